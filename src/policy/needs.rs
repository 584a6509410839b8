//! Needs of policies from the road. In: a policy and a kind of road. Out: the reason that the policy cannot advise there, or nothing.

use super::{Controller, CorrectedAdvice, ExpectedGain, Feature, Network, NetworkInput, RoadKind};
use crate::map::network::Side;

impl Feature {
    /// Returns true if the feature is available on this kind of road.
    pub fn is_seen_on(self, road: RoadKind) -> bool {
        match self {
            Self::Circumference | Self::Spacing => !road.is_network(),
            Self::SpeedLimit | Self::BendAhead | Self::FollowerGap | Self::FollowerSpeed => road != RoadKind::BareRing,
            Self::SignalDistance | Self::SignalGreen | Self::PathLeft => road.is_network(),
            Self::YieldDistance | Self::StopDistance | Self::LaneEndDistance => road.is_network(),
            _ if self.is_of_whole_ring() => road == RoadKind::BareRing,
            _ if self.is_of_lane_to(Side::Left) => road.lanes_beside().left,
            _ if self.is_of_lane_to(Side::Right) => road.lanes_beside().right,
            _ => true,
        }
    }

    /// Returns true for features of the vehicle behind the ego.
    pub fn is_of_follower(self) -> bool {
        matches!(self, Self::FollowerGap | Self::FollowerSpeed)
    }

    /// Returns true for features of the lane beside the ego's on this side.
    fn is_of_lane_to(self, side: Side) -> bool {
        use Feature::{LeftFollowerGap, LeftFollowerSpeed, LeftLeaderGap, LeftLeaderSpeed};
        use Feature::{RightFollowerGap, RightFollowerSpeed, RightLeaderGap, RightLeaderSpeed};
        match side {
            Side::Left => matches!(self, LeftLeaderGap | LeftLeaderSpeed | LeftFollowerGap | LeftFollowerSpeed),
            Side::Right => matches!(self, RightLeaderGap | RightLeaderSpeed | RightFollowerGap | RightFollowerSpeed),
        }
    }

    /// Returns the reason that this kind of road lacks the feature, in words that follow its name.
    fn why_unseen(self, road: RoadKind) -> &'static str {
        match road {
            RoadKind::Network(_) if self.is_of_lane_to(Side::Left) => "and its path has no lane to the left of its own",
            RoadKind::Network(_) if self.is_of_lane_to(Side::Right) => {
                "and its path has no lane to the right of its own"
            }
            _ => "which is not available",
        }
    }
}

pub(super) fn lacked_by_controller(controller: &Controller, road: RoadKind) -> Option<String> {
    let is_for_wave = matches!(controller, Controller::TwoPhase(_)) && road.is_network();
    is_for_wave.then(|| "opens a gap that absorbs the wave of a closed route".to_owned())
}

pub(super) fn lacked_by_network(network: &Network, road: RoadKind) -> Option<String> {
    lacked(&network.inputs, network.least_spacing_m, network.corrected.as_ref(), network.expected_gain.as_ref(), road)
}

/// Returns the reason that a network with these inputs, or the advice that it corrects, cannot advise on this kind of road.
pub(super) fn lacked(
    inputs: &[NetworkInput],
    least_spacing_m: f64,
    corrected: Option<&CorrectedAdvice>,
    gain: Option<&ExpectedGain>,
    road: RoadKind,
) -> Option<String> {
    let of_gain = gain.into_iter().flat_map(|gain| &gain.inputs);
    let unseen = inputs.iter().chain(of_gain).map(|input| input.feature).find(|feature| !feature.is_seen_on(road));
    if let Some(feature) = unseen {
        return Some(format!("sees `{}`, {}", feature.name(), feature.why_unseen(road)));
    }
    if least_spacing_m > 0.0 && road.is_network() {
        return Some(format!("withholds advice below {least_spacing_m} m of closed route per vehicle"));
    }
    match corrected {
        Some(CorrectedAdvice::Controller(controller)) => lacked_by_controller(controller, road),
        Some(CorrectedAdvice::Network(network)) => lacked_by_network(network, road),
        None => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::policy::{FEATURES, LanesBeside, PolicySettings, PolicySource};

    const SETTINGS: PolicySettings = PolicySettings { aim_mps: 4.0, equilibrium_mps: 4.0, step_s: 0.1 };

    /// A path with lanes on both sides.
    const NETWORK: RoadKind = RoadKind::Network(LanesBeside { left: true, right: true });

    fn lacks(name: &str, road: RoadKind) -> Option<String> {
        PolicySource::read(name, &SETTINGS).expect("a policy").lacks(road)
    }

    #[test]
    fn each_kind_of_road_provides_its_own_features() {
        let unseen = |road| FEATURES.into_iter().filter(|f| !f.is_seen_on(road)).map(Feature::name).collect::<Vec<_>>();
        let whole =
            ["deviation", "ring_mean_speed", "ring_speed_sd", "wave_cos_1", "wave_sin_1", "wave_cos_2", "wave_sin_2"];
        assert_eq!(unseen(NETWORK), [&["circumference", "spacing"][..], &whole].concat());
        let right = ["right_leader_gap", "right_leader_speed", "right_follower_gap", "right_follower_speed"];
        let left = ["left_leader_gap", "left_leader_speed", "left_follower_gap", "left_follower_speed"];
        let one_lane_left = RoadKind::Network(LanesBeside { left: true, right: false });
        assert_eq!(unseen(one_lane_left), [&["circumference", "spacing"][..], &right, &whole].concat());
        let of_networks =
            ["signal_distance", "signal_green", "yield_distance", "stop_distance", "lane_end_distance", "path_left"];
        assert_eq!(unseen(RoadKind::ClosedRoute), [&left[..], &right, &of_networks, &whole].concat());
        let of_drives = ["speed_limit", "bend_ahead", "follower_gap", "follower_speed"];
        assert_eq!(unseen(RoadKind::BareRing), [&of_drives[..], &left, &right, &of_networks].concat());
    }

    #[test]
    fn a_policy_lacks_the_inputs_and_advice_that_the_road_does_not_provide() {
        for name in ["none", "constant", "follower-stopper", "pi", "linear-feedback"] {
            assert_eq!(lacks(name, NETWORK), None, "{name}");
        }
        let ring = lacks("two-phase", NETWORK).expect("it is for a ring");
        assert!(ring.contains("closed route"), "{ring}");
        let shipped = lacks("ring-250-speed", NETWORK).expect("it was trained on rings");
        assert!(shipped.contains("circumference") || shipped.contains("spacing"), "{shipped}");
        for name in ["two-phase", "ring-250-speed"] {
            assert_eq!((lacks(name, RoadKind::BareRing), lacks(name, RoadKind::ClosedRoute)), (None, None), "{name}");
        }
        let folder = tempfile::tempdir().expect("a folder");
        let of = |head: &str, feature: &str, tail: &str| {
            let file = folder.path().join("policy.toml");
            let text = format!(
                "format = \"codrive policy 2\"\naction = \"speed\"\nlimits = [0.0, 10.0]\nspeed_change_mps = 0.0\n{head}levels = 0\n\
                 holds_s = [1.0, 1.0]\ninputs = [{{ feature = \"{feature}\", from = 0.0, to = 1.0 }}]\n\
                 [[layer]]\nbias = [0.0]\nweights = [[1.0]]\n{tail}"
            );
            std::fs::write(&file, text).expect("written");
            file.display().to_string()
        };
        assert_eq!(lacks(&of("", "gap", ""), NETWORK), None);
        let spacing = lacks(&of("least_spacing_m = 8.5\n", "gap", ""), NETWORK);
        assert!(spacing.expect("it is for a ring").contains("below 8.5 m"));
        let wave = of("", "gap", "[controller]\nkind = \"two-phase\"\nslow_mps = 2.0\nslow_s = 60.0\nthen_mps = 4.0\n");
        assert!(lacks(&wave, NETWORK).expect("it corrects what is for a ring").contains("closed route"));
        assert_eq!(lacks(&wave, RoadKind::ClosedRoute), None);
        let beside = of("", "left_leader_gap", "");
        let message = lacks(&beside, RoadKind::Network(LanesBeside::default())).expect("one lane has none beside it");
        assert_eq!(message, "sees `left_leader_gap`, and its path has no lane to the left of its own");
        assert_eq!(lacks(&beside, NETWORK), None);
        let signal = of("", "signal_distance", "");
        let message = lacks(&signal, RoadKind::ClosedRoute).expect("there are no signals");
        assert!(message.contains("`signal_distance`"), "{message}");
        assert_eq!(lacks(&signal, NETWORK), None);
        let refused = PolicySource::for_rings(&signal, &SETTINGS).expect_err("a ring has no signals").to_string();
        assert!(refused.contains("`signal_distance`") && refused.contains("remedy: use codrive run"), "{refused}");
    }
}
