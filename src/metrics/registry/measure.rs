//! Type of the measures of the registry. In: name, unit, definition, source, roads and vehicles. Out: a [`Measure`], and its texts for
//! tables.

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

/// Vehicles over which a measure is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeasuredOver {
    /// The ego vehicle and its driver.
    Ego,
    /// All advised vehicles; in drives by a person the ego vehicle alone.
    AdvisedVehicles,
    /// All vehicles, the ego vehicle included.
    AllVehicles,
}

/// Kinds of roads in some drives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RoadKinds {
    /// A closed route with a fixed number of vehicles.
    pub closed: bool,
    /// A network on which vehicles enter and leave.
    pub networks: bool,
}

impl RoadKinds {
    /// Returns the kind of road of one drive; on an open road vehicles enter and leave.
    pub fn of_drive(is_open: bool) -> Self {
        Self { closed: !is_open, networks: is_open }
    }

    /// Returns the kinds of both.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self { closed: self.closed || other.closed, networks: self.networks || other.networks }
    }
}

/// Definition of a measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Measure {
    /// Name in tables, with the unit.
    pub name: &'static str,
    /// Title in figures and tables.
    pub title: &'static str,
    /// Unit in ASCII; empty without a unit.
    pub unit: &'static str,
    /// Definition with its options.
    pub about: &'static str,
    /// Publication or topic of docs/references.md; empty for a definition of this program.
    pub source: &'static str,
    /// Name and number in SAE J2944; `None` if it has no such measure, or none was found.
    pub j2944: Option<&'static str>,
    /// Roads on which the measure is taken.
    pub on: MeasuredOn,
    /// Vehicles over which the measure is taken.
    pub over: MeasuredOver,
    /// True if only drives with advice have the measure.
    pub needs_advice: bool,
}

/// Creates a measure of the ego vehicle on every road.
pub(super) const fn ego(name: &'static str, title: &'static str, unit: &'static str, about: &'static str) -> Measure {
    let (on, over) = (MeasuredOn::EveryRoad(""), MeasuredOver::Ego);
    Measure { name, title, unit, about, source: "", j2944: None, on, over, needs_advice: false }
}

/// Creates a measure of all vehicles on every road.
pub(super) const fn all_vehicles(
    name: &'static str,
    title: &'static str,
    unit: &'static str,
    about: &'static str,
) -> Measure {
    Measure { over: MeasuredOver::AllVehicles, ..ego(name, title, unit, about) }
}

/// Creates a measure of all advised vehicles on every road.
pub(super) const fn advised(
    name: &'static str,
    title: &'static str,
    unit: &'static str,
    about: &'static str,
) -> Measure {
    Measure { over: MeasuredOver::AdvisedVehicles, ..ego(name, title, unit, about) }
}

impl Measure {
    /// Sets the name in SAE J2944.
    pub(super) const fn in_j2944(self, name: &'static str) -> Self {
        Self { j2944: Some(name), ..self }
    }

    /// Sets the publication or topic of docs/references.md.
    pub(super) const fn by(self, source: &'static str) -> Self {
        Self { source, ..self }
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

    /// Returns the definition for drives on these roads, with the name in SAE J2944 if there is one.
    pub fn definition(&self, roads: RoadKinds) -> String {
        let there = match self.on {
            MeasuredOn::EveryRoad(about) if roads.networks && !about.is_empty() => format!("; on networks: {about}"),
            MeasuredOn::ClosedRoutes(why) if roads.networks => format!("; not on networks: {why}"),
            MeasuredOn::Networks if roads.closed => "; on networks alone".into(),
            _ => String::new(),
        };
        let name = self.j2944.map_or(String::new(), |name| format!(" (SAE J2944: {name})"));
        format!("{}{there}{name}", self.about)
    }

    /// Returns the texts of a column: name, quantity, unit, definition.
    pub const fn texts(&self) -> (&'static str, &'static str, &'static str, &'static str) {
        (self.name, self.title, self.unit, self.about)
    }

    /// Returns quantity and unit, as in the label of an axis or a table's head.
    pub fn label(&self) -> String {
        if self.unit.is_empty() { self.title.into() } else { format!("{}, {}", self.title, unit_text(self.unit)) }
    }
}

/// Returns a unit as it is printed: `m/s3` becomes m/s³.
pub fn unit_text(unit: &str) -> String {
    unit.replace("s2", "s²").replace("s3", "s³").replace('*', "·")
}
