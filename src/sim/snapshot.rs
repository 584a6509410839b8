//! The world at one tick, as everybody above the simulation sees it: plain data, world axes, SI.

use crate::{
    controls::Indicator,
    ego::EgoState,
    map::network::{LanePosition, SignalStates},
    policy::Advice,
    rng,
    space::{CAR_WIDTH_M, Pose},
    time::Tick,
    traffic::{VehicleBody, VehicleId, VehicleLamps},
};

/// One car of the traffic at a tick, between two steps of its engine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VehicleSnapshot {
    /// Which car; never the ego.
    pub id: VehicleId,
    /// Pose of its centre now.
    pub pose: Pose,
    /// Pose one tick earlier, so that a frame can be drawn between the two.
    pub pose_before: Pose,
    /// Front bumper along the ego's route, metres; `None` beside it. On a closed route with a fixed number of cars all are on it.
    pub s_m: Option<f64>,
    /// Where it is on a network; `None` on a closed route, and beside all lanes.
    pub lane: Option<LanePosition>,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Acceleration, m/s2.
    pub accel_mps2: f64,
    /// Way driven since the start, metres: wheels turn by it.
    pub odometer_m: f64,
    /// Size and kind.
    pub body: VehicleBody,
    /// Height of the road under it, metres.
    pub height_m: f64,
    /// Its lamps.
    pub lamps: VehicleLamps,
    /// How the body leans on its springs; only for the picture.
    pub pitch: Pitch,
}

/// The pitch of a car's body on its springs, radians, nose up positive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pitch {
    /// Now.
    pub now_rad: f32,
    /// One tick earlier.
    pub before_rad: f32,
    rate_radps: f32,
}

impl Pitch {
    /// A tick of `dt_s` under an acceleration along the car. A damped spring: 2 degrees at 1 g, 1.3 Hz, 0.45 of critical
    /// damping (the middle of what saloons have: Gillespie 1992, chapter 5).
    #[must_use]
    pub fn step(self, accel_mps2: f64, dt_s: f64) -> Self {
        const RAD_PER_MPS2: f32 = 0.0356 / 9.81;
        const NATURAL_RADPS: f32 = 1.3 * std::f32::consts::TAU;
        const DAMPING: f32 = 0.45;
        let dt_s = dt_s as f32;
        let rest_rad = accel_mps2.clamp(-9.0, 9.0) as f32 * RAD_PER_MPS2;
        let pull =
            NATURAL_RADPS * NATURAL_RADPS * (rest_rad - self.now_rad) - 2.0 * DAMPING * NATURAL_RADPS * self.rate_radps;
        let rate_radps = self.rate_radps + pull * dt_s;
        Self { now_rad: self.now_rad + rate_radps * dt_s, before_rad: self.now_rad, rate_radps }
    }
}

/// Everything at one tick.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    /// When.
    pub tick: Tick,
    /// There is no participant: nobody sees the ego, which stands far from all roads, and its numbers mean nothing.
    pub is_without_ego: bool,
    /// The ego now.
    pub ego: EgoState,
    /// The ego one tick earlier.
    pub ego_before: EgoState,
    /// Ego's front bumper along the route, metres.
    pub ego_s_m: f64,
    /// Lane of the ego's front bumper on a network; `None` on a closed route, and beside all lanes.
    pub ego_lane: Option<LanePosition>,
    /// Which of the ego's indicators are on.
    pub ego_indicator: Indicator,
    /// Ego's lateral offset from the lane's centre line, metres, positive to the left.
    pub lane_offset_m: f64,
    /// All other cars, by ascending id.
    pub cars: Vec<VehicleSnapshot>,
    /// What the signals of the network show; empty where there are none.
    pub signals: SignalStates,
    /// The leader: its id, the gap in metres (bumper to bumper) and its speed in m/s. `None` if the ego is alone.
    pub leader: Option<Leader>,
    /// Advice that stands now.
    pub advice: Option<Advice>,
    /// Mean speed of all vehicles, the ego included, m/s (HC22's measure); 0 where none is there.
    pub mean_speed_mps: f64,
}

/// The car ahead in the lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leader {
    /// Which car.
    pub id: VehicleId,
    /// Own front bumper to its rear bumper, metres.
    pub gap_m: f64,
    /// Its speed, m/s.
    pub speed_mps: f64,
}

/// True if a car this far beside the lane's middle, metres, overlaps one in the middle.
pub fn is_in_lane(lane_offset_m: f64) -> bool {
    lane_offset_m.abs() < CAR_WIDTH_M
}

/// Where a chain of [`Snapshot::hash`] begins (FNV-1a's offset).
pub const HASH_START: u64 = rng::FNV_START;

impl Snapshot {
    /// The car ahead, if the ego could run into it: less than a car's width beside the lane's middle, where the others drive.
    /// [`Snapshot::leader`] is there wherever the ego is.
    pub fn leader_in_lane(&self) -> Option<Leader> {
        self.leader.filter(|_| is_in_lane(self.lane_offset_m))
    }

    /// Speeds of all vehicles that are there, m/s, the ego's last; backwards is negative.
    pub fn speeds_mps(&self) -> impl Iterator<Item = f64> {
        let ego = (!self.is_without_ego).then_some(self.ego.speed_mps);
        self.cars.iter().map(|car| car.speed_mps).chain(ego)
    }

    /// The ego's lamps, as others see them.
    pub fn ego_lamps(&self) -> VehicleLamps {
        VehicleLamps {
            brake: self.ego.braking,
            left: self.ego_indicator == Indicator::Left,
            right: self.ego_indicator == Indicator::Right,
            emergency: false,
        }
    }

    /// Fingerprint of this snapshot, chained to that of the ones before: equal if and only if (but for chance) every
    /// bit of every number that matters to a drive is equal.
    pub fn hash(&self, before: u64) -> u64 {
        let mut hash = before;
        self.visit(&mut |_, _, value| hash = rng::fnv_1a(hash, &value.to_bits().to_le_bytes()));
        hash
    }

    /// The first number in which two snapshots differ: its name, the car, both values. `None` if all bits are equal.
    pub fn first_difference(&self, other: &Self) -> Option<(String, f64, f64)> {
        let list = |snapshot: &Self| {
            let mut list = Vec::new();
            snapshot.visit(&mut |name, car, value| list.push((name, car, value)));
            list
        };
        let (mine, theirs) = (list(self), list(other));
        if mine.len() != theirs.len() {
            return Some(("count of numbers".into(), mine.len() as f64, theirs.len() as f64));
        }
        let pair = mine.iter().zip(&theirs).find(|(a, b)| a.2.to_bits() != b.2.to_bits())?;
        Some((format!("{} of car {}", pair.0.0, pair.0.1), pair.0.2, pair.1.2))
    }

    /// Every number that a drive depends on: its name, the car it belongs to, its value.
    fn visit(&self, put: &mut dyn FnMut(&'static str, u32, f64)) {
        let ego = &self.ego;
        put("tick", 0, self.tick.seconds());
        for (name, value) in [("x", ego.position.x), ("y", ego.position.y), ("z", ego.position.z)] {
            put(name, 0, value);
        }
        ego.rotation.to_array().iter().for_each(|value| put("rotation", 0, (*value).into()));
        put("speed", 0, ego.speed_mps);
        put("acceleration", 0, ego.accel_mps2);
        put("yaw rate", 0, ego.yaw_rate);
        put("gear", 0, ego.gear.into());
        put("engine speed", 0, ego.engine_rpm.into());
        put("steering torque", 0, ego.steering_torque_nm.into());
        put("lane offset", 0, self.lane_offset_m);
        for car in &self.cars {
            // On a closed route that is all there is to its place.
            if let Some(s_m) = car.s_m {
                put("place", car.id.0, s_m);
            }
            if car.lane.is_some() || car.s_m.is_none() {
                let (place, lamps) = (car.pose, car.lamps);
                let numbers = [("x", place.position.x), ("y", place.position.y), ("heading", place.yaw_rad)];
                numbers.iter().for_each(|(name, value)| put(name, car.id.0, *value));
                put("indicators", car.id.0, f64::from(u8::from(lamps.left) + 2 * u8::from(lamps.right)));
            }
            put("speed", car.id.0, car.speed_mps);
            put("acceleration", car.id.0, car.accel_mps2);
            put("brake lamps", car.id.0, f64::from(u8::from(car.lamps.brake)));
        }
        self.signals.all_letters().iter().for_each(|letter| put("signal", 0, (*letter).into()));
        if let Some(advice) = self.advice {
            put("target", 0, advice.target_mps);
            put("issue time", 0, advice.issued.seconds());
        }
    }
}

impl VehicleSnapshot {
    /// This vehicle for the physics of another.
    pub(super) fn obstacle(&self) -> crate::ego::Obstacle {
        let VehicleBody { length_m, width_m, .. } = self.body;
        let Self { pose, speed_mps, height_m, .. } = *self;
        crate::ego::Obstacle { id: self.id.0, pose, speed_mps, length_m, width_m, height_m }
    }

    /// A car as its engine placed it, at this pose.
    pub(super) fn at_start(car: &crate::traffic::CarState, pose: Pose) -> Self {
        Self {
            id: car.id,
            pose,
            pose_before: pose,
            s_m: Some(car.s_m),
            lane: None,
            speed_mps: car.speed_mps,
            accel_mps2: car.accel_mps2,
            odometer_m: 0.0,
            body: VehicleBody::CAR,
            height_m: 0.0,
            lamps: VehicleLamps { brake: car.braking, ..VehicleLamps::default() },
            pitch: Pitch::default(),
        }
    }
}

#[cfg(test)]
#[path = "snapshot_tests.rs"]
mod tests;
