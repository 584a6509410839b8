//! Proof of each file of a recording. In: a recording that was driven again to its end. Out: one line for each file: proven by
//! driving, by its checksum only, or not at all, with the parts that are proven less.

use super::facts::{DriveFacts, SUMMARY};
use crate::{
    map, policy,
    record::{
        Checksums, LOST_AND_FOUND, Manifest, RecordError, Table, TableReader, compare::OF_DEVICES, inputs, is_there,
        tables::EventRow,
    },
    scenario::Scenario,
};
use std::{fmt, path::Path};

/// Strength of a proof.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ProofKind {
    /// Drive that gives the same values again.
    Driving,
    /// SHA-256 equal to the one noted when the file was written.
    Checksum,
    /// No proof that the file is as it was written.
    Nothing,
}

impl fmt::Display for ProofKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Driving => "driving",
            Self::Checksum => "checksum only",
            Self::Nothing => "nothing",
        })
    }
}

/// File of a recording and its proof.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Evidence {
    /// Name of the file, relative to the recording's folder.
    pub file: String,
    /// Strongest proof of the file.
    pub by: ProofKind,
    /// Parts of the file with a weaker proof; empty if there are none.
    pub less: String,
}

impl Evidence {
    pub(super) fn driving(file: &str, less: String) -> Self {
        Self { file: file.into(), by: ProofKind::Driving, less }
    }

    fn checksum(file: &str, less: &str) -> Self {
        Self { file: file.into(), by: ProofKind::Checksum, less: less.into() }
    }
}

/// Returns the files of a recording as a table with a heading.
pub fn table(files: &[Evidence]) -> String {
    let width = files.iter().map(|file| file.file.chars().count()).max().unwrap_or_default().max("file".len());
    let line =
        |file: &str, by: &str, less: &str| format!("{file:<width$}  {by:<13}  {less}").trim_end().to_owned() + "\n";
    let lines = files.iter().map(|file| line(&file.file, &file.by.to_string(), &file.less));
    line("file", "proven by", "not fully proven") + &lines.collect::<String>()
}

/// Returns the proof of each file of a recording without differences.
pub(super) fn of(recording: &Path, scenario: &Scenario, facts: &DriveFacts) -> Result<Vec<Evidence>, RecordError> {
    let manifest = Manifest::load(recording)?;
    let mut files = Vec::new();
    for table in Table::of(&manifest) {
        let name = format!("{}.parquet", table.name());
        files.push(match table {
            Table::Frames => Evidence::checksum(&name, "times of frames and devices cannot be driven again"),
            Table::Events => Evidence::driving(&name, by_hand(recording)?),
            Table::Ego => Evidence::driving(&name, format!("{}: checksum only", OF_DEVICES[0])),
            Table::Advice => Evidence::driving(&name, format!("{}, {}: checksum only", OF_DEVICES[1], OF_DEVICES[2])),
            _ => Evidence::driving(&name, String::new()),
        });
    }
    let settings = "picture, sound, lamps and unused settings: checksum only";
    files.push(Evidence::driving(inputs::SCENARIO, settings.into()));
    files.extend(facts.evidence());
    let sums = Checksums::load(recording)?;
    let own = [inputs::SCENARIO, SUMMARY];
    let others = sums.files.keys().filter(|name| !own.contains(&name.as_str()));
    files.extend(others.map(|name| {
        if is_driven_with(&recording.join(name), scenario) {
            Evidence::driving(name, String::new())
        } else {
            Evidence::checksum(name, "")
        }
    }));
    if is_there(&recording.join(LOST_AND_FOUND))? {
        let less = "unreadable parts from the recovery of the drive";
        files.push(Evidence { file: LOST_AND_FOUND.into(), by: ProofKind::Nothing, less: less.into() });
    }
    Ok(files)
}

/// Checks whether the drive reads the file: the scenario's network, demand or policy, but not a map's title and route.
fn is_driven_with(file: &Path, scenario: &Scenario) -> bool {
    let is_of_map = map::is_path(&scenario.map) && file.starts_with(&scenario.map) && !file.ends_with("map.toml");
    let policies = Path::new(&scenario.policy).parent().filter(|_| policy::is_path(&scenario.policy));
    is_of_map
        || scenario.demand.input_files().any(|own| own == file)
        || policies.is_some_and(|own| file.starts_with(own))
}

/// Returns a note on the rows of events made by people and windows; empty if there are none.
fn by_hand(recording: &Path) -> Result<String, RecordError> {
    let mut count = 0;
    for part in TableReader::parts(&Table::Events.parquet(recording), &["event"])? {
        count += part?.words("event").iter().filter(|kind| !EventRow::is_of_world(kind)).count();
    }
    Ok(if count == 0 {
        String::new()
    } else {
        format!("marks, notes and other rows by people ({count}): checksum only")
    })
}
