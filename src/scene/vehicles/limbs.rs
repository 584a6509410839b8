//! Limbs and clothes of persons: riders and walkers. In: ends and radii, metres. Out: triangles.

use crate::scene::{
    Material,
    mesh::{SurfaceFinish, TriangleList},
};
use glam::Vec3;
use std::f32::consts::TAU;

pub(super) const JACKET: SurfaceFinish = SurfaceFinish::new(Material::Matt, [0.045, 0.05, 0.07]);
pub(super) const SHIRT: SurfaceFinish = SurfaceFinish::new(Material::Matt, [0.42, 0.40, 0.36]);
pub(super) const TROUSERS: SurfaceFinish = SurfaceFinish::new(Material::Matt, [0.035, 0.04, 0.06]);
pub(super) const SKIN: SurfaceFinish = SurfaceFinish::new(Material::Matt, [0.36, 0.21, 0.145]);

/// Adds a round limb or tube.
pub(super) fn limb(triangles: &mut TriangleList, from: [f32; 3], to: [f32; 3], radii: [f32; 2], finish: SurfaceFinish) {
    const SIDES: usize = 8;
    let ends = [Vec3::from(from), Vec3::from(to)];
    let along = (ends[1] - ends[0]).normalize_or(Vec3::X);
    let (right, up) = along.any_orthonormal_pair();
    let ring = |k: usize| {
        let corner = |i: usize| {
            let (sin, cos) = (TAU * i as f32 / SIDES as f32).sin_cos();
            ends[k] + (right * cos - up * sin) * radii[k]
        };
        (0..SIDES).map(corner).collect()
    };
    triangles.bar(2, ring, finish);
}

/// Adds a limb and its mirror image in the plane y = 0.
pub(super) fn limbs(
    triangles: &mut TriangleList,
    from: [f32; 3],
    to: [f32; 3],
    radii: [f32; 2],
    finish: SurfaceFinish,
) {
    limb(triangles, from, to, radii, finish);
    let flip = |[x, y, z]: [f32; 3]| [x, -y, z];
    limb(triangles, flip(from), flip(to), radii, finish);
}
