//! The experimenter's panel. In: a [`PanelState`]. Out: [`PanelCommand`]s. It owns no part of the simulation, and
//! nothing that a participant sees depends on it.

pub mod experimenter;
mod history;
pub mod overlay;
mod readout;
pub mod rig;
pub mod screens;
pub mod session;
mod settings;
pub mod theme;

pub use history::{SpeedHistory, SpeedSample};
pub use overlay::{
    contact_flash::contact_flash, key_list::show as key_list, recording_sign, room_sign::room_sign, seek_bar,
};
pub use readout::{Readings, dropped_time};
pub use rig::{
    calibration,
    display_check::{DisplayTruth, show as check},
};
pub use screens::{ParticipantScreen, SCREEN_KEYS, ScreenPainter, ScreenState};
pub use session::{ItemState, SessionCommand, SessionItem, SessionPanel, SessionPanelState, SessionPhase, StopRequest};
pub use settings::{PresetError, PresetList, SettingChoices};

use std::{path::Path, time::Duration};

use egui::{Button, Color32, RichText, Ui};

use crate::scenario::Scenario;
use settings::ScenarioEditor;

/// Content of the panel in one frame.
#[derive(Clone, Copy, Debug)]
pub struct PanelState<'a> {
    /// Scenario of the current drive, or of the one that could not start.
    pub scenario: &'a Scenario,
    /// State of the drive.
    pub phase: DrivePhase,
    /// The current moment; `None` before there is a world.
    pub readings: Option<Readings>,
    /// Speeds since the start of the drive.
    pub history: &'a SpeedHistory,
    /// Share of the time with advice in which the ego was in range, 0 to 1; `None` before the first advice.
    pub in_range: Option<f64>,
    /// Name and version of the traffic engine.
    pub engine: &'a str,
    /// Name of the policy in use, also if the scenario says `auto`; empty before there is a world.
    pub policy: &'a str,
    /// Time lost in stalls.
    pub dropped: Duration,
    /// Number of frames that lost time.
    pub stalls: u64,
    /// Time from frame to frame, ms.
    pub frame_ms: f64,
    /// Reason that the scenario cannot start or continue.
    pub error: Option<&'a str>,
    /// Folder of the recording; `None` if the drive is not recorded.
    pub recorded_in: Option<&'a Path>,
}

/// State of a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DrivePhase {
    /// Not yet started; the clock stands at 0.
    #[default]
    Ready,
    /// Starting: SUMO is starting, or the warm-up runs.
    Starting,
    /// Running: the clock advances.
    Running,
    /// The clock is stopped and can continue.
    Paused,
    /// Ended by its duration, a contact or an error.
    Ended,
}

/// Commands of the experimenter.
#[derive(Clone, Debug, PartialEq)]
pub enum PanelCommand {
    /// Start the clock, from the beginning or after a pause.
    Start,
    /// Stop the clock; Start continues.
    Pause,
    /// Advance by this much, then stop the clock.
    SingleStep(SingleStep),
    /// Start a new drive with this scenario, edited or not.
    Restart(Box<Scenario>),
    /// Show the wheel and pedal page.
    Wheel,
    /// A command of that page.
    Calibration(calibration::CalibrationCommand),
}

/// Size of a single step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SingleStep {
    /// One tick of the ego's physics, 10 ms.
    Tick,
    /// One step of traffic and policy.
    Step,
}

/// State of the panel: edits, and which parts are open.
pub struct SettingsPanel {
    editor: ScenarioEditor,
    presets: Option<PresetList>,
    /// True while the panel is shown.
    pub open: bool,
    /// True while the list of keys is shown.
    pub help_open: bool,
}

/// Width of the panel, points.
pub const WIDTH: f32 = 360.0;

impl SettingsPanel {
    /// Creates a closed panel for `scenario`. `choices` are the words to choose from for settings that are texts.
    pub fn new(scenario: &Scenario, choices: SettingChoices) -> Self {
        Self { editor: ScenarioEditor::new(scenario, choices), presets: None, open: false, help_open: false }
    }

    /// Allows settings to be saved and loaded under a name.
    pub fn keep_presets(&mut self, presets: PresetList) {
        self.presets = Some(presets);
    }

    /// Shows the presets, if they are enabled, and all settings.
    fn settings(&mut self, ui: &mut Ui) {
        if let Some(presets) = &mut self.presets {
            presets.show(ui, &mut self.editor);
            ui.add_space(4.0);
        }
        self.editor.show(ui);
        ui.add_space(12.0);
    }

    /// Updates the scenario and policy in use. A new scenario replaces all edits.
    pub fn follow(&mut self, state: &PanelState<'_>) {
        self.editor.follow(state.scenario);
        self.editor.follow_policy(state.policy);
    }

    /// Shows the drive's commands and its settings in a column given by the caller.
    pub fn drive(&mut self, ui: &mut Ui, state: &PanelState<'_>, commands: &mut Vec<PanelCommand>) {
        ui.add_space(4.0);
        self.controls(ui, state, commands);
        ui.separator();
        egui::ScrollArea::vertical().id_salt("settings").auto_shrink(false).show(ui, |ui| {
            self.settings(ui);
        });
    }

    /// Shows the open parts in the root [`Ui`] of a pass, and returns the commands. `keys` are keys and their actions.
    pub fn show(&mut self, ui: &mut Ui, state: &PanelState<'_>, keys: &[(&str, &str)]) -> Vec<PanelCommand> {
        let mut commands = Vec::new();
        self.follow(state);
        if self.open {
            egui::Panel::right("experimenter").default_size(WIDTH).min_size(320.0).show(ui, |ui| {
                ui.add_space(4.0);
                self.controls(ui, state, &mut commands);
                ui.separator();
                egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    readout::all_numbers(ui, state);
                    ui.add_space(4.0);
                    readout::plot(ui, state.history, 140.0);
                    ui.add_space(6.0);
                    self.settings(ui);
                });
            });
        }
        if self.help_open {
            key_list(ui.ctx(), keys);
        }
        commands
    }

    /// Shows the fixed top part: start, pause, single steps, restart, errors.
    fn controls(&mut self, ui: &mut Ui, state: &PanelState<'_>, commands: &mut Vec<PanelCommand>) {
        ui.horizontal(|ui| {
            let (word, light) = match state.phase {
                DrivePhase::Ready => ("ready", theme::DIM),
                DrivePhase::Starting => ("starting", theme::AMBER),
                DrivePhase::Running => ("running", theme::GREEN),
                DrivePhase::Paused => ("paused", theme::AMBER),
                DrivePhase::Ended => ("ended", theme::RED),
            };
            ui.heading("codrive");
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                ui.label(RichText::new(word).color(light).strong());
                let wheel = ui.small_button("Wheel").on_hover_text("Wheel and pedals: live bars, calibration, buttons");
                if wheel.clicked() {
                    commands.push(PanelCommand::Wheel);
                }
                recording_sign::show(ui, state.recorded_in);
            });
        });
        let edited = self.editor.scenario();
        ui.horizontal(|ui| {
            let held = matches!(state.phase, DrivePhase::Ready | DrivePhase::Paused);
            if state.phase == DrivePhase::Running {
                if ui.button("Pause").on_hover_text("Pause the drive (Ctrl+P; Space on the picture)").clicked() {
                    commands.push(PanelCommand::Pause);
                }
            } else if ui
                .add_enabled(held, primary("Start", held))
                .on_hover_text("Start or continue the drive (Ctrl+P; Space on the picture)")
                .on_disabled_hover_text("The drive is over: restart")
                .clicked()
            {
                commands.push(PanelCommand::Start);
            }
            for (text, advance, tip) in [
                ("+1 tick", SingleStep::Tick, "Advance by one tick of the vehicle's physics, 0.01 s"),
                ("+1 step", SingleStep::Step, "Advance by one step of traffic and advice"),
            ] {
                let button = ui.add_enabled(held, Button::new(text)).on_hover_text(tip);
                if button.on_disabled_hover_text("Pause first").clicked() {
                    commands.push(PanelCommand::SingleStep(advance));
                }
            }
            let pending = self.editor.is_edited();
            let restart = ui
                .add_enabled(edited.is_ok(), primary("Restart", pending && edited.is_ok()))
                .on_hover_text("Begin a new drive with the settings below");
            if restart.clicked()
                && let Ok(scenario) = &edited
            {
                commands.push(PanelCommand::Restart(Box::new(scenario.clone())));
            }
            // Always present, so that nothing moves under the pointer when the first setting is changed.
            let discard = ui.add_enabled(pending, Button::new("Discard")).on_hover_text("Undo all edits");
            if discard.on_disabled_hover_text("Nothing was changed").clicked() {
                self.editor.discard();
            }
        });
        match &edited {
            Err(fault) => one_line(ui, &fault.to_string(), theme::RED),
            Ok(_) if self.editor.is_edited() => one_line(ui, "Edited: restart to apply.", theme::AMBER),
            Ok(_) => one_line(ui, "No edits.", theme::DIM),
        }
        if let Some(error) = state.error {
            notice(ui, error, theme::RED);
        }
    }
}

/// Returns a button, highlighted as the next one to press if `is` is true.
fn primary(text: &str, is: bool) -> Button<'_> {
    if is {
        Button::new(RichText::new(text).color(Color32::WHITE)).fill(Color32::from_rgb(36, 96, 150))
    } else {
        Button::new(text)
    }
}

/// Shows a notice of exactly one line, so that the widgets below do not move; the tooltip has the full text.
fn one_line(ui: &mut Ui, text: &str, colour: Color32) {
    let frame = egui::Frame::new().fill(colour.gamma_multiply(0.12)).corner_radius(4).inner_margin(6);
    frame.show(ui, |ui| {
        ui.set_min_width(ui.available_width());
        ui.add(egui::Label::new(RichText::new(text).color(colour)).truncate()).on_hover_text(text);
    });
}

/// Shows a highlighted notice.
fn notice(ui: &mut Ui, text: &str, colour: Color32) {
    let frame = egui::Frame::new().fill(colour.gamma_multiply(0.12)).corner_radius(4).inner_margin(6);
    frame.show(ui, |ui| {
        ui.set_min_width(ui.available_width());
        ui.label(RichText::new(text).color(colour));
    });
}
