//! `codrive validate`: how like measured people traffic is. In: files of trajectories, or traffic drivers, whose rings are simulated. Out: a
//! table of moments beside those of people, or JSON, and a report with figures.

use super::{CliError, fit, out, progress::progress};
use crate::{
    analysis::report::{judged, table_rows, validation_report, write_page},
    idm::IdmParams,
    metrics::traffic_moments::{
        COLUMNS, Judgement, MEASURED, MeasuredTraffic, VehicleTrajectories, platoon_speed_sd_mps, read_trajectories,
    },
    toml_text::did_you_mean,
    traffic::{RING_STUDY, TrafficDrivers, population_names},
    train::{platoon_trajectories, ring_trajectories},
};
use clap::{Arg, ArgAction, ArgMatches, Command, parser::ValueSource, value_parser};
use serde_json::json;
use std::path::{Path, PathBuf};

pub(super) fn command() -> Command {
    let file = || value_parser!(PathBuf);
    let number = |name: &'static str, value: &'static str| {
        Arg::new(name).long(name).value_name(value).value_parser(value_parser!(f64)).allow_negative_numbers(true)
    };
    let command = Command::new("validate")
        .about("Compare traffic in one lane with measured people: how like people is it?")
        .after_help(format!(
            "A file of trajectories is CSV with the columns {}; .gz is read, too.\n\
             Each vehicle has a row at each step of time, in even steps of at most 0.5 s. leader is the vehicle ahead, \
             and gap_m the distance from the front bumper to its rear. The first vehicle of a platoon has neither.\n\
             Several files are runs of the same traffic: their mean is judged.\n\n\
             --traffic-drivers simulates the ring of the measured people with these drivers instead, and with those of the ring \
             study beside them. With the file of a platoon, it simulates the followers behind the recorded first vehicle, without a fit.\n\n\
             --fit searches the numbers of a population of drivers whose rings are like the file, by simulated moments, and writes it for \
             --traffic-drivers. A fit takes minutes; Ctrl-C ends it with the best so far.\n\n\
             scripts/measured-trajectories makes such files from public data.\n\
             Definitions of all moments: docs/measures.md. Sources: docs/references.md, people.\n\n\
             Examples:\n  \
             codrive validate --traffic-drivers safe-followers\n  \
             codrive validate ring.csv.gz --ring 260 --from 30 --to 390 --out like-people\n  \
             codrive validate ring.csv.gz --ring 260 --from 30 --to 390 --fit mine.toml",
            COLUMNS.join(", ")
        ))
        .arg(
            Arg::new("file")
                .value_name("FILE.csv")
                .required_unless_present("traffic-drivers")
                .num_args(1..)
                .value_parser(file())
                .help("Trajectories of vehicles in one lane"),
        )
        .arg(
            Arg::new("traffic-drivers")
                .long("traffic-drivers")
                .value_name("NAME|FILE.toml")
                .conflicts_with("ring")
                .help(format!("Drivers to simulate: {}, or a population's file", population_names().join(", "))),
        )
        .arg(
            Arg::new("runs")
                .long("runs")
                .value_name("N")
                .default_value("10")
                .value_parser(value_parser!(u32).range(1..=1000))
                .requires("traffic-drivers")
                .help("Simulated runs, each with persons and noise of its own"),
        )
        .arg(number("ring", "METRES").help("Length of the ring; without it, there is no wave speed"))
        .arg(number("from", "SECONDS").requires("file").help("Start of the compared part, since the first row [default: 0]"))
        .arg(number("to", "SECONDS").requires("file").help("End of the compared part [default: the end of the file]"))
        .arg(
            Arg::new("people")
                .long("people")
                .value_name("NAME")
                .help(format!(
                    "Measured people: {} [default: those of the drivers' name, otherwise {}]",
                    names().join(" or "),
                    MEASURED[0].name
                )),
        )
        .arg(Arg::new("json").long("json").action(ArgAction::SetTrue).help("Print JSON instead of a table"))
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("DIR")
                .value_parser(file())
                .help("Folder for report.html, moments.json and figures"),
        );
    fit::with_flags(command)
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    if fit::is_wanted(matches) {
        let file = matches.get_many::<PathBuf>("file").into_iter().flatten().next();
        return file.map_or(Ok(()), |file| fit::main(matches, file, &run(file, matches)?));
    }
    let text = |name: &str| matches.get_one::<String>(name).map(String::as_str);
    let drivers = text("traffic-drivers");
    if let (Some(name), Some(files)) = (drivers, matches.get_many::<PathBuf>("file")) {
        return files.into_iter().try_for_each(|file| behind_recorded(name, file, matches));
    }
    let known = drivers.filter(|name| names().contains(name));
    let people = people(text("people").or(known).unwrap_or(MEASURED[0].name))?;
    let runs = match drivers {
        Some(name) => simulated(name, people, matches)?,
        None => files(matches)?,
    };
    let judgements = judged(people, &runs);
    let beside = match drivers {
        Some(name) if name != RING_STUDY => judged(people, &simulated(RING_STUDY, people, matches)?),
        _ => Vec::new(),
    };
    let platoons: Vec<Vec<f64>> = runs.iter().map(platoon_speed_sd_mps).filter(|sds| sds.len() > 1).collect();
    let json = json!({
        "people": people.name, "traffic_drivers": drivers, "runs": runs.len(), "moments": judgements,
        "moments_of_ring_study": beside, "platoon_speed_sd_mps": platoons,
    });
    let json = format!("{json:#}\n");
    match matches.get_flag("json") {
        true => out::text(&json)?,
        false => out::text(table(people, &judgements, &beside))?,
    }
    for sds_mps in platoons.iter().filter(|_| !matches.get_flag("json")) {
        let texts: Vec<String> = sds_mps.iter().map(|sd| format!("{sd:.2}")).collect();
        out::line(format_args!("standard deviation of speed down the platoon: {} m/s", texts.join(" ")))?;
    }
    let Some(folder) = matches.get_one::<PathBuf>("out") else { return Ok(()) };
    let first = matches.get_many::<PathBuf>("file").into_iter().flatten().next();
    let file = first.and_then(|file| Some(file.file_name()?.to_string_lossy().into_owned()));
    let name = file.or(drivers.map(str::to_owned)).unwrap_or_default();
    let page = validation_report(&name, people, &runs, &judgements, &beside);
    let png = |svg: &str| super::desktop::png(svg).map(|png| png.map_err(|why| why.to_string()));
    write_page(folder, &page.html, &page.figures, png)?;
    crate::record::replace(&folder.join("moments.json"), json.as_bytes())?;
    out::status_line(format_args!("{}: report.html, moments.json and figures", folder.display()));
    Ok(())
}

/// Reads the files, a run each.
fn files(matches: &ArgMatches) -> Result<Vec<VehicleTrajectories>, CliError> {
    let files: Vec<&PathBuf> = matches.get_many("file").into_iter().flatten().collect();
    let bar = progress(files.len() as u64, "files".into());
    let read = |file: &&PathBuf| {
        let run = run(file, matches);
        bar.inc(1);
        run
    };
    let runs = files.iter().map(read).collect::<Result<Vec<_>, _>>();
    bar.finish_and_clear();
    runs
}

/// Simulates the ring of the measured people with these drivers, the part that was measured.
fn simulated(name: &str, people: &MeasuredTraffic, matches: &ArgMatches) -> Result<Vec<VehicleTrajectories>, CliError> {
    let drivers = TrafficDrivers::named(name, IdmParams::default()).map_err(|error| CliError::Input(error.0))?;
    let runs = matches.get_one::<u32>("runs").copied().unwrap_or(1) as usize;
    let [from_s, to_s] = people.from_to_s;
    let all = ring_trajectories(&drivers, (people.vehicles, people.ring_m), to_s, (1, runs));
    Ok(all.iter().map(|run| run.between(from_s, to_s)).collect())
}

/// Prints the standard deviations of speed down a platoon, of the people and of simulated followers behind the recorded first vehicle.
fn behind_recorded(name: &str, file: &Path, matches: &ArgMatches) -> Result<(), CliError> {
    if let Some(flag) = ["json", "out", "people"].into_iter().find(|flag| is_given(matches, flag)) {
        return Err(CliError::Input(format!(
            "--{flag} is for rings; a platoon is compared with the people of its file"
        )));
    }
    let recorded = run(file, matches)?;
    let people_mps = platoon_speed_sd_mps(&recorded);
    if people_mps.len() < 2 || people_mps.len() < recorded.vehicles.len() {
        let text = "the vehicles form no platoon; allowed with --traffic-drivers: one vehicle without a leader, each other one behind another";
        return Err(CliError::Input(format!("{}: {text}", file.display())));
    }
    let drivers = TrafficDrivers::named(name, IdmParams::default()).map_err(|error| CliError::Input(error.0))?;
    let runs = matches.get_one::<u32>("runs").copied().unwrap_or(1);
    let mut model_mps = vec![0.0; people_mps.len()];
    for seed in 1..=u64::from(runs) {
        let sds_mps = platoon_speed_sd_mps(&platoon_trajectories(&recorded, &drivers, seed));
        model_mps.iter_mut().zip(sds_mps).for_each(|(mean, sd)| *mean += sd / f64::from(runs));
    }
    out::line(format_args!("{}: standard deviation of speed down the platoon, m/s", file.display()))?;
    out::line(format_args!("vehicle  people   model"))?;
    for (k, (people, model)) in people_mps.iter().zip(&model_mps).enumerate() {
        let note = if k == 0 { "recorded".to_owned() } else { format!("{:+.1} %", 100.0 * (model / people - 1.0)) };
        out::line(format_args!("{:>7}  {people:>6.2}  {model:>6.2}  {note}", k + 1))?;
    }
    Ok(())
}

/// Checks whether a flag stands on the command line.
fn is_given(matches: &ArgMatches, flag: &str) -> bool {
    matches.value_source(flag) == Some(ValueSource::CommandLine)
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

/// Returns the moments as a table for a terminal, and those of the ring study if they stand beside.
fn table(people: &MeasuredTraffic, judgements: &[Judgement], beside: &[Judgement]) -> String {
    let rows = table_rows(judgements, beside);
    let width = |k: usize| rows.iter().map(|row| row[k].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..rows[0].len()).map(width).collect();
    let line = |row: &Vec<String>| {
        let cell = |(k, cell): (usize, &String)| match k {
            0 => format!("{cell:<width$}", width = widths[k]),
            _ => format!("  {cell:>width$}", width = widths[k]),
        };
        format!("{}\n", row.iter().enumerate().map(cell).collect::<String>())
    };
    let count = |judgements: &[Judgement]| {
        let judged = || judgements.iter().filter_map(|judgement| judgement.within);
        format!("{} of {}", judged().filter(|within| *within).count(), judged().count())
    };
    let table: String = rows.iter().map(line).collect();
    let study = if beside.is_empty() { String::new() } else { format!("; of the ring study {}", count(beside)) };
    format!("{table}{} moments with a criterion are like people ({}){study}\n", count(judgements), people.title)
}
