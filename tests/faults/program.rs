//! The program under a plan. In: arguments, a plan, a workplace. Out: how it ended, its output, and all its calls on files of the
//! workplace.

use super::plan::Plan;
use std::{
    ffi::OsStr,
    fs,
    io::Read,
    os::unix::process::ExitStatusExt,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    sync::{
        LazyLock,
        atomic::{AtomicU64, Ordering},
    },
    thread,
    time::{Duration, Instant},
};

/// Time limit, after which a process is killed and counts as failed.
const LIMIT: Duration = Duration::from_secs(120);
/// Step of the program's clock, microseconds. With it a drive hands over its rows after every 0.2 s of driving, on every machine.
const CLOCK_STEP_US: &str = "100000";

/// Library of `preload.c`, built once for all tests of this process.
static LIBRARY: LazyLock<(tempfile::TempDir, PathBuf)> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("libfaults.so");
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/faults/preload.c");
    let cc =
        Command::new("cc").args(["-shared", "-fPIC", "-O1", "-Wall", "-Werror", "-o"]).args([&path, &source]).output();
    let built = cc.expect("no C compiler (cc)\n  remedy: scripts/setup, or apt install gcc");
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    (folder, path)
});

/// Placeholder for the program in live drives, which run in a process of these tests. Also the environment variable with the folder of the
/// recording; the next one holds the seed.
pub const LIVE: &str = "CODRIVE_FAULTS_LIVE";
pub const LIVE_SEED: &str = "CODRIVE_FAULTS_LIVE_SEED";

/// Folder on which faults act, and the resources beside it.
pub struct Workplace {
    folder: tempfile::TempDir,
    /// Seed of the times at which devices disappear and return.
    seed: AtomicU64,
}

/// Outcome of a run of the program.
pub struct Outcome {
    /// Command line, for reports.
    pub command: String,
    /// Exit code; `None` if it was killed.
    pub code: Option<i32>,
    /// Signal that ended the process, if any.
    pub signal: Option<i32>,
    /// Standard output and standard error.
    pub text: String,
    /// Calls on files of the workplace, in order.
    pub trace: Vec<Call>,
    /// True if the process did not end within the time limit.
    pub hung: bool,
}

/// Call on a file of the workplace, or on a socket of the loopback.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Call {
    /// Kind of the call, as `preload.c` names it.
    pub kind: String,
    /// Path of the file, relative to the workplace.
    pub name: String,
    /// Result of the call: `ok`, `refused` by the system, or the action of the fault.
    pub result: String,
}

impl Outcome {
    /// Returns true if a fault killed the process.
    pub fn is_killed(&self) -> bool {
        self.signal == Some(9) && !self.hung
    }

    /// Returns true if a fault refused a call.
    pub fn was_refused(&self) -> bool {
        self.trace.iter().any(|call| call.result.starts_with('E') && call.result != "EINTR")
    }

    /// Returns the number of successful calls of this kind on files with names that end in `name`.
    pub fn count(&self, kind: &str, name: &str) -> usize {
        self.trace.iter().filter(|call| call.kind == kind && call.name.ends_with(name) && call.result == "ok").count()
    }
}

impl Workplace {
    pub fn new() -> Self {
        let folder = tempfile::Builder::new().prefix("codrive-faults-").tempdir().unwrap();
        for name in ["root", "side"] {
            fs::create_dir(folder.path().join(name)).unwrap();
        }
        Self { folder, seed: AtomicU64::new(0) }
    }

    /// Sets the seed of the times at which devices of the next command disappear and return.
    pub fn draw_devices_by(&self, seed: u64) {
        self.seed.store(seed, Ordering::Relaxed);
    }

    /// Returns the folder on which faults act.
    pub fn root(&self) -> PathBuf {
        self.folder.path().join("root")
    }

    /// Returns the path of a file in the workplace.
    pub fn file(&self, name: &str) -> PathBuf {
        self.root().join(name)
    }

    /// Runs the program without faults.
    pub fn run(&self, arguments: &[&str]) -> Outcome {
        self.run_under(&Plan::default(), arguments)
    }

    /// Runs the program under a plan. Arguments that begin with `@` are files of the workplace.
    pub fn run_under(&self, plan: &Plan, arguments: &[&str]) -> Outcome {
        let trace = self.folder.path().join("trace");
        let _ = fs::remove_file(&trace);
        let mut command = self.command(arguments);
        command.env("FAULTS_PLAN", plan.lines()).env("FAULTS_TRACE", &trace);
        let mut child = command.spawn().unwrap();
        let printed = [reader(child.stdout.take()), reader(child.stderr.take())];
        let hung = !ends(&mut child);
        let status = child.wait().unwrap();
        let text = printed.map(|thread| thread.join().unwrap()).concat();
        let line = |line: &str| {
            let (kind, rest) = line.split_once(' ')?;
            let (name, result) = rest.rsplit_once(' ')?;
            Some(Call { kind: kind.into(), name: name.into(), result: result.into() })
        };
        let trace = fs::read_to_string(trace).unwrap_or_default().lines().filter_map(line).collect();
        let command = ["codrive"].iter().chain(arguments).copied().collect::<Vec<_>>().join(" ").replace('@', "");
        Outcome { command, code: status.code(), signal: status.signal(), text, trace, hung }
    }

    fn command(&self, arguments: &[&str]) -> Command {
        if let [LIVE, folder] = arguments {
            return self.live(folder.trim_start_matches('@'));
        }
        let program = std::env::var_os("CODRIVE_FAULTS_PROGRAM");
        let mut command = Command::new(program.as_deref().unwrap_or(OsStr::new(env!("CARGO_BIN_EXE_codrive"))));
        for argument in arguments {
            match argument.strip_prefix('@') {
                Some(name) => command.arg(self.file(name)),
                None => command.arg(argument),
            };
        }
        self.preloaded(&mut command);
        command
            .env("FAULTS_STEP_US", CLOCK_STEP_US)
            // One participant after the other, so that a seed gives the same calls in the same order.
            .env("RAYON_NUM_THREADS", "1");
        command
    }

    /// Returns the command of a live drive. It uses the machine's clock, which streams need, and sees no streams of other processes.
    fn live(&self, folder: &str) -> Command {
        let lsl = self.folder.path().join("lsl_api.cfg");
        let session = self.folder.path().file_name().unwrap().to_string_lossy().into_owned();
        let text = "[ports]\nIPv6 = disable\n[multicast]\nResolveScope = machine\nListenAddress = 127.0.0.1\n[lab]\nKnownPeers = {127.0.0.1}";
        fs::write(&lsl, format!("{text}\nSessionID = {session}\n")).unwrap();
        let library = Path::new(env!("CARGO_MANIFEST_DIR")).join(".test-python/pylsl/lib");
        assert!(library.exists(), "{} is not there; run scripts/setup --test", library.display());
        let mut command = Command::new(std::env::current_exe().unwrap());
        self.preloaded(&mut command);
        command
            .args(["--exact", super::live::TEST, "--nocapture"])
            .env(LIVE, self.file(folder))
            .env(LIVE_SEED, self.seed.load(Ordering::Relaxed).to_string())
            .env("LSLAPICFG", lsl)
            .env("CODRIVE_LSL", library);
        command
    }

    fn preloaded(&self, command: &mut Command) {
        command
            .env("LD_PRELOAD", &LIBRARY.1)
            .env("FAULTS_ROOT", self.root())
            .env("FAULTS_SIDE", self.folder.path().join("side"))
            .env("RUST_BACKTRACE", "0")
            .env_remove("RUST_LOG")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
    }

    /// Keeps the folder for inspection and returns its path.
    pub fn keep(self) -> PathBuf {
        self.folder.keep()
    }
}

fn reader(from: Option<impl Read + Send + 'static>) -> thread::JoinHandle<String> {
    thread::spawn(move || {
        let mut bytes = Vec::new();
        let _ = from.unwrap().read_to_end(&mut bytes);
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

/// Waits for the end of the process. Returns false if it did not end within the limit.
#[allow(clippy::disallowed_methods, reason = "the limit of a program is a matter of wall time")]
fn ends(child: &mut Child) -> bool {
    let began = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if began.elapsed() > LIMIT {
            let _ = child.kill();
            return false;
        }
        thread::sleep(Duration::from_millis(2));
    }
    true
}

/// Copies a folder with its contents.
pub fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// Returns every file below a folder with its bytes, sorted; files that only hold a lock are left out.
pub fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_path_buf()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(&folder).into_iter().flatten().flatten() {
            if entry.file_type().unwrap().is_dir() {
                folders.push(entry.path());
            } else if entry.file_name() != "lock" {
                found.push((entry.path(), fs::read(entry.path()).unwrap()));
            }
        }
    }
    found.sort();
    found
}
