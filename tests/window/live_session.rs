//! Test of a participant's whole session in its two windows on a real X server (Xvfb), by keys alone: page, questions, two trials. The
//! program is killed in the middle of the first trial, and the same command continues there. Keys typed in the participant's window never
//! act as commands of the experimenter.

use crate::{
    keys::{B, CTRL, ENTER, ESC, F1, G, Q, RIGHT, S, T},
    xserver::{Server, wait_for},
};
use codrive::{
    record::{Table, TableReader},
    study::{
        ItemOutcome,
        session::{FILE, SessionLog},
    },
};
use std::{
    fs,
    path::{Path, PathBuf},
    process::{Child, Command, Stdio},
    thread::sleep,
    time::Duration,
};

const STUDY: &str = r##"title = "Short"
participants = 2
order = "fixed"
countdown_s = 0.0
least_frames_per_s = 0
[base]
traffic = "native"
vehicles = 6
warm_up_s = 0.0
duration_s = 1.5
quality = "low"
trees = 0
policy = "constant"
[[condition]]
name = "narrow"
set = { range_mph = 0.75, duration_s = 120.0 }
[[condition]]
name = "wide"
[[segment]]
kind = "text"
name = "welcome"
text = "# Welcome"
[[segment]]
kind = "questions"
name = "before"
questionnaire = "two.json"
[[segment]]
kind = "trials"
name = "trial"
"##;

const QUESTIONS: &str = r#"{ "title": "Two", "pages": [ { "elements": [
  { "type": "boolean", "name": "licence", "title": "A licence?", "isRequired": true },
  { "type": "rating", "name": "rested", "title": "Rested?", "isRequired": true, "rateMin": 1, "rateMax": 7 } ] } ] }"#;

struct WindowFixture {
    _folder: tempfile::TempDir,
    study: PathBuf,
    out: PathBuf,
}

impl WindowFixture {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (study, out) = (folder.path().join("short.toml"), folder.path().join("data"));
        fs::write(&study, STUDY).unwrap();
        fs::write(folder.path().join("two.json"), QUESTIONS).unwrap();
        Self { _folder: folder, study, out }
    }

    fn command(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
        command.args(["study", "session"]).arg(&self.study).args(["P03", "--out"]).arg(&self.out);
        command.env_remove("WAYLAND_DISPLAY").env("RUST_LOG", "error").stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    fn start(&self, server: &Server) -> Child {
        self.command().env("DISPLAY", &server.display).spawn().unwrap()
    }

    fn source(&self) -> PathBuf {
        self.out.join("sourcedata/sub-P03")
    }

    fn log(&self) -> Option<SessionLog> {
        SessionLog::load(&self.source().join(FILE)).ok()
    }

    fn runs(&self, item: &str) -> bool {
        self.log().and_then(|log| log.running).is_some_and(|running| running.item == item)
    }
}

/// Presses keys in a window repeatedly until the condition holds. The window may close before that: the program writes its tables after its
/// windows are closed.
fn strike_until(server: &Server, window: u32, keys: &[&[u8]], what: &str, holds: impl Fn() -> bool) {
    let mut next = keys.iter().cycle();
    wait_for(what, || {
        if holds() {
            return Some(());
        }
        server.strike_if_there(window, next.next()?);
        sleep(Duration::from_millis(150));
        None
    });
}

fn ended(program: Child) -> (Option<i32>, String) {
    let output = program.wait_with_output().unwrap();
    (output.status.code(), String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned())
}

#[test]
fn a_whole_session_by_keys_is_killed_in_a_trial_and_goes_on_there() {
    let (server, place) = (Server::start([1300, 1200]), WindowFixture::new());
    let mut program = place.start(&server);
    let participant = server.window("codrive: Short");
    server.window("Experimenter: P03");
    strike_until(&server, participant, &[&[ENTER]], "the questions", || place.runs("before"));
    // F1 lists the keys over the page. Esc closes the list and is no request to stop. The window is moved below the experimenter's window,
    // where it is fully visible.
    server.move_to(participant, [0, 820]);
    sleep(Duration::from_secs(1));
    let page = server.picture(participant);
    let share = |low: f64, high: f64| {
        let differs = server.picture(participant).differs(&page);
        (low..high).contains(&differs).then_some(())
    };
    server.strike(participant, &[F1]);
    wait_for("the list of keys", || share(0.05, 1.0));
    server.strike(participant, &[ESC]);
    wait_for("the page again", || share(0.0, 0.01));
    // The participant's keyboard cannot abort an item.
    server.strike(participant, &[CTRL, B]);
    strike_until(&server, participant, &[&[RIGHT], &[ENTER]], "the trial", || place.runs("trial-1-narrow"));
    let log = place.log().unwrap();
    assert!(log.item_runs.iter().all(|p| p.outcome == ItemOutcome::Done) && log.notes.is_empty(), "{log:?}");
    assert_eq!(log.answers["before"].len(), 2);
    let journal = place.source().join("trial-1-narrow/journal/rows.blocks");
    strike_until(&server, participant, &[&[ENTER]], "the drive", || journal.exists());
    wait_for("rows", || fs::metadata(&journal).ok().filter(|file| file.len() > 20_000));
    program.kill().unwrap();
    program.wait().unwrap();

    // Two programs cannot run the same session at once.
    let program = place.start(&server);
    let (participant, experimenter) = (server.window("codrive: Short"), server.window("Experimenter: P03"));
    let (code, text) = ended(place.command().env("DISPLAY", &server.display).spawn().unwrap());
    assert!(code == Some(2) && text.contains("another program runs the session of participant"), "{text}");
    let last = wait_for("the cut", || place.log()?.item_runs.pop().filter(|p| p.item == "trial-1-narrow"));
    assert_eq!(last.outcome, ItemOutcome::Cut);
    assert!(TableReader::parquet(&Table::Ego.parquet(&place.source().join("trial-1-narrow"))).unwrap().rows() > 20);
    strike_until(&server, experimenter, &[&[CTRL, G]], "the trial again", || place.runs("trial-1-narrow"));
    let again = place.source().join("trial-1-narrow-again-1");
    strike_until(&server, participant, &[&[ENTER]], "the drive again", || again.join("journal").exists());
    // The drive is long, so the experimenter skips it and gives a reason.
    let typed: [&[u8]; 4] = [&[CTRL, S], &[T], &[T], &[ENTER]];
    strike_until(&server, experimenter, &typed, "the skip", || {
        place.log().is_some_and(|log| log.item_runs.iter().any(|p| p.outcome == ItemOutcome::Skipped))
    });
    strike_until(&server, experimenter, &[&[CTRL, G]], "the second trial", || place.runs("trial-2-wide"));
    let over = || place.log().is_some_and(|log| log.end.is_some());
    strike_until(&server, participant, &[&[ENTER]], "the end", over);
    let baseline = place.source().join("trial-2-wide-baseline/summary.json");
    wait_for("the baseline", || baseline.exists().then_some(()));
    let mut program = program;
    strike_until(&server, experimenter, &[&[CTRL, Q]], "goodbye", {
        let program = std::cell::RefCell::new(&mut program);
        move || program.borrow_mut().try_wait().unwrap().is_some()
    });
    let (code, text) = ended(program);
    assert!(
        code == Some(0)
            && text.contains("participant P03 partial: the session was completed, and at least one item was skipped"),
        "{text}"
    );

    let read = |name: &str| fs::read_to_string(place.out.join(name)).unwrap();
    assert!(read("participants.tsv").contains("\tperson\tnarrow,wide\tpartial"), "{}", read("participants.tsv"));
    let scans = read("sub-P03/sub-P03_scans.tsv");
    let drives: Vec<&str> = scans.lines().filter(|line| line.contains("sourcedata/")).collect();
    assert!(drives.len() == 1 && drives[0].contains("trial-2-wide-baseline"), "{scans}");
    assert!(read("phenotype/before.tsv").lines().nth(1).is_some_and(|row| row.starts_with("sub-P03\ttrue\t")));
    let manifest = read("sourcedata/sub-P03/trial-2-wide/manifest.json");
    assert!(
        manifest.contains("\"participant\": \"P03\"") && manifest.contains("\"driver\": \"keyboard\""),
        "{manifest}"
    );
    // A participant cannot take part twice, and the message needs no display. The command also makes the baseline that was cut.
    let (whole, part) = (baseline.parent().unwrap(), place.source().join("trial-2-wide-baseline-part"));
    fs::rename(whole, &part).unwrap();
    let (code, text) = ended(place.command().env_remove("DISPLAY").spawn().unwrap());
    assert!(code == Some(2) && text.contains("has completed the whole study"), "{text}");
    assert!(text.contains("1 missing baseline was made for participant P03") && baseline.exists() && !part.exists());
    // The analysis reads the data set.
    let analysed = Command::new(env!("CARGO_BIN_EXE_codrive")).arg("analyse").arg(&place.out).output().unwrap();
    assert!(
        analysed.status.success() && String::from_utf8_lossy(&analysed.stdout).contains("1 drive\n"),
        "{analysed:?}"
    );
}

#[test]
fn invalid_arguments_are_refused_before_a_window_opens() {
    let place = WindowFixture::new();
    let run = |place: &WindowFixture, step: &str, arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_codrive"));
        command.args(["study", step]).arg(&place.study).args(arguments);
        command.env_remove("DISPLAY").env_remove("WAYLAND_DISPLAY");
        let output = command.output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned())
    };
    let out = place.out.to_str().unwrap();
    for (code, has) in [
        ("../P03", "it contains '.'"),
        ("Ann Lee", "it contains a space"),
        ("nul", "keeps this name"),
        ("", "is empty"),
    ] {
        let (exit, text) = run(&place, "session", &[code, "--out", out]);
        assert!(exit == Some(2) && text.contains(has) && text.contains("for example P03"), "{text}");
    }
    let (exit, text) = run(&place, "session", &["P03"]);
    assert!(exit == Some(2) && text.contains("--out"), "{text}");
    let (exit, text) = run(&place, "session", &["P03", "--out", out, "--participants", "2"]);
    assert!(exit == Some(2) && text.contains("unexpected argument '--participants'"), "{text}");
    let (exit, text) = run(&place, "session", &["P03", "--out", out]);
    assert!(exit == Some(1) && text.contains("no window can be opened"), "{text}");
    assert!(!Path::new(out).exists(), "nothing was made");
    assert_eq!(run(&place, "rehearse", &["--participants", "1", "--out", out]).0, Some(0));
    let (exit, text) = run(&place, "session", &["P03", "--out", out]);
    assert!(exit == Some(2) && text.contains("holds a rehearsal (R01)"), "{text}");
}

#[test]
fn no_page_is_shown_on_a_computer_slower_than_the_study_asks() {
    let (server, place) = (Server::start([1300, 1200]), WindowFixture::new());
    // No processor draws as many frames: 240 are twice what fast screens show.
    fs::write(&place.study, STUDY.replace("least_frames_per_s = 0", "least_frames_per_s = 240")).unwrap();
    let (code, text) = ended(place.start(&server));
    assert_eq!(code, Some(2), "{text}");
    let found = text.split("this computer draws ").nth(1).and_then(|rest| rest.split(' ').next()?.parse::<f64>().ok());
    assert!(found.is_some_and(|rate| rate > 0.0 && rate < 240.0), "{text}");
    assert!(text.contains("the study asks for 240 (least_frames_per_s)") && text.contains("remedy: "), "{text}");
    let log = place.log().expect("a log");
    assert!(log.item_runs.is_empty() && log.running.is_none() && log.frames_per_s.is_some(), "{log:?}");
}
