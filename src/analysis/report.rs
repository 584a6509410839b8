//! One page that says it all. In: analysed drives. Out: HTML that opens off-line: style and figures are in it.

use super::{
    Analysed, AnalysisError, MEASURES, People, Trial, figures,
    tables::{conditions, power, values},
    traces::DriveTraces,
};
use crate::train::Estimate;
use std::{fmt::Write, path::PathBuf};

/// Measures that are drawn by condition.
const DRAWN: [&str; 9] = [
    "speed_gain_mps",
    "mean_speed_mps",
    "time_in_range",
    "speed_error_mps",
    "reaction_s",
    "enter_range_s",
    "min_gap_m",
    "reversals_per_min",
    "fuel_saved_l_100km",
];
/// Measures whose power is reckoned.
const POWERED: [&str; 4] = ["mean_speed_mps", "time_in_range", "speed_error_mps", "reaction_s"];

const STYLE: &str = "body{font:15px/1.5 Helvetica,Arial,sans-serif;color:#222;max-width:1180px;margin:2em auto;padding:0 1.5em}\
h1{font-size:1.7em;margin-bottom:.2em}h2{margin-top:2em;border-bottom:1px solid #ccc}\
table{border-collapse:collapse;font-size:13px;margin:.6em 0}th,td{padding:.25em .7em;border-bottom:1px solid #ddd;text-align:right;vertical-align:top}\
th{border-bottom:1.5px solid #555}td:first-child,th:first-child,td.t,th.t{text-align:left}\
.grid{display:flex;flex-wrap:wrap;gap:8px 18px}.wide{overflow-x:auto}svg{max-width:100%;height:auto}.note{color:#555;font-size:13px}.warning{color:#a00}";

/// A page and the figures in it, by their file names.
pub struct Report {
    /// The page.
    pub html: String,
    /// Names and texts of the figures.
    pub figures: Vec<(String, String)>,
}

struct Page {
    html: String,
    figures: Vec<(String, String)>,
}

impl Page {
    fn put(&mut self, text: &str) {
        self.html.push_str(text);
        self.html.push('\n');
    }

    fn figure(&mut self, name: &str, svg: Option<String>) {
        let Some(svg) = svg else { return };
        // Names within a picture are names of the whole page here.
        let n = self.figures.len();
        let inline = svg.replace("id=\"f", &format!("id=\"p{n}f")).replace("url(#f", &format!("url(#p{n}f"));
        let _ = writeln!(self.html, "<div>{inline}</div>");
        self.figures.push((format!("{name}.svg"), svg));
    }
}

/// Makes the page.
///
/// # Errors
/// A recording whose ways are drawn cannot be read.
pub fn report(title: &str, drives: &[Analysed], who: &People, changed: &[String]) -> Result<Report, AnalysisError> {
    let mut page = Page { html: String::new(), figures: Vec::new() };
    let mut people: Vec<&str> = drives.iter().map(|drive| drive.found.participant.as_str()).collect();
    people.dedup();
    page.put(&format!(
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title><style>{STYLE}</style></head>\
         <body>\n<h1>{0}</h1>\n<p class=\"note\">{1}{2}; codrive {3}. Every measure is defined at the end.</p>",
        escaped(title),
        count(drives.len()),
        if people.len() > 1 { format!(" of {} participants", people.len()) } else { String::new() },
        env!("CARGO_PKG_VERSION")
    ));
    participants(&mut page, who);
    contacts(&mut page, drives);
    if !changed.is_empty() {
        page.put("<p class=\"warning\"><b>These files are not as they were written, and were analysed all the same:</b></p><ul>");
        changed.iter().for_each(|what| page.put(&format!("<li>{}</li>", escaped(what))));
        page.put("</ul>");
    }
    if !conditions(drives).is_empty() && people.len() > 1 {
        study(&mut page, drives);
        page.put("<h2>One participant's trials</h2>");
    } else {
        page.put("<h2>Drives</h2>");
    }
    let trials: Vec<&Analysed> = drives.iter().filter(|drive| drive.found.participant == people[0]).collect();
    let shown: Vec<&&Analysed> =
        trials.iter().filter(|drive| people.len() == 1 || drive.found.baseline.is_some()).collect();
    for (i, drive) in shown.into_iter().enumerate() {
        one(&mut page, drive, i + 1)?;
    }
    scores(&mut page, who);
    page.put("<h2>All drives</h2>");
    all(&mut page, drives);
    definitions(&mut page);
    page.put("</body></html>");
    Ok(Report { html: page.html, figures: page.figures })
}

/// Whose drives these are, and whose are not among them.
fn participants(page: &mut Page, people: &People) {
    if people.is_rehearsal() {
        page.put("<p class=\"warning\"><b>A rehearsal: all participants are simulated, nobody drove.</b></p>");
    }
    if !people.all.is_empty() {
        let left_out = people.all.iter().any(|person| person.is_excluded());
        let left_out = if left_out { "; drives and answers of excluded ones are left out" } else { "" };
        page.put(&format!("<p class=\"note\">Participants: {}{left_out}.</p>", escaped(&people.words())));
    }
}

/// Which drives had contacts with other cars.
fn contacts(page: &mut Page, drives: &[Analysed]) {
    const MOST: usize = 20;
    let k = index("contacts");
    let of = |drive: &Analysed| drive.measures.values[k].filter(|count| *count > 0.0);
    let hit: Vec<String> = drives
        .iter()
        .filter_map(|drive| Some(format!("{} ({})", escaped(&drive.found.title()), short_count(of(drive)?))))
        .collect();
    if hit.is_empty() {
        return;
    }
    let more = if hit.len() > MOST { format!(" and {} more", hit.len() - MOST) } else { String::new() };
    page.put(&format!(
        "<p class=\"warning\">Contacts with other cars in {} of {}: {}{more}.</p>",
        hit.len(),
        count(drives.len()),
        hit[..hit.len().min(MOST)].join(", ")
    ));
}

fn short_count(count: f64) -> String {
    format!("{count:.0}")
}

/// Scores of the questionnaires, over all participants who answered.
fn scores(page: &mut Page, people: &People) {
    if people.scores.iter().all(|score| score.values.is_empty()) {
        return;
    }
    page.put(
        "<h2>Questionnaires</h2>\n<p class=\"note\">Mean over participants [its 95 % interval by bootstrap], lowest and \
         highest.</p>\n<table><tr><th>questionnaire</th><th class=\"t\">score</th><th>n</th><th>mean</th><th>lowest</th>\
         <th>highest</th></tr>",
    );
    for score in &people.scores {
        let Some(e) = Estimate::of(&score.values) else { continue };
        let [low, high] = [f64::min, f64::max].map(|f| score.values.iter().copied().reduce(f).unwrap_or_default());
        page.put(&format!(
            "<tr><td>{}</td><td class=\"t\">{}</td><td>{}</td><td>{} [{}, {}]</td><td>{}</td><td>{}</td></tr>",
            escaped(&score.questionnaire),
            escaped(&score.name),
            score.values.len(),
            short(e.mean),
            short(e.low),
            short(e.high),
            short(low),
            short(high)
        ));
    }
    page.put("</table>");
}

/// So many drives, in words.
pub fn count(drives: usize) -> String {
    if drives == 1 { "1 drive".into() } else { format!("{drives} drives") }
}

fn study(page: &mut Page, drives: &[Analysed]) {
    let conditions = conditions(drives);
    page.put("<h2>By condition</h2>\n<p class=\"note\">Mean over participants [its 95 % interval by bootstrap].</p>\n<div class=\"wide\"><table><tr><th>measure</th>");
    for (name, of) in &conditions {
        page.put(&format!("<th>{} (n = {})</th>", escaped(name), of.len()));
    }
    page.put("</tr>");
    for (k, measure) in MEASURES.iter().enumerate() {
        let unit = if measure.unit.is_empty() { String::new() } else { format!(", {}", measure.unit) };
        let mut row = format!("<tr><td>{}{unit}</td>", measure.title);
        for (_, of) in &conditions {
            let found = values(of, k);
            // Where some trials have no such number, how many have.
            let n = if found.len() < of.len() { format!(" (n = {})", found.len()) } else { String::new() };
            let cell = Estimate::of(&found)
                .map_or("–".into(), |e| format!("{} [{}, {}]{n}", short(e.mean), short(e.low), short(e.high)));
            let _ = write!(row, "<td>{cell}</td>");
        }
        page.put(&(row + "</tr>"));
    }
    page.put("</table></div>\n<h2>Mean speed of all cars over time</h2>");
    page.figure("speed-over-time", figures::over_time(drives));
    page.put("<h2>Distributions</h2>\n<p class=\"note\">Each dot is a trial, lines join a participant's; beside them the mean and its 95 % interval.</p>\n<div class=\"grid\">");
    for name in DRAWN {
        let k = index(name);
        page.figure(&format!("by-condition-{}", name.replace('_', "-")), figures::distribution(drives, k));
    }
    page.put("</div>");
    powers(page, drives);
}

fn index(name: &str) -> usize {
    MEASURES.iter().position(|measure| measure.name == name).expect("a measure of the list")
}

fn powers(page: &mut Page, drives: &[Analysed]) {
    page.put(
        "<h2>Detectable differences (power)</h2>\n<p class=\"note\">Differences within participants (second condition less first), and the \
         smallest difference that would be seen with a power of 80 % at 5 % on two sides: 2.80 standard errors of \
         the difference (normal approximation, no correction for several comparisons).</p>\n<div class=\"wide\"><table><tr><th>measure</th>\
         <th class=\"t\">conditions</th><th>n</th><th>difference</th><th>SD</th><th>seen with n</th><th>with 10</th>\
         <th>with 25</th><th>with 50</th><th>n for this difference</th></tr>",
    );
    for name in POWERED {
        for p in power(drives, index(name)) {
            let unit = MEASURES[p.measure].unit;
            let needed = p.needed().filter(|n| *n < 10_000.0).map_or("–".into(), |n| n.to_string());
            page.put(&format!(
                "<tr><td>{}{}</td><td class=\"t\">{} → {}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{needed}</td></tr>",
                MEASURES[p.measure].title,
                if unit.is_empty() { String::new() } else { format!(", {unit}") },
                escaped(&p.pair[0]),
                escaped(&p.pair[1]),
                p.n,
                short(p.mean),
                short(p.sd),
                short(p.detectable(p.n)),
                short(p.detectable(10)),
                short(p.detectable(25)),
                short(p.detectable(50)),
            ));
        }
    }
    page.put("</table></div>");
}

/// One drive: ways, speeds, mean speed with and without advice.
fn one(page: &mut Page, drive: &Analysed, number: usize) -> Result<(), AnalysisError> {
    let title = drive.found.title();
    let trial = Trial::open(&drive.found.recording)?;
    let traces = DriveTraces::of(&trial)?;
    let of_baseline = |folder: &PathBuf| DriveTraces::of(&Trial::open(folder)?);
    let baseline = drive.found.baseline.as_ref().map(of_baseline).transpose()?.flatten();
    page.put(&format!("<h3>{}</h3>", escaped(&title)));
    if !trial.contacts_at.is_empty() {
        let each: Vec<String> =
            trial.contacts_at.iter().map(|[at_s, mps]| format!("at {at_s:.1} s with {mps:.1} m/s")).collect();
        let more = if trial.contacts > each.len() { ", ..." } else { "" };
        page.put(&format!("<p class=\"warning\">Contacts: {}{more}</p>", each.join(", ")));
    }
    if let Some(traces) = traces {
        page.figure(&format!("speeds-{number}"), Some(figures::speeds("Speed and advice", &traces, &trial)));
        let ways = figures::space_time("With advice", &traces, baseline.as_ref());
        page.figure(&format!("space-time-{number}"), Some(ways));
    }
    page.figure(&format!("mean-speed-{number}"), Some(figures::gain("Mean speed of all cars", drive)));
    Ok(())
}

fn all(page: &mut Page, drives: &[Analysed]) {
    let columns: Vec<usize> =
        DRAWN.iter().chain(&["min_ttc_s", "sdlp_m", "rms_jerk_mps3", "contacts"]).map(|n| index(n)).collect();
    page.put("<div class=\"wide\"><table><tr><th>drive</th><th>s</th>");
    for k in &columns {
        page.put(&format!("<th>{}</th>", MEASURES[*k].name.replace('_', " ")));
    }
    page.put("</tr>");
    for drive in drives {
        let mut row = format!("<tr><td>{}</td><td>{}</td>", escaped(&drive.found.title()), short(drive.duration_s));
        for k in &columns {
            let _ = write!(row, "<td>{}</td>", drive.measures.values[*k].map_or("–".into(), short));
        }
        page.put(&(row + "</tr>"));
    }
    page.put("</table></div>");
}

fn definitions(page: &mut Page) {
    page.put(
        "<h2>Definitions</h2>\n<table><tr><th>name</th><th class=\"t\">unit</th><th class=\"t\">definition</th></tr>",
    );
    for measure in MEASURES {
        page.put(&format!(
            "<tr><td><code>{}</code></td><td class=\"t\">{}</td><td class=\"t\">{}</td></tr>",
            measure.name,
            measure.unit,
            escaped(measure.about)
        ));
    }
    page.put("</table>");
}

/// Three digits that count.
fn short(value: f64) -> String {
    let text = match value.abs() {
        v if v >= 100.0 => format!("{value:.0}"),
        v if v >= 10.0 => format!("{value:.1}"),
        v if v >= 1.0 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    };
    if text.trim_start_matches('-').chars().all(|c| "0.".contains(c)) { "0".into() } else { text }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
#[path = "page_tests.rs"]
mod tests;
