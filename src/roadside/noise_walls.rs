//! Noise walls between fast roads and the homes beside them. In: guard rails, the buildings behind them, paved surfaces. Out: the walls' posts,
//! metres. Places are the project's own (`docs/references.md: roads`).

use super::{
    buildings::Buildings,
    guard_rails::{GuardRail, RailPost},
    road_surfaces::RoadSurfaces,
};

/// Distance of a wall behind its rail, metres.
const BEHIND_RAIL_M: f32 = 2.0;
/// Distances behind a rail at which buildings are looked for, and the largest distance of a building from such a place, metres: homes are
/// screened up to 85 m from a rail.
const LOOKED_AT_M: [f32; 5] = [10.0, 25.0, 40.0, 55.0, 70.0];
const NEAR_M: f32 = 15.0;
/// Number of spans by which a wall reaches beyond the last home, and of the shortest wall: 60 m, and 100 m.
const BEYOND: usize = 15;
const SHORTEST: usize = 25;
/// Least distance of a post from any asphalt and from any building, metres.
const FREE_M: f32 = 1.0;

/// Wall along a guard rail.
#[derive(Clone, Debug, PartialEq)]
pub struct NoiseWall {
    pub posts: Vec<RailPost>,
}

/// Returns all noise walls beside guard rails.
pub fn noise_walls(rails: &[GuardRail], buildings: &Buildings, surfaces: &RoadSurfaces) -> Vec<NoiseWall> {
    if buildings.plots.is_empty() && buildings.blocks.is_empty() {
        return Vec::new();
    }
    rails.iter().flat_map(|rail| along(rail, buildings, surfaces)).collect()
}

/// Returns the walls along a rail.
fn along(rail: &GuardRail, buildings: &Buildings, surfaces: &RoadSurfaces) -> Vec<NoiseWall> {
    let is_home_behind = |post: &RailPost| {
        let at = |behind_m: f32| (post.foot - post.to_road * behind_m).truncate();
        LOOKED_AT_M.iter().any(|behind_m| buildings.distance_m(at(*behind_m)) < NEAR_M)
    };
    let homes: Vec<usize> = (0..rail.posts.len()).filter(|k| is_home_behind(&rail.posts[*k])).collect();
    let is_screened = |k: usize| {
        let next = homes.partition_point(|home| home + BEYOND < k);
        homes.get(next).is_some_and(|home| *home <= k + BEYOND)
    };
    let wall = |post: &RailPost| RailPost { foot: post.foot - post.to_road * BEHIND_RAIL_M, ..*post };
    let is_free = |post: &RailPost| {
        let at = post.foot.truncate();
        surfaces.border_m(at) > FREE_M && buildings.distance_m(at) > FREE_M && !surfaces.is_on_bridge(post.foot)
    };
    let posts: Vec<Option<RailPost>> = rail
        .posts
        .iter()
        .enumerate()
        .map(|(k, post)| Some(wall(post)).filter(|post| is_screened(k) && is_free(post)))
        .collect();
    let runs = posts.split(Option::is_none).filter(|run| run.len() > SHORTEST);
    runs.map(|run| NoiseWall { posts: run.iter().copied().flatten().collect() }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        map::{
            network::Network,
            surroundings::{BuildingUse, Footprint, Surroundings},
        },
        roadside::{guard_rails::guard_rails, land_use_map::LandUseMap, town::Town},
    };
    use glam::{Vec3, dvec2};

    /// Returns the walls of a straight rail of 400 m whose road is to the north, with a house so far behind it, metres.
    fn walls(behind_m: f64) -> Vec<NoiseWall> {
        let post = |k: usize| RailPost { foot: Vec3::new(4.0 * k as f32, 0.0, 0.0), along: Vec3::X, to_road: Vec3::Y };
        let rail = GuardRail { posts: (0..=100).map(post).collect(), into_ground: [false; 2] };
        let net = Network::load("tests/data/networks/ramps.net.xml").expect("a network");
        let corner = |x: f64, y: f64| dvec2(200.0 + x, -behind_m + y);
        let outline = vec![corner(-5.0, -5.0), corner(5.0, -5.0), corner(5.0, 5.0), corner(-5.0, 5.0)];
        let house = Footprint { outline, kind: BuildingUse::House, height_m: None };
        // Its roads lie to the north of the rail.
        let far = net.moved_by(dvec2(0.0, 60.0).extend(0.0));
        let surfaces = RoadSurfaces::of(&far);
        let net = far.with_surroundings(Surroundings { buildings: vec![house], ..Surroundings::default() });
        let land_use = LandUseMap::of(net.surroundings(), &surfaces);
        let buildings = Buildings::of(&net, &Town::of(&net), &land_use, &surfaces, 1);
        assert_eq!(buildings.plots.len() + buildings.blocks.len(), 1);
        noise_walls(&[rail], &buildings, &surfaces)
    }

    #[test]
    fn a_wall_screens_a_house_near_a_rail_and_none_far_away() {
        let found = walls(45.0);
        let [wall] = &found[..] else { panic!("{found:?}") };
        // Places 15 m from a house of 10 m reach 20 m to either side of its middle, and the wall 60 m further: 160 m about x = 200.
        let (first, last) = (wall.posts[0].foot, wall.posts[wall.posts.len() - 1].foot);
        assert!((first.x - 120.0).abs() <= 4.0 && (last.x - 280.0).abs() <= 4.0, "{first} {last}");
        assert!(wall.posts.iter().all(|post| post.foot.y == -2.0));
        assert!(walls(120.0).is_empty());
    }

    #[test]
    fn roads_without_homes_beside_them_have_no_walls() {
        let net = Network::load("tests/data/networks/ramps.net.xml").expect("a network");
        let surfaces = RoadSurfaces::of(&net);
        assert!(noise_walls(&guard_rails(&net, &surfaces), &Buildings::default(), &surfaces).is_empty());
    }
}
