//! Other cars that follow by another model than the drive's own. In: a model, a share and a seed. Out: which cars have it.
//! The models are SUMO's, with its own numbers and its own noise, so that only SUMO in this process has them.

use crate::rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A car-following model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FollowingModel {
    /// The drive's own, the Intelligent Driver Model
    #[default]
    Idm,
    /// Krauss 1998 as SUMO has it, its default: keeps a safe speed, and dawdles
    Krauss,
    /// SUMO's Extended IDM: sees late and errs
    Eidm,
}

impl FollowingModel {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Idm, Self::Krauss, Self::Eidm];

    /// As it is written in settings.
    pub fn name(self) -> &'static str {
        match self {
            Self::Idm => "idm",
            Self::Krauss => "krauss",
            Self::Eidm => "eidm",
        }
    }

    /// As SUMO calls it.
    pub(super) fn sumo_name(self) -> &'static str {
        match self {
            Self::Idm => "IDM",
            Self::Krauss => "Krauss",
            Self::Eidm => "EIDM",
        }
    }
}

/// How many of the other cars have another model, and which.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModelMixture {
    /// Their model; [`FollowingModel::Idm`] leaves all as they are.
    pub model: FollowingModel,
    /// Their share of the other cars, 0 to 1.
    pub share: f64,
}

impl ModelMixture {
    /// Which of `cars` cars have it: the nearest whole number of the others, drawn by `seed`; never the ego, car 0.
    pub fn members(&self, cars: usize, seed: u64) -> Vec<bool> {
        let mut members = vec![false; cars];
        if self.model == FollowingModel::Idm || cars == 0 {
            return members;
        }
        let mut others: Vec<usize> = (1..cars).collect();
        let mut stream = rng::stream(seed, "traffic/models");
        for _ in 0..(self.share * others.len() as f64).round() as usize {
            members[others.swap_remove(stream.index(others.len()))] = true;
        }
        members
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_others_have_the_model_as_their_share_says_and_never_the_ego() {
        let count = |model, share, seed| {
            let members = ModelMixture { model, share }.members(22, seed);
            assert!(members.len() == 22 && !members[0]);
            members.iter().filter(|has| **has).count()
        };
        // Of 21 others.
        for (share, expected) in [(0.0, 0), (0.1, 2), (0.5, 11), (1.0, 21)] {
            assert_eq!(count(FollowingModel::Krauss, share, 1), expected);
            assert_eq!(count(FollowingModel::Idm, share, 1), 0);
        }
        let who = |seed| ModelMixture { model: FollowingModel::Eidm, share: 0.5 }.members(22, seed);
        assert!(who(1) == who(1) && who(1) != who(2));
    }
}
