//! A drive with a participant, without window or GPU. In: elapsed time, devices, commands. Out: the [`View`] of the
//! present moment.
//!
//! * [`start`]: start of a drive on a thread beside the drive loop; `restart`: replacement of the present drive by
//!   another.
//! * `devices`: effect of the participant's devices on the drive, and feedback to them.
//! * `drive_picture`: the picture; `flash_patch`: the square for a photodiode; [`sound`]: the sound.
//! * [`lab`]: laboratory devices: LSL streams and triggers.
//! * `presentation`: which digits of an n-back task were heard or shown. `recording`: the files. [`latency`], `loop_health`, [`contacts`]: values that the experimenter watches.
//! * [`wheel_calibration`]: state of the page that calibrates wheel and pedals.

pub mod contacts;
mod devices;
mod drive_picture;
mod flash_patch;
pub mod lab;
pub mod latency;
mod loop_health;
mod presentation;
mod recording;
mod restart;
pub mod sound;
pub mod start;
pub mod wheel_calibration;

use self::{
    contacts::ContactCount,
    devices::LedSignal,
    lab::LabDevices,
    latency::{InputLatency, Latency},
    presentation::{DigitPresentation, UnscoredDigit},
    recording::DriveRecording,
    sound::DriveSound,
    start::{PendingDrive, ReadyDrive},
};
use crate::{
    drive_loop::{Drive, RunError, drive::note_failure, summary_text},
    input::{ButtonAction, Devices, TimeStamp},
    record::{
        WriterStatus, inputs,
        manifest::ScreenInfo,
        tables::{FrameRow, NOT_SCORED},
    },
    render::Gpu,
    scenario::Scenario,
    scene::{StaticScene, View},
    sim::{Summary, SummaryAccumulator, World},
    snapshot::TaskPicture,
    study::ParticipantCode,
    time::{DueTicks, Pace, Tick},
};
use std::{
    path::{Path, PathBuf},
    time::Duration,
};

pub use drive_picture::DrivePicture;
pub use loop_health::{LoopHealth, phase};
pub use restart::RestartOutcome;

/// Drive in a window, with its devices and its recording.
pub struct LiveDrive {
    /// World and clock of the drive.
    pub drive: Drive,
    /// Drive that is to replace this one, and the reason why the requested one could not start.
    starting: Option<PendingDrive>,
    refused: Option<RunError>,
    pub devices: Devices,
    /// Picture of the drive as data.
    pub picture: DrivePicture,
    summary: SummaryAccumulator,
    /// Contacts so far, for the windows.
    contacts: ContactCount,
    lane_help: bool,
    recording: DriveRecording,
    lab: LabDevices,
    latency: InputLatency,
    sound: DriveSound,
    digits: DigitPresentation,
    /// True while the drive is paused because the wheel was unplugged.
    waiting: bool,
    /// True once a pulse of an event could not be felt.
    is_pulse_missed: bool,
    /// Signal of the detection response task's LED, and true once it could not be lit.
    led_signal: LedSignal,
    is_led_missed: bool,
    /// True if there is a window for the display of a secondary task.
    has_task_window: bool,
    /// Messages for the overlay.
    news: Vec<String>,
    /// True in a session: buttons are only collected in `pressed`, because the session decides when time runs.
    led: bool,
    pressed: Vec<ButtonAction>,
}

impl LiveDrive {
    /// Starts a drive and builds the static scene of its map.
    ///
    /// # Errors
    /// The world cannot start.
    pub fn new(scenario: &Scenario, pace: Pace, devices: Devices) -> Result<Self, RunError> {
        Ok(Self::with(start::start(scenario, pace, true)?, devices))
    }

    fn with(ReadyDrive { drive, static_scene }: ReadyDrive, devices: Devices) -> Self {
        let world = &drive.world;
        let of_world = || StaticScene::of_drive(world.map(), world.scenario(), world.drive().roadside());
        let static_scene = static_scene.unwrap_or_else(of_world);
        let scenario = drive.world.scenario();
        let (sound, digits) = (DriveSound::new(scenario), DigitPresentation::new(scenario.secondary_task.n));
        Self {
            picture: DrivePicture::new(&drive.world, static_scene),
            summary: SummaryAccumulator::new([0.0, f64::INFINITY]),
            contacts: ContactCount::default(),
            lane_help: scenario.lane_help,
            drive,
            starting: None,
            refused: None,
            devices,
            recording: DriveRecording::default(),
            lab: LabDevices::default(),
            latency: InputLatency::default(),
            digits,
            sound,
            waiting: false,
            is_pulse_missed: false,
            led_signal: LedSignal::Off,
            is_led_missed: false,
            has_task_window: false,
            news: Vec::new(),
            led: false,
            pressed: Vec::new(),
        }
    }

    /// Starts a drive of a session, paused; buttons are only collected (see [`LiveDrive::take_pressed`]).
    ///
    /// # Errors
    /// The world cannot start; `devices` is unchanged.
    pub fn with_devices(scenario: &Scenario, devices: &mut Option<Devices>) -> Result<Self, RunError> {
        let started = start::start(scenario, Pace::Paused, true)?;
        Ok(Self::led_from(started, devices.take().unwrap_or_else(Devices::open)))
    }

    /// Makes a drive of a session from a drive that has started elsewhere.
    pub fn led_from(started: ReadyDrive, mut devices: Devices) -> Self {
        devices.rest();
        Self { led: true, ..Self::with(started, devices) }
    }

    /// Returns the devices for the time after the drive.
    pub fn into_devices(mut self) -> Devices {
        self.darken_led();
        self.devices
    }

    /// Sets the laboratory devices of this drive.
    pub fn set_lab(&mut self, lab: LabDevices) {
        self.lab = lab;
    }

    /// Takes the laboratory devices for the next drive.
    pub fn take_lab(&mut self) -> LabDevices {
        std::mem::take(&mut self.lab)
    }

    /// Announces the start of the trial to the laboratory devices; `words` names it. To be called after
    /// [`LiveDrive::record`] if the drive is recorded.
    ///
    /// # Errors
    /// The recording cannot be written.
    pub fn begin_trial(&mut self, words: &str) -> Result<(), RunError> {
        Ok(self.lab.begin_trial(self.recording.folder(), words)?)
    }

    /// Extends the drive by `seconds`, also in its recording.
    ///
    /// # Errors
    /// The recording cannot be written.
    pub fn extend(&mut self, seconds: f64) -> Result<(), RunError> {
        self.drive.world.extend(seconds);
        let longer = inputs::portable(&self.drive.world);
        self.recording.set_scenario(&longer)
    }

    /// Starts recording this drive in `folder`.
    ///
    /// # Errors
    /// The folder holds a recording, or cannot be written.
    pub fn record(&mut self, folder: &Path, gpu: &Gpu) -> Result<(), RunError> {
        self.record_of(folder, gpu, None)
    }

    /// Starts recording this drive in `folder`, for a participant of a study.
    ///
    /// # Errors
    /// The folder holds a recording, or cannot be written.
    pub fn record_of(
        &mut self,
        folder: &Path,
        gpu: &Gpu,
        participant: Option<&ParticipantCode>,
    ) -> Result<(), RunError> {
        // Devices that are plugged in already belong in the manifest.
        self.poll_devices();
        let (world, driver) = (&self.drive.world, self.devices.describe());
        self.recording.begin(folder, world, driver, gpu, participant)?;
        self.note_profile();
        Ok(())
    }

    /// Notes that a frame was handed to the screen, `wall` after the first one and `elapsed` after the last.
    pub fn shown(&mut self, wall: Duration, elapsed: Duration, due: &DueTicks) {
        self.digits.shown();
        let patch = self.picture.shown();
        let [input_to_tick_s, latency_s] = self.latency.shown(elapsed);
        let row = FrameRow {
            frame: 0,
            tick: self.drive.world.snapshot().tick,
            fraction: self.drive.clock.fraction().into(),
            wall_s: wall.as_secs_f64(),
            elapsed_s: elapsed.as_secs_f64(),
            dropped_s: due.dropped.as_secs_f64(),
            latency_s,
            input_to_tick_s,
            flash: patch,
        };
        let number = self.recording.frame(row);
        self.lab.shown(row, number);
    }

    /// Returns the state of the recording's writer; `None` if the drive is not recorded.
    pub fn writer_status(&self) -> Option<&WriterStatus> {
        self.recording.writer_status()
    }

    /// Returns the folder of the recording; `None` if the drive is not recorded.
    pub fn recorded_in(&self) -> Option<&Path> {
        self.recording.folder()
    }

    /// Passes the rows since the last call to the disk.
    ///
    /// # Errors
    /// The disk is full or too slow. The drive must end; everything before is kept.
    pub fn flush(&mut self) -> Result<(), RunError> {
        self.recording.flush()?;
        Ok(self.lab.flush()?)
    }

    /// Records an event from outside the world, and passes it to the laboratory devices.
    pub fn note(&mut self, kind: &str, detail: &str) {
        self.recording.note(self.drive.world.snapshot().tick, kind, detail);
        self.lab.note(kind, detail);
    }

    /// Records an event from outside the world with a number.
    pub fn note_value(&mut self, kind: &str, detail: &str, value: f64) {
        self.recording.note_value(self.drive.world.snapshot().tick, kind, detail, value);
    }

    /// Plays a gentle tone for a question, if sound is on.
    pub fn chime(&mut self) {
        self.sound.chime();
    }

    /// Ends the recording, if there is one. Returns its folder.
    ///
    /// # Errors
    /// The recording cannot be written; its data can be recovered.
    pub fn finish_recording(&mut self) -> Result<Option<PathBuf>, RunError> {
        let ended = self.lab.end_trial();
        if let Some(missed) = self.digits.end() {
            leave_unscored(&mut self.summary, &mut self.recording, self.drive.world.snapshot().tick, &missed);
        }
        let finished = self.recording.finish(&self.summary.to_summary())?;
        Ok(ended.map(|()| finished)?)
    }

    /// Runs one frame of simulation. `watch` is called with the world after each tick.
    ///
    /// # Errors
    /// The traffic engine failed, or the recording cannot be written.
    pub fn advance(&mut self, elapsed: Duration, mut watch: impl FnMut(&World)) -> Result<DueTicks, RunError> {
        self.poll_devices();
        let torque_nm = self.devices.take_torque_nm();
        self.contacts.pass(elapsed);
        self.lab.begin_frame(elapsed);
        if self.drive.world.is_stopped() {
            self.update_rig();
            return Ok(DueTicks::default());
        }
        let Self { drive, devices, summary, contacts, lane_help, recording, lab, sound, picture, digits, .. } = self;
        let mut recorded = Ok(());
        recording.force(torque_nm);
        let ticked = TimeStamp::now();
        let due = drive.frame(
            elapsed,
            |world| {
                // Lane help would turn the keys' wheel beside that of the automation.
                let helps = *lane_help && !world.snapshot().automation.steers_now();
                devices.controls(world.snapshot().ego.speed_mps, helps.then(|| world.lane_hint()))
            },
            |world, controls| {
                summary.add(world.snapshot(), world.events());
                contacts.tick(world);
                sound.tick(world, controls);
                picture.tick(world, controls);
                lab.tick(world, controls);
                watch(world);
                if recorded.is_ok() {
                    recorded = recording.tick(world, controls);
                }
                // After the rows of the stimuli themselves.
                for unscored in digits.tick(world.events()) {
                    leave_unscored(summary, recording, world.snapshot().tick, &unscored);
                }
            },
        );
        let due = due.inspect_err(|error| note_failure(summary, error))?;
        recorded?;
        self.lab.end_frame(self.drive.world.snapshot().tick, self.drive.clock.fraction().into())?;
        for news in self.lab.take_news() {
            // Recorded for readers who see no window. It is not passed on to the laboratory devices, because one of
            // them reported it.
            self.recording.note(self.drive.world.snapshot().tick, "device", &news);
            self.news.push(news);
        }
        self.news.extend(self.contacts.take_texts());
        if due.ticks > 0 {
            self.latency.used(ticked);
        }
        self.update_rig();
        Ok(due)
    }

    /// Starts playing the drive's sound.
    pub fn open_sound(&mut self) {
        self.sound.open(self.drive.world.scenario());
    }

    /// Sets the screen, for the recording and for the latencies in the corner of the picture.
    pub fn set_screen(&mut self, screen: ScreenInfo) {
        self.latency.screen(screen.refresh_hz, &screen.present_mode);
        self.recording.set_screen(screen);
    }

    /// Returns the summary of the drive so far.
    pub fn summary(&self) -> Summary {
        self.summary.to_summary()
    }

    /// Returns the contacts so far.
    pub fn contacts(&self) -> &ContactCount {
        &self.contacts
    }

    /// Returns the latencies of the last seconds.
    pub fn latency(&self) -> &Latency {
        self.latency.recent()
    }

    /// Returns the present view; to be called once per picture.
    pub fn view(&mut self) -> View {
        let snapshot = self.drive.world.snapshot();
        let mut view = self.picture.view(snapshot, self.drive.clock.fraction(), self.contacts.jolt());
        if let (Some(dial), Some(sentence)) = (&mut view.dial, self.sound.shown_sentence(snapshot.tick)) {
            dial.message = Some(match dial.message.take() {
                Some(text) => format!("{text}\n{sentence}").into(),
                None => sentence,
            });
        }
        let is_elsewhere = match view.task {
            TaskPicture::Digit { .. } => self.sound.speaks_digits(),
            TaskPicture::Search { .. } => self.task_beside() != TaskPicture::None,
            TaskPicture::Signal => self.led_signal == LedSignal::Lit,
            TaskPicture::None | TaskPicture::Closed { .. } => false,
        };
        if is_elsewhere {
            view.task = TaskPicture::None;
        }
        self.digits.view(matches!(view.task, TaskPicture::Digit { .. }));
        view
    }

    /// States whether there is a window for the display of a secondary task; without one it is in the picture.
    pub fn set_task_window(&mut self, is_there: bool) {
        self.has_task_window = is_there;
    }

    /// Returns the content of the secondary task's own window.
    pub fn task_beside(&self) -> TaskPicture {
        let world = &self.drive.world;
        let is_beside = self.has_task_window && world.scenario().secondary_task.has_window();
        if is_beside { world.snapshot().task.shown } else { TaskPicture::None }
    }

    /// Pauses the drive on a person's request, or resumes it, with sound and force. A wheel that is plugged in during this pause does not end
    /// it.
    pub fn hold(&mut self, held: bool) {
        self.waiting = false;
        self.drive.clock.set_pace(if held { Pace::Paused } else { Pace::RealTime });
        self.update_rig();
    }

    /// Pauses the drive, or resumes it in real time.
    pub fn toggle_pause(&mut self) {
        self.hold(self.drive.clock.pace() != Pace::Paused);
    }

    /// Switches lane help on or off.
    pub fn toggle_lane_help(&mut self) {
        self.lane_help = !self.lane_help;
    }

    /// Checks whether lane help is on.
    pub fn lane_help(&self) -> bool {
        self.lane_help
    }

    /// Returns the summary of the drive so far as text.
    pub fn summary_text(&self) -> String {
        let world = &self.drive.world;
        let (driver, policy) = (self.devices.describe(), world.policy().to_string());
        summary_text::summary(world.drive(), &world.traffic_engine(), &driver, &policy, &self.summary.to_summary())
    }
}

/// Leaves a digit out of the scores, in the summary and in the recording.
fn leave_unscored(
    summary: &mut SummaryAccumulator,
    recording: &mut DriveRecording,
    now: Tick,
    UnscoredDigit { onset, detail }: &UnscoredDigit,
) {
    summary.leave_unscored(*onset);
    recording.note_value(now, NOT_SCORED, detail, onset.seconds());
}

#[cfg(test)]
mod secondary_task_tests;
#[cfg(test)]
mod tests;
