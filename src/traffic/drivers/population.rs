//! Populations of traffic drivers. In: a name, or a TOML file with the model and, for each of its parameters, mean and spread between
//! persons, unit and source, and their correlations. Out: persons, each drawn from a stream of their own. SI units.
//!
//! Parameters are positive, so each is lognormal between persons: `mean` is the mean over persons and `spread` the standard deviation of
//! the natural logarithm. Correlations are those of the logarithms.

use super::following::{AccelNoise, CarFollowing, TrafficDriver};
use crate::{
    data_folders,
    file::{SETTINGS_BYTES, read_text},
    idm::IdmParams,
    optimal_velocity::OptimalVelocityParams,
    rng::Stream,
    settings::{Field, SettingKind, fields_of},
    toml_text::{self, KeyPart, did_you_mean},
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize, de::DeserializeOwned};
use serde_json::{Map, Value};
use std::{collections::BTreeMap, fs, path::Path};

/// Name of the drivers who are all alike: the scenario's own IDM with Flow's noise.
pub const RING_STUDY: &str = "ring-study";

/// Folder of the shipped populations, relative to the project's root.
const SHIPPED: &str = "assets/populations";

/// Error in a population; the message is complete.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct PopulationError(pub String);

/// Car-following model that all persons of a file share.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum PopulationModel {
    /// Acceleration by speed, gap and closing speed: the default of traffic research.
    Idm,
    /// Optimal velocity with a follow-the-leader term.
    OptimalVelocity,
}

/// Distribution of one parameter over persons.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PersonParameter {
    /// Mean over persons, in `unit`.
    pub mean: f64,
    /// Standard deviation of the natural logarithm between persons; 0: all alike.
    #[serde(default)]
    #[schemars(range(min = 0.0))]
    pub spread: f64,
    /// Unit of the mean, as the program has it.
    pub unit: String,
    /// Source of the numbers; empty: the population's.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub source: String,
}

/// Correlation of the logarithms of two parameters between persons.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PersonCorrelation {
    /// Names of the two parameters.
    pub between: [String; 2],
    /// Coefficient of correlation, above -1 and below 1.
    #[schemars(range(min = -1.0, max = 1.0))]
    pub r: f64,
    /// Source of the number; empty: the population's.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub source: String,
}

/// Population of traffic drivers, as its file describes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrafficPopulation {
    /// Title for people, such as the instruction that the drivers had.
    pub title: String,
    /// Source of all numbers that name none of their own.
    pub source: String,
    /// Car-following model of all persons.
    pub model: PopulationModel,
    /// Parameters by name: all of the model, `noise_sd` and `noise_memory`.
    pub parameters: BTreeMap<String, PersonParameter>,
    /// Correlations; parameters without one are unrelated.
    #[serde(default, rename = "correlation", skip_serializing_if = "Vec::is_empty")]
    pub correlations: Vec<PersonCorrelation>,
    /// Parameters of the model, in the order in which a person's are drawn.
    #[serde(skip)]
    fields: Vec<Field>,
    /// Lower triangular root of the matrix of the parameters' correlations.
    #[serde(skip)]
    root: Vec<Vec<f64>>,
}

/// Parameters of an Ornstein-Uhlenbeck process, which is added to the acceleration.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
struct NoiseParams {
    /// Standard deviation of the acceleration
    #[schemars(range(min = 0.0, max = 2.0), extend("unit" = "m/s2"))]
    noise_sd: f64,
    /// Time constant of its autocorrelation
    #[schemars(range(min = 0.1, max = 100.0), extend("unit" = "s"))]
    noise_memory: f64,
}

/// Returns true if the setting is the path of a file, not a name.
pub fn is_path(name: &str) -> bool {
    name.ends_with(".toml") || name.contains(['/', '\\'])
}

/// Returns the names of the drivers that come with the program: [`RING_STUDY`], then the shipped populations in order.
pub fn names() -> Vec<String> {
    let files = fs::read_dir(data_folders::root().join(SHIPPED)).into_iter().flatten().flatten();
    let mut shipped: Vec<String> =
        files.filter_map(|file| Some(file.file_name().to_str()?.strip_suffix(".toml")?.to_owned())).collect();
    shipped.sort();
    std::iter::once(RING_STUDY.to_owned()).chain(shipped).collect()
}

/// Returns the parameters of a population's model with unit and limits, in the order in which a person's are drawn. A population has
/// no white noise: `noise` of the IDM is not among them.
pub fn parameter_fields(model: PopulationModel) -> Vec<Field> {
    let mut fields = match model {
        PopulationModel::Idm => fields_of::<IdmParams>(),
        PopulationModel::OptimalVelocity => fields_of::<OptimalVelocityParams>(),
    };
    fields.retain(|field| field.path != "noise");
    fields.extend(fields_of::<NoiseParams>());
    fields
}

impl TrafficPopulation {
    /// Reads a shipped population by name, or a file by path.
    ///
    /// # Errors
    /// The name is unknown, or the file cannot be read or is invalid; the message gives the place and the allowed values.
    pub fn named(name: &str) -> Result<Self, PopulationError> {
        let known = names();
        let path = if is_path(name) {
            Path::new(name).to_owned()
        } else if known.iter().any(|one| one == name) {
            data_folders::root().join(SHIPPED).join(format!("{name}.toml"))
        } else {
            let near = did_you_mean(name, &known);
            let message = format!(
                "traffic_drivers is \"{name}\"{near}; allowed: {}, or the path of a population's file (.toml)",
                known.join(", ")
            );
            return Err(PopulationError(message));
        };
        let text = read_text(&path, SETTINGS_BYTES).map_err(|why| {
            let near = toml_text::did_you_mean_file(&path);
            PopulationError(format!(
                "{}: cannot be read: {why}{near}\n  remedy: name a population's file, or one of {}",
                path.display(),
                known.join(", ")
            ))
        })?;
        Self::parse(&text, &path.display().to_string())
    }

    /// Reads a population from TOML text; messages refer to it as `name`.
    ///
    /// # Errors
    /// The text is invalid; the message gives the place and the allowed values.
    pub fn parse(text: &str, name: &str) -> Result<Self, PopulationError> {
        let (mut population, mut mistakes) = toml_text::read_formatted::<Self>(text, name);
        for (key, part, message) in population.iter_mut().flat_map(Self::completed) {
            mistakes.add(&key, part, &message);
        }
        toml_text::finished((population, mistakes)).map_err(|mistakes| PopulationError(mistakes.to_string()))
    }

    /// Returns the population after a change of its numbers, checked.
    ///
    /// # Errors
    /// A number is beyond its limits, or no persons can have the correlations together.
    pub fn checked(mut self) -> Result<Self, PopulationError> {
        match self.completed().into_iter().next() {
            None => Ok(self),
            Some((key, _, message)) => Err(PopulationError(format!("{key}: {message}"))),
        }
    }

    /// Returns lowest and highest value of a parameter's mean, in its unit; `None` if the model has no such parameter.
    pub fn limits(&self, parameter: &str) -> Option<[f64; 2]> {
        match self.fields.iter().find(|field| field.path == parameter)?.kind {
            SettingKind::Number { min, max } => Some([min, max]),
            _ => None,
        }
    }

    /// Returns the population as the text of a file.
    pub fn to_toml(&self) -> String {
        format!("format = {}\n", toml_text::FORMAT) + &toml::to_string(self).unwrap_or_default()
    }

    /// Checks all numbers and prepares the draws. Each fault has its key, the part of the key and the message.
    fn completed(&mut self) -> Vec<(String, KeyPart, String)> {
        let fields = parameter_fields(self.model);
        let known: Vec<&str> = fields.iter().map(|field| field.path.as_str()).collect();
        let unknown = self.parameters.keys().filter(|name| !known.contains(&name.as_str()));
        let mut faults: Vec<(String, KeyPart, String)> = unknown
            .map(|name| (format!("parameters.{name}"), KeyPart::Key, toml_text::unknown_key(name, &known)))
            .collect();
        // A name with a slip is not missing, too.
        let is_meant = |name: &str| self.parameters.keys().any(|key| toml_text::nearest(key, &known) == Some(name));
        for field in &fields {
            let name = &field.path;
            let Some(parameter) = self.parameters.get(name) else {
                if !is_meant(name) {
                    let message =
                        format!("parameter {name} is missing: {}, {}", field.doc.to_lowercase(), field.allowed());
                    faults.push((format!("parameters.{name}"), KeyPart::Key, message));
                }
                continue;
            };
            let mut add =
                |key: &str, message| faults.push((format!("parameters.{name}.{key}"), KeyPart::Value, message));
            if let Some(fault) = field.fault(&parameter.mean.into()) {
                add("mean", fault);
            }
            if !(0.0..=MOST_SPREAD).contains(&parameter.spread) {
                let message = format!("spread is {}; allowed: 0 to {MOST_SPREAD}, of the logarithm", parameter.spread);
                add("spread", message);
            }
            if parameter.unit != field.unit {
                let message = format!("unit is \"{}\"; allowed for {name}: \"{}\"", parameter.unit, field.unit);
                add("unit", message);
            }
        }
        match self.root_of_correlations(&known) {
            Ok(root) => self.root = root,
            Err(fault) => faults.push(fault),
        }
        self.fields = fields;
        faults
    }

    /// Returns the lower triangular root of the matrix of correlations (Cholesky).
    fn root_of_correlations(&self, names: &[&str]) -> Result<Vec<Vec<f64>>, (String, KeyPart, String)> {
        let n = names.len();
        let mut matrix = vec![vec![0.0; n]; n];
        for (k, row) in matrix.iter_mut().enumerate() {
            row[k] = 1.0;
        }
        for (number, correlation) in self.correlations.iter().enumerate() {
            let key = |part: &str| format!("correlation.{number}.{part}");
            let place = |name: &String| {
                let fault = || (key("between"), KeyPart::Value, toml_text::unknown_key(name, names));
                names.iter().position(|known| known == name).ok_or_else(fault)
            };
            let [a, b] = [place(&correlation.between[0])?, place(&correlation.between[1])?];
            if a == b || correlation.r.abs() >= 1.0 || correlation.r.is_nan() {
                let message = format!("r is {}; allowed: above -1 and below 1, of two parameters", correlation.r);
                return Err((key("r"), KeyPart::Value, message));
            }
            (matrix[a][b], matrix[b][a]) = (correlation.r, correlation.r);
        }
        let mut root = vec![vec![0.0; n]; n];
        for i in 0..n {
            for j in 0..=i {
                let known: f64 = (0..j).map(|k| root[i][k] * root[j][k]).sum();
                let rest: f64 = matrix[i][j] - known;
                if i == j && rest <= 0.0 {
                    let message = "no persons can have these correlations together: their matrix is not positive \
                                   definite\n  remedy: make them smaller";
                    return Err(("correlation".into(), KeyPart::Key, message.into()));
                }
                root[i][j] = if i == j { rest.sqrt() } else { rest / root[j][j] };
            }
        }
        Ok(root)
    }

    /// Returns model, parameters and source as the rest of a sentence on the population.
    pub fn in_words(&self) -> String {
        let model = match self.model {
            PopulationModel::Idm => "the Intelligent Driver Model (Treiber, Hennecke and Helbing 2000)",
            PopulationModel::OptimalVelocity => {
                "the optimal velocity model with a follow-the-leader term (Bando et al. 1995)"
            }
        };
        let parameter = |field: &Field| {
            let PersonParameter { mean, spread, unit, .. } = &self.parameters[&field.path];
            let unit = unit.replace("m2/", "m²/").replace("s2", "s²");
            let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
            let spread = if *spread > 0.0 { format!(" (spread {spread})") } else { String::new() };
            format!("{} = {mean}{unit}{spread}", field.path)
        };
        let parameters: Vec<String> = self.fields.iter().map(parameter).collect();
        let related =
            |pair: &PersonCorrelation| format!("; r of {} and {} is {}", pair.between[0], pair.between[1], pair.r);
        format!(
            "\"{}\", by {model}, on average with {}{}. Parameters with a spread are lognormal between persons, the spread being the \
             standard deviation of the logarithm; noise_sd and noise_memory are of Ornstein-Uhlenbeck noise of the acceleration. Source: {}.",
            self.title,
            parameters.join(", "),
            self.correlations.iter().map(related).collect::<String>(),
            self.source.trim_end_matches('.')
        )
    }

    /// Draws the model and the noise of one person.
    pub fn draw(&self, stream: &mut Stream) -> TrafficDriver {
        let normal: Vec<f64> = self.fields.iter().map(|_| stream.normal()).collect();
        self.with_numbers(|k, _| self.root[k].iter().zip(&normal).map(|(root, normal)| root * normal).sum())
    }

    /// Returns the driver with the mean of every parameter.
    pub fn typical(&self) -> TrafficDriver {
        // The mean of a lognormal parameter lies half a spread above its median.
        self.with_numbers(|_, spread| spread / 2.0)
    }

    /// Returns the driver whose `k`-th parameter, of this spread, lies `deviation(k, spread)` spreads from its median.
    fn with_numbers(&self, deviation: impl Fn(usize, f64) -> f64) -> TrafficDriver {
        let mut numbers = Map::new();
        for (k, field) in self.fields.iter().enumerate() {
            let PersonParameter { mean, spread, .. } = self.parameters[&field.path];
            let number = mean * (spread * deviation(k, spread) - spread * spread / 2.0).exp();
            let SettingKind::Number { min, max } = field.kind else { continue };
            numbers.insert(field.path.clone(), number.clamp(min, max).into());
        }
        let noise = |name: &str| numbers.get(name).and_then(Value::as_f64).unwrap_or_default();
        let noise = AccelNoise::OrnsteinUhlenbeck { sd_mps2: noise("noise_sd"), memory_s: noise("noise_memory") };
        numbers.retain(|name, _| !name.starts_with("noise"));
        let model = match self.model {
            PopulationModel::Idm => CarFollowing::Idm(IdmParams { noise: 0.0, ..of_numbers(numbers) }),
            PopulationModel::OptimalVelocity => CarFollowing::OptimalVelocity(of_numbers(numbers)),
        };
        TrafficDriver { model, noise }
    }
}

/// Largest spread, of the logarithm: at 1, one person in six has less than a third of the median, which no measurement of drivers shows.
const MOST_SPREAD: f64 = 1.0;

/// Returns the parameters of a model from numbers by name, all of which it has.
fn of_numbers<T: DeserializeOwned + Default>(numbers: Map<String, Value>) -> T {
    serde_json::from_value(Value::Object(numbers)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng;

    const SMALL: &str = "format = 1\ntitle = 't'\nsource = 's'\nmodel = 'optimal-velocity'\n\
        [parameters]\nalpha = { mean = 0.7, spread = 0.3, unit = '1/s' }\nbeta = { mean = 20, spread = 0.5, unit = 'm2/s' }\n\
        v_max = { mean = 9, unit = 'm/s' }\nd0 = { mean = 2.2, unit = 'm' }\nds = { mean = 2.8, unit = '' }\n\
        noise_sd = { mean = 0.2, unit = 'm/s2' }\nnoise_memory = { mean = 1.3, unit = 's' }\n";

    fn fault(text: &str) -> String {
        TrafficPopulation::parse(text, "mine.toml").unwrap_err().0
    }

    #[test]
    fn persons_have_the_stated_mean_spread_and_correlation() {
        let text = format!("{SMALL}[[correlation]]\nbetween = ['alpha', 'beta']\nr = -0.6\n");
        let population = TrafficPopulation::parse(&text, "mine.toml").unwrap();
        let persons: Vec<[f64; 2]> = (0..20_000)
            .map(|k| match population.draw(&mut rng::stream(k, "person")).model {
                CarFollowing::OptimalVelocity(model) => [model.alpha, model.beta],
                CarFollowing::Idm(_) => panic!("another model"),
            })
            .collect();
        let mean = |of: &dyn Fn(&[f64; 2]) -> f64| persons.iter().map(of).sum::<f64>() / persons.len() as f64;
        // Three standard errors of the mean of 20,000 lognormal numbers.
        assert!((mean(&|p| p[0]) - 0.7).abs() < 3.0 * 0.7 * 0.31 / 141.0);
        assert!((mean(&|p| p[1]) - 20.0).abs() < 3.0 * 20.0 * 0.53 / 141.0);
        let logs = [mean(&|p| p[0].ln()), mean(&|p| p[1].ln())];
        let moment = |a: usize, b: usize| mean(&|p| (p[a].ln() - logs[a]) * (p[b].ln() - logs[b]));
        assert!((moment(0, 0).sqrt() - 0.3).abs() < 0.006 && (moment(1, 1).sqrt() - 0.5).abs() < 0.01);
        let r = moment(0, 1) / (moment(0, 0) * moment(1, 1)).sqrt();
        // Three standard errors of a correlation of -0.6: 3 (1 - r^2) / sqrt(n).
        assert!((r + 0.6).abs() < 3.0 * 0.64 / 141.0, "{r}");
        let words = population.in_words();
        assert!(words.starts_with("\"t\", by the optimal velocity model"), "{words}");
        assert!(words.contains("alpha = 0.7 1/s (spread 0.3), beta = 20 m²/s (spread 0.5), v_max = 9 m/s"), "{words}");
        assert!(words.contains("r of alpha and beta is -0.6") && words.ends_with("Source: s."), "{words}");
    }

    #[test]
    fn shipped_populations_can_be_drawn_and_say_where_they_are_from() {
        assert_eq!(names(), [RING_STUDY, "gap-closers", "safe-followers"]);
        for name in &names()[1..] {
            let population = TrafficPopulation::named(name).unwrap();
            assert!(population.source.contains("Arizona Ring Experiments Dataset"), "{}", population.source);
            assert_eq!(population.draw(&mut rng::stream(1, "a")), population.draw(&mut rng::stream(1, "a")));
        }
        // The mean of the fit: docs/people.md.
        let AccelNoise::OrnsteinUhlenbeck { sd_mps2, memory_s } =
            TrafficPopulation::named("safe-followers").unwrap().typical().noise
        else {
            panic!("noise without memory")
        };
        assert!((sd_mps2 - 0.396).abs() < 1e-12 && (memory_s - 1.245).abs() < 1e-12);
    }

    #[test]
    fn a_fault_in_a_population_is_named_with_its_place_and_remedy() {
        let changed = |from: &str, to: &str| fault(&SMALL.replace(from, to));
        assert!(changed("mean = 0.7", "mean = 70").starts_with("mine.toml:6:"));
        assert!(changed("mean = 0.7", "mean = 70").contains("alpha is 70.0; allowed: a number from 0.01 to 10 1/s"));
        assert!(changed("'1/s'", "'s'").contains("unit is \"s\"; allowed for alpha: \"1/s\""));
        assert!(changed("ds =", "dd =").contains("unknown key `dd`"));
        assert!(changed("spread = 0.5", "spread = 5").contains("spread is 5; allowed: 0 to 1"));
        let missing = fault(&SMALL.replace("ds = { mean = 2.8, unit = '' }\n", ""));
        assert!(missing.contains("parameter ds is missing"), "{missing}");
        let impossible = format!(
            "{SMALL}[[correlation]]\nbetween = ['alpha', 'beta']\nr = 0.9\n[[correlation]]\nbetween = ['beta', 'd0']\nr = \
             0.9\n[[correlation]]\nbetween = ['alpha', 'd0']\nr = -0.9\n"
        );
        assert!(fault(&impossible).contains("not positive definite"), "{}", fault(&impossible));
        let unknown = TrafficPopulation::named("safe-folowers").unwrap_err().0;
        assert!(unknown.contains("(did you mean safe-followers?); allowed: ring-study, gap-closers"), "{unknown}");
        assert!(TrafficPopulation::named("no/such.toml").unwrap_err().0.contains("cannot be read"));
    }
}
