//! Measures of drives on networks. In: the sums of a drive. Out: numbers with their definitions. SI units.

use super::{definition::MeasureDefinition, inputs::MeasureInputs};
use crate::analysis::{data::RoadEvents, network::NetworkDriveTotals, statistics::middle};
use crate::sim::EndReason;

const fn measure(
    name: &'static str,
    title: &'static str,
    unit: &'static str,
    about: &'static str,
    of: fn(&MeasureInputs) -> Option<f64>,
) -> MeasureDefinition {
    MeasureDefinition::new(name, title, unit, about, of).on_networks_alone()
}

/// Measures in the order of the tables.
pub(super) const OF_NETWORKS: &[MeasureDefinition] = &[
    measure(
        "space_mean_speed_mps",
        "Space-mean speed of all vehicles",
        "m/s",
        "way of all vehicles over their time on the network (Edie 1963), of full seconds, at which all vehicles are recorded",
        |s| network(s)?.space_mean_speed_mps(),
    ),
    measure("vehicles", "Vehicles", "", "vehicles that were there at some time, the ego vehicle included", |s| {
        Some(network(s)?.vehicles as f64)
    }),
    measure(
        "departures_per_h",
        "Departures",
        "1/h",
        "vehicles that came in the drive, an hour; those that were there before are not counted",
        |s| s.per_hour(network(s)?.departures_and_arrivals()[0] as f64),
    ),
    measure("arrivals_per_h", "Arrivals", "1/h", "vehicles that came to their ends in the drive, an hour", |s| {
        s.per_hour(network(s)?.departures_and_arrivals()[1] as f64)
    }),
    measure(
        "trips",
        "Whole trips",
        "",
        "vehicles that departed and arrived in the drive, the ego vehicle left out",
        |s| network(s).map(|_| travel_times_s(s).len() as f64),
    ),
    measure(
        "travel_time_s",
        "Mean travel time",
        "s",
        "from departure to arrival of vehicles that departed and arrived in the drive, the ego vehicle left out: mean; who was there before, or is there at \
         the end, does not count, so that a short drive has short trips",
        |s| {
            let times = travel_times_s(s);
            (!times.is_empty()).then(|| times.iter().sum::<f64>() / times.len() as f64)
        },
    ),
    measure("travel_time_median_s", "Median travel time", "s", "the same times: median", |s| {
        middle(&travel_times_s(s))
    }),
    measure(
        "travel_time_p95_s",
        "95th percentile of travel time",
        "s",
        "the same times: 95th percentile (nearest rank)",
        |s| {
            let times = travel_times_s(s);
            times.get((0.95 * times.len() as f64).ceil() as usize - usize::from(!times.is_empty())).copied()
        },
    ),
    measure(
        "time_loss_s",
        "Mean time lost",
        "s",
        "travel time less that of the same way at the speed limit of each lane: mean over the same trips; the share of the limit that is driven \
         is taken to change evenly from one row of a vehicle to the next, a second at most",
        |s| network(s)?.mean_time_loss_s(),
    ),
    measure(
        "ego_travel_time_s",
        "Travel time of the ego vehicle",
        "s",
        "from the start of the drive to the end of the ego vehicle's path; empty if it did not come there",
        |s| (s.trial.ended == EndReason::PathEnd.name()).then_some(s.totals.duration_s),
    ),
    measure(
        "ego_time_loss_s",
        "Time lost of the ego vehicle",
        "s",
        "time of the drive less that of the way of the ego vehicle at the speed limit of each lane; above the limit time is won",
        |s| network(s)?.ego_time_loss_s,
    ),
    measure(
        "line_flow_per_h",
        "Throughput at the line",
        "1/h",
        "vehicles, the ego vehicle among them, whose fronts pass the first line, an hour: that which was asked for, or else all lanes of the \
         street nearest to the middle of the ego vehicle's path; a passage is told by the rows of a vehicle before and after it, at most a \
         second apart",
        |s| s.per_hour(network(s)?.lines.first()?.vehicles as f64),
    ),
    measure(
        "red_lights",
        "Red lights passed",
        "",
        "how often the middle of the ego vehicle followed its front over a line at red",
        |s| Some(events(s).red_lights as f64),
    ),
    measure(
        "wrong_ways",
        "Drives against the traffic",
        "",
        "how often the ego vehicle headed against the direction of its lane for a second or longer",
        |s| Some(events(s).wrong_way.count as f64),
    ),
    measure("wrong_way_s", "Time against the traffic", "s", "time of the same, from the end of that second on", |s| {
        Some(events(s).wrong_way.total_s(s.totals.duration_s))
    }),
    measure(
        "speedings",
        "Speedings",
        "",
        "how often the ego vehicle came to be faster than the limit of its lane by more than 1 m/s",
        |s| Some(events(s).speeding.count as f64),
    ),
    measure("speeding_s", "Time of speeding", "s", "time of the same, until the limit was kept again", |s| {
        Some(events(s).speeding.total_s(s.totals.duration_s))
    }),
    measure(
        "near_misses",
        "Near misses",
        "",
        "vehicles with which the ego vehicle would have collided within 1.5 s, had both gone on as they were; the same one counts again once \
         that time was longer than 3 s",
        |s| Some(events(s).near_misses as f64),
    ),
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
