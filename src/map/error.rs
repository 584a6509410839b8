//! What can be wrong with a map, each with file, line, value and remedy.

use super::circuit::CircuitFault;
use crate::toml_text::did_you_mean_file;
use std::path::PathBuf;

/// Why a map cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum MapError {
    /// The person's own maps have no place.
    #[error("there is no home folder to keep the map in\n  remedy: set HOME or XDG_DATA_HOME")]
    NoHome,
    /// The file or folder is not there.
    #[error("{}: there is no such file{}\n  remedy: name a map of `codrive map list`, or the path of a SUMO net.xml", file.display(), did_you_mean_file(file))]
    Missing {
        /// What was looked for.
        file: PathBuf,
    },
    /// Reading or writing failed.
    #[error("{}: {source}", file.display())]
    Io {
        /// Which file or folder.
        file: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// Not XML at all.
    #[error("{}:{line}:{column}: this is not XML: {message}\n  remedy: export the network again with netconvert", file.display())]
    NotXml {
        /// Which file.
        file: PathBuf,
        /// Line, from 1.
        line: u32,
        /// Column, from 1.
        column: u32,
        /// What the parser said.
        message: String,
    },
    /// XML, but not a SUMO network.
    #[error("{}:{line}: the root element is <{found}>, a SUMO network begins with <net>\n  remedy: convert it with `codrive map import`", file.display())]
    NotANet {
        /// Which file.
        file: PathBuf,
        /// Line, from 1.
        line: u32,
        /// Name of the root element.
        found: String,
    },
    /// Larger than what is read.
    #[error("{}: {what} is {value}; allowed: {allowed}", file.display())]
    Limit {
        /// Which file.
        file: PathBuf,
        /// Which size.
        what: String,
        /// Its value.
        value: String,
        /// What it may be.
        allowed: String,
    },
    /// An attribute is absent or cannot be used.
    #[error("{}:{line}: {element}: {attribute} is {value}; allowed: {allowed}", file.display())]
    Value {
        /// Which file.
        file: PathBuf,
        /// Line, from 1.
        line: u32,
        /// The element, for example `lane "e0_0"`.
        element: String,
        /// Which attribute.
        attribute: String,
        /// Its value in quotes, or `absent`.
        value: String,
        /// What it may be.
        allowed: &'static str,
    },
    /// A part that SUMO is not given.
    #[error("{}:{line}: {element}: {problem}", file.display())]
    Refused {
        /// Which file.
        file: PathBuf,
        /// Line, from 1.
        line: u32,
        /// The element, for example `edgeData "x"`.
        element: String,
        /// Why, what is allowed and the remedy.
        problem: String,
    },
    /// The network has no closed chain of lanes for passenger cars.
    #[error("{}: no closed route: {detail}\n  remedy: join the last edge to the first by a connection, or name the edges as `route = [..]` in map.toml", file.display())]
    NoRoute {
        /// Which file.
        file: PathBuf,
        /// Where the search ended.
        detail: String,
    },
    /// The network has no chain of lanes for passenger cars that is long enough to drive on.
    #[error("{}: no road for cars: {detail}\n  remedy: give lanes permission for passenger cars (allow=\"passenger\") and connections to each other, or import another part of the map", file.display())]
    NoPath {
        /// Which file.
        file: PathBuf,
        /// What there is instead.
        detail: String,
    },
    /// A file with nothing in it.
    #[error("{}: the file is empty\n  remedy: export or download it again", file.display())]
    Empty {
        /// Which file.
        file: PathBuf,
    },
    /// A file that refers to others, which netconvert would read.
    #[error("{}:{line}: {reference}\n  remedy: export it again without that, as UTF-8", file.display())]
    Reference {
        /// Which file.
        file: PathBuf,
        /// Line, from 1.
        line: u32,
        /// The reference, and why it is not read.
        reference: &'static str,
    },
    /// What netconvert made of a file cannot be used.
    #[error("{}: netconvert converts this file, but what it makes cannot be used: {problem}\n  remedy: mend the part of the file that this names, or import another part of the map", file.display())]
    Converted {
        /// What was to be imported.
        file: PathBuf,
        /// What is wrong with the network.
        problem: Box<MapError>,
    },
    /// The network, or what netconvert made of a file, is larger than what is read.
    #[error("{}: {what} {size}; allowed: at most {allowed}\n  remedy: import a part of it; cut that out first: osmium extract does it with OpenStreetMap's files, netconvert --keep-edges.in-boundary X1,Y1,X2,Y2 with others", file.display())]
    NetworkTooLarge {
        /// What was to be imported.
        file: PathBuf,
        /// Which network, in words that its size follows.
        what: &'static str,
        /// Its size.
        size: String,
        /// The most that is read.
        allowed: String,
    },
    /// The route of `map.toml` names an edge that the network does not have, or names one twice.
    #[error("{}: route: edge \"{edge}\" {problem}{near}; edges of this network: {known}", file.display())]
    RouteEdge {
        /// The network's file.
        file: PathBuf,
        /// Which edge.
        edge: String,
        /// What is wrong with it.
        problem: &'static str,
        /// The nearest edge that exists, as a question; empty where none is near.
        near: String,
        /// The edges that exist.
        known: String,
    },
    /// A path names an edge that cannot be driven along.
    #[error("{}: path: edge \"{edge}\" {problem}{near}; edges that cars may drive on: {known}\n  remedy: name ids of such edges in the order in which they are driven", file.display())]
    PathEdge {
        /// The network's file.
        file: PathBuf,
        /// Which edge.
        edge: String,
        /// What is wrong with it.
        problem: &'static str,
        /// The nearest edge that exists, as a question; empty where none is near.
        near: String,
        /// The edges that can be named.
        known: String,
    },
    /// Two edges of a path do not follow each other.
    #[error("{}: path: edge \"{from}\" does not lead to edge \"{to}\" for cars; it leads to: {onwards}\n  remedy: name every edge on the way, each connected to the next", file.display())]
    PathGap {
        /// The network's file.
        file: PathBuf,
        /// The first.
        from: String,
        /// The second.
        to: String,
        /// Where the first does lead.
        onwards: String,
    },
    /// A path without an edge.
    #[error("{}: the path names no edge\n  remedy: name the edges to drive along, the first one first", file.display())]
    EmptyPath {
        /// The network's file.
        file: PathBuf,
    },
    /// The start on a path is not on it.
    #[error("{}: the ego starts {start_m} m along its path; allowed: less than {length_m:.1} m, the path's length\n  remedy: a smaller path_start_m, or more edges in path", file.display())]
    PathStart {
        /// The network's file.
        file: PathBuf,
        /// Where it shall start, metres.
        start_m: f64,
        /// The path's length, metres.
        length_m: f64,
    },
    /// No map of this name.
    #[error(
        "there is no map \"{name}\"{near}; maps here: {known}\n  remedy: name one of these, or the path of a SUMO net.xml; `codrive map ring` and `codrive map import` make new ones"
    )]
    UnknownMap {
        /// What was asked for.
        name: String,
        /// The nearest name that exists, as a question; empty where none is near.
        near: String,
        /// The names that exist.
        known: String,
    },
    /// A TOML file that does not fit: file, line, column, what is wrong.
    #[error("{0}")]
    Toml(String),
    /// A number for a new map is out of range.
    #[error("{what} is {value}; allowed: {allowed}")]
    Parameter {
        /// Which number.
        what: &'static str,
        /// Its value.
        value: String,
        /// What it may be.
        allowed: String,
    },
    /// A circuit's pieces do not make a road.
    #[error("{}: {problem}", file.display())]
    Circuit {
        /// The circuit's file.
        file: PathBuf,
        /// What is wrong, and what would help.
        problem: CircuitFault,
    },
    /// A map of this name is there already.
    #[error("{}: this map exists already\n  remedy: choose another name or remove the folder first", folder.display())]
    Exists {
        /// Its folder.
        folder: PathBuf,
    },
    /// SUMO's converter is not on this machine.
    #[error("netconvert is not at {}\n  remedy: run scripts/setup, which puts SUMO into .sumo/", program.display())]
    NetconvertAbsent {
        /// Where it was expected.
        program: PathBuf,
    },
    /// Someone ended the import.
    #[error("{}: the import was ended; nothing is left of it", file.display())]
    Interrupted {
        /// What was to be imported.
        file: PathBuf,
    },
    /// SUMO's converter did not accept the file.
    #[error("{}: netconvert failed: {message}", file.display())]
    Netconvert {
        /// What was to be converted.
        file: PathBuf,
        /// Its own words.
        message: String,
    },
    /// SUMO's converter took more time or memory than it may have.
    #[error("{}: netconvert failed: {what}\n  it may take {seconds} s (--time-limit) and {memory_mib} MiB (--memory-limit)", file.display())]
    NetconvertLimit {
        /// What was to be converted.
        file: PathBuf,
        /// Which limit, in words.
        what: String,
        /// How long it may run, seconds.
        seconds: u64,
        /// How much memory it may have, MiB.
        memory_mib: u64,
    },
}
