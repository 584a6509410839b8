//! Other vehicles with a car-following model different from the drive's own. In: a model, a share and a seed. Out: the vehicles that have
//! it. The models are SUMO's, with SUMO's parameters and noise; only SUMO in this process has them.

use crate::rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Car-following model of other vehicles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FollowingModel {
    /// Intelligent Driver Model, the drive's own model
    #[default]
    Idm,
    /// Krauss 1998 as implemented in SUMO, its default: keeps a safe speed, with random slowdowns
    Krauss,
    /// SUMO's Extended IDM, with a reaction time and perception errors
    Eidm,
}

impl FollowingModel {
    pub const ALL: [Self; 3] = [Self::Idm, Self::Krauss, Self::Eidm];

    /// Returns the name used in settings.
    pub fn name(self) -> &'static str {
        match self {
            Self::Idm => "idm",
            Self::Krauss => "krauss",
            Self::Eidm => "eidm",
        }
    }

    /// Returns SUMO's name of the model.
    pub(super) fn sumo_name(self) -> &'static str {
        match self {
            Self::Idm => "IDM",
            Self::Krauss => "Krauss",
            Self::Eidm => "EIDM",
        }
    }
}

/// Share of other vehicles with a different car-following model, and that model.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ModelMixture {
    /// Model of these vehicles; [`FollowingModel::Idm`] changes no vehicle.
    pub model: FollowingModel,
    /// Share of these vehicles among the other vehicles, 0 to 1.
    pub share: f64,
}

impl ModelMixture {
    /// Returns a flag for each of `cars` vehicles, true for those with the model. Their number is the share of the others, rounded; `seed`
    /// draws them. The ego, vehicle 0, is never among them.
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
    fn the_stated_share_of_others_has_the_model_and_the_ego_never_has() {
        let count = |model, share, seed| {
            let members = ModelMixture { model, share }.members(22, seed);
            assert!(members.len() == 22 && !members[0]);
            members.iter().filter(|has| **has).count()
        };
        // There are 21 other vehicles.
        for (share, expected) in [(0.0, 0), (0.1, 2), (0.5, 11), (1.0, 21)] {
            assert_eq!(count(FollowingModel::Krauss, share, 1), expected);
            assert_eq!(count(FollowingModel::Idm, share, 1), 0);
        }
        let drawn = |seed| ModelMixture { model: FollowingModel::Eidm, share: 0.5 }.members(22, seed);
        assert!(drawn(1) == drawn(1) && drawn(1) != drawn(2));
    }
}
