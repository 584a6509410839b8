//! Checks a network for errors on which SUMO would crash. In: a `net.xml` as XML. Out: nothing, or the first element with an invalid
//! value. SUMO does not verify most of this, and an error crashes the whole program. Values of lanes are checked when they are read
//! (`network`); this file checks references between elements: junctions and their rules, signals, connections, boundaries.

use super::{MapError, limits::MOST_LANES_OF_ONE, net_xml::NetReader, xml_tree::Element};
use crate::sumo_xml::vocabulary::SIGNAL_TYPES;
use std::collections::{BTreeMap, BTreeSet};

const EDGE_FUNCTIONS: &str = "normal internal connector crossing walkingarea roundabout_edge";
const JUNCTION_TYPES: &str = "traffic_light traffic_light_unregulated traffic_light_right_on_red priority \
                              priority_stop right_before_left left_before_right allway_stop zipper rail_signal \
                              rail_crossing unregulated internal dead_end district unknown";
const SIGNALS: &str = "rRgGyYoOsSuU";
const LINK_STATES: &str = "-=oOrRgGyYuUmMswaZ";
/// Allowed directions; "T" is a U-turn with left-hand traffic.
const DIRECTIONS: &str = "s t T l r L R invalid";

/// Largest number of links of a junction in SUMO.
const MOST_LINKS: usize = 256;

/// Names that elements may refer to.
#[derive(Default)]
struct KnownNames<'a> {
    edges: BTreeMap<&'a str, EdgeEnds<'a>>,
    lanes: BTreeSet<&'a str>,
    junctions: BTreeSet<&'a str>,
    /// Length of the shortest state of each signal.
    signals: BTreeMap<&'a str, usize>,
    /// Junctions of railways; SUMO makes their signals itself if the file has none.
    railways: BTreeSet<&'a str>,
}

/// Properties of an edge that its connections must match.
struct EdgeEnds<'a> {
    lanes: usize,
    /// True for the inside of a junction for vehicles.
    internal: bool,
    /// Junctions at the edge's start and end.
    from: Option<&'a str>,
    to: Option<&'a str>,
}

/// Target lane of a connection: edge and index.
type GoalLane<'a> = (&'a str, &'a str);

/// Connections through junctions, collected while connections are checked.
#[derive(Default)]
struct JunctionWays<'a> {
    /// All connections as pairs of origin and target.
    known: BTreeSet<(GoalLane<'a>, GoalLane<'a>)>,
    /// Target of the connection whose `via` is this internal lane.
    over: BTreeMap<&'a str, GoalLane<'a>>,
    /// Target of each internal lane, by the lane's id.
    out: BTreeMap<String, GoalLane<'a>>,
}

/// Checks all elements below the root.
pub(super) fn check(reader: &NetReader, root: Element) -> Result<(), MapError> {
    let names = known_names(reader, root)?;
    version(reader, root, &names)?;
    let mut ways = JunctionWays::default();
    for node in root.children() {
        match node.name() {
            "edge" => ends(reader, node, &names)?,
            "junction" => junction(reader, node, &names)?,
            "connection" => connection(reader, node, &names, &mut ways)?,
            "roundabout" => roundabout(reader, node, &names)?,
            _ => {}
        }
    }
    insides(reader, root, &names, &ways)
}

/// Returns the names of all elements; checks edges, signals and the location, which refer to no other element.
fn known_names<'a>(reader: &NetReader, root: Element<'a>) -> Result<KnownNames<'a>, MapError> {
    let mut names = KnownNames::default();
    for node in root.children() {
        match node.name() {
            "edge" => edge(reader, node, &mut names)?,
            "junction" => junction_name(reader, node, &mut names)?,
            "tlLogic" => signal(reader, node, &mut names)?,
            "location" => location(reader, node)?,
            _ => {}
        }
    }
    for id in &names.railways {
        names.signals.entry(id).or_insert(MOST_LINKS);
    }
    Ok(names)
}

fn junction_name<'a>(reader: &NetReader, node: Element<'a>, names: &mut KnownNames<'a>) -> Result<(), MapError> {
    let id = reader.text(node, "id")?;
    if !names.junctions.insert(id) {
        return Err(reader.value(node, "id", "a name that no other junction has"));
    }
    if matches!(node.attribute("type"), Some("rail_signal" | "rail_crossing")) {
        names.railways.insert(id);
    }
    Ok(())
}

fn location(reader: &NetReader, node: Element) -> Result<(), MapError> {
    let sound = |text: &str| {
        let numbers: Vec<&str> = text.split(',').take(5).collect();
        [2, 4].contains(&numbers.len()) && numbers.iter().all(|x| number(x).is_some())
    };
    for attribute in ["netOffset", "convBoundary", "origBoundary"] {
        if node.attribute(attribute).is_some_and(|text| !sound(text)) {
            return Err(reader.value(node, attribute, "2 or 4 finite numbers with commas between"));
        }
    }
    Ok(())
}

fn version(reader: &NetReader, root: Element, names: &KnownNames) -> Result<(), MapError> {
    let version = root.attribute("version").and_then(|version| version.split_once('.'));
    let versioned = version.is_some_and(|(a, b)| a.parse::<u16>().is_ok() && b.parse::<u16>().is_ok());
    match versioned || names.junctions.is_empty() {
        true => Ok(()),
        false => Err(reader.value(root, "version", "the version of the format, such as 1.20")),
    }
}

fn roundabout(reader: &NetReader, node: Element, names: &KnownNames) -> Result<(), MapError> {
    let has_all = |attribute: &str, is_known: &dyn Fn(&str) -> bool| {
        node.attribute(attribute).unwrap_or_default().split_whitespace().all(is_known)
    };
    if !has_all("edges", &|id| names.edges.contains_key(id)) {
        return Err(reader.value(node, "edges", "ids of edges of this network"));
    }
    if !has_all("nodes", &|id| names.junctions.contains(id)) {
        return Err(reader.value(node, "nodes", "ids of junctions of this network"));
    }
    Ok(())
}

/// Checks that each internal lane has one connection in and one out, both with the same target lane.
fn insides(reader: &NetReader, root: Element, names: &KnownNames, ways: &JunctionWays) -> Result<(), MapError> {
    if names.junctions.is_empty() {
        return Ok(());
    }
    let inside = |edge: &Element| edge.attribute("function") == Some("internal");
    for edge in root.children_named("edge").filter(inside) {
        for lane in edge.children_named("lane") {
            let id = lane.attribute("id").unwrap_or_default();
            let (over, out) = (ways.over.get(id), ways.out.get(id));
            if over.is_none() {
                return Err(reader.value(lane, "id", "a lane inside a junction that is the via of one connection"));
            }
            if out != over {
                return Err(reader.value(
                    lane,
                    "id",
                    "a lane inside a junction that leads to the same lane as its connection",
                ));
            }
        }
    }
    Ok(())
}

fn number(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|x: &f64| x.is_finite())
}

fn one_of(list: &str, word: &str) -> bool {
    list.split_whitespace().any(|known| known == word)
}

fn edge<'a>(reader: &NetReader, node: Element<'a>, names: &mut KnownNames<'a>) -> Result<(), MapError> {
    let id = reader.text(node, "id")?;
    let lanes = node.children_named("lane");
    // netconvert gives some lanes inside junctions the index of another; their ids are right.
    let has_indices = node.attribute("function") != Some("internal");
    let mut n = 0;
    for lane in lanes {
        let lane_id = reader.text(lane, "id")?;
        if has_indices && lane.attribute("index").is_some_and(|index| index.trim().parse() != Ok(n)) {
            return Err(reader.value(lane, "index", "the lane's place in its edge: 0, 1, 2 and so on from the right"));
        }
        if lane_id.strip_prefix(id).and_then(|rest| rest.strip_prefix('_')).and_then(|index| index.parse().ok())
            != Some(n)
        {
            return Err(reader.value(lane, "id", "the edge's id, an underscore and the lane's place in it"));
        }
        if !names.lanes.insert(lane_id) {
            return Err(reader.value(lane, "id", "a name that no other lane has"));
        }
        n += 1;
        if n > MOST_LANES_OF_ONE {
            return Err(reader.value(lane, "index", "at most 32 lanes in an edge"));
        }
        for attribute in ["endOffset", "acceleration"] {
            if lane.attribute(attribute).is_some_and(|text| number(text).is_none_or(|x| !(0.0..=1e5).contains(&x))) {
                return Err(reader.value(lane, attribute, "a finite number of 0 or more, at most 100000"));
            }
        }
    }
    if n == 0 {
        return Err(reader.value(node, "lane", "at least one lane in each edge"));
    }
    let internal = node.attribute("function") == Some("internal");
    let (from, to) = (node.attribute("from"), node.attribute("to"));
    if names.edges.insert(id, EdgeEnds { lanes: n, internal, from, to }).is_some() {
        return Err(reader.value(node, "id", "a name that no other edge has"));
    }
    if node.attribute("function").is_some_and(|function| !one_of(EDGE_FUNCTIONS, function)) {
        return Err(reader.value(node, "function", EDGE_FUNCTIONS));
    }
    if node.attribute("priority").is_some_and(|text| text.trim().parse::<i32>().is_err()) {
        return Err(reader.value(node, "priority", "a whole number"));
    }
    if node.attribute("length").is_some() {
        reader.within(node, "length", &super::limits::LENGTH_M, "a number from 0.001 to 100000 m")?;
    }
    if node.has_attribute("shape") {
        reader.shape(node, 2)?;
    }
    Ok(())
}

/// Checks that edges outside junctions lead from a junction to a junction. A network without any junction is exempt: only this program
/// reads it.
fn ends(reader: &NetReader, node: Element, names: &KnownNames) -> Result<(), MapError> {
    if node.attribute("bidi").is_some_and(|id| !names.edges.contains_key(id)) {
        return Err(reader.value(node, "bidi", "the id of an edge of this network: the same track the other way"));
    }
    let inside = matches!(node.attribute("function"), Some("internal" | "crossing" | "walkingarea"));
    if inside || names.junctions.is_empty() {
        return Ok(());
    }
    for attribute in ["from", "to"] {
        if !names.junctions.contains(node.attribute(attribute).unwrap_or_default()) {
            return Err(reader.value(node, attribute, "the id of a junction of this network"));
        }
    }
    Ok(())
}

fn junction(reader: &NetReader, node: Element, names: &KnownNames) -> Result<(), MapError> {
    let kind = node.attribute("type").unwrap_or_default();
    if !one_of(JUNCTION_TYPES, kind) {
        return Err(reader.value(node, "type", JUNCTION_TYPES));
    }
    for attribute in ["x", "y"] {
        reader.coordinate(node, attribute)?;
    }
    if node.has_attribute("z") {
        reader.coordinate(node, "z")?;
    }
    if node.attribute("shape").is_some_and(|shape| !shape.trim().is_empty()) {
        reader.shape(node, 1)?;
    }
    for attribute in ["incLanes", "intLanes"] {
        let lanes = node.attribute(attribute).unwrap_or_default();
        if lanes.split_whitespace().any(|id| !names.lanes.contains(id)) {
            return Err(reader.value(node, attribute, "ids of lanes of this network"));
        }
    }
    requests(reader, node)
}

/// Checks the right of way of a junction's links.
fn requests(reader: &NetReader, node: Element) -> Result<(), MapError> {
    let inside = node.attribute("intLanes").unwrap_or_default().split_whitespace().count();
    let requests = || node.children_named("request");
    let n = requests().count();
    if n > 0 && inside > 0 && n != inside {
        return Err(reader.value(node, "intLanes", "as many lanes as the junction has requests, or none"));
    }
    for (k, request) in requests().enumerate() {
        if request.attribute("index").and_then(|text| text.trim().parse().ok()) != Some(k) {
            return Err(reader.value(request, "index", "the request's place in its junction: 0, 1, 2 and so on"));
        }
        for attribute in ["response", "foes"] {
            let bits = request.attribute(attribute).unwrap_or_default();
            if bits.len() != n || bits.bytes().any(|bit| !b"01".contains(&bit)) {
                return Err(reader.value(request, attribute, "a 0 or 1 for each request of its junction"));
            }
        }
        if request.attribute("cont").is_some_and(|cont| !one_of("0 1 true false", cont)) {
            return Err(reader.value(request, "cont", "0 or 1"));
        }
    }
    Ok(())
}

fn signal<'a>(reader: &NetReader, node: Element<'a>, names: &mut KnownNames<'a>) -> Result<(), MapError> {
    let id = reader.text(node, "id")?;
    if node.attribute("offset").is_some_and(|text| text.trim() != "begin" && number(text).is_none()) {
        return Err(reader.value(node, "offset", "a finite number, seconds"));
    }
    let length = phases(reader, node)?;
    if !node.attribute("type").is_some_and(|kind| one_of(SIGNAL_TYPES, kind)) {
        return Err(reader.value(node, "type", SIGNAL_TYPES));
    }
    // A signal may have several programs.
    let shortest = names.signals.entry(id).or_insert(length);
    *shortest = length.min(*shortest);
    Ok(())
}

/// Checks the phases of a signal's program, and returns the number of letters in each.
fn phases(reader: &NetReader, node: Element) -> Result<usize, MapError> {
    let mut length = None;
    for phase in node.children_named("phase") {
        for attribute in ["duration", "minDur", "maxDur"] {
            let sound = |text: &str| number(text).is_some_and(|s| (0.0..=1e9).contains(&s));
            if !phase.attribute(attribute).map_or(attribute != "duration", sound) {
                return Err(reader.value(phase, attribute, "a number from 0 to 1e9, seconds"));
            }
        }
        let state = phase.attribute("state").unwrap_or_default();
        if state.is_empty() || state.chars().any(|c| !SIGNALS.contains(c)) {
            return Err(reader.value(phase, "state", "a letter of rRgGyYoOsSuU for each link"));
        }
        if length.is_some_and(|length| length != state.len()) {
            return Err(reader.value(phase, "state", "as many letters as in the phase before"));
        }
        length = Some(state.len());
    }
    length.ok_or_else(|| reader.value(node, "phase", "at least one phase in each signal"))
}

fn connection<'a>(
    reader: &NetReader,
    node: Element<'a>,
    names: &KnownNames,
    ways: &mut JunctionWays<'a>,
) -> Result<(), MapError> {
    let end = |edge_name: &str, lane_name: &str| {
        let id = reader.text(node, edge_name)?;
        let Some(edge) = names.edges.get(id) else {
            return Err(reader.value(node, edge_name, "the id of an edge of this network"));
        };
        let text = node.attribute(lane_name).unwrap_or_default();
        if text.parse().is_ok_and(|index: usize| index < edge.lanes && text == index.to_string()) {
            return Ok((edge, (id, text)));
        }
        Err(reader.value(node, lane_name, "the index of a lane of that edge, the right-most being 0"))
    };
    let ((from, from_lane), (to, to_lane)) = (end("from", "fromLane")?, end("to", "toLane")?);
    if !ways.known.insert((from_lane, to_lane)) {
        return Err(reader.value(node, "toLane", "one connection from a lane to another"));
    }
    if !from.internal && !to.internal && from.to != to.from && from.to.is_some() && to.from.is_some() {
        return Err(reader.value(node, "to", "an edge that begins at the junction where the other ends"));
    }
    if from.internal {
        ways.out.insert(format!("{}_{}", from_lane.0, from_lane.1), to_lane);
    }
    if let Some(via) = node.attribute("via") {
        if !names.lanes.contains(via) {
            return Err(reader.value(node, "via", "the id of a lane of this network"));
        }
        if ways.over.insert(via, to_lane).is_some() {
            return Err(reader.value(node, "via", "a lane that is the via of no other connection"));
        }
    }
    if node.attribute("dir").is_some_and(|dir| !one_of(DIRECTIONS, dir)) {
        return Err(reader.value(node, "dir", DIRECTIONS));
    }
    if node.attribute("state").is_some_and(|state| state.chars().count() != 1 || !LINK_STATES.contains(state)) {
        return Err(reader.value(node, "state", LINK_STATES));
    }
    signal_link(reader, node, names)
}

/// Checks the signal of a connection, if it has one.
fn signal_link(reader: &NetReader, node: Element, names: &KnownNames) -> Result<(), MapError> {
    let Some(signal) = node.attribute("tl") else { return Ok(()) };
    let Some(length) = names.signals.get(signal) else {
        return Err(reader.value(node, "tl", "the id of a tlLogic of this network"));
    };
    for attribute in ["linkIndex", "linkIndex2"] {
        let text = node.attribute(attribute);
        let free = names.railways.contains(signal) && text.is_some_and(|text| text.trim() == "-1");
        let inside = free || text.is_some_and(|text| text.trim().parse().is_ok_and(|k: usize| k < *length));
        if !inside && (text.is_some() || attribute == "linkIndex") {
            return Err(reader.value(node, attribute, "the place of a letter in the states of its signal"));
        }
    }
    Ok(())
}
