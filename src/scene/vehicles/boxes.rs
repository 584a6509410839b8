//! Vehicles with flat sides, and parts of articulated ones: van, lorry, tractor, semi-trailer, bus, and the two parts of a long bus. Out:
//! models at their usual sizes, metres; see the parent module. A part is as long as from its bumper to its joint; its model may reach
//! beyond the joint.

use super::model::{Model, Shape, block};
use crate::scene::{
    Material,
    car::materials::{BRAKE, DARK, GLASS, PAINT, TRIM},
    mesh::{SurfaceFinish, TriangleList},
};
use glam::{Vec2, Vec3, vec2};
use std::f32::consts::TAU;

// Sizes of SUMO's `delivery`, a rigid lorry, the parts of SUMO's `trailer`, SUMO's `bus`, and the parts of a bus of 18 m.

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
/// The joint is the kingpin, half a metre ahead of the driven axle.
pub(super) const TRACTOR: Shape = Shape {
    size: Vec3::new(4.65, 2.55, 4.0),
    axles: [0.925, -2.825],
    track_half: 1.135,
    wheel: [0.50, 0.30],
    indicators: [Vec3::new(2.345, 1.10, 0.80), Vec3::new(-3.625, 1.0, 0.95)],
    indicator_radius: 0.07,
};
/// The axles are the first and the last of three.
pub(super) const SEMI_TRAILER: Shape = Shape {
    size: Vec3::new(11.85, 2.55, 4.0),
    axles: [-1.275, -3.915],
    track_half: 1.135,
    wheel: [0.50, 0.30],
    indicators: [Vec3::new(7.675, 1.10, 0.80), Vec3::new(-5.945, 1.08, 0.95)],
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

pub(super) const BUS_FRONT: Shape = Shape {
    size: Vec3::new(10.08, 2.5, 3.4),
    axles: [2.39, -3.31],
    track_half: 1.11,
    wheel: [0.48, 0.30],
    indicators: [Vec3::new(5.06, 1.08, 0.85), Vec3::new(-4.5, 1.12, 1.20)],
    indicator_radius: 0.07,
};
/// The part has one axle.
pub(super) const BUS_REAR: Shape = Shape {
    size: Vec3::new(7.92, 2.5, 3.4),
    axles: [-0.56, -0.56],
    track_half: 1.11,
    wheel: [0.48, 0.30],
    indicators: [Vec3::new(3.5, 1.08, 0.85), Vec3::new(-3.98, 1.12, 1.20)],
    indicator_radius: 0.07,
};

const PANEL: SurfaceFinish = SurfaceFinish::grey(Material::Matt, 0.52);
const LIGHT: SurfaceFinish = SurfaceFinish::new(Material::HeadLamp, [0.85, 1.0, 1.0]);
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

/// Adds the pair of brake lamps at a rear.
fn brake_lamps(triangles: &mut TriangleList, rear: f32, half: f32, z: f32) {
    for side in [-1.0f32, 1.0] {
        let (from, to) = if side > 0.0 { (half - 0.34, half - 0.10) } else { (0.10 - half, 0.34 - half) };
        block(triangles, [rear - 0.02, from, z - 0.13], [rear + 0.04, to, z + 0.13], BRAKE);
    }
}

/// Adds the pair of head lamps at a front.
fn head_lamps(triangles: &mut TriangleList, front: f32, half: f32, z: f32) {
    for side in [-1.0f32, 1.0] {
        let (from, to) = if side > 0.0 { (half - 0.52, half - 0.12) } else { (0.12 - half, 0.52 - half) };
        block(triangles, [front - 0.04, from, z - 0.11], [front + 0.015, to, z + 0.11], LIGHT);
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
    brake_lamps(&mut triangles, -3.24, half, 1.02);
    head_lamps(&mut triangles, 3.19, half, 0.90);
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
    brake_lamps(&mut triangles, -4.48, 1.22, 0.90);
    head_lamps(&mut triangles, 4.48, 1.22, 0.78);
    plate(&mut triangles, -4.486, 0.64);
    Model { triangles, shape: LORRY }
}

pub(super) fn tractor() -> Model {
    let mut triangles = TriangleList::default();
    cab(&mut triangles, 2.325, 1.25, 3.75);
    block(&mut triangles, [-3.625, -0.45, 0.72], [0.475, 0.45, 1.0], DARK);
    arch(&mut triangles, TRACTOR.axles[0], TRACTOR.wheel[0], 1.25);
    head_lamps(&mut triangles, 2.305, 1.24, 0.78);
    Model { triangles, shape: TRACTOR }
}

pub(super) fn semi_trailer() -> Model {
    let mut triangles = TriangleList::default();
    frame(&mut triangles, -5.895, 4.925);
    load(&mut triangles, [-5.905, 7.675], 1.275, [1.15, 4.0]);
    guards(&mut triangles, -0.575, 4.225, 1.20);
    fixed_wheels(&mut triangles, -2.595, 0.50, 1.10);
    brake_lamps(&mut triangles, -5.905, 1.24, 0.92);
    plate(&mut triangles, -5.911, 0.66);
    Model { triangles, shape: SEMI_TRAILER }
}

/// Half of a bus's width, metres.
const BUS_HALF_M: f32 = 1.25;

/// Adds the front of a bus with its bumper at `front`: windscreen, line sign, door panes, head lamps and mirrors.
fn bus_nose(triangles: &mut TriangleList, front: f32) {
    let half = BUS_HALF_M;
    let at = |x: f32, z: f32| vec2(front + x, z);
    across(triangles, at(-0.025, 1.20), at(-0.165, 2.85), half - 0.06, GLASS, 1.0);
    // A line sign over both windscreens.
    across(triangles, at(-0.20, 3.03), at(-0.36, 3.26), half - 0.3, DARK, 1.0);
    on_sides(triangles, &[at(-0.74, 1.20), at(-0.22, 1.20), at(-0.34, 2.75), at(-0.74, 2.75)], half, GLASS);
    head_lamps(triangles, front - 0.015, half, 0.70);
    mirrors(triangles, front - 0.25, half + 0.02, 2.45);
}

/// Adds the rear of a bus with its wall at `rear`: pane, brake lamps and number plate.
fn bus_tail(triangles: &mut TriangleList, rear: f32) {
    across(triangles, vec2(rear, 1.75), vec2(rear, 2.75), BUS_HALF_M - 0.18, GLASS, -1.0);
    brake_lamps(triangles, rear, BUS_HALF_M, 0.95);
    plate(triangles, rear + 0.002, 0.60);
}

/// Adds windows between pillars on both sides, the hindmost at `rear`.
fn bus_windows(triangles: &mut TriangleList, rear: f32, count: usize) {
    for k in 0..count {
        let rear = rear + 1.37 * k as f32;
        let corners = [vec2(rear, 1.35), vec2(rear + 1.29, 1.35), vec2(rear + 1.29, 2.85), vec2(rear, 2.85)];
        on_sides(triangles, &corners, BUS_HALF_M, GLASS);
    }
}

/// Adds the shell of a bus between the wall at `rear` and the bumper at `front`, with a dark sill and arches over these axles.
fn bus_shell(triangles: &mut TriangleList, [rear, front]: [f32; 2], axles: &[f32]) {
    let outline = [
        vec2(rear, 0.36),
        vec2(front - 0.05, 0.34),
        vec2(front, 0.75),
        vec2(front - 0.03, 1.25),
        vec2(front - 0.18, 3.0),
        vec2(front - 0.4, 3.32),
        vec2(front - 0.8, 3.40),
        vec2(rear + 0.29, 3.40),
        vec2(rear, 3.2),
    ];
    let half = BUS_HALF_M;
    body(triangles, &outline, vec2((rear + front) / 2.0, 1.5), half, PAINT);
    block(triangles, [rear + 0.09, -half + 0.06, 0.26], [front - 0.2, half - 0.06, 0.40], DARK);
    for axle in axles {
        arch(triangles, *axle, BUS.wheel[0], half);
    }
}

/// Adds half of the bellows between the parts of a bus.
fn bellows(triangles: &mut TriangleList, [rear, front]: [f32; 2]) {
    let half = BUS_HALF_M - 0.10;
    block(triangles, [rear, -half, 0.42], [front, half, 3.25], TRIM);
}

pub(super) fn bus() -> Model {
    let mut triangles = TriangleList::default();
    bus_shell(&mut triangles, [-5.99, 6.0], &BUS.axles);
    bus_windows(&mut triangles, -5.72, 8);
    bus_nose(&mut triangles, 6.0);
    bus_tail(&mut triangles, -5.99);
    Model { triangles, shape: BUS }
}

pub(super) fn bus_front() -> Model {
    let mut triangles = TriangleList::default();
    bus_shell(&mut triangles, [-4.5, 5.04], &BUS_FRONT.axles);
    bus_windows(&mut triangles, -4.2, 6);
    bus_nose(&mut triangles, 5.04);
    bellows(&mut triangles, [-5.35, -4.5]);
    Model { triangles, shape: BUS_FRONT }
}

pub(super) fn bus_rear() -> Model {
    let mut triangles = TriangleList::default();
    bus_shell(&mut triangles, [-3.95, 3.5], &BUS_REAR.axles[..1]);
    bus_windows(&mut triangles, -3.65, 4);
    bus_tail(&mut triangles, -3.95);
    bellows(&mut triangles, [3.5, 4.2]);
    Model { triangles, shape: BUS_REAR }
}
