//! Importing maps from other formats. In: an OpenDRIVE (`.xodr`), OpenStreetMap (`.osm`) or SUMO (`.net.xml`) file. Out: a
//! folder in `maps/` that is known to load. Conversion is SUMO's own netconvert, run as a program.

use super::{
    MapError, RoadMap, catalog,
    limits::{MOST_BYTES, MOST_IMPORT_BYTES},
};
use crate::{
    file::{open_regular, read_bounded, size_text},
    private,
};
use std::{
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    sync::atomic::{AtomicBool, Ordering},
    time::Duration,
};

/// The most that netconvert may write into one file, bytes: what is over the limit of a network cannot be used.
const FILE_BYTES: u64 = 2 * MOST_BYTES;

/// What netconvert may take, and whether it is still wanted.
#[derive(Clone, Copy, Debug)]
pub struct ImportBounds<'a> {
    /// How long it may run, seconds.
    pub seconds: u64,
    /// How much memory it may have, MiB.
    pub memory_mib: u64,
    /// Set once someone wants the import to end.
    pub stop: &'a AtomicBool,
}

/// How often it is asked whether it is done.
const WAITS_PER_S: u64 = 50;
/// How long netconvert may run if nothing else is said, seconds: a town takes 20 s.
pub const SECONDS: u64 = 300;
/// How much memory it may have if nothing else is said, MiB: a town takes 1 GB.
pub const MEMORY_MIB: u64 = 4096;

/// Brings `file` into `<name>/` among the person's own maps and loads it once.
///
/// # Errors
/// If the name is no plain word, the map exists, the file is none or too large, the format is none of the three, netconvert is
/// absent, fails or goes beyond `bounds`, or the network has no closed route; then nothing is left behind.
pub fn import(file: &Path, name: &str, bounds: &ImportBounds) -> Result<RoadMap, MapError> {
    let maps = catalog::own_folder().ok_or(MapError::NoHome)?;
    import_into(&maps, &netconvert(), file, name, bounds)
}

/// SUMO's converter: that of `SUMO_HOME`, else of the SUMO that the program was built with, else of `.sumo/sumo` in or above the
/// current folder.
fn netconvert() -> PathBuf {
    let of = |home: PathBuf| home.join("bin").join(format!("netconvert{}", std::env::consts::EXE_SUFFIX));
    let mut homes: Vec<PathBuf> = std::env::var_os("SUMO_HOME").map(PathBuf::from).into_iter().collect();
    homes.push(env!("CODRIVE_SUMO_HOME_AT_BUILD").into());
    let here = std::env::current_dir().unwrap_or_default();
    homes.extend(here.ancestors().map(|above| above.join(".sumo/sumo")));
    let first = of(homes[0].clone());
    homes.into_iter().map(of).find(|program| program.exists()).unwrap_or(first)
}

/// [`import`] with the two places named: the folder of maps, and the converter.
pub(super) fn import_into(
    maps: &Path,
    netconvert: &Path,
    file: &Path,
    name: &str,
    bounds: &ImportBounds,
) -> Result<RoadMap, MapError> {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if name.is_empty() || !name.chars().all(plain) {
        let allowed = "letters a to z, digits, - and _".to_owned();
        return Err(MapError::Parameter { what: "the map's name", value: format!("\"{name}\""), allowed });
    }
    let folder = maps.join(name);
    if folder.exists() {
        return Err(MapError::Exists { folder });
    }
    check_file(file)?;
    // Made beside its place and moved there when it is whole: an interrupted import is no map.
    let unfinished = maps.join(format!(".{name}.unfinished"));
    let failed = |source| MapError::Io { file: unfinished.clone(), source };
    let _ = std::fs::remove_dir_all(&unfinished);
    private::folder(&unfinished).map_err(failed)?;
    let made = fill(&unfinished, netconvert, file, name, bounds)
        .and_then(|()| std::fs::rename(&unfinished, &folder).map_err(failed))
        .and_then(|()| RoadMap::load(&folder.to_string_lossy()));
    if made.is_err() {
        let _ = std::fs::remove_dir_all(&unfinished);
    }
    made
}

/// A regular file, and not too large.
fn check_file(file: &Path) -> Result<(), MapError> {
    let failed = |source| MapError::Io { file: file.into(), source };
    let size = match open_regular(file) {
        Ok(open) => open.metadata().map_err(failed)?.len(),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Err(MapError::Missing { file: file.into() });
        }
        Err(error) => return Err(failed(error)),
    };
    if size <= MOST_IMPORT_BYTES {
        return Ok(());
    }
    let (what, allowed) = ("the file".into(), format!("at most {}", size_text(MOST_IMPORT_BYTES)));
    Err(MapError::Limit { file: file.into(), what, value: size_text(size), allowed })
}

fn fill(folder: &Path, netconvert: &Path, file: &Path, name: &str, bounds: &ImportBounds) -> Result<(), MapError> {
    let net = folder.join("net.xml");
    let source_name = file.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    if source_name.ends_with(".xodr") {
        // Curves are sampled each metre; the format's own lines through junctions are kept.
        let options = ["--opendrive.curve-resolution", "1", "--opendrive.internal-shapes", "true"];
        convert(netconvert, "--opendrive-files", file, &net, &options, bounds)?;
    } else if source_name.ends_with(".osm") || source_name.ends_with(".osm.xml") {
        // Heights are those that the file states; one without any stays flat.
        let options = [
            "--keep-edges.by-vclass",
            "passenger",
            "--remove-edges.isolated",
            "--junctions.join",
            "--osm.elevation",
            "true",
        ];
        convert(netconvert, "--osm-files", file, &net, &options, bounds)?;
    } else if source_name.ends_with("net.xml") {
        let copied = read_bounded(file, MOST_BYTES).and_then(|bytes| private::replace(&net, &bytes));
        copied.map_err(|source| MapError::Io { file: file.into(), source })?;
    } else {
        let allowed = "a file .xodr (OpenDRIVE), .osm (OpenStreetMap) or .net.xml (SUMO)".to_owned();
        return Err(MapError::Parameter { what: "the file to import", value: file.display().to_string(), allowed });
    }
    let length_m = RoadMap::load(&net.to_string_lossy()).map_err(|error| named(error, &net, file))?.route.length_m();
    let text = |text: String| toml::Value::String(text).to_string();
    let map_file = format!(
        "title = {}\ndescription = {}\n# The closed route is the longest loop found; to drive another, name its edges:\n\
         # route = [\"edge\", \"edge\"]\n",
        text(name.to_owned()),
        text(format!("A closed route of {length_m:.0} m, imported from {source_name}."))
    );
    private::replace(&folder.join("map.toml"), map_file.as_bytes())
        .map_err(|source| MapError::Io { file: folder.into(), source })
}

/// The same error about the file that a person knows, not the one that was made from it.
fn named(error: MapError, made: &Path, known: &Path) -> MapError {
    match error {
        MapError::NoRoute { file, detail } if file == made => MapError::NoRoute { file: known.into(), detail },
        other => other,
    }
}

fn convert(
    program: &Path,
    flag: &str,
    file: &Path,
    net: &Path,
    options: &[&str],
    bounds: &ImportBounds,
) -> Result<(), MapError> {
    if !program.is_file() {
        return Err(MapError::NetconvertAbsent { program: program.into() });
    }
    let failed = |message: String| {
        let ImportBounds { seconds, memory_mib, .. } = bounds;
        MapError::Netconvert { file: file.into(), seconds: *seconds, memory_mib: *memory_mib, message }
    };
    let io = |source| MapError::Io { file: program.into(), source };
    // Its words go into a file: a pipe that nobody empties would hold it.
    let log = net.with_extension("log");
    let mut command = bounded_command(program, bounds);
    command.arg(flag).arg(file).arg("--output-file").arg(net).args(options);
    command.args(["--precision", "6", "--xml-validation", "never", "--no-warnings", "true"]);
    if let Some(home) = program.parent().and_then(Path::parent) {
        let projections = home.join("data/proj");
        command.env("SUMO_HOME", home).env("PROJ_DATA", &projections).env("PROJ_LIB", &projections);
    }
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(private::file(&log).map_err(io)?);
    let mut child = command.spawn().map_err(io)?;
    // Counted, not read from a clock: only the order of magnitude matters.
    let mut waits = 0;
    let status = loop {
        if let Some(status) = child.try_wait().map_err(io)? {
            break status;
        }
        waits += 1;
        let late = waits > bounds.seconds * WAITS_PER_S;
        if late || bounds.stop.load(Ordering::Relaxed) {
            end_with_children(&mut child);
            return Err(if late {
                failed("it was not done in time and was ended".into())
            } else {
                MapError::Interrupted { file: file.into() }
            });
        }
        std::thread::sleep(Duration::from_millis(1000 / WAITS_PER_S));
    };
    let words = std::fs::read(&log).map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).unwrap_or_default();
    std::fs::remove_file(&log).map_err(io)?;
    if status.success() && net.is_file() {
        return Ok(());
    }
    let message: Vec<&str> = words.lines().filter(|line| !line.starts_with("Quitting")).take(5).collect();
    Err(failed(if message.is_empty() { format!("it ended with {status}") } else { message.join("\n  ") }))
}

/// The program with bounds that the system keeps, also when this program is gone: memory, time of the processor, and size of
/// its files. The shell sets them for itself and becomes the program.
#[cfg(unix)]
fn bounded_command(program: &Path, bounds: &ImportBounds) -> Command {
    let file_blocks = FILE_BYTES / 512;
    let script = format!(
        "ulimit -v {} && ulimit -t {} && ulimit -f {file_blocks} && exec \"$0\" \"$@\"",
        bounds.memory_mib * 1024,
        bounds.seconds
    );
    let mut command = Command::new("/bin/sh");
    command.arg("-c").arg(script).arg(program);
    // A group of its own, so that all that it starts is ended with it.
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
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
