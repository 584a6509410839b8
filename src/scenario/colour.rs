//! Colours as a person writes them: a name or `#rrggbb`. In: text. Out: sRGB bytes, or linear RGB for the picture.

/// Names of colours with their sRGB values.
pub const NAMES: [(&str, [u8; 3]); 12] = [
    ("red", [0xb8, 0x16, 0x12]),
    ("green", [0x30, 0xa2, 0x45]),
    ("blue", [0x1c, 0x4e, 0x9e]),
    ("yellow", [0xe6, 0xb8, 0x10]),
    ("orange", [0xd9, 0x66, 0x10]),
    ("violet", [0x5a, 0x2e, 0x8a]),
    ("white", [0xdc, 0xdc, 0xda]),
    ("silver", [0xa6, 0xaa, 0xad]),
    ("grey", [0x60, 0x64, 0x68]),
    ("black", [0x1c, 0x1c, 0x1e]),
    ("brown", [0x56, 0x38, 0x22]),
    ("magenta", [0xe1, 0x00, 0xe1]),
];

/// Returns the names of [`NAMES`] in order.
pub fn names() -> [&'static str; NAMES.len()] {
    NAMES.map(|(name, _)| name)
}

/// Error for a text that is not a colour; the message has the allowed values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("#rrggbb (six hexadecimal digits) or one of {}", names().join(", "))]
pub struct UnknownColour;

/// Returns the sRGB bytes of a name or of `#rrggbb`.
///
/// # Errors
/// The text is neither.
pub fn srgb(text: &str) -> Result<[u8; 3], UnknownColour> {
    if let Some((_, bytes)) = NAMES.iter().find(|(name, _)| *name == text) {
        return Ok(*bytes);
    }
    let digits = text.strip_prefix('#').filter(|d| d.len() == 6 && d.bytes().all(|b| b.is_ascii_hexdigit()));
    let byte = |i: usize| digits.and_then(|d| u8::from_str_radix(&d[2 * i..2 * i + 2], 16).ok());
    match (byte(0), byte(1), byte(2)) {
        (Some(r), Some(g), Some(b)) => Ok([r, g, b]),
        _ => Err(UnknownColour),
    }
}

/// Returns the colour of a name or of `#rrggbb` as linear RGB, 0..1 (IEC 61966-2-1).
///
/// # Errors
/// As [`srgb`].
pub fn linear(text: &str) -> Result<[f32; 3], UnknownColour> {
    srgb(text).map(|bytes| {
        bytes.map(|byte| {
            let v = f32::from(byte) / 255.0;
            if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_texts_than_names_and_six_digits_are_errors_with_allowed_values() {
        assert_eq!(srgb("#ff8000"), Ok([255, 128, 0]));
        assert_eq!(srgb("#FF8000"), Ok([255, 128, 0]));
        assert_eq!(srgb("red"), Ok(NAMES[0].1));
        for bad in ["", "#12345", "#1234567", "#+12345", "123456", "rad", "Red", "#ffé00"] {
            let allowed = srgb(bad).expect_err(bad).to_string();
            assert!(allowed.contains("#rrggbb") && allowed.contains("silver"), "{allowed}");
        }
        let [r, g, b] = linear("#ff8000").expect("a colour");
        assert!(r == 1.0 && (g - 0.2159).abs() < 1e-3 && b == 0.0, "{r} {g} {b}");
        // IEC 61966-2-1: up to 0.04045 the value is linear, byte / (255 * 12.92).
        let [dark, ..] = linear("#0a0000").expect("a colour");
        assert!((dark - 10.0 / 3294.6).abs() < 1e-6, "{dark}");
    }
}
