//! Who took part in a study, as its BIDS tables tell. In: `participants.tsv` and `phenotype/*.tsv` of a data set. Out: how far
//! each session came, whether anybody drove at all, whose drives are left out, and the scores of the questionnaires.

use super::{
    AnalysisError,
    sickness::{self, SicknessRating},
};
use crate::{
    file::{SETTINGS_BYTES, read_text},
    record,
    toml_text::did_you_mean,
};
use std::path::{Path, PathBuf};

/// How far a session came, in the words of `participants.tsv` (`study::Completion`), in the order in which they are reported.
pub const STATES: [&str; 7] = [COMPLETE, "partial", "withdrawn", "declined", "not_eligible", "open", EXCLUDED];
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
    /// Condition of the trials that it is about; empty where it is about no trial.
    pub condition: String,
    /// Those of the participants who answered and are not excluded, in the table's own unit.
    pub values: Vec<f64>,
}

/// A score of one participant.
#[derive(Clone, Debug, PartialEq)]
pub struct ParticipantScore {
    /// `sub-P03`.
    pub participant: String,
    /// Questionnaire of the plan, as its file is called.
    pub questionnaire: String,
    /// Place of the trial that it is about, from 1, and its condition; empty where it is about no trial.
    pub trial: [String; 2],
    /// The score's name.
    pub name: String,
    /// Its value as the table has it; empty where an answer is missing.
    pub value: String,
}

/// Participants of a study and their scores; empty outside of one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StudyParticipants {
    /// In the table's order.
    pub all: Vec<StudyParticipant>,
    /// In the order of files and columns, of one about trials in the order of conditions.
    pub scores: Vec<ScoreColumn>,
    /// The same one by one, in the order of files, rows and columns.
    pub each: Vec<ParticipantScore>,
    /// Ratings of sickness while driving, in the order of participants and questions.
    pub ratings: Vec<SicknessRating>,
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
        let mut people = Self { all, ..Self::default() };
        let counted: Vec<&String> = subjects.iter().filter(|subject| !people.is_excluded(subject)).collect();
        for subject in counted {
            people.ratings.extend(sickness::ratings(root, subject)?);
        }
        let mut files = record::entries(&root.join("phenotype"))?;
        files.retain(|path| path.extension().is_some_and(|ending| ending == "tsv"));
        files.sort();
        for path in files {
            let Some(table) = TsvFile::read(&path)? else { continue };
            let id = table.column("participant_id")?;
            let rows: Vec<&Vec<String>> =
                table.rows.iter().filter(|row| subjects.contains(&row[id]) && !people.is_excluded(&row[id])).collect();
            let mut questionnaire = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let trial = table.column("place").ok().zip(table.column("condition").ok());
            let conditions = trial.map_or_else(|| vec![String::new()], |(_, at)| conditions(&path, &rows, at));
            if trial.is_some() && rows.is_empty() {
                continue;
            }
            if let (Some((at, _)), Some(row)) = (trial, rows.first()) {
                // One table a place: together they are the questionnaire after every trial.
                questionnaire = questionnaire.replacen(&format!("_{}_", row[at]), "_", 1);
            }
            let scores = || table.names.iter().enumerate().filter_map(|(i, n)| Some((i, n.strip_prefix("score_")?)));
            for (at, name) in scores() {
                for condition in &conditions {
                    let of_it = rows.iter().filter(|row| trial.is_none_or(|(_, in_row)| row[in_row] == *condition));
                    let values: Vec<f64> = of_it.filter_map(|row| row[at].parse().ok()).collect();
                    let same = |known: &&mut ScoreColumn| {
                        trial.is_some()
                            && (&*known.questionnaire, &*known.name, &known.condition)
                                == (&*questionnaire, name, condition)
                    };
                    if let Some(known) = people.scores.iter_mut().find(same) {
                        known.values.extend(values);
                        continue;
                    }
                    let (questionnaire, condition) = (questionnaire.clone(), condition.clone());
                    people.scores.push(ScoreColumn { questionnaire, name: name.into(), condition, values });
                }
            }
            for row in rows {
                people.each.extend(scores().map(|(at, name)| ParticipantScore {
                    participant: row[id].clone(),
                    questionnaire: questionnaire.clone(),
                    trial: trial.map_or_else(Default::default, |(place, condition)| {
                        [&row[place], &row[condition]].map(Clone::clone)
                    }),
                    name: name.into(),
                    value: if row[at] == MISSING { String::new() } else { row[at].clone() },
                }));
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
            (!ids.is_empty()).then(|| format!("{} {}{names}", ids.len(), state.replace('_', " ")))
        };
        STATES.into_iter().filter_map(of).collect::<Vec<_>>().join(", ")
    }
}

/// What BIDS writes for what is not there.
pub(super) const MISSING: &str = "n/a";

/// Conditions of a study, in its order where the sidecar of a table tells it, and those that are in the table alone.
fn conditions(table: &Path, rows: &[&Vec<String>], at: usize) -> Vec<String> {
    let sidecar = read_text(&table.with_extension("json"), SETTINGS_BYTES).unwrap_or_default();
    let sidecar: serde_json::Value = serde_json::from_str(&sidecar).unwrap_or_default();
    let levels = sidecar["condition"]["Levels"].as_object();
    let mut found: Vec<String> = levels.map(|levels| levels.keys().cloned().collect()).unwrap_or_default();
    for row in rows {
        if row[at] != MISSING && !found.contains(&row[at]) {
            found.push(row[at].clone());
        }
    }
    found
}

/// A table as BIDS has it.
pub(super) struct TsvFile {
    path: PathBuf,
    names: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl TsvFile {
    /// `None` where there is no such file.
    pub fn read(path: &Path) -> Result<Option<Self>, AnalysisError> {
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

    pub fn column(&self, name: &str) -> Result<usize, AnalysisError> {
        let fault = || {
            AnalysisError::Input({
                let near = did_you_mean(name, &self.names);
                format!("{}: there is no column \"{name}\"{near}", self.path.display())
            })
        };
        self.names.iter().position(|n| n == name).ok_or_else(fault)
    }
}
