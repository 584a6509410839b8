//! Description of the sample, as papers give it: number, gender, age, driving licence, mileage, motion sickness. In: the answers of the
//! participants who are analysed. Out: a sentence for the page and the methods, which also names what the study did not ask.

use crate::analysis::{
    data::{
        StudyParticipants,
        person_answers::{QUESTIONS, number_in},
    },
    statistics::deviation,
    text::{joined_with_and, people as participants},
};
use crate::plot::minus;

/// Words for answers to the question on gender: one person, several.
const GENDERS: [(&str, [&str; 2]); 5] = [
    ("woman", ["woman", "women"]),
    ("man", ["man", "men"]),
    ("non-binary", ["non-binary", "non-binary"]),
    ("own", ["in own words", "in own words"]),
    ("not-said", ["no answer", "no answer"]),
];
/// Answers to the question on motion sickness, in the order of the text.
const OFTEN: [&str; 4] = ["never", "rarely", "sometimes", "often"];

/// Returns the sentences on the participants with these ids; empty outside of a study.
pub(super) fn sentences(people: &StudyParticipants, ids: &[&str]) -> String {
    if people.all.is_empty() || ids.is_empty() {
        return String::new();
    }
    let of = |question: &str| people.answers.of(question, ids);
    let gender = of("gender").map_or(String::new(), |answers| format!(" ({})", genders(&answers)));
    let mut facts: Vec<String> = Vec::new();
    facts.extend(of("age").map(|answers| format!("age {}", numbers(&answers, "years", 1))));
    facts.extend(of("years-licensed").map(|answers| format!("driving licence for {}", numbers(&answers, "years", 1))));
    facts.extend(of("km-per-year").map(|answers| format!("distance driven in a year {}", numbers(&answers, "km", 0))));
    facts.extend(of("sickness").map(|answers| format!("sick in vehicles: {}", counts(&answers))));
    let facts = if facts.is_empty() { String::new() } else { format!(", {}", facts.join("; ")) };
    let mut text = format!("N = {}{gender}{facts}.", participants(ids.len()));
    if people.is_rehearsal() {
        text += " The answers of simulated participants are drawn at random.";
    }
    let titles = ["age", "gender", "years with a driving licence", "distance driven in a year", "motion sickness"];
    let missing = QUESTIONS.iter().zip(titles).filter(|(question, _)| of(question).is_none());
    let missing: Vec<String> = missing.map(|(_, title)| title.to_owned()).collect();
    if !missing.is_empty() {
        text += &format!(" The study did not ask for {}.", joined_with_and(&missing));
    }
    text
}

/// Counts answers by their words, those of `order` first.
fn counted<'a>(answers: &[&'a str], order: &[&'a str]) -> Vec<(&'a str, usize)> {
    let mut found: Vec<(&str, usize)> = order.iter().map(|word| (*word, 0)).collect();
    for answer in answers {
        match found.iter_mut().find(|(word, _)| word == answer) {
            Some((_, n)) => *n += 1,
            None => found.push((answer, 1)),
        }
    }
    found.retain(|(_, n)| *n > 0);
    found
}

fn genders(answers: &[&str]) -> String {
    let order = GENDERS.map(|gender| gender.0);
    let mut words: Vec<(String, usize)> = Vec::new();
    for (answer, n) in counted(answers, &order) {
        let word = GENDERS.iter().find(|gender| gender.0 == answer).map_or(answer, |of| of.1[usize::from(n > 1)]);
        let word = if word.is_empty() { "no answer" } else { word };
        match words.iter_mut().find(|known| known.0 == word) {
            Some(known) => known.1 += n,
            None => words.push((word.to_owned(), n)),
        }
    }
    words.iter().map(|(word, n)| format!("{n} {word}")).collect::<Vec<_>>().join(", ")
}

fn counts(answers: &[&str]) -> String {
    let word = |(answer, n): (&str, usize)| format!("{n} {}", if answer.is_empty() { "no answer" } else { answer });
    counted(answers, &OFTEN).into_iter().map(word).collect::<Vec<_>>().join(", ")
}

/// Returns mean, standard deviation (N-1) and range, and the number of answers without a number.
fn numbers(answers: &[&str], unit: &str, decimals: usize) -> String {
    let found: Vec<f64> = answers.iter().filter_map(|answer| number_in(answer)).collect();
    let without = answers.len() - found.len();
    if found.is_empty() {
        return format!("unknown ({without} without a number)");
    }
    let text = |value: f64, decimals: usize| minus(&grouped(&format!("{value:.decimals$}")));
    let mean = found.iter().sum::<f64>() / found.len() as f64;
    let sd = deviation(&found).map_or(String::new(), |sd| format!(", SD = {}", text(sd, decimals)));
    let [low, high] = [f64::min, f64::max].map(|f| found.iter().copied().reduce(f).unwrap_or_default());
    let [low, high] = [low, high].map(|end| text(end, if end.fract() == 0.0 { 0 } else { decimals }));
    let without = if without > 0 { format!(" ({without} without a number)") } else { String::new() };
    format!("M = {} {unit}{sd}, range {low} to {high}{without}", text(mean, decimals))
}

/// Puts a comma before each group of three digits of a number of five or more.
fn grouped(number: &str) -> String {
    let (whole, rest) = number.split_at(number.find('.').unwrap_or(number.len()));
    if whole.len() < 5 {
        return number.to_owned();
    }
    let first = (whole.len() - 1) % 3 + 1;
    let groups: Vec<&str> =
        std::iter::once(&whole[..first]).chain((first..whole.len()).step_by(3).map(|at| &whole[at..at + 3])).collect();
    groups.join(",") + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::data::StudyParticipant;
    use std::{fs, path::Path};

    /// Writes a data set of four participants with one questionnaire on the person and one on health.
    fn data_set(root: &Path) -> StudyParticipants {
        let ids = ["sub-P1", "sub-P2", "sub-P3", "sub-P4"];
        fs::create_dir_all(root.join("phenotype")).unwrap();
        let people: String = ids.iter().map(|id| format!("{id}\tperson\tcomplete\n")).collect();
        fs::write(root.join("participants.tsv"), format!("participant_id\tkind\tstate\n{people}")).unwrap();
        let about = "participant_id\tage\tgender\tyears-licensed\tkm-per-year\nsub-P1\t20\twoman\t2\t12,000\nsub-P2\t30\twoman\t10\t\
                     8000 km\nsub-P3\tn/a\tnot-said\t1.5\ta lot\nsub-P4\t40\tn/a\t20\t10000\n";
        fs::write(root.join("phenotype/about.tsv"), about).unwrap();
        let health = "participant_id\tsickness\nsub-P1\trarely\nsub-P2\tnever\nsub-P3\trarely\nsub-P4\toften\n";
        fs::write(root.join("phenotype/health.tsv"), health).unwrap();
        StudyParticipants::of(root, &ids.map(str::to_owned), &std::collections::BTreeMap::new()).unwrap()
    }

    /// Ages 20, 30 and 40: mean 30, SD 10. Licences 2, 10, 1.5 and 20 years: mean 8.375; squares of departures sum to 225.69, so
    /// that SD = sqrt(225.69 / 3) = 8.67. Distances 12,000, 8,000 and 10,000 km: mean 10,000, SD 2000.
    #[test]
    fn the_sample_is_described_as_computed_by_hand() {
        let root = tempfile::tempdir().unwrap();
        let people = data_set(root.path());
        assert_eq!(
            sentences(&people, &["sub-P1", "sub-P2", "sub-P3", "sub-P4"]),
            "N = 4 participants (2 women, 2 no answer), age M = 30.0 years, SD = 10.0, range 20 to 40 (1 without a number); driving \
             licence for M = 8.4 years, SD = 8.7, range 1.5 to 20; distance driven in a year M = 10,000 km, SD = 2000, range 8000 to \
             12,000 (1 without a number); sick in vehicles: 1 never, 2 rarely, 1 often."
        );
        // Only those who are analysed count.
        let one = sentences(&people, &["sub-P2"]);
        assert!(one.starts_with("N = 1 participant (1 woman), age M = 30.0 years, range 30 to 30;"), "{one}");
    }

    #[test]
    fn what_was_not_asked_is_said() {
        let all = vec![StudyParticipant { id: "sub-P1".into(), ..StudyParticipant::default() }];
        let people = StudyParticipants { all, ..StudyParticipants::default() };
        assert_eq!(
            sentences(&people, &["sub-P1"]),
            "N = 1 participant. The study did not ask for age, gender, years with a driving licence, distance driven in a year and motion \
             sickness."
        );
        assert_eq!(sentences(&StudyParticipants::default(), &["sub-P1"]), "", "a drive of no study");
    }
}
