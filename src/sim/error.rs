//! Why a drive cannot start, and which settings decide on it.

use crate::{driver::DriverError, ego::EgoError, map::MapError, policy::PolicyError, traffic::TrafficError};

/// Why a drive cannot start.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// The map cannot be used.
    #[error(transparent)]
    Map(#[from] MapError),
    /// The traffic cannot start or go on.
    #[error(transparent)]
    Traffic(#[from] TrafficError),
    /// The policy needs something of a closed route, and the drive is on a network.
    #[error(
        "policy {policy} needs a closed route with a fixed number of cars: it {why}; this drive is on a network\n  remedy: --policy none or pi, \
         or constant, follower-stopper or linear-feedback with --policy-speed"
    )]
    PolicyNeedsRing {
        /// Its name.
        policy: String,
        /// What of such a route it needs.
        why: String,
    },
    /// The policy needs something of a network, and the drive is on a closed route.
    #[error(
        "policy {policy} needs a path through a network: it {why}; this drive is on a closed route\n  remedy: name another policy, or the \
         path of a network (--path)"
    )]
    PolicyNeedsNetwork {
        /// Its name.
        policy: String,
        /// What of a network it needs.
        why: String,
    },
    /// The policy is unknown or its file cannot be used.
    #[error(transparent)]
    Policy(#[from] PolicyError),
    /// The simulated driver whose advice is shown as a sham, or who drives other advised vehicles, cannot drive.
    #[error(transparent)]
    Driver(#[from] DriverError),
    /// A setting that the road does not allow, once that is known.
    #[error("{message}")]
    Setting {
        /// Its key.
        key: &'static str,
        /// Its value, what is allowed, and the remedy.
        message: String,
    },
    /// Somebody shall drive, and the scenario has no participant.
    #[error(
        "participant is false: nobody drives in this scenario, and a window is for somebody who does\n  remedy: codrive run, or --participant true"
    )]
    NoParticipant,
    /// The ego cannot be built.
    #[error(transparent)]
    Ego(#[from] EgoError),
}

impl WorldError {
    /// Keys of the scenario that decide on it, the likeliest first.
    pub fn settings(&self) -> &'static [&'static str] {
        match self {
            Self::Map(MapError::PathEdge { .. } | MapError::PathGap { .. } | MapError::EmptyPath { .. }) => {
                &["path", "map"]
            }
            Self::Map(MapError::PathStart { .. }) => &["path_start_m", "path"],
            Self::Map(_) => &["map"],
            Self::Policy(_) | Self::PolicyNeedsRing { .. } | Self::PolicyNeedsNetwork { .. } => &["policy"],
            Self::Traffic(TrafficError::Setup(_)) => &["vehicles", "map", "idm"],
            Self::Traffic(_) => &["traffic"],
            Self::Driver(_) => &["driver", "sham_advice"],
            Self::Setting { key: "participant", .. } => &["participant", "demand", "map"],
            Self::Setting { .. } => &["traffic", "sham_advice", "advised", "map"],
            Self::NoParticipant => &["participant"],
            Self::Ego(_) => &[],
        }
    }
}
