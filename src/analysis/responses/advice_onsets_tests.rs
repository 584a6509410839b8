//! Requests among changes, and the times of shams.

use super::*;
use crate::analysis::data::{ChangeFinder, IssuedAdvice, advice::MOST_CHANGES};
use crate::time::Tick;

/// Returns the onsets of a drive of so many ticks; advices are seen two ticks after their issue, with a range of +-0.5 m/s.
fn onsets(ticks: u64, speed: impl Fn(f64) -> f64, advice: &[(u64, f64)]) -> DriveOnsets {
    let mut finder = ChangeFinder::default();
    for &(tick, target_mps) in advice {
        let range_mps = [target_mps - 0.5, target_mps + 0.5];
        finder.add(&IssuedAdvice { seen_tick: tick + 2, target_mps, range_mps }).unwrap();
    }
    let mut finder = OnsetFinder::new(finder.changes);
    for tick in 1..=ticks {
        let at_s = Tick(tick).seconds();
        let throttle = 0.2 + 0.05 * (at_s * 3.0).sin();
        finder.add(&EgoSample { tick, throttle, speed_mps: speed(at_s), ..EgoSample::default() });
    }
    finder.finish()
}

fn kinds(found: &DriveOnsets) -> Vec<(u64, String, i8)> {
    found.onsets.iter().map(|onset| (onset.tick, onset.kind.to_string(), onset.direction)).collect()
}

#[test]
fn an_event_leaves_the_range_of_the_driver_or_asks_for_its_other_side() {
    // At 4 m/s: 4.3 keeps the speed in range; 5 does not; 5.5 has the same demand; 3 the opposite one; 4.1 none.
    let advice = [(100, 4.0), (200, 4.3), (300, 5.0), (400, 5.5), (500, 3.0), (600, 4.1)];
    let found = onsets(1000, |_| 4.0, &advice);
    let wanted =
        [(202, "change", 0), (302, "request", 1), (402, "change", 1), (502, "request", -1), (602, "change", 0)];
    assert_eq!(
        kinds(&found),
        wanted.map(|(tick, kind, direction)| (tick, kind.to_owned(), direction)),
        "the first advice is none"
    );
    assert_eq!(found.onsets[1].until_tick, Some(402), "watched until the next change");
    assert_eq!((found.onsets[1].speed_mps, found.onsets[4].until_tick), (4.0, None));
}

#[test]
fn small_steps_add_up_to_a_change_and_to_an_event_outside_the_range() {
    // Steps of 0.06 m/s: every second one makes a change, and at 4.6 the speed of 4 m/s is below the range.
    let advice: Vec<(u64, f64)> = (0..16).map(|k| (100 + 100 * k, 4.0 + 0.06 * k as f64)).collect();
    let found = onsets(3000, |_| 4.0, &advice);
    assert_eq!(found.onsets.len(), 7, "{:?}", kinds(&found));
    let requests: Vec<u64> =
        kinds(&found).into_iter().filter(|onset| onset.1 == "request").map(|onset| onset.0).collect();
    assert_eq!(requests, [1102], "at 4.60 m/s, ten steps of 0.06: {:?}", kinds(&found));
}

#[test]
fn idle_pedals_are_those_while_no_event_is_pending() {
    // Never in the new range: pending for 5 s of 60.
    let found = onsets(6000, |_| 4.0, &[(100, 4.0), (3000, 6.0)]);
    let none = onsets(6000, |_| 4.0, &[(100, 4.0)]);
    assert!(found.noise != none.noise && found.noise.threshold().is_some());
    // In the range after 1 s: pending no longer.
    let met = onsets(6000, |t| if t < 31.0 { 4.0 } else { 6.0 }, &[(100, 4.0), (3000, 6.0)]);
    assert!(met.noise != found.noise && met.noise != none.noise);
}

#[test]
fn shams_are_the_events_shifted_by_one_time_to_where_none_is_pending() {
    let advice: Vec<(u64, f64)> = (0..6).map(|k| (1000 + 1000 * k, if k % 2 == 0 { 4.0 } else { 6.0 })).collect();
    // The driver reaches each range 2 s after its onset.
    let speed = |t: f64| if ((t - 2.02) / 10.0) as i64 % 2 == 0 { 6.0 } else { 4.0 };
    let found = onsets(7000, speed, &advice);
    let requests: Vec<&Onset> = found.onsets.iter().filter(|onset| onset.kind == OnsetKind::Request).collect();
    assert_eq!((requests.len(), found.shams.len()), (5, 5), "{:?}", kinds(&found));
    let shift = (found.shams[0].tick + 7000 - requests[4].tick) % 7000;
    for sham in &found.shams {
        let of = requests.iter().find(|request| (request.tick + 7000 - sham.tick) % 7000 == (7000 - shift) % 7000);
        assert!(
            of.is_some_and(|of| of.direction == sham.direction)
                || requests.iter().any(|e| e.direction == sham.direction)
        );
        let since = requests.iter().map(|request| request.tick).filter(|tick| *tick <= sham.tick).max();
        assert!(since.is_none_or(|tick| sham.tick > tick + 200), "the range was reached 2 s after {since:?}: {sham:?}");
        assert!(sham.until_tick.is_none_or(|until| requests.iter().all(|e| e.tick <= sham.tick || e.tick >= until)));
    }
    assert_eq!(onsets(7000, speed, &advice), found, "the same again");
    // A request is always pending: there is no time for shams.
    let always: Vec<(u64, f64)> = (0..60).map(|k| (100 * k, if k % 2 == 0 { 2.0 } else { 6.0 })).collect();
    let shams = onsets(6000, |_| 4.0, &always).shams;
    assert!(shams.iter().all(|sham| sham.tick < 102), "but before the first: {shams:?}");
}

#[test]
fn shams_are_where_a_driver_can_be_watched_for_five_seconds() {
    let onset = |kind, tick| Onset { kind, tick, ..Onset::default() };
    // Pending until 11 s; from 11.5 s on there are 2 s to the next change, and after that change the full 5 s.
    let onsets = [onset(OnsetKind::Request, 1000), onset(OnsetKind::Change, 1350)];
    let ticks: Vec<u64> = shams(&onsets, &[[1000, 1100]], 20_000).iter().map(|sham| sham.tick).collect();
    assert_eq!(ticks, [1350], "the smallest shift of those with the most time");
}

#[test]
fn more_changes_than_are_analysed_are_refused() {
    let mut finder = ChangeFinder::default();
    let advice = |k: usize| IssuedAdvice { target_mps: (k % 2) as f64, ..IssuedAdvice::default() };
    (0..=MOST_CHANGES).for_each(|k| finder.add(&advice(k)).unwrap());
    assert_eq!(finder.changes.len(), MOST_CHANGES);
    let why = finder.add(&advice(MOST_CHANGES + 1)).unwrap_err().to_string();
    assert!(why.contains("500000") && why.contains("remedy"), "{why}");
}
