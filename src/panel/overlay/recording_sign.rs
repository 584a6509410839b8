//! Sign in every window whether a drive is recorded. In: the folder, if there is one. Out: a red REC with its name, or
//! a note that the drive is not recorded.

use crate::panel::theme;
use egui::{Color32, Label, RichText, Ui};
use std::path::Path;

/// Radius of the lamp, points.
pub const LAMP: f32 = 5.0;

/// Returns the text and its colour. Only the folder's own name is shown, because a participant reads it too.
pub fn text_and_colour(folder: Option<&Path>) -> (String, Color32) {
    let Some(folder) = folder else { return ("not recorded".into(), theme::DIM) };
    let name = folder.file_name().unwrap_or(folder.as_os_str());
    (format!("REC {}", name.to_string_lossy()), theme::RED)
}

/// Shows the sign in the rest of a right-to-left row; the tooltip has the full path.
pub(in crate::panel) fn show(ui: &mut Ui, folder: Option<&Path>) {
    let (text, colour) = text_and_colour(folder);
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
