//! Faults of a trained network, by kind and as messages: its file, its settings, the advice that it corrects and its expected gain.

use crate::{
    policy::{FORMAT, Feature, LayerFault, NetworkInput, identification::EstimatorFault},
    toml_text::TomlError,
};

/// Reasons that a text is not a valid policy file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PolicyNetworkFault {
    /// The text is not TOML, has unknown keys, or a value is not allowed.
    #[error("is not a policy file\n{0}")]
    File(TomlError),
    /// The format or its version is another.
    #[error("format is `{}`; allowed: `{}`", .0, FORMAT)]
    Format(String),
    /// The layers are inconsistent.
    #[error(transparent)]
    Layers(#[from] LayerFault),
    /// The predictor of the expected gain is invalid.
    #[error(transparent)]
    ExpectedGain(#[from] ExpectedGainFault),
    /// The driver estimator is invalid.
    #[error(transparent)]
    Estimator(#[from] EstimatorFault),
    /// The policy cannot correct the advice that it names.
    #[error(transparent)]
    Correction(#[from] CorrectionFault),
    /// A setting is out of range.
    #[error(transparent)]
    Setting(#[from] SettingFault),
    /// `levels` is 1, or the holds are not positive, finite and ascending.
    #[error("levels or holds_s are not valid")]
    LevelsOrHolds,
}

/// Reasons that a policy cannot correct an advice.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CorrectionFault {
    /// An acceleration cannot be added to a speed.
    #[error("only a policy whose action is \"speed\" can correct a controller or a network")]
    OfAcceleration,
    /// A parameter of the corrected controller is out of range.
    #[error("the controller's {key} is {value}; allowed: {allowed}")]
    Controller {
        /// Key of the parameter.
        key: &'static str,
        /// Value of the parameter.
        value: f64,
        /// Allowed values in words.
        allowed: String,
    },
    /// The network itself is invalid.
    #[error("the network that is corrected: {0}")]
    Network(Box<PolicyNetworkFault>),
    /// The network is valid but cannot be corrected.
    #[error("the network that is corrected {0}")]
    NotCorrectable(#[from] NotCorrectable),
}

/// Reasons that a network cannot be corrected; the message follows the network's name.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NotCorrectable {
    /// The network advises an acceleration.
    #[error("advises an acceleration, to which no speed can be added{}", REMEDY)]
    Acceleration,
    /// The network itself corrects another advice.
    #[error("corrects another advice itself{}", REMEDY)]
    CorrectsItself,
    /// The network needs the driver's traits or latents.
    #[error("needs the driver's traits{}", REMEDY)]
    AsksWhoDrives,
    /// The network probes its driver.
    #[error("probes the driver by itself{}", REMEDY)]
    Probes,
    /// The network withholds advice where it expects no gain.
    #[error("withholds advice where it expects no gain{}", REMEDY)]
    IsSilent,
    /// The network withholds advice on roads on which its corrector does not.
    #[error(
        "withholds advice below {corrected_m} m of road per vehicle, its correction below {own_m} m\n  remedy: train \
         the correction with least_spacing_m = {corrected_m} or more"
    )]
    LeastSpacing {
        /// Road per vehicle below which the network withholds advice, m.
        corrected_m: f64,
        /// Road per vehicle below which its corrector withholds advice, m.
        own_m: f64,
    },
}

const REMEDY: &str = "\n  remedy: name a speed policy that stands alone, such as ring-250-speed, or a controller";

/// Reasons that the predictor cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExpectedGainFault {
    /// The layers are inconsistent.
    #[error("expected_gain: {0}")]
    Layers(#[from] LayerFault),
    /// The bound is not finite, or an input has no range.
    #[error("expected_gain: {0}")]
    Setting(#[from] SettingFault),
}

/// Fault of a setting that both file formats have.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingFault {
    /// The limits of the action are empty or not finite.
    #[error("limits are {low} to {high}; the first must be below the second")]
    Limits {
        /// Lowest action, m/s² or m/s.
        low: f64,
        /// Highest action, m/s² or m/s.
        high: f64,
    },
    /// The bound on the change of speed is negative or not finite.
    #[error("speed_change_mps must be 0 or more")]
    SpeedChange,
    /// The least spacing is negative or not finite.
    #[error("least_spacing_m must be 0 or more")]
    LeastSpacing,
    /// The probe has a number that is not positive, or the policy advises an acceleration.
    #[error("the probe's numbers must be above 0, and the policy's action \"speed\"")]
    Probe,
    /// The bound on the expected gain is not finite.
    #[error("silent_below_mps must be a finite number")]
    SilentBelow,
    /// An input's range is empty or not finite.
    #[error("input {}: `to` must be above `from`", .0.name())]
    Input(Feature),
}

/// Returns the faults of the settings that both file formats have, each with its key: limits of the action, m/s² or m/s, largest change
/// of speed, m/s, least spacing, m, and inputs.
pub(in crate::policy) fn setting_faults(
    [low, high]: [f64; 2],
    speed_change_mps: f64,
    least_spacing_m: f64,
    inputs: &[NetworkInput],
) -> Vec<(String, SettingFault)> {
    let mut faults = Vec::new();
    if !(low.is_finite() && high.is_finite() && low < high) {
        faults.push(("limits".into(), SettingFault::Limits { low, high }));
    }
    if !(speed_change_mps.is_finite() && speed_change_mps >= 0.0) {
        faults.push(("speed_change_mps".into(), SettingFault::SpeedChange));
    }
    if !(least_spacing_m.is_finite() && least_spacing_m >= 0.0) {
        faults.push(("least_spacing_m".into(), SettingFault::LeastSpacing));
    }
    let unsound = inputs.iter().enumerate().filter(|(_, input)| !input.is_sound());
    faults.extend(unsound.map(|(i, input)| (format!("inputs.{i}"), SettingFault::Input(input.feature))));
    faults
}
