//! The observation as a network sees it, shared by drives, training and ONNX networks. In: an [`Observation`], SI. Out: one number per
//! [`NetworkInput`], usually about -1 to 1. HC22's four inputs are own speed, leader's speed, gap and circumference, scaled as
//! docs/references.md: learning lists them.

use super::{FAR_M, LaneBeside, NearVehicle, Observation, identification::MOST_LATENTS};
use crate::space::CAR_LENGTH_M;
use serde::{Deserialize, Serialize};

/// A quantity that a network can take as input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Feature {
    /// Own speed, m/s.
    Speed,
    /// Leader's speed, m/s.
    LeaderSpeed,
    /// Leader's speed minus own speed, m/s (Flow's ring environment).
    RelativeSpeed,
    /// Own front bumper to the leader's rear bumper, m.
    Gap,
    /// Front bumper to front bumper, m.
    Headway,
    /// Length of the closed route, m.
    Circumference,
    /// Length of the closed route per vehicle, m.
    Spacing,
    /// Own mean speed over about the last half minute, m/s.
    MeanSpeed,
    /// Natural logarithm of the hold in seconds.
    LogHold,
    /// Speed limit at the ego, m/s.
    SpeedLimit,
    /// Curvature of the path at the ego's position in three seconds, 1/m, positive to the left.
    BendAhead,
    /// Follower's front bumper to own rear bumper, m; [`FAR_M`] without a follower.
    FollowerGap,
    /// Follower's speed, m/s; own speed without a follower.
    FollowerSpeed,
    /// Own front bumper to the rear bumper of the next vehicle ahead in the left lane, m, negative if side by side. [`FAR_M`] without a
    /// vehicle, 0 without a left lane.
    LeftLeaderGap,
    /// Speed of the next vehicle ahead in the left lane, m/s; own speed without one.
    LeftLeaderSpeed,
    /// Front bumper of the next vehicle behind in the left lane to own rear bumper, m; sign and defaults as for
    /// [`Feature::LeftLeaderGap`].
    LeftFollowerGap,
    /// Speed of the next vehicle behind in the left lane, m/s; own speed without one.
    LeftFollowerSpeed,
    /// Own front bumper to the rear bumper of the next vehicle ahead in the right lane, m, negative if side by side. [`FAR_M`] without a
    /// vehicle, 0 without a right lane.
    RightLeaderGap,
    /// Speed of the next vehicle ahead in the right lane, m/s; own speed without one.
    RightLeaderSpeed,
    /// Front bumper of the next vehicle behind in the right lane to own rear bumper, m; sign and defaults as for
    /// [`Feature::RightLeaderGap`].
    RightFollowerGap,
    /// Speed of the next vehicle behind in the right lane, m/s; own speed without one.
    RightFollowerSpeed,
    /// Own front bumper to the stop line of the next signal on the path, m; [`FAR_M`] without one.
    SignalDistance,
    /// State of the next signal: 1 for green or no signal, 0 otherwise.
    SignalGreen,
    /// Own front bumper to the next line of the path where the ego must yield, m, including a permissive green; [`FAR_M`] without one.
    YieldDistance,
    /// Own front bumper to the next stop-sign line, m; [`FAR_M`] without one.
    StopDistance,
    /// Own front bumper to the end of the next edge on which the path changes lanes (for example before an exit), m; [`FAR_M`] without
    /// one.
    LaneEndDistance,
    /// Distance to the end of the path, m; [`FAR_M`] without an end.
    PathLeft,
    /// Speed of the controller or policy that is corrected, m/s; own speed without one.
    ControllerSpeed,
    /// Target of the current advice, m/s; own speed without any.
    Advised,
    /// Driver's present deviation from the advised speed, observed from their own history, m/s.
    ObservedDeviation,
    /// Driver's time from a new advice to the first response, observed likewise, s.
    ObservedReaction,
    /// Driver's time gap as a multiple of the other vehicles' time gap, observed likewise.
    ObservedTimeGapFactor,
    /// Driver's present deviation from the speed that they seek, m/s; like all features of the whole ring known on simulated rings only.
    Deviation,
    /// Mean speed of all vehicles, m/s.
    RingMeanSpeed,
    /// Standard deviation of speed over all vehicles, m/s.
    RingSpeedSd,
    /// Cosine part of the wave of speeds around the ring, counted from the ego backwards, m/s.
    #[serde(rename = "wave_cos_1")]
    WaveCos1,
    /// Sine part of that wave, m/s.
    #[serde(rename = "wave_sin_1")]
    WaveSin1,
    /// Cosine part of the wave of half that length, m/s.
    #[serde(rename = "wave_cos_2")]
    WaveCos2,
    /// Sine part of the wave of half that length, m/s.
    #[serde(rename = "wave_sin_2")]
    WaveSin2,
    /// Driver's time from a new advice to the first response, s.
    Reaction,
    /// Driver's speed minus the advised speed, m/s.
    SpeedBias,
    /// Standard deviation of the driver's speed around their target speed, m/s.
    TrackingError,
    /// Driver's time gap as a multiple of the other vehicles' time gap.
    TimeGapFactor,
    /// Share of time in which the driver follows the advice.
    Willingness,
    /// First of up to four latents of the driver from a variational encoder, dimensionless; 0 if unknown.
    #[serde(rename = "latent_1")]
    Latent1,
    /// Second latent of the driver.
    #[serde(rename = "latent_2")]
    Latent2,
    /// Third latent of the driver.
    #[serde(rename = "latent_3")]
    Latent3,
    /// Fourth latent of the driver.
    #[serde(rename = "latent_4")]
    Latent4,
}

/// All features in the order in which messages list them.
pub const FEATURES: [Feature; 48] = [
    Feature::Speed,
    Feature::LeaderSpeed,
    Feature::RelativeSpeed,
    Feature::Gap,
    Feature::Headway,
    Feature::Circumference,
    Feature::Spacing,
    Feature::MeanSpeed,
    Feature::LogHold,
    Feature::SpeedLimit,
    Feature::BendAhead,
    Feature::FollowerGap,
    Feature::FollowerSpeed,
    Feature::LeftLeaderGap,
    Feature::LeftLeaderSpeed,
    Feature::LeftFollowerGap,
    Feature::LeftFollowerSpeed,
    Feature::RightLeaderGap,
    Feature::RightLeaderSpeed,
    Feature::RightFollowerGap,
    Feature::RightFollowerSpeed,
    Feature::SignalDistance,
    Feature::SignalGreen,
    Feature::YieldDistance,
    Feature::StopDistance,
    Feature::LaneEndDistance,
    Feature::PathLeft,
    Feature::ControllerSpeed,
    Feature::Advised,
    Feature::ObservedDeviation,
    Feature::ObservedReaction,
    Feature::ObservedTimeGapFactor,
    Feature::Deviation,
    Feature::RingMeanSpeed,
    Feature::RingSpeedSd,
    Feature::WaveCos1,
    Feature::WaveSin1,
    Feature::WaveCos2,
    Feature::WaveSin2,
    Feature::Reaction,
    Feature::SpeedBias,
    Feature::TrackingError,
    Feature::TimeGapFactor,
    Feature::Willingness,
    Feature::Latent1,
    Feature::Latent2,
    Feature::Latent3,
    Feature::Latent4,
];

/// Latent features of a variational encoder, in order.
pub const LATENTS: [Feature; MOST_LATENTS] = [Feature::Latent1, Feature::Latent2, Feature::Latent3, Feature::Latent4];

impl Feature {
    /// Returns true for features that [`DriverObserver`](super::DriverObserver) observes.
    pub fn is_observed(self) -> bool {
        matches!(self, Self::ObservedDeviation | Self::ObservedReaction | Self::ObservedTimeGapFactor)
    }

    /// Returns the name used in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Speed => "speed",
            Self::LeaderSpeed => "leader_speed",
            Self::RelativeSpeed => "relative_speed",
            Self::Gap => "gap",
            Self::Headway => "headway",
            Self::Circumference => "circumference",
            Self::Spacing => "spacing",
            Self::MeanSpeed => "mean_speed",
            Self::LogHold => "log_hold",
            Self::SpeedLimit => "speed_limit",
            Self::BendAhead => "bend_ahead",
            Self::FollowerGap => "follower_gap",
            Self::FollowerSpeed => "follower_speed",
            Self::LeftLeaderGap => "left_leader_gap",
            Self::LeftLeaderSpeed => "left_leader_speed",
            Self::LeftFollowerGap => "left_follower_gap",
            Self::LeftFollowerSpeed => "left_follower_speed",
            Self::RightLeaderGap => "right_leader_gap",
            Self::RightLeaderSpeed => "right_leader_speed",
            Self::RightFollowerGap => "right_follower_gap",
            Self::RightFollowerSpeed => "right_follower_speed",
            Self::SignalDistance => "signal_distance",
            Self::SignalGreen => "signal_green",
            Self::YieldDistance => "yield_distance",
            Self::StopDistance => "stop_distance",
            Self::LaneEndDistance => "lane_end_distance",
            Self::PathLeft => "path_left",
            Self::ControllerSpeed => "controller_speed",
            Self::Advised => "advised",
            Self::ObservedDeviation => "observed_deviation",
            Self::ObservedReaction => "observed_reaction",
            Self::ObservedTimeGapFactor => "observed_time_gap_factor",
            Self::Deviation => "deviation",
            Self::RingMeanSpeed => "ring_mean_speed",
            Self::RingSpeedSd => "ring_speed_sd",
            Self::WaveCos1 => "wave_cos_1",
            Self::WaveSin1 => "wave_sin_1",
            Self::WaveCos2 => "wave_cos_2",
            Self::WaveSin2 => "wave_sin_2",
            Self::Reaction => "reaction",
            Self::SpeedBias => "speed_bias",
            Self::TrackingError => "tracking_error",
            Self::TimeGapFactor => "time_gap_factor",
            Self::Willingness => "willingness",
            Self::Latent1 => "latent_1",
            Self::Latent2 => "latent_2",
            Self::Latent3 => "latent_3",
            Self::Latent4 => "latent_4",
        }
    }

    /// Returns the feature with this name.
    pub fn named(name: &str) -> Option<Self> {
        FEATURES.into_iter().find(|feature| feature.name() == name)
    }

    /// Returns true for traits and latents of the driver: inputs that a teacher is given and an estimator estimates.
    pub fn is_of_driver(self) -> bool {
        use Feature::{Reaction, SpeedBias, TimeGapFactor, TrackingError, Willingness};
        matches!(self, Reaction | SpeedBias | TrackingError | TimeGapFactor | Willingness) || self.is_latent()
    }

    /// Returns true for features of the whole ring and of the driver's present state, unknown on real roads.
    pub fn is_of_whole_ring(self) -> bool {
        use Feature::{Deviation, RingMeanSpeed, RingSpeedSd, WaveCos1, WaveCos2, WaveSin1, WaveSin2};
        matches!(self, Deviation | RingMeanSpeed | RingSpeedSd | WaveCos1 | WaveSin1 | WaveCos2 | WaveSin2)
    }

    /// Returns true for the latents of a variational encoder.
    pub fn is_latent(self) -> bool {
        LATENTS.contains(&self)
    }

    pub fn of(self, o: &Observation) -> f64 {
        match self {
            Self::Speed => o.speed_mps,
            Self::LeaderSpeed => o.leader_speed_mps,
            Self::RelativeSpeed => o.leader_speed_mps - o.speed_mps,
            Self::Gap => o.gap_m,
            Self::Headway => o.gap_m + CAR_LENGTH_M,
            Self::Circumference => o.circumference_m,
            Self::Spacing => o.circumference_m / f64::from(o.vehicles.max(1)),
            Self::MeanSpeed => o.mean_speed_mps,
            Self::LogHold => o.hold_s.max(1e-3).ln(),
            Self::SpeedLimit => o.road.speed_limit_mps,
            Self::BendAhead => o.road.bend_per_m,
            Self::FollowerGap => o.road.follower.map_or(FAR_M, |follower| follower.gap_m),
            Self::FollowerSpeed => o.road.follower.map_or(o.speed_mps, |follower| follower.speed_mps),
            Self::LeftLeaderGap => gap_beside_m(o.road.left, |lane| lane.leader),
            Self::LeftLeaderSpeed => speed_beside_mps(o, o.road.left, |lane| lane.leader),
            Self::LeftFollowerGap => gap_beside_m(o.road.left, |lane| lane.follower),
            Self::LeftFollowerSpeed => speed_beside_mps(o, o.road.left, |lane| lane.follower),
            Self::RightLeaderGap => gap_beside_m(o.road.right, |lane| lane.leader),
            Self::RightLeaderSpeed => speed_beside_mps(o, o.road.right, |lane| lane.leader),
            Self::RightFollowerGap => gap_beside_m(o.road.right, |lane| lane.follower),
            Self::RightFollowerSpeed => speed_beside_mps(o, o.road.right, |lane| lane.follower),
            Self::SignalDistance => o.road.signal.map_or(FAR_M, |signal| signal.distance_m),
            Self::SignalGreen => f64::from(u8::from(o.road.signal.is_none_or(|signal| signal.is_green))),
            Self::YieldDistance => o.road.yield_line_m.unwrap_or(FAR_M),
            Self::StopDistance => o.road.stop_line_m.unwrap_or(FAR_M),
            Self::LaneEndDistance => o.road.lane_end_m.unwrap_or(FAR_M),
            Self::PathLeft => o.road.path_left_m.unwrap_or(FAR_M),
            Self::ControllerSpeed => o.corrected_mps.unwrap_or(o.speed_mps),
            Self::Advised => o.advised_mps.unwrap_or(o.speed_mps),
            Self::ObservedDeviation => o.observed.deviation_mps,
            Self::ObservedReaction => o.observed.reaction_s,
            Self::ObservedTimeGapFactor => o.observed.time_gap_factor,
            Self::Deviation => o.ring.unwrap_or_default().deviation_mps,
            Self::RingMeanSpeed => o.ring.unwrap_or_default().mean_speed_mps,
            Self::RingSpeedSd => o.ring.unwrap_or_default().speed_sd_mps,
            Self::WaveCos1 => o.ring.unwrap_or_default().waves_mps[0][0],
            Self::WaveSin1 => o.ring.unwrap_or_default().waves_mps[0][1],
            Self::WaveCos2 => o.ring.unwrap_or_default().waves_mps[1][0],
            Self::WaveSin2 => o.ring.unwrap_or_default().waves_mps[1][1],
            Self::Reaction => o.driver.unwrap_or_default().reaction_s,
            Self::SpeedBias => o.driver.unwrap_or_default().speed_bias_mps,
            Self::TrackingError => o.driver.unwrap_or_default().error_mps,
            Self::TimeGapFactor => o.driver.unwrap_or_default().time_gap_factor,
            Self::Willingness => o.driver.unwrap_or_default().willingness,
            Self::Latent1 => o.latents[0],
            Self::Latent2 => o.latents[1],
            Self::Latent3 => o.latents[2],
            Self::Latent4 => o.latents[3],
        }
    }
}

/// Returns the gap to a vehicle in a lane beside, m: [`FAR_M`] without a vehicle, 0 without a lane.
fn gap_beside_m(lane: Option<LaneBeside>, vehicle_of: fn(LaneBeside) -> Option<NearVehicle>) -> f64 {
    lane.map_or(0.0, |lane| vehicle_of(lane).map_or(FAR_M, |vehicle| vehicle.gap_m))
}

/// Returns the speed of a vehicle in a lane beside, m/s; own speed without one.
fn speed_beside_mps(
    o: &Observation,
    lane: Option<LaneBeside>,
    vehicle_of: fn(LaneBeside) -> Option<NearVehicle>,
) -> f64 {
    lane.and_then(vehicle_of).map_or(o.speed_mps, |vehicle| vehicle.speed_mps)
}

/// One scaled input of a network.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NetworkInput {
    /// Quantity that is scaled.
    pub feature: Feature,
    /// Value that is scaled to -1.
    pub from: f64,
    /// Value that is scaled to 1.
    pub to: f64,
}

impl NetworkInput {
    /// Returns the scaled input.
    #[inline(always)]
    pub fn scaled(&self, observation: &Observation) -> f32 {
        (2.0 * (self.feature.of(observation) - self.from) / (self.to - self.from) - 1.0) as f32
    }

    /// Returns true if the range is finite and not empty.
    pub fn is_sound(&self) -> bool {
        self.from.is_finite() && self.to.is_finite() && self.to > self.from
    }
}

/// Largest absolute value of a scaled road length, or of the length per vehicle. The range -1 to 1 covers the rings that the scale is for;
/// twice that is accepted for similar rings. A constant of 29, as for 1.7 km in the scale of 200 to 300 m, would dominate all other inputs
/// of a network.
pub const LARGEST_LENGTH: f32 = 2.0;

/// Returns the first input that is a length of this road and lies beyond [`LARGEST_LENGTH`] in its scale.
pub fn length_out_of_scale<'inputs>(
    inputs: &'inputs [NetworkInput],
    road: &Observation,
) -> Option<&'inputs NetworkInput> {
    let is_length = |input: &&NetworkInput| matches!(input.feature, Feature::Circumference | Feature::Spacing);
    inputs.iter().filter(is_length).find(|input| input.scaled(road).abs() > LARGEST_LENGTH)
}

/// Returns true if a policy with this bound withholds advice on the whole road. Logs a warning the first time.
pub fn withholds_advice(observation: &Observation, least_spacing_m: f64) -> bool {
    // Only once per process: an evaluation has hundreds of policies.
    static SAID: std::sync::Once = std::sync::Once::new();
    let is_withheld = is_too_dense(observation, least_spacing_m);
    if is_withheld {
        SAID.call_once(|| {
            let (length_m, cars) = (observation.circumference_m, observation.vehicles);
            log::warn!("the policy withholds advice on {length_m:.0} m with {cars} vehicles: advice would slow them")
        });
    }
    is_withheld
}

/// Returns true if the route has less than `least_spacing_m` of road per vehicle.
fn is_too_dense(observation: &Observation, least_spacing_m: f64) -> bool {
    // Tolerates 1 mm: a ring drawn at exactly this spacing has been rounded.
    Feature::Spacing.of(observation) < least_spacing_m - 1e-3
}

/// HC22's four inputs with the field's scaling: v/10, v_lead/10, gap/300, (L-200)/100, each mapped from 0..1 to -1..1.
pub const FIELD_INPUTS: [NetworkInput; 4] = [
    NetworkInput { feature: Feature::Speed, from: 0.0, to: 10.0 },
    NetworkInput { feature: Feature::LeaderSpeed, from: 0.0, to: 10.0 },
    NetworkInput { feature: Feature::Gap, from: 0.0, to: 300.0 },
    NetworkInput { feature: Feature::Circumference, from: 200.0, to: 300.0 },
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::policy::{DriverTraits, RoadAhead, SignalAhead};
    use crate::policy::{ObservedDriver, WholeRing};

    #[test]
    fn the_default_is_the_scaling_of_the_field() {
        let scaled = |seen: Observation| FIELD_INPUTS.map(|input| input.scaled(&seen));
        let seen = Observation {
            speed_mps: 5.0,
            leader_speed_mps: 10.0,
            gap_m: 75.0,
            circumference_m: 250.0,
            ..Observation::default()
        };
        assert_eq!(scaled(seen), [0.0, 1.0, -0.5, 0.0]);
        assert_eq!(scaled(Observation { circumference_m: 200.0, ..Observation::default() }), [-1.0; 4]);
    }

    #[test]
    fn every_feature_has_its_own_number_and_finds_its_name() {
        let seen = Observation {
            speed_mps: 3.0,
            leader_speed_mps: 4.5,
            gap_m: 7.0,
            circumference_m: 250.0,
            vehicles: 20,
            hold_s: 10.0,
            mean_speed_mps: 2.5,
            advised_mps: Some(4.0),
            observed: ObservedDriver { deviation_mps: 0.35, reaction_s: 0.7, time_gap_factor: 1.3 },
            driver: Some(DriverTraits::of([1.2, -0.5, 0.4, 1.1, 0.8])),
            latents: [0.3, -1.3, 0.7, 2.1],
            corrected_mps: Some(3.5),
            ring: Some(WholeRing {
                mean_speed_mps: 2.9,
                speed_sd_mps: 1.9,
                waves_mps: [[0.6, -0.9], [0.15, -0.2]],
                deviation_mps: -0.45,
            }),
            road: RoadAhead {
                speed_limit_mps: 13.9,
                bend_per_m: -0.02,
                follower: Some(NearVehicle { gap_m: 8.0, speed_mps: 3.3 }),
                left: Some(LaneBeside {
                    leader: Some(NearVehicle { gap_m: -2.0, speed_mps: 3.6 }),
                    follower: Some(NearVehicle { gap_m: 21.0, speed_mps: 3.7 }),
                }),
                right: Some(LaneBeside {
                    leader: Some(NearVehicle { gap_m: 22.0, speed_mps: 3.8 }),
                    follower: Some(NearVehicle { gap_m: 23.0, speed_mps: 3.9 }),
                }),
                signal: Some(SignalAhead { distance_m: 80.0, is_green: false }),
                yield_line_m: Some(81.0),
                stop_line_m: Some(82.0),
                lane_end_m: Some(83.0),
                path_left_m: Some(400.0),
            },
        };
        let of_traffic = [3.0, 4.5, 1.5, 7.0, 12.0, 250.0, 12.5, 2.5, 10.0_f64.ln()];
        let beside = [-2.0, 3.6, 21.0, 3.7, 22.0, 3.8, 23.0, 3.9];
        let of_traffic =
            [&of_traffic[..], &[13.9, -0.02, 8.0, 3.3], &beside, &[80.0, 0.0, 81.0, 82.0, 83.0, 400.0, 3.5]].concat();
        let whole_ring = [4.0, 0.35, 0.7, 1.3, -0.45, 2.9, 1.9, 0.6, -0.9, 0.15, -0.2];
        let expected = [&of_traffic[..], &whole_ring, &[1.2, -0.5, 0.4, 1.1, 0.8, 0.3, -1.3, 0.7, 2.1]].concat();
        assert_eq!(FEATURES.len(), expected.len());
        for (feature, expected) in FEATURES.into_iter().zip(expected) {
            assert_eq!(feature.of(&seen), expected, "{}", feature.name());
            assert_eq!(Feature::named(feature.name()), Some(feature));
            assert_eq!(serde_json::to_value(feature).unwrap(), feature.name());
        }
        // Without a follower and without a signal.
        let alone = Observation { speed_mps: 3.0, ..Observation::default() };
        let road = [Feature::FollowerGap, Feature::FollowerSpeed, Feature::SignalDistance, Feature::SignalGreen];
        assert_eq!(road.map(|feature| feature.of(&alone)), [1000.0, 3.0, 1000.0, 1.0]);
        let lines = [Feature::YieldDistance, Feature::StopDistance, Feature::LaneEndDistance];
        assert_eq!(lines.map(|feature| feature.of(&alone)), [1000.0; 3]);
        // With an empty lane on the left and no lane on the right.
        let left = Some(LaneBeside::default());
        let beside = Observation { road: RoadAhead { left, ..alone.road }, ..alone };
        let gaps =
            [Feature::LeftLeaderGap, Feature::LeftFollowerGap, Feature::RightLeaderGap, Feature::RightFollowerGap];
        assert_eq!(gaps.map(|feature| feature.of(&beside)), [1000.0, 1000.0, 0.0, 0.0]);
        let speeds = [Feature::LeftLeaderSpeed, Feature::RightFollowerSpeed];
        assert_eq!(speeds.map(|feature| feature.of(&beside)), [3.0; 2]);
    }

    #[test]
    fn a_road_is_too_dense_below_the_bound_and_never_without_one() {
        let ring = |vehicles| Observation { circumference_m: 210.0, vehicles, ..Observation::default() };
        assert!(is_too_dense(&ring(25), 8.5) && !is_too_dense(&ring(24), 8.5));
        // 8.4 m per vehicle; a spacing equal to the bound is not too dense.
        assert!(!is_too_dense(&ring(25), 8.4) && !is_too_dense(&ring(26), 0.0));
    }

    #[test]
    fn a_range_without_width_is_unsound() {
        let input = NetworkInput { feature: Feature::Gap, from: 0.0, to: 1.0 };
        assert!(input.is_sound() && !NetworkInput { to: 0.0, ..input }.is_sound());
        assert!(!NetworkInput { to: f64::NAN, ..input }.is_sound());
    }
}
