//! Search for the route of a network. In: a [`Network`] and, if the user chose, its edges in order. Out: the lanes to drive, internal
//! lanes included, as a [`Route`], closed if there is a loop. Deterministic: ties go to the lane that comes first in the file. The
//! default path of a network ([`default_path`]) never changes lanes, so that vehicles that keep their lane stay on it; `longest_open_path` finds
//! it where there is no loop.

use super::{
    MapError, Route, RouteLane,
    edge_path::along_edges,
    joined_shapes::{bridge_gaps, change_lanes, shape_length_m},
    limits::{LONGEST_ROUTE_M, WIDEST_GAP_M},
    longest_open_path,
    network::{Edge, JunctionId, Lane, LaneId, Network},
    tight_turns::{has_kink, is_street_corner, is_too_tight},
};
use crate::toml_text::did_you_mean;
use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

/// Largest number of lanes that the search for the longest loop visits in all; 2 million take about 0.1 s.
const SEARCH_STEPS: usize = 2_000_000;

/// Length below which a loop counts as driving round on the spot, metres: a lap takes 12 s at the 8 m/s of such bends.
const ON_THE_SPOT_M: f64 = 100.0;

/// Edges that the user, or an import, chose for a map.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChosenEdges<'a> {
    /// Ids of the edges in driving order.
    pub edges: &'a [String],
    /// True if the last edge leads to the first.
    pub closed: bool,
}

/// Returns the route of `net`: along the chosen edges if there are any, else its default path, which may be open.
pub(super) fn route_of(file: &Path, net: &Network, chosen: Option<ChosenEdges>) -> Result<Route, MapError> {
    let chain = match chosen {
        Some(ChosenEdges { edges, closed: false }) => {
            let edges: Vec<&str> = edges.iter().map(String::as_str).collect();
            return along_edges(file, net, &edges, None);
        }
        Some(ChosenEdges { edges, closed: true }) => along(file, net, edges)?,
        None => match default_path(file, net)? {
            path if path.is_closed => path.streets,
            path => {
                let edges: Vec<&str> = path.streets.iter().map(|lane| net.edge_of(*lane).id.as_str()).collect();
                return along_edges(file, net, &edges, None);
            }
        },
    };
    let mut lanes = Vec::new();
    let mut declared_m = 0.0;
    for (k, &entered) in chain.iter().enumerate() {
        let next = chain[(k + 1) % chain.len()];
        let left = lane_towards(net, entered, next);
        for lane in [entered, left] {
            check_stretch(file, net, &RouteLane::of(net, lane))?;
        }
        // A lane change has a point every 2 m.
        declared_m += net.lane(entered).length_m.max(net.lane(left).length_m);
        check_length(file, declared_m)?;
        lanes.push(change_lanes(&RouteLane::of(net, entered), &RouteLane::of(net, left)));
        lanes.extend(net.lanes_between(left, next).map(|lane| RouteLane::of(net, lane)));
    }
    check_gaps(file, net, &lanes)?;
    bridge_gaps(&mut lanes);
    Ok(Route::new(lanes).with_heights(net))
}

fn lane_at(net: &Network, lane: usize) -> &Lane {
    net.lane(LaneId::from_index(lane))
}

fn edge_at(net: &Network, lane: usize) -> &Edge {
    net.edge_of(LaneId::from_index(lane))
}

/// Returns true for a lane of a street that is open to passenger cars.
pub(super) fn drivable(net: &Network, lane: usize) -> bool {
    lane_at(net, lane).admits_cars() && edge_at(net, lane).kind.is_street()
}

fn check_length(file: &Path, length_m: f64) -> Result<(), MapError> {
    if length_m <= LONGEST_ROUTE_M {
        return Ok(());
    }
    let (what, value) = ("the length of the closed route".into(), format!("over {length_m:.0} m"));
    Err(MapError::Limit { file: file.into(), what, value, allowed: format!("at most {LONGEST_ROUTE_M} m") })
}

/// Checks the ratio of declared to drawn length, 0.01 to 100: positions count in declared metres, and vehicles drive drawn ones. Lanes of
/// less than a metre, as inside junctions, are exempt.
fn check_stretch(file: &Path, net: &Network, lane: &RouteLane) -> Result<(), MapError> {
    let drawn_m = shape_length_m(&lane.shape);
    if drawn_m.max(lane.length_m) < 1.0 || (0.01..=100.0).contains(&(lane.length_m / drawn_m)) {
        return Ok(());
    }
    let what = format!("the declared length of lane \"{}\" on the route", lane.id(net));
    let (value, allowed) =
        (format!("{} m", lane.length_m), format!("0.01 to 100 times that of its shape, {drawn_m:.3} m"));
    Err(MapError::Limit { file: file.into(), what, value, allowed })
}

/// Checks that the route as drawn is not too long, and that no gap in it is too wide to be bridged.
fn check_gaps(file: &Path, net: &Network, lanes: &[RouteLane]) -> Result<(), MapError> {
    let mut drawn_m = 0.0;
    for (k, lane) in lanes.iter().enumerate() {
        let next = &lanes[(k + 1) % lanes.len()];
        let gap_m = lane.shape[lane.shape.len() - 1].distance(next.shape[0]);
        if gap_m > WIDEST_GAP_M {
            let what = format!("the gap in the route between lanes \"{}\" and \"{}\"", lane.id(net), next.id(net));
            let (value, allowed) = (format!("{gap_m:.1} m"), format!("at most {WIDEST_GAP_M} m"));
            return Err(MapError::Limit { file: file.into(), what, value, allowed });
        }
        drawn_m += shape_length_m(&lane.shape) + gap_m;
        check_length(file, drawn_m)?;
    }
    Ok(())
}

/// Links that a search may use.
#[derive(Clone, Copy)]
struct AllowedLinks {
    /// Lane changes within an edge.
    changes: bool,
    /// U-turns back to where the lane came from.
    turnarounds: bool,
    tight_turns: TightTurns,
}

/// Turns that a car cannot make within its lane and that a search may use.
#[derive(Clone, Copy, PartialEq, Eq)]
enum TightTurns {
    None,
    /// Only those at the corners of streets, of up to 110 degrees.
    Corners,
    All,
}

/// Returns the lanes of a lane's edge that are open to cars, the lane itself included.
fn beside(net: &Network, lane: usize) -> impl Iterator<Item = usize> {
    edge_at(net, lane).lanes().map(LaneId::index).filter(|&lane| lane_at(net, lane).admits_cars())
}

/// Returns the lanes that can be entered next from each lane; the right-most target first.
fn links_by_lane(net: &Network, allowed: AllowedLinks) -> Vec<Vec<usize>> {
    let mut next = vec![Vec::new(); net.lanes().len()];
    let kinked: Vec<bool> =
        net.lanes().iter().map(|lane| allowed.tight_turns != TightTurns::All && has_kink(lane)).collect();
    for link in net.connections() {
        let (from, to) = (link.from.index(), link.to.index());
        if drivable(net, from)
            && !kinked[from]
            && !kinked[to]
            && drivable(net, to)
            && (allowed.turnarounds || !link.is_turnaround())
            && (allowed.tight_turns == TightTurns::All
                || allowed.tight_turns == TightTurns::Corners && is_street_corner(net, link)
                || !is_too_tight(net, link))
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

/// Returns the lane on which an edge is left for `next`: the one entered if it leads there, else the right-most that does.
fn lane_towards(net: &Network, entered: LaneId, next: LaneId) -> LaneId {
    let leads = |lane: &LaneId| net.connections_from(*lane).iter().any(|connection| connection.to == next);
    let beside = beside(net, entered.index()).map(LaneId::from_index);
    std::iter::once(entered).chain(beside).find(leads).unwrap_or(entered)
}

fn lane_ids(lanes: Vec<usize>) -> Vec<LaneId> {
    lanes.into_iter().map(LaneId::from_index).collect()
}

/// Rotates a loop to begin with the lane that comes first in the file, so that a map's origin does not depend on the search.
fn from_first(mut found: Vec<usize>) -> Vec<usize> {
    let first = (0..found.len()).min_by_key(|&k| found[k]).unwrap_or(0);
    found.rotate_left(first);
    found
}

/// Returns the path that is driven unless the user chooses one: the longest loop that does not cross itself, else any loop, else one with
/// U-turns, else the longest open path; none of them changes lanes. Turns that a car cannot make are used only if nothing is found without
/// them; but a loop round corners of streets that are a little too tight comes before an open path. A loop shorter than 100 m gives way to
/// a longer open path.
///
/// # Errors
/// No chain of lanes open to cars is long enough to drive.
pub(super) fn default_path(file: &Path, net: &Network) -> Result<DefaultPath, MapError> {
    let search = |tight_turns| {
        let links = |turnarounds| links_by_lane(net, AllowedLinks { changes: false, turnarounds, tight_turns });
        let next = links(false);
        let with_turnarounds = || any_loop(&links(true)).filter(|_| tight_turns != TightTurns::Corners);
        let closed = longest_without_crossing(net, &next).or_else(|| any_loop(&next)).or_else(with_turnarounds);
        let closed = closed.map(|found| (from_first(found), true));
        let usable = |lane| tight_turns == TightTurns::All || !has_kink(lane_at(net, lane));
        let open = || longest_open_path::longest(net, &next, usable).map(|found| (found, false));
        match closed {
            Some((lanes, _)) if length_m(net, &lanes) < ON_THE_SPOT_M => {
                let longer = open().filter(|(way, _)| length_m(net, way) > length_m(net, &lanes));
                longer.or(Some((lanes, true)))
            }
            found => found.or_else(open),
        }
    };
    let is_loop = |found: &(Vec<usize>, bool)| found.1;
    let gentle = search(TightTurns::None);
    let round_corners = || search(TightTurns::Corners).filter(is_loop);
    let found = gentle.clone().filter(is_loop).or_else(round_corners).or(gentle);
    let found = found.or_else(|| search(TightTurns::All));
    let (lanes, is_closed) = found.ok_or_else(|| longest_open_path::none(file, net))?;
    Ok(DefaultPath { streets: lane_ids(lanes), is_closed })
}

/// Path that is driven unless the user chooses one.
pub(super) struct DefaultPath {
    /// Lanes of streets in driving order, each connected to the next; on a closed path the last to the first.
    pub streets: Vec<LaneId>,
    pub is_closed: bool,
}

impl DefaultPath {
    /// Returns all lanes in driving order, internal lanes included.
    pub fn lanes<'n>(&'n self, net: &'n Network) -> impl Iterator<Item = LaneId> + 'n {
        let next = move |k: usize| self.streets.get(k + 1).or_else(|| self.streets.first().filter(|_| self.is_closed));
        let inside = move |k: usize, lane| next(k).into_iter().flat_map(move |next| net.lanes_between(lane, *next));
        let streets = self.streets.iter().enumerate();
        streets.flat_map(move |(k, lane)| std::iter::once(*lane).chain(inside(k, *lane)))
    }

    /// Returns the sum of the declared lengths of all lanes, metres.
    pub fn length_m(&self, net: &Network) -> f64 {
        self.lanes(net).map(|lane| net.lane(lane).length_m).sum()
    }
}

/// Returns the total length of street lanes, metres.
fn length_m(net: &Network, lanes: &[usize]) -> f64 {
    lanes.iter().map(|&lane| lane_at(net, lane).length_m).sum()
}

/// Searches depth-first from every lane, each with an equal share of the steps, and returns the longest loop that visits no junction
/// twice.
fn longest_without_crossing(net: &Network, next: &[Vec<usize>]) -> Option<Vec<usize>> {
    let next = peel(next);
    let starts: Vec<usize> = (0..next.len()).filter(|&lane| !next[lane].is_empty()).collect();
    let share = (SEARCH_STEPS / starts.len().max(1)).clamp(1_000, 200_000);
    // An edge that ends in no junction has a mark of its own.
    let alone = |lane: usize| net.junctions().len() + lane_at(net, lane).edge.index();
    let junction = |lane: usize| edge_at(net, lane).to.map_or_else(|| alone(lane), JunctionId::index);
    // An edge counts with the length of its right-most lane, so that an outer lane does not win over it.
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

/// Removes, repeatedly, lanes that lead nowhere or that no lane leads to.
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

/// Returns the shortest loop, in number of lanes, through the first lane that has one.
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

/// Returns a lane on a loop that can be reached from `lane` in a peeled network: the first lane visited twice.
fn on_a_loop(next: &[Vec<usize>], mut lane: usize) -> usize {
    let mut seen = vec![false; next.len()];
    while !std::mem::replace(&mut seen[lane], true) {
        lane = next[lane][0];
    }
    lane
}

/// Returns the edges with these ids; each id may occur once.
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

/// Returns the lanes along the edges that the user named: the right-most ones that lead all the way round.
fn along(file: &Path, net: &Network, edges: &[String]) -> Result<Vec<LaneId>, MapError> {
    let chosen = chosen_edges(file, net, edges)?;
    let mut furthest = 0;
    for changes in [false, true] {
        let next = links_by_lane(net, AllowedLinks { changes, turnarounds: true, tight_turns: TightTurns::All });
        let lanes_of = |k: usize| {
            let lanes = chosen[k % chosen.len()].lanes().map(LaneId::index);
            lanes.filter(|&lane| lane_at(net, lane).admits_cars())
        };
        for start in (0..edges.len().min(1)).flat_map(lanes_of) {
            // All chains at once: the lanes of edge k that can be reached, and from where.
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
                return Ok(lane_ids(chain));
            }
        }
    }
    Err(broken(file, edges, furthest))
}

/// Builds the error for a route that ends after edge `furthest`, counted from 0.
fn broken(file: &Path, edges: &[String], furthest: usize) -> MapError {
    let n = edges.len().max(1);
    let detail = match (edges.get(furthest % n), edges.get((furthest + 1) % n)) {
        (Some(from), Some(to)) => format!("the route of map.toml cannot go on from edge \"{from}\" to \"{to}\""),
        _ => "the route of map.toml names no edge".to_owned(),
    };
    MapError::NoRoute { file: file.into(), detail }
}
