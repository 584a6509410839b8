//! Answers against another program's figures, and people of whom is known how soon and how often they answer.

use super::*;
use crate::rng;

#[test]
fn it_is_the_likelihood_and_its_profile_as_another_program_has_them() {
    // scipy 1.17, minimize (Nelder-Mead, 1e-13) on the same likelihood with c = 0.06: mu -0.10069777, sigma 0.29783644, share
    // 0.48676783; brentq on the profile with t of 11: 0.677962 to 1.410316.
    let seen = [0.76, 1.07, 1.55, 0.82, 0.52, 0.91, 2.68, 1.21, 0.66, 1.02, 4.6, 9.3].map(Latency::Seen);
    let longer = [5.0, 5.0, 3.2, 5.0, 2.5].map(Latency::LongerThan);
    let times: Vec<Latency> = seen.into_iter().chain(longer).collect();
    let fit = AnswerFit::of(&times, 0.06).unwrap();
    assert!((fit.mu + 0.100_697_77).abs() < 1e-4 && (fit.sigma - 0.297_836_44).abs() < 1e-4, "{fit:?}");
    assert!((fit.share - 0.486_767_83).abs() < 1e-4, "{fit:?}");
    assert!((fit.interval_s[0] - 0.677_962).abs() < 1e-3 && (fit.interval_s[1] - 1.410_316).abs() < 1e-3, "{fit:?}");
    assert_eq!(AnswerFit::of(&times[10..], 0.06), None, "two were seen");
}

#[test]
fn chance_is_movements_over_seconds_watched() {
    // Two in 1 + 3 + 4 + 2 s.
    let times = [Latency::Seen(1.0), Latency::LongerThan(3.0), Latency::Seen(4.0), Latency::LongerThan(2.0)];
    assert!((chance_per_s(&times) - 0.2).abs() < 1e-12);
    assert_eq!(chance_per_s(&[]), 0.0);
}

#[test]
fn of_people_who_answer_half_of_it_and_move_anyway_the_median_is_theirs() {
    // 100 people with 20 events each, watched for 5 s; half to nine tenths are answered, and every ten seconds a foot moves. The shams tell
    // how often: 20 of 5 s.
    let [mut covered, mut lognormal_covered] = [0, 0];
    let mut errors = Vec::new();
    for person in 0..100 {
        let mut stream = rng::stream(person, "answers");
        let (mu, sigma) = (stream.uniform(0.6, 1.6).ln(), stream.uniform(0.15, 0.4));
        let share = stream.uniform(0.5, 0.9);
        let mut watch = |share: f64| -> Vec<Latency> {
            let event = |_| {
                let answer =
                    if stream.uniform(0.0, 1.0) < share { (mu + sigma * stream.normal()).exp() } else { f64::INFINITY };
                let first = answer.min(-10.0 * (1.0 - stream.uniform(0.0, 1.0)).ln());
                if first < 5.0 { Latency::Seen(first) } else { Latency::LongerThan(5.0) }
            };
            (0..20).map(event).collect()
        };
        let (events, shams) = (watch(share), watch(0.0));
        let fit = AnswerFit::of(&events, chance_per_s(&shams)).unwrap();
        let holds = |[low, high]: [f64; 2]| usize::from(low <= mu.exp() && mu.exp() <= high);
        covered += holds(fit.interval_s);
        lognormal_covered += holds(super::super::latency_fit::LognormalFit::of(&events).unwrap().interval_s);
        errors.push(fit.mu - mu);
    }
    // 95 % of 100 with a standard error of 2.2 %: three of them.
    assert!(covered >= 88, "{covered}");
    assert!(lognormal_covered < 88, "what this is for: {lognormal_covered}");
    errors.sort_by(f64::total_cmp);
    // Half of all are within a tenth, which is what a reaction time is asked for; none is off by half.
    assert!(errors[25] > -0.1 && errors[74] < 0.1, "{} {}", errors[25], errors[74]);
    let bias = errors.iter().sum::<f64>() / 100.0;
    assert!(bias.abs() < 0.05, "{bias}");
}
