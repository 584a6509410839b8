//! Reported cars as traffic sees them: one rule for both engines. In: [`VehicleReport`]s and the route. Out: where on the
//! route such a car is and whether others see it there. Metres, m/s.

use super::{CarState, ExternalVehicleState, TrafficError, VehicleId, VehicleReport, motion::SpeedStep};
use crate::{
    map::{Route, RoutePosition},
    space::{CAR_LENGTH_M, CAR_WIDTH_M, Pose},
};

impl ExternalVehicleState {
    /// Fails if a number in it is not finite: SUMO accepts NaN without a word, and the car is gone.
    ///
    /// # Errors
    /// [`TrafficError::NotFinite`].
    pub fn check(&self, car: VehicleId) -> Result<(), TrafficError> {
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
            Some(&(what, value)) => Err(TrafficError::NotFinite { what, car: car.0, value }),
            None => Ok(()),
        }
    }
}

/// Fails unless these are reports of different ones of `cars` cars, by ascending id, and every car that was left beside the road
/// is among them.
pub(super) fn check_reports(reports: &[VehicleReport], is_seen: &[bool]) -> Result<(), TrafficError> {
    reports.iter().try_for_each(|report| report.state.check(report.id))?;
    let is_ordered = reports.windows(2).all(|pair| pair[0].id < pair[1].id);
    if let Some(last) = reports.last().filter(|last| !is_ordered || last.id.0 as usize >= is_seen.len()) {
        let (id, cars) = (last.id.0, is_seen.len());
        return Err(TrafficError::Setup(format!("reports up to car {id}: they have to be in order, of {cars} cars")));
    }
    let mut left = (0..).zip(is_seen).filter(|(_, is_seen)| !**is_seen).map(|(id, _)| VehicleId(id));
    match left.find(|id| reports.binary_search_by_key(id, |report| report.id).is_err()) {
        Some(id) => {
            Err(TrafficError::Setup(format!("car {} is beside the road: its model cannot drive it there", id.0)))
        }
        None => Ok(()),
    }
}

/// Front bumper of a car at `pose` on the route. `near_s_m` as in [`Route::project`].
pub(super) fn place(route: &Route, pose: &Pose, near_s_m: Option<f64>) -> RoutePosition {
    route.project(pose.front(CAR_LENGTH_M), near_s_m)
}

/// True if a part of the car's body is on the lane: 2.5 m off the centre of a lane of 3.2 m is the last place where others
/// see it.
pub fn is_on_lane(route: &Route, point: RoutePosition) -> bool {
    point.offset_m.abs() <= (route.width_m(point.s_m) + CAR_WIDTH_M) / 2.0
}

/// Brings a car's state to the end of a step that `report` described, at `s_m`.
pub(super) fn follow(car: &mut CarState, report: &ExternalVehicleState, s_m: f64, step_s: f64) {
    let next_mps = report.next_speed_mps.max(0.0);
    car.s_m = s_m;
    car.set_motion(
        SpeedStep { before_mps: report.speed_mps.max(0.0), chosen_mps: next_mps, after_mps: next_mps },
        step_s,
    );
}
