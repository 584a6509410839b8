//! Overlays on the picture of a drive: the list of keys, the flash of a contact, the recording sign, the sign of a
//! recorded room, a replay's [`seek_bar`]. In: states. Out: shapes and commands.

pub(super) mod contact_flash;
pub(super) mod key_list;
pub mod recording_sign;
pub mod room_sign;
pub mod seek_bar;
