//! Definition of a measure. In: name, title, unit and options of a measure, and the roads on which it is taken. Out: its
//! definition in words for drives on these roads, and its value from the inputs of a drive.

use super::inputs::MeasureInputs;
use crate::analysis::text::unit_text;

/// Roads on which a measure is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeasuredOn {
    /// Every road; with the difference on a network, empty if there is none.
    EveryRoad(&'static str),
    /// Closed routes only; with the reason.
    ClosedRoutes(&'static str),
    /// Networks only, not closed routes.
    Networks,
}

/// Kinds of roads in some drives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RoadKinds {
    /// A closed route with a fixed number of vehicles.
    pub closed: bool,
    /// A network on which vehicles enter and leave.
    pub networks: bool,
}

/// Definition of a measure.
#[derive(Clone, Copy)]
pub struct MeasureDefinition {
    /// Name in tables, with the unit.
    pub name: &'static str,
    /// Title in figures and tables.
    pub title: &'static str,
    /// Unit in ASCII; empty without a unit.
    pub unit: &'static str,
    /// Definition with its options.
    pub about: &'static str,
    /// Name and number in SAE J2944; `None` if it has no such measure, or none was found.
    pub j2944: Option<&'static str>,
    /// Roads on which the measure is taken.
    pub on: MeasuredOn,
    /// True if only drives with advice have the measure.
    pub needs_advice: bool,
    /// Function that computes the measure.
    pub(super) of: fn(&MeasureInputs) -> Option<f64>,
}

impl MeasureDefinition {
    /// Creates a measure that is taken on all roads.
    pub(super) const fn new(
        name: &'static str,
        title: &'static str,
        unit: &'static str,
        about: &'static str,
        of: fn(&MeasureInputs) -> Option<f64>,
    ) -> Self {
        Self { name, title, unit, about, j2944: None, on: MeasuredOn::EveryRoad(""), needs_advice: false, of }
    }

    /// Sets the name in SAE J2944.
    pub(super) const fn in_j2944(self, name: &'static str) -> Self {
        Self { j2944: Some(name), ..self }
    }

    /// Restricts the measure to drives with advice.
    pub(super) const fn with_advice(self) -> Self {
        Self { needs_advice: true, ..self }
    }

    /// Sets the difference on a network.
    pub(super) const fn on_networks(self, about: &'static str) -> Self {
        Self { on: MeasuredOn::EveryRoad(about), ..self }
    }

    /// Restricts the measure to closed routes, with the reason.
    pub(super) const fn on_closed_routes(self, why: &'static str) -> Self {
        Self { on: MeasuredOn::ClosedRoutes(why), ..self }
    }

    /// Restricts the measure to networks.
    pub(super) const fn on_networks_alone(self) -> Self {
        Self { on: MeasuredOn::Networks, ..self }
    }

    /// Checks whether a drive on one of these roads may have the measure.
    pub fn is_on(&self, roads: RoadKinds) -> bool {
        match self.on {
            MeasuredOn::EveryRoad(_) => true,
            MeasuredOn::ClosedRoutes(_) => roads.closed,
            MeasuredOn::Networks => roads.networks,
        }
    }

    /// Checks whether tables of drives on these roads have a column of the measure. On a network, measures of closed routes
    /// keep an empty column, which the definition explains.
    pub fn has_column(&self, roads: RoadKinds) -> bool {
        roads.networks || self.on != MeasuredOn::Networks
    }

    /// Returns the definition for drives on these roads, with the name in SAE J2944.
    pub fn definition(&self, roads: RoadKinds) -> String {
        let there = match self.on {
            MeasuredOn::EveryRoad(about) if roads.networks && !about.is_empty() => format!("; on networks: {about}"),
            MeasuredOn::ClosedRoutes(why) if roads.networks => format!("; not on networks: {why}"),
            MeasuredOn::Networks if roads.closed => "; on networks alone".into(),
            _ => String::new(),
        };
        format!("{}{there} (SAE J2944: {})", self.about, self.j2944.unwrap_or("none"))
    }

    /// Returns quantity and unit, as in the label of an axis or a table's head.
    pub fn label(&self) -> String {
        if self.unit.is_empty() { self.title.into() } else { format!("{}, {}", self.title, unit_text(self.unit)) }
    }
}
