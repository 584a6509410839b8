//! Signs with names: of streets at the corners of a town where they begin, of the town where its streets begin, and of the road that an exit
//! leads to. In: the names in a network, and that of its town. Out: signs, and names for them. Names in other alphabets than the Latin one
//! have none, as no plate can show them.

use super::{
    sign_kind::{Sign, SignKind, SignedRoads},
    speed_limits::SpeedLimits,
};
use crate::{
    latin_letters::is_latin,
    map::network::{EdgeId, JunctionId, LaneId, Network},
    roadside::town::TOWN_MPS,
};
use std::collections::BTreeSet;

/// Distance of a street's name from the start of its outermost lane, metres.
const AFTER_CORNER_M: f64 = 1.2;
/// Length of the shortest street with its name at its start, metres: shorter ones are parts of junctions. The name stands at the
/// first longer one among so many.
const SHORTEST_NAMED_M: f64 = 8.0;
const MOST_SHORT: usize = 3;
/// Number of streets after an exit among which the first name is looked for.
const STREETS_BEYOND: usize = 4;

/// Returns the signs with names of streets of a town: one for each street and junction at which it begins for those who come from another one.
pub(super) fn street_names<'net>(roads: &SignedRoads<'net>) -> Vec<Sign<'net>> {
    let net = roads.net;
    let mut coming: Vec<(EdgeId, EdgeId)> = Vec::new();
    for way in net.connections().iter().filter(|way| !way.is_turnaround() && net.is_driven(way.from)) {
        coming.push((net.lane(way.to).edge, net.lane(way.from).edge));
    }
    coming.sort_unstable();
    coming.dedup();
    let mut named: BTreeSet<(JunctionId, &str)> = BTreeSet::new();
    let mut signs = Vec::new();
    for froms in coming.chunk_by(|(one, _), (other, _)| one == other) {
        let edge = froms[0].0;
        let (Some(name), Some(corner)) = (name(net, edge), net.edge(edge).from) else { continue };
        let begins = froms.iter().any(|(_, from)| {
            is_in_roundabout(net, *from) || net.edge(*from).name.as_deref().is_some_and(|other| other != name)
        });
        let is_street = roads.town.has_street(edge) && !is_in_roundabout(net, edge);
        if !begins || !is_street || named.contains(&(corner, name)) {
            continue;
        }
        let Some(outermost) = first_long(net, edge, name) else { continue };
        if let Some(sign) = roads.first_free((SignKind::StreetName(name), None), outermost, AFTER_CORNER_M) {
            named.insert((corner, name));
            signs.push(sign);
        }
    }
    signs
}

/// Returns the outermost lane of the first street from one on that is no part of a junction and has this name.
fn first_long(net: &Network, edge: EdgeId, name: &str) -> Option<LaneId> {
    let outermost = |edge: EdgeId| net.edge(edge).lanes().find(|lane| net.is_driven(*lane));
    let next = |lane: &LaneId| {
        let ways = net.connections_from(*lane).iter().filter(|way| !way.is_turnaround());
        ways.map(|way| net.lane(way.to).edge).find(|edge| self::name(net, *edge) == Some(name)).and_then(outermost)
    };
    let mut lanes = std::iter::successors(outermost(edge), next).take(MOST_SHORT);
    lanes.find(|lane| net.lane(*lane).line.drawn_m() >= SHORTEST_NAMED_M)
}

/// Returns the sign with the town's name for a street whose outermost lane this is: where a faster road leads into it, or at an entry if the road
/// comes from beyond the network's edge.
pub(super) fn place_name<'net>(
    roads: &SignedRoads<'net>,
    outermost: LaneId,
    limits: &SpeedLimits,
) -> Option<SignKind<'net>> {
    let edge = roads.net.lane(outermost).edge;
    let place = roads.place.filter(|place| is_latin(place) && roads.town.has_street(edge))?;
    let start = |of: &Network| of.lane(outermost).line.points()[0];
    let runs_on = || start(roads.net) != start(roads.drawn);
    let begins = if limits.is_entry(edge) { runs_on() } else { limits.follows_faster(edge, TOWN_MPS) };
    begins.then_some(SignKind::PlaceName(place))
}

/// Returns the first name on the way from a lane on: of its own road, or of the one that it leads to.
pub(super) fn name_beyond(net: &Network, lane: LaneId) -> Option<&str> {
    let next = |lane: &LaneId| net.connections_from(*lane).iter().map(|way| way.to).next();
    let mut lanes = std::iter::successors(Some(lane), next).take(STREETS_BEYOND);
    lanes.find_map(|lane| name(net, net.lane(lane).edge))
}

/// Returns the name of a street if letters of signs can show it.
fn name(net: &Network, edge: EdgeId) -> Option<&str> {
    net.edge(edge).name.as_deref().filter(|name| is_latin(name))
}

/// Checks whether a street is part of a roundabout.
pub(super) fn is_in_roundabout(net: &Network, edge: EdgeId) -> bool {
    net.roundabouts().iter().any(|roundabout| roundabout.edges.contains(&edge))
}

#[cfg(test)]
mod tests {
    use super::{
        super::signs::tests::{network, with_roads},
        *,
    };
    use crate::map::RoadMap;
    use std::path::Path;

    /// Returns the shown names of streets of a network, sorted.
    fn shown(net: &Network) -> Vec<String> {
        with_roads(net, None, |roads| {
            let mut names: Vec<String> = Vec::new();
            for sign in roads.signs() {
                if let SignKind::StreetName(name) = sign.kind {
                    names.push(name.to_owned());
                }
            }
            names.sort();
            names
        })
    }

    /// Returns the network of four arms, each with a name for its two streets.
    fn crossing_with(names: [&str; 4]) -> Network {
        let mut text = std::fs::read_to_string("tests/data/networks/crossing.net.xml").expect("a network of the tests");
        for (arm, name) in ["W", "S", "E", "N"].iter().zip(names) {
            for id in [format!("{arm}C"), format!("C{arm}")] {
                text = text.replace(&format!("<edge id=\"{id}\""), &format!("<edge id=\"{id}\" name=\"{name}\""));
            }
        }
        Network::read(Path::new("crossing.net.xml"), &text).expect("a network")
    }

    #[test]
    fn a_street_is_named_where_it_begins_for_those_from_another() {
        // Two streets cross: each is named once at the crossing.
        assert_eq!(
            shown(&crossing_with(["Long Road", "Mill Lane", "Long Road", "Mill Lane"])),
            ["Long Road", "Mill Lane"]
        );
        // One name all around begins nowhere; one in Chinese cannot be shown.
        assert!(shown(&crossing_with(["Ring"; 4])).is_empty());
        assert_eq!(
            shown(&crossing_with(["Long Road", "\u{4e2d}\u{5c71}\u{8def}", "Long Road", "Ring"])),
            ["Long Road", "Ring"]
        );
        // Streets without names have none, and neither has a road outside towns.
        assert!(shown(&network("crossing")).is_empty() && shown(&network("ramps")).is_empty());
    }

    #[test]
    fn streets_of_the_town_are_named_and_its_name_stands_at_its_edge() {
        let map = RoadMap::load("town").expect("a shipped map");
        let names = shown(&map.network);
        // Of its 27 names, those of the roundabout and of streets outside the town are not shown.
        let different: BTreeSet<&String> = names.iter().collect();
        assert!(different.len() >= 20 && !names.iter().any(|name| name == "Roundabout"), "{names:?}");
        let places = |place: Option<&str>| {
            with_roads(&map.network, place, |roads| {
                roads.signs().iter().filter(|sign| matches!(sign.kind, SignKind::PlaceName(_))).count()
            })
        };
        assert_eq!((places(None), places(Some("\u{5317}\u{4eac}"))), (0, 0));
        assert!(places(Some("Town")) >= 1);
    }
}
