//! One drive in numbers. In: its totals, and those of the same drive without advice where there is one. Out: [`DriveMeasures`]. Each
//! is over the whole trial unless its row in [`MEASURES`] says otherwise; that list is the only place that names them.

use super::{RecordedTrial, glossary::unit_text, response::AdviceResponse, totals::DriveTotals};
use crate::metrics::FlowTotals;

/// A drive in numbers; `None` where there is nothing to measure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DriveMeasures {
    /// Values in the order of [`MEASURES`].
    pub values: Vec<Option<f64>>,
    /// What became of every change of the advice.
    pub responses: Vec<AdviceResponse>,
}

/// A measure.
pub struct MeasureDefinition {
    /// Its name in tables, with the unit.
    pub name: &'static str,
    /// In words, for figures.
    pub title: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Definition with its options.
    pub about: &'static str,
    of: fn(&MeasureInputs) -> Option<f64>,
}

/// What measures are taken of.
struct MeasureInputs<'a> {
    trial: &'a RecordedTrial,
    totals: &'a DriveTotals,
    baseline: Option<&'a DriveTotals>,
    responses: &'a [AdviceResponse],
}

impl MeasureInputs<'_> {
    /// Middle value over the responses that have one.
    fn median(&self, of: fn(&AdviceResponse) -> Option<f64>) -> Option<f64> {
        median(self.responses.iter().filter_map(of).collect())
    }
}

impl MeasureDefinition {
    /// Quantity and unit, as an axis or a table's head says it.
    pub fn label(&self) -> String {
        if self.unit.is_empty() { self.title.into() } else { format!("{}, {}", self.title, unit_text(self.unit)) }
    }
}

const fn measure(
    name: &'static str,
    title: &'static str,
    unit: &'static str,
    about: &'static str,
    of: fn(&MeasureInputs) -> Option<f64>,
) -> MeasureDefinition {
    MeasureDefinition { name, title, unit, about, of }
}

/// All of them.
pub const MEASURES: &[MeasureDefinition] = &[
    measure(
        "mean_speed_mps",
        "Mean speed of all vehicles",
        "m/s",
        "speed of all vehicles, the ego vehicle included: mean over vehicles and ticks (100 a second; over steps of 0.1 s, as in \
         published figures, it differs by up to about 0.001 m/s)",
        |s| s.totals.mean_speed_mps.get(),
    ),
    measure(
        "baseline_speed_mps",
        "Mean speed of all vehicles without advice",
        "m/s",
        "speed of all vehicles: mean over vehicles and ticks in the drive from the same seed without advice, the ego vehicle driven by \
         the car-following model",
        |s| s.baseline?.mean_speed_mps.get(),
    ),
    measure(
        "speed_gain_mps",
        "Gain in mean speed over no advice",
        "m/s",
        "mean speed of all vehicles less that of the drive from the same seed without advice: the paired difference",
        |s| Some(s.totals.mean_speed_mps.get()? - s.baseline?.mean_speed_mps.get()?),
    ),
    measure(
        "sd_over_cars_mps",
        "Standard deviation of speed over vehicles",
        "m/s",
        "standard deviation of speed over the vehicles (N), mean over steps",
        |s| Some(all_cars(s.totals)?.sd_over_cars_mps()),
    ),
    measure(
        "last_disturbance_s",
        "Time of the last disturbance",
        "s",
        "from the first step until the standard deviation of speed over vehicles stays below 0.5 m/s; empty if it never does",
        |s| all_cars(s.totals)?.last_disturbance_s(),
    ),
    measure(
        "ego_speed_mps",
        "Mean speed of the ego vehicle",
        "m/s",
        "speed of the ego vehicle: mean over ticks",
        |s| s.totals.ego_speed_mps.get(),
    ),
    measure(
        "time_in_range",
        "Share of time in range",
        "",
        "share of the ticks with advice at which the speed is in the acceptable range, its edges included",
        |s| s.totals.in_range.get(),
    ),
    measure(
        "speed_error_mps",
        "Mean absolute speed error",
        "m/s",
        "absolute difference of speed and target: mean over ticks with advice",
        |s| s.totals.absolute_error_mps.get(),
    ),
    measure(
        "speed_bias_mps",
        "Mean speed error",
        "m/s",
        "speed less target: mean over ticks with advice; positive is too fast",
        |s| s.totals.error_mps.get(),
    ),
    measure(
        "changes",
        "Changes of the advice",
        "",
        "changes of the target that the driver saw, by at least 0.1 m/s from the target that counted last (smaller ones add up \
         until they do); the first advice is none",
        |s| Some(s.responses.len() as f64),
    ),
    measure(
        "responded",
        "Share of changes responded to",
        "",
        "share of the changes of the advice that a movement of a pedal answered within 0.15 to 5 s (SAE J2944)",
        |s| mean(&s.responses.iter().map(|r| f64::from(u8::from(r.reaction_s.is_some()))).collect::<Vec<_>>()),
    ),
    measure(
        "reaction_s",
        "Reaction time",
        "s",
        "from the frame that shows a change to 5 % of pedal travel towards it (SAE J2944): median over changes that were responded to within 0.15 to 5 s",
        |s| s.median(|r| r.reaction_s),
    ),
    measure(
        "enter_range_s",
        "Time to enter the range",
        "s",
        "from the frame that shows a change to the speed being in the new range: median over changes from out of it that were reached before the next",
        |s| s.median(|r| r.enter_s),
    ),
    measure(
        "enter_range_steps",
        "Steps to enter the range",
        "steps",
        "the time to enter the range in steps of the traffic: median over the same changes",
        |s| s.median(|r| Some(r.enter_steps? as f64)),
    ),
    measure(
        "min_gap_m",
        "Minimum gap",
        "m",
        "own front bumper to the leader's rear: smallest, over ticks in the leader's lane (less than a car's width, 1.8 m, beside the \
         lane's middle)",
        |s| s.totals.gap_m.0,
    ),
    measure(
        "min_headway_m",
        "Minimum headway",
        "m",
        "own front bumper to the leader's front (SAE J2944): smallest, over ticks in the leader's lane",
        |s| s.totals.headway_m.0,
    ),
    measure(
        "min_ttc_s",
        "Minimum time to collision",
        "s",
        "gap over closing speed while the gap closes: smallest, over ticks in the leader's lane",
        |s| s.totals.ttc_s.0,
    ),
    measure(
        "time_headway_s",
        "Time headway",
        "s",
        "own front bumper to the leader's front over own speed (SAE J2944): mean over ticks in the leader's lane at 1 m/s or more",
        |s| s.totals.time_headway_s.get(),
    ),
    measure(
        "min_time_headway_s",
        "Minimum time headway",
        "s",
        "own front bumper to the leader's front over own speed (SAE J2944): smallest, over ticks in the leader's lane at 1 m/s or more",
        |s| s.totals.min_time_headway_s.0,
    ),
    measure(
        "sdlp_m",
        "Standard deviation of lane position (SDLP)",
        "m",
        "standard deviation of lane position (N−1), reference the middle of the car, over the whole trial, unfiltered",
        |s| s.totals.sdlp_m(),
    ),
    measure(
        "reversals_per_min",
        "Steering reversal rate",
        "1/min",
        "reversals of the steering wheel with a gap size of 3 degrees, both ways, unfiltered, a minute",
        |s| {
            let minutes = s.totals.duration_s / 60.0;
            (minutes > 0.0).then(|| s.totals.reversals.count as f64 / minutes)
        },
    ),
    measure(
        "rms_jerk_mps3",
        "Root mean square jerk",
        "m/s3",
        "root mean square of the change of acceleration, averaged over a step, from one step to the next",
        |s| Some(s.totals.square_jerk.get()?.sqrt()),
    ),
    measure(
        "ego_fuel_l_100km",
        "Fuel consumption of the ego vehicle",
        "l/100 km",
        "fuel of the ego vehicle by the model of Kamal et al. (2013)",
        |s| enough(&s.totals.ego_alone)?.fuel_l_100km(),
    ),
    measure(
        "fuel_l_100km",
        "Fuel consumption of all vehicles",
        "l/100 km",
        "fuel of all vehicles by the model of Kamal et al. (2013)",
        |s| all_cars(s.totals)?.fuel_l_100km(),
    ),
    measure(
        "fuel_saved_l_100km",
        "Fuel saved over no advice",
        "l/100 km",
        "fuel of all vehicles in the drive from the same seed without advice less that in this one",
        |s| Some(all_cars(s.baseline?)?.fuel_l_100km()? - all_cars(s.totals)?.fuel_l_100km()?),
    ),
    measure("contacts", "Contacts with other vehicles", "", "how often the ego vehicle touched another vehicle", |s| {
        Some(s.trial.contacts as f64)
    }),
    measure("left_road", "Departures from the lane", "", "how often the middle of the car left its lane", |s| {
        Some(s.trial.left_road as f64)
    }),
    measure(
        "latency_median_s",
        "Median latency",
        "s",
        "from the newest input (the kernel's time) to the handing over of the frame that shows it: median over such frames",
        |s| middle(&s.trial.latencies_s),
    ),
    measure(
        "latency_p99_s",
        "99th percentile of latency",
        "s",
        "from the newest input (the kernel's time) to the handing over of the frame that shows it: 99th percentile (nearest rank)",
        |s| {
            let sorted = &s.trial.latencies_s;
            sorted.get((0.99 * sorted.len() as f64).ceil() as usize - usize::from(!sorted.is_empty())).copied()
        },
    ),
];

impl DriveMeasures {
    /// Of a drive with its totals and responses, and of the totals of the same without advice.
    pub fn of(
        trial: &RecordedTrial,
        totals: &DriveTotals,
        responses: Vec<AdviceResponse>,
        baseline: Option<&DriveTotals>,
    ) -> Self {
        let sight = MeasureInputs { trial, totals, baseline, responses: &responses };
        Self { values: MEASURES.iter().map(|measure| (measure.of)(&sight)).collect(), responses }
    }

    /// The value of a measure by its name.
    pub fn get(&self, name: &str) -> Option<f64> {
        let at = MEASURES.iter().position(|measure| measure.name == name)?;
        self.values.get(at).copied().flatten()
    }
}

/// Speeds of all cars by the code that judges policies: spread, calm, fuel.
fn all_cars(totals: &DriveTotals) -> Option<&FlowTotals> {
    enough(&totals.all_cars)
}

/// Of a single step nothing can be told.
fn enough(flow: &FlowTotals) -> Option<&FlowTotals> {
    (flow.steps() >= 2).then_some(flow)
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Middle value; of an even number the mean of the two in the middle.
pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    middle(&values)
}

/// The same of values in order.
fn middle(sorted: &[f64]) -> Option<f64> {
    let n = sorted.len();
    (n > 0).then(|| (sorted[(n - 1) / 2] + sorted[n / 2]) / 2.0)
}

/// Standard deviation, N-1.
pub(super) fn deviation(values: &[f64]) -> Option<f64> {
    let middle = mean(values)?;
    let square: f64 = values.iter().map(|x| (x - middle).powi(2)).sum();
    (values.len() > 1).then(|| (square / (values.len() - 1) as f64).sqrt())
}

#[cfg(test)]
#[path = "measures_tests.rs"]
mod tests;
