//! Lane changes of the ego's path. In: a [`RoadMap`]. Out: the stretches on which the path changes lanes, with the lanes from entry to
//! exit. Metres.

use crate::map::{
    RoadMap,
    network::{LaneId, Side},
};

/// A stretch of the path, along one edge, that begins in one lane and ends in another.
#[derive(Clone, Debug, PartialEq)]
pub struct LaneChange {
    /// Index among the route's lanes.
    pub index: usize,
    /// Start on the route, metres.
    pub start_s_m: f64,
    /// Length from the start to the end of the edge, metres.
    pub length_m: f64,
    /// Lanes in driving order.
    pub lanes: Vec<LaneId>,
    /// Side to which the path changes.
    pub side: Side,
}

impl LaneChange {
    /// Returns the end of the stretch, metres; on a closed route it may exceed a lap.
    pub fn end_s_m(&self) -> f64 {
        self.start_s_m + self.length_m
    }
}

/// Largest distance between starts of lanes that count as one point, metres: networks are rounded to centimetres.
const SAME_PLACE_M: f64 = 0.02;

/// Returns the lane changes of a map's route in driving order; `lanes` are the network's lanes of the route's.
pub fn lane_changes(map: &RoadMap, lanes: &[Option<LaneId>]) -> Vec<LaneChange> {
    lanes.iter().enumerate().filter_map(|(k, exit)| lane_change(map, k, (*exit)?)).collect()
}

/// Returns the change on the route's lane `index`, left by the lane `exit`, if the path enters by another lane of the edge.
fn lane_change(map: &RoadMap, index: usize, exit: LaneId) -> Option<LaneChange> {
    let (net, here) = (&map.network, &map.route.lanes()[index]);
    let begins = here.shape[0];
    let from_start_m = |lane: LaneId| net.lane(lane).line.points()[0].truncate().distance(begins);
    let entry = net.edge_of(exit).lanes().min_by(|a, b| from_start_m(*a).total_cmp(&from_start_m(*b)))?;
    // Lanes that fan out from one point, and internal lanes, are no lane change.
    let is_entered = from_start_m(exit) <= from_start_m(entry) + SAME_PLACE_M;
    let is_inside = !net.edge_of(exit).kind.is_street();
    // At the start of the path, or after a gap between lanes, the entry may be slightly beside the lane's start.
    if is_entered || is_inside || from_start_m(entry) > net.lane(entry).half_width_m() {
        return None;
    }
    let side = if (exit > entry) != net.is_left_hand() { Side::Left } else { Side::Right };
    let beside = std::iter::successors(Some(entry), |lane| net.neighbour(*lane, side));
    let lanes = beside.take(entry.index().abs_diff(exit.index()) + 1).collect();
    Some(LaneChange { index, start_s_m: here.start_s_m, length_m: here.length_m, lanes, side })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::PathLanes;

    /// Returns the lane changes of a path: lanes, side, start and end in centimetres.
    fn changes(file: &str, edges: &[&str]) -> Vec<(Vec<String>, Side, i64, i64)> {
        let map = RoadMap::load_along(&format!("tests/data/networks/{file}.net.xml"), edges).expect("a path");
        let cm = |m: f64| (m * 100.0).round() as i64;
        let names = |lanes: &[LaneId]| lanes.iter().map(|lane| map.network.lane(*lane).id.clone()).collect();
        let found = PathLanes::new(&map).lane_changes(&map);
        found.iter().map(|c| (names(&c.lanes), c.side, cm(c.start_s_m), cm(c.end_s_m()))).collect()
    }

    #[test]
    fn lanes_that_fan_out_from_one_point_are_no_change() {
        let lane = |id: &str, index: u32, points: &str| {
            format!("<lane id=\"{id}_{index}\" index=\"{index}\" speed=\"9\" length=\"40\" shape=\"{points}\"/>")
        };
        let way = |from: &str, to: &str, lanes: [u32; 2]| {
            let [out, into] = lanes;
            format!("<connection from=\"{from}\" to=\"{to}\" fromLane=\"{out}\" toLane=\"{into}\"/>")
        };
        let text = format!(
            "<net><edge id=\"a\">{}</edge><edge id=\"b\">{}{}</edge><edge id=\"c\">{}</edge>{}{}{}</net>",
            lane("a", 0, "-40,0 0,0"),
            lane("b", 0, "0,0 40,-3.2"),
            lane("b", 1, "0,0 40,0"),
            lane("c", 0, "40,0 80,0"),
            way("a", "b", [0, 0]),
            way("a", "b", [0, 1]),
            way("b", "c", [1, 0]),
        );
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("fan.net.xml");
        std::fs::write(&file, text).expect("written");
        let map = RoadMap::load_along(&file.to_string_lossy(), &["a", "b", "c"]).expect("a path");
        assert_eq!(PathLanes::new(&map).lane_changes(&map), []);
    }

    #[test]
    fn a_lane_change_goes_from_the_entry_lane_of_an_edge_to_its_exit_lane() {
        let lanes = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        // B0B1_0 has 69.20 m, the turn 9.03 m, B1C1 69.20 m.
        let expected = [(lanes(&["B1C1_0", "B1C1_1"]), Side::Left, 7823, 14743)];
        assert_eq!(changes("grid-signals", &["B0B1", "B1C1", "C1C2"]), expected);
        // From the on-ramp (272.41 m and 3.69 m inside) a vehicle has to leave the acceleration lane of 93.81 m.
        let found = changes("ramps", &["onramp", "between-AddedOnRampEdge", "between"]);
        let edge = |k: usize| format!("between-AddedOnRampEdge_{k}");
        assert_eq!(
            found.iter().map(|c| (c.0.clone(), c.1)).collect::<Vec<_>>(),
            [(vec![edge(0), edge(1)], Side::Left)]
        );
        assert_eq!(found[0].3 - found[0].2, 9381);
        assert_eq!(changes("grid-signals", &["A1B1", "B1C1", "C1C2"]), []);
    }

    #[test]
    fn with_left_hand_traffic_the_inner_lane_is_on_the_right() {
        // From the outer of the two car lanes of wc into the street that only the inner one leads to.
        let side = |file: &str, to: &str| {
            let map = RoadMap::load_along(&format!("tests/data/networks/{file}.net.xml"), &["wc"]).expect("a path");
            let outer = map.network.lane_named("wc_1").expect("a lane");
            let map = map.along(&["wc", to], outer).expect("a path");
            PathLanes::new(&map).lane_changes(&map).first().map(|change| change.side)
        };
        assert_eq!((side("town", "cn"), side("town-left", "cs")), (Some(Side::Left), Some(Side::Right)));
    }
}
