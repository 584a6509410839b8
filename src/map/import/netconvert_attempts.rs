//! Conversion of a file into a network: attempts with ever coarser options, until one gives a network that can be driven. In: a file of a
//! known format. Out: the network's bytes on the disk, the network, its default path, and how it was made.

use super::{
    ImportBounds,
    netconvert::Conversion,
    repair::{repair, with_default_limits},
    warnings::{self, ERROR, WARNING, WarningKind},
};
use crate::{
    file::{read_bounded, read_text, size_text},
    map::{
        MapError, SumoText, catalog,
        limits::{MOST_BYTES, MOST_IMPORT_BYTES},
        loop_search::default_path,
        network::{self, EdgeKind, Network},
    },
    private,
};
use std::path::Path;

/// Largest gap between a line through a junction and the lanes that it joins, metres: a car cannot follow a step of half its width.
const FITS_M: f64 = 0.5;

/// Format of a file to import.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceFormat {
    /// OpenDRIVE, files `.xodr`.
    OpenDrive,
    /// OpenStreetMap, files `.osm` and `.osm.xml`.
    OpenStreetMap,
    /// SUMO's own network format, files `net.xml`.
    Sumo,
}

/// Input of netconvert in an attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AttemptInput {
    /// No conversion: the file is a network already.
    Nothing,
    /// Original file; for a SUMO network, its canonical copy.
    File,
    /// Repaired copy of the file.
    Repaired,
}

/// Attempt to make a network of a file.
struct ConversionAttempt {
    input: AttemptInput,
    /// Command-line options for netconvert.
    options: &'static [&'static str],
    /// Description for the report, after "taken ".
    words: &'static str,
}

/// Options for OpenStreetMap. Heights come from the file; a file without heights stays flat.
const OSM: [&str; 6] =
    ["--keep-edges.by-vclass", "passenger", "--remove-edges.isolated", "--osm.elevation", "true", "--junctions.join"];

impl SourceFormat {
    /// Returns the format by the file's name; `None` if it is unknown.
    pub(super) fn of(file: &Path) -> Option<Self> {
        let name = file.file_name()?.to_string_lossy().to_lowercase();
        let ends = |ends: &[&str]| ends.iter().any(|end| name.ends_with(end));
        match () {
            () if ends(&[".xodr"]) => Some(Self::OpenDrive),
            () if ends(&[".osm", ".osm.xml"]) => Some(Self::OpenStreetMap),
            () if ends(&["net.xml"]) => Some(Self::Sumo),
            () => None,
        }
    }

    /// Returns the format's name for people.
    pub fn name(self) -> &'static str {
        match self {
            Self::OpenDrive => "OpenDRIVE",
            Self::OpenStreetMap => "OpenStreetMap",
            Self::Sumo => "a SUMO network",
        }
    }

    fn flag(self) -> &'static str {
        match self {
            Self::OpenDrive => "--opendrive-files",
            Self::OpenStreetMap => "--osm-files",
            Self::Sumo => "--sumo-net-file",
        }
    }

    fn attempts(self) -> &'static [ConversionAttempt] {
        match self {
            // Curves sampled every metre take much memory on some files, and lines through junctions do not always meet the lanes.
            Self::OpenDrive => &[
                ConversionAttempt {
                    input: AttemptInput::File,
                    options: &["--opendrive.curve-resolution", "1", "--opendrive.internal-shapes", "true"],
                    words: "with its own lines through junctions and curves sampled each metre",
                },
                ConversionAttempt {
                    input: AttemptInput::File,
                    options: &["--opendrive.curve-resolution", "1", "--ignore-errors", "true"],
                    words: "with netconvert's lines through junctions and curves sampled each metre",
                },
                ConversionAttempt {
                    input: AttemptInput::File,
                    options: &["--ignore-errors", "true"],
                    words: "with netconvert's lines through junctions and curves sampled each 2 m",
                },
                ConversionAttempt {
                    input: AttemptInput::Repaired,
                    options: &["--ignore-errors", "true"],
                    words: "with netconvert's lines through junctions and curves sampled each 2 m, after repair",
                },
            ],
            Self::OpenStreetMap => &[
                ConversionAttempt {
                    input: AttemptInput::File,
                    options: &OSM,
                    words: "with junctions that lie close together joined",
                },
                ConversionAttempt {
                    input: AttemptInput::File,
                    options: &[OSM[0], OSM[1], OSM[2], OSM[3], OSM[4], "--ignore-errors", "true"],
                    words: "with junctions as they are",
                },
                // netconvert treats a road as isolated if it leads out of the file at both ends.
                ConversionAttempt {
                    input: AttemptInput::File,
                    options: &[OSM[0], OSM[1], OSM[3], OSM[4], OSM[5], "--ignore-errors", "true"],
                    words: "with roads that join no other",
                },
            ],
            Self::Sumo => &[
                ConversionAttempt { input: AttemptInput::Nothing, options: &[], words: "as it is" },
                ConversionAttempt {
                    input: AttemptInput::File,
                    options: &["--ignore-errors", "true"],
                    words: "rebuilt by netconvert",
                },
            ],
        }
    }
}

/// Network made by an attempt.
pub(super) struct MadeNetwork {
    pub network: Network,
    pub path: network::Path,
    /// Description of the attempt, for the report.
    pub words: String,
    /// Reasons why finer attempts were rejected.
    pub before: Vec<String>,
    pub warnings: Vec<WarningKind>,
    /// Errors in the file that netconvert ignored.
    pub errors: Vec<WarningKind>,
}

/// Converts a file into `net`: by the first attempt whose network can be driven and whose lines through junctions meet the lanes, else by
/// the attempt with the smallest gap between them.
pub(super) fn make(
    program: &Path,
    file: &Path,
    format: SourceFormat,
    net: &Path,
    bounds: &ImportBounds,
) -> Result<MadeNetwork, MapError> {
    let failed = |source| MapError::Io { file: net.into(), source };
    let attempts = format.attempts();
    let runs = attempts.iter().filter(|one| one.input != AttemptInput::Nothing).count() as u64;
    let mut errors = Vec::new();
    let mut before = Vec::new();
    let mut best: Option<(f64, Vec<u8>, MadeNetwork)> = None;
    for one in attempts {
        match run_attempt(program, file, format, (net, one), (bounds, runs)) {
            Err(error @ MapError::Interrupted { .. }) => return Err(error),
            Err(error) => {
                let is_final = !is_worth_another_try(&error, format);
                before.push(format!("not {}: {}", one.words, in_one_line(&error, file)));
                errors.push(error);
                if is_final {
                    break;
                }
            }
            Ok(made) => {
                let gap_m = widest_joint_m(&made.network);
                let fits = gap_m <= FITS_M;
                if best.as_ref().is_none_or(|(least_m, ..)| gap_m < *least_m) {
                    let bytes = read_bounded(net, MOST_BYTES).map_err(failed)?;
                    best = Some((gap_m, bytes, MadeNetwork { before: before.clone(), ..made }));
                }
                // A SUMO network is accepted as its author drew it.
                if fits || format == SourceFormat::Sumo {
                    break;
                }
                before.push(format!("not {}: they miss the lanes that they join by up to {gap_m:.1} m", one.words));
            }
        }
    }
    match best {
        Some((_, bytes, made)) => private::replace(net, &bytes).map_err(failed).map(|()| made),
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

fn run_attempt(
    program: &Path,
    file: &Path,
    format: SourceFormat,
    (net, one): (&Path, &ConversionAttempt),
    (bounds, shares): (&ImportBounds, u64),
) -> Result<MadeNetwork, MapError> {
    let mut how = one.words.to_owned();
    let repaired = net.with_file_name("repaired.xodr");
    let copy = net.with_file_name("copy.net.xml");
    let input = match one.input {
        AttemptInput::Nothing => None,
        AttemptInput::File if format == SourceFormat::Sumo => {
            let text = catalog::read(file, MOST_BYTES)?;
            let text = SumoText::read(file, &text)?;
            private::replace(&copy, text.as_str().as_bytes())
                .map_err(|source| MapError::Io { file: file.into(), source })?;
            Some(copy.as_path())
        }
        AttemptInput::File => Some(file),
        AttemptInput::Repaired => {
            let text =
                read_text(file, MOST_IMPORT_BYTES).map_err(|source| MapError::Io { file: file.into(), source })?;
            let (text, done) = repair(&text).ok_or_else(|| MapError::Netconvert {
                file: file.into(),
                message: "it needs a repair that codrive does not know".into(),
            })?;
            private::replace(&repaired, text.as_bytes())
                .map_err(|source| MapError::Io { file: file.into(), source })?;
            how = format!("{how} ({})", done.join("; "));
            Some(repaired.as_path())
        }
    };
    let words = match input {
        Some(input) => {
            let _ = std::fs::remove_file(net);
            let conversion = Conversion {
                program,
                format: format.flag(),
                file: input,
                known: file,
                net,
                options: one.options,
                shares,
            };
            let words = conversion.run(bounds);
            let _ = std::fs::remove_file(&repaired);
            let _ = std::fs::remove_file(&copy);
            words?
        }
        None => String::new(),
    };
    // Errors name the user's file; line numbers of netconvert's result do not refer to it.
    let of = |problem: MapError| match one.input {
        AttemptInput::Nothing => problem,
        _ => MapError::Converted { file: file.into(), problem: Box::new(problem) },
    };
    let known = if one.input == AttemptInput::Nothing { file } else { Path::new("net.xml") };
    let (made, whose) = match one.input {
        AttemptInput::Nothing => (file, "the network has"),
        _ => (net, "netconvert makes a network of it that has"),
    };
    let text = catalog::read(made, MOST_BYTES).map_err(|error| match error {
        MapError::NotXml { line, column, message, .. } => {
            of(MapError::NotXml { file: known.into(), line, column, message })
        }
        MapError::Io { source, .. } => unreadable(file, made, whose, source),
        other => other,
    })?;
    let text = match with_default_limits(&text).filter(|_| one.input != AttemptInput::Nothing) {
        Some((text, done)) => {
            how = format!("{how}; {done}");
            text
        }
        None => text,
    };
    let network = Network::read(known, &text).map_err(of)?;
    private::replace(net, network.sumo_text().as_str().as_bytes())
        .map_err(|source| MapError::Io { file: file.into(), source })?;
    // This error is about the roads, so it names the user's file.
    let path = default_path(file, &network)?;
    let count = |begin| warnings::count(&words, begin);
    Ok(MadeNetwork { network, path, words: how, before: Vec::new(), warnings: count(WARNING), errors: count(ERROR) })
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
