//! The number of advised vehicles as a person writes it: `3`, `5%` or `0.05`. In: text or a number. Out: an [`AdvisedVehicles`]; the
//! participant's vehicle is the first of them.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use std::{fmt, str::FromStr};

/// A number of vehicles, or a share of all (penetration rate).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(into = "String")]
#[schemars(with = "String", extend("type" = ["string", "number"]))]
pub enum AdvisedVehicles {
    /// Number of vehicles, the participant's included.
    Count(u32),
    /// Share of all vehicles, 0..1.
    Share(f64),
}

/// Error for a text that is neither a number of vehicles nor a share.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "advised is \"{0}\"; allowed: a share of the vehicles, such as 5% or 0.05 (100% is all), or a whole number of \
     vehicles, such as 3 (1 is the participant's vehicle alone, 0 is none)"
)]
pub struct UnknownShare(String);

impl Default for AdvisedVehicles {
    /// Returns 1: the participant's vehicle alone.
    fn default() -> Self {
        Self::Count(1)
    }
}

impl AdvisedVehicles {
    /// Returns true if no vehicle is advised.
    pub fn is_no_vehicle(self) -> bool {
        matches!(self, Self::Count(0)) || self == Self::Share(0.0)
    }

    /// Returns the vehicles that the policy of this name advises: none by `none`.
    #[must_use]
    pub fn by_policy(self, name: &str) -> Self {
        if name == "none" { Self::Count(0) } else { self }
    }

    /// Returns the number of advised vehicles out of `vehicles`. A share is rounded, to at least 1 unless it is 0.
    pub fn of(self, vehicles: u32) -> u32 {
        match self {
            _ if self.is_no_vehicle() => 0,
            Self::Count(count) => count.min(vehicles),
            Self::Share(share) => ((share * f64::from(vehicles)).round() as u32).max(1),
        }
    }

    /// Returns the ids of the advised vehicles other than the participant's, out of `vehicles` on a closed route. Together with the
    /// participant's they are spread evenly: vehicle `floor(k vehicles / advised)` for each `k`.
    pub fn others(self, vehicles: u32) -> impl Iterator<Item = u32> {
        let advised = self.of(vehicles);
        (1..advised).map(move |k| (u64::from(k) * u64::from(vehicles) / u64::from(advised)) as u32)
    }

    /// Returns the same vehicles as a number out of a fixed number of vehicles. Among vehicles that enter and leave, which are `None`, it is
    /// the probability that one is advised: 0 for a count, as they are not counted.
    #[must_use]
    pub fn among(self, vehicles: Option<u32>) -> Self {
        match (vehicles, self) {
            (Some(vehicles), _) => Self::Count(self.of(vehicles)),
            (None, Self::Count(_)) => Self::Share(0.0),
            (None, Self::Share(_)) => self,
        }
    }

    /// Returns the share of `vehicles` that is advised, 0 to 1.
    pub fn share_of(self, vehicles: u32) -> f64 {
        match self {
            Self::Count(_) => f64::from(self.of(vehicles)) / f64::from(vehicles),
            Self::Share(share) => share,
        }
    }

    fn parse(text: &str) -> Option<Self> {
        let share = |number: &str, per: f64| number.trim().parse().ok().map(|value: f64| value / per);
        let text = text.trim();
        let shares = match text.strip_suffix('%') {
            Some(percent) => share(percent, 100.0).filter(|share| (0.0..=1.0).contains(share)),
            None if text.bytes().all(|byte| byte.is_ascii_digit()) => return text.parse().ok().map(Self::Count),
            // 1.0 is ambiguous: one vehicle or all.
            None => share(text, 1.0).filter(|share| (0.0..1.0).contains(share)),
        };
        shares.map(Self::Share)
    }
}

impl FromStr for AdvisedVehicles {
    type Err = UnknownShare;

    fn from_str(text: &str) -> Result<Self, UnknownShare> {
        Self::parse(text).ok_or_else(|| UnknownShare(text.into()))
    }
}

impl fmt::Display for AdvisedVehicles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count(count) => count.fmt(f),
            Self::Share(share) if *share == 0.0 || *share == 1.0 => write!(f, "{}%", share * 100.0),
            // A decimal, because the percentage may have more digits.
            Self::Share(share) => share.fmt(f),
        }
    }
}

impl From<AdvisedVehicles> for String {
    fn from(advised: AdvisedVehicles) -> Self {
        advised.to_string()
    }
}

impl<'de> Deserialize<'de> for AdvisedVehicles {
    /// Reads a text, or a number as written in a file.
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Written {
            Text(String),
            Whole(u32),
            Number(f64),
        }
        let text = match Written::deserialize(deserializer)? {
            Written::Text(text) => text,
            Written::Whole(count) => count.to_string(),
            // Keeps the decimal point: 1.0 is not a whole number.
            Written::Number(number) => format!("{number:?}"),
        };
        text.parse().map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> AdvisedVehicles {
        text.parse().unwrap_or_else(|fault| panic!("{fault}"))
    }

    #[test]
    fn a_share_is_a_percentage_or_fraction_and_a_count_is_a_whole_number() {
        assert_eq!([read("5%"), read("0.05"), read("5 %")], [AdvisedVehicles::Share(0.05); 3]);
        assert_eq!([read("100%"), read("0%"), read("0.0")], [1.0, 0.0, 0.0].map(AdvisedVehicles::Share));
        assert_eq!([read("3"), read("0"), read("1")], [3, 0, 1].map(AdvisedVehicles::Count));
        for wrong in ["", "-1", "1.0", "1.5", "101%", "-5%", "%", "half", "nan", "3 cars", "99999999999"] {
            let message = wrong.parse::<AdvisedVehicles>().expect_err(wrong).to_string();
            assert!(
                message.contains(&format!("\"{wrong}\"")) && message.contains("5% or 0.05 (100% is all)"),
                "{message}"
            );
        }
    }

    #[test]
    fn values_survive_conversion_to_text_and_numbers_in_files_are_read() {
        for text in ["0", "1", "22", "0%", "0.05", "0.07", "0.3333333333333333", "100%"] {
            assert_eq!(read(text).to_string(), text);
        }
        assert_eq!(read(&read("7%").to_string()), read("7%"));
        let of = |text: &str| crate::scenario::Scenario::from_toml(text, "x").map(|scenario| scenario.advised);
        assert_eq!(of("advised = 0.25"), Ok(AdvisedVehicles::Share(0.25)));
        assert_eq!(of("advised = 4"), Ok(AdvisedVehicles::Count(4)));
        assert_eq!(of("advised = \"20%\""), Ok(AdvisedVehicles::Share(0.2)));
        let message = of("seed = 1\nadvised = 1.0").expect_err("one or all").message;
        assert!(message.starts_with("x:2:11: advised is \"1.0\"; allowed: a share"), "{message}");
    }

    #[test]
    fn vehicles_are_a_number_where_it_is_fixed_and_a_share_where_they_enter() {
        let among = |text: &str| [read(text).among(Some(22)), read(text).among(None)];
        assert_eq!(among("20%"), [AdvisedVehicles::Count(4), AdvisedVehicles::Share(0.2)]);
        assert_eq!(among("1"), [AdvisedVehicles::Count(1), AdvisedVehicles::Share(0.0)]);
        assert_eq!(among("0%"), [AdvisedVehicles::Count(0), AdvisedVehicles::Share(0.0)]);
        assert_eq!(among("20%").map(|advised| advised.share_of(22)), [4.0 / 22.0, 0.2]);
    }

    #[test]
    fn a_share_is_rounded_to_at_least_one_vehicle_and_spread_evenly() {
        let chosen = |text: &str| (read(text).of(22), read(text).others(22).collect::<Vec<_>>());
        // Of 22 vehicles: 1.1, 2.2, 4.4 and 11.
        assert_eq!(chosen("5%"), (1, vec![]));
        assert_eq!(chosen("10%"), (2, vec![11]));
        assert_eq!(chosen("20%"), (4, vec![5, 11, 16]));
        assert_eq!(chosen("50%"), (11, (1..11).map(|k| 2 * k).collect()));
        assert_eq!(chosen("100%"), (22, (1..22).collect()));
        assert_eq!(chosen("0.001"), (1, vec![]), "a policy advises the participant at least");
        assert_eq!((chosen("0"), chosen("0%")), ((0, vec![]), (0, vec![])));
        assert_eq!(chosen("3"), (3, vec![7, 14]));
    }
}
