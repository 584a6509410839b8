//! The sky: its light ([`atmosphere`]) by day and in `twilight`, its `clouds`, and all on the device ([`sky_pass`]). In: the direction to the
//! sun and the visibility. Out: bindings for the scene's pass.

pub mod atmosphere;
pub(super) mod clouds;
pub mod sky_pass;
mod twilight;
