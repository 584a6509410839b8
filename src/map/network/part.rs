//! Part of a network: the streets of some junctions. In: a network, and which junctions to keep. Out: a network of their streets and inner
//! lanes, with indices of its own; signals keep theirs.

use super::{Connection, Edge, EdgeId, Junction, JunctionId, Lane, LaneId, Network, Roundabout};
use crate::map::SumoText;

/// New index of each kept part, by its old one.
struct KeptIndices(Vec<Option<u32>>);

impl KeptIndices {
    fn of(kept: impl Iterator<Item = bool>) -> Self {
        let mut next = 0;
        let number = |is_kept: bool| {
            let index = is_kept.then_some(next);
            next += u32::from(is_kept);
            index
        };
        Self(kept.map(number).collect())
    }

    fn get(&self, old: usize) -> Option<usize> {
        self.0[old].map(|index| index as usize)
    }
}

impl Network {
    /// Returns the part of the network with the streets that meet at the junctions for which `is_kept` is true. Junctions at the other ends of
    /// these streets have no links. It has no text for SUMO.
    #[must_use]
    pub fn part(&self, is_kept: impl Fn(JunctionId) -> bool) -> Self {
        let at = |junction: Option<JunctionId>| junction.is_some_and(&is_kept);
        let has_street = |edge: &Edge| match edge.junction {
            Some(inside) => is_kept(inside),
            None => at(edge.from) || at(edge.to),
        };
        let edges = KeptIndices::of(self.edges.iter().map(has_street));
        let lanes = KeptIndices::of(self.lanes.iter().map(|lane| edges.get(lane.edge.index()).is_some()));
        let mut touched: Vec<bool> = (0..self.junctions.len()).map(|k| is_kept(JunctionId::from_index(k))).collect();
        for edge in self.edges.iter().filter(|edge| has_street(edge)) {
            [edge.from, edge.to].into_iter().flatten().for_each(|junction| touched[junction.index()] = true);
        }
        let junctions = KeptIndices::of(touched.into_iter());
        let edge_of = |old: EdgeId| edges.get(old.index()).map(EdgeId::from_index);
        let lane_of = |old: LaneId| lanes.get(old.index()).map(LaneId::from_index);
        let junction_of = |old: JunctionId| junctions.get(old.index()).map(JunctionId::from_index);
        let lanes_of = |old: &[LaneId]| old.iter().copied().filter_map(lane_of).collect::<Vec<_>>();
        let edge = |(k, edge): (usize, &Edge)| {
            edges.get(k)?;
            let first = edge.lanes().next().and_then(lane_of).map_or(0, |lane| lane.index() as u32);
            Some(Edge {
                from: edge.from.and_then(junction_of),
                to: edge.to.and_then(junction_of),
                junction: edge.junction.and_then(junction_of),
                lanes: first..first + edge.lanes.len() as u32,
                bidi: edge.bidi.and_then(edge_of),
                crosses: edge.crosses.iter().copied().filter_map(edge_of).collect(),
                ..edge.clone()
            })
        };
        let lane = |lane: &Lane| {
            Some(Lane { edge: edge_of(lane.edge)?, opposite: lane.opposite.and_then(lane_of), ..lane.clone() })
        };
        let connection = |way: &Connection| {
            // One that leads through an inner lane needs it.
            let via = way.via.map(lane_of);
            let via = if via == Some(None) { return None } else { via.flatten() };
            Some(Connection { from: lane_of(way.from)?, to: lane_of(way.to)?, via, link: None, ..way.clone() })
        };
        let junction = |(k, junction): (usize, &Junction)| {
            junctions.get(k)?;
            let mut part = Junction {
                incoming: lanes_of(&junction.incoming),
                inside: lanes_of(&junction.inside),
                ..junction.clone()
            };
            if !is_kept(JunctionId::from_index(k)) {
                part.links.clear();
            }
            Some(part)
        };
        let roundabout = |round: &Roundabout| {
            let junctions = round.junctions.iter().map(|junction| junction_of(*junction)).collect::<Option<_>>()?;
            Some(Roundabout { junctions, edges: round.edges.iter().map(|edge| edge_of(*edge)).collect::<Option<_>>()? })
        };
        let mut part = Self {
            edges: self.edges.iter().enumerate().filter_map(edge).collect(),
            lanes: self.lanes.iter().filter_map(lane).collect(),
            junctions: self.junctions.iter().enumerate().filter_map(junction).collect(),
            connections: self.connections.iter().filter_map(connection).collect(),
            roundabouts: self.roundabouts.iter().filter_map(roundabout).collect(),
            signals: self.signals.clone(),
            header: self.header.clone(),
            location: self.location.clone(),
            left_hand: self.left_hand,
            sumo: SumoText::default(),
            surroundings: self.surroundings.clone(),
            ..Self::default()
        };
        part.derive();
        part
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn the_part_at_one_junction_has_its_streets_alone() {
        let net = Network::load("grid").expect("a shipped map");
        // The one in the middle, with four streets of two directions.
        let busiest =
            net.junctions().iter().max_by_key(|junction| junction.incoming.len()).expect("junctions").id.clone();
        let kept = |junction: JunctionId| net.junction(junction).id == busiest;
        let part = net.part(kept);
        let streets = |net: &Network| {
            let streets = net.edges().iter().filter(|edge| edge.kind.is_street());
            streets.map(|edge| edge.id.clone()).collect::<BTreeSet<_>>()
        };
        let meets = |edge: &&Edge| [edge.from, edge.to].into_iter().flatten().any(kept);
        let own: BTreeSet<String> =
            net.edges().iter().filter(|edge| edge.kind.is_street()).filter(meets).map(|edge| edge.id.clone()).collect();
        assert_eq!(streets(&part), own);
        assert!(own.len() == 8 && streets(&net).len() > 8, "{own:?}");
        // Each lane lies where it lay, on its edge; ways through the junction lead on as before.
        for lane in part.lane_ids() {
            let old = net.lane_named(&part.lane(lane).id).expect("a lane of the whole");
            assert_eq!(part.lane(lane).shape(), net.lane(old).shape());
            assert_eq!(part.edge_of(lane).id, net.edge_of(old).id);
            assert!(part.edge_of(lane).lanes().any(|own| own == lane));
        }
        let ways = |net: &Network| -> BTreeSet<(String, String)> {
            let ways = net.connections().iter();
            ways.map(|way| (net.lane(way.from).id.clone(), net.lane(way.to).id.clone())).collect()
        };
        assert!(ways(&part).is_subset(&ways(&net)));
        let through = |net: &Network| {
            let at = net.junctions().iter().find(|junction| junction.id == busiest).expect("kept");
            at.incoming.iter().map(|lane| net.connections_from(*lane).len()).sum::<usize>()
        };
        assert_eq!(through(&part), through(&net));
        let links = |net: &Network| {
            let at = net.junctions().iter().find(|junction| junction.id == busiest).expect("kept");
            at.links.iter().filter(|link| link.connection.is_some()).count()
        };
        assert_eq!(links(&part), links(&net));
        assert_eq!(part.signals().len(), net.signals().len());
    }
}
