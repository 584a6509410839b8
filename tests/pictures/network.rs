//! Tests of pictures of road networks by their pixels: lanes, junctions, signals and vehicles are where the network's file says. Points are
//! chosen by hand from `tests/data/networks/grid-signals.net.xml`. The centre of its crossing B1 is at (90, 90). The street A1B1 leads to
//! it from the west in two lanes of 3.2 m, with centre lines at y = 85.2 and 88.4 from x = 10.4 to 79.6.

use crate::{
    pixels::*,
    place::{self, MAGENTA, gpu},
};
use codrive::{
    map::{
        RoadMap,
        network::{LaneId, Network, SignalId, SignalStates},
    },
    render::{OFFSCREEN, Quality, Renderer, render_to_image},
    roadside::LazyRoadside,
    scenario::{DisplaySettings, GuidanceView, Scenario},
    scene::{self, Camera, Lens, Mesh, SignalHead, StaticScene, View, ViewKind, ViewOptions},
    sim::{Snapshot, VehicleSnapshot},
    space::Pose,
    traffic::{VehicleBody, VehicleId, VehicleKind, VehicleLamps},
};
use glam::{DVec2, Vec2, Vec3};
use image::RgbaImage;
use std::{
    path::Path,
    process::Command,
    sync::{Arc, Mutex, OnceLock},
};

fn network() -> &'static Arc<Network> {
    static NETWORK: OnceLock<Arc<Network>> = OnceLock::new();
    NETWORK.get_or_init(|| {
        let file = "tests/data/networks/grid-signals.net.xml";
        Arc::new(Network::load(file).unwrap_or_else(|e| panic!("{e}")))
    })
}

/// Returns the grid without trees and buildings, which would hide parts of it.
fn static_scene() -> &'static StaticScene {
    static STAGE: OnceLock<StaticScene> = OnceLock::new();
    STAGE.get_or_init(|| StaticScene { buildings: Mesh::default(), ..StaticScene::of_network(network(), 1, 0) })
}

fn draw(view: &View, size: [u32; 2]) -> RgbaImage {
    static RENDERER: OnceLock<Mutex<Renderer>> = OnceLock::new();
    let renderer = RENDERER.get_or_init(|| Mutex::new(Renderer::new(gpu(), static_scene(), OFFSCREEN, Quality::LOW)));
    let mut renderer = renderer.lock().unwrap_or_else(|e| e.into_inner());
    render_to_image(gpu(), &mut renderer, view, size).unwrap_or_else(|e| panic!("{e}"))
}

/// Returns a view from a camera, without the ego.
fn view(snapshot: &Snapshot, kind: ViewKind, camera: Camera) -> View {
    let mut view = scene::view(snapshot, 1.0, kind, &ViewOptions::default(), static_scene());
    view.cars.remove(0);
    view.camera = camera;
    view
}

/// Returns a view of 60 m by 60 m around the crossing from above.
fn from_above() -> View {
    let eye = Vec3::new(90.0, 90.0, 400.0);
    let lens = Lens::Parallel { half_extent_m: 30.0 };
    view(&Snapshot::default(), ViewKind::Birdseye, Camera { eye, forward: Vec3::NEG_Z, up: Vec3::Y, lens })
}

/// Draws that view, 10 pixels per metre.
fn plan() -> &'static RgbaImage {
    static PLAN: OnceLock<RgbaImage> = OnceLock::new();
    PLAN.get_or_init(|| draw(&from_above(), [600, 600]))
}

/// Returns the mean colour of 0.5 m by 0.5 m of the plan.
fn ground(at: Vec2) -> [f32; 3] {
    let pixel = ((at - Vec2::new(60.0, 120.0)) * Vec2::new(10.0, -10.0)).as_ivec2();
    let mut sum = [0.0; 3];
    for (dx, dy) in (-2..=2).flat_map(|dx| (-2..=2).map(move |dy| (dx, dy))) {
        let colour = rgb(plan().get_pixel((pixel.x + dx) as u32, (pixel.y + dy) as u32));
        (0..3).for_each(|k| sum[k] += colour[k] / 25.0);
    }
    sum
}

fn is_grass([r, g, b]: [f32; 3]) -> bool {
    g > 0.97 * r && g > 1.45 * b
}

/// Checks for a grey that is darker than paint.
fn is_asphalt([r, g, b]: [f32; 3]) -> bool {
    r.max(g).max(b) < 1.18 * r.min(g).min(b) && g < 0.62
}

fn is_paint([r, g, b]: [f32; 3]) -> bool {
    r.max(g).max(b) < 1.25 * r.min(g).min(b) && g > 0.62
}

#[test]
fn lanes_and_junctions_have_asphalt_and_all_else_grass() {
    // Lanes of all four streets, some metres from the crossing; its centre, its corners, and its borders with the lanes.
    for (x, y) in [
        (65.0, 85.2),
        (65.0, 88.4),
        (65.0, 91.6),
        (65.0, 94.8),
        (115.0, 85.2),
        (115.0, 94.8),
        (85.2, 65.0),
        (94.8, 65.0),
        (88.4, 112.0),
        (94.8, 115.0),
        (90.0, 90.0),
        (84.5, 84.5),
        (95.5, 95.5),
        (80.2, 90.7),
        (99.8, 88.0),
        (90.8, 80.2),
        (89.0, 99.8),
    ] {
        let seen = ground(Vec2::new(x, y));
        assert!(is_asphalt(seen), "({x}, {y}) is no asphalt: {seen:?}");
    }
    // The four meadows between the streets: 5 m beside a lane, 4 m from the crossing's corners (arcs of 4 m radius), and further out.
    for (x, y) in
        [(65.0, 78.5), (65.0, 101.5), (78.5, 65.0), (101.5, 112.0), (77.5, 77.5), (102.5, 102.5), (70.0, 108.0)]
    {
        let seen = ground(Vec2::new(x, y));
        assert!(is_grass(seen), "({x}, {y}) is no grass: {seen:?}");
    }
}

#[test]
fn a_road_outside_towns_has_a_line_at_its_edge() {
    // 10 m of the ring from above, 20 pixels per metre. The lane is 3.6 m wide, so that the middle of its line of 12 cm is at 1.86 m.
    let mut view = place::view(&place::snapshot(Vec::new()), ViewKind::Birdseye, &ViewOptions::default());
    view.cars.clear();
    let eye = place::on_lane(60.0, 0.0).position.as_vec2().extend(400.0);
    let lens = Lens::Parallel { half_extent_m: 10.0 };
    view.camera = Camera { eye, forward: Vec3::NEG_Z, up: Vec3::Y, lens };
    let image = place::draw(&view, false, [400, 400]);
    let light = |left_m: f64| {
        let at = |k: u32| place::on_lane(55.0 + 0.05 * f64::from(k), left_m).position.as_vec2().extend(0.0);
        let pixel = |k: u32| view.camera.project(at(k), 1.0).expect("in the picture") * 400.0;
        let green = (0..200).map(pixel).map(|pixel| rgb(image.get_pixel(pixel.x as u32, pixel.y as u32))[1]);
        green.sum::<f32>() / 200.0
    };
    // Half a metre beside it, on the lane, is asphalt. Paint is worn in places; a line that stands out by less than a fifth is none.
    for side in [-1.0, 1.0] {
        let (line, asphalt) = (light(1.86 * side), light(1.3 * side));
        assert!(line > 1.2 * asphalt, "{line} on {asphalt}");
    }
}

/// Returns the share of paint on the line between two points of the plan.
fn painted(from: Vec2, to: Vec2) -> f32 {
    let n = (from.distance(to) * 10.0) as u32;
    let is_painted = |k: &u32| {
        let at = from.lerp(to, *k as f32 / n as f32);
        let pixel = ((at - Vec2::new(60.0, 120.0)) * Vec2::new(10.0, -10.0)).as_uvec2();
        is_paint(rgb(plan().get_pixel(pixel.x.min(599), pixel.y.min(599))))
    };
    (0..n).filter(is_painted).count() as f32 / n as f32
}

#[test]
fn guidance_on_the_road_is_a_blue_line_along_the_path() {
    // From the west straight on over the crossing, in the right lane: along y = 85.2.
    let map = RoadMap::load_along("tests/data/networks/grid-signals.net.xml", &["A1B1", "B1C1"]).expect("a path");
    let display = DisplaySettings { guidance: GuidanceView::Road, trees: 0, ..DisplaySettings::default() };
    let scenario = Scenario { display, ..Scenario::default() };
    let guided = StaticScene::of_drive(&map, &scenario, &LazyRoadside::new(&map, scenario.seed, 0));
    let guided = StaticScene { buildings: Mesh::default(), ..guided };
    let mut renderer = Renderer::new(gpu(), &guided, OFFSCREEN, Quality::LOW);
    let from_above = View { route_line: 0..guided.route_line.indices.len() as u32, ..from_above() };
    let image = render_to_image(gpu(), &mut renderer, &from_above, [600, 600]).expect("a picture");
    let blue = |x: f32, y: f32| {
        let pixel = ((Vec2::new(x, y) - Vec2::new(60.0, 120.0)) * Vec2::new(10.0, -10.0)).as_uvec2();
        let [r, _, b] = rgb(image.get_pixel(pixel.x, pixel.y));
        b > 2.0 * r
    };
    for k in 0..100 {
        let x = 62.0 + 0.5 * k as f32;
        assert!(blue(x, 85.2) && !blue(x, 84.7) && !blue(x, 85.7) && !blue(x, 88.4), "at x = {x}");
    }
}

#[test]
fn an_arrow_points_to_the_right_on_the_lane_that_turns_right() {
    // The right lane of A1B1 leads straight on and to the right. Its arrow is 5 m long, with its tip 4.55 m before x = 79.6: a shaft in the
    // middle of the lane, and a head on its right. On its left is asphalt. Paint is worn in places.
    let shaft = painted(Vec2::new(70.3, 85.2), Vec2::new(73.2, 85.2));
    assert!(shaft > 0.6, "{shaft} of the shaft");
    let [right, left] = [84.7, 85.7].map(|y| painted(Vec2::new(71.9, y), Vec2::new(72.6, y)));
    assert!(right > 0.6 && left == 0.0, "{right} of the head on the right, {left} on the left");
}

#[test]
fn lines_separate_directions_and_lanes_and_end_before_the_crossing() {
    // Lines are 12 cm wide, so each has one fully painted pixel across. Paint is worn in places.
    let centre = painted(Vec2::new(62.0, 90.0), Vec2::new(78.0, 90.0));
    assert!(centre > 0.6, "{centre} of the line between directions");
    // Dashes of 3 m, gaps of 6 m.
    let broken = painted(Vec2::new(62.0, 86.8), Vec2::new(78.0, 86.8));
    assert!((0.12..0.55).contains(&broken), "{broken} of the line between lanes");
    let edge = painted(Vec2::new(62.0, 83.54), Vec2::new(78.0, 83.54));
    assert!(edge < 0.1, "{edge} of a line at the edge, where a street has a kerb");
    // The kerb begins 40 cm beyond the lane's edge at y = 83.6; the pavement is 2.4 m wide, paler than asphalt and no paint.
    let is_grey = |[r, g, b]: [f32; 3]| r.max(g).max(b) < 1.18 * r.min(g).min(b);
    let [asphalt, pavement, meadow] = [85.2, 82.0, 80.0].map(|y| ground(Vec2::new(65.0, y)));
    assert!(
        is_grey(pavement) && pavement[1] > 1.3 * asphalt[1] && is_grass(meadow),
        "{asphalt:?} {pavement:?} {meadow:?}"
    );
    // The stop line is 50 cm wide and ends 30 cm before the crossing; the other direction has none.
    let stop = painted(Vec2::new(79.05, 84.0), Vec2::new(79.05, 89.5));
    assert!(stop > 0.6, "{stop} of the stop line");
    let leaving = painted(Vec2::new(79.05, 90.6), Vec2::new(79.05, 96.0));
    assert!(leaving < 0.25, "{leaving} of a stop line where vehicles leave the crossing");
    for (from, to) in [((81.0, 90.0), (99.0, 90.0)), ((90.0, 81.0), (90.0, 99.0)), ((82.0, 86.8), (98.0, 86.8))] {
        let inside = painted(from.into(), to.into());
        assert!(inside < 0.02, "{inside} of a line through the crossing");
    }
}

fn lane(id: &str) -> LaneId {
    network().lane_named(id).expect("a lane of the grid")
}

/// Returns the signal heads of a lane, the one beside the stop line first.
fn heads(id: &str) -> Vec<&'static SignalHead> {
    static_scene().signal_heads.iter().filter(|head| head.lane == lane(id)).collect()
}

/// Returns the view of a driver 40 m before the stop line of A1B1, with the signals of the snapshot.
fn before_the_signal(snapshot: &Snapshot) -> View {
    let eye = Vec3::new(79.6 - 40.0, 85.2, 1.18);
    let lens = Lens::Perspective { fov_x_rad: ViewOptions::default().fov_x_rad() };
    view(snapshot, ViewKind::Chase, Camera { eye, forward: Vec3::X, up: Vec3::Z, lens })
}

const SIZE: [u32; 2] = [1280, 720];

/// Returns the mean colour of 3 by 3 pixels around the projected place of a lamp.
fn seen_lamp(image: &RgbaImage, view: &View, lamp: Vec3) -> [f32; 3] {
    let at = view.camera.project(lamp, SIZE[0] as f32 / SIZE[1] as f32).expect("in the picture");
    let pixel = (at * Vec2::new(SIZE[0] as f32, SIZE[1] as f32)).as_ivec2();
    let mut sum = [0.0; 3];
    for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
        let colour = rgb(image.get_pixel((pixel.x + dx) as u32, (pixel.y + dy) as u32));
        (0..3).for_each(|k| sum[k] += colour[k] / 9.0);
    }
    sum
}

/// Returns a snapshot in which all links of all signals show one letter.
fn showing(letter: u8) -> Snapshot {
    Snapshot { signals: SignalStates::uniform(network(), letter), ..Snapshot::default() }
}

#[test]
fn a_head_stands_beside_the_stop_line_and_faces_the_driver() {
    // One beside the outermost lane, whose edge is at y = 83.6, and one over the other lane at y = 88.4, both where the lanes end at x =
    // 79.6.
    let [beside, across] = heads("A1B1_0")[..] else { panic!("{:?}", heads("A1B1_0")) };
    let foot = beside.lamps[1];
    assert!((79.0..79.7).contains(&foot.x) && (82.0..83.2).contains(&foot.y), "{foot}");
    assert!((2.0..3.5).contains(&foot.z) && beside.lamps[0].z > foot.z && foot.z > beside.lamps[2].z, "{foot}");
    assert!(across.lamps[1].x > 100.0 && across.lamps[1].y < 83.2, "beyond the crossing: {:?}", across.lamps);
    let over = heads("A1B1_1")[0].lamps[1];
    assert!((over.y - 88.4).abs() < 0.01 && over.z > 4.7, "higher than a lorry of 4 m: {over}");
    for id in ["A1B1_0", "A1B1_1"] {
        assert!(heads(id).iter().all(|head| head.facing.distance(Vec3::NEG_X) < 1e-5));
    }
    // Nine junctions: four corners without a signal, four with three streets, one with four. Each street has a head for each of its two
    // lanes and one across the junction.
    assert_eq!(static_scene().signal_heads.len(), (4 * 3 + 4) * 3);
}

#[test]
fn only_the_lit_lamp_shows_its_colour_from_40_m() {
    let is_green = |[r, g, b]: [f32; 3]| g > 0.5 && g > 1.6 * r && g > b;
    let is_yellow = |[r, g, b]: [f32; 3]| r > 0.5 && g > 0.35 * r && g < 0.95 * r && b < 0.6 * g;
    let is_lit_red = |[r, g, b]: [f32; 3]| r > 0.5 && r > 2.0 * g && r > 2.0 * b;
    let is_dark = |[r, g, b]: [f32; 3]| r.max(g).max(b) < 0.35;
    let lights: [(&str, [bool; 3]); 4] = [
        ("rR", [true, false, false]),
        ("u", [true, true, false]),
        ("yY", [false, true, false]),
        ("gG", [false, false, true]),
    ];
    for (letters, lit) in lights {
        for letter in letters.bytes() {
            let view = before_the_signal(&showing(letter));
            let image = draw(&view, SIZE);
            for head in [heads("A1B1_0")[0], heads("A1B1_1")[0]] {
                let colours = head.lamps.map(|lamp| seen_lamp(&image, &view, lamp));
                let shown = [is_lit_red(colours[0]), is_yellow(colours[1]), is_green(colours[2])];
                assert_eq!(shown, lit, "{}: {colours:?}", char::from(letter));
                assert!((0..3).all(|k| lit[k] || is_dark(colours[k])), "{}: {colours:?}", char::from(letter));
            }
        }
    }
}

#[test]
fn without_a_drive_signals_show_their_first_programs() {
    // B1's first phase, 42 s long, is GGGggrrrrrGGGggrrrrr. A1B1 has links 15 to 19, B0B1 has 10 to 14 (its connections in the file).
    let red = before_the_signal(&Snapshot::default());
    let seen = seen_lamp(&draw(&red, SIZE), &red, heads("A1B1_0")[0].lamps[0]);
    assert!(seen[0] > 0.5 && seen[0] > 2.0 * seen[1], "red for A1B1: {seen:?}");
    let is_lit = |view: &View, lamp: Vec3| view.lamps.iter().any(|lit| lit.position == lamp);
    assert!(is_lit(&red, heads("A1B1_0")[0].lamps[0]) && is_lit(&red, heads("B0B1_0")[0].lamps[2]));
    // In the third phase, after 45 s, the colours are swapped.
    let late = Snapshot { tick: codrive::time::Tick::at_seconds(50.0), ..Snapshot::default() };
    let late = before_the_signal(&late);
    assert!(is_lit(&late, heads("A1B1_0")[0].lamps[2]) && is_lit(&late, heads("B0B1_0")[0].lamps[0]));
    assert_eq!(heads("A1B1_0")[0].signal, SignalId::from_index(signal_index("B1")));
}

fn signal_index(id: &str) -> usize {
    network().signals().iter().position(|signal| signal.id == id).expect("a signal of the grid")
}

fn vehicle(kind: VehicleKind, [length_m, width_m, height_m]: [f64; 3], lamps: VehicleLamps) -> Snapshot {
    let pose = Pose::new(DVec2::new(45.0, 85.2), 0.0);
    let body = VehicleBody { kind, length_m, width_m, height_m };
    let vehicle =
        VehicleSnapshot { id: VehicleId(8), pose, pose_before: pose, body, lamps, ..VehicleSnapshot::default() };
    Snapshot { cars: vec![vehicle], ..Snapshot::default() }
}

/// Draws a view from 150 m to the side at the height of a driver's eyes; the picture is 24 m wide.
fn from_the_side(snapshot: &Snapshot) -> RgbaImage {
    let eye = Vec3::new(45.0, 85.2 - 150.0, 1.5);
    let camera =
        Camera { eye, forward: Vec3::Y, up: Vec3::Z, lens: Lens::Perspective { fov_x_rad: 2.0 * (0.08f32).atan() } };
    let mut view = view(snapshot, ViewKind::Chase, camera);
    // Magenta, as some ordinary paints are as light as the meadow behind.
    view.cars.iter_mut().for_each(|car| car.colour = MAGENTA);
    // The sun is behind the camera, so the shadow lies behind the vehicle and no halo of a glint rises over its roof.
    view.to_sun = Vec3::new(0.0, -0.95, 0.3).normalize();
    draw(&view, [960, 320])
}

#[test]
fn vehicles_cover_their_size() {
    let empty = from_the_side(&Snapshot::default());
    for (kind, size) in [
        (VehicleKind::Truck, [16.5, 2.55, 4.0]),
        (VehicleKind::Truck, [7.1, 2.4, 3.2]),
        (VehicleKind::Bus, [12.0, 2.5, 3.4]),
        (VehicleKind::Van, [6.5, 2.16, 2.86]),
        (VehicleKind::Car, [4.0, 1.7, 1.6]),
    ] {
        let image = from_the_side(&vehicle(kind, size, VehicleLamps::default()));
        // Windows are hardly darker than the meadow behind them; without the vehicle no pixel above its shade changes.
        // 40 pixels per metre at the centre of the vehicle; its near side is nearer by less than 1 %.
        let changed = image.enumerate_pixels().filter(|(x, y, pixel)| difference(pixel, empty.get_pixel(*x, *y)) > 16);
        // Only pixels above the shade on the road.
        let above: Vec<[u32; 2]> = changed.map(|(x, y, _)| [x, y]).filter(|[_, y]| *y < 205).collect();
        let span = |k: usize| {
            let of = |point: &[u32; 2]| point[k];
            (above.iter().map(of).min().unwrap_or(0), above.iter().map(of).max().unwrap_or(0) + 1)
        };
        let ((left, right), (top, _)) = (span(0), span(1));
        let (length_m, height_m) = ((right - left) as f64 / 40.0, 1.5 + (160.0 - f64::from(top)) / 40.0);
        assert!((length_m / size[0] - 1.0).abs() < 0.03, "{kind:?} of {size:?} m is {length_m} m long");
        assert!((height_m - size[2]).abs() < 0.12, "{kind:?} of {size:?} m is {height_m} m high");
        // The vehicle is in the middle and is not just an outline: most of its box is filled.
        assert!((left as i32 + right as i32 - 960).abs() < 16, "{kind:?}: from {left} to {right}");
        let filled = above.len() as f64 / (f64::from(right - left) * f64::from(205 - top));
        assert!(filled > 0.6, "{kind:?}: {filled} of its box");
    }
}

#[test]
fn brake_lamps_shine_and_indicators_blink() {
    let behind = |snapshot: &Snapshot| {
        let eye = Vec3::new(30.0, 85.2, 1.5);
        let lens = Lens::Perspective { fov_x_rad: 0.6 };
        view(snapshot, ViewKind::Chase, Camera { eye, forward: Vec3::X, up: Vec3::Z, lens })
    };
    let size = [480, 270];
    for (kind, box_m) in [
        (VehicleKind::Truck, [16.5, 2.55, 4.0]),
        (VehicleKind::Bus, [12.0, 2.5, 3.4]),
        (VehicleKind::Van, [6.5, 2.16, 2.86]),
        (VehicleKind::Motorcycle, [2.2, 0.9, 1.5]),
    ] {
        let lamps = VehicleLamps { brake: true, ..VehicleLamps::default() };
        let [dark, lit] = [VehicleLamps::default(), lamps]
            .map(|lamps| pixels(&draw(&behind(&vehicle(kind, box_m, lamps)), size), is_red).len());
        assert!(lit > dark + 12, "{kind:?}: {lit} red pixels while braking, {dark} else");
    }
    let lamps = VehicleLamps { left: true, ..VehicleLamps::default() };
    let blinking = vehicle(VehicleKind::Bus, [12.0, 2.5, 3.4], lamps);
    let amber = |tick: u64| {
        let view = behind(&Snapshot { tick: codrive::time::Tick(tick), ..blinking.clone() });
        let image = draw(&view, size);
        let found = pixels(&image, |[r, g, b]| r > 0.7 && g > 0.3 * r && g < 0.9 * r && b < 0.5 * g);
        assert!(found.iter().all(|[x, _]| *x < size[0] / 2), "on the left side");
        found.len()
    };
    // Twelve moments of a second. SUMO's vehicles have no blinking rate; this renderer uses 86 per minute (`docs/references.md: roads`).
    let counts: Vec<usize> = (0..12).map(|k| amber(500 + 8 * k)).collect();
    let lit = counts.iter().filter(|count| **count > 5).count();
    assert!((4..=8).contains(&lit), "{counts:?}");
    assert!(counts.iter().filter(|count| **count == 0).count() >= 4, "{counts:?}");
}

/// Compares `crossing.net.xml` with a copy moved by 600 km to the east and 5,300 km to the north, as a network in national coordinates,
/// each with its vehicles.
#[test]
fn a_network_in_national_coordinates_looks_like_one_at_the_origin() {
    let by = DVec2::new(600_000.0, 5_300_000.0);
    let drawn = |file: &str, by: DVec2| {
        let network = Arc::new(Network::load(file).unwrap_or_else(|e| panic!("{e}")));
        let static_scene = StaticScene::of_network(&network, 1, 200);
        let renderer = Mutex::new(Renderer::new(gpu(), &static_scene, OFFSCREEN, Quality::LOW));
        // On lane WC towards the crossing at (200, 200): eastwards at y = 198.4.
        let pose = Pose::new(DVec2::new(150.0, 198.4) + by, 0.0);
        let mut snapshot = Snapshot::default();
        snapshot.ego.position = pose.position.extend(0.0);
        snapshot.ego_before = snapshot.ego;
        let leader = Pose::new(pose.position + DVec2::new(15.0, 0.0), 0.0);
        snapshot.cars =
            vec![VehicleSnapshot { id: VehicleId(1), pose: leader, pose_before: leader, ..VehicleSnapshot::default() }];
        let picture = |kind| {
            let view = scene::view(&snapshot, 1.0, kind, &ViewOptions::default(), &static_scene);
            let mut renderer = renderer.lock().unwrap_or_else(|e| e.into_inner());
            render_to_image(gpu(), &mut renderer, &view, [160, 90]).unwrap_or_else(|e| panic!("{e}"))
        };
        [ViewKind::Driver, ViewKind::Chase, ViewKind::Birdseye].map(picture)
    };
    let near = drawn("tests/data/networks/crossing.net.xml", DVec2::ZERO);
    let far = drawn("tests/data/picture-origin/crossing-far.net.xml", by);
    for (near, far) in near.iter().zip(&far) {
        let worst = near.as_raw().iter().zip(far.as_raw()).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(255);
        // Rounding of coordinates may change one of the display's 255 steps, which is invisible.
        assert!(worst <= 1, "{worst} of 255");
    }
}

/// Draws a chase view in a grid of 10 by 10 crossings with signals, the size that is promised for a city quarter.
#[test]
fn a_grid_of_ten_by_ten_has_a_bounded_number_of_triangles() {
    let folder = tempfile::tempdir().expect("a folder");
    let sumo = Path::new(env!("CARGO_MANIFEST_DIR")).join(".sumo/sumo");
    let (program, file) = (sumo.join("bin/netgenerate"), folder.path().join("grid.net.xml"));
    let mut command = Command::new(program);
    command.args(["--grid", "--grid.number", "10", "--grid.length", "100", "-L", "2", "--no-warnings", "true"]);
    command.args(["--default-junction-type", "traffic_light", "--xml-validation", "never"]).arg("-o").arg(&file);
    let made = command.env("SUMO_HOME", &sumo).output().unwrap_or_else(|e| panic!("run scripts/setup first: {e}"));
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let network = Arc::new(Network::load(&file.display().to_string()).unwrap_or_else(|e| panic!("{e}")));
    let static_scene = StaticScene::of_network(&network, 1, 0);
    // Two lanes each way, 36 km of streets, 72 km of lanes. A corner every 12 m in a dozen strips per lane would be 150,000 triangles, and
    // dashes as many again. A small graphics card sets up 300 million triangles a second; all of these take it less than 3 ms.
    let [road, land, posts] =
        [&static_scene.road, &static_scene.land, &static_scene.posts].map(|mesh| mesh.triangles());
    println!("{road} triangles of road, {land} of land, {posts} of signals");
    assert!(road < 600_000 && land < 120_000 && posts < 300_000, "{road}, {land}, {posts}");
    // From the driver's position, pieces outside the picture are culled.
    let mut renderer = Renderer::new(gpu(), &static_scene, OFFSCREEN, Quality::LOW);
    let mut view = scene::view(&Snapshot::default(), 1.0, ViewKind::Chase, &ViewOptions::default(), &static_scene);
    let lens = Lens::Perspective { fov_x_rad: ViewOptions::default().fov_x_rad() };
    view.camera = Camera { eye: Vec3::new(350.0, 398.4, 1.2), forward: Vec3::X, up: Vec3::Z, lens };
    render_to_image(gpu(), &mut renderer, &view, [320, 180]).unwrap_or_else(|e| panic!("{e}"));
    let cost = renderer.cost().main;
    println!("{cost:?}");
    assert!(cost.triangles < (road + land + posts) as u64 / 2, "{cost:?}");
}
