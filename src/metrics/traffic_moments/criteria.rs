//! Values of measured people, and how near to them a model of people has to be. In: the moments of some runs. Out: each moment beside its
//! value for people, and whether it is within its band. Sources: docs/references.md: people.

use super::moments::{MOMENTS, TrafficMoments};
use crate::metrics::registry::Measure;
use serde::Serialize;

/// Value of a moment for measured people.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Criterion {
    /// Name of the moment.
    pub moment: &'static str,
    /// Value for people, in the unit of the moment.
    pub people: f64,
    /// Values of the two halves of the measured time; `None` if unknown.
    pub halves: Option<[f64; 2]>,
    /// Lowest and highest value that counts as like people, `f64::MIN` or `f64::MAX` for no limit; `None` without a criterion.
    pub band: Option<[f64; 2]>,
}

/// Measured traffic with its moments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredTraffic {
    /// Name in commands and files.
    pub name: &'static str,
    /// Title in tables and reports.
    pub title: &'static str,
    /// Length of the ring, m.
    pub ring_m: f64,
    /// Number of vehicles on the ring.
    pub vehicles: usize,
    /// Measured part of a drive, s since its start.
    pub from_to_s: [f64; 2],
    pub criteria: &'static [Criterion],
}

/// Moment of a model beside that of people.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Judgement {
    /// Name of the moment.
    pub moment: &'static str,
    /// Title of the moment in tables.
    pub title: &'static str,
    pub unit: &'static str,
    /// Value for people, in the unit of the moment.
    pub people: f64,
    /// Values of the two halves of the measured time.
    pub people_halves: Option<[f64; 2]>,
    /// Lowest and highest value that counts as like people; an end is `None` if there is no limit.
    pub band: Option<[Option<f64>; 2]>,
    /// Mean over the runs of the model; `None` if a run does not have it.
    pub model: Option<f64>,
    /// Smallest and largest value of a run.
    pub model_runs: Option<[f64; 2]>,
    /// True if the mean is in the band; `None` without a band or a value.
    pub within: Option<bool>,
}

/// Compares the moments of some runs, such as ten seeds of a model, with those of people.
pub fn judge(people: &MeasuredTraffic, runs: &[TrafficMoments]) -> Vec<Judgement> {
    people.criteria.iter().map(|criterion| criterion.judge(runs)).collect()
}

impl MeasuredTraffic {
    /// Returns the value of a moment by its name.
    pub fn criterion(&self, moment: &str) -> Option<&'static Criterion> {
        self.criteria.iter().find(|criterion| criterion.moment == moment)
    }
}

impl Criterion {
    /// Compares the moment of some runs with that of people.
    fn judge(&self, runs: &[TrafficMoments]) -> Judgement {
        let values: Option<Vec<f64>> = runs.iter().map(|run| run.get(self.moment)).collect();
        let values = values.filter(|values| !values.is_empty());
        let model = values.as_ref().map(|values| values.iter().sum::<f64>() / values.len() as f64);
        let extreme = |of: fn(f64, f64) -> f64| values.as_ref()?.iter().copied().reduce(of);
        let within = |(value, [low, high]): (f64, [f64; 2])| (low..=high).contains(&value);
        let Measure { title, unit, .. } = self.measure();
        Judgement {
            moment: self.moment,
            title,
            unit,
            people: self.people,
            people_halves: self.halves,
            band: self.band.map(|band| band.map(|end| (end.abs() < f64::MAX).then_some(end))),
            model,
            model_runs: extreme(f64::min).zip(extreme(f64::max)).map(|(low, high)| [low, high]),
            within: model.zip(self.band).map(within),
        }
    }

    /// Returns the definition of the moment.
    fn measure(&self) -> Measure {
        *MOMENTS.iter().find(|moment| moment.name == self.moment).expect("a criterion names a moment")
    }
}

/// Quantiles of the gaps of experiment A, m, at shares from 0 to 1 in steps of 0.025.
pub const GAP_QUANTILES_M: [f64; 41] = [
    1.94, 3.49, 4.01, 4.33, 4.61, 4.87, 5.07, 5.28, 5.47, 5.68, 5.88, 6.06, 6.22, 6.37, 6.52, 6.68, 6.83, 6.98, 7.13,
    7.28, 7.42, 7.57, 7.72, 7.89, 8.06, 8.26, 8.46, 8.66, 8.85, 9.04, 9.27, 9.56, 9.90, 10.23, 10.61, 11.07, 11.69,
    12.52, 13.70, 15.51, 25.42,
];

/// Experiment A of the Arizona ring: 20 people told to follow safely, as in rush hour traffic.
pub const EXPERIMENT_A: MeasuredTraffic = MeasuredTraffic {
    name: "experiment-a",
    title: "Arizona ring, experiment A: follow safely",
    ring_m: 260.0,
    vehicles: 20,
    from_to_s: [30.0, 390.0],
    criteria: &[
        people("mean_speed_mps", 3.134).halves(2.984, 3.283).within(0.157),
        people("speed_sd_over_vehicles_mps", 0.706).halves(0.635, 0.777).within(0.10),
        people("speed_sd_growth_per_min", 0.077).halves(0.115, 0.024).band(f64::MIN, 0.15),
        people("accel_sd_mps2", 0.292).halves(0.270, 0.312).within(0.029),
        people("accel_p01_mps2", -0.810).halves(-0.744, -0.893).band(-0.92, -0.68),
        people("accel_p99_mps2", 0.801).halves(0.736, 0.855).band(0.68, 0.92),
        people("accel_kurtosis", 5.97).halves(5.93, 5.82),
        people("brakings_per_km", 1.24).halves(1.02, 1.44).band(0.7, 1.8),
        people("standing_share", 0.0004).halves(0.0, 0.0008),
        people("gap_p05_m", 4.01).halves(4.13, 3.85),
        people("gap_p25_m", 5.88).halves(6.03, 5.67),
        people("gap_median_m", 7.42).halves(7.45, 7.39),
        people("gap_p75_m", 9.27).halves(9.17, 9.42),
        people("gap_p95_m", 13.70).halves(13.53, 13.85),
        people("smallest_gap_m", 1.94).halves(2.43, 1.94).band(1.5, f64::MAX),
        people("gap_distance_to_experiment_a", 0.0).halves(0.026, 0.026).band(0.0, 0.05),
        people("person_gap_sd_m", 2.05).halves(1.80, 2.15),
        people("person_time_gap_s", 2.444).halves(2.628, 2.250).within(0.122),
        people("shortest_person_time_gap_s", 1.66).halves(1.58, 1.58),
        people("longest_person_time_gap_s", 4.38).halves(4.61, 4.25),
        people("person_time_gap_ln_sd", 0.249).halves(0.252, 0.263).within(0.08),
        people("person_accel_ln_sd", 0.272).halves(0.250, 0.312).within(0.07),
        people("lag_s", 1.812).halves(1.718, 1.790).within(0.2),
        people("shortest_person_lag_s", 1.25).halves(0.88, 1.31).band(1.15, 2.85),
        people("longest_person_lag_s", 2.82).halves(3.77, 3.43).band(1.15, 2.85),
        people("gain_at_0_03_hz", 0.944).halves(0.933, 0.943).within(0.06),
        people("gain_at_0_06_hz", 0.820).halves(0.787, 0.844).within(0.06),
        people("gain_at_0_1_hz", 0.663).halves(0.681, 0.650).within(0.06),
        people("gain_at_0_15_hz", 0.486).halves(0.430, 0.529).within(0.06),
        people("wave_speed_mps", -4.25).halves(-5.0, -3.5).within(0.8),
        people("wave_share", 0.479).halves(0.411, 0.479).band(0.4, 0.6),
        people("gap_split_half_r", 0.89),
        people("time_gap_split_half_r", 0.87).band(0.85, 1.0),
        people("accel_split_half_r", 0.85).band(0.8, 1.0),
        people("noise_split_half_r", 0.82),
        people("lag_split_half_r", 0.52),
    ],
};

/// Experiments F to H of the Arizona ring: people told to close the gap whenever safety permits. Their data are not at hand: values are
/// those of the fit of experiment G, and few.
pub const EXPERIMENT_G: MeasuredTraffic = MeasuredTraffic {
    name: "experiment-g",
    title: "Arizona ring, experiment G: close the gap",
    ring_m: 260.0,
    vehicles: 21,
    from_to_s: [30.0, 390.0],
    criteria: &[
        people("mean_speed_mps", 5.5).band(5.5, 6.0),
        people("speed_sd_over_vehicles_mps", 3.2).band(2.5, 3.5),
        people("standing_share", 0.0).band(0.0, 0.01),
        people("brakings_per_km", 9.7),
    ],
};

/// SD of speed of the four people who follow in a platoon of five, m/s, in order, in two runs of OpenACC. A model of people that follows
/// the recorded first vehicle is like them within 5 %.
pub const OPENACC_SPEED_SD_MPS: [[f64; 4]; 2] = [[3.43, 3.32, 3.18, 3.20], [5.88, 5.70, 5.70, 5.53]];

/// All measured traffic, the default first.
pub const MEASURED: [&MeasuredTraffic; 2] = [&EXPERIMENT_A, &EXPERIMENT_G];

/// Returns a moment of people without halves and criterion.
const fn people(moment: &'static str, people: f64) -> Criterion {
    Criterion { moment, people, halves: None, band: None }
}

impl Criterion {
    /// Sets the values of the two halves of the measured time.
    const fn halves(self, first: f64, second: f64) -> Self {
        Self { halves: Some([first, second]), ..self }
    }

    /// Sets the band that counts as like people.
    const fn band(self, low: f64, high: f64) -> Self {
        Self { band: Some([low, high]), ..self }
    }

    /// Sets the band to the value for people, plus and minus a width.
    const fn within(self, width: f64) -> Self {
        self.band(self.people - width, self.people + width)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(mean_speed_mps: Option<f64>) -> TrafficMoments {
        let mut values = [None; MOMENTS.len()];
        values[0] = mean_speed_mps;
        TrafficMoments { values }
    }

    #[test]
    fn every_criterion_names_a_moment_and_people_are_within_their_own_bands() {
        for criterion in MEASURED.iter().flat_map(|traffic| traffic.criteria) {
            assert!(!criterion.measure().title.is_empty());
            if let Some([low, high]) = criterion.band {
                assert!((low..=high).contains(&criterion.people), "{criterion:?}");
            }
        }
        assert!(MOMENTS.iter().all(|moment| EXPERIMENT_A.criteria.iter().any(|known| known.moment == moment.name)));
    }

    #[test]
    fn the_mean_over_the_runs_is_judged() {
        let judged = judge(&EXPERIMENT_A, &[run(Some(3.0)), run(Some(3.4))]);
        let mean = &judged[0];
        assert_eq!((mean.model, mean.model_runs, mean.within), (Some(3.2), Some([3.0, 3.4]), Some(true)));
        assert_eq!(judge(&EXPERIMENT_A, &[run(Some(3.4))])[0].within, Some(false));
        let missing = &judge(&EXPERIMENT_A, &[run(Some(3.0)), run(None)])[0];
        assert_eq!((missing.model, missing.model_runs, missing.within), (None, None, None));
    }
}
