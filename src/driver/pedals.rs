//! The foot of a simulated driver on two pedals. In: the acceleration wanted. Out: throttle and brake, never both. The foot
//! rests on a pedal until the other one is clearly needed, takes its time to get there, and presses no faster than feet do.

use super::DriverParams;
use crate::{ego::CarParams, time::TICK_S};

/// Acceleration beyond what rolling gives at which the foot changes pedals, m/s2. Between the two it rests unpressed.
const CHANGE_MPS2: f64 = 0.12;
/// Below this speed the car counts as standing, m/s.
const STANDING_MPS: f64 = 0.08;
/// A standing driver goes when at least this is wanted, m/s2 (with the ring's model a gap of 2.17 m).
const GO_MPS2: f64 = 0.15;
/// Pedal on which a standing driver rests, against the creep (0.06 would do); on a hill more, where that needs more.
const HOLD_PEDAL: f64 = 0.15;
/// How many times the pull of the hill the brake of one who stands there holds, beside the creep.
const HOLD_SHARE: f64 = 1.5;
/// What a car does by itself on the level as it stands, m/s2.
const CREEP_MPS2: f64 = 0.6;
/// Speed error to acceleration, 1/s, and its integral, 1/s2: corner frequency 1 rad/s, well below the car's own lags.
const GAIN: f64 = 1.0;
const INTEGRAL: f64 = 0.25;
/// The speed that the foot follows stays this close to the true one, m/s: what is lost beyond is given up.
const LEASH_MPS: f64 = 0.5;

/// Where the foot is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum FootPlace {
    Throttle,
    Brake,
    /// On its way, with the time left in seconds.
    ToThrottle(f64),
    ToBrake(f64),
}

#[derive(Clone, Debug)]
pub(super) struct PedalModel {
    foot: FootPlace,
    throttle: f64,
    brake: f64,
    holding: bool,
    /// The speed that would be driven if every acceleration had come as wanted, m/s.
    ideal_mps: f64,
    integral: f64,
    mass_kg: f64,
    power_w: f64,
    first_gear_n: f64,
    pedal_linear: f64,
    brake_mps2: f64,
    brake_exponent: f64,
    creep: bool,
}

impl PedalModel {
    pub fn new(car: &CarParams) -> Self {
        let torque_nm = car.engine.torque_curve.iter().map(|point| point.1).fold(0.0, f64::max);
        let first = car.gearbox.ratios[0] * car.gearbox.final_drive;
        Self {
            foot: FootPlace::Throttle,
            throttle: 0.0,
            brake: 0.0,
            holding: false,
            ideal_mps: f64::NAN,
            integral: 0.0,
            mass_kg: car.body.mass_kg,
            power_w: car.engine.pedal_power_w * car.gearbox.efficiency,
            first_gear_n: torque_nm * first * car.gearbox.efficiency / car.body.wheel_radius_m,
            pedal_linear: car.engine.pedal_linear,
            brake_mps2: car.brakes.full_share * 9.81,
            brake_exponent: car.brakes.pedal_exponent,
            creep: car.gearbox.creep,
        }
    }

    /// The foot is on the brake, as it is where a car is held before it goes.
    pub fn hold(&mut self) {
        (self.foot, self.brake, self.holding) = (FootPlace::Brake, HOLD_PEDAL, true);
    }

    /// Throttle and brake of this tick for a wanted acceleration in m/s2, on a road of this grade.
    pub fn press(&mut self, params: &DriverParams, speed_mps: f64, wanted_mps2: f64, grade: f64) -> (f32, f32) {
        let downhill_mps2 = 9.81 * -grade / grade.hypot(1.0);
        let command = self.command(speed_mps, wanted_mps2) - downhill_mps2;
        if speed_mps < STANDING_MPS && wanted_mps2 < GO_MPS2 {
            self.holding = true;
        } else if wanted_mps2 >= GO_MPS2 || speed_mps > 3.0 * STANDING_MPS {
            self.holding = false;
        }
        self.move_foot(params, if self.holding { f64::NEG_INFINITY } else { command });
        let mut throttle = 0.0;
        let mut brake = 0.0;
        match self.foot {
            FootPlace::Throttle => throttle = self.throttle_for(command, speed_mps),
            FootPlace::Brake if self.holding => {
                brake = HOLD_PEDAL.max(self.brake_for(CREEP_MPS2 + HOLD_SHARE * downhill_mps2.abs()));
            }
            FootPlace::Brake => brake = self.brake_for(-command.min(0.0)),
            FootPlace::ToThrottle(_) | FootPlace::ToBrake(_) => {}
        }
        let step = |from: f64, to: f64, per_s: f64| from + (to - from).clamp(-per_s * TICK_S, per_s * TICK_S);
        // A foot that leaves a pedal lets it go at once, a spring of 0.1 s.
        let off = |on: bool, per_s: f64| if on { per_s } else { 10.0 };
        self.throttle = step(self.throttle, throttle, off(self.foot == FootPlace::Throttle, params.throttle_per_s));
        self.brake = step(self.brake, brake, off(self.foot == FootPlace::Brake, params.brake_per_s));
        if self.foot == FootPlace::Brake || matches!(self.foot, FootPlace::ToBrake(_)) {
            (if self.brake > 0.0 { 0.0 } else { self.throttle as f32 }, self.brake as f32)
        } else {
            (self.throttle as f32 * if self.brake > 0.0 { 0.0 } else { 1.0 }, self.brake as f32)
        }
    }

    /// Acceleration that the pedals have to add to rolling: what is wanted, what was missed, what the car does by itself.
    fn command(&mut self, speed_mps: f64, wanted_mps2: f64) -> f64 {
        if self.holding || self.ideal_mps.is_nan() {
            self.ideal_mps = speed_mps;
            self.integral *= 1.0 - 0.5 * TICK_S;
        }
        self.ideal_mps = (self.ideal_mps + wanted_mps2 * TICK_S).clamp(speed_mps - LEASH_MPS, speed_mps + LEASH_MPS);
        let missed = self.ideal_mps - speed_mps;
        self.integral = (self.integral + INTEGRAL * missed * TICK_S).clamp(-0.6, 0.6);
        wanted_mps2 + GAIN * missed + self.integral - self.rolling_mps2(speed_mps)
    }

    /// What the car does without a pedal, m/s2, as its driver knows it: it creeps up to 1.7 m/s and rolls out above.
    fn rolling_mps2(&self, speed_mps: f64) -> f64 {
        const CREEP_MPS: f64 = 1.7;
        let out = -0.12 - 0.0004 * speed_mps * speed_mps;
        if !self.creep {
            return out;
        }
        let creep = CREEP_MPS2 * (1.0 - (speed_mps.max(0.0) / CREEP_MPS).powi(2));
        creep.max(out)
    }

    /// The accelerator for an acceleration, as the car's driver knows it: pulling away the pedal gives a share of the
    /// torque, later its square gives a share of the power.
    fn throttle_for(&self, command_mps2: f64, speed_mps: f64) -> f64 {
        /// Where first gear ends for a light pedal, m/s.
        const FIRST_MPS: f64 = 5.0;
        let force_n = command_mps2.max(0.0) * self.mass_kg;
        let by_power = (force_n * speed_mps.max(0.0) / self.power_w).sqrt();
        let share = force_n / self.first_gear_n * (speed_mps / FIRST_MPS).max(1.0);
        // The pedal map solved for the pedal: share = l p + (1 - l) p^2.
        let (l, q) = (self.pedal_linear, 1.0 - self.pedal_linear);
        let by_torque = if q > 1e-3 { ((l * l + 4.0 * q * share).sqrt() - l) / (2.0 * q) } else { share / l };
        by_power.max(by_torque).min(1.0)
    }

    /// The brake pedal for a deceleration.
    fn brake_for(&self, decel_mps2: f64) -> f64 {
        (decel_mps2 / self.brake_mps2).powf(1.0 / self.brake_exponent).min(1.0)
    }

    fn move_foot(&mut self, params: &DriverParams, command: f64) {
        self.foot = match self.foot {
            FootPlace::Throttle if command < -CHANGE_MPS2 => FootPlace::ToBrake(params.foot_s),
            FootPlace::Brake if command > CHANGE_MPS2 => FootPlace::ToThrottle(params.foot_s),
            FootPlace::ToBrake(left_s) if left_s <= TICK_S => FootPlace::Brake,
            FootPlace::ToThrottle(left_s) if left_s <= TICK_S => FootPlace::Throttle,
            FootPlace::ToBrake(left_s) => FootPlace::ToBrake(left_s - TICK_S),
            FootPlace::ToThrottle(left_s) => FootPlace::ToThrottle(left_s - TICK_S),
            resting => resting,
        };
    }
}
