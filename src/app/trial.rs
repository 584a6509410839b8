//! One whole drive, judged. In: a scenario with a simulated driver. Out: a [`Verdict`], by the same code as on the fast
//! ring, of the whole program: physics, pedals, advice, and either engine of traffic.

use super::{AppError, offline::Run};
use crate::{
    sim::Scenario,
    train::{Tally, Verdict},
};

/// Drives the scenario to its end; its warm-up does not count.
///
/// # Errors
/// The world cannot start or go on, or the driver is unknown.
pub fn judged(scenario: &Scenario) -> Result<Verdict, AppError> {
    let mut run = Run::new(scenario, [0.0, f64::INFINITY])?;
    let mut tally = Tally::new(scenario.step_s, run.world().map().route.length_m());
    while run.world().ended().is_none() {
        run.step()?;
        let snapshot = run.world().snapshot();
        let others = snapshot.cars.iter().map(|car| car.speed_mps as f32);
        let gap_m = snapshot.leader.map_or(f64::INFINITY, |leader| leader.gap_m);
        let ego_mps = snapshot.ego.speed_mps.max(0.0) as f32;
        tally.add(std::iter::once(ego_mps).chain(others), gap_m, snapshot.advice.as_ref());
    }
    Ok(with_touch(tally.verdict(), !run.summary().contacts.is_empty()))
}

/// The verdict on a drive in which the car touched another or not: one that did is crashed and never calm.
fn with_touch(verdict: Verdict, touched: bool) -> Verdict {
    let crashed = verdict.crashed || touched;
    Verdict { crashed, calm_s: verdict.calm_s.filter(|_| !crashed), ..verdict }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_drive_behind_others_is_judged_by_what_was_driven() {
        let scenario = Scenario {
            traffic: "native".into(),
            policy: "none".into(),
            driver: "perfect".into(),
            vehicles: 4,
            warm_up_s: 1.0,
            duration_s: 10.0,
            trees: 0,
            ..Scenario::default()
        };
        let verdict = judged(&scenario).unwrap();
        assert!(!verdict.crashed && verdict.in_range.is_none(), "{verdict:?}");
        // Four cars on a ring of 250 m, from a stand.
        assert!(verdict.mean_mps > 0.5 && verdict.settled_mps > verdict.mean_mps, "{verdict:?}");
        assert!(verdict.least_gap_m > 10.0 && verdict.least_gap_m < 250.0 / 4.0, "{verdict:?}");
    }

    #[test]
    fn a_car_that_touched_another_has_crashed_and_was_never_calm() {
        let verdict = calm_verdict();
        let told = |crashed, touched| {
            let after = with_touch(Verdict { crashed, ..verdict }, touched);
            (after.crashed, after.calm_s)
        };
        assert_eq!(told(false, false), (false, Some(3.0)));
        for (crashed, touched) in [(true, false), (false, true), (true, true)] {
            assert_eq!(told(crashed, touched), (true, None));
        }
    }

    fn calm_verdict() -> Verdict {
        Verdict { calm_s: Some(3.0), ..Tally::new(0.1, 250.0).verdict() }
    }
}
