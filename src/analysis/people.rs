//! Who took part in a study, as its BIDS tables tell. In: `participants.tsv` and `phenotype/*.tsv` of a data set. Out: how far
//! each session came, whether anybody drove at all, whose drives are left out, and the scores of the questionnaires.

use super::AnalysisError;
use crate::file::{SETTINGS_BYTES, read_text};
use crate::toml_text::did_you_mean;
use std::{
    fs,
    path::{Path, PathBuf},
};

/// How far a session came, in the words of `participants.tsv` (`study::Completion`), in the order in which they are reported.
pub const STATES: [&str; 5] = [COMPLETE, "partial", "withdrawn", "open", EXCLUDED];
const COMPLETE: &str = "complete";
const EXCLUDED: &str = "excluded";

/// A participant.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyParticipant {
    /// `sub-P03`.
    pub id: String,
    /// Nobody drove: one of a rehearsal.
    pub is_simulated: bool,
    /// How far the session came, in the table's word.
    pub state: String,
}

impl StudyParticipant {
    /// True if the drives are not to be analysed.
    pub fn is_excluded(&self) -> bool {
        self.state == EXCLUDED
    }
}

/// A score of a questionnaire.
#[derive(Clone, Debug, PartialEq)]
pub struct ScoreColumn {
    /// Questionnaire of the plan, as its file is called.
    pub questionnaire: String,
    /// The score's name.
    pub name: String,
    /// Those of the participants who answered and are not excluded, in the table's own unit.
    pub values: Vec<f64>,
}

/// Participants of a study and their scores; empty outside of one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StudyParticipants {
    /// In the table's order.
    pub all: Vec<StudyParticipant>,
    /// In the order of files and columns.
    pub scores: Vec<ScoreColumn>,
}

impl StudyParticipants {
    /// Those of a data set among `subjects`.
    ///
    /// # Errors
    /// A table is not as this program writes it.
    pub fn of(root: &Path, subjects: &[String]) -> Result<Self, AnalysisError> {
        let mut all = Vec::new();
        if let Some(table) = TsvFile::read(&root.join("participants.tsv"))? {
            let [id, kind, state] = [table.column("participant_id")?, table.column("kind")?, table.column("state")?];
            let rows = table.rows.iter().filter(|row| subjects.contains(&row[id]));
            all.extend(rows.map(|row| StudyParticipant {
                id: row[id].clone(),
                is_simulated: row[kind] == "simulated",
                state: row[state].clone(),
            }));
        }
        let mut people = Self { all, scores: Vec::new() };
        let entries = fs::read_dir(root.join("phenotype")).into_iter().flatten().flatten();
        let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
        files.retain(|path| path.extension().is_some_and(|ending| ending == "tsv"));
        files.sort();
        for path in files {
            let Some(table) = TsvFile::read(&path)? else { continue };
            let id = table.column("participant_id")?;
            let rows: Vec<&Vec<String>> =
                table.rows.iter().filter(|row| subjects.contains(&row[id]) && !people.is_excluded(&row[id])).collect();
            for (at, name) in table.names.iter().enumerate() {
                let Some(name) = name.strip_prefix("score_") else { continue };
                people.scores.push(ScoreColumn {
                    questionnaire: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
                    name: name.into(),
                    values: rows.iter().filter_map(|row| row[at].parse().ok()).collect(),
                });
            }
        }
        Ok(people)
    }

    /// True if this participant's drives are not to be analysed.
    pub fn is_excluded(&self, id: &str) -> bool {
        self.all.iter().any(|person| person.id == id && person.is_excluded())
    }

    /// True if nobody drove.
    pub fn is_rehearsal(&self) -> bool {
        self.all.iter().any(|person| person.is_simulated)
    }

    /// `2 complete, 1 partial (sub-P03), 1 excluded (sub-P05)`: who is not complete is named.
    pub fn words(&self) -> String {
        let of = |state: &str| {
            let ids: Vec<&str> =
                self.all.iter().filter(|person| person.state == state).map(|person| person.id.as_str()).collect();
            let names = if state == COMPLETE { String::new() } else { format!(" ({})", ids.join(", ")) };
            (!ids.is_empty()).then(|| format!("{} {state}{names}", ids.len()))
        };
        STATES.into_iter().filter_map(of).collect::<Vec<_>>().join(", ")
    }
}

/// A table as BIDS has it.
struct TsvFile {
    path: PathBuf,
    names: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl TsvFile {
    /// `None` where there is no such file.
    fn read(path: &Path) -> Result<Option<Self>, AnalysisError> {
        if !path.exists() {
            return Ok(None);
        }
        let text = read_text(path, SETTINGS_BYTES)
            .map_err(|why| AnalysisError::Input(format!("{}: cannot be read: {why}", path.display())))?;
        let mut lines = text.lines().map(|line| line.split('\t').map(str::to_owned).collect::<Vec<_>>());
        let names = lines.next().unwrap_or_default();
        let rows: Vec<Vec<String>> = lines.collect();
        if let Some(i) = rows.iter().position(|row| row.len() != names.len()) {
            return Err(AnalysisError::Input(format!(
                "{}: line {} has {} cells instead of {}",
                path.display(),
                i + 2,
                rows[i].len(),
                names.len()
            )));
        }
        Ok(Some(Self { path: path.into(), names, rows }))
    }

    fn column(&self, name: &str) -> Result<usize, AnalysisError> {
        let fault = || {
            AnalysisError::Input({
                let near = did_you_mean(name, &self.names);
                format!("{}: there is no column \"{name}\"{near}", self.path.display())
            })
        };
        self.names.iter().position(|n| n == name).ok_or_else(fault)
    }
}
