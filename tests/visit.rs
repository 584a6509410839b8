//! A participant's visit without a window: what the participant does and the experimenter decides, on a road that only keeps
//! count; and that every step is on the disk.

use codrive::{
    app::{
        AppError,
        visit::{Road, RoadNow, Visit, road::Kit},
    },
    input::{
        Devices, Rig as WheelRig,
        lamps::Lamps,
        profiles,
        profiles::Device,
        wheel::{Found, Told},
    },
    panel::{ItemState, Screen, VisitCommand, VisitPhase},
    record::RecordError,
    sim::Scenario,
    study::{
        Code, DataSet, Input, Outcome, Session, Study,
        session::{FILE, Log, Who},
    },
};
use std::{fs, path::Path, path::PathBuf, time::Duration};

const STUDY: &str = r##"title = "Short"
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

/// A road on which time passes when the test says so.
#[derive(Debug, Default)]
struct Counted {
    scenario: Option<Scenario>,
    folder: Option<PathBuf>,
    now: RoadNow,
    said: Vec<String>,
    fails: bool,
}

impl Counted {
    fn pass(&mut self, seconds: f64) {
        if self.folder.is_some() && !self.now.held {
            self.now.time_s += seconds;
            self.now.ended = self.now.time_s >= self.now.duration_s;
        }
    }
}

impl Road for Counted {
    fn prepare(&mut self, scenario: &Scenario) -> Result<(), AppError> {
        if self.fails {
            return Err(RecordError::Stopped("no road".into()).into());
        }
        self.now = RoadNow { duration_s: scenario.duration_s, ..RoadNow::default() };
        self.scenario = Some(scenario.clone());
        Ok(())
    }

    fn begin(&mut self, folder: &Path) -> Result<(), AppError> {
        fs::create_dir(folder).expect("a new folder");
        self.folder = Some(folder.into());
        Ok(())
    }

    fn hold(&mut self, held: bool) {
        self.now.held = held;
    }

    fn note(&mut self, kind: &str, detail: &str) {
        self.said.push(format!("{kind}: {detail}"));
    }

    fn extend(&mut self, seconds: f64) -> Result<(), AppError> {
        self.now.duration_s += seconds;
        Ok(())
    }

    fn end(&mut self) -> Result<(), AppError> {
        (self.scenario, self.folder) = (None, None);
        Ok(())
    }

    fn now(&self) -> RoadNow {
        self.now
    }
}

/// A visit with all around it.
struct Rig {
    _folder: tempfile::TempDir,
    out: PathBuf,
    study: Study,
    visit: Option<Visit>,
    road: Counted,
}

impl Rig {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("data");
        let study = Study::parse(STUDY.into(), Path::new("short.toml")).unwrap_or_else(|e| panic!("{e}"));
        let mut rig = Self { _folder: folder, out, study, visit: None, road: Counted::default() };
        rig.open();
        rig
    }

    /// Begins the visit, or goes on with it as after a crash: nobody has said goodbye.
    fn open(&mut self) {
        self.visit = None;
        self.road = Counted::default();
        let data = DataSet::open(&self.out, &self.study).unwrap();
        let code = Code::new("P03").unwrap();
        let session = Session::open(&data, &self.study, &code, Who::Person, 0, "then").unwrap();
        self.visit = Some(Visit::new(&self.study, session, || "2026-11-20T12:00:00Z".into()).unwrap());
    }

    fn visit(&mut self) -> &mut Visit {
        self.visit.as_mut().unwrap()
    }

    /// Time passes in frames of 50 ms.
    fn pass(&mut self, seconds: f64) {
        for _ in 0..(seconds / 0.05).round() as usize {
            self.road.pass(0.05);
            let visit = self.visit.as_mut().unwrap();
            visit.tick(Duration::from_millis(50), &mut self.road).unwrap();
        }
    }

    fn input(&mut self, input: Input) {
        self.visit.as_mut().unwrap().input(input, &mut self.road).unwrap();
    }

    /// Reads the page and goes on.
    fn next(&mut self) {
        self.pass(1.0);
        self.input(Input::Next);
    }

    fn command(&mut self, command: VisitCommand) {
        self.visit.as_mut().unwrap().command(command, &mut self.road).unwrap();
    }

    /// The command is not obeyed, and this is said.
    fn refused(&mut self, command: VisitCommand, has: &str) {
        let before = self.log();
        self.command(command);
        let said = self.visit().error().unwrap_or_default().to_owned();
        assert!(said.contains(has), "{said:?}");
        assert_eq!(self.log(), before, "nothing was done");
    }

    fn log(&self) -> Log {
        Log::load(&self.out.join("sourcedata/sub-P03").join(FILE)).unwrap()
    }

    /// What was, as name and outcome.
    fn passages(&self) -> Vec<(String, Outcome)> {
        self.log().passages.into_iter().map(|p| (p.item, p.outcome)).collect()
    }

    fn running(&self) -> String {
        self.log().running.map_or("nothing".into(), |running| running.item)
    }

    fn sees(&mut self) -> String {
        self.visit().sees()
    }

    fn answer(&mut self) {
        for _ in 0..20 {
            self.input(Input::Turn(1));
            self.input(Input::Next);
        }
    }

    /// From a page before a drive to the drive itself.
    fn drive_off(&mut self) {
        self.next();
        self.pass(3.5);
        assert!(self.sees().starts_with("drive "), "{}", self.sees());
    }

    /// To the intro of the practice drive.
    fn until_practice(&mut self) {
        self.next();
        self.next();
        self.answer();
        assert_eq!(self.sees(), "words before practice");
    }
}

fn reason(text: &str) -> String {
    text.into()
}

#[test]
fn a_visit_goes_from_the_welcome_to_the_thanks_and_every_step_is_on_the_disk() {
    let mut rig = Rig::new();
    assert!(matches!(rig.visit().screen(RoadNow::default()), Screen::Page("# Hello")));
    assert_eq!(rig.running(), "welcome");
    rig.input(Input::Next);
    assert_eq!(rig.running(), "welcome", "a page is not pressed away before it can be read");
    rig.next();
    assert_eq!(rig.sees(), "words before before");
    rig.next();
    assert_eq!(rig.sees(), "questions before, page 1 of 2");
    rig.pass(2.0);
    rig.answer();
    let answers = &rig.log().answers["before"];
    assert_eq!(answers.len(), 6);
    assert!((answers[0].time_s - 2.0).abs() < 0.01, "{answers:?}: since the page was seen");

    assert_eq!((rig.running().as_str(), rig.sees().as_str()), ("practice", "words before practice"));
    rig.next();
    assert_eq!(rig.sees(), "practice is being loaded");
    rig.pass(0.1);
    assert_eq!(rig.sees(), "countdown to practice");
    assert_eq!(rig.road.scenario.as_ref().unwrap().duration_s, 30.0);
    assert!(matches!(rig.visit().screen(RoadNow::default()), Screen::Countdown(3)));
    rig.pass(2.5);
    assert!(matches!(rig.visit().screen(RoadNow::default()), Screen::Countdown(1)) && rig.road.folder.is_none());
    rig.pass(0.6);
    assert_eq!(rig.road.folder, Some(rig.out.join("sourcedata/sub-P03/practice")));
    // The practice ends by its criterion, before its 30 s.
    rig.pass(3.0);
    rig.road.now.in_range_s = 1.9;
    rig.pass(0.1);
    assert_eq!(rig.sees(), "drive practice");
    rig.road.now.in_range_s = 2.0;
    rig.pass(0.1);
    assert_eq!((rig.sees().as_str(), rig.running().as_str()), ("the drive is over", "nothing"));
    assert_eq!(rig.road.said, ["criterion: 2 s in the range"]);

    rig.next();
    assert_eq!(rig.sees(), "rest rest");
    rig.next();
    assert_eq!(rig.sees(), "rest rest", "the rest is not over");
    let phase = rig.visit().phase(RoadNow::default());
    assert_eq!(phase, VisitPhase::Resting);
    rig.pass(9.5);
    rig.next();
    for name in ["trial-1-narrow", "trial-2-wide"] {
        assert_eq!(rig.running(), name);
        rig.drive_off();
        assert_eq!(rig.visit().left_s(RoadNow { duration_s: 8.0, time_s: 3.0, ..RoadNow::default() }), Some(5.0));
        rig.pass(8.1);
        assert_eq!(rig.sees(), "the drive is over");
        rig.next();
    }
    assert!(rig.visit().is_over() && rig.log().end.is_some_and(|end| end.complete));
    assert!(rig.passages().iter().all(|(_, outcome)| *outcome == Outcome::Done));
    assert_eq!(rig.visit().progress(), [6, 6]);
    rig.refused(VisitCommand::Stop(reason("late")), "the visit is over");
    rig.refused(VisitCommand::Skip(reason("late")), "the visit is over");
}

#[test]
fn after_a_cut_the_visit_goes_on_at_what_was_cut_when_the_experimenter_says_so() {
    let mut rig = Rig::new();
    // At each kind of item: a page, questions, the words before a drive, the drive itself, a rest.
    type Step = (&'static str, fn(&mut Rig));
    let steps: [Step; 5] = [
        ("welcome", |_| ()),
        ("before", |rig| {
            rig.next();
            rig.next();
            rig.input(Input::Turn(1));
            rig.input(Input::Next);
        }),
        ("practice", |rig| {
            rig.next();
            rig.answer();
        }),
        ("practice", |rig| {
            rig.drive_off();
            rig.pass(2.0);
        }),
        ("rest", |rig| {
            rig.drive_off();
            rig.pass(30.5);
            rig.next();
            rig.pass(5.0);
        }),
    ];
    for (cut, (name, go)) in steps.into_iter().enumerate() {
        go(&mut rig);
        assert_eq!(rig.running(), name);
        rig.open();
        let last = rig.log().passages.pop().unwrap();
        assert_eq!((last.item.as_str(), last.outcome, rig.running().as_str()), (name, Outcome::Cut, "nothing"));
        let screen = rig.visit().screen(RoadNow::default());
        assert!(matches!(screen, Screen::Wait(_)), "cut {cut}: {screen:?}");
        assert!(rig.visit().items().iter().any(|item| item.name == name && item.state == ItemState::Again));
        rig.next();
        assert_eq!(rig.running(), "nothing", "the participant waits");
        rig.command(VisitCommand::Go);
        assert_eq!(rig.running(), name);
    }
    assert_eq!(rig.visit().left_s(RoadNow::default()), Some(10.0), "a rest begins again");
    let recordings: Vec<String> = rig.log().passages.into_iter().filter_map(|p| p.recording).collect();
    assert_eq!(recordings, ["practice", "practice-again-1"]);
}

#[test]
fn what_is_broken_off_comes_again_and_what_is_called_back_comes_once_more() {
    let mut rig = Rig::new();
    rig.until_practice();
    rig.drive_off();
    rig.pass(1.0);
    rig.command(VisitCommand::Abort(reason("the phone rang")));
    assert_eq!(rig.road.said, ["aborted: the phone rang"]);
    assert!(rig.road.scenario.is_none() && rig.visit().phase(RoadNow::default()) == VisitPhase::Experimenter);
    let last = rig.log().passages.pop().unwrap();
    assert_eq!((last.outcome, last.reason.as_str()), (Outcome::Aborted, "the phone rang"));
    rig.refused(VisitCommand::Abort(reason("again")), "nothing runs");
    rig.command(VisitCommand::Go);
    assert_eq!(rig.sees(), "words before practice");
    let attempts = rig.visit().items().into_iter().find(|item| item.name == "practice").unwrap();
    assert_eq!((attempts.attempts, attempts.state), (2, ItemState::Now));

    // Called back while another item runs: it comes next. The running one called back is broken off.
    rig.command(VisitCommand::Repeat { item: "welcome".into(), reason: reason("did not read it") });
    assert_eq!(rig.running(), "practice");
    rig.command(VisitCommand::Repeat { item: "practice".into(), reason: reason("wrong seat") });
    assert_eq!(rig.running(), "nothing");
    rig.command(VisitCommand::Go);
    assert_eq!(rig.running(), "welcome");
    rig.refused(VisitCommand::Repeat { item: "rest".into(), reason: reason("x") }, "cannot be repeated");
    rig.next();
    assert_eq!(rig.running(), "practice");
}

#[test]
fn skipping_leaves_out_what_runs_or_what_comes_next() {
    let mut rig = Rig::new();
    rig.command(VisitCommand::Skip(reason("knows it")));
    assert_eq!(rig.running(), "before", "on to the next");
    rig.command(VisitCommand::Skip(reason("no time")));
    rig.drive_off();
    rig.command(VisitCommand::Skip(reason("no time")));
    assert_eq!(
        (rig.road.said.as_slice(), rig.running().as_str()),
        (["skipped: no time".to_owned()].as_slice(), "nothing")
    );
    // Nothing runs: what comes next is left out, and the participant goes on waiting.
    rig.command(VisitCommand::Skip(reason("not tired")));
    assert_eq!(rig.running(), "nothing");
    rig.command(VisitCommand::Go);
    assert_eq!(rig.running(), "trial-1-narrow");
    assert!(rig.passages().iter().all(|(_, outcome)| *outcome == Outcome::Skipped));
    for _ in 0..2 {
        rig.command(VisitCommand::Skip(reason("enough")));
    }
    assert!(rig.visit().is_over());
}

#[test]
fn drives_and_rests_last_longer_are_held_and_go_on() {
    let mut rig = Rig::new();
    rig.refused(VisitCommand::Extend { seconds: 5.0, reason: reason("x") }, "drives and rests can");
    rig.refused(VisitCommand::Pause, "no drive runs");
    rig.until_practice();
    rig.next();
    rig.pass(0.1);
    rig.command(VisitCommand::Pause);
    rig.pass(5.0);
    assert_eq!(rig.visit().phase(RoadNow::default()), VisitPhase::Held, "a countdown is held too");
    rig.command(VisitCommand::Resume);
    rig.pass(3.2);
    rig.command(VisitCommand::Pause);
    let now = rig.road.now;
    assert!(now.held && matches!(rig.visit().screen(now), Screen::Drive(Some(_))));
    rig.pass(60.0);
    rig.command(VisitCommand::Go);
    assert!(!rig.road.now.held && rig.sees() == "drive practice");
    rig.refused(VisitCommand::Extend { seconds: 0.0, reason: reason("x") }, "1 to 3600 s");
    rig.command(VisitCommand::Extend { seconds: 20.0, reason: reason("came late") });
    rig.pass(40.0);
    assert_eq!(rig.sees(), "drive practice");
    rig.pass(10.5);
    assert_eq!(rig.sees(), "the drive is over");
    let said = ["paused: by the experimenter", "resumed: by the experimenter", "extended: by 20 s: came late"];
    assert_eq!(rig.road.said, said);
    let kinds: Vec<String> = rig.log().notes.into_iter().map(|note| note.kind).collect();
    assert_eq!(kinds, ["paused", "resumed", "paused", "resumed", "extended"]);

    rig.next();
    rig.command(VisitCommand::Extend { seconds: 30.0, reason: reason("needs air") });
    rig.pass(20.0);
    assert_eq!(rig.visit().phase(RoadNow::default()), VisitPhase::Resting);
    rig.command(VisitCommand::Go);
    assert_eq!(rig.running(), "trial-1-narrow", "the experimenter ends a rest");
    assert!(rig.log().notes.last().is_some_and(|note| note.kind == "go" && note.text.contains("20 s sooner")));
}

#[test]
fn notes_and_marks_are_in_the_session_and_while_driving_in_the_recording() {
    let mut rig = Rig::new();
    rig.command(VisitCommand::Note(reason("left-handed")));
    rig.until_practice();
    rig.drive_off();
    rig.command(VisitCommand::Mark(String::new()));
    rig.input(Input::Mark);
    rig.command(VisitCommand::Note(reason("coughs")));
    assert_eq!(rig.road.said, ["mark: by the experimenter", "mark: by the participant", "note: coughs"]);
    let notes = rig.log().notes;
    let list: Vec<(&str, Option<&str>)> = notes.iter().map(|n| (n.text.as_str(), n.item.as_deref())).collect();
    let practice = Some("practice");
    assert_eq!(list[0], ("left-handed", Some("welcome")));
    assert_eq!(list[1..], [("by the experimenter", practice), ("by the participant", practice), ("coughs", practice)]);
}

#[test]
fn a_participant_who_asks_to_stop_holds_the_drive_and_sickness_ends_the_visit_for_good() {
    let mut rig = Rig::new();
    rig.until_practice();
    rig.drive_off();
    rig.input(Input::Stop);
    assert!(rig.road.now.held && rig.visit().asked());
    let words = rig.study.file.texts.asked.clone();
    let now = rig.road.now;
    assert!(matches!(rig.visit().screen(now), Screen::Drive(Some(text)) if text == words));
    rig.command(VisitCommand::Go);
    assert!(!rig.road.now.held && !rig.visit().asked());
    rig.input(Input::Stop);
    rig.command(VisitCommand::Stop(reason("sickness")));
    assert!(rig.visit().is_over() && rig.road.scenario.is_none());
    assert!(rig.road.said.contains(&"stopped: sickness".into()), "{:?}", rig.road.said);
    let end = rig.log().end.unwrap();
    assert_eq!((end.complete, end.reason.as_str()), (false, "sickness"));
    rig.visit = None;
    let data = DataSet::open(&rig.out, &rig.study).unwrap();
    let again = Session::open(&data, &rig.study, &Code::new("P03").unwrap(), Who::Person, 0, "later");
    assert!(again.unwrap_err().to_string().contains("stopped for good (sickness"));
}

#[test]
fn a_drive_that_cannot_start_or_go_on_is_said_and_comes_again() {
    let mut rig = Rig::new();
    rig.until_practice();
    rig.road.fails = true;
    rig.next();
    rig.pass(0.2);
    assert!(rig.visit().error().is_some_and(|error| error.contains("no road")));
    assert_eq!(rig.visit().phase(RoadNow::default()), VisitPhase::Experimenter);
    rig.road.fails = false;
    rig.command(VisitCommand::Go);
    assert!(rig.visit().error().is_none());
    rig.drive_off();
    let Rig { visit, road, .. } = &mut rig;
    visit.as_mut().unwrap().fail(&RecordError::Full(8).into(), road).unwrap();
    let last = rig.log().passages.pop().unwrap();
    assert!(last.outcome == Outcome::Aborted && last.reason.contains("the disk takes nothing any more"), "{last:?}");
    assert_eq!(rig.sees(), "please wait");
}

#[test]
fn a_wheel_and_its_buttons_lead_through_pages_and_questions() {
    const STEERING: u16 = 0;
    const CROSS: u16 = 288;
    const TRIANGLE: u16 = 291;
    const RIGHT_PADDLE: u16 = 292;
    let (to, told) = std::sync::mpsc::channel();
    let values = [(0, 32_767), (1, 255), (2, 255), (5, 255)].into_iter().collect();
    let profile = profiles::named("g29").unwrap();
    let device = Device { name: "G29".into(), id: (0x046d, 0xc24f), axes: Default::default(), values };
    let found = Found { device, profile, lamps: Lamps::default(), force: None, angle: Default::default() };
    to.send(Told::Found(Box::new(found))).unwrap();
    let mut kit = Kit::new(Devices::with_rig(WheelRig::fed_by(told)), &Code::new("P03").unwrap());
    let mut rig = Rig::new();
    let mut act = |rig: &mut Rig, told: &[Told]| {
        rig.pass(0.5);
        for one in told {
            let one = match one {
                Told::Axis { code, raw, .. } => Told::Axis { code: *code, raw: *raw, at: None },
                Told::Button { code, .. } => Told::Button { code: *code, down: true, at: None },
                _ => continue,
            };
            to.send(one).unwrap();
            let (_, inputs) = kit.frame(Duration::ZERO, |_| ()).unwrap();
            inputs.into_iter().for_each(|input| rig.input(input));
        }
    };
    let turn = |degrees: f64| {
        let raw = 32_767 - (degrees / 450.0 * 32_767.0) as i32;
        Told::Axis { code: STEERING, raw, at: None }
    };
    let press = |code: u16| Told::Button { code, down: true, at: None };
    act(&mut rig, &[turn(0.0), press(CROSS)]);
    act(&mut rig, &[press(CROSS)]);
    assert_eq!(rig.sees(), "questions before, page 1 of 2");
    // 13 degrees to the right are a place: the middle of the scale, and one more.
    act(&mut rig, &[turn(-13.0), turn(-26.0), press(CROSS)]);
    // Back to the first question, one place to the left, and on; the wheel goes on from where it is.
    act(&mut rig, &[press(TRIANGLE), turn(-11.0), press(CROSS), press(RIGHT_PADDLE)]);
    for step in 0..5 {
        act(&mut rig, &[turn(-40.0 - 20.0 * f64::from(step)), press(CROSS)]);
        if step == 1 {
            act(&mut rig, &[press(CROSS)]);
        }
    }
    act(&mut rig, &[press(CROSS)]);
    let answers = rig.log().answers["before"].clone();
    assert_eq!((answers.len(), &answers[0].answer), (6, &serde_json::json!(50)), "{answers:?}");
    assert_eq!(rig.running(), "practice");
    assert!(rig.log().notes.iter().any(|note| note.kind == "mark" && note.text == "by the participant"));
}
