//! The experimenter's window in a session: plan and commands on the left, pictures and numbers of the drive beside them. In: the session,
//! and the drive if there is one. Out: [`SessionCommand`]s.

use super::{BackendStatus, LiveSession};
use crate::{
    live_drive::{LiveDrive, LoopHealth, phase},
    panel::{
        DrivePhase, PanelState, Readings, SessionCommand, SessionPanel, SessionPanelState, SettingChoices,
        SettingsPanel, SpeedHistory,
        experimenter::{
            DriveHealth, DriveLog, ExperimenterCommand, ExperimenterPanel, ExperimenterState, WheelHealth,
            listed_events,
        },
    },
    scenario::Scenario,
    sim::World,
    study::Study,
    time::DueTicks,
};
use egui::{TextureId, Ui};
use std::time::Duration;

/// Panels of the experimenter's window.
pub struct ExperimenterView {
    panel: SettingsPanel,
    experimenter: ExperimenterPanel,
    live_session: SessionPanel,
    /// Log of the present or last drive, shown until the next drive begins.
    log: Option<DriveLog>,
    loop_health: LoopHealth,
    engine: String,
    base: Scenario,
    empty: SpeedHistory,
}

impl ExperimenterView {
    /// Creates the view before the first drive of a study.
    pub fn new(study: &Study) -> Self {
        Self {
            panel: SettingsPanel::new(&study.base, SettingChoices::default()),
            experimenter: ExperimenterPanel::default(),
            live_session: SessionPanel::default(),
            log: None,
            loop_health: LoopHealth::default(),
            engine: String::new(),
            base: study.base.clone(),
            empty: SpeedHistory::default(),
        }
    }

    /// Resets the view for a new drive.
    pub fn drive_begins(&mut self, live: &LiveDrive) {
        let world = &live.drive.world;
        self.log = Some(DriveLog::new(world));
        self.engine = world.traffic_engine();
        self.loop_health = LoopHealth::default();
    }

    /// Logs the world after a tick.
    pub fn watch(&mut self, world: &World) {
        if let Some(log) = &mut self.log {
            log.watch(world);
        }
    }

    /// Counts a frame that was shown, for the health display.
    pub fn frame(&mut self, elapsed: Duration, due: &DueTicks) {
        self.loop_health.frame(elapsed, due.dropped);
    }

    /// Shows a message to the experimenter, at the time of the drive.
    pub fn add_note(&mut self, now: BackendStatus, words: &str) {
        self.experimenter.notes.add_note(now.time_s, words);
    }

    /// Takes the words that were typed in the panel and not entered; `None` if there are none.
    pub fn take_words(&mut self) -> Option<String> {
        self.live_session.take_words()
    }

    /// Puts words that an earlier opening of the session left into the field for a note.
    pub fn restore(&mut self, words: &str) {
        self.live_session.restore(words);
    }

    /// Draws the whole window and returns the experimenter's commands. `wheel` is the participant's wheel between drives, `work`
    /// describes background work, `picture` is the participant's picture with its size.
    #[expect(clippy::too_many_arguments, reason = "one frame's facts, from one place")]
    pub fn show(
        &mut self,
        ui: &mut Ui,
        live_session: &LiveSession,
        live: Option<&LiveDrive>,
        now: BackendStatus,
        wheel: &WheelHealth,
        work: Option<&str>,
        picture: Option<(TextureId, [u32; 2])>,
    ) -> Vec<SessionCommand> {
        let Self { panel, experimenter, live_session: part, log, loop_health, engine, base, empty } = self;
        let between = || DriveHealth {
            wheel: wheel.clone(),
            error: live_session.drive_fault().map(str::to_owned),
            ..DriveHealth::default()
        };
        // Every drive of a session is recorded from its first tick.
        let of_drive = |live: &LiveDrive| DriveHealth {
            will_record: live.recorded_in().is_none(),
            ..loop_health.health(live, engine, live_session.drive_fault())
        };
        let health = live.map_or_else(between, of_drive);
        let clock = live.map(|live| &live.drive.clock);
        let drive = PanelState {
            scenario: live.map_or(&*base, |live| live.drive.world.scenario()),
            phase: live.map_or(DrivePhase::Ready, phase),
            readings: live.map(|live| Readings::from(live.drive.world.snapshot())),
            history: log.as_ref().map_or(&*empty, |log| &log.history),
            in_range: log.as_ref().and_then(DriveLog::share_in_range),
            engine,
            policy: live.map_or("", |live| &live.drive.world.policy().name),
            dropped: clock.map_or(Duration::ZERO, |clock| clock.dropped()),
            stalls: clock.map_or(0, |clock| clock.stalls()),
            frame_ms: loop_health.frame_ms(),
            error: live_session.error(),
            recorded_in: live.and_then(LiveDrive::recorded_in),
        };
        let snapshot = live.map(|live| live.drive.world.snapshot());
        let items = live_session.items();
        let sees = [Some(live_session.sees()), live_session.practice(now), live_session.ratings()];
        let sees = sees.into_iter().flatten().collect::<Vec<_>>().join(", ");
        let state = SessionPanelState {
            title: live_session.title(),
            code: live_session.session().log().participant.as_str(),
            items: &items,
            to_come_s: live_session.to_come_s(),
            sees: &sees,
            left_s: live_session.left_s(now),
            phase: live_session.phase(now),
            asked: live_session.asked(),
            error: live_session.error(),
            work,
        };
        let mut commands = Vec::new();
        let mut plan = |ui: &mut Ui| commands.extend(part.show(ui, &state));
        let events = live.map_or(Vec::new(), |live| listed_events(&live.drive.world));
        let around = ExperimenterState { drive, snapshot, health: &health, picture, events: &events };
        let asked = experimenter.show(ui, &around, log.as_ref(), panel, Some(&mut plan));
        // Beside a plan the session's own commands are the only others.
        commands.extend(asked.into_iter().filter_map(|command| match command {
            ExperimenterCommand::BeginEvent(event) => Some(SessionCommand::BeginEvent(event)),
            _ => None,
        }));
        for command in &mut commands {
            match command {
                SessionCommand::Mark(text) => {
                    *text = format!("by the experimenter, {}", experimenter.notes.number(now.time_s));
                }
                SessionCommand::Note(text) => experimenter.notes.add_note(now.time_s, text),
                _ => {}
            }
        }
        commands
    }
}

#[cfg(test)]
#[path = "experimenter_view_tests.rs"]
mod tests;
