//! Traffic compared with measured people from the command line: the table, JSON, the report, and messages of mistakes.

use super::advised::codrive;
use std::{fs, path::Path, process::Output};

/// Writes a ring of four vehicles on 100 m for two minutes, with a wave of 4 m/s against the direction of travel.
fn ring(folder: &Path) -> String {
    let mut text = "time_s,vehicle,leader,speed_mps,gap_m\n".to_owned();
    for step in 0..1200 {
        let time_s = f64::from(step) * 0.1;
        for vehicle in 0..4 {
            let place_m = 3.0 * time_s - 25.0 * f64::from(vehicle);
            let speed_mps = 3.0 + 0.3 * (std::f64::consts::TAU * (place_m + 4.0 * time_s) / 100.0).sin();
            text += &format!("{time_s:.1},{vehicle},{},{speed_mps:.4},20\n", (vehicle + 3) % 4);
        }
    }
    let path = folder.join("ring.csv");
    fs::write(&path, text).unwrap();
    path.to_str().unwrap().to_owned()
}

/// Runs the command; returns exit code, standard output and standard error.
fn validate(arguments: &[&str]) -> (i32, String, String) {
    let Output { status, stdout, stderr } = codrive(&["validate"]).args(arguments).output().unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (status.code().unwrap(), text(stdout), text(stderr))
}

#[test]
fn a_ring_is_compared_as_table_json_and_report() {
    let folder = tempfile::tempdir().unwrap();
    let (file, out) = (ring(folder.path()), folder.path().join("people"));
    let (code, table, error) = validate(&[&file, "--ring", "100", "--out", out.to_str().unwrap()]);
    assert_eq!(code, 0, "{error}");
    let line = |title: &str| table.lines().find(|line| line.starts_with(title)).unwrap_or_else(|| panic!("{table}"));
    assert!(line("Wave speed, m/s").contains("−4.00") && line("Wave speed, m/s").ends_with("yes"), "{table}");
    assert!(line("Mean speed of all vehicles, m/s").contains("3.13"), "{table}");
    assert!(table.trim_end().ends_with("are like people (Arizona ring, experiment A: follow safely)"), "{table}");
    let page = fs::read_to_string(out.join("report.html")).unwrap();
    assert!(page.contains("How like people: ring.csv") && page.contains("<svg") && page.ends_with("</html>\n"));
    for figure in ["space-time", "distributions", "gains", "persons"] {
        assert!(out.join(format!("figures/{figure}.svg")).is_file(), "{figure}");
    }
    // Two runs of the same traffic, as JSON; the folder has the same.
    let (code, json, error) = validate(&[&file, &file, "--ring", "100", "--from", "30", "--json"]);
    assert_eq!(code, 0, "{error}");
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!((&json["people"], &json["runs"]), (&"safe-followers".into(), &2.into()));
    let moments = json["moments"].as_array().unwrap();
    let wave = moments.iter().find(|moment| moment["moment"] == "wave_speed_mps").unwrap();
    assert_eq!((wave["model"].as_f64(), wave["people"].as_f64()), (Some(-4.0), Some(-4.25)));
    let kept = fs::read_to_string(out.join("moments.json")).unwrap();
    assert!(kept.contains("\"wave_share\""), "{kept}");
}

#[test]
fn mistakes_are_named_with_what_is_allowed() {
    let folder = tempfile::tempdir().unwrap();
    let file = ring(folder.path());
    let refused = |arguments: &[&str], wanted: &str| {
        let (code, _, error) = validate(arguments);
        assert!(code == 2 && error.contains(wanted), "{arguments:?}: {error}");
    };
    refused(
        &[&file, "--people", "safe-folowers"],
        "did you mean safe-followers?); allowed: safe-followers, gap-closers",
    );
    refused(&[&file, "--ring", "5"], "allowed: 10 to 100000 m");
    refused(&[&file, "--from", "60", "--to", "600"], "lasts 120.0 s; allowed: 0 <= from < to <= 120.0");
    refused(&["no-such.csv"], "no-such.csv: cannot be read");
    let broken = folder.path().join("broken.csv");
    fs::write(&broken, "time_s,vehicle,leader,speed_mps,gap_m\n0,1,,fast,\n").unwrap();
    refused(&[broken.to_str().unwrap()], "broken.csv: line 2: speed_mps is \"fast\"; allowed: a number from -2 to 100");
    let taken = folder.path().join("taken.toml");
    fs::write(&taken, "").unwrap();
    let (taken, fresh) = (taken.to_str().unwrap(), folder.path().join("fit.toml"));
    let fresh = fresh.to_str().unwrap();
    refused(&[&file, "--fit", fresh], "--ring");
    refused(&[&file, "--ring", "100", "--fit", taken], "taken.toml: exists\n  remedy: name another file with --fit");
    refused(
        &[&file, "--ring", "100", "--fit", fresh, "--fitted", "T,nois_sd"],
        "--fitted nois_sd: unknown key `nois_sd`",
    );
    refused(&[&file, "--ring", "100", "--fit", fresh, "--start", "safe-folowers"], "did you mean safe-followers?");
    refused(&[&file, "--traffic-drivers", "safe-followers"], "the vehicles form no platoon");
    let pair = folder.path().join("pair.csv");
    fs::write(&pair, "time_s,vehicle,leader,speed_mps,gap_m\n0,1,,3,\n0.1,1,,3,\n0,2,1,3,9\n0.1,2,1,3,9\n").unwrap();
    refused(&[pair.to_str().unwrap(), "--ring", "100", "--fit", fresh], "the vehicles do not form one ring");
}

#[test]
fn a_fitted_population_is_written_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let text = people(4.0 * 60.0);
    let (file, fitted) = (folder.path().join("people.csv"), folder.path().join("mine.toml"));
    fs::write(&file, text).unwrap();
    let (file, fitted) = (file.to_str().unwrap(), fitted.to_str().unwrap());
    let (code, text, error) = validate(&[
        file,
        "--ring",
        "130",
        "--fit",
        fitted,
        "--fitted",
        "T,noise_sd",
        "--budget",
        "3",
        "--rings",
        "4",
        "--bootstrap",
        "0",
    ]);
    assert_eq!(code, 0, "{error}");
    assert!(text.contains("fit to the first half") && text.contains("6 sets of numbers tried"), "{text}");
    let written = fs::read_to_string(fitted).unwrap();
    assert!(written.contains("Fit of 22 moments to people.csv, 0 to 240 s"), "{written}");
    let (code, json, error) = validate(&["--traffic-drivers", fitted, "--runs", "1", "--json"]);
    assert_eq!(code, 0, "{error}");
    assert!(json.contains("\"traffic_drivers\""));
}

/// Returns the file of ten vehicles on 130 m that drive by a model of their own, each with noise of its own.
fn people(duration_s: f64) -> String {
    let mut text = "time_s,vehicle,leader,speed_mps,gap_m\n".to_owned();
    let (mut speeds_mps, mut gaps_m, mut noises, mut number) = ([3.0f64; 10], [8.0f64; 10], [0.0f64; 10], 1u64);
    for step in 0..(duration_s / 0.1) as usize {
        let before_mps = speeds_mps;
        for k in 0..10 {
            number = number.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let uniform = (number >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
            noises[k] = 0.93 * noises[k] + 0.4 * uniform;
            let wanted_mps = (gaps_m[k] - 2.0).max(0.0) / (1.6 + 0.05 * k as f64);
            let leader_mps = before_mps[(k + 9) % 10];
            let accel_mps2 = 0.3 * (wanted_mps - before_mps[k]) + 0.5 * (leader_mps - before_mps[k]) + noises[k];
            speeds_mps[k] = (before_mps[k] + 0.1 * accel_mps2).max(0.0);
        }
        for k in 0..10 {
            gaps_m[k] += 0.1 * (speeds_mps[(k + 9) % 10] - speeds_mps[k]);
            let time_s = 0.1 * step as f64;
            text += &format!("{time_s:.1},{k},{},{:.4},{:.4}\n", (k + 9) % 10, speeds_mps[k], gaps_m[k]);
        }
    }
    text
}
