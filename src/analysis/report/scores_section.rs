//! Report section of questionnaires. In: the participants of a study. Out: the scores over all participants who answered.

use super::{
    page::{ReportPage, TableCells, short},
    words::{cells, estimate, interval},
};
use crate::analysis::data::{StudyParticipants, people::ScoreColumn};

/// Adds the scores of the questionnaires, over all participants who answered.
pub(super) fn scores(page: &mut ReportPage, people: &StudyParticipants) {
    let row = |score: &ScoreColumn| {
        let [low, high] = [f64::min, f64::max].map(|f| score.values.iter().copied().reduce(f).unwrap_or_default());
        let condition = if score.condition.is_empty() { String::new() } else { format!(", {}", score.condition) };
        let name = score.questionnaire.replace('_', " ") + &condition;
        let n = score.values.len();
        Some(vec![name, score.name.clone(), n.to_string(), estimate(&score.values)?, short(low), short(high)])
    };
    let rows: Vec<TableCells> = people.scores.iter().filter_map(row).collect();
    if rows.is_empty() {
        return;
    }
    page.put("<h2>Questionnaires</h2>");
    page.paragraph("lead", &format!("{} gives the scores of the questionnaires.", page.table_links(1)));
    page.table(
        &format!(
            "Scores of the questionnaires: mean [{}], lowest and highest. Questionnaires after every trial are listed \
             by condition. N is the number of participants.",
            interval()
        ),
        &cells(["Questionnaire", "Score", "N", "Mean", "Lowest", "Highest"]),
        &rows,
        &[1],
    );
}
