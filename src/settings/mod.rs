//! Structs of settings that define a file, flags and widgets at once. In: such a struct with its doc comments and limits, TOML text, and
//! `(field, value)` pairs of flags or widgets. Out: the list of its [`Field`]s; the checked struct, or an error with file, line, column,
//! value and the allowed values.

mod field;
mod flat;

pub use field::{Field, SettingKind, fields_of};
pub(crate) use flat::flat_settings;

use crate::{
    file::{SETTINGS_BYTES, read_text},
    toml_text::{self, KeyPart},
};
use schemars::JsonSchema;
use serde::{Serialize, de::DeserializeOwned};
use serde_json::Value;
use std::path::Path;

/// An error in settings written by a person; the message is complete.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct SettingsError {
    /// Setting at fault; empty if the error is in the text as a whole.
    pub key: String,
    /// File, line and column if there is a file; the value; the allowed values.
    pub message: String,
}

/// Struct of settings that is read from a file and changed by flags.
pub trait Settings: Serialize + DeserializeOwned + JsonSchema + Default {
    /// Checks relations between settings, each of which is already within its limits, and lists. The error holds the path of the key at fault,
    /// and a message.
    ///
    /// # Errors
    /// The settings contradict each other.
    fn check(&self) -> Result<(), (String, String)>;
}

/// Reads settings from a file; missing settings keep their default.
///
/// # Errors
/// The file cannot be read, is not TOML, names an unknown key, or a value has the wrong type or is out of range.
pub fn from_file<T: Settings>(path: &Path) -> Result<T, SettingsError> {
    let text = read_text(path, SETTINGS_BYTES).map_err(|e| SettingsError {
        key: String::new(),
        message: format!("{}: cannot be read: {e}{}", path.display(), toml_text::did_you_mean_file(path)),
    })?;
    from_toml(&text, &path.display().to_string())
}

/// Parses settings from TOML text; `name` is the file's name in messages.
///
/// # Errors
/// As [`from_file`].
pub fn from_toml<T: Settings>(text: &str, name: &str) -> Result<T, SettingsError> {
    let whole = |e: toml_text::TomlError| SettingsError { key: String::new(), message: e.to_string() };
    let settings: T = toml_text::parse(&toml_text::without_format(text, name).map_err(whole)?, name).map_err(whole)?;
    let json = serde_json::to_value(&settings).unwrap_or_default();
    let wrong = |key: &str, fault: String| SettingsError {
        key: key.to_owned(),
        message: toml_text::at(text, name, key, KeyPart::Value, &fault),
    };
    for field in fields_of::<T>() {
        if let Some(fault) = field.get(&json).and_then(|value| field.fault(value)) {
            return Err(wrong(&field.path, fault));
        }
    }
    settings.check().map_err(|(key, fault)| wrong(&key, fault))?;
    Ok(settings)
}

/// Returns `base` with some settings replaced, checked as a whole.
///
/// # Errors
/// A value has the wrong type or is out of range, or the settings contradict each other.
pub fn changed<T: Settings>(base: &T, changes: &[(Field, Value)]) -> Result<T, SettingsError> {
    let mut json = serde_json::to_value(base).unwrap_or_default();
    for (field, value) in changes {
        if let Some(message) = field.fault(value) {
            return Err(SettingsError { key: field.path.clone(), message });
        }
        field.set(&mut json, value.clone());
    }
    let settings: T = serde_json::from_value(json).map_err(|error| {
        let alone = |field: &Field, value: &Value| {
            let mut json = serde_json::to_value(base).unwrap_or_default();
            field.set(&mut json, value.clone());
            serde_json::from_value::<T>(json).is_err()
        };
        let at_fault = changes.iter().find(|(field, value)| alone(field, value));
        let key = at_fault.map_or_else(String::new, |(field, _)| field.path.clone());
        SettingsError { key, message: error.to_string() }
    })?;
    settings.check().map_err(|(key, message)| SettingsError { key, message })?;
    Ok(settings)
}
