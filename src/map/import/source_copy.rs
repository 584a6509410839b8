//! Copy of the user's file that netconvert reads. In: a file and its format. Out: a prepared copy, netconvert's options that belong to it, and
//! lines for the report on what was changed. The copies are removed when they are no longer needed.

use super::{
    driving_side::DrivingSide,
    open_drive::{self, OpenDriveFault},
    open_street_map,
    source_format::SourceFormat,
};
use crate::{
    map::{MapError, limits::MOST_IMPORT_BYTES},
    private,
    sumo_xml::document,
};
use std::path::{Path, PathBuf};

/// File that netconvert reads.
pub(super) struct SourceCopy {
    /// Path of the prepared copy, or of the user's file.
    pub file: PathBuf,
    /// Options of netconvert: `--type-files`, `--lefthand`.
    pub options: Vec<String>,
    /// Lines for the report.
    pub notes: Vec<String>,
    /// Name of the place, if the file has one.
    pub place: Option<String>,
    /// Files to remove when the conversion is over.
    copies: Vec<PathBuf>,
}

impl Drop for SourceCopy {
    fn drop(&mut self) {
        for copy in &self.copies {
            let _ = std::fs::remove_file(copy);
        }
    }
}

impl SourceCopy {
    /// Prepares `file` in `folder`; `side` is the side of traffic that the user named.
    ///
    /// # Errors
    /// The file cannot be read, contradicts itself, or `side` is given for a SUMO network, which states its side itself.
    pub fn make(file: &Path, format: SourceFormat, folder: &Path, side: Option<DrivingSide>) -> Result<Self, MapError> {
        let mut made =
            Self { file: file.into(), options: Vec::new(), notes: Vec::new(), place: None, copies: Vec::new() };
        match format {
            SourceFormat::OpenDrive => made.open_drive(folder, side)?,
            SourceFormat::OpenStreetMap => made.open_street_map(folder, side)?,
            SourceFormat::Sumo => {
                if let Some(side) = side {
                    let allowed =
                        "OpenDRIVE and OpenStreetMap files; a SUMO network names its side by `lefthand`".to_owned();
                    return Err(MapError::Parameter { what: "--driving-side", value: side.name().into(), allowed });
                }
            }
        }
        Ok(made)
    }

    fn open_drive(&mut self, folder: &Path, side: Option<DrivingSide>) -> Result<(), MapError> {
        let failed = |source| MapError::Io { file: self.file.clone(), source };
        let text = document::read_text(&self.file, MOST_IMPORT_BYTES).map_err(failed)?;
        let Some(prepared) = open_drive::prepare(&text, side) else { return Ok(()) };
        let copy = prepared.map_err(|OpenDriveFault { line, element, problem }| MapError::Refused {
            file: self.file.clone(),
            line,
            element,
            problem,
        })?;
        let types = self.keep(folder, "lanes.typ.xml", &open_drive::lane_types())?;
        self.options = vec!["--type-files".into(), types.to_string_lossy().into_owned()];
        self.sides(copy.side);
        self.notes = copy.notes;
        self.file = self.keep(folder, "copy.xodr", &copy.text)?;
        Ok(())
    }

    fn open_street_map(&mut self, folder: &Path, side: Option<DrivingSide>) -> Result<(), MapError> {
        let failed = |source| MapError::Io { file: self.file.clone(), source };
        let copy = folder.join("copy.osm");
        self.copies.push(copy.clone());
        let from = document::open(&self.file, MOST_IMPORT_BYTES).map_err(failed)?;
        let Some(found) = open_street_map::copy(from, private::file(&copy).map_err(failed)?, side).map_err(failed)?
        else {
            return Ok(());
        };
        self.sides(found.side);
        self.notes = found.notes;
        self.place = found.place;
        self.file = copy;
        Ok(())
    }

    fn sides(&mut self, side: DrivingSide) {
        if side == DrivingSide::Left {
            self.options.push("--lefthand".into());
        }
    }

    fn keep(&mut self, folder: &Path, name: &str, text: &str) -> Result<PathBuf, MapError> {
        let copy = folder.join(name);
        self.copies.push(copy.clone());
        private::replace(&copy, text.as_bytes()).map_err(|source| MapError::Io { file: copy.clone(), source })?;
        Ok(copy)
    }
}
