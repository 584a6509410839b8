//! One drive in numbers. In: its totals, and those of the same drive without advice where there is one. Out: [`DriveMeasures`]. Each
//! is over the whole trial unless its row in [`MEASURES`] says otherwise; that list is the only place that names them.

pub(super) use super::measure_inputs::{deviation, median};
use super::{
    RecordedTrial,
    events::OnsetKind,
    glossary::unit_text,
    measure_inputs::{MeasureInputs, all_cars, enough, middle},
    reactions::ResponseTime,
    response::AdviceResponse,
    totals::DriveTotals,
};

/// A drive in numbers; `None` where there is nothing to measure.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DriveMeasures {
    /// Values in the order of [`MEASURES`].
    pub values: Vec<Option<f64>>,
    /// What became of every change of the advice.
    pub responses: Vec<AdviceResponse>,
}

/// A measure.
pub struct MeasureDefinition {
    /// Its name in tables, with the unit.
    pub name: &'static str,
    /// In words, for figures.
    pub title: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Definition with its options.
    pub about: &'static str,
    /// Its name and number in SAE J2944; `None` where the practice has no such measure, or none that is known here.
    pub j2944: Option<&'static str>,
    of: fn(&MeasureInputs) -> Option<f64>,
}

impl MeasureDefinition {
    /// What it is called in SAE J2944.
    const fn in_j2944(self, name: &'static str) -> Self {
        Self { j2944: Some(name), ..self }
    }

    /// The definition, with the name in SAE J2944.
    pub fn definition(&self) -> String {
        match self.j2944 {
            Some(name) => format!("{} (SAE J2944: {name})", self.about),
            None => format!("{} (SAE J2944: none)", self.about),
        }
    }

    /// Quantity and unit, as an axis or a table's head says it.
    pub fn label(&self) -> String {
        if self.unit.is_empty() { self.title.into() } else { format!("{}, {}", self.title, unit_text(self.unit)) }
    }
}

const fn measure(
    name: &'static str,
    title: &'static str,
    unit: &'static str,
    about: &'static str,
    of: fn(&MeasureInputs) -> Option<f64>,
) -> MeasureDefinition {
    MeasureDefinition { name, title, unit, about, j2944: None, of }
}

/// All of them.
pub const MEASURES: &[MeasureDefinition] = &[
    measure(
        "mean_speed_mps",
        "Mean speed of all vehicles",
        "m/s",
        "speed of all vehicles, the ego vehicle included: mean over vehicles and ticks (100 a second; over steps of 0.1 s, as in \
         published figures, it differs by up to about 0.001 m/s)",
        |s| s.totals.mean_speed_mps.get(),
    ),
    measure(
        "baseline_speed_mps",
        "Mean speed of all vehicles without advice",
        "m/s",
        "speed of all vehicles: mean over vehicles and ticks in the drive from the same seed without advice, the ego vehicle driven by \
         the car-following model",
        |s| s.baseline?.mean_speed_mps.get(),
    ),
    measure(
        "speed_gain_mps",
        "Gain in mean speed over no advice",
        "m/s",
        "mean speed of all vehicles less that of the drive from the same seed without advice: the paired difference",
        |s| Some(s.totals.mean_speed_mps.get()? - s.baseline?.mean_speed_mps.get()?),
    ),
    measure(
        "sd_over_cars_mps",
        "Standard deviation of speed over vehicles",
        "m/s",
        "standard deviation of speed over the vehicles (N), mean over steps",
        |s| Some(all_cars(s.totals)?.sd_over_cars_mps()),
    ),
    measure(
        "sd_in_time_mps",
        "Standard deviation of speed over time",
        "m/s",
        "standard deviation of a vehicle's speed over the steps (N), mean over vehicles",
        |s| Some(all_cars(s.totals)?.sd_in_time_mps()),
    ),
    measure(
        "ego_sd_mps",
        "Standard deviation of the ego vehicle's speed",
        "m/s",
        "standard deviation of the ego vehicle's speed over the steps (N)",
        |s| Some(enough(&s.totals.ego_alone)?.sd_in_time_mps()),
    ),
    measure(
        "throughput_per_h",
        "Throughput",
        "1/h",
        "vehicles past the start of the route an hour, counted at steps; one that goes back is taken off",
        |s| s.per_hour(s.totals.passages as f64).filter(|_| all_cars(s.totals).is_some() && s.trial.setup.route_m > 0.0),
    ),
    measure(
        "stops",
        "Stops of all vehicles",
        "",
        "stops for each vehicle: its speed falls below 0.1 m/s; it has gone again above 1 m/s; standing at the start is none",
        |s| s.per_car(s.totals.all_motion.stops as f64),
    ),
    measure(
        "stopped_s",
        "Time stopped of all vehicles",
        "s",
        "time of a vehicle from below 0.1 m/s until above 1 m/s, summed over the drive, standing at the start included: mean over \
         vehicles",
        |s| s.per_car(s.totals.all_motion.stopped_s),
    ),
    measure("ego_stops", "Stops of the ego vehicle", "", "stops of the ego vehicle by the same rule", |s| {
        s.per_car(0.0).map(|_| s.totals.ego_motion.stops as f64)
    }),
    measure("ego_stopped_s", "Time stopped of the ego vehicle", "s", "the same time of the ego vehicle", |s| {
        s.per_car(0.0).map(|_| s.totals.ego_motion.stopped_s)
    }),
    measure(
        "hard_brakings",
        "Hard brakings of all vehicles",
        "",
        "decelerations of more than 3 m/s2 over a step, for each vehicle; steps that follow each other are one",
        |s| s.per_car(s.totals.all_motion.hard_brakings as f64),
    ),
    measure(
        "hard_braking_s",
        "Time of hard braking of all vehicles",
        "s",
        "time of the same decelerations: mean over vehicles",
        |s| s.per_car(s.totals.all_motion.hard_braking_s),
    ),
    measure(
        "ego_hard_brakings",
        "Hard brakings of the ego vehicle",
        "",
        "the same decelerations of the ego vehicle",
        |s| s.per_car(0.0).map(|_| s.totals.ego_motion.hard_brakings as f64),
    ),
    measure(
        "ego_hard_braking_s",
        "Time of hard braking of the ego vehicle",
        "s",
        "time of the same decelerations of the ego vehicle",
        |s| s.per_car(0.0).map(|_| s.totals.ego_motion.hard_braking_s),
    ),
    measure(
        "last_disturbance_s",
        "Time of the last disturbance",
        "s",
        "from the first step until the standard deviation of speed over vehicles stays below 0.5 m/s; empty if it never does",
        |s| all_cars(s.totals)?.last_disturbance_s(),
    ),
    measure(
        "ego_speed_mps",
        "Mean speed of the ego vehicle",
        "m/s",
        "speed of the ego vehicle: mean over ticks",
        |s| s.totals.ego_speed_mps.get(),
    ),
    measure(
        "time_in_range",
        "Share of time in range",
        "",
        "share of the ticks with advice at which the speed is in the acceptable range, its edges included",
        |s| s.totals.in_range.get(),
    ),
    measure(
        "speed_error_mps",
        "Mean absolute speed error",
        "m/s",
        "absolute difference of speed and target: mean over ticks with advice",
        |s| s.totals.absolute_error_mps.get(),
    ),
    measure(
        "speed_bias_mps",
        "Mean speed error",
        "m/s",
        "speed less target: mean over ticks with advice; positive is too fast",
        |s| s.totals.error_mps.get(),
    ),
    measure(
        "time_in_range_by_driver",
        "Share of time in range, by the driver",
        "",
        "share of the same ticks at which the speed is in the range and not within 2 s after a contact or after the car was put back on \
         its lane: the driver chose it",
        |s| s.totals.in_range_by_driver.get(),
    ),
    measure(
        "time_in_range_by_collision",
        "Share of time in range, by a collision",
        "",
        "share of the same ticks at which the speed is in the range within 2 s after a contact or after the car was put back",
        |s| Some(s.totals.in_range.get()? - s.totals.in_range_by_driver.get()?),
    ),
    measure(
        "changes",
        "Changes of the advice",
        "",
        "changes of target or range that the driver saw, by at least 0.1 m/s from those that counted last (smaller ones add up \
         until they do), events included; the first advice is none",
        |s| Some(s.count(OnsetKind::Change) + s.count(OnsetKind::Event)),
    ),
    measure(
        "events",
        "Events",
        "",
        "changes of the advice that ask something new: at the frame that shows them the speed is outside of the new range, and was in the \
         range before or on its other side",
        |s| Some(s.count(OnsetKind::Event)),
    ),
    measure(
        "responded",
        "Share of events responded to",
        "",
        "share of the events answered within 3 s by a movement of the pedals in the direction asked that is larger than the person's idle \
         movements, of those that were answered or watched that long; movements under way at the onset are left out",
        |s| ResponseTime::Reaction.share_answered(s.responses),
    ),
    measure(
        "responded_by_chance",
        "Share of shams responded to",
        "",
        "the same share of shams: the events shifted all by the same time to where none is pending; what is found there is chance",
        |s| ResponseTime::Chance.share_answered(s.responses),
    ),
    measure(
        "reaction_s",
        "Reaction time",
        "s",
        "perception-reaction time, from the frame that shows an event to the start of the first movement of the pedals in the direction \
         asked that is larger than the person's idle movements: median of the lognormal distribution of the answers, from three times on, \
         beside events that are never answered and movements by chance at the rate of the shams; censored at the next change of the \
         advice and the end of the drive",
        |s| s.median_s(ResponseTime::Reaction),
    )
    .in_j2944("reaction time, 6.5.2"),
    measure(
        "movement_s",
        "Movement time",
        "s",
        "from there to pedals that are 5 % of travel beyond idle movements: median of the censored lognormal distribution over the same \
         events",
        |s| s.median_s(ResponseTime::Movement),
    ),
    measure(
        "enter_range_s",
        "Time to enter the range",
        "s",
        "compliance time, from the frame that shows an event to the speed being in the new range: median of the censored lognormal \
         distribution over events, from three times on, censored as the reaction time",
        |s| s.median_s(ResponseTime::Compliance),
    ),
    measure(
        "enter_range_steps",
        "Steps to enter the range",
        "steps",
        "the time to enter the range in steps of the traffic",
        |s| Some(s.median_s(ResponseTime::Compliance)? / s.totals.step_s()),
    ),
    measure(
        "idle_movement",
        "Idle movement of the pedals",
        "",
        "95th percentile of the movements of the pedals (accelerator less brake) within 1 s while no event is pending, as a share of \
         travel, at least 0.01: of the participant's practice, or of the drive where there is none",
        |s| s.responses.first().map(|response| response.threshold),
    ),
    measure(
        "min_gap_m",
        "Minimum gap",
        "m",
        "own front bumper to the leader's rear: smallest, over ticks in the leader's lane (less than a car's width, 1.8 m, beside the \
         lane's middle)",
        |s| s.totals.gap_m.0,
    )
    .in_j2944("distance gap"),
    measure(
        "min_headway_m",
        "Minimum headway",
        "m",
        "own front bumper to the leader's front: smallest, over ticks in the leader's lane",
        |s| s.totals.headway_m.0,
    )
    .in_j2944("distance headway"),
    measure(
        "min_ttc_s",
        "Minimum time to collision",
        "s",
        "gap over closing speed while the gap closes: smallest, over ticks in the leader's lane",
        |s| s.totals.ttc_s.0,
    )
    .in_j2944("time to collision"),
    measure(
        "max_drac_mps2",
        "Maximum deceleration rate to avoid a crash (DRAC)",
        "m/s2",
        "closing speed squared over twice the gap: largest, over ticks in the leader's lane; 0 where the gap never closes",
        |s| s.totals.most_drac_mps2,
    ),
    measure(
        "time_gap_s",
        "Time gap",
        "s",
        "own front bumper to the leader's rear over own speed: mean over ticks in the leader's lane at 1 m/s or more",
        |s| s.totals.time_gap_s.get(),
    )
    .in_j2944("time gap"),
    measure(
        "min_time_gap_s",
        "Minimum time gap",
        "s",
        "own front bumper to the leader's rear over own speed: smallest, over ticks in the leader's lane at 1 m/s or more",
        |s| s.totals.min_time_gap_s.0,
    )
    .in_j2944("time gap"),
    measure(
        "time_headway_s",
        "Time headway",
        "s",
        "own front bumper to the leader's front over own speed: mean over ticks in the leader's lane at 1 m/s or more",
        |s| s.totals.time_headway_s.get(),
    )
    .in_j2944("time headway, 8.1.4"),
    measure(
        "min_time_headway_s",
        "Minimum time headway",
        "s",
        "own front bumper to the leader's front over own speed: smallest, over ticks in the leader's lane at 1 m/s or more",
        |s| s.totals.min_time_headway_s.0,
    )
    .in_j2944("time headway, 8.1.4"),
    measure(
        "sdlp_m",
        "Standard deviation of lane position (SDLP)",
        "m",
        "standard deviation of lane position (N−1), reference the middle of the car, over the whole trial, unfiltered",
        |s| s.totals.sdlp_m(),
    )
    .in_j2944("standard deviation of lane position, 10.1.3"),
    measure(
        "reversals_per_min",
        "Steering reversal rate",
        "1/min",
        "reversals of the steering wheel with a gap size of 3 degrees, both ways, unfiltered, a minute",
        |s| {
            let minutes = s.totals.duration_s / 60.0;
            (minutes > 0.0).then(|| s.totals.reversals.count as f64 / minutes)
        },
    )
    .in_j2944("steering wheel reversal"),
    measure(
        "pedal_reversals_per_min",
        "Pedal reversal rate",
        "1/min",
        "reversals of the pedals (accelerator less brake) with a gap size of 5 % of travel, both ways, unfiltered, a minute",
        |s| Some(s.per_hour(s.totals.pedal_reversals.count as f64)? / 60.0),
    ),
    measure(
        "rms_jerk_mps3",
        "Root mean square jerk",
        "m/s3",
        "root mean square of the change of acceleration, averaged over a step, from one step to the next",
        |s| Some(s.totals.square_jerk.get()?.sqrt()),
    )
    .in_j2944("jerk, 7.2.13"),
    measure(
        "ego_fuel_l_100km",
        "Fuel consumption of the ego vehicle",
        "l/100 km",
        "fuel of the ego vehicle by the model of Kamal et al. (2013)",
        |s| enough(&s.totals.ego_alone)?.fuel_l_100km(),
    ),
    measure(
        "fuel_l_100km",
        "Fuel consumption of all vehicles",
        "l/100 km",
        "fuel of all vehicles by the model of Kamal et al. (2013)",
        |s| all_cars(s.totals)?.fuel_l_100km(),
    ),
    measure(
        "ego_fuel_sumo_l_100km",
        "Fuel consumption of the ego vehicle, SUMO",
        "l/100 km",
        "fuel of the ego vehicle by SUMO's emission model (HBEFA 4.2, petrol, Euro 4)",
        |s| s.totals.sumo_fuel[1].l_100km(),
    ),
    measure(
        "fuel_sumo_l_100km",
        "Fuel consumption of all vehicles, SUMO",
        "l/100 km",
        "fuel of all vehicles by SUMO's emission model (HBEFA 4.2, petrol, Euro 4)",
        |s| s.totals.sumo_fuel[0].l_100km(),
    ),
    measure(
        "fuel_saved_l_100km",
        "Fuel saved over no advice",
        "l/100 km",
        "fuel of all vehicles in the drive from the same seed without advice less that in this one",
        |s| Some(all_cars(s.baseline?)?.fuel_l_100km()? - all_cars(s.totals)?.fuel_l_100km()?),
    ),
    measure(
        "hand_over_sd_mps",
        "Standard deviation of speed over vehicles at hand-over",
        "m/s",
        "standard deviation of speed over the vehicles (N) at the moment at which the driver takes the car over: the wave that the drive \
         begins with",
        |s| Some(s.trial.setup.manifest.hand_over?.speed_sd_mps),
    ),
    measure("contacts", "Contacts with other vehicles", "", "how often the ego vehicle touched another vehicle", |s| {
        Some(s.trial.contacts as f64)
    }),
    measure("left_road", "Departures from the lane", "", "how often the middle of the car left its lane", |s| {
        Some(s.trial.left_road as f64)
    }),
    measure(
        "latency_median_s",
        "Median latency",
        "s",
        "from the newest input (the kernel's time) to the handing over of the frame that shows it: median over such frames",
        |s| middle(&s.trial.latencies_s),
    ),
    measure(
        "latency_p99_s",
        "99th percentile of latency",
        "s",
        "from the newest input (the kernel's time) to the handing over of the frame that shows it: 99th percentile (nearest rank)",
        |s| {
            let sorted = &s.trial.latencies_s;
            sorted.get((0.99 * sorted.len() as f64).ceil() as usize - usize::from(!sorted.is_empty())).copied()
        },
    ),
];

impl DriveMeasures {
    /// Of a drive with its totals and responses, and of the totals of the same without advice.
    pub fn of(
        trial: &RecordedTrial,
        totals: &DriveTotals,
        responses: Vec<AdviceResponse>,
        baseline: Option<&DriveTotals>,
    ) -> Self {
        let sight = MeasureInputs { trial, totals, baseline, responses: &responses };
        Self { values: MEASURES.iter().map(|measure| (measure.of)(&sight)).collect(), responses }
    }

    /// The value of a measure by its name.
    pub fn get(&self, name: &str) -> Option<f64> {
        let at = MEASURES.iter().position(|measure| measure.name == name)?;
        self.values.get(at).copied().flatten()
    }
}

#[cfg(test)]
#[path = "measures_tests.rs"]
mod tests;
