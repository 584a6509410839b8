//! Tests of the places of cars in the picture: ahead, in the mirror, from above.

use crate::{pixels::*, place::*};
use codrive::{
    render::{OFFSCREEN, Quality, Renderer, dial::DialPlace, post::tonemap::mirror_rect, view_projection::ViewFrustum},
    scenario::CockpitView,
    scene::{self, BONNET_EDGE, Camera, CarModel, Lens, Mesh, StaticScene, ViewKind, ViewOptions},
    space::Pose,
    traffic::EGO,
};
use glam::{Vec2, Vec3};
use image::RgbaImage;
use std::{collections::BTreeMap, sync::Arc};

const SIZE: [u32; 2] = [320, 180];
const ASPECT: f32 = 320.0 / 180.0;

/// Returns the region of the picture that holds the projected box of a car, widened by 2 to 3 pixels.
fn expected(camera: &Camera, pose: &Pose) -> Region {
    let mut found = [f32::MAX, f32::MAX, f32::MIN, f32::MIN];
    for corner in corners(pose) {
        let at = camera.project(corner, ASPECT).expect("in front of the camera");
        let [x, y] = [at.x * SIZE[0] as f32, at.y * SIZE[1] as f32];
        found = [found[0].min(x), found[1].min(y), found[2].max(x), found[3].max(y)];
    }
    // One pixel for partly covered edges, and one for the edge filter.
    [found[0] - 2.0, found[1] - 2.0, found[2] + 3.0, found[3] + 3.0].map(|v| v.max(0.0) as u32)
}

#[test]
fn the_leader_is_where_its_gap_says_and_grows_as_the_gap_shrinks() {
    let mut before = 0;
    for gap_m in [20.0, 12.0, 6.0, 2.0] {
        let leader = on_lane(gap_m + 5.0, 0.0);
        let view = view(&snapshot(vec![car(1, leader)]), ViewKind::Driver, &marked());
        let image = draw(&view, false, SIZE);
        let seen = pixels(&image, is_magenta);
        let region = expected(&view.camera, &leader);
        let strays: Vec<_> = seen.iter().filter(|p| !inside(region, **p)).collect();
        assert!(strays.is_empty(), "gap {gap_m} m: magenta at {strays:?}, expected only in {region:?}");
        let area = (region[2] - region[0]) * (region[3] - region[1]);
        assert!(seen.len() as u32 > area / 5, "gap {gap_m} m: {} pixels of a box of {area}", seen.len());
        assert!(seen.len() > before, "gap {gap_m} m: {} pixels, {before} at a larger gap", seen.len());
        before = seen.len();
        let [x, y] = centroid(&image, &seen);
        let middle = view.camera.project(leader.position.as_vec2().extend(0.75), ASPECT).expect("in front");
        assert!((x - middle.x).abs() < 0.05 && (y - middle.y).abs() < 0.10, "gap {gap_m} m: {x} {y}, not {middle}");
    }
}

#[test]
fn a_car_behind_shows_only_in_the_mirror_and_on_its_own_side() {
    let [left, top, width, height] = mirror_rect(SIZE);
    let inset = [left, top, left + width, top + height];
    for left_m in [1.3, -1.3] {
        let ego = on_lane(0.0, 0.0);
        let follower = Pose::new(ego.rear(5.0) - ego.forward() * 9.5 + ego.left() * left_m, ego.yaw_rad);
        let snapshot = snapshot(vec![car(1, follower)]);
        let driver = view(&snapshot, ViewKind::Driver, &marked());
        let image = draw(&driver, false, SIZE);
        let seen = pixels(&image, is_magenta);
        assert!(seen.len() > 40, "{} pixels", seen.len());
        assert!(seen.iter().all(|p| inside(inset, *p)), "magenta outside of the mirror");
        // A mirror keeps left on the left.
        let x = (centroid(&image, &seen)[0] * SIZE[0] as f32 - left as f32) / width as f32;
        assert!((x < 0.5) == (left_m > 0.0), "{left_m} m to the left appears at {x} of the mirror's width");

        let alone = view(&snapshot, ViewKind::Mirror, &marked());
        let image = draw(&alone, false, SIZE);
        let seen = pixels(&image, is_magenta);
        let [x, _] = centroid(&image, &seen);
        let middle = alone.camera.project(follower.position.as_vec2().extend(0.75), ASPECT).expect("behind the car");
        assert!((x - (1.0 - middle.x)).abs() < 0.05, "at {x}; the camera, unflipped, has it at {}", middle.x);
    }
}

#[test]
fn the_ego_is_seen_from_outside_only() {
    let snapshot = full_ring();
    for kind in [ViewKind::Driver, ViewKind::Mirror, ViewKind::Chase, ViewKind::Birdseye] {
        let options = ViewOptions { cockpit: CockpitView::Off, ..marked_ego() };
        let image = draw(&view(&snapshot, kind, &options), true, SIZE);
        let seen = pixels(&image, is_magenta).len();
        let outside = matches!(kind, ViewKind::Chase | ViewKind::Birdseye);
        assert!(if outside { seen > 10 } else { seen == 0 }, "{kind:?}: {seen} pixels");
    }
}

#[test]
fn the_driver_sees_the_bonnet_of_the_ego_at_the_lower_edge() {
    let image = draw(&view(&full_ring(), ViewKind::Driver, &marked_ego()), true, SIZE);
    let seen = pixels(&image, is_magenta);
    assert!(seen.len() > 500, "{} pixels", seen.len());
    // The bonnet's edge is 9 degrees below the horizon, which is 24 % of the picture's height.
    let highest = seen.iter().map(|p| p[1]).min().unwrap_or(0);
    assert!((0.68..0.82).contains(&(highest as f32 / SIZE[1] as f32)), "row {highest}");
}

#[test]
fn the_bonnet_stays_red_towards_a_low_sun() {
    let snapshot = snapshot(Vec::new());
    let evening = ViewOptions::default().at_hour(17.2);
    let ahead_deg = 90.0 - on_lane(0.0, 0.0).yaw_rad.to_degrees() as f32;
    for aside_deg in [-35.0, -12.0, 20.0] {
        let options = ViewOptions { sun_azimuth_deg: ahead_deg + aside_deg, ..evening.clone() };
        let worn = |paint: Option<[f32; 3]>| {
            let mut options = options.clone();
            options.paint_overrides.extend(paint.map(|paint| (EGO, paint)));
            draw(&view(&snapshot, ViewKind::Driver, &options), false, SIZE)
        };
        let [red, black, white] = [None, Some([0.0; 3]), Some([0.8; 3])].map(worn);
        // The bonnet is the set of pixels that its paint changes. Pixels at its edge are left out, as they are partly road.
        let painted = |[x, y]: [u32; 2]| difference(black.get_pixel(x, y), white.get_pixel(x, y)) > 40;
        let inner = |x: u32, y: u32| {
            let around = [[x, y], [x - 1, y], [x + 1, y], [x, y - 1], [x, y + 1]];
            around.into_iter().all(painted)
        };
        let all =
            red.enumerate_pixels().filter(|(x, y, _)| (1..SIZE[0] - 1).contains(x) && (1..SIZE[1] - 1).contains(y));
        let sheet: Vec<[f32; 3]> = all.filter(|(x, y, _)| inner(*x, *y)).map(|(.., p)| rgb(p)).collect();
        let pale = sheet.iter().filter(|[r, g, b]| g.max(*b) > 0.72 * r).count();
        let mean = sheet.iter().map(|[r, g, b]| g.max(*b) / r).sum::<f32>() / sheet.len() as f32;
        println!("sun {aside_deg} degrees aside: {pale} of {} pale, green over red {mean}", sheet.len());
        // A twentieth is allowed for the sun's reflection, half a degree wide, with its halo. The rest of a red bonnet must be red.
        assert!(pale * 20 < sheet.len() && mean < 0.5, "sun {aside_deg}: {pale} of {} pale, mean {mean}", sheet.len());
    }
}

#[test]
fn the_birds_eye_view_shows_one_red_and_21_green_cars_at_their_places() {
    const PLAN: [u32; 2] = [480, 300];
    let mut snapshot = full_ring();
    // A lit brake lamp would be as red as the ego.
    snapshot.cars.iter_mut().for_each(|car| car.lamps.brake = false);
    let view = view(&snapshot, ViewKind::Birdseye, &Default::default());
    let image = draw(&view, true, PLAN);
    // Only pixels on the road count: some trees are as green as the cars.
    let on_road = |[x, y]: &[u32; 2]| {
        let place = Vec2::new((*x as f32 + 0.5) / PLAN[0] as f32, (*y as f32 + 0.5) / PLAN[1] as f32);
        let (start, _) = view.camera.ray(place, PLAN[0] as f32 / PLAN[1] as f32);
        let middle = map().route.project(start.truncate().as_dvec2(), None);
        middle.offset_m.abs() < 2.0
    };
    let seen = |is: fn([f32; 3]) -> bool| pixels(&image, is).into_iter().filter(on_road).collect::<Vec<_>>();
    // Windows split a car's paint by up to 2 m, 6 pixels; cars are 6 m apart.
    let red = blobs(&seen(is_red), 8.0);
    let green = blobs(&seen(is_car_green), 8.0);
    assert_eq!((red.len(), green.len()), (1, 21));
    let place = |centre: Vec3| {
        let at = view.camera.project(centre, PLAN[0] as f32 / PLAN[1] as f32).expect("in the picture");
        [at.x * PLAN[0] as f32, at.y * PLAN[1] as f32]
    };
    let shown = |blobs: &[Vec<[u32; 2]>], at: [f32; 2]| {
        let hits = blobs.iter().filter(|blob| {
            let [x, y] = centroid(&image, blob);
            (x * PLAN[0] as f32 - at[0]).hypot(y * PLAN[1] as f32 - at[1]) < 2.5
        });
        hits.count() == 1
    };
    assert!(shown(&red, place(snapshot.ego.position.as_vec3())), "the ego is not at its place");
    for car in &snapshot.cars {
        assert!(shown(&green, place(car.pose.position.as_vec2().extend(0.7))), "car {:?} is not at its place", car.id);
    }
}

#[test]
fn every_level_of_quality_shows_a_car_at_the_same_place() {
    let levels = [Quality::LOW, Quality::MEDIUM, Quality::HIGH];
    // The size is large enough for the low level to draw a smaller picture and scale it up.
    let size = [960, 540];
    assert!(Quality::LOW.drawn_size(size, false)[0] < size[0]);
    let mut renderers = levels.map(|quality| renderer(false, quality));
    for (gap_m, left_m) in [(8.0, 0.0), (25.0, 0.7)] {
        let leader = on_lane(gap_m + 5.0, left_m);
        let mut view = view(&snapshot(vec![car(1, leader)]), ViewKind::Driver, &marked());
        // The bonnet is left out: its red paint looks magenta where it mirrors the blue sky.
        view.seat = None;
        let places = renderers.each_mut().map(|renderer| {
            let image = draw_with(renderer, &view, size);
            // Weights by the share of magenta in a pixel. A threshold would favour the sunny side of the car.
            let magenta = |p| {
                let [r, g, b] = rgb(p).map(|v| v * v);
                (r.min(b) - 1.2 * g).max(0.0)
            };
            let weighed =
                image.enumerate_pixels().map(|(x, y, p)| Vec2::new(x as f32, y as f32).extend(1.0) * magenta(p));
            let sum: Vec3 = weighed.sum();
            assert!(sum.z > 10.0, "{sum}");
            sum.truncate() / sum.z
        });
        for place in &places[1..] {
            assert!(place.distance(places[0]) < 0.5, "gap {gap_m} m: {places:?}");
        }
    }
}

/// Returns the styles whose colours are compared: all vehicles, and people in three postures: standing, at the first phase, and at the fourth, with the
/// limbs of the other side in front.
fn compared_styles(cars: &[CarModel]) -> Vec<usize> {
    let is_compared =
        |style: &usize| cars[*style].postures.is_none_or(|[_, standing]| [0, 1, 4].contains(&(style - standing)));
    (0..cars.len()).filter(is_compared).collect()
}

/// Returns the mean colour of the pixels that differ by a car: red, green and blue from 0 to 1, as on the screen.
fn mean_colour(with: &RgbaImage, without: &RgbaImage) -> Vec3 {
    let (mut count, mut sum) = (0.0, Vec3::ZERO);
    for (a, _) in with.pixels().zip(without.pixels()).filter(|(a, b)| difference(a, b) > 3) {
        count += 1.0;
        sum += Vec3::from(rgb(a));
    }
    assert!(count > 500.0, "{count} pixels of a car");
    sum / count
}

#[test]
fn a_body_has_one_colour_on_both_sides_of_a_switch_of_detail() {
    // Largest steps of colour, as a share of the scale, by switch. Both are above the threshold of vision. A car of 36 pixels is two
    // degrees wide in front of a television; for a patch of that size, the eye notices a sudden change of 1 to 2 % in luminance (Weber's
    // fraction by daylight), at middle grey 0.003 of this scale. Levels of cars change at once, while those of trees blend. Far bodies have
    // fewer corners, hence broader glints, and opaque windows. Until they blend, these bounds limit the step: 0.02 where a car is large,
    // and 0.05, as for trees, where it is 40 pixels high.
    const MOST: [f32; 2] = [0.02, 0.05];
    // The background is meadow and road, visible through the windows.
    let bare = StaticScene { posts: Mesh::default(), tuft_places: Vec::new(), ..static_scene(false).clone() };
    let mut drawing = Renderer::new(gpu(), &bare, OFFSCREEN, Quality { msaa: 4, fine: true, ..Quality::LOW });
    let pose = on_lane(40.0, 0.0);
    let mut worst = [0.0f32; 2];
    let mut empty: BTreeMap<(u32, usize), RgbaImage> = BTreeMap::new();
    for style in compared_styles(&bare.cars) {
        // Near to mid and mid to far (`FITTED_PX` and `MID_PX` in `level_of_detail.rs`), from six directions, with brake lamps lit and
        // unlit.
        let [near, mid, far] = &bare.cars[style].levels;
        // Bodies of people and of other vehicles than cars are the same on both sides of a switch, or of both.
        let switches = [(100.0, near, mid), (36.0, mid, far)].into_iter().filter(|(_, a, b)| !Arc::ptr_eq(a, b));
        for (switch_px, k) in switches.flat_map(|(px, ..)| (0..6).map(move |k| (px, k))) {
            let paint = [[0.72, 0.72, 0.70], [0.479, 0.008, 0.006], [0.115, 0.120, 0.130]][k % 3];
            let (sin, cos) = (std::f32::consts::TAU * (k as f32 + 0.3) / 6.0).sin_cos();
            let forward = Vec3::new(cos, sin, -0.10 - 0.03 * k as f32).normalize();
            let mut colour = |radius_px: f32| {
                let mut view = view(&snapshot(vec![car(1, pose)]), ViewKind::Chase, &ViewOptions::default());
                view.cars.retain(|car| !car.is_ego);
                let at = view.cars[0].position;
                let camera = |distance_m: f32| Camera {
                    eye: at - forward * distance_m,
                    forward,
                    up: Vec3::Z,
                    lens: Lens::Perspective { fov_x_rad: 0.8 },
                };
                // The length that stands for a car in the choice of its level, 1.9 m.
                let at_1_m = ViewFrustum::new(&camera(1.0), SIZE).pixels(at, 1.9);
                view.camera = camera(at_1_m / radius_px);
                (view.cars[0].style, view.cars[0].colour, view.cars[0].brake) = (style, paint, (k % 2) as f32);
                // A person is in the posture of its model alone.
                view.cars[0].plate = if bare.cars[style].postures.is_some() { 0 } else { view.cars[0].plate };
                let with = draw_with(&mut drawing, &view, SIZE);
                view.cars.clear();
                let without =
                    empty.entry((radius_px.to_bits(), k)).or_insert_with(|| draw_with(&mut drawing, &view, SIZE));
                mean_colour(&with, without)
            };
            let (finer, coarser) = (colour(switch_px * 1.01), colour(switch_px * 0.99));
            let step = (finer - coarser).abs().max_element();
            let switch = usize::from(switch_px < 50.0);
            worst[switch] = worst[switch].max(step);
            println!("style {style}, {switch_px} px, way {k}: {finer:.3} {coarser:.3}: {step:.4}");
        }
    }
    assert!(worst[0] < MOST[0] && worst[1] < MOST[1], "steps of {worst:?} at the two switches");
}

/// Returns a drive with a magenta follower, 9.5 m behind the middle of the ego.
fn followed() -> codrive::sim::Snapshot {
    let ego = on_lane(0.0, 0.0);
    snapshot(vec![car(1, Pose::new(ego.rear(5.0) - ego.forward() * 9.5, ego.yaw_rad))])
}

#[test]
fn the_flat_mirror_shows_the_rear_view_flipped() {
    let mirror = view(&followed(), ViewKind::Mirror, &marked());
    // The same camera without a mirror: a driver's view that looks back, without the ego's own body.
    let rear = scene::View { kind: ViewKind::Driver, mirror: None, seat: None, ..mirror.clone() };
    // At the low level a mirror is drawn with fewer pixels than are shown. The rear view is drawn with as few.
    let drawn = Quality::LOW.drawn_size(SIZE, true);
    assert!(drawn[0] < SIZE[0]);
    let as_fine = Quality { most_pixels: drawn[0] * drawn[1], ..Quality::LOW };
    assert_eq!(as_fine.drawn_size(SIZE, false), drawn);
    for (low, same) in [(Quality::LOW, as_fine), (Quality { mirror_scale: 1.0, ..Quality::LOW }, Quality::LOW)] {
        let mirror = draw_with(&mut renderer(true, low), &mirror, SIZE);
        let rear = draw_with(&mut renderer(true, same), &rear, SIZE);
        let flipped = image::imageops::flip_horizontal(&rear);
        // Two steps of 255: rounding, and the dither noise, which is not flipped.
        let most = mirror.pixels().zip(flipped.pixels()).map(|(a, b)| difference(a, b)).max().unwrap_or(255);
        assert!(most <= 2, "{most}, mirror's scale {}", low.mirror_scale);
        assert!(rear != flipped, "a picture that is its own mirror image proves nothing");
    }
}

#[test]
fn a_convex_mirror_shrinks_the_follower_as_its_radius_says() {
    let seen = |radius_m: f32| {
        let mut options = marked();
        options.mirror.radius_m = radius_m;
        options.mirror.pitch_deg = -4.0;
        let image = draw(&view(&followed(), ViewKind::Mirror, &options), false, [640, 360]);
        (pixels(&image, is_magenta).len() as f32, options.mirror.bend(options.eye))
    };
    let (flat, _) = seen(0.0);
    for radius_m in [1.2, 2.4] {
        let (convex, bend) = seen(radius_m);
        // A convex mirror shrinks distant things by 1 + 2 d / R in both directions, and slightly more off its centre.
        let expected = (1.0 + 2.0 * bend).powi(-2);
        let ratio = convex / flat;
        assert!((0.80 * expected..1.10 * expected).contains(&ratio), "R {radius_m}: {ratio}, not {expected}");
    }
}

#[test]
fn at_60_m_brake_lamps_are_far_brighter_than_running_lamps() {
    let size = [1280, 720];
    let mut drawing = renderer(false, Quality { msaa: 4, ..Quality::LOW });
    // The vehicle is straight ahead of the camera and seen from behind, whatever the course of the road.
    let mut light = |braking: bool, level_gap_m: f64| {
        let ego = on_lane(0.0, 0.0);
        let pose = Pose::new(ego.position + ego.forward() * (5.0 + level_gap_m), ego.yaw_rad);
        let mut leader = car(1, pose);
        leader.lamps.brake = braking;
        let mut options = ViewOptions { cockpit: CockpitView::Off, ..Default::default() };
        options.paint_overrides.insert(leader.id, [0.03; 3]);
        let view = view(&snapshot(vec![leader]), ViewKind::Driver, &options);
        let image = draw_with(&mut drawing, &view, size);
        let at = pose.rear(5.0).as_vec2();
        let left = pose.left().as_vec2();
        let lamp = |side: f32| {
            let point = (at + left * (0.66 * side)).extend(0.82);
            let place = view.camera.project(point, size[0] as f32 / size[1] as f32).expect("ahead");
            let [x, y] = [place.x * size[0] as f32, place.y * size[1] as f32];
            // The brightest red of the few pixels that a lamp covers.
            let (xs, ys) = (x as u32 - 3..x as u32 + 4, y as u32 - 2..y as u32 + 3);
            let red = xs.flat_map(|x| ys.clone().map(move |y| (x, y))).map(|(x, y)| {
                let [r, g, _] = rgb(image.get_pixel(x, y)).map(|v| v.powf(2.2));
                r - g
            });
            red.fold(0.0, f32::max)
        };
        lamp(-1.0).min(lamp(1.0))
    };
    let (running, braking) = (light(false, 60.0), light(true, 60.0));
    // One step of 255 of the screen: a dimmer lamp would be invisible.
    assert!(running > 0.004, "running lamps can be seen: {running}");
    // UN Regulation 148, 01 series (2022; Regulation 7 before), paragraph 4.8.3.5: where one lamp is rear position and stop lamp, both
    // together are at least five times as bright as the position lamp alone.
    assert!(braking > 5.0 * running, "{braking} braking, {running} running, in linear red above green");
}

/// Checks leaders at gaps of 2 m and more, in four aspect ratios.
#[test]
fn the_speedometer_hides_nothing_of_a_leader_at_any_gap() {
    // 21:9, 16:9, 16:10 and 4:3.
    for size in [[2520, 1080], [1920, 1080], [1280, 720], [640, 360], [1920, 1200], [1024, 768]] {
        let aspect = size[0] as f32 / size[1] as f32;
        for cockpit in [CockpitView::Off, CockpitView::Bonnet] {
            let options = ViewOptions { cockpit, ..Default::default() };
            // One car number for each style, and offsets from the centre of the lane.
            for (id, gap_m, left_m) in [0, 1, 3].into_iter().flat_map(|id| {
                let gaps = [2.0, 2.5, 4.0, 8.0, 15.0, 40.0];
                gaps.into_iter().flat_map(move |gap_m| [-0.2, 0.0, 0.4].map(|left_m| (7 + id, gap_m, left_m)))
            }) {
                let view = view(&snapshot(vec![car(id, on_lane(gap_m + 5.0, left_m))]), ViewKind::Driver, &options);
                let place = DialPlace::of(&view, size).rect(size);
                let leader = view.cars[1];
                let [near, ..] = &static_scene(false).cars[leader.style].levels;
                let body = near.vertices.iter().map(|v| Vec3::from(v.position));
                let wheels = leader.hubs.iter().map(|hub| *hub - Vec3::Z * hub.z);
                for point in body.chain(wheels) {
                    let point = leader.position + leader.rotation * point;
                    let from_eye = view.cars[0].rotation.inverse() * (point - view.camera.eye);
                    // The bonnet hides points below its edge.
                    if view.seat.is_some() && from_eye.z < -BONNET_EDGE * from_eye.x {
                        continue;
                    }
                    let Some(at) = view.camera.project(point, aspect) else { continue };
                    let at = egui::pos2(at.x * size[0] as f32, at.y * size[1] as f32);
                    let reach = 0.5 * place.width();
                    assert!(
                        at.distance(place.center()) >= reach,
                        "{size:?}, {cockpit:?}, style {}, gap {gap_m} m, {left_m} m to the left: {at} in {place}",
                        leader.style
                    );
                }
            }
        }
    }
}
