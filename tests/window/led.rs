//! Tests of a session led by its experimenter in its two windows. Covered are answers by mouse, a drive with the duration of the study
//! file, a drive that is paused, aborted and repeated, a participant who asks to stop, and an end by sickness. The tests check the files of
//! the session.

use crate::{
    keys::{B, CTRL, E, ENTER, ESC, G, I, M, N, P, Q, T},
    xserver::{Picture, Server, wait_for},
};
use codrive::{
    record::{Manifest, Table, TableReader},
    scenario::Scenario,
    study::{
        ItemOutcome,
        session::{FILE, SessionLog, SessionNote},
    },
};
use serde_json::json;
use std::{
    fs,
    path::PathBuf,
    process::{Child, Command, Stdio},
    thread::sleep,
    time::Duration,
};

/// Colours of the participant's screens: an answer that can be chosen, and a chosen answer.
const CARD: [u8; 3] = [36, 43, 53];
const CHOSEN: [u8; 3] = [46, 116, 181];

const STUDY: &str = r##"title = "Led"
participants = 2
countdown_s = 1.0
least_frames_per_s = 0
[base]
traffic = "native"
vehicles = 6
warm_up_s = 0.0
quality = "low"
trees = 0
policy = "constant"
[[condition]]
name = "only"
set = { duration_s = 120.0 }
[[segment]]
kind = "questions"
name = "before"
questionnaire = "two.json"
[[segment]]
kind = "drive"
name = "practice"
set = { duration_s = 1.3 }
[[segment]]
kind = "break"
name = "rest"
rest_s = 3.0
[[segment]]
kind = "trials"
name = "trial"
"##;

const QUESTIONS: &str = r#"{ "title": "Two", "pages": [ { "elements": [
  { "type": "boolean", "name": "licence", "title": "A licence?", "isRequired": true },
  { "type": "rating", "name": "rested", "title": "Rested?", "isRequired": true, "rateMin": 1, "rateMax": 7 } ] } ] }"#;

/// Session with its files, X server, program and windows.
struct LiveSession {
    server: Server,
    folder: tempfile::TempDir,
    program: Option<Child>,
    participant: u32,
    experimenter: u32,
}

impl LiveSession {
    fn open() -> Self {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("led.toml"), STUDY).unwrap();
        fs::write(folder.path().join("two.json"), QUESTIONS).unwrap();
        let server = Server::start([2000, 820]);
        let mut live_session = Self { server, folder, program: None, participant: 0, experimenter: 0 };
        live_session.start();
        live_session
    }

    fn start(&mut self) {
        let program = Command::new(env!("CARGO_BIN_EXE_codrive"))
            .args(["study", "session"])
            .arg(self.folder.path().join("led.toml"))
            .args(["P03", "--out"])
            .arg(self.folder.path().join("data"))
            .env("DISPLAY", &self.server.display)
            .env("RUST_LOG", "error")
            .env_remove("WAYLAND_DISPLAY")
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        self.program = Some(program);
        self.participant = self.server.window("codrive: Led");
        self.experimenter = self.server.window("Experimenter: P03");
        self.server.move_to(self.experimenter, [700, 0]);
        wait_for("the small window", || (self.server.size_of(self.participant) == [640, 360]).then_some(()));
    }

    /// Waits for the end of the program; returns its exit code and output.
    fn ended(&mut self) -> (Option<i32>, String) {
        let mut program = self.program.take().unwrap();
        wait_for("the end of the program", || program.try_wait().unwrap());
        let output = program.wait_with_output().unwrap();
        (output.status.code(), String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned())
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join("data/sourcedata/sub-P03").join(name)
    }

    fn log(&self) -> SessionLog {
        wait_for("the session's file", || SessionLog::load(&self.file(FILE)).ok())
    }

    fn runs(&self, item: &str) -> bool {
        self.log().running.is_some_and(|running| running.item == item)
    }

    fn notes(&self, kind: &str) -> Vec<SessionNote> {
        self.log().notes.into_iter().filter(|note| note.kind == kind).collect()
    }

    /// Presses keys in a window repeatedly until the condition holds.
    fn strike_until(&self, window: u32, keys: &[u8], what: &str, holds: impl Fn(&Self) -> bool) {
        wait_for(what, || {
            if holds(self) {
                return Some(());
            }
            self.server.strike(window, keys);
            sleep(Duration::from_millis(200));
            None
        });
    }

    /// Presses keys once and waits until the condition holds.
    fn strike(&self, window: u32, keys: &[u8], what: &str, holds: impl Fn(&Self) -> bool) {
        self.server.strike(window, keys);
        wait_for(what, || holds(self).then_some(()));
    }

    /// Presses keys one after another at human speed. Where the processor draws, the experimenter's window is drawn twice a second.
    fn type_into(&self, window: u32, list: &[&[u8]]) {
        for keys in list {
            self.server.strike(window, keys);
            sleep(Duration::from_millis(1200));
        }
    }

    /// Clicks the card at index `place` in a row of `of` cards.
    fn click_card(&self, place: usize, of: usize) {
        let at = wait_for("cards side by side", || {
            let picture = self.server.picture(self.participant);
            cards(&picture, of).map(|cards| cards[place])
        });
        self.server.focus(self.participant);
        self.server.click(at);
    }

    /// Starts the drive from the page before it.
    fn drive_off(&self, folder: &str) {
        let rows = self.file(folder).join("journal/rows.blocks");
        self.strike_until(self.participant, &[ENTER], "the drive", |_| rows.exists());
    }

    /// Returns the size of a drive's journal of rows, bytes.
    fn rows(&self, folder: &str) -> u64 {
        fs::metadata(self.file(folder).join("journal/rows.blocks")).map_or(0, |file| file.len())
    }
}

impl Drop for LiveSession {
    fn drop(&mut self) {
        if let Some(program) = &mut self.program {
            let _ = program.kill();
            let _ = program.wait();
        }
    }
}

/// Returns the centres of `count` cards side by side, from the first such row, chosen or not.
fn cards(picture: &Picture, count: usize) -> Option<Vec<[u32; 2]>> {
    (0..picture.size[1].saturating_sub(8)).find_map(|y| {
        let mut row: Vec<[u32; 2]> = [CARD, CHOSEN].into_iter().flat_map(|c| picture.stretches(y, c, 20)).collect();
        row.sort();
        (row.len() == count).then(|| row.into_iter().map(|[from, length]| [from + length / 2, y + 8]).collect())
    })
}

/// Returns the ticks and details of a drive's events of one kind.
fn ticks_of(live_session: &LiveSession, folder: &str, kind: &str) -> Vec<(u64, String)> {
    let events = TableReader::parquet(&Table::Events.parquet(&live_session.file(folder))).unwrap();
    let all = events.wholes("tick").into_iter().zip(events.words("event").into_iter().zip(events.words("detail")));
    all.filter(|(_, (event, _))| event == kind).map(|(tick, (_, detail))| (tick, detail)).collect()
}

#[test]
fn a_led_session_with_a_pause_a_repeat_and_sickness_is_on_the_disk() {
    let mut live_session = LiveSession::open();
    let (participant, experimenter) = (live_session.participant, live_session.experimenter);
    // Answers "no" and 5 of 1 to 7; each answer is on the disk at once.
    live_session.click_card(1, 2);
    let given =
        |live_session: &LiveSession| live_session.log().running.map(|running| running.answers).unwrap_or_default();
    wait_for("the first answer", || {
        given(&live_session).first().filter(|given| given.answer == json!(false)).map(|_| ())
    });
    live_session.click_card(4, 7);
    wait_for("the second answer", || given(&live_session).get(1).filter(|given| given.answer == json!(5)).map(|_| ()));
    live_session.strike_until(participant, &[ENTER], "the practice", |live_session| live_session.runs("practice"));

    // 1.3 s, as in the study file, are 130 ticks.
    live_session.drive_off("practice");
    wait_for("the end of the practice", || live_session.file("practice/summary.json").exists().then_some(()));
    let ticks = TableReader::parquet(&Table::Ego.parquet(&live_session.file("practice"))).unwrap().wholes("tick");
    assert_eq!(ticks, (1..=130).collect::<Vec<_>>());

    // Enter cannot shorten the break of 3 s. Its start and end are recorded in whole seconds.
    live_session.strike_until(participant, &[ENTER], "the trial", |live_session| live_session.runs("trial-1-only"));
    let rest = live_session.log().item_runs.into_iter().find(|item_run| item_run.item == "rest").unwrap();
    let [began, ended] = [&rest.began, &rest.ended].map(|at| at.parse::<jiff::Timestamp>().unwrap().as_second());
    assert!((2..10).contains(&(ended - began)), "{} to {}", rest.began, rest.ended);

    // A pause of some seconds, with a mark, a note and an extension.
    live_session.drive_off("trial-1-only");
    wait_for("some rows", || (live_session.rows("trial-1-only") > 10_000).then_some(()));
    live_session.strike(experimenter, &[CTRL, P], "the pause", |live_session| live_session.notes("paused").len() == 1);
    let held = live_session.rows("trial-1-only");
    live_session.strike(experimenter, &[CTRL, M], "the mark", |live_session| live_session.notes("mark").len() == 1);
    live_session.type_into(experimenter, &[&[CTRL, N], &[T], &[T]]);
    live_session.strike(experimenter, &[ENTER], "the note", |live_session| live_session.notes("note").len() == 1);
    live_session.type_into(experimenter, &[&[CTRL, E], &[T]]);
    live_session
        .strike(experimenter, &[ENTER], "the longer drive", |live_session| live_session.notes("extended").len() == 1);
    live_session
        .strike(experimenter, &[CTRL, G], "the drive again", |live_session| live_session.notes("resumed").len() == 1);
    wait_for("more rows", || (live_session.rows("trial-1-only") > held + 10_000).then_some(()));

    // Aborted with a reason: the recording is complete, and the trial is repeated.
    live_session.type_into(experimenter, &[&[CTRL, B], &[T]]);
    let aborted = |live_session: &LiveSession| {
        live_session.log().item_runs.last().is_some_and(|last| last.outcome == ItemOutcome::Aborted)
    };
    live_session.strike(experimenter, &[ENTER], "the end of the drive", aborted);
    let last = live_session.log().item_runs.pop().unwrap();
    assert_eq!((last.item.as_str(), last.reason.as_str()), ("trial-1-only", "t"));
    assert_eq!(Manifest::load(&live_session.file("trial-1-only")).unwrap().ended.as_deref(), Some("stopped"));
    let at = |kind: &str| ticks_of(&live_session, "trial-1-only", kind);
    let [(paused, _)] = at("paused")[..] else { panic!("{:?}", at("paused")) };
    assert_eq!(at("resumed")[0].0, paused, "seconds of the clock, and not a tick while it was held");
    assert_eq!(
        (at("mark"), at("note")),
        (vec![(paused, "by the experimenter, 1".into())], vec![(paused, "tt".into())])
    );
    assert_eq!(at("extended"), [(paused, "by 60 s: t".into())]);
    let driven = Scenario::from_file(&live_session.file("trial-1-only/scenario.toml")).unwrap();
    assert_eq!(driven.duration_s, 180.0, "two minutes, and one more");
    let [(tick, reason)] = &at("aborted")[..] else { panic!("{:?}", at("aborted")) };
    assert!(*tick > paused && reason == "t", "{tick} {reason}");

    // The participant asks to stop. The drive is paused until the experimenter responds, here with sickness.
    live_session.strike(experimenter, &[CTRL, G], "the trial again", |live_session| live_session.runs("trial-1-only"));
    live_session.drive_off("trial-1-only-again-1");
    wait_for("some rows", || (live_session.rows("trial-1-only-again-1") > 10_000).then_some(()));
    live_session.strike(participant, &[ESC], "the wish", |live_session| live_session.notes("asked").len() == 1);
    live_session.type_into(experimenter, &[&[CTRL, I]]);
    live_session
        .strike(experimenter, &[ENTER], "the end of the session", |live_session| live_session.log().end.is_some());
    let end = live_session.log().end.unwrap();
    assert_eq!((end.complete, end.reason.as_str()), (false, "sickness"));
    let asked = ticks_of(&live_session, "trial-1-only-again-1", "asked");
    let ticks =
        TableReader::parquet(&Table::Ego.parquet(&live_session.file("trial-1-only-again-1"))).unwrap().wholes("tick");
    assert_eq!(ticks.last(), Some(&asked[0].0), "it stood from the wish to the end");
    live_session.server.strike(experimenter, &[CTRL, Q]);
    let (code, text) = live_session.ended();
    assert!(code == Some(0) && text.contains("participant P03 withdrawn: the session was stopped for good"), "{text}");

    // The analyst's tables hold the clicked answers and the completed drives.
    let read = |name: &str| fs::read_to_string(live_session.folder.path().join("data").join(name)).unwrap();
    let row = read("phenotype/before.tsv").lines().nth(1).unwrap_or_default().to_owned();
    assert!(row.starts_with("sub-P03\tfalse\t5"), "{row}");
    assert!(read("participants.tsv").contains("\tperson\tonly\twithdrawn"), "{}", read("participants.tsv"));
}

#[test]
fn after_ctrl_c_or_a_closed_window_the_session_resumes_with_its_answers() {
    let mut live_session = LiveSession::open();
    live_session.click_card(1, 2);
    let given = |live_session: &LiveSession| live_session.log().running.map_or(0, |running| running.answers.len());
    wait_for("the answer", || (given(&live_session) == 1).then_some(()));
    // The shell's built-in kill: a minimal Debian has no other.
    let id = live_session.program.as_ref().unwrap().id();
    assert!(Command::new("sh").args(["-c", &format!("kill -INT {id}")]).status().unwrap().success());
    let (code, text) = live_session.ended();
    assert!(code == Some(0) && text.contains("participant P03 is at before: run the same command to resume"), "{text}");
    let last = live_session.log().item_runs.pop().unwrap();
    assert_eq!((last.outcome, last.reason.as_str()), (ItemOutcome::Cut, "stopped by Ctrl-C"));
    assert_eq!(last.answers[0].answer, json!(false));
    // The tables list the session as open.
    let table = fs::read_to_string(live_session.folder.path().join("data/participants.tsv")).unwrap();
    assert!(table.contains("sub-P03\t") && table.contains("\topen"), "{table}");

    // The session continues at the experimenter's command and keeps the answers.
    live_session.start();
    live_session.strike(live_session.experimenter, &[CTRL, G], "the questions again", |live_session| {
        live_session.runs("before")
    });
    assert_eq!(given(&live_session), 1);
    live_session.server.close(live_session.participant);
    let (code, text) = live_session.ended();
    assert!(code == Some(0) && text.contains("is at before: run the same command to resume"), "{text}");
    let last = live_session.log().item_runs.pop().unwrap();
    assert_eq!(
        (last.outcome, last.reason.as_str(), last.answers.len()),
        (ItemOutcome::Cut, "the window was closed", 1)
    );
}
