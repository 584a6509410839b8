//! All vehicles of a recording, step by step. In: the table of the vehicles. Out: [`TrafficStep`]s with the vehicles by number:
//! on a closed route they are the same at every step, on a network they enter and leave. SI units.

use crate::{
    map::network::{LaneId, Network},
    record::{RecordError, TableParts, TableReader},
    time::TICKS_PER_S,
    traffic::VehicleId,
};
use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    sync::Arc,
    vec::IntoIter,
};

/// Columns that are read.
const CARS: [&str; 6] = ["tick", "car", "s_m", "speed_mps", "lane", "lane_s_m"];

/// A vehicle at the end of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepVehicle {
    /// Number in this drive; 0 is the ego.
    pub id: u32,
    /// Front bumper along the ego's route, metres; `None` beside the route.
    pub s_m: Option<f64>,
    /// Speed of the vehicle, m/s.
    pub speed_mps: f64,
    /// Lane and position of the front bumper along it, metres; `None` beside all lanes.
    pub lane: Option<(LaneId, f64)>,
}

/// All vehicles that have a row at the end of a step, the ego first, then by ascending number.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrafficStep {
    /// Tick at the end of the step.
    pub tick: u64,
    pub vehicles: Vec<StepVehicle>,
}

impl TrafficStep {
    /// Iterates over the speeds, m/s.
    pub fn speeds_mps(&self) -> impl Iterator<Item = f64> {
        self.vehicles.iter().map(|vehicle| vehicle.speed_mps)
    }

    /// Checks for a full second, at which all vehicles have a row, even those far from the ego.
    pub fn has_all(&self) -> bool {
        self.tick.is_multiple_of(u64::from(TICKS_PER_S))
    }

    /// Iterates over the numbers of the vehicles.
    pub fn ids(&self) -> impl Iterator<Item = u32> {
        self.vehicles.iter().map(|vehicle| vehicle.id)
    }
}

/// Iterator over the steps of a drive; rows of one tick are adjacent in the table.
pub struct TrafficSteps {
    path: PathBuf,
    parts: TableParts,
    network: Option<Arc<Network>>,
    persons: BTreeSet<u32>,
    rows: IntoIter<(u64, StepVehicle)>,
    begun: Option<TrafficStep>,
}

impl TrafficSteps {
    /// Opens the table of the vehicles; lanes are looked up if there is a network, and persons on foot and people of events are left out.
    ///
    /// # Errors
    /// The table cannot be read; each step can fail in the same way.
    pub(super) fn open(
        path: &Path,
        network: Option<Arc<Network>>,
        persons: BTreeSet<u32>,
    ) -> Result<Self, RecordError> {
        let parts = TableReader::parts(path, &CARS)?;
        Ok(Self { path: path.into(), parts, network, persons, rows: Vec::new().into_iter(), begun: None })
    }

    /// Returns the rows of a part that have a speed, or the name of a missing column.
    fn rows(&self, part: &TableReader) -> Result<Vec<(u64, StepVehicle)>, &'static str> {
        let (ticks, ids) = (part.wholes(CARS[0]), part.ids(CARS[1]));
        if ticks.len() != part.rows() {
            return Err(CARS[0]);
        }
        let ids = ids.into_iter().collect::<Option<Vec<u32>>>().filter(|ids| ids.len() == part.rows());
        let ids = ids.ok_or(CARS[1])?;
        let [s_m, speeds, lane_s_m] = [CARS[2], CARS[3], CARS[5]].map(|name| part.numbers(name));
        let lanes = self.network.as_ref().map(|network| (network, part.words(CARS[4])));
        let lane = |i: usize| {
            let (network, names) = lanes.as_ref()?;
            Some((network.lane_named(names.get(i)?)?, lane_s_m[i]?))
        };
        let row = |i: usize| {
            if self.persons.contains(&ids[i]) || VehicleId(ids[i]).is_of_event() {
                return None;
            }
            let vehicle = StepVehicle { id: ids[i], s_m: s_m[i], speed_mps: speeds[i]?, lane: lane(i) };
            Some((ticks[i], vehicle))
        };
        Ok((0..part.rows()).filter_map(row).collect())
    }
}

impl Iterator for TrafficSteps {
    type Item = Result<TrafficStep, RecordError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            let Some((tick, vehicle)) = self.rows.next() else {
                match self.parts.next() {
                    None => return self.begun.take().map(Ok),
                    Some(Err(error)) => return Some(Err(error)),
                    Some(Ok(part)) => match self.rows(&part) {
                        Ok(rows) => self.rows = rows.into_iter(),
                        Err(column) => {
                            let why = format!("column {column} is not as this program writes it");
                            return Some(Err(RecordError::Table { path: self.path.clone(), why }));
                        }
                    },
                }
                continue;
            };
            let over = self.begun.take_if(|step| step.tick != tick);
            let step = self.begun.get_or_insert_with(|| TrafficStep { tick, ..TrafficStep::default() });
            step.vehicles.push(vehicle);
            if over.is_some() {
                return over.map(Ok);
            }
        }
    }
}
