//! Scenes of OpenSCENARIO, imported by the program and driven without a participant. Expected: the trajectories that esmini drives
//! (`tests/data/openscenario/README.md`).

use crate::world::one_at_a_time;
use codrive::{
    scenario::{RoadUser, Scenario},
    sim::World,
    snapshot::VehicleSnapshot,
    traffic::VehicleId,
};
use glam::{DVec2, dvec2};
use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

/// Largest distance from the trajectory of esmini, m. Scenes of overtaking and crossing keep their meaning: the smallest gap between two bodies
/// in them is 1.7 m.
const PLACE_M: f64 = 0.1;
/// Largest difference in time, s. Triggers are looked at once a step of the traffic, which is 0.1 s; the trajectories of esmini were made with
/// steps of 0.001 s.
const TIME_S: f64 = 0.1;
/// Largest difference from the speeds of esmini within that time, m/s.
const SPEED_MPS: f64 = 0.1;
/// Sampling of the files of esmini, s.
const SAMPLE_S: f64 = 0.1;

/// State of an entity at one moment, as esmini drives it.
#[derive(Clone, Copy, Debug)]
struct Sample {
    /// Reference point, m: the middle of the rear axle, or of a person's body.
    point: DVec2,
    speed_mps: f64,
}

/// Entity of a scene with its samples, one each 0.1 s from the scene's start on.
#[derive(Debug)]
struct Trajectory {
    entity: String,
    samples: Vec<Sample>,
}

/// Deviation of a road user from its trajectory.
#[derive(Clone, Copy, Debug)]
struct Deviation {
    /// Least distance from the points that esmini passes within [`TIME_S`], m.
    place_m: f64,
    /// Distance outside of the speeds that esmini has within [`TIME_S`], m/s.
    speed_mps: f64,
    /// Distance from the point of esmini at the same moment, m. It is shown in messages only.
    at_once_m: f64,
}

impl Trajectory {
    /// Returns the deviation of a state at sample `k`.
    fn deviation(&self, k: usize, state: Sample) -> Deviation {
        let reach = (TIME_S / SAMPLE_S).round() as usize;
        let near = &self.samples[k.saturating_sub(reach)..(k + reach + 1).min(self.samples.len())];
        let speeds = || near.iter().map(|sample| sample.speed_mps);
        let [low, high] = [speeds().fold(f64::INFINITY, f64::min), speeds().fold(f64::NEG_INFINITY, f64::max)];
        Deviation {
            place_m: near
                .windows(2)
                .map(|pair| distance_m(state.point, [pair[0].point, pair[1].point]))
                .fold(f64::INFINITY, f64::min),
            speed_mps: (low - state.speed_mps).max(state.speed_mps - high).max(0.0),
            at_once_m: state.point.distance(self.samples[k].point),
        }
    }
}

/// Returns the distance from a point to a piece of a line, m.
fn distance_m(point: DVec2, [from, to]: [DVec2; 2]) -> f64 {
    let along = to - from;
    let share = ((point - from).dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    point.distance(from + share * along)
}

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/openscenario").join(name)
}

/// Reads the trajectories of a scene, in the order of its entities.
fn trajectories(scene: &str) -> Vec<Trajectory> {
    let text = fs::read_to_string(file(&format!("{scene}.esmini.csv"))).expect("a file of trajectories");
    let mut all: Vec<Trajectory> = Vec::new();
    for line in text.lines().skip(1) {
        let [time_s, entity, x_m, y_m, _, speed_mps] = line.split(',').collect::<Vec<_>>()[..] else {
            panic!("{scene}: {line}")
        };
        let [time_s, x_m, y_m, speed_mps] =
            [time_s, x_m, y_m, speed_mps].map(|text| text.parse::<f64>().expect("a number"));
        if !all.iter().any(|trajectory| trajectory.entity == entity) {
            all.push(Trajectory { entity: entity.into(), samples: Vec::new() });
        }
        let samples = &mut all.iter_mut().find(|trajectory| trajectory.entity == entity).expect("it is there").samples;
        assert!((time_s - samples.len() as f64 * SAMPLE_S).abs() < 1e-9, "{scene}: {line}");
        samples.push(Sample { point: dvec2(x_m, y_m), speed_mps });
    }
    all
}

/// Imports a scene as the program does, and reads the scenario that it writes.
fn imported(scene: &str, folder: &Path) -> Scenario {
    let scenario = folder.join(format!("{scene}.toml"));
    let mut program = Command::new(env!("CARGO_BIN_EXE_codrive"));
    program.args(["scenario", "import"]).arg(file(&format!("{scene}.xosc"))).arg("--out").arg(&scenario);
    let done = program.args(["--participant", "none"]).output().expect("the program runs");
    assert!(done.status.success(), "{scene}: {}", String::from_utf8_lossy(&done.stderr));
    Scenario::from_file(&scenario).unwrap_or_else(|fault| panic!("{scene}: {fault}"))
}

/// Returns a road user's state in the coordinates of the OpenDRIVE file.
fn state(world: &World, user: &RoadUser, vehicle: &VehicleSnapshot) -> Sample {
    let to_point_m = user.body().length_m / 2.0 - user.rear_axle_m();
    let point = vehicle.pose.position + to_point_m * vehicle.pose.forward();
    Sample { point: point - world.map().network.offset(), speed_mps: vehicle.speed_mps }
}

/// Returns the id of the road user that begins where a trajectory begins.
fn id_of(world: &World, user: &RoadUser, trajectory: &Trajectory) -> VehicleId {
    let all = world.snapshot().cars.iter();
    let begins_there =
        |car: &&VehicleSnapshot| state(world, user, car).point.distance(trajectory.samples[0].point) < PLACE_M;
    let ids: Vec<_> = all.filter(begins_there).map(|car| car.id).collect();
    let [id] = ids[..] else { panic!("{}: {ids:?} begin at its place", user.name) };
    id
}

/// Drives a scene to the end of its trajectories and compares all road users at each sample.
fn matches_esmini(scene: &str) {
    let _alone = one_at_a_time();
    let folder = tempfile::tempdir().expect("a folder");
    let scenario = imported(scene, folder.path());
    let trajectories = trajectories(scene);
    let mut world = World::new(&scenario).unwrap_or_else(|error| panic!("{scene}: {error}"));
    let users: Vec<_> = trajectories
        .iter()
        .map(|trajectory| {
            let mut all = scenario.road_users.iter();
            let user = all.find(|user| user.name == trajectory.entity).expect("a road user for each entity");
            (trajectory, user, id_of(&world, user, trajectory))
        })
        .collect();
    // Not the last sample: a vehicle that is 0.1 s ahead needs a later one.
    let last = trajectories.iter().map(|trajectory| trajectory.samples.len() - 2).min().expect("entities");
    for k in 0..=last {
        for (trajectory, user, id) in &users {
            let vehicle = world.snapshot().vehicle(*id);
            let vehicle = vehicle.unwrap_or_else(|| panic!("{scene}: {} is gone in sample {k}", user.name));
            let found = state(&world, user, vehicle);
            let deviation = trajectory.deviation(k, found);
            assert!(
                deviation.place_m <= PLACE_M && deviation.speed_mps <= SPEED_MPS,
                "{scene}: {} in sample {k}: {deviation:?}, {:.2} m from the point at this moment; {found:?}, esmini: {:?}",
                user.name,
                deviation.at_once_m,
                trajectory.samples[k]
            );
        }
        if k < last {
            let next_s = (k + 1) as f64 * SAMPLE_S;
            while world.snapshot().tick.seconds() < next_s - 1e-9 {
                assert_eq!(world.ended(), None, "{scene} in sample {k}");
                world.step().expect("the traffic goes on");
            }
        }
    }
}

#[test]
fn the_imported_cut_in_is_that_of_esmini() {
    matches_esmini("cut-in");
}

#[test]
fn imported_lane_changes_in_a_bend_are_those_of_esmini() {
    matches_esmini("lane-change");
}

#[test]
fn imported_changes_of_speed_are_those_of_esmini() {
    matches_esmini("brake");
}

#[test]
fn imported_people_walk_and_vehicles_stop_as_in_esmini() {
    matches_esmini("pedestrian");
}

#[test]
fn imported_vehicles_stop_at_a_light_as_in_esmini() {
    matches_esmini("traffic-light");
}

#[test]
fn imported_vehicles_arrive_together_as_in_esmini() {
    matches_esmini("synchronise");
}

#[test]
fn imported_events_repeat_and_put_vehicles_back_as_in_esmini() {
    matches_esmini("again");
}

#[test]
fn a_shift_a_delay_and_a_wrong_speed_are_deviations() {
    // A vehicle at 20 m/s along x; the point of sample 5 is at 10 m.
    let samples = (0..=10).map(|k| Sample { point: dvec2(2.0 * f64::from(k), 0.0), speed_mps: 20.0 }).collect();
    let trajectory = Trajectory { entity: "straight".into(), samples };
    let at = |x_m: f64, y_m: f64, speed_mps: f64| trajectory.deviation(5, Sample { point: dvec2(x_m, y_m), speed_mps });
    let within = |deviation: Deviation| deviation.place_m <= PLACE_M && deviation.speed_mps <= SPEED_MPS;
    assert!(within(at(10.0, 0.09, 20.05)) && within(at(11.9, 0.0, 20.0)) && within(at(8.1, 0.0, 19.95)));
    assert!(!within(at(10.0, 0.11, 20.0)), "beside it");
    assert!(!within(at(12.2, 0.0, 20.0)) && !within(at(7.8, 0.0, 20.0)), "more than 0.1 s ahead or behind");
    assert!(!within(at(10.0, 0.0, 20.2)), "faster");
}
