//! Single-track vehicles with their riders: motorcycle and bicycle. Out: models at their usual sizes, metres; see the parent
//! module.

use super::{
    limbs::{JACKET, SHIRT, SKIN, TROUSERS, limb, limbs},
    model::{Model, Shape, block},
};
use crate::scene::{
    Material,
    car::materials::{BRAKE, DARK, PAINT, TRIM},
    mesh::{SurfaceFinish, TriangleList},
};
use glam::Vec3;

/// Sizes of SUMO's `motorcycle` and `bicycle`.
pub(super) const MOTORCYCLE: Shape = Shape {
    size: Vec3::new(2.2, 0.9, 1.5),
    axles: [0.78, -0.76],
    track_half: 0.0,
    wheel: [0.31, 0.13],
    indicators: [Vec3::new(0.72, 0.22, 0.82), Vec3::new(-0.98, 0.20, 0.70)],
    indicator_radius: 0.035,
};
pub(super) const BICYCLE: Shape = Shape {
    size: Vec3::new(1.6, 0.65, 1.7),
    axles: [0.47, -0.46],
    track_half: 0.0,
    wheel: [0.335, 0.035],
    indicators: [Vec3::new(0.40, 0.30, 1.02), Vec3::new(-0.30, 0.22, 1.20)],
    indicator_radius: 0.03,
};

const LIGHT: SurfaceFinish = SurfaceFinish::new(Material::HeadLamp, [0.85, 1.0, 1.0]);
const STEEL: SurfaceFinish = SurfaceFinish::grey(Material::Metal, 0.40);

/// Posture of a rider: positions in the body's frame, metres; hand, knee and foot are those of the left side.
struct Rider {
    hips: [f32; 3],
    shoulders: [f32; 3],
    head: [f32; 3],
    hand: [f32; 3],
    knee: [f32; 3],
    foot: [f32; 3],
    top: SurfaceFinish,
    helmet: SurfaceFinish,
}

fn rider(triangles: &mut TriangleList, rider: &Rider) {
    let Rider { hips, shoulders, head, hand, knee, foot, top, helmet } = rider;
    limb(triangles, *hips, *shoulders, [0.155, 0.175], *top);
    let across = |[x, _, z]: [f32; 3], y: f32| [x, y, z];
    limb(triangles, across(*shoulders, -0.20), across(*shoulders, 0.20), [0.075, 0.075], *top);
    let elbow = [(shoulders[0] + hand[0]) / 2.0 - 0.02, 0.27, (shoulders[2] + hand[2]) / 2.0 - 0.06];
    limbs(triangles, across(*shoulders, 0.20), elbow, [0.06, 0.05], *top);
    limbs(triangles, elbow, *hand, [0.05, 0.04], *top);
    limbs(triangles, across(*hips, 0.10), *knee, [0.095, 0.07], TROUSERS);
    limbs(triangles, *knee, *foot, [0.07, 0.05], TROUSERS);
    limbs(triangles, *foot, [foot[0] + 0.16, foot[1], foot[2] - 0.03], [0.05, 0.04], DARK);
    triangles.ellipsoid(Vec3::from(*head), Vec3::new(0.125, 0.105, 0.135), [8, 12], |outwards| {
        if outwards.x > 0.45 && outwards.z < 0.35 { SKIN } else { *helmet }
    });
}

pub(super) fn motorcycle() -> Model {
    let mut triangles = TriangleList::default();
    // Engine, tank, seat, tail.
    block(&mut triangles, [-0.30, -0.16, 0.26], [0.36, 0.16, 0.62], DARK);
    triangles.ellipsoid(Vec3::new(0.20, 0.0, 0.78), Vec3::new(0.32, 0.15, 0.14), [8, 12], |_| PAINT);
    block(&mut triangles, [-0.72, -0.13, 0.70], [-0.05, 0.13, 0.79], TRIM);
    block(&mut triangles, [-1.02, -0.10, 0.70], [-0.66, 0.10, 0.82], PAINT);
    block(&mut triangles, [-1.06, -0.08, 0.72], [-1.02, 0.08, 0.80], BRAKE);
    block(&mut triangles, [-1.10, -0.09, 0.46], [-1.085, 0.09, 0.60], SurfaceFinish::grey(Material::Matt, 0.6));
    limb(&mut triangles, [-0.85, 0.0, 0.72], [-1.09, 0.0, 0.56], [0.03, 0.03], DARK);
    // Fork, head lamp, handlebar, swing arm, exhaust.
    limbs(&mut triangles, [0.78, 0.09, 0.31], [0.46, 0.09, 0.92], [0.028, 0.028], STEEL);
    triangles.ellipsoid(Vec3::new(0.60, 0.0, 0.86), Vec3::new(0.12, 0.15, 0.15), [8, 12], |o| {
        if o.x > 0.5 { LIGHT } else { PAINT }
    });
    limb(&mut triangles, [0.40, -0.36, 0.98], [0.40, 0.36, 0.98], [0.018, 0.018], DARK);
    limbs(&mut triangles, [-0.10, 0.09, 0.36], [-0.76, 0.09, 0.31], [0.03, 0.03], DARK);
    limb(&mut triangles, [0.25, -0.20, 0.28], [-0.85, -0.20, 0.36], [0.045, 0.055], STEEL);
    block(&mut triangles, [0.50, -0.07, 0.60], [1.10, 0.07, 0.635], PAINT);
    limbs(&mut triangles, [0.42, 0.20, 0.98], [0.46, 0.34, 1.12], [0.012, 0.012], DARK);
    limbs(&mut triangles, [0.46, 0.34, 1.12], [0.46, 0.43, 1.12], [0.04, 0.04], DARK);
    rider(
        &mut triangles,
        &Rider {
            hips: [-0.32, 0.0, 0.86],
            shoulders: [-0.08, 0.0, 1.24],
            head: [0.02, 0.0, 1.366],
            hand: [0.38, 0.33, 1.0],
            knee: [0.10, 0.22, 0.72],
            foot: [-0.22, 0.20, 0.34],
            top: JACKET,
            helmet: PAINT,
        },
    );
    Model { triangles, shape: MOTORCYCLE }
}

pub(super) fn bicycle() -> Model {
    let mut triangles = TriangleList::default();
    let [front, rear] = BICYCLE.axles;
    // Frame: crank, saddle and head tube.
    let (crank, saddle, head) = ([-0.06, 0.0, 0.30], [-0.22, 0.0, 0.86], [0.33, 0.0, 0.82]);
    for (from, to) in [(crank, saddle), (crank, head), ([-0.18, 0.0, 0.74], head)] {
        limb(&mut triangles, from, to, [0.02, 0.02], PAINT);
    }
    limbs(&mut triangles, [crank[0], 0.05, crank[2]], [rear, 0.05, 0.335], [0.012, 0.012], PAINT);
    limbs(&mut triangles, [-0.18, 0.04, 0.74], [rear, 0.05, 0.335], [0.012, 0.012], PAINT);
    limbs(&mut triangles, [0.34, 0.04, 0.78], [front, 0.05, 0.335], [0.014, 0.014], PAINT);
    limb(&mut triangles, head, [0.28, 0.0, 1.02], [0.016, 0.016], STEEL);
    limb(&mut triangles, [0.28, -0.29, 1.02], [0.28, 0.29, 1.02], [0.014, 0.014], DARK);
    block(&mut triangles, [-0.36, -0.07, 0.86], [-0.10, 0.07, 0.91], TRIM);
    limb(&mut triangles, [crank[0], -0.10, crank[2]], [crank[0], 0.10, crank[2]], [0.05, 0.05], STEEL);
    block(&mut triangles, [-0.48, -0.03, 0.74], [-0.44, 0.03, 0.82], BRAKE);
    block(&mut triangles, [0.38, -0.03, 0.88], [0.44, 0.03, 0.94], LIGHT);
    // The mudguards end where the wheels end.
    block(&mut triangles, [rear - 0.34, -0.03, 0.34], [rear - 0.325, 0.03, 0.52], TRIM);
    rider(
        &mut triangles,
        &Rider {
            hips: [-0.22, 0.0, 0.96],
            shoulders: [0.02, 0.0, 1.40],
            head: [0.10, 0.0, 1.566],
            hand: [0.28, 0.27, 1.05],
            knee: [0.14, 0.12, 0.74],
            foot: [-0.06, 0.12, 0.24],
            top: SHIRT,
            helmet: PAINT,
        },
    );
    Model { triangles, shape: BICYCLE }
}
