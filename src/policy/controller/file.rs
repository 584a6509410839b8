//! The file of a controller: TOML with its kind and its parameters, each with the unit in its key. In: text. Out: a [`Controller`], or an
//! error with file, line, value and allowed values. A controller is also written as text that reads back to the same bits.

use super::{
    Controller, ControllerFileError, ControllerKind, EngagedController, Order, Parameter,
    error::{ADVISED_SHARE, ControllerFault, FORMAT, keys},
};
use crate::{
    policy::{Action, Observation, Policy},
    toml_text::{self, KeyPart, Mistakes},
};
use serde::Deserialize;
use std::fmt::Write;

/// Prefix of the format in all versions.
const FORMAT_NAME: &str = "codrive controller";

/// Returns true if a text is meant as a controller's file: its format says so, or it has a `kind`, which no trained policy's file has.
pub fn is_controller(text: &str) -> bool {
    #[derive(Deserialize)]
    struct Head {
        format: Option<toml::Value>,
        kind: Option<toml::Value>,
    }
    let Ok(head) = toml::from_str::<Head>(text) else { return false };
    let says_so = head.format.as_ref().and_then(toml::Value::as_str).is_some_and(|f| f.starts_with(FORMAT_NAME));
    says_so || head.kind.is_some()
}

/// Controller as its file states it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ControllerFile {
    pub controller: Controller,
    /// Share of advised vehicles that the parameters are for, 0 to 1; 0 is one vehicle.
    pub advised_share: f64,
}

impl From<Controller> for ControllerFile {
    /// Returns a controller for one advised vehicle.
    fn from(controller: Controller) -> Self {
        Self { controller, advised_share: 0.0 }
    }
}

/// Running controller of a file.
struct EngagedFile {
    controller: EngagedController,
    advised_share: f64,
}

impl Policy for EngagedFile {
    fn watch(&mut self, observation: &Observation) {
        self.controller.watch(observation);
    }

    fn act(&mut self, time_s: f64, observation: &Observation) -> Action {
        self.controller.act(time_s, observation)
    }

    fn advised_share(&self) -> f64 {
        self.advised_share
    }
}

impl ControllerFile {
    /// Returns a newly engaged policy with steps of `step_s` seconds.
    pub fn policy(&self, step_s: f64) -> Box<dyn Policy> {
        let controller = EngagedController::new(&self.controller, step_s);
        Box::new(EngagedFile { controller, advised_share: self.advised_share })
    }

    /// Parses a controller's file; messages refer to it as `name`.
    ///
    /// # Errors
    /// The text is not TOML, is another kind of file, has an unknown key or lacks a required one, or a number is outside its limits or
    /// out of order. The message has all mistakes.
    pub fn from_toml(text: &str, name: &str) -> Result<Self, ControllerFileError> {
        let (table, mut mistakes) = toml_text::read::<toml::Table>(text, name);
        let file = table.and_then(|table| Self::of_table(&table, &mut mistakes));
        Ok(toml_text::finished((file, mistakes))?)
    }

    /// Returns the file of a table and adds its mistakes.
    fn of_table(table: &toml::Table, mistakes: &mut Mistakes) -> Option<Self> {
        let mut add = |key: &str, others: &[&str], part: KeyPart, fault: ControllerFault| {
            mistakes.add_related(key, others, part, &fault.to_string());
        };
        let found = |key: &str| table.get(key).map(ToString::to_string);
        if table.get("format").and_then(toml::Value::as_str) != Some(FORMAT) {
            add("format", &[], KeyPart::Value, ControllerFault::Format { found: found("format") });
            // Another format has other keys.
            table.get("format").is_none().then_some(())?;
        }
        let kind = table.get("kind").and_then(toml::Value::as_str).and_then(ControllerKind::named);
        let Some(kind) = kind else {
            add("kind", &[], KeyPart::Value, ControllerFault::Kind { found: found("kind") });
            return None;
        };
        let (parameters, known) = (kind.parameters(), keys(kind));
        let unknown: Vec<&str> = table.keys().map(String::as_str).filter(|key| !known.contains(key)).collect();
        for key in &unknown {
            add(key, &[], KeyPart::Key, ControllerFault::UnknownKey { key: (*key).to_owned(), kind });
        }
        let mut numbers: Vec<Option<f64>> = Vec::with_capacity(parameters.len());
        for (i, parameter) in parameters.iter().enumerate() {
            let number = number(table, parameter, parameters);
            let before = i.checked_sub(1).and_then(|before| Some((parameters[before].key, numbers[before]?)));
            match (&number, before) {
                (Ok(value), Some((before_key, before))) if !parameter.follows(before, *value) => {
                    let is_above = parameter.order == Order::Above;
                    let fault =
                        ControllerFault::Order { key: parameter.key, value: *value, before_key, before, is_above };
                    add(parameter.key, &[], KeyPart::Value, fault);
                }
                _ => {}
            }
            numbers.push(
                number
                    .map_err(|fault| {
                        // A fault of a whole list is marked at the whole list.
                        let key = if matches!(fault, ControllerFault::Value { .. }) {
                            parameter.key
                        } else {
                            parameter.table_key()
                        };
                        // A key with a slip is not missing, too.
                        let slips =
                            unknown.iter().copied().filter(|slip| toml_text::nearest(slip, &known) == Some(key));
                        add(key, &slips.collect::<Vec<_>>(), KeyPart::Value, fault);
                    })
                    .ok(),
            );
        }
        let advised_share =
            advised_share(table).map_err(|fault| add(ADVISED_SHARE, &[], KeyPart::Value, fault)).ok()?;
        let numbers: Vec<f64> = numbers.into_iter().collect::<Option<_>>()?;
        Some(Self { controller: Controller::of(kind, &numbers), advised_share })
    }

    /// Returns the file's text below a comment with the lines of `head`. Numbers are as short as possible and still read back to the same
    /// bits.
    pub fn to_toml(&self, head: &str) -> String {
        let mut text: String = head.lines().map(|line| format!("# {line}\n")).collect();
        let kind = self.controller.kind();
        let _ = writeln!(text, "format = \"{FORMAT}\"\nkind = \"{}\"", kind.name());
        if self.advised_share > 0.0 {
            let doc = "Share of advised vehicles that the parameters are for";
            let _ = writeln!(text, "# {doc}\n{ADVISED_SHARE} = {:?}", self.advised_share);
        }
        let (parameters, numbers) = (kind.parameters(), self.controller.numbers());
        for group in parameters.chunk_by(|a, b| a.table_key() == b.table_key()) {
            let first = &group[0];
            let values: Vec<String> = parameters
                .iter()
                .zip(&numbers)
                .filter(|(parameter, _)| parameter.table_key() == first.table_key())
                .map(|(_, number)| format!("{number:?}"))
                .collect();
            let unit = if first.unit.is_empty() { String::new() } else { format!(", {}", first.unit) };
            let values = if first.entry().is_some() { format!("[{}]", values.join(", ")) } else { values.concat() };
            let _ = writeln!(text, "# {}{unit}\n{} = {values}", first.doc, first.table_key());
        }
        text
    }
}

/// Returns the share of advised vehicles in a table, 0 without one.
fn advised_share(table: &toml::Table) -> Result<f64, ControllerFault> {
    let Some(value) = table.get(ADVISED_SHARE) else { return Ok(0.0) };
    let share = value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
    share.filter(|share| (0.0..=1.0).contains(share)).ok_or_else(|| ControllerFault::Value {
        key: ADVISED_SHARE,
        found: value.to_string(),
        allowed: "0 (one vehicle) to 1 (all)".into(),
    })
}

/// Returns the number in a table for a parameter.
fn number(table: &toml::Table, parameter: &Parameter, all: &[Parameter]) -> Result<f64, ControllerFault> {
    let key = parameter.table_key();
    let allowed = parameter.allowed();
    let value = table.get(key).ok_or(ControllerFault::Missing { key, doc: parameter.doc, allowed: allowed.clone() })?;
    let value = match parameter.entry() {
        None => value,
        Some(entry) => {
            let same = || all.iter().filter(|other| other.table_key() == key);
            let list = value.as_array().filter(|list| list.len() == same().count());
            &list.ok_or_else(|| ControllerFault::List {
                key,
                found: value.to_string(),
                length: same().count(),
                example: format!(
                    "[{}]",
                    same().map(|other| format!("{:?}", other.search[0])).collect::<Vec<_>>().join(", ")
                ),
            })?[entry]
        }
    };
    let number = value.as_float().or_else(|| value.as_integer().map(|whole| whole as f64));
    number.filter(|number| parameter.allows(*number)).ok_or_else(|| ControllerFault::Value {
        key: parameter.key,
        found: value.to_string(),
        allowed,
    })
}
