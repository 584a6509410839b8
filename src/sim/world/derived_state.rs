//! What follows from where the cars are. In: the ego's pose and the cars of a [`Snapshot`]. Out: in that snapshot the ego's
//! place on the road, its leader and the mean speed; an event when it leaves its lane or is back. Metres, m/s.

use crate::{
    map::{Route, network::SignalStates},
    sim::{
        Event, EventKind, Snapshot,
        snapshot::{Leader, VehicleSnapshot},
    },
    space::{CAR_LENGTH_M, Pose},
    time::Tick,
    traffic::CarState,
};

/// How far inside the lane's edge the ego is back on the road, metres: no flicker of events at the edge.
const BACK_INSIDE_M: f64 = 0.2;

/// Tick 0 with the cars where their engine has them; what follows from that is not derived yet.
pub(super) fn first_snapshot(ego: &crate::ego::EgoState, ego_s_m: f64, others: &[CarState]) -> Snapshot {
    Snapshot {
        tick: Tick(0),
        ego: *ego,
        ego_before: *ego,
        ego_s_m,
        lane_offset_m: 0.0,
        cars: others.iter().map(VehicleSnapshot::at_start).collect(),
        signals: SignalStates::default(),
        leader: None,
        advice: None,
        mean_speed_mps: 0.0,
    }
}

/// Where the ego is on the road, who leads, how fast all are.
pub(super) fn update(snapshot: &mut Snapshot, route: &Route, ego: &Pose) {
    let place = route.project(ego.front(CAR_LENGTH_M), Some(snapshot.ego_s_m));
    let middle = route.project(ego.position, Some(place.s_m));
    snapshot.ego_s_m = place.s_m;
    snapshot.lane_offset_m = middle.offset_m;
    snapshot.leader = snapshot
        .cars
        .iter()
        .map(|car| (route.ahead(place.s_m, car.s_m), car))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(headway_m, car)| Leader { id: car.id, gap_m: headway_m - CAR_LENGTH_M, speed_mps: car.speed_mps });
    let sum: f64 = snapshot.cars.iter().map(|car| car.speed_mps).sum();
    snapshot.mean_speed_mps = (sum + snapshot.ego.speed_mps) / (snapshot.cars.len() + 1) as f64;
}

/// Whether the middle of the ego is in its lane.
pub(super) struct LaneMonitor {
    is_in_lane: bool,
}

impl LaneMonitor {
    /// It starts there.
    pub fn new() -> Self {
        Self { is_in_lane: true }
    }

    /// True while it is.
    pub fn is_in_lane(&self) -> bool {
        self.is_in_lane
    }

    /// The event of this tick, if it has left or is back.
    pub fn watch(&mut self, snapshot: &Snapshot, route: &Route) -> Option<Event> {
        let half_m = route.width_m(snapshot.ego_s_m) / 2.0;
        let off_m = snapshot.lane_offset_m.abs();
        let kind = if self.is_in_lane && off_m > half_m {
            EventKind::LeftRoad { s_m: snapshot.ego_s_m, offset_m: snapshot.lane_offset_m }
        } else if !self.is_in_lane && off_m < half_m - BACK_INSIDE_M {
            EventKind::BackOnRoad
        } else {
            return None;
        };
        self.is_in_lane = !self.is_in_lane;
        Some(Event { tick: snapshot.tick, kind })
    }
}
