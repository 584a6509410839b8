//! Engine, torque converter and automatic gearbox. In: pedals, selector, speed. Out: force at the driven axle, gear and
//! engine speed. One step is one sub-step of the physics. Internal units are rad/s and N m.
//!
//! * **Engine**: a torque curve, friction, an idle governor, inertia. The pedal sets the torque, limited to a share of
//!   the power, so that a steady pedal means a steady speed.
//! * **Converter**: pump torque `k w^2 (1 - nu^6)` with nu = turbine/engine speed; at a standstill it multiplies the
//!   torque. It makes pulling away smooth and lets the ego creep. From second gear up a lock-up clutch transmits the
//!   rest.
//! * **Gears**: two lines of engine speed over the pedal, for changes up and down, so far apart that a change is never
//!   reversed. A change blends the ratios. First gear has a freewheel: no engine braking at walking pace, hence no jerk
//!   there.

use super::params::{CarParams, EngineParams, GearboxParams};
use super::table::interpolated;
use crate::controls::{Controls, Selector};
use std::f64::consts::PI;

const RAD_S_PER_RPM: f64 = PI / 30.0;
/// Gain of the idle governor, N m per rad/s: at 10 rad/s below idle it adds 30 N m.
const IDLE_GAIN_NMS: f64 = 3.0;
/// Largest torque of the idle governor, N m.
const IDLE_MAX_NM: f64 = 90.0;
/// Gain of the lock-up clutch, N m per rad/s of slip. Times the sub-step over the inertia it is 0.075, far from
/// unstable.
const LOCK_NMS: f64 = 6.0;
/// Turbine speeds between which the lock-up clutch closes, rad/s (950 to 1250 1/min).
const LOCK_FROM_TO: (f64, f64) = (100.0, 130.0);
/// Capacity of the converter when the wheels drive the engine, as a share of that when the engine drives.
const OVERRUN: f64 = 0.5;
/// Largest torque that the engine adds or withholds during a gear change, N m.
const SHIFT_MAX_NM: f64 = 100.0;
/// Time constant of shafts and mounts, s; smooths every change of torque.
const SHAFT_S: f64 = 0.07;
/// Time in which a clutch engages after a movement of the selector, and in which it closes or opens without creep, s.
const ENGAGE_S: f64 = 0.4;
/// Speed below which the converter is open until the pedal is touched, without creep, m/s.
const OPEN_BELOW_MPS: f64 = 2.5;

/// State of engine and gearbox.
#[derive(Clone, Debug)]
pub(super) struct Powertrain {
    /// Engaged position; follows the selector if the speed permits.
    engaged: Selector,
    /// Forward gear, from 1.
    gear: usize,
    engine_rad_s: f64,
    /// Present total ratio, positive.
    ratio: f64,
    /// Ratio at the start of the gear change, and time since then, s.
    shift_from: f64,
    since_shift_s: f64,
    lock: f64,
    coupling: f64,
    axle_nm: f64,
    pedal: f64,
}

impl Powertrain {
    /// Creates the state after a long drive at `speed_mps` with a light pedal.
    pub fn new(p: &CarParams, speed_mps: f64) -> Self {
        let mut train = Self {
            engaged: Selector::Drive,
            gear: 1,
            engine_rad_s: 0.0,
            ratio: 0.0,
            shift_from: 0.0,
            since_shift_s: 1e3,
            lock: 0.0,
            coupling: if p.gearbox.creep || speed_mps > OPEN_BELOW_MPS { 1.0 } else { 0.0 },
            axle_nm: 0.0,
            pedal: 0.0,
        };
        let wheel_rad_s = speed_mps.max(0.0) / p.body.wheel_radius_m;
        while train.gear < p.gearbox.ratios.len()
            && wheel_rad_s * train.total_ratio(&p.gearbox) > p.gearbox.up_rpm[0] * RAD_S_PER_RPM
        {
            train.gear += 1;
        }
        train.ratio = train.total_ratio(&p.gearbox);
        train.shift_from = train.ratio;
        train.engine_rad_s = (wheel_rad_s * train.ratio).max(p.engine.idle_rpm * RAD_S_PER_RPM);
        train
    }

    /// Returns the gear for display: -1 reverse, 0 neutral, 1 and up forwards.
    pub fn gear(&self) -> i8 {
        match self.engaged {
            Selector::Drive => self.gear as i8,
            Selector::Neutral => 0,
            Selector::Reverse => -1,
        }
    }

    /// Returns the engine speed, 1/min.
    pub fn rpm(&self) -> f64 {
        self.engine_rad_s / RAD_S_PER_RPM
    }

    /// Advances by `dt` seconds and returns the force at the driven axle, N, positive forwards.
    pub fn step(&mut self, p: &CarParams, controls: &Controls, speed_mps: f64, dt: f64) -> f64 {
        let gears = &p.gearbox;
        let pedal = f64::from(controls.throttle);
        self.pedal += (pedal - self.pedal) * (dt / 0.05).min(1.0);
        self.select(gears, controls.selector, speed_mps);
        let direction = match self.engaged {
            Selector::Drive => 1.0,
            Selector::Neutral => 0.0,
            Selector::Reverse => -1.0,
        };
        // Wheel speed on the turbine's side, positive when the ego rolls in the direction of the gear.
        let wheel_rad_s = direction * speed_mps / p.body.wheel_radius_m;
        let ratio_before = self.ratio;
        self.change_gear(gears, f64::from(controls.brake), wheel_rad_s, dt);
        let turbine = wheel_rad_s * self.ratio;
        let shifted = turbine - wheel_rad_s * ratio_before;
        self.couple(gears, direction, speed_mps, turbine, dt);

        let (pump_nm, turbine_nm) = self.converter(gears, self.engine_rad_s, turbine);
        let idle_rad_s = p.engine.idle_rpm * RAD_S_PER_RPM;
        let idle_load_nm = self.converter(gears, idle_rad_s, turbine).0.max(0.0);
        let slip = self.engine_rad_s - turbine;
        let lock_nm = (LOCK_NMS * slip * self.lock).clamp(-300.0, 300.0);
        let engine_nm = self.engine_nm(&p.engine, idle_load_nm) + self.shift_nm(&p.engine, turbine, shifted, dt);
        self.engine_rad_s += (engine_nm - pump_nm - lock_nm) / p.engine.inertia_kgm2 * dt;
        self.engine_rad_s = self.engine_rad_s.clamp(0.0, 1.05 * p.engine.limit_rpm * RAD_S_PER_RPM);

        let mut shaft_nm = turbine_nm + lock_nm;
        shaft_nm *= if shaft_nm > 0.0 { gears.efficiency } else { 1.0 };
        let target_nm = direction * shaft_nm * self.ratio;
        self.axle_nm += (target_nm - self.axle_nm) * (dt / SHAFT_S).min(1.0);
        self.axle_nm / p.body.wheel_radius_m
    }

    fn total_ratio(&self, gears: &GearboxParams) -> f64 {
        let ratio = if self.engaged == Selector::Reverse { gears.reverse_ratio } else { gears.ratios[self.gear - 1] };
        ratio * gears.final_drive
    }

    /// Follows the selector unless the ego rolls too fast in the other direction.
    fn select(&mut self, gears: &GearboxParams, wanted: Selector, speed_mps: f64) {
        let allowed = match wanted {
            Selector::Drive => speed_mps > -gears.selector_speed_mps,
            Selector::Neutral => true,
            Selector::Reverse => speed_mps < gears.selector_speed_mps,
        };
        if wanted == self.engaged || !allowed {
            return;
        }
        self.engaged = wanted;
        if wanted == Selector::Reverse {
            self.gear = 1;
        }
        self.coupling = 0.0;
        self.lock = 0.0;
        self.ratio = self.total_ratio(gears);
        self.shift_from = self.ratio;
    }

    /// Changes gear by the two lines, and blends the ratio.
    fn change_gear(&mut self, gears: &GearboxParams, brake: f64, wheel_rad_s: f64, dt: f64) {
        self.since_shift_s += dt;
        let rpm = |gear: usize| wheel_rad_s * gears.ratios[gear - 1] * gears.final_drive / RAD_S_PER_RPM;
        // A light pedal changes early: the lines rise with the pedal to the power of 1.5.
        let light = self.pedal.powf(1.5);
        let line = |[low, high]: [f64; 2]| low + (high - low) * light;
        if self.engaged == Selector::Drive && self.since_shift_s > gears.dwell_s.max(gears.shift_s) {
            let before = self.gear;
            if self.gear < gears.ratios.len() && rpm(self.gear) > line(gears.up_rpm) && brake < 0.02 {
                self.gear += 1;
            } else {
                // Possibly several gears at once, after hard braking.
                while self.gear > 1 && rpm(self.gear) < line(gears.down_rpm) {
                    self.gear -= 1;
                }
            }
            if self.gear != before {
                self.shift_from = self.ratio;
                self.since_shift_s = 0.0;
            }
        }
        let t = (self.since_shift_s / gears.shift_s).min(1.0);
        let blend = t * t * (3.0 - 2.0 * t);
        let target = self.total_ratio(gears);
        self.ratio = if t < 1.0 { self.shift_from * (target / self.shift_from).powf(blend) } else { target };
    }

    /// Updates the engagement of the converter and of its lock-up clutch.
    fn couple(&mut self, gears: &GearboxParams, direction: f64, speed_mps: f64, turbine: f64, dt: f64) {
        let open = if direction == 0.0 {
            0.0
        } else if gears.creep || speed_mps.abs() > OPEN_BELOW_MPS {
            1.0
        } else {
            (self.pedal / 0.04).min(1.0)
        };
        self.coupling = approach(self.coupling, open, dt / ENGAGE_S);
        let (from, to) = LOCK_FROM_TO;
        let changing = self.since_shift_s < gears.shift_s;
        let lock = if self.engaged != Selector::Drive || self.gear < 2 || changing || self.pedal > 0.9 {
            0.0
        } else {
            ((turbine - from) / (to - from)).clamp(0.0, 1.0)
        };
        self.lock = approach(self.lock, lock, dt / ENGAGE_S);
    }

    /// Returns the torques on the pump and on the turbine, N m, for their speeds in rad/s.
    fn converter(&self, gears: &GearboxParams, engine: f64, turbine: f64) -> (f64, f64) {
        if turbine <= engine {
            let nu = if engine > 0.0 { (turbine / engine).max(0.0) } else { 1.0 };
            let pump_nm = self.coupling * gears.pump_nms2 * engine * engine * (1.0 - nu.powi(6));
            let multiplied = 1.0 + (gears.stall_ratio - 1.0) * (1.0 - nu / 0.85).max(0.0);
            return (pump_nm, pump_nm * multiplied);
        }
        if self.gear == 1 && self.engaged == Selector::Drive {
            return (0.0, 0.0);
        }
        let nu = engine / turbine;
        let pump_nm = -OVERRUN * self.coupling * gears.pump_nms2 * turbine * turbine * (1.0 - nu.powi(6));
        (pump_nm, pump_nm)
    }

    /// Returns the torque that the engine adds or withholds during a gear change, N m, so that its inertia does not
    /// push the ego. `shifted` is the change of the turbine's speed in this step. An engine far from the turbine's
    /// speed adds little.
    fn shift_nm(&self, engine: &EngineParams, turbine: f64, shifted: f64, dt: f64) -> f64 {
        let (low, high) = (turbine.min(self.engine_rad_s), turbine.max(self.engine_rad_s).max(1.0));
        let follows = (low.max(0.0) / high).powi(2);
        (engine.inertia_kgm2 * shifted / dt * follows).clamp(-SHIFT_MAX_NM, SHIFT_MAX_NM)
    }

    /// Returns the net torque of the engine, N m; `idle_load_nm` is the converter's load at idle.
    fn engine_nm(&self, engine: &EngineParams, idle_load_nm: f64) -> f64 {
        let speed = self.engine_rad_s;
        let rpm = speed / RAD_S_PER_RPM;
        let full_nm = interpolated(&engine.torque_curve, rpm);
        let pedal = self.pedal;
        let share = engine.pedal_linear * pedal + (1.0 - engine.pedal_linear) * pedal * pedal;
        let power_nm = engine.pedal_power_w * pedal * pedal / speed.max(1.0);
        let cut = ((engine.limit_rpm - rpm) / 200.0).clamp(0.0, 1.0);
        let asked_nm = (share * full_nm).min(power_nm) * cut;
        let drag_nm = engine.drag_nm + engine.drag_nms * speed;
        let carried = (pedal / engine.pedal_neutral).min(1.0) * cut;
        // At idle the engine overcomes its own friction and the converter's load. The pedal adds to that, so it has no
        // dead travel. The help ends as the engine exceeds the speed that belongs to the pedal.
        let idle_rad_s = engine.idle_rpm * RAD_S_PER_RPM;
        let near_idle = (1.0 - (speed - idle_rad_s * (1.0 + 3.0 * pedal)) / (0.3 * idle_rad_s)).clamp(0.0, 1.0);
        let idle_nm = near_idle * (idle_load_nm + drag_nm * (1.0 - carried));
        let help_nm = (idle_nm + IDLE_GAIN_NMS * (idle_rad_s - speed).max(0.0)).min(IDLE_MAX_NM);
        asked_nm + help_nm - drag_nm * (1.0 - carried)
    }
}

/// Returns `value` moved towards `target` by at most `step`.
fn approach(value: f64, target: f64, step: f64) -> f64 {
    value + (target - value).clamp(-step, step)
}
