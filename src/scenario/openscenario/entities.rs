//! Entities of OpenSCENARIO: vehicles and people. In: the element `<Entities>`. Out: their kinds and sizes. Metres.

use super::{document::Place, fault::OpenScenarioError, parameters::Node, reader::Reader};
use crate::traffic::VehicleKind;

/// Vehicle or person of a scenario.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Entity {
    pub name: String,
    pub kind: VehicleKind,
    pub length_m: f64,
    pub width_m: f64,
    pub height_m: f64,
    /// Distance from the reference point forward to the middle of the body, m.
    pub centre_m: f64,
    /// Largest acceleration and deceleration, m/s2.
    pub most_mps2: [Option<f64>; 2],
    pub place: Place,
}

impl Entity {
    /// Returns the distance from the reference point forward to the front, m.
    pub fn front_m(&self) -> f64 {
        self.centre_m + self.length_m / 2.0
    }

    /// Returns the distance from the reference point back to the rear, m.
    pub fn rear_m(&self) -> f64 {
        self.length_m / 2.0 - self.centre_m
    }
}

/// Categories of vehicles with the kinds that stand for them.
const VEHICLES: [(&str, VehicleKind); 6] = [
    ("car", VehicleKind::Car),
    ("van", VehicleKind::Van),
    ("truck", VehicleKind::Truck),
    ("bus", VehicleKind::Bus),
    ("motorbike", VehicleKind::Motorcycle),
    ("bicycle", VehicleKind::Bicycle),
];

impl Reader {
    /// Reads all entities; those of kinds that codrive does not have are reported.
    ///
    /// # Errors
    /// A name or a size is missing or malformed, or two entities have one name.
    pub fn entities(&mut self, node: &Node) -> Result<Vec<Entity>, OpenScenarioError> {
        self.expect(node, &[], &["ScenarioObject"])?;
        let mut found: Vec<Entity> = Vec::new();
        for object in node.all("ScenarioObject")? {
            let name = object.text("name")?;
            if self.entity_names.contains(&name) {
                return Err(object.fault(format!("another entity is named \"{name}\"; allowed: one for each")));
            }
            found.extend(self.object(&object, &name)?);
            self.entity_names.push(name);
        }
        Ok(found)
    }

    fn object(&mut self, object: &Node, name: &str) -> Result<Option<Entity>, OpenScenarioError> {
        let mut body = None;
        for child in object.children()? {
            match child.name() {
                "Vehicle" | "Pedestrian" => body = self.body(&child, name)?,
                "CatalogReference" => body = self.follow(&child, |reader, entry| reader.body(entry, name))?,
                "ObjectController" => self.problems.note(format!(
                    "{}:{}: the controller of {name} has no effect: codrive moves all but the participant's vehicle",
                    child.place().file.display(),
                    child.place().line
                )),
                _ => self.leave_out_unknown(&child),
            }
        }
        Ok(body)
    }

    fn body(&mut self, node: &Node, name: &str) -> Result<Option<Entity>, OpenScenarioError> {
        let kind = match node.name() {
            "Vehicle" => {
                let category = node.text("vehicleCategory")?;
                VEHICLES.iter().find(|(word, _)| *word == category).map(|(_, kind)| *kind)
            }
            "Pedestrian" => {
                let category = node.find_text("pedestrianCategory")?;
                category.is_none_or(|word| word == "pedestrian").then_some(VehicleKind::Pedestrian)
            }
            _ => None,
        };
        let Some(kind) = kind else {
            self.leave_out(node, format!("{name} is of a kind that codrive does not have, and is not there"));
            return Ok(None);
        };
        for child in node.children()?.iter().filter(|child| child.name() != "BoundingBox") {
            // A trailer without a name is none.
            let is_empty = child.name() == "Trailer" && self.names_no_trailer(child)?;
            if !is_empty {
                self.leave_out_unknown(child);
            }
        }
        let outline = node.child("BoundingBox")?;
        let (centre, size) = (outline.child("Center")?, outline.child("Dimensions")?);
        let entity = Entity {
            name: name.to_owned(),
            kind,
            length_m: size.number("length")?,
            width_m: size.number("width")?,
            height_m: size.number("height")?,
            centre_m: centre.number("x")?,
            most_mps2: limits_mps2(node)?,
            place: node.place().clone(),
        };
        let sizes = [("length", entity.length_m), ("width", entity.width_m), ("height", entity.height_m)];
        if let Some((part, size_m)) = sizes.iter().find(|(_, size_m)| !(0.0..=100.0).contains(size_m)) {
            return Err(size.fault(format!("{part} is {size_m}; allowed: 0 to 100 m")));
        }
        if entity.centre_m.abs() > entity.length_m {
            return Err(centre.fault(format!("x is {}; allowed: within the length of the body", entity.centre_m)));
        }
        Ok(Some(entity))
    }

    fn names_no_trailer(&self, trailer: &Node) -> Result<bool, OpenScenarioError> {
        let Some(reference) = trailer.find("TrailerRef")? else { return Ok(trailer.children()?.is_empty()) };
        Ok(reference.find_text("entityRef")?.is_none_or(|name| name.trim().is_empty()))
    }
}

/// Returns the largest acceleration and deceleration of a vehicle, m/s2; `None` for a limit that is not stated, or beyond all that a vehicle can do.
fn limits_mps2(node: &Node) -> Result<[Option<f64>; 2], OpenScenarioError> {
    const POSSIBLE_MPS2: std::ops::RangeInclusive<f64> = 0.1..=100.0;
    let Some(performance) = node.find("Performance")? else { return Ok([None; 2]) };
    let limit = |name: &str| Ok(performance.find_number(name)?.filter(|limit| POSSIBLE_MPS2.contains(limit)));
    Ok([limit("maxAcceleration")?, limit("maxDeceleration")?])
}
