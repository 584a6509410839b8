//! Writes a closed single-lane road as a SUMO `net.xml`, without netconvert. In: the edges in driving order. Out: the text. Each edge
//! ends where the next begins, in a junction without extent. There are no internal lanes, so the declared lengths add up to the lap. Each
//! edge repeats its lane's shape: SUMO uses lanes, its tools read edges. Metres and m/s have six decimals: 1 um, so that headings of 1 m
//! chords are accurate to 1 urad.

use super::MapError;
use crate::private;
use glam::DVec2;
use std::{fmt::Write, path::Path};

/// Edge of a closed road with one lane.
#[derive(Clone, Debug, PartialEq)]
pub struct RoadEdge {
    /// Declared length of edge and lane, metres.
    pub length_m: f64,
    /// Speed limit, m/s.
    pub speed_limit_mps: f64,
    /// Width of the lane, metres.
    pub width_m: f64,
    /// Centre line; its last point is the first of the next edge.
    pub shape: Vec<DVec2>,
}

/// Returns the text of a network in which edge `e0` leads from junction `n0` to `n1`, and the last edge back to `n0`.
pub fn net_xml(comment: &str, edges: &[RoadEdge]) -> String {
    let mut low = DVec2::INFINITY;
    let mut high = DVec2::NEG_INFINITY;
    for point in edges.iter().flat_map(|edge| &edge.shape) {
        (low, high) = (low.min(*point), high.max(*point));
    }
    let bounds = format!("{},{}", point_text(low), point_text(high));
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- {comment} -->\n<net version=\"1.20\" \
         junctionCornerDetail=\"5\" limitTurnSpeed=\"5.50\" avoidOverlap=\"0\">\n    <location \
         netOffset=\"0.00,0.00\" convBoundary=\"{bounds}\" origBoundary=\"{bounds}\" projParameter=\"!\"/>\n"
    );
    let n = edges.len();
    for (k, edge) in edges.iter().enumerate() {
        let shape = edge.shape.iter().map(|point| point_text(*point)).collect::<Vec<_>>().join(" ");
        let (length, speed, width) = (number(edge.length_m), number(edge.speed_limit_mps), number(edge.width_m));
        let next = (k + 1) % n;
        push(
            &mut text,
            format_args!(
                "    <edge id=\"e{k}\" from=\"n{k}\" to=\"n{next}\" priority=\"-1\" spreadType=\"center\" length=\"{length}\" \
                 shape=\"{shape}\">\n        <lane id=\"e{k}_0\" index=\"0\" speed=\"{speed}\" length=\"{length}\" \
                 width=\"{width}\" shape=\"{shape}\"/>\n    </edge>\n"
            ),
        );
    }
    for (k, edge) in edges.iter().enumerate() {
        let before = (k + n - 1) % n;
        let (at, ahead) = (edge.shape[0], edge.shape[1]);
        // The junction is a line across the lane.
        let half_across = (ahead - at).normalize().perp() * (edge.width_m / 2.0);
        let (x, y) = (number(at.x), number(at.y));
        let shape = format!("{} {}", point_text(at - half_across), point_text(at + half_across));
        push(
            &mut text,
            format_args!(
                "    <junction id=\"n{k}\" type=\"priority\" x=\"{x}\" y=\"{y}\" incLanes=\"e{before}_0\" intLanes=\"\" \
                 shape=\"{shape}\">\n        <request index=\"0\" response=\"0\" foes=\"0\" cont=\"0\"/>\n    \
                 </junction>\n"
            ),
        );
    }
    for k in 0..n {
        let next = (k + 1) % n;
        push(
            &mut text,
            format_args!(
                "    <connection from=\"e{k}\" to=\"e{next}\" fromLane=\"0\" toLane=\"0\" dir=\"s\" state=\"M\"/>\n"
            ),
        );
    }
    text + "</net>\n"
}

/// Creates the folder with `net.xml` and `map.toml`.
pub(super) fn write_folder(folder: &Path, net: &str, title: &str, description: &str) -> Result<(), MapError> {
    if folder.exists() {
        return Err(MapError::Exists { folder: folder.into() });
    }
    let failed = |source| MapError::Io { file: folder.into(), source };
    private::folder(folder).map_err(failed)?;
    private::replace(&folder.join("net.xml"), net.as_bytes()).map_err(failed)?;
    let quoted = |text: &str| toml::Value::String(text.into()).to_string();
    let map_file = format!("title = {}\ndescription = {}\n", quoted(title), quoted(description));
    private::replace(&folder.join("map.toml"), map_file.as_bytes()).map_err(failed)
}

fn push(text: &mut String, arguments: std::fmt::Arguments) {
    text.write_fmt(arguments).expect("a String takes all text");
}

fn point_text(point: DVec2) -> String {
    format!("{},{}", number(point.x), number(point.y))
}

/// Formats with six decimals; never `-0.000000`, whose sign would depend on the last bit of a sine.
fn number(x: f64) -> String {
    let text = format!("{x:.6}");
    if text.trim_start_matches(['-', '0', '.']).is_empty() { "0.000000".into() } else { text }
}
