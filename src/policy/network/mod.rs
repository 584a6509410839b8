//! A trained network as a policy, and its file. In: an [`Observation`]. Out: an [`Action`]. The TOML file holds everything needed to use
//! the network: kind of action, limits, holds, inputs and layers as plain numbers.

mod assisted;
mod corrected;
mod expected_gain;
mod fault;
mod file;

pub use assisted::{AssistedPolicy, residual};
pub(super) use corrected::stands_alone;
pub use corrected::{CorrectedAdvice, EngagedAdvice};
pub use expected_gain::ExpectedGain;
pub(super) use fault::setting_faults;
pub use fault::{CorrectionFault, ExpectedGainFault, NotCorrectable, PolicyNetworkFault, SettingFault};

use super::{
    Action, DriverEstimator, FORMAT, NetworkInput, NetworkLayer, Observation, Policy, PolicyFileError, PolicyFileFault,
    Probe,
    features::withholds_advice,
    file_text::is_zero,
    layers::{check_layers, run_layers},
};
use crate::{
    file::read_text,
    toml_text::{self, KeyPart, did_you_mean_file},
};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Kind of a network's action.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NetworkOutput {
    /// Acceleration in m/s², kept for the hold.
    Acceleration,
    /// Target speed in m/s, driven for the hold.
    Speed,
}

/// A trained policy: the mean of a normal distribution over actions (one output), or the most probable of `levels` actions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Network {
    /// Format and version of the file, [`FORMAT`].
    pub format: String,
    /// Quantity that the network advises.
    pub action: NetworkOutput,
    /// Lowest and highest action, m/s² or m/s: at outputs -1 and 1, or at the first and the last level.
    pub limits: [f64; 2],
    /// Largest change of speed caused by an acceleration within one hold, m/s; 0: no bound. Wider limits are narrowed to it
    /// ([`bounded`]).
    pub speed_change_mps: f64,
    /// Road length per vehicle, m, below which advice is withheld; 0: never withheld.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub least_spacing_m: f64,
    /// Number of discrete levels; 0: continuous action.
    pub levels: u32,
    /// Shortest and longest hold in training, s.
    pub holds_s: [f64; 2],
    /// Largest share of advised vehicles in training, 0 to 1; 0: one vehicle.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub advised_share: f64,
    /// Inputs of the first layer, in order.
    pub inputs: Vec<NetworkInput>,
    /// Layers from the inputs to the action.
    #[serde(rename = "layer")]
    pub layers: Vec<NetworkLayer>,
    /// Advice that the policy corrects, if any; the action is then added to that speed, m/s.
    #[serde(default, rename = "controller", skip_serializing_if = "Option::is_none")]
    pub corrected: Option<CorrectedAdvice>,
    /// Probe of the driver, if the policy probes them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probe: Option<Probe>,
    /// Estimator of the driver's traits or latents, if the policy uses them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub estimator: Option<DriverEstimator>,
    /// Predictor of the gain from advice, used to withhold advice, if trained.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected_gain: Option<ExpectedGain>,
}

/// Largest policy file, bytes; two layers of 64 units take 0.1 MB.
pub const MOST_BYTES: u64 = 2 << 20;

/// Reads the text of a policy file.
pub(super) fn read(path: &Path) -> Result<String, PolicyFileError> {
    read_text(path, MOST_BYTES).map_err(|source| {
        PolicyFileError::new(path, PolicyFileFault::Unreadable { source, near: did_you_mean_file(path) })
    })
}

impl Network {
    /// Reads a policy file.
    ///
    /// # Errors
    /// The file cannot be read, is no policy file, its layers are inconsistent, or a number is not finite.
    pub fn from_file(path: &Path) -> Result<Self, PolicyFileError> {
        Self::from_text_of(path, &read(path)?)
    }

    /// Parses the text of the policy file at `path`; the path is used in errors only.
    pub(super) fn from_text_of(path: &Path, text: &str) -> Result<Self, PolicyFileError> {
        Self::parse(text, &path.display().to_string()).map_err(|why| PolicyFileError::new(path, why.into()))
    }

    /// Parses the text of a policy file.
    ///
    /// # Errors
    /// The text is no policy file, its layers are inconsistent, or a number is out of range. The message has all mistakes.
    pub fn from_toml(text: &str) -> Result<Self, PolicyNetworkFault> {
        Self::parse(text, "policy")
    }

    /// Parses the text of a policy file; `name` is the name of the text in messages.
    fn parse(text: &str, name: &str) -> Result<Self, PolicyNetworkFault> {
        let (network, mut mistakes) = toml_text::read::<Self>(text, name);
        for (key, others, fault) in network.iter().flat_map(Self::faults) {
            mistakes.add_related(&key, others, KeyPart::Value, &fault.to_string());
        }
        toml_text::finished((network, mistakes)).map_err(PolicyNetworkFault::File)
    }

    /// Checks that the network can be used as a policy.
    ///
    /// # Errors
    /// The format is another, the layers are inconsistent, or a number is out of range.
    pub fn check(&self) -> Result<(), PolicyNetworkFault> {
        self.faults().into_iter().next().map_or(Ok(()), |(.., fault)| Err(fault))
    }

    /// Returns the reasons for which the network cannot be used as a policy, each with its key in the file and the keys because of which
    /// it is one.
    fn faults(&self) -> Vec<(String, &'static [&'static str], PolicyNetworkFault)> {
        let mut faults = Vec::new();
        let mut add = |key: &str, others: &'static [&'static str], fault: Option<PolicyNetworkFault>| {
            faults.extend(fault.map(|fault| (key.to_owned(), others, fault)));
        };
        add("format", &[], (self.format != FORMAT).then(|| PolicyNetworkFault::Format(self.format.clone())));
        let outputs = if self.levels == 0 { 1 } else { self.levels as usize };
        add(
            "layer",
            &["levels", "inputs"],
            check_layers(&self.layers, self.inputs.len(), outputs).err().map(Into::into),
        );
        let settings = setting_faults(self.limits, self.speed_change_mps, self.least_spacing_m, &self.inputs);
        settings.into_iter().for_each(|(key, fault)| add(&key, &[], Some(fault.into())));
        let [shortest, longest] = self.holds_s;
        let is_sound = self.levels != 1 && shortest > 0.0 && shortest <= longest && longest.is_finite();
        add("holds_s", &["levels"], (!is_sound).then_some(PolicyNetworkFault::LevelsOrHolds));
        let corrected =
            self.corrected.as_ref().and_then(|advice| advice.check(self.action, self.least_spacing_m).err());
        add("controller", &["action", "least_spacing_m"], corrected.map(Into::into));
        add("probe", &["action"], self.probe.as_ref().and_then(|probe| probe.check(self.action).err()).map(Into::into));
        if let Some(estimator) = &self.estimator {
            let expects = self.expected_gain.iter().flat_map(|gain| &gain.inputs);
            let told = || estimator.check_tells(self.inputs.iter().chain(expects).map(|input| input.feature));
            add(
                "estimator",
                &["inputs", "expected_gain"],
                estimator.check().and_then(|()| told()).err().map(Into::into),
            );
        }
        add("expected_gain", &[], self.expected_gain.as_ref().and_then(|gain| gain.check().err()).map(Into::into));
        faults
    }

    /// Returns the last layer's outputs. The hold is clamped to the range of training, so that a policy trained on holds of a second can
    /// be asked ten times a second.
    pub fn outputs(&self, observation: &Observation) -> Vec<f32> {
        self.with_outputs(observation, <[f32]>::to_vec)
    }

    /// Returns the result of `look` on the last layer's outputs, without copying them.
    fn with_outputs<T>(&self, observation: &Observation, look: impl FnOnce(&[f32]) -> T) -> T {
        let hold_s = observation.hold_s.clamp(self.holds_s[0], self.holds_s[1]);
        let observation = &Observation { hold_s, ..*observation };
        run_layers(&self.layers, self.inputs.iter().map(|input| input.scaled(observation)), look)
    }

    /// Returns the action without exploration noise.
    pub fn action(&self, observation: &Observation) -> Action {
        self.with_outputs(observation, |outputs| self.chosen(outputs, observation))
    }

    /// Returns the number of the action: the advised speed, m/s, for a speed policy.
    pub fn speed_mps(&self, observation: &Observation) -> f64 {
        let (Action::Speed(value) | Action::Acceleration(value)) = self.action(observation);
        value
    }

    fn chosen(&self, outputs: &[f32], observation: &Observation) -> Action {
        let [low, high] = match self.action {
            NetworkOutput::Acceleration => bounded(self.limits, self.speed_change_mps, observation.hold_s),
            NetworkOutput::Speed => self.limits,
        };
        let share = if self.levels == 0 {
            (f64::from(outputs[0]).clamp(-1.0, 1.0) + 1.0) / 2.0
        } else {
            // The first of equal levels wins.
            let best = (0..outputs.len()).fold(0, |best, i| if outputs[i] > outputs[best] { i } else { best });
            best as f64 / f64::from(self.levels - 1)
        };
        self.scaled_action(low + (high - low) * share)
    }

    fn scaled_action(&self, value: f64) -> Action {
        match self.action {
            NetworkOutput::Acceleration => Action::Acceleration(value),
            NetworkOutput::Speed => Action::Speed(value),
        }
    }
}

/// Returns the acceleration limits narrowed so that a hold of `hold_s` changes the speed by at most `speed_change_mps` (0: no bound).
pub fn bounded(limits: [f64; 2], speed_change_mps: f64, hold_s: f64) -> [f64; 2] {
    if speed_change_mps <= 0.0 || hold_s <= 0.0 {
        return limits;
    }
    let most = speed_change_mps / hold_s;
    [limits[0].max(-most), limits[1].min(most)]
}

/// The layers alone. Estimator, corrected advice, probe and silence of a policy's file are in [`Network::policy`].
impl Policy for Network {
    fn act(&mut self, _time_s: f64, observation: &Observation) -> Action {
        self.action(observation)
    }

    fn abstains(&mut self, _time_s: f64, observation: &Observation) -> bool {
        withholds_advice(observation, self.least_spacing_m)
    }

    fn needs_driver_traits(&self) -> bool {
        self.inputs.iter().any(|input| input.feature.is_of_driver())
    }

    fn inputs(&self) -> &[NetworkInput] {
        &self.inputs
    }

    fn trained_holds_s(&self) -> Option<[f64; 2]> {
        Some(self.holds_s)
    }

    fn advised_share(&self) -> f64 {
        self.advised_share
    }
}

#[cfg(test)]
impl Network {
    /// Returns a network for tests that advises 0 to 10 m/s, for holds of 1 to 30 s.
    pub(crate) fn advising_speed(inputs: Vec<NetworkInput>, layers: Vec<NetworkLayer>) -> Self {
        Self {
            format: FORMAT.into(),
            action: NetworkOutput::Speed,
            limits: [0.0, 10.0],
            speed_change_mps: 0.0,
            least_spacing_m: 0.0,
            levels: 0,
            holds_s: [1.0, 30.0],
            advised_share: 0.0,
            inputs,
            layers,
            corrected: None,
            probe: None,
            estimator: None,
            expected_gain: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::policy::{FIELD_INPUTS, Feature};

    fn small(levels: u32, outputs: usize) -> Network {
        let weights = |n: usize, m: usize| -> Vec<Vec<f32>> {
            (0..n).map(|i| (0..m).map(|j| ((i * 7 + j * 3) % 11) as f32 / 9.0 - 0.5).collect()).collect()
        };
        let layers = vec![
            NetworkLayer { bias: vec![0.1, -0.2, 1.0 / 3.0], weights: weights(4, 3) },
            NetworkLayer { bias: vec![0.05; outputs], weights: weights(3, outputs) },
        ];
        Network {
            action: NetworkOutput::Acceleration,
            limits: [-0.5, 0.5],
            least_spacing_m: if levels == 0 { 8.6 } else { 0.0 },
            levels,
            ..Network::advising_speed(FIELD_INPUTS.to_vec(), layers)
        }
    }

    /// Returns a predictor whose gain falls by 1 m/s per unit of input, from `middle_mps` at 10 m of road per vehicle.
    fn gain(middle_mps: f32) -> ExpectedGain {
        let layers = vec![NetworkLayer { bias: vec![middle_mps], weights: vec![vec![-1.0]] }];
        let inputs = vec![NetworkInput { feature: Feature::Spacing, from: 9.0, to: 11.0 }];
        ExpectedGain { silent_below_mps: 0.25, inputs, layers }
    }

    #[test]
    fn a_policy_survives_the_round_trip_through_its_file() {
        let with_gain = Network { expected_gain: Some(gain(1.0 / 3.0)), ..small(0, 1) };
        let probe = Some(Probe { amplitude_mps: 0.2, period_s: 4.0, duration_s: 60.0 });
        let probing = Network { action: NetworkOutput::Speed, probe, ..small(0, 1) };
        let of_acceleration = Network { probe, ..small(0, 1) };
        assert_eq!(of_acceleration.check(), Err(SettingFault::Probe.into()));
        for network in [small(0, 1), small(5, 5), with_gain, probing] {
            assert_eq!(Network::from_toml(&network.to_toml()).unwrap(), network);
        }
    }

    #[test]
    fn a_policy_withholds_advice_where_it_expects_too_little_gain() {
        let network = Network { expected_gain: Some(gain(0.5)), least_spacing_m: 0.0, ..small(0, 1) };
        let mut policy = network.policy(0.1);
        // With 22 vehicles, 10 m each is the middle of the input range, where 0.5 m/s are expected; 10.5 m each gives -0.5 m/s.
        let on =
            |spacing_m: f64| Observation { circumference_m: 22.0 * spacing_m, vehicles: 22, ..Observation::default() };
        assert!(!policy.abstains(0.0, &on(10.0)) && !policy.abstains(0.0, &on(10.24)));
        // Withheld advice stays withheld for ten minutes.
        assert!(policy.abstains(1.0, &on(10.26)) && policy.abstains(600.0, &on(10.0)));
        assert!(!policy.abstains(601.0, &on(10.0)) && policy.abstains(602.0, &on(10.5)));
    }

    #[test]
    fn actions_lie_within_their_limits() {
        let far = Observation { speed_mps: 500.0, leader_speed_mps: -500.0, gap_m: 1e5, ..Observation::default() };
        for network in [small(0, 1), small(5, 5)] {
            for observation in [far, Observation::default()] {
                let Action::Acceleration(a) = network.action(&observation) else { panic!("an acceleration policy") };
                assert!((-0.5..=0.5).contains(&a), "{a}");
            }
        }
    }

    #[test]
    fn an_inconsistent_network_is_refused_with_the_fault() {
        let fault = |change: fn(&mut Network)| {
            let mut network = small(0, 1);
            change(&mut network);
            let report = Network::from_toml(&network.to_toml()).unwrap_err().to_string();
            assert!(report.starts_with("is not a policy file\npolicy:"), "{report}");
            network.check().unwrap_err().to_string()
        };
        assert_eq!(fault(|n| n.levels = 3), "the last layer has 1 outputs; allowed: 3");
        assert_eq!(fault(|n| n.limits = [1.0, 1.0]), "limits are 1 to 1; the first must be below the second");
        assert_eq!(fault(|n| n.least_spacing_m = -1.0), "least_spacing_m must be 0 or more");
        assert_eq!(fault(|n| n.inputs[2].to = 0.0), "input gap: `to` must be above `from`");
        let wide = NetworkLayer { bias: vec![0.0; 2], weights: vec![vec![0.0; 2]] };
        let two = ExpectedGain { layers: vec![wide], ..gain(0.0) };
        let mut network = small(0, 1);
        network.expected_gain = Some(two);
        let message = network.check().unwrap_err().to_string();
        assert_eq!(message, "expected_gain: the last layer has 2 outputs; allowed: 1");
        let message = fault(|n| n.expected_gain = Some(ExpectedGain { silent_below_mps: f64::INFINITY, ..gain(0.0) }));
        assert_eq!(message, "expected_gain: silent_below_mps must be a finite number");
        assert!(fault(|n| n.layers[0].weights.truncate(3)).starts_with("layer 0 has 3 inputs"));
        assert_eq!(fault(|n| n.layers[1].bias[0] = f32::NAN), "layer 1 holds a number that is not finite");
        let study = Network::from_toml("[[segment]]\nkind = \"text\"").unwrap_err().to_string();
        assert!(study.contains("policy:1:3: unknown key `segment`: the file is a study"), "{study}");
        assert!(Network::from_toml("speed = 3").unwrap_err().to_string().starts_with("is not a policy file"));
    }

    #[test]
    fn all_mistakes_of_a_file_are_in_one_report() {
        let network = Network { limits: [1.0, 1.0], least_spacing_m: -1.0, ..small(0, 1) };
        let text = network.to_toml().replacen("levels = 0", "levles = 0", 1);
        let report = Network::from_toml(&text).unwrap_err().to_string();
        for part in ["unknown key `levles`; did you mean `levels`?", "limits are 1 to 1", "least_spacing_m must be"] {
            assert_eq!(report.matches(part).count(), 1, "{report}");
        }
        assert_eq!(report.matches("\npolicy:").count(), 3, "{report}");
    }
}
