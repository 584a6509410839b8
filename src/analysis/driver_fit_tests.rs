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
    // Two standard errors to either side, and half as much again.
    assert!(error.interval[1] - error.interval[0] < 0.3 * 6.0 * 0.07, "{error:?}");
    for number in [reaction, bias, error] {
        let [low, high] = number.interval;
        assert!(
            low < number.value && number.value < high && (800.0..=900.0).contains(&number.rests_on_s),
            "{number:?}"
        );
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

/// A free road: advised 5 m/s, and nobody near.
const FREE: WantedSpeed = WantedSpeed {
    wanted_mps: 5.0,
    advised_mps: Some(5.0),
    behind: SeenAhead { speed_mps: 5.0, limit_mps: 30.0, gap_m: 1e6, leader_mps: 5.0, usual_time_gap_s: USUAL_S },
    group: 0,
};

#[test]
fn the_likeliest_bias_is_found_on_either_side_of_where_the_search_begins() {
    for bias_mps in [-0.37, 0.53] {
        // As often 0.2 m/s above the advice with its bias as below.
        let moment = |k: usize| WantedSpeed { wanted_mps: 5.0 + bias_mps + [-0.2, 0.2][k % 2], ..FREE };
        let wanted = WantedSpeeds { moments: (0..100).map(moment).collect(), each_s: 0.5 };
        let [found_mps, log_error, ..] = search(FIRST, &wanted, None, 1.0);
        // The finest steps are 3 mm/s, and half a percent of the error.
        assert!((found_mps - bias_mps).abs() < 0.005 && (log_error - 0.2_f64.ln()).abs() < 0.01, "{found_mps}");
    }
}

#[test]
fn a_leader_who_allows_less_than_the_advice_decides() {
    let numbers = [0.0, 0.3_f64.ln(), 1.0, 0.1_f64.ln()];
    let [free, led] = densities(&numbers, &FREE);
    // On the advice the normal density is 1 / 0.3, but for the factor that all have.
    assert!((free - 1.0 / 0.3).abs() < 0.01 && led < 1e-6, "{free} {led}");
    let near = SeenAhead { gap_m: 6.0, leader_mps: 4.0, ..FREE.behind };
    assert!(near.allowed_mps(1.0) < 4.5, "by the model it has to brake");
    let [free, led] = densities(&numbers, &WantedSpeed { behind: near, ..FREE });
    assert!(free < 1e-3 && led < 1e-3, "nobody wants to go on at 5 m/s there: {free} {led}");
}

#[test]
fn a_leader_seen_late_is_taken_to_brake_on_until_it_stands() {
    // From `mps` on it slows down with 2 m/s2, and is seen half a second late, 20 m ahead; the own 4 m/s take 2 m meanwhile.
    let seen = |mps: f32| {
        let moment = |k: u8| Moment {
            speed_mps: 4.0,
            leader_mps: mps + 0.2 * (2.0 - f32::from(k)),
            gap_m: 20.0,
            ..Moment::default()
        };
        let stretch: Vec<Moment> = (0..=7).map(moment).collect();
        seen_ahead(&stretch, 7, 5)
    };
    let [goes, stands] = [6.0, 0.5].map(seen);
    assert!((goes.leader_mps - 5.0).abs() < 1e-5 && (goes.gap_m - (20.0 + 5.5 * 0.5 - 2.0)).abs() < 1e-5, "{goes:?}");
    // 0.5 m/s are gone after 0.25 s and 0.0625 m.
    assert!(stands.leader_mps.abs() < 1e-6 && (stands.gap_m - 18.0625).abs() < 1e-5, "{stands:?}");
}

#[test]
fn a_car_that_speeds_up_as_hard_as_drivers_do_tells_no_wish() {
    // The simulated driver's most is 1.5 m/s2, of which 92 % are 1.38 m/s2.
    let wish = |accel_mps2: f32| {
        let moment = |k: u8| Moment {
            speed_mps: 5.0 + f32::from(k) * 0.1 * accel_mps2,
            limit_mps: 30.0,
            bend_mps: f32::INFINITY,
            ..Moment::default()
        };
        wanted_mps(&(0..6).map(moment).collect::<Vec<_>>(), 0)
    };
    assert!(wish(1.3).is_some_and(|mps| (mps - (5.0 + 1.5 * 1.3)).abs() < 1e-4) && wish(1.45).is_none());
}

#[test]
fn between_tenths_of_a_second_the_delay_is_the_lowest_point_of_a_parabola() {
    let row = std::array::from_fn(|k| (k as f64 - 4.3).powi(2));
    let profile = DelayProfile { rows: vec![row], free_s: 0.0, changes: 0 };
    assert!((profile.least(0..1) - 0.43).abs() < 1e-9);
}

#[test]
fn too_little_tells_nothing() {
    assert_eq!(fit(&[]), FoundDriver::default());
    assert_eq!(fit(&[&driven(SOMEBODY, 25, changing)]), FoundDriver::default());
    assert_eq!(fit(&[&DriverStretches::default()]), FoundDriver::default());
}
