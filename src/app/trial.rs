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
    let verdict = tally.verdict();
    let crashed = verdict.crashed || !run.summary().contacts.is_empty();
    Ok(Verdict { crashed, calm_s: verdict.calm_s.filter(|_| !crashed), ..verdict })
}
