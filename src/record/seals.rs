//! Seals of a recording: the files that its format requires, and their checksums. In: a finished recording. Out: every file,
//! table, column, row count and seal that is missing, surplus or altered.

use super::{
    Manifest, RecordError, Table,
    checksums::{self, Checksums, ColumnSums, TableSums},
    files, inputs, journal, lock, manifest,
    manifest::RecordingState,
    sha256::{file_sha256, sha256},
    table::{TableBatches, TableReader},
    tables::schema,
};
use crate::{file, scenario::Scenario};
use std::{fmt, fs, path::Path};

/// File extension of a signature, appended to the name of the signed file, as `ssh-keygen -Y sign` does.
pub const SIGNATURE: &str = "sig";
/// Folders without seals: the journal, which is removed at the end, unreadable journals, and results of an analysis.
const UNSEALED: [&str; 3] = [journal::FOLDER, journal::LOST_AND_FOUND, "analysis"];
/// Files that file managers create in viewed folders.
pub const OF_SYSTEMS: [&str; 3] = [".DS_Store", "Thumbs.db", "desktop.ini"];

/// Altered part of a recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AlteredFile {
    /// Name of the altered file.
    pub file: String,
    /// Description of the alteration.
    pub what: String,
}

impl fmt::Display for AlteredFile {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.file, self.what)
    }
}

/// Alterations found so far.
#[derive(Default)]
struct Found(Vec<AlteredFile>);

impl Found {
    fn add_fault(&mut self, file: &str, what: impl Into<String>) {
        self.0.push(AlteredFile { file: file.into(), what: what.into() });
    }
}

/// Compares a recording with its own seals, and with the files that its format and its scenario require.
///
/// # Errors
/// The manifest cannot be read or has another format; or a file cannot be read.
pub fn changes(recording: &Path) -> Result<Vec<AlteredFile>, RecordError> {
    let manifest = Manifest::load(recording)?;
    let mut found = Found::default();
    Manifest::faults(recording)?.into_iter().for_each(|what| found.add_fault(manifest::FILE, what));
    let tables = tables(recording, &manifest, &mut found)?;
    let path = recording.join(checksums::FILE);
    if !files::is_there(&path)? {
        found.add_fault(checksums::FILE, "is missing");
        return Ok(found.0);
    }
    let now = file_sha256(&path)?;
    if manifest.checksums.as_ref().is_some_and(|written| now != *written) {
        found.add_fault(checksums::FILE, "is not as it was written: manifest.json has another SHA-256 of it");
    }
    let sums = match Checksums::load(recording) {
        Ok(sums) => sums,
        Err(error @ RecordError::File { .. }) => return Err(error),
        Err(error) => {
            found.add_fault(checksums::FILE, format!("cannot be read any more: {error}"));
            return Ok(found.0);
        }
    };
    check_files(recording, &manifest, &sums, &mut found)?;
    check_tables(recording, &tables, &sums, &mut found)?;
    for name in unsealed(recording, &sums)? {
        found.add_fault(&name, format!("{} does not list it", checksums::FILE));
    }
    Ok(found.0)
}

/// Returns the tables that must be there. Network tables follow from the scenario. The table of advised vehicles follows from
/// the drive, which a replay compares.
fn tables(recording: &Path, manifest: &Manifest, found: &mut Found) -> Result<Vec<Table>, RecordError> {
    let path = recording.join(inputs::SCENARIO);
    if !files::is_there(&path)? {
        // Reported by `check_files`.
        return Ok(Table::of(manifest));
    }
    let text = file::read_text(&path, file::SETTINGS_BYTES).map_err(RecordError::file(&path))?;
    let scenario = match Scenario::from_toml(&text, inputs::SCENARIO) {
        Ok(scenario) => scenario,
        Err(why) => {
            found.add_fault(inputs::SCENARIO, format!("cannot be read any more: {}", why.message));
            return Ok(Table::of(manifest));
        }
    };
    if scenario.to_toml() != text {
        found.add_fault(inputs::SCENARIO, "is not as this program writes it: a setting is missing, or text was added");
    }
    let is_open = scenario.has_path_or_demand();
    if manifest.network_tables != is_open {
        let (is, declared) = (if is_open { "a network" } else { "a closed route" }, manifest.network_tables);
        found.add_fault(manifest::FILE, format!("network_tables is {declared}; the scenario is of a drive on {is}"));
    }
    Ok(Table::of(&Manifest { network_tables: is_open, ..manifest.clone() }))
}

/// Checks the files beside the tables: scenario, summary, inputs and streams.
fn check_files(recording: &Path, manifest: &Manifest, sums: &Checksums, found: &mut Found) -> Result<(), RecordError> {
    let is_cut = manifest.state == RecordingState::Recovered;
    for name in checksums::OTHERS {
        // A drive that was cut has no summary.
        let may_lack = is_cut && name == "summary.json" && !files::is_there(&recording.join(name))?;
        if !may_lack && !sums.files.contains_key(name) {
            found.add_fault(name, format!("{} has no SHA-256 of it", checksums::FILE));
        }
    }
    for (name, was) in &sums.files {
        let path = recording.join(name);
        if !files::is_there(&path)? {
            found.add_fault(name, "is missing");
        } else if file_sha256(&path)? != *was {
            found.add_fault(name, "is not as it was written: its SHA-256 differs");
        }
    }
    Ok(())
}

fn check_tables(recording: &Path, tables: &[Table], sums: &Checksums, found: &mut Found) -> Result<(), RecordError> {
    for table in tables {
        let (path, name) = (table.parquet(recording), format!("{}.parquet", table.name()));
        let Some(was) = sums.tables.get(table.name()) else {
            found.add_fault(&name, format!("{} has no SHA-256 of it", checksums::FILE));
            continue;
        };
        if !files::is_there(&path)? {
            found.add_fault(&name, "is missing");
            continue;
        }
        let is_as_written = file_sha256(&path)? == was.sha256;
        match table_differences(*table, &path, was) {
            Ok(what) if what.is_empty() && !is_as_written => {
                found.add_fault(&name, "was rewritten; all values are unchanged");
            }
            Ok(what) => what.into_iter().for_each(|what| found.add_fault(&name, what)),
            Err(error @ RecordError::File { .. }) => return Err(error),
            Err(error) => found.add_fault(&name, format!("cannot be read any more: {error}")),
        }
    }
    for name in sums.tables.keys().filter(|name| !tables.iter().any(|table| table.name() == *name)) {
        found.add_fault(checksums::FILE, format!("lists {name}.parquet, which is not a table of this drive"));
    }
    Ok(())
}

/// Describes each part of a table that was altered or does not match its format.
fn table_differences(table: Table, path: &Path, was: &TableSums) -> Result<Vec<String>, RecordError> {
    let mut sums = ColumnSums::default();
    let rows = TableReader::each_batch(path, &mut |batch| sums.push(batch))?;
    let mut found = Vec::new();
    if rows != was.rows {
        found.push(format!("has {rows} rows; {} were written", was.rows));
    }
    let (there, format, now) = (TableBatches::open(path)?.schema(), schema(table), sums.finish());
    for field in format.fields() {
        let name = field.name();
        match there.field_with_name(name) {
            Err(_) => found.push(format!("column {name} is missing")),
            Ok(other) if other.data_type() != field.data_type() => {
                found.push(format!("column {name} has values of another kind"));
            }
            Ok(_) => match was.columns.get(name) {
                None if was.rows > 0 => found.push(format!("{} has no SHA-256 of column {name}", checksums::FILE)),
                Some(written) if rows == was.rows && now.get(name) != Some(written) => {
                    found.push(format!("column {name} is not as it was written"));
                }
                _ => {}
            },
        }
    }
    let is_new = |name: &&String| format.field_with_name(name).is_err();
    found.extend(
        there.fields().iter().map(|field| field.name()).filter(is_new).map(|name| format!("column {name} is new")),
    );
    let more = was.columns.keys().filter(|name| format.field_with_name(name).is_err());
    found.extend(
        more.map(|name| format!("{} has a SHA-256 of column {name}, which no such table has", checksums::FILE)),
    );
    Ok(found)
}

impl Checksums {
    /// Adds the other files of a recording and saves all checksums. Returns the SHA-256 of the saved file.
    pub(super) fn save(mut self, recording: &Path) -> Result<String, RecordError> {
        let beside = unsealed(recording, &self)?.into_iter().filter(|name| !name.contains('/'));
        for name in beside.chain(inputs::carried(recording)?) {
            let sum = file_sha256(&recording.join(&name))?;
            self.files.insert(name, sum);
        }
        let text = serde_json::to_string_pretty(&self).expect("numbers and words") + "\n";
        files::replace(&recording.join(checksums::FILE), text.as_bytes())?;
        Ok(sha256(text.as_bytes()))
    }
}

/// Returns the files of a recording, relative to its folder, that should be in its checksums and are not.
fn unsealed(recording: &Path, sums: &Checksums) -> Result<Vec<String>, RecordError> {
    let known = |name: &str| {
        let table = name.strip_suffix(".parquet").is_some_and(|table| sums.tables.contains_key(table));
        let signature = format!("{}.{SIGNATURE}", manifest::FILE);
        let others = [manifest::FILE, checksums::FILE, lock::FILE, &signature];
        table || sums.files.contains_key(name) || others.contains(&name)
    };
    let (mut names, mut folders) = (Vec::new(), vec![String::new()]);
    while let Some(folder) = folders.pop() {
        let path = recording.join(&folder);
        for entry in fs::read_dir(&path).map_err(RecordError::file(&path))? {
            let entry = entry.map_err(RecordError::file(&path))?;
            let own = entry.file_name().to_string_lossy().into_owned();
            let is_begun = Path::new(&own).extension().is_some_and(|ending| ending == files::BESIDE);
            if is_begun || OF_SYSTEMS.contains(&own.as_str()) || (folder.is_empty() && UNSEALED.contains(&own.as_str()))
            {
                continue;
            }
            let name = if folder.is_empty() { own } else { format!("{folder}/{own}") };
            match entry.file_type().map_err(RecordError::file(entry.path()))? {
                kind if kind.is_dir() => folders.push(name),
                _ if known(&name) => {}
                _ => names.push(name),
            }
        }
    }
    names.sort();
    Ok(names)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_is_described_with_its_file() {
        let change = AlteredFile { file: "ego.parquet".into(), what: "is missing".into() };
        assert_eq!(change.to_string(), "ego.parquet: is missing");
    }
}
