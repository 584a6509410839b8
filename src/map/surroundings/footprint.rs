//! Footprints of buildings beside a network. In: SUMO's file of polygons in a map's folder, as polyconvert writes it. Out: [`Footprint`]s in
//! the network's coordinates, metres; or the fault with file, line and value.

use super::{MapError, limits::MOST_BYTES};
use crate::sumo_xml::document;
use glam::DVec2;
use std::{fmt::Write, path::Path};

/// File name of a map's buildings.
pub const FOOTPRINTS: &str = "buildings.xml";
/// Height of a storey, metres.
pub const STOREY_M: f64 = 3.0;
/// Maximum number of footprints of a map, and of corners of one.
const MOST_FOOTPRINTS: usize = 100_000;
const MOST_CORNERS: usize = 2000;
/// Greatest height of a building, metres: the tallest of the world has 828 m.
const HIGHEST_M: f64 = 1000.0;

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
    fn of(value: &str, area_m2: f64) -> Self {
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
        doubled_area_m2(&self.outline).abs() / 2.0
    }
}

fn doubled_area_m2(outline: &[DVec2]) -> f64 {
    let next = |k: usize| outline[(k + 1) % outline.len()];
    (0..outline.len()).map(|k| outline[k].perp_dot(next(k))).sum()
}

/// Reads the buildings of a file of SUMO polygons; other polygons and thin ones are left out.
///
/// # Errors
/// The file cannot be read, is no XML, or has a value out of range.
pub fn read(file: &Path) -> Result<Vec<Footprint>, MapError> {
    let text = document::read_text(file, MOST_BYTES).map_err(|source| MapError::Io { file: file.into(), source })?;
    parse(file, &text)
}

fn parse(file: &Path, text: &str) -> Result<Vec<Footprint>, MapError> {
    let tree = roxmltree::Document::parse(text).map_err(|error| {
        let at = error.pos();
        MapError::NotXml { file: file.into(), line: at.row, column: at.col, message: error.to_string() }
    })?;
    let mut found = Vec::new();
    for poly in tree.root_element().children().filter(|node| node.has_tag_name("poly")) {
        let Some(value) = poly.attribute("type").and_then(building) else { continue };
        let fault = |attribute: &str, value: &str, allowed: &'static str| MapError::Value {
            file: file.into(),
            line: tree.text_pos_at(poly.range().start).row,
            element: format!("poly \"{}\"", poly.attribute("id").unwrap_or_default()),
            attribute: attribute.into(),
            value: format!("\"{}\"", value.chars().take(60).collect::<String>()),
            allowed,
        };
        let shape = poly.attribute("shape").unwrap_or_default();
        let mut outline: Vec<DVec2> = shape.split_whitespace().map(point).collect::<Option<_>>().ok_or_else(|| {
            fault("shape", shape, "points x,y with a blank between them, metres, each number within 10,000,000")
        })?;
        outline.dedup_by(|a, b| a.distance(*b) < 0.01);
        if outline.len() > 1 && outline.first().zip(outline.last()).is_some_and(|(a, b)| a.distance(*b) < 0.01) {
            outline.pop();
        }
        if outline.len() > MOST_CORNERS || found.len() == MOST_FOOTPRINTS {
            let (what, value) = ("the number of buildings or of one's corners".into(), "larger".into());
            let allowed = format!("at most {MOST_FOOTPRINTS} and {MOST_CORNERS}");
            return Err(MapError::Limit { file: file.into(), what, value, allowed });
        }
        let doubled_m2 = doubled_area_m2(&outline);
        if outline.len() < 3 || doubled_m2.abs() < 8.0 {
            continue;
        }
        if doubled_m2 < 0.0 {
            outline.reverse();
        }
        let height_m = poly.attribute("height").map(|text| height(text).ok_or((text, "height")));
        let levels = || {
            let of_levels = |node: &roxmltree::Node| node.attribute("key") == Some("building:levels");
            let text = poly.children().find(of_levels)?.attribute("value")?;
            // What people write there may be no number, such as "2-3".
            height(text).map(|levels| levels.ceil() * STOREY_M)
        };
        let height_m = match height_m {
            Some(Ok(height_m)) => Some(height_m),
            Some(Err((text, attribute))) => return Err(fault(attribute, text, "metres above 0, at most 1000")),
            None => levels(),
        };
        found.push(Footprint { kind: BuildingUse::of(value, doubled_m2.abs() / 2.0), outline, height_m });
    }
    Ok(found)
}

/// Returns the value of OpenStreetMap's key `building` from the type of a polygon; `None` for another polygon.
fn building(kind: &str) -> Option<&str> {
    match kind.strip_prefix("building")? {
        "" => Some("yes"),
        rest => rest.strip_prefix('.'),
    }
}

fn point(text: &str) -> Option<DVec2> {
    let numbers: Vec<f64> = text.split(',').map(str::parse).collect::<Result<_, _>>().ok()?;
    let point = DVec2::new(*numbers.first()?, *numbers.get(1)?);
    // Not by the larger of both, which ignores NaN.
    point.to_array().iter().all(|number| number.abs() <= 1e7).then_some(point)
}

fn height(text: &str) -> Option<f64> {
    text.trim().parse().ok().filter(|height_m: &f64| *height_m > 0.0 && *height_m <= HIGHEST_M)
}

/// Returns the text of a file with these buildings, each as a polygon of SUMO.
pub fn text(footprints: &[Footprint]) -> String {
    let mut text = String::from("<additional>\n");
    for (id, footprint) in footprints.iter().enumerate() {
        let value = match footprint.kind {
            BuildingUse::House => "house",
            BuildingUse::Flats => "apartments",
            BuildingUse::Shops => "retail",
            BuildingUse::Outbuilding => "shed",
        };
        let height = footprint.height_m.map_or(String::new(), |height_m| format!(" height=\"{height_m}\""));
        let shape = footprint.outline.iter().map(|at| format!("{:.2},{:.2}", at.x, at.y)).collect::<Vec<_>>().join(" ");
        let _ = writeln!(text, "    <poly id=\"{id}\" type=\"building.{value}\"{height} shape=\"{shape}\"/>");
    }
    text + "</additional>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(polygons: &str) -> Result<Vec<Footprint>, String> {
        parse(Path::new("buildings.xml"), &format!("<additional>\n{polygons}\n</additional>"))
            .map_err(|e| e.to_string())
    }

    #[test]
    fn buildings_are_read_with_their_use_height_and_outline() {
        // By SUMO's polyconvert 1.28 from OpenStreetMap's tags, the first one without its repeated corner.
        let found = of(
            r#"<poly id="200" type="building.house" layer="-1.00" shape="71.89,18.59 86.22,18.40 86.37,29.52 72.04,29.71 71.89,18.59">
                   <param key="building:levels" value="2"/>
               </poly>
               <poly id="201" type="building.yes" height="11.50" shape="0,0 0,20 20,20 20,0"/>
               <poly id="202" type="landuse.forest" shape="0,0 9,0 9,9"/>
               <poly id="203" type="building" shape="0,0 9,0 9,0.1"/>
               <poly id="204" type="building.garage" shape="0,0,5 4,0,5 4,6,5 0,6,5"><param key="building:levels" value="1-2"/></poly>"#,
        )
        .expect("polygons");
        let looks: Vec<_> = found.iter().map(|f| (f.kind, f.height_m, f.outline.len(), f.area_m2().round())).collect();
        use BuildingUse::{Flats, House, Outbuilding};
        assert_eq!(
            looks,
            [(House, Some(6.0), 4, 159.0), (Flats, Some(11.5), 4, 400.0), (Outbuilding, None, 4, 24.0)],
            "other polygons and thin ones are left out"
        );
        assert!(found.iter().all(|footprint| doubled_area_m2(&footprint.outline) > 0.0), "counter-clockwise");
        assert_eq!(parse(Path::new("x"), &text(&found)).expect("its own file"), found);
    }

    #[test]
    fn a_fault_names_file_line_and_value() {
        let shape = of("<poly id=\"7\" type=\"building\" shape=\"0,0 x,1\"/>").unwrap_err();
        assert!(shape.starts_with("buildings.xml:2: poly \"7\": shape is \"0,0 x,1\"; allowed: points x,y"), "{shape}");
        assert!(of("<poly id=\"7\" type=\"building\" shape=\"NaN,0 9,0 9,9\"/>").is_err());
        let height = of("<poly id=\"7\" type=\"building\" height=\"-3\" shape=\"0,0 9,0 9,9\"/>").unwrap_err();
        assert!(height.contains("height is \"-3\"; allowed: metres above 0"), "{height}");
        assert!(of("<poly").unwrap_err().starts_with("buildings.xml:"));
    }
}
