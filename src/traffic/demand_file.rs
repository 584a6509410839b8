//! Check of demand files before SUMO reads them. In: `rou.xml` files of users, and the network. Out: canonical copies in a private folder,
//! which SUMO reads in their place, or the first fault with file, line, value and remedy. Files pass the gate in front of SUMO
//! ([`crate::sumo_xml`]) element by element. SUMO itself would find a missing edge after an hour of driving, and would silently leave out
//! vehicles that are out of order.

use super::{
    Demand, DemandFault,
    demand_count::{DemandCount, Departures},
    demand_references::DemandReferences,
    is_interrupted,
};
use crate::{
    data_folders,
    file::{SETTINGS_BYTES, read_bounded},
    map::network::Network,
    private,
    sumo_xml::{
        self, Dropped, Problem, Vocabulary,
        stream::{self, LeftOut, StreamError, Tag},
    },
};
use std::{
    io::{BufWriter, Write},
    path::{Path, PathBuf},
};

/// Maximum number of vehicles in a demand: two days with a thousand vehicles at a time, and 0.8 GB of memory if all of them wait.
pub const MOST_VEHICLES: u64 = 200_000;

/// Canonical copies of a demand's files.
#[derive(Debug, Default)]
pub struct CanonicalDemand {
    /// The demand, with the paths of the copies in place of its files.
    pub demand: Demand,
    /// True if a file defines SUMO's default vehicle type.
    pub defines_default_type: bool,
    /// Parts that the copies leave out, by original file.
    pub dropped: Vec<(PathBuf, Dropped)>,
    /// Elements that the copies leave out because of a fault, by original file.
    pub left_out: Vec<(PathBuf, LeftOut)>,
    /// First and last departures of the files, and of the demand's own flows.
    pub departures: Departures,
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
    let mut copies = CanonicalDemand { demand: demand.clone(), ..CanonicalDemand::default() };
    let mut count = DemandCount::new(demand, until_s);
    if count.vehicles() > MOST_VEHICLES {
        return Err(DemandFault::FlowVehicles { value: count.vehicles(), until_s });
    }
    let mut references = DemandReferences::new(network);
    let kinds = FileKind::of(demand);
    for (k, ((file, copied), kind)) in demand.input_files().zip(copies.demand.input_files_mut()).zip(kinds).enumerate()
    {
        let path = folder.join(format!("{k}.{}.xml", kind.name()));
        let unwritable = |error: std::io::Error| DemandFault::File { file: file.clone(), problem: error.to_string() };
        let out = BufWriter::new(private::file(&path).map_err(unwritable)?);
        let mut scan = Scan {
            references: &mut references,
            last_depart_s: (kind == FileKind::Routes).then_some(0.0),
            count: &mut count,
            defines_default_type: false,
        };
        let is_lenient = demand.leave_out_faults;
        let written = stream::copy_with(file, kind.vocabulary(), out, &mut |tag| scan.element(tag), is_lenient);
        if is_interrupted() {
            return Err(DemandFault::Interrupted);
        }
        let (mut out, dropped, left_out) = written?;
        out.flush().map_err(unwritable)?;
        if let Some(shipped) = shipped_bytes(file) {
            private::replace(&path, &shipped).map_err(unwritable)?;
        }
        copies.defines_default_type |= scan.defines_default_type;
        if count.vehicles() > MOST_VEHICLES {
            return Err(DemandFault::Vehicles { file: file.clone(), value: count.vehicles() });
        }
        *copied = path;
        if left_out.count > 0 {
            copies.left_out.push((file.clone(), left_out));
        }
        if !dropped.is_empty() {
            copies.dropped.push((file.clone(), dropped));
        }
    }
    copies.departures = count.departures();
    Ok(copies)
}

/// Kind of a file of a demand.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum FileKind {
    /// Read at the start, in any order of departures.
    Additional,
    /// Read as the drive goes on, by ascending times of departure.
    Routes,
}

impl FileKind {
    /// Returns the kinds of a demand's files, in their order ([`Demand::input_files`]).
    pub fn of(demand: &Demand) -> impl Iterator<Item = Self> {
        let additional = demand.additional_files.iter().map(|_| Self::Additional);
        additional.chain(demand.files.iter().map(|_| Self::Routes))
    }

    /// Returns the middle of the file names that SUMO's documentation uses.
    fn name(self) -> &'static str {
        match self {
            Self::Additional => "add",
            Self::Routes => "rou",
        }
    }

    /// Returns the elements that the gate lets through.
    pub fn vocabulary(self) -> &'static Vocabulary {
        match self {
            Self::Additional => sumo_xml::additional(),
            Self::Routes => sumo_xml::demand(),
        }
    }
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
    references: &'a mut DemandReferences<'n>,
    /// Time of the last departure, s; `None` where departures may be in any order.
    last_depart_s: Option<f64>,
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
        self.defines_default_type |= tag.name == "vType" && tag.attribute("id") == Some(super::demand::DEFAULT_TYPE);
        let faults = self.references.check(tag).and_then(|()| self.departure(tag));
        faults.map_err(|problem| Problem { element: tag.label(), problem })
    }

    /// Checks that departure times ascend: SUMO leaves out a vehicle or person that departs before one above it in the file. Vehicles of a
    /// line, which SUMO reads ahead, may be followed by earlier departures.
    fn departure(&mut self, tag: &Tag) -> Result<(), String> {
        let name = match tag.name.as_str() {
            "flow" | "personFlow" => "begin",
            "trip" | "vehicle" | "person" => "depart",
            _ => return Ok(()),
        };
        let (Some(last_s), Some(depart_s)) = (self.last_depart_s, number(tag, name)) else { return Ok(()) };
        if depart_s < last_s {
            return Err(format!(
                "departs at {depart_s} s, after a departure at {} s, so SUMO would leave it out; allowed: ascending \
                 times\n  remedy: sort the file with SUMO's tools/route/sort_routes.py",
                last_s
            ));
        }
        if tag.attribute("line").is_none_or(str::is_empty) {
            self.last_depart_s = Some(depart_s);
        }
        Ok(())
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
        copy(&Demand { files: vec![file], ..Demand::default() }, &network, 3600.0, folder.path())
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
            (
                "<routes>\n<vehicle id=\"b\" depart=\"9\"><route edges=\"south north\"/></vehicle></routes>",
                "town.rou.xml:2: route: no road leads from edge \"south\" to \"north\"; allowed after it: none, it is an end",
            ),
            (
                "<routes><vehicle id=\"b\" depart=\"9\"><route edges=\"north north\"/></vehicle></routes>",
                "no road leads from edge \"north\" to \"north\"; allowed after it: south",
            ),
            (
                "<routes><trip id=\"a\" depart=\"9\" from=\"north\" to=\"south\">\n<stop lane=\"north_1\" endPos=\"9\"/></trip></routes>",
                "town.rou.xml:2: stop: lane is \"north_1\"; allowed on this edge: north_0",
            ),
            (
                "<routes><trip id=\"a\" depart=\"9\" from=\"north\" to=\"south\"><stop busStop=\"central\"/></trip></routes>",
                "busStop is \"central\"; allowed: the id of a stopping place of the additional_files in [demand]",
            ),
            (
                "<routes><vType id=\"slow\"/>\n<trip id=\"a\" depart=\"9\" type=\"slwo\" from=\"north\" to=\"south\"/></routes>",
                "town.rou.xml:2: trip \"a\": type is \"slwo\"; allowed: the id of a vType or a vTypeDistribution above it (did you mean slow?)",
            ),
            (
                "<routes><vehicle id=\"a\" depart=\"9\" route=\"r1\"/></routes>",
                "vehicle \"a\": route is \"r1\"; allowed: the id of a route or a routeDistribution above it",
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
        let absent = Demand { files: vec!["no.rou.xml".into()], ..Demand::default() };
        let absent = copy(&absent, &network, 3600.0, folder.path()).unwrap_err().to_string();
        assert!(absent.starts_with("no.rou.xml: "), "{absent}");
    }

    #[test]
    fn departures_may_come_before_those_of_a_line_and_of_nothing_else() {
        let trips = |first: &str, second: &str| {
            let ends = "from=\"north\" to=\"south\"";
            check_text(&format!("<routes><{first} {ends}/>\n<{second} {ends}/></routes>"))
        };
        let bus = "flow id=\"bus\" line=\"19\" begin=\"180\" end=\"900\" period=\"300\"";
        let car = "trip id=\"car\" depart=\"60\"";
        assert_eq!(trips(bus, car), Ok(()));
        let late = "trip id=\"late\" depart=\"180\"";
        let early = "flow id=\"bus\" line=\"19\" begin=\"60\" end=\"900\" period=\"300\"";
        for second in [car, early] {
            assert!(
                trips(late, second).is_err_and(|fault| fault.contains("departs at 60 s, after a departure at 180 s"))
            );
        }
    }

    #[test]
    fn a_vehicle_that_departs_before_a_person_above_it_is_named() {
        let person = "<person id=\"p\" depart=\"180\"><walk edges=\"north\"/></person>";
        let text = format!("<routes>{person}\n<trip id=\"a\" depart=\"9\" from=\"north\" to=\"south\"/></routes>");
        let fault = check_text(&text).expect_err("SUMO leaves it out");
        assert!(fault.contains("trip \"a\": departs at 9 s, after a departure at 180 s"), "{fault}");
    }

    #[test]
    fn faulty_elements_are_left_out_and_named_where_a_demand_says_so() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("town.rou.xml");
        let good = "<trip id=\"a\" depart=\"9\" from=\"north\" to=\"south\"/>";
        let text = format!(
            "<routes>\n<trip id=\"x\" depart=\"1\" from=\"north\" to=\"nowhere\"/>\n{good}\n<vehicle id=\"b\" depart=\"9\">\
             <route edges=\"south north\"/><stop lane=\"north_0\"/></vehicle><trip id=\"c\" depart=\"3\" from=\"north\" to=\"south\"/></routes>"
        );
        std::fs::write(&file, text).unwrap();
        let network = Network::read(Path::new("town.net.xml"), TOWN).unwrap();
        let demand = Demand { files: vec![file], leave_out_faults: true, ..Demand::default() };
        let copies = folder.path().join("copies");
        std::fs::create_dir(&copies).unwrap();
        let found = copy(&demand, &network, 3600.0, &copies).unwrap();
        let kept = std::fs::read_to_string(&found.demand.files[0]).unwrap();
        assert_eq!(kept, format!("{}<routes>\n    {good}\n</routes>\n", sumo_xml::DECLARATION));
        let (_, LeftOut { count, first }) = &found.left_out[0];
        assert!(*count == 3 && first.contains("town.rou.xml:2: trip \"x\": to is \"nowhere\""), "{count}: {first}");
        let strict = copy(&Demand { leave_out_faults: false, ..demand }, &network, 3600.0, folder.path());
        assert!(strict.unwrap_err().to_string().contains("to is \"nowhere\""));
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
