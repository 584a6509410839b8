//! Search for the profile of a steering wheel. In: a device's ids and axes, a name given by a person. Out: its
//! [`WheelProfile`]. The user's own profiles come before shipped ones, and those before a guess.

use super::{
    buttons::RigButton,
    parts::{self, BUTTON_PART, PART, Part, Place},
    profile::{AxisRanges, Pedal, ProfileError, WheelProfile},
};
use crate::{
    file::{SETTINGS_BYTES, read_text},
    private,
    toml_text::did_you_mean,
};
use std::{
    collections::BTreeMap,
    ffi::OsString,
    path::{Path, PathBuf},
};

/// Shipped profiles of known wheels, by name.
const SHIPPED: [(&str, &str); 4] = [
    ("g29", include_str!("../../assets/wheels/g29.toml")),
    ("g27", include_str!("../../assets/wheels/g27.toml")),
    ("g920", include_str!("../../assets/wheels/g920.toml")),
    ("g923", include_str!("../../assets/wheels/g923.toml")),
];

/// Returns all shipped profiles.
pub fn shipped() -> impl Iterator<Item = WheelProfile> {
    SHIPPED.iter().filter_map(|(name, text)| WheelProfile::from_toml(text, name).ok())
}

/// Returns the folder of the user's own profiles; `None` without a home folder.
pub fn own_folder() -> Option<PathBuf> {
    own_folder_by(|name| std::env::var_os(name))
}

fn own_folder_by(variable: impl Fn(&str) -> Option<OsString>) -> Option<PathBuf> {
    let set = |name: &str| variable(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let config = set("XDG_CONFIG_HOME").or_else(|| set("APPDATA")).or_else(|| Some(set("HOME")?.join(".config")))?;
    Some(config.join("codrive").join("wheels"))
}

/// Reads a profile file.
///
/// # Errors
/// The file cannot be read, or is no profile.
pub fn load(path: &Path) -> Result<WheelProfile, ProfileError> {
    let shown = path.display().to_string();
    let text = read_text(path, SETTINGS_BYTES).map_err(|e| {
        ProfileError(format!(
            "{shown}: cannot be read: {e}\n  remedy: make a profile with codrive calibrate --name NAME"
        ))
    })?;
    WheelProfile::from_toml(&text, &shown)
}

/// Returns the profile of this name: a file, one of the user's own, or a shipped one.
///
/// # Errors
/// There is no such profile, or it is invalid.
pub fn named(name: &str) -> Result<WheelProfile, ProfileError> {
    if name.ends_with(".toml") {
        return load(Path::new(name));
    }
    if let Some(path) = own_folder().map(|folder| folder.join(format!("{name}.toml"))).filter(|path| path.exists()) {
        return load(&path);
    }
    match SHIPPED.iter().find(|(shipped, _)| *shipped == name) {
        Some((name, text)) => WheelProfile::from_toml(text, name),
        None => {
            let mut names: Vec<String> = SHIPPED.iter().map(|(name, _)| (*name).to_owned()).collect();
            names.extend(own().into_iter().filter_map(|path| Some(path.file_stem()?.to_string_lossy().into_owned())));
            let (near, names) = (did_you_mean(name, &names), names.join(", "));
            Err(ProfileError(format!(
                "there is no wheel profile \"{name}\"{near}; there are {names}\n  remedy: name one of these or a \
                 FILE.toml, or make it with codrive calibrate --name {name}"
            )))
        }
    }
}

/// Returns the user's own profiles, and the errors of files that are none.
pub fn own_profiles() -> (Vec<WheelProfile>, Vec<String>) {
    let (mut profiles, mut faults) = (Vec::new(), Vec::new());
    for path in own() {
        match load(&path) {
            Ok(profile) => profiles.push(profile),
            Err(error) => faults.push(error.to_string()),
        }
    }
    (profiles, faults)
}

/// Returns the files of the user's own profiles, sorted by name.
fn own() -> Vec<PathBuf> {
    own_folder().map_or_else(Vec::new, |folder| profiles_in(&folder))
}

fn profiles_in(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).ok();
    let mut paths: Vec<PathBuf> = entries.into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    paths.sort();
    paths
}

/// Saves a profile, by default among the user's own. Returns its path.
///
/// # Errors
/// There is no home folder, or the file cannot be written.
pub fn save(profile: &WheelProfile, path: Option<&Path>) -> Result<PathBuf, ProfileError> {
    let file = format!("{}.toml", file_name(&profile.name));
    let path = path.map(Path::to_owned).or_else(|| own_folder().map(|folder| folder.join(file)));
    let path =
        path.ok_or_else(|| ProfileError("no home folder is set\n  remedy: name a file with --out FILE.toml".into()))?;
    let refuse = |e: std::io::Error| ProfileError(format!("{}: cannot be written: {e}", path.display()));
    if let Some(folder) = path.parent() {
        private::folder(folder).map_err(refuse)?;
    }
    private::replace(&path, profile.to_toml().as_bytes()).map_err(refuse)?;
    Ok(path)
}

/// Converts a profile's name to a file name: small letters, digits and dashes.
fn file_name(name: &str) -> String {
    let words: Vec<String> = name
        .to_lowercase()
        .split(|c: char| !c.is_ascii_alphanumeric())
        .filter(|word| !word.is_empty())
        .map(str::to_owned)
        .collect();
    if words.is_empty() { "wheel".into() } else { words.join("-") }
}

/// Device without a profile yet.
#[derive(Clone, Debug, Default)]
pub struct UnprofiledDevice {
    pub name: String,
    /// Vendor and product on USB.
    pub id: (u16, u16),
    /// Range of each axis.
    pub axes: AxisRanges,
    /// Present raw value of each axis.
    pub values: BTreeMap<u16, i32>,
    pub place: Place,
    /// Further devices of the rig, such as pedals. The axes of the first have codes from [`PART`] on, those of the second
    /// from twice that, and their buttons from [`BUTTON_PART`] on.
    pub parts: Vec<Part>,
}

impl UnprofiledDevice {
    /// Adds a further device of the rig.
    pub fn add(&mut self, part: &Self) {
        self.parts.push(Part { id: part.id, place: part.place.clone() });
        let code = |code: &u16| code + PART * self.parts.len() as u16;
        self.axes.extend(part.axes.iter().map(|(axis, range)| (code(axis), *range)));
        // If all values are 0, the driver has not read the device yet.
        if part.values.values().any(|raw| *raw != 0) {
            self.values.extend(part.values.iter().map(|(axis, raw)| (code(axis), *raw)));
        }
    }

    /// Returns the button with this code in the rig.
    pub fn button(&self, code: u16) -> RigButton {
        let part = code / BUTTON_PART;
        RigButton { number: code % BUTTON_PART, device: parts::name(&self.parts, part), part }
    }

    /// Leaves out the axes of further devices that the profile does not use. The others keep their codes.
    pub fn keep_parts_of(&mut self, profile: &WheelProfile) {
        self.axes.retain(|code, _| profile.uses_part(code / PART));
        self.values.retain(|code, _| profile.uses_part(code / PART));
    }

    /// Returns the profile with its pedals found on the devices of this rig.
    fn fitted(&self, profile: &WheelProfile) -> Result<WheelProfile, ProfileError> {
        let mut profile = profile.clone();
        profile.find_parts(&self.parts)?;
        profile.fits(&self.axes)?;
        Ok(profile)
    }
}

/// Chooses the profile of a device, and lists the errors of profiles that were skipped. `asked` is the profile that a
/// person named.
///
/// # Errors
/// The named profile does not fit the device, or no profile fits or can be guessed.
pub fn choose(
    device: &UnprofiledDevice,
    asked: Option<&WheelProfile>,
) -> Result<(WheelProfile, Vec<String>), ProfileError> {
    choose_from(&own(), device, asked)
}

/// Chooses the profile of a device, with these files as the user's own profiles.
fn choose_from(
    own: &[PathBuf],
    device: &UnprofiledDevice,
    asked: Option<&WheelProfile>,
) -> Result<(WheelProfile, Vec<String>), ProfileError> {
    let mut faults = Vec::new();
    let (vendor, product) = device.id;
    if let Some(profile) = asked {
        if !profile.products.is_empty() && !profile.is_for(vendor, product) {
            faults.push(format!(
                "profile \"{}\" is for {}, and {} is {vendor:04x}:{product:04x}; it is used all the same\n  remedy: plug \
                 its wheel in, or make a profile with codrive calibrate",
                profile.name,
                profile.products.join(", "),
                device.name
            ));
        }
        return device.fitted(profile).map(|profile| (profile, faults));
    }
    let mut missing = None;
    for path in own {
        match load(path) {
            Ok(profile) if profile.is_for(vendor, product) && !profile.has_its_parts(&device.parts) => {
                missing = device.fitted(&profile).err();
            }
            Ok(profile) if profile.is_for(vendor, product) => match device.fitted(&profile) {
                Ok(profile) => return Ok((profile, faults)),
                Err(error) => faults.push(error.to_string()),
            },
            Ok(_) => {}
            Err(error) => faults.push(error.to_string()),
        }
    }
    if let Some(error) = missing {
        // Another profile would drive without the pedals that the person named.
        return Err(error);
    }
    if let Some(mut profile) = shipped().find(|profile| profile.is_for(vendor, product)) {
        profile.fits(&device.axes)?;
        scale(&mut profile, &device.axes);
        return Ok((profile, faults));
    }
    if device.values.values().all(|raw| *raw == 0) {
        // The guess would confuse released and floored pedals.
        return Err(ProfileError(format!(
            "{} is not known, and the rest positions of its pedals are not known yet\n  remedy: calibrate it with \
             codrive calibrate",
            device.name
        )));
    }
    let profile = WheelProfile::generic(&device.name, &device.axes, &device.values).map_err(|error| {
        // The reasons why own profiles were refused come first.
        ProfileError([&faults[..], &[error.to_string()]].concat().join("\n"))
    })?;
    let in_the_middle = |raw: &i32, pedal: &Pedal| (0.3..0.7).contains(&pedal.way(*raw));
    let combined = |pedal: &Pedal| device.values.get(&pedal.code()).is_some_and(|raw| in_the_middle(raw, pedal));
    if let Some((name, pedal)) = profile.pedals().find(|(_, pedal)| combined(pedal)) {
        return Err(ProfileError(format!(
            "{} is not known, and axis {}, taken for the {name}, rests in the middle, as pedals that share one axis do\n  \
             remedy: calibrate it with codrive calibrate",
            device.name, pedal.axis
        )));
    }
    faults.push(format!("{} is not known: its first axes are used; codrive calibrate measures them", device.name));
    Ok((profile, faults))
}

/// Adapts a shipped profile to the device's own ranges, for drivers with another resolution.
fn scale(profile: &mut WheelProfile, axes: &AxisRanges) {
    let s = &mut profile.steering;
    if let Some([low, high]) = axes.get(&s.axis).filter(|range| [s.left, s.right] != **range && range[0] < range[1]) {
        (s.left, s.right, s.centre) = (*low, *high, ((i64::from(*low) + i64::from(*high)) / 2) as i32);
    }
    for pedal in [Some(&mut profile.accelerator), profile.brake.as_mut()].into_iter().flatten() {
        if let Some([low, high]) = axes.get(&pedal.axis).filter(|range| range[0] < range[1]) {
            let high_rest = pedal.released > pedal.pressed;
            (pedal.released, pedal.pressed) = if high_rest { (*high, *low) } else { (*low, *high) };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{
        super::kinds::{self, Abilities, DeviceKind},
        *,
    };

    fn g29() -> UnprofiledDevice {
        let axes = [(0, [0, 65_535]), (1, [0, 255]), (2, [0, 255]), (5, [0, 255]), (16, [-1, 1]), (17, [-1, 1])];
        let values = [(0, 32_767), (1, 255), (2, 255), (5, 255)];
        UnprofiledDevice {
            name: "Logitech G29 Driving Force Racing Wheel".into(),
            id: (0x046d, 0xc24f),
            axes: axes.into(),
            values: values.into(),
            ..UnprofiledDevice::default()
        }
    }

    /// Returns the kind of a device with two axes and a button.
    fn kind(vendor: u16, product: u16, name: &str) -> DeviceKind {
        let abilities = Abilities::from_uevent("EV=b\nKEY=100000000 0 0 0 0\nABS=3\n");
        kinds::kind((vendor, product), name, abilities, &[], &shipped().collect::<Vec<_>>())
    }

    #[test]
    fn every_shipped_profile_is_sound() {
        assert_eq!(shipped().count(), SHIPPED.len());
        for (name, text) in SHIPPED {
            let profile = WheelProfile::from_toml(text, name).unwrap();
            assert_eq!(WheelProfile::from_toml(&profile.to_toml(), name).unwrap(), profile);
            assert!(!profile.products.is_empty());
        }
    }

    #[test]
    fn a_g29_is_recognised_and_one_in_ps4_mode_is_reported_as_unfit() {
        let (profile, faults) = choose(&g29(), None).unwrap();
        assert_eq!((profile.name.as_str(), faults.len()), ("Logitech G29", 0));
        assert_eq!(profile.brake.unwrap().axis, 5);
        assert_eq!(kind(0x046d, 0xc24f, "G29"), DeviceKind::Wheel);
        assert!(matches!(kind(0x046d, 0xc260, "Logitech G29"), DeviceKind::Unfit(text) if text.contains("PS3")));
    }

    #[test]
    fn a_pad_is_no_wheel_and_an_unknown_wheel_is() {
        assert_eq!(kind(0x045e, 0x028e, "Xbox 360 Controller"), DeviceKind::Controller);
        assert_eq!(kind(0x1234, 0x5678, "Some Racing Wheel"), DeviceKind::Wheel);
    }

    #[test]
    fn a_guessed_profile_takes_present_pedal_values_as_released() {
        let values = [(0, 512), (1, 3), (2, 1020)].into();
        let axes = [(0, [0, 1023]), (1, [0, 1023]), (2, [0, 1023])].into();
        let name = "Some Racing Wheel".into();
        let device = UnprofiledDevice { name, id: (1, 2), axes, values, ..UnprofiledDevice::default() };
        let (profile, faults) = choose(&device, None).unwrap();
        assert_eq!((profile.accelerator.released, profile.accelerator.pressed), (0, 1023));
        assert_eq!(profile.brake.map(|b| (b.released, b.pressed)), Some((1023, 0)));
        assert!(faults[0].contains("codrive calibrate"));
        let unread = UnprofiledDevice { values: [(0, 0), (1, 0), (2, 0)].into(), ..device.clone() };
        let message = choose(&unread, None).unwrap_err().0;
        assert!(message.contains("codrive calibrate"), "nobody guesses where a pedal rests: {message}");
        let combined = UnprofiledDevice { values: [(0, 512), (1, 500), (2, 1020)].into(), ..device.clone() };
        let message = choose(&combined, None).unwrap_err().0;
        assert!(message.contains("axis 1, taken for the accelerator, rests in the middle"), "{message}");
        let one_axis = UnprofiledDevice { axes: [(0, [0, 1023])].into(), ..device };
        assert!(choose(&one_axis, None).unwrap_err().0.contains("fewer than two axes"));
    }

    #[test]
    fn a_profile_with_a_missing_axis_names_the_axis_and_the_remedy() {
        let mut device = g29();
        device.axes.remove(&5);
        let message = choose(&device, None).unwrap_err().0;
        assert!(message.contains("brake is axis 5") && message.contains("codrive calibrate"), "{message}");
    }

    #[test]
    fn a_driver_with_another_resolution_reaches_the_full_range_too() {
        let mut device = g29();
        device.axes.insert(0, [0, 16_383]);
        device.axes.insert(2, [0, 1023]);
        let (profile, _) = choose(&device, None).unwrap();
        assert_eq!((profile.steering.right, profile.steering.centre), (16_383, 8191));
        assert_eq!((profile.accelerator.released, profile.accelerator.pressed), (1023, 0));
    }

    #[test]
    fn a_pedal_on_a_device_of_its_own_is_found_by_the_devices_id() {
        let mut profile = named("g29").unwrap();
        profile.accelerator =
            Pedal { device: Some("0EB7:183b".into()), axis: 0, released: 0, pressed: 4095, ..profile.accelerator };
        let profile = WheelProfile::from_toml(&profile.to_toml(), "mine").unwrap();
        let message = choose(&g29(), Some(&profile)).unwrap_err().0;
        assert!(message.contains("the device of the accelerator, 0EB7:183b, is not plugged in"), "{message}");
        let folder = tempfile::tempdir().unwrap();
        let own = WheelProfile { products: vec!["046d:c24f".into()], ..profile.clone() };
        std::fs::write(folder.path().join("a.toml"), own.to_toml()).unwrap();
        let refused = choose_from(&profiles_in(folder.path()), &g29(), None).unwrap_err().0;
        assert!(refused.contains("is not plugged in"), "no other profile takes its place: {refused}");
        let mut rig = g29();
        let part = |product, raw| UnprofiledDevice {
            id: (0x0eb7, product),
            axes: [(0, [0, 4095])].into(),
            values: [(0, raw)].into(),
            ..UnprofiledDevice::default()
        };
        [part(0x0001, 7), part(0x183b, 0)].iter().for_each(|part| rig.add(part));
        let (chosen, _) = choose(&rig, Some(&profile)).unwrap();
        assert_eq!((chosen.accelerator.code(), chosen.brake.as_ref().map(Pedal::code)), (2 * PART, Some(5)));
        assert_eq!(WheelProfile::from_toml(&chosen.to_toml(), "again").unwrap(), profile, "the file has evdev's codes");
        assert_eq!(
            (rig.values.get(&PART), rig.values.get(&(2 * PART))),
            (Some(&7), None),
            "the second is not read yet"
        );
        rig.keep_parts_of(&chosen);
        assert!(!rig.axes.contains_key(&PART) && rig.axes.contains_key(&(2 * PART)));
        let bad = profile.to_toml().replace("0EB7:183b", "pedals");
        assert!(
            WheelProfile::from_toml(&bad, "x").unwrap_err().0.contains("accelerator.device: \"pedals\" is no USB id")
        );
    }

    #[test]
    fn an_empty_axis_range_leaves_the_profile_unchanged() {
        let mut device = g29();
        device.axes.insert(0, [0, 0]);
        device.axes.insert(2, [7, 7]);
        let (profile, _) = choose_from(&[], &device, None).unwrap();
        let shipped = named("g29").unwrap();
        assert_eq!((profile.steering, profile.accelerator), (shipped.steering, shipped.accelerator));
    }

    #[test]
    fn an_own_profile_comes_before_a_shipped_one_and_faulty_ones_are_reported() {
        let folder = tempfile::tempdir().unwrap();
        let write = |file: &str, edit: &dyn Fn(&mut WheelProfile)| {
            let mut profile = WheelProfile { name: file.into(), ..named("g29").unwrap() };
            edit(&mut profile);
            std::fs::write(folder.path().join(file), profile.to_toml()).unwrap();
        };
        write("a.toml", &|profile| profile.products = vec!["046d:c29b".into()]);
        write("b.toml", &|profile| profile.accelerator.axis = 9);
        std::fs::write(folder.path().join("c.toml"), "name = 3").unwrap();
        write("notes.txt", &|_| ());
        let chosen = || choose_from(&profiles_in(folder.path()), &g29(), None).unwrap();
        let (profile, faults) = chosen();
        assert_eq!(profile.name, "Logitech G29", "none of them is for it and fits");
        assert_eq!(faults.len(), 2, "{faults:?}");
        assert!(faults[0].contains("accelerator is axis 9") && faults[1].contains("c.toml:1:8"), "{faults:?}");
        write("d.toml", &|_| ());
        write("e.toml", &|_| ());
        let (profile, faults) = chosen();
        assert_eq!((profile.name.as_str(), faults.len()), ("d.toml", 2));
        let asked = WheelProfile { name: "asked".into(), ..named("g29").unwrap() };
        let (profile, faults) = choose_from(&profiles_in(folder.path()), &g29(), Some(&asked)).unwrap();
        assert_eq!((profile.name.as_str(), faults.len()), ("asked", 0), "the one that was named comes first");
        let other = WheelProfile { products: vec!["346e:0004".into()], ..asked };
        let (profile, faults) = choose_from(&[], &g29(), Some(&other)).unwrap();
        assert_eq!(profile.name, "asked");
        assert!(
            faults[0].contains("profile \"asked\" is for 346e:0004") && faults[0].contains("is 046d:c24f"),
            "{faults:?}"
        );
        assert!(profiles_in(&folder.path().join("nothing")).is_empty());
    }

    #[test]
    fn own_profiles_are_in_the_systems_settings_folder() {
        let folder = |set: &[(&str, &str)]| {
            own_folder_by(|name| set.iter().find(|(known, _)| *known == name).map(|(_, value)| value.into()))
        };
        let lies = |path: &str| Some(PathBuf::from(path));
        let home = ("HOME", "/home/a");
        assert_eq!(folder(&[home]), lies("/home/a/.config/codrive/wheels"));
        assert_eq!(
            folder(&[home, ("XDG_CONFIG_HOME", "")]),
            lies("/home/a/.config/codrive/wheels"),
            "empty is not set"
        );
        assert_eq!(folder(&[home, ("XDG_CONFIG_HOME", "/set")]), lies("/set/codrive/wheels"));
        assert_eq!(folder(&[home, ("APPDATA", "/data")]), lies("/data/codrive/wheels"));
        assert_eq!((folder(&[]), folder(&[("HOME", "")])), (None, None));
    }

    #[test]
    fn a_name_becomes_the_name_of_a_file() {
        assert_eq!(file_name("Rig 1 / left, G29"), "rig-1-left-g29");
        assert_eq!(file_name("../.."), "wheel");
    }
}
