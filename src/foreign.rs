//! Libraries that read files of others. In: a call of one. Out: what it returns, or the words of its panic: a library that
//! meets a file its authors never thought of may break off, and that is a mistake in the file, not the end of the program.
//! Only for calls that leave nothing half-changed behind: what they worked on is dropped with the panic.

use std::{
    cell::Cell,
    panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook},
    sync::Once,
};

thread_local! {
    /// This thread is inside a call whose panic is reported as an error, so that it is not printed as well.
    static INSIDE: Cell<bool> = const { Cell::new(false) };
}

/// Calls a foreign library; a panic in it becomes an error.
///
/// # Errors
/// The words of the panic.
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
        words.or_else(|| thrown.downcast_ref::<String>().cloned()).unwrap_or_else(|| "it gave no reason".into())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_its_words_and_the_next_call_goes_on() {
        assert_eq!(guarded(|| 3), Ok(3));
        let zero = std::hint::black_box(0);
        assert_eq!(guarded(|| 1 / zero), Err("attempt to divide by zero".into()));
        assert_eq!(guarded(|| panic!("no {}", "good")), Err::<(), _>("no good".into()));
        assert_eq!(guarded(|| guarded(|| panic!("inner"))), Ok(Err::<(), _>("inner".into())));
        assert!(!INSIDE.get());
    }
}
