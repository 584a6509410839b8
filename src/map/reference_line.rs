//! Reference lines of OpenDRIVE roads: lines, arcs, clothoids and cubic polynomials. In: `<planView>`. Out: point and heading at a distance along
//! the road. Metres, radians.

use glam::{DVec2, dvec2};
use roxmltree::Node;

/// Length of a step of the integration along arcs and clothoids, metres, and the largest number of steps.
const STEP_M: f64 = 1.0;
const MOST_STEPS: f64 = 100_000.0;

/// Shape of one piece of a reference line.
#[derive(Clone, Copy, Debug, PartialEq)]
enum PieceShape {
    /// Curvature at its start, 1/m, and its change along the piece, 1/m².
    Clothoid([f64; 2]),
    /// Coefficients of forward and left coordinates, and the parameter's value for each metre.
    Cubic([[f64; 4]; 2], f64),
}

/// Piece of a reference line from a distance on.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Piece {
    start_m: f64,
    from: DVec2,
    heading_rad: f64,
    shape: PieceShape,
}

/// Reference line of a road.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct ReferenceLine(Vec<Piece>);

/// Returns the finite number of an attribute.
pub(super) fn number(node: Node, name: &str) -> Option<f64> {
    node.attribute(name)?.trim().parse().ok().filter(|number: &f64| number.abs() <= 1e7)
}

impl ReferenceLine {
    /// Reads the line of a road; pieces without a place or of no known shape are left out.
    pub fn of(road: Node) -> Self {
        let plan = road.children().find(|node| node.has_tag_name("planView"));
        let geometries = plan.into_iter().flat_map(|plan| plan.children().filter(|node| node.has_tag_name("geometry")));
        let mut pieces: Vec<Piece> = geometries.filter_map(piece).collect();
        pieces.sort_by(|a, b| a.start_m.total_cmp(&b.start_m));
        Self(pieces)
    }

    /// Returns the point and the heading this far along the road; `None` for a road without a line.
    pub fn at(&self, s_m: f64) -> Option<(DVec2, f64)> {
        let before = self.0.partition_point(|piece| piece.start_m <= s_m).saturating_sub(1);
        let piece = self.0.get(before)?;
        let (local, turn_rad) = piece.shape.at((s_m - piece.start_m).max(0.0));
        let at = piece.from + DVec2::from_angle(piece.heading_rad).rotate(local);
        at.is_finite().then_some((at, piece.heading_rad + turn_rad))
    }

    /// Returns the point this far along the road and to the left of its line.
    pub fn beside(&self, s_m: f64, left_m: f64) -> Option<DVec2> {
        self.at(s_m).map(|(at, heading_rad)| at + DVec2::from_angle(heading_rad).perp() * left_m)
    }
}

fn piece(geometry: Node) -> Option<Piece> {
    let of = |name: &str| number(geometry, name);
    let length_m = of("length")?;
    let shape = geometry.children().filter(Node::is_element).find_map(|node| shape(node, length_m))?;
    Some(Piece { start_m: of("s")?, from: dvec2(of("x")?, of("y")?), heading_rad: of("hdg")?, shape })
}

fn shape(node: Node, length_m: f64) -> Option<PieceShape> {
    let of = |name: &str| number(node, name);
    Some(match node.tag_name().name() {
        "line" => PieceShape::Clothoid([0.0; 2]),
        "arc" => PieceShape::Clothoid([of("curvature")?, 0.0]),
        "spiral" => {
            let (from, to) = (of("curvStart")?, of("curvEnd")?);
            PieceShape::Clothoid([from, (to - from) / length_m.max(1e-6)])
        }
        "poly3" => PieceShape::Cubic([[0.0, 1.0, 0.0, 0.0], [of("a")?, of("b")?, of("c")?, of("d")?]], 1.0),
        "paramPoly3" => {
            let forwards = [of("aU")?, of("bU")?, of("cU")?, of("dU")?];
            let left = [of("aV")?, of("bV")?, of("cV")?, of("dV")?];
            let by_length = node.attribute("pRange") == Some("arcLength");
            PieceShape::Cubic([forwards, left], if by_length { 1.0 } else { 1.0 / length_m.max(1e-6) })
        }
        _ => return None,
    })
}

impl PieceShape {
    /// Returns the place this far along the piece in the frame of its start, and the change of heading.
    fn at(self, along_m: f64) -> (DVec2, f64) {
        match self {
            Self::Clothoid([curvature, change]) => {
                let heading_rad = |m: f64| curvature * m + change * m * m / 2.0;
                if curvature == 0.0 && change == 0.0 {
                    return (dvec2(along_m, 0.0), 0.0);
                }
                // Simpson's rule, exact to a millimetre for any curve that a car can drive.
                let steps = (along_m / STEP_M).ceil().clamp(1.0, MOST_STEPS);
                let step_m = along_m / steps;
                let direction = |m: f64| DVec2::from_angle(heading_rad(m));
                let one = |k: usize| {
                    let from_m = k as f64 * step_m;
                    direction(from_m) + 4.0 * direction(from_m + step_m / 2.0) + direction(from_m + step_m)
                };
                ((0..steps as usize).map(one).sum::<DVec2>() * step_m / 6.0, heading_rad(along_m))
            }
            Self::Cubic(coefficients, per_m) => {
                let p = along_m * per_m;
                let [u, v] = coefficients.map(|[a, b, c, d]| a + p * (b + p * (c + p * d)));
                let [du, dv] = coefficients.map(|[_, b, c, d]| b + p * (2.0 * c + p * 3.0 * d));
                (dvec2(u, v), dv.atan2(du))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(geometry: &str, s_m: f64) -> (DVec2, f64) {
        let text = format!("<road><planView>{geometry}</planView></road>");
        let tree = roxmltree::Document::parse(&text).expect("XML");
        ReferenceLine::of(tree.root_element()).at(s_m).expect("a point")
    }

    #[test]
    fn pieces_of_all_shapes_lie_where_their_formulas_say() {
        let piece =
            |shape: &str| format!("<geometry s=\"10\" x=\"5\" y=\"7\" hdg=\"0\" length=\"100\">{shape}</geometry>");
        let near = |(found, heading_rad): (DVec2, f64), [x, y]: [f64; 2], turned_rad: f64| {
            assert!(
                found.distance(dvec2(x, y)) < 1e-3 && (heading_rad - turned_rad).abs() < 1e-4,
                "{found} {heading_rad}"
            );
        };
        near(at(&piece("<line/>"), 40.0), [35.0, 7.0], 0.0);
        // A quarter of a circle with a radius of 50 m.
        let quarter_m = 25.0 * std::f64::consts::PI;
        near(at(&piece("<arc curvature=\"0.02\"/>"), 10.0 + quarter_m), [55.0, 57.0], std::f64::consts::FRAC_PI_2);
        // A clothoid whose parameter is its length, 100 m: the series x = 1 - 1/40 + 1/3456 - 1/599040 and y = 1/6 - 1/336 + 1/42240 of its
        // end, in lengths.
        let [x, y] = [1.0 - 1.0 / 40.0 + 1.0 / 3456.0 - 1.0 / 599_040.0, 1.0 / 6.0 - 1.0 / 336.0 + 1.0 / 42_240.0];
        let end = [5.0 + 100.0 * x, 7.0 + 100.0 * y];
        near(at(&piece("<spiral curvStart=\"0\" curvEnd=\"0.01\"/>"), 110.0), end, 0.5);
        let cubic = "<paramPoly3 aU=\"0\" bU=\"100\" cU=\"0\" dU=\"0\" aV=\"0\" bV=\"0\" cV=\"8\" dV=\"0\" pRange=\"normalized\"/>";
        near(at(&piece(cubic), 60.0), [55.0, 9.0], 0.08f64.atan());
        near(at(&piece("<poly3 a=\"1\" b=\"0\" c=\"0.01\" d=\"0\"/>"), 20.0), [15.0, 9.0], 0.2f64.atan());
    }
}
