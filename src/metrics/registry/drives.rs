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
    .on_networks("mean over ticks of the mean over the vehicles that are there"),
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
        "mean speed of all vehicles less that of the drive from the same seed without advice: the paired \
         difference",
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
    .on_closed_routes("a vehicle is there for a part of the drive"),
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
        "vehicles past the start of the route an hour, counted at steps; one that goes back is taken off",
    )
    .on_closed_routes("there is no start of a route that all pass; the throughput is that at a line"),
    all_vehicles(
        "stops",
        "Stops of all vehicles",
        "",
        "stops for each vehicle: its speed falls below 0.1 m/s; it has gone again above 1 m/s; standing at \
         the start is none",
    )
    .on_networks("over all vehicles that were there, seen once a second"),
    all_vehicles(
        "stopped_s",
        "Time stopped of all vehicles",
        "s",
        "time of a vehicle from below 0.1 m/s until above 1 m/s, summed over the drive, standing at the start \
         included: mean over vehicles",
    )
    .on_networks("over all vehicles that were there, seen once a second"),
    ego("ego_stops", "Stops of the ego vehicle", "", "stops of the ego vehicle by the same rule"),
    ego("ego_stopped_s", "Time stopped of the ego vehicle", "s", "the same time of the ego vehicle"),
    all_vehicles(
        "hard_brakings",
        "Hard brakings of all vehicles",
        "",
        "decelerations of more than 3 m/s2 over a step, for each vehicle; steps that follow each other are \
         one",
    )
    .on_closed_routes("vehicles far from the ego vehicle are recorded once a second")
    .by("safety"),
    all_vehicles(
        "hard_braking_s",
        "Time of hard braking of all vehicles",
        "s",
        "time of the same decelerations: mean over vehicles",
    )
    .on_closed_routes("vehicles far from the ego vehicle are recorded once a second")
    .by("safety"),
    ego("ego_hard_brakings", "Hard brakings of the ego vehicle", "", "the same decelerations of the ego vehicle")
        .by("safety"),
    ego(
        "ego_hard_braking_s",
        "Time of hard braking of the ego vehicle",
        "s",
        "time of the same decelerations of the ego vehicle",
    )
    .by("safety"),
    all_vehicles(
        "last_disturbance_s",
        "Time of the last disturbance",
        "s",
        "from the first step until the standard deviation of speed over vehicles stays below 0.5 m/s; empty \
         if it never does",
    )
    .on_closed_routes("streets, turns and signals make speeds differ without any wave")
    .by("advice"),
    ego("ego_mean_speed_mps", "Mean speed of the ego vehicle", "m/s", "speed of the ego vehicle: mean over ticks"),
    advised(
        "time_in_range",
        "Share of time in range",
        "",
        "share of the ticks with advice at which the speed is in the acceptable range, its edges included",
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
        "speed less target: mean over ticks with advice; positive is too fast",
    )
    .with_advice(),
    ego(
        "time_in_range_by_driver",
        "Share of time in range, by the driver",
        "",
        "share of the same ticks at which the speed is in the range and not within 2 s after a contact or \
         after the car was put back on its lane: the driver chose it",
    )
    .with_advice(),
    ego(
        "time_in_range_by_collision",
        "Share of time in range, by a collision",
        "",
        "share of the same ticks at which the speed is in the range within 2 s after a contact or after the \
         car was put back",
    )
    .with_advice(),
    ego(
        "changes",
        "Changes of the advice",
        "",
        "changes of target or range that the driver saw, by at least 0.1 m/s from those that counted last \
         (smaller ones add up until they do), events included; the first advice is none",
    ),
    ego(
        "events",
        "Events",
        "",
        "changes of the advice that ask something new: at the frame that shows them the speed is outside of \
         the new range, and was in the range before or on its other side",
    ),
    ego(
        "responded",
        "Share of events responded to",
        "",
        "share of the events answered within 3 s by a movement of the pedals in the direction asked that is \
         larger than the person's idle movements, of those that were answered or watched that long; movements \
         under way at the onset are left out",
    )
    .with_advice(),
    ego(
        "responded_by_chance",
        "Share of shams responded to",
        "",
        "the same share of shams: the events shifted all by the same time to where none is pending; what is \
         found there is chance",
    )
    .with_advice(),
    ego(
        "reaction_s",
        "Reaction time",
        "s",
        "perception-reaction time, from the frame that shows an event to the start of the first movement of \
         the pedals in the direction asked that is larger than the person's idle movements: median of the \
         lognormal distribution of the answers, from three times on, beside events that are never answered \
         and movements by chance at the rate of the shams; censored at the next change of the advice and the \
         end of the drive",
    )
    .with_advice()
    .in_j2944("reaction time, 6.5.2"),
    ego(
        "movement_s",
        "Movement time",
        "s",
        "from there to pedals that are 5 % of travel beyond idle movements: median of the censored lognormal \
         distribution over the same events",
    )
    .with_advice(),
    ego(
        "enter_range_s",
        "Time to enter the range",
        "s",
        "compliance time, from the frame that shows an event to the speed being in the new range: median of \
         the censored lognormal distribution over events, from three times on, censored as the reaction time",
    )
    .with_advice(),
    ego(
        "enter_range_steps",
        "Steps to enter the range",
        "steps",
        "the time to enter the range in steps of the traffic",
    )
    .with_advice(),
    ego(
        "idle_movement",
        "Idle movement of the pedals",
        "",
        "95th percentile of the movements of the pedals (accelerator less brake) within 1 s while no event is \
         pending, as a share of travel, at least 0.01: of the participant's practice, or of the drive where \
         there is none",
    )
    .with_advice(),
    ego(
        "min_gap_m",
        "Minimum gap",
        "m",
        "own front bumper to the leader's rear: smallest, over ticks in the leader's lane (less than a car's \
         width, 1.8 m, beside the lane's middle)",
    )
    .on_networks("the leader is the next vehicle on its path, none that is beside it; the lane is that of its path")
    .in_j2944("distance gap"),
    ego(
        "min_headway_m",
        "Minimum headway",
        "m",
        "own front bumper to the leader's front: smallest, over ticks in the leader's lane",
    )
    .on_networks("to the same leaders, each with its own length")
    .in_j2944("distance headway"),
    ego(
        "min_ttc_s",
        "Minimum time to collision",
        "s",
        "gap over closing speed while the gap closes: smallest, over ticks in the leader's lane",
    )
    .on_networks("the leader is the next vehicle on its path, none that is beside it; the lane is that of its path")
    .in_j2944("time to collision")
    .by("Hayward 1972"),
    ego(
        "max_drac_mps2",
        "Maximum deceleration rate to avoid a crash (DRAC)",
        "m/s2",
        "closing speed squared over twice the gap: largest, over ticks in the leader's lane; 0 where the gap \
         never closes",
    )
    .on_networks("the leader is the next vehicle on its path, none that is beside it; the lane is that of its path")
    .by("Cooper 1976"),
    ego(
        "time_gap_s",
        "Time gap",
        "s",
        "own front bumper to the leader's rear over own speed: mean over ticks in the leader's lane at 1 m/s \
         or more",
    )
    .on_networks(
        "over ticks at which the next vehicle on its path, none that is beside it, is at most 6 s ahead \
         (Vogel 2002); the lane is that of its path",
    )
    .in_j2944("time gap")
    .by("Vogel 2002"),
    ego(
        "min_time_gap_s",
        "Minimum time gap",
        "s",
        "own front bumper to the leader's rear over own speed: smallest, over ticks in the leader's lane at 1 \
         m/s or more",
    )
    .on_networks("the leader is the next vehicle on its path, none that is beside it; the lane is that of its path")
    .in_j2944("time gap"),
    ego(
        "time_headway_s",
        "Time headway",
        "s",
        "own front bumper to the leader's front over own speed: mean over ticks in the leader's lane at 1 m/s \
         or more",
    )
    .on_networks("over ticks at which the same leader is at most 6 s ahead (Vogel 2002), with its own length")
    .in_j2944("time headway, 8.1.4")
    .by("Vogel 2002"),
    ego(
        "min_time_headway_s",
        "Minimum time headway",
        "s",
        "own front bumper to the leader's front over own speed: smallest, over ticks in the leader's lane at \
         1 m/s or more",
    )
    .on_networks("to the same leaders, each with its own length")
    .in_j2944("time headway, 8.1.4"),
    ego(
        "sdlp_m",
        "Standard deviation of lane position (SDLP)",
        "m",
        "standard deviation of lane position (N−1), reference the middle of the car, over the whole trial, \
         unfiltered",
    )
    .on_networks("over ticks in the lane of its path (less than a car's width, 1.8 m, beside the lane's middle)")
    .in_j2944("standard deviation of lane position, 10.1.3"),
    ego(
        "reversals_per_min",
        "Steering reversal rate",
        "1/min",
        "reversals of the steering wheel with a gap size of 3 degrees, both ways, unfiltered, a minute",
    )
    .in_j2944("steering wheel reversal"),
    ego(
        "pedal_reversals_per_min",
        "Pedal reversal rate",
        "1/min",
        "reversals of the pedals (accelerator less brake) with a gap size of 5 % of travel, both ways, \
         unfiltered, a minute",
    ),
    ego(
        "rms_jerk_mps3",
        "Root mean square jerk",
        "m/s3",
        "root mean square of the change of acceleration, averaged over a step, from one step to the next",
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
        "lorries and buses are no petrol cars, and vehicles far from the ego vehicle are recorded once a \
         second",
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
        "lorries and buses are no petrol cars, and vehicles far from the ego vehicle are recorded once a \
         second",
    )
    .by("HBEFA"),
    all_vehicles(
        "fuel_saved_l_100km",
        "Fuel saved over no advice",
        "l/100 km",
        "fuel of all vehicles in the drive from the same seed without advice less that in this one",
    )
    .on_closed_routes(
        "lorries and buses are no petrol cars, and vehicles far from the ego vehicle are recorded once a \
         second",
    )
    .by("Kamal 2013"),
    all_vehicles(
        "hand_over_speed_sd_over_vehicles_mps",
        "Standard deviation of speed over vehicles at hand-over",
        "m/s",
        "standard deviation of speed over the vehicles (N) at the moment at which the driver takes the car \
         over: the wave that the drive begins with",
    ),
    ego("contact_count", "Contacts with other vehicles", "", "how often the ego vehicle touched another vehicle"),
    ego("left_road", "Departures from the lane", "", "how often the middle of the car left its lane")
        .on_networks("how often the middle of the car left the road"),
    ego(
        "dropped_s",
        "Time given up",
        "s",
        "time of the simulation that was given up as frames came too late: the participant saw the drive in \
         slow motion for as long; sum over the drive",
    ),
    ego("frames_per_s", "Frame rate", "1/s", "frames shown on the participant's screen, per second of wall time"),
    ego("longest_frame_s", "Longest frame", "s", "longest time from one frame on the participant's screen to the next"),
    ego(
        "latency_median_s",
        "Median latency",
        "s",
        "from the newest input (the kernel's time) to the handing over of the frame that shows it: median \
         over such frames",
    ),
    ego(
        "latency_p99_s",
        "99th percentile of latency",
        "s",
        "from the newest input (the kernel's time) to the handing over of the frame that shows it: 99th \
         percentile (nearest rank)",
    ),
    ego(
        "late_input_share",
        "Share of late inputs",
        "",
        "share of the frames with a new input that were handed over more than 0.07 s after it",
    ),
];
