//! What a policy sees and how it is scaled: on the rings of training and in whole drives alike. In: names of features and a [`Scaling`].
//! Out: [`NetworkInput`]s, or why these names cannot be seen.

use super::config::Scaling;
use crate::{
    driver::LONGEST_REACTION_S,
    policy::{FEATURES, Feature, NetworkInput},
    toml_text::did_you_mean,
};

/// The curvature that becomes 1, and -1 to the right, 1/m: a turn at a crossing, with a radius of 10 m.
const TIGHT_BEND_PER_M: f64 = 0.1;
/// How far ahead of a line it becomes 1, seconds at the speed that becomes 1: from 10 m/s a driver who brakes with 1 m/s2 stands in 50 m.
const LINE_AHEAD_S: f64 = 10.0;

/// What these names, with commas between them, stand for, scaled; unknown names are left out ([`check_names`] refuses them).
pub fn inputs(sees: &str, scaling: &Scaling) -> Vec<NetworkInput> {
    names(sees).filter_map(Feature::named).map(|feature| input(feature, scaling)).collect()
}

/// Fails at a name that no feature has.
///
/// # Errors
/// What is wrong with `sees`, and what is allowed.
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
        | Feature::SpeedLimit
        | Feature::FollowerSpeed
        | Feature::LeftLeaderSpeed
        | Feature::LeftFollowerSpeed
        | Feature::RightLeaderSpeed
        | Feature::RightFollowerSpeed => (0.0, s.speed_to_mps),
        Feature::RelativeSpeed => (-s.speed_to_mps / 2.0, s.speed_to_mps / 2.0),
        Feature::Gap
        | Feature::Headway
        | Feature::FollowerGap
        | Feature::LeftLeaderGap
        | Feature::LeftFollowerGap
        | Feature::RightLeaderGap
        | Feature::RightFollowerGap => (0.0, s.gap_to_m),
        Feature::Circumference => (s.circumference_from_m, s.circumference_to_m),
        Feature::Spacing => (s.spacing_from_m, s.spacing_to_m),
        // 0.1 s to 30 s.
        Feature::LogHold => (0.1_f64.ln(), 30.0_f64.ln()),
        Feature::BendAhead => (-TIGHT_BEND_PER_M, TIGHT_BEND_PER_M),
        Feature::SignalDistance
        | Feature::YieldDistance
        | Feature::StopDistance
        | Feature::LaneEndDistance
        | Feature::PathLeft => (0.0, LINE_AHEAD_S * s.speed_to_mps),
        Feature::SignalGreen => (0.0, 1.0),
        Feature::Reaction => (0.0, LONGEST_REACTION_S),
        // PeRP's drivers go beyond it; people do not.
        Feature::SpeedBias => (-2.0, 2.0),
        Feature::TrackingError | Feature::Willingness => (0.0, 1.0),
        Feature::TimeGapFactor => (0.5, 1.5),
        // 19 of 20 drivers: latents are spread about as N(0, 1).
        Feature::Latent1 | Feature::Latent2 | Feature::Latent3 | Feature::Latent4 => (-2.0, 2.0),
    };
    NetworkInput { feature, from, to }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::policy::{Observation, RoadAhead, SignalAhead};

    #[test]
    fn every_feature_has_a_scale_and_a_wrong_name_is_answered_with_all_of_them() {
        let all = FEATURES.map(Feature::name).join(", ");
        let scaled = inputs(&all, &Scaling::default());
        assert_eq!(scaled.len(), FEATURES.len());
        assert!(scaled.iter().all(NetworkInput::is_sound));
        assert_eq!(check_names(&all), Ok(()));
        let fault = check_names("speed, gapp").unwrap_err();
        assert!(fault.starts_with("sees names `gapp` (did you mean gap?); allowed: speed, "), "{fault}");
    }

    #[test]
    fn what_only_whole_drives_have_is_scaled_as_its_like() {
        let road = RoadAhead {
            speed_limit_mps: 15.0,
            bend_per_m: -0.05,
            signal: Some(SignalAhead { distance_m: 25.0, is_green: false }),
            ..RoadAhead::default()
        };
        let seen = Observation { road, ..Observation::default() };
        let of = |name: &str| inputs(name, &Scaling::default())[0].scaled(&seen);
        // 15 of 10 m/s; half of a turn's curvature to the right; 25 of 100 m; red; nobody behind: 1 km of 30 m.
        let expected = [2.0, -0.5, -0.5, -1.0];
        assert_eq!(["speed_limit", "bend_ahead", "signal_distance", "signal_green"].map(of), expected);
        assert!((of("follower_gap") - (2.0 * 1000.0 / 30.0 - 1.0)).abs() < 1e-4);
    }
}
