//! Table of the vehicles. In: the world at the end of a step. Out: one row for each vehicle. SI units; positions in world axes
//! (x east, y north). On a network vehicles enter and leave; those far from the ego have a row each second only.

use crate::{
    map::network::{LanePosition, Network},
    record::table::{ColumnValue, TableColumn, column, number},
    sim::{Snapshot, VehicleSnapshot},
    time::{TICKS_PER_S, Tick},
};

/// Distance from the ego within which vehicles of a network have a row each step, metres. Within it, vehicles can touch the
/// ego.
const NEAR_M: f64 = 100.0;

/// Returns the vehicles that have a row at this step, by ascending number. On a closed route these are all. On a network these
/// are those near the ego, and all at each full second. Otherwise an hour of 1,000 vehicles would have 36 million rows and 1
/// GB; a replay has every step.
pub fn recorded_cars(snapshot: &Snapshot, is_on_network: bool) -> impl Iterator<Item = &VehicleSnapshot> {
    let takes_all = !is_on_network || snapshot.tick.0.is_multiple_of(u64::from(TICKS_PER_S));
    let ego = snapshot.ego.pose().position;
    snapshot.cars.iter().filter(move |car| takes_all || car.pose.position.distance(ego) <= NEAR_M)
}

/// Vehicle at a step; the ego is number 0.
#[derive(Clone, Debug)]
pub struct CarRow {
    /// Tick at the end of the step.
    pub tick: Tick,
    /// Number of the vehicle.
    pub car: u32,
    /// Front bumper along the ego's route, metres; `None` off the route.
    pub s_m: Option<f64>,
    /// Centre, to the east, metres.
    pub x_m: f64,
    /// Centre, to the north, metres.
    pub y_m: f64,
    /// Heading, radians, 0 east, positive to the left.
    pub yaw_rad: f64,
    pub speed_mps: f64,
    pub accel_mps2: f64,
    /// True if the brake lamps are lit.
    pub braking: bool,
    /// SUMO's id of its lane on a network; empty elsewhere.
    pub lane: String,
    /// Front bumper along that lane, metres.
    pub lane_s_m: Option<f64>,
    /// Offset from that lane's centre line, metres, positive to the left.
    pub lane_offset_m: Option<f64>,
}

impl CarRow {
    /// Returns the row of a vehicle of the traffic.
    pub fn of(tick: Tick, car: &VehicleSnapshot, network: &Network) -> Self {
        let at = car.pose;
        let (lane, lane_s_m, lane_offset_m) = in_lane(car.lane, network);
        Self {
            lane,
            lane_s_m,
            lane_offset_m,
            tick,
            car: car.id.0,
            s_m: car.s_m,
            x_m: at.position.x,
            y_m: at.position.y,
            yaw_rad: at.yaw_rad,
            speed_mps: car.speed_mps,
            accel_mps2: car.accel_mps2,
            braking: car.lamps.brake,
        }
    }

    /// Returns the row of the ego; `None` without a participant.
    pub fn ego(snapshot: &Snapshot, network: &Network) -> Option<Self> {
        if snapshot.is_without_ego {
            return None;
        }
        let (ego, pose) = (&snapshot.ego, snapshot.ego.pose());
        let (lane, lane_s_m, lane_offset_m) = in_lane(snapshot.ego_lane, network);
        Some(Self {
            lane,
            lane_s_m,
            lane_offset_m,
            tick: snapshot.tick,
            car: crate::traffic::EGO.0,
            s_m: Some(snapshot.ego_s_m),
            x_m: pose.position.x,
            y_m: pose.position.y,
            yaw_rad: pose.yaw_rad,
            speed_mps: ego.speed_mps,
            accel_mps2: ego.accel_mps2,
            braking: ego.braking,
        })
    }
}

/// Returns the id of a lane, the position along it and the offset from its centre line, metres.
pub(super) fn in_lane(at: Option<LanePosition>, network: &Network) -> (String, Option<f64>, Option<f64>) {
    at.map_or((String::new(), None, None), |at| (network.lane(at.lane).id.clone(), Some(at.s_m), Some(at.offset_m)))
}

/// Columns: one row for each vehicle and step.
pub const CARS: &[TableColumn<CarRow>] = &[
    column("tick", "", "tick at the end of the step", ColumnValue::Whole(|r| r.tick.0)),
    column(
        "car",
        "",
        "number of the car; 0 is the ego, which has no row in a drive without a participant",
        ColumnValue::Id(|r| Some(r.car)),
    ),
    number("s_m", "m", "front bumper along the ego's route; empty beside it", |r| r.s_m),
    number("x_m", "m", "centre, to the east", |r| Some(r.x_m)),
    number("y_m", "m", "centre, to the north", |r| Some(r.y_m)),
    number("yaw_rad", "rad", "heading, 0 east, positive to the left", |r| Some(r.yaw_rad)),
    number("speed_mps", "m/s", "speed", |r| Some(r.speed_mps)),
    number("accel_mps2", "m/s2", "acceleration", |r| Some(r.accel_mps2)),
    column("braking", "", "the brake lamps are lit", ColumnValue::Flag(|r| Some(r.braking))),
    column("lane", "", "SUMO's id of the lane; empty beside all lanes", ColumnValue::Word(|r| r.lane.clone())),
    number("lane_s_m", "m", "front bumper along the lane", |r| r.lane_s_m),
    number("lane_offset_m", "m", "front bumper beside the lane's middle, positive to the left", |r| r.lane_offset_m),
];
