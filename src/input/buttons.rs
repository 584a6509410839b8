//! Actions of the buttons of a wheel or gamepad. In: evdev codes, hat values. Out: a [`ButtonAction`].

use serde::{Deserialize, Serialize};

/// Buttons of each action, as evdev codes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Buttons {
    /// Switches between drive and reverse.
    pub reverse: Vec<u16>,
    /// Starts the drive, or resumes it after a pause.
    pub start: Vec<u16>,
    /// Marks the present moment in the recording.
    pub mark: Vec<u16>,
    /// Answers the question on the screen.
    pub answer: Vec<u16>,
    /// Returns to the driver's view.
    pub recentre: Vec<u16>,
    /// Requests the end of the drive.
    pub abort: Vec<u16>,
    /// Sounds the horn while held.
    pub horn: Vec<u16>,
    /// Switches the left indicator on or off.
    pub indicate_left: Vec<u16>,
    /// Switches the right indicator on or off.
    pub indicate_right: Vec<u16>,
    /// Up button of a d-pad; evdev's BTN_DPAD_UP by default. A d-pad that is a hat needs no entry.
    pub dpad_up: Vec<u16>,
    /// Down button of a d-pad, see `dpad_up`.
    pub dpad_down: Vec<u16>,
    /// Left button of a d-pad, see `dpad_up`.
    pub dpad_left: Vec<u16>,
    /// Right button of a d-pad, see `dpad_up`.
    pub dpad_right: Vec<u16>,
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
            // BTN_DPAD_UP to BTN_DPAD_RIGHT of Linux's input-event-codes.h.
            dpad_up: vec![544],
            dpad_down: vec![545],
            dpad_left: vec![546],
            dpad_right: vec![547],
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
    /// D-pad up: more, or the choice above.
    Up,
    /// D-pad down: less, or the choice below.
    Down,
    /// D-pad left: less, or the previous choice.
    Left,
    /// D-pad right: more, or the next choice.
    Right,
}

impl std::fmt::Display for ButtonAction {
    /// Writes a short description for display.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
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
            Self::Up => "up, higher",
            Self::Down => "down, lower",
            Self::Left => "left, lower",
            Self::Right => "right, higher",
        })
    }
}

impl ButtonAction {
    /// Actions that a person can assign to buttons.
    pub const ALL: [Self; 9] = [
        Self::Start,
        Self::Reverse,
        Self::IndicateLeft,
        Self::IndicateRight,
        Self::Horn,
        Self::Mark,
        Self::Answer,
        Self::Recentre,
        Self::Abort,
    ];
    /// Actions of the d-pad, which need no assignment if it is a hat.
    pub const DPAD: [Self; 4] = [Self::Up, Self::Down, Self::Left, Self::Right];

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
    pub fn of(&mut self, action: ButtonAction) -> &mut Vec<u16> {
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
            ButtonAction::Up => &mut self.dpad_up,
            ButtonAction::Down => &mut self.dpad_down,
            ButtonAction::Left => &mut self.dpad_left,
            ButtonAction::Right => &mut self.dpad_right,
        }
    }

    /// Assigns a button to an action, in place of the action's other buttons and of the button's other actions.
    pub fn give(&mut self, code: u16, action: ButtonAction) {
        for other in ButtonAction::ALL.into_iter().chain(ButtonAction::DPAD) {
            self.of(other).retain(|taken| *taken != code);
        }
        *self.of(action) = vec![code];
    }

    /// Returns the action of a button.
    pub fn action(&self, code: u16) -> Option<ButtonAction> {
        let all = [
            (&self.reverse, ButtonAction::Reverse),
            (&self.start, ButtonAction::Start),
            (&self.mark, ButtonAction::Mark),
            (&self.answer, ButtonAction::Answer),
            (&self.recentre, ButtonAction::Recentre),
            (&self.abort, ButtonAction::Abort),
            (&self.horn, ButtonAction::Horn),
            (&self.indicate_left, ButtonAction::IndicateLeft),
            (&self.indicate_right, ButtonAction::IndicateRight),
            (&self.dpad_up, ButtonAction::Up),
            (&self.dpad_down, ButtonAction::Down),
            (&self.dpad_left, ButtonAction::Left),
            (&self.dpad_right, ButtonAction::Right),
        ];
        all.into_iter().find(|(codes, _)| codes.contains(&code)).map(|(_, action)| action)
    }
}
