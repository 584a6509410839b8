//! Lamps of vehicles that are lit at times: indicators, reversing lamps, rear fog lamps. In: the vehicles of a picture, the weather. Out: discs
//! of light, metres from the scene's origin.

use super::{CarInstance, LitLamp, StaticScene, ViewKind, ViewOptions, traffic_parts::drawn_vehicles, vehicles};
use crate::{
    controls::BLINK_S,
    sim::Snapshot,
    space::Pose,
    traffic::{EGO, VehicleId, VehicleKind, VehicleLamps},
};
use glam::Vec3;

/// Linear colour of an indicator's light, and the share of its period in which it is on (`docs/references.md: roads`).
const INDICATOR: [f32; 3] = [3.4, 1.25, 0.02];
const BLINK_ON: f64 = 0.5;
/// Light of a reversing lamp, and of a rear fog lamp.
const REVERSING: [f32; 3] = [2.6, 2.5, 2.3];
const REAR_FOG: [f32; 3] = [5.0, 0.045, 0.02];
/// Visibility at and below which rear fog lamps are lit, metres (`docs/references.md: fog`).
const REAR_FOG_M: f32 = 100.0;
/// Speed backwards from which a vehicle of the traffic counts as reversing, m/s.
const BACKWARDS_MPS: f64 = 0.1;
/// Places of the reversing lamps and of the rear fog lamp as shares of the rear indicator's: behind, to the side, up.
const REVERSING_AT: Vec3 = Vec3::new(1.015, 0.80, 0.86);
const REAR_FOG_AT: Vec3 = Vec3::new(1.015, 0.62, 0.62);

/// State of a vehicle that its lamps show.
struct ShownState {
    id: VehicleId,
    lamps: VehicleLamps,
    is_reversing: bool,
}

/// Returns the lit lamps of all vehicles; from its own seat those of the ego are not visible. `cars` are the parts of the vehicles, the ego's
/// first.
pub(super) fn vehicle_lamps(
    snapshot: &Snapshot,
    cars: &[CarInstance],
    kind: ViewKind,
    now_s: f64,
    options: &ViewOptions,
    static_scene: &StaticScene,
) -> Vec<LitLamp> {
    let is_foggy = options.visibility_m <= REAR_FOG_M;
    let ego = ShownState { id: EGO, lamps: snapshot.ego_lamps(), is_reversing: snapshot.ego.gear < 0 };
    let others = snapshot.cars.iter().map(|car| ShownState {
        id: car.id,
        lamps: car.lamps,
        is_reversing: car.speed_mps < -BACKWARDS_MPS,
    });
    let is_from_outside = matches!(kind, ViewKind::Chase | ViewKind::Birdseye);
    let states = std::iter::once(ego).chain(others).zip(drawn_vehicles(snapshot, cars));
    let mut lit = Vec::new();
    for (state, (body, parts)) in states.skip(usize::from(!is_from_outside)) {
        // Each vehicle blinks with its own phase.
        let phase = now_s / BLINK_S + 0.37 * f64::from(state.id.0 % 8);
        let is_on = phase.fract() <= BLINK_ON;
        let sides = [(1.0, state.lamps.left && is_on), (-1.0, state.lamps.right && is_on)];
        let is_car = !matches!(body.kind, VehicleKind::Bicycle | VehicleKind::Motorcycle | VehicleKind::Pedestrian);
        let has_rear_lamps = is_car && (is_foggy || state.is_reversing);
        if !has_rear_lamps && sides.iter().all(|(_, is_lit)| !is_lit) {
            continue;
        }
        for (k, (part, drawn)) in body.parts(&Pose::default(), None).zip(parts).enumerate() {
            let shape = vehicles::shape(&body, k, part.length_m, &static_scene.hubs);
            let [front, rear] = shape.indicators;
            let is_last = k + 1 == parts.len();
            let mut add = |at: Vec3, facing: Vec3, radius_m: f32, light: [f32; 3]| {
                let position = drawn.position + drawn.rotation * at;
                lit.push(LitLamp { position, facing: drawn.rotation * facing, radius_m, light });
            };
            let radius_m = shape.indicator_radius_m;
            for (side, _) in sides.into_iter().filter(|(_, is_lit)| *is_lit) {
                let ends = [(k == 0, front, Vec3::X), (is_last, rear, Vec3::NEG_X)];
                for (_, at, facing) in ends.into_iter().filter(|(is_end, ..)| *is_end) {
                    add(at * Vec3::new(1.0, side, 1.0), facing, radius_m, INDICATOR);
                }
            }
            if is_last && is_car && state.is_reversing {
                for side in [1.0, -1.0] {
                    add(rear * REVERSING_AT * Vec3::new(1.0, side, 1.0), Vec3::NEG_X, radius_m, REVERSING);
                }
            }
            if is_last && is_car && is_foggy {
                // On the side of the oncoming traffic (`docs/references.md: fog`).
                let side = if static_scene.network.is_left_hand() { -1.0 } else { 1.0 };
                add(rear * REAR_FOG_AT * Vec3::new(1.0, side, 1.0), Vec3::NEG_X, 1.2 * radius_m, REAR_FOG);
            }
        }
    }
    lit
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        map::{RoadMap, network::Network},
        scene::view,
        sim::VehicleSnapshot,
        traffic::VehicleBody,
    };
    use glam::DVec2;

    fn car(id: u32, x: f64, speed_mps: f64) -> VehicleSnapshot {
        let pose = Pose { position: DVec2::new(x, 0.0), ..Pose::default() };
        let body = VehicleBody::CAR;
        VehicleSnapshot { id: VehicleId(id), pose, pose_before: pose, body, speed_mps, ..VehicleSnapshot::default() }
    }

    fn lamps(snapshot: &Snapshot, kind: ViewKind, visibility_m: f32, static_scene: &StaticScene) -> Vec<LitLamp> {
        let options = ViewOptions { visibility_m, ..ViewOptions::default() };
        view(snapshot, 1.0, kind, &options, static_scene).lamps
    }

    #[test]
    fn what_goes_backwards_shows_two_white_lamps_behind() {
        let map = RoadMap::load("ring-250").expect("a map that is shipped");
        let static_scene = StaticScene::with_trees(&map, 1, 0);
        let mut snapshot = Snapshot { cars: vec![car(1, 30.0, -0.5), car(2, 60.0, 0.5)], ..Snapshot::default() };
        let white = |snapshot: &Snapshot, kind: ViewKind| {
            let lit = lamps(snapshot, kind, 30_000.0, &static_scene);
            assert!(lit.iter().all(|lamp| lamp.facing.x < -0.99 && lamp.light[2] > 1.0), "{lit:?}");
            lit.iter().map(|lamp| lamp.position.x).collect::<Vec<_>>()
        };
        // A car of 5 m with its centre at 30 m: its rear is at 27.5 m.
        let behind = white(&snapshot, ViewKind::Driver);
        assert!(behind.len() == 2 && behind.iter().all(|x| (x - 27.5).abs() < 0.15), "{behind:?}");
        snapshot.ego.gear = -1;
        assert_eq!(white(&snapshot, ViewKind::Chase).len(), 4, "the ego's, too, in reverse gear");
        assert_eq!(white(&snapshot, ViewKind::Driver).len(), 2, "not from its own seat");
    }

    #[test]
    fn in_thick_fog_vehicles_have_a_red_lamp_on_the_side_of_oncoming_traffic() {
        let map = RoadMap::load("ring-250").expect("a map that is shipped");
        let right = StaticScene::with_trees(&map, 1, 0);
        let left_hand = Network::load("tests/data/networks/town-left.net.xml").expect("a network of the tests");
        let left = StaticScene { network: left_hand.into(), ..right.clone() };
        let mut bicycle = car(2, 60.0, 3.0);
        bicycle.body = VehicleBody { kind: VehicleKind::Bicycle, length_m: 1.6, ..VehicleBody::CAR };
        let snapshot = Snapshot { cars: vec![car(1, 30.0, 9.0), bicycle], ..Snapshot::default() };
        let red = |visibility_m: f32, scene: &StaticScene| {
            let lit = lamps(&snapshot, ViewKind::Driver, visibility_m, scene);
            let all = lit.iter().filter(|lamp| lamp.light == REAR_FOG).map(|lamp| lamp.position);
            all.collect::<Vec<Vec3>>()
        };
        assert!(red(101.0, &right).is_empty());
        let [lamp] = red(100.0, &right)[..] else { panic!("one lamp") };
        assert!((lamp.x - 27.5).abs() < 0.15 && lamp.y > 0.2, "{lamp}");
        // UN Regulation 48, 6.11: 0.25 to 1 m above the ground.
        assert!((0.25..=1.0).contains(&lamp.z), "{lamp}");
        assert!(red(60.0, &left)[0].y < -0.2);
    }
}
