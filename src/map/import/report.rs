//! Report on an imported file: the parts imported and dropped, netconvert's warnings, and the path to drive. In: the file and the network
//! made from it. Out: an [`ImportReport`], and its lines for people. Metres.

use super::{netconvert_attempts::MadeNetwork, source_format::SourceFormat, warnings::WarningKind};
use crate::{
    file::{open_regular, size_text},
    latin_letters::is_latin,
    map::{
        MapError,
        limits::MOST_IMPORT_BYTES,
        network::{EdgeKind, Network, NetworkCensus},
    },
    sumo_xml::{Dropped, document},
};
use std::{collections::BTreeSet, io::BufRead};

/// Number of kinds of warnings shown in the terminal; the file lists all.
const KINDS_TOLD: usize = 3;
/// Largest length of a warning's example, characters.
const EXAMPLE_CHARS: usize = 160;

/// Report on the import of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportReport {
    /// File name without its folder.
    pub file_name: String,
    /// Size of the file, bytes.
    pub bytes: u64,
    /// Format of the file.
    pub format: SourceFormat,
    /// Number of elements in the file by name; empty for a SUMO network.
    pub elements: Vec<(&'static str, usize)>,
    /// Description of the conversion.
    pub conversion: String,
    /// Reasons why finer options were rejected, one line each.
    pub finer: Vec<String>,
    /// Lines on the side of traffic, and on what was changed in the file before its conversion.
    pub notes: Vec<String>,
    /// Counts of the network's parts.
    pub census: NetworkCensus,
    /// Number of street lanes open to cars.
    pub car_lanes: usize,
    /// Number of different names of streets, and of those in letters that no sign can show.
    pub names: (usize, usize),
    /// Number of connections that are U-turns.
    pub u_turns: usize,
    /// Number of streets for cars with no lane before or after any of their lanes.
    pub alone: usize,
    /// Length of the default path, metres; its number of streets; and true if it is closed.
    pub path: (f64, usize, bool),
    /// Warnings of netconvert by kind.
    pub warnings: Vec<WarningKind>,
    /// Errors in the file that netconvert ignored, by kind.
    pub errors: Vec<WarningKind>,
    /// Parts of the network that are not passed to SUMO.
    pub dropped: Dropped,
}

impl ImportReport {
    pub(super) fn of(file: &std::path::Path, format: SourceFormat, made: &MadeNetwork) -> Result<Self, MapError> {
        let failed = |source| MapError::Io { file: file.into(), source };
        let net = &made.network;
        Ok(Self {
            file_name: file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default(),
            bytes: open_regular(file).and_then(|open| open.metadata()).map_err(failed)?.len(),
            format,
            elements: count_elements(file, format).map_err(failed)?,
            conversion: made.words.clone(),
            finer: made.before.clone(),
            notes: made.notes.clone(),
            census: net.census(),
            car_lanes: street_lanes(net).filter(|lane| lane.admits_cars()).count(),
            names: count_names(net),
            u_turns: net.connections().iter().filter(|way| way.is_turnaround()).count(),
            alone: alone(net),
            path: (made.path.length_m(net), made.path.streets.len(), made.path.is_closed),
            warnings: made.warnings.clone(),
            errors: made.errors.clone(),
            dropped: net.sumo_text().dropped().clone(),
        })
    }

    /// Returns the lines for the terminal.
    pub fn short(&self) -> Vec<String> {
        self.lines(KINDS_TOLD)
    }

    /// Returns the whole report as text, for a file.
    pub fn text(&self) -> String {
        self.lines(usize::MAX).iter().map(|line| format!("{line}\n")).collect()
    }

    fn lines(&self, kinds: usize) -> Vec<String> {
        let census = &self.census;
        let mut lines =
            vec![format!("file           {}, {}, {}", self.file_name, self.format.name(), size_text(self.bytes))];
        let elements = self.elements.iter().filter(|(_, n)| *n > 0).map(|(name, n)| format!("{n} {name}"));
        let elements = elements.collect::<Vec<_>>().join(", ");
        if !elements.is_empty() {
            lines.push(format!("has            {elements}"));
        }
        lines.push(format!("taken          {}", self.conversion));
        lines.extend(self.finer.iter().map(|line| format!("               {line}")));
        lines.extend(self.notes.iter().cloned());
        lines.push(format!("streets        {}, {:.0} m of lanes", census.streets, census.lanes_m));
        match self.names {
            (0, _) => {}
            (names, 0) => lines.push(format!("names          {names} of streets")),
            (names, others) => {
                lines.push(format!("names          {names} of streets; {others} in letters that no sign can show"));
            }
        }
        let others = census.lanes - self.car_lanes;
        lines.push(format!("lanes          {} for cars, {others} not for cars", self.car_lanes));
        lines.push(format!(
            "junctions      {}, {} lanes inside, {} connections, {} U-turns",
            census.junctions, census.insides, census.connections, self.u_turns
        ));
        let idle = match census.idle_signals {
            0 => String::new(),
            n => format!("; {n} without a lane"),
        };
        lines.push(format!("signals        {}{idle}", census.signals));
        lines.push(match (census.has_heights(), census.heights_m) {
            (true, (low_m, high_m)) => format!("heights        {low_m:.1} to {high_m:.1} m"),
            (false, _) => "heights        none: flat".to_owned(),
        });
        lines.push(match (census.islands, self.alone) {
            (0 | 1, _) => "parts          1: all streets are connected".to_owned(),
            (parts, 0) => format!("parts          {parts}, not connected to each other"),
            (parts, alone) => {
                format!("parts          {parts}, not connected to each other; {alone} streets without access")
            }
        });
        lines.push(format!("left out       {}", self.left_out()));
        for (name, found) in [("passed over   ", &self.errors), ("warnings      ", &self.warnings)] {
            let n: usize = found.iter().map(|kind| kind.count).sum();
            if n > 0 {
                lines.push(format!("{name} {n} of {} kinds", found.len()));
            }
            lines.extend(found.iter().take(kinds).map(|kind| {
                let short: String = kind.example.chars().take(EXAMPLE_CHARS).collect();
                format!("         {:>5} like: {short}", kind.count)
            }));
        }
        let (length_m, streets, is_closed) = self.path;
        let kind = if is_closed { "closed" } else { "open: no loop was found" };
        lines.push(format!("path           {length_m:.0} m over {streets} streets, {kind}"));
        lines
    }

    /// Describes the parts that netconvert never imports from this format.
    fn left_out(&self) -> String {
        match self.format {
            SourceFormat::Sumo if !self.dropped.is_empty() => return self.dropped.to_string(),
            SourceFormat::OpenDrive => "other signs, painted markings, objects other than buildings, trees and bushes, banking, and lanes without traffic",
            SourceFormat::OpenStreetMap => "ways not for cars, other signs, and painted markings",
            SourceFormat::Sumo => "nothing",
        }
        .to_owned()
    }
}

fn street_lanes(net: &Network) -> impl Iterator<Item = &crate::map::network::Lane> {
    net.lanes().iter().filter(|lane| net.edge(lane.edge).kind.is_street())
}

/// Counts the different names of streets, and those in letters of other alphabets than the Latin one.
fn count_names(net: &Network) -> (usize, usize) {
    let streets = net.edges().iter().filter(|edge| edge.kind.is_street());
    let names: BTreeSet<&str> = streets.filter_map(|edge| edge.name.as_deref()).collect();
    (names.len(), names.iter().filter(|name| !is_latin(name)).count())
}

/// Counts the streets for cars with no lane before or after any of their lanes.
fn alone(net: &Network) -> usize {
    let streets = net.edges().iter().filter(|edge| edge.kind.is_street());
    let for_cars = streets.filter(|edge| edge.lanes().any(|lane| net.lane(lane).admits_cars()));
    let leads = |lane| net.successors(lane).len() > 0 || !net.predecessors(lane).is_empty();
    for_cars.filter(|edge| edge.kind != EdgeKind::Connector && !edge.lanes().any(leads)).count()
}

/// Counts the elements of the file that people know by name.
fn count_elements(file: &std::path::Path, format: SourceFormat) -> Result<Vec<(&'static str, usize)>, std::io::Error> {
    let kinds: &[(&str, &str)] = match format {
        SourceFormat::OpenDrive => {
            &[("road", "roads"), ("junction", "junctions"), ("signal", "signals and signs"), ("object", "objects")]
        }
        SourceFormat::OpenStreetMap => &[("node", "nodes"), ("way", "ways"), ("relation", "relations")],
        SourceFormat::Sumo => &[],
    };
    let mut counts: Vec<(&'static str, usize)> = kinds.iter().map(|(_, words)| (*words, 0)).collect();
    if kinds.is_empty() {
        return Ok(counts);
    }
    // Tag by tag: the file may be a single line, larger than the memory to use.
    let mut document = document::open(file, MOST_IMPORT_BYTES)?;
    let mut tag = Vec::new();
    loop {
        tag.clear();
        if document.read_until(b'<', &mut tag)? == 0 {
            return Ok(counts);
        }
        let is_end = |byte: &u8| byte.is_ascii_whitespace() || [b'>', b'/'].contains(byte);
        let name = tag.split(is_end).next().unwrap_or_default();
        if let Some(k) = kinds.iter().position(|(known, _)| known.as_bytes() == name) {
            counts[k].1 += 1;
        }
    }
}
