//! `codrive validate`: how like measured people traffic is. In: files of trajectories. Out: a table of moments beside those of people, or
//! JSON, and a report with figures.

use super::{CliError, out, progress::progress};
use crate::{
    analysis::report::{cells, judged, validation_report, write_page},
    metrics::traffic_moments::{
        COLUMNS, Judgement, MEASURED, MeasuredTraffic, VehicleTrajectories, platoon_speed_sd_mps, read_trajectories,
    },
    toml_text::did_you_mean,
};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use serde_json::json;
use std::path::{Path, PathBuf};

pub(super) fn command() -> Command {
    let file = || value_parser!(PathBuf);
    let number = |name: &'static str, value: &'static str| {
        Arg::new(name).long(name).value_name(value).value_parser(value_parser!(f64)).allow_negative_numbers(true)
    };
    Command::new("validate")
        .about("Compare trajectories in one lane with measured people: how like people is the traffic?")
        .after_help(format!(
            "A file of trajectories is CSV with the columns {}; .gz is read, too.\n\
             Each vehicle has a row at each step of time, in even steps of at most 0.5 s. leader is the vehicle ahead, \
             and gap_m the distance from the front bumper to its rear. The first vehicle of a platoon has neither.\n\
             Several files are runs of the same traffic: their mean is judged.\n\n\
             scripts/measured-trajectories makes such files from public data.\n\
             Definitions of all moments: docs/measures.md. Sources: docs/references.md, people.\n\n\
             Example:\n  \
             codrive validate ring.csv.gz --ring 260 --from 30 --to 390 --out like-people",
            COLUMNS.join(", ")
        ))
        .arg(
            Arg::new("file")
                .value_name("FILE.csv")
                .required(true)
                .num_args(1..)
                .value_parser(file())
                .help("Trajectories of vehicles in one lane"),
        )
        .arg(number("ring", "METRES").help("Length of the ring; without it, there is no wave speed"))
        .arg(number("from", "SECONDS").default_value("0").help("Start of the compared part, since the first row"))
        .arg(number("to", "SECONDS").help("End of the compared part [default: the end of the file]"))
        .arg(
            Arg::new("people")
                .long("people")
                .value_name("NAME")
                .default_value(MEASURED[0].name)
                .help(format!("Measured people: {}", names().join(" or "))),
        )
        .arg(Arg::new("json").long("json").action(ArgAction::SetTrue).help("Print JSON instead of a table"))
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("DIR")
                .value_parser(file())
                .help("Folder for report.html, moments.json and figures"),
        )
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let people = people(matches.get_one::<String>("people").map_or("", String::as_str))?;
    let files: Vec<&PathBuf> = matches.get_many("file").into_iter().flatten().collect();
    let bar = progress(files.len() as u64, "files".into());
    let read = |file: &&PathBuf| {
        let run = run(file, matches);
        bar.inc(1);
        run
    };
    let runs = files.iter().map(read).collect::<Result<Vec<_>, _>>();
    bar.finish_and_clear();
    let runs = runs?;
    let judgements = judged(people, &runs);
    let platoons: Vec<Vec<f64>> = runs.iter().map(platoon_speed_sd_mps).filter(|sds| sds.len() > 1).collect();
    let json = json!({
        "people": people.name, "runs": runs.len(), "moments": judgements, "platoon_speed_sd_mps": platoons,
    });
    let json = format!("{json:#}\n");
    match matches.get_flag("json") {
        true => out::text(&json)?,
        false => out::text(table(people, &judgements))?,
    }
    for sds_mps in platoons.iter().filter(|_| !matches.get_flag("json")) {
        let texts: Vec<String> = sds_mps.iter().map(|sd| format!("{sd:.2}")).collect();
        out::line(format_args!("standard deviation of speed down the platoon: {} m/s", texts.join(" ")))?;
    }
    let Some(folder) = matches.get_one::<PathBuf>("out") else { return Ok(()) };
    let name = files[0].file_name().unwrap_or_default().to_string_lossy();
    let page = validation_report(&name, people, &runs, &judgements);
    let png = |svg: &str| super::desktop::png(svg).map(|png| png.map_err(|why| why.to_string()));
    write_page(folder, &page.html, &page.figures, png)?;
    crate::record::replace(&folder.join("moments.json"), json.as_bytes())?;
    out::status_line(format_args!("{}: report.html, moments.json and figures", folder.display()));
    Ok(())
}

fn names() -> Vec<&'static str> {
    MEASURED.iter().map(|people| people.name).collect()
}

fn people(name: &str) -> Result<&'static MeasuredTraffic, CliError> {
    MEASURED.into_iter().find(|people| people.name == name).ok_or_else(|| {
        let near = did_you_mean(name, &names());
        CliError::Input(format!("--people {name}: unknown{near}; allowed: {}", names().join(", ")))
    })
}

/// Reads the compared part of a file.
fn run(file: &Path, matches: &ArgMatches) -> Result<VehicleTrajectories, CliError> {
    let number = |name: &str| matches.get_one::<f64>(name).copied();
    let ring_m = number("ring");
    if ring_m.is_some_and(|ring_m| !(10.0..=100_000.0).contains(&ring_m)) {
        return Err(CliError::Input("--ring: allowed: 10 to 100000 m".into()));
    }
    let all = read_trajectories(file, ring_m).map_err(|fault| CliError::Input(fault.to_string()))?;
    let end_s = all.steps() as f64 * all.step_s;
    let (from_s, to_s) = (number("from").unwrap_or(0.0), number("to").unwrap_or(end_s));
    if !(0.0 <= from_s && from_s < to_s && to_s <= end_s + all.step_s) {
        let what = format!("--from {from_s} --to {to_s}: {} lasts {end_s:.1} s", file.display());
        return Err(CliError::Input(format!("{what}; allowed: 0 <= from < to <= {end_s:.1}")));
    }
    Ok(all.between(from_s, to_s))
}

/// Returns the moments as a table for a terminal.
fn table(people: &MeasuredTraffic, judgements: &[Judgement]) -> String {
    let head = ["moment", "people", "their halves", "like people", "model", "runs", "within"].map(String::from);
    let rows: Vec<[String; 7]> = std::iter::once(head).chain(judgements.iter().map(cells)).collect();
    let width = |k: usize| rows.iter().map(|row| row[k].chars().count()).max().unwrap_or(0);
    let widths: [usize; 7] = std::array::from_fn(width);
    let line = |row: &[String; 7]| {
        let cell = |(k, cell): (usize, &String)| match k {
            0 => format!("{cell:<width$}", width = widths[k]),
            _ => format!("  {cell:>width$}", width = widths[k]),
        };
        format!("{}\n", row.iter().enumerate().map(cell).collect::<String>())
    };
    let judged = || judgements.iter().filter_map(|judgement| judgement.within);
    let [within, all] = [judged().filter(|within| *within).count(), judged().count()];
    let table: String = rows.iter().map(line).collect();
    format!("{table}{within} of {all} moments with a criterion are like people ({})\n", people.title)
}
