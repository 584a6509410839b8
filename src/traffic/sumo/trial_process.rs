//! Child process for work that may crash or use too much memory. In: a command. Out: its exit status and messages, or an interruption. The
//! process is limited in memory and time, and ends with this program, however that ends.

use crate::{
    native_code,
    traffic::{TrafficError, is_interrupted},
};
use std::{
    io::{self, Read},
    process::{Child, Command, ExitStatus, Stdio},
    sync::OnceLock,
    thread::{self, sleep},
    time::{Duration, Instant},
};

/// Time limit of a trial: the largest network that codrive's reader accepts (a town) takes SUMO some seconds.
pub(super) const TIMEOUT: Duration = Duration::from_secs(120);
/// Duration of a wait after which the user gets a notice.
const SILENT: Duration = Duration::from_secs(2);
/// Limit of the process's address space, bytes: SUMO's libraries take 1 GiB of it, a town's network less.
const MOST_MEMORY: u64 = 4 << 30;
/// Maximum number of bytes kept of the process's standard error.
const MOST_WORDS: u64 = 4096;

static NOTICE: OnceLock<fn(&str)> = OnceLock::new();

/// Sets the function for notices of waits longer than 2 s, one line each. Without it there are no notices.
pub fn tell_waits_by(notice: fn(&str)) {
    let _ = NOTICE.set(notice);
}

/// End of a trial.
#[derive(Debug)]
pub(super) enum Ended {
    /// The process ended by itself: exit status and standard error.
    Itself(ExitStatus, String),
    /// The trial took too long.
    TimedOut,
}

/// Runs a command to its end. `what` names the trial in a notice of a long wait.
///
/// # Errors
/// [`TrafficError::Interrupted`], or an error of the operating system.
pub(super) fn run(command: &mut Command, what: &str) -> Result<Ended, TrafficError> {
    run_within(TIMEOUT, command, what)
}

fn run_within(limit: Duration, command: &mut Command, what: &str) -> Result<Ended, TrafficError> {
    let program = command.get_program().to_os_string();
    let failed = |error: io::Error| TrafficError::Setup(format!("{}: {error}", program.display()));
    let mut child =
        confine(command).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().map_err(failed)?;
    let words = child.stderr.take().map(|mut stderr| {
        thread::spawn(move || {
            let mut words = Vec::new();
            let _ = stderr.by_ref().take(MOST_WORDS).read_to_end(&mut words);
            // The rest is read, too: a process that cannot write would block.
            let _ = io::copy(&mut stderr, &mut io::sink());
            words
        })
    });
    let ended = wait(&mut child, limit, what);
    if !matches!(ended, Ok(Some(_))) {
        // Errors are ignored, because the process may have ended meanwhile.
        let _ = child.kill();
        let _ = child.wait();
    }
    let words = words.and_then(|thread| thread.join().ok()).unwrap_or_default();
    if is_interrupted() {
        return Err(TrafficError::Interrupted);
    }
    Ok(match ended.map_err(failed)? {
        Some(status) => Ended::Itself(status, String::from_utf8_lossy(&words).trim().into()),
        None => Ended::TimedOut,
    })
}

/// Waits for the end of the process; `None` after an interruption or the time limit.
fn wait(child: &mut Child, limit: Duration, what: &str) -> io::Result<Option<ExitStatus>> {
    let begun = now();
    let mut is_told = false;
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Some(status));
        }
        let waited = begun.elapsed();
        if is_interrupted() || waited > limit {
            return Ok(None);
        }
        if waited > SILENT && !is_told {
            is_told = true;
            if let Some(notice) = NOTICE.get() {
                notice(&format!("testing {what} in SUMO, up to {} s; Ctrl-C stops the test", limit.as_secs()));
            }
        }
        sleep(Duration::from_millis(10));
    }
}

/// Limits the memory of the process that a command starts, disables its core dump, and makes it end with the thread that starts it.
fn confine(command: &mut Command) -> &mut Command {
    #[cfg(target_os = "linux")]
    {
        use nix::sys::resource::{Resource, setrlimit};
        let limit = || {
            // If the system refuses a limit, only the time limit remains.
            let _ = setrlimit(Resource::RLIMIT_AS, MOST_MEMORY, MOST_MEMORY);
            let _ = setrlimit(Resource::RLIMIT_CORE, 0, 0);
            Ok(())
        };
        // SAFETY: between fork and exec the closure makes only system calls: no allocation, no lock.
        unsafe { std::os::unix::process::CommandExt::pre_exec(command, limit) };
    }
    native_code::end_with_parent(command)
}

#[allow(
    clippy::disallowed_methods,
    reason = "a time-out for another process is a matter of wall time, not of simulation"
)]
fn now() -> Instant {
    Instant::now()
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn a_trial_has_at_most_four_gibibytes_and_leaves_no_core_dump() {
        let mut limits = Command::new("cat");
        let done = confine(limits.arg("/proc/self/limits")).output().unwrap();
        let text = String::from_utf8_lossy(&done.stdout).into_owned();
        let limit = |name: &str| {
            let line = text.lines().find(|line| line.starts_with(name)).unwrap();
            line[name.len()..].split_whitespace().next().unwrap().to_owned()
        };
        assert_eq!([limit("Max address space"), limit("Max core file size")], ["4294967296", "0"], "{text}");
    }

    #[test]
    fn a_trial_ends_with_the_thread_that_started_it() {
        // The system sends its signal at the end of the thread that started the process, as at the end of the program.
        let begun = thread::spawn(|| confine(Command::new("sleep").arg("60")).spawn().unwrap());
        let mut child = begun.join().unwrap();
        let status = (0..200).find_map(|_| {
            sleep(Duration::from_millis(10));
            child.try_wait().unwrap()
        });
        let _ = child.kill();
        let status = status.expect("it has ended within 2 s");
        assert_eq!(std::os::unix::process::ExitStatusExt::signal(&status), Some(nix::libc::SIGKILL));
    }

    #[test]
    fn a_trial_that_takes_longer_than_its_limit_is_ended() {
        let ended = run_within(Duration::from_millis(50), Command::new("sleep").arg("5"), "a network").unwrap();
        assert!(matches!(ended, Ended::TimedOut), "{ended:?}");
    }

    #[test]
    fn a_wait_for_a_trial_ends_within_a_second_of_an_interruption() {
        let interruption = crate::traffic::Interruption::default();
        let heard = interruption.clone();
        let waiting = thread::spawn(move || {
            heard.obey();
            let ended = run(Command::new("sleep").arg("60"), "a network");
            (ended, now())
        });
        sleep(Duration::from_millis(100));
        let interrupted = now();
        interruption.interrupt();
        let (ended, at) = waiting.join().unwrap();
        assert!(matches!(ended, Err(TrafficError::Interrupted)), "{ended:?}");
        assert!(at - interrupted < Duration::from_secs(1));
    }
}
