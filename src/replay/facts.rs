//! Facts of a recording that follow from its drive. In: `manifest.json`, `summary.json` and the world driven again. Out: every
//! value that the drive does not give again, found by the functions that wrote it; and the values that no drive can prove.

use super::Evidence;
use crate::{
    controls::Controls,
    drive_loop::{RunError, offline, recording_manifest},
    driver,
    driver::SimulatedDriver,
    file::{SETTINGS_BYTES, read_text},
    record::{
        Manifest, RecordError, is_there,
        manifest::{self, RecordingState},
    },
    sim::{SummaryAccumulator, World},
};
use serde_json::{Map, Value};
use std::{collections::BTreeSet, fmt, path::Path};

/// Keys of `manifest.json` that no drive can prove: people, machines and times.
pub const STATED: [&str; 8] =
    ["program", "build", "policy_asked", "participant", "began", "machine", "graphics", "screen"];
/// Keys of seals, and the key of the format, which is checked when the file is read.
const SEALS: [&str; 3] = ["format", "checksums", "sha256"];
/// Prefix of the name of a simulated driver.
const SIMULATED: &str = "simulated: ";
/// File name of the summary.
pub(super) const SUMMARY: &str = "summary.json";

/// Value that the same drive does not give again.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FactDifference {
    /// Name of the file.
    pub file: &'static str,
    /// Key of the value.
    pub key: String,
    /// Value in the recording.
    pub recorded: String,
    /// Value of the drive driven again.
    pub driven: String,
}

impl fmt::Display for FactDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, key, recorded, driven } = self;
        write!(f, "{file}: {key} is {recorded}, driven again {driven}")
    }
}

/// Recorded facts of a drive, and the results of driving it again so far.
pub(super) struct DriveFacts {
    recorded: Manifest,
    keys: Map<String, Value>,
    /// Manifest that the same world writes.
    expected: Manifest,
    /// Text of the summary; `None` if there is none.
    summary_text: Option<String>,
    summary: SummaryAccumulator,
    /// Simulated driver of the recording, and the first tick at which it would have given other controls. `None` unless the
    /// recording names the scenario's driver and there is a participant.
    driver: Option<SimulatedDriver>,
    other_driver: Option<u64>,
}

impl DriveFacts {
    /// Reads the facts of a recording, before the first tick of its world.
    pub fn open(recording: &Path, world: &World) -> Result<Self, RunError> {
        let path = recording.join(SUMMARY);
        let read =
            |path: &Path| read_text(path, SETTINGS_BYTES).map_err(|why| RecordError::File { path: path.into(), why });
        let summary_text = is_there(&path)?.then(|| read(&path)).transpose()?;
        let recorded = Manifest::load(recording)?;
        let simulated = recorded.driver.strip_prefix(SIMULATED);
        let own = simulated.filter(|name| *name == world.scenario().driver && world.scenario().participant);
        let driver =
            own.map(|name| Ok::<_, RunError>(offline::driver_of(&driver::named(name)?.params, world)?)).transpose()?;
        Ok(Self {
            keys: Manifest::keys(recording)?,
            expected: recording_manifest::manifest(world, recorded.driver.clone(), recorded.graphics.clone()),
            summary: SummaryAccumulator::new([window_begin_s(summary_text.as_deref()), f64::INFINITY]),
            recorded,
            summary_text,
            driver,
            other_driver: None,
        })
    }

    /// Checks whether the drive was cut; then its end was not recorded.
    pub fn is_cut(&self) -> bool {
        self.recorded.state == RecordingState::Recovered
    }

    /// Compares the simulated driver's controls with the recorded ones, before the tick that they drive.
    pub fn before(&mut self, world: &World, controls: &Controls) {
        let Some(driver) = &mut self.driver else { return };
        if driver.controls(&world.perceived_by(driver)).sane() != controls.sane() {
            self.other_driver.get_or_insert(world.snapshot().tick.0 + 1);
        }
    }

    /// Adds a tick of the world to the summary.
    pub fn tick(&mut self, world: &World) {
        self.summary.add(world.snapshot(), world.events());
    }

    /// Returns the facts that differ, after all ticks were driven.
    pub fn end(&self, world: &World) -> Vec<FactDifference> {
        let mut found = Vec::new();
        let (summary, failure) = self.driven_summary(world);
        if let Some(text) = &self.summary_text {
            compare_summary(text, &summary, &mut found);
        }
        let mut expected = self.expected.clone();
        expected.state = self.recorded.state;
        expected.ended = Some(self.driven_end(failure));
        let hash = summary["hash"].as_str().map(str::to_owned);
        expected.hash = hash.filter(|_| !(self.is_cut() && self.recorded.hash.is_none()));
        let expected = object(&expected);
        let keys: BTreeSet<&String> = expected.keys().chain(self.keys.keys()).collect();
        for key in keys.into_iter().filter(|key| !STATED.contains(&key.as_str()) && !SEALS.contains(&key.as_str())) {
            compare(manifest::FILE, key, self.keys.get(key), expected.get(key), &mut found);
        }
        self.check_driver(world, &mut found);
        found
    }

    /// Returns the summary that the same drive writes, and the recorded failure, if any, which is not driven again.
    fn driven_summary(&self, world: &World) -> (Value, Option<String>) {
        let mut summary = self.summary.clone();
        let recorded = self.summary_text.as_deref().and_then(|text| serde_json::from_str::<Value>(text).ok());
        let failure =
            recorded.filter(|_| world.ended().is_none()).and_then(|value| Some(value["failure"].as_str()?.to_owned()));
        if let Some(why) = &failure {
            summary.fail(why.clone());
        }
        (serde_json::to_value(summary.to_summary()).expect("numbers and words"), failure)
    }

    /// Returns the manifest's text on the end that the same drive writes.
    fn driven_end(&self, failure: Option<String>) -> String {
        let mut summary = self.summary.clone();
        failure.into_iter().for_each(|why| summary.fail(why));
        let driven = summary.to_summary().end_text();
        let message = self.recorded.ended.clone().unwrap_or_default();
        let is_of_a_cut = message == "cut" || message.starts_with("recording failed: ");
        if self.is_cut() && is_of_a_cut { message } else { driven }
    }

    fn check_driver(&self, world: &World, found: &mut Vec<FactDifference>) {
        let mut add_difference = |driven: String| {
            let recorded = format!("{:?}", self.recorded.driver);
            found.push(FactDifference { file: manifest::FILE, key: "driver".into(), recorded, driven });
        };
        let simulated = self.recorded.driver.strip_prefix(SIMULATED);
        let asked = &world.scenario().driver;
        if simulated.is_some_and(|name| name != asked) {
            add_difference(format!("the driver of scenario.toml, {asked:?}"));
        }
        if let Some(tick) = self.other_driver {
            add_difference(format!("with other controls from tick {tick} on"));
        }
    }

    /// Returns the proofs of the manifest and the summary.
    pub fn evidence(&self) -> Vec<Evidence> {
        let mut stated: Vec<&str> =
            STATED.into_iter().filter(|key| self.keys.get(*key).is_some_and(|v| !v.is_null())).collect();
        if !self.recorded.driver.starts_with(SIMULATED) {
            stated.push("driver");
        }
        if self.is_cut() {
            stated.push("state and ended (the drive was cut)");
        } else if self.summary.to_summary().ended.is_none() {
            stated.push("ended (a person or a failure ended the drive)");
        }
        let manifest = Evidence::driving(manifest::FILE, format!("stated: {}", stated.join(", ")));
        [Some(manifest), self.summary_text.is_some().then(|| Evidence::driving(SUMMARY, String::new()))]
            .into_iter()
            .flatten()
            .collect()
    }
}

/// Returns the start of a summary's time window, s; 0 without one.
fn window_begin_s(summary: Option<&str>) -> f64 {
    let value: Option<Value> = summary.and_then(|text| serde_json::from_str(text).ok());
    value.and_then(|value| value["window_s"][0].as_f64()).unwrap_or_default()
}

fn object(manifest: &Manifest) -> Map<String, Value> {
    match serde_json::to_value(manifest) {
        Ok(Value::Object(keys)) => keys,
        _ => Map::new(),
    }
}

fn compare(
    file: &'static str,
    key: &str,
    recorded: Option<&Value>,
    driven: Option<&Value>,
    found: &mut Vec<FactDifference>,
) {
    if recorded != driven {
        let words = |value: Option<&Value>| value.map_or("nothing".into(), ToString::to_string);
        found.push(FactDifference { file, key: key.into(), recorded: words(recorded), driven: words(driven) });
    }
}

fn compare_summary(text: &str, driven: &Value, found: &mut Vec<FactDifference>) {
    let recorded: Map<String, Value> = match serde_json::from_str(text) {
        Ok(recorded) => recorded,
        Err(why) => {
            let (recorded, driven) = (format!("not readable: {why}"), "a list of keys and values".into());
            found.push(FactDifference { file: SUMMARY, key: "the file".into(), recorded, driven });
            return;
        }
    };
    let (before, driven) = (found.len(), driven.as_object().cloned().unwrap_or_default());
    let keys: BTreeSet<&String> = recorded.keys().chain(driven.keys()).collect();
    keys.into_iter().for_each(|key| compare(SUMMARY, key, recorded.get(key), driven.get(key), found));
    if found.len() == before && text != serde_json::to_string_pretty(&driven).expect("numbers and words") {
        let (recorded, driven) = ("written otherwise".into(), "other bytes of the same values".into());
        found.push(FactDifference { file: SUMMARY, key: "the file".into(), recorded, driven });
    }
}
