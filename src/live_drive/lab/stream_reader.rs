//! Recording of a stream of another device, on a thread of its own. In: samples, and the starts and ends of drives.
//! Out: a table in the recording with the device's own time stamps; beside it a JSON file with the stream's
//! description, the measured clock offsets and the gaps; messages for the experimenter. The reader looks for a lost
//! stream until it is back.

use crate::{
    lsl::{self, ClockOffset, FoundStream, Inlet, LslError, SampleChunk, SampleValues, local_clock_s},
    record::{
        RecordError,
        streams::{OFFSET, STAMP, StreamColumn, StreamJournal, StreamValues},
    },
    traffic::is_interrupted,
};
use serde_json::json;
use std::{
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
        mpsc::{self, Receiver, Sender, TryRecvError},
    },
    thread::JoinHandle,
    time::Duration,
};

/// Interval at which samples are fetched. A broken connection loses the samples since the last fetch.
const FETCH_EVERY: Duration = Duration::from_millis(5);
/// Interval at which rows are written, s.
const FLUSH_S: f64 = 0.5;
/// Interval at which the offset of the device's clock is measured, s.
const OFFSET_S: f64 = 5.0;
/// Longest wait for the first measurement of the offset, s.
const FIRST_OFFSET_S: f64 = 5.0;
/// Time without samples after which a stream of fixed rate is reported as silent, s.
const SILENT_S: f64 = 3.0;
/// Longest wait after the end of a drive for samples from before it, s: devices send in chunks.
const LATE_S: f64 = 0.3;

enum ReaderCommand {
    Begin(PathBuf),
    End(Sender<Result<(), RecordError>>),
}

/// End of a recording that is being written.
pub struct PendingEnd(Receiver<Result<(), RecordError>>);

impl PendingEnd {
    /// Waits until everything is on disk.
    ///
    /// # Errors
    /// The recording cannot be written.
    pub fn wait(self) -> Result<(), RecordError> {
        // Without its thread there is nothing to wait for; the thread has reported why it ended.
        self.0.recv().unwrap_or_else(|_| Err(RecordError::Stopped("the thread that reads a stream has ended".into())))
    }
}

/// The drive loop's end of a stream.
pub struct StreamReader {
    commands: Option<Sender<ReaderCommand>>,
    news: Receiver<String>,
    thread: Option<JoinHandle<()>>,
    /// Request to stop, so that the thread waits for no response.
    ends: Arc<AtomicBool>,
}

impl StreamReader {
    /// Waits for the stream and starts to read it.
    ///
    /// # Errors
    /// liblsl is missing, or the stream does not come or respond in time.
    pub fn open(predicate: &str, wait_s: f64) -> Result<Self, LslError> {
        let mut inlet = lsl::resolve(predicate, wait_s, &is_interrupted)?;
        let offset = inlet.clock_offset(FIRST_OFFSET_S, &is_interrupted)?;
        log::info!("records the LSL stream {}", inlet.stream());
        let (commands, received) = mpsc::channel();
        let (sender, news) = mpsc::channel();
        let ends = Arc::new(AtomicBool::new(false));
        let now = local_clock_s();
        let reader = ReaderThread {
            predicate: predicate.into(),
            stream: inlet.stream().clone(),
            inlet: Some(inlet),
            offset,
            offset_asked_s: now,
            sample_s: now,
            is_silent: false,
            recording: None,
            sender,
            ends: Arc::clone(&ends),
        };
        let thread = std::thread::Builder::new().name("lsl".into()).spawn(move || reader.run(&received));
        let thread = thread.map_err(|why| LslError::Refused { what: "a thread".into(), why: why.to_string() })?;
        Ok(Self { commands: Some(commands), news, thread: Some(thread), ends })
    }

    /// Starts a recording in the folder of a drive.
    pub fn begin(&self, recording: &Path) {
        self.command(ReaderCommand::Begin(recording.into()));
    }

    /// Ends the recording at the present time.
    pub fn end(&self) -> PendingEnd {
        let (to, done) = mpsc::channel();
        self.command(ReaderCommand::End(to));
        PendingEnd(done)
    }

    fn command(&self, command: ReaderCommand) {
        if let Some(commands) = &self.commands {
            // A thread that is gone is reported by [`PendingEnd::wait`].
            let _ = commands.send(command);
        }
    }

    /// Returns the messages about the stream since the last call.
    pub fn take_news(&self) -> Vec<String> {
        self.news.try_iter().collect()
    }
}

impl Drop for StreamReader {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        self.commands = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Recording of the stream in one drive.
struct StreamRecording {
    journal: StreamJournal,
    folder: PathBuf,
    stream: FoundStream,
    stamps_s: Vec<f64>,
    offsets_s: Vec<f64>,
    values: SampleValues,
    clock_offsets: Vec<ClockOffset>,
    /// Times at which the stream was lost and was back, s on LSL's clock.
    gaps: Vec<[Option<f64>; 2]>,
    flushed_s: f64,
    /// Error that ended the recording.
    failed: Option<RecordError>,
}

struct ReaderThread {
    predicate: String,
    /// Description of the stream when it was last found.
    stream: FoundStream,
    /// Open inlet; `None` while the stream is lost.
    inlet: Option<Inlet>,
    offset: ClockOffset,
    offset_asked_s: f64,
    /// Time of the last samples, s on LSL's clock.
    sample_s: f64,
    is_silent: bool,
    recording: Option<StreamRecording>,
    sender: Sender<String>,
    ends: Arc<AtomicBool>,
}

impl ReaderThread {
    fn run(mut self, commands: &Receiver<ReaderCommand>) {
        loop {
            match commands.try_recv() {
                Ok(ReaderCommand::Begin(folder)) => self.begin(&folder),
                Ok(ReaderCommand::End(done)) => {
                    let ended = self.end();
                    // The receiver may be gone.
                    let _ = done.send(ended);
                }
                Err(TryRecvError::Empty) => {}
                Err(TryRecvError::Disconnected) => return,
            }
            self.fetch();
            self.measure();
            self.flush(FLUSH_S);
            std::thread::sleep(FETCH_EVERY);
        }
    }

    fn begin(&mut self, folder: &Path) {
        // Samples from before the drive do not belong to it.
        self.fetch();
        match StreamRecording::begin(folder, &self.stream) {
            Ok(mut recording) => {
                recording.clock_offsets.push(self.offset);
                if self.inlet.is_none() {
                    recording.gaps.push([None, None]);
                }
                recording.describe(&self.predicate);
                self.recording = Some(recording);
            }
            Err(error) => self.tell(format!("the LSL stream {} is not recorded: {error}", self.stream.name)),
        }
    }

    fn end(&mut self) -> Result<(), RecordError> {
        let end_s = local_clock_s();
        while self.recording.is_some() && self.inlet.is_some() {
            let newest = self.recording.as_ref().and_then(|recording| recording.stamps_s.last().copied());
            let is_past = newest.is_some_and(|stamp| stamp + self.offset.offset_s > end_s);
            if is_past || local_clock_s() - end_s > LATE_S {
                break;
            }
            self.fetch();
            std::thread::sleep(FETCH_EVERY);
        }
        self.flush(0.0);
        let Some(mut recording) = self.recording.take() else { return Ok(()) };
        recording.describe(&self.predicate);
        recording.failed.map_or(Ok(()), Err)
    }

    /// Fetches the samples that have arrived, or looks for a lost stream.
    fn fetch(&mut self) {
        let Some(inlet) = &mut self.inlet else { return self.look_for() };
        loop {
            match inlet.pull() {
                Ok(chunk) if chunk.stamps_s.is_empty() => break,
                Ok(chunk) => {
                    self.sample_s = local_clock_s();
                    if let Some(recording) = &mut self.recording {
                        recording.take(chunk, self.offset.offset_s);
                    }
                }
                Err(error) => return self.lost(&error),
            }
        }
        let is_silent = self.stream.nominal_srate > 0.0 && local_clock_s() - self.sample_s > SILENT_S;
        if is_silent != self.is_silent {
            self.is_silent = is_silent;
            let name = &self.stream.name;
            self.tell(match is_silent {
                true => format!("the LSL stream {name} has sent nothing for {SILENT_S} s"),
                false => format!("the LSL stream {name} sends again"),
            });
        }
    }

    fn lost(&mut self, error: &LslError) {
        self.inlet = None;
        self.is_silent = false;
        self.tell(format!("{error}; codrive searches for it"));
        if let Some(recording) = &mut self.recording {
            recording.gaps.push([Some(local_clock_s()), None]);
            recording.describe(&self.predicate);
        }
    }

    /// Looks for a lost stream, by its `source_id` if it has one.
    fn look_for(&mut self) {
        let source = &self.stream.source_id;
        let predicate = match source.contains('\'') || source.is_empty() {
            true => self.predicate.clone(),
            false => format!("({}) and source_id='{source}'", self.predicate),
        };
        let ends = Arc::clone(&self.ends);
        let ends = move || ends.load(Ordering::Relaxed) || is_interrupted();
        let found = lsl::find(&predicate, FLUSH_S, &ends);
        let Ok(Some(mut inlet)) = found else { return };
        let Ok(offset) = inlet.clock_offset(FIRST_OFFSET_S, &ends) else { return };
        let now = local_clock_s();
        (self.offset, self.offset_asked_s, self.sample_s) = (offset, now, now);
        self.stream = inlet.stream().clone();
        self.inlet = Some(inlet);
        self.tell(format!("the LSL stream {} is back", self.stream.name));
        let Some(recording) = &mut self.recording else { return };
        if let Some(gap) = recording.gaps.last_mut() {
            gap[1] = Some(now);
        }
        if recording.stream.is_text() != self.stream.is_text() || recording.stream.channels != self.stream.channels {
            // Another format or other channels need another table.
            let folder = recording.folder.clone();
            self.flush(0.0);
            return self.begin(&folder);
        }
        recording.clock_offsets.push(offset);
        recording.describe(&self.predicate);
    }

    fn measure(&mut self) {
        let now = local_clock_s();
        let Some(inlet) = self.inlet.as_mut().filter(|_| now - self.offset_asked_s >= OFFSET_S) else { return };
        self.offset_asked_s = now;
        // The library measures in a thread of its own. A failed measurement is made up for by the next.
        let Ok(offset) = inlet.clock_offset(FLUSH_S, &|| self.ends.load(Ordering::Relaxed)) else { return };
        self.offset = offset;
        if let Some(recording) = &mut self.recording {
            recording.clock_offsets.push(offset);
            recording.describe(&self.predicate);
        }
    }

    fn flush(&mut self, every_s: f64) {
        let now = local_clock_s();
        let Some(recording) = self.recording.as_mut().filter(|recording| now - recording.flushed_s >= every_s) else {
            return;
        };
        recording.flushed_s = now;
        if let Err(error) = recording.flush() {
            let text = format!("the LSL stream {} is no longer recorded: {error}", recording.stream.name);
            recording.failed = Some(error);
            self.tell(text);
        }
    }

    fn tell(&self, text: String) {
        log::warn!("{text}");
        // The receiver may be gone.
        let _ = self.sender.send(text);
    }
}

impl StreamRecording {
    fn begin(folder: &Path, stream: &FoundStream) -> Result<Self, RecordError> {
        let mut columns = vec![
            StreamColumn::number(STAMP, "s", "time stamp of the sample, by the clock of the device's computer"),
            StreamColumn::number(
                OFFSET,
                "s",
                "clock of this machine minus clock of the device's computer, last measured value",
            ),
        ];
        for (k, channel) in stream.channels.iter().enumerate() {
            let name = if channel.label.is_empty() { format!("channel_{}", k + 1) } else { channel.label.clone() };
            columns.push(match stream.is_text() {
                true => StreamColumn::text(&name, ""),
                false => StreamColumn::number(&name, &channel.unit, ""),
            });
        }
        let values = no_values(stream);
        Ok(Self {
            journal: StreamJournal::begin(folder, &stream.name, &columns)?,
            folder: folder.into(),
            stream: stream.clone(),
            stamps_s: Vec::new(),
            offsets_s: Vec::new(),
            values,
            clock_offsets: Vec::new(),
            gaps: Vec::new(),
            flushed_s: local_clock_s(),
            failed: None,
        })
    }

    fn take(&mut self, chunk: SampleChunk, offset_s: f64) {
        self.offsets_s.resize(self.offsets_s.len() + chunk.stamps_s.len(), offset_s);
        self.stamps_s.extend(chunk.stamps_s);
        match (&mut self.values, chunk.values) {
            (SampleValues::Numbers(all), SampleValues::Numbers(new)) => all.extend(new),
            (SampleValues::Texts(all), SampleValues::Texts(new)) => all.extend(new),
            // The format of a stream is the same throughout a table.
            _ => {}
        }
    }

    fn flush(&mut self) -> Result<(), RecordError> {
        if self.stamps_s.is_empty() || self.failed.is_some() {
            return Ok(());
        }
        let count = self.stream.channels.len();
        let [stamps, offsets] = [&mut self.stamps_s, &mut self.offsets_s].map(std::mem::take);
        let mut columns = vec![StreamValues::Numbers(stamps), StreamValues::Numbers(offsets)];
        match std::mem::replace(&mut self.values, no_values(&self.stream)) {
            SampleValues::Numbers(all) => columns.extend(
                (0..count).map(|k| StreamValues::Numbers(all.iter().skip(k).step_by(count).copied().collect())),
            ),
            SampleValues::Texts(all) => columns
                .extend((0..count).map(|k| StreamValues::Texts(all.iter().skip(k).step_by(count).cloned().collect()))),
        }
        self.journal.append(columns)
    }

    /// Writes the JSON file beside the table with the present state.
    fn describe(&mut self, predicate: &str) {
        let gaps: Vec<_> =
            self.gaps.iter().map(|[lost, back]| json!({ "lost_lsl_s": lost, "back_lsl_s": back })).collect();
        let text = json!({
            "predicate": predicate,
            "samples": self.journal.rows(),
            "stream": self.stream,
            "clock_offsets": self.clock_offsets,
            "gaps": gaps,
        });
        if let Err(error) = self.journal.describe("json", &format!("{text:#}\n")) {
            self.failed.get_or_insert(error);
        }
    }
}

fn no_values(stream: &FoundStream) -> SampleValues {
    if stream.is_text() { SampleValues::Texts(Vec::new()) } else { SampleValues::Numbers(Vec::new()) }
}
