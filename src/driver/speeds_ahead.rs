//! Speeds that the road ahead allows a simulated driver. In: a driver and a position on a route. Out: the highest present speeds with which
//! bends, corners and lower limits ahead remain comfortable, and the curvature of corners. Metres, m/s, radians.

use super::DriverParams;
use crate::{ego::CarParams, map::Route, space::wrap_angle};

/// Step of the look-ahead for bends, m.
const LOOK_EVERY_M: f64 = 5.0;
/// Rounding of positions along a route, m.
const ROUNDING_M: f64 = 1e-6;

/// Returns the highest speed at `s_m` of a route with which every bend ahead remains comfortable for this driver, m/s.
/// The look-ahead is the way needed to stop at half the comfortable deceleration, plus 10 m.
pub fn bend_speed_mps(params: &DriverParams, route: &Route, s_m: f64, speed_mps: f64) -> f64 {
    let decel = params.decel_mps2 / 2.0;
    let far_m = 10.0 + speed_mps * speed_mps / (2.0 * decel);
    let looks = (far_m / LOOK_EVERY_M).ceil() as usize;
    let scale = route.drawn_scale(s_m);
    let window_m = 2.0 * LOOK_EVERY_M / scale;
    let (mut found_mps, mut look) = (f64::INFINITY, 0);
    while look <= looks {
        let ahead_m = look as f64 * LOOK_EVERY_M;
        let at_m = s_m + ahead_m / scale;
        let Bend { felt_per_m: bend, wheel_per_m } = bend_at(route, at_m, scale);
        let comfortable = (params.lateral_accel_mps2 / bend + 2.0 * decel * ahead_m).sqrt();
        // The curvature of a corner is fully visible half a window after the corner begins, and the foot moves a
        // little later.
        let begins_m = (ahead_m - LOOK_EVERY_M - speed_mps.max(0.0) * params.speed_relaxation_s).max(0.0);
        let corner_mps = corner_speed_mps(params, wheel_per_m);
        found_mps = found_mps.min(comfortable.min((corner_mps * corner_mps + 2.0 * decel * begins_m).sqrt()));
        // Of the looks whose windows are on one straight, the first allows the least.
        let straight_m = route.straight_ahead_m(at_m - window_m / 2.0) - window_m - ROUNDING_M;
        look += 1 + ((straight_m * scale / LOOK_EVERY_M) as usize).min(looks);
    }
    found_mps
}

/// Returns the highest speed at `s_m` of a route from which this driver reaches each lower limit ahead in time, m/s. As
/// for bends, the driver brakes with half the comfortable deceleration.
pub(super) fn next_limit_speed_mps(params: &DriverParams, route: &Route, s_m: f64, speed_mps: f64) -> f64 {
    let decel = params.decel_mps2 / 2.0;
    let speed_mps = speed_mps.max(0.0);
    let late_m = speed_mps * params.speed_relaxation_s;
    let far_m = late_m + speed_mps * speed_mps / (2.0 * decel);
    let (lanes, (here, at_m)) = (route.lanes(), route.lane_at(s_m));
    let limit_mps = lanes[here].speed_limit_mps;
    let mut ahead_m = lanes[here].length_m - at_m;
    let mut found_mps = f64::INFINITY;
    for k in here + 1..here + lanes.len() {
        if ahead_m > far_m || (k >= lanes.len() && !route.is_closed()) {
            break;
        }
        let lane = &lanes[k % lanes.len()];
        if lane.speed_limit_mps < limit_mps {
            let braking_m = (ahead_m - late_m).max(0.0);
            found_mps = found_mps.min((lane.speed_limit_mps.powi(2) + 2.0 * decel * braking_m).sqrt());
        }
        ahead_m += lane.length_m;
    }
    found_mps
}

/// Bend for a driver.
struct Bend {
    /// Curvature that determines the lateral acceleration, 1/m.
    felt_per_m: f64,
    /// Curvature that determines the wheel's angle, 1/m.
    wheel_per_m: f64,
}

/// Returns the bend around a position of a route; `scale` is drawn metres per declared metre. In an S-bend within the
/// window the turns to both sides are added, not cancelled: the wheel turns twice as far, over a way 1.5 times as long.
fn bend_at(route: &Route, s_m: f64, scale: f64) -> Bend {
    /// Smallest turn to either side in an S-bend, rad: within 10 m a smaller one moves the line by 0.25 m, for which a
    /// lane has room.
    const SIDE_RAD: f64 = 0.1;
    /// Turn above which a bend is a street corner, rad.
    const CORNER_RAD: f64 = 1.0;
    let window_m = 2.0 * LOOK_EVERY_M / scale;
    let yaws = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|quarter| route.yaw_at(s_m + window_m * quarter / 4.0));
    let turn_per_m = (wrap_angle(yaws[4] - yaws[0]) / window_m).abs().max(1e-6 * scale);
    // Street corners are shorter than the window, so half of it is checked too; gentler bends are cut.
    let half_per_m = || wrap_angle(yaws[3] - yaws[1]).abs() / (window_m / 2.0);
    let wheel_per_m = if turn_per_m * window_m > CORNER_RAD { turn_per_m.max(half_per_m()) } else { turn_per_m };
    let turns = yaws.windows(2).map(|pair| wrap_angle(pair[1] - pair[0]));
    let [left_rad, right_rad] = turns.fold([0.0, 0.0], |[l, r], turn| [l + turn.max(0.0), r - turn.min(0.0)]);
    if left_rad.min(right_rad) < SIDE_RAD {
        return Bend { felt_per_m: turn_per_m / scale, wheel_per_m: wheel_per_m / scale };
    }
    let felt_per_m = (left_rad + right_rad) / (window_m * scale);
    Bend { felt_per_m, wheel_per_m: felt_per_m * 2.0 / 1.5 }
}

/// Returns the curvature of a street corner around a position of a route, 1/m, positive to the left; 0 for no corner.
/// `scale` is drawn metres per declared metre. The curvature is taken between two chords of 5 m, so that a spike in the
/// line is no corner.
pub(super) fn corner_per_m(route: &Route, s_m: f64, scale: f64) -> f64 {
    /// Turn up to which a bend is cut and is no corner, rad.
    const CORNER_RAD: f64 = 0.8;
    let [before, here, after] = [-1.0, 0.0, 1.0].map(|share| route.point_at(s_m + share * LOOK_EVERY_M / scale));
    let turn_rad = (here - before).angle_to(after - here);
    if turn_rad.abs() > CORNER_RAD { turn_rad / LOOK_EVERY_M } else { 0.0 }
}

/// Returns the highest speed at which the arms can turn the wheel in time for a corner of this curvature, m/s; infinite
/// for bends that are no corners.
fn corner_speed_mps(params: &DriverParams, bend_per_m: f64) -> f64 {
    /// Radius below which a bend is a corner, m: the wheel must go round by about half a turn.
    const CORNER_RADIUS_M: f64 = 15.0;
    /// Way on which the wheel is turned, m: on a longer one the ego would leave a lane of 3.2 m.
    const WAY_M: f64 = 3.5;
    if bend_per_m * CORNER_RADIUS_M <= 1.0 {
        return f64::INFINITY;
    }
    let wheelbase_m = CarParams::default().body.wheelbase_m;
    let wheel_rad = (wheelbase_m * bend_per_m).atan() * f64::from(crate::controls::STEERING_RATIO);
    params.wheel_rad_s * WAY_M / wheel_rad
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::RoadMap;

    #[test]
    fn looks_left_out_on_a_straight_change_no_bit() {
        // Streets of 69 m with turns to the right and to the left between them, and a closed route that bends everywhere.
        let grid = RoadMap::load_along("tests/data/networks/grid-signals.net.xml", &["B0B1", "B1C1", "C1C2"]);
        let maps = [grid.expect("a path"), RoadMap::load("ring-250").expect("a map that is shipped")];
        assert!(maps[0].route.straight_ahead_m(1.0) > 60.0 && maps[1].route.straight_ahead_m(1.0) < 60.0);
        let params = DriverParams::default();
        for route in maps.iter().map(|map| &map.route) {
            for (k, speed_mps) in (0..1200).zip([0.0, 3.7, 9.1, 30.0].into_iter().cycle()) {
                let s_m = f64::from(k) * 0.273 - 20.0;
                let (decel, scale) = (params.decel_mps2 / 2.0, route.drawn_scale(s_m));
                let looks = ((10.0 + speed_mps * speed_mps / (2.0 * decel)) / LOOK_EVERY_M).ceil() as u32;
                // Every look, as the least speed is defined.
                let each = (0..=looks).map(|look| {
                    let ahead_m = f64::from(look) * LOOK_EVERY_M;
                    let bend = bend_at(route, s_m + ahead_m / scale, scale);
                    let begins_m = (ahead_m - LOOK_EVERY_M - speed_mps * params.speed_relaxation_s).max(0.0);
                    let corner_mps = corner_speed_mps(&params, bend.wheel_per_m);
                    let comfortable = (params.lateral_accel_mps2 / bend.felt_per_m + 2.0 * decel * ahead_m).sqrt();
                    comfortable.min((corner_mps * corner_mps + 2.0 * decel * begins_m).sqrt())
                });
                let least_mps = each.fold(f64::INFINITY, f64::min);
                let found_mps = bend_speed_mps(&params, route, s_m, speed_mps);
                assert_eq!(found_mps.to_bits(), least_mps.to_bits(), "at {s_m} m with {speed_mps} m/s");
            }
        }
    }
}
