//! Report of an analysis. In: analysed drives. Out: HTML that opens off-line, with style and figures inside, and the methods as
//! plain text. Quantities have their titles; column names occur only in the data dictionary.

use super::{
    AnalysedRecording, AnalysisError, MEASURES, RoadKinds, StudyParticipants, drive_section,
    drivers::{self, ParticipantDriver},
    figures, glossary,
    methods::{self, interval},
    models_page,
    network::methods_text,
    page::{ReportFigure, ReportPage, STYLE, TableCells, short},
    planned::PlannedAnalysis,
    setup::joined_with_and,
    tables::{conditions, participants, per_participant, power, values},
};
use crate::{metrics::Estimate, plot::escaped};

/// Measures with a figure by condition.
const DRAWN: [&str; 11] = [
    "speed_gain_mps",
    "mean_speed_mps",
    "time_in_range",
    "speed_error_mps",
    "reaction_s",
    "enter_range_s",
    "min_gap_m",
    "reversals_per_min",
    "fuel_saved_l_100km",
    "ego_time_loss_s",
    "travel_time_s",
];
/// Measures with a power calculation.
const POWERED: [&str; 4] = ["mean_speed_mps", "time_in_range", "speed_error_mps", "reaction_s"];
/// Measures listed drive by drive: subject and names, one table each.
const LISTED: [(&str, &[&str]); 3] = [
    (
        "speed and advice",
        &["mean_speed_mps", "speed_gain_mps", "time_in_range", "speed_error_mps", "reaction_s", "enter_range_s"],
    ),
    (
        "following, steering and fuel",
        &["min_gap_m", "min_ttc_s", "sdlp_m", "reversals_per_min", "rms_jerk_mps3", "fuel_saved_l_100km", "contacts"],
    ),
    (
        "road networks",
        &[
            "ego_travel_time_s",
            "ego_time_loss_s",
            "travel_time_s",
            "line_flow_per_h",
            "red_lights",
            "speeding_s",
            "near_misses",
        ],
    ),
];
/// Largest number of conditions, or drives, beside each other in a table: more are wider than a sheet.
const BESIDE: usize = 4;
const NONE: &str = "–"; // Mark of a missing number.

/// Page of a report with its methods and figures.
pub struct StudyReport {
    /// Page as one HTML text.
    pub html: String,
    /// Methods as plain text.
    pub methods: String,
    /// File names and SVG texts of the figures.
    pub figures: Vec<(String, String)>,
}

/// Agreement of the analysed files with their checksums, and with a signature.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FileProof {
    /// Sentences on files that have changed or are not in their place.
    pub changed: Vec<String>,
    /// Sentence on the signer of the files, or on a missing signature; `None` if parts have changed and no signer was asked
    /// for.
    pub signature: Option<String>,
}

/// Makes the page.
///
/// # Errors
/// A recording whose figures are drawn cannot be read.
pub fn report(
    title: &str,
    drives: &[AnalysedRecording],
    study_participants: &StudyParticipants,
    proof: &FileProof,
    drivers: &[ParticipantDriver],
    planned: Option<&PlannedAnalysis>,
) -> Result<StudyReport, AnalysisError> {
    let mut page = ReportPage::default();
    page.put(&format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title><style>{STYLE}</style></head>\
         <body>\n<h1>{0}</h1>",
        escaped(title)
    ));
    let all: Vec<&AnalysedRecording> = drives.iter().collect();
    let is_study = is_of_several_people(drives);
    let of = if is_study { format!(" of {} participants", participants(&all)) } else { String::new() };
    page.paragraph(
        "note",
        &format!(
            "{}{of}, analysed with codrive {}. The <a href=\"#methods\">methods</a> are ready to be copied; every quantity is \
             defined in the <a href=\"#data-dictionary\">data dictionary</a>.",
            count(drives.len()),
            env!("CARGO_PKG_VERSION")
        ),
    );
    if !proof.changed.is_empty() {
        page.put("<p class=\"warning\"><b>What follows is not as it was written, or not where it belongs, and was analysed all the same:</b></p><ul>");
        proof.changed.iter().for_each(|what| page.put(&format!("<li>{}</li>", escaped(what))));
        page.put("</ul>");
    }
    if let Some(signature) = &proof.signature {
        page.paragraph("note", &format!("Files: {}.", escaped(signature)));
    }
    took_part(&mut page, study_participants);
    contacts(&mut page, drives);
    if let Some(planned) = planned {
        models_page::section(&mut page, planned);
    }
    let is_compared = is_study && !conditions(drives).is_empty();
    if is_compared {
        study(&mut page, drives);
    }
    drive_section::one_by_one(&mut page, drives, is_compared)?;
    scores(&mut page, study_participants);
    super::sickness::section(&mut page, study_participants);
    drivers::section(&mut page, drivers);
    every(&mut page, drives);
    let mut methods = methods::paragraphs(drives, study_participants, drivers);
    methods.extend(planned.map(models_page::paragraph));
    page.put("<section id=\"methods\">\n<h2>Methods (to copy)</h2>");
    page.paragraph("note lead", "The same text stands in the file methods.txt beside this page.");
    methods.iter().for_each(|text| page.put(&format!("<p>{}</p>", escaped(text))));
    page.put("</section>");
    dictionary(&mut page, drives);
    page.put("</body></html>");
    Ok(StudyReport { html: page.html, methods: methods.join("\n\n") + "\n", figures: page.figures })
}

/// Checks whether the drives have more than one participant.
pub(super) fn is_of_several_people(drives: &[AnalysedRecording]) -> bool {
    participants(&drives.iter().collect::<Vec<_>>()) > 1
}

/// Returns a number of drives in words.
pub fn count(drives: usize) -> String {
    if drives == 1 { "1 drive".into() } else { format!("{drives} drives") }
}

/// Returns a number of participants in words.
pub(super) fn people(n: usize) -> String {
    if n == 1 { "1 participant".into() } else { format!("{n} participants") }
}

/// Adds a paragraph on the participants by state, with a warning about simulated ones.
pub(super) fn took_part(page: &mut ReportPage, people: &StudyParticipants) {
    if people.is_rehearsal() {
        page.put("<p class=\"warning\"><b>A rehearsal: all participants are simulated, nobody drove.</b></p>");
    }
    if !people.all.is_empty() {
        let left_out = people.all.iter().any(|person| person.is_excluded());
        let left_out = if left_out { "; drives and answers of excluded ones are left out" } else { "" };
        page.paragraph("note", &format!("Participants: {}{left_out}.", escaped(&people.to_string())));
    }
}

/// Adds a warning that names the drives with contacts with other vehicles.
pub(super) fn contacts(page: &mut ReportPage, drives: &[AnalysedRecording]) {
    const MOST: usize = 20;
    let k = index("contacts");
    let of = |drive: &AnalysedRecording| drive.measures.values[k].filter(|count| *count > 0.0);
    let hit: Vec<String> = drives
        .iter()
        .filter_map(|drive| Some(format!("{} ({:.0})", escaped(&drive.found.title()), of(drive)?)))
        .collect();
    if hit.is_empty() {
        return;
    }
    let more = if hit.len() > MOST { format!(" and {} more", hit.len() - MOST) } else { String::new() };
    page.paragraph(
        "warning",
        &format!(
            "Contacts with other vehicles in {} of {}: {}{more}.",
            hit.len(),
            count(drives.len()),
            hit[..hit.len().min(MOST)].join(", ")
        ),
    );
}

/// Adds the scores of the questionnaires, over all participants who answered.
pub(super) fn scores(page: &mut ReportPage, people: &StudyParticipants) {
    let row = |score: &super::people::ScoreColumn| {
        let [low, high] = [f64::min, f64::max].map(|f| score.values.iter().copied().reduce(f).unwrap_or_default());
        let condition = if score.condition.is_empty() { String::new() } else { format!(", {}", score.condition) };
        let name = score.questionnaire.replace('_', " ") + &condition;
        let n = score.values.len();
        Some(vec![name, score.name.clone(), n.to_string(), estimate(&score.values)?, short(low), short(high)])
    };
    let rows: Vec<TableCells> = people.scores.iter().filter_map(row).collect();
    if rows.is_empty() {
        return;
    }
    page.put("<h2>Questionnaires</h2>");
    page.paragraph("lead", &format!("{} gives the scores of the questionnaires.", page.table_links(1)));
    page.table(
        &format!(
            "Scores of the questionnaires, of one that comes after every trial by condition: mean [{}], lowest and highest; N is the \
             number of participants.",
            interval()
        ),
        &cells(["Questionnaire", "Score", "N", "Mean", "Lowest", "Highest"]),
        &rows,
        &[1],
    );
}

/// Adds the section by condition: means, figures, power.
pub(super) fn study(page: &mut ReportPage, drives: &[AnalysedRecording]) {
    let conditions = conditions(drives);
    let trials: usize = conditions.iter().map(|(_, of)| of.len()).sum();
    page.put("<h2>By condition</h2>");
    let over_time = figures::over_time(drives);
    let drawn: Vec<ReportFigure> = DRAWN.into_iter().filter_map(|name| distribution(drives, name)).collect();
    let powered: Vec<TableCells> = POWERED.into_iter().flat_map(|name| powers(drives, index(name))).collect();
    let parts = conditions.chunks(BESIDE).count();
    let (lines, dots) = (usize::from(over_time.is_some()), drawn.len());
    let mut text = format!("{} the measures of each condition.", verb(&page.table_links(parts), parts, "give"));
    if lines > 0 {
        text += &format!(" {} shows the mean speed over time.", page.figure_links(0, 1));
    }
    if dots > 0 {
        // These figures follow the one of speed over time.
        text +=
            &format!(" {} the distribution of a measure each.", verb(&page.figure_links(lines, dots), dots, "show"));
    }
    page.paragraph("lead", &text);
    means(page, &conditions);
    if let Some(svg) = over_time {
        page.figure(ReportFigure {
            name: "speed-over-time".into(),
            svg,
            caption: format!(
                "Mean speed of all vehicles over time by condition. Lines: mean over participants of the means of some seconds, at \
                 least 5, drawn at their middle; bands: {}; dashed grey: the same drives without advice, where there are any. {}, \
                 {} in all.",
                interval(),
                numbers(&conditions, participants),
                count(trials)
            ),
        });
    }
    drawn.into_iter().for_each(|figure| page.figure(figure));
    if powered.is_empty() {
        return;
    }
    page.put("<h3>Detectable differences (power)</h3>");
    page.paragraph(
        "lead",
        &format!("{} gives the differences that a study like this one would detect.", page.table_links(1)),
    );
    let head = ["Measure", "Conditions", "N", "Difference", "SD", "with this N", "with 10", "with 25", "with 50"];
    let head: TableCells = head.into_iter().map(str::to_owned).chain(["N for this difference".into()]).collect();
    page.table(
        "Differences within participants (second condition less first): mean, standard deviation (N−1), the smallest difference that \
         is detected with a power of 80 % at a two-sided level of 5 % with so many participants (2.80 standard errors of the \
         difference; normal approximation, no correction for several comparisons), and the number of participants for which that is \
         the difference found. N is the number of participants with both conditions.",
        &head,
        &powered,
        &[1],
    );
}

/// Returns links with their verb: `Tables 1 and 2 give`, `Table 1 gives`.
pub(super) fn verb(links: &str, n: usize, verb: &str) -> String {
    format!("{links} {verb}{}", if n == 1 { "s" } else { "" })
}

/// Adds tables of the means of all measures, with at most [`BESIDE`] conditions in each.
fn means(page: &mut ReportPage, conditions: &[(String, Vec<&AnalysedRecording>)]) {
    let has_value = |k: &usize| conditions.iter().any(|(_, of)| !values(of, *k).is_empty());
    let measured: Vec<usize> = (0..MEASURES.len()).filter(has_value).collect();
    let roads = RoadKinds::of(conditions.iter().flat_map(|(_, of)| of.iter().copied()));
    let is_missing = |k: &usize| MEASURES[*k].is_on(roads) && !has_value(k);
    let without: Vec<String> = (0..MEASURES.len()).filter(is_missing).map(|k| MEASURES[k].title.to_owned()).collect();
    let parts = conditions.chunks(BESIDE).len();
    for (i, part) in conditions.chunks(BESIDE).enumerate() {
        let head = ["Measure".to_owned()].into_iter();
        let head = head.chain(part.iter().map(|(name, of)| format!("{name} (N = {})", participants(of)))).collect();
        let row = |k: &usize| {
            let cell = |(_, of): &(String, Vec<&AnalysedRecording>)| {
                let found = values(of, *k);
                // N of the measure, if some participants lack it.
                let n = if found.len() < participants(of) { format!(" (N = {})", found.len()) } else { String::new() };
                estimate(&found).map_or(NONE.into(), |text| text + &n)
            };
            [MEASURES[*k].label()].into_iter().chain(part.iter().map(cell)).collect()
        };
        let of = if parts > 1 { format!(", part {} of {parts}", i + 1) } else { String::new() };
        let missing = if i > 0 || without.is_empty() {
            String::new()
        } else {
            format!(" Without any value: {}.", joined_with_and(&without))
        };
        page.table(
            &format!(
                "Measures by condition{of}: mean over participants [{}]. N is the number of participants.{missing}",
                interval()
            ),
            &head,
            &measured.iter().map(row).collect::<Vec<_>>(),
            &[],
        );
    }
}

/// Returns the number of participants by condition; a single number if all are equal.
fn numbers(conditions: &[(String, Vec<&AnalysedRecording>)], of: impl Fn(&[&AnalysedRecording]) -> usize) -> String {
    let each: Vec<usize> = conditions.iter().map(|(_, drives)| of(drives)).collect();
    let (least, most) = (each.iter().min().copied().unwrap_or(0), each.iter().max().copied().unwrap_or(0));
    if least == most {
        format!("N = {} in each condition", people(least))
    } else if each.len() <= 6 {
        let counts: Vec<String> = conditions.iter().zip(&each).map(|((name, _), n)| format!("{n} ({name})")).collect();
        format!("N = {} participants", joined_with_and(&counts))
    } else {
        format!("N = {least} to {most} participants in a condition")
    }
}

fn distribution(drives: &[AnalysedRecording], name: &str) -> Option<ReportFigure> {
    let k = index(name);
    let n = numbers(&conditions(drives), |of| per_participant(of, k).len());
    Some(ReportFigure {
        name: format!("by-condition-{}", name.replace('_', "-")),
        svg: figures::distribution(drives, k)?,
        caption: format!(
            "{} by condition. Small dots: participants, joined by a line; large dots with bars: mean and its {}. {n}.",
            MEASURES[k].title,
            interval()
        ),
    })
}

pub(super) fn index(name: &str) -> usize {
    MEASURES.iter().position(|measure| measure.name == name).expect("a measure of the list")
}

fn powers(drives: &[AnalysedRecording], measure: usize) -> Vec<TableCells> {
    let row = |p: super::tables::StatisticalPower| {
        let needed = p.needed().filter(|n| *n < 10_000.0).map_or(NONE.into(), |n| n.to_string());
        let words = [MEASURES[p.measure].label(), format!("{} → {}", p.pair[0], p.pair[1]), p.n.to_string()];
        let numbers = [p.mean, p.sd, p.detectable(p.n), p.detectable(10), p.detectable(25), p.detectable(50)];
        words.into_iter().chain(numbers.map(short)).chain([needed]).collect()
    };
    power(drives, measure).into_iter().map(row).collect()
}

/// Adds the measures of every drive: up to [`BESIDE`] drives as columns with all measures, more as rows with some of them.
pub(super) fn every(page: &mut ReportPage, drives: &[AnalysedRecording]) {
    page.put(if drives.len() == 1 { "<h2>The drive in numbers</h2>" } else { "<h2>All drives</h2>" });
    let roads = RoadKinds::of(drives);
    let may_be = |name: &str| MEASURES[index(name)].is_on(roads);
    let listed: Vec<_> = LISTED.iter().filter(|(_, names)| names.iter().any(|name| may_be(name))).collect();
    let tables = if drives.len() <= BESIDE { 1 } else { listed.len() };
    let links = verb(&page.table_links(tables), tables, "give");
    let what = if drives.len() == 1 { "the measures of the drive" } else { "the measures of every drive" };
    let missing = methods_text::not_measured(roads);
    page.paragraph("lead", &format!("{links} {what}; {NONE} stands for a number that is not there.{missing}"));
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

/// Adds the definitions of all columns of the tables beside the page.
pub(super) fn dictionary(page: &mut ReportPage, drives: &[AnalysedRecording]) {
    page.put("<section id=\"data-dictionary\">\n<h2>Data dictionary</h2>");
    let tables = glossary::tables(drives);
    page.paragraph(
        "lead",
        &format!(
            "{} define the columns of the tables beside this page; the same stands in the file columns.json.",
            page.table_links(tables.len())
        ),
    );
    for table in tables {
        let row = |column: &glossary::ColumnDefinition| {
            vec![
                escaped(&column.title),
                format!("<code>{}</code>", escaped(&column.name)),
                glossary::unit_text(column.unit),
                escaped(&column.about),
            ]
        };
        page.marked_table(
            &format!("Columns of {}, in which a row is {}.", table.file, table.row),
            &cells(["Quantity", "Column", "Unit", "Definition"]),
            &table.columns.iter().map(row).collect::<Vec<_>>(),
            &[1, 2, 3],
        );
    }
    page.put("</section>");
}

fn cells<const N: usize>(words: [&str; N]) -> TableCells {
    words.map(str::to_owned).to_vec()
}

/// Returns mean and interval; a single number has no interval, and no number gives `None`.
pub(super) fn estimate(numbers: &[f64]) -> Option<String> {
    let e = Estimate::of(numbers)?;
    Some(if numbers.len() > 1 {
        format!("{} [{}, {}]", short(e.mean), short(e.low), short(e.high))
    } else {
        short(e.mean)
    })
}
