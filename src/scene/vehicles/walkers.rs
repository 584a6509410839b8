//! Person on foot, in mid-step. Out: a model at its usual size, metres; see the parent module.

use super::{
    limbs::{JACKET, SKIN, TROUSERS, limb, limbs},
    model::{Model, Shape},
};
use crate::scene::{
    Material,
    mesh::{SurfaceFinish, TriangleList},
};
use glam::Vec3;

/// Size of SUMO's `pedestrian`. Its length is that of a person who stands; the model's step is longer and reaches beyond it on both sides.
pub(super) const WALKER: Shape = Shape {
    size: Vec3::new(0.215, 0.478, 1.719),
    axles: [0.10, -0.10],
    track_half: 0.0,
    // No wheel can be seen.
    wheel: [0.004, 0.004],
    indicators: [Vec3::ZERO; 2],
    indicator_radius: 0.0,
};

const SHOE: SurfaceFinish = SurfaceFinish::new(Material::Matt, [0.02, 0.02, 0.025]);
const HAIR: SurfaceFinish = SurfaceFinish::new(Material::Matt, [0.05, 0.035, 0.025]);

pub(super) fn walker() -> Model {
    let mut triangles = TriangleList::default();
    let body = &mut triangles;
    // The left leg is ahead, the right arm swings with it.
    for (side, swing) in [(1.0, 1.0), (-1.0, -1.0)] {
        let [hip, knee, ankle, toe] = [
            [0.0, 0.09 * side, 0.90],
            [0.12 * swing + 0.03, 0.09 * side, 0.50],
            [0.20 * swing - 0.03, 0.09 * side, 0.09],
            [0.20 * swing + 0.15, 0.09 * side, 0.05],
        ];
        limb(body, hip, knee, [0.088, 0.062], TROUSERS);
        limb(body, knee, ankle, [0.062, 0.042], TROUSERS);
        limb(body, [ankle[0] - 0.05, ankle[1], 0.05], toe, [0.05, 0.04], SHOE);
        let [shoulder, elbow, hand] =
            [[0.0, 0.17 * side, 1.42], [-0.08 * swing, 0.20 * side, 1.15], [-0.14 * swing + 0.10, 0.19 * side, 0.92]];
        limb(body, shoulder, elbow, [0.055, 0.045], JACKET);
        limb(body, elbow, hand, [0.045, 0.035], JACKET);
        body.ellipsoid(Vec3::from(hand), Vec3::splat(0.045), [6, 4], |_| SKIN);
    }
    limb(body, [0.0, 0.0, 0.86], [0.01, 0.0, 1.20], [0.145, 0.135], JACKET);
    limb(body, [0.01, 0.0, 1.20], [0.0, 0.0, 1.46], [0.135, 0.11], JACKET);
    limbs(body, [0.0, 0.0, 1.43], [0.0, 0.175, 1.42], [0.07, 0.06], JACKET);
    limb(body, [0.0, 0.0, 1.44], [0.01, 0.0, 1.54], [0.055, 0.05], SKIN);
    body.ellipsoid(Vec3::new(0.015, 0.0, 1.60), Vec3::new(0.095, 0.078, 0.115), [10, 8], |_| SKIN);
    body.ellipsoid(Vec3::new(-0.005, 0.0, 1.625), Vec3::new(0.095, 0.082, 0.094), [10, 8], |_| HAIR);
    Model { triangles, shape: WALKER }
}
