//! Drive loop's side of a recording: gathers rows and passes them to the writing thread in batches. In: the world after a tick,
//! a frame, a mark. Out: batches in a bounded queue. A full queue or disk is an error at the next call.

use super::{
    Manifest, RecordError, checksums, files,
    journal::{self, DurableFile, Journal},
    lock::RecordingLock,
    manifest::RecordingState,
    recover,
    tables::{
        AdviceRow, AdvisedRow, CarRow, EgoRow, EventRow, FrameRow, NetworkObserver, RowBatch, Table, recorded_cars,
    },
};
use crate::{
    controls::Controls,
    map::network::Network,
    scenario::Scenario,
    sim::{EventKind, HASH_START, Snapshot, Summary, World},
    time::Tick,
};
use fail::fail_point;
use std::{
    path::{Path, PathBuf},
    sync::{
        Arc,
        atomic::{AtomicU64, AtomicUsize, Ordering},
        mpsc::{self, SyncSender, TrySendError},
    },
    thread::JoinHandle,
    time::Duration,
};

/// Maximum time that rows wait before the owner of the clock passes them to the writing thread. A power cut loses at most this
/// and the time of writing a batch; the promised limit is 0.5 s.
pub const FLUSH_EVERY: Duration = Duration::from_millis(200);
/// Maximum number of batches that wait for the disk: 13 s of a drive.
const QUEUE: usize = 64;
/// Maximum number of ticks in a batch, at full speed without a clock.
const MOST_TICKS: usize = 2_000;

/// Status of the writing thread, readable at any time without waiting.
#[derive(Debug)]
pub struct WriterStatus {
    waiting: AtomicUsize,
    /// Free space on the disk, bytes; [`u64::MAX`] if the system does not report it.
    free: AtomicU64,
}

impl WriterStatus {
    /// Returns the number of waiting batches and its maximum.
    pub fn waiting(&self) -> [usize; 2] {
        [self.waiting.load(Ordering::Relaxed), QUEUE]
    }

    /// Returns the free space on the disk after the last batch, bytes; `None` if the system does not report it.
    pub fn free_bytes(&self) -> Option<u64> {
        Some(self.free.load(Ordering::Relaxed)).filter(|bytes| *bytes != u64::MAX)
    }

    fn look(&self, folder: &Path) {
        self.free.store(files::free_bytes(folder).unwrap_or(u64::MAX), Ordering::Relaxed);
    }
}

/// Recorder of one drive.
#[derive(Debug)]
pub struct Recorder {
    folder: PathBuf,
    manifest: Manifest,
    hash: u64,
    batch: RowBatch,
    observer: NetworkObserver,
    /// Advice that no frame has shown yet.
    unseen: Vec<AdviceRow>,
    writer_status: Arc<WriterStatus>,
    /// Last torque sent to the wheel's motor, N m.
    wheel_force_nm: Option<f64>,
    queue: Option<SyncSender<RowBatch>>,
    writer: Option<JoinHandle<Result<(), RecordError>>>,
    /// Lock on the folder until everything is written.
    _lock: RecordingLock,
}

impl Recorder {
    /// Begins a recording of `scenario` in `folder`, which is made if needed.
    ///
    /// # Errors
    /// The folder holds a recording already, or an I/O error.
    pub fn begin(folder: &Path, scenario: &Scenario, manifest: Manifest) -> Result<Self, RecordError> {
        Self::begin_with(folder, scenario, manifest, Journal::begin)
    }

    /// Begins a recording with the journal that `open` makes; tests pass one on a full disk.
    fn begin_with<F: DurableFile>(
        folder: &Path,
        scenario: &Scenario,
        mut manifest: Manifest,
        open: impl Fn(&Path) -> Result<Journal<F>, RecordError>,
    ) -> Result<Self, RecordError> {
        files::new_private_dir(folder)?;
        let lock = RecordingLock::take(folder)?;
        let names = ["manifest.json", "scenario.toml", "summary.json", checksums::FILE, journal::FOLDER];
        let tables = Table::ALL.map(|table| format!("{}.parquet", table.name()));
        let names = names.into_iter().map(str::to_owned).chain(tables);
        for file in names {
            if files::is_there(&folder.join(&file))? {
                return Err(RecordError::Taken { folder: folder.into(), file });
            }
        }
        fail_point!("begin.folder");
        manifest.state = RecordingState::Running;
        manifest.save(folder)?;
        fail_point!("begin.manifest");
        files::replace(&folder.join("scenario.toml"), scenario.to_toml().as_bytes())?;
        fail_point!("begin.scenario");
        let blocks = folder.join(journal::FOLDER);
        files::new_dir_within(folder, &blocks)?;
        let journal = open(&blocks)?;
        fail_point!("begin.journal");
        let (queue, batches) = mpsc::sync_channel(QUEUE);
        let writer_status = Arc::new(WriterStatus { waiting: AtomicUsize::new(0), free: AtomicU64::new(u64::MAX) });
        writer_status.look(folder);
        let (theirs, at) = (Arc::clone(&writer_status), folder.to_owned());
        let write = move || {
            journal.write(&batches, || {
                theirs.waiting.fetch_sub(1, Ordering::Relaxed);
                theirs.look(&at);
            })
        };
        let writer = std::thread::Builder::new().name("recorder".into()).spawn(write);
        let writer = writer.map_err(RecordError::file(folder))?;
        Ok(Self {
            folder: folder.into(),
            manifest,
            hash: HASH_START,
            batch: RowBatch::default(),
            observer: NetworkObserver::default(),
            unseen: Vec::new(),
            writer_status,
            wheel_force_nm: None,
            queue: Some(queue),
            writer: Some(writer),
            _lock: lock,
        })
    }

    /// Records the network before the first tick, if it has tables; must be called before it.
    pub fn start(&mut self, world: &World) {
        if self.manifest.network_tables {
            self.observer.start(world, &mut self.batch.network);
        }
    }

    /// Sets the mean torque sent to the wheel's motor, N m, for all ticks from here on; `None` without force feedback.
    pub fn force(&mut self, wheel_force_nm: Option<f64>) {
        self.wheel_force_nm = wheel_force_nm;
    }

    /// Records the world after a tick with these controls.
    ///
    /// # Errors
    /// The disk is full or too slow; all earlier rows are kept.
    pub fn tick(&mut self, world: &World, controls: &Controls) -> Result<(), RecordError> {
        let (snapshot, scenario) = (world.snapshot(), world.scenario());
        for event in world.events() {
            if let EventKind::Advice(advice) = event.kind {
                let speed_mps = snapshot.ego_before.speed_mps;
                self.unseen.push(AdviceRow { advice, speed_mps, shown_frame: None, shown_wall_s: None });
            }
            self.batch.events.extend(EventRow::of(event, &scenario.events));
        }
        self.observer.tick(world, &mut self.batch.network);
        self.batch.advised.extend(AdvisedRow::all(world));
        self.add(snapshot, controls, scenario.step_ticks(), &world.map().network)?;
        fail_point!("tick");
        Ok(())
    }

    fn add(
        &mut self,
        snapshot: &Snapshot,
        controls: &Controls,
        step_ticks: u64,
        network: &Network,
    ) -> Result<(), RecordError> {
        self.hash = snapshot.hash(self.hash);
        self.batch.ego.push(EgoRow::of(snapshot, &controls.sane(), self.wheel_force_nm, self.hash));
        if snapshot.tick.0.is_multiple_of(step_ticks) {
            self.batch.cars.extend(CarRow::ego(snapshot, network));
            let cars = recorded_cars(snapshot, self.manifest.network_tables);
            self.batch.cars.extend(cars.map(|car| CarRow::of(snapshot.tick, car, network)));
        }
        if self.batch.ego.len() >= MOST_TICKS { self.hand_over(true) } else { Ok(()) }
    }

    /// Records a frame that was handed to the screen, and its time with the advice that it showed first.
    pub fn frame(&mut self, frame: FrameRow) {
        for mut row in self.unseen.drain(..) {
            row.shown_frame = u32::try_from(frame.frame).ok();
            row.shown_wall_s = Some(frame.wall_s);
            self.batch.advice.push(row);
        }
        self.batch.frames.push(frame);
    }

    /// Records an event from outside the world: a mark, a pause, a note.
    pub fn event(&mut self, tick: Tick, kind: &str, detail: &str) {
        self.batch.events.push(EventRow {
            tick,
            kind: kind.into(),
            detail: detail.into(),
            car: None,
            value: None,
            angle_rad: None,
        });
    }

    /// Records an event from outside the world with a number, such as a rating.
    pub fn event_with_value(&mut self, tick: Tick, kind: &str, detail: &str, value: f64) {
        let (kind, detail) = (kind.into(), detail.into());
        self.batch.events.push(EventRow { tick, kind, detail, car: None, value: Some(value), angle_rad: None });
    }

    /// Passes the gathered rows to the writing thread without waiting; to be called every [`FLUSH_EVERY`].
    ///
    /// # Errors
    /// The disk is full or too slow; all earlier rows are kept.
    pub fn flush(&mut self) -> Result<(), RecordError> {
        self.hand_over(false)
    }

    /// Passes the gathered rows to the writing thread and waits for room in the queue. For drives at full speed, which may be
    /// limited by the disk.
    ///
    /// # Errors
    /// The disk is full; all earlier rows are kept.
    pub fn flush_waiting(&mut self) -> Result<(), RecordError> {
        self.hand_over(true)
    }

    fn hand_over(&mut self, wait: bool) -> Result<(), RecordError> {
        self.batch.advice.append(&mut self.unseen);
        let Some(queue) = &self.queue else { return Err(self.why_stopped()) };
        let batch = std::mem::take(&mut self.batch);
        // Counted before it is sent: the thread may finish it at once.
        self.writer_status.waiting.fetch_add(1, Ordering::Relaxed);
        let sent =
            if wait { queue.send(batch).map_err(|e| TrySendError::Disconnected(e.0)) } else { queue.try_send(batch) };
        match sent {
            Ok(()) => Ok(()),
            Err(TrySendError::Full(_)) => {
                self.note_failure("the disk is too slow");
                Err(RecordError::Full((QUEUE as u32 * FLUSH_EVERY).as_secs()))
            }
            Err(TrySendError::Disconnected(_)) => Err(self.why_stopped()),
        }
    }

    /// Returns the error of the writing thread, after it has stopped.
    fn why_stopped(&mut self) -> RecordError {
        self.queue = None;
        let end = self.writer.take().map(JoinHandle::join);
        let error = match end {
            Some(Ok(Err(error))) => error,
            _ => RecordError::Stopped("the writing thread has ended".into()),
        };
        match &error {
            RecordError::File { why, .. } => self.note_failure(&why.to_string()),
            other => self.note_failure(&other.to_string()),
        }
        error
    }

    /// Writes the reason for the end into the manifest, if the disk has room; recovery keeps it. `why` must not contain paths,
    /// which are private.
    fn note_failure(&mut self, why: &str) {
        self.manifest.ended.get_or_insert_with(|| format!("recording failed: {why}"));
        let _ = self.manifest.save(&self.folder);
    }

    /// Ends the recording: writes all rows to the disk, tables as Parquet, the summary and the final manifest. Returns the
    /// folder.
    ///
    /// # Errors
    /// The disk is full, and the journal stays for `recover`; or the disk lost part of the journal.
    pub fn finish(mut self, summary: &Summary) -> Result<PathBuf, RecordError> {
        self.hand_over(true)?;
        self.queue = None;
        if let Some(writer) = self.writer.take() {
            writer.join().map_err(|_| RecordError::Stopped("the writing thread failed".into()))??;
        }
        fail_point!("finish.begin");
        let written = recover::write_tables(&self.folder, &Table::of(&self.manifest))?;
        let text = serde_json::to_string_pretty(summary).expect("numbers and words");
        files::replace(&self.folder.join("summary.json"), text.as_bytes())?;
        fail_point!("finish.summary");
        self.manifest.checksums = Some(written.checksums.save(&self.folder)?);
        fail_point!("finish.checksums");
        self.manifest.ended.get_or_insert_with(|| summary.end_text());
        self.manifest.hash = Some(format!("{:016x}", self.hash));
        self.manifest.state = RecordingState::Complete;
        self.manifest.seal(&self.folder)?;
        fail_point!("finish.complete");
        let kept = recover::settle_journal(&self.folder, &written.holes)?;
        fail_point!("finish.journal_gone");
        let folder = std::mem::take(&mut self.folder);
        let Some(kept) = kept else { return Ok(folder) };
        let missing: Vec<String> = written.holes.iter().map(ToString::to_string).collect();
        Err(RecordError::Damaged { folder, missing: missing.join("; "), kept })
    }

    /// Replaces the recorded scenario after a change during the drive, such as a longer duration. A replay drives the changed
    /// one.
    ///
    /// # Errors
    /// An I/O error.
    pub fn set_scenario(&self, scenario: &Scenario) -> Result<(), RecordError> {
        files::replace(&self.folder.join("scenario.toml"), scenario.to_toml().as_bytes())
    }

    /// Returns the status of the writing thread.
    pub fn writer_status(&self) -> &WriterStatus {
        &self.writer_status
    }

    /// Returns the folder of the recording.
    pub fn folder(&self) -> &Path {
        &self.folder
    }
}

impl Drop for Recorder {
    /// Keeps the gathered rows of a drive that ends by an error; `recover` makes tables of them.
    fn drop(&mut self) {
        if self.queue.is_some() {
            let _ = self.hand_over(false);
            self.queue = None;
        }
        if let Some(writer) = self.writer.take() {
            let _ = writer.join();
        }
    }
}

#[cfg(test)]
#[path = "recorder_tests.rs"]
mod tests;
