//! Populations of drivers. In: a name and a stream of chance. Out: [`DriverParams`] of one person. What each spread rests on:
//! docs/references.md: drivers. Where nothing was measured, the spread is a choice and says so.

use super::{DriverError, DriverParams};
use crate::{rng::Stream, toml_text::did_you_mean};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A population that drivers are drawn from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Population {
    /// Nobody is drawn: the settings say who drives
    #[default]
    None,
    /// People: each with a reaction time, an error, a bias, a gap, a willingness of his own
    People,
    /// PeRP's instructed drivers: a constant deviation of -5, -2.5, 0, 2.5 or 5 m/s, no reaction time
    Perp,
    /// Half of them people, the rest spread evenly over all that can be met: what a policy is trained on that must know everybody
    Anyone,
}

/// Longest reaction time of any of them, s.
pub const LONGEST_REACTION_S: f64 = 2.5;

/// PeRP's traits, m/s (docs/references.md: perp).
pub const PERP_BIASES_MPS: [f64; 5] = [-5.0, -2.5, 0.0, 2.5, 5.0];

impl Population {
    /// All that drivers can be drawn from, by name.
    pub const NAMES: [&'static str; 3] = ["people", "perp", "anyone"];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::People => "people",
            Self::Perp => "perp",
            Self::Anyone => "anyone",
        }
    }

    /// The population of this name.
    ///
    /// # Errors
    /// There is none.
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

    /// One person. What is not of the person (feet, hands, the model's other numbers) is that of `base`.
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

/// Somebody of whom nothing is known: a person, one of PeRP's drivers, or anything between a machine and a slow, erring driver.
fn anyone(base: &DriverParams, stream: &mut Stream) -> DriverParams {
    match stream.index(6) {
        0..=2 => person(base, stream),
        3 => Population::Perp.draw(base, stream),
        4 => DriverParams { speed_bias_mps: stream.uniform(-5.0, 5.0), ..steady(base, stream) },
        _ => steady(base, stream),
    }
}

/// A driver who always follows, anything between a machine and a slow, erring driver.
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

/// A person.
fn person(base: &DriverParams, stream: &mut Stream) -> DriverParams {
    let mut lognormal =
        |median: f64, spread: f64, low: f64, high: f64| (median * (spread * stream.normal()).exp()).clamp(low, high);
    // Green 2000: means of 0.7 s (expected) to 1.5 s (surprise); individual times are skewed like a lognormal.
    let reaction_s = lognormal(1.0, 0.45, 0.3, LONGEST_REACTION_S);
    // A choice around the presets' 0.3 (attentive) and 0.8 m/s (sloppy).
    let error_mps = lognormal(0.35, 0.5, 0.1, 1.0);
    // A choice, as all that follows.
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
    fn people_have_the_reaction_times_that_were_measured_and_can_be_simulated() {
        let mut stream = rng::stream(1, "people");
        let base = DriverParams::default();
        let people: Vec<DriverParams> = (0..20_000).map(|_| Population::People.draw(&base, &mut stream)).collect();
        assert!(people.iter().all(|person| person.check().is_ok()));
        let mut reactions: Vec<f64> = people.iter().map(|person| person.reaction_s).collect();
        reactions.sort_by(f64::total_cmp);
        assert!((reactions[10_000] - 1.0).abs() < 0.02, "{}", reactions[10_000]);
        // A lognormal's quartiles: 1.0 exp(+-0.6745 x 0.45).
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
    fn a_wrong_name_is_told_with_what_there_is() {
        let told = Population::named("peple").unwrap_err().to_string();
        assert!(told.contains("peple") && told.contains("did you mean people") && told.contains("perp"), "{told}");
    }
}
