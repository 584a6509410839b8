//! State of the automation at a tick. In: nothing. Out: an [`AutomationState`], which the dial shows and the driver sees.

use crate::controls::Controls;

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

    /// Returns true while the system uses the pedals.
    pub fn keeps_speed_now(&self) -> bool {
        self.keeps_speed && self.mode.drives()
    }

    /// Returns true while the system turns the steering wheel.
    pub fn steers_now(&self) -> bool {
        self.steers && self.mode.drives()
    }
}
