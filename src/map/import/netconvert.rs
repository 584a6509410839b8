//! SUMO's converter, run as a program within limits of time and memory. In: a file of another format and options. Out: a `net.xml`
//! and what netconvert warned of, or its own words on why there is none.

use crate::{
    file::read_bounded,
    map::{MapError, limits::MOST_BYTES},
    native_code, private,
};
use std::{
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};

/// The most that netconvert may write into one file, bytes: what is over the limit of a network cannot be used.
const FILE_BYTES: u64 = 2 * MOST_BYTES;
/// How often it is asked whether it is done.
const WAITS_PER_S: u64 = 50;
/// What it says of a file without a road.
const NO_NODES: &str = "No nodes loaded";
/// How many lines of an error are told.
const LINES_TOLD: usize = 5;

/// What netconvert may take, and whether it is still wanted.
#[derive(Clone, Copy, Debug)]
pub struct ImportBounds<'a> {
    /// How long it may run, all tries together, seconds.
    pub seconds: u64,
    /// How much memory it may have, MiB.
    pub memory_mib: u64,
    /// Set once someone wants the import to end.
    pub stop: &'a AtomicBool,
}

/// Path of SUMO's converter: in the first of SUMO's homes that has it.
pub(super) fn program() -> PathBuf {
    let of = |home: PathBuf| home.join("bin").join(format!("netconvert{}", std::env::consts::EXE_SUFFIX));
    let homes = native_code::sumo_homes();
    let first = of(homes.first().cloned().unwrap_or_default());
    homes.into_iter().map(of).find(|program| program.exists()).unwrap_or(first)
}

/// One run of the converter.
pub(super) struct Conversion<'a> {
    /// The converter.
    pub program: &'a Path,
    /// The option before the file, which says its format.
    pub format: &'a str,
    /// What is converted.
    pub file: &'a Path,
    /// The file of the person, which errors name.
    pub known: &'a Path,
    /// What is written.
    pub net: &'a Path,
    /// Further options.
    pub options: &'a [&'a str],
    /// How many runs share the time that `bounds` allows.
    pub shares: u64,
}

impl Conversion<'_> {
    /// Runs it; what netconvert said comes back.
    ///
    /// # Errors
    /// It is absent, fails, goes beyond the bounds or is no longer wanted.
    pub fn run(&self, bounds: &ImportBounds) -> Result<String, MapError> {
        if !self.program.is_file() {
            return Err(MapError::NetconvertAbsent { program: self.program.into() });
        }
        let io = |source| MapError::Io { file: self.program.into(), source };
        // Its words go into a file: a pipe that nobody empties would hold it.
        let log = self.net.with_extension("log");
        let mut command = bounded_command(self.program, bounds);
        command.arg(self.format).arg(self.file).arg("--output-file").arg(self.net).args(self.options);
        command.args(["--precision", "6", "--xml-validation", "never"]);
        if let Some(home) = self.program.parent().and_then(Path::parent) {
            // SUMO's own table of projections: that of the system may have another version.
            let projections = home.join("data/proj");
            command.env("SUMO_HOME", home).env("PROJ_DATA", &projections).env("PROJ_LIB", &projections);
            // A projection of the file's may name grids, which the library would fetch.
            command.env("PROJ_NETWORK", "OFF");
        }
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(private::file(&log).map_err(io)?);
        let status = self.wait(command.spawn().map_err(io)?, bounds);
        let words = read_bounded(&log, FILE_BYTES).map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
        std::fs::remove_file(&log).map_err(io)?;
        let words = words.unwrap_or_default();
        let status = status?;
        if status.success() && self.net.is_file() {
            return Ok(words);
        }
        let mut errors = errors_of(&words);
        // It says so of a file without a road, and after other errors.
        if errors.len() == 1 && errors[0].starts_with(NO_NODES) {
            let detail = format!("the file has no road (netconvert: {NO_NODES})");
            return Err(MapError::NoPath { file: self.known.into(), detail });
        }
        errors.retain(|error| !error.starts_with(NO_NODES));
        // The system's words where it gives no more memory, netconvert's, and those of what it calls.
        if let Some(line) = out_of_memory(&words) {
            return Err(self.beyond(bounds, format!("it needs more memory ({line})")));
        }
        let message = match errors.is_empty() {
            true => format!("it ended with {status}, after the words: {}", words.lines().last().unwrap_or("none")),
            false => errors.join("\n  "),
        };
        Err(MapError::Netconvert { file: self.known.into(), message })
    }

    fn beyond(&self, bounds: &ImportBounds, what: String) -> MapError {
        let ImportBounds { seconds, memory_mib, .. } = *bounds;
        MapError::NetconvertLimit { file: self.known.into(), what, seconds, memory_mib }
    }

    fn wait(&self, mut child: Child, bounds: &ImportBounds) -> Result<std::process::ExitStatus, MapError> {
        // Counted, not read from a clock: only the order of magnitude matters.
        let most_waits = (bounds.seconds * WAITS_PER_S / self.shares.max(1)).max(1);
        let mut waits = 0;
        loop {
            if let Some(status) =
                child.try_wait().map_err(|source| MapError::Io { file: self.program.into(), source })?
            {
                return Ok(status);
            }
            waits += 1;
            let late = waits > most_waits;
            if late || bounds.stop.load(Ordering::Relaxed) {
                end_with_children(&mut child);
                return Err(match late {
                    true => self.beyond(bounds, "it was not done in time and was ended".into()),
                    false => MapError::Interrupted { file: self.known.into() },
                });
            }
            std::thread::sleep(Duration::from_millis(1000 / WAITS_PER_S));
        }
    }
}

/// The line with which it says that there is no more memory, if it does.
fn out_of_memory(words: &str) -> Option<&str> {
    let says_so = |line: &&str| {
        ["std::bad_alloc", "memory exhausted", "Cannot allocate memory"].iter().any(|word| line.contains(word))
    };
    words.lines().find(says_so).map(str::trim)
}

/// The errors among netconvert's words, with what and where as it says them. It names the file in a line of its own, which is
/// left out: it is the file that the message begins with.
fn errors_of(words: &str) -> Vec<String> {
    let mut errors: Vec<String> = Vec::new();
    let mut in_error = false;
    for line in words.lines() {
        // What follows an error is indented.
        if !line.starts_with(' ') {
            in_error = line.starts_with("Error:");
        }
        let known = ["In file", "Quitting"].iter().any(|start| line.trim_start().starts_with(start));
        let line = line.trim_start_matches("Error:").trim();
        if in_error && !known && !line.is_empty() && !errors.iter().any(|error| error == line) {
            errors.push(line.to_owned());
        }
    }
    let more = errors.len().saturating_sub(LINES_TOLD);
    errors.truncate(LINES_TOLD);
    if more > 0 {
        errors.push(format!("and {more} more"));
    }
    errors
}

/// The program with bounds that the system keeps, also when this program is gone: memory, time of the processor, and size of
/// its files. The shell sets them for itself and becomes the program.
#[cfg(unix)]
fn bounded_command(program: &Path, bounds: &ImportBounds) -> Command {
    let file_blocks = FILE_BYTES / 512;
    let script = format!(
        "ulimit -c 0; ulimit -v {} && ulimit -t {} && ulimit -f {file_blocks} && exec \"$0\" \"$@\"",
        bounds.memory_mib * 1024,
        bounds.seconds
    );
    let mut command = Command::new("/bin/sh");
    command.arg("-c").arg(script).arg(program);
    // A group of its own, so that all that it starts is ended with it.
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    native_code::end_with_parent(&mut command);
    command
}

#[cfg(not(unix))]
fn bounded_command(program: &Path, _bounds: &ImportBounds) -> Command {
    Command::new(program)
}

fn end_with_children(child: &mut Child) {
    #[cfg(target_os = "linux")]
    if let Ok(group) = i32::try_from(child.id()) {
        let _ = nix::sys::signal::killpg(nix::unistd::Pid::from_raw(group), nix::sys::signal::Signal::SIGKILL);
    }
    // It may be gone already.
    let _ = child.kill();
    let _ = child.wait();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_keep_what_and_where_and_leave_out_warnings_and_the_file() {
        // As netconvert 1.28 says it of a file that was cut off.
        let words = "Warning: Ignoring geoidgrids and vgridshift in projection\nError: input ended before all started tags \
                     were ended; last tag started is 'link'\n In file '/tmp/x/cut.xodr'\n At line/column 117/11.\n\nError: \
                     No nodes loaded.\nQuitting (on error).\n";
        assert_eq!(
            errors_of(words),
            [
                "input ended before all started tags were ended; last tag started is 'link'",
                "At line/column 117/11.",
                "No nodes loaded."
            ]
        );
        let many: String = (0..9).map(|k| format!("Error: edge {k}\n")).collect();
        assert_eq!(errors_of(&many).last().map(String::as_str), Some("and 4 more"));
        assert!(errors_of("Warning: Error: of a street's name\n").is_empty());
    }

    #[test]
    fn of_a_want_of_memory_the_line_is_told_that_says_so() {
        let words = "Loading...\nError: std::bad_alloc\nQuitting (on error).\n";
        assert_eq!(
            (out_of_memory(words), out_of_memory("Quitting (on error).")),
            (Some("Error: std::bad_alloc"), None)
        );
    }
}
