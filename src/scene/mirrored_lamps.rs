//! Lamps that a wet road mirrors: those of vehicles, signals and streets. In: the vehicles and lit lamps of a picture, the rain. Out: lamps
//! with their height over the road, metres from the scene's origin.

use super::{
    CarInstance, LitLamp, StaticScene, ViewOptions, network::street_lamps::STREET_LAMP_M,
    traffic_parts::drawn_vehicles, vehicles,
};
use crate::{sim::Snapshot, space::Pose, traffic::VehicleKind};
use glam::Vec3;

/// Lamp whose light a wet road mirrors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirroredLamp {
    pub lamp: LitLamp,
    /// Height of the lamp over the road, metres.
    pub height_m: f32,
}

/// Light of a dipped head lamp as one sees it off its beam, of a tail lamp, of a brake lamp and of a street lamp.
const HEAD: [f32; 3] = [3.8, 3.9, 4.0];
const TAIL: [f32; 3] = [0.26, 0.002, 0.001];
const BRAKE: [f32; 3] = [3.2, 0.015, 0.01];
const STREET: [f32; 3] = [4.2, 3.6, 2.7];
/// Radius of a disc with the area of a vehicle's lamp, and of a street lamp's lens, metres.
const LAMP_M: f32 = 0.10;
const STREET_M: f32 = 0.14;
/// Distance up to which street lamps are mirrored, metres. Houses may hide those farther away.
const STREET_SEEN_M: f32 = 90.0;

impl MirroredLamp {
    /// Checks whether a vehicle, other than the lamp's own, is in the way of the light from the lamp to the road and on to an eye.
    pub fn is_hidden_by(&self, car: &CarInstance, eye: Vec3) -> bool {
        /// Half the length, half the width and the height of the model of a car that light does not pass, metres.
        const HALF: Vec3 = Vec3::new(2.8, 0.75, 1.35);
        let half = HALF * car.scale;
        let lamp = self.lamp.position;
        if car.position.truncate().distance_squared(lamp.truncate()) < half.x * half.x {
            return false;
        }
        let (way, to_car) = ((lamp - eye).truncate(), (car.position - eye).truncate());
        let share = to_car.dot(way) / way.length_squared().max(1e-6);
        // Above the road, the light is on the straight line from the lamp to the mirror image of the eye.
        let below_m = eye.z - (lamp.z - self.height_m);
        let light_m = (self.height_m + below_m) * share - below_m;
        (0.0..1.0).contains(&share) && to_car.distance_squared(way * share) < half.y * half.y && light_m < half.z
    }
}

/// Returns the lamps that a wet road mirrors to an eye; none on a dry road. `cars` are the parts of the vehicles, the ego's first, `lit` the
/// lamps that are drawn as discs.
pub(super) fn mirrored_lamps(
    snapshot: &Snapshot,
    cars: &[CarInstance],
    lit: &[LitLamp],
    eye: Vec3,
    options: &ViewOptions,
    static_scene: &StaticScene,
) -> Vec<MirroredLamp> {
    if options.rain_mmph <= 0.0 {
        return vec![];
    }
    let mut mirrored = Vec::with_capacity(4 * cars.len() + lit.len());
    for (body, parts) in drawn_vehicles(snapshot, cars) {
        if matches!(body.kind, VehicleKind::Bicycle | VehicleKind::Pedestrian) {
            continue;
        }
        let last = parts.len().saturating_sub(1);
        for (k, (part, drawn)) in body.parts(&Pose::default(), None).zip(parts).enumerate() {
            // Head and tail lamps are beside the indicators.
            let [front, rear] = vehicles::shape(&body, k, part.length_m, &static_scene.hubs).indicators;
            let tail = if drawn.brake > 0.0 { BRAKE } else { TAIL };
            let ends = [(k == 0, front, Vec3::X, HEAD), (k == last, rear, Vec3::NEG_X, tail)];
            for (_, at, facing, light) in ends.into_iter().filter(|(is_end, ..)| *is_end) {
                for side in [1.0, -1.0] {
                    let position = drawn.position + drawn.rotation * (at * Vec3::new(1.0, side, 1.0));
                    let lamp = LitLamp { position, facing: drawn.rotation * facing, radius_m: LAMP_M, light };
                    mirrored.push(MirroredLamp { lamp, height_m: at.z });
                }
            }
        }
    }
    // The road under a signal or a vehicle near the ego is about as high as that under the ego.
    let road_m = cars.first().map_or(0.0, |ego| ego.position.z);
    mirrored.extend(lit.iter().map(|lamp| MirroredLamp { lamp: *lamp, height_m: lamp.position.z - road_m }));
    let near = static_scene.street_lamps.iter().filter(|at| at.distance_squared(eye) < STREET_SEEN_M * STREET_SEEN_M);
    mirrored.extend(near.map(|&position| {
        let lamp = LitLamp { position, facing: Vec3::NEG_Z, radius_m: STREET_M, light: STREET };
        MirroredLamp { lamp, height_m: STREET_LAMP_M }
    }));
    mirrored
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        map::RoadMap,
        scene::{ViewKind, view},
        sim::VehicleSnapshot,
        traffic::{VehicleBody, VehicleId, VehicleLamps},
    };
    use glam::DVec2;

    fn scene() -> StaticScene {
        StaticScene::with_trees(&RoadMap::load("ring-250").expect("a map that is shipped"), 1, 0)
    }

    #[test]
    fn a_wet_road_mirrors_lamps_of_vehicles_and_streets_at_their_heights() {
        let mut static_scene = scene();
        static_scene.street_lamps = vec![Vec3::new(20.0, 5.0, 6.0), Vec3::new(500.0, 5.0, 6.0)];
        let pose = Pose { position: DVec2::new(30.0, 0.0), ..Pose::default() };
        let body = VehicleBody::CAR;
        let lamps = VehicleLamps { brake: true, ..VehicleLamps::default() };
        let car =
            VehicleSnapshot { id: VehicleId(1), pose, pose_before: pose, body, lamps, ..VehicleSnapshot::default() };
        let snapshot = Snapshot { cars: vec![car], ..Snapshot::default() };
        let mirrored = |rain_mmph: f32| {
            let options = ViewOptions { rain_mmph, ..ViewOptions::default() };
            view(&snapshot, 1.0, ViewKind::Driver, &options, &static_scene).mirrored_lamps
        };
        assert!(mirrored(0.0).is_empty(), "a dry road");
        let wet = mirrored(8.0);
        // Four of the ego, four of the car, one of the street within 90 m.
        assert_eq!(wet.len(), 9, "{wet:?}");
        let of_car: Vec<_> = wet.iter().filter(|at| (25.0..35.0).contains(&at.lamp.position.x)).collect();
        // UN Regulation 48: dipped beams 0.5 to 1.2 m, tail lamps 0.35 to 1.5 m above the ground.
        assert!(of_car.len() == 4 && of_car.iter().all(|at| (0.5..1.2).contains(&at.height_m)), "{of_car:?}");
        let red = of_car.iter().filter(|at| at.lamp.facing.x < -0.99 && at.lamp.light[0] > 100.0 * at.lamp.light[1]);
        assert_eq!(red.count(), 2, "brake lamps behind");
        let street = wet.iter().find(|at| at.lamp.facing.z < -0.99).expect("a street lamp");
        assert_eq!((street.height_m, street.lamp.position.x), (6.0, 20.0));
    }

    #[test]
    fn a_vehicle_between_hides_low_lamps_but_not_street_lamps() {
        let ego = view(&Snapshot::default(), 1.0, ViewKind::Chase, &ViewOptions::default(), &scene()).cars[0];
        let car = |x: f32, y: f32| CarInstance { position: Vec3::new(x, y, 0.0), ..ego };
        let at = |height_m: f32| {
            let position = Vec3::new(40.0, 0.0, height_m);
            let lamp = LitLamp { position, facing: Vec3::NEG_X, radius_m: 0.1, light: TAIL };
            MirroredLamp { lamp, height_m }
        };
        let eye = Vec3::new(0.0, 0.0, 1.2);
        let hides = |x: f32, y: f32, height_m: f32| at(height_m).is_hidden_by(&car(x, y), eye);
        assert!(hides(20.0, 0.0, 0.8) && !hides(20.0, 3.0, 0.8), "in the lane, and in the next one");
        assert!(
            !hides(42.0, 0.0, 0.8) && !hides(50.0, 0.0, 0.8) && !hides(-10.0, 0.0, 0.8),
            "its own, beyond and behind"
        );
        // Half way, light from 6 m is at (6 - 1.2) / 2 = 2.4 m, over the roof.
        assert!(!hides(20.0, 0.0, 6.0));
    }
}
