//! What can be wrong with the file of a controller, by kind, and in words with file, line and a mark under the place.

use super::{CONTROLLERS, ControllerKind, file::FORMAT};
use crate::toml_text::{TomlError, did_you_mean, unknown_key};

/// Why a controller's file cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct ControllerFileError {
    /// What is wrong.
    pub fault: ControllerFault,
    /// All of it for people: file, line, what is wrong, what is allowed, and the line with a mark.
    pub message: String,
}

/// What is wrong with a controller's file.
#[derive(Debug, thiserror::Error)]
pub enum ControllerFault {
    /// The text is no TOML.
    #[error(transparent)]
    Toml(TomlError),
    /// It does not say what file it is, or says that it is another.
    #[error("format is {}; allowed: \"{FORMAT}\"", found.as_deref().unwrap_or("missing"))]
    Format {
        /// What it says.
        found: Option<String>,
    },
    /// It names no controller.
    #[error("kind is {}{}; allowed: {}", found.as_deref().unwrap_or("missing"), near_kind(found.as_deref()), kinds())]
    Kind {
        /// What it names.
        found: Option<String>,
    },
    /// A key that this kind does not have.
    #[error("{}", unknown_key(key, &keys(*kind)))]
    UnknownKey {
        /// The key.
        key: String,
        /// The kind of controller.
        kind: ControllerKind,
    },
    /// A parameter is not set.
    #[error("key `{key}` is missing: {doc}\n  remedy: give it {allowed}")]
    Missing {
        /// The parameter.
        key: &'static str,
        /// What it is.
        doc: &'static str,
        /// What is allowed.
        allowed: String,
    },
    /// A parameter is a list of another length, or none where one belongs.
    #[error("{key} is {found}; allowed: a list of {length} numbers, such as {example}")]
    List {
        /// The parameter.
        key: &'static str,
        /// What it is.
        found: String,
        /// Numbers in the list.
        length: usize,
        /// A list that is allowed.
        example: String,
    },
    /// A parameter is no number, or one outside of its limits.
    #[error("{key} is {found}; allowed: {allowed}")]
    Value {
        /// The parameter.
        key: &'static str,
        /// What it is.
        found: String,
        /// What is allowed.
        allowed: String,
    },
    /// Two parameters are not in their order.
    #[error("{key} is {value}; allowed: {} {before_key}, which is {before}", if *is_above { "above" } else { "not above" })]
    Order {
        /// The parameter.
        key: &'static str,
        /// What it is.
        value: f64,
        /// The one before it.
        before_key: &'static str,
        /// What that is.
        before: f64,
        /// It must be above that one; otherwise it must not.
        is_above: bool,
    },
}

fn kinds() -> String {
    CONTROLLERS.map(ControllerKind::name).join(", ")
}

fn near_kind(found: Option<&str>) -> String {
    found.map_or(String::new(), |found| did_you_mean(found.trim_matches('"'), &CONTROLLERS.map(ControllerKind::name)))
}

/// Keys that the file of such a controller may have.
fn keys(kind: ControllerKind) -> Vec<&'static str> {
    let mut keys = vec!["format", "kind"];
    keys.extend(kind.parameters().iter().map(|parameter| parameter.table_key()));
    keys.dedup();
    keys
}
