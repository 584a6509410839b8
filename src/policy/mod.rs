//! Advice. In: an [`Observation`] each step. Out: an [`Action`] each hold, shown to the driver as [`Advice`].

use crate::time::Tick;

/// What a policy may know, HC22's four numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observation {
    /// Own speed, m/s.
    pub speed_mps: f64,
    /// Leader's speed, m/s.
    pub leader_speed_mps: f64,
    /// Own front bumper to the leader's rear bumper, metres.
    pub gap_m: f64,
    /// Length of the closed route, metres.
    pub circumference_m: f64,
}

/// What a policy puts out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Keep this acceleration for the hold, m/s2.
    Acceleration(f64),
    /// Drive this speed for the hold, m/s.
    Speed(f64),
}

/// One advice as it stands on the speedometer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advice {
    /// When it was issued.
    pub issued: Tick,
    /// How long it stands, in steps.
    pub hold_steps: u32,
    /// The policy's own action.
    pub action: Action,
    /// Speed to be driven, m/s, within 0 and the speed limit.
    pub target_mps: f64,
    /// Half width of the acceptable range, m/s: target +- this.
    pub range_mps: f64,
}

impl Advice {
    /// Lowest and highest acceptable speed, m/s; never below 0.
    pub fn band_mps(&self) -> (f64, f64) {
        ((self.target_mps - self.range_mps).max(0.0), self.target_mps + self.range_mps)
    }

    /// True if `speed_mps` lies in the acceptable range, its edges included.
    pub fn accepts(&self, speed_mps: f64) -> bool {
        let (low, high) = self.band_mps();
        (low..=high).contains(&speed_mps)
    }
}
