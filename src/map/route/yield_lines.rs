//! Lines of the ego's path where others have right of way. In: a [`RoadMap`]. Out: for each line the position on the route, the stop rule,
//! the links that it yields to and the lanes of their vehicles. Metres.
//!
//! The right of way is the one in the network's file for the links of each junction. A link that waits inside its junction, such as a left
//! turn across oncoming traffic, has its line there, at the end of its first internal lane.

use crate::map::{
    RoadMap,
    network::{Connection, JunctionId, LaneId, LinkState, Network, SignalId},
};

/// Distance before its line from which a vehicle with right of way is considered, metres.
const FOE_AHEAD_M: f64 = 100.0;

/// Stop rule of a line, independent of other vehicles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopRule {
    /// Stop for vehicles with right of way only.
    None,
    /// Mandatory stop, for this link only.
    Stop,
    /// Mandatory stop on all links of the junction; vehicles go in the order of arrival.
    Allway,
}

/// A link that a line yields to.
#[derive(Clone, Debug, PartialEq)]
pub struct FoeLink {
    /// Index of the link in the junction's rules.
    #[cfg(test)]
    pub link: usize,
    /// Length through the junction, metres.
    pub length_m: f64,
    /// Signal, and the index of the link's letter in it.
    pub signal: Option<(SignalId, u32)>,
    /// True if it leads into the same lane as the path.
    pub joins: bool,
}

/// A lane of vehicles on a link that a line yields to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoeLane {
    pub lane: LaneId,
    /// Index in `YieldLine::foes` of the link.
    pub foe: usize,
    /// Position of that link's line along this lane, metres: below 0 inside the junction, beyond the lane's end on lanes further back.
    pub line_at_m: f64,
    /// Speed limit, m/s.
    pub limit_mps: f64,
}

/// A line where the path yields or stops.
#[derive(Clone, Debug, PartialEq)]
pub struct YieldLine {
    /// Junction behind the line, or around it.
    pub junction: JunctionId,
    /// Position on the route, metres.
    pub s_m: f64,
    /// Length from the line to the end of the junction, metres.
    pub inside_m: f64,
    /// Rule for stopping at the line.
    pub stop: StopRule,
    /// True if vehicles of this link and of its foes merge alternately, so that the ego follows the one ahead of it instead of waiting.
    pub is_zipper: bool,
    /// True if the line is inside the junction.
    pub waits_inside: bool,
    /// Signal of the ego's link, and the index of the link's letter in it.
    pub signal: Option<(SignalId, u32)>,
    /// Links with right of way over this line's.
    pub foes: Vec<FoeLink>,
    /// Lanes of vehicles on these links, sorted by lane.
    pub foe_lanes: Vec<FoeLane>,
}

/// Returns the lines of a map's route in driving order; `lanes` are the network's lanes of the route's.
pub fn yield_lines(map: &RoadMap, lanes: &[Option<LaneId>]) -> Vec<YieldLine> {
    let mut lines: Vec<YieldLine> = (0..lanes.len()).filter_map(|k| yield_line(map, lanes, k)).collect();
    lines.sort_by(|a, b| a.s_m.total_cmp(&b.s_m));
    lines
}

/// Returns the line at the end of the route's lane `k`, if the ego yields or stops there.
fn yield_line(map: &RoadMap, lanes: &[Option<LaneId>], k: usize) -> Option<YieldLine> {
    let (net, route) = (&map.network, &map.route);
    let next = |k: usize| (k + 1) % lanes.len();
    let (from, to) = (lanes[k]?, lanes[route.next_lane(k)?]?);
    if !net.edge_of(from).kind.is_street() {
        return None;
    }
    let way = net.connections_from(from).iter().find(|connection| connection.next() == to)?;
    let junction = net.junction_after(from)?;
    let rule = net.junction(junction).links.get(way.link? as usize)?;
    let stop = match way.state {
        LinkState::Stop => StopRule::Stop,
        LinkState::AllwayStop | LinkState::AllwayStopOld => StopRule::Allway,
        _ => StopRule::None,
    };
    let (mut foes, mut foe_lanes) = (Vec::new(), Vec::new());
    for link in rule.yields_to.iter() {
        let Some(other) = net.junction(junction).links.get(link).and_then(|rule| rule.connection) else { continue };
        let other = net.connection(other);
        // Vehicles in the own lane are leaders; pedestrians on crossings are not vehicles.
        if other.from == from || !net.edge_of(other.from).kind.is_street() {
            continue;
        }
        let joins = other.to == way.to;
        let inside = inside(net, other);
        let length_m = match inside.is_empty() {
            true => gap_m(net, other),
            false => inside.iter().map(|lane| net.lane(*lane).length_m).sum(),
        };
        add_lanes(net, other, foes.len(), &inside, way.to, &mut foe_lanes);
        foes.push(FoeLink {
            #[cfg(test)]
            link,
            length_m,
            signal: letter(other),
            joins,
        });
    }
    if foes.is_empty() && stop == StopRule::None {
        return None;
    }
    foe_lanes.sort_by_key(|lane| lane.lane);
    let here = &route.lanes()[k];
    let through: Vec<usize> = std::iter::successors(Some(next(k)), |k| Some(next(*k)))
        .take(lanes.len())
        .take_while(|k| route.lanes()[*k].is_bridge() || lanes[*k].is_some_and(|lane| is_inside(net, lane, junction)))
        .collect();
    let length_m = |k: &usize| route.lanes()[*k].length_m;
    let inside_m: f64 = through.iter().map(length_m).sum();
    let waits_inside = rule.waits_inside && through.len() > 1;
    let (s_m, inside_m) = match waits_inside {
        true => (here.start_s_m + here.length_m + length_m(&through[0]), inside_m - length_m(&through[0])),
        false => (here.start_s_m + here.length_m - net.lane(from).end_offset_m, inside_m),
    };
    let is_zipper = way.state == LinkState::Zipper;
    Some(YieldLine {
        junction,
        s_m: route.wrap(s_m),
        inside_m,
        stop,
        is_zipper,
        waits_inside,
        signal: letter(way),
        foes,
        foe_lanes,
    })
}

/// Returns the distance from the end of one lane to the start of the next, metres.
fn gap_m(net: &Network, way: &Connection) -> f64 {
    let (before, after) = (net.lane(way.from).line.points(), net.lane(way.to).line.points());
    before[before.len() - 1].distance(after[0])
}

fn letter(way: &Connection) -> Option<(SignalId, u32)> {
    way.signal.and_then(|ruled| Some((ruled.signal, ruled.index?)))
}

fn is_inside(net: &Network, lane: LaneId, junction: JunctionId) -> bool {
    let edge = net.edge_of(lane);
    !edge.kind.is_street() && net.junction_after(lane) == Some(junction)
}

/// Returns the internal lanes of a connection, in driving order.
fn inside(net: &Network, way: &Connection) -> Vec<LaneId> {
    let mut lanes = Vec::new();
    let mut next = way.via;
    // netconvert makes two or three; the limit ends the search in a network with a loop there.
    while let Some(lane) = next.filter(|_| lanes.len() < 16) {
        lanes.push(lane);
        next = net.connections_from(lane).iter().find(|connection| connection.to == way.to).and_then(|on| on.via);
    }
    lanes
}

/// Adds the lanes of vehicles on a link. They are the internal lanes, the lane beyond, from which rears still reach into the junction, and
/// the lane that leads into it. Lanes further back are added as long as vehicles neither yield nor pass a signal on the way. The lane
/// `own_to`, into which the path leads, is not added: a vehicle there is the ego's leader.
fn add_lanes(net: &Network, way: &Connection, foe: usize, inside: &[LaneId], own_to: LaneId, found: &mut Vec<FoeLane>) {
    let mut put = |lane: LaneId, line_at_m: f64| {
        let is_new = lane != own_to && !found.iter().any(|known| known.foe == foe && known.lane == lane);
        if is_new {
            found.push(FoeLane { lane, foe, line_at_m, limit_mps: net.lane(lane).speed_limit_mps });
        }
        is_new
    };
    let mut line_at_m = 0.0;
    for &lane in inside {
        put(lane, line_at_m);
        line_at_m -= net.lane(lane).length_m;
    }
    put(way.to, line_at_m);
    let end_m = |lane: LaneId| net.lane(lane).length_m;
    let mut open = vec![(way.from, end_m(way.from) - net.lane(way.from).end_offset_m)];
    while let Some((lane, line_at_m)) = open.pop() {
        if !put(lane, line_at_m) || line_at_m >= FOE_AHEAD_M {
            continue;
        }
        for &before in net.predecessors(lane) {
            let on = net.connections_from(before).iter().find(|on| on.next() == lane);
            if on.is_some_and(|on| on.signal.is_none() && !yields(net, on)) {
                open.push((before, end_m(before) + line_at_m));
            }
        }
    }
}

/// Returns true if a connection yields to any other.
fn yields(net: &Network, way: &Connection) -> bool {
    let rules = net.junction_after(way.from).map(|junction| &net.junction(junction).links);
    let rule = rules.zip(way.link).and_then(|(rules, link)| rules.get(link as usize));
    rule.is_some_and(|rule| rule.yields_to.iter().next().is_some())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(file: &str, edges: &[&str]) -> (RoadMap, Vec<YieldLine>) {
        let map = RoadMap::load_along(file, edges).expect("a path");
        let lanes: Vec<_> = map.route.lanes().iter().map(|lane| lane.lane).collect();
        let lines = yield_lines(&map, &lanes);
        (map, lines)
    }

    fn links(line: &YieldLine) -> Vec<usize> {
        line.foes.iter().map(|foe| foe.link).collect()
    }

    /// Returns the lanes of a link with the position of its line on each, in centimetres, sorted by name.
    fn places(map: &RoadMap, line: &YieldLine, foe: usize) -> Vec<(String, i64)> {
        let of = line.foe_lanes.iter().filter(|lane| lane.foe == foe);
        let place = |lane: &FoeLane| (map.network.lane(lane.lane).id.clone(), (lane.line_at_m * 100.0).round() as i64);
        let mut places: Vec<_> = of.map(place).collect();
        places.sort();
        places
    }

    #[test]
    fn a_roundabouts_entry_yields_to_its_ring_and_the_ring_does_not_yield() {
        let (map, lines) = lines("tests/data/networks/roundabout.net.xml", &["Ss", "se", "en", "nN"]);
        // Junction s: request 0, from Ss, has the response 100: link 2, from ws to se. Requests of the ring have none.
        assert_eq!(lines.len(), 1);
        let line = &lines[0];
        assert_eq!((links(line), line.stop, line.waits_inside, line.signal), (vec![2], StopRule::None, false, None));
        assert_eq!((line.s_m, line.inside_m), (124.07, 7.82), "the lengths of Ss_0 and :s_0_0");
        assert_eq!((line.foes[0].length_m, line.foes[0].joins), (12.36, true), ":s_2_0 leads to se, too");
        // Back along the ring, whose lanes have 21.28 m and 12.36 m in turn; a vehicle that enters the ring counts from its line on.
        let expected = [
            (":e_0_0", 9638),
            (":e_2_0", 10092),
            (":n_0_0", 6274),
            (":n_2_0", 6728),
            (":s_2_0", 0),
            (":w_1_0", 3364),
            (":w_2_0", 2910),
            ("en_0", 8856),
            ("nw_0", 5492),
            ("ws_0", 2128),
        ];
        assert_eq!(places(&map, line, 0), expected.map(|(lane, cm)| (lane.to_owned(), cm)));
    }

    #[test]
    fn a_left_turn_at_a_signal_waits_inside_the_junction_for_oncoming_traffic() {
        let (map, lines) = lines("tests/data/networks/grid-signals.net.xml", &["B0B1", "B1A1"]);
        // Junction B1: request 13 (linkIndex 13, from B0B1 to B1A1) has the response 01000000000100000110: links 1, 2, 8 and 18.
        let line = &lines[0];
        assert_eq!((lines.len(), links(line), line.waits_inside), (1, vec![1, 2, 8, 18], true));
        let signal = map.network.signals().iter().position(|signal| signal.id == "B1").map(SignalId::from_index);
        assert_eq!(line.signal, signal.map(|signal| (signal, 13)));
        let letters: Vec<_> = line.foes.iter().map(|foe| foe.signal.expect("a letter").1).collect();
        assert_eq!(letters, [1, 2, 8, 18]);
        // B0B1_1 has 69.20 m, :B1_13_0 5.01 m and :B1_24_0 14.34 m; B2B1_1 has 69.20 m, :B1_1_1 20.80 m.
        assert!((line.s_m - 74.21).abs() < 1e-9 && (line.inside_m - 14.34).abs() < 1e-9, "{line:?}");
        let expected = [(":B1_1_1", 0), ("B1B0_1", -2080), ("B2B1_1", 6920)];
        let found = places(&map, line, 1);
        let here: Vec<_> = found.into_iter().filter(|(lane, _)| !lane.starts_with(":B2")).collect();
        assert_eq!(here, expected.map(|(lane, cm)| (lane.to_owned(), cm)));
        assert_eq!(line.foes.iter().map(|foe| foe.joins).collect::<Vec<_>>(), [false, false, false, false]);
    }

    #[test]
    fn without_internal_lanes_the_line_is_at_the_lanes_end() {
        let (map, lines) = lines("tests/data/networks/random-8.net.xml", &["-54", "-3"]);
        // The link from -54_0 to -3_0 yields. -54_0 has 126.07 m and ends in (366.88, 174.74), 32.8 m from (334.86, 167.53), where -3_0
        // begins.
        assert_eq!(lines.len(), 1);
        let line = &lines[0];
        assert!((line.s_m - 126.07).abs() < 1e-9 && (32.8..33.5).contains(&line.inside_m), "{line:?}");
        assert!(map.route.point_at(line.s_m).distance(glam::dvec2(366.88, 174.74)) < 0.01);
        assert!(line.foes.iter().all(|foe| foe.length_m > 5.0), "their ways are as long as they are drawn: {line:?}");
    }

    #[test]
    fn an_all_way_stop_is_read_from_the_file() {
        let (_, lines) = lines("tests/data/networks/town.net.xml", &["cn", "nne", "ne"]);
        // Junction n: from cn to nne has the state w and request 2, whose response 100010 is links 1 and 5. From nne to ne has the state M.
        assert_eq!(lines.len(), 1);
        assert_eq!((links(&lines[0]), lines[0].stop), (vec![1, 5], StopRule::Allway));
    }
}
