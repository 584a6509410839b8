//! Signal heads: three lamps in a vertical dark housing with a backboard. One head is on a pole beside the stop line, one over each further
//! lane on an arm, and one across the junction, visible to the first vehicle at the line. In: the network. Out: one mesh of poles, arms and
//! heads; the lamps' positions, with the link whose state each head shows. Sizes are from `docs/references.md: roads`.

use super::road_surfaces::RoadSurfaces;
use crate::{
    map::network::{
        Connection, EdgeId, LaneId, LanePosition, Network, SignalId, SignalLight, SignalStates, TurnDirection,
    },
    scene::{
        LitLamp, Material, Mesh,
        mesh::{SurfaceFinish, TriangleList},
    },
    space::Pose3,
};
use glam::{Mat3, Vec2, Vec3};
use std::f32::consts::TAU;

/// Radius of a lamp, metres.
pub(in crate::scene) const LAMP_M: f32 = 0.15;
/// Distance between the middles of two lamps in a housing, metres.
const LAMP_EVERY_M: f32 = 0.36;
/// Height of the middle lamp on a pole, beside the stop line or across the junction, metres.
const POLE_HEAD_M: f32 = 2.75;
/// Height of the middle lamp over a lane, metres.
const ARM_HEAD_M: f32 = 5.6;
/// Height of the arm above the middle lamps of its heads, metres.
const ARM_OVER_M: f32 = 0.85;
/// Distance between a pole and the edge of the outermost lane, metres: beyond the shoulder.
pub(super) const BESIDE_M: f64 = 0.95;
/// Distance between heads and the end of the lane, metres: at the far edge of the stop line.
const BEFORE_END_M: f64 = 0.15;
/// Maximum distance of a head across the junction from the stop line, metres.
const ACROSS_M: f32 = 45.0;

pub(super) const STEEL: SurfaceFinish = SurfaceFinish::grey(Material::Matt, 0.22);
const HOUSING: SurfaceFinish = SurfaceFinish::grey(Material::Matt, 0.012);
const RIM: SurfaceFinish = SurfaceFinish::grey(Material::Matt, 0.62);
/// Colours of unlit lamps, from the top: red, yellow, green; linear albedo.
const DARK: [[f32; 3]; 3] = [[0.075, 0.006, 0.004], [0.075, 0.035, 0.003], [0.004, 0.050, 0.028]];
/// Light of the lamps, from the top: red, yellow, green.
const LIT: [[f32; 3]; 3] = [[3.6, 0.030, 0.012], [3.2, 1.35, 0.02], [0.05, 2.6, 0.95]];

/// Signal head: the link whose state it shows, and the positions of its lamps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SignalHead {
    /// Lane for whose drivers the head is.
    pub lane: LaneId,
    /// Signal that controls the head.
    pub signal: SignalId,
    /// Index of the link whose state the head shows, among the signal's links.
    pub link: u32,
    /// Centre of the front of each lamp, world axes, metres: red, yellow, green.
    pub lamps: [Vec3; 3],
    /// Direction in which the lamps shine, a unit vector in world axes.
    pub facing: Vec3,
}

impl SignalHead {
    /// Returns the lit lamps. Blinking lamps are lit for the first half of each second of `time_s`.
    pub(in crate::scene) fn lit(&self, states: &SignalStates, time_s: f64) -> impl Iterator<Item = LitLamp> {
        let lit: &[usize] = match states.light(self.signal, self.link) {
            Some(SignalLight::Red) => &[0],
            Some(SignalLight::RedYellow) => &[0, 1],
            Some(SignalLight::Yellow) => &[1],
            Some(SignalLight::GreenMinor | SignalLight::GreenMajor | SignalLight::GreenArrow) => &[2],
            Some(SignalLight::OffBlinking) if time_s.rem_euclid(1.0) < 0.5 => &[1],
            Some(SignalLight::OffBlinking | SignalLight::Off) | None => &[],
        };
        let (lamps, facing) = (self.lamps, self.facing);
        lit.iter().map(move |&k| LitLamp { position: lamps[k], facing, radius_m: LAMP_M, light: LIT[k] })
    }
}

/// Returns the connection whose light represents a lane, with its signal and link index: straight on, or else slight turns, right, left.
fn shown(net: &Network, lane: LaneId) -> Option<(&Connection, SignalId, u32)> {
    let turn = |way: &Connection| match way.direction {
        TurnDirection::Straight => 0,
        TurnDirection::PartRight | TurnDirection::PartLeft => 1,
        TurnDirection::Right => 2,
        TurnDirection::Left => 3,
        _ => 4,
    };
    let ruled = net.connections_from(lane).iter().filter_map(|way| {
        let link = way.signal?;
        Some((way, link.signal, link.index?))
    });
    ruled.min_by_key(|(way, ..)| turn(way))
}

/// Returns the mesh of all signal heads, poles and arms, and the heads.
pub(in crate::scene) fn heads(net: &Network, surfaces: &RoadSurfaces) -> (Mesh, Vec<SignalHead>) {
    let mut triangles = TriangleList::default();
    let mut heads = Vec::new();
    for edge in net.edge_ids() {
        approach(net, edge, surfaces, &mut triangles, &mut heads);
    }
    (triangles.into_mesh(0.6), heads)
}

/// Adds the heads at the end of one edge.
fn approach(
    net: &Network,
    edge: EdgeId,
    surfaces: &RoadSurfaces,
    triangles: &mut TriangleList,
    heads: &mut Vec<SignalHead>,
) {
    let lanes: Vec<LaneId> = net.edge(edge).lanes().filter(|lane| net.is_driven(*lane)).collect();
    let ruled: Vec<_> = lanes.iter().filter_map(|&lane| Some((lane, shown(net, lane)?))).collect();
    let (Some(&outermost), false) = (lanes.first(), ruled.is_empty()) else { return };
    // The pole is on the right, or on the left with left-hand traffic.
    let side = if net.is_left_hand() { 1.0 } else { -1.0 };
    let at = |lane: LaneId, offset_m: f64| {
        let of = net.lane(lane);
        let s_m = of.length_m - (BEFORE_END_M + of.end_offset_m) * of.length_m / of.line.drawn_m().max(1.0);
        net.pose(LanePosition { lane, s_m, offset_m })
    };
    let beside = |lane: LaneId| side * (net.lane(lane).half_width_m() + BESIDE_M);
    let foot = at(outermost, beside(outermost));
    // Offset from heads to their poles and arms.
    let behind = direction(&at(outermost, 0.0)) * 0.22;
    let mut arm_end: Option<Vec3> = None;
    for (k, &(lane, (way, signal, link))) in ruled.iter().enumerate() {
        let over = at(lane, 0.0);
        let mut head = |middle: Vec3, triangles: &mut TriangleList| {
            let facing = -direction(&over);
            heads.push(SignalHead { lane, signal, link, lamps: housing(triangles, middle, facing), facing });
        };
        if k == 0 {
            head(foot.position.as_vec3() + Vec3::Z * POLE_HEAD_M, triangles);
            if let Some(foot) = across(net, way, &over, side, surfaces) {
                pole(triangles, foot + behind, POLE_HEAD_M + 0.7);
                head(foot + Vec3::Z * POLE_HEAD_M, triangles);
            }
        } else {
            let middle = over.position.as_vec3() + Vec3::Z * ARM_HEAD_M;
            head(middle, triangles);
            arm_end = Some(middle + Vec3::Z * ARM_OVER_M);
            bar(triangles, middle + behind, middle + behind + Vec3::Z * ARM_OVER_M, 0.03);
        }
    }
    let foot = foot.position.as_vec3();
    match arm_end {
        Some(end) => {
            pole(triangles, foot + behind, end.z - foot.z + 0.15);
            bar(triangles, (foot + behind).with_z(end.z), end + behind, 0.07);
        }
        None => pole(triangles, foot + behind, POLE_HEAD_M + 0.7),
    }
}

/// Returns the foot of the head across the junction: beside the exit lane if the way is straight on, else beyond the road ahead. `None` if
/// there is no free place in range.
fn across(net: &Network, way: &Connection, line: &Pose3, side: f64, surfaces: &RoadSurfaces) -> Option<Vec3> {
    let (from, ahead) = (line.position.as_vec3(), direction(line));
    let near = |foot: &Vec3| foot.distance(from) < ACROSS_M && (*foot - from).dot(ahead) > 6.0;
    if matches!(way.direction, TurnDirection::Straight | TurnDirection::PartLeft | TurnDirection::PartRight) {
        let exit = net.edge_of(way.to).lanes().find(|lane| net.is_driven(*lane))?;
        let beside_m = side * (net.lane(exit).half_width_m() + BESIDE_M);
        let foot = |k: u32| {
            let pose = net.pose(LanePosition { lane: exit, s_m: 0.3 + f64::from(k), offset_m: beside_m });
            pose.position.as_vec3()
        };
        // Up to 7 m further on if another lane is in the way.
        let paved = net.edge_of(exit).lanes().any(|lane| net.lane(lane).is_footway());
        let free = |foot: &Vec3| paved || surfaces.border_m(foot.truncate()) > 0.5;
        return (0..8).map(foot).find(free).filter(near);
    }
    let foot = |k: u32| from + ahead * (6.0 + 0.5 * k as f32);
    (0..60).map(foot).find(|foot| surfaces.border_m(foot.truncate()) > 0.7).filter(near)
}

/// Returns the direction of a pose on the ground, a unit vector.
pub(super) fn direction(pose: &Pose3) -> Vec3 {
    Vec2::from_angle(pose.yaw_rad as f32).extend(0.0)
}

/// Adds a pole, with 0.5 m of it in the ground.
pub(super) fn pole(triangles: &mut TriangleList, foot: Vec3, height_m: f32) {
    bar(triangles, foot - Vec3::Z * 0.5, foot + Vec3::Z * height_m, 0.06);
}

/// Adds a steel bar with a hexagonal section.
fn bar(triangles: &mut TriangleList, from: Vec3, to: Vec3, radius_m: f32) {
    const SIDES: usize = 6;
    let along = (to - from).normalize_or(Vec3::Z);
    let (right, up) = along.any_orthonormal_pair();
    let ring = |k: usize| {
        let centre = if k == 0 { from } else { to };
        let corner = |i: usize| {
            let (sin, cos) = (TAU * i as f32 / SIDES as f32).sin_cos();
            centre + (right * cos + up * -sin) * radius_m
        };
        (0..SIDES).map(corner).collect()
    };
    triangles.bar(2, ring, STEEL);
}

/// Adds a housing centred on its middle lamp; returns the centres of the lamps' fronts, from the top.
fn housing(triangles: &mut TriangleList, middle: Vec3, facing: Vec3) -> [Vec3; 3] {
    let left = Vec3::Z.cross(facing);
    let turn = Mat3::from_cols(facing, left, Vec3::Z);
    let mut head = TriangleList::default();
    let [high, wide] = [LAMP_EVERY_M * 1.5 + 0.03, 0.20];
    head.cuboid(Vec3::new(-0.10, 0.0, 0.0), Vec3::new(0.10, wide, high), HOUSING);
    // The backboard and its pale rim.
    head.cuboid(Vec3::new(-0.02, 0.0, 0.0), Vec3::new(0.012, wide + 0.16, high + 0.16), HOUSING);
    let (y, z) = (wide + 0.20, high + 0.20);
    let corners = [(-y, -z), (y, -z), (y, z), (-y, z)].map(|(y, z)| Vec3::new(-0.026, y, z));
    head.quad(corners, RIM);
    head.cuboid(Vec3::new(-0.040, 0.0, 0.0), Vec3::new(0.012, y, z), HOUSING);
    let heights = [LAMP_EVERY_M, 0.0, -LAMP_EVERY_M];
    for (height_m, colour) in heights.into_iter().zip(DARK) {
        lens(&mut head, height_m, SurfaceFinish::new(Material::Lamp, colour));
        hood(&mut head, height_m);
    }
    triangles.append(head.moved(|p| middle + turn * p));
    heights.map(|height_m| middle + turn * Vec3::new(0.022, 0.0, height_m))
}

/// Adds a lamp's lens, slightly conical.
fn lens(head: &mut TriangleList, height_m: f32, finish: SurfaceFinish) {
    const SIDES: usize = 12;
    let rim = |k: usize| {
        let (sin, cos) = (TAU * k as f32 / SIDES as f32).sin_cos();
        Vec3::new(0.004, LAMP_M * cos, height_m + LAMP_M * sin)
    };
    for k in 0..SIDES {
        head.triangle([Vec3::new(0.014, 0.0, height_m), rim(k), rim(k + 1)], finish);
    }
}

/// Adds a hood over a lamp, visible from inside and outside.
fn hood(head: &mut TriangleList, height_m: f32) {
    const SIDES: usize = 6;
    let edge = |k: usize, out_m: f32| {
        // The arc starts a little below the middle on one side and ends a little below it on the other.
        let angle = TAU * (-0.04 + 0.58 * k as f32 / SIDES as f32);
        Vec3::new(out_m, 1.08 * LAMP_M * angle.cos(), height_m + 1.08 * LAMP_M * angle.sin())
    };
    for k in 0..SIDES {
        let corners = [edge(k, 0.0), edge(k, 0.20), edge(k + 1, 0.20), edge(k + 1, 0.0)];
        head.quad(corners, HOUSING);
        head.quad([corners[3], corners[2], corners[1], corners[0]], HOUSING);
    }
}

/// Returns the mesh of a lit lamp of radius 1 that shines along +x. Its light is the instance's colour.
pub(in crate::scene) fn lit_lamp() -> Mesh {
    const SIDES: usize = 16;
    let finish = SurfaceFinish::grey(Material::SignalLamp, 0.02);
    let mut triangles = TriangleList::default();
    let rim = |k: usize| {
        let (sin, cos) = (TAU * k as f32 / SIDES as f32).sin_cos();
        Vec3::new(-0.06, cos, sin)
    };
    for k in 0..SIDES {
        triangles.triangle([Vec3::ZERO, rim(k), rim(k + 1)], finish);
    }
    triangles.into_mesh(1.0)
}
