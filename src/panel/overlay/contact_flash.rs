//! Flash that shows a driver a contact. In: its brightness. Out: a red frame over the picture.

use egui::{Color32, Shape, Stroke, StrokeKind, Ui};

/// Width of the frame as a share of the picture's height: seen in the periphery, without covering road or speedometer.
const WIDTH: f32 = 0.05;

/// Draws a red frame around the whole picture, `brightness` from 0 (none) to 1.
pub fn contact_flash(ui: &Ui, brightness: f32) {
    if brightness <= 0.0 {
        return;
    }
    let whole = ui.ctx().content_rect();
    let colour = Color32::from_rgb(235, 30, 20).gamma_multiply(brightness.min(1.0));
    let frame = Stroke::new(WIDTH * whole.height(), colour);
    let painter = ui.ctx().layer_painter(egui::LayerId::background());
    painter.add(Shape::rect_stroke(whole, 0.0, frame, StrokeKind::Inside));
}
