//! Names of the vehicles and persons of a demand. In: its flows and the elements of its files. Out: whether a vehicle can have a name.
//!
//! SUMO numbers the vehicles of a flow: `f.0` and `f.1` of a flow `f`. It names those that a calibrator adds in the same way. The vehicle of a
//! person `p` who drives is `p_0`.

use super::{Demand, DemandFault, demand_file::FileKind};
use crate::{
    sumo_xml::stream::{self, Tag},
    toml_text::nearest,
};
use std::{collections::BTreeSet, io};

/// Names of a demand.
#[derive(Debug, Default)]
pub struct DemandNames {
    /// Names of single vehicles and persons.
    single: BTreeSet<String>,
    /// Names of what brings several of them.
    series: BTreeSet<String>,
}

impl DemandNames {
    /// Reads the files of a demand, through the gate in front of SUMO.
    ///
    /// # Errors
    /// A file cannot be read, or has a part that is refused.
    pub fn of(demand: &Demand) -> Result<Self, DemandFault> {
        let mut names = Self { series: demand.flow_names().collect(), ..Self::default() };
        for (file, kind) in demand.input_files().zip(FileKind::of(demand)) {
            let mut look = |tag: &Tag| {
                names.add(tag);
                Ok(())
            };
            stream::copy_with(file, kind.vocabulary(), io::sink(), &mut look, demand.leave_out_faults)?;
        }
        Ok(names)
    }

    fn add(&mut self, tag: &Tag) {
        let names = match tag.name.as_str() {
            "vehicle" | "trip" | "person" => &mut self.single,
            "flow" | "personFlow" | "calibrator" => &mut self.series,
            _ => return,
        };
        names.extend(tag.attribute("id").map(str::to_owned));
    }

    /// Checks whether a vehicle or person of the demand can have a name.
    pub fn has(&self, name: &str) -> bool {
        let numbered = |letter: char| {
            let (of, number) = name.rsplit_once(letter)?;
            (!number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit())).then_some(of)
        };
        self.single.contains(name)
            || numbered('.').is_some_and(|of| self.series.contains(of))
            || numbered('_').is_some_and(|person| self.has(person))
    }

    /// Returns the nearest name, if one is near.
    pub fn nearest(&self, name: &str) -> Option<String> {
        let near = |name, known: &BTreeSet<String>| {
            let known: Vec<&str> = known.iter().map(String::as_str).collect();
            nearest(name, &known).map(str::to_owned)
        };
        let numbered = name.rsplit_once('.').filter(|(_, number)| number.parse::<u32>().is_ok());
        let (series, number) = numbered.unwrap_or((name.rsplit_once('.').map_or(name, |(series, _)| series), "0"));
        near(name, &self.single).or_else(|| Some(format!("{}.{number}", near(series, &self.series)?)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::traffic::{Flow, KindShare, VehicleKind};

    #[test]
    fn a_demand_knows_the_names_that_sumo_gives() {
        let folder = tempfile::tempdir().unwrap();
        let [routes, additional] = ["a.rou.xml", "a.add.xml"].map(|name| folder.path().join(name));
        let person = "<person id=\"ann\" depart=\"4\"><walk edges=\"a\"/></person>";
        let text = format!(
            "<routes><vType id=\"slow\"/><trip id=\"bus 7\" depart=\"1\" from=\"a\" to=\"b\"/>\
             <vehicle id=\"v\" depart=\"2\"><route edges=\"a b\"/></vehicle>\
             <flow id=\"f\" begin=\"3\" end=\"9\" number=\"2\" from=\"a\" to=\"b\"/>{person}</routes>"
        );
        std::fs::write(&routes, text).unwrap();
        std::fs::write(&additional, "<additional><vType id=\"fast\"/></additional>").unwrap();
        let mix =
            vec![KindShare { kind: VehicleKind::Car, share: 0.0 }, KindShare { kind: VehicleKind::Truck, share: 1.0 }];
        let flow = Flow { from: "a".into(), to: "b".into(), per_hour: 60.0, mix };
        let demand = Demand {
            files: vec![routes],
            additional_files: vec![additional],
            flows: vec![Flow { mix: Vec::new(), ..flow.clone() }, flow],
            ..Demand::default()
        };
        let names = DemandNames::of(&demand).unwrap_or_else(|fault| panic!("{fault}"));
        for name in ["bus 7", "v", "f.0", "f.17", "ann", "ann_0", "flow0.car.3", "flow1.truck.0"] {
            assert!(names.has(name), "{name}");
        }
        for name in ["f", "f.", "f.x", "bus", "slow", "fast", "flow1.car.0", "flow0.car", "_0", ""] {
            assert!(!names.has(name), "{name}");
        }
        let near = |name: &str| names.nearest(name);
        assert_eq!([near("bus 77"), near("anne"), near("queue")], [Some("bus 7".into()), Some("ann".into()), None]);
        assert_eq!([near("flow1.trick.12"), near("f")], [Some("flow1.truck.12".into()), Some("f.0".into())]);
        assert_eq!(near("flow1.truck.x"), Some("flow1.truck.0".into()), "a name that can be there");
    }
}
