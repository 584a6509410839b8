//! Further devices of a rig, such as pedals, a shifter or a handbrake. In: USB ids and places from sysfs, texts of a profile such as
//! `0eb7:183b` or `0eb7:183b at usb-0000:00:14.0-2/input0`. Out: the number of the device in the rig; the wheel itself has number 0.

use std::fmt;

/// Distance of the axis codes of one device of the rig from those of the next: above all codes of evdev.
pub const PART: u16 = 64;
/// Distance of the button codes of one device of the rig from those of the next: above all codes of evdev.
pub const BUTTON_PART: u16 = 0x300;

/// Rule for the texts that name a device, for messages.
pub const ALLOWED_DEVICE: &str = "allowed: VENDOR:PRODUCT in four hexadecimal digits each, such as 046d:c24f; behind it ` at ` and the serial \
                                  number or USB port, where two devices have the id";

/// USB place of a device; both texts are empty where sysfs has none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// Serial number, the same at every port.
    pub serial: String,
    /// Port, such as `usb-0000:00:14.0-2/input0`.
    pub port: String,
}

/// Further device of a rig.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Part {
    /// Vendor and product on USB.
    pub id: (u16, u16),
    pub place: Place,
}

/// Reason why a text names no device of the rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PartFault {
    Missing,
    /// Several devices have the id, and the text names no place.
    Ambiguous,
}

impl fmt::Display for PartFault {
    /// Writes the fault as the end of a sentence, with its remedy.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Missing => "is not plugged in\n  remedy: plug it in, or measure the rig with codrive calibrate",
            Self::Ambiguous => {
                "is plugged in twice, and the profile does not say which one it means\n  remedy: unplug the other, or measure \
                 the rig with codrive calibrate"
            }
        })
    }
}

/// Returns a USB id as `vendor:product`.
pub fn id_text((vendor, product): (u16, u16)) -> String {
    format!("{vendor:04x}:{product:04x}")
}

/// Splits the text that names a device into its id and its place.
fn split(device: &str) -> (&str, Option<&str>) {
    device.split_once(" at ").map_or((device, None), |(id, place)| (id, Some(place)))
}

/// Checks whether a text is a USB id.
pub fn is_id(text: &str) -> bool {
    let hex = |part: &str| part.len() == 4 && part.chars().all(|digit| digit.is_ascii_hexdigit());
    text.split_once(':').is_some_and(|(vendor, product)| hex(vendor) && hex(product))
}

/// Checks whether a text has the form that names a device.
pub fn is_device(text: &str) -> bool {
    let (id, place) = split(text);
    is_id(id) && place != Some("")
}

/// Returns the number of the named device in the rig.
///
/// # Errors
/// No device has the id and place, or several have them.
pub fn number(parts: &[Part], device: &str) -> Result<u16, PartFault> {
    let (id, place) = split(device);
    let is_it = |part: &Part| {
        let at = |place: &str| place == part.place.serial || place == part.place.port;
        id.eq_ignore_ascii_case(&id_text(part.id)) && place.is_none_or(at)
    };
    let mut found = (1..).zip(parts).filter(|(_, part)| is_it(part)).map(|(number, _)| number);
    match (found.next(), found.next()) {
        (None, _) => Err(PartFault::Missing),
        (Some(number), None) => Ok(number),
        (Some(_), Some(_)) => Err(PartFault::Ambiguous),
    }
}

/// Returns the shortest text that names a device of the rig: its id; for one of several with the id also the serial number, or
/// the port where the serial number is missing or theirs, too. `None` is the wheel itself.
pub fn name(parts: &[Part], number: u16) -> Option<String> {
    let part = parts.get(usize::from(number.checked_sub(1)?))?;
    let id = id_text(part.id);
    let places = [&part.place.serial, &part.place.port].into_iter().filter(|place| !place.is_empty());
    let longer = places.map(|place| format!("{id} at {place}"));
    let names: Vec<String> = std::iter::once(id.clone()).chain(longer).collect();
    Some(names.into_iter().find(|name| self::number(parts, name) == Ok(number)).unwrap_or(id))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(product: u16, serial: &str, port: &str) -> Part {
        Part { id: (0x0eb7, product), place: Place { serial: serial.into(), port: port.into() } }
    }

    #[test]
    fn a_device_is_named_by_its_id_and_of_two_alike_by_serial_or_port() {
        let parts = [part(1, "", "usb-1/input0"), part(2, "A", "usb-2/input0"), part(2, "B", "usb-3/input0")];
        let names = |parts: &[Part]| (1..=parts.len() as u16).filter_map(|n| name(parts, n)).collect::<Vec<_>>();
        assert_eq!(names(&parts), ["0eb7:0001", "0eb7:0002 at A", "0eb7:0002 at B"]);
        let twins = [part(2, "A", "usb-2/input0"), part(2, "A", "usb-2/input1"), part(2, "", "usb-3/input0")];
        let ports = ["0eb7:0002 at usb-2/input0", "0eb7:0002 at usb-2/input1", "0eb7:0002 at usb-3/input0"];
        assert_eq!(names(&twins), ports, "a serial number that both have tells nothing");
        for (n, name) in (1..).zip(names(&twins)) {
            assert_eq!(number(&twins, &name), Ok(n), "{name}");
        }
        assert_eq!((name(&parts, 0), name(&parts, 4)), (None, None));
    }

    #[test]
    fn a_device_that_is_missing_or_named_for_two_has_no_number() {
        let parts = [part(1, "", "usb-1/input0"), part(2, "A", "usb-2/input0"), part(2, "B", "usb-3/input0")];
        assert_eq!(number(&parts, "0EB7:0001"), Ok(1), "in either case");
        assert_eq!(number(&parts, "0eb7:0002 at usb-3/input0"), Ok(3), "a profile may name the port");
        assert_eq!(number(&parts, "0eb7:0002"), Err(PartFault::Ambiguous));
        assert_eq!(number(&parts, "0eb7:0002 at C"), Err(PartFault::Missing));
        assert_eq!(number(&parts, "0eb7:0003"), Err(PartFault::Missing));
    }

    #[test]
    fn the_form_of_a_device_is_an_id_and_perhaps_a_place() {
        assert!(is_device("0eb7:183b") && is_device("0EB7:183b at usb-0000:00:14.0-2/input0"));
        for text in ["pedals", "0eb7", "0eb7:183", "0eb7:183b at ", "0eb7:183b usb-1", ""] {
            assert!(!is_device(text), "{text}");
        }
        assert!(!is_id("0eb7:183b at A"));
    }
}
