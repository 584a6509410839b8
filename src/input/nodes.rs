//! Wheels and other controllers of this computer. In: `/sys/class/input` and the profiles. Out: [`DeviceNode`]s. No device
//! is opened, and keyboards and mice are not listed.

use super::{
    kinds::{self, Abilities, DeviceKind},
    parts::{self, Place},
    profile::WheelProfile,
    profiles,
};
use std::{
    fs,
    path::{Path, PathBuf},
};

/// Input device as listed in sysfs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceNode {
    /// Path of the event device.
    pub path: PathBuf,
    pub name: String,
    /// Vendor and product on USB; 0 where sysfs has none.
    pub id: (u16, u16),
    pub place: Place,
    pub kind: DeviceKind,
}

impl DeviceNode {
    /// Checks whether the device is a wheel, usable or not.
    pub fn is_wheel(&self) -> bool {
        matches!(self.kind, DeviceKind::Wheel | DeviceKind::Unfit(_))
    }

    /// Returns name and ids for messages.
    pub fn described(&self) -> String {
        format!("{} ({})", self.name, parts::id_text(self.id))
    }
}

/// Returns all event devices that are wheels, usable or not, in the order of their numbers.
pub fn wheels() -> Vec<DeviceNode> {
    wheels_in(Path::new("/sys"))
}

fn wheels_in(sys: &Path) -> Vec<DeviceNode> {
    let mut found = devices_in(sys, &profiles::own_profiles().0);
    found.retain(DeviceNode::is_wheel);
    found
}

/// Returns all event devices that are wheels or other controllers: first those of a profile, an own one before a
/// shipped one, then wheels without one, then other controllers; equal ones in the order of their numbers. `asked` is
/// the profile that a person named.
pub fn controllers(asked: Option<&WheelProfile>) -> Vec<DeviceNode> {
    let mut own = profiles::own_profiles().0;
    own.extend(asked.cloned());
    let mut found = devices_in(Path::new("/sys"), &own);
    let shipped: Vec<WheelProfile> = profiles::shipped().collect();
    found.sort_by_key(|node| {
        let listed = |profiles: &[WheelProfile]| profiles.iter().any(|profile| profile.is_for(node.id.0, node.id.1));
        (!listed(asked.map_or(&[], std::slice::from_ref)), !listed(&own), !listed(&shipped), !node.is_wheel())
    });
    found
}

fn devices_in(sys: &Path, own: &[WheelProfile]) -> Vec<DeviceNode> {
    let Ok(entries) = fs::read_dir(sys.join("class/input")) else { return Vec::new() };
    let shipped: Vec<WheelProfile> = profiles::shipped().collect();
    let number = |name: &str| name.strip_prefix("event")?.parse::<u32>().ok();
    let mut found: Vec<(u32, DeviceNode)> = entries
        .flatten()
        .filter_map(|entry| {
            let file = entry.file_name().into_string().ok()?;
            let number = number(&file)?;
            let text =
                |what: &str| Some(fs::read_to_string(entry.path().join("device").join(what)).ok()?.trim().to_owned());
            let name = text("name")?;
            let hex = |what: &str| u16::from_str_radix(&text(what)?, 16).ok();
            let id = (hex("id/vendor").unwrap_or(0), hex("id/product").unwrap_or(0));
            let place = Place { serial: text("uniq").unwrap_or_default(), port: text("phys").unwrap_or_default() };
            let abilities = Abilities::from_uevent(&text("uevent").unwrap_or_default());
            let kind = kinds::kind(id, &name, abilities, own, &shipped);
            (kind != DeviceKind::Other)
                .then(|| (number, DeviceNode { path: Path::new("/dev/input").join(&file), name, id, place, kind }))
        })
        .collect();
    found.sort_by_key(|(number, _)| *number);
    found.into_iter().map(|(_, node)| node).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_wheels_of_sysfs_are_listed_in_the_order_of_their_numbers() {
        let sys = tempfile::tempdir().unwrap();
        let plug = |event: &str, name: &str, id: Option<(&str, &str)>| {
            let device = sys.path().join("class/input").join(event).join("device");
            fs::create_dir_all(device.join("id")).unwrap();
            fs::write(device.join("name"), format!("{name}\n")).unwrap();
            fs::write(device.join("uevent"), "EV=b\nKEY=ffff00000000 0 0 0 0\nABS=27\n").unwrap();
            if let Some((vendor, product)) = id {
                fs::write(device.join("id/vendor"), format!("{vendor}\n")).unwrap();
                fs::write(device.join("id/product"), format!("{product}\n")).unwrap();
            }
        };
        plug("event10", "Logitech G29", Some(("046d", "c24f")));
        plug("event2", "Some Racing Wheel", None);
        plug("event3", "AT Translated Set 2 keyboard", Some(("0001", "0001")));
        plug("event4", "Logitech G29", Some(("046d", "c260")));
        plug("js0", "Logitech G29", Some(("046d", "c24f")));
        plug("mouse0", "Logitech G29", Some(("046d", "c24f")));
        let found = wheels_in(sys.path());
        let node = |path: &str| DeviceNode {
            path: path.into(),
            name: "Logitech G29".into(),
            id: (0x046d, 0xc24f),
            place: Place::default(),
            kind: DeviceKind::Wheel,
        };
        let unnamed = DeviceNode { name: "Some Racing Wheel".into(), id: (0, 0), ..node("/dev/input/event2") };
        assert_eq!(found.len(), 3, "{found:?}");
        assert_eq!((&found[0], &found[2]), (&unnamed, &node("/dev/input/event10")));
        assert_eq!(found[1].id, (0x046d, 0xc260));
        assert!(matches!(found[1].kind, DeviceKind::Unfit(text) if text.contains("PS3")), "at the switch's other end");
        assert_eq!(wheels_in(&sys.path().join("nothing")), []);
        let device = sys.path().join("class/input/event10/device");
        fs::write(device.join("phys"), "usb-0000:00:14.0-2/input0\n").unwrap();
        fs::write(device.join("uniq"), "A7\n").unwrap();
        let place = Place { serial: "A7".into(), port: "usb-0000:00:14.0-2/input0".into() };
        assert_eq!(wheels_in(sys.path())[2].place, place);
    }
}
