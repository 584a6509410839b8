//! How far a point of the land is from the road, and how high the road is there; asked tens of thousands of times while a stage is
//! built. In: the route, or all surfaces of a network, once. Out: metres to the centre line, never more than 2 cm too long near
//! the road.

use crate::{map::Route, scene::network::road_surfaces::RoadSurfaces};
use glam::Vec2;

/// Distance of the points that stand for the centre line, metres: at 3 m beside it the error is 0.5^2/4/(2*3) = 2 cm.
const FINE_M: f64 = 0.5;
/// Fine points to a coarse one.
const FINE_PER_COARSE: usize = 32;

/// Where the roads are.
pub(in crate::scene) struct RoadDistance {
    roads: Roads,
    /// Largest half lane width, metres.
    half_lane_m: f32,
    centre: Vec2,
    radius_m: f32,
}

enum Roads {
    /// The centre line as points, with every 32nd as a first look.
    Route(Vec<Vec2>),
    /// All that is paved.
    Network(RoadSurfaces),
}

/// Of a network: what stands for half the lane's width, metres.
const HALF_LANE_M: f32 = 1.6;

impl RoadDistance {
    /// Samples the route.
    pub fn new(route: &Route) -> Self {
        let n = (route.length_m() / FINE_M).ceil().max(1.0) as usize;
        let fine: Vec<Vec2> =
            (0..n).map(|i| route.point_at(route.length_m() * i as f64 / n as f64).as_vec2()).collect();
        let low = fine.iter().copied().reduce(Vec2::min).unwrap_or_default();
        let high = fine.iter().copied().reduce(Vec2::max).unwrap_or_default();
        let centre = (low + high) / 2.0;
        let half_lane_m = route.lanes().iter().map(|lane| lane.width_m).fold(0.0, f64::max) as f32 / 2.0;
        let radius_m = fine.iter().map(|p| p.distance(centre)).fold(0.0, f32::max) + half_lane_m;
        Self { roads: Roads::Route(fine), half_lane_m, centre, radius_m }
    }

    /// Takes over the surfaces of a network.
    pub fn of_surfaces(surfaces: RoadSurfaces) -> Self {
        let (centre, radius_m) = surfaces.circle();
        Self { roads: Roads::Network(surfaces), half_lane_m: HALF_LANE_M, centre, radius_m }
    }

    /// The surfaces of a network; `None` of a route.
    pub fn surfaces(&self) -> Option<&RoadSurfaces> {
        match &self.roads {
            Roads::Route(_) => None,
            Roads::Network(surfaces) => Some(surfaces),
        }
    }

    /// Largest half lane width, metres.
    pub fn half_lane_m(&self) -> f32 {
        self.half_lane_m
    }

    /// Middle of the bounding box of the route.
    pub fn centre(&self) -> Vec2 {
        self.centre
    }

    /// Radius around the centre that holds the route and its lane, metres.
    pub fn radius_m(&self) -> f32 {
        self.radius_m
    }

    /// Distance from the centre line, metres; in a network the distance from the nearest lane's edge, and half a lane's width more.
    pub fn distance_m(&self, point: Vec2) -> f32 {
        let fine = match &self.roads {
            Roads::Route(fine) => fine,
            Roads::Network(surfaces) => return surfaces.border_m(point) + HALF_LANE_M,
        };
        // No fine point is further from its coarse one than this, because the way along the road is at least as long.
        let reach = FINE_M as f32 * FINE_PER_COARSE as f32;
        let squared = |p: &Vec2| p.distance_squared(point);
        let bound = fine.iter().step_by(FINE_PER_COARSE).map(squared).fold(f32::INFINITY, f32::min).sqrt();
        let mut best = bound * bound;
        for chunk in fine.chunks(FINE_PER_COARSE) {
            if chunk[0].distance(point) < bound + reach {
                best = chunk.iter().map(squared).fold(best, f32::min);
            }
        }
        best.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng;
    use crate::scene::static_scene::tests::ring;
    use glam::Vec2;

    #[test]
    fn distances_are_those_of_the_route() {
        let map = ring(250.0);
        let near = RoadDistance::new(&map.route);
        let mut random = rng::stream(1, "test");
        for _ in 0..500 {
            let point = Vec2::new(random.uniform(-150.0, 150.0) as f32, random.uniform(-150.0, 150.0) as f32);
            let exact = map.route.project(point.as_dvec2(), None).offset_m.abs() as f32;
            let error = near.distance_m(point) - exact;
            assert!((-1e-3..0.04 / exact.max(0.3)).contains(&error), "{point} {exact} {error}");
        }
        assert!((near.radius_m() - 250.0 / std::f32::consts::TAU - 1.6).abs() < 0.05);
    }
}
