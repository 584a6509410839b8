//! Line on the road that leads along the ego's path. In: a [`Route`]. Out: one mesh in world axes, a little above the road's paint.

use super::layer::Layer;
use crate::{
    map::Route,
    scene::{Material, Mesh, Vertex},
};
use glam::{DVec2, DVec3, Vec2, Vec3};

/// Width of the line, metres: a third of a car's track, so that the lane's paint stays visible on either side.
const WIDTH_M: f64 = 0.5;
/// Height of the line above the paint, metres.
const ABOVE_M: f64 = 0.006;
/// Distance between two rows of the line's corners, metres.
const ROW_M: f64 = 2.0;
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
}
