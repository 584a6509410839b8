//! The sickness scale while driving, as a participant sees it: where it stands, and which keys act.

use codrive::{
    panel::{ParticipantScreen, ScreenPainter, ScreenState},
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
        let state = ScreenState { screen, texts: &texts, progress: [3, 13], wheel: self.wheel };
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
fn the_scale_stands_beside_the_road_and_has_keys_that_do_not_drive() {
    for size in [[900.0, 600.0], [1280.0, 720.0], [1920.0, 1080.0]] {
        let mut harness = asked(size, false);
        let shown = harness.get_by_label("How sick do you feel now? 20").rect();
        // The road ahead is in the middle three fifths of the picture; the mirror hangs in the upper quarter, the dial stands in the
        // lower one.
        assert!(shown.left() >= 0.0 && shown.right() < 0.27 * size[0], "{shown:?} of {size:?}");
        assert!(shown.top() > 0.25 * size[1] && shown.bottom() < 0.75 * size[1], "{shown:?} of {size:?}");
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
}
