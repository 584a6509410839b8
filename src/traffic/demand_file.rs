//! Check of demand files before SUMO reads them. In: `rou.xml` files of users, and the network. Out: canonical copies in a private folder,
//! which SUMO reads in their place, or the first fault with file, line, value and remedy. Files pass the gate in front of SUMO
//! ([`crate::sumo_xml`]) element by element. SUMO itself would find a missing edge after an hour of driving, and would silently leave out
//! vehicles that are out of order.

use super::{Demand, DemandFault, demand_count::DemandCount, is_interrupted};
use crate::{
    data_folders,
    file::{SETTINGS_BYTES, read_bounded},
    map::network::{EdgeId, Network},
    private,
    sumo_xml::{
        self, Dropped, Problem,
        stream::{self, StreamError, Tag},
    },
    toml_text::did_you_mean,
};
use std::{
    collections::BTreeMap,
    io::{BufWriter, Write},
    path::{Path, PathBuf},
};

/// Maximum number of vehicles in a demand: two days with a thousand vehicles at a time, and 0.8 GB of memory if all of them wait.
pub const MOST_VEHICLES: u64 = 200_000;
/// Attributes with the ids of one or several edges, in elements that define routes.
const EDGES: [&str; 4] = ["from", "to", "via", "edges"];

/// Canonical copies of a demand's files.
#[derive(Debug, Default)]
pub struct CanonicalDemand {
    /// Paths of the copies, in the order of the files.
    pub files: Vec<PathBuf>,
    /// True if a file defines SUMO's default vehicle type.
    pub defines_default_type: bool,
    /// Parts that the copies leave out, by original file.
    pub dropped: Vec<(PathBuf, Dropped)>,
}

/// Writes canonical copies of a demand's files into `folder`, which is private and holds no demand yet.
///
/// # Errors
/// A file cannot be read or written; it has a part that is refused, a missing or unreachable edge, or vehicles out of order; the demand
/// brings more than [`MOST_VEHICLES`] before `until_s`, s; or the program was interrupted.
pub(super) fn copy(
    demand: &Demand,
    network: &Network,
    until_s: f64,
    folder: &Path,
) -> Result<CanonicalDemand, DemandFault> {
    let mut copies = CanonicalDemand::default();
    let mut count = DemandCount::new(demand, until_s);
    if count.vehicles() > MOST_VEHICLES {
        return Err(DemandFault::FlowVehicles { value: count.vehicles(), until_s });
    }
    let mut reachability = Reachability { network, reached: BTreeMap::new() };
    for (k, file) in demand.files.iter().enumerate() {
        let path = folder.join(format!("{k}.rou.xml"));
        let unwritable = |error: std::io::Error| DemandFault::File { file: file.clone(), problem: error.to_string() };
        let out = BufWriter::new(private::file(&path).map_err(unwritable)?);
        let mut scan = Scan {
            reachability: &mut reachability,
            last_depart_s: 0.0,
            count: &mut count,
            defines_default_type: false,
        };
        let copied = stream::copy(file, sumo_xml::demand(), out, &mut |tag| scan.element(tag));
        let (mut out, dropped) =
            copied.map_err(|error| if is_interrupted() { DemandFault::Interrupted } else { error.into() })?;
        out.flush().map_err(unwritable)?;
        if let Some(shipped) = shipped_bytes(file) {
            private::replace(&path, &shipped).map_err(unwritable)?;
        }
        copies.defines_default_type |= scan.defines_default_type;
        if count.vehicles() > MOST_VEHICLES {
            return Err(DemandFault::Vehicles { file: file.clone(), value: count.vehicles() });
        }
        copies.files.push(path);
        if !dropped.is_empty() {
            copies.dropped.push((file.clone(), dropped));
        }
    }
    Ok(copies)
}

/// Returns the bytes of a file shipped with the program, which SUMO gets unchanged; `None` for any other file.
fn shipped_bytes(file: &Path) -> Option<Vec<u8>> {
    read_bounded(file, SETTINGS_BYTES).ok().filter(|bytes| data_folders::is_shipped_for_sumo(bytes))
}

impl From<StreamError> for DemandFault {
    fn from(error: StreamError) -> Self {
        match error {
            StreamError::File { file, problem } => Self::File { file, problem },
            StreamError::Element { file, line, problem: Problem { element, problem } } => {
                Self::Element { file, line, element, problem }
            }
        }
    }
}

/// State of the reading of one file.
struct Scan<'a, 'n> {
    reachability: &'a mut Reachability<'n>,
    last_depart_s: f64,
    count: &'a mut DemandCount,
    defines_default_type: bool,
}

fn number(tag: &Tag, name: &str) -> Option<f64> {
    tag.attribute(name)?.trim().parse().ok()
}

impl Scan<'_, '_> {
    fn element(&mut self, tag: &Tag) -> Result<(), Problem> {
        if is_interrupted() {
            return Err(Problem { element: tag.label(), problem: "interrupted".into() });
        }
        self.count.add(tag).map_err(|problem| Problem { element: tag.label(), problem })?;
        match tag.name.as_str() {
            "trip" | "vehicle" | "flow" | "route" => {}
            "vType" => {
                self.defines_default_type |= tag.attribute("id") == Some(super::demand::DEFAULT_TYPE);
                return Ok(());
            }
            _ => return Ok(()),
        }
        let faults = self.edges(tag).and_then(|()| self.departure(tag));
        faults.map_err(|problem| Problem { element: tag.label(), problem })
    }

    /// Checks that the edges of an element exist and that a route leads from `from` to `to`.
    fn edges(&mut self, tag: &Tag) -> Result<(), String> {
        let network = self.reachability.network;
        for name in EDGES {
            let edges = tag.attribute(name).unwrap_or_default();
            if let Some(edge) = edges.split_whitespace().find(|edge| network.edge_named(edge).is_none()) {
                let known: Vec<&str> = network.edges().iter().map(|edge| edge.id.as_str()).collect();
                let near = did_you_mean(edge, &known);
                return Err(format!("{name} is \"{edge}\"; allowed: ids of edges of this network{near}"));
            }
        }
        if let (Some(from), Some(to)) = (tag.attribute("from"), tag.attribute("to"))
            && let [Some(start), Some(goal)] = [from, to].map(|edge| network.edge_named(edge.trim()))
            && !self.reachability.lead(start, goal)
        {
            return Err(format!("no route leads from \"{from}\" to \"{to}\"; allowed: edges that roads connect"));
        }
        Ok(())
    }

    /// Checks that departure times ascend: SUMO leaves out a vehicle that departs before one above it in the file.
    fn departure(&mut self, tag: &Tag) -> Result<(), String> {
        let Some(depart_s) = number(tag, if tag.name == "flow" { "begin" } else { "depart" }) else { return Ok(()) };
        if depart_s < self.last_depart_s {
            return Err(format!(
                "departs at {depart_s} s, after a departure at {} s, so SUMO would leave it out; allowed: ascending \
                 times\n  remedy: sort the file with SUMO's tools/route/sort_routes.py",
                self.last_depart_s
            ));
        }
        self.last_depart_s = depart_s;
        Ok(())
    }
}

/// Reachability between edges, regardless of permissions.
struct Reachability<'n> {
    network: &'n Network,
    /// Edges reachable from an edge, one bit each.
    reached: BTreeMap<EdgeId, Vec<u64>>,
}

impl Reachability<'_> {
    fn lead(&mut self, from: EdgeId, to: EdgeId) -> bool {
        let network = self.network;
        let reached = self.reached.entry(from).or_insert_with(|| {
            let mut reached = vec![0u64; network.edges().len().div_ceil(64)];
            let mut ahead = vec![from];
            while let Some(at) = ahead.pop() {
                let (word, bit) = (&mut reached[at.index() / 64], 1 << (at.index() % 64));
                if *word & bit == 0 {
                    *word |= bit;
                    let reachability = network.edge(at).lanes().flat_map(|lane| network.connections_from(lane));
                    ahead.extend(reachability.map(|way| network.lane(way.to).edge));
                }
            }
            reached
        });
        reached[to.index() / 64] & (1 << (to.index() % 64)) != 0
    }
}

/// Remedy for a demand that is too large.
pub(super) const SHORTER: &str = "\n  remedy: keep only departures during the drive (SUMO's tools/route/cutRoutes.py), or state flows in the \
     scenario";

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write;

    const TOWN: &str = "<net><edge id=\"north\" from=\"n\" to=\"m\"><lane id=\"north_0\" speed=\"9\" length=\"50\" shape=\"0,0 50,0\"/></edge>\
                        <edge id=\"south\" from=\"m\" to=\"n\"><lane id=\"south_0\" speed=\"9\" length=\"50\" shape=\"50,5 0,5\"/></edge>\
                        <connection from=\"north\" to=\"south\" fromLane=\"0\" toLane=\"0\"/></net>";

    fn check_text(text: &str) -> Result<(), String> {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("town.rou.xml");
        std::fs::write(&file, text).unwrap();
        let network = Network::read(Path::new("town.net.xml"), TOWN).unwrap();
        copy(&Demand { files: vec![file], flows: Vec::new() }, &network, 3600.0, folder.path())
            .map(drop)
            .map_err(|fault| fault.to_string())
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
                "<routes><flow id=\"f\" begin=\"0\" end=\"9\" number=\"3\" from=\"x\" to=\"south\"/></routes>",
                ":1: flow \"f\": from is \"x\"",
            ),
            (
                "<routes>\n<trip id=\"a\" depart=\"9\" from=\"north\" to=\"south\"/>\n<trip id=\"b\" depart=\"8.5\" \
                 from=\"north\" to=\"south\"/></routes>",
                "town.rou.xml:3: trip \"b\": departs at 8.5 s, after a departure at 9 s, so SUMO would leave it out",
            ),
            (
                "<routes>\n<trip id=\"a\" depart=\"9\" from=\"south\" to=\"north\"/></routes>",
                "town.rou.xml:2: trip \"a\": no route leads from \"south\" to \"north\"; allowed: edges that roads \
                 connect",
            ),
            ("<routes>\n<trip id=\"a\" depart=\"9\"></routes>", "town.rou.xml:2: this is not XML"),
            (
                "<routes><flow id=\"f\" begin=\"0\" end=\"3600\" from=\"north\" to=\"south\" number=\"200001\"/></routes>",
                "town.rou.xml:1: flow \"f\": number is \"200001\" brings 200001 until 3600 s; allowed: at most 200000",
            ),
        ] {
            let fault = check_text(text).expect_err(text);
            assert!(fault.contains(expected), "{expected:?} is not in: {fault}");
        }
        let good = "<routes><vType id=\"from\"/><trip id=\"a\" depart=\"9\" from=\"north\" to=\"south\" via=\"north south\"/>\
                    <trip id=\"b\" depart=\"triggered\" from=\"north\" to=\"south\"/>\
                    <trip id=\"c\" depart=\"9\" from=\"north\" to=\"south\"/></routes>";
        assert_eq!(check_text(good), Ok(()));
        let network = Network::read(Path::new("town.net.xml"), TOWN).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let absent = Demand { files: vec!["no.rou.xml".into()], flows: Vec::new() };
        let absent = copy(&absent, &network, 3600.0, folder.path()).unwrap_err().to_string();
        assert!(absent.starts_with("no.rou.xml: "), "{absent}");
    }

    #[test]
    fn a_million_trips_are_counted_and_refused_with_what_helps() {
        let mut text = String::from("<routes>\n");
        for k in 0..1_000_000 {
            writeln!(text, "<trip id=\"{k}\" depart=\"0\" from=\"north\" to=\"south\"/>").unwrap();
        }
        let fault = check_text(&(text + "</routes>")).unwrap_err();
        assert!(
            fault.contains("town.rou.xml: the demand has 1000000 vehicles and persons; allowed: at most 200000"),
            "{fault}"
        );
        assert!(fault.contains("remedy: keep only departures during the drive"), "{fault}");
    }
}
