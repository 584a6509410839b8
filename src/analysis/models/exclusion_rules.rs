//! Rules of exclusion of a planned analysis. In: the table `[analysis.exclude]` of a study's file. Out: [`ExclusionRules`], and each
//! rule as a sentence.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Rules that leave out trials and participants; a rule that is not given leaves nothing out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ExclusionRules {
    /// Smallest recorded share of a trial's planned length, 0 to 1; trials below it are left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub least_recorded_share: Option<f64>,
    /// Largest number of contacts with other vehicles in a trial; trials above it are left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub most_contacts: Option<u32>,
    /// Largest share of a trial's length given up because frames came too late (`dropped_s`), 0 to 1; trials above it are left
    /// out.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0.0, max = 1.0))]
    pub most_dropped_share: Option<f64>,
    /// Smallest number of remaining trials of a participant; participants below it are left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least_trials: Option<u32>,
    /// Leave out participants whose session was not completed.
    pub only_complete_sessions: bool,
}

impl ExclusionRules {
    /// Returns a sentence for each rule that is given.
    pub fn sentences(&self) -> Vec<String> {
        let share = self.least_recorded_share.map(|share| {
            format!("A trial is left out if less than {} % of its planned length was recorded.", 100.0 * share)
        });
        let contacts = self.most_contacts.map(|most| match most {
            0 => "A trial is left out if there was a contact with another vehicle.".into(),
            1 => "A trial is left out if there was more than one contact with other vehicles.".into(),
            most => format!("A trial is left out if there were more than {most} contacts with other vehicles."),
        });
        let dropped = self.most_dropped_share.map(|share| {
            format!(
                "A trial is left out if more than {} % of its length was given up because pictures came too late.",
                100.0 * share
            )
        });
        let trials = self.least_trials.map(|least| match least {
            1 => "A participant is left out if no trial remains after these rules.".into(),
            least => format!("A participant is left out if fewer than {least} trials remain after these rules."),
        });
        let complete = self
            .only_complete_sessions
            .then(|| "A participant is left out if the session was not completed.".to_owned());
        [share, contacts, dropped, complete, trials].into_iter().flatten().collect()
    }
}
