//! The ego back on its lane, for a driver who has no way back: from the meadow, or turned around on the road. In: the wish,
//! between two ticks. Out: the next tick has the car on the lane, in the gap where it left it, as fast as the slower one of the
//! two cars around it; an event says so, and a replay does the same at the same tick.

use super::{World, WorldError, car_params};
use crate::{
    ego::EgoCar,
    sim::{Event, EventKind},
    space::CAR_LENGTH_M,
    time::Tick,
};

/// Room that is left to the cars ahead and behind, metres.
const MARGIN_M: f64 = 1.0;
/// A car that heads further off its lane than this has no easy way back, radians.
const ASTRAY_RAD: f64 = 1.0;

/// Why a car is not put back on its lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotPutBack {
    /// It is there.
    #[error("the car is on its lane")]
    OnLane,
    /// Other cars are too close together where it left the lane.
    #[error("there is no room on the lane here: try again when the cars have moved on")]
    NoRoom,
    /// Nothing moves any more.
    #[error("the drive is over")]
    Over,
}

impl World {
    /// True if the ego is off its lane, or heads away from it.
    pub fn is_astray(&self) -> bool {
        !self.lane.is_in_lane() || self.lane_hint().heading_error_rad.abs() > ASTRAY_RAD
    }

    /// With the next tick the ego stands on its lane again.
    ///
    /// # Errors
    /// It is there, there is no room, or the drive is over.
    pub fn put_back(&mut self) -> Result<(), NotPutBack> {
        if self.ended.is_some() {
            return Err(NotPutBack::Over);
        }
        if !self.is_astray() {
            return Err(NotPutBack::OnLane);
        }
        self.room().ok_or(NotPutBack::NoRoom)?;
        self.wants_back = true;
        Ok(())
    }

    /// Obeys that wish, when the other cars of this tick are where they will be.
    pub(super) fn stand_on_lane(&mut self) -> Result<(), WorldError> {
        if !std::mem::take(&mut self.wants_back) {
            return Ok(());
        }
        let Some((s_m, speed_mps)) = self.room() else { return Ok(()) };
        let pose = self.map.route.pose_of_front(s_m, CAR_LENGTH_M);
        self.ego = EgoCar::new(&car_params(&self.scenario), pose, speed_mps, self.snapshot.cars.len())?;
        self.snapshot.ego_s_m = s_m;
        let tick = Tick(self.snapshot.tick.0 + 1);
        self.events.push(Event { tick, kind: EventKind::PutBack { s_m } });
        Ok(())
    }

    /// Where the ego's front can stand, nearest to where it is along the route, and the speed that fits there.
    fn room(&self) -> Option<(f64, f64)> {
        let (route, here_m) = (&self.map.route, self.snapshot.ego_s_m);
        let cars = &self.snapshot.cars;
        let ahead = cars
            .iter()
            .map(|car| (route.ahead(here_m, car.s_m) - CAR_LENGTH_M, car.speed_mps))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let behind =
            cars.iter().map(|car| (route.ahead(car.s_m, here_m), car.speed_mps)).min_by(|a, b| a.0.total_cmp(&b.0));
        let (Some((ahead_m, ahead_mps)), Some((behind_m, behind_mps))) = (ahead, behind) else {
            return Some((here_m, 0.0));
        };
        let [first_m, last_m] = [CAR_LENGTH_M + MARGIN_M - behind_m, ahead_m - MARGIN_M];
        let s_m = route.wrap(here_m + 0.0_f64.clamp(first_m.min(last_m), last_m));
        (first_m <= last_m).then_some((s_m, ahead_mps.min(behind_mps)))
    }
}
