//! Table of the advised vehicles other than the ego. In: each such vehicle at the end of a step. Out: one row for each. SI
//! units; positions in world axes (x east, y north). The ego is in the tables ego and advice.

use super::selector_word;
use crate::{
    controls::Controls,
    ego::EgoState,
    policy::Advice,
    record::table::{ColumnValue, TableColumn, column, number},
    sim::{Agent, World},
    time::Tick,
};

/// Advised vehicle at a step, with the controls of the tick that led to it.
#[derive(Clone, Copy, Debug)]
pub struct AdvisedRow {
    /// Tick at the end of the step.
    pub tick: Tick,
    /// Number of the vehicle.
    pub vehicle: u32,
    /// Controls that its driver gave in this tick.
    pub controls: Controls,
    /// State of the vehicle.
    pub car: EgoState,
    /// Front bumper along its own route, metres.
    pub s_m: f64,
    /// Offset from the lane's centre line, metres, positive to the left.
    pub lane_offset_m: f64,
    /// Vehicle ahead: number, gap in metres, speed in m/s.
    pub leader: Option<(u32, f64, f64)>,
    /// Advice in force after the tick.
    pub advice: Option<Advice>,
    /// Number of contacts with other vehicles since the start.
    pub contacts: u32,
}

impl AdvisedRow {
    /// Returns the row of a vehicle.
    fn of(agent: &Agent) -> Self {
        let view = agent.snapshot();
        Self {
            tick: view.tick,
            vehicle: agent.id().0,
            controls: agent.controls().sane(),
            car: view.ego,
            s_m: view.ego_s_m,
            lane_offset_m: view.lane_offset_m,
            leader: view.leader.map(|l| (l.id.0, l.gap_m, l.speed_mps)),
            advice: view.advice,
            contacts: agent.contact_count(),
        }
    }

    /// Returns the rows of a world after a tick; none within a step.
    pub fn all(world: &World) -> impl Iterator<Item = Self> {
        let is_step = world.snapshot().tick.0.is_multiple_of(world.scenario().step_ticks());
        world.advised_others().iter().filter(move |_| is_step).map(Self::of)
    }
}

/// Columns: one row for each advised vehicle and step.
pub const ADVISED: &[TableColumn<AdvisedRow>] = &[
    column("tick", "", "tick at the end of the step", ColumnValue::Whole(|r| r.tick.0)),
    column("vehicle", "", "number of the vehicle: that of car in cars.parquet", ColumnValue::Id(|r| Some(r.vehicle))),
    number("throttle", "", "accelerator in this tick, 0 released to 1 floored, as given", |r| {
        Some(r.controls.throttle.into())
    }),
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
        "indicators: off, left or right",
        ColumnValue::Word(|r| r.controls.indicator.name().into()),
    ),
    number("x_m", "m", "centre of the car, to the east", |r| Some(r.car.position.x)),
    number("y_m", "m", "centre of the car, to the north", |r| Some(r.car.position.y)),
    number("yaw_rad", "rad", "heading, 0 east, positive to the left", |r| Some(r.car.pose().yaw_rad)),
    number("speed_mps", "m/s", "speed along the car, negative in reverse", |r| Some(r.car.speed_mps)),
    number("accel_mps2", "m/s2", "acceleration along the car", |r| Some(r.car.accel_mps2)),
    number("s_m", "m", "front bumper along its own route", |r| Some(r.s_m)),
    number("lane_offset_m", "m", "offset of the middle from the lane's middle, positive to the left", |r| {
        Some(r.lane_offset_m)
    }),
    column("leader", "", "number of the vehicle ahead", ColumnValue::Id(|r| r.leader.map(|l| l.0))),
    number("gap_m", "m", "own front bumper to the leader's rear bumper", |r| r.leader.map(|l| l.1)),
    number("leader_speed_mps", "m/s", "speed of the leader", |r| r.leader.map(|l| l.2)),
    column(
        "advice_tick",
        "",
        "tick at which the advice that stands was issued; empty without",
        ColumnValue::Id(|r| u32::try_from(r.advice?.issued.0).ok()),
    ),
    number("target_mps", "m/s", "advised speed", |r| r.advice.map(|a| a.target_mps)),
    number("range_low_mps", "m/s", "lower edge of the acceptable range", |r| r.advice.map(|a| a.band_mps().0)),
    number("range_high_mps", "m/s", "upper edge of the acceptable range", |r| r.advice.map(|a| a.band_mps().1)),
    column(
        "in_range",
        "",
        "the speed is in the acceptable range",
        ColumnValue::Flag(|r| Some(r.advice?.accepts(r.car.speed_mps))),
    ),
    column(
        "contacts",
        "",
        "how often it has begun to touch another vehicle since the start",
        ColumnValue::Id(|r| Some(r.contacts)),
    ),
];
