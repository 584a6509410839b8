//! The calibration page: live values of wheel and pedals, the questions of a calibration, the assignment of buttons.
//! In: a [`PluggedWheel`], plain numbers of the moment. Out: [`CalibrationCommand`]s.

use egui::{Button, Color32, DragValue, Rect, RichText, Sense, Stroke, TextEdit, Ui, pos2, vec2};

use crate::input::{
    ButtonAction, RigButton, WheelProfile,
    calibrate::CalibrationStep,
    profile::{Pedal, ProfileError},
};
use crate::panel::theme;
use std::collections::BTreeMap;

/// Current state of the wheel that is plugged in.
#[derive(Clone, Debug)]
pub struct PluggedWheel {
    /// Device name of the wheel.
    pub device: String,
    /// Profile that interprets the raw values.
    pub profile: WheelProfile,
    /// Last raw value by axis number.
    pub raw: BTreeMap<u16, i32>,
    /// Button of the rig that was pressed last.
    pub last_button: Option<RigButton>,
    /// Calibration in progress, if any.
    pub asked: Option<CalibrationProgress>,
}

/// State of a calibration in progress.
#[derive(Clone, Debug)]
pub struct CalibrationProgress {
    /// Question that is asked now.
    pub step: CalibrationStep,
    /// All axes: number, name, position as a share of the range (see `Calibration::bars`).
    pub bars: Vec<(u16, String, f64)>,
    /// Resulting profile; `None` before the end.
    pub learnt: Option<Result<WheelProfile, ProfileError>>,
}

/// Commands of the page.
#[derive(Clone, Debug, PartialEq)]
pub enum CalibrationCommand {
    /// Start the calibration from the first question.
    Begin,
    /// Cancel the calibration; the profile stays unchanged.
    Cancel,
    /// Save this profile as the user's own and use it.
    Save(Box<WheelProfile>),
    /// The page was closed.
    Close,
}

/// State of the page: edits.
#[derive(Debug, Default)]
pub struct CalibrationPage {
    /// True while the page is shown.
    pub open: bool,
    /// Edited profile; `None` shows the wheel's own.
    edited: Option<WheelProfile>,
    /// Action that waits for a button.
    waiting: Option<ButtonAction>,
    /// Last button pressed before the wait began.
    before: Option<RigButton>,
    /// True once the result of this calibration has been taken over.
    taken: bool,
}

impl CalibrationPage {
    /// Shows the page if it is open, and returns the commands. `wheel` is `None` if none is plugged in; `message` is the
    /// outcome of the last command.
    pub fn show(&mut self, ui: &Ui, wheel: Option<&PluggedWheel>, message: Option<&str>) -> Vec<CalibrationCommand> {
        let mut commands = Vec::new();
        let mut open = self.open;
        egui::Window::new("Wheel and pedals").open(&mut open).resizable(false).default_width(520.0).show(
            ui.ctx(),
            |ui| {
                match wheel {
                    None => {
                        ui.label("No steering wheel is plugged in. Plug it in and wait until it has turned.");
                    }
                    Some(wheel) => self.page(ui, wheel, &mut commands),
                }
                if let Some(message) = message {
                    ui.separator();
                    ui.label(RichText::new(message).color(theme::AMBER));
                }
            },
        );
        if self.open && !open {
            *self = Self::default();
            commands.push(CalibrationCommand::Close);
        }
        commands
    }

    fn page(&mut self, ui: &mut Ui, wheel: &PluggedWheel, commands: &mut Vec<CalibrationCommand>) {
        self.listen(wheel);
        let shown = self.edited.as_ref().unwrap_or(&wheel.profile).clone();
        ui.label(RichText::new(format!("{}, profile {}", wheel.device, shown.name)).color(theme::DIM));
        ui.add_space(4.0);
        match &wheel.asked {
            Some(asked) if asked.step != CalibrationStep::Done => question(ui, asked, commands),
            _ => {
                self.live(ui, wheel, &shown);
                ui.add_space(6.0);
                self.buttons(ui, wheel, &shown);
                ui.add_space(6.0);
                self.end(ui, wheel, commands);
            }
        }
    }

    /// Takes over the result of a calibration, and the button for a waiting action.
    fn listen(&mut self, wheel: &PluggedWheel) {
        match &wheel.asked {
            None => self.taken = false,
            Some(asked) => {
                if let (Some(Ok(learnt)), false) = (&asked.learnt, self.taken) {
                    self.edited = Some(learnt.clone());
                    self.taken = true;
                }
            }
        }
        if let (Some(action), Some(button)) = (self.waiting, &wheel.last_button)
            && self.before.as_ref() != Some(button)
        {
            self.edited.get_or_insert_with(|| wheel.profile.clone()).buttons.give(button.clone(), action);
            self.waiting = None;
        }
    }

    /// Shows bars and curves of the shown profile at the current values.
    fn live(&mut self, ui: &mut Ui, wheel: &PluggedWheel, shown: &WheelProfile) {
        let raw = |axis: u16| wheel.raw.get(&axis).copied();
        let steering = &shown.steering;
        let turn = raw(steering.axis).map_or(0.0, |raw| steering.wheel_rad(raw));
        ui.horizontal(|ui| {
            ui.label(RichText::new("Steering").color(theme::DIM));
            let half = (steering.range_deg / 2.0).to_radians();
            // The bar runs from the middle; positive angles are left.
            bar_from_middle(ui, -turn / half);
            ui.monospace(format!("{:+7.1}°", turn.to_degrees()));
        });
        let mut edited = shown.clone();
        ui.horizontal(|ui| {
            let range = DragValue::new(&mut edited.steering.range_deg).range(90.0..=2520.0).suffix("°").max_decimals(0);
            number(ui, "Turn from end to end", range);
            let ratio = DragValue::new(&mut edited.steering.ratio).range(5.0..=40.0).speed(0.05).max_decimals(1);
            number(ui, "ratio", ratio);
        });
        ui.add_space(4.0);
        ui.horizontal(|ui| {
            let WheelProfile { accelerator, brake, handbrake, .. } = &mut edited;
            let pedals =
                [("Accelerator", Some(accelerator)), ("Brake", brake.as_mut()), ("Handbrake", handbrake.as_mut())];
            for (name, pedal) in pedals {
                let Some(pedal) = pedal else { continue };
                ui.vertical(|ui| {
                    let now = raw(pedal.code());
                    ui.label(RichText::new(format!("{name}, axis {}", pedal.axis)).color(theme::DIM));
                    curve(ui, pedal, now);
                    let position_text = now.map_or("not read yet".into(), |raw| {
                        format!("travel {:3.0} %  effect {:3.0} %", 100.0 * pedal.way(raw), 100.0 * pedal.effect(raw))
                    });
                    ui.monospace(position_text);
                    ui.horizontal(|ui| {
                        let curve = DragValue::new(&mut pedal.curve).range(0.3..=4.0).speed(0.01).max_decimals(2);
                        number(ui, "curve", curve);
                        let dead = DragValue::new(&mut pedal.dead).range(0.0..=0.4).speed(0.001).max_decimals(3);
                        number(ui, "dead", dead);
                    });
                });
                ui.add_space(10.0);
            }
        });
        if edited != *shown {
            self.edited = Some(edited);
        }
    }

    /// Shows the button of each action; a click on an action waits for its new button.
    fn buttons(&mut self, ui: &mut Ui, wheel: &PluggedWheel, shown: &WheelProfile) {
        ui.horizontal(|ui| {
            ui.label(RichText::new("Buttons").strong());
            let last = wheel.last_button.as_ref().map_or("press one to see its number".into(), |button| {
                let does = shown.buttons.action(button.code()).map_or("nothing".into(), |action| action.to_string());
                format!("pressed last: {button}, {does}")
            });
            ui.label(RichText::new(last).color(theme::DIM));
        });
        egui::Grid::new("buttons").num_columns(4).spacing([14.0, 3.0]).show(ui, |ui| {
            for (i, action) in ButtonAction::ALL.into_iter().enumerate() {
                let codes: Vec<String> = shown.buttons.clone().of(action).iter().map(RigButton::to_string).collect();
                let (text, colour) = match self.waiting {
                    Some(waiting) if waiting == action => ("press it ...".to_owned(), theme::AMBER),
                    _ if codes.is_empty() => ("none".to_owned(), theme::DIM),
                    _ => (codes.join(", "), theme::TEXT),
                };
                ui.label(action.to_string());
                let button = Button::new(RichText::new(text).color(colour).monospace()).min_size(vec2(92.0, 0.0));
                let name = format!("button for {action}");
                let response = ui
                    .add(button)
                    .on_hover_text("Click, then press the button on the wheel or on another device of the rig");
                response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, &name));
                if response.clicked() {
                    self.waiting = (self.waiting != Some(action)).then_some(action);
                    self.before = wheel.last_button.clone();
                }
                if i % 2 == 1 {
                    ui.end_row();
                }
            }
        });
    }

    fn end(&mut self, ui: &mut Ui, wheel: &PluggedWheel, commands: &mut Vec<CalibrationCommand>) {
        if let Some(CalibrationProgress { learnt: Some(Err(error)), .. }) = &wheel.asked {
            ui.label(RichText::new(error.to_string()).color(theme::RED));
        }
        ui.horizontal(|ui| {
            let ask =
                Button::new(RichText::new("Calibrate").color(Color32::WHITE)).fill(Color32::from_rgb(36, 96, 150));
            if ui.add(ask).on_hover_text("Measure axes, ends and rest positions; the drive is paused").clicked() {
                *self = Self { open: true, ..Self::default() };
                commands.push(CalibrationCommand::Begin);
            }
            if let Some(edited) = &mut self.edited {
                let label = ui.label("Name");
                ui.add(TextEdit::singleline(&mut edited.name).desired_width(180.0)).labelled_by(label.id);
            }
            if let Some(edited) = self.edited.clone() {
                let named = !edited.name.trim().is_empty();
                let save = ui.add_enabled(named, Button::new("Save")).on_hover_text("Save as a new profile and use it");
                if save.clicked() {
                    self.edited = None;
                    commands.push(CalibrationCommand::Save(Box::new(edited)));
                } else if ui.button("Discard").on_hover_text("Keep the profile as it is").clicked() {
                    *self = Self { open: true, taken: self.taken, ..Self::default() };
                    commands.push(CalibrationCommand::Cancel);
                }
            }
        });
    }
}

/// Shows a number field after its name.
fn number(ui: &mut Ui, name: &str, value: DragValue<'_>) {
    let label = ui.label(RichText::new(name).color(theme::DIM));
    ui.add(value).labelled_by(label.id);
}

/// Shows the question, and all axes as bars.
fn question(ui: &mut Ui, asked: &CalibrationProgress, commands: &mut Vec<CalibrationCommand>) {
    ui.label(RichText::new(asked.step.question()).size(20.0).color(theme::ACCENT));
    ui.add_space(6.0);
    egui::Grid::new("axes").num_columns(2).spacing([14.0, 5.0]).show(ui, |ui| {
        for (_, name, share) in &asked.bars {
            ui.label(name);
            bar(ui, *share);
            ui.end_row();
        }
    });
    ui.add_space(8.0);
    if ui.button("Cancel").clicked() {
        commands.push(CalibrationCommand::Cancel);
    }
}

const BAR: egui::Vec2 = vec2(300.0, 14.0);

fn bar(ui: &mut Ui, share: f64) {
    let (rect, _) = ui.allocate_exact_size(BAR, Sense::hover());
    ui.painter().rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    let full = Rect::from_min_size(rect.min, vec2(rect.width() * share.clamp(0.0, 1.0) as f32, rect.height()));
    ui.painter().rect_filled(full, 2.0, theme::ACCENT);
}

/// Draws a bar from the middle, `share` from -1 at the left end to 1 at the right.
fn bar_from_middle(ui: &mut Ui, share: f64) {
    let (rect, _) = ui.allocate_exact_size(BAR, Sense::hover());
    ui.painter().rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    let middle = rect.center().x;
    let end = middle + rect.width() / 2.0 * share.clamp(-1.0, 1.0) as f32;
    let part = Rect::from_x_y_ranges(middle.min(end)..=middle.max(end), rect.y_range());
    ui.painter().rect_filled(part, 2.0, theme::ACCENT);
    ui.painter().vline(middle, rect.y_range(), Stroke::new(1.0, theme::TEXT));
}

/// Draws the pedal's effect over its travel, with its current position.
fn curve(ui: &mut Ui, pedal: &Pedal, now: Option<i32>) {
    let (rect, _) = ui.allocate_exact_size(vec2(200.0, 110.0), Sense::hover());
    let painter = ui.painter();
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    let at = |way: f64, effect: f32| {
        pos2(rect.left() + rect.width() * way as f32, rect.bottom() - 4.0 - (rect.height() - 8.0) * effect)
    };
    let raw = |way: f64| f64::from(pedal.released) + (f64::from(pedal.pressed) - f64::from(pedal.released)) * way;
    let points: Vec<egui::Pos2> =
        (0..=100).map(|i| f64::from(i) / 100.0).map(|way| at(way, pedal.effect(raw(way).round() as i32))).collect();
    painter.line(points, Stroke::new(1.5, theme::ACCENT));
    if let Some(now) = now {
        let (way, effect) = (pedal.way(now), pedal.effect(now));
        let place = at(way, effect);
        painter.vline(place.x, rect.y_range(), Stroke::new(1.0, theme::DIM));
        painter.circle_filled(place, 4.0, theme::AMBER);
    }
}
