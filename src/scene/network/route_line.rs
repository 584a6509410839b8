//! Line on the road that leads along the ego's path. In: a [`Route`]. Out: one mesh in world axes, a little above the road's paint, and the
//! part of it that a picture shows.

use super::layer::Layer;
use crate::{
    map::Route,
    scene::{Material, Mesh, Vertex},
};
use glam::{DVec2, DVec3, Vec2, Vec3};
use std::ops::Range;

/// Width of the line, metres: a third of a car's track, so that the lane's paint stays visible on either side.
const WIDTH_M: f64 = 0.5;
/// Height of the line above the paint, metres.
const ABOVE_M: f64 = 0.006;
/// Distance between two rows of the line's corners, metres.
const ROW_M: f64 = 2.0;
/// Length of the line that is visible, metres: the next turn in a town. A path may cross itself and return on the other side of a road, so that
/// the line of a later part would lead astray.
const AHEAD_M: f64 = 200.0;
/// Distance of the line's begin behind the ego's front bumper, metres: the line begins below the ego, so that neither mirrors nor the chase view
/// show where it ends.
const BEHIND_M: f64 = 4.0;
/// Indices of the two triangles between two rows.
const ROW_INDICES: u32 = 6;
/// Linear albedo of the line: a blue that no marking has.
const COLOUR: [f32; 3] = [0.025, 0.14, 0.42];

/// Offset of `uv` from the range in which lanes have wheel tracks.
const UV_SHIFT: Vec2 = Vec2::splat(16.0);

/// Returns the line along a whole route, less `origin`; empty on a closed route, which has no turns to show.
pub fn route_line(route: &Route, origin: DVec3) -> Mesh {
    let mut mesh = Mesh::default();
    if route.is_closed() {
        return mesh;
    }
    let rows = (route.length_m() / ROW_M).ceil().max(1.0) as u32;
    let lift_m = f64::from(Layer::Paint.z_m()) + ABOVE_M;
    for row in 0..=rows {
        let s_m = (f64::from(row) * ROW_M).min(route.length_m());
        let middle = route.point_at(s_m);
        let left = DVec2::from_angle(route.yaw_at(s_m)).perp();
        for side in [-0.5, 0.5] {
            let at = (middle + left * side * WIDTH_M).extend(route.height_m(s_m) + lift_m) - origin;
            let uv = Vec2::new(s_m as f32, side as f32) + UV_SHIFT;
            mesh.vertex(Vertex::new(at.as_vec3(), Vec3::Z, COLOUR, uv, Material::Asphalt));
        }
    }
    for at in (0..rows).map(|row| 2 * row) {
        mesh.indices.extend([at, at + 2, at + 3, at, at + 3, at + 1]);
    }
    mesh
}

/// Returns the indices of the visible part of a line for an ego with its front bumper at `s_m` along the route.
pub fn visible_part(line: &Mesh, s_m: f64) -> Range<u32> {
    let rows = line.indices.len() as u32 / ROW_INDICES;
    // A negative or too large place is one at the route's begin or end.
    let row = |s_m: f64| ((s_m / ROW_M) as u32).min(rows) * ROW_INDICES;
    row(s_m - BEHIND_M)..row(s_m + AHEAD_M)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{map::RoadMap, scene::mesh::tests::check};

    #[test]
    fn the_line_lies_on_the_path_a_little_above_the_road() {
        let map = RoadMap::load("town").expect("a shipped map");
        let origin = DVec3::new(100.0, -50.0, 2.0);
        let mesh = route_line(&map.route, origin);
        check(&mesh, "line");
        assert_eq!(mesh.triangles(), 2 * (map.route.length_m() / ROW_M).ceil() as usize);
        for pair in mesh.vertices.chunks(2) {
            let [right, left] = [0, 1].map(|k| Vec3::from(pair[k].position).as_dvec3() + origin);
            assert!((right.distance(left) - WIDTH_M).abs() < 1e-3);
            let middle = (right + left) / 2.0;
            let s_m = f64::from(pair[0].uv[0] - UV_SHIFT.x);
            assert!(middle.truncate().distance(map.route.point_at(s_m)) < 0.01, "{s_m}");
            let above_m = middle.z - map.route.height_m(s_m);
            assert!((0.007..0.03).contains(&above_m), "above the paint, too low to be seen from the side: {above_m}");
        }
        // Faces look up.
        for face in mesh.indices.chunks(3) {
            let [a, b, c] = [0, 1, 2].map(|k| Vec3::from(mesh.vertices[face[k] as usize].position));
            assert!((b - a).cross(c - a).z > 0.0);
        }
        assert_eq!(route_line(&RoadMap::load("ring-250").expect("a map").route, origin).triangles(), 0);
    }
    #[test]
    fn a_picture_shows_the_line_from_the_ego_to_200_m_ahead() {
        // The path of the town crosses itself.
        let route = RoadMap::load("town").expect("a shipped map").route;
        let line = route_line(&route, DVec3::ZERO);
        let shown = |s_m: f64| {
            let part = visible_part(&line, s_m);
            let places = line.indices[part.start as usize..part.end as usize].iter();
            let places = places.map(|index| f64::from(line.vertices[*index as usize].uv[0] - UV_SHIFT.x));
            places.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), s_m| (least.min(s_m), most.max(s_m)))
        };
        for s_m in [100.0, 1001.0, 2000.5] {
            let (start_m, end_m) = shown(s_m);
            // The car is 5 m long and rows are 2 m apart.
            assert!(start_m > s_m - 6.5 && start_m < s_m - 3.0, "{s_m}: from {start_m}");
            assert!((end_m - s_m - 200.0).abs() < 2.1, "{s_m}: to {end_m}");
        }
        assert_eq!(shown(1.0).0, 0.0, "at the begin");
        let length_m = route.length_m();
        assert!((shown(length_m - 50.0).1 - length_m).abs() < 0.01, "at the end");
        assert!(visible_part(&line, length_m + 100.0).is_empty(), "beyond the end");
        assert!(visible_part(&Mesh::default(), 10.0).is_empty(), "without a line");
    }
}
