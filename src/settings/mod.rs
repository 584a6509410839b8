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
pub trait Settings: Serialize + DeserializeOwned + JsonSchema + Default + Clone + 'static {
    /// Returns the faults of relations between settings, each of which is already within its limits, and of lists.
    fn faults(&self) -> Vec<SettingFault>;

    /// Returns the key and the message of the first of the [`Settings::faults`].
    ///
    /// # Errors
    /// The settings contradict each other.
    fn check(&self) -> Result<(), (String, String)> {
        let first = self.faults().into_iter().next();
        first.map_or(Ok(()), |SettingFault { key, message, .. }| Err((key, message)))
    }
}

/// Fault of a setting beside others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SettingFault {
    /// Path of the setting at fault.
    pub key: String,
    /// Paths of the settings because of which it is at fault.
    pub others: &'static [&'static str],
    /// Value and allowed values.
    pub message: String,
}

impl SettingFault {
    /// Makes the fault of a setting for which others matter.
    pub fn new(key: impl Into<String>, others: &'static [&'static str], message: impl Into<String>) -> Self {
        Self { key: key.into(), others, message: message.into() }
    }
}

/// Reads settings from a file; missing settings keep their default.
///
/// # Errors
/// The file cannot be read, is not TOML, names an unknown key, or a value has the wrong type or is out of range. The message has all
/// mistakes.
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
    let (settings, mut mistakes) = toml_text::read_formatted::<T>(text, name);
    if let Some(settings) = &settings {
        let mut json = serde_json::to_value(settings).unwrap_or_default();
        for field in fields_of::<T>() {
            if let Some(fault) = field.get(&json).and_then(|value| field.fault(value)) {
                mistakes.add(&field.path, KeyPart::Value, &fault);
                // Relations are between values within their limits.
                field.set(&mut json, field.default.clone());
            }
        }
        let within: Result<T, _> =
            if mistakes.is_empty() { Ok(settings.clone()) } else { serde_json::from_value(json) };
        for SettingFault { key, others, message } in within.iter().flat_map(T::faults) {
            mistakes.add_related(&key, others, KeyPart::Value, &message);
        }
    }
    toml_text::finished((settings, mistakes))
        .map_err(|mistakes| SettingsError { key: String::new(), message: mistakes.to_string() })
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
