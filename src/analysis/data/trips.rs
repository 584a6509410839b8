//! Departures and arrivals. In: the tables of both. Out: one [`Trip`] per vehicle, without the ego. SI units.

use crate::{
    record::{RecordError, Table, TableReader},
    time::TICKS_PER_S,
    traffic::{VehicleId, VehicleKind},
};
use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

/// Place and time of a departure or arrival.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TripEnd {
    pub tick: u64,
    /// SUMO's id of the lane; empty beside all lanes. Of an arrival, the lane one step before.
    pub lane: String,
    /// Front bumper along the lane, metres.
    pub lane_s_m: Option<f64>,
}

/// Trip of a vehicle from departure to arrival, as far as both are in the drive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trip {
    /// Kind of vehicle: car, van, truck and so on.
    pub kind: String,
    /// Length of the vehicle, metres.
    pub length_m: Option<f64>,
    /// Departure; at tick 0 for vehicles that were present before the drive began.
    pub departed: TripEnd,
    /// Speed at departure, m/s.
    pub departed_mps: f64,
    /// Arrival; `None` for a vehicle that is present at the end.
    pub arrived: Option<TripEnd>,
    /// Travel time less the time for the same path at the speed limits, seconds; `None` for an incomplete trip, and without the
    /// network.
    pub time_loss_s: Option<f64>,
}

impl Trip {
    /// Checks whether the vehicle was present when the drive began; its departure time is then unknown.
    pub fn was_there_before(&self) -> bool {
        self.departed.tick == 0
    }

    /// Returns the time from departure to arrival, seconds; `None` if either is not in the drive.
    pub fn travel_time_s(&self) -> Option<f64> {
        let arrived = self.arrived.as_ref().filter(|_| !self.was_there_before())?;
        Some(seconds(arrived.tick.saturating_sub(self.departed.tick)))
    }
}

/// Converts ticks to seconds by division, so that tables show no more than two decimals.
pub fn seconds(ticks: u64) -> f64 {
    ticks as f64 / f64::from(TICKS_PER_S)
}

/// Columns read from both tables, and from the table of departures.
const BOTH: [&str; 4] = ["tick", "vehicle", "lane", "lane_s_m"];
const DEPARTURES: [&str; 7] = ["tick", "vehicle", "lane", "lane_s_m", "kind", "length_m", "speed_mps"];

/// Trips of the vehicles of a recording.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TripTable {
    /// Trips by vehicle number.
    pub trips: BTreeMap<u32, Trip>,
    /// Numbers of persons on foot and people of events, who are no vehicles and make no trips here.
    pub persons: BTreeSet<u32>,
    /// Number of arrivals without a departure, which occur if a recording lost rows.
    pub stray_arrivals: usize,
}

impl TripTable {
    /// Reads both tables of a recording of a network.
    ///
    /// # Errors
    /// A table cannot be read, or does not have this program's format.
    pub fn read(recording: &Path) -> Result<Self, RecordError> {
        let mut table = Self::default();
        let path = Table::Departures.parquet(recording);
        for part in TableReader::parts(&path, &DEPARTURES)? {
            let part = part?;
            let (kinds, lengths, speeds) = (part.words("kind"), part.numbers("length_m"), part.numbers("speed_mps"));
            for (i, (vehicle, departed)) in ends(&part, &path)?.into_iter().enumerate() {
                let (kind, length_m) = (kinds.get(i).cloned().unwrap_or_default(), lengths[i]);
                if kind == VehicleKind::Pedestrian.name() || VehicleId(vehicle).is_of_event() {
                    table.persons.insert(vehicle);
                    continue;
                }
                let departed_mps = speeds[i].unwrap_or_default();
                table.trips.insert(vehicle, Trip { kind, length_m, departed, departed_mps, ..Trip::default() });
            }
        }
        let path = Table::Arrivals.parquet(recording);
        for part in TableReader::parts(&path, &BOTH)? {
            for (vehicle, arrived) in ends(&part?, &path)? {
                table.arrive(vehicle, arrived);
            }
        }
        Ok(table)
    }

    fn arrive(&mut self, vehicle: u32, arrived: TripEnd) {
        match self.trips.get_mut(&vehicle) {
            Some(trip) => trip.arrived = Some(arrived),
            None if self.persons.contains(&vehicle) => {}
            None => self.stray_arrivals += 1,
        }
    }
}

/// Returns the rows of a part: vehicle, place and time.
fn ends(part: &TableReader, path: &Path) -> Result<Vec<(u32, TripEnd)>, RecordError> {
    let (ticks, vehicles, lanes) = (part.wholes("tick"), part.ids("vehicle"), part.words("lane"));
    if [ticks.len(), vehicles.len(), lanes.len()] != [part.rows(); 3] || vehicles.iter().any(Option::is_none) {
        let why = "a column is not as this program writes it".to_owned();
        return Err(RecordError::Table { path: path.into(), why });
    }
    let places = lanes.into_iter().zip(part.numbers("lane_s_m"));
    let rows = ticks.into_iter().zip(vehicles.into_iter().flatten()).zip(places);
    Ok(rows.map(|((tick, vehicle), (lane, lane_s_m))| (vehicle, TripEnd { tick, lane, lane_s_m })).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_trips_within_the_drive_have_a_travel_time() {
        let end = |tick| TripEnd { tick, ..TripEnd::default() };
        let trip = |departed, arrived: Option<u64>| {
            Trip { departed: end(departed), arrived: arrived.map(end), ..Trip::default() }.travel_time_s()
        };
        assert_eq!(trip(450, Some(2460)), Some(20.1));
        assert_eq!((trip(0, Some(2460)), trip(450, None), trip(0, None)), (None, None, None));
    }

    #[test]
    fn an_arrival_whose_departure_was_lost_is_counted_and_makes_no_trip() {
        let mut table = TripTable { trips: [(3, Trip::default())].into(), ..TripTable::default() };
        table.persons.insert(9);
        table.arrive(4, TripEnd::default());
        table.arrive(9, TripEnd::default());
        table.arrive(3, TripEnd { tick: 20, ..TripEnd::default() });
        assert_eq!((table.stray_arrivals, table.trips.len()), (1, 1));
        assert_eq!(table.trips[&3].arrived.as_ref().map(|end| end.tick), Some(20));
    }
}
