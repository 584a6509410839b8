//! A drive with a person in it, without window or GPU: devices in, pictures' contents out. In: elapsed time, commands.
//! Out: the [`View`] of the moment.

mod restart;

use super::{
    AppError, Drive, Instruments,
    contacts::Contacts,
    drive::{PATIENCE, note_failure},
    facts,
    flash::Flash,
    latency::Latency,
    sound::{self, Sound},
    starting::{self, Started, Starting},
    view_options, words,
};
use crate::{
    ego::Surface,
    input::{Action, Devices, Feel, RigNews, Stamp, Standing},
    record::{Gauge, Manifest, Recorder, inputs, manifest::Screen, tables::FrameRow},
    render::Gpu,
    scene::{self, Stage, View, ViewKind, ViewOptions},
    sim::{Scenario, Summary, Tally, World},
    study::Code,
    time::{Due, Pace},
};
use std::{
    path::{Path, PathBuf},
    time::Duration,
};

pub use restart::Restarted;

/// A drive as its window shows it.
pub struct Show {
    /// World and clock.
    pub drive: Drive,
    /// The one that is to come after it, and why that which was asked for did not.
    starting: Option<Starting>,
    refused: Option<AppError>,
    /// The participant's devices.
    pub devices: Devices,
    /// What stands still: road, land, trees, models.
    pub stage: Stage,
    /// Which view is on the screen.
    pub kind: ViewKind,
    options: ViewOptions,
    instruments: Instruments,
    tally: Tally,
    /// Contacts so far, for the windows.
    contacts: Contacts,
    lane_help: bool,
    recorder: Option<Recorder>,
    frames: u64,
    /// Time of the newest input that no tick has used yet, and of the oldest used one that no frame has shown yet.
    unused_input: Option<Stamp>,
    used_input: Option<UsedInput>,
    latency: Latency,
    screen: Option<Screen>,
    sound: Sound,
    flash: Flash,
    /// The square in the corner as the next frame has it.
    patch: Option<bool>,
    /// True while the drive stands because the wheel was unplugged.
    waiting: bool,
    /// What the desk has to say.
    news: Vec<String>,
    /// In a visit buttons only ask: whoever leads it lets time run and holds it. What they asked for.
    led: bool,
    pressed: Vec<Action>,
}

/// An input that a tick has used.
#[derive(Clone, Copy, Debug)]
struct UsedInput {
    /// The kernel's time of it.
    at: Stamp,
    /// When the tick used it.
    ticked: Stamp,
}

impl Show {
    /// Starts a drive and builds what is to be seen of its map.
    ///
    /// # Errors
    /// The world cannot start.
    pub fn new(scenario: &Scenario, pace: Pace, devices: Devices) -> Result<Self, AppError> {
        let drive = Drive::new(scenario, pace)?;
        let stage = starting::stage(&drive.world);
        Ok(Self::with(drive, stage, devices))
    }

    fn with(drive: Drive, stage: Stage, devices: Devices) -> Self {
        let scenario = drive.world.scenario();
        let (sound, flash) = (Sound::new(scenario), Flash::new(scenario.flash_patch));
        Self {
            options: view_options(scenario),
            instruments: Instruments::new(&drive.world),
            tally: Tally::new([0.0, f64::INFINITY]),
            contacts: Contacts::default(),
            lane_help: scenario.lane_help,
            drive,
            starting: None,
            refused: None,
            devices,
            stage,
            kind: ViewKind::Driver,
            recorder: None,
            frames: 0,
            unused_input: None,
            used_input: None,
            latency: Latency::default(),
            screen: None,
            sound,
            flash,
            patch: None,
            waiting: false,
            news: Vec::new(),
            led: false,
            pressed: Vec::new(),
        }
    }

    /// A drive of a visit, put in place and held: buttons only ask (see [`Show::take_pressed`]).
    ///
    /// # Errors
    /// The world cannot start; the devices are where they were.
    pub fn led(scenario: &Scenario, devices: &mut Option<Devices>) -> Result<Self, AppError> {
        let drive = Drive::new(scenario, Pace::Paused)?;
        let stage = Some(starting::stage(&drive.world));
        Ok(Self::led_from(Started { drive, stage }, devices.take().unwrap_or_else(Devices::open)))
    }

    /// The same of a drive that has begun elsewhere.
    pub(super) fn led_from(started: Started, mut devices: Devices) -> Self {
        let Started { drive, stage } = started;
        devices.rest();
        let stage = stage.unwrap_or_else(|| starting::stage(&drive.world));
        Self { led: true, ..Self::with(drive, stage, devices) }
    }

    /// The devices, for what comes after the drive.
    pub fn into_devices(self) -> Devices {
        self.devices
    }

    /// Buttons that were pressed since the last call, in a visit.
    pub fn take_pressed(&mut self) -> Vec<Action> {
        std::mem::take(&mut self.pressed)
    }

    /// The drive lasts so many seconds longer.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn extend(&mut self, seconds: f64) -> Result<(), AppError> {
        self.drive.world.extend(seconds);
        let longer = inputs::portable(&self.drive.world);
        Ok(self.recorder.as_ref().map_or(Ok(()), |recorder| recorder.set_scenario(&longer))?)
    }

    /// Records this drive in `folder` from here on.
    ///
    /// # Errors
    /// The folder holds a recording, or the system refuses.
    pub fn record(&mut self, folder: &Path, gpu: &Gpu) -> Result<(), AppError> {
        self.record_of(folder, gpu, None)
    }

    /// The same for a participant of a study.
    ///
    /// # Errors
    /// The folder holds a recording, or the system refuses.
    pub fn record_of(&mut self, folder: &Path, gpu: &Gpu, participant: Option<&Code>) -> Result<(), AppError> {
        // What is plugged in already is in the manifest.
        self.hear_devices();
        let world = &self.drive.world;
        let participant = participant.map(|code| code.as_str().to_owned());
        let drive = facts::manifest(world, self.devices.describe(), Some(gpu));
        let manifest = Manifest { participant, screen: self.screen.clone(), ..drive };
        self.recorder = Some(facts::begin(folder, world, manifest)?);
        self.note_profile();
        Ok(())
    }

    /// A frame has been handed to the screen, `wall` after the first one and `elapsed` after the last.
    pub fn shown(&mut self, wall: Duration, elapsed: Duration, due: &Due) {
        let used = self.used_input.take();
        let patch = self.patch.take().inspect(|_| self.flash.shown());
        let to_tick_s = used.map(|input| input.at.until(input.ticked).as_secs_f64());
        let latency_s = used.map(|input| input.at.until(Stamp::now()).as_secs_f64());
        self.latency.frame(elapsed, to_tick_s.zip(latency_s).map(|(tick, frame)| [tick, frame]));
        let Some(recorder) = &mut self.recorder else { return };
        recorder.frame(FrameRow {
            frame: self.frames,
            tick: self.drive.world.snapshot().tick,
            fraction: self.drive.clock.fraction().into(),
            wall_s: wall.as_secs_f64(),
            elapsed_s: elapsed.as_secs_f64(),
            dropped_s: due.dropped.as_secs_f64(),
            latency_s,
            input_to_tick_s: to_tick_s,
            flash: patch,
        });
        self.frames += 1;
    }

    /// How the recording does; `None` if the drive is not recorded.
    pub fn gauge(&self) -> Option<&Gauge> {
        self.recorder.as_ref().map(Recorder::gauge)
    }

    /// Where the drive is recorded; `None` if it is not.
    pub fn recorded_in(&self) -> Option<&Path> {
        self.recorder.as_ref().map(Recorder::folder)
    }

    /// Hands to the disk what was recorded since the last time.
    ///
    /// # Errors
    /// The disk is full or too slow; the drive must end, everything before is kept.
    pub fn flush(&mut self) -> Result<(), AppError> {
        Ok(self.recorder.as_mut().map_or(Ok(()), Recorder::flush)?)
    }

    /// Notes something in the recording that the world does not know of.
    pub fn note(&mut self, kind: &str, detail: &str) {
        let tick = self.drive.world.snapshot().tick;
        if let Some(recorder) = &mut self.recorder {
            recorder.event(tick, kind, detail);
        }
    }

    /// Ends the recording, if there is one. Returns where it lies.
    ///
    /// # Errors
    /// The disk refuses; what was recorded can be recovered.
    pub fn finish_recording(&mut self) -> Result<Option<PathBuf>, AppError> {
        let summary = self.tally.summary();
        Ok(self.recorder.take().map(|recorder| recorder.finish(&summary)).transpose()?)
    }

    /// One frame of simulation. `watch` sees the world after each tick.
    ///
    /// # Errors
    /// The traffic engine failed.
    pub fn advance(&mut self, elapsed: Duration, mut watch: impl FnMut(&World)) -> Result<Due, AppError> {
        self.hear_devices();
        self.contacts.pass(elapsed);
        if self.drive.world.is_stopped() {
            self.tell_rig();
            return Ok(Due::default());
        }
        let Self { drive, devices, tally, contacts, lane_help, recorder, sound, flash, .. } = self;
        drive.patience = PATIENCE;
        let mut recorded = Ok(());
        if let Some(recorder) = recorder {
            recorder.force(devices.torque_nm());
        }
        let ticked = Stamp::now();
        let due = drive.frame(
            elapsed,
            |world| devices.controls(world.snapshot().ego.speed_mps, lane_help.then(|| world.lane_hint())),
            |world, controls| {
                tally.add(world.snapshot(), world.events());
                contacts.tick(world);
                sound.tick(world, controls);
                flash.tick(world, controls);
                watch(world);
                if let (Some(recorder), Ok(())) = (&mut *recorder, &recorded) {
                    recorded = recorder.tick(world, controls);
                }
            },
        );
        let due = due.inspect_err(|error| note_failure(tally, error))?;
        recorded?;
        self.news.extend(self.contacts.take_words());
        if due.ticks > 0 {
            let used = self.unused_input.take().map(|at| UsedInput { at, ticked });
            self.used_input = self.used_input.or(used);
        }
        self.tell_rig();
        Ok(due)
    }

    /// Force, sound and lamps of the present moment.
    fn tell_rig(&mut self) {
        self.devices.feel(self.feel());
        let horn = self.devices.horn();
        if self.sound.frame(self.running(), horn) {
            self.note(sound::HORN, if horn { "on" } else { "off" });
        }
        if self.drive.world.scenario().rev_lamps {
            let standing = self.standing();
            if let Some(trouble) = self.devices.rig_mut().show_standing(standing) {
                log::warn!("{trouble}");
                self.news.push(trouble);
            }
        }
    }

    /// True while time runs.
    fn running(&self) -> bool {
        let world = &self.drive.world;
        self.drive.clock.pace() != Pace::Paused && world.ended().is_none() && !world.is_stopped()
    }

    /// How the speed stands to the advice.
    fn standing(&self) -> Standing {
        let snapshot = self.drive.world.snapshot();
        match snapshot.advice {
            None => Standing::None,
            Some(advice) if advice.accepts(snapshot.ego.speed_mps) => Standing::Within,
            Some(advice) if snapshot.ego.speed_mps < advice.target_mps => Standing::Below,
            Some(_) => Standing::Above,
        }
    }

    /// Begins to play the drive's sound.
    pub fn open_sound(&mut self) {
        self.sound.open(self.drive.world.scenario());
    }

    /// The screen that the pictures come to, for the recording and the corner of the picture.
    pub fn set_screen(&mut self, screen: Screen) {
        self.latency.screen(screen.refresh_hz, &screen.present_mode);
        self.screen = Some(screen);
    }

    /// The drive so far in numbers.
    pub fn summary(&self) -> Summary {
        self.tally.summary()
    }

    /// Contacts so far.
    pub fn contacts(&self) -> &Contacts {
        &self.contacts
    }

    /// Delays of the last seconds.
    pub fn latency(&self) -> &Latency {
        &self.latency
    }

    /// What the hands are to feel of the present moment.
    fn feel(&self) -> Feel {
        let world = &self.drive.world;
        let ego = &world.snapshot().ego;
        let on_grass = ego.wheels[..2].iter().filter(|wheel| wheel.surface == Surface::Grass).count();
        Feel {
            aligning_nm: ego.steering_torque_nm.into(),
            speed_mps: ego.speed_mps,
            grass: on_grass as f64 / 2.0,
            running: self.running(),
        }
    }

    /// Reads the devices: a wheel that is unplugged holds time until it is back, buttons do what they stand for.
    fn hear_devices(&mut self) {
        if self.drive.clock.pace() != Pace::Paused {
            self.waiting = false;
        }
        for news in self.devices.poll() {
            match news {
                RigNews::Found(name) => {
                    self.note("wheel plugged in", &self.devices.describe());
                    self.note_profile();
                    if std::mem::take(&mut self.waiting) {
                        self.drive.clock.set_pace(Pace::RealTime);
                        self.news.push(format!("{name} is back: the drive continues"));
                    }
                }
                RigNews::Lost(name) => {
                    self.note("wheel unplugged", &name);
                    self.news.push(format!("{name} was unplugged: pedals are released"));
                    if self.drive.clock.pace() == Pace::RealTime {
                        self.drive.clock.set_pace(Pace::Paused);
                        self.waiting = true;
                    }
                }
                RigNews::Pressed(action) => self.pressed(action),
                RigNews::Trouble(text) => {
                    self.note("wheel trouble", &text);
                    self.news.push(text);
                }
            }
        }
        self.unused_input = self.unused_input.max(self.devices.newest_input());
    }

    /// Puts the car back on its lane, if it has left it and there is room.
    pub fn put_back(&mut self) {
        let said = self.drive.world.put_back();
        self.news.push(said.map_or_else(|why| why.to_string(), |()| "the car is back on its lane".into()));
    }

    /// The participant pressed a button.
    fn pressed(&mut self, action: Action) {
        if action == Action::Recentre && self.drive.world.is_astray() {
            return self.put_back();
        }
        if self.led {
            self.pressed.push(action);
            return;
        }
        match action {
            Action::Reverse | Action::Horn => {}
            Action::Start => self.drive.clock.set_pace(Pace::RealTime),
            Action::Recentre => self.kind = ViewKind::Driver,
            Action::Mark => {
                self.note("mark", "by the participant");
                self.news.push("marked".into());
            }
            Action::Answer => self.note("answer", "button"),
            Action::Abort => {
                self.note("abort asked for", "button");
                self.drive.clock.set_pace(Pace::Paused);
                self.news.push("the participant asks to end the drive: Esc ends it, Space continues".into());
            }
        }
    }

    /// The wheel's whole profile into the recording.
    fn note_profile(&mut self) {
        if let Some(profile) = self.devices.wheel_profile().map(crate::input::Profile::to_toml) {
            self.note("wheel profile", &profile);
        }
    }

    /// True while the drive stands because the wheel was unplugged.
    pub fn waits_for_wheel(&self) -> bool {
        self.waiting && self.drive.clock.pace() == Pace::Paused
    }

    /// What has happened to the devices since the last call, for the desk to say.
    pub fn take_news(&mut self) -> Vec<String> {
        std::mem::take(&mut self.news)
    }

    /// What is to be seen now; to be asked once a picture.
    pub fn view(&mut self) -> View {
        let snapshot = self.drive.world.snapshot();
        let mut view = scene::view(snapshot, self.drive.clock.fraction(), self.kind, &self.options, &self.stage);
        if self.kind.has_dial() {
            view.dial = Some(self.instruments.read(snapshot));
        }
        self.patch = self.flash.frame();
        view.patch = self.patch;
        view
    }

    /// The next view in the order driver, chase, bird's-eye, mirror.
    pub fn next_view(&mut self) {
        self.kind = match self.kind {
            ViewKind::Driver => ViewKind::Chase,
            ViewKind::Chase => ViewKind::Birdseye,
            ViewKind::Birdseye => ViewKind::Mirror,
            ViewKind::Mirror => ViewKind::Driver,
        };
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
        words::summary(world.scenario(), &world.traffic_engine(), &who, &policy, &self.tally.summary())
    }
}

#[cfg(test)]
#[path = "show_tests.rs"]
mod tests;
