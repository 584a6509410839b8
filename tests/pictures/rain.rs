//! Tests of rain by numbers: light under clouds, what a wet road mirrors, drops that wipers take from the windscreen, costs. In: scenes of the
//! ring with few vehicles. Out: properties of the pixels and counts.

use super::{
    costs::{BUDGETS, Budget},
    daylight::LUMINANCE,
    pixels::*,
    place::*,
};
use codrive::{
    render::{OFFSCREEN, Quality, Renderer, sky::atmosphere::Sky},
    scene::{Mesh, SprayPuff, StaticScene, Vertex, View, ViewKind, ViewOptions, WiperMotion},
    sim::Snapshot,
    time::Tick,
};
use glam::Vec3;
use image::RgbaImage;

const SIZE: [u32; 2] = [320, 180];

fn rain(rain_mmph: f32, options: ViewOptions) -> ViewOptions {
    ViewOptions { rain_mmph, ..options }
}

#[test]
fn under_rain_clouds_there_is_no_shadow_and_a_tenth_of_the_light() {
    let lux = |time_h: f32, rain_mmph: f32| {
        let view = view(&snapshot(vec![]), ViewKind::Chase, &rain(rain_mmph, ViewOptions::default().at_hour(time_h)));
        let sky = Sky::new(view.to_sun, view.visibility_m, rain_mmph > 0.0);
        [sky.sun * sky.to_shining.z, sky.ambient(Vec3::Z)].map(|light| light.dot(LUMINANCE) / sky.one_lux)
    };
    for time_h in [7.0, 9.75, 12.0] {
        let [sun, clouds] = lux(time_h, 8.0);
        assert!(sun < 0.01 * clouds, "{time_h} h: {sun} lx of the sun, {clouds} lx of the clouds");
        // docs/references.md: fog: 1,000 to 30,000 lx under overcast skies.
        assert!((1000.0..30_000.0).contains(&clouds), "{time_h} h: {clouds} lx");
        let clear = lux(time_h, 0.0).iter().sum::<f32>();
        assert!((0.05..0.30).contains(&(clouds / clear)), "{time_h} h: {clouds} of {clear} lx");
    }
}

/// Number of pixels in a box on the road below vehicle 1, which is magenta and stands 18 m ahead, that have its hue.
fn hue_below(image: &RgbaImage, view: &View) -> usize {
    let pose = on_lane(23.0, 0.0);
    let rear = (pose.position - pose.forward() * 2.5).as_vec2().extend(0.0);
    let left = pose.left().as_vec2().extend(0.0);
    let at = |point: Vec3| {
        let seen = view.camera.project(point, SIZE[0] as f32 / SIZE[1] as f32).expect("in the picture");
        [seen.x * SIZE[0] as f32, seen.y * SIZE[1] as f32]
    };
    // The body of its mirror image lies from 0.3 to 0.9 m below the road.
    let [x0, y0] = at(rear + left * 0.6 - Vec3::Z * 0.35);
    let [x1, y1] = at(rear - left * 0.6 - Vec3::Z * 0.85);
    let is_inside = |[x, y]: &[u32; 2]| (x0..x1).contains(&(*x as f32 + 0.5)) && (y0..y1).contains(&(*y as f32 + 0.5));
    pixels(image, |[r, g, b]| r > g + 0.03 && b > g + 0.03).iter().filter(|at| is_inside(at)).count()
}

#[test]
fn a_wet_road_mirrors_the_vehicle_ahead_and_a_dry_one_does_not() {
    let ahead = snapshot(vec![car(1, on_lane(23.0, 0.0))]);
    let [dry, wet] = [0.0, 8.0].map(|rain_mmph| {
        let mut view = view(&ahead, ViewKind::Driver, &rain(rain_mmph, marked()));
        // Without bonnet and drops before it.
        (view.seat, view.mirror) = (None, None);
        hue_below(&draw(&view, false, SIZE), &view)
    });
    println!("{dry} pixels on the dry road, {wet} on the wet one");
    // Its image is about 17 pixels wide and 7 high; stones break some of it.
    assert!(dry == 0 && wet > 40, "{dry} pixels on the dry road, {wet} on the wet one");
}

#[test]
fn a_wet_road_does_not_show_what_lies_below_it() {
    // Foundations of houses and the feet of posts reach below the ground.
    let mut view = view(&snapshot(vec![]), ViewKind::Driver, &rain(8.0, marked()));
    (view.seat, view.mirror) = (None, None);
    let below = on_lane(18.0, 0.0).position.as_vec2().extend(-1.0);
    let corner = |x: f32, y: f32| Vertex { position: (below + Vec3::new(x, y, 0.0)).into(), ..Default::default() };
    let vertices = vec![corner(-2.0, -2.0), corner(2.0, -2.0), corner(-2.0, 2.0), corner(2.0, 2.0)];
    let slab = Mesh { vertices, indices: vec![0, 1, 2, 1, 3, 2] };
    let [without, with] = [Mesh::default(), slab].map(|posts| {
        let static_scene = StaticScene { posts, ..static_scene(false).clone() };
        draw_with(&mut Renderer::new(gpu(), &static_scene, OFFSCREEN, Quality::LOW), &view, SIZE)
    });
    let other = without.pixels().zip(with.pixels()).filter(|(a, b)| a != b).count();
    assert_eq!(other, 0, "pixels in which the slab is seen");
}

/// Returns the driver's picture at a time in rain, and the number of pixels in which it differs from a picture without windscreen, above the
/// bonnet.
fn drops(rain_mmph: f32, time_s: f64) -> usize {
    let at = Snapshot { tick: Tick((100.0 * time_s).round() as u64), ..snapshot(vec![]) };
    let mut view = view(&at, ViewKind::Driver, &rain(rain_mmph, ViewOptions::default()));
    (view.mirror, view.dial) = (None, None);
    let seen = draw(&view, false, SIZE);
    view.seat = None;
    let free = draw(&view, false, SIZE);
    let above = |y: u32| y < SIZE[1] * 6 / 10;
    seen.enumerate_pixels().filter(|(x, y, pixel)| above(*y) && difference(pixel, free.get_pixel(*x, *y)) > 6).count()
}

#[test]
fn wipers_take_the_drops_from_the_windscreen() {
    const LIGHT_MMPH: f32 = 2.5;
    let motion = WiperMotion::in_rain(LIGHT_MMPH).expect("rain");
    assert!(motion.sweep_s < 0.5 * motion.period_s, "the arms rest between two sweeps");
    // The arms rest at both times; half a minute after the start, so that beside their reach as many drops come as go.
    let start_s = 10.0 * motion.period_s;
    let after = drops(LIGHT_MMPH, start_s + motion.sweep_s + 0.05);
    let before = drops(LIGHT_MMPH, start_s + motion.period_s - 0.05);
    println!("{before} pixels before a sweep, {after} after it");
    // Within their reach 2.7 s of rain have gathered before, 0.05 to 1.4 s after a sweep: a quarter. Beside it there are as many.
    assert!(before > 60 && 2 * after < before, "{before}, then {after}");
    assert!(drops(20.0, start_s + 0.9) > before, "more in heavy rain");
}

#[test]
fn drops_by_night_are_no_darker_than_what_is_behind_them() {
    // A white wall 14 m ahead, which the headlamps light. By day drops show the dark ground upside down.
    let pose = on_lane(19.0, 0.0);
    let (middle, left) = (pose.position.as_vec2().extend(1.5), pose.left().as_vec2().extend(0.0));
    let normal = (-pose.forward()).as_vec2().extend(0.0).to_array();
    let corner = |aside_m: f32, up_m: f32| {
        let position = (middle - left * aside_m + Vec3::Z * up_m).to_array();
        Vertex { position, normal, colour: [0.8; 3], ..Default::default() }
    };
    let vertices = vec![corner(-9.0, -1.5), corner(9.0, -1.5), corner(9.0, 4.5), corner(-9.0, 4.5)];
    let posts = Mesh { vertices, indices: vec![0, 1, 2, 0, 2, 3] };
    let walled = StaticScene { posts, ..static_scene(false).clone() };
    let mut renderer = Renderer::new(gpu(), &walled, OFFSCREEN, Quality::LOW);
    let mut darker = |time_h: f32| {
        let at = Snapshot { tick: Tick(3000), ..snapshot(vec![]) };
        let mut view = view(&at, ViewKind::Driver, &rain(20.0, ViewOptions::default().at_hour(time_h)));
        (view.mirror, view.dial) = (None, None);
        let seen = draw_with(&mut renderer, &view, SIZE);
        view.seat = None;
        let free = draw_with(&mut renderer, &view, SIZE);
        let sum = |pixel: &image::Rgba<u8>| rgb(pixel).iter().sum::<f32>();
        let lower = |(x, y, pixel): &(u32, u32, &image::Rgba<u8>)| {
            *y < SIZE[1] * 6 / 10 && sum(pixel) < sum(free.get_pixel(*x, *y)) - 0.06
        };
        seen.enumerate_pixels().filter(lower).count()
    };
    let [day, night] = [12.0, 22.0].map(&mut darker);
    println!("{day} darker pixels by day, {night} by night");
    assert!(day > 40 && night * 20 < day, "{day} darker pixels by day, {night} by night");
}

#[test]
fn a_picture_in_rain_is_the_same_again_and_keeps_the_budget() {
    let Budget { quality, triangles, .. } = BUDGETS[0];
    let mut renderer = renderer(true, quality);
    let mut fast = full_ring();
    fast.ego.velocity = Vec3::X * 12.0;
    fast.cars.iter_mut().for_each(|car| car.speed_mps = 12.0);
    let [dry, wet] =
        [0.0, 50.0].map(|rain_mmph| view(&fast, ViewKind::Driver, &rain(rain_mmph, ViewOptions::default())));
    assert!(!wet.spray.is_empty());
    let mut drawn = |view: &View| {
        let image = draw_with(&mut renderer, view, SIZE);
        (image, renderer.cost())
    };
    let ((first, _), (between, plain)) = (drawn(&wet), drawn(&dry));
    let ((again, rainy), (dry_again, _)) = (drawn(&wet), drawn(&dry));
    assert!(again == first, "a replay shows the same drops");
    assert!(dry_again == between && first != between);
    println!("{rainy:?}, dry {plain:?}");
    // The strongest rain has the budget of a dry picture. Drops have no bytes; a puff of spray and a mirrored lamp have those of an instance.
    assert!(rainy.total().triangles < triangles, "{rainy:?}");
    let puffs = (wet.spray.len() + wet.mirrored_lamps.len()) as u64;
    assert!(rainy.uploaded_bytes <= plain.uploaded_bytes + 2 * 64 * puffs + 1024, "{rainy:?}, dry {plain:?}");
}

#[test]
fn spray_hides_part_of_what_is_behind_it() {
    let ahead = snapshot(vec![car(1, on_lane(30.0, 0.0))]);
    let mut view = view(&ahead, ViewKind::Driver, &rain(0.1, marked()));
    (view.seat, view.mirror) = (None, None);
    let mut renderer = Renderer::new(gpu(), static_scene(false), OFFSCREEN, Quality::LOW);
    // Sum of the hue of the magenta vehicle.
    let mut hue = |spray: Vec<SprayPuff>| {
        view.spray = spray;
        let image = draw_with(&mut renderer, &view, SIZE);
        image.pixels().map(rgb).map(|[r, g, b]| (r.min(b) - g).max(0.0)).sum::<f32>()
    };
    let between = on_lane(20.0, 0.0).position.as_vec2().extend(0.8);
    let (free, hidden) =
        (hue(vec![]), hue(vec![SprayPuff { position: between, radius_m: 3.0, height_m: 0.8, opacity: 0.9 }]));
    println!("{free}, behind spray {hidden}");
    assert!(free > 50.0 && hidden < 0.8 * free, "{free}, behind spray {hidden}");
    let beyond = on_lane(50.0, 0.0).position.as_vec2().extend(0.8);
    let far = SprayPuff { position: beyond, radius_m: 3.0, height_m: 0.8, opacity: 0.9 };
    assert!(hue(vec![far]) > 0.95 * free, "spray beyond the vehicle does not hide it");
}

#[test]
fn spray_fades_towards_the_road() {
    let mut view = view(&snapshot(vec![]), ViewKind::Driver, &rain(0.1, marked()));
    (view.seat, view.mirror) = (None, None);
    let foot = on_lane(20.0, 0.0).position.as_vec2().extend(0.0);
    let puff = SprayPuff { position: foot + Vec3::Z * 0.5, radius_m: 2.0, height_m: 0.5, opacity: 0.9 };
    let [free, hidden] = [vec![], vec![puff]].map(|spray| {
        view.spray = spray;
        draw(&view, false, SIZE)
    });
    let veil = |up_m: f32| {
        let seen = view.camera.project(foot + Vec3::Z * up_m, SIZE[0] as f32 / SIZE[1] as f32).expect("in the picture");
        let [x, y] = [seen.x * SIZE[0] as f32, seen.y * SIZE[1] as f32].map(|at| at as u32);
        (x - 4..=x + 4).map(|x| u32::from(difference(free.get_pixel(x, y), hidden.get_pixel(x, y)))).sum::<u32>()
    };
    let (at_road, above) = (veil(0.03), veil(0.5));
    println!("{at_road} at the road, {above} above it");
    assert!(above > 100 && at_road * 4 < above, "{at_road} at the road, {above} above it");
}
