//! Colours of the speedometer: sRGB, 0 to 255, as in the final picture.

/// Red, green, blue; sRGB.
pub type Rgb = [u8; 3];

/// Colours of the instrument and of its signals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Palette {
    /// Line at the target.
    pub target: Rgb,
    /// Band of the acceptable range.
    pub band: Rgb,
    /// Number while the speed is acceptable.
    pub number_inside: Rgb,
    /// Number while the speed is not acceptable, or without advice.
    pub number_outside: Rgb,
    /// Needle of the dial.
    pub needle: Rgb,
    /// Ticks and their numerals.
    pub scale: Rgb,
    /// Text of the unit.
    pub label: Rgb,
    /// The R of the reverse gear.
    pub reverse: Rgb,
    /// Telltales of the indicators: green, as required by UN R121.
    pub indicator: Rgb,
    /// Telltale of the main beam: blue, as required by UN R121.
    pub main_beam: Rgb,
    /// Face of the dial, drawn with `plate_alpha`.
    pub plate: Rgb,
    /// Opacity of the face, 0 to 255.
    pub plate_alpha: u8,
}

impl Palette {
    /// Colours of HC22: red line, green band, number green inside the range and white outside.
    pub const HC22: Self = Self {
        target: [255, 48, 48],
        band: [36, 196, 94],
        number_inside: [64, 240, 128],
        number_outside: [255, 255, 255],
        needle: [255, 255, 255],
        scale: [206, 212, 220],
        label: [160, 168, 178],
        reverse: [255, 190, 64],
        indicator: [64, 240, 128],
        main_beam: [72, 132, 255],
        plate: [13, 15, 19],
        plate_alpha: 222,
    };

    /// For red-green colour blindness: an orange line on a blue band, the number blue inside (hues of Okabe and Ito's
    /// set, which stay distinct under protanopia, deuteranopia and tritanopia).
    pub const COLOUR_BLIND_SAFE: Self = Self {
        target: [255, 159, 10],
        band: [0, 114, 208],
        number_inside: [100, 190, 255],
        reverse: [240, 228, 66],
        ..Self::HC22
    };
}

impl Default for Palette {
    fn default() -> Self {
        Self::HC22
    }
}
