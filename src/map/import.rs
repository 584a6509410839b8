//! New maps from other formats. In: an OpenDRIVE (`.xodr`), OpenStreetMap (`.osm`) or SUMO (`.net.xml`) file. Out: a
//! folder in `maps/` that is known to load. Conversion is SUMO's own netconvert, run as a program.

use super::{MapError, RoadMap, catalog};
use crate::private;
use std::{
    path::{Path, PathBuf},
    process::Command,
};

/// Brings `file` into `maps/<name>/` and loads it once.
///
/// # Errors
/// If the name is no plain word, the map exists, the format is none of the three, netconvert is absent or fails, or the
/// network has no closed route; then nothing is left behind.
pub fn import(file: &Path, name: &str) -> Result<RoadMap, MapError> {
    let root = catalog::project_root();
    let home = std::env::var_os("SUMO_HOME").map(PathBuf::from).filter(|home| home.join("bin/netconvert").exists());
    let home = home.unwrap_or_else(|| root.join(".sumo/sumo"));
    import_into(&root.join("maps"), &home.join("bin/netconvert"), file, name)
}

/// [`import`] with the two places named: the folder of maps, and the converter.
pub(super) fn import_into(maps: &Path, netconvert: &Path, file: &Path, name: &str) -> Result<RoadMap, MapError> {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if name.is_empty() || !name.chars().all(plain) {
        let allowed = "letters a to z, digits, - and _".to_owned();
        return Err(MapError::Parameter { what: "the map's name", value: format!("\"{name}\""), allowed });
    }
    let folder = maps.join(name);
    if folder.exists() {
        return Err(MapError::Exists { folder });
    }
    if !file.is_file() {
        return Err(MapError::Missing { file: file.into() });
    }
    // Made beside its place and moved there when it is whole: an interrupted import is no map.
    let unfinished = maps.join(format!(".{name}.unfinished"));
    let failed = |source| MapError::Io { file: unfinished.clone(), source };
    let _ = std::fs::remove_dir_all(&unfinished);
    private::folder(&unfinished).map_err(failed)?;
    let made = fill(&unfinished, netconvert, file, name)
        .and_then(|()| std::fs::rename(&unfinished, &folder).map_err(failed))
        .and_then(|()| RoadMap::load(&folder.to_string_lossy()));
    if made.is_err() {
        let _ = std::fs::remove_dir_all(&unfinished);
    }
    made
}

fn fill(folder: &Path, netconvert: &Path, file: &Path, name: &str) -> Result<(), MapError> {
    let net = folder.join("net.xml");
    let source_name = file.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    if source_name.ends_with(".xodr") {
        // Curves are sampled each metre; the format's own lines through junctions are kept.
        let options = ["--opendrive.curve-resolution", "1", "--opendrive.internal-shapes", "true"];
        convert(netconvert, "--opendrive-files", file, &net, &options)?;
    } else if source_name.ends_with(".osm") || source_name.ends_with(".osm.xml") {
        let options = ["--keep-edges.by-vclass", "passenger", "--remove-edges.isolated", "--junctions.join"];
        convert(netconvert, "--osm-files", file, &net, &options)?;
    } else if source_name.ends_with("net.xml") {
        let copied = std::fs::read(file).and_then(|bytes| private::replace(&net, &bytes));
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

fn convert(program: &Path, flag: &str, file: &Path, net: &Path, options: &[&str]) -> Result<(), MapError> {
    if !program.is_file() {
        return Err(MapError::NetconvertAbsent { program: program.into() });
    }
    let mut command = Command::new(program);
    command.arg(flag).arg(file).arg("--output-file").arg(net).args(options);
    command.args(["--precision", "6", "--xml-validation", "never", "--no-warnings", "true"]);
    if let Some(home) = program.parent().and_then(Path::parent) {
        let projections = home.join("data/proj");
        command.env("SUMO_HOME", home).env("PROJ_DATA", &projections).env("PROJ_LIB", &projections);
    }
    let done = command.output().map_err(|source| MapError::Io { file: program.into(), source })?;
    if done.status.success() && net.is_file() {
        return Ok(());
    }
    let words = String::from_utf8_lossy(&done.stderr);
    let message: Vec<&str> = words.lines().filter(|line| !line.starts_with("Quitting")).take(5).collect();
    Err(MapError::Netconvert { file: file.into(), message: message.join("\n  ") })
}
