//! Trajectories of a file as a log that is driven again on one lane. In: a file of trajectories (`trajectory_file`) that needs only the
//! columns `time_s` and `speed_mps`. Out: the vehicles with their positions, the last of the platoon first, or the fault with its line.
//!
//! The positions of a vehicle are, in this order: its column `s_m`; those of its leader, less a vehicle's length and its gap; the integral
//! of its speeds, linear between the steps. A ring of vehicles is cut behind the first vehicle of the file, which becomes the last on the
//! lane. Metres, m/s, seconds.

use super::{
    trajectories::VehicleTrajectories,
    trajectory_file::{FileRules, LineFault, ReadFault, ReadRows, TrajectoryFault, VehicleRows, of_file, rows_of},
};
use crate::space::CAR_LENGTH_M;
use std::{io::BufRead, path::Path};

/// Rules of a log: driving cycles have steps of 1 s. No car drives backwards or faster than 60 m/s in traffic, as in the models; speeds of
/// a sensor at a standstill are as low as -0.32 m/s (the Arizona ring's), and count as 0.
const OF_LOG: FileRules =
    FileRules { required: &["time_s", "speed_mps"], most_step_s: 1.0, speeds_mps: [-0.5, 60.0], places_m: [-1e5, 1e5] };
/// Distance from which positions and speeds of a vehicle are compared, m.
const COMPARED_M: f64 = 50.0;
/// Largest ratio of the distances by positions and by speeds: far above the errors of sensors, far below the ratio of m/s to km/h or mph.
const MOST_RATIO: f64 = 1.5;

/// Reads a file as a log: every vehicle has positions, and the rearmost is the first.
///
/// # Errors
/// The file cannot be read, or the vehicles cannot drive as it says on one lane.
pub fn read_log(path: &Path) -> Result<VehicleTrajectories, TrajectoryFault> {
    of_file(path, log_of)
}

fn log_of(from: &mut dyn BufRead) -> Result<VehicleTrajectories, ReadFault> {
    let ReadRows { step_s, mut vehicles } = rows_of(from, &OF_LOG)?;
    vehicles.iter_mut().flat_map(|rows| &mut rows.trajectory.speed_mps).for_each(|speed| *speed = speed.max(0.0));
    place(&mut vehicles, step_s)?;
    vehicles.iter().try_for_each(|rows| check_units(rows, step_s))?;
    vehicles.sort_by(|a, b| a.trajectory.s_m[0].total_cmp(&b.trajectory.s_m[0]));
    for pair in vehicles.windows(2) {
        check_apart(&pair[0], &pair[1], step_s)?;
    }
    let vehicles = vehicles.into_iter().map(|rows| rows.trajectory).collect();
    Ok(VehicleTrajectories { step_s, ring_m: None, vehicles })
}

/// Gives every vehicle its positions.
fn place(vehicles: &mut [VehicleRows], step_s: f64) -> Result<(), LineFault> {
    let is_placed = |rows: &VehicleRows| rows.trajectory.s_m.len() == rows.lines.len();
    let has_gaps = |rows: &VehicleRows| rows.trajectory.gap_m.len() == rows.lines.len();
    let mut heads: Vec<usize> = (0..vehicles.len())
        .filter(|k| !is_placed(&vehicles[*k]) && (vehicles[*k].trajectory.leader.is_none() || !has_gaps(&vehicles[*k])))
        .collect();
    if heads.is_empty() && !vehicles.iter().any(is_placed) {
        heads.extend(vehicles.iter().position(|rows| rows.trajectory.leader == Some(0)));
    }
    if let Some(second) = heads.get(1).or(heads.first().filter(|_| vehicles.iter().any(is_placed))) {
        let rows = &vehicles[*second];
        let what = format!("vehicle \"{}\" has neither positions nor a leader with gaps", rows.trajectory.name);
        let remedy = "add a column s_m, or leader and gap_m, or keep the rows of one vehicle alone";
        return Err((rows.lines[0], what, remedy.into()));
    }
    if let Some(head) = heads.first() {
        vehicles[*head].trajectory.s_m = integral_m(&vehicles[*head].trajectory.speed_mps, step_s);
    }
    // Each round places at least one vehicle behind another that has positions.
    while let Some(left) = vehicles.iter().position(|rows| !is_placed(rows)) {
        let next = (0..vehicles.len()).find(|k| {
            let leader = vehicles[*k].trajectory.leader;
            !is_placed(&vehicles[*k]) && leader.is_some_and(|leader| is_placed(&vehicles[leader]))
        });
        let Some((next, leader)) = next.and_then(|next| Some((next, vehicles[next].trajectory.leader?))) else {
            let rows = &vehicles[left];
            let what = format!(
                "vehicle \"{}\" and its leaders follow each other round a ring of their own",
                rows.trajectory.name
            );
            let remedy = "keep the rows of one ring, or of one vehicle alone, as the leader of the drive";
            return Err((rows.lines[0], what, remedy.into()));
        };
        let ahead_m = vehicles[leader].trajectory.s_m.clone();
        let own = &mut vehicles[next].trajectory;
        own.s_m = ahead_m.iter().zip(&own.gap_m).map(|(ahead_m, gap_m)| ahead_m - CAR_LENGTH_M - gap_m).collect();
    }
    Ok(())
}

/// Returns the integral of speeds that are linear between steps, m.
fn integral_m(speed_mps: &[f64], step_s: f64) -> Vec<f64> {
    let ways = speed_mps.windows(2).scan(0.0, |s_m, pair| {
        *s_m += (pair[0] + pair[1]) / 2.0 * step_s;
        Some(*s_m)
    });
    std::iter::once(0.0).chain(ways).collect()
}

/// Checks that positions and speeds of a vehicle are in the same units.
fn check_units(rows: &VehicleRows, step_s: f64) -> Result<(), LineFault> {
    let own = &rows.trajectory;
    let ends = |values: &[f64]| values.last().unwrap_or(&0.0) - values.first().unwrap_or(&0.0);
    let (by_places_m, by_speeds_m) = (ends(&own.s_m), ends(&integral_m(&own.speed_mps, step_s)));
    let far_m = by_places_m.abs().max(by_speeds_m);
    if far_m < COMPARED_M || far_m <= MOST_RATIO * by_places_m.min(by_speeds_m) {
        return Ok(());
    }
    let what = format!(
        "vehicle \"{}\" drives {by_places_m:.0} m by its positions and {by_speeds_m:.0} m by its speeds",
        own.name
    );
    let remedy = "write speed_mps in m/s (km/h divided by 3.6, mph by 2.237), and s_m and gap_m in m along the driving direction";
    Err((rows.lines[0], what, remedy.into()))
}

/// Checks that a vehicle stays behind the next one ahead.
fn check_apart(behind: &VehicleRows, ahead: &VehicleRows, step_s: f64) -> Result<(), LineFault> {
    let places = behind.trajectory.s_m.iter().zip(&ahead.trajectory.s_m);
    let Some(k) = places.clone().position(|(behind_m, ahead_m)| ahead_m - behind_m < CAR_LENGTH_M) else {
        return Ok(());
    };
    let [one, other] = [behind, ahead].map(|rows| &rows.trajectory);
    let what = format!(
        "vehicle \"{}\" at {:.2} m overlaps vehicle \"{}\" at {:.2} m after {:.1} s; vehicles are {CAR_LENGTH_M} m long",
        one.name,
        one.s_m[k],
        other.name,
        other.s_m[k],
        k as f64 * step_s
    );
    let remedy = "keep the rows of one lane, or leave out one of the two vehicles";
    Err((behind.lines[k], what, remedy.into()))
}

#[cfg(test)]
#[path = "log_file_tests.rs"]
mod tests;
