//! Table of drivers. In: participants as simulated drivers. Out: `drivers.csv` (a row per participant), with its columns.

use super::key::KEY;
use crate::analysis::{
    columns::{ColumnDefinition, TableColumns, cell, columns, line},
    drivers::ParticipantDriver,
};

/// Texts of a driver's number: name without its unit, quantity, unit at the end of the name, unit, definition.
pub(crate) struct DriverNumber {
    name: &'static str,
    title: &'static str,
    suffix: &'static str,
    unit: &'static str,
    about: &'static str,
}

/// Numbers in the order of [`FoundDriver::numbers`](crate::analysis::drivers::driver_fit::FoundDriver::numbers).
pub(crate) const DRIVER_NUMBERS: [DriverNumber; 4] = [
    DriverNumber {
        name: "reaction",
        title: "Reaction time to advice",
        suffix: "_s",
        unit: "s",
        about: "time from a change of the advice to the movement of the foot; found as the delay of the advice that \
             explains the wanted speed best",
    },
    DriverNumber {
        name: "speed_bias",
        title: "Bias",
        suffix: "_mps",
        unit: "m/s",
        about: "mean of the wanted speed minus the advised speed; positive: too fast",
    },
    DriverNumber {
        name: "error",
        title: "Tracking error",
        suffix: "_mps",
        unit: "m/s",
        about: "standard deviation of the wanted speed around the advised speed plus the bias",
    },
    DriverNumber {
        name: "time_gap_factor",
        title: "Time gap factor",
        suffix: "",
        unit: "",
        about: "desired time gap to the leader (T of the Intelligent Driver Model) as a multiple of the other vehicles' \
             time gap",
    },
];

impl DriverNumber {
    /// Returns the quantity with its unit.
    pub fn label(&self) -> String {
        if self.unit.is_empty() { self.title.into() } else { format!("{}, {}", self.title, self.unit) }
    }

    /// Returns the columns of the value, both ends of its interval, and the time that it rests on.
    fn columns(&self) -> [ColumnDefinition; 4] {
        let Self { name, title, suffix, unit, about } = self;
        let column = |part: &str, title: String, about: String| ColumnDefinition {
            name: format!("{name}{part}{suffix}"),
            title,
            unit,
            about,
        };
        [
            column("", (*title).into(), format!("{about}; empty if the drives do not determine it")),
            column("_low", format!("{title}, lower end"), "lower end of the 95 % interval".into()),
            column("_high", format!("{title}, upper end"), "upper end of the 95 % interval".into()),
            ColumnDefinition {
                name: format!("{name}_rests_on_s"),
                title: format!("{title}, basis"),
                unit: "s",
                about: "driving time that the value rests on; a long drive contributes evenly spaced stretches".into(),
            },
        ]
    }
}

/// Returns the columns of `drivers.csv`.
pub(crate) fn drivers_columns() -> TableColumns {
    let own = DRIVER_NUMBERS.iter().flat_map(DriverNumber::columns);
    let columns = columns(&KEY[..1]).into_iter().chain(own).collect();
    TableColumns { file: "drivers.csv", row: "a participant as a driver", columns }
}

/// Returns `drivers.csv`: a row per participant.
pub fn drivers(drivers: &[ParticipantDriver]) -> String {
    let row = |driver: &ParticipantDriver| {
        let cells = driver.found.numbers().into_iter().flat_map(|number| {
            let own = number.map(|n| [n.value, n.interval[0], n.interval[1], n.rests_on_s]);
            (0..4).map(move |k| cell(own.map(|own| own[k])))
        });
        line([driver.participant.clone()].into_iter().chain(cells))
    };
    drivers_columns().head() + &drivers.iter().map(row).collect::<String>()
}
