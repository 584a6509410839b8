//! A recording as a file of trajectories, whose vehicles can be driven behind again (`traffic = FILE.csv`). In: a recorded trial. Out: a CSV
//! file with a row for each step and each vehicle that was on the ego's route during the whole drive, the ego included. Metres, m/s, seconds.

use super::RecordedTrial;
use crate::{analysis::error::AnalysisError, record::RecordError};
use std::{
    collections::BTreeMap,
    fs::File,
    io::{self, BufWriter, Write},
    path::Path,
};

/// Writes the vehicles of a recording as a new file. Positions on a closed route go on from lap to lap. Returns the number of vehicles.
///
/// # Errors
/// The recording cannot be read, the file exists or cannot be written, or no vehicle was on the route all the time.
pub fn write_log(trial: &RecordedTrial, path: &Path) -> Result<usize, AnalysisError> {
    let failed = |why: io::Error| AnalysisError::Input(format!("{}: cannot be written: {why}", path.display()));
    let (mut steps, mut rows) = (0, BTreeMap::<u32, u64>::new());
    for step in trial.steps()? {
        steps += 1;
        for vehicle in step?.vehicles.iter().filter(|vehicle| vehicle.s_m.is_some()) {
            *rows.entry(vehicle.id).or_default() += 1;
        }
    }
    rows.retain(|_, count| *count == steps);
    if rows.is_empty() {
        let text = "no vehicle has a position on the ego's route at every step, so there is no log";
        return Err(AnalysisError::Input(format!("{}: {text}", trial.recording.display())));
    }
    let mut file = BufWriter::new(File::create_new(path).map_err(failed)?);
    write_rows(trial, &rows, &mut file)?.map_err(failed)?;
    Ok(rows.len())
}

/// Writes the rows of these vehicles. The outer result is that of reading, the inner one of writing.
fn write_rows(
    trial: &RecordedTrial,
    vehicles: &BTreeMap<u32, u64>,
    file: &mut impl Write,
) -> Result<io::Result<()>, RecordError> {
    let lap_m = trial.map.as_ref().filter(|map| map.route.is_closed()).map(|map| map.route.length_m());
    let mut places_m: BTreeMap<u32, f64> = BTreeMap::new();
    let mut written = writeln!(file, "time_s,vehicle,s_m,speed_mps");
    for step in trial.steps()? {
        let step = step?;
        let time_s = crate::time::Tick(step.tick).seconds();
        for vehicle in step.vehicles.iter().filter(|vehicle| vehicles.contains_key(&vehicle.id)) {
            let Some(s_m) = vehicle.s_m else { continue };
            let before_m = places_m.get(&vehicle.id).copied().unwrap_or(s_m);
            // The nearest place with this position in some lap.
            let laps = lap_m.map_or(0.0, |lap_m| ((before_m - s_m) / lap_m).round() * lap_m);
            places_m.insert(vehicle.id, s_m + laps);
            written = written.and(writeln!(
                file,
                "{time_s:.2},{},{:.4},{:.4}",
                vehicle.id,
                s_m + laps,
                vehicle.speed_mps.max(0.0)
            ));
        }
    }
    Ok(written.and_then(|()| file.flush()))
}
