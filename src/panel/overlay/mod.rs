//! What lies over a picture of a drive: the list of keys, the flash of a contact, whether the drive is recorded, a replay's
//! [`seek_bar`]. In: states. Out: shapes, and what was asked for.

pub(super) mod contact_flash;
pub(super) mod key_list;
pub mod recording_sign;
pub mod room_sign;
pub mod seek_bar;
