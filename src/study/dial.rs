//! One scale of the speedometer for all trials of a study: one that followed each trial's traffic would be a second factor in
//! a study of density. In: the highest speed to be expected in any trial. Out: a trial's scenario with that scale.

use super::Study;
use crate::{
    hud::{self, DialView},
    scenario::{DisplaySettings, Scenario},
    sim::ExpectedSpeeds,
};

/// The highest speed that a driver is to expect, m/s.
pub(super) fn top_mps(expected: &ExpectedSpeeds) -> f64 {
    hud::expected_top_mps(expected.equilibrium_mps, expected.advised_mps, expected.limit_mps)
}

impl Study {
    /// A trial with the scale of all trials, unless its own settings name one.
    pub(super) fn with_dial(&self, trial: Scenario) -> Scenario {
        if trial.display.dial_full > 0.0 {
            return trial;
        }
        Scenario {
            display: DisplaySettings {
                dial_full: DialView::scale_for(self.expected.top_mps, trial.display.units).full,
                ..trial.display
            },
            ..trial
        }
    }
}
