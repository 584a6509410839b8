//! Lettering of the instrument, of number plates and of road signs: lines of text as strokes of one width, so that no font and no glyph atlas
//! is needed. The forms are legible at a distance (open forms, tabular digits); `letter_forms` has them. In: text. Out: polylines, to be
//! drawn with a round pen of [`PEN`] times the height.

use super::letter_forms::{self, Stroke};
use crate::latin_letters::{Accent, decomposed};

/// Width of the pen as a share of the height of a digit.
pub const PEN: f32 = 0.16;
/// Space between the boxes of two characters (from the middle of one pen to the next), as a share of the height.
const GAP: f32 = 0.30;
/// Distance of an accent above the top of its letter, and half the distance of two dots, as shares of the height.
const ACCENT_OVER: f32 = 0.27;
const DOTS_HALF: f32 = 0.13;

/// Line of text, 1.0 high from the baseline to the top of a digit, with its middle at the origin: x to the right, y
/// down. Half the pen's width lies outside, and so do accents of capitals and what hangs below the baseline.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LetteredLine {
    /// Strokes, each at least two points.
    pub strokes: Vec<Vec<[f32; 2]>>,
    /// Distance from the middle of the first pen stroke to the middle of the last.
    pub width: f32,
}

/// Lays out `text`. A character without a form shows as a box.
pub fn set(text: &str) -> LetteredLine {
    let mut line = LetteredLine::default();
    let mut x = 0.0;
    for (base, accent) in decomposed(text) {
        let (width, mut parts) = letter_forms::of(base).unwrap_or_else(letter_forms::unknown);
        if let Some(accent) = accent {
            // The dot of a small i or j gives way to an accent.
            if matches!(base, 'i' | 'j') && !matches!(accent, Accent::Below | Accent::Stroke) {
                parts.pop();
            }
            parts.extend(strokes_of(accent, base, width));
        }
        if x > 0.0 {
            x += GAP;
        }
        line.strokes.extend(parts.iter().map(|part| part.iter().map(|p| [x + p[0], 0.5 - p[1]]).collect()));
        x += width;
    }
    line.width = x;
    for point in line.strokes.iter_mut().flatten() {
        point[0] -= x / 2.0;
    }
    line
}

/// Returns the strokes of an accent on a letter of this width.
fn strokes_of(accent: Accent, base: char, width: f32) -> Vec<Stroke> {
    let top =
        if base.is_lowercase() && !matches!(base, 'd' | 'h' | 'k' | 'l' | 't') { letter_forms::SMALL } else { 1.0 };
    let (middle, over) = (width / 2.0, top + ACCENT_OVER);
    let at = |points: &[[f32; 2]]| points.iter().map(|[x, y]| [middle + x, over + y]).collect::<Stroke>();
    let acute = |x: f32| at(&[[x - 0.05, -0.04], [x + 0.07, 0.08]]);
    match accent {
        Accent::Acute => vec![acute(0.0)],
        Accent::Grave => vec![at(&[[0.05, -0.04], [-0.07, 0.08]])],
        Accent::Circumflex => vec![at(&[[-0.14, -0.04], [0.0, 0.08], [0.14, -0.04]])],
        Accent::Caron => vec![at(&[[-0.14, 0.08], [0.0, -0.04], [0.14, 0.08]])],
        Accent::Tilde => vec![at(&[[-0.17, -0.03], [-0.08, 0.04], [0.08, -0.02], [0.17, 0.05]])],
        Accent::Diaeresis => {
            vec![at(&[[-DOTS_HALF, 0.0], [-DOTS_HALF, 0.02]]), at(&[[DOTS_HALF, 0.0], [DOTS_HALF, 0.02]])]
        }
        Accent::Ring => vec![letter_forms::arc([middle, over + 0.04], [0.10, 0.10], 0.0, 360.0)],
        Accent::Breve => vec![letter_forms::arc([middle, over + 0.09], [0.14, 0.12], 180.0, 360.0)],
        Accent::Macron => vec![at(&[[-0.16, 0.0], [0.16, 0.0]])],
        Accent::DotAbove => vec![at(&[[0.0, 0.0], [0.0, 0.02]])],
        Accent::DoubleAcute => vec![acute(-0.12), acute(0.12)],
        Accent::Below => vec![vec![[middle + 0.02, -0.20], [middle - 0.06, -0.34]]],
        Accent::Stroke => vec![match base {
            'd' => vec![[middle - 0.06, 0.84], [width + 0.08, 0.84]],
            'h' => vec![[-0.14, 0.84], [0.18, 0.84]],
            'D' | 'H' => vec![[-0.14, 0.52], [0.2, 0.52]],
            'l' => vec![[-0.14, 0.42], [0.16, 0.60]],
            'L' => vec![[-0.14, 0.40], [0.24, 0.62]],
            _ => vec![[-0.06, -0.10], [width + 0.06, top + 0.10]],
        }],
    }
}

#[cfg(test)]
mod tests {
    use super::{super::letter_forms::DIGIT, *};

    #[test]
    fn all_texts_of_the_instrument_can_be_set() {
        for text in ["0", "1", "2", "3", "4", "5", "6", "7", "8", "9", "R"] {
            assert!(!set(text).strokes.is_empty(), "{text}");
        }
        assert_eq!(set("mph").strokes.len(), 3 + 2 + 2);
        assert_eq!(set("km/h").strokes.len(), 3 + 3 + 1 + 2);
        assert_eq!(set("1.8 mi").strokes.len(), 1 + 1 + 2 + 3 + 2);
        assert_eq!(set("50 ft").strokes.len(), 1 + 1 + 2 + 2);
    }

    #[test]
    fn all_digits_have_one_width() {
        for digit in '0'..='9' {
            assert_eq!(set(&digit.to_string()).width, DIGIT);
            assert_eq!(set(&format!("1{digit}")).width, 2.0 * DIGIT + GAP);
        }
    }

    #[test]
    fn digits_stay_in_their_box() {
        for digit in '0'..='9' {
            for [x, y] in set(&digit.to_string()).strokes.into_iter().flatten() {
                assert!(x.abs() <= DIGIT / 2.0 + 0.021 && y.abs() <= 0.5001, "{digit}: {x} {y}");
            }
        }
    }

    #[test]
    fn every_letter_of_a_name_is_set_in_a_line_of_its_height() {
        let letters = ('A'..='Z').chain('a'..='z').chain("ÄÖÜäöüßéèñåøçłŻő-./'’,()&?!".chars());
        let unknown = set("\u{4e2d}");
        for letter in letters {
            let line = set(&letter.to_string());
            assert!(line != unknown && !line.strokes.is_empty(), "{letter}");
            for [x, y] in line.strokes.iter().flatten() {
                // The next letter's pen begins 0.3 beyond the box; accents of capitals stand up to 0.4 above the line, tails 0.35 below.
                assert!(x.abs() <= line.width / 2.0 + 0.15 && (-0.9..=0.85).contains(y), "{letter}: {x} {y}");
            }
        }
    }

    #[test]
    fn no_two_letters_look_alike_and_accents_add_to_their_letter() {
        // O is set as the digit 0, as on number plates.
        let letters: Vec<char> = ('A'..='Z').chain('a'..='z').collect();
        for (k, one) in letters.iter().enumerate() {
            for other in &letters[..k] {
                assert_ne!(set(&one.to_string()), set(&other.to_string()), "{one} {other}");
            }
        }
        assert_eq!(set("Ä").strokes.len(), set("A").strokes.len() + 2);
        assert_eq!(set("Ä").width, set("A").width);
        // An accent replaces the dot of an i; a character without a form is a box of four sides.
        assert_eq!(set("í").strokes.len(), set("i").strokes.len());
        assert_eq!(set("\u{4e2d}").strokes[0].len(), 5);
    }
}
