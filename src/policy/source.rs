//! Policies from names and files. In: the name of a policy, or the path of its file. Out: a [`PolicySource`], read once and engaged as
//! often as needed, or the controller or the advice of that name.

use super::{
    Controller, ControllerFile, ControllerKind, CorrectedAdvice, Network, OnnxPolicy, Policy, PolicyError,
    PolicySettings, RoadKind,
    controller::is_controller,
    names::file_of,
    needs::{lacked, lacked_by_controller, lacked_by_network},
    network::{self, stands_alone},
};
use std::{
    fmt,
    path::{Path, PathBuf},
    sync::Arc,
};

/// A policy that is read once and engaged any number of times; reading a trained policy's file takes longer than driving with it.
#[derive(Clone)]
pub struct PolicySource {
    kind: SourceKind,
    step_s: f64,
}

#[derive(Clone)]
enum SourceKind {
    NoAdvice,
    Controller(ControllerFile),
    Network(Box<Network>),
    Onnx(Box<OnnxPolicy>),
    /// Policy that no file holds: the function engages it.
    Other(Arc<dyn Fn() -> Box<dyn Policy> + Send + Sync>),
}

impl fmt::Debug for PolicySource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("PolicySource").finish_non_exhaustive()
    }
}

impl PolicySource {
    /// Returns the source of a policy that no file holds: `engage` returns a newly engaged one for each vehicle and drive.
    pub fn engaged_by(engage: impl Fn() -> Box<dyn Policy> + Send + Sync + 'static) -> Self {
        // The function knows the step itself.
        Self { kind: SourceKind::Other(Arc::new(engage)), step_s: 0.0 }
    }

    /// Reads a policy by name, shipped ones included, or by the path of its file (`.toml`, `.onnx`).
    ///
    /// # Errors
    /// The name is neither in [`NAMES`](super::NAMES) nor shipped, or the file cannot be used.
    pub fn read(name: &str, settings: &PolicySettings) -> Result<Self, PolicyError> {
        let kind = match (ControllerKind::named(name), file_of(name)) {
            (Some(kind), _) => SourceKind::Controller(Controller::by_name(kind, settings).into()),
            (None, _) if name == "none" => SourceKind::NoAdvice,
            (None, Some(file)) if name.ends_with(".onnx") => SourceKind::Onnx(Box::new(OnnxPolicy::from_file(&file)?)),
            (None, Some(file)) => Self::from_toml_file(&file)?,
            (None, None) => return Err(PolicyError::Unknown { name: name.into() }),
        };
        Ok(Self { kind, step_s: settings.step_s })
    }

    /// Reads the policy of a TOML file, a trained network or a controller.
    fn from_toml_file(path: &Path) -> Result<SourceKind, PolicyError> {
        let text = network::read(path)?;
        Ok(if is_controller(&text) {
            SourceKind::Controller(ControllerFile::from_toml(&text, &path.display().to_string())?)
        } else {
            SourceKind::Network(Box::new(Network::from_text_of(path, &text)?))
        })
    }

    /// Returns a newly engaged policy; `None` for `none`.
    pub fn engage(&self) -> Option<Box<dyn Policy>> {
        Some(match &self.kind {
            SourceKind::NoAdvice => return None,
            SourceKind::Controller(file) => file.policy(self.step_s),
            SourceKind::Network(network) => network.as_ref().clone().policy(self.step_s),
            SourceKind::Onnx(policy) => policy.engaged(self.step_s),
            SourceKind::Other(engage) => engage(),
        })
    }

    /// Reads the policy of this name for training and evaluation rings.
    ///
    /// # Errors
    /// The errors of [`PolicySource::read`], or the policy has inputs that only a whole drive provides.
    pub fn for_rings(name: &str, settings: &PolicySettings) -> Result<Self, PolicyError> {
        let source = Self::read(name, settings)?;
        match source.lacks(RoadKind::BareRing) {
            Some(why) => Err(PolicyError::NotOnRings { name: name.into(), why }),
            None => Ok(source),
        }
    }

    /// Returns the reason that the policy cannot advise on this kind of road, in words that follow "it"; `None` if it can.
    pub fn lacks(&self, road: RoadKind) -> Option<String> {
        match &self.kind {
            SourceKind::NoAdvice => None,
            SourceKind::Controller(file) => lacked_by_controller(&file.controller, road),
            SourceKind::Network(network) => lacked_by_network(network, road),
            SourceKind::Onnx(policy) => policy.lacks(road),
            SourceKind::Other(engage) => lacked(engage().inputs(), 0.0, None, None, road),
        }
    }
}

/// Builds and engages a policy by name or by the path of its file; `None` for `none`.
///
/// # Errors
/// The errors of [`PolicySource::read`].
///
/// # Examples
///
/// ```
/// # extern crate codrive_core as codrive;
/// use codrive::policy::{self, Action, Observation, PolicySettings};
///
/// let settings = PolicySettings { aim_mps: 4.3, equilibrium_mps: 4.362, step_s: 0.1 };
/// let mut constant = policy::build("constant", &settings)?.expect("only `none` gives no advice");
/// assert_eq!(constant.act(0.0, &Observation::default()), Action::Speed(4.3));
/// assert!(policy::build("none", &settings)?.is_none());
/// assert!(policy::build("constnat", &settings).is_err());
/// # Ok::<(), policy::PolicyError>(())
/// ```
pub fn build(name: &str, settings: &PolicySettings) -> Result<Option<Box<dyn Policy>>, PolicyError> {
    Ok(PolicySource::read(name, settings)?.engage())
}

/// Returns the controller with this name, or reads it from a file.
///
/// # Errors
/// No controller has this name, or the file cannot be used or holds no controller.
pub fn controller(name: &str, settings: &PolicySettings) -> Result<Controller, PolicyError> {
    match ControllerKind::named(name) {
        Some(kind) => Ok(Controller::by_name(kind, settings)),
        None if name.ends_with(".toml") => {
            Ok(ControllerFile::from_toml(&network::read(Path::new(name))?, name)?.controller)
        }
        None => Err(PolicyError::UnknownController { name: name.into() }),
    }
}

impl CorrectedAdvice {
    /// Reads the advice of a name or a file: a controller or a trained policy.
    ///
    /// # Errors
    /// The name is unknown, the file cannot be used, or the advice cannot be corrected.
    pub fn read(name: &str, settings: &PolicySettings) -> Result<Self, PolicyError> {
        if name.ends_with(".onnx") {
            return Err(PolicyError::CorrectedOnnx { name: name.into() });
        }
        match PolicySource::for_rings(name, settings).map(|source| source.kind) {
            Ok(SourceKind::Controller(file)) => Ok(Self::Controller(file.controller)),
            Ok(SourceKind::Network(network)) => match stands_alone(&network) {
                Ok(()) => Ok(Self::Network(network)),
                Err(fault) => Err(PolicyError::NotCorrectable { name: name.into(), fault }),
            },
            Ok(SourceKind::NoAdvice | SourceKind::Onnx(_) | SourceKind::Other(_))
            | Err(PolicyError::Unknown { .. }) => Err(PolicyError::UnknownCorrected { name: name.into() }),
            Err(other) => Err(other),
        }
    }
}

/// Returns all files of the policy at a path, its main file first.
pub fn files_of(path: &Path) -> Vec<PathBuf> {
    if path.extension().is_some_and(|e| e == "onnx") { OnnxPolicy::files(path) } else { vec![path.into()] }
}
