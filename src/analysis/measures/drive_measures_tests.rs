//! Measures against values computed by hand.

use super::*;
use crate::analysis::{
    data::{ChangeFinder, EgoSample, FrameTimes, IssuedAdvice, StepVehicle, TrafficStep},
    measures::totals::SteeringReversals,
    network::NetworkDriveTotals,
    responses::{OnsetFinder, ResponseWatch},
};
use crate::time::Tick;

/// Rows of a drive, as read from a recording.
struct Drive {
    ego: Vec<EgoSample>,
    steps: Vec<TrafficStep>,
    advice: Vec<IssuedAdvice>,
    trial: RecordedTrial,
}

impl Drive {
    /// Creates a drive of `n` ticks with two vehicles, the ego first.
    fn new(n: u64, speed: impl Fn(f64) -> f64, other: impl Fn(f64) -> f64) -> Self {
        let sample = |tick: u64| {
            let at_s = Tick(tick).seconds();
            let (speed_mps, mean_speed_mps) = (speed(at_s), (speed(at_s) + other(at_s)) / 2.0);
            EgoSample { tick, throttle: 0.1, speed_mps, mean_speed_mps, ..EgoSample::default() }
        };
        let step = |tick: u64| {
            let at_s = Tick(tick).seconds();
            let car = |id, s_m, speed_mps| StepVehicle { id, s_m: Some(s_m), speed_mps, lane: None };
            TrafficStep { tick, vehicles: vec![car(0, 10.0, speed(at_s)), car(1, 20.0, other(at_s))] }
        };
        Self {
            ego: (1..=n).map(sample).collect(),
            steps: (1..=n).filter(|tick| tick.is_multiple_of(10)).map(step).collect(),
            advice: Vec::new(),
            trial: RecordedTrial::default(),
        }
    }

    fn totals(&self) -> (DriveTotals, Vec<AdviceResponse>) {
        let mut finder = ChangeFinder::default();
        self.advice.iter().for_each(|advice| finder.add(advice).unwrap());
        let mut onsets = OnsetFinder::new(finder.changes);
        self.ego.iter().for_each(|row| onsets.add(row));
        let mut responses = ResponseWatch::new(0.1, onsets.finish(), None);
        let mut totals = DriveTotals::new(0.1).on(&self.trial);
        if self.trial.setup.roads().networks {
            totals = totals.on_network(NetworkDriveTotals::default());
        }
        for row in &self.ego {
            totals.add(row);
            responses.add(row);
        }
        self.steps.iter().for_each(|step| totals.add_step(step));
        totals.network.iter_mut().for_each(|network| network.finish(10));
        self.ego.iter().for_each(|row| totals.add_lane_offset(row.lane_offset_m));
        (totals, responses.finish())
    }

    fn measures(&self) -> DriveMeasures {
        self.measures_beside(None)
    }

    fn measures_beside(&self, baseline: Option<&Self>) -> DriveMeasures {
        let (totals, responses) = self.totals();
        let baseline = baseline.map(|baseline| baseline.totals().0);
        DriveMeasures::of(&self.trial, &totals, responses, &[], baseline.as_ref())
    }
}

fn get(measures: &DriveMeasures, name: &str) -> f64 {
    measures.get(name).unwrap_or_else(|| panic!("{name}"))
}

fn near(measures: &DriveMeasures, name: &str, wanted: f64) {
    let found = get(measures, name);
    assert!((found - wanted).abs() < 1e-9 * wanted.abs().max(1.0), "{name}: {found}, by hand {wanted}");
}

#[test]
fn mean_speed_and_its_gain_are_means_over_cars_and_ticks() {
    let with = Drive::new(1000, |_| 4.0, |_| 5.0);
    let without = Drive::new(1000, |_| 3.0, |_| 3.5);
    let found = with.measures_beside(Some(&without));
    near(&found, "mean_speed_mps", 4.5);
    near(&found, "baseline_speed_mps", 3.25);
    near(&found, "speed_gain_mps", 1.25);
    near(&found, "ego_mean_speed_mps", 4.0);
    // Two vehicles at 4 and 5 m/s: 0.5 m/s about their mean (N).
    assert!((get(&found, "speed_sd_over_vehicles_mps") - 0.5).abs() < 1e-6);
    let alone = with.measures();
    assert_eq!((alone.get("speed_gain_mps"), alone.get("fuel_saved_l_100km")), (None, None));
}

#[test]
fn fuel_of_a_cruise_is_that_of_each_model() {
    // Kamal et al. at 10 m/s: 0.1569 + 0.245 - 0.07415 + 0.05975 = 0.3875 ml/s, 0.03875 ml/m, 3.875 l / 100 km.
    let found = Drive::new(1000, |_| 10.0, |_| 10.0).measures();
    assert!((get(&found, "ego_fuel_l_100km") - 3.875).abs() < 1e-4, "{}", get(&found, "ego_fuel_l_100km"));
    assert!((get(&found, "fuel_l_100km") - 3.875).abs() < 1e-4);
    // SUMO's emissionsDrivingCycle at 10 m/s prints 582.51 mg/s: 0.78505 ml/s at 742 g/l.
    for name in ["ego_fuel_sumo_l_100km", "fuel_sumo_l_100km"] {
        assert!((get(&found, name) - 7.8505).abs() < 1e-3, "{name}: {}", get(&found, name));
    }
}

#[test]
fn range_and_error_count_only_where_there_is_advice() {
    let mut drive = Drive::new(1000, |_| 4.0, |_| 4.0);
    for i in 200..1000 {
        // 600 ticks at an error of -0.5, 200 at +1.
        let target = if i < 800 { 4.5 } else { 3.0 };
        drive.ego[i].target_mps = Some(target);
        drive.ego[i].in_range = Some(i < 800);
    }
    let found = drive.measures();
    near(&found, "time_in_range", 0.75);
    near(&found, "speed_error_mps", (600.0 * 0.5 + 200.0) / 800.0);
    near(&found, "speed_bias_mps", (-600.0 * 0.5 + 200.0) / 800.0);
    assert_eq!(Drive::new(100, |_| 4.0, |_| 4.0).measures().get("time_in_range"), None);
}

#[test]
fn minima_are_over_ticks_in_the_leaders_lane() {
    let mut drive = Drive::new(100, |_| 4.0, |_| 4.0);
    drive.ego[3].gap_m = Some(4.0);
    drive.ego[50].gap_m = Some(2.5);
    drive.ego[50].headway_m = Some(7.5);
    drive.ego[7].ttc_s = Some(9.0);
    drive.ego[8].ttc_s = Some(3.25);
    // Outside its lane the ego passes the leader: there is no gap between them.
    drive.ego[60].gap_m = Some(-5.0);
    drive.ego[60].headway_m = Some(0.0);
    drive.ego[60].ttc_s = Some(0.1);
    drive.ego[60].lane_offset_m = -1.9;
    let found = drive.measures();
    near(&found, "min_gap_m", 2.5);
    near(&found, "min_headway_m", 7.5);
    near(&found, "min_ttc_s", 3.25);
}

#[test]
fn a_time_headway_is_headway_over_own_speed_where_the_ego_moves() {
    let mut drive = Drive::new(100, |t| if t < 0.5 { 4.0 } else { 0.5 }, |_| 4.0);
    assert_eq!(drive.measures().get("time_headway_s"), None);
    for (row, headway_m) in [(3, 8.0), (7, 12.0), (80, 6.0)] {
        drive.ego[row].headway_m = Some(headway_m);
    }
    let found = drive.measures();
    assert!(drive.ego[3].speed_mps == 4.0 && drive.ego[80].speed_mps == 0.5, "the third is nearly at a standstill");
    near(&found, "time_headway_s", 2.5);
    near(&found, "min_time_headway_s", 2.0);
}

#[test]
fn time_gap_ends_at_the_rear_bumper_and_drac_is_v_squared_over_two_gaps() {
    let mut drive = Drive::new(100, |t| if t < 0.5 { 4.0 } else { 0.5 }, |_| 4.0);
    assert_eq!((drive.measures().get("time_gap_s"), drive.measures().get("max_drac_mps2")), (None, None));
    for (row, gap_m) in [(3, 6.0), (7, 10.0), (80, 1.0)] {
        drive.ego[row].gap_m = Some(gap_m);
    }
    near(&drive.measures(), "max_drac_mps2", 0.0);
    // Closing at 3 m/s over 6 m and at 2 m/s over 10 m: 9 / 12 and 4 / 20.
    (drive.ego[3].ttc_s, drive.ego[7].ttc_s) = (Some(2.0), Some(5.0));
    let found = drive.measures();
    near(&found, "time_gap_s", 2.0);
    near(&found, "min_time_gap_s", 1.5);
    near(&found, "max_drac_mps2", 0.75);
}

#[test]
fn spread_over_time_stops_and_hard_brakings_match_a_hand_count() {
    // The ego: 6 m/s, from 5 s on braking with 4 m/s2 to a stop at 6.5 s, from 8 s on 6 m/s again. The other: 2 m/s throughout.
    let ego = |t: f64| {
        if t < 5.0 {
            6.0
        } else if t < 8.0 {
            (6.0 - 4.0 * (t - 5.0)).max(0.0)
        } else {
            6.0
        }
    };
    let found = Drive::new(1000, ego, |_| 2.0).measures();
    near(&found, "ego_stops", 1.0);
    near(&found, "stops", 0.5);
    near(&found, "ego_hard_brakings", 1.0);
    near(&found, "hard_brakings", 0.5);
    // Stopped in the steps from 6.5 s to 7.9 s, braking in those from 5.1 s to 6.5 s.
    assert!((get(&found, "ego_stopped_s") - 1.5).abs() < 1e-9 && (get(&found, "stopped_s") - 0.75).abs() < 1e-9);
    assert!((get(&found, "ego_hard_braking_s") - 1.5).abs() < 1e-9, "{}", get(&found, "ego_hard_braking_s"));
    // Half the time at 2 and half at 6 m/s: 2 m/s about 4 (N); the other vehicle has none.
    let found = Drive::new(1000, |t| if t <= 5.0 { 2.0 } else { 6.0 }, |_| 2.0).measures();
    assert!(
        (get(&found, "ego_speed_sd_over_time_mps") - 2.0).abs() < 1e-6
            && (get(&found, "speed_sd_over_time_mps") - 1.0).abs() < 1e-6
    );
}

#[test]
fn network_time_gaps_are_of_followers_and_ring_measures_are_absent() {
    let mut drive = Drive::new(1000, |_| 10.0, |_| 10.0);
    for (i, row) in drive.ego.iter_mut().enumerate() {
        // Half of the time 2 s behind the leader, otherwise 60 s, which is not following; beside the lane of the path from 9 s
        // on.
        row.gap_m = Some(if i % 2 == 0 { 20.0 } else { 600.0 });
        row.lane_offset_m = if i >= 900 { 30.0 } else { 0.1 * f64::from(u8::try_from(i % 2).unwrap()) };
    }
    let ring = drive.measures();
    near(&ring, "time_gap_s", 31.0);
    drive.trial.setup.scenario.path = "A0B0".into();
    let found = drive.measures();
    near(&found, "time_gap_s", 2.0);
    // 450 times 0 and 450 times 0.1: 0.05 about their mean, N-1; the 30 m beside the path are not a lane position.
    near(&found, "sdlp_m", 0.05 * (900.0_f64 / 899.0).sqrt());
    assert!(get(&ring, "sdlp_m") > 5.0);
    for name in
        ["speed_sd_over_vehicles_mps", "speed_sd_over_time_mps", "fuel_l_100km", "hard_brakings", "last_disturbance_s"]
    {
        assert!(ring.get(name).is_some() && found.get(name).is_none(), "{name}");
    }
    // Two vehicles, evaluated each full second. A ring has no events of traffic rules.
    assert_eq!((get(&found, "stops"), get(&found, "space_mean_speed_mps"), get(&found, "vehicles")), (0.0, 10.0, 2.0));
    assert_eq!((found.get("red_lights"), ring.get("red_lights")), (Some(0.0), None));
}

#[test]
fn throughput_counts_vehicles_past_the_start_less_those_that_go_back() {
    let mut drive = Drive::new(6000, |_| 4.0, |_| 4.0);
    assert_eq!(drive.measures().get("passages_per_h"), None, "no route is known");
    drive.trial.setup.route_m = 100.0;
    // 60 s at 10 m/s from 0.5 m: six rounds of 100 m; the other vehicle goes back over the start once.
    for (k, step) in drive.steps.iter_mut().enumerate() {
        step.vehicles[0].s_m = Some((0.5 + k as f64) % 100.0);
        step.vehicles[1].s_m = Some(if k < 300 { 1.0 } else { 99.0 });
    }
    // 599.5 m are five whole rounds and most of the sixth: 5 - 1 in a minute.
    near(&drive.measures(), "passages_per_h", 4.0 * 60.0);
}

#[test]
fn pedal_reversals_are_of_five_percent_and_more() {
    let mut drive = Drive::new(6000, |_| 4.0, |_| 4.0);
    // A wave of +-3 % and 4 s on accelerator and brake turns at 1, 3, ... 59 s; the way to the first and from the last is 3 %.
    for row in &mut drive.ego {
        let pedals = 0.03 * (std::f64::consts::PI / 2.0 * Tick(row.tick).seconds()).sin();
        (row.throttle, row.brake) = (pedals.max(0.0), (-pedals).max(0.0));
    }
    near(&drive.measures(), "pedal_reversals_per_min", 28.0);
    drive.ego.iter_mut().for_each(|row| (row.throttle, row.brake) = (row.throttle * 0.8, row.brake * 0.8));
    near(&drive.measures(), "pedal_reversals_per_min", 0.0);
}

#[test]
fn time_in_range_counts_as_the_drivers_except_after_a_collision() {
    let mut drive = Drive::new(1000, |_| 4.0, |_| 4.0);
    for (i, row) in drive.ego.iter_mut().enumerate() {
        row.in_range = Some(i < 600);
    }
    // Contacts at 3 s and 4 s count to 6 s: 300 of the 600 ticks in range. At the contact at 9 s the speed is out of range.
    [300, 400, 900].into_iter().for_each(|tick| drive.trial.collided(tick));
    assert_eq!(drive.trial.after_contacts, [[300, 600], [900, 1100]]);
    let found = drive.measures();
    near(&found, "time_in_range", 0.6);
    near(&found, "time_in_range_by_driver", 0.3);
    near(&found, "time_in_range_by_collision", 0.3);
}

#[test]
fn sdlp_is_a_sample_standard_deviation() {
    let mut drive = Drive::new(4, |_| 4.0, |_| 4.0);
    for (row, offset_m) in drive.ego.iter_mut().zip([0.1, 0.2, 0.3, 0.4]) {
        row.lane_offset_m = offset_m;
    }
    // Squares about 0.25: 2 (0.15^2 + 0.05^2) = 0.05, over N-1 = 3.
    near(&drive.measures(), "sdlp_m", (0.05f64 / 3.0).sqrt());
}

#[test]
fn reversals_below_the_gap_size_do_not_count() {
    let count = |angles: &[f64]| {
        let mut reversals = SteeringReversals::new(3.0);
        angles.iter().for_each(|angle| reversals.add(*angle));
        reversals.count
    };
    assert_eq!(count(&[0.0, 5.0, 0.0, 5.0, 0.0]), 3);
    assert_eq!(count(&[0.0, 2.9, 0.0, 2.9, 0.0]), 0);
    // Small turns on the way do not count, nor does a slow drift that never turns back.
    assert_eq!(count(&[0.0, 4.0, 2.0, 8.0, 6.0, 12.0, 8.0]), 1);
    assert_eq!(count(&[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]), 0);
    assert_eq!(count(&[0.0, -1.5, 1.5, -1.5, 1.5]), 2);
    // A sine of 4 degrees and 2 s for 60 s: a turning point at every odd half second.
    let mut drive = Drive::new(6000, |_| 4.0, |_| 4.0);
    for row in &mut drive.ego {
        row.wheel_rad = (4.0 * (std::f64::consts::PI * Tick(row.tick).seconds()).sin()).to_radians();
    }
    near(&drive.measures(), "reversals_per_min", 60.0);
}

#[test]
fn jerk_is_between_means_of_steps() {
    let mut drive = Drive::new(100, |_| 4.0, |_| 4.0);
    // Acceleration grows by 0.02 m/s2 a step and trembles within a step, which its mean leaves out.
    for (i, row) in drive.ego.iter_mut().enumerate() {
        row.accel_mps2 = 0.02 * (i / 10) as f64 + if i % 2 == 0 { 1.0 } else { -1.0 };
    }
    near(&drive.measures(), "rms_jerk_mps3", 0.2);
}

#[test]
fn medians_of_responses_are_in_the_measures() {
    let mut drive = Drive::new(3000, |_| 4.0, |_| 4.0);
    drive.advice.push(IssuedAdvice { seen_tick: 1, target_mps: 4.0, range_mps: [3.8, 4.2] });
    for (k, (tick, reaction)) in [(500u64, 70usize), (1000, 90), (1500, 110)].into_iter().enumerate() {
        let target_mps = 5.0 + k as f64;
        let range_mps = [target_mps - 0.2, target_mps + 0.2];
        drive.advice.push(IssuedAdvice { seen_tick: tick, target_mps, range_mps });
        for row in &mut drive.ego[tick as usize - 1 + reaction..] {
            row.throttle += 0.1;
        }
    }
    let found = drive.measures();
    near(&found, "changes", 3.0);
    // The range of 5 is the first that excludes the speed of 4; 6 and 7 have the same demand.
    near(&found, "requests", 1.0);
    near(&found, "responded", 1.0);
    assert_eq!(
        (found.get("reaction_s"), found.get("enter_range_s")),
        (None, None),
        "of one request no distribution is told"
    );
}

#[test]
fn every_measure_has_a_name_with_its_unit_and_a_definition() {
    let mut names: Vec<&str> = MEASURES.iter().map(|m| m.name).collect();
    for measure in MEASURES {
        let ending = match measure.unit {
            "m/s" => "_mps",
            "m/s3" => "_mps3",
            "s" => "_s",
            "m" => "_m",
            "steps" => "_steps",
            "m/s2" => "_mps2",
            "1/min" => "_per_min",
            "1/h" => "_per_h",
            "l/100 km" => "_l_100km",
            _ => "",
        };
        assert!(measure.name.ends_with(ending) && measure.about.len() > 15, "{}", measure.name);
    }
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), MEASURES.len());
}

#[test]
fn latency_is_median_and_nearest_rank_of_the_frames_that_have_one() {
    let of = |latencies_s: Vec<f64>| {
        let frames = FrameTimes { latencies_s, ..FrameTimes::default() };
        let trial = RecordedTrial { frames, ..RecordedTrial::default() };
        DriveMeasures::of(&trial, &DriveTotals::new(0.1), Vec::new(), &[], None)
    };
    let measured = of((1..=200).map(|ms| f64::from(ms) / 1e3).collect());
    assert!((measured.get("latency_median_s").unwrap() - 0.1005).abs() < 1e-12);
    assert_eq!(measured.get("latency_p99_s"), Some(0.198));
    assert_eq!(of(vec![0.03]).get("latency_p99_s"), Some(0.03));
    assert_eq!(of(Vec::new()).get("latency_p99_s"), None, "a keyboard tells no times");
}

#[test]
fn measures_of_events_are_means_over_the_events_that_have_a_value() {
    let event = |brake_s: Option<f64>, could_brake: bool, min_ttc_s: Option<f64>, contact_mps: Option<f64>| {
        let release_s = brake_s.map(|brake_s| brake_s - 0.5);
        let max_decel_mps2 = if could_brake { 6.0 } else { 3.0 };
        ScriptedResponse {
            release_s,
            brake_s,
            could_brake,
            min_ttc_s,
            contact_mps,
            max_decel_mps2,
            ..Default::default()
        }
    };
    let events = [
        event(Some(1.0), true, Some(2.0), None),
        event(None, true, None, Some(3.0)),
        event(Some(2.0), true, Some(1.0), None),
        event(None, false, None, None),
    ];
    let of = |events: &[ScriptedResponse]| {
        let measured = DriveMeasures::of(&RecordedTrial::default(), &DriveTotals::new(0.1), Vec::new(), events, None);
        ["count", "response_s", "brake_s", "brake_share", "steering_s", "min_ttc_s", "max_decel_mps2", "contact_share"]
            .map(|name| measured.get(&format!("event_{name}")))
    };
    // Two of the three that could brake; brakes after 1.0 and 2.0 s; 3 times 6 and once 3 m/s².
    let by_hand = [Some(4.0), Some(1.0), Some(1.5), Some(2.0 / 3.0), None, Some(1.5), Some(5.25), Some(0.25)];
    assert_eq!(of(&events), by_hand);
    assert_eq!(of(&[]), [None; 8], "a drive without events");
}

#[test]
fn a_second_is_a_hundred_ticks_and_a_rest_is_dropped() {
    let mut drive = Drive::new(250, |_| 9.0, |_| 9.0);
    for (i, row) in drive.ego.iter_mut().enumerate().take(200) {
        row.mean_speed_mps = if i < 100 { 1.0 } else { 3.0 };
    }
    assert_eq!(drive.totals().0.per_second_mps, [1.0, 3.0]);
    assert!(Drive::new(99, |_| 1.0, |_| 1.0).totals().0.per_second_mps.is_empty());
}

#[test]
fn space_mean_speed_is_distance_over_time_at_full_seconds() {
    let step = |tick: u64, vehicles: &[(u32, f64)]| {
        let vehicle =
            |(id, speed_mps): &(u32, f64)| StepVehicle { id: *id, s_m: None, speed_mps: *speed_mps, lane: None };
        TrafficStep { tick, vehicles: vehicles.iter().map(vehicle).collect() }
    };
    let mut totals = DriveTotals::new(0.1).on_network(NetworkDriveTotals::default());
    assert_eq!(totals.traffic.space_mean_speed_mps(), None);
    totals.add_step(&step(100, &[(0, 10.0), (4, 0.0)]));
    // Between full seconds only vehicles near the ego have rows; they do not count here.
    totals.add_step(&step(110, &[(0, 30.0)]));
    totals.add_step(&step(200, &[(0, 4.0)]));
    assert_eq!(totals.traffic.space_mean_speed_mps(), Some(14.0 / 3.0));
}

#[test]
fn a_wave_round_a_ring_has_its_speed_and_an_even_ring_has_none() {
    // Ten vehicles at the same places: a sine wave against the direction of travel at 4 m/s on 100 m.
    let step = |tick: u64, amplitude_mps: f64| {
        let at_s = Tick(tick).seconds();
        let car = |id: u32| {
            let s_m = f64::from(id) * 10.0;
            let phase = std::f64::consts::TAU * (s_m + 4.0 * at_s) / 100.0;
            StepVehicle { id, s_m: Some(s_m), speed_mps: 5.0 + amplitude_mps * phase.sin(), lane: None }
        };
        TrafficStep { tick, vehicles: (0..10).map(car).collect() }
    };
    let measures = |amplitude_mps: f64| {
        let mut drive = Drive::new(10, |_| 5.0, |_| 5.0);
        drive.trial.setup.route_m = 100.0;
        drive.steps = (1..=1200).map(|i| step(10 * i, amplitude_mps)).collect();
        drive.measures()
    };
    let wave = measures(1.0);
    near(&wave, "wave_speed_mps", -4.0);
    assert!(get(&wave, "wave_share") > 0.99 && get(&wave, "speed_sd_growth_per_min").abs() < 0.01);
    // Each vehicle repeats its leader's speed 2.5 s later, at 0.04 Hz.
    assert!((get(&wave, "gain_at_0_03_hz") - 1.0).abs() < 0.01);
    let even = measures(0.0);
    assert_eq!((even.get("wave_speed_mps"), even.get("gain_at_0_03_hz")), (None, None));
}
