//! Answers that describe a sample: age, gender, driving licence, mileage, motion sickness. In: tables of questionnaires
//! (`phenotype/*.tsv`). Out: [`PersonAnswers`]: what was asked, and each participant's answer. A question counts by its name, in whichever
//! questionnaire it is asked.

use super::tsv::{MISSING, TsvFile};
use std::collections::BTreeMap;

/// Names of the questions about the person: age in years, gender, years with a driving licence, kilometres driven a year, and how often
/// the person is sick in vehicles.
pub const QUESTIONS: [&str; 5] = ["age", "gender", "years-licensed", "km-per-year", "sickness"];

/// Answers to the questions about the person; a question that the study did not ask has no entry.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PersonAnswers(BTreeMap<&'static str, BTreeMap<String, String>>);

impl PersonAnswers {
    /// Adds the answers of these participants from the table of a questionnaire; tables about a trial have none.
    pub(super) fn add(&mut self, table: &TsvFile, participants: &[&String]) {
        let Some(id) = table.column("participant_id").ok().filter(|_| table.column("place").is_err()) else { return };
        for question in QUESTIONS {
            let Ok(at) = table.column(question) else { continue };
            let of = self.0.entry(question).or_default();
            for row in table.rows.iter().filter(|row| participants.contains(&&row[id]) && row[at] != MISSING) {
                of.insert(row[id].clone(), row[at].clone());
            }
        }
    }

    /// Returns the answers of these participants to a question, empty where there is none; `None` if the study did not ask.
    pub fn of<'a>(&'a self, question: &str, participants: &[&str]) -> Option<Vec<&'a str>> {
        let answers = self.0.get(question)?;
        Some(participants.iter().map(|id| answers.get(*id).map_or("", String::as_str)).collect())
    }
}

/// Returns the number in an answer, which may have commas between thousands and a unit behind it: `28`, `12,000 km`.
pub fn number_in(answer: &str) -> Option<f64> {
    let unit = |sign: char| sign.is_alphabetic() || sign.is_whitespace();
    let digits = answer.trim().trim_end_matches(unit);
    let mut groups = digits.split(',');
    let first = groups.next()?;
    let is_grouped = groups.clone().all(|group| group.len() == 3 && group.bytes().all(|sign| sign.is_ascii_digit()));
    let is_number = first.bytes().all(|sign| sign.is_ascii_digit() || sign == b'.');
    let number = digits.replace(',', "").parse::<f64>().ok()?;
    (is_grouped && is_number).then_some(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_in_answers_have_commas_and_units_and_words_are_none() {
        for (answer, number) in [
            ("28", Some(28.0)),
            (" 28 years", Some(28.0)),
            ("12,000 km", Some(12_000.0)),
            ("2.5", Some(2.5)),
            ("0", Some(0.0)),
            ("", None),
            ("about 20", None),
            ("20-30", None),
            ("28,5", None),
            ("-3", None),
            ("rehearsed", None),
            ("inf", None),
        ] {
            assert_eq!(number_in(answer), number, "{answer}");
        }
    }

    #[test]
    fn answers_count_by_the_name_of_the_question() {
        let folder = tempfile::tempdir().unwrap();
        let table = |text: &str| {
            let path = folder.path().join("about.tsv");
            std::fs::write(&path, text).unwrap();
            TsvFile::read(&path).unwrap().unwrap()
        };
        let ids = ["sub-P1".to_owned(), "sub-P2".to_owned()];
        let counted: Vec<&String> = ids.iter().collect();
        let mut answers = PersonAnswers::default();
        answers.add(&table("participant_id\tage\tother\nsub-P1\t20\tx\nsub-P2\tn/a\tx\nsub-P3\t30\tx\n"), &counted);
        answers.add(&table("participant_id\tplace\tgender\nsub-P1\t1\twoman\n"), &counted);
        assert_eq!(answers.of("age", &["sub-P1", "sub-P2"]), Some(vec!["20", ""]));
        assert_eq!(answers.of("gender", &["sub-P1"]), None, "a table about a trial is not about the person");
    }
}
