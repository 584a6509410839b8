//! Sums of a drive on a network against values computed by hand. The limit on B0B1 is 13.89 m/s, its length 69.2 m.

use super::*;
use crate::analysis::data::TripEnd;

const LIMIT_MPS: f64 = 13.89;

fn grid() -> Arc<Network> {
    Arc::new(Network::load("tests/data/networks/grid-signals.net.xml").expect("a network"))
}

fn totals(net: &Arc<Network>, lines: &[&str], trips: &[(u32, Trip)]) -> NetworkDriveTotals {
    let line = |name: &&str| {
        let place: LinePlace = name.parse().expect("a place");
        LineCount::new(place.resolve(net, std::path::Path::new("p1")).expect("a line"))
    };
    NetworkDriveTotals {
        network: Some(Arc::clone(net)),
        lines: lines.iter().map(line).collect(),
        trips: trips.iter().cloned().collect(),
        ..NetworkDriveTotals::default()
    }
}

fn end(tick: u64, lane_s_m: f64) -> TripEnd {
    TripEnd { tick, lane: "B0B1_0".into(), lane_s_m: Some(lane_s_m) }
}

/// Returns a step with vehicles on the outer lane of B0B1: number, metres along it, speed.
fn step(net: &Network, tick: u64, vehicles: &[(u32, f64, f64)]) -> TrafficStep {
    let lane = net.lane_named("B0B1_0").expect("a lane");
    let vehicle = |(id, s_m, speed_mps): &(u32, f64, f64)| StepVehicle {
        id: *id,
        s_m: None,
        speed_mps: *speed_mps,
        lane: Some((lane, *s_m)),
    };
    TrafficStep { tick, vehicles: vehicles.iter().map(vehicle).collect() }
}

#[test]
fn vehicles_are_counted_once_each() {
    let net = grid();
    let mut totals = totals(&net, &[], &[]);
    totals.add_step(&step(&net, 100, &[(0, 1.0, 10.0), (4, 50.0, 0.0)]));
    totals.add_step(&step(&net, 200, &[(0, 12.0, 4.0)]));
    totals.finish(10);
    assert_eq!(totals.vehicles, 2);
}

#[test]
fn time_is_lost_against_the_limit_from_departure_to_arrival() {
    let net = grid();
    let trip = |departed: TripEnd, departed_mps, arrived| Trip { departed, departed_mps, arrived, ..Trip::default() };
    let half_mps = LIMIT_MPS / 2.0;
    let trips = [
        // At half the limit for 10 s: 5 s.
        (1, trip(end(150, 0.0), half_mps, Some(end(1150, 69.0)))),
        // From 0 to the limit in the first second, then at the limit: half a second.
        (2, trip(end(100, 0.0), 0.0, Some(end(400, 40.0)))),
        // A tenth above the limit for 2 s: a gain of 0.2 s.
        (3, trip(end(100, 0.0), 1.1 * LIMIT_MPS, Some(end(300, 30.0)))),
        // Incomplete trips.
        (4, trip(end(0, 0.0), half_mps, Some(end(300, 30.0)))),
        (5, trip(end(100, 0.0), half_mps, None)),
    ];
    let mut totals = totals(&net, &[], &trips);
    for second in 2..=11_u64 {
        let mut there = vec![(1, (second as f64 - 1.5) * half_mps, half_mps)];
        if second <= 3 {
            there.extend([(2, 7.0 * second as f64, LIMIT_MPS), (4, 10.0, half_mps)]);
        }
        if second == 2 {
            there.push((3, 15.0, 1.1 * LIMIT_MPS));
        }
        there.push((5, 5.0, half_mps));
        totals.add_step(&step(&net, 100 * second, &there));
    }
    totals.finish(10);
    let lost = |id: u32| totals.trips[&id].time_loss_s;
    let near = |found: Option<f64>, wanted: f64| found.is_some_and(|found| (found - wanted).abs() < 1e-9);
    assert!(near(lost(1), 5.0) && near(lost(2), 0.5) && near(lost(3), -0.2), "{:?}", totals.trips);
    assert_eq!((lost(4), lost(5)), (None, None));
    assert_eq!(totals.travel_times_s(), [2.0, 3.0, 10.0], "from the shortest on");
    assert_eq!(totals.departures_and_arrivals(), [4, 4], "one was there before, another is there at the end");
    assert!(near(totals.mean_time_loss_s(), 5.3 / 3.0));
}

#[test]
fn vehicles_that_depart_and_arrive_between_seconds_pass_lines() {
    let net = grid();
    let trip = |departed, arrived| Trip { departed, departed_mps: 12.0, arrived: Some(arrived), ..Trip::default() };
    let trips = [
        // From 3 to 60 m; its rows are at 10 and 50 m.
        (1, trip(end(120, 3.0), end(520, 60.0))),
        // Departs beyond the first line and arrives before the last.
        (2, trip(end(120, 8.0), end(420, 52.0))),
    ];
    let mut totals = totals(&net, &["B0B1:5", "B0B1:30", "B0B1:55"], &trips);
    for (second, at_m) in [(2, 10.0), (3, 25.0), (4, 50.0)] {
        totals.add_step(&step(&net, 100 * second, &[(1, at_m, 12.0), (2, at_m, 12.0)]));
    }
    totals.finish(10);
    assert_eq!(totals.lines.iter().map(|line| line.vehicles).collect::<Vec<_>>(), [1, 2, 1]);
}

#[test]
fn a_vehicle_gone_before_its_first_row_passes_lines_and_loses_time() {
    let net = grid();
    let (half_mps, arrived) = (LIMIT_MPS / 2.0, Some(end(490, 64.0)));
    let trip = |departed| Trip { departed, departed_mps: half_mps, arrived: arrived.clone(), ..Trip::default() };
    // One enters 0.8 s before it leaves, the other was present before the drive; neither is there at a full second.
    let trips = [(1, trip(end(410, 58.0))), (2, trip(end(0, 20.0)))];
    let mut totals = totals(&net, &["B0B1:60", "B0B1:30"], &trips);
    totals.finish(10);
    assert_eq!(totals.lines.iter().map(|line| line.vehicles).collect::<Vec<_>>(), [2, 1]);
    assert!(totals.trips[&1].time_loss_s.is_some_and(|lost_s| (lost_s - 0.4).abs() < 1e-9), "{:?}", totals.trips);
    assert_eq!(totals.trips[&2].time_loss_s, None);
}
