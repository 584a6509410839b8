//! Controls that a driver gives to a vehicle, their device, and the lane data of lane help. In: pedals, wheel and selector of a
//! device, of a simulated driver or of a recording. Out: [`Controls`] for each tick, and [`LaneHint`]. Radians, metres, seconds.

/// Positions of pedals, wheel, selector and stalk in one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Controls {
    /// Accelerator, 0 released to 1 floored.
    pub throttle: f32,
    /// Brake pedal, 0 released to 1 full force.
    pub brake: f32,
    /// Angle of the steering wheel, radians, positive to the left (lock at +-450 degrees).
    pub steering_wheel_rad: f32,
    /// Position of the gearbox selector.
    pub selector: Selector,
    /// Indicators that are on.
    #[serde(default)]
    pub indicator: Indicator,
    /// True while the main beam is on.
    #[serde(default)]
    pub main_beam: bool,
    /// Button of the secondary task that was pressed.
    #[serde(default)]
    pub task_button: TaskButton,
    /// True in a tick in which the button of the automation was pressed.
    #[serde(default)]
    pub automation_button: bool,
    /// True in a tick in which the button of the automation's time gap was pressed.
    #[serde(default)]
    pub gap_button: bool,
    /// Estimated torque of the hands on the steering wheel, N m, positive to the left; `None` without force feedback.
    #[serde(default)]
    pub hand_torque_nm: Option<f32>,
}

/// Travel of a pedal that counts as pressed in events and responses to them, as a share: beyond the noise of pedals at rest.
pub const PEDAL_PRESSED: f32 = 0.02;

impl Controls {
    /// Returns the controls with every number clamped to its limits; NaN becomes 0, and a torque that is no number `None`.
    pub fn sane(&self) -> Self {
        let within = |value: f32, low: f32, high: f32| if value.is_nan() { 0.0 } else { value.clamp(low, high) };
        Self {
            throttle: within(self.throttle, 0.0, 1.0),
            brake: within(self.brake, 0.0, 1.0),
            steering_wheel_rad: within(self.steering_wheel_rad, -STEERING_LOCK_RAD, STEERING_LOCK_RAD),
            selector: self.selector,
            indicator: self.indicator,
            main_beam: self.main_beam,
            task_button: self.task_button,
            automation_button: self.automation_button,
            gap_button: self.gap_button,
            hand_torque_nm: self.hand_torque_nm.filter(|torque_nm| torque_nm.is_finite()),
        }
    }
}

/// Device that drives the ego: the one touched last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControlSource {
    Keyboard,
    /// A gamepad, or a wheel on a system without evdev.
    Pad,
    /// A steering wheel read through evdev.
    Wheel,
}

/// Position of the automatic gearbox's selector.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub enum Selector {
    #[default]
    Drive,
    Neutral,
    Reverse,
}

/// Button of a secondary task, pressed in a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TaskButton {
    /// No press in this tick.
    #[default]
    None,
    /// Response, or confirmation of the cursor's column.
    Respond,
    /// Cursor one column to the left.
    Left,
    /// Cursor one column to the right.
    Right,
}

impl TaskButton {
    /// All buttons, in the order of declaration.
    pub const ALL: [Self; 4] = [Self::None, Self::Respond, Self::Left, Self::Right];

    /// Returns the word used in recordings.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Respond => "respond",
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

/// Direction indicators: the side to which the driver is going to turn or to change lanes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Indicator {
    #[default]
    Off,
    Left,
    Right,
}

impl Indicator {
    /// All settings, in the order of declaration.
    pub const ALL: [Self; 3] = [Self::Off, Self::Left, Self::Right];

    /// Returns the word used in recordings.
    pub fn name(self) -> &'static str {
        match self {
            Self::Off => "off",
            Self::Left => "left",
            Self::Right => "right",
        }
    }

    /// Returns the lit side at this time: lit in the first half of each period, dark in the second.
    pub fn lit_at(self, time_s: f64) -> Self {
        if (time_s / BLINK_S).fract() < 0.5 { self } else { Self::Off }
    }
}

/// Blinking period of an indicator, s: 86 a minute (UN R48 requires 60 to 120).
pub const BLINK_S: f64 = 0.7;

/// Steering wheel angle per road wheel angle, as in a mid-size saloon.
pub const STEERING_RATIO: f32 = 15.0;
/// Steering wheel angle at the lock on either side, radians (a G29 turns 900 degrees in all).
pub const STEERING_LOCK_RAD: f32 = 450.0 * std::f32::consts::PI / 180.0;

/// Lane data for lane help.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LaneHint {
    /// Curvature of the lane a little ahead, 1/m, positive to the left.
    pub curvature: f64,
    /// Offset of the vehicle from the centre line, metres, positive to the left.
    pub offset_m: f64,
    /// Heading of the vehicle relative to the lane, radians, positive to the left.
    pub heading_error_rad: f64,
}
