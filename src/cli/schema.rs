//! `codrive schema`: the JSON Schemas of the files that people write, for editors. In: the name of a kind of file. Out: its schema, as
//! committed in `assets/schemas`, to which the first line of each shipped file refers.

use super::{CliError, out};
use crate::{
    data_folders,
    map::{MapFile, circuit::Circuit},
    scenario::{RoadUser, Scenario, ScriptedEvent, scripted_event},
    study::{Questionnaire, StudyFile},
    sweep::PlanFile,
    toml_text::{FORMAT, did_you_mean},
    traffic::{Demand, TrafficPopulation},
    train::TrainConfig,
};
use clap::{Arg, ArgMatches, Command};
use schemars::{JsonSchema, Schema, SchemaGenerator, generate::SchemaSettings};
use serde_json::{Map, Value, json};

/// Folder of the committed schemas, below the project's root.
pub const FOLDER: &str = "assets/schemas";

/// Kind of file with a schema.
#[derive(Clone, Copy, Debug)]
pub struct FileKind {
    /// Name, which begins the name of the schema's file.
    pub name: &'static str,
    /// Heading of the schema in an editor, with the command that reads such a file.
    pub title: &'static str,
    make: fn(SchemaGenerator) -> Schema,
}

/// Kinds of files in alphabetical order.
pub const KINDS: &[FileKind] = &[
    FileKind { name: "circuit", title: "Circuit: codrive map circuit FILE", make: of::<Circuit> },
    FileKind { name: "events", title: "Events and road users: a part of a scenario", make: events },
    #[cfg(feature = "desktop")]
    FileKind {
        name: "lab",
        title: "Laboratory devices: codrive drive --lab FILE",
        make: of::<crate::live_drive::lab::LabSettings>,
    },
    FileKind { name: "map", title: "Map: map.toml of a folder of maps", make: of::<MapFile> },
    FileKind { name: "population", title: "Population of traffic drivers: --traffic-drivers FILE", make: population },
    FileKind { name: "questionnaire", title: "Questionnaire: a subset of SurveyJS", make: of::<Questionnaire> },
    FileKind { name: "scenario", title: "Scenario: codrive run --scenario FILE", make: scenario },
    FileKind { name: "study", title: "Study: codrive study check FILE", make: study },
    FileKind { name: "sweep", title: "Plan of a sweep: codrive sweep FILE", make: of::<PlanFile> },
    FileKind { name: "train", title: "Configuration of a training: codrive train --config FILE", make: training },
    #[cfg(feature = "desktop")]
    FileKind {
        name: "wheel",
        title: "Profile of a steering wheel: codrive drive --wheel FILE",
        make: of::<crate::input::WheelProfile>,
    },
];

impl FileKind {
    /// Returns the text of the schema's file. Draft 7 is the newest that editors of TOML know in full.
    pub fn text(&self) -> String {
        let generator = SchemaSettings::draft07().into_generator();
        let mut schema = (self.make)(generator).to_value();
        schema["title"] = self.title.into();
        format!("{schema:#}\n")
    }

    /// Returns the path of the committed schema below the project's root.
    pub fn path(&self) -> String {
        format!("{FOLDER}/{}.schema.json", self.name)
    }
}

fn of<T: JsonSchema>(generator: SchemaGenerator) -> Schema {
    generator.into_root_schema_for::<T>()
}

/// Returns a schema with further properties in the object at a path of its keys.
fn with(schema: Schema, place: &str, properties: impl IntoIterator<Item = (&'static str, Value)>) -> Schema {
    let mut value = schema.to_value();
    if let Some(Value::Object(known)) = value.pointer_mut(&format!("{place}/properties")) {
        known.extend(properties.into_iter().map(|(name, property)| (name.to_owned(), property)));
    }
    Schema::try_from(value).unwrap_or_default()
}

/// Returns the property `format` of files that may name their format.
fn format() -> (&'static str, Value) {
    (
        "format",
        json!({ "description": "Version of the file's format; 1 if missing.", "type": "integer", "const": FORMAT }),
    )
}

/// Returns the schema of a list with its description.
fn list<T: JsonSchema>(generator: &mut SchemaGenerator, about: &str) -> Value {
    let list = generator.subschema_for::<Vec<T>>().to_value();
    let about = Map::from_iter([("description".to_owned(), Value::from(about))]);
    Value::Object(
        list.as_object().into_iter().flatten().map(|(key, value)| (key.clone(), value.clone())).chain(about).collect(),
    )
}

/// Returns the lists of a scenario, which are no settings of the command line.
fn lists(generator: &mut SchemaGenerator) -> Vec<(&'static str, Value)> {
    vec![
        ("road_user", list::<RoadUser>(generator, "Road users at their places at the start, which events move.")),
        (scripted_event::KEY, list::<ScriptedEvent>(generator, "Events: triggers, and what then happens on the road.")),
    ]
}

fn scenario(mut generator: SchemaGenerator) -> Schema {
    let demand = generator.subschema_for::<Demand>().to_value();
    let lists = lists(&mut generator);
    with(of::<Scenario>(generator), "", lists.into_iter().chain([("demand", demand), format()]))
}

fn events(mut generator: SchemaGenerator) -> Schema {
    let lists = lists(&mut generator);
    let definitions = of::<ScriptedEvent>(generator).to_value()["definitions"].clone();
    let properties: Map<String, Value> = lists.into_iter().map(|(name, list)| (name.to_owned(), list)).collect();
    let schema = json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "type": "object",
        "additionalProperties": false,
        "properties": properties,
        "definitions": definitions,
    });
    Schema::try_from(schema).unwrap_or_default()
}

fn study(mut generator: SchemaGenerator) -> Schema {
    let events = list::<ScriptedEvent>(&mut generator, "Events, instead of the list of the base.");
    let schema = with(of::<StudyFile>(generator), "", [format()]);
    with(schema, "/definitions/Scenario", [(scripted_event::KEY, events)])
}

fn training(generator: SchemaGenerator) -> Schema {
    with(of::<TrainConfig>(generator), "", [format()])
}

fn population(generator: SchemaGenerator) -> Schema {
    with(of::<TrafficPopulation>(generator), "", [format()])
}

pub(super) fn command() -> Command {
    Command::new("schema")
        .about("Print the JSON Schema of a kind of file, for editors; without a name, list the kinds")
        .after_help(
            "Each schema is also a file of the folder assets/schemas; the first line of each shipped file names its own.\n\n\
             Example: codrive schema study > study.schema.json",
        )
        .arg(Arg::new("name").value_name("NAME").help("Kind of file, such as scenario"))
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let Some(name) = matches.get_one::<String>("name") else {
        let list = KINDS.iter().map(|kind| format!("{:14} {}", kind.name, kind.title));
        let folder = data_folders::root().join(FOLDER);
        return out::line(format_args!("{}\n{}", list.collect::<Vec<_>>().join("\n"), folder.display()));
    };
    let names: Vec<&str> = KINDS.iter().map(|kind| kind.name).collect();
    match KINDS.iter().find(|kind| kind.name == name) {
        Some(kind) => out::line(format_args!("{}", kind.text().trim_end())),
        None => {
            let near = did_you_mean(name, &names);
            Err(CliError::Input(format!("there is no schema \"{name}\"{near}; allowed: {}", names.join(", "))))
        }
    }
}
