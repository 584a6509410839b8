//! Kinds of input devices. In: a device's name, ids and abilities, as the kernel lists them in sysfs without the device
//! being opened. Out: a [`DeviceKind`]. An id in a profile decides before everything else; a mouse is never a wheel.

use super::profile::WheelProfile;

/// Kind of an input device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeviceKind {
    /// A usable steering wheel.
    Wheel,
    /// A wheel that is unusable in its present mode, with the remedy.
    Unfit(&'static str),
    /// A set of pedals, a shifter or another device with axes or buttons of a joystick, which may be a part of the rig or be
    /// calibrated by its id.
    Controller,
    /// A device with sticks, which gilrs reads.
    Pad,
    /// A keyboard, a mouse or another device that does not drive.
    Other,
}

/// Wheels in a mode without force or full range, by vendor and product.
const UNFIT: [(u16, u16, &str); 2] = [
    (
        0x046d,
        0xc260,
        "the switch of the Logitech G29 is at PS4; Linux then gives it neither force nor full range\n  remedy: move \
         the switch on its base to PS3; codrive finds the wheel a moment later",
    ),
    (
        0x046d,
        0xc267,
        "the Logitech G923 is in its PlayStation mode; Linux then gives it no force\n  remedy: install usb_modeswitch \
         with its udev rules; they switch the wheel to its native mode (046d:c266)",
    ),
];

/// Makers of wheel bases, by USB vendor: Moza, Simagic, Cammus, Asetek, Fanatec. Their pedals and flight sticks are
/// excluded by name.
const MAKERS: [u16; 5] = [0x346e, 0x3670, 0x3416, 0x2433, 0x0eb7];

/// Wheel bases whose vendor number is shared with other makers: Simucube 1, 2 Ultimate, 2 Pro, 2 Sport, Simagic Alpha
/// and M10, VRS DirectForce Pro, its R295, FFBeast.
const BASES: [(u16, u16); 8] = [
    (0x16d0, 0x0d5a),
    (0x16d0, 0x0d5f),
    (0x16d0, 0x0d60),
    (0x16d0, 0x0d61),
    (0x0483, 0x0522),
    (0x0483, 0xa355),
    (0x0483, 0xa44c),
    (0x045b, 0x59d7),
];

/// Words in the names of wheels.
const WHEEL_WORDS: [&str; 3] = ["wheel", "racing", "driving force"];

/// Words in the names of parts of a rig.
const PART_WORDS: [&str; 4] = ["pedal", "shifter", "handbrake", "hand brake"];

/// Words in the names of other devices that have axes or force and do not steer.
const OTHER_WORDS: [&str; 6] = ["joystick", "flight", "yoke", "rudder", "throttle", "stick"];

/// Abilities of an input device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Abilities {
    /// Absolute axes, one bit for each evdev code.
    axes: u64,
    /// True for relative axes of a mouse.
    points: bool,
    /// True for a constant force.
    pushes: bool,
    /// True for buttons of a joystick.
    has_triggers: bool,
    /// True for buttons of a gamepad.
    has_pad_buttons: bool,
    has_keys: bool,
    is_accelerometer: bool,
}

impl Abilities {
    /// Reads the abilities from a device's file `uevent` in sysfs.
    pub fn from_uevent(text: &str) -> Self {
        // Codes of linux/input-event-codes.h: REL_X and REL_Y; FF_CONSTANT; BTN_JOYSTICK and BTN_GAMEPAD;
        // INPUT_PROP_ACCELEROMETER.
        let value = |key: &str| text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix('=')).unwrap_or("");
        let [axes, relative, force, keys, properties] = ["ABS", "REL", "FF", "KEY", "PROP"].map(value);
        Self {
            axes: words(axes).next().unwrap_or(0),
            points: bit(relative, 0) || bit(relative, 1),
            pushes: bit(force, 0x52),
            has_triggers: (0x120..0x130).any(|code| bit(keys, code)),
            has_pad_buttons: (0x130..0x140).any(|code| bit(keys, code)),
            has_keys: words(keys).any(|word| word != 0),
            is_accelerometer: bit(properties, 6),
        }
    }

    /// Returns the number of axes that may be steering or pedals: those below the hats.
    fn driving_axes(self) -> u32 {
        (self.axes & 0xffff).count_ones()
    }

    fn steers(self) -> bool {
        self.driving_axes() > 0 && !self.points
    }

    /// Checks for buttons of a joystick, which need no axis; or for axes, of which one suffices for a device that is `named` as
    /// a part of a rig.
    fn is_controller(self, named: bool) -> bool {
        let few = if named { 1 } else { 2 };
        let has_axes = !self.has_keys && !self.is_accelerometer && self.driving_axes() >= few;
        !self.points && (self.has_triggers || has_axes || named && self.has_pad_buttons)
    }
}

/// Returns the words of a kernel's bitmap, the lowest first.
fn words(bitmap: &str) -> impl Iterator<Item = u64> {
    bitmap.split_whitespace().rev().map(|word| u64::from_str_radix(word, 16).unwrap_or(0))
}

fn bit(bitmap: &str, code: usize) -> bool {
    words(bitmap).nth(code / 64).is_some_and(|word| word >> (code % 64) & 1 == 1)
}

/// Returns the kind of a device. `own` are the profiles that a person made or named, `shipped` those of codrive.
pub fn kind(
    id: (u16, u16),
    name: &str,
    abilities: Abilities,
    own: &[WheelProfile],
    shipped: &[WheelProfile],
) -> DeviceKind {
    let in_any = |profiles: &[WheelProfile]| profiles.iter().any(|profile| profile.is_for(id.0, id.1));
    if in_any(own) {
        return DeviceKind::Wheel;
    }
    if let Some((.., remedy)) = UNFIT.iter().find(|(vendor, product, _)| (*vendor, *product) == id) {
        return DeviceKind::Unfit(remedy);
    }
    if in_any(shipped) {
        return DeviceKind::Wheel;
    }
    let name = name.to_lowercase();
    let has = |words: &[&str]| words.iter().any(|word| name.contains(word));
    let part = has(&PART_WORDS);
    let named = has(&WHEEL_WORDS) && !part;
    let made = MAKERS.contains(&id.0) || BASES.contains(&id) || abilities.pushes && abilities.driving_axes() > 1;
    if abilities.steers() && (named || made && !part && !has(&OTHER_WORDS)) {
        DeviceKind::Wheel
    } else if abilities.steers() && abilities.has_pad_buttons && !part {
        DeviceKind::Pad
    } else if abilities.is_controller(part) {
        DeviceKind::Controller
    } else {
        DeviceKind::Other
    }
}

#[cfg(test)]
mod tests {
    use super::{super::profiles, *};

    /// Bitmaps of a wheel base by hid-universal-pidff: eight axes and one hat, 48 buttons, constant force.
    const BASE: &str = "EV=20001b\nKEY=ffff00000000 0 0 0 0\nABS=300ff\nMSC=10\nFF=300040000 0\n";
    /// Bitmaps of a mouse: three buttons, two axes and a wheel, all relative.
    const MOUSE: &str = "EV=17\nKEY=70000 0 0 0 0\nREL=903\nMSC=10\n";
    /// Bitmaps of a gamepad: sticks, triggers and hat; rumble and periodic effects, as the kernel makes them of rumble.
    const PAD: &str = "EV=20000b\nKEY=7cdb000000000000 0 0 0 0\nABS=3003f\nFF=107030000 0\n";

    fn of(id: (u16, u16), name: &str, uevent: &str, own: &[WheelProfile]) -> DeviceKind {
        kind(id, name, Abilities::from_uevent(uevent), own, &profiles::shipped().collect::<Vec<_>>())
    }

    #[test]
    fn bases_without_the_word_wheel_are_found_by_force_or_maker() {
        let without_force = BASE.replace("FF=", "XX=");
        for (id, name) in [
            ((0x346e, 0x0004), "Gudsen MOZA R5 Base"),
            ((0x16d0, 0x0d60), "Granite Devices SimuCUBE 2 Pro"),
            ((0x0483, 0x0522), "Simagic Alpha"),
            ((0x0483, 0xa355), "VRS DirectForce Pro"),
        ] {
            assert_eq!(of(id, name, BASE, &[]), DeviceKind::Wheel, "{name}");
            assert_eq!(of(id, name, &without_force, &[]), DeviceKind::Wheel, "{name} by its maker");
        }
        assert_eq!(of((0x1209, 0xffb0), "OpenFFBoard", BASE, &[]), DeviceKind::Wheel, "by its force");
        assert_eq!(of((0x1209, 0xffb0), "OpenFFBoard", &without_force, &[]), DeviceKind::Controller);
    }

    #[test]
    fn mice_pads_sticks_and_pedals_are_no_wheels() {
        assert_eq!(of((0x045e, 0x0040), "Microsoft Wheel Mouse Optical", MOUSE, &[]), DeviceKind::Other);
        let tablet = MOUSE.replace("REL=903", "REL=903\nABS=3");
        assert_eq!(of((1, 2), "Wheel Mouse with a pen", &tablet, &[]), DeviceKind::Other);
        assert_eq!(of((1, 2), "Racing Keyboard", "EV=120013\nKEY=fffffffe\n", &[]), DeviceKind::Other);
        assert_eq!(of((0x045e, 0x028e), "Microsoft X-Box 360 pad", PAD, &[]), DeviceKind::Pad);
        assert_eq!(of((0x045e, 0x001b), "SideWinder Force Feedback 2 Joystick", BASE, &[]), DeviceKind::Controller);
        assert_eq!(of((0x346e, 0x0003), "MOZA SR-P Pedals", "EV=9\nABS=7\n", &[]), DeviceKind::Controller);
        assert_eq!(of((1, 2), "Racing Wheel Pedals", BASE, &[]), DeviceKind::Controller);
        assert_eq!(of((1, 2), "Laptop accelerometer", "EV=9\nABS=7\nPROP=40\n", &[]), DeviceKind::Other);
    }

    #[test]
    fn shifters_button_boxes_and_handbrakes_are_parts_of_a_rig() {
        let buttons = "EV=3\nKEY=ffff00000000 0 0 0 0\n";
        assert_eq!(of((1, 2), "Button box", buttons, &[]), DeviceKind::Controller, "without an axis");
        let pad_buttons = buttons.replace("ffff00000000", "7cdb000000000000");
        assert_eq!(of((1, 2), "TH8A Shifter", &pad_buttons, &[]), DeviceKind::Controller);
        assert_eq!(of((1, 2), "Unknown keypad", &pad_buttons, &[]), DeviceKind::Other);
        assert_eq!(of((1, 2), "USB Handbrake", "EV=9\nABS=1\n", &[]), DeviceKind::Controller, "one axis, no button");
        assert_eq!(of((1, 2), "Ambient light", "EV=9\nABS=1\n", &[]), DeviceKind::Other);
        assert_eq!(
            of((0x346e, 0x0006), "MOZA HBP Handbrake", BASE, &[]),
            DeviceKind::Controller,
            "by a maker of bases"
        );
    }

    #[test]
    fn an_id_in_an_own_profile_decides_before_name_and_abilities() {
        let own = |id: &str| [WheelProfile { products: vec![id.into()], ..profiles::named("g29").unwrap() }];
        assert_eq!(of((0x045e, 0x028e), "X-Box 360 pad", PAD, &own("045e:028e")), DeviceKind::Wheel);
        assert_eq!(of((0x046d, 0xc260), "Logitech G29", BASE, &own("046d:c260")), DeviceKind::Wheel, "its owner knows");
        assert!(matches!(of((0x046d, 0xc260), "Logitech G29", BASE, &[]), DeviceKind::Unfit(_)));
    }
}
