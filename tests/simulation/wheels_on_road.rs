//! Wheels on the drawn road. In: drives over all shipped maps, the networks of the tests and closed routes with heights. Out: every wheel of
//! the ego and of the vehicles around it stands on the road as the picture draws it.

use codrive::{
    drive_loop::offline::OfflineDrive,
    map::SHIPPED,
    scenario::{DisplaySettings, Scenario},
    scene::{self, CarInstance, Mesh, StaticScene, ViewKind, ViewOptions},
};
use glam::{Vec2, Vec3};
use std::collections::BTreeMap;

/// Largest distance of a wheel from the drawn road, metres: a tyre's deflection under load is 2 to 3 cm, and a gap of the width of a
/// finger is not seen under a car.
const MOST_M: f32 = 0.05;
/// Radius of a car's wheel, metres: that of the model.
const WHEEL_RADIUS_M: f32 = 0.33;
/// Side of a cell of the search, metres.
const CELL_M: f32 = 5.0;

/// Triangles of the road by cells on the ground.
struct DrawnRoad {
    cells: BTreeMap<[i32; 2], Vec<[Vec3; 3]>>,
}

impl DrawnRoad {
    fn new(road: &Mesh) -> Self {
        let mut cells: BTreeMap<[i32; 2], Vec<[Vec3; 3]>> = BTreeMap::new();
        for corners in road.indices.chunks(3) {
            let corners: [Vec3; 3] = std::array::from_fn(|k| road.vertices[corners[k] as usize].position.into());
            let flat = corners.map(|corner| corner.truncate() / CELL_M);
            let low = flat.into_iter().reduce(Vec2::min).unwrap_or_default().floor().as_ivec2();
            let high = flat.into_iter().reduce(Vec2::max).unwrap_or_default().floor().as_ivec2();
            for (x, y) in (low.x..=high.x).flat_map(|x| (low.y..=high.y).map(move |y| (x, y))) {
                cells.entry([x, y]).or_default().push(corners);
            }
        }
        Self { cells }
    }

    /// Returns the height of the surface nearest to a point, on the ground's vertical through it; `None` beside all surfaces.
    fn height_m(&self, point: Vec3) -> Option<f32> {
        let cell = (point.truncate() / CELL_M).floor().as_ivec2().to_array();
        let heights = self.cells.get(&cell)?.iter().filter_map(|[a, b, c]| {
            let [ab, ac, ap] = [*b - *a, *c - *a, point - *a].map(Vec3::truncate);
            let area = ab.perp_dot(ac);
            // Seen from above, counter-clockwise; walls and undersides are no road.
            (area > 1e-9).then_some(())?;
            let (v, w) = (ap.perp_dot(ac) / area, ab.perp_dot(ap) / area);
            let is_inside = v >= 0.0 && w >= 0.0 && v + w <= 1.0;
            is_inside.then_some(a.z + v * (b.z - a.z) + w * (c.z - a.z))
        });
        heights.min_by(|a, b| (a - point.z).abs().total_cmp(&(b - point.z).abs()))
    }
}

/// Returns the places where a car's tyres touch the ground.
fn contacts(car: &CarInstance) -> [Vec3; 4] {
    car.hubs.map(|hub| car.position + car.rotation * (hub - Vec3::Z * WHEEL_RADIUS_M * car.wheel_scale.z))
}

#[test]
fn every_wheel_stands_on_the_drawn_road() {
    let _alone = super::world::one_at_a_time();
    let networks =
        ["allway", "crossing", "grid-signals", "hill", "one-way", "ramps", "roundabout", "spider", "town", "town-left"];
    let networks = networks.map(|name| format!("tests/data/networks/{name}.net.xml"));
    let heights = ["loop", "hill"].map(|name| format!("tests/data/heights/{name}.net.xml"));
    let maps = SHIPPED.map(str::to_owned).into_iter().chain(networks).chain(heights);
    for map in maps {
        let scenario = Scenario {
            map: map.clone(),
            vehicles: 8,
            duration_s: 40.0,
            display: DisplaySettings { trees: 0, ..DisplaySettings::default() },
            ..Scenario::default()
        };
        let mut run = OfflineDrive::new(&scenario, [0.0, 40.0]).unwrap_or_else(|e| panic!("{map}: {e}"));
        let static_scene = StaticScene::with_trees(run.world().map(), 1, 0);
        let road = DrawnRoad::new(&static_scene.road);
        let (mut worst, mut wheels) = ((0.0f32, String::new()), 0);
        while run.world().ended().is_none() {
            let next_s = run.world().time_s() + 1.0;
            run.until(next_s).unwrap_or_else(|e| panic!("{map}: {e}"));
            let view =
                scene::view(run.world().snapshot(), 1.0, ViewKind::Chase, &ViewOptions::default(), &static_scene);
            for (k, car) in view.cars.iter().enumerate() {
                for contact in contacts(car) {
                    // A wheel beside the asphalt, as on a verge in a tight turn, is on no road.
                    let Some(road_m) = road.height_m(contact) else { continue };
                    wheels += 1;
                    let off_m = (contact.z - road_m).abs();
                    if off_m > worst.0 {
                        worst = (
                            off_m,
                            format!("vehicle {k} at {contact}, {:.1} s: road at {road_m}", run.world().time_s()),
                        );
                    }
                }
            }
        }
        println!("{map}: {wheels} wheels, at most {:.3} m off", worst.0);
        assert!(wheels >= 4 * 30, "{map}: only {wheels} wheels were on a road");
        assert!(worst.0 <= MOST_M, "{map}: {} m: {}", worst.0, worst.1);
    }
}
