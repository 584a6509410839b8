//! Places of a scene on the ego's path. In: the positions of an OpenSCENARIO file, its roads, and the network that was made of them. Out: a
//! [`Scene`]: the map with the path of one entity, and the distances of places along and beside it. Metres, radians.

use super::{
    OpenScenario,
    actions::Deed,
    document::Place,
    fault::OpenScenarioError,
    positions::{Placement, Spot, spot},
};
use crate::map::{
    OpenDriveRoads, RoadMap,
    network::{LaneId, LanePosition, Network, TurnDirection},
};
use glam::DVec2;
use std::collections::BTreeMap;

/// Largest distance between a place and the path, m: the width of a motorway with a verge.
const BESIDE_M: f64 = 50.0;
/// Largest distance of the leading entity from the middle of a lane, m.
const REACH_M: f64 = 10.0;
/// Length after which a path without a route ends, m, and its largest number of streets.
const STRAIGHT_ON_M: f64 = 5000.0;
const MOST_STREETS: usize = 100;

/// Place beside the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PathPlace {
    /// Distance along the path, m.
    pub s_m: f64,
    /// Offset to the left of the path, m.
    pub offset_m: f64,
    /// True where the heading is against the path.
    pub is_against: bool,
}

/// Roads with the path, and the places of the entities at the start.
pub(super) struct Scene<'r> {
    pub map: RoadMap,
    /// Words of the path in a scenario.
    pub path: String,
    /// Entity whose path it is.
    pub lead: String,
    pub roads: &'r OpenDriveRoads,
    pub spots: BTreeMap<String, Spot>,
}

impl<'r> Scene<'r> {
    /// Finds the path of the entity `lead` on the network of the file `map`.
    ///
    /// # Errors
    /// A place does not exist, the entity stands on no lane for cars, or its waypoints cannot be driven.
    pub fn new(scenario: &'r OpenScenario, map: &str, lead: &str) -> Result<Self, OpenScenarioError> {
        let roads = &scenario.roads;
        let spots = spots(scenario)?;
        let fault = |message: String| OpenScenarioError { file: scenario.file.clone(), line: 0, message };
        let network = Network::load(map).map_err(|error| fault(error.to_string()))?;
        let init = scenario.storyboard.init.iter().filter(|action| action.entity.as_deref() == Some(lead));
        let mut route: Option<(Vec<&Placement>, &Place)> = None;
        let mut start: Option<&Place> = None;
        for action in init {
            match &action.deed {
                Deed::Route(waypoints) => route = Some((waypoints.iter().collect(), &action.place)),
                Deed::Teleport(placement) => start = Some(&placement.place),
                _ => {}
            }
        }
        let (Some(at), Some(start)) = (spots.get(lead), start) else {
            return Err(fault(format!(
                "{lead} has no place at the start, and the path begins there\n  remedy: a <TeleportAction> in <Init>"
            )));
        };
        let lane = lane_of(&network, at).ok_or_else(|| {
            start.fault(format!(
                "{lead} stands more than {REACH_M} m from all lanes for cars in its direction\n  remedy: a place on a lane for cars"
            ))
        })?;
        let id = network.lane(lane).id.as_str();
        let (path, place) = match route {
            Some((waypoints, place)) => {
                let mut words = vec![id.to_owned()];
                for waypoint in waypoints {
                    let point = spot(waypoint, roads, &|name| spots.get(name).cloned())?.point + network.offset();
                    words.push(format!("{:.3},{:.3}", point.x, point.y));
                }
                (words.join(" ... "), place)
            }
            None => (straight_on(&network, lane).join(" "), start),
        };
        let words: Vec<&str> = path.split_whitespace().collect();
        let map = RoadMap::load_along(map, &words)
            .map_err(|error| place.fault(format!("the path of {lead} cannot be driven: {error}")))?;
        Ok(Self { map, path, lead: lead.to_owned(), roads, spots })
    }

    /// Returns the spot of a placement.
    ///
    /// # Errors
    /// The road or the lane does not exist, or the place depends on an entity without one.
    pub fn spot(&self, placement: &Placement) -> Result<Spot, OpenScenarioError> {
        spot(placement, self.roads, &|name| self.spots.get(name).cloned())
    }

    /// Returns the place of a spot beside the path; `None` where it is too far from it.
    pub fn place(&self, spot: &Spot) -> Option<PathPlace> {
        let route = &self.map.route;
        let found = route.project(spot.point + self.map.network.offset(), None);
        let is_against = (spot.heading_rad - route.yaw_at(found.s_m)).cos() < 0.0;
        (found.offset_m.abs() <= BESIDE_M).then_some(PathPlace { s_m: found.s_m, offset_m: found.offset_m, is_against })
    }

    /// Returns 1 where the reference line of an entity's road leads along the path at the start, and -1 where it leads against it.
    pub fn road_sign(&self, spot: &Spot) -> f64 {
        let line = spot.on_road.as_ref().and_then(|(road, s_m, _, _)| self.roads.road(road)?.place(*s_m, 0.0));
        let place = self.place(spot);
        let turn = line.zip(place).map(|((_, heading_rad), place)| heading_rad - self.map.route.yaw_at(place.s_m));
        if turn.is_some_and(|turn_rad| turn_rad.cos() < 0.0) { -1.0 } else { 1.0 }
    }
}

/// Returns the spots of all entities that are placed at the start. Places beside other entities come after these.
fn spots(scenario: &OpenScenario) -> Result<BTreeMap<String, Spot>, OpenScenarioError> {
    let mut left: Vec<(&String, &Placement)> = Vec::new();
    for action in &scenario.storyboard.init {
        if let (Some(entity), Deed::Teleport(placement)) = (&action.entity, &action.deed) {
            left.push((entity, placement));
        }
    }
    let mut spots: BTreeMap<String, Spot> = BTreeMap::new();
    while !left.is_empty() {
        let (mut later, mut first_fault, before) = (Vec::new(), None, left.len());
        for (entity, placement) in left {
            match spot(placement, &scenario.roads, &|name| spots.get(name).cloned()) {
                Ok(found) => drop(spots.insert(entity.clone(), found)),
                Err(fault) => {
                    first_fault = first_fault.or(Some(fault));
                    later.push((entity, placement));
                }
            }
        }
        if let Some(fault) = first_fault.filter(|_| later.len() == before) {
            return Err(fault);
        }
        left = later;
    }
    Ok(spots)
}

/// Returns the lane for cars nearest to a spot that leads in its direction.
fn lane_of(network: &Network, spot: &Spot) -> Option<LaneId> {
    let point = spot.point + network.offset();
    let lanes = network.lane_ids().filter(|lane| {
        let lane = network.lane(*lane);
        lane.admits_cars() && network.edge(lane.edge).kind.is_street()
    });
    let measured = lanes.filter_map(|lane| {
        let foot = LanePosition { offset_m: 0.0, ..network.place_in(lane, point.extend(0.0)) };
        let pose = network.pose(foot).flat();
        let distance_m = pose.position.distance(point);
        let is_along = DVec2::from_angle(spot.heading_rad).dot(pose.forward()) > 0.0;
        (is_along && distance_m <= REACH_M).then_some((distance_m, lane))
    });
    measured.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, lane)| lane)
}

/// Returns the words of the path from a lane straight on through junctions.
fn straight_on(network: &Network, lane: LaneId) -> Vec<String> {
    let mut words = vec![network.lane(lane).id.clone()];
    let (mut here, mut length_m) = (lane, network.lane(lane).length_m);
    while words.len() < MOST_STREETS && length_m < STRAIGHT_ON_M {
        let edge = network.lane(here).edge;
        let lanes = network.edge(edge).lanes();
        let ways = std::iter::once(here).chain(lanes.filter(|lane| *lane != here));
        let mut ways = ways.flat_map(|lane| network.connections_from(lane));
        let onwards = ways.find(|way| {
            let to = network.lane(way.to);
            way.direction == TurnDirection::Straight && to.admits_cars() && network.edge(to.edge).kind.is_street()
        });
        let Some(way) = onwards else { break };
        let next = &network.edge_of(way.to).id;
        if words.contains(next) || network.lane(way.to).edge == network.lane(lane).edge {
            break;
        }
        words.push(next.clone());
        here = way.to;
        length_m += network.lane(here).length_m;
    }
    words
}
