//! Spray that vehicles throw up from a wet road. In: a snapshot with its drawn vehicles, the rain, time. Out: soft puffs in the air behind them,
//! metres from the scene's origin. Amount, size and life of the puffs are codrive's own choice.

use super::{CarInstance, traffic_parts::drawn_vehicles};
use crate::{
    sim::Snapshot,
    traffic::{VehicleBody, VehicleKind},
};
use glam::Vec3;

/// Cloud of fine drops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SprayPuff {
    /// Middle, world axes.
    pub position: Vec3,
    pub radius_m: f32,
    /// Height of its middle over the road, metres.
    pub height_m: f32,
    /// Share of the light from behind that it hides in its middle.
    pub opacity: f32,
}

/// Number of puffs behind a vehicle, and how long each lasts.
const PUFFS: u32 = 9;
const LIFE_S: f64 = 1.0;
/// Speeds at which spray begins and at which it is full.
const SPEEDS_MPS: [f32; 2] = [4.0, 28.0];
/// Largest opacity of a puff, and the least that is drawn.
const OPACITY: f32 = 0.30;
const LEAST: f32 = 0.004;
/// Rain whose water on the road gives the full spray.
const FULL_MMPH: f32 = 10.0;
/// Share of the vehicle's speed with which its spray follows it.
const DRAGGED: f32 = 0.35;

/// Returns the spray behind all vehicles; none on a dry road. `cars` are the parts of the vehicles, the ego's first.
pub(super) fn spray(snapshot: &Snapshot, cars: &[CarInstance], rain_mmph: f32, now_s: f64) -> Vec<SprayPuff> {
    if rain_mmph <= 0.0 {
        return vec![];
    }
    let wet = (rain_mmph / FULL_MMPH).sqrt().min(1.0);
    let speeds = std::iter::once(snapshot.ego.speed_mps).chain(snapshot.cars.iter().map(|car| car.speed_mps));
    let mut puffs = Vec::new();
    for ((body, parts), speed_mps) in drawn_vehicles(snapshot, cars).zip(speeds) {
        let speed_mps = speed_mps as f32;
        let share = ((speed_mps - SPEEDS_MPS[0]) / (SPEEDS_MPS[1] - SPEEDS_MPS[0])).clamp(0.0, 1.0);
        let throws = !matches!(body.kind, VehicleKind::Bicycle | VehicleKind::Pedestrian);
        if let Some(rear) = parts.last().filter(|_| throws) {
            puffs.extend(behind(&body, rear, speed_mps, OPACITY * wet * share, now_s));
        }
    }
    puffs
}

/// Returns the puffs behind one vehicle.
fn behind(
    body: &VehicleBody,
    rear: &CarInstance,
    speed_mps: f32,
    opacity: f32,
    now_s: f64,
) -> impl Iterator<Item = SprayPuff> {
    /// Distance of the rear wheels from the middle of the model, before it is scaled.
    const REAR_M: f32 = 1.6;
    let (ahead, left) = (rear.rotation * Vec3::X, rear.rotation * Vec3::Y);
    let (start, half_m) = (rear.position - ahead * (REAR_M * rear.scale.x), 0.4 * body.width_m as f32);
    let large = (body.height_m / VehicleBody::CAR.height_m) as f32;
    (0..PUFFS).filter_map(move |k| {
        let turns = now_s / LIFE_S + f64::from(k) / f64::from(PUFFS);
        let age = turns.fract() as f32;
        // Each puff leaves from one side, somewhat elsewhere at each turn.
        let scatter = ((turns.floor() * 7.31 + f64::from(k) * 2.63).sin()) as f32;
        let side = if k % 2 == 0 { half_m } else { -half_m };
        let back_m = speed_mps * (1.0 - DRAGGED) * age * LIFE_S as f32;
        let radius_m = (0.35 + 1.1 * age) * large.sqrt();
        let height_m = 0.15 + 0.6 * age * large + 0.1 * scatter;
        let aside_m = side * (1.0 + 0.3 * age) + 0.25 * scatter;
        let position = start - ahead * back_m + left * aside_m + Vec3::Z * height_m;
        // It appears and vanishes softly.
        let opacity = opacity * (age / 0.12).min(1.0) * (1.0 - age).powf(1.5) * large.min(2.0);
        (opacity > LEAST).then_some(SprayPuff { position, radius_m, height_m, opacity })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        map::RoadMap,
        scene::{StaticScene, ViewKind, ViewOptions, view},
        sim::VehicleSnapshot,
        traffic::VehicleId,
    };

    #[test]
    fn vehicles_throw_up_spray_behind_them_when_they_are_fast_in_rain() {
        let map = RoadMap::load("ring-250").expect("a map that is shipped");
        let static_scene = StaticScene::with_trees(&map, 1, 0);
        let puffs = |rain_mmph: f32, speed_mps: f64| {
            let car = VehicleSnapshot { id: VehicleId(1), speed_mps, ..VehicleSnapshot::default() };
            let snapshot = Snapshot { cars: vec![car], ..Snapshot::default() };
            let options = ViewOptions { rain_mmph, ..ViewOptions::default() };
            view(&snapshot, 1.0, ViewKind::Driver, &options, &static_scene).spray
        };
        assert!(puffs(0.0, 25.0).is_empty(), "a dry road");
        assert!(puffs(10.0, 3.0).is_empty(), "walking pace");
        let opacity = |puffs: &[SprayPuff]| puffs.iter().map(|puff| puff.opacity).sum::<f32>();
        let (slow, fast, drizzle) = (puffs(10.0, 10.0), puffs(10.0, 25.0), puffs(1.0, 25.0));
        assert!(opacity(&slow) > 0.0 && opacity(&fast) > 2.0 * opacity(&slow), "{slow:?} {fast:?}");
        assert!(opacity(&drizzle) < 0.5 * opacity(&fast));
        // The vehicle stands at the origin and faces +x.
        assert!(fast.iter().all(|puff| puff.position.x < -1.0 && puff.position.x > -25.0), "{fast:?}");
        assert!(fast.iter().all(|puff| puff.opacity < 0.5), "what is behind stays visible");
    }
}
