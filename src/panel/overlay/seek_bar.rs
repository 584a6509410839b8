//! Seek bar of a replay: play and pause, speed, a timeline with advice and events. In: a [`SeekBarState`]. Out:
//! [`SeekBarCommand`]s. Times in seconds, speeds in m/s.

use crate::panel::{readout::time, theme};
use egui::{Align2, Color32, FontId, Rect, RichText, Sense, Shape, Stroke, Ui, pos2, vec2};

/// Event on the timeline.
#[derive(Clone, Debug, PartialEq)]
pub struct SeekBarEvent {
    /// Time since the start of the drive, s.
    pub time_s: f64,
    /// Description shown at the pointer.
    pub words: String,
}

/// Advice from a time on, until the next entry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdviceSince {
    /// Start of the advice, s.
    pub time_s: f64,
    /// Advised speed, m/s; `None` if the advice ends.
    pub target_mps: Option<f64>,
}

/// Content of the seek bar.
#[derive(Clone, Copy, Debug)]
pub struct SeekBarState<'a> {
    /// Time of the shown moment, s.
    pub time_s: f64,
    /// End of the recording, s.
    pub end_s: f64,
    /// Time up to which the recording has been simulated again, s.
    pub known_s: f64,
    /// True while the replay advances by itself.
    pub playing: bool,
    /// Playback speed, as a multiple of the drive's.
    pub speed: f64,
    /// Name of the current view.
    pub view: &'a str,
    /// Advice in order of time.
    pub advice: &'a [AdviceSince],
    /// Ego speed over time: pairs of s and m/s.
    pub speeds: &'a [[f64; 2]],
    /// Events to mark on the timeline.
    pub events: &'a [SeekBarEvent],
    /// Result of the proof so far.
    pub proof: &'a str,
    /// True if the proof found a difference.
    pub differs: bool,
}

/// Commands of the seek bar.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SeekBarCommand {
    /// Start or stop playback.
    Toggle,
    /// Go to this time, s.
    Seek(f64),
    /// Move by this many ticks; negative is back.
    Tick(i64),
    /// The next faster speed (true) or the next slower one (false).
    Speed(bool),
    /// Switch to the next view.
    NextView,
}

/// Height of the timeline, points.
const HEIGHT: f32 = 46.0;

/// Shows the seek bar at the bottom of the window, in the root [`Ui`] of a pass. Returns the commands, and its height
/// in points.
pub fn show(ui: &mut Ui, state: &SeekBarState<'_>) -> (Vec<SeekBarCommand>, f32) {
    let mut commands = Vec::new();
    let panel = egui::Panel::bottom("timeline").show(ui, |ui| {
        ui.add_space(3.0);
        line(ui, state, &mut commands);
        ui.horizontal_wrapped(|ui| buttons(ui, state, &mut commands));
        ui.add_space(3.0);
    });
    (commands, panel.response.rect.height())
}

fn buttons(ui: &mut Ui, state: &SeekBarState<'_>, commands: &mut Vec<SeekBarCommand>) {
    let mut button = |ui: &mut Ui, text: &str, tip: &str, command: SeekBarCommand| {
        if ui.button(text).on_hover_text(tip).clicked() {
            commands.push(command);
        }
    };
    let word = if state.playing { "Hold" } else { "Play" };
    button(ui, word, "Play or pause (Space)", SeekBarCommand::Toggle);
    button(ui, "−1 tick", "Back by 0.01 s (Left; with Shift 1 s, Page Up 10 s)", SeekBarCommand::Tick(-1));
    button(ui, "+1 tick", "Forward by 0.01 s (Right; with Shift 1 s, Page Down 10 s)", SeekBarCommand::Tick(1));
    button(ui, "Slower", "Half as fast (Down)", SeekBarCommand::Speed(false));
    ui.label(RichText::new(format!("{}×", state.speed)).monospace());
    button(ui, "Faster", "Twice as fast (Up)", SeekBarCommand::Speed(true));
    button(ui, state.view, "Another view (V)", SeekBarCommand::NextView);
    ui.separator();
    ui.label(RichText::new(format!("{} of {}", time(state.time_s), time(state.end_s))).monospace());
    ui.separator();
    let waits = state.time_s > state.known_s + 1e-6;
    if waits {
        let share = 100.0 * state.known_s / state.time_s;
        ui.label(RichText::new(format!("driving again up to here: {share:.0} %")).color(theme::AMBER));
    }
    ui.label(RichText::new(state.proof).color(if state.differs { theme::RED } else { theme::DIM }));
}

/// Shows the timeline: the simulated part lighter, ego speed and advice as curves, events and the current time as
/// marks.
fn line(ui: &mut Ui, state: &SeekBarState<'_>, commands: &mut Vec<SeekBarCommand>) {
    let (response, painter) = ui.allocate_painter(vec2(ui.available_width(), HEIGHT), Sense::click_and_drag());
    let all = response.rect;
    let field = Rect::from_min_max(all.min + vec2(2.0, 2.0), all.max - vec2(2.0, 14.0));
    let end_s = state.end_s.max(0.01);
    let x = |time_s: f64| field.left() + (time_s / end_s) as f32 * field.width();
    painter.rect_filled(field, 2.0, Color32::from_rgb(14, 16, 20));
    let known = Rect::from_min_max(field.min, pos2(x(state.known_s.min(end_s)), field.bottom()));
    painter.rect_filled(known, 2.0, Color32::from_rgb(36, 42, 50));
    let advised = state.advice.iter().filter_map(|advice| advice.target_mps);
    let top_mps = advised.chain(state.speeds.iter().map(|[_, v]| *v)).fold(4.0, f64::max) * 1.1;
    let y = |speed_mps: f64| field.bottom() - (speed_mps / top_mps) as f32 * field.height();
    for (i, advice) in state.advice.iter().enumerate() {
        let Some(target_mps) = advice.target_mps else { continue };
        let to_s = state.advice.get(i + 1).map_or(end_s, |next| next.time_s);
        painter.hline(x(advice.time_s)..=x(to_s), y(target_mps), Stroke::new(1.2, theme::RED));
    }
    let speeds: Vec<_> = state.speeds.iter().map(|[t, v]| pos2(x(*t), y(*v))).collect();
    painter.add(Shape::line(speeds, Stroke::new(1.2, theme::AMBER)));
    for event in state.events {
        let foot = pos2(x(event.time_s), field.bottom());
        let corners = vec![foot, foot + vec2(-4.0, 6.0), foot + vec2(4.0, 6.0)];
        painter.add(Shape::convex_polygon(corners, theme::ACCENT, Stroke::NONE));
    }
    let step_s =
        [1.0, 5.0, 10.0, 30.0, 60.0, 300.0, 600.0, 3600.0].into_iter().find(|s| end_s / s <= 8.0).unwrap_or(7200.0);
    for i in 0..=(end_s / step_s) as u32 {
        let at = f64::from(i) * step_s;
        let text = time(at).trim_end_matches(".0").to_owned();
        let align = if x(at) > field.right() - 16.0 { Align2::RIGHT_BOTTOM } else { Align2::LEFT_BOTTOM };
        painter.text(pos2(x(at), all.bottom()), align, text, FontId::proportional(10.5), theme::DIM);
    }
    painter.vline(x(state.time_s), field.y_range(), Stroke::new(2.0, Color32::WHITE));
    let pointed = response.interact_pointer_pos().or(response.hover_pos());
    let Some(at_s) = pointed.map(|at| f64::from((at.x - field.left()) / field.width()).clamp(0.0, 1.0) * end_s) else {
        return;
    };
    if response.clicked() || response.dragged() {
        commands.push(SeekBarCommand::Seek(at_s));
    }
    response.on_hover_ui_at_pointer(|ui| {
        ui.label(time(at_s));
        for event in state.events.iter().filter(|event| (x(event.time_s) - x(at_s)).abs() < 5.0) {
            ui.label(&event.words);
        }
        let advice = state.advice.iter().rev().find(|advice| advice.time_s <= at_s);
        if let Some(target_mps) = advice.and_then(|advice| advice.target_mps) {
            ui.label(RichText::new(format!("advice {target_mps:.2} m/s")).color(theme::RED));
        }
    });
}
