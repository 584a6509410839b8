//! Tables of participants. In: the participants of a study. Out: `scores.csv` (a row per score of a participant) and `fms.csv`
//! (a row per rating of sickness while driving), with their columns.

use super::key::KEY;
use crate::analysis::{
    columns::{ColumnTexts, TableColumns, columns, line},
    data::{SicknessRating, StudyParticipants, people::ParticipantScore},
};

const SCORES: [ColumnTexts; 6] = [
    KEY[0],
    ("questionnaire", "Questionnaire", "", "questionnaire of the plan, by the name of its file in the data set"),
    ("place", "Place", "", "place of the trial that the questionnaire is about, from 1; empty if it is about no trial"),
    ("condition", "Condition", "", "condition of that trial; empty if the questionnaire is about no trial"),
    ("score", "Score", "", "name of the score in its questionnaire"),
    ("value", "Value", "", "score in its own unit, by the rule of the questionnaire; empty if an answer is missing"),
];

const FMS: [ColumnTexts; 8] = [
    KEY[0],
    ("segment", "Segment", "", "segment of the study"),
    KEY[2],
    KEY[3],
    ("recording", "Recording", "", "folder of the recording; a repeated drive has several"),
    ("time_s", "Time", "s", "time from the start of the drive to the question"),
    (
        "value",
        "Sickness while driving",
        "",
        "rating on the fast motion sickness scale, 0 (no sickness at all) to 20 (frank sickness); empty without an \
         answer",
    ),
    ("answer_s", "Time to answer", "s", "time from the question to the answer; empty without an answer"),
];

/// Returns the columns of `scores.csv`.
pub(crate) fn scores_columns() -> TableColumns {
    TableColumns { file: "scores.csv", row: "a score of a participant", columns: columns(&SCORES) }
}

/// Returns `scores.csv`: a row per score of a participant, and per trial for a questionnaire after every trial.
pub fn scores(people: &StudyParticipants) -> String {
    let row = |score: &ParticipantScore| {
        let ParticipantScore { participant, questionnaire, trial: [place, condition], name, value } = score;
        line([participant, questionnaire, place, condition, name, value].map(Clone::clone))
    };
    scores_columns().head() + &people.each.iter().map(row).collect::<String>()
}

/// Returns the columns of `fms.csv`.
pub(crate) fn sickness_columns() -> TableColumns {
    TableColumns { file: "fms.csv", row: "a question about sickness while driving", columns: columns(&FMS) }
}

/// Returns `fms.csv`: a row per question.
pub fn sickness(people: &StudyParticipants) -> String {
    let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    let row = |rating: &SicknessRating| {
        let own = [number(Some(rating.time_s)), number(rating.value), number(rating.answer_s)];
        line([rating.participant.clone()].into_iter().chain(rating.drive.clone()).chain(own))
    };
    sickness_columns().head() + &people.ratings.iter().map(row).collect::<String>()
}
