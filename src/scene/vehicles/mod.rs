//! Vehicles other than cars: a van, two lorries, a bus, a motorcycle and a bicycle, plain but of their kind's shape. In: kind and size of
//! a vehicle. Out: its model, how the model is stretched to the size, where its wheels and indicators are. Metres, in a body's frame: x forward, y left, z up,
//! origin on the ground under the centre.
//!
//! A model is kept in the size of a car, 5.0 m by 1.8 m by 1.5 m, so that one scale serves all kinds: size over size of the car.

mod boxes;
mod cycles;

use super::{
    CarModel, Mesh,
    car::materials::WHEEL_RADIUS_M,
    mesh::{SurfaceFinish, TriangleList},
};
use crate::traffic::{VehicleBody, VehicleKind};
use glam::Vec3;

/// Number of body styles of cars: models of other kinds follow them in [`StaticScene::cars`](super::StaticScene::cars).
const CAR_STYLES: usize = 3;
/// From this length on a lorry has a trailer, metres.
const TRAILER_M: f64 = 12.0;

/// A kind's model as it was built, at its usual size.
struct Model {
    triangles: TriangleList,
    shape: Shape,
}

/// Where a model's wheels and lamps are, at its usual size.
#[derive(Clone, Copy, Debug)]
struct Shape {
    /// Length, width and height, metres.
    size: Vec3,
    /// Front and rear axle, metres ahead of the centre.
    axles: [f32; 2],
    /// Middle of a wheel to the left of the centre; 0 for vehicles with one track.
    track_half: f32,
    /// Radius and width of a wheel.
    wheel: [f32; 2],
    /// Left front and left rear indicator.
    indicators: [Vec3; 2],
    /// Their radius.
    indicator_radius: f32,
}

/// How a vehicle is drawn: which model, and how it is stretched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct VehicleShape {
    /// Index of its model; of cars the caller chooses.
    pub style: Option<usize>,
    /// Scale of the body.
    pub scale: Vec3,
    /// Scale of a wheel.
    pub wheel_scale: Vec3,
    /// Hubs: front left, front right, rear left, rear right.
    pub hubs: [Vec3; 4],
    /// Indicators on the left: front and rear. Those on the right are their mirror images.
    pub indicators: [Vec3; 2],
    /// Radius of an indicator, metres.
    pub indicator_radius_m: f32,
}

/// The car that all models are kept in the size of.
fn car_size() -> Vec3 {
    let VehicleBody { length_m, width_m, height_m, .. } = VehicleBody::CAR;
    Vec3::new(length_m as f32, width_m as f32, height_m as f32)
}

/// Models of all kinds but the car, in the order of their styles.
pub(super) fn models() -> Vec<CarModel> {
    let built =
        [boxes::van(), boxes::lorry(), boxes::articulated(), boxes::bus(), cycles::motorcycle(), cycles::bicycle()];
    built.into_iter().map(model).collect()
}

fn model(Model { triangles, shape }: Model) -> CarModel {
    let ratio = shape.size / car_size();
    let mut body = triangles.into_mesh(0.7);
    for vertex in &mut body.vertices {
        vertex.position = (Vec3::from(vertex.position) / ratio).into();
        // The renderer turns and stretches a normal as it does a place; this comes out as the model's own.
        vertex.normal = (Vec3::from(vertex.normal) / ratio).normalize_or(Vec3::Z).into();
    }
    let level = || body.clone();
    CarModel {
        levels: [level(), level(), level()],
        glass: [Mesh::default(), Mesh::default()],
        plan: level(),
        shade: body,
    }
}

/// How a vehicle is drawn; `car_hubs` are those of the car's model.
pub(super) fn shape(body: &VehicleBody, car_hubs: &[Vec3; 4]) -> VehicleShape {
    let size = Vec3::new(body.length_m as f32, body.width_m as f32, body.height_m as f32);
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
        VehicleKind::Truck if body.length_m < TRAILER_M => 1,
        VehicleKind::Truck => 2,
        VehicleKind::Bus => 3,
        VehicleKind::Motorcycle => 4,
        VehicleKind::Bicycle => 5,
    };
    let shape = [boxes::VAN, boxes::LORRY, boxes::ARTICULATED, boxes::BUS, cycles::MOTORCYCLE, cycles::BICYCLE][style];
    let stretch = size / shape.size;
    let [radius, width] = shape.wheel;
    // Wheels stay round: they take the radius of their kind, or a smaller one with a lower body.
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

/// A box between two corners.
fn block(triangles: &mut TriangleList, low: [f32; 3], high: [f32; 3], finish: SurfaceFinish) {
    let (low, high) = (Vec3::from(low), Vec3::from(high));
    triangles.cuboid((low + high) / 2.0, (high - low) / 2.0, finish);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{car, mesh::tests::check};

    fn body(kind: VehicleKind, length_m: f64, width_m: f64, height_m: f64) -> VehicleBody {
        VehicleBody { kind, length_m, width_m, height_m }
    }

    #[test]
    fn a_car_of_the_usual_size_is_not_changed_at_all() {
        let hubs = car::hubs();
        let shape = shape(&VehicleBody::CAR, &hubs);
        assert_eq!((shape.scale, shape.wheel_scale, shape.hubs, shape.style), (Vec3::ONE, Vec3::ONE, hubs, None));
    }

    /// Sizes are those of SUMO's classes (its documentation, "Vehicle Type Parameter Defaults").
    #[test]
    fn every_kind_is_as_large_as_it_says_and_stands_on_its_wheels() {
        let models = models();
        for of in [
            body(VehicleKind::Van, 6.5, 2.16, 2.86),
            body(VehicleKind::Truck, 7.1, 2.4, 2.4),
            body(VehicleKind::Truck, 16.5, 2.55, 4.0),
            body(VehicleKind::Bus, 12.0, 2.5, 3.4),
            body(VehicleKind::Motorcycle, 2.2, 0.9, 1.5),
            body(VehicleKind::Bicycle, 1.6, 0.65, 1.7),
        ] {
            let shape = shape(&of, &car::hubs());
            let model = &models[shape.style.expect("a model of its own") - CAR_STYLES];
            check(&model.levels[0], of.kind.name());
            let (low, high) = model.levels[0].bounds();
            let (low, high) = (low * shape.scale, high * shape.scale);
            let radius = shape.wheel_scale.x * WHEEL_RADIUS_M;
            let ends = shape.hubs.map(|hub| hub.x.abs() + radius);
            let reach = high.x.max(ends[0]) - low.x.min(-ends[2]);
            assert!((reach - of.length_m as f32).abs() < 0.06, "{of:?}: {reach} m long, {low} {high}");
            assert!((high.z - of.height_m as f32).abs() < 0.04, "{of:?}: {high}");
            // SUMO's widths are those without mirrors, which stand in the upper half; a handlebar counts.
            let most_z = if shape.hubs[0].y > 0.0 { 0.45 * high.z } else { high.z };
            let corners = model.levels[0].vertices.iter().map(|v| Vec3::from(v.position) * shape.scale);
            let widest = corners.filter(|corner| corner.z <= most_z).map(|corner| corner.y).fold(0.0, f32::max);
            let wide = 2.0 * widest.max(shape.hubs[0].y);
            assert!((-0.06..0.30).contains(&(of.width_m as f32 - wide)), "{of:?}: {wide} m wide");
            for hub in shape.hubs {
                assert!((hub.z - radius).abs() < 1e-5, "{of:?}: a wheel does not touch the road: {hub}");
            }
            assert!(model.levels[0].triangles() < 3000, "{of:?}: {}", model.levels[0].triangles());
        }
    }
}
