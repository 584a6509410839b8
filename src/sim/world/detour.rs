//! Way of an ego that has left its path. In: its lane in each tick, and the path. Out: events where it leaves the path and is back on it,
//! and the next manoeuvre of the way back, in place of the path's.
//!
//! The path stays the route of all positions: the ego's stands still while it is on another street, and goes on where it is back.

use crate::{
    map::{
        Manoeuvre, NextManoeuvre, PathGuidance, PathLanes, RoadMap, is_against,
        network::{EdgeId, LanePosition},
    },
    sim::{EventKind, Snapshot},
    time::TICKS_PER_S,
};

/// Time on another street after which the ego has left its path, ticks: a wide turn may touch one.
const BESIDE_TICKS: u32 = TICKS_PER_S;

/// Distance along the path from the last position from which the ego is at another place of it, metres: more than it moves in a tick, and
/// more than the search for its place around the last one finds.
const ELSEWHERE_M: f64 = 80.0;

/// Way back from a street beside the path.
struct WayBack {
    map: RoadMap,
    lanes: PathLanes,
    guidance: PathGuidance,
}

impl WayBack {
    fn from(edge: EdgeId, path: &RoadMap, left_s_m: f64) -> Option<Self> {
        let map = path.way_back(edge, left_s_m)?;
        let lanes = PathLanes::new(&map);
        Some(Self { guidance: lanes.guidance(&map), lanes, map })
    }
}

/// Relation of the ego to its path.
#[derive(Default)]
enum PathState {
    #[default]
    OnPath,
    /// On another street for so many ticks.
    Beside(u32),
    /// On another street, with the way back, if one leads back.
    Left { edge: EdgeId, way: Option<Box<WayBack>> },
}

/// Observer of an ego that may leave its path.
#[derive(Default)]
pub(super) struct Detour {
    state: PathState,
    /// Last position on the path, metres.
    left_s_m: f64,
}

impl Detour {
    /// Updates the position on the path of an ego that has left it or is back. Returns the event of this tick, if there is one.
    pub fn locate(&mut self, snapshot: &mut Snapshot, map: &RoadMap, lanes: &PathLanes) -> Option<EventKind> {
        if map.route.is_closed() {
            return None;
        }
        // Junctions and the land belong to no street: there the state stays, and so it does in a lane of the other direction.
        let is_along = |at: &LanePosition| !is_against(&map.network, *at, &snapshot.ego.pose());
        let is_street = |at: &LanePosition| map.network.edge_of(at.lane).kind.is_street();
        let on_street = snapshot.ego_lane.filter(|at| is_street(at) && is_along(at));
        let event = on_street.and_then(|at| self.on_street(at, snapshot, map, lanes));
        if self.has_left() {
            snapshot.ego_s_m = self.left_s_m;
        }
        event
    }

    /// Returns true while the ego is on another street than its path's.
    pub fn has_left(&self) -> bool {
        matches!(self.state, PathState::Left { .. })
    }

    /// Returns the next manoeuvre of the way back of an ego in this lane: to turn around where none leads back, or on a street that the way
    /// does not use; `None` on the path.
    pub fn next_manoeuvre(&self, at: Option<LanePosition>) -> Option<Option<NextManoeuvre>> {
        let PathState::Left { way, .. } = &self.state else { return None };
        let Some(way) = way else {
            return Some(Some(NextManoeuvre { manoeuvre: Manoeuvre::TurnAround, ahead_m: 0.0 }));
        };
        Some(at.and_then(|at| way.guidance.next(&way.map, way.lanes.s_on_edge(&way.map, at, 0.0)?)))
    }

    fn on_street(
        &mut self,
        at: LanePosition,
        snapshot: &mut Snapshot,
        map: &RoadMap,
        lanes: &PathLanes,
    ) -> Option<EventKind> {
        if let Some(s_m) = lanes.s_on_edge(map, at, snapshot.ego_s_m) {
            let had_left = self.has_left();
            if had_left || (s_m - snapshot.ego_s_m).abs() > ELSEWHERE_M {
                snapshot.ego_s_m = s_m;
            }
            (self.state, self.left_s_m) = (PathState::OnPath, snapshot.ego_s_m);
            return had_left.then_some(EventKind::BackOnPath { s_m });
        }
        let edge = map.network.lane(at.lane).edge;
        let on_way = |way: &WayBack| way.lanes.s_on_edge(&way.map, at, 0.0).is_some();
        match &mut self.state {
            PathState::OnPath => self.state = PathState::Beside(1),
            PathState::Beside(ticks) if *ticks < BESIDE_TICKS => *ticks += 1,
            PathState::Beside(_) => {
                let way = WayBack::from(edge, map, self.left_s_m).map(Box::new);
                self.state = PathState::Left { edge, way };
                return Some(EventKind::LeftPath { s_m: self.left_s_m });
            }
            PathState::Left { edge: last, way } => {
                // One search for each street: a way that is left again, or a street from which none leads back.
                if *last != edge && !way.as_deref().is_some_and(on_way) {
                    *way = WayBack::from(edge, map, self.left_s_m).map(Box::new);
                }
                *last = edge;
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ego::EgoState, space::Pose};

    /// A drive on a grid of three by three nodes that turns right at B1, into B1C1.
    struct Drive {
        map: RoadMap,
        lanes: PathLanes,
        detour: Detour,
        snapshot: Snapshot,
    }

    impl Drive {
        fn new() -> Self {
            let file = "tests/data/networks/grid-signals.net.xml";
            let map = RoadMap::load_along(file, &["B0B1", "B1C1", "C1C2"]).expect("a path");
            let lanes = PathLanes::new(&map);
            Self { map, lanes, detour: Detour::default(), snapshot: Snapshot::default() }
        }

        /// Places the ego in a lane for one tick, turned by an angle.
        fn place(&mut self, lane: &str, s_m: f64, turned_rad: f64) -> Option<EventKind> {
            let at = LanePosition { lane: self.map.network.lane_named(lane).expect("a lane"), s_m, offset_m: 0.0 };
            let pose = self.map.network.pose(at);
            let pose = Pose::new(pose.position.truncate(), pose.yaw_rad + turned_rad);
            self.snapshot.ego = EgoState {
                position: pose.position.extend(0.0),
                rotation: glam::Quat::from_rotation_z(pose.yaw_rad as f32),
                ..EgoState::default()
            };
            self.snapshot.ego_lane = Some(at);
            self.detour.locate(&mut self.snapshot, &self.map, &self.lanes)
        }
    }

    #[test]
    fn a_wrong_turn_is_noted_after_a_second_and_led_back_to_the_path() {
        let mut drive = Drive::new();
        drive.snapshot.ego_s_m = 60.0;
        assert_eq!(drive.place("B0B1_0", 60.0, 0.0), None);
        for tick in 0..BESIDE_TICKS {
            assert_eq!(drive.place("B1B2_0", 5.0, 0.0), None, "tick {tick}");
        }
        assert_eq!(drive.place("B1B2_0", 5.0, 0.0), Some(EventKind::LeftPath { s_m: 60.0 }));
        // The way back is left round the block: B2A2, A2A1, A1B1.
        let next = |drive: &Drive| drive.detour.next_manoeuvre(drive.snapshot.ego_lane).flatten();
        let Some(NextManoeuvre { manoeuvre: Manoeuvre::Left, ahead_m }) = next(&drive) else { panic!("a left turn") };
        assert!((55.0..70.0).contains(&ahead_m), "a street of the grid has 69.2 m: {ahead_m}");
        assert_eq!((drive.place("B2A2_1", 20.0, 0.0), drive.snapshot.ego_s_m), (None, 60.0), "the position waits");
        assert!(matches!(next(&drive), Some(NextManoeuvre { manoeuvre: Manoeuvre::Left, .. })));
        // Right at B2 instead: a way from there.
        assert_eq!(drive.place("B2C2_0", 20.0, 0.0), None);
        assert!(next(&drive).is_some_and(|next| next.manoeuvre != Manoeuvre::TurnAround));
        let edge =
            drive.map.route.lanes().iter().find(|lane| lane.edge_id(&drive.map.network) == "B1C1").expect("B1C1");
        let start_m = edge.start_s_m;
        let Some(EventKind::BackOnPath { s_m }) = drive.place("B1C1_0", 10.0, 0.0) else { panic!("back") };
        assert!((s_m - start_m - 10.0).abs() < 1e-9 && drive.snapshot.ego_s_m == s_m, "{s_m}");
        assert!(!drive.detour.has_left() && drive.detour.next_manoeuvre(drive.snapshot.ego_lane).is_none());
    }

    #[test]
    fn overtaking_in_the_opposite_lane_does_not_leave_the_path() {
        let mut drive = Drive::new();
        drive.snapshot.ego_s_m = 30.0;
        for _ in 0..3 * BESIDE_TICKS {
            assert_eq!(drive.place("B1B0_0", 30.0, std::f64::consts::PI), None);
        }
        assert!(!drive.detour.has_left());
    }

    #[test]
    fn a_short_cut_over_the_land_goes_on_at_its_place_of_the_path() {
        let mut drive = Drive::new();
        drive.snapshot.ego_s_m = 20.0;
        drive.place("B0B1_0", 20.0, 0.0);
        assert_eq!(drive.place("C1C2_0", 30.0, 0.0), None);
        let c1c2 =
            drive.map.route.lanes().iter().find(|lane| lane.edge_id(&drive.map.network) == "C1C2").expect("C1C2");
        assert!((drive.snapshot.ego_s_m - c1c2.start_s_m - 30.0).abs() < 1e-9, "{}", drive.snapshot.ego_s_m);
    }
}
