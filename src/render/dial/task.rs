//! Secondary task in the picture, or on a display of its own. In: its content at the moment. Out: shapes of egui's painter. Places and sizes are
//! shares of the picture's height, so that they are the same at each resolution.

use super::brush::DialBrush;
use crate::{
    hud::{SEARCH_ROWS, cells_across, search_circles},
    snapshot::TaskPicture,
};
use egui::{Color32, Painter, Pos2, Rect, Stroke, Vec2, pos2, vec2};

/// Signal of the detection response task: centre as shares of width and height, and diameter. On a 55-inch television at 1 m it is 26 degrees left of
/// the middle and 1.4 degrees wide.
const SIGNAL_AT: (f32, f32) = (0.10, 0.24);
const SIGNAL_SIZE: f32 = 0.035;
/// Height of a digit, and the free space between it and the instrument.
const DIGIT_HEIGHT: f32 = 0.075;
const DIGIT_GAP: f32 = 0.035;
/// Display of the surrogate reference task: width of all cells, and the margin around them.
const FIELD_WIDTH: f32 = 0.504;
const MARGIN: f32 = 0.02;
/// Width of a circle's line.
const LINE: f32 = 0.0028;
const FIELD: Color32 = Color32::from_rgb(12, 14, 18);
const CURSOR: Color32 = Color32::from_rgb(70, 84, 108);
const CIRCLE: Color32 = Color32::from_rgb(216, 220, 226);
const SIGNAL: Color32 = Color32::from_rgb(255, 24, 16);
/// Closed shutter: as bright as a road by day after the tone curve, so that the eyes need not adapt.
const SHUTTER: Color32 = Color32::from_rgb(118, 120, 122);

/// Paints the task over a picture, whose instrument is in `dial`.
pub(super) fn paint_task(painter: &Painter, screen: Rect, dial: Rect, shown: TaskPicture) {
    let high = screen.height();
    match shown {
        TaskPicture::None => {}
        TaskPicture::Signal => {
            let at = screen.min + vec2(SIGNAL_AT.0 * screen.width(), SIGNAL_AT.1 * high);
            painter.circle_filled(at, SIGNAL_SIZE * high / 2.0, SIGNAL);
        }
        TaskPicture::Digit { digit, .. } => {
            let height = DIGIT_HEIGHT * high;
            let centre = pos2(screen.center().x, dial.top() - DIGIT_GAP * high - height / 2.0);
            painter.circle_filled(centre, 0.95 * height, Color32::from_black_alpha(190));
            let brush = DialBrush { painter, centre, radius: height };
            brush.text(&digit.to_string(), centre, 1.0, Color32::WHITE);
        }
        TaskPicture::Search { columns, .. } => {
            let margin = MARGIN * high;
            let half = search_field(columns, high) / 2.0;
            let centre = screen.left_bottom() + vec2(half.x + 2.0 * margin, -half.y - 2.0 * margin);
            paint_search(painter, centre, high, shown);
        }
        TaskPicture::Closed { .. } => {
            painter.rect_filled(screen, 0.0, SHUTTER);
        }
    }
}

/// Paints a display of the surrogate reference task as large as `room` allows, in its middle; other tasks leave it empty.
pub fn paint_search_display(painter: &Painter, room: Rect, shown: TaskPicture) {
    let TaskPicture::Search { columns, .. } = shown else { return };
    let whole = search_field(columns, 1.0) + vec2(4.0, 4.0) * MARGIN;
    let high = (room.width() / whole.x).min(room.height() / whole.y);
    paint_search(painter, room.center(), high, shown);
}

/// Returns the size of the cells together in a picture of this height.
fn search_field(columns: u8, high: f32) -> Vec2 {
    let across = cells_across(columns);
    vec2(1.0, SEARCH_ROWS as f32 / across as f32) * FIELD_WIDTH * high
}

/// Paints a display of the surrogate reference task around `centre`, with the sizes that it has in a picture of this height.
fn paint_search(painter: &Painter, centre: Pos2, high: f32, shown: TaskPicture) {
    let TaskPicture::Search { seed, columns, target_column, cursor, size_ratio } = shown else { return };
    let (margin, size) = (MARGIN * high, search_field(columns, high));
    let field = Rect::from_center_size(centre, size);
    painter.rect_filled(field.expand(margin), margin, FIELD);
    let column = size.x / f32::from(columns);
    let left = field.left() + column * f32::from(cursor);
    let band = Rect::from_min_size(pos2(left, field.top()), vec2(column, size.y));
    painter.rect_filled(band.expand2(vec2(0.0, margin / 2.0)), 0.0, CURSOR);
    let cell = size.x / cells_across(columns) as f32;
    for circle in search_circles(seed, columns, target_column, size_ratio) {
        let centre: Pos2 = field.min + vec2(circle.centre[0] * size.x, circle.centre[1] * size.y);
        painter.circle_stroke(centre, circle.size * cell / 2.0, Stroke::new((LINE * high).max(1.0), CIRCLE));
    }
}
