//! Says in every window of a session that the room is recorded. In: the words, while it is. Out: a red lamp with them, at the upper left
//! edge, where neither road nor mirror nor dial is.

use crate::panel::{recording_sign::LAMP, theme};
use egui::{Align2, Color32, FontId, Rect, Role, Sense, Ui, WidgetInfo, pos2, vec2};

/// Height of the words, points.
const SIZE: f32 = 16.0;

/// Shows it; nothing without words.
pub fn room_sign(ui: &Ui, words: Option<&str>) {
    let Some(words) = words else { return };
    let whole = ui.max_rect();
    let painter = ui.painter();
    let galley = painter.layout_no_wrap(words.to_owned(), FontId::proportional(SIZE), theme::RED);
    let size = galley.size() + vec2(3.0 * LAMP + 16.0, 10.0);
    let rect: Rect = Align2::LEFT_TOP.anchor_size(whole.left_top() + vec2(10.0, 10.0), size);
    painter.rect_filled(rect, 4.0, Color32::from_black_alpha(200));
    painter.circle_filled(pos2(rect.left() + 8.0 + LAMP, rect.center().y), LAMP, theme::RED);
    painter.galley(pos2(rect.left() + 8.0 + 3.0 * LAMP, rect.center().y - 0.5 * galley.size().y), galley, theme::RED);
    let spoken = ui.interact(rect, egui::Id::unique("room"), Sense::hover());
    spoken.widget_info(|| WidgetInfo::labeled(Role::Label, true, words));
}
