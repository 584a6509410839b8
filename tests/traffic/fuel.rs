//! Fuel consumption compared with SUMO's own program, which computes the emissions of a driving cycle.

use super::*;
use codrive::metrics::fuel;
use std::{fmt::Write, fs, process::Command};

/// Returns speeds and accelerations of cars on a ring (a wave with noise that starts from a jam), and a lattice up to 40 m/s.
fn speeds_and_accelerations() -> Vec<(f32, f32)> {
    let history = run_free(&EngineChoice::Native, ring(0.2), 600);
    let of_the_ring = history.windows(2).flat_map(|pair| {
        let accel = |i: usize| ((pair[1][i].speed_mps - pair[0][i].speed_mps) / STEP_S) as f32;
        (0..pair[0].len()).map(|i| (pair[1][i].speed_mps as f32, accel(i))).collect::<Vec<_>>()
    });
    let lattice = (0..80).flat_map(|v| (0..41).map(move |a| (v as f32 * 0.5 + 0.1, a as f32 * 0.15 - 4.0)));
    of_the_ring.chain(lattice).collect()
}

#[test]
fn fuel_is_that_of_the_emission_model_of_sumo() {
    let cycle = speeds_and_accelerations();
    let folder = tempfile::tempdir().expect("a folder");
    let (input, output) = (folder.path().join("cycle.csv"), folder.path().join("emissions.csv"));
    let mut text = String::new();
    for (second, (v, a)) in cycle.iter().enumerate() {
        writeln!(text, "{second};{v};{a}").expect("a String takes all text");
    }
    fs::write(&input, text).expect("written");
    let home = traffic::sumo::home().expect("SUMO is here");
    let done = Command::new(home.join("bin/emissionsDrivingCycle"))
        .env("SUMO_HOME", &home)
        .args(["--emission-class", "HBEFA4/PC_petrol_Euro-4", "--timeline-file"])
        .arg(&input)
        .arg("--output")
        .arg(&output)
        .output()
        .expect("SUMO's emissionsDrivingCycle runs");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let emissions = fs::read_to_string(&output).expect("read");
    assert_eq!(emissions.lines().count(), cycle.len());
    let (mut idling, mut coasting, mut driving) = (0, 0, 0);
    for (line, &(v, a)) in emissions.lines().zip(&cycle) {
        // Columns: time, speed, acceleration, slope, CO, CO2, HC, PMx, NOx, fuel (mg/s), electricity.
        let fuel_mg_s: f64 = line.split(';').nth(9).and_then(|text| text.parse().ok()).expect("ten columns");
        // SUMO's tables of fuel by volume assume 742 g/l for petrol.
        let found_mg_s = f64::from(fuel::sumo_rate_ml_s(v, a)) * 742.0;
        // SUMO prints six digits. Single precision has seven, and terms cancel.
        assert!((found_mg_s - fuel_mg_s).abs() < 1e-5 * fuel_mg_s + 2e-3, "{v} m/s, {a} m/s2: {found_mg_s}, {line}");
        match fuel_mg_s {
            _ if v < 0.5 => idling += 1,
            0.0 => coasting += 1,
            _ => driving += 1,
        }
    }
    // The drive covers all three branches of the model.
    assert!(idling > 20 && coasting > 20 && driving > 20, "{idling} {coasting} {driving}");
}
