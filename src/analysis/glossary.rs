//! Definitions of all columns. In: analysed drives. Out: for each column of each table the quantity in words, its unit and its
//! definition. Table heads, labels, the page, the methods paragraph and the data dictionary all use these, or [`MEASURES`],
//! which names the measures.

use super::{AnalysedRecording, MEASURES, RoadKinds, network, tables::factors};
use serde_json::{Map, Value, json};

/// A column of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnDefinition {
    /// Column name in the table.
    pub name: String,
    /// Quantity in words, without its unit.
    pub title: String,
    /// Unit in ASCII; empty without a unit.
    pub unit: &'static str,
    /// Definition, without the name.
    pub about: String,
}

/// A table and its columns, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct TableColumns {
    pub file: &'static str,
    /// Meaning of a row.
    pub row: &'static str,
    pub columns: Vec<ColumnDefinition>,
}

/// Texts of a column: name, quantity, unit, definition.
pub(super) type ColumnTexts = (&'static str, &'static str, &'static str, &'static str);

const KEY: [ColumnTexts; 4] = [
    ("participant", "Participant", "", "code of the participant; empty outside of a study"),
    ("segment", "Segment", "", "segment of the study; empty outside of a study"),
    ("place", "Place", "", "place among the trials of the segment, from 1"),
    ("condition", "Condition", "", "condition of the trial; empty for a drive that is the same for everyone"),
];
const SCORES: [ColumnTexts; 6] = [
    KEY[0],
    ("questionnaire", "Questionnaire", "", "questionnaire of the plan, as its file in the data set is called"),
    ("place", "Place", "", "place of the trial that it is about, from 1; empty for one that is about no trial"),
    ("condition", "Condition", "", "condition of that trial; empty for one that is about no trial"),
    ("score", "Score", "", "name of the score in its questionnaire"),
    (
        "value",
        "Value",
        "",
        "the score in its own unit, by the rule of its questionnaire; empty where an answer is missing",
    ),
];
const FMS: [ColumnTexts; 8] = [
    KEY[0],
    ("segment", "Segment", "", "segment of the study"),
    KEY[2],
    KEY[3],
    ("recording", "Recording", "", "folder of the recording; a drive that came again has several"),
    ("time_s", "Time", "s", "when the question appeared, since the start of the drive"),
    (
        "value",
        "Sickness while driving",
        "",
        "rating on the fast motion sickness scale, 0 (no sickness at all) to 20 (frank sickness); empty where none came",
    ),
    ("answer_s", "Time to answer", "s", "from the question to the answer; empty where none came"),
];
const DRIVE: [ColumnTexts; 2] = [
    ("duration_s", "Duration", "s", "length of the drive"),
    ("ended", "End", "", "how the drive ended: duration (its time was over), contact, or who or what stopped it"),
];
const ADVICE: [ColumnTexts; 14] = [
    (
        "kind",
        "Kind",
        "",
        "event: the change asks something new, as the speed is outside of the new acceptable range and was in the range before or on its \
         other side; change: any other; sham: the events of the drive shifted all by the same time to where none is pending, to \
         see what is found by chance",
    ),
    (
        "onset_s",
        "Onset",
        "s",
        "when the change was seen, from the start of the drive: the first frame that showed it, or its issue where there was no screen",
    ),
    ("from_mps", "Target before", "m/s", "advised speed before the change"),
    ("to_mps", "Target after", "m/s", "advised speed after the change"),
    ("speed_mps", "Speed at the onset", "m/s", "speed of the ego vehicle at the onset"),
    ("asked", "Demand", "", "faster or slower: where the new range is; empty for a change that asks nothing new"),
    (
        "reaction_s",
        "Reaction time",
        "s",
        "perception-reaction time (reaction time, SAE J2944, 6.5.2): from the onset to the start of the first movement of the pedals in \
         the direction asked that is larger than the person's idle movements; empty if there was none until the end of watching \
         (censored there) or one was under way",
    ),
    (
        "under_way",
        "Movement under way",
        "",
        "such a movement started before 0.15 s: it is no response, and the reaction time is not known",
    ),
    (
        "movement_s",
        "Movement time",
        "s",
        "from the reaction to pedals that are 5 % of travel beyond the idle movements; empty if that was not reached until the end \
         of watching",
    ),
    (
        "enter_range_s",
        "Time to enter the range",
        "s",
        "compliance time: from the onset to the speed being in the new range; empty if it was not until the end of watching",
    ),
    ("enter_range_steps", "Steps to enter the range", "steps", "the time to enter the range in steps of the traffic"),
    (
        "watched_s",
        "Time watched",
        "s",
        "from the onset to the next change of the advice (of a sham: or the next sham) or the end of the drive; what is empty is censored \
         there",
    ),
    (
        "idle_movement",
        "Idle movement of the pedals",
        "",
        "95th percentile of the movements of the pedals within 1 s while no event is pending, as a share of travel, at least 0.01",
    ),
    (
        "idle_from",
        "Basis of the idle movement",
        "",
        "practice: the participant's first drive without a condition that has 20 s of idle pedals; drive: this drive; least: neither has \
         20 s, so that 0.01 is taken",
    ),
];
const REACTIONS: [ColumnTexts; 19] = [
    ("participant", "Participant", "", "code of the participant; empty outside of a study"),
    ("condition", "Condition", "", "condition of the drives; empty for drives that are the same for everyone"),
    (
        "time",
        "Time",
        "",
        "reaction: perception-reaction time; movement; compliance: time to enter the range; chance: reaction time to shams",
    ),
    ("onsets", "Onsets", "", "events, or shams, of these drives"),
    ("seen", "Times seen", "", "times that were not censored"),
    ("censored", "Times censored", "", "times that were longer than the time watched"),
    ("under_way", "Movements under way", "", "onsets that were left out as a movement was under way"),
    (
        "answered",
        "Share answered",
        "",
        "share within 3 s, of those that came or were watched that long: what chance has is no response to advice",
    ),
    ("chance_per_s", "Chance movements", "1/s", "of shams: movements that were found, over the seconds watched"),
    (
        "answering",
        "Share of events answered",
        "",
        "of reactions: share of the events that the driver answers at all, by the fit of the median; the others get a movement by chance or \
         none",
    ),
    (
        "median_s",
        "Median",
        "s",
        "median of the lognormal distribution of greatest likelihood, which takes account of censored times; of reactions that of the \
         answers, beside events that are never answered and movements by chance at the rate of the shams",
    ),
    (
        "low_s",
        "Median, lower end",
        "s",
        "lower end of its 95 % interval (Student's t on the logarithm, from the observed information; of reactions by the profile of the \
         likelihood)",
    ),
    ("high_s", "Median, upper end", "s", "upper end of the same interval"),
    ("log_mean", "Mean of the logarithm", "", "mu of the lognormal distribution of the time in seconds"),
    ("log_sd", "Standard deviation of the logarithm", "", "sigma of the same"),
    (
        "normal_mean_s",
        "Ex-Gaussian mu",
        "s",
        "mean of the normal part of the ex-Gaussian distribution; from 30 times seen on",
    ),
    ("normal_sd_s", "Ex-Gaussian sigma", "s", "standard deviation of the same part"),
    ("exponential_mean_s", "Ex-Gaussian tau", "s", "mean of the exponential part of the same distribution"),
    (
        "idle_from",
        "Basis of the idle movement",
        "",
        "where the size of idle movements of the pedals is from: practice, drive or least",
    ),
];
const SPEED: [ColumnTexts; 3] = [
    ("second", "Second", "s", "second of the drive; speeds are means over it"),
    (
        "mean_speed_mps",
        "Mean speed of all vehicles",
        "m/s",
        "speed of all vehicles, the ego vehicle included: mean over vehicles and the second",
    ),
    (
        "baseline_speed_mps",
        "Mean speed of all vehicles without advice",
        "m/s",
        "the same in the drive from the same seed without advice; empty if there is none",
    ),
];
const CONDITIONS: [ColumnTexts; 9] = [
    ("condition", "Condition", "", "condition of the trials"),
    ("measure", "Measure", "", "name of the measure, as the column of the table of trials"),
    ("unit", "Unit", "", "unit of the measure"),
    (
        "n",
        "Participants",
        "",
        "participants with a value; of one with several drives in the condition the mean counts once",
    ),
    ("mean", "Mean", "", "mean over participants"),
    ("sd", "Standard deviation", "", "standard deviation over participants (N−1)"),
    ("median", "Median", "", "median over participants"),
    (
        "low",
        "Interval, lower end",
        "",
        "lower end of the 95 % confidence interval of the mean (percentile bootstrap over participants)",
    ),
    ("high", "Interval, upper end", "", "upper end of the same interval"),
];

/// Texts of a driver's number: name without its unit, quantity, unit at the end of the name, unit, definition.
pub(super) struct DriverNumber {
    name: &'static str,
    title: &'static str,
    suffix: &'static str,
    unit: &'static str,
    about: &'static str,
}

/// Numbers in the order of [`FoundDriver::numbers`](super::driver_fit::FoundDriver::numbers).
pub(super) const DRIVER_NUMBERS: [DriverNumber; 4] = [
    DriverNumber {
        name: "reaction",
        title: "Reaction time to advice",
        suffix: "_s",
        unit: "s",
        about: "time from a change of the advice to the foot's movement; the delay of the advice that explains the wanted speed best",
    },
    DriverNumber {
        name: "speed_bias",
        title: "Bias",
        suffix: "_mps",
        unit: "m/s",
        about: "by how much the wanted speed is above (positive) or below the advised one on average",
    },
    DriverNumber {
        name: "error",
        title: "Tracking error",
        suffix: "_mps",
        unit: "m/s",
        about: "standard deviation of the wanted speed about the advised one and the bias",
    },
    DriverNumber {
        name: "time_gap_factor",
        title: "Time gap factor",
        suffix: "",
        unit: "",
        about: "desired time gap to the leader (T of the Intelligent Driver Model) as a multiple of the other cars'",
    },
];

impl DriverNumber {
    /// Returns the quantity with its unit.
    pub fn label(&self) -> String {
        if self.unit.is_empty() { self.title.into() } else { format!("{}, {}", self.title, self.unit) }
    }

    /// Returns the columns of the value, both ends of its interval, and the time that it rests on.
    fn columns(&self) -> [ColumnDefinition; 4] {
        let Self { name, title, suffix, unit, about } = self;
        let column = |part: &str, title: String, about: String| ColumnDefinition {
            name: format!("{name}{part}{suffix}"),
            title,
            unit,
            about,
        };
        [
            column("", (*title).into(), format!("{about}; empty where the drives do not tell")),
            column("_low", format!("{title}, lower end"), "lower end of its 95 % interval".into()),
            column("_high", format!("{title}, upper end"), "upper end of its 95 % interval".into()),
            ColumnDefinition {
                name: format!("{name}_rests_on_s"),
                title: format!("{title}, basis"),
                unit: "s",
                about: "time in which it showed; of a long drive evenly spaced stretches are taken".into(),
            },
        ]
    }
}

fn columns(words: &[ColumnTexts]) -> Vec<ColumnDefinition> {
    let column = |(name, title, unit, about): &ColumnTexts| ColumnDefinition {
        name: (*name).into(),
        title: (*title).into(),
        unit,
        about: (*about).into(),
    };
    words.iter().map(column).collect()
}

/// Returns the columns that identify the drive of a row.
fn key(drives: &[AnalysedRecording]) -> Vec<ColumnDefinition> {
    let factor = |name: String| ColumnDefinition {
        title: format!("Factor {name}"),
        about: format!("level of the factor {name} in the study's plan"),
        name,
        unit: "",
    };
    // A study without factors names its one factor "condition", which is a column already.
    let factors = factors(drives).into_iter().filter(|name| name != "condition").map(factor);
    columns(&KEY).into_iter().chain(factors).collect()
}

/// Returns all tables with their columns, for these drives.
pub fn tables(drives: &[AnalysedRecording]) -> Vec<TableColumns> {
    let roads = RoadKinds::of(drives);
    let measures = MEASURES.iter().filter(|measure| measure.has_column(roads)).map(|measure| ColumnDefinition {
        name: measure.name.into(),
        title: measure.title.into(),
        unit: measure.unit,
        about: measure.definition(roads),
    });
    let key = || key(drives).into_iter();
    let trials = key().chain(columns(&DRIVE)).chain(measures).collect();
    let mut tables = vec![
        TableColumns { file: "trials.csv", row: "a drive", columns: trials },
        TableColumns {
            file: "advice.csv",
            row: "a change of the advice, or a sham",
            columns: key().chain(columns(&ADVICE)).collect(),
        },
        TableColumns {
            file: "reactions.csv",
            row: "a kind of time of a participant in a condition",
            columns: columns(&REACTIONS),
        },
        TableColumns { file: "speed.csv", row: "a second of a drive", columns: key().chain(columns(&SPEED)).collect() },
        TableColumns { file: "conditions.csv", row: "a measure in a condition", columns: columns(&CONDITIONS) },
        TableColumns {
            file: "drivers.csv",
            row: "a participant as a driver",
            columns: columns(&KEY[..1])
                .into_iter()
                .chain(DRIVER_NUMBERS.iter().flat_map(DriverNumber::columns))
                .collect(),
        },
        TableColumns { file: "scores.csv", row: "a score of a participant", columns: columns(&SCORES) },
        TableColumns { file: "fms.csv", row: "a question about sickness while driving", columns: columns(&FMS) },
    ];
    if roads.networks {
        let of = |own: &[ColumnTexts]| key().chain(columns(own)).collect();
        tables.push(TableColumns {
            file: network::tables::TRIPS_FILE,
            row: "a vehicle of a drive on a network, the ego vehicle left out",
            columns: of(&network::tables::TRIPS),
        });
        tables.push(TableColumns {
            file: network::tables::LINES_FILE,
            row: "a line of a drive on a network",
            columns: of(&network::tables::LINES),
        });
    }
    tables
}

/// Returns the column names of a table.
pub fn names(drives: &[AnalysedRecording], file: &str) -> Vec<String> {
    let found = tables(drives).into_iter().find(|table| table.file == file).expect("a table of the list");
    found.columns.into_iter().map(|column| column.name).collect()
}

/// Returns the data dictionary as JSON: the columns of each table, with the keys of BIDS.
pub fn dictionary(drives: &[AnalysedRecording]) -> String {
    let entry = |column: ColumnDefinition| {
        let mut about = Map::new();
        about.insert("LongName".into(), column.title.into());
        about.insert("Description".into(), column.about.into());
        if !column.unit.is_empty() {
            about.insert("Units".into(), column.unit.into());
        }
        (column.name, Value::Object(about))
    };
    let table = |table: TableColumns| {
        let columns: Map<String, Value> = table.columns.into_iter().map(entry).collect();
        (table.file.to_owned(), json!({ "Row": table.row, "Columns": columns }))
    };
    let all: Map<String, Value> = tables(drives).into_iter().map(table).collect();
    format!("{:#}\n", Value::Object(all))
}

/// Returns a unit as it is printed: `m/s3` becomes m/s³.
pub fn unit_text(unit: &str) -> String {
    unit.replace("s2", "s²").replace("s3", "s³").replace('*', "·")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{StudyParticipants, page_tests::mixed_drives, response_time_table, sickness, tables as csv};

    #[test]
    fn every_column_has_a_title_and_a_definition_in_the_dictionary() {
        let drives = mixed_drives();
        let written = [
            ("trials.csv", csv::trials(&drives)),
            ("advice.csv", csv::advice(&drives)),
            ("reactions.csv", response_time_table::table(&drives)),
            ("speed.csv", csv::speed(&drives)),
            ("conditions.csv", csv::by_condition(&drives)),
            ("drivers.csv", csv::drivers(&drives, &[])),
            ("scores.csv", csv::scores(&drives, &StudyParticipants::default())),
            ("fms.csv", sickness::table(&StudyParticipants::default())),
            ("trips.csv", network::tables::trips(&drives)),
            ("lines.csv", network::tables::lines(&drives)),
        ];
        let dictionary: Value = serde_json::from_str(&dictionary(&drives)).unwrap();
        assert_eq!(dictionary.as_object().unwrap().len(), written.len());
        let tables = tables(&drives);
        for (file, text) in written {
            let head: Vec<&str> = text.lines().next().unwrap().split(',').collect();
            assert!(head.len() >= 6, "{file}: {head:?}");
            let of = tables.iter().find(|table| table.file == file).unwrap();
            assert_eq!(of.columns.iter().map(|column| column.name.as_str()).collect::<Vec<_>>(), head, "{file}");
            for column in &of.columns {
                let entry = &dictionary[file]["Columns"][&column.name];
                assert_eq!(entry["LongName"], column.title.as_str());
                assert_eq!(entry.get("Units").and_then(Value::as_str).unwrap_or_default(), column.unit);
                // Words, not the name again, and no other column's name within a definition.
                assert!(column.title.chars().next().is_some_and(|sign| !sign.is_lowercase()), "{column:?}");
                assert!(
                    column.about.len() > 5 && !column.about.contains('_') && !column.title.contains('_'),
                    "{column:?}"
                );
                let has_unit =
                    column.name.ends_with("_s") || column.name.ends_with("_mps") || column.name.ends_with("_m");
                assert!(!has_unit || !column.unit.is_empty(), "{column:?}");
            }
        }
    }
}
