//! A drive with a person in it, without window or GPU: devices in, pictures' contents out. In: elapsed time, commands.
//! Out: the [`View`] of the moment.
//!
//! * [`start`]: a drive that begins beside the loop; `restart`: another one in the place of this.
//! * `devices`: what the participant's devices do to the drive, and what the rig is told back.
//! * `drive_picture`: what is to be seen; `flash_patch`: the square for a photodiode; [`sound`]: what is to be heard.
//! * [`lab`]: other devices: streams of LSL, triggers.
//! * `recording`: its files. [`latency`], `loop_health`, [`contacts`]: what the experimenter watches.
//! * [`wheel_calibration`]: the page of wheel and pedals at work.

pub mod contacts;
mod devices;
mod drive_picture;
mod flash_patch;
pub mod lab;
pub mod latency;
mod loop_health;
mod recording;
mod restart;
pub mod sound;
pub mod start;
pub mod wheel_calibration;

use self::{
    contacts::ContactCount,
    lab::LabDevices,
    latency::{InputLatency, Latency},
    recording::DriveRecording,
    sound::DriveSound,
    start::{PendingDrive, ReadyDrive},
};
use crate::{
    drive_loop::{Drive, RunError, drive::note_failure, summary_text},
    input::{ButtonAction, Devices, TimeStamp},
    record::{WriterStatus, inputs, manifest::ScreenInfo, tables::FrameRow},
    render::Gpu,
    scenario::Scenario,
    scene::{StaticScene, View},
    sim::{Summary, SummaryAccumulator, World},
    study::ParticipantCode,
    time::{DueTicks, Pace},
};
use std::{
    path::{Path, PathBuf},
    time::Duration,
};

pub use drive_picture::DrivePicture;
pub use loop_health::{LoopHealth, phase};
pub use restart::RestartOutcome;

/// A drive as its window shows it.
pub struct LiveDrive {
    /// World and clock.
    pub drive: Drive,
    /// The one that is to come after it, and why that which was asked for did not.
    starting: Option<PendingDrive>,
    refused: Option<RunError>,
    /// The participant's devices.
    pub devices: Devices,
    /// What is to be seen of it.
    pub picture: DrivePicture,
    tally: SummaryAccumulator,
    /// Contacts so far, for the windows.
    contacts: ContactCount,
    lane_help: bool,
    recording: DriveRecording,
    lab: LabDevices,
    latency: InputLatency,
    sound: DriveSound,
    /// True while the drive stands because the wheel was unplugged.
    waiting: bool,
    /// Messages for the overlay.
    news: Vec<String>,
    /// In a session buttons only ask: whoever leads it lets time run and holds it. What they asked for.
    led: bool,
    pressed: Vec<ButtonAction>,
}

impl LiveDrive {
    /// Starts a drive and builds what is to be seen of its map.
    ///
    /// # Errors
    /// The world cannot start.
    pub fn new(scenario: &Scenario, pace: Pace, devices: Devices) -> Result<Self, RunError> {
        let drive = Drive::by_participant(scenario, pace)?;
        let stage = start::stage(&drive.world);
        Ok(Self::with(drive, stage, devices))
    }

    fn with(drive: Drive, stage: StaticScene, devices: Devices) -> Self {
        let scenario = drive.world.scenario();
        let sound = DriveSound::new(scenario);
        Self {
            picture: DrivePicture::new(&drive.world, stage),
            tally: SummaryAccumulator::new([0.0, f64::INFINITY]),
            contacts: ContactCount::default(),
            lane_help: scenario.lane_help,
            drive,
            starting: None,
            refused: None,
            devices,
            recording: DriveRecording::default(),
            lab: LabDevices::default(),
            latency: InputLatency::default(),
            sound,
            waiting: false,
            news: Vec::new(),
            led: false,
            pressed: Vec::new(),
        }
    }

    /// A drive of a session, put in place and held: buttons only ask (see [`LiveDrive::take_pressed`]).
    ///
    /// # Errors
    /// The world cannot start; the devices are where they were.
    pub fn with_devices(scenario: &Scenario, devices: &mut Option<Devices>) -> Result<Self, RunError> {
        let drive = Drive::by_participant(scenario, Pace::Paused)?;
        let stage = Some(start::stage(&drive.world));
        Ok(Self::led_from(ReadyDrive { drive, stage }, devices.take().unwrap_or_else(Devices::open)))
    }

    /// The same of a drive that has begun elsewhere.
    pub fn led_from(started: ReadyDrive, mut devices: Devices) -> Self {
        let ReadyDrive { drive, stage } = started;
        devices.rest();
        let stage = stage.unwrap_or_else(|| start::stage(&drive.world));
        Self { led: true, ..Self::with(drive, stage, devices) }
    }

    /// The devices, for what comes after the drive.
    pub fn into_devices(self) -> Devices {
        self.devices
    }

    /// The laboratory's devices that this drive has to do with.
    pub fn set_lab(&mut self, lab: LabDevices) {
        self.lab = lab;
    }

    /// They, for what comes after the drive.
    pub fn take_lab(&mut self) -> LabDevices {
        std::mem::take(&mut self.lab)
    }

    /// Says to them that the drive begins, in `words`; after [`LiveDrive::record`] where it is recorded.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn begin_trial(&mut self, words: &str) -> Result<(), RunError> {
        Ok(self.lab.begin_trial(self.recording.folder(), words)?)
    }

    /// The drive lasts so many seconds longer.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn extend(&mut self, seconds: f64) -> Result<(), RunError> {
        self.drive.world.extend(seconds);
        let longer = inputs::portable(&self.drive.world);
        self.recording.set_scenario(&longer)
    }

    /// Records this drive in `folder` from here on.
    ///
    /// # Errors
    /// The folder holds a recording, or the system refuses.
    pub fn record(&mut self, folder: &Path, gpu: &Gpu) -> Result<(), RunError> {
        self.record_of(folder, gpu, None)
    }

    /// The same for a participant of a study.
    ///
    /// # Errors
    /// The folder holds a recording, or the system refuses.
    pub fn record_of(
        &mut self,
        folder: &Path,
        gpu: &Gpu,
        participant: Option<&ParticipantCode>,
    ) -> Result<(), RunError> {
        // What is plugged in already is in the manifest.
        self.poll_devices();
        let (world, driver) = (&self.drive.world, self.devices.describe());
        self.recording.begin(folder, world, driver, gpu, participant)?;
        self.note_profile();
        Ok(())
    }

    /// A frame has been handed to the screen, `wall` after the first one and `elapsed` after the last.
    pub fn shown(&mut self, wall: Duration, elapsed: Duration, due: &DueTicks) {
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

    /// How the recording does; `None` if the drive is not recorded.
    pub fn writer_status(&self) -> Option<&WriterStatus> {
        self.recording.writer_status()
    }

    /// Where the drive is recorded; `None` if it is not.
    pub fn recorded_in(&self) -> Option<&Path> {
        self.recording.folder()
    }

    /// Hands to the disk what was recorded since the last time.
    ///
    /// # Errors
    /// The disk is full or too slow; the drive must end, everything before is kept.
    pub fn flush(&mut self) -> Result<(), RunError> {
        self.recording.flush()?;
        Ok(self.lab.flush()?)
    }

    /// Notes something in the recording that the world does not know of.
    pub fn note(&mut self, kind: &str, detail: &str) {
        self.recording.note(self.drive.world.snapshot().tick, kind, detail);
        self.lab.note(kind, detail);
    }

    /// The same with a number.
    pub fn note_value(&mut self, kind: &str, detail: &str, value: f64) {
        self.recording.note_value(self.drive.world.snapshot().tick, kind, detail, value);
    }

    /// A gentle sound, where there is any: something is asked.
    pub fn chime(&mut self) {
        self.sound.chime();
    }

    /// Ends the recording, if there is one. Returns where it lies.
    ///
    /// # Errors
    /// The disk refuses; what was recorded can be recovered.
    pub fn finish_recording(&mut self) -> Result<Option<PathBuf>, RunError> {
        let ended = self.lab.end_trial();
        let finished = self.recording.finish(&self.tally.summary())?;
        Ok(ended.map(|()| finished)?)
    }

    /// One frame of simulation. `watch` sees the world after each tick.
    ///
    /// # Errors
    /// The traffic engine failed.
    pub fn advance(&mut self, elapsed: Duration, mut watch: impl FnMut(&World)) -> Result<DueTicks, RunError> {
        self.poll_devices();
        self.contacts.pass(elapsed);
        if self.drive.world.is_stopped() {
            self.update_rig();
            return Ok(DueTicks::default());
        }
        let Self { drive, devices, tally, contacts, lane_help, recording, lab, sound, picture, .. } = self;
        lab.begin_frame();
        let mut recorded = Ok(());
        recording.force(devices.torque_nm());
        let ticked = TimeStamp::now();
        let due = drive.frame(
            elapsed,
            |world| devices.controls(world.snapshot().ego.speed_mps, lane_help.then(|| world.lane_hint())),
            |world, controls| {
                tally.add(world.snapshot(), world.events());
                contacts.tick(world);
                sound.tick(world, controls);
                picture.tick(world, controls);
                lab.tick(world, controls);
                watch(world);
                if recorded.is_ok() {
                    recorded = recording.tick(world, controls);
                }
            },
        );
        let due = due.inspect_err(|error| note_failure(tally, error))?;
        recorded?;
        self.lab.end_frame(self.drive.world.snapshot().tick, self.drive.clock.fraction().into())?;
        for news in self.lab.take_news() {
            // Readers of the recording see no window. The devices are not told: one of them reports this trouble.
            self.recording.note(self.drive.world.snapshot().tick, "device", &news);
            self.news.push(news);
        }
        self.news.extend(self.contacts.take_words());
        if due.ticks > 0 {
            self.latency.used(ticked);
        }
        self.update_rig();
        Ok(due)
    }

    /// Begins to play the drive's sound.
    pub fn open_sound(&mut self) {
        self.sound.open(self.drive.world.scenario());
    }

    /// The screen that the pictures come to, for the recording and the corner of the picture.
    pub fn set_screen(&mut self, screen: ScreenInfo) {
        self.latency.screen(screen.refresh_hz, &screen.present_mode);
        self.recording.set_screen(screen);
    }

    /// The drive so far in numbers.
    pub fn summary(&self) -> Summary {
        self.tally.summary()
    }

    /// Contacts so far.
    pub fn contacts(&self) -> &ContactCount {
        &self.contacts
    }

    /// Delays of the last seconds.
    pub fn latency(&self) -> &Latency {
        self.latency.recent()
    }

    /// What is to be seen now; to be asked once a picture.
    pub fn view(&mut self) -> View {
        self.picture.view(self.drive.world.snapshot(), self.drive.clock.fraction())
    }

    /// A person holds the drive, or lets it go on: a wheel that comes back meanwhile changes nothing about that.
    pub fn hold(&mut self, held: bool) {
        self.waiting = false;
        self.drive.clock.set_pace(if held { Pace::Paused } else { Pace::RealTime });
    }

    /// Pauses, or goes on in real time.
    pub fn toggle_pause(&mut self) {
        self.hold(self.drive.clock.pace() != Pace::Paused);
    }

    /// Lane help on or off.
    pub fn toggle_lane_help(&mut self) {
        self.lane_help = !self.lane_help;
    }

    /// True while lane help steers along.
    pub fn lane_help(&self) -> bool {
        self.lane_help
    }

    /// The drive so far in words.
    pub fn words(&self) -> String {
        let world = &self.drive.world;
        let (who, policy) = (self.devices.describe(), world.policy().words());
        summary_text::summary(world.scenario(), &world.traffic_engine(), &who, &policy, &self.tally.summary())
    }
}

#[cfg(test)]
mod tests;
