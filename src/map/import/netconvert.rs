//! SUMO's converter, run as a program within limits of time and memory. In: a file of another format and options. Out: a `net.xml` and
//! netconvert's messages, or its own error messages.

use super::driving_side::DrivingSide;
use crate::{
    file::read_bounded,
    map::{MapError, limits::MOST_BYTES},
    native_code, private,
};
use std::{
    ffi::OsStr,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};

/// Largest file that netconvert may write, bytes: a network beyond its size limit cannot be used anyway.
const FILE_BYTES: u64 = 2 * MOST_BYTES;
/// Number of checks per second whether netconvert has ended.
const WAITS_PER_S: u64 = 50;
/// Message of netconvert for a file without a road.
const NO_NODES: &str = "No nodes loaded";
/// Largest number of lines of an error that is shown.
const LINES_TOLD: usize = 5;

/// Limits of netconvert, the user's request to stop, and the side of traffic.
#[derive(Clone, Copy, Debug)]
pub struct ImportOptions<'a> {
    /// Time limit, all attempts together, seconds.
    pub seconds: u64,
    /// Memory limit of one run, MiB.
    pub memory_mib: u64,
    /// Set to true when the user wants the import to end.
    pub stop: &'a AtomicBool,
    /// Side of traffic; `None` takes it from the file.
    pub side: Option<DrivingSide>,
}

/// Returns the path of SUMO's converter: in the first of SUMO's folders that contains it.
pub(super) fn program() -> PathBuf {
    let of = |home: PathBuf| home.join("bin").join(format!("netconvert{}", std::env::consts::EXE_SUFFIX));
    let homes = native_code::sumo_homes();
    let first = of(homes.first().cloned().unwrap_or_default());
    homes.into_iter().map(of).find(|program| program.exists()).unwrap_or(first)
}

/// One run of the converter.
pub(super) struct Conversion<'a> {
    /// Path of the converter.
    pub program: &'a Path,
    /// Option before the file, which names its format.
    pub format: &'a str,
    /// File that is converted.
    pub file: &'a Path,
    /// File of the user, which errors name.
    pub known: &'a Path,
    /// File that is written.
    pub net: &'a Path,
    /// Further options of netconvert.
    pub options: Vec<&'a str>,
    /// Number of runs that share the time limit of `bounds`.
    pub shares: u64,
}

impl Conversion<'_> {
    /// Runs netconvert and returns its messages.
    ///
    /// # Errors
    /// netconvert is absent, fails, exceeds the bounds, or the user stopped it.
    pub fn run(&self, bounds: &ImportOptions) -> Result<String, MapError> {
        if !self.program.is_file() {
            return Err(MapError::NetconvertAbsent { program: self.program.into() });
        }
        let io = |source| MapError::Io { file: self.program.into(), source };
        // Messages go into a file: a pipe that is not read would block the program.
        let log = self.net.with_extension("log");
        let mut command = bounded_command(self.program, bounds);
        command.arg(self.format).arg(self.file).arg("--output-file").arg(self.net).args(&self.options);
        command.args(["--precision", "6", "--xml-validation", "never", "--output.street-names"]);
        with_projections(&mut command, self.program);
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(private::file(&log).map_err(io)?);
        let status = wait(command.spawn().map_err(io)?, self.program, self.known, bounds, self.shares);
        let words = read_bounded(&log, FILE_BYTES).map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
        std::fs::remove_file(&log).map_err(io)?;
        let words = words.unwrap_or_default();
        let status = status?;
        if status.success() && self.net.is_file() {
            return Ok(words);
        }
        let mut errors = errors_of(&words);
        // netconvert writes this message for a file without a road, and after other errors.
        if errors.len() == 1 && errors[0].starts_with(NO_NODES) {
            let detail = format!("the file has no road (netconvert: {NO_NODES})");
            return Err(MapError::NoPath { file: self.known.into(), detail });
        }
        errors.retain(|error| !error.starts_with(NO_NODES));
        // Messages of the system when memory runs out, of netconvert, and of its libraries.
        if let Some(line) = out_of_memory(&words) {
            return Err(beyond(self.known, bounds, format!("netconvert needs more memory ({line})")));
        }
        let message = match errors.is_empty() {
            true => {
                format!("netconvert ended with {status}; its last line: {}", words.lines().last().unwrap_or("none"))
            }
            false => errors.join("\n  "),
        };
        Err(MapError::Netconvert { file: self.known.into(), message })
    }
}

fn beyond(known: &Path, bounds: &ImportOptions, what: String) -> MapError {
    let ImportOptions { seconds, memory_mib, .. } = *bounds;
    MapError::NetconvertLimit { file: known.into(), what, seconds, memory_mib }
}

/// Waits for a program to end, at most its share of the time limit. Errors name the user's file `known`.
fn wait(
    mut child: Child,
    program: &Path,
    known: &Path,
    bounds: &ImportOptions,
    shares: u64,
) -> Result<std::process::ExitStatus, MapError> {
    // Waits are counted, not timed by a clock: only the order of magnitude matters.
    let most_waits = (bounds.seconds * WAITS_PER_S / shares.max(1)).max(1);
    let mut waits = 0;
    loop {
        let ended = child.try_wait().map_err(|source| MapError::Io { file: program.into(), source })?;
        if let Some(status) = ended {
            return Ok(status);
        }
        waits += 1;
        let late = waits > most_waits;
        if late || bounds.stop.load(Ordering::Relaxed) {
            end_with_children(&mut child);
            let name = program.file_stem().unwrap_or_default().to_string_lossy();
            return Err(match late {
                true => beyond(known, bounds, format!("{name} was stopped at the time limit")),
                false => MapError::Interrupted { file: known.into() },
            });
        }
        std::thread::sleep(Duration::from_millis(1000 / WAITS_PER_S));
    }
}

/// Converts the polygons and points of OpenStreetMap files, which are read as one, into the frame of a network. The program lies beside
/// netconvert.
///
/// # Errors
/// The program is absent, fails, exceeds the bounds, or the user stopped it.
pub(super) fn polygons(
    netconvert: &Path,
    files: &[&Path],
    net: &Path,
    written: &Path,
    bounds: &ImportOptions,
) -> Result<(), MapError> {
    let program = netconvert.with_file_name(format!("polyconvert{}", std::env::consts::EXE_SUFFIX));
    let file = files.first().copied().unwrap_or(net);
    let failed = |message: String| MapError::Netconvert { file: file.into(), message };
    if !program.is_file() {
        return Err(failed(format!("{} is absent", program.display())));
    }
    let names: Vec<&OsStr> = files.iter().map(|file| file.as_os_str()).collect();
    let mut command = bounded_command(&program, bounds);
    command
        .arg("--net-file")
        .arg(net)
        .arg("--osm-files")
        .arg(names.join(OsStr::new(",")))
        .arg("--output-file")
        .arg(written);
    command.args(["--osm.keep-full-type", "--all-attributes", "--xml-validation", "never"]);
    with_projections(&mut command, &program);
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let child = command.spawn().map_err(|source| MapError::Io { file: program.clone(), source })?;
    let status = wait(child, &program, file, bounds, 1)?;
    if status.success() && written.is_file() { Ok(()) } else { Err(failed(format!("polyconvert ended with {status}"))) }
}

/// Sets SUMO's own projection database for one of its programs: the system's may have another version.
fn with_projections(command: &mut Command, program: &Path) {
    if let Some(home) = program.parent().and_then(Path::parent) {
        let projections = home.join("data/proj");
        command.env("SUMO_HOME", home).env("PROJ_DATA", &projections).env("PROJ_LIB", &projections);
        // A projection in the file may name grids, which the library would download.
        command.env("PROJ_NETWORK", "OFF");
    }
}

/// Returns the first line that reports a lack of memory.
fn out_of_memory(words: &str) -> Option<&str> {
    let says_so = |line: &&str| {
        ["std::bad_alloc", "memory exhausted", "Cannot allocate memory"].iter().any(|word| line.contains(word))
    };
    words.lines().find(says_so).map(str::trim)
}

/// Returns the errors among netconvert's messages, with cause and place. Its line with the file's name is left out: the message begins
/// with that name already.
fn errors_of(words: &str) -> Vec<String> {
    let mut errors: Vec<String> = Vec::new();
    let mut in_error = false;
    for line in words.lines() {
        // Lines that continue an error are indented.
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

/// Returns the command with limits that the system enforces, even after this program has ended: memory, processor time and file size. A
/// shell sets the limits for itself and then executes the program.
#[cfg(unix)]
fn bounded_command(program: &Path, bounds: &ImportOptions) -> Command {
    let file_blocks = FILE_BYTES / 512;
    let script = format!(
        "ulimit -c 0; ulimit -v {} && ulimit -t {} && ulimit -f {file_blocks} && exec \"$0\" \"$@\"",
        bounds.memory_mib * 1024,
        bounds.seconds
    );
    let mut command = Command::new("/bin/sh");
    command.arg("-c").arg(script).arg(program);
    // A process group of its own, so that its child processes end with it.
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    native_code::end_with_parent(&mut command);
    command
}

#[cfg(not(unix))]
fn bounded_command(program: &Path, _bounds: &ImportOptions) -> Command {
    Command::new(program)
}

fn end_with_children(child: &mut Child) {
    #[cfg(target_os = "linux")]
    if let Ok(group) = i32::try_from(child.id()) {
        let _ = nix::sys::signal::killpg(nix::unistd::Pid::from_raw(group), nix::sys::signal::Signal::SIGKILL);
    }
    // The process may have ended already.
    let _ = child.kill();
    let _ = child.wait();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_keep_cause_and_place_and_leave_out_warnings_and_the_file() {
        // Output of netconvert 1.28 for a truncated file.
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
    fn the_line_that_reports_a_lack_of_memory_is_found() {
        let words = "Loading...\nError: std::bad_alloc\nQuitting (on error).\n";
        assert_eq!(
            (out_of_memory(words), out_of_memory("Quitting (on error).")),
            (Some("Error: std::bad_alloc"), None)
        );
    }
}
