//! Rev lamps on a wheel's rim, which the mainline driver (hid-lg4ff) shows as LED devices `...::RPM1` to `...::RPM5`. In:
//! how the speed stands to the advice. Out: bytes to `brightness` files, only when they change, and dark at the end.

use std::{
    fs, io,
    path::{Path, PathBuf},
};

/// The rule that lets everybody at the rig light them.
pub const UDEV_RULE: &str = r#"SUBSYSTEM=="leds", KERNEL=="*::RPM*", RUN+="/bin/chmod 0666 /sys%p/brightness""#;

/// How the speed stands to the advised range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdviceState {
    /// There is no advice.
    None,
    /// Too slow.
    Below,
    /// In the range.
    Within,
    /// Too fast.
    Above,
}

impl AdviceState {
    /// How many of so many lamps are lit: none, the first, the lower half with the middle, all.
    pub fn lit(self, lamps: usize) -> usize {
        match self {
            Self::None => 0,
            Self::Below => 1.min(lamps),
            Self::Within => lamps.div_ceil(2),
            Self::Above => lamps,
        }
    }
}

/// The lamps of one wheel, which may have none.
#[derive(Debug, Default)]
pub struct Lamps {
    files: Vec<PathBuf>,
    shown: Option<usize>,
}

impl Lamps {
    /// Those of the event device `event` ("event7"), below the folder `sys`, which is `/sys`.
    pub fn find(sys: &Path, event: &str) -> Self {
        // eventN/device is the input device, and its device the HID device that the lamps belong to.
        let folder = sys.join("class/input").join(event).join("device/device/leds");
        let mut lamps: Vec<(u32, PathBuf)> = fs::read_dir(folder)
            .into_iter()
            .flatten()
            .flatten()
            .filter_map(|entry| {
                let name = entry.file_name().into_string().ok()?;
                let number = name.rsplit_once("::RPM")?.1.parse().ok()?;
                Some((number, entry.path().join("brightness")))
            })
            .collect();
        lamps.sort();
        Self { files: lamps.into_iter().map(|(_, file)| file).collect(), shown: None }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.files.len()
    }

    /// Shows it. Nothing is written that stands there already.
    ///
    /// # Errors
    /// The system refuses; which file.
    pub fn show(&mut self, advice_state: AdviceState) -> io::Result<()> {
        let lit = advice_state.lit(self.files.len());
        if self.shown == Some(lit) {
            return Ok(());
        }
        self.shown = Some(lit);
        for (i, file) in self.files.iter().enumerate() {
            let was_told = |e: io::Error| io::Error::new(e.kind(), format!("{}: {e}", file.display()));
            // Written into what is there: a lamp that went with its wheel must not become a file.
            let mut open = fs::OpenOptions::new().write(true).truncate(true).open(file).map_err(was_told)?;
            io::Write::write_all(&mut open, if i < lit { b"1" } else { b"0" }).map_err(was_told)?;
        }
        Ok(())
    }
}

impl Drop for Lamps {
    fn drop(&mut self) {
        if self.shown.is_some_and(|lit| lit > 0) {
            let _ = self.show(AdviceState::None);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder that stands for /sys, with a wheel that has lamps at event7 and one without at event8.
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
    fn the_lamps_tell_below_within_and_above_and_are_dark_without_advice_and_at_the_end() {
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
    fn what_stands_there_is_not_written_again_and_a_lamp_that_is_gone_is_told() {
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
    fn a_wheel_without_lamps_has_none() {
        let mut lamps = Lamps::find(sys().path(), "event8");
        assert_eq!(lamps.count(), 0);
        lamps.show(AdviceState::Above).unwrap();
        assert_eq!(Lamps::find(Path::new("/nowhere"), "event0").count(), 0);
    }
}
