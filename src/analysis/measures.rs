//! One drive in numbers. In: its totals, and those of the same drive without advice where there is one. Out: [`DriveMeasures`]. Each
//! is over the whole trial unless its row in [`MEASURES`] says otherwise; the lists of which that is made (`measure_list`, and
//! `network::measures`) are the only places that name them.

pub(super) use super::measure_inputs::{deviation, median};
use super::{
    AnalysedRecording, RecordedTrial, glossary::unit_text, measure_inputs::MeasureInputs, measure_list::OF_EVERY_DRIVE,
    network::measures::OF_NETWORKS, response::AdviceResponse, totals::DriveTotals,
};

/// A drive in numbers; `None` where there is nothing to measure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DriveMeasures {
    /// Values in the order of [`MEASURES`].
    pub values: Vec<Option<f64>>,
    /// What became of every change of the advice.
    pub responses: Vec<AdviceResponse>,
}

/// On which roads a measure is taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeasuredOn {
    /// On all; what is different on a network, empty if nothing is.
    EveryRoad(&'static str),
    /// Not on networks; why.
    ClosedRoutes(&'static str),
    /// On networks alone.
    Networks,
}

/// Roads of some drives.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RoadKinds {
    /// A closed route with a fixed number of cars.
    pub closed: bool,
    /// A network on which vehicles come and go.
    pub networks: bool,
}

impl RoadKinds {
    /// Those of these drives.
    pub fn of<'a>(drives: impl IntoIterator<Item = &'a AnalysedRecording>) -> Self {
        drives.into_iter().fold(Self::default(), |kinds, drive| {
            let is_network = drive.setup.scenario.is_on_network();
            Self { closed: kinds.closed || !is_network, networks: kinds.networks || is_network }
        })
    }
}

/// A measure.
#[derive(Clone, Copy)]
pub struct MeasureDefinition {
    /// Its name in tables, with the unit.
    pub name: &'static str,
    /// In words, for figures.
    pub title: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Definition with its options.
    pub about: &'static str,
    /// Its name and number in SAE J2944; `None` where the practice has no such measure, or none that is known here.
    pub j2944: Option<&'static str>,
    /// On which roads it is taken.
    pub on: MeasuredOn,
    /// Only a drive with advice has it.
    pub needs_advice: bool,
    of: fn(&MeasureInputs) -> Option<f64>,
}

impl MeasureDefinition {
    /// A measure of all roads.
    pub(super) const fn new(
        name: &'static str,
        title: &'static str,
        unit: &'static str,
        about: &'static str,
        of: fn(&MeasureInputs) -> Option<f64>,
    ) -> Self {
        Self { name, title, unit, about, j2944: None, on: MeasuredOn::EveryRoad(""), needs_advice: false, of }
    }

    /// What it is called in SAE J2944.
    pub(super) const fn in_j2944(self, name: &'static str) -> Self {
        Self { j2944: Some(name), ..self }
    }

    /// Measure of drives with advice alone.
    pub(super) const fn with_advice(self) -> Self {
        Self { needs_advice: true, ..self }
    }

    /// What is different on a network.
    pub(super) const fn on_networks(self, about: &'static str) -> Self {
        Self { on: MeasuredOn::EveryRoad(about), ..self }
    }

    /// It is not taken on networks.
    pub(super) const fn on_closed_routes(self, why: &'static str) -> Self {
        Self { on: MeasuredOn::ClosedRoutes(why), ..self }
    }

    /// It is taken on networks alone.
    pub(super) const fn on_networks_alone(self) -> Self {
        Self { on: MeasuredOn::Networks, ..self }
    }

    /// True if a drive on one of these roads may have it.
    pub fn is_on(&self, roads: RoadKinds) -> bool {
        match self.on {
            MeasuredOn::EveryRoad(_) => true,
            MeasuredOn::ClosedRoutes(_) => roads.closed,
            MeasuredOn::Networks => roads.networks,
        }
    }

    /// True if tables of drives on these roads have a column of it: of what is not taken on their roads it is empty, and says why.
    pub fn has_column(&self, roads: RoadKinds) -> bool {
        roads.networks || self.on != MeasuredOn::Networks
    }

    /// The definition for drives on these roads, with the name in SAE J2944.
    pub fn definition(&self, roads: RoadKinds) -> String {
        let there = match self.on {
            MeasuredOn::EveryRoad(about) if roads.networks && !about.is_empty() => format!("; on networks: {about}"),
            MeasuredOn::ClosedRoutes(why) if roads.networks => format!("; not on networks: {why}"),
            MeasuredOn::Networks if roads.closed => "; on networks alone".into(),
            _ => String::new(),
        };
        format!("{}{there} (SAE J2944: {})", self.about, self.j2944.unwrap_or("none"))
    }

    /// Quantity and unit, as an axis or a table's head says it.
    pub fn label(&self) -> String {
        if self.unit.is_empty() { self.title.into() } else { format!("{}, {}", self.title, unit_text(self.unit)) }
    }
}

/// All of them: those of every drive, then those of networks.
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
    /// Of a drive with its totals and responses, and of the totals of the same without advice.
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

    /// The value of a measure by its name.
    pub fn get(&self, name: &str) -> Option<f64> {
        let at = MEASURES.iter().position(|measure| measure.name == name)?;
        self.values.get(at).copied().flatten()
    }
}

#[cfg(test)]
#[path = "measures_tests.rs"]
mod tests;
