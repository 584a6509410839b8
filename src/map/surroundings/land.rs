//! Kinds of land and trees, by OpenStreetMap's keys. In: the type of a polygon, such as `landuse.forest`. Out: a [`LandUse`].

use glam::DVec2;
use roxmltree::Node;

/// Type of a tree, and of a row of trees.
pub(super) const TREE: &str = "natural.tree";
pub(super) const TREE_ROW: &str = "natural.tree_row";
/// Key of a parameter that says which leaves a tree has.
pub(super) const LEAVES: &str = "leaf_type";

/// Kind of land, by what is seen of it from the road.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum LandUse {
    /// Wood with closed crowns.
    Wood,
    /// Bushes up to the height of a person.
    Scrub,
    /// Lawn with trees: a park, a garden, a cemetery.
    Park,
    /// Lawn or meadow without trees.
    Grass,
    /// Arable land without trees.
    Field,
    /// Land for houses with gardens.
    Residential,
    /// Land for shops and offices, with paved ground.
    Commercial,
    /// Paved ground: a car park, a square, a yard.
    Paved,
    Water,
}

impl LandUse {
    /// Returns the kind of land by a polygon's type, key and value of OpenStreetMap; `None` if it states none.
    pub(super) fn of(kind: &str) -> Option<Self> {
        let (key, value) = kind.split_once('.')?;
        Some(match (key, value) {
            ("landuse", "forest") | ("natural", "wood") => Self::Wood,
            ("natural", "scrub" | "heath" | "shrubbery") => Self::Scrub,
            ("leisure", "park" | "garden" | "golf_course" | "playground" | "dog_park" | "nature_reserve")
            | ("landuse", "cemetery" | "orchard" | "allotments")
            | ("tourism", "camp_site")
            | ("amenity", "grave_yard") => Self::Park,
            ("landuse", "grass" | "meadow" | "village_green" | "recreation_ground" | "greenfield" | "flowerbed")
            | ("natural", "grassland" | "wetland")
            | ("leisure", "pitch" | "common" | "track") => Self::Grass,
            ("landuse", "farmland" | "vineyard" | "plant_nursery") => Self::Field,
            ("landuse", "residential" | "farmyard" | "religious" | "education")
            | ("amenity", "school" | "kindergarten" | "hospital") => Self::Residential,
            ("landuse", "commercial" | "retail") => Self::Commercial,
            ("landuse", "industrial" | "railway" | "garages" | "construction" | "brownfield" | "quarry")
            | ("amenity", "parking" | "fuel" | "marketplace")
            | ("place", "square")
            | ("natural", "sand" | "beach" | "bare_rock" | "scree" | "shingle") => Self::Paved,
            ("natural", "water" | "bay")
            | ("waterway", "riverbank" | "dock")
            | ("landuse", "reservoir" | "basin")
            | ("leisure", "swimming_pool") => Self::Water,
            _ => return None,
        })
    }

    /// Returns a type that is read as this kind.
    pub(super) fn key_value(self) -> &'static str {
        match self {
            Self::Wood => "natural.wood",
            Self::Scrub => "natural.scrub",
            Self::Park => "leisure.park",
            Self::Grass => "landuse.grass",
            Self::Field => "landuse.farmland",
            Self::Residential => "landuse.residential",
            Self::Commercial => "landuse.commercial",
            Self::Paved => "amenity.parking",
            Self::Water => "natural.water",
        }
    }
}

/// Area of one kind of land.
#[derive(Clone, Debug, PartialEq)]
pub struct LandArea {
    /// Corners, counter-clockwise, the first one once.
    pub outline: Vec<DVec2>,
    pub land_use: LandUse,
}

impl LandArea {
    /// Returns a rectangle by its lower left corner and its sides along the axes, metres.
    pub fn rectangle(land_use: LandUse, [x, y]: [f64; 2], [width_m, depth_m]: [f64; 2]) -> Self {
        let corners = [[x, y], [x + width_m, y], [x + width_m, y + depth_m], [x, y + depth_m]];
        Self { outline: corners.map(DVec2::from).to_vec(), land_use }
    }

    /// Returns the area within the outline, m².
    pub fn area_m2(&self) -> f64 {
        super::doubled_area_m2(&self.outline).abs() / 2.0
    }
}

/// Tree at a stated place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StatedTree {
    pub position: DVec2,
    /// True for a tree with needles.
    pub is_conifer: bool,
}

/// Checks whether the parameters of a tree say that it has needles.
pub(super) fn has_needles(node: Node) -> bool {
    let is_needles =
        |child: Node| child.attribute("key") == Some(LEAVES) && child.attribute("value") == Some("needleleaved");
    node.children().any(is_needles)
}
