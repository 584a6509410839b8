//! Interrupts waiting for another program. In: a signal to the program, or somebody who no longer wants what a thread waits
//! for. Out: whether that came, for everything here that waits for another program, and if traffic is being started.

use super::TrafficError;
use std::{
    cell::RefCell,
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicUsize, Ordering},
    },
};

/// One for the whole process because signals are.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

thread_local! {
    /// The interruption that this thread obeys besides.
    static OBEYED: RefCell<Option<Interruption>> = const { RefCell::new(None) };
}

/// From here on no engine of this process waits for another program: a wait ends within a tenth of a second with
/// [`TrafficError::Interrupted`](super::TrafficError::Interrupted).
pub fn interrupt() {
    INTERRUPTED.store(true, Ordering::Relaxed);
}

/// True once [`interrupt`] was called, or the [`Interruption`] that this thread obeys.
pub fn is_interrupted() -> bool {
    INTERRUPTED.load(Ordering::Relaxed) || OBEYED.with_borrow(|own| own.as_ref().is_some_and(Interruption::has_come))
}

/// Fails with [`TrafficError::Interrupted`] once the wait is over: for what goes on step by step.
///
/// # Errors
/// As said.
pub fn go_on() -> Result<(), TrafficError> {
    if is_interrupted() { Err(TrafficError::Interrupted) } else { Ok(()) }
}

/// Starts of traffic that are under way in this process.
static STARTING: AtomicUsize = AtomicUsize::new(0);

/// A start of traffic, from the first look at its files to the end of the warm-up, until it is dropped. SUMO cannot be
/// interrupted while it reads a file. As nothing of the drive is recorded yet, a program that shall end meanwhile may do so
/// at once.
#[derive(Debug)]
pub struct TrafficStart(());

impl TrafficStart {
    /// Begins one.
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

/// Number of starts of traffic that are under way.
pub fn starts_under_way() -> usize {
    STARTING.load(Ordering::SeqCst)
}

/// The end of one thread's waiting; clones are the same one.
#[derive(Clone, Debug, Default)]
pub struct Interruption(Arc<AtomicBool>);

impl Interruption {
    /// Whatever this thread waits for from here on ends with it.
    pub fn obey(&self) {
        OBEYED.set(Some(self.clone()));
    }

    /// Ends the waiting of the thread that obeys it.
    pub fn interrupt(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    fn has_come(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
