//! The screen that checks the size of the picture against the scenario. In: the configured width of the picture and
//! distance of the eyes. Out: a ruler in centimetres and inches, a circle of a stated diameter and marks in all
//! corners, to be measured with a tape, and the value to enter if they differ.

use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Stroke, Ui, pos2, vec2};

use crate::panel::theme;

const METRES_PER_INCH: f32 = 0.0254;
/// Largest share of the picture's width for the ruler, and of its height for the circle.
const RULER_SHARE: f32 = 0.9;
const CIRCLE_SHARE: f32 = 0.5;

/// Configured size of the display.
#[derive(Clone, Debug, PartialEq)]
pub struct DisplayTruth {
    /// Configured width of the visible picture, m.
    pub screen_width_m: f64,
    /// Configured distance of the eyes, m.
    pub eye_distance_m: f64,
    /// Description of the screen, one line each: its monitor, rate, presentation of frames.
    pub screen: Vec<String>,
}

impl DisplayTruth {
    /// Returns the length of the ruler, m: the longest in whole decimetres that fits, or in centimetres on a small
    /// screen.
    pub fn ruler_m(&self) -> f64 {
        whole(f64::from(RULER_SHARE) * self.screen_width_m)
    }

    /// Returns the diameter of the circle, m, for a picture of this aspect ratio (width by height).
    pub fn circle_m(&self, aspect: f64) -> f64 {
        whole(f64::from(CIRCLE_SHARE) * self.screen_width_m / aspect)
    }

    /// Returns the horizontal angle of view, degrees.
    pub fn angle_deg(&self) -> f64 {
        2.0 * (self.screen_width_m / 2.0 / self.eye_distance_m).atan().to_degrees()
    }

    /// Returns the width to enter, m, if a tape reads `read_m` along the ruler.
    pub fn entered_m(&self, read_m: f64) -> f64 {
        self.screen_width_m * read_m / self.ruler_m()
    }
}

/// Rounds down to whole decimetres, or to centimetres below two decimetres; at least a centimetre.
fn whole(length_m: f64) -> f64 {
    let unit_m = if length_m >= 0.2 { 0.1 } else { 0.01 };
    ((length_m / unit_m + 1e-9).floor() * unit_m).max(0.01)
}

/// Draws the check over the whole window.
pub fn show(ui: &Ui, truth: &DisplayTruth) {
    let screen = ui.ctx().content_rect();
    let painter = ui.ctx().layer_painter(egui::LayerId::background());
    painter.rect_filled(screen, 0.0, theme::PANEL);
    let check_sheet = CheckSheet { painter, screen, points_per_m: screen.width() / truth.screen_width_m as f32 };
    check_sheet.corners();
    check_sheet.ruler(truth.ruler_m() as f32);
    check_sheet.circle(truth.circle_m(f64::from(screen.width() / screen.height())) as f32);
    check_sheet.draw_text(truth);
}

struct CheckSheet {
    painter: Painter,
    screen: Rect,
    points_per_m: f32,
}

impl CheckSheet {
    fn line(&self, from: Pos2, to: Pos2, width: f32, colour: Color32) {
        self.painter.line_segment([from, to], Stroke::new(width, colour));
    }

    fn text(&self, at: Pos2, align: Align2, text: &str, size: f32, colour: Color32) -> Rect {
        self.painter.text(at, align, text, FontId::proportional(size), colour)
    }

    /// Returns the size of the letters, which follows the picture, points.
    fn letters(&self) -> f32 {
        (self.screen.height() / 40.0).clamp(9.0, 28.0)
    }

    /// Draws a frame and marks in the corners; a cut-off one shows that the screen enlarges the picture.
    fn corners(&self) {
        self.painter.rect_stroke(self.screen, 0.0, Stroke::new(1.0, theme::AMBER), egui::StrokeKind::Inside);
        let arm = 0.04 * self.screen.height();
        for corner in
            [self.screen.left_top(), self.screen.right_top(), self.screen.left_bottom(), self.screen.right_bottom()]
        {
            let to_middle = self.screen.center() - corner;
            for way in [vec2(arm * to_middle.x.signum(), 0.0), vec2(0.0, arm * to_middle.y.signum())] {
                self.line(corner, corner + way, 5.0, theme::AMBER);
            }
        }
    }

    /// Draws centimetres above the line, inches below it.
    fn ruler(&self, length_m: f32) {
        let y = self.screen.top() + 0.16 * self.screen.height();
        let left = self.screen.center().x - length_m * self.points_per_m / 2.0;
        let x = |m: f32| left + m * self.points_per_m;
        let unit = 0.018 * self.screen.height();
        self.line(pos2(x(0.0), y), pos2(x(length_m), y), 1.5, theme::TEXT);
        let centimetres = (length_m * 100.0).round() as u32;
        // A mark each centimetre, or every five where closer marks would merge.
        let fine = if self.points_per_m * 0.01 >= 3.0 { 1 } else { 5 };
        let named = if centimetres > 20 { 10 } else { 5 };
        for cm in (0..=centimetres).step_by(fine) {
            let high = if cm % 10 == 0 {
                3.0
            } else if cm % 5 == 0 {
                2.2
            } else {
                1.2
            };
            let at = x(cm as f32 / 100.0);
            self.line(pos2(at, y), pos2(at, y - high * unit), 1.0, theme::TEXT);
            if cm % named == 0 {
                let text = if cm == 0 { "0 cm".into() } else { cm.to_string() };
                self.text(pos2(at, y - 3.3 * unit), Align2::CENTER_BOTTOM, &text, 0.9 * self.letters(), theme::TEXT);
            }
        }
        let inches = (length_m / METRES_PER_INCH).floor() as u32;
        let every = if inches > 12 { 5 } else { 1 };
        for inch in 0..=inches {
            let at = x(inch as f32 * METRES_PER_INCH);
            let high = if inch % every == 0 { 2.2 } else { 1.2 };
            self.line(pos2(at, y), pos2(at, y + high * unit), 1.0, theme::DIM);
            if inch % every == 0 {
                let text = if inch == 0 { "0 in".into() } else { inch.to_string() };
                self.text(pos2(at, y + 2.5 * unit), Align2::CENTER_TOP, &text, 0.8 * self.letters(), theme::DIM);
            }
        }
    }

    fn circle(&self, diameter_m: f32) {
        let radius = diameter_m * self.points_per_m / 2.0;
        let centre = pos2(self.screen.right() - 0.06 * self.screen.width() - radius, self.screen.center().y * 1.22);
        self.painter.circle_stroke(centre, radius, Stroke::new(2.0, theme::GREEN));
        self.line(centre - vec2(radius, 0.0), centre + vec2(radius, 0.0), 1.0, theme::GREEN);
        self.line(centre - vec2(0.0, radius), centre + vec2(0.0, radius), 1.0, theme::GREEN);
        let (text, at) = (length(diameter_m.into()), centre - vec2(0.0, 0.2 * self.letters()));
        let galley = self.painter.layout_no_wrap(text, FontId::proportional(self.letters()), theme::GREEN);
        let rect = Align2::CENTER_CENTER.anchor_size(at, galley.size());
        self.painter.rect_filled(rect.expand(3.0), 0.0, theme::PANEL);
        self.painter.galley(rect.min, galley, theme::GREEN);
    }

    fn draw_text(&self, truth: &DisplayTruth) {
        let ruler_m = truth.ruler_m();
        // An example with a deviation of 5 %.
        let read_m = 0.95 * ruler_m;
        let mut lines = vec![
            (
                format!(
                    "Set: the picture is {} wide, the eyes are {} away: {:.1} degrees.",
                    length(truth.screen_width_m),
                    length(truth.eye_distance_m),
                    truth.angle_deg()
                ),
                theme::ACCENT,
            ),
            (format!("1. Hold a tape to the ruler. It should read {} from end to end.", length(ruler_m)), theme::TEXT),
            (
                format!(
                    "    If it reads L, enter  --screen-width {:.3} x L / {ruler_m:.2}  (both in metres).",
                    truth.screen_width_m
                ),
                theme::TEXT,
            ),
            (
                format!("    Example: at {}, enter  --screen-width {:.3}", length(read_m), truth.entered_m(read_m)),
                theme::DIM,
            ),
            ("2. The circle should be as tall as it is wide. If not, the screen is not at its".into(), theme::TEXT),
            ("    own resolution, or stretches the picture: fix that first.".into(), theme::TEXT),
            ("3. All four corners should be visible. If not, switch overscan off.".into(), theme::TEXT),
            ("4. Measure from the driver's eyes to the middle of the screen, and enter".into(), theme::TEXT),
            (format!("    --eye-distance; {:.2} is set.", truth.eye_distance_m), theme::TEXT),
        ];
        lines.extend(truth.screen.iter().map(|line| (line.clone(), theme::DIM)));
        lines.push(("Esc ends.".into(), theme::DIM));
        let mut at = self.screen.left_top() + vec2(0.06 * self.screen.width(), 0.34 * self.screen.height());
        for (text, colour) in lines {
            let rect = self.text(at, Align2::LEFT_TOP, &text, self.letters(), colour);
            at.y = rect.bottom() + 0.35 * self.letters();
        }
    }
}

/// Formats a length as `121.8 cm (47.95 in)`.
fn length(m: f64) -> String {
    format!("{:.1} cm ({:.2} in)", 100.0 * m, m / f64::from(METRES_PER_INCH))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn truth(screen_width_m: f64) -> DisplayTruth {
        DisplayTruth { screen_width_m, eye_distance_m: 1.0, screen: Vec::new() }
    }

    #[test]
    fn ruler_and_circle_are_whole_and_fit() {
        assert!((truth(1.218).ruler_m() - 1.0).abs() < 1e-9);
        assert!((truth(1.218).circle_m(16.0 / 9.0) - 0.3).abs() < 1e-9);
        assert!((truth(0.34).ruler_m() - 0.3).abs() < 1e-9);
        assert!((truth(0.15).ruler_m() - 0.13).abs() < 1e-9);
        assert!((truth(0.34).circle_m(1.6) - 0.1).abs() < 1e-9);
    }

    #[test]
    fn the_width_to_enter_makes_the_ruler_true() {
        // A screen of 1.4 m that is configured as 1.218 m shows the metre as 1.149 m.
        let set = truth(1.218);
        let read_m = set.ruler_m() * 1.4 / 1.218;
        assert!((set.entered_m(read_m) - 1.4).abs() < 1e-9);
        assert!((set.angle_deg() - 62.7).abs() < 0.1);
    }
}
