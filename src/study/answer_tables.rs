//! Tables of answers. In: questionnaires and the logs of sessions. Out: for `phenotype/`, one row per participant, with a table of its
//! own for each place of a questionnaire about trials; for `beh`, one row per answer with its time.

use super::{
    PlannedItem, Study,
    bids::{self, TsvColumn, TsvTable},
    questions::{AnswerChoice, ElementKind, InputType, QuestionElement, Questionnaire, number},
    session_log::{SessionLog, TimedAnswer, as_map},
};

/// Returns the answers and scores of one questionnaire, one row per participant.
pub(super) fn phenotype(questionnaire: &Questionnaire, item: &str, logs: &[SessionLog]) -> TsvTable {
    let mut table = TsvTable::new(vec![participant()]);
    table.columns.extend(answer_columns(questionnaire));
    for log in logs {
        let Some(cells) = answer_cells(questionnaire, item, log) else { continue };
        table.rows.push([vec![log.participant.subject()], cells].concat());
    }
    table
}

/// Returns the answers and scores of a questionnaire about the trial at the place of `like` in its segment, one row per participant. BIDS
/// allows each participant only once in a table.
pub(super) fn phenotype_of_trial(
    study: &Study,
    questionnaire: &Questionnaire,
    like: &PlannedItem,
    logs: &[SessionLog],
) -> TsvTable {
    let mut table = TsvTable::new(vec![participant(), place(), condition(study)]);
    table.columns.extend(answer_columns(questionnaire));
    let asked = |item: &PlannedItem| item.after.as_ref().map(|after| after.questionnaire.clone());
    let key = |item: &PlannedItem| (item.segment.clone(), item.run, asked(item));
    for log in logs {
        let plan = study.plan(log.index);
        let Some(planned) = plan.items.iter().find(|planned| key(planned) == key(like)) else { continue };
        let Some(cells) = answer_cells(questionnaire, &planned.name, log) else { continue };
        table.rows.push([vec![log.participant.subject()], trial_cells(planned), cells].concat());
    }
    table
}

fn participant() -> TsvColumn {
    TsvColumn::new("participant_id", "code of the participant", "")
}

/// Returns the column for the place of a trial.
pub(super) fn place() -> TsvColumn {
    TsvColumn::new("place", "position among the trials of the segment, from 1", "")
}

/// Returns the column for the condition of a trial.
pub(super) fn condition(study: &Study) -> TsvColumn {
    TsvColumn::new("condition", "condition of the trial: its levels joined by +", "")
        .with(study.conditions.iter().map(|c| (c.name.clone(), format!("condition {} of the study", c.name))))
}

fn trial_cells(planned: &PlannedItem) -> Vec<String> {
    vec![planned.run.map_or(String::new(), |run| run.to_string()), planned.condition.clone().unwrap_or_default()]
}

fn answer_columns(questionnaire: &Questionnaire) -> Vec<TsvColumn> {
    let elements = questionnaire.pages.iter().flat_map(|page| &page.elements);
    let mut columns: Vec<TsvColumn> = elements.flat_map(columns_of).collect();
    for score in &questionnaire.scores {
        columns.push(TsvColumn::new(&format!("score_{}", score.name), &score.to_string(), ""));
    }
    columns
}

/// Returns the cells of an item that was done; `None` for any other item.
fn answer_cells(questionnaire: &Questionnaire, item: &str, log: &SessionLog) -> Option<Vec<String>> {
    let answers = as_map(log.answers.get(item).filter(|_| log.done(item).is_some())?);
    let elements = questionnaire.pages.iter().flat_map(|page| &page.elements);
    let named = elements.flat_map(|element| element.answer_names().into_iter().map(move |name| (element, name)));
    let cell = |(element, name): (&QuestionElement, String)| match answers.get(&name) {
        None => String::new(),
        Some(answer) if element.input_type == InputType::Number => {
            number(answer).map_or_else(|| bids::value(answer), |number| bids::number(Some(number)))
        }
        Some(answer) => bids::value(answer),
    };
    let mut cells: Vec<String> = named.map(cell).collect();
    // Rounding removes floating-point residues such as 3e-15 from sums of decimal weights.
    let round = |figure: f64| (figure * 1e6).round() / 1e6;
    cells.extend(questionnaire.scores(&answers).into_iter().map(|(_, figure)| bids::number(figure.map(round))));
    Some(cells)
}

/// Returns the columns of a question: one, or one for each row of a matrix.
fn columns_of(element: &QuestionElement) -> Vec<TsvColumn> {
    let words = |list: &[AnswerChoice]| {
        list.iter().map(|choice| (bids::value(&choice.value), choice.text.clone())).collect::<Vec<_>>()
    };
    let mut title = [element.title.as_str(), element.description.as_str()].join(" ").trim().to_owned();
    let levels = match element.kind {
        ElementKind::Radiogroup => words(&element.choices),
        ElementKind::Matrix => words(&element.columns),
        ElementKind::Boolean => vec![("true".into(), "yes".into()), ("false".into(), "no".into())],
        // `Levels` must list all values of a cell. The two ends of a scale, or the single choices of a list, are not all values.
        ElementKind::Rating => {
            let end = |word: &str| if word.is_empty() { String::new() } else { format!(" ({word})") };
            let (low, high) = (end(&element.min_rate_description), end(&element.max_rate_description));
            title += &format!(" From {}{low} to {}{high}", element.rate_min, element.rate_max);
            Vec::new()
        }
        ElementKind::Checkbox => {
            let list: Vec<String> =
                words(&element.choices).into_iter().map(|(w, text)| format!("{w}: {text}")).collect();
            title += &format!(" Any of these, joined by semicolons: {}", list.join("; "));
            Vec::new()
        }
        ElementKind::Text if element.input_type == InputType::Number => {
            title += &format!(" A number from {} to {}", element.min, element.max);
            Vec::new()
        }
        _ => Vec::new(),
    };
    let mut names = element.answer_names().into_iter();
    if element.kind == ElementKind::Matrix {
        return names
            .zip(&element.rows)
            .map(|(name, row)| TsvColumn::new(&name, &format!("{title} {}", row.text), "").with(levels.clone()))
            .collect();
    }
    names.next().map(|name| TsvColumn::new(&name, &title, "").with(levels)).into_iter().collect()
}

/// Returns the table of answers with their response times; for a questionnaire about a trial also its place and condition.
pub(super) fn timed(study: &Study, planned: &PlannedItem, answers: &[TimedAnswer]) -> TsvTable {
    let mut table = TsvTable::new(vec![
        TsvColumn::new("question", "name of the question", ""),
        TsvColumn::new("answer", "answer; several answers are joined by semicolons", ""),
        TsvColumn::new("response_time", "time from the display of the page to this answer", "s"),
    ]);
    let about_trial = planned.after.is_some() && planned.run.is_some();
    if about_trial {
        table.columns.extend([place(), condition(study)]);
    }
    let row = |a: &TimedAnswer| {
        let mut row = vec![a.question.clone(), bids::value(&a.answer), bids::number(Some(a.time_s))];
        row.extend(if about_trial { trial_cells(planned) } else { Vec::new() });
        row
    };
    table.rows = answers.iter().map(row).collect();
    table
}
