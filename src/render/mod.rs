//! The picture. In: a view of the scene. Out: pixels.

pub mod dial;
pub mod ui_pass;
