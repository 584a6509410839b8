//! Time of the drive for samples of other devices. In: the journal of the drive's clock, and batches with time stamps of their device and
//! their clock offsets. Out: the batches with the drive time beside each time stamp, s.

use super::{
    RecordError, files,
    streams::{OFFSET, STAMP, StreamColumn, TIME, each_batch},
};
use arrow_array::{Array, Float64Array, RecordBatch};
use arrow_schema::Schema;
use std::{path::Path, sync::Arc};

/// Clock of the drive: pairs of a time of this machine's clock and the drive time, both s.
#[derive(Debug, Default)]
pub(super) struct DriveClock(Vec<[f64; 2]>);

impl DriveClock {
    pub fn read(journal: &Path) -> Result<Self, RecordError> {
        let mut pairs = Vec::new();
        if files::is_there(journal)? {
            // Missing parts are reported when the clock becomes a table.
            each_batch(journal, &mut Vec::new(), &mut |batch| {
                let [stamps, times] = [STAMP, TIME].map(|name| numbers(&batch, name));
                pairs.extend(stamps.into_iter().zip(times).filter_map(|(stamp, time)| Some([stamp?, time?])));
                Ok(())
            })?;
        }
        Ok(Self(pairs))
    }

    /// Returns the drive time at a time of this machine's clock, interpolated between frames; `None` before the first and after
    /// the last.
    fn time_s(&self, lsl_s: f64) -> Option<f64> {
        let after = self.0.partition_point(|[stamp, _]| *stamp <= lsl_s);
        let [from, from_time] = *self.0.get(after.checked_sub(1)?)?;
        let Some([to, to_time]) = self.0.get(after) else { return (from == lsl_s).then_some(from_time) };
        Some(from_time + (to_time - from_time) * (lsl_s - from) / (to - from))
    }

    /// Returns a batch with the drive time added behind time stamps and offsets. A batch without stamps, or with the drive time
    /// already, is returned as it is.
    pub fn with_time(&self, batch: &RecordBatch, journal: &Path) -> Result<RecordBatch, RecordError> {
        let schema = batch.schema();
        let [stamp, time] = [STAMP, TIME].map(|name| schema.index_of(name).ok());
        let (Some(stamp), None) = (stamp, time) else { return Ok(batch.clone()) };
        let offset = schema.index_of(OFFSET).ok();
        let offsets = offset.map_or_else(|| vec![Some(0.0); batch.num_rows()], |_| numbers(batch, OFFSET));
        let stamps = numbers(batch, STAMP).into_iter().zip(offsets);
        // An offset that was never measured does not count as zero.
        let times: Float64Array = stamps.map(|(stamp, offset)| self.time_s(stamp? + offset?)).collect();
        let place = offset.unwrap_or(stamp).max(stamp) + 1;
        let (mut fields, mut columns) = (schema.fields().to_vec(), batch.columns().to_vec());
        let about = "time of the drive at that moment; empty before its start and after its end";
        fields.insert(place, Arc::new(StreamColumn::number(TIME, "s", about).field()));
        columns.insert(place, Arc::new(times));
        let made = RecordBatch::try_new(Arc::new(Schema::new(fields)), columns);
        made.map_err(|e| RecordError::Table { path: journal.into(), why: e.to_string() })
    }
}

fn numbers(batch: &RecordBatch, name: &str) -> Vec<Option<f64>> {
    let column = batch.column_by_name(name).and_then(|column| column.as_any().downcast_ref::<Float64Array>());
    column.map_or_else(|| vec![None; batch.num_rows()], |column| column.iter().collect())
}
