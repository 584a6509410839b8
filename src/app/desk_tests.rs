//! The desk over a drive without a window: keys, words on the picture, what the experimenter asks for.

use super::*;
use crate::{
    input::{Devices, Rig},
    record::{Reader, Table},
    render::Gpu,
};

fn scenario() -> Scenario {
    let usual = Scenario { traffic: "native".into(), vehicles: 6, warm_up_s: 0.0, ..Scenario::default() };
    Scenario { trees: 0, duration_s: 0.5, policy: "none".into(), ..usual }
}

fn sit(attended: bool) -> (Show, Desk) {
    let devices = Devices::with_rig(Rig::fed_by(std::sync::mpsc::channel().1));
    let show = Show::new(&scenario(), Pace::Paused, devices).unwrap();
    let desk = Desk::new(&show, false, attended);
    (show, desk)
}

/// Ticks that a frame of 30 ms brings.
fn frame(show: &mut Show, desk: &mut Desk) -> u64 {
    let before = show.drive.world.snapshot().tick.0;
    show.advance(Duration::from_millis(30), |world| desk.watch(world)).unwrap();
    show.drive.world.snapshot().tick.0 - before
}

/// All words that egui draws of this.
fn words(draw: impl FnMut(&mut Ui)) -> String {
    words_of(&egui::Context::default(), 1, draw)
}

/// All words of the last of so many passes.
fn words_of(ctx: &egui::Context, passes: usize, mut draw: impl FnMut(&mut Ui)) -> String {
    fn of(shape: &egui::Shape, out: &mut String) {
        match shape {
            egui::Shape::Text(text) => {
                out.push_str(text.galley.text());
                out.push('\n');
            }
            egui::Shape::Vec(shapes) => shapes.iter().for_each(|shape| of(shape, out)),
            _ => {}
        }
    }
    let screen_rect = Some(egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(1400.0, 900.0)));
    let mut out = String::new();
    for _ in 0..passes {
        let mut output = ctx.run_ui(egui::RawInput { screen_rect, ..Default::default() }, &mut draw);
        // There is no device that would take them.
        output.textures_delta.clear();
        out.clear();
        output.shapes.iter().for_each(|clipped| of(&clipped.shape, &mut out));
    }
    out
}

#[test]
fn keys_pause_go_on_by_a_tick_or_a_step_and_change_the_view() {
    let (mut show, mut desk) = sit(false);
    assert_eq!(frame(&mut show, &mut desk), 0);
    desk.key(Command::Tick, &mut show);
    assert_eq!(frame(&mut show, &mut desk), 1);
    desk.key(Command::Step, &mut show);
    assert_eq!(frame(&mut show, &mut desk), 10);
    desk.key(Command::Pause, &mut show);
    // While time runs a single step changes nothing.
    desk.key(Command::Step, &mut show);
    assert_eq!((frame(&mut show, &mut desk), show.drive.clock.pace()), (3, Pace::RealTime));
    desk.key(Command::Pause, &mut show);
    assert_eq!(frame(&mut show, &mut desk), 0);

    use crate::scene::ViewKind::{Birdseye, Chase, Driver, Mirror};
    for view in [Chase, Birdseye, Mirror, Driver] {
        desk.key(Command::NextView, &mut show);
        assert_eq!(show.kind, view);
    }
    let was = show.lane_help();
    desk.key(Command::LaneHelp, &mut show);
    let said = format!("lane help is {}", if was { "off" } else { "on" });
    assert_eq!((show.lane_help(), desk.message.clone()), (!was, Some(said)));
    desk.key(Command::Help, &mut show);
    assert_eq!((desk.message.clone(), desk.panel.help_open), (None, true), "the next key takes the message away");
    desk.key(Command::Panel, &mut show);
    assert!(desk.panel.open);
}

#[test]
fn words_on_the_picture_say_what_the_drive_is_at_and_to_whom() {
    for attended in [false, true] {
        let (mut show, mut desk) = sit(attended);
        let says = |desk: &Desk, show: &Show| desk.notes(show, None).middle;
        let [starts, waits, over] = if attended {
            ["Please wait.", "Please wait.", "The drive is over."]
        } else {
            [START, "Paused. Space continues.", "The drive is over. Backspace starts again."]
        };
        assert_eq!((phase(&show), says(&desk, &show)), (Phase::Ready, starts));
        assert!(words(|ui| drop(desk.show(ui, &show, None))).contains(starts), "and it is drawn");
        desk.obey(PanelCommand::Start, &mut show);
        frame(&mut show, &mut desk);
        assert_eq!((phase(&show), says(&desk, &show)), (Phase::Running, ""));
        desk.obey(PanelCommand::Pause, &mut show);
        assert_eq!((phase(&show), says(&desk, &show)), (Phase::Paused, waits));
        desk.obey(PanelCommand::SingleStep(Advance::Step), &mut show);
        assert_eq!(frame(&mut show, &mut desk), 10);
        show.drive.clock.set_pace(Pace::FullSpeed);
        while show.drive.world.ended().is_none() {
            frame(&mut show, &mut desk);
        }
        assert_eq!((phase(&show), says(&desk, &show)), (Phase::Ended, over));
        let summary = words(|ui| drop(desk.show(ui, &show, None)));
        assert_eq!(summary.contains("Mean speed of all cars: "), !attended, "{summary}");
    }
}

#[test]
fn a_message_is_the_drivers_only_where_nobody_attends_and_times_are_shown_on_demand() {
    let (mut show, mut desk) = sit(false);
    desk.say("the wheel is back".into(), &show);
    assert_eq!(desk.notes(&show, None).corner, ["the wheel is back"]);
    desk.key(Command::FrameTimes, &mut show);
    let times = PassTimes { shadow_ms: 1.0, main_ms: 2.5, mirror_ms: 0.25, develop_ms: 0.125 };
    let corner = desk.notes(&show, Some(times)).corner.join("\n");
    for part in ["shadow 1.00, main 2.50, mirror 0.25, develop 0.12 ms", "dropped 0.00 s in 0 stalls", "keyboard"] {
        assert!(corner.contains(part), "{corner}");
    }
    // A second that came late: 0.25 s of it are driven at most, the rest is said.
    show.drive.clock.set_pace(Pace::RealTime);
    let due = show.advance(Duration::from_secs(1), |_| ()).unwrap();
    let dropped = format!("dropped {:.2} s in 1 stall", due.dropped.as_secs_f64());
    assert!(due.ticks < 100 && due.dropped > Duration::ZERO);
    assert!(desk.notes(&show, None).corner.contains(&dropped), "{:?}", desk.notes(&show, None).corner);

    let (show, mut desk) = sit(true);
    desk.say("the wheel is back".into(), &show);
    assert!(desk.notes(&show, None).corner.is_empty());
    assert!(words(|ui| drop(desk.experimenter(ui, &show, None))).contains("the wheel is back"));
}

/// The end of a restart, which frames wait for. True if there is a new stage.
fn begun(show: &mut Show, desk: &mut Desk) -> bool {
    desk.restarted(Duration::from_secs(60), show).or_else(|| desk.restarted(Duration::from_secs(60), show)).unwrap()
}

/// A SUMO that takes connections and says nothing, and the scenario of a drive on it.
fn silent() -> (std::net::TcpListener, Scenario) {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let traffic = listener.local_addr().unwrap().to_string();
    (listener, Scenario { traffic, traffic_timeout_s: 600.0, ..scenario() })
}

#[test]
fn while_a_drive_is_being_started_time_stands_and_the_window_says_so() {
    let (_listener, waits) = silent();
    for attended in [false, true] {
        let (mut show, mut desk) = sit(attended);
        desk.obey(PanelCommand::Start, &mut show);
        assert!(frame(&mut show, &mut desk) > 0);
        let tick = show.drive.world.snapshot().tick;
        desk.obey(PanelCommand::Restart(Box::new(waits.clone())), &mut show);
        assert_eq!(show.starting(), Some(&waits));
        assert!(desk.restarted(Duration::from_millis(10), &mut show).is_none());
        assert_eq!(phase(&show), Phase::Starting);
        let says = desk.notes(&show, None).middle;
        assert_eq!(says, if attended { "Please wait." } else { "The drive is being started. Esc ends." });
        // Nothing that is pressed meanwhile moves the drive that is over.
        desk.obey(PanelCommand::SingleStep(Advance::Step), &mut show);
        for _ in 0..2 {
            desk.key(Command::Pause, &mut show);
            desk.key(Command::Tick, &mut show);
            assert_eq!(frame(&mut show, &mut desk), 0);
        }
        assert_eq!(show.drive.world.snapshot().tick, tick);
        // Another wish takes the place of the first, which lets go at once; the pace is that of before.
        desk.obey(PanelCommand::Restart(Box::new(scenario())), &mut show);
        assert!(!begun(&mut show, &mut desk));
        assert_eq!((phase(&show), show.drive.world.scenario().traffic.as_str()), (Phase::Running, "native"));
        assert!(frame(&mut show, &mut desk) > 0);
    }
}

#[test]
fn a_drive_that_cannot_even_begin_again_stands_and_another_try_helps() {
    let folder = tempfile::tempdir().unwrap();
    let (there, away) = (folder.path().join("ring"), folder.path().join("away"));
    std::fs::create_dir(&there).unwrap();
    for file in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/maps/ring-250")).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), there.join(file.file_name())).unwrap();
    }
    let own = Scenario { map: there.to_str().unwrap().to_owned(), ..scenario() };
    let (mut show, mut desk) = sit(false);
    desk.restart(&own, &mut show);
    assert!(begun(&mut show, &mut desk), "another map is another stage");
    desk.obey(PanelCommand::Start, &mut show);
    assert!(frame(&mut show, &mut desk) > 0);
    std::fs::rename(&there, &away).unwrap();
    desk.restart(&own, &mut show);
    assert!(!begun(&mut show, &mut desk));
    assert_eq!((phase(&show), frame(&mut show, &mut desk)), (Phase::Ended, 0));
    let notes = desk.notes(&show, None);
    assert_eq!(notes.middle, "The drive could not start. Backspace tries again.");
    assert!(notes.corner.join("\n").contains(there.to_str().unwrap()), "{:?}", notes.corner);
    std::fs::rename(&away, &there).unwrap();
    desk.restart(&own, &mut show);
    begun(&mut show, &mut desk);
    assert_eq!((phase(&show), desk.notes(&show, None).corner.len()), (Phase::Running, 0));
    assert!(frame(&mut show, &mut desk) > 0);
}

#[test]
fn a_drive_that_cannot_start_leaves_the_one_before_and_says_why() {
    let (mut show, mut desk) = sit(false);
    desk.obey(PanelCommand::SingleStep(Advance::Step), &mut show);
    frame(&mut show, &mut desk);
    let full = Scenario { vehicles: 400, ..scenario() };
    desk.obey(PanelCommand::Restart(Box::new(full)), &mut show);
    assert!(!begun(&mut show, &mut desk));
    let world = &show.drive.world;
    assert_eq!((world.snapshot().tick.0, world.scenario().vehicles, phase(&show)), (0, 6, Phase::Ready));
    let corner = desk.notes(&show, None).corner.join("\n");
    assert!(corner.contains("400") && corner.contains("do not fit"), "{corner}");
    // A good one takes the message away. Another seed is another stage, as many cars more are not.
    let more = Scenario { vehicles: 8, ..scenario() };
    desk.obey(PanelCommand::Restart(Box::new(more.clone())), &mut show);
    assert!(!begun(&mut show, &mut desk));
    assert!(desk.notes(&show, None).corner.is_empty() && show.drive.world.scenario().vehicles == 8);
    desk.obey(PanelCommand::Restart(Box::new(Scenario { seed: 9, ..more })), &mut show);
    assert!(begun(&mut show, &mut desk));
}

#[test]
fn marks_and_notes_of_the_experimenter_stand_in_the_recording_at_their_tick() {
    let gpu = Gpu::shared().expect("a graphics adapter is needed");
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("drive");
    let (mut show, mut desk) = sit(true);
    let both = |show: &Show, desk: &mut Desk| {
        [words(|ui| drop(desk.experimenter(ui, show, None))), words(|ui| drop(desk.show(ui, show, None)))]
    };
    assert!(both(&show, &mut desk).iter().all(|seen| seen.contains("not recorded") && !seen.contains("REC")));
    show.record(&recording, gpu).unwrap();
    assert!(both(&show, &mut desk).iter().all(|seen| seen.contains("REC drive") && !seen.contains("not recorded")));
    for (ticks, command) in
        [(1, ExperimenterCommand::Mark(3)), (10, ExperimenterCommand::Note("looks at the phone".into()))]
    {
        show.drive.clock.single_step(ticks);
        frame(&mut show, &mut desk);
        desk.heed(command, &mut show);
    }
    desk.heed(ExperimenterCommand::Drive(PanelCommand::Start), &mut show);
    assert_eq!(show.drive.clock.pace(), Pace::RealTime);
    show.finish_recording().unwrap();
    let events = Reader::parquet(&Table::Events.parquet(&recording)).unwrap();
    let rows: Vec<(u64, String, String)> = events
        .wholes("tick")
        .into_iter()
        .zip(events.words("event").into_iter().zip(events.words("detail")))
        .map(|(tick, (event, detail))| (tick, event, detail))
        .collect();
    for row in [(1, "mark", "by the experimenter, 3"), (11, "note", "looks at the phone")] {
        assert!(rows.contains(&(row.0, row.1.to_owned(), row.2.to_owned())), "{rows:?}");
    }
}

/// The panel on the picture, open, whose commands are obeyed.
fn at_the_panel() -> egui_kittest::Harness<'static, (Show, Desk)> {
    let (show, mut desk) = sit(false);
    desk.panel.open = true;
    egui_kittest::Harness::builder()
        .with_size(egui::vec2(1400.0, 900.0))
        .with_context_setup(crate::panel::theme::apply)
        .build_ui_state(
            |ui, (show, desk)| {
                for command in desk.show(ui, show, None) {
                    desk.obey(command, show);
                    if show.starting().is_some() {
                        begun(show, desk);
                    }
                }
            },
            (show, desk),
        )
}

#[test]
fn the_panels_buttons_let_time_run_hold_it_and_take_the_drive_back_to_its_start() {
    use egui_kittest::kittest::Queryable;
    let mut harness = at_the_panel();
    let mut click = |button: &str| {
        harness.get_by_role_and_label(egui::accesskit::Role::Button, button).click();
        harness.run();
        let (show, desk) = harness.state_mut();
        let ticks = frame(show, desk);
        (ticks, show.drive.clock.pace(), phase(show))
    };
    // A frame of 30 ms is three ticks.
    assert_eq!(click("Start"), (3, Pace::RealTime, Phase::Running));
    assert_eq!(click("Pause"), (0, Pace::Paused, Phase::Paused));
    assert_eq!(click("+1 tick"), (1, Pace::Paused, Phase::Paused));
    assert_eq!(click("+1 step"), (10, Pace::Paused, Phase::Paused));
    assert_eq!(click("Restart"), (0, Pace::Paused, Phase::Ready));
    assert_eq!(harness.state().0.drive.world.snapshot().tick.0, 0);
}

#[test]
fn the_page_of_the_wheel_is_shown_where_it_is_asked_for_and_never_on_the_picture_of_an_attended_driver() {
    for attended in [false, true] {
        let (mut show, mut desk) = sit(attended);
        let none = "No steering wheel is plugged in";
        assert!(!words(|ui| drop(desk.show(ui, &show, None))).contains(none), "it is closed");
        desk.obey(PanelCommand::Wheel, &mut show);
        // A window of egui's is laid out in its first pass and drawn in the second.
        let ctx = egui::Context::default();
        assert_eq!(words_of(&ctx, 2, |ui| drop(desk.show(ui, &show, None))).contains(none), !attended);
        let ctx = egui::Context::default();
        assert!(words_of(&ctx, 2, |ui| drop(desk.experimenter(ui, &show, None))).contains(none));
    }
}

#[test]
fn a_recording_that_came_to_its_end_is_said_with_its_reason_until_another_drive_begins() {
    for attended in [false, true] {
        let (mut show, mut desk) = sit(attended);
        desk.obey(PanelCommand::SingleStep(Advance::Step), &mut show);
        frame(&mut show, &mut desk);
        desk.recording_ended("the disk is full: make room".into());
        let says = |desk: &Desk, show: &Show| desk.notes(show, None).middle;
        assert_eq!(says(&desk, &show), if attended { "Please wait." } else { "The recording has ended. Esc leaves." });
        let seen = if attended {
            words(|ui| drop(desk.experimenter(ui, &show, None)))
        } else {
            words(|ui| drop(desk.show(ui, &show, None)))
        };
        assert!(seen.contains("the disk is full: make room"), "{seen}");
        desk.restart(&scenario(), &mut show);
        assert!(!begun(&mut show, &mut desk));
        assert!(desk.notes(&show, None).corner.is_empty());
        // Held in the middle of it, as the one before.
        desk.obey(PanelCommand::SingleStep(Advance::Step), &mut show);
        frame(&mut show, &mut desk);
        assert_eq!(phase(&show), Phase::Paused);
        assert_eq!(says(&desk, &show), if attended { "Please wait." } else { "Paused. Space continues." });
    }
}

#[test]
fn settings_offer_every_map_policy_and_driver_that_comes_with_the_program() {
    let offered = format!("{:?}", choices());
    for (setting, names) in [
        ("map", &["practice", "ring-250", "ring-641"][..]),
        ("traffic", &["sumo", "native"]),
        (
            "policy",
            &["auto", "none", "constant", "two-phase", "follower-stopper", "pi", "ring-250-speed", "ring-641-speed"],
        ),
        ("driver", &["follow", "perfect", "idm", "sloppy"]),
    ] {
        assert!(offered.contains(&format!("{setting:?}: ([")), "{setting}: {offered}");
        for name in names {
            assert!(offered.contains(&format!("{name:?}")), "{setting} {name}: {offered}");
        }
    }
}

#[test]
fn words_on_the_picture_stand_in_the_upper_middle_and_the_lower_left_and_lose_no_letter_in_a_small_window() {
    let long = "a message that is much longer than a window of 320 points is wide, so that it has to break into lines";
    for size in [egui::vec2(320.0, 180.0), egui::vec2(1280.0, 720.0)] {
        let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, size);
        let notes = Notes { middle: "Paused. Space continues.", corner: vec![long.to_owned()], card: String::new() };
        let ctx = egui::Context::default();
        let input = egui::RawInput { screen_rect: Some(screen), ..Default::default() };
        let mut output = ctx.run_ui(input, |ui| write_notes(ui, &notes));
        output.textures_delta.clear();
        let texts: Vec<(String, egui::Rect)> = output
            .shapes
            .iter()
            .filter_map(|clipped| match &clipped.shape {
                egui::Shape::Text(text) => {
                    Some((text.galley.text().to_owned(), egui::Rect::from_min_size(text.pos, text.galley.size())))
                }
                _ => None,
            })
            .collect();
        let [(middle, above), (corner, below)] = &texts[..] else { panic!("{texts:?}") };
        assert_eq!((middle.as_str(), corner.as_str()), (notes.middle, long));
        assert!(screen.contains_rect(*above) && screen.contains_rect(*below), "{size}: {above} {below}");
        // A third of the way down, in the middle; at the lower left.
        let centre = above.center();
        assert!((centre.x - size.x / 2.0).abs() < 1.0 && (centre.y / size.y - 0.34).abs() < 0.01, "{size}: {centre}");
        assert!(below.left() < 30.0 && size.y - below.bottom() < 30.0, "{size}: {below}");
    }
}
