//! Import of maps from other formats. In: an OpenDRIVE (`.xodr`), OpenStreetMap (`.osm`) or SUMO (`.net.xml`) file. Out: a folder in
//! `maps/` with the network, its default path and a report, [`Imported`]. SUMO's own netconvert does the conversion, as a program within
//! limits (`netconvert`), with coarser options if fine ones fail (`netconvert_attempts`). `surroundings` adds what stands beside the
//! roads.

mod driving_side;
#[cfg(test)]
mod format_tests;
mod left_hand_places;
mod netconvert;
mod netconvert_attempts;
mod open_drive;
mod open_street_map;
mod osm_elements;
mod osm_rings;
mod plain_ids;
mod repair;
mod report;
mod road_lanes;
mod sign_nodes;
mod sign_places;
mod sign_tags;
mod source_copy;
mod source_format;
mod surroundings;
#[cfg(test)]
mod tests;
mod warnings;

pub use driving_side::DrivingSide;
pub use netconvert::ImportOptions;
pub use report::ImportReport;
pub use source_format::SourceFormat;
pub use warnings::WarningKind;

use super::{MapError, RoadMap, catalog, limits::MOST_IMPORT_BYTES};
use crate::{
    file::{open_regular, size_text},
    private,
    sumo_xml::document,
};
use std::path::{Path, PathBuf};

/// Default time limit of netconvert, seconds: a town takes 20 s.
pub const SECONDS: u64 = 300;
/// Default memory limit of netconvert, MiB: a town takes 1 GB.
pub const MEMORY_MIB: u64 = 4096;
/// File name of the report in a map's folder.
pub const REPORT_FILE: &str = "import.txt";

/// Result of an import.
#[derive(Debug)]
pub struct Imported {
    /// Folder of the new map.
    pub folder: PathBuf,
    /// Report on the conversion.
    pub report: ImportReport,
    /// Map as a drive loads it, or the reason why it cannot be driven yet.
    pub map: Result<RoadMap, MapError>,
}

/// Imports `file` into the folder `<name>/` of the user's own maps, and loads the map once.
///
/// # Errors
/// The name has other characters than letters, digits, - and _; the map exists; the file is missing, empty or too large; the format is
/// unknown; netconvert is absent, fails or exceeds `options`; or the network has no road for cars. Nothing is left behind then.
pub fn import(file: &Path, name: &str, options: &ImportOptions) -> Result<Imported, MapError> {
    import_within(&catalog::own_folder().ok_or(MapError::NoHome)?, file, name, options)
}

/// Imports as [`import`] does, into the folder `<name>/` within `maps`.
///
/// # Errors
/// As [`import`].
pub fn import_within(maps: &Path, file: &Path, name: &str, options: &ImportOptions) -> Result<Imported, MapError> {
    import_into(maps, &netconvert::program(), file, name, options)
}

/// Imports as [`import`] does, with the folder of maps and the converter given.
pub(super) fn import_into(
    maps: &Path,
    netconvert: &Path,
    file: &Path,
    name: &str,
    options: &ImportOptions,
) -> Result<Imported, MapError> {
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
    let format = SourceFormat::of(file).ok_or_else(|| {
        let is_configuration = file.extension().is_some_and(|end| end.eq_ignore_ascii_case("sumocfg"));
        let remedy = if is_configuration {
            "\n  remedy: drive it with --scenario, or import the network that stands in its <net-file>"
        } else {
            ""
        };
        let formats =
            "a file .xodr (OpenDRIVE), .osm (OpenStreetMap) or .net.xml (SUMO), which may be compressed (.gz)";
        let allowed = format!("{formats}{remedy}");
        MapError::Parameter { what: "the file to import", value: file.display().to_string(), allowed }
    })?;
    check_references(file)?;
    // Made beside its final place and moved there when complete: an interrupted import is never a map.
    let unfinished = maps.join(format!(".{name}.unfinished"));
    let failed = |source| MapError::Io { file: folder.clone(), source };
    let _ = std::fs::remove_dir_all(&unfinished);
    private::folder(&unfinished).map_err(failed)?;
    let made = fill(&unfinished, netconvert, (file, format), name, options)
        .and_then(|report| std::fs::rename(&unfinished, &folder).map_err(failed).map(|()| report));
    if made.is_err() {
        let _ = std::fs::remove_dir_all(&unfinished);
    }
    let report = made?;
    let map = RoadMap::load(&folder.to_string_lossy());
    Ok(Imported { folder, report, map })
}

/// Checks that a file is regular, not empty and not too large.
fn check_file(file: &Path) -> Result<(), MapError> {
    let failed = |source| MapError::Io { file: file.into(), source };
    let open = match open_regular(file) {
        Ok(open) => open,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Err(MapError::Missing { file: file.into() });
        }
        Err(error) => return Err(failed(error)),
    };
    let size = open.metadata().map_err(failed)?.len();
    if size == 0 {
        return Err(MapError::Empty { file: file.into() });
    }
    if size > MOST_IMPORT_BYTES {
        let (what, allowed) = ("the file".into(), format!("at most {}", size_text(MOST_IMPORT_BYTES)));
        return Err(MapError::Limit { file: file.into(), what, value: size_text(size), allowed });
    }
    Ok(())
}

/// Checks that the document does not make netconvert read other files.
fn check_references(file: &Path) -> Result<(), MapError> {
    let found = document::open(file, MOST_IMPORT_BYTES).and_then(document::first_reference);
    match found.map_err(|source| MapError::Io { file: file.into(), source })? {
        Some((line, reference)) => {
            Err(MapError::Reference { file: file.into(), line, reference: reference.in_words() })
        }
        None => Ok(()),
    }
}

fn fill(
    folder: &Path,
    netconvert: &Path,
    (file, format): (&Path, SourceFormat),
    name: &str,
    options: &ImportOptions,
) -> Result<ImportReport, MapError> {
    let made = netconvert_attempts::make(netconvert, file, format, &folder.join("net.xml"), options)?;
    let mut report = ImportReport::of(file, format, &made)?;
    report.notes.extend(surroundings::write(folder, netconvert, (file, format), &made, options)?);
    let failed = |source| MapError::Io { file: file.into(), source };
    private::replace(&folder.join("map.toml"), map_file(name, &report, &made).as_bytes()).map_err(failed)?;
    private::replace(&folder.join(REPORT_FILE), report.text().as_bytes()).map_err(failed)?;
    Ok(report)
}

/// Returns the text of `map.toml`.
fn map_file(name: &str, report: &ImportReport, made: &netconvert_attempts::MadeNetwork) -> String {
    let text = |text: String| toml::Value::String(text).to_string();
    let (length_m, _, is_closed) = report.path;
    let kind = if is_closed { "A closed route" } else { "An open path" };
    let description = format!("{kind} of {length_m:.0} m, imported from {}.", report.file_name);
    // The title of a place stands on its signs.
    let title = made.place.clone().unwrap_or_else(|| name.to_owned());
    let head = format!("title = {}\ndescription = {}\n", text(title), text(description));
    if is_closed {
        return head
            + "# The closed route is the longest loop found; to drive another, name its edges:\n\
               # route = [\"edge\", \"edge\"]\n";
    }
    let streets = made.path.streets.iter().map(|lane| made.network.edge_of(*lane));
    let edges: Vec<String> = streets.map(|edge| text(edge.id.clone())).collect();
    format!(
        "{head}# No loop was found: this is the longest open path. To drive another, name its edges in order.\n\
         closed = false\nroute = [{}]\n",
        edges.join(", ")
    )
}
