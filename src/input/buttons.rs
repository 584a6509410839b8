//! Actions of the buttons of a rig or gamepad. In: evdev codes, hat values. Out: a [`ButtonAction`].

use super::parts::BUTTON_PART;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Button of the wheel or of a further device of the rig. A profile has the number of a button of the wheel, and for others a
/// text such as `"288 of 0eb7:183b"`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "ButtonText", into = "ButtonText")]
pub struct RigButton {
    /// evdev code on its device.
    pub number: u16,
    /// Device of the button (see `parts`), if it is not the wheel itself.
    pub device: Option<String>,
    /// Number of that device in the rig, 0 for the wheel itself; set when the rig is opened.
    pub part: u16,
}

/// Button as a profile has it.
#[derive(Serialize, Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected the number of a button, such as 288, or \"288 of VENDOR:PRODUCT\"")]
enum ButtonText {
    /// evdev code of a button of the wheel.
    Number(u16),
    /// Code of a button with the USB id of its device.
    Text(#[schemars(regex(pattern = r"^[0-9]+ of .+$"))] String),
}

impl RigButton {
    /// Returns the code of the button in the rig: evdev's, plus [`BUTTON_PART`] for each further device.
    pub fn code(&self) -> u16 {
        self.number + BUTTON_PART * self.part
    }
}

impl From<u16> for RigButton {
    fn from(number: u16) -> Self {
        Self { number, device: None, part: 0 }
    }
}

impl PartialEq<u16> for RigButton {
    fn eq(&self, number: &u16) -> bool {
        self.number == *number && self.device.is_none() && self.part == 0
    }
}

impl fmt::Display for RigButton {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.device {
            None => write!(f, "{}", self.number),
            Some(device) => write!(f, "{} of {device}", self.number),
        }
    }
}

impl TryFrom<ButtonText> for RigButton {
    type Error = String;

    fn try_from(text: ButtonText) -> Result<Self, String> {
        let number_and_device = match text {
            ButtonText::Number(number) => (number < BUTTON_PART).then_some((number, None)).ok_or(number.to_string()),
            ButtonText::Text(text) => text
                .split_once(" of ")
                .and_then(|(number, device)| Some((number.parse().ok()?, Some(device.to_owned()))))
                .filter(|(number, _)| *number < BUTTON_PART)
                .ok_or(text),
        };
        let (number, device) = number_and_device.map_err(|text| {
            format!(
                "\"{text}\" is no button; allowed: a number up to {}, such as 288, or \"288 of VENDOR:PRODUCT\"",
                BUTTON_PART - 1
            )
        })?;
        Ok(Self { number, device, part: 0 })
    }
}

impl From<RigButton> for ButtonText {
    fn from(button: RigButton) -> Self {
        if button.device.is_none() { Self::Number(button.number) } else { Self::Text(button.to_string()) }
    }
}

impl JsonSchema for RigButton {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "RigButton".into()
    }

    fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        ButtonText::json_schema(generator)
    }
}

/// Buttons of each action.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Buttons {
    /// Switches between drive and reverse.
    pub reverse: Vec<RigButton>,
    /// Starts the drive, or resumes it after a pause.
    pub start: Vec<RigButton>,
    /// Marks the present moment in the recording.
    pub mark: Vec<RigButton>,
    /// Answers the question on the screen.
    pub answer: Vec<RigButton>,
    /// Returns to the driver's view.
    pub recentre: Vec<RigButton>,
    /// Requests the end of the drive.
    pub abort: Vec<RigButton>,
    /// Sounds the horn while held.
    pub horn: Vec<RigButton>,
    /// Switches the left indicator on or off.
    pub indicate_left: Vec<RigButton>,
    /// Switches the right indicator on or off.
    pub indicate_right: Vec<RigButton>,
    /// Switches the main beam on or off.
    pub main_beam: Vec<RigButton>,
    /// Responds to the secondary task.
    pub respond: Vec<RigButton>,
    /// Switches the automation on or off.
    pub automation: Vec<RigButton>,
    /// Sets the automation's time gap to the vehicle ahead.
    pub time_gap: Vec<RigButton>,
    /// Brakes with full force while held.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub handbrake: Vec<RigButton>,
    /// Up button of a d-pad; evdev's BTN_DPAD_UP by default. A d-pad that is a hat needs no entry.
    pub dpad_up: Vec<RigButton>,
    /// Down button of a d-pad, see `dpad_up`.
    pub dpad_down: Vec<RigButton>,
    /// Left button of a d-pad, see `dpad_up`.
    pub dpad_left: Vec<RigButton>,
    /// Right button of a d-pad, see `dpad_up`.
    pub dpad_right: Vec<RigButton>,
}

impl Default for Buttons {
    fn default() -> Self {
        let none = Vec::new;
        Self {
            reverse: none(),
            start: none(),
            mark: none(),
            answer: none(),
            recentre: none(),
            abort: none(),
            horn: none(),
            indicate_left: none(),
            indicate_right: none(),
            main_beam: none(),
            respond: none(),
            automation: none(),
            time_gap: none(),
            handbrake: none(),
            // BTN_DPAD_UP to BTN_DPAD_RIGHT of Linux's input-event-codes.h.
            dpad_up: vec![544.into()],
            dpad_down: vec![545.into()],
            dpad_left: vec![546.into()],
            dpad_right: vec![547.into()],
        }
    }
}

/// Action that the participant requests with a button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ButtonAction {
    /// Switch between drive and reverse.
    Reverse,
    /// Start the drive, or resume it after a pause.
    Start,
    /// Mark the present moment in the recording.
    Mark,
    /// Answer the question on the screen.
    Answer,
    /// Return to the driver's view.
    Recentre,
    /// Request the end of the drive.
    Abort,
    /// Sound the horn while held.
    Horn,
    /// Switch the left indicator on or off.
    IndicateLeft,
    /// Switch the right indicator on or off.
    IndicateRight,
    /// Switch the main beam on or off.
    MainBeam,
    /// Respond to the secondary task.
    Respond,
    /// Switch the automation on or off.
    Automation,
    /// Set the automation's time gap to the next setting.
    TimeGap,
    /// Brake with full force while held.
    Handbrake,
    /// D-pad up: more, or the choice above.
    Up,
    /// D-pad down: less, or the choice below.
    Down,
    /// D-pad left: less, or the previous choice.
    Left,
    /// D-pad right: more, or the next choice.
    Right,
}

impl fmt::Display for ButtonAction {
    /// Writes a short description for display.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Reverse => "drive, reverse",
            Self::Start => "start, continue",
            Self::Mark => "mark this moment",
            Self::Answer => "answer",
            Self::Recentre => "driver's view, back onto the lane",
            Self::Abort => "ask to end the drive",
            Self::Horn => "horn",
            Self::IndicateLeft => "indicate left",
            Self::IndicateRight => "indicate right",
            Self::MainBeam => "main beam",
            Self::Respond => "respond to the secondary task",
            Self::Automation => "automation on, off",
            Self::TimeGap => "time gap of the automation",
            Self::Handbrake => "handbrake",
            Self::Up => "up, higher",
            Self::Down => "down, lower",
            Self::Left => "left, lower",
            Self::Right => "right, higher",
        })
    }
}

impl ButtonAction {
    /// Actions that a person can assign to buttons.
    pub const ALL: [Self; 14] = [
        Self::Start,
        Self::Reverse,
        Self::IndicateLeft,
        Self::IndicateRight,
        Self::MainBeam,
        Self::Respond,
        Self::Automation,
        Self::TimeGap,
        Self::Horn,
        Self::Mark,
        Self::Answer,
        Self::Recentre,
        Self::Abort,
        Self::Handbrake,
    ];
    /// Actions of the d-pad, which need no assignment if it is a hat.
    pub const DPAD: [Self; 4] = [Self::Up, Self::Down, Self::Left, Self::Right];

    /// Returns all actions, those of the d-pad last.
    pub fn every() -> impl Iterator<Item = Self> {
        Self::ALL.into_iter().chain(Self::DPAD)
    }

    /// Returns the action of a hat movement: evdev's ABS_HAT0X (16) and ABS_HAT0Y (17), -1 is left and up. Returns
    /// `None` for the middle position and for other axes.
    pub fn of_hat(axis: u16, raw: i32) -> Option<Self> {
        match (axis, raw.signum()) {
            (16, -1) => Some(Self::Left),
            (16, 1) => Some(Self::Right),
            (17, -1) => Some(Self::Up),
            (17, 1) => Some(Self::Down),
            _ => None,
        }
    }
}

impl Buttons {
    /// Returns the buttons of an action.
    pub fn of(&mut self, action: ButtonAction) -> &mut Vec<RigButton> {
        match action {
            ButtonAction::Reverse => &mut self.reverse,
            ButtonAction::Start => &mut self.start,
            ButtonAction::Mark => &mut self.mark,
            ButtonAction::Answer => &mut self.answer,
            ButtonAction::Recentre => &mut self.recentre,
            ButtonAction::Abort => &mut self.abort,
            ButtonAction::Horn => &mut self.horn,
            ButtonAction::IndicateLeft => &mut self.indicate_left,
            ButtonAction::IndicateRight => &mut self.indicate_right,
            ButtonAction::MainBeam => &mut self.main_beam,
            ButtonAction::Respond => &mut self.respond,
            ButtonAction::Automation => &mut self.automation,
            ButtonAction::TimeGap => &mut self.time_gap,
            ButtonAction::Handbrake => &mut self.handbrake,
            ButtonAction::Up => &mut self.dpad_up,
            ButtonAction::Down => &mut self.dpad_down,
            ButtonAction::Left => &mut self.dpad_left,
            ButtonAction::Right => &mut self.dpad_right,
        }
    }

    /// Assigns a button to an action, in place of the action's other buttons and of the button's other actions.
    pub fn give(&mut self, button: impl Into<RigButton>, action: ButtonAction) {
        let button = button.into();
        for other in ButtonAction::every() {
            self.of(other).retain(|taken| taken.code() != button.code());
        }
        *self.of(action) = vec![button];
    }

    /// Returns the action of a button, by its code in the rig.
    pub fn action(&self, code: u16) -> Option<ButtonAction> {
        self.all().find(|(_, button)| button.code() == code).map(|(action, _)| action)
    }

    /// Returns all buttons with their actions.
    pub fn all(&self) -> impl Iterator<Item = (ButtonAction, &RigButton)> {
        let lists = [
            (ButtonAction::Reverse, &self.reverse),
            (ButtonAction::Start, &self.start),
            (ButtonAction::Mark, &self.mark),
            (ButtonAction::Answer, &self.answer),
            (ButtonAction::Recentre, &self.recentre),
            (ButtonAction::Abort, &self.abort),
            (ButtonAction::Horn, &self.horn),
            (ButtonAction::IndicateLeft, &self.indicate_left),
            (ButtonAction::IndicateRight, &self.indicate_right),
            (ButtonAction::MainBeam, &self.main_beam),
            (ButtonAction::Respond, &self.respond),
            (ButtonAction::Automation, &self.automation),
            (ButtonAction::TimeGap, &self.time_gap),
            (ButtonAction::Handbrake, &self.handbrake),
            (ButtonAction::Up, &self.dpad_up),
            (ButtonAction::Down, &self.dpad_down),
            (ButtonAction::Left, &self.dpad_left),
            (ButtonAction::Right, &self.dpad_right),
        ];
        lists.into_iter().flat_map(|(action, buttons)| buttons.iter().map(move |button| (action, button)))
    }
}
