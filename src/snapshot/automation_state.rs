//! State of the automation at a tick. In: nothing. Out: an [`AutomationState`], which the dial shows and the driver sees.

use super::ToneSeries;
use crate::{controls::Controls, time::Tick};

/// Strength of the wheel's pulses in a takeover request, as a share of the strongest one, and the length of each, ticks.
const PULSE: f64 = 0.5;
const PULSE_TICKS: u64 = 30;

/// Time gaps that the button sets in turn, s (docs/references.md: automation).
pub const TIME_GAPS_S: [f64; 3] = [1.0, 1.5, 2.0];

/// Automation of the ego as its driver sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AutomationState {
    pub mode: AutomationMode,
    /// Use of the pedals by the system while it drives.
    pub keeps_speed: bool,
    /// Use of the steering wheel by the system while it drives.
    pub steers: bool,
    /// True in the second, urgent half of a takeover request's lead time, and in a minimal-risk manoeuvre.
    pub is_urgent: bool,
    /// Time gap that the system keeps to the vehicle ahead, s; `None` if it keeps none.
    pub time_gap_s: Option<f64>,
    /// Controls that moved the ego, if the system gave pedals or wheel.
    pub driven: Option<Controls>,
}

/// Mode of the automation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AutomationMode {
    /// The vehicle has no automation.
    #[default]
    None,
    /// The participant moves pedals and wheel.
    Off,
    /// The system moves pedals, wheel or both.
    On,
    /// The system drives and asks the participant to take over.
    TakeoverRequest,
    /// The system stops in the lane, as the participant has not taken over.
    MinimalRisk,
}

impl AutomationMode {
    /// Returns the word used in recordings.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Off => "off",
            Self::On => "on",
            Self::TakeoverRequest => "takeover_request",
            Self::MinimalRisk => "minimal_risk",
        }
    }

    /// Returns true while the system drives.
    pub fn drives(self) -> bool {
        !matches!(self, Self::None | Self::Off)
    }

    /// Returns true while the participant is asked to take over.
    pub fn asks(self) -> bool {
        matches!(self, Self::TakeoverRequest | Self::MinimalRisk)
    }
}

impl AutomationState {
    /// Visits the mode; no number without an automation.
    pub(super) fn visit(&self, put: &mut impl FnMut(&'static str, u32, f64)) {
        match self.mode {
            AutomationMode::None => {}
            mode => put("automation", 0, f64::from(mode as u8)),
        }
    }

    /// Returns the series of tones and pulses of a takeover request at this urgency.
    pub fn series(&self) -> ToneSeries {
        if self.is_urgent { ToneSeries::Urgent } else { ToneSeries::Gentle }
    }

    /// Returns the strength of the wheel's pulse at a tick, 0 to 1: while the participant is asked to take over, 0.3 s as often as tones sound.
    pub fn wheel_pulse(&self, now: Tick) -> f64 {
        let is_on = self.mode.asks() && now.0 % self.series().every_ticks() < PULSE_TICKS;
        if is_on { PULSE } else { 0.0 }
    }

    /// Returns the number of bars that show the time gap, 1 to 3: one for each setting up to it. Returns 0 without a time gap.
    pub fn gap_bars(&self) -> u8 {
        let bars = |gap_s: f64| TIME_GAPS_S.iter().filter(|setting_s| **setting_s <= gap_s).count().max(1) as u8;
        self.time_gap_s.map_or(0, bars)
    }

    /// Returns true while the system uses the pedals.
    pub fn keeps_speed_now(&self) -> bool {
        self.keeps_speed && self.mode.drives()
    }

    /// Returns true while the system turns the steering wheel.
    pub fn steers_now(&self) -> bool {
        self.steers && self.mode.drives()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_longer_time_gap_has_more_bars() {
        let bars = |time_gap_s| AutomationState { time_gap_s, ..AutomationState::default() }.gap_bars();
        // Between two settings a gap has the bars of the shorter one.
        let shown = [0.8, 1.0, 1.4, 1.5, 1.9, 2.0, 4.0].map(|gap_s| bars(Some(gap_s)));
        assert_eq!((shown, bars(None)), ([1, 1, 1, 2, 2, 3, 3], 0));
    }

    #[test]
    fn the_wheel_pulses_while_asked_to_take_over_and_more_often_when_urgent() {
        let felt = |mode: AutomationMode, is_urgent: bool| {
            let state = AutomationState { mode, is_urgent, ..AutomationState::default() };
            (0..600).filter(|tick| state.wheel_pulse(Tick(*tick)) > 0.0).count()
        };
        // In 6 s: three pulses of 0.3 s, ten when it is urgent.
        assert_eq!(felt(AutomationMode::TakeoverRequest, false), 3 * 30);
        assert_eq!(felt(AutomationMode::TakeoverRequest, true), 10 * 30);
        assert_eq!([AutomationMode::On, AutomationMode::Off].map(|mode| felt(mode, false)), [0, 0]);
    }
}
