//! Linear mixed model with one random intercept per participant, by restricted maximum likelihood (REML). In: participant,
//! terms and response, row by row, or a design and a response. Out: [`MixedModel`]: estimates, variances, and each contrast with its
//! standard error, Satterthwaite's degrees of freedom, p and interval. The same numbers give the same bits.

use super::{
    distributions::{student_bound, student_p},
    mixed_design::{DesignSlope, MixedDesign, ModelFault},
};
use nalgebra::{DMatrix, DVector};

/// A fitted linear mixed model.
#[derive(Clone, Debug, PartialEq)]
pub struct MixedModel {
    /// Estimates: the intercept, then one per term.
    pub estimates: Vec<f64>,
    /// Standard deviation between participants, in the unit of the response.
    pub sd_participant: f64,
    /// Standard deviation within participants, in the unit of the response.
    pub sd_residual: f64,
    /// Residuals by row: the response less the fit and the participant's intercept.
    pub residuals: Vec<f64>,
    /// Predicted deviation of each participant from the intercept.
    pub intercepts: Vec<f64>,
    /// REML criterion: minus two times the restricted log-likelihood, as other programs print it.
    pub criterion: f64,
    inverse: DMatrix<f64>,
    slope: DMatrix<f64>,
    /// Covariance of the estimated variance ratio (between over within) and the variance within: variance of the first,
    /// covariance, variance of the second; `None` if the variance between is 0.
    variances: Option<[f64; 3]>,
    free: f64,
}

/// Estimate of a weighted sum of a model's estimates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContrastEstimate {
    /// Weighted sum of the estimates.
    pub estimate: f64,
    /// Standard error of the sum.
    pub se: f64,
    /// Degrees of freedom by Satterthwaite.
    pub df: f64,
    /// Estimate over standard error.
    pub t: f64,
    /// Two-sided p value of t.
    pub p: f64,
}

impl ContrastEstimate {
    /// Returns the confidence interval of level `1 - alpha`.
    pub fn interval(&self, alpha: f64) -> [f64; 2] {
        let half = student_bound(alpha, self.df) * self.se;
        [self.estimate - half, self.estimate + half]
    }
}

impl MixedModel {
    /// Fits `response` of participants `participant_of_row` (numbers from 0, each with at least one row) on an intercept and `terms`; each
    /// term is a list with one number per row.
    ///
    /// # Errors
    /// There are too few rows, a term depends on others, or nothing varies.
    pub fn fit(participant_of_row: &[usize], terms: &[Vec<f64>], response: &[f64]) -> Result<Self, ModelFault> {
        Self::of_design(&MixedDesign::of(participant_of_row, terms)?, response)
    }

    /// Fits a response with one number per row of the design.
    ///
    /// # Errors
    /// Nothing varies.
    pub(super) fn of_design(design: &MixedDesign, response: &[f64]) -> Result<Self, ModelFault> {
        // The response is centred as the terms are; the intercept gets the means back.
        let middle = response.iter().sum::<f64>() / response.len() as f64;
        let y = DVector::from_iterator(response.len(), response.iter().map(|value| value - middle));
        let best = design.with(&y).best()?;
        let (ratio, free) = (best.ratio, design.free());
        let variance = best.squares[0] / free;
        let left = &y - &design.matrix * &best.estimates;
        let intercepts = design.intercepts(&left, ratio);
        // Back to terms that are not centred: the intercept is a weighted sum of the estimates.
        let p = best.estimates.len();
        let mut back = DMatrix::identity(p, p);
        design.means.iter().enumerate().for_each(|(k, mean)| back[(0, k + 1)] = -mean);
        let mut estimates = &back * &best.estimates;
        estimates[0] += middle;
        let variances = (ratio > 0.0).then(|| {
            let second = best.determinants[1] + best.squares[2] / variance;
            let mixed = -best.squares[1] / variance.powi(2);
            let within = free / variance.powi(2);
            let determinant = second * within - mixed * mixed;
            // Twice the inverse of the second derivatives of the criterion.
            [2.0 * within / determinant, -2.0 * mixed / determinant, 2.0 * second / determinant]
        });
        let DesignSlope { inverse, slope, .. } = best.design;
        Ok(Self {
            estimates: estimates.iter().copied().collect(),
            sd_participant: (ratio * variance).sqrt(),
            sd_residual: variance.sqrt(),
            residuals: left
                .iter()
                .zip(&design.participant_of_row)
                .map(|(value, one)| value - intercepts[*one])
                .collect(),
            intercepts,
            criterion: free * ((2.0 * std::f64::consts::PI * variance).ln() + 1.0) + best.determinants[0],
            slope: &back * (-(&inverse * &slope * &inverse)) * back.transpose(),
            inverse: &back * inverse * back.transpose(),
            variances,
            free,
        })
    }

    /// Returns the sum of the estimates with these weights, one per estimate.
    pub fn contrast(&self, weights: &[f64]) -> ContrastEstimate {
        let l = DVector::from_column_slice(weights);
        let variance = self.sd_residual.powi(2);
        let estimate = weights.iter().zip(&self.estimates).map(|(a, b)| a * b).sum::<f64>();
        let unit = l.dot(&(&self.inverse * &l));
        let by_ratio = variance * l.dot(&(&self.slope * &l));
        let of = variance * unit;
        let df = match self.variances {
            Some([ratio, both, within]) => {
                let spread = by_ratio * by_ratio * ratio + 2.0 * by_ratio * unit * both + unit * unit * within;
                2.0 * of * of / spread
            }
            // All variance is within: the degrees of freedom are those of a regression.
            None => self.free,
        };
        let t = estimate / of.sqrt();
        ContrastEstimate { estimate, se: of.sqrt(), df, t, p: student_p(t, df) }
    }

    /// Returns the estimate of one term; 0 is the intercept.
    pub fn term(&self, k: usize) -> ContrastEstimate {
        let weights: Vec<f64> = (0..self.estimates.len()).map(|i| f64::from(u8::from(i == k))).collect();
        self.contrast(&weights)
    }
}

/// Applies Holm's correction for several tests (Holm 1979): returns each p for comparison with the level of a single test, in
/// the order given.
pub fn holm(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|a, b| p[*a].total_cmp(&p[*b]));
    let mut corrected = vec![0.0; p.len()];
    let mut highest: f64 = 0.0;
    for (done, at) in order.into_iter().enumerate() {
        highest = highest.max(p[at] * (p.len() - done) as f64).min(1.0);
        corrected[at] = highest;
    }
    corrected
}

#[cfg(test)]
#[path = "mixed_model_tests.rs"]
mod tests;
