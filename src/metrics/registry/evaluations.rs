//! Measures of summaries, evaluated policies, benchmarks and trainings that recorded drives do not have. In: nothing. Out: their
//! names, units and definitions.

use super::measure::{Measure, advised, all_vehicles, ego};

/// Measures of drives, conflicts, networks, benchmarks and trainings, in this order.
pub(super) const MEASURES: &[Measure] = &[
    all_vehicles(
        "speed_sd_over_vehicles_and_time_mps",
        "Standard deviation of speed over vehicles and time",
        "m/s",
        "standard deviation of the speeds of all vehicles at all ticks (N)",
    ),
    all_vehicles(
        "settled_speed_mps",
        "Settled mean speed",
        "m/s",
        "mean speed of all vehicles over the last quarter of the horizon",
    ),
    all_vehicles("crashed", "Crash", "", "1 if vehicles collided, else 0; all vehicles stand from the collision on"),
    all_vehicles(
        "crash_s",
        "Time of the crash",
        "s",
        "time from the first advice to the end of the step with the collision",
    ),
    all_vehicles("flow_per_h", "Flow", "1/h", "vehicles that pass a point per hour: density times mean speed")
        .on_closed_routes("the density of a network differs from street to street")
        .by("Edie 1963"),
    ego("advices", "Advices", "", "advices issued, including repeated ones"),
    ego("duration_s", "Duration", "s", "length of the drive"),
    advised(
        "min_gap_to_neighbours_m",
        "Minimum gap to neighbours",
        "m",
        "smallest gap, bumper to bumper, between an advised vehicle and its leader, or between the ego vehicle and its \
         follower",
    )
    .on_networks("between any two vehicles in a lane"),
    ego(
        "min_ttc_to_neighbours_s",
        "Minimum time to collision with neighbours",
        "s",
        "smallest gap over closing speed, over steps, of the ego vehicle with its leader and of its follower with the \
         ego vehicle",
    )
    .on_closed_routes("leaders and followers change on networks; near misses are events")
    .by("Hayward 1972"),
    ego(
        "max_drac_to_neighbours_mps2",
        "Maximum deceleration rate to avoid a crash with neighbours",
        "m/s2",
        "largest closing speed squared over twice the gap, over steps, of the ego vehicle with its leader and of its \
         follower with the ego vehicle",
    )
    .on_closed_routes("leaders and followers change on networks; near misses are events")
    .by("Cooper 1976"),
    ego(
        "close_approaches",
        "Close approaches",
        "",
        "approaches of the ego vehicle to its leader, or of its follower to the ego vehicle, with a time to collision \
         below 1.5 s",
    )
    .on_closed_routes("leaders and followers change on networks; near misses are events")
    .by("safety"),
    all_vehicles(
        "hard_brakings_per_km",
        "Hard brakings per kilometre",
        "1/km",
        "decelerations of more than 3 m/s2 over a step, of all vehicles, per vehicle kilometre",
    )
    .on_closed_routes("vehicles enter and leave networks")
    .by("safety"),
    all_vehicles("stops_per_km", "Stops per kilometre", "1/km", "stops of all vehicles, per vehicle kilometre")
        .on_closed_routes("vehicles enter and leave networks"),
    ego(
        "advice_share",
        "Share driven by advice",
        "",
        "share of the steps with advice in which the advice set the speed of the ego vehicle",
    )
    .on_closed_routes("the source of the ego vehicle's speed is not known on networks"),
    ego(
        "distance_share",
        "Share driven by distance",
        "",
        "share of the steps with advice in which the driver's distance to the leader set the speed",
    )
    .on_closed_routes("the source of the ego vehicle's speed is not known on networks"),
    ego(
        "guard_share",
        "Share driven by the guard",
        "",
        "share of the steps with advice in which the guard against a collision set the speed",
    )
    .on_closed_routes("the source of the ego vehicle's speed is not known on networks"),
    all_vehicles("inflow_per_h", "Inflow", "1/h", "vehicles that entered during the horizon, per hour")
        .on_networks_alone(),
    all_vehicles("outflow_per_h", "Outflow", "1/h", "vehicles that left during the horizon, per hour")
        .on_networks_alone(),
    all_vehicles("vehicles_present", "Vehicles present", "", "vehicles on the network: mean over steps")
        .on_networks_alone(),
    all_vehicles(
        "vehicles_refused",
        "Vehicles refused",
        "",
        "vehicles of the demand that found no room to enter by the end; empty if the demand has no end",
    )
    .on_networks_alone(),
    advised("advised_vehicles", "Advised vehicles", "", "vehicles that were advised at some time"),
    advised(
        "advised_share",
        "Share of advised vehicles",
        "",
        "planned share of advised vehicles among all vehicles; on a network, among the vehicles that enter; without advice, the share whose drivers \
         drive as in the drives with advice",
    ),
    all_vehicles("calm_rings", "Calm rings", "", "rings on which the last disturbance ended before the horizon"),
    all_vehicles("crashes", "Crashes", "", "drives or episodes that ended in a crash"),
    all_vehicles(
        "worst_seed_mean_speed_mps",
        "Mean speed of the worst training seed",
        "m/s",
        "mean speed of all vehicles with the policy of the training seed that is slowest; empty with one seed",
    ),
    all_vehicles(
        "value_mps",
        "Value of the drives",
        "m/s",
        "mean speed of all vehicles minus the benchmark's speed_sd_penalty times the standard deviation over the vehicles",
    ),
    all_vehicles(
        "share_of_limit",
        "Share of the limit",
        "",
        "gain in value over no advice, as a share of the gain of the limit; empty without a limit",
    ),
    all_vehicles(
        "batch_mean_speed_mps",
        "Mean speed of a batch",
        "m/s",
        "mean speed of all vehicles over the rings of an update, with the policy's noise",
    ),
    all_vehicles(
        "judged_speed_mps",
        "Evaluated mean speed",
        "m/s",
        "mean speed of all vehicles over whole horizons on separate rings, minus the penalty for differences of speed, \
         without the policy's noise; empty if not evaluated",
    ),
    ego("reward_mps", "Reward", "m/s", "mean reward of the steps of an update"),
    ego("kl_nat", "KL divergence", "nat", "KL divergence between the policies after and before an update"),
    ego("entropy_nat", "Entropy", "nat", "entropy of the policy before an update"),
    ego("value_error", "Error of the value", "", "mean square error of the value network"),
    ego(
        "estimator_loss_nat",
        "Loss of the estimator",
        "nat",
        "loss of the estimator of the driver in a round; empty in other updates",
    ),
];
