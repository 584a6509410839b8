//! Summary of a drive of five ticks, computed by hand.

use super::*;
use crate::{
    ego::EgoState,
    policy::{Action, Advice},
    roadside::fixed_objects::FixedObjectKind,
    sim::{
        Leader, VehicleSnapshot,
        event::{Event, EventKind},
    },
    time::Tick,
    traffic::{VehicleId, VehicleKind},
};

fn snapshot(tick: u64, ego_mps: f64, car_mps: f64, gap_m: Option<f64>, target_mps: Option<f64>) -> Snapshot {
    let ego = EgoState { speed_mps: ego_mps, ..EgoState::default() };
    let car = VehicleSnapshot { id: VehicleId(1), speed_mps: car_mps, ..VehicleSnapshot::default() };
    Snapshot {
        tick: Tick(tick),
        ego,
        ego_before: ego,
        cars: vec![car],
        leader: gap_m.map(|gap_m| Leader { id: VehicleId(1), gap_m, speed_mps: car_mps }),
        advice: target_mps.map(advice),
        mean_speed_mps: 0.5 * (ego_mps + car_mps),
        ..Snapshot::default()
    }
}

/// Returns an advice with an acceptable range of half a metre per second on either side.
fn advice(target_mps: f64) -> Advice {
    let action = Action::Speed(target_mps);
    Advice {
        issued: Tick(0),
        hold: crate::policy::Hold::of_steps(1, 0.1),
        action,
        target_mps,
        range_mps: 0.5,
        is_fallback: false,
        driver: None,
        observed: None,
    }
}

/// Returns a drive with the ego at 1 to 5 m/s behind a car at 2 m/s; the gap is smallest after the window.
fn drive() -> Vec<Snapshot> {
    vec![
        snapshot(1, 1.0, 2.0, Some(7.0), Some(1.0)),
        snapshot(2, 2.0, 2.0, None, Some(2.5)),
        snapshot(3, 3.0, 2.0, Some(4.25), None),
        snapshot(4, 4.0, 2.0, Some(6.0), Some(3.0)),
        snapshot(5, 5.0, 2.0, Some(3.5), Some(5.0)),
    ]
}

fn summary(window_s: [f64; 2], drive: &[Snapshot], events: &[Event]) -> Summary {
    let mut summary = SummaryAccumulator::new(window_s);
    for snapshot in drive {
        let of: Vec<Event> = events.iter().copied().filter(|event| event.tick == snapshot.tick).collect();
        summary.add(snapshot, &of);
    }
    summary.to_summary()
}

#[test]
fn means_are_over_the_window_and_the_least_gap_over_the_whole_drive() {
    let found = summary([0.02, 0.04], &drive(), &[]);
    // Speeds in the window are 2, 3, 4 of the ego and 2, 2, 2 of the other vehicle: a sum of 15 over 6, and 41 of the squares.
    assert_eq!((found.mean_speed_mps, found.ego_mean_speed_mps), (Some(2.5), Some(3.0)));
    let sd_mps = found.speed_sd_over_vehicles_and_time_mps.unwrap();
    assert!((sd_mps - (41.0_f64 / 6.0 - 6.25).sqrt()).abs() < 1e-12, "{sd_mps}: N, not N-1");
    // There is advice at tick 2 (in range, at its edge) and tick 4 (out of range).
    assert_eq!(found.time_in_range, Some(0.5));
    assert_eq!(found.min_gap_m, Some(3.5));
    assert_eq!((found.window_s, found.duration_s), ([0.02, 0.04], 0.05));
    // A window longer than the drive ends with the drive.
    let whole = summary([0.0, f64::INFINITY], &drive(), &[]);
    assert_eq!((whole.window_s, whole.ego_mean_speed_mps), ([0.0, 0.05], Some(3.0)));
    assert_eq!((whole.mean_speed_mps, whole.time_in_range), (Some(2.5), Some(0.75)));
}

#[test]
fn missing_quantities_are_none() {
    let nothing = SummaryAccumulator::new([0.0, 1.0]).to_summary();
    assert_eq!(
        (nothing.mean_speed_mps, nothing.speed_sd_over_vehicles_and_time_mps, nothing.ego_mean_speed_mps),
        (None, None, None)
    );
    assert_eq!((nothing.time_in_range, nothing.min_gap_m, nothing.ended), (None, None, None));
    // A drive that ends before its window has a gap and no mean.
    let early = summary([1.0, 2.0], &drive(), &[]);
    assert_eq!((early.mean_speed_mps, early.min_gap_m), (None, Some(3.5)));
    let alone = summary([0.0, 1.0], &[snapshot(1, 2.0, 3.0, None, None)], &[]);
    assert_eq!(
        (alone.min_gap_m, alone.time_in_range, alone.speed_sd_over_vehicles_and_time_mps),
        (None, None, Some(0.5))
    );
}

#[test]
fn events_are_counted_and_contacts_keep_their_numbers() {
    let at = |tick: u64, kind: EventKind| Event { tick: Tick(tick), kind };
    let contact = EventKind::Contact {
        car: VehicleId(7),
        kind: VehicleKind::Car,
        ego_speed_mps: 4.0,
        car_speed_mps: 3.0,
        closing_mps: 1.25,
        angle_rad: 0.0,
    };
    let events = [
        at(1, EventKind::Advice(advice(1.0))),
        at(2, EventKind::Advice(advice(2.5))),
        at(3, EventKind::LeftRoad { s_m: 3.0, offset_m: 2.0 }),
        at(4, EventKind::BackOnRoad),
        at(4, contact),
        at(4, EventKind::ObjectContact { object: FixedObjectKind::Building, ego_speed_mps: 4.0, closing_mps: 1.0 }),
        at(5, EventKind::Ended(EndReason::Contact)),
    ];
    let found = summary([0.0, 0.01], &drive(), &events);
    assert_eq!((found.advices, found.left_road, found.ended), (2, 1, Some(EndReason::Contact)));
    let record = ContactRecord { time_s: 0.04, car: 7, ego_speed_mps: 4.0, car_speed_mps: 3.0, closing_mps: 1.25 };
    assert_eq!((found.contacts, found.contact_count, found.object_contacts), (vec![record], 1, 1));
}

#[test]
fn the_hash_depends_on_every_snapshot_and_their_order() {
    let all = [0.0, f64::INFINITY];
    let [first, again] = [(); 2].map(|()| summary(all, &drive(), &[]).hash);
    assert_eq!(first, again);
    let mut other = drive();
    other[2].ego.speed_mps = f64::from_bits(3.0_f64.to_bits() + 1);
    assert_ne!(summary(all, &other, &[]).hash, first, "the last bit of one speed");
    let mut swapped = drive();
    swapped.swap(1, 2);
    assert_ne!(summary(all, &swapped, &[]).hash, first);
}

#[test]
fn a_drive_of_days_lists_its_first_contacts_and_counts_them_all() {
    let mut summary = SummaryAccumulator::new([0.0, f64::INFINITY]);
    for tick in 0..=MOST_CONTACTS as u64 {
        let kind = EventKind::Contact {
            car: VehicleId(1),
            kind: VehicleKind::Car,
            ego_speed_mps: 2.0,
            car_speed_mps: 1.0,
            closing_mps: 1.0,
            angle_rad: 0.0,
        };
        summary.note(&Event { tick: Tick(tick), kind });
    }
    let summary = summary.to_summary();
    assert_eq!((summary.contacts.len(), summary.contact_count), (10_000, 10_001));
    assert_eq!(summary.contacts[9_999].time_s, Tick(9_999).seconds());
}

#[test]
fn a_car_beside_the_lane_has_no_gap_to_the_one_that_it_passes() {
    let mut summary = SummaryAccumulator::new([0.0, 1.0]);
    for (tick, offset_m, gap_m) in [(1, 0.0, 9.0), (2, 1.79, 7.0), (3, 1.8, -5.0), (4, -3.0, -5.0), (5, -1.79, 8.0)] {
        let passing = Snapshot { lane_offset_m: offset_m, ..snapshot(tick, 4.0, 3.0, Some(gap_m), None) };
        summary.add(&passing, &[]);
    }
    assert_eq!(summary.to_summary().min_gap_m, Some(7.0), "cars are 1.8 m wide");
}

/// Edie's generalised definition (1963): distance of all vehicles over their time.
#[test]
fn the_space_mean_speed_counts_each_vehicles_time() {
    // The ego alone at 9 m/s, then at 3 m/s with two others that stand: means 9 and 1, and 12 over four vehicles and ticks.
    let alone = Snapshot { cars: vec![], mean_speed_mps: 9.0, ..snapshot(1, 9.0, 0.0, None, None) };
    let mut three = snapshot(2, 3.0, 0.0, None, None);
    three.cars.push(VehicleSnapshot { id: VehicleId(2), ..VehicleSnapshot::default() });
    three.mean_speed_mps = 1.0;
    let found = summary([0.0, 1.0], &[alone, three], &[]);
    assert_eq!((found.mean_speed_mps, found.space_mean_speed_mps), (Some(5.0), Some(3.0)));
    // With a constant number of vehicles both are equal, and one of them is given.
    assert_eq!(summary([0.0, 1.0], &drive(), &[]).space_mean_speed_mps, None);
}
