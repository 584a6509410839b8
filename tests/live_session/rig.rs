//! A session with its study, data set and a road on which time passes only when the test says so.

use codrive::{
    drive_loop::RunError,
    panel::SessionCommand,
    record::RecordError,
    scenario::Scenario,
    session::{BackendStatus, DriveBackend, LiveSession},
    study::{
        DataSet, FormInput, ItemOutcome, ParticipantCode, Session, Study,
        session::{FILE, ParticipantKind, SessionLog},
    },
};
use std::{fs, path::Path, path::PathBuf, time::Duration};

/// Study of the sessions.
pub const STUDY: &str = r##"title = "Short"
participants = 2
seed = 7
order = "fixed"
[base]
traffic = "native"
duration_s = 8.0
[[condition]]
name = "narrow"
set = { range_mph = 0.5 }
[[condition]]
name = "wide"
set = { range_mph = 2.0 }
[[segment]]
kind = "text"
name = "welcome"
text = "# Hello"
[[segment]]
kind = "questions"
name = "before"
text = "Some questions."
questionnaire = "raw-tlx"
[[segment]]
kind = "drive"
name = "practice"
text = "Try the car."
set = { duration_s = 30.0 }
until_in_range_s = 2.0
[[segment]]
kind = "break"
name = "rest"
rest_s = 10.0
[[segment]]
kind = "trials"
name = "trial"
"##;

/// A road on which time passes only when the test says so.
#[derive(Debug, Default)]
pub struct Counted {
    pub scenario: Option<Scenario>,
    pub folder: Option<PathBuf>,
    pub now: BackendStatus,
    pub notes: Vec<String>,
    pub fails: bool,
}

impl Counted {
    pub fn pass(&mut self, seconds: f64) {
        if self.folder.is_some() && !self.now.held {
            self.now.time_s += seconds;
            self.now.ended = self.now.time_s >= self.now.duration_s;
        }
    }
}

impl DriveBackend for Counted {
    fn prepare(&mut self, scenario: &Scenario) -> Result<bool, RunError> {
        if self.fails {
            return Err(RecordError::Stopped("no road".into()).into());
        }
        self.now = BackendStatus { duration_s: scenario.duration_s, ..BackendStatus::default() };
        self.scenario = Some(scenario.clone());
        Ok(true)
    }

    fn begin(&mut self, folder: &Path) -> Result<(), RunError> {
        fs::create_dir(folder).expect("a new folder");
        // An empty folder would not count as a drive after a cut.
        fs::write(folder.join("rows"), "").expect("written");
        self.folder = Some(folder.into());
        Ok(())
    }

    fn hold(&mut self, held: bool) {
        self.now.held = held;
    }

    fn note(&mut self, kind: &str, detail: &str) {
        self.notes.push(format!("{kind}: {detail}"));
    }

    fn note_value(&mut self, kind: &str, detail: &str, value: f64) {
        self.notes.push(format!("{kind} {value}: {detail}"));
    }

    fn begin_event(&mut self, event: usize) {
        self.notes.push(format!("event {event}"));
    }

    fn chime(&mut self) {
        self.notes.push("chime".into());
    }

    fn extend(&mut self, seconds: f64) -> Result<(), RunError> {
        self.now.duration_s += seconds;
        Ok(())
    }

    fn end(&mut self) -> Result<(), RunError> {
        (self.scenario, self.folder) = (None, None);
        Ok(())
    }

    fn now(&self) -> BackendStatus {
        self.now
    }
}

/// A session with its study, data set and road.
pub struct Rig {
    _folder: tempfile::TempDir,
    pub out: PathBuf,
    pub study: Study,
    pub live_session: Option<LiveSession>,
    pub road: Counted,
}

impl Rig {
    pub fn new() -> Self {
        Self::of(STUDY)
    }

    /// Starts a session with these settings added to every drive.
    pub fn with(base: &str) -> Self {
        Self::of(&STUDY.replace("[base]\n", &format!("[base]\n{base}\n")))
    }

    /// Starts a session of another study.
    pub fn of(study: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("data");
        let study = Study::parse(study.into(), Path::new("short.toml")).unwrap_or_else(|e| panic!("{e}"));
        let mut rig = Self { _folder: folder, out, study, live_session: None, road: Counted::default() };
        rig.open();
        rig
    }

    /// Starts the session, or resumes it as after a crash, without an orderly end.
    pub fn open(&mut self) {
        self.live_session = None;
        self.road = Counted::default();
        let data = DataSet::open(&self.out, &self.study).unwrap();
        let code = ParticipantCode::new("P03").unwrap();
        let session = Session::open(&data, &self.study, &code, ParticipantKind::Person, 0, "then").unwrap();
        self.live_session = Some(LiveSession::new(&self.study, session, || "2026-11-20T12:00:00Z".into()).unwrap());
    }

    pub fn live_session(&mut self) -> &mut LiveSession {
        self.live_session.as_mut().unwrap()
    }

    /// Lets time pass in frames of 50 ms.
    pub fn pass(&mut self, seconds: f64) {
        for _ in 0..(seconds / 0.05).round() as usize {
            self.road.pass(0.05);
            let live_session = self.live_session.as_mut().unwrap();
            live_session.tick(Duration::from_millis(50), &mut self.road).unwrap();
        }
    }

    pub fn input(&mut self, input: FormInput) {
        self.live_session.as_mut().unwrap().input(input, &mut self.road).unwrap();
    }

    /// Waits 1 s on the page and goes on.
    pub fn next(&mut self) {
        self.pass(1.0);
        self.input(FormInput::Next);
    }

    pub fn command(&mut self, command: SessionCommand) {
        self.live_session.as_mut().unwrap().command(command, &mut self.road).unwrap();
    }

    /// Checks that the command is refused with this message and changes nothing.
    pub fn refused(&mut self, command: SessionCommand, has: &str) {
        let before = self.log();
        self.command(command);
        let message = self.live_session().error().unwrap_or_default().to_owned();
        assert!(message.contains(has), "{message:?}");
        assert_eq!(self.log(), before, "nothing was done");
    }

    pub fn log(&self) -> SessionLog {
        SessionLog::load(&self.out.join("sourcedata/sub-P03").join(FILE)).unwrap()
    }

    /// Returns name and outcome of all past item runs.
    pub fn item_runs(&self) -> Vec<(String, ItemOutcome)> {
        self.log().item_runs.into_iter().map(|p| (p.item, p.outcome)).collect()
    }

    pub fn running(&self) -> String {
        self.log().running.map_or("nothing".into(), |running| running.item)
    }

    pub fn sees(&mut self) -> String {
        self.live_session().sees()
    }

    pub fn answer(&mut self) {
        for _ in 0..20 {
            self.input(FormInput::Turn(1));
            self.input(FormInput::Next);
        }
    }

    /// Goes from the page before a drive into the drive itself.
    pub fn drive_off(&mut self) {
        self.next();
        self.pass(3.5);
        assert!(self.sees().starts_with("drive "), "{}", self.sees());
    }

    /// Goes to the text before the practice drive.
    pub fn until_practice(&mut self) {
        self.next();
        self.next();
        self.answer();
        assert_eq!(self.sees(), "text before practice");
    }
}
