//! Errors that prevent a drive from starting or going on, and the settings that each depends on.

use crate::{
    driver::DriverError, ego::EgoError, map::MapError, policy::PolicyError, scenario::PlanError, traffic::TrafficError,
};

/// Error that prevents a drive from starting or going on.
#[derive(Debug, thiserror::Error)]
pub enum WorldError {
    /// The scenario cannot be driven on its road.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The traffic cannot start or go on.
    #[error(transparent)]
    Traffic(#[from] TrafficError),
    /// The policy needs a closed route, and the drive is on a network.
    #[error(
        "policy {policy} needs a closed route with a fixed number of vehicles: it {why}; this drive is on a \
         network\n  remedy: choose --policy none or pi, or constant, follower-stopper or linear-feedback with \
         --policy-speed"
    )]
    PolicyNeedsRing {
        /// Name of the policy.
        policy: String,
        /// Property of a closed route that the policy needs.
        why: String,
    },
    /// The policy needs a network, and the drive is on a closed route.
    #[error(
        "policy {policy} needs a path through a network: it {why}; this drive is on a closed route\n  remedy: name another policy, or the \
         path of a network (--path)"
    )]
    PolicyNeedsNetwork {
        /// Name of the policy.
        policy: String,
        /// Property of a network that the policy needs.
        why: String,
    },
    /// The policy is unknown, or its file cannot be used.
    #[error(transparent)]
    Policy(#[from] PolicyError),
    /// A simulated driver cannot be used: the one whose advice is shown as sham advice, or the one of other advised vehicles.
    #[error(transparent)]
    Driver(#[from] DriverError),
    /// The drive needs a participant, and the scenario has none.
    #[error(
        "participant is false: this scenario has no driver, and a window needs one\n  remedy: use codrive run, or set \
         --participant true"
    )]
    NoParticipant,
    /// The ego cannot be built.
    #[error(transparent)]
    Ego(#[from] EgoError),
}

impl WorldError {
    /// Returns the part of the value of the first of [`WorldError::settings`] that is at fault, such as `.0.actions.1`; empty for all of it.
    pub fn part(&self) -> &str {
        match self {
            Self::Plan(PlanError::Setting { part, .. }) => part,
            _ => "",
        }
    }

    /// Returns the keys of the settings that the error depends on, the most likely cause first.
    pub fn settings(&self) -> &'static [&'static str] {
        match self {
            Self::Plan(PlanError::Map(error)) => match error {
                MapError::PathEdge { .. }
                | MapError::PathGap { .. }
                | MapError::PathJoint { .. }
                | MapError::PathPoint { .. }
                | MapError::NoWay { .. }
                | MapError::EmptyPath { .. } => &["path", "map"],
                MapError::PathStart { .. } => &["path_start_m", "path"],
                _ => &["map"],
            },
            Self::Plan(PlanError::Setting { key: "participant", .. }) => &["participant", "demand", "map"],
            Self::Plan(PlanError::Setting { key: "road_user", .. }) => &["road_user", "path", "map"],
            Self::Plan(PlanError::Setting { key: "event", .. }) => &["event", "duration_s", "map"],
            Self::Plan(PlanError::Setting { .. }) => &["traffic", "sham_advice", "advised", "map"],
            Self::Policy(_) | Self::PolicyNeedsRing { .. } | Self::PolicyNeedsNetwork { .. } => &["policy"],
            Self::Traffic(TrafficError::Setup(_)) => &["vehicles", "map", "idm"],
            Self::Traffic(_) => &["traffic"],
            Self::Driver(_) => &["driver", "sham_advice"],
            Self::NoParticipant => &["participant"],
            Self::Ego(_) => &[],
        }
    }
}
