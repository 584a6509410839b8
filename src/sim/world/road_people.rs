//! People whom events of a scenario move: pedestrians who cross the ego's route, cyclists who ride along it. In: the scenario, once; the ticks at
//! which events begin. Out: the people at any tick, as vehicles of the view that have no lane. Metres, m/s.
//!
//! A person waits beside the road from the drive's start on. From the tick of the event their place follows from the time alone: the distance that
//! they have walked or ridden, and from that the place beside the route. So a replay has the same people to the bit, with every engine.

use super::network_view::NetworkView;
use crate::{
    ego::GroundModel,
    map::{RoadMap, Route, network::Side},
    scenario::{ScriptedEvent, scripted_event::Action},
    sim::VehicleSnapshot,
    space::Pose,
    time::{TICK_S, Tick},
    traffic::{FIRST_OF_EVENTS, VehicleBody, VehicleId, VehicleKind},
};
use glam::DVec2;
use std::f64::consts::FRAC_PI_2;

const ON_FOOT: VehicleBody = VehicleBody::of_kind(VehicleKind::Pedestrian);
const RIDING: VehicleBody = VehicleBody::of_kind(VehicleKind::Bicycle);
/// Accelerations from a standstill, m/s2 (docs/references.md: walkers).
const ON_FOOT_MPS2: f64 = 2.0;
const RIDING_MPS2: f64 = 1.0;
/// Distance beyond the road's edge at which a person waits.
const WAITS_BEYOND_M: f64 = 0.6;
/// Distance from the road's edge at which a cyclist rides.
const RIDES_WITHIN_M: f64 = 1.0;
/// Way along the road in which a cyclist comes onto it, or leaves it.
const SHIFT_M: f64 = 12.0;
/// Radius at which a pedestrian turns after crossing, to walk on along the road.
const TURN_M: f64 = 0.7;
/// Widest road, from the route's line to its edge, and the grid on which its edge is found.
const WIDEST_M: f64 = 40.0;
const GRID_M: f64 = 0.1;
/// Distance from the ego beyond which a person who has left the road disappears.
const SEEN_M: f64 = 50.0;

/// People of all events, by ascending id.
pub(super) struct RoadPeople {
    people: Vec<RoadPerson>,
}

/// Person of an event.
struct RoadPerson {
    /// Number of the event, and of the action in it.
    of: (usize, usize),
    body: VehicleBody,
    way: Way,
    speed_mps: f64,
    accel_mps2: f64,
    stage: Stage,
}

#[derive(Clone, Copy, PartialEq)]
enum Stage {
    Waits,
    /// The person moves from this tick on.
    Moves(Tick),
    /// The person has disappeared.
    Gone,
}

/// Way of a person from beside the road back to beside the road.
#[derive(Clone, Copy)]
struct Way {
    /// Place of its beginning along the route.
    s_m: f64,
    /// Offset from the route at which the person waits, positive to the left.
    from_m: f64,
    shape: WayShape,
}

#[derive(Clone, Copy)]
enum WayShape {
    /// Straight across the road to this offset, then along the road.
    Across { to_m: f64 },
    /// Onto the road at this offset, along it for this distance, and off it.
    Along { offset_m: f64, for_m: f64 },
}

/// Place beside the route.
#[derive(Clone, Copy)]
struct Beside {
    /// Distance along the route from the way's beginning.
    along_m: f64,
    offset_m: f64,
    /// Direction against the route's.
    turned_rad: f64,
}

impl RoadPeople {
    /// Places the people of these events beside the road.
    pub fn new(events: &[ScriptedEvent], map: &RoadMap) -> Self {
        let actions = events.iter().enumerate().flat_map(|(k, event)| {
            let of_event = event.actions.iter().enumerate();
            of_event.map(move |(n, action)| ((k, n), action))
        });
        Self { people: actions.filter_map(|(of, action)| RoadPerson::new(of, action, map)).collect() }
    }

    /// Returns the id after those of all people.
    pub fn next_id(&self) -> VehicleId {
        id_of(self.people.len())
    }

    /// Lets the person of an action move from a tick on, even if they are still under way. Returns their id, and the time until they are off the road
    /// again, s.
    pub fn begin(&mut self, of: (usize, usize), now: Tick) -> Option<(VehicleId, f64)> {
        let at = self.people.iter().position(|person| person.of == of)?;
        let person = &mut self.people[at];
        person.stage = Stage::Moves(now);
        Some((id_of(at), person.time_for_s(person.way.on_road_m())))
    }

    /// Lets people who have left the road and are out of sight disappear, or wait again where their event may begin anew. `begins_again` says so.
    pub fn leave(&mut self, now: Tick, ego: DVec2, route: &Route, begins_again: &dyn Fn(usize) -> bool) {
        for person in &mut self.people {
            let Stage::Moves(begun) = person.stage else { continue };
            let (moved_m, _) = person.moved(begun, now);
            let is_off = moved_m > person.way.on_road_m();
            if is_off && person.way.pose(moved_m, route).position.distance(ego) > SEEN_M {
                person.stage = if begins_again(person.of.0) { Stage::Waits } else { Stage::Gone };
            }
        }
    }

    /// Returns the people at a tick, `ticks` after the last one.
    pub fn at(&self, now: Tick, ticks: u64, route: &Route) -> impl Iterator<Item = VehicleSnapshot> {
        let present = self.people.iter().enumerate().filter(|(_, person)| person.stage != Stage::Gone);
        present.map(move |(k, person)| {
            let (moved_m, speed_mps) = match person.stage {
                Stage::Moves(begun) => person.moved(begun, now),
                _ => (0.0, 0.0),
            };
            let before_m = match person.stage {
                Stage::Moves(begun) => person.moved(begun, Tick(now.0.saturating_sub(ticks))).0,
                _ => 0.0,
            };
            VehicleSnapshot {
                id: id_of(k),
                pose: person.way.pose(moved_m, route),
                pose_before: person.way.pose(before_m, route),
                speed_mps,
                odometer_m: moved_m,
                body: person.body,
                height_m: route.height_m(person.way.s_m),
                ..VehicleSnapshot::default()
            }
        })
    }

    /// Checks whether a person is on the road, or steps onto it.
    pub fn is_on_road(&self, id: VehicleId, now: Tick) -> bool {
        let person = id.0.checked_sub(FIRST_OF_EVENTS.0).and_then(|at| self.people.get(at as usize));
        person.is_some_and(|person| match person.stage {
            Stage::Moves(begun) => person.moved(begun, now).0 < person.way.on_road_m(),
            _ => false,
        })
    }
}

/// Returns the id of the person at this index.
fn id_of(at: usize) -> VehicleId {
    VehicleId(FIRST_OF_EVENTS.0 + at as u32)
}

impl RoadPerson {
    fn new(of: (usize, usize), action: &Action, map: &RoadMap) -> Option<Self> {
        let place_m = action.place_m()?;
        // Offset of the road's edge from the route.
        let edge_m = |side: Side| edge_m(map, place_m, side);
        let person = match action {
            Action::PedestrianCrosses(crossing) => {
                let to = if crossing.from == Side::Left { Side::Right } else { Side::Left };
                let beside_m = |side: Side| edge_m(side) + sign(side) * WAITS_BEYOND_M;
                let shape = WayShape::Across { to_m: beside_m(to) };
                let way = Way { s_m: place_m, from_m: beside_m(crossing.from), shape };
                let (speed_mps, accel_mps2) = (crossing.speed_mps, ON_FOOT_MPS2);
                Self { of, body: ON_FOOT, way, speed_mps, accel_mps2, stage: Stage::Waits }
            }
            Action::CyclistRides(ride) => {
                let side = if map.network.is_left_hand() { Side::Left } else { Side::Right };
                let offset_m = edge_m(side) - sign(side) * RIDES_WITHIN_M;
                let shape = WayShape::Along { offset_m, for_m: ride.for_m };
                let way = Way { s_m: place_m, from_m: edge_m(side) + sign(side) * WAITS_BEYOND_M, shape };
                let (speed_mps, accel_mps2) = (ride.speed_mps, RIDING_MPS2);
                Self { of, body: RIDING, way, speed_mps, accel_mps2, stage: Stage::Waits }
            }
            _ => return None,
        };
        Some(person)
    }

    /// Returns the distance moved since a tick, and the speed: even acceleration from a standstill up to the person's speed.
    fn moved(&self, begun: Tick, now: Tick) -> (f64, f64) {
        let for_s = now.0.saturating_sub(begun.0) as f64 * TICK_S;
        let up_s = self.speed_mps / self.accel_mps2;
        if for_s < up_s {
            return (self.accel_mps2 * for_s * for_s / 2.0, self.accel_mps2 * for_s);
        }
        (self.speed_mps * (for_s - up_s / 2.0), self.speed_mps)
    }

    /// Returns the time in which the person has moved this distance, which is longer than that of the acceleration.
    fn time_for_s(&self, way_m: f64) -> f64 {
        way_m / self.speed_mps + self.speed_mps / self.accel_mps2 / 2.0
    }
}

/// Returns 1 for the left side and -1 for the right one: the sign of an offset.
fn sign(side: Side) -> f64 {
    if side == Side::Left { 1.0 } else { -1.0 }
}

/// Returns the offset from the route of the edge of the road for vehicles, its shoulder included.
fn edge_m(map: &RoadMap, place_m: f64, side: Side) -> f64 {
    let ground = NetworkView::ground_at(map, place_m);
    let (middle, left) = (map.route.point_at(place_m), DVec2::from_angle(map.route.yaw_at(place_m)).perp());
    let is_road = |k: &u32| ground.is_for_vehicles(middle + left * sign(side) * GRID_M * f64::from(*k));
    let cells = (1..(WIDEST_M / GRID_M) as u32).take_while(is_road).count();
    sign(side) * GRID_M * cells as f64
}

impl Way {
    /// Returns the distance after which the person is off the road again.
    fn on_road_m(&self) -> f64 {
        match self.shape {
            WayShape::Across { to_m } => (to_m - self.from_m).abs(),
            WayShape::Along { for_m, .. } => for_m + 2.0 * SHIFT_M,
        }
    }

    /// Returns the place beside the route after this distance.
    fn beside(&self, moved_m: f64) -> Beside {
        match self.shape {
            WayShape::Across { to_m } => across(self.from_m, to_m, moved_m),
            WayShape::Along { offset_m, for_m } => {
                let on = shift(moved_m / SHIFT_M);
                let off = shift((moved_m - SHIFT_M - for_m) / SHIFT_M);
                let aside_m = offset_m - self.from_m;
                let slope = (on[1] - off[1]) * aside_m / SHIFT_M;
                Beside {
                    along_m: moved_m,
                    offset_m: self.from_m + (on[0] - off[0]) * aside_m,
                    turned_rad: slope.atan(),
                }
            }
        }
    }

    /// Returns the pose of the person after this distance.
    fn pose(&self, moved_m: f64, route: &Route) -> Pose {
        let Beside { along_m, offset_m, turned_rad } = self.beside(moved_m);
        let s_m = self.s_m + along_m;
        let yaw_rad = route.yaw_at(s_m);
        Pose::new(route.point_at(s_m) + DVec2::from_angle(yaw_rad).perp() * offset_m, yaw_rad + turned_rad)
    }
}

/// Returns the place after this distance on a way from one offset straight to another, round a corner, and along the road.
fn across(from_m: f64, to_m: f64, moved_m: f64) -> Beside {
    let (side, straight_m) = ((to_m - from_m).signum(), (to_m - from_m).abs());
    let turned_m = (moved_m - straight_m).max(0.0);
    let corner_rad = (turned_m / TURN_M).min(FRAC_PI_2);
    let along_m = (turned_m - FRAC_PI_2 * TURN_M).max(0.0);
    Beside {
        along_m: TURN_M * (1.0 - corner_rad.cos()) + along_m,
        offset_m: from_m + side * (moved_m.min(straight_m) + TURN_M * corner_rad.sin()),
        turned_rad: side * (FRAC_PI_2 - corner_rad),
    }
}

/// Returns the share of a shift aside after this share of its way, from 0 to 1, and its slope.
fn shift(part: f64) -> [f64; 2] {
    let t = part.clamp(0.0, 1.0);
    [t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t)]
}

#[cfg(test)]
#[path = "road_people_tests.rs"]
mod tests;
