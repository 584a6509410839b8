//! Evaluation of a policy by one whole drive. In: a scenario with a simulated driver. Out: an [`EvaluationResult`] of
//! the whole program: physics, pedals, advice, and either traffic engine. On a closed route the code is the same as on
//! the fast ring. Without advised vehicles, every vehicle is the engine's own. On a network there is no participant:
//! vehicles are advised as they enter, for the whole duration.

use super::{RunError, offline::OfflineDrive};
use crate::{
    map::RoadMap,
    metrics::{AdvisedStep, Approach, EpisodeMetrics, EpisodeStep, EvaluationResult, NetworkFlow},
    scenario::{AdvisedVehicles, PlannedDrive, Scenario},
    sim::{Snapshot, World, WorldError},
    space::CAR_LENGTH_M,
    traffic::VehicleState,
};
use std::{collections::BTreeMap, sync::Arc};

/// Drives the scenario to its end; its warm-up does not count. From the first contact of an advised vehicle on, all
/// vehicles count as standing, as on the fast ring.
///
/// # Errors
/// The world cannot start or go on, or the driver is unknown.
pub fn evaluate(scenario: &Scenario) -> Result<EvaluationResult, RunError> {
    evaluate_planned(PlannedDrive::new(scenario).map_err(WorldError::from)?)
}

/// Does the same as [`evaluate`] with a planned drive, which may have a policy of its own.
///
/// # Errors
/// As [`evaluate`].
pub fn evaluate_planned(drive: PlannedDrive) -> Result<EvaluationResult, RunError> {
    match drive.advised() {
        AdvisedVehicles::Share(_) => on_network(&drive),
        AdvisedVehicles::Count(0) => traffic_alone(&drive),
        AdvisedVehicles::Count(_) => with_participant(drive),
    }
}

/// Evaluates a drive by a simulated participant on a closed route.
fn with_participant(drive: PlannedDrive) -> Result<EvaluationResult, RunError> {
    let step_s = drive.scenario().step_s;
    let mut run = OfflineDrive::of(drive, [0.0, f64::INFINITY])?;
    let mut metrics = EpisodeMetrics::new(step_s, run.world().map().route.length_m());
    while run.world().ended().is_none() {
        run.step()?;
        if has_crashed(&run) {
            metrics.crash();
        }
        let snapshot = run.world().snapshot();
        let others = snapshot.vehicles().map(|car| car.speed_mps);
        let ego_mps = snapshot.ego.speed_mps.max(0.0);
        let ahead = snapshot
            .leader_in_lane()
            .map(|leader| Approach { gap_m: leader.gap_m, closing_mps: ego_mps - leader.speed_mps });
        let others_now = advised_others(run.world());
        let now = EpisodeStep { ahead, advice: snapshot.advice, others: others_now, ..EpisodeStep::default() };
        metrics.add(in_order(std::iter::once(ego_mps).chain(others)), now);
    }
    Ok(without_flow(metrics.result(), run.world().drive()))
}

/// Returns a result without the flow of a closed route where the route is open.
fn without_flow(result: EvaluationResult, drive: &PlannedDrive) -> EvaluationResult {
    let flow_per_h = result.flow_per_h.filter(|_| drive.logged().is_none());
    EvaluationResult { flow_per_h, ..result }
}

/// Returns the speeds of a closed route's vehicles with their places in the order, in the precision of the fast ring, m/s.
fn in_order(speeds_mps: impl Iterator<Item = f64>) -> impl Iterator<Item = (u32, f64)> {
    (0..).zip(speeds_mps.map(|speed_mps| f64::from(speed_mps as f32)))
}

/// Checks whether any of the fully simulated vehicles has touched another.
fn has_crashed(run: &OfflineDrive) -> bool {
    !run.summary().contacts.is_empty() || run.world().contacts_of_others() > 0
}

/// Evaluates a drive with vehicles that come and go. The mean speed is Flow's: the mean over the present vehicles at
/// each step, then over the steps.
fn on_network(drive: &PlannedDrive) -> Result<EvaluationResult, RunError> {
    let scenario = Scenario { participant: false, ..drive.scenario().clone() };
    let alone = PlannedDrive::on(&scenario, Arc::clone(drive.map())).map_err(WorldError::from)?;
    let mut run = OfflineDrive::of(alone.advised_by(drive.own_policy().cloned()), [0.0, f64::INFINITY])?;
    let last = (scenario.duration_s / scenario.step_s).round() as u64;
    let most_gap_m = run.world().map().route.length_m();
    let start = run.world().snapshot().numbered_speeds_mps();
    let mut metrics = EpisodeMetrics::on_network(scenario.step_s, start, most_gap_m);
    while run.world().ended().is_none() {
        run.step()?;
        if run.world().contacts_of_others() > 0 {
            metrics.crash();
            metrics.stand_until(last);
            break;
        }
        let snapshot = run.world().snapshot();
        let others = AdvisedStep { min_gap_m: min_gap_m(snapshot), ..advised_others(run.world()) };
        metrics.add(snapshot.numbered_speeds_mps(), EpisodeStep { others, ..EpisodeStep::default() });
    }
    let mut result = metrics.result();
    result.network = result.network.map(|flow| with_demand(flow, run.world(), metrics.newest()));
    Ok(result)
}

/// Returns the combined state of the advised vehicles other than the ego.
fn advised_others(world: &World) -> AdvisedStep {
    let mut step = AdvisedStep::default();
    for view in world.advised_others().iter().map(|agent| agent.snapshot()) {
        let gap_m = view.leader_in_lane().map(|leader| leader.gap_m);
        step.min_gap_m = [step.min_gap_m, gap_m].into_iter().flatten().min_by(f64::total_cmp);
        let Some(advice) = view.advice else { continue };
        step.advised += 1;
        step.in_range += u64::from(advice.accepts(view.ego.speed_mps));
    }
    step
}

/// Returns the smallest gap between two vehicles of a lane, m.
fn min_gap_m(snapshot: &Snapshot) -> Option<f64> {
    let mut lanes: BTreeMap<_, Vec<(f64, f64)>> = BTreeMap::new();
    for car in &snapshot.cars {
        let Some(at) = car.lane else { continue };
        lanes.entry(at.lane).or_default().push((at.s_m, at.s_m - car.body.length_m));
    }
    let gaps = lanes.into_values().flat_map(|mut places| {
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        let gaps: Vec<f64> = places.windows(2).map(|pair| pair[1].1 - pair[0].0).collect();
        gaps
    });
    gaps.min_by(f64::total_cmp)
}

/// Adds the numbers of vehicles that were refused and advised, at the end of a drive. Vehicles are numbered from 1 as
/// they enter, including the warm-up, so the newest number is the number of vehicles that have entered.
fn with_demand(flow: NetworkFlow, world: &World, newest: u32) -> NetworkFlow {
    let scenario = world.scenario();
    let passed_s = scenario.warm_up_s + world.hand_over().waited_s + world.time_s();
    NetworkFlow {
        vehicles_refused: scenario.demand.due(passed_s).map(|due| (due - f64::from(newest)).max(0.0)),
        advised_vehicles: world.ever_advised().len() as u32,
        ..flow
    }
}

/// Evaluates a drive without advised vehicles.
fn traffic_alone(drive: &PlannedDrive) -> Result<EvaluationResult, RunError> {
    let (scenario, map) = (drive.scenario(), drive.map());
    let mut engine = World::traffic_alone(drive)?;
    let mut metrics = EpisodeMetrics::new(scenario.step_s, map.route.length_m());
    for _ in 0..(scenario.duration_s / scenario.step_s).round() as u64 {
        engine.step(&[]).map_err(WorldError::from)?;
        let cars = engine.vehicles();
        let now = EpisodeStep { ahead: ahead(cars, map), ..EpisodeStep::default() };
        metrics.add(in_order(cars.iter().map(|car| car.speed_mps)), now);
    }
    Ok(without_flow(metrics.result(), drive))
}

/// Returns the state of the first vehicle, which takes the place of the ego, behind its leader.
fn ahead(cars: &[VehicleState], map: &RoadMap) -> Option<Approach> {
    let (ego, leader) = (&cars[0], &cars[1]);
    let s_m = |car: &VehicleState| map.route.s_on(car.lane?, car.s_m);
    let gap_m = map.route.ahead(s_m(ego)?, s_m(leader)?) - CAR_LENGTH_M;
    Some(Approach { gap_m, closing_mps: ego.speed_mps - leader.speed_mps })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::policy::{ConstantSpeed, PolicySource};
    use crate::scenario::DisplaySettings;
    use crate::traffic::EngineChoice;

    #[test]
    fn a_short_drive_behind_others_is_evaluated() {
        let scenario = Scenario {
            traffic: EngineChoice::Native,
            policy: "none".into(),
            driver: "perfect".into(),
            vehicles: 4,
            warm_up_s: 1.0,
            duration_s: 10.0,
            display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
            ..Scenario::default()
        };
        let result = evaluate(&scenario).unwrap();
        assert!(!result.crashed && result.time_in_range.is_none(), "{result:?}");
        // Four vehicles on a ring of 250 m, from a standstill.
        assert!(result.mean_speed_mps > 0.5 && result.settled_speed_mps > result.mean_speed_mps, "{result:?}");
        assert!(result.min_gap_to_neighbours_m > 10.0 && result.min_gap_to_neighbours_m < 250.0 / 4.0, "{result:?}");
    }

    /// Returns the paper's wave with these advised vehicles.
    fn wave(advised: AdvisedVehicles) -> Scenario {
        Scenario {
            traffic: EngineChoice::Native,
            policy: "pi".into(),
            advised,
            warm_up_s: 600.0,
            duration_s: 300.0,
            display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
            ..Scenario::default()
        }
    }

    #[test]
    fn without_advised_vehicles_all_drive_in_the_saturated_wave() {
        let result = evaluate(&wave(AdvisedVehicles::Share(0.0))).unwrap();
        // docs/references.md: ring: 2.99 m/s on average, and a standard deviation of 3.37 m/s over the vehicles.
        assert!((result.mean_speed_mps - 2.99).abs() < 0.08, "{result:?}");
        assert!((result.speed_sd_over_vehicles_mps - 3.37).abs() < 0.1, "{result:?}");
        assert!(
            !result.crashed && result.time_in_range.is_none() && result.min_gap_to_neighbours_m > 1.0,
            "{result:?}"
        );
        // The policy has no influence.
        let other = Scenario { policy: "constant".into(), driver: "sloppy".into(), ..wave(AdvisedVehicles::Count(0)) };
        assert_eq!(evaluate(&other).unwrap(), result);
    }

    #[test]
    fn a_policy_without_a_name_drives_as_the_same_policy_by_its_name() {
        let short = Scenario { warm_up_s: 10.0, duration_s: 30.0, ..wave(AdvisedVehicles::Count(3)) };
        let named = Scenario { policy: "constant".into(), policy_speed_mps: 4.3, ..short.clone() };
        let source = PolicySource::engaged_by(|| Box::new(ConstantSpeed { speed_mps: 4.3 }));
        let own = PlannedDrive::new(&Scenario { policy: "outside".into(), ..short.clone() }).unwrap();
        let result = evaluate_planned(own.advised_by(Some(source))).unwrap();
        assert_eq!(result, evaluate(&named).unwrap());
        assert_ne!(result, evaluate(&short).unwrap());
    }

    #[test]
    fn a_crash_of_another_advised_vehicle_counts_as_a_crash() {
        // Advised vehicles follow 15 m/s exactly and ignore their leaders; the ego brakes for others.
        let crowd = Scenario {
            policy: "constant".into(),
            policy_speed_mps: 15.0,
            driver: "exact".into(),
            warm_up_s: 0.0,
            duration_s: 40.0,
            ..wave(AdvisedVehicles::Count(2))
        };
        let mut run = OfflineDrive::by(&crate::driver::preset("follow").unwrap(), &crowd, [0.0, 40.0]).unwrap();
        assert!(!has_crashed(&run));
        run.until(40.0).unwrap();
        assert!(run.summary().contacts.is_empty(), "{:?}", run.summary().contacts);
        assert!(run.advised().contacts_of_others > 0 && has_crashed(&run));
    }

    #[test]
    fn after_a_crash_of_the_ego_all_vehicles_count_as_standing() {
        let scenario = Scenario {
            traffic: EngineChoice::Native,
            policy: "constant".into(),
            policy_speed_mps: 15.0,
            driver: "exact".into(),
            vehicles: 10,
            duration_s: 40.0,
            display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
            ..Scenario::default()
        };
        let result = evaluate(&scenario).unwrap();
        // The leader starts at a standstill 20 m ahead and accelerates to 15 m/s at the model's 1 m/s², the ego at 1.5
        // m/s².
        let crash_s = result.crash_s.unwrap();
        assert!(result.crashed && result.last_disturbance_s.is_none() && (5.0..20.0).contains(&crash_s), "{result:?}");
        assert_eq!(result.settled_speed_mps, 0.0);
    }
}
