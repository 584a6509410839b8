//! Expected durations of pages and questionnaires. In: texts and questions. Out: seconds, for the printed plan and the experimenter's
//! clock only; drives and analysis do not use them.
//!
//! Reading speed is 238 words per minute (Brysbaert 2019, silent reading of English). Each answer takes 4 s, with one answer per matrix
//! row. The 4 s are this project's assumption, not a measurement; a data set has the true times (`response_time`).

use super::questions::{AnswerChoice, QuestionElement, Questionnaire};

const WORDS_PER_MIN: f64 = 238.0;
const ANSWER_S: f64 = 4.0;
/// Time to notice a new page and to continue, s.
const PAGE_S: f64 = 3.0;

/// Returns the expected reading time of a page, s; 0 for a page without text.
pub(super) fn page_s(text: &str) -> f64 {
    if text.trim().is_empty() { 0.0 } else { PAGE_S + reading_s(text) }
}

fn reading_s(text: &str) -> f64 {
    // A number sign or a bullet is not a word.
    let words = text.split_whitespace().filter(|word| word.contains(char::is_alphanumeric)).count();
    words as f64 * 60.0 / WORDS_PER_MIN
}

/// Returns the expected duration of a questionnaire, s, counting all pages, even those that some participants do not see.
pub(super) fn questionnaire_s(questionnaire: &Questionnaire) -> f64 {
    let page = |title: &str, elements: &[QuestionElement]| {
        PAGE_S + reading_s(title) + elements.iter().map(element_s).sum::<f64>()
    };
    questionnaire.pages.iter().map(|p| page(&p.title, &p.elements)).sum()
}

fn element_s(element: &QuestionElement) -> f64 {
    let texts = |list: &[AnswerChoice]| list.iter().map(|choice| reading_s(&choice.text)).sum::<f64>();
    let own = [&element.title, &element.description, &element.min_rate_description, &element.max_rate_description];
    own.into_iter().chain([&element.html]).map(|text| reading_s(text)).sum::<f64>()
        + texts(&element.choices)
        + texts(&element.columns)
        + texts(&element.rows)
        + ANSWER_S * element.answer_names().len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_are_read_at_238_words_a_minute_and_answers_take_4_s() {
        // 238 words take a minute, plus 3 s for the page.
        assert!((page_s(&"word ".repeat(238)) - 63.0).abs() < 1e-9);
        assert_eq!((page_s(" \n"), page_s("# * -")), (0.0, 3.0), "marks are no words");
        let text = r#"{ "title": "t", "pages": [{ "name": "p", "title": "How are you?", "elements": [
            { "type": "matrix", "name": "m", "title": "Now", "columns": ["None", "Some"], "rows": ["Ache", "Sweat"] },
            { "type": "rating", "name": "r", "title": "Hard?", "rateMin": 0, "rateMax": 10, "minRateDescription": "not at all" }] }] }"#;
        let questionnaire = Questionnaire::parse(text, "t.json").unwrap();
        // Words counted by hand: 3 on the page, 1 + 2 + 2 of the matrix, 1 + 3 of the rating; three answers; one page.
        let expected = 12.0 * 60.0 / 238.0 + 3.0 * 4.0 + 3.0;
        assert!((questionnaire_s(&questionnaire) - expected).abs() < 1e-9, "{}", questionnaire_s(&questionnaire));
    }
}
