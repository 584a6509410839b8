//! The folder of a sweep. In: a plan and a folder. Out: finished and missing runs; one part per finished run, written once; and one
//! combined table per kind.
//!
//! ```text
//! parts/drives-FINGERPRINT.parquet     one run, complete or absent; its metadata (codrive.run) identify the run
//! checkpoints/trainings-FINGERPRINT    state of a training that is not done, complete or absent
//! drives.parquet  rings.parquet  trainings.parquet  rehearsals.parquet     all runs of a plan, in its order
//! policies/FINGERPRINT.toml            the best policy of each training
//! ```
//! A part is identified by the run alone. So a second start makes only what is missing, and plans and machines can share a folder: two
//! processes that make the same run write the same bytes.

use super::{RunCheckpoint, SweepError, SweepPlan, SweepRun};
use crate::{
    file::read_bounded,
    private,
    record::{self, RecordError, TableReader, parts},
    train::CHECKPOINT_BYTES,
};
use std::{
    collections::BTreeMap,
    fs,
    io::ErrorKind,
    path::{Path, PathBuf},
};

/// Name of the folder of parts.
const PARTS: &str = "parts";
/// Name of the folder of checkpoints.
const CHECKPOINTS: &str = "checkpoints";
/// Name of the folder of trained policies.
const POLICIES: &str = "policies";

/// The folder of a sweep's results.
#[derive(Clone, Debug)]
pub struct SweepFolder {
    root: PathBuf,
}

/// A combined table of all runs of one kind.
#[derive(Clone, Debug, PartialEq)]
pub struct CollectedTable {
    /// Path of the table.
    pub path: PathBuf,
    /// Number of runs in the table.
    pub runs: usize,
    /// Number of rows in the table.
    pub rows: u64,
}

impl SweepRun {
    /// Returns the file name of the run's part.
    ///
    /// # Errors
    /// A file that the run reads is missing.
    pub fn part_name(&self) -> Result<String, SweepError> {
        Ok(format!("{}-{}.parquet", self.task.kind(), self.fingerprint()?))
    }
}

impl SweepFolder {
    /// Opens a folder, creating it if necessary.
    ///
    /// # Errors
    /// The folder cannot be created, or a link is in place of one of its folders.
    pub fn open(root: &Path) -> Result<Self, SweepError> {
        record::new_dir_within(root, &root.join(PARTS))?;
        for name in [CHECKPOINTS, POLICIES] {
            let path = root.join(name);
            private::check_way(root, &path).map_err(|why| RecordError::File { path, why })?;
        }
        Ok(Self { root: root.into() })
    }

    /// Returns the path of the folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    /// Returns the path of a part, existing or not.
    pub fn part(&self, name: &str) -> PathBuf {
        self.root.join(PARTS).join(name)
    }

    /// Writes a part atomically: it is complete or absent, also after a power failure. Then removes the checkpoint of the run.
    ///
    /// # Errors
    /// The part cannot be written, or the checkpoint cannot be removed.
    pub fn put(&self, name: &str, bytes: &[u8]) -> Result<(), SweepError> {
        record::replace(&self.part(name), bytes)?;
        let checkpoint = self.checkpoint(name);
        match fs::remove_file(&checkpoint) {
            Err(why) if why.kind() != ErrorKind::NotFound => Err(of_checkpoint(&checkpoint, &why)),
            _ => Ok(()),
        }
    }

    /// Returns the path of the checkpoint of the run with this part, existing or not.
    pub fn checkpoint(&self, name: &str) -> PathBuf {
        self.root.join(CHECKPOINTS).join(Path::new(name).with_extension(""))
    }

    /// Returns the runs without a part. Computes the fingerprints of all runs.
    ///
    /// # Errors
    /// A file that a run reads is missing.
    pub fn missing<'a>(&self, runs: &'a [SweepRun]) -> Result<Vec<&'a SweepRun>, SweepError> {
        let mut missing = Vec::new();
        for run in runs {
            if !self.part(&run.part_name()?).is_file() {
                missing.push(run);
            }
        }
        Ok(missing)
    }

    /// Combines all finished runs of a plan into one table per kind, and writes the policies of trainings to files.
    ///
    /// # Errors
    /// A part cannot be read, or a file cannot be written.
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

    /// Writes the best policy of a training to a file.
    fn put_policy(&self, part: &Path) -> Result<(), RecordError> {
        let table = TableReader::parquet(part)?;
        let folder = self.root.join(POLICIES);
        record::new_dir_within(&self.root, &folder)?;
        for (run, policy) in table.words("run").into_iter().zip(table.words("policy")) {
            if !policy.is_empty() {
                record::replace(&folder.join(format!("{run}.toml")), policy.as_bytes())?;
            }
        }
        Ok(())
    }
}

/// Returns the error of a checkpoint that cannot be read or removed.
fn of_checkpoint(path: &Path, why: &std::io::Error) -> SweepError {
    SweepError::Run(format!("{}: {why}", path.display()))
}

/// Checkpoint of a run as a file, with a function that takes its reports.
pub struct CheckpointFile<'a> {
    /// Path of the checkpoint.
    pub path: PathBuf,
    /// Function that takes the reports.
    pub report: &'a dyn Fn(&str),
}

impl RunCheckpoint for CheckpointFile<'_> {
    fn load(&self) -> Result<Option<Vec<u8>>, SweepError> {
        match read_bounded(&self.path, CHECKPOINT_BYTES) {
            Ok(checkpoint) => Ok(Some(checkpoint)),
            Err(why) if why.kind() == ErrorKind::NotFound => Ok(None),
            Err(why) => Err(of_checkpoint(&self.path, &why)),
        }
    }

    fn save(&self, checkpoint: &[u8]) -> Result<(), SweepError> {
        record::new_private_dir(self.path.parent().unwrap_or(Path::new("")))?;
        Ok(record::replace(&self.path, checkpoint)?)
    }

    fn report(&self, text: &str) {
        (self.report)(text);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::NoCheckpoint;

    #[test]
    fn finished_runs_are_not_missing_and_tables_follow_the_plans_order() {
        let dir = tempfile::tempdir().expect("a folder");
        let text =
            "[[rings]]\nrings = 1\n[rings.settings]\nwarm_up_s = 1\nhorizon_s = 2\n[rings.each]\nseed = \"1-3\"\n";
        let plan = SweepPlan::from_text(text, Path::new("plan.toml")).expect("a plan");
        let folder = SweepFolder::open(&dir.path().join("out")).expect("a folder");
        assert_eq!(folder.missing(&plan.runs).expect("files").len(), 3);
        // The last two runs, in reverse order.
        for run in plan.runs.iter().rev().take(2) {
            folder
                .put(&run.part_name().expect("a name"), &run.execute(&NoCheckpoint).expect("it runs"))
                .expect("written");
        }
        let missing = folder.missing(&plan.runs).expect("files");
        assert_eq!(missing.iter().map(|run| run.number).collect::<Vec<_>>(), [0]);
        let tables = folder.collect(&plan).expect("collected");
        assert_eq!(tables.iter().map(|table| (table.runs, table.rows)).collect::<Vec<_>>(), [(2, 2)]);
        assert_eq!(TableReader::parquet(&tables[0].path).expect("a table").wholes("seed"), [2, 3]);
    }

    #[cfg(unix)]
    #[test]
    fn a_folder_of_a_sweep_is_no_link_but_the_sweep_itself_may_be_one() {
        let dir = tempfile::tempdir().expect("a folder");
        let (disk, link) = (dir.path().join("disk"), dir.path().join("link"));
        fs::create_dir(&disk).expect("a folder");
        std::os::unix::fs::symlink(&disk, &link).expect("a link");
        SweepFolder::open(&link).expect("the user's own link");
        for name in [PARTS, CHECKPOINTS, POLICIES] {
            let _ = fs::remove_dir(disk.join(name));
            std::os::unix::fs::symlink(dir.path(), disk.join(name)).expect("a link");
            let error = SweepFolder::open(&link).expect_err(name).to_string();
            assert!(error.contains(&format!("{name} is a symbolic link")) && error.contains("remedy"), "{error}");
            fs::remove_file(disk.join(name)).expect("removed");
        }
    }

    #[test]
    fn a_checkpoint_is_replaced_and_goes_when_the_part_is_there() {
        let dir = tempfile::tempdir().expect("a folder");
        let folder = SweepFolder::open(&dir.path().join("out")).expect("a folder");
        let name = "trainings-0a1b.parquet";
        let file = CheckpointFile { path: folder.checkpoint(name), report: &|_| () };
        assert_eq!(file.path, dir.path().join("out/checkpoints/trainings-0a1b"));
        assert_eq!(file.load().expect("readable"), None);
        for state in [&b"one"[..], b"two"] {
            file.save(state).expect("written");
            assert_eq!(file.load().expect("readable").as_deref(), Some(state));
        }
        folder.put(name, b"part").expect("written");
        assert_eq!(file.load().expect("readable"), None);
        // A part without a checkpoint is written as well.
        folder.put(name, b"part").expect("written");
        // What is no file is an error, and not a missing checkpoint.
        std::fs::create_dir(&file.path).expect("a folder");
        assert!(file.load().is_err());
    }
}
