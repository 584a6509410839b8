//! Vehicles other than cars, and persons on foot: van, lorry, tractor, semi-trailer, bus, the two parts of a long bus, motorcycle, bicycle
//! and walker, in simple shapes. In: kind and size of a vehicle, and one of its parts. Out: the part's model, the scale of the model, the
//! positions of wheels and indicators. Metres, in a part's frame: x forward, y left, z up, origin on the ground under the centre.
//!
//! A model is stored at the size of a car, 5.0 m by 1.8 m by 1.5 m, so that one scale serves all kinds: size of the vehicle over
//! size of the car.

mod boxes;
mod cycles;
mod gait;
mod limbs;
mod model;
mod walkers;

use super::{CarModel, Mesh, car::materials::WHEEL_RADIUS_M};
use crate::traffic::{VehicleBody, VehicleKind};
use glam::Vec3;
use model::Model;
use std::sync::Arc;

/// Number of body styles of cars: models of other kinds follow them in [`StaticScene::cars`](super::StaticScene::cars).
const CAR_STYLES: usize = 3;

/// Index of the first model of people on foot among those of all kinds but the car.
const FIRST_WALKER: usize = FIRST_BICYCLE + cycles::BICYCLES;
/// Index of the first model of a bicycle, likewise.
const FIRST_BICYCLE: usize = 8;

/// Model of a vehicle and its scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct VehicleShape {
    /// Index of the model, or of the first one of people in several postures; `None` for cars, whose style the caller chooses.
    pub style: Option<usize>,
    /// Scale of the body along its axes.
    pub scale: Vec3,
    /// Scale of a wheel along its axes.
    pub wheel_scale: Vec3,
    /// Hubs in the body's frame, metres: front left, front right, rear left, rear right.
    pub hubs: [Vec3; 4],
    /// Left indicators, front and rear, in the body's frame, metres. The right ones are their mirror images.
    pub indicators: [Vec3; 2],
    /// Radius of an indicator, metres.
    pub indicator_radius_m: f32,
}

/// Returns the size of the car, which is the size of all stored models, metres.
fn car_size() -> Vec3 {
    let VehicleBody { length_m, width_m, height_m, .. } = VehicleBody::CAR;
    Vec3::new(length_m as f32, width_m as f32, height_m as f32)
}

/// Returns the models of all kinds but the car, in the order of their styles. Bicycles and people on foot have a model for each posture.
pub(super) fn models() -> Vec<CarModel> {
    let built = [
        boxes::van(),
        boxes::lorry(),
        boxes::tractor(),
        boxes::semi_trailer(),
        boxes::bus(),
        boxes::bus_front(),
        boxes::bus_rear(),
        cycles::motorcycle(),
    ];
    let mut models = Vec::from(built.map(|built| {
        let body = Arc::new(stored(built));
        model([body.clone(), body], None)
    }));
    for postures in std::iter::once(cycles::bicycles().collect()).chain(walkers::walkers()) {
        models.extend(models_of_person(postures, CAR_STYLES + models.len()));
    }
    models
}

/// Returns the models of a person, standing and at the phases of a cycle, of which the first one has this style.
fn models_of_person(postures: Vec<[Model; 2]>, first_style: usize) -> impl Iterator<Item = CarModel> {
    let phases = postures.len() - 1;
    let (near, far): (Vec<Mesh>, Vec<Mesh>) = postures.into_iter().map(|levels| levels.map(stored).into()).unzip();
    let [near, far] = [near, far].map(|postures| Mesh::with_same_indices(&postures).into_iter().map(Arc::new));
    near.zip(far).enumerate().map(move |(k, (near, far))| {
        let next = if k == 0 { 0 } else { 1 + k % phases };
        model([near, far], Some([first_style + next, first_style]))
    })
}

/// Returns a model's mesh at the size of a car.
fn stored(Model { triangles, shape }: Model) -> Mesh {
    let ratio = shape.size / car_size();
    let mut body = triangles.into_mesh(0.7);
    for vertex in &mut body.vertices {
        vertex.position = (Vec3::from(vertex.position) / ratio).into();
        // The renderer transforms a normal like a position; after its scaling this is the model's own normal.
        vertex.normal = (Vec3::from(vertex.normal) / ratio).normalize_or(Vec3::Z).into();
    }
    body
}

/// Returns a model that is the same near and a little farther away, and the same from far and in shadows.
fn model([near, far]: [Arc<Mesh>; 2], postures: Option<[usize; 2]>) -> CarModel {
    let glass = [Mesh::default(), Mesh::default()];
    CarModel { plan: far.clone(), shade: far.clone(), levels: [near.clone(), near, far], glass, postures }
}

/// Posture of a cyclist or a person on foot, blended from those of three models: one of the cycle, the next one, and standing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct DrawnPosture {
    /// Index of the model after the first one of its kind.
    pub model: usize,
    /// Share of the next phase, plus 256 times the share of standing, both 0 to 255 (`shaders/posture.wgsl`).
    pub code: u16,
}

impl DrawnPosture {
    /// Returns the posture after this number of cycles of `phases` models; `moving` is 0 or less for a person who stands, 1 or more for one who makes
    /// whole steps.
    fn new(cycles: f64, phases: usize, moving: f32) -> Self {
        if moving <= 0.0 {
            return Self { model: 0, code: 0 };
        }
        let at = cycles.rem_euclid(1.0) * phases as f64;
        let phase = (at as usize).min(phases - 1);
        let code = |share: f32| (255.0 * share.clamp(0.0, 1.0)).round() as u16;
        Self { model: 1 + phase, code: code((at - phase as f64) as f32) + 256 * code(1.0 - moving) }
    }
}

/// Returns the posture of a cyclist or a person on foot after `moved_m`; `None` for other kinds.
pub(super) fn posture(kind: VehicleKind, number: u32, moved_m: f64, speed_mps: f64) -> Option<DrawnPosture> {
    match kind {
        VehicleKind::Bicycle => Some(cycles::posture_of(moved_m, speed_mps)),
        VehicleKind::Pedestrian => Some(walkers::posture_of(number, moved_m, speed_mps)),
        _ => None,
    }
}

/// Returns the model and scale of a vehicle's part with this index from the front, `length_m` long; `car_hubs` are the hubs of the car's
/// model.
pub(super) fn shape(body: &VehicleBody, part: usize, length_m: f64, car_hubs: &[Vec3; 4]) -> VehicleShape {
    let size = Vec3::new(length_m as f32, body.width_m as f32, body.height_m as f32);
    let scale = size / car_size();
    let style = match body.kind {
        VehicleKind::Car => {
            return VehicleShape {
                style: None,
                scale,
                wheel_scale: Vec3::splat(scale.z),
                hubs: car_hubs.map(|hub| hub * scale),
                indicators: [Vec3::new(2.36, 0.70, 0.66), Vec3::new(-2.47, 0.66, 0.80)].map(|at| at * scale),
                indicator_radius_m: 0.055,
            };
        }
        VehicleKind::Van => 0,
        VehicleKind::Truck if body.joint_m().is_none() => 1,
        VehicleKind::Truck => 2 + part,
        VehicleKind::Bus if body.joint_m().is_none() => 4,
        VehicleKind::Bus => 5 + part,
        VehicleKind::Motorcycle => 7,
        VehicleKind::Bicycle => FIRST_BICYCLE,
        VehicleKind::Pedestrian => FIRST_WALKER,
    };
    let boxes = [
        boxes::VAN,
        boxes::LORRY,
        boxes::TRACTOR,
        boxes::SEMI_TRAILER,
        boxes::BUS,
        boxes::BUS_FRONT,
        boxes::BUS_REAR,
        cycles::MOTORCYCLE,
        cycles::BICYCLE,
    ];
    let shape = boxes.get(style).copied().unwrap_or(walkers::WALKER);
    let stretch = size / shape.size;
    let [radius, width] = shape.wheel;
    // Wheels stay round: their radius is that of their kind, or smaller if the body is lower.
    let radius = radius * stretch.z.min(1.0);
    let hub =
        |axle: usize, side: f32| Vec3::new(shape.axles[axle] * stretch.x, side * shape.track_half * stretch.y, radius);
    VehicleShape {
        style: Some(CAR_STYLES + style),
        scale,
        wheel_scale: Vec3::new(
            radius / WHEEL_RADIUS_M,
            width / super::car::wheel::WHEEL_WIDTH_M,
            radius / WHEEL_RADIUS_M,
        ),
        hubs: [hub(0, 1.0), hub(0, -1.0), hub(1, 1.0), hub(1, -1.0)],
        indicators: shape.indicators.map(|at| at * stretch),
        indicator_radius_m: shape.indicator_radius,
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::{
        scene::{car, mesh::tests::check},
        space::Pose,
    };

    /// Returns the vertices of a person's near body in the picture, in metres and without the body's own way. `first` is the first model of the kind.
    /// The blending is that of `shaders/posture.wgsl`.
    pub fn drawn(models: &[CarModel], first: usize, DrawnPosture { model, code }: DrawnPosture) -> Vec<Vec3> {
        let this = &models[first + model];
        let others = this.postures.expect("a person").map(|style| &models[style - CAR_STYLES]);
        let size = if first == FIRST_WALKER { walkers::WALKER.size } else { cycles::BICYCLE.size };
        let [at, next, standing] = [this, others[0], others[1]]
            .map(|model| move |i: usize| Vec3::from(model.levels[0].vertices[i].position) * size / car_size());
        let [share, upright] = [code % 256, code / 256].map(|share| f32::from(share) / 255.0);
        (0..this.levels[0].vertices.len()).map(|i| at(i).lerp(next(i), share).lerp(standing(i), upright)).collect()
    }

    /// Returns the longest way of a point of a body between two postures, while the body moves `way_m` forwards.
    pub fn farthest_m(models: &[CarModel], first: usize, postures: [DrawnPosture; 2], way_m: f32) -> f32 {
        let [before, after] = postures.map(|posture| drawn(models, first, posture));
        before.iter().zip(after).map(|(a, b)| (b + Vec3::X * way_m).distance(*a)).fold(0.0, f32::max)
    }

    fn body(kind: VehicleKind, length_m: f64, width_m: f64, height_m: f64) -> VehicleBody {
        VehicleBody { kind, length_m, width_m, height_m }
    }

    #[test]
    fn a_car_of_the_usual_size_is_not_scaled() {
        let hubs = car::hubs();
        let shape = shape(&VehicleBody::CAR, 0, VehicleBody::CAR.length_m, &hubs);
        assert_eq!((shape.scale, shape.wheel_scale, shape.hubs, shape.style), (Vec3::ONE, Vec3::ONE, hubs, None));
    }

    #[test]
    fn people_on_foot_are_about_as_tall_as_sumos_and_make_steps() {
        let models = models();
        let shape = shape(&body(VehicleKind::Pedestrian, 0.215, 0.478, 1.719), 0, 0.215, &car::hubs());
        let first = shape.style.expect("a model of its own") - CAR_STYLES;
        assert_eq!(first, FIRST_WALKER);
        let of = |model: &CarModel| {
            check(&model.levels[0], "pedestrian");
            let (low, high) = model.levels[0].bounds();
            (high - low) * shape.scale
        };
        for number in 0..4 {
            let [standing, walking] = [0.0, 1.4]
                .map(|speed_mps| posture(VehicleKind::Pedestrian, number, 0.0, speed_mps).expect("a person's").model)
                .map(|model| of(&models[first + model]));
            assert!((1.6..1.85).contains(&standing.z) && (0.4..0.7).contains(&standing.y), "{standing}");
            assert!(walking.x > standing.x && standing.x < 0.45, "{standing} {walking}");
        }
    }

    /// Uses the sizes of SUMO's classes (its documentation, "Vehicle Type Parameter Defaults").
    #[test]
    fn every_kind_has_its_nominal_size_and_stands_on_its_wheels() {
        for of in [
            body(VehicleKind::Van, 6.5, 2.16, 2.86),
            body(VehicleKind::Truck, 7.1, 2.4, 2.4),
            body(VehicleKind::Truck, 16.5, 2.55, 4.0),
            body(VehicleKind::Bus, 12.0, 2.5, 3.4),
            body(VehicleKind::Bus, 18.0, 2.5, 3.4),
            body(VehicleKind::Motorcycle, 2.2, 0.9, 1.5),
            body(VehicleKind::Bicycle, 1.6, 0.65, 1.7),
        ] {
            let (mut reach, mut top) = ([f32::INFINITY, f32::NEG_INFINITY], 0.0f32);
            for (k, part) in of.parts(&Pose::default(), None).enumerate() {
                let [low, high] = check_part(&of, k, part.length_m);
                let x = part.pose.position.x as f32;
                reach = [reach[0].min(low.x + x), reach[1].max(high.x + x)];
                top = top.max(high.z);
            }
            let reach = reach[1] - reach[0];
            assert!((reach - of.length_m as f32).abs() < 0.06, "{of:?}: {reach} m long");
            assert!((top - of.height_m as f32).abs() < 0.04, "{of:?}: {top}");
        }
    }

    /// Checks a part's width, wheels and triangles; returns the lowest and the highest corner of the part with its wheels.
    fn check_part(of: &VehicleBody, part: usize, length_m: f64) -> [Vec3; 2] {
        let shape = shape(of, part, length_m, &car::hubs());
        let models = models();
        let model = &models[shape.style.expect("a model of its own") - CAR_STYLES];
        check(&model.levels[0], of.kind.name());
        let (low, high) = model.levels[0].bounds();
        let (low, high) = (low * shape.scale, high * shape.scale);
        let radius = shape.wheel_scale.x * WHEEL_RADIUS_M;
        // SUMO's widths exclude mirrors, which are in the upper half, but include a handlebar.
        let most_z = if shape.hubs[0].y > 0.0 { 0.45 * high.z } else { high.z };
        let corners = model.levels[0].vertices.iter().map(|v| Vec3::from(v.position) * shape.scale);
        let widest = corners.filter(|corner| corner.z <= most_z).map(|corner| corner.y).fold(0.0, f32::max);
        let wide = 2.0 * widest.max(shape.hubs[0].y);
        assert!((-0.06..0.30).contains(&(of.width_m as f32 - wide)), "{of:?}: {wide} m wide");
        for hub in shape.hubs {
            assert!((hub.z - radius).abs() < 1e-5, "{of:?}: a wheel does not touch the road: {hub}");
        }
        assert!(model.levels[0].triangles() < 3000, "{of:?}: {}", model.levels[0].triangles());
        let ends = shape.hubs.map(|hub| hub.x);
        let [front, rear] = [ends[0] + radius, ends[2] - radius];
        [Vec3::new(low.x.min(rear), low.y, low.z), Vec3::new(high.x.max(front), high.y, high.z)]
    }
}
