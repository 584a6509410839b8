//! Measures of drives on networks. In: nothing. Out: their names, units and definitions, in the order of the tables.

use super::measure::{Measure, all_vehicles, ego};

/// Measures in the order of the tables.
pub(super) const MEASURES: &[Measure] = &[
    all_vehicles(
        "space_mean_speed_mps",
        "Space-mean speed of all vehicles",
        "m/s",
        "way of all vehicles over their time on the network (Edie 1963), of full seconds, at which all \
         vehicles are recorded",
    )
    .on_networks_alone()
    .by("Edie 1963"),
    all_vehicles("vehicles", "Vehicles", "", "vehicles that were there at some time, the ego vehicle included")
        .on_networks_alone(),
    all_vehicles(
        "departures_per_h",
        "Departures",
        "1/h",
        "vehicles that came in the drive, an hour; those that were there before are not counted",
    )
    .on_networks_alone(),
    all_vehicles("arrivals_per_h", "Arrivals", "1/h", "vehicles that came to their ends in the drive, an hour")
        .on_networks_alone(),
    all_vehicles(
        "trips",
        "Whole trips",
        "",
        "vehicles that departed and arrived in the drive, the ego vehicle left out",
    )
    .on_networks_alone(),
    all_vehicles(
        "travel_time_s",
        "Mean travel time",
        "s",
        "from departure to arrival of vehicles that departed and arrived in the drive, the ego vehicle left \
         out: mean; who was there before, or is there at the end, does not count, so that a short drive has \
         short trips",
    )
    .on_networks_alone(),
    all_vehicles("travel_time_median_s", "Median travel time", "s", "the same times: median").on_networks_alone(),
    all_vehicles(
        "travel_time_p95_s",
        "95th percentile of travel time",
        "s",
        "the same times: 95th percentile (nearest rank)",
    )
    .on_networks_alone(),
    all_vehicles(
        "time_loss_s",
        "Mean time lost",
        "s",
        "travel time less that of the same way at the speed limit of each lane: mean over the same trips; the \
         share of the limit that is driven is taken to change evenly from one row of a vehicle to the next, a \
         second at most",
    )
    .on_networks_alone(),
    ego(
        "ego_travel_time_s",
        "Travel time of the ego vehicle",
        "s",
        "from the start of the drive to the end of the ego vehicle's path; empty if it did not come there",
    )
    .on_networks_alone(),
    ego(
        "ego_time_loss_s",
        "Time lost of the ego vehicle",
        "s",
        "time of the drive less that of the way of the ego vehicle at the speed limit of each lane; above the \
         limit time is won",
    )
    .on_networks_alone(),
    all_vehicles(
        "line_passages_per_h",
        "Passages of the line",
        "1/h",
        "vehicles, the ego vehicle among them, whose fronts pass the first line, an hour: that which was \
         asked for, or else all lanes of the street nearest to the middle of the ego vehicle's path; a \
         passage is told by the rows of a vehicle before and after it, at most a second apart",
    )
    .on_networks_alone(),
    ego(
        "red_lights",
        "Red lights passed",
        "",
        "how often the middle of the ego vehicle followed its front over a line at red",
    )
    .on_networks_alone(),
    ego(
        "wrong_ways",
        "Drives against the traffic",
        "",
        "how often the ego vehicle headed against the direction of its lane for a second or longer",
    )
    .on_networks_alone(),
    ego("wrong_way_s", "Time against the traffic", "s", "time of the same, from the end of that second on")
        .on_networks_alone(),
    ego(
        "speedings",
        "Speedings",
        "",
        "how often the ego vehicle came to be faster than the limit of its lane by more than 1 m/s",
    )
    .on_networks_alone(),
    ego("speeding_s", "Time of speeding", "s", "time of the same, until the limit was kept again").on_networks_alone(),
    ego(
        "near_misses",
        "Near misses",
        "",
        "vehicles with which the ego vehicle would have collided within 1.5 s, had both gone on as they were; \
         the same one counts again once that time was longer than 3 s",
    )
    .on_networks_alone()
    .by("safety"),
];
