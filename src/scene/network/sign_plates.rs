//! Plates of road signs. In: kind and size of a sign. Out: a plate around its middle, metres. Signs and their sizes are German
//! (`docs/references.md: roads`).

use super::{
    signals::STEEL,
    signs::{MOTORWAY_MPS, SignKind},
};
use crate::{
    hud::lettering,
    scene::{
        Material,
        car::number_plate::thinned,
        mesh::{SurfaceFinish, TriangleList},
    },
};
use glam::{Vec2, Vec3};
use std::f32::consts::{PI, SQRT_2, TAU};

/// Distance between plate and lettering, metres: at 80 m the depth buffer still tells them apart.
const RAISED_M: f32 = 0.015;
/// Tolerance for omitted points of letters, as a share of their height.
const COARSE: f32 = 0.02;

const RED: SurfaceFinish = SurfaceFinish::new(Material::Reflector, [0.42, 0.012, 0.012]);
const WHITE: SurfaceFinish = SurfaceFinish::grey(Material::Reflector, 0.72);
const YELLOW: SurfaceFinish = SurfaceFinish::new(Material::Reflector, [0.72, 0.42, 0.01]);
const BLUE: SurfaceFinish = SurfaceFinish::new(Material::Reflector, [0.012, 0.07, 0.33]);
const BLACK: SurfaceFinish = SurfaceFinish::grey(Material::Matt, 0.012);

/// Returns true for the larger signs of fast roads: discs above 80 km/h, triangles and squares above 100 km/h, with a margin for rounding.
pub(super) fn is_large(kind: SignKind, limit_mps: f64) -> bool {
    match kind {
        SignKind::Stop | SignKind::Exit | SignKind::ExitAhead(_) => false,
        SignKind::SpeedLimit(_) => limit_mps > 22.5,
        SignKind::Yield | SignKind::Zebra | SignKind::Priority => limit_mps > MOTORWAY_MPS,
    }
}

/// Returns the size of a sign: the diameter of discs and octagons, the side of triangles and squares, the height of beacons, metres.
pub(super) fn size_m(kind: SignKind, is_large: bool) -> f32 {
    match (kind, is_large) {
        (SignKind::Stop, _) | (SignKind::Yield, false) => 0.9,
        (SignKind::Exit, _) => 1.6,
        (SignKind::ExitAhead(_), _) => 1.5,
        (SignKind::Yield, true) => 1.26,
        (SignKind::Zebra | SignKind::Priority, true) => 0.84,
        (SignKind::SpeedLimit(_), true) => 0.75,
        (SignKind::Zebra | SignKind::Priority | SignKind::SpeedLimit(_), false) => 0.6,
    }
}

/// Returns a plate around its middle that faces along +x, and half its height, metres. Seen from before it, +y is to the right.
pub(super) fn plate(kind: SignKind, size_m: f32) -> (TriangleList, f32) {
    let mut plate = Plate::default();
    let round = |radius_m: f32, corners: usize, turn: f32| -> Vec<Vec2> {
        let angle = |k: usize| TAU * (k as f32 + turn) / corners as f32;
        (0..corners).map(|k| Vec2::from_angle(angle(k)) * radius_m).collect()
    };
    let half_m = size_m / 2.0;
    let half_height_m = match kind {
        SignKind::Stop => {
            // The diameter is that between two parallel sides.
            let corner_m = half_m / (PI / 8.0).cos();
            let [outer, inner] = [corner_m, corner_m * 0.94].map(|radius_m| round(radius_m, 8, 0.5));
            plate.frame(&outer, &inner, WHITE);
            plate.area(&inner, RED);
            plate.text("STOP", size_m * 0.27, WHITE);
            half_m
        }
        SignKind::Yield => {
            // An equilateral triangle with its tip down; its corners are cut.
            let height_m = size_m * 0.75f32.sqrt();
            let triangle = |share: f32| {
                let corners =
                    [(-0.5, 1.0), (0.0, -2.0), (0.5, 1.0)].map(|(y, z)| Vec2::new(y * size_m, z * height_m / 3.0));
                let cut = |k: usize, to: usize| corners[k].lerp(corners[to], 0.05) * share;
                [cut(0, 2), cut(0, 1), cut(1, 0), cut(1, 2), cut(2, 1), cut(2, 0)].to_vec()
            };
            let [outer, inner] = [triangle(1.0), triangle(0.64)];
            plate.frame(&outer, &inner, RED);
            plate.area(&inner, WHITE);
            height_m * 2.0 / 3.0
        }
        SignKind::Priority => {
            let corner_m = size_m * 0.5f32.sqrt();
            let [outer, inner] = [corner_m, corner_m * 0.72].map(|radius_m| round(radius_m, 4, 0.0));
            plate.frame(&outer, &inner, WHITE);
            plate.area(&inner, YELLOW);
            corner_m
        }
        SignKind::Zebra => {
            let [outer, inner] = [1.0, 0.94].map(|share| round(half_m * share * SQRT_2, 4, 0.5));
            plate.frame(&outer, &inner, WHITE);
            plate.area(&inner, BLUE);
            let triangle = [(0.0, 0.76), (-0.8, -0.66), (0.8, -0.66)].map(|(y, z)| Vec2::new(y, z) * half_m);
            plate.raised_area(&triangle, RAISED_M, WHITE);
            plate.walker(half_m);
            half_m
        }
        SignKind::Exit => {
            let [outer, inner] = [1.0, 0.94].map(|share| round(half_m * share * SQRT_2, 4, 0.5));
            plate.frame(&outer, &inner, WHITE);
            plate.area(&inner, BLUE);
            plate.exit_arrow(half_m);
            half_m
        }
        SignKind::ExitAhead(bars) => {
            let board = |share: f32| {
                let half = Vec2::new(0.3, 1.0) * half_m - (1.0 - share) * 0.3 * half_m;
                [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(y, z)| Vec2::new(y, z) * half).to_vec()
            };
            let [outer, inner] = [board(1.0), board(0.86)];
            plate.frame(&outer, &inner, WHITE);
            plate.area(&inner, BLUE);
            for bar in 0..bars {
                // The bars rise to the right, towards the exit.
                let z = (bar as f32 - (bars as f32 - 1.0) / 2.0) * 0.5 * half_m;
                let [from, to] = [(-0.22, -0.13), (0.22, 0.13)].map(|(y, up)| Vec2::new(y * half_m, z + up * half_m));
                plate.stroke([from, to], 0.075 * half_m, WHITE);
            }
            half_m
        }
        SignKind::SpeedLimit(kmh) => {
            let [outer, inner] = [half_m, half_m * 0.78].map(|radius_m| round(radius_m, 24, 0.0));
            plate.frame(&outer, &inner, RED);
            plate.area(&inner, WHITE);
            let height = if kmh < 100 { 0.42 } else { 0.32 };
            plate.text(&kmh.to_string(), size_m * height, BLACK);
            half_m
        }
    };
    (plate.triangles, half_height_m)
}

/// Builder of a plate that faces along +x. Outlines are counter-clockwise, seen from before the plate.
#[derive(Default)]
struct Plate {
    triangles: TriangleList,
}

impl Plate {
    /// Adds a convex area.
    fn area(&mut self, outline: &[Vec2], finish: SurfaceFinish) {
        self.raised_area(outline, 0.0, finish);
    }

    /// Adds a convex area, `off_m` before the plate.
    fn raised_area(&mut self, outline: &[Vec2], off_m: f32, finish: SurfaceFinish) {
        for k in 1..outline.len() - 1 {
            self.triangles.triangle([outline[0], outline[k], outline[k + 1]].map(|p| on(p, off_m)), finish);
        }
    }

    /// Adds a walking person over the bars of a crossing, within `half_m` of the middle.
    fn walker(&mut self, half_m: f32) {
        // Strokes as right, up, right, up and half the width, in shares of half the plate: trunk, arms, legs, bars.
        let strokes = [
            [0.01, 0.22, -0.02, -0.10, 0.075],
            [0.01, 0.20, -0.15, 0.02, 0.030],
            [0.01, 0.20, 0.16, 0.04, 0.030],
            [-0.02, -0.10, -0.16, -0.46, 0.045],
            [-0.02, -0.10, 0.14, -0.46, 0.045],
            [-0.52, -0.56, -0.34, -0.56, 0.045],
            [-0.09, -0.56, 0.09, -0.56, 0.045],
            [0.34, -0.56, 0.52, -0.56, 0.045],
        ];
        for [from_y, from_z, to_y, to_z, half] in strokes {
            self.stroke([Vec2::new(from_y, from_z), Vec2::new(to_y, to_z)].map(|p| p * half_m), half * half_m, BLACK);
        }
        let head = |k: u8| Vec2::from_angle(TAU * f32::from(k) / 8.0) * 0.085 + Vec2::new(0.02, 0.38);
        let head: Vec<Vec2> = (0..8).map(|k| head(k) * half_m).collect();
        self.raised_area(&head, 2.0 * RAISED_M, BLACK);
    }

    /// Adds an arrow that rises to the right, within `half_m` of the middle.
    fn exit_arrow(&mut self, half_m: f32) {
        let at = |y: f32, z: f32| Vec2::new(y, z) * half_m;
        self.stroke([at(-0.5, -0.5), at(0.2, 0.2)], 0.1 * half_m, WHITE);
        let head = [at(0.55, 0.55), at(-0.02, 0.38), at(0.38, -0.02)];
        self.raised_area(&head, 2.0 * RAISED_M, WHITE);
    }

    /// Adds a bar between two points before the plate.
    fn stroke(&mut self, [from, to]: [Vec2; 2], half_m: f32, finish: SurfaceFinish) {
        let along = (to - from).normalize_or_zero() * half_m * 0.5;
        let across = along.perp() * 2.0;
        let corners = [from - along - across, to + along - across, to + along + across, from - along + across];
        self.raised_area(&corners, 2.0 * RAISED_M, finish);
    }

    /// Adds the frame between two outlines with equally many corners, and the grey back of the plate.
    fn frame(&mut self, outer: &[Vec2], inner: &[Vec2], finish: SurfaceFinish) {
        let n = outer.len();
        for k in 0..n {
            let next = (k + 1) % n;
            self.triangles.quad([outer[k], outer[next], inner[next], inner[k]].map(|p| on(p, 0.0)), finish);
            let behind = [outer[next], outer[k], Vec2::ZERO].map(|p| on(p, -0.01));
            self.triangles.triangle(behind, STEEL);
        }
    }

    /// Adds a line of text around the middle, `height_m` high.
    fn text(&mut self, text: &str, height_m: f32, finish: SurfaceFinish) {
        let half_m = lettering::PEN / 2.0 * height_m;
        for stroke in lettering::set(text).strokes {
            let points: Vec<Vec2> =
                stroke.into_iter().map(|[right, down]| Vec2::new(right, -down) * height_m).collect();
            for pair in thinned(&points, COARSE * height_m).windows(2) {
                self.stroke([pair[0], pair[1]], half_m, finish);
            }
        }
    }
}

/// Returns a point of a plate, `off_m` before it.
fn on(point: Vec2, off_m: f32) -> Vec3 {
    Vec3::new(off_m, point.x, point.y)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::mesh::tests::faces;

    #[test]
    fn a_plate_shows_its_colours_to_the_front_alone() {
        let kinds = [
            SignKind::Stop,
            SignKind::Yield,
            SignKind::Zebra,
            SignKind::Priority,
            SignKind::SpeedLimit(80),
            SignKind::Exit,
            SignKind::ExitAhead(3),
        ];
        for kind in kinds {
            let (plate, half_height_m) = plate(kind, 0.6);
            for (corners, face) in faces(&plate.into_mesh(0.3)) {
                let is_back = corners[0].colour == STEEL.colour;
                assert_eq!(face.x > 0.0, !is_back, "{kind:?}: {corners:?}");
                assert!(corners.iter().all(|corner| corner.position[2] >= -half_height_m - 1e-4), "{kind:?}");
            }
        }
    }
}
