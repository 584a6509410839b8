//! One recorded drive, read from front to back. In: a recording's folder. Out: a [`RecordedTrial`], and its rows one by one: a
//! drive of days takes no more memory than one of minutes. SI units; seconds since the start of the drive.

use super::{
    advice::{AdviceChange, ChangeFinder, IssuedAdvice, ShownFrames},
    ego_samples::{EGO, EgoSamples},
    frame_times::{self, FrameTimes},
    gaze,
    road_events::RoadEvents,
    scripted_moments::{self, ScriptedMoment},
    setup::DriveSetup,
    traffic_steps::TrafficSteps,
    trips::TripTable,
};
use crate::analysis::error::AnalysisError;
use crate::{
    map::RoadMap,
    metrics::{AutomationChange, GazeSample, QuestionChange, TaskLog, TaskResponse, TaskStimulus},
    record::{
        self, RecordError, Table, TableParts, TableReader,
        tables::{NOT_SCORED, PUT_BACK, SHUTTER, SHUTTER_OPENS, TASK_RESPONSE, TASK_STIMULUS},
    },
    time::{TICKS_PER_S, Tick},
};
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

/// Time after a contact, or after the car was put back, in which the speed is not the driver's choice, seconds.
pub const AFTER_CONTACT_S: f64 = 2.0;
/// Largest number of contacts, red lights and marks that are listed one by one.
const MOST_MOMENTS: usize = 100;

/// A recorded drive: short facts in memory, rows on disk.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RecordedTrial {
    /// Folder of the recording.
    pub recording: PathBuf,
    /// Setup: manifest, scenario and length of the route.
    pub setup: DriveSetup,
    /// Map of the drive; `None` if it is missing.
    pub map: Option<Arc<RoadMap>>,
    /// First advice of the drive; `None` without advice.
    pub first_advice: Option<IssuedAdvice>,
    /// Changes of the advice.
    pub changes: Vec<AdviceChange>,
    /// Number of contacts with other vehicles.
    pub contacts: usize,
    /// Time, seconds, and closing speed, m/s, of the first contacts.
    pub contacts_at: Vec<[f64; 2]>,
    /// Violations of traffic rules by the ego on a network.
    pub road_events: RoadEvents,
    /// Times of the first red lights that the ego drove over, seconds.
    pub red_lights_at: Vec<f64>,
    /// Times of the first marks of the experimenter, seconds.
    pub marks_at: Vec<f64>,
    /// Spans from a contact, or from a car put back on its lane, to [`AFTER_CONTACT_S`] later, ticks; sorted and disjoint.
    pub after_contacts: Vec<[u64; 2]>,
    /// Events of the scenario that were seen.
    pub scripted: Vec<ScriptedMoment>,
    /// Events of the secondary task; a stimulus has the tick of the first frame that showed it.
    pub task: TaskLog,
    /// Changes of the automation, with their ticks.
    pub automation_changes: Vec<(Tick, AutomationChange)>,
    /// Gaze of the participant in a drive with takeover requests, if an eye tracker sent it.
    pub gaze: Vec<GazeSample>,
    /// Number of times that the middle of the car left its lane.
    pub left_road: usize,
    /// Times of the frames that the participant saw.
    pub frames: FrameTimes,
    /// Reason of the end, one word.
    pub ended: String,
}

impl RecordedTrial {
    /// Opens a recording.
    ///
    /// # Errors
    /// There is none, it was cut, it does not have this program's format, it has no participant, or its advice changes more
    /// often than [`MOST_CHANGES`](super::advice::MOST_CHANGES).
    pub fn open(recording: &Path) -> Result<Self, AnalysisError> {
        let manifest = record::open(recording)?;
        let scenario = record::inputs::scenario(recording).map_err(|e| AnalysisError::Input(e.message))?;
        if !scenario.participant {
            let text = format!(
                "{}: the drive has no participant, and the analysis is of a participant's driving\n  remedy: read the \
                 tables cars and advised of the recording",
                recording.display()
            );
            return Err(AnalysisError::Input(text));
        }
        let map = scenario.load_map().ok().map(Arc::new);
        let route_m = map.as_ref().map_or(0.0, |map| map.route.length_m());
        let mut trial = Self {
            recording: recording.into(),
            ended: manifest.ended.clone().unwrap_or_default(),
            setup: DriveSetup { route_m, manifest, scenario },
            map,
            ..Self::default()
        };
        for part in trial.parts(Table::Events, &["tick", "event", "detail", "car", "value"])? {
            let part = part?;
            let [kinds, details] = ["event", "detail"].map(|name| part.words(name));
            let values = part.ids("car").into_iter().zip(part.numbers("value"));
            let rows = part.wholes("tick").into_iter().zip(kinds).zip(details.into_iter().zip(values));
            for ((tick, kind), (detail, (vehicle, value))) in rows {
                scripted_moments::add(&mut trial.scripted, tick, [&kind, &detail], vehicle);
                let change = AutomationChange::of_words(&kind, &detail, value);
                trial.automation_changes.extend(change.map(|change| (Tick(tick), change)));
                add_to_log(&mut trial.task, Tick(tick), [&kind, &detail], value);
                trial.contacts += usize::from(kind == "contact");
                trial.left_road += usize::from(kind == "left_road");
                trial.road_events.add(tick, &kind);
                let time_s = Tick(tick).seconds();
                if matches!(kind.as_str(), "contact" | "object_contact") || kind == PUT_BACK {
                    trial.collided(tick);
                }
                if kind == "contact" && trial.contacts_at.len() < MOST_MOMENTS {
                    trial.contacts_at.push([time_s, value.unwrap_or_default()]);
                } else if kind == "red_light" && trial.red_lights_at.len() < MOST_MOMENTS {
                    trial.red_lights_at.push(time_s);
                } else if kind == "mark" && trial.marks_at.len() < MOST_MOMENTS {
                    trial.marks_at.push(time_s);
                }
            }
        }
        trial.count_from_frames()?;
        let mut finder = ChangeFinder::default();
        let mut frames = trial.shown_frames()?;
        for part in
            trial.parts(Table::Advice, &["tick", "target_mps", "range_low_mps", "range_high_mps", "shown_frame"])?
        {
            for advice in frames.advice(&part?)? {
                trial.first_advice.get_or_insert(advice);
                finder.add(&advice).map_err(|why| {
                    AnalysisError::Input(format!("{}: {why}", Table::Advice.parquet(recording).display()))
                })?;
            }
        }
        trial.changes = finder.changes;
        trial.frames = FrameTimes::read(trial.parts(Table::Frames, &frame_times::COLUMNS)?)?;
        let is_request = |(_, change): &(Tick, AutomationChange)| matches!(change, AutomationChange::Request { .. });
        if trial.automation_changes.iter().any(is_request) {
            let size = trial.setup.manifest.screen.as_ref().map_or([1, 1], |screen| screen.size);
            trial.gaze = gaze::read(recording, size)?;
        }
        Ok(trial)
    }

    /// Replaces the ticks of stimuli and of onsets of events by those of the first frames that showed them.
    fn count_from_frames(&mut self) -> Result<(), RecordError> {
        // A drive with a question has its event.
        if self.task.stimuli.is_empty() && self.scripted.is_empty() {
            return Ok(());
        }
        let mut frames = self.shown_frames()?;
        let TaskLog { stimuli, questions, .. } = &mut self.task;
        let stimuli = stimuli.iter_mut().map(|(tick, _)| &mut tick.0);
        let asked = questions.iter_mut().filter(|(_, change)| *change == QuestionChange::Asked);
        let shown = stimuli.chain(asked.map(|(tick, _)| &mut tick.0));
        let mut ticks: Vec<&mut u64> = shown.chain(self.scripted.iter_mut().map(|moment| &mut moment.onset)).collect();
        ticks.sort_unstable();
        ticks.into_iter().try_for_each(|tick| {
            *tick = frames.shown_tick(*tick)?;
            Ok(())
        })
    }

    fn shown_frames(&self) -> Result<ShownFrames, RecordError> {
        Ok(ShownFrames::new(self.parts(Table::Frames, &["frame", "tick"])?))
    }

    /// Marks a collision: from this tick on, the driver does not choose the speed for [`AFTER_CONTACT_S`].
    pub(crate) fn collided(&mut self, tick: u64) {
        let until = tick + (AFTER_CONTACT_S * f64::from(TICKS_PER_S)) as u64;
        match self.after_contacts.last_mut().filter(|last| last[1] >= tick) {
            Some(last) => last[1] = until,
            None => self.after_contacts.push([tick, until]),
        }
    }

    fn parts(&self, table: Table, columns: &[&str]) -> Result<TableParts, RecordError> {
        TableReader::parts(&table.parquet(&self.recording), columns)
    }

    /// Reads the ego's rows at every tick, in order.
    ///
    /// # Errors
    /// The table cannot be read, or does not have this program's format; each row can fail in the same way.
    pub fn ego(&self) -> Result<EgoSamples, RecordError> {
        let path = Table::Ego.parquet(&self.recording);
        let lengths = |table: TripTable| table.trips.into_iter().filter_map(|(id, trip)| Some((id, trip.length_m?)));
        let lengths_m = self.trips()?.map(|table| lengths(table).collect());
        let parts = TableReader::parts(&path, &EGO)?;
        Ok(EgoSamples::new(path, parts, lengths_m))
    }

    /// Reads the trips of the vehicles that entered and left; `None` if the recording has no tables of them.
    ///
    /// # Errors
    /// A table cannot be read, or does not have this program's format.
    pub fn trips(&self) -> Result<Option<TripTable>, RecordError> {
        self.has(Table::Departures).then(|| TripTable::read(&self.recording)).transpose()
    }

    /// Returns true if the recording has this table.
    pub fn has(&self, table: Table) -> bool {
        Table::of(&self.setup.manifest).contains(&table)
    }

    /// Reads all vehicles with a row, without persons on foot, at every step in order.
    ///
    /// # Errors
    /// The table cannot be read; each step can fail in the same way.
    pub fn steps(&self) -> Result<TrafficSteps, RecordError> {
        let network = self.map.as_ref().map(|map| Arc::clone(&map.network));
        let persons = self.trips()?.map(|table| table.persons).unwrap_or_default();
        TrafficSteps::open(&Table::Cars.parquet(&self.recording), network, persons)
    }
}

/// Adds a row of the table of events, by its kind and its detail, to the log of the secondary task; other kinds have no effect.
fn add_to_log(log: &mut TaskLog, tick: Tick, [kind, detail]: [&str; 2], value: Option<f64>) {
    match kind {
        TASK_STIMULUS => log.stimuli.extend(TaskStimulus::of_words(detail, value).map(|stimulus| (tick, stimulus))),
        TASK_RESPONSE => log.responses.extend(TaskResponse::of_words(detail, value).map(|response| (tick, response))),
        NOT_SCORED => value.into_iter().for_each(|onset_s| log.leave_unscored(Tick::at_seconds(onset_s))),
        SHUTTER => log.shutter.push((tick, detail == SHUTTER_OPENS)),
        _ => log.questions.extend(QuestionChange::of_words(kind, detail, value).map(|change| (tick, change))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        controls::{Controls, TaskButton},
        record::{Manifest, Recorder, tables::FrameRow},
        scenario::{Scenario, SecondaryTask, SecondaryTaskKind},
        sim::{EventKind, SummaryAccumulator, World},
        traffic::EngineChoice,
    };

    #[test]
    fn response_times_count_from_the_frame_that_showed_the_stimulus() {
        let secondary_task = SecondaryTask { kind: SecondaryTaskKind::DetectionResponse, ..SecondaryTask::default() };
        let (traffic, vehicles, duration_s) = (EngineChoice::Native, 2, 12.0);
        let scenario = Scenario { traffic, vehicles, duration_s, secondary_task, ..Scenario::default() };
        let folder = tempfile::tempdir().expect("a folder");
        let mut world = World::new(&scenario).expect("the native engine");
        let mut recorder =
            Recorder::begin(&folder.path().join("drive"), &scenario, Manifest::default()).expect("a new folder");
        let mut summary = SummaryAccumulator::new([0.0, f64::INFINITY]);
        let (mut due, mut onsets) = (None, Vec::new());
        while world.ended().is_none() {
            let tick = world.snapshot().tick.0 + 1;
            let task_button = if due == Some(tick) { TaskButton::Respond } else { TaskButton::None };
            let controls = Controls { task_button, ..Controls::default() };
            world.tick(&controls).expect("the native engine");
            summary.add(world.snapshot(), world.events());
            recorder.tick(&world, &controls).expect("room");
            if world.events().iter().any(|event| matches!(event.kind, EventKind::TaskStimulus(_))) {
                onsets.push(tick);
                due = Some(tick + 50);
            }
            // A frame at each seventh tick.
            if tick.is_multiple_of(7) {
                let frame = FrameRow {
                    frame: 0,
                    tick: Tick(tick),
                    fraction: 0.0,
                    wall_s: 0.0,
                    elapsed_s: 0.07,
                    dropped_s: 0.0,
                    latency_s: None,
                    input_to_tick_s: None,
                    flash: None,
                };
                recorder.frame(FrameRow { frame: tick / 7, ..frame });
            }
        }
        let summary = summary.to_summary();
        let recording = recorder.finish(&summary).expect("room");
        let trial = RecordedTrial::open(&recording).expect("a recording");
        let shown: Vec<u64> = onsets.iter().map(|onset| onset.div_ceil(7) * 7).collect();
        assert!(shown.len() >= 2 && shown != onsets, "{onsets:?}");
        assert_eq!(trial.task.stimuli.iter().map(|stimulus| stimulus.0.0).collect::<Vec<_>>(), shown);
        // Each press comes 0.5 s after its onset, also in the summary; the last signal may have none.
        let answered = trial.task.responses.len();
        let late: u64 = shown.iter().zip(&onsets).take(answered).map(|(shown, onset)| shown - onset).sum();
        let expected_s = 0.5 - late as f64 / 100.0 / answered as f64;
        let mean_s = |scores: crate::metrics::TaskScores| scores.detection.and_then(|score| score.detection_response_s);
        let [from_frames, from_ticks] = [trial.task.scores(duration_s), summary.secondary_task].map(mean_s);
        assert!((from_frames.expect("hits") - expected_s).abs() < 1e-9, "{from_frames:?}");
        assert!((from_ticks.expect("hits") - 0.5).abs() < 1e-9, "{from_ticks:?}");
    }
}
