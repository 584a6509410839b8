//! Pedals of a simulated driver. In: the wanted acceleration. Out: accelerator and brake, never both. The foot rests on
//! a pedal until the other one is clearly needed, takes time to move there, and presses with a limited rate.

use super::DriverParams;
use crate::{ego::CarParams, time::TICK_S};

/// Difference between the wanted acceleration and free rolling at which the foot changes pedals, m/s². Within it the
/// pedal is released.
const CHANGE_MPS2: f64 = 0.12;
/// Speed below which the ego counts as standing, m/s.
const STANDING_MPS: f64 = 0.08;
/// Smallest wanted acceleration at which a standing driver starts, m/s² (with the ring's model at a gap of 2.17 m).
const GO_MPS2: f64 = 0.15;
/// Brake pedal held at a standstill against the creep (0.06 would suffice); on a hill more, if the hill needs it.
const HOLD_PEDAL: f64 = 0.15;
/// Brake force held on a hill, as a multiple of the downhill force, in addition to creep.
const HOLD_SHARE: f64 = 1.5;
/// Creep acceleration at a standstill on a level road, m/s².
const CREEP_MPS2: f64 = 0.6;
/// Gain from speed error to acceleration, 1/s, and from its integral, 1/s²: the corner frequency of 1 rad/s is well
/// below the ego's own lags.
const GAIN: f64 = 1.0;
const INTEGRAL: f64 = 0.25;
/// Largest difference between the ideal and the true speed, m/s; a larger error is dropped.
const LEASH_MPS: f64 = 0.5;

/// Position of the foot.
#[derive(Clone, Copy, Debug, PartialEq)]
enum FootPlace {
    Throttle,
    Brake,
    /// Foot on its way to the accelerator, with the time left, s; likewise to the brake below.
    ToThrottle(f64),
    ToBrake(f64),
}

#[derive(Clone, Debug)]
pub(super) struct PedalModel {
    foot: FootPlace,
    throttle: f64,
    brake: f64,
    holding: bool,
    /// Speed that would result if every wanted acceleration were achieved, m/s.
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

    /// Puts the foot on the brake, for an ego that is held before it starts.
    pub fn hold(&mut self) {
        (self.foot, self.brake, self.holding) = (FootPlace::Brake, HOLD_PEDAL, true);
    }

    /// Puts the foot on the pedals as they are, and forgets past errors.
    pub fn rest_on(&mut self, throttle: f32, brake: f32) {
        self.foot = if brake > 0.0 { FootPlace::Brake } else { FootPlace::Throttle };
        (self.throttle, self.brake, self.holding) = (throttle.into(), brake.into(), false);
        (self.ideal_mps, self.integral) = (f64::NAN, 0.0);
    }

    /// Returns accelerator and brake of this tick for a wanted acceleration, m/s², on a road of this grade.
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
        // A foot that leaves a pedal releases it within 0.1 s, the time of the pedal's spring.
        let off = |on: bool, per_s: f64| if on { per_s } else { 10.0 };
        self.throttle = step(self.throttle, throttle, off(self.foot == FootPlace::Throttle, params.throttle_per_s));
        self.brake = step(self.brake, brake, off(self.foot == FootPlace::Brake, params.brake_per_s));
        if self.foot == FootPlace::Brake || matches!(self.foot, FootPlace::ToBrake(_)) {
            (if self.brake > 0.0 { 0.0 } else { self.throttle as f32 }, self.brake as f32)
        } else {
            (self.throttle as f32 * if self.brake > 0.0 { 0.0 } else { 1.0 }, self.brake as f32)
        }
    }

    /// Returns the acceleration that the pedals must add to free rolling, m/s²: the wanted one plus the correction of
    /// past errors.
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

    /// Returns the acceleration without a pedal, m/s², as the driver knows it: creep up to 1.7 m/s, coasting above.
    fn rolling_mps2(&self, speed_mps: f64) -> f64 {
        const CREEP_MPS: f64 = 1.7;
        let out = -0.12 - 0.0004 * speed_mps * speed_mps;
        if !self.creep {
            return out;
        }
        let creep = CREEP_MPS2 * (1.0 - (speed_mps.max(0.0) / CREEP_MPS).powi(2));
        creep.max(out)
    }

    /// Returns the accelerator for an acceleration, as the driver knows the ego. When pulling away the pedal sets a
    /// share of the torque; at higher speed its square sets a share of the power.
    fn throttle_for(&self, command_mps2: f64, speed_mps: f64) -> f64 {
        /// Speed at which first gear ends for a light pedal, m/s.
        const FIRST_MPS: f64 = 5.0;
        let force_n = command_mps2.max(0.0) * self.mass_kg;
        let by_power = (force_n * speed_mps.max(0.0) / self.power_w).sqrt();
        let share = force_n / self.first_gear_n * (speed_mps / FIRST_MPS).max(1.0);
        // Solves the pedal map for the pedal: share = l p + (1 - l) p².
        let (l, q) = (self.pedal_linear, 1.0 - self.pedal_linear);
        let by_torque = if q > 1e-3 { ((l * l + 4.0 * q * share).sqrt() - l) / (2.0 * q) } else { share / l };
        by_power.max(by_torque).min(1.0)
    }

    /// Returns the brake pedal for a deceleration.
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
