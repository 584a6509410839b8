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
use crate::file::read_unpacked_text;
use std::{
    collections::BTreeMap,
    io,
    path::{Path, PathBuf},
};

/// Columns of the file.
pub const COLUMNS: [&str; 5] = ["time_s", "vehicle", "leader", "speed_mps", "gap_m"];
/// Largest size of a file, unpacked, bytes: 20 vehicles over 10 h at steps of 0.1 s.
pub const MOST_BYTES: u64 = 256 << 20;
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

/// Content of a line that is not as it should be, and the remedy.
type LineFault = (usize, String, String);

/// Reads a file; `ring_m` is the length of the ring, m, if the vehicles drive on one.
///
/// # Errors
/// The file cannot be read, or a line is not as the head of this module says.
pub fn read_trajectories(path: &Path, ring_m: Option<f64>) -> Result<VehicleTrajectories, TrajectoryFault> {
    let text = read_unpacked_text(path, MOST_BYTES);
    let text = text.map_err(|why| TrajectoryFault::Unreadable { path: path.into(), why })?;
    let fault = |(line, what, remedy)| TrajectoryFault::Line { path: path.into(), line, what, remedy };
    parsed(&text, ring_m).map_err(fault)
}

/// A vehicle while its rows are read.
#[derive(Default)]
struct VehicleRows {
    trajectory: VehicleTrajectory,
    leader: String,
    times_s: Vec<f64>,
    first_line: usize,
}

/// Returns the trajectories in a text.
fn parsed(text: &str, ring_m: Option<f64>) -> Result<VehicleTrajectories, LineFault> {
    let mut lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim_end_matches('\r')));
    let (_, head) = lines.next().unwrap_or((1, ""));
    let columns = columns_of(head)?;
    let mut vehicles: Vec<VehicleRows> = Vec::new();
    let mut by_name: BTreeMap<String, usize> = BTreeMap::new();
    for (number, line) in lines.filter(|(_, line)| !line.is_empty()) {
        let row = Row::of(number, line, columns)?;
        let at = *by_name.entry(row.vehicle.to_owned()).or_insert_with(|| {
            let trajectory = VehicleTrajectory { name: row.vehicle.to_owned(), ..VehicleTrajectory::default() };
            let leader = row.leader.to_owned();
            vehicles.push(VehicleRows { trajectory, leader, first_line: number, ..VehicleRows::default() });
            vehicles.len() - 1
        });
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
    fn add(&mut self, row: &Row) -> Result<(), LineFault> {
        if row.leader != self.leader {
            let what = format!(
                "vehicle \"{}\" follows \"{}\", before it followed \"{}\"",
                row.vehicle, row.leader, self.leader
            );
            return Err((row.line, what, "split the file where a leader changes".to_owned()));
        }
        if let [first_s, second_s, ..] = self.times_s[..] {
            let expected_s = first_s + self.times_s.len() as f64 * (second_s - first_s);
            if (row.time_s - expected_s).abs() > 0.1 * (second_s - first_s) {
                let what =
                    format!("vehicle \"{}\" is at time {} s, expected {expected_s:.3} s", row.vehicle, row.time_s);
                return Err((row.line, what, "write even steps of time, in order, without holes".to_owned()));
            }
        } else if let [first_s] = self.times_s[..]
            && !(1e-3..=MOST_STEP_S).contains(&(row.time_s - first_s))
        {
            let what = format!("the step is {:.3} s; allowed: 0.001 to {MOST_STEP_S} s", row.time_s - first_s);
            return Err((
                row.line,
                what,
                "write each vehicle's rows in order of time, in even and short steps".to_owned(),
            ));
        }
        self.times_s.push(row.time_s);
        self.trajectory.speed_mps.push(row.speed_mps);
        self.trajectory.gap_m.extend(row.gap_m);
        Ok(())
    }
}

/// Returns the step of all vehicles, s, checking that all have the same steps.
fn common_step_s(vehicles: &[VehicleRows]) -> Result<f64, LineFault> {
    let longest = vehicles.iter().max_by_key(|rows| rows.times_s.len());
    let Some(all_s) = longest.map(|rows| &rows.times_s).filter(|times_s| times_s.len() > 1) else {
        return Err((
            1,
            "there are no two steps of a vehicle".to_owned(),
            "add a row for each vehicle and step".to_owned(),
        ));
    };
    let step_s = (all_s[all_s.len() - 1] - all_s[0]) / (all_s.len() - 1) as f64;
    for rows in vehicles {
        let same = rows.times_s.len() == all_s.len() && (rows.times_s[0] - all_s[0]).abs() < 0.1 * step_s;
        if !same {
            let name = &rows.trajectory.name;
            let what = format!(
                "vehicle \"{name}\" has {} steps from {} s on, others have {} from {} s on",
                rows.times_s.len(),
                rows.times_s[0],
                all_s.len(),
                all_s[0]
            );
            return Err((rows.first_line, what, "cut the file to the time that all vehicles have".to_owned()));
        }
    }
    Ok(step_s)
}

#[cfg(test)]
#[path = "trajectory_file_tests.rs"]
mod tests;
