//! State of the automation at a tick. In: nothing. Out: an [`AutomationState`], which the dial shows and the driver sees.

use crate::controls::Controls;

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
}
