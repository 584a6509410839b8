//! Size limits of networks. In: the text of a `net.xml`, before it is parsed. Out: its tree, or the limit that it exceeds. All limits lie
//! far above any road worth driving, and keep memory below 256 MiB: 50 MB for the text, 30 for attributes, 12 for elements, and about 100
//! for the network with its names. 10,000 edges of two lanes with signals take 171 MB in all for 40 MB of text
//! (`tests/fuzz/large_network.rs`).

use super::{
    MapError,
    xml_tree::{BYTE_ORDER_MARK, XmlTree, line_and_column},
};
use crate::foreign::guarded;
use std::{ops::RangeInclusive, path::Path};

/// Largest size of a network or circuit file, bytes: 10,000 edges of two lanes with signals have 40 MB.
pub const MOST_BYTES: u64 = 48 << 20;
/// Largest size of a file for netconvert, bytes: enough for a town's extract of OpenStreetMap.
pub const MOST_IMPORT_BYTES: u64 = 256 << 20;
/// Largest number of tags, opening and closing: an element takes 16 bytes once read. 10,000 edges of two lanes have 430,000.
const MOST_TAGS: usize = 600_000;
/// Largest number of attributes: each takes 12 bytes once read. 10,000 edges of two lanes have 1.9 million.
const MOST_ATTRIBUTES: usize = 2_500_000;
/// Largest number of attributes of one element: their names are compared pairwise.
const MOST_ATTRIBUTES_OF_ONE: usize = 256;
/// Largest number of namespaces: each prefixed name is looked up among them linearly.
const MOST_NAMESPACES: usize = 16;
/// Largest number of points of one shape.
pub const MOST_POINTS: usize = 20_000;
/// Largest number of points of all shapes together.
pub const MOST_POINTS_IN_ALL: usize = 1_000_000;
/// Largest number of lanes of one edge.
pub const MOST_LANES_OF_ONE: usize = 32;
/// Largest absolute coordinate, metres: the distance from the equator to a pole, so that national grids fit.
pub const FURTHEST_M: f64 = 1e7;
/// Range of declared lane lengths, metres: netconvert's shortest is 0.1.
pub const LENGTH_M: RangeInclusive<f64> = 0.001..=100_000.0;
/// Range of speed limits, m/s.
pub const SPEED_MPS: RangeInclusive<f64> = 0.01..=500.0;
/// Range of lane widths, metres.
pub const WIDTH_M: RangeInclusive<f64> = 0.001..=100.0;
/// Longest closed route, metres, as declared and as drawn: an hour at 100 km/h.
pub const LONGEST_ROUTE_M: f64 = 100_000.0;
/// Widest gap between two lanes of a route that is bridged, metres: a motorway junction without internal lanes.
pub const WIDEST_GAP_M: f64 = 500.0;

/// Limits as text for the command line's help.
pub const IN_WORDS: &str = "a net.xml has at most 48 MiB, 600000 tags, a million points, coordinates up to 1e7 m, lanes \
                            of 0.001 to 100000 m and 0.01 to 500 m/s, and a closed route of at most 100 km";

/// Parses a text after checking its size against the limits.
pub(super) fn parse<'text>(file: &Path, text: &'text str) -> Result<XmlTree<'text>, MapError> {
    let limit = |what: &'static str, found: usize, most: usize| {
        if found <= most {
            return Ok(());
        }
        Err(MapError::Limit {
            file: file.into(),
            what: what.into(),
            value: found.to_string(),
            allowed: format!("at most {most}"),
        })
    };
    let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(text);
    let bytes = text.as_bytes();
    limit("the number of tags", bytes.iter().filter(|byte| **byte == b'<').count(), MOST_TAGS)?;
    limit("the number of attributes", bytes.iter().filter(|byte| **byte == b'=').count(), MOST_ATTRIBUTES)?;
    limit("the number of namespaces", text.matches("xmlns").count(), MOST_NAMESPACES)?;
    let of_one = bytes.split(|byte| *byte == b'<').map(|tag| tag.iter().filter(|byte| **byte == b'=').count());
    limit("the number of attributes of one element", of_one.max().unwrap_or(0), MOST_ATTRIBUTES_OF_ONE)?;
    let not_xml = |at: usize, message| {
        let (line, column) = line_and_column(text, at);
        MapError::NotXml { file: file.into(), line, column, message }
    };
    guarded(|| XmlTree::parse(text))
        .map_err(|panic| not_xml(0, panic))?
        .map_err(|fault| not_xml(fault.at, fault.message))
}
