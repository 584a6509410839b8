//! Lines across a road, and counts of vehicles that cross them. In: a place named by the user, or a road; the places of a
//! vehicle from row to row. Out: a [`CrossSection`], and counts. Metres, ticks.
//!
//! A vehicle has crossed a line on an edge if one row is before the line and the next is beyond it, on the edge or on the next
//! edge. For a line on one lane, the lane of the row nearer to the line counts. Between two rows a vehicle must not drive the
//! whole edge unseen: edges too short for that have no line.

use crate::analysis::{data::trips::seconds, error::AnalysisError};
use crate::{
    map::{
        RoadMap, RouteLane,
        network::{EdgeId, EdgeKind, LaneId, Network},
    },
    toml_text::did_you_mean,
};
use std::{path::Path, str::FromStr};

/// Minimum time on an edge with a line, at its speed limit, seconds: rows are up to a second apart, and some vehicles drive
/// faster than the limit.
const LEAST_PASSAGE_S: f64 = 1.5;
/// Largest distance between two rows: a multiple of speed times time, plus metres.
const REACH: [f64; 2] = [1.5, 5.0];

/// A line as the user names it: `LANE_OR_EDGE:METRES`.
#[derive(Clone, Debug, PartialEq)]
pub struct LinePlace {
    /// SUMO's id of a lane or an edge.
    pub name: String,
    /// Distance from the start of the lane or edge, metres.
    pub at_m: f64,
}

impl FromStr for LinePlace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = "allowed: LANE_OR_EDGE:METRES, such as B0B1:50 or B0B1_0:12.5";
        let (name, metres) = text.rsplit_once(':').ok_or_else(|| format!("the metres are missing; {wanted}"))?;
        let at_m = metres.trim().parse().ok().filter(|at_m: &f64| at_m.is_finite() && *at_m >= 0.0);
        let at_m = at_m.ok_or_else(|| format!("\"{metres}\" is not a distance in metres; {wanted}"))?;
        if name.trim().is_empty() {
            return Err(format!("the lane or edge is missing; {wanted}"));
        }
        Ok(Self { name: name.trim().into(), at_m })
    }
}

impl LinePlace {
    /// Finds the line in a network; `recording` is named in messages.
    ///
    /// # Errors
    /// There is no such edge or lane, it ends before the line, or it is so short that vehicles may pass it unseen.
    pub fn resolve(&self, network: &Network, recording: &Path) -> Result<CrossSection, AnalysisError> {
        let Self { name, at_m } = self;
        let fault = |why: String, remedy: &str| {
            AnalysisError::Input(format!("--line {name}:{at_m}: {}: {why}\n  remedy: {remedy}", recording.display()))
        };
        let lane = network.lane_named(name).filter(|_| network.edge_named(name).is_none());
        let edge = lane.map(|lane| network.lane(lane).edge).or_else(|| network.edge_named(name));
        let Some(edge) = edge else {
            let streets = network.edges().iter().filter(|edge| edge.kind.is_street()).map(|edge| edge.id.as_str());
            let names: Vec<&str> = streets.chain(network.lanes().iter().map(|lane| lane.id.as_str())).collect();
            let near = did_you_mean(name, &names);
            return Err(fault(
                format!("the network has no edge or lane of this name{near}"),
                "name a lane of the table cars.parquet (column lane); leave out the index for all lanes of the edge",
            ));
        };
        let line = CrossSection { name: format!("{name}:{at_m}"), is_default: false, edge, lane, at_m: *at_m };
        let length_m = line.lanes(network).map(|lane| network.lane(lane).length_m).fold(f64::INFINITY, f64::min);
        if *at_m > length_m {
            let why = format!("the lane is {length_m:.1} m long");
            return Err(fault(why, "name a distance from the start of the lane, at most its length"));
        }
        if passage_s(network, edge) < LEAST_PASSAGE_S {
            let why = format!(
                "the lane is {length_m:.1} m long: too short, because vehicles far from the ego are recorded only once \
                 a second"
            );
            return Err(fault(why, "name the edge before or after this one"));
        }
        Ok(line)
    }
}

/// Returns the shortest time over the lanes of an edge at their speed limits, seconds.
fn passage_s(network: &Network, edge: EdgeId) -> f64 {
    let lanes = network.edge(edge).lanes().map(|lane| network.lane(lane));
    lanes.map(|lane| lane.length_m / lane.speed_limit_mps.max(0.1)).fold(f64::INFINITY, f64::min)
}

/// A line across an edge, or across one of its lanes.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossSection {
    /// Name in the form `LANE_OR_EDGE:METRES`.
    pub name: String,
    /// True for the default line at the middle of the ego's path, false for a line that was asked for.
    pub is_default: bool,
    edge: EdgeId,
    lane: Option<LaneId>,
    at_m: f64,
}

impl CrossSection {
    /// Returns the line across all lanes of the street that is nearest to the middle of the ego's path and long enough; `None`
    /// if there is none.
    pub fn middle_of_path(map: &RoadMap) -> Option<Self> {
        let (net, middle_m) = (&map.network, map.route.length_m() / 2.0);
        let is_street = |lane: &&RouteLane| {
            let edge = lane.lane.map(|lane| net.lane(lane).edge);
            edge.is_some_and(|edge| net.edge(edge).kind == EdgeKind::Normal && passage_s(net, edge) >= LEAST_PASSAGE_S)
        };
        let nearest_m = |lane: &RouteLane| middle_m.clamp(lane.start_s_m, lane.start_s_m + lane.length_m);
        let away_m = |lane: &RouteLane| (nearest_m(lane) - middle_m).abs();
        let streets = map.route.lanes().iter().filter(is_street);
        let street = streets.min_by(|a, b| away_m(a).total_cmp(&away_m(b)))?;
        let at_m = (nearest_m(street) - street.start_s_m).round().min(street.length_m);
        let name = format!("{}:{at_m}", street.edge_id(net));
        Some(Self { name, is_default: true, edge: net.lane(street.lane?).edge, lane: None, at_m })
    }

    /// Iterates over the lanes that the line crosses.
    fn lanes<'a>(&'a self, network: &'a Network) -> impl Iterator<Item = LaneId> + 'a {
        network.edge(self.edge).lanes().filter(|lane| self.lane.is_none_or(|own| own == *lane))
    }
}

/// Place of a vehicle in a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowPlace {
    pub tick: u64,
    pub lane: LaneId,
    /// Position of the front bumper along the lane, metres.
    pub s_m: f64,
    pub speed_mps: f64,
}

/// Number of vehicles that crossed a line.
#[derive(Clone, Debug, PartialEq)]
pub struct LineCount {
    pub line: CrossSection,
    /// Vehicles that crossed, the ego included.
    pub vehicles: u64,
    /// Longest time between the two rows of a crossing, seconds: the precision of its moment.
    pub resolution_s: f64,
}

impl LineCount {
    /// Starts a count of zero.
    pub fn new(line: CrossSection) -> Self {
        Self { line, vehicles: 0, resolution_s: 0.0 }
    }

    /// Counts a vehicle if it crosses the line from one row to its next.
    pub fn pass(&mut self, network: &Network, before: &RowPlace, now: &RowPlace) {
        if self.passes(network, before, now) {
            self.vehicles += 1;
            self.resolution_s = self.resolution_s.max(seconds(now.tick - before.tick));
        }
    }

    fn passes(&self, network: &Network, before: &RowPlace, now: &RowPlace) -> bool {
        let at_m = self.line.at_m;
        let is_on = |place: &RowPlace| network.lane(place.lane).edge == self.line.edge;
        let seconds = seconds(now.tick - before.tick);
        // A vehicle that enters or leaves the edge elsewhere than over its ends has not crossed the line.
        let reach_m = REACH[0] * before.speed_mps.max(now.speed_mps) * seconds + REACH[1];
        let lane = match (is_on(before), is_on(now)) {
            (true, true) if before.s_m < at_m && now.s_m >= at_m => {
                if at_m - before.s_m < now.s_m - at_m {
                    before.lane
                } else {
                    now.lane
                }
            }
            (true, false) if before.s_m < at_m && network.lane(before.lane).length_m - before.s_m <= reach_m => {
                before.lane
            }
            (false, true) if now.s_m >= at_m && now.s_m <= reach_m => now.lane,
            _ => return false,
        };
        self.line.lane.is_none_or(|own| own == lane)
    }
}

#[cfg(test)]
#[path = "cross_section_tests.rs"]
mod tests;
