//! Telltale of the automation on the speedometer. In: a [`DialView`]. Out: shapes of a steering wheel, or of a gauge for a system that keeps the speed
//! alone, in the colour of its state.

use super::{
    brush::{DialBrush, opaque},
    layout,
};
use crate::hud::{AutomationLamp, DialView, LampState, Palette};
use egui::{Pos2, Stroke, vec2};
use std::f32::consts::TAU;

/// Draws the telltale: grey while the system is off, green while it drives, amber in a takeover request, red in an urgent one.
pub(super) fn automation_lamp(brush: &DialBrush<'_>, dial: &DialView, palette: &Palette) {
    let Some(AutomationLamp { state, steers }) = dial.automation else { return };
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
}
