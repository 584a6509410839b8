//! The ground under the ego's wheels, from the map: asphalt on lane and shoulder, grass beyond.

use crate::{
    ego::{GroundModel, GroundSurface},
    map::{Route, SHOULDER_M},
};
use glam::DVec2;

/// The route's ground near one place.
pub(super) struct RoadGround<'a> {
    pub route: &'a Route,
    /// Where on the route the ego is about; the search stays near it.
    pub near_s_m: f64,
}

impl GroundModel for RoadGround<'_> {
    fn surface(&self, point: DVec2) -> GroundSurface {
        let found = self.route.project(point, Some(self.near_s_m));
        let half_m = self.route.width_m(found.s_m) / 2.0 + SHOULDER_M;
        if found.offset_m.abs() <= half_m { GroundSurface::Asphalt } else { GroundSurface::Grass }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn asphalt_reaches_over_the_shoulder_on_either_side_and_grass_begins_there() {
        let map = crate::map::RoadMap::load("ring-250").expect("the shipped ring");
        let ground = RoadGround { route: &map.route, near_s_m: 30.0 };
        let (middle, left) = (map.route.point_at(30.0), DVec2::from_angle(map.route.yaw_at(30.0)).perp());
        // A lane of 3.6 m, as the head of the ring's net.xml says, and a shoulder of 0.4 m.
        let edge_m = 3.6 / 2.0 + 0.4;
        for side in [1.0, -1.0] {
            let at = |offset_m: f64| ground.surface(middle + side * offset_m * left);
            assert_eq!([0.0, 1.5, edge_m - 0.02].map(at), [GroundSurface::Asphalt; 3]);
            assert_eq!([edge_m + 0.02, 4.0].map(at), [GroundSurface::Grass; 2]);
        }
    }
}
