//! Relation between latents and traits, used to evaluate an encoder trained without traits. In: drivers with their traits and latents.
//! Out: the linear function of the latents that fits each trait best, with its residual.

use crate::policy::{
    DriverEstimate, DriverTraits, LatentEstimate,
    identification::{MOST_LATENTS, TRAITS},
};

/// Variance added to each latent, so that a constant latent does no harm.
const LEAST_VARIANCE: f64 = 1e-9;

/// A linear function of the latents for each trait, fitted by least squares.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatentTraits {
    centre: [f64; MOST_LATENTS],
    mean: [f64; TRAITS],
    /// Change of each trait per unit of each latent.
    slopes: [[f64; MOST_LATENTS]; TRAITS],
    /// Standard deviation of each trait's residual.
    sd: [f64; TRAITS],
}

impl LatentTraits {
    /// Returns the least-squares fit to these drivers.
    pub fn of(drivers: &[(DriverTraits, LatentEstimate)]) -> Self {
        let n = drivers.len().max(1) as f64;
        let over = |of: &dyn Fn(&(DriverTraits, LatentEstimate)) -> f64| drivers.iter().map(of).sum::<f64>() / n;
        let centre: [f64; MOST_LATENTS] = std::array::from_fn(|k| over(&|(_, latents)| latents.mean[k]));
        let mean: [f64; TRAITS] = std::array::from_fn(|j| over(&|(traits, _)| traits.numbers()[j]));
        let off = |latents: &LatentEstimate, k: usize| latents.mean[k] - centre[k];
        let covariance: [[f64; MOST_LATENTS]; MOST_LATENTS] = std::array::from_fn(|a| {
            std::array::from_fn(|b| {
                let least = if a == b { LEAST_VARIANCE } else { 0.0 };
                least + over(&|(_, latents)| off(latents, a) * off(latents, b))
            })
        });
        let slopes: [[f64; MOST_LATENTS]; TRAITS] = std::array::from_fn(|j| {
            let with_trait = std::array::from_fn(|k| over(&|(traits, latents)| off(latents, k) * traits.numbers()[j]));
            solved(covariance, with_trait)
        });
        let mut fit = Self { centre, mean, slopes, sd: [0.0; TRAITS] };
        fit.sd = std::array::from_fn(|j| {
            over(&|(traits, latents)| (traits.numbers()[j] - fit.numbers(latents)[j]).powi(2)).sqrt()
        });
        fit
    }

    fn numbers(&self, latents: &LatentEstimate) -> [f64; TRAITS] {
        std::array::from_fn(|j| {
            let slopes = self.slopes[j].iter().zip(latents.mean).zip(self.centre);
            self.mean[j] + slopes.map(|((slope, mean), centre)| slope * (mean - centre)).sum::<f64>()
        })
    }

    /// Returns the traits that these latents predict.
    pub fn traits(&self, latents: &LatentEstimate) -> DriverEstimate {
        DriverEstimate { mean: DriverTraits::of(self.numbers(latents)), sd: DriverTraits::of(self.sd) }
    }
}

/// Solves `a x = b` for a positive definite `a` by Gaussian elimination (such a matrix needs no pivots).
fn solved(mut a: [[f64; MOST_LATENTS]; MOST_LATENTS], mut b: [f64; MOST_LATENTS]) -> [f64; MOST_LATENTS] {
    for i in 0..MOST_LATENTS {
        for j in i + 1..MOST_LATENTS {
            let share = a[j][i] / a[i][i];
            let above = a[i];
            a[j].iter_mut().zip(above).for_each(|(below, above)| *below -= share * above);
            b[j] -= share * b[i];
        }
    }
    for i in (0..MOST_LATENTS).rev() {
        let known: f64 = (i + 1..MOST_LATENTS).map(|k| a[i][k] * b[k]).sum();
        b[i] = (b[i] - known) / a[i][i];
    }
    b
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng;

    #[test]
    fn a_linear_relation_is_found_and_an_unrelated_trait_stays_unexplained() {
        let mut stream = rng::stream(1, "latents");
        let driver = |_| {
            let (x, y) = (stream.normal(), 0.5 * stream.normal());
            let latents = LatentEstimate { count: 2, mean: [x + 3.0, y - x, 0.0, 0.0], sd: [0.1; MOST_LATENTS] };
            // Traits depend on the first latent or on both; the error depends on neither.
            let error_mps = 0.2 * stream.normal();
            let traits = DriverTraits {
                reaction_s: 1.0 + 0.3 * y,
                speed_bias_mps: 2.0 * x,
                error_mps,
                ..DriverTraits::default()
            };
            (traits, latents)
        };
        let drivers: Vec<(DriverTraits, LatentEstimate)> = (0..500).map(driver).collect();
        let fit = LatentTraits::of(&drivers);
        for (traits, latents) in &drivers {
            let estimate = fit.traits(latents).mean;
            assert!((estimate.speed_bias_mps - traits.speed_bias_mps).abs() < 1e-6);
            assert!((estimate.reaction_s - traits.reaction_s).abs() < 1e-6 && estimate.error_mps.abs() < 0.1);
            assert!((estimate.willingness - 1.0).abs() < 1e-9);
        }
        let sd = fit.traits(&drivers[0].1).sd;
        assert!(sd.speed_bias_mps < 1e-6 && (sd.error_mps - 0.2).abs() < 0.02, "{sd:?}");
    }
}
