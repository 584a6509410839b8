//! Methods for drives made up by hand.

use super::*;
use crate::analysis::{data::StudyParticipant, drives::test_drives, network::NetworkDriveTotals};
use crate::sim::HandOver;

/// Returns four simulated trials of two people in two conditions with different ranges.
fn made() -> Vec<AnalysedRecording> {
    let mut drives = test_drives::drives();
    for (i, drive) in drives.iter_mut().enumerate() {
        drive.setup.manifest.program = "codrive 0.1.0".into();
        drive.setup.manifest.traffic = "SUMO 1.28.0 in process".into();
        drive.setup.manifest.driver = "simulated participant".into();
        drive.setup.manifest.policy.name = "two-phase".into();
        drive.setup.manifest.map.name = "ring-250".into();
        drive.setup.route_m = 250.0;
        drive.setup.scenario.seed = 10 + i as u64;
        drive.setup.scenario.range_mph = if i % 2 == 0 { 0.5 } else { 2.0 };
    }
    drives
}

#[test]
fn the_methods_say_what_ran_with_which_parameters_and_how_drives_differ() {
    let person = |id: &str, state: &str| StudyParticipant {
        id: id.into(),
        is_simulated: true,
        state: state.into(),
        ..StudyParticipant::default()
    };
    let all = vec![person("sub-P01", "complete"), person("sub-P02", "partial"), person("sub-P03", "excluded")];
    let found = paragraphs(&made(), &StudyParticipants { all, ..StudyParticipants::default() }, &[]);
    let text = text(&found, &made());
    for part in [
        "4 drives of 2 simulated participants were analysed.",
        "no person took part",
        "1 complete, 1 partial and 1 excluded",
        "of 1 participant (sub-P03) were excluded",
        "made with codrive 0.1.0 and analysed with",
        "The traffic was computed by SUMO 1.28.0, run within codrive.",
        "recorded at 100 Hz, all vehicles at 10 Hz",
        "The road was ring-250, a closed route of 250 m, with 22 vehicles",
        "v0 = 30 m/s, a desired time gap T = 1 s, a maximum acceleration a = 1 m/s², a comfortable deceleration b = 1.5 m/s²",
        "by the policy two-phase; an advice was held for 1 s.",
        "reached 0.5 and 2 mph (0.2235 and 0.8941 m/s)",
        "(few & <fast>: half width of the advised range 0.5 mph; many: half width of the advised range 2 mph)",
        "The order was the same for all participants.",
        "Each drive had its own seed, from 10 to 13",
        "| Mean speed of all vehicles | m/s | speed of all vehicles, the ego vehicle included: mean over",
        "percentile bootstrap over participants, 2,000 resamples",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    assert!(!text.contains("computed again without advice"), "there is no such drive: {text}");
    let mut alone = made();
    alone.iter_mut().for_each(|drive| drive.found.participant.clear());
    let text = paragraphs(&alone, &StudyParticipants::default(), &[]).join("\n");
    assert!(text.contains("no person took part") && !text.contains("rehearsal"), "drives of no study: {text}");
    let mut drives = made();
    for (drive, place) in drives.iter_mut().zip(["1", "2", "2", "1"]) {
        drive.found.place = place.into();
    }
    let text = paragraphs(&drives, &StudyParticipants::default(), &[]).join("\n");
    assert!(text.contains("There were 2 different orders."), "{text}");
}

#[test]
fn the_methods_tell_measured_people_from_drivers_who_are_alike() {
    let mut drives = made();
    drives[..2].iter_mut().for_each(|drive| drive.setup.scenario.traffic_drivers = "gap-closers".into());
    let text = paragraphs(&drives, &StudyParticipants::default(), &[]).join("\n");
    assert!(text.contains("In 2 drives, the other vehicles followed the Intelligent Driver Model with"), "{text}");
    let people = "In 2 drives, the other vehicles were driven by persons of a population, \"People who close the gap: Instruction II \
                  of the Arizona ring\", by the optimal velocity model";
    assert!(text.contains(people) && text.contains("alpha = 0.666 1/s"), "{text}");
}

#[test]
fn the_methods_tell_a_sham_from_advice_and_say_when_the_driver_took_over() {
    let mut drives = made();
    for (i, drive) in drives.iter_mut().enumerate() {
        drive.setup.scenario.range_mph = 1.0;
        drive.setup.scenario.sham_advice = i % 2 == 0;
    }
    let message = |drives: &[AnalysedRecording]| paragraphs(drives, &StudyParticipants::default(), &[]).join("\n");
    let text = message(&drives);
    assert!(
        text.contains("(few & <fast>: advice recorded in another drive (sham); many: advice of this drive)"),
        "{text}"
    );
    assert!(!text.contains("took over"), "{text}");
    for drive in &mut drives {
        drive.setup.scenario.wave_sd_mps = 2.0;
        drive.setup.scenario.standing_start = true;
        drive.setup.scenario.wave_wait_s = 600.0;
        drive.setup.manifest.hand_over = HandOver { is_as_asked: true, ..HandOver::default() };
    }
    let gate = "The driver then took over as soon as the standard deviation of speed over the vehicles had been 2 m/s \
                or more for 10 s and the ego vehicle stood still, or after a further 600 s at the latest; ";
    let text = message(&drives);
    assert!(text.contains(&format!("{gate}no drive began otherwise.")), "{text}");
    drives[0].setup.manifest.hand_over = HandOver::default();
    let text = message(&drives);
    assert!(text.contains(&format!("{gate}1 drive began otherwise.")), "{text}");
}

#[test]
fn the_methods_describe_traffic_on_networks_apart_from_closed_routes() {
    let mut drives = made();
    for drive in &mut drives[..2] {
        drive.setup.scenario.path = "A0B0 B0B1".into();
        drive.setup.scenario.warm_up_s = 30.0;
        drive.setup.manifest.map.name = "maps/grid".into();
        drive.setup.route_m = 1118.2;
        drive.network.insert(NetworkDriveTotals::default()).vehicles = 40;
    }
    let text = paragraphs(&drives, &StudyParticipants::default(), &[]).join("\n");
    for part in [
        "The road was ring-250, a closed route of 250 m, with 22 vehicles",
        "The ego vehicle drove on the road network grid, along a path of 1118 m. The traffic was computed by SUMO \
         1.28.0, run within codrive; vehicles entered and left, 40 in each drive. The traffic ran for 30 s before the \
         drive",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    let text = paragraphs(&drives[..2], &StudyParticipants::default(), &[]).join("\n");
    assert!(!text.contains("closed route") && !text.contains("Intelligent Driver Model"), "{text}");
}

#[test]
fn methods_of_a_single_drive_mention_no_statistics_and_no_participants() {
    let mut drives = made();
    drives.truncate(1);
    drives[0].found = crate::analysis::data::found::FoundRecording::default();
    drives[0].setup.manifest.driver = "simulated: follow".into();
    let text = paragraphs(&drives, &StudyParticipants::default(), &[]).join("\n");
    assert!(
        text.starts_with("1 drive was driven by a simulated driver (model follow); no person took part."),
        "{text}"
    );
    assert!(text.contains("The drive lasted 12 s. The seed was 10."), "{text}");
    assert!(!text.contains("confidence interval") && !text.contains("participants") && !text.contains("condition ("));
    drives[0].setup.manifest.driver = "keyboard".into();
    drives[0].setup.manifest.policy.name = "none".into();
    let text = paragraphs(&drives, &StudyParticipants::default(), &[]).join("\n");
    assert!(text.contains("the driver's controls were: keyboard.") && text.contains("No speed was advised."), "{text}");
    assert!(!text.contains("simulated driver") && !text.contains("acceptable range reached"), "{text}");
}

#[test]
fn the_methods_say_how_many_drives_were_seen_in_slow_motion() {
    let mut drives = made();
    let at = MEASURES.iter().position(|measure| measure.name == "dropped_s").unwrap();
    for drive in &mut drives {
        drive.setup.manifest.screen = Some(Default::default());
        drive.measures.values.resize(MEASURES.len(), None);
        drive.measures.values[at] = Some(0.01);
    }
    let message = |drives: &[AnalysedRecording]| paragraphs(drives, &StudyParticipants::default(), &[]).join("\n");
    assert!(!message(&drives).contains("in slow motion."));
    // 3 of 12 s.
    drives[1].measures.values[at] = Some(3.0);
    let text = message(&drives);
    assert!(
        text.contains(
            "In 1 of 4 drives, pictures came too late, and more than 1 % of the time was given up (25 % at the most)"
        ),
        "{text}"
    );
}

#[test]
fn the_methods_print_statements_and_the_speed_of_a_constant_policy() {
    let statements = crate::analysis::data::MethodsStatements {
        recruitment: Some("By posters.".into()),
        ethics: Some("The board\napproved it.".into()),
        apparatus: Some("A seat of a car.".into()),
    };
    let people = StudyParticipants { statements, ..StudyParticipants::default() };
    let mut drives = made();
    drives[0].setup.manifest.policy.name = "constant".into();
    drives[0].setup.scenario.policy_speed_mps = 3.5;
    let text = paragraphs(&drives, &people, &[]).join("\n");
    assert!(text.contains(" By posters. The board approved it.\n"), "{text}");
    assert!(text.contains("all vehicles at 10 Hz. A seat of a car.\n"), "{text}");
    assert!(text.contains("The policy constant advised one speed throughout a drive: 3.5 m/s."), "{text}");
    let without = paragraphs(&made(), &StudyParticipants::default(), &[]).join("\n");
    assert!(!without.contains("advised one speed"), "{without}");
}
