//! Work beside Python: on all cores, without the interpreter's lock, and without a panic that reaches the interpreter.

use codrive::traffic::Interruption;
use pyo3::{exceptions::PyRuntimeError, prelude::*};
use rayon::{ThreadPool, ThreadPoolBuilder, Yield};
use std::{
    cell::Cell,
    hint, mem,
    panic::{AssertUnwindSafe, catch_unwind, resume_unwind},
    process,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicBool, Ordering},
        mpsc::{self, RecvTimeoutError},
    },
    thread::{self, ThreadId},
    time::{Duration, Instant},
};

/// Thread pool, with the id of its process: a process that Python forks has none of the threads.
struct Threads(Mutex<Option<(u32, Arc<ThreadPool>)>>);

/// Pool with a thread per core, and a pool with one fewer, for work in which the calling thread takes part.
static ALL: Threads = Threads(Mutex::new(None));
static HELPERS: Threads = Threads(Mutex::new(None));

impl Threads {
    /// Returns the pool; creates it with `count` threads if there is none yet.
    ///
    /// # Errors
    /// `RuntimeError` if the system gives no threads.
    fn get(&self, count: impl FnOnce() -> usize) -> PyResult<Arc<ThreadPool>> {
        let mut pool = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match &*pool {
            Some((process, threads)) if *process == process::id() => Ok(Arc::clone(threads)),
            _ => {
                let threads = ThreadPoolBuilder::new().num_threads(count()).build();
                let threads = Arc::new(threads.map_err(|e| PyRuntimeError::new_err(format!("no threads: {e}")))?);
                // Dropping a pool waits for its threads, which do not exist here.
                mem::forget(pool.replace((process::id(), Arc::clone(&threads))));
                Ok(threads)
            }
        }
    }
}

/// Returns the pool with as many threads as there are cores, or as `RAYON_NUM_THREADS` says.
///
/// # Errors
/// `RuntimeError` if the system gives no threads.
pub fn pool() -> PyResult<Arc<ThreadPool>> {
    // 0: rayon's default number.
    ALL.get(|| 0)
}

/// Returns the number of threads of [`pool`].
///
/// # Errors
/// As [`pool`].
pub fn cores() -> PyResult<usize> {
    Ok(pool()?.current_num_threads())
}

/// Works on all cores while other threads of Python continue.
///
/// # Errors
/// `RuntimeError` if the work panics, which is a bug of codrive.
pub fn on_all_cores<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let pool = pool()?;
    here(py, || pool.install(work))
}

/// Does each job on a thread of its own, the first on this one. A job always has the same thread, so that its data stays in memory near
/// that core. Takes at most as many jobs as [`cores`]. Must be called within [`here`].
///
/// # Errors
/// `RuntimeError` if the system gives no threads.
pub fn side_by_side<J: Send>(jobs: Vec<J>, work: impl Fn(J) + Sync) -> PyResult<()> {
    let mut jobs = jobs.into_iter();
    let Some(own) = jobs.next() else { return Ok(()) };
    if jobs.len() == 0 {
        // Waking another thread takes longer than one block of rings.
        work(own);
        return Ok(());
    }
    let helpers = cores()? - 1;
    let others: Vec<_> = jobs.map(|job| Mutex::new(Some(job))).collect();
    HELPERS.get(|| helpers)?.in_place_scope(|scope| {
        scope.spawn_broadcast(|_, thread| {
            let job =
                others.get(thread.index()).and_then(|job| job.lock().unwrap_or_else(PoisonError::into_inner).take());
            job.into_iter().for_each(&work);
            stay_awake();
        });
        work(own);
    });
    Ok(())
}

/// Time for which a helper stays awake after its last job. Waking takes as long as half a step of a thousand rings.
const AWAKE: Duration = Duration::from_micros(100);

thread_local! {
    /// True while this thread is awake and looks for jobs.
    static LOOKS: Cell<bool> = const { Cell::new(false) };
    /// End of the last job of this thread.
    static LAST: Cell<Option<Instant>> = const { Cell::new(None) };
}

/// Looks for further jobs for a while after the present one has ended.
#[expect(clippy::disallowed_methods, reason = "the clock says when to sleep, and nothing else")]
fn stay_awake() {
    LAST.set(Some(Instant::now()));
    if LOOKS.get() {
        return;
    }
    rayon::spawn(|| {
        // Jobs found here end within `yield_now` and do not look for more themselves.
        if LOOKS.replace(true) {
            return;
        }
        let begun = Instant::now();
        while LAST.get().unwrap_or(begun).max(begun).elapsed() < AWAKE {
            if rayon::yield_now() != Some(Yield::Executed) {
                hint::spin_loop();
            }
        }
        LOOKS.set(false);
    });
}

/// Works like [`on_all_cores`], but on this thread alone: work for one core does not wait for other threads.
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

/// Interval at which Python is asked for signals while another thread works: Ctrl-C must end a wait within a second.
const SIGNALS: Duration = Duration::from_millis(50);

/// Signals to Python while several threads work without its lock: Ctrl-C. Only the thread that made it, on which Python was called, asks for
/// them; work on that thread calls [`Signals::have_come`] often.
pub struct Signals {
    have_come: AtomicBool,
    owner: ThreadId,
    /// Time of the last question, and what the handler of a signal raised.
    asked: Mutex<(Instant, Option<PyErr>)>,
}

impl Signals {
    /// Creates it for work that begins now on this thread.
    #[expect(clippy::disallowed_methods, reason = "the clock says when to ask, and nothing else")]
    pub fn new() -> Self {
        Self {
            have_come: AtomicBool::new(false),
            owner: thread::current().id(),
            asked: Mutex::new((Instant::now(), None)),
        }
    }

    /// Returns true if the work must end.
    #[expect(clippy::disallowed_methods, reason = "the clock says when to ask, and nothing else")]
    pub fn have_come(&self) -> bool {
        if self.owner == thread::current().id() {
            let mut asked = self.asked.lock().unwrap_or_else(PoisonError::into_inner);
            if asked.0.elapsed() >= SIGNALS {
                asked.1 = Python::attach(|py| py.check_signals()).err();
                asked.0 = Instant::now();
                self.have_come.fetch_or(asked.1.is_some(), Ordering::Relaxed);
            }
        }
        self.have_come.load(Ordering::Relaxed)
    }

    /// Returns what the handler of a signal raised.
    ///
    /// # Errors
    /// `KeyboardInterrupt`, or another exception.
    pub fn raised(self) -> PyResult<()> {
        self.asked.into_inner().unwrap_or_else(PoisonError::into_inner).1.map_or(Ok(()), Err)
    }
}

/// Works like [`here`], but on another thread, whose waits and warm-ups end with Ctrl-C. Python receives signals only on this thread.
///
/// # Errors
/// As [`here`]; `KeyboardInterrupt`, or what a handler of a signal raises.
pub fn interruptible<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let interruption = Interruption::default();
    let (working, ended) = mpsc::channel::<()>();
    let ended = Mutex::new(ended);
    thread::scope(|scope| {
        let obeying = interruption.clone();
        let thread = scope.spawn(move || {
            // Dropped at the end, also by a panic.
            let _working = working;
            obeying.obey();
            work()
        });
        let wait = || ended.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(SIGNALS);
        let mut asked = Ok(());
        while py.detach(wait) == Err(RecvTimeoutError::Timeout) {
            if asked.is_ok() {
                asked = py.check_signals();
            }
            if asked.is_err() {
                interruption.interrupt();
            }
        }
        let done = here(py, || thread.join().unwrap_or_else(|panic| resume_unwind(panic)))?;
        asked.map(|()| done)
    })
}
