//! Words and numbers of pages, figures and methods. In: numbers, units and lists. Out: text.

use crate::plot::minus;

/// Formats a number with at most four decimals, no trailing zeros, and a true minus sign.
pub fn number_text(number: f64) -> String {
    let text = format!("{number:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    minus(if text == "-0" { "0" } else { text })
}

/// Replaces the characters that end a line or control a terminal by spaces.
pub fn on_one_line(text: &str) -> String {
    text.replace(|sign: char| sign.is_control() || "\u{2028}\u{2029}".contains(sign), " ")
}

/// Joins words: `a`, `a and b`, `a, b and c`.
pub fn joined_with_and(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// Returns a number of drives in words.
pub fn count(drives: usize) -> String {
    if drives == 1 { "1 drive".into() } else { format!("{drives} drives") }
}

/// Returns a number of participants in words.
pub fn people(n: usize) -> String {
    if n == 1 { "1 participant".into() } else { format!("{n} participants") }
}
