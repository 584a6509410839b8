//! LSL settings of a study: the table `[lsl]` of its file. They do not change what a drive computes and are no part of
//! a scenario.

use super::confine::LOOPBACK;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Streams of this program and of other devices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LslSettings {
    /// Open this program's streams: codrive.advice, codrive.events, codrive.controls, codrive.ego, codrive.frames.
    pub outlets: bool,
    /// Network interface on which the streams can be received: loopback (this computer only), all, or a name such as
    /// eth0.
    pub interface: String,
    /// Ending of the streams' ids, by which recorders find them again; empty for a random one at each start. Never use
    /// a participant's code.
    pub source: String,
    /// Record a stream for each of these predicates, such as `type='EEG'` or `name='eyes'`; drives begin only when all
    /// streams are present.
    pub record: Vec<String>,
    /// Longest wait for each of these streams before the first drive, seconds.
    #[schemars(range(min = 0.1, max = 600.0))]
    pub wait_s: f64,
}

impl Default for LslSettings {
    fn default() -> Self {
        Self { outlets: false, interface: LOOPBACK.into(), source: String::new(), record: Vec::new(), wait_s: 10.0 }
    }
}

/// Error in the settings of LSL.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LslSettingsFault {
    /// Wait outside the allowed range, s.
    #[error("wait_s is {0}; allowed: a number from 0.1 to 600 s")]
    Wait(f64),
    /// Empty predicate in `record`.
    #[error("record has an empty predicate; write one such as \"type='EEG'\" or \"name='eyes'\"")]
    EmptyPredicate,
    /// Empty name of the interface.
    #[error(
        "interface is empty; allowed: loopback (this machine alone), all, or the name of a network interface, such as eth0"
    )]
    EmptyInterface,
}

impl LslSettingsFault {
    /// Returns the key of the setting.
    pub fn key(&self) -> &'static str {
        match self {
            Self::Wait(_) => "wait_s",
            Self::EmptyPredicate => "record",
            Self::EmptyInterface => "interface",
        }
    }
}

impl LslSettings {
    /// Checks the values.
    ///
    /// # Errors
    /// The first invalid value.
    pub fn check(&self) -> Result<(), LslSettingsFault> {
        if !(0.1..=600.0).contains(&self.wait_s) {
            return Err(LslSettingsFault::Wait(self.wait_s));
        }
        if self.record.iter().any(|predicate| predicate.trim().is_empty()) {
            return Err(LslSettingsFault::EmptyPredicate);
        }
        if self.interface.is_empty() {
            return Err(LslSettingsFault::EmptyInterface);
        }
        Ok(())
    }
}
