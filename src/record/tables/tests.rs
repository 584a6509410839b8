//! Tests of every column of a row against values set by hand.

use super::*;
use crate::{
    controls::{Controls, Indicator, Selector, TaskButton},
    ego::EgoState,
    map::network::{LanePosition, Network},
    metrics::{AutomationChange, QuestionChange, SwitchedOffBy, TaskResponse, TaskStimulus},
    policy::{Action, Advice, DriverEstimate, DriverTraits, ObservedDriver},
    roadside::fixed_objects::FixedObjectKind,
    scenario::Scenario,
    sim::{EndReason, Event, EventKind, EventStage, Leader, NotDone, Snapshot, VehicleSnapshot},
    snapshot::{AutomationMode, AutomationState},
    space::Pose,
    traffic::{VehicleId, VehicleKind},
};
use glam::{DVec3, Quat, dvec2};
use std::{collections::BTreeMap, f64::consts::PI};

/// Returns a table's row as text, by column name; numbers to six digits, empty as `-`.
fn cells<R>(columns: &[TableColumn<R>], row: &R) -> BTreeMap<&'static str, String> {
    let text = |column: &TableColumn<R>| match column.get {
        ColumnValue::Number(get) => get(row).map_or("-".into(), |v| format!("{:.6}", v)),
        ColumnValue::Whole(get) => get(row).to_string(),
        ColumnValue::Id(get) => get(row).map_or("-".into(), |v| v.to_string()),
        ColumnValue::Flag(get) => get(row).map_or("-".into(), |v| v.to_string()),
        ColumnValue::Word(get) => get(row),
    };
    columns.iter().map(|column| (column.name, text(column))).collect()
}

fn is<R>(columns: &[TableColumn<R>], row: &R, expected: &[(&'static str, &str)]) {
    let (found, expected) = (cells(columns, row), expected.iter().copied().collect::<BTreeMap<_, _>>());
    assert_eq!(found.keys().collect::<Vec<_>>(), expected.keys().collect::<Vec<_>>());
    for (name, value) in expected {
        assert_eq!(found[name], value, "{name}");
    }
}

const ADVISED: Advice = Advice {
    issued: Tick(100),
    hold: crate::policy::Hold::of_steps(30, 0.1),
    action: Action::Acceleration(-0.5),
    target_mps: 6.5,
    range_mps: 0.75,
    is_fallback: true,
    driver: Some(DriverEstimate {
        mean: DriverTraits {
            reaction_s: 1.5,
            speed_bias_mps: -0.25,
            error_mps: 0.5,
            time_gap_factor: 1.25,
            willingness: 0.75,
        },
        sd: DriverTraits {
            reaction_s: 0.125,
            speed_bias_mps: 0.25,
            error_mps: 0.375,
            time_gap_factor: 0.0625,
            willingness: 0.5,
        },
    }),
    observed: Some(ObservedDriver { deviation_mps: -0.125, reaction_s: 0.875, time_gap_factor: 1.125 }),
};

/// Snapshot of the ego at 6 m/s, 10 m behind a vehicle at 4 m/s; 0.5 rad left of east, nose 0.1 rad down, right side 0.2 rad
/// up.
fn snapshot() -> Snapshot {
    let ego = EgoState {
        position: DVec3::new(3.0, -4.0, 0.25),
        rotation: Quat::from_rotation_z(0.5) * Quat::from_rotation_y(0.1) * Quat::from_rotation_x(-0.2),
        speed_mps: 6.0,
        accel_mps2: 1.5,
        lateral_accel_mps2: -0.75,
        yaw_rate: 0.125,
        gear: 2,
        engine_rpm: 1800.0,
        steering_torque_nm: -3.5,
        braking: true,
        ..EgoState::default()
    };
    Snapshot {
        tick: Tick(123),
        ego,
        ego_before: EgoState { accel_mps2: 1.25, ..ego },
        ego_s_m: 77.5,
        lane_offset_m: -0.5,
        leader: Some(Leader { id: VehicleId(7), gap_m: 10.0, speed_mps: 4.0 }),
        advice: Some(ADVISED),
        mean_speed_mps: 3.25,
        automation: AutomationState {
            mode: AutomationMode::TakeoverRequest,
            time_gap_s: Some(1.5),
            driven: Some(Controls { throttle: 0.125, steering_wheel_rad: 0.5, ..Controls::default() }),
            ..AutomationState::default()
        },
        ..Snapshot::default()
    }
}

const CONTROLS: Controls = Controls {
    throttle: 0.25,
    brake: 0.5,
    steering_wheel_rad: -1.5,
    selector: Selector::Neutral,
    indicator: Indicator::Right,
    main_beam: true,
    task_button: TaskButton::Left,
    automation_button: true,
    gap_button: true,
    hand_torque_nm: Some(-0.75),
};

#[test]
fn a_row_of_the_ego_has_the_values_of_its_snapshot() {
    let row = EgoRow::of(&snapshot(), &CONTROLS, Some(2.0), 99);
    let expected = [
        ("tick", "123"),
        ("time_s", "1.230000"),
        ("hash", "99"),
        ("throttle", "0.250000"),
        ("brake", "0.500000"),
        ("steering_wheel_rad", "-1.500000"),
        ("selector", "neutral"),
        ("indicator", "right"),
        ("task_button", "left"),
        ("automation_button", "true"),
        ("gap_button", "true"),
        ("hand_torque_nm", "-0.750000"),
        ("automation", "takeover_request"),
        ("automation_gap_s", "1.500000"),
        ("driven_throttle", "0.125000"),
        ("driven_brake", "0.000000"),
        ("driven_wheel_rad", "0.500000"),
        ("main_beam", "true"),
        ("x_m", "3.000000"),
        ("y_m", "-4.000000"),
        ("z_m", "0.250000"),
        ("speed_mps", "6.000000"),
        ("accel_mps2", "1.500000"),
        ("lateral_accel_mps2", "-0.750000"),
        // 0.25 m/s2 more than 10 ms before.
        ("jerk_mps3", "25.000000"),
        ("yaw_rate_radps", "0.125000"),
        ("gear", "2.000000"),
        ("engine_rpm", "1800.000000"),
        ("steering_torque_nm", "-3.500000"),
        ("braking", "true"),
        ("s_m", "77.500000"),
        ("lane_offset_m", "-0.500000"),
        ("leader", "7"),
        ("gap_m", "10.000000"),
        // A vehicle is 5 m long.
        ("headway_m", "15.000000"),
        ("leader_speed_mps", "4.000000"),
        // 10 m at 2 m/s.
        ("ttc_s", "5.000000"),
        ("target_mps", "6.500000"),
        ("range_low_mps", "5.750000"),
        ("range_high_mps", "7.250000"),
        ("in_range", "true"),
        ("mean_speed_mps", "3.250000"),
        ("wheel_force_nm", "2.000000"),
    ];
    let found = cells(EGO, &row);
    let angle = |name: &str| found[name].parse::<f64>().expect("a number");
    for (name, rad) in [("yaw_rad", 0.5), ("pitch_rad", 0.1), ("roll_rad", -0.2)] {
        assert!((angle(name) - rad).abs() < 1e-6, "{name}: {}", found[name]);
    }
    for (name, value) in expected {
        assert_eq!(found[name], value, "{name}");
    }
    // Only the three angles are missing from the list above.
    assert_eq!(found.len(), expected.len() + 3);
}

#[test]
fn no_time_to_collision_without_a_closing_gap_and_no_cells_without_values() {
    for leader_mps in [6.0, 7.0] {
        let leader = Some(Leader { id: VehicleId(7), gap_m: 10.0, speed_mps: leader_mps });
        let row = EgoRow::of(&Snapshot { leader, ..snapshot() }, &CONTROLS, None, 0);
        assert_eq!(cells(EGO, &row)["ttc_s"], "-", "leader at {leader_mps} m/s");
    }
    let alone = EgoRow::of(&Snapshot { leader: None, advice: None, ..snapshot() }, &CONTROLS, None, 0);
    let empty = cells(EGO, &alone).into_iter().filter(|(_, text)| text == "-").map(|(name, _)| name);
    let expected = [
        "gap_m",
        "headway_m",
        "in_range",
        "leader",
        "leader_speed_mps",
        "range_high_mps",
        "range_low_mps",
        "target_mps",
        "ttc_s",
        "wheel_force_nm",
    ];
    assert_eq!(empty.collect::<Vec<_>>(), expected);
}

#[test]
fn rows_of_cars_advice_and_events_have_their_values() {
    let ego = [
        ("tick", "123"),
        ("car", "0"),
        ("s_m", "77.500000"),
        ("x_m", "3.000000"),
        ("y_m", "-4.000000"),
        ("yaw_rad", "0.500000"),
        ("speed_mps", "6.000000"),
        ("accel_mps2", "1.500000"),
        ("braking", "true"),
        ("lane", ""),
        ("lane_s_m", "-"),
        ("lane_offset_m", "-"),
    ];
    is(CARS, &CarRow::ego(&snapshot(), &Network::default()).expect("a participant"), &ego);
    let pose = Pose::new(dvec2(8.0, 9.0), -0.25);
    let network = Network::load("tests/data/networks/grid-signals.net.xml").unwrap();
    let lane = network.lane_named("B0C0_1").map(|lane| LanePosition { lane, s_m: 3.5, offset_m: -0.25 });
    let view = VehicleSnapshot {
        id: VehicleId(4),
        lane,
        pose,
        pose_before: Pose::new(dvec2(7.0, 9.5), -0.5),
        s_m: Some(12.5),
        speed_mps: 2.5,
        accel_mps2: -1.0,
        odometer_m: 60.0,
        ..VehicleSnapshot::default()
    };
    let car = [
        ("tick", "120"),
        ("car", "4"),
        ("s_m", "12.500000"),
        ("x_m", "8.000000"),
        ("y_m", "9.000000"),
        ("yaw_rad", "-0.250000"),
        ("speed_mps", "2.500000"),
        ("accel_mps2", "-1.000000"),
        ("braking", "false"),
        ("lane", "B0C0_1"),
        ("lane_s_m", "3.500000"),
        ("lane_offset_m", "-0.250000"),
    ];
    is(CARS, &CarRow::of(Tick(120), &view, &network), &car);

    let advice = AdviceRow { advice: ADVISED, speed_mps: 5.5, shown_frame: Some(8), shown_wall_s: Some(1.125) };
    let expected = [
        ("tick", "100"),
        ("action", "acceleration"),
        ("action_value", "-0.500000"),
        ("target_mps", "6.500000"),
        ("range_low_mps", "5.750000"),
        ("range_high_mps", "7.250000"),
        ("hold_s", "3.000000"),
        ("speed_mps", "5.500000"),
        ("in_range", "false"),
        ("fallback", "true"),
        ("shown_frame", "8"),
        ("shown_wall_s", "1.125000"),
        ("driver_reaction_s", "1.500000"),
        ("driver_reaction_sd_s", "0.125000"),
        ("driver_speed_bias_mps", "-0.250000"),
        ("driver_speed_bias_sd_mps", "0.250000"),
        ("driver_error_mps", "0.500000"),
        ("driver_error_sd_mps", "0.375000"),
        ("driver_time_gap_factor", "1.250000"),
        ("driver_time_gap_factor_sd", "0.062500"),
        ("driver_willingness", "0.750000"),
        ("driver_willingness_sd", "0.500000"),
        ("observed_deviation_mps", "-0.125000"),
        ("observed_reaction_s", "0.875000"),
        ("observed_time_gap_factor", "1.125000"),
    ];
    is(ADVICE, &advice, &expected);

    let brakes = "[[event]]\nname = \"brakes\"\ntrigger = { time_s = 1 }\nactions = [{ brake = { vehicle = \"leader\", decel_mps2 = 4 } }]\n";
    let scripted = Scenario::from_toml(brakes, "x").expect("a scenario").events;
    let at = |kind| EventRow::of(&Event { tick: Tick(5), kind }, &scripted);
    assert!(at(EventKind::Advice(ADVISED)).is_none(), "advice has its own table");
    let contact = EventKind::Contact {
        car: VehicleId(3),
        kind: VehicleKind::Car,
        ego_speed_mps: 9.0,
        car_speed_mps: 2.0,
        closing_mps: 7.0,
        angle_rad: -PI / 2.0,
    };
    for (kind, expected) in [
        (contact, ["contact", "ego at 9.000 m/s, car at 2.000 m/s", "3", "7.000000"]),
        (
            EventKind::ObjectContact { object: FixedObjectKind::GuardRail, ego_speed_mps: 9.0, closing_mps: 7.0 },
            ["object_contact", "guard rail, ego at 9.000 m/s", "-", "7.000000"],
        ),
        (
            EventKind::LeftRoad { s_m: 31.25, offset_m: -2.0 },
            ["left_road", "at 31.25 m of the route", "-", "-2.000000"],
        ),
        (EventKind::BackOnRoad, ["back_on_road", "", "-", "-"]),
        (EventKind::LeftPath { s_m: 31.25 }, ["left_path", "at 31.25 m of the route", "-", "-"]),
        (EventKind::BackOnPath { s_m: 80.5 }, ["back_on_path", "at 80.50 m of the route", "-", "-"]),
        (EventKind::Indicator(Indicator::Left), ["indicator", "left", "-", "-"]),
        (EventKind::MainBeam(true), ["main_beam", "on", "-", "-"]),
        (EventKind::TaskStimulus(TaskStimulus::Signal), ["task_stimulus", "signal", "-", "-"]),
        (
            EventKind::TaskStimulus(TaskStimulus::Digit { digit: 7, is_match: Some(true) }),
            ["task_stimulus", "match", "-", "7.000000"],
        ),
        (EventKind::TaskResponse(TaskResponse::Column(3)), ["task_response", "column", "-", "3.000000"]),
        (EventKind::Question { event: 0, change: QuestionChange::Asked }, ["question_asked", "brakes", "-", "-"]),
        (
            EventKind::Question { event: 0, change: QuestionChange::Answered { answer: 1, is_right: Some(false) } },
            ["question_answered", "wrong", "-", "2.000000"],
        ),
        (EventKind::Shutter(true), ["shutter", "open", "-", "-"]),
        (EventKind::Shutter(false), ["shutter", "closed", "-", "-"]),
        (EventKind::Automation(AutomationChange::Request { lead_s: 7.0 }), ["takeover_request", "", "-", "7.000000"]),
        (EventKind::Automation(AutomationChange::Off(SwitchedOffBy::Brake)), ["automation_off", "brake", "-", "-"]),
        (EventKind::PutBack { s_m: 12.5 }, ["put_back", "at 12.50 m of the route", "-", "-"]),
        (
            EventKind::Scripted { event: 0, vehicle: Some(VehicleId(3)), stage: EventStage::Onset },
            ["event_onset", "brakes", "3", "-"],
        ),
        (
            EventKind::Scripted { event: 0, vehicle: None, stage: EventStage::NotDone(NotDone::NoVehicle) },
            ["event_not_done", "brakes: no such vehicle", "-", "-"],
        ),
        (EventKind::Ended(EndReason::Duration), ["ended", "duration", "-", "-"]),
    ] {
        let [event, detail, car, value] = expected;
        let row = at(kind).expect("a row");
        // The other vehicle heads 90 degrees to the right of the ego's heading.
        let angle = if event == "contact" { "-90.000000" } else { "-" };
        let expected = [("tick", "5"), ("event", event), ("detail", detail), ("car", car), ("value", value)];
        is(EVENTS, &row, &[&expected[..], &[("angle_deg", angle)]].concat());
    }
}

/// Returns the rows of a table's columns for the page.
fn documented(schema: &Schema) -> String {
    let row = |field: &arrow_schema::FieldRef| {
        let fact = |name: &str| field.metadata().get(name).map_or("", String::as_str).replace('|', "\\|");
        let kind = match field.data_type() {
            arrow_schema::DataType::Float64 => "number",
            arrow_schema::DataType::Boolean => "true, false",
            arrow_schema::DataType::Utf8 => "text",
            _ => "whole",
        };
        format!("| `{}` | {} | {kind} | {} |\n", field.name(), fact("unit"), fact("description"))
    };
    schema.fields().iter().map(row).collect()
}

#[test]
fn the_page_of_tables_is_what_recordings_have() {
    let mut page = "# Tables of a recording\n\n**Goal:** look up each column of the tables that a drive writes, with unit and meaning.\n\n\
        A table is a Parquet file in the folder of the recording; each column has unit and meaning in its metadata. [Recordings](../commands.md#tables-of-a-recording) \
        says which tables a drive has. An empty cell means that there was nothing to measure. Positions are in the axes of the world: x east, y north, z up.\n"
        .to_owned();
    for table in Table::ALL {
        let rows = documented(&schema(table));
        page += &format!(
            "\n## `{}.parquet`\n\n| column | unit | values | meaning |\n|---|---|---|---|\n{rows}",
            table.name()
        );
    }
    expect_test::expect_file!["../../../docs/reference/recording-tables.md"].assert_eq(&page);
}
