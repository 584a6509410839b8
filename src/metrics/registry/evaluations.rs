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
    all_vehicles("crashed", "Crash", "", "vehicles collided (1) or not (0); from then on all vehicles stand"),
    all_vehicles("crash_s", "Time of the crash", "s", "from the first advice to the end of the step with the collision"),
    all_vehicles("flow_per_h", "Flow", "1/h", "vehicles past a place in an hour: density times mean speed")
        .on_closed_routes("the density of a network differs from street to street")
        .by("Edie 1963"),
    ego("advices", "Advices", "", "advices issued, repeated ones included"),
    ego("duration_s", "Duration", "s", "length of the drive"),
    advised(
        "min_gap_to_neighbours_m",
        "Minimum gap to neighbours",
        "m",
        "smallest gap from bumper to bumper of an advised vehicle to its leader, or of the ego vehicle's follower to it",
    )
    .on_networks("of any two vehicles in a lane"),
    ego(
        "min_ttc_to_neighbours_s",
        "Minimum time to collision with neighbours",
        "s",
        "gap over closing speed of the ego vehicle with its leader and of its follower with it: smallest over steps",
    )
    .on_closed_routes("leaders and followers change there; near misses are events")
    .by("Hayward 1972"),
    ego(
        "max_drac_to_neighbours_mps2",
        "Maximum deceleration rate to avoid a crash with neighbours",
        "m/s2",
        "closing speed squared over twice the gap, of the same pairs: largest over steps",
    )
    .on_closed_routes("leaders and followers change there; near misses are events")
    .by("Cooper 1976"),
    ego("close_approaches", "Close approaches", "", "approaches of the same pairs with a time to collision below 1.5 s")
        .on_closed_routes("leaders and followers change there; near misses are events")
        .by("safety"),
    all_vehicles(
        "hard_brakings_per_km",
        "Hard brakings per kilometre",
        "1/km",
        "decelerations of more than 3 m/s2 over a step, per kilometre of any vehicle",
    )
    .on_closed_routes("vehicles enter and leave there")
    .by("safety"),
    all_vehicles("stops_per_km", "Stops per kilometre", "1/km", "stops of any vehicle, per kilometre of any vehicle")
        .on_closed_routes("vehicles enter and leave there"),
    ego(
        "advice_share",
        "Share driven by advice",
        "",
        "share of the steps with advice in which the advice set the speed of the ego vehicle",
    )
    .on_closed_routes("no driver of its own is there"),
    ego(
        "distance_share",
        "Share driven by distance",
        "",
        "share of the same steps in which the driver's distance to the leader set the speed",
    )
    .on_closed_routes("no driver of its own is there"),
    ego(
        "guard_share",
        "Share driven by the guard",
        "",
        "share of the same steps in which the guard against a collision set the speed",
    )
    .on_closed_routes("no driver of its own is there"),
    all_vehicles("inflow_per_h", "Inflow", "1/h", "vehicles that entered during the horizon, an hour").on_networks_alone(),
    all_vehicles("outflow_per_h", "Outflow", "1/h", "vehicles that left during the horizon, an hour").on_networks_alone(),
    all_vehicles("vehicles_present", "Vehicles present", "", "vehicles on the network: mean over steps").on_networks_alone(),
    all_vehicles(
        "vehicles_refused",
        "Vehicles refused",
        "",
        "vehicles of the demand that found no room to enter until the end; empty if the demand has no end",
    )
    .on_networks_alone(),
    advised("advised_vehicles", "Advised vehicles", "", "vehicles that were advised at some time"),
    advised(
        "advised_share",
        "Share of advised vehicles",
        "",
        "share of the vehicles that were to be advised; on a network of those that enter",
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
        "batch_mean_speed_mps",
        "Mean speed of a batch",
        "m/s",
        "mean speed of all vehicles over the rings of an update, with the policy's noise",
    ),
    all_vehicles(
        "judged_speed_mps",
        "Evaluated mean speed",
        "m/s",
        "mean speed of all vehicles over whole horizons on separate rings, without the policy's noise; empty where it was not evaluated",
    ),
    ego("reward_mps", "Reward", "m/s", "mean reward of the steps of an update"),
    ego("kl_nat", "KL divergence", "nat", "KL divergence between the policies after and before an update"),
    ego("entropy_nat", "Entropy", "nat", "entropy of the policy before an update"),
    ego("value_error", "Error of the value", "", "mean square error of the value network"),
    ego("estimator_loss_nat", "Loss of the estimator", "nat", "loss of the estimator of the driver in a round; empty in other updates"),
];
