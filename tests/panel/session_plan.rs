//! The experimenter's part of a session: its commands by keys and mouse, and the rows of the plan.

use crate::screens::{keys, save, type_in};
use codrive::panel::{
    ItemState, SessionCommand, SessionItem, SessionPanel, SessionPanelState, SessionPhase, StopRequest, theme,
};
use egui::{Key, Modifiers, accesskit::Role};
use egui_kittest::{
    Harness,
    kittest::{NodeT, Queryable},
};

/// The experimenter's part with the state of a session.
struct Lead {
    panel: SessionPanel,
    items: Vec<SessionItem>,
    phase: SessionPhase,
    asked: Option<StopRequest>,
    error: Option<&'static str>,
    commands: Vec<SessionCommand>,
}

impl Lead {
    fn new(phase: SessionPhase) -> Self {
        let item = |name: &str, what: &str, state: ItemState, earlier: &str| SessionItem {
            name: name.into(),
            what: what.into(),
            condition: name.strip_prefix("trial-1-").map(str::to_owned),
            state,
            earlier: earlier.into(),
        };
        let items = vec![
            item("welcome", "a page to read", ItemState::Done, ""),
            item("ssq-before", "questions: ssq", ItemState::Skipped, "broken off"),
            item("familiarisation", "420 s on practice, 12 cars", ItemState::Done, "cut"),
            item("trial-1-narrow", "300 s on ring-250, 22 cars, policy ring-250-speed", ItemState::Now, ""),
            item("trial-rest-1", "rest, 60 s", ItemState::Ahead, ""),
        ];
        Self { panel: SessionPanel::default(), items, phase, asked: None, error: None, commands: Vec::new() }
    }

    fn show(&mut self, ui: &mut egui::Ui) {
        let state = SessionPanelState {
            title: "Co-operative congestion mitigation",
            code: "P03",
            items: &self.items,
            to_come_s: 905.0,
            sees: "drive trial-1-narrow",
            left_s: Some(191.4),
            phase: self.phase,
            asked: self.asked,
            error: self.error,
            work: None,
        };
        let made = self.panel.show(ui, &state);
        self.commands.extend(made);
    }
}

fn lead(lead: Lead, size: [f32; 2]) -> Harness<'static, Lead> {
    let mut harness = Harness::builder()
        .with_size(egui::Vec2::from(size))
        .with_context_setup(theme::apply)
        .wgpu()
        .build_ui_state(|ui, lead: &mut Lead| egui::CentralPanel::default().show(ui, |ui| lead.show(ui)).inner, lead);
    harness.run();
    harness
}

fn ctrl(harness: &mut Harness<'static, Lead>, key: Key) -> Vec<SessionCommand> {
    harness.key_press_modifiers(Modifiers::COMMAND, key);
    harness.run();
    std::mem::take(&mut harness.state_mut().commands)
}

fn enter(harness: &mut Harness<'static, Lead>) -> Vec<SessionCommand> {
    keys(harness, &[Key::Enter]);
    std::mem::take(&mut harness.state_mut().commands)
}

#[test]
fn every_command_is_given_by_keys_alone_with_its_reason() {
    let mut harness = lead(Lead::new(SessionPhase::Driving), [420.0, 700.0]);
    assert_eq!(ctrl(&mut harness, Key::P), [SessionCommand::Pause]);
    assert_eq!(ctrl(&mut harness, Key::M), [SessionCommand::Mark(String::new())]);
    assert_eq!(ctrl(&mut harness, Key::G), [], "a drive that runs needs no Go");
    for (key, words, expected) in [
        (Key::N, "coughs", SessionCommand::Note("coughs".into())),
        (Key::S, "no time", SessionCommand::Skip("no time".into())),
        (Key::E, "late", SessionCommand::Extend { seconds: 60.0, reason: "late".into() }),
        (Key::B, "phone", SessionCommand::Abort("phone".into())),
        (Key::R, "fell", SessionCommand::Repeat { item: "familiarisation".into(), reason: "fell".into() }),
    ] {
        assert_eq!(ctrl(&mut harness, key), []);
        assert_eq!(enter(&mut harness), [], "it wants a reason");
        harness.get_by_label("Please write a few words.");
        type_in(&mut harness, words);
        assert_eq!(enter(&mut harness), [expected]);
        assert!(harness.query_by_label("Cancel").is_none(), "done is done");
    }
    // Sickness has its reason already but asks for confirmation; Esc cancels it. The key itself holds everything.
    assert_eq!(ctrl(&mut harness, Key::I), [SessionCommand::Hold]);
    harness.get_by_label("End the session");
    keys(&mut harness, &[Key::Escape]);
    assert!(harness.query_by_label("End the session").is_none() && harness.state().commands.is_empty());
    assert_eq!(ctrl(&mut harness, Key::I), [SessionCommand::Hold]);
    assert_eq!(enter(&mut harness), [SessionCommand::Stop("sickness".into())]);
    for (key, stop) in
        [(Key::T, SessionCommand::StopTechnically("smoke".into())), (Key::D, SessionCommand::Exclude("smoke".into()))]
    {
        assert_eq!(ctrl(&mut harness, key), [SessionCommand::Hold]);
        type_in(&mut harness, "smoke");
        assert_eq!(enter(&mut harness), [stop]);
    }
    // The commands ask which item, and for how long.
    ctrl(&mut harness, Key::R);
    keys(&mut harness, &[Key::ArrowUp, Key::ArrowUp]);
    type_in(&mut harness, "x");
    assert_eq!(enter(&mut harness), [SessionCommand::Repeat { item: "welcome".into(), reason: "x".into() }]);
    ctrl(&mut harness, Key::E);
    assert_eq!(ctrl(&mut harness, Key::ArrowUp), []);
    type_in(&mut harness, "y");
    assert_eq!(enter(&mut harness), [SessionCommand::Extend { seconds: 70.0, reason: "y".into() }]);
}

#[test]
fn words_that_were_typed_outlive_another_command_and_the_end() {
    let mut harness = lead(Lead::new(SessionPhase::Driving), [420.0, 700.0]);
    ctrl(&mut harness, Key::N);
    type_in(&mut harness, "looks pale");
    assert_eq!(ctrl(&mut harness, Key::N), [], "the same question stays open");
    let draft = |words: &str| SessionCommand::Draft(words.into());
    assert_eq!(ctrl(&mut harness, Key::I), [SessionCommand::Hold, draft("looks pale")]);
    assert_eq!(harness.state_mut().panel.take_words(), None, "nothing was typed for the stop");
    ctrl(&mut harness, Key::E);
    type_in(&mut harness, "traffic");
    harness.state_mut().phase = SessionPhase::Over;
    harness.run();
    assert_eq!(std::mem::take(&mut harness.state_mut().commands), [draft("Extend: traffic")], "the drive is over");
    // At the end of the program the words are taken, and the next opening has them in the field of a note.
    ctrl(&mut harness, Key::N);
    type_in(&mut harness, "tired");
    let words = harness.state_mut().panel.take_words().unwrap();
    let mut again = lead(Lead::new(SessionPhase::Experimenter), [420.0, 700.0]);
    again.state_mut().panel.restore(&words);
    again.run();
    assert_eq!(enter(&mut again), [SessionCommand::Note("tired".into())]);
    // Esc throws words away.
    ctrl(&mut again, Key::N);
    type_in(&mut again, "no");
    keys(&mut again, &[Key::Escape]);
    assert_eq!((again.state_mut().panel.take_words(), again.state().commands.len()), (None, 0));
}

#[test]
fn buttons_act_only_when_possible_and_ending_a_drive_asks_first() {
    let mut harness = lead(Lead::new(SessionPhase::Held), [420.0, 700.0]);
    let press = |harness: &mut Harness<'static, Lead>, label: &str| {
        harness.get_by_role_and_label(Role::Button, label).click();
        harness.run();
        std::mem::take(&mut harness.state_mut().commands)
    };
    assert_eq!(press(&mut harness, "Go Ctrl+G"), [SessionCommand::Go]);
    assert_eq!(press(&mut harness, "Resume Ctrl+P"), [SessionCommand::Resume]);
    assert_eq!(press(&mut harness, "Break off Ctrl+B"), []);
    type_in(&mut harness, "too fast");
    assert_eq!(press(&mut harness, "Break it off"), [SessionCommand::Abort("too fast".into())]);
    harness.get_by_label("3:12");
    harness.get_by_label("before: broken off");
    harness.get_by_label("Plan: 3 of 5 done; about 16 min left");
    harness.get_by_label("300 s on ring-250, 22 cars, policy ring-250-speed");
    for (name, word) in [("welcome", "done"), ("trial-1-narrow", "now"), ("ssq-before", "skipped")] {
        let line = harness.get_by_label(name).rect().center().y;
        assert!(harness.get_all_by_label(word).any(|node| (node.rect().center().y - line).abs() < 4.0), "{name}");
    }
    // The question disappears when its drive is over.
    press(&mut harness, "Break off Ctrl+B");
    harness.state_mut().phase = SessionPhase::Over;
    harness.run();
    assert!(harness.query_by_label("Break it off").is_none());
    for label in
        ["Go Ctrl+G", "Skip Ctrl+S", "Break off Ctrl+B", "Sickness stop Ctrl+I", "Repeat Ctrl+R", "Extend Ctrl+E"]
    {
        assert_eq!(press(&mut harness, label), [], "{label}");
    }
    assert!(harness.query_by_label("Cancel").is_none());
    harness.state_mut().error = Some("the disk is full");
    harness.state_mut().asked = Some(StopRequest::Participant);
    harness.run();
    harness.get_by_label("the disk is full");
    harness.get_by_label_contains("The participant asks to stop:");
}

/// The plan has a quarter of a window of 1280 or 1920 pixels, and the whole width of one of 1024 pixels, which has pages.
#[test]
fn rows_of_the_plan_do_not_overlap_at_any_width() {
    let what = "300 s on ring-250, 22 cars, policy ring-250-speed, range 2 mph, with questions while driving";
    let item = |name: &str, state: ItemState, earlier: &str| SessionItem {
        name: name.into(),
        what: what.into(),
        condition: None,
        state,
        earlier: earlier.into(),
    };
    let items = [
        item("trial-12-narrow+dense+hesitant", ItemState::Again, "broken off"),
        item("trial-13-sham+usual+hesitant", ItemState::Broken, "broken off, cut, broken off"),
        item("rest", ItemState::Skipped, "broken off"),
        item("trial-14-wide+usual+brisk", ItemState::Ahead, ""),
    ];
    for width in [328.0, 360.0, 480.0, 1008.0] {
        let lead = self::lead(Lead { items: items.to_vec(), ..Lead::new(SessionPhase::Driving) }, [width, 700.0]);
        let rects: Vec<(String, egui::Rect)> = lead
            .root()
            .children_recursive()
            .filter(|node| node.accesskit_node().role() == Role::Label)
            .filter_map(|node| Some((node.accesskit_node().value()?.to_owned(), node.rect())))
            .collect();
        assert_eq!(rects.iter().filter(|(text, _)| text.starts_with("before: ")).count(), 3, "{rects:?}");
        for (i, (text, rect)) in rects.iter().enumerate() {
            assert!(rect.left() >= 0.0 && rect.right() <= width, "{text:?} at {rect:?} of {width}");
            for (other_text, other) in &rects[..i] {
                let both = rect.intersect(*other);
                assert!(
                    both.width() < 1.0 || both.height() < 1.0,
                    "{text:?} at {rect:?} on {other_text:?} at {other:?}"
                );
            }
        }
    }
}

#[test]
fn the_experimenters_part_has_its_pictures() {
    let mut asked = Lead::new(SessionPhase::Held);
    (asked.asked, asked.error) = (Some(StopRequest::Experimenter), Some("there is no drive or rest to extend"));
    save(&mut lead(asked, [360.0, 560.0]), "lead-asked");
    let mut repeat = lead(Lead::new(SessionPhase::Experimenter), [360.0, 560.0]);
    ctrl(&mut repeat, Key::R);
    save(&mut repeat, "lead-repeat");
    let mut stop = lead(Lead::new(SessionPhase::Driving), [360.0, 560.0]);
    ctrl(&mut stop, Key::I);
    save(&mut stop, "lead-stop");
}
