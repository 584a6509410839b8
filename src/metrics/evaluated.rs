//! Measures of an evaluated drive. In: an [`EvaluationResult`]. Out: each measure's number with its definition, in the order of the
//! tables of evaluations and sweeps.

use super::{EvaluationResult, Measure, registry::measure};

/// Accessor of a measure; `None` if the drive does not have it.
pub type EvaluatedValue = fn(&EvaluationResult) -> Option<f64>;

/// Measures of every evaluated drive, in order.
pub const EVALUATED: &[(Measure, EvaluatedValue)] = &[
    (measure("mean_speed_mps"), |v| Some(v.mean_speed_mps)),
    (measure("settled_speed_mps"), |v| Some(v.settled_speed_mps)),
    (measure("speed_sd_over_vehicles_mps"), |v| Some(v.speed_sd_over_vehicles_mps)),
    (measure("speed_sd_over_time_mps"), |v| Some(v.speed_sd_over_time_mps)),
    (measure("last_disturbance_s"), |v| v.last_disturbance_s),
    (measure("min_gap_to_neighbours_m"), |v| Some(v.min_gap_to_neighbours_m)),
    (measure("crashed"), |v| Some(f64::from(u8::from(v.crashed)))),
    (measure("crash_s"), |v| v.crash_s),
    (measure("fuel_l_100km"), |v| v.fuel_l_100km),
    (measure("flow_per_h"), |v| v.flow_per_h),
    (measure("time_in_range"), |v| v.time_in_range),
    (measure("min_ttc_to_neighbours_s"), |v| v.conflicts?.min_ttc_to_neighbours_s),
    (measure("max_drac_to_neighbours_mps2"), |v| Some(v.conflicts?.max_drac_to_neighbours_mps2)),
    (measure("close_approaches"), |v| Some(v.conflicts?.close_approaches.into())),
    (measure("hard_brakings_per_km"), |v| Some(v.conflicts?.hard_brakings_per_km)),
    (measure("stops_per_km"), |v| Some(v.conflicts?.stops_per_km)),
    (measure("advice_share"), |v| v.conflicts?.advice_share),
    (measure("guard_share"), |v| v.conflicts?.guard_share),
    (measure("distance_share"), |v| v.conflicts?.distance_share),
    (measure("space_mean_speed_mps"), |v| Some(v.network?.space_mean_speed_mps)),
    (measure("inflow_per_h"), |v| Some(v.network?.inflow_per_h)),
    (measure("outflow_per_h"), |v| Some(v.network?.outflow_per_h)),
    (measure("vehicles_present"), |v| Some(v.network?.vehicles_present)),
    (measure("vehicles_refused"), |v| v.network?.vehicles_refused),
    (measure("vehicles"), |v| Some(v.network?.vehicles.into())),
];

/// Returns the accessor of a measure by its name.
///
/// # Panics
/// Evaluations do not have the measure.
pub fn evaluated(name: &str) -> EvaluatedValue {
    EVALUATED.iter().find(|(measure, _)| measure.name == name).expect("a measure of evaluations").1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metrics::{Conflicts, NetworkFlow, registry::measures};

    #[test]
    fn a_result_of_a_network_is_read_as_it_was_written() {
        let result = EvaluationResult { network: Some(NetworkFlow::default()), ..EvaluationResult::default() };
        let ring = EvaluationResult { conflicts: Some(Conflicts::default()), ..EvaluationResult::default() };
        for result in [result, ring] {
            let text = serde_json::to_string(&result).unwrap();
            assert_eq!(serde_json::from_str::<EvaluationResult>(&text).unwrap(), result, "{text}");
        }
    }

    #[test]
    fn a_result_is_written_with_the_names_of_the_registry() {
        let result = EvaluationResult {
            conflicts: Some(Conflicts::default()),
            network: Some(NetworkFlow::default()),
            ..EvaluationResult::default()
        };
        let serde_json::Value::Object(mut json) = serde_json::to_value(result).unwrap() else { panic!("an object") };
        let Some(serde_json::Value::Object(network)) = json.remove("network") else { panic!("an object") };
        let written: Vec<&String> = json.keys().chain(network.keys()).collect();
        for name in &written {
            assert!(measures().any(|measure| measure.name == **name), "{name}");
        }
        assert!(EVALUATED.iter().all(|(measure, _)| written.iter().any(|name| *name == measure.name)));
    }
}
