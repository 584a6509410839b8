//! Closed circuits from a list of pieces. In: a `circuit.toml` of straights and bends. Out: a map's folder. The curvature of a bend rises
//! linearly (a clothoid), stays constant and falls linearly, so that the steering wheel turns without jerks. Two straights get the length
//! that closes the circuit. Metres, m/s; angles in degrees in the file, radians inside.

use super::{
    MapError, catalog,
    circuit_fault::{CircuitFault, LONGEST_M, MOST_PIECES, SHORTEST_M},
    write::{RoadEdge, net_xml, write_folder},
};
use crate::{
    file::{SETTINGS_BYTES, read_bounded},
    private,
    toml_text::{self, KeyPart},
};
use glam::{DMat2, DVec2};
use serde::Deserialize;
use std::path::Path;

/// Free ground required between two parts of the lane that are not neighbours, metres.
const CLEARANCE_M: f64 = 15.0;
/// Distance along the lane up to which parts are neighbours, metres.
const NEIGHBOURS_M: f64 = 60.0;
/// Circuit as its file describes it.
#[derive(Clone, Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Circuit {
    /// Title in one line.
    title: String,
    /// Purpose of the map.
    description: String,
    /// Width of the lane, m.
    #[schemars(range(min = 2.5, max = 10.0), extend("unit" = "m"))]
    width_m: f64,
    /// Speed limit of pieces without one of their own, m/s.
    #[schemars(range(min = 1.0, max = 100.0), extend("unit" = "m/s"))]
    speed_limit_mps: f64,
    /// Pieces in their order; two of them are solved.
    #[serde(rename = "piece")]
    #[schemars(length(max = 200))]
    pieces: Vec<CircuitPiece>,
}

/// One piece: `straight_m`, or `solved`, or the three numbers of a bend.
#[derive(Clone, Debug, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
struct CircuitPiece {
    /// Length of a straight, m.
    #[schemars(range(min = 10.0, max = 5000.0), extend("unit" = "m"))]
    straight_m: Option<f64>,
    /// True for a straight with the length that closes the circuit.
    #[serde(default)]
    solved: bool,
    /// Radius of the arc of a bend, m.
    #[schemars(range(min = 10.0, max = 5000.0), extend("unit" = "m"))]
    radius_m: Option<f64>,
    /// Angle by which a bend turns, degrees, positive to the left.
    #[schemars(range(min = -270.0, max = 270.0), extend("unit" = "deg"))]
    turn_deg: Option<f64>,
    /// Length of the clothoid at each end of a bend, m.
    #[schemars(range(min = 1.0), extend("unit" = "m"))]
    easing_m: Option<f64>,
    /// Speed limit of the piece, m/s.
    #[schemars(range(min = 1.0, max = 100.0), extend("unit" = "m/s"))]
    speed_limit_mps: Option<f64>,
}

/// Piece as geometry. A straight has curvature 0 and no turn.
#[derive(Clone, Copy, Debug)]
struct PieceGeometry {
    length_m: f64,
    easing_m: f64,
    /// Curvature of the arc, 1/m, positive to the left.
    curvature: f64,
    turn_deg: f64,
    solved: bool,
    speed_limit_mps: f64,
}

/// Network made from a circuit's file.
#[derive(Clone, Debug)]
pub struct GeneratedNetwork {
    /// Title in one line.
    pub title: String,
    /// Purpose of the map.
    pub description: String,
    /// Text of the `net.xml`.
    pub net_xml: String,
}

/// Makes the network of a `circuit.toml`.
///
/// # Errors
/// The file is absent or has unknown keys or invalid values; its bends do not add up to one turn; there are not two solved straights that
/// can close it; or two parts of the lane come too close.
pub fn make(file: &Path) -> Result<GeneratedNetwork, MapError> {
    let text = catalog::read_settings(file)?;
    let name = file.display().to_string();
    let problem = |problem: CircuitFault| MapError::Circuit { file: file.into(), problem };
    let (circuit, mut mistakes) = toml_text::read::<Circuit>(&text, &name);
    let mut curves = Vec::new();
    if let Some(circuit) = &circuit {
        if circuit.pieces.len() > MOST_PIECES {
            return Err(problem(CircuitFault::ManyPieces(circuit.pieces.len())));
        }
        for (i, piece) in circuit.pieces.iter().enumerate() {
            match PieceGeometry::new(piece, circuit.speed_limit_mps) {
                Ok(curve) => curves.push(curve),
                Err(faults) => faults.into_iter().for_each(|(key, why)| {
                    // The speed limit of a piece may come from the whole circuit.
                    let own = format!("piece.{i}.{key}").trim_end_matches('.').to_owned();
                    let is_own = key != "speed_limit_mps" || piece.speed_limit_mps.is_some();
                    mistakes.add(if is_own { &own } else { key }, KeyPart::Value, &format!("piece {}: {why}", i + 1));
                }),
            }
        }
        if !(2.5..=10.0).contains(&circuit.width_m) {
            let message = format!("width_m is {}; allowed: 2.5 to 10", circuit.width_m);
            mistakes.add("width_m", KeyPart::Value, &message);
        }
    }
    let circuit = toml_text::finished((circuit, mistakes)).map_err(|e| MapError::Toml(e.to_string()))?;
    check_length(&curves).map_err(problem)?;
    let curves = close(curves).map_err(problem)?;
    check_length(&curves).map_err(problem)?;
    let road = centred(lay(&curves, circuit.width_m));
    check_clearance(&road).map_err(problem)?;
    let comment = "A circuit made by codrive from circuit.toml.";
    Ok(GeneratedNetwork { title: circuit.title, description: circuit.description, net_xml: net_xml(comment, &road) })
}

/// Writes the circuit of `file` as a new map's `folder`, with a copy of the file.
///
/// # Errors
/// As [`make`], or the folder exists or cannot be written.
pub fn write(folder: &Path, file: &Path) -> Result<(), MapError> {
    let made = make(file)?;
    write_folder(folder, &made.net_xml, &made.title, &made.description)?;
    let copied =
        read_bounded(file, SETTINGS_BYTES).and_then(|text| private::replace(&folder.join("circuit.toml"), &text));
    copied.map_err(|source| MapError::Io { file: folder.into(), source })
}

impl PieceGeometry {
    /// Checks and converts a piece. The error is each key at fault with a message; the key is empty if the piece is none of the three
    /// kinds.
    fn new(piece: &CircuitPiece, default_mps: f64) -> Result<Self, Vec<(&'static str, String)>> {
        let limit_mps = piece.speed_limit_mps.unwrap_or(default_mps);
        let mut faults = Vec::new();
        let mut check = |name: &'static str, value: f64, low: f64, high: f64| {
            if !(low..=high).contains(&value) {
                faults.push((name, format!("{name} is {value}; allowed: {low} to {high}")));
            }
        };
        check("speed_limit_mps", limit_mps, 1.0, 100.0);
        let straight = |length_m, solved| Self {
            length_m,
            easing_m: 0.0,
            curvature: 0.0,
            turn_deg: 0.0,
            solved,
            speed_limit_mps: limit_mps,
        };
        let made = match (piece.straight_m, piece.solved, piece.radius_m, piece.turn_deg, piece.easing_m) {
            (Some(length_m), false, None, None, None) => {
                check("straight_m", length_m, SHORTEST_M, 5000.0);
                straight(length_m, false)
            }
            (None, true, None, None, None) => straight(0.0, true),
            (None, false, Some(radius_m), Some(turn_deg), Some(easing_m)) => {
                check("radius_m", radius_m, 10.0, 5000.0);
                check("turn_deg", turn_deg.abs(), 1.0, 270.0);
                let turned_m = radius_m * turn_deg.abs().to_radians();
                if (10.0..=5000.0).contains(&radius_m) && (1.0..=270.0).contains(&turn_deg.abs()) {
                    check("easing_m", easing_m, 1.0, turned_m);
                }
                // Each easing turns by easing / (2 radius), the arc between them by the rest.
                let (length_m, curvature) = (turned_m + easing_m, turn_deg.signum() / radius_m);
                Self { length_m, easing_m, curvature, turn_deg, ..straight(0.0, false) }
            }
            _ => {
                let text = "a piece has either straight_m, or solved = true, or radius_m, turn_deg and easing_m";
                faults.push(("", text.into()));
                straight(0.0, true)
            }
        };
        if faults.is_empty() { Ok(made) } else { Err(faults) }
    }

    /// Returns the angle that the lane has turned `t_m` into the piece, radians: the integral of the curvature's trapezoid.
    fn turned(&self, t_m: f64) -> f64 {
        let (length_m, easing_m) = (self.length_m, self.easing_m);
        let at_full_m = if easing_m == 0.0 {
            t_m
        } else if t_m < easing_m {
            t_m * t_m / (2.0 * easing_m)
        } else if t_m < length_m - easing_m {
            t_m - easing_m / 2.0
        } else {
            length_m - easing_m - (length_m - t_m).powi(2) / (2.0 * easing_m)
        };
        self.curvature * at_full_m
    }

    /// Returns points at most 1 m apart (straights: 10 m), relative to the piece's start, where it heads `yaw_rad`.
    fn points(&self, yaw_rad: f64) -> Vec<DVec2> {
        // The chord of 1 m sags 5 mm at a radius of 25 m; there the points are 0.84 m apart and sag 3.5 mm.
        let chord_m = if self.curvature == 0.0 { 10.0 } else { (0.028 / self.curvature.abs()).sqrt().min(1.0) };
        let n = (self.length_m / chord_m).ceil().max(1.0);
        let step_m = self.length_m / n;
        let mut point = DVec2::ZERO;
        let mut points = vec![point];
        for k in 0..n as usize {
            // Gauss-Legendre with three nodes: error of order seven, 1e-15 m over a metre of these bends.
            let middle_m = (k as f64 + 0.5) * step_m;
            let heading = |node: f64| DVec2::from_angle(yaw_rad + self.turned(middle_m + node * step_m / 2.0));
            let node = 0.6f64.sqrt();
            point += (heading(-node) * 5.0 + heading(0.0) * 8.0 + heading(node) * 5.0) / 18.0 * step_m;
            points.push(point);
        }
        points
    }
}

fn check_length(curves: &[PieceGeometry]) -> Result<(), CircuitFault> {
    let length_m: f64 = curves.iter().map(|curve| curve.length_m).sum();
    if length_m <= LONGEST_M { Ok(()) } else { Err(CircuitFault::TooLong { length_m }) }
}

/// Returns the heading at the start of each piece, radians; the first heads east.
fn headings(curves: &[PieceGeometry]) -> Vec<f64> {
    // Summed in degrees, in which the numbers of the file are exact.
    let mut turned_deg = 0.0;
    let heading = |curve: &PieceGeometry| {
        let here = f64::to_radians(turned_deg);
        turned_deg += curve.turn_deg;
        here
    };
    curves.iter().map(heading).collect()
}

/// Sets the lengths of the two solved straights so that the end meets the start.
fn close(mut curves: Vec<PieceGeometry>) -> Result<Vec<PieceGeometry>, CircuitFault> {
    let turn_deg: f64 = curves.iter().map(|curve| curve.turn_deg).sum();
    if (turn_deg.abs() - 360.0).abs() > 1e-9 {
        return Err(CircuitFault::Open { turn_deg });
    }
    let headings = headings(&curves);
    let solved: Vec<usize> = (0..curves.len()).filter(|&k| curves[k].solved).collect();
    let &[first, second] = solved.as_slice() else {
        return Err(CircuitFault::NotTwoSolved(solved.len()));
    };
    let directions = DMat2::from_cols(DVec2::from_angle(headings[first]), DVec2::from_angle(headings[second]));
    if directions.determinant().abs() < 0.1 {
        return Err(CircuitFault::Parallel { pieces: [first + 1, second + 1] });
    }
    let step = |k: usize| curves[k].points(headings[k]).last().copied().unwrap_or_default();
    let open: DVec2 = (0..curves.len()).filter(|&k| !curves[k].solved).map(step).sum();
    let lengths = directions.inverse() * -open;
    for (k, length_m) in [(first, lengths.x), (second, lengths.y)] {
        if length_m < SHORTEST_M {
            return Err(CircuitFault::TooShort { piece: k + 1, length_m });
        }
        curves[k].length_m = length_m;
    }
    Ok(curves)
}

/// Makes one edge per piece, the first starting at the origin.
fn lay(curves: &[PieceGeometry], width_m: f64) -> Vec<RoadEdge> {
    let headings = headings(curves);
    let mut start = DVec2::ZERO;
    let mut road = Vec::new();
    for (k, curve) in curves.iter().enumerate() {
        let mut shape: Vec<DVec2> = curve.points(headings[k]).into_iter().map(|step| start + step).collect();
        start = shape[shape.len() - 1];
        if k + 1 == curves.len() {
            // The two points differ by rounding only, 1e-12 m.
            shape.pop();
            shape.push(DVec2::ZERO);
        }
        road.push(RoadEdge { length_m: curve.length_m, speed_limit_mps: curve.speed_limit_mps, width_m, shape });
    }
    road
}

/// Moves the middle of the bounding box to the origin.
fn centred(mut road: Vec<RoadEdge>) -> Vec<RoadEdge> {
    let points = || road.iter().flat_map(|edge| &edge.shape);
    let low = points().fold(DVec2::INFINITY, |low, point| low.min(*point));
    let high = points().fold(DVec2::NEG_INFINITY, |high, point| high.max(*point));
    for point in road.iter_mut().flat_map(|edge| &mut edge.shape) {
        *point -= (low + high) / 2.0;
    }
    road
}

/// Refuses a lane that comes too close to another part of itself, or crosses it.
fn check_clearance(road: &[RoadEdge]) -> Result<(), CircuitFault> {
    let mut points = Vec::new();
    let mut start_m = 0.0;
    for (piece, edge) in road.iter().enumerate() {
        for (k, point) in edge.shape.iter().enumerate() {
            let s_m = start_m + edge.length_m * k as f64 / (edge.shape.len() - 1) as f64;
            points.push((piece + 1, s_m, *point));
        }
        start_m += edge.length_m;
    }
    let wanted_m = CLEARANCE_M + road[0].width_m;
    for (k, (piece, s_m, point)) in points.iter().enumerate() {
        for (other_piece, other_s_m, other) in &points[k + 1..] {
            let along_m = (other_s_m - s_m).min(start_m - (other_s_m - s_m));
            let apart_m = point.distance(*other);
            if along_m > NEIGHBOURS_M && apart_m < wanted_m {
                return Err(CircuitFault::TooClose { pieces: [*piece, *other_piece], apart_m, wanted_m });
            }
        }
    }
    Ok(())
}
