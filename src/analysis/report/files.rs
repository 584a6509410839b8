//! Files of an analysis. In: its results and a folder. Out: tables (CSV), figures, the data dictionary, the methods and the page.

use super::{FileProof, glossary, report};
use crate::{
    analysis::{
        data::FolderContents,
        drivers::participants::{ParticipantDriver, drivers_toml},
        drives::AnalysedRecording,
        error::AnalysisError,
        models::planned::{self, PlannedAnalysis},
        tables,
    },
    private,
    record::{self, RecordError},
};
use rayon::prelude::*;
use std::path::Path;

/// Results of an analysis.
#[derive(Clone, Copy, Debug)]
pub struct AnalysisResults<'a> {
    /// Contents of the folder that was analysed.
    pub contents: &'a FolderContents,
    /// Result of comparing the files with their checksums and places.
    pub proof: &'a FileProof,
    /// Drives that were analysed, in their order.
    pub drives: &'a [AnalysedRecording],
    /// Driver of each participant.
    pub fitted: &'a [ParticipantDriver],
    /// Results of the planned analysis, if the study has one.
    pub planned: Option<&'a PlannedAnalysis>,
}

impl AnalysisResults<'_> {
    /// Writes all files to the folder `out`. `descriptions` are the files that describe a data set's derivatives, by name. `png` converts
    /// a figure from SVG; `None` if this build cannot.
    ///
    /// # Errors
    /// A recording whose figures are drawn cannot be read, a link is in the way, or a file cannot be written.
    pub fn write(
        &self,
        out: &Path,
        descriptions: &[(&str, String)],
        png: impl Fn(&str) -> Option<Result<Vec<u8>, String>> + Sync,
    ) -> Result<(), AnalysisError> {
        let Self { contents, proof, drives, fitted, planned } = *self;
        let made = report(&contents.title, drives, &contents.people, proof, fitted, planned)?;
        record::new_dir_within(private::base_of(out, contents.folder()), out)?;
        let write = |name: &str, text: &str| record::replace(&out.join(name), text.as_bytes());
        self.write_tables(&write)?;
        if contents.is_whole {
            descriptions.iter().try_for_each(|(name, text)| write(name, text))?;
        }
        write("methods.txt", &made.methods)?;
        Ok(write_page(out, &made.html, &made.figures, png)?)
    }

    /// Writes the tables one after the other. Tables that few studies have are left out where they have no rows.
    fn write_tables(&self, write: &impl Fn(&str, &str) -> Result<(), RecordError>) -> Result<(), RecordError> {
        let Self { contents: FolderContents { title, people, is_whole, .. }, drives, fitted, planned, .. } = *self;
        write("trials.csv", &tables::trials(drives))?;
        write("advice.csv", &tables::advice(drives))?;
        write("reactions.csv", &tables::response_times(drives))?;
        write("speed.csv", &tables::speed(drives))?;
        write("conditions.csv", &tables::by_condition(drives))?;
        write("drivers.csv", &tables::drivers(fitted))?;
        if !people.each.is_empty() {
            write("scores.csv", &tables::scores(people))?;
        }
        if !people.ratings.is_empty() {
            write("fms.csv", &tables::sickness(people))?;
        }
        if tables::have_events(drives) {
            write(tables::EVENTS_FILE, &tables::events(drives))?;
        }
        if drives.iter().any(|drive| drive.network.is_some()) {
            write(tables::TRIPS_FILE, &tables::trips(drives))?;
            write(tables::LINES_FILE, &tables::lines(drives))?;
        }
        write("columns.json", &glossary::dictionary(drives))?;
        if *is_whole {
            write("drivers.toml", &drivers_toml(title, fitted))?;
        }
        if let Some(planned) = planned {
            write("models.csv", &planned.models_csv())?;
            write("models.json", &planned::models_json())?;
            write("left_out.csv", &planned.left_out_csv())?;
        }
        Ok(())
    }
}

/// Writes a page as `report.html`, and its figures to the folder `figures` beside it. `png` converts a figure from SVG; `None` if this build
/// cannot.
///
/// # Errors
/// A file cannot be written.
pub fn write_page(
    out: &Path,
    html: &str,
    figures: &[(String, String)],
    png: impl Fn(&str) -> Option<Result<Vec<u8>, String>> + Sync,
) -> Result<(), RecordError> {
    record::new_dir_within(out, &out.join("figures"))?;
    figures.par_iter().try_for_each(|(name, svg)| {
        let path = out.join("figures").join(name);
        record::replace(&path, svg.as_bytes())?;
        let path = path.with_extension("png");
        match png(svg) {
            Some(Ok(png)) => record::replace(&path, &png),
            Some(Err(why)) => Err(RecordError::Table { path, why }),
            None => Ok(()),
        }
    })?;
    record::replace(&out.join("report.html"), html.as_bytes())
}
