//! Simulated drivers. In: what a person in the seat could perceive ([`Perception`]). Out: [`Controls`], through the same
//! pedals and wheel as people, so that a whole study can be rehearsed without anyone. Seeded; SI units.
//!
//! Each tick: the senses deliver late what was advised and anticipate the leader (`senses`); the wanted acceleration is
//! the smallest of "reach the advised speed", "keep behind the leader" (IDM) and "slow for the bend or the lower limit"; one foot turns it
//! into pedals (`feet`), two hands the lane into an angle of the wheel (`hands`).

mod compliance;
mod fitted;
mod named;
mod params;
mod pedals;
mod perception;
mod population;
mod steering;

pub use compliance::{Compliance, HELD_BACK_S};
pub use fitted::{DriversFile, DriversFileError, FORMAT as DRIVERS_FORMAT, FittedDriver};
pub use named::{NamedDriver, named};
pub use params::{DriverError, DriverParams, LeaderRule, MACHINES, PRESETS, preset};
pub use population::{LONGEST_REACTION_S, Population};

use crate::{
    controls::{Controls, Indicator, Selector},
    ego::{CarParams, EgoState},
    map::Route,
    policy::Advice,
    rng,
    space::wrap_angle,
};
use compliance::AdviceTaken;
use glam::{DVec2, dvec2};
use pedals::PedalModel;
use perception::{DelayedPerception, OrnsteinUhlenbeck};
use steering::SteeringModel;
pub use steering::TURN_IN_S;

/// Time constant of the wander in the lane, s.
const LANE_TIME_S: f64 = 8.0;

/// What a person in the seat perceives in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Perception {
    /// Own speed, m/s.
    pub speed_mps: f64,
    /// The lane, from [`SimulatedDriver::look`].
    pub lane: LaneView,
    /// The car ahead, if there is one.
    pub leader: Option<SeenLeader>,
    /// Way from the front bumper to a line that must not be crossed now, metres: of a signal that is not green, or where others
    /// go first.
    pub stop_ahead_m: Option<f64>,
    /// The advice on the speedometer, if there is one.
    pub advice: Option<Advice>,
    /// Speed limit, m/s.
    pub speed_limit_mps: f64,
    /// The side to which the path turns soon, or changes lanes.
    pub indicator: Indicator,
}

/// The car ahead.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeenLeader {
    /// Own front bumper to its rear bumper, metres.
    pub gap_m: f64,
    /// Its speed, m/s.
    pub speed_mps: f64,
}

/// The lane as seen from the seat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaneView {
    /// Offset of the rear axle from the centre line, metres, positive to the left.
    pub offset_m: f64,
    /// Own heading less the lane's, radians.
    pub heading_error_rad: f64,
    /// A point of the centre line ahead, from the rear axle: x along the car, y to its left, metres.
    pub aim: DVec2,
    /// Curvatures of the corners where it will be [`TURN_IN_S`] later, 1/m; 0 where there are none.
    pub next_corners_per_m: [f64; TURN_IN_S.len()],
    /// Highest speed from which every bend ahead is still comfortable, m/s.
    pub bend_speed_mps: f64,
    /// Highest speed from which every limit ahead that is lower than that here is comfortably reached where it begins, m/s.
    pub next_limit_speed_mps: f64,
    /// Grade of the road under the car, the tangent of the slope's angle, positive uphill.
    pub grade: f64,
}

impl Default for LaneView {
    /// A straight lane, followed exactly.
    fn default() -> Self {
        let (bend_speed_mps, next_limit_speed_mps) = (f64::INFINITY, f64::INFINITY);
        let aim = dvec2(10.0, 0.0);
        Self {
            offset_m: 0.0,
            heading_error_rad: 0.0,
            aim,
            next_corners_per_m: [0.0; TURN_IN_S.len()],
            bend_speed_mps,
            next_limit_speed_mps,
            grade: 0.0,
        }
    }
}

/// A simulated driver in the ego.
#[derive(Clone, Debug)]
pub struct SimulatedDriver {
    params: DriverParams,
    rear_axle_m: f64,
    advice: AdviceTaken,
    senses: DelayedPerception,
    feet: PedalModel,
    hands: SteeringModel,
    speed_wander: OrnsteinUhlenbeck,
    lane_wander: OrnsteinUhlenbeck,
}

impl SimulatedDriver {
    /// A driver who knows the car. The same seed drives the same way.
    ///
    /// # Errors
    /// If a number of the driver is outside of what can be simulated.
    pub fn new(params: &DriverParams, car: &CarParams, seed: u64) -> Result<Self, DriverError> {
        params.check()?;
        Ok(Self {
            rear_axle_m: car.body.front_axle_m - car.body.wheelbase_m,
            advice: AdviceTaken::new(Compliance::of(params, seed)),
            senses: DelayedPerception::new(params.reaction_s, params.leader_reaction_s),
            feet: PedalModel::new(car),
            hands: SteeringModel::new(car),
            speed_wander: OrnsteinUhlenbeck::new(
                params.error_mps,
                params.error_time_s,
                rng::stream(seed, "driver/speed"),
            ),
            lane_wander: OrnsteinUhlenbeck::new(params.lane_error_m, LANE_TIME_S, rng::stream(seed, "driver/lane")),
            params: params.clone(),
        })
    }

    /// The same with a foot on the brake, as where a drive begins at a standstill.
    pub fn with_foot_on_brake(mut self) -> Self {
        self.feet.hold();
        self
    }

    /// The driver's numbers.
    pub fn params(&self) -> &DriverParams {
        &self.params
    }

    /// The lane of `route` as seen from the car; `near_s_m` is where the car is thought to be on it.
    pub fn look(&self, route: &Route, ego: &EgoState, near_s_m: Option<f64>) -> LaneView {
        self.look_beside(route, ego, near_s_m, |_| 0.0)
    }

    /// The same of a line that runs `beside_m` to the left of the route's at a place of it, metres.
    pub fn look_beside(
        &self,
        route: &Route,
        ego: &EgoState,
        near_s_m: Option<f64>,
        beside_m: impl Fn(f64) -> f64,
    ) -> LaneView {
        let pose = ego.pose();
        let rear = pose.position + pose.forward() * self.rear_axle_m;
        let here = route.project(rear, near_s_m);
        let ahead_m = steering::preview_m(&self.params, ego.speed_mps);
        let scale = route.drawn_scale(here.s_m);
        let aim_s_m = here.s_m + ahead_m / scale;
        let to_line = DVec2::from_angle(route.yaw_at(aim_s_m)).perp() * beside_m(aim_s_m);
        let to_aim = route.point_at(aim_s_m) + to_line - rear;
        let corner_later =
            |after_s: f64| corner_per_m(route, here.s_m + ego.speed_mps.max(0.0) * after_s / scale, scale);
        LaneView {
            offset_m: here.offset_m - beside_m(here.s_m),
            heading_error_rad: wrap_angle(pose.yaw_rad - route.yaw_at(here.s_m)),
            aim: dvec2(to_aim.dot(pose.forward()), to_aim.dot(pose.left())),
            next_corners_per_m: TURN_IN_S.map(corner_later),
            bend_speed_mps: bend_speed_mps(&self.params, route, here.s_m, ego.speed_mps),
            next_limit_speed_mps: next_limit_speed_mps(&self.params, route, here.s_m, ego.speed_mps),
            grade: route.grade(here.s_m),
        }
    }

    /// The controls of this tick.
    pub fn controls(&mut self, now: &Perception) -> Controls {
        let wanted_mps2 = self.wanted_mps2(now);
        let (throttle, brake) = self.feet.press(&self.params, now.speed_mps, wanted_mps2, now.lane.grade);
        let wander_m = self.lane_wander.next();
        let steering_wheel_rad = self.hands.turn(&self.params, now.speed_mps, &now.lane, wander_m);
        Controls { throttle, brake, steering_wheel_rad, selector: Selector::Drive, indicator: now.indicator }
    }

    /// The acceleration that the driver wants, m/s2.
    fn wanted_mps2(&mut self, now: &Perception) -> f64 {
        let advised_mps = now.advice.map(|advice| advice.target_mps);
        let seen_mps = self.advice.see(advised_mps, now.leader.map(|leader| leader.speed_mps));
        let (target_mps, leader) = self.senses.see(now, seen_mps);
        let stop_ahead_m = self.senses.see_stop(now);
        let wander_mps = self.speed_wander.next();
        let p = &self.params;
        let reach =
            |speed_mps: f64| ((speed_mps - now.speed_mps) / p.speed_relaxation_s).clamp(-p.decel_mps2, p.accel_mps2);
        let v0 = p.idm.v0.min(now.speed_limit_mps.max(1.0));
        let follow = |gap_m: f64, speed_mps: f64| {
            let idm = crate::idm::IdmParams { v0, ..p.idm };
            idm.acceleration(now.speed_mps.max(0.0), speed_mps, gap_m)
        };
        let target_mps = target_mps.filter(|_| p.follows_advice && self.advice.follows());
        let rule = if target_mps.is_some() { p.leader_rule } else { LeaderRule::Model };
        let behind = match (rule, leader) {
            (LeaderRule::Ignore, _) | (LeaderRule::Guard, None) => f64::INFINITY,
            (LeaderRule::Guard, Some(leader)) => guarded_mps2(p, now.speed_mps, &leader),
            (LeaderRule::Model, Some(leader)) => follow(leader.gap_m, leader.speed_mps),
            (LeaderRule::Model, None) => follow(1e6, now.speed_mps),
        };
        let road = reach(now.lane.bend_speed_mps.min(now.lane.next_limit_speed_mps));
        let advised = target_mps.map_or(f64::INFINITY, |target_mps| {
            // Bias and error fade below 1 m/s: nobody errs about a standstill.
            let own = (p.speed_bias_mps + wander_mps) * target_mps.clamp(0.0, 1.0);
            let wanted_mps = (target_mps + own).min(now.speed_limit_mps).max(0.0);
            let off_mps = wanted_mps - now.speed_mps;
            reach(wanted_mps - off_mps.clamp(-p.deadband_mps, p.deadband_mps))
        });
        // As behind a leader that stands on the line, whatever rule holds behind cars.
        let stop = stop_ahead_m.map_or(f64::INFINITY, |gap_m| follow(gap_m, 0.0));
        behind.min(advised).min(road).min(stop)
    }
}

/// Bends are looked at in such steps, metres.
const LOOK_EVERY_M: f64 = 5.0;

/// The highest speed at `s_m` of a route from which every bend ahead is still comfortable for this driver, m/s. Looks as far as the
/// car needs to slow down at half the comfortable deceleration.
pub fn bend_speed_mps(params: &DriverParams, route: &Route, s_m: f64, speed_mps: f64) -> f64 {
    let decel = params.decel_mps2 / 2.0;
    let far_m = 10.0 + speed_mps * speed_mps / (2.0 * decel);
    let looks = (far_m / LOOK_EVERY_M).ceil() as usize;
    let scale = route.drawn_scale(s_m);
    (0..=looks)
        .map(|i| {
            let ahead_m = i as f64 * LOOK_EVERY_M;
            let Bend { felt_per_m: bend, wheel_per_m } = bend_at(route, s_m + ahead_m / scale, scale);
            let comfortable = (params.lateral_accel_mps2 / bend + 2.0 * decel * ahead_m).sqrt();
            // A corner begins half a window before its curvature is seen whole, and the foot comes down a little later.
            let begins_m = (ahead_m - LOOK_EVERY_M - speed_mps.max(0.0) * params.speed_relaxation_s).max(0.0);
            let corner_mps = corner_speed_mps(params, wheel_per_m);
            comfortable.min((corner_mps * corner_mps + 2.0 * decel * begins_m).sqrt())
        })
        .fold(f64::INFINITY, f64::min)
}

/// The highest speed at `s_m` of a route from which this driver comes to each limit ahead that is lower than that here with no more than its
/// speed, m/s: comfortably, as for bends.
fn next_limit_speed_mps(params: &DriverParams, route: &Route, s_m: f64, speed_mps: f64) -> f64 {
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

/// A bend as a driver has to take it.
struct Bend {
    /// Curvature that is felt, 1/m.
    felt_per_m: f64,
    /// Curvature by which the wheel has to go round, 1/m.
    wheel_per_m: f64,
}

/// The bend around a place of a route of which a declared metre is drawn `scale` metres long. Of an S within a window the turns to
/// either side are added up, not set off, and the wheel goes round twice as far, on a way that is half as long again.
fn bend_at(route: &Route, s_m: f64, scale: f64) -> Bend {
    /// Less to one of the sides is no S, radians: within 10 m it moves the line by a quarter of a metre, which a lane has room for.
    const SIDE_RAD: f64 = 0.1;
    /// A turn by more than this is that of a street corner, radians.
    const CORNER_RAD: f64 = 1.0;
    let window_m = 2.0 * LOOK_EVERY_M / scale;
    let yaws = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|quarter| route.yaw_at(s_m + window_m * quarter / 4.0));
    let turn_per_m = (wrap_angle(yaws[4] - yaws[0]) / window_m).abs().max(1e-6 * scale);
    // The corners of streets are shorter than the window; a bend by less is cut.
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

/// The curvature of a street corner around a place of a route of which a declared metre is drawn `scale` metres long, positive to the left, 1/m;
/// 0 where there is none. It is that between two ways of 5 m, so that a spike in the line is no corner.
fn corner_per_m(route: &Route, s_m: f64, scale: f64) -> f64 {
    /// A bend by less is cut, radians.
    const CORNER_RAD: f64 = 0.8;
    let [before, here, after] = [-1.0, 0.0, 1.0].map(|share| route.point_at(s_m + share * LOOK_EVERY_M / scale));
    let turn_rad = (here - before).angle_to(after - here);
    if turn_rad.abs() > CORNER_RAD { turn_rad / LOOK_EVERY_M } else { 0.0 }
}

/// The speed at which arms can still turn the wheel in time for a corner of this curvature, m/s; no bound on bends that are no
/// corners.
fn corner_speed_mps(params: &DriverParams, bend_per_m: f64) -> f64 {
    /// A bend of a smaller radius is a corner, metres: the wheel has to go round by more than half a turn.
    const CORNER_RADIUS_M: f64 = 15.0;
    /// The way on which the wheel is turned, metres: on more, the car would leave a lane of 3.2 m on the inside or the outside.
    const WAY_M: f64 = 3.5;
    if bend_per_m * CORNER_RADIUS_M <= 1.0 {
        return f64::INFINITY;
    }
    let wheelbase_m = CarParams::default().body.wheelbase_m;
    let wheel_rad = (wheelbase_m * bend_per_m).atan() * f64::from(crate::controls::STEERING_RATIO);
    params.wheel_rad_s * WAY_M / wheel_rad
}

/// The most that may be accelerated without a collision in sight, m/s2: the safe speed of Krauss (1998), from which the car
/// still stops behind the leader if that brakes as hard as this driver does.
fn guarded_mps2(p: &DriverParams, speed_mps: f64, leader: &SeenLeader) -> f64 {
    /// From the wish to brake to the brake's effect: the foot, the pedal, the car, s.
    const DELAY_S: f64 = 0.6;
    /// Gap that is kept at a stop, metres.
    const GAP_M: f64 = 1.0;
    let delay_mps = p.decel_mps2 * DELAY_S;
    let room_m = (leader.gap_m - GAP_M).max(0.0);
    let safe_mps =
        (delay_mps * delay_mps + leader.speed_mps.max(0.0).powi(2) + 2.0 * p.decel_mps2 * room_m).sqrt() - delay_mps;
    ((safe_mps - speed_mps) / DELAY_S).max(-9.0)
}
