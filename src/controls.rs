//! What whoever drives asks of the car, and what helps them to. In: pedals, wheel and selector of a device, of a simulated driver
//! or of a recording. Out: [`Controls`], once a tick; [`LaneHint`], the lane as lane help sees it. Radians, metres.

/// What pedals, wheel and selector ask of the car in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Controls {
    /// Accelerator, 0 released to 1 floored.
    pub throttle: f32,
    /// Brake pedal, 0 released to 1 full force.
    pub brake: f32,
    /// Angle of the steering wheel, radians, positive to the left (lock at +-450 degrees).
    pub steering_wheel_rad: f32,
    /// Position of the selector.
    pub selector: Selector,
}

impl Controls {
    /// The same with every number within its limits; what is not a number counts as released and straight ahead.
    pub fn sane(&self) -> Self {
        let within = |value: f32, low: f32, high: f32| if value.is_nan() { 0.0 } else { value.clamp(low, high) };
        Self {
            throttle: within(self.throttle, 0.0, 1.0),
            brake: within(self.brake, 0.0, 1.0),
            steering_wheel_rad: within(self.steering_wheel_rad, -STEERING_LOCK_RAD, STEERING_LOCK_RAD),
            selector: self.selector,
        }
    }
}

/// Position of the automatic gearbox's selector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Selector {
    /// Forwards.
    #[default]
    Drive,
    /// Nothing engaged.
    Neutral,
    /// Backwards.
    Reverse,
}

/// Steering wheel angle per road wheel angle (a mid-size saloon).
pub const STEERING_RATIO: f32 = 15.0;
/// The steering wheel's lock on either side, radians (a G29 turns 900 degrees in all).
pub const STEERING_LOCK_RAD: f32 = 450.0 * std::f32::consts::PI / 180.0;

/// The lane as lane help sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LaneHint {
    /// Curvature of the lane a little ahead, 1/m, positive to the left.
    pub curvature: f64,
    /// Car's offset from the centre line, metres, positive to the left.
    pub offset_m: f64,
    /// Car's heading against the lane's, radians, positive to the left.
    pub heading_error_rad: f64,
}
