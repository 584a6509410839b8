//! `codrive replay DIR --window`: a recorded drive in any view, at any speed, with a timeline to seek on. In: a recording. Out:
//! a window; at its end the result of the proof. A [`Verifier`] drives the world again on its own thread, also while nothing is
//! drawn.

use super::{
    ReplayReport,
    playback::Playback,
    verifier::{ReplayHeader, Verifier},
};
use crate::{
    desktop::{
        DriverWindow, WindowSetup,
        event_loop::{self, LoopControl, Windows, now},
        keys::{self, KeyCommand},
    },
    drive_loop::RunError,
    hud::Speedometer,
    panel::{
        key_list,
        seek_bar::{self, AdviceSince, SeekBarCommand, SeekBarEvent, SeekBarState},
        theme,
    },
    record::{self, Table, TableReader, tables::ADVICE_WITHHELD},
    roadside::LazyRoadside,
    scenario::Scenario,
    scene::{self, StaticScene, View, ViewKind, ViewOptions, view_options},
    time::{TICK_S, Tick},
};
use std::{
    path::{Path, PathBuf},
    sync::{Arc, atomic::AtomicBool},
    time::Instant,
};
use winit::{
    event::{ElementState, KeyEvent, WindowEvent},
    event_loop::ActiveEventLoop,
    keyboard::{KeyCode, ModifiersState, PhysicalKey},
    window::{Window, WindowId},
};

/// Options of the replay window.
pub struct ReplayOptions {
    /// Folder of the recording.
    pub recording: PathBuf,
    /// View at the start.
    pub kind: ViewKind,
    /// Time at the start, s.
    pub at_s: f64,
    /// Flag that ends the program (Ctrl-C).
    pub stop: Arc<AtomicBool>,
}

/// Shows a recording until its window is closed. Returns the result of the proof so far, and the recording's length in ticks.
///
/// # Errors
/// The recording cannot be driven again, there is no display or graphics adapter, or the engine failed.
pub fn run(options: &ReplayOptions) -> Result<(ReplayReport, u64), RunError> {
    // The recording is opened first, so that its faults are reported before a window opens.
    let (verifier, opened) = Verifier::start(&options.recording)?;
    let marks = SeekBarMarks::read(&options.recording)?;
    let event_loop = event_loop::event_loop()?;
    let end = opened.end;
    let mut live = ReplayedDrive::new(verifier, opened, marks, options);
    let (_, ended) = event_loop::run::<ReplayWindows>(event_loop, &mut live, &options.stop);
    ended?;
    let report = live.verifier.known().report.clone();
    Ok((report, end.0))
}

/// Number of distinct places on the seek bar; longer drives are thinned to it.
const COLUMNS: u64 = 1000;

/// Contents of the seek bar: times in s, speeds in m/s.
#[derive(Debug, Default, PartialEq)]
pub struct SeekBarMarks {
    advice: Vec<AdviceSince>,
    speeds: Vec<[f64; 2]>,
    events: Vec<SeekBarEvent>,
}

impl SeekBarMarks {
    /// Reads the contents of the seek bar from the tables of a recording.
    ///
    /// # Errors
    /// A table cannot be read.
    pub fn read(recording: &Path) -> Result<Self, RunError> {
        let parts = |table: Table, columns: &[&str]| TableReader::parts(&table.parquet(recording), columns);
        // As many as a screen has columns.
        let stride = (record::count(recording, Table::Ego)? / COLUMNS).max(1);
        let (mut advice, mut speeds, mut events) = (Vec::<AdviceSince>::new(), Vec::new(), Vec::new());
        let mut column = None;
        for part in parts(Table::Advice, &["tick", "target_mps"])? {
            let part = part?;
            for (tick, target) in part.wholes("tick").into_iter().zip(part.numbers("target_mps")) {
                let is_same_column = column.replace(tick / stride) == Some(tick / stride);
                // The last advice in a column of the screen replaces earlier ones.
                match advice.last_mut() {
                    Some(last) if is_same_column => last.target_mps = target,
                    _ => advice.push(AdviceSince { time_s: Tick(tick).seconds(), target_mps: target }),
                }
            }
        }
        for part in parts(Table::Ego, &["tick", "speed_mps"])? {
            let part = part?;
            let rows = part.wholes("tick").into_iter().zip(part.numbers("speed_mps"));
            let seen = rows.filter(|(tick, _)| tick.is_multiple_of(stride));
            speeds.extend(seen.map(|(tick, speed)| [Tick(tick).seconds(), speed.unwrap_or_default()]));
        }
        for part in parts(Table::Events, &["tick", "event", "detail"])? {
            let part = part?;
            let kinds = part.words("event").into_iter().zip(part.words("detail"));
            events.extend(part.wholes("tick").into_iter().zip(kinds).map(|(tick, (kind, detail))| {
                if kind == ADVICE_WITHHELD {
                    advice.push(AdviceSince { time_s: Tick(tick).seconds(), target_mps: None });
                }
                let detail = detail.lines().next().unwrap_or_default();
                let words = if detail.is_empty() { kind } else { format!("{kind}: {detail}") };
                SeekBarEvent { time_s: Tick(tick).seconds(), words }
            }));
        }
        advice.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
        Ok(Self { advice, speeds, events })
    }
}

/// Recording and its playback.
struct ReplayedDrive {
    verifier: Verifier,
    /// Result of the proof and time driven, s, when last read.
    report: ReplayReport,
    known_s: f64,
    playback: Playback,
    marks: SeekBarMarks,
    scenario: Scenario,
    static_scene: StaticScene,
    options: ViewOptions,
    instruments: Speedometer,
    kind: ViewKind,
    end: Tick,
}

impl ReplayedDrive {
    fn new(verifier: Verifier, opened: ReplayHeader, marks: SeekBarMarks, options: &ReplayOptions) -> Self {
        let ReplayHeader { scenario, map, instruments, end } = opened;
        let mut playback = Playback::new(end.seconds());
        playback.seek(options.at_s);
        let roadside = LazyRoadside::new(&map, scenario.seed, scenario.display.trees as usize);
        Self {
            verifier,
            report: ReplayReport::default(),
            known_s: 0.0,
            playback,
            marks,
            static_scene: StaticScene::of_drive(&map, &scenario, &roadside),
            options: view_options(&scenario),
            scenario,
            instruments,
            kind: options.kind,
            end,
        }
    }

    /// Reads the present progress of the verifier.
    fn look(&mut self) -> Result<(), RunError> {
        let mut known = self.verifier.known();
        if let Some(error) = known.failure.take() {
            return Err(error);
        }
        self.known_s = known.timeline.end_s();
        self.report.clone_from(&known.report);
        Ok(())
    }

    fn view(&mut self) -> View {
        let (snapshot, fraction) = self.verifier.known().timeline.at(self.playback.time_s);
        let mut view = scene::view(&snapshot, fraction, self.kind, &self.options, &self.static_scene);
        view.dial = self.kind.has_dial().then(|| self.instruments.read(&snapshot));
        view
    }

    fn obey(&mut self, command: SeekBarCommand) {
        match command {
            SeekBarCommand::Toggle => self.playback.toggle(),
            SeekBarCommand::Seek(time_s) => self.playback.seek(time_s),
            SeekBarCommand::Tick(ticks) => self.playback.tick(ticks),
            SeekBarCommand::Speed(faster) => self.playback.change_speed(faster),
            SeekBarCommand::NextView => {
                self.kind = match self.kind {
                    ViewKind::Driver => ViewKind::Chase,
                    ViewKind::Chase => ViewKind::Birdseye,
                    ViewKind::Birdseye => ViewKind::Mirror,
                    ViewKind::Mirror => ViewKind::Driver,
                }
            }
        }
    }

    fn seek_bar(&self, ui: &mut egui::Ui) -> (Vec<SeekBarCommand>, f32) {
        let proof = proof(&self.report, self.end.0);
        let state = SeekBarState {
            time_s: self.playback.time_s,
            end_s: self.playback.end_s,
            known_s: self.known_s,
            playing: self.playback.playing,
            speed: self.playback.speed(),
            view: match self.kind {
                ViewKind::Driver => "Driver's view",
                ViewKind::Chase => "From behind",
                ViewKind::Birdseye => "From above",
                ViewKind::Mirror => "Mirror",
            },
            advice: &self.marks.advice,
            speeds: &self.marks.speeds,
            events: &self.marks.events,
            proof: &proof,
            differs: !self.report.is_proven(),
        };
        seek_bar::show(ui, &state)
    }
}

/// Returns the result of the proof as a line of text.
fn proof(report: &ReplayReport, all: u64) -> String {
    if report.is_empty {
        return "nothing to compare: the recording has no tick".into();
    }
    if let [first, more @ ..] = report.changes.as_slice() {
        let others = if more.is_empty() { String::new() } else { format!(" and {} more", more.len()) };
        return format!("changed since it was recorded: {}{others}", first.file);
    }
    if let Some(tick) = report.hole {
        return format!("rows are missing from {:.2} s on", tick.seconds());
    }
    match report.first_difference {
        None if !report.facts.is_empty() => format!("not as driven: {}", report.facts[0]),
        Some(tick) => format!("differs from the recording from {:.2} s on", Tick(tick).seconds()),
        None if report.ticks >= all => format!("proven: all {all} ticks are the same to the bit"),
        None => format!("proven to {:.0} s: the same to the bit", Tick(report.ticks).seconds()),
    }
}

/// Returns the command of a key.
fn command_of(key: KeyCode, shift: bool, playback: &Playback) -> Option<SeekBarCommand> {
    let by = |seconds: f64| SeekBarCommand::Tick((seconds / TICK_S) as i64);
    Some(match key {
        KeyCode::Space => SeekBarCommand::Toggle,
        KeyCode::ArrowLeft => {
            if shift {
                by(-1.0)
            } else {
                SeekBarCommand::Tick(-1)
            }
        }
        KeyCode::ArrowRight => {
            if shift {
                by(1.0)
            } else {
                SeekBarCommand::Tick(1)
            }
        }
        KeyCode::PageUp => SeekBarCommand::Seek(playback.time_s - 10.0),
        KeyCode::PageDown => SeekBarCommand::Seek(playback.time_s + 10.0),
        KeyCode::Home => SeekBarCommand::Seek(0.0),
        KeyCode::End => SeekBarCommand::Seek(playback.end_s),
        KeyCode::ArrowUp => SeekBarCommand::Speed(true),
        KeyCode::ArrowDown => SeekBarCommand::Speed(false),
        KeyCode::KeyV => SeekBarCommand::NextView,
        _ => return None,
    })
}

/// Keys of the window and their meanings.
const KEYS: [(&str, &str); 11] = [
    ("F1", "this list"),
    ("Space", "play, hold"),
    ("Left, Right", "by one tick (10 ms)"),
    ("Shift+Left, Right", "by 1 s"),
    ("Page Up, Page Down", "by 10 s"),
    ("Home, End", "to the start, to the end"),
    ("Up, Down", "twice as fast, half as fast"),
    ("V", "next view: driver, chase, bird's-eye, mirror"),
    ("F11", "full screen"),
    ("Esc", "close this list, end"),
    ("Ctrl+Q", "end"),
];

/// Replay window with its playback.
struct ReplayWindows<'a> {
    live: &'a mut ReplayedDrive,
    picture: DriverWindow,
    last: Instant,
    modifiers: ModifiersState,
    help_open: bool,
}

impl<'a> Windows for ReplayWindows<'a> {
    type WindowParts = &'a mut ReplayedDrive;

    fn open(event_loop: &ActiveEventLoop, live: &'a mut ReplayedDrive) -> Result<Self, RunError> {
        let title = format!("codrive replay: {}", live.scenario.map);
        let mut picture = DriverWindow::open(event_loop, &WindowSetup { title, ..WindowSetup::default() })?;
        theme::apply(picture.ctx());
        let view = live.view();
        picture.set_static_scene(&live.static_scene, &view, live.scenario.display.quality)?;
        Ok(Self { live, picture, last: now(), modifiers: ModifiersState::default(), help_open: false })
    }

    fn handle_event(&mut self, _: WindowId, event: WindowEvent) -> Result<LoopControl, RunError> {
        self.picture.on_event(&event);
        match event {
            WindowEvent::CloseRequested => return Ok(LoopControl::End),
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } => return Ok(self.key(&event)),
            WindowEvent::RedrawRequested => self.draw()?,
            _ => {}
        }
        Ok(LoopControl::GoOn)
    }

    fn first(&self) -> &Window {
        self.picture.window()
    }
}

impl ReplayWindows<'_> {
    fn key(&mut self, event: &KeyEvent) -> LoopControl {
        let PhysicalKey::Code(code) = event.physical_key else { return LoopControl::GoOn };
        if event.state != ElementState::Pressed {
            return LoopControl::GoOn;
        }
        let control = self.modifiers.control_key() || self.modifiers.super_key();
        if control && keys::with_control(&event.logical_key, code) == Some(KeyCommand::Quit) {
            return LoopControl::End;
        }
        match code {
            KeyCode::Escape if !std::mem::take(&mut self.help_open) => return LoopControl::End,
            KeyCode::F1 => self.help_open = !self.help_open,
            KeyCode::F11 => self.picture.toggle_fullscreen(),
            code => {
                let asked = command_of(code, self.modifiers.shift_key(), &self.live.playback);
                if let Some(command) = asked {
                    self.live.obey(command);
                }
            }
        }
        LoopControl::GoOn
    }

    fn draw(&mut self) -> Result<(), RunError> {
        let Self { live, picture, last, help_open, .. } = self;
        let begin = now();
        let elapsed_s = (begin - *last).as_secs_f64();
        *last = begin;
        live.look()?;
        live.playback.advance(elapsed_s, live.known_s);
        let view = live.view();
        let (mut asked, mut foot) = (Vec::new(), 0.0);
        let output = picture.overlay(|ui| {
            let (commands, height) = live.seek_bar(ui);
            asked.extend(commands);
            foot = height;
            if *help_open {
                key_list(ui.ctx(), &KEYS);
            }
        });
        picture.leave_foot((foot * output.pixels_per_point).round() as u32);
        picture.draw(Some(&view), Some(output));
        asked.into_iter().for_each(|command| live.obey(command));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::AlteredFile;

    #[test]
    fn the_proof_is_described_as_far_as_it_goes() {
        let report = |ticks, first_difference| ReplayReport { ticks, first_difference, ..ReplayReport::default() };
        assert_eq!(proof(&report(1200, None), 3000), "proven to 12 s: the same to the bit");
        assert_eq!(proof(&report(3000, None), 3000), "proven: all 3000 ticks are the same to the bit");
        assert_eq!(proof(&report(3000, Some(250)), 3000), "differs from the recording from 2.50 s on");
        let change = |file: &str| AlteredFile { file: file.into(), what: String::new() };
        let changes = vec![change("ego.parquet"), change("manifest.json")];
        let changed = ReplayReport { changes, ..report(3000, None) };
        assert_eq!(proof(&changed, 3000), "changed since it was recorded: ego.parquet and 1 more");
        let cut = ReplayReport { hole: Some(Tick(51)), ..report(50, None) };
        assert_eq!(proof(&cut, 3000), "rows are missing from 0.51 s on");
    }

    #[test]
    fn keys_move_by_ticks_by_seconds_and_to_the_ends() {
        let mut playback = Playback::new(60.0);
        playback.seek(20.0);
        let asked = |key, shift| command_of(key, shift, &playback);
        assert_eq!(asked(KeyCode::ArrowLeft, false), Some(SeekBarCommand::Tick(-1)));
        assert_eq!(asked(KeyCode::ArrowRight, true), Some(SeekBarCommand::Tick(100)));
        assert_eq!(asked(KeyCode::PageUp, false), Some(SeekBarCommand::Seek(10.0)));
        assert_eq!(asked(KeyCode::End, false), Some(SeekBarCommand::Seek(60.0)));
        assert_eq!(asked(KeyCode::KeyQ, false), None);
    }
}
