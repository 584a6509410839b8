//! The end of waiting. In: a signal to the program. Out: whether it came, for everything here that waits for another
//! program. It is one for the whole process because signals are.

use std::sync::atomic::{AtomicBool, Ordering};

static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// From here on no engine of this process waits for another program: a wait ends within a tenth of a second with
/// [`TrafficError::Interrupted`](super::TrafficError::Interrupted).
pub fn interrupt() {
    INTERRUPTED.store(true, Ordering::Relaxed);
}

/// True once [`interrupt`] was called.
pub fn is_interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed)
}
