//! The world at one tick, as all modules above the simulation see it: plain data, world axes, SI.

mod automation_state;
mod stimuli;
mod task_display;
mod weather;

pub use crate::traffic::Leader;
pub use automation_state::{AutomationMode, AutomationState, TIME_GAPS_S};
pub use stimuli::{EventStimuli, Pictogram, ShownQuestion, ToneSeries};
pub use task_display::{TaskDisplay, TaskPicture};
pub use weather::Weather;

use crate::{
    controls::Indicator,
    ego::{EgoState, Obstacle, ObstacleId},
    map::{
        NextManoeuvre,
        network::{LanePosition, SignalStates},
    },
    policy::Advice,
    rng,
    space::{CAR_WIDTH_M, Pose},
    time::Tick,
    traffic::{Articulation, EGO, VehicleBody, VehicleId, VehicleKind, VehicleLamps, VehiclePart},
};
use std::sync::Arc;

/// A vehicle of the traffic at one tick, interpolated between two steps of the engine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VehicleSnapshot {
    /// Id of the vehicle; never the ego's.
    pub id: VehicleId,
    /// Pose of the vehicle's centre now.
    pub pose: Pose,
    /// Pose one tick earlier, so that a frame can be drawn in between.
    pub pose_before: Pose,
    /// Headings of the parts of an articulated vehicle; `None` for a vehicle of one part.
    pub articulation: Option<Articulation>,
    /// Headings of the parts one tick earlier.
    pub articulation_before: Option<Articulation>,
    /// Front bumper along the ego's route, metres; `None` beside the route. On a closed route with a fixed number of vehicles, never
    /// `None`.
    pub s_m: Option<f64>,
    /// Position along and beside its lane; `None` off all lanes.
    pub lane: Option<LanePosition>,
    /// Speed along the heading, m/s; negative is backwards.
    pub speed_mps: f64,
    /// Acceleration along the heading, m/s².
    pub accel_mps2: f64,
    /// Distance driven since the start, metres, for the rotation of the wheels.
    pub odometer_m: f64,
    /// Length, width and kind of the body.
    pub body: VehicleBody,
    /// Height of the road under the vehicle, metres.
    pub height_m: f64,
    /// Lamps that are on.
    pub lamps: VehicleLamps,
    /// Pitch of the body, for the picture only.
    pub pitch: Pitch,
}

/// Pitch of a vehicle's body on its suspension, radians, positive nose up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pitch {
    /// Pitch at this tick.
    pub now_rad: f32,
    /// Pitch one tick earlier.
    pub before_rad: f32,
    rate_radps: f32,
}

impl Pitch {
    /// Advances by `dt_s` under a longitudinal acceleration. Damped spring: 2 degrees at 1 g, 1.3 Hz, 0.45 of critical damping (the middle
    /// of the values of saloons: Gillespie 1992, chapter 5).
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

/// The world at one tick, seen from one vehicle, the ego.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Snapshot {
    pub tick: Tick,
    /// True in a drive without a participant: the ego is parked far from all roads and its values are meaningless.
    pub is_without_ego: bool,
    /// State of the ego at this tick.
    pub ego: EgoState,
    /// State of the ego one tick earlier.
    pub ego_before: EgoState,
    /// Ego's front bumper along the route, metres.
    pub ego_s_m: f64,
    /// Lane of the ego's front bumper; `None` off all lanes.
    pub ego_lane: Option<LanePosition>,
    /// Ego's indicators that are on.
    pub ego_indicator: Indicator,
    /// True while the ego has its main beam on.
    pub ego_main_beam: bool,
    /// Next manoeuvre of the ego's path; `None` if there is none.
    pub next_manoeuvre: Option<NextManoeuvre>,
    /// Ego's lateral offset from the lane's centre line, metres, positive to the left.
    pub lane_offset_m: f64,
    /// All other vehicles and persons on foot, by ascending id. Persons have no lane.
    pub cars: Vec<VehicleSnapshot>,
    /// States of the network's signals; empty without signals.
    pub signals: SignalStates,
    /// Vehicle ahead; `None` if the ego is alone.
    pub leader: Option<Leader>,
    /// Advice in force, if there is any.
    pub advice: Option<Advice>,
    /// Text that an event shows the participant.
    pub message: Option<Arc<str>>,
    /// Other stimuli that events give the participant, if there are any.
    pub stimuli: Option<Arc<EventStimuli>>,
    /// Question that an event puts to the participant.
    pub question: Option<Arc<ShownQuestion>>,
    /// Weather and daylight, if events have changed those of the scenario.
    pub weather: Option<Weather>,
    /// Mean speed of all vehicles, the ego included, m/s (HC22's measure); 0 without vehicles.
    pub mean_speed_mps: f64,
    /// Secondary task of the ego's driver.
    pub task: TaskDisplay,
    /// Automation of the ego.
    pub automation: AutomationState,
}

/// Returns true if a car with this lateral offset, metres, overlaps one in the middle of the lane.
pub fn is_in_lane(lane_offset_m: f64) -> bool {
    lane_offset_m.abs() < CAR_WIDTH_M
}

/// Start value of a chain of [`Snapshot::hash`].
pub const HASH_START: u64 = rng::FNV_START;

impl Snapshot {
    /// Returns the leader if the ego overlaps its lateral range: less than a car's width from the middle of the lane. [`Snapshot::leader`]
    /// does not depend on the ego's lateral offset.
    pub fn leader_in_lane(&self) -> Option<Leader> {
        self.leader.filter(|_| is_in_lane(self.lane_offset_m))
    }

    /// Returns the time to collision with the leader, s, while the gap closes (SAE J2944: gap over closing speed).
    pub fn ttc_s(&self) -> Option<f64> {
        let leader = self.leader?;
        let closing_mps = self.ego.speed_mps - leader.speed_mps;
        (closing_mps > 0.0).then(|| leader.gap_m / closing_mps)
    }

    /// Returns all other vehicles: [`Snapshot::cars`] without [`Snapshot::persons`].
    pub fn vehicles(&self) -> impl Iterator<Item = &VehicleSnapshot> {
        self.cars.iter().filter(|car| !car.is_person())
    }

    /// Returns another vehicle or person by its id; `None` if it is not there.
    pub fn vehicle(&self, id: VehicleId) -> Option<&VehicleSnapshot> {
        self.cars.binary_search_by_key(&id, |car| car.id).ok().map(|at| &self.cars[at])
    }

    /// Returns all persons on foot, and the cyclists of events, who are no part of the traffic either.
    pub fn persons(&self) -> impl Iterator<Item = &VehicleSnapshot> {
        self.cars.iter().filter(|car| car.is_person())
    }

    /// Returns the speeds of all vehicles, m/s, the ego's last; negative is backwards.
    pub fn speeds_mps(&self) -> impl Iterator<Item = f64> {
        let ego = (!self.is_without_ego).then_some(self.ego.speed_mps);
        self.vehicles().map(|car| car.speed_mps).chain(ego)
    }

    /// Returns numbers and speeds of all vehicles, m/s, the ego first; a vehicle that rolls backwards has 0.
    pub fn numbered_speeds_mps(&self) -> impl Iterator<Item = (u32, f64)> {
        let ego = (!self.is_without_ego).then_some((EGO.0, self.ego.speed_mps));
        let others = self.vehicles().map(|car| (car.id.0, car.speed_mps));
        ego.into_iter().chain(others).map(|(id, speed_mps)| (id, speed_mps.max(0.0)))
    }

    /// Returns the ego's lamps as other drivers see them.
    pub fn ego_lamps(&self) -> VehicleLamps {
        // A minimal-risk manoeuvre has the hazard lights on (UN Regulation 157, 5.5.1).
        let is_hazard = self.automation.mode == AutomationMode::MinimalRisk;
        VehicleLamps {
            brake: self.ego.braking,
            left: is_hazard || self.ego_indicator == Indicator::Left,
            right: is_hazard || self.ego_indicator == Indicator::Right,
            emergency: false,
        }
    }

    /// Returns a hash of this snapshot, chained to the hash `before`. Two hashes are equal if and only if, except by chance, every bit of
    /// every number that matters to a drive is equal.
    pub fn hash(&self, before: u64) -> u64 {
        let mut hash = before;
        self.visit(&mut |_, _, value| hash = rng::chained(hash, value.to_bits()));
        hash
    }

    /// Returns the first number in which two snapshots differ: its name with the vehicle's id, and both values. `None` if all bits are
    /// equal.
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

    /// Visits every number that a drive depends on, with its name and the vehicle's id (0 for the ego).
    fn visit(&self, put: &mut impl FnMut(&'static str, u32, f64)) {
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
            // On a closed route this alone defines the position.
            if let Some(s_m) = car.s_m {
                put("place", car.id.0, s_m);
            }
            if car.lane.is_some() || car.s_m.is_none() {
                let Pose { position, yaw_rad } = car.pose;
                let numbers = [("x", position.x), ("y", position.y), ("heading", yaw_rad)];
                numbers.iter().for_each(|(name, value)| put(name, car.id.0, *value));
            }
            if let Some(Articulation { front_yaw_rad, rear_yaw_rad }) = car.articulation {
                put("heading of the front part", car.id.0, front_yaw_rad);
                put("heading of the rear part", car.id.0, rear_yaw_rad);
            }
            put("speed", car.id.0, car.speed_mps);
            put("acceleration", car.id.0, car.accel_mps2);
            let VehicleLamps { brake, left, right, .. } = car.lamps;
            put("lamps", car.id.0, f64::from(u8::from(brake) + 2 * u8::from(left) + 4 * u8::from(right)));
        }
        self.signals.all_letters().iter().for_each(|letter| put("signal", 0, (*letter).into()));
        if let Some(advice) = self.advice {
            put("target", 0, advice.target_mps);
            put("issue time", 0, advice.issued.seconds());
        }
        if let Some(message) = &self.message {
            put("message", 0, rng::fnv_1a(HASH_START, message.as_bytes()) as f64);
        }
        if let Some(stimuli) = &self.stimuli {
            stimuli.visit(put);
        }
        if let Some(question) = &self.question {
            question.visit(put);
        }
        if let Some(Weather { visibility_km, rain_mmph, time_h }) = self.weather {
            let numbers = [("visibility", visibility_km), ("rain", rain_mmph), ("time of day", time_h)];
            numbers.iter().for_each(|(name, value)| put(name, 0, *value));
        }
        self.task.visit(put);
        self.automation.visit(put);
    }
}

impl VehicleSnapshot {
    /// Checks whether this is a person on foot or a cyclist of an event, rather than a vehicle of the traffic.
    pub fn is_person(&self) -> bool {
        let kind = self.body.kind;
        kind == VehicleKind::Pedestrian || (kind == VehicleKind::Bicycle && self.id.is_of_event())
    }

    /// Returns the parts of this vehicle, the front one first.
    pub fn parts(&self) -> impl Iterator<Item = VehiclePart> + use<> {
        self.body.parts(&self.pose, self.articulation)
    }

    /// Returns the parts of this vehicle as obstacles for the physics of another.
    pub fn obstacles(&self) -> impl Iterator<Item = Obstacle> + use<> {
        let Self { id, speed_mps, height_m, body, .. } = *self;
        self.parts().enumerate().map(move |(part, VehiclePart { pose, length_m })| Obstacle {
            id: ObstacleId::Vehicle(id.0),
            part: part as u8,
            pose,
            speed_mps,
            length_m,
            width_m: body.width_m,
            height_m,
        })
    }
}

#[cfg(test)]
mod tests;
