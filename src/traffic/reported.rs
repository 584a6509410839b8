//! Externally driven vehicles as other traffic sees them: one rule for both engines. In: [`VehicleReport`]s and the route. Out: position of
//! such a vehicle on the route, and whether others see it there. Metres, m/s.

use super::{ExternalVehicleState, TrafficError, VehicleId, VehicleReport};
use crate::{
    map::{Route, RoutePosition},
    space::{CAR_LENGTH_M, CAR_WIDTH_M, Pose},
};

impl ExternalVehicleState {
    /// Checks that all numbers are finite: SUMO accepts NaN silently and loses the vehicle.
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

/// Checks that the reports are of different vehicles, by ascending id, and that every vehicle that was left off the lane has one. `is_seen`
/// has one entry per vehicle, false for one off the lane.
pub(super) fn check_reports(reports: &[VehicleReport], is_seen: &[bool]) -> Result<(), TrafficError> {
    reports.iter().try_for_each(|report| report.state.check(report.id))?;
    let is_ordered = reports.windows(2).all(|pair| pair[0].id < pair[1].id);
    if let Some(last) = reports.last().filter(|last| !is_ordered || last.id.0 as usize >= is_seen.len()) {
        let (id, cars) = (last.id.0, is_seen.len());
        return Err(TrafficError::Setup(format!(
            "the last report is of vehicle {id}; allowed: reports in order, of {cars} vehicles"
        )));
    }
    let mut left = (0..).zip(is_seen).filter(|(_, is_seen)| !**is_seen).map(|(id, _)| VehicleId(id));
    match left.find(|id| reports.binary_search_by_key(id, |report| report.id).is_err()) {
        Some(id) => {
            Err(TrafficError::Setup(format!("vehicle {} is beside the road, where its model cannot drive it", id.0)))
        }
        None => Ok(()),
    }
}

/// Returns the position on the route of the front bumper of a vehicle at `pose`. `near_s_m` as in [`Route::project`].
pub(super) fn place(route: &Route, pose: &Pose, near_s_m: Option<f64>) -> RoutePosition {
    route.project(pose.front(CAR_LENGTH_M), near_s_m)
}

/// Returns true if a part of the vehicle's body is on the lane. On a lane of 3.2 m, others see a vehicle up to 2.5 m off the centre line.
pub fn is_on_lane(route: &Route, point: RoutePosition) -> bool {
    point.offset_m.abs() <= (route.width_m(point.s_m) + CAR_WIDTH_M) / 2.0
}
