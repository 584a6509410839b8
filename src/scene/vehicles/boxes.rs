//! Vehicles with flat sides: van, lorry, articulated lorry and bus. Out: models at their usual sizes, metres; see the parent
//! module.

use super::model::{Model, Shape, block};
use crate::scene::{
    Material,
    car::materials::{BRAKE, DARK, GLASS, PAINT, TRIM},
    mesh::{SurfaceFinish, TriangleList},
};
use glam::{Vec2, Vec3, vec2};
use std::f32::consts::TAU;

/// Sizes of SUMO's `delivery`, a rigid lorry, SUMO's `trailer`, and SUMO's `bus`.
pub(super) const VAN: Shape = Shape {
    size: Vec3::new(6.5, 2.16, 2.86),
    axles: [2.12, -1.75],
    track_half: 0.97,
    wheel: [0.36, 0.24],
    indicators: [Vec3::new(3.16, 0.92, 0.86), Vec3::new(-3.27, 1.0, 1.30)],
    indicator_radius: 0.06,
};
pub(super) const LORRY: Shape = Shape {
    size: Vec3::new(9.0, 2.5, 3.6),
    axles: [3.05, -2.35],
    track_half: 1.11,
    wheel: [0.50, 0.30],
    indicators: [Vec3::new(4.52, 1.08, 0.80), Vec3::new(-4.52, 1.06, 0.92)],
    indicator_radius: 0.07,
};
pub(super) const ARTICULATED: Shape = Shape {
    size: Vec3::new(16.5, 2.55, 4.0),
    axles: [6.85, 3.10],
    track_half: 1.135,
    wheel: [0.50, 0.30],
    indicators: [Vec3::new(8.27, 1.10, 0.80), Vec3::new(-8.27, 1.08, 0.95)],
    indicator_radius: 0.07,
};
pub(super) const BUS: Shape = Shape {
    size: Vec3::new(12.0, 2.5, 3.4),
    axles: [3.35, -2.55],
    track_half: 1.11,
    wheel: [0.48, 0.30],
    indicators: [Vec3::new(6.02, 1.08, 0.85), Vec3::new(-6.02, 1.12, 1.20)],
    indicator_radius: 0.07,
};

const PANEL: SurfaceFinish = SurfaceFinish::grey(Material::Matt, 0.52);
const LIGHT: SurfaceFinish = SurfaceFinish::grey(Material::Lamp, 0.85);
const TYRE: SurfaceFinish = SurfaceFinish::grey(Material::Tyre, 0.022);
/// Distance by which flat parts stand out from a side, metres.
const PROUD_M: f32 = 0.012;

/// Adds a body whose side outline is the same across its width: corners (x, z) counter-clockwise seen from the right, and a point
/// `middle` from which all of them are visible.
fn body(triangles: &mut TriangleList, outline: &[Vec2], middle: Vec2, half: f32, finish: SurfaceFinish) {
    let at = |p: Vec2, y: f32| Vec3::new(p.x, y, p.y);
    for k in 0..outline.len() {
        let (a, b) = (outline[k], outline[(k + 1) % outline.len()]);
        triangles.quad([at(a, half), at(b, half), at(b, -half), at(a, -half)], finish);
        triangles.triangle([at(middle, -half), at(a, -half), at(b, -half)], finish);
        triangles.triangle([at(middle, half), at(b, half), at(a, half)], finish);
    }
}

/// Adds a pane or another flat part on both sides: corners (x, z) counter-clockwise seen from the right, convex.
fn on_sides(triangles: &mut TriangleList, outline: &[Vec2], half: f32, finish: SurfaceFinish) {
    let y = half + PROUD_M;
    for k in 1..outline.len() - 1 {
        let [a, b, c] = [outline[0], outline[k], outline[k + 1]];
        triangles.triangle([a, b, c].map(|p| Vec3::new(p.x, -y, p.y)), finish);
        triangles.triangle([a, c, b].map(|p| Vec3::new(p.x, y, p.y)), finish);
    }
}

/// Adds a pane across the front or the rear, between two heights of a slope; the sign of `out` is the direction it faces along x.
fn across(triangles: &mut TriangleList, low: Vec2, high: Vec2, half: f32, finish: SurfaceFinish, out: f32) {
    let slope = high - low;
    let proud = vec2(slope.y, -slope.x).normalize_or_zero() * out.signum() * PROUD_M;
    let [low, high] = [low + proud * out.abs(), high + proud * out.abs()];
    let at = |p: Vec2, y: f32| Vec3::new(p.x, y, p.y);
    let corners = [at(low, -half), at(low, half), at(high, half), at(high, -half)];
    triangles.quad(if out > 0.0 { corners } else { [corners[1], corners[0], corners[3], corners[2]] }, finish);
}

/// Adds the dark recess behind a wheel.
fn arch(triangles: &mut TriangleList, axle: f32, radius: f32, half: f32) {
    let rim = |k: usize| {
        let (sin, cos) = (TAU / 2.0 * k as f32 / 12.0).sin_cos();
        vec2(axle + (radius + 0.09) * cos, radius + (radius + 0.09) * sin - 0.02)
    };
    let mut outline: Vec<Vec2> = (0..=12).map(rim).collect();
    outline.push(vec2(axle - radius - 0.09, 0.30));
    outline.push(vec2(axle + radius + 0.09, 0.30));
    on_sides(triangles, &outline, half - PROUD_M * 0.5, DARK);
}

/// Adds a pair of wheels that are part of the body, for axles beyond the second.
fn fixed_wheels(triangles: &mut TriangleList, axle: f32, radius: f32, half: f32) {
    for side in [-1.0f32, 1.0] {
        let ring = |k: usize| {
            let y = side * half - 0.15 + 0.30 * k as f32;
            (0..18)
                .map(|i| {
                    let (sin, cos) = (TAU * i as f32 / 18.0).sin_cos();
                    Vec3::new(axle + radius * cos, y, radius + radius * sin)
                })
                .collect()
        };
        triangles.bar(2, ring, TYRE);
        triangles.ellipsoid(
            Vec3::new(axle, side * (half + 0.145), radius),
            Vec3::new(radius * 0.55, 0.02, radius * 0.55),
            [4, 12],
            |_| SurfaceFinish::grey(Material::Matt, 0.20),
        );
    }
}

/// Adds pairs of lamps: brake lamps behind, head lamps in front.
fn lamps(triangles: &mut TriangleList, [rear, front]: [f32; 2], half: f32, [rear_z, front_z]: [f32; 2]) {
    for side in [-1.0f32, 1.0] {
        let span = |inner: f32, outer: f32| if side > 0.0 { (inner, outer) } else { (-outer, -inner) };
        let (from, to) = span(half - 0.34, half - 0.10);
        block(triangles, [rear - 0.02, from, rear_z - 0.13], [rear + 0.04, to, rear_z + 0.13], BRAKE);
        let (from, to) = span(half - 0.52, half - 0.12);
        block(triangles, [front - 0.04, from, front_z - 0.11], [front + 0.015, to, front_z + 0.11], LIGHT);
    }
}

/// Adds mirrors on arms beside the windscreen.
fn mirrors(triangles: &mut TriangleList, x: f32, half: f32, z: f32) {
    for side in [-1.0f32, 1.0] {
        let (from, to) = if side > 0.0 { (half - 0.12, half - 0.01) } else { (0.01 - half, 0.12 - half) };
        block(triangles, [x, from, z - 0.28], [x + 0.10, to, z + 0.28], TRIM);
    }
}

fn plate(triangles: &mut TriangleList, x: f32, z: f32) {
    block(
        triangles,
        [x - 0.012, -0.26, z - 0.055],
        [x + 0.012, 0.26, z + 0.055],
        SurfaceFinish::grey(Material::Matt, 0.6),
    );
}

pub(super) fn van() -> Model {
    let mut triangles = TriangleList::default();
    let half = 1.06;
    let outline = [
        vec2(-3.24, 0.42),
        vec2(3.15, 0.42),
        vec2(3.22, 0.62),
        vec2(3.15, 1.15),
        vec2(2.30, 1.42),
        vec2(1.62, 2.52),
        vec2(1.25, 2.80),
        vec2(0.9, 2.86),
        vec2(-3.10, 2.86),
        vec2(-3.24, 2.72),
    ];
    body(&mut triangles, &outline, vec2(0.3, 1.2), half, PAINT);
    // Bumpers and sills.
    block(&mut triangles, [3.05, -half, 0.30], [3.25, half, 0.62], TRIM);
    block(&mut triangles, [-3.25, -half, 0.34], [-3.12, half, 0.60], TRIM);
    block(&mut triangles, [-3.1, -half + 0.08, 0.26], [3.0, half - 0.08, 0.46], DARK);
    across(&mut triangles, vec2(2.24, 1.52), vec2(1.68, 2.42), half - 0.12, GLASS, 1.0);
    on_sides(&mut triangles, &[vec2(0.75, 1.48), vec2(2.02, 1.48), vec2(1.52, 2.30), vec2(0.75, 2.30)], half, GLASS);
    for side in [-1.0f32, 1.0] {
        let pane = [vec2(-3.24, 1.62), vec2(-3.24, 2.42)];
        let at = |p: Vec2, y: f32| Vec3::new(p.x - PROUD_M, y, p.y);
        let (from, to) = if side > 0.0 { (0.10, 0.88) } else { (-0.88, -0.10) };
        triangles.quad([at(pane[0], to), at(pane[0], from), at(pane[1], from), at(pane[1], to)], GLASS);
    }
    for axle in VAN.axles {
        arch(&mut triangles, axle, VAN.wheel[0], half);
    }
    lamps(&mut triangles, [-3.24, 3.19], half, [1.02, 0.90]);
    block(&mut triangles, [3.15, -0.45, 0.72], [3.225, 0.45, 0.94], DARK);
    mirrors(&mut triangles, 1.95, half + 0.03, 1.62);
    plate(&mut triangles, -3.235, 0.80);
    plate(&mut triangles, 3.236, 0.50);
    Model { triangles, shape: VAN }
}

/// Adds a cab over the engine, with its front at `front`, 2.2 m long.
fn cab(triangles: &mut TriangleList, front: f32, half: f32, top: f32) {
    let rear = front - 2.2;
    let outline = [
        vec2(rear, 0.55),
        vec2(front - 0.03, 0.45),
        vec2(front, 1.30),
        vec2(front - 0.06, 1.60),
        vec2(front - 0.30, top - 0.18),
        vec2(front - 0.55, top),
        vec2(rear, top),
    ];
    body(triangles, &outline, vec2(front - 1.0, 1.2), half, PAINT);
    let glass_top = (top - 0.35).min(2.75);
    let slope = |z: f32| front - 0.06 - 0.24 * (z - 1.60) / (top - 1.78);
    across(triangles, vec2(slope(1.68), 1.68), vec2(slope(glass_top), glass_top), half - 0.10, GLASS, 1.0);
    let side = [
        vec2(front - 1.30, 1.62),
        vec2(front - 0.22, 1.62),
        vec2(front - 0.42, glass_top),
        vec2(front - 1.30, glass_top),
    ];
    on_sides(triangles, &side, half, GLASS);
    block(triangles, [front - 0.10, -half + 0.25, 0.95], [front + 0.004, half - 0.25, 1.35], DARK);
    block(triangles, [front - 0.25, -half, 0.35], [front + 0.0, half, 0.62], TRIM);
    mirrors(triangles, front - 0.30, half + 0.12, 0.55 * top + 0.30);
}

/// Adds a frame under the load area, with an underrun guard at the rear.
fn frame(triangles: &mut TriangleList, rear: f32, front: f32) {
    block(triangles, [rear, -0.45, 0.72], [front, 0.45, 1.02], DARK);
    block(triangles, [rear, -1.10, 0.48], [rear + 0.10, 1.10, 0.60], TRIM);
    block(triangles, [rear, -1.12, 0.72], [rear + 0.12, 1.12, 1.05], DARK);
}

/// Adds a cargo box with a dark frame round its doors.
fn load(triangles: &mut TriangleList, [rear, front]: [f32; 2], half: f32, [low, top]: [f32; 2]) {
    block(triangles, [rear, -half, low], [front, half, top], PANEL);
    for (from, to) in [(-half, -half + 0.07), (-0.03, 0.03), (half - 0.07, half)] {
        block(triangles, [rear - 0.006, from, low], [rear, to, top], TRIM);
    }
    for (from, to) in [(low, low + 0.08), (top - 0.08, top)] {
        block(triangles, [rear - 0.006, -half, from], [rear, half, to], TRIM);
    }
}

/// Adds side guards, which keep people from falling under the wheels.
fn guards(triangles: &mut TriangleList, from: f32, to: f32, half: f32) {
    for side in [-1.0f32, 1.0] {
        for z in [0.55, 0.82] {
            let (low, high) = if side > 0.0 { (half - 0.06, half) } else { (-half, 0.06 - half) };
            block(triangles, [from, low, z], [to, high, z + 0.12], SurfaceFinish::grey(Material::Matt, 0.25));
        }
    }
}

pub(super) fn lorry() -> Model {
    let mut triangles = TriangleList::default();
    cab(&mut triangles, 4.5, 1.22, 2.95);
    frame(&mut triangles, -4.47, 3.2);
    load(&mut triangles, [-4.48, 2.15], 1.25, [1.05, 3.6]);
    guards(&mut triangles, -1.65, 2.0, 1.18);
    arch(&mut triangles, LORRY.axles[0], LORRY.wheel[0], 1.22);
    lamps(&mut triangles, [-4.48, 4.48], 1.22, [0.90, 0.78]);
    plate(&mut triangles, -4.486, 0.64);
    Model { triangles, shape: LORRY }
}

pub(super) fn articulated() -> Model {
    let mut triangles = TriangleList::default();
    cab(&mut triangles, 8.25, 1.25, 3.75);
    block(&mut triangles, [2.3, -0.45, 0.72], [6.4, 0.45, 1.0], DARK);
    frame(&mut triangles, -8.22, 2.6);
    load(&mut triangles, [-8.23, 5.35], 1.275, [1.15, 4.0]);
    guards(&mut triangles, -2.9, 1.9, 1.20);
    for axle in [-3.6, -4.92, -6.24] {
        fixed_wheels(&mut triangles, axle, 0.50, 1.10);
    }
    arch(&mut triangles, ARTICULATED.axles[0], ARTICULATED.wheel[0], 1.25);
    lamps(&mut triangles, [-8.23, 8.23], 1.24, [0.92, 0.78]);
    plate(&mut triangles, -8.236, 0.66);
    Model { triangles, shape: ARTICULATED }
}

pub(super) fn bus() -> Model {
    let mut triangles = TriangleList::default();
    let half = 1.25;
    let outline = [
        vec2(-5.99, 0.36),
        vec2(5.95, 0.34),
        vec2(6.0, 0.75),
        vec2(5.97, 1.25),
        vec2(5.82, 3.0),
        vec2(5.6, 3.32),
        vec2(5.2, 3.40),
        vec2(-5.7, 3.40),
        vec2(-5.99, 3.2),
    ];
    body(&mut triangles, &outline, vec2(0.0, 1.5), half, PAINT);
    across(&mut triangles, vec2(5.975, 1.20), vec2(5.835, 2.85), half - 0.06, GLASS, 1.0);
    across(&mut triangles, vec2(-5.99, 1.75), vec2(-5.99, 2.75), half - 0.18, GLASS, -1.0);
    // A line sign over both windscreens.
    across(&mut triangles, vec2(5.80, 3.03), vec2(5.64, 3.26), half - 0.3, DARK, 1.0);
    // Windows between pillars.
    for k in 0..8 {
        let rear = -5.72 + 1.37 * k as f32;
        on_sides(
            &mut triangles,
            &[vec2(rear, 1.35), vec2(rear + 1.29, 1.35), vec2(rear + 1.29, 2.85), vec2(rear, 2.85)],
            half,
            GLASS,
        );
    }
    on_sides(&mut triangles, &[vec2(5.26, 1.20), vec2(5.78, 1.20), vec2(5.66, 2.75), vec2(5.26, 2.75)], half, GLASS);
    block(&mut triangles, [-5.9, -half + 0.06, 0.26], [5.8, half - 0.06, 0.40], DARK);
    for axle in BUS.axles {
        arch(&mut triangles, axle, BUS.wheel[0], half);
    }
    lamps(&mut triangles, [-5.99, 5.985], half, [0.95, 0.70]);
    mirrors(&mut triangles, 5.75, half + 0.02, 2.45);
    plate(&mut triangles, -5.988, 0.60);
    Model { triangles, shape: BUS }
}
