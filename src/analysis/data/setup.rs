//! Setup of a drive. In: manifest and scenario of a recording. Out: road, start, advice and driver in words.

use crate::{
    metrics::RoadKinds,
    record::Manifest,
    scenario::{Scenario, StartLayout},
};

/// Setup of a drive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DriveSetup {
    /// Manifest of the recording: program, driver, policy and so on.
    pub manifest: Manifest,
    /// Scenario that was driven.
    pub scenario: Scenario,
    /// Length of the route, metres; 0 if its map is missing.
    pub route_m: f64,
}

impl DriveSetup {
    /// Name of the road, without the folder in which a recording carries it.
    pub fn road(&self) -> String {
        let name = &self.manifest.map.name;
        name.rsplit('/').next().unwrap_or(name).to_owned()
    }

    /// Returns the length of a lap, metres; 0 on an open lane, or if the map is missing.
    pub fn lap_m(&self) -> f64 {
        if self.scenario.traffic.log_file().is_some() { 0.0 } else { self.route_m }
    }

    /// Returns the origin of the advice.
    pub fn advice(&self) -> &'static str {
        match self.scenario.sham_advice {
            _ if self.manifest.policy.name == "none" => "none",
            true => "recorded in another drive (sham)",
            false => "of this drive",
        }
    }

    /// Returns the start of the vehicles in words.
    pub fn start(&self) -> &'static str {
        match self.scenario.start {
            StartLayout::Even => "evenly spaced",
            StartLayout::Bunched => "bunched, with one long gap",
        }
    }

    /// Returns the kind of its road.
    pub fn roads(&self) -> RoadKinds {
        RoadKinds::of_drive(self.scenario.has_path_or_demand())
    }

    /// Checks whether a simulated driver drove.
    pub fn is_simulated(&self) -> bool {
        self.manifest.driver.starts_with("simulated")
    }
}
