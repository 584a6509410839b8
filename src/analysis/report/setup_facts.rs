//! Facts of the setup that drives share or differ in. In: the setups of some drives. Out: facts in words.

use crate::analysis::{
    data::DriveSetup,
    drives::{AnalysedRecording, conditions},
    text::{joined_with_and, number_text},
};
use crate::{metrics::registry::unit_text, record::inputs};

/// Value of a fact, which may differ between drives.
#[derive(Clone, Debug, PartialEq)]
pub enum SetupValue {
    /// Number with its unit in ASCII.
    Number(f64, &'static str),
    /// A name or another word.
    Word(String),
}

/// A fact of a drive: its name and its value.
type SetupFact = (&'static str, fn(&DriveSetup) -> SetupValue);

/// Facts that distinguish drives, in the order of the report.
const FACTS: [SetupFact; 19] = [
    ("road", |s| SetupValue::Word(s.road())),
    ("number of vehicles", |s| SetupValue::Number(f64::from(s.scenario.vehicles), "")),
    ("drivers of the traffic", |s| SetupValue::Word(inputs::last(&s.scenario.traffic_drivers).into())),
    ("desired speed v0", |s| SetupValue::Number(s.scenario.idm.v0, "m/s")),
    ("desired time gap T", |s| SetupValue::Number(s.scenario.idm.t, "s")),
    ("maximum acceleration a", |s| SetupValue::Number(s.scenario.idm.a, "m/s2")),
    ("comfortable deceleration b", |s| SetupValue::Number(s.scenario.idm.b, "m/s2")),
    ("acceleration exponent δ", |s| SetupValue::Number(s.scenario.idm.delta, "")),
    ("minimum gap s0", |s| SetupValue::Number(s.scenario.idm.s0, "m")),
    ("acceleration noise", |s| SetupValue::Number(s.scenario.idm.noise, "m/s2")),
    ("policy", |s| SetupValue::Word(s.manifest.policy.name.clone())),
    ("advice", |s| SetupValue::Word(s.advice().into())),
    ("hold", |s| SetupValue::Number(s.scenario.hold_s, "s")),
    ("half width of the advised range", |s| SetupValue::Number(s.scenario.range_mph, "mph")),
    ("start of the vehicles", |s| SetupValue::Word(s.start().into())),
    ("warm-up", |s| SetupValue::Number(s.scenario.warm_up_s, "s")),
    ("planned duration", |s| SetupValue::Number(s.scenario.duration_s, "s")),
    ("delay of the controls", |s| SetupValue::Number(s.scenario.extra_delay_s, "s")),
    ("unit of the speedometer", |s| SetupValue::Word(s.scenario.display.units.label().into())),
];

/// Joins the values of some drives without repetition: `0.5, 1 and 2 mph`; for more than six numbers, the smallest and the
/// largest.
pub fn joined_values(values: impl IntoIterator<Item = SetupValue>) -> String {
    const MOST: usize = 6;
    let mut numbers: Vec<(f64, &'static str)> = Vec::new();
    let mut words: Vec<String> = Vec::new();
    for value in values {
        match value {
            SetupValue::Number(x, unit) if !numbers.contains(&(x, unit)) => numbers.push((x, unit)),
            SetupValue::Word(word) if !words.contains(&word) => words.push(word),
            _ => {}
        }
    }
    numbers.sort_by(|a, b| a.0.total_cmp(&b.0));
    let unit = numbers.first().map_or(String::new(), |(_, unit)| unit_text(unit));
    let unit = if unit.is_empty() { unit } else { format!(" {unit}") };
    match &numbers[..] {
        [] => joined_with_and(&words),
        [first, .., last] if numbers.len() > MOST => {
            format!("{} to {}{unit} ({} values)", number_text(first.0), number_text(last.0), numbers.len())
        }
        all => joined_with_and(&all.iter().map(|(x, _)| number_text(*x)).collect::<Vec<_>>()) + &unit,
    }
}

/// Returns the values of a fact in these drives.
pub fn fact(drives: &[&AnalysedRecording], name: &str) -> String {
    let (_, of) = FACTS.iter().find(|fact| fact.0 == name).expect("a fact of the list");
    joined_values(drives.iter().map(|drive| of(&drive.setup)))
}

/// Returns the differences of each condition from the others: `narrow: half width of the advised range 0.5 mph`.
pub fn condition_differences(drives: &[AnalysedRecording]) -> Vec<String> {
    let conditions = conditions(drives);
    let differs = |fact: &&SetupFact| {
        let mut each = conditions.iter().map(|(_, of)| joined_values(of.iter().map(|drive| fact.1(&drive.setup))));
        let first = each.next();
        each.any(|other| Some(other) != first)
    };
    let facts: Vec<&SetupFact> = FACTS.iter().filter(differs).collect();
    let words = |of: &[&AnalysedRecording]| {
        let each: Vec<String> = facts
            .iter()
            .map(|(name, value)| format!("{name} {}", joined_values(of.iter().map(|drive| value(&drive.setup)))))
            .collect();
        each.join(", ")
    };
    conditions.iter().filter(|_| !facts.is_empty()).map(|(name, of)| format!("{name}: {}", words(of))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_appear_once_in_order_with_unit_and_many_as_a_range() {
        let mph = |x| SetupValue::Number(x, "mph");
        assert_eq!(joined_values([mph(2.0), mph(0.5), mph(1.0), mph(0.5)]), "0.5, 1 and 2 mph");
        assert_eq!(joined_values([SetupValue::Number(-1.5, "m/s2")]), "−1.5 m/s²");
        let six = (0..6).map(|i| SetupValue::Number(f64::from(i), ""));
        assert_eq!(joined_values(six), "0, 1, 2, 3, 4 and 5", "six are listed");
        assert_eq!(joined_values((0..30).map(|i| SetupValue::Number(f64::from(i), ""))), "0 to 29 (30 values)");
        assert_eq!(joined_values(["b", "a", "b"].map(|word| SetupValue::Word(word.into()))), "b and a");
        assert_eq!(joined_values([]), "");
        assert_eq!(
            (number_text(0.1 + 0.2), number_text(-0.000_01), number_text(300.0)),
            ("0.3".into(), "0".into(), "300".into())
        );
    }
}
