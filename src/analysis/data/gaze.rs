//! Gaze of a participant, from the stream of an eye tracker in a recording. In: the folder `streams`, the size of the picture. Out: [`GazeSample`]s, by
//! ascending time. Seconds since the start of the drive.

use crate::metrics::GazeSample;
use crate::record::{RecordError, TableReader, streams};
use serde::Deserialize;
use std::{fs, path::Path};

/// Content of the streams of eye trackers, as LSL's conventions name it.
const CONTENT: &str = "gaze";
/// Names of the columns across and down the picture that are known, in small letters.
const COLUMNS: [[&str; 2]; 4] = [["screen_x", "screen_y"], ["screenx", "screeny"], ["gaze_x", "gaze_y"], ["x", "y"]];
/// Lower end of the road as a share of the picture's height: the highest upper edge of the speedometer, whose diameter is 0.34 and whose margin is 0.015.
const ROAD_BOTTOM: f64 = 0.645;

/// Part of a stream's description.
#[derive(Deserialize)]
struct Described {
    stream: Stream,
}

#[derive(Deserialize)]
struct Stream {
    #[serde(rename = "type")]
    content: String,
    channels: Vec<Channel>,
}

#[derive(Deserialize)]
struct Channel {
    label: String,
    unit: String,
}

/// Reads the gaze of a drive whose picture has this size, pixels. Without a stream of the type `Gaze` with known columns there are no samples; of several
/// streams the first by name counts.
///
/// # Errors
/// A table cannot be read.
pub(super) fn read(recording: &Path, size: [u32; 2]) -> Result<Vec<GazeSample>, RecordError> {
    let Ok(entries) = fs::read_dir(recording.join(streams::FOLDER)) else { return Ok(Vec::new()) };
    let mut files: Vec<_> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    files.retain(|file| file.extension().is_some_and(|ending| ending == "json"));
    files.sort();
    for file in files {
        // A description that a crash has cut belongs to a stream without known columns.
        let text = fs::read_to_string(&file).unwrap_or_default();
        let Ok(Described { stream }) = serde_json::from_str::<Described>(&text) else { continue };
        let Some(found) = stream.columns().filter(|_| stream.content.eq_ignore_ascii_case(CONTENT)) else { continue };
        let table = TableReader::parquet(&file.with_extension("parquet"))?;
        return Ok(samples(&table, found, size));
    }
    Ok(Vec::new())
}

impl Stream {
    /// Returns the columns across and down the picture, each with true if its unit is the pixel.
    fn columns(&self) -> Option<[(&str, bool); 2]> {
        let named = |name: &str| {
            let channel = self.channels.iter().find(|channel| channel.label.eq_ignore_ascii_case(name))?;
            Some((channel.label.as_str(), channel.unit.to_ascii_lowercase().starts_with("pix")))
        };
        COLUMNS.iter().find_map(|[across, down]| Some([named(across)?, named(down)?]))
    }
}

/// Returns the samples of a table. Those without a time or a place, as in a blink, are left out.
fn samples(table: &TableReader, columns: [(&str, bool); 2], size: [u32; 2]) -> Vec<GazeSample> {
    let shares = [0, 1].map(|side| {
        let (name, is_pixels) = columns[side];
        let scale = if is_pixels { f64::from(size[side].max(1)) } else { 1.0 };
        table.numbers(name).into_iter().map(move |value| value.map(|value| value / scale))
    });
    let [across, down] = shares;
    let mut samples: Vec<GazeSample> = table
        .numbers(streams::TIME)
        .into_iter()
        .zip(across.zip(down))
        .filter_map(|(time_s, (x, y))| {
            let (time_s, x, y) = (time_s?, x?, y?);
            let is_on_road = (0.0..=1.0).contains(&x) && (0.0..=ROAD_BOTTOM).contains(&y);
            (time_s.is_finite() && x.is_finite() && y.is_finite()).then_some(GazeSample { time_s, is_on_road })
        })
        .collect();
    samples.sort_by(|a, b| a.time_s.total_cmp(&b.time_s));
    samples
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::streams::{CLOCK, OFFSET, STAMP, StreamColumn, StreamJournal, StreamValues, TIME};
    use serde_json::json;

    /// Writes a stream as a recorder does, whose clock is that of the drive, and reads its gaze in a picture of 1000 by 500 pixels.
    fn gaze_of(content: &str, channels: [(&str, &str); 2], rows: &[[f64; 3]]) -> Vec<[f64; 2]> {
        let folder = tempfile::tempdir().expect("a folder");
        let number = |(name, unit): (&str, &str)| StreamColumn::number(name, unit, "");
        let begin = |name: &str, columns: &[(&str, &str)]| {
            let columns: Vec<StreamColumn> = columns.iter().copied().map(number).collect();
            StreamJournal::begin(folder.path(), name, &columns).expect("a stream")
        };
        let pair = || StreamValues::Numbers(vec![0.0, 10.0]);
        begin(CLOCK, &[(STAMP, "s"), (TIME, "s")]).append(vec![pair(), pair()]).expect("rows");
        let mut journal = begin("eyes", &[(STAMP, "s"), (OFFSET, "s"), channels[0], channels[1]]);
        let column = |k: usize| StreamValues::Numbers(rows.iter().map(|row| row[k]).collect());
        let none = StreamValues::Numbers(vec![0.0; rows.len()]);
        journal.append(vec![column(0), none, column(1), column(2)]).expect("rows");
        let labels = channels.map(|(label, unit)| json!({ "label": label, "unit": unit }));
        let text = json!({ "stream": { "type": content, "channels": labels } });
        journal.describe("json", &text.to_string()).expect("a description");
        streams::settle(folder.path(), &mut Vec::new()).expect("a table");
        let found = read(folder.path(), [1000, 500]).expect("a readable recording");
        found.iter().map(|sample| [sample.time_s, f64::from(u8::from(sample.is_on_road))]).collect()
    }

    #[test]
    fn a_gaze_above_the_speedometer_is_on_the_road() {
        let shares = [[0.0, 0.5, 0.3], [0.1, 0.5, 0.7], [0.2, 1.2, 0.3], [0.3, f64::NAN, 0.3], [0.4, 0.1, 0.6]];
        let wanted = vec![[0.0, 1.0], [0.1, 0.0], [0.2, 0.0], [0.4, 1.0]];
        assert_eq!(gaze_of("Gaze", [("Screen_X", "normalized"), ("Screen_Y", "normalized")], &shares), wanted);
        let pixels = shares.map(|[time_s, x, y]| [time_s, 1000.0 * x, 500.0 * y]);
        assert_eq!(gaze_of("gaze", [("x", "pixels"), ("y", "pixels")], &pixels), wanted);
    }

    #[test]
    fn streams_of_other_devices_are_no_gaze() {
        let rows = [[0.0, 0.5, 0.3]];
        assert!(gaze_of("EEG", [("x", ""), ("y", "")], &rows).is_empty());
        assert!(gaze_of("Gaze", [("pupil", "mm"), ("y", "")], &rows).is_empty());
        assert!(read(Path::new("/no/such/recording"), [1, 1]).expect("no gaze").is_empty());
    }
}
