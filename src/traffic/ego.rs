//! The reported ego as traffic sees it: one rule for both engines. In: an [`ExternalVehicleState`] and the route. Out: where on the
//! route the ego is and whether others see it there. Metres, m/s.

use super::{CarState, EGO, ExternalVehicleState, TrafficError, motion::SpeedStep};
use crate::{
    map::{Route, RoutePosition},
    space::{CAR_LENGTH_M, CAR_WIDTH_M, Pose},
};

impl ExternalVehicleState {
    /// Fails if a number in it is not finite: SUMO accepts NaN without a word, and the car is gone.
    ///
    /// # Errors
    /// [`TrafficError::NotFinite`].
    pub fn check(&self) -> Result<(), TrafficError> {
        let numbers = [
            ("x", self.pose.position.x),
            ("y", self.pose.position.y),
            ("heading", self.pose.yaw_rad),
            ("speed", self.speed_mps),
            ("predicted x", self.next_pose.position.x),
            ("predicted y", self.next_pose.position.y),
            ("predicted heading", self.next_pose.yaw_rad),
            ("predicted speed", self.next_speed_mps),
        ];
        match numbers.iter().find(|(_, value)| !value.is_finite()) {
            Some(&(what, value)) => Err(TrafficError::NotFinite { what, car: EGO.0, value }),
            None => Ok(()),
        }
    }
}

/// Front bumper of a car at `pose` on the route. `near_s_m` as in [`Route::project`].
pub(super) fn place(route: &Route, pose: &Pose, near_s_m: Option<f64>) -> RoutePosition {
    route.project(pose.front(CAR_LENGTH_M), near_s_m)
}

/// True if a part of the car's body is on the lane: 2.5 m off the centre of a lane of 3.2 m is the last place where others
/// see it.
pub(super) fn is_on_lane(route: &Route, point: RoutePosition) -> bool {
    point.offset_m.abs() <= (route.width_m(point.s_m) + CAR_WIDTH_M) / 2.0
}

/// Brings the ego's state to the end of a step that `report` described, at `s_m`.
pub(super) fn follow(ego: &mut CarState, report: &ExternalVehicleState, s_m: f64, step_s: f64) {
    let next_mps = report.next_speed_mps.max(0.0);
    ego.s_m = s_m;
    ego.pose = report.next_pose;
    ego.set_motion(
        SpeedStep { before_mps: report.speed_mps.max(0.0), chosen_mps: next_mps, after_mps: next_mps },
        step_s,
    );
}

/// What to say if the ego's model shall drive it from beside the road.
pub(super) fn off_the_road() -> TrafficError {
    TrafficError::Setup("the ego is beside the road: its model cannot drive it from there".to_string())
}
