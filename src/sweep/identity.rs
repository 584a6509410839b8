//! Identity of a run and its fingerprint. In: a [`SweepRun`]. Out: JSON with every setting and the fingerprint of every file that it
//! reads, and the SHA-256 of that JSON. It contains no path of a machine and no position in a plan, so that equal runs of two plans are
//! one run.

use super::{SweepError, SweepRun, file_fingerprints::sha256_of, plan::SweepTask};
use crate::{policy, scenario::Scenario, traffic::is_population_path, train::TrainConfig};
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// Raised when the same settings come to other numbers, or a run to other columns.
const FORMAT: u32 = 2;
/// Length of a fingerprint in hexadecimal digits: half of SHA-256, unique among a million runs.
const LETTERS: usize = 32;

impl SweepRun {
    /// Returns everything that determines the result of the run.
    ///
    /// # Errors
    /// A file that the run reads is missing.
    pub fn identity(&self) -> Result<Value, SweepError> {
        let task = match &self.task {
            SweepTask::Rings(task) => json!({
                "config": of_training(&task.follower().map_err(SweepError::Plan)?)?,
                "policy": of_policy(&task.policy)?,
                "policy_speed_mps": task.policy_speed_mps,
                "rings": task.rings,
            }),
            SweepTask::Drive(scenario) => of_scenario(scenario)?,
            SweepTask::Training(config) => of_training(config)?,
            SweepTask::Rehearsal(task) => json!({
                "study": of_file(&task.study)?,
                "files": in_any_order(&task.reads)?,
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

    /// Returns the fingerprint of the identity, which names the run's file.
    ///
    /// # Errors
    /// The errors of [`SweepRun::identity`].
    pub fn fingerprint(&self) -> Result<String, SweepError> {
        Ok(fingerprint_of(&self.identity()?.to_string()))
    }
}

/// Returns the fingerprint of an identity.
pub(super) fn fingerprint_of(identity: &str) -> String {
    let hex: String = Sha256::digest(identity.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect();
    hex[..LETTERS].to_owned()
}

/// Returns the name of a policy, or the fingerprints of its files.
fn of_policy(name: &str) -> Result<Value, SweepError> {
    let Some(file) = policy::file_of(name) else { return Ok(json!(name)) };
    Ok(json!({ "files": of_files(&policy::files_of(&file))? }))
}

/// Returns the fingerprints of files in the given order.
fn of_files(files: &[PathBuf]) -> Result<Vec<Value>, SweepError> {
    files.iter().map(|file| of_file(file)).collect()
}

/// Returns the sorted fingerprints of files, since the order of their paths depends on the machine.
fn in_any_order(files: &[PathBuf]) -> Result<Vec<String>, SweepError> {
    let mut files = files.iter().map(|file| sha256_of(file)).collect::<Result<Vec<_>, _>>()?;
    files.sort();
    files.dedup();
    Ok(files)
}

/// Returns the fingerprint of a file's content.
fn of_file(path: &Path) -> Result<Value, SweepError> {
    Ok(json!({ "sha256": sha256_of(path)? }))
}

/// Returns a scenario with the names of its files replaced by the files' fingerprints.
fn of_scenario(scenario: &Scenario) -> Result<Value, SweepError> {
    let mut settings = serde_json::to_value(scenario).unwrap_or_default();
    for (setting, files) in scenario.files().map_err(|why| SweepError::Plan(why.to_string()))? {
        let named = setting.split('.').fold(&mut settings, |at, key| &mut at[key]);
        *named = json!({ "files": of_files(&files)? });
    }
    Ok(settings)
}

/// Returns a training with the corrected policy and the populations of drivers that are files replaced by their fingerprints.
fn of_training(config: &TrainConfig) -> Result<Value, SweepError> {
    let mut settings = serde_json::to_value(config).unwrap_or_default();
    if config.is_residual() {
        settings["residual_over"] = of_policy(&config.advice.residual_over)?;
    }
    let population = |name| if is_population_path(name) { of_file(Path::new(name)) } else { Ok(json!(name)) };
    settings["traffic_drivers"] = config.ring.populations().map(population).collect::<Result<_, _>>()?;
    Ok(settings)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{map::RoadMap, sweep::SweepPlan};

    fn fingerprints(text: &str) -> Vec<String> {
        let plan = SweepPlan::from_text(text, Path::new("plan.toml")).expect("a plan");
        plan.runs.iter().map(|run| run.fingerprint().expect("its files are there")).collect()
    }

    #[test]
    fn a_run_is_identified_by_its_content_and_not_by_its_place_in_a_plan() {
        let one = "[[drives]]\n[drives.settings]\ntraffic = \"native\"\n[drives.each]\nseed = [1, 2]\n";
        let [first, second] = fingerprints(one).try_into().expect("two runs");
        assert_ne!(first, second);
        assert_eq!(first.len(), LETTERS);
        // The seeds in reverse order, with another name and the default written out.
        let other = "[[drives]]\nname = \"waves\"\n[drives.settings]\ntraffic = \"native\"\nvehicles = 22\n[drives.each]\nseed = [2, 1]\n";
        assert_eq!(fingerprints(other), [second, first.clone()]);
        for setting in ["hold_s = 2", "policy = \"pi\"", "driver = \"sloppy\"", "map = \"practice\"", "vehicles = 21"] {
            let changed = one.replace("[drives.each]", &format!("{setting}\n[drives.each]"));
            assert_ne!(fingerprints(&changed)[0], first, "{setting}");
        }
    }

    #[test]
    fn a_log_counts_by_its_content_and_not_where_it_lies() {
        let folder = tempfile::tempdir().expect("a folder");
        let print_of = |name: &str, speed: u32| {
            let file = folder.path().join(name);
            std::fs::write(&file, format!("time_s,speed_mps\n0,{speed}\n1,{speed}\n")).expect("written");
            let settings = format!("map = \"lane-10km\"\ntraffic = {:?}", file.to_str().expect("a name"));
            fingerprints(&format!("[[drives]]\n[drives.settings]\n{settings}\nduration_s = 1\n")).remove(0)
        };
        assert_eq!(print_of("one.csv", 9), print_of("two.csv", 9));
        assert_ne!(print_of("one.csv", 9), print_of("one.csv", 8));
    }

    #[test]
    fn populations_and_demands_count_by_their_content_and_not_where_they_lie() {
        let shipped = crate::data_folders::root().join("assets/populations/gap-closers.toml");
        let people = std::fs::read_to_string(shipped).expect("a shipped population");
        let identity = |name: &str, people: &str| {
            let folder = tempfile::tempdir().expect("a folder");
            std::fs::write(folder.path().join(name), people).expect("written");
            std::fs::write(folder.path().join("signs.add.xml"), "<additional/>").expect("written");
            std::fs::write(
                folder.path().join("drive.toml"),
                "map = \"merge\"\nduration_s = 1\n[demand]\nadditional_files = [\"signs.add.xml\"]\n",
            )
            .expect("written");
            let text = format!(
                "[[drives]]\nscenario = \"drive.toml\"\n[[trainings]]\n[trainings.settings]\ntraffic_drivers = \"{name}, gap-closers\"\n\
                 [[rings]]\n[rings.settings]\ntraffic_drivers = \"{name}\"\n[[drives]]\n[drives.settings]\ntraffic = \"native\"\n\
                 duration_s = 1\ntraffic_drivers = \"{name}\"\n"
            );
            let plan = SweepPlan::from_text(&text, &folder.path().join("plan.toml")).expect("a plan");
            let of = |run: &crate::sweep::SweepRun| run.identity().expect("its files are there").to_string();
            let all: Vec<String> = plan.runs.iter().map(of).collect();
            assert!(!all.concat().contains(&*folder.path().to_string_lossy()), "{all:?}");
            all
        };
        let one = identity("one.toml", &people);
        assert_eq!(one, identity("two.toml", &people));
        let other = identity("one.toml", &(people + "# another text\n"));
        // Rings, both drives, the training: all but the first drive have the population.
        assert_eq!((0..4).filter(|k| one[*k] != other[*k]).collect::<Vec<_>>(), [0, 2, 3]);
    }

    #[test]
    fn all_files_of_a_map_count_and_not_where_it_lies() {
        let folder = tempfile::tempdir().expect("a folder");
        let map = folder.path().join("mine");
        std::fs::create_dir(&map).expect("a folder");
        let shipped = RoadMap::files("ring-250").expect("a map");
        shipped.iter().for_each(|file| {
            std::fs::copy(file, map.join(file.file_name().expect("a name"))).expect("copied");
        });
        let drive = |name: &str| format!("[[drives]]\n[drives.settings]\ntraffic = \"native\"\nmap = \"{name}\"\n");
        let print = |text: &str| {
            let plan = SweepPlan::from_text(text, &folder.path().join("plan.toml")).expect("a plan");
            plan.runs[0].fingerprint().expect("its files are there")
        };
        let there = print(&drive("ring-250"));
        assert_eq!(print(&drive("./mine")), there);
        let about = std::fs::read_to_string(map.join("map.toml")).expect("a text");
        std::fs::write(map.join("map.toml"), about + "# the other way round\n").expect("written");
        let changed = print(&drive("./mine"));
        assert_ne!(changed, there);
        std::fs::write(map.join("demand.rou.xml"), "<routes/>").expect("written");
        assert_ne!(print(&drive("./mine")), changed);
    }

    #[test]
    fn files_that_a_studys_drives_read_are_part_of_the_fingerprint() {
        let folder = tempfile::tempdir().expect("a folder");
        let policy = folder.path().join("calm.toml");
        let aim = |mps: f64| {
            let text = format!("format = \"codrive controller 1\"\nkind = \"constant\"\nspeed_mps = {mps}\n");
            std::fs::write(&policy, text).expect("written");
        };
        aim(4.0);
        let lead = |mps: u32| {
            let rows: String = (0..30).map(|second| format!("{second},{mps}\n")).collect();
            std::fs::write(folder.path().join("leader.csv"), format!("time_s,speed_mps\n{rows}")).expect("written");
        };
        lead(9);
        let shipped = crate::data_folders::root().join("assets/populations/gap-closers.toml");
        let people = std::fs::read_to_string(shipped).expect("a shipped population");
        let drivers = |text: &str| std::fs::write(folder.path().join("people.toml"), text).expect("written");
        drivers(&people);
        let study = format!(
            "title = \"Short\"\nparticipants = 4\nseed = 1\norder = \"williams\"\n[base]\ntraffic = \"native\"\nduration_s = 10\n[[condition]]\nname = \"advised\"\nset = {{ policy = {policy:?} }}\n\
             [[condition]]\nname = \"free\"\nset = {{ policy = \"none\" }}\n\
             [[condition]]\nname = \"led\"\nset = {{ policy = \"none\", map = \"lane-10km\", traffic = \"leader.csv\", vehicles = 4 }}\n\
             [[condition]]\nname = \"people\"\nset = {{ policy = \"none\", traffic_drivers = \"people.toml\" }}\n\
             [[segment]]\nname = \"drives\"\nkind = \"trials\"\n"
        );
        std::fs::write(folder.path().join("study.toml"), study).expect("written");
        let print = || {
            let text = "[[rehearsals]]\nstudy = \"study.toml\"\n";
            let plan = SweepPlan::from_text(text, &folder.path().join("plan.toml")).expect("a plan");
            plan.runs[0].fingerprint().expect("its files are there")
        };
        let first = print();
        aim(4.5);
        assert_ne!(print(), first);
        aim(4.0);
        lead(8);
        assert_ne!(print(), first, "a log");
        lead(9);
        drivers(&format!("{people}# another text\n"));
        assert_ne!(print(), first, "a population");
        drivers(&people);
        assert_eq!(print(), first);
    }

    #[test]
    fn the_content_of_a_file_counts_and_not_its_name() {
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
