//! A replay detects a change to a recording even after all checksums were recomputed, wherever the drive itself contradicts the change.
//! Every key of the manifest, the summary and the scenario, every column and every file is changed, deleted and emptied. Values that no
//! drive can prove are listed here.

use super::{
    codrive, printed,
    resealing::{copy, edit_json, files, read_json, reseal, sha256},
    tampering::{rows, write},
};
use codrive::{
    drive_loop::offline::OfflineDrive,
    record,
    replay::{Replay, ReplayReport},
    scenario::{AdvisedVehicles, DisplaySettings, Scenario},
    traffic::EngineChoice,
};
use serde_json::{Value, json};
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
    sync::{Mutex, OnceLock},
};

/// SUMO runs one simulation per process.
pub static SUMO: Mutex<()> = Mutex::new(());

/// Returns a scenario with six vehicles, three of them advised; its drives last 3 s.
fn scenario() -> Scenario {
    Scenario {
        traffic: EngineChoice::Native,
        vehicles: 6,
        advised: AdvisedVehicles::Share(0.5),
        hold_s: 0.5,
        warm_up_s: 1.0,
        duration_s: 3.0,
        seed: 3,
        display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
        ..Scenario::default()
    }
}

/// Returns the folder of that drive, recorded once.
pub fn whole() -> &'static Path {
    static WHOLE: OnceLock<tempfile::TempDir> = OnceLock::new();
    let folder = WHOLE.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let mut run = OfflineDrive::new(&scenario(), [0.0, f64::INFINITY]).unwrap();
        run.record(&folder.path().join("whole")).unwrap();
        run.until(3.0).unwrap();
        run.finish_recording().unwrap();
        folder
    });
    Box::leak(folder.path().join("whole").into_boxed_path())
}

/// Returns a copy of a recording after `tamper`, and the temporary folder that owns it.
pub fn tampered(of: &Path, tamper: impl FnOnce(&Path)) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let drive = folder.path().join("p1");
    copy(of, &drive);
    tamper(&drive);
    (folder, drive)
}

/// Replays a recording. Returns the report, or why the replay cannot begin or go on.
pub fn replayed(drive: &Path) -> Result<ReplayReport, String> {
    let mut replay = Replay::open(drive).map_err(|error| error.to_string())?;
    replay.advance(u64::MAX).map_err(|error| error.to_string())?;
    Ok(replay.report().clone())
}

pub fn is_found(drive: &Path) -> bool {
    replayed(drive).is_ok_and(|report| !report.is_proven()) || replayed(drive).is_err()
}

/// Returns the JSON pointers of all leaf values.
fn leaves(value: &Value, at: &str) -> Vec<String> {
    match value {
        Value::Object(keys) if !keys.is_empty() => {
            keys.iter().flat_map(|(k, v)| leaves(v, &format!("{at}/{k}"))).collect()
        }
        Value::Array(values) if !values.is_empty() => {
            values.iter().enumerate().flat_map(|(i, v)| leaves(v, &format!("{at}/{i}"))).collect()
        }
        _ => vec![at.into()],
    }
}

/// Returns another value of the same kind.
fn other(value: &Value) -> Value {
    match value {
        Value::Null => "other".into(),
        Value::Bool(is) => (!is).into(),
        Value::Number(n) => n.as_u64().map_or_else(|| (n.as_f64().unwrap() + 1.0).into(), |n| (n + 1).into()),
        Value::String(text) => format!("{text}x").into(),
        Value::Array(_) => json!([{ "time_s": 1.0 }]),
        Value::Object(_) => json!({ "more": 1 }),
    }
}

/// Returns the values of a file whose change, and whose deletion, a replay of the resealed recording does not detect.
fn unfound(file: &str) -> [BTreeSet<String>; 2] {
    let before = read_json(&whole().join(file));
    let seals = ["/checksums", "/sha256"];
    let mut unfound = [BTreeSet::new(), BTreeSet::new()];
    for place in leaves(&before, "").into_iter().filter(|place| !seals.contains(&place.as_str())) {
        let change = |value: &mut Value| *value.pointer_mut(&place).unwrap() = other(before.pointer(&place).unwrap());
        let delete = |value: &mut Value| {
            let (parent, key) = place.rsplit_once('/').unwrap();
            match value.pointer_mut(parent).unwrap() {
                Value::Object(keys) => drop(keys.shift_remove(key)),
                Value::Array(values) => drop(values.remove(key.parse().unwrap())),
                _ => unreachable!("a leaf has a list above it"),
            }
        };
        for (unfound, change) in unfound.iter_mut().zip([&change as &dyn Fn(&mut Value), &delete]) {
            let (_folder, drive) = tampered(whole(), |drive| edit_json(&drive.join(file), change));
            assert!(
                record::changes(&drive).map_or(true, |found| !found.is_empty()),
                "{file}{place}: without new checksums"
            );
            reseal(&drive);
            if !is_found(&drive) {
                unfound.insert(place.clone());
            }
        }
    }
    unfound
}

fn set<const N: usize>(names: [&str; N]) -> BTreeSet<String> {
    names.map(str::to_owned).into()
}

#[test]
fn a_resealed_recording_that_was_not_changed_is_proven_file_by_file() {
    // The copy also holds a table of another device and an input that the drive does not read.
    let (_folder, drive) = tampered(whole(), |drive| {
        for name in ["streams/eyes.parquet", "inputs/maps/other/net.xml"] {
            fs::create_dir_all(drive.join(name).parent().unwrap()).unwrap();
            fs::write(drive.join(name), "more").unwrap();
        }
        reseal(drive);
    });
    let report = replayed(&drive).unwrap();
    assert!(report.is_proven() && report.ticks == 300, "{report:?}");
    let proven: BTreeMap<String, String> =
        report.files.iter().map(|file| (file.file.clone(), file.by.to_string())).collect();
    let by_driving = ["ego", "cars", "advice", "events", "advised"].map(|table| format!("{table}.parquet"));
    let by_driving = by_driving.iter().map(String::as_str).chain(["scenario.toml", "summary.json", "manifest.json"]);
    let mut expected: BTreeMap<String, String> = by_driving.map(|name| (name.into(), "driving".into())).collect();
    for name in ["frames.parquet", "streams/eyes.parquet", "inputs/maps/other/net.xml"] {
        expected.insert(name.into(), "checksum only".into());
    }
    assert_eq!(proven, expected);
}

#[test]
fn a_change_of_any_manifest_key_that_follows_from_the_drive_is_found() {
    let [changed, deleted] = unfound("manifest.json");
    // Program, machine and time: facts that no drive can prove.
    assert_eq!(changed, set(["/program", "/build", "/policy_asked", "/began", "/machine", "/graphics"]));
    assert_eq!(deleted, set(["/policy_asked"]));
    // Optional facts, and a drive that claims to have been cut.
    let added = [("participant", json!("P7")), ("screen", Value::Null), ("state", "recovered".into())];
    for (key, value) in added {
        let (_folder, drive) =
            tampered(whole(), |drive| edit_json(&drive.join("manifest.json"), |keys| keys[key] = value));
        assert!(!record::changes(&drive).unwrap().is_empty(), "{key}: without new checksums");
        reseal(&drive);
        assert!(!is_found(&drive), "{key} follows from no drive");
    }
    let others = [
        ("note", json!(1)),
        ("network_tables", true.into()),
        ("advised_table", false.into()),
        ("lateral_accel_mps2", 2.0.into()),
        ("format", 2.into()),
    ];
    for (key, value) in others {
        let (_folder, drive) = tampered(whole(), |drive| {
            edit_json(&drive.join("manifest.json"), |keys| keys[key] = value);
            reseal(drive);
        });
        assert!(is_found(&drive), "{key}");
        if key == "network_tables" {
            let found: Vec<String> = record::changes(&drive).unwrap().iter().map(ToString::to_string).collect();
            let message = "manifest.json: network_tables is true; the scenario is of a drive on a closed route";
            assert_eq!(found, [message], "without driving, too");
        }
    }
}

#[test]
fn a_change_of_any_summary_key_is_found() {
    assert_eq!(unfound("summary.json"), [BTreeSet::new(), BTreeSet::new()]);
    let (_folder, drive) = tampered(whole(), |drive| {
        edit_json(&drive.join("summary.json"), |keys| keys["more"] = 1.into());
        reseal(drive);
    });
    let facts = replayed(&drive).unwrap().facts;
    assert_eq!(facts[0].to_string(), "summary.json: more is 1, driven again nothing");
    let (_folder, drive) = tampered(whole(), |drive| {
        let path = drive.join("summary.json");
        fs::write(&path, read_json(&path).to_string()).unwrap();
        reseal(drive);
    });
    let facts = replayed(&drive).unwrap().facts;
    assert_eq!(
        facts[0].to_string(),
        "summary.json: the file is written otherwise, driven again other bytes of the same values"
    );
}

/// Settings of the picture that no manifest holds.
const SEEN: [&str; 15] = [
    "/guidance",
    "/ordinary_paints",
    "/time_h",
    "/visibility_km",
    "/wind_mps",
    "/trees",
    "/ego_colour",
    "/traffic_colour",
    "/cockpit",
    "/palette",
    "/mirror_yaw_deg",
    "/mirror_pitch_deg",
    "/mirror_fov_deg",
    "/mirror_radius_m",
    "/quality",
];

/// Returns another value that the setting allows.
fn other_setting(scenario: &Value, place: &str) -> Value {
    let words = [
        ("/map", "practice"),
        ("/policy", "pi"),
        ("/driver", "sloppy"),
        ("/traffic", "sumo"),
        ("/traffic_leader", "v2"),
        ("/path", "A B"),
        ("/advised", "1"),
        ("/advised_body", "full"),
        ("/start", "bunched"),
        ("/contact", "end"),
        ("/other_model", "krauss"),
        ("/flash_patch", "pedal"),
        ("/secondary_task/kind", "occlusion"),
        ("/secondary_task/signal", "remote-led"),
        ("/secondary_task/display", "window"),
        ("/automation/system", "policy"),
        ("/ego_colour", "blue"),
        ("/traffic_colour", "blue"),
    ];
    let was = scenario.pointer(place).unwrap();
    let fits = |value: &Value| {
        let mut changed = scenario.clone();
        *changed.pointer_mut(place).unwrap() = value.clone();
        let read = serde_json::from_value::<Scenario>(changed);
        value != was && read.is_ok_and(|read| Scenario::from_toml(&read.to_toml(), "other").is_ok())
    };
    if let Some((_, word)) = words.iter().find(|(of, _)| *of == place) {
        return (*word).into();
    }
    if let Value::Bool(is) = was {
        return (!is).into();
    }
    if place == "/step_s" {
        // The hold must be a whole number of steps.
        return 0.05.into();
    }
    if place == "/idm/v0" {
        // No vehicle drives faster than the limit, 30 m/s.
        return 29.0.into();
    }
    let candidates: Vec<Value> = match was {
        Value::Number(n) if n.is_u64() => vec![(n.as_u64().unwrap() + 1).into()],
        Value::Number(n) => [1.0, -1.0, 0.1, -0.1, 10.0].map(|by| (n.as_f64().unwrap() + by).into()).into(),
        _ => ["kmh", "km/h", "off", "bonnet", "colour-blind-safe", "colour_blind_safe", "low"].map(Value::from).into(),
    };
    candidates.into_iter().find(fits).unwrap_or_else(|| panic!("{place}: another value than {was}"))
}

#[test]
fn a_change_of_any_setting_that_moves_a_vehicle_is_found() {
    let text = fs::read_to_string(whole().join("scenario.toml")).unwrap();
    let before = serde_json::to_value(Scenario::from_toml(&text, "scenario.toml").unwrap()).unwrap();
    let _sumo = SUMO.lock();
    let mut unfound = BTreeSet::new();
    for place in leaves(&before, "") {
        let mut changed = before.clone();
        *changed.pointer_mut(&place).unwrap() = other_setting(&before, &place);
        let other = serde_json::from_value::<Scenario>(changed).unwrap_or_else(|e| panic!("{place}: {e}"));
        let (_folder, drive) =
            tampered(whole(), |drive| fs::write(drive.join("scenario.toml"), other.to_toml()).unwrap());
        assert!(!record::changes(&drive).unwrap().is_empty(), "{place}: without new checksums");
        reseal(&drive);
        if !is_found(&drive) {
            unfound.insert(place.clone());
        }
        // Without its line a setting would have the default.
        let key = place.rsplit('/').next().unwrap();
        let lines: String =
            text.lines().filter(|line| !line.starts_with(&format!("{key} ="))).map(|l| format!("{l}\n")).collect();
        if lines != text {
            let (_folder, drive) = tampered(whole(), |drive| {
                fs::write(drive.join("scenario.toml"), &lines).unwrap();
                reseal(drive);
            });
            assert!(record::changes(&drive).map_or(true, |found| !found.is_empty()), "{place} deleted");
        }
    }
    // Settings of picture and sound, and settings without effect in this drive: contact, waiting for a wave, a second model, lane help for
    // keys, a path, a policy with a target speed, SUMO on another machine, the secondary task, the automation.
    let stated = [
        "/advice_tone",
        "/spoken_guidance",
        "/flash_patch",
        "/lane_help",
        "/rev_lamps",
        "/sound/engine_db",
        "/sound/horn_db",
        "/sound/master_db",
        "/sound/others_db",
        "/sound/road_db",
        "/sound/tone_db",
        "/sound/wind_db",
        "/secondary_task/signal",
        "/secondary_task/n",
        "/secondary_task/spoken_digits",
        "/secondary_task/spoken_response",
        "/secondary_task/digit_interval_s",
        "/secondary_task/block_pause_s",
        "/secondary_task/columns",
        "/secondary_task/size_ratio",
        "/secondary_task/display",
        "/secondary_task/open_s",
        "/secondary_task/closed_s",
        "/secondary_task/self_paced",
        "/automation/starts_on",
        "/automation/set_speed_mps",
        "/automation/time_gap_s",
        "/automation/override_deg",
        "/automation/hands_on_nm",
        "/automation/override_nm",
        "/automation/minimal_risk_mps2",
        "/automation/spoken_requests",
        "/contact",
        "/other_model_share",
        "/path_start_m",
        "/start_speed_mps",
        "/policy_speed_mps",
        "/wave_wait_s",
    ];
    let stated: BTreeSet<String> = stated.into_iter().chain(SEEN).map(str::to_owned).collect();
    assert_eq!(unfound, stated);
}

#[test]
fn every_missing_or_empty_file_is_found() {
    for name in files(whole(), "").into_iter().filter(|name| name != "lock") {
        let gone = |drive: &Path| fs::remove_file(drive.join(&name)).unwrap();
        let empty = |drive: &Path| fs::write(drive.join(&name), "").unwrap();
        let no_rows = |drive: &Path| {
            if name.ends_with(".parquet") {
                write(&drive.join(&name), &rows(&drive.join(&name)).slice(0, 0));
            }
        };
        for (how, change) in [("gone", &gone as &dyn Fn(&Path)), ("empty", &empty), ("no rows", &no_rows)] {
            if how == "no rows" && (!name.ends_with(".parquet") || name == "frames.parquet") {
                continue;
            }
            let (_folder, drive) = tampered(whole(), change);
            assert!(
                record::changes(&drive).map_or(true, |found| !found.is_empty()),
                "{name} {how}: without new checksums"
            );
            if name != "manifest.json" && name != "checksums.json" {
                reseal(&drive);
            }
            assert!(is_found(&drive), "{name} {how}");
        }
    }
    // A file that the recording does not list is found as well.
    let (_folder, drive) = tampered(whole(), |drive| fs::write(drive.join("notes.txt"), "mine").unwrap());
    let found = record::changes(&drive).unwrap();
    assert_eq!(found[0].to_string(), "notes.txt: checksums.json does not list it");
    assert!(is_found(&drive));
}

#[test]
fn a_missing_seal_is_an_alteration() {
    let found = |tamper: &dyn Fn(&Path)| {
        let (_folder, drive) = tampered(whole(), tamper);
        assert!(is_found(&drive));
        record::changes(&drive).unwrap().iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
    };
    let remove = |key: &'static str| {
        move |drive: &Path| {
            edit_json(&drive.join("manifest.json"), |keys| drop(keys.as_object_mut().unwrap().shift_remove(key)))
        }
    };
    assert_eq!(found(&remove("sha256")), "manifest.json: sha256 is missing");
    let message = found(&remove("checksums"));
    assert!(message.contains("manifest.json: checksums is missing"), "{message}");
    let within = |change: fn(&mut Value)| {
        move |drive: &Path| {
            edit_json(&drive.join("checksums.json"), change);
            let sum = sha256(&fs::read(drive.join("checksums.json")).unwrap());
            edit_json(&drive.join("manifest.json"), |manifest| {
                manifest["checksums"] = sum.into();
                manifest.as_object_mut().unwrap().shift_remove("sha256");
                let own = sha256(format!("{manifest:#}\n").as_bytes());
                manifest["sha256"] = own.into();
            });
        }
    };
    let column = |sums: &mut Value| drop(sums["tables"]["ego"]["columns"].as_object_mut().unwrap().remove("speed_mps"));
    assert_eq!(found(&within(column)), "ego.parquet: checksums.json has no SHA-256 of column speed_mps");
    assert_eq!(
        found(&within(|sums| sums["tables"]["ego"]["rows"] = 299.into())),
        "ego.parquet: has 300 rows; 299 were written"
    );
    let table = |sums: &mut Value| drop(sums["tables"].as_object_mut().unwrap().remove("cars"));
    let message = found(&within(table));
    assert!(message.contains("cars.parquet: checksums.json has no SHA-256 of it"), "{message}");
    let file = |sums: &mut Value| drop(sums["files"].as_object_mut().unwrap().remove("summary.json"));
    assert!(found(&within(file)).contains("summary.json: checksums.json has no SHA-256 of it"));
    let more = |sums: &mut Value| sums["tables"]["signals"] = sums["tables"]["ego"].clone();
    assert_eq!(found(&within(more)), "checksums.json: lists signals.parquet, which is not a table of this drive");
    let more = |sums: &mut Value| sums["tables"]["ego"]["columns"]["more"] = "0".into();
    assert_eq!(
        found(&within(more)),
        "ego.parquet: checksums.json has a SHA-256 of column more, which no such table has"
    );
    // The same table values, written as other bytes.
    let anew = |drive: &Path| write(&drive.join("ego.parquet"), &rows(&drive.join("ego.parquet")));
    assert_eq!(found(&anew), "ego.parquet: was rewritten; all values are unchanged");
}

#[test]
fn a_recording_without_ticks_is_reported_as_different() {
    let (_folder, drive) = tampered(whole(), |drive| {
        for table in ["ego", "cars", "advice", "events", "advised"] {
            let path = drive.join(format!("{table}.parquet"));
            write(&path, &rows(&path).slice(0, 0));
        }
        reseal(drive);
    });
    let (code, text) = printed(&mut codrive(&["replay", drive.to_str().unwrap()]));
    assert!(
        code == 1 && text.contains("nothing was compared") && !text.contains("the same to the bit"),
        "{code}: {text}"
    );
}

#[test]
fn a_false_simulated_driver_is_found_by_the_controls() {
    let (_folder, drive) = tampered(whole(), |drive| {
        edit_json(&drive.join("manifest.json"), |keys| keys["driver"] = "simulated: sloppy".into());
        let path = drive.join("scenario.toml");
        let text = fs::read_to_string(&path).unwrap().replace("driver = \"follow\"", "driver = \"sloppy\"");
        fs::write(&path, text).unwrap();
        // The recorded controls are those of the driver `follow`; driven again with `sloppy` they differ.
        reseal(drive);
    });
    let facts: Vec<String> = replayed(&drive).unwrap().facts.iter().map(ToString::to_string).collect();
    assert!(
        facts.iter().any(|fact| fact.contains("driver is \"simulated: sloppy\", driven again with other controls")),
        "{facts:?}"
    );
}
