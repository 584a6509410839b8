//! Responses against movements made by hand and simulated people with known reactions.

use super::*;
use crate::analysis::{
    data::{ChangeFinder, IssuedAdvice},
    responses::{OnsetFinder, ResponseTime, latency_fit::Latency},
};
use crate::rng;

/// Returns the responses of a drive; pedals and speed are functions of the time. Advices are seen two ticks after their issue.
fn responses(
    ticks: u64,
    pedals: impl Fn(f64) -> (f64, f64),
    speed: impl Fn(f64) -> f64,
    advice: &[(u64, f64)],
) -> Vec<AdviceResponse> {
    let mut finder = ChangeFinder::default();
    for &(tick, target_mps) in advice {
        let range_mps = [target_mps - 0.5, target_mps + 0.5];
        finder.add(&IssuedAdvice { seen_tick: tick + 2, target_mps, range_mps }).unwrap();
    }
    let rows: Vec<EgoSample> = (1..=ticks)
        .map(|tick| {
            let at_s = Tick(tick).seconds();
            let (throttle, brake) = pedals(at_s);
            EgoSample { tick, throttle, brake, speed_mps: speed(at_s), ..EgoSample::default() }
        })
        .collect();
    let mut onsets = OnsetFinder::new(finder.changes);
    rows.iter().for_each(|row| onsets.add(row));
    let mut watch = ResponseWatch::new(0.1, onsets.finish(), None);
    rows.iter().for_each(|row| watch.add(row));
    watch.finish()
}

fn requests(found: &[AdviceResponse]) -> Vec<AdviceResponse> {
    found.iter().filter(|response| response.kind == OnsetKind::Request).copied().collect()
}

#[test]
fn reaction_ends_where_the_movement_starts_and_movement_5_percent_beyond() {
    // The accelerator moves by 10 % a second from 3.00 s on; idle pedals are still, so that 1 % is the threshold.
    let press = |t: f64| (0.2 + 0.1 * (t - 3.0).clamp(0.0, 2.0), 0.0);
    // 3.5 m/s, the lower edge, is reached 2.5 s after 3.00 s.
    let speed = |t: f64| 2.0 + 0.6 * (t - 3.0).max(0.0);
    let found = requests(&responses(1000, press, speed, &[(100, 2.0), (150, 2.05), (200, 4.0)]));
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!((found[0].onset_s, found[0].from_mps, found[0].to_mps, found[0].direction), (2.02, 2.0, 4.0, 1));
    assert_eq!((found[0].threshold, found[0].noise_from), (0.01, NoiseSource::Least));
    // The movement starts at 3.00 s (half the threshold takes 0.05 s), and 6 % of travel are reached at 3.60 s.
    assert!((found[0].reaction_s.unwrap() - 1.03).abs() < 0.021, "{found:?}");
    assert!((found[0].reaction_s.unwrap() + found[0].movement_s.unwrap() - 1.58).abs() < 0.021, "{found:?}");
    assert!((found[0].enter_s.unwrap() - 3.48).abs() < 0.011 && found[0].enter_steps == Some(35), "{found:?}");
    assert!((found[0].watched_s - 7.98).abs() < 0.011, "to the end: {found:?}");
}

#[test]
fn lifting_the_foot_is_a_response_to_a_lower_target_and_pressing_is_not() {
    let lift = |t: f64| (if t < 2.5 { 0.2 } else { 0.1 }, 0.0);
    let found = requests(&responses(1000, lift, |_| 5.0, &[(100, 5.0), (200, 3.0)]));
    assert!((found[0].reaction_s.unwrap() - 0.48).abs() < 0.021 && found[0].enter_s.is_none(), "{found:?}");
    let brake = |t: f64| (0.0, if t < 2.5 { 0.0 } else { 0.3 });
    let found = requests(&responses(1000, brake, |_| 5.0, &[(100, 5.0), (200, 3.0)]));
    assert!((found[0].reaction_s.unwrap() - 0.48).abs() < 0.021, "{found:?}");
    let on = |t: f64| (0.2 + 0.02 * t, 0.0);
    assert_eq!(requests(&responses(1000, on, |_| 5.0, &[(100, 5.0), (200, 3.0)]))[0].reaction_s, None);
}

#[test]
fn movements_under_way_are_marked_and_late_ones_censored() {
    let under_way = |t: f64| (0.2 + 0.4 * (t - 1.8).clamp(0.0, 1.0), 0.0);
    let found = requests(&responses(1000, under_way, |_| 2.0, &[(100, 2.0), (200, 4.0)]));
    assert!(found[0].is_under_way && found[0].reaction_s.is_none() && found[0].movement_s.is_none(), "{found:?}");
    // A movement at 9.08 s is late and still a response: long times are not clipped.
    let late = |t: f64| (if t < 9.08 { 0.1 } else { 0.5 }, 0.0);
    let found = requests(&responses(1000, late, |_| 2.0, &[(100, 2.0), (200, 4.0)]));
    assert!((found[0].reaction_s.unwrap() - 7.06).abs() < 0.021, "{found:?}");
    // If another target replaces the first, the time to the first is only known to be longer.
    let found = requests(&responses(1000, late, |_| 2.0, &[(100, 2.0), (200, 4.0), (600, 6.0)]));
    assert_eq!((found.len(), found[0].reaction_s), (1, None), "the second asks the same again: {found:?}");
    assert!((found[0].watched_s - 3.99).abs() < 0.011, "{found:?}");
    let fitted = ResponseTime::Reaction.latencies(&found);
    assert_eq!(fitted, [Latency::LongerThan(found[0].watched_s)]);
}

#[test]
fn a_change_replaced_before_it_is_seen_has_no_time_watched() {
    let press = |t: f64| (if t < 2.5 { 0.1 } else { 0.5 }, 0.0);
    // Two changes appear in one frame, and one after the last row.
    let found = responses(1000, press, |_| 2.0, &[(100, 2.0), (200, 4.0), (200, 6.0), (999, 8.0)]);
    let found: Vec<_> = found.iter().filter(|response| response.kind != OnsetKind::Sham).collect();
    assert_eq!(found.len(), 3, "{found:?}");
    assert!(found[0].watched_s == 0.0 && found[0].reaction_s.is_none(), "{found:?}");
    assert_eq!((found[2].to_mps, found[2].onset_s, found[2].watched_s), (8.0, 10.01, 0.0));
}

/// Simulates a person with a known reaction time and a trembling foot, in five minutes with advice between two speeds.
fn person(number: u64) -> (f64, f64, Vec<AdviceResponse>) {
    let mut stream = rng::stream(number, "known reaction");
    let (mu, sigma) = (stream.uniform(0.6, 1.6).ln(), 0.3);
    let idle = stream.uniform(0.0, 0.03);
    let ticks = 30_000;
    // Steps of 6 to 12 s; each gets a response of 15 % of travel within 0.4 s, and the speed follows after 2 s.
    let mut advice = vec![(100, 4.0)];
    let mut movements = vec![(1.02, 0.0, 4.0)];
    let mut at = 1000;
    while at < ticks - 600 {
        let target_mps = if advice.len() % 2 == 0 { 4.0 } else { 6.0 };
        advice.push((at, target_mps));
        movements.push((Tick(at + 2).seconds() + (mu + sigma * stream.normal()).exp(), 0.15, target_mps));
        at += stream.uniform(600.0, 1200.0) as u64;
    }
    // Idle movements: slow waves with phases of their own, 0.3 to 1.5 a second.
    let waves: Vec<[f64; 2]> =
        (0..5).map(|_| [stream.uniform(2.0, 9.0), stream.uniform(0.0, std::f64::consts::TAU)]).collect();
    let found = responses(
        ticks,
        |t| {
            let tremble: f64 = waves.iter().map(|[rate, phase]| (rate * t + phase).sin()).sum::<f64>() / 5.0;
            let mut pedal = 0.3 + idle * tremble;
            for (responded_s, size, target_mps) in &movements {
                let way = if *target_mps > 5.0 { *size } else { -*size };
                // Full movement after 0.4 s; from 1 s on back within 3 s.
                let since = t - responded_s;
                let out = (since / 0.4).clamp(0.0, 1.0) - ((since - 1.0) / 3.0).clamp(0.0, 1.0);
                pedal += way * out;
            }
            (pedal.clamp(0.0, 1.0), 0.0)
        },
        |t| movements.iter().rev().find(|movement| movement.0 + 2.0 < t).map_or(4.0, |movement| movement.2),
        &advice,
    );
    (mu.exp(), idle, found)
}

#[test]
fn known_reactions_of_200_people_are_found_and_few_shams_get_a_response() {
    let (mut errors, mut chance, mut responded) = (Vec::new(), Vec::new(), Vec::new());
    for number in 0..200 {
        let (median_s, _, found) = person(number);
        let Some(fit) = ResponseTime::Reaction.fit(&found) else { continue };
        errors.push(fit.median_s / median_s - 1.0);
        chance.extend(ResponseTime::Chance.share_with_response(&found));
        responded.extend(ResponseTime::Reaction.share_with_response(&found));
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let bias = mean(&errors);
    let spread = mean(&errors.iter().map(|e| (e - bias).powi(2)).collect::<Vec<_>>()).sqrt();
    assert_eq!(errors.len(), 200);
    // A reaction time is fit to compare conditions if it is right to a tenth.
    assert!(bias.abs() < 0.1 && spread < 0.15, "{bias} {spread}");
    assert!(mean(&responded) > 0.9 && mean(&chance) < 0.35, "{} {}", mean(&responded), mean(&chance));
}
