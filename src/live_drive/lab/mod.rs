//! Laboratory devices beside a drive: LSL streams of this program, LSL streams of other devices in its recording, and
//! triggers. In: the settings ([`LabSettings`]); ticks, frames and events of the drive. Out: samples with the times of
//! their events, tables in the recording, messages for the experimenter. Nothing here changes a drive, and the drive
//! loop does not wait for it.
//!
//! * `outlets`: the drive's own streams. `stream_reader`: recording of a stream of another device. `background`: a
//!   table written by a thread of its own.
//!
//! The time stamp of a tick is the time at which it was due: the start time of its frame, less the ticks that came
//! after it. All ticks of a frame are computed at once; their time stamps are 10 ms apart.

mod background;
mod outlets;
mod stream_reader;

use self::{background::BackgroundJournal, outlets::DriveOutlets, stream_reader::StreamReader};
use crate::{
    controls::Controls,
    drive_loop::RunError,
    file,
    lsl::{self, LslSettings, LslSettingsFault, OutletInterface, local_clock_s},
    record::{
        RecordError,
        streams::{CLOCK, STAMP, StreamColumn, StreamJournal, StreamValues, TIME},
        tables::{AdviceRow, EgoRow, EventRow, FrameRow},
    },
    sim::{EventKind, World},
    study::file::StudyFile,
    time::{TICK_S, Tick},
    toml_text::{self, KeyPart, TomlError},
    triggers::{TriggerPort, TriggerSettings, TriggerSettingsFault, WrittenTrigger},
};
use serde::{Deserialize, Serialize};
use std::{
    path::{Path, PathBuf},
    time::Duration,
};

/// Delay of a reading of the clock above which the drive must have paused, s.
const LONGEST_DELAY_S: f64 = 0.1;

/// Settings for the laboratory devices: the tables `[lsl]` and `[triggers]` of a study's file, or of a separate file.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LabSettings {
    /// LSL streams to send and to record.
    pub lsl: LslSettings,
    /// Triggers on a serial port; `None` for none.
    pub triggers: Option<TriggerSettings>,
}

/// Error in a settings file for laboratory devices.
#[derive(Debug, thiserror::Error)]
pub enum LabSettingsError {
    /// The file cannot be read.
    #[error("{path}: {why}")]
    File {
        /// Path of the settings file.
        path: PathBuf,
        why: std::io::Error,
    },
    /// The file's TOML is invalid.
    #[error(transparent)]
    Text(#[from] TomlError),
    /// A stream's settings are invalid.
    #[error("[lsl] {0}")]
    Lsl(#[from] LslSettingsFault),
    /// A trigger's settings are invalid.
    #[error("[triggers] {0}")]
    Triggers(#[from] TriggerSettingsFault),
}

impl LabSettings {
    /// Reads a file with the tables `[lsl]` and `[triggers]`.
    ///
    /// # Errors
    /// The file is invalid; the message gives the place and the allowed values.
    pub fn load(path: &Path) -> Result<Self, LabSettingsError> {
        let text = file::read_text(path, file::SETTINGS_BYTES);
        let text = text.map_err(|why| LabSettingsError::File { path: path.into(), why })?;
        let (settings, mut mistakes) = toml_text::read::<Self>(&text, &path.display().to_string());
        if let Some(Self { lsl, triggers }) = &settings {
            if let Err(fault) = lsl.check() {
                mistakes.add(&format!("lsl.{}", fault.key()), KeyPart::Value, &fault.to_string());
            }
            if let Some(Err(fault)) = triggers.as_ref().map(TriggerSettings::check) {
                mistakes.add(&format!("triggers.{}", fault.key()), KeyPart::Value, &fault.to_string());
            }
        }
        Ok(toml_text::finished((settings, mistakes))?)
    }

    /// Checks the values.
    ///
    /// # Errors
    /// The first invalid value.
    pub fn check(&self) -> Result<(), LabSettingsError> {
        self.lsl.check()?;
        Ok(self.triggers.as_ref().map_or(Ok(()), TriggerSettings::check)?)
    }

    /// Returns the settings of a study.
    pub fn of(study: &StudyFile) -> Self {
        Self { lsl: study.lsl.clone(), triggers: study.triggers.clone() }
    }
}

/// Open laboratory devices; by default there are none.
#[derive(Default)]
pub struct LabDevices {
    outlets: Option<DriveOutlets>,
    /// Settings of this program's streams while these are requested and not open yet.
    planned_outlets: Option<LslSettings>,
    readers: Vec<StreamReader>,
    triggers: Option<TriggerPort>,
    /// Description of the present trial.
    trial: Option<String>,
    /// Number of frames of the trial so far.
    frames: u64,
    recording: Option<LabRecording>,
    /// Start time of the frame, and the time stamp of its last tick, s on LSL's clock.
    frame_s: f64,
    stamp_s: f64,
    /// Rows of the frame's ticks.
    ticks: Vec<TickRows>,
    news: Vec<String>,
}

/// Rows of a tick for the streams.
struct TickRows {
    ego: EgoRow,
    advice: Option<AdviceRow>,
    events: Vec<EventRow>,
}

/// Tables in the recording that this thread fills; streams of other devices have threads of their own.
struct LabRecording {
    clock: BackgroundJournal,
    pairs: Vec<[f64; 2]>,
    triggers: Option<BackgroundJournal>,
}

/// Returns the start time of a frame that begins `elapsed` after one that began at `last_s`, where the clock was read at
/// `read_s`. The clock is read after the start, on a busy computer some milliseconds after it, and never before it. So
/// `elapsed`, which has no such delay, counts from the earliest start that the clock has shown since the last pause.
fn frame_start_s(last_s: f64, elapsed: Duration, read_s: f64) -> f64 {
    let due_s = last_s + elapsed.as_secs_f64();
    if read_s - due_s > LONGEST_DELAY_S { read_s } else { due_s.min(read_s) }
}

impl LabDevices {
    /// Opens the devices except for this program's streams ([`LabDevices::open_outlets`]). Waits for every stream that
    /// is to be recorded.
    ///
    /// # Errors
    /// liblsl is missing, a stream did not come in time, the trigger device cannot be opened, or the computer lacks the
    /// network interface of the settings.
    pub fn open(settings: &LabSettings) -> Result<Self, RunError> {
        let triggers = settings.triggers.as_ref().map(TriggerPort::open).transpose()?;
        let planned_outlets = settings.lsl.outlets.then(|| settings.lsl.clone());
        if planned_outlets.is_some() {
            lsl::library::open()?;
            OutletInterface::of(&settings.lsl.interface).check()?;
        }
        let wait_s = settings.lsl.wait_s;
        let readers = settings.lsl.record.iter().map(|predicate| StreamReader::open(predicate, wait_s));
        let readers = readers.collect::<Result<Vec<_>, _>>()?;
        let mut lab = Self::default();
        (lab.planned_outlets, lab.readers, lab.triggers) = (planned_outlets, readers, triggers);
        Ok(lab)
    }

    /// Opens this program's streams, if they are requested. A study does this after the participant's consent.
    ///
    /// # Errors
    /// liblsl refuses a stream.
    pub fn open_outlets(&mut self) -> Result<(), RunError> {
        if let Some(settings) = &self.planned_outlets {
            self.outlets = Some(DriveOutlets::open(settings)?);
            self.planned_outlets = None;
        }
        Ok(())
    }

    /// Checks whether there is no device.
    fn is_empty(&self) -> bool {
        self.outlets.is_none() && self.readers.is_empty() && self.triggers.is_none()
    }

    /// Starts a trial that is recorded in `recording`. `words` describes it: the item of the study's plan with its
    /// condition.
    ///
    /// # Errors
    /// The recording cannot be written.
    pub fn begin_trial(&mut self, recording: Option<&Path>, words: &str) -> Result<(), RecordError> {
        if self.is_empty() {
            return Ok(());
        }
        if let Some(recording) = recording {
            let columns = [
                StreamColumn::number(STAMP, "s", "LSL's clock of this machine at the start of a frame"),
                StreamColumn::number(TIME, "s", "time of the drive at the start of this frame"),
            ];
            let table = |name: &str, columns: &[StreamColumn]| {
                BackgroundJournal::new(StreamJournal::begin(recording, name, columns)?)
            };
            let clock = table(CLOCK, &columns)?;
            let triggers = self.triggers.is_some().then(|| table("triggers", &trigger_columns())).transpose()?;
            self.recording = Some(LabRecording { clock, pairs: Vec::new(), triggers });
            for reader in &self.readers {
                reader.begin(recording);
            }
        }
        // No frame of this trial follows the last frame of the trial before.
        (self.trial, self.frames, self.frame_s) = (Some(words.into()), 0, 0.0);
        self.announce("trial_start", words, local_clock_s());
        Ok(())
    }

    /// Ends the trial, and waits until everything received so far is in its recording: half a second at most if streams
    /// are recorded.
    ///
    /// # Errors
    /// The recording cannot be written.
    pub fn end_trial(&mut self) -> Result<(), RecordError> {
        let Some(words) = self.trial.take() else { return Ok(()) };
        self.announce("trial_end", &words, local_clock_s());
        let Some(mut recording) = self.recording.take() else { return Ok(()) };
        let ended: Vec<_> = self.readers.iter().map(StreamReader::end).collect();
        let mut result = recording.flush();
        if let Some(port) = &mut self.triggers {
            result = result.and(recording.triggers(port.wait_written(), &mut self.news));
        }
        result = result.and(recording.finish());
        for end in ended {
            result = result.and(end.wait());
        }
        self.take_reports();
        result
    }

    /// Starts a frame that begins `elapsed` after the one before; the time stamps of its ticks are counted back from its
    /// start.
    pub(super) fn begin_frame(&mut self, elapsed: Duration) {
        self.frame_s = frame_start_s(self.frame_s, elapsed, local_clock_s());
    }

    /// Adds a tick of the world with these controls.
    pub(super) fn tick(&mut self, world: &World, controls: &Controls) {
        if self.is_empty() {
            return;
        }
        let snapshot = world.snapshot();
        let advice = world.events().iter().find_map(|event| match event.kind {
            EventKind::Advice(advice) => {
                let speed_mps = snapshot.ego_before.speed_mps;
                Some(AdviceRow { advice, speed_mps, shown_frame: None, shown_wall_s: None })
            }
            _ => None,
        });
        let events = world.events().iter().filter_map(|event| EventRow::of(event, &world.scenario().events)).collect();
        self.ticks.push(TickRows { ego: EgoRow::of(snapshot, &controls.sane(), None, 0), advice, events });
    }

    /// Sends the frame's ticks. At the frame's start time the drive is at `tick` and `fraction` of the next.
    ///
    /// # Errors
    /// The recording cannot be written.
    pub(super) fn end_frame(&mut self, tick: Tick, fraction: f64) -> Result<(), RecordError> {
        if self.is_empty() {
            return Ok(());
        }
        let now_ticks = tick.0 as f64 + fraction;
        for rows in std::mem::take(&mut self.ticks) {
            let due_s = self.frame_s - (now_ticks - rows.ego.tick.0 as f64) * TICK_S;
            // The start times of frames differ by some microseconds from the ticks' times; time stamps must not go back
            // for that.
            self.stamp_s = due_s.max(self.stamp_s);
            self.push(&rows, self.stamp_s);
        }
        self.take_reports();
        let Some(recording) = &mut self.recording else { return Ok(()) };
        recording.pairs.push([self.frame_s, now_ticks * TICK_S]);
        let written = self.triggers.as_mut().map(TriggerPort::take_written).unwrap_or_default();
        recording.triggers(written, &mut self.news)
    }

    /// Passes the drive's clock to the disk, as often as the drive's own rows. Without it the samples of devices have
    /// no time in the drive.
    ///
    /// # Errors
    /// The recording cannot be written.
    pub(super) fn flush(&mut self) -> Result<(), RecordError> {
        self.recording.as_mut().filter(|recording| !recording.pairs.is_empty()).map_or(Ok(()), LabRecording::flush)
    }

    fn push(&mut self, rows: &TickRows, stamp_s: f64) {
        // An event at the start of a tick has the time stamp of the tick before.
        let of = |tick: Tick| stamp_s - (rows.ego.tick.0 as f64 - tick.0 as f64) * TICK_S;
        if let Some(outlets) = &mut self.outlets {
            outlets.tick(&rows.ego, stamp_s);
            if let Some(row) = &rows.advice {
                outlets.advice(row, of(row.advice.issued));
            }
            for event in &rows.events {
                outlets.event(event, of(event.tick));
            }
        }
        if let Some(port) = &mut self.triggers {
            if let Some(row) = &rows.advice {
                port.event("advice", of(row.advice.issued));
            }
            rows.events.iter().for_each(|event| port.event(&event.kind, of(event.tick)));
        }
    }

    /// Sends a frame that was handed to the screen just now; `number` is its number in the recording, if there is one.
    pub(super) fn shown(&mut self, row: FrameRow, number: Option<u64>) {
        // Frames before the start of the trial need no analysis.
        let Some(outlets) = self.outlets.as_mut().filter(|_| self.trial.is_some()) else { return };
        outlets.frame(&FrameRow { frame: number.unwrap_or(self.frames), ..row }, local_clock_s());
        self.frames += 1;
    }

    /// Sends an event from outside the world.
    pub(super) fn note(&mut self, kind: &str, detail: &str) {
        self.announce(kind, detail, local_clock_s());
    }

    fn announce(&mut self, kind: &str, detail: &str, stamp_s: f64) {
        if let Some(outlets) = &mut self.outlets {
            outlets.announce(kind, detail, stamp_s);
        }
        if let Some(port) = &mut self.triggers {
            port.event(kind, stamp_s);
        }
    }

    fn take_reports(&mut self) {
        self.news.extend(self.readers.iter().flat_map(StreamReader::take_news));
        self.news.extend(self.outlets.as_mut().and_then(DriveOutlets::take_trouble));
    }

    /// Returns the messages for the experimenter since the last call.
    pub fn take_news(&mut self) -> Vec<String> {
        self.take_reports();
        std::mem::take(&mut self.news)
    }
}

impl Drop for LabDevices {
    fn drop(&mut self) {
        // A drive that ends with an error keeps its data.
        if let Err(error) = self.end_trial() {
            log::error!("{error}");
        }
    }
}

impl LabRecording {
    fn flush(&mut self) -> Result<(), RecordError> {
        let pairs = std::mem::take(&mut self.pairs);
        let column = |k: usize| StreamValues::Numbers(pairs.iter().map(|pair| pair[k]).collect());
        self.clock.append(vec![column(0), column(1)])
    }

    fn finish(&mut self) -> Result<(), RecordError> {
        let triggers = self.triggers.as_mut().map_or(Ok(()), BackgroundJournal::finish);
        self.clock.finish().and(triggers)
    }

    fn triggers(&mut self, written: Vec<WrittenTrigger>, news: &mut Vec<String>) -> Result<(), RecordError> {
        for why in written.iter().filter_map(|trigger| trigger.why.as_ref()) {
            let text = format!("a trigger was not written: {why}");
            log::error!("{text}");
            news.push(text);
        }
        let Some(journal) = self.triggers.as_mut().filter(|_| !written.is_empty()) else { return Ok(()) };
        let numbers = |get: fn(&WrittenTrigger) -> f64| StreamValues::Numbers(written.iter().map(get).collect());
        journal.append(vec![
            numbers(|trigger| trigger.due_s),
            numbers(|trigger| trigger.written_s.unwrap_or(f64::NAN)),
            StreamValues::Texts(written.iter().map(|trigger| trigger.event.clone()).collect()),
            numbers(|trigger| trigger.code.into()),
        ])
    }
}

fn trigger_columns() -> [StreamColumn; 4] {
    [
        StreamColumn::number(STAMP, "s", "time of the event, on LSL's clock of this machine"),
        StreamColumn::number(
            "written_lsl_s",
            "s",
            "time at which the system accepted the byte, on LSL's clock of this machine; empty if it did not",
        ),
        StreamColumn::text("event", "kind of event: advice, trial_start, trial_end, mark or contact"),
        StreamColumn::number("code", "", "the byte"),
    ]
}

#[cfg(test)]
mod tests;
