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

/// Ticks that a frame of a second brings.
fn frame(show: &mut Show, desk: &mut Desk) -> u64 {
    let before = show.drive.world.snapshot().tick.0;
    show.advance(Duration::from_millis(30), |world| desk.watch(world)).unwrap();
    show.drive.world.snapshot().tick.0 - before
}

/// All words that egui draws of this.
fn words(draw: impl FnMut(&mut Ui)) -> String {
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
    let ctx = egui::Context::default();
    let screen_rect = Some(egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(1400.0, 900.0)));
    let mut output = ctx.run_ui(egui::RawInput { screen_rect, ..Default::default() }, draw);
    // There is no device that would take them.
    output.textures_delta.clear();
    let mut out = String::new();
    output.shapes.iter().for_each(|clipped| of(&clipped.shape, &mut out));
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
        let [waits, over] = if attended {
            ["Please wait.", "The drive is over."]
        } else {
            ["Paused. Space goes on.", "The drive is over. Backspace begins again."]
        };
        assert_eq!((phase(&show), says(&desk, &show)), (Phase::Ready, waits));
        assert!(words(|ui| drop(desk.show(ui, &show, None))).contains(waits), "and it is drawn");
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
    let dropped = format!("dropped {:.2} s in 1 stalls", due.dropped.as_secs_f64());
    assert!(due.ticks < 100 && due.dropped > Duration::ZERO);
    assert!(desk.notes(&show, None).corner.contains(&dropped), "{:?}", desk.notes(&show, None).corner);

    let (show, mut desk) = sit(true);
    desk.say("the wheel is back".into(), &show);
    assert!(desk.notes(&show, None).corner.is_empty());
    assert!(words(|ui| drop(desk.experimenter(ui, &show, None))).contains("the wheel is back"));
}

#[test]
fn a_drive_that_cannot_start_leaves_the_one_before_and_says_why() {
    let (mut show, mut desk) = sit(false);
    desk.obey(PanelCommand::SingleStep(Advance::Step), &mut show);
    frame(&mut show, &mut desk);
    let full = Scenario { vehicles: 400, ..scenario() };
    assert!(!desk.obey(PanelCommand::Restart(Box::new(full)), &mut show));
    let world = &show.drive.world;
    assert_eq!((world.snapshot().tick.0, world.scenario().vehicles, phase(&show)), (0, 6, Phase::Ready));
    let corner = desk.notes(&show, None).corner.join("\n");
    assert!(corner.contains("400") && corner.contains("do not fit"), "{corner}");
    // A good one takes the message away. Another seed is another stage, as many cars more are not.
    let more = Scenario { vehicles: 8, ..scenario() };
    assert!(!desk.obey(PanelCommand::Restart(Box::new(more.clone())), &mut show));
    assert!(desk.notes(&show, None).corner.is_empty() && show.drive.world.scenario().vehicles == 8);
    assert!(desk.obey(PanelCommand::Restart(Box::new(Scenario { seed: 9, ..more })), &mut show));
}

#[test]
fn marks_and_notes_of_the_experimenter_stand_in_the_recording_at_their_tick() {
    let gpu = Gpu::shared().expect("a graphics adapter is needed");
    let folder = tempfile::tempdir().unwrap();
    let recording = folder.path().join("drive");
    let (mut show, mut desk) = sit(true);
    show.record(&recording, gpu).unwrap();
    for (ticks, command) in
        [(1, ExperimenterCommand::Mark(3)), (10, ExperimenterCommand::Note("looks at the phone".into()))]
    {
        show.drive.clock.single_step(ticks);
        frame(&mut show, &mut desk);
        assert!(!desk.heed(command, &mut show));
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
    for row in [(1, "mark", "experimenter, mark 3"), (11, "note", "looks at the phone")] {
        assert!(rows.contains(&(row.0, row.1.to_owned(), row.2.to_owned())), "{rows:?}");
    }
}
