//! Execution of one run in this process. In: a [`SweepRun`], and the checkpoint of a training. Out: its part, a Parquet table as bytes. No
//! clock changes it and it keeps no state in the process, so that the bytes are the same on every machine of one kind.

use super::{
    RunCheckpoint, SweepError, SweepRun,
    checkpoint::{opened, sealed},
    identity::fingerprint_of,
    plan::{RehearsalTask, RingsTask, SweepTask},
    rows::{DriveRow, RehearsalRow, RowHead, TrainingRow, drive_columns, rehearsal_columns, training_columns},
};
use crate::{
    analysis::{
        AnalysedRecording, AnalysisError, MEASURES, analyse, find,
        models::{
            plan::PlanHistory,
            planned::{PlannedAnalysis, PlannedOutcome},
        },
    },
    drive_loop::{RunError, evaluation_drive, rehearsal::Rehearsal},
    policy::PolicySource,
    record::parts::parquet_bytes,
    scenario::{PlannedDrive, Scenario},
    sim::WorldError,
    study::Study,
    temporary::TemporaryFolder,
    train::{self, CheckpointClock, Learner, TrainConfig},
};
use std::{path::Path, sync::atomic::AtomicBool};

/// Random stream of the rings, the same as in `codrive evaluate`.
const STREAM: &str = "evaluate";

impl SweepRun {
    /// Executes the run and returns its part, whose metadata identifies the run. A training continues from its checkpoint and keeps a new one
    /// while it runs; the part is the same bytes with and without one.
    ///
    /// # Errors
    /// A file is missing or was changed meanwhile, or a drive cannot start or continue.
    pub fn execute(&self, checkpoint: &dyn RunCheckpoint) -> Result<Vec<u8>, SweepError> {
        let identity = self.identity()?.to_string();
        let run = fingerprint_of(&identity);
        let about = [("codrive.run", identity)];
        let varied = serde_json::Value::Object(self.varied.clone()).to_string();
        let head = |seed: u64| RowHead { run: run.clone(), table: self.table.clone(), varied: varied.clone(), seed };
        let part = match &self.task {
            SweepTask::Rings(task) => parquet_bytes(&drive_columns(), &rings(task, &head(task.config.seed))?, &about)?,
            SweepTask::Drive(scenario) => {
                parquet_bytes(&drive_columns(), &[drive(scenario, head(scenario.seed))?], &about)?
            }
            SweepTask::Training(config) => {
                let report = |text: &str| checkpoint.report(&format!("run {}, {self}: {text}", self.number));
                let learner = trained(config, &run, checkpoint, &report)?;
                parquet_bytes(&training_columns(), &training_rows(&learner, &head(config.seed)), &about)?
            }
            SweepTask::Rehearsal(task) => {
                parquet_bytes(&rehearsal_columns(), &rehearsal(task, &head(task.seed))?, &about)?
            }
        };
        // Otherwise the part's name would not match its rows.
        if self.fingerprint()? != run {
            return Err(SweepError::Run("a file that the run reads was changed during the run".into()));
        }
        Ok(part)
    }
}

/// Evaluates a policy on rings, as `codrive evaluate` does.
fn rings(task: &RingsTask, head: &RowHead) -> Result<Vec<DriveRow>, SweepError> {
    let config = task.follower().map_err(SweepError::Plan)?;
    let source = PolicySource::for_rings(&task.policy, &config.policy_settings(task.policy_speed_mps))
        .map_err(|why| SweepError::Plan(why.to_string()))?;
    let results = train::evaluate(&config, STREAM, task.rings as usize, || source.engage());
    let advised = config.ring.advised.by_policy(&task.policy);
    let row = |(ring, result)| DriveRow {
        head: head.clone(),
        ring,
        map: String::new(),
        traffic: "ring".into(),
        policy: bare(&task.policy),
        driver: if task.driver.is_empty() { "configured".into() } else { task.driver.clone() },
        hold_s: config.advice.hold_s,
        advised_vehicles: advised.of(config.ring.vehicles_max),
        advised_share: config.ring.advised.share_of(config.ring.vehicles_max),
        result,
    };
    Ok((0..).zip(results).map(row).collect())
}

/// Evaluates one whole drive.
fn drive(scenario: &Scenario, head: RowHead) -> Result<DriveRow, SweepError> {
    let planned = PlannedDrive::new(scenario).map_err(|why| RunError::from(WorldError::from(why)))?;
    let advisable = planned.advisable();
    let result = evaluation_drive::evaluate_planned(planned)?;
    let advised = scenario.advised.by_policy(&scenario.policy);
    Ok(DriveRow {
        head,
        ring: 0,
        map: bare(&scenario.map),
        traffic: bare(&scenario.traffic.to_string()),
        policy: bare(&scenario.policy),
        driver: scenario.driver.clone(),
        hold_s: scenario.hold_s,
        advised_vehicles: match (advisable, result.network) {
            (_, Some(network)) => network.advised_vehicles,
            (vehicles, None) => advised.of(vehicles.unwrap_or_default()),
        },
        advised_share: match advisable {
            Some(vehicles) => scenario.advised.share_of(vehicles),
            None => scenario.advised.among(None).share_of(1),
        },
        result,
    })
}

/// Returns the last component of a name or path, which is the same on every machine.
fn bare(name: &str) -> String {
    Path::new(name).file_name().map_or_else(|| name.into(), |last| last.to_string_lossy().into_owned())
}

/// Runs a training to its end, from its checkpoint if there is one. A checkpoint that cannot be read or written is reported, and costs time
/// only.
fn trained(
    config: &TrainConfig,
    run: &str,
    checkpoint: &dyn RunCheckpoint,
    report: &dyn Fn(&str),
) -> Result<Learner, SweepError> {
    let mut learner = match continued(run, checkpoint, report) {
        Some(learner) => learner,
        None => Learner::beside(config, config.corrected_advice().map_err(SweepError::Plan)?),
    };
    let mut clock = CheckpointClock::default();
    while learner.iteration() < learner.config().all_iterations() {
        learner.iterate();
        if clock.is_due() {
            let state = learner.to_checkpoint().map_err(SweepError::Run);
            let saved = state.and_then(|state| checkpoint.save(&sealed(run, &state)?));
            saved.unwrap_or_else(|why| report(&format!("warning: no checkpoint is kept: {why}")));
        }
    }
    learner.learn_silence();
    Ok(learner)
}

/// Returns the training of the run's checkpoint; `None` if there is none or it cannot be used, which is reported.
fn continued(run: &str, checkpoint: &dyn RunCheckpoint, report: &dyn Fn(&str)) -> Option<Learner> {
    let ignored = |why: &dyn std::fmt::Display| {
        report(&format!("warning: the checkpoint is ignored and the training starts anew: {why}"));
    };
    let bytes = checkpoint.load().unwrap_or_else(|why| {
        ignored(&why);
        None
    })?;
    let learner = opened(run, &bytes).and_then(Learner::from_checkpoint).map_err(|why| ignored(&why)).ok()?;
    report(&format!(
        "continues from its checkpoint after update {} of {}",
        learner.iteration(),
        learner.config().all_iterations()
    ));
    Some(learner)
}

/// Returns the rows of a training, one for each update.
fn training_rows(learner: &Learner, head: &RowHead) -> Vec<TrainingRow> {
    let (network, best, _) = learner.best();
    let row = |update: &train::LearningCurveRow| TrainingRow {
        head: head.clone(),
        policy: if update.iteration == best { network.to_toml() } else { String::new() },
        update: *update,
    };
    learner.curve().iter().map(row).collect()
}

/// Runs a rehearsal in a temporary folder and returns its planned analysis.
fn rehearsal(task: &RehearsalTask, head: &RowHead) -> Result<Vec<RehearsalRow>, SweepError> {
    let study = Study::load(&task.study).and_then(|study| study.with_seed(task.seed, &task.study));
    let study = study.map_err(|why| SweepError::Plan(why.to_string()))?;
    let folder = TemporaryFolder::new().map_err(|why| SweepError::Run(format!("no folder for a rehearsal: {why}")))?;
    let root = folder.path().join("data");
    let rehearsal = Rehearsal::open(&study, &root, task.participants)?.out_of(task.population);
    rehearsal.run(&AtomicBool::new(false), &|_| ())?;
    let analysed = (|| -> Result<_, AnalysisError> {
        let found = find(&root)?;
        let drives = analyse(&found.found, &[], &|| ())?;
        let planned = PlannedAnalysis::of(&PlanHistory::of(&root, None)?, &drives, &found.people);
        Ok((drives, planned))
    })();
    let (drives, planned) = analysed.map_err(|why| SweepError::Run(why.to_string()))?;
    let mut rows: Vec<RehearsalRow> = Vec::new();
    for drive in drives.iter().filter(|drive| !drive.found.condition.is_empty()) {
        rows.extend(of_trial(drive, head));
    }
    for outcome in planned.iter().flat_map(|planned| &planned.outcomes) {
        rows.extend(of_outcome(outcome, head));
    }
    Ok(rows)
}

fn of_trial<'a>(drive: &'a AnalysedRecording, head: &'a RowHead) -> impl Iterator<Item = RehearsalRow> + 'a {
    MEASURES.iter().zip(&drive.measures.values).filter(|(_, value)| value.is_some()).map(|(measure, value)| {
        RehearsalRow {
            head: head.clone(),
            kind: "trial",
            participant: drive.found.participant.clone(),
            place: drive.found.place.clone(),
            condition: drive.found.condition.clone(),
            reference: String::new(),
            measure: measure.name.into(),
            value: *value,
            p: [None; 2],
        }
    })
}

fn of_outcome<'a>(outcome: &'a PlannedOutcome, head: &'a RowHead) -> impl Iterator<Item = RehearsalRow> + 'a {
    let contrasts = outcome.fitted.iter().flat_map(|fitted| &fitted.contrasts);
    contrasts.map(|tested| RehearsalRow {
        head: head.clone(),
        kind: "contrast",
        participant: String::new(),
        place: String::new(),
        condition: tested.contrast.condition.clone(),
        reference: tested.contrast.reference.clone(),
        measure: MEASURES[outcome.measure].name.into(),
        value: tested.found.map(|found| found.estimate),
        p: [tested.found.map(|found| found.p), tested.found.map(|_| tested.p_holm)],
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        record::TableReader,
        sweep::{NoCheckpoint, SweepPlan},
    };
    use std::cell::RefCell;

    fn parts(text: &str) -> Vec<(SweepRun, Vec<u8>)> {
        let plan = SweepPlan::from_text(text, Path::new("plan.toml")).expect("a plan");
        plan.runs.into_iter().map(|run| (run.clone(), run.execute(&NoCheckpoint).expect("it runs"))).collect()
    }

    fn table(bytes: &[u8]) -> TableReader {
        let file = tempfile::NamedTempFile::new().expect("a file");
        std::fs::write(file.path(), bytes).expect("written");
        TableReader::parquet(file.path()).expect("a table")
    }

    #[test]
    fn rings_give_the_results_of_evaluate_and_the_same_bytes_each_time() {
        let text = "[[rings]]\nrings = 4\n[rings.settings]\nwarm_up_s = 5\nhorizon_s = 20\ndriver = \"follow\"\n\
                    [rings.each]\npolicy = [\"pi\"]\nseed = [7]\n";
        let (run, bytes) = parts(text).remove(0);
        assert_eq!(bytes, run.execute(&NoCheckpoint).expect("it runs"));
        let SweepTask::Rings(task) = &run.task else { panic!("rings") };
        let config = task.follower().expect("a driver");
        let source = PolicySource::for_rings("pi", &config.policy_settings(0.0)).expect("pi");
        let expected = train::evaluate(&config, "evaluate", 4, || source.engage());
        let expected: Vec<Option<f64>> = expected.iter().map(|result| Some(result.mean_speed_mps)).collect();
        let read = table(&bytes);
        assert_eq!(read.numbers("mean_speed_mps"), expected);
        assert_eq!((read.wholes("seed"), read.wholes("ring")), (vec![7; 4], vec![0, 1, 2, 3]));
    }

    #[test]
    fn a_part_is_the_same_bytes_wherever_its_plan_lies() {
        let made = || {
            let folder = tempfile::tempdir().expect("a folder");
            let policy = "format = \"codrive controller 1\"\nkind = \"constant\"\nspeed_mps = 4.0\n";
            std::fs::write(folder.path().join("calm.toml"), policy).expect("written");
            let rings =
                "[[rings]]\nrings = 1\n[rings.settings]\nwarm_up_s = 1\nhorizon_s = 2\npolicy = \"calm.toml\"\n";
            let drive = "[[drives]]\n[drives.settings]\ntraffic = \"native\"\nduration_s = 1\ntrees = 0\npolicy = \"calm.toml\"\n";
            let plan = SweepPlan::from_text(&(rings.to_owned() + drive), &folder.path().join("plan.toml"));
            plan.expect("a plan")
                .runs
                .iter()
                .map(|run| run.execute(&NoCheckpoint).expect("it runs"))
                .collect::<Vec<_>>()
        };
        let (here, there) = (made(), made());
        assert!(here == there && here.len() == 2);
        assert_eq!(table(&here[0]).words("policy"), ["calm.toml"]);
    }

    /// Store that keeps every state of a test in memory.
    #[derive(Default)]
    struct Kept {
        checkpoint: RefCell<Option<Vec<u8>>>,
        reports: RefCell<Vec<String>>,
    }

    impl RunCheckpoint for Kept {
        fn load(&self) -> Result<Option<Vec<u8>>, SweepError> {
            Ok(self.checkpoint.borrow().clone())
        }

        fn save(&self, checkpoint: &[u8]) -> Result<(), SweepError> {
            *self.checkpoint.borrow_mut() = Some(checkpoint.into());
            Ok(())
        }

        fn report(&self, text: &str) {
            self.reports.borrow_mut().push(text.into());
        }
    }

    #[test]
    fn a_training_continued_from_its_checkpoint_has_the_same_bytes() {
        let text = "[[trainings]]\n[trainings.settings]\niterations = 3\njudge_every = 1\nbatch = 600\nrings = 16\nhorizon_s = 10\nwarm_up_s = 5\n";
        let (run, whole) = parts(text).remove(0);
        let executed = |checkpoint: Option<Vec<u8>>| {
            let kept = Kept { checkpoint: RefCell::new(checkpoint), ..Kept::default() };
            let part = run.execute(&kept).expect("it runs");
            (part, kept.checkpoint.into_inner().expect("a checkpoint"), kept.reports.into_inner())
        };
        // The first checkpoint follows the first update, the next one a minute later.
        let (part, first, reports) = executed(None);
        assert!(part == whole && reports.is_empty(), "{reports:?}");
        let (part, second, reports) = executed(Some(first.clone()));
        assert!(part == whole);
        assert_eq!(reports, ["run 0, trainings 1: continues from its checkpoint after update 1 of 3"]);
        // This one follows the second update.
        let (part, _, reports) = executed(Some(second));
        assert!(part == whole && reports[0].ends_with("after update 2 of 3"), "{reports:?}");

        let fingerprint = run.fingerprint().expect("a fingerprint");
        let state = opened(&fingerprint, &first).expect("whole");
        let older = sealed(&fingerprint, &state.replacen("\"theta\":", "\"weights\":", 1)).expect("small");
        let mut damaged = first.clone();
        *damaged.last_mut().expect("a byte") ^= 1;
        for (useless, why) in [(damaged, "damaged"), (older, "not a checkpoint of this version: ")] {
            let (part, _, reports) = executed(Some(useless));
            let warning = "run 0, trainings 1: warning: the checkpoint is ignored and the training starts anew: ";
            assert!(part == whole && reports.len() == 1, "{reports:?}");
            assert!(reports[0].strip_prefix(warning).is_some_and(|text| text.starts_with(why)), "{reports:?}");
        }

        // The state is used: that of another seed gives other bytes.
        let other = Learner::new(&TrainConfig { seed: 2, ..training(&run).clone() });
        let state = other.to_checkpoint().expect("a state");
        let (part, _, _) = executed(Some(sealed(&fingerprint, &state).expect("small")));
        assert!(part != whole);
    }

    fn training(run: &SweepRun) -> &TrainConfig {
        let SweepTask::Training(config) = &run.task else { panic!("a training") };
        config
    }

    #[test]
    fn rings_and_drives_state_how_many_vehicles_are_advised() {
        let folder = tempfile::tempdir().expect("a folder");
        let log = "time_s,speed_mps\n0,9\n1,9\n2,9\n3,9\n4,9\n";
        std::fs::write(folder.path().join("leader.csv"), log).expect("written");
        let text = "[[rings]]\nrings = 1\n[rings.settings]\nwarm_up_s = 1\nhorizon_s = 2\n[rings.each]\npolicy = [\"pi\", \"none\"]\n\
                    advised = [\"5%\", \"20%\", 3]\n[[drives]]\n[drives.settings]\ntraffic = \"native\"\nduration_s = 1\ntrees = 0\npolicy = \"pi\"\n\
                    [drives.each]\nadvised = [\"20%\", 1]\n[[drives]]\n[drives.settings]\nmap = \"lane-10km\"\ntraffic = \"leader.csv\"\n\
                    vehicles = 12\nduration_s = 3\ntrees = 0\npolicy = \"follower-stopper\"\n[drives.each]\nadvised = [\"20%\"]\n";
        let plan = SweepPlan::from_text(text, &folder.path().join("plan.toml")).expect("a plan");
        let advised: Vec<(u64, f64)> = plan
            .runs
            .iter()
            .map(|run| {
                let read = table(&run.execute(&NoCheckpoint).expect("it runs"));
                (read.wholes("advised_vehicles")[0], read.numbers("advised_share")[0].expect("a share"))
            })
            .collect();
        // Of the 22 vehicles of the ring 1.1 and 4.4, rounded; behind the leader 2.2 of 11. A drive without advice has the share that it is
        // compared with.
        assert_eq!(
            advised,
            [
                (1, 0.05),
                (0, 0.05),
                (4, 0.2),
                (0, 0.2),
                (3, 3.0 / 22.0),
                (0, 3.0 / 22.0),
                (4, 0.2),
                (1, 1.0 / 22.0),
                (2, 0.2)
            ]
        );
    }

    #[test]
    fn a_training_keeps_its_best_policy_in_the_row_of_its_update() {
        let text = "[[trainings]]\n[trainings.settings]\niterations = 3\njudge_every = 1\nbatch = 600\nrings = 16\nhorizon_s = 10\nwarm_up_s = 5\n";
        let read = table(&parts(text)[0].1);
        assert_eq!(read.wholes("iteration"), [1, 2, 3]);
        let judged: Vec<f64> = read.numbers("judged_speed_mps").into_iter().map(|v| v.expect("judged")).collect();
        let best = (0..3).max_by(|a, b| judged[*a].total_cmp(&judged[*b])).expect("three");
        let policies = read.words("policy");
        for (i, policy) in policies.iter().enumerate() {
            assert_eq!(!policy.is_empty(), i == best, "{i}: {judged:?}");
        }
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("policy.toml");
        std::fs::write(&file, &policies[best]).expect("written");
        let settings = TrainConfig::default().policy_settings(0.0);
        assert!(PolicySource::for_rings(&file.display().to_string(), &settings).is_ok());
    }
}
