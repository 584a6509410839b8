//! Trajectories of a lab from a file. In: a CSV file with a row for each vehicle and step, compressed (gzip) or not. Out:
//! [`VehicleTrajectories`], or the fault with its line.
//!
//! | column | content |
//! |---|---|
//! | `time_s` | time, s, in even steps of at most 0.5 s |
//! | `vehicle` | name of the vehicle, without commas |
//! | `leader` | name of the vehicle ahead, always the same; empty for the first of a platoon |
//! | `speed_mps` | speed, m/s |
//! | `gap_m` | distance from the front bumper to the leader's rear, m; empty without a leader |
//!
//! Every vehicle has a row at each step, in order of time. Columns may stand in any order, and other columns are ignored.

use super::trajectories::{VehicleTrajectories, VehicleTrajectory};
use crate::file::{open_regular, unpacked};
use std::{
    collections::BTreeMap,
    io::{self, BufRead, BufReader, Read},
    path::{Path, PathBuf},
};

/// Columns of the file.
pub const COLUMNS: [&str; 5] = ["time_s", "vehicle", "leader", "speed_mps", "gap_m"];
/// Largest number of rows: 20 vehicles over 5 h at steps of 0.1 s.
pub const MOST_ROWS: usize = 4_000_000;
/// Largest number of vehicles, and of bytes of a line.
const MOST_VEHICLES: usize = 1000;
const MOST_LINE_BYTES: u64 = 4096;
/// Largest step, s: lags and accelerations are shorter than two larger ones.
const MOST_STEP_S: f64 = 0.5;
/// Smallest and largest speed, m/s, and gap, m, that are not taken for another unit or a fault of a sensor.
const SPEEDS_MPS: [f64; 2] = [-2.0, 100.0];
const GAPS_M: [f64; 2] = [-5.0, 1000.0];

/// Fault in a file of trajectories.
#[derive(Debug, thiserror::Error)]
pub enum TrajectoryFault {
    #[error("{}: cannot be read: {why}", path.display())]
    Unreadable { path: PathBuf, why: io::Error },
    #[error("{}: line {line}: {what}\n  remedy: {remedy}", path.display())]
    Line { path: PathBuf, line: usize, what: String, remedy: String },
}

/// Line, what is wrong with it, and the remedy.
type LineFault = (usize, String, String);

/// Fault before the file's name is added.
#[derive(Debug)]
enum ReadFault {
    Io(io::Error),
    Line(LineFault),
}

impl From<LineFault> for ReadFault {
    fn from(fault: LineFault) -> Self {
        Self::Line(fault)
    }
}

/// Reads a file; `ring_m` is the length of the ring, m, if the vehicles drive on one.
///
/// # Errors
/// The file cannot be read, or a line is not as the head of this module says.
pub fn read_trajectories(path: &Path, ring_m: Option<f64>) -> Result<VehicleTrajectories, TrajectoryFault> {
    let file = open_regular(path).and_then(unpacked);
    let read = file.map_err(ReadFault::Io).and_then(|file| parsed(BufReader::new(file), ring_m));
    read.map_err(|fault| match fault {
        ReadFault::Io(why) => TrajectoryFault::Unreadable { path: path.into(), why },
        ReadFault::Line((line, what, remedy)) => TrajectoryFault::Line { path: path.into(), line, what, remedy },
    })
}

/// A vehicle while its rows are read.
#[derive(Default)]
struct VehicleRows {
    trajectory: VehicleTrajectory,
    leader: String,
    first_line: usize,
    /// Times of the first, the second and the last row, s.
    first_s: f64,
    second_s: f64,
    last_s: f64,
}

/// Reads the next line without its end; `None` after the last.
fn next_line<'a>(from: &mut impl BufRead, line: usize, text: &'a mut String) -> Result<Option<&'a str>, ReadFault> {
    text.clear();
    let bytes = from.by_ref().take(MOST_LINE_BYTES).read_line(text).map_err(ReadFault::Io)?;
    if bytes as u64 == MOST_LINE_BYTES && !text.ends_with('\n') {
        let what = format!("the line is too long; allowed: at most {MOST_LINE_BYTES} bytes");
        return Err((line, what, "end each row with a line feed, and leave other columns out".to_owned()).into());
    }
    Ok((bytes > 0).then(|| text.trim_end_matches(['\n', '\r'])))
}

/// Reads the trajectories from a text.
fn parsed(mut from: impl BufRead, ring_m: Option<f64>) -> Result<VehicleTrajectories, ReadFault> {
    let mut text = String::new();
    let columns = columns_of(next_line(&mut from, 1, &mut text)?.unwrap_or_default())?;
    let mut vehicles: Vec<VehicleRows> = Vec::new();
    let mut by_name: BTreeMap<String, usize> = BTreeMap::new();
    let mut number = 1;
    while let Some(line) = next_line(&mut from, number + 1, &mut text)? {
        number += 1;
        if line.is_empty() {
            continue;
        }
        let row = Row::of(number, line, columns)?;
        let at = match by_name.get(row.vehicle) {
            Some(at) => *at,
            None => {
                by_name.insert(row.vehicle.to_owned(), vehicles.len());
                vehicles.push(VehicleRows::new(&row));
                vehicles.len() - 1
            }
        };
        if number > MOST_ROWS || vehicles.len() > MOST_VEHICLES {
            let what = format!("too much; allowed: at most {MOST_ROWS} rows and {MOST_VEHICLES} vehicles");
            return Err((number, what, "split the file".to_owned()).into());
        }
        vehicles[at].add(&row)?;
    }
    let step_s = common_step_s(&vehicles)?;
    let mut all = VehicleTrajectories { step_s, ring_m, vehicles: Vec::new() };
    for mut rows in vehicles {
        if !rows.leader.is_empty() {
            let unknown = || {
                let what = format!("leader \"{}\" has no rows of its own", rows.leader);
                (rows.first_line, what, "add the leader's rows, or leave leader and gap_m empty".to_owned())
            };
            rows.trajectory.leader = Some(*by_name.get(&rows.leader).ok_or_else(unknown)?);
        }
        all.vehicles.push(rows.trajectory);
    }
    Ok(all)
}

/// Returns the place of each of [`COLUMNS`] in the head of the file.
fn columns_of(head: &str) -> Result<[usize; 5], LineFault> {
    let names: Vec<&str> = head.trim_start_matches('\u{feff}').split(',').map(str::trim).collect();
    let mut places = [0; 5];
    for (place, column) in places.iter_mut().zip(COLUMNS) {
        let missing = || {
            let what = format!("there is no column \"{column}\"; the columns are \"{}\"", names.join(", "));
            (1, what, format!("name the columns in the first line: {}", COLUMNS.join(",")))
        };
        *place = names.iter().position(|name| *name == column).ok_or_else(missing)?;
    }
    Ok(places)
}

/// Cells of a line.
struct Row<'a> {
    line: usize,
    time_s: f64,
    vehicle: &'a str,
    leader: &'a str,
    speed_mps: f64,
    gap_m: Option<f64>,
}

impl<'a> Row<'a> {
    fn of(line: usize, text: &'a str, columns: [usize; 5]) -> Result<Self, LineFault> {
        let cells: Vec<&str> = text.split(',').map(str::trim).collect();
        let cell = |k: usize| cells.get(columns[k]).copied().unwrap_or_default();
        let number = |k: usize, [low, high]: [f64; 2]| {
            let value = cell(k).parse::<f64>().ok().filter(|value| (low..=high).contains(value));
            value.ok_or_else(|| {
                let what = format!("{} is \"{}\"; allowed: a number from {low} to {high}", COLUMNS[k], cell(k));
                let remedy =
                    "write the value in this unit, fill short holes by interpolation, or leave the vehicle out";
                (line, what, remedy.to_owned())
            })
        };
        let [vehicle, leader] = [cell(1), cell(2)];
        if vehicle.is_empty() || vehicle == leader {
            let what = format!("vehicle \"{vehicle}\" with leader \"{leader}\"");
            return Err((line, what, "give each vehicle a name, and another vehicle as its leader".to_owned()));
        }
        let gap_m = if leader.is_empty() { None } else { Some(number(4, GAPS_M)?) };
        Ok(Self { line, time_s: number(0, [-1e9, 1e9])?, vehicle, leader, speed_mps: number(3, SPEEDS_MPS)?, gap_m })
    }
}

impl VehicleRows {
    fn new(row: &Row) -> Self {
        Self {
            trajectory: VehicleTrajectory { name: row.vehicle.to_owned(), ..VehicleTrajectory::default() },
            leader: row.leader.to_owned(),
            first_line: row.line,
            ..Self::default()
        }
    }

    fn rows(&self) -> usize {
        self.trajectory.speed_mps.len()
    }

    fn add(&mut self, row: &Row) -> Result<(), LineFault> {
        let name = row.vehicle;
        if row.leader != self.leader {
            let what = format!("vehicle \"{name}\" follows \"{}\", before it followed \"{}\"", row.leader, self.leader);
            return Err((row.line, what, "split the file where a leader changes".to_owned()));
        }
        let step_s = self.second_s - self.first_s;
        match self.rows() {
            0 => self.first_s = row.time_s,
            1 => self.second_s = row.time_s,
            rows => {
                let expected_s = self.first_s + rows as f64 * step_s;
                if (row.time_s - expected_s).abs() > 0.1 * step_s {
                    let what = format!("vehicle \"{name}\" is at time {} s, expected {expected_s:.3} s", row.time_s);
                    return Err((row.line, what, "write even steps of time, in order, without holes".to_owned()));
                }
            }
        }
        if self.rows() == 1 && !(1e-3..=MOST_STEP_S).contains(&(self.second_s - self.first_s)) {
            let what = format!("the step is {:.3} s; allowed: 0.001 to {MOST_STEP_S} s", self.second_s - self.first_s);
            return Err((
                row.line,
                what,
                "write each vehicle's rows in order of time, in even and short steps".to_owned(),
            ));
        }
        self.last_s = row.time_s;
        self.trajectory.speed_mps.push(row.speed_mps);
        self.trajectory.gap_m.extend(row.gap_m);
        Ok(())
    }
}

/// Returns the step of all vehicles, s, checking that all have the same steps.
fn common_step_s(vehicles: &[VehicleRows]) -> Result<f64, LineFault> {
    let longest = vehicles.iter().max_by_key(|rows| rows.rows()).filter(|rows| rows.rows() > 1);
    let Some(longest) = longest else {
        return Err((
            1,
            "there are no two steps of a vehicle".to_owned(),
            "add a row for each vehicle and step".to_owned(),
        ));
    };
    let step_s = (longest.last_s - longest.first_s) / (longest.rows() - 1) as f64;
    for rows in vehicles {
        let is_same = rows.rows() == longest.rows() && (rows.first_s - longest.first_s).abs() < 0.1 * step_s;
        if !is_same {
            let what = format!(
                "vehicle \"{}\" has {} steps from {} s on, others have {} from {} s on",
                rows.trajectory.name,
                rows.rows(),
                rows.first_s,
                longest.rows(),
                longest.first_s
            );
            return Err((rows.first_line, what, "cut the file to the time that all vehicles have".to_owned()));
        }
    }
    Ok(step_s)
}

#[cfg(test)]
#[path = "trajectory_file_tests.rs"]
mod tests;
