//! The sickness scale while driving, as a participant sees it: its position and its keys; and the sign that the room is recorded.

use codrive::{
    controls::ControlSource,
    panel::{ParticipantScreen, ScreenPainter, ScreenState, room_sign},
    study::{FmsPrompt, FormInput, ParticipantTexts},
};
use egui::Key;
use egui_kittest::{Harness, kittest::Queryable};

#[derive(Default)]
struct Asked {
    screens: ScreenPainter,
    wheel: bool,
    inputs: Vec<FormInput>,
}

impl Asked {
    fn show(&mut self, ui: &mut egui::Ui) {
        let texts = ParticipantTexts::default();
        let screen = ParticipantScreen::Rating(FmsPrompt { value: 20, left_s: 9.0 });
        let source = if self.wheel { ControlSource::Wheel } else { ControlSource::Keyboard };
        let state = ScreenState { screen, texts: &texts, progress: [3, 13], source, spoken: false };
        self.inputs.extend(self.screens.show(ui, &state));
    }
}

fn asked(size: [f32; 2], wheel: bool) -> Harness<'static, Asked> {
    let mut harness =
        crate::harness(Asked { wheel, ..Asked::default() }, size, 1.0, |ui, asked: &mut Asked| asked.show(ui));
    harness.run();
    harness
}

#[test]
fn the_scale_is_beside_the_road_and_its_keys_do_not_drive() {
    for size in [[900.0, 600.0], [1280.0, 720.0], [1920.0, 1080.0], [3840.0, 2160.0]] {
        let mut harness = asked(size, false);
        let shown = harness.get_by_label("How sick do you feel now? 20").rect();
        // The bonnet begins at two thirds of the height, with road and mirror above it. The dial reaches three fifths of the width.
        assert!(shown.left() > 0.65 * size[0] && shown.right() < size[0], "{shown:?} of {size:?}");
        assert!(shown.top() > 0.67 * size[1] && shown.bottom() < size[1], "{shown:?} of {size:?}");
        for key in [Key::ArrowUp, Key::ArrowDown, Key::ArrowLeft, Key::ArrowRight, Key::Space] {
            harness.key_press(key);
            harness.run();
        }
        let turned = |inputs: &[FormInput]| inputs.iter().any(|input| matches!(input, FormInput::Turn(_)));
        assert!(!turned(&harness.state().inputs), "arrows drive");
        harness.state_mut().inputs.clear();
        for key in [Key::PageUp, Key::Plus, Key::PageDown, Key::Minus, Key::Enter] {
            harness.key_press(key);
            harness.run();
        }
        let [more, less] = [1, -1].map(FormInput::Turn);
        assert_eq!(harness.state().inputs, [more.clone(), more, less.clone(), less, FormInput::Next]);
    }
    crate::screens::save(&mut asked([1280.0, 720.0], true), "rating");
    crate::screens::save(&mut asked([3840.0, 2160.0], false), "rating-television");
}

#[test]
fn a_window_says_in_red_that_the_room_is_recorded_and_only_then() {
    for words in [None, Some("the room is recorded")] {
        let mut harness =
            crate::harness(words, [1280.0, 720.0], 1.0, |ui, words: &mut Option<&str>| room_sign(ui, *words));
        harness.run();
        let is_seen = harness.query_by_label("the room is recorded").is_some();
        let picture = harness.render().expect("a picture");
        let red = picture.pixels().filter(|pixel| pixel[0] > 150 && pixel[0] > 2 * pixel[1]).count();
        assert_eq!((is_seen, red > 60), (words.is_some(), words.is_some()), "{red} red pixels");
    }
}
