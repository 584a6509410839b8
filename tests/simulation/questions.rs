//! Questions of events: each is shown from its onset to its answer or the end of its time, is scored by who drives at the answer, and is replayed to
//! the bit.

use crate::events::{RING, scenario};
use codrive::{
    controls::{Controls, TaskButton},
    drive_loop::recording_manifest,
    record::{self, Manifest, Table, TableReader},
    replay::Replay,
    sim::{SummaryAccumulator, World},
    snapshot::TaskPicture,
};

/// Three questions, the first while the automation drives; the last one is not answered.
const QUESTIONS: &str = r#"
[secondary_task]
kind = "surrogate-reference"
[automation]
system = "cruise-and-lane-keeping"
starts_on = true
[[event]]
name = "automated"
trigger = { time_s = 1 }
actions = [{ ask = { question = "Who steers now?", answers = ["I", "the car"], right = "I", right_automated = "the car", for_s = 2 } }]
[[event]]
name = "off"
trigger = { time_s = 2 }
actions = [{ automation = "off" }]
[[event]]
name = "by hand"
trigger = { time_s = 3 }
actions = [{ ask = { question = "Who steers now?", answers = ["I", "the car"], right = "I", right_automated = "the car", for_s = 2 } }]
[[event]]
name = "ignored"
trigger = { time_s = 5 }
actions = [{ ask = { question = "How tired are you?", answers = ["little", "so so", "very"], for_s = 1.5 } }]
"#;

/// Ticks at which the right button is pressed: an answer, an answer, and one for the secondary task.
const PRESSES: [u64; 3] = [151, 401, 700];

#[test]
fn questions_are_shown_answered_scored_and_replayed() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("drive");
    let mut world = World::new(&scenario(&format!("{RING}{QUESTIONS}"))).expect("the native engine");
    let manifest =
        Manifest { driver: "keyboard".into(), ..recording_manifest::manifest(&world, "keyboard".into(), None) };
    let mut recorder = recording_manifest::begin(&path, &world, manifest).expect("a new folder");
    let mut summary = SummaryAccumulator::new([0.0, f64::INFINITY]);
    let (mut shown, mut cursors) = (Vec::new(), Vec::new());
    for tick in 1..=800 {
        let task_button = if PRESSES.contains(&tick) { TaskButton::Right } else { TaskButton::None };
        let controls = Controls { task_button, ..Controls::default() };
        world.tick(&controls).expect("the native engine");
        recorder.tick(&world, &controls).expect("room");
        summary.add(world.snapshot(), world.events());
        if let Some(question) = &world.snapshot().question {
            shown.push((tick, question.answers.len()));
        }
        if let TaskPicture::Search { cursor, .. } = world.snapshot().task.shown {
            cursors.push(cursor);
        }
    }
    let summary = summary.to_summary();
    recorder.finish(&summary).expect("room");
    let stretch = |from: u64, to: u64, answers: usize| (from..=to).map(move |tick| (tick, answers));
    let expected: Vec<_> = stretch(101, 150, 2).chain(stretch(301, 400, 2)).chain(stretch(501, 650, 3)).collect();
    assert_eq!(shown, expected);
    // Presses that answer do not move the band of the secondary task.
    assert!(cursors[..699].iter().all(|cursor| *cursor == 3) && cursors[699..].iter().all(|cursor| *cursor == 4));
    let table = TableReader::parquet(&Table::Events.parquet(&path)).expect("a table");
    let rows: Vec<_> = table
        .words("event")
        .into_iter()
        .zip(table.words("detail"))
        .zip(table.wholes("tick").into_iter().zip(table.numbers("value")))
        .filter(|((kind, _), _)| kind.starts_with("question"))
        .map(|((kind, detail), (tick, value))| (tick, kind["question_".len()..].to_owned(), detail, value))
        .collect();
    let row = |tick: u64, kind: &str, detail: &str, value| (tick, kind.to_owned(), detail.to_owned(), value);
    let expected = [
        row(101, "asked", "automated", None),
        row(151, "answered", "right", Some(2.0)),
        row(301, "asked", "by hand", None),
        row(401, "answered", "wrong", Some(2.0)),
        row(501, "asked", "ignored", None),
        row(651, "unanswered", "ignored", None),
    ];
    assert_eq!(rows, expected);
    let score = summary.secondary_task.questions.expect("questions");
    assert_eq!((score.questions, score.questions_unanswered, score.question_correct), (3, 1, Some(0.5)));
    // Half a second, and a second.
    assert!((score.question_response_s.expect("answers") - 0.75).abs() < 1e-9);
    assert!(record::changes(&path).expect("a recording").is_empty());
    let mut replay = Replay::open(&path).expect("it can be driven");
    replay.advance(u64::MAX).expect("the native engine");
    assert!(replay.report().is_proven() && replay.report().ticks == 800, "{:?}", replay.report());
}
