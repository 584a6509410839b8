//! Demand of a road network: number, kinds, origins and destinations of the vehicles that enter. In: SUMO files, or flows of a scenario.
//! Out: input for an engine. SUMO's router finds the route of each vehicle when it departs.

use super::{
    VehicleKind,
    demand_file::{self, CanonicalDemand, MOST_VEHICLES, SHORTER},
};
use crate::{map::network::Network, sumo_xml::write_escaped, toml_text::did_you_mean};
use serde::{Deserialize, Serialize};
use std::{
    fmt::Write,
    path::{Path, PathBuf},
};

/// Maximum rate of a flow, vehicles per hour. A lane carries about 2,000.
pub const MOST_PER_HOUR: f64 = 100_000.0;

/// Latest begin of a drive in the files of a demand, s: a year.
pub const LATEST_S: f64 = 31_536_000.0;

/// SUMO's type for vehicles that have no type in a file.
pub(super) const DEFAULT_TYPE: &str = "DEFAULT_VEHTYPE";
/// Type from which SUMO makes the type of vehicles that drivers outside SUMO move.
pub(super) const EGO_TYPE: &str = "codrive.ego";
/// Attributes of a vehicle type that changes lanes only while it drives, at 11 degrees at most: the lateral speed is at most 0.2 of the
/// speed. With SUMO's share of 1, a vehicle that stops during a lane change stands across both lanes.
const AS_A_CAR_STEERS: &str = "lcMaxSpeedLatStanding=\"0\" lcMaxSpeedLatFactor=\"0.2\"";

/// Demand for a road network.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Demand {
    /// SUMO files (`rou.xml`: vehicles, trips, flows, routes, types), by ascending time of departure. SUMO reads canonical copies.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<PathBuf>,
    /// SUMO's additional files (`add.xml`: stopping places, rerouters, calibrators, speed signs, programs of signals, types), read before
    /// the demand files.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub additional_files: Vec<PathBuf>,
    /// Time of day in the files at which the drive begins, seconds; vehicles that depart earlier never enter.
    #[serde(skip_serializing_if = "is_zero")]
    #[schemars(range(min = 0.0, max = 31_536_000.0), extend("unit" = "s"))]
    pub begin_s: f64,
    /// True to leave out, with a warning, vehicles and other elements of the files that SUMO cannot drive, and parts that codrive does not
    /// give to SUMO; false to refuse a file for the first of them.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub leave_out_faults: bool,
    /// Flows from edge to edge.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub flows: Vec<Flow>,
}

/// Flow of vehicles with random departure times.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Flow {
    /// Edge on which the vehicles enter.
    pub from: String,
    /// Edge at whose end the vehicles leave.
    pub to: String,
    /// Mean rate, vehicles per hour.
    #[schemars(range(min = 0.0, max = 100_000.0), extend("unit" = "1/h"))]
    pub per_hour: f64,
    /// Shares of the vehicle kinds; all vehicles are cars if empty. The shares need not add up to one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub mix: Vec<KindShare>,
}

/// Share of one vehicle kind in a flow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct KindShare {
    pub kind: VehicleKind,
    /// Weight relative to the other shares of the flow, 0 or more.
    #[schemars(range(min = 0.0))]
    pub share: f64,
}

/// Fault in the flows or files of a demand.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DemandFault {
    /// The rate of a flow is out of range.
    #[error("flow {flow}: per_hour is {value}; allowed: a number above 0, at most {MOST_PER_HOUR}")]
    Rate {
        /// Number of the flow, from 1.
        flow: usize,
        /// Rate of the flow, vehicles per hour.
        value: f64,
    },
    /// A share of a flow is negative or not finite, or no share is above 0.
    #[error("flow {flow}: the share of {} is {value}; allowed: 0 or more, and at least one share above 0", .kind.name())]
    Share {
        /// Number of the flow, from 1.
        flow: usize,
        /// Vehicle kind with this share.
        kind: VehicleKind,
        value: f64,
    },
    /// A kind of a flow is no vehicle.
    #[error(
        "flow {flow}: a share has kind {}; allowed: car, van, truck, bus, motorcycle, bicycle\n  remedy: state persons \
         in a demand file (person, personFlow)", .kind.name()
    )]
    Kind {
        /// Number of the flow, from 1.
        flow: usize,
        /// Kind of the share.
        kind: VehicleKind,
    },
    /// The begin of the drive in the files is out of range.
    #[error("begin_s is {value}; allowed: a number from 0 to {LATEST_S}")]
    Begin {
        /// Begin of the drive in the files, s.
        value: f64,
    },
    /// No vehicle departs between the begin and the end of the drive.
    #[error(
        "{}: no vehicle departs: the {nearest} at {at_s} s; the drive begins at {begin_s} s of the file\n  remedy: \
         begin_s = {at_s} in [demand]", .file.display()
    )]
    NoneDeparts {
        /// First file of the demand.
        file: PathBuf,
        /// Departure nearest to the drive: `first` or `last`.
        nearest: &'static str,
        /// Time of that departure in the files, s.
        at_s: f64,
        /// Begin of the drive in the files, s.
        begin_s: f64,
    },
    /// The reading was interrupted.
    #[error("interrupted while the demand was read")]
    Interrupted,
    /// A file that cannot be read.
    #[error("{}: {problem}", .file.display())]
    File {
        file: PathBuf,
        /// Cause of the failure.
        problem: String,
    },
    /// An element of a file is at fault.
    #[error("{}:{line}: {element}: {problem}", .file.display())]
    Element {
        file: PathBuf,
        /// Line number, counted from 1.
        line: u32,
        /// Label of the element, for example `trip "t7"`.
        element: String,
        /// Description of the fault, with the allowed values.
        problem: String,
    },
    /// The files bring too many vehicles.
    #[error("{}: the demand has {value} vehicles and persons; allowed: at most {MOST_VEHICLES}{SHORTER}", .file.display())]
    Vehicles {
        /// File at which the limit is exceeded.
        file: PathBuf,
        /// Number of vehicles and persons up to the end of this file, including flows and earlier files.
        value: u64,
    },
    /// The demand's own flows bring too many vehicles.
    #[error(
        "the flows of the demand have {value} vehicles until {until_s} s; allowed: at most {MOST_VEHICLES}\n  remedy: \
         set a lower per_hour, or a shorter drive"
    )]
    FlowVehicles {
        /// Number of vehicles before `until_s`.
        value: u64,
        /// Time until which vehicles are counted, s.
        until_s: f64,
    },
    /// A flow names an edge that does not exist or is part of a junction.
    #[error(
        "flow {flow}: {side} is \"{edge}\"; allowed: the id of an edge of this network that is not part of a \
         junction{near}"
    )]
    Edge {
        /// Number of the flow, from 1.
        flow: usize,
        /// Attribute at fault: `from` or `to`.
        side: &'static str,
        /// Id of the edge.
        edge: String,
        /// Nearest existing name, as a question; empty if none is near.
        near: String,
    },
}

impl Demand {
    /// Returns true if the demand has neither files nor flows.
    pub fn is_empty(&self) -> bool {
        self.input_files().next().is_none() && self.flows.is_empty()
    }

    /// Returns all files that SUMO reads for the demand, in its order: additional files, then demand files.
    pub fn input_files(&self) -> impl Iterator<Item = &PathBuf> {
        self.additional_files.iter().chain(&self.files)
    }

    /// Returns all files that SUMO reads for the demand, to be replaced, in the order of [`Demand::input_files`].
    pub fn input_files_mut(&mut self) -> impl Iterator<Item = &mut PathBuf> {
        self.additional_files.iter_mut().chain(&mut self.files)
    }

    /// Checks rates, shares and edges of all flows. `edges` has the ids of the edges that a flow may name.
    ///
    /// # Errors
    /// The first fault.
    pub fn check(&self, edges: &[&str]) -> Result<(), DemandFault> {
        self.check_numbers()?;
        for (flow, at) in self.flows.iter().zip(1..) {
            for (side, edge) in [("from", &flow.from), ("to", &flow.to)] {
                if !edges.contains(&edge.as_str()) {
                    let near = did_you_mean(edge, edges);
                    return Err(DemandFault::Edge { flow: at, side, edge: edge.clone(), near });
                }
            }
        }
        Ok(())
    }

    /// Writes canonical copies of the files into a private folder, through the gate in front of SUMO. Vehicles are counted until a time, s.
    ///
    /// # Errors
    /// The first element that is refused or cannot be driven on the network; or the demand brings too many vehicles.
    pub fn canonical(&self, network: &Network, until_s: f64, folder: &Path) -> Result<CanonicalDemand, DemandFault> {
        demand_file::copy(self, network, until_s, folder)
    }

    /// Checks the begin, and rates and shares of all flows, which do not depend on the network.
    ///
    /// # Errors
    /// The first fault.
    pub fn check_numbers(&self) -> Result<(), DemandFault> {
        if !(0.0..=LATEST_S).contains(&self.begin_s) {
            return Err(DemandFault::Begin { value: self.begin_s });
        }
        for (flow, at) in self.flows.iter().zip(1..) {
            if !(flow.per_hour > 0.0 && flow.per_hour <= MOST_PER_HOUR) {
                return Err(DemandFault::Rate { flow: at, value: flow.per_hour });
            }
            let sum: f64 = flow.mix.iter().map(|part| part.share).sum();
            if let Some(part) = flow.mix.iter().find(|part| !VehicleKind::ALL.contains(&part.kind)) {
                return Err(DemandFault::Kind { flow: at, kind: part.kind });
            }
            let bad = |part: &&KindShare| !(part.share >= 0.0 && part.share.is_finite()) || sum <= 0.0;
            if let Some(part) = flow.mix.iter().find(bad) {
                return Err(DemandFault::Share { flow: at, kind: part.kind, value: part.share });
            }
        }
        Ok(())
    }

    /// Returns the names of the flows in SUMO, which numbers their vehicles.
    pub(super) fn flow_names(&self) -> impl Iterator<Item = String> {
        let parts = self.flows.iter().enumerate().flat_map(|(k, flow)| flow.kinds().iter().map(move |part| (k, part)));
        parts.filter(|(_, part)| part.share > 0.0).map(|(k, part)| flow_name(k, part.kind))
    }

    /// Returns the flows as a SUMO file, with `car` as attributes of the type of passenger cars. Each kind in a flow gets a flow of its
    /// own: exponential times between vehicles stay exponential when they are split. Vehicles at a standstill do not change lanes, and
    /// neither do vehicles without a type in a file: SUMO would move them sideways at 1 m/s, through vehicles beside them. Vehicles of files
    /// without a model of their own follow SUMO's default, as in SUMO itself.
    /// `defines_default_type` is true if a file has that type.
    pub(super) fn flows_xml(&self, car: &str, defines_default_type: bool) -> String {
        let mut text = String::from("<routes>\n");
        if !defines_default_type {
            push(&mut text, format_args!("  <vType id=\"{DEFAULT_TYPE}\" {AS_A_CAR_STEERS}/>\n"));
        }
        push(&mut text, format_args!("  <vType id=\"{EGO_TYPE}\" carFollowModel=\"IDM\" {AS_A_CAR_STEERS}/>\n"));
        if self.flows.is_empty() {
            return text + "</routes>\n";
        }
        for kind in VehicleKind::ALL {
            let model = if kind == VehicleKind::Car { car } else { "carFollowModel=\"IDM\"" };
            push(
                &mut text,
                format_args!(
                    "  <vType id=\"{}\" vClass=\"{}\" {AS_A_CAR_STEERS} {model}/>\n",
                    type_name(kind),
                    kind.sumo_class()
                ),
            );
        }
        let (begin_s, end_s) = (self.begin_s, self.begin_s + 1_000_000.0);
        for (k, flow) in self.flows.iter().enumerate() {
            let sum: f64 = flow.kinds().iter().map(|part| part.share).sum();
            for part in flow.kinds().iter().filter(|part| part.share > 0.0) {
                let per_s = flow.per_hour * part.share / sum / 3600.0;
                let (name, kind) = (flow_name(k, part.kind), type_name(part.kind));
                let (from, to) = (escaped(&flow.from), escaped(&flow.to));
                push(
                    &mut text,
                    format_args!(
                        "  <flow id=\"{name}\" type=\"{kind}\" begin=\"{begin_s}\" end=\"{end_s}\" period=\"exp({per_s:.9})\" from=\"{from}\" \
                         to=\"{to}\" departLane=\"best\" departSpeed=\"desired\" departPos=\"base\"/>\n"
                    ),
                );
            }
        }
        text + "</routes>\n"
    }
}

impl Flow {
    /// Returns the shares of the vehicle kinds.
    fn kinds(&self) -> &[KindShare] {
        const CARS: [KindShare; 1] = [KindShare { kind: VehicleKind::Car, share: 1.0 }];
        if self.mix.is_empty() { &CARS } else { &self.mix }
    }
}

/// Returns the name of the vehicles of a kind in the flow with a number.
fn flow_name(flow: usize, kind: VehicleKind) -> String {
    format!("flow{flow}.{}", kind.name())
}

/// Returns the name of the vehicle type of a kind.
fn type_name(kind: VehicleKind) -> String {
    format!("codrive.{}", kind.name())
}

fn is_zero(number: &f64) -> bool {
    *number == 0.0
}

fn escaped(text: &str) -> String {
    let mut bytes = Vec::new();
    write_escaped(&mut bytes, text).expect("memory takes all text");
    String::from_utf8(bytes).expect("it was text")
}

fn push(text: &mut String, arguments: std::fmt::Arguments) {
    text.write_fmt(arguments).expect("a String takes all text");
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flow(per_hour: f64, mix: Vec<KindShare>) -> Demand {
        let flow = Flow { from: "a".into(), to: "b".into(), per_hour, mix };
        Demand { flows: vec![flow], ..Demand::default() }
    }

    #[test]
    fn faults_name_the_flow_the_value_and_what_is_allowed() {
        let share = |kind, share| KindShare { kind, share };
        let fault = |demand: &Demand| demand.check(&["a", "b", "bridge"]).map_err(|fault| fault.to_string());
        assert_eq!(fault(&flow(600.0, Vec::new())), Ok(()));
        for rate in [0.0, -1.0, f64::NAN, 1e9] {
            let text = fault(&flow(rate, Vec::new())).unwrap_err();
            assert!(text.starts_with(&format!("flow 1: per_hour is {rate}; allowed: a number above 0")), "{text}");
        }
        let none = fault(&flow(1.0, vec![share(VehicleKind::Car, 0.0)])).unwrap_err();
        assert!(none.contains("the share of car is 0"), "{none}");
        let mut elsewhere = flow(1.0, Vec::new());
        elsewhere.flows[0].to = "brigde".into();
        let text = fault(&elsewhere).unwrap_err();
        assert!(text.starts_with("flow 1: to is \"brigde\"") && text.ends_with("(did you mean bridge?)"), "{text}");
    }

    #[test]
    fn a_mix_is_split_into_flows_by_its_shares() {
        let mix = vec![
            KindShare { kind: VehicleKind::Car, share: 3.0 },
            KindShare { kind: VehicleKind::Truck, share: 1.0 },
            KindShare { kind: VehicleKind::Bus, share: 0.0 },
        ];
        let text = flow(720.0, mix).flows_xml("carFollowModel=\"IDM\"", false);
        // The rates are 540 and 180 vehicles per hour.
        assert!(
            text.contains("type=\"codrive.car\" begin=\"0\" end=\"1000000\" period=\"exp(0.150000000)\""),
            "{text}"
        );
        assert!(
            text.contains("type=\"codrive.truck\" begin=\"0\" end=\"1000000\" period=\"exp(0.050000000)\""),
            "{text}"
        );
        assert_eq!(text.matches("<flow ").count(), 2);
        let car = "<vType id=\"codrive.car\" vClass=\"passenger\" lcMaxSpeedLatStanding=\"0\" lcMaxSpeedLatFactor=\"0.2\" carFollowModel=\"IDM\"/>";
        assert!(text.contains(car), "{text}");
        let default = "<vType id=\"DEFAULT_VEHTYPE\" lcMaxSpeedLatStanding=\"0\" lcMaxSpeedLatFactor=\"0.2\"/>";
        assert!(text.contains(default), "{text}");
    }

    #[test]
    fn a_default_type_of_a_file_is_the_files() {
        let (folder, copies) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
        let file = folder.path().join("own.rou.xml");
        std::fs::write(&file, "<routes><vType id='DEFAULT_VEHTYPE' accel=\"3\"/></routes>").expect("written");
        let demand = Demand { files: vec![file], ..Demand::default() };
        let network = Network::read(Path::new("n.net.xml"), "<net/>").expect("a network without roads");
        let canonical = demand.canonical(&network, 3600.0, copies.path()).expect("it passes");
        let own = demand.flows_xml("", canonical.defines_default_type);
        assert!(!own.contains("DEFAULT_VEHTYPE"), "{own}");
    }
}
