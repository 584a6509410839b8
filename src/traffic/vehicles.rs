//! Vehicles on a road network: what moves there, which has come and which has gone. In: the records of an engine. Out: plain data, by
//! ascending id. Metres, m/s, world axes.

use super::VehicleId;
use crate::{
    map::network::LaneId,
    space::{CAR_LENGTH_M, CAR_WIDTH_M, Pose},
};
use serde::{Deserialize, Serialize};

/// What kind of vehicle it is: which model stands for it in the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum VehicleKind {
    /// A passenger car, and whatever has no kind of its own here.
    #[default]
    Car,
    /// A delivery van.
    Van,
    /// A lorry, with or without a trailer.
    Truck,
    /// A bus or coach.
    Bus,
    /// A motorcycle or moped.
    Motorcycle,
    /// A bicycle.
    Bicycle,
}

impl VehicleKind {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::Car, Self::Van, Self::Truck, Self::Bus, Self::Motorcycle, Self::Bicycle];

    /// Its name in tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Car => "car",
            Self::Van => "van",
            Self::Truck => "truck",
            Self::Bus => "bus",
            Self::Motorcycle => "motorcycle",
            Self::Bicycle => "bicycle",
        }
    }

    /// SUMO's class of such vehicles, which has its own sizes, speeds and permissions.
    pub fn sumo_class(self) -> &'static str {
        match self {
            Self::Car => "passenger",
            Self::Van => "delivery",
            name => name.name(),
        }
    }

    /// The kind that stands for a class of SUMO's.
    pub fn of_sumo_class(class: &str) -> Self {
        match class {
            "delivery" => Self::Van,
            "truck" | "trailer" | "army" => Self::Truck,
            "bus" | "coach" => Self::Bus,
            "motorcycle" | "moped" => Self::Motorcycle,
            "bicycle" | "scooter" => Self::Bicycle,
            _ => Self::Car,
        }
    }
}

/// Size and kind of a vehicle: what does not change while it is there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct VehicleBody {
    /// Its kind.
    pub kind: VehicleKind,
    /// Bumper to bumper, metres.
    pub length_m: f64,
    /// Width, metres.
    pub width_m: f64,
    /// Height, metres.
    pub height_m: f64,
}

impl Default for VehicleBody {
    fn default() -> Self {
        Self::CAR
    }
}

impl VehicleBody {
    /// The passenger car that all vehicles of a ring are.
    pub const CAR: Self = Self { kind: VehicleKind::Car, length_m: CAR_LENGTH_M, width_m: CAR_WIDTH_M, height_m: 1.5 };
}

/// What of its lamps is lit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct VehicleLamps {
    /// Brake lamps.
    pub brake: bool,
    /// The left indicator blinks.
    pub left: bool,
    /// The right indicator blinks.
    pub right: bool,
    /// Blue or yellow light.
    pub emergency: bool,
}

/// One vehicle at the end of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NetworkVehicle {
    /// Which; never given twice in a drive.
    pub id: VehicleId,
    /// Size and kind.
    pub body: VehicleBody,
    /// Its lane; `None` beside all lanes.
    pub lane: Option<LaneId>,
    /// Front bumper along that lane, declared metres from its start.
    pub s_m: f64,
    /// Beside the lane's middle, metres, positive to the left.
    pub offset_m: f64,
    /// Pose of its centre on the ground plane.
    pub pose: Pose,
    /// Height of the road under its front, metres.
    pub height_m: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Acceleration over the step, m/s2; 0 in the step in which it came.
    pub accel_mps2: f64,
    /// Its lamps.
    pub lamps: VehicleLamps,
}

/// A vehicle that has come in a step.
#[derive(Clone, Debug, PartialEq)]
pub struct Departure {
    /// Its number from now on.
    pub id: VehicleId,
    /// Its name in the demand.
    pub name: String,
    /// Its type in the demand.
    pub kind: String,
    /// Size and kind.
    pub body: VehicleBody,
}

/// Who has come and who has gone in a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct VehicleChanges {
    /// Those that have come, by ascending id. One that came and went in the same step is in both lists.
    pub departed: Vec<Departure>,
    /// Those that have gone, by ascending id.
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
