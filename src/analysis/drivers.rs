//! Participants as simulated drivers. In: analysed drives. Out: a [`ParticipantDriver`] for each participant; the rows of
//! `drivers.csv`; `drivers.toml`, with which a rehearsal drives as these participants did; their section of the page and
//! paragraph of the methods.

use super::{
    AnalysedRecording,
    driver_fit::{FoundDriver, FoundNumber, GROUPS, LEAST_S, fit},
    driver_moments::DriverStretches,
    glossary,
    page::{ReportPage, TableCells, short},
    report,
};
use crate::driver::{DRIVERS_FORMAT, DriversFile, FittedDriver};
use rayon::prelude::*;

/// A participant, described by the numbers of the simulated driver.
#[derive(Clone, Debug, PartialEq)]
pub struct ParticipantDriver {
    /// `sub-P03`; empty outside of a study.
    pub participant: String,
    /// Numbers fitted to the drives.
    pub found: FoundDriver,
}

impl FoundDriver {
    /// Returns the numbers in the order of the table: reaction, bias, error, time gap.
    pub fn numbers(&self) -> [Option<FoundNumber>; 4] {
        [self.reaction_s, self.speed_bias_mps, self.error_mps, self.time_gap_factor]
    }
}

/// Fits each participant of these drives, in the order of their first drives.
pub fn drivers(drives: &[AnalysedRecording]) -> Vec<ParticipantDriver> {
    let mut each: Vec<(&str, Vec<&DriverStretches>)> = Vec::new();
    for drive in drives {
        let participant = drive.found.participant.as_str();
        match each.iter_mut().find(|(other, _)| *other == participant) {
            Some((_, of)) => of.push(&drive.stretches),
            None => each.push((participant, vec![&drive.stretches])),
        }
    }
    let one = |(participant, of): (&str, Vec<&DriverStretches>)| ParticipantDriver {
        participant: participant.into(),
        found: fit(&of),
    };
    each.into_par_iter().map(one).collect()
}

/// Returns the file of the participants with at least one number, as `codrive study rehearse --drivers` reads it.
pub fn drivers_toml(study: &str, drivers: &[ParticipantDriver]) -> String {
    let one = |driver: &ParticipantDriver| {
        let value = |number: Option<FoundNumber>| number.map(|number| number.value);
        FittedDriver {
            participant: Some(driver.participant.clone()).filter(|code| !code.is_empty()),
            reaction_s: value(driver.found.reaction_s),
            error_mps: value(driver.found.error_mps),
            speed_bias_mps: value(driver.found.speed_bias_mps),
            time_gap_factor: value(driver.found.time_gap_factor),
        }
    };
    let driver = drivers.iter().filter(|driver| driver.found != FoundDriver::default()).map(one).collect();
    DriversFile { format: DRIVERS_FORMAT.into(), study: study.into(), driver }.text()
}

/// Returns the participants with at least one number.
fn with_numbers(drivers: &[ParticipantDriver]) -> Vec<&ParticipantDriver> {
    drivers.iter().filter(|driver| driver.found != FoundDriver::default()).collect()
}

/// Adds the section of the page; none without numbers.
pub(super) fn section(page: &mut ReportPage, drivers: &[ParticipantDriver]) {
    let with_numbers = with_numbers(drivers);
    if with_numbers.is_empty() {
        return;
    }
    page.put("<h2>Drivers</h2>");
    page.paragraph(
        "lead",
        &format!(
            "{} gives each participant as the simulated driver who would drive alike; drivers.csv has the same with the time that \
             each number rests on. – stands for what the drives do not tell.",
            page.table_links(1)
        ),
    );
    let number = |found: Option<FoundNumber>| {
        found.map_or("–".into(), |n| {
            format!("{} [{}, {}]", short(n.value), short(n.interval[0]), short(n.interval[1]))
        })
    };
    let row = |driver: &&ParticipantDriver| {
        let participant = if driver.participant.is_empty() { "The driver".into() } else { driver.participant.clone() };
        [participant].into_iter().chain(driver.found.numbers().map(number)).collect()
    };
    let head =
        ["Participant".to_owned()].into_iter().chain(glossary::DRIVER_NUMBERS.map(|number| number.label())).collect();
    page.table(
        &format!(
            "Drivers as found from advice and driving: value [95 % interval]. N = {}.",
            report::people(with_numbers.len())
        ),
        &head,
        &with_numbers.iter().map(row).collect::<Vec<TableCells>>(),
        &[],
    );
}

/// Returns the paragraph of the methods; empty without numbers.
pub(super) fn paragraph(drivers: &[ParticipantDriver]) -> String {
    if with_numbers(drivers).is_empty() {
        return String::new();
    }
    format!(
        "Each participant was described by the numbers of codrive's simulated driver, which accelerates by the smaller of what reaches \
         the advised speed and what the Intelligent Driver Model asks for behind the leader. Bias, tracking error and time gap had the \
         largest likelihood of the wanted speed, read from speed and acceleration twice a second; their 95 % intervals are by the \
         jackknife over at most {GROUPS} parts of the time. The reaction time was the delay of the advice for which the innovations of \
         the tracking error (time constant 5 s) were smallest; its 95 % interval is by the bootstrap over stretches of 20 s. A number \
         that rests on less than {LEAST_S:.0} s, or whose interval is too wide to tell anything, was left out."
    )
}
