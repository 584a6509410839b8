//! Lettering of the instrument, of number plates and of road signs: digits, the letters of units and some capitals as strokes of one
//! width, so that no font and no glyph atlas is needed. The forms are legible at a distance (open forms, tabular
//! digits). In: text, height. Out: polylines, to be drawn with a round pen of [`PEN`] times the height.

/// Width of the pen as a share of the height of a digit.
pub const PEN: f32 = 0.16;
/// Space between the boxes of two characters (from the middle of one pen to the next), as a share of the height.
const GAP: f32 = 0.30;
/// Largest angle of one segment of an arc, degrees.
const ARC_STEP_DEG: f32 = 9.0;

/// Line of text, 1.0 high from the baseline to the top of a digit, with its middle at the origin: x to the right, y
/// down. Half the pen's width lies outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LetteredLine {
    /// Strokes, each at least two points.
    pub strokes: Vec<Vec<[f32; 2]>>,
    /// Distance from the middle of the first pen stroke to the middle of the last.
    pub width: f32,
}

/// Lays out `text`; characters that the instrument does not need are left out.
pub fn set(text: &str) -> LetteredLine {
    let mut line = LetteredLine::default();
    let mut x = 0.0;
    for sign in text.chars() {
        let Some((width, parts)) = sign_strokes(sign) else { continue };
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

/// One stroke, y up from the baseline.
type Stroke = Vec<[f32; 2]>;

/// Returns an arc of an ellipse from `from` to `to` degrees, counter-clockwise from +x if `to` is larger.
fn arc(centre: [f32; 2], radius: [f32; 2], from: f32, to: f32) -> Stroke {
    let pieces = ((to - from).abs() / ARC_STEP_DEG).ceil().max(1.0);
    (0..=pieces as u32)
        .map(|i| {
            let (sin, cos) = (from + (to - from) * i as f32 / pieces).to_radians().sin_cos();
            [centre[0] + radius[0] * cos, centre[1] + radius[1] * sin]
        })
        .collect()
}

/// Joins strokes end to end.
fn join(parts: &[&[[f32; 2]]]) -> Stroke {
    parts.concat()
}

/// Width of every digit, so that a number keeps its place.
const DIGIT: f32 = 0.52;

fn sign_strokes(sign: char) -> Option<(f32, Vec<Stroke>)> {
    // All digits are 0.52 wide and 1 high; small letters are 0.66 high.
    let bowl = |y: f32| arc([0.26, y], [0.26, 0.27], 0.0, 360.0);
    Some(match sign {
        '0' | 'O' => {
            let upper = arc([0.26, 0.72], [0.26, 0.28], 0.0, 180.0);
            let lower = arc([0.26, 0.28], [0.26, 0.28], 180.0, 360.0);
            (DIGIT, vec![join(&[&upper, &lower, &[[0.52, 0.72]]])])
        }
        '1' => (DIGIT, vec![vec![[0.10, 0.80], [0.32, 1.0], [0.32, 0.0]]]),
        '2' => {
            let head = arc([0.26, 0.74], [0.25, 0.26], 165.0, -37.0);
            (DIGIT, vec![join(&[&head, &[[0.02, 0.0], [0.52, 0.0]]])])
        }
        '3' => {
            let upper = arc([0.25, 0.77], [0.23, 0.23], 155.0, -90.0);
            let lower = arc([0.25, 0.27], [0.27, 0.27], 90.0, -155.0);
            (DIGIT, vec![upper, lower])
        }
        '4' => (DIGIT, vec![vec![[0.30, 1.0], [0.0, 0.25], [0.54, 0.25]], vec![[0.40, 0.54], [0.40, 0.0]]]),
        '5' => {
            let belly = arc([0.25, 0.31], [0.27, 0.31], 132.0, -150.0);
            (DIGIT, vec![join(&[&[[0.47, 1.0], [0.09, 1.0]], &belly])])
        }
        '6' => (DIGIT, vec![bowl(0.27), vec![[0.035, 0.405], [0.37, 1.0]]]),
        '7' => (DIGIT, vec![vec![[0.0, 1.0], [0.52, 1.0], [0.17, 0.0]]]),
        '8' => (DIGIT, vec![arc([0.26, 0.77], [0.22, 0.23], 0.0, 360.0), bowl(0.27)]),
        '9' => (DIGIT, vec![bowl(0.73), vec![[0.485, 0.595], [0.15, 0.0]]]),
        'm' => {
            let first = join(&[&arc([0.17, 0.49], [0.17, 0.17], 180.0, 0.0), &[[0.34, 0.0]]]);
            let second = join(&[&arc([0.51, 0.49], [0.17, 0.17], 180.0, 0.0), &[[0.68, 0.0]]]);
            (0.68, vec![vec![[0.0, 0.66], [0.0, 0.0]], first, second])
        }
        'p' => (0.46, vec![vec![[0.0, 0.66], [0.0, -0.30]], arc([0.23, 0.33], [0.23, 0.33], 0.0, 360.0)]),
        'h' => {
            let arch = join(&[&arc([0.21, 0.45], [0.21, 0.21], 180.0, 0.0), &[[0.42, 0.0]]]);
            (0.42, vec![vec![[0.0, 1.0], [0.0, 0.0]], arch])
        }
        'k' => (
            0.40,
            vec![vec![[0.0, 1.0], [0.0, 0.0]], vec![[0.36, 0.66], [0.0, 0.26]], vec![[0.13, 0.405], [0.40, 0.0]]],
        ),
        // Letters and point of distances.
        'i' => (0.04, vec![vec![[0.02, 0.66], [0.02, 0.0]], vec![[0.02, 0.93], [0.02, 0.95]]]),
        'f' => (
            0.32,
            vec![
                join(&[&[[0.12, 0.0]], &arc([0.28, 0.82], [0.16, 0.18], 180.0, 80.0)]),
                vec![[0.0, 0.62], [0.28, 0.62]],
            ],
        ),
        't' => (
            0.32,
            vec![
                join(&[&[[0.12, 0.95]], &arc([0.28, 0.16], [0.16, 0.16], 180.0, 280.0)]),
                vec![[0.0, 0.62], [0.28, 0.62]],
            ],
        ),
        '.' => (0.04, vec![vec![[0.02, 0.0], [0.02, 0.02]]]),
        ' ' => (0.20, vec![]),
        '/' => (0.34, vec![vec![[0.0, -0.12], [0.34, 1.06]]]),
        'R' => {
            let bow = join(&[&[[0.0, 0.0], [0.0, 1.0]], &arc([0.25, 0.74], [0.26, 0.26], 90.0, -90.0)]);
            (0.52, vec![join(&[&bow, &[[0.0, 0.48]]]), vec![[0.26, 0.48], [0.53, 0.0]]])
        }
        // Capitals of number plates.
        'H' => {
            (DIGIT, vec![vec![[0.0, 1.0], [0.0, 0.0]], vec![[0.52, 1.0], [0.52, 0.0]], vec![[0.0, 0.52], [0.52, 0.52]]])
        }
        'L' => (0.46, vec![vec![[0.0, 1.0], [0.0, 0.0], [0.46, 0.0]]]),
        'M' => (0.60, vec![vec![[0.0, 0.0], [0.0, 1.0], [0.30, 0.42], [0.60, 1.0], [0.60, 0.0]]]),
        'K' => {
            (DIGIT, vec![vec![[0.0, 1.0], [0.0, 0.0]], vec![[0.50, 1.0], [0.0, 0.38]], vec![[0.18, 0.60], [0.53, 0.0]]])
        }
        'N' => (DIGIT, vec![vec![[0.0, 0.0], [0.0, 1.0], [0.52, 0.0], [0.52, 1.0]]]),
        'T' => (0.54, vec![vec![[0.0, 1.0], [0.54, 1.0]], vec![[0.27, 1.0], [0.27, 0.0]]]),
        'E' => (0.46, vec![vec![[0.46, 1.0], [0.0, 1.0], [0.0, 0.0], [0.46, 0.0]], vec![[0.0, 0.53], [0.40, 0.53]]]),
        // Further capitals of STOP and BUS.
        'S' => {
            let upper = arc([0.26, 0.755], [0.24, 0.245], 35.0, 270.0);
            let lower = arc([0.26, 0.255], [0.26, 0.255], 90.0, -145.0);
            (DIGIT, vec![join(&[&upper, &lower])])
        }
        'P' => {
            let bow = join(&[&[[0.0, 0.0], [0.0, 1.0]], &arc([0.25, 0.74], [0.27, 0.26], 90.0, -90.0)]);
            (DIGIT, vec![join(&[&bow, &[[0.0, 0.48]]])])
        }
        'B' => {
            let upper = join(&[&[[0.0, 0.0], [0.0, 1.0]], &arc([0.24, 0.76], [0.25, 0.24], 90.0, -90.0)]);
            let lower = join(&[&[[0.0, 0.52]], &arc([0.25, 0.26], [0.27, 0.26], 90.0, -90.0), &[[0.0, 0.0]]]);
            (DIGIT, vec![join(&[&upper, &[[0.0, 0.52]]]), lower])
        }
        'U' => (DIGIT, vec![join(&[&[[0.0, 1.0]], &arc([0.26, 0.27], [0.26, 0.27], 180.0, 360.0), &[[0.52, 1.0]]])]),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
