//! What whoever drives asks of the car, and what helps them to. In: pedals, wheel and selector of a device, of a simulated driver
//! or of a recording. Out: [`Controls`], once a tick; [`LaneHint`], the lane as lane help sees it. Radians, metres, seconds.

/// What pedals, wheel, selector and stalk ask of the car in one tick.
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
    /// Which indicators are on.
    #[serde(default)]
    pub indicator: Indicator,
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
            indicator: self.indicator,
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

/// Direction indicators: the side to which the driver is going to turn or to change lanes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Indicator {
    /// Dark.
    #[default]
    Off,
    /// Those on the left blink.
    Left,
    /// Those on the right blink.
    Right,
}

impl Indicator {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Off, Self::Left, Self::Right];

    /// As recordings have it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Left => "left",
            Self::Right => "right",
        }
    }

    /// Blinking at this time: what of it is lit, half of each period.
    pub fn lit_at(self, time_s: f64) -> Self {
        if (time_s / BLINK_S).fract() < 0.5 { self } else { Self::Off }
    }
}

/// Period in which an indicator is lit and dark once, seconds: 86 a minute (UN R48 asks for 60 to 120).
pub const BLINK_S: f64 = 0.7;

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
