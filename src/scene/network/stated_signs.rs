//! Signs that a map states, in place of those by rules. In: the surroundings of a network, and its signs by rules. Out: both; of two of one kind
//! at one place the stated one.

use super::sign_kind::{Sign, SignKind, SignedRoads};
use crate::map::surroundings::{StatedSign, StatedSignKind};
use glam::Vec2;
use std::mem::discriminant;

/// Distance from a stated sign within which none of its kind follows from rules, metres.
const INSTEAD_M: f32 = 20.0;
/// Least distance of a stated sign from any lane, metres: one over a road has no pole beside it.
const FREE_M: f32 = 0.1;

/// Adds the stated signs to those by rules.
pub(super) fn add_stated<'net>(roads: &SignedRoads<'net>, signs: &mut Vec<Sign<'net>>) {
    let stated: Vec<Sign> = roads.net.surroundings().signs.iter().filter_map(|sign| placed(roads, sign)).collect();
    let is_stated = |sign: &Sign| {
        let is_like = |other: &Sign| discriminant(&other.kind) == discriminant(&sign.kind);
        stated.iter().any(|other| is_like(other) && other.foot.distance(sign.foot) < INSTEAD_M)
    };
    signs.retain(|sign| !is_stated(sign));
    signs.extend(stated);
}

/// Returns a stated sign at its place; `None` on a road, and far from all of them.
fn placed<'net>(roads: &SignedRoads<'net>, sign: &StatedSign) -> Option<Sign<'net>> {
    let at = sign.position.as_vec2();
    let foot = at.extend(roads.surfaces.height_m(at));
    let lane = roads.net.locate(foot.as_dvec3(), None)?.lane;
    let facing = Vec2::from_angle(sign.facing_rad as f32).extend(0.0);
    let is_free = roads.surfaces.border_m(at) > FREE_M;
    is_free.then_some(Sign { kind: kind(sign.kind), below: None, lane, foot, facing })
}

fn kind(of: StatedSignKind) -> SignKind<'static> {
    match of {
        StatedSignKind::Stop => SignKind::Stop,
        StatedSignKind::Yield => SignKind::Yield,
        StatedSignKind::Roundabout => SignKind::Roundabout,
        StatedSignKind::Priority => SignKind::Priority,
        StatedSignKind::Zebra => SignKind::Zebra,
        StatedSignKind::SpeedLimit(limit) => SignKind::SpeedLimit(limit),
    }
}

#[cfg(test)]
mod tests {
    use super::{
        super::signs::tests::{network, with_roads},
        *,
    };
    use crate::map::surroundings::Surroundings;
    use glam::dvec2;
    use std::f64::consts::PI;

    #[test]
    fn a_stated_sign_stands_in_place_of_one_by_rules_and_beside_others() {
        let net = network("crossing");
        let (first, count) = with_roads(&net, None, |roads| {
            let signs = roads.signs();
            let limit = signs.iter().find(|sign| matches!(sign.kind, SignKind::SpeedLimit(_))).expect("a limit");
            (limit.foot.as_dvec3(), signs.len())
        });
        let sign = |at, kind| StatedSign { position: at, facing_rad: PI, kind };
        let beside = first.truncate() + dvec2(1.0, 0.0);
        let signs = vec![
            sign(beside, StatedSignKind::SpeedLimit(30)),
            sign(beside, StatedSignKind::Stop),
            // On the road, and far from it.
            sign(net.lanes()[0].line.points()[0].truncate(), StatedSignKind::Stop),
            sign(dvec2(9000.0, 9000.0), StatedSignKind::Stop),
        ];
        let net = net.with_surroundings(Surroundings { signs, ..Surroundings::default() });
        with_roads(&net, None, |roads| {
            let signs = roads.signs();
            assert_eq!(signs.len(), count + 1);
            let near: Vec<SignKind> =
                signs.iter().filter(|sign| sign.foot.as_dvec3().distance(first) < 5.0).map(|sign| sign.kind).collect();
            assert_eq!(near, [SignKind::SpeedLimit(30), SignKind::Stop]);
            assert!(signs[count - 1].facing.distance(glam::Vec3::NEG_X) < 1e-3, "{:?}", signs[count - 1]);
        });
    }
}
