//! Settings as a list, read from the JSON Schema of their struct: doc, unit, limits, kind and default of each. The command line, the
//! checks of files and the panel are generated from this list.

use crate::toml_text::did_you_mean;
use serde_json::Value;
use std::{
    any::TypeId,
    collections::BTreeMap,
    sync::{Mutex, PoisonError},
};

/// One setting of a struct.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Key in the file; `idm.T` for a key in a table.
    pub path: String,
    /// Description of the setting, one sentence.
    pub doc: String,
    /// Unit symbol; empty if the setting has none.
    pub unit: String,
    /// Kind of value and its limits.
    pub kind: SettingKind,
    /// Value in the default of the struct.
    pub default: Value,
}

/// Kind of value of a setting.
#[derive(Clone, Debug, PartialEq)]
pub enum SettingKind {
    /// Switch, true or false.
    Switch,
    /// Integer within limits, both included.
    Whole {
        /// Smallest allowed value of the integer.
        min: u64,
        /// Largest allowed value of the integer.
        max: u64,
    },
    /// Number within limits, both included.
    Number {
        /// Smallest allowed value of the number.
        min: f64,
        /// Largest allowed value of the number.
        max: f64,
    },
    /// One of these words.
    Choice(Vec<String>),
    /// Text, checked by the code that uses it.
    Text,
}

impl Field {
    /// Returns the command-line flag without dashes: the key without its unit, with `-` for `_`.
    pub fn flag(&self) -> String {
        flag_of(&self.path)
    }

    /// Returns the table of the key, if any.
    pub fn table(&self) -> Option<&str> {
        self.path.split_once('.').map(|(table, _)| table)
    }

    /// Describes the allowed values.
    pub fn allowed(&self) -> String {
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        match &self.kind {
            SettingKind::Switch => "true or false".into(),
            SettingKind::Whole { min, max } => format!("a whole number from {min} to {max}{unit}"),
            SettingKind::Number { min, max } => format!("a number from {min} to {max}{unit}"),
            SettingKind::Choice(words) => format!("one of {}", words.join(", ")),
            SettingKind::Text => "a text".into(),
        }
    }

    /// Returns the value of the setting in a struct written as JSON.
    pub fn get<'a>(&self, settings: &'a Value) -> Option<&'a Value> {
        self.path.split('.').try_fold(settings, |value, key| value.get(key))
    }

    /// Sets the value in a struct written as JSON; creates missing tables.
    pub fn set(&self, settings: &mut Value, value: Value) {
        let mut place = settings;
        for key in self.path.split('.') {
            place = &mut place[key];
        }
        *place = value;
    }

    /// Returns `None` if `value` is allowed, otherwise the error message.
    pub fn fault(&self, value: &Value) -> Option<String> {
        let fits = match &self.kind {
            SettingKind::Switch => value.is_boolean(),
            SettingKind::Whole { min, max } => value.as_u64().is_some_and(|v| (*min..=*max).contains(&v)),
            // A NaN or an infinity becomes null in JSON and fails here too.
            SettingKind::Number { min, max } => value.as_f64().is_some_and(|v| (*min..=*max).contains(&v)),
            SettingKind::Choice(words) => value.as_str().is_some_and(|v| words.iter().any(|w| w == v)),
            SettingKind::Text => value.is_string(),
        };
        let shown = if value.is_null() { "not a finite number".into() } else { value.to_string() };
        let near = match (&self.kind, value.as_str()) {
            (SettingKind::Choice(words), Some(text)) => {
                did_you_mean(text, &words.iter().map(String::as_str).collect::<Vec<_>>())
            }
            _ => String::new(),
        };
        (!fits).then(|| format!("{} is {shown}{near}; allowed: {}", self.path, self.allowed()))
    }

    /// Returns the value that a file of changed settings gives this one. A text may be a number, as in a scenario file: `advised = 3`.
    ///
    /// # Errors
    /// The value is not allowed; the message says what is.
    pub fn written(&self, value: &Value) -> Result<Value, String> {
        let value = match (&self.kind, value) {
            (SettingKind::Text, Value::Number(number)) => Value::String(number.to_string()),
            (_, value) => value.clone(),
        };
        self.fault(&value).map_or(Ok(value), Err)
    }
}

fn flag_of(path: &str) -> String {
    let bare = ["_mph", "_mps", "_mps2", "_mmph", "_s", "_m", "_h", "_km", "_deg"]
        .iter()
        .find_map(|unit| path.strip_suffix(unit));
    bare.unwrap_or(path).replace('_', "-")
}

/// Returns all settings of a struct, in the order of its fields. The first call of a process makes the schema: that of a scenario takes some
/// milliseconds, and a study asks for it at each of its conditions.
pub fn fields_of<T: schemars::JsonSchema + serde::Serialize + Default + 'static>() -> Vec<Field> {
    static MADE: Mutex<BTreeMap<TypeId, Vec<Field>>> = Mutex::new(BTreeMap::new());
    let made = || MADE.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(fields) = made().get(&TypeId::of::<T>()) {
        return fields.clone();
    }
    let fields = fields_by_schema::<T>();
    made().insert(TypeId::of::<T>(), fields.clone());
    fields
}

fn fields_by_schema<T: schemars::JsonSchema + serde::Serialize + Default>() -> Vec<Field> {
    let schema = schemars::generate::SchemaSettings::draft2020_12()
        .with(|s| s.inline_subschemas = true)
        .into_generator()
        .into_root_schema_for::<T>();
    let default = serde_json::to_value(T::default()).unwrap_or_default();
    let mut list = Vec::new();
    collect(schema.as_value(), &default, "", &mut list);
    list
}

fn collect(schema: &Value, default: &Value, prefix: &str, list: &mut Vec<Field>) {
    // The order of the default's keys is the order of the fields, which serde_json keeps.
    let Some(keys) = default.as_object() else { return };
    for (key, default) in keys {
        let property = &schema["properties"][key];
        let path = format!("{prefix}{key}");
        if property["type"] == "object" {
            collect(property, default, &format!("{path}."), list);
            continue;
        }
        let text = |name: &str| property[name].as_str().unwrap_or_default().to_owned();
        list.push(Field {
            doc: text("description").replace('\n', " "),
            unit: text("unit"),
            kind: kind(property),
            default: default.clone(),
            path,
        });
    }
}

fn kind(property: &Value) -> SettingKind {
    let words = |list: &Value, key: Option<&str>| -> Vec<String> {
        let items = list.as_array().map(Vec::as_slice).unwrap_or_default();
        items.iter().filter_map(|item| key.map_or(item, |k| &item[k]).as_str().map(str::to_owned)).collect()
    };
    let limit = |name: &str, otherwise: f64| property[name].as_f64().unwrap_or(otherwise);
    match property["type"].as_str() {
        Some("boolean") => SettingKind::Switch,
        Some("integer") => SettingKind::Whole {
            min: limit("minimum", 0.0) as u64,
            max: property["maximum"].as_u64().unwrap_or(limit("maximum", f64::MAX) as u64),
        },
        Some("number") => SettingKind::Number { min: limit("minimum", f64::MIN), max: limit("maximum", f64::MAX) },
        _ if property["oneOf"].is_array() => SettingKind::Choice(words(&property["oneOf"], Some("const"))),
        _ if property["enum"].is_array() => SettingKind::Choice(words(&property["enum"], None)),
        _ => SettingKind::Text,
    }
}
