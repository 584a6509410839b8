//! Configurations of the shipped rings. In: the name of a road. Out: the [`TrainConfig`] with its vehicles and scaling.

use super::config::{AdviceConfig, NetworkConfig, RingConfig, Scaling, TrainConfig};
use crate::idm::IdmParams;

impl TrainConfig {
    /// Names of the shipped rings that have a configuration, [`TrainConfig::of_ring`].
    pub const RINGS: [&str; 2] = ["ring-250", "ring-641"];

    /// Returns the configuration of a shipped ring; `None` for other roads.
    pub fn of_ring(name: &str) -> Option<Self> {
        match name {
            "ring-250" => Some(Self::paper_ring()),
            "ring-641" => Some(Self::larger_ring()),
            _ => None,
        }
    }

    /// Returns HC22's ring with the wave on it, the default if no configuration is named.
    pub fn paper_ring() -> Self {
        Self {
            ring: RingConfig {
                circumference_min_m: 250.0,
                circumference_max_m: 250.0,
                bunched_share: 1.0,
                ..RingConfig::default()
            },
            ..Self::default()
        }
    }

    /// Returns the configuration of the larger shipped ring: 40 vehicles, scaled as its shipped policies see it.
    pub fn larger_ring() -> Self {
        let paper = Self::paper_ring();
        Self {
            advice: AdviceConfig { top_speed_mps: 18.0, ..paper.advice.clone() },
            ring: RingConfig {
                vehicles_min: 40,
                vehicles_max: 40,
                circumference_min_m: 640.9,
                circumference_max_m: 640.9,
                warm_up_s: 300.0,
                idm: IdmParams { v0: 17.88, ..paper.ring.idm },
                ..paper.ring.clone()
            },
            network: NetworkConfig {
                scaling: Scaling {
                    speed_to_mps: 20.0,
                    gap_to_m: 60.0,
                    circumference_from_m: 560.0,
                    circumference_to_m: 720.0,
                    spacing_from_m: 12.0,
                    spacing_to_m: 20.0,
                },
                ..paper.network.clone()
            },
            ..paper
        }
    }
}
