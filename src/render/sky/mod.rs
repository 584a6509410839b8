//! The sky: its light ([`atmosphere`]), its `clouds`, and both on the device ([`sky_pass`]). In: the hour and how far one sees.
//! Out: bindings of the scene's pass.

pub mod atmosphere;
pub(super) mod clouds;
pub mod sky_pass;
