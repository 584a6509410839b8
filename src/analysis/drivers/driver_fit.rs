//! Fit of the simulated driver's parameters to a person, from advised and driven speeds. In: stretches of all drives of the
//! person. Out: reaction time to advice, bias, error and time gap, each with a 95 % interval, or `None` where the drives do not
//! determine it.
//!
//! The simulated driver ([`crate::driver`]) takes the smaller of two accelerations: "reach the advised speed of a reaction time
//! ago, plus a bias, plus a wander" and "keep behind the leader" (IDM). The wanted speed is estimated from the drive: the
//! current speed, plus the time in which the driver closes a speed difference (1.5 s) times the acceleration 0.3 s later.
//!
//! * **Bias, error, time gap**: the likelihood of the minimum of two normal variables. One has the advice plus the bias as its
//!   mean and the error as its deviation; the other has the speed that the car-following model allows with this time gap as its
//!   mean. A moment behind a slow leader thus counts as "wanted at least this" and does not lower the bias. Intervals:
//!   jackknife over [`GROUPS`] parts of the time, since neighbouring moments are not independent.
//! * **Reaction**: the delay of the advice with the smallest innovations of the wander (its change beyond the prediction with a
//!   time constant of 5 s), over the moments not decided by the leader. Interval: bootstrap over the stretches.
//!
//! Limits: no reaction time where the advice did not change while the driver followed it, or changed too little; no time gap
//! where the leader decided for less than [`LEAST_S`]; an error below 0.15 m/s only to about half of itself, because foot and
//! car add errors of their own. A driver who ignores the advice looks like one with a large error. With the fitted numbers the
//! simulated driver drives alike; for people they describe behaviour, not how people think.

use crate::analysis::data::{
    DriverStretches,
    driver_moments::{AFTER, BEFORE, MOMENT_S, Moment},
};
use crate::{driver::DriverParams, rng};

/// Time constant with which the simulated driver closes a speed difference, s.
const RELAX_S: f64 = 1.5;
/// Delay from the wanted speed to the acceleration that is read for it, moments: foot, engine and tyres respond within 0.1 to
/// 0.4 s.
const CAR_LAG: usize = 3;
/// Delay from a change of the wanted speed to the car's acceleration (foot, engine, tyres), s: median over 20 rehearsed
/// participants with known reaction times.
const RESPONSE_LAG_S: f64 = 0.235;
/// Time constant of the wander (the slow error of the wanted speed), s.
const WANDER_S: f64 = 5.0;
/// Span of an innovation of the wander, moments: 0.5 s, longer than the pedals' own movement.
const INNOVATION: usize = 5;
/// Number of delays tried: 0 to 2.9 s in tenths. The moments before a stretch cover them and the innovation.
const DELAYS: usize = BEFORE;
/// Cap of an innovation, m/s: a change of mind is not a tracking error.
const MOST_INNOVATION_MPS: f64 = 1.0;
/// Speed at or below which a car creeps and its driver does not follow a speed, m/s.
const MOVING_MPS: f64 = 1.0;
/// Margin to the speed limit and to the speed in bends, m/s; closer to them, they decide.
const ROOM_MPS: f64 = 1.0;
/// Share of the driver's largest acceleration and braking beyond which these decide.
const NOT_FLOORED: f64 = 0.92;
/// Margin of the wanted speed below the speed that the leader allows, m/s: with more, the driver is free of the leader.
const FREE_MPS: f64 = 0.3;
/// Minimum time in which the advice, or the leader, decides for a result, s.
pub const LEAST_S: f64 = 30.0;
/// Minimum number of changes of the advice, each of at least [`CHANGE_MPS`], for a reaction time.
const LEAST_CHANGES: usize = 5;
const CHANGE_MPS: f32 = 0.1;
/// Widest intervals that are reported: reaction, s, and time gap factor.
const WIDEST_REACTION_S: f64 = 1.0;
const WIDEST_FACTOR: f64 = 0.5;
/// Systematic errors, which no resampling shows: lags differ from pedal to pedal, and the leader is not seen exactly as the
/// model assumes. Reaction, s, bias, m/s, and time gap factor; the intervals are extended by these on both sides.
const LAG_ERROR_S: f64 = 0.05;
const BIAS_ERROR_MPS: f64 = 0.03;
const FACTOR_ERROR: f64 = 0.03;
/// Largest and smallest number of parts of the time for the jackknife.
pub const GROUPS: usize = 20;
const LEAST_GROUPS: usize = 5;
/// Largest number of moments in the likelihood, and their smallest spacing in moments: two a second.
const MOST_MOMENTS: usize = 7200;
const THINNED: usize = 5;
/// Resamples of the bootstrap.
const RESAMPLES: usize = 1000;

/// A fitted number of a driver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundNumber {
    /// Maximum-likelihood estimate, in the number's own unit.
    pub value: f64,
    /// Ends of the 95 % interval.
    pub interval: [f64; 2],
    /// Time that the estimate is based on, s.
    pub rests_on_s: f64,
}

/// Fitted numbers of a driver; `None` where the drives do not determine one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FoundDriver {
    /// Time from a change of the advice to the foot's movement, s.
    pub reaction_s: Option<FoundNumber>,
    /// Standard deviation of the wanted speed around the advised one, m/s.
    pub error_mps: Option<FoundNumber>,
    /// Constant offset from the advised speed, m/s; positive is faster.
    pub speed_bias_mps: Option<FoundNumber>,
    /// Desired time gap as a multiple of the other vehicles'.
    pub time_gap_factor: Option<FoundNumber>,
}

/// Wanted speed of the driver at a moment, with the advice and the leader.
#[derive(Clone, Copy, Debug, Default)]
struct WantedSpeed {
    /// Speed that the car is approaching, m/s.
    wanted_mps: f64,
    /// Advised speed a reaction time ago, m/s.
    advised_mps: Option<f64>,
    behind: SeenAhead,
    /// Part of the time for the jackknife.
    group: usize,
}

/// Inputs of the car-following model.
#[derive(Clone, Copy, Debug, Default)]
struct SeenAhead {
    speed_mps: f64,
    limit_mps: f64,
    gap_m: f64,
    leader_mps: f64,
    usual_time_gap_s: f64,
}

impl SeenAhead {
    /// Returns the speed that the model approaches with this time gap, m/s.
    fn allowed_mps(&self, time_gap_factor: f64) -> f64 {
        let usual = DriverParams::default().idm;
        let idm = crate::idm::IdmParams {
            t: time_gap_factor * self.usual_time_gap_s,
            v0: usual.v0.min(self.limit_mps.max(1.0)),
            ..usual
        };
        self.speed_mps + RELAX_S * idm.acceleration(self.speed_mps, self.leader_mps, self.gap_m)
    }
}

/// Wanted speeds of a driver, moment by moment.
struct WantedSpeeds {
    moments: Vec<WantedSpeed>,
    /// Time that each moment represents, s.
    each_s: f64,
}

/// Fit parameters: bias (m/s), ln of the error (m/s), time gap factor, ln of the deviation around the leader's allowed speed
/// (m/s).
type Numbers = [f64; 4];
/// Bounds of the search. A deviation around the leader's allowed speed above 0.2 m/s would take the place of the error.
const LIMITS: [[f64; 2]; 4] = [[-10.0, 10.0], [-3.5, 1.61], [0.4, 3.0], [-3.5, -1.6]];
/// First steps of the search, and the smallest scale of them.
const STEPS: [f64; 4] = [0.2, 0.3, 0.15, 0.3];
const FINEST: f64 = 1.0 / 64.0;
/// Start of the search, and the time gaps to start from. From one alone, the error may end up in the place of the leader.
const FIRST: Numbers = [0.0, -1.2, 1.0, -2.3];
const FIRST_FACTORS: [f64; 3] = [0.7, 1.0, 1.4];
/// Delay of the advice where it cannot be estimated, s.
const USUAL_DELAY_S: f64 = 1.0;

/// Fits one driver to all of their drives; the same drives give the same numbers.
pub fn fit(drives: &[&DriverStretches]) -> FoundDriver {
    let mut numbers = FIRST;
    let mut wanted = WantedSpeeds { moments: Vec::new(), each_s: 0.0 };
    // Moments free of the leader depend on the time gap, and the advice seen depends on the reaction time.
    for round in 0..3 {
        let profile = DelayProfile::of(drives, numbers[2]);
        let delay = profile.best();
        wanted = wanted_speeds(drives, delay.unwrap_or(USUAL_DELAY_S));
        let [bias, error, factor, loose] = numbers;
        let starts = if round == 0 { FIRST_FACTORS.to_vec() } else { vec![factor] };
        let found = starts.into_iter().map(|factor| search([bias, error, factor, loose], &wanted, None, 1.0));
        let best = found.min_by(|a, b| wanted.misfit(a, None).total_cmp(&wanted.misfit(b, None)));
        numbers = best.unwrap_or(numbers);
    }
    let reaction_s = DelayProfile::of(drives, numbers[2]).reaction();
    FoundDriver { reaction_s, ..of_numbers(&numbers, &wanted) }
}

/// Returns bias, error and time gap with their intervals.
fn of_numbers(numbers: &Numbers, wanted: &WantedSpeeds) -> FoundDriver {
    let groups = wanted.moments.iter().map(|moment| moment.group + 1).max().unwrap_or(0);
    if groups < LEAST_GROUPS {
        return FoundDriver::default();
    }
    let without: Vec<Numbers> = (0..groups).map(|group| search(*numbers, wanted, Some(group), 0.25)).collect();
    let spread = |k: usize| {
        let n = without.len() as f64;
        let mean = without.iter().map(|other| other[k]).sum::<f64>() / n;
        student_95(n - 1.0)
            * ((n - 1.0) / n * without.iter().map(|other| (other[k] - mean).powi(2)).sum::<f64>()).sqrt()
    };
    let [free_s, behind_s] = wanted.seconds(numbers);
    let number = |k: usize, rests_on_s: f64, of: fn(f64) -> f64, more: f64| {
        let interval = [of(numbers[k] - spread(k)) - more, of(numbers[k] + spread(k)) + more];
        (rests_on_s >= LEAST_S).then_some(FoundNumber { value: of(numbers[k]), interval, rests_on_s })
    };
    let same = std::convert::identity;
    FoundDriver {
        reaction_s: None,
        error_mps: number(1, free_s, f64::exp, 0.0),
        speed_bias_mps: number(0, free_s, same, BIAS_ERROR_MPS),
        time_gap_factor: number(2, behind_s, same, FACTOR_ERROR)
            .filter(|n| n.interval[1] - n.interval[0] <= WIDEST_FACTOR),
    }
}

/// Returns the two-sided 95 % bound of Student's t, within 2 % from four degrees of freedom on (series in the inverse of
/// `degrees`).
fn student_95(degrees: f64) -> f64 {
    1.96 + 2.37 / degrees + 2.82 / degrees.powi(2)
}

/// Returns the wanted speeds, at most two moments a second, of a driver who acts on the advice of `delay_s` ago.
fn wanted_speeds(drives: &[&DriverStretches], delay_s: f64) -> WantedSpeeds {
    let count: usize = drives.iter().flat_map(|drive| &drive.stretches).map(Vec::len).sum();
    let every = count.div_ceil(MOST_MOMENTS).max(THINNED);
    let stretches: usize = drives.iter().map(|drive| drive.stretches.len()).sum();
    let delay = (delay_s / MOMENT_S).round() as usize;
    // The simulated driver's reaction time to a leader is 0.7 of that to advice.
    let leader_delay = (0.7 * delay_s / MOMENT_S).round() as usize;
    let mut moments = Vec::new();
    let all = drives.iter().flat_map(|drive| drive.stretches.iter().map(|stretch| (drive.usual_time_gap_s, stretch)));
    for (number, (usual_time_gap_s, stretch)) in all.enumerate() {
        for i in (BEFORE..stretch.len() - AFTER).step_by(every) {
            let Some(wanted_mps) = wanted_mps(stretch, i) else { continue };
            moments.push(WantedSpeed {
                wanted_mps,
                advised_mps: stretch[i - delay].advised_mps.map(f64::from),
                behind: SeenAhead { usual_time_gap_s, ..seen_ahead(stretch, i, leader_delay) },
                group: number * GROUPS.min(stretches) / stretches,
            });
        }
    }
    WantedSpeeds { moments, each_s: every as f64 * MOMENT_S }
}

/// Returns the speed that the driver approaches at moment `i`, m/s; `None` where neither advice nor leader decides.
fn wanted_mps(stretch: &[Moment], i: usize) -> Option<f64> {
    let now = &stretch[i];
    let speed_mps = f64::from(now.speed_mps);
    let accel_mps2 =
        f64::from(stretch[i + CAR_LAG + 1].speed_mps - stretch[i + CAR_LAG - 1].speed_mps) / (2.0 * MOMENT_S);
    let usual = DriverParams::default();
    let floored = accel_mps2 > NOT_FLOORED * usual.accel_mps2 || accel_mps2 < -NOT_FLOORED * usual.decel_mps2;
    let aim_mps = f64::from(now.advised_mps.map_or(now.speed_mps, |advised| advised.max(now.speed_mps)));
    let is_bound = aim_mps + ROOM_MPS > f64::from(now.limit_mps.min(now.bend_mps));
    (speed_mps > MOVING_MPS && !floored && !is_bound).then_some(speed_mps + RELAX_S * accel_mps2)
}

/// Returns the leader as extrapolated by a driver who sees it `delay` moments late: at constant speed, or braking on if it
/// braked.
fn seen_ahead(stretch: &[Moment], i: usize, delay: usize) -> SeenAhead {
    let (now, then, before) = (&stretch[i], &stretch[i - delay], &stretch[i - delay - 2]);
    let leader_mps = f64::from(then.leader_mps);
    let brake_mps2 = (f64::from(before.leader_mps - then.leader_mps) / (2.0 * MOMENT_S)).clamp(0.0, 9.0);
    let late_s = delay as f64 * MOMENT_S;
    let braked_s = if brake_mps2 > 0.0 { late_s.min(leader_mps / brake_mps2) } else { late_s };
    let slowed_mps = (leader_mps - brake_mps2 * braked_s).max(0.0);
    let own_way_m: f64 = stretch[i - delay..i].iter().map(|moment| f64::from(moment.speed_mps) * MOMENT_S).sum();
    SeenAhead {
        speed_mps: now.speed_mps.into(),
        limit_mps: now.limit_mps.into(),
        gap_m: f64::from(then.gap_m) + f64::midpoint(leader_mps, slowed_mps) * braked_s - own_way_m,
        leader_mps: slowed_mps,
        usual_time_gap_s: 0.0,
    }
}

/// Returns the densities of a moment (without 1/sqrt(2 pi)): the advice decided, the leader decided.
fn densities(numbers: &Numbers, moment: &WantedSpeed) -> [f64; 2] {
    let [bias_mps, log_error, factor, log_loose] = *numbers;
    let (error_mps, loose_mps) = (log_error.exp(), log_loose.exp());
    let allowed_mps = moment.behind.allowed_mps(factor);
    let normal = |off: f64, deviation: f64| (-0.5 * (off / deviation).powi(2)).exp() / deviation;
    let led = normal(moment.wanted_mps - allowed_mps, loose_mps);
    let Some(advised_mps) = moment.advised_mps else { return [0.0, led] };
    let own_mps = advised_mps + bias_mps;
    let free =
        normal(moment.wanted_mps - own_mps, error_mps) * share_below((allowed_mps - moment.wanted_mps) / loose_mps);
    [free, led * share_below((own_mps - moment.wanted_mps) / error_mps)]
}

/// Approximates the standard normal distribution function by the logistic one, to 0.01.
fn share_below(deviations: f64) -> f64 {
    1.0 / (1.0 + (-1.702 * deviations).exp())
}

impl WantedSpeeds {
    /// Returns the negative log-likelihood of all moments outside the group `without`.
    fn misfit(&self, numbers: &Numbers, without: Option<usize>) -> f64 {
        /// Density floor: a moment that neither explains does not outweigh all others.
        const STRAY: f64 = 1e-4;
        let of = |moment: &WantedSpeed| -(densities(numbers, moment).iter().sum::<f64>() + STRAY).ln();
        self.moments.iter().filter(|moment| Some(moment.group) != without).map(of).sum()
    }

    /// Returns the time in which the advice and in which the leader decided, s.
    fn seconds(&self, numbers: &Numbers) -> [f64; 2] {
        let mut sums = [0.0; 2];
        for moment in &self.moments {
            let [free, led] = densities(numbers, moment);
            if free + led > 0.0 {
                sums[0] += free / (free + led);
                sums[1] += led / (free + led);
            }
        }
        sums.map(|sum| sum * self.each_s)
    }
}

/// Maximises the likelihood near `from` by coordinate search: moves each number while that helps, then halves the steps.
fn search(from: Numbers, wanted: &WantedSpeeds, without: Option<usize>, first: f64) -> Numbers {
    /// Upper bound of rounds, far above the usual number: each round without a move halves the steps.
    const MOST_ROUNDS: usize = 200;
    let mut best = from;
    let mut least = wanted.misfit(&best, without);
    let mut scale = first;
    for _ in 0..MOST_ROUNDS {
        let mut has_moved = false;
        for k in 0..best.len() {
            for step in [STEPS[k] * scale, -STEPS[k] * scale] {
                let mut other = best;
                other[k] = (other[k] + step).clamp(LIMITS[k][0], LIMITS[k][1]);
                let now = wanted.misfit(&other, without);
                if now < least {
                    (best, least, has_moved) = (other, now, true);
                    break;
                }
            }
        }
        if !has_moved {
            scale /= 2.0;
            if scale < FINEST {
                break;
            }
        }
    }
    best
}

/// Squared innovations of the wander, for each delay of the advice.
struct DelayProfile {
    /// Sums of squares by delay, (m/s)^2, one row per stretch.
    rows: Vec<[f64; DELAYS]>,
    free_s: f64,
    changes: usize,
}

impl DelayProfile {
    /// Sums over the moments in which the leader, with this time gap, does not decide.
    fn of(drives: &[&DriverStretches], time_gap_factor: f64) -> Self {
        let mut profile = Self { rows: Vec::new(), free_s: 0.0, changes: 0 };
        for drive in drives {
            for stretch in &drive.stretches {
                profile.add(stretch, drive.usual_time_gap_s, time_gap_factor);
            }
        }
        profile
    }

    fn add(&mut self, stretch: &[Moment], usual_time_gap_s: f64, time_gap_factor: f64) {
        let free = |i: usize| {
            let ahead = SeenAhead { usual_time_gap_s, ..seen_ahead(stretch, i, 0) };
            wanted_mps(stretch, i).filter(|wanted_mps| *wanted_mps < ahead.allowed_mps(time_gap_factor) - FREE_MPS)
        };
        let wanted: Vec<Option<f64>> = (BEFORE..stretch.len() - AFTER).map(free).collect();
        let keeps = (-(INNOVATION as f64) * MOMENT_S / WANDER_S).exp();
        let mut row = [0.0; DELAYS];
        let mut pairs = 0;
        for i in BEFORE + INNOVATION..stretch.len() - AFTER {
            let (Some(now), Some(before)) = (wanted[i - BEFORE], wanted[i - BEFORE - INNOVATION]) else { continue };
            let advised = |at: usize| stretch[at].advised_mps.map(f64::from);
            let innovation =
                |delay: usize| Some(now - advised(i - delay)? - keeps * (before - advised(i - INNOVATION - delay)?));
            let innovations: Option<Vec<f64>> = (0..DELAYS).map(innovation).collect();
            let Some(innovations) = innovations else { continue };
            for (sum, innovation) in row.iter_mut().zip(innovations) {
                *sum += innovation.abs().min(MOST_INNOVATION_MPS).powi(2);
            }
            pairs += 1;
            let is_change = |(a, b): (f32, f32)| (a - b).abs() >= CHANGE_MPS;
            self.changes += usize::from(stretch[i].advised_mps.zip(stretch[i - 1].advised_mps).is_some_and(is_change));
        }
        if pairs > 0 {
            self.rows.push(row);
            self.free_s += f64::from(pairs) * MOMENT_S;
        }
    }

    /// Returns the likeliest delay, s; `None` without enough stretches, time or changes of the advice.
    fn best(&self) -> Option<f64> {
        let is_told = self.rows.len() >= LEAST_GROUPS && self.free_s >= LEAST_S && self.changes >= LEAST_CHANGES;
        is_told.then(|| self.least(0..self.rows.len()))
    }

    /// Returns the delay with the smallest sum over these stretches, s, interpolated between tenths by a parabola.
    fn least(&self, stretches: impl Iterator<Item = usize>) -> f64 {
        let mut sums = [0.0; DELAYS];
        for stretch in stretches {
            sums.iter_mut().zip(&self.rows[stretch]).for_each(|(sum, row)| *sum += row);
        }
        let lowest = (0..DELAYS).min_by(|a, b| sums[*a].total_cmp(&sums[*b])).unwrap_or(0);
        let between = match lowest {
            0 => 0.0,
            last if last + 1 == DELAYS => 0.0,
            k => {
                let curve = sums[k - 1] - 2.0 * sums[k] + sums[k + 1];
                if curve > 0.0 { 0.5 * (sums[k - 1] - sums[k + 1]) / curve } else { 0.0 }
            }
        };
        (lowest as f64 + between) * MOMENT_S
    }

    /// Returns the reaction time with its interval; `None` if the advice changed too little or the interval is too wide.
    fn reaction(&self) -> Option<FoundNumber> {
        let value = self.best()?;
        let n = self.rows.len();
        let mut stream = rng::stream(n as u64, "reaction");
        let mut resample = || {
            let drawn: Vec<usize> = (0..n).map(|_| stream.index(n)).collect();
            self.least(drawn.into_iter())
        };
        let mut values: Vec<f64> = (0..RESAMPLES).map(|_| resample()).collect();
        values.sort_by(f64::total_cmp);
        let at = |share: f64| values[(share * (RESAMPLES - 1) as f64).round() as usize];
        let interval = [at(0.025), at(0.975)];
        let is_told = interval[1] - interval[0] <= WIDEST_REACTION_S && value < (DELAYS - 1) as f64 * MOMENT_S;
        // The delay was fitted against an acceleration that is itself read [`CAR_LAG`] moments late.
        let reaction_s = |delay_s: f64| (delay_s + CAR_LAG as f64 * MOMENT_S - RESPONSE_LAG_S).max(0.0);
        let interval = [reaction_s(interval[0] - LAG_ERROR_S), reaction_s(interval[1] + LAG_ERROR_S)];
        is_told.then_some(FoundNumber { value: reaction_s(value), interval, rests_on_s: self.free_s })
    }
}

#[cfg(test)]
#[path = "driver_fit_tests.rs"]
mod tests;
