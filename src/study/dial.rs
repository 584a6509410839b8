//! Effect of a study on the speedometer. All trials share one scale, because a scale that followed each trial's traffic would be a second
//! factor in a study of density. A range narrower than the displayed number resolves is an error. In: the highest speed expected in any
//! trial; the drives. Out: a trial's scenario with the common scale; or the range at fault, located where it was set.

use super::{Study, StudyError, file::SegmentKind};
use crate::{
    hud::{self, DialView},
    policy,
    scenario::{DisplaySettings, Scenario},
    sim::ExpectedSpeeds,
};

/// Returns the highest speed that a driver must expect, m/s.
pub(super) fn top_mps(expected: &ExpectedSpeeds) -> f64 {
    hud::expected_top_mps(expected.equilibrium_mps, expected.advised_mps, expected.limit_mps)
}

impl Study {
    /// Checks that no drive advises a range that the speedometer cannot show. A study that has begun may continue with such a range.
    ///
    /// # Errors
    /// A range is too narrow; the message has file, line, value and the allowed values. `name` is the file's name in the message.
    pub fn check_ranges(&self, name: &str) -> Result<(), StudyError> {
        for (i, segment) in self.file.segment.iter().enumerate() {
            let conditions: Vec<_> = match segment.kind {
                SegmentKind::Drive => vec![None],
                SegmentKind::Trials => self.conditions.iter().map(Some).collect(),
                _ => Vec::new(),
            };
            for condition in conditions {
                let Ok(scenario) = self.drive(i, condition) else { continue };
                if let (false, Err(fault)) = (scenario.policy == policy::NAMES[0], hud::check_range(&scenario)) {
                    return Err(self
                        .wrong(i, condition, &["range_mph"], fault.to_string())
                        .located(&self.source, name));
                }
            }
        }
        Ok(())
    }

    /// Returns a trial with the scale of all trials, unless its own settings have one.
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
