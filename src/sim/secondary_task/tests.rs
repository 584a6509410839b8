//! Runs of each task with given presses.

use super::{step::ticks, *};
use crate::{
    metrics::{TaskLog, TaskResponse, TaskStimulus},
    scenario::SecondaryTask,
    sim::EventKind,
    snapshot::TaskPicture,
};

/// Runs a task for some seconds with presses at some times, s. Returns its events, and the picture of each tick from 0 on.
fn run(task: SecondaryTask, seconds: f64, presses: &[(f64, TaskButton)]) -> (Vec<Event>, Vec<TaskPicture>) {
    let mut run = TaskRun::new(&Scenario { secondary_task: task, seed: 5, ..Scenario::default() }).unwrap();
    let (mut events, mut pictures) = (Vec::new(), vec![TaskPicture::None]);
    for tick in (1..=ticks(seconds)).map(Tick) {
        let pressed = presses.iter().find(|press| Tick::at_seconds(press.0) == tick);
        pictures.push(run.tick(tick, pressed.map_or(TaskButton::None, |press| press.1), &mut events).shown);
    }
    (events, pictures)
}

fn of_kind(kind: SecondaryTaskKind) -> SecondaryTask {
    SecondaryTask { kind, ..SecondaryTask::default() }
}

fn onsets(events: &[Event]) -> Vec<u64> {
    events.iter().filter(|event| matches!(event.kind, EventKind::TaskStimulus(_))).map(|event| event.tick.0).collect()
}

fn log(events: &[Event]) -> TaskLog {
    let mut log = TaskLog::default();
    events.iter().for_each(|event| event.add_to(&mut log));
    log
}

#[test]
fn signals_come_every_3_to_5_s_and_last_until_a_response_or_1_s() {
    let task = of_kind(SecondaryTaskKind::DetectionResponse);
    let (events, pictures) = run(task, 4000.0, &[]);
    let onsets = onsets(&events);
    let apart: Vec<u64> =
        std::iter::once(&0).chain(&onsets).zip(&onsets).map(|(before, after)| after - before).collect();
    assert!(apart.iter().all(|apart| (300..=500).contains(apart)), "{apart:?}");
    // A uniform distribution from 3 to 5 s has mean 4 s; the standard error of 1000 draws is 0.018 s.
    let mean = apart.iter().sum::<u64>() as f64 / apart.len() as f64;
    assert!((mean - 400.0).abs() < 6.0, "{mean}");
    let lit = |pictures: &[TaskPicture]| pictures.iter().filter(|shown| **shown == TaskPicture::Signal).count();
    let first = onsets[0] as usize;
    assert_eq!((lit(&pictures[..first]), lit(&pictures[..first + 200])), (0, 100));
    // A press after 0.05 s leaves the signal on, one after 0.4 s puts it out.
    let at = |after_s: f64| (Tick(first as u64).seconds() + after_s, TaskButton::Respond);
    let (answered, pictures) = run(task, 8.0, &[at(0.05), at(0.4)]);
    assert_eq!(lit(&pictures[..first + 200]), 40);
    let score = log(&answered).scores(Tick(first as u64).seconds() + 2.5).detection.unwrap();
    assert_eq!((score.detection_signals, score.detection_misses, score.detection_false_responses), (1, 0, 1));
    assert!((score.detection_response_s.unwrap() - 0.4).abs() < 1e-9);
}

#[test]
fn digits_come_in_blocks_of_ten_every_2_25_s() {
    let (events, _) = run(of_kind(SecondaryTaskKind::NBack), 64.0, &[]);
    // From 5 s on, ten digits, then 2.25 s and a pause of 7.5 s.
    let expected: Vec<u64> = [500, 3500].iter().flat_map(|from| (0..10).map(move |i| from + 225 * i)).collect();
    assert_eq!(onsets(&events), expected);
}

#[test]
fn a_digit_matches_exactly_if_it_is_the_one_n_back() {
    for n in 0..=2 {
        let (events, _) = run(SecondaryTask { n, ..of_kind(SecondaryTaskKind::NBack) }, 3000.0, &[]);
        let digits: Vec<(u8, Option<bool>)> = events
            .iter()
            .filter_map(|event| match event.kind {
                EventKind::TaskStimulus(TaskStimulus::Digit { digit, is_match }) => Some((digit, is_match)),
                _ => None,
            })
            .collect();
        assert_eq!(digits.len(), 1000);
        for block in digits.chunks(10) {
            for (i, (digit, is_match)) in block.iter().enumerate() {
                let expected = match n {
                    0 => Some(*digit == 0),
                    n => i.checked_sub(usize::from(n)).map(|before| block[before].0 == *digit),
                };
                assert_eq!(*is_match, expected, "{n}-back, {block:?}");
            }
        }
        let matches = digits.iter().filter(|digit| digit.1 == Some(true)).count() as f64;
        let able = digits.iter().filter(|digit| digit.1.is_some()).count() as f64;
        assert!((matches / able - 1.0 / 3.0).abs() < 0.05, "{n}-back: {matches} of {able}");
    }
}

#[test]
fn a_block_with_spoken_responses_has_each_digit_once() {
    let task = SecondaryTask { spoken_response: true, ..of_kind(SecondaryTaskKind::NBack) };
    let (events, _) = run(task, 30.0, &[]);
    let mut digits: Vec<f64> = events
        .iter()
        .filter_map(|event| if let EventKind::TaskStimulus(stimulus) = event.kind { stimulus.words().1 } else { None })
        .collect();
    digits.sort_by(f64::total_cmp);
    assert_eq!(digits, (0..10).map(f64::from).collect::<Vec<_>>());
}

#[test]
fn a_confirmed_column_ends_a_display() {
    let task = SecondaryTask { columns: 2, ..of_kind(SecondaryTaskKind::SurrogateReference) };
    use TaskButton::{Left, Respond, Right};
    // The cursor begins at the second of two columns, and stays within both.
    let presses = [(1.0, Left), (1.5, Left), (2.0, Respond), (3.0, Right), (5.0, Respond)];
    let (events, pictures) = run(task, 6.0, &presses);
    assert_eq!(onsets(&events), [1, 200, 500]);
    let log = log(&events);
    let columns: Vec<TaskResponse> = log.responses.iter().map(|response| response.1).collect();
    assert_eq!(columns, [TaskResponse::Column(1), TaskResponse::Column(2)]);
    let score = log.scores(6.0).search.unwrap();
    assert_eq!(score.search_displays, 2);
    // From 0.01 to 2 s, and from 2 to 5 s.
    assert!((score.search_response_s.unwrap() - (1.99 + 3.0) / 2.0).abs() < 1e-9);
    let cursor = |tick: usize| match pictures[tick] {
        TaskPicture::Search { cursor, .. } => cursor,
        _ => panic!("no display at {tick}"),
    };
    assert_eq!([50, 120, 199, 250, 350].map(cursor), [1, 0, 0, 1, 1]);
}

#[test]
fn a_shutter_moves_by_time_or_opens_on_a_press() {
    let task = of_kind(SecondaryTaskKind::Occlusion);
    let movements = |task, presses: &[(f64, TaskButton)]| -> Vec<(u64, bool)> {
        let log = log(&run(task, 8.0, presses).0);
        log.shutter.iter().map(|(tick, is_open)| (tick.0, *is_open)).collect()
    };
    let paced = [(1, true), (151, false), (301, true), (451, false), (601, true), (751, false)];
    assert_eq!(movements(task, &[(2.0, TaskButton::Respond)]), paced, "a press has no effect");
    let own = SecondaryTask { self_paced: true, ..task };
    let presses = [(1.0, TaskButton::Respond), (4.0, TaskButton::Respond), (4.5, TaskButton::Left)];
    assert_eq!(movements(own, &presses), [(1, true), (151, false), (400, true), (550, false)]);
}
