//! Report section and paragraph of the methods on participants as simulated drivers. In: the numbers of each. Out: a table on
//! the page, and text.

use super::page::{ReportPage, TableCells, short};
use crate::analysis::{
    drivers::{
        FoundDriver, FoundNumber, ParticipantDriver,
        driver_fit::{GROUPS, LEAST_S},
    },
    tables::DRIVER_NUMBERS,
    text::people,
};

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
            "{} describes each participant by the parameters of a simulated driver who would drive like the \
             participant. The file drivers.csv also has the driving time that each parameter rests on. A dash (–) \
             means that the drives do not determine a parameter.",
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
    let head = ["Participant".to_owned()].into_iter().chain(DRIVER_NUMBERS.map(|number| number.label())).collect();
    page.table(
        &format!(
            "Driver parameters estimated from advice and driving: value [95 % interval]. N = {}.",
            people(with_numbers.len())
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
        "Each participant was described by the parameters of codrive's simulated driver. Its acceleration is the \
         smaller of the acceleration that reaches the advised speed and the acceleration of the Intelligent Driver \
         Model behind the leader. Bias, tracking error and time gap were estimated by maximum likelihood of the wanted \
         speed, read from speed and acceleration twice a second; 95 % intervals are by the jackknife over at most \
         {GROUPS} parts of the time. The reaction time was the delay of the advice with the smallest innovations of \
         the tracking error (time constant 5 s); the 95 % interval is by the bootstrap over stretches of 20 s. A \
         parameter that rests on less than {LEAST_S:.0} s, or has too wide an interval to be informative, was left out."
    )
}
