//! Lamp and texts of the automation. In: its [`AutomationState`]. Out: an [`AutomationLamp`], which blinks in takeover requests, and the text above the
//! dial.

use crate::{
    controls::BLINK_S,
    snapshot::{AutomationMode, AutomationState},
};

/// Lamp of the automation on the dial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AutomationLamp {
    pub state: LampState,
    /// True for the symbol of a steering wheel, false for that of a gauge: the system keeps the speed alone.
    pub steers: bool,
    /// Number of bars of the time gap, 0 to 3; 0 if the system keeps none.
    pub gap_bars: u8,
}

/// State that the colour of the automation's lamp shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LampState {
    /// The system can be switched on.
    Off,
    /// The system moves pedals, wheel or both.
    On,
    /// The participant is asked to take over.
    Request,
    /// The request is urgent, or the vehicle stops by itself.
    Urgent,
}

impl AutomationLamp {
    /// Returns the lamp at a time of the drive, s. Requests blink, urgent ones at twice the rate.
    pub(super) fn at(automation: &AutomationState, time_s: f64) -> Option<Self> {
        let is_lit = |period_s: f64| (time_s / period_s).fract() < 0.5;
        let state = match automation.mode {
            AutomationMode::None => None,
            AutomationMode::Off => Some(LampState::Off),
            AutomationMode::On => Some(LampState::On),
            _ if automation.is_urgent => is_lit(BLINK_S / 2.0).then_some(LampState::Urgent),
            _ => is_lit(BLINK_S).then_some(LampState::Request),
        };
        state.map(|state| Self { state, steers: automation.steers, gap_bars: automation.gap_bars() })
    }
}

/// Returns the text of a takeover request.
pub(super) fn request_text(automation: &AutomationState) -> Option<&'static str> {
    match (automation.mode, automation.is_urgent) {
        (AutomationMode::TakeoverRequest, false) => Some("Please take over"),
        (AutomationMode::TakeoverRequest, true) => Some("TAKE OVER NOW"),
        (AutomationMode::MinimalRisk, _) => Some("STOPPING - TAKE OVER"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_blinks_and_an_urgent_one_twice_as_fast() {
        let automation = |mode, is_urgent| AutomationState { mode, is_urgent, ..AutomationState::default() };
        let changes = |state: &AutomationState| {
            // 4.2 s are six periods of 0.7 s, seen each 0.05 s from 0.025 s on.
            let lit: Vec<bool> =
                (0..84).map(|k| AutomationLamp::at(state, f64::from(k) * 0.05 + 0.025).is_some()).collect();
            lit.windows(2).filter(|pair| pair[0] != pair[1]).count()
        };
        assert_eq!(changes(&automation(AutomationMode::On, false)), 0);
        assert_eq!(changes(&automation(AutomationMode::TakeoverRequest, false)), 11);
        assert_eq!(changes(&automation(AutomationMode::TakeoverRequest, true)), 23);
        assert_eq!(AutomationLamp::at(&automation(AutomationMode::None, false), 0.0), None);
    }
}
