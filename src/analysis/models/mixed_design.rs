//! Design of a linear mixed model with one random intercept per participant, and its restricted likelihood (REML). In: participant and
//! terms, row by row. Out: `MixedDesign`, computed once for all responses of these rows, and the criterion of a response with its
//! derivatives at any ratio of the variances between and within participants.
//!
//! With a single random intercept the likelihood depends on that one ratio; the other numbers follow in closed form (Bates 2015). Rows are
//! needed only as sums over participants, so that a ratio costs no more than a few small matrices, however many rows there are.

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

/// Sums of the terms over the participants with equally many rows.
struct TermGroup {
    /// Rows of each participant, and number of participants.
    rows: f64,
    count: f64,
    /// Sum over participants of s s', where s is one participant's sums of the terms.
    terms: DMatrix<f64>,
}

/// Participants and terms of a model, without a response.
pub(super) struct MixedDesign {
    pub(super) participant_of_row: Vec<usize>,
    /// Terms, centred, which keeps digits, with the intercept as first column.
    pub(super) matrix: DMatrix<f64>,
    /// Means of the terms before they were centred.
    pub(super) means: Vec<f64>,
    /// Rows and sums of the terms of each participant, and the group of each by its number of rows.
    persons: Vec<(usize, DVector<f64>)>,
    groups: BTreeMap<usize, TermGroup>,
    /// Product of the transposed matrix with itself.
    products: DMatrix<f64>,
    /// The ratios that are tried before the best is refined.
    tried: Vec<DesignAtRatio>,
}

/// Part of the criterion at one ratio that depends on the design only.
struct DesignAtRatio {
    ratio: f64,
    cholesky: Cholesky<f64, Dyn>,
    /// Logarithm of the determinants.
    determinant: f64,
}

/// First derivatives by the ratio that depend on the design only.
pub(super) struct DesignSlope {
    pub(super) inverse: DMatrix<f64>,
    /// Derivative of the matrix of terms, and its product with the inverse.
    pub(super) slope: DMatrix<f64>,
    turned: DMatrix<f64>,
    /// Derivative of the logarithm of the determinants.
    determinant: f64,
}

/// A response with its sums over a design's rows.
pub(super) struct ResponseSums<'a> {
    design: &'a MixedDesign,
    /// For each group of the design: sums over participants of s t and t t, where s and t are one participant's sums of terms and response.
    groups: Vec<(DVector<f64>, f64)>,
    cross: DVector<f64>,
    squares: f64,
}

/// Number of ratios tried before the best is refined: standard deviation between over within from 0 to 3540.
const TRIED: usize = 60;
/// Sine of the angle between a term and the space of the terms before it, at or below which the term depends on them.
const ALIASED: f64 = 1e-7;

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

impl MixedDesign {
    /// Returns the design of participants `participant_of_row` (numbers from 0, each with at least one row) with an intercept and `terms`;
    /// each term is a list with one number per row.
    ///
    /// # Errors
    /// There are too few rows, or a term depends on others.
    pub(super) fn of(participant_of_row: &[usize], terms: &[Vec<f64>]) -> Result<Self, ModelFault> {
        let rows = participant_of_row.len();
        let participants = participant_of_row.iter().max().map_or(0, |most| most + 1);
        let p = terms.len() + 1;
        if participants < 2 || rows <= participants.max(p + 1) {
            return Err(ModelFault::TooFew { rows, participants });
        }
        let means: Vec<f64> = terms.iter().map(|term| term.iter().sum::<f64>() / rows as f64).collect();
        let matrix = DMatrix::from_fn(rows, p, |row, k| if k == 0 { 1.0 } else { terms[k - 1][row] - means[k - 1] });
        if let Some(term) = aliased(&matrix) {
            return Err(ModelFault::Aliased { term: term - 1 });
        }
        let mut persons = vec![(0, DVector::zeros(p)); participants];
        for (row, person) in participant_of_row.iter().enumerate() {
            persons[*person].0 += 1;
            persons[*person].1 += matrix.row(row).transpose();
        }
        let mut groups: BTreeMap<usize, TermGroup> = BTreeMap::new();
        for (n, terms) in persons.iter().filter(|person| person.0 > 0) {
            let group = groups.entry(*n).or_insert_with(|| TermGroup {
                rows: *n as f64,
                count: 0.0,
                terms: DMatrix::zeros(p, p),
            });
            group.count += 1.0;
            group.terms += terms * terms.transpose();
        }
        let products = matrix.transpose() * &matrix;
        let participant_of_row = participant_of_row.to_vec();
        let mut design = Self { participant_of_row, matrix, means, persons, groups, products, tried: Vec::new() };
        design.tried = (0..TRIED).map(|i| design.at(tried_ratio(i))).collect();
        Ok(design)
    }

    /// Returns the number of rows less the number of estimates.
    pub(super) fn free(&self) -> f64 {
        self.matrix.nrows() as f64 - self.matrix.ncols() as f64
    }

    /// Returns the predicted deviation of each participant from the intercept: residuals of the rows, at a ratio of the variances.
    pub(super) fn intercepts(&self, left: &DVector<f64>, ratio: f64) -> Vec<f64> {
        let mut departures = vec![(0.0, 0.0); self.persons.len()];
        for (person, value) in self.participant_of_row.iter().zip(left.iter()) {
            departures[*person].0 += value;
            departures[*person].1 += 1.0;
        }
        departures.iter().map(|(sum, n)| ratio / (1.0 + n * ratio) * sum).collect()
    }

    /// Returns the sums of a response with one number per row, less its mean.
    pub(super) fn with(&self, response: &DVector<f64>) -> ResponseSums<'_> {
        let mut of_person = vec![0.0; self.persons.len()];
        self.participant_of_row.iter().zip(response).for_each(|(person, value)| of_person[*person] += value);
        let empty = || (DVector::zeros(self.matrix.ncols()), 0.0);
        let mut groups: BTreeMap<usize, (DVector<f64>, f64)> = self.groups.keys().map(|n| (*n, empty())).collect();
        for ((n, terms), sum) in self.persons.iter().zip(of_person) {
            if let Some(group) = groups.get_mut(n) {
                group.0 += terms * sum;
                group.1 += sum * sum;
            }
        }
        ResponseSums {
            design: self,
            groups: groups.into_values().collect(),
            cross: self.matrix.transpose() * response,
            squares: response.norm_squared(),
        }
    }

    fn at(&self, ratio: f64) -> DesignAtRatio {
        let mut terms = self.products.clone();
        let mut determinant = 0.0;
        for group in self.groups.values() {
            let grown = 1.0 + group.rows * ratio;
            terms.zip_apply(&group.terms, |sum, term| *sum -= term * (ratio / grown));
            determinant += group.count * grown.ln();
        }
        let cholesky: Cholesky<f64, Dyn> = Cholesky::new(terms).expect("columns are independent: looked at before");
        determinant += 2.0 * cholesky.l_dirty().diagonal().iter().map(|x| x.ln()).sum::<f64>();
        DesignAtRatio { ratio, cholesky, determinant }
    }

    fn slope(&self, at: &DesignAtRatio) -> DesignSlope {
        let p = self.matrix.ncols();
        let (mut slope, mut determinant) = (DMatrix::zeros(p, p), 0.0);
        for group in self.groups.values() {
            let grown = 1.0 + group.rows * at.ratio;
            slope.zip_apply(&group.terms, |sum, term| *sum += term * (-1.0 / (grown * grown)));
            determinant += group.count * (group.rows / grown);
        }
        let inverse = at.cholesky.inverse();
        let turned = &inverse * &slope;
        determinant += turned.trace();
        DesignSlope { inverse, slope, turned, determinant }
    }
}

/// Returns the place between `low` and `high` where a function that rises crosses zero, to 13 digits; an end if it does not cross zero. By the
/// ITP method (Oliveira 2020): no more steps than halving takes but two, and a few where the function is smooth.
fn rising_root(mut low: f64, mut high: f64, function: impl Fn(f64) -> f64) -> f64 {
    let (mut at_low, mut at_high) = (function(low), function(high));
    if at_low >= 0.0 || at_high <= 0.0 {
        return if at_low >= 0.0 { low } else { high };
    }
    let exact = 0.5e-13 * high;
    let halvings = ((high - low) / (2.0 * exact)).log2().ceil();
    let pull = 0.2 / (high - low);
    let mut most = exact * (halvings + 1.0).exp2();
    while high - low > 2.0 * exact {
        let middle = 0.5 * (low + high);
        let secant = (high * at_low - low * at_high) / (at_low - at_high);
        let towards = (middle - secant).signum();
        let step = pull * (high - low).powi(2);
        let cut = if step <= (middle - secant).abs() { secant + towards * step } else { middle };
        // No further from the middle than halving allows.
        let reach = (most - 0.5 * (high - low)).max(0.0);
        let tried = if (cut - middle).abs() <= reach { cut } else { middle - towards * reach };
        match function(tried) {
            0.0 => return tried,
            value if value > 0.0 => (high, at_high) = (tried, value),
            value => (low, at_low) = (tried, value),
        }
        most *= 0.5;
    }
    0.5 * (low + high)
}

/// Returns ratio `i` of those that are tried, up to `TRIED`.
fn tried_ratio(i: usize) -> f64 {
    let share = i as f64 / TRIED as f64;
    (share / (1.0 - share).powi(2)).powi(2)
}

/// A response's criterion at the ratio with the largest restricted likelihood.
pub(super) struct BestRatio {
    pub(super) ratio: f64,
    pub(super) estimates: DVector<f64>,
    /// Weighted sum of squared residuals, and its first two derivatives.
    pub(super) squares: [f64; 3],
    /// Logarithm of the determinants, and its second derivative.
    pub(super) determinants: [f64; 2],
    pub(super) design: DesignSlope,
}

impl ResponseSums<'_> {
    /// Returns the estimates at a ratio, and the weighted sum of squared residuals.
    fn solved(&self, at: &DesignAtRatio) -> (DVector<f64>, f64) {
        let mut cross = self.cross.clone();
        let mut squares = self.squares;
        for (group, sums) in self.design.groups.values().zip(&self.groups) {
            let grown = 1.0 + group.rows * at.ratio;
            cross -= &sums.0 * (at.ratio / grown);
            squares -= sums.1 * at.ratio / grown;
        }
        let estimates = at.cholesky.solve(&cross);
        let left = (squares - cross.dot(&estimates)).max(0.0);
        (estimates, left)
    }

    /// Returns the first two derivatives of the sum of squared residuals; the second lacks the part by which the estimates change, whose
    /// direction is the last value.
    fn squares_slope(&self, ratio: f64, estimates: &DVector<f64>) -> ([f64; 2], DVector<f64>) {
        let mut squares = [0.0; 2];
        let mut pull = DVector::zeros(estimates.len());
        for (group, sums) in self.design.groups.values().zip(&self.groups) {
            let grown = 1.0 + group.rows * ratio;
            let (first, second) = (-1.0 / (grown * grown), 2.0 * group.rows / grown.powi(3));
            let by_terms = &group.terms * estimates;
            let departures = sums.1 - 2.0 * estimates.dot(&sums.0) + estimates.dot(&by_terms);
            squares[0] += first * departures;
            squares[1] += second * departures;
            pull += (&sums.0 - by_terms) * first;
        }
        (squares, pull)
    }

    /// Returns the first derivative of the criterion by the ratio.
    fn criterion_slope(&self, ratio: f64) -> f64 {
        let at = self.design.at(ratio);
        let (estimates, squares) = self.solved(&at);
        let ([slope, _], _) = self.squares_slope(ratio, &estimates);
        self.design.free() * slope / squares + self.design.slope(&at).determinant
    }

    /// Returns the criterion at the best ratio.
    ///
    /// # Errors
    /// Nothing varies within participants.
    pub(super) fn best(&self) -> Result<BestRatio, ModelFault> {
        let ratio = self.best_ratio().ok_or(ModelFault::NoVariation)?;
        let at = self.design.at(ratio);
        let (estimates, left) = self.solved(&at);
        let ([slope, mut bend], pull) = self.squares_slope(ratio, &estimates);
        let design = self.design.slope(&at);
        bend -= 2.0 * pull.dot(&(&design.inverse * &pull));
        let p = estimates.len();
        let (mut terms, mut determinant) = (DMatrix::zeros(p, p), 0.0);
        for group in self.design.groups.values() {
            let grown = 1.0 + group.rows * ratio;
            let share = group.rows / grown;
            terms += &group.terms * (2.0 * group.rows / grown.powi(3));
            determinant -= group.count * share * share;
        }
        determinant += (&design.inverse * terms).trace() - (&design.turned * &design.turned).trace();
        Ok(BestRatio {
            ratio,
            estimates,
            squares: [left, slope, bend],
            determinants: [at.determinant, determinant],
            design,
        })
    }

    /// Returns the ratio with the largest restricted likelihood; `None` if there is no variance within.
    fn best_ratio(&self) -> Option<f64> {
        let free = self.design.free();
        let left: Vec<f64> = self.design.tried.iter().map(|at| self.solved(at).1).collect();
        if left[0] <= 1e-20 * self.squares.max(f64::MIN_POSITIVE) {
            return None;
        }
        let values: Vec<f64> =
            left.iter().zip(&self.design.tried).map(|(left, at)| free * (left / free).ln() + at.determinant).collect();
        let best = (0..TRIED).min_by(|a, b| values[*a].total_cmp(&values[*b]))?;
        if best == TRIED - 1 {
            return None;
        }
        let (low, high) = (tried_ratio(best.saturating_sub(1)), tried_ratio(best + 1));
        Some(rising_root(low, high, |ratio| self.criterion_slope(ratio)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    #[test]
    fn a_root_is_found_to_13_digits_in_no_more_steps_than_halving() {
        let root = |function: &dyn Fn(f64) -> f64| {
            let steps = Cell::new(0);
            let counted = |x: f64| {
                steps.set(steps.get() + 1);
                function(x)
            };
            (rising_root(0.0, 2.0, counted), steps.get())
        };
        // Halving takes 44 steps from 2 to 2e-13; the ends, one step more, and one for rounding are allowed.
        for (function, exact) in [
            (&(|x: f64| x * x - 2.0) as &dyn Fn(f64) -> f64, 2.0_f64.sqrt()),
            (&|x: f64| x.exp() - 1.0001, 1.0001_f64.ln()),
            (&|x: f64| (x - 0.3).powi(9), 0.3),
            (&|x: f64| if x < 1.7 { -1e-9 } else { 1e9 }, 1.7),
        ] {
            let (found, steps) = root(function);
            assert!((found - exact).abs() <= 1e-13 * 2.0, "{found} is not {exact}");
            assert!(steps <= 44 + 4, "{steps} steps to {exact}");
        }
        assert!(root(&|x: f64| x * x - 2.0).1 < 15, "a smooth function takes a third of halving's steps");
        assert_eq!((root(&|x: f64| x + 1.0).0, root(&|x: f64| x - 3.0).0), (0.0, 2.0), "no root");
    }
}
