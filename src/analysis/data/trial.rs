//! One recorded drive, read from front to back. In: a recording's folder. Out: a [`RecordedTrial`], and its rows one by one: a
//! drive of days takes no more memory than one of minutes. SI units; seconds since the start of the drive.

use super::{
    advice::{AdviceChange, ChangeFinder, IssuedAdvice, ShownFrames},
    ego_samples::{EGO, EgoSamples},
    frame_times::{self, FrameTimes},
    road_events::RoadEvents,
    setup::DriveSetup,
    traffic_steps::TrafficSteps,
    trips::TripTable,
};
use crate::analysis::error::AnalysisError;
use crate::{
    map::RoadMap,
    record::{self, RecordError, Table, TableParts, TableReader, tables::PUT_BACK},
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
        for part in trial.parts(Table::Events, &["tick", "event", "value"])? {
            let part = part?;
            let rows = part.wholes("tick").into_iter().zip(part.words("event").into_iter().zip(part.numbers("value")));
            for (tick, (kind, value)) in rows {
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
        let mut finder = ChangeFinder::default();
        let mut frames = ShownFrames::new(trial.parts(Table::Frames, &["frame", "tick"])?);
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
        Ok(trial)
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
