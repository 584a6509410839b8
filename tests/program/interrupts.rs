//! Signals that end a wait for SUMO: for a trial of the files in its own process, and for SUMO's reading in this process, which cannot be
//! interrupted.

use std::{
    fs,
    io::Read,
    path::PathBuf,
    process::{Child, Command, ExitStatus, Stdio},
    thread::sleep,
    time::{Duration, Instant},
};

/// A drive on the merge without a participant, and its folder for temporary files.
struct SlowDrive {
    folder: tempfile::TempDir,
    program: Child,
}

impl SlowDrive {
    /// Starts a drive in which SUMO reads its files for 60 s, with the user's own demand or the map's.
    fn begin(with_own_demand: bool) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::create_dir(at("tmp")).unwrap();
        let own = "<routes><flow id=\"f\" from=\"inflow_highway\" to=\"center\" begin=\"0\" end=\"9\" period=\"2\"/></routes>";
        fs::write(at("own.rou.xml"), own).unwrap();
        let demand = if with_own_demand { "[demand]\nfiles = [\"own.rou.xml\"]\n" } else { "" };
        fs::write(at("drive.toml"), format!("map = \"merge\"\nparticipant = false\nduration_s = 5.0\n{demand}"))
            .unwrap();
        let program = Command::new(env!("CARGO_BIN_EXE_codrive"))
            .args(["run", "--scenario", "drive.toml"])
            .current_dir(folder.path())
            .env("TMPDIR", at("tmp"))
            .env("CODRIVE_SUMO_READS_S", "60")
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        Self { folder, program }
    }

    /// Returns the entries of the folder for temporary files.
    fn temporary(&self) -> Vec<PathBuf> {
        fs::read_dir(self.folder.path().join("tmp")).unwrap().map(|entry| entry.unwrap().path()).collect()
    }

    /// Returns the id of the process that tries the files.
    fn trial(&self) -> Option<u32> {
        let id = self.program.id();
        let mut tasks = fs::read_dir(format!("/proc/{id}/task")).unwrap();
        tasks.find_map(|task| {
            let children = fs::read_to_string(task.unwrap().path().join("children")).ok()?;
            children.split_whitespace().next()?.parse().ok()
        })
    }

    fn signal(&self, name: &str) {
        assert!(Command::new("kill").arg(name).arg(self.program.id().to_string()).status().unwrap().success());
    }

    /// Waits at most 1 s for the end of the program. Returns its exit status and standard error.
    fn ended(&mut self) -> (ExitStatus, String) {
        let status = within("the end of the program", Duration::from_secs(1), || self.program.try_wait().unwrap());
        let mut printed = String::new();
        self.program.stderr.take().unwrap().read_to_string(&mut printed).unwrap();
        (status, printed)
    }
}

impl Drop for SlowDrive {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}

fn within<T>(what: &str, limit: Duration, mut look: impl FnMut() -> Option<T>) -> T {
    #[expect(clippy::disallowed_methods, reason = "the promise is one of wall time")]
    let begun = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(begun.elapsed() < limit, "{what}: not within {limit:?}");
        sleep(Duration::from_millis(10));
    }
}

const LONG: Duration = Duration::from_secs(10);

fn is_alive(process: u32) -> bool {
    // A process that has ended but was not yet waited for is a zombie.
    let state = fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    state.rsplit(") ").next().is_some_and(|rest| !rest.is_empty() && !rest.starts_with('Z'))
}

#[test]
fn a_program_whose_sumo_reads_a_file_ends_within_a_second_of_each_signal() {
    for signal in ["-INT", "-TERM"] {
        let mut drive = SlowDrive::begin(false);
        within("a temporary folder", LONG, || (!drive.temporary().is_empty()).then_some(()));
        // By then the program is inside the call of SUMO.
        sleep(Duration::from_millis(300));
        drive.signal(signal);
        let (status, printed) = drive.ended();
        assert_eq!(status.code(), Some(130), "{signal}: {printed}");
        assert!(printed.contains("ended while SUMO was reading its files"), "{printed}");
        assert_eq!(drive.temporary(), [""; 0].map(PathBuf::from), "{signal}");
    }
}

#[test]
fn a_trial_is_named_after_two_seconds_and_ends_with_its_program() {
    let mut drive = SlowDrive::begin(true);
    let trial = within("a trial", LONG, || drive.trial());
    sleep(Duration::from_millis(2500));
    drive.signal("-INT");
    let (status, printed) = drive.ended();
    assert_eq!(status.code(), Some(130), "{printed}");
    assert!(printed.contains("codrive: testing ") && printed.contains("own.rou.xml on "), "{printed}");
    assert!(printed.contains("in SUMO, up to 120 s; Ctrl-C stops the test\n"), "{printed}");
    assert!(!is_alive(trial));
    assert_eq!(drive.temporary(), [""; 0].map(PathBuf::from));
}

#[test]
fn a_trial_ends_with_its_killed_program_and_the_next_start_cleans_up() {
    let mut drive = SlowDrive::begin(true);
    let trial = within("a trial", LONG, || drive.trial());
    drive.program.kill().unwrap();
    drive.program.wait().unwrap();
    within("the end of the trial", Duration::from_secs(1), || (!is_alive(trial)).then_some(()));
    assert!(!drive.temporary().is_empty(), "it had no time to remove its folders");
    let next = Command::new(env!("CARGO_BIN_EXE_codrive"))
        .args(["run", "--map", "merge", "--participant", "false", "--duration", "1"])
        .env("TMPDIR", drive.folder.path().join("tmp"))
        .output()
        .unwrap();
    assert!(next.status.success(), "{}", String::from_utf8_lossy(&next.stderr));
    assert_eq!(drive.temporary(), [""; 0].map(PathBuf::from));
}
