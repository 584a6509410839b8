//! The ground under the ego's wheels, from the map: asphalt on lane and shoulder, grass beyond.

use crate::{
    ego::{Ground, Surface},
    map::{Route, SHOULDER_M},
};
use glam::DVec2;

/// The route's ground near one place.
pub(super) struct RoadGround<'a> {
    pub route: &'a Route,
    /// Where on the route the ego is about; the search stays near it.
    pub near_s_m: f64,
}

impl Ground for RoadGround<'_> {
    fn surface(&self, point: DVec2) -> Surface {
        let found = self.route.project(point, Some(self.near_s_m));
        let half_m = self.route.width_m(found.s_m) / 2.0 + SHOULDER_M;
        if found.offset_m.abs() <= half_m { Surface::Asphalt } else { Surface::Grass }
    }
}
