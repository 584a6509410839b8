//! Text of a figure: widths and line breaks. In: words and a size. Out: widths in the units of the picture. A picture is shown
//! in two fonts: a browser sets it in Helvetica, Arial or a font of equal widths, [`png`](super::png) in the program's own
//! font. The wider of the two counts.

use skrifa::{
    FontRef, MetadataProvider,
    instance::{LocationRef, Size},
};
use std::sync::OnceLock;

/// Font size of all text, units of the picture: 8 points at the intended print width.
pub(super) const SIZE: f64 = 12.0;
/// Distance from one line to the next, units of the picture.
pub(super) const LINE: f64 = 14.5;
/// Widths of Helvetica's characters from space to tilde, thousandths of the font size (Adobe's font metrics of the core 14
/// fonts).
const HELVETICA: [u16; 95] = [
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278, 556, 556, 556, 556, 556, 556, 556,
    556, 556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667, 611, 778, 722, 278, 500, 667, 556, 833,
    722, 778, 667, 778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 278, 278, 278, 469, 556, 333, 556, 556, 500, 556,
    556, 278, 556, 556, 222, 222, 500, 222, 833, 556, 556, 556, 556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334,
    260, 334, 584,
];

/// Returns the width of a line of text of this size.
pub fn width(text: &str, size: f64) -> f64 {
    text.chars().map(|sign| helvetica(sign).max(own(sign))).sum::<f64>() * size
}

/// Returns the width of a character in Helvetica, as a share of the size. Outside the table: 0.584 for minus and dash, 0.78 for
/// European letters, else 1.
fn helvetica(sign: char) -> f64 {
    let at = (sign as usize).checked_sub(0x20);
    match at.and_then(|at| HELVETICA.get(at)) {
        Some(thousandths) => f64::from(*thousandths) / 1000.0,
        None if sign == '−' || sign == '–' => 0.584,
        None if (sign as u32) < 0x250 => 0.78,
        None => 1.0,
    }
}

/// Returns the width of a character in the program's own font, as a share of the size.
fn own(sign: char) -> f64 {
    static ASCII: OnceLock<Vec<f64>> = OnceLock::new();
    let measured = |sign: char| {
        let font = FontRef::new(epaint_default_fonts::UBUNTU_LIGHT).ok()?;
        let glyph = font.charmap().map(sign)?;
        Some(f64::from(font.glyph_metrics(Size::new(1.0), LocationRef::default()).advance_width(glyph)?))
    };
    let ascii = ASCII.get_or_init(|| (0..128u8).map(|code| measured(code.into()).unwrap_or(0.0)).collect());
    ascii.get(sign as usize).copied().unwrap_or_else(|| measured(sign).unwrap_or(1.0))
}

/// Checks whether text can be set in this font file.
pub fn is_font(bytes: &[u8]) -> bool {
    FontRef::from_index(bytes, 0).is_ok_and(|font| font.charmap().has_map())
}

/// Breaks text into lines no wider than `limit`: after spaces and signs that join words, and within a word that is wider than a
/// line.
pub fn wrapped(text: &str, limit: f64, size: f64) -> Vec<String> {
    let mut lines = vec![String::new()];
    for piece in text.split_inclusive([' ', '-', '+', '/', '_', ',']) {
        let line = lines.last_mut().expect("there is one");
        let fits = |line: &str| width(line.trim_end(), size) <= limit;
        if fits(&(line.clone() + piece)) {
            line.push_str(piece);
            continue;
        }
        if !line.is_empty() {
            lines.push(String::new());
        }
        for sign in piece.chars() {
            let line = lines.last_mut().expect("there is one");
            if !line.is_empty() && !fits(&format!("{line}{sign}")) {
                lines.push(sign.into());
            } else {
                line.push(sign);
            }
        }
    }
    lines.iter().map(|line| line.trim_end().to_owned()).collect()
}

/// Returns the number of lines of a name in a room of this width; `None` if it has to be broken within a word.
pub fn lines_needed(name: &str, limit: f64) -> Option<usize> {
    let mut words = name.split_inclusive([' ', '-', '+', '/', '_', ',']);
    words.all(|word| width(word.trim_end(), SIZE) <= limit).then(|| wrapped(name, limit, SIZE).len())
}

/// Escapes text for SVG and HTML.
pub fn escaped(text: &str) -> String {
    // XML allows no control characters except tab and line ends, not even as character references.
    let is_none_of_xml = |c: char| (c.is_control() && !"\t\n\r".contains(c)) || "\u{fffe}\u{ffff}".contains(c);
    let text = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;");
    text.replace(is_none_of_xml, "\u{fffd}")
}

/// Replaces a leading hyphen by a true minus sign (U+2212).
pub fn minus(number: &str) -> String {
    number.replacen('-', "−", usize::from(number.starts_with('-')))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn widths_are_those_of_the_wider_font_and_lines_break_where_words_end() {
        // H 722, a and i of Helvetica: 722 + 556 + 222 thousandths.
        assert!((width("Hai", 10.0) - 15.0).abs() < 1.0, "{}", width("Hai", 10.0));
        assert!(width("mm", 12.0) >= 2.0 * 0.833 * 12.0 && width("", 12.0) == 0.0);
        assert_eq!(wrapped("Mean speed of all cars, m/s", 90.0, 12.0), ["Mean speed of", "all cars, m/s"]);
        assert_eq!(wrapped("few-cars+wide", 55.0, 12.0), ["few-cars+", "wide"]);
        for limit in [5.0, 30.0, 60.0] {
            let lines = wrapped("a-verylongwordwithoutanybreak indeed", limit, 12.0);
            assert!(lines.iter().all(|line| width(line, 12.0) <= limit.max(12.0)), "{lines:?}");
            assert_eq!(lines.concat().replace(' ', ""), "a-verylongwordwithoutanybreakindeed");
        }
        assert_eq!((lines_needed("few-cars", 30.0), lines_needed("verylongword", 30.0)), (Some(2), None));
        assert_eq!((minus("-0.5").as_str(), minus("1-2").as_str()), ("−0.5", "1-2"));
    }
}
