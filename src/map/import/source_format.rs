//! Formats of files to import. In: a file's name. Out: its format, and netconvert's option for it.

use std::path::Path;

/// Format of a file to import.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceFormat {
    /// OpenDRIVE, files `.xodr`.
    OpenDrive,
    /// OpenStreetMap, files `.osm` and `.osm.xml`.
    OpenStreetMap,
    /// SUMO's own network format, files `net.xml`.
    Sumo,
}

impl SourceFormat {
    /// Returns the format by the file's name, which may end with `.gz`; `None` if it is unknown.
    pub(super) fn of(file: &Path) -> Option<Self> {
        let name = file.file_name()?.to_string_lossy().to_lowercase();
        let name = name.trim_end_matches(".gz");
        let ends = |ends: &[&str]| ends.iter().any(|end| name.ends_with(end));
        match () {
            () if ends(&[".xodr"]) => Some(Self::OpenDrive),
            () if ends(&[".osm", ".osm.xml"]) => Some(Self::OpenStreetMap),
            () if ends(&["net.xml"]) => Some(Self::Sumo),
            () => None,
        }
    }

    /// Returns the format's name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::OpenDrive => "OpenDRIVE",
            Self::OpenStreetMap => "OpenStreetMap",
            Self::Sumo => "a SUMO network",
        }
    }

    /// Returns netconvert's option before the name of the file.
    pub(super) fn option(self) -> &'static str {
        match self {
            Self::OpenDrive => "--opendrive-files",
            Self::OpenStreetMap => "--osm-files",
            Self::Sumo => "--sumo-net-file",
        }
    }
}
