//! Ctrl-C, SIGTERM and SIGHUP. Out: a flag at which loops end in order. While SUMO reads a file, which cannot be interrupted,
//! the process itself ends.

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

/// Exit code of a program ended by Ctrl-C, as shells report it.
pub(super) const INTERRUPTED: u8 = 130;
/// Interval between checks of a traffic start in progress.
const LOOK: Duration = Duration::from_millis(20);
const LOOKS: usize = 25;

/// Returns a flag that Ctrl-C sets. The program then ends at the next frame, with everything written.
pub(crate) fn stop_on_ctrl_c() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    // The handler runs on its own thread.
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

/// Ends the process if traffic is still starting after half a second.
fn end_stuck_start() {
    for _ in 0..LOOKS {
        if traffic::starts_under_way() == 0 {
            return;
        }
        sleep(LOOK);
    }
    out::status_line("codrive: ended while SUMO was reading its files; nothing of this drive is recorded");
    end_at_once(INTERRUPTED);
}

/// Ends the process with a code if traffic is still starting on a thread that is not joined. A normal exit would run the
/// destructors of SUMO's libraries while they read.
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
