//! Order of a fixed number of vehicles on a route. In: the view of all vehicles at a step's end. Out: the leader of each. Metres, m/s.

use crate::{
    map::Route,
    sim::{Leader, Snapshot, VehicleSnapshot},
    traffic::VehicleId,
};

/// Vehicles of a route in driving order.
#[derive(Default)]
pub(super) struct DrivingOrder {
    /// Front bumpers along the route, ids, lengths and speeds, by position.
    places: Vec<(f64, VehicleId, f64, f64)>,
}

impl DrivingOrder {
    /// Takes the vehicles that are on the route in a view, and the observer's own.
    pub fn take(&mut self, view: &Snapshot, own: Option<&VehicleSnapshot>) {
        let on_route = view.vehicles().chain(own);
        self.places.clear();
        self.places.extend(on_route.filter_map(|car| Some((car.s_m?, car.id, car.body.length_m, car.speed_mps))));
        self.places.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    }

    /// Returns the leader of a vehicle; `None` for one that is alone, not on the route, or the first on an open one.
    pub fn leader(&self, id: VehicleId, route: &Route) -> Option<Leader> {
        let at = self.places.iter().position(|place| place.1 == id)?;
        if !route.is_closed() && at + 1 == self.places.len() {
            return None;
        }
        let (next_m, leader, length_m, speed_mps) = self.places[(at + 1) % self.places.len()];
        let gap_m = route.drawn_ahead_m(self.places[at].0, next_m) - length_m;
        let speed_mps = speed_mps * route.drawn_scale(next_m);
        (leader != id).then_some(Leader { id: leader, gap_m, speed_mps })
    }
}
