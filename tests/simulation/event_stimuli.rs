//! Stimuli that events give the participant: each is in the snapshot from its onset to its end, is recorded and is replayed to the bit.

use crate::events::{RING, scenario};
use codrive::{
    drive_loop::offline::OfflineDrive,
    record::{self, Table, TableReader},
    replay::Replay,
    scenario::Scenario,
    snapshot::{EventStimuli, Pictogram, ToneSeries},
    time::Tick,
};

/// Returns an event at a time, s, with one action.
fn event(name: &str, time_s: f64, action: &str) -> String {
    format!("[[event]]\nname = \"{name}\"\ntrigger = {{ time_s = {time_s} }}\nactions = [{action}]\n")
}

/// Drives and records a scenario for 4 s, and checks that its replay is proven. Returns the stimuli after each tick, and the rows of events.
fn recorded(events: &str) -> (Vec<EventStimuli>, Vec<(u64, String)>) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("drive");
    let mut run = OfflineDrive::new(&scenario(&format!("{RING}{events}")), [0.0, f64::INFINITY]).expect("a drive");
    run.record(&path).expect("a recording");
    let mut seen = Vec::new();
    for k in 1..=400 {
        run.until(f64::from(k) * 0.01).expect("the traffic goes on");
        seen.push(run.world().snapshot().stimuli.as_deref().cloned().unwrap_or_default());
    }
    drop(run);
    record::recover(&path).expect("it is recovered");
    let table = TableReader::parquet(&Table::Events.parquet(&path)).expect("a table");
    let rows = table.wholes("tick").into_iter().zip(table.words("event")).collect();
    let mut replay = Replay::open(&path).expect("it can be driven");
    replay.advance(u64::MAX).expect("the traffic goes on");
    assert!(replay.report().is_proven() && replay.report().ticks == 400, "{:?}", replay.report());
    (seen, rows)
}

/// Returns the ticks of the first and last stimuli that fit, and checks that all between fit, too.
fn ticks_of(seen: &[EventStimuli], fits: impl Fn(&EventStimuli) -> bool) -> [usize; 2] {
    let ticks: Vec<usize> = (1..).zip(seen).filter(|(_, stimuli)| fits(stimuli)).map(|(tick, _)| tick).collect();
    let [Some(first), Some(last)] = [ticks.first(), ticks.last()] else { panic!("it never comes") };
    assert_eq!(ticks.len(), last - first + 1, "without a gap: {ticks:?}");
    [*first, *last]
}

#[test]
fn tones_and_sentences_begin_at_the_recorded_onset() {
    let (seen, rows) = recorded(
        &(event("tones", 1.0, "{ sound = { tone = \"urgent\", for_s = 1.5 } }")
            + &event("words", 2.0, "{ speak = { text = \"Mind the gap\" } }")),
    );
    let tones = ticks_of(&seen, |stimuli| stimuli.tones == [(ToneSeries::Urgent, Tick(101))]);
    assert_eq!(tones, [101, 250]);
    // A sentence takes no time of the drive: it is there for one step of 0.1 s.
    let sentence = Some(("Mind the gap".into(), Tick(201)));
    assert_eq!(ticks_of(&seen, |stimuli| stimuli.sentence == sentence), [201, 210]);
    let of = |kind: &str| rows.iter().filter(|(_, event)| event == kind).map(|(tick, _)| *tick).collect::<Vec<_>>();
    assert_eq!([of("event_armed"), of("event_onset"), of("event_ended")], [[0, 0], [101, 201], [210, 250]]);
}

#[test]
fn signs_and_pulses_last_as_long_as_their_event_says() {
    let (seen, rows) = recorded(
        &(event("sign", 1.0, "{ pictogram = { sign = \"hands_on\", for_s = 2 } }")
            + &event("pulse", 2.0, "{ wheel_pulse = { strength = 0.5, for_s = 0.3 } }")),
    );
    assert_eq!(ticks_of(&seen, |stimuli| stimuli.pictogram == Some(Pictogram::HandsOn)), [101, 300]);
    assert_eq!(ticks_of(&seen, |stimuli| stimuli.wheel_pulse == 0.5), [201, 230]);
    let ends: Vec<u64> = rows.iter().filter(|(_, event)| event == "event_ended").map(|(tick, _)| *tick).collect();
    assert_eq!(ends, [230, 300]);
}

#[test]
fn stimuli_beyond_their_bounds_are_refused_with_value_and_remedy() {
    let fault = |action: &str| {
        let text = format!("{RING}{}", event("e", 1.0, action));
        Scenario::from_toml(&text, "stimuli.toml").expect_err("it is refused").message
    };
    for (action, words) in [
        ("{ sound = { tone = \"loud\" } }", "gentle"),
        ("{ sound = { tone = \"gentle\", for_s = 0 } }", "for_s is 0; allowed: 0.1 to 604800"),
        ("{ pictogram = { sign = \"go\", for_s = 3 } }", "hands_on"),
        ("{ wheel_pulse = { strength = 2, for_s = 0.3 } }", "strength is 2; allowed: 0.05 to 1"),
        ("{ wheel_pulse = { strength = 1, for_s = 60 } }", "for_s is 60; allowed: 0.1 to 10"),
        ("{ ask = { question = \"a\", answers = [\"b\"], for_s = 3 } }", "1 answers; allowed: 2 or 3"),
        (
            "{ ask = { question = \"a\", answers = [\"b\", \"c\"], right = \"d\", for_s = 3 } }",
            "right is \"d\"; allowed: \"b\", \"c\"",
        ),
        (
            "{ ask = { question = \"a\", answers = [\"b\", \"c\"], right_automated = \"b\", for_s = 3 } }",
            "right_automated needs right",
        ),
        (
            "{ ask = { question = \"a\", answers = [\"b\", \" \"], for_s = 3 } }",
            "answer has 1 letters; allowed: 1 to 20",
        ),
        ("{ speak = { text = \" \" } }", "text has 1 letters; allowed: 1 to 200"),
        (&format!("{{ speak = {{ text = \"{}\" }} }}", "a".repeat(201)), "text has 201 letters; allowed: 1 to 200"),
    ] {
        let message = fault(action);
        assert!(message.contains(words) && message.contains("stimuli.toml:9"), "{action}: {message}");
    }
}
