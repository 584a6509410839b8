//! Search for the longest open path through a network. In: a [`Network`], and the successors of each lane. Out: the longest open chain of
//! street lanes found. It visits no junction twice, so it does not cross itself. The search is bounded in steps and deterministic: ties
//! go to the lane that comes first in the file. Metres.

use super::{
    MapError,
    limits::LONGEST_ROUTE_M,
    loop_search::drivable,
    network::{JunctionId, LaneId, Network},
};
use std::path::Path;

/// Largest number of lanes that the search visits in all; 2 million take about 0.1 s.
const SEARCH_STEPS: usize = 2_000_000;
/// Shortest path worth driving, metres: two cars of 5 m, the gap of a standstill between them, and room to drive off.
const SHORTEST_M: f64 = 20.0;

/// Returns the longest chain found of lanes that are `usable`; `next` holds the lanes that can be entered from each lane, by index.
/// `None` if every chain is shorter than [`SHORTEST_M`].
pub(super) fn longest(net: &Network, next: &[Vec<usize>], usable: impl Fn(usize) -> bool) -> Option<Vec<usize>> {
    let mut entered = vec![false; next.len()];
    next.iter().flatten().for_each(|&goal| entered[goal] = true);
    // Starts of roads first: the longest path along a road begins at its start.
    let (begins, within): (Vec<usize>, Vec<usize>) =
        (0..next.len()).filter(|&lane| drivable(net, lane) && usable(lane)).partition(|&lane| !entered[lane]);
    let n = begins.len() + within.len();
    let mut search = Search {
        net,
        next,
        share: (SEARCH_STEPS / n.max(1)).clamp(200, 200_000),
        visited: vec![false; net.junctions().len() + net.edges().len()],
        // Tolerance: a chain of exactly the shortest length is accepted.
        best_m: SHORTEST_M - 1e-5,
        best: None,
    };
    begins.into_iter().chain(within).for_each(|start| search.from(start));
    search.best
}

/// Builds the error for a network without a path long enough.
pub(super) fn none(file: &Path, net: &Network) -> MapError {
    let streets = || net.lane_ids().filter(|lane| net.edge_of(*lane).kind.is_street());
    let for_cars = || streets().map(|lane| net.lane(lane)).filter(|lane| lane.admits_cars());
    let longest_m = for_cars().map(|lane| lane.length_m).fold(0.0, f64::max);
    let detail = match (streets().count(), for_cars().count()) {
        (0, _) => "the network has no street".to_owned(),
        (n, 0) => format!("none of the {n} lanes of its streets is open to passenger cars"),
        (_, n) => format!(
            "{n} lanes are open to passenger cars, the longest has {longest_m:.1} m, and no chain of them has {} m",
            SHORTEST_M
        ),
    };
    MapError::NoPath { file: file.into(), detail }
}

struct Search<'a> {
    net: &'a Network,
    next: &'a [Vec<usize>],
    /// Steps for each start.
    share: usize,
    /// Marks for junctions at the ends of the chain's lanes, and for edges that end in no junction.
    visited: Vec<bool>,
    best_m: f64,
    best: Option<Vec<usize>>,
}

impl Search<'_> {
    fn end_of(&self, lane: usize) -> usize {
        let edge = self.net.lane(LaneId::from_index(lane)).edge;
        // An edge that ends in no junction has a mark of its own.
        let alone = || self.net.junctions().len() + edge.index();
        self.net.edge(edge).to.map_or_else(alone, JunctionId::index)
    }

    fn length_m(&self, lane: usize) -> f64 {
        self.net.lane(LaneId::from_index(lane)).length_m
    }

    /// Searches depth-first from a lane, within its share of the steps.
    fn from(&mut self, start: usize) {
        let begins_at = self.net.edge_of(LaneId::from_index(start)).from.map(JunctionId::index);
        // A chain may end where it begins, but passes no junction twice.
        let first = begins_at.filter(|&junction| junction != self.end_of(start));
        for junction in first.into_iter().chain([self.end_of(start)]) {
            self.visited[junction] = true;
        }
        let mut path = vec![(start, 0)];
        let mut length_m = self.length_m(start);
        let mut steps = 0;
        self.keep(&path, length_m);
        while let Some((lane, tried)) = path.last_mut() {
            let lane = *lane;
            let goal = self.next[lane].get(*tried).copied().filter(|_| steps < self.share);
            *tried += 1;
            steps += 1;
            match goal {
                Some(goal) if length_m + self.length_m(goal) > LONGEST_ROUTE_M => {}
                Some(goal) if Some(self.end_of(goal)) == first => {
                    path.push((goal, 0));
                    self.keep(&path, length_m + self.length_m(goal));
                    path.pop();
                }
                Some(goal) if !self.visited[self.end_of(goal)] => {
                    let end = self.end_of(goal);
                    self.visited[end] = true;
                    length_m += self.length_m(goal);
                    path.push((goal, 0));
                    self.keep(&path, length_m);
                }
                Some(_) => {}
                None => {
                    let end = self.end_of(lane);
                    self.visited[end] = false;
                    length_m -= self.length_m(lane);
                    path.pop();
                }
            }
        }
        first.into_iter().for_each(|junction| self.visited[junction] = false);
    }

    fn keep(&mut self, path: &[(usize, usize)], length_m: f64) {
        // Tolerance for rounding: other chains add the lengths in another order.
        if length_m > self.best_m + 1e-6 {
            self.best_m = length_m;
            self.best = Some(path.iter().map(|(lane, _)| *lane).collect());
        }
    }
}
