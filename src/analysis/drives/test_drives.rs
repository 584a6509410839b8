//! Analysed drives made up by hand, for tests.

use super::AnalysedRecording;
use crate::analysis::{
    data::{DriveSetup, DriverStretches, FoundRecording},
    measures::{DriveMeasures, MEASURES},
    network::NetworkDriveTotals,
};

/// Returns a trial of a participant in which every measure is `value`, or missing.
pub(crate) fn drive(participant: &str, condition: &str, rank: usize, value: Option<f64>) -> AnalysedRecording {
    let found = FoundRecording {
        participant: participant.into(),
        segment: "trial".into(),
        condition: condition.into(),
        rank,
        ..FoundRecording::default()
    };
    let measures = DriveMeasures { values: vec![value; MEASURES.len()], responses: Vec::new() };
    let per_second_mps = value.map_or(Vec::new(), |v| vec![v; 12]);
    let (baseline_per_second_mps, ended) = (Vec::new(), "duration".to_owned());
    AnalysedRecording {
        found,
        measures,
        per_second_mps,
        baseline_per_second_mps,
        duration_s: 12.0,
        ended,
        setup: DriveSetup::default(),
        stretches: DriverStretches::default(),
        network: None,
        scripted_responses: Vec::new(),
    }
}

/// Returns trials of two participants in two conditions; one has no values.
pub(crate) fn drives() -> Vec<AnalysedRecording> {
    vec![
        drive("sub-P01", "few & <fast>", 0, Some(2.0)),
        drive("sub-P01", "many", 1, Some(4.0)),
        drive("sub-P02", "few & <fast>", 0, Some(3.0)),
        drive("sub-P02", "many", 1, None),
    ]
}

/// Returns the trials of [`drives`], with the first participant on a network.
pub(crate) fn mixed_drives() -> Vec<AnalysedRecording> {
    let mut drives = drives();
    for drive in &mut drives[..2] {
        drive.setup.scenario.path = "A0B0 B0B1".into();
        drive.setup.manifest.traffic = "SUMO 1.28.0 in process".into();
        drive.network.insert(NetworkDriveTotals::default()).vehicles = 40;
    }
    drives
}
