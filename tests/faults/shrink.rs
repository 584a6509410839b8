//! Search for the smallest plan that still breaks a promise. In: a plan that breaks one. Out: a plan with fewer and earlier faults, and a
//! report.

use super::{
    plan::{Fault, Plan},
    scenario::{Broken, Scenario},
};

/// Maximum number of plans tried.
const TRIES: usize = 40;

/// Returns the report of a broken promise: the seed, the plan, the smallest plan, the command lines.
pub fn report(scenario: Scenario, seed: u64, plan: &Plan, broken: Box<Broken>) -> String {
    let (small, least) = shrink(scenario, seed, plan);
    // If a second run of the same plan breaks nothing, the order of threads was the cause.
    let least = least.unwrap_or(broken);
    let Broken { promise, outcome, work } = *least;
    let printed = outcome.text.trim().replace('\n', "\n    ");
    format!(
        "seed {seed}, {scenario:?}: {promise}\n  plan: {plan}\n  smallest: {small}\n  command: {}\n  ended: exit code {:?}, signal {:?}\n    {printed}\n  left in: {}\n  again: scripts/faults 1 {seed}\n",
        outcome.command,
        outcome.code,
        outcome.signal,
        work.keep().display(),
    )
}

/// Removes faults, and moves the remaining ones forward, as long as a promise breaks.
fn shrink(scenario: Scenario, seed: u64, plan: &Plan) -> (Plan, Option<Box<Broken>>) {
    let (mut small, mut least) = (plan.clone(), None);
    let mut tries = 0;
    loop {
        let smaller = smaller(&small).into_iter().find_map(|plan| {
            tries += 1;
            if tries > TRIES {
                return None;
            }
            scenario.check(&plan, seed).err().map(|broken| (plan, broken))
        });
        match smaller {
            Some((plan, broken)) => (small, least) = (plan, Some(broken)),
            None => break,
        }
    }
    if least.is_none() {
        least = scenario.check(&small, seed).err();
    }
    (small, least)
}

/// Returns the plans that are one step smaller.
fn smaller(plan: &Plan) -> Vec<Plan> {
    let mut found = Vec::new();
    if plan.0.len() > 1 {
        for left_out in 0..plan.0.len() {
            let mut fewer = plan.clone();
            fewer.0.remove(left_out);
            found.push(fewer);
        }
    }
    for (place, fault) in plan.0.iter().enumerate() {
        let mut simpler: Vec<Fault> = [1, fault.at / 2, fault.at - 1]
            .into_iter()
            .filter(|at| (1..fault.at).contains(at))
            .map(|at| Fault { at, ..fault.clone() })
            .collect();
        if fault.is_power_cut() {
            simpler.push(Fault { action: fault.action.replace("power", "kill"), number: 0, ..fault.clone() });
        }
        if fault.is_power_cut() && fault.number != 0 {
            simpler.push(Fault { number: 0, ..fault.clone() });
        }
        if let Some(once) = fault.action.strip_suffix('+') {
            simpler.push(Fault { action: once.into(), ..fault.clone() });
        }
        found.extend(simpler.into_iter().map(|fault| {
            let mut other = plan.clone();
            other.0[place] = fault;
            other
        }));
    }
    found
}

#[test]
fn a_plan_shrinks_fault_by_fault_and_call_by_call() {
    let plan: Plan = "write a 8 EIO+; sync b 1 power 7".parse().unwrap();
    let found: Vec<String> = smaller(&plan).iter().map(ToString::to_string).collect();
    let expected = [
        "sync b 1 power 7",
        "write a 8 EIO+",
        "write a 1 EIO+; sync b 1 power 7",
        "write a 4 EIO+; sync b 1 power 7",
        "write a 7 EIO+; sync b 1 power 7",
        "write a 8 EIO; sync b 1 power 7",
        "write a 8 EIO+; sync b 1 kill",
        "write a 8 EIO+; sync b 1 power",
    ];
    assert_eq!(found, expected);
    assert!(smaller(&"write a 1 EIO".parse().unwrap()).is_empty());
}
