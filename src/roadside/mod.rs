//! Surroundings of the roads of a network, for the picture and for contacts: paved surfaces, ends of roads, towns, kinds of land, buildings,
//! guard rails, noise walls, posts, parked cars, trees. In: a network, a seed. Out: a [`Roadside`] in a frame near the roads, metres; the same
//! network and seed give the same bits.
//!
//! `road_surfaces` says where asphalt is, with the areas of `junction_areas`, the corners of `outlines` and a `cell_grid` to look things up in. `road_ends` lets roads run on at the
//! network's edge; of a large network `near_roads` keeps the part near the path. `town` says which streets have pavements, `land_use_map` what a map states of the ground, `relief` how high it is, with the
//! `noise` of hills and the `verge_shape` of roads. `plots` and `footprint_places` place the `buildings`, whose
//! `house_plans` say how they and their fences look. `street_lamps`, `signal_places`, `parked_cars` and `trees` place what their names say.
//! `fixed_objects` are those parts that a car cannot pass.

pub mod buildings;
mod cell_grid;
pub mod fixed_objects;
pub mod footprint_places;
pub mod guard_rails;
pub mod house_plans;
pub mod junction_areas;
pub mod land_use_map;
mod near_roads;
pub mod noise;
pub mod noise_walls;
pub mod outlines;
pub mod parked_cars;
pub mod plots;
pub mod relief;
pub mod road_ends;
pub mod road_surfaces;
pub mod signal_places;
pub mod street_lamps;
pub mod town;
pub mod trees;
pub mod verge_shape;

use self::{
    buildings::Buildings,
    fixed_objects::FixedObjects,
    guard_rails::GuardRail,
    land_use_map::LandUseMap,
    noise_walls::NoiseWall,
    parked_cars::ParkedCar,
    relief::Relief,
    road_ends::DeadEnd,
    road_surfaces::RoadSurfaces,
    signal_places::SignalPlace,
    street_lamps::StreetLamp,
    town::Town,
    trees::{Woods, forest},
};
use crate::map::{RoadMap, network::Network};
use glam::{DVec2, DVec3};
use std::sync::{Arc, OnceLock};

/// Step of the frame's origin, metres: in single precision, a network at most so far from the origin has its places to a tenth of a
/// millimetre.
pub const ORIGIN_STEP_M: f64 = 2000.0;

/// Roadside of a network.
#[derive(Debug)]
pub struct Roadside {
    /// Origin of the frame in world axes.
    pub origin: DVec3,
    /// Network in this frame.
    pub network: Arc<Network>,
    /// Network whose roads run on beyond its edge, for the picture alone; `None` if none does.
    longer: Option<(Network, RoadSurfaces)>,
    pub dead_ends: Vec<DeadEnd>,
    /// Surfaces of the network's own roads.
    pub own_surfaces: RoadSurfaces,
    pub town: Town,
    pub land_use: LandUseMap,
    pub buildings: Buildings,
    pub guard_rails: Vec<GuardRail>,
    pub noise_walls: Vec<NoiseWall>,
    pub signals: Vec<SignalPlace>,
    pub street_lamps: Vec<StreetLamp>,
    pub parked_cars: Vec<ParkedCar>,
    pub seed: u64,
    most_trees: usize,
    woods: OnceLock<Woods>,
}

impl Roadside {
    /// Finds what stands beside the roads of a network, with at most `most_trees` trees. Of a large network it is the part near the points of a
    /// path.
    pub fn of(network: &Arc<Network>, path: &[DVec2], seed: u64, most_trees: usize) -> Self {
        let is_large = near_roads::is_large(network);
        let part = is_large.then(|| Arc::new(near_roads::part_near(network, path)));
        let network = part.as_ref().unwrap_or(network);
        let (low, high) = network.bounds();
        let origin = ((low + high) / 2.0 / ORIGIN_STEP_M).round() * ORIGIN_STEP_M;
        let network = if origin == DVec3::ZERO { Arc::clone(network) } else { Arc::new(network.moved_by(-origin)) };
        let own_surfaces = RoadSurfaces::of(&network);
        // At the edge of a part roads end in the picture alone.
        let (longer, dead_ends) =
            if is_large { (None, Vec::new()) } else { road_ends::running_on(&network, &own_surfaces) };
        let longer = longer.map(|net| {
            let surfaces = RoadSurfaces::of(&net);
            (net, surfaces)
        });
        let (drawn, surfaces) = longer.as_ref().map_or((&*network, &own_surfaces), |(net, surfaces)| (net, surfaces));
        let land_use = LandUseMap::of(network.surroundings(), surfaces);
        let town = Town::of(&network);
        let buildings = Buildings::of(&network, &town, &land_use, surfaces, seed);
        let guard_rails = guard_rails::guard_rails(drawn, surfaces);
        Self {
            noise_walls: noise_walls::noise_walls(&guard_rails, &buildings, surfaces),
            guard_rails,
            signals: signal_places::signal_places(&network, surfaces),
            street_lamps: street_lamps::street_lamps(&network, &town, surfaces),
            parked_cars: parked_cars::on_drives(&buildings, &Relief::new(surfaces, &land_use, seed)),
            origin,
            network,
            longer,
            dead_ends,
            own_surfaces,
            town,
            land_use,
            buildings,
            seed,
            most_trees,
            woods: OnceLock::new(),
        }
    }

    /// Returns the network as it is drawn: with roads that run on beyond its edge.
    pub fn drawn_network(&self) -> &Network {
        self.longer.as_ref().map_or(&self.network, |(net, _)| net)
    }

    /// Returns the surfaces of all roads that are drawn.
    pub fn surfaces(&self) -> &RoadSurfaces {
        self.longer.as_ref().map_or(&self.own_surfaces, |(_, surfaces)| surfaces)
    }

    /// Returns the ground around the roads.
    pub fn relief(&self) -> Relief<'_> {
        Relief::new(self.surfaces(), &self.land_use, self.seed)
    }

    /// Returns the trees; plants them at the first call.
    pub fn woods(&self) -> &Woods {
        self.woods.get_or_init(|| {
            let stated = self.network.surroundings();
            forest::plant(stated, self.surfaces(), &self.buildings, &self.land_use, self.seed, self.most_trees)
        })
    }
}

/// Roadside of a drive, found when it is first needed: most simulated drivers stay on the road. Clones share it.
#[derive(Clone, Debug)]
pub struct LazyRoadside {
    network: Arc<Network>,
    /// Points along the path if the network is large.
    path: Vec<DVec2>,
    seed: u64,
    most_trees: usize,
    found: Arc<(OnceLock<Roadside>, OnceLock<FixedObjects>)>,
}

impl LazyRoadside {
    /// Returns the roadside of a map with at most `most_trees` trees, not yet found.
    pub fn new(map: &RoadMap, seed: u64, most_trees: usize) -> Self {
        let points =
            if near_roads::is_large(&map.network) { map.route.length_m() / near_roads::PATH_STEP_M } else { 0.0 };
        let path =
            (0..points.ceil() as usize).map(|k| map.route.point_at(k as f64 * near_roads::PATH_STEP_M)).collect();
        Self { network: Arc::clone(&map.network), path, seed, most_trees, found: Arc::default() }
    }

    /// Checks whether the roadside has been found.
    pub fn is_found(&self) -> bool {
        self.found.0.get().is_some()
    }

    /// Returns the roadside; finds it at the first call.
    pub fn get(&self) -> &Roadside {
        self.found.0.get_or_init(|| Roadside::of(&self.network, &self.path, self.seed, self.most_trees))
    }

    /// Returns the objects that a car cannot pass; finds them at the first call.
    pub fn fixed_objects(&self) -> &FixedObjects {
        self.found.1.get_or_init(|| FixedObjects::of(self.get()))
    }
}
