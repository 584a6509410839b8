//! The experimenter's window: plan, progress and warnings. In: an [`ExperimenterState`]; in a study a closure that
//! shows the session's plan. Out: [`ExperimenterCommand`]s. It owns no part of the simulation, and nothing that a
//! participant sees depends on it.
//!
//! * [`log`]: the drive so far, updated with the world after each tick.
//! * [`map`], [`space_time`], [`plots`]: the drive as pictures.
//! * [`lamps`]: warnings. [`notes`]: marks and notes.
//!
//! Left: the plan, or the drive's commands and settings; middle: pictures and plots; right: numbers, lamps, notes. A
//! narrow window (or a large scale) shows these as four pages. On the keyboard, Tab and the arrow keys move the focus;
//! the other keys are in [`KEYS`], which F1 lists.

mod events;
pub mod lamps;
pub mod log;
pub mod map;
pub mod notes;
pub mod plots;
pub mod space_time;

pub use events::{ListedEvent, listed_events};
pub use lamps::{ContactHealth, DriveHealth, Lamp, LampColour, RecordingHealth, WheelHealth};
pub use log::DriveLog;

use super::{DrivePhase, PanelCommand, PanelState, SettingsPanel, overlay::key_list, readout, theme};
use crate::sim::Snapshot;
use egui::{Event, Key, Modifiers, RichText, ScrollArea, TextureId, Ui, Vec2, vec2};
use notes::SessionNotes;

/// Keys of the window beside a drive, and their actions. A session of a study has keys of its own.
pub const KEYS: [(&str, &str); 8] = [
    ("F1", "this list"),
    ("Ctrl+P", "pause, continue"),
    ("Ctrl+M", "mark this moment"),
    ("Ctrl+N", "write a note"),
    ("Ctrl+1 to Ctrl+4", "next or previous page of a narrow window"),
    ("Ctrl+Plus, Minus, 0", "larger, smaller, original size"),
    key_list::FULL_SCREEN,
    ("Ctrl+Q", "end"),
];

/// Minimum width of a window without pages, points.
const WIDE: f32 = 1060.0;

/// Initial share of the left part in a wide window: enough to read a line of a plan to its end.
const PLAN_SHARE: f32 = 0.25;

/// Height of a heading over a picture, points.
const HEADING: f32 = 22.0;

/// Content of the window in one pass.
pub struct ExperimenterState<'a> {
    /// Commands and numbers of the drive.
    pub drive: PanelState<'a>,
    /// The current moment; `None` before there is a world.
    pub snapshot: Option<&'a Snapshot>,
    /// Measurements for the lamps.
    pub health: &'a DriveHealth,
    /// The driver's picture, and its size in pixels.
    pub picture: Option<(TextureId, [u32; 2])>,
    /// Events of the scenario; empty without a drive.
    pub events: &'a [ListedEvent],
}

/// Commands of the experimenter.
#[derive(Clone, Debug, PartialEq)]
pub enum ExperimenterCommand {
    /// A command for the drive.
    Drive(PanelCommand),
    /// Mark this moment in the recording; marks are numbered from 1.
    Mark(u32),
    /// Write this note into the recording.
    Note(String),
    /// Begin the event of this number in the scenario by hand.
    BeginEvent(usize),
    /// End the program (Ctrl+Q).
    End,
}

/// Pages of a narrow window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum PanelPage {
    #[default]
    Plan,
    Picture,
    Plots,
    Lamps,
}

/// State of the window.
#[derive(Default)]
pub struct ExperimenterPanel {
    page: PanelPage,
    by_speed: bool,
    screen: space_time::DiagramTexture,
    help_open: bool,
    /// Marks and notes of this session.
    pub notes: SessionNotes,
}

impl ExperimenterPanel {
    /// Shows the window in the root [`Ui`] of a pass, and returns the commands. `log` is the drive so far, if there is
    /// one. `plan` shows the left part in a study; without it, `panel` shows start, pause and settings there.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        state: &ExperimenterState<'_>,
        log: Option<&DriveLog>,
        panel: &mut SettingsPanel,
        mut plan: Option<&mut dyn FnMut(&mut Ui)>,
    ) -> Vec<ExperimenterCommand> {
        let mut commands = Vec::new();
        let may_drive = plan.is_none();
        self.keys(ui, state, may_drive, &mut commands);
        panel.follow(&state.drive);
        let mut left = |ui: &mut Ui, commands: &mut Vec<ExperimenterCommand>| match &mut plan {
            Some(plan) => plan(ui),
            None => {
                let mut asked = Vec::new();
                panel.drive(ui, &state.drive, &mut asked);
                commands.extend(asked.into_iter().map(ExperimenterCommand::Drive));
            }
        };
        let lamps = lamps::lamps(state.health);
        match (self.help_open, may_drive) {
            (true, true) => key_list::show(ui.ctx(), &KEYS),
            (true, false) => key_list::show(ui.ctx(), &super::session::keys()),
            (false, _) => {}
        }
        if ui.available_width() >= WIDE {
            let wide = (PLAN_SHARE * ui.available_width()).clamp(360.0, 560.0);
            egui::Panel::left("plan").default_size(wide).min_size(300.0).show(ui, |ui| left(ui, &mut commands));
            egui::Panel::right("lamps").default_size(312.0).min_size(270.0).show(ui, |ui| {
                self.right(ui, state, &lamps, may_drive, &mut commands);
            });
            egui::CentralPanel::default().show(ui, |ui| {
                let height = ui.available_height();
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    // Without a drive nothing is shown below: the picture, with the pages that the participant reads,
                    // takes the height.
                    let most = if log.is_some() { 0.3 * height } else { height };
                    let top = self.pictures(ui, state, log, most);
                    self.plots(ui, state, log, height - top);
                });
            });
            return commands;
        }
        egui::Panel::top("pages").show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                let plan = if may_drive { "Drive" } else { "Plan" };
                for (page, name) in [
                    (PanelPage::Plan, plan),
                    (PanelPage::Picture, "Picture"),
                    (PanelPage::Plots, "Plots"),
                    (PanelPage::Lamps, "State"),
                ] {
                    ui.selectable_value(&mut self.page, page, name);
                }
                ui.separator();
                lamps::strip(ui, &lamps);
            });
        });
        egui::CentralPanel::default().show(ui, |ui| match self.page {
            PanelPage::Plan => left(ui, &mut commands),
            PanelPage::Lamps => self.right(ui, state, &lamps, may_drive, &mut commands),
            PanelPage::Picture => {
                let height = ui.available_height();
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.pictures(ui, state, log, height));
            }
            PanelPage::Plots => {
                let height = ui.available_height();
                ScrollArea::vertical().auto_shrink(false).show(ui, |ui| self.plots(ui, state, log, height));
            }
        });
        commands
    }

    /// Handles the keys that work wherever the focus is.
    fn keys(
        &mut self,
        ui: &Ui,
        state: &ExperimenterState<'_>,
        may_drive: bool,
        commands: &mut Vec<ExperimenterCommand>,
    ) {
        // A key held down repeats; only the first press counts.
        let pressed = |modifiers, wanted| {
            ui.input_mut(|input| {
                let first = |event: &Event| matches!(event, Event::Key { key, repeat: false, pressed: true, .. } if *key == wanted);
                let first = input.events.iter().any(first);
                input.consume_key(modifiers, wanted) && first
            })
        };
        let time_s = state.drive.readings.map_or(0.0, |now| now.time_s);
        if pressed(Modifiers::NONE, Key::F1) || (self.help_open && pressed(Modifiers::NONE, Key::Escape)) {
            self.help_open = !self.help_open;
        }
        if !may_drive && ui.input(|input| input.modifiers.command && input.keys_down.iter().any(is_letter)) {
            // Shows the page on which the session's commands are.
            self.page = PanelPage::Plan;
        }
        if may_drive && pressed(Modifiers::COMMAND, Key::P) {
            match state.drive.phase {
                DrivePhase::Running => commands.push(ExperimenterCommand::Drive(PanelCommand::Pause)),
                DrivePhase::Ready | DrivePhase::Paused => {
                    commands.push(ExperimenterCommand::Drive(PanelCommand::Start))
                }
                DrivePhase::Starting | DrivePhase::Ended => {}
            }
        }
        if may_drive && pressed(Modifiers::COMMAND, Key::M) {
            self.notes.mark(time_s, commands);
        }
        if may_drive && pressed(Modifiers::COMMAND, Key::N) {
            self.page = PanelPage::Lamps;
            self.notes.focus();
        }
        if may_drive && pressed(Modifiers::COMMAND, Key::Q) {
            commands.push(ExperimenterCommand::End);
        }
        let pages = [PanelPage::Plan, PanelPage::Picture, PanelPage::Plots, PanelPage::Lamps];
        for (key, page) in [Key::Num1, Key::Num2, Key::Num3, Key::Num4].into_iter().zip(pages) {
            if pressed(Modifiers::COMMAND, key) {
                self.page = page;
            }
        }
    }

    /// Shows the driver's picture, and the road from above if there is a log, at most about `most` points high. Returns
    /// the height used, points.
    fn pictures(&mut self, ui: &mut Ui, state: &ExperimenterState<'_>, log: Option<&DriveLog>, most: f32) -> f32 {
        let begin = ui.cursor().top();
        let room = ui.available_width();
        // Side by side if both are large enough.
        let beside = room > 480.0 && log.is_some();
        let width = if beside { (room - 8.0) * 0.6 } else { room };
        let height = (width * 9.0 / 16.0).min((most - HEADING).max(130.0));
        let both = |ui: &mut Ui, this: &mut Self| {
            ui.allocate_ui(vec2(width, height + HEADING), |ui| {
                ui.vertical(|ui| {
                    ui.horizontal(|ui| {
                        ui.set_min_height(HEADING);
                        title(ui, "View of the participant");
                    });
                    picture(ui, state.picture, vec2(width, height));
                });
            });
            let Some(log) = log else { return };
            ui.vertical(|ui| {
                let width = if beside { room - width - 8.0 } else { room };
                ui.horizontal(|ui| {
                    ui.set_min_height(HEADING);
                    title(ui, "From above");
                    ui.checkbox(&mut this.by_speed, RichText::new("by speed").size(12.0))
                        .on_hover_text("Colour the other vehicles by their speed");
                });
                map::show(ui, log, state.snapshot, this.by_speed, width, height);
            });
        };
        if beside {
            ui.horizontal_top(|ui| both(ui, self));
        } else {
            both(ui, self);
        }
        ui.cursor().top() - begin
    }

    /// Shows speeds over time and the space-time diagram, in `room` points of height if that is enough.
    fn plots(&mut self, ui: &mut Ui, state: &ExperimenterState<'_>, log: Option<&DriveLog>, room: f32) {
        let Some(log) = log else { return };
        let last_s = log.speeds.back().map_or(0.0, |row| row.time_s);
        let time_s = state.drive.readings.map_or(last_s, |now| now.time_s);
        let field = |share: f32, least: f32| (share * (room - 3.0 * HEADING - 20.0)).max(least);
        // The plots of a finished drive stay and are labelled as such.
        let last = if state.snapshot.is_none() { " (last drive)" } else { "" };
        readout::plot(ui, &log.history, field(0.33, 90.0));
        title(ui, &format!("All vehicles, m/s; yellow: the participant{last}"));
        plots::cars(ui, log, time_s, field(0.27, 80.0));
        ui.horizontal(|ui| {
            title(ui, &format!("Space and time, metres along the road{last}"));
            map::key(ui, log.top_mps);
        });
        log.space_time.show(ui, &mut self.screen, log.window(time_s), field(0.4, 110.0));
    }

    /// Shows numbers, lamps, notes.
    fn right(
        &mut self,
        ui: &mut Ui,
        state: &ExperimenterState<'_>,
        lamps: &[Lamp],
        may_drive: bool,
        commands: &mut Vec<ExperimenterCommand>,
    ) {
        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
            ui.add_space(4.0);
            readout::numbers(ui, &state.drive);
            let advice = state.drive.readings.and_then(|now| now.advice);
            if let Some(driver) = advice.and_then(|advice| advice.driver) {
                ui.separator();
                title(ui, "Driver, as estimated by the policy");
                readout::driver(ui, &driver);
            }
            if let Some(observed) = advice.and_then(|advice| advice.observed) {
                ui.separator();
                title(ui, "Driver, as observed from speed and advice");
                readout::observed_driver(ui, &observed);
            }
            ui.separator();
            lamps::show(ui, lamps);
            ui.separator();
            if !state.events.is_empty() {
                title(ui, "Events");
                events::show(ui, state.events, commands);
                ui.separator();
            }
            let time_s = state.drive.readings.map_or(0.0, |now| now.time_s);
            if may_drive {
                self.notes.show(ui, time_s, commands);
            } else {
                // The session has its own buttons for marks and notes; only the list is shown.
                self.notes.list(ui);
            }
        });
    }
}

/// Returns true for a letter: session commands are letters with Ctrl.
fn is_letter(key: &Key) -> bool {
    (Key::A..=Key::Z).contains(key)
}

fn title(ui: &mut Ui, text: &str) {
    ui.label(RichText::new(text).color(theme::DIM).size(12.5));
}

/// Shows a texture in a field, as large as its aspect ratio allows.
fn picture(ui: &mut Ui, picture: Option<(TextureId, [u32; 2])>, room: Vec2) {
    let Some((texture, [width, height])) = picture.filter(|(_, size)| size[0] > 0 && size[1] > 0) else {
        nothing(ui, room, "no picture yet");
        return;
    };
    let size = vec2(width as f32, height as f32);
    let scale = (room.x / size.x).min(room.y / size.y);
    let image = egui::Image::new((texture, size * scale)).alt_text("The driver's picture");
    ui.allocate_ui_with_layout(room, egui::Layout::top_down(egui::Align::Center), |ui| ui.add(image));
}

fn nothing(ui: &mut Ui, room: Vec2, why: &str) {
    let (response, painter) = ui.allocate_painter(room, egui::Sense::hover());
    painter.rect_filled(response.rect, 4.0, egui::Color32::from_rgb(14, 16, 20));
    let font = egui::FontId::proportional(13.0);
    painter.text(response.rect.center(), egui::Align2::CENTER_CENTER, why, font, theme::DIM);
}
