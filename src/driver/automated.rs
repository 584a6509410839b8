//! Driver of the automation. In: what its sensors perceive ([`Perception`]) and a [`SpeedGoal`]. Out: [`Controls`], through the same pedals and
//! wheel as people, without their delays and errors.

use super::{DriverError, Perception, SimulatedDriver, cruise_control, guarded_mps2, preset};
use crate::{controls::Controls, ego::CarParams};

/// Speed that the automation is to drive, m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpeedGoal {
    /// Set speed with a time gap to the vehicle ahead.
    Cruise {
        set_mps: f64,
        time_gap_s: f64,
        /// True if the vehicle slows down for bends.
        heeds_bends: bool,
        /// True if it also stops at lines and avoids collisions with all its brakes.
        heeds_all: bool,
    },
    /// Speed that the policy advises, shown to the participant or not.
    Advice,
    /// Even braking to a standstill, m/s².
    Brake(f64),
}

/// Driver of the automation.
#[derive(Clone, Debug)]
pub struct AutomatedDriver {
    driver: SimulatedDriver,
}

impl AutomatedDriver {
    /// Creates a driver that knows the ego's parameters.
    ///
    /// # Errors
    /// As [`SimulatedDriver::new`].
    pub fn new(car: &CarParams) -> Result<Self, DriverError> {
        // The machine that follows advice exactly and brakes to avoid a collision; it draws no random number that counts.
        Ok(Self { driver: SimulatedDriver::new(&preset("guarded")?, car, 0)? })
    }

    /// Returns the driver through whose eyes the vehicle sees ([`Perception`]).
    pub fn eyes(&self) -> &SimulatedDriver {
        &self.driver
    }

    /// Returns this driver with pedals and wheel as they are.
    pub fn from_controls(&self, controls: &Controls) -> Self {
        let mut driver = self.driver.clone();
        driver.pedals.rest_on(controls.throttle, controls.brake);
        driver.steering.hold(controls.steering_wheel_rad);
        Self { driver }
    }

    /// Returns the controls of this tick.
    pub fn controls(&mut self, now: &Perception, goal: SpeedGoal) -> Controls {
        let wanted_mps2 = self.wanted_mps2(now, goal);
        let driver = &mut self.driver;
        let steering_wheel_rad = driver.steering.turn(&driver.params, now.speed_mps, &now.lane, 0.0);
        Controls { steering_wheel_rad, ..driver.press(now, wanted_mps2) }
    }

    fn wanted_mps2(&mut self, now: &Perception, goal: SpeedGoal) -> f64 {
        match goal {
            SpeedGoal::Advice => self.driver.wanted_mps2(now),
            SpeedGoal::Brake(decel_mps2) => -decel_mps2,
            SpeedGoal::Cruise { set_mps, time_gap_s, heeds_bends, heeds_all } => {
                let params = &self.driver.params;
                let cruise = |set_mps, leader| cruise_control::wanted_mps2(now.speed_mps, set_mps, time_gap_s, leader);
                let wanted_mps2 = cruise(set_mps, now.leader);
                let bends = |speed_mps: f64| if heeds_bends { cruise(speed_mps, None) } else { f64::INFINITY };
                let wanted_mps2 = wanted_mps2.min(bends(now.lane.bend_speed_mps));
                if !heeds_all {
                    return wanted_mps2;
                }
                let line = now
                    .stop_ahead_m
                    .map_or(f64::INFINITY, |gap_m| params.idm.acceleration(now.speed_mps.max(0.0), 0.0, gap_m));
                let guard = now.leader.map_or(f64::INFINITY, |leader| guarded_mps2(params, now.speed_mps, &leader));
                wanted_mps2.min(line).min(guard)
            }
        }
    }
}
