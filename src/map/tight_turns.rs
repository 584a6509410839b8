//! Which turns a car cannot make within its lane. In: a connection of a network. Out: whether its turn is too tight. Metres, radians.

use super::network::{Connection, Lane, LaneId, Network};
use crate::space::wrap_angle;
use glam::DVec2;

/// Radius of the tightest circle that the middle of a passenger car drives, metres: turning circles are about 11 m wide.
const TURNING_RADIUS_M: f64 = 5.5;
/// What a driver leaves between the middle of the car and the lane's edge, metres.
const MARGIN_M: f64 = 0.5;
/// Turns by less than this are no corners, radians: 30 degrees.
const CORNER_RAD: f64 = 0.52;

/// True if a car on its tightest circle leaves the lane while it turns as the connection does.
///
/// A corner of angle a and radius r is cut by a circle of radius R that touches both its sides: in the middle, they are
/// (R - r) (1 / cos(a / 2) - 1) apart.
pub(super) fn is_too_tight(net: &Network, connection: &Connection) -> bool {
    let (from, to) = (net.lane(connection.from), net.lane(connection.to));
    let turn_rad = wrap_angle(direction(to, false) - direction(from, true)).abs();
    if turn_rad < CORNER_RAD {
        return false;
    }
    let radius_m = way_m(net, connection) / turn_rad;
    let leeway_m = from.half_width_m().min(to.half_width_m()) - MARGIN_M;
    (TURNING_RADIUS_M - radius_m) * (1.0 / (turn_rad / 2.0).cos().max(1e-9) - 1.0) > leeway_m
}

/// Length of the way through the junction: along the lanes inside, or straight across where there are none.
fn way_m(net: &Network, connection: &Connection) -> f64 {
    let mut at = connection.via;
    let mut way_m = 0.0;
    // As many lanes as are followed inside a junction.
    for _ in 0..16 {
        let Some(lane) = at else { break };
        way_m += drawn_m(net.lane(lane));
        let onwards = net.connections_from(lane).iter().find(|way| way.to == connection.to);
        at = onwards.and_then(|way| way.via).filter(|next: &LaneId| *next != lane);
    }
    let (from, to) = (net.lane(connection.from).shape(), net.lane(connection.to).shape());
    let across_m = from[from.len() - 1].truncate().distance(to[0].truncate());
    // A line that ends short of the lanes is bridged.
    way_m.max(across_m)
}

fn drawn_m(lane: &Lane) -> f64 {
    lane.shape().windows(2).map(|pair| pair[0].truncate().distance(pair[1].truncate())).sum()
}

/// Direction at the start or the end of a lane, over the few metres that a car is long, so that a last short piece that is askew
/// does not count.
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

    /// A turn to the left by `turn_deg` on an arc of `radius_m` between two straight lanes, `width_m` wide.
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

    #[test]
    fn turns_that_a_turning_circle_of_11_m_leaves_the_lane_in_are_too_tight() {
        // 1.1 m of leeway in a lane of 3.2 m. A right angle: (5.5 - r) 0.4142 > 1.1 for r < 2.84.
        assert!(tight(90.0, 2.7, 3.2) && !tight(90.0, 3.0, 3.2));
        // 120 degrees: (5.5 - r) 1 > 1.1 for r < 4.4.
        assert!(tight(120.0, 4.2, 3.2) && !tight(120.0, 4.6, 3.2));
        // A wider lane has room for it, a slight bend needs none, and back on the spot needs a circle.
        assert!(!tight(90.0, 2.7, 4.0) && !tight(25.0, 0.1, 3.2) && tight(175.0, 3.0, 3.2));
    }
}
