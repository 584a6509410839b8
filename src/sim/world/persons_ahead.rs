//! Persons on foot, and cyclists of events, in the way of an ego. In: a map, once, and snapshots. Out: the nearest crossing on which a person is, or
//! waits to be, or the nearest person on the road elsewhere. A driver stops before a person on foot as behind a vehicle that stands, and stays behind
//! a cyclist. Metres, m/s.

use crate::{
    driver::SeenLeader,
    map::{RoadMap, Route, network::EdgeKind},
    sim::{Snapshot, VehicleSnapshot},
    space::{CAR_WIDTH_M, Pose, is_one_road},
    traffic::VehicleKind,
};
use glam::DVec2;

/// Distance up to which a driver looks for persons, and for vehicles across the way, m: the stopping distance at 100 km/h. At a higher speed it is
/// that in which a driver stops after a second by comfortable braking, m/s2.
pub(super) const AHEAD_M: f64 = 100.0;
const COMFORTABLE_MPS2: f64 = 2.5;
/// Time before and after the arrival of the ego at which its way has to be free, s.
pub(super) const APART_S: f64 = 0.5;
/// Distance into a crossing up to which a driver still stops for persons on it.
const INTO_CROSSING_M: f64 = 1.0;
/// Smallest distance at which a car passes a person.
const BESIDE_M: f64 = 0.5;
/// Distance from the end of a crossing without signals at which a person is waiting to cross.
const WAITING_M: f64 = 2.0;
/// Time for which a driver looks ahead at the way of a person, s: at 1.4 m/s the half width of a lane and of a car.
const LOOKS_AHEAD_S: f64 = 2.0;

/// Lateral offset of the line that an ego follows from its route's, m, positive to the left, at a place of the route, m. They differ where the
/// path changes lanes.
pub(super) type DrivenLine<'a> = &'a dyn Fn(f64) -> f64;

/// Crossings along an ego's path.
pub(super) struct PersonsAhead {
    crossings: Vec<Crossing>,
}

/// Crossing on the path.
struct Crossing {
    /// Position of its near side along the route.
    s_m: f64,
    /// Ends of its middle line.
    ends: [DVec2; 2],
    half_width_m: f64,
    height_m: f64,
    /// Distance beyond its ends at which persons wait to cross.
    waiting_m: f64,
}

impl PersonsAhead {
    /// Returns the crossings of the streets that a map's route drives.
    pub fn new(map: &RoadMap) -> Self {
        let (net, route) = (&map.network, &map.route);
        let is_driven =
            |edge| route.lanes().iter().any(|lane| lane.lane.is_some_and(|lane| net.lane(lane).edge == edge));
        let edges = net.edges().iter().filter(|edge| edge.kind == EdgeKind::Crossing);
        let driven = edges.filter(|edge| edge.crosses.iter().any(|street| is_driven(*street)));
        let crossing = |edge: &crate::map::network::Edge| {
            let lane = net.lane(edge.lanes().next()?);
            let shape = lane.shape();
            let (first, last) = (*shape.first()?, *shape.last()?);
            let has_signals = edge.junction.is_some_and(|junction| net.junction(junction).kind.has_signals());
            // The place of its line that is nearest to the route.
            let places = (0..=20).map(|k| route.project(first.lerp(last, f64::from(k) / 20.0).truncate(), None));
            let at = places.min_by(|a, b| a.offset_m.abs().total_cmp(&b.offset_m.abs()))?;
            (at.offset_m.abs() < lane.width_m).then_some(Crossing {
                s_m: at.s_m - lane.half_width_m(),
                ends: [first.truncate(), last.truncate()],
                half_width_m: lane.half_width_m(),
                height_m: first.z,
                waiting_m: if has_signals { 0.0 } else { WAITING_M },
            })
        };
        Self { crossings: driven.filter_map(crossing).collect() }
    }

    /// Returns the nearest person in the ego's way, or the crossing where they are, as a driver sees them; `None` without such a person.
    pub fn nearest(&self, snapshot: &Snapshot, route: &Route, line_m: DrivenLine) -> Option<SeenLeader> {
        let ego = snapshot.ego.position.truncate();
        let ahead_m = look_ahead_m(snapshot.ego.speed_mps);
        let near = snapshot.persons().filter(|person| person.pose.position.distance(ego) < ahead_m);
        let seen = |person: &VehicleSnapshot| {
            let beside = BesideRoute::of(person, snapshot, route, line_m);
            let on_road = beside.on_road_ahead_m(person, snapshot, route);
            // A person who has crossed the ego's lane and walks on is not in its way.
            let waits = on_road.is_some() || !beside.has_passed();
            let crossings = self.crossings.iter().filter(|crossing| waits && crossing.has(person));
            let at_crossing = crossings.filter_map(|crossing| {
                let ahead_m = route.difference(snapshot.ego_s_m, crossing.s_m);
                (ahead_m >= -INTO_CROSSING_M).then_some(ahead_m.max(0.0))
            });
            let gap_m = at_crossing.chain(on_road).min_by(f64::total_cmp)?;
            let (_, speed_mps) = along(person, person.pose.yaw_rad - route.yaw_at(beside.s_m));
            Some(SeenLeader { gap_m, speed_mps })
        };
        near.filter_map(seen).min_by(|a, b| a.gap_m.total_cmp(&b.gap_m))
    }
}

impl Crossing {
    /// Checks whether a person is on the crossing, or waits at one of its ends.
    fn has(&self, person: &VehicleSnapshot) -> bool {
        let line = self.ends[1] - self.ends[0];
        let from = person.pose.position - self.ends[0];
        let along_m = from.dot(line.normalize_or_zero());
        let beside_m = from.perp_dot(line.normalize_or_zero()).abs();
        let reach = -self.waiting_m..=line.length() + self.waiting_m;
        beside_m <= self.half_width_m && reach.contains(&along_m) && is_one_road(person.height_m, self.height_m)
    }
}

/// Returns the distance up to which a driver at a speed looks for persons and vehicles across the way, m.
pub(super) fn look_ahead_m(speed_mps: f64) -> f64 {
    AHEAD_M.max(speed_mps + speed_mps * speed_mps / (2.0 * COMFORTABLE_MPS2))
}

/// Checks whether something is nearer to a line than `half_m` between two times, s, by its offset from the line at a time, m, which only rises or only
/// falls: it passes 0 between two times where its sign differs.
pub(super) fn is_near_line(offset_m: impl Fn(f64) -> f64, times_s: [f64; 2], half_m: f64) -> bool {
    let [from_m, to_m] = times_s.map(|time_s| offset_m(time_s.max(0.0)));
    from_m * to_m < 0.0 || from_m.abs().min(to_m.abs()) < half_m
}

/// Checks whether a person at this lateral offset from a vehicle's way, who nears it at this speed, is in the way or will be soon. `widths_m` is the
/// sum of both widths.
pub(super) fn is_in_way(offset_m: f64, nearing_mps: f64, widths_m: f64) -> bool {
    offset_m.abs() - nearing_mps.max(0.0) * LOOKS_AHEAD_S < widths_m / 2.0 + BESIDE_M
}

/// Returns the distance from a person's middle to the rear of their body, and their speed along a way against which they are turned by this angle. A
/// person on foot counts as a point that stands.
pub(super) fn along(person: &VehicleSnapshot, turned_rad: f64) -> (f64, f64) {
    match person.body.kind {
        VehicleKind::Pedestrian => (0.0, 0.0),
        _ => (person.body.length_m / 2.0, (person.speed_mps * turned_rad.cos()).max(0.0)),
    }
}

/// Position of a person or vehicle beside the line that an ego follows.
pub(super) struct BesideRoute {
    pub s_m: f64,
    /// Lateral offset from the line, positive to the left.
    pub offset_m: f64,
    /// Speed at which the person comes nearer to the line; negative for one who walks away.
    pub nearing_mps: f64,
}

impl BesideRoute {
    pub fn of(person: &VehicleSnapshot, snapshot: &Snapshot, route: &Route, line_m: DrivenLine) -> Self {
        let away_m = person.pose.position.distance(snapshot.ego.position.truncate());
        Self::near(person, route, route.wrap(snapshot.ego_s_m + away_m), line_m)
    }

    /// Returns the position of a person near a place of the route.
    pub fn near(person: &VehicleSnapshot, route: &Route, near_s_m: f64, line_m: DrivenLine) -> Self {
        let at = route.project(person.pose.position, Some(near_s_m));
        let offset_m = at.offset_m - line_m(at.s_m);
        let to_left = person.pose.forward().dot(Pose::new(DVec2::ZERO, route.yaw_at(at.s_m)).left());
        Self { s_m: at.s_m, offset_m, nearing_mps: -offset_m.signum() * to_left * person.speed_mps }
    }

    /// Checks whether the person is beside the ego's way and walks away from it.
    fn has_passed(&self) -> bool {
        self.nearing_mps < -0.1 && self.offset_m.abs() > CAR_WIDTH_M / 2.0 + BESIDE_M
    }

    /// Returns the distance from the ego's front bumper to the person, if they are in its way or will be soon.
    fn on_road_ahead_m(&self, person: &VehicleSnapshot, snapshot: &Snapshot, route: &Route) -> Option<f64> {
        let (rear_m, _) = along(person, 0.0);
        let ahead_m = route.difference(snapshot.ego_s_m, self.s_m) - rear_m;
        let widths_m = CAR_WIDTH_M + person.body.width_m;
        let is_in_way = is_in_way(self.offset_m, self.nearing_mps, widths_m) || {
            // A person of an event goes on. One of the traffic stops at a road, or is on a crossing.
            let arrives_s = ahead_m / snapshot.ego.speed_mps.max(1.0);
            let offset_m = |time_s: f64| self.offset_m.abs() - self.nearing_mps * time_s;
            let times_s = [arrives_s - APART_S, arrives_s + APART_S];
            person.id.is_of_event() && is_near_line(offset_m, times_s, widths_m / 2.0 + BESIDE_M)
        };
        let is_level = is_one_road(person.height_m, route.height_m(self.s_m));
        (ahead_m > 0.0 && is_in_way && is_level).then_some(ahead_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{ego::EgoState, traffic::VehicleBody};
    use glam::dvec2;

    /// Returns the gap to a person who stands `left_m` to the left of a street to the north and 20 m before an ego whose line is `line_m` to the left.
    fn seen_m(left_m: f64, line_m: f64) -> Option<f64> {
        let map = RoadMap::load("figure-eight").expect("a map that ships");
        let lane = map.network.lane_named("bottom_0").expect("a lane");
        let ego_s_m = map.route.s_on(lane, 0.0).expect("a lane of the route");
        // The street begins at (61.6, 30.13).
        let person = VehicleSnapshot {
            pose: Pose::new(dvec2(61.6 - left_m, 30.13 + 20.0), 0.0),
            body: VehicleBody { kind: VehicleKind::Pedestrian, width_m: 0.5, ..VehicleBody::CAR },
            ..VehicleSnapshot::default()
        };
        let ego = EgoState { position: dvec2(61.6 - line_m, 30.13).extend(0.0), speed_mps: 8.0, ..EgoState::default() };
        let snapshot = Snapshot { ego, ego_s_m, cars: vec![person], ..Snapshot::default() };
        PersonsAhead::new(&map).nearest(&snapshot, &map.route, &|_| line_m).map(|seen| seen.gap_m)
    }

    #[test]
    fn persons_are_seen_beside_the_line_that_is_driven_not_beside_the_route() {
        // A car of 1.8 m and a person of 0.5 m, 0.5 m apart, need 1.65 m.
        let near = |seen: Option<f64>| seen.is_some_and(|gap_m| (gap_m - 20.0).abs() < 0.05);
        assert!(near(seen_m(0.0, 0.0)) && near(seen_m(3.5, 3.5)) && near(seen_m(3.5, 2.0)), "in the way");
        assert_eq!([seen_m(0.0, 3.5), seen_m(3.5, 0.0), seen_m(3.5, 1.8)], [None; 3], "beside the way");
    }
}
