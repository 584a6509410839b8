//! Drivers by name or by numbers, on the command line, in a scenario and in tables. In: text. Out: a [`NamedDriver`],
//! which whole drives and the fast ring use alike, so that a name has the same meaning everywhere.

use super::{DriverError, DriverParams, params::NUMBERS, preset};
use std::fmt::Write;

/// Driver with the text that names it.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedDriver {
    /// Text that [`named`] reads: the name of a preset, or numbers.
    pub text: String,
    pub params: DriverParams,
}

/// Returns the driver of a text: a preset ([`preset`]), or numbers such as `reaction=1,error=0.5`. The numbers are the
/// reaction time to advice (s; the one to the leader is 0.7 of it, as in the presets), tracking error, constant
/// deviation and deadband (m/s).
///
/// # Errors
/// The text is neither a preset nor numbers, or a number is not allowed.
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
            // The second names are those of recordings and scripts up to 2026.
            "speed_bias" | "trait" => params.speed_bias_mps = number,
            "deadband" | "slack" => params.deadband_mps = number,
            _ => return Err(DriverError::UnknownNumber { key: key.into() }),
        }
    }
    params.check()?;
    Ok(NamedDriver { text: text.split(',').map(str::trim).collect::<Vec<_>>().join(","), params })
}

impl NamedDriver {
    /// Creates a driver from the numbers that [`named`] reads: reaction (s), error, constant deviation and deadband
    /// (m/s).
    ///
    /// # Errors
    /// A number is not allowed.
    pub fn of_numbers(numbers: [f64; 4]) -> Result<Self, DriverError> {
        let pairs: Vec<String> = NUMBERS.iter().zip(numbers).map(|(key, value)| format!("{key}={value}")).collect();
        named(&pairs.join(","))
    }

    /// Returns the driver's name for tables and figures.
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
    fn an_unknown_driver_is_refused_with_the_known_names() {
        let message = |text: &str| named(text).unwrap_err().to_string();
        assert!(
            message("folow").contains("no driver is called \"folow\"")
                && message("folow").contains("did you mean follow")
        );
        assert!(message("folow").contains("exact, guarded") && message("folow").contains("reaction=1,error=0.5"));
        assert_eq!(message("error=9"), "driver: error_mps = 9 is not allowed\n  remedy: give a number from 0 to 5");
        assert!(message("error=x").contains("error is \"x\""), "{}", message("error=x"));
        assert!(
            message("eror=1")
                .starts_with("unknown driver parameter \"eror\" (did you mean error?)\n  remedy: use some of")
        );
        assert!(message("error=1,follow").contains("\"follow\""));
    }
}
