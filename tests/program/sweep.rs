//! A sweep from the command line: the same tables in every way of running it, finished runs are kept, and failures are reported.

use super::advised::{codrive, printed};
use std::{
    fs,
    path::{Path, PathBuf},
    process::Stdio,
    time::Duration,
};

/// A plan of four drives of 2 s.
const PLAN: &str = "[[drives]]\n[drives.settings]\ntraffic = \"native\"\nduration_s = 2\ntrees = 0\n[drives.each]\npolicy = [\"none\", \"pi\"]\nseed = \"1-2\"\n";

/// Writes a plan into a temporary folder.
fn plan(text: &str) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.toml");
    fs::write(&path, text).unwrap();
    (folder, path)
}

/// Returns names and modification times of the parts in a folder.
fn parts(out: &Path) -> Vec<(String, std::time::SystemTime)> {
    let entries = fs::read_dir(out.join("parts")).unwrap().map(|entry| entry.unwrap());
    // A part has another ending while it is written.
    let mut parts: Vec<_> = entries
        .filter(|entry| entry.path().extension().is_some_and(|ending| ending == "parquet"))
        .map(|entry| (entry.file_name().into_string().unwrap(), entry.metadata().unwrap().modified().unwrap()))
        .collect();
    parts.sort();
    parts
}

#[test]
fn a_cluster_without_the_package_names_another_projects_codrive() {
    let (folder, plan) = plan(PLAN);
    let venv = folder.path().join("venv");
    let made = std::process::Command::new("python3").args(["-m", "venv", "--without-pip"]).arg(&venv).status().unwrap();
    assert!(made.success());
    let on_ray = || {
        let out = folder.path().join("out");
        let mut command = codrive(&["sweep", "--on", "ray", "--out"]);
        printed(command.arg(out).arg(&plan).env("PATH", venv.join("bin")).env_remove("PYTHONPATH"))
    };
    let missing = "python3: the package codrive_sim is missing";
    let (code, text) = on_ray();
    assert!(
        code == 1 && text.starts_with(&format!("{missing}\n")) && text.contains("pip install './python[ray]'"),
        "{text}"
    );
    let packages = fs::read_dir(venv.join("lib")).unwrap().next().unwrap().unwrap().path().join("site-packages");
    fs::write(packages.join("codrive.py"), "").unwrap();
    let (code, text) = on_ray();
    assert!(
        code == 1 && text.starts_with(&format!("{missing}; the package codrive there is another project\n")),
        "{text}"
    );
}

#[test]
fn a_plan_gives_the_same_table_at_once_in_parts_and_repeated() {
    let (folder, plan) = plan(PLAN);
    let out = folder.path().join("whole");
    let sweep = |out: &Path, more: &[&str]| printed(codrive(&["sweep"]).arg(&plan).arg("--out").arg(out).args(more));
    let (code, text) = sweep(&out, &["--workers", "2"]);
    assert!(code == 0 && text.contains("drives.parquet: 4 runs, 4 rows"), "{text}");
    let table = fs::read(out.join("drives.parquet")).unwrap();
    let made = parts(&out);
    assert_eq!(made.len(), 4);

    // No run is repeated.
    let (code, text) = sweep(&out, &[]);
    assert!(code == 0 && parts(&out) == made, "{text}");

    // As two jobs of an array, the last one first, with one worker each.
    let array = folder.path().join("array");
    for part in ["2/2", "1/2"] {
        let (code, text) = sweep(&array, &["--part", part, "--workers", "1"]);
        assert_eq!(code, 0, "{text}");
        assert_eq!(parts(&array).len(), if part == "2/2" { 2 } else { 4 });
        let (code, text) = sweep(&array, &["--collect"]);
        assert!((code == 0) == (part == "1/2"), "{text}");
        assert!(part == "1/2" || text.contains("2 of 4 runs are missing"), "{text}");
    }
    assert_eq!(fs::read(array.join("drives.parquet")).unwrap(), table);

    // A lost part is made again with the same bytes.
    fs::remove_file(array.join("parts").join(&made[1].0)).unwrap();
    let (code, text) = printed(codrive(&["sweep"]).arg(&plan).arg("--out").arg(&array).arg("--list"));
    assert!(code == 0 && text.matches("  done  ").count() == 3 && text.matches("  open  ").count() == 1, "{text}");
    assert_eq!(sweep(&array, &[]).0, 0);
    assert_eq!(
        fs::read(array.join("parts").join(&made[1].0)).unwrap(),
        fs::read(out.join("parts").join(&made[1].0)).unwrap()
    );
}

#[test]
fn a_failed_run_is_retried_and_reported_and_the_others_are_kept() {
    // Policies are read with the plan, and again when their run starts.
    let text = PLAN.replace("\"none\", \"pi\"", "\"none\", \"calm.toml\"");
    let (folder, plan) = plan("");
    let policy = folder.path().join("calm.toml");
    fs::write(&plan, text).unwrap();
    fs::write(&policy, "format = \"codrive controller 1\"\nkind = \"constant\"\nspeed_mps = 4.0\n").unwrap();
    let out = folder.path().join("out");
    // A folder blocks the path of one part.
    let (_, listed) = printed(codrive(&["sweep"]).arg(&plan).arg("--list"));
    let names: Vec<&str> = listed.split_whitespace().filter(|word| word.ends_with(".parquet")).collect();
    assert_eq!(names.len(), 4, "{listed}");
    fs::create_dir_all(out.join("parts").join(names[2])).unwrap();
    let (code, text) = printed(codrive(&["sweep"]).arg(&plan).arg("--out").arg(&out).args(["--retries", "2"]));
    assert!(code == 1 && text.contains("1 runs failed; run the same command again to repeat them"), "{text}");
    assert!(text.contains("seed 1") && text.contains(names[2]), "{text}");
    assert_eq!(names.iter().filter(|name| out.join("parts").join(name).is_file()).count(), 3);
    fs::remove_dir(out.join("parts").join(names[2])).unwrap();
    let (code, text) = printed(codrive(&["sweep"]).arg(&plan).arg("--out").arg(&out));
    assert!(code == 0 && text.contains("4 runs"), "{text}");
}

#[test]
#[allow(clippy::disallowed_methods, reason = "a limit is of the clock on the wall")]
fn a_hanging_run_is_ended_retried_and_reported_and_the_others_are_kept() {
    // Two drives that take a moment, and one that would take hours. The limit leaves the short ones enough time on a busy machine.
    let text = PLAN.replace("[[drives]]\n", "[[drives]]\nlimit_s = 4\n").replace("duration_s = 2\n", "");
    let text = text.replace("policy = [\"none\", \"pi\"]\nseed = \"1-2\"", "duration_s = [600000, 1, 2]");
    let (folder, plan) = plan(&text);
    let out = folder.path().join("out");
    let start = std::time::Instant::now();
    let (code, text) = printed(codrive(&["sweep"]).arg(&plan).arg("--out").arg(&out).args(["--workers", "1"]));
    let failure = "drives 1: duration_s 600000: the run was not done after limit_s, 4 s";
    assert!(code == 1 && text.contains("1 runs failed") && text.contains(failure), "{text}");
    assert_eq!(parts(&out).len(), 2, "{text}");
    // The first attempt and one retry.
    assert!(start.elapsed() >= Duration::from_secs(8), "{:?}", start.elapsed());
}

#[cfg(unix)]
#[test]
fn a_sweep_resumes_after_a_stop_and_after_a_killed_worker() {
    let long = PLAN.replace("duration_s = 2", "duration_s = 120").replace("\"1-2\"", "\"1-4\"");
    let (folder, plan) = plan(&long);
    let out = folder.path().join("out");
    let start = || {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_codrive"));
        command.arg("sweep").arg(&plan).arg("--out").arg(&out).args(["--workers", "2"]);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    };
    let some_parts = |out: &Path| out.join("parts").is_dir() && !parts(out).is_empty();
    let signal = |pid: u32, signal: &str| {
        assert!(std::process::Command::new("kill").args([signal, &pid.to_string()]).status().unwrap().success());
    };
    let child = start();
    while !some_parts(&out) {
        std::thread::sleep(Duration::from_millis(20));
    }
    signal(child.id(), "-INT");
    let ended = child.wait_with_output().unwrap();
    let text = String::from_utf8_lossy(&ended.stderr);
    assert!(
        ended.status.code() == Some(1) && text.contains("stopped; run the same command again to make the missing runs"),
        "{text}"
    );
    let before: Vec<String> = parts(&out).into_iter().map(|part| part.0).collect();
    assert!((1..8).contains(&before.len()), "{before:?}");

    // A killed worker costs its run, which another worker repeats.
    let child = start();
    let workers = format!("/proc/{0}/task/{0}/children", child.id());
    let victim = loop {
        // Threads start the workers, so each worker is a child of a thread.
        let tasks = fs::read_dir(format!("/proc/{}/task", child.id())).unwrap();
        let children = tasks.flatten().filter_map(|task| fs::read_to_string(task.path().join("children")).ok());
        let all: String = children.collect::<Vec<_>>().join(" ");
        if let Some(first) = all.split_whitespace().next() {
            break first.parse().unwrap();
        }
        assert!(Path::new(&workers).exists(), "it ended before a worker was seen");
        std::thread::sleep(Duration::from_millis(5));
    };
    signal(victim, "-KILL");
    let ended = child.wait_with_output().unwrap();
    let text = [ended.stdout, ended.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    assert!(ended.status.success() && text.contains("drives.parquet: 8 runs, 8 rows"), "{text}");
    assert!(parts(&out).len() == 8 && before.iter().all(|name| parts(&out).iter().any(|part| part.0 == *name)));
}

/// A plan of a training of some seconds.
const TRAINING: &str = "[[trainings]]\n[trainings.settings]\niterations = 80\njudge_every = 80\nbatch = 600\nrings = 16\nhorizon_s = 10\nwarm_up_s = 5\n";

#[cfg(unix)]
#[test]
#[allow(clippy::disallowed_methods, reason = "a user waits by the clock on the wall")]
fn a_training_continues_after_ctrl_c_with_the_same_bytes() {
    let (folder, plan) = plan(TRAINING);
    let out = folder.path().join("out");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_codrive"));
    command.arg("sweep").arg(&plan).arg("--out").arg(&out);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let checkpoints = || fs::read_dir(out.join("checkpoints")).map_or(0, |entries| entries.flatten().count());
    while checkpoints() == 0 {
        std::thread::sleep(Duration::from_millis(10));
    }
    let stop = std::time::Instant::now();
    assert!(std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let text = String::from_utf8_lossy(&child.wait_with_output().unwrap().stderr).into_owned();
    // A second is promised; ten times as much are for a machine with other things to do.
    assert!(text.contains("stopped; run the same command again") && stop.elapsed() < Duration::from_secs(10), "{text}");
    assert!(parts(&out).is_empty() && checkpoints() > 0);

    let (code, text) = printed(codrive(&["sweep"]).arg(&plan).arg("--out").arg(&out));
    // The first checkpoint follows the first update, the next one a minute later.
    let report = "run 0, trainings 1: continues from its checkpoint after update 1 of 80";
    assert!(code == 0 && text.contains(report), "{text}");
    assert_eq!((checkpoints(), parts(&out).len()), (0, 1));
    let whole = folder.path().join("whole");
    let (code, text) = printed(codrive(&["sweep"]).arg(&plan).arg("--out").arg(&whole));
    assert!(code == 0 && !text.contains("continues"), "{text}");
    assert_eq!(fs::read(out.join("trainings.parquet")).unwrap(), fs::read(whole.join("trainings.parquet")).unwrap());
}

#[test]
fn a_wrong_plan_is_refused_where_it_is_wrong() {
    let (folder, plan) = plan(&PLAN.replace("duration_s", "duration"));
    let (code, text) = printed(codrive(&["sweep"]).arg(&plan).arg("--out").arg(folder.path().join("out")));
    assert!(code == 2 && text.contains("plan.toml:4:1: unknown key `duration`; did you mean `duration_s`?"), "{text}");
    assert!(!folder.path().join("out").exists(), "nothing is made of a plan that is wrong");
    let gone = folder.path().join("plam.toml");
    let (code, text) = printed(codrive(&["sweep"]).arg(&gone).arg("--out").arg(folder.path().join("out")));
    assert!(code == 2 && text.contains("did you mean plan.toml?"), "{text}");
}
