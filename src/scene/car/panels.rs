//! Cuts of a body: arches, windows, lamps, grilles, gaps between panels. In: the left half of a body in paint. Out: the same half
//! in its materials, and the clear covers over its lamps. Metres; positions are those before bending.

use super::{
    body_profile::{self, BodyLines, CABIN_FRONT_M},
    materials::{ARCH_RADIUS_M, CHROME, DARK, GLASS, GLOSS, LampLevel, PAINT, TRIM, WHEEL_RADIUS_M, WHEELBASE_M},
    panel_cutting::{CutRegion, PanelSkin},
};
use crate::scene::{Material, mesh::SurfaceFinish};
use glam::{Vec2, Vec3};

/// Distance of the wheel houses' inner wall from the middle of the car, metres.
const ARCH_DEPTH_M: f32 = 0.58;
/// Rear and front edge of the front door along x at the belt, metres.
const DOORS: [f32; 2] = [-0.01, 0.96];
/// Clear plastic: a darker pane is less transparent.
const CLEAR: SurfaceFinish = SurfaceFinish::new(Material::Glass, [0.002, 0.002, 0.002]);
/// Gap between panels: dark paint, which the shader lightens where a pixel is wider than the gap (`car.wgsl`).
const GAP: SurfaceFinish = SurfaceFinish::grey(Material::Paint, 0.02);
/// Mean finish of a head lamp, for levels without depth.
const HEAD: SurfaceFinish = SurfaceFinish::new(Material::HeadLamp, [0.16, 0.0, 0.7]);
/// Inside of a head lamp behind its cover, dark by day.
const HEAD_INSIDE: SurfaceFinish = SurfaceFinish::new(Material::HeadLamp, [0.010, 0.0, 0.7]);
const DAYLIGHT: SurfaceFinish = SurfaceFinish::new(Material::HeadLamp, [0.90, 1.0, 1.0]);
const AMBER: SurfaceFinish = SurfaceFinish::new(Material::Lamp, [0.45, 0.10, 0.012]);
const WHITE: SurfaceFinish = SurfaceFinish::grey(Material::Lamp, 0.42);
const REFLECTOR: SurfaceFinish = SurfaceFinish::new(Material::Reflector, [0.16, 0.004, 0.004]);
/// Frame of light around a rear lamp, and the lamp inside it.
const RUNNING: SurfaceFinish = SurfaceFinish::new(Material::BrakeLamp, [0.34, 1.0, 0.55]);
const STOP: SurfaceFinish = SurfaceFinish::new(Material::BrakeLamp, [0.16, 0.10, 1.0]);

fn points<const N: usize>(list: [(f32, f32); N]) -> [Vec2; N] {
    list.map(Vec2::from)
}

fn across<const N: usize>(list: [(f32, f32); N]) -> CutRegion {
    CutRegion::seen_along(0, &points(list))
}

/// Returns a gap between panels from `a` to `b`, 5 mm wide as on real cars; wider ones look like rods from close by.
fn gap(axis: usize, a: (f32, f32), b: (f32, f32)) -> CutRegion {
    let (a, b) = (Vec2::from(a), Vec2::from(b));
    let aside = (b - a).perp().normalize() * 0.0025;
    CutRegion::seen_along(axis, &[a - aside, b - aside, b + aside, a + aside])
}

/// Adds the details to a half body. Returns the covers of its lamps.
pub(in crate::scene) fn add_details(skin: &mut PanelSkin, lines: &BodyLines, level: LampLevel) -> PanelSkin {
    let mut covers = PanelSkin::default();
    arches(skin, level);
    windows(skin, lines, level);
    front(skin, &mut covers, level);
    rear(skin, level);
    if level == LampLevel::Near {
        gaps(skin, lines);
    }
    covers
}

/// Cuts the wheel houses, and paints the black sill between them.
fn arches(skin: &mut PanelSkin, level: LampLevel) {
    let sides = match level {
        LampLevel::Near => 30,
        LampLevel::Mid => 16,
        LampLevel::Far => 10,
    };
    for hub in [-WHEELBASE_M / 2.0, WHEELBASE_M / 2.0] {
        let circle: Vec<Vec2> = (0..sides)
            .map(|k| Vec2::from_angle(std::f32::consts::TAU * k as f32 / sides as f32) * ARCH_RADIUS_M)
            .map(|p| p + Vec2::new(hub, WHEEL_RADIUS_M))
            .collect();
        let house = CutRegion::seen_along(1, &circle).within(-Vec3::Y, -ARCH_DEPTH_M);
        skin.recess(&house, |p| p.with_y(ARCH_DEPTH_M), DARK, DARK);
    }
    if level != LampLevel::Far {
        let sill = CutRegion::seen_along(1, &points([(-1.3, 0.1), (1.3, 0.1), (1.3, 0.250), (-1.3, 0.262)]));
        skin.paint(&sill.within(-Vec3::Y, -0.72).facing(Vec3::Y, 0.1), TRIM);
    }
}

fn windows(skin: &mut PanelSkin, lines: &BodyLines, level: LampLevel) {
    let outline: Vec<Vec2> = lines.side_glass.iter().copied().map(Vec2::from).collect();
    let side = CutRegion::seen_along(1, &outline).within(-Vec3::Y, -0.3).facing(Vec3::Y, 0.28);
    // Windscreen and rear window lie between the pillars, whose inner edges are straight seen from above.
    let framed = |[rear, front]: [f32; 2], least_z: f32, up: f32| {
        let width = |x: f32| body_profile::at(lines, x).roof_y - 0.042;
        let [a, b] = [width(rear), width(front)];
        let corners = [(rear, -1.0), (front, -1.0), (front, b - 0.06), (front - 0.05 * (front - rear).signum(), b)];
        let polygon = points([corners[0], corners[1], corners[2], corners[3], (rear + 0.03, a), (rear, a - 0.06)]);
        CutRegion::seen_along(2, &polygon).within(-Vec3::Z, -least_z).facing(Vec3::Z, up)
    };
    let screen = framed([0.265, CABIN_FRONT_M - 0.045], 0.93, 0.2);
    let back = framed(lines.rear_glass, 0.99, 0.1);
    if level != LampLevel::Far {
        skin.paint(&side.clone().grown(0.016), GLOSS);
    }
    if level == LampLevel::Near {
        skin.paint(&screen.clone().grown(0.020), GLOSS);
        skin.paint(&back.clone().grown(0.020), GLOSS);
    }
    for pane in [&side, &screen, &back] {
        skin.paint(pane, GLASS);
    }
    if level == LampLevel::Far {
        return;
    }
    let mut bar = |x: f32, lean: f32, half: f32| {
        // The bar leans forwards with height.
        let slope = lean / 0.6;
        let low = Vec3::new(-1.0, 0.0, slope);
        skin.paint(&side.clone().within(low, 0.8 * slope - x + half).within(-low, x + half - 0.8 * slope), GLOSS);
    };
    // The pillar between the doors, then the division of the rear side window.
    bar(-0.01, 0.03, 0.050);
    if level == LampLevel::Near {
        bar(lines.side_glass[9].0 + 0.52, 0.06, 0.016);
    }
}

/// Cuts grille, intakes and head lamps.
fn front(skin: &mut PanelSkin, covers: &mut PanelSkin, level: LampLevel) {
    let ahead = |cell: CutRegion, x: f32| cell.within(-Vec3::X, -x);
    let back = |depth: f32| move |p: Vec3| p - Vec3::X * depth;
    let grille = ahead(
        across([
            (-0.1, 0.505),
            (0.34, 0.505),
            (0.375, 0.525),
            (0.395, 0.575),
            (0.372, 0.622),
            (0.33, 0.640),
            (-0.1, 0.646),
        ]),
        2.3,
    );
    let intake = ahead(across([(-0.1, 0.283), (0.46, 0.283), (0.54, 0.312), (0.52, 0.374), (-0.1, 0.384)]), 2.3);
    let vent = ahead(across([(0.62, 0.305), (0.71, 0.325), (0.70, 0.440), (0.655, 0.455), (0.625, 0.400)]), 2.2);
    if level != LampLevel::Far {
        skin.paint(&ahead(across([(-1.0, 0.1), (1.0, 0.1), (1.0, 0.255), (-1.0, 0.268)]), 1.78), TRIM);
        skin.paint(&grille.clone().grown(0.011), if level == LampLevel::Near { CHROME } else { GLOSS });
    }
    if level == LampLevel::Near {
        for (cell, depth) in [(&grille, 0.030), (&intake, 0.045), (&vent, 0.030)] {
            skin.recess(cell, back(depth), DARK, GLOSS);
        }
    } else {
        skin.paint(&grille, DARK);
        skin.paint(&intake, DARK);
        // The vent is 3 pixels by 1 at the distance where a car changes to the far level.
        if level == LampLevel::Mid {
            skin.paint(&vent, DARK);
        }
    }
    // The lamp rises along the wing and ends in a point.
    let lamp = across([(0.405, 0.55), (0.98, 0.55), (0.98, 0.85), (0.565, 0.85)])
        .within(Vec3::new(0.43, 0.0, 1.0), 0.650 + 0.43 * 2.5)
        .within(Vec3::new(-0.30, 0.0, -1.0), -0.574 - 0.30 * 2.5)
        .within(-Vec3::X, -2.14);
    let strip = lamp.clone().within(Vec3::new(0.30, 0.0, 1.0), 0.592 + 0.30 * 2.5);
    match level {
        LampLevel::Near => {
            let inside = skin.recess(&lamp, |p| p - Vec3::new(0.060, 0.022, 0.0), HEAD_INSIDE, GLOSS);
            covers
                .faces
                .extend(inside.into_iter().map(|face| super::panel_cutting::BodyFace { finish: CLEAR, ..face }));
            skin.paint(&strip.facing(Vec3::new(0.7, 0.7, 0.0), 0.2), DAYLIGHT);
        }
        LampLevel::Mid => {
            skin.paint(&lamp, HEAD);
            skin.paint(&strip, DAYLIGHT);
        }
        LampLevel::Far => skin.paint(&lamp, SurfaceFinish::new(Material::HeadLamp, [0.30, 0.0, 0.7])),
    }
}

/// Cuts the rear lamps, the recess of the plate and the lower part of the bumper.
fn rear(skin: &mut PanelSkin, level: LampLevel) {
    let behind = |cell: CutRegion, x: f32| cell.within(Vec3::X, x);
    let lamp = behind(
        across([(0.37, 0.774), (0.43, 0.760), (0.98, 0.752), (0.98, 0.880), (0.45, 0.872), (0.37, 0.852)]),
        -2.30,
    )
    .within(Vec3::new(1.0, 0.0, 0.4), -2.30 + 0.4 * 0.76);
    let plate = behind(
        across([(-0.1, 0.630), (0.275, 0.630), (0.30, 0.650), (0.30, 0.735), (0.28, 0.752), (-0.1, 0.752)]),
        -2.3,
    );
    let valance = behind(across([(-1.0, 0.1), (1.0, 0.1), (1.0, 0.360), (-1.0, 0.372)]), -1.8);
    skin.paint(&valance, TRIM);
    let reflector = behind(across([(0.55, 0.418), (0.755, 0.428), (0.75, 0.456), (0.56, 0.446)]), -2.3);
    if level == LampLevel::Far {
        skin.paint(&lamp, SurfaceFinish::new(Material::BrakeLamp, [0.20, 0.35, 0.75]));
        return;
    }
    skin.paint(&lamp.clone().grown(0.006), GLOSS);
    skin.paint(&lamp, RUNNING);
    let inner = lamp.grown(-0.017);
    skin.paint(&inner, GLOSS);
    skin.paint(&inner.clone().within(Vec3::Z, 0.842).within(-Vec3::Z, -0.800), STOP);
    let lower = inner.clone().within(Vec3::Z, 0.794);
    skin.paint(&lower.clone().within(-Vec3::Y, -0.52), AMBER);
    skin.paint(&lower.within(Vec3::Y, 0.50), WHITE);
    skin.paint(&reflector, REFLECTOR);
    // A dark strip from lamp to lamp above the plate.
    skin.paint(&behind(across([(-0.1, 0.792), (0.35, 0.792), (0.35, 0.828), (-0.1, 0.828)]), -2.3), GLOSS);
    let pipe = behind(across([(0.47, 0.312), (0.63, 0.312), (0.655, 0.355), (0.455, 0.355)]), -2.2);
    if level == LampLevel::Near {
        let ahead = |depth: f32| move |p: Vec3| p + Vec3::X * depth;
        skin.paint(&behind(across([(-0.1, 0.827), (0.35, 0.827), (0.35, 0.833), (-0.1, 0.833)]), -2.3), CHROME);
        skin.recess(&plate, ahead(0.034), PAINT, PAINT);
        skin.paint(&pipe.clone().grown(0.007), CHROME);
        skin.recess(&pipe, ahead(0.06), DARK, CHROME);
        let diffuser = behind(across([(-0.1, 0.313), (0.38, 0.313), (0.40, 0.350), (-0.1, 0.350)]), -2.2);
        skin.recess(&diffuser, ahead(0.05), DARK, TRIM);
        // Ribs in the lamp.
        for k in 0..9 {
            let y = 0.43 + 0.045 * k as f32;
            let rib = inner.clone().within(-Vec3::Y, -y).within(Vec3::Y, y + 0.005).within(Vec3::Z, 0.842);
            skin.paint(&rib.within(-Vec3::Z, -0.800), REFLECTOR);
        }
    }
}

/// Draws the gaps of doors, bonnet and boot lid.
fn gaps(skin: &mut PanelSkin, lines: &BodyLines) {
    let (seat, tail) = (lines.cabin_rear_m, lines.side_glass[9].0);
    let mut draw = |cell: CutRegion| {
        for face in skin.cut(&cell) {
            let finish = match face.finish.material {
                Material::Paint => GAP,
                Material::BrakeLamp => DARK,
                _ => face.finish,
            };
            skin.faces.push(super::panel_cutting::BodyFace { finish, ..face });
        }
    };
    let door = |a, b| gap(1, a, b).within(-Vec3::Y, -0.6).facing(Vec3::Y, 0.3);
    for x in DOORS {
        draw(door((x, 0.30), (x + 0.012, 0.62)));
        draw(door((x + 0.012, 0.62), (x, 0.985)));
    }
    let end = (tail + 0.28).clamp(-1.24, -1.10);
    for way in [[(-0.90, 0.30), (-0.93, 0.58)], [(-0.93, 0.58), (end, 0.79)], [(end, 0.79), (end, 0.985)]] {
        draw(door(way[0], way[1]));
    }
    draw(door((-0.90, 0.302), (DOORS[1], 0.302)));
    // Bumpers end at the arches, in line with the lamps.
    draw(door((1.78, 0.56), (2.20, 0.655)));
    draw(door((-1.79, 0.60), (-2.32, 0.600)));
    let above = |a, b| gap(2, a, b).within(-Vec3::Z, -0.6).facing(Vec3::Z, 0.3);
    draw(above((CABIN_FRONT_M + 0.02, 0.725), (1.9, 0.665)));
    draw(above((1.9, 0.665), (2.34, 0.560)));
    draw(above((2.34, 0.560), (2.43, 0.42)));
    draw(above((2.43, 0.42), (2.445, -0.1)));
    let rear = |a, b| gap(0, a, b).within(Vec3::X, -2.2).facing(-Vec3::X, 0.2);
    // The lower edge of the lid is rounded towards its sides.
    let lid = [(-0.1, 0.612), (0.470, 0.612), (0.508, 0.622), (0.526, 0.650), (0.530, 0.690), (0.530, 0.95)];
    lid.windows(2).for_each(|ends| draw(rear(ends[0], ends[1])));
    if seat > -2.0 {
        draw(above((-2.46, 0.53), (seat - 0.02, 0.64)));
    }
}
