//! What a drive on a network knows beside the ego's route. In: the map and the snapshot. Out: the ego's lane, the ground under it, the line at
//! a signal, or where others go first, where it has to stop, whether it is at the end of its path. Metres, m/s.

use super::{gap_acceptance::LaneChanging, give_way::GiveWay, path_lanes::PathLanes, turns::Turns};
use crate::{
    controls::Indicator,
    driver::DriverParams,
    map::{
        RoadMap, StopLine,
        network::{LanePosition, SignalLight},
    },
    policy::SignalAhead,
    sim::{
        Snapshot, VehicleSnapshot,
        ground::{NetworkGround, RoadGround},
    },
    space::{CAR_LENGTH_M, Pose},
};

/// A driver stops for a yellow light if this is enough, m/s2 (the deceleration that German rules for times of yellow reckon with is
/// 3.5, American ones 3.05).
const STOPS_MPS2: f64 = 3.0;
/// And for a red one if this is: who began to brake for yellow, late by a reaction time, goes on braking.
const STOPS_FOR_RED_MPS2: f64 = 6.0;
/// So far ahead a signal matters, metres.
const SIGNAL_AHEAD_M: f64 = 300.0;

/// The ego's path through a network.
pub(super) struct NetworkView {
    lanes: PathLanes,
    give_way: GiveWay,
    changing: LaneChanging,
    turns: Turns,
    /// The ego is on the last edge of its path, or was there until its front came to the end.
    is_on_last: bool,
}

impl NetworkView {
    /// The path of a map's route.
    pub fn new(map: &RoadMap) -> Self {
        let lanes = PathLanes::new(map);
        let give_way = GiveWay::new(lanes.yield_lines(map));
        let changes = lanes.lane_changes(map);
        Self {
            give_way,
            turns: lanes.turns(map, &changes),
            changing: LaneChanging::new(changes),
            lanes,
            is_on_last: false,
        }
    }

    /// Notes in the snapshot in which lane the ego's front is.
    pub fn locate(&mut self, snapshot: &mut Snapshot, map: &RoadMap, ego: &Pose) {
        let last = snapshot.ego_lane.map(|at| at.lane);
        let height_m = snapshot.ego.position.z;
        snapshot.ego_lane = self.lanes.ego_lane(map, ego, height_m, snapshot.ego_s_m, last);
        let edge = |at: LanePosition| map.network.edge_of(at.lane).id.as_str();
        let is_on_last = snapshot.ego_lane.map(edge) == map.route.lanes().last().map(|lane| lane.edge.as_str());
        let has_left = snapshot.ego_lane.is_none() || snapshot.ego_s_m < map.route.length_m();
        self.is_on_last = is_on_last || (self.is_on_last && !has_left);
    }

    /// Notes how the ego stands at the next line, and how far it is with a change of lanes; the leader there is that in its own lane.
    pub fn look_around(&mut self, snapshot: &mut Snapshot, map: &RoadMap) {
        self.changing.update(snapshot, map);
        self.give_way.update(snapshot, map);
    }

    /// The lane in which the ego will be at a pose soon, and the pose, as traffic is told: `None` beside all lanes.
    ///
    /// Inside a junction it is always in a lane, in that of its path or that in which it was last, and in the middle of that: lanes lie over each
    /// other there, and SUMO would take a place beside the middle for one in another lane, with the route of that.
    pub fn told(&self, snapshot: &Snapshot, map: &RoadMap, pose: &Pose) -> (Option<LanePosition>, Pose) {
        let (net, last) = (&map.network, snapshot.ego_lane.map(|at| at.lane));
        let height_m = snapshot.ego.position.z;
        let found = self.lanes.ego_lane(map, pose, height_m, snapshot.ego_s_m, last);
        let front = pose.front(CAR_LENGTH_M);
        let lane = found.or_else(|| {
            let lane = self.lanes.in_junction(map, front, snapshot.ego_s_m, last)?;
            Some(net.place_in(lane, front.extend(height_m)))
        });
        let inside = lane.filter(|at| !net.edge_of(at.lane).kind.is_street());
        let middle = inside.map(|at| net.pose(LanePosition { offset_m: 0.0, ..at }).flat());
        let told =
            middle.map(|front| Pose { position: front.position - front.forward() * (CAR_LENGTH_M / 2.0), ..front });
        (lane, told.unwrap_or(*pose))
    }

    /// Where a vehicle's front is along this path, metres; `None` beside it.
    pub fn s_of(&self, map: &RoadMap, car: &VehicleSnapshot, near_s_m: f64) -> Option<f64> {
        self.lanes.s_at(map, car.lane?, car.pose.front(car.body.length_m), near_s_m)
    }

    /// The ground around the ego.
    pub fn ground<'a>(&self, map: &'a RoadMap, snapshot: &Snapshot) -> NetworkGround<'a> {
        let lane = snapshot.ego_lane.map(|at| at.lane);
        let way = RoadGround { route: &map.route, near_s_m: snapshot.ego_s_m };
        NetworkGround { network: &map.network, near: lane, height_m: snapshot.ego.position.z, way }
    }

    /// The ground at a place of the route, before the ego is there.
    pub fn ground_at<'a>(&self, map: &'a RoadMap, s_m: f64) -> NetworkGround<'a> {
        let near = map.network.lane_named(&map.route.lanes()[map.route.lane_at(s_m).0].id);
        let way = RoadGround { route: &map.route, near_s_m: s_m };
        NetworkGround { network: &map.network, near, height_m: map.route.height_m(s_m), way }
    }

    /// Way from the ego's front bumper to the nearest line of its path that must not be crossed now, metres: a signal's, one where others
    /// go first before this driver, or the last place to change lanes from while there is no gap.
    pub fn stop_ahead_m(&self, snapshot: &Snapshot, map: &RoadMap, driver: &DriverParams) -> Option<f64> {
        let signal_m = self.signal_ahead_m(snapshot, map);
        let yield_m = self.give_way.must_yield_ahead_m(snapshot, map, driver);
        let change_m = self.changing.wait_ahead_m(snapshot, driver);
        [signal_m, yield_m, change_m].into_iter().flatten().min_by(f64::total_cmp)
    }

    /// Way from the ego's front bumper to the line of the next signal of its path, if that must not be crossed now, metres.
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

    /// The next line at a signal of the ego's path, and the way to it, metres.
    fn next_line(&self, snapshot: &Snapshot, map: &RoadMap) -> Option<(f64, &StopLine)> {
        let ahead =
            self.lanes.stop_lines().iter().map(|line| (map.route.drawn_ahead_m(snapshot.ego_s_m, line.s_m), line));
        ahead.filter(|(ahead_m, _)| *ahead_m >= 0.0).min_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// The side to which a driver on the path indicates now.
    pub fn indicator(&self, snapshot: &Snapshot, map: &RoadMap) -> Indicator {
        self.turns.indicator_at(map, snapshot.ego_s_m, self.changing.over_s_m())
    }

    /// The next signal of the ego's path, however far; one that is off is none.
    pub fn next_signal(&self, snapshot: &Snapshot, map: &RoadMap) -> Option<SignalAhead> {
        let (distance_m, line) = self.next_line(snapshot, map)?;
        let light = snapshot.signals.light(line.signal, line.link)?;
        if matches!(light, SignalLight::Off | SignalLight::OffBlinking) {
            return None;
        }
        let is_green = matches!(light, SignalLight::GreenMinor | SignalLight::GreenMajor);
        Some(SignalAhead { distance_m, is_green })
    }

    /// Way from the ego's front bumper to the next line where others go first, metres; only those at which one stops in any case, or only the
    /// others.
    pub fn line_ahead_m(&self, snapshot: &Snapshot, map: &RoadMap, stops: bool) -> Option<f64> {
        self.give_way.line_ahead_m(snapshot, map, stops)
    }

    /// Way from the ego's front bumper to the end of the next edge on which its path changes lanes, metres.
    pub fn lane_end_ahead_m(&self, snapshot: &Snapshot, map: &RoadMap) -> Option<f64> {
        self.changing.lane_end_ahead_m(snapshot, map)
    }

    /// How far to the left of the route's line the line is that a driver on the path follows at a place of it, metres.
    pub fn beside_m(&self, map: &RoadMap, s_m: f64) -> f64 {
        self.changing.beside_m(map, s_m)
    }

    /// True once the ego has come over the last edge of an open path to its end. Who crosses there on another way is not at it.
    pub fn is_at_end(&self, snapshot: &Snapshot, map: &RoadMap) -> bool {
        !map.route.is_closed() && self.is_on_last && snapshot.ego_s_m >= map.route.length_m()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ego::EgoState;
    use glam::{DVec2, dvec2};

    fn told(map: &RoadMap, pose: Pose, ego_lane: Option<LanePosition>, ego_s_m: f64) -> (Option<String>, Pose) {
        let ego = EgoState { position: pose.position.extend(0.0), ..EgoState::default() };
        let snapshot = Snapshot { ego, ego_lane, ego_s_m, ..Snapshot::default() };
        let (lane, pose) = NetworkView::new(map).told(&snapshot, map, &pose);
        (lane.map(|at| map.network.lane(at.lane).id.clone()), pose)
    }

    #[test]
    fn inside_a_junction_traffic_is_told_of_the_middle_of_the_lane_and_on_a_street_of_the_place() {
        // B0B1_0 has 69.2 m in x = 94.8, and ends at y = 79.6; its way straight on, :B1_11_0, leads 20.8 m on.
        let map = RoadMap::load_along("tests/data/networks/grid-signals.net.xml", &["B0B1", "B1B2"]).expect("a path");
        let lane = |name: &str, s_m: f64| {
            let lane = map.network.lane_named(name).expect("a lane");
            Some(LanePosition { lane, s_m, offset_m: 0.0 })
        };
        let at = |x: f64, y: f64, yaw_rad: f64| {
            Pose::new(dvec2(x, y) - DVec2::from_angle(yaw_rad) * CAR_LENGTH_M / 2.0, yaw_rad)
        };
        let beside = at(95.3, 60.0, 1.5);
        assert_eq!(told(&map, beside, lane("B0B1_0", 49.0), 49.0), (Some("B0B1_0".into()), beside));
        let (name, pose) = told(&map, at(95.3, 90.0, 1.5), lane(":B1_11_0", 10.0), 79.6);
        assert_eq!(name.as_deref(), Some(":B1_11_0"));
        assert!(pose.front(CAR_LENGTH_M).distance(dvec2(94.8, 90.0)) < 1e-6, "{pose:?}");
        assert!((pose.yaw_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
        // Far beside the roads nobody is told.
        assert_eq!(told(&map, at(300.0, 300.0, 1.5), None, 79.6).0, None);
    }

    #[test]
    fn who_is_in_a_junction_but_in_none_of_its_lanes_is_still_there_for_traffic() {
        // From Ss into a roundabout whose junction s is wider than its lanes: somewhere in it there is no lane, whichever way one points.
        let map = RoadMap::load_along("tests/data/networks/roundabout.net.xml", &["Ss", "se", "eE"]).expect("a path");
        let net = &map.network;
        let junction = net.junction(net.junction_named("s").expect("a junction"));
        let entry = net.lane_named("Ss_0").expect("a lane");
        let end = LanePosition { lane: entry, s_m: net.lane(entry).length_m, offset_m: 0.0 };
        let view = NetworkView::new(&map);
        let mut lost = 0;
        for k in 0..40_000 {
            let place = junction.position.truncate() + dvec2(f64::from(k % 200), f64::from(k / 200)) * 0.15 - 15.0;
            let pose = Pose::new(place - dvec2(CAR_LENGTH_M / 2.0, 0.0), 0.0);
            if junction.covers(place) && view.lanes.ego_lane(&map, &pose, 0.0, end.s_m, Some(entry)).is_none() {
                lost += 1;
                assert!(told(&map, pose, Some(end), end.s_m).0.is_some(), "{place}");
            }
        }
        assert!(lost > 0, "there is such a place");
    }
}
