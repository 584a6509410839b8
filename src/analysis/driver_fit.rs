//! A driver in the numbers of the simulated one, from what was advised and what was driven. In: stretches of all drives of one
//! person. Out: reaction time to advice, bias, error and time gap, each with a 95 % interval, or `None` where the drives do not tell.
//!
//! The simulated driver ([`crate::driver`]) wants the smaller of two accelerations: "reach the advised speed of a reaction time ago,
//! plus a bias, plus a wander" and "keep behind the leader" (IDM). Its wish is read from the drive: the speed that it is on the way to
//! is its speed plus the time in which it closes a difference (1.5 s) times the acceleration that the car has 0.3 s later.
//!
//! * **Bias, error, time gap**: the likelihood of the smaller of two normal variables, one about the advice plus the bias with the
//!   error as its deviation, one about what the car-following model asks for with this time gap. So a moment behind a slow leader
//!   counts as "wanted at least this" and pulls no bias down. Intervals: jackknife over [`GROUPS`] parts of the time, since moments
//!   close to each other are not independent.
//! * **Reaction**: the delay of the advice for which the innovations of the wander (its change beyond what a time constant of 5 s
//!   foretells) are smallest, over the moments that the leader did not decide. Interval: bootstrap over the stretches.
//!
//! What this cannot tell: a reaction time where the advice did not change while the driver followed it, or changed too little to stand
//! out; a time gap where the leader decided for less than [`LEAST_S`]; an error below 0.15 m/s to better than half of itself, for foot
//! and car err, too. Somebody who ignores the advice looks like one with a large error. The numbers are those with which the simulated
//! driver would drive alike; of people they say what they do, not how they think.

use super::driver_moments::{AFTER, BEFORE, DriverStretches, MOMENT_S, Moment};
use crate::{driver::DriverParams, rng};

/// Time in which the simulated driver closes a difference of speed, s.
const RELAX_S: f64 = 1.5;
/// The acceleration is taken so many moments after the wish: foot, engine and tyres answer within 0.1 to 0.4 s.
const CAR_LAG: usize = 3;
/// From a change of the wish to the car's acceleration, s: foot, engine and tyres. In the median of 20 rehearsed participants, whose
/// reaction times are known.
const ANSWER_LAG_S: f64 = 0.235;
/// Time constant of the wander, s.
const WANDER_S: f64 = 5.0;
/// Over which innovations of the wander are taken, moments: half a second, which is longer than the pedals' own movement.
const INNOVATION: usize = 5;
/// Delays that are tried: up to 2.9 s in tenths; what is seen before a stretch is long enough for them and the innovation.
const DELAYS: usize = BEFORE;
/// An innovation beyond this counts as this, m/s: a change of mind is no tracking error.
const MOST_INNOVATION_MPS: f64 = 1.0;
/// Below this speed a car creeps, and its driver does not follow a speed, m/s.
const MOVING_MPS: f64 = 1.0;
/// Room to the speed limit and to the speed in bends, in which these do not decide, m/s.
const ROOM_MPS: f64 = 1.0;
/// Shares of the largest accelerations below which these do not decide.
const NOT_FLOORED: f64 = 0.92;
/// The driver is free of the leader where he is this far below the speed that the leader allows, m/s.
const FREE_MPS: f64 = 0.3;
/// Time in which the advice, or the leader, has to decide before anything is told of it, s.
pub const LEAST_S: f64 = 30.0;
/// Changes of the advice of at least [`CHANGE_MPS`] from which on a reaction is told.
const LEAST_CHANGES: usize = 5;
const CHANGE_MPS: f32 = 0.1;
/// Intervals that are wider tell nothing: reaction, s, and time gap factor.
const WIDEST_REACTION_S: f64 = 1.0;
const WIDEST_FACTOR: f64 = 0.5;
/// What is not of chance and so in no resample: lags differ from pedal to pedal, and the leader is not seen as the model has it.
/// Reaction, s, bias, m/s, and time gap factor; the intervals reach further by this.
const LAG_ERROR_S: f64 = 0.05;
const BIAS_ERROR_MPS: f64 = 0.03;
const FACTOR_ERROR: f64 = 0.03;
/// Parts of the time for the jackknife, at the most and at the least.
pub const GROUPS: usize = 20;
const LEAST_GROUPS: usize = 5;
/// Moments of the likelihood at the most, and at least so far apart: two a second.
const MOST_MOMENTS: usize = 7200;
const THINNED: usize = 5;
/// Resamples of the bootstrap.
const RESAMPLES: usize = 1000;

/// A number of a driver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundNumber {
    /// The likeliest.
    pub value: f64,
    /// Ends of the 95 % interval.
    pub interval: [f64; 2],
    /// Time in which it showed, s.
    pub rests_on_s: f64,
}

/// What was found of a driver; `None` where the drives do not tell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FoundDriver {
    /// Time from a change of the advice to the foot's movement, s.
    pub reaction_s: Option<FoundNumber>,
    /// Standard deviation of the wanted speed around the advised one, m/s.
    pub error_mps: Option<FoundNumber>,
    /// Always this much faster (positive) than advised, m/s.
    pub speed_bias_mps: Option<FoundNumber>,
    /// Desired time gap as a multiple of the other cars'.
    pub time_gap_factor: Option<FoundNumber>,
}

/// What the driver wanted at a moment, and why.
#[derive(Clone, Copy, Debug, Default)]
struct WantedSpeed {
    /// Speed that the car is on the way to, m/s.
    wanted_mps: f64,
    /// Advised speed a reaction time ago.
    advised_mps: Option<f64>,
    behind: SeenAhead,
    /// Part of the time for the jackknife.
    group: usize,
}

/// What the car-following model needs.
#[derive(Clone, Copy, Debug, Default)]
struct SeenAhead {
    speed_mps: f64,
    limit_mps: f64,
    gap_m: f64,
    leader_mps: f64,
    usual_time_gap_s: f64,
}

impl SeenAhead {
    /// Speed that the model is on the way to with this time gap, m/s.
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

/// What a driver wanted, moment by moment.
struct WantedSpeeds {
    moments: Vec<WantedSpeed>,
    /// Time for which each stands, s.
    each_s: f64,
}

/// Bias (m/s), logarithm of the error (m/s), time gap factor, logarithm of how closely the leader is followed (m/s).
type Numbers = [f64; 4];
/// Where the search may go. A following that is looser than 0.2 m/s would take the place of the error.
const LIMITS: [[f64; 2]; 4] = [[-10.0, 10.0], [-3.5, 1.61], [0.4, 3.0], [-3.5, -1.6]];
/// First and last steps of the search.
const STEPS: [f64; 4] = [0.2, 0.3, 0.15, 0.3];
const FINEST: f64 = 1.0 / 64.0;
/// Where it begins, and with which time gaps: from one alone it may end where the error takes the place of the leader.
const FIRST: Numbers = [0.0, -1.2, 1.0, -2.3];
const FIRST_FACTORS: [f64; 3] = [0.7, 1.0, 1.4];
/// Delay of the advice where it cannot be told, s.
const USUAL_DELAY_S: f64 = 1.0;

/// Fits one driver to all his drives; the same drives give the same numbers.
pub fn fit(drives: &[&DriverStretches]) -> FoundDriver {
    let mut numbers = FIRST;
    let mut wanted = WantedSpeeds { moments: Vec::new(), each_s: 0.0 };
    // What is free of the leader depends on the time gap, and what was seen on the reaction.
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

/// Bias, error and time gap with their intervals.
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

/// Student's t, two-sided 95 %, of four degrees of freedom or more: within 2 %, by its series in the inverse of these.
fn student_95(degrees: f64) -> f64 {
    1.96 + 2.37 / degrees + 2.82 / degrees.powi(2)
}

/// What the driver wanted, two moments a second or fewer; he acts on advice of `delay_s` ago.
fn wanted_speeds(drives: &[&DriverStretches], delay_s: f64) -> WantedSpeeds {
    let count: usize = drives.iter().flat_map(|drive| &drive.stretches).map(Vec::len).sum();
    let every = count.div_ceil(MOST_MOMENTS).max(THINNED);
    let stretches: usize = drives.iter().map(|drive| drive.stretches.len()).sum();
    let delay = (delay_s / MOMENT_S).round() as usize;
    // The simulated driver answers a leader in 0.7 of the time that he takes for advice.
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

/// The speed that the driver is on the way to at moment `i`, m/s; `None` where something else than advice or leader decides.
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

/// The leader as a driver takes him to be who sees him `delay` moments late: he goes on as he did then, and brakes on if he braked.
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

/// Densities of a moment: the advice decided, the leader did.
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

/// Share of a normal distribution below so many deviations, to 0.01 (by the logistic one).
fn share_below(deviations: f64) -> f64 {
    1.0 / (1.0 + (-1.702 * deviations).exp())
}

impl WantedSpeeds {
    /// Minus the logarithm of the likelihood of all moments but those of a group.
    fn misfit(&self, numbers: &Numbers, without: Option<usize>) -> f64 {
        /// What a moment that neither explains counts: it is no reason to give up all others.
        const STRAY: f64 = 1e-4;
        let of = |moment: &WantedSpeed| -(densities(numbers, moment).iter().sum::<f64>() + STRAY).ln();
        self.moments.iter().filter(|moment| Some(moment.group) != without).map(of).sum()
    }

    /// Time in which the advice and in which the leader decided, s.
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

/// The numbers of the largest likelihood near `from`: each in turn is moved as long as that helps, then by half as much.
fn search(from: Numbers, wanted: &WantedSpeeds, without: Option<usize>, first: f64) -> Numbers {
    /// Far more than a search takes: each round that moves nothing halves the steps.
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

/// Squared innovations of the wander by the delay of the advice.
struct DelayProfile {
    /// A row a stretch.
    rows: Vec<[f64; DELAYS]>,
    free_s: f64,
    changes: usize,
}

impl DelayProfile {
    /// Over the moments in which the leader, with this time gap, does not decide.
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

    /// The likeliest delay, s.
    fn best(&self) -> Option<f64> {
        let is_told = self.rows.len() >= LEAST_GROUPS && self.free_s >= LEAST_S && self.changes >= LEAST_CHANGES;
        is_told.then(|| self.least(0..self.rows.len()))
    }

    /// The delay of the smallest sum over these stretches, s: between the tenths by a parabola.
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

    /// The reaction time with its interval, where the advice changed enough to tell it.
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
        // The delay of the advice was tried against an acceleration that is itself taken late.
        let reaction_s = |delay_s: f64| (delay_s + CAR_LAG as f64 * MOMENT_S - ANSWER_LAG_S).max(0.0);
        let interval = [reaction_s(interval[0] - LAG_ERROR_S), reaction_s(interval[1] + LAG_ERROR_S)];
        is_told.then_some(FoundNumber { value: reaction_s(value), interval, rests_on_s: self.free_s })
    }
}

#[cfg(test)]
#[path = "driver_fit_tests.rs"]
mod tests;
