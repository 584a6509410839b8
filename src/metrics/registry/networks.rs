//! Measures of drives on networks. In: nothing. Out: their names, units and definitions, in the order of the tables.

use super::measure::{Measure, all_vehicles, ego};

/// Measures in the order of the tables.
pub(super) const MEASURES: &[Measure] = &[
    all_vehicles(
        "space_mean_speed_mps",
        "Space-mean speed of all vehicles",
        "m/s",
        "distance driven by all vehicles over their time on the network (Edie 1963); in recorded drives at full seconds, \
         at which all vehicles are recorded; equal to the mean speed if the number of vehicles never changes",
    )
    .on_networks_alone()
    .by("Edie 1963"),
    all_vehicles("vehicles", "Vehicles", "", "vehicles present at any time of the drive, the ego vehicle included")
        .on_networks_alone(),
    all_vehicles(
        "departures_per_h",
        "Departures",
        "1/h",
        "vehicles that entered during the drive, per hour; vehicles present at the start are not counted",
    )
    .on_networks_alone(),
    all_vehicles(
        "arrivals_per_h",
        "Arrivals",
        "1/h",
        "vehicles that reached their destinations during the drive, per hour",
    )
    .on_networks_alone(),
    all_vehicles(
        "trips",
        "Whole trips",
        "",
        "vehicles that departed and arrived during the drive, without the ego vehicle",
    )
    .on_networks_alone(),
    all_vehicles(
        "travel_time_s",
        "Mean travel time",
        "s",
        "time from departure to arrival: mean over vehicles that departed and arrived during the drive, without the \
         ego vehicle; other vehicles do not count, so a short drive has short trips",
    )
    .on_networks_alone(),
    all_vehicles(
        "travel_time_median_s",
        "Median travel time",
        "s",
        "time from departure to arrival over the same vehicles: median",
    )
    .on_networks_alone(),
    all_vehicles(
        "travel_time_p95_s",
        "95th percentile of travel time",
        "s",
        "time from departure to arrival over the same vehicles: 95th percentile (nearest rank)",
    )
    .on_networks_alone(),
    all_vehicles(
        "time_loss_s",
        "Mean time lost",
        "s",
        "travel time minus the time for the same way at the speed limit of each lane: mean over the whole trips; \
         between two rows of a vehicle, at most 1 s apart, the speed as a share of the limit is taken to change \
         linearly",
    )
    .on_networks_alone(),
    ego(
        "ego_travel_time_s",
        "Travel time of the ego vehicle",
        "s",
        "time from the start of the drive to the end of the ego vehicle's path; empty if the ego vehicle did not reach \
         it",
    )
    .on_networks_alone(),
    ego(
        "ego_time_loss_s",
        "Time lost of the ego vehicle",
        "s",
        "time of the drive minus the time for the ego vehicle's way at the speed limit of each lane; driving above the \
         limit lowers it",
    )
    .on_networks_alone(),
    all_vehicles(
        "line_passages_per_h",
        "Passages of the line",
        "1/h",
        "vehicles, the ego vehicle included, whose fronts pass the first line, per hour; without --line, the line \
         crosses all lanes of the street nearest to the middle of the ego vehicle's path; a passage is found from the \
         rows of a vehicle before and after it, at most 1 s apart",
    )
    .on_networks_alone(),
    ego(
        "red_lights",
        "Red lights passed",
        "",
        "number of times the ego vehicle passed a line at red, with its front and then its middle",
    )
    .on_networks_alone(),
    ego(
        "wrong_ways",
        "Drives against the traffic",
        "",
        "number of times the ego vehicle headed against the direction of its lane for 1 s or longer",
    )
    .on_networks_alone(),
    ego(
        "wrong_way_s",
        "Time against the traffic",
        "s",
        "time headed against the direction of the lane, from the end of that first second on",
    )
    .on_networks_alone(),
    ego(
        "wrong_turns",
        "Wrong turns",
        "",
        "number of times the ego vehicle was on another street than those of its path for 1 s or longer",
    )
    .on_networks_alone(),
    ego(
        "off_path_s",
        "Time beside the path",
        "s",
        "time from the end of that first second until the ego vehicle is on a street of its path again",
    )
    .on_networks_alone(),
    ego(
        "speedings",
        "Speedings",
        "",
        "number of times the ego vehicle came to exceed the limit of its lane by more than 1 m/s",
    )
    .on_networks_alone(),
    ego("speeding_s", "Time of speeding", "s", "time of these speedings, each until the limit is kept again")
        .on_networks_alone(),
    ego(
        "near_misses",
        "Near misses",
        "",
        "vehicles with which the ego vehicle would have collided within 1.5 s if both had kept their motion; a vehicle \
         counts again once that time was longer than 3 s",
    )
    .on_networks_alone()
    .by("safety"),
];
