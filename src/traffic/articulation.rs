//! Bodies of long vehicles. In: the place of the front bumper after each step. Out: the heading of a vehicle whose bodies follow the path of
//! its own front, and the poses of the two parts of an articulated one. Metres, radians, world axes.
//!
//! SUMO draws long vehicles with the front on the lane and the rear on the lane behind. The heading that it reports is another where a lane
//! change begins behind a bend (that of the lane alone), and for its articulated shapes (that of the first part alone). A rigid bar of that
//! heading swings its rear across the lanes beside it.

use super::{VehicleBody, VehicleKind};
use crate::space::{Pose, wrap_angle};
use glam::DVec2;
use std::collections::VecDeque;

/// Length from which a vehicle follows the path of its front, metres. Up to it, SUMO's heading is that path's within 10 degrees.
const LONG_M: f64 = 8.0;
/// Length from which a lorry has a trailer, metres: the longest rigid one allowed in the EU.
const ARTICULATED_LORRY_M: f64 = 12.0;
/// Length above which a bus has a joint, metres: the longest rigid one allowed in the EU.
const RIGID_BUS_M: f64 = 15.0;
/// Positions of the joints, as shares of the length behind the front: the kingpin of a semi-trailer of 16.5 m, 4.65 m behind the bumper,
/// and the middle of the bellows of a bus of 18 m.
const KINGPIN: f64 = 4.65 / 16.5;
const BELLOWS: f64 = 0.56;
/// Length of the path that is kept, as a multiple of the vehicle's length: more than its bodies span in any bend.
const KEPT: f64 = 2.0;
/// Shortest distance between two points of a path, metres.
const APART_M: f64 = 0.1;

/// Headings of the two parts of an articulated vehicle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Articulation {
    /// Heading of the tractor, or of the front of a bus, radians.
    pub front_yaw_rad: f64,
    /// Heading of the trailer, or of the rear of a bus, radians.
    pub rear_yaw_rad: f64,
}

impl Articulation {
    /// Returns the headings at `fraction` (0..1) of the way to `other`, turning the short way round.
    pub fn lerp(&self, other: &Self, fraction: f64) -> Self {
        let mix = |from: f64, to: f64| wrap_angle(from + wrap_angle(to - from) * fraction);
        Self {
            front_yaw_rad: mix(self.front_yaw_rad, other.front_yaw_rad),
            rear_yaw_rad: mix(self.rear_yaw_rad, other.rear_yaw_rad),
        }
    }
}

/// A rigid part of a vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VehiclePart {
    /// Pose of the part's centre.
    pub pose: Pose,
    /// Length from bumper to joint, or from bumper to bumper, metres.
    pub length_m: f64,
}

impl VehiclePart {
    fn behind(front: DVec2, yaw_rad: f64, length_m: f64) -> Self {
        Self { pose: Pose::new(front - DVec2::from_angle(yaw_rad) * (length_m / 2.0), yaw_rad), length_m }
    }
}

impl VehicleBody {
    /// Returns the distance of the joint from the front bumper, metres; `None` for a vehicle of one part.
    pub fn joint_m(&self) -> Option<f64> {
        match self.kind {
            VehicleKind::Truck if self.length_m >= ARTICULATED_LORRY_M => Some(KINGPIN * self.length_m),
            VehicleKind::Bus if self.length_m > RIGID_BUS_M => Some(BELLOWS * self.length_m),
            _ => None,
        }
    }

    /// Returns the parts of a vehicle with its front bumper where that of `pose` is, the front one first; in a line with `pose` where
    /// their headings are not known.
    pub fn parts(&self, pose: &Pose, articulation: Option<Articulation>) -> impl Iterator<Item = VehiclePart> + use<> {
        let parts = match self.joint_m() {
            Some(joint_m) => {
                let straight = Articulation { front_yaw_rad: pose.yaw_rad, rear_yaw_rad: pose.yaw_rad };
                let Articulation { front_yaw_rad, rear_yaw_rad } = articulation.unwrap_or(straight);
                let front = VehiclePart::behind(pose.front(self.length_m), front_yaw_rad, joint_m);
                let rear = VehiclePart::behind(front.pose.rear(joint_m), rear_yaw_rad, self.length_m - joint_m);
                [Some(front), Some(rear)]
            }
            None => [Some(VehiclePart { pose: *pose, length_m: self.length_m }), None],
        };
        parts.into_iter().flatten()
    }
}

/// Path of a long vehicle's front bumper.
#[derive(Clone, Debug)]
pub(super) struct FrontPath {
    /// Points of the path, the oldest first, and the present front.
    points: VecDeque<DVec2>,
}

impl FrontPath {
    /// Returns the path of a vehicle with a pose; `None` for a vehicle that needs none. Before it, the vehicle went straight on.
    pub fn of(body: &VehicleBody, pose: &Pose) -> Option<Self> {
        (body.length_m >= LONG_M || body.joint_m().is_some()).then(|| Self::straight(body, pose))
    }

    fn straight(body: &VehicleBody, pose: &Pose) -> Self {
        let front = pose.front(body.length_m);
        Self { points: [front - pose.forward() * (KEPT * body.length_m), front].into() }
    }

    /// Moves the front to that of SUMO's `pose` after a step. A vehicle that moves further than `farthest_m` was not driven there: it has
    /// SUMO's heading.
    pub fn follow(&mut self, body: &VehicleBody, pose: &Pose, farthest_m: f64) {
        let front = pose.front(body.length_m);
        let [before, last] = [2, 1].map(|from_end| self.points[self.points.len() - from_end]);
        if last.distance(front) > farthest_m {
            *self = Self::straight(body, pose);
            return;
        }
        // The last point is the present front; it stays as a point of the path if it is far enough from the one before.
        if before.distance(last) < APART_M {
            self.points.pop_back();
        }
        self.points.push_back(front);
        let kept_m = KEPT * body.length_m;
        while self.points.len() > 2 && self.points[1].distance(front) > kept_m {
            self.points.pop_front();
        }
    }

    /// Returns the pose of the vehicle, whose heading is that from its rear to its front, and the headings of its parts.
    pub fn pose(&self, body: &VehicleBody) -> (Pose, Option<Articulation>) {
        let front = self.points[self.points.len() - 1];
        let (rear, articulation) = match body.joint_m() {
            Some(joint_m) => {
                let joint = self.behind(front, joint_m, self.points.len());
                let rear = self.behind(joint.0, body.length_m - joint_m, joint.1);
                let articulation = Articulation {
                    front_yaw_rad: (front - joint.0).to_angle(),
                    rear_yaw_rad: (joint.0 - rear.0).to_angle(),
                };
                (rear.0, Some(articulation))
            }
            None => (self.behind(front, body.length_m, self.points.len()).0, None),
        };
        (VehiclePart::behind(front, (front - rear).to_angle(), body.length_m).pose, articulation)
    }

    /// Returns the first point of the path that is `length_m` from `from` in a straight line, among the points before the one with index
    /// `end`, and the number of points before it. A path that is too short goes straight on.
    fn behind(&self, from: DVec2, length_m: f64, end: usize) -> (DVec2, usize) {
        let mut near = from;
        for (index, point) in self.points.iter().take(end).enumerate().rev() {
            if from.distance(*point) >= length_m {
                return (at_distance(from, near, *point, length_m), index + 1);
            }
            near = *point;
        }
        (from + (near - from).normalize_or(-DVec2::X) * length_m, 0)
    }
}

/// Returns the point between `near` and `far` that is `length_m` from `from`; `near` is nearer, `far` is not.
fn at_distance(from: DVec2, near: DVec2, far: DVec2, length_m: f64) -> DVec2 {
    let (along, offset) = (far - near, near - from);
    // |offset + share along| = length_m; the larger root, as `near` is inside the circle.
    let (a, b) = (along.length_squared(), offset.dot(along));
    let c = offset.length_squared() - length_m * length_m;
    let root = (b * b - a * c).max(0.0).sqrt();
    if a == 0.0 { far } else { near + along * ((root - b) / a).clamp(0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::traffic::VehicleKind::{Bus, Truck};
    use glam::dvec2;
    use std::f64::consts::{FRAC_PI_2, TAU};

    fn body(kind: VehicleKind, length_m: f64) -> VehicleBody {
        VehicleBody { kind, length_m, width_m: 2.5, height_m: 3.4 }
    }

    /// Drives a front 40 m to the east and round a quarter circle to the north with this radius; returns what it is like every 0.5 m.
    fn drive(body: &VehicleBody, radius_m: f64) -> Vec<(Pose, Option<Articulation>)> {
        let start = Pose::new(dvec2(-40.0 - body.length_m / 2.0, 0.0), 0.0);
        let mut path = FrontPath::of(body, &start).expect("a long vehicle");
        let way = |way_m: f64| match way_m - 40.0 {
            before if before < 0.0 => dvec2(before, 0.0),
            turn_m if turn_m < radius_m * FRAC_PI_2 => {
                let (sin, cos) = (turn_m / radius_m).sin_cos();
                dvec2(radius_m * sin, radius_m * (1.0 - cos))
            }
            on_m => dvec2(radius_m, radius_m + on_m - radius_m * FRAC_PI_2),
        };
        let drive = |k: u32| {
            // SUMO's heading is wrong on purpose.
            let front = way(f64::from(k) * 0.5);
            path.follow(body, &Pose::new(front - DVec2::X * (body.length_m / 2.0), 0.0), 2.0);
            path.pose(body)
        };
        (0..180).map(drive).collect()
    }

    /// Distance of a point from the path of [`drive`], metres.
    fn beside_m(point: DVec2, radius_m: f64) -> f64 {
        match (point.x < 0.0, point.y > radius_m) {
            (true, _) => point.y.abs(),
            (_, true) => (point.x - radius_m).abs(),
            _ => (point.distance(dvec2(0.0, radius_m)) - radius_m).abs(),
        }
    }

    #[test]
    fn joints_and_rears_of_long_vehicles_stay_on_the_path_of_the_front() {
        for (body, joints) in [(body(Bus, 12.0), 1), (body(Bus, 18.0), 2), (body(Truck, 16.5), 2)] {
            for (pose, articulation) in drive(&body, 11.0) {
                let parts: Vec<VehiclePart> = body.parts(&pose, articulation).collect();
                assert_eq!(parts.len(), joints, "{body:?}");
                let ends = parts.iter().map(|part| part.pose.rear(part.length_m));
                let off_m = ends.map(|end| beside_m(end, 11.0)).fold(0.0, f64::max);
                assert!(off_m < 0.05, "{body:?}: {off_m} m beside the path at {pose:?}");
                let length_m: f64 = parts.iter().map(|part| part.length_m).sum();
                assert!((length_m - body.length_m).abs() < 1e-9);
                assert!(parts[0].pose.front(parts[0].length_m).distance(pose.front(body.length_m)) < 1e-9);
            }
        }
    }

    #[test]
    fn headings_turn_no_faster_than_the_front_drives_round_its_rear() {
        for body in [body(Bus, 12.0), body(Bus, 18.0), body(Truck, 16.5)] {
            let turn = |from: f64, to: f64| wrap_angle(to - from).abs();
            for pair in drive(&body, 11.0).windows(2) {
                let [(from, bent), (to, bends)] = [pair[0], pair[1]];
                assert!(turn(from.yaw_rad, to.yaw_rad) < 0.5 / 6.0, "{from:?} {to:?}");
                if let (Some(from), Some(to)) = (bent, bends) {
                    assert!(turn(from.front_yaw_rad, to.front_yaw_rad) < 0.5 / 2.5, "{from:?} {to:?}");
                    assert!(turn(from.rear_yaw_rad, to.rear_yaw_rad) < 0.5 / 5.0, "{from:?} {to:?}");
                }
            }
        }
    }

    #[test]
    fn a_vehicle_moved_elsewhere_has_the_heading_that_it_is_given() {
        let bus = body(Bus, 18.0);
        let mut path = FrontPath::of(&bus, &Pose::default()).expect("a long vehicle");
        let there = Pose::new(dvec2(200.0, 50.0), 1.0);
        path.follow(&bus, &there, 3.0);
        let (pose, articulation) = path.pose(&bus);
        assert!(pose.position.distance(there.position) < 1e-9 && (pose.yaw_rad - 1.0).abs() < 1e-9);
        let articulation = articulation.expect("it has a joint");
        assert!((articulation.front_yaw_rad - articulation.rear_yaw_rad).abs() < 1e-9);
    }

    #[test]
    fn cars_vans_and_short_lorries_keep_the_heading_of_sumo() {
        for body in [VehicleBody::CAR, body(VehicleKind::Van, 6.5), body(Truck, 7.1)] {
            assert!(FrontPath::of(&body, &Pose::default()).is_none(), "{body:?}");
            assert_eq!(body.parts(&Pose::default(), None).count(), 1);
        }
    }

    #[test]
    fn headings_of_parts_mix_the_short_way_round() {
        let from = Articulation { front_yaw_rad: TAU / 2.0 - 0.1, rear_yaw_rad: 0.0 };
        let to = Articulation { front_yaw_rad: 0.1 - TAU / 2.0, rear_yaw_rad: 0.2 };
        let half = from.lerp(&to, 0.5);
        assert!((half.front_yaw_rad.abs() - TAU / 2.0).abs() < 1e-9 && (half.rear_yaw_rad - 0.1).abs() < 1e-9);
    }
}
