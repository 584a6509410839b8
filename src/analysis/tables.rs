//! What was measured, as CSV. In: analysed drives. Out: text: `trials.csv` (a row a drive), `advice.csv` (a row a change of
//! the advice), `speed.csv` (a row a second), `conditions.csv` (mean, deviation and 95 % bootstrap interval), and a
//! description of every column.

use super::{
    Analysed, MEASURES,
    measures::{deviation, median},
};
use crate::train::Estimate;
use serde_json::{Map, Value, json};

/// A number, or nothing.
fn cell(value: Option<f64>) -> String {
    value.filter(|v| v.is_finite()).map_or(String::new(), |v| v.to_string())
}

fn line(cells: impl IntoIterator<Item = String>) -> String {
    let quoted = cells.into_iter().map(|c| if c.contains([',', '"', '\n']) { format!("{c:?}") } else { c });
    quoted.collect::<Vec<_>>().join(",") + "\n"
}

/// Names of the factors, as the first drive has them.
fn factors(drives: &[Analysed]) -> Vec<String> {
    drives.first().map(|d| d.found.levels.iter().map(|level| level.0.clone()).collect()).unwrap_or_default()
}

/// Columns that say which drive a row is of.
fn key_names(drives: &[Analysed]) -> Vec<String> {
    let mut names: Vec<String> = ["participant", "segment", "place", "condition"].map(str::to_owned).to_vec();
    // A study without factors calls its one factor as the column that is there.
    names.extend(factors(drives).into_iter().filter(|factor| factor != "condition"));
    names
}

fn key(drive: &Analysed) -> Vec<String> {
    let found = &drive.found;
    let mut cells =
        vec![found.participant.clone(), found.segment.clone(), found.place.clone(), found.condition.clone()];
    cells.extend(found.levels.iter().filter(|level| level.0 != "condition").map(|level| level.1.clone()));
    cells
}

/// A row a drive.
pub fn trials(drives: &[Analysed]) -> String {
    let names = MEASURES.iter().map(|measure| measure.name.to_owned());
    let head = key_names(drives).into_iter().chain(["duration_s", "ended"].map(str::to_owned)).chain(names);
    let row = |drive: &Analysed| {
        let facts = [cell(Some(drive.duration_s)), drive.ended.clone()];
        line(key(drive).into_iter().chain(facts).chain(drive.measures.values.iter().map(|v| cell(*v))))
    };
    line(head) + &drives.iter().map(row).collect::<String>()
}

/// A row a change of the advice.
pub fn advice(drives: &[Analysed]) -> String {
    let own = ["onset_s", "from_mps", "to_mps", "reaction_s", "was_in_range", "enter_range_s", "enter_range_steps"];
    let mut text = line(key_names(drives).into_iter().chain(own.map(str::to_owned)));
    for drive in drives {
        for r in drive.responses() {
            let own = [
                cell(Some(r.onset_s)),
                cell(Some(r.from_mps)),
                cell(Some(r.to_mps)),
                cell(r.reaction_s),
                r.was_in_range.to_string(),
                cell(r.enter_s),
                cell(r.enter_steps.map(|n| n as f64)),
            ];
            text += &line(key(drive).into_iter().chain(own));
        }
    }
    text
}

/// A row a second of every drive.
pub fn speed(drives: &[Analysed]) -> String {
    let own = ["second", "mean_speed_mps", "baseline_speed_mps"];
    let mut text = line(key_names(drives).into_iter().chain(own.map(str::to_owned)));
    for drive in drives {
        for (second, speed) in drive.per_second_mps.iter().enumerate() {
            let baseline = drive.baseline_per_second_mps.get(second).copied();
            text += &line(key(drive).into_iter().chain([second.to_string(), cell(Some(*speed)), cell(baseline)]));
        }
    }
    text
}

/// Conditions in the study's order; drives without one are left out.
pub fn conditions(drives: &[Analysed]) -> Vec<(String, Vec<&Analysed>)> {
    let mut list: Vec<(String, Vec<&Analysed>)> = Vec::new();
    for drive in drives.iter().filter(|d| !d.found.condition.is_empty()) {
        match list.iter_mut().find(|(name, _)| *name == drive.found.condition) {
            Some((_, of)) => of.push(drive),
            None => list.push((drive.found.condition.clone(), vec![drive])),
        }
    }
    list.sort_by_key(|(_, of)| of[0].found.rank);
    list
}

/// A measure of some drives.
pub fn values(of: &[&Analysed], measure: usize) -> Vec<f64> {
    of.iter().filter_map(|drive| drive.measures.values[measure]).collect()
}

/// A row a condition and measure.
pub fn by_condition(drives: &[Analysed]) -> String {
    let head = ["condition", "measure", "unit", "n", "mean", "sd", "median", "low", "high"];
    let mut text = line(head.map(str::to_owned));
    for (condition, of) in conditions(drives) {
        for (k, measure) in MEASURES.iter().enumerate() {
            let values = values(&of, k);
            let Some(estimate) = Estimate::of(&values) else { continue };
            text += &line([
                condition.clone(),
                measure.name.into(),
                measure.unit.into(),
                values.len().to_string(),
                cell(Some(estimate.mean)),
                cell(deviation(&values)),
                cell(median(values)),
                cell(Some(estimate.low)),
                cell(Some(estimate.high)),
            ]);
        }
    }
    text
}

/// What every column is, as JSON.
pub fn description(drives: &[Analysed]) -> String {
    let mut out = Map::new();
    let mut put = |name: &str, about: &str, unit: &str| {
        let value = if unit.is_empty() {
            json!({ "Description": about })
        } else {
            json!({ "Description": about, "Units": unit })
        };
        out.insert(name.into(), value);
    };
    put("participant", "code of the participant", "");
    put("segment", "segment of the study", "");
    put("place", "place among the trials of the segment, from 1", "");
    put("condition", "condition of the trial", "");
    factors(drives).iter().for_each(|factor| put(factor, "level of the factor", ""));
    put("duration_s", "length of the drive", "s");
    put("ended", "how it ended", "");
    MEASURES.iter().for_each(|measure| put(measure.name, measure.about, measure.unit));
    put("onset_s", "advice.csv: when the change was seen, from the start of the drive", "s");
    put("from_mps", "advice.csv: the target before", "m/s");
    put("to_mps", "advice.csv: the new target", "m/s");
    put("was_in_range", "advice.csv: the speed was in the new range at the onset", "");
    put("second", "speed.csv: second of the drive; speeds are means over it", "s");
    put("low", "conditions.csv: lower end of the 95 % bootstrap interval of the mean", "");
    put("high", "conditions.csv: upper end", "");
    format!("{:#}\n", Value::Object(out))
}

/// How large a difference between two conditions would be seen, from the paired differences within participants.
#[derive(Clone, Debug, PartialEq)]
pub struct Power {
    /// Index of the measure.
    pub measure: usize,
    /// Two conditions.
    pub pair: [String; 2],
    /// Participants with both.
    pub n: usize,
    /// Mean and standard deviation (N-1) of the differences, second less first.
    pub mean: f64,
    /// Their standard deviation.
    pub sd: f64,
}

impl Power {
    /// The difference that `n` participants show with a power of 80 % at 5 % on two sides: 2.80 standard errors.
    pub fn detectable(&self, n: usize) -> f64 {
        2.80 * self.sd / (n as f64).sqrt()
    }

    /// Participants who would show the difference that was found, as above; `None` where there is none.
    pub fn needed(&self) -> Option<f64> {
        (self.mean != 0.0).then(|| (2.80 * self.sd / self.mean).powi(2).ceil().max(2.0))
    }
}

/// Paired differences of a measure between all pairs of conditions.
pub fn power(drives: &[Analysed], measure: usize) -> Vec<Power> {
    let conditions = conditions(drives);
    let mut list = Vec::new();
    for (i, (first, a)) in conditions.iter().enumerate() {
        for (second, b) in &conditions[i + 1..] {
            let differences: Vec<f64> = a
                .iter()
                .filter_map(|one| {
                    let other = b.iter().find(|other| other.found.participant == one.found.participant)?;
                    Some(other.measures.values[measure]? - one.measures.values[measure]?)
                })
                .collect();
            if let Some(sd) = deviation(&differences) {
                let n = differences.len();
                let mean = differences.iter().sum::<f64>() / n as f64;
                list.push(Power { measure, pair: [first.clone(), second.clone()], n, mean, sd });
            }
        }
    }
    list
}
