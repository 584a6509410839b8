//! Interruption of waits for another program. In: a signal to the program, or a request to end the waits of one thread. Out: the state of
//! the interruption, for all code that waits for another program; and the number of starts of traffic under way.

use super::TrafficError;
use std::{
    cell::RefCell,
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
};

/// Process-wide flag, because signals are process-wide.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

thread_local! {
    /// Interruption that this thread obeys in addition.
    static OBEYED: RefCell<Option<Interruption>> = const { RefCell::new(None) };
}

/// Ends all present and future waits of this process for another program: each ends within a tenth of a second with
/// [`TrafficError::Interrupted`](super::TrafficError::Interrupted).
pub fn interrupt() {
    INTERRUPTED.store(true, Ordering::Relaxed);
}

/// Returns true once [`interrupt`] was called, or the [`Interruption`] of this thread was triggered.
pub fn is_interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed) || OBEYED.with_borrow(|own| own.as_ref().is_some_and(Interruption::has_come))
}

/// Fails after an interruption; for work that proceeds step by step.
///
/// # Errors
/// [`TrafficError::Interrupted`].
pub fn go_on() -> Result<(), TrafficError> {
    if is_interrupted() { Err(TrafficError::Interrupted) } else { Ok(()) }
}

/// Number of starts of traffic under way in this process.
static STARTING: AtomicUsize = AtomicUsize::new(0);

/// Start of traffic, from the first read of its files to the end of the warm-up; it ends on drop. SUMO cannot be interrupted while it reads
/// a file. Nothing of the drive is recorded yet, so a program that must end during a start may exit at once.
#[derive(Debug)]
pub struct TrafficStart(());

impl TrafficStart {
    /// Registers a start of traffic.
    pub fn begin() -> Self {
        STARTING.fetch_add(1, Ordering::SeqCst);
        Self(())
    }
}

impl Drop for TrafficStart {
    fn drop(&mut self) {
        STARTING.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Returns the number of starts of traffic under way.
pub fn starts_under_way() -> usize {
    STARTING.load(Ordering::SeqCst)
}

/// Interruption of one thread's waits; clones share one state.
#[derive(Clone, Debug, Default)]
pub struct Interruption(Arc<AtomicBool>);

impl Interruption {
    /// Makes all further waits of this thread end with this interruption.
    pub fn obey(&self) {
        OBEYED.set(Some(self.clone()));
    }

    /// Ends the waits of the thread that obeys it.
    pub fn interrupt(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    fn has_come(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
