//! Signs of events above the speedometer. In: a [`DialView`]. Out: shapes of one of a few signs of our own drawing, on a dark plate, which can be told
//! apart by outline and colour alone.

use super::{
    brush::{DialBrush, black, opaque},
    layout,
};
use crate::{
    hud::{DialView, Rgb},
    snapshot::Pictogram,
};
use egui::{Pos2, Rect, Shape, Stroke, Vec2, vec2};
use std::f32::consts::{FRAC_PI_4, FRAC_PI_8, TAU};

const RED: Rgb = [214, 24, 32];
const WHITE: Rgb = [248, 248, 248];
const INK: Rgb = [16, 16, 18];
const AMBER: Rgb = [255, 190, 64];

/// Share of the plate that the sign fills.
const FILLED: f32 = 0.86;
/// Corners of the middle line of the rim of a warning.
const TRIANGLE: [[f32; 2]; 3] = [[0.0, -0.80], [0.92, 0.80], [-0.92, 0.80]];

/// Sheet of one sign: x to the right and y downwards, both from -1 to 1.
struct Sheet<'a> {
    brush: &'a DialBrush<'a>,
    middle: Pos2,
    /// Half the side, pixels.
    half: f32,
}

/// Draws the sign of an event above the dial.
pub(super) fn pictogram(brush: &DialBrush<'_>, dial: &DialView) {
    let Some(sign) = dial.pictogram else { return };
    let (half, up) = layout::PICTOGRAM;
    let (middle, half) = (brush.below(-up), half * brush.radius);
    brush.painter.rect_filled(Rect::from_center_size(middle, Vec2::splat(2.0 * half)), 0.2 * half, black(200));
    let sheet = Sheet { brush, middle, half: FILLED * half };
    match sign {
        Pictogram::Brake => sheet.brake(),
        Pictogram::HandsOn => sheet.hands_on(),
        Pictogram::Pedestrian => sheet.pedestrian(),
        Pictogram::Slippery => sheet.slippery(),
        Pictogram::Stop => sheet.stop(),
        Pictogram::Warning => sheet.warning(),
    }
}

impl Sheet<'_> {
    fn at(&self, [x, y]: [f32; 2]) -> Pos2 {
        self.middle + vec2(x, y) * self.half
    }

    /// Draws a convex shape.
    fn fill(&self, corners: &[[f32; 2]], colour: Rgb) {
        self.brush.polygon(corners.iter().map(|corner| self.at(*corner)).collect(), opaque(colour));
    }

    fn disc(&self, middle: [f32; 2], radius: f32, colour: Rgb) {
        self.brush.painter.circle_filled(self.at(middle), radius * self.half, opaque(colour));
    }

    fn ellipse(&self, middle: [f32; 2], radii: [f32; 2], colour: Rgb) {
        let radii = Vec2::from(radii) * self.half;
        self.brush.painter.add(Shape::ellipse_filled(self.at(middle), radii, opaque(colour)));
    }

    /// Draws a line with round ends.
    fn line(&self, points: &[[f32; 2]], width: f32, colour: Rgb) {
        let stroke = Stroke::new(width * self.half, opaque(colour));
        self.brush.painter.line(points.iter().map(|point| self.at(*point)).collect(), stroke);
        for end in [points[0], points[points.len() - 1]] {
            self.disc(end, width / 2.0, colour);
        }
    }

    /// Draws an arc around the middle; the angle counts clockwise from the right.
    fn arc(&self, radius: f32, (from, to): (f32, f32), width: f32, colour: Rgb) {
        let points: Vec<[f32; 2]> = (0..=16)
            .map(|k| from + (to - from) * k as f32 / 16.0)
            .map(|angle| [radius * angle.cos(), radius * angle.sin()])
            .collect();
        self.line(&points, width, colour);
    }

    /// Draws a word in the middle.
    fn text(&self, word: &str, height: f32) {
        self.brush.text(word, self.middle, height * self.half / self.brush.radius, opaque(WHITE));
    }

    /// Draws the white triangle with a red rim of all warnings.
    fn triangle(&self) {
        self.fill(&TRIANGLE, WHITE);
        let mut rim = TRIANGLE.to_vec();
        rim.push(TRIANGLE[0]);
        for side in rim.windows(2) {
            self.line(side, 0.2, RED);
        }
    }

    fn warning(&self) {
        self.triangle();
        self.fill(&[[-0.11, -0.36], [0.11, -0.36], [0.06, 0.28], [-0.06, 0.28]], INK);
        self.disc([0.0, 0.5], 0.11, INK);
    }

    fn pedestrian(&self) {
        self.triangle();
        self.disc([0.03, -0.30], 0.115, INK);
        self.line(&[[0.0, -0.06], [-0.02, 0.22]], 0.17, INK);
        self.line(&[[-0.02, 0.22], [0.14, 0.42], [0.22, 0.64]], 0.11, INK);
        self.line(&[[-0.02, 0.22], [-0.10, 0.46], [-0.26, 0.64]], 0.11, INK);
        self.line(&[[0.0, -0.08], [0.18, 0.08], [0.30, 0.14]], 0.075, INK);
        self.line(&[[0.0, -0.08], [-0.17, 0.06], [-0.22, 0.24]], 0.075, INK);
    }

    fn slippery(&self) {
        self.triangle();
        // The car from behind, turned by its skid.
        let turned = |[x, y]: [f32; 2]| {
            let (sin, cos) = (-0.22_f32).sin_cos();
            [x * cos - y * sin, x * sin + y * cos - 0.05]
        };
        let fill = |corners: &[[f32; 2]]| self.fill(&corners.iter().map(|c| turned(*c)).collect::<Vec<_>>(), INK);
        fill(&[[-0.17, -0.22], [0.17, -0.22], [0.25, 0.0], [-0.25, 0.0]]);
        fill(&[[-0.30, -0.02], [0.30, -0.02], [0.30, 0.16], [-0.30, 0.16]]);
        fill(&[[-0.28, 0.16], [-0.15, 0.16], [-0.15, 0.24], [-0.28, 0.24]]);
        fill(&[[0.15, 0.16], [0.28, 0.16], [0.28, 0.24], [0.15, 0.24]]);
        for x in [-0.20, 0.20] {
            let trace: Vec<[f32; 2]> = (0..=12)
                .map(|k| k as f32 / 12.0)
                .map(|share| [x + 0.09 * (share * TAU).sin() - 0.10 * share, 0.30 + 0.36 * share])
                .collect();
            self.line(&trace, 0.075, INK);
        }
    }

    fn stop(&self) {
        let octagon = |radius: f32| -> Vec<[f32; 2]> {
            let corner = |k: u8| FRAC_PI_8 + f32::from(k) * FRAC_PI_4;
            (0..8).map(corner).map(|angle| [radius * angle.cos(), radius * angle.sin()]).collect()
        };
        self.fill(&octagon(1.0), WHITE);
        self.fill(&octagon(0.91), RED);
        self.text("STOP", 0.46);
    }

    fn brake(&self) {
        self.fill(&[[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]], RED);
        // The word, as a drawing of a disc or a pedal is read as a brake that has failed. Above and below it, the rims of a disc.
        for middle in [-TAU / 4.0, TAU / 4.0] {
            self.arc(0.80, (middle - 1.0, middle + 1.0), 0.12, WHITE);
        }
        self.text("BRAKE", 0.44);
    }

    fn hands_on(&self) {
        self.arc(0.66, (0.0, TAU), 0.15, WHITE);
        self.disc([0.0, 0.0], 0.19, WHITE);
        for spoke in [[0.60, 0.0], [-0.60, 0.0], [0.0, 0.60]] {
            self.line(&[[0.0, 0.0], spoke], 0.13, WHITE);
        }
        for side in [-1.0, 1.0] {
            self.line(&[[side * 0.70, 0.02], [side * 0.86, 0.92]], 0.26, AMBER);
            self.ellipse([side * 0.68, -0.08], [0.22, 0.27], AMBER);
            self.line(&[[side * 0.62, -0.12], [side * 0.44, -0.26]], 0.11, AMBER);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{hud::SpeedometerScale, units::SpeedUnit};
    use egui::{Context, LayerId, RawInput, pos2};

    /// Returns the rectangle of all shapes of a sign on a dial of radius 100 whose centre is the origin.
    fn extent(sign: Pictogram) -> (Rect, usize) {
        let scale = SpeedometerScale::up_to(50.0);
        let dial = DialView::new(0.0, None, SpeedUnit::Kmh, scale, false).with_pictogram(Some(sign));
        let mut output = Context::default().run_pass(RawInput::default(), |context| {
            let painter = context.layer_painter(LayerId::background()).with_clip_rect(Rect::EVERYTHING);
            pictogram(&DialBrush { painter: &painter, centre: Pos2::ZERO, radius: 100.0 }, &dial);
        });
        // No text of egui's fonts is drawn.
        output.textures_delta.clear();
        let rects: Vec<Rect> = output.shapes.iter().map(|shape| shape.shape.visual_bounding_rect()).collect();
        (rects.iter().fold(Rect::NOTHING, |all, rect| all.union(*rect)), rects.len())
    }

    #[test]
    fn every_sign_lies_on_its_plate_between_dial_and_text() {
        let signs = [
            Pictogram::Brake,
            Pictogram::HandsOn,
            Pictogram::Pedestrian,
            Pictogram::Slippery,
            Pictogram::Stop,
            Pictogram::Warning,
        ];
        let (half, up) = layout::PICTOGRAM;
        let middle = pos2(0.0, -100.0 * up);
        let plate = Rect::from_center_size(middle, Vec2::splat(200.0 * half));
        let (text, _, above_sign) = layout::MESSAGE;
        assert!(plate.bottom() < -100.0 && plate.top() > -100.0 * (above_sign - text), "{plate:?}");
        for sign in signs {
            let (extent, shapes) = extent(sign);
            assert!(shapes > 4 && extent == plate, "{sign:?}: {shapes} shapes in {extent:?}");
        }
    }
}
