//! Tests of the overlay on a drive without a window: keys, texts on the picture, commands of the experimenter.

use super::*;
use crate::{
    input::{Devices, Rig},
    record::{Table, TableReader},
    render::Gpu,
    scenario::DisplaySettings,
    traffic::EngineChoice,
};

fn scenario() -> Scenario {
    let usual = Scenario { traffic: EngineChoice::Native, vehicles: 6, warm_up_s: 0.0, ..Scenario::default() };
    Scenario { duration_s: 0.5, policy: "none".into(), display: DisplaySettings { trees: 0, ..usual.display }, ..usual }
}

fn sit(attended: bool) -> (LiveDrive, DriveOverlay) {
    let devices = Devices::with_rig(Rig::fed_by(std::sync::mpsc::channel().1));
    let live = LiveDrive::new(&scenario(), Pace::Paused, devices).unwrap();
    let overlay = DriveOverlay::new(&live, false, attended);
    (live, overlay)
}

/// Advances by a frame of 30 ms and returns the number of ticks.
fn frame(live: &mut LiveDrive, overlay: &mut DriveOverlay) -> u64 {
    let before = live.drive.world.snapshot().tick.0;
    live.advance(Duration::from_millis(30), |world| overlay.watch(world)).unwrap();
    live.drive.world.snapshot().tick.0 - before
}

/// Returns all text that egui draws.
fn drawn_text(draw: impl FnMut(&mut Ui)) -> String {
    text_of(&egui::Context::default(), 1, draw)
}

/// Returns all text of the last of `passes` passes.
fn text_of(ctx: &egui::Context, passes: usize, mut draw: impl FnMut(&mut Ui)) -> String {
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
        // There is no device to take the textures.
        output.textures_delta.clear();
        out.clear();
        output.shapes.iter().for_each(|clipped| of(&clipped.shape, &mut out));
    }
    out
}

#[test]
fn keys_pause_advance_by_a_tick_or_a_step_and_change_the_view() {
    let (mut live, mut overlay) = sit(false);
    assert_eq!(frame(&mut live, &mut overlay), 0);
    overlay.key(KeyCommand::Tick, &mut live);
    assert_eq!(frame(&mut live, &mut overlay), 1);
    overlay.key(KeyCommand::Step, &mut live);
    assert_eq!(frame(&mut live, &mut overlay), 10);
    overlay.key(KeyCommand::Pause, &mut live);
    // While the clock runs, a single step changes nothing.
    overlay.key(KeyCommand::Step, &mut live);
    assert_eq!((frame(&mut live, &mut overlay), live.drive.clock.pace()), (3, Pace::RealTime));
    overlay.key(KeyCommand::Pause, &mut live);
    assert_eq!(frame(&mut live, &mut overlay), 0);

    use crate::scene::ViewKind::{Birdseye, Chase, Driver, Mirror};
    for view in [Chase, Birdseye, Mirror, Driver] {
        overlay.key(KeyCommand::NextView, &mut live);
        assert_eq!(live.picture.kind, view);
    }
    overlay.key(KeyCommand::WholeMap, &mut live);
    assert!(overlay.show_map);
    overlay.key(KeyCommand::WholeMap, &mut live);
    assert!(!overlay.show_map);
    let was = live.lane_help();
    overlay.key(KeyCommand::LaneHelp, &mut live);
    let message = format!("lane help is {}", if was { "off" } else { "on" });
    assert_eq!((live.lane_help(), overlay.message.clone()), (!was, Some(message)));
    overlay.key(KeyCommand::Help, &mut live);
    assert_eq!((overlay.message.clone(), overlay.panel.help_open), (None, true), "the next key takes the message away");
    overlay.key(KeyCommand::Panel, &mut live);
    assert!(overlay.panel.open);
}

#[test]
fn the_text_on_the_picture_fits_the_state_and_the_reader() {
    for attended in [false, true] {
        let (mut live, mut overlay) = sit(attended);
        let shown_message = |overlay: &DriveOverlay, live: &LiveDrive| overlay.notes(live, None).middle;
        let [starts, waits, over] = if attended {
            ["Please wait.", "Please wait.", "The drive is over."]
        } else {
            [START, "Paused. Space continues.", "The drive is over. Press Backspace to start again."]
        };
        assert_eq!((phase(&live), shown_message(&overlay, &live)), (DrivePhase::Ready, starts));
        assert!(drawn_text(|ui| drop(overlay.show(ui, &live, None))).contains(starts), "and it is drawn");
        overlay.handle_panel_command(PanelCommand::Start, &mut live);
        frame(&mut live, &mut overlay);
        assert_eq!((phase(&live), shown_message(&overlay, &live)), (DrivePhase::Running, ""));
        overlay.handle_panel_command(PanelCommand::Pause, &mut live);
        assert_eq!((phase(&live), shown_message(&overlay, &live)), (DrivePhase::Paused, waits));
        overlay.handle_panel_command(PanelCommand::SingleStep(SingleStep::Step), &mut live);
        assert_eq!(frame(&mut live, &mut overlay), 10);
        live.drive.clock.set_pace(Pace::FullSpeed);
        while live.drive.world.ended().is_none() {
            frame(&mut live, &mut overlay);
        }
        assert_eq!((phase(&live), shown_message(&overlay, &live)), (DrivePhase::Ended, over));
        let summary = drawn_text(|ui| drop(overlay.show(ui, &live, None)));
        assert_eq!(summary.contains("Mean speed of all vehicles: "), !attended, "{summary}");
    }
}

#[test]
fn messages_go_to_the_experimenter_if_present_and_times_show_on_demand() {
    let (mut live, mut overlay) = sit(false);
    overlay.show_message("the wheel is back".into(), &live);
    assert_eq!(overlay.notes(&live, None).corner, ["the wheel is back"]);
    overlay.key(KeyCommand::FrameTimes, &mut live);
    let times = PassTimes { shadow_ms: 1.0, main_ms: 2.5, mirror_ms: 0.25, tonemap_ms: 0.125, ..PassTimes::default() };
    let corner = overlay.notes(&live, Some(times)).corner.join("\n");
    for part in ["shadow 1.00, main 2.50, mirror 0.25, tone map 0.12 ms", "dropped 0.00 s in 0 stalls", "keyboard"] {
        assert!(corner.contains(part), "{corner}");
    }
    // A second that came late: at most 0.25 s of it are simulated, the rest is reported as dropped.
    live.drive.clock.set_pace(Pace::RealTime);
    let due = live.advance(Duration::from_secs(1), |_| ()).unwrap();
    let dropped = format!("dropped {:.2} s in 1 stall", due.dropped.as_secs_f64());
    assert!(due.ticks < 100 && due.dropped > Duration::ZERO);
    assert!(overlay.notes(&live, None).corner.contains(&dropped), "{:?}", overlay.notes(&live, None).corner);

    let (live, mut overlay) = sit(true);
    overlay.show_message("the wheel is back".into(), &live);
    assert!(overlay.notes(&live, None).corner.is_empty());
    assert!(drawn_text(|ui| drop(overlay.experimenter(ui, &live, None))).contains("the wheel is back"));
}

/// Waits for the end of a restart. Returns true if there is a new static scene.
fn begun(live: &mut LiveDrive, overlay: &mut DriveOverlay) -> bool {
    overlay
        .restarted(Duration::from_secs(60), live)
        .or_else(|| overlay.restarted(Duration::from_secs(60), live))
        .unwrap()
}

#[test]
fn while_a_drive_is_being_started_time_stands_and_the_window_says_so() {
    // Two hours of warm-up and of waiting for a wave that never comes, in steps of a hundredth of a second: seconds.
    let (warm_up_s, wave_wait_s, wave_sd_mps, step_s) = (3600.0, 3600.0, 10.0, 0.01);
    let waits = Scenario { vehicles: 30, warm_up_s, wave_wait_s, wave_sd_mps, step_s, ..scenario() };
    for attended in [false, true] {
        let (mut live, mut overlay) = sit(attended);
        overlay.handle_panel_command(PanelCommand::Start, &mut live);
        assert!(frame(&mut live, &mut overlay) > 0);
        let tick = live.drive.world.snapshot().tick;
        overlay.handle_panel_command(PanelCommand::Restart(Box::new(waits.clone())), &mut live);
        assert_eq!(live.starting(), Some(&waits));
        assert!(overlay.restarted(Duration::from_millis(10), &mut live).is_none());
        assert_eq!(phase(&live), DrivePhase::Starting);
        let shown_message = overlay.notes(&live, None).middle;
        assert_eq!(shown_message, if attended { "Please wait." } else { "The drive is starting. Esc ends it." });
        // Keys and commands during the start do not move the old drive.
        overlay.handle_panel_command(PanelCommand::SingleStep(SingleStep::Step), &mut live);
        for _ in 0..2 {
            overlay.key(KeyCommand::Pause, &mut live);
            overlay.key(KeyCommand::Tick, &mut live);
            assert_eq!(frame(&mut live, &mut overlay), 0);
        }
        assert_eq!(live.drive.world.snapshot().tick, tick);
        // Another restart replaces the first, which is cancelled at once; the pace stays.
        overlay.handle_panel_command(PanelCommand::Restart(Box::new(scenario())), &mut live);
        assert!(!begun(&mut live, &mut overlay));
        assert_eq!((phase(&live), &live.drive.world.scenario().traffic), (DrivePhase::Running, &EngineChoice::Native));
        assert!(frame(&mut live, &mut overlay) > 0);
    }
}

#[test]
fn a_drive_that_cannot_start_again_stands_until_another_try_works() {
    let folder = tempfile::tempdir().unwrap();
    let (there, away) = (folder.path().join("ring"), folder.path().join("away"));
    std::fs::create_dir(&there).unwrap();
    for file in std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/maps/ring-250")).unwrap() {
        let file = file.unwrap();
        std::fs::copy(file.path(), there.join(file.file_name())).unwrap();
    }
    let own = Scenario { map: there.to_str().unwrap().to_owned(), ..scenario() };
    let (mut live, mut overlay) = sit(false);
    overlay.restart(&own, &mut live);
    assert!(begun(&mut live, &mut overlay), "another map is another stage");
    overlay.handle_panel_command(PanelCommand::Start, &mut live);
    assert!(frame(&mut live, &mut overlay) > 0);
    std::fs::rename(&there, &away).unwrap();
    overlay.restart(&own, &mut live);
    assert!(!begun(&mut live, &mut overlay));
    assert_eq!((phase(&live), frame(&mut live, &mut overlay)), (DrivePhase::Ended, 0));
    let notes = overlay.notes(&live, None);
    assert_eq!(notes.middle, "The drive could not start. Press Backspace to try again.");
    assert!(notes.corner.join("\n").contains(there.to_str().unwrap()), "{:?}", notes.corner);
    std::fs::rename(&away, &there).unwrap();
    overlay.restart(&own, &mut live);
    begun(&mut live, &mut overlay);
    assert_eq!((phase(&live), overlay.notes(&live, None).corner.len()), (DrivePhase::Running, 0));
    assert!(frame(&mut live, &mut overlay) > 0);
}

#[test]
fn a_drive_that_cannot_start_keeps_the_old_one_and_gives_the_reason() {
    let (mut live, mut overlay) = sit(false);
    overlay.handle_panel_command(PanelCommand::SingleStep(SingleStep::Step), &mut live);
    frame(&mut live, &mut overlay);
    let full = Scenario { vehicles: 400, ..scenario() };
    overlay.handle_panel_command(PanelCommand::Restart(Box::new(full)), &mut live);
    assert!(!begun(&mut live, &mut overlay));
    let world = &live.drive.world;
    assert_eq!((world.snapshot().tick.0, world.scenario().vehicles, phase(&live)), (0, 6, DrivePhase::Ready));
    let corner = overlay.notes(&live, None).corner.join("\n");
    assert!(corner.contains("400") && corner.contains("do not fit"), "{corner}");
    // A good scenario removes the message. Another seed needs another static scene, a few more vehicles do not.
    let more = Scenario { vehicles: 8, ..scenario() };
    overlay.handle_panel_command(PanelCommand::Restart(Box::new(more.clone())), &mut live);
    assert!(!begun(&mut live, &mut overlay));
    assert!(overlay.notes(&live, None).corner.is_empty() && live.drive.world.scenario().vehicles == 8);
    overlay.handle_panel_command(PanelCommand::Restart(Box::new(Scenario { seed: 9, ..more })), &mut live);
    assert!(begun(&mut live, &mut overlay));
}

#[test]
fn marks_and_notes_are_recorded_at_their_tick() {
    let gpu = Gpu::shared().expect("a graphics adapter is needed");
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("drive");
    let (mut live, mut overlay) = sit(true);
    let both = |live: &LiveDrive, overlay: &mut DriveOverlay| {
        [
            drawn_text(|ui| drop(overlay.experimenter(ui, live, None))),
            drawn_text(|ui| drop(overlay.show(ui, live, None))),
        ]
    };
    assert!(both(&live, &mut overlay).iter().all(|seen| seen.contains("not recorded") && !seen.contains("REC")));
    live.record(&recording, gpu).unwrap();
    assert!(both(&live, &mut overlay).iter().all(|seen| seen.contains("REC drive") && !seen.contains("not recorded")));
    for (ticks, command) in
        [(1, ExperimenterCommand::Mark(3)), (10, ExperimenterCommand::Note("looks at the phone".into()))]
    {
        live.drive.clock.single_step(ticks);
        frame(&mut live, &mut overlay);
        overlay.handle_experimenter_command(command, &mut live);
    }
    overlay.handle_experimenter_command(ExperimenterCommand::Drive(PanelCommand::Start), &mut live);
    assert_eq!(live.drive.clock.pace(), Pace::RealTime);
    live.finish_recording().unwrap();
    let events = TableReader::parquet(&Table::Events.parquet(&recording)).unwrap();
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

/// Returns a harness of the picture with the panel open, which executes the panel's commands.
fn at_the_panel() -> egui_kittest::Harness<'static, (LiveDrive, DriveOverlay)> {
    let (live, mut overlay) = sit(false);
    overlay.panel.open = true;
    egui_kittest::Harness::builder()
        .with_size(egui::vec2(1400.0, 900.0))
        .with_context_setup(crate::panel::theme::apply)
        .build_ui_state(
            |ui, (live, overlay)| {
                for command in overlay.show(ui, live, None) {
                    overlay.handle_panel_command(command, live);
                    if live.starting().is_some() {
                        begun(live, overlay);
                    }
                }
            },
            (live, overlay),
        )
}

#[test]
fn the_panels_buttons_run_pause_step_and_restart_the_drive() {
    use egui_kittest::kittest::Queryable;
    let mut harness = at_the_panel();
    let mut click = |button: &str| {
        harness.get_by_role_and_label(egui::accesskit::Role::Button, button).click();
        harness.run();
        let (live, overlay) = harness.state_mut();
        let ticks = frame(live, overlay);
        (ticks, live.drive.clock.pace(), phase(live))
    };
    // A frame of 30 ms is three ticks.
    assert_eq!(click("Start"), (3, Pace::RealTime, DrivePhase::Running));
    assert_eq!(click("Pause"), (0, Pace::Paused, DrivePhase::Paused));
    assert_eq!(click("+1 tick"), (1, Pace::Paused, DrivePhase::Paused));
    assert_eq!(click("+1 step"), (10, Pace::Paused, DrivePhase::Paused));
    assert_eq!(click("Restart"), (0, Pace::Paused, DrivePhase::Ready));
    assert_eq!(harness.state().0.drive.world.snapshot().tick.0, 0);
}

#[test]
fn the_wheel_page_is_shown_on_request_but_not_to_an_attended_driver() {
    for attended in [false, true] {
        let (mut live, mut overlay) = sit(attended);
        let none = "No steering wheel is plugged in";
        assert!(!drawn_text(|ui| drop(overlay.show(ui, &live, None))).contains(none), "it is closed");
        overlay.handle_panel_command(PanelCommand::Wheel, &mut live);
        // An egui window is laid out in its first pass and drawn in the second.
        let ctx = egui::Context::default();
        assert_eq!(text_of(&ctx, 2, |ui| drop(overlay.show(ui, &live, None))).contains(none), !attended);
        let ctx = egui::Context::default();
        assert!(text_of(&ctx, 2, |ui| drop(overlay.experimenter(ui, &live, None))).contains(none));
    }
}

#[test]
fn a_failed_recording_is_shown_with_its_reason_until_the_next_drive() {
    for attended in [false, true] {
        let (mut live, mut overlay) = sit(attended);
        overlay.handle_panel_command(PanelCommand::SingleStep(SingleStep::Step), &mut live);
        frame(&mut live, &mut overlay);
        overlay.recording_ended("the disk is full: make room".into());
        let shown_message = |overlay: &DriveOverlay, live: &LiveDrive| overlay.notes(live, None).middle;
        assert_eq!(
            shown_message(&overlay, &live),
            if attended { "Please wait." } else { "The recording has ended. Esc leaves." }
        );
        let seen = if attended {
            drawn_text(|ui| drop(overlay.experimenter(ui, &live, None)))
        } else {
            drawn_text(|ui| drop(overlay.show(ui, &live, None)))
        };
        assert!(seen.contains("the disk is full: make room"), "{seen}");
        overlay.restart(&scenario(), &mut live);
        assert!(!begun(&mut live, &mut overlay));
        assert!(overlay.notes(&live, None).corner.is_empty());
        // Paused in the middle of it, like the drive before.
        overlay.handle_panel_command(PanelCommand::SingleStep(SingleStep::Step), &mut live);
        frame(&mut live, &mut overlay);
        assert_eq!(phase(&live), DrivePhase::Paused);
        assert_eq!(shown_message(&overlay, &live), if attended { "Please wait." } else { "Paused. Space continues." });
    }
}

#[test]
fn settings_offer_every_map_policy_and_driver_that_comes_with_the_program() {
    let offered = format!("{:?}", choices());
    for (setting, names) in [
        ("map", &["lane-10km", "practice", "ring-250", "ring-260", "ring-641"][..]),
        (
            "policy",
            &["auto", "none", "constant", "two-phase", "follower-stopper", "pi", "ring-250-speed", "ring-641-speed"],
        ),
        ("traffic_drivers", &["ring-study", "safe-followers", "gap-closers"]),
        ("driver", &["follow", "perfect", "idm", "sloppy"]),
    ] {
        assert!(offered.contains(&format!("{setting:?}: ([")), "{setting}: {offered}");
        for name in names {
            assert!(offered.contains(&format!("{name:?}")), "{setting} {name}: {offered}");
        }
    }
}

#[test]
fn texts_on_the_picture_stay_in_place_and_whole_in_a_small_window() {
    let long = "a message that is much longer than a window of 320 points is wide, so that it has to break into lines";
    for size in [egui::vec2(320.0, 180.0), egui::vec2(1280.0, 720.0)] {
        let screen = egui::Rect::from_min_size(egui::Pos2::ZERO, size);
        let notes =
            OverlayNotes { middle: "Paused. Space continues.", corner: vec![long.to_owned()], card: String::new() };
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

#[test]
fn the_counts_of_the_readout_begin_anew_with_each_drive() {
    let (mut live, mut overlay) = sit(true);
    let counts = |live: &LiveDrive, overlay: &mut DriveOverlay| {
        let DriveOverlay { log, loop_health, engine, .. } = overlay;
        let health = loop_health.health(live, engine, None);
        let readout = state(live, log, loop_health, engine, None);
        (health.dropped_s, health.contacts.count, readout.dropped, readout.stalls)
    };
    overlay.handle_panel_command(PanelCommand::Start, &mut live);
    let due = live.advance(Duration::from_secs(3), |world| overlay.watch(world)).unwrap();
    overlay.frame(Duration::from_secs(3), &due);
    let (dropped_s, _, dropped, stalls) = counts(&live, &mut overlay);
    assert!(dropped_s.iter().all(|s| *s > 2.0) && dropped > Duration::from_secs(2) && stalls == 1, "{dropped_s:?}");
    overlay.restart(&scenario(), &mut live);
    begun(&mut live, &mut overlay);
    assert_eq!(counts(&live, &mut overlay), ([0.0; 2], 0, Duration::ZERO, 0));
}
