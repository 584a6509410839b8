//! Participants that nobody has to invite. In: the study's seed and the participant's number. Out: how one drives, and
//! answers to questions. A model for rehearsing a study and its analysis, not for what people would say.
//!
//! Driving (`driver`), each number drawn for the participant: reaction to advice uniform in 0.6 to 1.6 s, to the leader 0.7
//! of that; tracking error uniform in 0.1 to 0.6 m/s; steady over- or under-speeding normal with 0.25 m/s, at most 0.6;
//! wander in the lane uniform in 0.03 to 0.10 m.
//!
//! Answers: a participant has a level u, uniform in 0 to 1. A rating is the scale's nearest point to u with a normal error
//! of 0.15 of the scale; an answer of a matrix the column at 0.5 u^2 with an error of 0.12, so that most symptoms are none;
//! a choice is uniform; each of several is taken with 0.3; yes with 0.7; lines say "rehearsed". Reading and answering takes
//! 1.5 s and an exponential time of mean 2 s.

use super::{
    questions::{Choice, Element, ElementKind, Questionnaire},
    session::{Answered, as_map},
};
use crate::{
    driver::DriverParams,
    rng::{self, Stream},
};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// A simulated participant.
#[derive(Clone, Debug)]
pub struct Participant {
    /// How they drive.
    pub driver: DriverParams,
    level: f64,
    seed: u64,
    index: usize,
}

impl Participant {
    /// Participant number `index` of a study with this seed; always the same.
    pub fn draw(seed: u64, index: usize) -> Self {
        let mut stream = rng::stream(seed, &format!("participant {index}"));
        let reaction_s = stream.uniform(0.6, 1.6);
        let driver = DriverParams {
            reaction_s,
            leader_reaction_s: 0.7 * reaction_s,
            error_mps: stream.uniform(0.1, 0.6),
            trait_mps: (0.25 * stream.normal()).clamp(-0.6, 0.6),
            lane_error_m: stream.uniform(0.03, 0.10),
            ..DriverParams::default()
        };
        Self { driver, level: stream.uniform(0.0, 1.0), seed, index }
    }

    /// The numbers that were drawn, by name with unit.
    pub fn traits(&self) -> BTreeMap<String, f64> {
        let d = &self.driver;
        let list = [
            ("reaction_s", d.reaction_s),
            ("error_mps", d.error_mps),
            ("overspeed_mps", d.trait_mps),
            ("lane_error_m", d.lane_error_m),
            ("level", self.level),
        ];
        list.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
    }

    /// Answers to a questionnaire that comes under this name: every question that is to be seen, page by page.
    pub fn answer(&self, questionnaire: &Questionnaire, item: &str) -> Vec<Answered> {
        let mut stream = rng::stream(self.seed, &format!("answers {} {item}", self.index));
        let mut answered: Vec<Answered> = Vec::new();
        for page in &questionnaire.pages {
            let mut time_s = 0.0;
            if page.visible_if.as_ref().is_some_and(|condition| !condition.holds(&as_map(&answered))) {
                continue;
            }
            for element in &page.elements {
                // An answer on the same page may bring a question to sight.
                if element.visible_if.as_ref().is_some_and(|condition| !condition.holds(&as_map(&answered))) {
                    continue;
                }
                for question in element.answer_names() {
                    time_s += 1.5 - 2.0 * (1.0 - stream.uniform(0.0, 1.0)).ln();
                    let answer = self.choose(element, &mut stream);
                    let time_s = (time_s * 1000.0).round() / 1000.0;
                    answered.push(Answered { question, answer, time_s });
                }
            }
        }
        answered
    }

    fn choose(&self, element: &Element, stream: &mut Stream) -> Value {
        let at = |place: f64, n: usize| ((place * (n - 1) as f64).round().max(0.0) as usize).min(n - 1);
        let word = |choices: &[Choice], i: usize| choices[i].value.clone();
        match element.kind {
            ElementKind::Rating => {
                let rates = element.rates();
                let rate = rates[at(self.level + 0.15 * stream.normal(), rates.len())];
                if rate.fract() == 0.0 { json!(rate as i64) } else { json!(rate) }
            }
            ElementKind::Matrix => {
                let place = 0.5 * self.level * self.level + 0.12 * stream.normal();
                word(&element.columns, at(place, element.columns.len()))
            }
            ElementKind::Radiogroup => word(&element.choices, stream.index(element.choices.len())),
            ElementKind::Checkbox => {
                let taken = element.choices.iter().filter(|_| stream.uniform(0.0, 1.0) < 0.3);
                Value::Array(taken.map(|choice| choice.value.clone()).collect())
            }
            ElementKind::Boolean => Value::Bool(stream.uniform(0.0, 1.0) < 0.7),
            ElementKind::Text | ElementKind::Comment | ElementKind::Html => json!("rehearsed"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn every_answer_is_allowed_and_none_that_is_required_is_missing() {
        for name in ["ssq", "raw-tlx", "acceptance", "driving-experience"] {
            let questionnaire = Questionnaire::find(name, Path::new(".")).unwrap();
            for index in 0..20 {
                let participant = Participant::draw(5, index);
                assert_eq!(participant.driver.check(), Ok(()));
                let answered = participant.answer(&questionnaire, name);
                let map = as_map(&answered);
                for page in questionnaire.visible_pages(&map) {
                    assert_eq!(page.missing(&map), Vec::<String>::new(), "{name}");
                    for element in page.visible_elements(&map) {
                        for answer in element.answer_names() {
                            assert!(element.accepts(&map[&answer]), "{answer}: {}", map[&answer]);
                        }
                    }
                }
                assert_eq!(answered, Participant::draw(5, index).answer(&questionnaire, name));
            }
        }
    }

    #[test]
    fn traits_are_within_what_is_stated_and_differ() {
        let people: Vec<Participant> = (0..400).map(|i| Participant::draw(1, i)).collect();
        let mean_and_sd = |get: &dyn Fn(&Participant) -> f64| {
            let values: Vec<f64> = people.iter().map(get).collect();
            let mean = values.iter().sum::<f64>() / 400.0;
            (mean, (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 399.0).sqrt())
        };
        // Even between two edges: the middle, and a spread of the width over the square root of 12. Three standard errors.
        let width_to_sd = 12f64.sqrt();
        for (name, low, high) in
            [("reaction_s", 0.6, 1.6), ("error_mps", 0.1, 0.6), ("lane_error_m", 0.03, 0.10), ("level", 0.0, 1.0)]
        {
            assert!(people.iter().all(|p| (low..high).contains(&p.traits()[name])), "{name}");
            let (mean, sd) = mean_and_sd(&|p| p.traits()[name]);
            let expected = (high - low) / width_to_sd;
            assert!((mean - f64::midpoint(low, high)).abs() < 3.0 * expected / 20.0, "{name}: {mean}");
            assert!((sd / expected - 1.0).abs() < 0.1, "{name}: {sd}");
        }
        // Normal with 0.25 m/s, cut at 0.6, which takes 2 % of the spread.
        let (mean, sd) = mean_and_sd(&|p| p.traits()["overspeed_mps"]);
        assert!(mean.abs() < 3.0 * 0.25 / 20.0 && (sd / 0.245 - 1.0).abs() < 0.12, "{mean}, {sd}");
        assert!(people.iter().all(|p| p.traits()["overspeed_mps"].abs() <= 0.6));
        for p in &people {
            // Brake lamps ahead are answered sooner than a number on the dial.
            assert_eq!(p.driver.leader_reaction_s, 0.7 * p.driver.reaction_s);
            assert_eq!(p.traits()["reaction_s"], p.driver.reaction_s);
        }
        assert_eq!(people[7].traits(), Participant::draw(1, 7).traits());
        assert_ne!(people[7].traits(), Participant::draw(2, 7).traits());
    }

    #[test]
    fn answers_follow_the_level_of_who_gives_them_and_take_seconds_each() {
        let tlx = Questionnaire::find("raw-tlx", Path::new(".")).unwrap();
        let (mut low, mut high, mut waits) = (Vec::new(), Vec::new(), Vec::new());
        for index in 0..200 {
            let participant = Participant::draw(9, index);
            let answered = participant.answer(&tlx, "tlx");
            let mean = answered.iter().filter_map(|a| a.answer.as_f64()).sum::<f64>() / answered.len() as f64;
            let level = participant.traits()["level"];
            if level < 0.3 {
                low.push(mean)
            } else if level > 0.7 {
                high.push(mean)
            }
            let times: BTreeMap<&str, f64> = answered.iter().map(|one| (one.question.as_str(), one.time_s)).collect();
            // Each page begins at 0.
            for page in &tlx.pages {
                let mut before = 0.0;
                for name in page.elements.iter().flat_map(Element::answer_names) {
                    waits.push(times[name.as_str()] - before);
                    before = times[name.as_str()];
                }
            }
        }
        let mean = |list: &[f64]| list.iter().sum::<f64>() / list.len() as f64;
        // Levels of 0.15 and 0.85 on a scale from 0 to 100.
        assert!((mean(&low) - 15.0).abs() < 6.0 && (mean(&high) - 85.0).abs() < 6.0, "{} {}", mean(&low), mean(&high));
        // 1.5 s at least, and 2 s more on average (exponential); 1,200 answers, three standard errors.
        assert_eq!(waits.len(), 1200);
        assert!(waits.iter().all(|wait| *wait >= 1.499));
        assert!((mean(&waits) - 3.5).abs() < 3.0 * 2.0 / (waits.len() as f64).sqrt(), "{}", mean(&waits));
        let milliseconds = waits.iter().map(|wait| (wait * 1000.0 - (wait * 1000.0).round()).abs());
        assert!(milliseconds.fold(0.0, f64::max) < 1e-6);
    }
}
