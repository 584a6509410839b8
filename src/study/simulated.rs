//! Simulated participants. In: the study's seed and the participant's number. Out: the driver's parameters, and answers to questions. The
//! model serves to rehearse a study and its analysis; it does not predict people's answers.
//!
//! Driving (`driver`), each parameter drawn per participant: reaction time to advice uniform in 0.6 to 1.6 s, to the leader 0.7 times
//! that; tracking error uniform in 0.1 to 0.6 m/s; constant over- or under-speeding normal with SD 0.25 m/s, clamped to 0.6 m/s; lateral
//! wander uniform in 0.03 to 0.10 m. Parameters fitted to a person ([`FittedDriver`]) replace drawn ones. Alternatively, the whole driver
//! is drawn from a [`Population`]; then reaction time, error, bias, time gap and compliance vary as defined there.
//!
//! Answers: a participant has a level u, uniform in 0 to 1. A rating is the point of the scale nearest to u plus a normal error with SD
//! 0.15 of the scale. An answer to a matrix row is the column at 0.5 u^2 plus an error with SD 0.12, so that most symptoms are "none". A
//! choice is uniform; each option of a checkbox is taken with probability 0.3; yes has probability 0.7; a number is a
//! whole one, uniform in its range; other text fields get "rehearsed".
//! Reading and answering takes 1.5 s plus an exponential time of mean 2 s.
//!
//! Sickness: a rating rises with the minutes driven, by a slope drawn per participant (exponential, mean 0.1 per minute), plus a normal
//! error with SD 0.5. The answer takes as long as above; without an answer in time, the question stays unanswered.

use super::{
    FmsRating, PlanItem, PlannedItem, SessionPlan, Study, fms,
    questions::{AnswerChoice, ElementKind, InputType, QuestionElement, Questionnaire},
    session_log::{EndCause, TimedAnswer, as_map},
};
use crate::{
    driver::{DriverParams, FittedDriver, Population},
    rng::{self, Stream},
};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Maximum number of draws of an answer; a screening that one in a thousand passes by chance is then passed with 99 %.
const MOST_DRAWS: usize = 5000;

/// Simulated participant of a rehearsal.
#[derive(Clone, Debug)]
pub struct SimulatedParticipant {
    /// Driver parameters in traffic whose desired time gap is the model's default.
    pub driver: DriverParams,
    known: FittedDriver,
    level: f64,
    population: Population,
    seed: u64,
    index: usize,
}

impl SimulatedParticipant {
    /// Draws participant number `index` of a study with this seed; reproducible.
    pub fn draw(seed: u64, index: usize) -> Self {
        let mut stream = rng::stream(seed, &format!("participant {index}"));
        let reaction_s = stream.uniform(0.6, 1.6);
        let driver = DriverParams {
            reaction_s,
            leader_reaction_s: 0.7 * reaction_s,
            error_mps: stream.uniform(0.1, 0.6),
            speed_bias_mps: (0.25 * stream.normal()).clamp(-0.6, 0.6),
            lane_error_m: stream.uniform(0.03, 0.10),
            ..DriverParams::default()
        };
        Self {
            driver,
            known: FittedDriver::default(),
            level: stream.uniform(0.0, 1.0),
            population: Population::None,
            seed,
            index,
        }
    }

    /// Replaces the driver by one drawn from a population, by seed and number of the participant.
    pub fn out_of(mut self, population: Population) -> Self {
        let mut stream = rng::stream(self.seed, &format!("{} {}", population.name(), self.index));
        let usual_time_gap_s = self.driver.idm.t;
        self.driver = population.draw(&self.driver, &mut stream);
        self.population = population;
        if population != Population::None {
            self.known.time_gap_factor = Some(self.driver.idm.t / usual_time_gap_s);
        }
        self
    }

    /// Replaces drawn driver parameters by those fitted to a person.
    pub fn who_drives_as(mut self, known: &FittedDriver) -> Self {
        self.known = known.clone();
        self.driver = known.applied_to(&self.driver, self.driver.idm.t);
        self
    }

    /// Returns the driver parameters in traffic whose desired time gap is `usual_time_gap_s`, s.
    pub fn driver_among(&self, usual_time_gap_s: f64) -> DriverParams {
        self.known.applied_to(&self.driver, usual_time_gap_s)
    }

    /// Returns the drawn parameters, by name with unit.
    pub fn parameters(&self) -> BTreeMap<String, f64> {
        let d = &self.driver;
        let list = [
            ("reaction_s", d.reaction_s),
            ("error_mps", d.error_mps),
            ("overspeed_mps", d.speed_bias_mps),
            ("lane_error_m", d.lane_error_m),
            ("level", self.level),
        ];
        let list = list.map(|(name, value)| (name.to_owned(), value)).into_iter();
        let of_population = [
            ("compliance", d.compliance),
            ("compliance_fade_s", d.compliance_fade_s),
            ("patience_mps", d.patience_mps),
            ("inattention_per_min", d.inattention_per_min),
        ];
        let of_population = of_population.into_iter().filter(|_| self.population != Population::None);
        let of_population = of_population.map(|(name, value)| (name.to_owned(), value));
        list.chain(of_population)
            .chain(self.known.time_gap_factor.map(|factor| ("time_gap_factor".to_owned(), factor)))
            .collect()
    }

    /// Returns the sickness rating for a question asked at `time_s` of a drive of the plan. Minutes driven count by the plan, so that a
    /// resumed rehearsal gives the same ratings.
    pub fn rate(&self, plan: &SessionPlan, drive: &str, time_s: f64) -> FmsRating {
        let slope_per_min =
            -0.1 * (1.0 - rng::stream(self.seed, &format!("fms {}", self.index)).uniform(0.0, 1.0)).ln();
        let before = plan.items.iter().take_while(|planned| planned.name != drive);
        let before_s: f64 = before
            .map(|planned| match &planned.item {
                PlanItem::Drive { scenario, .. } => scenario.duration_s,
                _ => 0.0,
            })
            .sum();
        let mut stream = rng::stream(self.seed, &format!("fms {} {drive} {time_s}", self.index));
        let felt = slope_per_min * (before_s + time_s) / 60.0 + 0.5 * stream.normal();
        let answer_s = 1.5 - 2.0 * (1.0 - stream.uniform(0.0, 1.0)).ln();
        let value = felt.round().clamp(0.0, fms::HIGHEST.into()) as u8;
        // Rounded up to the end of the 0.1 s step in which the answer comes.
        let answer_s = (10.0 * answer_s).ceil() / 10.0;
        let in_time = answer_s < fms::ANSWER_S;
        FmsRating { time_s, value: in_time.then_some(value), answer_s: in_time.then_some(answer_s) }
    }

    /// Returns answers to every visible question of a questionnaire, page by page; `item` is its name in the plan.
    pub fn answer(&self, questionnaire: &Questionnaire, item: &str) -> Vec<TimedAnswer> {
        let mut stream = rng::stream(self.seed, &format!("answers {} {item}", self.index));
        let mut answered: Vec<TimedAnswer> = Vec::new();
        for page in &questionnaire.pages {
            let mut time_s = 0.0;
            if page.visible_if.as_ref().is_some_and(|condition| !condition.holds(&as_map(&answered))) {
                continue;
            }
            for element in &page.elements {
                // An answer on the same page may make a question visible.
                if element.visible_if.as_ref().is_some_and(|condition| !condition.holds(&as_map(&answered))) {
                    continue;
                }
                for question in element.answer_names() {
                    time_s += 1.5 - 2.0 * (1.0 - stream.uniform(0.0, 1.0)).ln();
                    let answer = self.choose(element, &mut stream);
                    let time_s = (time_s * 1000.0).round() / 1000.0;
                    answered.push(TimedAnswer { question, answer, time_s });
                }
            }
        }
        answered
    }

    /// Returns answers that pass a consent or a screening. Draws again until the answers let the session continue, at most `MOST_DRAWS`
    /// times; then the first answers are used. A score above its limit is not avoided.
    pub fn answer_as_invited(&self, study: &Study, word: &str, planned: &PlannedItem) -> Vec<TimedAnswer> {
        let questionnaire = &study.questionnaires[word];
        let first = self.answer(questionnaire, &planned.name);
        let is_turned_away = |answers: &[TimedAnswer]| {
            study.ending(planned, &as_map(answers)).is_some_and(|ending| ending.cause != EndCause::ScoreLimit)
        };
        if !is_turned_away(&first) {
            return first;
        }
        let again = (1..MOST_DRAWS).map(|i| self.answer(questionnaire, &format!("{} again {i}", planned.name)));
        again.into_iter().find(|answers| !is_turned_away(answers)).unwrap_or(first)
    }

    fn choose(&self, element: &QuestionElement, stream: &mut Stream) -> Value {
        let at = |place: f64, n: usize| ((place * (n - 1) as f64).round().max(0.0) as usize).min(n - 1);
        let word = |choices: &[AnswerChoice], i: usize| choices[i].value.clone();
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
            ElementKind::Text if element.input_type == InputType::Number => {
                json!(stream.uniform(element.min, element.max).round().to_string())
            }
            ElementKind::Text | ElementKind::Comment | ElementKind::Html => json!("rehearsed"),
        }
    }
}

#[cfg(test)]
#[path = "simulated_tests.rs"]
mod tests;
