//! Table of the ego. In: the state of the loop at a tick. Out: one row for each tick. SI units; positions in world axes (x east, y
//! north).

use crate::{
    controls::{Controls, Selector},
    ego::EgoState,
    policy::Advice,
    record::table::{ColumnValue, TableColumn, column, number},
    sim::Snapshot,
    snapshot::AutomationState,
    space::CAR_LENGTH_M,
    time::{TICK_S, Tick},
};
use glam::EulerRot;

/// Ego at a tick, with the controls that led to it.
#[derive(Clone, Copy, Debug)]
pub struct EgoRow {
    /// Tick of the row.
    pub tick: Tick,
    /// Hash chain over all snapshots up to this one.
    pub hash: u64,
    /// Controls that the driver gave in this tick.
    pub controls: Controls,
    /// State of the ego; `None` without a participant.
    pub ego: Option<EgoState>,
    /// Acceleration one tick before, m/s2.
    pub accel_before_mps2: f64,
    /// Front bumper along the route, metres.
    pub s_m: f64,
    /// Offset from the lane's centre line, metres, positive to the left.
    pub lane_offset_m: f64,
    /// Vehicle ahead: number, gap in metres, speed in m/s.
    pub leader: Option<(u32, f64, f64)>,
    /// Time to collision with it, s.
    pub ttc_s: Option<f64>,
    /// Automation of the ego.
    pub automation: AutomationState,
    /// Advice shown on the speedometer.
    pub advice: Option<Advice>,
    /// Mean speed of all vehicles, m/s.
    pub mean_speed_mps: f64,
    /// Mean torque sent to the wheel's motor since the frame before, N m, positive to the left; `None` without force
    /// feedback.
    pub wheel_force_nm: Option<f64>,
}

impl EgoRow {
    /// Returns the row of a snapshot; `wheel_force_nm` is the mean torque sent to the wheel's motor.
    pub fn of(snapshot: &Snapshot, controls: &Controls, wheel_force_nm: Option<f64>, hash: u64) -> Self {
        Self {
            tick: snapshot.tick,
            hash,
            controls: *controls,
            ego: (!snapshot.is_without_ego).then_some(snapshot.ego),
            accel_before_mps2: snapshot.ego_before.accel_mps2,
            s_m: snapshot.ego_s_m,
            lane_offset_m: snapshot.lane_offset_m,
            leader: snapshot.leader.map(|l| (l.id.0, l.gap_m, l.speed_mps)),
            ttc_s: snapshot.ttc_s().filter(|_| !snapshot.is_without_ego),
            automation: snapshot.automation,
            advice: snapshot.advice,
            mean_speed_mps: snapshot.mean_speed_mps,
            wheel_force_nm,
        }
    }

    fn angles(&self) -> Option<[f64; 3]> {
        let (yaw, pitch, roll) = self.ego?.rotation.to_euler(EulerRot::ZYX);
        Some([yaw, pitch, roll].map(f64::from))
    }
}

/// Returns the selector position as a word.
pub fn selector_word(selector: Selector) -> &'static str {
    match selector {
        Selector::Drive => "drive",
        Selector::Neutral => "neutral",
        Selector::Reverse => "reverse",
    }
}

/// Columns: one row for each tick (100 Hz). Without a participant the cells of the ego are empty, and the row holds the hash.
pub const EGO: &[TableColumn<EgoRow>] = &[
    column("tick", "", "tick, 10 ms each, since the start of the drive", ColumnValue::Whole(|r| r.tick.0)),
    number("time_s", "s", "time since the start of the drive", |r| Some(r.tick.seconds())),
    column("hash", "", "fingerprint of every snapshot up to this tick", ColumnValue::Whole(|r| r.hash)),
    number(
        "throttle",
        "",
        "accelerator, 0 released to 1 floored, as given: the scenario's extra delay comes after",
        |r| Some(r.controls.throttle.into()),
    ),
    number("brake", "", "brake pedal, 0 released to 1 full force", |r| Some(r.controls.brake.into())),
    number("steering_wheel_rad", "rad", "angle of the steering wheel, positive to the left", |r| {
        Some(r.controls.steering_wheel_rad.into())
    }),
    column(
        "selector",
        "",
        "selector: drive, neutral or reverse",
        ColumnValue::Word(|r| selector_word(r.controls.selector).into()),
    ),
    column(
        "indicator",
        "",
        "indicators as given: off, left or right",
        ColumnValue::Word(|r| r.controls.indicator.name().into()),
    ),
    column(
        "task_button",
        "",
        "button of the secondary task that was pressed in this tick: none, respond, left or right",
        ColumnValue::Word(|r| r.controls.task_button.name().into()),
    ),
    column(
        "automation_button",
        "",
        "true in a tick in which the button of the automation was pressed",
        ColumnValue::Flag(|r| Some(r.controls.automation_button)),
    ),
    column(
        "gap_button",
        "",
        "true in a tick in which the button of the automation's time gap was pressed",
        ColumnValue::Flag(|r| Some(r.controls.gap_button)),
    ),
    number(
        "hand_torque_nm",
        "N m",
        "torque of the hands on the steering wheel, estimated from its motor and its motion, positive to the left; empty without force feedback",
        |r| r.controls.hand_torque_nm.map(f64::from),
    ),
    column(
        "automation",
        "",
        "mode of the automation: none, off, on, takeover_request or minimal_risk",
        ColumnValue::Word(|r| r.automation.mode.name().into()),
    ),
    number(
        "automation_gap_s",
        "s",
        "time gap that the automation keeps to the vehicle ahead; empty if it keeps none",
        |r| r.automation.time_gap_s,
    ),
    number("driven_throttle", "", "accelerator that the automation gave; empty while it is off", |r| {
        Some(r.automation.driven?.throttle.into())
    }),
    number("driven_brake", "", "brake pedal that the automation gave", |r| Some(r.automation.driven?.brake.into())),
    number(
        "driven_wheel_rad",
        "rad",
        "angle of the steering wheel that the automation gave, and of its return to the participant's in the second after",
        |r| Some(r.automation.driven?.steering_wheel_rad.into()),
    ),
    column("main_beam", "", "true while the main beam is on", ColumnValue::Flag(|r| Some(r.controls.main_beam))),
    number("x_m", "m", "centre of the car, to the east", |r| Some(r.ego?.position.x)),
    number("y_m", "m", "centre of the car, to the north", |r| Some(r.ego?.position.y)),
    number("z_m", "m", "centre of the car, up from the ground", |r| Some(r.ego?.position.z)),
    number("yaw_rad", "rad", "heading, 0 east, positive to the left", |r| Some(r.angles()?[0])),
    number("pitch_rad", "rad", "pitch of the body, positive nose down", |r| Some(r.angles()?[1])),
    number("roll_rad", "rad", "roll of the body, positive right side down", |r| Some(r.angles()?[2])),
    number("speed_mps", "m/s", "speed along the car, negative in reverse", |r| Some(r.ego?.speed_mps)),
    number("accel_mps2", "m/s2", "acceleration along the car", |r| Some(r.ego?.accel_mps2)),
    number("lateral_accel_mps2", "m/s2", "acceleration to the left", |r| Some(r.ego?.lateral_accel_mps2)),
    number("jerk_mps3", "m/s3", "change of accel_mps2 since the tick before, over the tick", |r| {
        Some((r.ego?.accel_mps2 - r.accel_before_mps2) / TICK_S)
    }),
    number("yaw_rate_radps", "rad/s", "yaw rate, positive to the left", |r| Some(r.ego?.yaw_rate)),
    number("gear", "", "gear: -1 reverse, 0 neutral, 1.. forwards", |r| Some(r.ego?.gear.into())),
    number("engine_rpm", "1/min", "engine speed", |r| Some(r.ego?.engine_rpm.into())),
    number("steering_torque_nm", "N m", "self-aligning torque at the wheel, positive to the left", |r| {
        Some(r.ego?.steering_torque_nm.into())
    }),
    column("braking", "", "the brake lamps are lit", ColumnValue::Flag(|r| Some(r.ego?.braking))),
    number("s_m", "m", "front bumper along the route", |r| r.ego.map(|_| r.s_m)),
    number("lane_offset_m", "m", "offset of the middle from the lane's middle, positive to the left", |r| {
        r.ego.map(|_| r.lane_offset_m)
    }),
    column("leader", "", "number of the car ahead", ColumnValue::Id(|r| r.leader.map(|l| l.0))),
    number("gap_m", "m", "own front bumper to the leader's rear bumper", |r| r.leader.map(|l| l.1)),
    number("headway_m", "m", "own front bumper to the leader's front bumper (SAE J2944)", |r| {
        r.leader.map(|l| l.1 + CAR_LENGTH_M)
    }),
    number("leader_speed_mps", "m/s", "speed of the leader", |r| r.leader.map(|l| l.2)),
    number("ttc_s", "s", "time to collision, gap over closing speed; empty while the gap does not close", |r| r.ttc_s),
    number("target_mps", "m/s", "advised speed", |r| r.advice.map(|a| a.target_mps)),
    number("range_low_mps", "m/s", "lower edge of the acceptable range", |r| r.advice.map(|a| a.band_mps().0)),
    number("range_high_mps", "m/s", "upper edge of the acceptable range", |r| r.advice.map(|a| a.band_mps().1)),
    column(
        "in_range",
        "",
        "the speed is in the acceptable range",
        ColumnValue::Flag(|r| Some(r.advice?.accepts(r.ego?.speed_mps))),
    ),
    number("mean_speed_mps", "m/s", "mean speed of all vehicles, the ego included", |r| Some(r.mean_speed_mps)),
    number(
        "wheel_force_nm",
        "N m",
        "torque that the steering wheel's motor was sent, positive to the left; empty where there is no force",
        |r| r.wheel_force_nm,
    ),
];
