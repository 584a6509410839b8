//! Tests of drives in a window whose traffic fails: the window responds while SUMO is silent, and the recording states the failure.

use crate::{
    keys::{BACKSPACE, ESC},
    xserver::{Server, ended, wait_for},
};
use codrive::{
    record::Manifest,
    traffic::sumo::{home, program},
};
use std::{
    net::TcpListener,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    thread::sleep,
    time::Duration,
};

/// SUMO process that listens on a port; it is killed when dropped.
struct Remote(Child, u16);

impl Remote {
    fn listen() -> Self {
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let net = concat!(env!("CARGO_MANIFEST_DIR"), "/maps/ring-250/net.xml");
        let child = Command::new(program(&home().unwrap()))
            .args(["--net-file", net, "--remote-port", &port.to_string()])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        // A connection would use up its only client, so the test reads the kernel's list of sockets instead.
        let entry = format!(":{port:04X} 00000000:0000 0A");
        wait_for("SUMO", || {
            let files = ["/proc/net/tcp", "/proc/net/tcp6"];
            files.iter().any(|file| std::fs::read_to_string(file).unwrap_or_default().contains(&entry)).then_some(())
        });
        Self(child, port)
    }

    fn signal(&self, name: &str) {
        let sent = Command::new("sh").args(["-c", &format!("kill -{name} {}", self.0.id())]).status().unwrap();
        assert!(sent.success());
    }
}

impl Drop for Remote {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Display, folder for the recording, and a listening SUMO.
struct Place {
    server: Server,
    _folder: tempfile::TempDir,
    out: PathBuf,
    remote: Remote,
}

impl Place {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("drive");
        Self { server: Server::start([640, 400]), _folder: folder, out, remote: Remote::listen() }
    }
}

/// Starts a recorded drive in a window with the SUMO at `remote`, and lets it run for a second.
fn driving(server: &Server, remote: &Remote, out: &Path, timeout_s: &str) -> Child {
    let traffic = format!("127.0.0.1:{}", remote.1);
    let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
    command
        .args(["drive", "--quality", "low", "--trees", "0", "--duration", "0", "--out", out.to_str().unwrap()])
        .args(["--traffic", &traffic, "--traffic-timeout", timeout_s]);
    let program = server.start_program(&mut command);
    let window = server.window("codrive");
    wait_for("a picture", || (server.colours() > 200).then_some(()));
    server.focus(window);
    sleep(Duration::from_secs(1));
    program
}

#[test]
fn a_killed_sumo_ends_the_drive_and_its_recording_names_the_failure() {
    let Place { server, out, remote, .. } = &Place::new();
    let program = driving(server, remote, out, "5");
    remote.signal("KILL");
    let (code, text) = ended(program);
    assert_eq!(code, 1, "{text}");
    let why = format!("SUMO at 127.0.0.1:{} is gone", remote.1);
    assert!(text.contains(&why), "{text}");
    let ended = Manifest::load(out).unwrap().ended.unwrap();
    assert!(ended.starts_with(&format!("failed: {why}")), "{ended}");
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    assert!(summary.contains("\"ended\": \"failed\""), "{summary}");
}

#[test]
fn esc_ends_a_drive_with_a_silent_sumo_long_before_the_time_out() {
    let Place { server, out, remote, .. } = &Place::new();
    let program = driving(server, remote, out, "600");
    remote.signal("STOP");
    sleep(Duration::from_secs(1));
    server.key(ESC, true);
    server.key(ESC, false);
    // The test waits for a minute and the time-out is ten, so the key ends the drive.
    let (code, text) = ended(program);
    assert_eq!(code, 0, "{text}");
    assert_eq!(Manifest::load(out).unwrap().ended.as_deref(), Some("stopped"), "{text}");
    remote.signal("CONT");
}

#[test]
fn esc_ends_a_window_that_waits_for_sumo_to_restart() {
    let Place { server, out, remote, .. } = &Place::new();
    let program = driving(server, remote, out, "600");
    // The system accepts the new connection, but the stopped SUMO never responds.
    remote.signal("STOP");
    for key in [BACKSPACE, ESC] {
        server.key(key, true);
        server.key(key, false);
        sleep(Duration::from_secs(1));
    }
    let (code, text) = ended(program);
    assert_eq!(code, 0, "{text}");
    assert_eq!(Manifest::load(out).unwrap().ended.as_deref(), Some("stopped"), "{text}");
    remote.signal("CONT");
}

#[test]
fn esc_ends_a_window_within_a_second_while_sumo_reads_a_file() {
    let server = Server::start([320, 200]);
    let mut program = server.start_program(
        Command::new(env!("CARGO_BIN_EXE_codrive"))
            .args(["drive", "--quality", "low", "--duration", "0", "--policy", "none", "--map", "ring-250"])
            // Every start of SUMO takes this long, the first one included.
            .env("CODRIVE_SUMO_READS_S", "6"),
    );
    let window = server.window("codrive");
    server.focus(window);
    wait_for("a picture", || (server.colours() > 100).then_some(()));
    for key in [BACKSPACE, ESC] {
        server.key(key, true);
        server.key(key, false);
        sleep(Duration::from_millis(300));
    }
    let is_over = (0..100).any(|_| {
        sleep(Duration::from_millis(10));
        program.try_wait().unwrap().is_some()
    });
    assert!(is_over, "it waits for SUMO");
    let (code, text) = ended(program);
    assert_eq!(code, 0, "{text}");
}
