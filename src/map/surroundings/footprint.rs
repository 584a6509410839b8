//! Footprints of buildings, by OpenStreetMap's key `building`. In: a polygon. Out: a [`Footprint`], metres.

use crate::map::MapError;
use glam::DVec2;
use roxmltree::Node;

/// Height of a storey, metres.
pub const STOREY_M: f64 = 3.0;
/// Greatest height of a building, metres: the tallest of the world has 828 m.
pub(super) const HIGHEST_M: f64 = 1000.0;

/// Use of a building.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuildingUse {
    /// House for one or two families.
    House,
    /// House of flats, an office, a school, and all that is unknown and large.
    Flats,
    /// Shops on the ground floor.
    Shops,
    /// Garage, shed, or another building without windows.
    Outbuilding,
}

impl BuildingUse {
    /// Returns the use by the value of OpenStreetMap's key `building`, and by the area where that says nothing, m².
    pub(super) fn of(value: &str, area_m2: f64) -> Self {
        match value {
            "house" | "detached" | "semidetached_house" | "semi" | "terrace" | "bungalow" | "farm" | "cabin" => {
                Self::House
            }
            "apartments" | "dormitory" | "hotel" | "office" | "school" | "hospital" | "university" | "public" => {
                Self::Flats
            }
            "retail" | "commercial" | "supermarket" | "shop" | "kiosk" => Self::Shops,
            "garage" | "garages" | "shed" | "hut" | "carport" | "roof" | "greenhouse" | "barn" | "industrial"
            | "warehouse" => Self::Outbuilding,
            _ if area_m2 < 25.0 => Self::Outbuilding,
            _ if area_m2 < 200.0 => Self::House,
            _ => Self::Flats,
        }
    }

    /// Returns a type that is read as this use.
    pub(super) fn key_value(self) -> &'static str {
        match self {
            Self::House => "building.house",
            Self::Flats => "building.apartments",
            Self::Shops => "building.retail",
            Self::Outbuilding => "building.shed",
        }
    }
}

/// Footprint of a building.
#[derive(Clone, Debug, PartialEq)]
pub struct Footprint {
    /// Corners, counter-clockwise, the first one once.
    pub outline: Vec<DVec2>,
    pub kind: BuildingUse,
    /// Height over the ground, metres, if the file states it or a number of storeys.
    pub height_m: Option<f64>,
}

impl Footprint {
    /// Returns the area within the outline, m².
    pub fn area_m2(&self) -> f64 {
        super::doubled_area_m2(&self.outline).abs() / 2.0
    }

    /// Returns the building of a polygon with this outline, whose type states this value of OpenStreetMap's key `building`.
    ///
    /// # Errors
    /// The height is no height.
    pub(super) fn read(
        node: Node,
        value: &str,
        outline: Vec<DVec2>,
        fault: &dyn Fn((&str, &str), &'static str) -> MapError,
    ) -> Result<Self, MapError> {
        let stated = node.attribute("height").map(|text| height(text).ok_or(("height", text)));
        let levels = || {
            let of_levels = |child: &Node| child.attribute("key") == Some("building:levels");
            let text = node.children().find(of_levels)?.attribute("value")?;
            // What people write there may be no number, such as "2-3".
            height(text).map(|levels| levels.ceil() * STOREY_M)
        };
        let height_m = match stated {
            Some(Ok(height_m)) => Some(height_m),
            Some(Err(text)) => return Err(fault(text, "metres above 0, at most 1000")),
            None => levels(),
        };
        let kind = BuildingUse::of(value, super::doubled_area_m2(&outline).abs() / 2.0);
        Ok(Self { outline, kind, height_m })
    }
}

/// Returns the value of OpenStreetMap's key `building` from the type of a polygon; `None` for another polygon.
pub(super) fn value_of(kind: &str) -> Option<&str> {
    match kind.strip_prefix("building")? {
        "" => Some("yes"),
        rest => rest.strip_prefix('.'),
    }
}

fn height(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|height_m: &f64| *height_m > 0.0 && *height_m <= HIGHEST_M)
}
