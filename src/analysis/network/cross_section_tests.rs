//! Line crossings of rows written by hand on the grid: B0B1 is 69.2 m long and ends at the junction B1.

use super::*;

const GRID: &str = "tests/data/networks/grid-signals.net.xml";

fn row(net: &Network, tick: u64, lane: &str, s_m: f64, speed_mps: f64) -> RowPlace {
    RowPlace { tick, lane: net.lane_named(lane).expect(lane), s_m, speed_mps }
}

/// Counts the pairs of rows that cross the line, a second apart at 13 m/s.
fn passages(net: &Network, line: &str, pairs: &[[(&str, f64); 2]]) -> u64 {
    let place: LinePlace = line.parse().expect("a place");
    let mut count = LineCount::new(place.resolve(net, Path::new("p1")).expect("a line"));
    for [before, now] in pairs {
        count.pass(net, &row(net, 100, before.0, before.1, 13.0), &row(net, 200, now.0, now.1, 13.0));
    }
    count.vehicles
}

#[test]
fn a_line_on_an_edge_is_passed_on_it_over_its_end_and_over_its_start() {
    let net = Network::load(GRID).expect("a network");
    let on = |a: f64, b: f64| [("B0B1_0", a), ("B0B1_0", b)];
    assert_eq!(passages(&net, "B0B1:30", &[on(20.0, 30.0), on(29.9, 42.0)]), 2, "the front on the line is past it");
    assert_eq!(passages(&net, "B0B1:30", &[on(30.0, 42.0), on(10.0, 29.9), on(42.0, 20.0), on(20.0, 20.0)]), 0);
    // The next row is on the next lane, inside the junction.
    assert_eq!(passages(&net, "B0B1:65", &[[("B0B1_0", 60.0), (":B1_11_0", 4.0)]]), 1);
    assert_eq!(passages(&net, "B0B1:55", &[[("B0B1_0", 60.0), (":B1_11_0", 4.0)]]), 0, "it was past it before");
    assert_eq!(passages(&net, "B1C1:5", &[[(":B1_16_0", 15.0), ("B1C1_1", 7.0)]]), 1);
    assert_eq!(passages(&net, "B1C1:9", &[[(":B1_16_0", 15.0), ("B1C1_1", 7.0)]]), 0);
    // Not counted: 60 m in a second, as for a vehicle that changes to the other direction.
    assert_eq!(passages(&net, "B0B1:30", &[[("B0B1_0", 10.0), ("B1B0_0", 60.0)]]), 0);
}

#[test]
fn a_lane_counts_its_own_vehicles_and_an_edge_those_of_all_lanes() {
    let net = Network::load(GRID).expect("a network");
    // From the outer to the inner lane: nearer to the line before the change, and after it.
    let pairs = [
        [("B1C1_0", 28.0), ("B1C1_1", 40.0)],
        [("B1C1_0", 20.0), ("B1C1_1", 32.0)],
        [("B1C1_0", 25.0), ("B1C1_0", 37.0)],
    ];
    let of = |line: &str| passages(&net, line, &pairs);
    assert_eq!((of("B1C1:30"), of("B1C1_0:30"), of("B1C1_1:30")), (3, 2, 1));
}

#[test]
fn a_line_may_lie_at_the_end_of_its_edge_and_not_beyond() {
    let net = Network::load(GRID).expect("a network");
    let resolve = |line: &str| line.parse::<LinePlace>().expect("a place").resolve(&net, Path::new("p1"));
    assert!(resolve("B0B1:69.2").is_ok() && resolve("B0B1:69.3").is_err());
}

#[test]
fn the_moment_of_a_passage_is_known_to_the_time_between_its_rows() {
    let net = Network::load(GRID).expect("a network");
    let place: LinePlace = "B0B1:30".parse().expect("a place");
    let mut count = LineCount::new(place.resolve(&net, Path::new("p1")).expect("a line"));
    count.pass(&net, &row(&net, 100, "B0B1_0", 29.0, 10.0), &row(&net, 110, "B0B1_0", 30.0, 10.0));
    assert_eq!((count.vehicles, count.resolution_s), (1, 0.1));
    count.pass(&net, &row(&net, 100, "B0B1_0", 29.0, 10.0), &row(&net, 200, "B0B1_0", 39.0, 10.0));
    count.pass(&net, &row(&net, 200, "B0B1_0", 39.0, 10.0), &row(&net, 500, "B0B1_0", 69.0, 10.0));
    assert_eq!((count.vehicles, count.resolution_s), (2, 1.0), "who does not pass tells nothing");
}

#[test]
fn lines_outside_the_network_are_errors_with_a_remedy() {
    let net = Network::load(GRID).expect("a network");
    for (text, message) in [
        ("B0B1", "the metres are missing; allowed: LANE_OR_EDGE:METRES"),
        ("B0B1:far", "\"far\" is not a distance in metres"),
        ("B0B1:-1", "\"-1\" is not a distance"),
        (":5", "the lane or edge is missing"),
    ] {
        let found = text.parse::<LinePlace>().expect_err(text);
        assert!(found.contains(message), "{text}: {found}");
    }
    for (text, message) in [
        ("B0B7:5", "--line B0B7:5: p1: the network has no edge or lane of this name (did you mean B0B1"),
        ("B0B1_0:69.3", "the lane is 69.2 m long\n  remedy: name a distance"),
        (":B1_0:2", "recorded only once a second\n  remedy: name the edge before or after this one"),
    ] {
        let place: LinePlace = text.parse().expect(text);
        let found = place.resolve(&net, Path::new("p1")).expect_err(text).to_string();
        assert!(found.contains(message), "{text}: {found}");
    }
    let inside: LinePlace = ":B1_0:2".parse().expect("an edge inside a junction");
    assert_eq!((inside.name.as_str(), inside.at_m), (":B1_0", 2.0));
}

#[test]
fn the_line_of_a_path_is_at_its_middle_on_the_nearest_street() {
    // 69.2 m, 20.8 m through the junction, 69.2 m: the middle is in the junction, equally far from both streets.
    let map = RoadMap::load_along(GRID, &["B0B1", "B1B2"]).expect("a path");
    let line = CrossSection::middle_of_path(&map).expect("a line");
    assert!(line.is_default && (line.name == "B0B1:69" || line.name == "B1B2:0"), "{line:?}");
    let map = RoadMap::load_along(GRID, &["A0B0", "B0B1", "B1B2"]).expect("a path");
    let line = CrossSection::middle_of_path(&map).expect("a line");
    let street = map.route.lanes().iter().find(|lane| lane.edge_id(&map.network) == "B0B1").expect("the middle one");
    let at_m = map.route.length_m() / 2.0 - street.start_s_m;
    assert_eq!(line.name, format!("B0B1:{}", at_m.round()));
}
