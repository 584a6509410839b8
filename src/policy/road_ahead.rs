//! What the road ahead of the ego has, as a policy may see it, and which roads have it. In: a policy as it was read, and a kind of road.
//! Out: why it cannot advise there, or nothing. Metres, m/s.

use super::{
    Controller, CorrectedAdvice, ExpectedGain, Feature, Network, NetworkInput, PolicyError, PolicySettings,
    PolicySource, SourceKind,
};
use crate::map::network::Side;

/// What stands for a distance where there is nothing to measure one to, metres.
pub const FAR_M: f64 = 1000.0;

/// A vehicle behind the ego, or ahead of it or behind in a lane beside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearVehicle {
    /// From the front bumper of the one behind to the rear bumper of the one ahead, metres; below 0 where they are side by side.
    pub gap_m: f64,
    /// Its speed, m/s.
    pub speed_mps: f64,
}

/// A lane beside the ego's in the same direction, and who is nearest there. Of those side by side with the ego who has the front bumper ahead of
/// the ego's, or as far, is the leader.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LaneBeside {
    /// The next one ahead.
    pub leader: Option<NearVehicle>,
    /// The next one behind.
    pub follower: Option<NearVehicle>,
}

/// The next signal of the ego's path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignalAhead {
    /// The ego's front bumper to its line, metres.
    pub distance_m: f64,
    /// It shows green.
    pub is_green: bool,
}

/// The road ahead in a whole drive; rings of training have none of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RoadAhead {
    /// Speed limit where the ego is, m/s.
    pub speed_limit_mps: f64,
    /// Curvature of the path where the ego is in three seconds, 1/m, positive to the left.
    pub bend_per_m: f64,
    /// Who drives behind the ego.
    pub follower: Option<NearVehicle>,
    /// The lane to its left, if cars may drive there.
    pub left: Option<LaneBeside>,
    /// The lane to its right, if cars may drive there.
    pub right: Option<LaneBeside>,
    /// The next signal of its path.
    pub signal: Option<SignalAhead>,
    /// Its front bumper to the next line of its path where others go first and nobody has to stop for the line's own sake, metres.
    pub yield_line_m: Option<f64>,
    /// The same to the next line of a stop sign.
    pub stop_line_m: Option<f64>,
    /// The same to where its path must have changed lanes, as before an exit.
    pub lane_end_m: Option<f64>,
    /// Way to the end of its path, metres; `None` on a closed route.
    pub path_left_m: Option<f64>,
}

/// Where a policy is to advise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RoadKind {
    /// A ring of training and evaluation: cars and a length, and nothing else.
    BareRing,
    /// A whole drive on a closed route with a fixed number of cars.
    ClosedRoute,
    /// A whole drive along a path through a network.
    Network(LanesBeside),
}

/// On which sides of a path's own lanes other lanes lie, anywhere along it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LanesBeside {
    /// To the left.
    pub left: bool,
    /// To the right.
    pub right: bool,
}

impl RoadKind {
    /// True of a path through a network.
    fn is_network(self) -> bool {
        matches!(self, Self::Network(_))
    }

    /// The lanes beside a path; none elsewhere.
    fn lanes_beside(self) -> LanesBeside {
        if let Self::Network(beside) = self { beside } else { LanesBeside::default() }
    }
}

impl Feature {
    /// True if it can be seen on this kind of road.
    pub fn is_seen_on(self, road: RoadKind) -> bool {
        match self {
            Self::Circumference | Self::Spacing => !road.is_network(),
            Self::SpeedLimit | Self::BendAhead | Self::FollowerGap | Self::FollowerSpeed => road != RoadKind::BareRing,
            Self::SignalDistance | Self::SignalGreen | Self::PathLeft => road.is_network(),
            Self::YieldDistance | Self::StopDistance | Self::LaneEndDistance => road.is_network(),
            _ if self.is_of_lane_to(Side::Left) => road.lanes_beside().left,
            _ if self.is_of_lane_to(Side::Right) => road.lanes_beside().right,
            _ => true,
        }
    }

    /// True of what is seen in the lane beside the ego's on this side.
    fn is_of_lane_to(self, side: Side) -> bool {
        use Feature::{LeftFollowerGap, LeftFollowerSpeed, LeftLeaderGap, LeftLeaderSpeed};
        use Feature::{RightFollowerGap, RightFollowerSpeed, RightLeaderGap, RightLeaderSpeed};
        match side {
            Side::Left => matches!(self, LeftLeaderGap | LeftLeaderSpeed | LeftFollowerGap | LeftFollowerSpeed),
            Side::Right => matches!(self, RightLeaderGap | RightLeaderSpeed | RightFollowerGap | RightFollowerSpeed),
        }
    }

    /// Why this kind of road has it not, in words that follow its name.
    fn why_unseen(self, road: RoadKind) -> &'static str {
        match road {
            RoadKind::Network(_) if self.is_of_lane_to(Side::Left) => "and its path has no lane to the left of its own",
            RoadKind::Network(_) if self.is_of_lane_to(Side::Right) => {
                "and its path has no lane to the right of its own"
            }
            _ => "which is not to be had",
        }
    }
}

impl PolicySource {
    /// The policy of this name for rings of training and evaluation.
    ///
    /// # Errors
    /// As [`PolicySource::read`] has them, or it sees what only a whole drive has.
    pub fn for_rings(name: &str, settings: &PolicySettings) -> Result<Self, PolicyError> {
        let source = Self::read(name, settings)?;
        match source.lacks(RoadKind::BareRing) {
            Some(why) => Err(PolicyError::NotOnRings { name: name.into(), why }),
            None => Ok(source),
        }
    }

    /// Why it cannot advise on this kind of road, in words that follow "it"; `None` where it can.
    pub fn lacks(&self, road: RoadKind) -> Option<String> {
        match &self.kind {
            SourceKind::NoAdvice => None,
            SourceKind::Controller(controller) => lacked_by_controller(controller, road),
            SourceKind::Network(network) => lacked_by_network(network, road),
            SourceKind::Onnx(policy) => policy.lacks(road),
        }
    }
}

fn lacked_by_controller(controller: &Controller, road: RoadKind) -> Option<String> {
    let is_for_wave = matches!(controller, Controller::TwoPhase(_)) && road.is_network();
    is_for_wave.then(|| "opens a hole that swallows the wave of a closed route".to_owned())
}

fn lacked_by_network(network: &Network, road: RoadKind) -> Option<String> {
    lacked(&network.inputs, network.least_spacing_m, network.corrected.as_ref(), network.expected_gain.as_ref(), road)
}

/// What a network with these inputs lacks, and what it corrects.
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
        return Some(format!("withholds advice below {least_spacing_m} m of closed route for each car"));
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
    use crate::policy::FEATURES;

    const SETTINGS: PolicySettings = PolicySettings { aim_mps: 4.0, equilibrium_mps: 4.0, step_s: 0.1 };

    /// A path beside which lanes lie on both sides.
    const NETWORK: RoadKind = RoadKind::Network(LanesBeside { left: true, right: true });

    fn lacks(name: &str, road: RoadKind) -> Option<String> {
        PolicySource::read(name, &SETTINGS).expect("a policy").lacks(road)
    }

    #[test]
    fn each_kind_of_road_has_what_it_has() {
        let unseen = |road| FEATURES.into_iter().filter(|f| !f.is_seen_on(road)).map(Feature::name).collect::<Vec<_>>();
        assert_eq!(unseen(NETWORK), ["circumference", "spacing"]);
        let right = ["right_leader_gap", "right_leader_speed", "right_follower_gap", "right_follower_speed"];
        let left = ["left_leader_gap", "left_leader_speed", "left_follower_gap", "left_follower_speed"];
        let one_lane_left = RoadKind::Network(LanesBeside { left: true, right: false });
        assert_eq!(unseen(one_lane_left), [&["circumference", "spacing"][..], &right].concat());
        let of_networks =
            ["signal_distance", "signal_green", "yield_distance", "stop_distance", "lane_end_distance", "path_left"];
        assert_eq!(unseen(RoadKind::ClosedRoute), [&left[..], &right, &of_networks].concat());
        let of_drives = ["speed_limit", "bend_ahead", "follower_gap", "follower_speed"];
        assert_eq!(unseen(RoadKind::BareRing), [&of_drives[..], &unseen(RoadKind::ClosedRoute)].concat());
    }

    #[test]
    fn a_policy_lacks_what_it_sees_or_corrects_and_the_road_has_not() {
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
        let told = lacks(&beside, RoadKind::Network(LanesBeside::default())).expect("one lane has none beside it");
        assert_eq!(told, "sees `left_leader_gap`, and its path has no lane to the left of its own");
        assert_eq!(lacks(&beside, NETWORK), None);
        let signal = of("", "signal_distance", "");
        let told = lacks(&signal, RoadKind::ClosedRoute).expect("there are no signals");
        assert!(told.contains("`signal_distance`"), "{told}");
        assert_eq!(lacks(&signal, NETWORK), None);
        let refused = PolicySource::for_rings(&signal, &SETTINGS).err().expect("a ring has no signals").to_string();
        assert!(refused.contains("`signal_distance`") && refused.contains("remedy: codrive run"), "{refused}");
    }
}
