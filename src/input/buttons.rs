//! Buttons of a wheel or pad by what they do. In: evdev codes, ways of a hat. Out: a [`ButtonAction`].

use serde::{Deserialize, Serialize};

/// Buttons by what they do, as evdev codes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Buttons {
    /// Drive to reverse and back.
    pub reverse: Vec<u16>,
    /// Begin, or go on after a pause.
    pub start: Vec<u16>,
    /// Mark this moment in the recording.
    pub mark: Vec<u16>,
    /// Answer what is asked.
    pub answer: Vec<u16>,
    /// Back to the driver's view.
    pub recentre: Vec<u16>,
    /// Ask for the end of the drive.
    pub abort: Vec<u16>,
    /// Sound the horn for as long as it is held.
    pub horn: Vec<u16>,
    /// Indicate to the left, or no longer.
    pub indicate_left: Vec<u16>,
    /// Indicate to the right, or no longer.
    pub indicate_right: Vec<u16>,
    /// The four ways of a d-pad that is made of buttons (evdev's BTN_DPAD where nothing is said); one that is a hat needs none.
    pub dpad_up: Vec<u16>,
    /// See `dpad_up`.
    pub dpad_down: Vec<u16>,
    /// See `dpad_up`.
    pub dpad_left: Vec<u16>,
    /// See `dpad_up`.
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

/// What the participant asks for with a button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ButtonAction {
    /// Drive to reverse and back.
    Reverse,
    /// Begin, or go on after a pause.
    Start,
    /// Mark this moment.
    Mark,
    /// Answer what is asked.
    Answer,
    /// Back to the driver's view.
    Recentre,
    /// Ask for the end of the drive.
    Abort,
    /// Sound the horn for as long as it is held.
    Horn,
    /// Indicate to the left, or no longer.
    IndicateLeft,
    /// Indicate to the right, or no longer.
    IndicateRight,
    /// The d-pad upwards: more, or the choice above.
    Up,
    /// The d-pad downwards: less, or the choice below.
    Down,
    /// The d-pad to the left: less, or the choice before.
    Left,
    /// The d-pad to the right: more, or the choice after.
    Right,
}

impl ButtonAction {
    /// Those that a person gives to buttons.
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
    /// Those of the d-pad, which a wheel tells by itself.
    pub const DPAD: [Self; 4] = [Self::Up, Self::Down, Self::Left, Self::Right];

    /// What a movement of a hat means: evdev's ABS_HAT0X (16) and ABS_HAT0Y (17), -1 left and up. `None` for its way back, and for
    /// any other axis.
    pub fn of_hat(axis: u16, raw: i32) -> Option<Self> {
        match (axis, raw.signum()) {
            (16, -1) => Some(Self::Left),
            (16, 1) => Some(Self::Right),
            (17, -1) => Some(Self::Up),
            (17, 1) => Some(Self::Down),
            _ => None,
        }
    }

    /// What it does, in a few words.
    pub fn words(self) -> &'static str {
        match self {
            Self::Reverse => "drive, reverse",
            Self::Start => "start, go on",
            Self::Mark => "mark this moment",
            Self::Answer => "answer",
            Self::Recentre => "driver's view, back onto the lane",
            Self::Abort => "ask for the end",
            Self::Horn => "horn",
            Self::IndicateLeft => "indicate left",
            Self::IndicateRight => "indicate right",
            Self::Up => "up, more",
            Self::Down => "down, less",
            Self::Left => "left, less",
            Self::Right => "right, more",
        }
    }
}

impl Buttons {
    /// The buttons of an action.
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

    /// Gives a button to an action, and takes it from any other.
    pub fn give(&mut self, code: u16, action: ButtonAction) {
        for other in ButtonAction::ALL.into_iter().chain(ButtonAction::DPAD) {
            self.of(other).retain(|taken| *taken != code);
        }
        *self.of(action) = vec![code];
    }

    /// What a button does.
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
