//! Fixed objects near a vehicle with full physics. In: the roadside of the drive, the vehicle, the ground under it. Out: obstacles for the physics.
//!
//! Only where the vehicle reaches beyond the asphalt, or onto a pavement, are objects looked up: a drive that stays on the road never finds them.

use crate::{
    ego::{EgoState, GroundModel, GroundSurface, Obstacle, ObstacleId},
    roadside::{
        LazyRoadside,
        fixed_objects::{FixedObject, FixedObjectKind},
    },
    space::{CAR_LENGTH_M, CAR_WIDTH_M, Pose},
};
use glam::DVec2;

/// Ticks between two looks at the ground around the vehicle: four points cost as much as a tenth of a tick in a town.
const LOOK_EVERY: u32 = 4;
/// Distances ahead of the bumpers and beside the doors at which asphalt is looked for, metres: more than the way until the next look, at 50 m/s
/// ahead.
const ASPHALT_M: [f64; 2] = [2.0, 0.5];
/// Distances at which a lane for vehicles is looked for, metres. In a bend, a car reaches over a pavement; no pole stands nearer to the kerb than
/// half a metre.
const LANE_M: [f64; 2] = [0.3, 0.15];

/// Finder of fixed objects near a vehicle.
pub(super) struct ObjectsBeside {
    roadside: LazyRoadside,
    near: Vec<Obstacle>,
    ticks_to_look: u32,
    /// True if the vehicle reached beyond the road at the last look.
    is_beside: bool,
}

impl ObjectsBeside {
    /// Returns the finder for this roadside.
    pub fn new(roadside: &LazyRoadside) -> Self {
        Self { roadside: roadside.clone(), near: Vec::new(), ticks_to_look: 0, is_beside: false }
    }

    /// Returns the other obstacles together with the fixed objects that the vehicle may touch in this tick.
    pub fn add_to<'a>(
        &'a mut self,
        others: &'a [Obstacle],
        ego: &EgoState,
        ground: &dyn GroundModel,
    ) -> &'a [Obstacle] {
        let pose = ego.pose();
        if self.ticks_to_look == 0 {
            self.ticks_to_look = LOOK_EVERY;
            self.is_beside = reaches_beyond(&pose, ground);
        }
        self.ticks_to_look -= 1;
        if !self.is_beside {
            return others;
        }
        let height_m = ego.position.z;
        let objects = self.roadside.fixed_objects().near(pose.position);
        let obstacle = |(number, object): (u32, &FixedObject)| Obstacle {
            id: ObstacleId::FixedObject(number),
            part: 0,
            pose: object.pose,
            speed_mps: 0.0,
            length_m: object.length_m,
            width_m: object.width_m,
            height_m,
        };
        self.near.clear();
        self.near.extend_from_slice(others);
        self.near.extend(objects.filter(|(_, object)| object.is_at_height(height_m)).map(obstacle));
        &self.near
    }

    /// Returns the kind of a fixed object by its number.
    pub fn kind(&self, number: u32) -> Option<FixedObjectKind> {
        self.roadside.fixed_objects().get(number).map(|object| object.kind)
    }
}

/// Checks whether a vehicle is about to reach beyond the asphalt, or onto a pavement.
fn reaches_beyond(pose: &Pose, ground: &dyn GroundModel) -> bool {
    let (ahead, left) = (pose.forward(), pose.forward().perp());
    let are_all = |[beyond_m, aside_m]: [f64; 2], is_so: &dyn Fn(DVec2) -> bool| {
        let (ahead_m, left_m) = (CAR_LENGTH_M / 2.0 + beyond_m, CAR_WIDTH_M / 2.0 + aside_m);
        let corners = [(ahead_m, left_m), (ahead_m, -left_m), (-ahead_m, left_m), (-ahead_m, -left_m)];
        corners.into_iter().all(|(along_m, aside_m)| is_so(pose.position + ahead * along_m + left * aside_m))
    };
    !are_all(ASPHALT_M, &|point| ground.surface(point) == GroundSurface::Asphalt)
        || !are_all(LANE_M, &|point| ground.is_for_vehicles(point))
}
