//! Motion of a road user that a scenario places and its events move. In: its settings, the ego's route, actions. Out: its pose and speed at each tick.
//! Metres, m/s, seconds.
//!
//! The point that follows the lane is the rear axle, as in a car and in OpenSCENARIO. It moves along the route at its own lateral place, by the distance that
//! its speed covers there.

use super::{
    event_view::OnRoute,
    user_speed::{SeenVehicle, SeenVehicles, UserSpeed},
    user_way::{UserWay, beside},
};
use crate::{
    map::RoadMap,
    scenario::{
        RoadUser,
        scripted_event::{Action, ChangeShape, LaneChange, Teleport, Walk},
    },
    sim::VehicleSnapshot,
    space::{Pose, Pose3, is_along, wrap_angle},
    time::TICK_S,
    traffic::{VehicleBody, VehicleId, VehicleLamps},
};
use std::f64::consts::PI;

/// Distance along the route over which its curvature is taken, m.
const CURVATURE_M: f64 = 4.0;
/// Smallest share of the distance on the route that a distance beside it is: inside the narrowest bends.
const TIGHTEST: f64 = 0.1;
/// Largest difference of drawn from declared metres, as a share.
const MOST_DIFFERENCE: f64 = 0.25;
/// Way aside from which a vehicle indicates, m.
const INDICATES_M: f64 = 1.0;
/// Deceleration from which the brake lamps are lit, m/s2.
const BRAKE_LAMP_MPS2: f64 = 0.2;

/// A road user with its state.
pub(super) struct MovedRoadUser {
    pub id: VehicleId,
    pub name: String,
    body: VehicleBody,
    /// Distance from the rear axle to the front.
    front_m: f64,
    against: bool,
    /// Rear axle along the route.
    s_m: f64,
    /// Number of lanes left of the route's, and offset from that lane's middle, in the route's direction.
    lane: i32,
    offset_m: f64,
    speed_mps: f64,
    /// Largest acceleration and deceleration of changes of the speed.
    most_mps2: [f64; 2],
    speed: UserSpeed,
    way: UserWay,
    is_broken_down: bool,
    now: VehicleSnapshot,
}

impl MovedRoadUser {
    /// Places a road user on the road of a drive.
    pub fn new(id: VehicleId, user: &RoadUser, map: &RoadMap) -> Self {
        let (body, front_m) = (user.body(), user.rear_axle_m());
        let at = Teleport {
            vehicle: user.name.clone(),
            place_m: user.place_m,
            lanes_left: user.lanes_left,
            offset_m: user.offset_m,
            against: user.against,
        };
        let mut moved = Self {
            id,
            name: user.name.clone(),
            body,
            front_m,
            against: false,
            s_m: 0.0,
            lane: 0,
            offset_m: 0.0,
            speed_mps: user.speed_mps,
            most_mps2: user.most_mps2(),
            speed: UserSpeed::Keeps,
            way: UserWay::Keeps,
            is_broken_down: false,
            now: VehicleSnapshot { id, body, ..VehicleSnapshot::default() },
        };
        moved.teleport(&at, map);
        moved
    }

    /// Places the road user at once, without a change of its speed.
    fn teleport(&mut self, to: &Teleport, map: &RoadMap) {
        let front_m = if to.against { -self.front_m } else { self.front_m };
        (self.against, self.s_m) = (to.against, to.place_m - front_m);
        (self.lane, self.offset_m, self.way) = (to.lanes_left, to.offset_m, UserWay::Keeps);
        let pose = self.posed(map, 0.0);
        self.show(map, pose, self.now.accel_mps2, 0.0);
        self.now.pose_before = pose;
    }

    /// Returns the road user as it is drawn now.
    pub fn now(&self) -> VehicleSnapshot {
        self.now
    }

    /// Returns the ends of the body along the route, m: the lower place and the higher one.
    fn extent_m(&self) -> [f64; 2] {
        let front_m = self.seen().front_m;
        if self.against { [front_m, front_m + self.body.length_m] } else { [front_m - self.body.length_m, front_m] }
    }

    /// Returns where the road user is along the ego's route.
    pub fn on_route(&self) -> OnRoute {
        let (seen, pose) = (self.seen(), self.now.pose);
        let axle = pose.position - pose.forward() * self.to_centre_m();
        OnRoute {
            extent_m: self.extent_m(),
            along_mps: seen.along_mps,
            speed_mps: seen.speed_mps,
            accel_mps2: self.now.accel_mps2,
            driven_m: self.now.odometer_m,
            point: axle.extend(self.now.height_m),
        }
    }

    /// Returns the distance from the rear axle forward to the centre.
    fn to_centre_m(&self) -> f64 {
        self.front_m - self.body.length_m / 2.0
    }

    /// Returns the road user as others see it.
    pub fn seen(&self) -> SeenVehicle {
        let toward = self.toward();
        SeenVehicle {
            front_m: self.s_m + toward * self.front_m,
            along_mps: toward * self.speed_mps,
            speed_mps: self.speed_mps,
        }
    }

    /// Returns the lane, counted to the left from the route's, and whether the road user is against the route.
    pub fn lane(&self) -> (i32, bool) {
        (self.lane, self.against)
    }

    /// Returns 1 for a road user along the route and -1 for one against it.
    fn toward(&self) -> f64 {
        if self.against { -1.0 } else { 1.0 }
    }

    /// Checks whether an action of this event is under way.
    pub fn is_moved_by(&self, event: usize) -> bool {
        self.speed.event() == Some(event) || self.way.event() == Some(event)
    }

    /// Begins an action, which replaces another one on the speed, or on the lateral place. `of_lane` is the lane from which a change of lanes counts.
    /// Returns false for an action that road users do not carry out.
    pub fn begin(
        &mut self,
        event: usize,
        action: &Action,
        of_lane: (i32, bool),
        (map, others): (&RoadMap, SeenVehicles),
    ) -> bool {
        let is_broken_down = matches!(action, Action::BreakDown { .. });
        let from_mps = self.speed_mps;
        match action {
            Action::Brake { decel_mps2: rate_mps2, to_mps, keep_s, .. }
            | Action::Accelerate { accel_mps2: rate_mps2, to_mps, keep_s, .. } => {
                self.speed = UserSpeed::evenly(event, from_mps, *to_mps, *rate_mps2, *keep_s);
            }
            Action::KeepSpeed { for_s, .. } => self.speed = UserSpeed::evenly(event, from_mps, from_mps, 1.0, *for_s),
            Action::BreakDown { decel_mps2, for_s, .. } => {
                self.speed = UserSpeed::evenly(event, from_mps, 0.0, *decel_mps2, *for_s);
            }
            Action::Speed(change) => {
                self.speed = UserSpeed::change(event, change, self.most_mps2, (&mut self.speed_mps, others));
            }
            Action::Synchronise(meeting) => self.speed = UserSpeed::Meets(event, meeting.clone(), None),
            Action::ChangeLane(change) => {
                self.change_lane(event, change, of_lane, map);
                return true;
            }
            Action::Offset(change) => {
                self.way = UserWay::shift(event, change, self.offset_m);
                return true;
            }
            Action::Walk(walk) => {
                self.walk(event, walk, map);
                return true;
            }
            Action::Teleport(to) => {
                self.teleport(to, map);
                return true;
            }
            _ => return false,
        }
        self.is_broken_down = is_broken_down;
        true
    }

    /// Brings the speed evenly to another one within a time, s.
    pub fn drive(&mut self, event: usize, to_mps: f64, within_s: f64) {
        let rate_mps2 = ((to_mps - self.speed_mps).abs() / within_s).max(1e-9);
        self.speed = UserSpeed::evenly(event, self.speed_mps, to_mps, rate_mps2, 0.0);
    }

    /// Begins a change into the lane of the route.
    pub fn enter_route(&mut self, event: usize, in_s: f64, map: &RoadMap) {
        let change = LaneChange {
            vehicle: self.name.clone(),
            to_the_left: 0,
            of: None,
            within_s: in_s,
            in_s: Some(in_s),
            in_m: None,
            shape: ChangeShape::Sinusoidal,
        };
        self.change_lane(event, &change, (0, false), map);
    }

    fn change_lane(&mut self, event: usize, change: &LaneChange, (lane, is_against): (i32, bool), map: &RoadMap) {
        let lateral_m = self.lateral_m(map);
        self.lane = lane + if is_against { -change.to_the_left } else { change.to_the_left };
        self.offset_m = lateral_m - map.lane_middle_m(self.s_m, self.lane);
        self.way = UserWay::change_lane(event, change, self.offset_m);
    }

    /// Begins a way along a line, at once at its first point.
    fn walk(&mut self, event: usize, walk: &Walk, map: &RoadMap) {
        self.way = UserWay::walk(event, walk, map);
        self.step_way(0.0, map);
    }

    /// Moves the road user by one tick.
    pub fn tick(&mut self, map: &RoadMap, others: SeenVehicles) {
        let before = (self.speed_mps, self.now.pose);
        self.speed_mps = self.speed.step(self.seen(), others);
        if self.speed.event().is_none() {
            self.is_broken_down = false;
        }
        let moved_m = (before.0 + self.speed_mps) / 2.0 * TICK_S;
        let pose = self.step_way(moved_m, map);
        self.show(map, pose, (self.speed_mps - before.0) / TICK_S, moved_m);
        self.now.pose_before = before.1;
    }

    /// Takes the place on by this distance. Returns the pose there.
    fn step_way(&mut self, moved_m: f64, map: &RoadMap) -> Pose {
        let (mut along_m, mut turned_rad) = (moved_m, 0.0);
        match &mut self.way {
            UserWay::Keeps => {}
            UserWay::Shifts(shift) => {
                let (offset_m, along, is_over) = shift.step(moved_m);
                let aside_m = (offset_m - self.offset_m) * if self.against { -1.0 } else { 1.0 };
                if along > 0.0 && !is_over {
                    turned_rad = aside_m.atan2(along);
                }
                (self.offset_m, along_m) = (offset_m, along);
                if is_over {
                    self.way = UserWay::Keeps;
                }
            }
            UserWay::Walks(line) => {
                let axle = line.step(moved_m);
                let is_over = line.is_over();
                let at = map.route.project(axle.position, Some(self.s_m));
                self.s_m = at.s_m;
                self.offset_m = at.offset_m - map.lane_middle_m(at.s_m, self.lane);
                self.against = wrap_angle(axle.yaw_rad - map.route.yaw_at(at.s_m)).cos() < 0.0;
                if is_over {
                    self.way = UserWay::Keeps;
                }
                return self.centred(axle);
            }
        }
        let on_route = 1.0 - map.route.curvature_at(self.s_m, CURVATURE_M) * self.lateral_m(map);
        // The shortest pieces of a road, as in junctions without an area, may be declared much longer than they are drawn.
        let [behind, ahead] = [-1.0, 1.0].map(|m| map.route.point_at(self.s_m + m));
        let drawn_m = (behind.distance(ahead) / 2.0).clamp(1.0 - MOST_DIFFERENCE, 1.0 + MOST_DIFFERENCE);
        self.s_m += self.toward() * along_m / (drawn_m * on_route.max(TIGHTEST));
        let end_m = map.route.length_m();
        if !(0.0..=end_m).contains(&self.s_m) {
            // The road ends: the road user stands there.
            (self.s_m, self.speed_mps) = (self.s_m.clamp(0.0, end_m), 0.0);
            self.speed = UserSpeed::Keeps;
        }
        self.posed(map, turned_rad)
    }

    /// Returns the lateral place on the route, m, positive to the left.
    fn lateral_m(&self, map: &RoadMap) -> f64 {
        map.lane_middle_m(self.s_m, self.lane) + self.offset_m
    }

    /// Returns the pose of the centre on the route, turned relative to it.
    fn posed(&self, map: &RoadMap, turned_rad: f64) -> Pose {
        let against_rad = if self.against { PI } else { 0.0 };
        let yaw_rad = map.route.yaw_at(self.s_m) + against_rad + turned_rad;
        self.centred(Pose::new(beside(map, self.s_m, self.lateral_m(map)), wrap_angle(yaw_rad)))
    }

    /// Returns the pose of the centre for one of the rear axle.
    fn centred(&self, axle: Pose) -> Pose {
        Pose::new(axle.position + axle.forward() * self.to_centre_m(), axle.yaw_rad)
    }

    /// Updates what is drawn.
    fn show(&mut self, map: &RoadMap, pose: Pose, accel_mps2: f64, moved_m: f64) {
        // A vehicle along the route whose middle is in its lane is one of those that follow each other there.
        let is_in_lane = self.lateral_m(map).abs() < map.route.width_m(self.s_m) / 2.0;
        let is_on_route = is_in_lane && is_along(pose.yaw_rad, map.route.yaw_at(self.s_m)) && !self.now.is_person();
        // Drivers know vehicles by their lanes, and persons by where they are beside the line that they follow.
        let near = if is_on_route {
            map.route.lanes()[map.route.lane_at(self.s_m).0].lane
        } else {
            self.now.lane.map(|at| at.lane)
        };
        let front = pose.front(self.body.length_m).extend(map.route.height_m(self.s_m));
        let front = Pose3 { position: front, yaw_rad: pose.yaw_rad, grade: 0.0 };
        let lane = map.network.lane_along(&front, near).filter(|_| !self.now.is_person());
        let aside_m = match &self.way {
            UserWay::Shifts(shift) => shift.aside_m() * self.toward(),
            _ => 0.0,
        };
        self.now = VehicleSnapshot {
            pose,
            s_m: is_on_route.then_some(self.seen().front_m),
            lane,
            speed_mps: self.speed_mps,
            accel_mps2,
            odometer_m: self.now.odometer_m + moved_m,
            height_m: map.route.height_m(self.s_m),
            lamps: VehicleLamps {
                brake: accel_mps2 < -BRAKE_LAMP_MPS2,
                left: self.is_broken_down || aside_m > INDICATES_M,
                right: self.is_broken_down || aside_m < -INDICATES_M,
                emergency: false,
            },
            pitch: self.now.pitch.step(accel_mps2, TICK_S),
            ..self.now
        };
    }
}
