//! The speedometer as data. In: speed, advice, unit, scenario. Out: a [`Dial`]: angles, ticks, colours; no GPU, no egui.
//! HC22: round gauge with ticks and needle, the number in the centre, the target a red line, the acceptable range a
//! green band, the number green inside the range and white outside.

use crate::units::SpeedUnit;

/// Everything on the speedometer in one frame. Speeds in the dial's own unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Dial {
    /// Unit of all numbers.
    pub unit: SpeedUnit,
    /// Full scale, a multiple of `major_step`.
    pub full_scale: f64,
    /// Distance between numbered ticks.
    pub major_step: f64,
    /// Unnumbered ticks between two numbered ones, plus one.
    pub minor_per_major: u32,
    /// Present speed, not negative.
    pub speed: f64,
    /// Advice: target, lower and upper edge of the range.
    pub advice: Option<DialAdvice>,
    /// True if the gear is reverse.
    pub reverse: bool,
}

/// Advice as the dial shows it, in the dial's unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DialAdvice {
    /// The red line.
    pub target: f64,
    /// Lower edge of the green band.
    pub low: f64,
    /// Upper edge of the green band.
    pub high: f64,
}
