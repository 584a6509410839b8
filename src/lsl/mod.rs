//! Lab Streaming Layer: streams of this program and of other devices on one network, each sample with the time at which it was
//! taken. In: descriptions, samples. Out: streams that others record; samples of others with their time stamps.
//!
//! * [`library`]: liblsl, opened at run time. `stream`: what a stream says of itself.
//! * [`Outlet`]: a stream of this program; [`confine`]: the network on which it is heard. [`Inlet`]: a stream of another device, found by a predicate.
//! * [`settings`]: what a study asks for.
//!
//! Time stamps are seconds on the monotonic clock of the machine that took the sample; [`Inlet::clock_offset`] says how far
//! that clock is from this machine's.

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

/// Why something with LSL cannot be done.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum LslError {
    /// The library is not on this machine.
    #[error("liblsl is not here: {0}\n  remedy: run scripts/setup --lsl, or set CODRIVE_LSL to the library's file")]
    Absent(String),
    /// The library refused a call.
    #[error("liblsl refused {what}: {why}")]
    Refused {
        /// What was asked of it.
        what: String,
        /// Its own words.
        why: String,
    },
    /// A stream that was named is not there.
    #[error(
        "no LSL stream with {predicate} came within {seconds} s. {}\n  remedy: start the device's own LSL program, or change the predicate",
        seen_in_words(seen)
    )]
    NotFound {
        /// The predicate.
        predicate: String,
        /// How long it was waited for.
        seconds: f64,
        /// The streams that are there, in words.
        seen: Vec<String>,
    },
    /// The stream was there and is gone.
    #[error("the LSL stream {0} is gone")]
    Lost(String),
    /// The other side did not answer in time.
    #[error("the LSL stream {0} does not answer")]
    Silent(String),
    /// The program is to end.
    #[error("interrupted while waiting for an LSL stream")]
    Interrupted,
    /// The setting names no interface of this machine.
    #[error(
        "there is no network interface \"{name}\"; allowed: loopback, all, or one of {known}\n  remedy: interface in [lsl]"
    )]
    NoInterface {
        /// The setting.
        name: String,
        /// The interfaces that there are.
        known: String,
    },
    /// The stream has more channels than a recording takes.
    #[error(
        "the LSL stream {name} has {channels} channels; allowed: {most}\n  remedy: a predicate of another stream, or a stream of fewer channels"
    )]
    TooWide {
        /// Name of the stream.
        name: String,
        /// Channels of the stream.
        channels: usize,
        /// The most.
        most: usize,
    },
}

fn seen_in_words(seen: &[String]) -> String {
    match seen {
        [] => "No stream is there at all.".into(),
        some => format!("Streams that are there: {}.", some.join("; ")),
    }
}

/// Variable that names liblsl's configuration.
pub const CONFIG_VARIABLE: &str = "LSLAPICFG";
/// Name of that file in other places. liblsl reads one of the working folder before all others: it may say where to write a log.
pub const CONFIG: &str = "lsl_api.cfg";

/// Now, seconds on the clock of LSL's time stamps: liblsl's own where it is loaded, else the monotonic clock that it reads.
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
