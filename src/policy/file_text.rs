//! Parts of the text of a trained policy's file: its format, and numbers that read back to the same bits.

/// Identifier of the file format and its version.
pub const FORMAT: &str = "codrive policy 2";

/// Returns true for 0; used to skip keys that have their default value.
pub(super) fn is_zero(x: &f64) -> bool {
    *x == 0.0
}

/// Formats numbers as a TOML array.
pub(super) fn row(numbers: &[f32]) -> String {
    let words: Vec<String> = numbers.iter().map(|x| number(*x)).collect();
    format!("[{}]", words.join(", "))
}

fn number(x: f32) -> String {
    // TOML requires lower-case `nan`.
    let short = format!("{x:?}").to_lowercase();
    // The reader parses as f64 and rounds again, which in rare cases gives the neighbouring f32.
    let same = short.parse::<f64>().is_ok_and(|y| (y as f32).to_bits() == x.to_bits());
    if same { short } else { format!("{:?}", f64::from(x)) }
}
