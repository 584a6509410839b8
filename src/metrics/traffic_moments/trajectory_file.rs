//! Trajectories of a lab from a file. In: a CSV file with a row for each vehicle and step, compressed (gzip) or not. Out:
//! [`VehicleTrajectories`], or the fault with its line. `log_file` reads the same files as a log that is driven again.
//!
//! | column | content |
//! |---|---|
//! | `time_s` or `t_s` | time, s, in even steps of at most 0.5 s |
//! | `vehicle` or `car` | name of the vehicle, without commas |
//! | `leader` | name of the vehicle ahead, always the same; empty for the first of a platoon |
//! | `speed_mps` | speed, m/s |
//! | `gap_m` | distance from the front bumper to the leader's rear, m; empty without a leader |
//! | `s_m` | only of logs: front bumper along the lane, m |
//!
//! Every vehicle has a row at each step, in order of time. Columns may stand in any order, and other columns are ignored. OpenACC's
//! platoons have a row for all vehicles of a step instead (`trajectory_columns`).

use super::{
    trajectories::{VehicleTrajectories, VehicleTrajectory},
    trajectory_columns::{Layout, Row},
};
use crate::file::{open_regular, unpacked};
use std::{
    collections::BTreeMap,
    io::{self, BufRead, BufReader, Read},
    path::{Path, PathBuf},
};

/// Columns of a file of trajectories.
pub const COLUMNS: [&str; 5] = ["time_s", "vehicle", "leader", "speed_mps", "gap_m"];
/// Largest number of rows: 20 vehicles over 5 h at steps of 0.1 s.
pub const MOST_ROWS: usize = 4_000_000;
/// Largest number of vehicles, and of bytes of a line.
const MOST_VEHICLES: usize = 1000;
const MOST_LINE_BYTES: u64 = 4096;
/// Smallest and largest gap, m, that is not taken for another unit or a fault of a sensor.
pub(super) const GAPS_M: [f64; 2] = [-5.0, 1000.0];

/// Rules of a use of the file.
pub(super) struct FileRules {
    /// Columns that the file must have.
    pub required: &'static [&'static str],
    /// Largest step, s.
    pub most_step_s: f64,
    /// Smallest and largest speed, m/s, that is not taken for another unit or a fault of a sensor.
    pub speeds_mps: [f64; 2],
    /// Smallest and largest position along the lane, m.
    pub places_m: [f64; 2],
}

/// Rules of moments of traffic: lags and accelerations are shorter than two steps of more than 0.5 s.
pub(super) const OF_MOMENTS: FileRules =
    FileRules { required: &COLUMNS, most_step_s: 0.5, speeds_mps: [-2.0, 100.0], places_m: [-1e7, 1e7] };

/// Fault in a file of trajectories.
#[derive(Debug, thiserror::Error)]
pub enum TrajectoryFault {
    #[error("{}: cannot be read: {why}", path.display())]
    Unreadable { path: PathBuf, why: io::Error },
    #[error("{}: line {line}: {what}\n  remedy: {remedy}", path.display())]
    Line { path: PathBuf, line: usize, what: String, remedy: String },
}

/// Line, what is wrong with it, and the remedy.
pub(super) type LineFault = (usize, String, String);

/// Fault before the file's name is added.
#[derive(Debug)]
pub(super) enum ReadFault {
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
    of_file(path, |from| parsed(from, ring_m))
}

/// Opens a file, compressed or not, and adds its name to a fault of the reader.
pub(super) fn of_file<T>(
    path: &Path,
    read: impl FnOnce(&mut dyn BufRead) -> Result<T, ReadFault>,
) -> Result<T, TrajectoryFault> {
    let file = open_regular(path).and_then(unpacked);
    let read = file.map_err(ReadFault::Io).and_then(|file| read(&mut BufReader::new(file)));
    read.map_err(|fault| match fault {
        ReadFault::Io(why) => TrajectoryFault::Unreadable { path: path.into(), why },
        ReadFault::Line((line, what, remedy)) => TrajectoryFault::Line { path: path.into(), line, what, remedy },
    })
}

/// A vehicle while its rows are read.
#[derive(Default)]
pub(super) struct VehicleRows {
    pub trajectory: VehicleTrajectory,
    pub leader: String,
    /// Lines of the rows.
    pub lines: Vec<usize>,
    /// Times of the first, the second and the last row, s.
    first_s: f64,
    second_s: f64,
    last_s: f64,
}

/// Reads the next line without its end; `None` after the last.
fn next_line<'a>(mut from: &mut dyn BufRead, line: usize, text: &'a mut String) -> Result<Option<&'a str>, ReadFault> {
    text.clear();
    let bytes = Read::take(&mut from, MOST_LINE_BYTES).read_line(text).map_err(ReadFault::Io)?;
    if bytes as u64 == MOST_LINE_BYTES && !text.ends_with('\n') {
        let what = format!("the line is too long; allowed: at most {MOST_LINE_BYTES} bytes");
        return Err((line, what, "end each row with a line feed, and leave other columns out".to_owned()).into());
    }
    Ok((bytes > 0).then(|| text.trim_end_matches(['\n', '\r'])))
}

/// Vehicles of a text, with their common step, s.
pub(super) struct ReadRows {
    pub step_s: f64,
    pub vehicles: Vec<VehicleRows>,
}

/// Reads the vehicles' rows from a text.
pub(super) fn rows_of(from: &mut dyn BufRead, rules: &FileRules) -> Result<ReadRows, ReadFault> {
    let mut text = String::new();
    let layout = Layout::of(next_line(from, 1, &mut text)?.unwrap_or_default(), rules)?;
    let mut vehicles: Vec<VehicleRows> = Vec::new();
    let mut by_name: BTreeMap<String, usize> = BTreeMap::new();
    let mut number = 1;
    while let Some(line) = next_line(from, number + 1, &mut text)? {
        number += 1;
        if line.is_empty() {
            continue;
        }
        for row in layout.rows(number, line, rules) {
            let row = row?;
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
            vehicles[at].add(&row, rules.most_step_s)?;
        }
    }
    let step_s = common_step_s(&vehicles)?;
    // A vehicle alone needs no leader: the rows of one vehicle out of a platoon are a log, too.
    if rules.required.contains(&"leader") || vehicles.len() > 1 {
        for rows in &mut vehicles {
            if !rows.leader.is_empty() {
                let unknown = || {
                    let what = format!("leader \"{}\" has no rows of its own", rows.leader);
                    (rows.lines[0], what, "add the leader's rows, or leave leader and gap_m empty".to_owned())
                };
                rows.trajectory.leader = Some(*by_name.get(&rows.leader).ok_or_else(unknown)?);
            }
        }
    }
    Ok(ReadRows { step_s, vehicles })
}

/// Reads the trajectories from a text.
fn parsed(from: &mut dyn BufRead, ring_m: Option<f64>) -> Result<VehicleTrajectories, ReadFault> {
    let ReadRows { step_s, vehicles } = rows_of(from, &OF_MOMENTS)?;
    let vehicles = vehicles.into_iter().map(|rows| rows.trajectory).collect();
    Ok(VehicleTrajectories { step_s, ring_m, vehicles })
}

impl VehicleRows {
    fn new(row: &Row) -> Self {
        Self {
            trajectory: VehicleTrajectory { name: row.vehicle.to_owned(), ..VehicleTrajectory::default() },
            leader: row.leader.to_owned(),
            ..Self::default()
        }
    }

    fn rows(&self) -> usize {
        self.trajectory.speed_mps.len()
    }

    fn add(&mut self, row: &Row, most_step_s: f64) -> Result<(), LineFault> {
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
        if self.rows() == 1 && !(1e-3..=most_step_s).contains(&(self.second_s - self.first_s)) {
            let what = format!("the step is {:.3} s; allowed: 0.001 to {most_step_s} s", self.second_s - self.first_s);
            return Err((
                row.line,
                what,
                "write each vehicle's rows in order of time, in even and short steps".to_owned(),
            ));
        }
        self.last_s = row.time_s;
        self.trajectory.speed_mps.push(row.speed_mps);
        self.trajectory.gap_m.extend(row.gap_m);
        self.trajectory.s_m.extend(row.s_m);
        self.lines.push(row.line);
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
            return Err((rows.lines[0], what, "cut the file to the time that all vehicles have".to_owned()));
        }
    }
    Ok(step_s)
}

#[cfg(test)]
#[path = "trajectory_file_tests.rs"]
mod tests;
