//! The experimenter's overlay: panel, messages, frame times on top of the picture, or all of it in a window of its own.
//! In: the running [`LiveDrive`]. Out: widgets and commands.

use super::end_card::EndCard;
use crate::{
    controls::ControlSource,
    desktop::keys::{self, KeyCommand},
    driver,
    input::profiles,
    live_drive::{LiveDrive, LoopHealth, RestartOutcome, phase, wheel_calibration},
    map,
    panel::{
        DrivePhase, PanelCommand, PanelState, PresetList, Readings, SettingChoices, SettingsPanel, SingleStep,
        calibration::CalibrationPage,
        contact_flash, dropped_time,
        experimenter::{
            DriveLog, ExperimenterCommand, ExperimenterPanel, ExperimenterState, listed_events, map as road_map,
        },
        recording_sign,
    },
    policy,
    render::PassTimes,
    scenario::Scenario,
    sim::{Snapshot, World},
    time::{DueTicks, Pace},
    traffic::population_names,
};
use egui::{Align2, Color32, FontId, TextureId, Ui};
use std::time::Duration;

/// Texts before a free drive, with a keyboard or a gamepad and with a wheel.
const START: &str = "Space or Up starts.\nArrow keys or W A S D drive.\nF1 lists the keys.";
const START_BY_WHEEL: &str = "The wheel's start button or Space starts.\nWheel and pedals drive.\nF1 lists the keys.";

/// Side of the map of the whole road, as a share of the picture's height.
const MAP_SHARE: f32 = 0.46;

/// Panel and overlays of a drive.
pub struct DriveOverlay {
    panel: SettingsPanel,
    experimenter: ExperimenterPanel,
    /// True if the experimenter has a window: the driver's then does not mention the experimenter's keys.
    attended: bool,
    log: DriveLog,
    loop_health: LoopHealth,
    engine: String,
    show_times: bool,
    show_map: bool,
    message: Option<String>,
    error: Option<String>,
    /// True if the recording ended before the drive, which is paused since.
    is_cut: bool,
    /// Card at the end of a free drive.
    card: Option<EndCard>,
    /// Wheel and pedal page, and the outcome of its last command.
    wheel: CalibrationPage,
    wheel_said: Option<String>,
}

impl DriveOverlay {
    /// Creates an overlay for this drive. `open` opens the panel on the picture; `attended` is true if the experimenter
    /// has a window.
    pub fn new(live: &LiveDrive, open: bool, attended: bool) -> Self {
        let world = &live.drive.world;
        let mut panel = SettingsPanel::new(world.scenario(), choices());
        panel.open = open;
        // Beside the user's wheel profiles.
        if let Some(own) = profiles::own_folder() {
            panel.keep_presets(PresetList::in_folder(own.with_file_name("scenarios")));
        }
        Self {
            panel,
            experimenter: ExperimenterPanel::default(),
            attended,
            log: DriveLog::new(world),
            loop_health: LoopHealth::default(),
            engine: world.traffic_engine(),
            show_times: false,
            show_map: false,
            message: None,
            error: None,
            is_cut: false,
            card: None,
            wheel: CalibrationPage::default(),
            wheel_said: None,
        }
    }

    /// Updates the log with the world after a tick.
    pub fn watch(&mut self, world: &World) {
        self.log.watch(world);
    }

    /// Records that a frame was shown, `elapsed` after the one before.
    pub fn frame(&mut self, elapsed: Duration, due: &DueTicks) {
        self.loop_health.frame(elapsed, due.dropped);
    }

    /// Shows the overlay on the picture, and returns the panel's commands. `times` are the GPU times of the passes.
    pub fn show(&mut self, ui: &mut Ui, live: &LiveDrive, times: Option<PassTimes>) -> Vec<PanelCommand> {
        let mut notes = self.notes(live, times);
        if phase(live) == DrivePhase::Ended && !live.is_stopped() && !self.attended {
            let world = &live.drive.world;
            let card = self.card.get_or_insert_with(|| EndCard::begin(world.scenario(), &live.summary()));
            notes.card = card.text();
        } else {
            self.card = None;
        }
        // Before the panel, which lies over it.
        if self.show_map {
            paint_map(ui, &self.log, live.drive.world.snapshot());
        }
        let Self { panel, log, loop_health, engine, error, .. } = self;
        let state = state(live, log, loop_health, engine, error.as_deref());
        let keys = match (self.attended, panel.open) {
            (true, _) => keys::list_of_driver(),
            (false, true) => keys::list(),
            (false, false) => keys::list_of_free_driver(),
        };
        let mut asked = panel.show(ui, &state, &keys);
        if !self.attended {
            asked.extend(self.wheel_page(ui, live));
        }
        contact_flash(ui, live.contacts().flash());
        write_notes(ui, &notes);
        write_recording(ui, live);
        asked
    }

    /// Shows the experimenter's window, and returns its commands. `picture` is the driver's picture, and its size in
    /// pixels.
    pub fn experimenter(
        &mut self,
        ui: &mut Ui,
        live: &LiveDrive,
        picture: Option<(TextureId, [u32; 2])>,
    ) -> Vec<ExperimenterCommand> {
        let Self { panel, experimenter, log, loop_health, engine, error, .. } = self;
        let health = loop_health.health(live, engine, error.as_deref());
        let drive = state(live, log, loop_health, engine, error.as_deref());
        let (snapshot, events) = (Some(live.drive.world.snapshot()), listed_events(&live.drive.world));
        let state = ExperimenterState { drive, snapshot, health: &health, picture, events: &events };
        let mut asked = experimenter.show(ui, &state, Some(log), panel, None);
        asked.extend(self.wheel_page(ui, live).into_iter().map(ExperimenterCommand::Drive));
        asked
    }

    /// Shows the wheel and pedal page, if it is open.
    fn wheel_page(&mut self, ui: &mut Ui, live: &LiveDrive) -> Vec<PanelCommand> {
        let wheel = if self.wheel.open { wheel_calibration::wheel(live.devices.rig()) } else { None };
        let asked = self.wheel.show(ui, wheel.as_ref(), self.wheel_said.as_deref());
        asked.into_iter().map(PanelCommand::Calibration).collect()
    }

    /// Returns the texts on the picture: state of the drive in the middle, times and messages at the lower left.
    fn notes(&self, live: &LiveDrive, times: Option<PassTimes>) -> OverlayNotes {
        let middle = match phase(live) {
            DrivePhase::Starting if !self.attended => "The drive is starting. Esc ends it.",
            DrivePhase::Ended if live.is_stopped() && !self.attended => {
                "The drive could not start. Press Backspace to try again."
            }
            DrivePhase::Starting => "Please wait.",
            DrivePhase::Paused if self.is_cut && !self.attended => "The recording has ended. Esc leaves.",
            DrivePhase::Paused if self.attended && live.waits_for_wheel() => "The wheel was unplugged.",
            DrivePhase::Paused | DrivePhase::Ready if self.attended => "Please wait.",
            DrivePhase::Ended if self.attended => "The drive is over.",
            DrivePhase::Paused if live.waits_for_wheel() => {
                "The wheel was unplugged. Plug it in to continue, or press Space to continue without it."
            }
            DrivePhase::Ready if live.devices.source() == ControlSource::Wheel => START_BY_WHEEL,
            DrivePhase::Ready => START,
            DrivePhase::Paused => "Paused. Space continues.",
            DrivePhase::Ended => "The drive is over. Press Backspace to start again.",
            DrivePhase::Running => "",
        };
        let mut corner = Vec::new();
        corner.extend(self.message.clone());
        corner.extend(self.error.clone());
        if self.show_times {
            corner.extend(live.latency().lines());
            corner.extend(times.map(|t| {
                let parts = (t.shadow_ms, t.main_ms, t.mirror_ms, t.tonemap_ms);
                format!(
                    "GPU: shadow {:.2}, main {:.2}, mirror {:.2}, tone map {:.2} ms",
                    parts.0, parts.1, parts.2, parts.3
                )
            }));
            let clock = &live.drive.clock;
            corner.push(format!("dropped {}", dropped_time(clock.dropped(), clock.stalls())));
            let help = if live.lane_help() { ", lane help" } else { "" };
            corner.push(format!("{}{help}", live.devices.describe()));
        }
        OverlayNotes { middle, corner, card: String::new() }
    }

    /// Closes the list of keys; returns true if it was open.
    pub fn close_help(&mut self) -> bool {
        std::mem::take(&mut self.panel.help_open)
    }

    /// Executes a command from a key.
    pub fn key(&mut self, command: KeyCommand, live: &mut LiveDrive) {
        self.message = None;
        match command {
            KeyCommand::Help => self.panel.help_open = !self.panel.help_open,
            KeyCommand::Panel => self.panel.open = !self.panel.open,
            KeyCommand::FrameTimes => self.show_times = !self.show_times,
            KeyCommand::Pause => live.toggle_pause(),
            KeyCommand::Tick => single_step(live, 1),
            KeyCommand::Step => single_step(live, live.drive.world.scenario().step_ticks()),
            KeyCommand::WholeMap => self.show_map = !self.show_map,
            KeyCommand::NextView => live.picture.next_view(),
            KeyCommand::PutBack => live.put_back(),
            KeyCommand::LaneHelp => {
                live.toggle_lane_help();
                self.show_message(format!("lane help is {}", if live.lane_help() { "on" } else { "off" }), live);
            }
            KeyCommand::Mark => {
                live.note("mark", "by the experimenter");
                self.show_message("marked".into(), live);
            }
            KeyCommand::Reverse
            | KeyCommand::IndicateLeft
            | KeyCommand::IndicateRight
            | KeyCommand::MainBeam
            | KeyCommand::Respond
            | KeyCommand::CursorLeft
            | KeyCommand::CursorRight
            | KeyCommand::Automation
            | KeyCommand::TimeGap => {
                command.apply_to(&mut live.devices);
            }
            KeyCommand::Restart | KeyCommand::FullScreen | KeyCommand::ReloadShaders | KeyCommand::Quit => {}
        }
    }

    /// Executes a command from the panel.
    pub fn handle_panel_command(&mut self, command: PanelCommand, live: &mut LiveDrive) {
        match command {
            PanelCommand::Start => live.drive.clock.set_pace(Pace::RealTime),
            PanelCommand::Pause => live.drive.clock.set_pace(Pace::Paused),
            PanelCommand::SingleStep(SingleStep::Tick) => single_step(live, 1),
            PanelCommand::SingleStep(SingleStep::Step) => single_step(live, live.drive.world.scenario().step_ticks()),
            PanelCommand::Restart(scenario) => self.restart(&scenario, live),
            PanelCommand::Wheel => self.wheel.open = !self.wheel.open,
            PanelCommand::Calibration(command) => self.wheel_said = live.calibrate(command),
        }
    }

    /// Starts another drive; [`DriveOverlay::restarted`] completes it.
    pub fn restart(&mut self, scenario: &Scenario, live: &mut LiveDrive) {
        self.message = None;
        self.error = None;
        self.is_cut = false;
        if let Err(error) = live.restart(scenario) {
            self.error = Some(error.to_string());
        }
    }

    /// Waits at most `patience` for a restart to complete. `None` while it is in progress; true if there is a new
    /// static scene to draw. If the new drive was refused, the drive before starts again and the panel shows the
    /// reason.
    pub fn restarted(&mut self, patience: Duration, live: &mut LiveDrive) -> Option<bool> {
        let RestartOutcome { new_static_scene, refused } = live.restarted(patience)?;
        let world = &live.drive.world;
        self.log = DriveLog::new(world);
        self.loop_health.restart();
        self.engine = world.traffic_engine();
        self.error = refused.map(|error| error.to_string());
        Some(new_static_scene)
    }

    /// Executes a command of the experimenter.
    pub fn handle_experimenter_command(&mut self, command: ExperimenterCommand, live: &mut LiveDrive) {
        match command {
            ExperimenterCommand::Drive(command) => self.handle_panel_command(command, live),
            ExperimenterCommand::Mark(number) => live.note("mark", &format!("by the experimenter, {number}")),
            ExperimenterCommand::Note(text) => live.note("note", &text),
            ExperimenterCommand::BeginEvent(event) => live.drive.world.begin_event(event),
            // The window ends the program.
            ExperimenterCommand::End => {}
        }
    }

    /// Shows that the recording has failed, until another drive begins.
    pub fn recording_ended(&mut self, why: String) {
        self.error = Some(why);
        self.is_cut = true;
    }

    /// Shows a message: on the picture until the next key, or to the experimenter.
    pub fn show_message(&mut self, message: String, live: &LiveDrive) {
        if self.attended {
            self.experimenter.notes.add_note(live.drive.world.time_s(), &message);
        } else {
            self.message = Some(message);
        }
    }
}

/// Texts on the picture.
struct OverlayNotes {
    middle: &'static str,
    corner: Vec<String>,
    /// Card below the middle; empty without one.
    card: String,
}

/// Paints the map of the whole road at the upper right, where no view has a dial: square, with the ego red and the others green.
fn paint_map(ui: &Ui, log: &DriveLog, snapshot: &Snapshot) {
    let painter = ui.ctx().layer_painter(egui::LayerId::background());
    let screen = ui.ctx().content_rect();
    let side = MAP_SHARE * screen.height();
    let field = Align2::RIGHT_TOP.anchor_size(screen.right_top() + egui::vec2(-16.0, 16.0), egui::vec2(side, side));
    road_map::paint(&painter, field, log, Some(snapshot), false);
}

fn write_notes(ui: &Ui, notes: &OverlayNotes) {
    let painter = ui.ctx().layer_painter(egui::LayerId::background());
    let screen = ui.ctx().content_rect();
    let boxed = |align: Align2, at: egui::Pos2, text: String, size: f32| {
        // In a small window a long text wraps rather than lose its end.
        let galley = painter.layout(text, FontId::proportional(size), Color32::WHITE, screen.width() - 48.0);
        let rect = align.anchor_size(at, galley.size());
        painter.rect_filled(rect.expand2(egui::vec2(10.0, 6.0)), 6.0, Color32::from_black_alpha(150));
        painter.galley(rect.min, galley, Color32::WHITE);
    };
    if !notes.middle.is_empty() {
        let at = screen.center_top() + egui::vec2(0.0, 0.34 * screen.height());
        boxed(Align2::CENTER_CENTER, at, notes.middle.into(), 26.0);
    }
    if !notes.card.is_empty() {
        let at = screen.center_top() + egui::vec2(0.0, 0.52 * screen.height());
        boxed(Align2::CENTER_CENTER, at, notes.card.clone(), 20.0);
    }
    if !notes.corner.is_empty() {
        boxed(Align2::LEFT_BOTTOM, screen.left_bottom() + egui::vec2(18.0, -16.0), notes.corner.join("\n"), 14.0);
    }
}

/// Shows the recording state at the upper left, in the participant's window too: a missing recording should be noticed
/// before the drive is over.
fn write_recording(ui: &Ui, live: &LiveDrive) {
    let (text, colour) = recording_sign::text_and_colour(live.recorded_in());
    let painter = ui.ctx().layer_painter(egui::LayerId::background());
    let galley = painter.layout_no_wrap(text, FontId::proportional(13.0), colour);
    let lamp = if live.recorded_in().is_some() { 2.0 * recording_sign::LAMP + 6.0 } else { 0.0 };
    let corner = ui.ctx().content_rect().left_top() + egui::vec2(16.0, 12.0);
    let rect = Align2::LEFT_TOP.anchor_size(corner, galley.size() + egui::vec2(lamp, 0.0));
    painter.rect_filled(rect.expand2(egui::vec2(6.0, 3.0)), 4.0, Color32::from_black_alpha(150));
    if lamp > 0.0 {
        painter.circle_filled(rect.left_center() + egui::vec2(recording_sign::LAMP, 0.0), recording_sign::LAMP, colour);
    }
    painter.galley(rect.min + egui::vec2(lamp, 0.0), galley, colour);
}

/// Collects the content of the panel.
fn state<'a>(
    live: &'a LiveDrive,
    log: &'a DriveLog,
    loop_health: &LoopHealth,
    engine: &'a str,
    error: Option<&'a str>,
) -> PanelState<'a> {
    let (world, clock) = (&live.drive.world, &live.drive.clock);
    PanelState {
        scenario: world.scenario(),
        phase: phase(live),
        readings: Some(Readings::from(world.snapshot())),
        history: &log.history,
        in_range: log.share_in_range(),
        engine,
        policy: &world.policy().name,
        dropped: clock.dropped(),
        stalls: clock.stalls(),
        frame_ms: loop_health.frame_ms(),
        error,
        recorded_in: live.recorded_in(),
    }
}

fn single_step(live: &mut LiveDrive, ticks: u64) {
    if live.drive.clock.pace() == Pace::Paused && live.starting().is_none() {
        live.drive.clock.single_step(ticks);
    }
}

/// Returns the names of all policies: built in and shipped.
fn policies() -> Vec<String> {
    let own = std::iter::once(policy::AUTO).chain(policy::NAMES).map(str::to_owned);
    own.chain(policy::shipped()).collect()
}

/// Returns the words to choose from for the settings that are texts.
fn choices() -> SettingChoices {
    let maps: Vec<String> = map::list().into_iter().map(|info| info.name).collect();
    SettingChoices::default()
        .with("map", maps, None)
        .with("policy", policies(), None)
        .with("traffic", ["sumo", "native"], Some("path of a file of trajectories (.csv)"))
        .with("traffic_drivers", population_names(), Some("path of a population's file (.toml)"))
        .with("driver", driver::PRESETS, None)
}

#[cfg(test)]
#[path = "overlay_tests.rs"]
mod tests;
