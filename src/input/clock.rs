//! Time stamps of input. In: the kernel's event times. Out: times on the monotonic clock, which all threads and the
//! kernel share, so that their differences are latencies.

use std::time::Duration;

/// A moment on the system's monotonic clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct TimeStamp(pub Duration);

/// Largest age of an input event. An older one means a device that replays events or a wrong clock, and is no latency.
const PLAUSIBLE: Duration = Duration::from_secs(1);

impl TimeStamp {
    /// Returns the present time.
    pub fn now() -> Self {
        Self(monotonic())
    }

    /// Returns the time from `self` to `later`, zero if `later` is earlier.
    pub fn until(self, later: Self) -> Duration {
        later.0.saturating_sub(self.0)
    }

    /// Returns the time stamp of an event, `None` if it is not within the last second before `now`.
    pub fn plausible(event: Duration, now: Self) -> Option<Self> {
        let age = now.0.checked_sub(event)?;
        (age <= PLAUSIBLE).then_some(Self(event))
    }
}

#[cfg(target_os = "linux")]
fn monotonic() -> Duration {
    // The clock with which the kernel stamps events after EVIOCSCLOCKID.
    nix::time::clock_gettime(nix::time::ClockId::CLOCK_MONOTONIC).map(Duration::from).unwrap_or_default()
}

#[cfg(not(target_os = "linux"))]
fn monotonic() -> Duration {
    use std::{sync::OnceLock, time::Instant};
    static START: OnceLock<Instant> = OnceLock::new();
    #[allow(clippy::disallowed_methods, reason = "input is where the time of devices enters")]
    let now = Instant::now;
    START.get_or_init(now).elapsed()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_advances_and_differences_are_never_negative() {
        let before = TimeStamp::now();
        std::thread::sleep(Duration::from_millis(20));
        let after = TimeStamp::now();
        assert!(before.until(after) >= Duration::from_millis(20) && before.0 > Duration::ZERO);
        assert_eq!(after.until(before), Duration::ZERO);
    }

    #[test]
    fn only_an_event_of_the_last_second_has_an_age() {
        let now = TimeStamp(Duration::from_secs(100));
        assert_eq!(
            TimeStamp::plausible(Duration::from_millis(99_990), now).unwrap().until(now),
            Duration::from_millis(10)
        );
        assert_eq!(TimeStamp::plausible(Duration::from_millis(100), now), None, "a replayed event from 1970");
        assert_eq!(TimeStamp::plausible(Duration::from_secs(101), now), None, "an event from the future");
        let second = Duration::from_secs(99);
        assert_eq!(TimeStamp::plausible(second, now), Some(TimeStamp(second)), "a second ago at the most");
        assert_eq!(TimeStamp::plausible(second - Duration::from_nanos(1), now), None);
    }
}
