//! Kinds of controllers. In: a kind and the road, or numbers. Out: a [`Controller`] with its parameters and their faults.

use super::{
    ConstantSpeed, FollowerStopper, LinearFeedback, PiParameters, TwoPhase,
    parameters::{Order, Parameter, Parametric, ordered},
};
use crate::policy::PolicySettings;
use serde::{Deserialize, Serialize};

/// A controller with its parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Controller {
    /// One speed for the whole drive.
    Constant(ConstantSpeed),
    /// A slow phase, then the final speed.
    TwoPhase(TwoPhase),
    FollowerStopper(FollowerStopper),
    /// PI with saturation and its parameters.
    Pi(PiParameters),
    LinearFeedback(LinearFeedback),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ControllerKind {
    /// One speed for the whole drive.
    Constant,
    /// A slow phase, then the final speed.
    TwoPhase,
    FollowerStopper,
    Pi,
    LinearFeedback,
}

/// All kinds, in the order of [`crate::policy::NAMES`].
pub const CONTROLLERS: [ControllerKind; 5] = [
    ControllerKind::Constant,
    ControllerKind::TwoPhase,
    ControllerKind::FollowerStopper,
    ControllerKind::Pi,
    ControllerKind::LinearFeedback,
];

impl ControllerKind {
    /// Returns the name on the command line and in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::TwoPhase => "two-phase",
            Self::FollowerStopper => "follower-stopper",
            Self::Pi => "pi",
            Self::LinearFeedback => "linear-feedback",
        }
    }

    /// Returns the kind with this name.
    pub fn named(name: &str) -> Option<Self> {
        CONTROLLERS.into_iter().find(|kind| kind.name() == name)
    }

    /// Returns the parameters in the order of the file.
    pub fn parameters(self) -> &'static [Parameter] {
        match self {
            Self::Constant => ConstantSpeed::PARAMETERS,
            Self::TwoPhase => TwoPhase::PARAMETERS,
            Self::FollowerStopper => FollowerStopper::PARAMETERS,
            Self::Pi => PiParameters::PARAMETERS,
            Self::LinearFeedback => LinearFeedback::PARAMETERS,
        }
    }
}

impl Controller {
    /// Returns the controller of a name on a road: its authors' parameters, and the set or automatic target speed.
    pub fn by_name(kind: ControllerKind, settings: &PolicySettings) -> Self {
        let aim_mps = settings.aim_or_automatic_mps();
        match kind {
            ControllerKind::Constant => Self::Constant(ConstantSpeed { speed_mps: aim_mps }),
            ControllerKind::TwoPhase => Self::TwoPhase(TwoPhase::for_ring(settings.equilibrium_mps, aim_mps)),
            ControllerKind::FollowerStopper => Self::FollowerStopper(FollowerStopper::published(aim_mps)),
            ControllerKind::Pi => Self::Pi(PiParameters::default()),
            ControllerKind::LinearFeedback => Self::LinearFeedback(LinearFeedback::around(aim_mps)),
        }
    }

    /// Returns the controller with these parameter values.
    ///
    /// # Panics
    /// Panics if there are fewer numbers than parameters.
    pub fn of(kind: ControllerKind, numbers: &[f64]) -> Self {
        match kind {
            ControllerKind::Constant => Self::Constant(ConstantSpeed::of(numbers)),
            ControllerKind::TwoPhase => Self::TwoPhase(TwoPhase::of(numbers)),
            ControllerKind::FollowerStopper => Self::FollowerStopper(FollowerStopper::of(numbers)),
            ControllerKind::Pi => Self::Pi(PiParameters::of(numbers)),
            ControllerKind::LinearFeedback => Self::LinearFeedback(LinearFeedback::of(numbers)),
        }
    }

    /// Returns the controller after moving each number as little as the order of the parameters requires.
    ///
    /// # Panics
    /// Panics if there are fewer numbers than parameters.
    pub fn of_ordered(kind: ControllerKind, numbers: &[f64]) -> Self {
        Self::of(kind, &ordered(kind.parameters(), numbers))
    }

    /// Returns the kind of this controller.
    pub fn kind(&self) -> ControllerKind {
        match self {
            Self::Constant(_) => ControllerKind::Constant,
            Self::TwoPhase(_) => ControllerKind::TwoPhase,
            Self::FollowerStopper(_) => ControllerKind::FollowerStopper,
            Self::Pi(_) => ControllerKind::Pi,
            Self::LinearFeedback(_) => ControllerKind::LinearFeedback,
        }
    }

    /// Returns the parameter values in the order of [`ControllerKind::parameters`].
    pub fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Constant(controller) => controller.numbers(),
            Self::TwoPhase(controller) => controller.numbers(),
            Self::FollowerStopper(controller) => controller.numbers(),
            Self::Pi(parameters) => parameters.numbers(),
            Self::LinearFeedback(controller) => controller.numbers(),
        }
    }

    /// Returns the first parameter outside its limits or out of order, its value and the allowed values.
    pub fn fault(&self) -> Option<(Parameter, f64, String)> {
        let (parameters, numbers) = (self.kind().parameters(), self.numbers());
        (0..numbers.len()).find_map(|k| {
            let (parameter, number) = (parameters[k], numbers[k]);
            if !parameter.allows(number) {
                return Some((parameter, number, parameter.allowed()));
            }
            let before = k.checked_sub(1).map(|before| numbers[before])?;
            let order = if parameter.order == Order::Above { "more than" } else { "at most" };
            (!parameter.follows(before, number)).then(|| (parameter, number, format!("{order} {before}")))
        })
    }
}
