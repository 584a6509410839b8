//! `codrive analyse`: measures, figures and a report of recordings.

use super::{CliError, out, progress::progress};
use crate::{
    analysis::{
        AnalysisError, DamagedParticipants, FolderContents, FoundRecording, analyse,
        data::{RecordedTrial, write_log},
        drivers::participants as drivers,
        find_undamaged,
        models::{plan::PlanHistory, planned::PlannedAnalysis},
        network::LinePlace,
        report::{AnalysisResults, FileProof},
        text::count,
    },
    drive_loop::RunError,
    private,
    record::{self, AlteredFile},
    study::{
        bids, checksums, erasure, places,
        session::{self, SessionLog},
    },
};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use rayon::prelude::*;
use std::{
    fmt::{Display, Formatter},
    path::{Path, PathBuf},
};

pub(super) fn command() -> Command {
    Command::new("analyse")
        .about(format!(
            "Make tables of measures (CSV), figures ({}), a methods text and a report (HTML, to be printed) of \
             recordings",
            super::desktop::FIGURES
        ))
        .after_help(
            "Results:\n  \
             report.html    report; for a PDF, print it from a browser\n  \
             methods.txt    methods section to copy\n  \
             figures/       89 mm wide (column) or 183 mm wide (page); PNG at 300 dots per inch\n  \
             columns.json   definition of every column of the tables\n  \
             reactions.csv  distributions of each participant's reaction, movement and compliance times, and the \
             chance level\n  \
             events.csv     response times and extremes after each event of the scenario\n  \
             drivers.csv    reaction time, bias, error and time gap of each participant\n  \
             drivers.toml   these drivers for codrive study rehearse FILE --drivers drivers.toml; folder of a study \
             only\n  \
             trips.csv      vehicles that entered and left a network, with travel time and time lost\n  \
             lines.csv      vehicles that passed each --line on a network\n\n\
             Every call makes all results again, and only reads the recordings.\n\
             Every file is first compared with its checksum.\n\
             Every recording is first compared with its participant, trial, condition, session log and plan.\n\
             The exit code is 1 if anything differs, also with --accept-changes.\n\
             A participant with a lost or unreadable recording or table is named and left out; the others are analysed.\n\n\
             Figures of long drives show the paths of the first hour, and speeds of evenly spaced steps.\n\
             A drive with more than 500,000 changes of advice is refused.\n\
             On networks, vehicles far from the ego are recorded once a second. columns.json names the measures that \
             networks lack.",
        )
        .arg(
            Arg::new("folder")
                .value_name("DIR")
                .required(true)
                .value_parser(value_parser!(PathBuf))
                .help("A recording, a participant of a study (.../sub-P03), or the folder of a study"),
        )
        .arg(Arg::new("out").long("out").value_name("DIR").value_parser(value_parser!(PathBuf)).help(
            "Folder of the results [default: analysis/ in a recording, derivatives/codrive/ in the folder of a study]",
        ))
        .arg(Arg::new("study").long("study").value_name("FILE.toml").value_parser(value_parser!(PathBuf)).help(
            "Current study file. The command carries out its [analysis], and the report lists the changes since the first \
             session [default: the plan in the data set]",
        ))
        .arg(
            Arg::new("line")
                .long("line")
                .value_name("LANE_OR_EDGE:METRES")
                .action(ArgAction::Append)
                .value_parser(|text: &str| text.parse::<LinePlace>())
                .help(
                    "Line for counting throughput on networks: a lane, or all lanes of an edge, and the distance from \
                     its start. May be given several times; the table of trials uses the first [default: the street in \
                     the middle of the ego's path]",
                ),
        )
        .arg(Arg::new("accept-changes").long("accept-changes").action(ArgAction::SetTrue).help(
            "Analyse recordings and data sets with changed or misplaced files. The output and the report name these \
             files first, and the exit code is 1",
        ))
        .arg(
            Arg::new("trajectories")
                .long("trajectories")
                .value_name("FILE.csv")
                .value_parser(value_parser!(PathBuf))
                .help("New file of the trajectories of one recording's vehicles, to drive behind them: --traffic FILE.csv"),
        )
        .arg(super::sign::signer_argument())
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let Some(folder) = matches.get_one::<PathBuf>("folder") else { return Ok(()) };
    erasure::finish_around(folder).map_err(RunError::from)?;
    let (contents, found) = compared(folder)?;
    let out = matches.get_one::<PathBuf>("out").unwrap_or(&contents.out);
    if !found.iter().all(|change| is_left_out(&contents, change)) && !matches.get_flag("accept-changes") {
        return Err(CliError::Failed(refusal(folder, &found)));
    }
    let changed: Vec<String> = found.iter().map(ToString::to_string).collect();
    for what in &changed {
        out::line(format_args!("not as written: {what}"))?;
    }
    let signature = super::sign::of_analysis(&contents, !changed.is_empty(), matches)?;
    if let Some(signature) = &signature {
        out::line(format_args!("{signature}"))?;
    }
    let proof = FileProof { changed, signature };
    let bar = progress(contents.found.len() as u64, "drives".into());
    let lines: Vec<LinePlace> = matches.get_many("line").into_iter().flatten().cloned().collect();
    let drives = analyse(&contents.found, &lines, &|| bar.inc(1));
    bar.finish_and_clear();
    let drives = drives?;
    let fitted = drivers::drivers(&drives);
    let planned = match &contents.root {
        Some(root) if contents.is_whole => {
            let history = PlanHistory::of(root, matches.get_one::<PathBuf>("study").map(PathBuf::as_path))?;
            PlannedAnalysis::of(&history, &drives, &contents.people)
        }
        _ => None,
    };
    let results = AnalysisResults {
        contents: &contents,
        proof: &proof,
        drives: &drives,
        fitted: &fitted,
        planned: planned.as_ref(),
    };
    results.write(out, &bids::derived(&contents.title), |svg| {
        super::desktop::png(svg).map(|png| png.map_err(|why| why.to_string()))
    })?;
    out::line(format_args!(
        "{}: report.html, methods.txt, tables (CSV) and figures ({}) of {}",
        out.display(),
        super::desktop::FIGURES,
        count(drives.len())
    ))?;
    if let Some(file) = matches.get_one::<PathBuf>("trajectories") {
        trajectories(&contents, file)?;
    }
    if proof.changed.is_empty() {
        return Ok(());
    }
    Err(CliError::Failed(format!(
        "{}: analysed although {} not as written (named above and in the report){}",
        folder.display(),
        things(proof.changed.len()),
        left_out(&contents.damaged)
    )))
}

/// Returns a sentence on the participants who are left out, with the remedy; empty if there are none.
fn left_out(damaged: &DamagedParticipants) -> String {
    if damaged.is_empty() {
        return String::new();
    }
    let ids: Vec<&str> = damaged.keys().map(String::as_str).collect();
    let are = if ids.len() == 1 { "is" } else { "are" };
    format!(
        "; {} {are} left out, because files cannot be read any more\n  remedy: restore the files from a copy, or exclude \
         the participant (codrive study exclude); files that can be read are analysed as they are with --accept-changes",
        ids.join(", ")
    )
}

/// Writes the trajectories of one recording.
fn trajectories(contents: &FolderContents, file: &Path) -> Result<(), CliError> {
    let [found] = &contents.found[..] else {
        let text = format!("--trajectories is for one recording; this folder has {}", contents.found.len());
        return Err(CliError::Input(text));
    };
    let way = file.parent().unwrap_or(file);
    private::check_way(private::base_of(way, contents.folder()), way)
        .map_err(|why| CliError::Input(format!("{}: {why}", file.display())))?;
    let vehicles = write_log(&RecordedTrial::open(&found.recording)?, file)?;
    out::line(format_args!("{}: trajectories of {vehicles} vehicles", file.display()))
}

/// A part that was changed or lies in the wrong place.
#[derive(Clone, PartialEq)]
pub(super) struct Change {
    /// Participant that the part belongs to, such as `sub-P03`; `None` for a part of the whole data set.
    subject: Option<String>,
    text: String,
}

impl Display for Change {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.text)
    }
}

/// Returns the contents of a folder without its damaged participants, and the parts that were changed since they were written, cannot be
/// read any more, or lie in the wrong place. Files of a data set are checked against its list, recordings against their place in it and
/// their own seals.
pub(super) fn compared(folder: &Path) -> Result<(FolderContents, Vec<Change>), CliError> {
    let contents = find_undamaged(folder, &DamagedParticipants::new())?;
    let (mut found, mut damaged) = (Vec::new(), contents.damaged.clone());
    if let Some(root) = &contents.root {
        let listed = checksums::changes(root).map_err(RunError::from)?;
        let placed = places::misplaced(root).map_err(RunError::from)?;
        let change = |one: &AlteredFile| Change { subject: checksums::subject(&one.file), text: one.to_string() };
        found.extend(listed.iter().chain(&placed).map(change));
        for lost in listed.iter().filter(|one| is_lost(root, &one.file)) {
            damaged.entry(checksums::subject(&lost.file).unwrap_or_default()).or_insert_with(|| lost.to_string());
        }
    }
    let one = |drive: &FoundRecording| compare_drive(&contents, drive);
    let all: Vec<(Vec<Change>, Option<String>)> = contents.found.par_iter().map(one).collect::<Result<_, _>>()?;
    for (drive, (changes, why)) in contents.found.iter().zip(all) {
        // A file that differs from both the data set's list and its recording's seals is listed with both.
        found.extend(changes);
        if let Some(why) = why {
            damaged.entry(drive.participant.clone()).or_insert(why);
        }
    }
    found.dedup();
    let left = |(subject, why): (&String, &String)| Change {
        subject: Some(subject.clone()),
        text: format!("{subject} is left out: {why}"),
    };
    found.extend(damaged.iter().map(left));
    let contents = if damaged == contents.damaged { contents } else { find_undamaged(folder, &damaged)? };
    Ok((contents, found))
}

/// Compares a drive and its baseline with their seals. Also returns the reason why a drive of a data set cannot be analysed any more, if
/// anything differs and it cannot.
fn compare_drive(contents: &FolderContents, drive: &FoundRecording) -> Result<(Vec<Change>, Option<String>), CliError> {
    let subject = Some(drive.participant.clone()).filter(|_| contents.root.is_some());
    let mut found = Vec::new();
    for folder in [Some(&drive.recording), drive.baseline.as_ref()].into_iter().flatten() {
        let shown = contents.root.as_deref().and_then(|root| folder.strip_prefix(root).ok()).unwrap_or(folder);
        // Running and cut recordings are refused with their own messages.
        match record::open(folder).and_then(|_| record::changes(folder)) {
            Ok(changes) => found.extend(changes.iter().map(|change| Change {
                subject: subject.clone(),
                text: format!("{}: {}", shown.join(&change.file).display(), change.what),
            })),
            Err(why) if subject.is_none() => return Err(why.into()),
            Err(why) => return Ok((found, Some(format!("{}: {why}", shown.display())))),
        }
    }
    if found.is_empty() || subject.is_none() {
        return Ok((found, None));
    }
    let failed = analyse(std::slice::from_ref(drive), &[], &|| ()).err();
    let shown = contents.root.as_deref().and_then(|root| drive.recording.strip_prefix(root).ok());
    let why = failed.map(|why| format!("{}: {why}", shown.unwrap_or(&drive.recording).display()));
    Ok((found, why))
}

/// Returns true for a change of a participant whose data are not analysed.
fn is_left_out(contents: &FolderContents, change: &Change) -> bool {
    change.subject.as_ref().is_some_and(|of| {
        let is_other = !contents.is_whole && !contents.found.iter().any(|drive| drive.participant == *of);
        is_other || contents.damaged.contains_key(of) || contents.people.is_excluded(of)
    })
}

/// Returns true if the participant of this file cannot be analysed without it: their log, or the list of their drives.
fn is_lost(root: &Path, file: &str) -> bool {
    let path = root.join(file);
    file.ends_with("_scans.tsv") && !path.exists()
        || file.starts_with("sourcedata/") && path.ends_with(session::FILE) && SessionLog::load(&path).is_err()
}

/// Returns the refusal to analyse, with the remedy.
fn refusal(folder: &Path, changed: &[Change]) -> String {
    const MOST: usize = 20;
    let mut lines = vec![format!("{}: {} not as written or misplaced", folder.display(), things(changed.len()))];
    lines.extend(changed.iter().take(MOST).map(ToString::to_string));
    if changed.len() > MOST {
        lines.push(format!("and {} more", changed.len() - MOST));
    }
    lines.push(
        "remedy: restore the files, or analyse them as they are with --accept-changes; the report then names the \
         changes, and the exit code is still 1"
            .into(),
    );
    lines.join("\n  ")
}

fn things(count: usize) -> String {
    if count == 1 { "1 thing is".into() } else { format!("{count} things are") }
}

impl From<AnalysisError> for CliError {
    fn from(error: AnalysisError) -> Self {
        match error {
            AnalysisError::Input(text) => Self::Input(text),
            AnalysisError::Record(error) => error.into(),
        }
    }
}
