//! Report section of single drives. In: analysed drives and their recordings. Out: figures of each on the page: speeds,
//! positions over time, and mean speed as driven and without advice.

use super::{
    figures, network_figures,
    page::{ReportFigure, ReportPage},
    words::verb,
};
use crate::analysis::{
    data::{DriveTrajectories, RecordedTrial},
    drives::AnalysedRecording,
    error::AnalysisError,
    network::PathTraces,
};
use crate::{plot::escaped, record::Table};
use std::path::Path;

/// Adds the drives one by one: all drives of the first participant, and in a comparison only those with a baseline.
pub(super) fn one_by_one(
    page: &mut ReportPage,
    drives: &[AnalysedRecording],
    is_compared: bool,
) -> Result<(), AnalysisError> {
    let first = &drives[0].found.participant;
    let shown: Vec<&AnalysedRecording> = drives
        .iter()
        .filter(|drive| drive.found.participant == *first && (!is_compared || drive.found.baseline.is_some()))
        .collect();
    if shown.is_empty() {
        return Ok(());
    }
    page.put(match (is_compared, shown.len()) {
        (true, _) => "<h2>One participant's trials</h2>",
        (false, 1) => "<h2>The drive</h2>",
        (false, _) => "<h2>Drives</h2>",
    });
    for (i, drive) in shown.into_iter().enumerate() {
        let title = drive.found.title();
        let (figures, hits) = one(drive, &title, i + 1)?;
        page.put(&format!("<h3>{}</h3>", escaped(&title)));
        let (links, n) = (page.figure_links(0, figures.len()), figures.len());
        page.paragraph("lead", &format!("{} this drive.", verb(&links, n, "show")));
        if !hits.is_empty() {
            page.paragraph("warning", &hits);
        }
        let missing = drive.network.iter().flat_map(|network| &network.missing);
        missing.for_each(|missing| page.paragraph("warning", &escaped(missing)));
        figures.into_iter().for_each(|figure| page.figure(figure));
    }
    Ok(())
}

/// Returns the figures of a drive (speeds, positions, mean speed as driven and without advice) and a sentence about contacts.
fn one(drive: &AnalysedRecording, title: &str, number: usize) -> Result<(Vec<ReportFigure>, String), AnalysisError> {
    let trial = RecordedTrial::open(&drive.found.recording)?;
    let baseline = drive.found.baseline.as_deref().map(RecordedTrial::open).transpose()?;
    let more = if trial.contacts > trial.contacts_at.len() { ", ..." } else { "" };
    let each = trial.contacts_at.iter().map(|[at_s, mps]| format!("at {at_s:.1} s with {mps:.1} m/s"));
    let each: Vec<String> = each.collect();
    let hits = if each.is_empty() { String::new() } else { format!("Contacts: {}{more}", each.join(", ")) };
    let vehicles = match &drive.network {
        Some(network) => format!("{} vehicles that entered and left", network.vehicles),
        None => format!("{} vehicles", drive.setup.scenario.vehicles),
    };
    let what = format!("1 drive ({title}), {vehicles}");
    let mut figures = match drive.network {
        Some(_) => on_network(&trial, baseline.as_ref(), &what, number)?,
        None => on_closed_route(&trial, baseline.as_ref(), &what, number)?,
    };
    let without = if drive.baseline_per_second_mps.is_empty() { "" } else { " as driven, and without advice" };
    figures.push(ReportFigure {
        name: format!("mean-speed-{number}"),
        svg: figures::gain("", drive),
        caption: format!(
            "Mean speed of all vehicles over time{without}: means of at least 5 s, drawn at their middle. {what}."
        ),
    });
    Ok((figures, hits))
}

/// Returns the positions of all vehicles of a recorded drive over time, along the ego's path, as SVG; `None` if none were
/// recorded.
///
/// # Errors
/// The folder holds no recording, or one that cannot be read.
pub fn space_time(recording: &Path) -> Result<Option<String>, AnalysisError> {
    let trial = RecordedTrial::open(recording)?;
    Ok(match trial.has(Table::Path) {
        true => PathTraces::of(&trial)?.map(|traces| network_figures::space_time("", &traces, None)),
        false => DriveTrajectories::of(&trial)?.map(|traces| figures::space_time("", &traces, None)),
    })
}

/// Returns a sentence on the moments marked in the figure of speeds.
fn marked_moments(trial: &RecordedTrial) -> String {
    let contacts = ("red: contacts with other vehicles", trial.contacts_at.is_empty());
    let red_lights = ("red dashes: red lights passed", trial.red_lights_at.is_empty());
    let marks = ("dashed: moments that the experimenter marked", trial.marks_at.is_empty());
    let marks_text =
        [contacts, red_lights, marks].into_iter().filter(|(_, is_empty)| !is_empty).map(|(words, _)| words);
    let marks_text = marks_text.collect::<Vec<_>>().join("; ");
    let mut signs = marks_text.chars();
    signs.next().map_or(String::new(), |first| format!(" {}{}.", first.to_uppercase(), signs.as_str()))
}

/// Returns the figures of speeds and positions on a closed route.
fn on_closed_route(
    trial: &RecordedTrial,
    baseline: Option<&RecordedTrial>,
    what: &str,
    number: usize,
) -> Result<Vec<ReportFigure>, AnalysisError> {
    let Some(traces) = DriveTrajectories::of(trial)? else { return Ok(Vec::new()) };
    let baseline = baseline.map(DriveTrajectories::of).transpose()?.flatten();
    let marks = marked_moments(trial);
    let compared = if baseline.is_some() {
        "; above as driven, below from the same seed without advice, driven by the car-following model"
    } else {
        ""
    };
    let title = if baseline.is_some() { "As driven" } else { "" };
    Ok(vec![
        ReportFigure {
            name: format!("speeds-{number}"),
            svg: figures::speeds("", &traces, trial),
            caption: format!(
                "Speed of the ego vehicle, advised speed with its acceptable range (green band), and mean speed of all vehicles with \
                 the slowest and the fastest of them (grey band).{marks} {what}."
            ),
        },
        ReportFigure {
            name: format!("space-time-{number}"),
            svg: figures::space_time(title, &traces, baseline.as_ref()),
            caption: format!(
                "Positions of all vehicles over time, coloured by speed, the ego vehicle outlined{compared}. The last \
                 colour includes all higher speeds. {what}."
            ),
        },
    ])
}

/// Returns the figures of speeds and positions along the ego's path on a network.
fn on_network(
    trial: &RecordedTrial,
    baseline: Option<&RecordedTrial>,
    what: &str,
    number: usize,
) -> Result<Vec<ReportFigure>, AnalysisError> {
    let Some(traces) = PathTraces::of(trial)? else { return Ok(Vec::new()) };
    let baseline = baseline.map(PathTraces::of).transpose()?.flatten();
    let marks = marked_moments(trial);
    let range =
        if trial.first_advice.is_some() { ", advised speed with its acceptable range (green band)," } else { "" };
    let compared = if baseline.is_some() { "; above as driven, below from the same seed without advice" } else { "" };
    let title = if baseline.is_some() { "As driven" } else { "" };
    let signals = if traces.signals.is_empty() { "" } else { " Horizontal bars show the signals at their stop lines." };
    Ok(vec![
        ReportFigure {
            name: format!("speeds-{number}"),
            svg: network_figures::speeds("", &traces, trial),
            caption: format!(
                "Speed of the ego vehicle{range} and mean speed of all vehicles on the network. The mean jumps when a \
                 vehicle enters or leaves.{marks} {what}."
            ),
        },
        ReportFigure {
            name: format!("space-time-{number}"),
            svg: network_figures::space_time(title, &traces, baseline.as_ref()),
            caption: format!(
                "Positions of all vehicles in the lanes of the ego vehicle's path over time, once a second, coloured \
                 by speed, the ego vehicle outlined{compared}. A line begins and ends where a vehicle enters and \
                 leaves the path.{signals} The last colour includes all higher speeds. {what}."
            ),
        },
    ])
}
