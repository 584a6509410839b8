//! Security of the gate in front of SUMO: input that passes it makes SUMO write no file and connect nowhere. In: networks, demands and
//! additional files with hostile parts drawn from SUMO's whole vocabulary. Out: the system calls, as strace reports them.
//!
//! One child process starts SUMO on many inputs in a row under one strace. `scripts/fuzz` sets `CODRIVE_GATE_INPUTS`; `CODRIVE_GATE_SEED`
//! changes the inputs.

use super::alone;
use codrive::{
    idm::IdmParams,
    map::network::Network,
    rng::{self, Stream},
    traffic::{
        Demand, DemandSetup, Traffic, TrafficDrivers,
        sumo::{self, SumoTraffic},
    },
};
use std::{
    collections::BTreeSet,
    env, fs,
    path::{Path, PathBuf},
    process::{Command, Output},
    sync::Arc,
};

/// Variable set in the child: the folder of the inputs.
const CHILD: &str = "CODRIVE_GATE_CHILD";
/// Number of inputs of an ordinary run.
const INPUTS: usize = 200;
/// Steps of SUMO on an input, 2 s: devices write when a vehicle departs.
const STEPS: usize = 20;
/// Time until which vehicles are counted, s.
const HORIZON_S: f64 = 3600.0;
const NET: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/networks/grid-signals.net.xml");
const DEMAND: &str = "<routes>\n<vType id=\"t\" accel=\"2\"/>\n<vehicle id=\"v\" type=\"t\" depart=\"0\"><route edges=\"A0A1 A1A2\"/></vehicle>\n\
                      <trip id=\"w\" depart=\"0\" from=\"B0B1\" to=\"B1B2\"/>\n<flow id=\"f\" begin=\"0\" end=\"9\" period=\"3\" from=\"A1A0\" to=\"A0B0\"/>\n</routes>\n";
const ADDITIONAL: &str = "<additional>\n<busStop id=\"s\" lane=\"A0A1_0\" startPos=\"10\" endPos=\"30\"/>\n\
                          <rerouter id=\"r\" edges=\"B0B1\"><interval begin=\"0\" end=\"9\"><closingReroute id=\"B1B2\" disallow=\"bus\"/></interval></rerouter>\n\
                          <calibrator id=\"c\" edge=\"A1A0\" pos=\"1\"><flow begin=\"0\" end=\"9\" speed=\"8\"/></calibrator>\n\
                          <variableSpeedSign id=\"z\" lanes=\"A0A1_1\"><step time=\"0\" speed=\"9\"/></variableSpeedSign>\n</additional>\n";

/// Parts that write to the file VICTIM if SUMO reads them unchanged: in the network, in the type `t`, in the actuated signal.
const IN_NETWORK: [&str; 3] = [
    "<edgeData id=\"x\" file=\"VICTIM\" freq=\"1\"/>",
    "<laneData id=\"x\" file=\"VICTIM\" freq=\"1\"/>",
    "<inductionLoop id=\"x\" lane=\"A0A1_0\" pos=\"5\" freq=\"1\" file=\"VICTIM\"/>",
];
const IN_TYPE: [&str; 2] = [
    "<param key=\"has.ssm.device\" value=\"true\"/><param key=\"device.ssm.file\" value=\"VICTIM\"/>",
    "<param key=\"has.toc.device\" value=\"true\"/><param key=\"device.toc.file\" value=\"VICTIM\"/>\
     <param key=\"device.toc.automatedType\" value=\"t\"/><param key=\"device.toc.manualType\" value=\"t\"/>",
];
const IN_SIGNAL: &str = "<param key=\"file\" value=\"VICTIM\"/><param key=\"freq\" value=\"1\"/>";

fn number(name: &str, otherwise: usize) -> usize {
    env::var(name)
        .map_or(otherwise, |text| text.parse().unwrap_or_else(|_| panic!("{name} is {text}; allowed: a number")))
}

/// Vocabulary for hostile parts: all elements and attributes of SUMO's schemas, and all options, as keys of parameters.
struct Words {
    elements: Vec<String>,
    attributes: Vec<String>,
    keys: Vec<String>,
}

fn words() -> Words {
    let folder = sumo::home().unwrap().join("data/xsd");
    let names = |file: &str, of: &str| -> BTreeSet<String> {
        let text = fs::read_to_string(folder.join(file)).unwrap();
        let start = format!("<xsd:{of} name=\"");
        let found = text.split(&start).skip(1).filter_map(|rest| rest.split('"').next());
        found.map(str::to_owned).collect()
    };
    let files = [
        "net_file.xsd",
        "additional_file.xsd",
        "types/route.xsd",
        "types/base.xsd",
        "types/taz.xsd",
        "types/meandata.xsd",
    ];
    let all = |of: &str| files.iter().flat_map(|file| names(file, of)).collect::<BTreeSet<_>>().into_iter().collect();
    let options = names("types/sumoConfigurationType.xsd", "element").into_iter();
    let devices = [
        "ssm",
        "toc",
        "fcd",
        "tripinfo",
        "rerouting",
        "btreceiver",
        "emissions",
        "battery",
        "elechybrid",
        "bluelight",
        "vehroute",
    ];
    let keys =
        options.chain(devices.map(|name| format!("has.{name}.device"))).chain(["file".into(), "freq".into()]).collect();
    Words { elements: all("element"), attributes: all("attribute"), keys }
}

fn one<'a>(stream: &mut Stream, list: &'a [String]) -> &'a str {
    &list[stream.index(list.len())]
}

/// Returns a text with some hostile parts in it; they name `victim`.
fn hostile(stream: &mut Stream, text: &str, words: &Words, victim: &str) -> String {
    let mut text = text.to_owned();
    for _ in 0..=stream.index(3) {
        let value = [victim, victim, "true", "1", "http://127.0.0.1:9/x"][stream.index(5)];
        let param = |stream: &mut Stream| format!("<param key=\"{}\" value=\"{value}\"/>", one(stream, &words.keys));
        match stream.index(8) {
            0 => {
                let (element, attribute) = (one(stream, &words.elements), one(stream, &words.attributes));
                let part = format!("<{element} id=\"x\" {attribute}=\"{value}\" file=\"{victim}\" href=\"{victim}\"/>");
                behind_tag(stream, &mut text, &part);
            }
            1..4 => {
                let name = one(stream, &words.attributes);
                attribute(stream, &mut text, name, value);
            }
            4..7 => {
                let part = param(stream);
                within_tag(stream, &mut text, &part);
            }
            _ => {
                let parts = [&IN_NETWORK[..], &IN_TYPE[..], &[IN_SIGNAL]].concat();
                let part = parts[stream.index(parts.len())].replace("VICTIM", victim);
                behind_tag(stream, &mut text, &part);
            }
        }
    }
    text
}

/// Returns the ends of the tags of elements, before a `/` if there is one.
fn tag_ends(text: &str) -> Vec<usize> {
    let ends = text.match_indices('>').map(|(at, _)| if text[..at].ends_with('/') { at - 1 } else { at });
    let is_start =
        |at: &usize| text[..*at].rfind('<').is_some_and(|from| text.as_bytes()[from + 1].is_ascii_alphabetic());
    ends.filter(is_start).collect()
}

fn behind_tag(stream: &mut Stream, text: &mut String, part: &str) {
    let ends = tag_ends(text);
    let at = ends[stream.index(ends.len())];
    let behind = at + text[at..].find('>').unwrap() + 1;
    text.insert_str(behind, part);
}

fn attribute(stream: &mut Stream, text: &mut String, name: &str, value: &str) {
    let ends = tag_ends(text);
    let at = ends[stream.index(ends.len())];
    text.insert_str(at, &format!(" {name}=\"{value}\""));
}

/// Puts a part into an empty element, or behind the start tag of an element with content.
fn within_tag(stream: &mut Stream, text: &mut String, part: &str) {
    let ends = tag_ends(text);
    let at = ends[stream.index(ends.len())];
    if !text[at..].starts_with('/') {
        return text.insert_str(at + 1, part);
    }
    let from = text[..at].rfind('<').unwrap() + 1;
    let name = text[from..].split([' ', '/', '>', '\n']).next().unwrap().to_owned();
    text.replace_range(at..at + 2, &format!(">{part}</{name}>"));
}

/// Folder in which SUMO runs, with a file that no program may change.
struct GateFixture {
    folder: tempfile::TempDir,
}

impl GateFixture {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        for name in ["inputs", "work", "tmp", "victims"] {
            fs::create_dir(folder.path().join(name)).unwrap();
        }
        Self { folder }
    }

    fn at(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Runs a program under strace. Returns its output and the system calls, one per line.
    fn traced(&self, program: &Path, arguments: &[&str]) -> (Output, String) {
        let log = self.at("trace");
        let output = Command::new("strace")
            .args(["-f", "-qq", "-y", "--seccomp-bpf", "-s", "4096", "-e"])
            .arg("trace=open,openat,openat2,creat,rename,renameat,renameat2,unlink,unlinkat,mkdir,mkdirat,link,linkat,symlink,symlinkat,truncate,connect,bind")
            .arg("-o")
            .args([&log, program])
            .args(arguments)
            .current_dir(self.at("work"))
            .env(CHILD, self.at("inputs"))
            .env("TMPDIR", self.at("tmp"))
            .env("CODRIVE_SUMO_HOME", sumo::home().unwrap())
            .output()
            .expect("strace is installed: scripts/setup");
        (output, fs::read_to_string(log).unwrap())
    }

    /// Returns the calls that change a file that codrive did not name, or that connect elsewhere.
    fn offences(&self, trace: &str) -> Vec<String> {
        // A file is named by its path, or by its name within an open folder.
        let own = ["\"", "<"].map(|quote| format!("{quote}{}/", self.at("tmp").display()));
        let is_offence = |line: &&str| {
            let Some(call) = line.split_once(' ').map(|(_, call)| call.trim_start()) else { return false };
            let changes = ["O_WRONLY", "O_RDWR", "O_CREAT", "O_TRUNC"].iter().any(|flag| call.contains(flag));
            let opens = call.starts_with("open");
            let harmless = own.iter().any(|own| call.contains(own))
                || call.contains("\"/dev/null\"")
                || call.starts_with("+++")
                || call.starts_with("---");
            // A resumed call of a thread was reported in full where it began.
            !harmless && !call.starts_with("<...") && (!opens || changes)
        };
        trace.lines().filter(is_offence).map(str::to_owned).collect()
    }

    fn victims(&self) -> Vec<PathBuf> {
        let files = ["victims", "work"].map(|name| fs::read_dir(self.at(name)).unwrap());
        files.into_iter().flatten().map(|entry| entry.unwrap().path()).collect()
    }
}

/// Starts SUMO on each input, as a drive does. Returns the number of inputs that passed the gate, and the number on which SUMO ran.
fn drive_all(folder: &Path) -> (usize, usize) {
    let (mut passed, mut driven) = (0, 0);
    let mut inputs: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    inputs.sort();
    for input in inputs {
        let net_file = input.join("net.xml");
        let Ok(network) = Network::load(net_file.to_str().unwrap()) else { continue };
        let copies = tempfile::tempdir().unwrap();
        let demand = Demand {
            files: vec![input.join("demand.rou.xml")],
            additional_files: vec![input.join("stops.add.xml")],
            ..Demand::default()
        };
        if demand.canonical(&network, HORIZON_S, copies.path()).is_err() {
            continue;
        }
        passed += 1;
        let setup = DemandSetup {
            network: Arc::new(network),
            net_file,
            demand,
            egos: Vec::new(),
            drivers: TrafficDrivers::Alike(IdmParams::default()),
            step_s: 0.1,
            until_s: HORIZON_S,
            first_number: 0,
            seed: 1,
        };
        // This process is itself the trial.
        let Ok(mut traffic) = SumoTraffic::start_untried(&setup) else { continue };
        driven += usize::from((0..STEPS).all(|_| traffic.step(&[]).is_ok()));
    }
    (passed, driven)
}

#[test]
fn what_passes_the_gate_makes_sumo_write_nothing_and_connect_nowhere() {
    let _alone = alone();
    if let Ok(folder) = env::var(CHILD) {
        let (passed, driven) = drive_all(Path::new(&folder));
        println!("\npassed {passed} driven {driven}");
        return;
    }
    let (words, place) = (words(), GateFixture::new());
    let net = fs::read_to_string(NET).unwrap();
    let mut stream = rng::stream(number("CODRIVE_GATE_SEED", 1) as u64, "gate");
    let inputs = number("CODRIVE_GATE_INPUTS", INPUTS);
    for k in 0..inputs {
        let folder = place.at(&format!("inputs/{k:05}"));
        fs::create_dir(&folder).unwrap();
        let victim = place.at(&format!("victims/{k}.xml"));
        let victim = victim.to_str().unwrap();
        // A new network costs a process; a new demand does not.
        let which = [0, 1, 1, 1, 2, 2, 2, 2][k % 8];
        let mut files =
            [("net.xml", net.clone()), ("stops.add.xml", ADDITIONAL.into()), ("demand.rou.xml", DEMAND.into())];
        files[which].1 = hostile(&mut stream, &files[which].1, &words, victim);
        for (name, text) in files {
            fs::write(folder.join(name), text).unwrap();
        }
    }
    let name = "gate::what_passes_the_gate_makes_sumo_write_nothing_and_connect_nowhere";
    let (output, trace) =
        place.traced(&env::current_exe().unwrap(), &["--exact", name, "--nocapture", "--test-threads", "1"]);
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{text}\n{}", String::from_utf8_lossy(&output.stderr));
    let count = |word: &str| -> usize {
        let rest = text.split(word).nth(1).unwrap_or_else(|| panic!("{text}"));
        rest.split_whitespace().next().unwrap().parse().unwrap()
    };
    let (passed, driven) = (count("\npassed "), count(" driven "));
    println!("{inputs} inputs, {passed} passed the gate, {driven} were driven");
    // A gate that refuses everything would prove nothing.
    assert!(passed > inputs / 5 && driven > passed / 2, "{passed} of {inputs} passed, {driven} driven");
    assert!(passed < inputs, "hostile parts are among the inputs");
    let offences = place.offences(&trace);
    assert!(
        offences.is_empty(),
        "{} calls:\n{}",
        offences.len(),
        offences.iter().take(20).cloned().collect::<Vec<_>>().join("\n")
    );
    assert!(place.victims().is_empty(), "{:?}", place.victims());
}

#[test]
fn hostile_parts_write_files_if_sumo_reads_them_without_the_gate() {
    let place = GateFixture::new();
    let net = fs::read_to_string(NET).unwrap();
    let victim = place.at("victims/x.xml");
    let raw = |part: &str| part.replace("VICTIM", victim.to_str().unwrap());
    let in_network = IN_NETWORK.map(|part| (net.replace("</net>", &format!("{}</net>", raw(part))), DEMAND.to_owned()));
    let in_type = IN_TYPE
        .map(|part| (net.clone(), DEMAND.replace("accel=\"2\"/>", &format!("accel=\"2\">{}</vType>", raw(part)))));
    let signal = net.find("<phase").unwrap();
    let in_signal = [(format!("{}{}{}", &net[..signal], raw(IN_SIGNAL), &net[signal..]), DEMAND.to_owned())];
    for (net, demand) in in_network.into_iter().chain(in_type).chain(in_signal) {
        fs::write(place.at("net.xml"), &net).unwrap();
        fs::write(place.at("demand.rou.xml"), &demand).unwrap();
        let files = [place.at("net.xml"), place.at("demand.rou.xml")];
        let arguments =
            ["-n", files[0].to_str().unwrap(), "-r", files[1].to_str().unwrap(), "-e", "5", "--no-step-log"];
        let (output, trace) = place.traced(&sumo::home().unwrap().join("bin/sumo"), &arguments);
        let offences = place.offences(&trace);
        let is_seen = offences.iter().any(|line| line.contains(victim.to_str().unwrap()));
        assert!(is_seen && victim.exists(), "{demand}\n{offences:?}\n{}", String::from_utf8_lossy(&output.stderr));
        fs::remove_file(&victim).unwrap();
        // The gate refuses each of them by name.
        let network = Network::load(files[0].to_str().unwrap());
        let copies = tempfile::tempdir().unwrap();
        let demand = Demand { files: vec![files[1].clone()], ..Demand::default() };
        let refused = match network {
            Err(error) => error.to_string(),
            Ok(network) => demand.canonical(&network, HORIZON_S, copies.path()).unwrap_err().to_string(),
        };
        assert!(refused.contains("remedy: remove it from the file"), "{refused}");
    }
}

/// Returns the output of SUMO's own program on a network and a demand: all vehicles of each step, with all digits.
fn vehicles_by_sumo(net: &Path, demand: &Path, folder: &Path) -> String {
    let (home, out) = (sumo::home().unwrap(), folder.join("fcd.xml"));
    let output = Command::new(home.join("bin/sumo"))
        .env("SUMO_HOME", &home)
        .args([
            "--step-length",
            "0.1",
            "--precision",
            "16",
            "--seed",
            "5",
            "--no-step-log",
            "--no-warnings",
            "-e",
            "60",
            "-n",
        ])
        .args([net, Path::new("-r"), demand, Path::new("--fcd-output"), &out])
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = fs::read_to_string(out).unwrap();
    // The head of the output names the files and the time.
    text[text.find("<timestep").unwrap()..].to_owned()
}

#[test]
fn sumo_drives_on_a_copy_as_on_the_original_to_the_last_digit() {
    for name in ["grid-signals", "roundabout", "ramps", "town-left"] {
        let folder = tempfile::tempdir().unwrap();
        let place = |name: &str| folder.path().join(name);
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/data/networks/{name}.net.xml"));
        let network = Network::load(file.to_str().unwrap()).unwrap();
        let edge = |lane| network.edge_of(lane);
        let streets = network.connections().iter().filter(|way| {
            let is_street = |lane| edge(lane).kind.is_street() && network.lane(lane).admits_cars();
            is_street(way.from) && is_street(way.to)
        });
        let trips = streets.take(60).enumerate().map(|(k, way)| {
            let (from, to) = (&edge(way.from).id, &edge(way.to).id);
            format!("<trip id='{k}' depart='{}' from='{from}' to='{to}' departLane=\"best\" weather='fine'/> <!-- {k} -->\n", k / 2)
        });
        fs::write(
            place("demand.rou.xml"),
            format!("<routes><vType id='DEFAULT_VEHTYPE' sigma='0.5'/>\n{}</routes>", trips.collect::<String>()),
        )
        .unwrap();
        let demand = Demand { files: vec![place("demand.rou.xml")], ..Demand::default() };
        let copy = &demand.canonical(&network, HORIZON_S, folder.path()).unwrap().demand.files[0];
        fs::write(place("copy.net.xml"), network.sumo_text().as_str()).unwrap();
        let original = vehicles_by_sumo(&file, &place("demand.rou.xml"), folder.path());
        assert!(original.matches("<vehicle ").count() > 1000, "{name}: {}", original.matches("<vehicle ").count());
        assert!(vehicles_by_sumo(&place("copy.net.xml"), copy, folder.path()) == original, "{name}");
    }
}
