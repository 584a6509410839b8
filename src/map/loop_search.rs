//! Finding the route of a network. In: a [`Network`] and, if a person chose, its edges in order. Out: the lanes to drive, insides of
//! junctions included, as a [`Route`], closed if there is a loop. Deterministic: ties go to what the file names first. The default path of
//! a network ([`default_path`]) never changes lanes, so that cars which keep their lane stay on it; `open_path` finds it where
//! there is no loop.

use super::{
    MapError, Route, RouteLane,
    edge_path::along_edges,
    joined_shapes::{bridge_gaps, change_lanes, extend_points, shape_length_m},
    limits::{LONGEST_ROUTE_M, WIDEST_GAP_M},
    network::{self, Connection, Edge, JunctionId, Lane, LaneId, Network},
    open_path,
    tight_turns::{has_kink, is_too_tight},
};
use crate::toml_text::did_you_mean;
use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

/// How many lanes the search for the longest loop may visit in all; 2 million take about 0.1 s.
const SEARCH_STEPS: usize = 2_000_000;

/// A shorter loop is a circle on the spot, metres: at the 8 m/s of such bends once round takes 12 s.
const ON_THE_SPOT_M: f64 = 100.0;

/// The edges that a person, or an import, chose for a map.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChosenEdges<'a> {
    /// In driving order.
    pub edges: &'a [String],
    /// True if the last leads to the first.
    pub closed: bool,
}

/// The route of `net`: along the chosen edges if there are any, else its default path; open where that is.
pub(super) fn route_of(file: &Path, net: &Network, chosen: Option<ChosenEdges>) -> Result<Route, MapError> {
    let chain = match chosen {
        Some(ChosenEdges { edges, closed: false }) => {
            let edges: Vec<&str> = edges.iter().map(String::as_str).collect();
            return along_edges(file, net, &edges, None);
        }
        Some(ChosenEdges { edges, closed: true }) => along(file, net, edges)?,
        None => match default_path(file, net) {
            Ok(path) if path.is_closed() => streets_of(net, &path),
            // A loop that changes lanes goes before an open path, as before there were open ones.
            found => match (longest_loop(file, net), found) {
                (Err(_), Ok(path)) => {
                    let edges: Vec<&str> =
                        streets_of(net, &path).into_iter().map(|lane| edge_at(net, lane).id.as_str()).collect();
                    return along_edges(file, net, &edges, None);
                }
                (looped, _) => looped?,
            },
        },
    };
    let mut lanes = Vec::new();
    let mut declared_m = 0.0;
    for (k, &entered) in chain.iter().enumerate() {
        let next = chain[(k + 1) % chain.len()];
        let left = lane_towards(net, entered, next);
        for lane in [entered, left] {
            check_stretch(file, &route_lane(net, lane))?;
        }
        // A change of lanes makes a point each 2 m.
        declared_m += lane_at(net, entered).length_m.max(lane_at(net, left).length_m);
        check_length(file, declared_m)?;
        lanes.push(change_lanes(&route_lane(net, entered), &route_lane(net, left)));
        lanes.extend(inside(net, left, next).into_iter().map(|lane| route_lane(net, lane)));
    }
    extend_points(&mut lanes);
    check_gaps(file, &lanes)?;
    bridge_gaps(&mut lanes);
    Ok(Route::new(lanes))
}

fn lane_at(net: &Network, lane: usize) -> &Lane {
    net.lane(LaneId::from_index(lane))
}

fn edge_at(net: &Network, lane: usize) -> &Edge {
    net.edge_of(LaneId::from_index(lane))
}

/// True of a lane of a street that is open to passenger cars.
pub(super) fn drivable(net: &Network, lane: usize) -> bool {
    lane_at(net, lane).admits_cars() && edge_at(net, lane).kind.is_street()
}

/// A lane on the ground plane: routes are flat.
fn route_lane(net: &Network, lane: usize) -> RouteLane {
    let (lane, edge) = (lane_at(net, lane), edge_at(net, lane));
    RouteLane {
        id: lane.id.clone(),
        edge: edge.id.clone(),
        start_s_m: 0.0,
        length_m: lane.length_m,
        speed_limit_mps: lane.speed_limit_mps,
        width_m: lane.width_m,
        shape: lane.shape().iter().map(|point| point.truncate()).collect(),
    }
}

/// The first connection between two lanes.
fn connection(net: &Network, from: usize, to: usize) -> Option<&Connection> {
    net.connections_from(LaneId::from_index(from)).iter().find(|connection| connection.to.index() == to)
}

fn check_length(file: &Path, length_m: f64) -> Result<(), MapError> {
    if length_m <= LONGEST_ROUTE_M {
        return Ok(());
    }
    let (what, value) = ("the length of the closed route".into(), format!("over {length_m:.0} m"));
    Err(MapError::Limit { file: file.into(), what, value, allowed: format!("at most {LONGEST_ROUTE_M} m") })
}

/// Positions are declared metres and cars drive drawn ones: one may be longer than the other, but not by a hundred times.
/// Lanes of less than a metre, as there are inside junctions, are let be.
fn check_stretch(file: &Path, lane: &RouteLane) -> Result<(), MapError> {
    let drawn_m = shape_length_m(&lane.shape);
    if drawn_m.max(lane.length_m) < 1.0 || (0.01..=100.0).contains(&(lane.length_m / drawn_m)) {
        return Ok(());
    }
    let what = format!("the declared length of lane \"{}\" on the route", lane.id);
    let (value, allowed) =
        (format!("{} m", lane.length_m), format!("0.01 to 100 times that of its shape, {drawn_m:.3} m"));
    Err(MapError::Limit { file: file.into(), what, value, allowed })
}

/// The route as it will be drawn is not too long, and no hole in it too wide to be bridged.
fn check_gaps(file: &Path, lanes: &[RouteLane]) -> Result<(), MapError> {
    let mut drawn_m = 0.0;
    for (k, lane) in lanes.iter().enumerate() {
        let next = &lanes[(k + 1) % lanes.len()];
        let gap_m = lane.shape[lane.shape.len() - 1].distance(next.shape[0]);
        if gap_m > WIDEST_GAP_M {
            let what = format!("the hole in the route between lanes \"{}\" and \"{}\"", lane.id, next.id);
            let (value, allowed) = (format!("{gap_m:.1} m"), format!("at most {WIDEST_GAP_M} m"));
            return Err(MapError::Limit { file: file.into(), what, value, allowed });
        }
        drawn_m += shape_length_m(&lane.shape) + gap_m;
        check_length(file, drawn_m)?;
    }
    Ok(())
}

/// Which links a search may use.
#[derive(Clone, Copy)]
struct AllowedLinks {
    /// Changing lanes within an edge.
    changes: bool,
    /// Turning on the spot.
    turnarounds: bool,
    /// Turns that a car cannot make within its lane.
    tight_turns: bool,
}

/// All lanes of the edge that `lane` belongs to, for cars.
fn beside(net: &Network, lane: usize) -> impl Iterator<Item = usize> {
    edge_at(net, lane).lanes().map(LaneId::index).filter(|&lane| lane_at(net, lane).admits_cars())
}

/// Lanes that can be entered next, by the lane that was entered; the right-most goal first.
fn links_by_lane(net: &Network, allowed: AllowedLinks) -> Vec<Vec<usize>> {
    let mut next = vec![Vec::new(); net.lanes().len()];
    let kinked: Vec<bool> = net.lanes().iter().map(|lane| !allowed.tight_turns && has_kink(lane)).collect();
    for link in net.connections() {
        let (from, to) = (link.from.index(), link.to.index());
        if drivable(net, from)
            && !kinked[from]
            && !kinked[to]
            && drivable(net, to)
            && (allowed.turnarounds || !link.is_turnaround())
            && (allowed.tight_turns || !is_too_tight(net, link))
        {
            let entered = beside(net, from).filter(|&lane| allowed.changes || lane == from);
            entered.for_each(|lane| next[lane].push(to));
        }
    }
    for goals in &mut next {
        goals.sort_by_key(|&lane| (net.index_in_edge(LaneId::from_index(lane)), lane));
        goals.dedup();
    }
    next
}

/// The lane by which an edge is left for `next`: the one that was entered if it leads there, else the right-most that does.
fn lane_towards(net: &Network, entered: usize, next: usize) -> usize {
    let leads = |lane: &usize| connection(net, *lane, next).is_some();
    std::iter::once(entered).chain(beside(net, entered)).find(leads).unwrap_or(entered)
}

fn longest_loop(file: &Path, net: &Network) -> Result<Vec<usize>, MapError> {
    // Best first: keeping the lane, then changing lanes; crossing oneself and turning on the spot only where it must be.
    let links = |changes, turnarounds| links_by_lane(net, AllowedLinks { changes, turnarounds, tight_turns: true });
    let found = longest_without_crossing(net, &links(false, false))
        .or_else(|| longest_without_crossing(net, &links(true, false)))
        .or_else(|| any_loop(&links(true, false)))
        .or_else(|| any_loop(&links(true, true)));
    let found = found.ok_or_else(|| {
        let lanes = (0..net.lanes().len()).filter(|&lane| drivable(net, lane)).count();
        let detail = format!("{lanes} lanes are open to passenger cars, and no chain of them returns to its start");
        MapError::NoRoute { file: file.into(), detail }
    })?;
    Ok(from_first(found))
}

/// A loop that begins with what the file names first, so that a map's origin does not depend on the search.
fn from_first(mut found: Vec<usize>) -> Vec<usize> {
    let first = (0..found.len()).min_by_key(|&k| found[k]).unwrap_or(0);
    found.rotate_left(first);
    found
}

/// The path that is driven where a person chose none: the longest loop that keeps its lanes and crosses itself nowhere, else a loop
/// that keeps its lanes, else the longest open path that does; with turns that a car can make, if there is one. A loop on which a
/// participant would go round and round on the spot gives way to an open path that is longer.
///
/// # Errors
/// If no chain of lanes open to cars is long enough to drive on.
pub(super) fn default_path(file: &Path, net: &Network) -> Result<network::Path, MapError> {
    let search = |tight_turns| {
        let next = links_by_lane(net, AllowedLinks { changes: false, turnarounds: false, tight_turns });
        let closed =
            longest_without_crossing(net, &next).or_else(|| any_loop(&next)).map(|found| (from_first(found), true));
        let usable = |lane| tight_turns || !has_kink(lane_at(net, lane));
        let open = || open_path::longest(net, &next, usable).map(|found| (found, false));
        match closed {
            Some((lanes, _)) if length_m(net, &lanes) < ON_THE_SPOT_M => {
                let longer = open().filter(|(way, _)| length_m(net, way) > length_m(net, &lanes));
                longer.or(Some((lanes, true)))
            }
            found => found.or_else(open),
        }
    };
    let (lanes, is_closed) = search(false).or_else(|| search(true)).ok_or_else(|| open_path::none(file, net))?;
    let lanes: Vec<LaneId> = lanes.into_iter().map(LaneId::from_index).collect();
    network::Path::through(net, &lanes, is_closed)
        .map_err(|error| MapError::NoPath { file: file.into(), detail: error.to_string() })
}

/// Length of lanes of streets, metres.
fn length_m(net: &Network, lanes: &[usize]) -> f64 {
    lanes.iter().map(|&lane| lane_at(net, lane).length_m).sum()
}

/// The lanes of a path between junctions.
fn streets_of(net: &Network, path: &network::Path) -> Vec<usize> {
    path.lanes().iter().map(|lane| lane.index()).filter(|lane| edge_at(net, *lane).kind.is_street()).collect()
}

/// Depth first from every lane, each with an equal share of the steps; the longest loop that visits no junction twice.
fn longest_without_crossing(net: &Network, next: &[Vec<usize>]) -> Option<Vec<usize>> {
    let next = peel(next);
    let starts: Vec<usize> = (0..next.len()).filter(|&lane| !next[lane].is_empty()).collect();
    let share = (SEARCH_STEPS / starts.len().max(1)).clamp(1_000, 200_000);
    // An edge that ends in no junction ends alone.
    let alone = |lane: usize| net.junctions().len() + lane_at(net, lane).edge.index();
    let junction = |lane: usize| edge_at(net, lane).to.map_or_else(|| alone(lane), JunctionId::index);
    // An edge counts as long as its right-most lane, so that an outer lane does not win over the right-most.
    let weight_m = |lane: usize| edge_at(net, lane).lanes().next().map_or(0.0, |first| net.lane(first).length_m);
    let mut best: (f64, Option<Vec<usize>>) = (0.0, None);
    let mut visited = vec![false; net.junctions().len() + net.edges().len()];
    for start in starts {
        let mut path = vec![(start, 0)];
        let mut length_m = weight_m(start);
        visited[junction(start)] = true;
        let mut steps = 0;
        while let Some((lane, tried)) = path.last_mut() {
            let goal = next[*lane].get(*tried).copied().filter(|_| steps < share);
            *tried += 1;
            steps += 1;
            match goal {
                Some(goal) if goal == start => {
                    if length_m > best.0 + 1e-6 {
                        best = (length_m, Some(path.iter().map(|(lane, _)| *lane).collect()));
                    }
                }
                Some(goal) if !visited[junction(goal)] => {
                    visited[junction(goal)] = true;
                    length_m += weight_m(goal);
                    path.push((goal, 0));
                }
                Some(_) => {}
                None => {
                    visited[junction(*lane)] = false;
                    length_m -= weight_m(*lane);
                    path.pop();
                }
            }
        }
    }
    best.1
}

/// Takes away, again and again, lanes that lead nowhere or that nothing leads to.
fn peel(next: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let mut before = vec![Vec::new(); next.len()];
    for (lane, goals) in next.iter().enumerate() {
        goals.iter().for_each(|&goal| before[goal].push(lane));
    }
    let mut ways_in: Vec<usize> = before.iter().map(Vec::len).collect();
    let mut ways_out: Vec<usize> = next.iter().map(Vec::len).collect();
    let mut gone: Vec<bool> = (0..next.len()).map(|lane| ways_in[lane] == 0 || ways_out[lane] == 0).collect();
    let mut left: Vec<usize> = (0..next.len()).filter(|&lane| gone[lane]).collect();
    while let Some(lane) = left.pop() {
        for (others, ways) in [(&next[lane], &mut ways_in), (&before[lane], &mut ways_out)] {
            for &other in others {
                ways[other] -= 1;
                if ways[other] == 0 && !gone[other] {
                    gone[other] = true;
                    left.push(other);
                }
            }
        }
    }
    let kept = |lane: usize| next[lane].iter().copied().filter(|&goal| !gone[lane] && !gone[goal]).collect();
    (0..next.len()).map(kept).collect()
}

/// The shortest loop through the first lane that has one, counted in lanes.
fn any_loop(next: &[Vec<usize>]) -> Option<Vec<usize>> {
    let next = peel(next);
    let mut steps = 0;
    (0..next.len()).filter(|&lane| !next[lane].is_empty()).find_map(|start| {
        let start = if steps < SEARCH_STEPS { start } else { on_a_loop(&next, start) };
        let mut came_from = BTreeMap::new();
        let mut queue = std::collections::VecDeque::from([start]);
        while let Some(lane) = queue.pop_front() {
            if next[lane].contains(&start) {
                let mut chain: Vec<usize> =
                    std::iter::successors(Some(lane), |lane| came_from.get(lane).copied()).collect();
                chain.reverse();
                return Some(chain);
            }
            for &goal in &next[lane] {
                steps += 1;
                if goal != start && !came_from.contains_key(&goal) {
                    came_from.insert(goal, lane);
                    queue.push_back(goal);
                }
            }
        }
        None
    })
}

/// A lane on a loop that can be reached from `lane`, in a network that has been peeled: the first that comes twice.
fn on_a_loop(next: &[Vec<usize>], mut lane: usize) -> usize {
    let mut seen = vec![false; next.len()];
    while !std::mem::replace(&mut seen[lane], true) {
        lane = next[lane][0];
    }
    lane
}

/// The edges of these names, each once.
fn chosen_edges<'a>(file: &Path, net: &'a Network, edges: &[String]) -> Result<Vec<&'a Edge>, MapError> {
    let streets = || net.edges().iter().filter(|edge| edge.kind.is_street());
    let edge_of_id: BTreeMap<&str, &Edge> = streets().map(|edge| (edge.id.as_str(), edge)).collect();
    let mut named = BTreeSet::new();
    let mut chosen = Vec::new();
    for id in edges {
        let bad = |problem| {
            let known: Vec<&str> = streets().map(|edge| edge.id.as_str()).collect();
            let is_there = known.contains(&id.as_str());
            let near = if is_there { String::new() } else { did_you_mean(id, &known) };
            MapError::RouteEdge { file: file.into(), edge: id.clone(), problem, near, known: super::listed(&known) }
        };
        if !named.insert(id) {
            return Err(bad("is named twice"));
        }
        chosen.push(*edge_of_id.get(id.as_str()).ok_or_else(|| bad("does not exist"))?);
    }
    Ok(chosen)
}

/// The lanes along the edges that a person named, the right-most that lead all the way round.
fn along(file: &Path, net: &Network, edges: &[String]) -> Result<Vec<usize>, MapError> {
    let chosen = chosen_edges(file, net, edges)?;
    let mut furthest = 0;
    for changes in [false, true] {
        let next = links_by_lane(net, AllowedLinks { changes, turnarounds: true, tight_turns: true });
        let lanes_of = |k: usize| {
            let lanes = chosen[k % chosen.len()].lanes().map(LaneId::index);
            lanes.filter(|&lane| lane_at(net, lane).admits_cars())
        };
        for start in (0..edges.len().min(1)).flat_map(lanes_of) {
            // All chains at once: which lanes of edge k can be reached, and from where.
            let mut reached: Vec<BTreeMap<usize, usize>> = vec![BTreeMap::from([(start, start)])];
            for k in 1..=edges.len() {
                let mut here = BTreeMap::new();
                for &from in reached[k - 1].keys() {
                    for goal in lanes_of(k).filter(|goal| next[from].contains(goal)) {
                        here.entry(goal).or_insert(from);
                    }
                }
                if here.is_empty() {
                    break;
                }
                furthest = furthest.max(k);
                reached.push(here);
            }
            if reached.len() > edges.len() && reached[edges.len()].contains_key(&start) {
                let mut chain = vec![start];
                for k in (1..=edges.len()).rev() {
                    chain.insert(0, reached[k][&chain[0]]);
                }
                chain.pop();
                return Ok(chain);
            }
        }
    }
    Err(broken(file, edges, furthest))
}

/// Why a route of these edges ends after edge `furthest`, counted round from 0.
fn broken(file: &Path, edges: &[String], furthest: usize) -> MapError {
    let n = edges.len().max(1);
    let detail = match (edges.get(furthest % n), edges.get((furthest + 1) % n)) {
        (Some(from), Some(to)) => format!("the route of map.toml cannot go on from edge \"{from}\" to \"{to}\""),
        _ => "the route of map.toml names no edge".to_owned(),
    };
    MapError::NoRoute { file: file.into(), detail }
}

/// The lanes inside the junction between two lanes that are linked, in driving order.
fn inside(net: &Network, from: usize, to: usize) -> Vec<usize> {
    let mut lanes = Vec::new();
    let via_of = |lane: usize| connection(net, lane, to).and_then(|link| link.via).map(LaneId::index);
    let mut via = via_of(from);
    // netconvert makes two or three of them; a network that leads in circles inside a junction is not followed.
    while let Some(lane) = via.filter(|lane| lanes.len() < 16 && !lanes.contains(lane)) {
        lanes.push(lane);
        via = via_of(lane);
    }
    lanes
}
