//! Places of signals: at the end of each lane whose way has a light, across the junction, and at both ends of crossings. In: the network, its
//! paved surfaces. Out: [`SignalPlace`]s, metres.

use super::road_surfaces::RoadSurfaces;
use crate::{
    map::{
        network::{Connection, EdgeId, EdgeKind, LaneId, LanePosition, Network, SignalId, SignalLight, TurnDirection},
        surroundings::BESIDE_M,
    },
    space::Pose3,
};
use glam::{Vec2, Vec3};

/// Radius of the poles of signals, lamps and signs, metres.
pub const POLE_RADIUS_M: f32 = 0.06;
/// Distance of the pole of a head for those who walk from the crossing's end and side, metres.
const BEYOND_CROSSING_M: f32 = 0.4;
const BESIDE_CROSSING_M: f64 = 0.25;
/// Distance of a pole behind its head, metres.
const BEHIND_M: f32 = 0.22;
const BEHIND_WALKERS_M: f32 = 0.15;
/// Distance of the pole of a head for bicycles from the edge of their lane, metres: between it and the pole of the heads for cars.
const BESIDE_BICYCLES_M: f64 = 0.3;
/// Distance between heads and the end of the lane, metres: at the far edge of the stop line.
const BEFORE_END_M: f64 = 0.15;
/// Least distance of a head across the junction from the stop line where the way is not straight on, metres, and its largest distance to one
/// side as a share of that: it is in the picture then.
const LEAST_ACROSS_M: f32 = 10.0;
const ASIDE_SHARE: f32 = 0.45;
/// Maximum distance of a head across the junction from the stop line, metres.
const ACROSS_M: f32 = 45.0;

/// Signals of an edge, or of a crossing.
#[derive(Clone, Debug, PartialEq)]
pub enum SignalPlace {
    /// End of an edge with signals for vehicles.
    Approach(SignalledApproach),
    /// Ends of a crossing.
    Crossing([CrossingEnd; 2]),
}

/// End of an edge with signals.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalledApproach {
    /// Point on the ground below the head beside the stop line.
    pub foot: Vec3,
    /// Vector from heads to their poles and arms.
    pub behind: Vec3,
    /// Lanes with signals, from the outermost.
    pub lanes: Vec<SignalledLane>,
}

/// Place of the head of a lane before the junction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HeadPlace {
    /// On the pole beside the stop line.
    Pole,
    /// On the arm of that pole, over the lane.
    Arm,
    /// On a pole of its own over this point on the ground: for bicycles.
    OwnPole(Vec3),
}

/// Lane with a signal at its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignalledLane {
    pub lane: LaneId,
    pub signal: SignalId,
    /// Index of the link whose state is shown, among the signal's links.
    pub link: u32,
    /// Direction of the way whose light is shown.
    pub direction: TurnDirection,
    /// Middle of the lane at the stop line.
    pub line: Pose3,
    pub place: HeadPlace,
    /// Point on the ground below the head across the junction; `None` without one.
    pub across: Option<Vec3>,
}

/// End of a crossing with a signal for those who walk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CrossingEnd {
    pub lane: LaneId,
    pub signal: SignalId,
    pub link: u32,
    /// Point on the ground below the head.
    pub foot: Vec3,
    /// Unit vector away from the road.
    pub outwards: Vec3,
}

impl SignalPlace {
    /// Returns the feet of all poles.
    pub fn poles(&self) -> Vec<Vec3> {
        match self {
            Self::Approach(approach) => {
                let lanes = || approach.lanes.iter();
                let own = lanes().filter_map(|lane| match lane.place {
                    HeadPlace::OwnPole(foot) => Some(foot),
                    HeadPlace::Pole | HeadPlace::Arm => None,
                });
                let main = approach.has_pole().then_some(approach.foot);
                let feet = lanes().filter_map(|lane| lane.across).chain(own).chain(main);
                feet.map(|foot| foot + approach.behind).collect()
            }
            Self::Crossing(ends) => ends.iter().map(CrossingEnd::pole).collect(),
        }
    }
}

impl SignalledApproach {
    /// Checks whether there is a pole with the heads for cars.
    pub fn has_pole(&self) -> bool {
        self.lanes.iter().any(|lane| matches!(lane.place, HeadPlace::Pole | HeadPlace::Arm))
    }
}

impl CrossingEnd {
    /// Returns the foot of the pole.
    pub fn pole(&self) -> Vec3 {
        self.foot + self.outwards * BEHIND_WALKERS_M
    }
}

/// Returns the places of all signals of a network.
pub fn signal_places(net: &Network, surfaces: &RoadSurfaces) -> Vec<SignalPlace> {
    let place = |edge: EdgeId| match net.edge(edge).kind {
        EdgeKind::Crossing => at_crossing(net, edge).map(SignalPlace::Crossing),
        _ => approach(net, edge, surfaces).map(SignalPlace::Approach),
    };
    net.edge_ids().filter_map(place).collect()
}

/// Returns the connection whose light represents a lane, with its signal and link index: straight on, or else slight turns, right, left.
fn shown(net: &Network, lane: LaneId) -> Option<(&Connection, SignalId, u32)> {
    let turn = |way: &Connection| match way.direction {
        TurnDirection::Straight => 0,
        TurnDirection::PartRight | TurnDirection::PartLeft => 1,
        TurnDirection::Right => 2,
        TurnDirection::Left => 3,
        _ => 4,
    };
    let ruled = net.connections_from(lane).iter().filter_map(|way| {
        let link = way.signal?;
        Some((way, link.signal, link.index?))
    });
    ruled.min_by_key(|(way, ..)| turn(way))
}

/// Returns the signals at the end of an edge.
fn approach(net: &Network, edge: EdgeId, surfaces: &RoadSurfaces) -> Option<SignalledApproach> {
    let lanes: Vec<LaneId> = net.edge(edge).lanes().filter(|lane| net.is_driven(*lane)).collect();
    let ruled: Vec<_> = lanes.iter().filter_map(|&lane| Some((lane, shown(net, lane)?))).collect();
    let (Some(&outermost), false) = (lanes.first(), ruled.is_empty()) else { return None };
    // The pole is on the right, or on the left with left-hand traffic.
    let side = if net.is_left_hand() { 1.0 } else { -1.0 };
    let at = |lane: LaneId, offset_m: f64| {
        let of = net.lane(lane);
        let s_m = of.length_m - (BEFORE_END_M + of.end_offset_m) * of.length_m / of.line.drawn_m().max(1.0);
        net.pose(LanePosition { lane, s_m, offset_m })
    };
    let beside =
        |lane: LaneId, pole_m: f64| at(lane, side * (net.lane(lane).half_width_m() + pole_m)).position.as_vec3();
    let foot = beside(outermost, BESIDE_M);
    let behind = direction(&at(outermost, 0.0)) * BEHIND_M;
    let is_for_cars = |lane: LaneId| !net.lane(lane).is_for_bicycles();
    let first_for_cars = ruled.iter().position(|(lane, _)| is_for_cars(*lane));
    let signalled = |(k, &(lane, (way, signal, link))): (usize, &(LaneId, (&Connection, SignalId, u32)))| {
        let line = at(lane, 0.0);
        let place = if !is_for_cars(lane) && lane == outermost {
            HeadPlace::OwnPole(beside(lane, BESIDE_BICYCLES_M))
        } else if Some(k) == first_for_cars {
            HeadPlace::Pole
        } else {
            HeadPlace::Arm
        };
        // Those at the line do not see what is over them: they see the head across of another lane, if it shows the same.
        let mut before = ruled[..k].iter().filter(|(lane, _)| is_for_cars(*lane));
        let is_repeated = before.any(|(_, (_, of, other))| *of == signal && shows_alike(net, signal, [link, *other]));
        let is_across = is_for_cars(lane) && !is_repeated;
        let across = if is_across { across(net, way, &line, side, surfaces) } else { None };
        SignalledLane { lane, signal, link, direction: way.direction, line, place, across }
    };
    Some(SignalledApproach { foot, behind, lanes: ruled.iter().enumerate().map(signalled).collect() })
}

/// Returns the signals for those who walk over a crossing: one on either side of the road, facing the other.
fn at_crossing(net: &Network, edge: EdgeId) -> Option<[CrossingEnd; 2]> {
    let lane = net.edge(edge).lanes().next()?;
    let onto = net.predecessors(lane).iter().flat_map(|before| net.connections_from(*before));
    let mut ruled = onto.filter(|way| way.to == lane).filter_map(|way| way.signal);
    let (link, rule) = ruled.find_map(|rule| rule.index.zip(Some(rule)))?;
    let of = net.lane(lane);
    let beside_m = of.half_width_m() + BESIDE_CROSSING_M;
    let ends = [(of.length_m, 1.0, -beside_m), (0.0, -1.0, beside_m)];
    Some(ends.map(|(s_m, beyond, offset_m)| {
        let end = net.pose(LanePosition { lane, s_m, offset_m });
        let outwards = direction(&end) * beyond;
        let foot = end.position.as_vec3() + outwards * BEYOND_CROSSING_M;
        CrossingEnd { lane, signal: rule.signal, link, foot, outwards }
    }))
}

/// Returns the foot of the head across the junction: beside the exit lane if the way is straight on, else in view of those at the line.
/// `None` if there is no free place in range.
fn across(net: &Network, way: &Connection, line: &Pose3, side: f64, surfaces: &RoadSurfaces) -> Option<Vec3> {
    let (from, ahead) = (line.position.as_vec3(), direction(line));
    let near = |foot: &Vec3| foot.distance(from) < ACROSS_M && (*foot - from).dot(ahead) > 6.0;
    if matches!(way.direction, TurnDirection::Straight | TurnDirection::PartLeft | TurnDirection::PartRight) {
        let exit = net.edge_of(way.to).lanes().find(|lane| net.is_driven(*lane))?;
        let beside_m = side * (net.lane(exit).half_width_m() + BESIDE_M);
        let foot = |k: u32| {
            let pose = net.pose(LanePosition { lane: exit, s_m: 0.3 + f64::from(k), offset_m: beside_m });
            pose.position.as_vec3()
        };
        // Up to 7 m further on if another lane is in the way.
        let paved = net.edge_of(exit).lanes().any(|lane| net.lane(lane).is_footway());
        let free = |foot: &Vec3| paved || surfaces.border_m(foot.truncate()) > 0.5;
        return (0..8).map(foot).find(free).filter(near);
    }
    // Straight ahead, or the least to one side, so far across that it is below the mirror inset.
    let turns_left = matches!(way.direction, TurnDirection::Left | TurnDirection::Turnaround);
    let aside = Vec3::Z.cross(ahead) * if turns_left { 1.0 } else { -1.0 };
    let row = |k: u32| {
        let ahead_m = LEAST_ACROSS_M + 0.5 * k as f32;
        let steps = (0..).map(|step| step as f32).take_while(move |aside_m| *aside_m <= ASIDE_SHARE * ahead_m);
        steps.flat_map(move |aside_m| [aside_m, -aside_m]).map(move |aside_m| from + ahead * ahead_m + aside * aside_m)
    };
    (0..80).flat_map(row).find(|foot| surfaces.border_m(foot.truncate()) > 0.7).filter(near)
}

/// Checks whether two links of a signal show the same in all phases.
fn shows_alike(net: &Network, signal: SignalId, [a, b]: [u32; 2]) -> bool {
    let phases = || net.signal(signal).programs.iter().flat_map(|program| &program.phases);
    // A permissive green looks like a protected one.
    let seen = |light: Option<SignalLight>| match light {
        Some(SignalLight::GreenMinor | SignalLight::GreenArrow) => Some(SignalLight::GreenMajor),
        other => other,
    };
    phases().all(|phase| seen(phase.light(a)) == seen(phase.light(b)))
}

/// Returns the direction of a pose on the ground, a unit vector.
pub fn direction(pose: &Pose3) -> Vec3 {
    Vec2::from_angle(pose.yaw_rad as f32).extend(0.0)
}
