//! Walls of buildings that hide things behind them. In: upright walls of a scene, a camera. Out: an answer for each box whether walls hide it wholly, so
//! that it need not be drawn; in a town they hide most of its vehicles and houses.

use super::view_projection::ViewFrustum;
use crate::scene::{Material, Mesh};
use glam::{Vec2, Vec3};

/// Number of upright strips of a picture.
const STRIPS: usize = 512;
/// Distances ahead of the camera up to which walls are known apart, metres: what stands at a distance is hidden by the walls before it.
const RINGS_M: [f32; 8] = [12.0, 20.0, 32.0, 50.0, 80.0, 130.0, 210.0, 350.0];
/// Least distance ahead of the camera of walls and boxes, metres; those nearer hide nothing and are not hidden.
const NEAR_M: f32 = 0.5;
/// Height that a wall must have over the camera to be of use, metres.
const LOW_M: f32 = 0.5;

/// An upright wall, which goes down into the ground: from left to right as seen from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UprightWall {
    ends: [Vec2; 2],
    top_m: f32,
}

impl UprightWall {
    /// Returns the rectangular walls of a mesh of buildings.
    pub fn of_mesh(mesh: &Mesh) -> Vec<Self> {
        let corner = |index: u32| Vec3::from(mesh.vertices[index as usize].position);
        let is_wall = |index: u32| mesh.vertices[index as usize].material & 0xff == Material::Wall as u32;
        let triangles: &[[u32; 3]] = mesh.indices.as_chunks().0;
        let rectangle = |pair: &[[u32; 3]]| {
            let [[a, b, c], [d, e, f]] = [pair[0], pair[1]];
            let is_one = a == d && c == e && is_wall(a);
            let [from, to, over_to, over_from] = [a, b, c, f].map(corner);
            let are_one = |a: f32, b: f32| (a - b).abs() < 1e-3;
            let is_upright =
                [from - over_from, to - over_to].iter().all(|off| off.truncate().length() < 1e-3 && off.z < 0.0);
            let wall = Self { ends: [from.truncate(), to.truncate()], top_m: over_from.z };
            (is_one && is_upright && are_one(over_from.z, over_to.z)).then_some(wall)
        };
        triangles.windows(2).filter_map(rectangle).collect()
    }
}

/// Highest walls around a camera, in strips of its picture and by distance.
///
/// A point of the ground plan has the coordinates (u, z): z metres ahead of the camera, u times z metres to its right. A straight wall is straight
/// over u in 1/z, too, and its height over the camera divided by z is what it hides.
#[derive(Debug)]
pub struct WallHorizon {
    eye: Vec3,
    ahead: Vec2,
    right: Vec2,
    /// Half the width of the picture in u.
    reach: f32,
    /// Least height over the camera divided by distance that is seen above the walls before each of [`RINGS_M`], by strip; empty where walls
    /// hide nothing.
    seen_above: Vec<[f32; STRIPS]>,
}

impl WallHorizon {
    /// Draws the walls of a picture. Walls hide nothing from above or from straight below.
    pub fn new(frustum: &ViewFrustum, walls: &[UprightWall]) -> Self {
        let camera = &frustum.camera;
        let [right, up] = frustum.spread();
        let ahead = camera.forward.truncate();
        // Rays through the picture's corners have the least part ahead in the plan.
        let least = ahead.length() - up.truncate().length() - right.z.abs();
        let is_usable = frustum.parallel_m().is_none() && least > 0.2 && !walls.is_empty();
        let ahead = ahead.normalize_or(Vec2::X);
        let mut horizon = Self {
            eye: camera.eye,
            ahead,
            right: -ahead.perp(),
            reach: right.length() / least,
            seen_above: if is_usable { vec![[f32::NEG_INFINITY; STRIPS]; RINGS_M.len()] } else { vec![] },
        };
        if is_usable {
            walls.iter().for_each(|wall| horizon.add(wall));
            for ring in 1..RINGS_M.len() {
                for strip in 0..STRIPS {
                    let nearer = horizon.seen_above[ring - 1][strip];
                    let here = &mut horizon.seen_above[ring][strip];
                    *here = here.max(nearer);
                }
            }
        }
        horizon
    }

    /// Returns the place in the plan, metres to the right of the camera and ahead of it.
    fn plan(&self, at: Vec2) -> Vec2 {
        let off = at - self.eye.truncate();
        Vec2::new(off.dot(self.right), off.dot(self.ahead))
    }

    /// Returns the strip, with its fraction, at `u`.
    fn strip(&self, u: f32) -> f32 {
        (u / self.reach + 1.0) / 2.0 * STRIPS as f32
    }

    fn add(&mut self, wall: &UprightWall) {
        let over_m = wall.top_m - self.eye.z;
        let [from, to] = wall.ends.map(|end| self.plan(end));
        let last_m = RINGS_M[RINGS_M.len() - 1];
        // From outside, a wall's left end is on the left: from there u rises.
        if over_m < LOW_M || from.y.max(to.y) < NEAR_M || from.y.min(to.y) > last_m || from.perp_dot(to) >= 0.0 {
            return;
        }
        let cut = |end: Vec2, other: Vec2| {
            let share = (NEAR_M - end.y) / (other.y - end.y);
            if end.y < NEAR_M { end.lerp(other, share) } else { end }
        };
        let [from, to] = [cut(from, to), cut(to, from)];
        let [left, right] = [from, to].map(|end| self.strip(end.x / end.y));
        let [nearness_left, nearness_right] = [from, to].map(|end| 1.0 / end.y);
        let per_strip = (nearness_right - nearness_left) / (right - left);
        let first = left.ceil().max(0.0) as usize;
        for strip in first..STRIPS.min(right.floor().max(0.0) as usize) {
            let nearness = [strip, strip + 1].map(|at| nearness_left + (at as f32 - left) * per_strip);
            let farthest = nearness[0].min(nearness[1]);
            if let Some(ring) = RINGS_M.iter().position(|ring_m| ring_m * farthest >= 1.0) {
                let seen_above = &mut self.seen_above[ring][strip];
                *seen_above = seen_above.max(over_m * farthest);
            }
        }
    }

    /// Checks whether walls hide a box with these lowest and highest corners wholly.
    pub fn hides(&self, low: Vec3, high: Vec3) -> bool {
        let corners = [low.truncate(), Vec2::new(low.x, high.y), high.truncate(), Vec2::new(high.x, low.y)];
        let corners = corners.map(|corner| self.plan(corner));
        let nearest_m = corners.iter().fold(f32::INFINITY, |least, corner| least.min(corner.y));
        let Some(ring) = RINGS_M.iter().rposition(|ring_m| *ring_m <= nearest_m) else { return false };
        let Some(seen_above) = self.seen_above.get(ring) else { return false };
        let over_m = high.z - self.eye.z;
        let steepest = corners.iter().fold(f32::NEG_INFINITY, |most, corner| most.max(over_m / corner.y));
        let strips = corners.map(|corner| self.strip(corner.x / corner.y));
        let [left, right] = [
            strips.iter().fold(f32::INFINITY, |least, strip| least.min(*strip)),
            strips.iter().fold(f32::NEG_INFINITY, |most, strip| most.max(*strip)),
        ];
        let first = left.floor().clamp(0.0, STRIPS as f32 - 1.0) as usize;
        let last = right.floor().clamp(0.0, STRIPS as f32 - 1.0) as usize;
        seen_above[first..=last].iter().all(|above| steepest < *above)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        map::RoadMap,
        render::{OFFSCREEN, Quality, Renderer, device::gpu::Gpu, render_to_image},
        scene::{self, Camera, Lens, StaticScene, ViewKind, ViewOptions},
        sim::Snapshot,
    };

    const EYE: Vec3 = Vec3::new(100.0, 50.0, 1.2);

    fn camera(eye: Vec3, forward: Vec3) -> Camera {
        Camera { eye, forward: forward.normalize(), up: Vec3::Z, lens: Lens::Perspective { fov_x_rad: 1.2 } }
    }

    /// Returns the horizon of a wall from 5 m on the left to 5 m on the right, 20 m east of the eye, with its top at 6 m.
    fn behind_a_wall(forward: Vec3) -> WallHorizon {
        let wall = UprightWall { ends: [Vec2::new(120.0, 55.0), Vec2::new(120.0, 45.0)], top_m: 6.0 };
        WallHorizon::new(&ViewFrustum::new(&camera(EYE, forward), [640, 360]), &[wall])
    }

    fn boxed(ahead_m: [f32; 2], left_m: [f32; 2], top_m: f32) -> [Vec3; 2] {
        [0, 1].map(|k| EYE.with_z(0.0) + Vec3::new(ahead_m[k], left_m[k], [0.0, top_m][k]))
    }

    #[test]
    fn a_wall_hides_what_is_wholly_behind_and_below_its_edges() {
        // The ray over the wall's edge rises 4.8 m in 20 m: at 40 m it is 10.8 m high. Its sides are 10 m from the axis there.
        let cases = [
            ("behind", [40.0, 44.0], [-4.0, 4.0], 3.0, true),
            ("below the ray", [40.0, 44.0], [-4.0, 4.0], 10.0, true),
            ("over the ray", [40.0, 44.0], [-4.0, 4.0], 10.9, false),
            ("just within the sides", [40.0, 40.5], [-9.8, 9.8], 3.0, true),
            ("beyond the left side", [40.0, 40.5], [8.0, 10.2], 3.0, false),
            ("beside", [40.0, 44.0], [15.0, 18.0], 3.0, false),
            ("before it", [13.0, 16.0], [-1.0, 1.0], 3.0, false),
            ("through it", [18.0, 25.0], [-1.0, 1.0], 3.0, false),
            ("around the eye", [-5.0, 60.0], [-1.0, 1.0], 3.0, false),
        ];
        // The camera may look aside, up or down.
        for forward in [Vec3::X, Vec3::new(1.0, 0.2, 0.0), Vec3::new(1.0, -0.2, 0.1), Vec3::new(1.0, 0.0, -0.2)] {
            let horizon = behind_a_wall(forward);
            for (what, ahead_m, left_m, top_m, is_hidden) in cases {
                let [low, high] = boxed(ahead_m, left_m, top_m);
                assert_eq!(horizon.hides(low, high), is_hidden, "{what}, looking towards {forward}");
            }
        }
    }

    #[test]
    fn a_wall_behind_the_camera_and_the_back_of_a_wall_hide_nothing() {
        let [low, high] = boxed([40.0, 44.0], [-4.0, 4.0], 3.0);
        assert!(!behind_a_wall(Vec3::NEG_X).hides(low, high));
        let back = UprightWall { ends: [Vec2::new(120.0, 45.0), Vec2::new(120.0, 55.0)], top_m: 6.0 };
        let frustum = ViewFrustum::new(&camera(EYE, Vec3::X), [640, 360]);
        assert!(!WallHorizon::new(&frustum, &[back]).hides(low, high));
        let above = Camera { lens: Lens::Parallel { half_extent_m: 50.0 }, ..camera(EYE, Vec3::NEG_Z) };
        let above = Camera { up: Vec3::X, ..above };
        assert!(!WallHorizon::new(&ViewFrustum::new(&above, [640, 360]), &[back]).hides(low, high));
    }

    #[test]
    fn a_town_looks_the_same_whether_hidden_things_are_drawn_or_not() {
        let map = RoadMap::load("town").expect("a shipped map");
        let static_scene = StaticScene::with_trees(&map, 1, 300);
        let gpu = Gpu::headless().expect("a graphics device");
        let mut renderer = Renderer::new(&gpu, &static_scene, OFFSCREEN, Quality::LOW);
        let walls = std::mem::take(&mut renderer.meshes.walls);
        assert!(walls.len() > 1000, "{} walls of 378 houses", walls.len());
        let mut triangles = [0; 2];
        for (s_m, side, above_m) in [(30.0, 0.0, 1.2), (240.0, 0.5, 1.2), (700.0, 3.1, 1.4), (1100.0, -0.6, 4.0)] {
            let at = (map.route.point_at(s_m).extend(map.route.height_m(s_m)) - static_scene.origin).as_vec3();
            let yaw_rad = map.route.yaw_at(s_m) as f32 + side;
            let forward = Vec3::new(yaw_rad.cos(), yaw_rad.sin(), if above_m > 2.0 { -0.15 } else { 0.0 });
            let mut view =
                scene::view(&Snapshot::default(), 1.0, ViewKind::Chase, &ViewOptions::default(), &static_scene);
            view.cars.clear();
            view.camera = camera(at + Vec3::Z * above_m, forward);
            let [without, with] = [&vec![], &walls].map(|walls| {
                renderer.meshes.walls.clone_from(walls);
                // The second picture has all its shadows.
                render_to_image(&gpu, &mut renderer, &view, [320, 180]).expect("a picture");
                let image = render_to_image(&gpu, &mut renderer, &view, [320, 180]).expect("a picture");
                (image, renderer.cost().main.triangles)
            });
            let differing = without.0.pixels().zip(with.0.pixels()).filter(|(a, b)| a != b).count();
            assert_eq!(differing, 0, "pixels at {s_m} m");
            triangles[0] += without.1;
            triangles[1] += with.1;
        }
        // In streets with houses on both sides, most of a town is hidden.
        assert!(triangles[1] * 2 < triangles[0], "{triangles:?}");
    }
}
