//! The experimenter's side of a visit: plan and commands on the left, the drive in pictures and numbers beside it. In: the
//! visit, the drive while there is one. Out: [`VisitCommand`]s.

use super::{RoadNow, Visit};
use crate::{
    app::{Pulse, Show, desk::phase},
    panel::{
        Choices, History, Panel, PanelState, Phase, Readings, VisitCommand, VisitPanel, VisitState,
        experimenter::{Experimenter, ExperimenterState, Health, Log, WheelHealth},
    },
    sim::{Scenario, World},
    study::Study,
    time::Due,
};
use egui::{TextureId, Ui};
use std::time::Duration;

/// What the experimenter has before them.
pub struct Lead {
    panel: Panel,
    experimenter: Experimenter,
    visit: VisitPanel,
    /// The drive so far; stays to be looked at until the next begins.
    log: Option<Log>,
    pulse: Pulse,
    engine: String,
    base: Scenario,
    empty: History,
}

impl Lead {
    /// Before the first drive of this study.
    pub fn new(study: &Study) -> Self {
        Self {
            panel: Panel::new(&study.base, Choices::default()),
            experimenter: Experimenter::default(),
            visit: VisitPanel::default(),
            log: None,
            pulse: Pulse::default(),
            engine: String::new(),
            base: study.base.clone(),
            empty: History::default(),
        }
    }

    /// A drive was put in place.
    pub fn drive_begins(&mut self, show: &Show) {
        let world = &show.drive.world;
        self.log = Some(Log::new(world));
        self.engine = world.traffic_engine();
        self.pulse = Pulse::default();
    }

    /// Sees the world after a tick.
    pub fn watch(&mut self, world: &World) {
        if let Some(log) = &mut self.log {
            log.watch(world);
        }
    }

    /// A frame was shown.
    pub fn frame(&mut self, elapsed: Duration, due: &Due) {
        self.pulse.frame(elapsed, due.dropped);
    }

    /// Tells the experimenter something.
    pub fn say(&mut self, now: RoadNow, words: &str) {
        self.experimenter.notes.say(now.time_s, words);
    }

    /// The whole window. `wheel` is what the participant has in hands between drives, `work` is what goes on beside the visit, `picture` what the participant sees and its size.
    #[expect(clippy::too_many_arguments, reason = "one frame's facts, from one place")]
    pub fn show(
        &mut self,
        ui: &mut Ui,
        visit: &Visit,
        show: Option<&Show>,
        now: RoadNow,
        wheel: &WheelHealth,
        work: Option<&str>,
        picture: Option<(TextureId, [u32; 2])>,
    ) -> Vec<VisitCommand> {
        let Self { panel, experimenter, visit: part, log, pulse, engine, base, empty } = self;
        let between = || Health { wheel: wheel.clone(), error: visit.error().map(str::to_owned), ..Health::default() };
        let health = show.map_or_else(between, |show| pulse.health(show, engine, visit.error()));
        let clock = show.map(|show| &show.drive.clock);
        let drive = PanelState {
            scenario: show.map_or(&*base, |show| show.drive.world.scenario()),
            phase: show.map_or(Phase::Ready, phase),
            readings: show.map(|show| Readings::from(show.drive.world.snapshot())),
            history: log.as_ref().map_or(&*empty, |log| &log.history),
            in_range: log.as_ref().and_then(Log::share_in_range),
            engine,
            policy: show.map_or("", |show| &show.drive.world.policy().name),
            dropped: clock.map_or(Duration::ZERO, |clock| clock.dropped()),
            stalls: clock.map_or(0, |clock| clock.stalls()),
            frame_ms: pulse.frame_ms(),
            error: visit.error(),
            recorded_in: show.and_then(Show::recorded_in),
        };
        let snapshot = show.map(|show| show.drive.world.snapshot());
        let (items, sees) = (visit.items(), visit.sees());
        let state = VisitState {
            title: visit.title(),
            code: visit.session().log().participant.as_str(),
            items: &items,
            to_come_s: visit.to_come_s(),
            sees: &sees,
            left_s: visit.left_s(now),
            phase: visit.phase(now),
            asked: visit.asked(),
            error: visit.error(),
            work,
        };
        let mut commands = Vec::new();
        let mut plan = |ui: &mut Ui| commands.extend(part.show(ui, &state));
        let around = ExperimenterState { drive, snapshot, health: &health, picture };
        let asked = experimenter.show(ui, &around, log.as_ref(), panel, Some(&mut plan));
        debug_assert!(asked.is_empty(), "{asked:?}: beside a plan the visit's own commands are the only ones");
        for command in &mut commands {
            match command {
                VisitCommand::Mark(text) => {
                    *text = format!("by the experimenter, {}", experimenter.notes.number(now.time_s));
                }
                VisitCommand::Note(text) => experimenter.notes.say(now.time_s, text),
                _ => {}
            }
        }
        commands
    }
}

#[cfg(test)]
#[path = "lead_tests.rs"]
mod tests;
