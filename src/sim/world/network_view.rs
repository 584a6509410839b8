//! View of a network along the ego's path. In: the map and the snapshot. Out: the ego's lane, the ground under it, the next signal, yield
//! line and place to stop, and whether the ego is at the end of its path. Metres, m/s.

use super::{detour::Detour, persons_ahead::PersonsAhead, vehicles_across};
use crate::{
    controls::Indicator,
    driver::{
        DriverParams, SeenLeader,
        manoeuvres::{LaneChanging, RightOfWay},
    },
    map::{
        PathGuidance, PathLanes, RoadMap, SHOULDER_M, StopLine, Turns,
        network::{LanePosition, SignalLight},
    },
    policy::SignalAhead,
    sim::{
        EventKind, Snapshot, VehicleSnapshot,
        ground::{NONE_CLEAR, NetworkGround, RoadGround},
    },
    space::{CAR_LENGTH_M, Pose},
};

/// Largest deceleration at which a driver stops for a yellow light, m/s² (German rules for the duration of yellow assume 3.5, American ones
/// 3.05).
const STOPS_MPS2: f64 = 3.0;
/// Largest deceleration at which a driver stops for a red light, m/s²: a driver who began to brake for yellow, late by a reaction time,
/// goes on braking.
const STOPS_FOR_RED_MPS2: f64 = 6.0;
/// Distance from which a driver considers a signal, metres.
const SIGNAL_AHEAD_M: f64 = 300.0;

/// View of a network along the ego's path.
pub(super) struct NetworkView {
    lanes: PathLanes,
    right_of_way: RightOfWay,
    changing: LaneChanging,
    turns: Turns,
    guidance: PathGuidance,
    detour: Detour,
    persons: PersonsAhead,
    /// True if the ego is on the last edge of its path, or was there until its front reached the end.
    is_on_last: bool,
}

impl NetworkView {
    /// Returns the view along a map's route.
    pub fn new(map: &RoadMap) -> Self {
        let lanes = PathLanes::new(map);
        let right_of_way = RightOfWay::new(lanes.yield_lines(map));
        let changes = lanes.lane_changes(map);
        Self {
            right_of_way,
            turns: lanes.turns(map, &changes),
            guidance: lanes.guidance(map),
            detour: Detour::default(),
            changing: LaneChanging::new(changes),
            persons: PersonsAhead::new(map),
            lanes,
            is_on_last: false,
        }
    }

    /// Updates the lane of the ego's front in the snapshot, and its position where it has left its path or is back. Returns the event of
    /// that, if there is one.
    pub fn locate(&mut self, snapshot: &mut Snapshot, map: &RoadMap, ego: &Pose) -> Option<EventKind> {
        let last = snapshot.ego_lane.map(|at| at.lane);
        let height_m = snapshot.ego.position.z;
        snapshot.ego_lane = self.lanes.ego_lane(map, ego, height_m, snapshot.ego_s_m, last);
        let event = self.detour.locate(snapshot, map, &self.lanes);
        self.note_last_edge(snapshot, map);
        event
    }

    /// Updates lane and position along the path of an ego that the engine keeps in this lane, which may be beside the path's.
    pub fn follow(&mut self, snapshot: &mut Snapshot, map: &RoadMap, lane: Option<LanePosition>) {
        snapshot.ego_lane = lane;
        let found = lane.and_then(|at| self.lanes.s_on_edge(map, at, snapshot.ego_s_m));
        snapshot.ego_s_m = found.unwrap_or(snapshot.ego_s_m);
        self.note_last_edge(snapshot, map);
    }

    /// Notes whether the ego is on the last edge of its path.
    fn note_last_edge(&mut self, snapshot: &Snapshot, map: &RoadMap) {
        let edge = |at: LanePosition| map.network.edge_of(at.lane).id.as_str();
        let is_on_last = snapshot.ego_lane.map(edge) == map.route.lanes().last().map(|lane| lane.edge_id(&map.network));
        let has_left = snapshot.ego_lane.is_none() || snapshot.ego_s_m < map.route.length_m();
        self.is_on_last = is_on_last || (self.is_on_last && !has_left);
    }

    /// Returns the speed limit for the ego, m/s: of its path's street, or of the one on which it is beside the path.
    pub fn limit_mps(&self, snapshot: &Snapshot, map: &RoadMap) -> f64 {
        let beside = snapshot.ego_lane.filter(|_| self.detour.has_left());
        beside.map_or_else(|| map.street_limit_mps(snapshot.ego_s_m), |at| map.network.lane(at.lane).speed_limit_mps)
    }

    /// Updates the ego's next manoeuvre, its state at the next line and its lane change; during the latter it sets the leader to the one in the
    /// ego's own lane.
    pub fn update_derived(&mut self, snapshot: &mut Snapshot, map: &RoadMap) {
        let way_back = self.detour.next_manoeuvre(snapshot.ego_lane);
        snapshot.next_manoeuvre = way_back.unwrap_or_else(|| self.guidance.next(map, snapshot.ego_s_m));
        self.changing.update(snapshot, map);
        self.right_of_way.update(snapshot, map);
    }

    /// Returns the lane and the pose to report to traffic for the ego at a pose soon to come; `None` off all lanes.
    ///
    /// Inside a junction the ego is always reported in the middle of a lane: of its path's, or of the last one. Lanes overlap there, and
    /// SUMO would take a position beside the middle for one in another lane, with that lane's route.
    pub fn reported_place(&self, snapshot: &Snapshot, map: &RoadMap, pose: &Pose) -> (Option<LanePosition>, Pose) {
        let (net, last) = (&map.network, snapshot.ego_lane.map(|at| at.lane));
        let height_m = snapshot.ego.position.z;
        let front = pose.front(CAR_LENGTH_M);
        let front_s_m = map.route.project(front, Some(snapshot.ego_s_m)).s_m;
        let found = self.lanes.ego_lane(map, pose, height_m, front_s_m, last);
        let lane = found.or_else(|| {
            let lane = self.lanes.in_junction(map, front, snapshot.ego_s_m, last)?;
            Some(net.place_in(lane, front.extend(height_m)))
        });
        let inside = lane.filter(|at| !net.edge_of(at.lane).kind.is_street());
        let middle = inside.map(|at| net.pose(LanePosition { offset_m: 0.0, ..at }).flat());
        let reported =
            middle.map(|front| Pose { position: front.position - front.forward() * (CAR_LENGTH_M / 2.0), ..front });
        (lane, reported.unwrap_or(*pose))
    }

    /// Returns the position of a vehicle's front along this path, metres; `None` off the path.
    pub fn s_of(&self, map: &RoadMap, car: &VehicleSnapshot, near_s_m: f64) -> Option<f64> {
        self.lanes.s_at(map, car.lane?, car.pose.front(car.body.length_m), near_s_m)
    }

    /// Returns the ground around the ego.
    pub fn ground<'a>(&self, map: &'a RoadMap, snapshot: &Snapshot) -> NetworkGround<'a> {
        let (near, ego) = (snapshot.ego_lane.map(|at| at.lane), snapshot.ego.position);
        let way = RoadGround { route: &map.route, near_s_m: snapshot.ego_s_m };
        let clear = (ego.truncate(), map.network.clear_m(ego, SHOULDER_M, near));
        NetworkGround { network: &map.network, near, height_m: ego.z, way, clear }
    }

    /// Returns the ground at a position of the route, before the ego is there.
    pub fn ground_at(map: &RoadMap, s_m: f64) -> NetworkGround<'_> {
        let near = map.route.lanes()[map.route.lane_at(s_m).0].lane;
        let way = RoadGround { route: &map.route, near_s_m: s_m };
        NetworkGround { network: &map.network, near, height_m: map.route.height_m(s_m), way, clear: NONE_CLEAR }
    }

    /// Returns the distance from the ego's front bumper to the nearest line of its path that must not be crossed now, metres. It is the
    /// line of a signal, a line at which this driver must yield, or the last place for a lane change without a gap.
    pub fn stop_ahead_m(&self, snapshot: &Snapshot, map: &RoadMap, driver: &DriverParams) -> Option<f64> {
        let signal_m = self.signal_ahead_m(snapshot, map);
        let yield_m = self.right_of_way.must_yield_ahead_m(snapshot, map, driver);
        let change_m = self.changing.wait_ahead_m(snapshot, driver);
        [signal_m, yield_m, change_m].into_iter().flatten().min_by(f64::total_cmp)
    }

    /// Returns the vehicle of another lane behind which a driver on the path merges at a zipper.
    pub fn merges_behind(&self, snapshot: &Snapshot, map: &RoadMap) -> Option<SeenLeader> {
        self.right_of_way.merges_behind(snapshot, map)
    }

    /// Returns the nearest vehicle across the way: within a junction where the path has right of way, or one that follows no lane.
    pub fn across(&self, snapshot: &Snapshot, map: &RoadMap) -> Option<SeenLeader> {
        vehicles_across::nearest(snapshot, map, &|s_m| self.beside_m(map, s_m), &self.right_of_way)
    }

    /// Returns the nearest person in the ego's way, or at the crossing where they are, as a driver sees them.
    pub fn person_ahead(&self, snapshot: &Snapshot, map: &RoadMap) -> Option<SeenLeader> {
        self.persons.nearest(snapshot, &map.route, &|s_m| self.beside_m(map, s_m))
    }

    /// Returns the distance from the ego's front bumper to the line of the path's next signal, metres, if it must not be crossed now.
    fn signal_ahead_m(&self, snapshot: &Snapshot, map: &RoadMap) -> Option<f64> {
        let (ahead_m, line) = self.next_line(snapshot, map).filter(|(ahead_m, _)| *ahead_m < SIGNAL_AHEAD_M)?;
        let brakes_mps2 = match snapshot.signals.light(line.signal, line.link)? {
            SignalLight::Red | SignalLight::RedYellow => STOPS_FOR_RED_MPS2,
            SignalLight::Yellow => STOPS_MPS2,
            _ => return None,
        };
        let speed_mps = snapshot.ego.speed_mps.max(0.0);
        (speed_mps * speed_mps <= 2.0 * brakes_mps2 * ahead_m).then_some(ahead_m)
    }

    /// Returns the distance to the next line at a signal of the ego's path, metres, and the line.
    pub fn next_line(&self, snapshot: &Snapshot, map: &RoadMap) -> Option<(f64, &StopLine)> {
        let ahead =
            self.lanes.stop_lines().iter().map(|line| (map.route.drawn_ahead_m(snapshot.ego_s_m, line.s_m), line));
        ahead.filter(|(ahead_m, _)| *ahead_m >= 0.0).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Returns the side to which a driver on the path indicates now.
    pub fn indicator(&self, snapshot: &Snapshot, map: &RoadMap) -> Indicator {
        self.turns.indicator_at(map, snapshot.ego_s_m, self.changing.over_s_m())
    }

    /// Returns the next signal of the ego's path, at any distance; `None` if it is off or there is none.
    pub fn next_signal(&self, snapshot: &Snapshot, map: &RoadMap) -> Option<SignalAhead> {
        let (distance_m, line) = self.next_line(snapshot, map)?;
        let light = snapshot.signals.light(line.signal, line.link)?;
        if matches!(light, SignalLight::Off | SignalLight::OffBlinking) {
            return None;
        }
        let is_green = matches!(light, SignalLight::GreenMinor | SignalLight::GreenMajor);
        Some(SignalAhead { distance_m, is_green })
    }

    /// Returns the distance from the ego's front bumper to the next line of the path, metres: if `stops`, to a line with a mandatory stop,
    /// otherwise to a line at which the ego only yields.
    pub fn line_ahead_m(&self, snapshot: &Snapshot, map: &RoadMap, stops: bool) -> Option<f64> {
        self.right_of_way.line_ahead_m(snapshot, map, stops)
    }

    /// Returns the distance from the ego's front bumper to the end of the next edge on which its path changes lanes, metres.
    pub fn lane_end_ahead_m(&self, snapshot: &Snapshot, map: &RoadMap) -> Option<f64> {
        self.changing.lane_end_ahead_m(snapshot, map)
    }

    /// Returns the offset, from the route's line, of the line that a driver on the path follows at a position of the route, metres,
    /// positive to the left.
    pub fn beside_m(&self, map: &RoadMap, s_m: f64) -> f64 {
        self.changing.beside_m(map, s_m)
    }

    /// Returns true if the ego has reached the end of an open path on its last edge. A vehicle that crosses the end on another road is not
    /// at the end.
    pub fn is_at_end(&self, snapshot: &Snapshot, map: &RoadMap) -> bool {
        !map.route.is_closed() && self.is_on_last && snapshot.ego_s_m >= map.route.length_m()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ego::EgoState;
    use glam::{DVec2, dvec2};

    fn reported(map: &RoadMap, pose: Pose, ego_lane: Option<LanePosition>, ego_s_m: f64) -> (Option<String>, Pose) {
        let ego = EgoState { position: pose.position.extend(0.0), ..EgoState::default() };
        let snapshot = Snapshot { ego, ego_lane, ego_s_m, ..Snapshot::default() };
        let (lane, pose) = NetworkView::new(map).reported_place(&snapshot, map, &pose);
        (lane.map(|at| map.network.lane(at.lane).id.clone()), pose)
    }

    #[test]
    fn the_reported_pose_is_mid_lane_in_a_junction_and_exact_on_a_street() {
        // B0B1_0 has 69.2 m at x = 94.8 and ends at y = 79.6; straight on, :B1_11_0 goes on for 20.8 m.
        let map = RoadMap::load_along("tests/data/networks/grid-signals.net.xml", &["B0B1", "B1B2"]).expect("a path");
        let lane = |name: &str, s_m: f64| {
            let lane = map.network.lane_named(name).expect("a lane");
            Some(LanePosition { lane, s_m, offset_m: 0.0 })
        };
        let at = |x: f64, y: f64, yaw_rad: f64| {
            Pose::new(dvec2(x, y) - DVec2::from_angle(yaw_rad) * CAR_LENGTH_M / 2.0, yaw_rad)
        };
        let beside = at(95.3, 60.0, 1.5);
        assert_eq!(reported(&map, beside, lane("B0B1_0", 49.0), 49.0), (Some("B0B1_0".into()), beside));
        let (name, pose) = reported(&map, at(95.3, 90.0, 1.5), lane(":B1_11_0", 10.0), 79.6);
        assert_eq!(name.as_deref(), Some(":B1_11_0"));
        assert!(pose.front(CAR_LENGTH_M).distance(dvec2(94.8, 90.0)) < 1e-6, "{pose:?}");
        assert!((pose.yaw_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
        // Far off the roads no lane is reported.
        assert_eq!(reported(&map, at(300.0, 300.0, 1.5), None, 79.6).0, None);
    }

    #[test]
    fn an_ego_in_a_junction_is_reported_in_a_lane_even_where_it_is_in_none() {
        // From Ss into a roundabout whose junction s is wider than its lanes: somewhere in the junction there is no lane at any heading.
        let map = RoadMap::load_along("tests/data/networks/roundabout.net.xml", &["Ss", "se", "eE"]).expect("a path");
        let net = &map.network;
        let junction = net.junctions().iter().find(|junction| junction.id == "s").expect("a junction");
        let entry = net.lane_named("Ss_0").expect("a lane");
        let end = LanePosition { lane: entry, s_m: net.lane(entry).length_m, offset_m: 0.0 };
        let view = NetworkView::new(&map);
        let mut lost = 0;
        for k in 0..40_000 {
            let place = junction.position.truncate() + dvec2(f64::from(k % 200), f64::from(k / 200)) * 0.15 - 15.0;
            let pose = Pose::new(place - dvec2(CAR_LENGTH_M / 2.0, 0.0), 0.0);
            if junction.covers(place) && view.lanes.ego_lane(&map, &pose, 0.0, end.s_m, Some(entry)).is_none() {
                lost += 1;
                assert!(reported(&map, pose, Some(end), end.s_m).0.is_some(), "{place}");
            }
        }
        assert!(lost > 0, "there is such a place");
    }
}
