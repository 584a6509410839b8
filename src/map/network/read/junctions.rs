//! Junctions and signals of a net.xml. In: a `<junction>`, a `<roundabout>`, a `<tlLogic>`. Out: their data.

use super::{Names, parameters};
use crate::map::{
    MapError,
    network::{
        Junction, JunctionKind, LinkRule, LinkSet, Network, ProgramKind, Roundabout, Signal, SignalId, SignalPhase,
        SignalProgram,
    },
    xml_tree::Element,
};
use glam::{DVec3, dvec3};

const LANES_ALLOWED: &str = "ids of lanes of this network";

impl Junction {
    /// Creates a junction without lanes and rules.
    pub(in crate::map::network) fn new(id: String, kind: JunctionKind, position: DVec3, declared: bool) -> Self {
        Self {
            id,
            kind,
            position,
            shape: Vec::new(),
            custom_shape: false,
            radius_m: None,
            name: None,
            incoming: Vec::new(),
            inside: Vec::new(),
            links: Vec::new(),
            other: Vec::new(),
            declared,
        }
    }
}

impl<'r> Names<'r> {
    /// Reads a junction with its rules, without its lanes.
    pub fn junction(&self, node: Element<'r>) -> Result<Junction, MapError> {
        let reader = self.reader;
        let kind = JunctionKind::from_name(node.attribute("type").unwrap_or_default());
        let kind = kind.ok_or_else(|| reader.value(node, "type", "a type of SUMO's junctions"))?;
        let z = if node.has_attribute("z") { reader.coordinate(node, "z")? } else { 0.0 };
        let position = dvec3(reader.coordinate(node, "x")?, reader.coordinate(node, "y")?, z);
        let mut junction = Junction::new(reader.text(node, "id")?.to_owned(), kind, position, true);
        if node.attribute("shape").is_some_and(|shape| !shape.trim().is_empty()) {
            junction.shape = reader.shape(node, 1)?;
        }
        junction.custom_shape = reader.truth(node, "customShape", false)?;
        junction.radius_m = reader.within_if_any(node, "radius", &(-1.0..=1e4), "a number from -1 to 10000 m")?;
        junction.name = node.attribute("name").map(str::to_owned);
        let known = ["id", "type", "x", "y", "z", "incLanes", "intLanes", "shape", "customShape", "radius", "name"];
        junction.other = self.others(node, &known);
        for request in node.children_named("request") {
            let set = |attribute: &str| LinkSet::from_bits(request.attribute(attribute).unwrap_or_default());
            junction.links.push(LinkRule {
                yields_to: set("response"),
                crosses: set("foes"),
                waits_inside: reader.truth(request, "cont", false)?,
                connection: None,
            });
        }
        Ok(junction)
    }

    /// Sets the lanes that a junction names.
    pub fn lanes_of_junction(&self, junction: &mut Junction, node: Element<'r>) -> Result<(), MapError> {
        junction.incoming = self.listed(node, "incLanes", &self.lanes, LANES_ALLOWED)?;
        junction.inside = self.listed(node, "intLanes", &self.lanes, LANES_ALLOWED)?;
        Ok(())
    }

    pub fn roundabout(&self, node: Element<'r>) -> Result<Roundabout, MapError> {
        Ok(Roundabout {
            junctions: self.listed(node, "nodes", &self.junctions, "ids of junctions of this network")?,
            edges: self.listed(node, "edges", &self.edges, "ids of edges of this network")?,
        })
    }

    /// Adds the railway signals that the file leaves to SUMO: one for each railway junction without a program.
    pub fn railway_signals(&mut self, net: &mut Network) {
        for (id, junction) in &self.junctions {
            let kind = net.junctions[junction.index()].kind;
            if matches!(kind, JunctionKind::RailSignal | JunctionKind::RailCrossing) && !self.signals.contains_key(id) {
                self.signals.insert(id, SignalId::from_index(net.signals.len()));
                net.signals.push(Signal { id: (*id).to_owned(), programs: Vec::new(), links: Vec::new() });
            }
        }
    }

    /// Reads a program of a signal, and adds the signal if it is new.
    pub fn signal(&mut self, net: &mut Network, node: Element<'r>) -> Result<(), MapError> {
        let reader = self.reader;
        let id = reader.text(node, "id")?;
        let kind = ProgramKind::from_name(node.attribute("type").unwrap_or_default());
        let seconds = |node: Element, attribute: &str| {
            reader.within_if_any(node, attribute, &(0.0..=1e9), "a number from 0 to 1e9, seconds")
        };
        let known = ["duration", "minDur", "maxDur", "state"];
        let mut phases = Vec::new();
        for phase in node.children_named("phase") {
            phases.push(SignalPhase {
                duration_s: seconds(phase, "duration")?.unwrap_or_default(),
                min_s: seconds(phase, "minDur")?,
                max_s: seconds(phase, "maxDur")?,
                state: phase.attribute("state").unwrap_or_default().to_owned(),
                other: self.others(phase, &known),
            });
        }
        let program = SignalProgram {
            id: node.attribute("programID").unwrap_or_default().to_owned(),
            kind: kind.ok_or_else(|| reader.value(node, "type", "a type of SUMO's signals"))?,
            offset_s: match node.attribute("offset").map(str::trim) {
                Some("begin") => None,
                None => Some(0.0),
                _ => Some(reader.within(node, "offset", &(-1e9..=1e9), "a number from -1e9 to 1e9, seconds")?),
            },
            phases,
            parameters: parameters(node),
        };
        let signal = *self.signals.entry(id).or_insert_with(|| {
            net.signals.push(Signal { id: id.to_owned(), programs: Vec::new(), links: Vec::new() });
            SignalId::from_index(net.signals.len() - 1)
        });
        let programs = &mut net.signals[signal.index()].programs;
        if programs.iter().any(|other| other.id == program.id) {
            return Err(reader.value(node, "programID", "a name that no other program of this signal has"));
        }
        programs.push(program);
        Ok(())
    }
}
