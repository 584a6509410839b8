//! All readers of files that people or other programs write. In: bytes. Out: true if they were accepted; then the result is used as the
//! program would first use it. Good inputs are the shipped files, the tests' files, a recording made by the program, and `corpus/`.

use super::{
    good_texts::{DRIVERS, OPEN_DRIVE_OBJECTS, PERSONS, SURROUNDINGS, TRAJECTORIES},
    mutate,
};
use codrive::{
    driver::{DriverParams, DriversFile},
    input::{WheelProfile, profiles},
    map::{
        RoadMap, circuit,
        network::{LanePosition, Network as RoadNetwork},
        surroundings,
    },
    metrics::traffic_moments::{moments, read_trajectories},
    policy::{Network, Observation, ObservedDriver, OnnxPolicy, Policy, RoadAhead},
    record::{self, Manifest, Table},
    rng::Stream,
    scenario::Scenario,
    study::{
        DataSet, ItemOutcome, ParticipantCode, Questionnaire, Session, Study,
        session::{ParticipantKind, SessionLog, TimedAnswer},
    },
    sumo_xml::{demand, stream},
};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Function that changes a good input, with another one at hand.
type Change = fn(&mut Stream, Vec<u8>, &[u8]) -> Vec<u8>;

/// Function that reads bytes; true if they were accepted.
type Read = Box<dyn Fn(&[u8]) -> bool>;

/// One reader of files, with the inputs to test it with.
pub struct Reader {
    /// Name of the reader, and of its folder in `corpus/`.
    pub name: &'static str,
    /// Valid inputs, which are changed.
    pub good: Vec<Vec<u8>>,
    /// Function that changes a valid input.
    pub change: Change,
    /// Number of inputs in a run in which all readers together take half a minute.
    pub share: usize,
    /// Function that reads bytes; true if they were accepted.
    pub read: Read,
}

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn shipped(files: &[impl AsRef<str>]) -> Vec<Vec<u8>> {
    let read = |file: &str| fs::read(root().join(file)).unwrap_or_else(|e| panic!("{file}: {e}"));
    files.iter().map(|file| read(file.as_ref())).collect()
}

/// Recordings that the program makes: one that ended, and one whose journal still exists.
struct Recordings {
    ended: PathBuf,
    cut: PathBuf,
}

fn recordings(folder: &Path) -> Recordings {
    let made = Recordings { ended: folder.join("ended"), cut: folder.join("cut") };
    // The program is killed before it writes the tables, so that everything is in the journal and always the same.
    for (out, kill_at) in [(&made.ended, ""), (&made.cut, "finish.begin")] {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_codrive"));
        command.args(["run", "--traffic", "native", "--vehicles", "5", "--duration", "2", "--warm-up", "0", "--out"]);
        command.arg(out).env_remove("CODRIVE_KILL_AT");
        if !kill_at.is_empty() {
            command.env("CODRIVE_KILL_AT", kill_at);
        }
        let status = command.output().unwrap().status;
        assert_eq!(status.success(), kill_at.is_empty(), "{status}");
    }
    made
}

/// Returns the file of a session with a completed drive, answers and notes.
fn live_session(folder: &Path) -> Vec<u8> {
    let study = Study::load(&root().join("assets/studies/congestion.toml")).unwrap();
    let data = DataSet::open(folder, &study).unwrap();
    let mut session =
        Session::open(&data, &study, &ParticipantCode::new("R01").unwrap(), ParticipantKind::Simulated, 0, "now")
            .unwrap();
    for _ in 0..3 {
        session.begin("now").unwrap();
        let answer = TimedAnswer { question: "nausea".into(), answer: 2.into(), time_s: 1.5 };
        session.keep(vec![answer]).unwrap();
        session.note("mark", "a note", "now").unwrap();
        session.end(ItemOutcome::Done, "", "now").unwrap();
    }
    session.begin("now").unwrap();
    fs::read(session.folder().join("session.json")).unwrap()
}

/// Copies a folder with its contents to `to`, replacing what is there.
fn copied(from: &Path, to: &Path) {
    let _ = fs::remove_dir_all(to);
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().flatten() {
        if entry.path().is_dir() {
            copied(&entry.path(), &to.join(entry.file_name()));
        } else {
            fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
        }
    }
}

fn text(bytes: &[u8]) -> Option<&str> {
    std::str::from_utf8(bytes).ok()
}

/// Uses a map as the start of the program does.
fn used(map: &RoadMap) {
    let (centre, radius_m) = map.bounds();
    assert!(centre.is_finite() && radius_m.is_finite(), "bounds {centre} {radius_m}");
    let length_m = map.route.length_m();
    for i in 0..50 {
        let s_m = length_m * f64::from(i) / 50.0;
        let (point, yaw) = (map.route.point_at(s_m), map.route.yaw_at(s_m));
        assert!(point.is_finite() && yaw.is_finite(), "{point} {yaw} at {s_m} of {length_m}");
        assert!(map.route.project(point, Some(s_m)).s_m.is_finite());
    }
}

/// Uses a network: finds places on its lanes, counts its parts, and writes it.
fn used_network(network: &RoadNetwork) {
    let every = network.lanes().len().div_ceil(40).max(1);
    for lane in network.lane_ids().step_by(every) {
        for (s_m, offset_m) in [(0.0, 0.0), (0.4 * network.lane(lane).length_m, 1.0)] {
            let pose = network.pose(LanePosition { lane, s_m, offset_m });
            assert!(pose.position.is_finite() && pose.yaw_rad.is_finite() && pose.grade.is_finite(), "{pose:?}");
            for hint in [None, Some(lane)] {
                let found = network.locate(pose.position, hint);
                assert!(found.is_none_or(|at| at.s_m.is_finite() && at.offset_m.is_finite()), "{found:?}");
            }
        }
    }
    assert!(network.census().lanes <= network.lanes().len());
    // SUMO must read the same network, and its copy must pass the checks unchanged.
    let copy = network.sumo_text().as_str();
    let again = RoadNetwork::read(Path::new("copy.net.xml"), copy).expect("the copy of a network is one");
    assert!(again == *network && again.sumo_text().as_str() == copy, "the copy for SUMO is another network");
}

/// Returns a reader of a file that holds the bytes.
pub fn with_file(file: PathBuf, read: impl Fn(&Path) -> bool + 'static) -> Read {
    Box::new(move |bytes| {
        fs::write(&file, bytes).unwrap();
        read(&file)
    })
}

const MOMENT: Observation = Observation {
    speed_mps: 4.0,
    leader_speed_mps: 4.0,
    gap_m: 6.0,
    circumference_m: 250.0,
    vehicles: 22,
    hold_s: 1.0,
    mean_speed_mps: 4.0,
    advised_mps: None,
    observed: ObservedDriver { deviation_mps: 0.2, reaction_s: 0.9, time_gap_factor: 1.1 },
    driver: None,
    latents: [0.0; 4],
    corrected_mps: None,
    ring: None,
    road: RoadAhead {
        speed_limit_mps: 8.0,
        bend_per_m: 0.0,
        follower: None,
        left: None,
        right: None,
        signal: None,
        yield_line_m: None,
        stop_line_m: None,
        lane_end_m: None,
        path_left_m: None,
    },
};

/// Returns all readers. Files that a reader needs on the disk go into `folder`.
pub fn all(folder: &Path) -> Vec<Reader> {
    let mut readers = settings(folder);
    readers.extend([networks(folder), recorded(folder), vec![super::scenes::reader(folder)]].into_iter().flatten());
    for reader in &mut readers {
        let kept = root().join("tests/fuzz/corpus").join(reader.name);
        let mut files: Vec<PathBuf> = fs::read_dir(kept).into_iter().flatten().flatten().map(|e| e.path()).collect();
        files.sort();
        reader.good.extend(files.iter().map(|file| fs::read(file).unwrap()));
        assert!(!reader.good.is_empty(), "{} has no good input", reader.name);
    }
    readers
}

fn settings(folder: &Path) -> Vec<Reader> {
    let study = root().join("assets/studies/congestion.toml");
    let scenario = Scenario::default().to_toml().into_bytes();
    let wheels = ["g29", "g27", "g920", "g923"].map(|name| format!("assets/wheels/{name}.toml"));
    let forms =
        ["ssq", "raw-tlx", "acceptance", "driving-experience"].map(|name| format!("assets/questionnaires/{name}.json"));
    vec![
        Reader {
            name: "scenario",
            good: [
                vec![scenario],
                shipped(&[
                    "docs/how-to/leader-brakes.toml",
                    "docs/how-to/all-events.toml",
                    "docs/how-to/people-cross.toml",
                    "docs/how-to/road-users.toml",
                ]),
            ]
            .concat(),
            change: mutate::text,
            share: 800,
            read: Box::new(|bytes| text(bytes).is_some_and(|text| Scenario::from_toml(text, "fuzz").is_ok())),
        },
        Reader {
            name: "study",
            good: shipped(&["assets/studies/congestion.toml"]),
            change: mutate::text,
            share: 450,
            read: Box::new(move |bytes| text(bytes).is_some_and(|text| Study::parse(text.to_owned(), &study).is_ok())),
        },
        Reader {
            name: "questionnaire",
            good: shipped(&forms),
            change: mutate::text,
            share: 800,
            read: Box::new(|bytes| {
                let read = text(bytes).and_then(|text| Questionnaire::parse(text, "fuzz").ok());
                read.is_some_and(|form| {
                    form.scores(&Default::default());
                    true
                })
            }),
        },
        Reader {
            name: "wheel",
            good: shipped(&wheels),
            change: mutate::text,
            share: 450,
            read: with_file(folder.join("wheel.toml"), |file| {
                profiles::load(file).is_ok_and(|profile: WheelProfile| {
                    for raw in [i32::MIN, -1, 0, 1, 32_768, 65_535, i32::MAX] {
                        assert!(profile.steering.wheel_rad(raw).is_finite(), "{raw}");
                    }
                    true
                })
            }),
        },
        Reader {
            name: "drivers",
            good: vec![DRIVERS.as_bytes().to_vec()],
            change: mutate::text,
            share: 450,
            read: Box::new(|bytes| {
                let read = text(bytes).and_then(|text| DriversFile::parse(text, "fuzz").ok());
                read.is_some_and(|file| {
                    let base = DriverParams::default();
                    for driver in &file.driver {
                        assert_eq!(driver.applied_to(&base, base.idm.t).check(), Ok(()), "{driver:?}");
                    }
                    true
                })
            }),
        },
        Reader {
            name: "trajectories",
            good: vec![TRAJECTORIES.as_bytes().to_vec()],
            change: mutate::text,
            share: 450,
            read: with_file(folder.join("trajectories.csv"), |file| {
                read_trajectories(file, Some(100.0)).is_ok_and(|all| moments(&all).get("mean_speed_mps").is_some())
            }),
        },
        Reader {
            name: "network",
            good: shipped(&["assets/policies/ring-250-speed/policy.toml"]),
            change: mutate::text,
            share: 450,
            read: Box::new(|bytes| {
                let read = text(bytes).and_then(|text| Network::from_toml(text).ok());
                read.is_some_and(|mut network| {
                    network.act(0.0, &MOMENT);
                    true
                })
            }),
        },
    ]
}

fn networks(folder: &Path) -> Vec<Reader> {
    let map_folder = folder.join("map");
    fs::create_dir_all(&map_folder).unwrap();
    fs::copy(root().join("maps/ring-250/net.xml"), map_folder.join("net.xml")).unwrap();
    let own = shipped(&["assets/policies/ring-250-speed/policy.onnx"]).remove(0);
    vec![
        Reader {
            name: "circuit",
            good: shipped(&["maps/practice/circuit.toml"]),
            change: mutate::text,
            share: 400,
            read: with_file(folder.join("circuit.toml"), |file| circuit::make(file).is_ok()),
        },
        Reader {
            name: "net",
            good: shipped(&[
                "tests/data/junctions-inside.net.xml",
                "tests/data/junctions-none.net.xml",
                "maps/ring-250/net.xml",
            ]),
            change: mutate::text,
            share: 500,
            read: with_file(folder.join("fuzz.net.xml"), |file| {
                RoadMap::load(file.to_str().unwrap()).is_ok_and(|map| {
                    used(&map);
                    true
                })
            }),
        },
        Reader {
            name: "demand",
            good: [shipped(&["maps/merge/demand.rou.xml"]), vec![PERSONS.to_vec()]].concat(),
            change: mutate::text,
            share: 2500,
            read: with_file(folder.join("fuzz.rou.xml"), |file| {
                let copy =
                    |file: &Path| stream::copy(file, demand(), Vec::new(), &mut |_| Ok(())).map(|(copy, _)| copy);
                copy(file).is_ok_and(|first| {
                    fs::write(file, &first).unwrap();
                    copy(file).is_ok_and(|second| second == first) || panic!("the copy does not pass as it is")
                })
            }),
        },
        Reader {
            name: "roads",
            good: shipped(
                &["figure-eight", "hill", "one-way", "ramps", "town", "track"]
                    .map(|name| format!("tests/data/networks/{name}.net.xml"))
                    .each_ref()
                    .map(String::as_str),
            ),
            change: mutate::text,
            share: 500,
            read: Box::new(|bytes| {
                let read = text(bytes).map(|text| RoadNetwork::read(Path::new("fuzz.net.xml"), text));
                read.is_some_and(|read| {
                    read.is_ok_and(|network| {
                        used_network(&network);
                        true
                    })
                })
            }),
        },
        Reader {
            name: "surroundings",
            good: vec![SURROUNDINGS.as_bytes().to_vec()],
            change: mutate::text,
            share: 2000,
            read: with_file(folder.join("surroundings.xml"), |file| {
                surroundings::read(file).is_ok_and(|all| {
                    let buildings = all.buildings.iter().map(|of| (of.area_m2(), of.outline.len()));
                    let outlines = buildings.chain(all.areas.iter().map(|of| (of.area_m2(), of.outline.len())));
                    for (area_m2, corners) in outlines {
                        assert!(area_m2.is_finite() && corners >= 3, "{all:?}");
                    }
                    assert!(all.points().all(|point| point.is_finite()), "{all:?}");
                    true
                })
            }),
        },
        Reader {
            name: "open_drive_objects",
            good: vec![OPEN_DRIVE_OBJECTS.as_bytes().to_vec()],
            change: mutate::text,
            share: 2000,
            read: with_file(folder.join("objects.xodr"), |file| {
                surroundings::open_drive::read(file).is_ok_and(|all| {
                    assert!(all.points().all(|point| point.is_finite()), "{all:?}");
                    !all.is_empty()
                })
            }),
        },
        Reader {
            name: "map",
            good: vec![b"title = \"a\"\ndescription = \"b\"\nroute = [\"e0\", \"e1\", \"e2\", \"e3\"]\n".to_vec()],
            change: mutate::text,
            share: 700,
            read: with_file(map_folder.join("map.toml"), move |_| {
                RoadMap::load(map_folder.to_str().unwrap()).is_ok_and(|map| {
                    used(&map);
                    true
                })
            }),
        },
        Reader {
            name: "onnx",
            good: [vec![own], shipped(&["tests/data/torch-legacy.onnx", "tests/data/torch-dynamo.onnx"])].concat(),
            change: mutate::onnx,
            share: 700,
            read: {
                let beside = fs::read_to_string(root().join("tests/data/torch-legacy.onnx.toml")).unwrap();
                Box::new(move |bytes| {
                    let own = OnnxPolicy::from_bytes(bytes, None);
                    let read = own.or_else(|_| OnnxPolicy::from_bytes(bytes, Some(&beside)));
                    read.is_ok_and(|mut policy| {
                        policy.act(0.0, &MOMENT);
                        true
                    })
                })
            },
        },
        Reader {
            name: "description",
            good: shipped(&["tests/data/torch-legacy.onnx.toml"]),
            change: mutate::text,
            share: 2000,
            read: {
                let described = fs::read(root().join("tests/data/torch-legacy.onnx")).unwrap();
                Box::new(move |bytes| {
                    text(bytes).is_some_and(|text| OnnxPolicy::from_bytes(&described, Some(text)).is_ok())
                })
            },
        },
    ]
}

fn recorded(folder: &Path) -> Vec<Reader> {
    let made = recordings(folder);
    let at = |name: &str| folder.join(name);
    let tables: Vec<Vec<u8>> =
        Table::OF_EVERY_DRIVE.iter().map(|table| fs::read(table.parquet(&made.ended)).unwrap()).collect();
    let journals: Vec<PathBuf> = fs::read_dir(made.cut.join("journal")).unwrap().flatten().map(|e| e.path()).collect();
    let mut streams: Vec<(PathBuf, Vec<u8>)> =
        journals.into_iter().map(|p| (p.clone(), fs::read(p).unwrap())).collect();
    streams.sort();
    // The first byte selects the file of the journal; its bytes follow.
    let good = streams.iter().enumerate().map(|(k, (_, bytes))| [&[k as u8], bytes.as_slice()].concat()).collect();
    let names: Vec<_> = streams.iter().map(|(path, _)| path.file_name().unwrap().to_owned()).collect();
    let (cut, again, whole) = (made.cut.clone(), at("again"), at("whole"));
    copied(&made.ended, &whole);
    let manifest = whole.join(record::manifest::FILE);
    let manifest_bytes = fs::read(&manifest).unwrap();
    let session = live_session(&at("data"));
    vec![
        Reader {
            name: "journal",
            good,
            change: mutate::bytes,
            share: 60,
            read: Box::new(move |bytes| {
                let Some((which, bytes)) = bytes.split_first() else { return false };
                copied(&cut, &again);
                fs::write(again.join("journal").join(&names[usize::from(*which) % names.len()]), bytes).unwrap();
                record::recover(&again).is_ok()
            }),
        },
        Reader {
            name: "manifest",
            good: vec![manifest_bytes],
            change: mutate::text,
            share: 2500,
            read: with_file(manifest, move |_| {
                let _ = record::recover(&whole);
                Manifest::load(&whole).is_ok()
            }),
        },
        Reader {
            name: "parquet",
            good: tables,
            change: mutate::bytes,
            share: 800,
            read: with_file(at("table.parquet"), |file| {
                record::TableReader::parquet(file).is_ok_and(|table| {
                    for name in ["tick", "car", "speed_mps", "in_range", "kind", "detail"] {
                        let rows = [table.numbers(name).len(), table.ids(name).len(), table.flags(name).len()];
                        assert!(rows.iter().all(|n| *n <= table.rows()), "{name}: {rows:?} of {}", table.rows());
                        table.wholes(name);
                        table.words(name);
                    }
                    true
                })
            }),
        },
        Reader {
            name: "session",
            good: vec![session],
            change: mutate::text,
            share: 2500,
            read: with_file(at("session.json"), |file| SessionLog::load(file).is_ok()),
        },
    ]
}
