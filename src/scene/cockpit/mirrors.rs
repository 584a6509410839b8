//! Mirrors of the full cockpit: a flat one at the windscreen's upper edge and a convex one on each door. In: the driver's eye,
//! the body's position, the picture's angle of view. Out: [`MirrorPane`]s, each a glass in the world with the camera behind it,
//! and the housings around them as meshes: origin in the middle of the glass, x towards the driver, y to the driver's right, z
//! up, metres.

use crate::scene::{
    Camera, Lens, Mesh, ViewOptions,
    car::materials::{GLOSS, PAINT, TRIM},
    mesh::{SurfaceFinish, TriangleList},
};
use glam::{Affine3A, Mat3A, Quat, Vec2, Vec3};
use std::f32::consts::TAU;

/// Half the width and height of the rear-view mirror's glass, metres.
const REAR_M: Vec2 = Vec2::new(0.0986, 0.029);
/// Middle of the rear-view mirror in the body's frame, metres.
const REAR_PLACE_M: Vec3 = Vec3::new(0.50, 0.0, 1.248);
/// Half the width and height of a door mirror's glass, and the left mirror's middle in the body's frame, metres.
const SIDE_M: Vec2 = Vec2::new(0.075, 0.053);
const SIDE_PLACE_M: Vec3 = Vec3::new(0.700, 0.925, 0.992);
/// Radius of curvature of the door mirrors, metres; UN R46 requires at least 1.2 (class III).
const SIDE_RADIUS_M: f32 = 1.3;
/// Angles of the door mirrors, radians. Yaw is outwards: their edge shows the ego's flank and, on the ground 4 m behind the eye,
/// more than the metre beside it that UN R46 requires. Pitch is downwards: the horizon is near their upper edge.
const SIDE_YAW_RAD: f32 = 0.125;
const SIDE_PITCH_RAD: f32 = -0.105;
/// Scale of a mirror outside the picture, which is turned about the eye into the picture. It is moved closer and made smaller by
/// this factor, in front of pillars and doors, so that its apparent size is unchanged.
const NEARER: f32 = 0.6;
/// Free space between a mirror turned into the picture and the picture's edge, radians.
const MARGIN_RAD: f32 = 0.020;

/// Glass of a mirror and its picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorPane {
    /// Upper left, upper right and lower left corner as the driver sees them, world axes.
    pub corners: [Vec3; 3],
    /// Transform from the housing's frame to the body's.
    pub body_from_glass: Affine3A,
    /// Approximate width as a share of the picture's width, for the choice of resolution.
    pub width_share: f32,
    /// Aspect ratio, width / height.
    pub aspect: f32,
    /// Camera behind the glass as if it were flat; its picture is flipped left to right.
    pub camera: Camera,
    /// Curvature, see [`MirrorOptions::bend`](crate::scene::MirrorOptions::bend).
    pub bend: f32,
    /// True if the mirror is in its real position, not turned into the picture.
    pub at_home: bool,
}

/// Returns the rear-view mirror with `rear` behind it, the left and the right door mirror, of a car whose body is at
/// `world_from_body`.
pub(in crate::scene) fn panes(world_from_body: Affine3A, rear: Camera, options: &ViewOptions) -> [MirrorPane; 3] {
    let eye = options.eye;
    let first = GlassPlace::new(REAR_PLACE_M, REAR_M, options).pane(world_from_body, rear, options.mirror.bend(eye));
    let [left, right] = [1.0, -1.0].map(|side| {
        let home = SIDE_PLACE_M * Vec3::new(1.0, side, 1.0);
        let turn = Quat::from_rotation_z(-side * SIDE_YAW_RAD) * Quat::from_rotation_y(SIDE_PITCH_RAD);
        let camera = Camera {
            eye: world_from_body.transform_point3(home),
            forward: world_from_body.transform_vector3(turn * Vec3::NEG_X),
            up: world_from_body.transform_vector3(turn * Vec3::Z),
            lens: Lens::Perspective { fov_x_rad: 2.0 * (SIDE_M.x / eye.distance(home)).atan() },
        };
        GlassPlace::new(home, SIDE_M, options).pane(world_from_body, camera, eye.distance(home) / SIDE_RADIUS_M)
    });
    [first, left, right]
}

/// Position of a glass in the body.
struct GlassPlace {
    body_from_glass: Affine3A,
    half_m: Vec2,
    width_share: f32,
    at_home: bool,
}

impl GlassPlace {
    fn new(home: Vec3, half_m: Vec2, options: &ViewOptions) -> Self {
        let (eye, fov_x_rad) = (options.eye, options.fov_x_rad());
        let off = home - eye;
        let bearing = off.y.atan2(off.x);
        let half_rad = (half_m.x / off.length()).atan();
        let most = fov_x_rad / 2.0 - half_rad - MARGIN_RAD;
        let at_home = bearing.abs() <= most;
        let (turn, scale) = if at_home { (0.0, 1.0) } else { (most * bearing.signum() - bearing, NEARER) };
        let place = eye + scale * (Quat::from_rotation_z(turn) * off);
        // The glass faces half way between the eye and straight back.
        let x = ((eye - place).normalize() + Vec3::NEG_X).normalize();
        let y = Vec3::Z.cross(x).normalize();
        let axes = Mat3A::from_cols(x.into(), y.into(), x.cross(y).into()) * scale;
        let bearing = bearing + turn;
        let edges = [bearing - half_rad, bearing + half_rad].map(f32::tan);
        Self {
            body_from_glass: Affine3A { matrix3: axes, translation: place.into() },
            half_m,
            width_share: (edges[1] - edges[0]) / (2.0 * (fov_x_rad / 2.0).tan()),
            at_home,
        }
    }

    fn pane(&self, world_from_body: Affine3A, camera: Camera, bend: f32) -> MirrorPane {
        let world = world_from_body * self.body_from_glass;
        let corner =
            |right: f32, up: f32| world.transform_point3(Vec3::new(0.0, right * self.half_m.x, up * self.half_m.y));
        MirrorPane {
            corners: [corner(-1.0, 1.0), corner(1.0, 1.0), corner(-1.0, -1.0)],
            body_from_glass: self.body_from_glass,
            width_share: self.width_share,
            aspect: self.half_m.x / self.half_m.y,
            camera,
            bend,
            at_home: self.at_home,
        }
    }
}

/// Returns the housings: the rear-view mirror's with its stalk, and those of a mirror with its foot at the right, at the left and
/// below.
pub(in crate::scene) fn housings() -> [Mesh; 4] {
    let mut rear = shell(REAR_M, 0.030, 0.0075, GLOSS);
    // The stalk, from behind the glass up to the windscreen's edge.
    tube(
        &mut rear,
        [Vec3::new(-0.022, 0.0, 0.010), Vec3::new(-0.055, 0.0, 0.070), Vec3::new(-0.060, 0.0, 0.230)],
        0.0075,
        GLOSS,
    );
    let mut side = shell(SIDE_M, 0.075, 0.010, PAINT);
    tube(
        &mut side,
        [Vec3::new(-0.035, 0.040, -0.035), Vec3::new(-0.035, 0.085, -0.060), Vec3::new(-0.030, 0.190, -0.075)],
        0.014,
        GLOSS,
    );
    let other = side.mirrored();
    let mut below = shell(SIDE_M, 0.075, 0.010, PAINT);
    tube(
        &mut below,
        [Vec3::new(-0.035, -0.020, -0.035), Vec3::new(-0.035, -0.025, -0.060), Vec3::new(-0.045, -0.045, -0.090)],
        0.020,
        TRIM,
    );
    [rear, side, other, below].map(|triangles| triangles.into_mesh(0.8))
}

/// Returns a housing `deep_m` deep, with a rim `rim_m` wide around a glass of `half_m`.
fn shell(half_m: Vec2, deep_m: f32, rim_m: f32, finish: SurfaceFinish) -> TriangleList {
    const CORNERS: usize = 40;
    let ring = |x: f32, grown: f32| -> Vec<Vec3> {
        let corner = |k: usize| {
            let angle = TAU * k as f32 / CORNERS as f32;
            // A rounded rectangle (Lamé's curve of the fifth order), clockwise for the driver.
            let [left, up] = Vec2::from_angle(angle).to_array().map(|v| v.signum() * v.abs().powf(0.4));
            Vec3::new(x, -left * (half_m.x + grown), up * (half_m.y + grown))
        };
        (0..CORNERS).map(corner).collect()
    };
    let least = -half_m.y;
    let mut all = TriangleList::default();
    let outside = [
        ring(-deep_m, 0.6 * least),
        ring(-0.92 * deep_m, 0.35 * least),
        ring(-0.6 * deep_m, 0.0),
        ring(-0.2 * deep_m, 0.85 * rim_m),
        ring(0.002, rim_m),
        ring(0.005, 0.75 * rim_m),
    ];
    all.bar(outside.len(), |i| outside[i].clone(), finish);
    let inside = [ring(0.005, 0.75 * rim_m), ring(0.004, 0.25 * rim_m), ring(-0.001, 0.0)];
    all.bar(inside.len(), |i| inside[i].clone(), GLOSS);
    all
}

/// Adds a round bar along a curve given by three points.
fn tube(all: &mut TriangleList, way: [Vec3; 3], radius_m: f32, finish: SurfaceFinish) {
    const PLACES: usize = 9;
    let at = |t: f32| {
        // A quadratic Bézier curve from the first point to the last, bent towards the middle one.
        way[0] * (1.0 - t) * (1.0 - t) + way[1] * 2.0 * t * (1.0 - t) + way[2] * t * t
    };
    let ring = |i: usize| -> Vec<Vec3> {
        let t = i as f32 / (PLACES - 1) as f32;
        let along = (at((t + 0.05).min(1.0)) - at((t - 0.05).max(0.0))).normalize();
        let across = along.cross(Vec3::X).normalize_or(Vec3::Y);
        let up = across.cross(along);
        (0..10)
            .map(|k| Vec2::from_angle(-TAU * k as f32 / 10.0))
            .map(|o| at(t) + radius_m * (across * o.x + up * o.y))
            .collect()
    };
    all.bar(PLACES, ring, finish);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::mesh::tests::{check, has_coat, open_edges};

    fn pictured(screen_width_m: f32) -> ([MirrorPane; 3], Camera, ViewOptions) {
        let options = ViewOptions { screen_width_m, ..Default::default() };
        let lens = Lens::Perspective { fov_x_rad: options.fov_x_rad() };
        let camera = Camera { eye: options.eye, forward: Vec3::X, up: Vec3::Z, lens };
        let rear = Camera { eye: options.mirror.position, forward: Vec3::NEG_X, ..camera };
        (panes(Affine3A::IDENTITY, rear, &options), camera, options)
    }

    #[test]
    fn every_mirror_is_in_the_picture_and_in_its_real_place_if_it_fits() {
        // One television at a metre, and three of them side by side.
        for (screen_width_m, at_home) in [(1.2176, [false; 3]), (6.0, [true; 3])] {
            let (panes, camera, options) = pictured(screen_width_m);
            assert_eq!(panes.map(|pane| pane.at_home), at_home);
            for (pane, home) in panes.iter().zip([1.0, 1.0, -1.0].map(|side| SIDE_PLACE_M * Vec3::new(1.0, side, 1.0)))
            {
                for corner in pane.corners {
                    let x = camera.project(corner, 16.0 / 9.0).expect("before the eye").x;
                    assert!((0.0..=1.0).contains(&x), "{pane:?}: {x}");
                }
                let place = Vec3::from(pane.body_from_glass.translation);
                if pane.at_home && pane.bend > 0.0 {
                    assert!(place.distance(home) < 1e-5);
                }
                // Not moved up or down.
                let slope = |p: Vec3| (p - options.eye).z / (p - options.eye).truncate().length();
                let home = if pane.bend > 0.0 { home } else { REAR_PLACE_M };
                assert!((slope(place) - slope(home)).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn a_side_mirror_shows_the_ego_flank_and_the_road_required_by_un_r46() {
        // UN R46, 15.2.4.3: a metre of road beside the car from 4 m behind the eye on, five from 30 m on, and the horizon.
        let (panes, _, options) = pictured(1.2176);
        for (pane, side) in panes[1..].iter().zip([1.0f32, -1.0]) {
            let Lens::Perspective { fov_x_rad } = pane.camera.lens else { panic!("a perspective") };
            let seen = |point: Vec3| {
                // Position at which the glass shows the point: in the flat picture, moved inwards by the curvature
                // (`render/post/tonemap.rs`).
                let wide = Camera { lens: Lens::Perspective { fov_x_rad: 2.5 }, ..pane.camera };
                let at = wide.project(point, 1.0).expect("behind the car");
                let off = (at - 0.5) * 2.0 * 1.25f32.tan();
                let angle = off.length().atan();
                // Solves atan(r) + 2 asin(bend r) = angle by bisection.
                let (mut low, mut high) = (0.0f32, 1.0f32);
                for _ in 0..40 {
                    let middle = (low + high) / 2.0;
                    if middle.atan() + 2.0 * (pane.bend * middle).min(1.0).asin() < angle {
                        low = middle
                    } else {
                        high = middle
                    }
                }
                let half = (fov_x_rad / 2.0).tan();
                off.normalize_or_zero() * low / Vec2::new(half, half / pane.aspect)
            };
            let rear = options.eye.x;
            let flank = side * 0.9;
            for (behind_m, beside_m) in [(4.0, 0.0), (4.0, 1.0), (30.0, 0.0), (30.0, 5.0)] {
                let at = seen(Vec3::new(rear - behind_m, flank + side * beside_m, 0.0));
                assert!(at.abs().max_element() < 1.0, "side {side}: {behind_m} m behind, {beside_m} m beside: {at}");
            }
            let horizon = seen(Vec3::new(-5000.0, flank, 1.0));
            assert!(horizon.abs().max_element() < 1.0, "{horizon}");
            // The ego's flank takes less than a quarter of the glass. The picture is not yet flipped.
            let flank = seen(Vec3::new(-2.4, flank, 0.9));
            assert!((0.45..1.0).contains(&(-side * flank.x)), "side {side}: {flank}");
        }
    }

    #[test]
    fn housings_are_closed_and_coated() {
        for mesh in housings() {
            check(&mesh, "housing");
            assert!(has_coat(&mesh));
            assert_eq!(open_edges(&mesh), 0);
            assert!(mesh.triangles() < 1200, "{}", mesh.triangles());
        }
    }
}
