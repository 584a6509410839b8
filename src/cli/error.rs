//! Failures of commands. In: the errors of other modules. Out: a [`CliError`], which says whether the user can correct it.

use crate::{
    drive_loop::RunError, map::MapError, record::RecordError, scenario::PlanError, settings::SettingsError,
    sim::WorldError, study::SessionError, traffic::TrafficError,
};

/// Failure of a command; the message is complete.
#[derive(Debug, thiserror::Error)]
pub enum CliError {
    /// Bad input, which the user can correct: exit 2.
    #[error("{0}")]
    Input(String),
    /// Failure of the machine or the program: exit 1.
    #[error("{0}")]
    Failed(String),
    /// Interruption by a person before a drive began: exit 130, as shells report Ctrl-C.
    #[error("{0}")]
    Interrupted(String),
    /// Closed standard output, as behind `head`: nothing more is printed, exit 141.
    #[error("no program reads the standard output")]
    Unread,
}

impl From<SettingsError> for CliError {
    fn from(error: SettingsError) -> Self {
        Self::Input(error.message)
    }
}

impl From<WorldError> for CliError {
    fn from(error: WorldError) -> Self {
        match error {
            WorldError::Plan(PlanError::Map(error)) => error.into(),
            WorldError::Traffic(TrafficError::Interrupted) => Self::Interrupted(error.to_string()),
            WorldError::Traffic(TrafficError::Setup(_) | TrafficError::NotFinite { .. }) => {
                Self::Input(error.to_string())
            }
            WorldError::Traffic(_) => Self::Failed(error.to_string()),
            _ => Self::Input(error.to_string()),
        }
    }
}

impl From<MapError> for CliError {
    fn from(error: MapError) -> Self {
        match error {
            MapError::Interrupted { .. } => Self::Interrupted(error.to_string()),
            other => Self::Input(other.to_string()),
        }
    }
}

impl From<RecordError> for CliError {
    fn from(error: RecordError) -> Self {
        match error {
            RecordError::Taken { .. } | RecordError::Absent(_) | RecordError::Cut(_) | RecordError::Running(_) => {
                Self::Input(error.to_string())
            }
            other => Self::Failed(other.to_string()),
        }
    }
}

impl From<RunError> for CliError {
    fn from(error: RunError) -> Self {
        match error {
            RunError::World(error) => error.into(),
            RunError::Driver(error) => Self::Input(error.to_string()),
            RunError::Scenario(error) => error.into(),
            RunError::Record(error) => error.into(),
            RunError::Session(SessionError::Refused(text)) => Self::Input(text),
            RunError::Session(SessionError::Record(error)) => error.into(),
            RunError::NoMonitor { .. } | RunError::NoRefresh { .. } => Self::Input(error.to_string()),
            other => Self::Failed(other.to_string()),
        }
    }
}
