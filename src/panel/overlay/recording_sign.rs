//! Shows in every window whether a drive is recorded. In: the folder, if there is one. Out: a red REC with its name, or that
//! nothing is recorded.

use crate::panel::theme;
use egui::{Color32, Label, RichText, Ui};
use std::path::Path;

/// Radius of the lamp before it, points.
pub const LAMP: f32 = 5.0;

/// What is said, and in which colour. The folder's own name alone: a participant reads it too.
pub fn words(folder: Option<&Path>) -> (String, Color32) {
    let Some(folder) = folder else { return ("not recorded".into(), theme::DIM) };
    let name = folder.file_name().unwrap_or(folder.as_os_str());
    (format!("REC {}", name.to_string_lossy()), theme::RED)
}

/// The same in a row from right to left, in what is left of it; the whole path is under the mouse.
pub(in crate::panel) fn show(ui: &mut Ui, folder: Option<&Path>) {
    let (text, colour) = words(folder);
    let line = ui.add(Label::new(RichText::new(text).color(colour).strong()).truncate());
    match folder {
        Some(folder) => line.on_hover_text(folder.display().to_string()),
        None => line.on_hover_text("codrive drive --out FOLDER records a drive"),
    };
    if folder.is_some() {
        let (rect, _) = ui.allocate_exact_size(egui::vec2(2.0 * LAMP, 2.0 * LAMP), egui::Sense::hover());
        ui.painter().circle_filled(rect.center(), LAMP, colour);
    }
}
