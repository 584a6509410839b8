//! Keys of a PC keyboard as key codes of an X server: evdev's codes plus 8.

pub const B: u8 = 56;
pub const BACKSPACE: u8 = 22;
pub const CTRL: u8 = 37;
pub const E: u8 = 26;
pub const ENTER: u8 = 36;
pub const ESC: u8 = 9;
pub const F1: u8 = 67;
pub const F11: u8 = 95;
pub const G: u8 = 42;
pub const I: u8 = 31;
pub const M: u8 = 58;
pub const N: u8 = 57;
pub const P: u8 = 33;
pub const Q: u8 = 24;
pub const RIGHT: u8 = 114;
pub const S: u8 = 39;
pub const SPACE: u8 = 65;
pub const T: u8 = 28;
pub const U: u8 = 30;
pub const V: u8 = 55;
pub const W: u8 = 25;
