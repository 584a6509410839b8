//! Frames of reference. World axes are SUMO's: x east, y north, z up, metres; yaw counter-clockwise from east, radians.
//!
//! The position of a vehicle is the [`Pose`] of its **centre** everywhere in codrive. SUMO uses the centre of the *front
//! bumper* and a compass heading in degrees (0 north, clockwise). Only [`Pose::from_sumo`] and [`Pose::to_sumo`] convert
//! between the two.

use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Length of a car on screen, in rapier and in SUMO, metres (HC22): the gap that a driver sees is the gap that the models use.
pub const CAR_LENGTH_M: f64 = 5.0;
/// Width of a car, metres (SUMO's default passenger car).
pub const CAR_WIDTH_M: f64 = 1.8;

/// Height difference from which vehicles cannot touch, m. Bridges leave 4.5 m clear, and no road climbs half of that
/// over the length of a contact.
const ONE_ROAD_M: f64 = 2.5;

/// Checks whether two heights are so close that vehicles there can touch, rather than on a bridge and below it.
pub fn is_one_road(a_m: f64, b_m: f64) -> bool {
    (a_m - b_m).abs() < ONE_ROAD_M
}

/// Cosine of the largest angle between a vehicle and the road along which it drives: half a right angle.
const ALONG_COS: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Checks whether a vehicle with this heading, rad, drives along a road with that one, rather than across or against it.
pub fn is_along(heading_rad: f64, road_rad: f64) -> bool {
    (heading_rad - road_rad).cos() > ALONG_COS
}

/// Returns 0 below `low`, 1 above `high`, and a smooth value between.
pub fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Position and heading of a vehicle's centre on the ground plane, world axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Centre of the vehicle, metres.
    pub position: DVec2,
    /// Heading, radians, counter-clockwise from east, in (-pi, pi].
    pub yaw_rad: f64,
}

/// Position and heading on a road with slopes, world axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose3 {
    /// Position in world axes, metres.
    pub position: DVec3,
    /// Heading, radians, counter-clockwise from east, in (-pi, pi].
    pub yaw_rad: f64,
    /// Grade in the direction of the heading: tangent of the slope angle, positive uphill.
    pub grade: f64,
}

impl Pose3 {
    /// Returns the pose on the ground plane.
    pub fn flat(&self) -> Pose {
        Pose { position: self.position.truncate(), yaw_rad: self.yaw_rad }
    }
}

/// Pose of a vehicle in SUMO's convention.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SumoPose {
    /// Centre of the front bumper, metres.
    pub front: DVec2,
    /// Compass heading, degrees: 0 north, clockwise.
    pub angle_deg: f64,
}

impl Pose {
    /// Makes a pose; the yaw is wrapped into (-pi, pi].
    #[inline]
    pub fn new(position: DVec2, yaw_rad: f64) -> Self {
        Self { position, yaw_rad: wrap_angle(yaw_rad) }
    }

    /// Returns the unit vector of the heading.
    pub fn forward(&self) -> DVec2 {
        DVec2::from_angle(self.yaw_rad)
    }

    /// Returns the unit vector to the vehicle's left.
    pub fn left(&self) -> DVec2 {
        self.forward().perp()
    }

    /// Returns the centre of the front bumper of a vehicle of `length_m`.
    pub fn front(&self, length_m: f64) -> DVec2 {
        self.position + self.forward() * (length_m / 2.0)
    }

    /// Returns the centre of the rear bumper of a vehicle of `length_m`.
    pub fn rear(&self, length_m: f64) -> DVec2 {
        self.position - self.forward() * (length_m / 2.0)
    }

    /// Converts from SUMO's front bumper and compass heading, for a vehicle of `length_m`.
    pub fn from_sumo(sumo: SumoPose, length_m: f64) -> Self {
        let yaw_rad = wrap_angle(FRAC_PI_2 - sumo.angle_deg.to_radians());
        let position = sumo.front - DVec2::from_angle(yaw_rad) * (length_m / 2.0);
        Self { position, yaw_rad }
    }

    /// Converts to SUMO's front bumper and compass heading (0..360), for a vehicle of `length_m`.
    pub fn to_sumo(&self, length_m: f64) -> SumoPose {
        let angle_deg = (FRAC_PI_2 - self.yaw_rad).to_degrees().rem_euclid(360.0);
        SumoPose { front: self.front(length_m), angle_deg }
    }

    /// Returns the pose at `fraction` (0..1) of the way to `other`, turning the short way round.
    pub fn lerp(&self, other: &Self, fraction: f64) -> Self {
        let turn = wrap_angle(other.yaw_rad - self.yaw_rad);
        Self::new(self.position.lerp(other.position, fraction), self.yaw_rad + turn * fraction)
    }

    /// Checks whether all numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.position.is_finite() && self.yaw_rad.is_finite()
    }
}

/// Wraps an angle into (-pi, pi], radians.
#[inline]
pub fn wrap_angle(angle_rad: f64) -> f64 {
    if -PI < angle_rad && angle_rad <= PI {
        return angle_rad;
    }
    let wrapped = angle_rad.rem_euclid(TAU);
    if wrapped > PI { wrapped - TAU } else { wrapped }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec2;

    #[test]
    fn sumo_angles_are_compass_headings_of_the_front_bumper() {
        let north = Pose::from_sumo(SumoPose { front: dvec2(10.0, 20.0), angle_deg: 0.0 }, 5.0);
        assert!((north.position - dvec2(10.0, 17.5)).length() < 1e-12);
        assert!((north.yaw_rad - FRAC_PI_2).abs() < 1e-12);
        let east = Pose::from_sumo(SumoPose { front: dvec2(0.0, 0.0), angle_deg: 90.0 }, 5.0);
        assert!((east.position - dvec2(-2.5, 0.0)).length() < 1e-12);
        assert!(east.yaw_rad.abs() < 1e-12);
    }

    #[test]
    fn a_pose_survives_the_way_to_sumo_and_back() {
        for degrees in (-180..=180).step_by(7) {
            let pose = Pose::new(dvec2(3.0, -4.0), f64::from(degrees).to_radians());
            let back = Pose::from_sumo(pose.to_sumo(CAR_LENGTH_M), CAR_LENGTH_M);
            assert!((pose.position - back.position).length() < 1e-12, "{degrees}");
            assert!(wrap_angle(pose.yaw_rad - back.yaw_rad).abs() < 1e-12, "{degrees}");
            let compass_rad = pose.to_sumo(CAR_LENGTH_M).angle_deg.to_radians();
            let along = dvec2(compass_rad.sin(), compass_rad.cos());
            assert!((along - pose.forward()).length() < 1e-12, "{degrees}");
        }
    }

    #[test]
    fn interpolation_turns_the_short_way_round() {
        let a = Pose::new(DVec2::ZERO, 3.1);
        let b = Pose::new(dvec2(2.0, 0.0), -3.1);
        let half = a.lerp(&b, 0.5);
        assert!((half.yaw_rad.abs() - PI).abs() < 1e-9, "{}", half.yaw_rad);
        assert_eq!(half.position, dvec2(1.0, 0.0));
    }
}
