//! Registry of measures: the only place for the name, unit and definition of each. In: the name of a measure. Out: a [`Measure`].
//! Summaries, evaluations, benchmarks, sweeps, trainings, analyses and docs/measures.md read it.
//!
//! * `drives`: measures of every recorded drive. * `networks`: measures of drives on networks only.
//! * `evaluations`: measures of evaluated policies, benchmarks and trainings.

mod drives;
mod evaluations;
mod networks;

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
const fn ego(name: &'static str, title: &'static str, unit: &'static str, about: &'static str) -> Measure {
    let (on, over) = (MeasuredOn::EveryRoad(""), MeasuredOver::Ego);
    Measure { name, title, unit, about, source: "", j2944: None, on, over, needs_advice: false }
}

/// Creates a measure of all vehicles on every road.
const fn all_vehicles(name: &'static str, title: &'static str, unit: &'static str, about: &'static str) -> Measure {
    Measure { over: MeasuredOver::AllVehicles, ..ego(name, title, unit, about) }
}

/// Creates a measure of all advised vehicles on every road.
const fn advised(name: &'static str, title: &'static str, unit: &'static str, about: &'static str) -> Measure {
    Measure { over: MeasuredOver::AdvisedVehicles, ..ego(name, title, unit, about) }
}

impl Measure {
    /// Sets the name in SAE J2944.
    const fn in_j2944(self, name: &'static str) -> Self {
        Self { j2944: Some(name), ..self }
    }

    /// Sets the publication or topic of docs/references.md.
    const fn by(self, source: &'static str) -> Self {
        Self { source, ..self }
    }

    /// Restricts the measure to drives with advice.
    const fn with_advice(self) -> Self {
        Self { needs_advice: true, ..self }
    }

    /// Sets the difference on a network.
    const fn on_networks(self, about: &'static str) -> Self {
        Self { on: MeasuredOn::EveryRoad(about), ..self }
    }

    /// Restricts the measure to closed routes, with the reason.
    const fn on_closed_routes(self, why: &'static str) -> Self {
        Self { on: MeasuredOn::ClosedRoutes(why), ..self }
    }

    /// Restricts the measure to networks.
    const fn on_networks_alone(self) -> Self {
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

const LISTS: [&[Measure]; 3] = [drives::MEASURES, networks::MEASURES, evaluations::MEASURES];

/// Returns all measures of the registry.
pub fn measures() -> impl Iterator<Item = &'static Measure> {
    LISTS.into_iter().flatten()
}

/// Returns a measure by its name; a list that names an unknown one does not compile.
///
/// # Panics
/// The registry has no measure of this name.
pub const fn measure(name: &str) -> Measure {
    let mut i = 0;
    while i < LISTS.len() {
        let mut k = 0;
        while k < LISTS[i].len() {
            if is_same(LISTS[i][k].name.as_bytes(), name.as_bytes()) {
                return LISTS[i][k];
            }
            k += 1;
        }
        i += 1;
    }
    panic!("the registry has no measure of this name")
}

const fn is_same(a: &[u8], b: &[u8]) -> bool {
    let mut i = 0;
    while i < a.len() && i < b.len() && a[i] == b[i] {
        i += 1;
    }
    i == a.len() && i == b.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn each_name_has_one_definition_and_ends_with_its_unit() {
        let names: BTreeSet<&str> = measures().map(|measure| measure.name).collect();
        assert_eq!(names.len(), measures().count());
        for measure in measures() {
            let suffix = match measure.unit {
                "" => continue,
                "1/h" => "per_h",
                "1/min" => "per_min",
                "1/km" => "per_km",
                "l/100 km" => "l_100km",
                "m/s" => "mps",
                "m/s2" => "mps2",
                "m/s3" => "mps3",
                unit => unit,
            };
            assert!(measure.name.ends_with(&format!("_{suffix}")), "{}: {}", measure.name, measure.unit);
            assert!(!measure.title.is_empty() && !measure.about.is_empty(), "{}", measure.name);
        }
    }

    #[test]
    fn each_source_is_in_the_references() {
        let references = include_str!("../../../docs/references.md");
        for measure in measures().filter(|measure| !measure.source.is_empty()) {
            let source = measure.source;
            let is_there =
                references.contains(&format!("**[{source}]**")) || references.contains(&format!("### `{source}`:"));
            assert!(is_there, "{}: {source}", measure.name);
        }
    }

    /// Returns the registry as the tables of docs/measures.md.
    fn tables() -> String {
        let titles =
            ["Recorded drives", "Recorded drives on networks", "Summaries, evaluations, benchmarks and trainings"];
        let row = |measure: &Measure| {
            let over = match measure.over {
                MeasuredOver::Ego => "ego",
                MeasuredOver::AdvisedVehicles => "advised",
                MeasuredOver::AllVehicles => "all",
            };
            let (on, difference) = match measure.on {
                MeasuredOn::EveryRoad("") => ("every", String::new()),
                MeasuredOn::EveryRoad(about) => ("every", format!("; on networks: {about}")),
                MeasuredOn::ClosedRoutes(_) => ("closed", String::new()),
                MeasuredOn::Networks => ("networks", String::new()),
            };
            let Measure { name, unit, about, source, .. } = measure;
            format!("| `{name}` | {} | {over} | {on} | {about}{difference} | {source} |\n", unit_text(unit))
        };
        let table = |(title, list): (&str, &[Measure])| {
            let rows: String = list.iter().map(row).collect();
            format!(
                "\n## {title}\n\n| name | unit | over | roads | definition | source |\n|---|---|---|---|---|---|\n{rows}"
            )
        };
        titles.into_iter().zip(LISTS).map(table).collect()
    }

    #[test]
    fn the_page_of_measures_is_the_registry() {
        let page = include_str!("../../../docs/measures.md");
        let tables = tables();
        assert!(page.ends_with(&tables), "docs/measures.md must end with:\n{tables}");
    }
}
