//! Road signs among the nodes of an OpenStreetMap file, which SUMO's converters drop. In: the file, and the network made from it. Out: the
//! signs in the network's frame, and lines for the report. `sign_tags` reads the tags, `sign_places` chooses the places at the roads.

use super::{
    netconvert::{self, ImportOptions},
    netconvert_attempts::MadeNetwork,
    osm_elements::{self, ElementKind, OsmElement},
    sign_places::{CarLanes, NodeAtRoad},
    sign_tags::NodeSigns,
};
use crate::{
    map::{MapError, limits::MOST_IMPORT_BYTES, surroundings::StatedSign},
    private,
    sumo_xml::document,
};
use glam::{DVec2, dvec2};
use roxmltree::Document;
use std::{collections::BTreeMap, fmt::Write, path::Path};

/// Files for polyconvert with the points to be projected, and its result, in the map's folder.
const POINTS: &str = "points.osm";
const PROJECTED: &str = "points.xml";
/// Values of `highway` of ways that are not for cars.
const PATHS: [&str; 10] = [
    "footway",
    "cycleway",
    "path",
    "pedestrian",
    "steps",
    "bridleway",
    "corridor",
    "platform",
    "construction",
    "proposed",
];
/// Largest number of values of signs that the report names.
const VALUES_TOLD: usize = 12;

/// Signs of a file, and lines for the report on those that are not drawn.
#[derive(Debug, Default)]
pub(super) struct FoundSigns {
    pub signs: Vec<StatedSign>,
    pub notes: Vec<String>,
}

/// Node that stands for one sign or several, as the file has it.
#[derive(Debug)]
struct SignNode {
    id: i64,
    signs: NodeSigns,
    /// Neighbours of the node on each way for cars that it is on, in the way's direction.
    on_ways: Vec<[Option<i64>; 2]>,
    /// True if it is on another way, such as a footpath.
    is_on_path: bool,
}

/// Reads the signs of a file.
///
/// # Errors
/// The file cannot be read, polyconvert fails, or the user stopped the import.
pub(super) fn read(
    folder: &Path,
    netconvert: &Path,
    file: &Path,
    made: &MadeNetwork,
    options: &ImportOptions,
) -> Result<FoundSigns, MapError> {
    let failed = |source| MapError::Io { file: file.into(), source };
    let open = || document::open(file, MOST_IMPORT_BYTES).map_err(failed);
    let mut nodes = Vec::new();
    let mut by_id = BTreeMap::new();
    osm_elements::each(open()?, |element| collect(element, made.place.as_deref(), &mut nodes, &mut by_id))
        .map_err(failed)?;
    if nodes.is_empty() {
        return Ok(FoundSigns::default());
    }
    let mut places_deg: BTreeMap<i64, [f64; 2]> = BTreeMap::new();
    let around = nodes.iter().flat_map(|node| node.on_ways.iter().flatten().flatten().chain([&node.id]));
    places_deg.extend(around.map(|id| (*id, [0.0; 2])));
    osm_elements::each(open()?, |element| {
        if let (ElementKind::Node, Some(place_deg)) = (element.kind, places_deg.get_mut(&element.id)) {
            *place_deg = element.place_deg;
        }
    })
    .map_err(failed)?;
    let points = projected(folder, netconvert, &places_deg, options)?;
    Ok(placed(&nodes, &points, &CarLanes::of(&made.network)))
}

/// Adds a node with signs, or what a way says of them. Files have their nodes before their ways.
fn collect(element: &OsmElement, place: Option<&str>, nodes: &mut Vec<SignNode>, by_id: &mut BTreeMap<i64, usize>) {
    match element.kind {
        ElementKind::Node => {
            if let Some(signs) = NodeSigns::of(&element.tags, place) {
                by_id.insert(element.id, nodes.len());
                nodes.push(SignNode { id: element.id, signs, on_ways: Vec::new(), is_on_path: false });
            }
        }
        ElementKind::Way => {
            let Some(highway) = element.value("highway") else { return };
            let ids = &element.nodes;
            for (k, id) in ids.iter().enumerate() {
                let Some(node) = by_id.get(id).and_then(|index| nodes.get_mut(*index)) else { continue };
                match PATHS.contains(&highway) {
                    true => node.is_on_path = true,
                    false => node.on_ways.push([k.checked_sub(1), k.checked_add(1)].map(|k| ids.get(k?).copied())),
                }
            }
        }
        ElementKind::Relation => {}
    }
}

/// Returns points in the network's frame, by polyconvert, which takes the projection from the network.
fn projected(
    folder: &Path,
    netconvert: &Path,
    places_deg: &BTreeMap<i64, [f64; 2]>,
    options: &ImportOptions,
) -> Result<BTreeMap<i64, DVec2>, MapError> {
    let mut text = String::from("<osm version=\"0.6\">\n");
    for (id, [latitude, longitude]) in places_deg {
        let _ = writeln!(
            text,
            "<node id=\"{id}\" lat=\"{latitude}\" lon=\"{longitude}\"><tag k=\"amenity\" v=\"sign\"/></node>"
        );
    }
    text += "</osm>\n";
    let [points, written] = [POINTS, PROJECTED].map(|name| folder.join(name));
    let failed = |source| MapError::Io { file: points.clone(), source };
    let read = private::replace(&points, text.as_bytes())
        .map_err(failed)
        .and_then(|()| {
            netconvert::polygons(netconvert, &[points.as_path()], &folder.join("net.xml"), &written, options)
        })
        .and_then(|()| document::read_text(&written, MOST_IMPORT_BYTES).map_err(failed));
    for file in [&points, &written] {
        let _ = std::fs::remove_file(file);
    }
    let text = read?;
    let tree = Document::parse(&text).map_err(|error| failed(std::io::Error::other(error)))?;
    let point = |node: roxmltree::Node| {
        let number = |name: &str| node.attribute(name)?.parse::<f64>().ok().filter(|number| number.is_finite());
        Some((node.attribute("id")?.parse().ok()?, dvec2(number("x")?, number("y")?)))
    };
    Ok(tree.descendants().filter(|node| node.has_tag_name("poi")).filter_map(point).collect())
}

/// Places the signs at the roads, and counts those that are left out.
fn placed(nodes: &[SignNode], points: &BTreeMap<i64, DVec2>, lanes: &CarLanes) -> FoundSigns {
    let mut found = FoundSigns::default();
    let mut others: BTreeMap<&str, usize> = BTreeMap::new();
    let mut reasons: BTreeMap<&str, usize> = BTreeMap::new();
    for node in nodes {
        node.signs.others.iter().for_each(|value| *others.entry(value).or_default() += 1);
        let Some(at) = points.get(&node.id).copied() else { continue };
        let place = |id: &Option<i64>| id.as_ref().and_then(|id| points.get(id)).copied();
        let at_road = NodeAtRoad {
            at,
            around: node.on_ways.iter().map(|[before, after]| [place(before), place(after)]).collect(),
            is_on_path: node.is_on_path,
        };
        for (kind, holds) in &node.signs.signs {
            match lanes.signs(&at_road, *kind, *holds) {
                Ok(signs) => found.signs.extend(signs),
                Err(reason) => *reasons.entry(reason).or_default() += 1,
            }
        }
    }
    let mut others: Vec<(&str, usize)> = others.into_iter().collect();
    others.sort_by_key(|(value, count)| (std::cmp::Reverse(*count), *value));
    let all: usize = others.iter().map(|(_, count)| count).sum();
    let told: Vec<String> = others.iter().take(VALUES_TOLD).map(|(value, count)| format!("{count} {value}")).collect();
    let more = if others.len() > VALUES_TOLD { ", ..." } else { "" };
    if all > 0 {
        found.notes.push(format!("other signs    {all} that are not drawn: {}{more}", told.join(", ")));
    }
    found
        .notes
        .extend(reasons.iter().map(|(reason, count)| format!("               {count} signs left out: {reason}")));
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{
        import::{DrivingSide, import_into},
        network::Network,
        surroundings::StatedSignKind::{self, PlaceName, Roundabout, SpeedLimit, Stop, Yield},
    };
    use std::sync::atomic::AtomicBool;

    static STOP: AtomicBool = AtomicBool::new(false);
    /// Lengths of a degree to the north and to the east at 50 degrees north, metres (WGS 84).
    const DEGREE_M: [f64; 2] = [111_229.0, 71_698.0];

    /// Node so many metres north and east of the crossing of the streets.
    fn node(id: u32, [north_m, east_m]: [f64; 2], tags: &[[&str; 2]]) -> String {
        let tags: String = tags.iter().map(|[k, v]| format!("<tag k=\"{k}\" v=\"{v}\"/>")).collect();
        let (latitude, longitude) = (50.0 + north_m / DEGREE_M[0], 8.0 + east_m / DEGREE_M[1]);
        format!("<node id=\"{id}\" lat=\"{latitude}\" lon=\"{longitude}\">{tags}</node>")
    }

    fn way(id: u32, nodes: &[u32], kind: &str) -> String {
        let nodes: String = nodes.iter().map(|node| format!("<nd ref=\"{node}\"/>")).collect();
        format!("<way id=\"{id}\">{nodes}<tag k=\"highway\" v=\"{kind}\"/></way>")
    }

    fn imported(elements: &str, side: Option<DrivingSide>) -> (Vec<String>, Network) {
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("place.osm");
        std::fs::write(&file, format!("<osm version=\"0.6\">{elements}</osm>")).expect("written");
        let netconvert = Path::new(env!("CODRIVE_ROOT")).join(".sumo/sumo/bin/netconvert");
        let options = ImportOptions { seconds: 60, memory_mib: 1024, stop: &STOP, side };
        let made = import_into(&folder.path().join("maps"), &netconvert, &file, "place", &options).expect("imported");
        assert!(!made.folder.join(POINTS).exists() && !made.folder.join(PROJECTED).exists());
        let net = Network::load(&made.folder.join("net.xml").to_string_lossy()).expect("a network");
        (made.report.notes, net)
    }

    /// A sign is expected where polyconvert puts a tree of the file, in the order of the trees.
    #[test]
    fn signs_among_the_nodes_stand_beside_the_road_on_the_side_of_traffic() {
        // A street to the east and one to the north, two lanes of 3.2 m: the poles are 3.2 m and 0.95 m from their middle.
        let aside_m = 4.15;
        for (side, right_m) in [(None, aside_m), (Some(DrivingSide::Left), -aside_m)] {
            let elements = [
                node(1, [0.0, -200.0], &[]),
                node(2, [0.0, 0.0], &[]),
                node(3, [0.0, 200.0], &[]),
                node(4, [200.0, 0.0], &[]),
                node(5, [60.0, 0.0], &[["highway", "stop"], ["direction", "backward"]]),
                node(6, [0.0, -150.0], &[["traffic_sign:forward", "DE:274[30]"]]),
                node(7, [0.0, 100.0], &[["traffic_sign", "city_limit"], ["direction", "90"], ["name", "Ulm"]]),
                // Beside the roads: one keeps its place, one is on the road, and one is at a footpath.
                node(8, [100.0, -12.0], &[["traffic_sign", "DE:205,DE:215;DE:283"], ["direction", "180"]]),
                node(9, [-0.5, -80.0], &[["traffic_sign", "DE:206"], ["direction", "W"]]),
                node(10, [30.0, 40.0], &[["highway", "give_way"]]),
                // A direction is missing, and no road is near.
                node(11, [0.0, 50.0], &[["traffic_sign", "DE:274-50"]]),
                node(12, [900.0, 0.0], &[["traffic_sign", "DE:206,hazard"]]),
                node(13, [30.0, 90.0], &[]),
                node(14, [-300.0, 0.0], &[["place", "town"], ["name", "Ulm"]]),
                // Trees where signs are expected.
                node(21, [60.0, -right_m], &[["natural", "tree"]]),
                node(22, [-right_m, -150.0], &[["natural", "tree"]]),
                node(23, [right_m, 100.0], &[["natural", "tree"]]),
                node(24, [100.0, -12.0], &[["natural", "tree"]]),
                node(25, [-right_m, -80.0], &[["natural", "tree"]]),
                way(31, &[1, 6, 2, 11, 7, 3], "secondary"),
                way(32, &[2, 5, 4], "residential"),
                way(33, &[10, 13], "footway"),
            ];
            let (notes, net) = imported(&elements.concat(), side);
            let found = net.surroundings();
            // Each faces those who come: from the north, west, east, south (180 degrees) and west.
            let expected: [(usize, StatedSignKind, f64); 6] = [
                (0, Stop, 90.0),
                (1, SpeedLimit(30), 180.0),
                (2, PlaceName, 0.0),
                (3, Yield, -90.0),
                (3, Roundabout, -90.0),
                (4, Stop, 180.0),
            ];
            assert_eq!(found.signs.len(), expected.len(), "{found:?}");
            for (sign, (tree, kind, facing_deg)) in found.signs.iter().zip(expected) {
                let place = found.trees[tree].position;
                assert!(sign.kind == kind && sign.position.distance(place) < 0.1, "{sign:?}, not {kind:?} at {place}");
                // The grid's north is 0.8 degrees from the true one.
                let off_deg = (sign.facing_rad.to_degrees() - facing_deg + 180.0).rem_euclid(360.0) - 180.0;
                assert!(off_deg.abs() < 1.0, "{sign:?} does not face {facing_deg} degrees");
            }
            for line in [
                "signs          6",
                "other signs    2 that are not drawn: 1 DE:283, 1 hazard",
                "               1 signs left out: no road of the network is near",
                "               1 signs left out: the file does not say for which direction they hold",
                "               1 signs left out: they stand at ways that are not for cars",
            ] {
                assert!(notes.iter().any(|note| note == line), "{line}: {notes:?}");
            }
        }
    }

    #[test]
    fn a_stop_without_a_direction_holds_towards_the_nearer_junction() {
        let elements = [
            node(1, [0.0, -200.0], &[]),
            node(2, [0.0, 0.0], &[]),
            node(3, [0.0, 200.0], &[]),
            node(4, [200.0, 0.0], &[]),
            // The way is divided 100 m before its junction; another sign is at the junction itself, of which it is not known whose it is.
            node(5, [120.0, 0.0], &[["highway", "stop"]]),
            node(6, [100.0, 0.0], &[]),
            way(31, &[1, 2, 3], "secondary"),
            way(32, &[4, 5, 6], "residential"),
            way(33, &[6, 2], "residential"),
        ];
        let (_, net) = imported(&elements.concat(), None);
        let [stop] = net.surroundings().signs[..] else { panic!("{:?}", net.surroundings()) };
        // It faces north, towards those who drive south to the junction.
        assert!((stop.facing_rad.to_degrees() - 90.0).abs() < 1.0, "{stop:?}");
    }
}
