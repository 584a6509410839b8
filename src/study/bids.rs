//! Tables and sidecars as BIDS wants them (`beh`, version 1.10): tab-separated, `n/a` for what is not there, every column
//! described in JSON with its unit and levels. In: rows. Out: text; events of a recorded drive.

use crate::record::{RecordError, Table as Recorded, TableReader};
use serde_json::{Map, Value, json};
use std::path::Path;

/// A column: name, meaning, unit (empty for none), words that stand in it with their meanings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TsvColumn {
    /// Name.
    pub name: String,
    /// What it is.
    pub about: String,
    /// Unit.
    pub unit: String,
    /// Words and what they mean.
    pub levels: Vec<(String, String)>,
}

impl TsvColumn {
    /// A column without levels.
    pub fn new(name: &str, about: &str, unit: &str) -> Self {
        Self { name: name.into(), about: about.into(), unit: unit.into(), levels: Vec::new() }
    }

    /// The same with levels.
    #[must_use]
    pub fn with(mut self, levels: impl IntoIterator<Item = (String, String)>) -> Self {
        self.levels = levels.into_iter().collect();
        self
    }
}

/// A table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TsvTable {
    /// Columns in order.
    pub columns: Vec<TsvColumn>,
    /// A cell for each column; empty is `n/a`.
    pub rows: Vec<Vec<String>>,
}

impl TsvTable {
    /// A table without rows.
    pub fn new(columns: Vec<TsvColumn>) -> Self {
        Self { columns, rows: Vec::new() }
    }

    /// The table's text.
    pub fn text(&self) -> String {
        let names: Vec<String> = self.columns.iter().map(|c| c.name.clone()).collect();
        let line = |cells: &Vec<String>| {
            let cells: Vec<String> = cells.iter().map(|cell| cell_text(cell)).collect();
            cells.join("\t") + "\n"
        };
        std::iter::once(&names).chain(&self.rows).map(line).collect()
    }

    /// Its sidecar: `more` comes first.
    pub fn sidecar(&self, more: Value) -> String {
        let mut out = more.as_object().cloned().unwrap_or_default();
        for column in &self.columns {
            let mut about = Map::new();
            about.insert("Description".into(), column.about.clone().into());
            if !column.unit.is_empty() {
                about.insert("Units".into(), column.unit.clone().into());
            }
            if !column.levels.is_empty() {
                let levels = column.levels.iter().map(|(word, text)| (word.clone(), text.clone().into()));
                about.insert("Levels".into(), Value::Object(levels.collect()));
            }
            out.insert(column.name.clone(), about.into());
        }
        format!("{:#}\n", Value::Object(out))
    }
}

fn cell_text(cell: &str) -> String {
    if cell.is_empty() { "n/a".into() } else { cell.replace(['\t', '\n', '\r'], " ") }
}

/// A number as a cell.
pub fn number(value: Option<f64>) -> String {
    value.filter(|v| v.is_finite()).map_or(String::new(), |v| v.to_string())
}

/// A JSON value as a cell: words without quotes, lists joined by semicolons.
pub fn value(value: &Value) -> String {
    match value {
        Value::Null => String::new(),
        Value::String(word) => word.clone(),
        Value::Array(list) => list.iter().map(self::value).collect::<Vec<_>>().join(";"),
        other => other.to_string(),
    }
}

/// A name of the study as a label of BIDS, letters and digits alone: `ssq-before` is `ssqBefore`.
pub fn label(name: &str) -> String {
    let mut parts = name.split('-');
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |label, part| {
        let mut chars = part.chars();
        let head = chars.next().map(|c| c.to_ascii_uppercase());
        label + &head.into_iter().chain(chars).collect::<String>()
    })
}

/// The version of BIDS that data sets keep to.
pub const VERSION: &str = "1.10.0";

/// Facts of a task for a sidecar.
pub fn task(name: &str, description: &str, instructions: &str, institution: Option<&str>) -> Value {
    let mut facts = json!({
        "TaskName": name,
        "TaskDescription": description,
        "Instructions": if instructions.is_empty() { "none" } else { instructions },
        "StimulusPresentation": {
            "SoftwareName": "codrive",
            "SoftwareVersion": env!("CARGO_PKG_VERSION"),
        },
    });
    if let Some(institution) = institution {
        facts["InstitutionName"] = institution.into();
    }
    facts
}

/// `dataset_description.json` of what is derived from a data set.
pub fn derived(title: &str) -> String {
    let about = json!({
        "Name": format!("{title}: measures by codrive"),
        "BIDSVersion": VERSION,
        "DatasetType": "derivative",
        "GeneratedBy": [{
            "Name": "codrive",
            "Version": env!("CARGO_PKG_VERSION"),
            "Description": "codrive analyse: measures of every drive (columns.json defines them), figures, report",
        }],
    });
    format!("{about:#}\n")
}

/// Advice and events of a recorded drive as `_events.tsv`: onset from the start of the drive.
///
/// # Errors
/// A table of it cannot be read.
pub fn events(recording: &Path) -> Result<TsvTable, RecordError> {
    let words = [
        ("advice", "a new target stands on the speedometer"),
        ("advice_withheld", "the target is gone: the policy advises nothing from now on"),
        ("contact", "the car began to touch another one"),
        ("left_road", "the middle of the car left its lane"),
        ("back_on_road", "the middle of the car is back in the lane"),
        ("put_back", "the car was put back on its lane"),
        ("ended", "the drive is over"),
        ("mark", "a mark by the experimenter or the participant"),
        ("note", "a note by the experimenter"),
        ("criterion", "the criterion of a practice drive is met"),
        ("asked", "the participant asked to stop"),
        ("paused", "the experimenter paused the drive"),
        ("resumed", "the drive went on"),
        ("extended", "the drive lasts longer"),
    ];
    let mut table = TsvTable::new(vec![
        TsvColumn::new("onset", "time since the start of the drive, in simulation", "s"),
        TsvColumn::new("duration", "how long an advice stands; n/a for what has no length", "s"),
        TsvColumn::new("trial_type", "what happened", "").with(words.map(|(w, t)| (w.to_owned(), t.to_owned()))),
        TsvColumn::new("tick", "tick of the recording, 10 ms each: joins to its tables", ""),
        TsvColumn::new("target_speed", "advised speed", "m/s"),
        TsvColumn::new("range_low", "lower edge of the acceptable range", "m/s"),
        TsvColumn::new("range_high", "upper edge of the acceptable range", "m/s"),
        TsvColumn::new("speed", "speed of the participant's car at that moment", "m/s"),
        TsvColumn::new("value", "closing speed of a contact, or offset where the road was left", "m/s or m"),
        TsvColumn::new("detail", "the rest in words", ""),
    ]);
    let mut rows: Vec<(u64, Vec<String>)> = Vec::new();
    let advice = TableReader::parquet(&Recorded::Advice.parquet(recording))?;
    let columns = ["hold_s", "target_mps", "range_low_mps", "range_high_mps", "speed_mps"].map(|n| advice.numbers(n));
    for (i, tick) in advice.wholes("tick").into_iter().enumerate() {
        let [hold, target, low, high, speed] = [0, 1, 2, 3, 4].map(|k: usize| number(columns[k][i]));
        let tick_cells = vec![onset(tick), hold, "advice".into(), tick.to_string(), target, low, high, speed];
        rows.push((tick, tick_cells.into_iter().chain([String::new(), String::new()]).collect()));
    }
    let events = TableReader::parquet(&Recorded::Events.parquet(recording))?;
    let (kinds, details, values) = (events.words("event"), events.words("detail"), events.numbers("value"));
    for (i, tick) in events.wholes("tick").into_iter().enumerate() {
        let mut cells = vec![onset(tick), String::new(), kinds[i].clone(), tick.to_string()];
        cells.extend([const { String::new() }; 4]);
        cells.extend([number(values[i]), details[i].clone()]);
        rows.push((tick, cells));
    }
    rows.sort_by_key(|row| row.0);
    table.rows = rows.into_iter().map(|row| row.1).collect();
    Ok(table)
}

fn onset(tick: u64) -> String {
    format!("{}.{:02}", tick / 100, tick % 100)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_keep_to_their_line_and_what_is_missing_says_so() {
        let mut table = TsvTable::new(vec![TsvColumn::new("a", "first", "s"), TsvColumn::new("b", "second", "")]);
        table.rows.push(vec!["1\t2\n3".into(), String::new()]);
        assert_eq!(table.text(), "a\tb\n1 2 3\tn/a\n");
        let sidecar: Value = serde_json::from_str(&table.sidecar(json!({ "TaskName": "x" }))).unwrap();
        assert_eq!(
            sidecar,
            json!({"TaskName": "x", "a": {"Description": "first", "Units": "s"}, "b": {"Description": "second"}})
        );
        assert_eq!((label("ssq-before"), label("trial")), ("ssqBefore".into(), "trial".into()));
        assert_eq!(value(&json!(["a", 2])), "a;2");
        assert_eq!((onset(1205), onset(7)), ("12.05".into(), "0.07".into()));
    }

    #[test]
    fn a_number_that_is_none_is_empty_and_values_are_words_without_quotes() {
        assert_eq!(number(Some(2.5)), "2.5");
        for none in [None, Some(f64::NAN), Some(f64::INFINITY)] {
            assert_eq!(number(none), "");
        }
        assert_eq!([Value::Null, json!("a b"), json!(true), json!(2.5)].map(|v| value(&v)), ["", "a b", "true", "2.5"]);
        let with = TsvColumn::new("a", "first", "").with([("x".to_owned(), "an x".to_owned())]);
        let sidecar: Value = serde_json::from_str(&TsvTable::new(vec![with]).sidecar(Value::Null)).unwrap();
        assert_eq!(sidecar, json!({"a": {"Description": "first", "Levels": {"x": "an x"}}}));
        let told = task("trial", "Driving", "", None);
        assert_eq!((&told["TaskName"], &told["Instructions"]), (&json!("trial"), &json!("none")));
        assert_eq!(task("trial", "Driving", "Go.", None)["Instructions"], "Go.");
        assert!(told["InstitutionName"].is_null());
        assert_eq!(task("trial", "Driving", "", Some("A laboratory"))["InstitutionName"], "A laboratory");
        assert_eq!(told["StimulusPresentation"]["SoftwareName"], "codrive");
    }

    #[test]
    fn advice_and_events_of_a_recording_are_rows_in_the_order_of_time() {
        use crate::{
            controls::Controls,
            record::{Manifest, Recorder},
            scenario::Scenario,
            sim::{SummaryAccumulator, World},
            time::Tick,
            traffic::EngineChoice,
        };
        let folder = tempfile::tempdir().unwrap();
        let scenario = Scenario {
            traffic: EngineChoice::Native,
            policy: "constant".into(),
            policy_speed_mps: 4.0,
            range_mph: 1.0,
            hold_s: 0.5,
            duration_s: 1.2,
            ..Scenario::default()
        };
        let mut world = World::new(&scenario).unwrap();
        let mut recorder = Recorder::begin(&folder.path().join("drive"), &scenario, Manifest::default()).unwrap();
        let mut tally = SummaryAccumulator::new([0.0, f64::INFINITY]);
        for tick in 1..=120 {
            world.tick(&Controls::default()).unwrap();
            tally.add(world.snapshot(), world.events());
            recorder.tick(&world, &Controls::default()).unwrap();
            if tick == 33 {
                recorder.event(Tick(tick), "note", "coughs");
            }
        }
        let folder = recorder.finish(&tally.summary()).unwrap();
        let table = events(&folder).unwrap();
        assert!(table.rows.is_sorted_by_key(|row| row[3].parse::<u64>().unwrap()), "{:?}", table.rows);
        let of = |kind: &str| table.rows.iter().filter(|row| row[2] == kind).cloned().collect::<Vec<_>>();
        let none = String::new;
        let text = |words: &str| words.to_owned();
        assert_eq!(
            of("note"),
            [vec![
                text("0.33"),
                none(),
                text("note"),
                text("33"),
                none(),
                none(),
                none(),
                none(),
                none(),
                text("coughs")
            ]]
        );
        let ended = of("ended");
        assert_eq!((ended.len(), &ended[0][0], &ended[0][9]), (1, &text("1.20"), &text("duration")));
        let advice = of("advice");
        // Two or three holds of half a second begin within 1.2 s.
        assert!((2..=3).contains(&advice.len()), "{advice:?}");
        for row in &advice {
            assert_eq!(row[1..3], ["0.5", "advice"]);
            // A mile is 1609.344 m: the range is 0.44704 m/s to either side.
            let [target, low, high] = [4, 5, 6].map(|i: usize| row[i].parse::<f64>().unwrap());
            assert!(target == 4.0 && (low - 3.552_96).abs() < 1e-9 && (high - 4.447_04).abs() < 1e-9, "{row:?}");
            assert_eq!((row[8].as_str(), row[9].as_str()), ("", ""), "an advice has no value and no words");
        }
        let ticks: Vec<u64> = advice.iter().map(|row| row[3].parse().unwrap()).collect();
        assert!(ticks.windows(2).all(|pair| pair[1] - pair[0] == 50), "{ticks:?}");
        let text = table.text();
        assert!(text.starts_with("onset\tduration\ttrial_type\ttick\ttarget_speed\t"), "{text}");
    }
}
