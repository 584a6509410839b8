//! Style of the participant's screens: dark, so that the room does not brighten between drives, and large. In: the
//! window's size in points. Out: sizes and colours.

use egui::{Color32, CornerRadius, FontId, Stroke, TextStyle, Ui, Vec2, vec2};

/// Background of the screens.
pub const BACK: Color32 = Color32::from_rgb(15, 18, 23);
/// Main text of all screens.
pub const TEXT: Color32 = Color32::from_rgb(218, 223, 229);
/// Secondary text, such as descriptions.
pub const DIM: Color32 = Color32::from_rgb(148, 158, 170);
/// Option that can be chosen.
pub const CARD: Color32 = Color32::from_rgb(36, 43, 53);
/// Option under the pointer.
pub const CARD_HOVERED: Color32 = Color32::from_rgb(50, 59, 72);
/// Edge of an option, and dot of an item still to come: visible on the background.
pub const EDGE: Color32 = Color32::from_rgb(98, 108, 121);
/// Chosen option, and the focused button.
pub const CHOSEN: Color32 = Color32::from_rgb(46, 116, 181);
/// Ring and bar at the focus.
pub const CURSOR: Color32 = Color32::from_rgb(255, 205, 110);
/// Note on a missing answer.
pub const MISSING: Color32 = Color32::from_rgb(255, 128, 118);

/// Sizes for one window.
#[derive(Clone, Copy, Debug)]
pub struct PageStyle {
    /// Height of the text, points; all sizes follow from it.
    pub em: f32,
}

impl PageStyle {
    /// Computes the sizes for a window of this size, points. A narrow window has smaller text, so that a line holds
    /// some words.
    pub fn of(size: Vec2) -> Self {
        Self { em: (size.y / 25.0).min(size.x / 32.0).max(9.0) }
    }

    /// Returns the font at a multiple of the text height.
    pub fn font(&self, times: f32) -> FontId {
        FontId::proportional(times * self.em)
    }

    /// Returns the radius of corners.
    pub fn round(&self) -> CornerRadius {
        CornerRadius::same((0.3 * self.em).min(255.0) as u8)
    }

    /// Returns the ring around the focus.
    pub fn ring(&self) -> Stroke {
        Stroke::new((0.12 * self.em).max(1.5), CURSOR)
    }

    /// Returns the edge of a card.
    pub fn edge(&self) -> Stroke {
        Stroke::new((0.05 * self.em).max(1.0), EDGE)
    }

    /// Applies the style to everything drawn later in this [`Ui`].
    pub fn apply_style(&self, ui: &mut Ui) {
        let style = ui.style_mut();
        let body = self.em;
        for (name, size) in [(TextStyle::Body, body), (TextStyle::Button, body), (TextStyle::Small, 0.8 * body)] {
            style.text_styles.insert(name, FontId::proportional(size));
        }
        style.text_styles.insert(TextStyle::Heading, FontId::proportional(1.6 * body));
        style.text_styles.insert(TextStyle::Monospace, FontId::monospace(0.95 * body));
        style.spacing.item_spacing = vec2(0.5 * body, 0.45 * body);
        style.spacing.scroll = egui::style::ScrollStyle::solid();
        style.spacing.scroll.bar_width = 0.3 * body;
        let visuals = &mut style.visuals;
        // The font has no bold face; strong text is brighter.
        visuals.widgets.active.fg_stroke.color = Color32::WHITE;
        visuals.extreme_bg_color = CARD;
        visuals.widgets.noninteractive.fg_stroke.color = TEXT;
        style.interaction.selectable_labels = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the contrast of two colours, 1 to 21, as defined by WCAG 2.1.
    fn contrast(one: Color32, other: Color32) -> f64 {
        let linear = |channel: u8| {
            let share = f64::from(channel) / 255.0;
            if share <= 0.03928 { share / 12.92 } else { ((share + 0.055) / 1.055).powf(2.4) }
        };
        let luminance = |c: Color32| 0.2126 * linear(c.r()) + 0.7152 * linear(c.g()) + 0.0722 * linear(c.b());
        let [a, b] = [luminance(one), luminance(other)];
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    /// `docs/references.md: contrast`: 4.5 for text, 3 for edges of controls and for the focus.
    #[test]
    fn text_and_edges_contrast_with_their_background() {
        assert!((contrast(Color32::WHITE, Color32::BLACK) - 21.0).abs() < 1e-9);
        // Example of the standard's authors: #767676 is the darkest grey that passes on white.
        assert!((contrast(Color32::from_rgb(0x76, 0x76, 0x76), Color32::WHITE) - 4.54).abs() < 0.01);
        for (words, behind) in [(TEXT, BACK), (TEXT, CARD), (DIM, BACK), (MISSING, BACK), (Color32::WHITE, CHOSEN)] {
            assert!(contrast(words, behind) >= 4.5, "{words:?} on {behind:?}: {}", contrast(words, behind));
        }
        for part in [EDGE, CHOSEN, CURSOR, DIM] {
            assert!(contrast(part, BACK) >= 3.0, "{part:?}: {}", contrast(part, BACK));
        }
    }
}
