//! Other devices of a laboratory beside a drive: streams of LSL out of it and into its recording, and triggers. In: what is asked for
//! ([`LabSettings`]); ticks, frames and events of the drive. Out: samples with the time at which they happened, tables in the
//! recording, what the experimenter has to know. Nothing here changes a drive, and its loop waits for none of it.
//!
//! * `outlets`: the drive's own streams. `stream_reader`: a stream of another device on its way into the recording. `background`: a
//!   table that a thread of its own writes.
//!
//! The time of a tick is that at which it was due: the time at which its frame began, less the ticks that came after it. All
//! ticks of a frame are computed at once; their time stamps are 10 ms apart as the ticks are.

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
    toml_text::{self, TomlError},
    triggers::{TriggerPort, TriggerSettings, TriggerSettingsFault, WrittenTrigger},
};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// What a drive has to do with other devices: the tables `[lsl]` and `[triggers]` of a study's file, or of a file of their own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LabSettings {
    /// Streams.
    pub lsl: LslSettings,
    /// Triggers.
    pub triggers: Option<TriggerSettings>,
}

/// A file of these settings that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum LabSettingsError {
    /// It cannot be read.
    #[error("{path}: {why}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        why: std::io::Error,
    },
    /// It is not as it should be written.
    #[error(transparent)]
    Text(#[from] TomlError),
    /// A stream cannot be asked for so.
    #[error("[lsl] {0}")]
    Lsl(#[from] LslSettingsFault),
    /// A trigger cannot be.
    #[error("[triggers] {0}")]
    Triggers(#[from] TriggerSettingsFault),
}

impl LabSettings {
    /// Reads a file with the tables `[lsl]` and `[triggers]`.
    ///
    /// # Errors
    /// What is wrong, where, and what is allowed.
    pub fn load(path: &Path) -> Result<Self, LabSettingsError> {
        let text = file::read_text(path, file::SETTINGS_BYTES);
        let text = text.map_err(|why| LabSettingsError::File { path: path.into(), why })?;
        let settings: Self = toml_text::parse(&text, &path.display().to_string())?;
        settings.check()?;
        Ok(settings)
    }

    /// Checks the values.
    ///
    /// # Errors
    /// The first that cannot be.
    pub fn check(&self) -> Result<(), LabSettingsError> {
        self.lsl.check()?;
        Ok(self.triggers.as_ref().map_or(Ok(()), TriggerSettings::check)?)
    }

    /// Those of a study.
    pub fn of(study: &StudyFile) -> Self {
        Self { lsl: study.lsl.clone(), triggers: study.triggers.clone() }
    }
}

/// The devices, open. The default has none.
#[derive(Default)]
pub struct LabDevices {
    outlets: Option<DriveOutlets>,
    /// Streams of this program that are asked for and not open yet.
    planned_outlets: Option<LslSettings>,
    readers: Vec<StreamReader>,
    triggers: Option<TriggerPort>,
    /// The words of the trial that runs.
    trial: Option<String>,
    /// Frames of it so far.
    frames: u64,
    recording: Option<LabRecording>,
    /// When the frame began, and the time stamp of its last tick.
    frame_s: f64,
    stamp_s: f64,
    /// What happened in the ticks of this frame.
    ticks: Vec<TickRows>,
    news: Vec<String>,
}

/// What a tick has for the streams.
struct TickRows {
    ego: EgoRow,
    advice: Option<AdviceRow>,
    events: Vec<EventRow>,
}

/// What goes into the recording of a drive beside the streams, which their own threads write.
struct LabRecording {
    clock: BackgroundJournal,
    pairs: Vec<[f64; 2]>,
    triggers: Option<BackgroundJournal>,
}

impl LabDevices {
    /// Opens what is asked for but the streams of this program ([`LabDevices::open_outlets`]); waits for every stream that is to be
    /// recorded.
    ///
    /// # Errors
    /// liblsl is not here, a stream did not come in time, or the trigger device cannot be opened; this machine has not the interface
    /// on which streams are to be heard.
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

    /// Opens the streams of this program, where they are asked for. In a study that is after the participant's consent.
    ///
    /// # Errors
    /// liblsl refuses.
    pub fn open_outlets(&mut self) -> Result<(), RunError> {
        if let Some(settings) = &self.planned_outlets {
            self.outlets = Some(DriveOutlets::open(settings)?);
            self.planned_outlets = None;
        }
        Ok(())
    }

    /// True where there is nothing to be told anything.
    fn is_empty(&self) -> bool {
        self.outlets.is_none() && self.readers.is_empty() && self.triggers.is_none()
    }

    /// A drive begins; it is recorded in `recording`, and `words` say which it is: the item of the study's plan with its condition.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn begin_trial(&mut self, recording: Option<&Path>, words: &str) -> Result<(), RecordError> {
        if self.is_empty() {
            return Ok(());
        }
        if let Some(recording) = recording {
            let columns = [
                StreamColumn::number(STAMP, "s", "LSL's clock of this machine at the begin of a frame"),
                StreamColumn::number(TIME, "s", "time of the drive then"),
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
        (self.trial, self.frames) = (Some(words.into()), 0);
        self.announce("trial_start", words, local_clock_s());
        Ok(())
    }

    /// It is over: everything that was taken until now is in its recording. Waits for that, half a second at most where streams are
    /// recorded.
    ///
    /// # Errors
    /// The disk refuses.
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

    /// A frame begins: its ticks are counted back from now.
    pub(super) fn begin_frame(&mut self) {
        self.frame_s = local_clock_s();
    }

    /// The world has made a tick.
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
        let events = world.events().iter().filter_map(EventRow::of).collect();
        self.ticks.push(TickRows { ego: EgoRow::of(snapshot, &controls.sane(), None, 0), advice, events });
    }

    /// The frame's ticks are made: the drive stands at `tick` and `fraction` of the next, which is now.
    ///
    /// # Errors
    /// The disk refuses.
    pub(super) fn end_frame(&mut self, tick: Tick, fraction: f64) -> Result<(), RecordError> {
        if self.is_empty() {
            return Ok(());
        }
        let now_ticks = tick.0 as f64 + fraction;
        for rows in std::mem::take(&mut self.ticks) {
            let due_s = self.frame_s - (now_ticks - rows.ego.tick.0 as f64) * TICK_S;
            // Frames begin some microseconds apart from where ticks put them: time does not go back for that.
            self.stamp_s = due_s.max(self.stamp_s);
            self.push(&rows, self.stamp_s);
        }
        self.take_reports();
        let Some(recording) = &mut self.recording else { return Ok(()) };
        recording.pairs.push([self.frame_s, now_ticks * TICK_S]);
        let written = self.triggers.as_mut().map(TriggerPort::take_written).unwrap_or_default();
        recording.triggers(written, &mut self.news)
    }

    /// Hands the drive's clock to the disk, without which a device's samples have no time in the drive; as often as the drive itself.
    ///
    /// # Errors
    /// The disk refuses.
    pub(super) fn flush(&mut self) -> Result<(), RecordError> {
        self.recording.as_mut().filter(|recording| !recording.pairs.is_empty()).map_or(Ok(()), LabRecording::flush)
    }

    fn push(&mut self, rows: &TickRows, stamp_s: f64) {
        // What happens as a tick begins has the stamp of the tick before.
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

    /// A frame was handed to the screen just now; `number` is the recording's, where there is one.
    pub(super) fn shown(&mut self, row: FrameRow, number: Option<u64>) {
        // Of a drive that is held before its start nothing is to be analysed.
        let Some(outlets) = self.outlets.as_mut().filter(|_| self.trial.is_some()) else { return };
        outlets.frame(&FrameRow { frame: number.unwrap_or(self.frames), ..row }, local_clock_s());
        self.frames += 1;
    }

    /// Something happened that the world does not know of.
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

    /// What the experimenter has to know since the last call.
    pub fn take_news(&mut self) -> Vec<String> {
        self.take_reports();
        std::mem::take(&mut self.news)
    }
}

impl Drop for LabDevices {
    fn drop(&mut self) {
        // A drive that ends by an error keeps what there is.
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
        StreamColumn::number(STAMP, "s", "when the event was, on LSL's clock of this machine"),
        StreamColumn::number(
            "written_lsl_s",
            "s",
            "when the system had taken the byte, on the same clock; empty if it did not",
        ),
        StreamColumn::text("event", "advice, trial_start, trial_end, mark or contact"),
        StreamColumn::number("code", "", "the byte"),
    ]
}

#[cfg(test)]
mod tests;
