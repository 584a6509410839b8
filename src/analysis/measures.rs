//! Measures of one drive. In: its totals, and optionally the totals of the same drive without advice. Out: [`DriveMeasures`].
//! Each measure is over the whole trial unless its row in [`MEASURES`] says otherwise. The two lists that make it up
//! (`measure_list` and `network::measures`) are the only places that name the measures.

pub(super) use super::measure_inputs::{deviation, median};
use super::{
    AnalysedRecording, RecordedTrial, glossary::unit_text, measure_inputs::MeasureInputs, measure_list::OF_EVERY_DRIVE,
    network::measures::OF_NETWORKS, response_detection::AdviceResponse, totals::DriveTotals,
};

/// Measures of a drive; `None` where there is nothing to measure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DriveMeasures {
    /// Values in the order of [`MEASURES`].
    pub values: Vec<Option<f64>>,
    /// Responses to every change of the advice, events and shams included.
    pub responses: Vec<AdviceResponse>,
}

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

impl RoadKinds {
    /// Returns the kinds of roads of these drives.
    pub fn of<'a>(drives: impl IntoIterator<Item = &'a AnalysedRecording>) -> Self {
        drives.into_iter().fold(Self::default(), |kinds, drive| {
            let is_network = drive.setup.scenario.has_path_or_demand();
            Self { closed: kinds.closed || !is_network, networks: kinds.networks || is_network }
        })
    }
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
    of: fn(&MeasureInputs) -> Option<f64>,
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

/// All measures: first `OF_EVERY_DRIVE`, then `OF_NETWORKS`.
pub const MEASURES: &[MeasureDefinition] = &joined::<{ OF_EVERY_DRIVE.len() + OF_NETWORKS.len() }>();

const fn joined<const N: usize>() -> [MeasureDefinition; N] {
    let mut all = [OF_EVERY_DRIVE[0]; N];
    let mut i = 1;
    while i < N {
        all[i] = if i < OF_EVERY_DRIVE.len() { OF_EVERY_DRIVE[i] } else { OF_NETWORKS[i - OF_EVERY_DRIVE.len()] };
        i += 1;
    }
    all
}

impl DriveMeasures {
    /// Computes the measures of a drive from its totals and responses and the totals of the same drive without advice.
    pub fn of(
        trial: &RecordedTrial,
        totals: &DriveTotals,
        responses: Vec<AdviceResponse>,
        baseline: Option<&DriveTotals>,
    ) -> Self {
        let sight = MeasureInputs { trial, totals, baseline, responses: &responses };
        let is_network = trial.is_on_network();
        let roads = RoadKinds { closed: !is_network, networks: is_network };
        let value = |measure: &MeasureDefinition| (measure.of)(&sight).filter(|_| measure.is_on(roads));
        Self { values: MEASURES.iter().map(value).collect(), responses }
    }

    /// Returns the value of a measure by its name.
    pub fn get(&self, name: &str) -> Option<f64> {
        let at = MEASURES.iter().position(|measure| measure.name == name)?;
        self.values.get(at).copied().flatten()
    }
}

#[cfg(test)]
#[path = "measures_tests.rs"]
mod tests;
