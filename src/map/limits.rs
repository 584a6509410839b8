//! How large a network may be. In: the text of a `net.xml`, before it is parsed. Out: the parsed document, or which limit
//! it breaks. All limits lie far above a road that is worth driving, and below what fills 256 MiB: 34 MB of text, 94 of attributes, 70 of
//! tags and what is between them, 70 for the network that is made of them.

use super::MapError;
use crate::foreign::guarded;
use roxmltree::{Document, ParsingOptions};
use std::{ops::RangeInclusive, path::Path};

/// The most that a network or a circuit may hold, bytes: a town of 20,000 lanes has 30 MB.
pub const MOST_BYTES: u64 = 32 << 20;
/// The most that a file for netconvert may hold, bytes: a town's extract of OpenStreetMap.
pub const MOST_IMPORT_BYTES: u64 = 256 << 20;
/// The most tags, opening and closing: 88 bytes each once they are read.
const MOST_TAGS: usize = 400_000;
/// The most attributes: 72 bytes each once they are read. A grid of 9,800 edges with all insides of its junctions has 1.23 million.
const MOST_ATTRIBUTES: usize = 1_300_000;
/// The most attributes of one element: the parser compares each with each.
const MOST_ATTRIBUTES_OF_ONE: usize = 256;
/// The most namespaces: the parser keeps them anew for each element below.
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
pub const WIDTH_M: RangeInclusive<f64> = 0.1..=100.0;
/// The longest closed route, metres, as declared and as drawn: an hour at 100 km/h.
pub const LONGEST_ROUTE_M: f64 = 100_000.0;
/// The widest hole between two lanes of a route that is bridged, metres: a motorway junction without its inside.
pub const WIDEST_GAP_M: f64 = 500.0;

/// Limits in words, for help texts.
pub const IN_WORDS: &str = "a net.xml has at most 32 MiB, 400000 tags, a million points, coordinates up to 1e7 m, lanes \
                            of 0.001 to 100000 m and 0.01 to 500 m/s, and a closed route of at most 100 km";

/// Parses a text that keeps the limits.
pub(super) fn parse<'text>(file: &Path, text: &'text str) -> Result<Document<'text>, MapError> {
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
    let bytes = text.as_bytes();
    // The parser makes room for as many as these before it reads.
    limit("the number of tags", bytes.iter().filter(|byte| **byte == b'<').count(), MOST_TAGS)?;
    limit("the number of attributes", bytes.iter().filter(|byte| **byte == b'=').count(), MOST_ATTRIBUTES)?;
    limit("the number of namespaces", text.matches("xmlns").count(), MOST_NAMESPACES)?;
    let of_one = bytes.split(|byte| *byte == b'<').map(|tag| tag.iter().filter(|byte| **byte == b'=').count());
    limit("the number of attributes of one element", of_one.max().unwrap_or(0), MOST_ATTRIBUTES_OF_ONE)?;
    let not_xml = |line, column, message| MapError::NotXml { file: file.into(), line, column, message };
    let options = ParsingOptions { nodes_limit: 2 * MOST_TAGS as u32, ..ParsingOptions::default() };
    guarded(|| Document::parse_with_options(text, options))
        .map_err(|panic| not_xml(1, 1, panic))?
        .map_err(|error| not_xml(error.pos().row, error.pos().col, error.to_string()))
}
