//! Texts above the speedometer: those of events and sentences, and a question with its answers. In: a [`DialView`]. Out: shapes on dark plates within the picture.

use super::{
    brush::{DialBrush, black, opaque},
    layout,
};
use crate::hud::{DialView, Palette, lettering};
use egui::{Color32, Pos2, Rect, Vec2, pos2, vec2};

/// Free space between two answers, and width of the mark of an answer's button with its gap to the text, as multiples of the letters' height.
const BETWEEN: f32 = 1.6;
const MARK: f32 = 1.7;

/// Button that chooses an answer.
#[derive(Clone, Copy)]
enum AnswerButton {
    Left,
    Middle,
    Right,
}

/// Largest number of letters in a row of a text: the longest text of an event.
const ROW_LETTERS: usize = 60;

/// Returns the rows of a text, broken at its line breaks and between words.
fn rows(text: &str) -> Vec<String> {
    let mut rows: Vec<String> = Vec::new();
    for line in text.lines() {
        rows.push(String::new());
        for word in line.split_whitespace() {
            let row = rows.last_mut().filter(|row| row.chars().count() + 1 + word.chars().count() <= ROW_LETTERS);
            match row {
                Some(row) if row.is_empty() => row.push_str(word),
                Some(row) => row.extend([" ", word]),
                None => rows.push(word.to_owned()),
            }
        }
    }
    rows.retain(|row| !row.is_empty());
    rows
}

/// Returns the distance of a question's answers that a text takes above the dial, as a multiple of its radius.
fn height_of_message(dial: &DialView) -> f32 {
    let (.., of_row) = layout::QUESTION;
    dial.message.as_ref().map_or(0.0, |text| of_row * rows(text).len() as f32)
}

/// Draws the text of an event or a sentence above the dial, on a dark plate for each row within the picture.
pub(super) fn message(brush: &DialBrush<'_>, dial: &DialView, palette: &Palette) {
    let Some(text) = &dial.message else { return };
    let (height, alone, above_sign) = layout::MESSAGE;
    let (.., of_row) = layout::QUESTION;
    let up = if dial.pictogram.is_some() { above_sign } else { alone };
    let height = height * brush.radius;
    for (k, row) in rows(text).iter().rev().enumerate() {
        let plate = plate_size(lettering::set(row).width, height);
        let middle = pos2(within(brush, plate.x), brush.below(-up - of_row * k as f32).y);
        paint_plate(brush, middle, plate);
        write(brush, row, middle, height, opaque(palette.needle));
    }
}

/// Draws a question above sign and text, and below it the answers, each with the mark of its button: arrows to the left and right, a disc for the
/// response button.
pub(super) fn question(brush: &DialBrush<'_>, dial: &DialView, palette: &Palette) {
    let Some(shown) = &dial.question else { return };
    let (height, rows, alone, above_sign, _) = layout::QUESTION;
    let sign = if dial.pictogram.is_some() { above_sign } else { alone };
    let up = sign + height_of_message(dial);
    let (colour, height) = (opaque(palette.needle), height * brush.radius);
    let widths: Vec<f32> =
        shown.answers.iter().map(|answer| plate_size(lettering::set(answer).width + MARK, height).x).collect();
    let row = widths.iter().sum::<f32>() + BETWEEN * height * (widths.len() - 1) as f32;
    let plate = plate_size(lettering::set(&shown.question).width, height);
    let middle = within(brush, row.max(plate.x));
    let above = pos2(middle, brush.below(-up - rows).y);
    paint_plate(brush, above, plate);
    write(brush, &shown.question, above, height, colour);
    let mut left = middle - row / 2.0;
    for (k, (answer, width)) in shown.answers.iter().zip(widths).enumerate() {
        let button = match k {
            0 => AnswerButton::Left,
            k if k + 1 == shown.answers.len() => AnswerButton::Right,
            _ => AnswerButton::Middle,
        };
        let centre = pos2(left + width / 2.0, brush.below(-up).y);
        paint_plate(brush, centre, vec2(width, plate.y));
        // The right arrow is right of its text.
        let side = if matches!(button, AnswerButton::Right) { 1.0 } else { -1.0 };
        let text = lettering::set(answer).width;
        write(brush, answer, centre - vec2(side * MARK / 2.0 * height, 0.0), height, colour);
        mark(brush, button, centre + vec2(side * text / 2.0 * height, 0.0), height, colour);
        left += width + BETWEEN * height;
    }
}

/// Draws the mark of a button with letters of this height.
fn mark(brush: &DialBrush<'_>, button: AnswerButton, middle: Pos2, height: f32, colour: Color32) {
    let tip = match button {
        AnswerButton::Left => -1.0,
        AnswerButton::Right => 1.0,
        AnswerButton::Middle => {
            brush.painter.circle_filled(middle, 0.32 * height, colour);
            return;
        }
    };
    let at = |x: f32, y: f32| middle + vec2(tip * x, y) * height;
    brush.polygon(vec![at(0.45, 0.0), at(-0.3, 0.45), at(-0.3, -0.45)], colour);
}

/// Returns the size of a plate for a text of this width, a multiple of the height of its letters.
fn plate_size(width: f32, height: f32) -> Vec2 {
    vec2(width + 1.2, 2.0) * height
}

/// Returns the middle of a plate of this width, pixels: above the dial, or as near to it as the picture's right edge allows.
fn within(brush: &DialBrush<'_>, width: f32) -> f32 {
    let room = brush.painter.clip_rect();
    brush.centre.x.min((room.right() - width / 2.0).max(room.center().x))
}

fn paint_plate(brush: &DialBrush<'_>, middle: Pos2, size: Vec2) {
    brush.painter.rect_filled(Rect::from_center_size(middle, size), 0.3 * size.y, black(200));
}

/// Writes a text with letters of this height, pixels.
fn write(brush: &DialBrush<'_>, text: &str, middle: Pos2, height: f32, colour: Color32) {
    brush.text(text, middle, height / brush.radius, colour);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        hud::SpeedometerScale,
        snapshot::{Pictogram, ShownQuestion},
        units::SpeedUnit,
    };
    use egui::Shape;
    use std::sync::Arc;

    /// Returns the plates of a question with these answers above a dial at `across` in a picture of 640 by 360 pixels.
    fn plates(answers: &[&str], across: f32, pictogram: Option<Pictogram>) -> Vec<Rect> {
        let answers = answers.iter().map(|answer| Arc::from(*answer)).collect();
        let question = ShownQuestion { question: "Who steers now?".into(), answers };
        let dial = DialView::new(0.0, None, SpeedUnit::Kmh, SpeedometerScale::up_to(50.0), false)
            .with_pictogram(pictogram)
            .asking(Some(Arc::new(question)));
        let screen = Rect::from_min_size(Pos2::ZERO, vec2(640.0, 360.0));
        let input = egui::RawInput { screen_rect: Some(screen), ..Default::default() };
        let mut output = egui::Context::default().run_ui(input, |ui| {
            let painter = ui.ctx().layer_painter(egui::LayerId::background());
            let brush = DialBrush { painter: &painter, centre: pos2(across, 295.0), radius: 60.0 };
            super::question(&brush, &dial, &Palette::default());
        });
        output.textures_delta.clear();
        let rects = output.shapes.iter().filter_map(|clipped| match &clipped.shape {
            Shape::Rect(plate) => Some(plate.rect),
            _ => None,
        });
        rects.collect()
    }

    #[test]
    fn a_long_sentence_is_broken_between_words_into_rows() {
        let sentence =
            "The road ahead is closed, please prepare to turn around at the next roundabout and follow the signs";
        let broken = rows(sentence);
        assert!(broken.len() == 2 && broken.iter().all(|row| row.chars().count() <= ROW_LETTERS), "{broken:?}");
        assert_eq!(broken.join(" "), sentence);
        assert_eq!(rows("TAKE OVER NOW\nTurn left."), ["TAKE OVER NOW", "Turn left."]);
        assert_eq!(rows("Reduce speed"), ["Reduce speed"]);
    }

    #[test]
    fn answers_stand_in_a_row_below_the_question_within_the_picture() {
        for answers in [&["I", "the car"][..], &["the car in front of me", "so so", "I"]] {
            // In the middle, and beside the right margin.
            for across in [320.0, 575.0] {
                let plates = plates(answers, across, None);
                assert_eq!(plates.len(), 1 + answers.len());
                for pair in plates[1..].windows(2) {
                    assert!(pair[0].right() < pair[1].left() && pair[0].top() == pair[1].top(), "{plates:?}");
                }
                let screen = Rect::from_min_size(Pos2::ZERO, vec2(640.0, 360.0));
                assert!(plates.iter().all(|plate| screen.contains_rect(*plate)), "{plates:?}");
                // The question is above the answers, and these above the dial, whose upper edge is at 235.
                assert!(plates[1..].iter().all(|answer| plates[0].bottom() < answer.top() && answer.bottom() < 235.0));
            }
        }
        let above_sign = plates(&["I", "the car"], 320.0, Some(Pictogram::HandsOn));
        // The plate of the sign reaches 1.74 radii above the centre.
        assert!(above_sign.iter().all(|plate| plate.bottom() < 295.0 - 1.74 * 60.0), "{above_sign:?}");
    }
}
