//! How large a network may be. In: the text of a `net.xml`, before it is parsed. Out: its tree, or which limit it breaks. All limits
//! lie far above a road that is worth driving, and below what fills 256 MiB: 50 MB of text, 30 of attributes, 12 of elements, and some
//! 100 for the network that is made of them with what its names stand for. 10,000 edges of two lanes with signals take 171 MB in
//! all for 40 MB of text (`tests/fuzz/large_network.rs`).

use super::{
    MapError,
    xml_tree::{BYTE_ORDER_MARK, XmlTree, line_and_column},
};
use crate::foreign::guarded;
use std::{ops::RangeInclusive, path::Path};

/// The most that a network or a circuit may hold, bytes: 10,000 edges of two lanes with signals have 40 MB.
pub const MOST_BYTES: u64 = 48 << 20;
/// The most that a file for netconvert may hold, bytes: a town's extract of OpenStreetMap.
pub const MOST_IMPORT_BYTES: u64 = 256 << 20;
/// The most tags, opening and closing: 16 bytes an element once they are read. 10,000 edges of two lanes have 430,000.
const MOST_TAGS: usize = 600_000;
/// The most attributes: 12 bytes each once they are read. 10,000 edges of two lanes have 1.9 million.
const MOST_ATTRIBUTES: usize = 2_500_000;
/// The most attributes of one element: each is compared with each.
const MOST_ATTRIBUTES_OF_ONE: usize = 256;
/// The most namespaces: each name with a prefix is looked for among them.
const MOST_NAMESPACES: usize = 16;
/// The most points of one shape, and of all together.
pub const MOST_POINTS: usize = 20_000;
/// See [`MOST_POINTS`].
pub const MOST_POINTS_IN_ALL: usize = 1_000_000;
/// The most lanes of one edge.
pub const MOST_LANES_OF_ONE: usize = 32;
/// Furthest coordinate from the origin, metres: the way from the equator to the pole, so that national grids fit.
pub const FURTHEST_M: f64 = 1e7;
/// Declared lengths of lanes, metres: netconvert's shortest is 0.1.
pub const LENGTH_M: RangeInclusive<f64> = 0.001..=100_000.0;
/// Speed limits, m/s.
pub const SPEED_MPS: RangeInclusive<f64> = 0.01..=500.0;
/// Widths of lanes, metres.
pub const WIDTH_M: RangeInclusive<f64> = 0.001..=100.0;
/// The longest closed route, metres, as declared and as drawn: an hour at 100 km/h.
pub const LONGEST_ROUTE_M: f64 = 100_000.0;
/// The widest hole between two lanes of a route that is bridged, metres: a motorway junction without its inside.
pub const WIDEST_GAP_M: f64 = 500.0;

/// Limits in words, for help texts.
pub const IN_WORDS: &str = "a net.xml has at most 48 MiB, 600000 tags, a million points, coordinates up to 1e7 m, lanes \
                            of 0.001 to 100000 m and 0.01 to 500 m/s, and a closed route of at most 100 km";

/// Parses a text that keeps the limits.
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
