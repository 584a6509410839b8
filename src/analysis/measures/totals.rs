//! Sums of one drive. In: a [`RecordedTrial`], or its rows and steps in order. Out: [`DriveTotals`], the basis of the measures.
//! SI units.
//!
//! Only three parts grow with the drive: a number per second, a wave per half minute, and a response per change of the advice. They take 5 MB for seven
//! days, the longest drive, and at most 150 MB.

use crate::analysis::{
    data::{EgoSample, RecordedTrial, StepVehicle, TrafficStep},
    error::AnalysisError,
    network::{LinePlace, NetworkDriveTotals},
    responses::{AdviceResponse, OnsetFinder, PedalNoise, ResponseWatch, response_detection::PEDAL},
};
use crate::{
    metrics::{
        Approach, AutomationChange, RunningMean, RunningMinimum, TakeoverLog, TickTotals, TrafficTotals,
        fuel::SumoFuelTotals,
        waves::{VehicleSample, WaveTotals},
    },
    sim::is_in_lane,
    time::{TICK_S, TICKS_PER_S, Tick},
};
use std::collections::BTreeMap;

/// Gap size of a reversal of the pedals, share of travel: the movement that ends a movement time.
pub const PEDAL_REVERSAL: f64 = PEDAL;

/// Gap size of a steering reversal, degrees of the steering wheel.
pub const REVERSAL_DEG: f64 = 3.0;

/// Smallest speed for a gap or headway in seconds, m/s: at a standstill they are infinite.
pub const MOVING_MPS: f64 = 1.0;

/// Largest gap or headway of a follower on a network, seconds; beyond it, a vehicle drives freely (Vogel 2002).
pub const FOLLOWING_S: f64 = 6.0;

/// Sums of a drive.
#[derive(Clone, Debug)]
pub struct DriveTotals {
    /// Speeds, range and gap of every tick, as a summary has them.
    pub ticks: TickTotals,
    /// Share of the ticks with advice in the range at a speed that the driver chose: not up to
    /// [`AFTER_CONTACT_S`](crate::analysis::data::trial::AFTER_CONTACT_S) after a collision.
    pub in_range_by_driver: RunningMean,
    /// Speed less target, m/s.
    pub error_mps: RunningMean,
    /// Absolute difference of speed and target, m/s.
    pub absolute_error_mps: RunningMean,
    /// Headway to the leader, metres.
    pub headway_m: RunningMinimum,
    /// Time to collision, seconds.
    pub ttc_s: RunningMinimum,
    /// Largest deceleration rate to avoid a crash, m/s2; 0 if a leader was there and the gap never closed.
    pub most_drac_mps2: Option<f64>,
    /// Gap over speed, seconds, while the ego moves at [`MOVING_MPS`] or more.
    pub time_gap_s: RunningMean,
    /// Smallest gap over speed, seconds.
    pub min_time_gap_s: RunningMinimum,
    /// Headway over speed, seconds, while the ego moves at [`MOVING_MPS`] or more.
    pub time_headway_s: RunningMean,
    /// Smallest headway over speed, seconds.
    pub min_time_headway_s: RunningMinimum,
    /// Reversals of the steering wheel.
    pub reversals: SteeringReversals,
    /// Reversals of the pedals, accelerator less brake.
    pub pedal_reversals: SteeringReversals,
    /// Square of the jerk between steps, (m/s3)^2.
    pub square_jerk: RunningMean,
    /// Vehicles past the start of the route, less those that go back over it.
    pub passages: i64,
    /// All vehicles, at each step; on a network at full seconds, at which all vehicles have a row.
    pub traffic: TrafficTotals,
    /// The ego alone, at each step.
    pub ego_traffic: TrafficTotals,
    /// Waves of all vehicles; `None` on a network, or if the length of the route is unknown.
    pub waves: Option<WaveTotals>,
    /// Fuel of all vehicles and of the ego by SUMO's model.
    pub sumo_fuel: [SumoFuelTotals; 2],
    /// Mean speed of all vehicles over each whole second, m/s.
    pub per_second_mps: Vec<f64>,
    /// Length of the drive, seconds.
    pub duration_s: f64,
    /// Sums of a drive on a network; `None` on a closed route.
    pub network: Option<NetworkDriveTotals>,
    /// Takeovers from the automation.
    pub takeovers: TakeoverLog,
    step_s: f64,
    route_m: f64,
    after_contacts: std::iter::Peekable<std::vec::IntoIter<[u64; 2]>>,
    automation_changes: std::iter::Peekable<std::vec::IntoIter<(Tick, AutomationChange)>>,
    /// Position of each vehicle along the route at the last step, metres, by vehicle number.
    places_m: BTreeMap<u32, f64>,
    lane_offset_m: RunningMean,
    /// Squares of the offsets about their mean, m2.
    lane_squares_m2: f64,
    second: RunningMean,
    step_accel_mps2: RunningMean,
    accel_before_mps2: Option<f64>,
}

impl DriveTotals {
    /// Starts the sums of a drive with steps of `step_s`.
    pub fn new(step_s: f64) -> Self {
        Self {
            ticks: TickTotals::default(),
            in_range_by_driver: RunningMean::default(),
            error_mps: RunningMean::default(),
            absolute_error_mps: RunningMean::default(),
            headway_m: RunningMinimum::default(),
            ttc_s: RunningMinimum::default(),
            most_drac_mps2: None,
            time_gap_s: RunningMean::default(),
            min_time_gap_s: RunningMinimum::default(),
            time_headway_s: RunningMean::default(),
            min_time_headway_s: RunningMinimum::default(),
            reversals: SteeringReversals::new(REVERSAL_DEG),
            pedal_reversals: SteeringReversals::new(PEDAL_REVERSAL),
            passages: 0,
            square_jerk: RunningMean::default(),
            traffic: TrafficTotals::new(step_s),
            ego_traffic: TrafficTotals::new(step_s),
            waves: None,
            sumo_fuel: Default::default(),
            per_second_mps: Vec::new(),
            duration_s: 0.0,
            network: None,
            takeovers: TakeoverLog::default(),
            step_s,
            route_m: 0.0,
            after_contacts: Vec::new().into_iter().peekable(),
            automation_changes: Vec::new().into_iter().peekable(),
            places_m: BTreeMap::new(),
            lane_offset_m: RunningMean::default(),
            lane_squares_m2: 0.0,
            second: RunningMean::default(),
            step_accel_mps2: RunningMean::default(),
            accel_before_mps2: None,
        }
    }

    /// Sets the length of the route and the collisions from `trial`.
    pub fn on(mut self, trial: &RecordedTrial) -> Self {
        self.route_m = trial.setup.lap_m();
        self.waves = (self.route_m > 0.0).then(|| WaveTotals::on_ring(self.step_s, self.route_m));
        self.after_contacts = trial.after_contacts.clone().into_iter().peekable();
        self.automation_changes = trial.automation_changes.clone().into_iter().peekable();
        self
    }

    /// Adds the sums of a network.
    pub fn on_network(self, network: NetworkDriveTotals) -> Self {
        Self { network: Some(network), traffic: TrafficTotals::new(1.0), waves: None, ..self }
    }

    /// Reads a whole drive; returns its responses, too, and gives each row of the ego to `each`. `practice` has the idle pedal
    /// movements of the same person; `lines` are the lines for throughput on a network.
    ///
    /// # Errors
    /// A table cannot be read, or does not have this program's format; a line is not on the network.
    pub fn of(
        trial: &RecordedTrial,
        practice: Option<&PedalNoise>,
        lines: &[LinePlace],
        mut each: impl FnMut(&EgoSample),
    ) -> Result<(Self, Vec<AdviceResponse>), AnalysisError> {
        let step_s = trial.setup.scenario.step_s;
        let mut totals = Self::new(step_s).on(trial);
        if let Some(trips) = trial.trips()? {
            totals = totals.on_network(NetworkDriveTotals::open(trial, trips, lines)?);
        }
        let mut onsets = OnsetFinder::new(trial.changes.clone());
        for ego in trial.ego()? {
            let ego = ego?;
            totals.add(&ego);
            onsets.add(&ego);
            each(&ego);
        }
        // A second pass: responses need the idle movements of the whole drive. Squares about the mean need the mean first;
        // squares about any other value lose digits.
        let mut responses = ResponseWatch::new(step_s, onsets.finish(), practice);
        for ego in trial.ego()? {
            let ego = ego?;
            responses.add(&ego);
            totals.add_lane_offset(ego.lane_offset_m);
        }
        for step in trial.steps()? {
            totals.add_step(&step?);
        }
        let step_ticks = trial.setup.scenario.step_ticks();
        totals.network.iter_mut().for_each(|network| network.finish(step_ticks));
        Ok((totals, responses.finish()))
    }

    /// Adds the ego's row of the next tick.
    pub fn add(&mut self, ego: &EgoSample) {
        while let Some((tick, change)) = self.automation_changes.next_if(|(tick, _)| tick.0 <= ego.tick) {
            self.takeovers.add(tick, change);
        }
        self.takeovers.watch(Tick(ego.tick), ego.ttc_s, ego.lane_offset_m);
        self.ticks.mean_speed_mps.add(ego.mean_speed_mps);
        self.ticks.add_ego(ego.speed_mps, ego.in_range);
        if let Some(is_in_range) = ego.in_range {
            while self.after_contacts.next_if(|span| span[1] <= ego.tick).is_some() {}
            let by_driver = is_in_range && self.after_contacts.peek().is_none_or(|span| ego.tick < span[0]);
            self.in_range_by_driver.add(f64::from(u8::from(by_driver)));
        }
        if let Some(target_mps) = ego.target_mps {
            self.error_mps.add(ego.speed_mps - target_mps);
            self.absolute_error_mps.add((ego.speed_mps - target_mps).abs());
        }
        if is_in_lane(ego.lane_offset_m) {
            self.ticks.min_gap_m.add(ego.gap_m);
            self.headway_m.add(ego.headway_m);
            self.ttc_s.add(ego.ttc_s);
            self.add_drac(ego);
            if let Some(gap_m) = ego.gap_m.filter(|_| ego.speed_mps >= MOVING_MPS) {
                if self.follows(gap_m / ego.speed_mps) {
                    self.time_gap_s.add(gap_m / ego.speed_mps);
                }
                self.min_time_gap_s.add(Some(gap_m / ego.speed_mps));
            }
            if let Some(headway_m) = ego.headway_m.filter(|_| ego.speed_mps >= MOVING_MPS) {
                if self.follows(headway_m / ego.speed_mps) {
                    self.time_headway_s.add(headway_m / ego.speed_mps);
                }
                self.min_time_headway_s.add(Some(headway_m / ego.speed_mps));
            }
        }
        self.reversals.add(ego.wheel_rad.to_degrees());
        self.pedal_reversals.add(ego.throttle - ego.brake);
        if self.counts_lane_offset(ego.lane_offset_m) {
            self.lane_offset_m.add(ego.lane_offset_m);
        }
        self.duration_s = Tick(ego.tick).seconds();
        self.add_accel(ego.accel_mps2);
        self.add_to_second(ego.mean_speed_mps);
    }

    /// Adds the deceleration rate to avoid a crash: closing speed squared over twice the gap.
    fn add_drac(&mut self, ego: &EgoSample) {
        let Some(gap_m) = ego.gap_m else { return };
        // The recording has the time to collision, gap over closing speed, while the gap closes.
        let closing_mps = ego.ttc_s.filter(|ttc_s| *ttc_s > 0.0).map_or(0.0, |ttc_s| gap_m / ttc_s);
        let drac_mps2 = Approach { gap_m, closing_mps }.drac_mps2();
        self.most_drac_mps2 = Some(self.most_drac_mps2.map_or(drac_mps2, |most| most.max(drac_mps2)));
    }

    /// Averages the acceleration over a step, and adds the jerk from the step before.
    fn add_accel(&mut self, accel_mps2: f64) {
        let ticks = (self.step_s / TICK_S).round().max(1.0) as u64;
        self.step_accel_mps2.add(accel_mps2);
        if self.step_accel_mps2.count() < ticks {
            return;
        }
        let over = std::mem::take(&mut self.step_accel_mps2).get();
        if let (Some(before), Some(now)) = (std::mem::replace(&mut self.accel_before_mps2, over), over) {
            self.square_jerk.add(((now - before) / self.step_s).powi(2));
        }
    }

    fn add_to_second(&mut self, mean_speed_mps: f64) {
        self.second.add(mean_speed_mps);
        if self.second.count() == u64::from(TICKS_PER_S) {
            self.per_second_mps.extend(std::mem::take(&mut self.second).get());
        }
    }

    /// Adds the vehicles with a row at the end of the next step.
    pub fn add_step(&mut self, step: &TrafficStep) {
        let vehicles = || step.vehicles.iter().map(|vehicle| (vehicle.id, vehicle.speed_mps.max(0.0)));
        let speeds = || vehicles().map(|(_, speed_mps)| speed_mps as f32);
        self.ego_traffic.add(vehicles().take(1));
        self.sumo_fuel[1].add(speeds().take(1), self.step_s);
        if self.network.is_none() || step.has_all() {
            self.traffic.add(vehicles());
        }
        if let Some(network) = &mut self.network {
            network.add_step(step);
            return;
        }
        self.sumo_fuel[0].add(speeds(), self.step_s);
        if let Some(waves) = &mut self.waves {
            let sample = |vehicle: &StepVehicle| VehicleSample {
                speed_mps: vehicle.speed_mps,
                position_m: vehicle.s_m.unwrap_or(f64::NAN),
            };
            waves.add(step.vehicles.iter().map(sample));
        }
        // A move back by more than half the route crosses its start.
        for (id, now_m) in step.vehicles.iter().filter_map(|vehicle| Some((vehicle.id, vehicle.s_m?))) {
            let Some(before_m) = self.places_m.insert(id, now_m) else { continue };
            let way_m = now_m - before_m;
            self.passages += i64::from(way_m < -0.5 * self.route_m) - i64::from(way_m > 0.5 * self.route_m);
        }
    }

    /// Adds the offset from the lane's middle of a tick, in a second pass after all ticks.
    pub fn add_lane_offset(&mut self, offset_m: f64) {
        if !self.counts_lane_offset(offset_m) {
            return;
        }
        let middle_m = self.lane_offset_m.get().unwrap_or_default();
        self.lane_squares_m2 += (offset_m - middle_m).powi(2);
    }

    /// Checks whether the ego follows: always on a closed route, and on a network up to [`FOLLOWING_S`].
    fn follows(&self, behind_s: f64) -> bool {
        self.network.is_none() || behind_s <= FOLLOWING_S
    }

    /// Checks whether an offset counts for the lane position. On a network it is relative to the path, and counts only in the
    /// path's lane.
    fn counts_lane_offset(&self, offset_m: f64) -> bool {
        self.network.is_none() || is_in_lane(offset_m)
    }

    /// Returns the length of a step, seconds.
    pub fn step_s(&self) -> f64 {
        self.step_s
    }

    /// Returns the standard deviation of the offset from the lane's middle (N-1), metres.
    pub fn sdlp_m(&self) -> Option<f64> {
        let n = self.lane_offset_m.count();
        (n > 1).then(|| (self.lane_squares_m2 / (n - 1) as f64).sqrt())
    }
}

/// Counts the reversals of an angle, or of the pedals: turns back by at least a gap from an extreme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SteeringReversals {
    gap: f64,
    /// Reversals so far, of both directions.
    pub count: usize,
    /// Extremes since the last reversal, and the direction of the last turn: 0 before the first.
    low: f64,
    high: f64,
    way: i8,
}

impl SteeringReversals {
    /// Starts with this gap size, in the unit of the angle.
    pub fn new(gap: f64) -> Self {
        Self { gap, count: 0, low: f64::INFINITY, high: f64::NEG_INFINITY, way: 0 }
    }

    /// Adds the next angle, in the unit of the gap.
    pub fn add(&mut self, angle: f64) {
        self.low = self.low.min(angle);
        self.high = self.high.max(angle);
        if self.way >= 0 && self.high - angle >= self.gap {
            self.count += usize::from(self.way > 0);
            (self.way, self.low) = (-1, angle);
        } else if self.way <= 0 && angle - self.low >= self.gap {
            self.count += usize::from(self.way < 0);
            (self.way, self.high) = (1, angle);
        }
    }
}
