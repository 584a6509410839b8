//! Samples of a driver, the input of the estimator. In: speeds, gap and advice. Out: scaled numbers, five times a second.

/// Length of one sample: advised minus own speed, own speed, leader's minus own speed, gap; each about -1 to 1.
pub const SAMPLE_NUMBERS: usize = 4;

/// Time between two samples, s: a fifth of the spread of people's reaction times.
pub const SAMPLE_S: f64 = 0.2;

/// Samples per update of the estimator, which runs once a second.
pub const SAMPLES: usize = 5;

/// Inputs of the recurrent unit: the samples, and 1 if an advice is in force, else 0.
pub const INPUTS: usize = SAMPLE_NUMBERS * SAMPLES + 1;

/// Inputs of the recurrent unit of a policy that observes its driver: those, and [`observed_inputs`].
pub const INPUTS_WITH_OBSERVED: usize = INPUTS + 2;

/// Returns the scaled reaction time and time gap of an observed driver, both given in s.
pub fn observed_inputs(reaction_s: f32, time_gap_factor: f32) -> [f32; 2] {
    [(reaction_s - 1.0) / 0.5, (time_gap_factor - 1.0) / 0.3]
}

/// Returns one scaled sample of a driver; speeds in m/s, the gap in m.
pub fn sample(speed_mps: f32, leader_mps: f32, gap_m: f32, advised_mps: Option<f32>) -> [f32; SAMPLE_NUMBERS] {
    let short_mps = advised_mps.map_or(0.0, |advised| advised - speed_mps);
    [short_mps / 2.0, speed_mps / 5.0 - 1.0, (leader_mps - speed_mps) / 2.0, (gap_m / 20.0 - 1.0).min(4.0)]
}
