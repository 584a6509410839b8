//! Simulated drivers. In: what a person in the seat could perceive ([`Perception`]). Out: [`Controls`], through the
//! same pedals and wheel as people, so that a whole study can be rehearsed without participants. Seeded; SI units.
//!
//! Each tick, `perception` delivers the advice with the driver's delay and anticipates the leader. The wanted
//! acceleration is the smallest of three: reach the advised speed, keep the distance to the leader (IDM), slow down for
//! a bend, a lower limit (`speeds_ahead`) or a stop line. `pedals` turns it into accelerator and brake, `steering` the lane into an
//! angle of the wheel. [`manoeuvres`] decides on networks: right of way and lane changes.

mod automated;
mod compliance;
mod cruise_control;
mod fitted;
pub mod manoeuvres;
mod named;
mod params;
mod pedals;
mod perception;
mod population;
mod secondary_task;
mod speeds_ahead;
mod steering;
mod supervision;

pub use automated::{AutomatedDriver, SpeedGoal};
pub use compliance::{Compliance, HELD_BACK_S};
pub use fitted::{DriversFile, DriversFileError, FORMAT as DRIVERS_FORMAT, FittedDriver};
pub use named::{NamedDriver, named};
pub use params::{DriverError, DriverParams, LeaderRule, MACHINES, PRESETS, preset};
pub use population::{LONGEST_REACTION_S, Population};
pub use speeds_ahead::bend_speed_mps;

use crate::{
    controls::{Controls, Indicator, Selector},
    ego::{CarParams, EgoState},
    idm::IdmParams,
    map::Route,
    policy::Advice,
    rng,
    snapshot::{AutomationState, TaskDisplay},
    space::wrap_angle,
    traffic::{AccelNoise, CarFollowing, TrafficDrivers},
};
use compliance::AdviceTaken;
use glam::{DVec2, dvec2};
use pedals::PedalModel;
use perception::{DelayedPerception, OrnsteinUhlenbeck};
use secondary_task::TaskResponder;
use speeds_ahead::{corner_per_m, next_limit_speed_mps};
use steering::SteeringModel;
pub use steering::TURN_IN_S;
use supervision::Supervisor;

/// Time constant of the driver's deviation from the centre line, s.
const LANE_TIME_S: f64 = 8.0;

/// Perception of the driver in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Perception {
    /// Speed of the ego, m/s.
    pub speed_mps: f64,
    /// Lane ahead, from [`SimulatedDriver::look`].
    pub lane: LaneView,
    /// Leader, if there is one.
    pub leader: Option<SeenLeader>,
    /// Distance from the front bumper to a line that must not be crossed now, m: at a signal that is not green, or
    /// where others have right of way.
    pub stop_ahead_m: Option<f64>,
    /// Advice on the speedometer, if there is any.
    pub advice: Option<Advice>,
    pub speed_limit_mps: f64,
    /// Side to which the path turns or changes lanes next.
    pub indicator: Indicator,
    /// Secondary task of the driver.
    pub task: TaskDisplay,
    /// Automation of the ego.
    pub automation: AutomationState,
    /// Angle of the steering wheel, rad, positive to the left; the automation turns it, too.
    pub wheel_rad: f32,
}

/// Leader as the driver perceives it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeenLeader {
    /// Gap from the own front bumper to the leader's rear bumper, m.
    pub gap_m: f64,
    /// Speed of the leader, m/s.
    pub speed_mps: f64,
}

/// Lane as seen from the seat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaneView {
    /// Offset of the rear axle from the centre line, m, positive to the left.
    pub offset_m: f64,
    /// Heading of the ego relative to the lane, rad.
    pub heading_error_rad: f64,
    /// Target point on the centre line, relative to the rear axle: x along the ego, y to its left, m.
    pub aim: DVec2,
    /// Curvatures of the corners at the positions [`TURN_IN_S`] ahead, 1/m; 0 for no corner.
    pub next_corners_per_m: [f64; TURN_IN_S.len()],
    /// Highest present speed with which every bend ahead remains comfortable, m/s.
    pub bend_speed_mps: f64,
    /// Highest present speed from which every lower speed limit ahead can be reached comfortably where it begins, m/s.
    pub next_limit_speed_mps: f64,
    /// Grade of the road at the ego, the tangent of the slope angle, positive uphill.
    pub grade: f64,
}

impl Default for LaneView {
    /// Returns a straight lane, followed exactly.
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

/// Simulated driver of the ego.
#[derive(Clone, Debug)]
pub struct SimulatedDriver {
    params: DriverParams,
    /// Model with which the driver keeps the distance to a leader.
    following: CarFollowing,
    rear_axle_m: f64,
    advice: AdviceTaken,
    senses: DelayedPerception,
    pedals: PedalModel,
    steering: SteeringModel,
    speed_wander: OrnsteinUhlenbeck,
    /// Noise of the acceleration with which the driver keeps the distance, m/s2.
    following_noise: OrnsteinUhlenbeck,
    lane_wander: OrnsteinUhlenbeck,
    task: TaskResponder,
    supervisor: Supervisor,
}

impl SimulatedDriver {
    /// Creates a driver that knows the ego's parameters. The same seed drives the same way.
    ///
    /// # Errors
    /// A number of the driver is outside the range that can be simulated.
    pub fn new(params: &DriverParams, car: &CarParams, seed: u64) -> Result<Self, DriverError> {
        params.check()?;
        Ok(Self {
            rear_axle_m: car.body.front_axle_m - car.body.wheelbase_m,
            advice: AdviceTaken::new(Compliance::of(params, seed)),
            senses: DelayedPerception::new(params.reaction_s, params.leader_reaction_s),
            pedals: PedalModel::new(car),
            steering: SteeringModel::new(car),
            speed_wander: OrnsteinUhlenbeck::new(
                params.error_mps,
                params.error_time_s,
                rng::stream(seed, "driver/speed"),
            ),
            lane_wander: OrnsteinUhlenbeck::new(params.lane_error_m, LANE_TIME_S, rng::stream(seed, "driver/lane")),
            following: CarFollowing::Idm(params.idm),
            following_noise: OrnsteinUhlenbeck::new(0.0, 1.0, rng::stream(seed, "driver/following")),
            task: TaskResponder::new(seed),
            supervisor: Supervisor::new(seed),
            params: params.clone(),
        })
    }

    /// Lets the driver follow as the average person of this traffic, if its drivers are measured people: with their model and without a
    /// further reaction time to the leader, because the measured lag is that of the model (docs/references.md: people). A driver with
    /// another time gap than usual keeps it in proportion. One who errs has the noise of the average person, too.
    pub fn among(mut self, traffic: &TrafficDrivers) -> Self {
        if !traffic.are_alike() {
            let factor = self.params.idm.t / IdmParams::default().t;
            self.following = traffic.typical().model.with_time_gap(factor);
            self.senses = DelayedPerception::new(self.params.reaction_s, 0.0);
            if let (true, AccelNoise::OrnsteinUhlenbeck { sd_mps2, memory_s }) =
                (self.params.errs(), traffic.typical().noise)
            {
                self.following_noise.scale(sd_mps2, memory_s);
            }
        }
        self
    }

    /// Puts the driver's foot on the brake, for a drive that begins at a standstill.
    pub fn with_foot_on_brake(mut self) -> Self {
        self.pedals.hold();
        self
    }

    pub fn params(&self) -> &DriverParams {
        &self.params
    }

    /// Returns the lane of `route` as seen from the ego; `near_s_m` is the expected position of the ego on it.
    pub fn look(&self, route: &Route, ego: &EgoState, near_s_m: Option<f64>) -> LaneView {
        self.look_beside(route, ego, near_s_m, |_| 0.0)
    }

    /// Returns the view of a line that runs `beside_m` to the left of the route at each position, m.
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
            ..self.look_along(route, here.s_m, ego.speed_mps)
        }
    }

    /// Returns the view of a lane that the vehicle keeps by itself: the speeds that the road ahead allows, and its grade.
    pub fn look_along(&self, route: &Route, s_m: f64, speed_mps: f64) -> LaneView {
        LaneView {
            bend_speed_mps: bend_speed_mps(&self.params, route, s_m, speed_mps),
            next_limit_speed_mps: next_limit_speed_mps(&self.params, route, s_m, speed_mps),
            grade: route.grade(s_m),
            ..LaneView::default()
        }
    }

    /// Returns the controls of this tick. Where the automation drives, the feet rest and the hands go with the wheel.
    pub fn controls(&mut self, now: &Perception) -> Controls {
        let pedals = self.pedals(now);
        let wander_m = self.lane_wander.next();
        let steering_wheel_rad = match now.automation.steers_now() {
            true => self.steering.hold(now.wheel_rad),
            false => self.steering.turn(&self.params, now.speed_mps, &now.lane, wander_m),
        };
        let automation_button = self.supervisor.presses(now.automation.mode);
        Controls { steering_wheel_rad, automation_button, task_button: self.task.press(now.task), ..pedals }
    }

    /// Returns the controls of this tick with the steering wheel straight, for a vehicle that keeps its line by itself.
    pub fn pedals(&mut self, now: &Perception) -> Controls {
        let wanted_mps2 = self.wanted_mps2(now);
        if now.automation.keeps_speed_now() {
            self.pedals.rest_on(0.0, 0.0);
            return Controls { selector: Selector::Drive, indicator: now.indicator, ..Controls::default() };
        }
        self.press(now, wanted_mps2)
    }

    /// Returns the pedals of this tick for a wanted acceleration, m/s², with the steering wheel straight.
    fn press(&mut self, now: &Perception, wanted_mps2: f64) -> Controls {
        let (throttle, brake) = self.pedals.press(&self.params, now.speed_mps, wanted_mps2, now.lane.grade);
        Controls { throttle, brake, selector: Selector::Drive, indicator: now.indicator, ..Controls::default() }
    }

    /// Returns the wanted acceleration, m/s².
    fn wanted_mps2(&mut self, now: &Perception) -> f64 {
        let advised_mps = now.advice.map(|advice| advice.target_mps);
        let seen_mps = self.advice.see(advised_mps, now.leader.map(|leader| leader.speed_mps));
        let (target_mps, leader) = self.senses.see(now, seen_mps);
        let stop_ahead_m = self.senses.see_stop(now);
        let wander_mps = self.speed_wander.next();
        // Like every error, the noise fades below 1 m/s.
        let noise_mps2 = self.following_noise.next() * now.speed_mps.clamp(0.0, 1.0);
        let p = &self.params;
        let reach =
            |speed_mps: f64| ((speed_mps - now.speed_mps) / p.speed_relaxation_s).clamp(-p.decel_mps2, p.accel_mps2);
        let by = |model: &CarFollowing, gap_m: f64, speed_mps: f64| {
            model.acceleration(now.speed_mps.max(0.0), speed_mps, gap_m, now.speed_limit_mps.max(1.0))
        };
        let follow = |gap_m: f64, speed_mps: f64| noise_mps2 + by(&self.following, gap_m, speed_mps);
        let target_mps = target_mps.filter(|_| p.follows_advice && self.advice.follows());
        let rule = if target_mps.is_some() { p.leader_rule } else { LeaderRule::Model };
        let behind = match (rule, leader) {
            (LeaderRule::Ignore, _) | (LeaderRule::Guard, None) => f64::INFINITY,
            (LeaderRule::Guard, Some(leader)) => guarded_mps2(p, now.speed_mps, &leader),
            (LeaderRule::Model, Some(leader)) => follow(leader.gap_m, leader.speed_mps),
            (LeaderRule::Model, None) => follow(1e6, now.speed_mps),
        };
        let road = reach(now.lane.bend_speed_mps.min(now.lane.next_limit_speed_mps));
        // Models of following keep the limit by themselves, without the error with which an advised speed is kept. Advice to drive as fast as
        // the limit allows asks for nothing more.
        let asks = |target_mps: &f64| rule != LeaderRule::Model || *target_mps < now.speed_limit_mps;
        let advised = target_mps.filter(asks).map_or(f64::INFINITY, |target_mps| {
            // Bias and error fade below 1 m/s: there is no error about a standstill.
            let own = (p.speed_bias_mps + wander_mps) * target_mps.clamp(0.0, 1.0);
            let wanted_mps = (target_mps + own).min(now.speed_limit_mps).max(0.0);
            let off_mps = wanted_mps - now.speed_mps;
            reach(wanted_mps - off_mps.clamp(-p.deadband_mps, p.deadband_mps))
        });
        // The line is treated as a standing leader, whatever the rule for leaders is. Measured models know no lines.
        let stop = stop_ahead_m.map_or(f64::INFINITY, |gap_m| by(&CarFollowing::Idm(p.idm), gap_m, 0.0));
        behind.min(advised).min(road).min(stop)
    }
}

/// Returns the largest acceleration without an imminent collision, m/s². It follows from the safe speed of Krauss
/// (1998), at which the ego can still stop behind a leader that brakes as hard as this driver does.
fn guarded_mps2(p: &DriverParams, speed_mps: f64, leader: &SeenLeader) -> f64 {
    /// Delay from the decision to brake to the effect of the brake (foot, pedal, vehicle), s.
    const DELAY_S: f64 = 0.6;
    /// Gap that is kept at a stop, m.
    const GAP_M: f64 = 1.0;
    let delay_mps = p.decel_mps2 * DELAY_S;
    let room_m = (leader.gap_m - GAP_M).max(0.0);
    let safe_mps =
        (delay_mps * delay_mps + leader.speed_mps.max(0.0).powi(2) + 2.0 * p.decel_mps2 * room_m).sqrt() - delay_mps;
    ((safe_mps - speed_mps) / DELAY_S).max(-9.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{time::TICK_S, traffic::TrafficDrivers};

    /// Returns what a driver sees behind a leader on a road with a limit of 30 m/s.
    fn behind(speed_mps: f64, gap_m: f64, leader_mps: f64) -> Perception {
        let leader = Some(SeenLeader { gap_m, speed_mps: leader_mps });
        Perception { speed_mps, leader, speed_limit_mps: 30.0, ..Perception::default() }
    }

    #[test]
    fn among_measured_people_a_driver_follows_by_their_model() {
        let car = CarParams::default();
        for (name, factor) in [("safe-followers", 1.0), ("gap-closers", 1.0), ("gap-closers", 1.2)] {
            let people = TrafficDrivers::named(name, IdmParams::default()).expect("a shipped population");
            let mut params = preset("perfect").expect("a preset");
            params.idm.t *= factor;
            let mut driver = SimulatedDriver::new(&params, &car, 1).expect("a driver").among(&people);
            // Nothing is late: the first look is answered by the model of the average person.
            let expected = match people.typical().model {
                CarFollowing::Idm(idm) => IdmParams { t: idm.t * factor, ..idm }.acceleration(5.0, 4.0, 8.0),
                // A time gap of 1.2 is a gap seen as 8 / 1.2 m.
                CarFollowing::OptimalVelocity(model) => model.acceleration(5.0, 4.0, 8.0 / factor, 30.0),
            };
            let wanted = driver.wanted_mps2(&behind(5.0, 8.0, 4.0));
            assert!((wanted - expected).abs() < 1e-9, "{name}: {wanted} of {expected}");
        }
    }

    #[test]
    fn a_driver_who_errs_has_the_noise_of_measured_people() {
        let people = TrafficDrivers::named("safe-followers", IdmParams::default()).expect("a shipped population");
        let AccelNoise::OrnsteinUhlenbeck { sd_mps2, memory_s } = people.typical().noise else { panic!("noise") };
        let mut driver =
            SimulatedDriver::new(&DriverParams::default(), &CarParams::default(), 1).unwrap().among(&people);
        let mut noise_mps2 = |speed_mps: f64| {
            let model_mps2 = people.typical().model.acceleration(speed_mps, speed_mps, 12.0, 30.0);
            driver.wanted_mps2(&behind(speed_mps, 12.0, speed_mps)) - model_mps2
        };
        assert_eq!(noise_mps2(0.0), 0.0, "a queue does not creep");
        let all: Vec<f64> = (0..1_000_000).map(|_| noise_mps2(5.0)).collect();
        let moment = |lag: usize| {
            let count = (all.len() - lag) as f64;
            all.iter().zip(&all[lag..]).map(|(a, b)| a * b).sum::<f64>() / count
        };
        // 10,000 s are 8,000 time constants: a statistical error of 1.6 % of the variance.
        assert!((moment(0).sqrt() / sd_mps2 - 1.0).abs() < 0.05, "{} of {sd_mps2}", moment(0).sqrt());
        // The smoothing over a fifth of the time constant raises the correlation after one of them from 0.37 to 0.46.
        let later = moment((memory_s / TICK_S) as usize) / moment(0);
        assert!((later - 0.46).abs() < 0.06, "{later}");
    }

    #[test]
    fn among_the_ring_studys_vehicles_a_driver_keeps_their_own_model() {
        let car = CarParams::default();
        let study = TrafficDrivers::named("ring-study", IdmParams { t: 2.0, ..IdmParams::default() }).expect("a name");
        let params = preset("perfect").expect("a preset");
        let mut driver = SimulatedDriver::new(&params, &car, 1).expect("a driver").among(&study);
        let own = params.idm.acceleration(5.0, 4.0, 8.0);
        assert!((driver.wanted_mps2(&behind(5.0, 8.0, 4.0)) - own).abs() < 1e-9);
    }
}
