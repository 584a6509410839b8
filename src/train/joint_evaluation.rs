//! Evaluation of a policy that decides for many rings in one call, such as one in another program with costly calls. In: a
//! configuration's rings and the function to ask. Out: bit for bit the results of [`super::evaluate()`] for a policy with the same
//! actions.

use super::{
    config::TrainConfig,
    evaluation::{EvaluatedBlock, steps},
    simd::LANES,
};
use crate::{
    metrics::EvaluationResult,
    policy::{Action, Observation, Policy},
};
use rayon::prelude::*;
use std::sync::{Arc, Mutex, PoisonError};

/// Action of one ring, shared between the joint call and the ring's advisor.
type SharedAction = Arc<Mutex<Option<Action>>>;

/// A policy that returns the action of the joint call.
struct Answered {
    answer: SharedAction,
}

impl Policy for Answered {
    fn act(&mut self, _time_s: f64, _observation: &Observation) -> Action {
        let answer = *self.answer.lock().unwrap_or_else(PoisonError::into_inner);
        // A missing action counts as NaN, for which the advisor has its own rule.
        answer.unwrap_or(Action::Speed(f64::NAN))
    }

    fn observes_driver(&self) -> bool {
        true
    }
}

/// A block with the actions for its rings.
struct AskedBlock {
    driven: EvaluatedBlock,
    answers: Vec<SharedAction>,
}

impl AskedBlock {
    fn new(config: &TrainConfig, stream: &str, index: usize) -> Self {
        let rows = LANES * config.ring.advised_slots().count();
        let answers: Vec<SharedAction> = (0..rows).map(|_| Arc::default()).collect();
        let mut next = answers.iter();
        let policy = || {
            let answer = Arc::clone(next.next()?);
            Some(Box::new(Answered { answer }) as Box<dyn Policy>)
        };
        Self { driven: EvaluatedBlock::new(config, stream, index, config.hold(), policy), answers }
    }

    /// Returns the observations that the advisors are about to give their policies, row by row.
    fn observations(&self) -> impl Iterator<Item = Observation> + '_ {
        let seen = |row| self.driven.advisors.complete_observation(row, &self.driven.env.observe(row));
        (0..self.driven.env.rows()).map(seen)
    }
}

/// Evaluates the rings of [`super::evaluate()`] with the same arguments side by side. Each hold `ask` gets one observation per advised
/// vehicle, ring after ring, and returns one action for each. All rings have the shortest hold.
///
/// # Errors
/// The error of `ask`, which ends the evaluation.
pub fn evaluate_jointly<E>(
    config: &TrainConfig,
    stream: &str,
    rings: usize,
    mut ask: impl FnMut(&[Observation]) -> Result<Vec<Action>, E>,
) -> Result<Vec<EvaluationResult>, E> {
    let mut blocks: Vec<AskedBlock> =
        (0..rings.div_ceil(LANES)).into_par_iter().map(|index| AskedBlock::new(config, stream, index)).collect();
    let advised = config.ring.advised_slots().count();
    let mut left = steps(config, config.ring.horizon_s);
    while left > 0 {
        let seen: Vec<Observation> = blocks.iter().flat_map(AskedBlock::observations).take(rings * advised).collect();
        let actions = ask(&seen)?;
        let answers = blocks.iter().flat_map(|block| &block.answers);
        for (answer, action) in answers.zip(&actions) {
            *answer.lock().unwrap_or_else(PoisonError::into_inner) = Some(*action);
        }
        let steps = left.min(config.hold().steps().into());
        blocks.par_iter_mut().for_each(|block| (0..steps).for_each(|_| block.driven.step()));
        left -= steps;
    }
    Ok(blocks.iter().flat_map(|block| block.driven.results()).take(rings).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::train::{RingConfig, evaluate, evaluate_part};
    use std::convert::Infallible;

    /// A policy whose action depends on everything that an advisor adds to the observation of traffic.
    fn answer(seen: &Observation) -> Action {
        let advised_mps = seen.advised_mps.unwrap_or(2.0);
        Action::Speed(
            0.4 * seen.mean_speed_mps + 0.3 * seen.leader_speed_mps + 0.2 * advised_mps + 0.1 * seen.hold_s
                - 0.1 * seen.observed.deviation_mps,
        )
    }

    struct OneByOne;

    impl Policy for OneByOne {
        fn act(&mut self, _time_s: f64, seen: &Observation) -> Action {
            answer(seen)
        }

        fn observes_driver(&self) -> bool {
            true
        }
    }

    fn config() -> TrainConfig {
        let paper = TrainConfig::paper_ring();
        // 25.5 s is not a whole number of holds.
        TrainConfig { ring: RingConfig { warm_up_s: 20.0, horizon_s: 25.5, ..paper.ring.clone() }, ..paper }
    }

    #[test]
    fn a_joint_evaluation_equals_one_ring_by_ring() {
        let ask = |seen: &[Observation]| Ok::<_, Infallible>(seen.iter().map(answer).collect());
        let Ok(jointly) = evaluate_jointly(&config(), "test", 20, ask);
        let one_by_one = evaluate(&config(), "test", 20, || Some(Box::new(OneByOne)));
        assert_eq!(jointly.len(), 20);
        assert_eq!(jointly, one_by_one);
    }

    #[test]
    fn an_error_of_the_asked_policy_ends_the_evaluation() {
        let mut questions = 0;
        let ask = |seen: &[Observation]| {
            questions += 1;
            if questions < 3 { Ok(seen.iter().map(answer).collect()) } else { Err("tired") }
        };
        assert_eq!(evaluate_jointly(&config(), "test", 1, ask), Err("tired"));
        assert_eq!(questions, 3);
    }

    #[test]
    fn an_evaluation_in_parts_equals_the_whole() {
        let part = |rings| evaluate_part(&config(), "test", rings, 37, || Some(Box::new(OneByOne)));
        let whole = evaluate(&config(), "test", 37, || Some(Box::new(OneByOne)));
        assert_eq!([part(0..16), part(16..37)].concat(), whole);
    }
}
