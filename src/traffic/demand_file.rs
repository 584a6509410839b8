//! Looks through files of demand before SUMO has them. In: `rou.xml` files and the network. Out: nothing, or the first fault with file,
//! line, value and remedy. SUMO reads such a file little by little while the drive goes on: it would find an edge that is not there after
//! an hour, leave out vehicles that stand out of order without a word, and take 4 kB for each that waits. Files are read
//! element by element; one that is compressed (`.gz`) is left to SUMO.

use super::{
    Demand, DemandFault,
    demand_count::{self, DemandCount},
};
use crate::{
    file,
    map::network::{EdgeId, Network},
    toml_text::did_you_mean,
};
use quick_xml::{
    Reader, XmlVersion,
    events::{BytesStart, Event},
};
use std::{collections::BTreeMap, io::BufReader, path::Path};

/// The most vehicles that the files of a demand may bring together: two days of a thousand at a time, and 0.8 GB if all of them wait.
pub const MOST_VEHICLES: u64 = 200_000;
/// The most bytes of one file: room for what is too many vehicles to be counted.
pub const MOST_DEMAND_BYTES: u64 = 256 << 20;
/// Attributes that name one edge or several, of elements that SUMO drives along.
const EDGES: [&str; 4] = ["from", "to", "via", "edges"];

/// Fails at the first fault of a demand's files.
///
/// # Errors
/// A file cannot be read or is not XML, names an edge that the network has not or one that cannot be come to, has vehicles out of order, or all together bring more
/// than [`MOST_VEHICLES`] until a time, s.
pub(super) fn check(demand: &Demand, network: &Network, until_s: f64) -> Result<(), DemandFault> {
    let mut count = DemandCount::new(demand, until_s);
    if count.vehicles() > MOST_VEHICLES {
        return Err(DemandFault::FlowVehicles { value: count.vehicles(), until_s });
    }
    let mut ways = Ways { network, reached: BTreeMap::new() };
    for file in demand.files.iter().filter(|file| !file.to_string_lossy().ends_with(".gz")) {
        let mut scan = Scan { file, ways: &mut ways, line: 1, last_depart_s: 0.0, count: &mut count };
        scan.read()?;
        if count.vehicles() > MOST_VEHICLES {
            return Err(DemandFault::Vehicles { file: file.clone(), value: count.vehicles() });
        }
    }
    Ok(())
}

/// A file that is read.
struct Scan<'a, 'n> {
    file: &'a Path,
    ways: &'a mut Ways<'n>,
    /// Where the present element begins, from 1.
    line: u32,
    last_depart_s: f64,
    count: &'a mut DemandCount,
}

impl Scan<'_, '_> {
    fn read(&mut self) -> Result<(), DemandFault> {
        let unreadable = |problem: String| DemandFault::File { file: self.file.into(), problem };
        let open = file::open_regular(self.file).map_err(|error| unreadable(error.to_string()))?;
        let bytes = open.metadata().map_err(|error| unreadable(error.to_string()))?.len();
        if bytes > MOST_DEMAND_BYTES {
            return Err(unreadable(format!(
                "it holds {} MiB; allowed: at most {}{SHORTER}",
                bytes >> 20,
                MOST_DEMAND_BYTES >> 20
            )));
        }
        let mut reader = Reader::from_reader(BufReader::new(open));
        let mut buffer = Vec::new();
        loop {
            buffer.clear();
            match reader.read_event_into(&mut buffer) {
                Ok(Event::Eof) => return Ok(()),
                Ok(Event::Start(tag)) => self.element(&tag)?,
                Ok(Event::Empty(tag)) => {
                    self.element(&tag)?;
                    self.count.end(&String::from_utf8_lossy(tag.name().as_ref()));
                }
                Ok(Event::End(tag)) => self.count.end(&String::from_utf8_lossy(tag.name().as_ref())),
                Ok(_) => {}
                Err(error) => return Err(self.fault("this is not XML", error)),
            }
            self.line += buffer.iter().filter(|byte| **byte == b'\n').count() as u32;
        }
    }

    fn fault(&self, element: impl ToString, problem: impl ToString) -> DemandFault {
        let (element, problem) = (element.to_string(), problem.to_string());
        DemandFault::Element { file: self.file.into(), line: self.line, element, problem }
    }

    fn element(&mut self, tag: &BytesStart) -> Result<(), DemandFault> {
        let kind = String::from_utf8_lossy(tag.name().as_ref()).into_owned();
        let element = self.text(tag, "id")?.map_or(kind.clone(), |id| format!("{kind} \"{id}\""));
        let counted = self.count.begin(&kind, &|name| demand_count::text_of(tag, name));
        counted.map_err(|problem| self.fault(&element, problem))?;
        if !matches!(kind.as_str(), "trip" | "vehicle" | "flow" | "route") {
            return Ok(());
        }
        self.edges(tag, &element)?;
        self.departure(tag, if kind == "flow" { "begin" } else { "depart" }, &element)
    }

    fn text(&self, tag: &BytesStart, name: &str) -> Result<Option<String>, DemandFault> {
        let wrong = |error: quick_xml::Error| self.fault(name, error);
        let found = tag.try_get_attribute(name).map_err(|error| wrong(error.into()))?;
        let text = found.map(|attribute| attribute.normalized_value(XmlVersion::Implicit1_0).map(String::from));
        text.transpose().map_err(wrong)
    }

    fn number(&self, tag: &BytesStart, name: &str) -> Result<Option<f64>, DemandFault> {
        Ok(self.text(tag, name)?.and_then(|text| text.trim().parse().ok()))
    }

    /// The edges of an element: they are there, and a way leads from the first to the last.
    fn edges(&mut self, tag: &BytesStart, element: &str) -> Result<(), DemandFault> {
        let network = self.ways.network;
        for name in EDGES {
            let edges = self.text(tag, name)?.unwrap_or_default();
            if let Some(edge) = edges.split_whitespace().find(|edge| network.edge_named(edge).is_none()) {
                let known: Vec<&str> = network.edges().iter().map(|edge| edge.id.as_str()).collect();
                let near = did_you_mean(edge, &known);
                let problem = format!("{name} is \"{edge}\"; allowed: ids of edges of this network{near}");
                return Err(self.fault(element, problem));
            }
        }
        if let (Some(from), Some(to)) = (self.text(tag, "from")?, self.text(tag, "to")?)
            && let [Some(start), Some(goal)] = [&from, &to].map(|edge| network.edge_named(edge.trim()))
            && !self.ways.lead(start, goal)
        {
            let problem = format!("no way leads from \"{from}\" to \"{to}\"; allowed: edges that roads connect");
            return Err(self.fault(element, problem));
        }
        Ok(())
    }

    /// SUMO leaves out who departs before somebody that stands above.
    fn departure(&mut self, tag: &BytesStart, name: &str, element: &str) -> Result<(), DemandFault> {
        let Some(depart_s) = self.number(tag, name)? else { return Ok(()) };
        if depart_s < self.last_depart_s {
            let problem = format!(
                "departs at {depart_s} s, after one at {} s, and SUMO would leave it out; allowed: ascending times\n  \
                 remedy: sort the file with SUMO's tools/route/sort_routes.py",
                self.last_depart_s
            );
            return Err(self.fault(element, problem));
        }
        self.last_depart_s = depart_s;
        Ok(())
    }
}

/// Where roads lead, whoever may drive on them.
struct Ways<'n> {
    network: &'n Network,
    /// The edges that can be come to from one, a bit each.
    reached: BTreeMap<EdgeId, Vec<u64>>,
}

impl Ways<'_> {
    fn lead(&mut self, from: EdgeId, to: EdgeId) -> bool {
        let network = self.network;
        let reached = self.reached.entry(from).or_insert_with(|| {
            let mut reached = vec![0u64; network.edges().len().div_ceil(64)];
            let mut ahead = vec![from];
            while let Some(at) = ahead.pop() {
                let (word, bit) = (&mut reached[at.index() / 64], 1 << (at.index() % 64));
                if *word & bit == 0 {
                    *word |= bit;
                    let ways = network.edge(at).lanes().flat_map(|lane| network.connections_from(lane));
                    ahead.extend(ways.map(|way| network.lane(way.to).edge));
                }
            }
            reached
        });
        reached[to.index() / 64] & (1 << (to.index() % 64)) != 0
    }
}

/// What helps where a demand is too large.
pub(super) const SHORTER: &str = "\n  remedy: keep those that depart during the drive (SUMO's tools/route/cutRoutes.py), or state flows in the scenario";

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write;

    const TOWN: &str = "<net><edge id=\"north\" from=\"n\" to=\"m\"><lane id=\"north_0\" speed=\"9\" length=\"50\" shape=\"0,0 50,0\"/></edge>\
                        <edge id=\"south\" from=\"m\" to=\"n\"><lane id=\"south_0\" speed=\"9\" length=\"50\" shape=\"50,5 0,5\"/></edge>\
                        <connection from=\"north\" to=\"south\" fromLane=\"0\" toLane=\"0\"/></net>";

    fn said(text: &str) -> Result<(), String> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("town.rou.xml");
        std::fs::write(&file, text).unwrap();
        let network = Network::read(Path::new("town.net.xml"), TOWN).unwrap();
        check(&Demand { files: vec![file], flows: Vec::new() }, &network, 3600.0).map_err(|fault| fault.to_string())
    }

    #[test]
    fn a_fault_is_said_with_file_line_element_and_remedy_before_the_drive() {
        for (text, expected) in [
            (
                "<routes>\n<trip id=\"a\" depart=\"9\" from=\"north\" to=\"suoth\"/></routes>",
                "town.rou.xml:2: trip \"a\": to is \"suoth\"; allowed: ids of edges of this network (did you mean south?)",
            ),
            (
                "<routes>\n\n<vehicle id=\"b\" depart=\"9\">\n<route edges=\"north east\"/></vehicle></routes>",
                "town.rou.xml:4: route: edges is \"east\"",
            ),
            (
                "<routes><flow id=\"f\" begin=\"0\" end=\"9\" number=\"1\" from=\"x\" to=\"south\"/></routes>",
                ":1: flow \"f\": from is \"x\"",
            ),
            (
                "<routes>\n<trip id=\"a\" depart=\"9\" from=\"north\" to=\"south\"/>\n<trip id=\"b\" depart=\"8.5\" \
                 from=\"north\" to=\"south\"/></routes>",
                "town.rou.xml:3: trip \"b\": departs at 8.5 s, after one at 9 s, and SUMO would leave it out",
            ),
            (
                "<routes>\n<trip id=\"a\" depart=\"9\" from=\"south\" to=\"north\"/></routes>",
                "town.rou.xml:2: trip \"a\": no way leads from \"south\" to \"north\"; allowed: edges that roads connect",
            ),
            ("<routes>\n<trip id=\"a\" depart=\"9\"></routes>", "town.rou.xml:2: this is not XML"),
            (
                "<routes><flow id=\"f\" begin=\"0\" end=\"999\" from=\"north\" to=\"south\" number=\"200001\"/></routes>",
                "town.rou.xml:1: flow \"f\": number is \"200001\" brings 200001 until 3600 s; allowed: at most 200000",
            ),
        ] {
            let fault = said(text).expect_err(text);
            assert!(fault.contains(expected), "{expected:?} is not in: {fault}");
        }
        let good = "<routes><vType id=\"from\"/><trip id=\"a\" depart=\"9\" from=\"north\" to=\"south\" via=\"north south\"/>\
                    <trip id=\"b\" depart=\"triggered\" from=\"north\" to=\"south\"/>\
                    <trip id=\"c\" depart=\"9\" from=\"north\" to=\"south\"/></routes>";
        assert_eq!(said(good), Ok(()));
        let network = Network::read(Path::new("town.net.xml"), TOWN).unwrap();
        let absent = Demand { files: vec!["no.rou.xml".into()], flows: Vec::new() };
        let absent = check(&absent, &network, 3600.0).unwrap_err().to_string();
        assert!(absent.starts_with("no.rou.xml: "), "{absent}");
    }

    #[test]
    fn a_million_trips_are_counted_and_refused_with_what_helps() {
        let mut text = String::from("<routes>\n");
        for k in 0..1_000_000 {
            writeln!(text, "<trip id=\"{k}\" depart=\"0\" from=\"north\" to=\"south\"/>").unwrap();
        }
        let fault = said(&(text + "</routes>")).unwrap_err();
        assert!(
            fault.contains("town.rou.xml: the demand brings 1000000 vehicles and persons; allowed: at most 200000"),
            "{fault}"
        );
        assert!(fault.contains("remedy: keep those that depart during the drive"), "{fault}");
    }
}
