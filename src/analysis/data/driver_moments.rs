//! Input of the driver fit. In: a recorded drive, row by row. Out: [`DriverStretches`]: ten moments a second in stretches of 20
//! s, evenly spaced over the drive, half an hour at most. A drive of days takes no more memory than one of hours. SI units.

use super::{ego_samples::EgoSample, thinned_values::ThinnedValues, trial::RecordedTrial};
use crate::{
    driver::{DriverParams, bend_speed_mps},
    record::Table,
    space::CAR_LENGTH_M,
    time::TICK_S,
};
use std::collections::VecDeque;

/// Ticks from one moment to the next: 0.1 s, a third of the precision to which reaction times can be estimated.
const MOMENT_TICKS: u64 = 10;
/// Time from one moment to the next, s.
pub(crate) const MOMENT_S: f64 = MOMENT_TICKS as f64 * TICK_S;
/// Moments before a stretch in which a driver may have seen the cause of an action in it: 3 s.
pub(crate) const BEFORE: usize = 30;
/// Moments after a stretch in which the car carries out the driver's last actions: 0.4 s.
pub(crate) const AFTER: usize = 4;
/// Moments of a stretch: 20 s, four time constants of the wander, so that stretches are nearly independent.
pub(crate) const STRETCH: usize = 200;
/// Moments of the shortest stretch that is kept: 5 s.
const LEAST: usize = 50;
/// Largest number of stretches kept of one drive.
const MOST_STRETCHES: usize = 90;
/// Gap where no vehicle is ahead, m: without effect in the car-following model.
const NOBODY_M: f64 = 1e6;

/// State of the drive at a moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Moment {
    /// Own speed, m/s.
    pub speed_mps: f32,
    /// Advised speed, m/s.
    pub advised_mps: Option<f32>,
    /// Gap to the leader, metres.
    pub gap_m: f32,
    /// Speed of the leader, m/s; the own speed if there is none.
    pub leader_mps: f32,
    /// Speed limit of the road, m/s.
    pub limit_mps: f32,
    /// Highest speed from which every bend ahead is comfortable, m/s.
    pub bend_mps: f32,
}

/// Stretches of one drive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DriverStretches {
    /// Desired time gap of the other vehicles, s.
    pub(crate) usual_time_gap_s: f64,
    /// Stretches, each with the moments before and after it.
    pub(crate) stretches: Vec<Vec<Moment>>,
}

/// Cuts a drive into stretches.
struct StretchCutter {
    kept: ThinnedValues<Vec<Moment>>,
    recent: VecDeque<Moment>,
    last_tick: Option<u64>,
}

/// Collects the stretches of a drive from the ego's rows. A drive past signals has none.
pub struct StretchCollector<'a> {
    trial: &'a RecordedTrial,
    usual: DriverParams,
    /// `None` with a table of signals: the simulated driver of the fit knows advice, bends and a leader, but no signals and no right of way.
    cutter: Option<StretchCutter>,
}

impl<'a> StretchCollector<'a> {
    /// Starts for a drive.
    pub fn new(trial: &'a RecordedTrial) -> Self {
        let cutter = (!trial.has(Table::Signals)).then(StretchCutter::new);
        Self { trial, usual: DriverParams::default(), cutter }
    }

    /// Adds the ego's row of the next tick.
    pub fn add(&mut self, ego: &EgoSample) {
        let Some(cutter) = &mut self.cutter else { return };
        let Some(s_m) = ego.s_m.filter(|_| ego.tick.is_multiple_of(MOMENT_TICKS)) else { return };
        // Without its map, a drive is treated as if on a straight road.
        let route = self.trial.map.as_ref().map(|map| &map.route);
        // The driver looks from the middle of the car, not from its front bumper.
        let middle_m = s_m - CAR_LENGTH_M / 2.0;
        let leader = ego.gap_m.zip(ego.leader_speed_mps);
        let (gap_m, leader_mps) = leader.unwrap_or((NOBODY_M, ego.speed_mps));
        let moment = Moment {
            speed_mps: ego.speed_mps as f32,
            advised_mps: ego.target_mps.map(|mps| mps as f32),
            gap_m: gap_m as f32,
            leader_mps: leader_mps as f32,
            limit_mps: route.map_or(f32::INFINITY, |route| route.speed_limit_mps(s_m) as f32),
            bend_mps: route
                .map_or(f32::INFINITY, |route| bend_speed_mps(&self.usual, route, middle_m, ego.speed_mps) as f32),
        };
        cutter.add(ego.tick, moment);
    }

    /// Returns the stretches after all rows were added.
    pub fn finish(self) -> DriverStretches {
        let Some(cutter) = self.cutter else { return DriverStretches::default() };
        DriverStretches { usual_time_gap_s: self.trial.setup.scenario.idm.t, stretches: cutter.finish() }
    }
}

#[cfg(test)]
impl DriverStretches {
    /// Cuts consecutive moments of a made-up drive into stretches.
    pub(crate) fn of_moments(usual_time_gap_s: f64, moments: &[Moment]) -> Self {
        let mut cutter = StretchCutter::new();
        moments.iter().zip(0_u64..).for_each(|(moment, i)| cutter.add(i * MOMENT_TICKS, *moment));
        Self { usual_time_gap_s, stretches: cutter.finish() }
    }
}

impl StretchCutter {
    fn new() -> Self {
        Self { kept: ThinnedValues::new(MOST_STRETCHES), recent: VecDeque::new(), last_tick: None }
    }

    fn add(&mut self, tick: u64, moment: Moment) {
        let goes_on = self.last_tick.is_none_or(|last| last + MOMENT_TICKS == tick);
        self.last_tick = Some(tick);
        if !goes_on {
            self.end_part();
        }
        self.recent.push_back(moment);
        if self.recent.len() == BEFORE + STRETCH + AFTER {
            self.keep();
            // The end of this stretch is the lead-in of the next.
            self.recent.drain(..STRETCH);
        }
    }

    fn keep(&mut self) {
        let takes = self.kept.takes_next();
        self.kept.push(if takes { self.recent.iter().copied().collect() } else { Vec::new() });
    }

    /// Keeps the moments since the last whole stretch, if they are long enough for a stretch of their own.
    fn end_part(&mut self) {
        if self.recent.len() >= BEFORE + LEAST + AFTER {
            self.keep();
        }
        self.recent.clear();
    }

    fn finish(mut self) -> Vec<Vec<Moment>> {
        self.end_part();
        self.kept.values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(moments: usize) -> Vec<Vec<Moment>> {
        let at = |i: usize| Moment { speed_mps: i as f32, ..Moment::default() };
        DriverStretches::of_moments(1.0, &(0..moments).map(at).collect::<Vec<_>>()).stretches
    }

    #[test]
    fn a_drive_is_cut_without_a_moment_lost_but_at_its_start_and_end() {
        // 3 s before, three stretches of 20 s, one of 7 s, 0.4 s after.
        let stretches = cut(BEFORE + 3 * STRETCH + 70 + AFTER);
        let own: Vec<f32> =
            stretches.iter().flat_map(|s| &s[BEFORE..s.len() - AFTER]).map(|moment| moment.speed_mps).collect();
        assert_eq!(own, (BEFORE..BEFORE + 3 * STRETCH + 70).map(|i| i as f32).collect::<Vec<_>>());
        assert_eq!(cut(BEFORE + LEAST + AFTER - 1).len(), 0);
    }

    #[test]
    fn a_long_drive_keeps_as_much_as_a_short_one_and_from_all_of_it() {
        let stretches = cut(100_000 * 10);
        assert!((MOST_STRETCHES / 2..=MOST_STRETCHES).contains(&stretches.len()), "{}", stretches.len());
        assert!(stretches.iter().all(|stretch| stretch.len() == BEFORE + STRETCH + AFTER));
        assert!(stretches[stretches.len() - 1][0].speed_mps > 900_000.0, "to the end");
    }

    #[test]
    fn a_hole_in_the_time_ends_a_stretch() {
        let mut cutter = StretchCutter::new();
        let ticks = (0..150).chain(400..550).map(|i| i * MOMENT_TICKS);
        ticks.for_each(|tick| cutter.add(tick, Moment { speed_mps: tick as f32, ..Moment::default() }));
        let stretches = cutter.finish();
        assert_eq!(stretches.iter().map(Vec::len).collect::<Vec<_>>(), [150, 150]);
        assert_eq!(stretches[1][0].speed_mps, 4000.0);
    }
}
