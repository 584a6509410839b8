//! Response fits against the figures of another program, and for simulated people with known response times and shares.

use super::*;
use crate::analysis::responses::latency_fit::LognormalFit;
use crate::rng;

#[test]
fn fit_and_interval_match_scipy() {
    // scipy 1.17, minimize (Nelder-Mead, 1e-13) on the same likelihood with c = 0.06: mu -0.10069777, sigma 0.29783644, share
    // 0.48676783; brentq on the profile with t of 11: 0.677962 to 1.410316.
    let seen = [0.76, 1.07, 1.55, 0.82, 0.52, 0.91, 2.68, 1.21, 0.66, 1.02, 4.6, 9.3].map(Latency::Seen);
    let longer = [5.0, 5.0, 3.2, 5.0, 2.5].map(Latency::LongerThan);
    let times: Vec<Latency> = seen.into_iter().chain(longer).collect();
    let fit = ResponseFit::of(&times, 0.06).unwrap();
    assert!((fit.mu + 0.100_697_77).abs() < 1e-4 && (fit.sigma - 0.297_836_44).abs() < 1e-4, "{fit:?}");
    assert!((fit.share - 0.486_767_83).abs() < 1e-4, "{fit:?}");
    assert!((fit.interval_s[0] - 0.677_962).abs() < 1e-3 && (fit.interval_s[1] - 1.410_316).abs() < 1e-3, "{fit:?}");
    assert_eq!(ResponseFit::of(&times[10..], 0.06), None, "two were seen");
}

#[test]
fn chance_is_movements_over_seconds_watched() {
    // Two in 1 + 3 + 4 + 2 s.
    let times = [Latency::Seen(1.0), Latency::LongerThan(3.0), Latency::Seen(4.0), Latency::LongerThan(2.0)];
    assert!((chance_per_s(&times) - 0.2).abs() < 1e-12);
    assert_eq!(chance_per_s(&[]), 0.0);
}

#[test]
fn median_is_found_for_people_who_respond_to_half_and_move_anyway() {
    // 100 people with 20 requests each, watched for 5 s. Half to nine tenths get a response, and a foot moves every ten seconds.
    // 20 shams of 5 s give the chance rate.
    let [mut covered, mut lognormal_covered] = [0, 0];
    let mut errors = Vec::new();
    for person in 0..100 {
        let mut stream = rng::stream(person, "answers");
        let (mu, sigma) = (stream.uniform(0.6, 1.6).ln(), stream.uniform(0.15, 0.4));
        let share = stream.uniform(0.5, 0.9);
        let mut watch = |share: f64| -> Vec<Latency> {
            let request = |_| {
                let response_s =
                    if stream.uniform(0.0, 1.0) < share { (mu + sigma * stream.normal()).exp() } else { f64::INFINITY };
                let first = response_s.min(-10.0 * (1.0 - stream.uniform(0.0, 1.0)).ln());
                if first < 5.0 { Latency::Seen(first) } else { Latency::LongerThan(5.0) }
            };
            (0..20).map(request).collect()
        };
        let (requests, shams) = (watch(share), watch(0.0));
        let fit = ResponseFit::of(&requests, chance_per_s(&shams)).unwrap();
        let holds = |[low, high]: [f64; 2]| usize::from(low <= mu.exp() && mu.exp() <= high);
        covered += holds(fit.interval_s);
        lognormal_covered += holds(LognormalFit::of(&requests).unwrap().interval_s);
        errors.push(fit.mu - mu);
    }
    // 95 % of 100, less three standard errors of 2.2 %.
    assert!(covered >= 88, "{covered}");
    assert!(lognormal_covered < 88, "what this is for: {lognormal_covered}");
    errors.sort_by(f64::total_cmp);
    // Half of all are within a tenth, the usual precision asked of a reaction time.
    assert!(errors[25] > -0.1 && errors[74] < 0.1, "{} {}", errors[25], errors[74]);
    let bias = errors.iter().sum::<f64>() / 100.0;
    assert!(bias.abs() < 0.05, "{bias}");
}
