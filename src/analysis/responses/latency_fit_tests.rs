//! Fits against closed forms, R 4 and simulated people with known times.

use super::*;
use crate::rng;

fn seen(times: &[f64]) -> Vec<Latency> {
    times.iter().map(|s| Latency::Seen(*s)).collect()
}

#[test]
fn without_censoring_the_fit_is_the_mean_logarithm_with_students_interval() {
    // ln t of 0, 1, 2, 3: mean 1.5, sigma (N) sqrt(5/4), standard error sqrt(5/3)/2 (N-1), t of 3 3.182446.
    let fit = LognormalFit::of(&seen(&[1.0, 1f64.exp(), 2f64.exp(), 3f64.exp()])).unwrap();
    assert!((fit.mu - 1.5).abs() < 1e-9 && (fit.sigma - 1.25f64.sqrt()).abs() < 1e-9, "{fit:?}");
    let half = 3.182_446 * (5.0f64 / 3.0).sqrt() / 2.0;
    assert!((fit.interval_s[0].ln() - (1.5 - half)).abs() < 2e-3, "{fit:?}");
    assert!((fit.interval_s[1].ln() - (1.5 + half)).abs() < 2e-3, "{fit:?}");
    assert!((fit.median_s() - 1.5f64.exp()).abs() < 1e-9);
}

#[test]
fn censored_times_count_as_they_do_in_r() {
    // R 4, optim (BFGS) on -sum(ifelse(seen, dnorm(log(t), mu, sigma, log = TRUE), pnorm(log(t), mu, sigma, FALSE, TRUE))):
    // mu 0.49510979, sigma 0.69794342, standard error of mu from its numeric Hessian 0.198410.
    let mut times = seen(&[0.82, 1.10, 0.95, 1.43, 0.71, 2.20, 1.05, 0.88, 1.31, 1.77]);
    times.extend([5.0, 3.2, 0.9, 2.5].map(Latency::LongerThan));
    let fit = LognormalFit::of(&times).unwrap();
    assert!((fit.mu - 0.495_109_79).abs() < 1e-6 && (fit.sigma - 0.697_943_42).abs() < 1e-6, "{fit:?}");
    assert_eq!((fit.seen, fit.censored), (10, 4));
    let half = (fit.interval_s[1] / fit.interval_s[0]).ln() / 2.0;
    // Variance with 10/9 and t of 9.
    assert!((half - 0.198_410 * (10.0f64 / 9.0).sqrt() * 2.262_157).abs() < 1e-4, "{half}");
    assert_eq!(LognormalFit::of(&times[8..]), None, "two were seen");
    assert_eq!(LognormalFit::of(&seen(&[1.0; 9])), None, "all the same");
}

#[test]
fn tails_and_quantiles_match_r() {
    // pnorm(z, lower.tail = FALSE, log.p = TRUE) and qt(0.975, n) of R 4.
    for (z, wanted) in [
        (-3.0, -0.001_350_809_965),
        (0.5, -1.175_911_761_594),
        (2.9, -6.284_058_234_947),
        (3.1, -6.940_688_458_421),
        (9.0, -43.628_149_113_332),
        (30.0, -454.321_243_956_343),
    ] {
        assert!((ln_upper_tail(z) - wanted).abs() < 1e-9 * (1.0 - wanted), "{z}: {}", ln_upper_tail(z));
    }
    for (n, wanted) in [(3, 3.182_446), (4, 2.776_445), (5, 2.570_582), (9, 2.262_157), (29, 2.045_230)] {
        assert!((student_975(n) - wanted).abs() < 1e-3, "{n}: {}", student_975(n));
    }
}

#[test]
fn the_ex_gaussian_fit_matches_r() {
    // R 4: 40 times of rnorm(0.8, 0.12) + rexp(mean 0.5), three of them censored at 2 s; optim on the same likelihood gives
    // mu 0.843268, sigma 0.066544, tau 0.500251 (-log likelihood 15.996538).
    let of_r = [
        1.16, 0.9, 1.34, 1.92, 1.98, 0.95, 1.43, 1.47, 1.35, 2.0, 0.91, 1.2, 1.11, 1.4, 1.35, 1.79, 1.33, 1.24, 1.33,
        0.93, 1.91, 1.07, 1.6, 2.0, 1.08, 0.89, 1.18, 1.8, 1.01, 0.8, 1.12, 1.09, 1.3, 1.05, 1.58, 0.86, 2.0, 0.95,
        0.79, 1.07,
    ];
    let time = |s: &f64| if *s < 2.0 { Latency::Seen(*s) } else { Latency::LongerThan(*s) };
    let times: Vec<Latency> = of_r.iter().map(time).collect();
    let fit = ExGaussianFit::of(&times).unwrap();
    assert!((fit.mu_s - 0.843_268).abs() < 1e-3 && (fit.sigma_s - 0.066_544).abs() < 1e-3, "{fit:?}");
    assert!((fit.tau_s - 0.500_251).abs() < 1e-3 && (fit.mean_s() - 1.343_519).abs() < 1e-3, "{fit:?}");
    let parts: Vec<(f64, bool)> = times.iter().map(|time| time.parts()).collect();
    assert!((fit.ln_likelihood(&parts) + 15.996_538).abs() < 1e-5);
    assert_eq!(ExGaussianFit::of(&times[..29]), None);
    assert_eq!(ExGaussianFit::of(&[Latency::Seen(0.8); 40]), None, "times that are all the same have no spread");
}

#[test]
fn the_interval_contains_the_known_median_for_95_percent_of_200_people() {
    // 20 requests each; the advice changes again after 0.7 to 3 s, so that about a quarter of the times is censored.
    let [mut covered, mut censored] = [0, 0];
    let mut errors = Vec::new();
    for person in 0..200 {
        let mut stream = rng::stream(person, "censored latencies");
        let (mu, sigma) = (stream.uniform(0.6, 1.6).ln(), stream.uniform(0.2, 0.6));
        let times: Vec<Latency> = (0..20)
            .map(|_| {
                let s = (mu + sigma * stream.normal()).exp();
                let until_s = stream.uniform(0.7, 3.0);
                if s < until_s { Latency::Seen(s) } else { Latency::LongerThan(until_s) }
            })
            .collect();
        let fit = LognormalFit::of(&times).unwrap();
        let median_s = mu.exp();
        covered += usize::from(fit.interval_s[0] <= median_s && median_s <= fit.interval_s[1]);
        censored += fit.censored;
        errors.push(fit.mu - mu);
    }
    let bias = errors.iter().sum::<f64>() / 200.0;
    let spread = (errors.iter().map(|e| (e - bias).powi(2)).sum::<f64>() / 199.0).sqrt();
    assert!((600..1400).contains(&censored), "{censored}");
    // 95 % of 200 with a standard error of 1.5 %: three of them on either side.
    assert!((181..=199).contains(&covered), "{covered}");
    // Three standard errors of the mean. Ignoring the censoring would shorten the medians by 0.1 and more.
    assert!(bias.abs() < 3.0 * spread / 200f64.sqrt() + 0.005, "{bias} {spread}");
}
