//! Who came and went. In: the tables of departures and arrivals. Out: one [`Trip`] a vehicle, the ego left out. SI units.

use crate::{
    record::{RecordError, Table, TableReader},
    time::TICKS_PER_S,
};
use std::{collections::BTreeMap, path::Path};

/// Where and when a vehicle came or went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TripEnd {
    /// When.
    pub tick: u64,
    /// SUMO's id of its lane; empty beside all lanes. Of one that went, where it was one step before.
    pub lane: String,
    /// Front bumper along that lane, metres.
    pub lane_s_m: Option<f64>,
}

/// A vehicle from its departure to its arrival, as far as both are in the drive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trip {
    /// Car, van, truck and so on.
    pub kind: String,
    /// Length of the vehicle, metres.
    pub length_m: Option<f64>,
    /// Where it came; at tick 0 those that were there before the drive began.
    pub departed: TripEnd,
    /// Its speed then, m/s.
    pub departed_mps: f64,
    /// Where it went; `None` of one that is there at the end.
    pub arrived: Option<TripEnd>,
    /// Travel time less that of the same way at the speed limits, seconds; `None` of a trip that is not whole, and without the network.
    pub time_loss_s: Option<f64>,
}

impl Trip {
    /// True if it was there when the drive began: when it departed is not known.
    pub fn was_there_before(&self) -> bool {
        self.departed.tick == 0
    }

    /// From departure to arrival, seconds; `None` if either is not in the drive.
    pub fn travel_time_s(&self) -> Option<f64> {
        let arrived = self.arrived.as_ref().filter(|_| !self.was_there_before())?;
        Some(seconds(arrived.tick.saturating_sub(self.departed.tick)))
    }
}

/// Ticks as seconds, with no more digits in a table than hundredths need.
pub fn seconds(ticks: u64) -> f64 {
    ticks as f64 / f64::from(TICKS_PER_S)
}

/// Columns of both tables, and those of departures besides.
const BOTH: [&str; 4] = ["tick", "vehicle", "lane", "lane_s_m"];
const DEPARTURES: [&str; 7] = ["tick", "vehicle", "lane", "lane_s_m", "kind", "length_m", "speed_mps"];

/// The vehicles of a recording that came and went.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TripTable {
    /// By the numbers of the vehicles.
    pub trips: BTreeMap<u32, Trip>,
    /// Arrivals of vehicles without a departure: a recording that lost rows has them.
    pub stray_arrivals: usize,
}

impl TripTable {
    /// Reads the tables of a recording that has them.
    ///
    /// # Errors
    /// A table cannot be read, or is not as this program writes it.
    pub fn read(recording: &Path) -> Result<Self, RecordError> {
        let mut table = Self::default();
        let path = Table::Departures.parquet(recording);
        for part in TableReader::parts(&path, &DEPARTURES)? {
            let part = part?;
            let (kinds, lengths, speeds) = (part.words("kind"), part.numbers("length_m"), part.numbers("speed_mps"));
            for (i, (vehicle, departed)) in ends(&part, &path)?.into_iter().enumerate() {
                let (kind, length_m) = (kinds.get(i).cloned().unwrap_or_default(), lengths[i]);
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
            None => self.stray_arrivals += 1,
        }
    }
}

/// The rows of a part: who, where and when.
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
    fn a_travel_time_is_known_of_those_alone_who_came_and_went_in_the_drive() {
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
        table.arrive(4, TripEnd::default());
        table.arrive(3, TripEnd { tick: 20, ..TripEnd::default() });
        assert_eq!((table.stray_arrivals, table.trips.len()), (1, 1));
        assert_eq!(table.trips[&3].arrived.as_ref().map(|end| end.tick), Some(20));
    }
}
