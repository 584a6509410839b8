//! Way of a vehicle from one step of the traffic to the next. In: the vehicle at both steps. Out: the vehicle at any time between. Metres, m/s.

use crate::{
    map::{Route, network::LanePosition},
    space::{Pose, wrap_angle},
    traffic::{Articulation, EGO, VehicleId, VehicleState},
};

/// Distance in a step that counts as a jump, metres: beyond twice what the speeds explain (a lane may be drawn longer than its declared
/// length), or sideways. SUMO moved the vehicle there at once. Interpolated over the step, it would hit vehicles in between at an
/// impossible speed.
const JUMP_M: f64 = 1.0;
/// Lateral share of the distance in a step that a bend, or a lane change in a long step, explains.
const SIDEWAYS: f64 = 0.25;

/// A vehicle with its position on the ego's route.
#[derive(Clone, Copy, Debug)]
pub(super) struct PlacedVehicle {
    pub vehicle: VehicleState,
    pub s_m: Option<f64>,
}

/// Way of a vehicle from the last step to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepWay {
    pub id: VehicleId,
    /// The vehicle at the last step; `None` if it departs in this one.
    pub from: Option<PlacedVehicle>,
    /// The vehicle at the next step; `None` if it arrives in this one.
    pub to: Option<PlacedVehicle>,
    /// True if the engine moves the vehicle at once.
    pub jumps: bool,
    /// Distance along the ego's route, metres; `None` if it cannot have been driven.
    pub route_way_m: Option<f64>,
}

/// A vehicle interpolated within a step.
pub(super) struct Shown {
    pub pose: Pose,
    pub articulation: Option<Articulation>,
    pub height_m: f64,
    pub s_m: Option<f64>,
    pub lane: Option<LanePosition>,
    pub speed_mps: f64,
}

impl StepWay {
    /// Returns the way between two steps of `step_s` seconds; at least one of both ends is known.
    pub fn of(from: Option<PlacedVehicle>, to: Option<PlacedVehicle>, route: &Route, step_s: f64) -> Self {
        let id = from.or(to).map_or(EGO, |placed| placed.vehicle.id);
        let Some((a, b)) = from.zip(to) else { return Self { id, from, to, jumps: false, route_way_m: None } };
        let farthest_m = 2.0 * a.vehicle.speed_mps.max(b.vehicle.speed_mps) * step_s + JUMP_M;
        let jumps = !is_short(&a.vehicle, &b.vehicle) && {
            let [begin, end] =
                [&a.vehicle, &b.vehicle].map(|at| Pose::new(at.pose.front(at.body.length_m), at.pose.yaw_rad));
            is_jump(&begin, &end, farthest_m)
        };
        let ends = a.s_m.zip(b.s_m).filter(|_| !jumps);
        Self { id, from, to, jumps, route_way_m: ends.and_then(|ends| driven_m(route, ends, farthest_m)) }
    }

    /// Returns the vehicle at `fraction` of the step.
    pub fn between(&self, from: &PlacedVehicle, to: &PlacedVehicle, route: &Route, fraction: f64) -> Shown {
        let (a, b, jumps) = (&from.vehicle, &to.vehicle, self.jumps);
        let mix = |a: f64, b: f64| a + (b - a) * fraction;
        let nearer = if fraction < 0.5 { from } else { to };
        let lane = match (a.lane_position(), b.lane_position()) {
            (Some(from), Some(to)) if from.lane == to.lane && !jumps => Some(LanePosition {
                lane: to.lane,
                s_m: mix(from.s_m, to.s_m),
                offset_m: mix(from.offset_m, to.offset_m),
            }),
            _ => nearer.vehicle.lane_position(),
        };
        let on_route = from.s_m.zip(self.route_way_m);
        Shown {
            pose: if jumps { nearer.vehicle.pose } else { a.pose.lerp(&b.pose, fraction) },
            articulation: match (a.articulation, b.articulation) {
                (Some(from), Some(to)) if !jumps => Some(from.lerp(&to, fraction)),
                _ => nearer.vehicle.articulation,
            },
            height_m: if jumps { nearer.vehicle.height_m } else { mix(a.height_m, b.height_m) },
            s_m: on_route.map(|(from_s_m, way_m)| route.wrap(from_s_m + way_m * fraction)).or(nearer.s_m),
            lane,
            speed_mps: mix(a.speed_mps, b.speed_mps),
        }
    }
}

/// Returns true if the front has moved by less than [`JUMP_M`] less rounding: no jump in any direction, and found without sines.
fn is_short(from: &VehicleState, to: &VehicleState) -> bool {
    let turn_rad = wrap_angle(to.pose.yaw_rad - from.pose.yaw_rad).abs();
    from.pose.position.distance(to.pose.position) + to.body.length_m / 2.0 * turn_rad < 0.99 * JUMP_M
}

/// Returns true if a front bumper cannot have driven from one pose to the other: the distance is too long, or too far sideways of its
/// heading. The chord of an arc points midway between the headings at its ends. (In SUMO the front drives: the rear of a long vehicle
/// swings out when it begins a lane change after a bend.)
fn is_jump(from: &Pose, to: &Pose, farthest_m: f64) -> bool {
    let way = to.position - from.position;
    let sideways_m = way.dot(from.lerp(to, 0.5).left()).abs();
    way.length() > farthest_m || sideways_m > JUMP_M.max(SIDEWAYS * way.length())
}

/// Returns the distance along the route between two steps, metres. `None` if it is too long to have been driven: where a route passes
/// twice, a vehicle has two positions.
fn driven_m(route: &Route, (from_s_m, to_s_m): (f64, f64), farthest_m: f64) -> Option<f64> {
    Some(route.difference(from_s_m, to_s_m)).filter(|way_m| way_m.abs() <= farthest_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::RoadMap;
    use glam::dvec2;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn a_vehicle_moved_sideways_or_far_ahead_has_jumped_and_a_turning_one_not() {
        let at = |x: f64, y: f64, yaw_rad: f64| Pose::new(dvec2(x, y), yaw_rad);
        let here = at(0.0, 0.0, 0.0);
        // 10 m/s for 0.1 s: at most 2 m plus 1 m.
        assert!(!is_jump(&here, &at(1.0, 0.1, 0.0), 3.0));
        // A lane of 3.2 m sideways, stopped or moving.
        assert!(is_jump(&here, &at(0.0, 3.2, 0.0), 1.0) && is_jump(&here, &at(1.0, 2.8, 0.0), 3.0));
        // Across a junction of 12 m without internal lanes.
        assert!(is_jump(&here, &at(12.0, 0.0, 0.0), 3.0));
        // A quarter circle with a radius of 6 m in a step of 1 s: 9.4 m.
        assert!(!is_jump(&here, &at(6.0, 6.0, FRAC_PI_2), 20.0));
    }

    #[test]
    fn positions_too_far_apart_to_be_driven_are_not_interpolated() {
        // Round a block and along its first edge again: B0B1 begins at 0 and after four blocks of 90 m (69.2 m and 20.8 m, or 9.03 m in a
        // turn).
        let edges = ["B0B1", "B1C1", "C1C0", "C0B0", "B0B1"];
        let map = RoadMap::load_along("tests/data/networks/grid-signals.net.xml", &edges).expect("a path");
        let again_m =
            map.route.lanes().iter().rfind(|lane| lane.edge_id(&map.network) == "B0B1").expect("twice").start_s_m;
        assert!(again_m > 300.0);
        assert_eq!(driven_m(&map.route, (10.0, 12.0), 7.0), Some(2.0));
        assert_eq!(driven_m(&map.route, (10.0, again_m + 12.0), 7.0), None);
    }
}
