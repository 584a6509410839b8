//! References of a demand's elements: edges, lanes, types, routes, stopping places. In: the elements of all files in the order in which SUMO
//! reads them, and the network. Out: nothing, or the reference that leads nowhere, with what is there. SUMO itself would end the drive at
//! such an element, after an hour of driving.

use crate::{
    map::network::{EdgeId, Network},
    sumo_xml::{stream::Tag, vocabulary::SIGNAL_TYPES},
    toml_text::did_you_mean,
};
use std::collections::{BTreeMap, BTreeSet};

/// Attributes with the ids of one or several edges, in elements that define routes.
const EDGES: [&str; 4] = ["from", "to", "via", "edges"];
/// Attributes of a stop with the id of a stopping place, which are also the names of the elements that define these places.
const STOPPING_PLACES: [&str; 5] = ["busStop", "trainStop", "containerStop", "chargingStation", "parkingArea"];
/// Vehicle types that SUMO defines.
const OWN_TYPES: [&str; 6] = [
    "DEFAULT_VEHTYPE",
    "DEFAULT_PEDTYPE",
    "DEFAULT_BIKETYPE",
    "DEFAULT_TAXITYPE",
    "DEFAULT_RAILTYPE",
    "DEFAULT_CONTAINERTYPE",
];

/// Definitions of all files so far.
pub(super) struct DemandReferences<'n> {
    network: &'n Network,
    types: BTreeSet<String>,
    routes: BTreeSet<String>,
    stopping_places: BTreeSet<String>,
    /// Edges reachable from an edge, one bit each, regardless of permissions.
    reached: BTreeMap<EdgeId, Vec<u64>>,
}

impl<'n> DemandReferences<'n> {
    pub fn new(network: &'n Network) -> Self {
        Self {
            network,
            types: OWN_TYPES.map(str::to_owned).into(),
            routes: BTreeSet::new(),
            stopping_places: BTreeSet::new(),
            reached: BTreeMap::new(),
        }
    }

    /// Checks the references of an element at its start tag, and remembers what it defines.
    ///
    /// # Errors
    /// The first reference that leads nowhere, with its attribute and the allowed values.
    pub fn check(&mut self, tag: &Tag) -> Result<(), String> {
        let id = || tag.attribute("id").unwrap_or_default().to_owned();
        match tag.name.as_str() {
            "vType" | "vTypeDistribution" => drop(self.types.insert(id())),
            "routeDistribution" => drop(self.routes.insert(id())),
            "route" => {
                self.edges(tag)?;
                self.connected(tag)?;
                self.routes.insert(id());
            }
            "vehicle" | "trip" | "flow" => {
                self.edges(tag)?;
                self.way(tag)?;
                named(tag, "type", &self.types, "a vType or a vTypeDistribution above it")?;
                named(tag, "route", &self.routes, "a route or a routeDistribution above it")?;
            }
            "person" | "personFlow" => named(tag, "type", &self.types, "a vType or a vTypeDistribution above it")?,
            "stop" => self.stop(tag)?,
            "tlLogic" => {
                let kind = tag.attribute("type").unwrap_or("static");
                if !SIGNAL_TYPES.split_whitespace().any(|known| known == kind) {
                    return Err(format!("type is \"{kind}\"; allowed: {SIGNAL_TYPES}"));
                }
            }
            place if STOPPING_PLACES.contains(&place) => {
                self.lane(tag)?;
                self.stopping_places.insert(id());
            }
            _ => {}
        }
        Ok(())
    }

    /// Checks that the edges of an element exist.
    fn edges(&self, tag: &Tag) -> Result<(), String> {
        let network = self.network;
        for name in EDGES {
            let edges = tag.attribute(name).unwrap_or_default();
            if let Some(edge) = edges.split_whitespace().find(|edge| network.edge_named(edge).is_none()) {
                let known: Vec<&str> = network.edges().iter().map(|edge| edge.id.as_str()).collect();
                let near = did_you_mean(edge, &known);
                return Err(format!("{name} is \"{edge}\"; allowed: ids of edges of this network{near}"));
            }
        }
        Ok(())
    }

    /// Checks that each edge of a route leads to the next.
    fn connected(&self, tag: &Tag) -> Result<(), String> {
        let network = self.network;
        let named = |edge: &str| network.edge_named(edge);
        let edges = tag.attribute("edges").unwrap_or_default();
        for (edge, next) in edges.split_whitespace().zip(edges.split_whitespace().skip(1)) {
            let (Some(from), Some(to)) = (named(edge), named(next)) else { continue };
            if !self.successors(from).any(|after| after == to) {
                let after: BTreeSet<&str> = self.successors(from).map(|id| network.edge(id).id.as_str()).collect();
                let after: Vec<&str> = after.into_iter().collect();
                let allowed = if after.is_empty() { "none, it is an end of the network" } else { &after.join(", ") };
                return Err(format!("no road leads from edge \"{edge}\" to \"{next}\"; allowed after it: {allowed}"));
            }
        }
        Ok(())
    }

    /// Checks that a route leads from `from` to `to`.
    fn way(&mut self, tag: &Tag) -> Result<(), String> {
        let (Some(from), Some(to)) = (tag.attribute("from"), tag.attribute("to")) else { return Ok(()) };
        if let [Some(start), Some(goal)] = [from, to].map(|edge| self.network.edge_named(edge.trim()))
            && !self.leads(start, goal)
        {
            return Err(format!("no route leads from \"{from}\" to \"{to}\"; allowed: edges that roads connect"));
        }
        Ok(())
    }

    /// Checks the place of a stop.
    fn stop(&self, tag: &Tag) -> Result<(), String> {
        self.lane(tag)?;
        for kind in STOPPING_PLACES {
            named(tag, kind, &self.stopping_places, "a stopping place of the additional_files in [demand]")?;
        }
        let edge = tag.attribute("edge").filter(|edge| self.network.edge_named(edge).is_none());
        edge.map_or(Ok(()), |edge| Err(format!("edge is \"{edge}\"; allowed: an edge of this network")))
    }

    /// Checks that the lane of an element exists.
    fn lane(&self, tag: &Tag) -> Result<(), String> {
        let network = self.network;
        let Some(lane) = tag.attribute("lane").filter(|lane| network.lane_named(lane).is_none()) else { return Ok(()) };
        let edge = lane.rsplit_once('_').and_then(|(edge, _)| network.edge_named(edge));
        let Some(edge) = edge else {
            return Err(format!("lane is \"{lane}\"; allowed: a lane of this network"));
        };
        let lanes: Vec<&str> = network.edge(edge).lanes().map(|lane| network.lane(lane).id.as_str()).collect();
        Err(format!("lane is \"{lane}\"; allowed on this edge: {}", lanes.join(", ")))
    }

    fn successors(&self, edge: EdgeId) -> impl Iterator<Item = EdgeId> {
        let network = self.network;
        let ways = network.edge(edge).lanes().flat_map(|lane| network.connections_from(lane));
        ways.map(|way| network.lane(way.to).edge)
    }

    fn leads(&mut self, from: EdgeId, to: EdgeId) -> bool {
        if !self.reached.contains_key(&from) {
            let mut reached = vec![0u64; self.network.edges().len().div_ceil(64)];
            let mut ahead = vec![from];
            while let Some(at) = ahead.pop() {
                let (word, bit) = (&mut reached[at.index() / 64], 1 << (at.index() % 64));
                if *word & bit == 0 {
                    *word |= bit;
                    ahead.extend(self.successors(at));
                }
            }
            self.reached.insert(from, reached);
        }
        self.reached[&from][to.index() / 64] & (1 << (to.index() % 64)) != 0
    }
}

/// Checks that an attribute, where it is there, has a known id.
fn named(tag: &Tag, attribute: &str, known: &BTreeSet<String>, allowed: &str) -> Result<(), String> {
    let Some(id) = tag.attribute(attribute).filter(|id| !known.contains(*id)) else { return Ok(()) };
    let known: Vec<&str> = known.iter().map(String::as_str).collect();
    Err(format!("{attribute} is \"{id}\"; allowed: the id of {allowed}{}", did_you_mean(id, &known)))
}
