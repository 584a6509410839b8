//! The windows of a session: the participant's, with screens and the picture of the drive, the experimenter's, and that of a secondary task if a
//! drive has one. In: winit events, Ctrl-C, the clock. Out: frames. The participant's window takes driving keys, the keys of its screens, F1 for
//! the list of both, and F11 for full screen. Closing a window interrupts the session; the same command resumes it.

use super::{
    DriveBackend, LiveSession,
    admission::{check_frame_rate, look_ahead, open_session, scenarios},
    command::DRAFT,
    drives::{SessionResources, WindowBackend},
    experimenter_view::ExperimenterView,
    voice::VoiceOrder,
};
use crate::{
    audio::Voice,
    desktop::{
        DriverWindow, ExperimenterWindow, TaskWindow, WindowSetup,
        display::{self, WindowPlacement},
        event_loop::{self, LoopControl, Windows, now},
        keys::{self, KeyCommand},
    },
    drive_loop::{
        RunError,
        baselines::{self, BaselineJob},
        recording_manifest,
    },
    input::{Devices, WheelProfile},
    live_drive::{
        LiveDrive,
        lab::{LabDevices, LabSettings},
    },
    panel::{
        ScreenPainter, ScreenState, SessionCommand, contact_flash, experimenter::WheelHealth, key_list, room_sign,
        theme,
    },
    record,
    snapshot::TaskPicture,
    study::{Completion, DataSet, FormInput, ParticipantCode, Session, Study, session::SessionLog},
};
use std::{
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
    keyboard::{KeyCode, PhysicalKey},
    window::{Window, WindowId},
};

/// Options of `codrive study session`.
pub struct SessionOptions {
    /// Study of the session.
    pub study: Study,
    /// Folder of the data set.
    pub out: PathBuf,
    /// Code of the participant.
    pub code: ParticipantCode,
    /// Monitor and mode of the participant's window at the start.
    pub place: WindowPlacement,
    /// Placement of the window of a secondary task with a display of its own.
    pub task_place: WindowPlacement,
    /// Profile of the wheel; `None` selects one by the wheel that is found.
    pub wheel: Option<WheelProfile>,
    /// Folder of the LED for signals of the detection response task; `None` for the wheel's rev lamps.
    pub led: Option<PathBuf>,
    /// Set to true to end the program (Ctrl-C).
    pub stop: Arc<AtomicBool>,
}

/// State in which a session was left.
#[derive(Clone, Debug, PartialEq)]
pub enum SessionOutcome {
    /// The session is over.
    Over(Completion),
    /// The session can be resumed; the name of its next item.
    Open(String),
}

/// Runs a participant's session from its present item to its end or until a window is closed.
///
/// # Errors
/// There is no display or graphics adapter. The participant has finished, is run elsewhere, or their files cannot be read. The disk is
/// full. Completed items are kept in all cases.
pub fn run(options: SessionOptions) -> Result<SessionOutcome, RunError> {
    if options.out.exists() {
        // Checks for refusals before a display is needed and before any file is made.
        look_ahead(&options, &DataSet::open(&options.out, &options.study)?)?;
    }
    // No file is written for a session if the lab devices are not ready.
    let lab = LabDevices::open(&LabSettings::of(&options.study.file))?;
    let event_loop = event_loop::event_loop()?;
    let data = DataSet::open(&options.out, &options.study)?;
    let session = open_session(&options, &data)?;
    let devices = Devices::open_with(options.wheel.clone()).with_led(options.led.as_deref());
    let mut resources = SessionResources::new(devices, &options.code).with_room(options.study.file.record_room);
    resources.lab = lab;
    let (frame, ended) = event_loop::run::<SessionWindows>(event_loop, (&options, session, resources), &options.stop);
    let left = frame.map(|mut frame| frame.leave(&data, &options)).transpose();
    ended?;
    Ok(left?.unwrap_or_else(|| SessionOutcome::Open("the first screen".into())))
}

/// A session with its windows.
struct SessionWindows<'a> {
    options: &'a SessionOptions,
    picture: DriverWindow,
    experimenter: ExperimenterWindow,
    /// Window of the secondary task, open during the whole session if a drive has one.
    task: Option<TaskWindow>,
    live_session: LiveSession,
    resources: SessionResources,
    screens: ScreenPainter,
    experimenter_view: ExperimenterView,
    /// Playback of spoken instructions.
    voice: Option<Voice>,
    making: Option<BaselineJob>,
    /// Log that the data set was last published with; `None` before all baselines are made.
    published: Option<SessionLog>,
    data: DataSet,
    /// Reason given by the experimenter for closing the windows of a session that is not over.
    reason: Option<String>,
    /// True while the list of keys is shown to the participant.
    help_open: bool,
    /// Start of the last frame; `None` after a long operation that must not count as time of a drive.
    last: Option<Instant>,
    /// Start of the drive, and last time that rows were written to disk.
    first: Instant,
    flushed: Instant,
}

impl<'a> Windows for SessionWindows<'a> {
    type WindowParts = (&'a SessionOptions, Session, SessionResources);

    fn open(
        event_loop: &ActiveEventLoop,
        (options, mut session, mut resources): Self::WindowParts,
    ) -> Result<Self, RunError> {
        let place = display::beside_experimenter(options.place, event_loop);
        let placing = WindowSetup { title: format!("codrive: {}", options.study.file.title), place };
        let mut picture = DriverWindow::open(event_loop, &placing)?;
        theme::apply(picture.ctx());
        check_frame_rate(&options.study, &mut session, &picture)?;
        picture.keep_preview();
        let title = format!("Experimenter: {}, {}", options.code, options.study.file.title);
        let experimenter = ExperimenterWindow::open(event_loop, picture.gpu(), picture.window(), &title)?;
        let has_task = scenarios(&session).any(|scenario| scenario.secondary_task.has_window());
        let task = has_task.then(|| TaskWindow::open(event_loop, picture.gpu(), picture.window(), options.task_place));
        let task = task.transpose()?;
        resources.has_task_window = task.is_some();
        if let Some(font) = &options.study.font {
            theme::add_font(picture.ctx(), font);
            theme::add_font(experimenter.ctx(), font);
        }
        let mut experimenter_view = ExperimenterView::new(&options.study);
        if let Some(note) = session.log().notes.last().filter(|note| note.kind == DRAFT) {
            experimenter_view.restore(&note.text);
        }
        let start = now();
        Ok(Self {
            options,
            picture,
            experimenter,
            task,
            live_session: LiveSession::new(&options.study, session, recording_manifest::now)?,
            resources,
            screens: ScreenPainter::default(),
            experimenter_view,
            voice: None,
            making: None,
            published: None,
            data: DataSet::open(&options.out, &options.study)?,
            reason: None,
            help_open: false,
            last: None,
            first: start,
            flushed: start,
        })
    }

    fn handle_event(&mut self, id: WindowId, event: WindowEvent) -> Result<LoopControl, RunError> {
        if event == WindowEvent::CloseRequested {
            return Ok(if self.may_end() { LoopControl::End } else { LoopControl::GoOn });
        }
        if self.experimenter.id() == id {
            self.experimenter.on_event(self.picture.gpu(), &event);
            return Ok(LoopControl::GoOn);
        }
        let is_of_task = self.task.as_ref().is_some_and(|window| window.id() == id);
        match &mut self.task {
            Some(task) if is_of_task => task.on_event(self.picture.gpu(), &event),
            _ => drop(self.picture.on_event(&event)),
        }
        match event {
            WindowEvent::Focused(false) => self.release_keys(),
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } => self.key(&event, is_of_task)?,
            WindowEvent::RedrawRequested if !is_of_task => return self.draw(),
            _ => {}
        }
        Ok(LoopControl::GoOn)
    }

    fn first(&self) -> &Window {
        self.picture.window()
    }

    fn may_end(&mut self) -> bool {
        self.live_session.may_close()
    }
}

impl SessionWindows<'_> {
    /// Runs one frame: the experimenter's commands, devices and drive, the participant's input, the picture. A command that holds the drive
    /// therefore acts before the frame moves. Returns the end of the loop when the experimenter closes the session.
    fn draw(&mut self) -> Result<LoopControl, RunError> {
        for command in self.draw_experimenter() {
            match command {
                SessionCommand::Close if !self.live_session.is_over() => {}
                SessionCommand::Close | SessionCommand::Interrupt(_) if !self.may_end() => {}
                SessionCommand::Close => return Ok(LoopControl::End),
                SessionCommand::Interrupt(reason) => {
                    self.reason = Some(reason);
                    return Ok(LoopControl::End);
                }
                command => self.on_backend(|live_session, backend| live_session.command(command, backend))?,
            }
        }
        let elapsed = self.lap();
        let Self { resources, experimenter_view, .. } = self;
        let (due, inputs) = match resources.frame(elapsed, |world| experimenter_view.watch(world)) {
            Ok(done) => done,
            Err(error) => {
                self.on_backend(|live_session, backend| live_session.fail(&error, backend));
                Default::default()
            }
        };
        for input in inputs {
            self.on_backend(|live_session, backend| live_session.input(input, backend))?;
        }
        for words in self.resources.take_contacts() {
            self.on_backend(|live_session, backend| live_session.note_contact(&words, backend))?;
        }
        self.speak();
        if self.live_session.has_consent() {
            self.resources.lab.open_outlets()?;
        }
        let (drove, prepared) = (self.live_session.drives(), self.resources.live.is_some());
        self.on_backend(|live_session, backend| live_session.tick(elapsed, backend))?;
        if let (Some(live), false) = (&self.resources.live, prepared) {
            self.experimenter_view.drive_begins(live);
            // Loading took long; that time must not count.
            self.last = None;
        }
        if drove != self.live_session.drives() {
            self.picture.window().set_cursor_visible(drove);
            self.release_keys();
        }
        for input in self.draw_picture(elapsed, due) {
            self.on_backend(|live_session, backend| live_session.input(input, backend))?;
        }
        if let (true, Some(live)) = (now() - self.flushed > record::FLUSH_EVERY, &mut self.resources.live) {
            self.flushed = now();
            if let Err(error) = live.flush() {
                self.on_backend(|live_session, backend| live_session.fail(&error, backend));
            }
        }
        self.after_the_session()?;
        Ok(LoopControl::GoOn)
    }

    /// Carries out the session's voice order, and reports the playback status to the session.
    fn speak(&mut self) {
        match self.live_session.take_voice_order() {
            Some(VoiceOrder::Play(text)) => {
                // The previous playback must release the device first.
                self.voice = None;
                self.voice = Some(Voice::play(text.wav));
            }
            Some(VoiceOrder::Stop) => self.voice = None,
            None => {}
        }
        let Some(status) = self.voice.as_ref().map(Voice::status) else { return };
        if let Some(warning) = self.live_session.hear_voice(status) {
            self.experimenter_view.add_note(super::BackendStatus::default(), &warning);
        }
    }

    /// Runs an action on the session with the window's drive backend.
    fn on_backend<T>(&mut self, act: impl FnOnce(&mut LiveSession, &mut dyn DriveBackend) -> T) -> T {
        let Self { picture, resources, live_session, .. } = self;
        act(live_session, &mut WindowBackend { picture, resources })
    }

    /// Draws the participant's window. Returns the input from its keys and mouse.
    fn draw_picture(&mut self, elapsed: Duration, due: crate::time::DueTicks) -> Vec<FormInput> {
        let now_there = self.on_backend(|_, backend| backend.now());
        let Self { picture, task, resources, live_session, screens, experimenter_view, .. } = self;
        let (options, first, help_open) = (self.options, &mut self.first, &mut self.help_open);
        let state = ScreenState {
            screen: live_session.screen(now_there),
            texts: &options.study.file.texts,
            progress: live_session.progress(),
            source: resources.source(),
            spoken: live_session.is_spoken(),
        };
        let room = resources.hears_room().then_some(options.study.file.texts.room.as_str());
        let mut inputs = Vec::new();
        let flash = resources.live.as_ref().map_or(0.0, |live| live.contacts().flash());
        let output = picture.overlay(|ui| {
            // Esc closes the list of keys before it counts as a request to stop.
            if *help_open && ui.input_mut(|input| input.consume_key(egui::Modifiers::NONE, egui::Key::Escape)) {
                *help_open = false;
            }
            inputs.extend(screens.show(ui, &state));
            contact_flash(ui, flash);
            room_sign(ui, room);
            if *help_open {
                key_list(ui.ctx(), &keys::list_of_participant());
            }
        });
        let over_picture = state.screen.is_over_picture();
        let view = resources.live.as_mut().filter(|_| over_picture).map(|live| live.view());
        let drawn = picture.draw(view.as_ref(), Some(output));
        if let Some(task) = task {
            let live = resources.live.as_ref().filter(|_| over_picture);
            task.draw(picture.gpu(), live.map_or(TaskPicture::None, LiveDrive::task_beside));
        }
        let done = now();
        if now_there.time_s == 0.0 {
            *first = done;
        }
        let Some(live) = resources.live.as_mut().filter(|_| drawn) else { return inputs };
        live.shown(done - *first, elapsed, &due);
        experimenter_view.frame(elapsed, &due);
        inputs
    }

    /// Draws the experimenter's window if it is due. Returns the experimenter's commands.
    fn draw_experimenter(&mut self) -> Vec<SessionCommand> {
        let now_there = self.on_backend(|_, backend| backend.now());
        for news in self.resources.take_news() {
            self.experimenter_view.add_note(now_there, &news);
        }
        let Self { picture, experimenter, live_session, resources, experimenter_view, making, published, data, .. } =
            self;
        if !experimenter.due() {
            return Vec::new();
        }
        let seen = picture.preview().map(|view| {
            let texture = view.texture();
            (experimenter.picture(picture.gpu(), view), [texture.width(), texture.height()])
        });
        let done = published
            .as_ref()
            .map(|_| format!("All data saved. Analyse it with: codrive analyse {}", data.root().display()));
        let wheel = match resources.devices().and_then(|devices| devices.wheel_profile()) {
            Some(profile) => WheelHealth::There(profile.name.clone()),
            None => WheelHealth::None,
        };
        let hears_room = resources.hears_room();
        let work = making.as_ref().map(BaselineJob::progress_text).or(done);
        let mut commands = Vec::new();
        experimenter.draw(picture.gpu(), |ui| {
            commands.extend(experimenter_view.show(
                ui,
                live_session,
                resources.live.as_ref(),
                now_there,
                &wheel,
                work.as_deref(),
                seen,
            ));
            room_sign(ui, hears_room.then_some("THE ROOM IS RECORDED"));
        });
        commands
    }

    /// Finishes a session that is over: drives missing baselines on a thread, then publishes the tables of the data set.
    fn after_the_session(&mut self) -> Result<(), RunError> {
        let log = self.live_session.session().log();
        let is_waiting = !self.live_session.is_over() || self.live_session.waits_for_disk();
        // A note, a mark or an exclusion may still come, and changes the log.
        if is_waiting || self.published.as_ref() == Some(log) {
            return Ok(());
        }
        let code = log.participant.clone();
        let busy = match &mut self.making {
            _ if self.published.is_some() => false,
            Some(making) if making.is_busy() => true,
            Some(making) => {
                let whole = making.finish(false);
                if let Err(error) = whole {
                    self.experimenter_view
                        .add_note(super::BackendStatus::default(), &format!("a baseline could not be driven: {error}"));
                }
                false
            }
            None => {
                let session = self.live_session.session();
                let trials = baselines::missing(session.folder(), session.plan(), session.log());
                let any = !trials.is_empty();
                if any {
                    self.making = Some(BaselineJob::begin(&code, trials)?);
                }
                any
            }
        };
        if !busy {
            self.making = None;
            self.data.publish(&self.options.study, &code)?;
            self.published = Some(self.live_session.session().log().clone());
        }
        Ok(())
    }

    /// Closes the session with the windows. A running item is interrupted and comes again with the same command.
    fn leave(&mut self, data: &DataSet, options: &SessionOptions) -> Result<SessionOutcome, RunError> {
        let stopped = options.stop.load(Ordering::Relaxed);
        let usual = if stopped { "stopped by Ctrl-C" } else { "the window was closed" };
        let reason = self.reason.take().unwrap_or_else(|| usual.into());
        if let Some(words) = self.experimenter_view.take_words() {
            let draft = SessionCommand::Draft(words);
            self.on_backend(|live_session, backend| live_session.command(draft, backend))?;
        }
        self.on_backend(|live_session, backend| live_session.close(&reason, backend))?;
        let made = self.making.as_mut().map_or(Ok(0), |making| making.finish(true));
        // Lists also the baselines that were made before an error.
        data.publish(&options.study, &options.code)?;
        made?;
        let log = self.live_session.session().log();
        Ok(match (&log.end, self.live_session.session().next()) {
            (Some(_), _) => SessionOutcome::Over(Completion::of(log)),
            (None, next) => SessionOutcome::Open(next.map_or_else(String::new, |(_, planned)| planned.name.clone())),
        })
    }

    /// Returns the time since the last frame, and starts the next.
    fn lap(&mut self) -> Duration {
        let begin = now();
        self.last.replace(begin).map_or(Duration::ZERO, |before| begin - before)
    }

    fn release_keys(&mut self) {
        if let Some(devices) = self.resources.devices() {
            devices.keyboard.release_all();
        }
    }

    /// Handles a key of the participant's window or of the secondary task's; screens receive their keys through egui.
    ///
    /// # Errors
    /// The drive cannot go on.
    fn key(&mut self, event: &KeyEvent, is_of_task: bool) -> Result<(), RunError> {
        let PhysicalKey::Code(code) = event.physical_key else { return Ok(()) };
        let down = event.state == ElementState::Pressed;
        let drives = self.live_session.drives();
        if let (Some(key), Some(devices)) = (keys::driving(code), self.resources.devices()) {
            devices.keyboard.set(key, down && drives);
        }
        if code == KeyCode::Escape && down && drives && !self.help_open {
            // At the key: the screens read it after the next frame has moved.
            self.on_backend(|live_session, backend| live_session.input(FormInput::Stop, backend))?;
        }
        match keys::command(code).filter(|_| down && !event.repeat) {
            Some(KeyCommand::Help) => self.help_open = !self.help_open,
            Some(KeyCommand::FullScreen) if is_of_task => {}
            Some(KeyCommand::FullScreen) => self.picture.toggle_fullscreen(),
            Some(KeyCommand::PutBack) if drives => {
                if let Some(live) = &mut self.resources.live {
                    live.put_back();
                }
            }
            Some(command) if drives => {
                if let Some(devices) = self.resources.devices() {
                    command.apply_to(devices);
                }
            }
            _ => {}
        }
        Ok(())
    }
}
