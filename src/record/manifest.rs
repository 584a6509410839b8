//! Manifest of a recording: facts that another lab needs to judge or reproduce it. In: facts of the drive loop. Out:
//! `manifest.json`.

use super::{
    RecordError, files,
    sha256::{file_sha256, sha256},
};
use crate::{file, sim::HandOver};
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::path::Path;

/// File name of the manifest.
pub const FILE: &str = "manifest.json";

/// Format of the recordings that this version writes and reads. The format defines the seals, tables, columns and files of a
/// recording: a missing one was removed.
pub const FORMAT: u32 = 1;

/// Keys of the file, in order, and whether each is required.
pub(super) const KEYS: [(&str, bool); 25] = [
    ("format", true),
    ("program", true),
    ("build", true),
    ("traffic", true),
    ("seed", true),
    ("map", true),
    ("policy", true),
    ("policy_asked", false),
    ("lateral_accel_mps2", false),
    ("hand_over", true),
    ("network_tables", false),
    ("advised_table", false),
    ("driver", true),
    ("participant", false),
    ("began", true),
    ("machine", true),
    ("graphics", true),
    ("display_m", true),
    ("screen", false),
    ("dial", true),
    ("state", true),
    ("ended", true),
    ("hash", true),
    ("checksums", true),
    ("sha256", true),
];

/// Number of a recording format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct RecordingFormat(pub u32);

impl Default for RecordingFormat {
    fn default() -> Self {
        Self(FORMAT)
    }
}

/// Facts about one recording.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Format of the recording.
    pub format: RecordingFormat,
    /// Name and version of the program.
    pub program: String,
    /// Kind of build: release or dev.
    pub build: String,
    /// Traffic engine and its version.
    pub traffic: String,
    /// Seed of everything random.
    pub seed: u64,
    /// Map, and the SHA-256 of its network file.
    pub map: NamedHash,
    /// Policy, and the SHA-256 of its file if it has one.
    pub policy: NamedHash,
    /// Reason for this policy if another name was asked for (`auto`).
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub policy_asked: Option<String>,
    /// Lateral acceleration that limits the other vehicles' speed in bends, m/s2; `None` without a limit.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub lateral_accel_mps2: Option<f64>,
    /// State of the traffic when the driver took over.
    pub hand_over: HandOver,
    /// True if the recording has the tables of a network. Follows from the scenario, and is compared with it.
    #[serde(skip_serializing_if = "std::ops::Not::not", default)]
    pub network_tables: bool,
    /// True if the recording has the table of other advised vehicles. Follows from the drive, and is compared with it.
    #[serde(skip_serializing_if = "std::ops::Not::not", default)]
    pub advised_table: bool,
    /// Input devices, or the name of the simulated driver.
    pub driver: String,
    /// Participant code in a study; never a name.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub participant: Option<String>,
    /// Start of the recording, UTC.
    pub began: String,
    /// Operating system, processor and cores.
    pub machine: String,
    /// Graphics adapter and driver; `None` without a picture.
    pub graphics: Option<String>,
    /// Width of the visible picture, and distance of the eyes from it, metres.
    pub display_m: [f64; 2],
    /// Screen and presentation of frames; `None` without a window.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub screen: Option<ScreenInfo>,
    /// Full scale of the speedometer, in its displayed unit.
    pub dial: DialScale,
    /// State of the recording.
    pub state: RecordingState,
    /// Reason for the end; `None` while the drive lasts, and after a cut.
    pub ended: Option<String>,
    /// Hash chain over all snapshots, at the end.
    pub hash: Option<String>,
    /// SHA-256 of `checksums.json`, once all files are written.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub checksums: Option<String>,
    /// SHA-256 of this manifest without this line, once it is written for the last time.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub sha256: Option<String>,
}

/// State of a recording.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RecordingState {
    /// Drive in progress, or cut: the rows are in the journal.
    #[default]
    Running,
    /// Drive ended by itself: all tables are whole.
    Complete,
    /// Drive cut: the tables hold the rows that could be saved.
    Recovered,
}

/// Full scale of the speedometer and its unit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DialScale {
    /// Full scale, in `unit`.
    pub full: f64,
    /// Unit, mph or km/h.
    pub unit: String,
}

/// Screen and presentation of frames.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ScreenInfo {
    /// Name of the monitor, as the system reports it.
    pub monitor: Option<String>,
    /// Refresh rate of the monitor, Hz.
    pub refresh_hz: Option<f64>,
    /// Size of the picture, pixels.
    pub size: [u32; 2],
    /// Presentation mode; fifo waits for the screen and never tears.
    pub present_mode: String,
    /// Maximum number of frames that wait for the screen.
    pub frames_ahead: u32,
}

/// Name and the SHA-256 of its file or text.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct NamedHash {
    pub name: String,
    /// SHA-256, hexadecimal; `None` without a readable file.
    pub sha256: Option<String>,
}

impl NamedHash {
    /// Returns a name with the SHA-256 of its file, if the file can be read.
    pub fn of(name: &str, file: Option<&Path>) -> Self {
        Self { name: name.into(), sha256: file.and_then(|file| file_sha256(file).ok()) }
    }
}

impl NamedHash {
    /// Returns a name with the SHA-256 of its text.
    pub fn of_text(name: &str, text: &str) -> Self {
        Self { name: name.into(), sha256: Some(sha256(text.as_bytes())) }
    }
}

impl Manifest {
    /// Reads the manifest of a recording.
    ///
    /// # Errors
    /// The manifest is missing, cannot be read or has another format.
    pub fn load(recording: &Path) -> Result<Self, RecordError> {
        let path = recording.join(FILE);
        if !files::is_there(&path)? {
            return Err(RecordError::Absent(recording.into()));
        }
        let keys = Self::keys(recording)?;
        let fault = |why: String| RecordError::Table { path: path.clone(), why };
        match keys.get("format") {
            Some(format) if *format == FORMAT => {}
            Some(format) => {
                let program = keys.get("program").and_then(Value::as_str).unwrap_or("another version");
                return Err(fault(format!(
                    "the recording has format {format} and was written by {program}; this is {} and reads format {FORMAT}\n  remedy: use \
                     the program that wrote it",
                    concat!("codrive ", env!("CARGO_PKG_VERSION"))
                )));
            }
            None => return Err(fault(format!("the key \"format\" is missing; every recording has it (now {FORMAT})"))),
        }
        serde_json::from_value(Value::Object(keys)).map_err(|e| fault(e.to_string()))
    }

    /// Returns all keys and values of the file, in order, including unknown keys.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn keys(recording: &Path) -> Result<Map<String, Value>, RecordError> {
        let path = recording.join(FILE);
        let text = file::read_text(&path, file::SETTINGS_BYTES).map_err(RecordError::file(&path))?;
        serde_json::from_str(&text).map_err(|e| RecordError::Table { path, why: e.to_string() })
    }

    /// Checks whether all tables are written.
    pub fn is_complete(&self) -> bool {
        self.state != RecordingState::Running
    }

    /// Returns the faults in the manifest of a finished recording: a wrong SHA-256, missing keys and unknown keys.
    ///
    /// # Errors
    /// The file cannot be read.
    pub(super) fn faults(recording: &Path) -> Result<Vec<String>, RecordError> {
        let mut keys = Self::keys(recording)?;
        let mut faults = Vec::new();
        for (key, _) in KEYS.iter().filter(|(key, must)| *must && !keys.contains_key(*key)) {
            faults.push(format!("{key} is missing"));
        }
        for key in keys.keys().filter(|key| !KEYS.iter().any(|(known, _)| known == key)) {
            faults.push(format!("{key} is not a key of format {FORMAT}"));
        }
        // The SHA-256 covers the text, not the parsed manifest: an added line is a change, too.
        let written = keys.shift_remove("sha256");
        let text = serde_json::to_string_pretty(&keys).expect("numbers and words") + "\n";
        if written.is_some_and(|written| written != sha256(text.as_bytes()).as_str()) {
            faults.push("is not as it was written: its own SHA-256 differs".into());
        }
        Ok(faults)
    }

    fn text(&self) -> String {
        serde_json::to_string_pretty(self).expect("numbers and words") + "\n"
    }

    pub(super) fn save(&self, recording: &Path) -> Result<(), RecordError> {
        files::replace(&recording.join(FILE), self.text().as_bytes())
    }

    /// Saves the manifest for the last time, with its SHA-256.
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
    fn a_recording_is_complete_by_its_state() {
        let is = |state| Manifest { state, ended: Some("stopped".into()), ..Manifest::default() }.is_complete();
        assert!(is(RecordingState::Complete) && is(RecordingState::Recovered) && !is(RecordingState::Running));
    }

    #[test]
    fn a_sealed_manifest_is_intact_until_any_line_changes() {
        let folder = tempfile::tempdir().expect("a folder");
        let faults = || Manifest::faults(folder.path()).expect("readable");
        assert!(matches!(Manifest::load(folder.path()), Err(RecordError::Absent(_))));
        let mut manifest = Manifest { driver: "keyboard".into(), ..Manifest::default() };
        manifest.save(folder.path()).expect("room");
        assert_eq!(Manifest::load(folder.path()).expect("there"), manifest);
        assert_eq!(faults(), ["checksums is missing", "sha256 is missing"]);
        manifest.checksums = Some(String::new());
        manifest.seal(folder.path()).expect("room");
        assert_eq!(faults(), [""; 0]);
        // A second seal ignores the first one.
        manifest.seal(folder.path()).expect("room");
        assert_eq!((faults(), Manifest::load(folder.path()).expect("there")), (Vec::new(), manifest));
        let path = folder.path().join(FILE);
        let text = std::fs::read_to_string(&path).expect("there");
        let differs = "is not as it was written: its own SHA-256 differs";
        for (from, to, more) in [
            ("\"keyboard\"", "\"wheel\"", None),
            ("\"seed\": 0", "\"seed\": 1", None),
            ("{\n", "{\n  \"note\": 1,\n", Some("note is not a key of format 1")),
            ("  \"graphics\": null,\n", "", Some("graphics is missing")),
        ] {
            assert!(text.contains(from), "{text}");
            std::fs::write(&path, text.replacen(from, to, 1)).expect("written");
            assert_eq!(faults(), more.into_iter().chain([differs]).collect::<Vec<_>>(), "{to}");
        }
    }

    #[test]
    fn every_key_that_a_manifest_can_have_is_known_and_in_order() {
        let whole = Manifest {
            policy_asked: Some(String::new()),
            lateral_accel_mps2: Some(3.0),
            network_tables: true,
            advised_table: true,
            participant: Some(String::new()),
            screen: Some(ScreenInfo::default()),
            checksums: Some(String::new()),
            sha256: Some(String::new()),
            ..Manifest::default()
        };
        let keys = |manifest: &Manifest| -> Vec<String> {
            let value = serde_json::to_value(manifest).expect("numbers and words");
            value.as_object().expect("keys").keys().cloned().collect()
        };
        assert_eq!(keys(&whole), KEYS.map(|(key, _)| key));
        let least = Manifest { checksums: whole.checksums, sha256: whole.sha256, ..Manifest::default() };
        let must: Vec<&str> = KEYS.iter().filter(|(_, must)| *must).map(|(key, _)| *key).collect();
        assert_eq!(keys(&least), must);
    }

    #[test]
    fn a_recording_of_another_format_is_refused_with_its_program_version() {
        let folder = tempfile::tempdir().expect("a folder");
        let refused = |text: &str| {
            std::fs::write(folder.path().join(FILE), text).expect("written");
            Manifest::load(folder.path()).expect_err("another format").to_string()
        };
        let later = refused("{\"program\": \"codrive 9.1.0\", \"format\": 2, \"more\": []}");
        assert!(
            later.contains("has format 2 and was written by codrive 9.1.0") && later.contains("reads format 1"),
            "{later}"
        );
        let none = refused("{\"program\": \"codrive 0.0.9\"}");
        assert!(none.contains("the key \"format\" is missing"), "{none}");
    }

    #[test]
    fn a_name_has_the_sha256_of_its_file_if_it_has_one() {
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
    }
}
