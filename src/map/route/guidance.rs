//! Manoeuvres of the ego's path, for the guidance of a participant. In: a [`RoadMap`]. Out: the next place at which the path leaves the road
//! that goes straight on, and the way to it. Metres.

use super::turns::{JunctionWay, way_at_end};
use crate::{
    map::{
        RoadMap,
        network::{Connection, EdgeId, LaneId, TurnDirection},
    },
    space::wrap_angle,
};
use std::collections::BTreeSet;

/// Way on at a junction or a fork.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Manoeuvre {
    Left,
    Right,
    /// The left one of two roads that both lead on.
    KeepLeft,
    /// The right one of two roads that both lead on, as at the exit of a motorway.
    KeepRight,
    /// Back on the same road.
    TurnAround,
    /// Through a roundabout to one of its exits.
    Roundabout {
        /// Direction of the exit from that of the way in, degrees, positive to the left: 0 is straight on.
        exit_deg: i16,
        /// True with left-hand traffic.
        is_clockwise: bool,
    },
}

/// Manoeuvre that comes next, or is under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NextManoeuvre {
    pub manoeuvre: Manoeuvre,
    /// Distance from the ego's front bumper to the end of the street, metres; 0 within the junction.
    pub ahead_m: f64,
}

/// Manoeuvres of a route, each with the end of its street and the length within its junction, metres.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PathGuidance(Vec<(f64, f64, Manoeuvre)>);

impl PathGuidance {
    /// Returns the manoeuvres of a map's route; `lanes` are the network's lanes of the route's.
    pub fn new(map: &RoadMap, lanes: &[Option<LaneId>]) -> Self {
        let net = &map.network;
        let rings: BTreeSet<EdgeId> = net.roundabouts().iter().flat_map(|ring| ring.edges.iter().copied()).collect();
        let is_on_ring = |lane: LaneId| rings.contains(&net.lane(lane).edge);
        let found = (0..lanes.len()).filter_map(|k| {
            let JunctionWay { connection, at_s_m, length_m } = way_at_end(map, lanes, k)?;
            match [connection.from, connection.to].map(is_on_ring) {
                // All is said before the way in.
                [true, _] => None,
                [false, true] => roundabout(map, lanes, (k, at_s_m), is_on_ring),
                [false, false] => Some((at_s_m, length_m, manoeuvre(map, connection)?)),
            }
        });
        Self(found.collect())
    }

    /// Returns all manoeuvres, in driving order.
    pub fn manoeuvres(&self) -> impl Iterator<Item = Manoeuvre> {
        self.0.iter().map(|(_, _, manoeuvre)| *manoeuvre)
    }

    /// Returns the manoeuvre under way, else the next one after a position of the route.
    pub fn next(&self, map: &RoadMap, s_m: f64) -> Option<NextManoeuvre> {
        let ahead = self.0.iter().filter_map(|(at_s_m, length_m, manoeuvre)| {
            let is_under_way = (-length_m..0.0).contains(&map.route.difference(s_m, *at_s_m));
            let ahead_m = if is_under_way { 0.0 } else { map.route.drawn_ahead_m(s_m, *at_s_m) };
            // On an open route those behind have a negative distance.
            (ahead_m >= 0.0).then_some(NextManoeuvre { manoeuvre: *manoeuvre, ahead_m })
        });
        ahead.min_by(|a, b| a.ahead_m.total_cmp(&b.ahead_m))
    }
}

/// Returns the manoeuvre through a roundabout that begins after the route's lane `k`, at `at_s_m`, with the length to its exit; `None` if the
/// route ends within.
fn roundabout(
    map: &RoadMap,
    lanes: &[Option<LaneId>],
    (k, at_s_m): (usize, f64),
    is_on_ring: impl Fn(LaneId) -> bool,
) -> Option<(f64, f64, Manoeuvre)> {
    /// Distance from the roundabout at which its roads have their own direction, metres.
    const AWAY_M: f64 = 10.0;
    let (net, route) = (&map.network, &map.route);
    let n = lanes.len();
    let mut after = (k + 1..if route.is_closed() { k + n } else { n }).map(|k| k % n);
    let is_exit = |k: &usize| lanes[*k].is_some_and(|lane| net.edge_of(lane).kind.is_street() && !is_on_ring(lane));
    let exit = &route.lanes()[after.find(is_exit)?];
    let in_rad = route.yaw_at(at_s_m - AWAY_M);
    let out_rad = route.yaw_at(exit.start_s_m + AWAY_M.min(exit.length_m / 2.0));
    let exit_deg = wrap_angle(out_rad - in_rad).to_degrees().round() as i16;
    let manoeuvre = Manoeuvre::Roundabout { exit_deg, is_clockwise: net.is_left_hand() };
    Some((at_s_m, route.ahead(at_s_m, exit.start_s_m), manoeuvre))
}

/// Returns the manoeuvre from a lane's end to another lane; `None` where there is no choice, or the way leads straight on.
fn manoeuvre(map: &RoadMap, way: &Connection) -> Option<Manoeuvre> {
    let net = &map.network;
    let edge = net.lane(way.from).edge;
    let from: Vec<LaneId> = net.edge(edge).lanes().collect();
    let onto = net.lane(way.to).edge;
    // Other ways on from this street for cars.
    let others = || {
        let ways =
            from.iter().enumerate().flat_map(|(k, lane)| net.connections_from(*lane).iter().map(move |way| (k, way)));
        ways.filter(|(_, other)| {
            let lane = net.lane(other.to);
            lane.edge != onto && lane.admits_cars() && !other.is_turnaround()
        })
    };
    others().next()?;
    match way.direction {
        TurnDirection::Left => Some(Manoeuvre::Left),
        TurnDirection::Right => Some(Manoeuvre::Right),
        TurnDirection::PartLeft => Some(Manoeuvre::KeepLeft),
        TurnDirection::PartRight => Some(Manoeuvre::KeepRight),
        TurnDirection::Turnaround | TurnDirection::TurnaroundLeftHand => Some(Manoeuvre::TurnAround),
        TurnDirection::Straight | TurnDirection::Unknown => {
            // A fork: the slower road is the exit. Lanes are counted from the outer side.
            let own = from.iter().position(|lane| *lane == way.from)?;
            let straight = others().filter(|(_, other)| other.direction == way.direction);
            let faster =
                straight.filter(|(_, other)| net.lane(other.to).speed_limit_mps > net.lane(way.to).speed_limit_mps);
            let inner = faster.map(|(k, _)| k > own).reduce(|a, b| a && b)?;
            Some(if inner != net.is_left_hand() { Manoeuvre::KeepRight } else { Manoeuvre::KeepLeft })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::PathLanes;

    /// Returns the manoeuvres at positions of a map's route.
    fn at(map: &RoadMap, positions_m: &[f64]) -> Vec<Option<(Manoeuvre, f64)>> {
        let guidance = PathLanes::new(map).guidance(map);
        let next = |s_m: &f64| guidance.next(map, *s_m).map(|next| (next.manoeuvre, next.ahead_m.round()));
        positions_m.iter().map(next).collect()
    }

    #[test]
    fn a_path_turns_at_crossings_and_goes_straight_on_without_a_word() {
        use Manoeuvre::{Left, Right};
        let file = "tests/data/networks/grid-signals.net.xml";
        let map = RoadMap::load_along(file, &["B0B1", "B1C1", "C1C2"]).expect("a path");
        let lanes = map.route.lanes();
        // B0B1_0 has 69.20 m and turns right into B1C1; then C1C2 turns left.
        let left_m = lanes.iter().find(|lane| lane.edge_id(&map.network) == "B1C1").expect("B1C1").start_s_m;
        assert_eq!(at(&map, &[0.0, 49.2, 70.0]), [Some((Right, 69.0)), Some((Right, 20.0)), Some((Right, 0.0))]);
        let after = at(&map, &[left_m + 1.0]);
        assert!(matches!(after[0], Some((Left, ahead_m)) if (40.0..90.0).contains(&ahead_m)), "{after:?}");
        assert_eq!(at(&map, &[map.route.length_m() - 1.0]), [None]);
        let map = RoadMap::load_along(file, &["A1B1", "B1C1"]).expect("a path");
        assert_eq!(at(&map, &[0.0, 69.0, 100.0]), [None; 3], "straight on");
    }

    #[test]
    fn a_roundabout_is_one_manoeuvre_with_the_direction_of_its_exit() {
        // Four arms; the way in comes from the south.
        for (path, wanted_deg) in
            [(vec!["Ss", "se", "eE"], -90), (vec!["Ss", "se", "en", "nN"], 0), (vec!["Ss", "se", "en", "nw", "wW"], 90)]
        {
            let map = RoadMap::load_along("tests/data/networks/roundabout.net.xml", &path).expect("a path");
            let seen = at(&map, &[0.0]);
            let Some((Manoeuvre::Roundabout { exit_deg, is_clockwise: false }, ahead_m)) = seen[0] else {
                panic!("{path:?}: {seen:?}")
            };
            assert!((exit_deg - wanted_deg).abs() < 15, "{path:?}: {exit_deg}");
            // On the ring it is under way, and after it nothing is left to say.
            assert_eq!(
                at(&map, &[ahead_m + 5.0]),
                [Some((Manoeuvre::Roundabout { exit_deg, is_clockwise: false }, 0.0))]
            );
            assert_eq!(at(&map, &[map.route.length_m() - 1.0]), [None]);
        }
    }

    #[test]
    fn the_exit_of_the_motorway_is_the_only_manoeuvre_of_its_path() {
        let map = RoadMap::load("motorway").expect("a map that is shipped");
        // The lengths in its net.xml, with the lanes within three junctions: 1900.85 + 3 + 244.50 + 8 + 5839.87 + 8 + 244.54 m.
        let start = at(&map, &[0.0, 5000.0]);
        let Some((Manoeuvre::KeepRight, whole_m)) = start[0] else { panic!("{start:?}") };
        assert!((whole_m - 8248.76).abs() < 1.0, "{whole_m}");
        assert_eq!(start[1], Some((Manoeuvre::KeepRight, whole_m - 5000.0)));
        assert_eq!(at(&map, &[whole_m + 300.0]), [None]);
        let ring = RoadMap::load("ring-250").expect("a map that is shipped");
        assert_eq!(at(&ring, &[0.0]), [None]);
    }
}
