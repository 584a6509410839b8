//! The list of keys, over the picture. In: keys and what they do, as data.

use egui::{Align2, Context, Frame, RichText, vec2};

use super::theme;

/// Shows the keys in the middle of the window.
pub fn show(ctx: &Context, keys: &[(&str, &str)]) {
    let area = egui::Area::new(egui::Id::unique("keys")).order(egui::Order::Foreground);
    area.anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0)).interactable(false).show(ctx, |ui| {
        Frame::window(ui.style()).fill(theme::PANEL.gamma_multiply(0.96)).show(ui, |ui| {
            ui.heading("Keys");
            ui.add_space(6.0);
            egui::Grid::new("keys").num_columns(2).spacing([24.0, 5.0]).show(ui, |ui| {
                for (key, what) in keys {
                    ui.label(RichText::new(*key).monospace().color(theme::ACCENT));
                    ui.label(*what);
                    ui.end_row();
                }
            });
        });
    });
}
