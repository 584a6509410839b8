//! Lab Streaming Layer: streams of this program and of other devices on one network, each sample with the time at which
//! it was taken. In: descriptions, samples. Out: streams for recorders; samples of other devices with their time
//! stamps.
//!
//! * [`library`]: liblsl, opened at run time. `stream`: the descriptions of streams.
//! * [`Outlet`]: a stream of this program; [`confine`]: the network on which it can be received. [`Inlet`]: a stream of
//!   another device, found by a predicate.
//! * [`settings`]: the table `[lsl]` of a study.
//!
//! Time stamps are seconds on the monotonic clock of the computer that took the sample; [`Inlet::clock_offset`] gives
//! the offset of that clock from this computer's.

pub mod confine;
mod inlet;
pub mod library;
mod outlet;
pub mod settings;
mod stream;

pub use confine::OutletInterface;
pub use inlet::{ClockOffset, Inlet, SampleChunk, SampleValues, find, resolve, resolve_all};
pub use outlet::Outlet;
pub use settings::{LslSettings, LslSettingsFault};
pub use stream::{Channel, ChannelFormat, FoundStream, StreamDescription};

/// Error of the Lab Streaming Layer.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LslError {
    /// The library is not on this computer.
    #[error(
        "liblsl was not found: {0}\n  remedy: run scripts/setup --lsl in a checkout, or set CODRIVE_LSL to the library's file; pip install pylsl brings one"
    )]
    Absent(String),
    /// The library refused a call.
    #[error("liblsl refused {what}: {why}")]
    Refused {
        /// Name of the refused operation.
        what: String,
        /// Reason given by the library.
        why: String,
    },
    /// No stream matches the predicate.
    #[error(
        "no LSL stream with {predicate} was found within {seconds} s. {}\n  remedy: start the device's own LSL \
         program, or change the predicate",
        seen_text(seen)
    )]
    NotFound {
        /// Predicate of the search.
        predicate: String,
        /// Duration of the search, s.
        seconds: f64,
        /// Descriptions of the streams that were found.
        seen: Vec<String>,
    },
    /// The stream was there and is lost.
    #[error("the LSL stream {0} is gone")]
    Lost(String),
    /// The device did not respond in time.
    #[error("the LSL stream {0} does not answer")]
    Silent(String),
    /// The program is about to end.
    #[error("interrupted while waiting for an LSL stream")]
    Interrupted,
    /// The setting names no network interface of this computer.
    #[error(
        "there is no network interface \"{name}\"; allowed: loopback, all, or one of {known}\n  remedy: set interface \
         in [lsl]"
    )]
    NoInterface {
        /// Name in the setting.
        name: String,
        /// Names of this computer's interfaces, separated by commas.
        known: String,
    },
    /// The stream has more channels than a recording supports.
    #[error(
        "the LSL stream {name} has {channels} channels; allowed: {most}\n  remedy: use the predicate of another \
         stream, or a stream with fewer channels"
    )]
    TooWide {
        /// Name of the stream.
        name: String,
        /// Number of channels of the stream.
        channels: usize,
        /// Largest number of channels.
        most: usize,
    },
}

fn seen_text(seen: &[String]) -> String {
    match seen {
        [] => "There is no stream.".into(),
        some => format!("Streams found: {}.", some.join("; ")),
    }
}

/// Environment variable that names liblsl's configuration file.
pub const CONFIG_VARIABLE: &str = "LSLAPICFG";
/// Name of the configuration file in other places. liblsl reads the one in the working folder first; it may name a log
/// file.
pub const CONFIG: &str = "lsl_api.cfg";

/// Returns the present time, s on the clock of LSL's time stamps: liblsl's own clock if it is loaded, otherwise the
/// monotonic clock that liblsl reads.
pub fn local_clock_s() -> f64 {
    library::loaded().map_or_else(monotonic_s, library::Library::local_clock_s)
}

#[cfg(target_os = "linux")]
fn monotonic_s() -> f64 {
    let now = nix::time::clock_gettime(nix::time::ClockId::CLOCK_MONOTONIC);
    now.map(std::time::Duration::from).unwrap_or_default().as_secs_f64()
}

#[cfg(not(target_os = "linux"))]
fn monotonic_s() -> f64 {
    use std::{sync::OnceLock, time::Instant};
    static START: OnceLock<Instant> = OnceLock::new();
    #[allow(clippy::disallowed_methods, reason = "time stamps of samples are wall time, not simulation")]
    let now = Instant::now;
    START.get_or_init(now).elapsed().as_secs_f64()
}

#[cfg(test)]
mod tests;
