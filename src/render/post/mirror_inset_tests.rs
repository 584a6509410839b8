//! Tests of the mirror inset: what it never hides from the driver.

use super::tonemap::mirror_rect;
use crate::{
    map::network::{LaneId, LanePosition, Network},
    scene::{self, StaticScene, ViewKind, ViewOptions},
    snapshot::Snapshot,
    space::CAR_LENGTH_M,
};
use glam::{DQuat, Vec2, Vec3};

/// Distance of the front bumper from the end of the lane of a driver who stands at the line, metres.
const BEFORE_END_M: f64 = 1.2;

/// Returns the points of a driver's signals that the driver sees at the stop line, beside the inset.
fn seen_at_the_line(static_scene: &StaticScene, lane: LaneId) -> Vec<Vec3> {
    let size = [1280u32, 720];
    let net = &static_scene.network;
    let of = net.lane(lane);
    let s_m = (of.length_m - BEFORE_END_M - CAR_LENGTH_M / 2.0).max(0.0);
    let at = net.pose(LanePosition { lane, s_m, offset_m: 0.0 });
    let mut snapshot = Snapshot::default();
    snapshot.ego.position = at.position + static_scene.origin;
    snapshot.ego.rotation = DQuat::from_rotation_z(at.yaw_rad).as_quat();
    snapshot.ego_before = snapshot.ego;
    let view = scene::view(&snapshot, 1.0, ViewKind::Driver, &ViewOptions::default(), static_scene);
    let [left, top, width, height] = mirror_rect(size).map(|pixels| pixels as f32);
    let is_seen = |lamp: &Vec3| {
        let aspect = size[0] as f32 / size[1] as f32;
        let Some(at) = view.camera.project(*lamp, aspect) else { return false };
        let pixel = at * Vec2::new(size[0] as f32, size[1] as f32);
        let is_inside = at.cmpge(Vec2::ZERO).all() && at.cmple(Vec2::ONE).all();
        let is_hidden = (left..left + width).contains(&pixel.x) && (top..top + height).contains(&pixel.y);
        is_inside && !is_hidden
    };
    // The heads of the lane, and those of the lanes beside it that are green when its own is.
    let heads = || static_scene.signal_heads.iter();
    let own = heads().find(|head| head.lane == lane).expect("a signal");
    let letters = |link: u32| {
        let phases = net.signal(own.signal).programs.iter().flat_map(|program| &program.phases);
        phases.map(|phase| phase.state.to_ascii_lowercase().as_bytes()[link as usize]).collect::<Vec<u8>>()
    };
    let is_beside = |of: LaneId| net.lane(of).edge == net.lane(lane).edge;
    let of_lane = heads().filter(|head| is_beside(head.lane) && letters(head.link) == letters(own.link));
    // A whole head: its red and its green.
    let whole = of_lane.filter(|head| [0, 2].iter().all(|k| is_seen(&head.lamps[*k])));
    whole.map(|head| head.lamps[1]).collect()
}

#[test]
fn a_driver_at_the_stop_line_sees_a_signal_beside_the_mirror_inset() {
    let mut lanes = 0;
    let mut blind = Vec::new();
    for name in ["town", "grid", "tests/data/networks/town-left.net.xml", "tests/data/networks/grid-signals.net.xml"] {
        let net = Network::load(name).expect("a network");
        let static_scene = StaticScene::of_network(&net.into(), 1, 0);
        let net = &static_scene.network;
        for lane in net.lane_ids().filter(|lane| net.is_driven(*lane)) {
            if static_scene.signal_heads.iter().any(|head| head.lane == lane) {
                lanes += 1;
                if seen_at_the_line(&static_scene, lane).is_empty() {
                    blind.push(format!("{name} {}", net.lane(lane).id));
                }
            }
        }
    }
    assert!(lanes > 50, "{lanes}");
    assert!(blind.is_empty(), "{} of {lanes}: {blind:?}", blind.len());
}
