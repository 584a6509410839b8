//! Sums of a drive on a network. In: its steps in order. Out: [`NetworkDriveTotals`]: distance and time of all vehicles, their
//! trips, counts at lines, and the ego's time loss against the speed limits. SI units. The size grows with the number of
//! vehicles, not with their time.

use super::cross_section::{CrossSection, LineCount, LinePlace, RowPlace};
use crate::analysis::{
    data::{RecordedTrial, StepVehicle, TrafficStep, Trip, TripTable},
    error::AnalysisError,
};
use crate::{map::network::Network, time::Tick, traffic::EGO};
use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

/// Sums of a drive on a network.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NetworkDriveTotals {
    /// Trips by vehicle number, without the ego.
    pub trips: BTreeMap<u32, Trip>,
    /// Counts at the lines, the ego included.
    pub lines: Vec<LineCount>,
    /// Sentences on what this recording lacks, and why.
    pub missing: Vec<String>,
    /// Number of vehicles at any time, the ego included.
    pub vehicles: usize,
    /// Time of the ego less the time for its path at the speed limits, seconds; `None` without the network.
    pub ego_time_loss_s: Option<f64>,
    /// Network and tracks, released by `finish`.
    network: Option<Arc<Network>>,
    tracks: BTreeMap<u32, VehicleTrack>,
}

/// State of a vehicle at its last row.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct VehicleTrack {
    /// Place in the last row with a lane.
    place: Option<RowPlace>,
    /// Tick of the last known speed, and that speed as a share of the limit.
    pace: Option<(u64, f64)>,
    /// Time less the time for the same path at the limits, seconds.
    loss_s: f64,
}

impl VehicleTrack {
    /// Starts the track of a vehicle without a row yet, at its departure.
    fn departed(trip: &Trip, network: &Network) -> Self {
        let (tick, speed_mps) = (trip.departed.tick, trip.departed_mps);
        let mut track = Self::default();
        if let (Some(lane), Some(s_m)) = (network.lane_named(&trip.departed.lane), trip.departed.lane_s_m) {
            track.place = Some(RowPlace { tick, lane, s_m, speed_mps });
            track.pace = Some((tick, speed_mps / network.lane(lane).speed_limit_mps.max(0.1)));
        }
        track
    }
}

impl NetworkDriveTotals {
    /// Opens the sums of a drive; `lines` are the lines that were asked for, else the default line of its path is taken.
    ///
    /// # Errors
    /// A line is not on the network.
    pub fn open(trial: &RecordedTrial, table: TripTable, lines: &[LinePlace]) -> Result<Self, AnalysisError> {
        let mut totals = Self { trips: table.trips, ..Self::default() };
        if table.stray_arrivals > 0 {
            totals.missing.push(format!(
                "The recording has lost rows: {} of its vehicles arrive without a departure and have no travel time.",
                table.stray_arrivals
            ));
        }
        let Some(map) = &trial.map else {
            if let Some(line) = lines.first() {
                return Err(AnalysisError::Input(format!(
                    "--line {}:{}: {}: the road of the recording is no longer on this machine, so the line cannot be \
                     found\n  remedy: leave the line out",
                    line.name,
                    line.at_m,
                    trial.recording.display()
                )));
            }
            totals.missing.push(
                "The road of the recording is no longer on this machine. Throughput at a line, time lost and the \
                 figure of the ego's path are missing."
                    .into(),
            );
            return Ok(totals);
        };
        let sections: Vec<CrossSection> = if lines.is_empty() {
            CrossSection::middle_of_path(map).into_iter().collect()
        } else {
            lines.iter().map(|line| line.resolve(&map.network, &trial.recording)).collect::<Result<_, _>>()?
        };
        totals.lines = sections.into_iter().map(LineCount::new).collect();
        totals.network = Some(Arc::clone(&map.network));
        Ok(totals)
    }

    /// Adds the vehicles with a row at the next step.
    pub fn add_step(&mut self, step: &TrafficStep) {
        for vehicle in &step.vehicles {
            self.follow(step.tick, vehicle);
        }
    }

    /// Moves a vehicle from its last row, or its departure, to this row.
    fn follow(&mut self, tick: u64, vehicle: &StepVehicle) {
        let Some(network) = self.network.clone() else {
            self.tracks.insert(vehicle.id, VehicleTrack::default());
            return;
        };
        let mut track = self.tracks.get(&vehicle.id).copied().unwrap_or_else(|| {
            self.trips
                .get(&vehicle.id)
                .map_or_else(VehicleTrack::default, |trip| VehicleTrack::departed(trip, &network))
        });
        let now = vehicle.lane.map(|(lane, s_m)| RowPlace { tick, lane, s_m, speed_mps: vehicle.speed_mps });
        self.advance(&mut track, tick, now, vehicle.speed_mps, &network);
        self.tracks.insert(vehicle.id, track);
    }

    fn advance(
        &mut self,
        track: &mut VehicleTrack,
        tick: u64,
        now: Option<RowPlace>,
        speed_mps: f64,
        network: &Network,
    ) {
        // Beside all lanes, the limit of the vehicle's last lane holds.
        let lane = now.or(track.place).map(|place| place.lane);
        let pace = lane.map(|lane| speed_mps / network.lane(lane).speed_limit_mps.max(0.1));
        if let (Some((since, before)), Some(pace)) = (track.pace, pace) {
            track.loss_s += Tick(tick.saturating_sub(since)).seconds() * (1.0 - (before + pace) / 2.0);
        }
        track.pace = pace.map(|pace| (tick, pace)).or(track.pace);
        let Some(now) = now else { return };
        if let Some(before) = track.place.filter(|before| before.tick < tick) {
            self.lines.iter_mut().for_each(|line| line.pass(network, &before, &now));
        }
        track.place = Some(now);
    }

    /// Ends the sums after all steps, which are `step_ticks` apart: trips are followed to their ends.
    pub fn finish(&mut self, step_ticks: u64) {
        self.vehicles = self.trips.keys().chain(self.tracks.keys()).chain([&EGO.0]).collect::<BTreeSet<_>>().len();
        if let Some(network) = self.network.take() {
            self.finish_trips(step_ticks, &network);
        }
        self.tracks.clear();
    }

    fn finish_trips(&mut self, step_ticks: u64, network: &Network) {
        self.ego_time_loss_s = self.tracks.get(&EGO.0).and_then(|track| track.pace.map(|_| track.loss_s));
        for (id, mut trip) in std::mem::take(&mut self.trips) {
            if let Some(arrived) = &trip.arrived {
                let mut track = self.tracks.get(&id).copied().unwrap_or_else(|| VehicleTrack::departed(&trip, network));
                // The table has the place one step before the arrival; the speed is that of the last row.
                let last_tick = arrived.tick.saturating_sub(step_ticks);
                let speed_mps = track.place.map_or(0.0, |place| place.speed_mps);
                let lane = network.lane_named(&arrived.lane).zip(arrived.lane_s_m);
                let now = lane.map(|(lane, s_m)| RowPlace { tick: last_tick, lane, s_m, speed_mps });
                self.advance(&mut track, last_tick, now, speed_mps, network);
                let rest =
                    track.pace.map(|(since, pace)| Tick(arrived.tick.saturating_sub(since)).seconds() * (1.0 - pace));
                trip.time_loss_s = trip.travel_time_s().and(rest).map(|rest_s| track.loss_s + rest_s);
            }
            self.trips.insert(id, trip);
        }
    }

    /// Returns the travel times of complete trips, seconds, sorted.
    pub fn travel_times_s(&self) -> Vec<f64> {
        let mut times: Vec<f64> = self.trips.values().filter_map(Trip::travel_time_s).collect();
        times.sort_by(f64::total_cmp);
        times
    }

    /// Returns the mean time loss of complete trips, seconds.
    pub fn mean_time_loss_s(&self) -> Option<f64> {
        let losses: Vec<f64> = self.trips.values().filter_map(|trip| trip.time_loss_s).collect();
        (!losses.is_empty()).then(|| losses.iter().sum::<f64>() / losses.len() as f64)
    }

    /// Returns the number of vehicles that departed in the drive, and the number that arrived.
    pub fn departures_and_arrivals(&self) -> [usize; 2] {
        let departed = self.trips.values().filter(|trip| !trip.was_there_before()).count();
        let arrived = self.trips.values().filter(|trip| trip.arrived.is_some()).count();
        [departed, arrived]
    }
}

#[cfg(test)]
#[path = "totals_tests.rs"]
mod tests;
