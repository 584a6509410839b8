//! Turns and lane changes of the ego's path, for the indicators of a simulated driver. In: a [`RoadMap`]. Out: the side to indicate at a
//! position of the path. Metres.

use super::lane_changes::LaneChange;
use crate::{
    controls::Indicator,
    map::{
        RoadMap,
        network::{Connection, LaneId, Side, TurnDirection},
    },
};

/// Distance before a turn at which a driver begins to indicate, metres: the last 100 feet (California Vehicle Code 22108).
const AHEAD_M: f64 = 30.0;

/// A turn or a lane change of the path.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Turn {
    /// Start on the route, metres.
    from_s_m: f64,
    /// Length from the start to the end, metres.
    length_m: f64,
    side: Indicator,
}

/// The turns and lane changes of a route.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Turns(Vec<Turn>);

impl Turns {
    /// Returns the turns and lane changes of a map's route; `lanes` are the network's lanes of the route's.
    pub fn new(map: &RoadMap, lanes: &[Option<LaneId>], changes: &[LaneChange]) -> Self {
        let at_junctions = (0..lanes.len()).filter_map(|k| turn(map, lanes, k));
        Self(at_junctions.chain(changes.iter().map(change)).collect())
    }

    /// Returns the side of the turn in progress or within `AHEAD_M`; off if there is none. The lane change that begins at `over_s_m` counts
    /// as finished.
    pub fn indicator_at(&self, map: &RoadMap, s_m: f64, over_s_m: Option<f64>) -> Indicator {
        let route = &map.route;
        let comes = |turn: &&Turn| {
            let ahead_m = route.difference(s_m, turn.from_s_m);
            -turn.length_m < ahead_m && ahead_m <= AHEAD_M && Some(turn.from_s_m) != over_s_m
        };
        // The nearer one of two consecutive turns counts.
        let nearest = |a: &&Turn, b: &&Turn| {
            let ahead_m = |turn: &Turn| route.difference(s_m, turn.from_s_m);
            ahead_m(a).total_cmp(&ahead_m(b))
        };
        self.0.iter().filter(comes).min_by(nearest).map_or(Indicator::Off, |turn| turn.side)
    }
}

/// Way of a route over the junction at the end of a street.
pub(super) struct JunctionWay<'a> {
    pub connection: &'a Connection,
    /// End of the street on the route, metres.
    pub at_s_m: f64,
    /// Length of the way within the junction, metres.
    pub length_m: f64,
}

/// Returns the way over the junction at the end of the route's lane `k`; `None` within junctions, and at the route's end.
pub(super) fn way_at_end<'a>(map: &'a RoadMap, lanes: &[Option<LaneId>], k: usize) -> Option<JunctionWay<'a>> {
    let (net, route) = (&map.network, &map.route);
    let next = |k: usize| (k + 1) % lanes.len();
    let (from, to) = (lanes[k]?, lanes[route.next_lane(k)?]?);
    if !net.edge_of(from).kind.is_street() {
        return None;
    }
    let connection = net.connections_from(from).iter().find(|way| way.next() == to)?;
    let inside = std::iter::successors(Some(next(k)), |k| Some(next(*k)))
        .take(lanes.len())
        .take_while(|k| !route.lanes()[*k].is_street(net));
    let length_m = inside.map(|k| route.lanes()[k].length_m).sum();
    let here = &route.lanes()[k];
    Some(JunctionWay { connection, at_s_m: route.wrap(here.start_s_m + here.length_m), length_m })
}

/// Returns the turn at the junction at the end of the route's lane `k`.
fn turn(map: &RoadMap, lanes: &[Option<LaneId>], k: usize) -> Option<Turn> {
    let JunctionWay { connection, at_s_m, length_m } = way_at_end(map, lanes, k)?;
    let side = match connection.direction {
        TurnDirection::Left | TurnDirection::PartLeft | TurnDirection::Turnaround => Indicator::Left,
        TurnDirection::Right | TurnDirection::PartRight | TurnDirection::TurnaroundLeftHand => Indicator::Right,
        TurnDirection::Straight | TurnDirection::Unknown => return None,
    };
    Some(Turn { from_s_m: at_s_m, length_m, side })
}

/// Returns the turn for a lane change.
fn change(change: &LaneChange) -> Turn {
    let side = if change.side == Side::Left { Indicator::Left } else { Indicator::Right };
    Turn { from_s_m: change.start_s_m, length_m: change.length_m, side }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::PathLanes;

    fn turns_of(map: &RoadMap) -> Turns {
        let lanes = PathLanes::new(map);
        lanes.turns(map, &lanes.lane_changes(map))
    }

    #[test]
    fn a_driver_indicates_before_and_in_turns_and_in_lane_changes() {
        use Indicator::{Left, Off, Right};
        let file = "tests/data/networks/grid-signals.net.xml";
        let map = RoadMap::load_along(file, &["B0B1", "B1C1", "C1C2"]).expect("a path");
        let lanes = map.route.lanes();
        // B0B1_0 has 69.20 m and turns right into B1C1_0; C1C2 turns left from B1C1_1.
        let (right_m, change, left) = (69.2, &lanes[2], lanes.last().expect("C1C2").start_s_m);
        assert!(
            change.edge_id(&map.network) == "B1C1" && (lanes[0].start_s_m + lanes[0].length_m - right_m).abs() < 1e-9
        );
        let turns = turns_of(&map);
        let at = |s_m: f64| turns.indicator_at(&map, s_m, None);
        assert_eq!([at(0.0), at(right_m - 31.0), at(right_m - 29.0)], [Off, Off, Right]);
        assert_eq!([at(change.start_s_m - 0.1), at(change.start_s_m + 0.1), at(left - 0.1)], [Right, Left, Left]);
        // After the lane change the indicator is off until the next turn.
        let over = |s_m: f64| turns.indicator_at(&map, s_m, Some(change.start_s_m));
        assert_eq!([over(change.start_s_m + 20.0), over(left - 20.0)], [Off, Left]);
        assert_eq!([at(left + 0.1), at(map.route.length_m())], [Off, Off]);
        // Without a turn the indicator is off.
        let map = RoadMap::load_along(file, &["A1B1", "B1C1"]).expect("a path");
        let turns = turns_of(&map);
        assert!((0..150).all(|s_m| turns.indicator_at(&map, f64::from(s_m), None) == Off));
    }
}
