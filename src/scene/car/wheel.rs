//! Wheel: a tyre and a rim with five spokes, which make rotation visible. Axle along y through the origin, outer side towards +y,
//! metres.

use super::materials::{LampLevel, WHEEL_RADIUS_M};
use crate::scene::{
    Material, Mesh,
    mesh::{SurfaceFinish, TriangleList},
};
use glam::Vec3;
use std::f32::consts::TAU;

const SPOKES: usize = 5;
/// Width of the tyre, metres.
pub const WHEEL_WIDTH_M: f32 = 0.22;

/// Returns the closed wheel at each level of detail.
pub fn wheels() -> [Mesh; 3] {
    [LampLevel::Near, LampLevel::Mid, LampLevel::Far].map(wheel)
}

fn wheel(level: LampLevel) -> Mesh {
    let mut triangles = TriangleList::default();
    // 40 corners deviate from the circle by 1 mm, 10 corners by 16 mm.
    let sides = match level {
        LampLevel::Near => 40,
        LampLevel::Mid => 18,
        LampLevel::Far => 10,
    };
    let half = WHEEL_WIDTH_M / 2.0;
    let r = WHEEL_RADIUS_M;
    let tyre = SurfaceFinish::grey(Material::Tyre, 0.022);
    let rim = SurfaceFinish::grey(Material::Metal, 0.46);
    // Matt, not polished, so that turning spokes are visible in any light.
    let alloy = SurfaceFinish::grey(Material::Matt, 0.24);
    let well = SurfaceFinish::grey(Material::Matt, 0.02);
    let inside = SurfaceFinish::grey(Material::Matt, 0.015);
    // From the middle of the inner side over the tread into the dish of the rim: (y, radius), finish up to the next point.
    let profile = [
        (-0.085, 0.0, inside),
        (-0.085, 0.215, tyre),
        (-half, 0.262, tyre),
        (-half + 0.012, r - 0.018, tyre),
        (-half + 0.035, r, tyre),
        (half - 0.035, r, tyre),
        (half - 0.012, r - 0.018, tyre),
        (half, 0.262, tyre),
        (half - 0.010, 0.222, rim),
        (half - 0.022, 0.205, well),
        (half - 0.075, 0.190, well),
        (half - 0.075, 0.0, well),
    ];
    // At the far level: tread, two sides, a bright disc.
    let flat = [(-half, 0.0, tyre), (-half, r, tyre), (half, r, tyre), (half, 0.215, rim), (half, 0.0, rim)];
    let profile = if level == LampLevel::Far { &flat[..] } else { &profile };
    for pair in profile.windows(2) {
        for k in 0..sides {
            let at = |(y, radius, _): (f32, f32, SurfaceFinish), k: usize| {
                around(radius, (k % sides) as f32 / sides as f32, y)
            };
            triangles.quad([at(pair[0], k), at(pair[0], k + 1), at(pair[1], k + 1), at(pair[1], k)], pair[0].2);
        }
    }
    if level == LampLevel::Far {
        return triangles.into_mesh(40f32.to_radians());
    }
    for k in 0..SPOKES {
        let turn = k as f32 / SPOKES as f32;
        if level == LampLevel::Near {
            // Each spoke is forked.
            [-0.026, 0.026].into_iter().for_each(|aside| spoke(&mut triangles, turn + aside, 0.55, alloy));
        } else {
            spoke(&mut triangles, turn, 1.0, alloy);
        }
    }
    if level == LampLevel::Near {
        // Brake disc behind the spokes, bolts in front.
        let disc = SurfaceFinish::grey(Material::Metal, 0.30);
        triangles.ellipsoid(Vec3::new(0.0, half - 0.072, 0.0), Vec3::new(0.15, 0.012, 0.15), [4, 24], |_| disc);
        for k in 0..5 {
            let at = around(0.036, (k as f32 + 0.5) / 5.0, half - 0.020);
            triangles.ellipsoid(at, Vec3::new(0.007, 0.006, 0.007), [3, 5], |_| well);
        }
    }
    // The cap in the middle.
    triangles.ellipsoid(Vec3::new(0.0, half - 0.04, 0.0), Vec3::new(0.055, 0.022, 0.055), [4, 10], |_| alloy);
    triangles.into_mesh(40f32.to_radians())
}

/// Returns a point at `radius` and `turn` around the axle (1 is one revolution, positive rolls forwards).
fn around(radius: f32, turn: f32, y: f32) -> Vec3 {
    let (sin, cos) = (turn * TAU).sin_cos();
    Vec3::new(radius * sin, y, radius * cos)
}

/// Adds a tapered bar from the cap to the rim, its face slightly domed outwards.
fn spoke(triangles: &mut TriangleList, turn: f32, width: f32, finish: SurfaceFinish) {
    let half = WHEEL_WIDTH_M / 2.0;
    // Half widths in turns: 34 mm at the cap, 22 mm at the rim.
    let ring = |radius: f32, half_width_m: f32, y_face: f32| {
        let w = width * half_width_m / (TAU * radius);
        [
            around(radius, turn - w, y_face - 0.03),
            around(radius, turn + w, y_face - 0.03),
            around(radius, turn + w * 0.8, y_face),
            around(radius, turn - w * 0.8, y_face),
        ]
    };
    let inner = ring(0.035, 0.030, half - 0.030);
    let outer = ring(0.207, 0.023, half - 0.020);
    for k in 0..4 {
        let next = (k + 1) % 4;
        triangles.quad([inner[k], outer[k], outer[next], inner[next]], finish);
    }
    triangles.quad([inner[0], inner[1], inner[2], inner[3]], finish);
    triangles.quad([outer[3], outer[2], outer[1], outer[0]], finish);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::mesh::tests::{check, has_coat, open_edges, volume_m3, worst_agreement};

    #[test]
    fn the_wheel_is_closed_round_and_has_the_radius_of_its_hubs_height() {
        for (wheel, most) in wheels().iter().zip([1800, 700, 100]) {
            check(wheel, "wheel");
            assert!(!has_coat(wheel), "drawn without");
            assert_eq!(open_edges(wheel), 0);
            assert!(worst_agreement(wheel) > 0.6, "{}", worst_agreement(wheel));
            let (low, high) = wheel.bounds();
            assert!((high.z - WHEEL_RADIUS_M).abs() < 1e-4 && (low.z + WHEEL_RADIUS_M).abs() < 1e-4, "{low} {high}");
            assert!((high.y - low.y - WHEEL_WIDTH_M).abs() < 1e-4);
            // A full cylinder would be 0.075 m3.
            assert!((0.05..0.076).contains(&volume_m3(wheel)), "{}", volume_m3(wheel));
            assert!(wheel.triangles() < most, "{}", wheel.triangles());
        }
    }
}
