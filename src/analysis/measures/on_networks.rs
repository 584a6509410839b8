//! Measures of drives on networks. In: the sums of a drive. Out: a number, or `None` where there is nothing to measure. SI units.

use super::{MeasuredValue, inputs::MeasureInputs};
use crate::{
    analysis::{data::RoadEvents, network::NetworkDriveTotals, statistics::middle},
    metrics::registry::measure,
    sim::EndReason,
};

/// Measures in the order of the tables.
pub(super) const OF_NETWORKS: &[MeasuredValue] = &[
    (measure("space_mean_speed_mps"), |s| s.totals.traffic.space_mean_speed_mps()),
    (measure("vehicles"), |s| Some(network(s)?.vehicles as f64)),
    (measure("departures_per_h"), |s| s.per_hour(network(s)?.departures_and_arrivals()[0] as f64)),
    (measure("arrivals_per_h"), |s| s.per_hour(network(s)?.departures_and_arrivals()[1] as f64)),
    (measure("trips"), |s| network(s).map(|_| travel_times_s(s).len() as f64)),
    (measure("travel_time_s"), |s| {
        let times = travel_times_s(s);
        (!times.is_empty()).then(|| times.iter().sum::<f64>() / times.len() as f64)
    }),
    (measure("travel_time_median_s"), |s| middle(&travel_times_s(s))),
    (measure("travel_time_p95_s"), |s| {
        let times = travel_times_s(s);
        times.get((0.95 * times.len() as f64).ceil() as usize - usize::from(!times.is_empty())).copied()
    }),
    (measure("time_loss_s"), |s| network(s)?.mean_time_loss_s()),
    (measure("ego_travel_time_s"), |s| (s.trial.ended == EndReason::PathEnd.name()).then_some(s.totals.duration_s)),
    (measure("ego_time_loss_s"), |s| network(s)?.ego_time_loss_s),
    (measure("line_passages_per_h"), |s| s.per_hour(network(s)?.lines.first()?.vehicles as f64)),
    (measure("red_lights"), |s| Some(events(s).red_lights as f64)),
    (measure("wrong_ways"), |s| Some(events(s).wrong_way.count as f64)),
    (measure("wrong_way_s"), |s| Some(events(s).wrong_way.total_s(s.totals.duration_s))),
    (measure("wrong_turns"), |s| Some(events(s).off_path.count as f64)),
    (measure("off_path_s"), |s| Some(events(s).off_path.total_s(s.totals.duration_s))),
    (measure("speedings"), |s| Some(events(s).speeding.count as f64)),
    (measure("speeding_s"), |s| Some(events(s).speeding.total_s(s.totals.duration_s))),
    (measure("near_misses"), |s| Some(events(s).near_misses as f64)),
];

fn network<'a>(inputs: &MeasureInputs<'a>) -> Option<&'a NetworkDriveTotals> {
    inputs.totals.network.as_ref()
}

fn events(inputs: &MeasureInputs) -> RoadEvents {
    inputs.trial.road_events
}

fn travel_times_s(inputs: &MeasureInputs) -> Vec<f64> {
    network(inputs).map(NetworkDriveTotals::travel_times_s).unwrap_or_default()
}
