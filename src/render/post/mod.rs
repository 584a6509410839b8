//! From light to the screen: [`bloom`], [`tonemap`], the output of egui ([`ui_pass`]), the experimenter's [`preview`].
//! In: textures of light. Out: sRGB values.

pub mod bloom;
pub mod preview;
pub mod tonemap;
pub mod ui_pass;

#[cfg(test)]
mod mirror_inset_tests;
