//! Windscreen and wipers of the ego. In: the intensity of the rain, time. Out: meshes, the angle of the arms over time, and their transforms to
//! the body's frame, metres and seconds.

use super::{Cockpit, Material, Mesh, TriangleList};
use crate::scene::{Vertex, car::materials::GLOSS};
use glam::{Affine3A, Mat3A, Vec3};
use std::f64::consts::TAU;

/// Foot and top of the windscreen's plane, x and z in the body's frame: that of the pillars.
const FOOT: [f32; 2] = [1.16, 0.945];
const TOP: [f32; 2] = [0.25, 1.36];
/// Largest distance of a drop on the glass from the ego's middle: those beside the windscreen lie on the side windows.
const ASIDE_M: f32 = 1.3;
/// Distance to the left of the two wipers' axles, and the lengths of their arms. Both lie to the right at rest.
pub const AXLES_M: [f32; 2] = [0.62, 0.01];
pub const ARMS_M: [f32; 2] = [0.82, 0.60];
/// Share of an arm without a blade.
pub const BARE: f32 = 0.14;
/// Angle of a whole sweep.
pub const SWEEP_RAD: f32 = 1.62;

/// Motion of the wipers: a sweep up and down, then rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WiperMotion {
    /// Time from the begin of a sweep to the next.
    pub period_s: f64,
    /// Duration of a sweep.
    pub sweep_s: f64,
}

impl WiperMotion {
    /// Returns the motion that a rain sensor chooses; `None` without rain. The rates are those of EU rules (docs/references.md: rain).
    pub fn in_rain(rain_mmph: f32) -> Option<Self> {
        /// Upper limits of light and of moderate rain, mm/h.
        const LIGHT: f32 = 2.5;
        const MODERATE: f32 = 7.6;
        let motion = |per_minute: f64, sweep_s: f64| Some(Self { period_s: 60.0 / per_minute, sweep_s });
        match rain_mmph {
            dry if dry <= 0.0 => None,
            light if light <= LIGHT => motion(15.0, 60.0 / 45.0),
            moderate if moderate <= MODERATE => motion(45.0, 60.0 / 45.0),
            _ => motion(62.0, 60.0 / 62.0),
        }
    }

    /// Returns the angle of both arms over their rest.
    pub fn angle_rad(&self, time_s: f64) -> f32 {
        let since_s = time_s.rem_euclid(self.period_s).min(self.sweep_s);
        (0.5 * (1.0 - (TAU * since_s / self.sweep_s).cos())) as f32 * SWEEP_RAD
    }
}

/// Returns the transform from the windscreen's plane (x to the left, y up along the glass, z outwards) to the body's frame.
fn body_from_glass() -> Affine3A {
    let up = Vec3::new(TOP[0] - FOOT[0], 0.0, TOP[1] - FOOT[1]).normalize();
    let axes = Mat3A::from_cols(Vec3::Y.into(), up.into(), Vec3::Y.cross(up).into());
    Affine3A { matrix3: axes, translation: Vec3::new(FOOT[0], 0.0, FOOT[1]).into() }
}

impl Cockpit {
    /// Returns the transforms of both wipers, from frames with the axle at the origin and the blade along x to 1, to the body's frame.
    pub fn body_from_wipers(angle_rad: f32) -> [Affine3A; 2] {
        std::array::from_fn(|k| {
            body_from_glass()
                * Affine3A::from_translation(Vec3::new(AXLES_M[k], 0.0, 0.012))
                * Affine3A::from_rotation_z(std::f32::consts::PI - angle_rad)
                * Affine3A::from_scale(Vec3::new(ARMS_M[k], 1.0, 1.0))
        })
    }
}

/// Returns the glass with its place on the plane as texture coordinates, metres.
pub(super) fn windscreen() -> Mesh {
    let high = Vec3::new(TOP[0] - FOOT[0], 0.0, TOP[1] - FOOT[1]).length();
    let normal = body_from_glass().transform_vector3(Vec3::Z);
    let corner = |x: f32, y: f32| Vertex {
        position: body_from_glass().transform_point3(Vec3::new(x, y, 0.0)).into(),
        normal: normal.into(),
        uv: [x, y],
        material: Material::Glass as u32,
        ..Vertex::default()
    };
    let corners = [(-ASIDE_M, 0.0), (ASIDE_M, 0.0), (ASIDE_M, high), (-ASIDE_M, high)];
    // Seen from inside.
    Mesh { vertices: corners.map(|(x, y)| corner(x, y)).into(), indices: vec![0, 2, 1, 0, 3, 2] }
}

/// Returns an arm with its blade, of length 1 along x.
pub(super) fn arm() -> Mesh {
    let mut parts = TriangleList::default();
    let bar = |parts: &mut TriangleList, [from, to]: [f32; 2], half: [f32; 2], off: Vec3| {
        let ring = |i: usize| {
            let at = off + Vec3::X * if i == 0 { from } else { to };
            [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)]
                .map(|(y, z)| at + Vec3::new(0.0, half[0] * y, half[1] * z))
                .into()
        };
        parts.bar(2, ring, GLOSS);
    };
    bar(&mut parts, [0.0, 0.62], [0.0045, 0.0025], Vec3::Z * 0.009);
    bar(&mut parts, [BARE, 1.0], [0.0025, 0.0045], Vec3::ZERO);
    parts.into_mesh(0.6)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ViewOptions;

    #[test]
    fn wipers_sweep_as_often_as_the_rules_ask() {
        assert_eq!(WiperMotion::in_rain(0.0), None);
        let per_minute = |rain_mmph| 60.0 / WiperMotion::in_rain(rain_mmph).expect("rain").period_s;
        // Regulation (EU) 1008/2010, annex III, 1.1.5: one frequency of 10 to 55, one of at least 45, at least 15 apart.
        let [light, moderate, heavy] = [1.0, 5.0, 20.0].map(per_minute);
        assert!((10.0..=55.0).contains(&light) && (10.0..=55.0).contains(&moderate), "{light} {moderate}");
        assert!(heavy >= 45.0 && heavy - moderate >= 15.0, "{heavy}");
    }

    #[test]
    fn a_sweep_goes_up_and_down_and_then_the_arms_rest() {
        let motion = WiperMotion { period_s: 4.0, sweep_s: 1.0 };
        for (time_s, share) in [(0.0, 0.0), (0.25, 0.5), (0.5, 1.0), (0.75, 0.5), (1.0, 0.0), (3.0, 0.0), (400.5, 1.0)]
        {
            assert!((motion.angle_rad(time_s) / SWEEP_RAD - share).abs() < 1e-4, "{time_s}");
        }
    }

    #[test]
    fn the_arms_lie_flat_at_rest_and_clear_the_drivers_view() {
        let eye = ViewOptions::default().eye;
        let tip = |k: usize, angle: f32| Cockpit::body_from_wipers(angle)[k].transform_point3(Vec3::X);
        for k in [0, 1] {
            assert!((tip(k, 0.0).z - FOOT[1]).abs() < 0.02, "at rest {}", tip(k, 0.0));
            assert!(tip(k, 0.0).y < AXLES_M[k] - 0.5, "to the right of its axle");
            assert!(tip(k, SWEEP_RAD).z > FOOT[1] + 0.2, "up: {}", tip(k, SWEEP_RAD));
        }
        // The place on the glass through which the driver sees the horizon straight ahead is wiped by their own wiper.
        let glass = body_from_glass().inverse();
        let (from, way) = (glass.transform_point3(eye), glass.transform_vector3(Vec3::X));
        let seen = from - way * (from.z / way.z);
        let reach_m = (seen.x - AXLES_M[0]).hypot(seen.y);
        assert!((BARE * ARMS_M[0]..ARMS_M[0]).contains(&reach_m), "{reach_m}");
        let angle = seen.y.atan2(AXLES_M[0] - seen.x);
        assert!((0.0..SWEEP_RAD).contains(&angle), "{angle}");
        assert!(windscreen().vertices.iter().all(|v| v.position[0] > 0.0));
    }
}
