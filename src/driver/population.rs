//! Populations of drivers. In: a name and a random stream. Out: [`DriverParams`] of one driver. The sources of the
//! distributions are in docs/references.md: drivers. A distribution without a measurement is a choice, and its comment
//! says so.

use super::{DriverError, DriverParams};
use crate::{rng::Stream, toml_text::did_you_mean};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Population from which drivers are drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Population {
    /// No population: the settings describe the driver
    #[default]
    None,
    /// People, each with their own reaction time, error, bias, time gap and willingness
    People,
    /// PeRP's instructed drivers: a constant deviation of -5, -2.5, 0, 2.5 or 5 m/s, no reaction time
    Perp,
    /// Half people, the rest spread evenly over all drivers that may occur: for training policies for every driver
    Anyone,
}

/// Longest reaction time of a person, s.
pub const LONGEST_REACTION_S: f64 = 2.5;

/// Constant deviations of PeRP's drivers, m/s (docs/references.md: perp).
pub const PERP_BIASES_MPS: [f64; 5] = [-5.0, -2.5, 0.0, 2.5, 5.0];

impl Population {
    /// Names of the populations that drivers can be drawn from.
    pub const NAMES: [&'static str; 3] = ["people", "perp", "anyone"];

    /// Returns the name, as in settings.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::People => "people",
            Self::Perp => "perp",
            Self::Anyone => "anyone",
        }
    }

    /// Returns the population of this name.
    ///
    /// # Errors
    /// The name is unknown.
    pub fn named(name: &str) -> Result<Self, DriverError> {
        match name {
            "people" => Ok(Self::People),
            "perp" => Ok(Self::Perp),
            "anyone" => Ok(Self::Anyone),
            _ => Err(DriverError::UnknownPopulation {
                name: name.into(),
                near: did_you_mean(name, &Self::NAMES),
                known: Self::NAMES.join(", "),
            }),
        }
    }

    /// Draws one driver. Parameters that do not differ between drivers (pedals, steering, the rest of the model) come
    /// from `base`.
    pub fn draw(self, base: &DriverParams, stream: &mut Stream) -> DriverParams {
        match self {
            Self::None => base.clone(),
            Self::People => person(base, stream),
            Self::Perp => DriverParams {
                follows_advice: true,
                reaction_s: 0.0,
                leader_reaction_s: 0.0,
                error_mps: 1.0,
                speed_bias_mps: PERP_BIASES_MPS[stream.index(PERP_BIASES_MPS.len())],
                ..base.clone()
            },
            Self::Anyone => anyone(base, stream),
        }
    }
}

/// Draws any driver: a person, one of PeRP's drivers, or one between a machine and a slow, imprecise driver.
fn anyone(base: &DriverParams, stream: &mut Stream) -> DriverParams {
    match stream.index(6) {
        0..=2 => person(base, stream),
        3 => Population::Perp.draw(base, stream),
        4 => DriverParams { speed_bias_mps: stream.uniform(-5.0, 5.0), ..steady(base, stream) },
        _ => steady(base, stream),
    }
}

/// Draws a driver that always follows, between a machine and a slow, imprecise driver.
fn steady(base: &DriverParams, stream: &mut Stream) -> DriverParams {
    let reaction_s = stream.uniform(-0.5, 2.0).max(0.0);
    DriverParams {
        follows_advice: true,
        reaction_s,
        leader_reaction_s: reaction_s * stream.uniform(0.0, 1.0),
        error_mps: stream.uniform(-0.2, 0.8).max(0.0),
        speed_bias_mps: 0.0,
        ..base.clone()
    }
}

/// Draws a person from the distributions below.
fn person(base: &DriverParams, stream: &mut Stream) -> DriverParams {
    let mut lognormal =
        |median: f64, spread: f64, low: f64, high: f64| (median * (spread * stream.normal()).exp()).clamp(low, high);
    // Green 2000: means of 0.7 s (expected) to 1.5 s (surprise); individual times have a skewed, lognormal
    // distribution.
    let reaction_s = lognormal(1.0, 0.45, 0.3, LONGEST_REACTION_S);
    // A choice, around the presets' 0.3 (attentive) and 0.8 m/s (sloppy).
    let error_mps = lognormal(0.35, 0.5, 0.1, 1.0);
    // A choice, like all that follow.
    let time_gap_factor = lognormal(1.0, 0.2, 0.7, 1.6);
    let speed_bias_mps = (0.35 * stream.normal()).clamp(-1.0, 1.0);
    let refuses = stream.uniform(0.0, 1.0) < 0.05;
    let fades = stream.uniform(0.0, 1.0) < 0.25;
    let is_impatient = stream.uniform(0.0, 1.0) < 0.25;
    let is_inattentive = stream.uniform(0.0, 1.0) < 0.3;
    DriverParams {
        follows_advice: true,
        reaction_s,
        leader_reaction_s: 0.7 * reaction_s,
        error_mps,
        speed_bias_mps,
        compliance: if refuses { 0.0 } else { 1.0 },
        compliance_fade_s: if fades { 600.0 } else { 0.0 },
        patience_mps: if is_impatient { 2.0 } else { 0.0 },
        inattention_per_min: if is_inattentive { 3.0 } else { 0.0 },
        inattention_s: if is_inattentive { 4.0 } else { 0.0 },
        idm: crate::idm::IdmParams { t: base.idm.t * time_gap_factor, ..base.idm },
        ..base.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng;

    #[test]
    fn people_have_the_measured_reaction_times_and_can_be_simulated() {
        let mut stream = rng::stream(1, "people");
        let base = DriverParams::default();
        let people: Vec<DriverParams> = (0..20_000).map(|_| Population::People.draw(&base, &mut stream)).collect();
        assert!(people.iter().all(|person| person.check().is_ok()));
        let mut reactions: Vec<f64> = people.iter().map(|person| person.reaction_s).collect();
        reactions.sort_by(f64::total_cmp);
        assert!((reactions[10_000] - 1.0).abs() < 0.02, "{}", reactions[10_000]);
        // Quartiles of a lognormal: 1.0 exp(±0.6745 x 0.45).
        assert!((reactions[5_000] - 0.738).abs() < 0.02 && (reactions[15_000] - 1.354).abs() < 0.03);
        let share = |of: fn(&DriverParams) -> bool| people.iter().filter(|p| of(p)).count() as f64 / 20_000.0;
        assert!((share(|p| p.compliance == 0.0) - 0.05).abs() < 0.01);
        assert!((share(|p| p.compliance_fade_s > 0.0) - 0.25).abs() < 0.01);
    }

    #[test]
    fn perps_drivers_have_its_five_traits_and_no_reaction_time() {
        let mut stream = rng::stream(1, "perp");
        let drivers: Vec<DriverParams> =
            (0..100).map(|_| Population::Perp.draw(&DriverParams::default(), &mut stream)).collect();
        for bias in PERP_BIASES_MPS {
            assert!(drivers.iter().filter(|d| d.speed_bias_mps == bias).count() > 5, "{bias}");
        }
        assert!(drivers.iter().all(|d| d.reaction_s == 0.0 && d.error_mps == 1.0));
    }

    #[test]
    fn an_unknown_population_is_refused_with_the_known_names() {
        let message = Population::named("peple").unwrap_err().to_string();
        assert!(
            message.contains("peple") && message.contains("did you mean people") && message.contains("perp"),
            "{message}"
        );
    }
}
