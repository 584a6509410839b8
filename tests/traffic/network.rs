//! SUMO on road networks, compared with SUMO's own program with the same options: the engine must report what that program writes for every
//! vehicle at every step. SUMO's own tools make the networks here.

use super::*;
use codrive::map::network::{LaneId, LanePosition, Network, SignalId, SignalLight};
use codrive::traffic::{
    Demand, DemandSetup, Flow, KindShare, TrafficError, VehicleKind, VehicleState,
    sumo::{self, SumoTraffic},
};
use roxmltree::Document;
use std::{
    collections::{BTreeMap, BTreeSet},
    fs,
    path::{Path, PathBuf},
    process::Command,
};
use tempfile::TempDir;

/// Network in a folder of its own.
pub struct Town {
    pub folder: TempDir,
    pub net: PathBuf,
}

/// Runs one of SUMO's programs.
pub fn run(program: &str, arguments: &[&str]) {
    let home = sumo::home().expect("SUMO is here");
    let done = Command::new(home.join("bin").join(program)).env("SUMO_HOME", &home).args(arguments).output();
    let done = done.expect("SUMO's programs run");
    assert!(done.status.success(), "{program}: {}", String::from_utf8_lossy(&done.stderr));
}

impl Town {
    /// Creates three by three junctions with signals and two lanes each way.
    pub fn grid() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let net = folder.path().join("grid.net.xml");
        let file = net.to_str().expect("plain");
        let of = ["--grid", "--grid.number", "3", "--grid.length", "120", "--grid.attach-length", "120", "-L", "2"];
        run("netgenerate", &[&of[..], &["--tls.guess", "--no-turnarounds", "--output-file", file]].concat());
        Self { folder, net }
    }

    pub fn setup(&self, demand: Demand) -> DemandSetup {
        DemandSetup {
            network: Arc::new(Network::load(self.net.to_str().expect("plain")).expect("it can be read")),
            net_file: self.net.clone(),
            demand,
            egos: Vec::new(),
            first_number: 0,
            drivers: TrafficDrivers::Alike(model(0.0)),
            step_s: STEP_S,
            until_s: 3600.0,
            seed: 7,
        }
    }

    /// Writes a demand file: cars that cross the town in four directions, with a bus, a truck and a motorcycle among them.
    pub fn trips(&self) -> Demand {
        let file = self.folder.path().join("trips.rou.xml");
        let mut text = String::from("<routes>\n");
        for kind in ["bus", "truck", "motorcycle"] {
            text += &format!("<vType id=\"{kind}\" vClass=\"{kind}\"/>\n");
        }
        let ways = [("left0A0", "C2right2"), ("bottom1B0", "B2top1"), ("right1C1", "A1left1"), ("top0A2", "C0bottom2")];
        for k in 0..240 {
            let (from, to) = ways[k % 4];
            let kind = ["DEFAULT_VEHTYPE", "DEFAULT_VEHTYPE", "bus", "DEFAULT_VEHTYPE", "truck", "motorcycle"][k % 6];
            text += &format!(
                "<trip id=\"v{k}\" type=\"{kind}\" depart=\"{}\" from=\"{from}\" to=\"{to}\" departLane=\"best\"/>\n",
                k / 2
            );
        }
        fs::write(&file, text + "</routes>\n").expect("written");
        Demand { files: vec![file], ..Demand::default() }
    }
}

/// State of a vehicle as written by SUMO's program.
#[derive(Debug)]
struct Written {
    place: [f64; 2],
    angle_deg: f64,
    speed_mps: f64,
    lane: String,
    lane_pos_m: f64,
}

/// Writes a file with the engine's version of SUMO's default type: its vehicles change lanes only while they drive.
fn default_type(town: &Town) -> PathBuf {
    let file = town.folder.path().join("default.rou.xml");
    let text =
        "<routes><vType id=\"DEFAULT_VEHTYPE\" lcMaxSpeedLatStanding=\"0\" lcMaxSpeedLatFactor=\"0.2\"/></routes>";
    fs::write(&file, text).expect("written");
    file
}

/// Returns all vehicles of every step from SUMO's own program.
fn written(town: &Town, setup: &DemandSetup, steps: usize) -> Vec<BTreeMap<String, Written>> {
    let out = town.folder.path().join("fcd.xml");
    let routes = format!("{},{}", default_type(town).display(), setup.demand.files[0].display());
    let end = (steps as f64 * STEP_S).to_string();
    let (net, out_file) = (town.net.to_str().expect("plain"), out.to_str().expect("plain"));
    run(
        "sumo",
        &[
            "--net-file",
            net,
            "--route-files",
            &routes,
            "--step-length",
            "0.100",
            "--precision",
            "16",
            "--time-to-teleport",
            "-1",
            "--collision.action",
            "none",
            "--no-step-log",
            "--no-warnings",
            "--seed",
            "7",
            "--lanechange.duration",
            "5",
            "--fcd-output",
            out_file,
            "--end",
            &end,
        ],
    );
    let text = fs::read_to_string(&out).expect("read");
    let document = Document::parse(&text).expect("XML");
    let steps = document.root_element().children().filter(|node| node.has_tag_name("timestep"));
    steps
        .map(|step| {
            let vehicles = step.children().filter(|node| node.has_tag_name("vehicle"));
            vehicles
                .map(|node| {
                    let text = |name| node.attribute(name).expect("FCD has it").to_owned();
                    let number = |name| text(name).parse::<f64>().expect("a number");
                    let written = Written {
                        place: [number("x"), number("y")],
                        angle_deg: number("angle"),
                        speed_mps: number("speed"),
                        lane: text("lane"),
                        lane_pos_m: number("pos"),
                    };
                    (text("id"), written)
                })
                .collect()
        })
        .collect()
}

#[test]
fn every_vehicle_of_every_step_is_as_the_program_of_sumo_writes_it() {
    const STEPS: usize = 2500;
    let _alone = alone();
    let town = Town::grid();
    let setup = town.setup(town.trips());
    let wanted = written(&town, &setup, STEPS);
    assert_eq!(wanted.len(), STEPS);
    let mut traffic = SumoTraffic::start_with_demand(&setup).expect("it starts");
    let mut names = BTreeMap::new();
    let (mut compared, mut changes_of_lane, mut arrived, mut most) = (0, 0, 0, 0);
    let network = &setup.network;
    let mut lanes_before: BTreeMap<u32, LaneId> = BTreeMap::new();
    for (step, wanted) in wanted.iter().enumerate() {
        traffic.step(&[]).expect("a step");
        for new in &traffic.changes().departed {
            assert!(names.insert(new.id.0, new.clone()).is_none(), "no number is given twice");
        }
        arrived += traffic.changes().arrived.len();
        assert!(traffic.vehicles().windows(2).all(|pair| pair[0].id < pair[1].id));
        assert_eq!(traffic.vehicles().len(), wanted.len(), "step {step}");
        most = most.max(wanted.len());
        for vehicle in traffic.vehicles() {
            let departure = &names[&vehicle.id.0];
            let written = &wanted[&departure.name];
            compare(vehicle, written, &setup, step);
            compared += 1;
            let lane = vehicle.lane.expect("on a lane");
            let before = lanes_before.insert(vehicle.id.0, lane);
            let edge = |lane: LaneId| network.lane(lane).edge;
            changes_of_lane += usize::from(before.is_some_and(|before| before != lane && edge(before) == edge(lane)));
        }
        // Each junction with signals has sixteen links, which are red, yellow or green.
        for k in 0..network.signals().len() {
            let signal = SignalId::from_index(k);
            assert_eq!(traffic.signal(signal).len(), 16);
            use SignalLight::{GreenMajor, GreenMinor, Red, Yellow};
            let light = |link| traffic.light(signal, link).expect("it has that link");
            assert!((0..16).map(light).all(|light| [Red, Yellow, GreenMinor, GreenMajor].contains(&light)));
        }
    }
    let kinds: Vec<VehicleKind> = names.values().map(|new| new.body.kind).collect();
    for kind in [VehicleKind::Car, VehicleKind::Bus, VehicleKind::Truck, VehicleKind::Motorcycle] {
        assert!(kinds.iter().filter(|other| **other == kind).count() >= 30, "{}", kind.name());
    }
    let in_all: BTreeSet<&String> = wanted.iter().flat_map(BTreeMap::keys).collect();
    assert_eq!(names.values().map(|new| &new.name).collect::<BTreeSet<_>>(), in_all);
    println!("{compared} states, {changes_of_lane} changes of lane, {arrived} arrived, at most {most} at once");
    assert!(arrived > 100 && changes_of_lane > 20 && most > 40);
}

/// Returns the total lateral distance, metres, that vehicles moved in steps before and after which they stood, and the number of such
/// steps.
fn sideways_while_standing(setup: &DemandSetup, steps: usize) -> (f64, usize) {
    let mut traffic = SumoTraffic::start_with_demand(setup).expect("it starts");
    let mut before: BTreeMap<u32, (LaneId, f64, f64)> = BTreeMap::new();
    let (mut way_m, mut stood) = (0.0, 0);
    for _ in 0..steps {
        traffic.step(&[]).expect("a step");
        for vehicle in traffic.vehicles() {
            let (lane, offset_m) = (vehicle.lane.expect("on a lane"), vehicle.offset_m);
            let last = before.insert(vehicle.id.0, (lane, offset_m, vehicle.speed_mps));
            if let Some((last_lane, last_m, 0.0)) = last.filter(|_| vehicle.speed_mps == 0.0) {
                way_m += if last_lane == lane { (offset_m - last_m).abs() } else { 3.2 };
                stood += 1;
            }
        }
    }
    (way_m, stood)
}

#[test]
fn a_stopped_vehicle_moves_sideways_only_if_a_files_type_allows_it() {
    let _alone = alone();
    let town = Town::grid();
    let flow = |from: &str, to: &str| Flow { from: from.into(), to: to.into(), per_hour: 900.0, mix: Vec::new() };
    let flows = vec![flow("left0A0", "C2right2"), flow("bottom1B0", "B2top1"), flow("top0A2", "C0bottom2")];
    let (way_m, stood) = sideways_while_standing(&town.setup(Demand { flows, ..Demand::default() }), 2500);
    assert_eq!(way_m, 0.0);
    // The test needs stopped vehicles: a queue of four at a red light of 10 s stands for 400 steps, and there are several in 250 s.
    assert!(stood > 1000, "{stood}");
    // Buses, trucks and motorcycles of a file behave as their types state.
    let (way_m, _) = sideways_while_standing(&town.setup(town.trips()), 2500);
    assert!(way_m > 1.0, "{way_m} m");
}

fn compare(found: &VehicleState, written: &Written, setup: &DemandSetup, step: usize) {
    let what = || format!("step {step}: {found:?} instead of {written:?}");
    let front = found.pose.front(found.body.length_m);
    assert!(front.distance(glam::DVec2::from(written.place)) < 1e-9, "{}", what());
    // SUMO's heading for a long vehicle is not that of its body; the bodies of these follow the path of their front (`long_vehicles`).
    let follows_its_front = found.body.length_m >= 8.0;
    let apart = codrive::space::wrap_angle(found.pose.yaw_rad - (90.0 - written.angle_deg).to_radians());
    assert!(follows_its_front || apart.abs() < 1e-9, "{}", what());
    assert!((found.speed_mps - written.speed_mps).abs() < 1e-9, "{}", what());
    assert!((found.s_m - written.lane_pos_m).abs() < 1e-9, "{}", what());
    // The network's position is SUMO's, except during a lane change: SUMO moves the vehicle sideways by the lane's direction.
    let lane = found.lane.expect("on a lane");
    let place = LanePosition { lane, s_m: found.s_m, offset_m: found.offset_m };
    let point = setup.network.pose(place).position.truncate();
    assert!(point.distance(front) < if found.offset_m == 0.0 { 1e-6 } else { 0.2 }, "{point}: {}", what());
    assert_eq!(found.lane.map(|lane| setup.network.lane(lane).id.as_str()), Some(written.lane.as_str()), "{}", what());
}

#[test]
fn flows_bring_as_many_vehicles_of_each_kind_as_they_say() {
    let _alone = alone();
    let town = Town::grid();
    let share = |kind, share| KindShare { kind, share };
    let flow = Flow {
        from: "left1A1".into(),
        to: "C1right1".into(),
        per_hour: 900.0,
        mix: vec![share(VehicleKind::Car, 2.0), share(VehicleKind::Van, 1.0), share(VehicleKind::Truck, 1.0)],
    };
    let setup = town.setup(Demand { flows: vec![flow], ..Demand::default() });
    let mut traffic = SumoTraffic::start_with_demand(&setup).expect("it starts");
    let mut found: BTreeMap<&str, f64> = BTreeMap::new();
    for _ in 0..12_000 {
        traffic.step(&[]).expect("a step");
        for new in &traffic.changes().departed {
            *found.entry(new.body.kind.name()).or_default() += 1.0;
        }
    }
    // 300 vehicles in 20 minutes, Poisson distributed: the limit is four standard deviations.
    for (kind, wanted) in [("car", 150.0), ("van", 75.0), ("truck", 75.0)] {
        let count = found.get(kind).copied().unwrap_or_default();
        assert!((count - wanted).abs() < 4.0 * f64::sqrt(wanted), "{count} of {wanted} {kind}s");
    }
}

#[test]
fn an_impossible_demand_is_refused_with_the_names_at_fault() {
    let _alone = alone();
    let town = Town::grid();
    let refused = |demand: Demand| {
        let mut traffic = SumoTraffic::start_with_demand(&town.setup(demand))?;
        for _ in 0..20 {
            traffic.step(&[])?;
        }
        Ok(())
    };
    let nowhere = town.folder.path().join("nowhere.rou.xml");
    fs::write(&nowhere, "<routes><trip id=\"lost\" depart=\"0\" from=\"left1A1\" to=\"no_such_edge\"/></routes>")
        .unwrap();
    let of = |file: &Path| Demand { files: vec![file.into()], ..Demand::default() };
    let error: TrafficError = refused(of(&nowhere)).expect_err("there is no such edge");
    assert!(error.to_string().contains("no_such_edge"), "{error}");
    let absent = refused(of(Path::new("absent.rou.xml"))).expect_err("there is no such file");
    assert!(absent.to_string().contains("absent.rou.xml"), "{absent}");
}
