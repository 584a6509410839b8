//! What a run is made of, and its fingerprint. In: a [`SweepRun`]. Out: JSON with every setting and the fingerprint of every file that it
//! reads, and SHA-256 of that. It has no path of a machine and no place in a plan: a run that stands in two plans is one run.

use super::{SweepError, SweepRun, plan::SweepTask};
use crate::{policy, record::file_sha256, scenario::Scenario, train::TrainConfig};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::path::Path;

/// Raised when the same settings come to other numbers, or a run to other columns.
const FORMAT: u32 = 1;
/// Letters of a fingerprint: half of SHA-256, which no two of a million runs share.
const LETTERS: usize = 32;

impl SweepRun {
    /// All that decides what the run comes to.
    ///
    /// # Errors
    /// A file that it reads is not there.
    pub fn identity(&self) -> Result<Value, SweepError> {
        let task = match &self.task {
            SweepTask::Rings(task) => json!({
                "config": task.follower().map_err(SweepError::Plan)?,
                "policy": of_policy(&task.policy)?,
                "aim_mps": task.aim_mps,
                "rings": task.rings,
            }),
            SweepTask::Drive(scenario) => of_scenario(scenario)?,
            SweepTask::Training(config) => of_training(config)?,
            SweepTask::Rehearsal(task) => json!({
                "study": of_file(&task.study)?,
                "seed": task.seed,
                "participants": task.participants,
                "population": task.population.name(),
            }),
        };
        Ok(json!({
            "format": FORMAT,
            "program": concat!("codrive ", env!("CARGO_PKG_VERSION")),
            "kind": self.task.kind(),
            "task": task,
        }))
    }

    /// The fingerprint of that, as files are named by it.
    ///
    /// # Errors
    /// As [`SweepRun::identity`].
    pub fn fingerprint(&self) -> Result<String, SweepError> {
        let identity = self.identity()?.to_string();
        let hex: String = Sha256::digest(identity.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect();
        Ok(hex[..LETTERS].to_owned())
    }
}

/// A policy: its name, or the fingerprint of its files.
fn of_policy(name: &str) -> Result<Value, SweepError> {
    let Some(file) = policy::file_of(name) else { return Ok(json!(name)) };
    let files = policy::files_of(&file);
    Ok(json!({ "files": files.iter().map(|file| of_file(file)).collect::<Result<Vec<_>, _>>()? }))
}

/// A file by what is in it.
fn of_file(path: &Path) -> Result<Value, SweepError> {
    Ok(json!({ "sha256": file_sha256(path)? }))
}

/// A scenario, with what is in the files that it names in place of their names.
fn of_scenario(scenario: &Scenario) -> Result<Value, SweepError> {
    let map = scenario.load_map().map_err(|why| SweepError::Plan(why.to_string()))?;
    let mut settings = serde_json::to_value(scenario).unwrap_or_default();
    settings["map"] = of_file(&map.net_file)?;
    settings["policy"] = of_policy(&scenario.policy)?;
    if !scenario.demand.files.is_empty() {
        let files = scenario.demand.files.iter().map(|file| of_file(file)).collect::<Result<Vec<_>, _>>()?;
        settings["demand"]["files"] = json!(files);
    }
    Ok(settings)
}

/// A training, with what it corrects in place of its name.
fn of_training(config: &TrainConfig) -> Result<Value, SweepError> {
    let mut settings = serde_json::to_value(config).unwrap_or_default();
    if config.is_residual() {
        settings["residual_over"] = of_policy(&config.advice.residual_over)?;
    }
    Ok(settings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::SweepPlan;

    fn fingerprints(text: &str) -> Vec<String> {
        let plan = SweepPlan::from_text(text, Path::new("plan.toml")).expect("a plan");
        plan.runs.iter().map(|run| run.fingerprint().expect("its files are there")).collect()
    }

    #[test]
    fn a_run_is_known_by_what_is_run_and_not_by_its_place() {
        let one = "[[drives]]\n[drives.settings]\ntraffic = \"native\"\n[drives.each]\nseed = [1, 2]\n";
        let [first, second] = fingerprints(one).try_into().expect("two runs");
        assert_ne!(first, second);
        assert_eq!(first.len(), LETTERS);
        // The other way round, under another name, with the default written out.
        let other = "[[drives]]\nname = \"waves\"\n[drives.settings]\ntraffic = \"native\"\nvehicles = 22\n[drives.each]\nseed = [2, 1]\n";
        assert_eq!(fingerprints(other), [second, first.clone()]);
        for setting in ["hold_s = 2", "policy = \"pi\"", "driver = \"sloppy\"", "map = \"practice\"", "vehicles = 21"] {
            let changed = one.replace("[drives.each]", &format!("{setting}\n[drives.each]"));
            assert_ne!(fingerprints(&changed)[0], first, "{setting}");
        }
    }

    #[test]
    fn what_stands_in_a_file_counts_and_not_what_the_file_is_called() {
        let dir = tempfile::tempdir().expect("a folder");
        let put = |name: &str, aim: &str| {
            let text = format!("format = \"codrive controller 1\"\nkind = \"constant\"\nspeed_mps = {aim}\n");
            std::fs::write(dir.path().join(name), text).expect("written");
        };
        put("a.toml", "4.0");
        put("b.toml", "4.0");
        put("c.toml", "4.5");
        let text = "[[rings]]\n[rings.each]\npolicy = [\"a.toml\", \"b.toml\", \"c.toml\"]\n";
        let plan = SweepPlan::from_text(text, &dir.path().join("plan.toml")).expect("a plan");
        let all: Vec<String> = plan.runs.iter().map(|run| run.fingerprint().expect("files")).collect();
        assert_eq!(all[0], all[1]);
        assert_ne!(all[0], all[2]);
        let identity = plan.runs[0].identity().expect("files").to_string();
        assert!(!identity.contains(&*dir.path().to_string_lossy()), "{identity}");
    }
}
