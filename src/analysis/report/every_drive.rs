//! Report section of all drives in numbers. In: analysed drives. Out: tables of their measures.

use super::{
    network_text,
    page::{ReportPage, short},
    words::{BESIDE, NONE, verb},
};
use crate::analysis::{
    drives::{AnalysedRecording, is_of_several_people, participants, road_kinds},
    measures::{MEASURES, index},
    text::{count, people},
};

/// Measures listed drive by drive: subject and names, one table each.
const LISTED: [(&str, &[&str]); 3] = [
    (
        "speed and advice",
        &["mean_speed_mps", "speed_gain_mps", "time_in_range", "speed_error_mps", "reaction_s", "enter_range_s"],
    ),
    (
        "following, steering and fuel",
        &[
            "min_gap_m",
            "min_ttc_s",
            "sdlp_m",
            "reversals_per_min",
            "rms_jerk_mps3",
            "fuel_saved_l_100km",
            "contact_count",
        ],
    ),
    (
        "road networks",
        &[
            "ego_travel_time_s",
            "ego_time_loss_s",
            "travel_time_s",
            "line_passages_per_h",
            "red_lights",
            "speeding_s",
            "near_misses",
        ],
    ),
];

/// Adds the measures of every drive: up to [`BESIDE`] drives as columns with all measures, more as rows with some of them.
pub(super) fn every(page: &mut ReportPage, drives: &[AnalysedRecording]) {
    page.put(if drives.len() == 1 { "<h2>The drive in numbers</h2>" } else { "<h2>All drives</h2>" });
    let roads = road_kinds(drives);
    let may_be = |name: &str| MEASURES[index(name)].is_on(roads);
    let listed: Vec<_> = LISTED.iter().filter(|(_, names)| names.iter().any(|name| may_be(name))).collect();
    let tables = if drives.len() <= BESIDE { 1 } else { listed.len() };
    let links = verb(&page.table_links(tables), tables, "give");
    let what = if drives.len() == 1 { "the measures of the drive" } else { "the measures of every drive" };
    let missing = network_text::not_measured(roads);
    page.paragraph("lead", &format!("{links} {what}; {NONE} marks a missing value.{missing}"));
    let n = count_of(drives);
    if drives.len() <= BESIDE {
        let row = |k: usize| {
            let values = drives.iter().map(|drive| drive.measures.values[k].map_or(NONE.into(), short));
            [MEASURES[k].label()].into_iter().chain(values).collect()
        };
        let titles = drives.iter().map(|drive| drive.found.title());
        page.table(
            &format!("Measures of every drive. {n}."),
            &["Measure".to_owned()].into_iter().chain(titles).collect(),
            &(0..MEASURES.len()).filter(|k| MEASURES[*k].is_on(roads)).map(row).collect::<Vec<_>>(),
            &[],
        );
        return;
    }
    for (what, names) in listed {
        let columns: Vec<usize> = names.iter().filter(|name| may_be(name)).map(|name| index(name)).collect();
        let head = ["Drive".to_owned(), "Duration, s".to_owned()].into_iter();
        let row = |drive: &AnalysedRecording| {
            let values = columns.iter().map(|k| drive.measures.values[*k].map_or(NONE.into(), short));
            [drive.found.title(), short(drive.duration_s)].into_iter().chain(values).collect()
        };
        page.table(
            &format!("Measures of every drive: {what}. {n}."),
            &head.chain(columns.iter().map(|k| MEASURES[*k].label())).collect(),
            &drives.iter().map(row).collect::<Vec<_>>(),
            &[],
        );
    }
}

fn count_of(drives: &[AnalysedRecording]) -> String {
    let all: Vec<&AnalysedRecording> = drives.iter().collect();
    let of = if is_of_several_people(drives) { format!(" of {}", people(participants(&all))) } else { String::new() };
    format!("N = {}{of}", count(drives.len()))
}
