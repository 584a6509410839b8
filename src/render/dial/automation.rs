//! Telltales of the automation on the speedometer. In: a [`DialView`]. Out: shapes of a steering wheel, or of a gauge for a system that keeps the speed
//! alone, in the colour of its state; beside them, for a system that keeps a time gap, a vehicle ahead and one to three bars.

use super::{
    brush::{DialBrush, opaque},
    layout,
};
use crate::hud::{AutomationLamp, DialView, LampState, Palette};
use egui::{Color32, Pos2, Stroke, vec2};
use std::f32::consts::TAU;

/// Draws the telltale: grey while the system is off, green while it drives, amber in a takeover request, red in an urgent one.
pub(super) fn automation_lamp(brush: &DialBrush<'_>, dial: &DialView, palette: &Palette) {
    let Some(AutomationLamp { state, steers, gap_bars }) = dial.automation else { return };
    let colour = opaque(match state {
        LampState::Off => palette.label,
        LampState::On => palette.indicator,
        LampState::Request => palette.reverse,
        LampState::Urgent => palette.target,
    });
    let (left, down, radius, width) = layout::AUTOMATION;
    let middle = brush.centre + vec2(-left, down) * brush.radius;
    let stroke = Stroke::new(brush.at_least_px(width, 1.5) * brush.radius, colour);
    // A turn of 0 is downwards; positive turns are clockwise.
    let at = |turn: f32, share: f32| -> Pos2 {
        let (sin, cos) = (turn * TAU).sin_cos();
        middle + vec2(-sin, cos) * share * radius * brush.radius
    };
    if steers {
        brush.painter.circle_stroke(middle, radius * brush.radius, stroke);
        brush.painter.circle_filled(middle, 0.28 * radius * brush.radius, colour);
        for spoke in [0.0, 0.29, -0.29] {
            brush.painter.line_segment([at(spoke, 0.2), at(spoke, 1.0)], stroke);
        }
    } else {
        let arc = (0..=24).map(|k| at(0.125 + 0.75 * k as f32 / 24.0, 1.0)).collect();
        brush.painter.line(arc, stroke);
        brush.painter.line_segment([middle, at(0.66, 0.72)], stroke);
        brush.painter.circle_filled(middle, 0.18 * radius * brush.radius, colour);
    }
    if gap_bars > 0 {
        time_gap(brush, gap_bars, colour);
    }
}

/// Draws a vehicle ahead and the three bars of the time gap, the nearest and widest one first; those beyond `bars` are dim.
fn time_gap(brush: &DialBrush<'_>, bars: u8, colour: Color32) {
    let (right, down, width, height) = layout::TIME_GAP;
    // Draws an upright trapezium by its place above the lowest bar, in heights of a bar, and its widths at both ends.
    let shape = |[from, to]: [f32; 2], [below, above]: [f32; 2], colour: Color32| {
        let at =
            |side: f32, up: f32| brush.centre + vec2(right + side * width / 2.0, down - up * height) * brush.radius;
        brush.polygon(vec![at(-below, from), at(below, from), at(above, to), at(-above, to)], colour);
    };
    for number in 0..3 {
        let (from, share) = (1.5 * f32::from(number), 1.0 - 0.15 * f32::from(number));
        shape([from, from + 1.0], [share; 2], if number < bars { colour } else { colour.gamma_multiply(0.25) });
    }
    // The vehicle: its body, and a narrower roof.
    shape([4.8, 6.3], [0.6; 2], colour);
    shape([6.3, 7.5], [0.46, 0.3], colour);
}
