//! `codrive train` and its results, through the program itself.

use assert_cmd::Command;
use std::{fs, path::Path};

/// Configuration of a training of seconds: small rings, small network.
const SMALL: &str = "vehicles_min = 8\nvehicles_max = 8\ncircumference_min_m = 100\ncircumference_max_m = 100\n\
    warm_up_s = 10\nhorizon_s = 30\nhidden_width = 8\nbatch = 640\nrings = 16\nvalue_batch = 320\njudge_every = 2\n\
    iterations = 2\n";

fn codrive(arguments: &[&str]) -> assert_cmd::assert::Assert {
    Command::cargo_bin("codrive").unwrap().args(arguments).assert()
}

/// Runs the program, checks that it exits with 2, and returns its message.
fn refused(arguments: &[&str]) -> String {
    let output = codrive(arguments).code(2).get_output().clone();
    String::from_utf8(output.stderr).unwrap()
}

fn text(path: &Path) -> String {
    path.to_string_lossy().into_owned()
}

#[test]
fn a_training_makes_a_policy_that_drives_and_resumes_to_the_same_bits() {
    let dir = tempfile::tempdir().unwrap();
    let config = dir.path().join("small.toml");
    fs::write(&config, SMALL).unwrap();
    let (config, whole, parts) = (text(&config), dir.path().join("whole"), dir.path().join("parts"));
    codrive(&["train", "--config", &config, "--iterations", "4", "--out", &text(&whole)]).success();
    codrive(&["train", "--config", &config, "--out", &text(&parts)]).success();
    codrive(&["train", "--resume", "--iterations", "4", "--out", &text(&parts)]).success();
    for name in ["policy.toml", "policy.onnx", "checkpoint.json", "curve.csv", "curve.svg"] {
        assert!(fs::read(whole.join(name)).unwrap() == fs::read(parts.join(name)).unwrap(), "{name}");
    }
    let policy = text(&whole.join("policy.toml"));
    let drive = ["run", "--traffic", "native", "--policy", &policy, "--duration", "5", "--json"];
    let output = codrive(&drive).success().get_output().clone();
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["summary"]["advices"], 5, "one a second");
    // The ONNX file beside it drives alike: its table is equal except for the name.
    let onnx = text(&whole.join("policy.onnx"));
    let judged = |policy: &str| {
        let arguments = ["evaluate", "--config", &config, "--policy", policy, "--over", "2", "--json"];
        let output = codrive(&arguments).success().get_output().clone();
        let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        report["rows"][0]["mean_speed_mps"]["mean"].as_f64().unwrap()
    };
    assert!((judged(&policy) - judged(&onnx)).abs() < 1e-3);

    // No file is overwritten, and a training resumes only with its old settings.
    let before = fs::read(whole.join("policy.toml")).unwrap();
    let printed = refused(&["train", "--config", &config, "--out", &text(&whole)]);
    assert!(printed.contains("already holds a training (policy.toml)"), "{printed}");
    let printed = refused(&["train", "--resume", "--seed", "7", "--out", &text(&whole)]);
    assert!(printed.contains("was trained with `seed = 1`, not `seed = 7`"), "{printed}");
    assert_eq!(fs::read(whole.join("policy.toml")).unwrap(), before);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_reported_and_leaves_the_old_checkpoint() {
    let dir = tempfile::tempdir().unwrap();
    let config = dir.path().join("small.toml");
    fs::write(&config, SMALL).unwrap();
    let out = dir.path().join("out");
    codrive(&["train", "--config", &text(&config), "--out", &text(&out)]).success();
    let before = fs::read(out.join("checkpoint.json")).unwrap();
    let resume = ["train", "--resume", "--iterations", "4", "--out", &text(&out)];
    // The file size limit is half the checkpoint's size, in blocks of 512 bytes: a program cannot tell this from a full disk.
    let room = before.len() / 2 / 512;
    let output = std::process::Command::new("sh")
        .args(["-c", &format!("trap '' XFSZ; ulimit -f {room}; exec \"$@\""), "sh", env!("CARGO_BIN_EXE_codrive")])
        .args(resume)
        .output()
        .unwrap();
    let printed = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{printed}");
    assert!(printed.contains("File too large") && printed.contains("the previous file is kept"), "{printed}");
    assert_eq!(fs::read(out.join("checkpoint.json")).unwrap(), before);
    assert!(!out.join("checkpoint.json.new").exists(), "nothing half-written is left");
    codrive(&resume).success();
}

#[test]
fn an_evaluation_writes_tables_and_figures_and_overwrites_no_file() {
    let dir = tempfile::tempdir().unwrap();
    let config = dir.path().join("small.toml");
    fs::write(&config, SMALL).unwrap();
    let out = text(&dir.path().join("out"));
    let base = ["evaluate", "--config", &text(&config), "--over", "3", "--out", &out, "--adherence"];
    let more =
        ["--policy", "two-phase", "--policy", "none", "--holds", "1,5", "--driver", "perfect", "--driver", "error=1"];
    let arguments: Vec<&str> = base.into_iter().chain(more).collect();
    codrive(&arguments).success();
    let rings = fs::read_to_string(Path::new(&out).join("rings.csv")).unwrap();
    assert!(rings.starts_with("policy,hold_s,driver,traffic,seed,ring,window_from_s,window_to_s,mean_speed_mps,"));
    assert_eq!(rings.lines().count(), 1 + 2 * 2 * 2 * 3);
    let summary = fs::read_to_string(Path::new(&out).join("summary.csv")).unwrap();
    assert_eq!(summary.lines().count(), 1 + 2 * 2 * 2);
    for name in ["speed-against-hold.svg", "adherence.svg", "space-time-two-phase-hold-5-s-driver-perfect.svg"] {
        let picture = fs::read_to_string(Path::new(&out).join(name)).unwrap();
        assert!(picture.starts_with("<svg") && picture.ends_with("</svg>\n") && !picture.contains("NaN"), "{name}");
        // The figure is as wide as a journal's page. It is also a PNG at 300 dots per inch if the program can draw pictures.
        assert!(picture.contains(" width=\"183mm\" "), "{name}");
        #[cfg(feature = "desktop")]
        {
            let (wide, _) = image::image_dimensions(Path::new(&out).join(name).with_extension("png")).unwrap();
            assert_eq!(f64::from(wide), (183.0_f64 / 25.4 * 300.0).ceil(), "{name}");
        }
    }
    assert!(refused(&arguments).contains("already holds an evaluation (rings.csv)"));
    let printed = refused(&["evaluate", "--driver", "folow"]);
    assert!(printed.contains("no driver is called \"folow\" (did you mean follow?)"), "{printed}");
    assert!(refused(&["evaluate", "--holds", "0.25"]).contains("allowed: a whole number of steps of 0.1 s"));
    let drawn = ["evaluate", "--traffic", "native", "--follow", "driver"];
    let printed = refused(&drawn);
    assert!(printed.contains("draws a driver for each ring") && printed.contains("--driver"), "{printed}");
}

/// Runs an evaluation of short drives as JSON. Returns its rows by policy and driver.
fn evaluated(arguments: &[&str], [warm_up, horizon]: [&str; 2]) -> Vec<serde_json::Value> {
    let short = ["evaluate", "--json", "--over", "2", "--warm-up", warm_up, "--horizon", horizon];
    let all: Vec<&str> = short.iter().chain(arguments).copied().collect();
    let output = codrive(&all).success().get_output().clone();
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    report["rows"].as_array().unwrap().clone()
}

#[test]
fn each_driver_behaves_alike_on_every_engine() {
    let drivers = ["follow", "perfect", "sloppy", "idm", "guarded", "exact", "reaction=1,error=0.5"];
    for engine in ["ring", "native", "sumo"] {
        let named: Vec<&str> = drivers.iter().flat_map(|driver| ["--driver", driver]).collect();
        let slow = ["--traffic", engine, "--policy", "constant", "--policy-speed", "2"];
        let rows = evaluated(&slow.iter().chain(&named).copied().collect::<Vec<_>>(), ["5", "20"]);
        assert_eq!(rows.len(), 2 * drivers.len(), "{engine}: without advice, too");
        let (advised, none) = rows.split_at(drivers.len());
        let speeds =
            |row: &serde_json::Value| [0, 1].map(|ring| row["rings"][ring]["mean_speed_mps"].as_f64().unwrap());
        for (i, driver) in drivers.iter().enumerate() {
            assert_eq!((&advised[i]["policy"], &none[i]["policy"]), (&"constant".into(), &"none".into()));
            // 2 m/s is slower than the traffic: a driver who follows it slows all vehicles down, a driver who ignores it does not.
            let [with, without] = [&advised[i], &none[i]].map(speeds);
            assert_eq!(with == without, *driver == "idm", "{driver} on {engine}: {with:?} {without:?}");
            assert_eq!(advised[i]["crashes"], 0, "{driver} on {engine}");
        }
        // 8 m/s is faster: of the two drivers who follow exactly, only `guarded` brakes.
        let fast = ["--traffic", engine, "--policy", "constant", "--policy-speed", "8"];
        let named = ["--driver", "exact", "--driver", "guarded", "--driver", "follow"];
        let rows = evaluated(&fast.iter().chain(&named).copied().collect::<Vec<_>>(), ["5", "20"]);
        let crashes: Vec<u64> = rows.iter().map(|row| row["crashes"].as_u64().unwrap()).collect();
        assert_eq!(crashes, [2, 0, 0, 0, 0, 0], "{engine}");
    }
}

#[test]
fn an_evaluation_has_a_row_without_advice_and_reports_crashes() {
    let dir = tempfile::tempdir().unwrap();
    let out = text(&dir.path().join("out"));
    let rows = evaluated(&["--policy", "ring-250-speed", "--policy", "pi"], ["120", "300"]);
    let of = |i: usize| (rows[i]["policy"].as_str().unwrap(), rows[i]["mean_speed_mps"]["mean"].as_f64().unwrap());
    assert_eq!([of(0).0, of(1).0, of(2).0], ["ring-250-speed", "pi", "none"]);
    assert!(rows.iter().all(|row| row["driver"] == "follow" && row["crashes"] == 0), "{rows:?}");
    // docs/references.md: ring: the wave alone flows at 3.0 m/s.
    assert!((2.8..3.2).contains(&of(2).1) && of(0).1 > of(2).1 + 0.5, "{:?} {:?}", of(0), of(2));

    let exact = ["evaluate", "--policy", "ring-250-speed", "--driver", "exact", "--over", "3", "--out", &out];
    let short = ["--warm-up", "120", "--horizon", "300"];
    let printed = codrive(&exact.into_iter().chain(short).collect::<Vec<_>>()).success().get_output().stdout.clone();
    let printed = String::from_utf8(printed).unwrap();
    assert!(
        printed.contains("!!! CRASHED in 3 of 3 drives, first ") && printed.contains("3 of 6 drives ended in a crash"),
        "{printed}"
    );
    assert!(printed.contains("\nnone, driver exact\n"), "{printed}");
    for figure in ["space-time", "speeds"].map(|kind| format!("{kind}-ring-250-speed-hold-1-s-driver-exact.svg")) {
        let picture = fs::read_to_string(Path::new(&out).join(&figure)).unwrap();
        assert!(picture.contains(">CRASH at ") && picture.contains("CRASHED in 3 of 3 drives"), "{figure}");
    }
}

#[test]
fn auto_is_the_policy_of_the_map_and_an_unknown_name_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let config = dir.path().join("small.toml");
    fs::write(&config, SMALL).unwrap();
    let printed = codrive(&["evaluate", "--config", &text(&config), "--policy", "auto", "--over", "2"]).success();
    let printed = String::from_utf8_lossy(&printed.get_output().stdout).into_owned();
    assert!(printed.contains("ring-250-speed"), "{printed}");
    let refusal = refused(&["evaluate", "--policy", "autos"]);
    assert!(refusal.contains("policy `autos` is unknown (did you mean auto?); allowed: auto, none"), "{refusal}");
}

#[test]
fn whole_drives_have_the_same_measures_on_sumo_and_the_native_engine() {
    let judged = |engine: &str| -> serde_json::Value {
        let whole = ["evaluate", "--traffic", engine, "--policy", "two-phase", "--driver", "perfect", "--over", "2"];
        let short = ["--warm-up", "5", "--horizon", "20", "--json"];
        let output = codrive(&whole.into_iter().chain(short).collect::<Vec<_>>()).success().get_output().clone();
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let [native, sumo] = ["native", "sumo"].map(judged);
    assert_eq!((&native["traffic"], &sumo["traffic"]), (&"native".into(), &"sumo".into()), "{sumo}");
    for ring in 0..2 {
        let of = |report: &serde_json::Value| report["rows"][0]["rings"][ring].clone();
        let [native, sumo] = [of(&native), of(&sumo)];
        for report in [&native, &sumo] {
            assert!(report["mean_speed_mps"].as_f64().unwrap() > 0.5, "{report}");
            assert!(report["fuel_l_100km"].as_f64().unwrap() > 1.0, "{report}");
            assert_eq!(report["crashed"], false);
        }
        // The engines agree to 1e-11 m without an externally driven vehicle; the ego's report passes through SUMO's text format of angles
        // and positions.
        for measure in ["mean_speed_mps", "speed_sd_over_vehicles_mps", "min_gap_to_neighbours_m", "fuel_l_100km"] {
            let [a, b] = [&native, &sumo].map(|report| report[measure].as_f64().unwrap());
            assert!((a - b).abs() < 0.01 * a.abs(), "{measure}: {a} native, {b} on SUMO");
        }
    }
}

#[test]
fn bad_configurations_are_named_with_what_is_allowed() {
    let dir = tempfile::tempdir().unwrap();
    let out = text(&dir.path().join("out"));
    let file = dir.path().join("train.toml");
    let printed = |content: &str| {
        fs::write(&file, content).unwrap();
        refused(&["train", "--config", &text(&file), "--out", &out])
    };
    assert!(printed("hold_s = 1\nhoold_s = 2\n").contains("train.toml:2:1: unknown key `hoold_s`"));
    assert!(
        printed("max_kl = -1").contains("train.toml:1:10: max_kl is -1.0; allowed: a number from 0.000001 to 1 nat")
    );
    assert!(printed("rings = 20").contains("rings is 20; allowed: a multiple of 16"));
    assert!(printed("vehicles_max = 40").contains("vehicles_max is 40; allowed: at most 28"));
    assert!(printed("least_spacing_m = 14").contains("least_spacing_m is 14; allowed: at most 13.64"));
    assert!(
        printed("sees = \"speed,gapp\"")
            .contains("sees names `gapp` (did you mean gap?); allowed: speed, leader_speed")
    );
    assert!(printed("hold_s = 0.25").contains("hold_s is 0.25; allowed: a whole number of steps of 0.1 s"));
    assert!(!Path::new(&out).join("train.toml").exists());
}

#[test]
fn a_file_that_is_no_policy_is_refused_before_the_drive() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("foreign.toml");
    let printed = |content: Option<&str>| {
        content.inspect(|c| fs::write(&file, c).unwrap());
        refused(&["run", "--traffic", "native", "--policy", &text(&file), "--duration", "5"])
    };
    assert!(printed(None).contains("foreign.toml: cannot be read"), "{}", printed(None));
    assert!(printed(Some("speed = 3")).contains("foreign.toml: is not a policy file"));
    assert!(printed(Some("format = ")).contains("foreign.toml: is not a policy file"));
}
