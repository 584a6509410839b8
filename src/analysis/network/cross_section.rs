//! Lines across a road, and who passes them. In: a place that a person names, or a road; where a vehicle was from row to row. Out: a
//! [`CrossSection`], and counts. Metres, ticks.
//!
//! A vehicle has passed a line on an edge if it was before it and is beyond it: on the edge, or on the next. Of a lane alone it is the lane of
//! the row that is nearer to the line. Between two rows a vehicle must not pass the whole edge unseen: edges too short for that have no line.

use super::trips::seconds;
use crate::{
    analysis::AnalysisError,
    map::{
        RoadMap, RouteLane,
        network::{EdgeId, EdgeKind, LaneId, Network},
    },
    toml_text::did_you_mean,
};
use std::{path::Path, str::FromStr};

/// An edge with a line takes so long at its speed limit at least, seconds: rows are up to a second apart, and some drive faster than the
/// limit.
const LEAST_PASSAGE_S: f64 = 1.5;
/// Between two rows a vehicle gets so much farther than its speed says, at most: a share and metres.
const REACH: [f64; 2] = [1.5, 5.0];

/// A line as a person names it: `LANE_OR_EDGE:METRES`.
#[derive(Clone, Debug, PartialEq)]
pub struct LinePlace {
    /// SUMO's id of a lane or an edge.
    pub name: String,
    /// From its start, metres.
    pub at_m: f64,
}

impl FromStr for LinePlace {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wanted = "wanted is LANE_OR_EDGE:METRES, such as B0B1:50 or B0B1_0:12.5";
        let (name, metres) = text.rsplit_once(':').ok_or_else(|| format!("there are no metres; {wanted}"))?;
        let at_m = metres.trim().parse().ok().filter(|at_m: &f64| at_m.is_finite() && *at_m >= 0.0);
        let at_m = at_m.ok_or_else(|| format!("\"{metres}\" is no distance in metres; {wanted}"))?;
        if name.trim().is_empty() {
            return Err(format!("there is no lane and no edge; {wanted}"));
        }
        Ok(Self { name: name.trim().into(), at_m })
    }
}

impl LinePlace {
    /// The line in a network; `recording` is whose it is, for messages.
    ///
    /// # Errors
    /// There is no such edge or lane, it ends before the line, or it is so short that vehicles pass it unseen.
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
                format!("the network has no edge and no lane of this name{near}"),
                "name one of the table cars.parquet (column lane), without the index for all lanes of the edge",
            ));
        };
        let line = CrossSection { name: format!("{name}:{at_m}"), is_default: false, edge, lane, at_m: *at_m };
        let length_m = line.lanes(network).map(|lane| network.lane(lane).length_m).fold(f64::INFINITY, f64::min);
        if *at_m > length_m {
            let why = format!("it is {length_m:.1} m long");
            return Err(fault(why, "name a distance from its start that is within it"));
        }
        if passage_s(network, edge) < LEAST_PASSAGE_S {
            let why = format!(
                "it is {length_m:.1} m long: vehicles far from the ego have a row each second, and pass it unseen"
            );
            return Err(fault(why, "name the edge before or after it"));
        }
        Ok(line)
    }
}

/// How long the fastest lane of an edge takes at its speed limit, seconds.
fn passage_s(network: &Network, edge: EdgeId) -> f64 {
    let lanes = network.edge(edge).lanes().map(|lane| network.lane(lane));
    lanes.map(|lane| lane.length_m / lane.speed_limit_mps.max(0.1)).fold(f64::INFINITY, f64::min)
}

/// A line across an edge, or across one of its lanes.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossSection {
    /// Where: `LANE_OR_EDGE:METRES`.
    pub name: String,
    /// Nobody named it: it is at the middle of the ego's path.
    pub is_default: bool,
    edge: EdgeId,
    lane: Option<LaneId>,
    at_m: f64,
}

impl CrossSection {
    /// All lanes of the street nearest to the middle of the ego's path that is long enough; `None` if there is no such street.
    pub fn middle_of_path(map: &RoadMap) -> Option<Self> {
        let (net, middle_m) = (&map.network, map.route.length_m() / 2.0);
        let is_street = |lane: &&RouteLane| {
            net.edge_named(&lane.edge)
                .is_some_and(|edge| net.edge(edge).kind == EdgeKind::Normal && passage_s(net, edge) >= LEAST_PASSAGE_S)
        };
        let nearest_m = |lane: &RouteLane| middle_m.clamp(lane.start_s_m, lane.start_s_m + lane.length_m);
        let away_m = |lane: &RouteLane| (nearest_m(lane) - middle_m).abs();
        let streets = map.route.lanes().iter().filter(is_street);
        let street = streets.min_by(|a, b| away_m(a).total_cmp(&away_m(b)))?;
        let at_m = (nearest_m(street) - street.start_s_m).round().min(street.length_m);
        let name = format!("{}:{at_m}", street.edge);
        Some(Self { name, is_default: true, edge: net.edge_named(&street.edge)?, lane: None, at_m })
    }

    /// The lanes that it crosses.
    fn lanes<'a>(&'a self, network: &'a Network) -> impl Iterator<Item = LaneId> + 'a {
        network.edge(self.edge).lanes().filter(|lane| self.lane.is_none_or(|own| own == *lane))
    }
}

/// Where a vehicle was in a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowPlace {
    /// When.
    pub tick: u64,
    /// Its lane.
    pub lane: LaneId,
    /// Front bumper along it, metres.
    pub s_m: f64,
    /// Its speed, m/s.
    pub speed_mps: f64,
}

/// How many have passed a line.
#[derive(Clone, Debug, PartialEq)]
pub struct LineCount {
    /// Which.
    pub line: CrossSection,
    /// Vehicles, the ego among them.
    pub vehicles: u64,
    /// Longest time between the two rows of a passage, seconds: so exactly its moment is known.
    pub resolution_s: f64,
}

impl LineCount {
    /// Nobody yet.
    pub fn new(line: CrossSection) -> Self {
        Self { line, vehicles: 0, resolution_s: 0.0 }
    }

    /// A vehicle was there, and is here at its next row.
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
        // Who comes to the edge, or leaves it, in any other way than over its ends has not passed it.
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
