//! Drives of a session in the participant's window. In: scenarios, frames. Out: a [`LiveDrive`] for each drive, and a [`DriveBackend`]
//! for the state machine. Devices stay open from the first screen to the last.

use super::{BackendStatus, DriveBackend, wheel_navigation::WheelNavigation};
use crate::{
    audio::{RoomRecording, RoomStatus},
    controls::ControlSource,
    desktop::DriverWindow,
    drive_loop::RunError,
    input::{Devices, RigEvent},
    live_drive::{
        LiveDrive, contacts,
        lab::LabDevices,
        start::{PATIENCE, PendingDrive},
    },
    scenario::Scenario,
    sim::World,
    study::{FormInput, ParticipantCode, PracticeObserver, PracticeProgress},
    time::{DueTicks, Pace},
};
use std::{path::Path, time::Duration};

/// File of the room recording in a recording's folder.
const ROOM_FILE: &str = "room.wav";
const ROOM_EVENT: &str = "room_recording";

/// Devices and drive of a session.
pub struct SessionResources {
    /// Drive that is running or about to begin.
    pub live: Option<LiveDrive>,
    /// Drive that is loading.
    starting: Option<PendingDrive>,
    /// Devices, while no drive has them.
    devices: Option<Devices>,
    /// Lab devices, while no drive has them.
    pub lab: LabDevices,
    navigation: WheelNavigation,
    code: ParticipantCode,
    practice: PracticeObserver,
    /// Position of the brake pedal in the last frame before the drive begins, 0 to 1.
    brake: f64,
    /// True once the drive has begun, even while an unplugged wheel holds time.
    began: bool,
    /// Messages for the experimenter about devices and drive.
    news: Vec<String>,
    /// True if there is a window for the display of a secondary task.
    pub has_task_window: bool,
    /// True if drives record the room.
    records_room: bool,
    room: Option<RoomRecording>,
    /// True once the drive's recording has an event for the start or failure of the room recording.
    room_is_noted: bool,
    /// Descriptions of contacts that are not yet in the session log.
    contacts: Vec<String>,
}

impl SessionResources {
    /// Creates the resources without a drive.
    pub fn new(devices: Devices, code: &ParticipantCode) -> Self {
        Self {
            live: None,
            starting: None,
            devices: Some(devices),
            lab: LabDevices::default(),
            navigation: WheelNavigation::default(),
            code: code.clone(),
            practice: PracticeObserver::default(),
            brake: 0.0,
            began: false,
            news: Vec::new(),
            has_task_window: false,
            records_room: false,
            room: None,
            room_is_noted: false,
            contacts: Vec::new(),
        }
    }

    /// Returns the resources with room recording during drives switched on or off.
    pub fn with_room(self, records_room: bool) -> Self {
        Self { records_room, ..self }
    }

    /// Returns true while the room is recorded.
    pub fn hears_room(&self) -> bool {
        self.room.as_ref().is_some_and(|room| matches!(room.status(), RoomStatus::Recording { .. }))
    }

    /// Adds an event to the drive's recording that maps the present tick to a sample of the room recording. A failure is also reported to
    /// the experimenter.
    fn note_room(&mut self, what: &str) {
        let (Some(room), Some(live)) = (&self.room, &mut self.live) else { return };
        match room.status() {
            RoomStatus::Opening => {}
            RoomStatus::Recording { samples, rate_hz } => {
                self.room_is_noted = true;
                let words = format!("{what}: sample {samples} of {ROOM_FILE}, {rate_hz} a second");
                live.note_value(ROOM_EVENT, &words, samples as f64);
            }
            RoomStatus::Failed(why) => {
                self.room_is_noted = true;
                live.note(ROOM_EVENT, &format!("not recorded: {why}"));
                self.news.push(format!("the room is not recorded: {why}"));
                self.room = None;
            }
        }
    }

    /// Returns the devices, from the drive if it has them.
    pub fn devices(&mut self) -> Option<&mut Devices> {
        match &mut self.live {
            Some(live) => Some(&mut live.devices),
            None => self.devices.as_mut(),
        }
    }

    /// Returns the last device used; the keyboard in place of a wheel that was unplugged.
    pub fn source(&mut self) -> ControlSource {
        let Some(devices) = self.devices() else { return ControlSource::Keyboard };
        match devices.source() {
            ControlSource::Wheel if devices.wheel_profile().is_none() => ControlSource::Keyboard,
            source => source,
        }
    }

    /// Runs one frame: advances the drive, if there is one, and returns the participant's input.
    ///
    /// # Errors
    /// The drive cannot go on.
    pub fn frame(
        &mut self,
        elapsed: Duration,
        mut watch: impl FnMut(&World),
    ) -> Result<(DueTicks, Vec<FormInput>), RunError> {
        if !self.room_is_noted {
            self.note_room("begins");
        }
        let Self { live, devices, lab, navigation, practice, brake, began, news, contacts, .. } = self;
        news.extend(lab.take_news());
        let Some(live) = live else {
            let Some(devices) = devices else { return Ok((DueTicks::default(), Vec::new())) };
            return Ok((DueTicks::default(), at_a_screen(devices, navigation, news)));
        };
        let due = live.advance(elapsed, |world| {
            let (snapshot, scenario) = (world.snapshot(), world.scenario());
            if snapshot.tick.0.is_multiple_of(scenario.step_ticks()) {
                practice.step(snapshot, world.map(), scenario.step_s);
            }
            contacts.extend(world.events().iter().filter_map(contacts::contact_text));
            watch(world);
        })?;
        if !*began {
            live.devices.keyboard.stay_in_drive();
            *brake = f64::from(live.devices.controls(0.0, None).brake);
        }
        news.extend(live.take_news());
        *navigation = WheelNavigation::default();
        Ok((due, live.take_pressed().into_iter().filter_map(WheelNavigation::pressed_driving).collect()))
    }

    /// Returns the progress of the current drive, if it is for practice, in whole steps.
    pub fn practice(&self) -> PracticeProgress {
        self.practice.progress()
    }

    /// Takes the descriptions of contacts since the last call.
    pub fn take_contacts(&mut self) -> Vec<String> {
        std::mem::take(&mut self.contacts)
    }

    /// Takes the messages about devices and drive since the last call.
    pub fn take_news(&mut self) -> Vec<String> {
        std::mem::take(&mut self.news)
    }
}

/// Reads the devices at a screen: buttons and turns of the wheel become form input.
fn at_a_screen(devices: &mut Devices, navigation: &mut WheelNavigation, news: &mut Vec<String>) -> Vec<FormInput> {
    let mut inputs = Vec::new();
    for event in devices.poll() {
        match event {
            RigEvent::Pressed(action) => inputs.extend(WheelNavigation::pressed(action)),
            RigEvent::Connected(name) => news.push(format!("{name} is plugged in")),
            RigEvent::Disconnected(name) => news.push(format!("{name} was unplugged")),
            RigEvent::Trouble(text) => news.push(text),
        }
    }
    let source = devices.source();
    let answers = devices.wheel_profile().is_some_and(|p| !(p.buttons.answer.is_empty() && p.buttons.start.is_empty()));
    let controls = devices.controls(0.0, None);
    inputs.extend(navigation.inputs_from(&controls, source, !answers));
    inputs
}

/// Drive backend of the participant's window.
pub struct WindowBackend<'a> {
    /// Window that shows the pictures.
    pub picture: &'a mut DriverWindow,
    /// Devices and drive of the session.
    pub resources: &'a mut SessionResources,
}

impl DriveBackend for WindowBackend<'_> {
    fn prepare(&mut self, scenario: &Scenario) -> Result<bool, RunError> {
        let resources = &mut *self.resources;
        let starting = match &mut resources.starting {
            Some(starting) => starting,
            none => none.insert(PendingDrive::begin(scenario, true)?),
        };
        let Some(started) = starting.wait(PATIENCE) else { return Ok(false) };
        resources.starting = None;
        let mut live = LiveDrive::led_from(started?, resources.devices.take().unwrap_or_else(Devices::open));
        (resources.brake, resources.began) = (0.0, false);
        resources.practice = PracticeObserver::new(live.drive.world.map());
        let view = live.view();
        let set = self.picture.set_static_scene(&live.picture.static_scene, &view, scenario.display.quality);
        live.open_sound();
        live.set_screen(self.picture.screen());
        live.set_task_window(resources.has_task_window);
        live.set_lab(std::mem::take(&mut resources.lab));
        resources.live = Some(live);
        set.map(|()| true)
    }

    fn begin(&mut self, folder: &Path) -> Result<(), RunError> {
        let resources = &mut *self.resources;
        if let Some(live) = &mut resources.live {
            live.record_of(folder, self.picture.gpu(), Some(&resources.code))?;
            // Name of the item in the plan, which includes the condition: trial-2-wide.
            live.begin_trial(&folder.file_name().unwrap_or_default().to_string_lossy())?;
            live.drive.clock.set_pace(Pace::RealTime);
            resources.began = true;
            resources.room = resources.records_room.then(|| RoomRecording::begin(&folder.join(ROOM_FILE)));
            resources.room_is_noted = resources.room.is_none();
        }
        Ok(())
    }

    fn hold(&mut self, held: bool) {
        if let Some(live) = self.resources.live.as_mut().filter(|_| self.resources.began) {
            live.hold(held);
        }
        // Ticks stop while the drive is paused, but the room recording continues.
        self.resources.note_room(if held { "held" } else { "goes on" });
    }

    fn note(&mut self, kind: &str, detail: &str) {
        if let Some(live) = &mut self.resources.live {
            live.note(kind, detail);
        }
    }

    fn note_value(&mut self, kind: &str, detail: &str, value: f64) {
        if let Some(live) = &mut self.resources.live {
            live.note_value(kind, detail, value);
        }
    }

    fn begin_event(&mut self, event: usize) {
        if let Some(live) = self.resources.live.as_mut().filter(|_| self.resources.began) {
            live.drive.world.begin_event(event);
        }
    }

    fn chime(&mut self) {
        if let Some(live) = &mut self.resources.live {
            live.chime();
        }
    }

    fn extend(&mut self, seconds: f64) -> Result<(), RunError> {
        self.resources.live.as_mut().map_or(Ok(()), |live| live.extend(seconds))
    }

    fn end(&mut self) -> Result<(), RunError> {
        let resources = &mut *self.resources;
        resources.starting = None;
        // The room file must be complete before the recording's checksums are made.
        resources.note_room("ends");
        resources.room = None;
        let Some(mut live) = resources.live.take() else { return Ok(()) };
        let finished = live.finish_recording();
        resources.lab = live.take_lab();
        // SUMO must release its simulation for the next drive of this process.
        live.drive.world.stop_traffic();
        resources.devices = Some(live.into_devices());
        finished.map(drop)
    }

    fn now(&self) -> BackendStatus {
        let Some(live) = &self.resources.live else { return BackendStatus::default() };
        let world = &live.drive.world;
        BackendStatus {
            time_s: world.time_s(),
            duration_s: world.scenario().duration_s,
            practice: self.resources.practice(),
            brake: self.resources.brake,
            speed_mps: world.snapshot().ego.speed_mps,
            unit: world.scenario().display.units,
            ended: world.ended().is_some(),
            held: self.resources.began && live.drive.clock.pace() == Pace::Paused,
        }
    }
}
