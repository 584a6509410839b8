//! Tests of benchmark files: refused definitions, and the conditions in which each row is evaluated.

use super::*;

fn shipped_folder() -> PathBuf {
    data_folders::root().join(SHIPPED)
}

fn shipped_text() -> String {
    std::fs::read_to_string(shipped_folder().join("ring.toml")).unwrap()
}

fn parsed(text: &str) -> Benchmark {
    Benchmark::parse(text, "small.toml", PathBuf::from("here")).map_err(|e| e.to_string()).unwrap()
}

fn refused_of(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "{from}");
    match Benchmark::parse(&text.replacen(from, to, 1), "ring.toml", shipped_folder()) {
        Err(CliError::Input(message)) => message,
        _ => panic!("{to} was taken"),
    }
}

/// Two drivers, one of them used only if named; two policies and no advice, one policy with its own driver and hold.
const SMALL: &str = r#"format = "codrive benchmark 1"
title = "A small one"
rings = 2
seed = 3
holds_s = [1.0, 10.0]
[[road]]
name = "long"
circumference_m = [260.0, 260.0]
vehicles = [22, 22]
idm_spread = 0.0
[[road]]
name = "some"
circumference_m = [230.0, 250.5]
vehicles = [20, 22]
idm_spread = 0.1
[[driver]]
name = "people"
driver = "people"
[[driver]]
name = "closing"
driver = "exact"
ego_response_s = 0.5
only_where_named = true
[[row]]
name = "no advice"
policies = ["none"]
[[row]]
name = "by hand"
policies = ["two-phase"]
[[row]]
name = "a machine's"
policies = ["pi", "constant"]
drivers = ["closing"]
holds_s = [0.1]
"#;

#[test]
fn faults_of_a_file_are_reported_with_their_position() {
    for (from, to, expected) in [
        ("rings = 200", "rings = 1", "ring.toml:5:9: rings is 1; allowed: 2 to 100000"),
        ("rings = 200", "ringz = 200", "did you mean `rings`"),
        ("holds_s = [1.0, 10.0]", "holds_s = [1.0, 0.25]", "ring.toml:7:17"),
        ("driver = \"people\"", "driver = \"peeple\"", "no driver is called \"peeple\""),
        ("policies = [\"pi\"]", "policies = [\"pie\"]", "policy `pie` is unknown (did you mean pi?)"),
        ("vehicles = [18, 26]", "vehicles = [18, 36]", "road `210-290 m, 18-26 cars` is not valid"),
    ] {
        let message = refused_of(&shipped_text(), from, to);
        assert!(message.contains(expected), "{message}");
    }
    for (from, to, expected) in [
        (
            "drivers = [\"closing\"]",
            "drivers = [\"closign\"]",
            "ring.toml:33:12: no driver of this file has the name `closign`",
        ),
        ("drivers = [\"closing\"]", "drivers = []", "ring.toml:33:11: drivers is empty"),
        ("holds_s = [0.1]", "holds_s = [0.15]", "ring.toml:34:12"),
        ("[230.0, 250.5]", "[260.0, 260.0]", "two roads have the key `260`"),
        (
            "holds_s = [0.1]",
            "roads = [\"261\"]",
            "ring.toml:34:10: no road of this file has the key `261` (did you mean 260?)",
        ),
        ("holds_s = [0.1]", "roads = []", "ring.toml:34:9: roads is empty"),
        ("vehicles = [22, 22]", "warm_up_s = -1.0\nvehicles = [22, 22]", "warm_up_s is -1; allowed: 0 to 3600"),
        ("name = \"closing\"", "name = \"people\"", "two drivers have the name `people`"),
        ("ego_response_s = 0.5", "ego_response_s = 50", "ego_response_s is 50; allowed: 0.1 to 10"),
    ] {
        let message = refused_of(SMALL, from, to);
        assert!(message.contains(expected), "{message}");
    }
}

#[test]
fn paths_are_filled_in_for_each_cell() {
    let benchmark = parsed(SMALL);
    let path = |road: usize, name: &str| {
        let condition =
            EvaluationCondition { road: &benchmark.roads[road], hold_s: 10.0, driver: &benchmark.drivers[1] };
        benchmark.policy(name, &condition)
    };
    let expected = |file: &str| PathBuf::from("here").join(file).display().to_string();
    assert_eq!(path(0, "tuned/{road}/pi-{driver}-{hold}.toml"), expected("tuned/260/pi-closing-10.toml"));
    assert_eq!(path(1, "tuned/{road}/pi-{driver}-{hold}.toml"), expected("tuned/230-250.5/pi-closing-10.toml"));
    assert_eq!(path(0, "pi"), "pi", "a name is no path");
    let own = parsed(&SMALL.replace("name = \"some\"", "name = \"some\"\nkey = \"260-wide\""));
    assert_eq!(own.roads.iter().map(Road::key).collect::<Vec<_>>(), ["260", "260-wide"]);
}

#[test]
fn a_row_is_judged_in_its_conditions_with_no_advice_as_baseline() {
    let benchmark = parsed(SMALL);
    let judged = |row: usize| -> Vec<(f64, &str)> {
        let conditions = benchmark.conditions();
        let here = conditions.iter().filter(|condition| std::ptr::eq(condition.road, &benchmark.roads[0]));
        let here = here.filter(|condition| benchmark.judges(&benchmark.rows[row], condition));
        here.map(|condition| (condition.hold_s, condition.driver.name.as_str())).collect()
    };
    assert_eq!(judged(1), [(1.0, "people"), (10.0, "people")]);
    assert_eq!(judged(2), [(0.1, "closing")]);
    assert_eq!(judged(0), [(1.0, "people"), (10.0, "people"), (0.1, "closing")]);
    assert_eq!(benchmark.conditions().len(), 6, "three on each road");
    let condition = EvaluationCondition { road: &benchmark.roads[0], hold_s: 0.1, driver: &benchmark.drivers[1] };
    let config = benchmark.config(&condition).map_err(|e| e.to_string()).unwrap();
    assert_eq!((config.driver.ego_response_s, config.advice.hold_s), (0.5, 0.1));
}

#[test]
fn rows_can_name_roads_and_roads_can_set_speed_limit_and_warm_up() {
    let one_road = SMALL.replace("holds_s = [0.1]", "holds_s = [0.1]\nroads = [\"260\"]");
    let benchmark =
        parsed(&one_road.replace("name = \"long\"", "name = \"long\"\ndesired_speed_mps = 17.88\nwarm_up_s = 300.0"));
    let conditions = benchmark.conditions();
    let judged: Vec<String> = conditions
        .iter()
        .filter(|condition| benchmark.judges(&benchmark.rows[2], condition))
        .map(|condition| format!("{} {}", condition.road.key(), condition.hold_s))
        .collect();
    assert_eq!(judged, ["260 0.1"]);
    assert_eq!(conditions.len(), 5, "without the machine's on the other road");
    let ring = |road: usize| {
        let condition =
            EvaluationCondition { road: &benchmark.roads[road], hold_s: 1.0, driver: &benchmark.drivers[0] };
        benchmark.config(&condition).map_err(|e| e.to_string()).unwrap().ring
    };
    assert_eq!((ring(0).idm.v0, ring(0).warm_up_s), (17.88, 300.0));
    assert_eq!((ring(1).idm.v0, ring(1).warm_up_s), (30.0, 120.0));
}

#[test]
fn tuned_controllers_are_judged_in_the_conditions_they_were_tuned_for() {
    // Two roads, two holds, five drivers; three roads, two holds, four drivers.
    for (name, vehicles, conditions) in [("ring", "cars", 20), ("worlds", "vehicles", 24)] {
        let benchmark = Benchmark::load(name).map_err(|e| e.to_string()).unwrap();
        let is_tuned = |policy: &&String| policy.contains("/tuned/") && policy.contains("{road}");
        let mut tuned = 0;
        for condition in benchmark.conditions() {
            let rows = benchmark.rows.iter().filter(|row| benchmark.judges(row, &condition));
            for policy in rows.flat_map(|row| &row.policies).filter(is_tuned) {
                let file = benchmark.policy(policy, &condition);
                let text = std::fs::read_to_string(&file).unwrap();
                let driver = condition.driver.following_driver().unwrap().label();
                let span =
                    |[low, high]: [f64; 2]| if low < high { format!("{low} to {high}") } else { low.to_string() };
                let (cars, length_m) = (condition.road.vehicles.map(f64::from), condition.road.circumference_m);
                let drivers = &condition.road.traffic_drivers;
                let among = if drivers == RING_STUDY { String::new() } else { format!(" among {drivers}") };
                for sentence in [
                    format!("Driver: {driver}. Holds: {} s.", condition.hold_s),
                    format!(
                        "of the stream \"tune\", seed 1: {} {vehicles} on {} m{among},",
                        span(cars),
                        span(length_m)
                    ),
                ] {
                    assert!(text.contains(&sentence), "{file} does not say: {sentence}");
                }
                tuned += 1;
            }
        }
        let rows = benchmark.rows.iter().filter(|row| row.policies.iter().any(|policy| is_tuned(&policy))).count();
        assert!(rows > 0 && tuned == conditions * rows, "{name}: {tuned} of {rows} rows");
    }
}

#[test]
fn an_unknown_benchmark_is_refused_with_the_known_names() {
    let Err(CliError::Input(message)) = Benchmark::load("rign") else { panic!("there is none") };
    assert!(
        message.contains("did you mean ring") && message.contains("name one of corners, mixed, published, ring"),
        "{message}"
    );
}

#[test]
fn a_road_has_the_drivers_that_it_names() {
    let text = SMALL.replacen("idm_spread = 0.0", "traffic_drivers = \"gap-closers\"", 1);
    let of = |text: &str, k: usize| {
        let benchmark = parsed(text);
        let condition = EvaluationCondition { road: &benchmark.roads[k], hold_s: 1.0, driver: &benchmark.drivers[0] };
        benchmark.config(&condition).map_err(|e| e.to_string()).unwrap().ring.traffic_drivers
    };
    assert_eq!([of(&text, 0), of(&text, 1), of(SMALL, 0)], ["gap-closers", "ring-study", "ring-study"]);
    let typo = refused_of(&text, "gap-closers", "gap-closer");
    assert!(
        typo.starts_with("ring.toml:10:19: traffic_drivers is \"gap-closer\" (did you mean gap-closers?)"),
        "{typo}"
    );
    let spread = refused_of(&text, "\"gap-closers\"", "\"gap-closers\"\nidm_spread = 0.1");
    assert!(
        spread.starts_with("ring.toml:11:14: idm_spread is 0.1; allowed with traffic_drivers gap-closers: 0"),
        "{spread}"
    );
}

#[test]
fn a_road_has_the_share_of_advised_vehicles_that_it_names() {
    let benchmark = parsed(&SMALL.replacen("idm_spread = 0.0", "advised = \"50%\"", 1));
    let advised = |k: usize| {
        let condition = EvaluationCondition { road: &benchmark.roads[k], hold_s: 1.0, driver: &benchmark.drivers[0] };
        benchmark.config(&condition).map_err(|e| e.to_string()).unwrap().ring.advised_slots().count()
    };
    // Half of 22 vehicles; without a share the participant's alone.
    assert_eq!([advised(0), advised(1)], [11, 1]);
}

#[test]
fn a_benchmark_has_one_limit_and_a_penalty_within_bounds() {
    let rows = |is_limit: [bool; 2]| {
        let row = |(k, is_limit): (usize, bool)| {
            format!("[[row]]\nname = \"row {k}\"\npolicies = [\"pi\"]\nis_limit = {is_limit}\n")
        };
        SMALL.to_owned() + &is_limit.into_iter().enumerate().map(row).collect::<String>()
    };
    assert!(parsed(&rows([true, false])).rows.iter().any(|row| row.is_limit));
    let Err(CliError::Input(two)) = Benchmark::parse(&rows([true, true]), "ring.toml", PathBuf::new()) else {
        panic!("two")
    };
    assert!(two.contains("two rows are the limit; allowed: one"), "{two}");
    let fault = refused_of(SMALL, "holds_s", "speed_sd_penalty = 11.0\nholds_s");
    assert!(fault.contains("speed_sd_penalty is 11; allowed: 0 to 10"), "{fault}");
}
