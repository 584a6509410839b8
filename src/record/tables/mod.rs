//! Tables of a recording: their names, their files and the rows to be written. A table and its columns are in a file of its name,
//! those of networks in `networks`. In: rows. Out: the columns of a table, and the tick of a row.

mod advice;
mod advised;
mod cars;
mod ego;
mod events;
mod frames;
mod networks;

pub use advice::{ADVICE, AdviceRow};
pub use advised::{ADVISED, AdvisedRow};
pub use cars::{CARS, CarRow, recorded_cars};
pub use ego::{EGO, EgoRow, selector_word};
pub use events::{
    ADVICE_WITHHELD, EVENTS, EventRow, NOT_SCORED, PUT_BACK, SHUTTER, SHUTTER_OPENS, TASK_RESPONSE, TASK_STIMULUS,
};
pub use frames::{FRAMES, FrameRow};
pub use networks::{ARRIVALS, ArrivalRow, DEPARTURES, DepartureRow, PATH, PathRow, SIGNALS, SignalRow};
pub(super) use networks::{NetworkObserver, NetworkRows};

use super::{
    Manifest,
    table::{self, ColumnValue, TableColumn},
};
use crate::time::Tick;
use arrow_schema::Schema;
use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

/// Table of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Table {
    /// One row for each tick.
    Ego,
    /// One row for each vehicle and step.
    Cars,
    /// One row for each advice.
    Advice,
    /// One row for each frame.
    Frames,
    /// One row for each event.
    Events,
    /// One row for each vehicle that has entered; only on a network.
    Departures,
    /// One row for each vehicle that has left; only on a network.
    Arrivals,
    /// One row for each signal at the start and for each change; only on a network.
    Signals,
    /// One row for each lane of the ego's path; only on a network.
    Path,
    /// One row for each step and advised vehicle other than the ego; only if there are such vehicles.
    Advised,
}

impl Table {
    /// All tables. Journals identify a table by its index here, so a new one goes to the end.
    pub const ALL: [Self; 10] = [
        Self::Ego,
        Self::Cars,
        Self::Advice,
        Self::Frames,
        Self::Events,
        Self::Departures,
        Self::Arrivals,
        Self::Signals,
        Self::Path,
        Self::Advised,
    ];
    /// Tables of every recording; the others belong to drives on networks or with several advised vehicles.
    pub const OF_EVERY_DRIVE: [Self; 5] = [Self::Ego, Self::Cars, Self::Advice, Self::Frames, Self::Events];
    /// Tables of drives on a network only.
    pub const OF_NETWORKS: [Self; 4] = [Self::Departures, Self::Arrivals, Self::Signals, Self::Path];

    /// Returns the tables that a recording has.
    pub fn of(manifest: &Manifest) -> Vec<Self> {
        let belongs = |table: &Self| match table {
            Self::Advised => manifest.advised_table,
            table => manifest.network_tables || !Self::OF_NETWORKS.contains(table),
        };
        Self::ALL.into_iter().filter(belongs).collect()
    }

    /// Returns the name of the table, as in its file name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ego => "ego",
            Self::Cars => "cars",
            Self::Advice => "advice",
            Self::Frames => "frames",
            Self::Events => "events",
            Self::Departures => "departures",
            Self::Arrivals => "arrivals",
            Self::Signals => "signals",
            Self::Path => "path",
            Self::Advised => "advised",
        }
    }

    /// Returns the path of the table's file in a finished recording.
    pub fn parquet(self, recording: &Path) -> PathBuf {
        recording.join(format!("{}.parquet", self.name()))
    }
}

/// Returns the tick of a row. Every table has a column `tick` except the path, which counts as tick 0.
pub(super) fn tick<R>(columns: &[TableColumn<R>], row: &R) -> Tick {
    let ticks = columns.iter().find(|column| column.name == "tick");
    Tick(ticks.map_or(0, |column| match column.get {
        ColumnValue::Whole(get) => get(row),
        _ => 0,
    }))
}

/// Rows to be written to the disk.
#[derive(Debug, Default)]
pub(super) struct RowBatch {
    pub ego: Vec<EgoRow>,
    pub cars: Vec<CarRow>,
    pub advice: Vec<AdviceRow>,
    pub frames: Vec<FrameRow>,
    pub events: Vec<EventRow>,
    pub network: NetworkRows,
    pub advised: Vec<AdvisedRow>,
}

/// Returns the columns of a table as an Arrow schema.
pub(super) fn schema(table: Table) -> Arc<Schema> {
    match table {
        Table::Ego => table::schema(EGO),
        Table::Cars => table::schema(CARS),
        Table::Advice => table::schema(ADVICE),
        Table::Frames => table::schema(FRAMES),
        Table::Events => table::schema(EVENTS),
        Table::Departures => table::schema(DEPARTURES),
        Table::Arrivals => table::schema(ARRIVALS),
        Table::Signals => table::schema(SIGNALS),
        Table::Path => table::schema(PATH),
        Table::Advised => table::schema(ADVISED),
    }
}

#[cfg(test)]
mod tests;
