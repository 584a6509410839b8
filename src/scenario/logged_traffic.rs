//! The vehicles of a file of trajectories on the lane of a drive, and the simulated vehicles behind them. In: a scenario whose `traffic`
//! is a file, and its road. Out: a [`TrafficLog`] along the road, and the place and speed of every vehicle at its start. Metres, m/s.
//!
//! The order on the lane, from the front: the vehicles of the file, the ego, the other simulated vehicles. All simulated vehicles start
//! at the speed of the vehicle ahead of the ego, each at the equilibrium gap of its own driver. Behind a named vehicle, the ego is the only
//! simulated one, in the gap between two vehicles of the file, which do not react to it.

use super::{PlanError, Scenario};
use crate::{
    map::RoadMap,
    metrics::traffic_moments::read_log,
    space::CAR_LENGTH_M,
    toml_text::did_you_mean,
    traffic::{CarFollowing, EngineChoice, InitialVehicle, LoggedVehicle, TrafficDrivers, TrafficLog},
};
use std::sync::Arc;

/// Largest gap at the start, m: near its desired speed a driver's equilibrium gap grows without bound.
const MOST_GAP_M: f64 = 150.0;
/// Smallest gap at the start, m.
const LEAST_GAP_M: f64 = 1.0;
/// Largest number of names that a message lists.
const MOST_NAMES: usize = 20;
/// Name of a shipped road for logs.
const LANE: &str = "lane-10km";

/// Vehicles of a file, and the start of all vehicles.
#[derive(Clone, Debug)]
pub struct LoggedTraffic {
    /// Vehicles of the file along the road.
    pub log: Arc<TrafficLog>,
    /// Time for which the file can be driven on the road, s from its first row.
    pub lasts_s: f64,
    /// Index in the log of the vehicle ahead of the ego.
    leader: usize,
    /// Vehicles at their start: the ego, those of the file from the rear to the front, and the others from the front to the rear.
    pub starts: Vec<InitialVehicle>,
}

/// Returns the fault of a setting.
fn fault(key: &'static str, message: String) -> PlanError {
    PlanError::Setting { key, part: String::new(), message }
}

impl LoggedTraffic {
    /// Reads the scenario's file and places all vehicles; `None` if the traffic is no file.
    ///
    /// # Errors
    /// The file cannot be driven, the road is closed or too short, or a setting contradicts the file.
    pub(super) fn of(scenario: &Scenario, map: &RoadMap, drivers: &TrafficDrivers) -> Result<Option<Self>, PlanError> {
        let Some(file) = scenario.traffic.log_file() else { return Ok(None) };
        let name = file.display();
        if map.route.is_closed() {
            let message = format!(
                "map is {}, a closed route; allowed with traffic {name}: an open road\n  remedy: map {LANE}, a lane of \
                 codrive map lane, or a map whose route is open",
                scenario.map
            );
            return Err(fault("map", message));
        }
        let read = read_log(file).map_err(|error| fault("traffic", error.to_string()))?;
        let step_s = read.step_s;
        let vehicles = read.vehicles.into_iter().map(|own| LoggedVehicle {
            name: own.name,
            s_m: own.s_m,
            speed_mps: own.speed_mps,
        });
        let log = TrafficLog::new(step_s, vehicles.collect());
        check_time(scenario, &log)?;
        let leader = leader(scenario, &log)?;
        let limit_mps = map.route.speed_limit_mps(0.0);
        let gap_m =
            |id: usize, speed_mps: f64| gap_m(&drivers.driver(scenario.seed, id as u32).model, speed_mps, limit_mps);
        let logged = log.vehicles().len();
        let (ahead_m, speed_mps) = log.at(leader, 0.0);
        let mut rear_m = ahead_m - CAR_LENGTH_M;
        let mut fronts_m = Vec::new();
        if leader == 0 {
            let simulated = (scenario.vehicles as usize).saturating_sub(logged).max(1);
            for id in std::iter::once(0).chain(logged + 1..logged + simulated) {
                fronts_m.push(rear_m - gap_m(id, speed_mps));
                rear_m = fronts_m[fronts_m.len() - 1] - CAR_LENGTH_M;
            }
        } else {
            let room_m = room_m(&log, leader)?;
            fronts_m.push(rear_m - gap_m(0, speed_mps).min(room_m / 2.0));
            rear_m = log.at(0, 0.0).0 - CAR_LENGTH_M;
        }
        let by_m = (-rear_m).max(0.0);
        let log = log.moved(by_m);
        let lasts_s = lasts_s(scenario, map, &log)?;
        let at = |s_m: &f64| InitialVehicle { s_m: s_m + by_m, speed_mps };
        let of_log = (0..logged).map(|k| {
            let (s_m, speed_mps) = log.at(k, 0.0);
            InitialVehicle { s_m, speed_mps }
        });
        let starts = fronts_m[..1].iter().map(at).chain(of_log).chain(fronts_m[1..].iter().map(at)).collect();
        Ok(Some(Self { starts, leader, lasts_s, log: Arc::new(log) }))
    }

    /// Returns the number of vehicles of the file.
    pub fn logged(&self) -> u32 {
        self.log.vehicles().len() as u32
    }

    /// Returns the mean speed of the vehicle ahead of the ego between two times of the file, m/s.
    pub(super) fn mean_speed_mps(&self, from_s: f64, to_s: f64) -> f64 {
        let at_m = |time_s: f64| self.log.at(self.leader, time_s.min(self.log.length_s())).0;
        (at_m(to_s) - at_m(from_s)) / (to_s - from_s)
    }

    /// Returns the number of simulated vehicles, the ego included.
    pub fn simulated(&self) -> u32 {
        self.starts.len() as u32 - self.logged()
    }

    /// Returns the number of the `k`-th simulated vehicle behind those of the file; the ego is the first.
    pub fn id_of(&self, k: u32) -> u32 {
        if k == 0 { 0 } else { self.logged() + k }
    }
}

/// Finds the vehicle ahead of the ego: that of the scenario's name, or the last of the log.
fn leader(scenario: &Scenario, log: &TrafficLog) -> Result<usize, PlanError> {
    let name = scenario.traffic_leader.trim();
    let names: Vec<&str> = log.vehicles().iter().map(|vehicle| vehicle.name.as_str()).collect();
    if name.is_empty() {
        return Ok(0);
    }
    names.iter().position(|known| *known == name).ok_or_else(|| {
        let (near, most) = (did_you_mean(name, &names), names.len().min(MOST_NAMES));
        let more = if names.len() > most { ", ..." } else { "" };
        let message = format!(
            "traffic_leader is \"{name}\"{near}; allowed: a vehicle of {}: {}{more}",
            scenario.traffic,
            names[..most].join(", ")
        );
        fault("traffic_leader", message)
    })
}

/// Returns the room beyond the ego's length in the gap behind a vehicle of the log, m.
fn room_m(log: &TrafficLog, leader: usize) -> Result<f64, PlanError> {
    let [ahead, behind] = [leader, leader - 1].map(|k| &log.vehicles()[k]);
    let gap_m = ahead.s_m[0] - CAR_LENGTH_M - behind.s_m[0];
    let needed_m = CAR_LENGTH_M + 2.0 * LEAST_GAP_M;
    if gap_m >= needed_m {
        return Ok(gap_m - CAR_LENGTH_M);
    }
    Err(fault(
        "traffic_leader",
        format!(
            "traffic_leader is \"{}\"; the gap from it to vehicle \"{}\" is {gap_m:.1} m at the start, and the ego needs {needed_m} m\n  \
             remedy: another vehicle, or leave vehicle \"{}\" out of the file",
            ahead.name, behind.name, behind.name
        ),
    ))
}

/// Returns the gap at which a driver keeps this speed, m: within [`LEAST_GAP_M`] and [`MOST_GAP_M`].
fn gap_m(model: &CarFollowing, speed_mps: f64, limit_mps: f64) -> f64 {
    let (mut low_m, mut high_m) = (LEAST_GAP_M, MOST_GAP_M);
    // Halved 50 times, the interval is shorter than a rounding error.
    for _ in 0..50 {
        let middle_m = (low_m + high_m) / 2.0;
        let is_enough = model.acceleration(speed_mps, speed_mps, middle_m, limit_mps) >= 0.0;
        if is_enough { high_m = middle_m } else { low_m = middle_m }
    }
    high_m
}

/// Checks that the file lasts as long as the drive.
fn check_time(scenario: &Scenario, log: &TrafficLog) -> Result<(), PlanError> {
    let (needed_s, has_s) = (scenario.warm_up_s + scenario.duration_s, log.length_s());
    // Half a step: times of a file are rounded.
    let spare_s = scenario.step_s / 2.0;
    if has_s + spare_s >= needed_s && has_s + spare_s >= scenario.warm_up_s + scenario.step_s {
        return Ok(());
    }
    let traffic = &scenario.traffic;
    let left_s = (has_s - scenario.warm_up_s).floor();
    let remedy = match left_s > 0.0 {
        true => format!("duration {left_s} (in evaluations the horizon), or 0 for as long as file and lane allow"),
        false => "a shorter warm_up, or a longer file".into(),
    };
    Err(fault(
        "duration_s",
        format!(
            "{traffic} ends after {has_s:.1} s; the drive needs {needed_s:.1} s (warm_up {} s, duration {} s)\n  remedy: {remedy}",
            scenario.warm_up_s, scenario.duration_s
        ),
    ))
}

/// Returns the time for which the file can be driven on the lane, s: until its end, or until its first vehicle is at the end of the lane.
///
/// # Errors
/// A drive of the scenario's duration, or the first step of one without, needs a longer lane.
fn lasts_s(scenario: &Scenario, map: &RoadMap, log: &TrafficLog) -> Result<f64, PlanError> {
    let (first, length_m) = (log.vehicles().len() - 1, map.route.length_m());
    // Rounded times of a file count as whole steps.
    let steps = (log.length_s() / scenario.step_s + 1e-6).floor() as u64;
    let times_s = (0..=steps).map(|k| k as f64 * scenario.step_s);
    let lasts_s = times_s.take_while(|time_s| log.at(first, *time_s).0 <= length_m).last().unwrap_or(0.0);
    let needed_s = scenario.warm_up_s + scenario.duration_s.max(scenario.step_s);
    if lasts_s + scenario.step_s / 2.0 >= needed_s {
        return Ok(lasts_s);
    }
    let end_m = log.at(first, needed_s).0;
    Err(fault(
        "map",
        format!(
            "map {} is {length_m:.0} m long; vehicle \"{}\" of {} reaches its end after {lasts_s:.0} s, and {end_m:.0} m in {needed_s:.0} s\n  \
             remedy: a shorter duration, or a longer lane: codrive map lane --length {:.0}",
            scenario.map,
            log.vehicles()[first].name,
            scenario.traffic,
            (end_m / 100.0).ceil() * 100.0
        ),
    ))
}

impl Scenario {
    /// Checks the settings that are not for traffic of a file. The error has the key and the message.
    pub(super) fn check_logged(&self) -> Result<(), (&'static str, String)> {
        let EngineChoice::Log(file) = &self.traffic else {
            let text = "allowed: empty, because only traffic FILE.csv has vehicles with names";
            let has_leader = !self.traffic_leader.trim().is_empty();
            let fault = has_leader
                .then(|| ("traffic_leader", format!("traffic_leader is \"{}\"; {text}", self.traffic_leader)));
            return fault.map_or(Ok(()), Err);
        };
        let settings = [
            ("path", !self.path.trim().is_empty(), self.path.clone(), "empty; the vehicles drive the map's own road"),
            ("demand", !self.demand.is_empty(), "not empty".into(), "none; the file has the other vehicles"),
            ("wave_sd_mps", self.wave_sd_mps > 0.0, self.wave_sd_mps.to_string(), "0; the file decides on waves"),
            ("standing_start", self.standing_start, "true".into(), "false; the file decides when vehicles stand"),
            (
                "sham_advice",
                self.sham_advice,
                "true".into(),
                "false; sham advice comes from another drive on a closed route",
            ),
        ];
        match settings.into_iter().find(|(_, is_fault, ..)| *is_fault) {
            Some((key, _, value, allowed)) => {
                Err((key, format!("{key} is {value}; allowed with traffic {file}: {allowed}")))
            }
            None => Ok(()),
        }
    }
}

#[cfg(test)]
#[path = "logged_traffic_tests.rs"]
mod tests;
