//! Violations of traffic rules and near misses of the ego on a network. In: the snapshot of a tick. Out: an event where one begins or ends.
//! Metres, m/s.
//!
//! * **stop line**: the front crosses the line of a link that shows red (or red and yellow). **red light**: the centre follows.
//! * **wrong way**: the front has been in a lane against its direction for a second.
//! * **speeding**: the ego exceeds its lane's limit by [`OVER_MPS`]; ends when the ego keeps the limit.
//! * **near miss**: the time to collision falls below [`NEAR_MISS_S`]; the same vehicle counts again after it was longer than 3 s.

use super::time_to_collision::MovingEgo;
use crate::{
    map::{
        RoadMap, is_against,
        network::{LaneId, LanePosition, Network, SignalId, SignalLight},
    },
    sim::{Event, EventKind, Snapshot},
    space::{CAR_LENGTH_M, Pose},
    time::{TICK_S, TICKS_PER_S},
    traffic::VehicleId,
};

/// Excess over the limit that counts as speeding, m/s: police subtracts 3 km/h from its measurement (German practice below 100 km/h), and
/// the speed of a driver who keeps the limit varies a little.
const OVER_MPS: f64 = 1.0;
/// Time to collision below which a near miss begins, s (the measure is that of Hayward 1972).
const NEAR_MISS_S: f64 = 1.5;
/// Time against the lane's direction that counts as wrong way, ticks; shorter times occur when backing out of a space.
const WRONG_WAY_TICKS: u32 = TICKS_PER_S;
/// Interval of the check for near misses, ticks.
const LOOK_TICKS: u64 = 10;

/// State of the violations and near misses in progress.
#[derive(Debug, Default)]
pub(super) struct RoadRules {
    lane: Option<LanePosition>,
    /// Line of a red signal that the front has crossed.
    crossed: Option<CrossedLine>,
    against_ticks: u32,
    is_wrong_way: bool,
    is_speeding: bool,
    /// Vehicles with a near miss in progress, by ascending id.
    near: Vec<VehicleId>,
}

/// A line of a red signal that the front has crossed.
#[derive(Clone, Copy, Debug)]
struct CrossedLine {
    signal: SignalId,
    link: u32,
    /// Lane that ends at the line.
    before: LaneId,
    /// Distance of the front beyond the line, metres.
    beyond_m: f64,
}

impl RoadRules {
    /// Adds the events of this tick. `ego` is the pose of the ego's centre.
    pub fn watch(&mut self, snapshot: &Snapshot, map: &RoadMap, ego: &Pose, events: &mut Vec<Event>) {
        let mut put = |kind: EventKind| events.push(Event { tick: snapshot.tick, kind });
        self.signals(snapshot, &map.network, &mut put);
        self.direction(snapshot, &map.network, ego, &mut put);
        self.limit(snapshot, &map.network, &mut put);
        if snapshot.tick.0.is_multiple_of(LOOK_TICKS) {
            self.others(snapshot, map, ego, &mut put);
        }
        self.lane = snapshot.ego_lane;
    }

    fn signals(&mut self, snapshot: &Snapshot, net: &Network, put: &mut impl FnMut(EventKind)) {
        let speed_mps = snapshot.ego.speed_mps;
        let is_red = |signal: SignalId, link: u32| {
            matches!(snapshot.signals.light(signal, link), Some(SignalLight::Red | SignalLight::RedYellow))
        };
        if let (Some(before), Some(now)) = (self.lane, snapshot.ego_lane)
            && before.lane != now.lane
        {
            let way = net.connections_from(before.lane).iter().find(|connection| connection.next() == now.lane);
            let ruled = way.and_then(|way| way.signal.as_ref()).and_then(|ruled| Some((ruled.signal, ruled.index?)));
            if let Some((signal, link)) = ruled.filter(|(signal, link)| is_red(*signal, *link)) {
                self.crossed = Some(CrossedLine { signal, link, before: before.lane, beyond_m: 0.0 });
                put(EventKind::StopLine { s_m: snapshot.ego_s_m, speed_mps });
            }
        }
        let Some(crossed) = &mut self.crossed else { return };
        crossed.beyond_m += speed_mps * TICK_S;
        let is_back = snapshot.ego_lane.is_some_and(|at| at.lane == crossed.before);
        if is_back || !is_red(crossed.signal, crossed.link) {
            self.crossed = None;
        } else if crossed.beyond_m > CAR_LENGTH_M / 2.0 {
            self.crossed = None;
            put(EventKind::RedLight { s_m: snapshot.ego_s_m, speed_mps });
        }
    }

    fn direction(&mut self, snapshot: &Snapshot, net: &Network, ego: &Pose, put: &mut impl FnMut(EventKind)) {
        let is_against = snapshot.ego_lane.is_some_and(|at| is_against(net, at, ego));
        self.against_ticks = if is_against { (self.against_ticks + 1).min(WRONG_WAY_TICKS) } else { 0 };
        let is_wrong_way = is_against && (self.is_wrong_way || self.against_ticks >= WRONG_WAY_TICKS);
        if is_wrong_way != self.is_wrong_way {
            self.is_wrong_way = is_wrong_way;
            put(if is_wrong_way { EventKind::WrongWay { s_m: snapshot.ego_s_m } } else { EventKind::RightWay });
        }
    }

    fn limit(&mut self, snapshot: &Snapshot, net: &Network, put: &mut impl FnMut(EventKind)) {
        let Some(at) = snapshot.ego_lane else { return };
        let (limit_mps, speed_mps) = (net.lane(at.lane).speed_limit_mps, snapshot.ego.speed_mps);
        if !self.is_speeding && speed_mps > limit_mps + OVER_MPS {
            self.is_speeding = true;
            put(EventKind::Speeding { s_m: snapshot.ego_s_m, over_mps: speed_mps - limit_mps });
        } else if self.is_speeding && speed_mps <= limit_mps {
            self.is_speeding = false;
            put(EventKind::WithinLimit);
        }
    }

    fn others(&mut self, snapshot: &Snapshot, map: &RoadMap, ego: &Pose, put: &mut impl FnMut(EventKind)) {
        let ego = MovingEgo::of(snapshot, map, ego, self.is_wrong_way);
        for car in &snapshot.cars {
            let ttc_s = ego.time_to_collision_s(car);
            match (self.near.binary_search(&car.id), ttc_s) {
                (Err(at), Some(ttc_s)) if ttc_s < NEAR_MISS_S => {
                    self.near.insert(at, car.id);
                    put(EventKind::NearMiss { car: car.id, time_s: ttc_s });
                }
                (Ok(at), None) => drop(self.near.remove(at)),
                _ => {}
            }
        }
        // A vehicle that has left the network is removed.
        self.near.retain(|id| snapshot.cars.binary_search_by_key(id, |car| car.id).is_ok());
    }
}

#[cfg(test)]
#[path = "road_rules_tests.rs"]
mod tests;
