//! How many vehicles are advised, as a person writes it: `3`, `5%` or `0.05`. The participant's is the first of them.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use std::{fmt, str::FromStr};

/// A number of vehicles, or a share of all (the penetration rate).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(into = "String")]
#[schemars(with = "String")]
pub enum AdvisedVehicles {
    /// So many.
    Count(u32),
    /// This share of all, 0 to 1.
    Share(f64),
}

/// The text is neither a number of vehicles nor a share.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "advised is \"{0}\"; allowed: a share of the vehicles, such as 5% or 0.05 (100% is all), or a whole number of vehicles, such as 3 \
     (1 is the participant's alone, 0 is nobody)"
)]
pub struct UnknownShare(String);

impl Default for AdvisedVehicles {
    /// The participant's alone.
    fn default() -> Self {
        Self::Count(1)
    }
}

impl AdvisedVehicles {
    /// True if not even the participant's is.
    pub fn is_nobody(self) -> bool {
        matches!(self, Self::Count(0)) || self == Self::Share(0.0)
    }

    /// How many of `vehicles`: a share is rounded, and is at least the participant's.
    pub fn of(self, vehicles: u32) -> u32 {
        match self {
            _ if self.is_nobody() => 0,
            Self::Count(count) => count.min(vehicles),
            Self::Share(share) => ((share * f64::from(vehicles)).round() as u32).max(1),
        }
    }

    /// The numbers of those beside the participant's, of `vehicles` on a closed route: with it they are spread evenly in the order of
    /// the cars, car `floor(k vehicles / advised)` for each `k`.
    pub fn others(self, vehicles: u32) -> impl Iterator<Item = u32> {
        let advised = self.of(vehicles);
        (1..advised).map(move |k| (u64::from(k) * u64::from(vehicles) / u64::from(advised)) as u32)
    }

    /// The probability with which a vehicle that comes to a network is advised: vehicles are not counted there.
    pub fn of_those_that_come(self) -> f64 {
        match self {
            Self::Count(_) => 0.0,
            Self::Share(share) => share,
        }
    }

    fn parse(text: &str) -> Option<Self> {
        let share = |number: &str, per: f64| number.trim().parse().ok().map(|value: f64| value / per);
        let text = text.trim();
        let shares = match text.strip_suffix('%') {
            Some(percent) => share(percent, 100.0).filter(|share| (0.0..=1.0).contains(share)),
            None if text.bytes().all(|byte| byte.is_ascii_digit()) => return text.parse().ok().map(Self::Count),
            // 1.0 could be one vehicle or all.
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
            // As a decimal, because a percentage of it may have no end.
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
    /// From a text, or from a number as it stands in a file.
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
            // With its point: 1.0 is no whole number.
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
    fn a_share_is_written_as_percentage_or_fraction_and_a_number_of_vehicles_as_a_whole_number() {
        assert_eq!([read("5%"), read("0.05"), read("5 %")], [AdvisedVehicles::Share(0.05); 3]);
        assert_eq!([read("100%"), read("0%"), read("0.0")], [1.0, 0.0, 0.0].map(AdvisedVehicles::Share));
        assert_eq!([read("3"), read("0"), read("1")], [3, 0, 1].map(AdvisedVehicles::Count));
        for wrong in ["", "-1", "1.0", "1.5", "101%", "-5%", "%", "half", "nan", "3 cars", "99999999999"] {
            let told = wrong.parse::<AdvisedVehicles>().expect_err(wrong).to_string();
            assert!(told.contains(&format!("\"{wrong}\"")) && told.contains("5% or 0.05 (100% is all)"), "{told}");
        }
    }

    #[test]
    fn it_survives_the_way_to_text_and_back_and_numbers_of_a_file_are_read() {
        for text in ["0", "1", "22", "0%", "0.05", "0.07", "0.3333333333333333", "100%"] {
            assert_eq!(read(text).to_string(), text);
        }
        assert_eq!(read(&read("7%").to_string()), read("7%"));
        let of = |text: &str| crate::scenario::Scenario::from_toml(text, "x").map(|scenario| scenario.advised);
        assert_eq!(of("advised = 0.25"), Ok(AdvisedVehicles::Share(0.25)));
        assert_eq!(of("advised = 4"), Ok(AdvisedVehicles::Count(4)));
        assert_eq!(of("advised = \"20%\""), Ok(AdvisedVehicles::Share(0.2)));
        let told = of("seed = 1\nadvised = 1.0").expect_err("one or all").message;
        assert!(told.starts_with("x:2:11: advised is \"1.0\"; allowed: a share"), "{told}");
    }

    #[test]
    fn a_share_of_the_vehicles_is_rounded_is_the_participants_at_least_and_spread_evenly() {
        let chosen = |text: &str| (read(text).of(22), read(text).others(22).collect::<Vec<_>>());
        // 22 vehicles: 1.1, 2.2, 4.4 and 11.
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
