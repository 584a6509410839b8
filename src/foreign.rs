//! Calls of libraries that read files of unknown origin. In: a call. Out: its result, or the message of its panic. A library
//! may panic on an unexpected file; that is a fault of the file and must not end the program. Only for calls whose data are
//! dropped after a panic, so that nothing half-changed is used.

use std::{
    cell::Cell,
    panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook},
    sync::Once,
};

thread_local! {
    /// True inside a guarded call on this thread; its panic is reported as an error and not printed.
    static INSIDE: Cell<bool> = const { Cell::new(false) };
}

/// Calls a foreign library; a panic in it becomes an error.
///
/// # Errors
/// Message of the panic.
pub fn guarded<T>(call: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = take_hook();
        set_hook(Box::new(move |info| {
            if !INSIDE.get() {
                before(info);
            }
        }));
    });
    let was = INSIDE.replace(true);
    let result = catch_unwind(AssertUnwindSafe(call));
    INSIDE.set(was);
    result.map_err(|thrown| {
        let words = thrown.downcast_ref::<&str>().map(|words| (*words).to_owned());
        words.or_else(|| thrown.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no reason given".into())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_its_message_and_the_next_call_works() {
        assert_eq!(guarded(|| 3), Ok(3));
        let zero = std::hint::black_box(0);
        assert_eq!(guarded(|| 1 / zero), Err("attempt to divide by zero".into()));
        assert_eq!(guarded(|| panic!("no {}", "good")), Err::<(), _>("no good".into()));
        assert_eq!(guarded(|| guarded(|| panic!("inner"))), Ok(Err::<(), _>("inner".into())));
        assert!(!INSIDE.get());
    }
}
