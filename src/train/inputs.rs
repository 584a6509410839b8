//! Inputs of a policy and their scaling, for training rings and whole drives. In: names of features and a [`Scaling`]. Out:
//! [`NetworkInput`]s, or the reason that a name is refused.

use super::config::Scaling;
use crate::{
    driver::LONGEST_REACTION_S,
    policy::{FEATURES, Feature, NetworkInput},
    toml_text::did_you_mean,
};

/// Curvature scaled to 1 (and to -1 to the right), 1/m: a turn at an intersection with a radius of 10 m.
const TIGHT_BEND_PER_M: f64 = 0.1;
/// Time ahead of a line that is scaled to 1, s, at the speed scaled to 1: from 10 m/s a driver braking with 1 m/s² stops in 50 m.
const LINE_AHEAD_S: f64 = 10.0;

/// Returns the scaled inputs for comma-separated names; unknown names are skipped ([`check_names`] refuses them).
pub fn inputs(sees: &str, scaling: &Scaling) -> Vec<NetworkInput> {
    names(sees).filter_map(Feature::named).map(|feature| input(feature, scaling)).collect()
}

/// Checks that every name is a feature.
///
/// # Errors
/// The unknown name in `sees`, and the known ones.
pub fn check_names(sees: &str) -> Result<(), String> {
    let known = || FEATURES.map(Feature::name);
    match names(sees).find(|name| Feature::named(name).is_none()) {
        None => Ok(()),
        Some(name) => {
            let near = did_you_mean(name, &known());
            Err(format!("sees names `{name}`{near}; allowed: {}", known().join(", ")))
        }
    }
}

fn names(sees: &str) -> impl Iterator<Item = &str> {
    sees.split(',').map(str::trim)
}

fn input(feature: Feature, s: &Scaling) -> NetworkInput {
    let (from, to) = match feature {
        Feature::Speed
        | Feature::LeaderSpeed
        | Feature::MeanSpeed
        | Feature::ControllerSpeed
        | Feature::Advised
        | Feature::RingMeanSpeed
        | Feature::SpeedLimit
        | Feature::FollowerSpeed
        | Feature::LeftLeaderSpeed
        | Feature::LeftFollowerSpeed
        | Feature::RightLeaderSpeed
        | Feature::RightFollowerSpeed => (0.0, s.speed_to_mps),
        Feature::RelativeSpeed | Feature::WaveCos1 | Feature::WaveSin1 | Feature::WaveCos2 | Feature::WaveSin2 => {
            (-s.speed_to_mps / 2.0, s.speed_to_mps / 2.0)
        }
        Feature::Gap
        | Feature::Headway
        | Feature::FollowerGap
        | Feature::LeftLeaderGap
        | Feature::LeftFollowerGap
        | Feature::RightLeaderGap
        | Feature::RightFollowerGap => (0.0, s.gap_to_m),
        Feature::Circumference => (s.circumference_from_m, s.circumference_to_m),
        Feature::Spacing => (s.spacing_from_m, s.spacing_to_m),
        Feature::RingSpeedSd => (0.0, s.speed_to_mps / 2.0),
        // 0.1 s to 30 s.
        Feature::LogHold => (0.1_f64.ln(), 30.0_f64.ln()),
        Feature::BendAhead => (-TIGHT_BEND_PER_M, TIGHT_BEND_PER_M),
        Feature::SignalDistance
        | Feature::YieldDistance
        | Feature::StopDistance
        | Feature::LaneEndDistance
        | Feature::PathLeft => (0.0, LINE_AHEAD_S * s.speed_to_mps),
        Feature::SignalGreen => (0.0, 1.0),
        Feature::Reaction | Feature::ObservedReaction => (0.0, LONGEST_REACTION_S),
        Feature::ObservedTimeGapFactor => (0.5, 1.5),
        // PeRP's drivers exceed this range; people do not.
        Feature::ObservedDeviation | Feature::Deviation | Feature::SpeedBias => (-2.0, 2.0),
        Feature::TrackingError | Feature::Willingness => (0.0, 1.0),
        Feature::TimeGapFactor => (0.5, 1.5),
        // Covers 19 of 20 drivers: latents are distributed about as N(0, 1).
        Feature::Latent1 | Feature::Latent2 | Feature::Latent3 | Feature::Latent4 => (-2.0, 2.0),
    };
    NetworkInput { feature, from, to }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::policy::{Observation, RoadAhead, SignalAhead};

    #[test]
    fn every_feature_has_a_scale_and_a_wrong_name_is_refused_with_all_names() {
        let all = FEATURES.map(Feature::name).join(", ");
        let scaled = inputs(&all, &Scaling::default());
        assert_eq!(scaled.len(), FEATURES.len());
        assert!(scaled.iter().all(NetworkInput::is_sound));
        assert_eq!(check_names(&all), Ok(()));
        let fault = check_names("speed, gapp").unwrap_err();
        assert!(fault.starts_with("sees names `gapp` (did you mean gap?); allowed: speed, "), "{fault}");
    }

    #[test]
    fn features_of_whole_drives_are_scaled_like_similar_features() {
        let road = RoadAhead {
            speed_limit_mps: 15.0,
            bend_per_m: -0.05,
            signal: Some(SignalAhead { distance_m: 25.0, is_green: false }),
            ..RoadAhead::default()
        };
        let seen = Observation { road, ..Observation::default() };
        let of = |name: &str| inputs(name, &Scaling::default())[0].scaled(&seen);
        // 15 of 10 m/s; half of a turn's curvature to the right; 25 of 100 m; red; no follower: 1 km of 30 m.
        let expected = [2.0, -0.5, -0.5, -1.0];
        assert_eq!(["speed_limit", "bend_ahead", "signal_distance", "signal_green"].map(of), expected);
        assert!((of("follower_gap") - (2.0 * 1000.0 / 30.0 - 1.0)).abs() < 1e-4);
    }
}
