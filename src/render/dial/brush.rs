//! Brush for round instruments. In: radii and lengths as shares of the instrument's radius, angles in radians clockwise
//! from 12 o'clock. Out: shapes of egui's painter, in pixels.

use egui::{Color32, Mesh, Painter, Pos2, Shape, Stroke, vec2};

use crate::hud::{Rgb, lettering};

/// Number of segments of a circle: on a dial of 720 pixels a chord deviates by 0.2 pixels.
const SPOKES: u32 = 96;

/// Draws in the units of one instrument.
#[derive(Clone, Copy)]
pub struct DialBrush<'a> {
    /// Painter that receives the shapes.
    pub painter: &'a Painter,
    /// Centre of the instrument, pixels.
    pub centre: Pos2,
    /// Radius of the instrument, pixels.
    pub radius: f32,
}

impl DialBrush<'_> {
    /// Returns the point at an angle and a radius.
    pub fn at(&self, angle: f32, radius: f32) -> Pos2 {
        self.centre + vec2(angle.sin(), -angle.cos()) * (radius * self.radius)
    }

    /// Returns the point at this distance below the centre.
    pub fn below(&self, down: f32) -> Pos2 {
        self.centre + vec2(0.0, down * self.radius)
    }

    /// Returns `share`, but at least as much as `pixels`: thin lines stay visible on a small dial.
    pub fn at_least_px(&self, share: f32, pixels: f32) -> f32 {
        share.max(pixels / self.radius)
    }

    /// Draws a straight line towards the centre.
    pub fn radial(&self, angle: f32, (outer, inner): (f32, f32), width: f32, colour: Color32) {
        let ends = [self.at(angle, inner), self.at(angle, outer)];
        self.painter.line_segment(ends, Stroke::new(width * self.radius, colour));
    }

    /// Draws a part of a ring, cut off square at both angles.
    pub fn arc(&self, (outer, inner): (f32, f32), (from, to): (f32, f32), colour: Color32) {
        let pieces = ((to - from).abs().to_degrees() / 1.5).ceil().max(1.0);
        let middle = (outer + inner) / 2.0;
        let points = (0..=pieces as u32).map(|i| self.at(from + (to - from) * i as f32 / pieces, middle)).collect();
        self.painter.line(points, Stroke::new((outer - inner) * self.radius, colour));
    }

    /// Draws a filled convex shape.
    pub fn polygon(&self, corners: Vec<Pos2>, colour: Color32) {
        self.painter.add(Shape::convex_polygon(corners, colour, Stroke::NONE));
    }

    /// Draws a disc in rings of colour from the innermost out, each blending into the next.
    pub fn disc(&self, rings: &[(f32, Color32)]) {
        self.turned(rings, |(radius, colour), _| (*radius, *colour));
    }

    /// Draws a ring whose colour depends on the angle; its edges are soft over one pixel.
    pub fn ring(&self, inner: f32, outer: f32, colour: impl Fn(f32) -> Color32) {
        let soft = 0.5 / self.radius;
        let rows = [(inner - soft, 0.0), (inner + soft, 1.0), (outer - soft, 1.0), (outer + soft, 0.0)];
        self.turned(&rows, |&(radius, share), angle| (radius, colour(angle).gamma_multiply(share)));
    }

    /// Draws a surface of revolution: `point` gives radius and colour for each row and angle.
    fn turned<T>(&self, rows: &[T], point: impl Fn(&T, f32) -> (f32, Color32)) {
        let mut mesh = Mesh::default();
        for spoke in 0..SPOKES {
            let angle = std::f32::consts::TAU * spoke as f32 / SPOKES as f32;
            for row in rows {
                let (radius, colour) = point(row, angle);
                mesh.colored_vertex(self.at(angle, radius), colour);
            }
        }
        let rows = rows.len() as u32;
        for spoke in 0..SPOKES {
            let (here, next) = (spoke * rows, (spoke + 1) % SPOKES * rows);
            for row in 0..rows - 1 {
                mesh.add_triangle(here + row, here + row + 1, next + row);
                mesh.add_triangle(next + row, here + row + 1, next + row + 1);
            }
        }
        self.painter.add(Shape::mesh(mesh));
    }

    /// Draws text in the instrument's own lettering, centred at `middle`.
    pub fn text(&self, text: &str, middle: Pos2, height: f32, colour: Color32) {
        let size = height * self.radius;
        let pen = lettering::PEN * size;
        for stroke in lettering::set(text).strokes {
            let points: Vec<Pos2> = stroke.iter().map(|&[x, y]| middle + vec2(x, y) * size).collect();
            if points[0].distance(points[points.len() - 1]) < 1e-3 * size {
                self.painter.add(Shape::closed_line(points[1..].to_vec(), Stroke::new(pen, colour)));
                continue;
            }
            // Drawn from corner to corner with round ends: a mitre join would break off.
            let mut start = 0;
            for end in 1..points.len() {
                if end + 1 == points.len() || is_corner(points[end - 1], points[end], points[end + 1]) {
                    self.painter.circle_filled(points[start], pen / 2.0, colour);
                    self.painter.circle_filled(points[end], pen / 2.0, colour);
                    self.painter.line(points[start..=end].to_vec(), Stroke::new(pen, colour));
                    start = end;
                }
            }
        }
    }
}

/// Returns true if a line turns by more than 30 degrees at `at`.
fn is_corner(before: Pos2, at: Pos2, after: Pos2) -> bool {
    (at - before).normalized().dot((after - at).normalized()) < 0.866
}

/// Converts an sRGB colour to egui's type.
pub fn opaque([r, g, b]: Rgb) -> Color32 {
    Color32::from_rgb(r, g, b)
}

/// Returns black with this opacity.
pub fn black(alpha: u8) -> Color32 {
    Color32::from_black_alpha(alpha)
}

/// Multiplies a colour's brightness by a factor, and sets its opacity.
pub fn shade(colour: Rgb, light: f32, alpha: u8) -> Color32 {
    let [r, g, b] = colour.map(|part| (f32::from(part) * light).round().clamp(0.0, 255.0) as u8);
    Color32::from_rgba_unmultiplied(r, g, b, alpha)
}
