//! Tests of vehicles that enter and leave and of signal states, from step to step, against values by hand.

use super::*;
use crate::{sim::VehicleSnapshot, traffic::VehicleKind};

fn grid() -> Network {
    Network::load("tests/data/networks/grid-signals.net.xml").expect("a network")
}

const TRUCK: VehicleBody = VehicleBody { kind: VehicleKind::Truck, length_m: 7.5, width_m: 2.5, height_m: 3.25 };

/// Returns a snapshot with vehicles given by number, lane, distance along it and speed.
fn at(network: &Network, tick: u64, cars: &[(u32, &str, f64, f64)]) -> Snapshot {
    let car = |(id, lane, s_m, speed_mps): &(u32, &str, f64, f64)| VehicleSnapshot {
        id: VehicleId(*id),
        lane: network.lane_named(lane).map(|lane| LanePosition { lane, s_m: *s_m, offset_m: 0.0 }),
        speed_mps: *speed_mps,
        body: TRUCK,
        ..VehicleSnapshot::default()
    };
    Snapshot { tick: Tick(tick), cars: cars.iter().map(car).collect(), ..Snapshot::default() }
}

#[test]
fn new_vehicles_depart_and_missing_vehicles_arrive_at_their_last_lane() {
    let network = grid();
    let steps = [
        at(&network, 0, &[(3, "B0B1_0", 5.0, 1.0), (5, "", 0.0, 2.0)]),
        at(&network, 10, &[(3, "B0B1_0", 6.0, 1.5), (5, "", 0.0, 2.0)]),
        at(&network, 20, &[(2, "B1C1_1", 1.0, 4.0), (5, "B0C0_1", 2.5, 2.0), (9, "B1C1_0", 7.0, 3.0)]),
        at(&network, 30, &[(2, "B1C1_1", 3.0, 4.0)]),
        at(&network, 40, &[]),
    ];
    let mut observer = NetworkObserver::default();
    let mut rows = NetworkRows::default();
    steps.iter().for_each(|step| observer.observe(step, &network, &mut rows));
    let departures: Vec<_> = rows
        .departures
        .iter()
        .map(|row| (row.tick.0, row.vehicle, row.lane.as_str(), row.lane_s_m, row.speed_mps))
        .collect();
    let expected = [
        (0, 3, "B0B1_0", Some(5.0), 1.0),
        (0, 5, "", None, 2.0),
        (20, 2, "B1C1_1", Some(1.0), 4.0),
        (20, 9, "B1C1_0", Some(7.0), 3.0),
    ];
    assert_eq!(departures, expected);
    let arrivals: Vec<_> =
        rows.arrivals.iter().map(|row| (row.tick.0, row.vehicle, row.lane.as_str(), row.lane_s_m)).collect();
    let expected = [
        (20, 3, "B0B1_0", Some(6.0)),
        (30, 5, "B0C0_1", Some(2.5)),
        (30, 9, "B1C1_0", Some(7.0)),
        (40, 2, "B1C1_1", Some(3.0)),
    ];
    assert_eq!(arrivals, expected);
}

#[test]
fn each_signal_has_a_row_at_the_start_and_one_whenever_it_changes() {
    let network = grid();
    // In the order of the file.
    let ids: Vec<&str> = network.signals().iter().map(|signal| signal.id.as_str()).collect();
    assert_eq!(ids, ["A1", "B0", "B1", "B2", "C1"]);
    let step = |tick: u64, letters: &[u8]| {
        let mut snapshot = at(&network, tick, &[]);
        // Two links of the first signal, none of the second, one of each other.
        snapshot.signals.set(letters, &[0, 2, 2, 3, 4, 5]);
        snapshot
    };
    let mut observer = NetworkObserver::default();
    let mut rows = NetworkRows::default();
    for (tick, letters) in [(0, b"rGyGg"), (10, b"rGyGg"), (20, b"ruyGo"), (30, b"ruyGo"), (40, b"rGyGo")] {
        observer.observe(&step(tick, letters), &network, &mut rows);
    }
    let found: Vec<_> = rows.signals.iter().map(|row| (row.tick.0, row.signal.as_str(), row.state.as_str())).collect();
    let start = [(0, "A1", "rG"), (0, "B0", ""), (0, "B1", "y"), (0, "B2", "G"), (0, "C1", "g")];
    assert_eq!(found[..5], start);
    assert_eq!(found[5..], [(20, "A1", "ru"), (20, "C1", "o"), (40, "A1", "rG")]);
}

/// Returns a row as text, by column name; numbers to three digits, empty as `-`.
fn cells<R>(columns: &[TableColumn<R>], row: &R) -> String {
    let text = |column: &TableColumn<R>| match column.get {
        ColumnValue::Number(get) => get(row).map_or("-".into(), |v| format!("{v:.3}")),
        ColumnValue::Whole(get) => get(row).to_string(),
        ColumnValue::Id(get) => get(row).map_or("-".into(), |v| v.to_string()),
        ColumnValue::Flag(get) => get(row).map_or("-".into(), |v| v.to_string()),
        ColumnValue::Word(get) => get(row),
    };
    columns.iter().map(|column| format!("{} {}", column.name, text(column))).collect::<Vec<_>>().join(", ")
}

#[test]
fn rows_of_network_tables_have_the_values_of_their_fields() {
    let lane = || "B0B1_0".to_owned();
    let row =
        DepartureRow { tick: Tick(20), vehicle: 4, body: TRUCK, lane: lane(), lane_s_m: Some(5.5), speed_mps: 1.25 };
    let expected = "tick 20, vehicle 4, kind truck, length_m 7.500, width_m 2.500, height_m 3.250, lane B0B1_0, \
                    lane_s_m 5.500, speed_mps 1.250";
    assert_eq!(cells(DEPARTURES, &row), expected);
    let row = ArrivalRow { tick: Tick(30), vehicle: 4, lane: lane(), lane_s_m: None };
    assert_eq!(cells(ARRIVALS, &row), "tick 30, vehicle 4, lane B0B1_0, lane_s_m -");
    let row = SignalRow { tick: Tick(40), signal: "B1".into(), state: "rGy".into() };
    assert_eq!(cells(SIGNALS, &row), "tick 40, signal B1, state rGy");
    let row = PathRow { order: 2, edge: "B0B1".into(), lane: lane(), start_s_m: 12.5, length_m: 81.25 };
    assert_eq!(cells(PATH, &row), "order 2, edge B0B1, lane B0B1_0, start_s_m 12.500, length_m 81.250");
}

#[test]
fn only_recordings_of_networks_have_these_tables() {
    use super::super::{Manifest, Table};
    let names = |network_tables| -> Vec<&str> {
        let manifest = Manifest { network_tables, ..Manifest::default() };
        Table::of(&manifest).iter().map(|table| table.name()).collect()
    };
    assert_eq!(names(false), ["ego", "cars", "advice", "frames", "events"]);
    assert_eq!(names(true), ["ego", "cars", "advice", "frames", "events", "departures", "arrivals", "signals", "path"]);
    // The manifest of a ring has no key for network tables.
    assert!(!serde_json::to_string(&Manifest::default()).expect("words").contains("network_tables"));
}
