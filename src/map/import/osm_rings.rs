//! Areas of OpenStreetMap that are relations: of several ways, or with holes. SUMO's polyconvert makes an area of the relation's kind of each
//! way, also of those around holes. In: the file. Out: a second file for polyconvert, in which each such area is one closed way that enters and
//! leaves its holes along one line, and a line for the report.

use super::osm_elements::{self, ElementKind, OsmElement, RingMember};
use crate::{
    map::{MapError, limits::MOST_IMPORT_BYTES},
    sumo_xml::document,
};
use quick_xml::escape::escape;
use std::{collections::BTreeMap, fmt::Write, path::Path};

/// Keys of areas that codrive may draw.
const DRAWN: [&str; 8] = ["building", "landuse", "natural", "leisure", "amenity", "waterway", "tourism", "place"];
/// First id of the ways in the second file: ids of OpenStreetMap are smaller.
const FIRST_ID: i64 = 1 << 60;
/// Largest number of corners of an area that is joined: others stay as polyconvert makes them.
const MOST_CORNERS: usize = 20_000;
/// Tag in the second file that keeps the ways of joined areas from becoming areas themselves. Of several keys polyconvert takes the last one
/// of the alphabet, so that a way keeps its own kind.
const PART: &str = "<tag k=\"admin_level\" v=\"0\"/>";

/// Second file for polyconvert.
pub(super) struct RingFile {
    pub text: String,
    /// Number of holes that are joined to outlines.
    pub holes: usize,
}

/// Node of a ring with its place, degrees.
type Corner = (i64, [f64; 2]);
type Ring = Vec<Corner>;

/// Reads the areas of a file; `None` if none is of several ways or has a hole.
///
/// # Errors
/// The file cannot be read.
pub(super) fn read(file: &Path) -> Result<Option<RingFile>, MapError> {
    let failed = |source| MapError::Io { file: file.into(), source };
    let open = || document::open(file, MOST_IMPORT_BYTES).map_err(failed);
    let mut relations: Vec<OsmElement> = Vec::new();
    osm_elements::each(open()?, |element| {
        let is_drawn = || element.tags.iter().any(|(key, _)| DRAWN.contains(&key.as_str()));
        if element.kind == ElementKind::Relation && element.value("type") == Some("multipolygon") && is_drawn() {
            relations.push(element.clone());
        }
    })
    .map_err(failed)?;
    let members = relations.iter().flat_map(|relation| &relation.members);
    let mut ways: BTreeMap<i64, Vec<i64>> = members.map(|member| (member.way, Vec::new())).collect();
    if ways.is_empty() {
        return Ok(None);
    }
    osm_elements::each(open()?, |element| {
        if let (ElementKind::Way, Some(nodes)) = (element.kind, ways.get_mut(&element.id)) {
            nodes.clone_from(&element.nodes);
        }
    })
    .map_err(failed)?;
    let mut places: BTreeMap<i64, [f64; 2]> = ways.values().flatten().map(|node| (*node, [f64::NAN; 2])).collect();
    osm_elements::each(open()?, |element| {
        if let (ElementKind::Node, Some(place)) = (element.kind, places.get_mut(&element.id)) {
            *place = element.place_deg;
        }
    })
    .map_err(failed)?;
    Ok(written(&relations, &ways, &places))
}

/// Returns the second file.
fn written(
    relations: &[OsmElement],
    ways: &BTreeMap<i64, Vec<i64>>,
    places: &BTreeMap<i64, [f64; 2]>,
) -> Option<RingFile> {
    let (mut areas, mut parts, mut holes) = (String::new(), String::new(), 0);
    let mut next_id = FIRST_ID..;
    for relation in relations {
        let Some((rings, found)) = joined(&relation.members, ways, places) else { continue };
        holes += found;
        let tags: String =
            relation.tags.iter().filter(|(key, _)| key != "type").fold(String::new(), |mut text, (k, v)| {
                let _ = write!(text, "<tag k=\"{}\" v=\"{}\"/>", escape(k.as_str()), escape(v.as_str()));
                text
            });
        for (ring, id) in rings.iter().zip(&mut next_id) {
            let _ = write!(areas, "<way id=\"{id}\">");
            ring.iter().chain(ring.first()).for_each(|(node, _)| {
                let _ = write!(areas, "<nd ref=\"{node}\"/>");
            });
            let _ = writeln!(areas, "{tags}</way>");
        }
        for RingMember { way, .. } in &relation.members {
            let _ = write!(parts, "<member type=\"way\" ref=\"{way}\" role=\"outer\"/>");
        }
    }
    let text = format!("<osm version=\"0.6\">\n{areas}<relation id=\"{FIRST_ID}\">{parts}{PART}</relation>\n</osm>\n");
    (!areas.is_empty()).then_some(RingFile { text, holes })
}

/// Returns the outer rings of an area with its holes joined to them, and the number of holes; `None` if polyconvert makes it well, or if the
/// file has not all of its outer rings.
fn joined(
    members: &[RingMember],
    ways: &BTreeMap<i64, Vec<i64>>,
    places: &BTreeMap<i64, [f64; 2]>,
) -> Option<(Vec<Ring>, usize)> {
    let of = |is_inner: bool| {
        let of_role = members.iter().filter(move |member| member.is_inner == is_inner);
        of_role.filter_map(|member| ways.get(&member.way)).filter(|nodes| nodes.len() > 1).collect::<Vec<_>>()
    };
    let (outer, inner) = (of(false), of(true));
    let corners: usize = outer.iter().chain(&inner).map(|nodes| nodes.len()).sum();
    let is_plain = inner.is_empty() && outer.iter().all(|nodes| nodes.first() == nodes.last());
    if is_plain || outer.is_empty() || corners > MOST_CORNERS {
        return None;
    }
    let placed = |nodes: Vec<i64>| {
        let ring: Ring = nodes.into_iter().filter_map(|node| Some((node, *places.get(&node)?))).collect();
        (ring.len() > 2 && ring.iter().all(|(_, [north, _])| north.is_finite())).then_some(ring)
    };
    let (outer, is_whole) = rings(outer);
    let mut outer: Vec<Ring> = outer.into_iter().map(placed).collect::<Option<_>>().filter(|_| is_whole)?;
    let holes = rings(inner).0.into_iter().filter_map(placed).filter_map(|hole| {
        let around = outer.iter().position(|ring| contains(ring, hole[0].1))?;
        Some((nearest(&outer[around], &hole).0, around, hole))
    });
    let mut holes: Vec<(f64, usize, Ring)> = holes.collect();
    // The nearest hole first, so that lines to others need not cross it.
    holes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let count = holes.len();
    for (_, around, hole) in holes {
        let at = nearest(&outer[around], &hole).1;
        join(&mut outer[around], hole, at);
    }
    Some((outer, count))
}

/// Returns closed rings of ways that meet at their ends, the first node of each once, and true if no way is left over.
fn rings(ways: Vec<&Vec<i64>>) -> (Vec<Vec<i64>>, bool) {
    let mut at_end: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
    for (k, nodes) in ways.iter().enumerate() {
        at_end.entry(nodes[0]).or_default().push(k);
        at_end.entry(nodes[nodes.len() - 1]).or_default().push(k);
    }
    let (mut is_used, mut found, mut is_whole) = (vec![false; ways.len()], Vec::new(), true);
    for first in 0..ways.len() {
        if std::mem::replace(&mut is_used[first], true) {
            continue;
        }
        let mut ring = ways[first].clone();
        while ring.first() != ring.last() {
            let end = ring[ring.len() - 1];
            let Some(next) = at_end[&end].iter().copied().find(|k| !is_used[*k]) else { break };
            is_used[next] = true;
            let nodes = ways[next];
            match nodes[0] == end {
                true => ring.extend(&nodes[1..]),
                false => ring.extend(nodes.iter().rev().skip(1)),
            }
        }
        match ring.len() > 3 && ring.first() == ring.last() {
            true => {
                ring.pop();
                found.push(ring);
            }
            false => is_whole = false,
        }
    }
    (found, is_whole)
}

/// Returns the square of the distance between the nearest corners of two rings, and their indices.
fn nearest(ring: &[Corner], hole: &[Corner]) -> (f64, [usize; 2]) {
    let pairs = (0..ring.len()).flat_map(|k| (0..hole.len()).map(move |other| [k, other]));
    let shrunk = hole[0].1[0].to_radians().cos();
    let distances = pairs.map(|[k, other]| {
        let [north, east] = [0, 1].map(|axis| ring[k].1[axis] - hole[other].1[axis]);
        (north * north + (east * shrunk) * (east * shrunk), [k, other])
    });
    distances.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, [0, 0]))
}

/// Adds a hole to a ring: from one corner to one of the hole, around the hole against the ring's direction, and back.
fn join(ring: &mut Ring, mut hole: Ring, [at, mut first]: [usize; 2]) {
    if (doubled(ring) > 0.0) == (doubled(&hole) > 0.0) {
        hole.reverse();
        first = hole.len() - 1 - first;
    }
    hole.rotate_left(first);
    let around = hole.iter().chain(hole.first()).copied().chain([ring[at]]).collect::<Ring>();
    ring.splice(at + 1..at + 1, around);
}

/// Returns twice the area of a ring in square degrees, above 0 in one direction and below 0 in the other.
fn doubled(ring: &[Corner]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|((_, [y, x]), (_, [next_y, next_x]))| x * next_y - next_x * y).sum()
}

/// Checks whether a place lies in a ring (even-odd rule).
fn contains(ring: &[Corner], [y, x]: [f64; 2]) -> bool {
    let next = ring.iter().cycle().skip(1);
    let crossed = ring
        .iter()
        .zip(next)
        .filter(|((_, [ay, ax]), (_, [by, bx]))| (*ay > y) != (*by > y) && x < ax + (bx - ax) * (y - ay) / (by - ay));
    crossed.count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{
        import::{DrivingSide, ImportOptions, import_into},
        network::Network,
        surroundings::{BuildingUse, LandUse, SURROUNDINGS},
    };
    use std::sync::atomic::AtomicBool;

    static STOP: AtomicBool = AtomicBool::new(false);

    /// Four nodes from an id on, around a square: metres north and east of a place, and its side.
    fn square(id: u32, [north_m, east_m]: [f64; 2], side_m: f64) -> String {
        let corners = [[0.0, 0.0], [0.0, side_m], [side_m, side_m], [side_m, 0.0]];
        let node = |(id, [north, east]): (u32, [f64; 2])| {
            // Lengths of a degree at 50 degrees north (WGS 84).
            let (latitude, longitude) = (50.0 + (north_m + north) / 111_229.0, 8.0 + (east_m + east) / 71_698.0);
            format!("<node id=\"{id}\" lat=\"{latitude}\" lon=\"{longitude}\"/>")
        };
        (id..).zip(corners).map(node).collect()
    }

    fn way(id: u32, nodes: &[u32], tag: &str) -> String {
        let nodes: String = nodes.iter().map(|node| format!("<nd ref=\"{node}\"/>")).collect();
        format!("<way id=\"{id}\">{nodes}{}</way>", tags(tag))
    }

    fn tags(of: &str) -> String {
        of.split_whitespace()
            .filter_map(|tag| tag.split_once('='))
            .fold(String::new(), |text, (k, v)| format!("{text}<tag k=\"{k}\" v=\"{v}\"/>"))
    }

    fn relation(id: u32, outer: &[u32], inner: &[u32], tag: &str) -> String {
        let of = |role: &str, ways: &[u32]| -> String {
            ways.iter().map(|way| format!("<member type=\"way\" ref=\"{way}\" role=\"{role}\"/>")).collect()
        };
        format!("<relation id=\"{id}\">{}{}{}</relation>", of("outer", outer), of("inner", inner), tags(tag))
    }

    #[test]
    fn holes_of_areas_and_courtyards_stay_free() {
        let parts = [
            // A street, a block with two courtyards, a wood in two ways with a pond in it, and a park whose outline is cut off.
            square(1, [0.0, 0.0], 200.0),
            square(10, [20.0, 20.0], 40.0),
            square(20, [30.0, 25.0], 10.0),
            square(25, [30.0, 45.0], 10.0),
            square(30, [-250.0, 20.0], 100.0),
            square(40, [-220.0, 50.0], 30.0),
            square(50, [-250.0, 150.0], 20.0),
            way(100, &[1, 2, 3], "highway=residential"),
            way(101, &[10, 11, 12, 13, 10], ""),
            way(102, &[20, 21, 22, 23, 20], ""),
            way(103, &[25, 28, 27, 26, 25], ""),
            way(104, &[30, 31, 32], ""),
            way(105, &[30, 33, 32], ""),
            way(106, &[40, 41, 42, 43, 40], "natural=water"),
            way(107, &[50, 51, 52], ""),
            relation(200, &[101], &[102, 103], "type=multipolygon building=apartments building:levels=4"),
            relation(201, &[104, 105], &[106], "type=multipolygon landuse=forest"),
            relation(202, &[107, 999], &[], "type=multipolygon leisure=park"),
        ];
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("place.osm");
        std::fs::write(&file, format!("<osm version=\"0.6\">{}</osm>", parts.concat())).expect("written");
        let netconvert = Path::new(env!("CODRIVE_ROOT")).join(".sumo/sumo/bin/netconvert");
        let side = Some(DrivingSide::Right);
        let options = ImportOptions { seconds: 60, memory_mib: 1024, stop: &STOP, side };
        let made = import_into(&folder.path().join("maps"), &netconvert, &file, "place", &options).expect("imported");
        assert!(
            made.report.notes.iter().any(|note| note == "holes          3 in buildings and land"),
            "{:?}",
            made.report
        );
        let left: Vec<_> =
            std::fs::read_dir(&made.folder).expect("a folder").flatten().map(|of| of.file_name()).collect();
        assert!(
            left.iter().any(|name| name == SURROUNDINGS) && !left.iter().any(|name| name == "areas.osm"),
            "{left:?}"
        );
        let net = Network::load(&made.folder.join("net.xml").to_string_lossy()).expect("a network");
        let found = net.surroundings();
        let is_near = |area_m2: f64, expected_m2: f64| (area_m2 / expected_m2 - 1.0).abs() < 0.01;
        let [block] = &found.buildings[..] else { panic!("{found:?}") };
        assert_eq!((block.kind, block.height_m), (BuildingUse::Flats, Some(12.0)));
        assert!(is_near(block.area_m2(), 40.0 * 40.0 - 2.0 * 10.0 * 10.0), "{}", block.area_m2());
        let area_m2 = |of: LandUse| -> Vec<f64> {
            found.areas.iter().filter(|area| area.land_use == of).map(|area| area.area_m2()).collect()
        };
        let ([wood_m2], [pond_m2], [park_m2]) =
            (&area_m2(LandUse::Wood)[..], &area_m2(LandUse::Water)[..], &area_m2(LandUse::Park)[..])
        else {
            panic!("{found:?}")
        };
        assert!(
            is_near(*wood_m2, 100.0 * 100.0 - 30.0 * 30.0) && is_near(*pond_m2, 30.0 * 30.0),
            "{wood_m2} {pond_m2}"
        );
        // What is left of it in the file, as polyconvert closes it.
        assert!(is_near(*park_m2, 20.0 * 20.0 / 2.0), "{park_m2}");
    }
}
