//! `codrive replay DIR --window`: a recorded drive to be looked at in any view, at any speed, with a line to seek on. In: a
//! recording. Out: a window; at its end what the proof has found. The world is driven again by a [`Prover`] beside it, whether
//! the window is drawn or not.

use super::{
    Verdict,
    film::Player,
    prover::{Opened, Prover},
};
use crate::{
    app::{
        AppError, Instruments,
        host::{PictureWindow, Placing},
        shell::{self, Next, Windows, now},
        view_options,
    },
    panel::{
        key_list, theme,
        timeline::{self, Happened, TimelineCommand, TimelineState},
    },
    record::{self, Reader, Table},
    scene::{self, Stage, View, ViewKind, ViewOptions},
    sim::Scenario,
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

/// How the window was asked to open.
pub struct ReplayOptions {
    /// The recording.
    pub recording: PathBuf,
    /// The view it begins with.
    pub kind: ViewKind,
    /// Begin at this time, seconds.
    pub at_s: f64,
    /// Becomes true when the program is to end (Ctrl-C).
    pub stop: Arc<AtomicBool>,
}

/// Shows a recording until its window is closed. Returns what was proven until then, and the recording's length in ticks.
///
/// # Errors
/// No recording that can be driven again, no display, no graphics adapter, or the engine failed on the way.
pub fn run(options: &ReplayOptions) -> Result<(Verdict, u64), AppError> {
    // The recording first: what is wrong with it is said before a window opens.
    let (prover, opened) = Prover::start(&options.recording)?;
    let marks = Marks::read(&options.recording)?;
    let event_loop = shell::event_loop()?;
    let end = opened.end;
    let mut show = Show::new(prover, opened, marks, options);
    let (_, ended) = shell::run::<Frame>(event_loop, &mut show, &options.stop);
    ended?;
    let verdict = show.prover.known().verdict.clone();
    Ok((verdict, end.0))
}

/// So many places on the line are told apart: what a drive of days has more of is thinned to it.
const COLUMNS: u64 = 1000;

/// What stands on the line: times in seconds, speeds in m/s.
#[derive(Debug, Default, PartialEq)]
pub struct Marks {
    advice: Vec<[f64; 2]>,
    speeds: Vec<[f64; 2]>,
    events: Vec<Happened>,
}

impl Marks {
    /// From the tables of a recording.
    ///
    /// # Errors
    /// A table cannot be read.
    pub fn read(recording: &Path) -> Result<Self, AppError> {
        let parts = |table: Table, columns: &[&str]| Reader::parts(&table.parquet(recording), columns);
        // As many as a screen has columns.
        let stride = (record::count(recording, Table::Ego)? / COLUMNS).max(1);
        let (mut advice, mut speeds, mut events) = (Vec::<[f64; 2]>::new(), Vec::new(), Vec::new());
        let mut column = None;
        for part in parts(Table::Advice, &["tick", "target_mps"])? {
            let part = part?;
            for (tick, target) in part.wholes("tick").into_iter().zip(part.numbers("target_mps")) {
                let target_mps = target.unwrap_or_default();
                let is_same_column = column.replace(tick / stride) == Some(tick / stride);
                // What was advised in one column of the screen replaces what was before it.
                match advice.last_mut() {
                    Some(last) if is_same_column => last[1] = target_mps,
                    _ => advice.push([Tick(tick).seconds(), target_mps]),
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
                let detail = detail.lines().next().unwrap_or_default();
                let words = if detail.is_empty() { kind } else { format!("{kind}: {detail}") };
                Happened { time_s: Tick(tick).seconds(), words }
            }));
        }
        Ok(Self { advice, speeds, events })
    }
}

/// The recording and where it is looked at.
struct Show {
    prover: Prover,
    /// What was found when it was last looked at, and how far it was driven then, seconds.
    verdict: Verdict,
    known_s: f64,
    player: Player,
    marks: Marks,
    scenario: Scenario,
    stage: Stage,
    options: ViewOptions,
    instruments: Instruments,
    kind: ViewKind,
    end: Tick,
}

impl Show {
    fn new(prover: Prover, opened: Opened, marks: Marks, options: &ReplayOptions) -> Self {
        let Opened { scenario, map, instruments, end } = opened;
        let mut player = Player::new(end.seconds());
        player.seek(options.at_s);
        Self {
            prover,
            verdict: Verdict::default(),
            known_s: 0.0,
            player,
            marks,
            stage: Stage::with_trees(&map, scenario.seed, scenario.trees as usize),
            options: view_options(&scenario),
            scenario,
            instruments,
            kind: options.kind,
            end,
        }
    }

    /// Looks what the prover has found.
    fn look(&mut self) -> Result<(), AppError> {
        let mut known = self.prover.known();
        if let Some(error) = known.failure.take() {
            return Err(error);
        }
        self.known_s = known.film.end_s();
        self.verdict.clone_from(&known.verdict);
        Ok(())
    }

    fn view(&mut self) -> View {
        let (snapshot, fraction) = self.prover.known().film.at(self.player.time_s);
        let mut view = scene::view(&snapshot, fraction, self.kind, &self.options, &self.stage);
        view.dial = self.kind.has_dial().then(|| self.instruments.read(&snapshot));
        view
    }

    fn obey(&mut self, command: TimelineCommand) {
        match command {
            TimelineCommand::Toggle => self.player.toggle(),
            TimelineCommand::Seek(time_s) => self.player.seek(time_s),
            TimelineCommand::Tick(ticks) => self.player.tick(ticks),
            TimelineCommand::Speed(faster) => self.player.change_speed(faster),
            TimelineCommand::NextView => {
                self.kind = match self.kind {
                    ViewKind::Driver => ViewKind::Chase,
                    ViewKind::Chase => ViewKind::Birdseye,
                    ViewKind::Birdseye => ViewKind::Mirror,
                    ViewKind::Mirror => ViewKind::Driver,
                }
            }
        }
    }

    fn timeline(&self, ui: &mut egui::Ui) -> (Vec<TimelineCommand>, f32) {
        let proof = proof(&self.verdict, self.end.0);
        let state = TimelineState {
            time_s: self.player.time_s,
            end_s: self.player.end_s,
            known_s: self.known_s,
            playing: self.player.playing,
            speed: self.player.speed(),
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
            differs: !self.verdict.is_proven(),
        };
        timeline::show(ui, &state)
    }
}

/// What the proof has found, in words.
fn proof(verdict: &Verdict, all: u64) -> String {
    if let Some([first, more @ ..]) = verdict.changes.as_deref() {
        let others = if more.is_empty() { String::new() } else { format!(" and {} more", more.len()) };
        return format!("changed since it was recorded: {}{others}", first.file);
    }
    if let Some(tick) = verdict.hole {
        return format!("rows are missing from {:.2} s on", tick.seconds());
    }
    match verdict.first_difference {
        Some(tick) => format!("not as recorded from {:.2} s on", Tick(tick).seconds()),
        None if verdict.ticks >= all => format!("proven: all {all} ticks are the same to the bit"),
        None => format!("proven to {:.0} s: the same to the bit", Tick(verdict.ticks).seconds()),
    }
}

/// What a key asks for.
fn command_of(key: KeyCode, shift: bool, player: &Player) -> Option<TimelineCommand> {
    let by = |seconds: f64| TimelineCommand::Tick((seconds / TICK_S) as i64);
    Some(match key {
        KeyCode::Space => TimelineCommand::Toggle,
        KeyCode::ArrowLeft => {
            if shift {
                by(-1.0)
            } else {
                TimelineCommand::Tick(-1)
            }
        }
        KeyCode::ArrowRight => {
            if shift {
                by(1.0)
            } else {
                TimelineCommand::Tick(1)
            }
        }
        KeyCode::PageUp => TimelineCommand::Seek(player.time_s - 10.0),
        KeyCode::PageDown => TimelineCommand::Seek(player.time_s + 10.0),
        KeyCode::Home => TimelineCommand::Seek(0.0),
        KeyCode::End => TimelineCommand::Seek(player.end_s),
        KeyCode::ArrowUp => TimelineCommand::Speed(true),
        KeyCode::ArrowDown => TimelineCommand::Speed(false),
        KeyCode::KeyV => TimelineCommand::NextView,
        _ => return None,
    })
}

/// Keys of the window, and what they do.
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

/// The window.
struct Frame<'a> {
    show: &'a mut Show,
    picture: PictureWindow,
    last: Instant,
    modifiers: ModifiersState,
    help_open: bool,
}

impl<'a> Windows for Frame<'a> {
    type Parts = &'a mut Show;

    fn open(event_loop: &ActiveEventLoop, show: &'a mut Show) -> Result<Self, AppError> {
        let title = format!("codrive replay: {}", show.scenario.map);
        let mut picture = PictureWindow::open(event_loop, &Placing { title, ..Placing::default() })?;
        theme::apply(picture.ctx());
        let view = show.view();
        picture.stage(&show.stage, &view, show.scenario.quality)?;
        Ok(Self { show, picture, last: now(), modifiers: ModifiersState::default(), help_open: false })
    }

    fn hear(&mut self, _: WindowId, event: WindowEvent) -> Result<Next, AppError> {
        self.picture.on_event(&event);
        match event {
            WindowEvent::CloseRequested => return Ok(Next::End),
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } => return Ok(self.key(&event)),
            WindowEvent::RedrawRequested => self.draw()?,
            _ => {}
        }
        Ok(Next::GoOn)
    }

    fn first(&self) -> &Window {
        self.picture.window()
    }
}

impl Frame<'_> {
    fn key(&mut self, event: &KeyEvent) -> Next {
        let PhysicalKey::Code(code) = event.physical_key else { return Next::GoOn };
        if event.state != ElementState::Pressed {
            return Next::GoOn;
        }
        match code {
            KeyCode::KeyQ if self.modifiers.control_key() || self.modifiers.super_key() => return Next::End,
            KeyCode::Escape if !std::mem::take(&mut self.help_open) => return Next::End,
            KeyCode::F1 => self.help_open = !self.help_open,
            KeyCode::F11 => self.picture.toggle_fullscreen(),
            code => {
                let asked = command_of(code, self.modifiers.shift_key(), &self.show.player);
                if let Some(command) = asked {
                    self.show.obey(command);
                }
            }
        }
        Next::GoOn
    }

    fn draw(&mut self) -> Result<(), AppError> {
        let Self { show, picture, last, help_open, .. } = self;
        let begin = now();
        let elapsed_s = (begin - *last).as_secs_f64();
        *last = begin;
        show.look()?;
        show.player.advance(elapsed_s, show.known_s);
        let view = show.view();
        let (mut asked, mut foot) = (Vec::new(), 0.0);
        let output = picture.overlay(|ui| {
            let (commands, height) = show.timeline(ui);
            asked.extend(commands);
            foot = height;
            if *help_open {
                key_list(ui.ctx(), &KEYS);
            }
        });
        picture.leave_foot((foot * output.pixels_per_point).round() as u32);
        picture.draw(Some(&view), Some(output));
        asked.into_iter().for_each(|command| show.obey(command));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::Change;

    #[test]
    fn the_proof_is_said_as_far_as_it_goes() {
        let verdict = |ticks, first_difference| Verdict { ticks, first_difference, ..Verdict::default() };
        assert_eq!(proof(&verdict(1200, None), 3000), "proven to 12 s: the same to the bit");
        assert_eq!(proof(&verdict(3000, None), 3000), "proven: all 3000 ticks are the same to the bit");
        assert_eq!(proof(&verdict(3000, Some(250)), 3000), "not as recorded from 2.50 s on");
        let change = |file: &str| Change { file: file.into(), what: String::new() };
        let changes = Some(vec![change("ego.parquet"), change("manifest.json")]);
        let changed = Verdict { changes, ..verdict(3000, None) };
        assert_eq!(proof(&changed, 3000), "changed since it was recorded: ego.parquet and 1 more");
        let cut = Verdict { hole: Some(Tick(51)), ..verdict(50, None) };
        assert_eq!(proof(&cut, 3000), "rows are missing from 0.51 s on");
    }

    #[test]
    fn keys_go_by_ticks_seconds_and_to_the_ends() {
        let mut player = Player::new(60.0);
        player.seek(20.0);
        let asked = |key, shift| command_of(key, shift, &player);
        assert_eq!(asked(KeyCode::ArrowLeft, false), Some(TimelineCommand::Tick(-1)));
        assert_eq!(asked(KeyCode::ArrowRight, true), Some(TimelineCommand::Tick(100)));
        assert_eq!(asked(KeyCode::PageUp, false), Some(TimelineCommand::Seek(10.0)));
        assert_eq!(asked(KeyCode::End, false), Some(TimelineCommand::Seek(60.0)));
        assert_eq!(asked(KeyCode::KeyQ, false), None);
    }
}
