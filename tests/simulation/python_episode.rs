//! The episode that Rust and Python both run: python/tests/test_episode.py compares the rings of the package with the same file. In: a seed
//! and a rule for the actions. Out: rewards and observations of each hold, to the bit.

use codrive::{
    policy::Action,
    rng::{FNV_START, fnv_1a},
    train::{
        ActionKind, AdviceConfig, DriverConfig, FollowKind, RingConfig, TrainConfig, environment::VecEnv,
        rollout::action, simd::LANES,
    },
};
use std::fmt::Write;

/// Expected result of both. After an intended change of the rings, replace it by the output of this test.
const EXPECTED: &str = include_str!("../../python/tests/episode.txt");
const RINGS: usize = 20;

/// Returns eight holds of 1 s with a horizon of 3 s, so that each ring begins a second and a third episode; the drivers are random.
fn config() -> TrainConfig {
    let paper = TrainConfig::paper_ring();
    TrainConfig {
        advice: AdviceConfig { action: ActionKind::Speed, ..paper.advice.clone() },
        ring: RingConfig { warm_up_s: 10.0, horizon_s: 3.0, ..paper.ring.clone() },
        driver: DriverConfig { follow: FollowKind::Driver, ..paper.driver.clone() },
        seed: 7,
        ..paper
    }
}

fn chained<const N: usize>(numbers: impl Iterator<Item = [u8; N]>) -> u64 {
    numbers.fold(FNV_START, |hash, bytes| fnv_1a(hash, &bytes))
}

#[test]
fn the_episode_of_python_is_that_of_rust() {
    let config = config();
    let inputs = config.inputs();
    let block = |index: usize| {
        VecEnv::new(&config, "train", index, config.hold()).with_rings((RINGS - index * LANES).min(LANES))
    };
    let mut blocks: Vec<VecEnv> = (0..RINGS.div_ceil(LANES)).map(block).collect();
    let mut text = String::from(
        "hold, reward of ring 0 and of ring 19, FNV-1a of all rewards (f64) and of all observations (f32)\n",
    );
    for hold in 0..8 {
        let mut rewards: Vec<f64> = Vec::new();
        let mut seen: Vec<f32> = Vec::new();
        for (index, block) in blocks.iter_mut().enumerate() {
            let drawn = |l: usize| (((index * LANES + l) * 7 + hold * 3) % 11) as f32 / 5.0 - 1.0;
            let actions: [Action; LANES] = std::array::from_fn(|l| action(&config, drawn(l), config.hold()));
            let outcomes = block.hold(&actions);
            let rings = (RINGS - index * LANES).min(LANES);
            rewards.extend(outcomes[..rings].iter().map(|outcome| f64::from(outcome.reward)));
            seen.extend(
                (0..rings)
                    .flat_map(|l| inputs.iter().map(move |input| (l, input)))
                    .map(|(l, input)| input.scaled(&block.observe(l))),
            );
        }
        let rewards_hash = chained(rewards.iter().map(|reward| reward.to_le_bytes()));
        let seen_hash = chained(seen.iter().map(|number| number.to_le_bytes()));
        let _ = writeln!(text, "{hold} {:?} {:?} {rewards_hash:016x} {seen_hash:016x}", rewards[0], rewards[19]);
    }
    assert!(text == EXPECTED, "python/tests/episode.txt is not what the rings do now, which is:\n{text}");
}
