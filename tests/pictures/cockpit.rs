//! Tests of the full cockpit: its mirrors hang in the car and show the road behind, and its instrument can be read over the steering wheel.

use crate::{pixels::*, place::*};
use codrive::{
    render::dial::{DialPlace, layout},
    scenario::CockpitView,
    scene::{MirrorPane, View, ViewKind, ViewOptions},
    space::Pose,
    traffic::EGO,
};
use glam::{Vec2, Vec3};

const SIZE: [u32; 2] = [768, 432];
const ASPECT: f32 = 768.0 / 432.0;

fn full() -> ViewOptions {
    ViewOptions { cockpit: CockpitView::Full, ..marked() }
}

fn panes(view: &View) -> [MirrorPane; 3] {
    view.seat.and_then(|seat| seat.mirrors).expect("a full cockpit")
}

/// Returns the region of the picture that holds a mirror's glass.
fn region(view: &View, pane: &MirrorPane) -> Region {
    let [corner, right, down] = pane.corners;
    let places = [corner, right, down, right + down - corner]
        .map(|p| view.camera.project(p, ASPECT).expect("before the eye") * Vec2::new(SIZE[0] as f32, SIZE[1] as f32));
    let (low, high) = places.iter().fold((places[0], places[0]), |(low, high), p| (low.min(*p), high.max(*p)));
    [low.x as u32, low.y as u32, high.x.ceil() as u32, high.y.ceil() as u32]
}

#[test]
fn a_car_beside_the_tail_shows_only_in_the_mirror_of_its_side() {
    for (which, side) in [(1, 1.0f32), (2, -1.0)] {
        let mut before: Option<f32> = None;
        for beside_m in [2.6, 3.6] {
            let ego = on_lane(0.0, 0.0);
            let other =
                Pose::new(ego.rear(5.0) - ego.forward() * 7.0 + ego.left() * (f64::from(side) * beside_m), ego.yaw_rad);
            let view = view(&snapshot(vec![car(1, other)]), ViewKind::Driver, &full());
            let image = draw(&view, false, SIZE);
            let boxes = panes(&view).map(|pane| region(&view, &pane));
            let of =
                |k: usize| pixels(&image, is_magenta).into_iter().filter(|p| inside(boxes[k], *p)).collect::<Vec<_>>();
            let (seen, elsewhere) = (of(which), of(3 - which));
            assert!(seen.len() > 30, "side {side}, {beside_m} m beside: {} pixels", seen.len());
            assert!(elsewhere.is_empty(), "side {side}: {} pixels in the other mirror", elsewhere.len());
            // A mirror keeps left on the left.
            let x = centroid(&image, &seen)[0];
            if let Some(before) = before {
                assert!((x - before) * side < -0.003, "side {side}: {before}, then {x}");
            }
            before = Some(x);
        }
    }
}

#[test]
fn the_mirror_hangs_in_the_car_and_shows_the_follower_without_an_inset() {
    let ego = on_lane(0.0, 0.0);
    let follower = Pose::new(ego.rear(5.0) - ego.forward() * 8.0, ego.yaw_rad);
    let view = view(&snapshot(vec![car(1, follower)]), ViewKind::Driver, &full());
    let image = draw(&view, false, SIZE);
    let rear = region(&view, &panes(&view)[0]);
    let seen = pixels(&image, is_magenta);
    assert!(seen.len() > 60, "{}", seen.len());
    // One pixel more, for smoothed edges.
    let [left, top, right, bottom] = rear;
    let glasses = panes(&view).map(|pane| region(&view, &pane));
    let wide = [left.saturating_sub(1), top.saturating_sub(1), right + 1, bottom + 1];
    assert!(seen.iter().any(|p| inside(wide, *p)));
    assert!(seen.iter().all(|p| inside(wide, *p) || glasses[1..].iter().any(|glass| inside(*glass, *p))));
    // The mirror is seen in perspective: its nearer, right side is higher.
    let pane = panes(&view)[0];
    let at = |p: Vec3| view.camera.project(p, ASPECT).expect("before the eye");
    let [corner, right, down] = pane.corners;
    let (near, far) = (at(right).distance(at(right + down - corner)), at(corner).distance(at(down)));
    assert!((near / far - 1.0).abs() > 0.01, "{near} {far}");
    // The frame is dark on all sides.
    let middle = [(rear[0] + rear[2]) as f32 / 2.0, (rear[1] + rear[3]) as f32 / 2.0];
    let below = image.get_pixel(middle[0] as u32, (middle[1] + 0.5 * (rear[3] - rear[1]) as f32) as u32 + 2);
    assert!(luminance(rgb(below)) < 0.25, "{below:?}");
}

#[test]
fn the_flank_of_the_ego_is_at_the_inner_edge_of_each_side_mirror() {
    let mut options = ViewOptions { cockpit: CockpitView::Full, ..Default::default() };
    options.paint_overrides.insert(EGO, MAGENTA);
    let view = view(&snapshot(vec![]), ViewKind::Driver, &options);
    let image = draw(&view, false, SIZE);
    for (which, inner) in [(1, 1.0), (2, -1.0)] {
        let [left, top, right, bottom] = region(&view, &panes(&view)[which]);
        // Inside the frame and its round corners, which have the car's paint, too.
        let (dx, dy) = ((right - left) / 25, (bottom - top) / 4);
        let glass = [left + dx, top + dy, right - dx, bottom - dy];
        let seen: Vec<_> = pixels(&image, is_magenta).into_iter().filter(|p| inside(glass, *p)).collect();
        assert!(seen.len() > 5, "mirror {which}: {} pixels", seen.len());
        let share = seen.len() as f32 / ((glass[2] - glass[0]) * (glass[3] - glass[1])) as f32;
        assert!(share < 0.25, "mirror {which}: {share} of the glass");
        let middle = (left + right) as f32 / 2.0;
        assert!(seen.iter().all(|p| (p[0] as f32 + 0.5 - middle) * inner > 0.0), "mirror {which}: {seen:?}");
    }
}

#[test]
fn the_instrument_is_in_its_cluster_with_a_number_as_high_as_on_the_dial() {
    let view = view(&full_ring(), ViewKind::Driver, &full());
    for (size, whole) in [([1920, 1080], true), ([1280, 720], true), ([1920, 1200], true), ([2520, 1080], false)] {
        let rect = DialPlace::of(&view, size).rect(size);
        let number_px = layout::NUMBER.0 * rect.width() / 2.0;
        // Reference: a dial of 0.34 of the height at 16:9, whose number was 0.35 of its radius high. In a higher picture of the same width,
        // the world has the same scale.
        let before_px = 0.35 * 0.34 / 2.0 * (size[1] as f32).min(size[0] as f32 * 9.0 / 16.0);
        assert!(number_px >= before_px, "{size:?}: {number_px} pixels, {before_px} before");
        assert!((rect.center().x - size[0] as f32 / 2.0).abs() < 1.0 && rect.bottom() <= size[1] as f32);
        let aspect = size[0] as f32 / size[1] as f32;
        let middle = view.cars[0].position + view.cars[0].rotation * codrive::scene::CLUSTER_M;
        let at = view.camera.project(middle, aspect).expect("before the eye");
        let off = egui::pos2(at.x * size[0] as f32, at.y * size[1] as f32).distance(rect.center());
        // A picture of 21:9 ends above the lower edge of the cluster.
        assert!(off < if whole { 1.0 } else { 0.1 * size[1] as f32 }, "{size:?}: {off} pixels beside it");
    }
}

#[test]
fn no_turn_of_the_steering_wheel_covers_the_dark_face_of_the_cluster() {
    for turn in [-2.5, -0.4, 0.0, 0.4, 2.5] {
        let mut view = view(&full_ring(), ViewKind::Driver, &full());
        if let Some(seat) = &mut view.seat {
            seat.steering_wheel_rad = Some(turn);
        }
        let image = draw(&view, false, SIZE);
        let rect = DialPlace::of(&view, SIZE).rect(SIZE);
        // The whole disc of the instrument, without its shadow.
        let strays = image.enumerate_pixels().filter(|(x, y, p)| {
            let at = egui::pos2(*x as f32 + 0.5, *y as f32 + 0.5);
            at.distance(rect.center()) < layout::FACE * rect.width() / 2.0 - 1.0 && luminance(rgb(p)) > 0.13
        });
        assert_eq!(strays.count(), 0, "wheel at {turn}");
    }
}
