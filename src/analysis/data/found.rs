//! Recordings in a folder. In: a recording, a participant's folder or a whole data set. Out: the recordings to analyse, with
//! participant, condition and baseline. A data set is read by its BIDS tables (`sub-*_scans.tsv`).

use super::{
    people::{DamagedParticipants, StudyParticipants},
    session_ends, sickness_ratings,
    tsv::{MISSING, TsvFile},
};
use crate::analysis::error::AnalysisError;
use crate::{
    file::{SETTINGS_BYTES, read_text},
    record::{self, RecordError},
};
use std::path::{Path, PathBuf};

/// A recording to analyse.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FoundRecording {
    /// `sub-P03`; empty outside of a study.
    pub participant: String,
    /// Segment of the study.
    pub segment: String,
    /// Place among the trials, as in the table.
    pub place: String,
    /// Condition; empty for a drive that is the same for everyone.
    pub condition: String,
    /// Place of the condition in the study, from 0; behind all conditions if it is none of them.
    pub rank: usize,
    /// Level of each factor.
    pub levels: Vec<(String, String)>,
    /// Folder of the recording.
    pub recording: PathBuf,
    /// Folder of the same drive without advice.
    pub baseline: Option<PathBuf>,
}

impl FoundRecording {
    /// Returns participant, segment, place and condition; for a recording alone, the folder's name.
    pub fn title(&self) -> String {
        if self.participant.is_empty() {
            return self.recording.file_name().unwrap_or_default().to_string_lossy().into_owned();
        }
        let parts = [&self.participant, &self.segment, &self.place, &self.condition];
        parts.into_iter().filter(|part| !part.is_empty()).cloned().collect::<Vec<_>>().join(" ")
    }
}

/// Contents of a folder.
#[derive(Clone, Debug, PartialEq)]
pub struct FolderContents {
    /// Recordings, in the order of participants and places.
    pub found: Vec<FoundRecording>,
    /// Folder of the data set; `None` for a recording alone.
    pub root: Option<PathBuf>,
    /// Output folder of tables and report.
    pub out: PathBuf,
    /// Title of the report: the study's name, the participant or the recording.
    pub title: String,
    /// Participants, including those with excluded drives.
    pub people: StudyParticipants,
    /// A whole data set, not one participant or one recording.
    pub is_whole: bool,
    /// Participants who are left out because their files cannot be read any more.
    pub damaged: DamagedParticipants,
}

impl FolderContents {
    /// Returns the folder of another person's files in which results may lie: the data set, or the recording.
    pub fn folder(&self) -> &Path {
        let recording = || self.found.first().map_or(Path::new(""), |found| &found.recording);
        self.root.as_deref().unwrap_or_else(recording)
    }
}

/// Finds the recordings in a folder.
///
/// # Errors
/// The folder holds nothing to analyse, or a table cannot be read.
pub fn find(folder: &Path) -> Result<FolderContents, AnalysisError> {
    let found = find_undamaged(folder, &DamagedParticipants::new())?;
    match found.damaged.into_iter().next() {
        Some((subject, why)) => Err(AnalysisError::Input(format!("{subject}: {why}"))),
        None => Ok(FolderContents { damaged: DamagedParticipants::new(), ..found }),
    }
}

/// Finds the recordings in a folder, and leaves out the participants in `damaged` and those whose own tables cannot be read.
///
/// # Errors
/// The folder holds nothing to analyse, or a table of all participants cannot be read.
pub fn find_undamaged(folder: &Path, damaged: &DamagedParticipants) -> Result<FolderContents, AnalysisError> {
    if folder.join("manifest.json").exists() {
        let name = folder.file_name().unwrap_or_default().to_owned();
        let beside = |ending: &str| {
            let mut name = name.clone();
            name.push(ending);
            folder.with_file_name(name)
        };
        let baseline = Some(beside("-baseline")).filter(|path| path.exists());
        let found = FoundRecording { recording: folder.into(), baseline, ..FoundRecording::default() };
        let title = found.title();
        return Ok(FolderContents {
            found: vec![found],
            root: None,
            out: folder.join("analysis"),
            title,
            people: StudyParticipants::default(),
            is_whole: false,
            damaged: DamagedParticipants::new(),
        });
    }
    let nothing = || {
        AnalysisError::Input(format!(
            "{} contains nothing to analyse; name a recording, a participant of a study (.../sub-P03) or the study's \
             folder",
            folder.display()
        ))
    };
    let is_root = |path: &Path| path.join("dataset_description.json").exists();
    let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let (root, subjects) = if is_root(folder) {
        (folder, subjects(folder)?)
    } else {
        let root = folder.ancestors().skip(1).find(|path| is_root(path)).ok_or_else(nothing)?;
        if !name.starts_with("sub-") {
            return Err(nothing());
        }
        (root, vec![name.clone()])
    };
    let whole = is_root(folder);
    let (mut damaged, mut drives) = (damaged.clone(), Vec::new());
    for subject in &subjects {
        match scans(root, subject).and_then(|found| sickness_ratings::ratings(root, subject).map(|_| found)) {
            Ok(found) => drives.push((subject, found)),
            Err(why) => _ = damaged.entry(subject.clone()).or_insert_with(|| why.to_string()),
        }
    }
    let mut people = StudyParticipants::of(root, &subjects, &damaged)?;
    if whole {
        people.erased = session_ends::erased(root)?;
    }
    drives.retain(|(subject, _)| !people.is_excluded(subject) && !damaged.contains_key(*subject));
    let found: Vec<FoundRecording> = drives.into_iter().flat_map(|(_, found)| found).collect();
    if found.is_empty() {
        let mut text =
            format!("{} contains no complete drive that is not excluded; see participants.tsv", folder.display());
        damaged.iter().for_each(|(subject, why)| text += &format!("\n  {subject} is left out: {why}"));
        return Err(AnalysisError::Input(text));
    }
    let out = root.join("derivatives").join("codrive");
    let title = if whole { study_title(root) } else { name.clone() };
    let out = if whole { out } else { out.join(name) };
    Ok(FolderContents { found, root: Some(root.into()), out, title, people, is_whole: whole, damaged })
}

fn subjects(root: &Path) -> Result<Vec<String>, RecordError> {
    let entries = record::entries(root)?;
    let names = entries.iter().map(|path| path.file_name().unwrap_or_default().to_string_lossy().into_owned());
    let mut names: Vec<String> = names.filter(|name| name.starts_with("sub-")).collect();
    names.sort();
    Ok(names)
}

fn study_title(root: &Path) -> String {
    let text = read_text(&root.join("dataset_description.json"), SETTINGS_BYTES).unwrap_or_default();
    let value: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    value["Name"].as_str().unwrap_or("Study").to_owned()
}

/// Returns the drives of one participant; none before the end of their session, which writes the list.
fn scans(root: &Path, subject: &str) -> Result<Vec<FoundRecording>, AnalysisError> {
    let path = root.join(subject).join(format!("{subject}_scans.tsv"));
    let Some(table) = TsvFile::read(&path)? else { return Ok(Vec::new()) };
    let column = |name: &str| table.column(name);
    let known = [column("segment")?, column("place")?, column("condition")?, column("recording")?, column("baseline")?];
    let levels = known[2] + 1..column("seed")?;
    let order = table.conditions()?;
    let drive = |row: &Vec<String>| {
        let cell = |at: usize| if row[at] == MISSING { String::new() } else { row[at].clone() };
        let [segment, place, condition, recording, baseline] = known.map(cell);
        // Questionnaire rows have no recording.
        (!recording.is_empty()).then(|| FoundRecording {
            rank: order.iter().position(|name| *name == condition).unwrap_or(order.len()),
            participant: subject.into(),
            segment,
            place,
            condition,
            levels: levels.clone().map(|at| (table.names[at].clone(), cell(at))).collect(),
            recording: root.join(recording),
            baseline: (!baseline.is_empty()).then(|| root.join(baseline)),
        })
    };
    Ok(table.rows.iter().filter_map(drive).collect())
}

#[cfg(test)]
#[path = "found_tests.rs"]
mod tests;
