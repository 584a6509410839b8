//! Drives of the program on a SUMO that dies, falls silent, or is gone at the replay: each drive ends in time, keeps its recording, and
//! states the cause.

use super::{
    remote::{Remote, listen, signal},
    *,
};
use codrive::record::{Manifest, Table, TableReader};
use std::{
    io::{BufRead, BufReader, Read},
    net::{TcpListener, TcpStream},
    path::Path,
    process::{Child, Command, Stdio},
    thread::sleep,
    time::Duration,
};

/// Time limit for the program to end after a signal or the loss of its traffic: a time-out of 0.5 s, and the delay of two loaded cores.
/// Without time-outs none of these tests would end.
const SOON: Duration = Duration::from_secs(20);

fn codrive(arguments: &[&str]) -> Child {
    Command::new(env!("CARGO_BIN_EXE_codrive"))
        .args(arguments)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Returns exit code and output of a program, which must end within [`SOON`].
fn ended(mut program: Child) -> (i32, String) {
    let begun = now();
    let status = loop {
        if let Some(status) = program.try_wait().unwrap() {
            break status;
        }
        if begun.elapsed() > SOON {
            program.kill().unwrap();
            panic!("the program goes on after {SOON:?}");
        }
        sleep(Duration::from_millis(20));
    };
    let mut text = String::new();
    program.stdout.take().unwrap().read_to_string(&mut text).unwrap();
    program.stderr.take().unwrap().read_to_string(&mut text).unwrap();
    (status.code().unwrap_or(-1), text)
}

/// Returns a SUMO that already listens. The program would find no listener while a SUMO still loads.
fn listening() -> Remote {
    let remote = listen("ring-250");
    // A test connection would take the place of its only client, so the kernel's list of sockets is read instead.
    let entry = format!(":{:04X} 00000000:0000 0A", remote.port);
    for _ in 0..400 {
        let sockets = ["/proc/net/tcp", "/proc/net/tcp6"].map(|file| std::fs::read_to_string(file).unwrap_or_default());
        if sockets.iter().any(|text| text.contains(&entry)) {
            return remote;
        }
        sleep(Duration::from_millis(50));
    }
    panic!("SUMO does not listen after 20 s");
}

/// Starts a drive in real time on `remote`, recorded in `out`, and returns once it has begun.
fn driving(remote: &Remote, out: &Path, timeout_s: &str) -> Child {
    let traffic = format!("127.0.0.1:{}", remote.port);
    let out = out.to_str().unwrap();
    let drive = ["run", "--real-time", "--traffic", &traffic, "--duration", "600", "--out", out];
    let program = codrive(&[&drive[..], &["--traffic-timeout", timeout_s]].concat());
    // Rows are written to the disk twice a second.
    let (mut bytes, mut grown) = (0, 0);
    for _ in 0..400 {
        let now = std::fs::metadata(Path::new(out).join("journal/rows.blocks")).map_or(0, |file| file.len());
        (grown, bytes) = (grown + usize::from(now > bytes), now);
        if grown > 3 {
            return program;
        }
        sleep(Duration::from_millis(50));
    }
    panic!("no drive after 20 s: {:?}", ended(program));
}

/// Returns the end of a drive in `out` by its manifest and by its summary; checks that its tables exist.
fn told(out: &Path) -> [String; 2] {
    let rows = TableReader::parquet(&Table::Ego.parquet(out)).unwrap().rows();
    assert!(rows >= 10, "{rows} ticks were kept");
    assert!(!out.join("journal").exists(), "nothing is left to recover");
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    [Manifest::load(out).unwrap().ended.expect("the manifest says how it ended"), summary]
}

#[test]
fn a_drive_whose_sumo_is_killed_is_kept_and_says_why_it_ended() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("drive");
    let mut remote = listening();
    let program = driving(&remote, &out, "0.5");
    remote.child.kill().unwrap();
    let (code, text) = ended(program);
    let why = format!("SUMO at 127.0.0.1:{} is gone", remote.port);
    assert_eq!(code, 1, "{text}");
    assert!(text.contains(&why), "{text}");
    let [manifest, summary] = told(&out);
    assert!(manifest.starts_with(&format!("failed: {why}")), "{manifest}");
    assert!(summary.contains("\"ended\": \"failed\"") && summary.contains(&why), "{summary}");
}

#[test]
fn a_drive_whose_sumo_falls_silent_ends_after_the_time_out_and_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("drive");
    let remote = listening();
    let program = driving(&remote, &out, "0.5");
    signal(&remote.child, "STOP");
    let (code, text) = ended(program);
    assert_eq!(code, 1, "{text}");
    assert!(text.contains("did not answer within 0.5 s: a step did not come"), "{text}");
    let [manifest, _] = told(&out);
    assert!(manifest.starts_with("failed: SUMO at 127.0.0.1:"), "{manifest}");
}

#[test]
fn ctrl_c_at_once_ends_a_drive_that_waits_for_sumo_as_stopped() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("drive");
    let remote = listening();
    let program = driving(&remote, &out, "600");
    signal(&remote.child, "STOP");
    // The pause lets the program begin to wait.
    sleep(Duration::from_millis(300));
    signal(&program, "INT");
    let (code, text) = ended(program);
    assert_eq!(code, 0, "{text}");
    let [manifest, summary] = told(&out);
    assert_eq!(manifest, "stopped", "{summary}");
}

#[test]
fn signals_end_a_program_that_waits_for_the_first_answer() {
    for name in ["INT", "TERM"] {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let traffic = listener.local_addr().unwrap().to_string();
        let program = codrive(&["run", "--traffic", &traffic, "--traffic-timeout", "600"]);
        // The program has connected, asks for the version, and waits.
        let (mut stream, _): (TcpStream, _) = listener.accept().unwrap();
        stream.read_exact(&mut [0; 10]).unwrap();
        signal(&program, name);
        let (code, text) = ended(program);
        assert_eq!(code, 130, "{text}");
        assert!(text.contains("interrupted while waiting for SUMO"), "{text}");
    }
}

#[test]
fn a_drive_on_a_remote_sumo_replays_in_process_when_that_is_gone() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("drive");
    let remote = listening();
    let traffic = format!("127.0.0.1:{}", remote.port);
    let (code, text) =
        ended(codrive(&["run", "--traffic", &traffic, "--duration", "20", "--out", out.to_str().unwrap()]));
    assert_eq!(code, 0, "{text}");
    drop(remote);
    let (code, text) = ended(codrive(&["replay", out.to_str().unwrap()]));
    assert_eq!(code, 0, "{text}");
    let said: Vec<&str> = text.lines().filter(|line| line.contains(&traffic)).collect();
    assert!(said.len() == 1 && said[0].contains("driven again on SUMO in this program"), "{text}");
    assert!(text.contains("the same"), "{text}");
    // Of the two drives one is the recorded one; the message appears once.
    let (code, text) = ended(codrive(&["replay", out.to_str().unwrap(), "--what-if", "hold=5"]));
    assert_eq!((code, text.matches("driven again on SUMO in this program").count()), (0, 1), "{text}");
}

#[test]
fn a_trial_on_a_remote_sumo_that_is_gone_has_its_baseline_in_process() {
    let _alone = alone();
    let folder = tempfile::tempdir().unwrap();
    let trial = folder.path().join("trial");
    let scenario = codrive::scenario::Scenario {
        // A port without a listener.
        traffic: TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().to_string().parse().unwrap(),
        duration_s: 2.0,
        warm_up_s: 0.0,
        ..codrive::scenario::Scenario::default()
    };
    let code = codrive::study::ParticipantCode::new("P01").unwrap();
    let stop = std::sync::atomic::AtomicBool::new(false);
    let whole = codrive::drive_loop::rehearsal::baseline(&code, &trial, &scenario, &stop, &|_| ()).unwrap();
    let manifest = Manifest::load(&folder.path().join("trial-baseline")).unwrap();
    assert!(whole && manifest.traffic.contains("in process"), "{manifest:?}");
}

#[test]
fn the_program_names_a_web_server_in_the_place_of_sumo() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let traffic = listener.local_addr().unwrap().to_string();
    std::thread::spawn(move || {
        let (stream, _) = listener.accept().unwrap();
        let mut line = Vec::new();
        BufReader::new(&stream).read_until(b'\n', &mut line).unwrap();
        std::io::Write::write_all(&mut &stream, b"HTTP/1.0 400 Bad Request\r\n\r\n").unwrap();
    });
    let (code, text) = ended(codrive(&["run", "--traffic", &traffic, "--traffic-timeout", "0.3"]));
    assert_eq!(code, 1, "{text}");
    assert!(text.contains(&format!("the program that listens at {traffic} is not SUMO: it says")), "{text}");
}
