//! Single-track vehicles with their riders: motorcycle and bicycle. Out: models at their usual sizes, metres; see the parent
//! module.

use super::{
    DrawnPosture, gait,
    limbs::{Hair, JACKET, SIDES, SKIN, Sides, TROUSERS, arm, head, leg, limb, limbs, matt, shoe, tube},
    model::{Model, Shape, block},
};
use crate::scene::{
    Material,
    car::materials::{BRAKE, DARK, PAINT, TRIM},
    mesh::{SurfaceFinish, TriangleList},
};
use glam::{Quat, Vec3};
use std::f32::consts::{PI, TAU};

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
/// Yellow of a cyclist's jacket.
const SHIRT: SurfaceFinish = matt([0.46, 0.40, 0.06]);
const STEEL: SurfaceFinish = SurfaceFinish::grey(Material::Metal, 0.40);

/// Number of positions of the cranks that have a model of their own.
const CRANKS: usize = 16;
/// Number of models of a bicycle.
pub(super) const BICYCLES: usize = 1 + CRANKS;
/// Middle of the cranks and their length.
const CRANK: [f32; 3] = [-0.06, 0.0, 0.30];
const CRANK_M: f32 = 0.17;
/// Way of a bicycle in a turn of the cranks: a middle gear.
const TURN_M: f64 = 4.6;
/// Speed from which a cyclist has both feet on the pedals, m/s; the posture of a slower one is blended with that of standing.
const RIDES_MPS: f64 = 1.0;
/// Height of a rider, and the top of the helmet above the shoulders.
const RIDER_M: f32 = 1.74;
const HELMET_M: f32 = 0.30;

/// Posture of a rider: positions in the body's frame, metres; the hand is that of the left side.
struct Rider {
    hips: [f32; 3],
    shoulders: [f32; 3],
    hand: [f32; 3],
    /// Pedals or foot rests, the left one first.
    feet: [[f32; 3]; 2],
    top: SurfaceFinish,
    helmet: SurfaceFinish,
}

fn rider(triangles: &mut TriangleList, rider: &Rider, sides: Sides) {
    let Rider { hips, shoulders, hand, feet, top, helmet } = rider;
    let (hips, shoulders) = (Vec3::from(*hips), Vec3::from(*shoulders));
    let back = (shoulders - hips).normalize();
    let sections: Vec<_> = [(-0.08, 0.115), (0.10, 0.150), (0.45, 0.125), (0.80, 0.165), (0.97, 0.150), (1.05, 0.075)]
        .map(|(part, radius): (f32, f32)| (hips + back * (part * hips.distance(shoulders)), radius))
        .into();
    tube(triangles, &sections, sides + 2, *top);
    for (side, foot) in [(1.0, feet[0]), (-1.0, feet[1])] {
        let flip = |[x, y, z]: [f32; 3]| Vec3::new(x, y.abs() * side, z);
        let leg_of = gait::leg_on_pedal(RIDER_M, hips + Vec3::Y * 0.09 * side, flip(foot));
        leg(triangles, &leg_of, 1.0, false, sides, TROUSERS);
        shoe(triangles, &leg_of, sides, DARK);
        let arm_of = gait::arm_on_grip(RIDER_M, shoulders + Vec3::Y * 0.155 * side, flip(*hand));
        arm(triangles, &arm_of, 1.0, sides, *top);
    }
    let hair = Hair { finish: matt([0.05, 0.03, 0.02]), is_long: false };
    let top_m = shoulders.z + HELMET_M - 0.015;
    head(triangles, shoulders + back * 0.04, top_m, sides, SKIN, hair);
    let middle = Vec3::new(shoulders.x + back.x * 0.04 + 0.012, 0.0, top_m - 0.095);
    let shell = |outwards: Vec3| if outwards.z > -0.2 { *helmet } else { hair.finish };
    triangles.ellipsoid(middle, Vec3::new(0.132, 0.098, 0.110), [sides.max(6), sides.max(6) + 2], shell);
}

/// Returns the posture of a cyclist who has ridden `moved_m`.
pub(super) fn posture_of(moved_m: f64, speed_mps: f64) -> DrawnPosture {
    DrawnPosture::new(moved_m / TURN_M, CRANKS, (speed_mps / RIDES_MPS) as f32)
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
            hips: [-0.32, 0.0, 0.80],
            shoulders: [-0.08, 0.0, 1.20],
            hand: [0.38, 0.33, 1.0],
            feet: [[-0.18, 0.20, 0.30]; 2],
            top: JACKET,
            helmet: PAINT,
        },
        8,
    );
    Model { triangles, shape: MOTORCYCLE }
}

/// Returns the models of a bicycle with its rider, near and far: standing with a foot on the ground, then the positions of the cranks.
pub(super) fn bicycles() -> impl Iterator<Item = [Model; 2]> {
    let ridden = (0..CRANKS).map(|k| Some(TAU * k as f32 / CRANKS as f32));
    std::iter::once(None).chain(ridden).map(|turn_rad| SIDES.map(|sides| bicycle(turn_rad, sides)))
}

/// Returns a bicycle whose left crank has turned by this angle from its foremost position; `None` stands with the left foot on the ground.
fn bicycle(turn_rad: Option<f32>, sides: Sides) -> Model {
    let mut triangles = TriangleList::cutting_alike();
    let [front, rear] = BICYCLE.axles;
    // Frame: crank, saddle and head tube.
    let (crank, saddle, head) = (CRANK, [-0.22, 0.0, 0.86], [0.33, 0.0, 0.82]);
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
    let pedal = |angle_rad: f32, side: f32| {
        let (sin, cos) = angle_rad.sin_cos();
        [CRANK[0] + CRANK_M * cos, 0.12 * side, CRANK[2] - CRANK_M * sin]
    };
    let angle_rad = turn_rad.unwrap_or(-0.5 * PI);
    let pedals = [pedal(angle_rad, 1.0), pedal(angle_rad + PI, -1.0)];
    for (turn_rad, [x, y, z]) in [angle_rad, angle_rad + PI].into_iter().zip(pedals) {
        // Built forwards and turned, so that its corners turn with it.
        let mut crank = TriangleList::cutting_alike();
        limb(&mut crank, [0.0, y * 0.5, 0.0], [CRANK_M, y * 0.5, 0.0], [0.014, 0.012], STEEL);
        triangles.append(crank.moved(|corner| Vec3::from(CRANK) + Quat::from_rotation_y(turn_rad) * corner));
        block(&mut triangles, [x - 0.045, y - 0.045, z - 0.010], [x + 0.045, y + 0.045, z + 0.010], DARK);
    }
    let left = if turn_rad.is_some() { pedals[0] } else { [-0.10, 0.26, 0.02] };
    rider(
        &mut triangles,
        &Rider {
            hips: [-0.22, 0.0, 0.94],
            shoulders: [0.05, 0.0, 1.40],
            hand: [0.28, 0.27, 1.05],
            feet: [left, pedals[1]],
            top: SHIRT,
            helmet: PAINT,
        },
        sides,
    );
    Model { triangles, shape: BICYCLE }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::vehicles::{
        FIRST_BICYCLE, models,
        tests::{drawn, farthest_m},
    };

    /// Promises that no point of a cyclist is faster than the bicycle and its pedals together, whose way in a turn of the cranks is a circle of 0.17 m,
    /// with a tenth more for knees. Frames are 1/60 s apart.
    #[test]
    fn no_point_of_a_cyclist_jumps_between_two_frames() {
        let models = models();
        let (speed_mps, frame_s) = (5.0, 1.0 / 60.0);
        let way_m = (speed_mps * frame_s) as f32;
        let of = |frame: u32| posture_of(f64::from(frame) * speed_mps * frame_s, speed_mps);
        let most_m = way_m * (1.0 + 1.1 * TAU * CRANK_M / TURN_M as f32) + 0.001;
        for frame in 0..60 {
            let moved_m = farthest_m(&models, FIRST_BICYCLE, [of(frame), of(frame + 1)], way_m);
            assert!(moved_m < most_m, "frame {frame}: {moved_m} m, more than {most_m} m");
        }
        // From standing, with 1 m/s2: the left foot comes from the ground to the pedal.
        let at = |frame: u32| posture_of(0.5 * (f64::from(frame) * frame_s).powi(2), f64::from(frame) * frame_s);
        for frame in 0..70 {
            let moved_m = farthest_m(&models, FIRST_BICYCLE, [at(frame), at(frame + 1)], 0.0);
            assert!(moved_m < 0.03, "{frame} frames after the start: {moved_m} m");
        }
    }

    /// Promises 2 cm at worst.
    #[test]
    fn between_two_positions_of_the_cranks_a_cyclist_is_where_they_are() {
        let models = models();
        for k in 0..CRANKS {
            let direct = bicycle(Some(TAU * (k as f32 + 0.5) / CRANKS as f32), SIDES[0]).triangles;
            let posture = DrawnPosture { model: 1 + k, code: 128 };
            let points = drawn(&models, FIRST_BICYCLE, posture);
            let mesh = &models[FIRST_BICYCLE + posture.model].levels[0];
            for (&index, corner) in mesh.indices.iter().zip(direct.corners().flatten()) {
                let off_m = points[index as usize].distance(corner);
                assert!(off_m < 0.02, "position {k}: {off_m} m at {corner}");
            }
        }
    }
}
