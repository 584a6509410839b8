//! Sign in every window of a session that the room is recorded. In: the text, while it is. Out: the text with a red
//! lamp in the upper left corner, clear of road, mirror and dial.

use crate::panel::{recording_sign::LAMP, theme};
use egui::{Align2, Color32, FontId, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2};

/// Height of the text as a share of the window's height, readable from the driver's seat, and its minimum, points.
const SHARE: f32 = 0.022;
const LEAST: f32 = 16.0;

/// Shows the sign, or nothing without a text.
pub fn room_sign(ui: &Ui, words: Option<&str>) {
    let Some(words) = words else { return };
    let whole = ui.max_rect();
    let painter = ui.painter();
    let height = (SHARE * whole.height()).max(LEAST);
    let grown = height / LEAST;
    let (lamp, edge) = (LAMP * grown, 8.0 * grown);
    let galley = painter.layout_no_wrap(words.to_owned(), FontId::proportional(height), theme::RED);
    let size = galley.size() + vec2(3.0 * lamp + 2.0 * edge, 10.0 * grown);
    let rect: Rect = Align2::LEFT_TOP.anchor_size(whole.left_top() + vec2(10.0, 10.0) * grown, size);
    painter.rect_filled(rect, 4.0 * grown, Color32::from_black_alpha(200));
    painter.circle_filled(pos2(rect.left() + edge + lamp, rect.center().y), lamp, theme::RED);
    painter.galley(pos2(rect.left() + edge + 3.0 * lamp, rect.center().y - 0.5 * galley.size().y), galley, theme::RED);
    let spoken = ui.interact(rect, egui::Id::unique("room"), Sense::hover());
    spoken.widget_info(|| WidgetInfo::labeled(Role::Label, true, words));
}
