//! Tests of drivers and traffic that yield at a zebra crossing to pedestrians of a demand, of events, and of road users. The crossing of the network
//! `zebra` is at x = 198 to 202 m of a street along x with a lane of 3.2 m in each direction, and its ends are at y = -3.2 and 3.2 m.

use super::{people_of_events::scenario, persons, world::one_at_a_time};
use codrive::{
    drive_loop::offline::OfflineDrive,
    scenario::Scenario,
    sim::{EventKind, Snapshot, VehicleSnapshot, World},
};

/// Ends of the crossing along the street, m.
const CROSSING_M: [f64; 2] = [198.0, 202.0];

const STREET: &str =
    "map = \"tests/data/networks/zebra.net.xml\"\npath = \"ab bc\"\npolicy = \"none\"\ntrees = 0\nduration_s = 60\n";
/// A pedestrian at the kerb of the crossing, 1.2 m from its end, who walks to the other side.
const AT_KERB: &str = "[[road_user]]\nname = \"walker\"\nkind = \"pedestrian\"\nplace_m = 200\noffset_m = -2.8\n";
/// Vehicles in both directions.
const FLOWS: &str = "[demand]\n[[demand.flows]]\nfrom = \"ab\"\nto = \"bc\"\nper_hour = 500\n\
    [[demand.flows]]\nfrom = \"cb\"\nto = \"ba\"\nper_hour = 500\n";

/// Returns the event that lets the road user cross at this time.
fn walks(time_s: f64) -> String {
    format!(
        "[[event]]\nname = \"walks\"\ntrigger = {{ time_s = {time_s} }}\nactions = [{{ speed = {{ vehicle = \"walker\", to_mps = 1.4, rate_mps2 = 2 }} }}, \
         {{ walk = {{ vehicle = \"walker\", points = [[200, -2.8], [200, 6.2]] }} }}]\n"
    )
}

/// Figures of a drive.
#[derive(Debug)]
struct Seen {
    /// Smallest distance between a vehicle's body and a person's middle, m.
    nearest_m: f64,
    /// Seconds in which a vehicle stands within 12 m before the crossing, eastbound and westbound.
    stood_s: [f64; 2],
    /// Lowest speed within 30 m before the crossing, eastbound, m/s.
    slowest_mps: f64,
    /// Seconds in which a person is on the road.
    crossed_s: f64,
}

impl Seen {
    fn new() -> Self {
        Self { nearest_m: f64::INFINITY, stood_s: [0.0; 2], slowest_mps: f64::INFINITY, crossed_s: 0.0 }
    }

    /// Adds a state that lasts 0.1 s.
    fn add<'a>(&mut self, view: &Snapshot, vehicles: impl Iterator<Item = &'a VehicleSnapshot>) {
        let is_on_road = |person: &&VehicleSnapshot| person.pose.position.y.abs() < 3.2;
        self.crossed_s += if view.persons().any(|person| is_on_road(&person)) { 0.1 } else { 0.0 };
        let mut stands = [false; 2];
        for car in vehicles {
            let front_m = car.pose.front(car.body.length_m).x;
            let is_east = car.pose.forward().x > 0.0;
            let before_m = if is_east { CROSSING_M[0] - front_m } else { front_m - CROSSING_M[1] };
            // SUMO stops up to the line, a simulated driver up to half a metre beyond it.
            stands[usize::from(!is_east)] |= car.speed_mps.abs() < 0.2 && (-0.5..12.0).contains(&before_m);
            if is_east && (0.0..30.0).contains(&before_m) {
                self.slowest_mps = self.slowest_mps.min(car.speed_mps);
            }
            for person in view.persons() {
                let way = person.pose.position - car.pose.position;
                let beside = [way.x.abs() - car.body.length_m / 2.0, way.y.abs() - car.body.width_m / 2.0];
                self.nearest_m = self.nearest_m.min(beside[0].max(beside[1]));
            }
        }
        for (stood_s, stands) in self.stood_s.iter_mut().zip(stands) {
            *stood_s += if stands { 0.1 } else { 0.0 };
        }
    }
}

/// Drives by the simulated driver for 60 s, or to the end of the path. Returns the figures of the ego and the time of its passing, s.
fn driven(scenario: &Scenario) -> (Seen, f64) {
    let mut run = OfflineDrive::new(scenario, [0.0, f64::INFINITY]).unwrap_or_else(|error| panic!("{error}"));
    let (mut seen, mut passed_s) = (Seen::new(), f64::INFINITY);
    for k in 1..600 {
        run.until(f64::from(k) * 0.1).expect("the traffic goes on");
        let view = run.world().snapshot();
        let touched = run.world().events().iter().any(|event| matches!(event.kind, EventKind::Contact { .. }));
        assert!(!touched, "{seen:?}");
        let ego =
            VehicleSnapshot { pose: view.ego.pose(), speed_mps: view.ego.speed_mps, ..VehicleSnapshot::default() };
        seen.add(view, std::iter::once(&ego));
        if ego.pose.front(5.0).x > CROSSING_M[1] {
            passed_s = passed_s.min(f64::from(k) * 0.1);
        }
    }
    (seen, passed_s)
}

/// Runs the traffic alone for 60 s.
fn run(scenario: &Scenario) -> Seen {
    let mut world = World::new(scenario).unwrap_or_else(|error| panic!("{error}"));
    let mut seen = Seen::new();
    for _ in 0..600 {
        world.step().expect("the traffic goes on");
        let view = world.snapshot();
        seen.add(view, view.vehicles());
    }
    seen
}

#[test]
fn a_driver_waits_for_a_road_user_at_a_zebra_until_it_has_crossed() {
    let _alone = one_at_a_time();
    let (seen, passed_s) = driven(&scenario(&format!("{STREET}{AT_KERB}{}", walks(30.0))));
    // The driver stands within 22 s; the person waits until second 30 and is over the lane's 3.2 m and half a metre 4 s later.
    assert!(seen.stood_s[0] > 5.0 && seen.nearest_m > 0.5, "{seen:?}");
    assert!((31.0..42.0).contains(&passed_s), "{passed_s} s, {seen:?}");
}

#[test]
fn a_driver_stops_for_a_road_user_who_walks_onto_a_zebra() {
    let _alone = one_at_a_time();
    // The person comes from 4.5 m beside the crossing's end and steps onto it while the driver is near.
    let walks = walks(14.0).replace("[200, -2.8]", "[200, -6.0]");
    let (seen, passed_s) = driven(&scenario(&format!("{STREET}{}{walks}", AT_KERB.replace("-2.8", "-6.0"))));
    assert!(seen.crossed_s > 4.0 && seen.nearest_m > 0.5 && passed_s.is_finite(), "{passed_s} s, {seen:?}");
    // At its limit of 13.9 m/s the car would pass while the person is on the lane.
    assert!(seen.slowest_mps < 10.0 && passed_s > 14.0 + 4.4 / 1.4, "{passed_s} s, {seen:?}");
}

#[test]
fn a_driver_stops_for_a_pedestrian_of_an_event_at_a_zebra() {
    let _alone = one_at_a_time();
    let text = format!(
        "{STREET}[[event]]\nname = \"crosses\"\ntrigger = {{ place_m = 150 }}\nactions = [{{ pedestrian_crosses = {{ place_m = 200, from = \"right\" }} }}]\n"
    );
    let (seen, passed_s) = driven(&scenario(&text));
    assert!(seen.crossed_s > 3.5 && seen.nearest_m > 0.5 && passed_s.is_finite(), "{passed_s} s, {seen:?}");
}

#[test]
fn traffic_of_sumo_stops_at_a_zebra_for_persons_of_the_demand() {
    let _alone = one_at_a_time();
    let folder = tempfile::tempdir().expect("a folder");
    let text = "<routes><flow id=\"e\" begin=\"0\" end=\"60\" period=\"7\" from=\"ab\" to=\"bc\"/>\
        <flow id=\"w\" begin=\"0\" end=\"60\" period=\"7\" from=\"cb\" to=\"ba\"/>\
        <personFlow id=\"p\" begin=\"10\" end=\"40\" period=\"6\" departPos=\"185\"><walk from=\"ab\" to=\"cb\"/></personFlow></routes>";
    let scenario = Scenario { participant: false, ..persons::scenario(folder.path(), "zebra", "ab bc", text) };
    let seen = run(&scenario);
    assert!(seen.crossed_s > 10.0 && seen.nearest_m > 0.5, "{seen:?}");
    assert!(seen.stood_s.iter().all(|stood_s| *stood_s > 2.0), "{seen:?}");
}

#[test]
fn traffic_of_sumo_stops_at_a_zebra_for_a_road_user_and_for_an_event() {
    let _alone = one_at_a_time();
    let event = "[[event]]\nname = \"crosses\"\ntrigger = { time_s = 25 }\nactions = [{ pedestrian_crosses = { place_m = 200, from = \"right\" } }]\n";
    for people in [format!("{AT_KERB}{}", walks(25.0)), event.to_owned()] {
        let text = format!("{STREET}participant = false\n{people}{FLOWS}");
        let seen = run(&scenario(&text));
        assert!(seen.crossed_s > 3.5 && seen.nearest_m > 0.1, "{people}: {seen:?}");
        assert!(seen.slowest_mps < 3.0, "{people}: {seen:?}");
        // The person crosses within 7 s, after which the traffic goes on.
        assert!(seen.stood_s.iter().all(|stood_s| *stood_s < 12.0), "{people}: {seen:?}");
    }
}
