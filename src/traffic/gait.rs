//! Gait of people on foot, by which picture and sound go. In: number of a person, way walked. Out: cycles of two steps.
//!
//! The length of a cycle over the height: docs/references.md, walkers.

/// Heights of the builds of people, m. A person's number selects the build.
pub const HEIGHTS_M: [f32; 4] = [1.79, 1.66, 1.73, 1.70];
/// Length of a cycle of two steps over the height.
pub const CYCLE: f32 = 0.76;

/// Returns the build of the person with this number.
pub fn build(number: u32) -> usize {
    number as usize % HEIGHTS_M.len()
}

/// Returns the number of cycles that a person has walked after `moved_m`: at a whole number the left heel touches the ground, half a cycle later
/// the right heel.
pub fn cycles(number: u32, moved_m: f64) -> f64 {
    // People do not step in time with each other.
    moved_m / f64::from(CYCLE * HEIGHTS_M[build(number)]) + f64::from(number) * 0.37
}
