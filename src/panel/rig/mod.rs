//! Pages that set up a rig: the steering wheel's [`calibration`], the display's check. In: what the devices say, the scenario's
//! numbers. Out: what was chosen.

pub mod calibration;
pub(super) mod display_check;
