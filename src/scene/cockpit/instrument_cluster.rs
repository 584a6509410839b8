//! Instrument cluster of the full cockpit: a housing with a hood on the dashboard, seen over the steering wheel. Out: its mesh in
//! the body's frame, and the position of the instrument. `render/dial.rs` draws the dial over its face.

use crate::scene::{
    Material,
    car::materials::DARK,
    mesh::{SurfaceFinish, TriangleList},
};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// Middle of the instrument in the body's frame, metres: straight ahead of the driver's eye.
pub const CLUSTER_M: Vec3 = Vec3::new(0.7726, 0.36, 0.9859);
/// Radius of the instrument, metres. Its number is as high in the picture as the number of the plain speedometer.
pub const CLUSTER_RADIUS_M: f32 = 0.0684;
/// Unit directions in the body's frame: towards the eye, and up along the face.
const TOWARDS: Vec3 = Vec3::new(-0.961, 0.0, 0.277);
const UP: Vec3 = Vec3::new(0.277, 0.0, 0.961);
/// Half the width and height of the face, metres.
const HALF_M: Vec2 = Vec2::new(0.088, 0.0715);
/// Finishes: leather over the hood, its seam along the lip, the walls inside it.
const HOOD: SurfaceFinish = SurfaceFinish::new(Material::Matt, [0.058, 0.054, 0.049]);
const LIP: SurfaceFinish = SurfaceFinish::grey(Material::Matt, 0.13);
const WALL: SurfaceFinish = SurfaceFinish::grey(Material::Matt, 0.024);

/// Returns the housing: from the dashboard to the hood's lip, and back to the face.
pub(in crate::scene) fn binnacle() -> TriangleList {
    const CORNERS: usize = 48;
    let outline = |k: usize| {
        let angle = TAU * k as f32 / CORNERS as f32;
        // A rounded rectangle (Lamé's curve of the fourth order), clockwise for the driver.
        Vec2::from_angle(angle).to_array().map(|v| v.signum() * v.abs().sqrt())
    };
    // The lip is closer to the driver at the top than at the bottom.
    let lip_m = |up: f32| 0.010 + 0.034 * (0.5 + 0.5 * up);
    let place = |towards: f32, grown: f32, [left, up]: [f32; 2]| {
        CLUSTER_M + TOWARDS * towards + Vec3::Y * (HALF_M.x + grown) * left + UP * (HALF_M.y + grown) * up
    };
    let ring = |towards: f32, lip: f32, grown: f32| {
        move |k: usize| {
            let at = outline(k);
            place(towards + lip * lip_m(at[1]), grown, at)
        }
    };
    let rings = |list: &[(f32, f32, f32)]| -> Vec<Vec<Vec3>> {
        list.iter().map(|&(towards, lip, grown)| (0..CORNERS).map(ring(towards, lip, grown)).collect()).collect()
    };
    let mut all = TriangleList::default();
    // Open at both ends: the back is inside the dashboard, and the driver looks into the front.
    let mut wall = |rings: Vec<Vec<Vec3>>, finish: SurfaceFinish| {
        for pair in rings.windows(2) {
            for (k, next) in (0..CORNERS).map(|k| (k, (k + 1) % CORNERS)) {
                all.quad([pair[0][k], pair[1][k], pair[1][next], pair[0][next]], finish);
            }
        }
    };
    let shell = rings(&[(-0.20, 0.0, 0.010), (-0.10, 0.0, 0.012), (-0.004, 1.0, 0.009), (-0.001, 1.0, 0.0065)]);
    wall(shell, HOOD);
    let lip = rings(&[(-0.001, 1.0, 0.0065), (0.0, 1.0, 0.004)]);
    wall(lip, LIP);
    let inside = rings(&[(0.0, 1.0, 0.004), (-0.003, 1.0, 0.001), (0.0, 0.0, 0.0)]);
    wall(inside, WALL);
    // The face is slightly larger than the wall around it.
    let face: Vec<Vec3> = (0..CORNERS).map(|k| place(0.0, 0.003, outline(k))).collect();
    for k in 1..CORNERS - 1 {
        all.triangle([face[0], face[k + 1], face[k]], DARK);
    }
    all
}
