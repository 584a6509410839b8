//! Checks of a training's configuration. In: a [`TrainConfig`]. Out: the keys of settings that do not fit the others, each with the
//! reason.

use super::{TrainConfig, config::ActionKind, drawn_ring::TRUCK_LENGTH_M, inputs::check_names};
use crate::{
    policy::{Feature, Hold, NetworkInput, RoadKind},
    scenario::AdvisedVehicles,
    settings::{SettingFault, Settings},
    space::CAR_LENGTH_M,
    time::is_whole_ticks,
    traffic::TrafficDrivers,
};

impl Settings for TrainConfig {
    fn faults(&self) -> Vec<SettingFault> {
        [self.advice_faults(), self.ring_faults(), self.learning_faults()].concat()
    }
}

impl TrainConfig {
    /// Returns the faults of steps, holds and the advice, and of what the policy observes.
    fn advice_faults(&self) -> Vec<SettingFault> {
        let mut faults = Vec::new();
        let mut add = |key: &str, others, message: String| faults.push(SettingFault::new(key, others, message));
        if !is_whole_ticks(self.ring.step_s) {
            add("step_s", &[], format!("step_s is {}; allowed: a multiple of 0.01 s", self.ring.step_s));
        }
        if let Err(fault) = Hold::new(self.advice.hold_s, self.ring.step_s) {
            add("hold_s", &["step_s"], fault.to_string());
        }
        let [_, longest_s] = self.holds_s();
        if longest_s > self.ring.horizon_s {
            let horizon_s = self.ring.horizon_s;
            let text = format!("the longest hold is {longest_s} s; allowed: at most the horizon, {horizon_s} s");
            add("hold_s", &["hold_max_s", "horizon_s"], text);
        }
        if self.is_residual() && self.advice.action == ActionKind::Acceleration {
            let text = "residual_over is set; allowed: empty if action is \"acceleration\"";
            add("residual_over", &["action"], text.into());
        }
        if self.probe().is_some() && self.advice.action == ActionKind::Acceleration {
            let text = format!("probe_mps is {}; allowed: 0 if action is \"acceleration\"", self.advice.probe_mps);
            add("probe_mps", &["action"], text);
        }
        if !self.is_residual() && self.inputs().iter().any(|input| input.feature == Feature::ControllerSpeed) {
            let text = "sees names `controller_speed`; allowed: only if residual_over is set";
            add("sees", &["residual_over"], text.into());
        }
        if let Err(fault) = check_names(&self.network.sees) {
            add("sees", &[], fault);
        }
        if let Some(input) = self.inputs().iter().find(|input| !input.feature.is_seen_on(RoadKind::BareRing)) {
            let text = format!("sees names `{}`, which training rings do not have", input.feature.name());
            add("sees", &[], text);
        }
        if self.advice.levels == 1 {
            add("levels", &[], "levels is 1; allowed: 0 (continuous) or at least 2".into());
        }
        faults
    }

    /// Returns the faults of the rings and their vehicles.
    fn ring_faults(&self) -> Vec<SettingFault> {
        let ring = &self.ring;
        let mut faults = Vec::new();
        let mut add = |key: &str, others, message: String| faults.push(SettingFault::new(key, others, message));
        if ring.vehicles_max < ring.vehicles_min {
            let text =
                format!("vehicles_max is {}; allowed: from vehicles_min, {}", ring.vehicles_max, ring.vehicles_min);
            add("vehicles_max", &["vehicles_min"], text);
        }
        if ring.circumference_max_m < ring.circumference_min_m {
            let text = format!(
                "circumference_max_m is {}; allowed: from circumference_min_m, {}",
                ring.circumference_max_m, ring.circumference_min_m
            );
            add("circumference_max_m", &["circumference_min_m"], text);
        }
        if let Err((key, text)) = self.check_of_advised() {
            add(key, &["vehicles_min", "vehicles_max", "estimator_rounds", "silence_rings"], text);
        }
        if let Err((key, text)) = self.check_of_drivers() {
            add(key, &["traffic_drivers"], text);
        }
        let length_m = if ring.truck_share > 0.0 { TRUCK_LENGTH_M } else { CAR_LENGTH_M };
        let car_m = length_m + ring.idm.s0 * (1.0 + ring.idm_spread) * (1.0 + ring.car_spread);
        if ring.circumference_min_m < f64::from(ring.vehicles_max) * car_m {
            let most = (ring.circumference_min_m / car_m).floor();
            let text = format!(
                "vehicles_max is {}; allowed: at most {most}, as many as fit on {} m",
                ring.vehicles_max, ring.circumference_min_m
            );
            add("vehicles_max", &["circumference_min_m", "truck_share", "idm", "idm_spread", "car_spread"], text);
        }
        if ring.circumference_max_m < f64::from(ring.vehicles_max) * ring.least_spacing_m {
            let text = format!(
                "least_spacing_m is {}; allowed: at most {:.2}, the road per vehicle on circumference_max_m with {} \
                 vehicles",
                ring.least_spacing_m,
                ring.circumference_max_m / f64::from(ring.vehicles_max),
                ring.vehicles_max
            );
            add("least_spacing_m", &["circumference_max_m", "vehicles_max"], text);
        }
        faults
    }

    /// Returns the faults of the learning: numbers of rings, silence, estimator and scaling.
    fn learning_faults(&self) -> Vec<SettingFault> {
        let mut faults = Vec::new();
        let mut add = |key: &str, others, message: String| faults.push(SettingFault::new(key, others, message));
        let silence_rings = self.silence.silence_rings;
        for (key, rings) in [("rings", self.run.rings), ("silence_rings", silence_rings)] {
            if !rings.is_multiple_of(super::simd::LANES as u32) {
                add(key, &[], format!("{key} is {rings}; allowed: a multiple of 16"));
            }
        }
        if silence_rings > 0 && self.lasting_inputs().is_empty() {
            let text = format!(
                "silence_rings is {silence_rings}; allowed: 0 if sees names no lasting input: circumference, spacing, \
                 log_hold, or an input of the driver"
            );
            add("silence_rings", &["sees"], text);
        }
        if let Err((key, text)) = self.check_of_driver() {
            let others: &[&str] =
                if key == "sees" { &["estimator", "latents"] } else { &["sees", "estimator", "latents"] };
            add(key, others, text);
        }
        if !self.inputs().iter().all(NetworkInput::is_sound) {
            add("scaling", &["sees"], "scaling: each `to` must be above its `from`".into());
        }
        faults
    }
}

impl TrainConfig {
    /// Checks the number of advised vehicles, which is the same on all rings.
    fn check_of_advised(&self) -> Result<(), (&'static str, String)> {
        let (advised, [min, max]) = (self.ring.advised, [self.ring.vehicles_min, self.ring.vehicles_max]);
        let refused = |allowed: String| Err(("advised", format!("advised is {advised}; allowed: {allowed}")));
        if advised.is_no_vehicle() || matches!(advised, AdvisedVehicles::Count(count) if count > max) {
            return refused(format!("1 to {max}, as many as there are vehicles, or a share such as 20%"));
        }
        if advised.of(max) == 1 {
            return Ok(());
        }
        if min != max {
            return refused(format!(
                "1, as rings have {min} to {max} vehicles; others need the same number on all rings"
            ));
        }
        let [rounds, rings] = [self.student.estimator_rounds, self.silence.silence_rings];
        for (key, value) in [("estimator_rounds", rounds), ("silence_rings", rings)] {
            if value > 0 {
                return refused(format!("1 if {key} is above 0; it is {value}"));
            }
        }
        Ok(())
    }

    /// Checks the drivers of the other vehicles: people have spreads of their own.
    fn check_of_drivers(&self) -> Result<(), (&'static str, String)> {
        let ring = &self.ring;
        let mut are_alike = true;
        for name in ring.populations() {
            let drivers = TrafficDrivers::named(name, ring.idm).map_err(|error| ("traffic_drivers", error.0))?;
            are_alike &= drivers.are_alike();
        }
        let spreads =
            [("idm_spread", ring.idm_spread), ("car_spread", ring.car_spread), ("truck_share", ring.truck_share)];
        match spreads.into_iter().find(|(_, value)| *value != 0.0 && !are_alike) {
            Some((key, value)) => {
                let name = &ring.traffic_drivers;
                Err((key, format!("{key} is {value}; allowed with traffic_drivers {name}: 0; its persons differ")))
            }
            None => Ok(()),
        }
    }

    /// Checks that the estimator provides every driver input of the policy.
    fn check_of_driver(&self) -> Result<(), (&'static str, String)> {
        let known = self.known_of_driver();
        let names = known.iter().map(|feature| feature.name()).collect::<Vec<_>>().join(", ");
        let seen = self.inputs().into_iter().map(|input| input.feature).find(|feature| feature.is_of_driver());
        let rounds = self.student.estimator_rounds;
        if rounds > 0 && seen.is_none() {
            let text =
                format!("estimator_rounds is {rounds}; allowed: 0 if sees names no input of the driver ({names})");
            return Err(("estimator_rounds", text));
        }
        let is_foreign = |input: &NetworkInput| input.feature.is_of_driver() && !known.contains(&input.feature);
        if let Some(input) = self.inputs().iter().find(|input| is_foreign(input)) {
            let text = format!(
                "sees names `{}`, which this estimator does not estimate; allowed inputs of the driver: {names}",
                input.feature.name()
            );
            return Err(("sees", text));
        }
        if rounds == 0 && seen.is_some_and(Feature::is_latent) {
            return Err((
                "estimator_rounds",
                "estimator_rounds is 0; allowed: at least 1 if sees names latents".into(),
            ));
        }
        Ok(())
    }
}
