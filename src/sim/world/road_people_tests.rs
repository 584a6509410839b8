//! Tests of the people of events: edges of the road, ways across it and along it, at any tick.

use super::*;
use crate::scenario::Scenario;

/// Returns the people of one action on a map, and that map.
fn people(map: &str, action: &str) -> (RoadPeople, RoadMap) {
    let text = format!("[[event]]\nname = \"a\"\ntrigger = {{ time_s = 1 }}\nactions = [{{ {action} }}]\n");
    let events = Scenario::from_toml(&text, "x").unwrap_or_else(|fault| panic!("{fault}")).events;
    let map = RoadMap::load(map).expect("a shipped map");
    (RoadPeople::new(&events, &map), map)
}

/// Returns place along the route and offset, metres, and speed, m/s, of the person `for_s` after the beginning at 2 s.
fn at(people: &RoadPeople, map: &RoadMap, for_s: f64) -> (f64, f64, f64) {
    let now = Tick::at_seconds(2.0 + for_s);
    let person = people.at(now, 1, &map.route).next().expect("one person");
    let place = map.route.project(person.pose.position, None);
    (place.s_m, place.offset_m, person.speed_mps)
}

#[test]
fn a_pedestrian_crosses_a_ring_at_their_speed_from_kerb_to_kerb() {
    // The ring's lane is 3.6 m wide with shoulders of 0.4 m: the edges are 2.2 m from the line, and the person waits 0.6 m beyond.
    let (mut people, map) =
        people("ring-250", "pedestrian_crosses = { place_m = 80, from = \"right\", speed_mps = 1.4 }");
    let (s_m, offset_m, speed_mps) = at(&people, &map, 5.0);
    assert!((s_m - 80.0).abs() < 0.05 && (offset_m + 2.8).abs() < 0.11 && speed_mps == 0.0, "{s_m} {offset_m}");
    let (id, lasts_s) = people.begin((0, 0), Tick::at_seconds(2.0)).expect("the person");
    assert!(id.is_of_event());
    // 0.7 s up to 1.4 m/s with 2 m/s²: 0.49 m. Then 1.4 m/s: after 2.7 s it is 3.29 m.
    let waits_m = offset_m;
    for (for_s, moved_m) in [(0.35, 0.1225), (0.7, 0.49), (2.7, 3.29)] {
        let (s_m, offset_m, _) = at(&people, &map, for_s);
        assert!((offset_m - waits_m - moved_m).abs() < 0.01 && (s_m - 80.0).abs() < 0.02, "{for_s}: {offset_m} {s_m}");
    }
    // 5.6 m take 0.7 s and 5.11 m at 1.4 m/s.
    assert!((lasts_s - (0.7 + 5.11 / 1.4)).abs() < 0.15, "{lasts_s}");
    assert!(people.is_on_road(id, Tick::at_seconds(2.0 + lasts_s - 0.2)));
    assert!(!people.is_on_road(id, Tick::at_seconds(2.0 + lasts_s + 0.2)));
    // Then the person walks on along the road.
    let (s_m, offset_m, _) = at(&people, &map, lasts_s + 5.0);
    assert!(offset_m > 2.7 && s_m > 83.0, "{s_m} {offset_m}");
}

#[test]
fn a_cyclist_rides_within_the_edge_and_leaves_the_road_again() {
    let (mut people, map) = people("lane-10km", "cyclist_rides = { place_m = 500, for_m = 60, speed_mps = 5 }");
    let edge_m = -edge_m(&map, 500.0, Side::Right);
    people.begin((0, 0), Tick::at_seconds(2.0));
    // 5 s up to 5 m/s, 12.5 m; at 10 s 37.5 m: on the road.
    let (s_m, offset_m, speed_mps) = at(&people, &map, 10.0);
    assert!((s_m - 537.5).abs() < 0.1 && (offset_m + edge_m - 1.0).abs() < 0.05, "{s_m} {offset_m} of {edge_m}");
    assert_eq!(speed_mps, 5.0);
    // After 12 m, 60 m and 12 m the road is left: 84 m at 19.3 s.
    let (_, offset_m, _) = at(&people, &map, 20.0);
    assert!((offset_m + edge_m + 0.6).abs() < 0.05, "{offset_m} of {edge_m}");
}

#[test]
fn a_person_out_of_sight_disappears_or_waits_again() {
    let (mut people, map) = people("lane-10km", "pedestrian_crosses = { place_m = 500, from = \"left\" }");
    let (id, _) = people.begin((0, 0), Tick(0)).expect("the person");
    let (here, far) = (map.route.point_at(500.0), map.route.point_at(400.0));
    let count = |people: &RoadPeople| people.at(Tick(5000), 1, &map.route).count();
    people.leave(Tick(100), far, &map.route, &|_| false);
    assert_eq!(count(&people), 1, "still on the road");
    people.leave(Tick(2000), here, &map.route, &|_| false);
    assert_eq!(count(&people), 1, "in sight of the ego");
    people.leave(Tick(2000), far, &map.route, &|_| true);
    assert!(count(&people) == 1 && !people.is_on_road(id, Tick(2001)), "it waits again");
    people.begin((0, 0), Tick(3000));
    people.leave(Tick(5000), far, &map.route, &|_| false);
    assert_eq!(count(&people), 0);
}
