//! The end of the program by Ctrl-C, SIGTERM or SIGHUP. Out: a flag for loops that end in an orderly way; and where SUMO reads a
//! file, which nothing interrupts, the end of the process itself.

use super::out;
use crate::{temporary, traffic};
use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    thread::sleep,
    time::Duration,
};

/// Exit code of a program that Ctrl-C ended, as shells state it.
pub(super) const INTERRUPTED: u8 = 130;
/// Interval at which a start of traffic is looked at, and the longest that it may go on: half a second, of the second within which a person expects the end.
const LOOK: Duration = Duration::from_millis(20);
const LOOKS: usize = 25;

/// A flag that says how the program ends when someone presses Ctrl-C: at the next frame, with everything written.
pub(crate) fn stop_on_ctrl_c() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    // It runs on a thread of its own.
    let set = ctrlc::set_handler(move || {
        flag.store(true, Ordering::Relaxed);
        traffic::interrupt();
        end_stuck_start();
    });
    if let Err(error) = set {
        log::warn!("Ctrl-C will end the program at once: {error}");
    }
    stop
}

/// Ends the process where traffic is still being started after half a second.
fn end_stuck_start() {
    for _ in 0..LOOKS {
        if traffic::starts_under_way() == 0 {
            return;
        }
        sleep(LOOK);
    }
    out::status_line("codrive: ended while SUMO was reading its files; of this drive nothing is recorded");
    end_at_once(INTERRUPTED);
}

/// Ends the process with a code where traffic is still being started on a thread that nobody waits for: the end in order would run
/// the destructors of SUMO's libraries while they read.
pub(super) fn end_if_starting(code: u8) {
    if traffic::starts_under_way() > 0 {
        end_at_once(code);
    }
}

fn end_at_once(code: u8) -> ! {
    temporary::remove_all();
    #[cfg(target_os = "linux")]
    // SAFETY: it takes a number and does not return.
    unsafe {
        nix::libc::_exit(code.into())
    }
    #[cfg(not(target_os = "linux"))]
    std::process::exit(code.into())
}
