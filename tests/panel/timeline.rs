//! The timeline of a replay: its content and its controls.

use crate::experimenter::save;
use codrive::panel::{
    seek_bar::{AdviceSince, SeekBarCommand, SeekBarEvent, SeekBarState, show},
    theme,
};
use egui::accesskit::Role;
use egui_kittest::{Harness, kittest::Queryable};

/// A timeline with the commands that its user gave.
#[derive(Default)]
struct Hand {
    time_s: f64,
    asked: Vec<SeekBarCommand>,
}

#[test]
fn a_timeline_plays_steps_and_seeks_and_says_what_is_proven() {
    let speeds: Vec<[f64; 2]> = (0..=200).map(f64::from).map(|t| [t, 4.0 + (t * 0.1).sin()]).collect();
    let mut harness =
        Harness::builder().with_size([900.0, 300.0]).with_context_setup(theme::apply).wgpu().build_ui_state(
            |ui, hand: &mut Hand| {
                let state = SeekBarState {
                    time_s: hand.time_s,
                    end_s: 200.0,
                    known_s: 120.0,
                    playing: false,
                    speed: 0.5,
                    view: "From above",
                    advice: &[(20.0, Some(2.5)), (90.0, Some(4.3)), (150.0, None)]
                        .map(|(time_s, target_mps)| AdviceSince { time_s, target_mps }),
                    speeds: &speeds,
                    events: &[SeekBarEvent { time_s: 50.0, words: "mark: button".into() }],
                    proof: "proven to 120 s: the same to the bit",
                    differs: false,
                };
                hand.asked.extend(show(ui, &state).0);
            },
            Hand { time_s: 10.0, ..Hand::default() },
        );
    harness.run();
    for (button, command) in [
        ("Play", SeekBarCommand::Toggle),
        ("+1 tick", SeekBarCommand::Tick(1)),
        ("−1 tick", SeekBarCommand::Tick(-1)),
        ("Faster", SeekBarCommand::Speed(true)),
        ("Slower", SeekBarCommand::Speed(false)),
        ("From above", SeekBarCommand::NextView),
    ] {
        harness.get_by_role_and_label(Role::Button, button).click();
        harness.run();
        assert_eq!(std::mem::take(&mut harness.state_mut().asked), [command]);
    }
    for text in ["0.5×", "0:10.0 of 3:20.0", "proven to 120 s: the same to the bit"] {
        harness.get_by_label(text);
    }
    assert!(harness.query_by_label_contains("driving again").is_none());
    harness.state_mut().time_s = 160.0;
    harness.run();
    harness.get_by_label("driving again up to here: 75 %");
    // A click in the middle of the line seeks to the middle of the drive.
    let above = harness.get_by_role_and_label(Role::Button, "Play").rect().top() - 30.0;
    harness.drag_at(egui::pos2(450.0, above));
    harness.run();
    harness.drop_at(egui::pos2(450.0, above));
    harness.run();
    let asked = &harness.state().asked;
    let Some(SeekBarCommand::Seek(time_s)) = asked.first() else { panic!("{asked:?}") };
    assert!((time_s - 100.0).abs() < 1.0, "{time_s}");
    let picture = harness.render().unwrap();
    save(&picture, "timeline");
    // Red, or half red at the edge of a line; amber has three quarters as much green as red.
    let red = |pixel: &image::Rgba<u8>| pixel.0[0] > 110 && f32::from(pixel.0[1]) < 0.6 * f32::from(pixel.0[0]);
    let columns: Vec<u32> = picture.enumerate_pixels().filter(|(.., pixel)| red(pixel)).map(|(x, ..)| x).collect();
    // 200 s are 864 points from 18 on; advice lasts from 20 to 150 s, and the speed line crosses it at times.
    let x = |time_s: f64| 18.0 + time_s / 200.0 * 864.0;
    let ends = [columns.iter().min(), columns.iter().max()].map(|end| f64::from(*end.unwrap()));
    assert!((ends[0] - x(20.0)).abs() < 3.0 && (ends[1] - x(150.0)).abs() < 3.0, "{ends:?}");
    let seen = (ends[0] as u32..ends[1] as u32).filter(|x| columns.contains(x)).count() as f64;
    assert!(seen > 0.8 * (ends[1] - ends[0]), "advice is on {seen} points of the line");
}
