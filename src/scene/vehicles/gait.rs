//! Postures of people in metres: on foot at a phase of the gait, standing, and at the pedals. In: height and phase. Out: joints in the body's frame:
//! x forward, y left, z up, origin on the ground under the middle.
//!
//! Lengths of limbs are shares of the height, and the walk has the usual proportions of a cycle (docs/references.md: walkers). The ball of a
//! foot on the ground goes back as fast as the body goes forward, so that no foot slides.

use crate::traffic::gait::CYCLE;
use glam::{Vec2, Vec3, vec2};
use std::f32::consts::{PI, TAU};

/// Share of the cycle in which a foot is on the ground.
const STANCE: f32 = 0.62;
/// Share of the cycle after which the heel leaves the ground.
const HEEL_UP: f32 = 0.36;
/// Pitch of the foot as the toes leave the ground and as the heel touches it, rad, positive heel up.
const TOE_OFF_RAD: f32 = 0.80;
const HEEL_STRIKE_RAD: f32 = -0.22;
/// Share of the cycle after which the whole sole is on the ground.
const FLAT_FROM: f32 = 0.08;

/// Lengths over the height.
const THIGH: f32 = 0.245;
const SHIN: f32 = 0.246;
const ANKLE: f32 = 0.042;
const UPPER_ARM: f32 = 0.186;
const FOREARM: f32 = 0.150;
/// Ankle and heel behind the ball of the foot, and the ball above the ground.
const ANKLE_TO_BALL: f32 = 0.085;
const BALL_TO_HEEL: f32 = 0.105;
const BALL: f32 = 0.012;
/// Ankle seen from the ball of a flat foot.
const FLAT: Vec2 = vec2(-ANKLE_TO_BALL, ANKLE - BALL);
/// Height of the hips of one who walks, and of the shoulders above the hips; half widths of both.
const HIP: f32 = 0.505;
const TRUNK: f32 = 0.285;
const HIP_BOB: f32 = 0.011;
const HALF_SHOULDERS: f32 = 0.112;
const HALF_HIPS: f32 = 0.052;

/// Joints of a leg.
#[derive(Clone, Copy, Debug)]
pub(super) struct Leg {
    pub hip: Vec3,
    pub knee: Vec3,
    pub ankle: Vec3,
    /// Ball of the foot.
    pub ball: Vec3,
}

/// Joints of an arm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arm {
    pub shoulder: Vec3,
    pub elbow: Vec3,
    pub hand: Vec3,
}

/// Posture of a person: the left limbs first.
#[derive(Clone, Copy, Debug)]
pub(super) struct Posture {
    pub legs: [Leg; 2],
    pub arms: [Arm; 2],
    /// Middle between the hips.
    pub pelvis: Vec3,
    /// Middle between the shoulders.
    pub chest: Vec3,
}

/// Returns the posture at a phase of the walk, 0 to 1: at 0 the left heel touches the ground.
pub(super) fn walking(height_m: f32, phase: f32) -> Posture {
    let hip_m = height_m * (HIP + HIP_BOB * (2.0 * TAU * (phase - 0.3)).cos());
    let pelvis = Vec3::new(0.0, 0.0, hip_m);
    let chest = Vec3::new(0.03 * height_m, 0.0, hip_m + TRUNK * height_m);
    let side = |k: usize| if k == 0 { 1.0 } else { -1.0 };
    let phases = [phase, (phase + 0.5).fract()];
    let leg = |k: usize| {
        let (ankle, ball) = foot(phases[k]);
        leg_to(height_m, pelvis, side(k), ankle * height_m, ball * height_m)
    };
    let arm = |k: usize| {
        // An arm swings against the leg of its side.
        let swing_rad = 0.06 - 0.36 * (TAU * phases[k]).cos();
        let bend_rad = 0.30 + 0.5 * swing_rad.max(0.0);
        arm_at(height_m, chest, side(k), swing_rad, bend_rad)
    };
    Posture { legs: [0, 1].map(leg), arms: [0, 1].map(arm), pelvis, chest }
}

/// Returns the posture of a person who stands at ease.
pub(super) fn standing(height_m: f32) -> Posture {
    let pelvis = Vec3::new(0.0, 0.0, height_m * (THIGH + SHIN + ANKLE - 0.004));
    let chest = pelvis + Vec3::Z * TRUNK * height_m;
    let leg = |k: usize| {
        let side = [1.0, -1.0][k];
        let ankle = vec2(-0.02, ANKLE) * height_m;
        leg_to(height_m, pelvis, side, ankle, ankle - FLAT * height_m)
    };
    let arm = |k: usize| arm_at(height_m, chest, [1.0, -1.0][k], 0.04, 0.18);
    Posture { legs: [0, 1].map(leg), arms: [0, 1].map(arm), pelvis, chest }
}

/// Returns ankle and ball of a foot at a phase of its leg, forward and up, over the height.
fn foot(phase: f32) -> (Vec2, Vec2) {
    if phase < STANCE {
        return foot_on_ground(phase);
    }
    let part = (phase - STANCE) / (1.0 - STANCE);
    let (from, to) = (foot_on_ground(STANCE).0, foot_on_ground(0.0).0);
    let pitch_rad = TOE_OFF_RAD * (1.0 - smooth(part * 1.4)) + HEEL_STRIKE_RAD * smooth(part);
    let lift = vec2(0.0, 0.035 * (PI * part).sin());
    let ankle = from.lerp(to, 0.5 * part + 0.5 * smooth(part)) + lift;
    (ankle, ankle - turned(FLAT, pitch_rad))
}

/// Returns the same while the foot is on the ground, on its heel, its sole or its ball.
fn foot_on_ground(phase: f32) -> (Vec2, Vec2) {
    let (pitch_rad, heel_m) = if phase < FLAT_FROM {
        let pitch_rad = HEEL_STRIKE_RAD * (1.0 - phase / FLAT_FROM);
        (pitch_rad, -BALL_TO_HEEL * pitch_rad.sin())
    } else {
        (TOE_OFF_RAD * smooth((phase - HEEL_UP) / (STANCE - HEEL_UP)), 0.0)
    };
    // The ball goes back with the road.
    let ball = vec2(0.185 + ANKLE_TO_BALL - CYCLE * phase, BALL + heel_m);
    (ball + turned(FLAT, pitch_rad), ball)
}

/// Turns a vector, forward and up, so that what is behind rises.
fn turned(vector: Vec2, pitch_rad: f32) -> Vec2 {
    Vec2::from_angle(-pitch_rad).rotate(vector)
}

fn smooth(part: f32) -> f32 {
    crate::space::smoothstep(0.0, 1.0, part)
}

/// Returns the leg from a pelvis to a foot, whose ankle and ball are given forward and up.
fn leg_to(height_m: f32, pelvis: Vec3, side: f32, ankle: Vec2, ball: Vec2) -> Leg {
    let hip = pelvis + Vec3::Y * side * HALF_HIPS * height_m;
    let place = |at: Vec2| Vec3::new(at.x, side * (HALF_HIPS + 0.004) * height_m, at.y);
    let (knee, ankle) = bent(hip, place(ankle), [THIGH * height_m, SHIN * height_m], Vec3::X);
    Leg { hip, knee, ankle, ball: place(ball) }
}

/// Returns middle joint and end of a limb of two parts from `from` towards `to`, bent towards `side`; it ends short of what it cannot reach.
fn bent(from: Vec3, to: Vec3, [upper_m, lower_m]: [f32; 2], side: Vec3) -> (Vec3, Vec3) {
    let along = (to - from).normalize_or(-Vec3::Z);
    let reach_m = from.distance(to).min(0.9995 * (upper_m + lower_m));
    let foot_m = (upper_m * upper_m - lower_m * lower_m + reach_m * reach_m) / (2.0 * reach_m);
    let out_m = (upper_m * upper_m - foot_m * foot_m).max(0.0).sqrt();
    let out = (side - along * side.dot(along)).normalize_or(Vec3::X);
    (from + along * foot_m + out * out_m, from + along * reach_m)
}

/// Returns the arm at a swing of the shoulder and a bend of the elbow, rad, both positive forward.
fn arm_at(height_m: f32, chest: Vec3, side: f32, swing_rad: f32, bend_rad: f32) -> Arm {
    let shoulder = chest + Vec3::new(0.0, side * HALF_SHOULDERS * height_m, -0.012 * height_m);
    let down = |angle_rad: f32, out: f32| Vec3::new(angle_rad.sin(), side * out, -angle_rad.cos()).normalize();
    let elbow = shoulder + down(swing_rad, 0.10) * UPPER_ARM * height_m;
    Arm { shoulder, elbow, hand: elbow + down(swing_rad + bend_rad, 0.0) * FOREARM * height_m }
}

/// Returns the leg of a rider of this height from a hip to a pedal.
pub(super) fn leg_on_pedal(height_m: f32, hip: Vec3, pedal: Vec3) -> Leg {
    let ankle = pedal + Vec3::new(-0.09, 0.0, 0.095);
    let (knee, ankle) = bent(hip, ankle, [THIGH * height_m, SHIN * height_m], Vec3::X);
    Leg { hip, knee, ankle, ball: pedal + Vec3::new(0.03, 0.0, 0.03) }
}

/// Returns the arm of a rider of this height from a shoulder to a grip, its elbow low and outside.
pub(super) fn arm_on_grip(height_m: f32, shoulder: Vec3, grip: Vec3) -> Arm {
    let out = Vec3::new(-0.3, 0.4 * shoulder.y.signum(), -1.0);
    let (elbow, hand) = bent(shoulder, grip, [UPPER_ARM * height_m, (FOREARM + 0.02) * height_m], out);
    Arm { shoulder, elbow, hand }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ball_of_a_foot_on_the_ground_does_not_slide() {
        let height_m = 1.75;
        // From flat foot to toe-off the body goes on by the cycle's share.
        for k in 10..60 {
            let phase = k as f32 / 100.0;
            let [at, next] = [phase, phase + 0.01].map(|phase| walking(height_m, phase).legs[0].ball);
            let slid_m = next.x - at.x + 0.01 * CYCLE * height_m;
            assert!(slid_m.abs() < 1e-4 && (at.z - BALL * height_m).abs() < 1e-4, "{phase}: {slid_m} m, {at}");
        }
    }

    #[test]
    fn limbs_keep_their_lengths_and_no_foot_is_below_the_ground() {
        let height_m = 1.75;
        for k in 0..200 {
            let posture = walking(height_m, k as f32 / 200.0);
            for leg in posture.legs {
                let [thigh_m, shin_m] = [leg.hip.distance(leg.knee), leg.knee.distance(leg.ankle)];
                assert!((thigh_m - THIGH * height_m).abs() < 2e-3 && (shin_m - SHIN * height_m).abs() < 2e-3, "{k}");
                assert!(leg.ball.z > 0.0 && leg.ankle.z > 0.03 * height_m, "{k}: {leg:?}");
                // A knee bends forward alone.
                assert!(leg.knee.x > leg.hip.lerp(leg.ankle, 0.5).x - 1e-3, "{k}: {leg:?}");
            }
        }
        // Two steps later all is as before.
        let [first, again] = [0.0, 1.0].map(|phase: f32| walking(height_m, phase.fract()).legs[1].ankle);
        assert_eq!(first, again);
    }
}
