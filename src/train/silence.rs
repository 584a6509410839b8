//! Learning when a policy should withhold advice. In: a configuration and a policy. Out: an [`ExpectedGain`], learned from paired drives.
//! A pair is one drive up to a moment, and continues from there once with the policy's advice and once without any. The target is the
//! gain of advice from that moment on; the inputs are the policy's knowledge of the road, the hold and the driver at that moment.
//!
//! Withholding as an additional action of the policy is a trap: without advice no advised speed is missed, nothing changes, and nothing
//! is learned. Seed 1 ended at 3.72 m/s that way instead of 4.06.

use super::{
    config::TrainConfig,
    environment::VecEnv,
    evaluation::Advisors,
    fitted_network::{Fit, FittedNetwork},
    net::Shape,
    simd::LANES,
};
use crate::{
    policy::{ExpectedGain, Feature, Network, NetworkInput},
    rng,
};
use rayon::prelude::*;

/// Moments at which pairs split, s after the first advice; the estimate of the driver is still forming in the first minute.
const LOOKS_S: [f64; 7] = [0.0, 15.0, 30.0, 60.0, 120.0, 240.0, 480.0];
/// Units of each of the two hidden layers.
const UNITS: usize = 32;
/// Learning rates of Adam in sequence, and passes over the data with each.
const RATES: [f64; 3] = [3e-3, 1e-3, 3e-4];
const EPOCHS: u32 = 12;
/// Steps per pass if there are few rows; rows per step if there are many.
const STEPS: usize = 32;
const MOST_ROWS: usize = 512;

/// Result of learning when to withhold advice.
#[derive(Clone, Debug, PartialEq)]
pub struct LearnedSilence {
    /// Predictor of the gain from advice.
    pub expected_gain: ExpectedGain,
    /// Number of paired drives.
    pub pairs: usize,
    /// Share of the rows on which the policy withholds advice.
    pub silent_share: f64,
    /// Root mean square error of the prediction of one ring's gain, m/s; mostly chance.
    pub error_mps: f64,
}

/// Observations and gains of paired drives.
#[derive(Clone, Debug, Default)]
struct PairedDrives {
    /// Rows of scaled inputs.
    seen: Vec<f32>,
    /// Gain of advice for each row, m/s.
    gain_mps: Vec<f32>,
}

/// Returns true for features that may predict the gain: those that advice itself does not change from moment to moment.
fn is_lasting(feature: Feature) -> bool {
    match feature {
        Feature::Circumference | Feature::Spacing | Feature::LogHold => true,
        other => other.is_of_driver(),
    }
}

impl TrainConfig {
    /// Returns the scaled inputs of the predictor: the lasting ones among the policy's inputs.
    pub fn lasting_inputs(&self) -> Vec<NetworkInput> {
        self.inputs().into_iter().filter(|input| is_lasting(input.feature)).collect()
    }
}

/// Runs paired drives on `config`'s rings and fits the predictor to them. `network` is the policy without a predictor.
pub fn learn(config: &TrainConfig, network: &Network) -> LearnedSilence {
    let inputs = config.lasting_inputs();
    let blocks = config.silence.silence_rings as usize / LANES;
    let pair = |index| drive_pair(config, network, &inputs, index);
    let pairs: Vec<PairedDrives> = (0..blocks).into_par_iter().map(pair).collect();
    let seen: Vec<f32> = pairs.iter().flat_map(|pair| &pair.seen).copied().collect();
    let gain_mps: Vec<f32> = pairs.iter().flat_map(|pair| &pair.gain_mps).copied().collect();
    let shape = Shape::new(&[inputs.len(), UNITS, UNITS, 1]);
    let mut stream = rng::stream(config.seed, "silence/fit");
    let mut fitted = FittedNetwork::new(&shape, &mut stream);
    let batch = (gain_mps.len() / STEPS).clamp(1, MOST_ROWS);
    let mut square = 0.0;
    for rate in RATES {
        square = fitted.fit(&shape, &seen, &gain_mps, &Fit { rate, epochs: EPOCHS, batch }, &mut stream);
    }
    let silent_below_mps = config.silence.silent_below_mps;
    let expected = fitted.estimate(&shape, &seen);
    let silent = expected.iter().filter(|gain| f64::from(**gain) < silent_below_mps).count();
    LearnedSilence {
        expected_gain: ExpectedGain { silent_below_mps, inputs, layers: fitted.layers(&shape) },
        pairs: blocks * LANES,
        silent_share: silent as f64 / expected.len().max(1) as f64,
        error_mps: square.sqrt(),
    }
}

/// Runs one block of rings with advice up to a moment, and from there once with advice and once without.
fn drive_pair(config: &TrainConfig, network: &Network, inputs: &[NetworkInput], index: usize) -> PairedDrives {
    let step_s = config.ring.step_s;
    let steps = |time_s: f64| (time_s / step_s).round() as u64;
    // Blocks are in order of their hold, so neighbours split at different moments.
    let look = steps(LOOKS_S[index % LOOKS_S.len()].min(config.ring.horizon_s / 2.0));
    let hold = config.hold_of(index, config.silence.silence_rings as usize / LANES);
    let mut advised = VecEnv::new(config, "silence", index, hold);
    let mut advisors = Advisors::new(config, hold, &|| Some(network.clone().policy(step_s)));
    for step in 0..look {
        advisors.advise(&mut advised, step);
        advised.step();
    }
    let mut pair = PairedDrives::default();
    for l in 0..LANES {
        let truth = advised.observe(l);
        let known = advisors.who_drives(l).map_or(truth, |driver| driver.complete_observation(&truth));
        pair.seen.extend(inputs.iter().map(|input| input.scaled(&known)));
    }
    let mut silent = advised.clone();
    (0..LANES).for_each(|l| silent.advise(l, None, hold));
    let (mut with, mut without) = (MeanSpeeds::default(), MeanSpeeds::default());
    for step in look..steps(config.ring.horizon_s) {
        advisors.advise(&mut advised, step);
        with.step(&mut advised);
        without.step(&mut silent);
    }
    let means = with.mps().into_iter().zip(without.mps());
    pair.gain_mps.extend(means.map(|(with_mps, without_mps)| with_mps - without_mps));
    pair
}

/// Mean speeds of all vehicles on sixteen rings; after a collision the vehicles count as stopped.
#[derive(Default)]
struct MeanSpeeds {
    sums_mps: [f32; LANES],
    has_crashed: [bool; LANES],
    steps: u32,
}

impl MeanSpeeds {
    /// Runs one step of the rings.
    fn step(&mut self, block: &mut VecEnv) {
        block.step();
        let ring = block.rings();
        self.steps += 1;
        for l in 0..LANES {
            self.has_crashed[l] |= block.least_gap_m(l) <= 0.0;
            if !self.has_crashed[l] {
                self.sums_mps[l] += ring.mean_mps()[l];
            }
        }
    }

    fn mps(&self) -> [f32; LANES] {
        self.sums_mps.map(|sum| sum / self.steps.max(1) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        policy::{NetworkLayer, Observation},
        train::{
            ActionKind, AdviceConfig, DriverConfig, FollowKind, Learner, NetworkConfig, RingConfig, SilenceConfig,
        },
    };

    /// Advice for drivers who always comply, on rings with 9 to 13 m of road per vehicle.
    fn config() -> TrainConfig {
        TrainConfig {
            advice: AdviceConfig { action: ActionKind::Speed, hold_s: 5.0, ..AdviceConfig::default() },
            ring: RingConfig {
                circumference_min_m: 200.0,
                circumference_max_m: 290.0,
                horizon_s: 300.0,
                ..RingConfig::default()
            },
            driver: DriverConfig {
                follow: FollowKind::Driver,
                error_mps: 0.0,
                random_driver: false,
                ..DriverConfig::default()
            },
            network: NetworkConfig { sees: "speed,spacing,log_hold".into(), ..NetworkConfig::default() },
            silence: SilenceConfig { silence_rings: 256, silent_below_mps: 0.0 },
            ..TrainConfig::default()
        }
    }

    /// Returns the policy that always advises `speed_mps`.
    fn constant(config: &TrainConfig, speed_mps: f32) -> Network {
        let mut network = Learner::new(config).best().0;
        let [low, high] = network.limits.map(|limit| limit as f32);
        let bias = vec![2.0 * (speed_mps - low) / (high - low) - 1.0];
        network.layers = vec![NetworkLayer { bias, weights: vec![vec![0.0]; network.inputs.len()] }];
        network
    }

    #[test]
    fn advice_that_slows_a_ring_is_withheld_and_out_of_reach_advice_gains_0() {
        let config = config();
        let on = |length_m: f64| Observation {
            circumference_m: length_m,
            vehicles: 22,
            hold_s: 5.0,
            ..Observation::default()
        };
        // `codrive evaluate --policy constant --policy-speed 2.5 --driver reaction=1 --holds 5 --horizon 300` on 285 m: 2.62 m/s, 4.08 without
        // advice. A calmed ring flows even faster than that once advice is withdrawn.
        let learned = learn(&config, &constant(&config, 2.5));
        let gain_mps = learned.expected_gain.gain_mps(&on(285.0));
        assert!(gain_mps < -1.4 && learned.expected_gain.asks_for_silence(&on(285.0)), "{gain_mps}");
        assert!(learned.pairs == 256 && learned.silent_share > 0.5, "{}", learned.silent_share);
        // No vehicle reaches 9 m/s on such rings, so both drives of a pair are the same.
        let learned = learn(&config, &constant(&config, 9.0));
        for length_m in [205.0, 245.0, 285.0] {
            let gain_mps = learned.expected_gain.gain_mps(&on(length_m));
            assert!(gain_mps.abs() < 0.02, "{length_m} m: {gain_mps}");
        }
    }

    #[test]
    fn the_predictor_has_lasting_inputs_only() {
        let sees = "speed,gap,spacing,mean_speed,controller_speed,log_hold,speed_bias";
        let config =
            TrainConfig { network: NetworkConfig { sees: sees.into(), ..NetworkConfig::default() }, ..config() };
        let features: Vec<Feature> = config.lasting_inputs().iter().map(|input| input.feature).collect();
        assert_eq!(features, [Feature::Spacing, Feature::LogHold, Feature::SpeedBias]);
    }
}
