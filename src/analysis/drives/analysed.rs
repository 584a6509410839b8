//! Analysis of single drives. In: the recordings found in a folder, and lines for throughput. Out: an [`AnalysedRecording`] for
//! each, with its measures and the data of its figures.

use crate::analysis::{
    data::{DriveSetup, DriverStretches, FoundRecording, RecordedTrial, driver_moments::StretchCollector},
    error::AnalysisError,
    measures::{DriveMeasures, DriveTotals},
    network::{LinePlace, NetworkDriveTotals},
    responses::{AdviceResponse, DriveOnsets, PedalNoise, ScriptedResponse, ScriptedResponses},
};
use crate::metrics::RoadKinds;
use rayon::prelude::*;
use std::{collections::BTreeMap, path::Path};

/// A recording with its measures and the data of its figures.
#[derive(Clone, Debug, PartialEq)]
pub struct AnalysedRecording {
    pub found: FoundRecording,
    pub measures: DriveMeasures,
    /// Mean speed of all vehicles, second by second, m/s.
    pub per_second_mps: Vec<f64>,
    /// Mean speed without advice, second by second, m/s; empty without a baseline.
    pub baseline_per_second_mps: Vec<f64>,
    pub duration_s: f64,
    /// Reason of the end, from the manifest.
    pub ended: String,
    pub setup: DriveSetup,
    /// Stretches for the fit of the driver.
    pub stretches: DriverStretches,
    /// Responses to the events of the scenario.
    pub scripted_responses: Vec<ScriptedResponse>,
    /// Trips and lines of a drive on a network; `None` on a closed route.
    pub network: Option<NetworkDriveTotals>,
}

impl AnalysedRecording {
    /// Returns the changes of the advice with their responses.
    pub fn responses(&self) -> &[AdviceResponse] {
        &self.measures.responses
    }

    /// Returns the time given up because frames came too late, as a share of the drive's length.
    pub fn dropped_share(&self) -> f64 {
        self.measures.get("dropped_s").unwrap_or(0.0) / self.duration_s.max(1e-9)
    }
}

/// Analyses recordings in parallel; calls `done` after each. Throughput on networks is counted at `lines`, or at the middle of
/// the ego's path if there are none.
///
/// # Errors
/// A recording cannot be read, a line is not on its network, or lines were given and no recording is of a network.
pub fn analyse(
    found: &[FoundRecording],
    lines: &[LinePlace],
    done: &(impl Fn() + Sync),
) -> Result<Vec<AnalysedRecording>, AnalysisError> {
    let practice = practice(found)?;
    let one = |found: &FoundRecording| -> Result<AnalysedRecording, AnalysisError> {
        let trial = RecordedTrial::open(&found.recording)?;
        let practice = practice.get(found.participant.as_str());
        let mut stretches = StretchCollector::new(&trial);
        let mut scripted = ScriptedResponses::new(&trial);
        let (totals, responses) = DriveTotals::of(&trial, practice, lines, |ego| {
            stretches.add(ego);
            scripted.add(ego);
        })?;
        let (stretches, scripted_responses) = (stretches.finish(), scripted.finish());
        let of_baseline = |folder: &Path| {
            Ok::<_, AnalysisError>(DriveTotals::of(&RecordedTrial::open(folder)?, None, lines, |_| ())?.0)
        };
        let baseline = found.baseline.as_deref().map(of_baseline).transpose()?;
        let analysed = AnalysedRecording {
            measures: DriveMeasures::of(&trial, &totals, responses, &scripted_responses, baseline.as_ref()),
            per_second_mps: totals.per_second_mps,
            baseline_per_second_mps: baseline.map(|b| b.per_second_mps).unwrap_or_default(),
            duration_s: totals.duration_s,
            stretches,
            ended: trial.ended,
            setup: trial.setup,
            found: found.clone(),
            network: totals.network,
            scripted_responses,
        };
        done();
        Ok(analysed)
    };
    let drives: Vec<AnalysedRecording> = found.par_iter().map(one).collect::<Result<_, _>>()?;
    if let Some(line) = lines.first().filter(|_| drives.iter().all(|drive| drive.network.is_none())) {
        return Err(AnalysisError::Input(format!(
            "--line {}:{}: no recording is of a network; on a closed route, throughput is counted at its \
             start\n  remedy: leave the line out",
            line.name, line.at_m
        )));
    }
    Ok(drives)
}

/// Returns the pedal noise of each participant in practice: of the first drive without a condition that has enough idle time. On a network
/// pedals move for bends, signals and others' right of way, so that such a drive says nothing about idle pedals. Participants without a
/// practice are not in the map.
fn practice(found: &[FoundRecording]) -> Result<BTreeMap<&str, PedalNoise>, AnalysisError> {
    let drives = found.iter().filter(|drive| !drive.participant.is_empty() && drive.condition.is_empty());
    let drives: Vec<&FoundRecording> = drives.collect();
    let noise = |drive: &&FoundRecording| {
        let trial = RecordedTrial::open(&drive.recording)?;
        if trial.setup.roads().networks { Ok(PedalNoise::default()) } else { Ok(DriveOnsets::of(&trial)?.noise) }
    };
    let noises: Vec<PedalNoise> = drives.par_iter().map(noise).collect::<Result<_, AnalysisError>>()?;
    let mut list = BTreeMap::new();
    for (drive, noise) in drives.into_iter().zip(noises) {
        if noise.threshold().is_some() {
            list.entry(drive.participant.as_str()).or_insert(noise);
        }
    }
    Ok(list)
}

/// Returns the kinds of roads of these drives.
pub fn road_kinds<'a>(drives: impl IntoIterator<Item = &'a AnalysedRecording>) -> RoadKinds {
    drives.into_iter().fold(RoadKinds::default(), |kinds, drive| kinds.and(drive.setup.roads()))
}
