//! Tables of drives on networks only: vehicles that enter and leave, states of signals, path of the ego. In: the world before
//! its first tick and after each tick. Out: rows. SI units; lanes by SUMO's ids.
//!
//! The ego is present from the first tick to the last and has no row. A vehicle that enters and leaves within one step is in no
//! snapshot, and thus in neither table.

use super::cars::in_lane;
use crate::{
    map::{
        RoadMap,
        network::{LanePosition, Network, SignalId, SignalStates},
    },
    record::table::{ColumnValue, TableColumn, column, number},
    sim::{Snapshot, World},
    time::Tick,
    traffic::{VehicleBody, VehicleId},
};

/// Vehicle that has entered.
#[derive(Clone, Debug, PartialEq)]
pub struct DepartureRow {
    /// End of the step in which it entered; the tick before the first for vehicles present at the start.
    pub tick: Tick,
    /// Number of the vehicle; never reused in a drive.
    pub vehicle: u32,
    /// Kind and dimensions of the vehicle.
    pub body: VehicleBody,
    /// SUMO's id of its lane; empty off all lanes.
    pub lane: String,
    /// Front bumper along that lane, metres.
    pub lane_s_m: Option<f64>,
    /// Speed at the end of that step, m/s.
    pub speed_mps: f64,
}

/// Columns: one row for each vehicle that has entered.
pub const DEPARTURES: &[TableColumn<DepartureRow>] = &[
    column(
        "tick",
        "",
        "tick at the end of the step in which it came; 0 for vehicles that are there at the start",
        ColumnValue::Whole(|r| r.tick.0),
    ),
    column("vehicle", "", "number of the vehicle: that of car in cars.parquet", ColumnValue::Id(|r| Some(r.vehicle))),
    column(
        "kind",
        "",
        "car, van, truck, bus, motorcycle or bicycle; pedestrian for a person on foot",
        ColumnValue::Word(|r| r.body.kind.name().into()),
    ),
    number("length_m", "m", "bumper to bumper", |r| Some(r.body.length_m)),
    number("width_m", "m", "width", |r| Some(r.body.width_m)),
    number("height_m", "m", "height", |r| Some(r.body.height_m)),
    column("lane", "", "SUMO's id of the lane; empty beside all lanes", ColumnValue::Word(|r| r.lane.clone())),
    number("lane_s_m", "m", "front bumper along the lane", |r| r.lane_s_m),
    number("speed_mps", "m/s", "speed", |r| Some(r.speed_mps)),
];

/// Vehicle that has left.
#[derive(Clone, Debug, PartialEq)]
pub struct ArrivalRow {
    /// End of the step in which it left.
    pub tick: Tick,
    /// Number of the vehicle.
    pub vehicle: u32,
    /// SUMO's id of its lane one step before; empty off all lanes.
    pub lane: String,
    /// Front bumper along that lane one step before, metres.
    pub lane_s_m: Option<f64>,
}

/// Columns: one row for each vehicle that has left.
pub const ARRIVALS: &[TableColumn<ArrivalRow>] = &[
    column("tick", "", "tick at the end of the step in which it went", ColumnValue::Whole(|r| r.tick.0)),
    column("vehicle", "", "number of the vehicle: that of car in cars.parquet", ColumnValue::Id(|r| Some(r.vehicle))),
    column(
        "lane",
        "",
        "SUMO's id of the lane where it was one step before; empty beside all lanes",
        ColumnValue::Word(|r| r.lane.clone()),
    ),
    number("lane_s_m", "m", "front bumper along that lane one step before", |r| r.lane_s_m),
];

/// State of a signal from a tick on.
#[derive(Clone, Debug, PartialEq)]
pub struct SignalRow {
    /// End of the step from which the state holds; the tick before the first for the state at the start.
    pub tick: Tick,
    /// SUMO's id of the signal.
    pub signal: String,
    /// SUMO's letters, one for each link; empty for a signal that SUMO does not switch.
    pub state: String,
}

/// Columns: one row for each signal at the start, and one for each change.
pub const SIGNALS: &[TableColumn<SignalRow>] = &[
    column(
        "tick",
        "",
        "tick at the end of the step from which on it shows this; 0 for what it shows at the start",
        ColumnValue::Whole(|r| r.tick.0),
    ),
    column("signal", "", "SUMO's id of the signal", ColumnValue::Word(|r| r.signal.clone())),
    column(
        "state",
        "",
        "SUMO's letters, one a link: r red, u red and yellow, y yellow, g green that yields, G green, s green arrow, o \
         blinking, O off",
        ColumnValue::Word(|r| r.state.clone()),
    ),
];

/// Lane of the ego's path.
#[derive(Clone, Debug, PartialEq)]
pub struct PathRow {
    /// Index in the path, from 0.
    pub order: u64,
    /// SUMO's id of the edge; begins with a colon inside a junction.
    pub edge: String,
    /// SUMO's id of the lane.
    pub lane: String,
    /// Start of the lane on the path, metres.
    pub start_s_m: f64,
    pub length_m: f64,
}

impl PathRow {
    /// Returns the row of a lane of a map's route. A bridge is named after the lanes before and after it.
    fn of(map: &RoadMap, order: usize) -> Self {
        let (net, lanes) = (&map.network, map.route.lanes());
        let here = &lanes[order];
        let (edge, lane) = match here.is_bridge() {
            true => (":".into(), format!(":{}->{}", lanes[order - 1].id(net), lanes[order + 1].id(net))),
            false => (here.edge_id(net).to_owned(), here.id(net).to_owned()),
        };
        Self { order: order as u64, edge, lane, start_s_m: here.start_s_m, length_m: here.length_m }
    }
}

/// Columns: one row for each lane of the ego's path, in driving order.
pub const PATH: &[TableColumn<PathRow>] = &[
    column("order", "", "place in the path, from 0", ColumnValue::Whole(|r| r.order)),
    column(
        "edge",
        "",
        "SUMO's id of the edge; begins with a colon inside a junction",
        ColumnValue::Word(|r| r.edge.clone()),
    ),
    column(
        "lane",
        "",
        "SUMO's id of the lane; where the path changes lanes on an edge, of that from which it goes on",
        ColumnValue::Word(|r| r.lane.clone()),
    ),
    number("start_s_m", "m", "where it begins on the path, in which s_m of the other tables counts", |r| {
        Some(r.start_s_m)
    }),
    number("length_m", "m", "how long it is", |r| Some(r.length_m)),
];

/// Rows of these tables, to be written or compared.
#[derive(Debug, Default, PartialEq)]
pub(in crate::record) struct NetworkRows {
    pub departures: Vec<DepartureRow>,
    pub arrivals: Vec<ArrivalRow>,
    pub signals: Vec<SignalRow>,
    pub path: Vec<PathRow>,
}

/// Finds vehicles and signal states that are new in a world since the last step.
#[derive(Debug, Default)]
pub(in crate::record) struct NetworkObserver {
    /// Vehicles at the end of the last step, by ascending id, without the ego.
    vehicles: Vec<(VehicleId, Option<LanePosition>)>,
    /// Signal states at the end of the last step; `None` before the start.
    signals: Option<SignalStates>,
}

impl NetworkObserver {
    /// Adds the rows of a world before its first tick.
    pub fn start(&mut self, world: &World, rows: &mut NetworkRows) {
        let map = world.map();
        rows.path.extend((0..map.route.lanes().len()).map(|order| PathRow::of(map, order)));
        self.observe(world.snapshot(), &map.network, rows);
    }

    /// Adds the rows of a world after a tick, if it was started. Vehicles enter and leave, and signals change, at the end of a step.
    pub fn tick(&mut self, world: &World, rows: &mut NetworkRows) {
        let snapshot = world.snapshot();
        if self.signals.is_some() && snapshot.tick.0.is_multiple_of(world.scenario().step_ticks()) {
            self.observe(snapshot, &world.map().network, rows);
        }
    }

    fn observe(&mut self, snapshot: &Snapshot, network: &Network, rows: &mut NetworkRows) {
        self.observe_vehicles(snapshot, network, rows);
        self.observe_signals(snapshot, network, rows);
    }

    fn observe_signals(&mut self, snapshot: &Snapshot, network: &Network, rows: &mut NetworkRows) {
        for (k, signal) in network.signals().iter().enumerate() {
            let id = SignalId::from_index(k);
            let shown = snapshot.signals.letters(id);
            if self.signals.as_ref().is_none_or(|before| before.letters(id) != shown) {
                let state = String::from_utf8_lossy(shown).into_owned();
                rows.signals.push(SignalRow { tick: snapshot.tick, signal: signal.id.clone(), state });
            }
        }
        self.signals.get_or_insert_default().clone_from(&snapshot.signals);
    }

    fn observe_vehicles(&mut self, snapshot: &Snapshot, network: &Network, rows: &mut NetworkRows) {
        let tick = snapshot.tick;
        // Both lists are by ascending id, so one pass is enough.
        let mut before = self.vehicles.iter().peekable();
        let mut arrive = |(id, at): &(VehicleId, Option<LanePosition>)| {
            let (lane, lane_s_m, _) = in_lane(*at, network);
            rows.arrivals.push(ArrivalRow { tick, vehicle: id.0, lane, lane_s_m });
        };
        for car in &snapshot.cars {
            while let Some(gone) = before.next_if(|(id, _)| *id < car.id) {
                arrive(gone);
            }
            if before.next_if(|(id, _)| *id == car.id).is_none() {
                let (lane, lane_s_m, _) = in_lane(car.lane, network);
                let (vehicle, body, speed_mps) = (car.id.0, car.body, car.speed_mps);
                rows.departures.push(DepartureRow { tick, vehicle, body, lane, lane_s_m, speed_mps });
            }
        }
        before.for_each(arrive);
        self.vehicles.clear();
        self.vehicles.extend(snapshot.cars.iter().map(|car| (car.id, car.lane)));
    }
}

#[cfg(test)]
#[path = "networks_tests.rs"]
mod tests;
