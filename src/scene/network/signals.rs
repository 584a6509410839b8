//! Signal heads. For vehicles: three lamps in a vertical dark housing with a backboard, one head on a pole beside the stop line, one over each
//! further lane on an arm, and one across the junction, visible to the first vehicle at the line. For bicycles: a smaller head beside their lane.
//! For those who walk: two lamps at both ends of a crossing. In: their places, the network. Out: one mesh of poles, arms and heads; the lamps'
//! positions, with the link whose state each head shows. Sizes are from `docs/references.md: roads`.

use super::signal_faces::{SMALL_LAMP_M, SignalFace};
use crate::{
    map::network::{LaneId, Network, SignalId, SignalLight, SignalStates},
    roadside::signal_places::{
        CrossingEnd, HeadPlace, POLE_RADIUS_M, SignalPlace, SignalledApproach, SignalledLane, direction,
    },
    scene::{
        LitLamp, Material, Mesh,
        mesh::{SurfaceFinish, TriangleList},
    },
};
use glam::{Mat3, Vec2, Vec3};
use std::f32::consts::TAU;

/// Radius of a lamp, metres.
pub(in crate::scene) const LAMP_M: f32 = 0.15;
/// Distance of the light of a lamp before the front of its housing, metres.
const LENS_M: f32 = 0.022;
/// Distance between the middles of two lamps in a housing, metres.
const LAMP_EVERY_M: f32 = 0.36;
/// Height of the middle lamp on a pole, beside the stop line or across the junction, metres.
const POLE_HEAD_M: f32 = 2.75;
/// Height of the middle lamp over a lane, metres.
const ARM_HEAD_M: f32 = 5.6;
/// Height of the arm above the middle lamps of its heads, metres.
const ARM_OVER_M: f32 = 0.85;
/// Distance up to which lamps show their pictures, metres: of 720 lines an arrow then has little more than one.
const PICTURED_M: f32 = 150.0;
/// Height of the middle of a head for those who walk, metres.
const WALKERS_HEAD_M: f32 = 2.35;
/// Height of the middle of a head for bicycles, metres.
const BICYCLES_HEAD_M: f32 = 2.35;
/// Distance between the middles of two small lamps, and from the outermost one to the end of their housing, metres.
const SMALL_LAMP_EVERY_M: f32 = 0.25;
const SMALL_END_M: f32 = 0.135;

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
    /// Picture that its lamps show.
    pub face: SignalFace,
    /// Centre of the front of each lamp, world axes, metres: red, yellow, green. A head for those who walk has no yellow one.
    pub lamps: [Vec3; 3],
    /// Direction in which the lamps shine, a unit vector in world axes.
    pub facing: Vec3,
}

impl SignalHead {
    /// Returns the head as it is seen from a point: from afar an arrow is a disc, and the small lamps for those who walk or cycle are left
    /// out, so that the number of lights stays small in a city.
    pub(in crate::scene) fn seen_from(&self, eye: Vec3) -> Option<Self> {
        match self.face {
            _ if self.lamps[0].distance_squared(eye) < PICTURED_M * PICTURED_M => Some(*self),
            SignalFace::Walkers | SignalFace::Bicycles => None,
            SignalFace::Arrow(_) | SignalFace::Full => Some(Self { face: SignalFace::Full, ..*self }),
        }
    }

    /// Returns the lit lamps. Blinking lamps are lit for the first half of each second of `time_s`.
    pub(in crate::scene) fn lit(self, states: &SignalStates, time_s: f64) -> impl Iterator<Item = LitLamp> {
        let lit: &[usize] = match states.light(self.signal, self.link) {
            Some(SignalLight::Red | SignalLight::RedYellow | SignalLight::Yellow)
                if self.face == SignalFace::Walkers =>
            {
                &[0]
            }
            Some(SignalLight::Red) => &[0],
            Some(SignalLight::RedYellow) => &[0, 1],
            Some(SignalLight::Yellow) => &[1],
            Some(SignalLight::GreenMinor | SignalLight::GreenMajor | SignalLight::GreenArrow) => &[2],
            Some(SignalLight::OffBlinking) if self.face != SignalFace::Walkers && time_s.rem_euclid(1.0) < 0.5 => &[1],
            Some(SignalLight::OffBlinking | SignalLight::Off) | None => &[],
        };
        let Self { lamps, facing, face, .. } = self;
        // To the right as seen by those for whom it shines.
        let right = Vec3::Z.cross(facing);
        lit.iter().flat_map(move |&k| {
            let (discs, radius_m) = face.discs(k);
            let at = move |disc: Vec2| lamps[k] + right * disc.x + Vec3::Z * disc.y;
            discs.map(move |disc| LitLamp { position: at(disc), facing, radius_m, light: LIT[k] })
        })
    }
}

/// Returns the mesh of all signal heads, poles and arms, and the heads.
pub(in crate::scene) fn heads(net: &Network, places: &[SignalPlace]) -> (Mesh, Vec<SignalHead>) {
    let mut triangles = TriangleList::default();
    let mut heads = Vec::new();
    for place in places {
        match place {
            SignalPlace::Approach(of) => approach(net, of, &mut triangles, &mut heads),
            SignalPlace::Crossing(ends) => ends.iter().for_each(|end| heads.push(walkers_head(end, &mut triangles))),
        }
    }
    (triangles.into_mesh(0.6), heads)
}

/// Adds the heads at the end of one edge.
fn approach(net: &Network, place: &SignalledApproach, triangles: &mut TriangleList, heads: &mut Vec<SignalHead>) {
    let SignalledApproach { foot, behind, lanes } = place;
    let (foot, behind) = (*foot, *behind);
    let mut arm_end: Option<Vec3> = None;
    for &SignalledLane { lane, signal, link, direction: turn, line, place, across } in lanes {
        let face = SignalFace::of(net, lane, (turn, signal, link));
        let mut head = |middle: Vec3, triangles: &mut TriangleList| {
            let facing = -direction(&line);
            let lamps = match face {
                SignalFace::Bicycles => small_housing(triangles, middle, facing, [0, 1, 2]),
                _ => housing(triangles, middle, facing),
            };
            heads.push(SignalHead { lane, signal, link, face, lamps, facing });
        };
        match place {
            HeadPlace::OwnPole(foot) => {
                pole(triangles, foot + behind, BICYCLES_HEAD_M + 0.45);
                head(foot + Vec3::Z * BICYCLES_HEAD_M, triangles);
            }
            HeadPlace::Pole => head(foot + Vec3::Z * POLE_HEAD_M, triangles),
            HeadPlace::Arm => {
                let over = line.position.as_vec3() + Vec3::Z * ARM_HEAD_M;
                head(over, triangles);
                arm_end = Some(over + Vec3::Z * ARM_OVER_M);
                bar(triangles, over + behind, over + behind + Vec3::Z * ARM_OVER_M, 0.03);
            }
        }
        if let Some(foot) = across {
            pole(triangles, foot + behind, POLE_HEAD_M + 0.7);
            head(foot + Vec3::Z * POLE_HEAD_M, triangles);
        }
    }
    match arm_end {
        Some(end) => {
            pole(triangles, foot + behind, end.z - foot.z + 0.15);
            bar(triangles, (foot + behind).with_z(end.z), end + behind, 0.07);
        }
        None if place.has_pole() => pole(triangles, foot + behind, POLE_HEAD_M + 0.7),
        None => {}
    }
}

/// Returns the head for those who walk at one end of a crossing, and adds it with its pole.
fn walkers_head(end: &CrossingEnd, triangles: &mut TriangleList) -> SignalHead {
    let CrossingEnd { lane, signal, link, foot, outwards } = *end;
    pole(triangles, end.pole(), WALKERS_HEAD_M + 0.3);
    let facing = -outwards;
    // The green lamp is in the place of the yellow one, too.
    let [red, green] = small_housing(triangles, foot + Vec3::Z * WALKERS_HEAD_M, facing, [0, 2]);
    let lamps = [red, green, green];
    SignalHead { lane, signal, link, face: SignalFace::Walkers, lamps, facing }
}

/// Adds a pole, with 0.5 m of it in the ground.
pub(super) fn pole(triangles: &mut TriangleList, foot: Vec3, height_m: f32) {
    bar(triangles, foot - Vec3::Z * 0.5, foot + Vec3::Z * height_m, POLE_RADIUS_M);
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
    fit_lamps(&mut head, heights.into_iter().zip(DARK), LAMP_M);
    triangles.append(head.moved(|p| middle + turn * p));
    heights.map(|height_m| middle + turn * Vec3::new(LENS_M, 0.0, height_m))
}

/// Adds the unlit lamps of a housing at these heights over its middle, with these colours.
fn fit_lamps(head: &mut TriangleList, lamps: impl Iterator<Item = (f32, [f32; 3])>, radius_m: f32) {
    for (height_m, colour) in lamps {
        lens(head, height_m, radius_m, SurfaceFinish::new(Material::Lamp, colour));
        hood(head, height_m, radius_m);
    }
}

/// Adds a housing of small lamps for those who walk or cycle, with these colours of [`DARK`] from the top; returns the centres of the lamps'
/// fronts.
fn small_housing<const N: usize>(
    triangles: &mut TriangleList,
    middle: Vec3,
    facing: Vec3,
    colours: [usize; N],
) -> [Vec3; N] {
    let turn = Mat3::from_cols(facing, Vec3::Z.cross(facing), Vec3::Z);
    let mut head = TriangleList::default();
    let top_m = SMALL_LAMP_EVERY_M * (N as f32 - 1.0) / 2.0;
    head.cuboid(Vec3::new(-0.08, 0.0, 0.0), Vec3::new(0.08, 0.13, top_m + SMALL_END_M), HOUSING);
    let heights: [f32; N] = std::array::from_fn(|k| top_m - SMALL_LAMP_EVERY_M * k as f32);
    fit_lamps(&mut head, heights.into_iter().zip(colours.map(|colour| DARK[colour])), SMALL_LAMP_M);
    triangles.append(head.moved(|p| middle + turn * p));
    heights.map(|height_m| middle + turn * Vec3::new(LENS_M, 0.0, height_m))
}

/// Adds a lamp's lens, slightly conical.
fn lens(head: &mut TriangleList, height_m: f32, radius_m: f32, finish: SurfaceFinish) {
    const SIDES: usize = 12;
    let rim = |k: usize| {
        let (sin, cos) = (TAU * k as f32 / SIDES as f32).sin_cos();
        Vec3::new(0.004, radius_m * cos, height_m + radius_m * sin)
    };
    for k in 0..SIDES {
        head.triangle([Vec3::new(0.014, 0.0, height_m), rim(k), rim(k + 1)], finish);
    }
}

/// Adds a hood over a lamp, visible from inside and outside.
fn hood(head: &mut TriangleList, height_m: f32, radius_m: f32) {
    const SIDES: usize = 6;
    let long_m = 1.33 * radius_m;
    let edge = |k: usize, out_m: f32| {
        // The arc starts a little below the middle on one side and ends a little below it on the other.
        let angle = TAU * (-0.04 + 0.58 * k as f32 / SIDES as f32);
        Vec3::new(out_m, 1.08 * radius_m * angle.cos(), height_m + 1.08 * radius_m * angle.sin())
    };
    for k in 0..SIDES {
        let corners = [edge(k, 0.0), edge(k, long_m), edge(k + 1, long_m), edge(k + 1, 0.0)];
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
