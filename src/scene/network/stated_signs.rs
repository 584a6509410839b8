//! Signs that a map states, in place of those by rules. In: the surroundings of a network, and its signs by rules. Out: both; of two of one kind
//! at one place for the same drivers the stated one. Two stated ones at one place stand on one pole.

use super::sign_kind::{Sign, SignKind, SignedRoads};
use crate::{
    latin_letters::is_latin,
    map::surroundings::{StatedSign, StatedSignKind},
};
use glam::Vec2;
use std::mem::{Discriminant, discriminant};

/// Distance from a stated sign within which none of its kind follows from rules, metres.
const INSTEAD_M: f32 = 20.0;
/// Distance within which stated signs that face alike stand on one pole, metres.
const ONE_POLE_M: f32 = 0.3;
/// Number of signs before a sign among which another on its pole is looked for.
const MOST_ON_POLE: usize = 4;
/// Least cosines of the angle between signs for the same drivers, and between those on one pole: 60 and 8 degrees.
const SAME_DRIVERS: f32 = 0.5;
const ALIKE: f32 = 0.99;
/// Least distance of a stated sign from any lane, metres: one over a road has no pole beside it.
const FREE_M: f32 = 0.1;

/// Adds the stated signs to those by rules.
pub(super) fn add_stated<'net>(roads: &SignedRoads<'net>, signs: &mut Vec<Sign<'net>>) {
    let mut stated: Vec<Sign> = Vec::new();
    for sign in roads.net.surroundings().signs.iter().filter_map(|sign| placed(roads, sign)) {
        let is_there =
            |other: &&mut Sign| other.foot.distance(sign.foot) < ONE_POLE_M && other.facing.dot(sign.facing) > ALIKE;
        // Signs of a pole follow each other. A third one has no room.
        match stated.iter_mut().rev().take(MOST_ON_POLE).find(is_there) {
            Some(other) => other.below = other.below.or(Some(sign.kind).filter(|kind| *kind != other.kind)),
            None => stated.push(sign),
        }
    }
    let is_stated = |sign: &Sign| {
        let is_like =
            |other: &Sign| other.facing.dot(sign.facing) > SAME_DRIVERS && other.foot.distance(sign.foot) < INSTEAD_M;
        let mut kinds = stated.iter().filter(|other| is_like(other)).flat_map(|other| [Some(other.kind), other.below]);
        kinds.any(|kind| kind.is_some_and(|kind| subject(kind) == subject(sign.kind)))
    };
    signs.retain(|sign| !is_stated(sign));
    signs.extend(stated);
}

/// Returns the subject of a sign: that of all signs of right of way is the same, because only one of them can hold.
fn subject(of: SignKind) -> Discriminant<SignKind> {
    match of {
        SignKind::Stop | SignKind::Yield | SignKind::Priority => discriminant(&SignKind::Stop),
        other => discriminant(&other),
    }
}

/// Returns a stated sign at its place; `None` on a road, and far from all of them.
fn placed<'net>(roads: &SignedRoads<'net>, sign: &StatedSign) -> Option<Sign<'net>> {
    let at = sign.position.as_vec2();
    let foot = at.extend(roads.surfaces.height_m(at));
    let lane = roads.net.locate(foot.as_dvec3(), None)?.lane;
    let facing = Vec2::from_angle(sign.facing_rad as f32).extend(0.0);
    let is_free = roads.surfaces.border_m(at) > FREE_M;
    is_free.then_some(Sign { kind: kind(sign.kind, roads.place)?, below: None, lane, foot, facing })
}

/// Returns the kind of a stated sign; `None` for the name of a place that no sign can show.
fn kind<'net>(of: StatedSignKind, place: Option<&'net str>) -> Option<SignKind<'net>> {
    Some(match of {
        StatedSignKind::Stop => SignKind::Stop,
        StatedSignKind::Yield => SignKind::Yield,
        StatedSignKind::Roundabout => SignKind::Roundabout,
        StatedSignKind::Priority => SignKind::Priority,
        StatedSignKind::Zebra => SignKind::Zebra,
        StatedSignKind::PlaceName => SignKind::PlaceName(place.filter(|place| is_latin(place))?),
        StatedSignKind::SpeedLimit(limit) => SignKind::SpeedLimit(limit),
    })
}

#[cfg(test)]
mod tests {
    use super::{
        super::signs::tests::{network, with_roads},
        *,
    };
    use crate::map::surroundings::Surroundings;
    use SignKind::{PlaceName, SpeedLimit, Stop, Yield};
    use glam::{DVec2, dvec2};
    use std::f64::consts::PI;

    /// Checks the signs within 5 m of the first sign of the crossing that a function chooses, in a network of this place: `stated` are places
    /// behind that sign in metres, turns from its facing in radians, and kinds.
    fn check(
        place: Option<&str>,
        by_rules: impl Fn(&Sign) -> bool,
        stated: &[(f64, f64, StatedSignKind)],
        expected: &[(SignKind, Option<SignKind>)],
        change: isize,
    ) {
        let net = network("crossing");
        let (at, facing, count) = with_roads(&net, place, |roads| {
            let signs = roads.signs();
            let sign = signs.iter().find(|sign| by_rules(sign)).expect("a sign");
            (sign.foot.truncate().as_dvec2(), sign.facing.truncate().as_dvec2(), signs.len())
        });
        let sign = |&(behind_m, turn_rad, kind): &(f64, f64, StatedSignKind)| StatedSign {
            position: at - facing * behind_m,
            facing_rad: facing.to_angle() + turn_rad,
            kind,
        };
        let signs = stated.iter().map(sign).collect();
        let net = net.with_surroundings(Surroundings { signs, ..Surroundings::default() });
        with_roads(&net, place, |roads| {
            let signs = roads.signs();
            let near = signs.iter().filter(|sign| sign.foot.truncate().as_dvec2().distance(at) < 5.0);
            let near: Vec<_> = near.map(|sign| (sign.kind, sign.below)).collect();
            assert_eq!(near, expected, "{stated:?}");
            assert_eq!(signs.len(), count.checked_add_signed(change).expect("signs"), "{stated:?}");
        });
    }

    #[test]
    fn a_stated_sign_stands_in_place_of_one_by_rules_and_beside_others() {
        let is_limit = |sign: &Sign| matches!(sign.kind, SpeedLimit(_));
        let is_yield = |sign: &Sign| sign.kind == Yield;
        check(None, is_limit, &[(1.0, 0.0, StatedSignKind::SpeedLimit(30))], &[(SpeedLimit(30), None)], 0);
        // For those who come the other way.
        let both = [(SpeedLimit(50), None), (SpeedLimit(30), None)];
        check(None, is_limit, &[(1.0, PI, StatedSignKind::SpeedLimit(30))], &both, 1);
        check(None, is_limit, &[(1.0, 0.0, StatedSignKind::Stop)], &[(SpeedLimit(50), None), (Stop, None)], 1);
        // One sign of right of way is in place of another.
        check(None, is_yield, &[(1.0, 0.1, StatedSignKind::Stop)], &[(Stop, None)], 0);
        check(None, is_limit, &[(9000.0, 0.0, StatedSignKind::Stop)], &[(SpeedLimit(50), None)], 0);
    }

    #[test]
    fn two_stated_signs_at_a_place_stand_on_one_pole() {
        let is_place = |sign: &Sign| matches!(sign.kind, PlaceName(_));
        let stated = [StatedSignKind::PlaceName, StatedSignKind::SpeedLimit(30)].map(|kind| (1.0, 0.0, kind));
        check(Some("Ulm"), is_place, &stated, &[(PlaceName("Ulm"), Some(SpeedLimit(30)))], 0);
    }

    #[test]
    fn a_stated_sign_on_a_road_is_left_out() {
        let net = network("crossing");
        let count = with_roads(&net, None, |roads| roads.signs().len());
        let on_road = net.lanes()[0].line.points()[0].truncate();
        let places: [DVec2; 2] = [on_road, dvec2(9000.0, 9000.0)];
        let sign = |position| StatedSign { position, facing_rad: 0.0, kind: StatedSignKind::Stop };
        let signs = places.map(sign).to_vec();
        let net = net.with_surroundings(Surroundings { signs, ..Surroundings::default() });
        with_roads(&net, None, |roads| assert_eq!(roads.signs().len(), count));
    }
}
