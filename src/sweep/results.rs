//! The folder of a sweep. In: a plan and a folder. Out: which of its runs are there; a part for each that is made, written once; all of
//! them in one table a kind.
//!
//! ```text
//! parts/drives-FINGERPRINT.parquet     a run, whole or not there; its metadata (codrive.run) say what it is of
//! drives.parquet  rings.parquet  trainings.parquet  rehearsals.parquet     all runs of a plan, in its order
//! policies/FINGERPRINT.toml            the best policy of each training
//! ```
//! A part is known by what was run alone, so that a second start makes what is missing, plans may share a folder, and machines may,
//! too: whoever comes second writes the same bytes.

use super::{SweepError, SweepPlan, SweepRun};
use crate::record::{self, RecordError, TableReader, parts};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

/// Folder of the parts.
const PARTS: &str = "parts";
/// Folder of trained policies.
const POLICIES: &str = "policies";

/// A folder of results.
#[derive(Clone, Debug)]
pub struct SweepFolder {
    root: PathBuf,
}

/// A table of all runs of a kind.
#[derive(Clone, Debug, PartialEq)]
pub struct CollectedTable {
    /// Its file.
    pub path: PathBuf,
    /// How many runs are in it.
    pub runs: usize,
    /// How many rows.
    pub rows: u64,
}

impl SweepRun {
    /// Name of its part, in the folder of parts.
    ///
    /// # Errors
    /// A file that it reads is not there.
    pub fn part_name(&self) -> Result<String, SweepError> {
        Ok(format!("{}-{}.parquet", self.task.kind(), self.fingerprint()?))
    }
}

impl SweepFolder {
    /// Opens a folder, or makes it.
    ///
    /// # Errors
    /// The system refuses.
    pub fn open(root: &Path) -> Result<Self, SweepError> {
        record::new_private_dir(&root.join(PARTS))?;
        Ok(Self { root: root.into() })
    }

    /// Where it is.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Where a part is, or would be.
    pub fn part(&self, name: &str) -> PathBuf {
        self.root.join(PARTS).join(name)
    }

    /// Writes a part: it is there whole or not at all, also after a power cut.
    ///
    /// # Errors
    /// The system refuses.
    pub fn put(&self, name: &str, bytes: &[u8]) -> Result<(), SweepError> {
        Ok(record::replace(&self.part(name), bytes)?)
    }

    /// Which runs of a plan are not there. Fingerprints are taken of all of them.
    ///
    /// # Errors
    /// A file that a run reads is not there.
    pub fn missing<'a>(&self, runs: &'a [SweepRun]) -> Result<Vec<&'a SweepRun>, SweepError> {
        let mut missing = Vec::new();
        for run in runs {
            if !self.part(&run.part_name()?).is_file() {
                missing.push(run);
            }
        }
        Ok(missing)
    }

    /// Puts all runs of a plan that are there into one table a kind, and the policies of trainings into files.
    ///
    /// # Errors
    /// A part cannot be read, or the system refuses.
    pub fn collect(&self, plan: &SweepPlan) -> Result<Vec<CollectedTable>, SweepError> {
        let mut kinds: BTreeMap<&str, Vec<PathBuf>> = BTreeMap::new();
        for run in &plan.runs {
            let part = self.part(&run.part_name()?);
            let parts = kinds.entry(run.task.kind()).or_default();
            if part.is_file() && !parts.contains(&part) {
                parts.push(part);
            }
        }
        let mut tables = Vec::new();
        for (kind, found) in kinds.into_iter().filter(|(_, found)| !found.is_empty()) {
            let path = self.root.join(format!("{kind}.parquet"));
            let rows = parts::join(&found, &path)?;
            if kind == "trainings" {
                found.iter().try_for_each(|part| self.put_policy(part))?;
            }
            tables.push(CollectedTable { path, runs: found.len(), rows });
        }
        Ok(tables)
    }

    /// The best policy of a training as a file.
    fn put_policy(&self, part: &Path) -> Result<(), RecordError> {
        let table = TableReader::parquet(part)?;
        let folder = self.root.join(POLICIES);
        record::new_private_dir(&folder)?;
        for (run, policy) in table.words("run").into_iter().zip(table.words("policy")) {
            if !policy.is_empty() {
                record::replace(&folder.join(format!("{run}.toml")), policy.as_bytes())?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_there_is_not_missing_and_the_table_is_in_the_order_of_the_plan() {
        let dir = tempfile::tempdir().expect("a folder");
        let text =
            "[[rings]]\nrings = 1\n[rings.settings]\nwarm_up_s = 1\nhorizon_s = 2\n[rings.each]\nseed = \"1-3\"\n";
        let plan = SweepPlan::from_text(text, Path::new("plan.toml")).expect("a plan");
        let folder = SweepFolder::open(&dir.path().join("out")).expect("a folder");
        assert_eq!(folder.missing(&plan.runs).expect("files").len(), 3);
        // The last comes first.
        for run in plan.runs.iter().rev().take(2) {
            folder.put(&run.part_name().expect("a name"), &run.execute().expect("it runs")).expect("written");
        }
        let missing = folder.missing(&plan.runs).expect("files");
        assert_eq!(missing.iter().map(|run| run.number).collect::<Vec<_>>(), [0]);
        let tables = folder.collect(&plan).expect("collected");
        assert_eq!(tables.iter().map(|table| (table.runs, table.rows)).collect::<Vec<_>>(), [(2, 2)]);
        assert_eq!(TableReader::parquet(&tables[0].path).expect("a table").wholes("seed"), [2, 3]);
    }
}
