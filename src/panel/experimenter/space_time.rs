//! Space-time diagram of the running drive: time to the right, position along the unrolled road upwards, each vehicle a
//! line coloured by its speed, the ego's edged in white. In: positions and speeds at each step. Out: a picture of the
//! last five minutes, half a second a column. The columns are a ring buffer: only new ones are uploaded.

use super::map::shade;
use crate::panel::{readout, theme};
use egui::{Color32, ColorImage, Rect, TextureHandle, TextureId, TextureOptions, Ui, pos2, vec2};
use std::sync::atomic::{AtomicU64, Ordering};

/// Longest time span in the plots of all vehicles: a trial of HC22.
pub const WINDOW_S: f64 = 300.0;
/// Columns and rows of the picture.
const COLUMNS: usize = 600;
const ROWS: usize = 256;
const COLUMN_S: f64 = WINDOW_S / COLUMNS as f64;
/// Colour of an empty place.
const EMPTY: Color32 = Color32::from_rgb(14, 16, 20);

/// Positions of all vehicles in the last five minutes.
#[derive(Clone, Debug)]
pub struct SpaceTime {
    /// Number of this diagram among all since the start of the program.
    number: u64,
    length_m: f64,
    top_mps: f64,
    /// Columns one after the other, each from the end of the road to its start.
    pixels: Vec<Color32>,
    /// Number of the column that is being painted, counted from the start of the drive.
    column: usize,
    before: Option<Vec<f64>>,
}

/// Texture of a diagram; new columns are uploaded to it.
#[derive(Default)]
pub struct DiagramTexture {
    texture: Option<TextureHandle>,
    /// Number of the uploaded diagram, and the column that was being painted.
    knows: (u64, usize),
}

impl SpaceTime {
    /// Creates an empty diagram of a road of this length; the colour scale ends at `top_mps`.
    pub fn new(length_m: f64, top_mps: f64) -> Self {
        static DIAGRAMS: AtomicU64 = AtomicU64::new(1);
        Self {
            number: DIAGRAMS.fetch_add(1, Ordering::Relaxed),
            length_m: length_m.max(1.0),
            top_mps,
            pixels: vec![EMPTY; COLUMNS * ROWS],
            column: 0,
            before: None,
        }
    }

    /// Adds position along the road and speed of the ego and of all others at `time_s`, which must not decrease.
    pub fn add(&mut self, time_s: f64, ego: (f64, f64), others: impl Iterator<Item = (f64, f64)>) {
        let column = (time_s / COLUMN_S).max(0.0) as usize;
        // Skipped columns are emptied too, at most all of them.
        for fresh in (self.column + 1..=column).rev().take(COLUMNS) {
            self.pixels[fresh % COLUMNS * ROWS..][..ROWS].fill(EMPTY);
        }
        self.column = self.column.max(column);
        let mut now: Vec<(f64, f64)> = others.collect();
        now.push(ego);
        let before = self.before.take().filter(|before| before.len() == now.len());
        let last = now.len() - 1;
        for (i, &(s_m, speed_mps)) in now.iter().enumerate() {
            let from_m = before.as_ref().map_or(s_m, |before| before[i]);
            let colour = shade(speed_mps / self.top_mps);
            self.paint(from_m, s_m, if i == last { Some(colour) } else { None }, colour);
        }
        self.before = Some(now.into_iter().map(|(s_m, _)| s_m).collect());
    }

    /// Paints a vehicle's movement in the current column; with `ego` three rows thick and edged.
    fn paint(&mut self, from_m: f64, to_m: f64, ego: Option<Color32>, colour: Color32) {
        let row = |s_m: f64| (s_m / self.length_m * ROWS as f64).floor() as i64;
        let (from, mut to) = (row(from_m), row(to_m));
        // The shorter way, across the seam if need be: a vehicle does not jump by half of the road.
        if to < from - ROWS as i64 / 2 {
            to += ROWS as i64;
        } else if to > from + ROWS as i64 / 2 {
            to -= ROWS as i64;
        }
        let column = self.column % COLUMNS * ROWS;
        let mut put = |row: i64, colour: Color32| {
            let row = ROWS - 1 - row.rem_euclid(ROWS as i64) as usize;
            self.pixels[column + row] = colour;
        };
        let (low, high) = (from.min(to), from.max(to));
        if ego.is_some() {
            for row in [low - 2, high + 2] {
                put(row, Color32::WHITE);
            }
            (low - 1..=high + 1).for_each(|row| put(row, colour));
        } else {
            // Two rows thick, so that a diagram drawn at a smaller size has no gaps.
            (low..=high + 1).for_each(|row| put(row, colour));
        }
    }

    /// Shows the diagram over the available width, `height` points high, from `from_s` to `to_s`.
    pub fn show(&self, ui: &mut Ui, screen: &mut DiagramTexture, [from_s, to_s]: [f64; 2], height: f32) {
        let (response, painter) = ui.allocate_painter(vec2(ui.available_width(), height), egui::Sense::hover());
        let all = response.rect;
        let field = Rect::from_min_max(all.min + vec2(44.0, 4.0), all.max - vec2(4.0, 18.0));
        if field.width() < 10.0 || field.height() < 10.0 {
            return;
        }
        painter.rect_filled(field, 0.0, EMPTY);
        let x = |t: f64| field.left() + ((t - from_s) / (to_s - from_s)) as f32 * field.width();
        let texture = screen.texture(ui, self);
        // In the texture, time runs down and position to the right: the corners are assigned explicitly.
        let first = (self.column + 1).saturating_sub(COLUMNS);
        let mut at = first;
        while at <= self.column {
            let seam = (at / COLUMNS + 1) * COLUMNS;
            let end = seam.min(self.column + 1);
            let v = |column: usize| (column as f32 - (seam - COLUMNS) as f32) / COLUMNS as f32;
            let span = [at, end].map(|column| x(column as f64 * COLUMN_S).clamp(field.left(), field.right()));
            let mut mesh = egui::Mesh::with_texture(texture);
            for (px, py, u, v) in [
                (span[0], field.top(), 0.0, v(at)),
                (span[1], field.top(), 0.0, v(end)),
                (span[1], field.bottom(), 1.0, v(end)),
                (span[0], field.bottom(), 1.0, v(at)),
            ] {
                mesh.vertices.push(egui::epaint::Vertex { pos: pos2(px, py), uv: pos2(u, v), color: Color32::WHITE });
            }
            mesh.indices.extend([0, 1, 2, 0, 2, 3]);
            painter.add(mesh);
            at = end;
        }
        let font = egui::FontId::proportional(11.0);
        // A short drive gets closer marks: in a minute, marks at whole minutes would be two.
        let step_s = [10.0, 20.0, 60.0].into_iter().find(|step_s| (to_s - from_s) / step_s <= 6.0).unwrap_or(60.0);
        for mark in (from_s / step_s).ceil() as u64..=(to_s / step_s) as u64 {
            let at_s = mark as f64 * step_s;
            let at = pos2(x(at_s), field.bottom());
            painter.vline(at.x, field.y_range(), egui::Stroke::new(1.0, Color32::from_white_alpha(18)));
            let align = if at.x > field.right() - 14.0 { egui::Align2::RIGHT_TOP } else { egui::Align2::CENTER_TOP };
            painter.text(
                at + vec2(0.0, 3.0),
                align,
                readout::time(at_s).trim_end_matches(".0"),
                font.clone(),
                theme::DIM,
            );
        }
        for share in [0.0, 0.5, 1.0] {
            let at = pos2(field.left() - 4.0, field.bottom() - share as f32 * field.height());
            let align = [egui::Align2::RIGHT_BOTTOM, egui::Align2::RIGHT_CENTER, egui::Align2::RIGHT_TOP];
            let unit = if share == 1.0 { " m" } else { "" };
            let text = format!("{:.0}{unit}", share * self.length_m);
            painter.text(at, align[(share * 2.0) as usize], text, font.clone(), theme::DIM);
        }
        response.on_hover_text(
            "Positions of all vehicles in up to the last five minutes: time to the right, metres along the road \
             upwards; red stands, blue flows. The line with the white edge is the participant",
        );
    }
}

impl DiagramTexture {
    /// Uploads the new columns, or all if the diagram is another or too many are new.
    fn texture(&mut self, ui: &Ui, diagram: &SpaceTime) -> TextureId {
        let options = TextureOptions::LINEAR;
        let (number, known) = self.knows;
        self.knows = (diagram.number, diagram.column);
        // From half of all columns on, a full upload is faster.
        let stale = number != diagram.number || diagram.column - known >= COLUMNS / 2;
        match &mut self.texture {
            Some(texture) if !stale => {
                // The column that was being painted last time has changed as well.
                for column in known..=diagram.column {
                    let column = column % COLUMNS;
                    let image = ColorImage::new([ROWS, 1], diagram.pixels[column * ROWS..][..ROWS].to_vec());
                    texture.set_partial([0, column], image, options);
                }
                texture.id()
            }
            slot => {
                let image = ColorImage::new([ROWS, COLUMNS], diagram.pixels.clone());
                slot.insert(ui.ctx().load_texture("space-time", image, options)).id()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl SpaceTime {
        /// Returns the colour at a time and place; `None` if the place is empty or out of the diagram's time range.
        fn colour_at(&self, time_s: f64, s_m: f64) -> Option<Color32> {
            let column = (time_s / COLUMN_S).max(0.0) as usize;
            if column > self.column || column + COLUMNS <= self.column {
                return None;
            }
            let row = ROWS - 1 - ((s_m / self.length_m * ROWS as f64) as usize).min(ROWS - 1);
            Some(self.pixels[column % COLUMNS * ROWS + row]).filter(|colour| *colour != EMPTY)
        }
    }

    #[test]
    fn lines_cross_the_seam_and_are_dropped_after_five_minutes() {
        let mut diagram = SpaceTime::new(256.0, 8.0);
        // One vehicle at 4 m/s from 250 m on; the ego stands at 100 m.
        for step in 0..=100 {
            let t = f64::from(step) * 0.1;
            diagram.add(t, (100.5, 0.0), std::iter::once(((250.0 + 4.0 * t) % 256.0, 4.0)));
        }
        let moving = shade(0.5);
        assert_eq!(diagram.colour_at(0.2, 250.5), Some(moving));
        assert_eq!(diagram.colour_at(9.9, 33.5), Some(moving), "250 + 39.6 - 256");
        assert_eq!(diagram.colour_at(5.0, 130.5), None, "nobody was there: the seam is crossed the short way");
        assert_eq!(diagram.colour_at(5.0, 100.5), Some(shade(0.0)));
        assert_eq!(diagram.colour_at(5.0, 102.5), Some(Color32::WHITE), "the ego's edge");
        assert_eq!(diagram.colour_at(10.6, 100.5), None, "not yet");
        // Ten minutes later, with nothing between.
        diagram.add(610.0, (100.5, 0.0), std::iter::once((20.0, 4.0)));
        assert_eq!(diagram.colour_at(5.0, 100.5), None);
        assert_eq!(diagram.colour_at(400.0, 100.5), None);
        assert!(diagram.colour_at(610.0, 100.5).is_some());
    }
}
