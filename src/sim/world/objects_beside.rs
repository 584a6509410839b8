//! Fixed objects near a vehicle with full physics. In: the roadside of the drive, the vehicle, the ground under it. Out: obstacles for the physics.
//!
//! Only where the vehicle reaches beyond the asphalt are objects looked up: a drive that stays on the road never finds them.

use crate::{
    ego::{EgoState, GroundModel, GroundSurface, Obstacle, ObstacleId},
    roadside::{
        LazyRoadside,
        fixed_objects::{FixedObject, FixedObjectKind},
    },
    space::{CAR_LENGTH_M, CAR_WIDTH_M},
};

/// Distance ahead of the bumpers and beside the doors at which the ground is looked at, metres: more than the way in a tick.
const AHEAD_M: f64 = 1.0;
const ASIDE_M: f64 = 0.5;

/// Finder of fixed objects near a vehicle.
pub(super) struct ObjectsBeside {
    roadside: LazyRoadside,
    near: Vec<Obstacle>,
}

impl ObjectsBeside {
    /// Returns the finder for this roadside.
    pub fn new(roadside: &LazyRoadside) -> Self {
        Self { roadside: roadside.clone(), near: Vec::new() }
    }

    /// Returns the other obstacles together with the fixed objects that the vehicle may touch in this tick.
    pub fn add_to<'a>(
        &'a mut self,
        others: &'a [Obstacle],
        ego: &EgoState,
        ground: &dyn GroundModel,
    ) -> &'a [Obstacle] {
        let pose = ego.pose();
        let (ahead, left) = (pose.forward(), pose.forward().perp());
        let (ahead_m, left_m) = (CAR_LENGTH_M / 2.0 + AHEAD_M, CAR_WIDTH_M / 2.0 + ASIDE_M);
        let corners = [(ahead_m, left_m), (ahead_m, -left_m), (-ahead_m, left_m), (-ahead_m, -left_m)];
        let is_road = |(along_m, aside_m): (f64, f64)| {
            ground.surface(pose.position + ahead * along_m + left * aside_m) == GroundSurface::Asphalt
        };
        if corners.into_iter().all(is_road) {
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
