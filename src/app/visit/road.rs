//! Drives of a visit as its window shows them. In: scenarios, frames. Out: a [`Show`] while a drive is there, and a [`Road`]
//! for the state machine. Devices stay open from the first screen to the last.

use super::{Road, RoadNow, hands::Hands};
use crate::{
    app::{AppError, Show, contacts, drive::PATIENCE, host::PictureWindow, starting::Starting},
    input::{Devices, RigNews, Source},
    sim::{Scenario, World},
    study::{Code, Input},
    time::{Due, Pace},
};
use std::{path::Path, time::Duration};

/// What a visit has on the road.
pub struct Kit {
    /// The drive, while one is there.
    pub show: Option<Show>,
    /// The one that is being begun.
    starting: Option<Starting>,
    /// The devices while no drive has them.
    devices: Option<Devices>,
    hands: Hands,
    code: Code,
    in_range_s: f64,
    /// Time runs, or would if the wheel were not unplugged.
    began: bool,
    /// What the experimenter has to know of the devices and the drive.
    news: Vec<String>,
    /// Contacts that the visit's log does not have yet, in words.
    contacts: Vec<String>,
}

impl Kit {
    /// Nothing on the road yet.
    pub fn new(devices: Devices, code: &Code) -> Self {
        Self {
            show: None,
            starting: None,
            devices: Some(devices),
            hands: Hands::default(),
            code: code.clone(),
            in_range_s: 0.0,
            began: false,
            news: Vec::new(),
            contacts: Vec::new(),
        }
    }

    /// The devices, wherever they are.
    pub fn devices(&mut self) -> Option<&mut Devices> {
        match &mut self.show {
            Some(show) => Some(&mut show.devices),
            None => self.devices.as_mut(),
        }
    }

    /// True if a wheel is what the participant holds: one that was unplugged is still the last that was touched.
    pub fn wheel(&mut self) -> bool {
        self.devices().is_some_and(|devices| devices.source() == Source::Wheel && devices.wheel_profile().is_some())
    }

    /// One frame: the drive goes on if there is one, and what hands and feet ask for.
    ///
    /// # Errors
    /// The drive cannot go on.
    pub fn frame(&mut self, elapsed: Duration, mut watch: impl FnMut(&World)) -> Result<(Due, Vec<Input>), AppError> {
        let Self { show, devices, hands, in_range_s, news, contacts, .. } = self;
        let Some(show) = show else {
            let Some(devices) = devices else { return Ok((Due::default(), Vec::new())) };
            return Ok((Due::default(), at_a_screen(devices, hands, news)));
        };
        let due = show.advance(elapsed, |world| {
            let (snapshot, scenario) = (world.snapshot(), world.scenario());
            let step = snapshot.tick.0.is_multiple_of(scenario.step_ticks());
            if step && snapshot.advice.is_some_and(|advice| advice.accepts(snapshot.ego.speed_mps)) {
                *in_range_s += scenario.step_s;
            }
            contacts.extend(world.events().iter().filter_map(contacts::words));
            watch(world);
        })?;
        news.extend(show.take_news());
        *hands = Hands::default();
        Ok((due, show.take_pressed().into_iter().filter_map(Hands::pressed_driving).collect()))
    }

    /// How long the speed was in the range of the drive that is there, seconds: whole steps.
    pub fn in_range_s(&self) -> f64 {
        self.in_range_s
    }

    /// Contacts since the last call, in words.
    pub fn take_contacts(&mut self) -> Vec<String> {
        std::mem::take(&mut self.contacts)
    }

    /// What has happened to the devices since the last call.
    pub fn take_news(&mut self) -> Vec<String> {
        std::mem::take(&mut self.news)
    }
}

/// Devices where no drive has them: buttons and turns are inputs.
fn at_a_screen(devices: &mut Devices, hands: &mut Hands, news: &mut Vec<String>) -> Vec<Input> {
    let mut inputs = Vec::new();
    for told in devices.poll() {
        match told {
            RigNews::Pressed(action) => inputs.extend(Hands::pressed(action)),
            RigNews::Found(name) => news.push(format!("{name} is there")),
            RigNews::Lost(name) => news.push(format!("{name} was unplugged")),
            RigNews::Trouble(text) => news.push(text),
        }
    }
    let source = devices.source();
    let answers = devices.wheel_profile().is_some_and(|p| !(p.buttons.answer.is_empty() && p.buttons.start.is_empty()));
    let controls = devices.controls(0.0, None);
    inputs.extend(hands.feel(&controls, source, !answers));
    inputs
}

/// The road of a window.
pub struct Live<'a> {
    /// Shows the pictures.
    pub picture: &'a mut PictureWindow,
    /// What is on the road.
    pub kit: &'a mut Kit,
}

impl Road for Live<'_> {
    fn prepare(&mut self, scenario: &Scenario) -> Result<bool, AppError> {
        let kit = &mut *self.kit;
        let starting = match &mut kit.starting {
            Some(starting) => starting,
            none => none.insert(Starting::begin(scenario, true)?),
        };
        let Some(started) = starting.wait(PATIENCE) else { return Ok(false) };
        kit.starting = None;
        let mut show = Show::led_from(started?, kit.devices.take().unwrap_or_else(Devices::open));
        (kit.in_range_s, kit.began) = (0.0, false);
        let view = show.view();
        let staged = self.picture.stage(&show.stage, &view, scenario.quality);
        show.open_sound();
        show.set_screen(self.picture.screen());
        kit.show = Some(show);
        staged.map(|()| true)
    }

    fn begin(&mut self, folder: &Path) -> Result<(), AppError> {
        let kit = &mut *self.kit;
        if let Some(show) = &mut kit.show {
            show.record_of(folder, self.picture.gpu(), Some(&kit.code))?;
            show.drive.clock.set_pace(Pace::RealTime);
            kit.began = true;
        }
        Ok(())
    }

    fn hold(&mut self, held: bool) {
        if let Some(show) = self.kit.show.as_mut().filter(|_| self.kit.began) {
            show.hold(held);
        }
    }

    fn note(&mut self, kind: &str, detail: &str) {
        if let Some(show) = &mut self.kit.show {
            show.note(kind, detail);
        }
    }

    fn extend(&mut self, seconds: f64) -> Result<(), AppError> {
        self.kit.show.as_mut().map_or(Ok(()), |show| show.extend(seconds))
    }

    fn end(&mut self) -> Result<(), AppError> {
        let kit = &mut *self.kit;
        kit.starting = None;
        let Some(mut show) = kit.show.take() else { return Ok(()) };
        let finished = show.finish_recording();
        // SUMO lets go of its simulation, for the next drive of this process.
        show.drive.world.stop_traffic();
        kit.devices = Some(show.into_devices());
        finished.map(drop)
    }

    fn now(&self) -> RoadNow {
        let Some(show) = &self.kit.show else { return RoadNow::default() };
        let world = &show.drive.world;
        RoadNow {
            time_s: world.time_s(),
            duration_s: world.scenario().duration_s,
            in_range_s: self.kit.in_range_s,
            speed_mps: world.snapshot().ego.speed_mps,
            unit: world.scenario().units,
            ended: world.ended().is_some(),
            held: self.kit.began && show.drive.clock.pace() == Pace::Paused,
        }
    }
}
