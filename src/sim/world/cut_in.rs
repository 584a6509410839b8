//! Cut-in of a vehicle of a neighbouring lane before the ego. In: both vehicles where a step begins. Out: the vehicle's motion in that step, and when it
//! changes lanes. Metres, m/s.

use super::event_view::ScriptView;
use crate::{
    sim::VehicleSnapshot,
    time::Tick,
    traffic::{LaneMotion, VehicleId},
};

/// Speed by which the vehicle closes up, per metre that it is off its place, 1/s; and the most of it, m/s.
const CLOSES_PER_S: f64 = 0.4;
const CLOSES_MPS: f64 = 8.0;
/// Largest change of its speed, m/s2.
const RATE_MPS2: f64 = 3.0;
/// Errors of place and speed within which it changes lanes, m and m/s.
const NEAR_M: f64 = 1.0;
const NEAR_MPS: f64 = 1.0;
/// Lateral distance to the ego's way at which it is in the ego's lane, m.
const IN_LANE_M: f64 = 0.8;
/// Time for the change of lanes itself, s.
const CHANGE_S: f64 = 10.0;

/// Vehicle on its way into the ego's lane.
#[derive(Debug)]
pub(super) struct CutIn {
    /// Number of the event.
    pub event: usize,
    pub id: VehicleId,
    /// Gap from the ego's front to the vehicle's rear, m.
    pub gap_m: f64,
    /// Tick by which the change has to have begun.
    pub until: Tick,
    /// Tick at which the change began.
    pub changing_since: Option<Tick>,
}

/// Behaviour of a vehicle that cuts in, in the step that begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum CutInStep {
    /// Drive on towards its place, or into the lane.
    Drives(LaneMotion),
    /// Begin of the change of lanes, by this many to the left.
    Changes(LaneMotion, i32),
    /// End of the cut-in: the vehicle is in the ego's lane.
    Over,
    /// End without a place in its time.
    TooLate,
}

impl CutIn {
    /// Returns what the vehicle does in the step that begins.
    pub fn step(&mut self, car: &VehicleSnapshot, seen: &ScriptView, step_s: f64) -> CutInStep {
        let (view, route) = (seen.view, &seen.map.route);
        let Some(own) = seen.own() else { return CutInStep::TooLate };
        let now = view.tick;
        let front =
            |vehicle: &VehicleSnapshot| route.project(vehicle.pose.front(vehicle.body.length_m), Some(view.ego_s_m));
        let (own_at, at) = (front(own), front(car));
        let aside_m = at.offset_m - own_at.offset_m;
        let keeps = LaneMotion { id: self.id, mean_mps: car.speed_mps, end_mps: car.speed_mps };
        if let Some(since) = self.changing_since {
            return match aside_m.abs() < IN_LANE_M {
                true => CutInStep::Over,
                false if now.seconds() > since.seconds() + CHANGE_S => CutInStep::TooLate,
                false => CutInStep::Drives(keeps),
            };
        }
        if now >= self.until {
            return CutInStep::TooLate;
        }
        let off_m = self.gap_m + car.body.length_m - route.difference(own_at.s_m, at.s_m);
        let wanted_mps = own.speed_mps + (CLOSES_PER_S * off_m).clamp(-CLOSES_MPS, CLOSES_MPS);
        if off_m.abs() < NEAR_M && (car.speed_mps - own.speed_mps).abs() < NEAR_MPS {
            self.changing_since = Some(now);
            return CutInStep::Changes(keeps, if aside_m > 0.0 { -1 } else { 1 });
        }
        let change_mps = (wanted_mps - car.speed_mps).clamp(-RATE_MPS2 * step_s, RATE_MPS2 * step_s);
        let end_mps = (car.speed_mps + change_mps).max(0.0);
        CutInStep::Drives(LaneMotion { id: self.id, mean_mps: (car.speed_mps + end_mps) / 2.0, end_mps })
    }
}
