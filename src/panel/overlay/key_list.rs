//! The list of keys, over the picture. In: keys and their actions, as data. Out: shapes.

use egui::{Align2, Context, Frame, Label, RichText, vec2};

use crate::panel::theme;

/// Key that every window of an experimenter has.
pub(in crate::panel) const FULL_SCREEN: (&str, &str) = ("F11", "full screen");

/// Height of a line, height around the lines, and width of the list, points, before it grows with the window.
const LINE: f32 = 22.0;
const AROUND: f32 = 70.0;
const WIDTH: f32 = 620.0;
/// Largest letter size, as a share of the window's height.
const LARGEST: f32 = 0.028;
/// Share of the window's height that the list takes when it grows.
const SHARE: f32 = 0.8;

/// Shows the keys in the middle of the window, large enough for a participant in the driver's seat; in two columns of
/// small letters where one would be too high.
pub fn show<K: AsRef<str>>(ctx: &Context, keys: &[(K, &str)]) {
    let room = ctx.content_rect().size();
    let height = keys.len() as f32 * LINE + AROUND;
    let columns = if height > room.y { 2 } else { 1 };
    let rows = keys.len().div_ceil(columns);
    let grown = (SHARE * room.y / height).min(room.x / WIDTH).min(LARGEST * room.y / 14.0).max(1.0);
    let (size, apart) = if columns > 1 { (11.0, vec2(12.0, 2.0)) } else { (14.0 * grown, vec2(24.0, 5.0) * grown) };
    // A long description wraps, so that it stays in the window.
    let width = if columns > 1 { 0.5 * room.x - 140.0 } else { f32::INFINITY };
    let area = egui::Area::new(egui::Id::unique("keys")).order(egui::Order::Foreground);
    area.anchor(Align2::CENTER_CENTER, vec2(0.0, 0.0)).interactable(false).show(ctx, |ui| {
        Frame::window(ui.style()).fill(theme::PANEL.gamma_multiply(0.96)).show(ui, |ui| {
            ui.label(RichText::new("Keys").size(if columns > 1 { 16.0 } else { 16.0 * grown }));
            ui.add_space(if columns > 1 { 0.0 } else { 6.0 });
            egui::Grid::new("keys").num_columns(2 * columns).spacing(apart).show(ui, |ui| {
                for row in 0..rows {
                    for (key, what) in (0..columns).filter_map(|column| keys.get(column * rows + row)) {
                        ui.label(RichText::new(key.as_ref()).monospace().size(size).color(theme::ACCENT));
                        ui.scope(|ui| {
                            ui.set_max_width(width);
                            ui.add(Label::new(RichText::new(*what).size(size)).wrap());
                        });
                    }
                    ui.end_row();
                }
            });
        });
    });
}
