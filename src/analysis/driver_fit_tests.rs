//! The fit of a driver, on drives that are made up of the model alone: what each kind of drive tells, and what it does not. Whole
//! rehearsed drives, with feet and a car, are in `tests/studies/drivers.rs`.

use super::*;

/// How somebody drives.
#[derive(Clone, Copy)]
struct Truth {
    reaction_s: f64,
    bias_mps: f64,
    error_mps: f64,
    factor: f64,
}

const SOMEBODY: Truth = Truth { reaction_s: 1.2, bias_mps: 0.4, error_mps: 0.3, factor: 1.3 };
/// The other cars' time gap, s.
const USUAL_S: f64 = 1.1;

/// Advice of this time, and the speed of a leader if there is one.
type Plan = fn(f64) -> (Option<f64>, Option<f64>);

/// A drive of so many seconds: the model's equations tick by tick, with a car that answers a wish as late as the fit takes it to.
fn driven(truth: Truth, seconds: usize, plan: Plan) -> DriverStretches {
    const TICKS_A_MOMENT: usize = 10;
    let tick_s = MOMENT_S / TICKS_A_MOMENT as f64;
    let mut stream = rng::stream(5, "made up");
    let usual = DriverParams::default().idm;
    let idm = crate::idm::IdmParams { t: truth.factor * USUAL_S, v0: 30.0, ..usual };
    let (mut speed_mps, mut gap_m, mut wander) = (4.0_f64, 12.0_f64, 0.0);
    let keeps = (-tick_s / WANDER_S).exp();
    let mut moments: Vec<Moment> = Vec::new();
    let mut wishes = vec![0.0; CAR_LAG * TICKS_A_MOMENT];
    for i in 0..seconds * 10 * TICKS_A_MOMENT {
        let at_s = i as f64 * tick_s;
        let (advised, leader) = plan(at_s);
        // As late as the model has it, less what the fit takes off for foot and car.
        let seen_s = at_s - truth.reaction_s + CAR_LAG as f64 * MOMENT_S - ANSWER_LAG_S;
        wander = keeps * wander + (1.0 - keeps * keeps).sqrt() * truth.error_mps * stream.normal();
        let reach = plan(seen_s.max(0.0))
            .0
            .map_or(f64::INFINITY, |advised_mps| (advised_mps + truth.bias_mps + wander - speed_mps) / RELAX_S);
        let behind = leader.map_or(f64::INFINITY, |leader_mps| idm.acceleration(speed_mps, leader_mps, gap_m));
        if i.is_multiple_of(TICKS_A_MOMENT) {
            moments.push(Moment {
                speed_mps: speed_mps as f32,
                advised_mps: advised.map(|mps| mps as f32),
                gap_m: if leader.is_some() { gap_m as f32 } else { 1e6 },
                leader_mps: leader.unwrap_or(speed_mps) as f32,
                limit_mps: 30.0,
                bend_mps: f32::INFINITY,
            });
        }
        wishes.push(reach.min(behind).min(1.0));
        speed_mps = (speed_mps + wishes[i] * tick_s).max(0.0);
        gap_m += leader.map_or(0.0, |leader_mps| (leader_mps - speed_mps) * tick_s);
    }
    DriverStretches::of_moments(USUAL_S, &moments)
}

/// Changes every seven seconds between three speeds; nobody is ahead.
fn changing(at_s: f64) -> (Option<f64>, Option<f64>) {
    (Some([4.0, 4.8, 4.4, 3.8][(at_s / 7.0) as usize % 4]), None)
}

fn constant(_: f64) -> (Option<f64>, Option<f64>) {
    (Some(4.0), None)
}

/// No advice, behind a leader who goes faster and slower.
fn led(at_s: f64) -> (Option<f64>, Option<f64>) {
    (None, Some(4.0 + (at_s / 8.0).sin()))
}

#[test]
fn changing_advice_on_a_free_road_tells_all_but_the_time_gap() {
    let drive = driven(SOMEBODY, 900, changing);
    let found = fit(&[&drive]);
    let reaction = found.reaction_s.unwrap();
    // A moment: what lies between is guessed by a parabola.
    assert!((reaction.value - 1.2).abs() < 0.1, "{reaction:?}");
    // 900 s are 90 independent pieces of a wander of 5 s: standard errors of 0.03 m/s and 7 %, three of them.
    let (bias, error) = (found.speed_bias_mps.unwrap(), found.error_mps.unwrap());
    assert!((bias.value - 0.4).abs() < 0.1, "{bias:?}");
    assert!((error.value / 0.3 - 1.0).abs() < 0.22, "{error:?}");
    for number in [reaction, bias, error] {
        let [low, high] = number.interval;
        assert!(low < number.value && number.value < high && number.rests_on_s > 800.0, "{number:?}");
    }
    assert_eq!(found.time_gap_factor, None, "there was nobody to keep a distance from");
    assert_eq!(fit(&[&drive]), found, "the same drive gives the same numbers");
}

#[test]
fn advice_that_never_changes_tells_no_reaction_time() {
    let found = fit(&[&driven(SOMEBODY, 900, constant)]);
    assert_eq!(found.reaction_s, None);
    assert!((found.speed_bias_mps.unwrap().value - 0.4).abs() < 0.1, "{found:?}");
}

#[test]
fn a_leader_tells_the_time_gap_alone() {
    let found = fit(&[&driven(SOMEBODY, 300, led)]);
    let gap = found.time_gap_factor.unwrap();
    assert!((gap.value - 1.3).abs() < 0.05 && gap.rests_on_s > 200.0, "{gap:?}");
    assert_eq!((found.reaction_s, found.speed_bias_mps, found.error_mps), (None, None, None));
}

#[test]
fn drives_of_one_person_are_taken_together() {
    let drives = [driven(SOMEBODY, 900, changing), driven(SOMEBODY, 300, led)];
    let found = fit(&drives.iter().collect::<Vec<_>>());
    assert!(found.numbers().iter().all(Option::is_some), "{found:?}");
    assert!((found.time_gap_factor.unwrap().value - 1.3).abs() < 0.05, "{found:?}");
    assert!((found.speed_bias_mps.unwrap().value - 0.4).abs() < 0.1, "{found:?}");
}

#[test]
fn a_moment_behind_a_slow_leader_pulls_no_bias_down() {
    // Advised 5 m/s behind a leader who mostly goes slower: most of the time the leader decides.
    let behind: Plan = |at_s| (Some([4.5, 5.2][(at_s / 9.0) as usize % 2]), Some(4.6 + (at_s / 15.0).sin()));
    let drive = driven(SOMEBODY, 1800, behind);
    let mean_off: f64 = {
        let all = drive.stretches.iter().flatten();
        let off: Vec<f64> = all.map(|m| f64::from(m.speed_mps - m.advised_mps.unwrap())).collect();
        off.iter().sum::<f64>() / off.len() as f64
    };
    let bias = fit(&[&drive]).speed_bias_mps.unwrap();
    assert!(mean_off < 0.1, "the plain mean is far off: {mean_off}");
    assert!((bias.value - 0.4).abs() < 0.15, "{bias:?}");
}

#[test]
fn too_little_tells_nothing() {
    assert_eq!(fit(&[]), FoundDriver::default());
    assert_eq!(fit(&[&driven(SOMEBODY, 25, changing)]), FoundDriver::default());
    assert_eq!(fit(&[&DriverStretches::default()]), FoundDriver::default());
}
