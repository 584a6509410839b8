//! Triggers: one byte on a wire for each named event, for amplifiers that record no network stream. In: events by name. Out: bytes on a
//! serial port, or on an adapter that emulates a parallel port, written by a thread of their own; and the time of each.
//!
//! A parallel-port adapter holds a byte on its eight lines until the next byte comes. For such a device the byte returns to 0 after a set
//! time, and the next byte waits for that.

mod port;

pub use port::TriggerPort;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Table `[triggers]` of a study file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TriggerSettings {
    /// Device file, such as /dev/ttyUSB0.
    pub device: PathBuf,
    /// Baud rate, bit/s; one of the standard rates from 9600 to 921600.
    #[serde(default = "baud")]
    pub baud: u32,
    /// Time after which the byte returns to 0, ms; 0 for a device that makes a pulse of each byte.
    #[serde(default)]
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub return_to_zero_ms: f64,
    /// Byte of each event; an event without a byte has no trigger.
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
    /// Byte for a new advice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub advice: Option<u8>,
    /// Byte for the start of a drive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trial_start: Option<u8>,
    /// Byte for the end of a drive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trial_end: Option<u8>,
    /// Byte for a mark of the experimenter or the participant.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mark: Option<u8>,
    /// Byte for a contact with another vehicle.
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

    /// Returns the byte of an event; `None` if it has none.
    pub fn of(self, event: &str) -> Option<u8> {
        self.named().into_iter().find(|(name, _)| *name == event)?.1
    }
}

/// A trigger setting that is not allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TriggerSettingsFault {
    /// A baud rate that serial ports do not support.
    #[error("baud is {0}; allowed: 9600, 19200, 38400, 57600, 115200, 230400, 460800, 921600")]
    Baud(u32),
    /// A time out of range.
    #[error("return_to_zero_ms is {0}; allowed: a number from 0 to 1000 ms")]
    Return(f64),
    /// A byte of 0, which is the state between triggers.
    #[error("the code of {0} is 0; allowed: 1 to 255; 0 is the level between triggers")]
    Zero(&'static str),
    /// Two events with the same byte, which an analysis could not tell apart.
    #[error("{0} and {1} have the same code {2}; each event needs its own code")]
    Twice(&'static str, &'static str, u8),
}

impl TriggerSettingsFault {
    /// Returns the key of the setting at fault.
    pub fn key(&self) -> &'static str {
        match self {
            Self::Baud(_) => "baud",
            Self::Return(_) => "return_to_zero_ms",
            Self::Zero(_) | Self::Twice(..) => "codes",
        }
    }
}

impl TriggerSettings {
    /// Checks baud rate, return time and bytes.
    ///
    /// # Errors
    /// The first setting that is not allowed.
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

/// Reason why there are no triggers.
#[derive(Debug, thiserror::Error)]
pub enum TriggerError {
    /// The device cannot be opened.
    #[error(
        "the trigger device {device} cannot be opened: {why}\n  remedy: plug it in, name its file, and give this user \
         write access (on Debian: the group dialout)"
    )]
    Open {
        /// Device file of the settings.
        device: PathBuf,
        /// Error of the operating system.
        why: std::io::Error,
    },
    /// The thread cannot be started.
    #[error("the thread for triggers cannot start: {0}")]
    Thread(std::io::Error),
    /// The operating system is not supported.
    #[error("triggers work on Linux only\n  remedy: leave [triggers] out")]
    System,
}

/// A trigger, with the time at which it was written.
#[derive(Clone, Debug, PartialEq)]
pub struct WrittenTrigger {
    /// Name of the event.
    pub event: String,
    /// Byte of the event.
    pub code: u8,
    /// Time of the event, s, on the clock of [`crate::lsl::local_clock_s`].
    pub due_s: f64,
    /// Time when the operating system had taken the byte, s, on the same clock; `None` if writing failed.
    pub written_s: Option<f64>,
    /// Error message if writing failed.
    pub why: Option<String>,
}

#[cfg(test)]
mod tests;
