//! Conversion of a file into a network: attempts with ever coarser options, until one gives a network that can be driven. In: a file of a
//! known format. Out: the network's bytes on the disk, the network, its default path, and how it was made.

use super::{
    netconvert::{Conversion, ImportOptions},
    repair::{repair, with_default_limits},
    source_copy::SourceCopy,
    source_format::SourceFormat,
    warnings::{self, ERROR, WARNING, WarningKind},
};
use crate::{
    file::{read_bounded, size_text},
    map::{
        MapError, SumoText, catalog,
        limits::{MOST_BYTES, MOST_IMPORT_BYTES},
        loop_search::{DefaultPath, default_path},
        network::{EdgeKind, Network},
    },
    private,
    sumo_xml::document,
};
use std::path::{Path, PathBuf};

/// Largest gap between a line through a junction and the lanes that it joins, metres: a car cannot follow a step of half its width.
const FITS_M: f64 = 0.5;

/// Input of netconvert in an attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AttemptInput {
    /// No conversion: the file is a network already.
    Nothing,
    /// Prepared copy of the file; for a SUMO network, its canonical copy.
    File,
    /// Repaired copy of that copy.
    Repaired,
}

/// Options of netconvert in an attempt.
struct AttemptOptions {
    input: AttemptInput,
    options: &'static [&'static [&'static str]],
    /// Description for the report, after "taken ".
    words: &'static str,
}

const EACH_METRE: &[&str] = &["--opendrive.curve-resolution", "1"];
const OWN_LINES: &[&str] = &["--opendrive.internal-shapes", "true"];
const LENIENT: &[&str] = &["--ignore-errors", "true"];
const FOR_CARS: &[&str] = &["--keep-edges.by-vclass", "passenger"];
/// netconvert treats a road as isolated if it leads out of the file at both ends.
const WITHOUT_ISOLATED: &[&str] = &["--remove-edges.isolated"];
/// Heights come from the file; a file without heights stays flat.
const HEIGHTS: &[&str] = &["--osm.elevation", "true"];
const JOINED: &[&str] = &["--junctions.join"];

/// Attempts for OpenDRIVE. Curves sampled every metre take much memory on some files, and lines through junctions do not always meet the
/// lanes.
const OPEN_DRIVE: &[AttemptOptions] = &[
    AttemptOptions {
        input: AttemptInput::File,
        options: &[EACH_METRE, OWN_LINES],
        words: "with its own lines through junctions and curves sampled every metre",
    },
    AttemptOptions {
        input: AttemptInput::File,
        options: &[EACH_METRE, LENIENT],
        words: "with netconvert's lines through junctions and curves sampled every metre",
    },
    AttemptOptions {
        input: AttemptInput::File,
        options: &[LENIENT],
        words: "with netconvert's lines through junctions and curves sampled every 2 m",
    },
    AttemptOptions {
        input: AttemptInput::Repaired,
        options: &[LENIENT],
        words: "with netconvert's lines through junctions and curves sampled every 2 m, after repair",
    },
];

const OPEN_STREET_MAP: &[AttemptOptions] = &[
    AttemptOptions {
        input: AttemptInput::File,
        options: &[FOR_CARS, WITHOUT_ISOLATED, HEIGHTS, JOINED],
        words: "with junctions that lie close together joined",
    },
    AttemptOptions {
        input: AttemptInput::File,
        options: &[FOR_CARS, WITHOUT_ISOLATED, HEIGHTS, LENIENT],
        words: "with junctions as they are",
    },
    AttemptOptions {
        input: AttemptInput::File,
        options: &[FOR_CARS, HEIGHTS, JOINED, LENIENT],
        words: "with roads that are connected to no other road",
    },
];

const SUMO: &[AttemptOptions] = &[
    AttemptOptions { input: AttemptInput::Nothing, options: &[], words: "as it is" },
    AttemptOptions { input: AttemptInput::File, options: &[LENIENT], words: "rebuilt by netconvert" },
];

/// Network made by an attempt.
pub(super) struct MadeNetwork {
    pub network: Network,
    pub path: DefaultPath,
    /// Description of the attempt, for the report.
    pub words: String,
    /// Reasons why finer attempts were rejected.
    pub before: Vec<String>,
    /// Lines for the report on what was changed in the file before its conversion.
    pub notes: Vec<String>,
    /// Name of the place, if the file has one.
    pub place: Option<String>,
    pub warnings: Vec<WarningKind>,
    /// Errors in the file that netconvert ignored.
    pub errors: Vec<WarningKind>,
    /// Largest gap between lines through junctions and the lanes that they join, metres.
    gap_m: f64,
}

/// Converts a file into `net`: by the first attempt whose network can be driven and whose lines through junctions meet the lanes, else by
/// the attempt with the smallest gap between them.
pub(super) fn make(
    program: &Path,
    file: &Path,
    format: SourceFormat,
    net: &Path,
    bounds: &ImportOptions,
) -> Result<MadeNetwork, MapError> {
    let failed = |source| MapError::Io { file: net.into(), source };
    let attempts = match format {
        SourceFormat::OpenDrive => OPEN_DRIVE,
        SourceFormat::OpenStreetMap => OPEN_STREET_MAP,
        SourceFormat::Sumo => SUMO,
    };
    let source = SourceCopy::make(file, format, net.parent().unwrap_or(Path::new("")), bounds.side)?;
    let runs = attempts.iter().filter(|one| one.input != AttemptInput::Nothing).count() as u64;
    let mut errors = Vec::new();
    let mut before = Vec::new();
    let mut best: Option<(Vec<u8>, MadeNetwork)> = None;
    for AttemptOptions { input, options, words } in attempts {
        let attempt = Attempt { program, file, source: &source, format, net, bounds, runs, input: *input, options };
        match attempt.run(words) {
            Err(error @ MapError::Interrupted { .. }) => return Err(error),
            Err(error) => {
                let is_final = !is_worth_another_try(&error, format);
                before.push(format!("not {words}: {}", in_one_line(&error, file)));
                errors.push(error);
                if is_final {
                    break;
                }
            }
            Ok(made) => {
                let gap_m = made.gap_m;
                if best.as_ref().is_none_or(|(_, best)| gap_m < best.gap_m) {
                    let bytes = read_bounded(net, MOST_BYTES).map_err(failed)?;
                    best = Some((bytes, MadeNetwork { before: before.clone(), ..made }));
                }
                // A SUMO network is accepted as its author drew it.
                if gap_m <= FITS_M || format == SourceFormat::Sumo {
                    break;
                }
                before.push(format!("not {words}: these lines miss the lanes that they join by up to {gap_m:.1} m"));
            }
        }
    }
    match best {
        Some((bytes, made)) => private::replace(net, &bytes).map_err(failed).map(|()| made),
        // An error of a finished conversion explains more than a failure of netconvert in another attempt.
        None => {
            let converted = |error: &MapError| {
                matches!(error, MapError::NoPath { .. } | MapError::Converted { .. } | MapError::NetworkTooLarge { .. })
            };
            let reason = errors.iter().position(converted).filter(|_| format != SourceFormat::Sumo).unwrap_or(0);
            Err(errors.swap_remove(reason))
        }
    }
}

/// Attempt to make a network of a file.
struct Attempt<'a> {
    program: &'a Path,
    file: &'a Path,
    source: &'a SourceCopy,
    format: SourceFormat,
    /// Place of the network.
    net: &'a Path,
    bounds: &'a ImportOptions<'a>,
    /// Number of runs of netconvert that share the time limit.
    runs: u64,
    input: AttemptInput,
    options: &'a [&'a [&'a str]],
}

impl Attempt<'_> {
    fn run(&self, words: &str) -> Result<MadeNetwork, MapError> {
        let mut words = words.to_owned();
        let messages = self.convert(&mut words)?;
        let network = self.read(&mut words)?;
        self.judge(network, words, &messages)
    }

    /// Runs netconvert, unless the file is a network already, and returns its messages. Adds a repair to `words`.
    fn convert(&self, words: &mut String) -> Result<String, MapError> {
        if self.input == AttemptInput::Nothing {
            return Ok(String::new());
        }
        let input = self.prepared(words)?;
        let _ = std::fs::remove_file(self.net);
        let conversion = Conversion {
            program: self.program,
            format: self.format.option(),
            file: &input,
            known: self.file,
            net: self.net,
            options: self.options.concat().into_iter().chain(self.source.options.iter().map(String::as_str)).collect(),
            shares: self.runs,
        };
        let messages = conversion.run(self.bounds);
        if ![self.file, &self.source.file].contains(&input.as_path()) {
            let _ = std::fs::remove_file(&input);
        }
        messages
    }

    /// Returns the file that netconvert reads: the prepared, repaired or canonical copy.
    fn prepared(&self, words: &mut String) -> Result<PathBuf, MapError> {
        let failed = |source| MapError::Io { file: self.file.into(), source };
        let copy = |name: &str, text: &str| {
            let copy = self.net.with_file_name(name);
            private::replace(&copy, text.as_bytes()).map_err(failed).map(|()| copy)
        };
        match self.input {
            AttemptInput::Repaired => {
                let text = document::read_text(&self.source.file, 2 * MOST_IMPORT_BYTES).map_err(failed)?;
                let (text, done) = repair(&text).ok_or_else(|| MapError::Netconvert {
                    file: self.file.into(),
                    message: "netconvert cannot read the file, and codrive has no repair for it".into(),
                })?;
                *words = format!("{words} ({})", done.join("; "));
                copy("repaired.xodr", &text)
            }
            _ if self.format == SourceFormat::Sumo => {
                let text = catalog::read_network(self.file)?;
                copy("copy.net.xml", SumoText::read(self.file, &text)?.as_str())
            }
            _ => Ok(self.source.file.clone()),
        }
    }

    /// Reads the network, and writes it as SUMO reads it. Adds speed limits that were missing to `words`.
    fn read(&self, words: &mut String) -> Result<Network, MapError> {
        let is_converted = self.input != AttemptInput::Nothing;
        // Errors name the user's file; line numbers of netconvert's result do not refer to it.
        let of = |problem: MapError| match is_converted {
            true => MapError::Converted { file: self.file.into(), problem: Box::new(problem) },
            false => problem,
        };
        let (known, made, whose) = match is_converted {
            true => (Path::new("net.xml"), self.net, "netconvert makes a network that has"),
            false => (self.file, self.file, "the network has"),
        };
        let text = catalog::read_network(made).map_err(|error| match error {
            MapError::NotXml { line, column, message, .. } => {
                of(MapError::NotXml { file: known.into(), line, column, message })
            }
            MapError::Io { source, .. } => unreadable(self.file, made, whose, source),
            other => other,
        })?;
        let text = match with_default_limits(&text).filter(|_| is_converted) {
            Some((text, done)) => {
                *words = format!("{words}; {done}");
                text
            }
            None => text,
        };
        let network = Network::read(known, &text).map_err(of)?;
        private::replace(self.net, network.sumo_text().as_str().as_bytes())
            .map_err(|source| MapError::Io { file: self.file.into(), source })?;
        Ok(network)
    }

    /// Finds the network's default path, and the largest gap in its lines through junctions.
    fn judge(&self, network: Network, words: String, messages: &str) -> Result<MadeNetwork, MapError> {
        // This error is about the roads, so it names the user's file.
        let path = default_path(self.file, &network)?;
        let gap_m = widest_joint_m(&network);
        let [warnings, errors] = [WARNING, ERROR].map(|begin| warnings::count(messages, begin));
        let (before, notes, place) = (Vec::new(), self.source.notes.clone(), self.source.place.clone());
        Ok(MadeNetwork { network, path, words, before, notes, place, warnings, errors, gap_m })
    }
}

/// Builds the error for a network that could not be read; it names the user's `file`.
fn unreadable(file: &Path, net: &Path, what: &'static str, source: std::io::Error) -> MapError {
    let file = file.to_path_buf();
    match net.metadata() {
        Ok(found) if source.kind() == std::io::ErrorKind::FileTooLarge => MapError::NetworkTooLarge {
            file,
            what,
            size: size_text(found.len().next_multiple_of(1 << 20)),
            allowed: size_text(MOST_BYTES),
        },
        _ => MapError::Io { file, source },
    }
}

/// Returns false if no options can help: the file cannot be read at all, or is not of this format.
fn is_worth_another_try(error: &MapError, format: SourceFormat) -> bool {
    match error {
        // For OpenDRIVE, coarser options make curves of fewer points; for the other formats there are none.
        MapError::NetworkTooLarge { .. } => format == SourceFormat::OpenDrive,
        // Message of netconvert's XML parser for a truncated file or text that is not XML.
        MapError::Netconvert { message, .. } => !message.contains("At line/column"),
        MapError::NetconvertAbsent { .. }
        | MapError::NotXml { .. }
        | MapError::NotANet { .. }
        | MapError::Refused { .. }
        | MapError::Limit { .. }
        | MapError::Io { .. } => false,
        _ => true,
    }
}

/// Returns the first line of an error, without the name of the file.
fn in_one_line(error: &MapError, file: &Path) -> String {
    let text = error.to_string();
    let text = text.lines().next().unwrap_or_default();
    text.strip_prefix(&format!("{}: ", file.display())).unwrap_or(text).to_owned()
}

/// Returns the largest gap between lines through junctions and the lanes that they join, metres; only lanes open to cars count.
fn widest_joint_m(net: &Network) -> f64 {
    let is_inside = |lane| net.edge_of(lane).kind == EdgeKind::Internal;
    let joints = net.lane_ids().flat_map(|from| net.successors(from).map(move |to| (from, to)));
    let joints = joints.filter(|&(from, to)| is_inside(from) || is_inside(to));
    let for_cars = joints.filter(|&(from, to)| net.lane(from).admits_cars() && net.lane(to).admits_cars());
    let gap_m = |(from, to)| {
        let (end, start): (&[glam::DVec3], &[glam::DVec3]) = (net.lane(from).shape(), net.lane(to).shape());
        end[end.len() - 1].truncate().distance(start[0].truncate())
    };
    for_cars.map(gap_m).fold(0.0, f64::max)
}
