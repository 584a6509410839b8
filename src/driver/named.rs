//! Drivers by name or by numbers: on the command line, in a scenario, in tables. In: text. Out: a [`NamedDriver`], which
//! whole drives and the fast ring take alike, so that a name means the same everywhere.

use super::{DriverError, DriverParams, params::NUMBERS, preset};
use std::fmt::Write;

/// A driver and what he is called.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedDriver {
    /// As [`named`] reads it: the name of a preset, or numbers.
    pub text: String,
    /// All of him.
    pub params: DriverParams,
}

/// The driver that a text names: a preset ([`preset`]), or one in numbers such as `reaction=1,error=0.5`: reaction time to
/// advice (s; to the leader 0.7 of it, as in the presets), tracking error, constant deviation and deadband (m/s).
///
/// # Errors
/// The text is no preset and no numbers, or a number is not allowed.
pub fn named(text: &str) -> Result<NamedDriver, DriverError> {
    let text = text.trim();
    if !text.contains('=') {
        return Ok(NamedDriver { text: text.into(), params: preset(text)? });
    }
    let mut params =
        DriverParams { reaction_s: 0.0, leader_reaction_s: 0.0, error_mps: 0.0, ..DriverParams::default() };
    for pair in text.split(',') {
        let unknown = || DriverError::Unknown { name: pair.trim().to_owned() };
        let (key, value) = pair.split_once('=').ok_or_else(unknown)?;
        let (key, value) = (key.trim(), value.trim());
        let number = value.parse().map_err(|_| DriverError::NoNumber { key: key.into(), value: value.into() })?;
        match key {
            "reaction" => (params.reaction_s, params.leader_reaction_s) = (number, 0.7 * number),
            "error" => params.error_mps = number,
            // The second words are those of recordings and scripts up to 2026.
            "speed_bias" | "trait" => params.speed_bias_mps = number,
            "deadband" | "slack" => params.deadband_mps = number,
            _ => return Err(DriverError::UnknownNumber { key: key.into() }),
        }
    }
    params.check()?;
    Ok(NamedDriver { text: text.split(',').map(str::trim).collect::<Vec<_>>().join(","), params })
}

impl NamedDriver {
    /// A driver in numbers, as [`named`] reads them: reaction (s), error, constant deviation and deadband (m/s).
    ///
    /// # Errors
    /// A number is not allowed.
    pub fn of_numbers(numbers: [f64; 4]) -> Result<Self, DriverError> {
        let pairs: Vec<String> = NUMBERS.iter().zip(numbers).map(|(key, value)| format!("{key}={value}")).collect();
        named(&pairs.join(","))
    }

    /// What tables and figures call him.
    pub fn label(&self) -> String {
        if !self.text.contains('=') {
            return self.text.clone();
        }
        let p = &self.params;
        let mut label = format!("reaction {} s, error {} m/s", p.reaction_s, p.error_mps);
        for (what, value) in [("speed bias", p.speed_bias_mps), ("deadband", p.deadband_mps)] {
            if value != 0.0 {
                let _ = write!(label, ", {what} {value} m/s");
            }
        }
        label
    }
}

#[cfg(test)]
mod tests {
    use super::{super::LeaderRule, *};

    #[test]
    fn a_driver_is_read_by_name_and_by_numbers() {
        assert_eq!(named("sloppy").unwrap().params, preset("sloppy").unwrap());
        assert_eq!(named("guarded").unwrap().params.leader_rule, LeaderRule::Guard);
        let late = named("reaction=1, error=0.5").unwrap();
        assert_eq!(
            (late.text.as_str(), late.label().as_str()),
            ("reaction=1,error=0.5", "reaction 1 s, error 0.5 m/s")
        );
        let p = &late.params;
        assert_eq!(
            (p.reaction_s, p.leader_reaction_s, p.error_mps, p.speed_bias_mps, p.deadband_mps),
            (1.0, 0.7, 0.5, 0.0, 0.0)
        );
        assert!(p.follows_advice && p.leader_rule == LeaderRule::Model);
        assert_eq!(named(&late.text).unwrap(), late);
        let slow = NamedDriver::of_numbers([0.0, 0.0, -0.5, 0.2]).unwrap();
        assert_eq!(named("trait=-0.5,slack=0.2").unwrap().params, slow.params, "as recordings of 2026 have it");
        assert_eq!(slow.label(), "reaction 0 s, error 0 m/s, speed bias -0.5 m/s, deadband 0.2 m/s");
    }

    #[test]
    fn what_is_no_driver_is_told_with_what_there_is() {
        let told = |text: &str| named(text).unwrap_err().to_string();
        assert!(
            told("folow").contains("no driver is called \"folow\"") && told("folow").contains("did you mean follow")
        );
        assert!(told("folow").contains("exact, guarded") && told("folow").contains("reaction=1,error=0.5"));
        assert_eq!(told("error=9"), "driver: error_mps = 9 is not allowed\n  remedy: give a number from 0 to 5");
        assert!(told("error=x").contains("error is \"x\""), "{}", told("error=x"));
        assert!(
            told("eror=1").starts_with("a driver has no number \"eror\" (did you mean error?)\n  remedy: give some of")
        );
        assert!(told("error=1,follow").contains("\"follow\""));
    }
}
