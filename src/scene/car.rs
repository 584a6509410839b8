//! The bodies of cars: a saloon, an estate and a liftback, 5.00 m long, 1.80 m wide, 1.45 m high, each at three levels of
//! detail. Out: meshes without wheels (x forward, y left, z up, origin on the ground under the centre) and where the
//! wheels sit. A body is lofted: at stations along x a half cross-section, whose heights and widths follow `shape`.

use super::fittings;
use super::mesh::{Finish, Soup};
use super::shape::{self, ARCH_RADIUS_M, CABIN_FRONT_M, Lines, STYLES};
use super::{CarModel, Material};
use glam::{Vec2, Vec3};

/// Distance between the axles, metres.
pub const WHEELBASE_M: f32 = 2.8;
/// Distance between the middles of the tyres of one axle, metres.
pub const TRACK_M: f32 = 1.55;
/// Radius of a wheel, and height of its hub, metres.
pub const WHEEL_RADIUS_M: f32 = 0.33;

/// Main lines of a half section, from the middle of the floor round the left side to the middle of the top. Between two
/// of them a section has as many points as its level of detail asks for, so a point is a number on this scale.
const LAST: usize = 13;
const FLOOR_EDGE: usize = 1;
const SILL: usize = 2;
const BELT: usize = 7;
const GLASS_LOW: usize = 8;
const GLASS_HIGH: usize = 9;
const ROOF_EDGE: usize = 10;

pub(super) const PAINT: Finish = Finish::grey(Material::Paint, 1.0);
pub(super) const DARK: Finish = Finish::grey(Material::Matt, 0.012);
pub(super) const TRIM: Finish = Finish::grey(Material::Matt, 0.025);
pub(super) const GLASS: Finish = Finish::new(Material::Glass, [0.020, 0.024, 0.028]);
pub(super) const CHROME: Finish = Finish::grey(Material::Metal, 0.55);
pub(super) const LAMP: Finish = Finish::grey(Material::Lamp, 0.62);
pub(super) const BRAKE: Finish = Finish::new(Material::BrakeLamp, [0.32, 0.012, 0.012]);

/// How finely a car is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Level {
    /// The nearest two or three cars: rounded, fitted out, with glass that is seen through.
    Near,
    /// Some 3,000 triangles.
    Mid,
    /// Some 900.
    Far,
}

/// Hubs in the body's frame at rest: front left, front right, rear left, rear right.
pub fn hubs() -> [Vec3; 4] {
    let hub = |x: f32, y: f32| Vec3::new(x * WHEELBASE_M, y * TRACK_M, 2.0 * WHEEL_RADIUS_M) / 2.0;
    [hub(1.0, 1.0), hub(1.0, -1.0), hub(-1.0, 1.0), hub(-1.0, -1.0)]
}

/// All body styles; the first is the ego's.
pub fn models() -> Vec<CarModel> {
    let model = |lines| {
        let near = Parts::new(lines, Level::Near);
        let whole = |level| {
            let mut parts = Parts::new(lines, level);
            parts.shell.append(parts.glass);
            parts.shell.append(parts.fittings);
            parts.shell.into_mesh(CREASE_RAD)
        };
        let mut body = near.shell;
        body.append(near.fittings);
        body.append(near.inside);
        CarModel {
            levels: [body.into_mesh(CREASE_RAD), whole(Level::Mid), whole(Level::Far)],
            glass: near.glass.into_mesh(CREASE_RAD),
        }
    };
    STYLES.iter().map(|lines| model(lines)).collect()
}

/// 48 degrees: edges of bonnet and boot are sharp, curved panels are not.
pub(super) const CREASE_RAD: f32 = 0.838;

/// A body in parts.
pub(super) struct Parts {
    /// Skin but for the windows.
    pub shell: Soup,
    /// The windows, which close the shell.
    pub glass: Soup,
    /// What is fixed to the outside.
    pub fittings: Soup,
    /// What is seen through the windows.
    pub inside: Soup,
}

impl Parts {
    pub fn new(lines: &Lines, level: Level) -> Self {
        let ks = scale(level);
        let sections: Vec<Section> = stations(lines, level).iter().map(|&x| Section::new(lines, x, &ks)).collect();
        let [mut shell, mut glass, mut liner] = [Soup::default(), Soup::default(), Soup::default()];
        for pair in sections.windows(2) {
            for (i, k) in ks.iter().enumerate().take(ks.len() - 1) {
                let [a, b] = [&pair[0].points, &pair[1].points];
                let finish = side_finish(lines, level, [pair[0].x, pair[1].x], *k as usize);
                let corners = [a[i], a[i + 1], b[i + 1], b[i]];
                let skin = if finish.material == Material::Glass { &mut glass } else { &mut shell };
                skin.quad(corners, finish);
                let cabin = pair[0].x > lines.cabin_rear_m - 0.01 && pair[1].x < CABIN_FRONT_M + 0.01;
                if cabin && *k as usize >= BELT && finish.material != Material::Glass {
                    let [a, b, c, d] = corners;
                    liner.quad([d, c, b, a], Finish::grey(Material::Matt, 0.03));
                }
            }
        }
        cap(&mut shell, &sections[0], &ks, false);
        cap(&mut shell, &sections[sections.len() - 1], &ks, true);
        let both = |left: Soup| {
            let mut all = left.mirrored();
            all.append(left);
            all
        };
        let mut inside = both(liner);
        inside.append(fittings::cabin(lines));
        Self { shell: both(shell), glass: both(glass), fittings: fittings::outside(lines, level), inside }
    }
}

/// The points of a half section.
fn scale(level: Level) -> Vec<f32> {
    let pieces = |j: usize| match level {
        Level::Near => [1, 1, 2, 3, 3, 3, 2, 1, 4, 1, 3, 3, 3][j],
        Level::Mid => 1,
        Level::Far => 0,
    };
    if level == Level::Far {
        return [0, FLOOR_EDGE, SILL, 4, 5, BELT, ROOF_EDGE, 12, LAST].map(|k| k as f32).into();
    }
    let piece = |j: usize| (0..pieces(j)).map(move |i| j as f32 + i as f32 / pieces(j) as f32);
    (0..LAST).flat_map(piece).chain([LAST as f32]).collect()
}

/// Where the cross-sections are, from the rear to the front.
fn stations(lines: &Lines, level: Level) -> Vec<f32> {
    let rear = lines.cabin_rear_m;
    let mut xs = vec![-2.5, -2.43, -2.28, rear, lines.rear_glass[1], -0.40, 0.24, CABIN_FRONT_M, 1.9, 2.15, 2.47, 2.5];
    let arch: &[f32] = match level {
        Level::Far => &[0.24, ARCH_RADIUS_M, ARCH_RADIUS_M + 0.004],
        _ => &[0.0, 0.13, 0.24, 0.32, 0.36, ARCH_RADIUS_M, ARCH_RADIUS_M + 0.004],
    };
    // Around each wheel arch: its lip rises on a circle and falls by an upright edge on either side.
    for hub in [-WHEELBASE_M / 2.0, WHEELBASE_M / 2.0] {
        xs.extend(arch.iter().flat_map(|dx| [hub - dx, hub + dx]));
    }
    if level != Level::Far {
        xs.extend([-2.49, -2.47, -2.37, -2.14, -2.0, rear - 0.05, -0.82, -0.62, -0.15, 0.12, 0.45, 0.75]);
        xs.extend([CABIN_FRONT_M + 0.07, 2.03, 2.25, 2.33, 2.39, 2.435, 2.465, 2.485]);
        xs.extend(HEAD_LAMP);
        xs.extend(SEAMS.iter().flat_map(|seam| [seam - SEAM_M / 2.0, seam + SEAM_M / 2.0]));
        xs.extend(PILLAR);
        xs.extend(lines.side_glass);
        xs.push(lines.rear_glass[0]);
    }
    xs.sort_by(f32::total_cmp);
    xs.dedup_by(|a, b| *a - *b < 1e-3);
    if level == Level::Near {
        const STEP_M: f32 = 0.10;
        let between = |p: &[f32]| {
            let n = ((p[1] - p[0]) / STEP_M).ceil().max(1.0);
            let (from, step) = (p[0], (p[1] - p[0]) / n);
            (0..n as usize).map(move |i| from + step * i as f32)
        };
        xs = xs.windows(2).flat_map(between).chain([2.5]).collect();
    }
    xs
}

/// Door edges.
const SEAMS: [f32; 3] = [-0.96, -0.01, 0.96];
/// Width of the gap between panels, metres.
const SEAM_M: f32 = 0.012;
/// The pillar between the side windows.
const PILLAR: [f32; 2] = [-0.06, 0.04];
const WINDSCREEN: [f32; 2] = [0.24, CABIN_FRONT_M];
/// Edges of the head lamp's chambers: frame, lamp, web, lamp, frame.
const HEAD_LAMP: [f32; 6] = [2.168, 2.18, 2.28, 2.292, 2.40, 2.412];

/// One half cross-section.
struct Section {
    x: f32,
    points: Vec<Vec3>,
}

impl Section {
    fn new(lines: &Lines, x: f32, ks: &[f32]) -> Self {
        let at = shape::at(lines, x);
        // The side: how far in from the widest, and how far up from sill to belt. Over a wheel the lower lines bunch at
        // the lip of the arch and the upper ones keep their height, so that the panel above it stays smooth.
        let rise = at.belt_z - at.sill_z;
        let side = |k: f32| {
            const LINES: [(f32, f32); 5] = [(0.030, 0.03), (0.012, 0.20), (0.0, 0.44), (0.003, 0.64), (0.022, 0.91)];
            let i = (k as usize).min(3);
            let t = k - i as f32;
            let [inset, up] = [0, 1].map(|axis| {
                let value = |j: usize| if axis == 0 { LINES[j].0 } else { LINES[j].1 };
                through([value(i.saturating_sub(1)), value(i), value(i + 1), value((i + 2).min(4))], t)
            });
            let lip_z = at.floor_z + 0.012 * (k + 1.0);
            Vec2::new(at.half_width - inset, (at.sill_z + rise * up).max(lip_z))
        };
        let height = (at.roof_z - at.belt_z).max(0.12);
        let (low, high) = (0.03 / height, 1.0 - 0.05 / height);
        let top = |k: f32| {
            const INWARDS: [f32; 4] = [1.0, 0.74, 0.40, 0.0];
            let i = (k as usize).min(2);
            let inwards = INWARDS[i] + (INWARDS[i + 1] - INWARDS[i]) * (k - i as f32);
            Vec2::new(at.roof_y * inwards, at.roof_z + (at.top_z - at.roof_z) * (1.0 - inwards * inwards))
        };
        let main = |j: usize| match j {
            0 => Vec2::new(0.0, at.floor_z),
            FLOOR_EDGE => Vec2::new(at.half_width - 0.14, at.floor_z),
            SILL..BELT => side((j - SILL) as f32),
            BELT => Vec2::new(at.belt_y, at.belt_z),
            GLASS_LOW => at.shoulder(low),
            GLASS_HIGH => at.shoulder(high),
            _ => top((j - ROOF_EDGE) as f32),
        };
        let point = |k: f32| {
            let j = k as usize;
            let t = k - j as f32;
            match j {
                _ if t == 0.0 => main(j),
                SILL..=5 => side(k - SILL as f32),
                GLASS_LOW => at.shoulder(low + (high - low) * t),
                ROOF_EDGE.. => top(k - ROOF_EDGE as f32),
                _ => main(j).lerp(main(j + 1), t),
            }
        };
        let points = ks.iter().map(|&k| point(k)).map(|p| Vec3::new(x, p.x, p.y)).collect();
        Self { x, points }
    }
}

/// A smooth curve through the middle two of four values (Catmull and Rom 1974).
fn through([a, b, c, d]: [f32; 4], t: f32) -> f32 {
    0.5 * (2.0 * b + (c - a) * t + (2.0 * a - 5.0 * b + 4.0 * c - d) * t * t + (3.0 * (b - c) + d - a) * t * t * t)
}

/// What the skin is made of between two stations and above the line `j`.
fn side_finish(lines: &Lines, level: Level, [x0, x1]: [f32; 2], j: usize) -> Finish {
    let within = |[low, high]: [f32; 2]| x0 > low - 1e-3 && x1 < high + 1e-3;
    let seam = SEAMS.iter().any(|s| within([s - SEAM_M / 2.0, s + SEAM_M / 2.0]));
    let lamp = [[HEAD_LAMP[1], HEAD_LAMP[2]], [HEAD_LAMP[3], HEAD_LAMP[4]]].into_iter().any(within);
    let window = within(lines.rear_glass) || within(WINDSCREEN);
    match j {
        0 | FLOOR_EDGE => DARK,
        SILL if !(-2.2..=2.2).contains(&x0) => TRIM,
        SILL..=6 if seam => DARK,
        5 | 6 if level == Level::Far && within([2.15, 2.47]) => LAMP,
        5 | 6 if lamp => LAMP,
        5 | 6 if within([HEAD_LAMP[0], HEAD_LAMP[5]]) => DARK,
        5 if within([-2.5, -2.28]) => BRAKE,
        BELT if level != Level::Far && within(lines.side_glass) => CHROME,
        BELT | GLASS_LOW if within(PILLAR) => TRIM,
        GLASS_LOW if within(lines.side_glass) => GLASS,
        BELT if level == Level::Far && within([lines.rear_glass[1], 0.75]) => GLASS,
        GLASS_HIGH if within(lines.side_glass) => TRIM,
        ROOF_EDGE.. if window => GLASS,
        GLASS_LOW.. if within([CABIN_FRONT_M, CABIN_FRONT_M + 0.07]) => TRIM,
        _ => PAINT,
    }
}

/// Closes the left half of an end: the rear (normal towards -x) or the front.
fn cap(soup: &mut Soup, end: &Section, ks: &[f32], front: bool) {
    let outline = &end.points;
    let index = |line: usize| ks.iter().position(|&k| k == line as f32).expect("a main line");
    let (sill, belt) = (index(SILL), index(BELT));
    // Columns stand under the points of the upper outline, so that the cap meets it corner by corner.
    let columns: Vec<f32> = outline[belt..].iter().map(|p| p.y / outline[belt].y).collect();
    let place = |row: usize, column: usize| {
        let p = outline[row];
        Vec3::new(p.x, p.y * columns[column], p.z)
    };
    let mut face = |[a, b, c, d]: [Vec3; 4], finish: Finish| {
        soup.quad(if front { [d, c, b, a] } else { [a, b, c, d] }, finish);
    };
    for column in 0..columns.len() - 1 {
        // The floor has no corners between its middle and its edge, so the lowest row is a fan from there.
        let edge = outline[FLOOR_EDGE];
        face([edge, edge, place(sill, column + 1), place(sill, column)], TRIM);
        for row in sill..belt {
            let (line, across) = (ks[row] as usize, ks[belt + column] as usize - BELT);
            let finish = if front { front_finish(line, across) } else { rear_finish(line, across) };
            face(
                [place(row, column), place(row, column + 1), place(row + 1, column + 1), place(row + 1, column)],
                finish,
            );
        }
        let (outer, inner) = (outline[belt + column], outline[belt + column + 1]);
        face([place(belt, column), place(belt, column + 1), inner, outer], PAINT);
    }
    let middle = place(sill, columns.len() - 1);
    face([outline[FLOOR_EDGE], outline[0], middle, middle], TRIM);
}

fn rear_finish(row: usize, column: usize) -> Finish {
    match (row, column) {
        (SILL, _) => TRIM,
        (5, 0..=3) => BRAKE,
        _ => PAINT,
    }
}

fn front_finish(row: usize, column: usize) -> Finish {
    match (row, column) {
        (SILL, _) | (4 | 5, 3..) => TRIM,
        _ => PAINT,
    }
}

#[cfg(test)]
mod tests {
    use super::super::Mesh;
    use super::super::mesh::tests::{check, faces, open_edges, volume_m3, worst_agreement};
    use super::*;

    /// Every style at every level, windows closed, and how many triangles it may have.
    fn bodies() -> Vec<(Mesh, std::ops::Range<usize>)> {
        let levels = [(Level::Near, 7000..16_000), (Level::Mid, 1500..4800), (Level::Far, 300..1000)];
        let all = STYLES.iter().flat_map(|lines| levels.clone().map(|(level, size)| (*lines, level, size)));
        all.map(|(lines, level, size)| {
            let mut parts = Parts::new(lines, level);
            parts.shell.append(parts.glass);
            parts.shell.append(parts.fittings);
            (parts.shell.into_mesh(CREASE_RAD), size)
        })
        .collect()
    }
    use crate::space::{CAR_LENGTH_M, CAR_WIDTH_M};

    #[test]
    fn every_body_is_as_long_and_wide_as_the_models_believe() {
        for (body, _) in bodies() {
            check(&body, "body");
            let (low, high) = body.bounds();
            let length = f64::from(high.x - low.x);
            assert!((length - CAR_LENGTH_M).abs() < 0.01 && (high.x + low.x).abs() < 0.005, "{low} {high}");
            assert!((1.44..1.46).contains(&high.z), "{high}");
            assert!(high.y <= 1.0 && (high.y + low.y).abs() < 1e-5, "mirrors: {low} {high}");
            // Without the mirrors, which stand at 0.92 m and higher.
            let widest =
                body.vertices.iter().filter(|v| v.position[2] < 0.9).map(|v| v.position[1]).fold(0.0, f32::max);
            assert!((f64::from(widest) * 2.0 - CAR_WIDTH_M).abs() < 0.01, "{widest}");
        }
    }

    #[test]
    fn every_body_is_closed_and_faces_outwards() {
        for (body, size) in bodies() {
            assert_eq!(open_edges(&body), 0);
            // 5.0 x 1.8 x 1.45 m filled by a bit more than half.
            assert!((5.5..8.6).contains(&volume_m3(&body)), "{}", volume_m3(&body));
            assert!(worst_agreement(&body) > 0.5, "{}", worst_agreement(&body));
            assert!(size.contains(&body.triangles()), "{} not in {size:?}", body.triangles());
        }
        for model in models() {
            check(&model.glass, "glass");
            assert!(model.levels[0].triangles() < 18_000, "{}", model.levels[0].triangles());
        }
    }

    #[test]
    fn near_and_far_levels_have_one_outline() {
        // Width and height of every 25 cm of the body differ by less than a pixel at the distance of the switch: 2.5 cm
        // near to mid (30 m, 1280 pixels), 6 cm mid to far.
        for levels in bodies().chunks(3) {
            let outline = |mesh: &Mesh| {
                let mut slices = [(0f32, 0f32); 20];
                for (corners, _) in faces(mesh) {
                    let [a, b, c] = corners.map(|v| Vec3::from(v.position));
                    for (k, slice) in slices.iter_mut().enumerate() {
                        let x = -2.371 + 0.25 * k as f32;
                        for (p, q) in [(a, b), (b, c), (c, a)] {
                            if (p.x - x) * (q.x - x) < 0.0 {
                                let at = p.lerp(q, (x - p.x) / (q.x - p.x));
                                // Mirrors aside.
                                let wide = if at.z < 0.89 { at.y } else { 0.0 };
                                *slice = (slice.0.max(wide), slice.1.max(at.z));
                            }
                        }
                    }
                }
                slices
            };
            let [near, mid, far] = [0, 1, 2].map(|k| outline(&levels[k].0));
            for k in 0..20 {
                let off = |a: (f32, f32), b: (f32, f32)| (a.0 - b.0).abs().max((a.1 - b.1).abs());
                let mirrors = (11..=13).contains(&k);
                assert!(mirrors || off(near[k], mid[k]) < 0.025, "slice {k}: {:?} {:?}", near[k], mid[k]);
                assert!(mirrors || off(mid[k], far[k]) < 0.06, "slice {k}: {:?} {:?}", mid[k], far[k]);
            }
        }
    }

    #[test]
    fn wheels_touch_the_ground_and_fit_their_arches() {
        for hub in hubs() {
            assert_eq!(hub.z, WHEEL_RADIUS_M);
            for v in bodies().iter().flat_map(|(body, _)| &body.vertices) {
                let p = Vec3::from(v.position);
                let away = Vec2::new(p.x - hub.x, p.z - hub.z).length();
                let beside = (p.y - hub.y).abs() < 0.11;
                assert!(!beside || away > WHEEL_RADIUS_M + 0.02, "{p} in the wheel at {hub}");
            }
        }
    }

    #[test]
    fn lamps_are_where_lamps_are() {
        for (body, _) in bodies() {
            let middle = |material: Material| -> Vec<Vec3> {
                let of = |v: &super::super::Vertex| v.material == material as u32;
                faces(&body)
                    .filter(|(corners, _)| of(&corners[0]))
                    .map(|(corners, _)| corners.iter().map(|v| Vec3::from(v.position)).sum::<Vec3>() / 3.0)
                    .collect()
            };
            let brake = middle(Material::BrakeLamp);
            assert!(brake.iter().any(|p| p.y > 0.4) && brake.iter().any(|p| p.y < -0.4), "left and right");
            assert!(brake.iter().any(|p| p.z > 1.3 && p.y.abs() < 0.1), "the third, high");
            assert!(brake.iter().filter(|p| p.z < 1.0).all(|p| p.x < -2.2));
            let head: Vec<Vec3> = middle(Material::Lamp).into_iter().filter(|p| p.x > 0.0).collect();
            assert!(!head.is_empty() && head.iter().all(|p| p.x > 2.1 && p.y.abs() > 0.3));
        }
    }
}
