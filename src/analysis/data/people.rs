//! Participants of a study, from its BIDS tables and logs. In: `participants.tsv`, `phenotype/*.tsv` and the logs of the sessions. Out: the
//! state, order and end of each session, simulated participants, exclusions, scores of questionnaires, and answers about the person.

use super::{
    person_answers::PersonAnswers,
    session_ends::EndReasons,
    sickness_ratings::{self, SicknessRating},
    statements::MethodsStatements,
    tsv::{MISSING, TsvFile},
};
use crate::{analysis::error::AnalysisError, record};
use std::{collections::BTreeMap, path::Path};

/// States of a session in the words of `participants.tsv` (`study::Completion`), in the order of reports.
pub const STATES: [&str; 9] =
    [COMPLETE, "partial", "withdrawn", "ended_technically", "declined", "not_eligible", "open", EXCLUDED, DAMAGED];
/// State of a participant whose files cannot be read any more, in place of the state in the table.
pub const DAMAGED: &str = "damaged";
const COMPLETE: &str = "complete";
const EXCLUDED: &str = "excluded";

/// Participants whose files cannot be read any more, by their ids, each with the reason.
pub type DamagedParticipants = BTreeMap<String, String>;

/// A participant of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StudyParticipant {
    /// Participant's id, such as `sub-P03`.
    pub id: String,
    /// True for a simulated participant of a rehearsal.
    pub is_simulated: bool,
    /// State of the session, one of [`STATES`].
    pub state: String,
    /// Conditions in the participant's order, joined by commas; empty if the table has none.
    pub order: String,
    /// Reasons of an early end and of an exclusion.
    pub ends: EndReasons,
}

impl StudyParticipant {
    /// Reads the participants among `subjects` from `participants.tsv`; none without the table.
    fn of(root: &Path, subjects: &[String]) -> Result<Vec<Self>, AnalysisError> {
        let Some(table) = TsvFile::read(&root.join("participants.tsv"))? else { return Ok(Vec::new()) };
        let [id, kind, state] = [table.column("participant_id")?, table.column("kind")?, table.column("state")?];
        let order = table.column("order").ok();
        let rows = table.rows.iter().filter(|row| subjects.contains(&row[id]));
        let participant = |row: &Vec<String>| Self {
            id: row[id].clone(),
            is_simulated: row[kind] == "simulated",
            state: row[state].clone(),
            order: order.map_or(String::new(), |at| row[at].replace(MISSING, "")),
            ends: EndReasons::of(root, &row[id]),
        };
        Ok(rows.map(participant).collect())
    }

    /// Checks whether the participant's drives are left out of the analysis: excluded by the experimenter, or damaged.
    pub fn is_excluded(&self) -> bool {
        [EXCLUDED, DAMAGED].contains(&self.state.as_str())
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
    /// Descriptions of the questionnaires with their sources, by the name of the questionnaire.
    pub questionnaires: BTreeMap<String, String>,
    /// Scores one by one, in the order of files, rows and columns.
    pub each: Vec<ParticipantScore>,
    /// Ratings of sickness while driving, in the order of participants and questions.
    pub ratings: Vec<SicknessRating>,
    /// Answers that describe the participants who are not excluded.
    pub answers: PersonAnswers,
    /// Recruitment, ethics and apparatus in the words of the study's file.
    pub statements: MethodsStatements,
    /// Number of participants whose data were erased; 0 unless the whole data set is analysed.
    pub erased: usize,
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
    /// Reads the participants among `subjects` from a data set. The participants in `damaged` are left out, each for its reason.
    ///
    /// # Errors
    /// A table does not have this program's format.
    pub fn of(root: &Path, subjects: &[String], damaged: &DamagedParticipants) -> Result<Self, AnalysisError> {
        let statements = MethodsStatements::of(root);
        let mut people = Self { all: StudyParticipant::of(root, subjects)?, statements, ..Self::default() };
        for person in &mut people.all {
            if let Some(why) = damaged.get(&person.id) {
                person.state = DAMAGED.into();
                person.ends.excluded = Some(format!("damaged: {why}"));
            }
        }
        let is_counted = |subject: &&String| !people.is_excluded(subject) && !damaged.contains_key(*subject);
        let counted: Vec<&String> = subjects.iter().filter(is_counted).collect();
        for subject in &counted {
            people.ratings.extend(sickness_ratings::ratings(root, subject)?);
        }
        let mut files = record::entries(&root.join("phenotype"))?;
        files.retain(|path| path.extension().is_some_and(|ending| ending == "tsv"));
        files.sort();
        for path in files {
            let Some(table) = TsvFile::read(&path)? else { continue };
            people.answers.add(&table, &counted);
            if let Some(table) = PhenotypeTable::of(&table, &path, &counted)? {
                people.add(&table);
            }
        }
        Ok(people)
    }

    /// Adds the scores of a questionnaire. One table per place of a trial becomes one questionnaire after every trial.
    fn add(&mut self, table: &PhenotypeTable) {
        self.questionnaires.insert(table.questionnaire.clone(), table.about.clone());
        for (i, name) in table.scores.iter().enumerate() {
            for condition in &table.conditions {
                let of_it = table.rows.iter().filter(|row| row.trial[1] == *condition);
                let values = of_it.filter_map(|row| row.scores[i].parse::<f64>().ok());
                let this = [&table.questionnaire, name, condition];
                let is_this = |known: &&mut ScoreColumn| [&known.questionnaire, &known.name, &known.condition] == this;
                match self.scores.iter_mut().find(is_this) {
                    Some(known) => known.values.extend(values),
                    None => {
                        let [questionnaire, name, condition] = this.map(String::clone);
                        self.scores.push(ScoreColumn { questionnaire, name, condition, values: values.collect() });
                    }
                }
            }
        }
        for row in &table.rows {
            self.each.extend(table.scores.iter().zip(&row.scores).map(|(name, value)| ParticipantScore {
                participant: row.participant.clone(),
                questionnaire: table.questionnaire.clone(),
                trial: row.trial.clone(),
                name: name.clone(),
                value: value.clone(),
            }));
        }
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

/// Scores of one questionnaire (`phenotype/NAME.tsv`), of the participants who count.
struct PhenotypeTable {
    /// Questionnaire of the plan, without the place of the trial, and its description.
    questionnaire: String,
    about: String,
    /// Names of the scores.
    scores: Vec<String>,
    /// Conditions of the trials; one empty text for a questionnaire that is not about a trial.
    conditions: Vec<String>,
    rows: Vec<PhenotypeRow>,
}

/// Answers of one participant to a questionnaire.
struct PhenotypeRow {
    /// Participant's id, such as `sub-P03`.
    participant: String,
    /// Place (from 1) and condition of the trial; empty without a trial.
    trial: [String; 2],
    /// Scores in the order of the table; empty if an answer is missing.
    scores: Vec<String>,
}

impl PhenotypeTable {
    /// Returns the scores of the table in the file `path`; `None` if none of `participants` has a row in a table about a trial.
    fn of(table: &TsvFile, path: &Path, participants: &[&String]) -> Result<Option<Self>, AnalysisError> {
        let id = table.column("participant_id")?;
        let trial = table.column("place").ok().zip(table.column("condition").ok());
        let rows: Vec<&Vec<String>> = table.rows.iter().filter(|row| participants.contains(&&row[id])).collect();
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let (questionnaire, conditions) = match (trial, rows.first()) {
            (None, _) => (name.into_owned(), vec![String::new()]),
            (Some(_), None) => return Ok(None),
            // `trial_2_trust` is `trial_trust` after the second trial.
            (Some((place, condition)), Some(row)) => {
                (name.replacen(&format!("_{}_", row[place]), "_", 1), conditions(table, &rows, condition)?)
            }
        };
        let scores = table.names.iter().enumerate().filter_map(|(i, name)| Some((i, name.strip_prefix("score_")?)));
        let (columns, scores): (Vec<usize>, Vec<String>) = scores.map(|(i, name)| (i, name.to_owned())).unzip();
        let score = |cell: &String| if cell == MISSING { String::new() } else { cell.clone() };
        let row = |row: &&Vec<String>| PhenotypeRow {
            participant: row[id].clone(),
            trial: trial
                .map_or_else(Default::default, |(place, condition)| [row[place].clone(), row[condition].clone()]),
            scores: columns.iter().map(|at| score(&row[*at])).collect(),
        };
        let rows = rows.iter().map(row).collect();
        Ok(Some(Self { questionnaire, about: table.questionnaire()?, scores, conditions, rows }))
    }
}

/// Returns the conditions of a study: in the order of the table's sidecar, then those found only in the rows.
fn conditions(table: &TsvFile, rows: &[&Vec<String>], at: usize) -> Result<Vec<String>, AnalysisError> {
    let mut found = table.conditions()?;
    for row in rows {
        if row[at] != MISSING && !found.contains(&row[at]) {
            found.push(row[at].clone());
        }
    }
    Ok(found)
}
