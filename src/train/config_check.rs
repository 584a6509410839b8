//! Checks of a training's configuration. In: a [`TrainConfig`]. Out: the key of the first setting that does not fit the others, and the
//! reason.

use super::{TrainConfig, config::ActionKind, drawn_ring::TRUCK_LENGTH_M, inputs::check_names};
use crate::{
    policy::{Feature, Hold, NetworkInput, RoadKind},
    scenario::AdvisedVehicles,
    settings::Settings,
    space::CAR_LENGTH_M,
    time::is_whole_ticks,
    traffic::TrafficDrivers,
};

impl Settings for TrainConfig {
    fn check(&self) -> Result<(), (String, String)> {
        self.check_relations().map_err(|(key, message)| (key.into(), message))
    }
}

impl TrainConfig {
    fn check_relations(&self) -> Result<(), (&'static str, String)> {
        if !is_whole_ticks(self.ring.step_s) {
            return Err(("step_s", format!("step_s is {}; allowed: a multiple of 0.01 s", self.ring.step_s)));
        }
        if let Err(fault) = Hold::new(self.advice.hold_s, self.ring.step_s) {
            return Err(("hold_s", fault.to_string()));
        }
        if self.holds_s()[1] > self.ring.horizon_s {
            let text = format!(
                "the longest hold is {} s; allowed: at most the horizon, {} s",
                self.holds_s()[1],
                self.ring.horizon_s
            );
            return Err(("hold_s", text));
        }
        if self.is_residual() && self.advice.action == ActionKind::Acceleration {
            let text = "residual_over is set; allowed: empty if action is \"acceleration\"";
            return Err(("residual_over", text.into()));
        }
        if self.probe().is_some() && self.advice.action == ActionKind::Acceleration {
            let text = format!("probe_mps is {}; allowed: 0 if action is \"acceleration\"", self.advice.probe_mps);
            return Err(("probe_mps", text));
        }
        if !self.is_residual() && self.inputs().iter().any(|input| input.feature == Feature::ControllerSpeed) {
            return Err(("sees", "sees names `controller_speed`; allowed: only if residual_over is set".into()));
        }
        if let Err(fault) = check_names(&self.network.sees) {
            return Err(("sees", fault));
        }
        if let Some(input) = self.inputs().iter().find(|input| !input.feature.is_seen_on(RoadKind::BareRing)) {
            let text = format!("sees names `{}`, which training rings do not have", input.feature.name());
            return Err(("sees", text));
        }
        if self.advice.levels == 1 {
            return Err(("levels", "levels is 1; allowed: 0 (continuous) or at least 2".into()));
        }
        if self.ring.vehicles_max < self.ring.vehicles_min {
            let text = format!(
                "vehicles_max is {}; allowed: from vehicles_min, {}",
                self.ring.vehicles_max, self.ring.vehicles_min
            );
            return Err(("vehicles_max", text));
        }
        if self.ring.circumference_max_m < self.ring.circumference_min_m {
            let text = format!(
                "circumference_max_m is {}; allowed: from circumference_min_m, {}",
                self.ring.circumference_max_m, self.ring.circumference_min_m
            );
            return Err(("circumference_max_m", text));
        }
        self.check_of_advised()?;
        self.check_of_drivers()?;
        let length_m = if self.ring.truck_share > 0.0 { TRUCK_LENGTH_M } else { CAR_LENGTH_M };
        let car_m = length_m + self.ring.idm.s0 * (1.0 + self.ring.idm_spread) * (1.0 + self.ring.car_spread);
        if self.ring.circumference_min_m < f64::from(self.ring.vehicles_max) * car_m {
            let most = (self.ring.circumference_min_m / car_m).floor();
            let text = format!(
                "vehicles_max is {}; allowed: at most {most}, as many as fit on {} m",
                self.ring.vehicles_max, self.ring.circumference_min_m
            );
            return Err(("vehicles_max", text));
        }
        if self.ring.circumference_max_m < f64::from(self.ring.vehicles_max) * self.ring.least_spacing_m {
            let text = format!(
                "least_spacing_m is {}; allowed: at most {:.2}, the road per vehicle on circumference_max_m with {} \
                 vehicles",
                self.ring.least_spacing_m,
                self.ring.circumference_max_m / f64::from(self.ring.vehicles_max),
                self.ring.vehicles_max
            );
            return Err(("least_spacing_m", text));
        }
        if !self.run.rings.is_multiple_of(super::simd::LANES as u32) {
            return Err(("rings", format!("rings is {}; allowed: a multiple of 16", self.run.rings)));
        }
        let silence_rings = self.silence.silence_rings;
        if !silence_rings.is_multiple_of(super::simd::LANES as u32) {
            return Err(("silence_rings", format!("silence_rings is {silence_rings}; allowed: a multiple of 16")));
        }
        if silence_rings > 0 && self.lasting_inputs().is_empty() {
            let text = format!(
                "silence_rings is {silence_rings}; allowed: 0 if sees names no lasting input: circumference, spacing, \
                 log_hold, or an input of the driver"
            );
            return Err(("silence_rings", text));
        }
        self.check_of_driver()?;
        if !self.inputs().iter().all(NetworkInput::is_sound) {
            return Err(("scaling", "scaling: each `to` must be above its `from`".into()));
        }
        Ok(())
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
