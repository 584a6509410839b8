//! Radii, lengths and heights of the speedometer as shares of the instrument's radius (half its rectangle), from the outside in. In: nothing. Out:
//! constants.

/// Edge of the face; the shadow lies outside.
pub const FACE: f32 = 0.955;
/// Outer and inner end of the red line.
pub const TARGET: (f32, f32) = (0.945, 0.765);
/// Outer and inner edge of the green band.
pub const BAND: (f32, f32) = (0.915, 0.835);
/// Outer end of all ticks.
pub const MARKS: f32 = 0.818;
/// Inner ends of numbered, half and other ticks.
pub const MARKS_INNER: (f32, f32, f32) = (0.720, 0.752, 0.774);
/// Tip and root of the needle: it spans from between numerals and ticks to the band and hides no numeral.
pub const NEEDLE: (f32, f32) = (0.822, 0.650);
/// Radius of the numerals' outer edges, and the height of numerals on scales below 100 and from 100 up: three digits have room outside the hub.
pub const NUMERALS: (f32, f32, f32) = (0.626, 0.102, 0.078);
/// Edge of the hub, which carries number and unit.
pub const HUB: f32 = 0.43;
/// Height of a number below 100 and of one with three digits, and the distance of its middle above the centre.
pub const NUMBER: (f32, f32, f32) = (0.42, 0.30, 0.05);
/// Height of the unit, and the distance of its middle below the centre.
pub const UNIT: (f32, f32) = (0.085, 0.305);
/// Height of the R, and the distance of its middle below the centre.
pub const REVERSE: (f32, f32) = (0.13, 0.69);
/// Arrows of the indicators: distance of the tip beside and below the centre, length, half the height.
pub const INDICATOR: (f32, f32, f32, f32) = (0.46, 0.69, 0.24, 0.095);
/// Telltale of the main beam, between the number and the hub's edge: distance of its middle above the centre, half its height.
pub const MAIN_BEAM: (f32, f32) = (0.345, 0.05);
/// Telltale of the automation, in the gap of the scale: distance of its middle to the left of and below the centre, radius, width of its lines.
pub const AUTOMATION: (f32, f32, f32, f32) = (0.235, 0.535, 0.08, 0.017);
/// Bars of the automation's time gap: distance of the middle of the lowest one's foot to the right of and below the centre, width, height.
pub const TIME_GAP: (f32, f32, f32, f32) = (0.235, 0.615, 0.16, 0.025);
/// Arrow of the guidance: distance of its middle below the centre, half its height, width of its line.
pub const GUIDANCE: (f32, f32, f32) = (0.615, 0.15, 0.036);
/// Height of the text of an event, and the distances of its middle above the centre without and with a sign.
pub const MESSAGE: (f32, f32, f32) = (0.15, 1.22, 1.94);
/// Question: height of its letters, distance of the question above its answers, distances of the answers' middle above the centre without and with a
/// sign, and the further distance with a text.
pub const QUESTION: (f32, f32, f32, f32, f32) = (0.15, 0.34, 1.22, 1.94, 0.34);
/// Sign of an event: half the side of its plate, and the distance of its middle above the centre.
pub const PICTOGRAM: (f32, f32) = (0.34, 1.40);
/// Height of the distance below the arrow, and the distance of its middle below the centre.
pub const GUIDANCE_DISTANCE: (f32, f32) = (0.105, 0.855);
