//! The ego seen from the driver's seat. Out: meshes in metres: bonnet and wings; the shelf behind the windscreen with the doors
//! beside it; instruments, doors and pillars (these three in the body's frame); the steering wheel about its hub, its axle along
//! x towards the driver; the mirrors' housings; [`wipers`]. Drawn in the driver's view only.

pub(super) mod instrument_cluster;
pub(super) mod mirrors;
pub mod wipers;

use super::{
    Material, Mesh,
    car::{
        BodyParts,
        body_profile::{self, CABIN_FRONT_M, STYLES},
        materials::{CHROME, CREASE_RAD, DARK, GLOSS, LampLevel, TRIM},
        panel_cutting::PanelSkin,
    },
    mesh::{SurfaceFinish, TriangleList},
};
use glam::{Affine3A, Quat, Vec2, Vec3};
use std::f32::consts::TAU;

/// Padded, grained plastic, and the top of the dashboard with a faint sheen.
const PADDED: SurfaceFinish = SurfaceFinish::grey(Material::Matt, 0.034);
const TOPPED: SurfaceFinish = SurfaceFinish::new(Material::Tyre, [0.058, 0.054, 0.049]);
const FIN: SurfaceFinish = SurfaceFinish::grey(Material::Matt, 0.050);
/// Side of the square at which the grain of plastic repeats, metres.
const GRAIN_M: f32 = 0.26;
const LINING: SurfaceFinish = SurfaceFinish::grey(Material::Matt, 0.070);
const LEATHER: SurfaceFinish = SurfaceFinish::grey(Material::Tyre, 0.020);
/// Hub of the steering wheel in the body's frame, metres; it keeps the rim below the instrument.
const HUB_M: Vec3 = Vec3::new(0.56, 0.36, 0.786);
/// Rear end of the wings, where the doors begin, x in metres.
const DOOR_M: f32 = 0.99;
/// Angle by which the steering wheel leans back from upright, radians.
const LEAN_RAD: f32 = 0.42;
/// Distance of the bonnet's edge below the horizon straight ahead of the driver, metres at 1 m. The bonnet hides the road below
/// this edge and, to either side, below a circle that touches it there.
pub const BONNET_EDGE: f32 = 0.155;
/// Radius of the steering wheel's rim, metres.
const RIM_M: f32 = 0.185;

/// Meshes of the ego seen from the driver's seat.
#[derive(Clone, Debug, PartialEq)]
pub struct Cockpit {
    /// Bonnet and wings, in the body's frame.
    pub bonnet: Mesh,
    /// Both wipers at rest, in the body's frame.
    pub resting_wipers: Mesh,
    /// One wiper, placed by [`Cockpit::body_from_wipers`], and the windscreen, in the body's frame: both for rain.
    pub wiper: Mesh,
    pub windscreen: Mesh,
    /// The dashboard's top from the windscreen's foot on, and the doors below their windows.
    pub shelf: Mesh,
    /// Housing of the instruments, edges of the doors, pillars.
    pub cabin: Mesh,
    /// Steering wheel, see [`Cockpit::body_from_wheel`].
    pub wheel: Mesh,
    /// Housings of mirrors, placed by [`body_from_glass`](super::MirrorPane::body_from_glass): the rear-view mirror's with its
    /// stalk, and those with their foot at the right, at the left and below.
    pub housings: [Mesh; 4],
}

impl Cockpit {
    /// Builds all parts, for the ego's body style.
    pub(in crate::scene) fn new() -> Self {
        Self {
            bonnet: bonnet(),
            resting_wipers: resting_wipers(),
            wiper: wipers::arm(),
            windscreen: wipers::windscreen(),
            shelf: shelf(),
            cabin: cabin(),
            wheel: wheel(),
            housings: mirrors::housings(),
        }
    }

    /// Returns the transform from the steering wheel to the body when it is turned by `wheel_rad`, positive to the left.
    pub fn body_from_wheel(wheel_rad: f32) -> Affine3A {
        // The axle points back and up to the driver; a turn to the left is negative about it.
        let axle = Quat::from_rotation_y(LEAN_RAD) * Quat::from_rotation_z(std::f32::consts::PI);
        Affine3A::from_rotation_translation(axle * Quat::from_rotation_x(wheel_rad), HUB_M)
    }
}

/// Distance by which the wings' rear ends fall, so that they lie below the doors' tops, metres.
const UNDER_DOOR_M: f32 = 0.008;

fn bonnet() -> Mesh {
    let lines = STYLES[0];
    let mut shell = BodyParts::new(lines, LampLevel::Near).shell;
    // The part of the body before the windscreen or beside the dashboard that is visible from above.
    let seen = |p: Vec3| p.z > 0.60 && (p.x > CABIN_FRONT_M || (p.x > DOOR_M && p.z < 0.93));
    let mut sheet = shell.take(|face| face.corners.iter().all(|c| seen(c.flat)));
    for corner in sheet.faces.iter_mut().flat_map(|face| &mut face.corners) {
        corner.at.z -= dip_m(corner.flat) + if corner.flat.x < CABIN_FRONT_M - 0.05 { UNDER_DOOR_M } else { 0.0 };
    }
    sheet.smooth(0.95);
    let mut mesh = sheet.mesh();
    let mut parts = TriangleList::default();
    seal(&mut parts);
    mesh.append(&parts.into_mesh(CREASE_RAD));
    mesh
}

/// Returns the distance by which the bonnet falls towards the windscreen between the wings, metres. Without it an upright driver
/// would see a strip of bonnet that is 4 % of the picture high.
fn dip_m(flat: Vec3) -> f32 {
    let share = flat.y.abs() / body_profile::at(STYLES[0], flat.x).belt_y;
    0.034 * body_profile::smooth((1.85 - flat.x) / 0.60) * body_profile::smooth((0.99 - share) / 0.20)
}

/// Returns two thin arms at rest on the bonnet's rear edge.
fn resting_wipers() -> Mesh {
    let mut parts = TriangleList::default();
    const PLACES: usize = 12;
    for (from, to) in [(0.62, 0.06), (0.01, -0.56)] {
        let ring = |i: usize| {
            let t = i as f32 / (PLACES - 1) as f32;
            let at = on_shelf((-0.012 - 0.020 * t, -0.021 + 0.004 * t), from + (to - from) * t);
            let half = 0.0045 - 0.002 * t;
            [(-half, 0.0), (0.0, -half), (half, 0.0), (0.0, half)].map(|(x, z)| at + Vec3::new(x, 0.0, z)).into()
        };
        parts.bar(PLACES, ring, GLOSS);
    }
    parts.into_mesh(CREASE_RAD)
}

/// Draws the black seal along the windscreen's foot, under which the bonnet's rear edge ends.
fn seal(parts: &mut TriangleList) {
    const PLACES: usize = 41;
    let ring = |i: usize| {
        let y = 0.84 - 1.68 * i as f32 / (PLACES - 1) as f32;
        // High enough to close the gap between bonnet and dashboard, and thinning out beside the pillars.
        let thin = body_profile::smooth((0.84 - y.abs()) / 0.04);
        // The bonnet's edge rises and bows backwards towards the wings, and so does the seal over it.
        let aside = body_profile::smooth((y.abs() - 0.55) / 0.15);
        let dip_m = dip_m(Vec3::new(CABIN_FRONT_M, y, 0.0));
        let at = on_shelf((0.012 + 0.014 * aside, -0.004 - dip_m), y);
        (0..8)
            .map(|k| Vec2::from_angle(TAU * k as f32 / 8.0))
            .map(|o| at + Vec3::new(-0.022 * o.x, 0.0, (0.002 + 0.013 * thin) * o.y))
            .collect()
    };
    parts.bar(PLACES, ring, GLOSS);
}

fn shelf() -> Mesh {
    let mut all = grained(scuttle().mesh());
    all.append(&doors().mesh());
    all.append(&fins().into_mesh(CREASE_RAD));
    all
}

/// Returns the doors below their windows, seen from inside; they hide the road beside the scuttle.
fn doors() -> PanelSkin {
    const PARTS: usize = 16;
    const REAR_M: f32 = 0.40;
    const FRONT_M: f32 = CABIN_FRONT_M + 0.20;
    let lines = STYLES[0];
    let mut skin = PanelSkin::default();
    for side in [-1.0, 1.0] {
        // From the belt inwards, then down.
        let place = |i: usize, row: usize| {
            let x = REAR_M + (FRONT_M - REAR_M) * i as f32 / PARTS as f32;
            let at = body_profile::at(lines, x);
            // It narrows and falls towards its front end, so that the wing ends it.
            let thin = body_profile::smooth((FRONT_M - x) / 0.22);
            let z = at.belt_z + 0.020 * body_profile::smooth((x - 0.78) / 0.15) * thin - 0.030 * (1.0 - thin);
            let (inwards, z) =
                [(0.010, z - 0.002), (0.010 + 0.050 * thin, z - 0.010), (0.010 + 0.100 * thin, 0.55)][row];
            Vec3::new(x, side * (at.belt_y - inwards), z)
        };
        for i in 0..PARTS {
            for row in 0..2 {
                let [a, b, c, d] = [place(i, row), place(i, row + 1), place(i + 1, row + 1), place(i + 1, row)];
                skin.quad(if side > 0.0 { [a, b, c, d] } else { [d, c, b, a] }, |p| p, PADDED);
            }
        }
    }
    skin.smooth(0.9);
    skin
}

/// Sets texture coordinates on parts with a grain; `u` below zero marks them for the shader (`car.wgsl`).
fn grained(mut mesh: Mesh) -> Mesh {
    for v in mesh.vertices.iter_mut().filter(|v| v.material == Material::Tyre as u32) {
        v.uv = [v.position[1] / GRAIN_M - 20.0, v.position[0] / GRAIN_M];
    }
    mesh
}

/// Returns a point on the dashboard's top from its distances behind the windscreen's foot, above the crown there, and to the
/// left, metres.
fn on_shelf((back, up): (f32, f32), y: f32) -> Vec3 {
    let lines = STYLES[0];
    let foot = body_profile::bend(lines, Vec3::new(CABIN_FRONT_M + 0.03, y, 0.95));
    let at = body_profile::at(lines, CABIN_FRONT_M + 0.03);
    Vec3::new(foot.x - back * (1.0 + 0.12 * (y / 0.8) * (y / 0.8)), y, at.crown(y.clamp(-0.8, 0.8)) + up)
}

/// Front and rear edge of the defroster's vents: distance behind the windscreen's foot, height above the crown, metres.
const VENT: [(f32, f32); 2] = [(0.040, -0.052), (0.082, -0.064)];

/// Returns the dashboard's top, from the foot of the windscreen to below the picture: a dark sill, the vents of the defroster, a
/// padded shelf with a seam, rounded at its edges.
fn scuttle() -> PanelSkin {
    const COLUMNS: usize = 32;
    let rows = [
        ((-0.28, -0.090), DARK),
        ((-0.05, -0.052), DARK),
        ((0.030, -0.037), TOPPED),
        ((0.034, -0.044), TOPPED),
        // Down into the vents and up over a rounded edge.
        ((0.038, -0.051), DARK),
        (VENT[0], DARK),
        (VENT[1], DARK),
        ((0.086, -0.060), TOPPED),
        ((0.094, -0.0575), TOPPED),
        ((0.106, -0.0585), TOPPED),
        ((0.150, -0.066), TOPPED),
        ((0.166, -0.0695), DARK),
        ((0.170, -0.0715), TOPPED),
        ((0.176, -0.0705), TOPPED),
        ((0.22, -0.079), TOPPED),
        ((0.34, -0.088), TOPPED),
        ((0.44, -0.105), TOPPED),
        ((0.50, -0.16), TOPPED),
    ];
    let place = |(back, up): (f32, f32), column: usize| {
        // Narrower and deeper where it continues under the bonnet and the wings.
        let (width, up) = match back {
            back if back < -0.1 => (1.52, up - 0.004),
            back if back < 0.0 => (1.64, up - 0.004),
            _ => (1.70, up),
        };
        on_shelf((back, up), width * (column as f32 / COLUMNS as f32 - 0.5))
    };
    let mut skin = PanelSkin::default();
    for pair in rows.windows(2) {
        for column in 0..COLUMNS {
            let ([(a, finish), (b, _)], next) = ([pair[0], pair[1]], column + 1);
            skin.quad([place(a, column), place(a, next), place(b, next), place(b, column)], |p| p, finish);
        }
    }
    skin.smooth(0.9);
    skin
}

/// Returns the fins of the vents, in three groups.
fn fins() -> TriangleList {
    const PITCH_M: f32 = 0.013;
    let mut all = TriangleList::default();
    for (from, to) in [(-0.66, -0.20), (-0.17, 0.17), (0.20, 0.66)] {
        for k in 0..((to - from) / PITCH_M) as usize {
            let y = from + PITCH_M * k as f32;
            let corner = |end: usize, y: f32| on_shelf(VENT[end], y) + Vec3::Z * 0.0045;
            all.quad([corner(0, y), corner(0, y + 0.005), corner(1, y + 0.005), corner(1, y)], FIN);
        }
    }
    all
}

fn cabin() -> Mesh {
    let mut skin = PanelSkin::default();
    let lines = STYLES[0];
    // The doors' upper edges, from the dashboard to beside the eye.
    for side in [-1.0f32, 1.0] {
        let edge = |i: usize, (z_m, in_m): (f32, f32)| {
            let x = 1.16 - 0.1 * i as f32;
            let at = body_profile::at(lines, x);
            Vec3::new(x, side * (at.belt_y - in_m), at.belt_z + z_m)
        };
        let section = [(0.004, 0.0), (0.012, 0.025), (0.010, 0.06), (-0.012, 0.085), (-0.40, 0.095)];
        for i in 0..13 {
            for pair in section.windows(2) {
                let mut corners = [edge(i, pair[0]), edge(i, pair[1]), edge(i + 1, pair[1]), edge(i + 1, pair[0])];
                if side > 0.0 {
                    corners.reverse();
                }
                skin.quad(corners, |p| p, PADDED);
            }
        }
    }
    skin.smooth(0.9);
    let mut all = skin.mesh();
    let mut parts = TriangleList::default();
    for side in [-1.0, 1.0] {
        pillar(&mut parts, side);
    }
    all.append(&parts.into_mesh(1.2));
    all.append(&instrument_cluster::binnacle().into_mesh(CREASE_RAD));
    all
}

/// Draws a pillar along the windscreen's edge, from the dashboard to the roof: lined inside, with a dark seal towards the glass.
fn pillar(all: &mut TriangleList, side: f32) {
    const PLACES: usize = 25;
    let middle = |i: usize| {
        let x = CABIN_FRONT_M + 0.05 - 0.95 * i as f32 / (PLACES - 1) as f32;
        let at = body_profile::at(STYLES[0], x.min(CABIN_FRONT_M));
        // The foot of the pillar is inside the dashboard.
        let foot_m = 0.09 * (1.0 - i as f32 / 3.0).max(0.0).powi(2);
        Vec3::new(x + 0.5 * foot_m, side * (at.roof_y + 0.022), at.roof_z - 0.010 - foot_m)
    };
    let ring = |half: [f32; 2], off: f32| {
        move |i: usize| -> Vec<Vec3> {
            let along = (middle((i + 1).min(PLACES - 1)) - middle(i.max(1) - 1)).normalize();
            let across = along.cross(Vec3::Z).normalize();
            let up = across.cross(along);
            let corner = |k: usize| {
                let (sin, cos) = (TAU * k as f32 / 16.0).sin_cos();
                // A rounded rectangle (Lamé's curve of the fourth order).
                let round = |v: f32| v.signum() * v.abs().sqrt();
                middle(i) + across * (round(cos) * half[0] - off * side) + up * (round(sin) * half[1])
            };
            (0..16).map(corner).collect()
        }
    };
    all.bar(PLACES, ring([0.020, 0.016], 0.0), LINING);
    all.bar(PLACES, ring([0.007, 0.010], 0.022), DARK);
}

fn wheel() -> Mesh {
    let mut triangles = TriangleList::default();
    const PLACES: usize = 65;
    let rim = |i: usize| -> Vec<Vec3> {
        let turn = TAU * (i % (PLACES - 1)) as f32 / (PLACES - 1) as f32;
        let out = Vec3::new(0.0, turn.sin(), turn.cos());
        // Thicker at the thumbs.
        let thick = 0.0145 + 0.002 * (2.0 * turn).cos().min(0.0).abs();
        let corner = |k: usize| {
            let (sin, cos) = (TAU * k as f32 / 14.0).sin_cos();
            out * (RIM_M + thick * 0.88 * cos) - Vec3::X * (thick * sin)
        };
        (0..14).map(corner).collect()
    };
    triangles.bar(PLACES, rim, LEATHER);
    // A thin bright ring at the top marks straight ahead.
    let mark = |i: usize| -> Vec<Vec3> {
        let turn = -0.035 + 0.07 * i as f32 / 4.0;
        let out = Vec3::new(0.0, turn.sin(), turn.cos());
        let corner = |k: usize| {
            let (sin, cos) = (TAU * k as f32 / 14.0).sin_cos();
            out * (RIM_M + 0.0136 * cos) - Vec3::X * (0.0152 * sin)
        };
        (0..14).map(corner).collect()
    };
    triangles.bar(5, mark, SurfaceFinish::grey(Material::Tyre, 0.28));
    // Hub and three spokes.
    triangles.ellipsoid(Vec3::new(-0.012, 0.0, -0.005), Vec3::new(0.030, 0.078, 0.070), [14, 20], |_| LEATHER);
    triangles.ellipsoid(Vec3::new(0.016, 0.0, 0.0), Vec3::new(0.008, 0.022, 0.016), [8, 14], |_| CHROME);
    for (turn, wide) in [(TAU * 0.255, 0.030), (-TAU * 0.255, 0.030), (TAU * 0.5, 0.026)] {
        let out = Vec3::new(0.0, turn.sin(), turn.cos());
        let aside = Vec3::new(0.0, turn.cos(), -turn.sin());
        let ring = |i: usize| -> Vec<Vec3> {
            let t = i as f32 / 6.0;
            let at = out * (0.05 + (RIM_M - 0.055) * t) - Vec3::X * (0.020 * (1.0 - t));
            let half = wide * (1.0 - 0.35 * t);
            let corner = |k: usize| {
                let (sin, cos) = (TAU * k as f32 / 10.0).sin_cos();
                at + aside * (half * cos) - Vec3::X * (0.009 * sin)
            };
            (0..10).map(corner).collect()
        };
        triangles.bar(7, ring, GLOSS);
    }
    // The steering column.
    triangles.ellipsoid(Vec3::new(-0.09, 0.0, -0.01), Vec3::new(0.07, 0.05, 0.05), [10, 14], |_| TRIM);
    triangles.into_mesh(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::ViewOptions;
    use crate::scene::mesh::tests::{check, faces, has_coat, open_edges, volume_m3};

    #[test]
    fn the_cockpit_does_not_hide_the_road() {
        let cockpit = Cockpit::new();
        let eye = ViewOptions::default().eye;
        let placed = |mesh: &Mesh, from: Affine3A| -> Vec<Vec3> {
            mesh.vertices.iter().map(|v| from.transform_point3(v.position.into()) - eye).collect()
        };
        let highest = |points: &[Vec3], ahead: &dyn Fn(Vec3) -> bool| {
            points.iter().filter(|p| ahead(**p)).map(|p| p.z / p.x).fold(f32::MIN, f32::max)
        };
        check(&cockpit.bonnet, "bonnet");
        check(&cockpit.shelf, "shelf");
        check(&cockpit.cabin, "cabin");
        check(&cockpit.wheel, "wheel");
        // Straight ahead the bonnet ends 9 degrees below the horizon. The asphalt is visible from 7.5 m before the eye, 5 m
        // before the bumper; of a car 2 m ahead all above its bumper is visible.
        let bonnet = [&cockpit.bonnet, &cockpit.shelf].map(|mesh| placed(mesh, Affine3A::IDENTITY)).concat();
        let edge = highest(&bonnet, &|p| p.x > 0.4 && (p.y / p.x).abs() < 0.30);
        assert!((-0.19..-0.14).contains(&edge), "{edge}");
        // Where the speedometer covers the bonnet, the bonnet hides all that the instrument would hide.
        let along_edges: Vec<Vec3> = faces(&cockpit.bonnet)
            .flat_map(|(corners, _)| {
                let [a, b, c] = corners.map(|corner| Vec3::from(corner.position) - eye);
                [(a, b), (b, c), (c, a)].into_iter().flat_map(|(a, b)| (0..16).map(move |i| a.lerp(b, i as f32 / 16.0)))
            })
            .collect();
        for k in -7..7 {
            let (left, right) = (0.02 * k as f32, 0.02 * (k + 1) as f32);
            // An instrument is round, so it begins lower beside its middle. Radius of the largest one, metres at 1 m.
            let radius = 0.155f32;
            let lower = radius - (radius * radius - left.abs().min(right.abs()).powi(2)).sqrt();
            let edge = highest(&along_edges, &|p| p.x > 0.4 && (left..=right).contains(&(p.y / p.x)));
            assert!(edge >= -BONNET_EDGE - lower, "{left}: {edge}");
        }
        // No part of the cabin rises above the edge but the pillars at the picture's edges, at any steering angle.
        let cabin = placed(&cockpit.cabin, Affine3A::IDENTITY);
        assert!(highest(&cabin, &|p| p.x > 0.2 && (p.y / p.x).abs() < 0.36) < edge, "cabin");
        for turn in [-3.0, -0.5, 0.0, 1.0, 4.0] {
            let wheel = placed(&cockpit.wheel, Cockpit::body_from_wheel(turn));
            assert!(highest(&wheel, &|p| p.x > 0.2) < edge, "wheel at {turn}");
            assert!(wheel.iter().all(|p| p.length() > 0.25), "clear of the near plane");
        }
        assert!(bonnet.iter().chain(&cabin).all(|p| p.length() > 0.25), "clear of the near plane");
    }

    #[test]
    fn below_the_bonnets_seal_is_neither_paint_nor_road() {
        let cockpit = Cockpit::new();
        let eye = ViewOptions::default().eye;
        // Triangles as the driver sees them: to the left and down at 1 m, and nearness.
        let mut seen: Vec<(bool, [Vec3; 3])> = Vec::new();
        for mesh in [&cockpit.bonnet, &cockpit.shelf] {
            for (corners, face) in faces(mesh) {
                let from_eye = corners.map(|corner| Vec3::from(corner.position) - eye);
                if from_eye.iter().all(|p| p.x > 0.2) && face.dot(from_eye[0]) < 0.0 {
                    let is_paint = corners[0].material == Material::Paint as u32;
                    seen.push((is_paint, from_eye.map(|p| Vec3::new(p.y / p.x, -p.z / p.x, 1.0 / p.x))));
                }
            }
        }
        // From the picture's middle to its left edge, 0.6 m aside at 1 m, in steps of 5 pixels of 1920; down to its lower edge, 0.34 m, in steps
        // of 2.
        for column in 0..190u16 {
            let left = 0.0032 * f32::from(column);
            let here: Vec<_> =
                seen.iter().filter(|(_, t)| t.iter().any(|p| p.x <= left) && t.iter().any(|p| p.x >= left)).collect();
            let nearest = |down: f32| {
                let hits = here.iter().filter_map(|(is_paint, [a, b, c])| {
                    let at = Vec2::new(left, down);
                    let side =
                        |from: &Vec3, to: &Vec3| (to.truncate() - from.truncate()).perp_dot(at - from.truncate());
                    let shares = [side(b, c), side(c, a), side(a, b)];
                    let whole: f32 = shares.iter().sum();
                    let is_inside = whole != 0.0 && shares.iter().all(|share| share / whole >= -1e-5);
                    is_inside.then(|| ((shares[0] * a.z + shares[1] * b.z + shares[2] * c.z) / whole, *is_paint))
                });
                hits.max_by(|one, other| one.0.total_cmp(&other.0)).map(|(_, is_paint)| is_paint)
            };
            let all: Vec<Option<bool>> = (0..140u16).map(|row| nearest(0.16 + 0.0013 * f32::from(row))).collect();
            let below: Vec<_> =
                all.iter().skip_while(|hit| hit.is_none()).skip_while(|hit| **hit == Some(true)).collect();
            let wrong = below.iter().position(|hit| **hit != Some(false));
            assert_eq!(wrong, None, "{left} to the left, {} rows: {below:?}", below.len());
        }
    }

    #[test]
    fn shelf_and_cabin_have_no_coat() {
        let Cockpit { bonnet, shelf, cabin, wheel, .. } = Cockpit::new();
        assert_eq!([bonnet, shelf, cabin, wheel].map(|mesh| has_coat(&mesh)), [true, false, false, true]);
    }

    #[test]
    fn a_left_turn_moves_the_top_of_the_steering_wheel_left() {
        let top = Vec3::new(0.0, 0.0, RIM_M);
        let at = |turn: f32| Cockpit::body_from_wheel(turn).transform_point3(top);
        assert!(at(0.0).z > HUB_M.z + 0.15 && (at(0.0).y - HUB_M.y).abs() < 1e-5, "{}", at(0.0));
        // In a turn to the left the top of the rim moves left, towards +y.
        assert!(at(0.5).y > HUB_M.y + 0.05, "{}", at(0.5));
        // The face of the wheel points at the driver: backwards and up.
        let face = Cockpit::body_from_wheel(0.0).transform_vector3(Vec3::X);
        assert!(face.x < -0.8 && face.z > 0.3, "{face}");
        let mesh = wheel();
        assert_eq!(open_edges(&mesh), 0);
        assert!(volume_m3(&mesh) > 0.0);
    }
}
