//! What was driven, where and by which program: all that another lab needs to judge a recording or to make it again. In:
//! facts of the loop. Out: `manifest.json`.

use super::{RecordError, checksums::file_sha256, files};
use crate::{file, sim::HandOver};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use sha2::{Digest, Sha256};
use std::path::Path;

/// Name of its file.
pub const FILE: &str = "manifest.json";

/// All about one recording. Unknown keys are kept out: a later program says its own version.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Name and version of the program.
    pub program: String,
    /// How it was built: release or dev.
    pub build: String,
    /// Traffic engine and its version.
    pub traffic: String,
    /// Seed of everything random.
    pub seed: u64,
    /// The map and the fingerprint of its network file.
    pub map: NamedHash,
    /// The policy and, for one from a file, its fingerprint.
    pub policy: NamedHash,
    /// Why it is that policy, where another name was asked for (`auto`).
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub policy_asked: Option<String>,
    /// Lateral acceleration that bounds the other cars' speed in bends, m/s2; `None` where nothing does.
    #[serde(skip_serializing_if = "Option::is_none", default, alias = "bend_mps2")]
    pub lateral_accel_mps2: Option<f64>,
    /// How traffic was when the driver took over; `None` in a recording of an earlier version.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub hand_over: Option<HandOver>,
    /// The recording has the tables of a drive on a network; false in one of a closed route, and of an earlier version.
    #[serde(skip_serializing_if = "std::ops::Not::not", default)]
    pub network_tables: bool,
    /// The recording has the table of vehicles that are advised beside the ego; false where the ego alone is, and in one of an earlier
    /// version.
    #[serde(skip_serializing_if = "std::ops::Not::not", default)]
    pub advised_table: bool,
    /// Who drove: devices, or the name of a simulated driver.
    pub driver: String,
    /// Participant code, in a study; never a name.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub participant: Option<String>,
    /// When it began, UTC.
    pub began: String,
    /// Operating system, processor, cores.
    pub machine: String,
    /// Graphics adapter and driver; `None` without a picture.
    pub graphics: Option<String>,
    /// Width of the visible picture and distance of the eyes from it, metres.
    pub display_m: [f64; 2],
    /// The screen and how pictures come to it; `None` without a window.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub screen: Option<ScreenInfo>,
    /// Full scale of the speedometer, in the unit that it shows; `None` in a recording of an earlier version.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub dial: Option<DialScale>,
    /// How far it is; `None` in a recording of an earlier version.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub state: Option<RecordingState>,
    /// How it ended; `None` while it lasts, and after a cut.
    pub ended: Option<String>,
    /// Fingerprint of all snapshots, at the end.
    pub hash: Option<String>,
    /// SHA-256 of `checksums.json`, once all files are written.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub checksums: Option<String>,
    /// SHA-256 of this manifest without this line, once it is written for the last time.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub sha256: Option<String>,
}

/// How far a recording is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RecordingState {
    /// The drive lasts, or was cut: rows are in the journal.
    Running,
    /// The drive ended by itself: all tables are whole.
    Complete,
    /// The drive was cut: the tables hold what could be saved.
    Recovered,
}

/// What the speedometer reaches to.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DialScale {
    /// Full scale.
    pub full: f64,
    /// Its unit: mph or km/h.
    pub unit: String,
}

/// A screen and how pictures come to it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ScreenInfo {
    /// Name of the monitor, as the system tells.
    pub monitor: Option<String>,
    /// Its refresh rate, Hz.
    pub refresh_hz: Option<f64>,
    /// Size of the picture, pixels.
    pub size: [u32; 2],
    /// How pictures are handed over: fifo waits for the screen and never tears.
    pub present_mode: String,
    /// Pictures that may wait for the screen, at most.
    pub frames_ahead: u32,
}

/// A name and the SHA-256 of what it stands for.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct NamedHash {
    /// Its name.
    pub name: String,
    /// SHA-256 of its file, hexadecimal; `None` if it has none.
    pub sha256: Option<String>,
}

impl NamedHash {
    /// A name and its file, if there is one that can be read.
    pub fn of(name: &str, file: Option<&Path>) -> Self {
        Self { name: name.into(), sha256: file.and_then(|file| file_sha256(file).ok()) }
    }
}

impl NamedHash {
    /// A name and the text that it stands for.
    pub fn of_text(name: &str, text: &str) -> Self {
        Self { name: name.into(), sha256: Some(sha256(text.as_bytes())) }
    }
}

/// SHA-256, hexadecimal.
pub(super) fn sha256(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

pub(super) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

impl Manifest {
    /// Reads that of a recording.
    ///
    /// # Errors
    /// There is none, or it cannot be read.
    pub fn load(recording: &Path) -> Result<Self, RecordError> {
        let path = recording.join(FILE);
        if !path.exists() {
            return Err(RecordError::Absent(recording.into()));
        }
        let text = file::read_text(&path, file::SETTINGS_BYTES).map_err(RecordError::file(&path))?;
        serde_json::from_str(&text).map_err(|e| RecordError::Table { path, why: e.to_string() })
    }

    /// True once all tables are written.
    pub fn is_complete(&self) -> bool {
        match self.state {
            Some(state) => state != RecordingState::Running,
            // Earlier versions wrote the end when the tables were whole.
            None => self.ended.is_some(),
        }
    }

    /// False if somebody has changed that of a recording since it was written for the last time; `None` if its own SHA-256 was
    /// never noted, as by an earlier version.
    ///
    /// # Errors
    /// It cannot be read.
    pub fn is_as_written(recording: &Path) -> Result<Option<bool>, RecordError> {
        let path = recording.join(FILE);
        let text = file::read_text(&path, file::SETTINGS_BYTES).map_err(RecordError::file(&path))?;
        // Of the text and not of what this version understands of it: an added line is a change, too.
        let read = serde_json::from_str(&text);
        let mut lines: Map<String, Value> = read.map_err(|e| RecordError::Table { path, why: e.to_string() })?;
        let written = lines.shift_remove("sha256");
        let text = serde_json::to_string_pretty(&lines).expect("numbers and words") + "\n";
        Ok(written.map(|written| written == sha256(text.as_bytes()).as_str()))
    }

    fn text(&self) -> String {
        serde_json::to_string_pretty(self).expect("numbers and words") + "\n"
    }

    pub(super) fn save(&self, recording: &Path) -> Result<(), RecordError> {
        files::replace(&recording.join(FILE), self.text().as_bytes())
    }

    /// Saves it for the last time.
    pub(super) fn seal(&mut self, recording: &Path) -> Result<(), RecordError> {
        self.sha256 = None;
        self.sha256 = Some(sha256(self.text().as_bytes()));
        self.save(recording)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recording_is_complete_when_its_state_says_so_and_an_old_one_when_it_says_how_it_ended() {
        let is = |state: Option<RecordingState>, ended: Option<&str>| {
            Manifest { state, ended: ended.map(str::to_owned), ..Manifest::default() }.is_complete()
        };
        assert!(
            is(Some(RecordingState::Complete), None)
                && is(Some(RecordingState::Recovered), None)
                && is(None, Some("stopped"))
        );
        assert!(
            !is(Some(RecordingState::Running), None)
                && !is(Some(RecordingState::Running), Some("stopped"))
                && !is(None, None)
        );
    }

    #[test]
    fn a_sealed_manifest_is_as_written_until_any_line_of_it_changes() {
        let folder = tempfile::tempdir().expect("a folder");
        let as_written = || Manifest::is_as_written(folder.path()).expect("readable");
        assert!(matches!(Manifest::load(folder.path()), Err(RecordError::Absent(_))));
        let mut manifest = Manifest { driver: "keyboard".into(), ..Manifest::default() };
        manifest.save(folder.path()).expect("room");
        assert_eq!((as_written(), Manifest::load(folder.path()).expect("there")), (None, manifest.clone()));
        manifest.seal(folder.path()).expect("room");
        assert_eq!(as_written(), Some(true));
        // Sealed twice, it does not count the seal before.
        manifest.seal(folder.path()).expect("room");
        assert_eq!((as_written(), Manifest::load(folder.path()).expect("there")), (Some(true), manifest));
        let path = folder.path().join(FILE);
        let text = std::fs::read_to_string(&path).expect("there");
        for (from, to) in
            [("\"keyboard\"", "\"wheel\""), ("\"seed\": 0", "\"seed\": 1"), ("{\n", "{\n  \"note\": 1,\n")]
        {
            assert!(text.contains(from), "{text}");
            std::fs::write(&path, text.replacen(from, to, 1)).expect("written");
            assert_eq!(as_written(), Some(false), "{to}");
        }
    }

    #[test]
    fn a_name_has_the_sum_of_its_file_where_there_is_one() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("x");
        std::fs::write(&path, "abc").expect("written");
        // FIPS 180-2, appendix B.1.
        let sum = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(NamedHash::of("x", Some(&path)), NamedHash { name: "x".into(), sha256: Some(sum.into()) });
        assert_eq!(sha256(b"abc"), sum);
        for none in [None, Some(folder.path().join("gone"))] {
            assert_eq!(NamedHash::of("x", none.as_deref()).sha256, None);
        }
        assert_eq!(hex(&[0x0f, 0xa0, 0]), "0fa000");
    }
}
