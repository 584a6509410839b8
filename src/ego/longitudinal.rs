//! The ego along a line: its engine, gearbox, brakes and resistances, without springs, steering and contacts. In: pedals once a tick and
//! the grade. Out: speed, acceleration and way. For advised vehicles without a person inside: the speed behind the same pedals is
//! that of [`EgoCar`](super::EgoCar) to some mm/s, at a fraction of its cost.

use super::{EgoError, body::GRAVITY, params::CarParams, powertrain::Powertrain};
use crate::{controls::Controls, time::TICK_S};

/// Steps in a tick: a converter settles within 20 ms. With the four of the full car the speed is no nearer to its own.
const SUBSTEPS: u32 = 2;
const SUBSTEP_S: f64 = TICK_S / SUBSTEPS as f64;

/// Vehicle that moves along a line.
#[derive(Clone, Debug)]
pub struct LongitudinalCar {
    params: CarParams,
    powertrain: Powertrain,
    /// Brake force after the hydraulics' lag, as a share of the force at a floored pedal.
    brake: f64,
    speed_mps: f64,
    accel_mps2: f64,
    is_braking: bool,
}

impl LongitudinalCar {
    /// Creates a vehicle with this speed, m/s.
    ///
    /// # Errors
    /// A parameter is outside the range that can be simulated.
    pub fn new(params: &CarParams, speed_mps: f64) -> Result<Self, EgoError> {
        params.check()?;
        Ok(Self {
            powertrain: Powertrain::new(params, speed_mps),
            params: params.clone(),
            brake: 0.0,
            speed_mps,
            accel_mps2: 0.0,
            is_braking: false,
        })
    }

    /// Returns the speed, m/s, negative where it rolls back.
    pub fn speed_mps(&self) -> f64 {
        self.speed_mps
    }

    /// Returns the acceleration of the last tick, m/s².
    pub fn accel_mps2(&self) -> f64 {
        self.accel_mps2
    }

    /// Returns true while the brake lamps are lit.
    pub fn is_braking(&self) -> bool {
        self.is_braking
    }

    /// Returns the gear (see [`EgoState`](super::EgoState)) and the engine speed, 1/min.
    pub fn gear_and_rpm(&self) -> (i8, f64) {
        (self.powertrain.gear(), self.powertrain.rpm())
    }

    /// Sets the speed, m/s, where something else than its driver has moved it.
    pub fn set_speed(&mut self, speed_mps: f64) {
        self.speed_mps = speed_mps;
    }

    /// Returns the largest forces that front and rear tyres transmit under the present acceleration, as shares of the weight: it moves load
    /// from one axle to the other.
    fn grips(&self) -> [f64; 2] {
        let (b, t) = (&self.params.body, &self.params.tyres);
        let height_m = b.cg_height_m - self.params.suspension.link_height_m;
        let moved = self.accel_mps2 / f64::from(GRAVITY) * height_m / b.wheelbase_m;
        [b.front_share - moved, 1.0 - b.front_share + moved]
            .map(|load| t.asphalt_friction_at(self.speed_mps) * t.slip_control * load.max(0.0))
    }

    /// Advances by one tick on a road of this grade, the tangent of the slope angle, positive uphill. Returns the way, m.
    pub fn tick(&mut self, controls: &Controls, grade: f64) -> f64 {
        let controls = controls.sane();
        let before_mps = self.speed_mps;
        let (p, weight_n) = (&self.params, self.params.body.mass_kg * f64::from(GRAVITY));
        let pedal = f64::from(controls.brake).powf(p.brakes.pedal_exponent);
        let lag = if p.brakes.lag_s > 0.0 { (SUBSTEP_S / p.brakes.lag_s).min(1.0) } else { 1.0 };
        let drag = 0.5 * p.body.air_density_kgm3 * p.body.drag_area_m2;
        let slope = 1.0 / grade.hypot(1.0);
        let grips = self.grips();
        let [front, rear] = [p.brakes.front_share, 1.0 - p.brakes.front_share];
        let mut way_m = 0.0;
        for _ in 0..SUBSTEPS {
            self.brake += (pedal - self.brake) * lag;
            let v = self.speed_mps;
            let drive_n = self.powertrain.step(p, &controls, v, SUBSTEP_S);
            let drive_n = drive_n.clamp(-grips[0] * weight_n, grips[0] * weight_n);
            let free_n = drive_n - drag * v * v.abs() - weight_n * grade * slope;
            let brake = self.brake * p.brakes.full_share;
            let held = (brake * front).min(grips[0]) + (brake * rear).min(grips[1]) + p.tyres.asphalt_rolling;
            let most_mps = held * weight_n * slope / p.body.mass_kg * SUBSTEP_S;
            let free_mps = v + free_n / p.body.mass_kg * SUBSTEP_S;
            // Brakes and rolling resistance slow the vehicle down and hold it, but never move it.
            self.speed_mps = free_mps - free_mps.clamp(-most_mps, most_mps);
            way_m += self.speed_mps * SUBSTEP_S;
        }
        self.accel_mps2 = (self.speed_mps - before_mps) / TICK_S;
        self.is_braking = f64::from(controls.brake) > p.brakes.lamp_pedal;
        way_m
    }
}
