//! Answering screens with wheel, pedals and buttons. In: controls of each frame, pressed buttons. Out: [`FormInput`]s. Angles are those
//! of the steering wheel in rad, positive to the left.

use crate::{
    controls::{ControlSource, Controls},
    input::ButtonAction,
    study::FormInput,
};

/// Turn of the wheel for one place, rad (12 degrees). Counted from the last place reached, so that a trembling hand between two places
/// moves nothing.
const PLACE_RAD: f64 = 0.21;
/// Pedal position that counts as pressed, 0 to 1; the pedal must go below `RELEASED` before it counts again.
const PRESSED: f32 = 0.6;
const RELEASED: f32 = 0.2;
/// Stick deflection that moves one place, as angle of the steering wheel in rad; the stick must return below `STICK_REST_RAD` before it
/// moves another.
const STICK_RAD: f64 = 2.0;
const STICK_REST_RAD: f64 = 0.8;

/// State of wheel, pedals and stick in the last frame.
#[derive(Clone, Debug, Default)]
pub struct WheelNavigation {
    anchor_rad: Option<f64>,
    source: Option<ControlSource>,
    /// True for accelerator and brake that are pressed.
    down: [bool; 2],
    stick: bool,
}

impl WheelNavigation {
    /// Returns the meaning of a button at a screen.
    pub fn pressed(action: ButtonAction) -> Option<FormInput> {
        match action {
            ButtonAction::Answer | ButtonAction::Start => Some(FormInput::Next),
            ButtonAction::Reverse | ButtonAction::Recentre => Some(FormInput::Back),
            ButtonAction::Mark => Some(FormInput::Mark),
            ButtonAction::Abort => Some(FormInput::Stop),
            ButtonAction::Left | ButtonAction::Up => Some(FormInput::Turn(-1)),
            ButtonAction::Right | ButtonAction::Down => Some(FormInput::Turn(1)),
            ButtonAction::Horn | ButtonAction::Handbrake => None,
            ButtonAction::Respond | ButtonAction::Automation | ButtonAction::TimeGap => None,
            ButtonAction::IndicateLeft | ButtonAction::IndicateRight | ButtonAction::MainBeam => None,
        }
    }

    /// Returns the meaning of a button while driving, excluding buttons that control vehicle or view. Up means more here, as the question
    /// asks for a number, not for an option of a list.
    pub fn pressed_driving(action: ButtonAction) -> Option<FormInput> {
        match action {
            ButtonAction::Mark => Some(FormInput::Mark),
            ButtonAction::Abort => Some(FormInput::Stop),
            ButtonAction::Answer => Some(FormInput::Next),
            ButtonAction::Right | ButtonAction::Up => Some(FormInput::Turn(1)),
            ButtonAction::Left | ButtonAction::Down => Some(FormInput::Turn(-1)),
            ButtonAction::Start | ButtonAction::Reverse | ButtonAction::Recentre => None,
            ButtonAction::Horn | ButtonAction::Handbrake => None,
            ButtonAction::Respond | ButtonAction::Automation | ButtonAction::TimeGap => None,
            ButtonAction::IndicateLeft | ButtonAction::IndicateRight | ButtonAction::MainBeam => None,
        }
    }

    /// Converts the controls of a frame to form input. `pedals` is true for devices without an answer button: the accelerator then
    /// answers and the brake goes back.
    pub fn inputs_from(&mut self, controls: &Controls, source: ControlSource, pedals: bool) -> Vec<FormInput> {
        let mut inputs = Vec::new();
        if self.source != Some(source) {
            // A change of device is not a movement, and a pedal that is already down was not pressed now.
            let down = [controls.throttle, controls.brake].map(|way| way > RELEASED);
            *self = Self { source: Some(source), down, ..Self::default() };
        }
        let angle = f64::from(controls.steering_wheel_rad);
        match source {
            ControlSource::Keyboard => return inputs,
            ControlSource::Wheel => {
                let anchor = *self.anchor_rad.get_or_insert(angle);
                let places = ((angle - anchor) / PLACE_RAD).trunc();
                if places != 0.0 {
                    self.anchor_rad = Some(anchor + places * PLACE_RAD);
                    inputs.push(FormInput::Turn(-places as i32));
                }
            }
            ControlSource::Pad => {
                if !self.stick && angle.abs() > STICK_RAD {
                    inputs.push(FormInput::Turn(if angle > 0.0 { -1 } else { 1 }));
                }
                self.stick = angle.abs() > if self.stick { STICK_REST_RAD } else { STICK_RAD };
            }
        }
        if pedals {
            let ways = [controls.throttle, controls.brake];
            for ((down, way), input) in self.down.iter_mut().zip(ways).zip([FormInput::Next, FormInput::Back]) {
                if !*down && way > PRESSED {
                    inputs.push(input);
                }
                *down = way > if *down { RELEASED } else { PRESSED };
            }
        }
        inputs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turned(degrees: f64) -> Controls {
        Controls { steering_wheel_rad: degrees.to_radians() as f32, ..Controls::default() }
    }

    #[test]
    fn a_wheel_moves_place_by_place_and_does_not_flicker_between_two() {
        let mut navigation = WheelNavigation::default();
        let mut moved = |degrees: f64| navigation.inputs_from(&turned(degrees), ControlSource::Wheel, false);
        assert_eq!(moved(40.0), [], "where it stands at first is no movement");
        assert_eq!(moved(40.0 - 13.0), [FormInput::Turn(1)], "to the right is on");
        for _ in 0..20 {
            assert_eq!((moved(40.0 - 11.0), moved(40.0 - 13.5)), (vec![], vec![]), "a trembling hand");
        }
        assert_eq!(moved(40.0 + 0.5), [FormInput::Turn(-1)]);
        assert_eq!(moved(40.0 - 61.0), [FormInput::Turn(5)], "a quick turn skips no place");
        assert_eq!(navigation.inputs_from(&turned(300.0), ControlSource::Keyboard, false), []);
        assert_eq!(
            navigation.inputs_from(&turned(300.0), ControlSource::Wheel, false),
            [],
            "another device is elsewhere"
        );
    }

    #[test]
    fn pedals_answer_once_per_stroke_if_no_button_does() {
        let mut navigation = WheelNavigation::default();
        let mut pressed = |throttle: f32, brake: f32, pedals: bool| {
            navigation.inputs_from(&Controls { throttle, brake, ..Controls::default() }, ControlSource::Wheel, pedals)
        };
        assert_eq!(pressed(0.9, 0.0, true), [], "it was down before");
        assert_eq!((pressed(0.0, 0.0, true), pressed(0.7, 0.0, true)), (vec![], vec![FormInput::Next]));
        assert_eq!((pressed(0.5, 0.0, true), pressed(0.9, 0.0, true)), (vec![], vec![]));
        assert_eq!((pressed(0.0, 0.8, true), pressed(0.9, 0.0, false)), (vec![FormInput::Back], vec![]));
    }

    #[test]
    fn a_stick_moves_one_place_per_push() {
        let mut navigation = WheelNavigation::default();
        let mut pushed = |rad: f32| {
            navigation.inputs_from(
                &Controls { steering_wheel_rad: rad, ..Controls::default() },
                ControlSource::Pad,
                true,
            )
        };
        assert_eq!((pushed(-2.5), pushed(-3.5), pushed(-1.5)), (vec![FormInput::Turn(1)], vec![], vec![]));
        assert_eq!((pushed(0.1), pushed(2.5)), (vec![], vec![FormInput::Turn(-1)]));
    }

    #[test]
    fn buttons_answer_at_a_screen_and_mark_rate_or_ask_to_stop_in_a_drive() {
        let meaning = |of: fn(ButtonAction) -> Option<FormInput>| ButtonAction::ALL.map(|action| (action, of(action)));
        assert_eq!(
            meaning(WheelNavigation::pressed),
            [
                (ButtonAction::Start, Some(FormInput::Next)),
                (ButtonAction::Reverse, Some(FormInput::Back)),
                (ButtonAction::IndicateLeft, None),
                (ButtonAction::IndicateRight, None),
                (ButtonAction::MainBeam, None),
                (ButtonAction::Respond, None),
                (ButtonAction::Automation, None),
                (ButtonAction::TimeGap, None),
                (ButtonAction::Horn, None),
                (ButtonAction::Mark, Some(FormInput::Mark)),
                (ButtonAction::Answer, Some(FormInput::Next)),
                (ButtonAction::Recentre, Some(FormInput::Back)),
                (ButtonAction::Abort, Some(FormInput::Stop)),
                (ButtonAction::Handbrake, None),
            ]
        );
        // In a drive, no button goes to the next or previous stop; the answer button answers the scale in the picture.
        let driving =
            meaning(WheelNavigation::pressed_driving).into_iter().filter_map(|(action, input)| Some((action, input?)));
        assert_eq!(
            driving.collect::<Vec<_>>(),
            [
                (ButtonAction::Mark, FormInput::Mark),
                (ButtonAction::Answer, FormInput::Next),
                (ButtonAction::Abort, FormInput::Stop)
            ]
        );
        // Right is the next option of a list and more on a scale; up is the previous option of a list and more on a scale.
        let dpad = ButtonAction::DPAD.map(|way| (WheelNavigation::pressed(way), WheelNavigation::pressed_driving(way)));
        let [back, on] = [Some(FormInput::Turn(-1)), Some(FormInput::Turn(1))];
        let expected = [(&back, &on), (&on, &back), (&back, &back), (&on, &on)];
        assert_eq!(dpad, expected.map(|(list, scale)| (list.clone(), scale.clone())));
    }
}
