//! Moments of traffic in one lane, by which it is compared with measured people. In: nothing. Out: their names, units and definitions.

use super::measure::{Measure, all_vehicles};

/// Moments in the order of the tables; the rest of them are measures of recorded drives.
pub(super) const MEASURES: &[Measure] = &[
    moment(
        "accel_sd_mps2",
        "Standard deviation of acceleration",
        "m/s2",
        "standard deviation (N) of the change of speed over 1 s, over all vehicles and steps",
    ),
    moment(
        "accel_p01_mps2",
        "1st percentile of acceleration",
        "m/s2",
        "change of speed over 1 s, over all vehicles and steps: 1st percentile",
    ),
    moment(
        "accel_p99_mps2",
        "99th percentile of acceleration",
        "m/s2",
        "change of speed over 1 s, over all vehicles and steps: 99th percentile",
    ),
    moment(
        "accel_kurtosis",
        "Kurtosis of acceleration",
        "",
        "change of speed over 1 s, over all vehicles and steps: kurtosis, 3 for a normal distribution",
    ),
    moment(
        "brakings_per_km",
        "Brakings per kilometre",
        "1/km",
        "changes of speed over 1 s below -1 m/s2 per vehicle kilometre; consecutive steps count once",
    ),
    moment("standing_share", "Share of standing", "", "share of vehicles and steps at a speed below 0.5 m/s"),
    moment("gap_p05_m", "5th percentile of the gap", "m", "gaps of all vehicles at all steps: 5th percentile"),
    moment("gap_p25_m", "25th percentile of the gap", "m", "gaps of all vehicles at all steps: 25th percentile"),
    moment("gap_median_m", "Median gap", "m", "gaps of all vehicles at all steps: median"),
    moment("gap_p75_m", "75th percentile of the gap", "m", "gaps of all vehicles at all steps: 75th percentile"),
    moment("gap_p95_m", "95th percentile of the gap", "m", "gaps of all vehicles at all steps: 95th percentile"),
    moment("smallest_gap_m", "Smallest gap of all vehicles", "m", "smallest gap of any vehicle at any step"),
    moment(
        "gap_distance_to_experiment_a",
        "Distance of gaps to experiment A",
        "",
        "largest difference of the distribution of gaps to that of experiment A of the Arizona ring (Kolmogorov and \
         Smirnov), whose quantiles are known in steps of 2.5 %",
    )
    .by("people"),
    moment(
        "person_gap_sd_m",
        "Standard deviation of a person's gap",
        "m",
        "standard deviation (N) of a vehicle's gap over the steps, mean over vehicles",
    ),
    moment(
        "person_time_gap_s",
        "Median time gap of persons",
        "s",
        "gap over speed at 1 m/s or more: median over steps, and of these the median over vehicles",
    ),
    moment(
        "shortest_person_time_gap_s",
        "Shortest time gap of a person",
        "s",
        "gap over speed at 1 m/s or more: median over steps, smallest of all vehicles",
    ),
    moment(
        "longest_person_time_gap_s",
        "Longest time gap of a person",
        "s",
        "gap over speed at 1 m/s or more: median over steps, largest of all vehicles",
    ),
    moment(
        "person_time_gap_ln_sd",
        "Spread of persons' time gaps",
        "",
        "standard deviation (N-1) over vehicles of the logarithm of the median time gap",
    ),
    moment(
        "person_accel_ln_sd",
        "Spread of persons' acceleration",
        "",
        "standard deviation (N-1) over vehicles of the logarithm of the standard deviation of the change of speed over 1 s",
    ),
    moment(
        "lag_s",
        "Lag to the leader's speed",
        "s",
        "shift from 0 to 6 s at which a vehicle's speed correlates most with its leader's earlier speed, over the steps \
         that both have, refined by a parabola: median over vehicles",
    ),
    moment(
        "shortest_person_lag_s",
        "Shortest lag of a person",
        "s",
        "lag to the leader's speed, smallest of all vehicles",
    ),
    moment(
        "longest_person_lag_s",
        "Longest lag of a person",
        "s",
        "lag to the leader's speed, largest of all vehicles",
    ),
    moment(
        "gap_split_half_r",
        "Split-half correlation of the gap",
        "",
        "correlation over vehicles of the mean gap in the first half of the time and in the second",
    ),
    moment(
        "time_gap_split_half_r",
        "Split-half correlation of the time gap",
        "",
        "correlation over vehicles of the median time gap in the first half of the time and in the second",
    ),
    moment(
        "accel_split_half_r",
        "Split-half correlation of acceleration",
        "",
        "correlation over vehicles of the standard deviation of the change of speed over 1 s in the first half of the \
         time and in the second",
    ),
    moment(
        "noise_split_half_r",
        "Split-half correlation of noise",
        "",
        "correlation over vehicles of a person's noise in the first half of the time and in the second; noise is the \
         standard deviation of the residuals of a linear regression of the change of speed over the next second on gap, own \
         speed and leader's speed",
    ),
    moment(
        "lag_split_half_r",
        "Split-half correlation of the lag",
        "",
        "correlation over vehicles of the lag to the leader's speed in the first half of the time and in the second",
    ),
];

/// Creates a moment of vehicles that follow each other in one lane.
const fn moment(name: &'static str, title: &'static str, unit: &'static str, about: &'static str) -> Measure {
    all_vehicles(name, title, unit, about).on_closed_routes("leaders change on networks")
}
