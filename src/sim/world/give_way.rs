//! When the ego has to wait at a line where others go first. In: the lines of its path and the snapshot of a tick. Out: the way to the next one
//! if it must not be crossed now. Metres, seconds, m/s.
//!
//! The rule is SUMO's (docs/references.md: yield): the ego goes if it has left the junction [`GAP_S`] before a vehicle that it
//! yields to gets there, or gets there as long after that one has left it. Where both ways join, the other must not have to brake harder
//! than is comfortable, either. Nobody has priority at a red signal.

use super::yield_lines::{StopRule, YieldLine};
use crate::{
    driver::{DriverParams, bend_speed_mps},
    map::{RoadMap, network::SignalLight},
    sim::{Snapshot, snapshot::VehicleSnapshot},
    space::CAR_LENGTH_M,
    traffic::VehicleId,
};

/// Least time between the ego and one that it yields to in a junction, s (SUMO's `jmTimegapMinor`).
const GAP_S: f64 = 1.0;
/// Who has begun to go on goes on if it would have to brake harder than this, m/s2 (SUMO's default of passenger cars).
const STOPS_MPS2: f64 = 4.5;
/// Below this speed a vehicle stands, m/s.
const STANDING_MPS: f64 = 0.1;
/// Who stands so near a line stands at it, metres.
const AT_LINE_M: f64 = 5.0;
/// Inside a junction a driver stands so far before its line, metres, and what its car-following model adds, 0.6 m. (SUMO's own vehicles stand
/// 0.1 m before it.) Who stands further back is too late in the second part when it clears the junction.
const BEFORE_LINE_M: f64 = 0.5;
/// Others that stand are waited for no longer than this, s: they let the ego go first, or wait for each other in a circle.
const PATIENCE_S: f64 = 5.0;
/// Lines further away than the way on which the ego brakes comfortably and this are no matter yet, metres.
const SEEN_EARLIER_M: f64 = 20.0;

/// How the ego goes on from a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct OwnPace {
    /// From the decision to go to going, s.
    pub delay_s: f64,
    /// Acceleration, m/s2.
    pub accel_mps2: f64,
    /// Deceleration that is comfortable, m/s2.
    pub decel_mps2: f64,
    /// Highest speed through the junction, m/s.
    pub through_mps: f64,
}

impl OwnPace {
    /// That of a driver through the junction behind a line.
    pub fn of(driver: &DriverParams, map: &RoadMap, line: &YieldLine) -> Self {
        const EVERY_M: f64 = 4.0;
        let looks = (line.inside_m / EVERY_M).ceil() as usize;
        let at = |k: usize| {
            let s_m = line.s_m + EVERY_M * k as f64;
            map.route.speed_limit_mps(s_m).min(bend_speed_mps(driver, &map.route, s_m, 0.0))
        };
        Self {
            delay_s: driver.leader_reaction_s + driver.foot_s,
            accel_mps2: driver.idm.a,
            decel_mps2: driver.idm.b,
            through_mps: (0..=looks).map(at).fold(driver.idm.v0, f64::min).max(1.0),
        }
    }

    /// When the ego gets to a line `ahead_m` away and when it has gone `way_m` beyond, s, and how fast it is there, m/s.
    fn window(&self, ahead_m: f64, speed_mps: f64, way_m: f64) -> OwnWindow {
        let (speed_mps, through_mps) = (speed_mps.max(0.0), self.through_mps);
        if speed_mps > through_mps {
            let arrives_s = 2.0 * ahead_m / (speed_mps + through_mps);
            return OwnWindow { arrives_s, leaves_s: arrives_s + way_m / through_mps, speed_mps: through_mps };
        }
        let all_m = ahead_m + way_m;
        let rest_m = (all_m - speed_mps * self.delay_s).max(0.0);
        OwnWindow {
            arrives_s: reach_s(ahead_m, speed_mps, self.accel_mps2, through_mps),
            leaves_s: self.delay_s + reach_s(rest_m, speed_mps, self.accel_mps2, through_mps),
            speed_mps: (speed_mps * speed_mps + 2.0 * self.accel_mps2 * rest_m).sqrt().min(through_mps),
        }
    }
}

/// When the ego would be in a junction.
#[derive(Clone, Copy, Debug, PartialEq)]
struct OwnWindow {
    arrives_s: f64,
    leaves_s: f64,
    /// When it leaves.
    speed_mps: f64,
}

/// Time for a way from a speed, with an acceleration up to a top speed, s.
fn reach_s(way_m: f64, speed_mps: f64, accel_mps2: f64, top_mps: f64) -> f64 {
    let top_mps = top_mps.max(speed_mps);
    let speeding_m = (top_mps * top_mps - speed_mps * speed_mps) / (2.0 * accel_mps2);
    if way_m <= speeding_m {
        return ((speed_mps * speed_mps + 2.0 * accel_mps2 * way_m).sqrt() - speed_mps) / accel_mps2;
    }
    (top_mps - speed_mps) / accel_mps2 + (way_m - speeding_m) / top_mps
}

/// The lines of the path, and how the ego stands at the next one.
#[derive(Debug)]
pub(super) struct GiveWay {
    lines: Vec<YieldLine>,
    /// The next line, by its place, and the way to it.
    next: Option<(usize, f64)>,
    /// So long the ego has stood at it while it might go, ticks.
    stood_ticks: u32,
    /// Who stood at the line of an all-way stop before the ego did; whether they have gone on since or not.
    first_come: Vec<VehicleId>,
}

impl GiveWay {
    /// With the lines of a path in driving order.
    pub fn new(lines: Vec<YieldLine>) -> Self {
        Self { lines, next: None, stood_ticks: 0, first_come: Vec::new() }
    }

    /// Notes how the ego stands at the next line.
    pub fn update(&mut self, snapshot: &Snapshot, map: &RoadMap) {
        let ahead = |line: &YieldLine| map.route.drawn_ahead_m(snapshot.ego_s_m, line.s_m);
        let lines = self.lines.iter().map(ahead).enumerate().filter(|(_, ahead_m)| *ahead_m >= 0.0);
        let next = lines.min_by(|a, b| a.1.total_cmp(&b.1));
        if next.map(|(k, _)| k) != self.next.map(|(k, _)| k) {
            self.stood_ticks = 0;
            self.first_come.clear();
        }
        self.next = next;
        let Some((k, ahead_m)) = next else { return };
        let line = &self.lines[k];
        let own = own_light(line, snapshot);
        if line.stop == StopRule::Allway && self.stood_ticks == 0 {
            for foe in foes(line, snapshot).filter(|foe| foe.is_at_line() && foe.stands()) {
                if !self.first_come.contains(&foe.car.id) {
                    self.first_come.push(foe.car.id);
                }
            }
        }
        if !line.waits_inside && own.is_some_and(is_closed) {
            self.stood_ticks = 0;
        } else if ahead_m < AT_LINE_M && snapshot.ego.speed_mps < STANDING_MPS {
            self.stood_ticks += 1;
        }
    }

    /// Way from the ego's front bumper to the next line, if this driver must not cross it now, metres; as far beyond a line inside a junction as
    /// a car would be that stands there for the driver to stop at the line.
    pub fn must_yield_ahead_m(&self, snapshot: &Snapshot, map: &RoadMap, driver: &DriverParams) -> Option<f64> {
        let (k, ahead_m) = self.next?;
        let line = &self.lines[k];
        let speed_mps = snapshot.ego.speed_mps.max(0.0);
        let braking_m = |decel_mps2: f64| speed_mps * speed_mps / (2.0 * decel_mps2);
        let is_near = (braking_m(STOPS_MPS2)..=braking_m(driver.idm.b) + SEEN_EARLIER_M).contains(&ahead_m);
        let waits = || self.must_wait(line, ahead_m, snapshot, &OwnPace::of(driver, map, line));
        // Nobody stands before a line inside a junction as before a car.
        let nearer_m = if line.waits_inside { driver.idm.s0 - BEFORE_LINE_M } else { 0.0 };
        (is_near && waits()).then_some(ahead_m + nearer_m.max(0.0))
    }

    /// Way from the ego's front bumper to the next line of the path, metres: at which one stops for the line's own sake, or of those at which
    /// one only yields. While the signal of its way shows green with priority a line is none.
    pub fn line_ahead_m(&self, snapshot: &Snapshot, map: &RoadMap, stops: bool) -> Option<f64> {
        let counts = |line: &&YieldLine| {
            let own = own_light(line, snapshot);
            own != Some(SignalLight::GreenMajor) && (line.stop != StopRule::None && own.is_none()) == stops
        };
        let ahead = self.lines.iter().filter(counts).map(|line| map.route.drawn_ahead_m(snapshot.ego_s_m, line.s_m));
        ahead.filter(|ahead_m| *ahead_m >= 0.0).min_by(f64::total_cmp)
    }

    /// True if the ego must not cross a line now.
    fn must_wait(&self, line: &YieldLine, ahead_m: f64, snapshot: &Snapshot, pace: &OwnPace) -> bool {
        let own = own_light(line, snapshot);
        if own == Some(SignalLight::GreenMajor) {
            return false;
        }
        let stops = line.stop != StopRule::None && own.is_none() || own == Some(SignalLight::GreenArrow);
        if stops && self.stood_ticks == 0 {
            return true;
        }
        // Who waits inside while its signal is red clears the junction: nobody else comes.
        let is_clearing = line.waits_inside && own.is_some_and(is_closed);
        let is_patient = !is_clearing && f64::from(self.stood_ticks) * crate::time::TICK_S < PATIENCE_S;
        foes(line, snapshot).any(|foe| {
            let is_allway = line.stop == StopRule::Allway && own.is_none();
            let is_later = is_allway && foe.can_stop() && !self.first_come.contains(&foe.car.id);
            !is_later && (is_patient || !foe.stands()) && foe.is_in_conflict(pace, ahead_m, line, snapshot)
        })
    }
}

/// What the signal of the way shows.
fn own_light(line: &YieldLine, snapshot: &Snapshot) -> Option<SignalLight> {
    line.signal.and_then(|(signal, link)| snapshot.signals.light(signal, link))
}

/// True if a light lets nobody begin to cross.
fn is_closed(light: SignalLight) -> bool {
    matches!(light, SignalLight::Red | SignalLight::RedYellow | SignalLight::Yellow)
}

/// A vehicle on a link that a line yields to.
struct Foe<'a> {
    car: &'a VehicleSnapshot,
    /// Which of the line's links.
    link: usize,
    /// To its own line, metres; below 0 inside the junction.
    ahead_m: f64,
    limit_mps: f64,
}

/// The vehicles on the links that a line yields to, and before them, whose tails have not left the junction.
fn foes<'a>(line: &'a YieldLine, snapshot: &'a Snapshot) -> impl Iterator<Item = Foe<'a>> {
    snapshot.cars.iter().flat_map(move |car| {
        let on = car.lane.map(|at| (at.lane, at.s_m));
        let first = on.map_or(0, |(lane, _)| line.foe_lanes.partition_point(|known| known.lane < lane));
        let same = line.foe_lanes[first..].iter().map_while(move |known| {
            let (_, s_m) = on.filter(|(lane, _)| *lane == known.lane)?;
            Some(Foe { car, link: known.foe, ahead_m: known.line_at_m - s_m, limit_mps: known.limit_mps })
        });
        same.filter(|foe| foe.ahead_m + line.foes[foe.link].length_m + car.body.length_m > 0.0)
    })
}

impl Foe<'_> {
    fn stands(&self) -> bool {
        self.car.speed_mps < STANDING_MPS
    }

    fn is_at_line(&self) -> bool {
        (0.0..AT_LINE_M).contains(&self.ahead_m)
    }

    /// True if it can stop before its line.
    fn can_stop(&self) -> bool {
        let speed_mps = self.car.speed_mps.max(0.0);
        self.ahead_m > 0.0 && speed_mps * speed_mps <= 2.0 * STOPS_MPS2 * self.ahead_m
    }

    /// True if the ego would come too near to it in the junction.
    fn is_in_conflict(&self, pace: &OwnPace, ahead_m: f64, line: &YieldLine, snapshot: &Snapshot) -> bool {
        let link = &line.foes[self.link];
        let speed_mps = self.car.speed_mps.max(0.0);
        if self.ahead_m > 0.0 {
            let light = link.signal.and_then(|(signal, letter)| snapshot.signals.light(signal, letter));
            // Who can stop for red or yellow does.
            if light.is_some_and(is_closed) && self.can_stop() {
                return false;
            }
        }
        let body_m = if link.joins { 0.0 } else { CAR_LENGTH_M };
        let own = pace.window(ahead_m, snapshot.ego.speed_mps, line.inside_m + body_m);
        // Where both ways join, what counts is the end of both: there the other must be behind the ego's tail.
        let to_tail_m = if link.joins { link.length_m - CAR_LENGTH_M } else { 0.0 };
        // Others are expected to speed up as the driver does.
        let arrives_s = reach_s((self.ahead_m + to_tail_m).max(0.0), speed_mps, pace.accel_mps2, self.limit_mps);
        let leaves_s = (self.ahead_m + link.length_m + self.car.body.length_m) / speed_mps.max(1e-3);
        let slower_mps = if link.joins { (speed_mps - own.speed_mps).max(0.0) } else { 0.0 };
        // On this much more way than the ego it slows down to the speed that the ego, speeding up, has by then.
        let slowing_s = slower_mps * slower_mps / (2.0 * (pace.decel_mps2 + pace.accel_mps2)) / speed_mps.max(1e-3);
        let goes_first = own.leaves_s + GAP_S + slowing_s < arrives_s;
        let goes_after = leaves_s + GAP_S < own.arrives_s;
        !goes_first && !goes_after
    }
}

#[cfg(test)]
#[path = "give_way_tests.rs"]
mod tests;
