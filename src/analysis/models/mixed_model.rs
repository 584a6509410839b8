//! Linear mixed model with one random intercept per participant, by restricted maximum likelihood (REML). In: participant,
//! terms and response, row by row. Out: [`MixedModel`]: estimates, variances, and each contrast with its standard error,
//! Satterthwaite's degrees of freedom, p and interval. The same numbers give the same bits.
//!
//! With a single random intercept the likelihood depends on one ratio, of the variances between and within participants; the
//! other numbers follow in closed form (Bates 2015). Rows are needed only as sums over participants, so that a fit costs no
//! more than a few hundred small matrices, however many rows there are.

use super::distributions::{student_bound, student_p};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use std::collections::BTreeMap;

/// Reason why a model cannot be fitted.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ModelFault {
    /// Fewer than two participants, or too few rows: no more than participants, or than estimates plus one.
    #[error("too few observations for a model: {rows} of {participants} participants")]
    TooFew {
        /// Number of rows of the data.
        rows: usize,
        /// Number of participants in these rows.
        participants: usize,
    },
    /// A term that is a linear combination of the terms before it.
    #[error("the term {term} cannot be separated from the terms before it")]
    Aliased {
        /// Position among the terms, from 0.
        term: usize,
    },
    /// No variation left: terms and participants explain every value, or all values are equal.
    #[error("the data do not vary within participants beyond the terms of the model")]
    NoVariation,
}

/// Sums over the participants with equally many rows.
struct GroupSums {
    /// Rows of each participant, and number of participants.
    rows: f64,
    count: f64,
    /// Sums over participants of s s', s t and t t, where s and t are one participant's sums of terms and response.
    terms: DMatrix<f64>,
    cross: DVector<f64>,
    response: f64,
}

/// Sums of the rows that a fit needs.
struct RowSums {
    groups: Vec<GroupSums>,
    terms: DMatrix<f64>,
    cross: DVector<f64>,
    response: f64,
    rows: f64,
}

/// REML criterion at one ratio of variances, with derivatives by the ratio.
struct AtRatio {
    inverse: DMatrix<f64>,
    estimates: DVector<f64>,
    /// Weighted sum of squared residuals, and its first two derivatives.
    squares: [f64; 3],
    /// Logarithms of determinants, and their first two derivatives.
    determinants: [f64; 3],
    /// Derivative of the matrix of terms.
    slope: DMatrix<f64>,
}

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

/// Number of ratios tried before the best is refined: standard deviation between over within from 0 to 3540.
const TRIED: usize = 60;
/// Sine of the angle between a term and the space of the terms before it, at or below which the term depends on them.
const ALIASED: f64 = 1e-7;

impl MixedModel {
    /// Fits `response` of participants `participant_of_row` (numbers from 0, each with at least one row) on an intercept and `terms`; each
    /// term is a list with one number per row.
    ///
    /// # Errors
    /// There are too few rows, a term depends on others, or nothing varies.
    pub fn fit(participant_of_row: &[usize], terms: &[Vec<f64>], response: &[f64]) -> Result<Self, ModelFault> {
        let (rows, participants) = (response.len(), participant_of_row.iter().max().map_or(0, |most| most + 1));
        let p = terms.len() + 1;
        if participants < 2 || rows <= participants.max(p + 1) {
            return Err(ModelFault::TooFew { rows, participants });
        }
        // Terms and response are centred, which keeps digits; the intercept gets the means back.
        let mean = |values: &[f64]| values.iter().sum::<f64>() / rows as f64;
        let means: Vec<f64> = terms.iter().map(|term| mean(term)).collect();
        let middle = mean(response);
        let matrix = DMatrix::from_fn(rows, p, |row, k| if k == 0 { 1.0 } else { terms[k - 1][row] - means[k - 1] });
        if let Some(term) = aliased(&matrix) {
            return Err(ModelFault::Aliased { term: term - 1 });
        }
        let y = DVector::from_iterator(rows, response.iter().map(|value| value - middle));
        let sums = RowSums::of(participant_of_row, participants, &matrix, &y);
        let ratio = sums.best().ok_or(ModelFault::NoVariation)?;
        let at = sums.at(ratio);
        let free = sums.rows - p as f64;
        let variance = at.squares[0] / free;
        let fitted = &matrix * &at.estimates;
        let left = &y - &fitted;
        let mut departures = vec![(0.0, 0.0); participants];
        for (person, value) in participant_of_row.iter().zip(left.iter()) {
            departures[*person].0 += value;
            departures[*person].1 += 1.0;
        }
        let intercepts: Vec<f64> = departures.iter().map(|(sum, n)| ratio / (1.0 + n * ratio) * sum).collect();
        // Back to terms that are not centred: the intercept is a weighted sum of the estimates.
        let mut back = DMatrix::identity(p, p);
        means.iter().enumerate().for_each(|(k, mean)| back[(0, k + 1)] = -mean);
        let mut estimates = &back * &at.estimates;
        estimates[0] += middle;
        let variances = (ratio > 0.0).then(|| {
            let second = at.determinants[2] + at.squares[2] / variance;
            let mixed = -at.squares[1] / variance.powi(2);
            let within = free / variance.powi(2);
            let determinant = second * within - mixed * mixed;
            // Twice the inverse of the second derivatives of the criterion.
            [2.0 * within / determinant, -2.0 * mixed / determinant, 2.0 * second / determinant]
        });
        Ok(Self {
            estimates: estimates.iter().copied().collect(),
            sd_participant: (ratio * variance).sqrt(),
            sd_residual: variance.sqrt(),
            residuals: left.iter().zip(participant_of_row).map(|(value, person)| value - intercepts[*person]).collect(),
            intercepts,
            criterion: free * ((2.0 * std::f64::consts::PI * variance).ln() + 1.0) + at.determinants[0],
            slope: &back * (-(&at.inverse * &at.slope * &at.inverse)) * back.transpose(),
            inverse: &back * at.inverse * back.transpose(),
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

/// Returns the first column that depends on the columns before it.
fn aliased(matrix: &DMatrix<f64>) -> Option<usize> {
    let mut basis: Vec<DVector<f64>> = Vec::new();
    for (k, column) in matrix.column_iter().enumerate() {
        let mut rest = column.into_owned();
        let length = rest.norm();
        for direction in &basis {
            let share = direction.dot(&rest);
            rest -= direction * share;
        }
        let left = rest.norm();
        if left.is_nan() || left <= ALIASED * length || length == 0.0 {
            return Some(k);
        }
        basis.push(rest / left);
    }
    None
}

impl RowSums {
    fn of(participant_of_row: &[usize], participants: usize, matrix: &DMatrix<f64>, y: &DVector<f64>) -> Self {
        let p = matrix.ncols();
        let mut persons = vec![(0_usize, DVector::zeros(p), 0.0); participants];
        for (row, person) in participant_of_row.iter().enumerate() {
            let sums = &mut persons[*person];
            sums.0 += 1;
            sums.1 += matrix.row(row).transpose();
            sums.2 += y[row];
        }
        let mut groups: BTreeMap<usize, GroupSums> = BTreeMap::new();
        for (n, terms, response) in persons.into_iter().filter(|person| person.0 > 0) {
            let group = groups.entry(n).or_insert_with(|| GroupSums {
                rows: n as f64,
                count: 0.0,
                terms: DMatrix::zeros(p, p),
                cross: DVector::zeros(p),
                response: 0.0,
            });
            group.count += 1.0;
            group.terms += &terms * terms.transpose();
            group.cross += &terms * response;
            group.response += response * response;
        }
        Self {
            groups: groups.into_values().collect(),
            terms: matrix.transpose() * matrix,
            cross: matrix.transpose() * y,
            response: y.norm_squared(),
            rows: y.len() as f64,
        }
    }

    /// Evaluates the criterion at one ratio of the variance between participants over that within.
    fn at(&self, ratio: f64) -> AtRatio {
        let p = self.cross.len();
        let mut terms = self.terms.clone();
        let mut cross = self.cross.clone();
        let mut response = self.response;
        let mut determinants = [0.0; 3];
        for group in &self.groups {
            let grown = 1.0 + group.rows * ratio;
            terms -= &group.terms * (ratio / grown);
            cross -= &group.cross * (ratio / grown);
            response -= group.response * ratio / grown;
            let share = group.rows / grown;
            determinants[0] += group.count * grown.ln();
            determinants[1] += group.count * share;
            determinants[2] -= group.count * share * share;
        }
        let cholesky: Cholesky<f64, Dyn> = Cholesky::new(terms).expect("columns are independent: looked at before");
        let estimates = cholesky.solve(&cross);
        let inverse = cholesky.inverse();
        determinants[0] += 2.0 * cholesky.l_dirty().diagonal().iter().map(|x| x.ln()).sum::<f64>();
        let (mut slope, mut bend) = (DMatrix::zeros(p, p), DMatrix::zeros(p, p));
        let mut squares = [(response - cross.dot(&estimates)).max(0.0), 0.0, 0.0];
        let mut pull = DVector::zeros(p);
        for group in &self.groups {
            let grown = 1.0 + group.rows * ratio;
            let (first, second) = (-1.0 / (grown * grown), 2.0 * group.rows / grown.powi(3));
            let by_terms = &group.terms * &estimates;
            let departures = group.response - 2.0 * estimates.dot(&group.cross) + estimates.dot(&by_terms);
            slope += &group.terms * first;
            bend += &group.terms * second;
            squares[1] += first * departures;
            squares[2] += second * departures;
            pull += (&group.cross - by_terms) * first;
        }
        squares[2] -= 2.0 * pull.dot(&(&inverse * &pull));
        let turned = &inverse * &slope;
        determinants[1] += turned.trace();
        determinants[2] += (&inverse * bend).trace() - (&turned * &turned).trace();
        AtRatio { inverse, estimates, squares, determinants, slope }
    }

    /// Returns the ratio with the largest restricted likelihood; `None` if there is no variance within.
    fn best(&self) -> Option<f64> {
        let free = self.rows - self.cross.len() as f64;
        let ratio_of = |i: usize| {
            let share = i as f64 / TRIED as f64;
            (share / (1.0 - share).powi(2)).powi(2)
        };
        let value = |ratio: f64| {
            let at = self.at(ratio);
            free * (at.squares[0] / free).ln() + at.determinants[0]
        };
        let rises = |ratio: f64| {
            let at = self.at(ratio);
            free * at.squares[1] / at.squares[0] + at.determinants[1] > 0.0
        };
        let least = self.at(0.0).squares[0];
        if least <= 1e-20 * self.response.max(f64::MIN_POSITIVE) {
            return None;
        }
        let best = (0..TRIED).min_by(|a, b| value(ratio_of(*a)).total_cmp(&value(ratio_of(*b))))?;
        if best == TRIED - 1 {
            return None;
        }
        let (mut low, mut high) = (ratio_of(best.saturating_sub(1)), ratio_of(best + 1));
        if best == 0 && rises(0.0) {
            return Some(0.0);
        }
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            if high - low <= 1e-13 * high {
                break;
            }
            if rises(middle) { high = middle } else { low = middle }
        }
        Some(0.5 * (low + high))
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
