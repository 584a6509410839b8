//! The mixed model against closed forms. `tests/studies/models.rs` compares it with another program.

use super::*;
use crate::rng;

/// Returns participants with one row per condition: the response is a sum of condition, person and noise.
fn balanced(persons: usize, conditions: usize, sd_person: f64) -> (Vec<usize>, Vec<Vec<f64>>, Vec<f64>) {
    let mut stream = rng::stream(5, "balanced");
    let (mut participant_of_row, mut response) = (Vec::new(), Vec::new());
    let mut terms = vec![Vec::new(); conditions - 1];
    for person in 0..persons {
        let own = sd_person * stream.normal();
        for condition in 0..conditions {
            participant_of_row.push(person);
            (1..conditions).for_each(|k| terms[k - 1].push(f64::from(u8::from(k == condition))));
            response.push(20.0 + 0.5 * condition as f64 + own + stream.normal());
        }
    }
    (participant_of_row, terms, response)
}

/// With each person in each condition once, the variances match the analysis of variance. A difference of conditions has
/// the residual's degrees of freedom; with two conditions it is the paired t test.
#[test]
fn balanced_data_give_the_analysis_of_variance() {
    for (persons, conditions) in [(8, 2), (12, 4)] {
        let (participant_of_row, terms, y) = balanced(persons, conditions, 2.0);
        let model = MixedModel::fit(&participant_of_row, &terms, &y).unwrap();
        let (n, k) = (persons as f64, conditions as f64);
        let mean = |of: &dyn Fn(usize) -> bool| {
            let picked: Vec<f64> = (0..y.len()).filter(|i| of(*i)).map(|i| y[i]).collect();
            picked.iter().sum::<f64>() / picked.len() as f64
        };
        let all = mean(&|_| true);
        let persons_means: Vec<f64> = (0..persons).map(|person| mean(&|i| participant_of_row[i] == person)).collect();
        let means: Vec<f64> = (0..conditions).map(|c| mean(&|i| i % conditions == c)).collect();
        let within: f64 = (0..y.len())
            .map(|i| (y[i] - persons_means[participant_of_row[i]] - means[i % conditions] + all).powi(2))
            .sum::<f64>()
            / ((n - 1.0) * (k - 1.0));
        let between = k * persons_means.iter().map(|m| (m - all).powi(2)).sum::<f64>() / (n - 1.0);
        assert!((model.sd_residual.powi(2) / within - 1.0).abs() < 1e-8, "{model:?} {within}");
        assert!((model.sd_participant.powi(2) / ((between - within) / k) - 1.0).abs() < 1e-8);
        let first = model.term(1);
        assert!((first.estimate - (means[1] - means[0])).abs() < 1e-10);
        assert!((first.se - (2.0 * within / n).sqrt()).abs() < 1e-8);
        assert!((first.df - (n - 1.0) * (k - 1.0)).abs() < 1e-4, "{first:?}");
        // Degrees of freedom of the intercept, by Satterthwaite's own formula for a sum of two mean squares.
        let [a, b] = [between / k, (k - 1.0) * within / k];
        let known = (a + b).powi(2) / (a * a / (n - 1.0) + b * b / ((n - 1.0) * (k - 1.0)));
        assert!((model.term(0).df / known - 1.0).abs() < 1e-4, "{} {known}", model.term(0).df);
        let [low, high] = first.interval(0.05);
        assert!(low < first.estimate && first.estimate < high);
    }
}

/// Persons who differ less than chance have a variance of 0 between them, and the model is a regression.
#[test]
fn without_variance_between_persons_the_model_is_a_regression() {
    let participant_of_row = [0, 0, 1, 1, 2, 2];
    // Every person has the same mean.
    let y = [1.0, 3.0, 0.5, 3.5, 1.5, 2.5];
    let term = vec![vec![0.0, 1.0, 0.0, 1.0, 0.0, 1.0]];
    let model = MixedModel::fit(&participant_of_row, &term, &y).unwrap();
    assert_eq!(model.sd_participant, 0.0);
    // By hand: a difference of 2, residual sum of squares 1, 4 degrees of freedom, se = sqrt(1/4 x 2/3).
    let found = model.term(1);
    assert!((found.estimate - 2.0).abs() < 1e-12 && (found.se - (1.0_f64 / 6.0).sqrt()).abs() < 1e-12, "{found:?}");
    assert_eq!(found.df, 4.0);
    // Six rows, two estimates; the product of the sums of squares is 6 x 1.5: 4 (ln(2 pi 1/4) + 1) + ln 9.
    let criterion = 4.0 * ((0.5 * std::f64::consts::PI).ln() + 1.0) + 9.0_f64.ln();
    assert!((model.criterion - criterion).abs() < 1e-9, "{} {criterion}", model.criterion);
}

#[test]
fn models_that_cannot_be_fitted_are_errors() {
    let (participant_of_row, mut terms, y) = balanced(4, 3, 1.0);
    assert!(matches!(
        MixedModel::fit(&participant_of_row[..3], &[], &y[..3]),
        Err(ModelFault::TooFew { rows: 3, participants: 1 })
    ));
    // Intercept, slope and variance from three rows leave nothing to estimate the error of the slope.
    let slope = [vec![0.0, 1.0, 2.0]];
    let found = MixedModel::fit(&[0, 1, 0], &slope, &[1.0, 2.5, 3.0]);
    assert_eq!(found, Err(ModelFault::TooFew { rows: 3, participants: 2 }));
    assert_eq!(MixedModel::fit(&participant_of_row, &terms, &[7.3; 12]), Err(ModelFault::NoVariation));
    // Every row is its person's constant.
    let fixed: Vec<f64> = participant_of_row.iter().map(|person| *person as f64).collect();
    assert_eq!(MixedModel::fit(&participant_of_row, &terms, &fixed), Err(ModelFault::NoVariation));
    let sum = terms[0].iter().zip(&terms[1]).map(|(a, b)| 2.0 * a + b).collect();
    terms.push(sum);
    assert_eq!(MixedModel::fit(&participant_of_row, &terms, &y), Err(ModelFault::Aliased { term: 2 }));
}

/// Example of four tests: 0.005, 0.01, 0.03, 0.04 are multiplied by 4, 3, 2 and 1, and never fall below the value before.
#[test]
fn holm_multiplies_the_smallest_by_the_count_and_never_falls() {
    let found = holm(&[0.01, 0.04, 0.03, 0.005]);
    for (found, known) in found.iter().zip([0.03, 0.06, 0.06, 0.02]) {
        assert!((found - known).abs() < 1e-15, "{found} {known}");
    }
    assert_eq!(holm(&[0.6, 0.9]), [1.0, 1.0]);
    assert!(holm(&[]).is_empty());
}
