//! Tests of the plan: combinations and settings against a count by hand, and errors with their position.

use super::*;

fn plan(text: &str) -> SweepPlan {
    SweepPlan::from_text(text, Path::new("plan.toml")).expect("a plan")
}

fn fault(text: &str) -> String {
    SweepPlan::from_text(text, Path::new("plan.toml")).expect_err("no plan").to_string()
}

#[test]
fn a_table_is_all_combinations_of_its_lists() {
    let text = "[[drives]]\nname = \"holds\"\n[drives.settings]\ntraffic = \"native\"\nduration_s = 60\nidm.T = 1.2\n\
                [drives.each]\nhold_s = [1, 2.5]\npolicy = [\"none\", \"pi\"]\nseed = \"3-5\"\n";
    let plan = plan(text);
    // Two holds, two policies and three seeds, the seed changing fastest.
    assert_eq!(plan.runs.len(), 12);
    let all: Vec<(f64, String, u64)> = plan
        .runs
        .iter()
        .map(|run| match &run.task {
            SweepTask::Drive(scenario) => (scenario.hold_s, scenario.policy.clone(), scenario.seed),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(all[0], (1.0, "none".into(), 3));
    assert_eq!(all[1], (1.0, "none".into(), 4));
    assert_eq!(all[3], (1.0, "pi".into(), 3));
    assert_eq!(all[11], (2.5, "pi".into(), 5));
    let SweepTask::Drive(scenario) = &plan.runs[7].task else { panic!("a drive") };
    assert_eq!((scenario.idm.t, scenario.duration_s, plan.runs[7].number), (1.2, 60.0, 7));
    assert_eq!(plan.runs[7].table, "holds");
    assert_eq!(Value::Object(plan.runs[7].varied.clone()).to_string(), r#"{"hold_s":2.5,"policy":"none","seed":4}"#);
}

#[test]
fn every_kind_is_read_with_its_own_settings() {
    let plan = plan(
        "[[rings]]\nrings = 32\n[rings.each]\npolicy = [\"pi\"]\ndriver = [\"follow\", \"people\"]\npolicy_speed_mps = [4.0]\n\
         [[trainings]]\n[trainings.settings]\niterations = 5\n[trainings.each]\nseed = [1, 2]\n\
         [[rehearsals]]\nstudy = \"assets/studies/congestion-short.toml\"\n[rehearsals.settings]\nparticipants = 4\npopulation = \"people\"\n\
         [rehearsals.each]\nseed = \"10-11\"\n",
    );
    let kinds: Vec<&str> = plan.runs.iter().map(|run| run.task.kind()).collect();
    assert_eq!(kinds, ["rings", "rings", "trainings", "trainings", "rehearsals", "rehearsals"]);
    let SweepTask::Rings(rings) = &plan.runs[1].task else { panic!("rings") };
    assert_eq!((rings.rings, rings.driver.as_str(), rings.policy_speed_mps), (32, "people", 4.0));
    let SweepTask::Training(config) = &plan.runs[3].task else { panic!("a training") };
    assert_eq!((config.run.iterations, config.seed), (5, 2));
    let SweepTask::Rehearsal(task) = &plan.runs[5].task else { panic!("a rehearsal") };
    assert_eq!((task.seed, task.participants, task.population), (11, 4, Population::People));
}

#[test]
fn a_mistake_is_reported_with_line_and_column() {
    let drives =
        |each: &str| fault(&format!("[[drives]]\n[drives.settings]\ntraffic = \"native\"\n[drives.each]\n{each}\n"));
    assert!(fault("").contains("there is nothing to run; allowed: tables [[rings]]"), "{}", fault(""));
    assert!(fault("[[drive]]\n").starts_with("plan.toml:1:3: unknown key `drive`; did you mean `drives`?"));
    assert!(
        drives("hold = [1]").starts_with("plan.toml:5:1: unknown key `hold`; did you mean `hold_s`?"),
        "{}",
        drives("hold = [1]")
    );
    assert!(
        drives("hold_s = [1, 700]").starts_with("plan.toml:5:10: hold_s is 700; allowed: a number from 0.01 to 600 s")
    );
    assert!(drives("hold_s = 1").starts_with("plan.toml:5:10: hold_s is 1; allowed: a list"));
    assert!(drives("seed = \"9-3\"").starts_with("plan.toml:5:8: seed is \"9-3\"; allowed: a list, or a range"));
    assert!(drives("seed = []").contains("allowed: a list of one value or more"));
    assert!(drives("traffic = [\"sumo\"]").contains("traffic is also given in settings"));
    assert!(
        drives("policy = [\"pii\"]").contains("policy `pii` is unknown (did you mean pi?)"),
        "{}",
        drives("policy = [\"pii\"]")
    );
    assert!(drives("driver = [\"folow\"]").contains("did you mean follow"));
    assert!(drives("map = [\"ring-25\"]").starts_with("plan.toml:5:7: "), "{}", drives("map = [\"ring-25\"]"));
    assert!(
        drives("seed = \"0-999\"\nhold_s = [1, 2]\nvehicles = \"2-999\"")
            .contains("the table makes more than 1000000 runs")
    );
    let rings = fault("[[rings]]\n[rings.each]\ndriver = [\"peple\"]\n");
    assert!(rings.starts_with("plan.toml:3:10: ") && rings.contains("did you mean people?"), "{rings}");
    let study = fault("[[rehearsals]]\nstudy = \"nowhere.toml\"\n");
    assert!(study.starts_with("plan.toml:2:9: ") && study.contains("cannot be read"), "{study}");
}

#[test]
fn all_mistakes_of_a_plan_are_in_one_report() {
    let text = "[[drives]]\nlimit_s = 0\n[[drives]]\n[drives.settings]\ntraffic = \"native\"\nhold = 1\nvehicles = 1\n\
                [[rings]]\nring = 3\n[[rings]]\nrings = 0\n[[trainings]]\nconfig = 3\n";
    let report = fault(text);
    let places: Vec<&str> = report.lines().filter_map(|line| line.strip_prefix("plan.toml:")).collect();
    let wanted = [
        "2:11: limit_s is 0",
        "6:1: unknown key `hold`",
        "7:12: vehicles is 1",
        "9:1: unknown key `ring`; did you mean `rings`?",
        "11:9: rings is 0",
        "13:10: invalid type: integer `3`",
    ];
    assert!(
        places.len() == wanted.len() && places.iter().zip(wanted).all(|(one, begin)| one.starts_with(begin)),
        "{report}"
    );
}

#[test]
fn files_that_a_plan_names_lie_beside_it() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(
        folder.path().join("calm.toml"),
        "format = \"codrive controller 1\"\nkind = \"constant\"\nspeed_mps = 4.0\n",
    )
    .expect("written");
    std::fs::write(folder.path().join("wave.toml"), "traffic = \"native\"\nvehicles = 20\n").expect("written");
    let text = "[[drives]]\nscenario = \"wave.toml\"\n[drives.each]\npolicy = [\"calm.toml\", \"pi\"]\n";
    let plan = SweepPlan::from_text(text, &folder.path().join("plan.toml")).expect("a plan");
    let drive = |run: &SweepRun| match &run.task {
        SweepTask::Drive(scenario) => (scenario.policy.clone(), scenario.vehicles),
        other => panic!("{other:?}"),
    };
    assert_eq!(drive(&plan.runs[0]), (folder.path().join("calm.toml").display().to_string(), 20));
    assert_eq!(drive(&plan.runs[1]), ("pi".into(), 20));
    let text = "[[drives]]\nscenario = \"wave.toml\"\n[drives.each]\nmap = [\"town.net.xml\"]\n";
    let refusal = SweepPlan::from_text(text, &folder.path().join("plan.toml")).expect_err("no such map").to_string();
    assert!(refusal.contains(&folder.path().join("town.net.xml").display().to_string()), "{refusal}");
}

#[test]
fn a_limit_holds_for_its_table_and_leaves_the_fingerprint_unchanged() {
    let text = "[[drives]]\nlimit_s = 90\n[drives.settings]\ntraffic = \"native\"\n[[drives]]\n[drives.settings]\ntraffic = \"native\"\n";
    let plan = plan(text);
    assert_eq!(plan.runs.iter().map(|run| run.limit_s).collect::<Vec<_>>(), [Some(90.0), None]);
    assert_eq!(plan.runs[0].fingerprint().expect("files"), plan.runs[1].fingerprint().expect("files"));
    let refusal = fault(&text.replace("90", "0"));
    assert!(refusal.starts_with("plan.toml:2:11: limit_s is 0; allowed: a number from 0.1 to 8640000 s"), "{refusal}");
}
