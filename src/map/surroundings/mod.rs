//! Buildings, kinds of land, trees and signs beside the roads of a map. In: SUMO's file of polygons in a map's folder, as
//! polyconvert writes it from OpenStreetMap. Out: [`Surroundings`] in the network's coordinates, metres; or the fault with file, line and
//! value.

mod footprint;
mod land;
pub mod open_drive;
mod road_sign;

pub use self::{
    footprint::{BuildingUse, Footprint, STOREY_M},
    land::{LandArea, LandUse, StatedTree},
    road_sign::{BESIDE_M, StatedSign, StatedSignKind},
};

pub(super) use self::road_sign::older_limit;

use super::{MapError, limits::MOST_BYTES};
use crate::sumo_xml::document;
use glam::DVec2;
use roxmltree::{Document, Node};
use std::{fmt::Write, path::Path};

/// File name of a map's surroundings.
pub const SURROUNDINGS: &str = "surroundings.xml";
/// Maximum number of buildings, areas, trees and signs of a file.
const MOST_KEPT: usize = 200_000;
/// Maximum number of walls of a building, and of corners of an area; an outline with more is made coarser.
const MOST_WALLS: usize = 200;
const MOST_CORNERS: usize = 2000;
/// Least area of a polygon, m².
const LEAST_M2: f64 = 4.0;
/// Distance between the trees of a row, metres.
const ROW_M: f64 = 8.0;

/// Buildings, areas of land, trees and signs beside a network.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surroundings {
    pub buildings: Vec<Footprint>,
    pub areas: Vec<LandArea>,
    pub trees: Vec<StatedTree>,
    pub signs: Vec<StatedSign>,
}

impl Surroundings {
    /// Checks whether nothing is known.
    pub fn is_empty(&self) -> bool {
        self.count() == 0
    }

    /// Returns the number of buildings, areas, trees and signs.
    pub fn count(&self) -> usize {
        self.buildings.len() + self.areas.len() + self.trees.len() + self.signs.len()
    }

    /// Returns all corners and points of buildings, land and trees.
    pub fn points(&self) -> impl Iterator<Item = &DVec2> {
        let outlines = self.buildings.iter().map(|of| &of.outline).chain(self.areas.iter().map(|of| &of.outline));
        outlines.flatten().chain(self.trees.iter().map(|tree| &tree.position))
    }

    /// Returns all land, and the buildings, trees and signs at the places for which `is_near` is true.
    #[must_use]
    pub fn within(&self, is_near: impl Fn(DVec2) -> bool) -> Self {
        let has_near_corner = |building: &&Footprint| building.outline.iter().any(|corner| is_near(*corner));
        Self {
            buildings: self.buildings.iter().filter(has_near_corner).cloned().collect(),
            areas: self.areas.clone(),
            trees: self.trees.iter().filter(|tree| is_near(tree.position)).cloned().collect(),
            signs: self.signs.iter().filter(|sign| is_near(sign.position)).cloned().collect(),
        }
    }

    /// Shifts all coordinates by `by`, metres.
    pub(super) fn move_by(&mut self, by: DVec2) {
        let buildings = self.buildings.iter_mut().flat_map(|of| &mut of.outline);
        let areas = self.areas.iter_mut().flat_map(|of| &mut of.outline);
        let trees = self.trees.iter_mut().map(|tree| &mut tree.position);
        let signs = self.signs.iter_mut().map(|sign| &mut sign.position);
        buildings.chain(areas).chain(trees).chain(signs).for_each(|at| *at += by);
    }

    /// Returns the text of a file with these surroundings.
    pub fn text(&self) -> String {
        let mut text = String::from("<additional>\n");
        let shape = |outline: &[DVec2]| {
            outline.iter().map(|at| format!("{:.2},{:.2}", at.x, at.y)).collect::<Vec<_>>().join(" ")
        };
        for (id, Footprint { outline, kind, height_m }) in self.buildings.iter().enumerate() {
            let height = height_m.map_or(String::new(), |height_m| format!(" height=\"{height_m}\""));
            let (kind, shape) = (kind.key_value(), shape(outline));
            let _ = writeln!(text, "    <poly id=\"b{id}\" type=\"{kind}\"{height} shape=\"{shape}\"/>");
        }
        for (id, LandArea { outline, land_use }) in self.areas.iter().enumerate() {
            let (kind, shape) = (land_use.key_value(), shape(outline));
            let _ = writeln!(text, "    <poly id=\"a{id}\" type=\"{kind}\" shape=\"{shape}\"/>");
        }
        for (id, StatedTree { position: DVec2 { x, y }, is_conifer }) in self.trees.iter().enumerate() {
            let leaves = if *is_conifer { "needleleaved" } else { "broadleaved" };
            let param = format!("<param key=\"{}\" value=\"{leaves}\"/>", land::LEAVES);
            let _ =
                writeln!(text, "    <poi id=\"t{id}\" type=\"{}\" x=\"{x:.2}\" y=\"{y:.2}\">{param}</poi>", land::TREE);
        }
        for (id, sign) in self.signs.iter().enumerate() {
            let (DVec2 { x, y }, code, angle_deg) = (sign.position, sign.kind.code(), sign.angle_deg());
            let kind = format!("{}{code}", road_sign::SIGN);
            let _ = writeln!(
                text,
                "    <poi id=\"s{id}\" type=\"{kind}\" x=\"{x:.2}\" y=\"{y:.2}\" angle=\"{angle_deg:.1}\"/>"
            );
        }
        text + "</additional>\n"
    }
}

/// Reads the surroundings of a file of SUMO polygons and points; those of other types, and thin ones, are left out.
///
/// # Errors
/// The file cannot be read, is no XML, or has a value out of range.
pub fn read(file: &Path) -> Result<Surroundings, MapError> {
    read_within(file, MOST_BYTES)
}

/// Reads a file as [`read`] does, of at most this many bytes.
pub(super) fn read_within(file: &Path, most_bytes: u64) -> Result<Surroundings, MapError> {
    let text = document::read_text(file, most_bytes).map_err(|source| MapError::Io { file: file.into(), source })?;
    parse(file, &text)
}

fn parse(file: &Path, text: &str) -> Result<Surroundings, MapError> {
    let tree = tree_of(file, text)?;
    let mut found = Surroundings::default();
    for node in tree.root_element().children().filter(Node::is_element) {
        let Some(kind) = node.attribute("type") else { continue };
        let fault = |(attribute, value): (&str, &str), allowed: &'static str| MapError::Value {
            file: file.into(),
            line: tree.text_pos_at(node.range().start).row,
            element: format!("{} \"{}\"", node.tag_name().name(), node.attribute("id").unwrap_or_default()),
            attribute: attribute.into(),
            value: format!("\"{}\"", value.chars().take(60).collect::<String>()),
            allowed,
        };
        match node.tag_name().name() {
            "poly" => found.add_polygon(node, kind, &fault)?,
            "poi" => found.add_point(node, kind, &fault)?,
            _ => {}
        }
        if found.count() > MOST_KEPT {
            return Err(too_many(file));
        }
    }
    Ok(found)
}

/// Parses the text of a file.
pub(super) fn tree_of<'text>(file: &Path, text: &'text str) -> Result<Document<'text>, MapError> {
    Document::parse(text).map_err(|error| {
        let at = error.pos();
        MapError::NotXml { file: file.into(), line: at.row, column: at.col, message: error.to_string() }
    })
}

/// Values that coordinates may have.
const POINTS: &str = "points x,y with a blank between them, metres, each number within 10,000,000";

impl Surroundings {
    /// Adds what a polygon of this type states.
    fn add_polygon(
        &mut self,
        node: Node,
        kind: &str,
        fault: &dyn Fn((&str, &str), &'static str) -> MapError,
    ) -> Result<(), MapError> {
        let (of_building, of_land) = (footprint::value_of(kind), LandUse::of(kind));
        if of_building.is_none() && of_land.is_none() && kind != land::TREE_ROW {
            return Ok(());
        }
        let shape = node.attribute("shape").unwrap_or_default();
        let points = shape.split_whitespace().map(point).collect::<Option<Vec<DVec2>>>();
        let points = points.ok_or_else(|| fault(("shape", shape), POINTS))?;
        if kind == land::TREE_ROW {
            let is_conifer = land::has_needles(node);
            let places = along(&points);
            self.trees.extend(places.map(|position| StatedTree { position, is_conifer }));
            return Ok(());
        }
        let most = if of_building.is_some() { MOST_WALLS } else { MOST_CORNERS };
        let Some(points) = closed(points, most) else { return Ok(()) };
        match (of_building, of_land) {
            (Some(value), _) => self.buildings.push(Footprint::read(node, value, points, fault)?),
            (None, Some(land_use)) => self.areas.push(LandArea { outline: points, land_use }),
            (None, None) => {}
        }
        Ok(())
    }

    /// Adds what a point of this type states.
    fn add_point(
        &mut self,
        node: Node,
        kind: &str,
        fault: &dyn Fn((&str, &str), &'static str) -> MapError,
    ) -> Result<(), MapError> {
        let sign = kind.strip_prefix(road_sign::SIGN).and_then(StatedSignKind::of_code);
        if kind != land::TREE && sign.is_none() {
            return Ok(());
        }
        let number = |name: &str| node.attribute(name).unwrap_or_default();
        let text = format!("{},{}", number("x"), number("y"));
        let position = point(&text).ok_or_else(|| fault(("x,y", &text), POINTS))?;
        let Some(kind) = sign else {
            self.trees.push(StatedTree { position, is_conifer: land::has_needles(node) });
            return Ok(());
        };
        let angle = node.attribute("angle").unwrap_or("0");
        let angle_deg = angle.parse().ok().filter(|angle_deg: &f64| angle_deg.abs() <= 360.0);
        let angle_deg =
            angle_deg.ok_or_else(|| fault(("angle", angle), "degrees clockwise from north, -360 to 360"))?;
        self.signs.push(StatedSign { position, facing_rad: StatedSign::facing_rad(angle_deg), kind });
        Ok(())
    }
}

fn too_many(file: &Path) -> MapError {
    let (what, value) = ("the number of buildings, areas, trees and signs".into(), "larger".into());
    MapError::Limit { file: file.into(), what, value, allowed: format!("at most {MOST_KEPT}") }
}

/// Returns an outline counter-clockwise, the first corner once, with at most `most` corners; `None` if it encloses next to nothing.
fn closed(mut corners: Vec<DVec2>, most: usize) -> Option<Vec<DVec2>> {
    corners.dedup_by(|a, b| a.distance(*b) < 0.01);
    if corners.len() > 1 && corners.first().zip(corners.last()).is_some_and(|(a, b)| a.distance(*b) < 0.01) {
        corners.pop();
    }
    let mut outline = thinned(corners, most);
    let doubled_m2 = doubled_area_m2(&outline);
    if outline.len() < 3 || doubled_m2.abs() < 2.0 * LEAST_M2 {
        return None;
    }
    if doubled_m2 < 0.0 {
        outline.reverse();
    }
    Some(outline)
}

/// Returns every second, third, ... corner of an outline with more than `most`.
fn thinned(mut outline: Vec<DVec2>, most: usize) -> Vec<DVec2> {
    let every = outline.len().div_ceil(most).max(1);
    let mut number = 0..;
    outline.retain(|_| number.next().is_some_and(|k: usize| k.is_multiple_of(every)));
    outline
}

/// Returns points along a line, [`ROW_M`] apart, at most one more than a file may have.
fn along(line: &[DVec2]) -> impl Iterator<Item = DVec2> {
    let on_pair = |pair: &[DVec2]| {
        let [from, to] = [pair[0], pair[1]];
        let count = (from.distance(to) / ROW_M).floor().clamp(1.0, MOST_KEPT as f64) as usize;
        (0..count).map(move |k| from.lerp(to, k as f64 / count as f64))
    };
    line.windows(2).flat_map(on_pair).chain(line.last().copied()).take(MOST_KEPT + 1)
}

/// Returns twice the area within an outline, m²; above 0 if it is counter-clockwise.
fn doubled_area_m2(outline: &[DVec2]) -> f64 {
    let next = |k: usize| outline[(k + 1) % outline.len()];
    (0..outline.len()).map(|k| outline[k].perp_dot(next(k))).sum()
}

fn point(text: &str) -> Option<DVec2> {
    let numbers: Vec<f64> = text.split(',').map(str::parse).collect::<Result<_, _>>().ok()?;
    let point = DVec2::new(*numbers.first()?, *numbers.get(1)?);
    // Not by the larger of both, which ignores NaN.
    point.to_array().iter().all(|number| number.abs() <= 1e7).then_some(point)
}

#[cfg(test)]
mod tests;
