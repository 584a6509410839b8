//! The update against finite differences and against its bound.

use super::{
    distribution::DistributionFamily,
    net::Shape,
    scalar::SimdFloat,
    trpo::{Batch, Decision, PolicyShape, TrustRegion, TrustRegionSettings, advantages, conjugate_gradient},
};
use crate::rng;

const ROWS: usize = 1200;

fn policy<T: SimdFloat>(family: DistributionFamily) -> (PolicyShape, Vec<T>, Batch<T>) {
    let shape = PolicyShape { net: Shape::new(&[4, 8, 6, family.outputs()]), family };
    let mut stream = rng::stream(2, "trpo");
    let mut theta: Vec<T> = shape.net.orthogonal(0.5, &mut stream);
    theta.resize(shape.parameters(), T::of(-0.3));
    let mut normals = |n: usize| (0..n).map(|_| stream.normal()).collect::<Vec<f64>>();
    let inputs: Vec<T> = normals(4 * ROWS).into_iter().map(T::of).collect();
    let actions = normals(ROWS).into_iter().map(|x| match family {
        DistributionFamily::Normal => T::of(x),
        DistributionFamily::Levels(n) => T::of((x.abs() * 10.0).floor() % n as f64),
    });
    let actions = actions.collect();
    let advantages = normals(ROWS);
    (shape, theta, Batch { inputs, actions, advantages })
}

fn moved(theta: &[f64], way: &[f64], by: f64) -> Vec<f64> {
    theta.iter().zip(way).map(|(t, w)| t + by * w).collect()
}

fn ways(n: usize) -> Vec<Vec<f64>> {
    let mut stream = rng::stream(3, "ways");
    (0..4).map(|_| (0..n).map(|_| stream.normal()).collect()).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[test]
fn the_policy_gradient_equals_finite_differences() {
    for family in [DistributionFamily::Normal, DistributionFamily::Levels(5)] {
        let (shape, theta, batch) = policy::<f64>(family);
        let region = TrustRegion::new(&shape, &theta, &batch);
        let gradient = region.gradient();
        for i in 0..theta.len() {
            let mut way = vec![0.0; theta.len()];
            way[i] = 1.0;
            let at = |by: f64| region.compare(&moved(&theta, &way, by)).0;
            let difference = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!((gradient[i] - difference).abs() < 1e-8, "{family:?} {i}: {} {difference}", gradient[i]);
        }
    }
}

#[test]
fn the_fisher_product_is_the_second_difference_of_the_divergence() {
    for family in [DistributionFamily::Normal, DistributionFamily::Levels(5)] {
        let (shape, theta, batch) = policy::<f64>(family);
        let region = TrustRegion::new(&shape, &theta, &batch);
        let divergence = |way: &[f64]| {
            let at = |by: f64| region.compare(&moved(&theta, way, by)).1;
            (at(1e-4) + at(-1e-4)) / 1e-8
        };
        let ways = ways(theta.len());
        for pair in ways.windows(2) {
            let (u, v) = (&pair[0], &pair[1]);
            let both: Vec<f64> = u.iter().zip(v).map(|(a, b)| a + b).collect();
            // Polarisation: u F v from three squares, which tests the product off its diagonal as well.
            let expected = (divergence(&both) - divergence(u) - divergence(v)) / 2.0;
            let product = dot(u, &region.fisher_product(v, 0.0));
            let scale = divergence(u) + divergence(v);
            assert!((product - expected).abs() < 1e-4 * scale, "{family:?}: {product} {expected}");
            let damped = dot(u, &region.fisher_product(v, 0.1));
            assert!((damped - product - 0.1 * dot(u, v)).abs() < 1e-9);
        }
    }
}

#[test]
fn conjugate_gradients_solve_a_small_system_exactly() {
    let matrix = [[4.0, 1.0, 0.0], [1.0, 3.0, 0.5], [0.0, 0.5, 2.0]];
    let product = |v: &[f64]| matrix.iter().map(|row| dot(row, v)).collect::<Vec<_>>();
    let x = conjugate_gradient(product, &[1.0, -2.0, 3.0], 3);
    for (ax, b) in product(&x).iter().zip([1.0, -2.0, 3.0]) {
        assert!((ax - b).abs() < 1e-10);
    }
}

#[test]
fn every_accepted_step_keeps_the_bound_and_gains() {
    for family in [DistributionFamily::Normal, DistributionFamily::Levels(5)] {
        let (shape, mut theta, mut batch) = policy::<f32>(family);
        let mut stream = rng::stream(4, "advantages");
        for round in 0..20 {
            let fisher_every = 1 + round % 2 * 4;
            let region = TrustRegionSettings { max_kl: 0.01, cg_steps: 10, damping: 0.1, fisher_every, backtracks: 10 };
            batch.advantages = (0..ROWS).map(|_| stream.normal()).collect();
            let before = theta.clone();
            let update = shape.update(&mut theta, &batch, &region);
            assert!(update.halvings.is_some() && update.gain > 0.0, "{update:?}");
            assert!(update.kl > 0.0 && update.kl <= 0.01, "{update:?}");
            let (gain, kl) = TrustRegion::new(&shape, &before, &batch).compare(&theta);
            assert_eq!((gain, kl), (update.gain, update.kl));
        }
    }
}

#[test]
fn a_part_of_the_batch_with_all_its_distinct_rows_gives_the_same_update() {
    let (shape, theta, batch) = policy::<f64>(DistributionFamily::Normal);
    let three_times = Batch {
        inputs: batch.inputs.chunks(4).flat_map(|row| row.repeat(3)).collect(),
        actions: batch.actions.iter().flat_map(|a| [*a; 3]).collect(),
        advantages: batch.advantages.iter().flat_map(|a| [*a; 3]).collect(),
    };
    let after = |batch: &Batch<f64>, fisher_every| {
        let region = TrustRegionSettings { max_kl: 0.01, cg_steps: 10, damping: 0.1, fisher_every, backtracks: 10 };
        let mut theta = theta.clone();
        shape.update(&mut theta, batch, &region);
        theta
    };
    let difference = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let (whole, part) = (after(&batch, 1), after(&three_times, 3));
    assert!(difference(&whole, &theta) > 1e-3, "the update moves");
    assert!(difference(&whole, &part) < 1e-9, "{}", difference(&whole, &part));
    assert!(difference(&whole, &after(&batch, 3)) > 1e-6, "a third of rows that differ says something else");
}

#[test]
fn an_update_has_the_same_bits_with_any_number_of_threads() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let (shape, mut theta, batch) = policy::<f32>(DistributionFamily::Normal);
            let region =
                TrustRegionSettings { max_kl: 0.01, cg_steps: 10, damping: 0.1, fisher_every: 1, backtracks: 10 };
            shape.update(&mut theta, &batch, &region);
            theta.into_iter().map(f32::to_bits).collect::<Vec<_>>()
        })
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(5));
}

#[test]
fn advantages_are_discounted_sums_of_residuals_within_an_episode() {
    let d = |reward, value, next_value, last| Decision { reward, value, next_value, last };
    let decisions = [d(1.0, 0.5, 0.7, false), d(2.0, 0.7, 0.2, true), d(3.0, 0.1, 0.4, false)];
    let (gamma, lambda) = (0.9, 0.8);
    let delta = [1.0 + 0.63 - 0.5, 2.0 + 0.18 - 0.7, 3.0 + 0.36 - 0.1];
    let found = advantages(&decisions, gamma, lambda);
    assert!((found[2] - delta[2]).abs() < 1e-12);
    assert!((found[1] - delta[1]).abs() < 1e-12);
    assert!((found[0] - (delta[0] + 0.72 * delta[1])).abs() < 1e-12);
    // With lambda 1 the advantage is the discounted return minus the value, for any values in between.
    let found = advantages(&[d(1.0, 0.5, 0.7, false), d(2.0, 0.7, 0.0, true)], gamma, 1.0);
    assert!((found[0] - (1.0 + 0.9 * 2.0 - 0.5)).abs() < 1e-12);
}
