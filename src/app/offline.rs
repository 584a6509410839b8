//! A drive without a window: a simulated driver at full speed. In: a scenario. Out: rows, a summary, or a world at a
//! given second to take a picture of.

use super::{AppError, Drive, words};
use crate::{
    driver::{self, SimulatedDriver},
    sim::{Scenario, Summary, Tally, World},
    time::{Pace, Tick},
};
use std::time::Duration;

/// Columns of [`Run::step_row`], SI units as their names say.
pub const STEP_COLUMNS: &str = "time_s,ego_s_m,lane_offset_m,speed_mps,accel_mps2,throttle,brake,steering_wheel_rad,\
gap_m,leader_speed_mps,target_mps,range_low_mps,range_high_mps,in_range,mean_speed_mps";

/// One drive by a simulated driver.
pub struct Run {
    drive: Drive,
    driver: SimulatedDriver,
    controls: crate::ego::Controls,
    tally: Tally,
}

impl Run {
    /// Puts everything in place; means will be over `window_s`.
    ///
    /// # Errors
    /// The world cannot start or the driver is unknown.
    pub fn new(scenario: &Scenario, window_s: [f64; 2]) -> Result<Self, AppError> {
        let params = driver::preset(&scenario.driver)?;
        let drive = Drive::new(scenario, Pace::Paused)?;
        Ok(Self {
            driver: SimulatedDriver::new(&params, drive.world.ego_params(), scenario.seed)?,
            drive,
            controls: Default::default(),
            tally: Tally::new(window_s),
        })
    }

    /// Drives one step (0.1 s unless the scenario says otherwise), or what is left of it before the drive ends.
    ///
    /// # Errors
    /// The traffic engine failed.
    pub fn step(&mut self) -> Result<(), AppError> {
        self.ticks(self.drive.world.scenario().step_ticks())
    }

    /// Drives until `time_s` or the end of the drive.
    ///
    /// # Errors
    /// The traffic engine failed.
    pub fn until(&mut self, time_s: f64) -> Result<(), AppError> {
        let now = self.drive.world.snapshot().tick;
        self.ticks(Tick::at_seconds(time_s).0.saturating_sub(now.0))
    }

    fn ticks(&mut self, ticks: u64) -> Result<(), AppError> {
        let Self { drive, driver, controls, tally } = self;
        drive.clock.single_step(ticks);
        drive.frame(
            Duration::ZERO,
            |world| {
                *controls = driver.controls(&world.perceived_by(driver));
                *controls
            },
            |world| tally.add(world.snapshot(), world.events()),
        )?;
        Ok(())
    }

    /// The world as it is now.
    pub fn world(&self) -> &World {
        &self.drive.world
    }

    /// The drive so far in numbers.
    pub fn summary(&self) -> Summary {
        self.tally.summary()
    }

    /// The drive so far in words.
    pub fn words(&self) -> String {
        let world = &self.drive.world;
        let scenario = world.scenario();
        words::summary(scenario, &world.traffic_engine(), &scenario.driver, &self.summary())
    }

    /// The present step as a CSV row under [`STEP_COLUMNS`]; what does not exist is empty.
    pub fn step_row(&self) -> String {
        let snapshot = self.drive.world.snapshot();
        let (ego, controls) = (&snapshot.ego, &self.controls);
        let number = |value: Option<f64>| value.map_or(String::new(), |v| format!("{v:.6}"));
        let band = snapshot.advice.map(|advice| advice.band_mps());
        let in_range = snapshot.advice.map(|advice| u8::from(advice.accepts(ego.speed_mps)).to_string());
        format!(
            "{:.2},{:.6},{:.6},{:.6},{:.6},{:.4},{:.4},{:.5},{},{},{},{},{},{},{:.6}",
            snapshot.tick.seconds(),
            snapshot.ego_s_m,
            snapshot.lane_offset_m,
            ego.speed_mps,
            ego.accel_mps2,
            controls.throttle,
            controls.brake,
            controls.steering_wheel_rad,
            number(snapshot.leader.map(|l| l.gap_m)),
            number(snapshot.leader.map(|l| l.speed_mps)),
            number(snapshot.advice.map(|a| a.target_mps)),
            number(band.map(|b| b.0)),
            number(band.map(|b| b.1)),
            in_range.unwrap_or_default(),
            snapshot.mean_speed_mps,
        )
    }
}
