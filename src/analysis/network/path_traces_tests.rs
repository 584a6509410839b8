//! Traces along a path, for vehicles made up by hand.

use super::*;

const GRID: &str = "tests/data/networks/grid-signals.net.xml";

fn path() -> RoadMap {
    RoadMap::load_along(GRID, &["A0B0", "B0B1", "B1C1"]).expect("a path")
}

/// Returns a step at a full second; vehicles are number, metres along the path, m/s, lane.
fn step(map: &RoadMap, second: u64, vehicles: &[(u32, Option<f64>, f64, &str)]) -> TrafficStep {
    let vehicle = |(id, s_m, speed_mps, lane): &(u32, Option<f64>, f64, &str)| StepVehicle {
        id: *id,
        s_m: *s_m,
        speed_mps: *speed_mps,
        lane: map.network.lane_named(lane).map(|lane| (lane, 1.0)),
    };
    TrafficStep { tick: 100 * second, vehicles: vehicles.iter().map(vehicle).collect() }
}

fn ends(pieces: &[TracePiece]) -> Vec<[[f64; 2]; 2]> {
    pieces.iter().map(|piece| piece.ends).collect()
}

#[test]
fn a_trace_has_a_gap_beside_the_path_and_at_jumps() {
    let map = path();
    let mut collector = PathTraceCollector::new(&map);
    let other = [Some(10.0), Some(20.0), None, Some(40.0), Some(50.0), Some(130.0), Some(100.0)];
    // The ego always has a position along its path; from 4 to 5 s it is in another street.
    let lanes = ["A0B0_0", "A0B0_0", "A0B0_0", "B0C0_0", "B0C0_0", "B0B1_0", "B0B1_0"];
    for (k, (s_m, lane)) in other.into_iter().zip(lanes).enumerate() {
        let ego = (0, Some(5.0 + 10.0 * k as f64), 10.0, lane);
        collector.add(&step(&map, 1 + k as u64, &[ego, (7, s_m, 10.0, "A0B0_0")]));
    }
    // Between full seconds only vehicles near the ego have rows; the ego's trace goes to the end of the drive.
    let last = [(0, Some(70.0), 10.0, "B0B1_0"), (7, Some(101.0), 10.0, "A0B0_0")];
    collector.add(&TrafficStep { tick: 750, ..step(&map, 0, &last) });
    let traces = collector.finish();
    let wanted = [[[1.0, 10.0], [2.0, 20.0]], [[4.0, 40.0], [5.0, 50.0]]];
    assert_eq!(ends(&traces.others), wanted, "neither 80 m in a second, nor 30 m back");
    let wanted =
        [[[1.0, 5.0], [2.0, 15.0]], [[2.0, 15.0], [3.0, 25.0]], [[6.0, 55.0], [7.0, 65.0]], [[7.0, 65.0], [7.5, 70.0]]];
    assert_eq!(ends(&traces.ego), wanted);
    // The part driven by the ego and 100 m around it, within the path.
    assert_eq!(traces.shown_m, [0.0, 170.0]);
    assert!(map.route.length_m() > 170.0 && traces.ends_s.is_none());
}

#[test]
fn a_picture_of_hours_shows_the_first_hour() {
    let map = path();
    let mut collector = PathTraceCollector::new(&map);
    for second in 1..=4000 {
        collector.add(&step(&map, second, &[(0, Some(5.0), 0.0, "A0B0_0")]));
    }
    let traces = collector.finish();
    assert_eq!((traces.ends_s, traces.ego.len()), (Some(3600.0), 3599));
}

#[test]
fn a_signal_shows_each_light_until_the_next_and_nothing_while_it_is_off() {
    let mut bar = SignalBar { s_m: 60.0, spans: Vec::new() };
    let (red, green) = (SignalLight::Red, SignalLight::GreenMajor);
    // Rows for changes of other links change nothing here.
    for (time_s, light) in [(0.0, Some(red)), (3.0, Some(red)), (8.0, Some(green)), (20.0, None), (30.0, Some(red))] {
        bar.show(time_s, light);
    }
    bar.end(25.0);
    assert_eq!(bar.spans, [([0.0, 8.0], red), ([8.0, 20.0], green)], "what comes after the end is left out");
    bar.show(24.0, Some(green));
    bar.end(25.0);
    assert_eq!(bar.spans[2], ([24.0, 25.0], green));
}
