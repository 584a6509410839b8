//! The driver's window, and the experimenter's beside it. In: events of winit, Ctrl-C. Out: frames on the screen.
//! `DriveWindows::draw` is one turn of the loop (docs/decisions.md: 1); everything that needs no window is in
//! [`LiveDrive`] and [`DriveOverlay`].

mod end_card;
pub mod overlay;
mod recordings;

use self::{overlay::DriveOverlay, recordings::RecordingFolders};
use crate::{
    desktop::{
        DriverWindow, ExperimenterWindow, TaskWindow, WindowSetup,
        display::{self, WindowPlacement},
        event_loop::{self, LoopControl, Windows, now},
        keys::{self, KeyCommand},
    },
    drive_loop::RunError,
    input::{Devices, DriveKey, WheelProfile},
    live_drive::{
        LiveDrive,
        lab::{LabDevices, LabSettings},
        start::PATIENCE,
    },
    panel::{experimenter::ExperimenterCommand, theme},
    record::{self, RecordError},
    scenario::Scenario,
    time::Pace,
};
use std::{
    path::{Path, PathBuf},
    sync::{Arc, atomic::AtomicBool},
    time::{Duration, Instant},
};
use winit::{
    event::{ElementState, KeyEvent, WindowEvent},
    event_loop::ActiveEventLoop,
    keyboard::{KeyCode, ModifiersState, PhysicalKey},
    window::{Window, WindowId},
};

/// Options of `codrive drive`.
pub struct WindowOptions {
    /// Scenario of the first drive.
    pub scenario: Scenario,
    /// Placement of the driver's window, with full screen.
    pub place: WindowPlacement,
    /// Placement of the window of a secondary task with a display of its own.
    pub task_place: WindowPlacement,
    /// Show the experimenter's panel at the start.
    pub panel: bool,
    /// Open the experimenter's window beside the driver's.
    pub experimenter: bool,
    /// Start paused, until the space bar is pressed.
    pub paused: bool,
    /// Folder of the recording; `None` does not record.
    pub out: Option<PathBuf>,
    /// Profile of the wheel; `None` takes the profile for the wheel that is found.
    pub wheel: Option<WheelProfile>,
    /// Folder of the LED for signals of the detection response task; `None` for the wheel's rev lamps.
    pub led: Option<PathBuf>,
    /// Settings for laboratory devices.
    pub lab: LabSettings,
    /// Flag that becomes true when the program should end (Ctrl-C).
    pub stop: Arc<AtomicBool>,
}

impl WindowOptions {
    /// Returns true for a drive without experimenter and recording.
    fn is_free(&self) -> bool {
        self.out.is_none() && !self.experimenter && !self.panel
    }
}

/// Opens the window and drives until it is closed. Returns a summary of the drive as text, also if the drive ended with
/// a failure.
///
/// # Errors
/// No display, no graphics adapter, or a world that cannot start.
pub fn run(options: WindowOptions) -> Result<(String, Result<(), RunError>), RunError> {
    // An error of the laboratory devices is reported on a machine without a display, too.
    let mut lab = LabDevices::open(&options.lab)?;
    lab.open_outlets()?;
    let event_loop = event_loop::event_loop()?;
    // The world first: an error in the scenario is reported before a window opens. A free drive waits for its driver.
    let pace = if options.paused || options.is_free() { Pace::Paused } else { Pace::RealTime };
    let mut live = LiveDrive::new(
        &options.scenario,
        pace,
        Devices::open_with(options.wheel.clone()).with_led(options.led.as_deref()),
    )?;
    live.set_lab(lab);
    let stop = Arc::clone(&options.stop);
    let (frame, ended) = event_loop::run::<DriveWindows>(event_loop, (options, live), &stop);
    let ended = ended.or_else(|error| if error.is_interruption() { Ok(()) } else { Err(error) });
    let Some(mut frame) = frame else { return Ok((String::new(), ended)) };
    let drive = frame.live.summary_text();
    let recorded = frame.live.finish_recording().map(drop);
    let text = format!("{}{drive}", frame.recordings);
    let cut = frame.failed.take().map_or(Ok(()), |error| Err(error.into()));
    Ok((text, ended.and(cut).and(recorded)))
}

/// A drive in its window.
struct DriveWindows {
    picture: DriverWindow,
    /// Experimenter's window, if it was asked for; then the driver's window accepts the driver's own keys only.
    experimenter: Option<ExperimenterWindow>,
    /// Window of a secondary task with a display of its own.
    task: Option<TaskWindow>,
    live: LiveDrive,
    overlay: DriveOverlay,
    /// Start of the last frame; `None` before the first, and after another static scene went to the GPU: time counts
    /// from the first picture, so that loading shaders and models is not a stall.
    last: Option<Instant>,
    /// Start of the first frame, and time of the last write of rows to the disk.
    first: Instant,
    flushed: Instant,
    /// Folders of the recordings.
    recordings: RecordingFolders,
    /// True if the recording ended before the drive.
    is_cut: bool,
    /// Error of the first recording that did so.
    failed: Option<RecordError>,
    modifiers: ModifiersState,
    /// True after the experimenter has ended the program.
    is_over: bool,
    /// True while the drive waits at its start for the driver's accelerator key, or Space.
    awaits_driver: bool,
}

impl Windows for DriveWindows {
    type WindowParts = (WindowOptions, LiveDrive);

    fn open(event_loop: &ActiveEventLoop, (options, mut live): Self::WindowParts) -> Result<Self, RunError> {
        let place =
            if options.experimenter { display::beside_experimenter(options.place, event_loop) } else { options.place };
        let placing = WindowSetup { title: format!("codrive: {}", options.scenario.map), place };
        let mut picture = DriverWindow::open(event_loop, &placing)?;
        theme::apply(picture.ctx());
        let view = live.view();
        picture.set_static_scene(&live.picture.static_scene, &view, options.scenario.display.quality)?;
        live.open_sound();
        live.set_screen(picture.screen());
        let mut recordings = RecordingFolders::new(options.out);
        if let Some(folder) = recordings.next() {
            live.record(&folder, picture.gpu())?;
        }
        live.begin_trial(&options.scenario.map)?;
        let experimenter = if options.experimenter {
            picture.keep_preview();
            let title = format!("Experimenter: {}", options.scenario.map);
            Some(ExperimenterWindow::open(event_loop, picture.gpu(), picture.window(), &title)?)
        } else {
            None
        };
        let has_task = options.scenario.secondary_task.has_window();
        let task = has_task.then(|| TaskWindow::open(event_loop, picture.gpu(), picture.window(), options.task_place));
        let task = task.transpose()?;
        live.set_task_window(task.is_some());
        let overlay = DriveOverlay::new(&live, options.panel && experimenter.is_none(), experimenter.is_some());
        let start = now();
        Ok(Self {
            picture,
            experimenter,
            task,
            live,
            overlay,
            last: None,
            first: start,
            flushed: start,
            recordings,
            is_cut: false,
            failed: None,
            modifiers: ModifiersState::default(),
            is_over: false,
            awaits_driver: !options.experimenter,
        })
    }

    fn handle_event(&mut self, id: WindowId, event: WindowEvent) -> Result<LoopControl, RunError> {
        if let Some(experimenter) = self.experimenter.as_mut().filter(|window| window.id() == id) {
            experimenter.on_event(self.picture.gpu(), &event);
            return Ok(if event == WindowEvent::CloseRequested { LoopControl::End } else { LoopControl::GoOn });
        }
        let is_of_task = self.task.as_ref().is_some_and(|window| window.id() == id);
        let heard = match &mut self.task {
            Some(task) if is_of_task => {
                task.on_event(self.picture.gpu(), &event);
                false
            }
            _ => self.picture.on_event(&event),
        };
        match event {
            WindowEvent::CloseRequested => return Ok(LoopControl::End),
            WindowEvent::Focused(false) => self.live.devices.keyboard.release_all(),
            // Tab and the arrow keys drive and switch; only a text that is being typed keeps its keys.
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } if !(heard && self.picture.is_typing()) => {
                let asked = self.key(&event, is_of_task);
                return Ok(if asked == Some(KeyCommand::Quit) { LoopControl::End } else { LoopControl::GoOn });
            }
            WindowEvent::ModifiersChanged(modifiers) => self.modifiers = modifiers.state(),
            WindowEvent::RedrawRequested if !is_of_task => {
                self.draw()?;
                return Ok(if self.is_over { LoopControl::End } else { LoopControl::GoOn });
            }
            _ => {}
        }
        Ok(LoopControl::GoOn)
    }

    fn first(&self) -> &Window {
        self.picture.window()
    }
}

impl DriveWindows {
    /// Runs one frame: simulates the ticks that are due, draws, presents.
    fn draw(&mut self) -> Result<(), RunError> {
        let first = self.last.is_none();
        let elapsed = self.lap();
        if self.is_cut && self.live.writer_status().is_some() {
            // Without a recording there is no driving, even if someone presses Space.
            self.live.drive.clock.set_pace(Pace::Paused);
        }
        // A pedal may be in any position when a wheel is found; a key that is down was pressed now.
        if self.awaits_driver && self.live.devices.keyboard.is_down(DriveKey::Throttle) {
            self.live.drive.clock.set_pace(Pace::RealTime);
        }
        self.awaits_driver &= self.live.drive.clock.pace() == Pace::Paused;
        let advanced = self.live.advance(elapsed, |world| self.overlay.watch(world));
        let due = self.or_cut(advanced)?;
        if let Some(news) = self.live.take_news().pop() {
            self.overlay.show_message(news, &self.live);
        }
        if !due.dropped.is_zero() && self.live.drive.clock.stalls() == 1 {
            log::warn!(
                "a frame was late and {:.0} ms of the drive were lost; F3 shows the sum (--quality low is faster)",
                due.dropped.as_secs_f64() * 1e3
            );
        }
        let view = self.live.view();
        let times = self.picture.pass_times();
        let mut asked = Vec::new();
        let output = self.picture.overlay(|ui| asked.extend(self.overlay.show(ui, &self.live, times)));
        let drawn = self.picture.draw(Some(&view), Some(output));
        if let Some(task) = &mut self.task {
            task.draw(self.picture.gpu(), self.live.task_beside());
        }
        let done = now();
        if first {
            self.last = Some(done);
            self.first = done;
        }
        if drawn {
            self.live.shown(done - self.first, elapsed, &due);
        }
        self.overlay.frame(elapsed, &due);
        if done - self.flushed > record::FLUSH_EVERY {
            self.flushed = done;
            let flushed = self.live.flush();
            self.or_cut(flushed)?;
        }
        let mut asked: Vec<ExperimenterCommand> = asked.into_iter().map(ExperimenterCommand::Drive).collect();
        asked.extend(self.draw_experimenter());
        for command in asked {
            self.is_over |= command == ExperimenterCommand::End;
            self.overlay.handle_experimenter_command(command, &mut self.live);
        }
        // Most drives are ready within a frame.
        if let Some(new_static_scene) = self.overlay.restarted(PATIENCE, &mut self.live) {
            self.began(new_static_scene)?;
        }
        Ok(())
    }

    /// Handles the start of another drive, or of the same drive again: it is recorded like the first, in a folder
    /// beside it.
    fn began(&mut self, new_static_scene: bool) -> Result<(), RunError> {
        if new_static_scene {
            self.renew_static_scene()?;
        }
        self.is_cut = false;
        // A drive that could not start takes no folder: the summary lists only what was recorded.
        if !self.live.is_stopped()
            && let Some(folder) = self.recordings.next()
        {
            let begun = self.live.record(&folder, self.picture.gpu());
            self.or_cut(begun)?;
        }
        if self.live.is_stopped() {
            return Ok(());
        }
        let map = self.live.drive.world.scenario().map.clone();
        let begun = self.live.begin_trial(&map);
        self.or_cut(begun)
    }

    /// Handles the result of a part of the drive. If the recording has failed, the drive is paused and the window shows
    /// the reason until it is closed: a closed window explains nothing.
    fn or_cut<T: Default>(&mut self, done: Result<T, RunError>) -> Result<T, RunError> {
        let Err(RunError::Record(error)) = done else { return done };
        if !std::mem::replace(&mut self.is_cut, true) {
            self.live.drive.clock.set_pace(Pace::Paused);
            let folder = self.recordings.last().unwrap_or(Path::new(".")).display();
            self.overlay.recording_ended(format!(
                "The recording in {folder} has ended.\n{error}\nWhat was driven before is kept."
            ));
            self.failed.get_or_insert(error);
        }
        Ok(T::default())
    }

    /// Draws the experimenter's window if it is due, and returns its commands.
    fn draw_experimenter(&mut self) -> Vec<ExperimenterCommand> {
        let Self { experimenter: Some(window), picture, live, overlay, .. } = self else { return Vec::new() };
        if !window.due() {
            return Vec::new();
        }
        let seen = picture.preview().map(|view| {
            let texture = view.texture();
            (window.picture(picture.gpu(), view), [texture.width(), texture.height()])
        });
        let mut asked = Vec::new();
        window.draw(picture.gpu(), |ui| asked.extend(overlay.experimenter(ui, live, seen)));
        asked
    }

    /// Uploads the models of a new map to the GPU.
    fn renew_static_scene(&mut self) -> Result<(), RunError> {
        let view = self.live.view();
        let scenario = self.live.drive.world.scenario();
        self.picture.set_static_scene(&self.live.picture.static_scene, &view, scenario.display.quality)?;
        self.picture.window().set_title(&format!("codrive: {}", scenario.map));
        self.last = None;
        Ok(())
    }

    /// Returns the time since the last frame.
    fn lap(&mut self) -> Duration {
        let begin = now();
        self.last.replace(begin).map_or(Duration::ZERO, |before| begin - before)
    }

    /// Handles a key that went down or up in the driver's window or in that of the secondary task, which fills its screen by itself. Returns its command.
    fn key(&mut self, event: &KeyEvent, is_of_task: bool) -> Option<KeyCommand> {
        let PhysicalKey::Code(code) = event.physical_key else { return None };
        let down = event.state == ElementState::Pressed;
        let control = self.modifiers.control_key() || self.modifiers.super_key();
        if let Some(key) = keys::driving(code) {
            self.live.devices.keyboard.set(key, down && !control);
        }
        let asked = if control { keys::with_control(&event.logical_key, code) } else { keys::command(code) };
        let command = asked.filter(|_| down && !event.repeat)?;
        if self.experimenter.is_some() && !control && !command.is_drivers() {
            return None;
        }
        if code == KeyCode::Escape && (self.picture.has_open_list() || self.overlay.close_help()) {
            return None;
        }
        match command {
            KeyCommand::FullScreen if is_of_task => {}
            KeyCommand::FullScreen => self.picture.toggle_fullscreen(),
            KeyCommand::ReloadShaders => match self.picture.reload_shaders() {
                Ok(()) => self.overlay.show_message("shaders read again".into(), &self.live),
                Err(error) => self.overlay.show_message(error.to_string(), &self.live),
            },
            KeyCommand::Restart => {
                let scenario = self.live.drive.world.scenario().clone();
                self.overlay.restart(&scenario, &mut self.live);
            }
            other => self.overlay.key(other, &mut self.live),
        }
        Some(command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drive_is_free_without_experimenter_and_recording() {
        let is_free = |out: Option<&str>, experimenter: bool, panel: bool| {
            let options = WindowOptions {
                scenario: Scenario::default(),
                place: WindowPlacement::default(),
                task_place: WindowPlacement::default(),
                panel,
                experimenter,
                paused: false,
                out: out.map(PathBuf::from),
                wheel: None,
                led: None,
                lab: LabSettings::default(),
                stop: Arc::default(),
            };
            options.is_free()
        };
        assert!(is_free(None, false, false));
        for (out, experimenter, panel) in [(Some("p1"), false, false), (None, true, false), (None, false, true)] {
            assert!(!is_free(out, experimenter, panel));
        }
    }
}
