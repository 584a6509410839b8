//! How drives were made. In: manifest and scenario of each. Out: facts in words, and what is the same in all of them or differs.

use super::{Analysed, glossary::printed, tables::conditions};
use crate::{
    chart::minus,
    record::Manifest,
    scenario::{Scenario, StartLayout},
};

/// How a drive was made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Setup {
    /// By which program, with what.
    pub manifest: Manifest,
    /// What was driven.
    pub scenario: Scenario,
    /// Length of the closed route, metres; 0 if its map is not here any more.
    pub route_m: f64,
}

/// Something that may differ between drives.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number and its unit.
    Number(f64, &'static str),
    /// A word.
    Word(String),
}

/// A fact of a drive, and what it is called.
type Fact = (&'static str, fn(&Setup) -> Value);

/// What distinguishes drives, in the order in which it is told.
const FACTS: [Fact; 17] = [
    ("road", |s| Value::Word(s.road())),
    ("number of vehicles", |s| Value::Number(f64::from(s.scenario.vehicles), "")),
    ("desired speed v0", |s| Value::Number(s.scenario.idm.v0, "m/s")),
    ("desired time gap T", |s| Value::Number(s.scenario.idm.t, "s")),
    ("maximum acceleration a", |s| Value::Number(s.scenario.idm.a, "m/s2")),
    ("comfortable deceleration b", |s| Value::Number(s.scenario.idm.b, "m/s2")),
    ("acceleration exponent δ", |s| Value::Number(s.scenario.idm.delta, "")),
    ("minimum gap s0", |s| Value::Number(s.scenario.idm.s0, "m")),
    ("acceleration noise", |s| Value::Number(s.scenario.idm.noise, "m/s2")),
    ("policy", |s| Value::Word(s.manifest.policy.name.clone())),
    ("hold", |s| Value::Number(s.scenario.hold_s, "s")),
    ("half width of the advised range", |s| Value::Number(s.scenario.range_mph, "mph")),
    ("start of the vehicles", |s| Value::Word(s.start().into())),
    ("warm-up", |s| Value::Number(s.scenario.warm_up_s, "s")),
    ("planned duration", |s| Value::Number(s.scenario.duration_s, "s")),
    ("delay of the controls", |s| Value::Number(s.scenario.extra_delay_s, "s")),
    ("unit of the speedometer", |s| Value::Word(s.scenario.units.label().into())),
];

impl Setup {
    /// Name of the road, without the folder in which a recording carries it.
    pub fn road(&self) -> String {
        let name = &self.manifest.map.name;
        name.rsplit('/').next().unwrap_or(name).to_owned()
    }

    fn start(&self) -> &'static str {
        match self.scenario.start {
            StartLayout::Even => "evenly spaced",
            StartLayout::Bunched => "bunched, with one long gap",
        }
    }

    /// True if no person drove.
    pub fn is_simulated(&self) -> bool {
        self.manifest.driver.starts_with("simulated")
    }
}

/// A number without digits that say nothing, with a true minus sign.
pub fn plain(number: f64) -> String {
    let text = format!("{number:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    minus(if text == "-0" { "0" } else { text })
}

/// `a`, `a and b`, `a, b and c`.
pub fn listed(words: &[String]) -> String {
    match words {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

/// Values of some drives without repetition: `0.5, 1 and 2 mph`; of many numbers the smallest and the largest.
pub fn said(values: impl IntoIterator<Item = Value>) -> String {
    const MOST: usize = 6;
    let mut numbers: Vec<(f64, &'static str)> = Vec::new();
    let mut words: Vec<String> = Vec::new();
    for value in values {
        match value {
            Value::Number(x, unit) if !numbers.contains(&(x, unit)) => numbers.push((x, unit)),
            Value::Word(word) if !words.contains(&word) => words.push(word),
            _ => {}
        }
    }
    numbers.sort_by(|a, b| a.0.total_cmp(&b.0));
    let unit = numbers.first().map_or(String::new(), |(_, unit)| printed(unit));
    let unit = if unit.is_empty() { unit } else { format!(" {unit}") };
    match &numbers[..] {
        [] => listed(&words),
        [first, .., last] if numbers.len() > MOST => {
            format!("{} to {}{unit} ({} values)", plain(first.0), plain(last.0), numbers.len())
        }
        all => listed(&all.iter().map(|(x, _)| plain(*x)).collect::<Vec<_>>()) + &unit,
    }
}

/// What a fact of this name is in these drives.
pub fn fact(drives: &[&Analysed], name: &str) -> String {
    let (_, of) = FACTS.iter().find(|fact| fact.0 == name).expect("a fact of the list");
    said(drives.iter().map(|drive| of(&drive.setup)))
}

/// For each condition what sets it apart from others: `narrow: half width of the advised range 0.5 mph`.
pub fn apart(drives: &[Analysed]) -> Vec<String> {
    let conditions = conditions(drives);
    let differs = |fact: &&Fact| {
        let mut each = conditions.iter().map(|(_, of)| said(of.iter().map(|drive| fact.1(&drive.setup))));
        let first = each.next();
        each.any(|other| Some(other) != first)
    };
    let facts: Vec<&Fact> = FACTS.iter().filter(differs).collect();
    let words = |of: &[&Analysed]| {
        let each: Vec<String> = facts
            .iter()
            .map(|(name, value)| format!("{name} {}", said(of.iter().map(|drive| value(&drive.setup)))))
            .collect();
        each.join(", ")
    };
    conditions.iter().filter(|_| !facts.is_empty()).map(|(name, of)| format!("{name}: {}", words(of))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_said_once_in_order_with_their_unit_and_many_by_their_ends() {
        let mph = |x| Value::Number(x, "mph");
        assert_eq!(said([mph(2.0), mph(0.5), mph(1.0), mph(0.5)]), "0.5, 1 and 2 mph");
        assert_eq!(said([Value::Number(-1.5, "m/s2")]), "−1.5 m/s²");
        assert_eq!(said((0..30).map(|i| Value::Number(f64::from(i), ""))), "0 to 29 (30 values)");
        assert_eq!(said(["b", "a", "b"].map(|word| Value::Word(word.into()))), "b and a");
        assert_eq!(said([]), "");
        assert_eq!((plain(0.1 + 0.2), plain(-0.000_01), plain(300.0)), ("0.3".into(), "0".into(), "300".into()));
    }
}
