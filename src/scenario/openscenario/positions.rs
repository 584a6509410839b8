//! Positions of OpenSCENARIO. In: elements such as `<LanePosition>`, and the roads of the scenario. Out: [`Placement`]s, and from them points with
//! headings in the coordinates of the roads. Metres, radians.

use super::{document::Place, fault::OpenScenarioError, parameters::Node, reader::Reader};
use crate::{
    map::{OpenDriveRoad, OpenDriveRoads},
    toml_text::did_you_mean,
};
use glam::{DVec2, dvec2};
use std::f64::consts::PI;

/// Largest distance by which a place may lie beyond an end of its road, m: rounding in files.
const BEYOND_M: f64 = 0.5;

/// Position as a file states it.
#[derive(Clone, Debug)]
pub(super) enum Position {
    World(DVec2),
    Lane {
        road: String,
        lane: i32,
        s_m: f64,
        offset_m: f64,
    },
    Road {
        road: String,
        s_m: f64,
        t_m: f64,
    },
    /// Place on the lanes beside another entity.
    BesideLane {
        entity: String,
        lanes: i32,
        ds_m: f64,
        offset_m: f64,
    },
    /// Place along the road of another entity.
    BesideRoad {
        entity: String,
        ds_m: f64,
        dt_m: f64,
    },
    /// Place by the axes of the world, or by those of the entity.
    BesideEntity {
        entity: String,
        by: DVec2,
        is_turned: bool,
    },
    /// Place along a route from its first waypoint.
    Route {
        waypoints: Vec<Placement>,
        along_m: f64,
        lane: Option<i32>,
        offset_m: f64,
    },
}

/// Position with its orientation and the place in the file.
#[derive(Clone, Debug)]
pub(super) struct Placement {
    pub position: Position,
    /// Heading, and true if it is relative to the road or to the other entity.
    pub heading: (f64, bool),
    pub place: Place,
}

impl Placement {
    /// Returns true for a place that depends on that of an entity.
    pub fn is_beside_entity(&self) -> bool {
        use Position::{BesideEntity, BesideLane, BesideRoad};
        matches!(self.position, BesideLane { .. } | BesideRoad { .. } | BesideEntity { .. })
    }
}

/// Point of the roads' coordinates.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Spot {
    pub point: DVec2,
    pub heading_rad: f64,
    /// Road with the distances along it and to the left of its line, and the lane, if the position names them.
    pub on_road: Option<(String, f64, f64, Option<i32>)>,
}

impl Reader {
    /// Reads the only child of an element such as `<Position>`; `None` if it is reported as unknown.
    ///
    /// # Errors
    /// A number or a name is missing or malformed.
    pub fn position(&mut self, parent: &Node) -> Result<Option<Placement>, OpenScenarioError> {
        let node = parent.only()?;
        self.expect(parent, &[], &[node.name()])?;
        let position = match node.name() {
            "WorldPosition" => {
                self.expect(&node, &["x", "y", "z", "h", "p", "r"], &[])?;
                Position::World(dvec2(node.number("x")?, node.number("y")?))
            }
            "LanePosition" => {
                self.expect(&node, &["roadId", "laneId", "s", "offset"], &["Orientation"])?;
                Position::Lane {
                    road: node.text("roadId")?,
                    lane: node.whole("laneId")?,
                    s_m: node.number("s")?,
                    offset_m: node.find_number("offset")?.unwrap_or(0.0),
                }
            }
            "RoadPosition" => {
                self.expect(&node, &["roadId", "s", "t"], &["Orientation"])?;
                Position::Road { road: node.text("roadId")?, s_m: node.number("s")?, t_m: node.number("t")? }
            }
            "RelativeLanePosition" => {
                self.expect(&node, &["entityRef", "dLane", "ds", "offset"], &["Orientation"])?;
                Position::BesideLane {
                    entity: node.text("entityRef")?,
                    lanes: node.whole("dLane")?,
                    ds_m: node.number("ds")?,
                    offset_m: node.find_number("offset")?.unwrap_or(0.0),
                }
            }
            "RelativeRoadPosition" => {
                self.expect(&node, &["entityRef", "ds", "dt"], &["Orientation"])?;
                Position::BesideRoad {
                    entity: node.text("entityRef")?,
                    ds_m: node.number("ds")?,
                    dt_m: node.number("dt")?,
                }
            }
            "RelativeWorldPosition" | "RelativeObjectPosition" => {
                self.expect(&node, &["entityRef", "dx", "dy", "dz"], &["Orientation"])?;
                Position::BesideEntity {
                    entity: node.text("entityRef")?,
                    by: dvec2(node.number("dx")?, node.number("dy")?),
                    is_turned: node.name() == "RelativeObjectPosition",
                }
            }
            "RoutePosition" => match self.route_position(&node)? {
                Some(position) => position,
                None => return Ok(None),
            },
            _ => {
                self.leave_out_unknown(&node);
                return Ok(None);
            }
        };
        let own = node.find_number("h")?.filter(|_| node.name() == "WorldPosition");
        let heading = match (own, node.find("Orientation")?) {
            (Some(heading_rad), _) => (heading_rad, false),
            (None, Some(turn)) => {
                self.expect(&turn, &["type", "h", "p", "r"], &[])?;
                let is_relative = turn.find_text("type")?.is_some_and(|kind| kind == "relative");
                (turn.find_number("h")?.unwrap_or(0.0), is_relative)
            }
            (None, None) => (0.0, node.name() != "WorldPosition"),
        };
        Ok(Some(Placement { position, heading, place: node.place().clone() }))
    }

    fn route_position(&mut self, node: &Node) -> Result<Option<Position>, OpenScenarioError> {
        self.expect(node, &[], &["RouteRef", "InRoutePosition", "Orientation"])?;
        let waypoints = self.route_of(&node.child("RouteRef")?)?;
        let within = node.child("InRoutePosition")?.only()?;
        let (lane, offset_m) = match within.name() {
            "FromLaneCoordinates" => {
                self.expect(&within, &["pathS", "laneId", "laneOffset"], &[])?;
                (Some(within.whole("laneId")?), within.find_number("laneOffset")?.unwrap_or(0.0))
            }
            "FromRoadCoordinates" => {
                self.expect(&within, &["pathS", "t"], &[])?;
                (None, within.number("t")?)
            }
            _ => {
                self.leave_out_unknown(&within);
                return Ok(None);
            }
        };
        Ok(Some(Position::Route { waypoints, along_m: within.number("pathS")?, lane, offset_m }))
    }

    /// Reads the waypoints of the route within an element, or of the one that it refers to.
    pub fn route_of(&mut self, parent: &Node) -> Result<Vec<Placement>, OpenScenarioError> {
        let node = parent.only()?;
        match node.name() {
            "CatalogReference" => self.follow(&node, |reader, entry| reader.route(entry)),
            "Route" => self.route(&node),
            other => Err(node.fault(format!("\"{other}\" stands for a route; allowed: Route, CatalogReference"))),
        }
    }

    fn route(&mut self, node: &Node) -> Result<Vec<Placement>, OpenScenarioError> {
        self.expect(node, &["name", "closed"], &["Waypoint"])?;
        if node.name() != "Route" {
            return Err(node.fault("the entry is no route"));
        }
        if node.truth("closed")? {
            self.leave_out_part(node, "closed", "the route is driven once");
        }
        let mut waypoints = Vec::new();
        for waypoint in node.all("Waypoint")? {
            self.expect(&waypoint, &["routeStrategy"], &["Position"])?;
            waypoints.extend(self.position(&waypoint.child("Position")?)?);
        }
        if waypoints.is_empty() {
            return Err(node.fault("the route has no waypoint"));
        }
        Ok(waypoints)
    }
}

/// Returns the spot of a placement; `spot_of` returns that of another entity, if it is known.
///
/// # Errors
/// The road or the lane does not exist, the place lies beyond the road, or the other entity has no place.
pub(super) fn spot(
    placement: &Placement,
    roads: &OpenDriveRoads,
    spot_of: &dyn Fn(&str) -> Option<Spot>,
) -> Result<Spot, OpenScenarioError> {
    let at = &placement.place;
    let entity = |name: &str| {
        let why = "where it is cannot be known before the drive\n  remedy: a place on a road";
        spot_of(name).ok_or_else(|| at.fault(format!("the place depends on \"{name}\"; {why}")))
    };
    let on_road = |name: &str| {
        let other = entity(name)?;
        let missing = || at.fault(format!("\"{name}\" stands on no road\n  remedy: give it a <LanePosition>"));
        other.on_road.clone().map(|on_road| (other, on_road)).ok_or_else(missing)
    };
    let mut base_rad = 0.0;
    let found = match &placement.position {
        Position::World(point) => Spot { point: *point, heading_rad: 0.0, on_road: None },
        Position::Lane { road, lane, s_m, offset_m } => lane_spot(at, roads, road, (*lane, *s_m, *offset_m))?,
        Position::Road { road, s_m, t_m } => road_spot(at, roads, road, (*s_m, *t_m))?,
        Position::BesideLane { entity: name, lanes, ds_m, offset_m } => {
            let (other, (road, s_m, t_m, lane)) = on_road(name)?;
            let known = known_road(at, roads, &road)?;
            let lane = lane.or_else(|| known.lane_under(s_m, t_m));
            let lane = lane.ok_or_else(|| at.fault(format!("\"{name}\" stands beside the lanes of road {road}")))?;
            let sign = if faces_along(known, &other, s_m) { 1.0 } else { -1.0 };
            let lane = lane_beside(lane, *lanes * sign as i32);
            lane_spot(at, roads, &road, (lane, s_m + sign * ds_m, *offset_m))?
        }
        Position::BesideRoad { entity: name, ds_m, dt_m } => {
            let (_, (road, s_m, t_m, _)) = on_road(name)?;
            road_spot(at, roads, &road, (s_m + ds_m, t_m + dt_m))?
        }
        Position::BesideEntity { entity: name, by, is_turned } => {
            let other = entity(name)?;
            let by = if *is_turned { DVec2::from_angle(other.heading_rad).rotate(*by) } else { *by };
            base_rad = if placement.heading.1 { other.heading_rad } else { 0.0 };
            Spot { point: other.point + by, heading_rad: 0.0, on_road: None }
        }
        Position::Route { waypoints, along_m, lane, offset_m } => {
            let first = spot(&waypoints[0], roads, spot_of)?;
            let missing = || at.fault("the route begins at a point without a road\n  remedy: a <LanePosition>");
            let (road, s_m, _, first_lane) = first.on_road.clone().ok_or_else(missing)?;
            let sign = if faces_along(known_road(at, roads, &road)?, &first, s_m) { 1.0 } else { -1.0 };
            match lane.or(first_lane) {
                Some(lane) if lane != 0 => lane_spot(at, roads, &road, (lane, s_m + sign * along_m, *offset_m))?,
                _ => road_spot(at, roads, &road, (s_m + sign * along_m, *offset_m))?,
            }
        }
    };
    let (turn_rad, is_relative) = placement.heading;
    let heading_rad = if is_relative { found.heading_rad + base_rad + turn_rad } else { turn_rad };
    Ok(Spot { heading_rad, ..found })
}

/// Returns the lane this many lanes to the left of another, seen along the road, without the middle lane 0.
pub(super) fn lane_beside(lane: i32, to_the_left: i32) -> i32 {
    let (mut found, step) = (lane, to_the_left.signum());
    for _ in 0..to_the_left.abs().min(100) {
        found += step;
        if found == 0 {
            found += step;
        }
    }
    found
}

/// Returns true if an entity heads along the reference line of its road.
fn faces_along(road: &OpenDriveRoad, spot: &Spot, s_m: f64) -> bool {
    road.place(s_m, 0.0).is_none_or(|(_, heading_rad)| (spot.heading_rad - heading_rad).cos() >= 0.0)
}

fn known_road<'r>(at: &Place, roads: &'r OpenDriveRoads, id: &str) -> Result<&'r OpenDriveRoad, OpenScenarioError> {
    roads.road(id).ok_or_else(|| {
        let known: Vec<&str> = roads.roads().iter().map(|road| road.id.as_str()).collect();
        let some = known.iter().take(20).copied().collect::<Vec<_>>().join(", ");
        at.fault(format!("the road file has no road \"{id}\"{}; it has {some}", did_you_mean(id, &known)))
    })
}

/// Returns the distance along a road, moved onto it where it lies barely beyond an end.
fn along(at: &Place, road: &OpenDriveRoad, s_m: f64) -> Result<f64, OpenScenarioError> {
    match (-BEYOND_M..=road.length_m + BEYOND_M).contains(&s_m) {
        true => Ok(s_m.clamp(0.0, road.length_m)),
        false => Err(at.fault(format!("s is {s_m} on road {}; allowed: 0 to {:.2} m", road.id, road.length_m))),
    }
}

fn lane_spot(
    at: &Place,
    roads: &OpenDriveRoads,
    road: &str,
    (lane, s_m, offset_m): (i32, f64, f64),
) -> Result<Spot, OpenScenarioError> {
    let known = known_road(at, roads, road)?;
    let s_m = along(at, known, s_m)?;
    let middle_m = known.lane_middle_m(lane, s_m).ok_or_else(|| {
        let lanes: Vec<String> = known.lanes_at(s_m).iter().map(ToString::to_string).collect();
        at.fault(format!("road {road} has no lane {lane} at {s_m} m; it has {}", lanes.join(", ")))
    })?;
    let found = road_spot(at, roads, road, (s_m, middle_m + offset_m))?;
    let turn_rad = if known.drives_along(lane) { 0.0 } else { PI };
    let on_road = found.on_road.map(|(road, s_m, t_m, _)| (road, s_m, t_m, Some(lane)));
    Ok(Spot { point: found.point, heading_rad: found.heading_rad + turn_rad, on_road })
}

fn road_spot(
    at: &Place,
    roads: &OpenDriveRoads,
    road: &str,
    (s_m, t_m): (f64, f64),
) -> Result<Spot, OpenScenarioError> {
    let known = known_road(at, roads, road)?;
    let s_m = along(at, known, s_m)?;
    let without = || at.fault(format!("road {road} has no reference line at {s_m} m"));
    let (point, heading_rad) = known.place(s_m, t_m).ok_or_else(without)?;
    Ok(Spot { point, heading_rad, on_road: Some((road.to_owned(), s_m, t_m, None)) })
}
