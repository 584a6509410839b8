//! People on foot: several builds, each standing and at the phases of the walk. Out: models at their usual sizes, metres; see the parent module.
//! The picture blends neighbouring phases (`shaders/posture.wgsl`).

use super::{
    DrawnPosture,
    gait::{self, Posture},
    limbs::{Hair, SIDES, Sides, arm, head, leg, matt, shoe, trunk},
    model::{Model, Shape},
};
use crate::{
    scene::mesh::{SurfaceFinish, TriangleList},
    traffic::gait::{HEIGHTS_M, build, cycles},
};
use glam::Vec3;

/// Size of SUMO's `pedestrian`. Its length is that of a person who stands; a step is longer and reaches beyond it on both sides.
pub(super) const WALKER: Shape = Shape {
    size: Vec3::new(0.215, 0.478, 1.719),
    axles: [0.10, -0.10],
    track_half: 0.0,
    // No wheel can be seen.
    wheel: [0.004, 0.004],
    indicators: [Vec3::ZERO; 2],
    indicator_radius: 0.0,
};

/// Number of phases of the walk that have a model of their own. Blended between two of them, no point is farther than 2.5 cm from its place.
const PHASES: usize = 16;
/// Speed from which a person makes whole steps, m/s; the posture of a slower one is blended with that of standing.
const WALKS_MPS: f64 = 0.3;

/// Build and clothes of a person.
struct Build {
    /// Widths of limbs and trunk over those of a slim person.
    girth: f32,
    skin: SurfaceFinish,
    hair: Hair,
    top: SurfaceFinish,
    /// Hem of the top, over the height.
    hem: f32,
    bottom: SurfaceFinish,
    /// Hem of a skirt over the height; `None` for trousers.
    skirt: Option<f32>,
    shoes: SurfaceFinish,
}

/// Builds of the heights [`HEIGHTS_M`].
const BUILDS: [Build; HEIGHTS_M.len()] = [
    Build {
        girth: 1.06,
        skin: matt([0.40, 0.25, 0.18]),
        hair: Hair { finish: matt([0.055, 0.035, 0.022]), is_long: false },
        top: matt([0.055, 0.10, 0.19]),
        hem: 0.50,
        bottom: matt([0.035, 0.045, 0.075]),
        skirt: None,
        shoes: matt([0.022, 0.018, 0.016]),
    },
    Build {
        girth: 0.92,
        skin: matt([0.46, 0.29, 0.21]),
        hair: Hair { finish: matt([0.16, 0.085, 0.035]), is_long: true },
        top: matt([0.34, 0.045, 0.05]),
        hem: 0.55,
        bottom: matt([0.045, 0.042, 0.05]),
        skirt: Some(0.31),
        shoes: matt([0.03, 0.028, 0.03]),
    },
    Build {
        girth: 1.24,
        skin: matt([0.17, 0.09, 0.058]),
        hair: Hair { finish: matt([0.018, 0.015, 0.014]), is_long: false },
        top: matt([0.30, 0.27, 0.20]),
        hem: 0.44,
        bottom: matt([0.09, 0.085, 0.08]),
        skirt: None,
        shoes: matt([0.05, 0.032, 0.02]),
    },
    Build {
        girth: 0.97,
        skin: matt([0.43, 0.27, 0.19]),
        hair: Hair { finish: matt([0.30, 0.29, 0.28]), is_long: false },
        top: matt([0.06, 0.15, 0.085]),
        hem: 0.47,
        bottom: matt([0.17, 0.145, 0.11]),
        skirt: None,
        shoes: matt([0.38, 0.37, 0.35]),
    },
];

/// Returns the models of each build, near and far: standing, then the phases of the walk.
pub(super) fn walkers() -> impl Iterator<Item = Vec<[Model; 2]>> {
    BUILDS.iter().zip(HEIGHTS_M).map(|(build, height_m)| {
        let walking = (0..PHASES).map(|k| gait::walking(height_m, k as f32 / PHASES as f32));
        let postures = std::iter::once(gait::standing(height_m)).chain(walking);
        postures.map(|posture| SIDES.map(|sides| model(build, height_m, &posture, sides))).collect()
    })
}

/// Returns the posture of a person with this number who has walked `moved_m`, after the first one of all people on foot.
pub(super) fn posture_of(number: u32, moved_m: f64, speed_mps: f64) -> DrawnPosture {
    let DrawnPosture { model, code } =
        DrawnPosture::new(cycles(number, moved_m), PHASES, (speed_mps / WALKS_MPS) as f32);
    DrawnPosture { model: build(number) * (1 + PHASES) + model, code }
}

fn model(build: &Build, height_m: f32, posture: &Posture, sides: Sides) -> Model {
    Model { triangles: person(build, height_m, posture, sides), shape: WALKER }
}

fn person(build: &Build, height_m: f32, posture: &Posture, sides: Sides) -> TriangleList {
    let mut triangles = TriangleList::cutting_alike();
    let body = &mut triangles;
    let girth = build.girth;
    let legwear = if build.skirt.is_some() { build.skin } else { build.bottom };
    for k in 0..2 {
        leg(body, &posture.legs[k], girth.sqrt(), build.skirt.is_some(), sides, legwear);
        shoe(body, &posture.legs[k], sides, build.shoes);
        arm(body, &posture.arms[k], girth.sqrt(), sides, build.top);
    }
    let Posture { pelvis, chest, .. } = *posture;
    if let Some(hem) = build.skirt {
        let knees = posture.legs.map(|leg| leg.hip.lerp(leg.knee, 0.85).x);
        let (low, high) = (knees[0].min(knees[1]), knees[0].max(knees[1]));
        let at_hem = Vec3::new((low + high) / 2.0, 0.0, hem * height_m);
        let hips = pelvis.with_z(pelvis.z + 0.02 * height_m);
        let sections = [
            (at_hem, [(high - low) / 2.0 + 0.10, 0.175]),
            (at_hem.lerp(hips, 0.6), [(high - low) / 4.0 + 0.115, 0.165]),
            (hips, [0.108, 0.148]),
            (hips + Vec3::Z * 0.06 * height_m, [0.085, 0.112]),
        ];
        trunk(body, &sections, sides + 2, build.bottom);
    }
    let depth = girth * girth;
    let section = |part: f32, forward: f32, left: f32, ahead: f32| {
        let middle = pelvis.lerp(chest, part) + Vec3::X * ahead;
        (middle, [forward * depth, left * girth])
    };
    let hem = (build.hem * height_m - pelvis.z) / (chest.z - pelvis.z);
    let above_hem = [
        section(0.10, 0.114, 0.158, 0.0),
        section(0.35, 0.102, 0.136, 0.004),
        section(0.62, 0.112, 0.152, 0.008),
        section(0.84, 0.112, 0.172, 0.004),
        section(0.95, 0.092, 0.170, 0.0),
        section(1.02, 0.070, 0.118, 0.0),
        section(1.07, 0.056, 0.068, 0.004),
    ];
    let at_hem = section(hem, 0.106, 0.152, 0.0);
    let above_hem = above_hem.into_iter().filter(|(middle, _)| middle.z > at_hem.0.z + 0.02);
    let sections: Vec<_> = std::iter::once(at_hem).chain(above_hem).collect();
    trunk(body, &sections, sides + 4, build.top);
    if build.skirt.is_none() {
        let seat =
            [section(-0.16, 0.085, 0.10, 0.0), section(-0.06, 0.108, 0.150, 0.0), section(0.12, 0.104, 0.148, 0.0)];
        trunk(body, &seat, sides + 2, build.bottom);
    }
    let top_m = chest.z + 0.185 * height_m;
    head(body, chest, top_m, sides, build.skin, build.hair);
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::vehicles::{
        FIRST_WALKER, models,
        tests::{drawn, farthest_m},
    };

    #[test]
    fn people_of_several_builds_are_as_tall_as_people_are() {
        for (postures, height_m) in walkers().zip(HEIGHTS_M) {
            assert_eq!(postures.len(), 1 + PHASES);
            for (k, [near, _]) in postures.into_iter().enumerate() {
                let mesh = near.triangles.into_mesh(0.7);
                let (low, high) = mesh.bounds();
                // Soles are on the ground, or a little above it on the ball of one foot.
                assert!((-0.02..0.03).contains(&low.z), "{k}: {low}");
                assert!(mesh.triangles() < 3000, "{k}: {}", mesh.triangles());
                assert!(k > 0 || (high.z - height_m).abs() < 0.03, "{high} for {height_m}");
            }
        }
        assert_eq!(walkers().count(), BUILDS.len());
    }

    #[test]
    fn a_person_stands_and_then_walks_through_all_phases() {
        assert_eq!(posture_of(4, 0.0, 0.0).model, 0);
        let seen: std::collections::BTreeSet<_> =
            (0..100).map(|k| posture_of(4, 1.36 * f64::from(k) / 100.0, 1.4).model).collect();
        assert_eq!(seen, (1..=PHASES).collect());
        assert_eq!(posture_of(5, 0.0, 0.0).model, 1 + PHASES, "the next has another build");
    }

    /// Promises 2.5 cm at worst and a centimetre on average over all corners.
    #[test]
    fn between_two_phases_a_body_is_where_the_gait_has_it() {
        let models = models();
        for (number, (build, height_m)) in BUILDS.iter().zip(HEIGHTS_M).enumerate() {
            for half in (1..2 * PHASES).step_by(2) {
                let phase = half as f32 / (2 * PHASES) as f32;
                let posture = DrawnPosture { model: number * (1 + PHASES) + 1 + half / 2, code: 128 };
                let points = drawn(&models, FIRST_WALKER, posture);
                let mesh = &models[FIRST_WALKER + posture.model].levels[0];
                let direct = person(build, height_m, &gait::walking(height_m, phase), SIDES[0]);
                let corners = mesh.indices.iter().zip(direct.corners().flatten());
                let off_m: Vec<f32> = corners.map(|(&index, corner)| points[index as usize].distance(corner)).collect();
                let most_m = off_m.iter().copied().fold(0.0, f32::max);
                let mean_m = off_m.iter().sum::<f32>() / off_m.len() as f32;
                assert!(most_m < 0.025 && mean_m < 0.010, "build {number}, phase {phase}: {most_m} m, {mean_m} m");
            }
        }
    }

    /// Promises that no point of a body is faster than 3.5 times the body: a foot in swing covers 0.62 of a cycle in 0.38 of its time, so that it is
    /// 2.6 times as fast as the body on average. Frames are 1/60 s apart.
    #[test]
    fn no_point_of_a_walking_body_jumps_between_two_frames() {
        const FRAME_S: f64 = 1.0 / 60.0;
        let models = models();
        for number in 0..BUILDS.len() as u32 {
            let speed_mps = 1.4;
            let of = |frame: u32| posture_of(number, f64::from(frame) * speed_mps * FRAME_S, speed_mps);
            let way_m = (speed_mps * FRAME_S) as f32;
            for frame in 0..70 {
                let moved_m = farthest_m(&models, FIRST_WALKER, [of(frame), of(frame + 1)], way_m);
                assert!(moved_m < 3.5 * way_m, "person {number}, frame {frame}: {moved_m} m");
            }
            // From standing, with 2 m/s2: the feet part within 0.15 s.
            let at_s = |frame: u32| f64::from(frame) * FRAME_S;
            let of = |frame: u32| posture_of(number, at_s(frame).powi(2), 2.0 * at_s(frame));
            for frame in 0..40 {
                let moved_m = farthest_m(&models, FIRST_WALKER, [of(frame), of(frame + 1)], 0.0);
                assert!(moved_m < 0.08, "person {number}, {frame} frames after the start: {moved_m} m");
            }
        }
    }
}
