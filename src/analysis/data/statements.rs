//! Statements of a study's leaders that no recording can show. In: the table `[methods]` of a study's file, or of the copy in a data set.
//! Out: [`MethodsStatements`], which preregistration and methods print.

use crate::analysis::text::on_one_line;
use crate::file::{SETTINGS_BYTES, read_text};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// File name of the study's file at the start of its data set.
pub const BEGUN: &str = "study.toml";
/// File name of the study's file at the last session, present if its plan of the analysis has changed.
pub const CHANGED: &str = "study-changed.toml";

/// Statements in whole sentences, for preregistration and methods.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MethodsStatements {
    /// Recruitment of the participants: where, how, with what reward and what criteria.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recruitment: Option<String>,
    /// Approval by an ethics committee with its number, and consent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ethics: Option<String>,
    /// Apparatus besides what codrive records: seat, room, screen's model, wheel's model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub apparatus: Option<String>,
}

impl MethodsStatements {
    /// Reads the statements of a data set; none if it has no study file or the file cannot be read.
    pub fn of(root: &Path) -> Self {
        #[derive(Default, Deserialize)]
        struct StudyPart {
            #[serde(default)]
            methods: MethodsStatements,
        }
        let changed = root.join(CHANGED);
        let file = if changed.exists() { changed } else { root.join(BEGUN) };
        let text = read_text(&file, SETTINGS_BYTES).ok();
        text.and_then(|text| toml::from_str::<StudyPart>(&text).ok()).unwrap_or_default().methods
    }

    /// Checks whether nothing is stated.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// Returns all statements with their keys and titles, each on one line; `None` where nothing is stated.
    pub fn all(&self) -> [(&'static str, &'static str, Option<String>); 3] {
        let stated = |text: &Option<String>| {
            let text = text.as_deref().map(|text| on_one_line(text).split_whitespace().collect::<Vec<_>>().join(" "));
            text.filter(|text| !text.is_empty())
        };
        [
            ("recruitment", "Recruitment", stated(&self.recruitment)),
            ("ethics", "Ethics", stated(&self.ethics)),
            ("apparatus", "Apparatus", stated(&self.apparatus)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn statements_are_those_of_the_last_session_each_on_one_line() {
        let folder = tempfile::tempdir().unwrap();
        assert_eq!(MethodsStatements::of(folder.path()), MethodsStatements::default());
        let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write(BEGUN, "title = \"T\"\n[methods]\nethics = \"\"\"Approved.\n  No. 7.\"\"\"\nrecruitment = \" \"\n");
        let [recruitment, ethics, apparatus] = MethodsStatements::of(folder.path()).all().map(|(.., text)| text);
        assert_eq!((recruitment, ethics.as_deref(), apparatus), (None, Some("Approved. No. 7."), None));
        write(CHANGED, "[methods]\napparatus = \"A seat.\"\n");
        assert_eq!(MethodsStatements::of(folder.path()).all()[2].2.as_deref(), Some("A seat."));
        assert!(MethodsStatements::of(folder.path()).ethics.is_none());
    }
}
