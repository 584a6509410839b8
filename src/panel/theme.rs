//! Colours and sizes of the panel: dark, so that a laptop beside the rig does not light the room.

use egui::{
    Color32, CornerRadius, FontData, FontFamily, FontId, Margin, Stroke, TextStyle,
    epaint::text::{FontInsert, FontPriority, InsertFontFamily},
    vec2,
};

/// Mean speed of all vehicles; interactive elements.
pub const ACCENT: Color32 = Color32::from_rgb(92, 170, 235);
/// Ego speed; edited settings.
pub const AMBER: Color32 = Color32::from_rgb(240, 186, 92);
/// Speed inside the advised range.
pub const GREEN: Color32 = Color32::from_rgb(84, 210, 130);
/// Target speed; errors; the end of a drive.
pub const RED: Color32 = Color32::from_rgb(255, 107, 107);
/// Main text: values and names.
pub const TEXT: Color32 = Color32::from_rgb(222, 226, 231);
/// Text of labels and secondary text.
pub const DIM: Color32 = Color32::from_rgb(150, 158, 168);
/// Background of panels and of the display check.
pub const PANEL: Color32 = Color32::from_rgb(22, 25, 30);

/// Adds a fallback font for letters that the other fonts lack; check it with [`crate::plot::is_font`] first.
pub fn add_font(ctx: &egui::Context, bytes: &[u8]) {
    let families = [FontFamily::Proportional, FontFamily::Monospace]
        .map(|family| InsertFontFamily { family, priority: FontPriority::Lowest });
    ctx.add_font(FontInsert::new("study", FontData::from_owned(bytes.to_vec()), families.into()));
}

/// Applies the theme to a context; once, before its first pass.
pub fn apply(ctx: &egui::Context) {
    ctx.set_theme(egui::Theme::Dark);
    ctx.style_mut_of(egui::Theme::Dark, |style| {
        let sizes = [(TextStyle::Small, 11.5), (TextStyle::Body, 14.0), (TextStyle::Button, 14.0)];
        style.text_styles.extend(sizes.map(|(name, size)| (name, FontId::proportional(size))));
        style.text_styles.insert(TextStyle::Heading, FontId::proportional(16.0));
        style.text_styles.insert(TextStyle::Monospace, FontId::monospace(13.0));
        style.drag_value_text_style = TextStyle::Monospace;

        let spacing = &mut style.spacing;
        spacing.item_spacing = vec2(8.0, 5.0);
        spacing.button_padding = vec2(9.0, 4.0);
        spacing.interact_size = vec2(40.0, 24.0);
        spacing.window_margin = Margin::same(14);
        spacing.scroll = egui::style::ScrollStyle::thin();

        let visuals = &mut style.visuals;
        visuals.panel_fill = PANEL;
        visuals.window_fill = Color32::from_rgb(28, 32, 38);
        visuals.extreme_bg_color = Color32::from_rgb(14, 16, 20);
        visuals.faint_bg_color = Color32::from_rgb(27, 31, 37);
        visuals.window_stroke = Stroke::new(1.0, Color32::from_rgb(52, 58, 66));
        visuals.selection.bg_fill = Color32::from_rgb(38, 84, 124);
        visuals.selection.stroke = Stroke::new(1.0, Color32::WHITE);
        visuals.hyperlink_color = ACCENT;
        visuals.error_fg_color = RED;
        visuals.warn_fg_color = AMBER;
        let widgets = &mut visuals.widgets;
        widgets.noninteractive.fg_stroke.color = TEXT;
        widgets.noninteractive.bg_stroke.color = Color32::from_rgb(42, 47, 55);
        for (state, fill) in [
            (&mut widgets.inactive, Color32::from_rgb(42, 48, 56)),
            (&mut widgets.hovered, Color32::from_rgb(54, 62, 72)),
            (&mut widgets.active, Color32::from_rgb(66, 76, 88)),
            (&mut widgets.open, Color32::from_rgb(48, 55, 64)),
        ] {
            state.bg_fill = fill;
            state.weak_bg_fill = fill;
            state.fg_stroke.color = TEXT;
            state.corner_radius = CornerRadius::same(4);
        }
        // The focused widget gets an edge that is visible from a chair's distance.
        widgets.active.bg_stroke = Stroke::new(2.0, ACCENT);
    });
}
