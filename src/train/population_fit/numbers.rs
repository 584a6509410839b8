//! Numbers of a population that a fit searches. In: their names, such as `T`, `T.spread` or `T~noise_sd`. Out: their values, bounds, and a
//! population with other values. A mean is searched by its logarithm.

use crate::{
    toml_text::unknown_key,
    traffic::{PersonCorrelation, PopulationError, TrafficPopulation},
};
use std::fmt;

/// Largest factor between a mean and that of the population from which the search starts.
const MOST_FACTOR: f64 = 3.0;
/// Largest spread, of the logarithm, and largest correlation that is searched.
const MOST_SPREAD: f64 = 1.0;
const MOST_CORRELATION: f64 = 0.9;

/// Number of a population.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FittedNumber {
    /// Mean of a parameter over persons.
    Mean(String),
    /// Spread of a parameter between persons.
    Spread(String),
    /// Correlation of two parameters between persons.
    Correlation([String; 2]),
}

impl fmt::Display for FittedNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mean(name) => write!(f, "{name}"),
            Self::Spread(name) => write!(f, "{name}.spread"),
            Self::Correlation([a, b]) => write!(f, "{a}~{b}"),
        }
    }
}

impl FittedNumber {
    /// Returns the number of this name in a population.
    ///
    /// # Errors
    /// The population has no such parameter.
    pub fn named(name: &str, population: &TrafficPopulation) -> Result<Self, String> {
        let number = match (name.split_once('~'), name.strip_suffix(".spread")) {
            (Some((a, b)), _) => Self::Correlation([a.to_owned(), b.to_owned()]),
            (None, Some(parameter)) => Self::Spread(parameter.to_owned()),
            (None, None) => Self::Mean(name.to_owned()),
        };
        let known: Vec<&str> = population.parameters.keys().map(String::as_str).collect();
        match number.parameters().into_iter().find(|parameter| !known.contains(parameter)) {
            Some(unknown) => Err(format!("{name}: {}", unknown_key(unknown, &known))),
            None => Ok(number),
        }
    }

    /// Returns the parameters that the number is of.
    pub fn parameters(&self) -> Vec<&str> {
        match self {
            Self::Mean(name) | Self::Spread(name) => vec![name],
            Self::Correlation(names) => names.iter().map(String::as_str).collect(),
        }
    }

    /// Returns the coordinate of the search from a value.
    pub fn coordinate(&self, value: f64) -> f64 {
        if matches!(self, Self::Mean(_)) { value.ln() } else { value }
    }

    /// Returns the value from a coordinate of the search.
    pub fn value(&self, coordinate: f64) -> f64 {
        if matches!(self, Self::Mean(_)) { coordinate.exp() } else { coordinate }
    }

    /// Returns the value in a population.
    pub fn of(&self, population: &TrafficPopulation) -> f64 {
        match self {
            Self::Mean(name) => population.parameters[name].mean,
            Self::Spread(name) => population.parameters[name].spread,
            Self::Correlation(names) => {
                let between = population.correlations.iter().find(|correlation| is_between(correlation, names));
                between.map_or(0.0, |correlation| correlation.r)
            }
        }
    }

    /// Returns lowest and highest coordinate of a search that starts from a population.
    pub fn bounds(&self, start: &TrafficPopulation) -> [f64; 2] {
        match self {
            Self::Mean(name) => {
                let [low, high] = start.limits(name).unwrap_or([f64::MIN_POSITIVE, f64::MAX]);
                let mean = self.of(start).max(1e-3);
                [low.max(mean / MOST_FACTOR).ln(), high.min(mean * MOST_FACTOR).ln()]
            }
            Self::Spread(_) => [0.0, MOST_SPREAD],
            Self::Correlation(_) => [-MOST_CORRELATION, MOST_CORRELATION],
        }
    }

    /// Sets the value in a population.
    fn set(&self, population: &mut TrafficPopulation, value: f64) {
        if let Self::Correlation(between) = self {
            population.correlations.retain(|correlation| !is_between(correlation, between));
            let between = between.clone();
            population.correlations.push(PersonCorrelation { between, r: value, source: String::new() });
            return;
        }
        let Some(parameter) = population.parameters.get_mut(self.parameters()[0]) else { return };
        match self {
            Self::Mean(_) => parameter.mean = value,
            _ => parameter.spread = value,
        }
    }
}

fn is_between(correlation: &PersonCorrelation, names: &[String; 2]) -> bool {
    names.iter().all(|name| correlation.between.contains(name))
}

/// Returns a population with these coordinates of the search.
///
/// # Errors
/// No persons can have the numbers together.
pub fn population_at(
    start: &TrafficPopulation,
    numbers: &[FittedNumber],
    coordinates: &[f64],
) -> Result<TrafficPopulation, PopulationError> {
    let mut population = start.clone();
    for (number, coordinate) in numbers.iter().zip(coordinates) {
        number.set(&mut population, number.value(*coordinate));
    }
    population.checked()
}
