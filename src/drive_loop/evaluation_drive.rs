//! Evaluates a policy by one whole drive. In: a scenario with a simulated driver. Out: a [`EvaluationResult`], by the same
//! code as on the fast ring, of the whole program: physics, pedals, advice, and either engine of traffic.

use super::{RunError, offline::OfflineDrive};
use crate::{
    metrics::{Approach, EpisodeMetrics, EpisodeStep, EvaluationResult},
    scenario::Scenario,
};

/// Drives the scenario to its end; its warm-up does not count. From the first contact on all cars count as standing, as on
/// the fast ring.
///
/// # Errors
/// The world cannot start or go on, or the driver is unknown.
pub fn evaluate(scenario: &Scenario) -> Result<EvaluationResult, RunError> {
    let mut run = OfflineDrive::new(scenario, [0.0, f64::INFINITY])?;
    let mut tally = EpisodeMetrics::new(scenario.step_s, run.world().map().route.length_m());
    while run.world().ended().is_none() {
        run.step()?;
        if !run.summary().contacts.is_empty() {
            tally.crash();
        }
        let snapshot = run.world().snapshot();
        let others = snapshot.cars.iter().map(|car| car.speed_mps as f32);
        let ego_mps = snapshot.ego.speed_mps.max(0.0);
        let ahead = snapshot
            .leader_in_lane()
            .map(|leader| Approach { gap_m: leader.gap_m, closing_mps: ego_mps - leader.speed_mps });
        let now = EpisodeStep { ahead, advice: snapshot.advice, ..EpisodeStep::default() };
        tally.add(std::iter::once(ego_mps as f32).chain(others), now);
    }
    Ok(tally.verdict())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::DisplaySettings;
    use crate::traffic::EngineChoice;

    #[test]
    fn a_short_drive_behind_others_is_judged_by_what_was_driven() {
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
        let verdict = evaluate(&scenario).unwrap();
        assert!(!verdict.crashed && verdict.in_range.is_none(), "{verdict:?}");
        // Four cars on a ring of 250 m, from a stand.
        assert!(verdict.mean_mps > 0.5 && verdict.settled_mps > verdict.mean_mps, "{verdict:?}");
        assert!(verdict.least_gap_m > 10.0 && verdict.least_gap_m < 250.0 / 4.0, "{verdict:?}");
    }

    #[test]
    fn a_car_that_drives_into_another_has_crashed_and_stands_from_then_on() {
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
        let verdict = evaluate(&scenario).unwrap();
        // The leader begins at a standstill 20 m ahead and reaches 15 m/s at the model's 1 m/s2, the ego at 1.5 m/s2.
        let crash_s = verdict.crash_s.unwrap();
        assert!(
            verdict.crashed && verdict.last_disturbance_s.is_none() && (5.0..20.0).contains(&crash_s),
            "{verdict:?}"
        );
        assert_eq!(verdict.settled_mps, 0.0);
    }
}
