//! Plates of road signs. In: kind and size of a sign. Out: a plate around its middle, metres. Signs and their sizes are German
//! (`docs/references.md: roads`).

use super::{
    sign_kind::{MOTORWAY_MPS, SignKind},
    signals::STEEL,
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

/// Distance between two layers of a plate, metres. Positions 10 km from the scene's origin are rounded to half a millimetre, and the depth buffer
/// must still tell the layers apart. A larger distance would shift the lettering over the plate's edge for those who see it from the side.
const RAISED_M: f32 = 0.003;
/// Tolerance for omitted points of letters, as a share of their height.
const COARSE: f32 = 0.02;

const RED: SurfaceFinish = SurfaceFinish::new(Material::Reflector, [0.42, 0.012, 0.012]);
const WHITE: SurfaceFinish = SurfaceFinish::grey(Material::Reflector, 0.72);
const YELLOW: SurfaceFinish = SurfaceFinish::new(Material::Reflector, [0.72, 0.42, 0.01]);
const BLUE: SurfaceFinish = SurfaceFinish::new(Material::Reflector, [0.012, 0.07, 0.33]);
const BLACK: SurfaceFinish = SurfaceFinish::grey(Material::Matt, 0.012);

/// Number of letters up to which signs show a name in full, and above which boards show it in two lines.
const MOST_LETTERS: usize = 24;
const ONE_LINE_LETTERS: usize = 12;
/// Height of capitals of names, metres: of a street, a place, and the road after an exit.
const STREET_LETTER_M: f32 = 0.10;
const PLACE_LETTER_M: f32 = 0.17;
const EXIT_LETTER_M: f32 = 0.28;
/// Distance between the baselines of two lines of a name, and of its accents and tails to the plate's edge, as shares of the letters' height.
const LINE: f32 = 1.75;
const MARGIN: f32 = 0.5;
/// Width of the frame of a plate with a name, and of the room for the arrow on the board of an exit, metres.
const FRAME_M: f32 = 0.012;
const ARROW_M: f32 = 0.9;

/// Size of a plate.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlateSize {
    /// Diameter of discs and octagons, side of triangles and squares, height of beacons, height of the letters of a name, metres.
    pub size_m: f32,
    pub half_width_m: f32,
    pub half_height_m: f32,
}

/// Returns true for the larger signs of fast roads: discs above 80 km/h, triangles and squares above 100 km/h, with a margin for rounding.
pub(super) fn is_large(kind: SignKind, limit_mps: f64) -> bool {
    match kind {
        SignKind::SpeedLimit(_) | SignKind::Roundabout => limit_mps > 22.5,
        SignKind::Yield | SignKind::Zebra | SignKind::Priority => limit_mps > MOTORWAY_MPS,
        _ => false,
    }
}

/// Returns the size of a sign's plate.
pub(super) fn size_m(kind: SignKind, is_large: bool) -> PlateSize {
    let equal = |size_m: f32| PlateSize { size_m, half_width_m: size_m / 2.0, half_height_m: size_m / 2.0 };
    let lettered = |lines: &[String], size_m: f32, aside_m: f32, least: [f32; 2]| {
        let width_m = lines.iter().map(|line| lettering::set(line).width * size_m).fold(0.0, f32::max);
        let margins_m = 2.0 * (MARGIN + lettering::PEN) * size_m;
        let height_m = (lines.len() as f32 - 1.0) * LINE * size_m + size_m + margins_m;
        let half = |length_m: f32, least_m: f32| length_m.max(least_m) / 2.0;
        let half_width_m = half(width_m + margins_m + aside_m, least[0]);
        PlateSize { size_m, half_width_m, half_height_m: half(height_m, least[1]) }
    };
    match (kind, is_large) {
        (SignKind::Stop, _) => equal(0.9),
        (SignKind::Yield, _) => {
            let size_m: f32 = if is_large { 1.26 } else { 0.9 };
            PlateSize { half_height_m: size_m * 0.75f32.sqrt() / 2.0, ..equal(size_m) }
        }
        (SignKind::Priority, _) => {
            let size_m: f32 = if is_large { 0.84 } else { 0.6 };
            let half_m = size_m * 0.5f32.sqrt();
            PlateSize { size_m, half_width_m: half_m, half_height_m: half_m }
        }
        (SignKind::Exit, _) => equal(1.6),
        (SignKind::ExitAhead(_), _) => PlateSize { half_width_m: 0.225, ..equal(1.5) },
        (SignKind::Zebra, true) => equal(0.84),
        (SignKind::SpeedLimit(_) | SignKind::Roundabout, true) => equal(0.75),
        (SignKind::Zebra | SignKind::SpeedLimit(_) | SignKind::Roundabout, false) => equal(0.6),
        (SignKind::StreetName(name), _) => lettered(&[short(name)], STREET_LETTER_M, 0.0, [0.0, 0.0]),
        (SignKind::PlaceName(name), _) => lettered(&in_lines(name), PLACE_LETTER_M, 0.0, [1.0, 0.55]),
        (SignKind::ExitBoard(name), _) => {
            let lines = name.map(in_lines).unwrap_or_default();
            match lines.len() {
                0 => PlateSize { size_m: EXIT_LETTER_M, ..equal(1.2) },
                _ => lettered(&lines, EXIT_LETTER_M, ARROW_M, [0.0, 1.1]),
            }
        }
    }
}

/// Returns a name as signs show it: long ones are cut.
fn short(name: &str) -> String {
    if name.chars().count() <= MOST_LETTERS {
        return name.to_owned();
    }
    let kept: String = name.chars().take(MOST_LETTERS - 1).collect();
    format!("{}.", kept.trim_end_matches([' ', '-', '.', ',', '/']))
}

/// Returns a short name in one line, or a longer one in two, divided at the blank or hyphen that is nearest to its middle.
fn in_lines(name: &str) -> Vec<String> {
    let name = short(name);
    let middle = name.len() / 2;
    let cuts = name.match_indices([' ', '-']).map(|(at, _)| at + 1);
    match cuts.min_by_key(|at| at.abs_diff(middle)) {
        Some(at) if name.chars().count() > ONE_LINE_LETTERS => {
            [&name[..at], &name[at..]].map(|line| line.trim().to_owned()).to_vec()
        }
        _ => vec![name],
    }
}

/// Returns a plate around its middle that faces along +x. Seen from before it, +y is to the right. With left-hand traffic arrows lead to the other
/// side.
pub(super) fn plate(kind: SignKind, size: PlateSize, is_left_hand: bool) -> TriangleList {
    let side = if is_left_hand { -1.0 } else { 1.0 };
    let mut plate = Plate { triangles: TriangleList::default(), side };
    let round = |radius_m: f32, corners: usize, turn: f32| -> Vec<Vec2> {
        let angle = |k: usize| TAU * (k as f32 + turn) / corners as f32;
        (0..corners).map(|k| Vec2::from_angle(angle(k)) * radius_m).collect()
    };
    let PlateSize { size_m, half_width_m, half_height_m } = size;
    let half_m = size_m / 2.0;
    let board = |inset_m: f32| {
        let half = Vec2::new(half_width_m, half_height_m) - inset_m;
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(y, z)| Vec2::new(y, z) * half)
    };
    match kind {
        SignKind::Stop => {
            // The diameter is that between two parallel sides.
            let corner_m = half_m / (PI / 8.0).cos();
            let [outer, inner] = [corner_m, corner_m * 0.94].map(|radius_m| round(radius_m, 8, 0.5));
            plate.frame(&outer, &inner, WHITE);
            plate.area(&inner, RED);
            plate.text("STOP", Vec2::ZERO, size_m * 0.27, WHITE);
        }
        SignKind::Yield => {
            // An equilateral triangle with its tip down; its corners are cut. Its centre is above the plate's middle.
            let height_m = 2.0 * half_height_m;
            let centre = Vec2::new(0.0, height_m / 6.0);
            let triangle = |share: f32| {
                let corners =
                    [(-0.5, 1.0), (0.0, -2.0), (0.5, 1.0)].map(|(y, z)| Vec2::new(y * size_m, z * height_m / 3.0));
                let cut = |k: usize, to: usize| corners[k].lerp(corners[to], 0.05) * share + centre;
                [cut(0, 2), cut(0, 1), cut(1, 0), cut(1, 2), cut(2, 1), cut(2, 0)].to_vec()
            };
            let [outer, inner] = [triangle(1.0), triangle(0.64)];
            plate.frame(&outer, &inner, RED);
            plate.area(&inner, WHITE);
        }
        SignKind::Priority => {
            let [outer, inner] = [half_width_m, half_width_m * 0.72].map(|radius_m| round(radius_m, 4, 0.0));
            plate.frame(&outer, &inner, WHITE);
            plate.area(&inner, YELLOW);
        }
        SignKind::Zebra => {
            let [outer, inner] = [1.0, 0.94].map(|share| round(half_m * share * SQRT_2, 4, 0.5));
            plate.frame(&outer, &inner, WHITE);
            plate.area(&inner, BLUE);
            let triangle = [(0.0, 0.76), (-0.8, -0.66), (0.8, -0.66)].map(|(y, z)| Vec2::new(y, z) * half_m);
            plate.raised_area(&triangle, RAISED_M, WHITE);
            plate.walker(half_m);
        }
        SignKind::Exit => {
            plate.framed(&board(0.0), &board(0.06 * half_m), WHITE, BLUE);
            plate.exit_arrow(Vec2::ZERO, half_m);
        }
        SignKind::ExitAhead(bars) => {
            plate.framed(&board(0.0), &board(0.042 * half_m), WHITE, BLUE);
            for bar in 0..bars {
                // The bars rise to the right, towards the exit, or to the left with left-hand traffic.
                let z = (bar as f32 - (bars as f32 - 1.0) / 2.0) * 0.5 * half_m;
                let ends = [(-0.22, -0.13), (0.22, 0.13)].map(|(y, up)| Vec2::new(y * half_m * side, z + up * half_m));
                plate.stroke(ends, 0.075 * half_m, WHITE);
            }
        }
        SignKind::Roundabout => {
            let [outer, inner] = [half_m, half_m * 0.95].map(|radius_m| round(radius_m, 24, 0.0));
            plate.framed(&outer, &inner, WHITE, BLUE);
            plate.turning_arrows(half_m);
        }
        SignKind::StreetName(name) => {
            plate.framed(&board(0.0), &board(FRAME_M / 2.0), WHITE, BLUE);
            plate.lines(&[short(name)], Vec2::ZERO, size_m, WHITE);
        }
        SignKind::PlaceName(name) => {
            plate.framed(&board(0.0), &board(FRAME_M), YELLOW, YELLOW);
            plate.frame_before(&board(FRAME_M), &board(3.0 * FRAME_M), BLACK);
            plate.lines(&in_lines(name), Vec2::ZERO, size_m, BLACK);
        }
        SignKind::ExitBoard(name) => {
            plate.framed(&board(0.0), &board(2.0 * FRAME_M), WHITE, BLUE);
            let arrow_half_m = if name.is_some() { ARROW_M / 2.0 } else { half_width_m };
            plate.exit_arrow(Vec2::new(side * (half_width_m - arrow_half_m), 0.0), arrow_half_m);
            let lines = name.map(in_lines).unwrap_or_default();
            plate.lines(&lines, Vec2::new(-side * ARROW_M / 2.0, 0.0), size_m, WHITE);
        }
        SignKind::SpeedLimit(limit) => {
            let [outer, inner] = [half_m, half_m * 0.78].map(|radius_m| round(radius_m, 24, 0.0));
            plate.frame(&outer, &inner, RED);
            plate.area(&inner, WHITE);
            let height = if limit < 100 { 0.42 } else { 0.32 };
            plate.text(&limit.to_string(), Vec2::ZERO, size_m * height, BLACK);
        }
    }
    plate.triangles
}

/// Builder of a plate that faces along +x. Outlines of frames are counter-clockwise, seen from before the plate.
struct Plate {
    triangles: TriangleList,
    /// -1 where arrows lead to the left, with left-hand traffic; 1 otherwise.
    side: f32,
}

impl Plate {
    /// Adds a convex area.
    fn area(&mut self, outline: &[Vec2], finish: SurfaceFinish) {
        self.raised_area(outline, 0.0, finish);
    }

    /// Adds a convex area, `off_m` before the plate.
    fn raised_area(&mut self, outline: &[Vec2], off_m: f32, finish: SurfaceFinish) {
        for k in 1..outline.len() - 1 {
            let [a, b, c] = [outline[0], outline[k], outline[k + 1]];
            // Mirrored outlines are clockwise.
            let corners = if (b - a).perp_dot(c - a) < 0.0 { [a, c, b] } else { [a, b, c] };
            self.triangles.triangle(corners.map(|p| on(p, off_m)), finish);
        }
    }

    /// Adds a convex area within a frame.
    fn framed(&mut self, outer: &[Vec2], inner: &[Vec2], frame: SurfaceFinish, area: SurfaceFinish) {
        self.frame(outer, inner, frame);
        self.area(inner, area);
    }

    /// Adds a frame before the plate, between two outlines with equally many corners.
    fn frame_before(&mut self, outer: &[Vec2], inner: &[Vec2], finish: SurfaceFinish) {
        for k in 0..outer.len() {
            let next = (k + 1) % outer.len();
            self.raised_area(&[outer[k], outer[next], inner[next], inner[k]], RAISED_M, finish);
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

    /// Adds an arrow that rises to the right, or to the left with left-hand traffic, within `half_m` of a point.
    fn exit_arrow(&mut self, middle: Vec2, half_m: f32) {
        let side = self.side;
        let at = |y: f32, z: f32| Vec2::new(y * side, z) * half_m + middle;
        self.stroke([at(-0.5, -0.5), at(0.2, 0.2)], 0.1 * half_m, WHITE);
        let head = [at(0.55, 0.55), at(-0.02, 0.38), at(0.38, -0.02)];
        self.raised_area(&head, 2.0 * RAISED_M, WHITE);
    }

    /// Adds three arrows around the middle, counter-clockwise, or clockwise with left-hand traffic.
    fn turning_arrows(&mut self, half_m: f32) {
        const PIECES: u8 = 6;
        let side = self.side;
        let at = |degrees: f32, radius: f32| {
            let along = Vec2::from_angle(degrees.to_radians());
            Vec2::new(along.x * side, along.y) * radius * half_m
        };
        for arrow in 0..3u8 {
            // Each begins where the tip of the one before it ends: 62 degrees of bow and 42 of head, from the lower right on.
            let start = f32::from(arrow) * 120.0 - 35.0;
            let bow = |k: u8, radius: f32| at(start + 62.0 * f32::from(k) / f32::from(PIECES), radius);
            for k in 0..PIECES {
                let corners = [bow(k, 0.48), bow(k, 0.66), bow(k + 1, 0.66), bow(k + 1, 0.48)];
                self.raised_area(&corners, RAISED_M, WHITE);
            }
            let head = [at(start + 58.0, 0.33), at(start + 58.0, 0.82), at(start + 104.0, 0.58)];
            self.raised_area(&head, RAISED_M, WHITE);
        }
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

    /// Adds a line of text around a point, `height_m` high.
    fn text(&mut self, text: &str, middle: Vec2, height_m: f32, finish: SurfaceFinish) {
        let half_m = lettering::PEN / 2.0 * height_m;
        for stroke in lettering::set(text).strokes {
            let points: Vec<Vec2> =
                stroke.into_iter().map(|[right, down]| Vec2::new(right, -down) * height_m + middle).collect();
            for pair in thinned(&points, COARSE * height_m).windows(2) {
                self.stroke([pair[0], pair[1]], half_m, finish);
            }
        }
    }

    /// Adds lines of text below each other around a point, letters `height_m` high.
    fn lines(&mut self, lines: &[String], middle: Vec2, height_m: f32, finish: SurfaceFinish) {
        for (k, line) in lines.iter().enumerate() {
            let up_m = ((lines.len() as f32 - 1.0) / 2.0 - k as f32) * LINE * height_m;
            self.text(line, middle + Vec2::Y * up_m, height_m, finish);
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
    fn a_plate_shows_its_colours_to_the_front_alone_and_keeps_its_size() {
        let kinds = [
            SignKind::Stop,
            SignKind::Yield,
            SignKind::Roundabout,
            SignKind::Zebra,
            SignKind::Priority,
            SignKind::SpeedLimit(80),
            SignKind::StreetName("Karl-Marx-Straße"),
            SignKind::PlaceName("Île-Saint-Gély"),
            SignKind::ExitBoard(Some("Bad Königshofen Ågård")),
            SignKind::ExitBoard(None),
            SignKind::Exit,
            SignKind::ExitAhead(3),
        ];
        for (kind, is_left_hand) in kinds.into_iter().flat_map(|kind| [(kind, false), (kind, true)]) {
            let size = size_m(kind, false);
            let bound = [size.half_width_m, size.half_height_m].map(|half_m| half_m + 1e-4);
            for (corners, face) in faces(&plate(kind, size, is_left_hand).into_mesh(0.3)) {
                let is_back = corners[0].colour == STEEL.colour;
                assert_eq!(face.x > 0.0, !is_back, "{kind:?}: {corners:?}");
                let is_within = |p: [f32; 3]| p[1].abs() <= bound[0] && p[2].abs() <= bound[1];
                assert!(corners.iter().all(|corner| is_within(corner.position)), "{kind:?}: {corners:?} {size:?}");
            }
        }
    }

    #[test]
    fn names_stay_on_their_plates_seen_from_75_degrees_aside() {
        // From there a plate is a quarter as wide as from in front, and its name can hardly be read.
        let slope = 75f32.to_radians().tan();
        let names = [
            SignKind::StreetName("Field Lane"),
            SignKind::PlaceName("Île-Saint-Gély"),
            SignKind::ExitBoard(Some("Bad Königshofen Ågård")),
        ];
        for kind in names {
            let size = size_m(kind, false);
            let mesh = plate(kind, size, false).into_mesh(0.3);
            let furthest = mesh.vertices.iter().map(|v| v.position[1].abs() + v.position[0].max(0.0) * slope);
            let furthest_m = furthest.fold(0.0, f32::max);
            assert!(furthest_m <= size.half_width_m + 1e-4, "{kind:?}: {furthest_m} of {} m", size.half_width_m);
        }
    }

    #[test]
    fn long_names_are_cut_and_divided_at_a_blank() {
        let long = "Doktor-Wilhelm-Külz-Straße West";
        assert_eq!(short("Sonnenallee"), "Sonnenallee");
        assert_eq!(short(long), "Doktor-Wilhelm-Külz-Str.");
        assert_eq!(in_lines("Sonnenallee"), ["Sonnenallee"]);
        assert_eq!(in_lines("Straße am Flughafen"), ["Straße am", "Flughafen"]);
        assert_eq!(in_lines(long), ["Doktor-Wilhelm-", "Külz-Str."]);
    }
}
