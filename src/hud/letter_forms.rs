//! Forms of the lettering's characters: digits, letters A to Z and a to z, ß, and the other characters of units and names. In: a character.
//! Out: its width and its strokes, as shares of the height of a digit; y is up from the baseline.

/// Largest angle of one segment of an arc, degrees.
const ARC_STEP_DEG: f32 = 9.0;

/// One stroke, y up from the baseline.
pub(super) type Stroke = Vec<[f32; 2]>;

/// Returns an arc of an ellipse from `from` to `to` degrees, counter-clockwise from +x if `to` is larger.
pub(super) fn arc(centre: [f32; 2], radius: [f32; 2], from: f32, to: f32) -> Stroke {
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

/// Height of a small x as a share of a digit's. With the pen's width it has 0.71 of the height of a capital.
pub(super) const SMALL: f32 = 0.66;
/// Width of every digit, so that a number keeps its place.
pub(super) const DIGIT: f32 = 0.52;

/// Returns the width and the strokes of a character; `None` if it has no form.
pub(super) fn of(sign: char) -> Option<(f32, Vec<Stroke>)> {
    // All digits are 0.52 wide and 1 high.
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
        'p' => (0.46, vec![vec![[0.0, SMALL], [0.0, -0.30]], small_bowl()]),
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
        // Further capitals.
        'A' => (0.58, vec![vec![[0.0, 0.0], [0.29, 1.0], [0.58, 0.0]], vec![[0.10, 0.32], [0.48, 0.32]]]),
        'C' => {
            let upper = arc([0.26, 0.72], [0.26, 0.28], 28.0, 180.0);
            (0.50, vec![join(&[&upper, &arc([0.26, 0.28], [0.26, 0.28], 180.0, 332.0)])])
        }
        'D' => {
            let upper = arc([0.24, 0.70], [0.30, 0.30], 90.0, 0.0);
            let lower = arc([0.24, 0.30], [0.30, 0.30], 0.0, -90.0);
            (0.54, vec![join(&[&[[0.0, 0.0], [0.0, 1.0]], &upper, &lower, &[[0.0, 0.0]]])])
        }
        'F' => (0.44, vec![vec![[0.44, 1.0], [0.0, 1.0], [0.0, 0.0]], vec![[0.0, 0.50], [0.38, 0.50]]]),
        'G' => {
            let upper = arc([0.27, 0.72], [0.27, 0.28], 28.0, 180.0);
            let lower = arc([0.27, 0.28], [0.27, 0.28], 180.0, 360.0);
            (0.54, vec![join(&[&upper, &lower, &[[0.54, 0.48], [0.30, 0.48]]])])
        }
        'I' => (0.04, vec![vec![[0.02, 1.0], [0.02, 0.0]]]),
        'J' => (0.36, vec![join(&[&[[0.36, 1.0]], &arc([0.17, 0.24], [0.19, 0.24], 0.0, -155.0)])]),
        'Q' => {
            let (width, mut strokes) = of('O')?;
            strokes.push(vec![[0.30, 0.24], [0.56, -0.06]]);
            (width, strokes)
        }
        'V' => (0.56, vec![vec![[0.0, 1.0], [0.28, 0.0], [0.56, 1.0]]]),
        'W' => (0.84, vec![vec![[0.0, 1.0], [0.21, 0.0], [0.42, 0.88], [0.63, 0.0], [0.84, 1.0]]]),
        'X' => (0.54, vec![vec![[0.0, 1.0], [0.54, 0.0]], vec![[0.54, 1.0], [0.0, 0.0]]]),
        'Y' => (0.56, vec![vec![[0.0, 1.0], [0.28, 0.46], [0.56, 1.0]], vec![[0.28, 0.46], [0.28, 0.0]]]),
        'Z' => (0.50, vec![vec![[0.0, 1.0], [0.50, 1.0], [0.0, 0.0], [0.50, 0.0]]]),
        // Further small letters.
        'a' => {
            let head = arc([0.20, 0.45], [0.21, 0.21], 155.0, 0.0);
            let (left, right) =
                (arc([0.18, 0.19], [0.18, 0.19], 90.0, 270.0), arc([0.22, 0.19], [0.19, 0.19], 270.0, 360.0));
            (0.41, vec![join(&[&head, &[[0.41, 0.0]]]), join(&[&[[0.41, 0.38]], &left, &right])])
        }
        'b' => (0.46, vec![vec![[0.0, 1.0], [0.0, 0.0]], small_bowl()]),
        'c' => (0.40, vec![arc([0.23, SMALL / 2.0], [0.23, SMALL / 2.0], 45.0, 315.0)]),
        'd' => (0.46, vec![vec![[0.46, 1.0], [0.46, 0.0]], small_bowl()]),
        'e' => {
            let round = arc([0.23, SMALL / 2.0], [0.23, SMALL / 2.0], 0.0, 315.0);
            (0.46, vec![join(&[&[[0.02, 0.33]], &round])])
        }
        'g' => {
            let hook = arc([0.22, -0.10], [0.24, 0.20], 0.0, -145.0);
            (0.46, vec![join(&[&[[0.46, SMALL]], &hook]), small_bowl()])
        }
        'j' => {
            let hook = arc([-0.04, -0.12], [0.18, 0.18], 0.0, -85.0);
            (0.14, vec![join(&[&[[0.14, SMALL]], &hook]), vec![[0.14, 0.93], [0.14, 0.95]]])
        }
        'l' => (0.15, vec![join(&[&[[0.0, 1.0]], &arc([0.15, 0.15], [0.15, 0.15], 180.0, 270.0)])]),
        'n' => {
            let (width, mut strokes) = of('h')?;
            strokes[0][0][1] = SMALL;
            (width, strokes)
        }
        'o' => (0.46, vec![small_bowl()]),
        'q' => (0.46, vec![vec![[0.46, SMALL], [0.46, -0.30]], small_bowl()]),
        'r' => (0.30, vec![vec![[0.0, SMALL], [0.0, 0.0]], arc([0.21, 0.45], [0.21, 0.21], 180.0, 65.0)]),
        's' => {
            let upper = arc([0.20, 0.50], [0.18, 0.16], 35.0, 270.0);
            let lower = arc([0.20, 0.17], [0.20, 0.17], 90.0, -145.0);
            (0.40, vec![join(&[&upper, &lower])])
        }
        'u' => {
            let bottom = arc([0.21, 0.21], [0.21, 0.21], 180.0, 360.0);
            (0.42, vec![join(&[&[[0.0, SMALL]], &bottom]), vec![[0.42, SMALL], [0.42, 0.0]]])
        }
        'v' => (0.46, vec![vec![[0.0, SMALL], [0.23, 0.0], [0.46, SMALL]]]),
        'w' => (0.72, vec![vec![[0.0, SMALL], [0.18, 0.0], [0.36, 0.60], [0.54, 0.0], [0.72, SMALL]]]),
        'x' => (0.44, vec![vec![[0.0, SMALL], [0.44, 0.0]], vec![[0.44, SMALL], [0.0, 0.0]]]),
        'y' => (0.46, vec![vec![[0.0, SMALL], [0.23, 0.03]], vec![[0.46, SMALL], [0.12, -0.30]]]),
        'z' => (0.40, vec![vec![[0.0, SMALL], [0.40, SMALL], [0.0, 0.0], [0.40, 0.0]]]),
        'ß' => {
            let arch = arc([0.20, 0.78], [0.20, 0.22], 180.0, -90.0);
            let belly = arc([0.20, 0.28], [0.25, 0.28], 90.0, -110.0);
            (0.45, vec![join(&[&[[0.0, 0.0]], &arch, &belly])])
        }
        // Further characters of names.
        '-' | '\u{2010}' | '\u{2011}' | '\u{2013}' => (0.24, vec![vec![[0.0, 0.36], [0.24, 0.36]]]),
        '\'' | '\u{2018}' | '\u{2019}' => (0.04, vec![vec![[0.02, 1.0], [0.02, 0.80]]]),
        ',' => (0.04, vec![vec![[0.03, 0.01], [-0.03, -0.15]]]),
        ':' => (0.04, vec![vec![[0.02, 0.0], [0.02, 0.02]], vec![[0.02, 0.5], [0.02, 0.52]]]),
        '?' => {
            let hook = arc([0.23, 0.76], [0.22, 0.24], 165.0, -55.0);
            (0.46, vec![join(&[&hook, &[[0.23, 0.42], [0.23, 0.27]]]), vec![[0.23, 0.0], [0.23, 0.02]]])
        }
        '!' => (0.04, vec![vec![[0.02, 1.0], [0.02, 0.27]], vec![[0.02, 0.0], [0.02, 0.02]]]),
        '(' => (0.16, vec![arc([0.46, 0.45], [0.46, 0.75], 130.0, 230.0)]),
        ')' => (0.16, vec![arc([-0.30, 0.45], [0.46, 0.75], 50.0, -50.0)]),
        '&' => {
            let head = arc([0.23, 0.80], [0.15, 0.20], -50.0, 220.0);
            let belly = arc([0.22, 0.25], [0.22, 0.25], 130.0, 345.0);
            (
                0.56,
                vec![join(&[&[[0.56, 0.0]], &[[0.11, 0.67]]]), head, join(&[&[[0.33, 0.65]], &belly, &[[0.52, 0.42]]])],
            )
        }
        _ => return None,
    })
}

/// Returns the bowl of a small letter.
fn small_bowl() -> Stroke {
    arc([0.23, SMALL / 2.0], [0.23, SMALL / 2.0], 0.0, 360.0)
}

/// Returns the width and the strokes of a character without a form: a box.
pub(super) fn unknown() -> (f32, Vec<Stroke>) {
    (0.5, vec![vec![[0.0, 0.0], [0.5, 0.0], [0.5, 1.0], [0.0, 1.0], [0.0, 0.0]]])
}
