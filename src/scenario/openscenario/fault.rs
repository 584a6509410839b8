//! Faults of an OpenSCENARIO file, and what of it a drive does not have. In: places of elements and messages. Out: [`OpenScenarioError`], which ends
//! the import, and [`Unsupported`], of which all are listed.

use std::{fmt, path::PathBuf};

/// Fault because of which a scenario cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct OpenScenarioError {
    pub file: PathBuf,
    /// Line, counted from 1; 0 for the file as a whole.
    pub line: u32,
    /// Value, allowed values and remedy.
    pub message: String,
}

impl fmt::Display for OpenScenarioError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.line {
            0 => write!(f, "{}: {}", self.file.display(), self.message),
            line => write!(f, "{}:{line}: {}", self.file.display(), self.message),
        }
    }
}

/// Part of a file that a drive does not have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unsupported {
    pub file: PathBuf,
    /// Line, counted from 1.
    pub line: u32,
    /// Name of the element.
    pub element: String,
    /// Consequence for the scene.
    pub meaning: String,
}

impl fmt::Display for Unsupported {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{}:{}: <{}>: {}", self.file.display(), self.line, self.element, self.meaning)
    }
}

/// Lists that grow while a scenario is read.
#[derive(Clone, Debug, Default)]
pub(super) struct Problems {
    pub unsupported: Vec<Unsupported>,
    /// Facts that the user should know but that take nothing from the scene.
    pub notes: Vec<String>,
}

impl Problems {
    /// Adds a fact once.
    pub fn note(&mut self, text: impl Into<String>) {
        let text = text.into();
        if !self.notes.contains(&text) {
            self.notes.push(text);
        }
    }

    /// Adds a part of the file once.
    pub fn add(&mut self, part: Unsupported) {
        if !self.unsupported.contains(&part) {
            self.unsupported.push(part);
        }
    }
}

/// Returns the consequence of leaving out an element of this name.
pub(super) fn meaning_of(element: &str) -> &'static str {
    match element {
        "AppearanceAction" | "LightStateAction" | "AnimationAction" => "lamps and postures stay as codrive draws them",
        "VisibilityAction" => "the entity stays visible",
        "EnvironmentAction" => "weather and daylight stay those of the scenario's settings",
        "TrafficAction" | "TrafficSwarmAction" | "TrafficSourceAction" | "TrafficSinkAction" | "TrafficStopAction" => {
            "no further traffic comes"
        }
        "AcquirePositionAction" => "the entity goes on along its lane",
        "LongitudinalDistanceAction" | "SpeedProfileAction" => "the entity keeps its speed",
        "LateralDistanceAction" => "the entity keeps its lane",
        "EntityAction" | "AddEntityAction" | "DeleteEntityAction" => "the entity is there during the whole drive",
        "ParameterAction" | "VariableAction" | "SetMonitorAction" => "the value stays as it is declared",
        "TrafficSignalControllerAction" | "TrafficSignalController" => "signals follow the programs of the network",
        "TrailerAction" | "Trailer" => "the vehicle is drawn without a trailer",
        "MiscObject" => "the object is not there",
        "ObjectController" | "Controller" => "codrive moves the entity",
        "FallingEdge" => "the condition never comes true",
        name if name.ends_with("Condition") => "the condition never comes true",
        name if name.ends_with("Position") => "codrive does not know the place",
        _ => "it has no effect",
    }
}
