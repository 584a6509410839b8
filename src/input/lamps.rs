//! LEDs of the kernel's LED class: the rev lamps on a wheel's rim, which the mainline driver (hid-lg4ff) exposes as LED
//! devices `...::RPM1` to `...::RPM5`, or another LED that a person names. In: the speed relative to the advice, or a
//! signal of the detection response task. Out: bytes to `brightness` files, only when they change. The lamps are dark
//! at the end.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// udev rule that lets every user of the computer set the lamps.
pub const UDEV_RULE: &str = r#"SUBSYSTEM=="leds", KERNEL=="*::RPM*", RUN+="/bin/chmod 0666 /sys%p/brightness""#;

/// Speed relative to the advised range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdviceState {
    None,
    /// Slower than the range.
    Below,
    /// Within the range, ends included.
    Within,
    /// Faster than the range.
    Above,
}

impl AdviceState {
    /// Returns the number of lit lamps out of `lamps`: none without advice, one below, the lower half and the middle
    /// within, all above.
    pub fn lit(self, lamps: usize) -> usize {
        match self {
            Self::None => 0,
            Self::Below => 1.min(lamps),
            Self::Within => lamps.div_ceil(2),
            Self::Above => lamps,
        }
    }
}

/// Rev lamps of one wheel, which may have none; or one other LED.
#[derive(Debug, Default)]
pub struct Lamps {
    lamps: Vec<Lamp>,
    shown: Option<usize>,
}

/// LED device with its file.
#[derive(Debug)]
struct Lamp {
    file: PathBuf,
    /// Text that sets its full brightness.
    full: String,
}

impl Lamp {
    /// Returns the LED of a folder of the kernel's LED class. Without a stated maximum its full brightness is 1.
    fn in_folder(folder: &Path) -> Self {
        let most = fs::read_to_string(folder.join("max_brightness"));
        let most = most.ok().and_then(|text| text.trim().parse::<u32>().ok());
        Self { file: folder.join("brightness"), full: most.unwrap_or(1).to_string() }
    }
}

impl Lamps {
    /// Finds the lamps of the event device `event` ("event7") in the folder `sys`, which is `/sys` except in tests.
    pub fn find(sys: &Path, event: &str) -> Self {
        // eventN/device is the input device, and its device the HID device that the lamps belong to.
        let folder = sys.join("class/input").join(event).join("device/device/leds");
        let mut lamps: Vec<(u32, Lamp)> = fs::read_dir(folder)
            .into_iter()
            .flatten()
            .flatten()
            .filter_map(|entry| {
                let name = entry.file_name().into_string().ok()?;
                let number = name.rsplit_once("::RPM")?.1.parse().ok()?;
                Some((number, Lamp::in_folder(&entry.path())))
            })
            .collect();
        lamps.sort_by_key(|(number, _)| *number);
        Self { lamps: lamps.into_iter().map(|(_, lamp)| lamp).collect(), shown: None }
    }

    /// Returns the LED of this folder, such as `/sys/class/leds/NAME`.
    pub fn at(folder: &Path) -> Self {
        Self { lamps: vec![Lamp::in_folder(folder)], shown: None }
    }

    /// Returns the number of lamps.
    pub fn count(&self) -> usize {
        self.lamps.len()
    }

    /// Lights the lamps for this state; writes only when the number of lit lamps changes.
    ///
    /// # Errors
    /// A file cannot be written; the message names it.
    pub fn show(&mut self, advice_state: AdviceState) -> io::Result<()> {
        self.light(advice_state.lit(self.lamps.len()))
    }

    /// Lights all lamps or none, as the signal of the detection response task; writes only when that changes.
    ///
    /// # Errors
    /// A file cannot be written; the message names it.
    pub fn signal(&mut self, is_on: bool) -> io::Result<()> {
        self.light(if is_on { self.lamps.len() } else { 0 })
    }

    /// Lights this number of lamps.
    fn light(&mut self, lit: usize) -> io::Result<()> {
        if self.shown == Some(lit) {
            return Ok(());
        }
        self.shown = Some(lit);
        for (i, Lamp { file, full }) in self.lamps.iter().enumerate() {
            let named = |e: io::Error| io::Error::new(e.kind(), format!("{}: {e}", file.display()));
            // Opened without `create`: a lamp that was unplugged with its wheel must not become a file.
            let mut open = fs::OpenOptions::new().write(true).truncate(true).open(file).map_err(named)?;
            io::Write::write_all(&mut open, if i < lit { full.as_bytes() } else { b"0" }).map_err(named)?;
        }
        Ok(())
    }
}

impl Drop for Lamps {
    fn drop(&mut self) {
        if self.shown.is_some_and(|lit| lit > 0) {
            let _ = self.light(0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Makes a folder in place of /sys: a wheel with lamps at event7 and one without lamps at event8.
    fn sys() -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for lamp in ["RPM3", "RPM1", "RPM5", "RPM2", "RPM4"] {
            let leds = folder.path().join(format!("class/input/event7/device/device/leds/0003:046D:C24F.0001::{lamp}"));
            fs::create_dir_all(&leds).unwrap();
            fs::write(leds.join("brightness"), "0\n").unwrap();
        }
        fs::create_dir_all(folder.path().join("class/input/event8/device/device")).unwrap();
        folder
    }

    fn lit(sys: &Path) -> String {
        let at = |n| sys.join(format!("class/input/event7/device/device/leds/0003:046D:C24F.0001::RPM{n}/brightness"));
        (1..=5).map(|n| fs::read_to_string(at(n)).unwrap().trim().to_owned()).collect()
    }

    #[test]
    fn lamps_show_the_advice_state_and_are_dark_without_advice_and_at_the_end() {
        let folder = sys();
        let mut lamps = Lamps::find(folder.path(), "event7");
        assert_eq!(lamps.count(), 5);
        for (advice_state, shown) in [
            (AdviceState::Below, "10000"),
            (AdviceState::Within, "11100"),
            (AdviceState::Above, "11111"),
            (AdviceState::None, "00000"),
            (AdviceState::Above, "11111"),
        ] {
            lamps.show(advice_state).unwrap();
            assert_eq!(lit(folder.path()), shown, "{advice_state:?}");
        }
        drop(lamps);
        assert_eq!(lit(folder.path()), "00000");
    }

    #[test]
    fn an_unchanged_state_is_not_rewritten_and_a_missing_lamp_is_an_error() {
        let folder = sys();
        let mut lamps = Lamps::find(folder.path(), "event7");
        lamps.show(AdviceState::Within).unwrap();
        let first = folder.path().join("class/input/event7/device/device/leds/0003:046D:C24F.0001::RPM1/brightness");
        fs::remove_file(&first).unwrap();
        lamps.show(AdviceState::Within).unwrap();
        let error = lamps.show(AdviceState::Below).unwrap_err().to_string();
        assert!(error.contains("RPM1/brightness"), "{error}");
        assert!(!first.exists(), "no file is made in its place");
    }

    #[test]
    fn a_signal_lights_all_rev_lamps_or_another_led_with_its_full_brightness() {
        let folder = sys();
        let mut lamps = Lamps::find(folder.path(), "event7");
        for (is_on, shown) in [(true, "11111"), (false, "00000"), (true, "11111")] {
            lamps.signal(is_on).unwrap();
            assert_eq!(lit(folder.path()), shown);
        }
        drop(lamps);
        assert_eq!(lit(folder.path()), "00000", "dark at the end");
        let led = folder.path().join("class/leds/goose-neck");
        fs::create_dir_all(&led).unwrap();
        fs::write(led.join("brightness"), "0\n").unwrap();
        fs::write(led.join("max_brightness"), "255\n").unwrap();
        let mut lamps = Lamps::at(&led);
        for (is_on, shown) in [(true, "255"), (false, "0")] {
            lamps.signal(is_on).unwrap();
            assert_eq!(fs::read_to_string(led.join("brightness")).unwrap(), shown);
        }
        assert!(Lamps::at(&folder.path().join("nowhere")).signal(true).is_err());
    }

    #[test]
    fn a_wheel_without_lamps_has_none() {
        let mut lamps = Lamps::find(sys().path(), "event8");
        assert_eq!(lamps.count(), 0);
        lamps.show(AdviceState::Above).unwrap();
        assert_eq!(Lamps::find(Path::new("/nowhere"), "event0").count(), 0);
    }
}
