//! Work beside Python: on all cores, without the interpreter's lock, and without a panic that reaches the interpreter.

use pyo3::{exceptions::PyRuntimeError, prelude::*};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::{
    mem,
    panic::{AssertUnwindSafe, catch_unwind},
    process,
    sync::{Arc, Mutex, PoisonError},
};

/// The pool and the process that its threads live in: a process that Python forks has none of them.
static POOL: Mutex<Option<(u32, Arc<ThreadPool>)>> = Mutex::new(None);

/// As many threads as there are cores, or as `RAYON_NUM_THREADS` says.
///
/// # Errors
/// `RuntimeError` where the system gives no threads.
pub fn pool() -> PyResult<Arc<ThreadPool>> {
    let mut pool = POOL.lock().unwrap_or_else(PoisonError::into_inner);
    match &*pool {
        Some((process, threads)) if *process == process::id() => Ok(Arc::clone(threads)),
        _ => {
            let threads = ThreadPoolBuilder::new().build();
            let threads = Arc::new(threads.map_err(|e| PyRuntimeError::new_err(format!("no threads: {e}")))?);
            // Taking a pool down waits for its threads, which are not here.
            mem::forget(pool.replace((process::id(), Arc::clone(&threads))));
            Ok(threads)
        }
    }
}

/// Works on all cores while other threads of Python go on.
///
/// # Errors
/// `RuntimeError` where it panics, which is a bug of codrive.
pub fn on_all_cores<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let pool = pool()?;
    here(py, || pool.install(work))
}

/// The same on this thread alone: what one core does at once waits for no other.
///
/// # Errors
/// As [`on_all_cores`].
pub fn here<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    py.detach(|| catch_unwind(AssertUnwindSafe(work))).map_err(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str);
        let text = text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
        PyRuntimeError::new_err(format!("a bug of codrive: {text}; please report it with the call that led to it"))
    })
}
