//! The code that names a participant in files. In: text typed by an experimenter. Out: a [`ParticipantCode`] that cannot lead out of the
//! data folder and that every operating system and BIDS accept as a name; or a message with the allowed codes.

use super::SessionError;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A participant's code: 1 to 16 ASCII letters and digits. Never a name.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct ParticipantCode(String);

/// Maximum length of a code.
const MOST: usize = 16;
/// Names that Windows reserves for devices.
const DEVICES: [&str; 4] = ["con", "prn", "aux", "nul"];
/// Words that BIDS and this program use in the place of a code.
const WORDS: [&str; 4] = ["emptyroom", "all", "none", "na"];

impl ParticipantCode {
    /// Checks a code.
    ///
    /// # Errors
    /// The code is empty, too long, has other characters, or is a reserved word.
    pub fn new(text: &str) -> Result<Self, SessionError> {
        let refused = |why: String| {
            Err(SessionError::Refused(format!(
                "the participant code {text:?} cannot be used: {why}; allowed: 1 to {MOST} letters and digits, for example P03"
            )))
        };
        if text.is_empty() {
            return refused("it is empty".into());
        }
        if let Some(other) = text.chars().find(|c| !c.is_ascii_alphanumeric()) {
            let other = if other == ' ' { "a space".into() } else { format!("{other:?}") };
            return refused(format!("it contains {other}"));
        }
        if text.len() > MOST {
            return refused(format!("it has {} characters", text.len()));
        }
        let small = text.to_ascii_lowercase();
        let numbered = |device: &str| {
            small.strip_prefix(device).is_some_and(|rest| rest.len() == 1 && rest.bytes().all(|b| b.is_ascii_digit()))
        };
        if DEVICES.contains(&small.as_str()) || numbered("com") || numbered("lpt") {
            return refused("Windows keeps this name for a device".into());
        }
        if WORDS.contains(&small.as_str()) {
            return refused("this word is reserved".into());
        }
        Ok(Self(text.into()))
    }

    /// Returns the BIDS name of the participant: `sub-P03`.
    pub fn subject(&self) -> String {
        format!("sub-{}", self.0)
    }

    /// Returns the code without `sub-`.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl fmt::Display for ParticipantCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl TryFrom<String> for ParticipantCode {
    type Error = SessionError;

    fn try_from(text: String) -> Result<Self, SessionError> {
        Self::new(&text)
    }
}

impl From<ParticipantCode> for String {
    fn from(code: ParticipantCode) -> Self {
        code.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_code_is_letters_and_digits_and_nothing_else() {
        for good in ["P03", "1", "abcdefgh12345678", "COM", "com12", "nuls"] {
            assert_eq!(ParticipantCode::new(good).unwrap().subject(), format!("sub-{good}"));
        }
        for (bad, why) in [
            ("", "it is empty"),
            ("..", "it contains '.'"),
            ("../P03", "it contains '.'"),
            ("a/b", "it contains '/'"),
            ("a\\b", "it contains '\\\\'"),
            ("P\0", "it contains '\\0'"),
            ("P 3", "it contains a space"),
            ("P-3", "it contains '-'"),
            ("Pé", "it contains 'é'"),
            ("P\n", "it contains '\\n'"),
            ("abcdefgh123456789", "it has 17 characters"),
            ("nul", "a device"),
            ("CON", "a device"),
            ("Com1", "a device"),
            ("lpt9", "a device"),
            ("EmptyRoom", "reserved"),
        ] {
            let message = ParticipantCode::new(bad).unwrap_err().to_string();
            assert!(message.contains(why) && message.contains("1 to 16 letters and digits"), "{bad:?}: {message}");
            let json = serde_json::to_string(bad).unwrap();
            assert!(serde_json::from_str::<ParticipantCode>(&json).is_err(), "{bad:?} in a file");
        }
    }
}
