//! Checks that an evaluation's engine and road can take its settings. In: the command line. Out: an error with a remedy.

use super::{
    CliError,
    plan::{Engine, asked_policies},
};
use crate::{
    map::{self, RoadMap},
    policy,
    settings::fields_of,
    traffic::{EngineChoice, FollowingModel, ModelMixture},
    train::TrainConfig,
};
use clap::{ArgMatches, parser::ValueSource};

/// Settings of rings that whole drives do not have.
const OF_RINGS: [&str; 6] =
    ["circumference_min_m", "circumference_max_m", "least_spacing_m", "idm_spread", "car_spread", "truck_share"];

fn is_asked(matches: &ArgMatches, setting: &str) -> bool {
    matches.value_source(setting) == Some(ValueSource::CommandLine)
}

/// Fails if whole drives are asked for something that only the fast ring has.
pub(super) fn check_whole(matches: &ArgMatches, config: &TrainConfig) -> Result<(), CliError> {
    let mut fields = fields_of::<TrainConfig>().into_iter();
    if let Some(field) = fields.find(|field| OF_RINGS.contains(&field.path.as_str()) && is_asked(matches, &field.path))
    {
        return Err(CliError::Input(format!(
            "--{} is for traffic ring; the road of whole drives is a map, and their vehicles are alike\n  remedy: \
             --map NAME or FILE, such as --map ring-260, or --traffic ring",
            field.flag()
        )));
    }
    let [min, max] = [config.ring.vehicles_min, config.ring.vehicles_max];
    if is_asked(matches, "vehicles_max") && min != max {
        return Err(CliError::Input(format!(
            "--vehicles-max is {max} and --vehicles-min {min}; whole drives have the same number of vehicles\n  remedy: the same number \
             for both, or --traffic ring"
        )));
    }
    Ok(())
}

/// Fails if a road was named that the fast ring does not have.
pub(super) fn check_ring(matches: &ArgMatches, map: &str, road: &RoadMap) -> Result<(), CliError> {
    if !is_asked(matches, "map") || map::known_as(road).and_then(|name| TrainConfig::of_ring(&name)).is_some() {
        return Ok(());
    }
    Err(CliError::Input(format!(
        "map {map} is for whole drives; traffic ring has {} and the rings of a configuration\n  remedy: --traffic native \
         or --traffic sumo",
        TrainConfig::RINGS.join(", ")
    )))
}

/// Fails if an evaluation on a network lacks a setting for which only rings have a default.
pub(super) fn check_network(matches: &ArgMatches, map: &str, engine: &Engine) -> Result<(), CliError> {
    let lacks = if *engine != Engine::Traffic(EngineChoice::Sumo) {
        format!("traffic {engine} is for closed routes\n  remedy: --traffic sumo")
    } else if !matches.contains_id("advised") {
        "the advised vehicles are a share of the vehicles that enter\n  remedy: --advised 10%,25%".into()
    } else if asked_policies(matches).is_none_or(|mut names| names.any(|name| name == policy::AUTO)) {
        "--policy auto has no policy there\n  remedy: --policy pi, or constant, follower-stopper or linear-feedback \
         with --policy-speed, or a file"
            .into()
    } else {
        return Ok(());
    };
    Err(CliError::Input(format!("map {map} is a network that vehicles enter and leave: {lacks}")))
}

/// Returns the model and the share of other vehicles with a different model, from the command line.
pub(super) fn mixture(matches: &ArgMatches, engine: &Engine) -> Result<ModelMixture, CliError> {
    let word = matches.get_one::<String>("other-model").map_or("", String::as_str);
    let model = FollowingModel::ALL.into_iter().find(|model| model.name() == word).unwrap_or_default();
    let share = matches.get_one::<f64>("other-model-share").copied().unwrap_or(1.0);
    if !(0.0..=1.0).contains(&share) {
        return Err(CliError::Input(format!("--other-model-share is {share}; allowed: 0 to 1")));
    }
    if model != FollowingModel::Idm && *engine != Engine::Traffic(EngineChoice::Sumo) {
        return Err(CliError::Input(format!(
            "--other-model is {word}; traffic {engine} has only idm\n  remedy: --traffic sumo"
        )));
    }
    Ok(ModelMixture { model, share })
}
