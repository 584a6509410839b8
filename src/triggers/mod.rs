//! Triggers: a byte on a wire for each of named events, for amplifiers that record no network stream. In: events by name. Out: bytes
//! on a serial port or on a device that stands in for a parallel port, written by a thread of their own, and when each was.
//!
//! A device that stands in for a parallel port holds a byte on its eight lines until another comes: there the byte returns to 0
//! after a stated time, and the next waits for that.

mod port;

pub use port::TriggerPort;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The table `[triggers]` of a study.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TriggerSettings {
    /// The device's file, such as /dev/ttyUSB0.
    pub device: PathBuf,
    /// Its speed, bits a second, of those that serial ports have.
    #[serde(default = "baud")]
    pub baud: u32,
    /// The byte returns to 0 after so long, milliseconds; 0 for a device that makes a pulse of each byte by itself.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub return_to_zero_ms: f64,
    /// The byte of each event; an event without one has no trigger.
    #[serde(default)]
    pub codes: TriggerCodes,
}

fn baud() -> u32 {
    115_200
}

/// Bytes by event, 1 to 255.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct TriggerCodes {
    /// A new advice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub advice: Option<u8>,
    /// A drive begins.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trial_start: Option<u8>,
    /// It is over.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trial_end: Option<u8>,
    /// A mark of the experimenter or of the participant.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mark: Option<u8>,
    /// A contact with another car.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact: Option<u8>,
}

impl TriggerCodes {
    fn named(self) -> [(&'static str, Option<u8>); 5] {
        let Self { advice, trial_start, trial_end, mark, contact } = self;
        [
            ("advice", advice),
            ("trial_start", trial_start),
            ("trial_end", trial_end),
            ("mark", mark),
            ("contact", contact),
        ]
    }

    /// The byte of an event; `None` where it has none.
    pub fn of(self, event: &str) -> Option<u8> {
        self.named().into_iter().find(|(name, _)| *name == event)?.1
    }
}

/// A setting that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TriggerSettingsFault {
    /// No serial port has it.
    #[error("baud is {0}; allowed: 9600, 19200, 38400, 57600, 115200, 230400, 460800, 921600")]
    Baud(u32),
    /// It is no such time.
    #[error("return_to_zero_ms is {0}; allowed: a number from 0 to 1000 ms")]
    Return(f64),
    /// 0 is the state between triggers.
    #[error("the code of {0} is 0; allowed: 1 to 255, for 0 is what stands between triggers")]
    Zero(&'static str),
    /// An analysis could not tell them apart.
    #[error("{0} and {1} have the same code {2}; each event needs its own")]
    Twice(&'static str, &'static str, u8),
}

impl TriggerSettingsFault {
    /// The key of the setting.
    pub fn key(&self) -> &'static str {
        match self {
            Self::Baud(_) => "baud",
            Self::Return(_) => "return_to_zero_ms",
            Self::Zero(_) | Self::Twice(..) => "codes",
        }
    }
}

impl TriggerSettings {
    /// Checks the values.
    ///
    /// # Errors
    /// The first that cannot be.
    pub fn check(&self) -> Result<(), TriggerSettingsFault> {
        if !port::BAUDS.contains(&self.baud) {
            return Err(TriggerSettingsFault::Baud(self.baud));
        }
        if !(0.0..=1000.0).contains(&self.return_to_zero_ms) {
            return Err(TriggerSettingsFault::Return(self.return_to_zero_ms));
        }
        let codes: Vec<(&str, u8)> =
            self.codes.named().into_iter().filter_map(|(name, code)| Some((name, code?))).collect();
        for (i, &(name, code)) in codes.iter().enumerate() {
            if code == 0 {
                return Err(TriggerSettingsFault::Zero(name));
            }
            if let Some((other, _)) = codes[..i].iter().find(|(_, before)| *before == code) {
                return Err(TriggerSettingsFault::Twice(other, name, code));
            }
        }
        Ok(())
    }
}

/// Why there are no triggers.
#[derive(Debug, thiserror::Error)]
pub enum TriggerError {
    /// The device cannot be opened.
    #[error(
        "the trigger device {device}: {why}\n  remedy: plug it in, name its file, and let this user write to it (on Debian: the group dialout)"
    )]
    Open {
        /// Its file.
        device: PathBuf,
        /// What the system said.
        why: std::io::Error,
    },
    /// The system gives no thread.
    #[error("the thread of the triggers: {0}")]
    Thread(std::io::Error),
    /// This system has no serial ports that the program knows.
    #[error("triggers are written on Linux only; leave [triggers] out")]
    System,
}

/// A trigger that was due.
#[derive(Clone, Debug, PartialEq)]
pub struct WrittenTrigger {
    /// Its event.
    pub event: String,
    /// Its byte.
    pub code: u8,
    /// When the event was, seconds on the clock of [`crate::lsl::local_clock_s`].
    pub due_s: f64,
    /// When the system had taken the byte, on the same clock; `None` if it did not.
    pub written_s: Option<f64>,
    /// Why it did not.
    pub why: Option<String>,
}

#[cfg(test)]
mod tests;
