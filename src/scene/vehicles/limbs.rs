//! Bodies and clothes of people: limbs, trunk, head. In: joints and radii, metres. Out: triangles.

use super::gait::{Arm, Leg};
use crate::scene::{
    Material,
    mesh::{SurfaceFinish, TriangleList},
};
use glam::{Quat, Vec3};
use std::f32::consts::TAU;

pub(super) const JACKET: SurfaceFinish = matt([0.045, 0.05, 0.07]);
pub(super) const TROUSERS: SurfaceFinish = matt([0.035, 0.04, 0.06]);
pub(super) const SKIN: SurfaceFinish = matt([0.36, 0.21, 0.145]);

/// Returns cloth, hair or skin of a colour.
pub(super) const fn matt(colour: [f32; 3]) -> SurfaceFinish {
    SurfaceFinish::new(Material::Matt, colour)
}

/// Sides of limbs near and far: a body with fewer than ten sides is darker, which would be seen where a person is a hundred pixels high.
pub(super) const SIDES: [Sides; 2] = [10, 6];

/// Detail of a body: sides of a limb.
pub(super) type Sides = usize;

/// Adds a round tube through these points with these radii.
pub(super) fn tube(triangles: &mut TriangleList, points: &[(Vec3, f32)], sides: Sides, finish: SurfaceFinish) {
    let along = |k: usize| {
        let (before, after) = (points[k.saturating_sub(1)].0, points[(k + 1).min(points.len() - 1)].0);
        (after - before).normalize_or(Vec3::X)
    };
    let ring = |k: usize| {
        let (right, up) = along(k).any_orthonormal_pair();
        let corner = |i: usize| {
            let (sin, cos) = (TAU * i as f32 / sides as f32).sin_cos();
            points[k].0 + (right * cos - up * sin) * points[k].1
        };
        (0..sides).map(corner).collect()
    };
    triangles.bar(points.len(), ring, finish);
}

/// Adds a round limb or tube.
pub(super) fn limb(triangles: &mut TriangleList, from: [f32; 3], to: [f32; 3], radii: [f32; 2], finish: SurfaceFinish) {
    tube(triangles, &[(from.into(), radii[0]), (to.into(), radii[1])], 8, finish);
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

/// Adds a trunk through elliptic cross-sections: middle, and half widths forward and to the left, from below to above.
pub(super) fn trunk(triangles: &mut TriangleList, sections: &[(Vec3, [f32; 2])], sides: Sides, finish: SurfaceFinish) {
    let ring = |k: usize| {
        let (middle, [forward, left]) = sections[k];
        let corner = |i: usize| {
            let (sin, cos) = (TAU * i as f32 / sides as f32).sin_cos();
            middle + Vec3::new(forward * cos, -left * sin, 0.0)
        };
        (0..sides).map(corner).collect()
    };
    triangles.bar(sections.len(), ring, finish);
}

/// Adds a leg in trousers or stockings; `girth` scales its radii. A leg under a skirt begins above the knee, as a thigh would reach through the cloth.
pub(super) fn leg(
    triangles: &mut TriangleList,
    leg: &Leg,
    girth: f32,
    is_under_skirt: bool,
    sides: Sides,
    cloth: SurfaceFinish,
) {
    let Leg { hip, knee, ankle, .. } = *leg;
    let on = |from: Vec3, to: Vec3, part: f32, radius: f32| (from.lerp(to, part), radius * girth);
    let points = [
        (hip + (hip - knee) * 0.06, 0.086 * girth),
        on(hip, knee, 0.30, 0.084),
        on(hip, knee, 0.75, 0.064),
        (knee, 0.058 * girth),
        on(knee, ankle, 0.30, 0.058),
        on(knee, ankle, 0.75, 0.044),
        (ankle, 0.042 * girth),
    ];
    tube(triangles, if is_under_skirt { &points[2..] } else { &points }, sides, cloth);
}

/// Adds a shoe from the ankle to before the ball of the foot.
pub(super) fn shoe(triangles: &mut TriangleList, leg: &Leg, sides: Sides, leather: SurfaceFinish) {
    let Leg { ankle, ball, .. } = *leg;
    let sole = (ball - ankle).with_y(0.0);
    // On a flat foot the ball is below the ankle by its height.
    let rest = (-0.03f32).atan2(0.085);
    let pitch_rad = sole.z.atan2(sole.x) - rest;
    let turn = Quat::from_rotation_y(-pitch_rad);
    let mut shoe = TriangleList::default();
    let half = Vec3::new(0.142, 0.047, 0.036);
    shoe.ellipsoid(Vec3::new(-0.055, 0.0, 0.014), half, [6, sides.max(6)], |_| leather);
    triangles.append(shoe.moved(|corner| {
        // Flat soles: what is below them is pressed up.
        let pressed = Vec3::new(corner.x, corner.y, corner.z.max(-0.010));
        // The toes stay flat while the heel rises.
        if pitch_rad < 0.0 && pressed.x > 0.0 { ball + pressed } else { ball + turn * pressed }
    }));
    tube(triangles, &[(ankle + turn * Vec3::new(-0.01, 0.0, -0.03), 0.045), (ankle, 0.046)], sides, leather);
}

/// Adds an arm in a sleeve, and its hand.
pub(super) fn arm(triangles: &mut TriangleList, arm: &Arm, girth: f32, sides: Sides, sleeve: SurfaceFinish) {
    let Arm { shoulder, elbow, hand } = *arm;
    let points = [
        (shoulder + Vec3::Z * 0.035, 0.040 * girth),
        (shoulder.lerp(elbow, 0.08), 0.058 * girth),
        (shoulder.lerp(elbow, 0.5), 0.052 * girth),
        (elbow, 0.044 * girth),
        (elbow.lerp(hand, 0.35), 0.044 * girth),
        (elbow.lerp(hand, 0.88), 0.034 * girth),
    ];
    tube(triangles, &points, sides, sleeve);
    let down = (hand - elbow).normalize_or(-Vec3::Z);
    let palm = hand + down * 0.055;
    tube(
        triangles,
        &[(elbow.lerp(hand, 0.84), 0.026), (hand + down * 0.01, 0.032), (palm, 0.037), (palm + down * 0.07, 0.020)],
        sides,
        SKIN,
    );
}

/// Hair of a head.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hair {
    pub finish: SurfaceFinish,
    /// True for hair down to the shoulders.
    pub is_long: bool,
}

/// Adds neck and head on a chest whose shoulders are at `chest`; the face looks along x.
pub(super) fn head(
    triangles: &mut TriangleList,
    chest: Vec3,
    top_m: f32,
    sides: Sides,
    skin: SurfaceFinish,
    hair: Hair,
) {
    let middle = Vec3::new(chest.x + 0.022, 0.0, top_m - 0.125);
    tube(triangles, &[(chest, 0.062), (middle - Vec3::new(0.012, 0.0, 0.06), 0.052)], sides, skin);
    let half = Vec3::new(0.094, 0.073, 0.116);
    let grid = [sides.max(6), sides.max(6) + 2];
    triangles.ellipsoid(middle, half, grid, |_| skin);
    // Hair covers the crown, the sides down to the ears, and the nape.
    triangles
        .ellipsoid(middle + Vec3::new(-0.014, 0.0, 0.020), half + Vec3::new(0.001, 0.008, 0.0), grid, |_| hair.finish);
    if hair.is_long {
        let nape = middle + Vec3::new(-0.062, 0.0, -0.085);
        triangles.ellipsoid(nape, Vec3::new(0.050, 0.080, 0.135), grid, |_| hair.finish);
    }
    if sides >= 10 {
        triangles.ellipsoid(middle + Vec3::new(0.090, 0.0, -0.014), Vec3::new(0.020, 0.013, 0.025), [6, 6], |_| skin);
        for side in [1.0, -1.0] {
            let eye = middle + Vec3::new(0.079, 0.031 * side, 0.012);
            triangles.ellipsoid(eye, Vec3::new(0.008, 0.013, 0.007), [6, 6], |_| matt([0.03, 0.025, 0.02]));
            let ear = middle + Vec3::new(-0.005, 0.078 * side, -0.008);
            triangles.ellipsoid(ear, Vec3::new(0.017, 0.010, 0.030), [6, 6], |_| skin);
        }
        let mouth = middle + Vec3::new(0.078, 0.0, -0.058);
        triangles.ellipsoid(mouth, Vec3::new(0.010, 0.022, 0.006), [6, 6], |_| matt([0.24, 0.09, 0.075]));
    }
}
