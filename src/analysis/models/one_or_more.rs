//! Value of a key that takes one or a list. In: TOML or JSON. Out: the values as a slice.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One value, or a list of values; one value means a list of one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected one value or a list of them")]
pub enum OneOrMore<T> {
    /// Single value, written without brackets.
    One(T),
    /// List of values, in brackets.
    More(Vec<T>),
}

impl<T> OneOrMore<T> {
    /// Returns the values in their order.
    pub fn all(&self) -> &[T] {
        match self {
            Self::One(one) => std::slice::from_ref(one),
            Self::More(all) => all,
        }
    }
}
