//! Traffic of a drive for numpy. In: the world. Out: all vehicles now as columns, lanes and signals; names of the columns and of the measures
//! of a hold. Metres, m/s, radians.

use codrive::{
    drive_loop::hold_measures,
    map::network::{Network, SignalId},
    sim::{Leader, Snapshot, World, WorldError},
    space::{CAR_LENGTH_M, CAR_WIDTH_M, Pose},
    traffic::{EGO, VehicleId},
};

/// Names of the columns, those of cars.parquet; `lane` is the index of a lane in [`lanes`], -1 off all lanes.
pub const VEHICLE_COLUMNS: [&str; 13] = [
    "car",
    "is_advised",
    "lane",
    "lane_s_m",
    "lane_offset_m",
    "s_m",
    "x_m",
    "y_m",
    "yaw_rad",
    "speed_mps",
    "accel_mps2",
    "length_m",
    "width_m",
];

/// Names of the measures of a hold.
pub const HOLD_MEASURES: [&str; hold_measures::HOLD_MEASURES.len()] = names();

const fn names() -> [&'static str; hold_measures::HOLD_MEASURES.len()] {
    let mut names = [""; hold_measures::HOLD_MEASURES.len()];
    let mut index = 0;
    while index < names.len() {
        names[index] = hold_measures::HOLD_MEASURES[index].name;
        index += 1;
    }
    names
}

/// Returns all vehicles now, by ascending number, column by column; NaN for a place that a vehicle does not have.
pub fn vehicles(world: &World) -> Vec<f64> {
    let rows = rows(world);
    (0..VEHICLE_COLUMNS.len()).flat_map(|column| rows.iter().map(move |row| row[column])).collect()
}

fn rows(world: &World) -> Vec<[f64; VEHICLE_COLUMNS.len()]> {
    let snapshot = world.snapshot();
    let ego = (!snapshot.is_without_ego).then(|| ego(snapshot));
    let advised = world.advised_others();
    let is_advised = |id: VehicleId| advised.binary_search_by_key(&id, |agent| agent.id()).is_ok();
    let others = snapshot.vehicles().map(|car| {
        let (lane, lane_s_m, lane_offset_m) = match car.lane {
            Some(at) => (at.lane.index() as f64, at.s_m, at.offset_m),
            None => (-1.0, f64::NAN, f64::NAN),
        };
        let Pose { position, yaw_rad } = car.pose;
        [
            f64::from(car.id.0),
            f64::from(u8::from(is_advised(car.id))),
            lane,
            lane_s_m,
            lane_offset_m,
            car.s_m.unwrap_or(f64::NAN),
            position.x,
            position.y,
            yaw_rad,
            car.speed_mps,
            car.accel_mps2,
            car.body.length_m,
            car.body.width_m,
        ]
    });
    ego.into_iter().chain(others).collect()
}

/// Returns the participant's vehicle, which is always advised.
fn ego(snapshot: &Snapshot) -> [f64; VEHICLE_COLUMNS.len()] {
    let (state, Pose { position, yaw_rad }) = (&snapshot.ego, snapshot.ego.pose());
    let (lane, lane_s_m) = snapshot.ego_lane.map_or((-1.0, f64::NAN), |at| (at.lane.index() as f64, at.s_m));
    let lane_offset_m = snapshot.ego_lane.map_or(snapshot.lane_offset_m, |at| at.offset_m);
    [
        f64::from(EGO.0),
        1.0,
        lane,
        lane_s_m,
        lane_offset_m,
        snapshot.ego_s_m,
        position.x,
        position.y,
        yaw_rad,
        state.speed_mps,
        state.accel_mps2,
        CAR_LENGTH_M,
        CAR_WIDTH_M,
    ]
}

/// Returns for each of [`vehicles`] the vehicle ahead of it on its way within `reach_m`, if any.
///
/// # Errors
/// The road has no network with a demand, or the engine failed.
pub fn leaders(world: &World, reach_m: f64) -> Result<Vec<Option<Leader>>, WorldError> {
    let others = world.leaders(reach_m)?;
    let snapshot = world.snapshot();
    let ego = (!snapshot.is_without_ego).then(|| snapshot.leader.filter(|leader| leader.gap_m <= reach_m));
    Ok(ego.into_iter().chain(others).collect())
}

/// Returns id, width and centre line of each lane, points of east and north one after the other.
pub fn lanes(network: &Network) -> Vec<(String, f64, Vec<f64>)> {
    let lane = |lane: &codrive::map::network::Lane| {
        let points = lane.line.points().iter().flat_map(|point| [point.x, point.y]).collect();
        (lane.id.clone(), lane.width_m, points)
    };
    network.lanes().iter().map(lane).collect()
}

/// Returns id and present letters of each signal.
pub fn signals(world: &World) -> Vec<(String, String)> {
    let (known, states) = (world.map().network.signals(), &world.snapshot().signals);
    let letters = |index| String::from_utf8_lossy(states.letters(SignalId::from_index(index))).into_owned();
    known.iter().enumerate().map(|(index, signal)| (signal.id.clone(), letters(index))).collect()
}
