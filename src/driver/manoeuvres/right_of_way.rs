//! The decision to wait at a line where others have right of way, or to merge behind another vehicle. In: the lines of the ego's path and the
//! snapshot of a tick. Out: the distance to the next line if the ego must not cross it now, and the vehicle behind which it merges. Metres,
//! seconds, m/s.
//!
//! The rule is SUMO's (docs/references.md: yield). The ego goes if it leaves the junction [`GAP_S`] before a vehicle with right of way
//! arrives, or arrives [`GAP_S`] after that vehicle has left. Where both paths merge, the other vehicle must also not need more than
//! comfortable braking. At a red signal no vehicle has right of way.
//!
//! At a zipper nobody waits: who is nearer to the end of the junction goes first, and the other follows.

use crate::{
    driver::{DriverParams, SeenLeader, bend_speed_mps},
    map::{
        RoadMap, Route, StopRule, YieldLine,
        network::{JunctionId, SignalLight},
    },
    snapshot::{Snapshot, VehicleSnapshot},
    space::CAR_LENGTH_M,
    traffic::VehicleId,
};

/// Minimum time between the ego and a vehicle with right of way in a junction, s (SUMO's `jmTimegapMinor`).
const GAP_S: f64 = 1.0;
/// A vehicle that would need harder braking than this does not stop, m/s² (SUMO's default for passenger cars).
const STOPS_MPS2: f64 = 4.5;
/// Speed below which a vehicle counts as stopped, m/s.
const STANDING_MPS: f64 = 0.1;
/// A vehicle stopped within this distance of a line is at the line, metres.
const AT_LINE_M: f64 = 5.0;
/// Distance from a line inside a junction at which a driver stops, metres; the car-following model adds 0.6 m. (SUMO's own vehicles stop
/// 0.1 m before it.) A vehicle further back would clear the junction too late.
const BEFORE_LINE_M: f64 = 0.5;
/// Longest wait for stopped vehicles, s: they let the ego go first, or they wait for each other in a circle.
const PATIENCE_S: f64 = 5.0;
/// Look-ahead beyond the comfortable braking distance, metres.
const SEEN_EARLIER_M: f64 = 20.0;
/// Longest part of a junction that is before its line, metres: a line inside a junction has such a part.
const JUNCTION_M: f64 = 30.0;
/// Distance from a zipper's line at which a driver looks for the vehicle to merge behind, metres.
const SEES_ZIPPER_M: f64 = 60.0;
/// Share of the way to a zipper's line that is added to the gap, because the gap opens on that way.
const OPENS: f64 = 0.5;

/// Motion of the ego from a line on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OwnPace {
    /// Time from the decision to go until the vehicle moves, s.
    pub delay_s: f64,
    /// Acceleration up to `through_mps`, m/s².
    pub accel_mps2: f64,
    /// Comfortable deceleration, m/s².
    pub decel_mps2: f64,
    /// Highest speed through the junction, m/s.
    pub through_mps: f64,
}

impl OwnPace {
    /// Returns the motion of a driver through the junction beyond a line.
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

    /// Returns the times, s, at which the ego reaches a line `ahead_m` away and has gone `way_m` beyond, and its speed at the end, m/s.
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

/// Time window of the ego in a junction, s from now.
#[derive(Clone, Copy, Debug, PartialEq)]
struct OwnWindow {
    arrives_s: f64,
    leaves_s: f64,
    /// Speed when it leaves, m/s.
    speed_mps: f64,
}

/// Returns the time for a distance, s, from a speed with an acceleration up to a top speed.
fn reach_s(way_m: f64, speed_mps: f64, accel_mps2: f64, top_mps: f64) -> f64 {
    let top_mps = top_mps.max(speed_mps);
    let speeding_m = (top_mps * top_mps - speed_mps * speed_mps) / (2.0 * accel_mps2);
    if way_m <= speeding_m {
        return ((speed_mps * speed_mps + 2.0 * accel_mps2 * way_m).sqrt() - speed_mps) / accel_mps2;
    }
    (top_mps - speed_mps) / accel_mps2 + (way_m - speeding_m) / top_mps
}

/// The lines of the path, and the ego's state at the next one.
#[derive(Debug)]
pub struct RightOfWay {
    lines: Vec<YieldLine>,
    /// Index of the next line, and the distance to it.
    next: Option<(usize, f64)>,
    /// Time for which the ego has been stopped at it with permission to go, ticks.
    stood_ticks: u32,
    /// Vehicles that stopped at the line of an all-way stop before the ego did, including those that have gone since.
    first_come: Vec<VehicleId>,
}

impl RightOfWay {
    /// Returns the state for the lines of a path in driving order.
    pub fn new(lines: Vec<YieldLine>) -> Self {
        Self { lines, next: None, stood_ticks: 0, first_come: Vec::new() }
    }

    /// Updates the ego's state at the next line.
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

    /// Returns the distance from the ego's front bumper to the next line, metres, if this driver must not cross it now. For a line inside a
    /// junction it is the distance to the vehicle behind which the driver would stop at the line.
    pub fn must_yield_ahead_m(&self, snapshot: &Snapshot, map: &RoadMap, driver: &DriverParams) -> Option<f64> {
        let (k, ahead_m) = self.next?;
        let line = &self.lines[k];
        if line.is_zipper {
            return None;
        }
        let speed_mps = snapshot.ego.speed_mps.max(0.0);
        let braking_m = |decel_mps2: f64| speed_mps * speed_mps / (2.0 * decel_mps2);
        let is_near = (braking_m(STOPS_MPS2)..=braking_m(driver.idm.b) + SEEN_EARLIER_M).contains(&ahead_m);
        let waits = || self.must_wait(line, ahead_m, snapshot, &OwnPace::of(driver, map, line));
        // At a line inside a junction the driver stops nearer than behind a vehicle.
        let nearer_m = if line.waits_inside { driver.idm.s0 - BEFORE_LINE_M } else { 0.0 };
        (is_near && waits()).then_some(ahead_m + nearer_m.max(0.0))
    }

    /// Returns true if the path has a line at a junction around `s_m`, where the driver judges the vehicles in it. A path may pass a junction
    /// twice and have right of way once.
    pub fn yields_at(&self, junction: JunctionId, s_m: f64, route: &Route) -> bool {
        let is_near = |line: &YieldLine| route.difference(line.s_m, s_m).abs() < line.inside_m + JUNCTION_M;
        self.lines.iter().any(|line| line.junction == junction && is_near(line))
    }

    /// Returns the vehicle of another lane behind which the ego merges at a zipper, with the gap that it still has to open.
    pub fn merges_behind(&self, snapshot: &Snapshot, map: &RoadMap) -> Option<SeenLeader> {
        let zippers = self.lines.iter().filter(|line| line.is_zipper);
        let to_end_m = |line: &YieldLine| {
            let end_s_m = map.route.wrap(line.s_m + line.inside_m);
            map.route.drawn_ahead_m(snapshot.ego_s_m, end_s_m)
        };
        let reach_m = |line: &YieldLine| 0.0..=line.inside_m + SEES_ZIPPER_M;
        let near =
            zippers.map(|line| (line, to_end_m(line))).filter(|(line, to_end_m)| reach_m(line).contains(to_end_m));
        let leaders = near.flat_map(|(line, to_end_m)| {
            foes(line, snapshot).filter_map(move |foe| {
                let link = &line.foes[foe.link];
                let lead_m = to_end_m - (foe.ahead_m + link.length_m);
                let gap_m = lead_m - foe.car.body.length_m + OPENS * (to_end_m - line.inside_m).max(0.0);
                (link.joins && lead_m > 0.0).then_some(SeenLeader { gap_m, speed_mps: foe.car.speed_mps })
            })
        });
        leaders.min_by(|a, b| a.gap_m.total_cmp(&b.gap_m))
    }

    /// Returns the distance from the ego's front bumper to the next line of the path, metres: if `stops`, to a line with a mandatory stop,
    /// otherwise to a line at which the ego only yields. A line whose signal shows green with priority is skipped.
    pub fn line_ahead_m(&self, snapshot: &Snapshot, map: &RoadMap, stops: bool) -> Option<f64> {
        let counts = |line: &&YieldLine| {
            let own = own_light(line, snapshot);
            own != Some(SignalLight::GreenMajor) && (line.stop != StopRule::None && own.is_none()) == stops
        };
        let ahead = self.lines.iter().filter(counts).map(|line| map.route.drawn_ahead_m(snapshot.ego_s_m, line.s_m));
        ahead.filter(|ahead_m| *ahead_m >= 0.0).min_by(f64::total_cmp)
    }

    /// Returns true if the ego must not cross a line now.
    fn must_wait(&self, line: &YieldLine, ahead_m: f64, snapshot: &Snapshot, pace: &OwnPace) -> bool {
        let own = own_light(line, snapshot);
        if own == Some(SignalLight::GreenMajor) {
            return false;
        }
        let stops = line.stop != StopRule::None && own.is_none() || own == Some(SignalLight::GreenArrow);
        if stops && self.stood_ticks == 0 {
            return true;
        }
        // A vehicle that waits inside while its signal is red clears the junction, as no other vehicle enters.
        let is_clearing = line.waits_inside && own.is_some_and(is_closed);
        let is_patient = !is_clearing && f64::from(self.stood_ticks) * crate::time::TICK_S < PATIENCE_S;
        foes(line, snapshot).any(|foe| {
            let is_allway = line.stop == StopRule::Allway && own.is_none();
            let is_later = is_allway && foe.can_stop() && !self.first_come.contains(&foe.car.id);
            !is_later && (is_patient || !foe.stands()) && foe.is_in_conflict(pace, ahead_m, line, snapshot)
        })
    }
}

/// Returns the light of the signal for the ego's link.
fn own_light(line: &YieldLine, snapshot: &Snapshot) -> Option<SignalLight> {
    line.signal.and_then(|(signal, link)| snapshot.signals.light(signal, link))
}

/// Returns true if a light forbids entering the junction.
fn is_closed(light: SignalLight) -> bool {
    matches!(light, SignalLight::Red | SignalLight::RedYellow | SignalLight::Yellow)
}

/// A vehicle on a link that a line yields to.
struct Foe<'a> {
    car: &'a VehicleSnapshot,
    /// Index of the link in the line's `foes`.
    link: usize,
    /// Distance to the vehicle's own line, metres; below 0 inside the junction.
    ahead_m: f64,
    limit_mps: f64,
}

/// Returns the vehicles that are on the links that a line yields to, or approach them, until their rear has left the junction.
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

    /// Returns true if the vehicle can stop before its line.
    fn can_stop(&self) -> bool {
        let speed_mps = self.car.speed_mps.max(0.0);
        self.ahead_m > 0.0 && speed_mps * speed_mps <= 2.0 * STOPS_MPS2 * self.ahead_m
    }

    /// Returns true if the ego would come too close to the vehicle in the junction.
    fn is_in_conflict(&self, pace: &OwnPace, ahead_m: f64, line: &YieldLine, snapshot: &Snapshot) -> bool {
        let link = &line.foes[self.link];
        let speed_mps = self.car.speed_mps.max(0.0);
        if self.ahead_m > 0.0 {
            let light = link.signal.and_then(|(signal, letter)| snapshot.signals.light(signal, letter));
            // A vehicle that can stop for red or yellow stops.
            if light.is_some_and(is_closed) && self.can_stop() {
                return false;
            }
        }
        let body_m = if link.joins { 0.0 } else { CAR_LENGTH_M };
        let own = pace.window(ahead_m, snapshot.ego.speed_mps, line.inside_m + body_m);
        // Where both paths merge, the end of both counts: there the other vehicle must be behind the ego's rear.
        let to_tail_m = if link.joins { link.length_m - CAR_LENGTH_M } else { 0.0 };
        // Other vehicles are expected to accelerate as the driver does.
        let arrives_s = reach_s((self.ahead_m + to_tail_m).max(0.0), speed_mps, pace.accel_mps2, self.limit_mps);
        let leaves_s = (self.ahead_m + link.length_m + self.car.body.length_m) / speed_mps.max(1e-3);
        let slower_mps = if link.joins { (speed_mps - own.speed_mps).max(0.0) } else { 0.0 };
        // The other vehicle travels this much further than the ego while it slows down to the speed that the accelerating ego has by then.
        let slowing_s = slower_mps * slower_mps / (2.0 * (pace.decel_mps2 + pace.accel_mps2)) / speed_mps.max(1e-3);
        let goes_first = own.leaves_s + GAP_S + slowing_s < arrives_s;
        let goes_after = leaves_s + GAP_S < own.arrives_s;
        !goes_first && !goes_after
    }
}

#[cfg(test)]
#[path = "right_of_way_tests.rs"]
mod tests;
