//! Keys of the window, defined once: their actions and the list for F1. In: winit's keys: physical ones, so that driving
//! does not depend on the layout of the keyboard, and the character of a key that is pressed with Ctrl. Out: a
//! [`KeyCommand`] or a driving key.

use crate::{
    controls::{Indicator, TaskButton},
    input::{Devices, DriveKey},
    panel::SCREEN_KEYS,
};
use winit::keyboard::{Key, KeyCode};

/// Command of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyCommand {
    /// Show or hide the list of keys.
    Help,
    /// Show or hide the experimenter's panel.
    Panel,
    /// Show or hide frame times.
    FrameTimes,
    /// Pause or continue the drive.
    Pause,
    /// Advance by one tick while paused.
    Tick,
    /// Advance by one step while paused.
    Step,
    /// Restart the drive from its beginning.
    Restart,
    /// Next view: driver, chase, bird's-eye, mirror.
    NextView,
    /// Show or hide the map of the whole road.
    WholeMap,
    /// Switch between drive and reverse.
    Reverse,
    /// Toggle the left indicator.
    IndicateLeft,
    /// Toggle the right indicator.
    IndicateRight,
    /// Switch the main beam on or off.
    MainBeam,
    /// Respond to the secondary task.
    Respond,
    /// Move the cursor of the secondary task to the left.
    CursorLeft,
    /// Move the cursor of the secondary task to the right.
    CursorRight,
    /// Switch the automation on or off.
    Automation,
    /// Set the automation's time gap to the next setting.
    TimeGap,
    /// Put the ego back on its lane.
    PutBack,
    /// Toggle the lane help.
    LaneHelp,
    /// Toggle full screen of the window.
    FullScreen,
    /// Reload the shaders from disk.
    ReloadShaders,
    /// Mark this moment in the recording.
    Mark,
    /// End the program (Esc, Ctrl+Q).
    Quit,
}

impl KeyCommand {
    /// Returns true for the driver's own commands: the only ones in the driver's window while the experimenter has a
    /// window.
    pub fn is_drivers(self) -> bool {
        matches!(
            self,
            Self::Help
                | Self::Reverse
                | Self::IndicateLeft
                | Self::IndicateRight
                | Self::MainBeam
                | Self::Respond
                | Self::CursorLeft
                | Self::CursorRight
                | Self::Automation
                | Self::TimeGap
                | Self::PutBack
                | Self::FullScreen
        )
    }

    /// Carries out a command for the driver's devices. Returns true if it is one.
    pub fn apply_to(self, devices: &mut Devices) -> bool {
        match self {
            Self::Reverse => devices.keyboard.toggle_reverse(),
            Self::IndicateLeft => devices.indicate(Indicator::Left),
            Self::IndicateRight => devices.indicate(Indicator::Right),
            Self::MainBeam => devices.switch_main_beam(),
            Self::Respond => devices.press_for_task(TaskButton::Respond),
            Self::CursorLeft => devices.press_for_task(TaskButton::Left),
            Self::CursorRight => devices.press_for_task(TaskButton::Right),
            Self::Automation => devices.press_for_automation(),
            Self::TimeGap => devices.press_for_time_gap(),
            _ => return false,
        }
        true
    }

    /// Returns true for commands that help to develop the program.
    fn is_developers(self) -> bool {
        matches!(self, Self::FrameTimes | Self::Tick | Self::Step | Self::ReloadShaders)
    }
}

/// All commands: keys, name of the keys, action. A command without a name is in the row of another one.
const COMMANDS: [(&[KeyCode], KeyCommand, &str, &str); 24] = [
    (&[KeyCode::F1], KeyCommand::Help, "F1", "this list"),
    (&[KeyCode::F2, KeyCode::Tab], KeyCommand::Panel, "F2, Tab", "experimenter's panel"),
    (&[KeyCode::F3], KeyCommand::FrameTimes, "F3", "frame times"),
    (&[KeyCode::Space], KeyCommand::Pause, "Space, Ctrl+P", "pause, continue"),
    (&[KeyCode::KeyN], KeyCommand::Tick, "N; M", "one tick; one step, while paused"),
    (&[KeyCode::KeyM], KeyCommand::Step, "", ""),
    (&[KeyCode::Backspace], KeyCommand::Restart, "Backspace", "begin again"),
    (&[KeyCode::KeyV], KeyCommand::NextView, "V; G", "next view; whole map on, off"),
    (&[KeyCode::KeyG], KeyCommand::WholeMap, "", ""),
    (&[KeyCode::KeyR], KeyCommand::Reverse, "R; C; T", "drive, reverse (standing); automation on, off; its time gap"),
    (&[KeyCode::KeyC], KeyCommand::Automation, "", ""),
    (&[KeyCode::KeyT], KeyCommand::TimeGap, "", ""),
    (&[KeyCode::KeyQ], KeyCommand::IndicateLeft, "Q; E", "indicator left; right, on or off"),
    (&[KeyCode::KeyE], KeyCommand::IndicateRight, "", ""),
    (&[KeyCode::KeyF], KeyCommand::MainBeam, "F", "main beam on, off"),
    (&[KeyCode::KeyI], KeyCommand::Respond, "I; U; O", "secondary task: respond; left; right"),
    (&[KeyCode::KeyU], KeyCommand::CursorLeft, "", ""),
    (&[KeyCode::KeyO], KeyCommand::CursorRight, "", ""),
    (&[KeyCode::KeyB], KeyCommand::PutBack, "B", "back onto the lane"),
    (&[KeyCode::KeyL], KeyCommand::LaneHelp, "L", "lane help on, off"),
    (&[KeyCode::F11], KeyCommand::FullScreen, "F11", "full screen"),
    (&[KeyCode::F5], KeyCommand::ReloadShaders, "F5", "load the shaders again"),
    (&[], KeyCommand::Mark, "Ctrl+M", "mark this moment"),
    (&[KeyCode::Escape], KeyCommand::Quit, "Esc, Ctrl+Q", "end"),
];

/// Commands with Ctrl, the same in every window of the program: character, and its key on a keyboard without Latin letters.
const WITH_CONTROL: [(&str, KeyCode, KeyCommand); 3] = [
    ("p", KeyCode::KeyP, KeyCommand::Pause),
    ("m", KeyCode::KeyM, KeyCommand::Mark),
    ("q", KeyCode::KeyQ, KeyCommand::Quit),
];

const DRIVING: [(&[KeyCode], DriveKey, &str, &str); 5] = [
    (&[KeyCode::ArrowUp, KeyCode::KeyW], DriveKey::Throttle, "Up, W", "accelerate"),
    (&[KeyCode::ArrowDown, KeyCode::KeyS], DriveKey::Brake, "Down, S", "brake; twice at a standstill: reverse"),
    (&[KeyCode::ArrowLeft, KeyCode::KeyA], DriveKey::Left, "Left, A", "steer left"),
    (&[KeyCode::ArrowRight, KeyCode::KeyD], DriveKey::Right, "Right, D", "steer right"),
    (&[KeyCode::KeyH], DriveKey::Horn, "H", "horn"),
];

/// Returns the command of a key, if it has one.
pub fn command(key: KeyCode) -> Option<KeyCommand> {
    COMMANDS.iter().find(|row| row.0.contains(&key)).map(|row| row.1)
}

/// Returns the command of a key with Ctrl, if it has one: by its character, as on an AZERTY keyboard Q and M are elsewhere;
/// by its place if the character is no Latin letter, as on a Greek keyboard.
pub fn with_control(character: &Key, place: KeyCode) -> Option<KeyCommand> {
    let row = match character {
        Key::Character(text) if text.is_ascii() => WITH_CONTROL.iter().find(|row| text.eq_ignore_ascii_case(row.0)),
        _ => WITH_CONTROL.iter().find(|row| row.1 == place),
    };
    row.map(|row| row.2)
}

/// Returns the driving key, if it is one.
pub fn driving(key: KeyCode) -> Option<DriveKey> {
    DRIVING.iter().find(|row| row.0.contains(&key)).map(|row| row.1)
}

/// Returns the complete list for F1: key and action, for a window with the experimenter's panel.
pub fn list() -> Vec<(&'static str, &'static str)> {
    list_of(|_| true)
}

/// Returns the list for F1 in the window of a driver without an experimenter: no keys of developers.
pub fn list_of_free_driver() -> Vec<(&'static str, &'static str)> {
    list_of(|command| !command.is_developers())
}

/// Returns the list for F1 in a driver's window beside an experimenter's.
pub fn list_of_driver() -> Vec<(&'static str, &'static str)> {
    list_of(KeyCommand::is_drivers)
}

/// Returns the list for F1 in a participant's window: screens and drive.
pub fn list_of_participant() -> Vec<(&'static str, &'static str)> {
    SCREEN_KEYS.into_iter().chain(list_of_driver()).collect()
}

fn list_of(is_listed: fn(KeyCommand) -> bool) -> Vec<(&'static str, &'static str)> {
    let commands = COMMANDS.iter().filter(|row| is_listed(row.1) && !row.2.is_empty()).map(|row| (row.2, row.3));
    DRIVING.iter().map(|row| (row.2, row.3)).chain(commands).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beside_an_experimenter_the_driver_has_only_their_own_commands() {
        let drivers: Vec<&str> = COMMANDS.iter().filter(|row| row.1.is_drivers()).map(|row| row.2).collect();
        assert_eq!(drivers, ["F1", "R; C; T", "", "", "Q; E", "", "F", "I; U; O", "", "", "B", "F11"]);
        let listed: Vec<&str> = list_of_driver().into_iter().map(|(key, _)| key).collect();
        let expected =
            ["Up, W", "Down, S", "Left, A", "Right, D", "H", "F1", "R; C; T", "Q; E", "F", "I; U; O", "B", "F11"];
        assert_eq!(listed, expected);
    }

    #[test]
    fn keys_act_as_listed() {
        use KeyCode as K;
        let commands = [K::Tab, K::F2, K::Escape, K::Space].map(command);
        assert_eq!(commands, [KeyCommand::Panel, KeyCommand::Panel, KeyCommand::Quit, KeyCommand::Pause].map(Some));
        let driving = [K::ArrowUp, K::KeyS, K::KeyA, K::ArrowRight, K::KeyH].map(driving);
        use DriveKey as D;
        assert_eq!(driving, [D::Throttle, D::Brake, D::Left, D::Right, D::Horn].map(Some));
        assert_eq!((command(K::ArrowUp), super::driving(K::Escape), command(K::KeyX)), (None, None, None));
        let indicate = [K::KeyQ, K::KeyE].map(command);
        assert_eq!(indicate, [Some(KeyCommand::IndicateLeft), Some(KeyCommand::IndicateRight)]);
        // Without a character the place counts.
        let by_place = |place| with_control(&Key::Unidentified(winit::keyboard::NativeKey::Unidentified), place);
        let control = [K::KeyQ, K::KeyP, K::KeyM, K::KeyR, K::Escape].map(by_place);
        assert_eq!(control, [Some(KeyCommand::Quit), Some(KeyCommand::Pause), Some(KeyCommand::Mark), None, None]);
        let list = list();
        assert_eq!(list.len(), 22);
        assert!(list.contains(&("Up, W", "accelerate")) && list.contains(&("Esc, Ctrl+Q", "end")));
    }

    #[test]
    fn keys_with_ctrl_act_by_their_character() {
        let pressed = |text: &str, place| with_control(&Key::Character(text.into()), place);
        // On AZERTY the key of Q types A and the key of A types Q; M is right of L, and its place types a comma.
        assert_eq!(pressed("q", KeyCode::KeyA), Some(KeyCommand::Quit));
        assert_eq!(pressed("a", KeyCode::KeyQ), None);
        assert_eq!(pressed("m", KeyCode::Semicolon), Some(KeyCommand::Mark));
        assert_eq!(pressed(",", KeyCode::KeyM), None);
        assert_eq!(pressed("Q", KeyCode::KeyQ), Some(KeyCommand::Quit), "with caps lock");
        assert_eq!(pressed("π", KeyCode::KeyP), Some(KeyCommand::Pause), "a Greek keyboard");
    }

    #[test]
    fn keys_of_developers_are_listed_with_the_panel_alone() {
        for participants in [list_of_participant(), list_of_driver(), list_of_free_driver()] {
            assert!(participants.iter().all(|(key, _)| !["F3", "F5", "N; M"].contains(key)), "{participants:?}");
        }
        let only_panel: Vec<_> = list().into_iter().filter(|row| !list_of_free_driver().contains(row)).collect();
        assert_eq!(only_panel.into_iter().map(|(key, _)| key).collect::<Vec<_>>(), ["F3", "N; M", "F5"]);
    }

    #[test]
    fn the_list_of_keys_fits_every_window() {
        // Window sizes of software rendering, a laptop, a television.
        for size in [[640.0, 360.0], [1280.0, 720.0], [1920.0, 1080.0]] {
            let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, size.into());
            let ctx = egui::Context::default();
            crate::panel::theme::apply(&ctx);
            for _ in 0..3 {
                let input = egui::RawInput { screen_rect: Some(screen), ..Default::default() };
                ctx.run_ui(input, |ui| crate::panel::key_list(ui.ctx(), &list())).textures_delta.clear();
            }
            let shown = ctx.memory(|memory| memory.area_rect(egui::Id::unique("keys"))).unwrap();
            assert!(screen.contains_rect(shown) && shown.height() > 150.0, "{shown:?} of {size:?}");
        }
    }

    #[test]
    fn no_key_has_two_meanings() {
        let all: Vec<KeyCode> =
            COMMANDS.iter().flat_map(|r| r.0).chain(DRIVING.iter().flat_map(|r| r.0)).copied().collect();
        for (i, key) in all.iter().enumerate() {
            assert!(!all[..i].contains(key), "{key:?}");
        }
    }
}
