//! Facts of a recording that follow from its drive. In: `manifest.json` and `summary.json`, and the world that is driven again. Out: every
//! value of theirs that is not as the drive gives it, by the functions that wrote it; and what no drive can prove.

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

/// Keys of `manifest.json` that no drive can prove: who and what took part, and when.
pub const STATED: [&str; 8] =
    ["program", "build", "policy_asked", "participant", "began", "machine", "graphics", "screen"];
/// Keys that are seals, and that of the format, which is compared when the file is read.
const SEALS: [&str; 3] = ["format", "checksums", "sha256"];
/// Words before the name of a simulated driver.
const SIMULATED: &str = "simulated: ";
/// The file with the drive in numbers.
pub(super) const SUMMARY: &str = "summary.json";

/// A value that is not as the same drive gives it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FactDifference {
    /// The file.
    pub file: &'static str,
    /// Key of the value.
    pub key: String,
    /// Value in the recording.
    pub recorded: String,
    /// Value that the same drive gives.
    pub driven: String,
}

impl fmt::Display for FactDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { file, key, recorded, driven } = self;
        write!(f, "{file}: {key} is {recorded}, driven again {driven}")
    }
}

/// Statements of a recording about its drive, and the results of the drive so far.
pub(super) struct DriveFacts {
    recorded: Manifest,
    keys: Map<String, Value>,
    /// Manifest that the same world writes.
    expected: Manifest,
    /// Text of the summary; `None` where there is none.
    summary: Option<String>,
    tally: SummaryAccumulator,
    /// The simulated driver that the recording names, and the first tick at which it would have given other controls.
    driver: Option<SimulatedDriver>,
    other_driver: Option<u64>,
}

impl DriveFacts {
    /// Reads those of a recording beside its world before the first tick.
    pub fn open(recording: &Path, world: &World) -> Result<Self, RunError> {
        let path = recording.join(SUMMARY);
        let read =
            |path: &Path| read_text(path, SETTINGS_BYTES).map_err(|why| RecordError::File { path: path.into(), why });
        let summary = is_there(&path)?.then(|| read(&path)).transpose()?;
        let recorded = Manifest::load(recording)?;
        let simulated = recorded.driver.strip_prefix(SIMULATED);
        let own = simulated.filter(|name| *name == world.scenario().driver && world.scenario().participant);
        let driver =
            own.map(|name| Ok::<_, RunError>(offline::driver_of(&driver::named(name)?.params, world)?)).transpose()?;
        Ok(Self {
            keys: Manifest::keys(recording)?,
            expected: recording_manifest::manifest(world, recorded.driver.clone(), recorded.graphics.clone()),
            tally: SummaryAccumulator::new([window_begin_s(summary.as_deref()), f64::INFINITY]),
            recorded,
            summary,
            driver,
            other_driver: None,
        })
    }

    /// True for a drive that was cut: nobody wrote how it ended.
    pub fn is_cut(&self) -> bool {
        self.recorded.state == RecordingState::Recovered
    }

    /// Before a tick that is driven with these controls.
    pub fn before(&mut self, world: &World, controls: &Controls) {
        let Some(driver) = &mut self.driver else { return };
        if driver.controls(&world.perceived_by(driver)).sane() != controls.sane() {
            self.other_driver.get_or_insert(world.snapshot().tick.0 + 1);
        }
    }

    /// The world has made a tick.
    pub fn tick(&mut self, world: &World) {
        self.tally.add(world.snapshot(), world.events());
    }

    /// All ticks were driven: what is not as the drive gives it.
    pub fn end(&self, world: &World) -> Vec<FactDifference> {
        let mut found = Vec::new();
        let (summary, failure) = self.driven_summary(world);
        if let Some(text) = &self.summary {
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

    /// The summary that the same drive writes, and why it failed, which is not driven again.
    fn driven_summary(&self, world: &World) -> (Value, Option<String>) {
        let mut tally = self.tally.clone();
        let recorded = self.summary.as_deref().and_then(|text| serde_json::from_str::<Value>(text).ok());
        let failure =
            recorded.filter(|_| world.ended().is_none()).and_then(|value| Some(value["failure"].as_str()?.to_owned()));
        if let Some(why) = &failure {
            tally.fail(why.clone());
        }
        (serde_json::to_value(tally.summary()).expect("numbers and words"), failure)
    }

    /// Words of the same drive's manifest on its end.
    fn driven_end(&self, failure: Option<String>) -> String {
        let mut tally = self.tally.clone();
        failure.into_iter().for_each(|why| tally.fail(why));
        let driven = tally.summary().end_in_words();
        let said = self.recorded.ended.clone().unwrap_or_default();
        let is_of_a_cut = said == "cut" || said.starts_with("recording failed: ");
        if self.is_cut() && is_of_a_cut { said } else { driven }
    }

    fn check_driver(&self, world: &World, found: &mut Vec<FactDifference>) {
        let mut say = |driven: String| {
            let recorded = format!("{:?}", self.recorded.driver);
            found.push(FactDifference { file: manifest::FILE, key: "driver".into(), recorded, driven });
        };
        let simulated = self.recorded.driver.strip_prefix(SIMULATED);
        let asked = &world.scenario().driver;
        if simulated.is_some_and(|name| name != asked) {
            say(format!("the driver of scenario.toml, {asked:?}"));
        }
        if let Some(tick) = self.other_driver {
            say(format!("with other controls from tick {tick} on"));
        }
    }

    /// Proofs of the manifest and the summary.
    pub fn evidence(&self) -> Vec<Evidence> {
        let mut stated: Vec<&str> =
            STATED.into_iter().filter(|key| self.keys.get(*key).is_some_and(|v| !v.is_null())).collect();
        if !self.recorded.driver.starts_with(SIMULATED) {
            stated.push("driver");
        }
        if self.is_cut() {
            stated.push("state and ended (the drive was cut)");
        } else if self.tally.summary().ended.is_none() {
            stated.push("ended (somebody or a failure ended the drive)");
        }
        let manifest = Evidence::driving(manifest::FILE, format!("stated: {}", stated.join(", ")));
        [Some(manifest), self.summary.is_some().then(|| Evidence::driving(SUMMARY, String::new()))]
            .into_iter()
            .flatten()
            .collect()
    }
}

/// The first second of the window of a summary.
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
            let (recorded, driven) = (format!("not to be read: {why}"), "a list of keys and values".into());
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
