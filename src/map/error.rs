//! Errors of maps, with file, line, value and remedy.

use super::circuit_fault::CircuitFault;
use crate::toml_text::did_you_mean_file;
use std::path::PathBuf;

/// Error of reading or writing a map.
#[derive(Debug, thiserror::Error)]
pub enum MapError {
    /// No folder for the user's own maps.
    #[error("there is no home folder to keep the map in\n  remedy: set HOME or XDG_DATA_HOME")]
    NoHome,
    /// Missing file or folder.
    #[error("{}: there is no such file{}\n  remedy: name a map of `codrive map list`, or the path of a SUMO net.xml", file.display(), did_you_mean_file(file))]
    Missing {
        /// File or folder that was not found.
        file: PathBuf,
    },
    /// Failure of reading or writing.
    #[error("{}: {source}", file.display())]
    Io {
        /// File or folder that failed.
        file: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// Text that is not XML.
    #[error("{}:{line}:{column}: this is not XML: {message}\n  remedy: export the network again with netconvert", file.display())]
    NotXml {
        file: PathBuf,
        /// Line number, counted from 1.
        line: u32,
        /// Column number, counted from 1.
        column: u32,
        /// Message of the parser.
        message: String,
    },
    /// XML that is not a SUMO network.
    #[error("{}:{line}: the root element is <{found}>, a SUMO network begins with <net>\n  remedy: {}", file.display(), remedy_for_root(found))]
    NotANet {
        file: PathBuf,
        /// Line number, counted from 1.
        line: u32,
        /// Name of the root element.
        found: String,
    },
    /// Size beyond a limit.
    #[error("{}: {what} is {value}; allowed: {allowed}", file.display())]
    Limit {
        file: PathBuf,
        /// Quantity that exceeds its limit.
        what: String,
        /// Value found in the file.
        value: String,
        /// Largest value that is allowed.
        allowed: String,
    },
    /// Attribute that is absent or invalid.
    #[error("{}:{line}: {element}: {attribute} is {value}; allowed: {allowed}", file.display())]
    Value {
        file: PathBuf,
        /// Line number, counted from 1.
        line: u32,
        /// Element with its id, for example `lane "e0_0"`.
        element: String,
        /// Name of the attribute.
        attribute: String,
        /// Value in quotes, or `absent`.
        value: String,
        /// Values that are allowed.
        allowed: &'static str,
    },
    /// Fault of a network in the format of an old version of SUMO.
    #[error("{problem}\n  remedy: the network has the format {version}; `codrive map import {}` rebuilds it", file.display())]
    Outdated {
        file: PathBuf,
        /// Version of the format, as the file names it.
        version: String,
        /// Fault that was found first.
        problem: Box<MapError>,
    },
    /// Part of a file that must not reach SUMO.
    #[error("{}:{line}: {element}: {problem}", file.display())]
    Refused {
        file: PathBuf,
        /// Line number, counted from 1.
        line: u32,
        /// Element with its id, for example `edgeData "x"`.
        element: String,
        /// Reason, allowed content and remedy.
        problem: String,
    },
    /// Network without a closed chain of lanes for passenger cars.
    #[error("{}: no closed route: {detail}\n  remedy: join the last edge to the first by a connection, or name the edges as `route = [..]` in map.toml", file.display())]
    NoRoute {
        file: PathBuf,
        /// Place where the search ended.
        detail: String,
    },
    /// Network without a chain of lanes for passenger cars that is long enough to drive.
    #[error("{}: no road for cars: {detail}\n  remedy: give lanes permission for passenger cars (allow=\"passenger\") and connections to each other, or import another part of the map", file.display())]
    NoPath {
        file: PathBuf,
        /// Description of the lanes that exist instead.
        detail: String,
    },
    /// Empty file that was to be imported.
    #[error("{}: the file is empty\n  remedy: export or download it again", file.display())]
    Empty {
        /// File that was to be imported.
        file: PathBuf,
    },
    /// File that refers to other files, which netconvert would read.
    #[error("{}:{line}: {reference}\n  remedy: export the file again without this, as UTF-8", file.display())]
    Reference {
        file: PathBuf,
        /// Line number, counted from 1.
        line: u32,
        /// Reference, with the reason for the refusal.
        reference: &'static str,
    },
    /// Unusable result of netconvert.
    #[error("{}: netconvert converts this file, but the network cannot be used: {problem}\n  remedy: correct the named part of the file, or import another part of the map", file.display())]
    Converted {
        /// File that was to be imported.
        file: PathBuf,
        /// Fault of the converted network.
        problem: Box<MapError>,
    },
    /// Network, imported or made by netconvert, beyond the size limit.
    #[error("{}: {what} {size}; allowed: at most {allowed}\n  remedy: import a part of the map; cut it out with osmium extract (OpenStreetMap) or netconvert --keep-edges.in-boundary X1,Y1,X2,Y2 (other formats)", file.display())]
    NetworkTooLarge {
        /// File that was to be imported.
        file: PathBuf,
        /// Subject of the message, followed by the size.
        what: &'static str,
        /// Size of the network.
        size: String,
        /// Largest size that is allowed.
        allowed: String,
    },
    /// Edge in the route of `map.toml` that the network lacks, or that is named twice.
    #[error("{}: route: edge \"{edge}\" {problem}{near}; edges of this network: {known}", file.display())]
    RouteEdge {
        /// File of the network.
        file: PathBuf,
        /// Id of the edge.
        edge: String,
        /// Fault of the edge.
        problem: &'static str,
        /// Question with the nearest edge that exists; empty if none is near.
        near: String,
        /// List of the edges that exist.
        known: String,
    },
    /// Edge in a path that cannot be driven.
    #[error("{}: path: edge \"{edge}\" {problem}{near}; edges that cars may drive on: {known}\n  remedy: name ids of such edges in the order in which they are driven", file.display())]
    PathEdge {
        /// File of the network.
        file: PathBuf,
        /// Id of the edge.
        edge: String,
        /// Fault of the edge.
        problem: &'static str,
        /// Question with the nearest edge that exists; empty if none is near.
        near: String,
        /// Edges that can be named.
        known: String,
    },
    /// Two edges of a path that do not follow each other.
    #[error("{}: path: edge \"{from}\" does not lead to edge \"{to}\" for cars; it leads to: {onwards}\n  remedy: name every edge on the way, each connected to the next, or put ... between the two for the quickest way", file.display())]
    PathGap {
        /// File of the network.
        file: PathBuf,
        /// Id of the first edge.
        from: String,
        /// Id of the second edge.
        to: String,
        /// Edges that the first edge leads to.
        onwards: String,
    },
    /// `...` in a path that is not between two places.
    #[error("{}: path: `...` stands between two places, for the quickest way from one to the other\n  remedy: for example \"A0B0 ... C2C1\"", file.display())]
    PathJoint {
        /// File of the network.
        file: PathBuf,
    },
    /// Point of a path that is on no street.
    #[error("{}: path: no street for cars is within {reach_m} m of the point {point}\n  remedy: X,Y in metres in the frame of the network, near a street", file.display())]
    PathPoint {
        /// File of the network.
        file: PathBuf,
        /// Text `X,Y` of the point.
        point: String,
        /// Largest distance of the point from a street, metres.
        reach_m: f64,
    },
    /// Two places of a path without a way between them.
    #[error("{}: path: no way for cars leads from edge \"{from}\" to edge \"{to}\"", file.display())]
    NoWay {
        /// File of the network.
        file: PathBuf,
        /// Id of the first edge.
        from: String,
        /// Id of the second edge.
        to: String,
    },
    /// Path without an edge.
    #[error("{}: the path names no edge\n  remedy: name the edges to drive along, the first one first", file.display())]
    EmptyPath {
        /// File of the network.
        file: PathBuf,
    },
    /// Start of the ego beyond the end of its path.
    #[error("{}: the ego starts {start_m} m along its path; allowed: less than {length_m:.1} m, the path's length\n  remedy: set a smaller path_start_m, or name more edges in path", file.display())]
    PathStart {
        /// File of the network.
        file: PathBuf,
        /// Requested start, metres from the path's start.
        start_m: f64,
        /// Length of the path, metres.
        length_m: f64,
    },
    /// Unknown name of a map.
    #[error(
        "there is no map \"{name}\"{near}; maps here: {known}\n  looked in: {looked}\n  remedy: name one of these, or the path of a SUMO net.xml; `codrive map ring` and `codrive map import` make new ones"
    )]
    UnknownMap {
        /// Name that was requested.
        name: String,
        /// Question with the nearest name that exists; empty if none is near.
        near: String,
        /// List of the names that exist.
        known: String,
        /// Folders in which maps are looked for.
        looked: String,
    },
    /// Invalid TOML file: file, line, column and fault.
    #[error("{0}")]
    Toml(String),
    /// Number for a new map that is out of range.
    #[error("{what} is {value}; allowed: {allowed}")]
    Parameter {
        /// Name of the number.
        what: &'static str,
        /// Value that was given.
        value: String,
        /// Values that are allowed.
        allowed: String,
    },
    /// Pieces of a circuit that do not make a road.
    #[error("{}: {problem}", file.display())]
    Circuit {
        /// File of the circuit.
        file: PathBuf,
        /// Fault, with a remedy.
        problem: CircuitFault,
    },
    /// Name of a map that exists already.
    #[error("{}: this map exists already\n  remedy: choose another name, or remove the folder first", folder.display())]
    Exists {
        /// Folder of the existing map.
        folder: PathBuf,
    },
    /// Missing netconvert, SUMO's converter.
    #[error("netconvert is not at {}\n  remedy: run scripts/setup, which puts SUMO into .sumo/", program.display())]
    NetconvertAbsent {
        /// Expected path of the program.
        program: PathBuf,
    },
    /// Import that the user ended.
    #[error("{}: the import was stopped; no file was kept", file.display())]
    Interrupted {
        /// File that was to be imported.
        file: PathBuf,
    },
    /// File that netconvert did not accept.
    #[error("{}: netconvert failed: {message}", file.display())]
    Netconvert {
        /// File that was to be converted.
        file: PathBuf,
        /// Error messages of netconvert, one a line.
        message: String,
    },
    /// Conversion beyond its limit of time or memory.
    #[error("{}: netconvert failed: {what}\n  allowed: {seconds} s (--time-limit) and {memory_mib} MiB (--memory-limit)", file.display())]
    NetconvertLimit {
        /// File that was to be converted.
        file: PathBuf,
        /// Limit that was exceeded, as text.
        what: String,
        /// Time limit of the conversion, seconds.
        seconds: u64,
        /// Memory limit of the conversion, MiB.
        memory_mib: u64,
    },
}

/// Returns the remedy for a document that is not a network, by the name of its root element.
fn remedy_for_root(found: &str) -> &'static str {
    match found {
        "configuration" | "sumoConfiguration" => {
            "this is a configuration of SUMO; drive it with --scenario, or name the network that stands in its <net-file>"
        }
        "routes" | "additional" => {
            "this is a demand of SUMO; name it in a scenario, as files = [\"...\"] under [demand]"
        }
        _ => "convert it with `codrive map import`",
    }
}
