//! Comparison of a recording with the same drive, driven again. In: the tables of a recording, and the world driven again with
//! the recorded controls. Out: the first cell that differs in any bit, and the number of such cells. Rows are read batch by
//! batch, so memory does not grow with the length of the drive.
//!
//! Values that no simulation makes are not compared here: times of devices and frames, the wheel's force, marks and notes.
//! `checksums.json` has the checksums of those values.

use super::{
    Manifest, RecordError, Table,
    table::{ColumnValue, TableBatches, TableColumn},
    tables::{
        self, ADVICE, ADVISED, ARRIVALS, AdviceRow, AdvisedRow, CARS, CarRow, DEPARTURES, EGO, EVENTS, EgoRow,
        EventRow, NetworkObserver, NetworkRows, PATH, SIGNALS, recorded_cars,
    },
};
use crate::{
    controls::{Controls, Indicator, Selector, TaskButton},
    sim::{EventKind, HASH_START, World},
    time::Tick,
};
use arrow_array::{Array, ArrayRef, BooleanArray, Float64Array, RecordBatch, StringArray, UInt32Array, UInt64Array};
use std::{collections::BTreeMap, fmt, path::Path};

/// Columns that no simulation makes.
pub const OF_DEVICES: [&str; 3] = ["wheel_force_nm", "shown_frame", "shown_wall_s"];

/// Cell that differs from the recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellDifference {
    /// Table of the cell.
    pub table: Table,
    /// Number of the row, from 0.
    pub row: u64,
    /// Tick of the row.
    pub tick: Tick,
    /// Name of the column.
    pub column: String,
    /// Recorded value; empty if the recording lacks the row.
    pub recorded: String,
    /// Value of the drive driven again; empty if it lacks the row.
    pub driven: String,
}

impl fmt::Display for CellDifference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let or = |text: &str| if text.is_empty() { "nothing".to_owned() } else { text.to_owned() };
        let Self { table, row, tick, column, recorded, driven } = self;
        let (name, time_s, recorded, driven) = (table.name(), tick.seconds(), or(recorded), or(driven));
        write!(
            f,
            "{name}.parquet, row {row} ({time_s:.2} s), column {column}: recorded {recorded}, driven again {driven}"
        )
    }
}

/// Comparison of all tables of a recording with a running world.
pub struct TableComparison {
    ego: TableCursor,
    cars: TableCursor,
    advice: TableCursor,
    events: TableCursor,
    /// `None` if the recording has no network tables.
    network: Option<NetworkCursors>,
    /// `None` if the recording has no table of other advised vehicles.
    advised: Option<TableCursor>,
    observer: NetworkObserver,
    hash: u64,
    found: Differences,
}

/// Differences found so far.
#[derive(Default)]
struct Differences {
    first: Option<CellDifference>,
    cells: u64,
    /// Number of differing cells, by table name and column name.
    columns: BTreeMap<(&'static str, String), u64>,
}

impl Differences {
    fn add(&mut self, difference: CellDifference) {
        self.cells += 1;
        *self.columns.entry((difference.table.name(), difference.column.clone())).or_default() += 1;
        self.first.get_or_insert(difference);
    }
}

impl TableComparison {
    /// Opens the tables of a finished recording that a drive of this world has.
    ///
    /// # Errors
    /// A table cannot be read.
    pub fn open(recording: &Path, world: &World) -> Result<Self, RecordError> {
        let network_tables = Manifest::load(recording)?.network_tables;
        let cursor = |table| TableCursor::open(recording, table);
        Ok(Self {
            ego: cursor(Table::Ego)?,
            cars: cursor(Table::Cars)?,
            advice: cursor(Table::Advice)?,
            events: cursor(Table::Events)?,
            network: network_tables.then(|| NetworkCursors::open(recording)).transpose()?,
            advised: world.has_other_agents().then(|| cursor(Table::Advised)).transpose()?,
            observer: NetworkObserver::default(),
            hash: HASH_START,
            found: Differences::default(),
        })
    }

    /// Compares the world before its first tick; only networks have rows then.
    ///
    /// # Errors
    /// A table cannot be read further.
    pub fn start(&mut self, world: &World) -> Result<(), RecordError> {
        let mut rows = NetworkRows::default();
        if self.network.is_some() {
            self.observer.start(world, &mut rows);
        }
        self.compare_network(&rows)
    }

    /// Returns the controls of tick `due`, which must come next; `None` at the end of the recording or at a hole.
    ///
    /// # Errors
    /// The table is not as this program writes it.
    pub fn controls(&mut self, due: Tick) -> Result<Option<Controls>, RecordError> {
        if !self.ego.has_row()? || self.ego.tick() != due {
            return Ok(None);
        }
        let ego = &self.ego;
        let [throttle, brake, wheel] = ["throttle", "brake", "steering_wheel_rad"].map(|name| ego.number(name));
        let word = ego.word("selector");
        let selectors = [Selector::Drive, Selector::Neutral, Selector::Reverse];
        let selector = selectors.into_iter().find(|s| word == Some(tables::selector_word(*s)));
        let word = ego.word("indicator");
        let indicator = Indicator::ALL.into_iter().find(|side| word == Some(side.name()));
        let word = ego.word("task_button");
        let task_button = TaskButton::ALL.into_iter().find(|button| word == Some(button.name()));
        let automation_buttons = ego.flag("automation_button").zip(ego.flag("gap_button"));
        let presses = task_button.zip(automation_buttons);
        let words = selector.zip(indicator).zip(ego.flag("main_beam").zip(presses));
        match (throttle, brake, wheel, words) {
            (Some(throttle), Some(brake), Some(wheel), Some(((selector, indicator), (main_beam, (task_button, (automation_button, gap_button)))))) => Ok(Some(Controls {
                throttle: throttle as f32,
                brake: brake as f32,
                steering_wheel_rad: wheel as f32,
                selector,
                indicator,
                main_beam,
                task_button,
                automation_button,
                gap_button,
                // Empty without force feedback.
                hand_torque_nm: ego.number("hand_torque_nm").map(|torque_nm| torque_nm as f32),
            })),
            _ => Err(ego.batches_error(
                "columns throttle, brake, steering_wheel_rad, selector, indicator, main_beam, task_button, automation_button or gap_button are not as this program writes them",
            )),
        }
    }

    /// Compares the world's rows after a tick with the recorded ones. `controls` are those of that tick.
    ///
    /// # Errors
    /// A table cannot be read further.
    pub fn tick(&mut self, world: &World, controls: &Controls) -> Result<(), RecordError> {
        let (snapshot, scenario) = (world.snapshot(), world.scenario());
        self.hash = snapshot.hash(self.hash);
        for event in world.events() {
            if let EventKind::Advice(advice) = event.kind {
                let speed_mps = snapshot.ego_before.speed_mps;
                let row = AdviceRow { advice, speed_mps, shown_frame: None, shown_wall_s: None };
                self.advice.compare(ADVICE, &row, &mut self.found)?;
            }
            if let Some(row) = EventRow::of(event, &scenario.events) {
                // Marks, pauses and notes lie between the world's events.
                while self.events.has_row()? && self.events.is_by_hand() {
                    self.events.skip();
                }
                self.events.compare(EVENTS, &row, &mut self.found)?;
            }
        }
        self.ego.compare(EGO, &EgoRow::of(snapshot, &controls.sane(), None, self.hash), &mut self.found)?;
        if snapshot.tick.0.is_multiple_of(scenario.step_ticks()) {
            let network = &world.map().network;
            if let Some(ego) = CarRow::ego(snapshot, network) {
                self.cars.compare(CARS, &ego, &mut self.found)?;
            }
            for car in recorded_cars(snapshot, self.network.is_some()) {
                self.cars.compare(CARS, &CarRow::of(snapshot.tick, car, network), &mut self.found)?;
            }
        }
        self.compare_advised(world)?;
        let mut rows = NetworkRows::default();
        self.observer.tick(world, &mut rows);
        self.compare_network(&rows)
    }

    fn compare_advised(&mut self, world: &World) -> Result<(), RecordError> {
        let Some(cursor) = &mut self.advised else { return Ok(()) };
        AdvisedRow::all(world).try_for_each(|row| cursor.compare(ADVISED, &row, &mut self.found))
    }

    fn compare_network(&mut self, rows: &NetworkRows) -> Result<(), RecordError> {
        let Some(cursors) = &mut self.network else { return Ok(()) };
        let NetworkCursors { departures, arrivals, signals, path } = cursors;
        let found = &mut self.found;
        rows.departures.iter().try_for_each(|row| departures.compare(DEPARTURES, row, found))?;
        rows.arrivals.iter().try_for_each(|row| arrivals.compare(ARRIVALS, row, found))?;
        rows.signals.iter().try_for_each(|row| signals.compare(SIGNALS, row, found))?;
        rows.path.iter().try_for_each(|row| path.compare(PATH, row, found))
    }

    /// Counts the recorded rows left over after all ticks to `last` were driven. `is_cut` is true for a drive that was cut: the
    /// journal may hold steps whose ticks are lost, so later rows do not count.
    ///
    /// # Errors
    /// A table cannot be read further.
    pub fn end(&mut self, last: Tick, is_cut: bool) -> Result<(), RecordError> {
        let network = self.network.as_mut().into_iter().flat_map(NetworkCursors::all);
        let others = network.chain(self.advised.as_mut());
        for cursor in [&mut self.cars, &mut self.advice, &mut self.events].into_iter().chain(others) {
            while cursor.has_row()? && (!is_cut || cursor.tick() <= last) {
                if !(cursor.table == Table::Events && cursor.is_by_hand()) {
                    self.found.add(cursor.surplus());
                }
                cursor.skip();
            }
        }
        Ok(())
    }

    /// Returns the first differing cell; `None` if all bits are equal so far.
    pub fn first(&self) -> Option<&CellDifference> {
        self.found.first.as_ref()
    }

    /// Returns the number of differing cells so far, including missing and surplus rows.
    pub fn cells(&self) -> u64 {
        self.found.cells
    }

    /// Returns the number of differing cells so far, by table name and column name.
    pub fn columns(&self) -> &BTreeMap<(&'static str, String), u64> {
        &self.found.columns
    }
}

/// Cursors of the tables of a network.
struct NetworkCursors {
    departures: TableCursor,
    arrivals: TableCursor,
    signals: TableCursor,
    path: TableCursor,
}

impl NetworkCursors {
    fn open(recording: &Path) -> Result<Self, RecordError> {
        let cursor = |table| TableCursor::open(recording, table);
        Ok(Self {
            departures: cursor(Table::Departures)?,
            arrivals: cursor(Table::Arrivals)?,
            signals: cursor(Table::Signals)?,
            path: cursor(Table::Path)?,
        })
    }

    fn all(&mut self) -> [&mut TableCursor; 4] {
        [&mut self.departures, &mut self.arrivals, &mut self.signals, &mut self.path]
    }
}

/// Table of a recording, read row by row.
struct TableCursor {
    table: Table,
    batches: TableBatches,
    batch: Option<RecordBatch>,
    /// Index of the row in the batch, and number of rows in earlier batches.
    at: usize,
    before: u64,
}

impl TableCursor {
    fn open(recording: &Path, table: Table) -> Result<Self, RecordError> {
        let batches = TableBatches::open(&table.parquet(recording))?;
        Ok(Self { table, batches, batch: None, at: 0, before: 0 })
    }

    fn batches_error(&self, why: &str) -> RecordError {
        RecordError::Table { path: self.batches.path().into(), why: why.into() }
    }

    /// Checks whether there is a current row; reads the next batch if needed.
    fn has_row(&mut self) -> Result<bool, RecordError> {
        while self.batch.as_ref().is_none_or(|batch| self.at >= batch.num_rows()) {
            let Some(next) = self.batches.next().transpose()? else { return Ok(false) };
            self.before += self.batch.take().map_or(0, |batch| batch.num_rows() as u64);
            self.at = 0;
            self.batch = Some(next);
        }
        Ok(true)
    }

    fn skip(&mut self) {
        self.at += 1;
    }

    fn array<A: Array + 'static>(&self, name: &str) -> Option<&A> {
        let array: &ArrayRef = self.batch.as_ref()?.column_by_name(name)?;
        array.as_any().downcast_ref::<A>().filter(|array| self.at < array.len() && array.is_valid(self.at))
    }

    fn tick(&self) -> Tick {
        Tick(self.array::<UInt64Array>("tick").map_or(0, |ticks| ticks.value(self.at)))
    }

    fn number(&self, name: &str) -> Option<f64> {
        self.array::<Float64Array>(name).map(|values| values.value(self.at))
    }

    fn flag(&self, name: &str) -> Option<bool> {
        self.array::<BooleanArray>(name).map(|flags| flags.value(self.at))
    }

    fn word(&self, name: &str) -> Option<&str> {
        self.array::<StringArray>(name).map(|words| words.value(self.at))
    }

    /// Returns the current row as a surplus row, identified by its tick or, in a table without ticks, by its first column.
    fn surplus(&self) -> CellDifference {
        let schema = self.batch.as_ref().map(RecordBatch::schema);
        let first = schema.as_ref().filter(|schema| schema.index_of("tick").is_err()).map(|schema| schema.field(0));
        let name = first.map_or("tick", |field| field.name().as_str());
        let value = self.array::<UInt64Array>(name).map_or(0, |values| values.value(self.at));
        self.difference(name, value.to_string(), String::new())
    }

    /// Checks whether the event was made by a person or a window, not by the world.
    fn is_by_hand(&self) -> bool {
        !self.word("event").is_some_and(EventRow::is_of_world)
    }

    /// Compares the current row with the driven one and moves on. A row of another tick counts as one cell, surplus or missing,
    /// and the tables stay aligned.
    fn compare<R>(
        &mut self,
        columns: &[TableColumn<R>],
        driven: &R,
        found: &mut Differences,
    ) -> Result<(), RecordError> {
        let tick = tables::tick(columns, driven);
        while self.has_row()? && self.tick() < tick {
            found.add(self.surplus());
            self.skip();
        }
        if !self.has_row()? || self.tick() > tick {
            let named = columns.iter().find(|column| column.name == "tick").or(columns.first());
            let (name, value) = named.map_or(("tick", String::new()), |column| (column.name, text(column, driven)));
            found.add(CellDifference { tick, ..self.difference(name, String::new(), value) });
            return Ok(());
        }
        // The hash chain differs wherever anything does, so it is reported last.
        let (chain, others): (Vec<_>, Vec<_>) = columns
            .iter()
            .filter(|column| !OF_DEVICES.contains(&column.name) && !self.is_equal(column, driven))
            .partition(|column| column.name == "hash");
        for column in others.into_iter().chain(chain) {
            found.add(self.difference(column.name, self.cell(column), text(column, driven)));
        }
        self.skip();
        Ok(())
    }

    fn is_equal<R>(&self, column: &TableColumn<R>, driven: &R) -> bool {
        let name = column.name;
        match column.get {
            ColumnValue::Number(get) => self.number(name).map(f64::to_bits) == get(driven).map(f64::to_bits),
            ColumnValue::Whole(get) => self.array::<UInt64Array>(name).map(|a| a.value(self.at)) == Some(get(driven)),
            ColumnValue::Id(get) => self.array::<UInt32Array>(name).map(|a| a.value(self.at)) == get(driven),
            ColumnValue::Flag(get) => self.array::<BooleanArray>(name).map(|a| a.value(self.at)) == get(driven),
            ColumnValue::Word(get) => self.word(name) == Some(&get(driven)),
        }
    }

    /// Returns the current cell as text.
    fn cell<R>(&self, column: &TableColumn<R>) -> String {
        let (name, at) = (column.name, self.at);
        let found = match column.get {
            ColumnValue::Number(_) => self.number(name).map(|v| v.to_string()),
            ColumnValue::Whole(_) => self.array::<UInt64Array>(name).map(|a| a.value(at).to_string()),
            ColumnValue::Id(_) => self.array::<UInt32Array>(name).map(|a| a.value(at).to_string()),
            ColumnValue::Flag(_) => self.array::<BooleanArray>(name).map(|a| a.value(at).to_string()),
            ColumnValue::Word(_) => self.word(name).map(|word| format!("{word:?}")),
        };
        found.unwrap_or_else(|| "empty".into())
    }

    fn difference(&self, column: &str, recorded: String, driven: String) -> CellDifference {
        let (table, row) = (self.table, self.before + self.at as u64);
        CellDifference { table, row, tick: self.tick(), column: column.into(), recorded, driven }
    }
}

/// Returns the driven cell as text.
fn text<R>(column: &TableColumn<R>, row: &R) -> String {
    let found = match column.get {
        ColumnValue::Number(get) => get(row).map(|v| v.to_string()),
        ColumnValue::Whole(get) => Some(get(row).to_string()),
        ColumnValue::Id(get) => get(row).map(|v| v.to_string()),
        ColumnValue::Flag(get) => get(row).map(|v| v.to_string()),
        ColumnValue::Word(get) => Some(format!("{:?}", get(row))),
    };
    found.unwrap_or_else(|| "empty".into())
}

#[cfg(test)]
#[path = "compare_tests.rs"]
mod tests;
