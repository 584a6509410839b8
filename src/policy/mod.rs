//! Advice. In: an [`Observation`] each step. Out: an [`Action`] each hold, shown to the driver as [`Advice`]. [`build`] makes policies
//! from a name or a file; [`Advisor`] asks them once a hold. SI units.

mod advice;
mod advisor;
mod controller;
pub(crate) mod driver_observer;
mod error;
mod features;
mod file_text;
mod hold;
pub mod identification;
mod layers;
mod mean_speed;
mod names;
mod needs;
mod network;
mod observation;
#[cfg(feature = "onnx")]
pub mod onnx;
#[cfg(not(feature = "onnx"))]
#[path = "without_onnx.rs"]
pub mod onnx;
mod outside;
mod probe;
mod replayed;
mod road_ahead;
mod settings;
mod source;

pub use advice::{Action, Advice, Policy};
pub use advisor::{Advisor, shown_mps, untrained_hold, untrained_length, untrained_share};
pub use controller::{
    CONTROLLERS, ConstantSpeed, Controller, ControllerFile, ControllerFileError, ControllerKind, EngagedController,
    FollowerStopper, LinearFeedback, Order, Parameter, PiParameters, PiSaturation, SearchScale, TwoPhase,
};
pub use driver_observer::{DriverObserver, ObservedDriver};
pub use error::{PolicyError, PolicyFileError, PolicyFileFault};
pub use features::{FEATURES, FIELD_INPUTS, Feature, LARGEST_LENGTH, LATENTS, NetworkInput, length_out_of_scale};
pub use file_text::FORMAT;
pub use hold::{Hold, HoldError};
pub use identification::{DriverEstimate, DriverEstimator, DriverTraits, LatentEstimate, WhoDrives};
pub use layers::{LayerFault, NetworkLayer};
pub use mean_speed::MeanSpeed;
pub use names::{AUTO, NAMES, ResolvedPolicy, file_of, is_path, resolve, shipped};
pub use network::{
    AssistedPolicy, CorrectedAdvice, CorrectionFault, EngagedAdvice, ExpectedGain, ExpectedGainFault, Network,
    NetworkOutput, NotCorrectable, PolicyNetworkFault, SettingFault, bounded, residual,
};
pub use observation::{Observation, WholeRing};
pub use onnx::OnnxPolicy;
pub use outside::OutsideAdvice;
pub use probe::Probe;
pub use replayed::ReplayedAdvice;
pub use road_ahead::{FAR_M, LaneBeside, LanesBeside, NearVehicle, RoadAhead, RoadKind, SignalAhead};
pub use settings::{AUTOMATIC_SHARE, PolicySettings};
pub use source::{PolicySource, build, controller, files_of};
