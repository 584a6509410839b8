//! Gores: paved wedges between two roads of one direction, from the junction where they part or meet to the place where their asphalt is
//! apart. In: a network with its lanes. Out: the wedges' borders, metres.

use super::{EdgeId, JunctionId, LaneId, LanePosition, Network, Side, junction::is_inside};
use crate::map::SHOULDER_M;
use glam::{DVec2, DVec3};

/// Largest angle between the two roads at their junction, radians: 20 degrees. Roads at larger ones have a corner between them.
const MOST_APART_RAD: f64 = 0.35;
/// Distance between the borders of the two roads at the wedge's end, metres: both shoulders, and so much that a kerb and a sign stand beyond.
const END_WIDE_M: f64 = 2.0 * SHOULDER_M + 2.0;
/// Distance between two rows, metres.
const ROW_M: f64 = 1.0;
/// Lengths of the shortest and the longest wedge, metres. Roads that stay close for longer run beside each other.
const LONG_M: std::ops::Range<f64> = 8.0..200.0;
/// Largest difference of the two roads' heights, metres: beyond it there is a slope or a wall between them.
const MOST_RISE_M: f64 = 0.3;

/// Wedge between two roads that part or meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Gore {
    pub junction: JunctionId,
    /// True if the roads part, false if they meet.
    pub parts: bool,
    /// Corners: the left border of the road on the right, from the junction outwards, then the right border of the other one, back again.
    /// Right and left are those of its traffic.
    pub outline: Vec<DVec3>,
}

impl Gore {
    /// Checks whether a point of the ground plane lies in the wedge.
    pub fn covers(&self, point: DVec2) -> bool {
        is_inside(point, &self.outline)
    }

    /// Returns the rows from the junction outwards, a metre apart: a point on the border of the right road, and one of the left.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = [DVec3; 2]> {
        let last = self.outline.len() - 1;
        (0..self.outline.len() / 2).map(move |k| [self.outline[k], self.outline[last - k]])
    }
}

/// Returns all gores of a network, in the order of their edges.
pub(super) fn gores(net: &Network) -> Vec<Gore> {
    let of_cars = |edge: EdgeId| net.edge(edge).kind.is_street() && outermost(net, edge, Side::Left).is_some();
    let ways = net.connections().iter().filter(|way| !way.is_turnaround());
    let mut ways: Vec<(EdgeId, EdgeId)> =
        ways.map(|way| (net.lane(way.from).edge, net.lane(way.to).edge)).filter(|way| of_cars(way.0)).collect();
    let mut found = Vec::new();
    for parts in [true, false] {
        ways.sort_unstable();
        ways.dedup();
        for group in ways.chunk_by(|one, other| one.0 == other.0) {
            for (k, (_, one)) in group.iter().enumerate() {
                let others = group[k + 1..].iter().map(|(_, other)| *other);
                found.extend(others.filter_map(|other| between(net, [*one, other], parts)));
            }
        }
        ways.iter_mut().for_each(|way| *way = (way.1, way.0));
    }
    found
}

/// Returns the outermost lane of an edge on a side if cars drive there.
fn outermost(net: &Network, edge: EdgeId, side: Side) -> Option<LaneId> {
    let is_outermost = |lane: &LaneId| net.neighbour(*lane, side).is_none();
    net.edge(edge).lanes().find(is_outermost).filter(|lane| net.lane(*lane).admits_cars())
}

/// Returns the wedge between two roads, if it ends within [`LONG_M`].
fn between(net: &Network, edges: [EdgeId; 2], parts: bool) -> Option<Gore> {
    // The lane's place at the junction, and the direction there in which traffic drives.
    let at_junction = |edge: EdgeId| {
        let lane = net.lane(net.edge(edge).lanes().next()?);
        let points = lane.line.points();
        Some(if parts {
            (points[0], lane.line.start_direction())
        } else {
            (points[points.len() - 1], lane.line.end_direction())
        })
    };
    let ([one, other], mut edges) = ([at_junction(edges[0])?, at_junction(edges[1])?], edges);
    if one.1.angle_to(other.1).abs() > MOST_APART_RAD {
        return None;
    }
    if (other.0 - one.0).truncate().perp_dot(one.1) > 0.0 {
        // The other one is on the right.
        edges.reverse();
    }
    let [left, right] = [outermost(net, edges[1], Side::Right)?, outermost(net, edges[0], Side::Left)?];
    let [of_left, of_right] = [net.lane(left), net.lane(right)];
    let drawn_m = of_right.line.drawn_m();
    let (mut borders, mut others) = (Vec::new(), Vec::new());
    loop {
        let out_m = borders.len() as f64 * ROW_M;
        if out_m > drawn_m.min(LONG_M.end) {
            return None;
        }
        let along = if parts { out_m / drawn_m } else { 1.0 - out_m / drawn_m };
        let at = LanePosition { lane: right, s_m: along * of_right.length_m, offset_m: of_right.half_width_m() };
        let border = net.pose(at).position;
        let across = net.place_in(left, border);
        let other = net.pose(LanePosition { offset_m: -of_left.half_width_m(), ..across }).position;
        if (other.z - border.z).abs() > MOST_RISE_M {
            return None;
        }
        let gap_m = -across.offset_m - of_left.half_width_m();
        if gap_m > END_WIDE_M {
            break;
        }
        borders.push(border);
        others.push(if gap_m > 0.0 { other } else { border });
    }
    let junction = if parts { net.edge(edges[0]).from } else { net.edge(edges[0]).to };
    let is_long = borders.len() as f64 * ROW_M >= LONG_M.start;
    let outline = borders.into_iter().chain(others.into_iter().rev()).collect();
    is_long.then_some(Gore { junction: junction?, parts, outline })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// Returns a network in which the roads `left` and `right` part from `way`, or meet before it: all straight, one at an angle of 5 degrees.
    fn fork(parts: bool, rise_m: f64) -> Network {
        let (cos, sin) = (5.0_f64.to_radians().cos(), 5.0_f64.to_radians().sin());
        let point = |[x, y, z]: [f64; 3]| if parts { format!("{x},{y},{z}") } else { format!("{},{},{z}", -x, -y) };
        let edge = |id: &str, [inner, outer]: [[f64; 3]; 2], leads_out: bool| {
            let (ends, shape) = if leads_out == parts {
                ("from=\"fork\" to=\"out\"", [inner, outer])
            } else {
                ("from=\"out\" to=\"fork\"", [outer, inner])
            };
            let shape = shape.map(point).join(" ");
            format!(
                "<edge id=\"{id}\" {ends}><lane id=\"{id}_0\" index=\"0\" speed=\"30\" length=\"90\" shape=\"{shape}\"/></edge>"
            )
        };
        let edges = [
            edge("way", [[0.0, -1.6, 0.0], [-90.0, -1.6, 0.0]], false),
            edge("left", [[0.0, 0.0, 0.0], [90.0, 0.0, 0.0]], true),
            edge("right", [[0.0, -3.2, rise_m], [90.0 * cos, -3.2 - 90.0 * sin, rise_m]], true),
        ];
        let way = |one: &str| {
            let [from, to] = if parts { ["way", one] } else { [one, "way"] };
            format!("<connection from=\"{from}\" to=\"{to}\" fromLane=\"0\" toLane=\"0\"/>")
        };
        let text = format!("<net>{}{}{}</net>", edges.concat(), way("left"), way("right"));
        Network::read(Path::new("t.net.xml"), &text).expect("a network")
    }

    #[test]
    fn a_wedge_widens_by_the_angle_until_both_shoulders_and_two_metres_fit() {
        for parts in [true, false] {
            let net = fork(parts, 0.0);
            let [gore] = net.gores() else { panic!("{:?}", net.gores()) };
            assert_eq!(gore.parts, parts);
            // At 5 degrees, 2.8 m of width are reached after 32.1 m, and lanes are 3.2 m wide.
            assert_eq!(gore.rows().len(), 33);
            let (sin, cos) = 5.0_f64.to_radians().sin_cos();
            for (k, [right, left]) in gore.rows().enumerate() {
                // Where roads meet, the network is turned by half a turn, and so is what is left and right of the traffic.
                let [on_right, on_left] = if parts { [right, left] } else { [-left, -right] };
                assert!((on_left.y + 1.6).abs() < 1e-6, "{k}: {on_left}");
                let off_m = (on_right.truncate() - DVec2::new(0.0, -3.2)).perp_dot(DVec2::new(cos, -sin));
                assert!((off_m + 1.6).abs() < 0.01, "{k}: {on_right} is {off_m} m from the right road's middle");
                assert!((right.distance(left) - k as f64 * sin).abs() < 0.02, "{k}: {right} {left}");
            }
            let sign = if parts { 1.0 } else { -1.0 };
            let covered = |x: f64, y: f64| gore.covers(sign * DVec2::new(x, y));
            assert!(covered(20.0, -2.4) && !covered(20.0, -1.5) && !covered(20.0, -3.6) && !covered(40.0, -2.4));
        }
    }

    #[test]
    fn roads_at_other_heights_and_corners_have_no_wedge() {
        assert!(fork(true, 1.0).gores().is_empty());
        let count = |name: &str| Network::load(name).expect("a network").gores().len();
        // The motorway has one entry and one exit. The ramps of the other network leave at 24 degrees.
        assert_eq!([count("motorway"), count("tests/data/networks/ramps.net.xml")], [2, 0]);
        for name in ["ring-250", "figure-eight", "grid", "tests/data/networks/crossing.net.xml"] {
            assert_eq!(count(name), 0, "{name}");
        }
    }
}
