//! Pages that set up a rig: the steering wheel's [`calibration`] and the check of the display. In: values of the
//! devices, the scenario's numbers. Out: commands of the pages.

pub mod calibration;
pub(super) mod display_check;
