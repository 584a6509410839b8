//! Writes a single-lane road, closed or open, as a SUMO `net.xml`, without netconvert. In: the edges in driving order. Out: the text. Each
//! edge ends where the next begins, in a junction without extent. There are no internal lanes, so the declared lengths add up. Each
//! edge repeats its lane's shape: SUMO uses lanes, its tools read edges. Metres and m/s have six decimals: 1 um, so that headings of 1 m
//! chords are accurate to 1 urad.

use super::MapError;
use crate::private;
use glam::DVec2;
use std::{fmt::Write, path::Path};

/// Edge of a road with one lane.
#[derive(Clone, Debug, PartialEq)]
pub struct RoadEdge {
    /// Declared length of edge and lane, metres.
    pub length_m: f64,
    /// Speed limit, m/s.
    pub speed_limit_mps: f64,
    /// Width of the lane, metres.
    pub width_m: f64,
    /// Centre line; its last point is the first of the next edge, if there is one.
    pub shape: Vec<DVec2>,
}

/// Returns the text of a network in which edge `e0` leads from junction `n0` to `n1`, and the last edge back to `n0`.
pub fn net_xml(comment: &str, edges: &[RoadEdge]) -> String {
    road_xml(comment, edges, true)
}

/// Returns the text of a network in which edge `e0` leads from junction `n0` to `n1`, and the last edge to a junction of its own.
pub fn open_net_xml(comment: &str, edges: &[RoadEdge]) -> String {
    road_xml(comment, edges, false)
}

fn road_xml(comment: &str, edges: &[RoadEdge], is_closed: bool) -> String {
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
        let next = if is_closed { (k + 1) % n } else { k + 1 };
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
        if k == 0 && !is_closed {
            push_end(&mut text, 0, "", [edge.shape[0], edge.shape[1]], edge.width_m);
            continue;
        }
        let before = (k + n - 1) % n;
        let (x, y, shape) = across([edge.shape[0], edge.shape[1]], edge.width_m);
        push(
            &mut text,
            format_args!(
                "    <junction id=\"n{k}\" type=\"priority\" x=\"{x}\" y=\"{y}\" incLanes=\"e{before}_0\" intLanes=\"\" \
                 shape=\"{shape}\">\n        <request index=\"0\" response=\"0\" foes=\"0\" cont=\"0\"/>\n    \
                 </junction>\n"
            ),
        );
    }
    if let (Some(RoadEdge { shape, width_m, .. }), false) = (edges.last(), is_closed) {
        let [before, end] = [shape[shape.len() - 2], shape[shape.len() - 1]];
        push_end(&mut text, n, &format!("e{}_0", n - 1), [end, end + (end - before)], *width_m);
    }
    for k in 0..if is_closed { n } else { n - 1 } {
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

/// Returns the coordinates of a junction, and its shape: a line across the lane that goes from the first of two points to the second.
fn across([at, ahead]: [DVec2; 2], width_m: f64) -> (String, String, String) {
    let half_across = (ahead - at).normalize().perp() * (width_m / 2.0);
    let shape = format!("{} {}", point_text(at - half_across), point_text(at + half_across));
    (number(at.x), number(at.y), shape)
}

/// Adds the junction at an end of an open road.
fn push_end(text: &mut String, k: usize, lanes: &str, points: [DVec2; 2], width_m: f64) {
    let (x, y, shape) = across(points, width_m);
    push(
        text,
        format_args!(
            "    <junction id=\"n{k}\" type=\"dead_end\" x=\"{x}\" y=\"{y}\" incLanes=\"{lanes}\" intLanes=\"\" \
             shape=\"{shape}\"/>\n"
        ),
    );
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
