//! Turns that a car cannot drive within its lane. In: a connection of a network, or a lane. Out: whether it turns too tightly, has a
//! corner in its line, steps aside or leads backwards. Metres, radians.

use super::network::{Connection, Lane, Network};
use crate::space::wrap_angle;
use glam::DVec2;

/// Radius of the tightest circle that the middle of a passenger car drives, metres: turning circles are about 11 m wide.
const TURNING_RADIUS_M: f64 = 5.5;
/// Margin that a driver leaves between the middle of the car and the lane's edge, metres.
const MARGIN_M: f64 = 0.5;
/// Smallest turn that counts as a corner, radians: 30 degrees.
const CORNER_RAD: f64 = 0.52;
/// Largest turn at the corner of a street, radians: 110 degrees.
const STREET_CORNER_RAD: f64 = 1.92;
/// Turn above which the lines before and behind it intersect far away, radians: 150 degrees.
const NEARLY_BACK_RAD: f64 = 2.6;

/// Distance below which points of a shape count as one, metres: a short last piece may be askew.
const POINTS_APART_M: f64 = 0.5;
/// Largest step back that counts as an overlap of two lanes drawn slightly too long, metres.
const OVERLAP_M: f64 = 1.0;
/// Length of the lanes before and behind a junction that is checked together with its internal lanes, metres: two cars. The rest of a
/// lane is checked by itself.
const JOINED_M: f64 = 10.0;

/// Returns true if a car cannot follow the connection from lane to lane. It would leave the lane on its tightest circle or at a corner of
/// the internal lanes, or the next lane begins beside or behind the end of the first.
pub(super) fn is_too_tight(net: &Network, connection: &Connection) -> bool {
    let (from, to) = (net.lane(connection.from), net.lane(connection.to));
    let (out, into) = (direction(from, true), direction(to, false));
    let turn_rad = wrap_angle(into - out).abs();
    let leeway_m = from.half_width_m().min(to.half_width_m()) - MARGIN_M;
    let inside: Vec<&Lane> = net.lanes_between(connection.from, connection.to).map(|lane| net.lane(lane)).collect();
    if !inside.is_empty() && has_corner(&joined_pieces(from, &inside, to), leeway_m) {
        return true;
    }
    if turn_rad >= CORNER_RAD {
        return leaves_lane(turn_rad, way_m(from, &inside, to) / turn_rad, leeway_m);
    }
    let across = start(to) - end(from);
    let ahead_m = across.dot(DVec2::from_angle(out)).min(across.dot(DVec2::from_angle(into)));
    let aside_m = across.dot(DVec2::from_angle(out).perp()).abs().min(across.dot(DVec2::from_angle(into).perp()).abs());
    ahead_m < -OVERLAP_M || aside_m - leeway_m > reach_aside_m(ahead_m)
}

/// Returns true for a connection that turns by up to 110 degrees, as at the corner of a street. Networks made by hand have such corners
/// drawn tighter than a car turns; it cuts their inside.
pub(super) fn is_street_corner(net: &Network, connection: &Connection) -> bool {
    let (from, to) = (net.lane(connection.from), net.lane(connection.to));
    (CORNER_RAD..STREET_CORNER_RAD).contains(&wrap_angle(direction(to, false) - direction(from, true)).abs())
}

/// Returns true for a lane with a corner in its shape that a car cannot follow within the lane.
pub(super) fn has_kink(lane: &Lane) -> bool {
    has_corner(&pieces(&points(lane)), lane.half_width_m() - MARGIN_M)
}

/// Straight piece of a line.
#[derive(Clone, Copy, Debug)]
struct LineSegment {
    start: DVec2,
    end: DVec2,
}

impl LineSegment {
    fn step(&self) -> DVec2 {
        self.end - self.start
    }
}

/// Returns true for a line with a corner at which a car leaves a lane with this leeway.
fn has_corner(pieces: &[LineSegment], leeway_m: f64) -> bool {
    (0..pieces.len()).any(|first| {
        // From piece to piece: the turn so far, and the distance between the joints.
        let (mut turn_rad, mut way_m) = (0.0, 0.0);
        for last in first + 1..pieces.len() {
            turn_rad += wrap_angle(pieces[last].step().to_angle() - pieces[last - 1].step().to_angle());
            way_m += pieces[last - 1].end.distance(pieces[last].start);
            let turn_rad: f64 = turn_rad;
            let is_corner = match turn_rad.abs() {
                0.0..CORNER_RAD => false,
                CORNER_RAD..NEARLY_BACK_RAD => {
                    // A circle tangent to the first and the last piece passes at this distance from the intersection of their lines.
                    let circle_m = TURNING_RADIUS_M * (1.0 / (turn_rad / 2.0).cos() - 1.0);
                    circle_m - corner_cut_m(&pieces[first..=last]) > leeway_m
                }
                _ => leaves_lane(turn_rad.abs(), way_m / turn_rad.abs(), leeway_m),
            };
            if is_corner {
                return true;
            }
            way_m += pieces[last].step().length();
            if way_m > TURNING_RADIUS_M * std::f64::consts::PI {
                break;
            }
        }
        false
    })
}

/// Returns the distance between a line and the intersection of its first and last piece, extended, metres.
fn corner_cut_m(pieces: &[LineSegment]) -> f64 {
    let (first, last) = (pieces[0], pieces[pieces.len() - 1]);
    let (out, into) = (first.step(), last.step());
    let along = (last.start - first.end).perp_dot(into) / out.perp_dot(into);
    let corner = first.end + out * along;
    let joints = pieces.windows(2).map(|pair| LineSegment { start: pair[0].end, end: pair[1].start });
    let between = pieces[1..pieces.len() - 1].iter().copied();
    joints.chain(between).map(|piece| distance_m(corner, piece)).fold(f64::INFINITY, f64::min)
}

fn distance_m(point: DVec2, piece: LineSegment) -> f64 {
    let step = piece.step();
    let share = (point - piece.start).dot(step) / step.length_squared().max(1e-12);
    (piece.start + step * share.clamp(0.0, 1.0)).distance(point)
}

/// Returns the points of a lane, without those too close to the previous one.
fn points(lane: &Lane) -> Vec<DVec2> {
    let mut points: Vec<DVec2> = Vec::new();
    for point in lane.shape().iter().map(|point| point.truncate()) {
        if points.last().is_none_or(|last| last.distance(point) >= POINTS_APART_M) {
            points.push(point);
        }
    }
    points
}

fn pieces(points: &[DVec2]) -> Vec<LineSegment> {
    points.windows(2).map(|pair| LineSegment { start: pair[0], end: pair[1] }).collect()
}

/// Returns the pieces of the line through a junction, with the ends of the lanes before and behind it. A lateral step between two lanes
/// is not a corner: [`is_too_tight`] has a rule of its own for it. Short internal lines are skipped: they may lead back to a lane that
/// overlaps.
fn joined_pieces(from: &Lane, inside: &[&Lane], to: &Lane) -> Vec<LineSegment> {
    let mut before = points(from);
    before.reverse();
    let mut before = first_metres(before);
    before.reverse();
    let inside = inside.iter().filter(|lane| drawn_m(lane) > OVERLAP_M).map(|lane| points(lane));
    let lines = [before].into_iter().chain(inside).chain([first_metres(points(to))]);
    lines.flat_map(|line| pieces(&line)).collect()
}

/// Returns the first [`JOINED_M`] of a line.
fn first_metres(points: Vec<DVec2>) -> Vec<DVec2> {
    let mut kept = Vec::new();
    let mut left_m = JOINED_M;
    for point in points {
        let Some(last) = kept.last().copied() else {
            kept.push(point);
            continue;
        };
        let step: DVec2 = point - last;
        if step.length() >= left_m {
            kept.push(last + step.normalize_or_zero() * left_m);
            break;
        }
        left_m -= step.length();
        kept.push(point);
    }
    kept
}

/// Returns true if a car on its tightest circle leaves a lane with this leeway at a turn of this angle and radius.
///
/// A circle of radius R that is tangent to both sides cuts a corner of angle a and radius r. In the middle, they are (R - r) (1 / cos(a /
/// 2) - 1) apart.
fn leaves_lane(turn_rad: f64, radius_m: f64, leeway_m: f64) -> bool {
    (TURNING_RADIUS_M - radius_m) * (1.0 / (turn_rad / 2.0).cos().max(1e-9) - 1.0) > leeway_m
}

/// Returns the lateral displacement that a car reaches over a distance ahead, metres: on an arc to one side and one to the other, L^2 = 4
/// R d - d^2.
fn reach_aside_m(ahead_m: f64) -> f64 {
    let tightest_m = 2.0 * TURNING_RADIUS_M;
    let rest = tightest_m * tightest_m - ahead_m.clamp(0.0, tightest_m).powi(2);
    tightest_m - rest.sqrt()
}

fn start(lane: &Lane) -> DVec2 {
    lane.shape()[0].truncate()
}

fn end(lane: &Lane) -> DVec2 {
    lane.shape()[lane.shape().len() - 1].truncate()
}

/// Returns the length of the way through the junction, metres: along the internal lanes, or straight across if there are none.
fn way_m(from: &Lane, inside: &[&Lane], to: &Lane) -> f64 {
    let way_m: f64 = inside.iter().map(|lane| drawn_m(lane)).sum();
    // A line that ends short of the lanes is bridged.
    way_m.max(end(from).distance(start(to)))
}

fn drawn_m(lane: &Lane) -> f64 {
    lane.shape().windows(2).map(|pair| pair[0].truncate().distance(pair[1].truncate())).sum()
}

/// Returns the direction at the start or the end of a lane, radians, taken over 2 m so that a short last piece that is askew does not
/// count.
fn direction(lane: &Lane, at_end: bool) -> f64 {
    const OVER_M: f64 = 2.0;
    let mut points: Vec<DVec2> = lane.shape().iter().map(|point| point.truncate()).collect();
    if at_end {
        points.reverse();
    }
    let near = points[0];
    let far = points.iter().find(|point| point.distance(near) >= OVER_M).unwrap_or(&points[points.len() - 1]);
    let along = if at_end { near - *far } else { *far - near };
    along.to_angle()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// Checks a left turn by `turn_deg` on an arc of `radius_m` between two straight lanes, `width_m` wide.
    fn tight(turn_deg: f64, radius_m: f64, width_m: f64) -> bool {
        let turn = turn_deg.to_radians();
        let on_arc =
            |share: f64| DVec2::new(0.0, radius_m) + DVec2::from_angle(turn * share).rotate(DVec2::NEG_Y) * radius_m;
        let out = DVec2::from_angle(turn);
        let lane = |id: &str, kind: &str, points: &[DVec2]| {
            let shape: Vec<String> = points.iter().map(|point| format!("{:.6},{:.6}", point.x, point.y)).collect();
            format!(
                "<edge id=\"{id}\" {kind}><lane id=\"{id}_0\" index=\"0\" speed=\"9\" length=\"40\" width=\"{width_m}\" shape=\"{}\"/></edge>",
                shape.join(" ")
            )
        };
        let arc: Vec<DVec2> = (0..=20).map(|k| on_arc(f64::from(k) / 20.0)).collect();
        let text = format!(
            "<net>{}{}{}<connection from=\"a\" to=\"b\" fromLane=\"0\" toLane=\"0\" via=\":n_0\"/><connection from=\":n\" \
             to=\"b\" fromLane=\"0\" toLane=\"0\"/></net>",
            lane(":n", "function=\"internal\"", &arc),
            lane("a", "", &[DVec2::new(-40.0, 0.0), DVec2::ZERO]),
            lane("b", "", &[on_arc(1.0), on_arc(1.0) + out * 40.0]),
        );
        let net = Network::read(Path::new("t.net.xml"), &text).unwrap();
        is_too_tight(&net, &net.connections_from(net.lane_named("a_0").unwrap())[0])
    }

    /// Checks a connection between two straight lanes of 3.2 m, by internal lanes along these points; each ends where the next begins.
    fn through(from: &str, insides: &[&str], to: &str) -> bool {
        let lane = |id: &str, kind: &str, shape: &str| {
            format!(
                "<edge id=\"{id}\" {kind}><lane id=\"{id}_0\" index=\"0\" speed=\"9\" length=\"40\" width=\"3.2\" shape=\"{shape}\"/></edge>"
            )
        };
        let mut text = lane("a", "", from) + &lane("b", "", to);
        let mut before = "a".to_owned();
        for (k, shape) in insides.iter().enumerate() {
            text += &lane(&format!(":n{k}"), "function=\"internal\"", shape);
            text += &format!("<connection from=\"{before}\" to=\"b\" fromLane=\"0\" toLane=\"0\" via=\":n{k}_0\"/>");
            before = format!(":n{k}");
        }
        text += &format!("<connection from=\"{before}\" to=\"b\" fromLane=\"0\" toLane=\"0\"/>");
        let net = Network::read(Path::new("t.net.xml"), &format!("<net>{text}</net>")).unwrap();
        is_too_tight(&net, &net.connections_from(net.lane_named("a_0").unwrap())[0])
    }

    #[test]
    fn a_corner_inside_a_junction_counts_however_long_the_line_is() {
        let (from, north) = ("-40,0 0,0", "20,20 20,60");
        // A right angle after 20 m: on a circle of 5.5 m a car is 2.28 m aside there, and has 1.1 m. Along its 40 m it would have 25 m.
        assert!(through(from, &["0,0 20,0 20,20"], north));
        // The same corner where one internal lane ends and the next begins, and at the start of the lane behind the junction.
        assert!(through(from, &["0,0 20,0", "20,0 20,20"], north) && through(from, &["0,0 20,0"], "20,0 20,40"));
        // No corner if it is cut off over 6 m on either side, or on an arc.
        assert!(!through(from, &["0,0 14,0 20,6 20,20"], north));
        let arc = |k: i32| {
            DVec2::new(0.0, 20.0)
                + DVec2::from_angle(f64::from(k) * 0.1 * std::f64::consts::FRAC_PI_2).rotate(DVec2::NEG_Y) * 20.0
        };
        let arc: Vec<String> = (0..=10).map(|k| format!("{:.6},{:.6}", arc(k).x, arc(k).y)).collect();
        assert!(!through(from, &[&arc.join(" ")], north));
        // A zigzag leads on straight ahead, and has two corners.
        assert!(through(from, &["0,0 10,0 10,20 30,20 30,0 40,0"], "40,0 80,0"));
        // Lines drawn 0.8 m too long, or 0.8 m aside, have no corner.
        assert!(!through(from, &["-0.8,0 20.8,0"], "20,0 60,0") && !through(from, &["0,0.8 20,0.8"], "20,0 60,0"));
        // A half circle of 5.5 m to the other side of a street takes 17.3 m of way across.
        assert!(through(from, &["0,0 0.9,0"], "0,17 -40,17") && !through(from, &["0,0 0.9,0"], "0,18 -40,18"));
        // No corner where an internal lane leads back to a lane that begins 0.8 m before the other ends.
        assert!(!through(from, &["0,0 -0.8,0"], "-0.8,0 40,0"));
    }

    /// Checks a connection from a lane that ends at the origin, heading east, to one that begins at (x, y) and heads east.
    fn onward(x: f64, y: f64) -> bool {
        let text = format!(
            "<net><edge id=\"a\"><lane id=\"a_0\" index=\"0\" speed=\"9\" length=\"40\" width=\"3.2\" shape=\"-40,0 0,0\"/></edge>\
             <edge id=\"b\"><lane id=\"b_0\" index=\"0\" speed=\"9\" length=\"40\" width=\"3.2\" shape=\"{x},{y} {},{y}\"/></edge>\
             <connection from=\"a\" to=\"b\" fromLane=\"0\" toLane=\"0\"/></net>",
            x + 40.0
        );
        let net = Network::read(Path::new("t.net.xml"), &text).unwrap();
        is_too_tight(&net, &net.connections_from(net.lane_named("a_0").unwrap())[0])
    }

    #[test]
    fn a_next_lane_that_begins_behind_or_beside_cannot_be_reached() {
        // 1.1 m of leeway. Two arcs of 5.5 m bring a car d = 11 - sqrt(121 - L^2) m aside on L m: 1.20 m on 5 m, 4.02 m on 8.5 m.
        assert!(!onward(0.0, 0.0) && !onward(12.0, 0.5) && !onward(-0.5, 0.0));
        assert!(onward(-8.0, 0.0) && onward(0.0, 3.2) && onward(0.0, -3.2));
        assert!(!onward(5.0, 2.2) && onward(5.0, 2.4) && !onward(8.5, 5.1) && onward(8.5, -5.3));
    }

    #[test]
    fn a_corner_in_the_shape_of_a_lane_is_a_kink_and_a_bend_is_not() {
        let kinked = |points: &str| {
            let text = format!(
                "<net><edge id=\"a\"><lane id=\"a_0\" index=\"0\" speed=\"9\" length=\"80\" width=\"3.2\" shape=\"{points}\"/></edge></net>"
            );
            let net = Network::read(Path::new("t.net.xml"), &text).unwrap();
            has_kink(net.lane(net.lane_named("a_0").unwrap()))
        };
        // At a point: 5.5 (1 / cos(a / 2) - 1) > 1.1 for a > 67.1 degrees. 60 and 75 degrees, to the left and to the right.
        assert!(!kinked("0,0 40,0 60,34.64") && !kinked("0,0 40,0 60,-34.64"));
        assert!(kinked("0,0 40,0 50.35,38.64") && kinked("0,0 40,0 50.35,-38.64"));
        // A right angle in two steps of 45 degrees cuts the corner by half of the distance between them. The circle of 5.5 m passes 2.28
        // m from it: 1.78 m aside where they are 1 m apart, 0.78 m where they are 3 m apart.
        assert!(kinked("0,0 40,0 40.71,0.71 40.71,40") && !kinked("0,0 40,0 42.12,2.12 42.12,40"));
        // 2.2 m apart they cut it by 1.1 m: the circle passes 1.18 m aside.
        assert!(kinked("0,0 40,0 41.56,1.56 41.56,40"));
        // A last piece of 0.3 m that is askew is not a kink.
        assert!(!kinked("0,0 40,0 40,0.3"));
    }

    #[test]
    fn turns_that_need_more_than_a_turning_circle_of_11_m_are_too_tight() {
        // 1.1 m of leeway in a lane of 3.2 m. A right angle: (5.5 - r) 0.4142 > 1.1 for r < 2.84.
        assert!(tight(90.0, 2.7, 3.2) && !tight(90.0, 3.0, 3.2));
        // 120 degrees: (5.5 - r) 1 > 1.1 for r < 4.4.
        assert!(tight(120.0, 4.2, 3.2) && !tight(120.0, 4.6, 3.2));
        // A wider lane has room, a slight bend needs none, and a turn back on the spot needs a circle.
        assert!(!tight(90.0, 2.7, 4.0) && !tight(25.0, 0.1, 3.2) && tight(175.0, 3.0, 3.2));
    }
}
