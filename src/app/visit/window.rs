//! The two windows of a visit: the participant's, with screens and the picture of the drive, and the experimenter's. In:
//! events of winit, Ctrl-C, the clock. Out: frames. The participant's window knows driving keys, those of its screens, F1 for
//! the list of both and F11 for the whole screen; closing it, or the experimenter's, breaks off the visit, and the same command goes on there.

use super::{
    Road, Visit, baselines,
    baselines::Making,
    lead::Lead,
    road::{Kit, Live},
};
use crate::{
    app::{
        AppError,
        display::{self, Place},
        facts,
        host::{ExperimenterWindow, PictureWindow, Placing},
        keys::{self, Command},
        shell::{self, Next, Windows, now},
    },
    input::{Devices, Profile},
    panel::{ScreenState, Screens, VisitCommand, contact_flash, experimenter::WheelHealth, key_list, theme},
    record,
    study::{
        Code, Completion, DataSet, Input, Session, SessionError, Study, lock,
        session::{self, Log, Who},
    },
};
use std::{
    io::Write,
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};
use winit::{
    event::{ElementState, KeyEvent, WindowEvent},
    event_loop::ActiveEventLoop,
    keyboard::PhysicalKey,
    window::{Window, WindowId},
};

/// What `codrive study --participant` was asked for.
pub struct VisitOptions {
    /// The study.
    pub study: Study,
    /// Folder of its data set.
    pub out: PathBuf,
    /// Who takes part.
    pub code: Code,
    /// Where the participant's window opens, and whether it fills the screen at once.
    pub place: Place,
    /// Profile of the wheel; `None` takes the one for the wheel that is found.
    pub wheel: Option<Profile>,
    /// Becomes true when the program is to end (Ctrl-C).
    pub stop: Arc<AtomicBool>,
}

/// How a visit was left.
#[derive(Clone, Debug, PartialEq)]
pub enum Left {
    /// It is over.
    Over(Completion),
    /// Something is left to do: the next item's name.
    Open(String),
}

/// Leads a participant through the plan, from where they are to its end or until a window is closed.
///
/// # Errors
/// No display or graphics adapter; a participant who has been through, is being run elsewhere, or whose files cannot be
/// read; a full disk. What was done is kept.
pub fn run(options: VisitOptions) -> Result<Left, AppError> {
    if options.out.exists() {
        // What is refused is refused without a display too, and before anything is made.
        look_ahead(&options, &DataSet::open(&options.out, &options.study)?)?;
    }
    let event_loop = shell::event_loop()?;
    let data = DataSet::open(&options.out, &options.study)?;
    let session = open_session(&options, &data)?;
    let kit = Kit::new(Devices::open_with(options.wheel.clone()), &options.code);
    let (frame, ended) = shell::run::<Frame>(event_loop, (&options, session, kit), &options.stop);
    let left = frame.map(|mut frame| frame.leave(&data, &options)).transpose();
    ended?;
    Ok(left?.unwrap_or_else(|| Left::Open("the first screen".into())))
}

fn open_session(options: &VisitOptions, data: &DataSet) -> Result<Session, AppError> {
    let index = data.next_index()?;
    Ok(Session::open(data, &options.study, &options.code, Who::Person, index, &facts::now())?)
}

/// A rehearsal's folder is no place for people; a visit that is over may lack baselines, since its window was closed while
/// they were driven, and is not run again.
fn look_ahead(options: &VisitOptions, data: &DataSet) -> Result<(), AppError> {
    if let Some(log) = data.logs()?.iter().find(|log| log.who == Who::Simulated) {
        return Err(SessionError::Refused(format!(
            "{} holds a rehearsal ({}); people take part in a folder of its own",
            data.root().display(),
            log.participant
        ))
        .into());
    }
    let folder = data.source(&options.code);
    let path = folder.join(session::FILE);
    if !path.exists() || Log::load(&path)?.end.is_none() {
        return Ok(());
    }
    let lock = lock::lock(&folder, &options.code)?;
    let made = baselines::make_up(data, &options.study, &options.code, &options.stop, &|_| ())?;
    if made > 0 {
        let were = if made == 1 { "baseline was" } else { "baselines were" };
        let text = format!("{made} missing {were} made for participant {}", options.code);
        // A visit goes on where nobody reads that.
        let _ = writeln!(std::io::stdout(), "{text}");
    }
    drop(lock);
    open_session(options, data).map(drop)
}

/// A visit in its windows.
struct Frame<'a> {
    options: &'a VisitOptions,
    picture: PictureWindow,
    experimenter: ExperimenterWindow,
    visit: Visit,
    kit: Kit,
    screens: Screens,
    lead: Lead,
    making: Option<Making>,
    /// Baselines have been made, or there were none to make.
    made: bool,
    data: DataSet,
    /// Why the experimenter closes the windows of a visit that is not over.
    reason: Option<String>,
    /// The participant reads the list of keys.
    help_open: bool,
    /// When the last frame began; `None` after something that took long and is no part of a drive.
    last: Option<Instant>,
    /// When the drive began, and when rows last went to the disk.
    first: Instant,
    flushed: Instant,
}

impl<'a> Windows for Frame<'a> {
    type Parts = (&'a VisitOptions, Session, Kit);

    fn open(event_loop: &ActiveEventLoop, (options, session, kit): Self::Parts) -> Result<Self, AppError> {
        let place = display::beside_experimenter(options.place, event_loop);
        let placing = Placing { title: format!("codrive: {}", options.study.file.title), place };
        let mut picture = PictureWindow::open(event_loop, &placing)?;
        theme::apply(picture.ctx());
        picture.keep_miniature();
        let title = format!("Experimenter: {}, {}", options.code, options.study.file.title);
        let experimenter = ExperimenterWindow::open(event_loop, picture.gpu(), picture.window(), &title)?;
        if let Some(font) = &options.study.font {
            theme::add_font(picture.ctx(), font);
            theme::add_font(experimenter.ctx(), font);
        }
        let start = now();
        Ok(Self {
            options,
            picture,
            experimenter,
            visit: Visit::new(&options.study, session, facts::now)?,
            kit,
            screens: Screens::default(),
            lead: Lead::new(&options.study),
            making: None,
            made: false,
            data: DataSet::open(&options.out, &options.study)?,
            reason: None,
            help_open: false,
            last: None,
            first: start,
            flushed: start,
        })
    }

    fn hear(&mut self, id: WindowId, event: WindowEvent) -> Result<Next, AppError> {
        if event == WindowEvent::CloseRequested {
            return Ok(Next::End);
        }
        if self.experimenter.id() == id {
            self.experimenter.on_event(self.picture.gpu(), &event);
            return Ok(Next::GoOn);
        }
        self.picture.on_event(&event);
        match event {
            WindowEvent::Focused(false) => self.release_keys(),
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } => self.key(&event),
            WindowEvent::RedrawRequested => return self.draw(),
            _ => {}
        }
        Ok(Next::GoOn)
    }

    fn first(&self) -> &Window {
        self.picture.window()
    }
}

impl Frame<'_> {
    /// One frame: devices and drive, what the participant does, the picture, what the experimenter decides. The end
    /// when the experimenter closes the visit.
    fn draw(&mut self) -> Result<Next, AppError> {
        let elapsed = self.lap();
        let Self { kit, lead, .. } = self;
        let (due, inputs) = match kit.frame(elapsed, |world| lead.watch(world)) {
            Ok(done) => done,
            Err(error) => {
                self.on_road(|visit, road| visit.fail(&error, road));
                Default::default()
            }
        };
        for input in inputs {
            self.on_road(|visit, road| visit.input(input, road))?;
        }
        for words in self.kit.take_contacts() {
            self.visit.note_contact(&words)?;
        }
        let (drove, prepared) = (self.visit.drives(), self.kit.show.is_some());
        self.on_road(|visit, road| visit.tick(elapsed, road))?;
        if let (Some(show), false) = (&self.kit.show, prepared) {
            self.lead.drive_begins(show);
            // What was loaded took long, and no timer counts it.
            self.last = None;
        }
        if drove != self.visit.drives() {
            self.picture.window().set_cursor_visible(drove);
            self.release_keys();
        }
        for input in self.draw_picture(elapsed, due) {
            self.on_road(|visit, road| visit.input(input, road))?;
        }
        if let (true, Some(show)) = (now() - self.flushed > record::FLUSH_EVERY, &mut self.kit.show) {
            self.flushed = now();
            if let Err(error) = show.flush() {
                self.on_road(|visit, road| visit.fail(&error, road));
            }
        }
        self.after_the_visit()?;
        for command in self.draw_experimenter() {
            match command {
                VisitCommand::Close => return Ok(if self.visit.is_over() { Next::End } else { Next::GoOn }),
                VisitCommand::Interrupt(reason) => {
                    self.reason = Some(reason);
                    return Ok(Next::End);
                }
                _ => {}
            }
            self.on_road(|visit, road| visit.command(command, road))?;
        }
        Ok(Next::GoOn)
    }

    /// Something that the visit does with its road.
    fn on_road<T>(&mut self, act: impl FnOnce(&mut Visit, &mut dyn Road) -> T) -> T {
        let Self { picture, kit, visit, .. } = self;
        act(visit, &mut Live { picture, kit })
    }

    /// The participant's window. Returns what keys and mouse did there.
    fn draw_picture(&mut self, elapsed: Duration, due: crate::time::Due) -> Vec<Input> {
        let now_there = self.on_road(|_, road| road.now());
        let Self { picture, kit, visit, screens, lead, options, first, help_open, .. } = self;
        let state = ScreenState {
            screen: visit.screen(now_there),
            texts: &options.study.file.texts,
            progress: visit.progress(),
            wheel: kit.wheel(),
        };
        let mut inputs = Vec::new();
        let flash = kit.show.as_ref().map_or(0.0, |show| show.contacts().flash());
        let output = picture.overlay(|ui| {
            // Esc closes the list before it asks to stop.
            if *help_open && ui.input_mut(|input| input.consume_key(egui::Modifiers::NONE, egui::Key::Escape)) {
                *help_open = false;
            }
            inputs.extend(screens.show(ui, &state));
            contact_flash(ui, flash);
            if *help_open {
                key_list(ui.ctx(), &keys::list_of_participant());
            }
        });
        let over_picture = state.screen.is_over_picture();
        let view = kit.show.as_mut().filter(|_| over_picture).map(|show| show.view());
        let drawn = picture.draw(view.as_ref(), Some(output));
        let done = now();
        if now_there.time_s == 0.0 {
            *first = done;
        }
        let Some(show) = kit.show.as_mut().filter(|_| drawn) else { return inputs };
        show.shown(done - *first, elapsed, &due);
        lead.frame(elapsed, &due);
        inputs
    }

    /// The experimenter's window, when it is due.
    fn draw_experimenter(&mut self) -> Vec<VisitCommand> {
        let now_there = self.on_road(|_, road| road.now());
        for news in self.kit.take_news() {
            self.lead.say(now_there, &news);
        }
        let Self { picture, experimenter, visit, kit, lead, making, made, data, .. } = self;
        if !experimenter.due() {
            return Vec::new();
        }
        let seen = picture.miniature().map(|view| {
            let texture = view.texture();
            (experimenter.picture(picture.gpu(), view), [texture.width(), texture.height()])
        });
        let done = made.then(|| format!("All data saved. Analyse it with: codrive analyse {}", data.root().display()));
        let wheel = match kit.devices().and_then(|devices| devices.wheel_profile()) {
            Some(profile) => WheelHealth::There(profile.name.clone()),
            None => WheelHealth::None,
        };
        let work = making.as_ref().map(Making::words).or(done);
        let mut commands = Vec::new();
        experimenter.draw(picture.gpu(), |ui| {
            commands.extend(lead.show(ui, visit, kit.show.as_ref(), now_there, &wheel, work.as_deref(), seen));
        });
        commands
    }

    /// When the visit is over: the data set's tables, then baselines on their thread, then the tables once more.
    fn after_the_visit(&mut self) -> Result<(), AppError> {
        if !self.visit.is_over() || self.made {
            return Ok(());
        }
        let code = self.visit.session().log().participant.clone();
        let busy = match &mut self.making {
            Some(making) if making.is_busy() => true,
            Some(making) => {
                let whole = making.finish(false);
                if let Err(error) = whole {
                    self.lead.say(super::RoadNow::default(), &format!("a baseline could not be driven: {error}"));
                }
                false
            }
            None => {
                let session = self.visit.session();
                let trials = baselines::missing(session.folder(), session.plan(), session.log());
                let any = !trials.is_empty();
                if any {
                    self.making = Some(Making::begin(&code, trials)?);
                }
                any
            }
        };
        if !busy {
            (self.made, self.making) = (true, None);
            self.data.publish(&self.options.study, &code)?;
        }
        Ok(())
    }

    /// The windows close: what runs is broken off, and comes again with the same command.
    fn leave(&mut self, data: &DataSet, options: &VisitOptions) -> Result<Left, AppError> {
        let stopped = options.stop.load(Ordering::Relaxed);
        let usual = if stopped { "stopped by Ctrl-C" } else { "the window was closed" };
        let reason = self.reason.take().unwrap_or_else(|| usual.into());
        self.on_road(|visit, road| visit.close(&reason, road))?;
        if let Some(making) = &mut self.making {
            making.finish(true)?;
        }
        data.publish(&options.study, &options.code)?;
        let log = self.visit.session().log();
        Ok(match (&log.end, self.visit.session().next()) {
            (Some(_), _) => Left::Over(Completion::of(log)),
            (None, next) => Left::Open(next.map_or_else(String::new, |(_, planned)| planned.name.clone())),
        })
    }

    /// Time since the last frame.
    fn lap(&mut self) -> Duration {
        let begin = now();
        self.last.replace(begin).map_or(Duration::ZERO, |before| begin - before)
    }

    fn release_keys(&mut self) {
        if let Some(devices) = self.kit.devices() {
            devices.keyboard.release_all();
        }
    }

    /// A key of the participant's window; screens hear theirs through egui.
    fn key(&mut self, event: &KeyEvent) {
        let PhysicalKey::Code(code) = event.physical_key else { return };
        let down = event.state == ElementState::Pressed;
        let drives = self.visit.drives();
        if let (Some(key), Some(devices)) = (keys::driving(code), self.kit.devices()) {
            devices.keyboard.set(key, down && drives);
        }
        match keys::command(code).filter(|_| down && !event.repeat) {
            Some(Command::Help) => self.help_open = !self.help_open,
            Some(Command::FullScreen) => self.picture.toggle_fullscreen(),
            Some(Command::Reverse) if drives => {
                if let Some(devices) = self.kit.devices() {
                    devices.keyboard.toggle_reverse();
                }
            }
            Some(Command::PutBack) if drives => {
                if let Some(show) = &mut self.kit.show {
                    show.put_back();
                }
            }
            _ => {}
        }
    }
}
