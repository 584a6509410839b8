//! Bodies of other vehicles around the ego: they appear and disappear, each with its own size.

use super::ego::{ROAD, brake};
use codrive::{
    ego::{CarParams, EgoCar, Obstacle},
    space::Pose,
};
use glam::dvec2;

#[test]
fn bodies_of_other_vehicles_appear_and_disappear_with_their_own_size() {
    let mut ego = EgoCar::new(&CarParams::default(), Pose::default(), 0.0, 0).unwrap();
    let at = |id: u32, x: f64, length_m: f64| Obstacle {
        id,
        pose: Pose::new(dvec2(x, 0.0), 0.0),
        length_m,
        width_m: 2.5,
        ..Obstacle::default()
    };
    // The centre of a lorry of 12 m is 8.4 m ahead of the ego's: a tenth of a metre overlaps (6 + 2.5 - 8.4). A car there is 3.4 m away.
    let mut touched = Vec::new();
    for list in [
        vec![at(5, 8.4, 5.0)],
        vec![at(9, -30.0, 5.0), at(5, 8.4, 5.0)],
        vec![at(9, -30.0, 5.0)],
        vec![at(9, -30.0, 5.0), at(31, 8.4, 12.0)],
    ] {
        touched.push(ego.tick(&brake(0.5), &ROAD, &list).iter().map(|contact| contact.car).collect::<Vec<_>>());
    }
    assert_eq!(touched, [vec![], vec![], vec![], vec![31]]);
    // The lorry is gone: the ego, pushed back a little, stands free.
    for _ in 0..200 {
        assert!(ego.tick(&brake(0.5), &ROAD, &[at(9, -30.0, 5.0)]).is_empty());
    }
    assert!(ego.state().velocity.length() < 0.01 && ego.state().position.x > -0.5, "{:?}", ego.state().position);
}
