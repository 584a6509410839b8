//! Vehicles on a road network: their states, departures and arrivals. In: the records of an engine. Out: plain data, by ascending id.
//! Metres, m/s, world axes.

use super::Articulation;
use crate::{
    map::{
        PathLanes, RoadMap,
        network::{LaneId, LanePosition},
    },
    space::{CAR_LENGTH_M, CAR_WIDTH_M, Pose},
};
use serde::{Deserialize, Serialize};

/// Number of a vehicle. On a ring the ego is 0, vehicle 1 starts ahead of it (its leader), and so on in driving direction; the last is the
/// ego's follower.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize, serde::Deserialize)]
pub struct VehicleId(pub u32);

/// Number of the participant's vehicle, in every engine.
pub const EGO: VehicleId = VehicleId(0);

/// Smallest number of a person or road user that the scenario's events move; no engine counts as far.
pub const FIRST_OF_EVENTS: VehicleId = VehicleId(100_000_000);

impl VehicleId {
    /// Checks whether this is a person or road user that the scenario's events move.
    pub fn is_of_event(self) -> bool {
        self >= FIRST_OF_EVENTS
    }
}

/// Kind of a vehicle, which selects its model in the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum VehicleKind {
    /// Passenger car, and every vehicle of SUMO without a kind of its own here.
    #[default]
    Car,
    /// Van; SUMO's class `delivery`.
    Van,
    /// Lorry, with or without a trailer.
    Truck,
    /// Bus; SUMO's classes `bus` and `coach`.
    Bus,
    /// Motorcycle; SUMO's classes `motorcycle` and `moped`.
    Motorcycle,
    /// Bicycle; SUMO's classes `bicycle` and `scooter`.
    Bicycle,
    /// Person on foot or in a wheelchair, who is on the road without being a part of its traffic.
    Pedestrian,
}

impl VehicleKind {
    /// Kinds of vehicles, which flows may have.
    pub const ALL: [Self; 6] = [Self::Car, Self::Van, Self::Truck, Self::Bus, Self::Motorcycle, Self::Bicycle];

    /// Returns the name used in tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Car => "car",
            Self::Van => "van",
            Self::Truck => "truck",
            Self::Bus => "bus",
            Self::Motorcycle => "motorcycle",
            Self::Bicycle => "bicycle",
            Self::Pedestrian => "pedestrian",
        }
    }

    /// Returns SUMO's class of such vehicles, which has its own sizes, speeds and permissions.
    pub fn sumo_class(self) -> &'static str {
        match self {
            Self::Car => "passenger",
            Self::Van => "delivery",
            name => name.name(),
        }
    }

    /// Returns the kind for a vehicle class of SUMO.
    pub fn of_sumo_class(class: &str) -> Self {
        match class {
            "delivery" => Self::Van,
            "truck" | "trailer" | "army" => Self::Truck,
            "bus" | "coach" => Self::Bus,
            "motorcycle" | "moped" => Self::Motorcycle,
            "bicycle" | "scooter" => Self::Bicycle,
            "pedestrian" | "wheelchair" => Self::Pedestrian,
            _ => Self::Car,
        }
    }
}

/// Kind and size of a vehicle, which never change.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VehicleBody {
    pub kind: VehicleKind,
    /// Length from bumper to bumper, metres.
    pub length_m: f64,
    pub width_m: f64,
    pub height_m: f64,
}

impl Default for VehicleBody {
    fn default() -> Self {
        Self::CAR
    }
}

impl VehicleBody {
    /// Passenger car, the body of all vehicles of a ring.
    pub const CAR: Self = Self { kind: VehicleKind::Car, length_m: CAR_LENGTH_M, width_m: CAR_WIDTH_M, height_m: 1.5 };

    /// Returns the body of a kind: a car's, or the size of SUMO's class of that kind.
    pub const fn of_kind(kind: VehicleKind) -> Self {
        let [length_m, width_m, height_m] = match kind {
            VehicleKind::Car => return Self::CAR,
            VehicleKind::Van => [6.5, 2.16, 2.86],
            VehicleKind::Truck => [7.1, 2.4, 2.4],
            VehicleKind::Bus => [12.0, 2.5, 3.4],
            VehicleKind::Motorcycle => [2.2, 0.9, 1.5],
            VehicleKind::Bicycle => [1.6, 0.65, 1.7],
            VehicleKind::Pedestrian => [0.215, 0.478, 1.719],
        };
        Self { kind, length_m, width_m, height_m }
    }
}

/// Lamps of a vehicle that are lit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct VehicleLamps {
    pub brake: bool,
    /// The left indicator blinks.
    pub left: bool,
    /// The right indicator blinks.
    pub right: bool,
    /// A blue or yellow emergency light is on.
    pub emergency: bool,
}

/// State of one vehicle at the end of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VehicleState {
    /// Number of the vehicle, unique in a drive.
    pub id: VehicleId,
    pub body: VehicleBody,
    /// Lane of the vehicle; `None` off all lanes.
    pub lane: Option<LaneId>,
    /// Front bumper along that lane, declared metres from its start.
    pub s_m: f64,
    /// Lateral offset of the vehicle from the centre line, metres, positive to the left.
    pub offset_m: f64,
    /// Pose of the vehicle's centre on the ground plane. The heading of an articulated vehicle is that from its rear to its front.
    pub pose: Pose,
    /// Headings of the parts of an articulated vehicle; `None` for a vehicle of one part.
    pub articulation: Option<Articulation>,
    /// Height of the road under the front bumper, metres.
    pub height_m: f64,
    pub speed_mps: f64,
    /// Acceleration over the step, m/s2; 0 in the step of its departure.
    pub accel_mps2: f64,
    pub lamps: VehicleLamps,
}

impl VehicleState {
    /// Returns the position of the front bumper in its lane; `None` off all lanes.
    pub fn lane_position(&self) -> Option<LanePosition> {
        Some(LanePosition { lane: self.lane?, s_m: self.s_m, offset_m: self.offset_m })
    }

    /// Returns where the front bumper is along a map's route, metres; of several places the one nearest to `near_s_m`. `None` off the route.
    pub fn s_on(&self, map: &RoadMap, lanes: &PathLanes, near_s_m: f64) -> Option<f64> {
        lanes.s_at(map, self.lane_position()?, self.pose.front(self.body.length_m), near_s_m)
    }
}

/// Vehicle that departed in a step.
#[derive(Clone, Debug, PartialEq)]
pub struct Departure {
    /// Number of the vehicle, from this step on.
    pub id: VehicleId,
    /// Name of the vehicle in the demand.
    pub name: String,
    /// Type of the vehicle in the demand.
    pub kind: String,
    pub body: VehicleBody,
}

/// Departures and arrivals of a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VehicleChanges {
    /// Vehicles that departed, by ascending id. A vehicle that departs and arrives in the same step is in both lists.
    pub departed: Vec<Departure>,
    /// Vehicles that arrived, by ascending id.
    pub arrived: Vec<VehicleId>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_has_a_class_of_sumo_that_means_it() {
        for kind in VehicleKind::ALL {
            assert_eq!(VehicleKind::of_sumo_class(kind.sumo_class()), kind, "{}", kind.name());
        }
        assert_eq!(VehicleKind::of_sumo_class("evehicle"), VehicleKind::Car);
        assert_eq!(VehicleKind::of_sumo_class("coach"), VehicleKind::Bus);
    }
}
