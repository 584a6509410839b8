//! People on foot: several builds, each standing and at the phases of the walk. Out: models at their usual sizes, metres; see the parent module.

use super::{
    gait::{self, Posture},
    limbs::{Hair, SIDES, Sides, arm, head, leg, matt, shoe, trunk},
    model::{Model, Shape},
};
use crate::scene::mesh::{SurfaceFinish, TriangleList};
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

/// Number of phases of the walk that have a model of their own.
const PHASES: usize = 20;
/// Speed below which a person stands, m/s.
const STANDS_MPS: f64 = 0.1;

/// Build and clothes of a person.
struct Build {
    height_m: f32,
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

const BUILDS: [Build; 4] = [
    Build {
        height_m: 1.79,
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
        height_m: 1.66,
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
        height_m: 1.73,
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
        height_m: 1.70,
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

/// Returns the models of all builds at each level of detail: standing, then the phases of the walk.
pub(super) fn walkers() -> impl Iterator<Item = [Model; 3]> {
    BUILDS.iter().flat_map(|build| {
        let walking = (0..PHASES).map(|k| gait::walking(build.height_m, k as f32 / PHASES as f32));
        std::iter::once(gait::standing(build.height_m))
            .chain(walking)
            .map(|posture| SIDES.map(|sides| Model { triangles: person(build, &posture, sides), shape: WALKER }))
    })
}

/// Returns the index of the model of a person with this number who has walked `moved_m`.
pub(super) fn model_of(number: u32, moved_m: f64, speed_mps: f64) -> usize {
    let build = number as usize % BUILDS.len();
    let first = build * (1 + PHASES);
    if speed_mps < STANDS_MPS {
        return first;
    }
    let cycles = moved_m / f64::from(gait::CYCLE * BUILDS[build].height_m);
    // People do not step in time with each other.
    let phase = (cycles + f64::from(number) * 0.37).rem_euclid(1.0);
    first + 1 + ((phase * PHASES as f64) as usize).min(PHASES - 1)
}

fn person(build: &Build, posture: &Posture, sides: Sides) -> TriangleList {
    let mut triangles = TriangleList::default();
    let body = &mut triangles;
    let (height_m, girth) = (build.height_m, build.girth);
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

    #[test]
    fn people_of_several_builds_are_as_tall_as_people_are() {
        let mut heights = Vec::new();
        for (k, [near, ..]) in walkers().enumerate() {
            let mesh = near.triangles.into_mesh(0.7);
            let (low, high) = mesh.bounds();
            // Soles are on the ground, or a little above it on the ball of one foot.
            assert!((-0.02..0.03).contains(&low.z), "{k}: {low}");
            assert!(mesh.triangles() < 3000, "{k}: {}", mesh.triangles());
            if k % (1 + PHASES) == 0 {
                heights.push(high.z);
            }
        }
        for (height_m, build) in heights.iter().zip(&BUILDS) {
            assert!((height_m - build.height_m).abs() < 0.03, "{height_m} for {}", build.height_m);
        }
        assert_eq!(walkers().count(), BUILDS.len() * (1 + PHASES));
    }

    #[test]
    fn a_person_stands_and_then_walks_through_all_phases() {
        assert_eq!(model_of(4, 0.0, 0.0), 0);
        let cycle_m = f64::from(gait::CYCLE * BUILDS[0].height_m);
        let seen: std::collections::BTreeSet<_> =
            (0..100).map(|k| model_of(4, cycle_m * f64::from(k) / 100.0, 1.4)).collect();
        assert_eq!(seen, (1..=PHASES).collect());
        assert_eq!(model_of(5, 0.0, 0.0), 1 + PHASES, "the next has another build");
    }
}
