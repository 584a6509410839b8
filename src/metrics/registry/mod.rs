//! Registry of measures: the only place for the name, unit and definition of each. In: the name of a measure. Out: a [`Measure`].
//! Summaries, evaluations, benchmarks, sweeps, trainings, analyses and docs/measures.md read it.
//!
//! * `drives`: measures of every recorded drive. * `networks`: measures of drives on networks only.
//! * `evaluations`: measures of evaluated policies, benchmarks and trainings. * `moments`: moments of traffic in one lane.
//! * `secondary_tasks`: measures of drives with a secondary task. * `events`: measures of drives with events.
//! * `takeovers`: measures of drives with takeover requests.

mod drives;
mod evaluations;
mod events;
mod measure;
mod moments;
mod networks;
mod secondary_tasks;
mod takeovers;

pub use measure::{Measure, MeasuredOn, MeasuredOver, RoadKinds, unit_text};

const LISTS: [&[Measure]; 7] = [
    drives::MEASURES,
    networks::MEASURES,
    evaluations::MEASURES,
    moments::MEASURES,
    secondary_tasks::MEASURES,
    events::MEASURES,
    takeovers::MEASURES,
];

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
                "1/s" => "per_s",
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
        let titles = [
            "Recorded drives",
            "Recorded drives on networks",
            "Summaries, evaluations, benchmarks and trainings",
            "Moments of traffic",
            "Recorded drives with a secondary task",
            "Recorded drives with events",
            "Recorded drives with takeover requests",
        ];
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
