//! Recordings hold every tick, survive a cut at any byte and a kill at any moment, are never overwritten, and replay to the same bits.

mod automation;
mod format_one;
mod kills;
mod logged;
mod network;
mod network_analysis;
mod promises;
mod resealed;
mod resealed_tables;
mod resealing;
mod secondary_task;
mod signed;
mod tampering;

use assert_cmd::Command;
use codrive::{
    record::{Manifest, Table, TableReader},
    scenario::Scenario,
};
use std::{fs, os::unix::fs::PermissionsExt, path::Path};

fn codrive(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
    command.args(arguments).env("RUST_LOG", "error");
    command
}

/// Records a drive on the native engine.
fn record(folder: &Path, seconds: &str) {
    let folder = folder.to_str().unwrap();
    codrive(&["run", "--traffic", "native", "--duration", seconds, "--hold", "1", "--out", folder]).assert().success();
}

fn printed(command: &mut Command) -> (i32, String) {
    let output = command.output().unwrap();
    let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    (output.status.code().unwrap(), text)
}

#[test]
fn every_tick_and_step_is_in_the_tables_and_rows_join_by_their_tick() {
    let folder = tempfile::tempdir().unwrap();
    let drive = folder.path().join("p1");
    record(&drive, "12");
    let table = |table: Table| TableReader::parquet(&table.parquet(&drive)).unwrap();
    let (ego, cars, advice) = (table(Table::Ego), table(Table::Cars), table(Table::Advice));
    assert_eq!(ego.wholes("tick"), (1..=1200).collect::<Vec<u64>>());
    assert_eq!(cars.rows(), 120 * 22);
    assert_eq!(advice.rows(), 12);

    // The ego is car 0 of its step, with the same values.
    let (speeds, places) = (ego.numbers("speed_mps"), ego.numbers("s_m"));
    let (car_ticks, ids) = (cars.wholes("tick"), cars.ids("car"));
    let (car_speeds, car_places) = (cars.numbers("speed_mps"), cars.numbers("s_m"));
    let mut joined = 0;
    for i in (0..cars.rows()).filter(|&i| ids[i] == Some(0)) {
        let tick = car_ticks[i] as usize;
        assert!(tick.is_multiple_of(10));
        assert_eq!((car_speeds[i], car_places[i]), (speeds[tick - 1], places[tick - 1]));
        joined += 1;
    }
    assert_eq!(joined, 120);

    // Gap and headway differ by a vehicle's length, the target lies in its range, and the mean is over the vehicles of the step.
    let (gaps, headways) = (ego.numbers("gap_m"), ego.numbers("headway_m"));
    assert!(gaps.iter().zip(&headways).all(|(g, h)| (h.unwrap() - g.unwrap() - 5.0).abs() < 1e-9));
    let mean = ego.numbers("mean_speed_mps")[1199].unwrap();
    let of_step: Vec<f64> =
        (0..cars.rows()).filter(|&i| car_ticks[i] == 1200).map(|i| car_speeds[i].unwrap()).collect();
    assert!((of_step.iter().sum::<f64>() / 22.0 - mean).abs() < 1e-9);
    let (target, in_range) = (ego.numbers("target_mps"), ego.flags("in_range"));
    assert!(target.iter().all(Option::is_some) && in_range.iter().all(Option::is_some));

    let manifest = Manifest::load(&drive).unwrap();
    assert_eq!(manifest.ended.as_deref(), Some("duration"));
    assert_eq!(manifest.map.sha256.map(|h| h.len()), Some(64));
    let summary: serde_json::Value = serde_json::from_slice(&fs::read(drive.join("summary.json")).unwrap()).unwrap();
    assert_eq!(summary["hash"].as_str(), manifest.hash.as_deref());
    assert!(!drive.join("journal").exists());
}

#[test]
fn only_the_user_can_read_the_files_and_nothing_is_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let drive = folder.path().join("p1");
    record(&drive, "1");
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;
    assert_eq!(mode(&drive), 0o700);
    let mut before = Vec::new();
    for entry in fs::read_dir(&drive).unwrap() {
        let path = entry.unwrap().path();
        assert_eq!(mode(&path), 0o600, "{}", path.display());
        before.push((path.clone(), fs::read(path).unwrap()));
    }
    let (code, text) = printed(&mut codrive(&["run", "--duration", "1", "--out", drive.to_str().unwrap()]));
    assert!(code == 2 && text.contains("holds a recording already") && text.contains("another folder"), "{text}");
    for (path, bytes) in before {
        assert_eq!(fs::read(&path).unwrap(), bytes, "{}", path.display());
    }
}

#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    let inside = file.join("p1");
    let (code, text) = printed(&mut codrive(&["run", "--duration", "1", "--out", inside.to_str().unwrap()]));
    assert!(code == 1 && text.contains(inside.to_str().unwrap()), "{text}");
}

#[test]
fn a_replay_proves_every_tick() {
    let folder = tempfile::tempdir().unwrap();
    let drive = folder.path().join("p1");
    codrive(&["run", "--duration", "6", "--driver", "follow", "--out", drive.to_str().unwrap()]).assert().success();
    let (code, text) = printed(&mut codrive(&["replay", drive.to_str().unwrap()]));
    assert!(code == 0 && text.contains("all 600 ticks are the same to the bit; every file agrees"), "{text}");
    let (code, text) = printed(&mut codrive(&["replay", folder.path().to_str().unwrap()]));
    assert!(code == 2 && text.contains("holds no recording"), "{text}");
}

#[cfg(feature = "desktop")]
#[test]
fn the_sound_file_is_as_long_as_the_drive_private_and_reproducible() {
    let folder = tempfile::tempdir().unwrap();
    let drive = folder.path().join("p1");
    record(&drive, "3");
    let wav = |name: &str| {
        let file = folder.path().join(name);
        let arguments = ["replay", drive.to_str().unwrap(), "--wav", file.to_str().unwrap()];
        (printed(&mut codrive(&arguments)), file)
    };
    let ((code, text), first) = wav("a.wav");
    assert_eq!(code, 0, "{text}");
    assert_eq!(fs::metadata(&first).unwrap().permissions().mode() & 0o777, 0o600);
    let mut reader = hound::WavReader::open(&first).unwrap();
    let spec = reader.spec();
    assert_eq!((spec.channels, spec.sample_rate, reader.duration()), (2, 48_000, 3 * 48_000));
    let loudest = reader.samples::<i16>().map(|sample| sample.unwrap().unsigned_abs()).max().unwrap();
    assert!((500..32_000).contains(&loudest), "an engine that idles and pulls away: {loudest}");
    let (_, second) = wav("b.wav");
    assert_eq!(fs::read(&first).unwrap(), fs::read(second).unwrap());
    let ((code, text), _) = wav("a.wav");
    assert!(code == 1 && text.contains("a.wav") && text.contains("name another"), "{code}: {text}");
}

#[test]
fn any_moment_of_a_replay_is_the_world_as_it_was_then() {
    use codrive::replay::{Replay, Verifier};
    let folder = tempfile::tempdir().unwrap();
    let drive = folder.path().join("drive");
    record(&drive, "12.05");
    let (prover, opened) = Verifier::start(&drive).unwrap();
    assert_eq!(opened.end.0, 1205);
    // Nothing reads the timeline until the replay is over, as if the window were hidden.
    while !prover.is_over() {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let known = prover.known();
    let (timeline, proof) = (&known.timeline, &known.report);
    assert_eq!((proof.ticks, proof.first_difference), (1205, None), "proven to the end");
    assert_eq!(timeline.end_s(), 12.05);

    let mut world = Replay::open(&drive).unwrap();
    let mut at = 0;
    // The timeline is read backwards and the world is driven forwards: the timeline can be read in any order.
    let mut wanted: Vec<u64> = vec![1205, 1203, 1200, 977, 500, 333, 10, 1];
    let seen: Vec<_> = wanted.iter().map(|tick| timeline.at(*tick as f64 / 100.0)).collect();
    wanted.reverse();
    for (tick, (snapshot, fraction)) in wanted.iter().zip(seen.iter().rev()) {
        world.advance(tick - at).unwrap();
        at = *tick;
        let now = world.world().snapshot();
        let ego = snapshot.ego_before.position.lerp(snapshot.ego.position, f64::from(*fraction));
        // Between two steps of 0.1 s a vehicle under 3 m/s2 is at most 4 mm from the straight line.
        assert!(ego.distance(now.ego.position) < 0.005, "tick {tick}: {}", ego.distance(now.ego.position));
        assert!((snapshot.ego.speed_mps - now.ego.speed_mps).abs() < 0.05, "tick {tick}");
        for (shown, car) in snapshot.cars.iter().zip(&now.cars) {
            let place = shown.pose_before.lerp(&shown.pose, f64::from(*fraction)).position;
            assert!(place.distance(car.pose.position) < 0.005, "tick {tick}, {:?}", car.id);
        }
    }
}

#[test]
fn a_replay_that_is_closed_in_the_middle_ends_at_once() {
    use codrive::replay::Verifier;
    let folder = tempfile::tempdir().unwrap();
    let drive = folder.path().join("drive");
    record(&drive, "60");
    let (prover, _) = Verifier::start(&drive).unwrap();
    let proven = prover.known().report.ticks;
    assert!(proven < 6000, "{proven}: it has only begun");
    drop(prover);
}

#[test]
fn a_what_if_drives_the_same_seed_and_prints_the_paired_difference() {
    let folder = tempfile::tempdir().unwrap();
    let drive = folder.path().join("drive");
    record(&drive, "20");
    let program = |arguments: &[&str]| printed(codrive(&["replay", drive.to_str().unwrap()]).args(arguments));
    let (code, text) = program(&["--what-if", "policy=constant", "--what-if", "driver=perfect"]);
    assert_eq!(code, 0, "{text}");
    assert!(text.contains("instead with policy=constant, driver=perfect"), "{text}");
    let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains("recorded driver simulated: follow, policy ring-250-speed"), "{text}");
    assert!(words.contains("instead driver simulated: perfect, policy constant"), "{text}");
    assert!(words.contains("recorded instead recorded less instead"), "{text}");
    let row = text.lines().find(|line| line.starts_with("mean speed, all vehicles")).unwrap();
    let numbers: Vec<f64> = row.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let [recorded, instead, difference] = numbers[..] else { panic!("{row}") };
    assert!((recorded - instead - difference).abs() < 0.0011 && recorded != instead, "{row}");
    let beside = folder.path().join("drive-what-if-policy-constant-driver-perfect");
    let other = Scenario::from_file(&beside.join("scenario.toml")).unwrap();
    let same = Scenario::from_file(&drive.join("scenario.toml")).unwrap();
    assert_eq!((other.seed, other.duration_s, &*other.policy), (same.seed, 20.0, "constant"));
    assert_eq!(TableReader::parquet(&Table::Ego.parquet(&beside)).unwrap().rows(), 2000);

    // Nothing is overwritten; an unknown setting is named.
    let (code, text) = program(&["--what-if", "policy=constant", "--what-if", "driver=perfect"]);
    assert!(code != 0 && text.contains("nothing is overwritten"), "{code} {text}");
    let (code, text) = program(&["--what-if", "polcy=none"]);
    assert!(code == 2 && text.contains("there is no setting polcy"), "{code} {text}");
    let (code, text) = program(&["--what-if", "policy=nobody"]);
    assert!(code == 2 && text.contains("policy `nobody` is unknown"), "{code} {text}");
}
