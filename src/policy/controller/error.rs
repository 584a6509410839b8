//! Faults of a controller's file, as messages.

use super::{CONTROLLERS, ControllerKind};
use crate::toml_text::{TomlError, did_you_mean, unknown_key};

/// Format and version of a controller's file.
pub(super) const FORMAT: &str = "codrive controller 1";

/// Optional key of each kind: the share of advised vehicles that the parameters are for.
pub(super) const ADVISED_SHARE: &str = "advised_share";

/// Error for an unusable controller's file: all its mistakes, each with file, line, allowed values, and the line with a mark.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct ControllerFileError(#[from] TomlError);

/// Fault in a controller's file.
#[derive(Debug, thiserror::Error)]
pub(super) enum ControllerFault {
    /// The format is missing, or the file has another one.
    #[error("format is {}; allowed: \"{FORMAT}\"", found.as_deref().unwrap_or("missing"))]
    Format {
        /// Format in the file, if present.
        found: Option<String>,
    },
    /// The kind is missing or unknown.
    #[error("kind is {}{}; allowed: {}", found.as_deref().unwrap_or("missing"), near_kind(found.as_deref()), kinds())]
    Kind {
        /// Kind in the file, if present.
        found: Option<String>,
    },
    /// A key that this kind does not have.
    #[error("{}", unknown_key(key, &keys(*kind)))]
    UnknownKey {
        /// Unknown key in the file.
        key: String,
        /// Kind of controller that the file names.
        kind: ControllerKind,
    },
    /// A parameter is missing.
    #[error("key `{key}` is missing: {doc}\n  remedy: give it {allowed}")]
    Missing {
        /// Key of the parameter.
        key: &'static str,
        /// Description of the parameter.
        doc: &'static str,
        /// Allowed values in words.
        allowed: String,
    },
    /// A list has the wrong length, or a single value stands in place of a list.
    #[error("{key} is {found}; allowed: a list of {length} numbers, such as {example}")]
    List {
        /// Key of the parameter.
        key: &'static str,
        /// Value in the file.
        found: String,
        /// Required length of the list.
        length: usize,
        /// Example of an allowed list.
        example: String,
    },
    /// A parameter is not a number, or is outside its limits.
    #[error("{key} is {found}; allowed: {allowed}")]
    Value {
        /// Key of the parameter.
        key: &'static str,
        /// Value in the file.
        found: String,
        /// Allowed values in words.
        allowed: String,
    },
    /// Two parameters are out of order.
    #[error("{key} is {value}; allowed: {} {before_key}, which is {before}", if *is_above { "above" } else { "not above" })]
    Order {
        /// Key of the parameter.
        key: &'static str,
        /// Value of the parameter.
        value: f64,
        /// Key of the parameter before it.
        before_key: &'static str,
        /// Value of the parameter before it.
        before: f64,
        /// True if `value` must be above `before`; false if it must not be above it.
        is_above: bool,
    },
}

fn kinds() -> String {
    CONTROLLERS.map(ControllerKind::name).join(", ")
}

fn near_kind(found: Option<&str>) -> String {
    found.map_or(String::new(), |found| did_you_mean(found.trim_matches('"'), &CONTROLLERS.map(ControllerKind::name)))
}

/// Returns the keys that the file of such a controller may have.
pub(super) fn keys(kind: ControllerKind) -> Vec<&'static str> {
    let mut keys = vec!["format", "kind", ADVISED_SHARE];
    keys.extend(kind.parameters().iter().map(|parameter| parameter.table_key()));
    keys.dedup();
    keys
}
