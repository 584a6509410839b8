//! Measures of every recorded drive. In: nothing. Out: their names, units and definitions, in the order of the tables.

use super::measure::{Measure, advised, all_vehicles, ego};

/// Measures in the order of the tables.
pub(super) const MEASURES: &[Measure] = &[
    all_vehicles(
        "mean_speed_mps",
        "Mean speed of all vehicles",
        "m/s",
        "speed of all vehicles, the ego vehicle included: mean over vehicles and ticks (100 a second; over \
         steps of 0.1 s, as in published figures, it differs by up to about 0.001 m/s)",
    )
    .on_networks(
        "mean over ticks of the mean over the vehicles present, so that moments with few vehicles count as much as others; the \
         space-mean speed counts each vehicle's time",
    ),
    all_vehicles(
        "baseline_speed_mps",
        "Mean speed of all vehicles without advice",
        "m/s",
        "speed of all vehicles: mean over vehicles and ticks in the drive from the same seed without advice, \
         the ego vehicle driven by the car-following model",
    ),
    all_vehicles(
        "speed_gain_mps",
        "Gain in mean speed over no advice",
        "m/s",
        "mean speed of all vehicles minus that of the drive from the same seed without advice (paired difference)",
    ),
    all_vehicles(
        "speed_sd_over_vehicles_mps",
        "Standard deviation of speed over vehicles",
        "m/s",
        "standard deviation of speed over the vehicles (N), mean over steps",
    )
    .on_closed_routes("streets, turns and signals make speeds differ without any wave"),
    all_vehicles(
        "speed_sd_over_time_mps",
        "Standard deviation of speed over time",
        "m/s",
        "standard deviation of a vehicle's speed over the steps (N), mean over vehicles",
    )
    .on_closed_routes("vehicles are present for only a part of the drive"),
    ego(
        "ego_speed_sd_over_time_mps",
        "Standard deviation of the ego vehicle's speed",
        "m/s",
        "standard deviation of the ego vehicle's speed over the steps (N)",
    ),
    all_vehicles(
        "passages_per_h",
        "Passages of the route's start",
        "1/h",
        "vehicles that pass the start of the route per hour, counted at steps; a vehicle that goes back over it is \
         subtracted",
    )
    .on_closed_routes("no point is passed by all vehicles; the throughput is that at a line"),
    all_vehicles(
        "stops",
        "Stops of all vehicles",
        "",
        "stops per vehicle: a stop begins below 0.1 m/s and ends above 1 m/s; standing at the start is not a stop",
    )
    .on_networks("over all vehicles present, sampled once a second"),
    all_vehicles(
        "stopped_s",
        "Time stopped of all vehicles",
        "s",
        "time from a speed below 0.1 m/s to a speed above 1 m/s, summed over the drive, standing at the start \
         included: mean over vehicles",
    )
    .on_networks("over all vehicles present, sampled once a second"),
    ego("ego_stops", "Stops of the ego vehicle", "", "stops of the ego vehicle, by the same rule as for all vehicles"),
    ego(
        "ego_stopped_s",
        "Time stopped of the ego vehicle",
        "s",
        "time stopped of the ego vehicle, by the same rule as for all vehicles",
    ),
    all_vehicles(
        "hard_brakings",
        "Hard brakings of all vehicles",
        "",
        "decelerations of more than 3 m/s2 over a step, per vehicle; consecutive steps count once",
    )
    .on_closed_routes("vehicles far from the ego vehicle are recorded once a second")
    .by("safety"),
    all_vehicles(
        "hard_braking_s",
        "Time of hard braking of all vehicles",
        "s",
        "time with a deceleration of more than 3 m/s2 over a step: mean over vehicles",
    )
    .on_closed_routes("vehicles far from the ego vehicle are recorded once a second")
    .by("safety"),
    ego(
        "ego_hard_brakings",
        "Hard brakings of the ego vehicle",
        "",
        "decelerations of the ego vehicle of more than 3 m/s2 over a step; consecutive steps count once",
    )
    .by("safety"),
    ego(
        "ego_hard_braking_s",
        "Time of hard braking of the ego vehicle",
        "s",
        "time with a deceleration of the ego vehicle of more than 3 m/s2 over a step",
    )
    .by("safety"),
    all_vehicles(
        "last_disturbance_s",
        "Time of the last disturbance",
        "s",
        "time from the first step until the standard deviation of speed over vehicles stays below 0.5 m/s; empty if it \
         never does",
    )
    .on_closed_routes("streets, turns and signals make speeds differ without any wave")
    .by("advice"),
    ego("ego_mean_speed_mps", "Mean speed of the ego vehicle", "m/s", "speed of the ego vehicle: mean over ticks"),
    advised(
        "time_in_range",
        "Share of time in range",
        "",
        "share of the ticks with advice at which the speed is in the acceptable range, edges included",
    )
    .with_advice(),
    ego(
        "speed_error_mps",
        "Mean absolute speed error",
        "m/s",
        "absolute difference of speed and target: mean over ticks with advice",
    )
    .with_advice(),
    ego(
        "speed_bias_mps",
        "Mean speed error",
        "m/s",
        "speed minus target: mean over ticks with advice; positive: too fast",
    )
    .with_advice(),
    ego(
        "time_in_range_by_driver",
        "Share of time in range, by the driver",
        "",
        "share of the ticks with advice at which the speed is in the acceptable range by the driver's choice: not \
         within 2 s after a contact or after the vehicle was put back on its lane",
    )
    .with_advice(),
    ego(
        "time_in_range_by_collision",
        "Share of time in range, by a collision",
        "",
        "share of the ticks with advice at which the speed is in the acceptable range within 2 s after a contact or \
         after the vehicle was put back on its lane",
    )
    .with_advice(),
    ego(
        "changes",
        "Changes of the advice",
        "",
        "changes of target or range shown to the driver, of at least 0.1 m/s since the last counted change (smaller \
         changes add up); requests are included, the first advice is not",
    ),
    ego(
        "requests",
        "Requests of the advice",
        "",
        "changes of the advice that require a new speed: at the frame that shows the change, the speed is outside the \
         new range, and inside the old range or beyond its other side",
    ),
    ego(
        "responded",
        "Share of requests responded to",
        "",
        "share of the requests with a response within 3 s, of the requests with a response or at least 3 s watched; a \
         response is a movement of the pedals in the required direction that is larger than the person's idle \
         movements; requests with a movement under way at the onset are left out",
    )
    .with_advice(),
    ego(
        "responded_by_chance",
        "Share of shams responded to",
        "",
        "share of the shams with such a response; shams are the requests, all shifted by the same time to moments \
         without a pending request; responses to shams are chance",
    )
    .with_advice(),
    ego(
        "reaction_s",
        "Reaction time",
        "s",
        "perception-reaction time, from the frame that shows a request to the start of the first movement of the pedals \
         in the required direction that is larger than the person's idle movements: median of the lognormal \
         distribution of the responses, with at least three times; the fit allows for requests without a response and \
         for movements by chance at the rate of the shams; times are censored at the next change of the advice and at \
         the end of the drive",
    )
    .with_advice()
    .in_j2944("reaction time, 6.5.2"),
    ego(
        "movement_s",
        "Movement time",
        "s",
        "time from the start of the response to pedals 5 % of travel beyond the idle movements: median of the censored \
         lognormal distribution over the same requests",
    )
    .with_advice(),
    ego(
        "enter_range_s",
        "Time to enter the range",
        "s",
        "compliance time, from the frame that shows a request until the speed is in the new range: median of the \
         censored lognormal distribution over requests, with at least three times; censored as the reaction time",
    )
    .with_advice(),
    ego("enter_range_steps", "Steps to enter the range", "steps", "time to enter the range, in steps of the traffic")
        .with_advice(),
    ego(
        "idle_movement",
        "Idle movement of the pedals",
        "",
        "95th percentile of the movements of the pedals (accelerator minus brake) within 1 s while no request is \
         pending, as a share of travel, at least 0.01; from the participant's practice, or from the drive without a \
         practice",
    )
    .with_advice(),
    ego(
        "min_gap_m",
        "Minimum gap",
        "m",
        "smallest distance from the ego's front bumper to the leader's rear, over ticks in the leader's lane (less \
         than a car's width, 1.8 m, from the lane's middle)",
    )
    .on_networks(
        "the leader is the next vehicle on the ego's path, not a vehicle beside it; the lane is that of the path",
    )
    .in_j2944("distance gap"),
    ego(
        "min_headway_m",
        "Minimum headway",
        "m",
        "smallest distance from the ego's front bumper to the leader's front, over ticks in the leader's lane",
    )
    .on_networks("leaders as for the gap, each with its own length")
    .in_j2944("distance headway"),
    ego(
        "min_ttc_s",
        "Minimum time to collision",
        "s",
        "smallest gap over closing speed while the gap closes, over ticks in the leader's lane",
    )
    .on_networks(
        "the leader is the next vehicle on the ego's path, not a vehicle beside it; the lane is that of the path",
    )
    .in_j2944("time to collision")
    .by("Hayward 1972"),
    ego(
        "max_drac_mps2",
        "Maximum deceleration rate to avoid a crash (DRAC)",
        "m/s2",
        "largest closing speed squared over twice the gap, over ticks in the leader's lane; 0 if the gap never closes",
    )
    .on_networks(
        "the leader is the next vehicle on the ego's path, not a vehicle beside it; the lane is that of the path",
    )
    .by("Cooper 1976"),
    ego(
        "time_gap_s",
        "Time gap",
        "s",
        "distance from the ego's front bumper to the leader's rear over the ego's speed: mean over ticks in the \
         leader's lane at 1 m/s or more",
    )
    .on_networks(
        "over ticks at which the next vehicle on the ego's path, not a vehicle beside it, is at most 6 s ahead (Vogel \
         2002); the lane is that of the path",
    )
    .in_j2944("time gap")
    .by("Vogel 2002"),
    ego(
        "min_time_gap_s",
        "Minimum time gap",
        "s",
        "smallest distance from the ego's front bumper to the leader's rear over the ego's speed, over ticks in the \
         leader's lane at 1 m/s or more",
    )
    .on_networks(
        "the leader is the next vehicle on the ego's path, not a vehicle beside it; the lane is that of the path",
    )
    .in_j2944("time gap"),
    ego(
        "time_headway_s",
        "Time headway",
        "s",
        "distance from the ego's front bumper to the leader's front over the ego's speed: mean over ticks in the \
         leader's lane at 1 m/s or more",
    )
    .on_networks(
        "over ticks at which the leader of the time gap is at most 6 s ahead (Vogel 2002), with its own length",
    )
    .in_j2944("time headway, 8.1.4")
    .by("Vogel 2002"),
    ego(
        "min_time_headway_s",
        "Minimum time headway",
        "s",
        "smallest distance from the ego's front bumper to the leader's front over the ego's speed, over ticks in the \
         leader's lane at 1 m/s or more",
    )
    .on_networks("leaders as for the gap, each with its own length")
    .in_j2944("time headway, 8.1.4"),
    ego(
        "sdlp_m",
        "Standard deviation of lane position (SDLP)",
        "m",
        "standard deviation (N−1) of the lane position of the middle of the car, over the whole trial, unfiltered",
    )
    .on_networks("over ticks in the lane of the ego's path (less than a car's width, 1.8 m, from the lane's middle)")
    .in_j2944("standard deviation of lane position, 10.1.3"),
    ego(
        "reversals_per_min",
        "Steering reversal rate",
        "1/min",
        "reversals of the steering wheel per minute, with a gap size of 3 degrees, both ways, unfiltered",
    )
    .in_j2944("steering wheel reversal"),
    ego(
        "pedal_reversals_per_min",
        "Pedal reversal rate",
        "1/min",
        "reversals of the pedals (accelerator minus brake) per minute, with a gap size of 5 % of travel, both ways, \
         unfiltered",
    ),
    ego(
        "rms_jerk_mps3",
        "Root mean square jerk",
        "m/s3",
        "root mean square of the rate of change, from one step to the next, of the acceleration averaged over a step",
    )
    .in_j2944("jerk, 7.2.13"),
    ego(
        "ego_fuel_l_100km",
        "Fuel consumption of the ego vehicle",
        "l/100 km",
        "fuel of the ego vehicle by the model of Kamal et al. (2013)",
    )
    .by("Kamal 2013"),
    all_vehicles(
        "fuel_l_100km",
        "Fuel consumption of all vehicles",
        "l/100 km",
        "fuel of all vehicles by the model of Kamal et al. (2013)",
    )
    .on_closed_routes(
        "lorries and buses are not petrol cars, and vehicles far from the ego vehicle are recorded once a second",
    )
    .by("Kamal 2013"),
    ego(
        "ego_fuel_sumo_l_100km",
        "Fuel consumption of the ego vehicle, SUMO",
        "l/100 km",
        "fuel of the ego vehicle by SUMO's emission model (HBEFA 4.2, petrol, Euro 4)",
    )
    .by("HBEFA"),
    all_vehicles(
        "fuel_sumo_l_100km",
        "Fuel consumption of all vehicles, SUMO",
        "l/100 km",
        "fuel of all vehicles by SUMO's emission model (HBEFA 4.2, petrol, Euro 4)",
    )
    .on_closed_routes(
        "lorries and buses are not petrol cars, and vehicles far from the ego vehicle are recorded once a second",
    )
    .by("HBEFA"),
    all_vehicles(
        "fuel_saved_l_100km",
        "Fuel saved over no advice",
        "l/100 km",
        "fuel of all vehicles in the drive from the same seed without advice minus that in this drive",
    )
    .on_closed_routes(
        "lorries and buses are not petrol cars, and vehicles far from the ego vehicle are recorded once a second",
    )
    .by("Kamal 2013"),
    all_vehicles(
        "hand_over_speed_sd_over_vehicles_mps",
        "Standard deviation of speed over vehicles at hand-over",
        "m/s",
        "standard deviation of speed over the vehicles (N) at the moment at which the driver takes over: the wave at \
         the start of the drive",
    ),
    ego("contact_count", "Contacts with other vehicles", "", "number of times the ego vehicle touched another vehicle"),
    ego(
        "object_contacts",
        "Contacts with objects",
        "",
        "number of times the ego vehicle touched a fixed object beside the road, such as a wall, a guard rail or a tree",
    ),
    ego("left_road", "Departures from the lane", "", "number of times the middle of the car left its lane")
        .on_networks("number of times the middle of the car left the road"),
    ego(
        "dropped_s",
        "Time given up",
        "s",
        "simulation time given up because frames came too late, summed over the drive; the participant then saw the \
         drive in slow motion",
    ),
    ego("frames_per_s", "Frame rate", "1/s", "frames shown on the participant's screen, per second of wall time"),
    ego("longest_frame_s", "Longest frame", "s", "longest time from one frame on the participant's screen to the next"),
    ego(
        "latency_median_s",
        "Median latency",
        "s",
        "time from the newest input (the kernel's time) to the handing over of the frame that shows it: median over \
         frames that show an input",
    ),
    ego(
        "latency_p99_s",
        "99th percentile of latency",
        "s",
        "time from the newest input (the kernel's time) to the handing over of the frame that shows it: 99th \
         percentile (nearest rank)",
    ),
    ego(
        "late_input_share",
        "Share of late inputs",
        "",
        "share of the frames with a new input that were handed over more than 0.07 s after it",
    ),
    waves(
        "wave_speed_mps",
        "Wave speed",
        "m/s",
        "speed, in the road's frame and in steps of 0.25 m/s, of the frame of reference in which the pattern of speeds along \
         the route less their mean stands best: median over windows of 60 s that overlap by half; negative: against the \
         direction of travel",
    ),
    waves(
        "wave_share",
        "Share of the wave",
        "",
        "coherence of the wave: share of the variance of speed along the route and over 60 s that moves with the wave speed, \
         median over the same windows",
    ),
    waves(
        "speed_sd_growth_per_min",
        "Growth of the waves",
        "1/min",
        "slope of the logarithm of the standard deviation of speed over the vehicles (N), by least squares over means of \
         20 s",
    ),
    gain("gain_at_0_03_hz", "Gain at 0.03 Hz"),
    gain("gain_at_0_06_hz", "Gain at 0.06 Hz"),
    gain("gain_at_0_1_hz", "Gain at 0.1 Hz"),
    gain("gain_at_0_15_hz", "Gain at 0.15 Hz"),
];

/// Creates a measure of waves on a closed route.
const fn waves(name: &'static str, title: &'static str, unit: &'static str, about: &'static str) -> Measure {
    all_vehicles(name, title, unit, about).on_closed_routes("leaders change on networks").by("people")
}

/// Creates a measure of the gain at the frequency in its title.
const fn gain(name: &'static str, title: &'static str) -> Measure {
    waves(
        name,
        title,
        "",
        "gain from a leader's speed to its follower's at this frequency: size of their cross-spectrum over the leaders' \
         spectrum, summed over vehicles and Hann windows of 60 s that overlap by half (Welch)",
    )
}
