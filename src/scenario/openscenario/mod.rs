//! Import of OpenSCENARIO XML 1.x. In: a file `.xosc` with its catalogs and its OpenDRIVE road. Out: a [`Scenario`](super::Scenario) with road users and
//! events, or the first fault with its line; and all that the file has and codrive does not. Seconds, metres, m/s.
//!
//! `document`, `parameters` and `reader` know the language: lines, values, references to catalogs. `entities`, `positions`, `actions`, `conditions` and
//! `storyboard` read its elements. `scene` finds their places on the ego's path, and `casting`, `triggers`, `deeds`, `script` and `imported` write the scenario.

mod actions;
mod casting;
mod conditions;
mod deeds;
mod document;
mod entities;
mod expression;
mod fault;
#[cfg(test)]
mod fault_tests;
mod imported;
mod parameters;
mod positions;
mod reader;
#[cfg(test)]
mod repeated_tests;
mod scene;
mod script;
mod storyboard;
#[cfg(test)]
mod tests;
mod triggers;

pub use fault::{OpenScenarioError, Unsupported};
pub use imported::ImportedScenario;

use crate::map::OpenDriveRoads;
use entities::Entity;
use parameters::{Node, Scope};
use reader::Reader;
use std::path::{Path, PathBuf};
use storyboard::Storyboard;

/// Entity whose place the participant takes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum ParticipantChoice {
    /// The entity named `Ego`, in any case of letters; without it, no entity.
    #[default]
    Ego,
    /// Entity of this name.
    Named(String),
    /// No entity: all of them are road users.
    None,
}

/// OpenSCENARIO file that has been read.
#[derive(Debug)]
pub struct OpenScenario {
    file: PathBuf,
    road_file: PathBuf,
    roads: OpenDriveRoads,
    entities: Vec<Entity>,
    storyboard: Storyboard,
    reader: Reader,
}

impl OpenScenario {
    /// Reads a file with its catalogs and its road.
    ///
    /// # Errors
    /// A file is missing or no XML, a part is missing, or a value is malformed.
    pub fn read(file: &Path) -> Result<Self, OpenScenarioError> {
        let root = Node::new(&document::read(file)?, &std::rc::Rc::<Scope>::default())?;
        let mut reader = Reader::default();
        if root.find("Catalog")?.is_some() {
            return Err(root.fault("this is a catalog\n  remedy: name the scenario that refers to it"));
        }
        let known = ["CatalogLocations", "RoadNetwork", "Entities", "Storyboard"];
        reader.expect(&root, &[], &known)?;
        if let Some(locations) = root.find("CatalogLocations")? {
            reader.locate_catalogs(&locations)?;
        }
        let network = root.child("RoadNetwork")?;
        reader.expect(&network, &[], &["LogicFile"])?;
        let logic = network.child("LogicFile")?;
        let road_file = file.parent().unwrap_or(Path::new("")).join(logic.text("filepath")?);
        let roads = OpenDriveRoads::read(&road_file).map_err(|error| logic.fault(error))?;
        if roads.roads().is_empty() {
            let message = format!("{} has no road; allowed: a file of OpenDRIVE, .xodr", road_file.display());
            return Err(logic.fault(message));
        }
        let entities = reader.entities(&root.child("Entities")?)?;
        let storyboard = reader.storyboard(&root.child("Storyboard")?)?;
        Ok(Self { file: file.to_path_buf(), road_file, roads, entities, storyboard, reader })
    }

    /// Returns the OpenDRIVE file of the scenario.
    pub fn road_file(&self) -> &Path {
        &self.road_file
    }

    /// Returns what the file has and a drive does not, as far as it is known without the network.
    pub fn unsupported(&self) -> &[Unsupported] {
        &self.reader.problems.unsupported
    }
}
