//! Attributes of a net.xml. In: an element and an attribute's name. Out: the checked value, or an error with file, line, element and
//! allowed values. Metres, m/s.

use super::{
    MapError,
    limits::{FURTHEST_M, MOST_POINTS},
    xml_tree::Element,
};
use glam::{DVec3, dvec3};
use std::{ops::RangeInclusive, path::Path};

/// Reader of attribute values; errors name its file.
pub(super) struct NetReader<'a> {
    pub file: &'a Path,
}

/// Returns a value in quotes; a long one is cut after 100 characters.
fn quoted(value: &str) -> String {
    const MOST: usize = 100;
    match value.char_indices().nth(MOST) {
        Some((end, _)) => format!("\"{}...\" ({} characters)", &value[..end], value.chars().count()),
        None => format!("\"{value}\""),
    }
}

impl NetReader<'_> {
    pub fn value(&self, node: Element, attribute: &str, allowed: &'static str) -> MapError {
        let tag = node.name();
        let element = match (node.attribute("id"), node.attribute("from"), node.attribute("to")) {
            (Some(id), _, _) => format!("{tag} \"{id}\""),
            (None, Some(from), Some(to)) => format!("{tag} from \"{from}\" to \"{to}\""),
            _ => tag.to_owned(),
        };
        let value = node.attribute(attribute).map_or("absent".to_owned(), quoted);
        let (file, line, attribute) = (self.file.into(), node.line(), attribute.to_owned());
        MapError::Value { file, line, element, attribute, value, allowed }
    }

    pub fn text<'n>(&self, node: Element<'n>, attribute: &str) -> Result<&'n str, MapError> {
        node.attribute(attribute).ok_or_else(|| self.value(node, attribute, "a name"))
    }

    /// Parses a number within `limits`; `allowed` describes them in the error.
    pub fn within(
        &self,
        node: Element,
        attribute: &str,
        limits: &RangeInclusive<f64>,
        allowed: &'static str,
    ) -> Result<f64, MapError> {
        let number = node.attribute(attribute).and_then(|text| text.trim().parse().ok());
        number.filter(|x| limits.contains(x)).ok_or_else(|| self.value(node, attribute, allowed))
    }

    /// Parses as [`NetReader::within`]; `None` if the attribute is absent.
    pub fn within_if_any(
        &self,
        node: Element,
        attribute: &str,
        limits: &RangeInclusive<f64>,
        allowed: &'static str,
    ) -> Result<Option<f64>, MapError> {
        node.has_attribute(attribute).then(|| self.within(node, attribute, limits, allowed)).transpose()
    }

    pub fn coordinate(&self, node: Element, attribute: &str) -> Result<f64, MapError> {
        self.within(node, attribute, &(-FURTHEST_M..=FURTHEST_M), "a number from -1e7 to 1e7 m")
    }

    /// Parses the attribute `shape`, of at least `least` points.
    pub fn shape(&self, node: Element, least: usize) -> Result<Vec<DVec3>, MapError> {
        self.shape_of(node, "shape", least)
    }

    /// Parses an attribute of at least `least` points.
    pub fn shape_of(&self, node: Element, attribute: &str, least: usize) -> Result<Vec<DVec3>, MapError> {
        let points = node.attribute(attribute).and_then(parse_shape);
        points.filter(|points| points.len() >= least).ok_or_else(|| {
            self.value(
                node,
                attribute,
                "two or more different points \"x,y\" or \"x,y,z\" of numbers from -1e7 to 1e7, in metres, at most 20000",
            )
        })
    }

    /// Parses a boolean as SUMO writes it; an absent attribute is `absent`.
    pub fn truth(&self, node: Element, attribute: &str, absent: bool) -> Result<bool, MapError> {
        match node.attribute(attribute).map(str::trim) {
            None => Ok(absent),
            Some("1" | "true" | "True" | "yes" | "on") => Ok(true),
            Some("0" | "false" | "False" | "no" | "off" | "-" | "") => Ok(false),
            Some(_) => Err(self.value(node, attribute, "0 or 1")),
        }
    }
}

/// Parses the points of a shape; `None` if there are too many, or a number is malformed or out of range. A point within a micrometre of
/// the previous one on the ground is moved onto it: the square of a smaller distance may underflow to zero.
fn parse_shape(text: &str) -> Option<Vec<DVec3>> {
    const SAME_M: f64 = 1e-6;
    let mut points: Vec<DVec3> = Vec::new();
    for point in text.split_whitespace() {
        let mut numbers = point.split(',').map(|x| x.parse().ok().filter(|x: &f64| x.abs() <= FURTHEST_M));
        let (x, y, z) = (numbers.next()??, numbers.next()??, numbers.next());
        if numbers.next().is_some() || z == Some(None) || points.len() == MOST_POINTS {
            return None;
        }
        let point = dvec3(x, y, z.flatten().unwrap_or(0.0));
        let same = points.last().filter(|last| last.truncate().distance(point.truncate()) < SAME_M);
        points.push(same.map_or(point, |last| last.truncate().extend(point.z)));
    }
    Some(points)
}
