//! `codrive analyse`: measures, figures and a report of recordings.

use super::{CliError, out, progress::progress};
use crate::{
    analysis::{
        AnalysisError, FolderContents, analyse,
        data::{RecordedTrial, write_log},
        drivers::participants as drivers,
        find,
        models::{plan::PlanHistory, planned::PlannedAnalysis},
        network::LinePlace,
        report::{AnalysisResults, FileProof},
        text::count,
    },
    drive_loop::RunError,
    record,
    study::{bids, checksums, erasure, places},
};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use rayon::prelude::*;
use std::path::{Path, PathBuf};

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
             Every recording is first compared with its participant, trial, condition, session and plan.\n\
             The exit code is 1 if anything differs, also with --accept-changes.\n\n\
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
    let contents = find(folder)?;
    let out = matches.get_one::<PathBuf>("out").unwrap_or(&contents.out);
    let changed = changes(&contents)?;
    if !changed.is_empty() && !matches.get_flag("accept-changes") {
        return Err(CliError::Failed(refusal(folder, &changed)));
    }
    for what in &changed {
        out::line(format_args!("not as written: {what}"))?;
    }
    let is_said = changed.is_empty() || matches.contains_id("signer");
    let signed = || super::sign::signature(contents.root.as_deref().unwrap_or(folder), matches);
    let signature = is_said.then(signed).transpose()?;
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
        "{}: analysed although {} not as written (named above and in the report)",
        folder.display(),
        things(proof.changed.len())
    )))
}

/// Writes the trajectories of one recording.
fn trajectories(contents: &FolderContents, file: &Path) -> Result<(), CliError> {
    let [found] = &contents.found[..] else {
        let text = format!("--trajectories is for one recording; this folder has {}", contents.found.len());
        return Err(CliError::Input(text));
    };
    let vehicles = write_log(&RecordedTrial::open(&found.recording)?, file)?;
    out::line(format_args!("{}: trajectories of {vehicles} vehicles", file.display()))
}

/// Returns the parts of a folder that were changed since they were written or lie in the wrong place.
pub(super) fn disagreements(folder: &Path) -> Result<Vec<String>, CliError> {
    changes(&find(folder)?)
}

/// Returns the parts that were changed or lie in the wrong place. Files of the data set are checked against its list,
/// recordings against their place in it and their own seals.
fn changes(contents: &FolderContents) -> Result<Vec<String>, CliError> {
    let mut found: Vec<String> = Vec::new();
    if let Some(root) = &contents.root {
        let listed = checksums::changes(root).map_err(RunError::from)?;
        let placed = places::misplaced(root).map_err(RunError::from)?;
        found.extend(listed.iter().chain(&placed).map(ToString::to_string));
    }
    let recordings = contents.found.iter().flat_map(|found| [Some(&found.recording), found.baseline.as_ref()]);
    let recordings: Vec<&PathBuf> = recordings.flatten().collect();
    let of_one = |folder: &&PathBuf| -> Result<Vec<String>, CliError> {
        // Running and cut recordings are refused with their own messages.
        record::open(folder)?;
        let changes = record::changes(folder)?;
        let shown = contents.root.as_deref().and_then(|root| folder.strip_prefix(root).ok()).unwrap_or(folder);
        Ok(changes.iter().map(|change| format!("{}: {}", shown.join(&change.file).display(), change.what)).collect())
    };
    let all: Vec<Vec<String>> = recordings.par_iter().map(of_one).collect::<Result<_, _>>()?;
    // A file that differs from both the data set's list and its recording's seals is listed with both.
    found.extend(all.into_iter().flatten());
    found.dedup();
    Ok(found)
}

/// Returns the refusal to analyse, with the remedy.
fn refusal(folder: &Path, changed: &[String]) -> String {
    const MOST: usize = 20;
    let mut lines = vec![format!("{}: {} not as written or misplaced", folder.display(), things(changed.len()))];
    lines.extend(changed.iter().take(MOST).cloned());
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
