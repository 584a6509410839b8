//! What a study asks of LSL: the table `[lsl]` of its file. It changes nothing of what a drive computes and is no part of a scenario.

use super::confine::LOOPBACK;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Streams of this program and of other devices.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LslSettings {
    /// Open this program's streams: codrive.advice, codrive.events, codrive.controls, codrive.ego, codrive.frames.
    pub outlets: bool,
    /// Network interface on which they are heard: loopback (this machine alone), all, or a name such as eth0.
    pub interface: String,
    /// Ending of their ids, by which recorders find them again; random for each start where it is empty. Never a participant's code.
    pub source: String,
    /// Record a stream for each of these predicates, such as `type='EEG'` or `name='eyes'`; a drive begins only when all are there.
    pub record: Vec<String>,
    /// So long it is waited for each of them before the first drive, seconds.
    #[schemars(range(min = 0.1, max = 600.0))]
    pub wait_s: f64,
}

impl Default for LslSettings {
    fn default() -> Self {
        Self { outlets: false, interface: LOOPBACK.into(), source: String::new(), record: Vec::new(), wait_s: 10.0 }
    }
}

/// A setting that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LslSettingsFault {
    /// The time is no time to wait.
    #[error("wait_s is {0}; allowed: a number from 0.1 to 600 s")]
    Wait(f64),
    /// There is nothing to look for.
    #[error("record has an empty predicate; write one such as \"type='EEG'\" or \"name='eyes'\"")]
    EmptyPredicate,
    /// The interface has no name.
    #[error(
        "interface is empty; allowed: loopback (this machine alone), all, or the name of a network interface, such as eth0"
    )]
    EmptyInterface,
}

impl LslSettingsFault {
    /// The key of the setting.
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
    /// The first that cannot be.
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
