//! Tests of tables of events: rows of a recorded drive by hand, and the description of every word.

use super::*;

#[test]
fn advice_and_events_of_a_recording_are_rows_in_the_order_of_time() {
    use crate::{
        controls::Controls,
        record::{Manifest, Recorder},
        scenario::Scenario,
        sim::{SummaryAccumulator, World},
        time::Tick,
        traffic::EngineChoice,
    };
    let folder = tempfile::tempdir().unwrap();
    let scenario = Scenario {
        traffic: EngineChoice::Native,
        policy: "constant".into(),
        policy_speed_mps: 4.0,
        range_mph: 1.0,
        hold_s: 0.5,
        duration_s: 1.2,
        ..Scenario::default()
    };
    let mut world = World::new(&scenario).unwrap();
    let mut recorder = Recorder::begin(&folder.path().join("drive"), &scenario, Manifest::default()).unwrap();
    let mut summary = SummaryAccumulator::new([0.0, f64::INFINITY]);
    for tick in 1..=120 {
        world.tick(&Controls::default()).unwrap();
        summary.add(world.snapshot(), world.events());
        recorder.tick(&world, &Controls::default()).unwrap();
        if tick == 33 {
            recorder.event(Tick(tick), "note", "coughs");
        }
    }
    let folder = recorder.finish(&summary.to_summary()).unwrap();
    let table = DriveEvents::of(&folder).unwrap().since(0);
    assert!(table.rows.is_sorted_by_key(|row| row[3].parse::<u64>().unwrap()), "{:?}", table.rows);
    let of = |kind: &str| table.rows.iter().filter(|row| row[2] == kind).cloned().collect::<Vec<_>>();
    let none = String::new;
    let text = |words: &str| words.to_owned();
    assert_eq!(
        of("note"),
        [vec![text("0.33"), none(), text("note"), text("33"), none(), none(), none(), none(), none(), text("coughs")]]
    );
    let ended = of("ended");
    assert_eq!((ended.len(), &ended[0][0], &ended[0][9]), (1, &text("1.20"), &text("duration")));
    let advice = of("advice");
    // Two or three holds of 0.5 s begin within 1.2 s.
    assert!((2..=3).contains(&advice.len()), "{advice:?}");
    for row in &advice {
        assert_eq!(row[1..3], ["0.5", "advice"]);
        // A mile is 1609.344 m, so the range is 0.44704 m/s to either side.
        let [target, low, high] = [4, 5, 6].map(|i: usize| row[i].parse::<f64>().unwrap());
        assert!(target == 4.0 && (low - 3.552_96).abs() < 1e-9 && (high - 4.447_04).abs() < 1e-9, "{row:?}");
        assert_eq!((row[8].as_str(), row[9].as_str()), ("", ""), "an advice has no value and no words");
    }
    let ticks: Vec<u64> = advice.iter().map(|row| row[3].parse().unwrap()).collect();
    assert!(ticks.windows(2).all(|pair| pair[1] - pair[0] == 50), "{ticks:?}");
    let text = table.text();
    assert!(text.starts_with("onset\tduration\ttrial_type\ttick\ttarget_speed\t"), "{text}");
}

#[test]
fn onsets_have_two_decimals_and_are_negative_before_the_first_sample() {
    let onsets =
        [(1205, 0), (7, 0), (0, 0), (0, 1), (1, 1), (101, 1), (0, 250)].map(|(tick, first)| onset(tick, first));
    assert_eq!(onsets, ["12.05", "0.07", "0.00", "-0.01", "0.00", "1.00", "-2.50"]);
    let rows = vec![(5, vec![String::new(), "mark".into()])];
    assert_eq!(DriveEvents { rows }.since(1).rows, [["0.04", "", "mark"]]);
}

#[test]
fn every_event_word_has_a_meaning_and_tags() {
    let tagged = serde_json::from_str::<Value>(&sidecar()).unwrap();
    let words = |key: &str| tagged["trial_type"][key].as_object().unwrap().keys().cloned().collect::<Vec<_>>();
    assert_eq!(words("Levels"), words("HED"));
    assert!(words("Levels").contains(&"advice_withheld".to_owned()));
    assert_eq!(tagged["target_speed"]["HED"], "(Label/Advised-speed, Speed/# m-per-s)");
    assert_eq!(tagged["speed"]["Units"], "m/s");
}
