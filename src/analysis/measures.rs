//! One drive in numbers. In: a [`Trial`], and the same drive without advice where there is one. Out: [`Measures`]. Each is
//! over the whole trial unless its row in [`MEASURES`] says otherwise; that list is the only place that names them.

use super::{
    Trial,
    response::{Response, responses},
};
use crate::train;

/// Gap size of a steering reversal, degrees of the steering wheel (SAE J2944, 11.6).
pub const REVERSAL_DEG: f64 = 3.0;

/// A drive in numbers; `None` where there is nothing to measure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Measures {
    /// Values in the order of [`MEASURES`].
    pub values: Vec<Option<f64>>,
    /// What became of every change of the advice.
    pub responses: Vec<Response>,
}

/// A measure.
pub struct Measure {
    /// Its name in tables, with the unit.
    pub name: &'static str,
    /// In words, for figures.
    pub title: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Definition with its options.
    pub about: &'static str,
    of: fn(&Sight) -> Option<f64>,
}

/// What measures are taken of.
struct Sight<'a> {
    trial: &'a Trial,
    baseline: Option<&'a Trial>,
    responses: &'a [Response],
    verdict: Option<train::Verdict>,
    baseline_verdict: Option<train::Verdict>,
}

const fn measure(
    name: &'static str,
    title: &'static str,
    unit: &'static str,
    about: &'static str,
    of: fn(&Sight) -> Option<f64>,
) -> Measure {
    Measure { name, title, unit, about, of }
}

/// All of them.
pub const MEASURES: &[Measure] = &[
    measure(
        "mean_speed_mps",
        "Mean speed of all cars",
        "m/s",
        "speed of all vehicles, the ego included: mean over vehicles and ticks",
        |s| mean(&s.trial.ego.mean_speed_mps),
    ),
    measure(
        "baseline_speed_mps",
        "The same without advice",
        "m/s",
        "the same in the drive from the same seed without advice, driven by the car-following model",
        |s| mean(&s.baseline?.ego.mean_speed_mps),
    ),
    measure(
        "speed_gain_mps",
        "Gain of mean speed over no advice",
        "m/s",
        "mean_speed_mps less baseline_speed_mps: the paired difference",
        |s| Some(mean(&s.trial.ego.mean_speed_mps)? - mean(&s.baseline?.ego.mean_speed_mps)?),
    ),
    measure(
        "sd_over_cars_mps",
        "Spread of speed over cars",
        "m/s",
        "standard deviation of speed over the vehicles (N), mean over steps",
        |s| Some(s.verdict?.sd_over_cars_mps),
    ),
    measure(
        "calm_after_s",
        "Time until the wave is calm",
        "s",
        "from the first step until the spread over cars stays below 0.5 m/s; empty if it never does",
        |s| s.verdict?.calm_s,
    ),
    measure("ego_speed_mps", "Mean speed of the ego", "m/s", "speed of the ego: mean over ticks", |s| {
        mean(&s.trial.ego.speed_mps)
    }),
    measure(
        "time_in_range",
        "Share of time in the range",
        "",
        "share of the ticks with advice at which the speed is in the acceptable range, its edges included",
        |s| {
            let known: Vec<f64> = s.trial.ego.in_range.iter().flatten().map(|is| f64::from(u8::from(*is))).collect();
            mean(&known)
        },
    ),
    measure(
        "speed_error_mps",
        "Mean absolute speed error",
        "m/s",
        "absolute difference of speed and target: mean over ticks with advice",
        |s| mean(&errors(s.trial).map(f64::abs).collect::<Vec<_>>()),
    ),
    measure(
        "speed_bias_mps",
        "Mean speed error",
        "m/s",
        "speed less target: mean over ticks with advice; positive is too fast",
        |s| mean(&errors(s.trial).collect::<Vec<_>>()),
    ),
    measure(
        "changes",
        "Changes of the advice",
        "",
        "changes of the target of at least 0.1 m/s that the driver saw; the first advice is none",
        |s| Some(s.responses.len() as f64),
    ),
    measure(
        "responded",
        "Share of changes answered",
        "",
        "share of these changes that a pedal answered (SAE J2944; see advice.csv)",
        |s| mean(&s.responses.iter().map(|r| f64::from(u8::from(r.reaction_s.is_some()))).collect::<Vec<_>>()),
    ),
    measure(
        "reaction_s",
        "Reaction time",
        "s",
        "from the frame that shows a change to 5 % of pedal travel towards it (SAE J2944): median over changes that were answered within 0.15 to 5 s",
        |s| median(s.responses.iter().filter_map(|r| r.reaction_s).collect()),
    ),
    measure(
        "enter_range_s",
        "Time to enter the range",
        "s",
        "from the frame that shows a change to the speed being in the new range: median over changes from out of it that were reached before the next",
        |s| median(s.responses.iter().filter_map(|r| r.enter_s).collect()),
    ),
    measure("enter_range_steps", "Steps to enter the range", "steps", "the same in steps of the scenario", |s| {
        median(s.responses.iter().filter_map(|r| Some(r.enter_steps? as f64)).collect())
    }),
    measure("min_gap_m", "Smallest gap", "m", "own front bumper to the leader's rear: smallest", |s| {
        least(&s.trial.ego.gap_m)
    }),
    measure(
        "min_headway_m",
        "Smallest headway",
        "m",
        "own front bumper to the leader's front (SAE J2944): smallest",
        |s| least(&s.trial.ego.headway_m),
    ),
    measure(
        "min_ttc_s",
        "Smallest time to collision",
        "s",
        "gap over closing speed while the gap closes: smallest",
        |s| least(&s.trial.ego.ttc_s),
    ),
    measure(
        "sdlp_m",
        "SDLP",
        "m",
        "standard deviation of lane position (N-1), reference the middle of the car, over the whole trial, unfiltered",
        |s| deviation(&s.trial.ego.lane_offset_m),
    ),
    measure(
        "reversals_per_min",
        "Steering reversal rate",
        "1/min",
        "reversals of the steering wheel with a gap size of 3 degrees, both ways, unfiltered, a minute",
        |s| {
            let minutes = s.trial.duration_s() / 60.0;
            let wheel = s.trial.ego.wheel_rad.iter().map(|rad| rad.to_degrees());
            (minutes > 0.0).then(|| reversals(wheel, REVERSAL_DEG) as f64 / minutes)
        },
    ),
    measure(
        "rms_jerk_mps3",
        "RMS jerk",
        "m/s3",
        "root mean square of the change of acceleration, averaged over a step, from one step to the next",
        |s| rms_jerk(s.trial),
    ),
    measure(
        "ego_fuel_l_100km",
        "Fuel of the ego",
        "l/100 km",
        "fuel of the ego by the model of Kamal et al. (2013)",
        |s| fuel(s.trial, 1)?.fuel_l_100km,
    ),
    measure(
        "fuel_l_100km",
        "Fuel of all cars",
        "l/100 km",
        "fuel of all vehicles by the model of Kamal et al. (2013)",
        |s| s.verdict?.fuel_l_100km,
    ),
    measure(
        "fuel_saved_l_100km",
        "Fuel saved over no advice",
        "l/100 km",
        "fuel_l_100km of the drive without advice less that of this one",
        |s| Some(s.baseline_verdict?.fuel_l_100km? - s.verdict?.fuel_l_100km?),
    ),
    measure("contacts", "Contacts", "", "contacts with other cars", |s| Some(s.trial.contacts as f64)),
    measure("left_road", "Departures from the lane", "", "how often the middle of the car left its lane", |s| {
        Some(s.trial.left_road as f64)
    }),
    measure(
        "latency_median_s",
        "Latency, median",
        "s",
        "from the newest input (the kernel's time) to the handing over of the frame that shows it: median over such frames",
        |s| median(s.trial.latencies_s.clone()),
    ),
    measure("latency_p99_s", "Latency, 99th percentile", "s", "the same: 99th percentile (nearest rank)", |s| {
        let mut sorted = s.trial.latencies_s.clone();
        sorted.sort_by(f64::total_cmp);
        sorted.get((0.99 * sorted.len() as f64).ceil() as usize - usize::from(!sorted.is_empty())).copied()
    }),
];

impl Measures {
    /// Of a drive, and of the same without advice.
    pub fn of(trial: &Trial, baseline: Option<&Trial>) -> Self {
        let responses = responses(trial);
        let verdict = |trial: &Trial| fuel(trial, usize::MAX);
        let sight = Sight {
            trial,
            baseline,
            responses: &responses,
            verdict: verdict(trial),
            baseline_verdict: baseline.and_then(verdict),
        };
        Self { values: MEASURES.iter().map(|measure| (measure.of)(&sight)).collect(), responses }
    }

    /// The value of a measure by its name.
    pub fn get(&self, name: &str) -> Option<f64> {
        let at = MEASURES.iter().position(|measure| measure.name == name)?;
        self.values.get(at).copied().flatten()
    }
}

fn errors(trial: &Trial) -> impl Iterator<Item = f64> {
    let ego = &trial.ego;
    ego.speed_mps.iter().zip(&ego.target_mps).filter_map(|(speed, target)| Some(speed - (*target)?))
}

/// The first `cars` cars by the code that judges policies: spread, calm, fuel.
fn fuel(trial: &Trial, cars: usize) -> Option<train::Verdict> {
    if trial.steps.len() < 2 {
        return None;
    }
    // Only these three are taken from it; gap and range are measured tick by tick.
    let mut tally = train::Tally::new(trial.step_s, trial.route_m.max(1.0));
    for step in &trial.steps {
        tally.add(step.speed_mps.iter().take(cars).map(|v| v.max(0.0) as f32), f64::INFINITY, None);
    }
    Some(tally.verdict())
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn least(values: &[Option<f64>]) -> Option<f64> {
    values.iter().flatten().copied().reduce(f64::min)
}

/// Middle value; of an even number the mean of the two in the middle.
pub(super) fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    (n > 0).then(|| (values[(n - 1) / 2] + values[n / 2]) / 2.0)
}

/// Standard deviation, N-1.
pub(super) fn deviation(values: &[f64]) -> Option<f64> {
    let middle = mean(values)?;
    let square: f64 = values.iter().map(|x| (x - middle).powi(2)).sum();
    (values.len() > 1).then(|| (square / (values.len() - 1) as f64).sqrt())
}

/// How often the angle turns back by at least `gap` from where it was furthest.
fn reversals(angles: impl Iterator<Item = f64>, gap: f64) -> usize {
    let mut count = 0;
    // Furthest to either side since the last reversal, and the way that it was turned last: 0 before the first.
    let (mut low, mut high, mut way) = (f64::INFINITY, f64::NEG_INFINITY, 0);
    for angle in angles {
        low = low.min(angle);
        high = high.max(angle);
        if way >= 0 && high - angle >= gap {
            count += usize::from(way > 0);
            (way, low) = (-1, angle);
        } else if way <= 0 && angle - low >= gap {
            count += usize::from(way < 0);
            (way, high) = (1, angle);
        }
    }
    count
}

fn rms_jerk(trial: &Trial) -> Option<f64> {
    let ticks = (trial.step_s / crate::time::TICK_S).round().max(1.0) as usize;
    let means: Vec<f64> = trial.ego.accel_mps2.chunks_exact(ticks).filter_map(mean).collect();
    let squares: Vec<f64> = means.windows(2).map(|pair| ((pair[1] - pair[0]) / trial.step_s).powi(2)).collect();
    Some(mean(&squares)?.sqrt())
}

#[cfg(test)]
#[path = "measures_tests.rs"]
mod tests;
