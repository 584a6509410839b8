//! `codrive evaluate --benchmark`: the same result on any number of threads, and rings that no other code has used.

use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;

const SMALL: &str = r#"
format = "codrive benchmark 1"
title = "A small one"
rings = 16
seed = 3
holds_s = [1.0]
[[road]]
name = "ring"
circumference_m = [230.0, 260.0]
vehicles = [20, 22]
idm_spread = 0.1
[[driver]]
name = "people"
driver = "people"
[[row]]
name = "no advice"
policies = ["none"]
[[row]]
name = "two seeds of one"
policies = ["constant", "two-phase"]
"#;

fn judged(folder: &Path, threads: &str) -> Value {
    let file = folder.join("small.toml");
    std::fs::write(&file, SMALL).unwrap();
    let mut program = Command::cargo_bin("codrive").unwrap();
    program.args(["evaluate", "--json", "--benchmark"]).arg(&file).env("RAYON_NUM_THREADS", threads);
    let output = program.assert().success().get_output().stdout.clone();
    serde_json::from_slice(&output).unwrap()
}

#[test]
fn a_benchmark_is_the_same_on_one_thread_and_on_two_and_pairs_its_rings() {
    let folder = tempfile::tempdir().unwrap();
    let [one, two] = ["1", "2"].map(|threads| judged(folder.path(), threads));
    assert_eq!(one["fingerprint"], two["fingerprint"]);
    assert_eq!(one["cells"], two["cells"]);
    let [none, both] = [&one["cells"][0], &one["cells"][1]];
    assert_eq!(
        (none["drives"].as_u64(), both["drives"].as_u64()),
        (Some(16), Some(32)),
        "16 rings, and two training seeds"
    );
    assert_eq!(none["speed_gain_mps"]["mean"], 0.0, "over itself, ring by ring");
    let mean = |cell: &Value| cell["mean_speed_mps"]["mean"].as_f64().unwrap();
    let gain = both["speed_gain_mps"]["mean"].as_f64().unwrap();
    assert!((gain - (mean(both) - mean(none))).abs() < 1e-9, "{gain}");
    assert!(
        both["worst_seed_mean_speed_mps"].as_f64().unwrap() < mean(both) && none["worst_seed_mean_speed_mps"].is_null()
    );
    assert_eq!(one["roads"][0]["rings_with_a_wave"], 16);
    assert!(both["over_fastest_single"].is_null(), "there is none beside it");
}

#[test]
fn a_row_of_several_seeds_is_compared_with_the_fastest_single_policy() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("small.toml");
    let more = "[[row]]\nname = \"PI\"\npolicies = [\"pi\"]\n[[row]]\nname = \"slow\"\npolicies = [\"constant\"]\n";
    std::fs::write(&file, SMALL.to_owned() + more).unwrap();
    let mut program = Command::cargo_bin("codrive").unwrap();
    program.args(["evaluate", "--json", "--benchmark"]).arg(&file);
    let judged: Value = serde_json::from_slice(&program.assert().success().get_output().stdout).unwrap();
    let mean = |k: usize| judged["cells"][k]["mean_speed_mps"]["mean"].as_f64().unwrap();
    let beside = &judged["cells"][1]["over_fastest_single"];
    // Cell 0 has no advice and does not count.
    let (name, fastest) = if mean(2) > mean(3) { ("PI", mean(2)) } else { ("slow", mean(3)) };
    assert_eq!(beside["policy"], name);
    assert!((beside["speed_gain_mps"]["mean"].as_f64().unwrap() - (mean(1) - fastest)).abs() < 1e-9, "{beside}");
    let [low, high] = ["low", "high"].map(|end| beside["speed_gain_mps"][end].as_f64().unwrap());
    assert!(low < mean(1) - fastest && mean(1) - fastest < high);
    assert!(judged["cells"][2]["over_fastest_single"].is_null(), "one policy is beside none");
}

#[test]
fn a_row_with_its_own_conditions_has_its_own_baseline_and_a_dot_per_cell() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("small.toml");
    let own = r#"
[[driver]]
name = "closing"
driver = "exact"
ego_response_s = 0.5
only_where_named = true
[[row]]
name = "a machine's"
policies = ["pi"]
drivers = ["closing"]
holds_s = [0.1]
"#;
    std::fs::write(&file, SMALL.replace("rings = 16", "rings = 4") + own).unwrap();
    let out = folder.path().join("out");
    let mut program = Command::cargo_bin("codrive").unwrap();
    program.args(["evaluate", "--json", "--benchmark"]).arg(&file).arg("--out").arg(&out).assert().success();
    let json: Value = serde_json::from_slice(&std::fs::read(out.join("benchmark.json")).unwrap()).unwrap();
    let place = |cell: &Value| {
        let text = |key: &str| cell[key].as_str().unwrap().to_owned();
        format!("{}, {} s, {}", text("policy"), cell["hold_s"], text("driver"))
    };
    let places: Vec<String> = json["cells"].as_array().unwrap().iter().map(place).collect();
    let expected = [
        "no advice, 1.0 s, people",
        "two seeds of one, 1.0 s, people",
        "no advice, 0.1 s, closing",
        "a machine's, 0.1 s, closing",
    ];
    assert_eq!(places, expected);
    // Without advice an exact ego has no speed to follow: the driver's own model drives it, as it drives the other vehicles.
    assert!(json["cells"][3]["speed_gain_mps"]["mean"].is_number());
    for (hold, rows, driver) in
        [("1", ["no advice", "two seeds of one"], "people"), ("0.1", ["no advice", "a machine's"], "closing")]
    {
        let svg = std::fs::read_to_string(out.join(format!("mean-speed-230-260-hold-{hold}.svg"))).unwrap();
        let picture = roxmltree::Document::parse(&svg).unwrap();
        let texts: Vec<&str> = picture.descendants().filter_map(|node| node.text()).map(str::trim).collect();
        for printed in rows.iter().chain(&[driver]) {
            assert!(texts.contains(printed), "{printed}: {texts:?}");
        }
        let dots = picture.descendants().filter(|node| node.has_tag_name("circle")).count();
        assert_eq!(dots, 2 + 1, "a dot for each row, and one of the legend");
    }
}

#[test]
fn names_with_commas_and_quotes_stay_in_their_cells() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("small.toml");
    let named = SMALL
        .replace("two seeds of one", r#"two \"seeds\", of one"#)
        .replace("\"people\"\ndriver", "\"all, mixed\"\ndriver");
    std::fs::write(&file, named.replace("rings = 16", "rings = 2")).unwrap();
    let out = folder.path().join("out");
    let mut program = Command::cargo_bin("codrive").unwrap();
    program.args(["evaluate", "--benchmark"]).arg(&file).arg("--out").arg(&out).assert().success();
    let text = std::fs::read_to_string(out.join("summary.csv")).unwrap();
    let starts = |start: &str| text.lines().any(|line| line.starts_with(start));
    assert!(starts(r#""ring",1,"all, mixed","two ""seeds"", of one",2,"#), "{text}");
    assert!(starts(r#""ring",1,"all, mixed","no advice",2,"#), "{text}");
}

/// Collects the source files below a folder, without files of tests.
fn sources(folder: &Path, found: &mut Vec<(String, String)>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") && !path.ends_with("tests.rs") {
            found.push((path.display().to_string(), std::fs::read_to_string(&path).unwrap()));
        }
    }
}

#[test]
fn nothing_but_the_benchmark_takes_its_random_numbers() {
    let mut found = Vec::new();
    sources(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &mut found);
    let naming = |text: &str| text.contains("\"benchmark\"") || text.contains("SEALED_STREAM");
    let mut naming_files: Vec<&str> =
        found.iter().filter(|(_, text)| naming(text)).map(|(path, _)| path.as_str()).collect();
    naming_files.sort_unstable();
    // The command, which has a flag of this name, and the benchmark with its report.
    let allowed = ["cli/evaluate/benchmark/mod.rs", "cli/evaluate/benchmark/report.rs", "cli/evaluate/mod.rs"];
    assert_eq!(naming_files.len(), allowed.len(), "{naming_files:?}");
    assert!(
        naming_files.iter().zip(allowed).all(|(path, end)| path.replace('\\', "/").ends_with(end)),
        "{naming_files:?}"
    );
    // The command uses the flag only, not the stream.
    let (_, command) = found.iter().find(|(path, _)| path.replace('\\', "/").ends_with("evaluate/mod.rs")).unwrap();
    assert!(!command.contains("SEALED_STREAM"));
}

#[test]
fn each_row_states_its_share_of_the_limit_in_value() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("small.toml");
    let limit = "[[row]]\nname = \"limit\"\npolicies = [\"pi\"]\nis_limit = true\n";
    let text = SMALL.replace("seed = 3", "seed = 3\nspeed_sd_penalty = 0.5") + limit;
    std::fs::write(&file, text).unwrap();
    let mut program = Command::cargo_bin("codrive").unwrap();
    program.args(["evaluate", "--json", "--benchmark"]).arg(&file);
    let judged: Value = serde_json::from_slice(&program.assert().success().get_output().stdout).unwrap();
    let cell = |k: usize| &judged["cells"][k];
    let value = |k: usize| {
        let sd = cell(k)["measures"]["speed_sd_over_vehicles_mps"].as_f64().unwrap();
        cell(k)["mean_speed_mps"]["mean"].as_f64().unwrap() - 0.5 * sd
    };
    let share = (value(1) - value(0)) / (value(2) - value(0));
    for (k, expected) in [0.0, share, 1.0].into_iter().enumerate() {
        let stated = cell(k)["share_of_limit"].as_f64().unwrap();
        assert!((stated - expected).abs() < 1e-9, "{k}: {stated} of {expected}");
        assert!((cell(k)["value_mps"].as_f64().unwrap() - value(k)).abs() < 1e-9, "{k}");
    }
}
