//! Drivers behind one another on a route of one lane. In: places and speeds. Out: the acceleration that each driver chooses, all from one
//! state. On an open route, the first vehicle has a free road. Metres, m/s, m/s2.

use super::{HARDEST_MPS2, bends::BendSpeeds, drivers::TrafficDriver};
use crate::{map::Route, space::CAR_LENGTH_M};

/// Drivers of a route, by vehicle number.
#[derive(Clone, Debug)]
pub(super) struct LaneFollowers {
    drivers: Vec<TrafficDriver>,
    bends: Option<BendSpeeds>,
    /// Numbers of the vehicles that others see, in driving order.
    order: Vec<usize>,
}

impl LaneFollowers {
    pub fn new(drivers: Vec<TrafficDriver>, bends: Option<BendSpeeds>) -> Self {
        Self { order: Vec::with_capacity(drivers.len()), drivers, bends }
    }

    /// Computes the acceleration of every visible vehicle, all from the present state; those of others stay as they are.
    pub fn choose(
        &mut self,
        route: &Route,
        step_s: f64,
        s_m: &[f64],
        speed_mps: &[f64],
        is_seen: &[bool],
        accel_mps2: &mut [f64],
    ) {
        self.sort(s_m, is_seen);
        for k in 0..self.order.len() {
            let (i, leader) = (self.order[k], self.order[(k + 1) % self.order.len()]);
            let bend_mps = self.bends.as_ref().map_or(f64::INFINITY, |bends| bends.at(s_m[i]));
            let limit_mps = route.speed_limit_mps(s_m[i]).min(bend_mps);
            // The leader of the last vehicle in the order is one lap ahead; a single vehicle follows itself.
            let lap_m = match k + 1 == self.order.len() {
                true if route.is_closed() => route.length_m(),
                true => f64::INFINITY,
                false => 0.0,
            };
            let gap_m = s_m[leader] + lap_m - s_m[i] - CAR_LENGTH_M;
            let model = &self.drivers[i].model;
            let accel = model.acceleration(speed_mps[i], speed_mps[leader], gap_m, limit_mps);
            accel_mps2[i] = accel.clamp(-HARDEST_MPS2, HARDEST_MPS2);
            if speed_mps[i] + accel * step_s > bend_mps {
                // The model approaches a lower desired speed slowly; a driver does not enter a bend too fast.
                let down_mps2 = (bend_mps - speed_mps[i]) / step_s;
                accel_mps2[i] = accel_mps2[i].min(down_mps2.max(-model.comfortable_mps2()));
            }
        }
    }

    /// Sorts the visible vehicles by position. Needed in every step: vehicles do not overtake, but one that left the lane may return
    /// anywhere.
    fn sort(&mut self, s_m: &[f64], is_seen: &[bool]) {
        self.order.clear();
        self.order.extend((0..s_m.len()).filter(|car| is_seen[*car]));
        self.order.sort_unstable_by(|&a, &b| s_m[a].total_cmp(&s_m[b]).then(a.cmp(&b)));
    }
}
