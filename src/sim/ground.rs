//! The ground under the ego's wheels, from the map: asphalt on lanes, their shoulders and in junctions, grass elsewhere. On a network the
//! ground has the height and the grade of the ego's lane. The ego's route is asphalt, too, across a gap between two lanes without the
//! outline of a junction.

use crate::{
    ego::{GroundModel, GroundShape, GroundSurface},
    map::{
        Route, SHOULDER_M,
        network::{EdgeKind, LaneId, Network},
    },
};
use glam::{DVec2, DVec3};

/// Ground along a route.
pub(super) struct RoadGround<'a> {
    pub route: &'a Route,
    /// Approximate position of the ego along the route, metres; the search stays near it.
    pub near_s_m: f64,
}

impl GroundModel for RoadGround<'_> {
    fn surface(&self, point: DVec2) -> GroundSurface {
        let found = self.route.project(point, Some(self.near_s_m));
        let half_m = self.route.width_m(found.s_m) / 2.0 + SHOULDER_M;
        if found.offset_m.abs() <= half_m { GroundSurface::Asphalt } else { GroundSurface::Grass }
    }
}

/// Half the distance between a car's axles, metres.
const HALF_WHEELBASE_M: f64 = 1.4;

/// Ground of a network.
pub(super) struct NetworkGround<'a> {
    pub network: &'a Network,
    /// Lane of the ego, if known.
    pub near: Option<LaneId>,
    /// Height of the road at the ego, metres; separates a bridge from the road below it.
    pub height_m: f64,
    /// Ground along the ego's route.
    pub way: RoadGround<'a>,
    /// Circle in which all is asphalt: its middle and its radius, metres.
    pub clear: (DVec2, f64),
}

/// Circle without a point, for [`NetworkGround::clear`].
pub(super) const NONE_CLEAR: (DVec2, f64) = (DVec2::ZERO, -1.0);

impl NetworkGround<'_> {
    /// Returns true if a point is on the lane found near `hint` or on the shoulder of that lane.
    fn is_on_lane(&self, at: DVec3, hint: Option<LaneId>) -> bool {
        self.network.lane_under(at, SHOULDER_M, hint).is_some()
    }

    /// Returns true if a point is in the junction that the ego is in, approaches or leaves, or in a paved wedge between roads that part or
    /// meet there. Without a lane of the ego, the lane nearest to the point counts.
    fn is_in_junction(&self, at: DVec2) -> bool {
        let nearest = || self.network.locate(at.extend(self.height_m), None).map(|found| found.lane);
        let Some(lane) = self.near.or_else(nearest) else { return false };
        let edge = self.network.edge_of(lane);
        let around = [edge.from, edge.to, edge.junction];
        let mut wedges = self.network.gores().iter().filter(|wedge| around.contains(&Some(wedge.junction)));
        let mut junctions = around.into_iter().flatten();
        junctions.any(|junction| self.network.junction(junction).covers(at)) || wedges.any(|wedge| wedge.covers(at))
    }
}

impl GroundModel for NetworkGround<'_> {
    fn surface(&self, point: DVec2) -> GroundSurface {
        if point.distance(self.clear.0) <= self.clear.1 {
            return GroundSurface::Asphalt;
        }
        let at = point.extend(self.height_m);
        let is_road = self.is_on_lane(at, self.near) || self.is_in_junction(point) || self.is_on_lane(at, None);
        if is_road { GroundSurface::Asphalt } else { self.way.surface(point) }
    }

    fn is_for_vehicles(&self, point: DVec2) -> bool {
        let at = point.extend(self.height_m);
        let under = |hint: Option<LaneId>| self.network.lane_under(at, SHOULDER_M, hint);
        let lane = under(self.near).or_else(|| under(None));
        let is_driven = |lane: LaneId| {
            !self.network.lane(lane).is_footway() || self.network.edge_of(lane).kind == EdgeKind::Crossing
        };
        lane.map_or_else(|| self.way.surface(point) == GroundSurface::Asphalt, is_driven)
    }

    fn shape(&self, middle: DVec2) -> GroundShape {
        let Some(found) = self.network.locate(middle.extend(self.height_m), self.near) else {
            return GroundShape { height_m: self.height_m, gradient: DVec2::ZERO };
        };
        let road = self.network.pose(found);
        let ahead = DVec2::from_angle(road.yaw_rad);
        let height_m = |along_m: f64| {
            let at = (middle + ahead * along_m).extend(road.position.z);
            self.network.locate(at, self.near).map(|found| self.network.pose(found).position.z)
        };
        // On a level road the height everywhere is that in the middle; where the grade changes, the axles stand on either side.
        let axles =
            if self.network.is_level() { [None; 2] } else { [HALF_WHEELBASE_M, -HALF_WHEELBASE_M].map(height_m) };
        if let [Some(front_m), Some(rear_m)] = axles {
            let grade = (front_m - rear_m) / (2.0 * HALF_WHEELBASE_M);
            return GroundShape { height_m: (front_m + rear_m) / 2.0, gradient: ahead * grade };
        }
        GroundShape { height_m: road.position.z, gradient: ahead * road.grade }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{RouteLane, network::LanePosition};

    /// Returns an open route along these points.
    fn way_along(shape: Vec<DVec2>) -> Route {
        let length_m = shape.windows(2).map(|pair| pair[0].distance(pair[1])).sum();
        Route::open(vec![RouteLane { lane: None, start_s_m: 0.0, length_m, speed_limit_mps: 9.0, width_m: 3.2, shape }])
    }

    fn far_away() -> Route {
        way_along(vec![DVec2::splat(1e5), DVec2::new(1e5 + 10.0, 1e5)])
    }

    #[test]
    fn asphalt_ends_and_grass_begins_at_the_edge_of_the_shoulder() {
        let map = crate::map::RoadMap::load("ring-250").expect("the shipped ring");
        let ground = RoadGround { route: &map.route, near_s_m: 30.0 };
        let (middle, left) = (map.route.point_at(30.0), DVec2::from_angle(map.route.yaw_at(30.0)).perp());
        // The lane is 3.6 m wide, as the head of the ring's net.xml says, and the shoulder 0.4 m.
        let edge_m = 3.6 / 2.0 + 0.4;
        for side in [1.0, -1.0] {
            let at = |offset_m: f64| ground.surface(middle + side * offset_m * left);
            assert_eq!([0.0, 1.5, edge_m - 0.02].map(at), [GroundSurface::Asphalt; 3]);
            assert_eq!([edge_m + 0.02, 4.0].map(at), [GroundSurface::Grass; 2]);
        }
    }

    #[test]
    fn lanes_and_junctions_are_asphalt_with_the_roads_height_and_grade() {
        let net = Network::load("tests/data/networks/grid-signals.net.xml").expect("a network");
        // Lanes are 3.2 m wide; the grid's crossings are 100 m apart, with B1 in the middle. C1B1 leads to B1 from the east.
        let lane = net.lane_named("C1B1_0").expect("a lane");
        let near = Some(lane);
        let elsewhere = far_away();
        let way = RoadGround { route: &elsewhere, near_s_m: 1.0 };
        let ground = NetworkGround { network: &net, near, height_m: 0.0, way, clear: NONE_CLEAR };
        let line = net.pose(LanePosition { lane, s_m: 40.0, offset_m: 0.0 });
        let (middle, left) = (line.position.truncate(), DVec2::from_angle(line.yaw_rad).perp());
        let at = |offset_m: f64| ground.surface(middle + left * offset_m);
        // The lane beside it and the two lanes of the other direction are road, too; grass begins beyond the shoulders.
        assert_eq!([0.0, -1.9, 3.2, 5.4, 6.4, 9.6, 11.5].map(at), [GroundSurface::Asphalt; 7]);
        assert_eq!([-2.1, 11.7].map(at), [GroundSurface::Grass; 2]);
        let junction = net.junctions().iter().find(|junction| junction.id == "B1").expect("a junction");
        assert_eq!(ground.surface(junction.position.truncate()), GroundSurface::Asphalt);
        assert_eq!(ground.shape(middle), GroundShape::default());

        let hill = Network::load("tests/data/networks/hill.net.xml").expect("a network");
        let lane = hill.lane_named("up_1").expect("a lane");
        let ground = NetworkGround { network: &hill, near: Some(lane), height_m: 9.0, ..ground };
        // Between the second and third point of its shape in the file, 62.1 m apart on the ground and 9 m in height.
        let (a, b) = (DVec2::new(50.2751, 103.4195), DVec2::new(110.4934, 118.4741));
        let shape = ground.shape((a + b) / 2.0);
        assert!((shape.height_m - 9.5).abs() < 0.01, "{shape:?}");
        let along = (b - a).normalize() * 9.0 / a.distance(b);
        assert!(shape.gradient.distance(along) < 0.01, "{shape:?} {along}");
    }

    #[test]
    fn the_area_of_a_junction_is_asphalt_where_no_lane_is_drawn() {
        // A network without internal lanes.
        let net = Network::load("tests/data/networks/random-8.net.xml").expect("a network");
        let elsewhere = far_away();
        let way = || RoadGround { route: &elsewhere, near_s_m: 1.0 };
        let seen = |near| NetworkGround { network: &net, near, height_m: 0.0, way: way(), clear: NONE_CLEAR };
        let bare = net.junctions().iter().filter(|junction| {
            let middle = junction.position.truncate();
            junction.covers(middle) && !seen(None).is_on_lane(junction.position, None)
        });
        let mut compared = 0;
        for junction in bare {
            let Some(lane) = junction.incoming.first().copied() else { continue };
            assert_eq!(
                seen(Some(lane)).surface(junction.position.truncate()),
                GroundSurface::Asphalt,
                "{}",
                junction.id
            );
            // Without a lane of the ego, as beside a corner, the ground is the same where a lane is near.
            let is_near_a_lane = net.locate(junction.position, None).is_some();
            let unhinted = seen(None).surface(junction.position.truncate());
            assert_eq!(unhinted == GroundSurface::Asphalt, is_near_a_lane, "{}", junction.id);
            compared += 1;
        }
        assert!(compared > 0, "there are such junctions");
    }

    #[test]
    fn pavements_are_asphalt_but_not_for_vehicles() {
        // The street cn leads to the north: its pavement is 2 m wide around x = 124.2, its lane 3.2 m around x = 121.6, as in the file. A
        // crossing leads over it around y = 127.9.
        let net = Network::load("tests/data/networks/town.net.xml").expect("a network");
        let elsewhere = far_away();
        let way = || RoadGround { route: &elsewhere, near_s_m: 1.0 };
        for near in [None, net.lane_named("cn_1"), net.lane_named("cn_0")] {
            let ground = NetworkGround { network: &net, near, height_m: 0.0, way: way(), clear: NONE_CLEAR };
            let on = |x: f64, y: f64| {
                let at = DVec2::new(x, y);
                (ground.surface(at) == GroundSurface::Asphalt, ground.is_for_vehicles(at))
            };
            assert_eq!([on(123.7, 160.0), on(125.0, 160.0)], [(true, false); 2], "{near:?}");
            assert_eq!([on(121.6, 160.0), on(121.6, 127.9)], [(true, true); 2], "{near:?}");
        }
    }

    #[test]
    fn the_wedge_between_a_motorway_and_its_exit_is_asphalt_to_its_end() {
        let net = Network::load("motorway").expect("a shipped map");
        let gore = net.gores().iter().find(|gore| gore.parts).expect("the exit");
        let rows: Vec<[DVec3; 2]> = gore.rows().collect();
        let middle = |k: usize| ((rows[k][0] + rows[k][1]) / 2.0).truncate();
        let elsewhere = far_away();
        let way = RoadGround { route: &elsewhere, near_s_m: 1.0 };
        let near = net.lane_named("off_0");
        let ground = NetworkGround { network: &net, near, height_m: 0.0, way, clear: NONE_CLEAR };
        // Its last metre is 2.8 m wide, and shoulders are 0.4 m.
        let last = rows.len() - 1;
        assert!(rows[last][0].distance(rows[last][1]) > 2.0);
        assert_eq!([last / 2, last - 1].map(|k| ground.surface(middle(k))), [GroundSurface::Asphalt; 2]);
        assert_eq!(ground.surface(middle(last) * 2.0 - middle(last - 3)), GroundSurface::Grass);
    }

    #[test]
    fn the_way_over_a_gap_between_two_lanes_is_asphalt() {
        // Two lanes to the east with a gap of 14 m, at a junction without an outline.
        let lane = |id: &str, from: f64| {
            format!(
                "<edge id=\"{id}\"><lane id=\"{id}_0\" index=\"0\" speed=\"9\" length=\"40\" shape=\"{from},0 {},0\"/></edge>",
                from + 40.0
            )
        };
        let text = format!(
            "<net>{}{}<connection from=\"a\" to=\"b\" fromLane=\"0\" toLane=\"0\"/></net>",
            lane("a", 0.0),
            lane("b", 54.0)
        );
        let net = Network::read(std::path::Path::new("t.net.xml"), &text).expect("a network");
        let route = way_along(vec![DVec2::ZERO, DVec2::new(94.0, 0.0)]);
        let way = RoadGround { route: &route, near_s_m: 45.0 };
        let ground = NetworkGround { network: &net, near: None, height_m: 0.0, way, clear: NONE_CLEAR };
        // The lane is 3.2 m wide and each shoulder 0.4 m.
        let at = |y: f64| ground.surface(DVec2::new(47.0, y));
        assert_eq!([0.0, 1.9, -1.9].map(at), [GroundSurface::Asphalt; 3]);
        assert_eq!([2.1, -2.1].map(at), [GroundSurface::Grass; 2]);
    }
}
