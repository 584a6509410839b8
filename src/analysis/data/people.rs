//! Participants of a study, from its BIDS tables. In: `participants.tsv` and `phenotype/*.tsv` of a data set. Out: the state of
//! each session, simulated participants, exclusions, and the scores of the questionnaires.

use super::{
    sickness_ratings::{self, SicknessRating},
    tsv::{MISSING, TsvFile},
};
use crate::analysis::error::AnalysisError;
use crate::{
    file::{SETTINGS_BYTES, read_text},
    record,
};
use std::path::Path;

/// States of a session in the words of `participants.tsv` (`study::Completion`), in the order of reports.
pub const STATES: [&str; 7] = [COMPLETE, "partial", "withdrawn", "declined", "not_eligible", "open", EXCLUDED];
const COMPLETE: &str = "complete";
const EXCLUDED: &str = "excluded";

/// A participant of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyParticipant {
    /// Participant's id, such as `sub-P03`.
    pub id: String,
    /// True for a simulated participant of a rehearsal.
    pub is_simulated: bool,
    /// State of the session, one of [`STATES`].
    pub state: String,
}

impl StudyParticipant {
    /// Checks whether the participant's drives are excluded from the analysis.
    pub fn is_excluded(&self) -> bool {
        self.state == EXCLUDED
    }
}

/// Values of one score of a questionnaire.
#[derive(Clone, Debug, PartialEq)]
pub struct ScoreColumn {
    /// Questionnaire of the plan, named after its file.
    pub questionnaire: String,
    /// Name of the score.
    pub name: String,
    /// Condition of the trials that the score is about; empty without a trial.
    pub condition: String,
    /// Values of the participants who answered and are not excluded, in the table's own unit.
    pub values: Vec<f64>,
}

/// A score of one participant.
#[derive(Clone, Debug, PartialEq)]
pub struct ParticipantScore {
    /// Participant's id, such as `sub-P03`.
    pub participant: String,
    /// Questionnaire of the plan, named after its file.
    pub questionnaire: String,
    /// Place (from 1) and condition of the trial that the score is about; empty without a trial.
    pub trial: [String; 2],
    /// Name of the score.
    pub name: String,
    /// Value as in the table; empty if an answer is missing.
    pub value: String,
}

/// Participants of a study and their scores; empty outside of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StudyParticipants {
    /// Participants in the order of the table.
    pub all: Vec<StudyParticipant>,
    /// Scores in the order of files and columns; scores about trials also in the order of conditions.
    pub scores: Vec<ScoreColumn>,
    /// Scores one by one, in the order of files, rows and columns.
    pub each: Vec<ParticipantScore>,
    /// Ratings of sickness while driving, in the order of participants and questions.
    pub ratings: Vec<SicknessRating>,
}

impl std::fmt::Display for StudyParticipants {
    /// Writes counts by state, with the ids of sessions that are not complete: `2 complete, 1 partial (sub-P03), 1 excluded
    /// (sub-P05)`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let of = |state: &str| {
            let ids: Vec<&str> =
                self.all.iter().filter(|person| person.state == state).map(|person| person.id.as_str()).collect();
            let names = if state == COMPLETE { String::new() } else { format!(" ({})", ids.join(", ")) };
            (!ids.is_empty()).then(|| format!("{} {}{names}", ids.len(), state.replace('_', " ")))
        };
        f.write_str(&STATES.into_iter().filter_map(of).collect::<Vec<_>>().join(", "))
    }
}

impl StudyParticipants {
    /// Reads the participants among `subjects` from a data set.
    ///
    /// # Errors
    /// A table does not have this program's format.
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
            people.ratings.extend(sickness_ratings::ratings(root, subject)?);
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
                // One table per place: together they are the questionnaire after every trial.
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

    /// Checks whether the participant's drives are excluded from the analysis.
    pub fn is_excluded(&self, id: &str) -> bool {
        self.all.iter().any(|person| person.id == id && person.is_excluded())
    }

    /// Checks whether any participant is simulated.
    pub fn is_rehearsal(&self) -> bool {
        self.all.iter().any(|person| person.is_simulated)
    }
}

/// Returns the conditions of a study: in the order of the table's sidecar, then those found only in the table.
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
