//! State that follows from the vehicles' poses. In: the ego's pose and the vehicles of a [`Snapshot`]. Out: in that snapshot the ego's
//! position on the road, its leader and the mean speed; events when the ego leaves the road and returns. Metres, m/s.

use crate::{
    controls::Indicator,
    map::{Route, RoutePosition, network::SignalStates},
    policy::NearVehicle,
    sim::{Event, EventKind, Leader, Snapshot, VehicleSnapshot},
    snapshot::{AutomationState, TaskDisplay},
    space::{CAR_LENGTH_M, CAR_WIDTH_M, Pose, is_one_road},
    time::Tick,
};

/// Returns the snapshot of tick 0 without other vehicles and without derived state.
pub(super) fn first_snapshot(ego: &crate::ego::EgoState, ego_s_m: f64) -> Snapshot {
    Snapshot {
        tick: Tick(0),
        is_without_ego: false,
        ego: *ego,
        ego_before: *ego,
        ego_s_m,
        ego_lane: None,
        ego_indicator: Indicator::Off,
        ego_main_beam: false,
        next_manoeuvre: None,
        lane_offset_m: 0.0,
        cars: Vec::new(),
        signals: SignalStates::default(),
        leader: None,
        advice: None,
        message: None,
        stimuli: None,
        question: None,
        weather: None,
        mean_speed_mps: 0.0,
        task: TaskDisplay::default(),
        automation: AutomationState::default(),
    }
}

/// Updates the ego's position on the route: the front's position along it and the centre's lateral offset.
pub(super) fn locate(snapshot: &mut Snapshot, route: &Route, ego: &Pose) {
    let place = route.project(ego.front(CAR_LENGTH_M), Some(snapshot.ego_s_m));
    let middle = route.project(ego.position, Some(place.s_m));
    snapshot.ego_s_m = place.s_m;
    snapshot.lane_offset_m = middle.offset_m;
}

/// Returns the ego's front along the route and its centre's lateral offset as one position.
pub(super) fn own_place(snapshot: &Snapshot) -> RoutePosition {
    RoutePosition { s_m: snapshot.ego_s_m, offset_m: snapshot.lane_offset_m }
}

/// Updates the leader and the mean speed.
pub(super) fn update_derived(snapshot: &mut Snapshot, route: &Route) {
    look_at_all(snapshot);
    let ego_s_m = snapshot.ego_s_m;
    // On an open route the distance ahead to vehicles behind is negative.
    let on_route = snapshot.vehicles().filter_map(|car| match car.s_m {
        // The speed is scaled to the drawn length of a lane whose declared length is longer.
        Some(s_m) => {
            let speed_mps = car.speed_mps * route.drawn_scale(s_m);
            Some((route.drawn_ahead_m(ego_s_m, s_m) - car.body.length_m, speed_mps, car))
        }
        None => in_the_way(car, route, ego_s_m),
    });
    snapshot.leader = on_route
        .filter(|(gap_m, _, car)| route.is_closed() || *gap_m >= -car.body.length_m)
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(gap_m, speed_mps, car)| Leader { id: car.id, gap_m, speed_mps });
}

/// Updates the mean speed.
pub(super) fn look_at_all(snapshot: &mut Snapshot) {
    let sum: f64 = snapshot.speeds_mps().sum();
    snapshot.mean_speed_mps = sum / snapshot.speeds_mps().count().max(1) as f64;
}

/// Returns the vehicle behind the ego on its route.
pub(super) fn follower(snapshot: &Snapshot, route: &Route) -> Option<NearVehicle> {
    // Below one lap on closed routes; negative on open routes for vehicles ahead.
    let behind_m = |s_m: f64| route.drawn_ahead_m(s_m, snapshot.ego_s_m);
    let behind = snapshot.cars.iter().filter_map(|car| {
        let s_m = car.s_m?;
        Some((behind_m(s_m), car.speed_mps * route.drawn_scale(s_m)))
    });
    let nearest = behind.filter(|(behind_m, _)| *behind_m > 0.0).min_by(|a, b| a.0.total_cmp(&b.0));
    nearest.map(|(behind_m, speed_mps)| NearVehicle { gap_m: behind_m - CAR_LENGTH_M, speed_mps })
}

/// Returns the gap, metres, and the speed along the route, m/s, of a vehicle whose front has left the ego's route while its rear is still
/// in the ego's way. A vehicle on a bridge above the route, or below it, is not in the way.
fn in_the_way<'a>(car: &'a VehicleSnapshot, route: &Route, ego_s_m: f64) -> Option<(f64, f64, &'a VehicleSnapshot)> {
    let tail = route.project(car.pose.rear(car.body.length_m), Some(ego_s_m));
    let gap_m = route.difference(ego_s_m, tail.s_m);
    let is_in_it = tail.offset_m.abs() < (CAR_WIDTH_M + car.body.width_m) / 2.0;
    let is_level = is_one_road(car.height_m, route.height_m(tail.s_m));
    let along = (car.pose.yaw_rad - route.yaw_at(tail.s_m)).cos();
    (is_in_it && is_level && gap_m > 0.0).then_some((gap_m, (car.speed_mps * along).max(0.0), car))
}

/// Watches whether the ego's centre is in its lane.
pub(super) struct LaneMonitor {
    is_in_lane: bool,
}

impl LaneMonitor {
    /// Returns a monitor of an ego that starts in its lane.
    pub fn new() -> Self {
        Self { is_in_lane: true }
    }

    /// Returns true while the ego's centre is in its lane.
    pub fn is_in_lane(&self) -> bool {
        self.is_in_lane
    }

    /// Returns the event of this tick, if the ego has left the road or is back. `is_on_road`: its centre is on asphalt.
    pub fn watch(&mut self, snapshot: &Snapshot, is_on_road: bool) -> Option<Event> {
        let kind = if self.is_in_lane && !is_on_road {
            EventKind::LeftRoad { s_m: snapshot.ego_s_m, offset_m: snapshot.lane_offset_m }
        } else if !self.is_in_lane && is_on_road {
            EventKind::BackOnRoad
        } else {
            return None;
        };
        self.is_in_lane = !self.is_in_lane;
        Some(Event { tick: snapshot.tick, kind })
    }
}
