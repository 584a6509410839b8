//! Vehicles of the traffic that events of the scenario move. In: actions on vehicles; once a step, the view of the drive. Out: motions of these vehicles
//! in the step that begins, orders to the traffic, and what could not be carried out. Metres, m/s, seconds.

use super::{
    cut_in::{CutIn, CutInStep},
    driving_order::DrivingOrder,
    event_view::ScriptView,
    road_people::RoadPeople,
    road_users::RoadUsers,
    speed_control::SpeedControl,
    traffic_coupling::TrafficCoupling,
    yielding,
};
use crate::{
    scenario::{PlannedDrive, scripted_event::Action},
    sim::{VehicleSnapshot, event::NotDone},
    time::Tick,
    traffic::{LaneMotion, TrafficOrder, VehicleId},
};

/// Largest change of speed with which a vehicle returns to a speed that it keeps, m/s2.
const KEEPS_MPS2: f64 = 3.0;
/// Time in which SUMO keeps a vehicle on the lane that it has cut into, s.
const CUT_IN_S: f64 = 5.0;

/// Number of an event, vehicle that it no longer moves, and the reason.
pub(super) type Failed = (usize, VehicleId, NotDone);

/// Vehicles that events move.
pub(super) struct EventVehicles {
    controls: Vec<SpeedControl>,
    cut_ins: Vec<CutIn>,
    order: DrivingOrder,
    step_s: f64,
    is_open: bool,
    /// Motions in the step that begins, by ascending id.
    motions: Vec<LaneMotion>,
}

impl EventVehicles {
    /// Returns the state before the first event of a drive.
    pub fn new(drive: &PlannedDrive) -> Self {
        Self {
            controls: Vec::new(),
            cut_ins: Vec::new(),
            order: DrivingOrder::default(),
            step_s: drive.scenario().step_s,
            is_open: drive.is_open(),
            motions: Vec::new(),
        }
    }

    /// Checks whether an event moves a vehicle now.
    pub fn moves(&self, id: VehicleId) -> bool {
        self.controls.iter().any(|control| control.id == id) || self.cut_ins.iter().any(|cut_in| cut_in.id == id)
    }

    /// Checks whether an event still moves a vehicle.
    pub fn are_moved_by(&self, event: usize) -> bool {
        self.controls.iter().any(|control| control.event == event)
            || self.cut_ins.iter().any(|cut_in| cut_in.event == event)
    }

    /// Begins an action on a vehicle. Returns the time that the traffic has for it, s; 0 where the vehicle is moved from step to step.
    ///
    /// # Errors
    /// The traffic refuses it.
    pub fn begin(
        &mut self,
        event: usize,
        action: &Action,
        id: VehicleId,
        (seen, traffic): (&ScriptView, &mut TrafficCoupling),
    ) -> Result<f64, NotDone> {
        let speed_mps = seen.view.vehicle(id).map_or(0.0, |car| car.speed_mps);
        let [to_mps, rate_mps2, keep_s] = match action {
            Action::Brake { decel_mps2: rate_mps2, to_mps, keep_s, .. }
            | Action::Accelerate { accel_mps2: rate_mps2, to_mps, keep_s, .. } => [*to_mps, *rate_mps2, *keep_s],
            Action::KeepSpeed { for_s, .. } => [speed_mps, KEEPS_MPS2, *for_s],
            Action::BreakDown { decel_mps2, for_s, .. } => [0.0, *decel_mps2, *for_s],
            Action::CutIn { gap_m, within_s, .. } => {
                self.take_over(id, traffic)?;
                self.begin_cut_in(event, id, [*gap_m, *within_s], seen);
                return Ok(0.0);
            }
            Action::ChangeLane(change) => {
                let (to_the_left, duration_s) = (change.to_the_left, change.within_s);
                let order = TrafficOrder::ChangeLane { id, to_the_left, duration_s, keeps_gaps: true };
                return traffic.order(&order).map(|_| duration_s).map_err(|_| NotDone::Refused);
            }
            _ => return Ok(0.0),
        };
        self.take_over(id, traffic)?;
        let is_broken_down = matches!(action, Action::BreakDown { .. });
        self.controls.push(SpeedControl { event, id, to_mps, rate_mps2, keep_s, since: None, is_broken_down });
        Ok(0.0)
    }

    /// Begins an action on a road user.
    ///
    /// # Errors
    /// Road users do not carry it out.
    pub fn begin_on_user(
        &mut self,
        event: usize,
        action: &Action,
        id: VehicleId,
        (seen, users): (&ScriptView, &mut RoadUsers),
    ) -> Result<(), NotDone> {
        // A newer action ends a cut-in.
        self.cut_ins.retain(|cut_in| cut_in.id != id);
        if let Action::CutIn { gap_m, within_s, .. } = action {
            self.begin_cut_in(event, id, [*gap_m, *within_s], seen);
            return Ok(());
        }
        users.begin(event, action, id, (seen.view, seen.map))
    }

    fn begin_cut_in(&mut self, event: usize, id: VehicleId, [gap_m, within_s]: [f64; 2], seen: &ScriptView) {
        let until = Tick::at_seconds(seen.view.tick.seconds() + within_s);
        self.cut_ins.push(CutIn { event, id, gap_m, until, changing_since: None });
    }

    /// Moves all vehicles in the step that begins, and gives back those whose time is over. Returns what cannot be carried out.
    pub fn step(&mut self, seen: &ScriptView, (users, traffic): (&mut RoadUsers, &mut TrafficCoupling)) -> Vec<Failed> {
        let mut failed = Vec::new();
        self.motions.clear();
        self.control_speeds(seen, traffic, &mut failed);
        self.cut_in(seen, (users, traffic), &mut failed);
        self.motions.sort_by_key(|motion| motion.id);
        failed
    }

    /// Lets vehicles that no event moves brake for people on the road and for road users; the first `logged` of the others move as in a file.
    pub fn yield_to(&mut self, (people, users): (&RoadPeople, &RoadUsers), seen: &ScriptView, logged: u32) {
        let view = seen.view;
        let is_there = |id: VehicleId| users.has(id) || people.is_on_road(id, view.tick);
        let of_events = view.cars.iter().rev().take_while(|car| car.id.is_of_event());
        let on_road: Vec<_> = of_events.filter(|car| is_there(car.id)).collect();
        if on_road.is_empty() {
            return;
        }
        if !self.is_open {
            self.order.take(view, seen.own());
        }
        let (route, order) = (&seen.map.route, (!self.is_open).then_some(&self.order));
        let is_free = |id: VehicleId| id.0 > logged && !id.is_of_event() && !(seen.agents)(id) && !self.moves(id);
        let free = view.vehicles().filter(|car| is_free(car.id));
        let braking = free.filter_map(|car| yielding::motion(car, on_road.iter().copied(), route, order, self.step_s));
        let braking: Vec<_> = braking.collect();
        self.motions.extend(braking);
        self.motions.sort_by_key(|motion| motion.id);
    }

    /// Returns the motions of vehicles in the step that begins, by ascending id.
    pub fn motions(&self) -> &[LaneMotion] {
        &self.motions
    }

    /// Takes speed and lane from the model of a vehicle of a network, so that it moves as an event says.
    fn take_over(&self, id: VehicleId, traffic: &mut TrafficCoupling) -> Result<(), NotDone> {
        match self.is_open {
            true => traffic.order(&TrafficOrder::TakeOver { id }).map(drop).map_err(|_| NotDone::Refused),
            false => Ok(()),
        }
    }

    /// Gives a vehicle back to its own driver. It may have left in this step; then there is nothing to give back.
    fn give_back(&self, id: VehicleId, traffic: &mut TrafficCoupling) {
        if self.is_open {
            let _ = traffic.order(&TrafficOrder::GiveBack { id });
        }
    }

    /// Moves the vehicles whose speeds events change, and gives back those whose time is over.
    fn control_speeds(&mut self, seen: &ScriptView, traffic: &mut TrafficCoupling, failed: &mut Vec<Failed>) {
        if self.controls.is_empty() {
            return;
        }
        if !self.is_open {
            self.order.take(seen.view, seen.own());
        }
        let mut controls = std::mem::take(&mut self.controls);
        controls.retain_mut(|control| {
            let Some(car) = seen.view.vehicle(control.id) else {
                failed.push((control.event, control.id, NotDone::HasLeft));
                return false;
            };
            if control.is_over(car.speed_mps, seen.view.tick) {
                self.give_back(control.id, traffic);
                return false;
            }
            // An engine of networks keeps safe distances by itself.
            let leader = self.order.leader(control.id, &seen.map.route).filter(|_| !self.is_open);
            self.motions.push(control.motion(car.speed_mps, leader, self.step_s));
            true
        });
        self.controls = controls;
    }

    /// Moves the vehicles that cut in.
    fn cut_in(
        &mut self,
        seen: &ScriptView,
        (users, traffic): (&mut RoadUsers, &mut TrafficCoupling),
        failed: &mut Vec<Failed>,
    ) {
        let mut cut_ins = std::mem::take(&mut self.cut_ins);
        cut_ins.retain_mut(|cut_in| {
            let (event, id) = (cut_in.event, cut_in.id);
            let Some(car) = seen.view.vehicle(id) else {
                failed.push((event, id, NotDone::HasLeft));
                return false;
            };
            let step = cut_in.step(car, seen, self.step_s);
            if users.has(id) {
                if step == CutInStep::TooLate {
                    failed.push((event, id, NotDone::TooLate));
                }
                return users.cut_in(event, id, step, (seen, self.step_s));
            }
            match step {
                CutInStep::Drives(motion) => self.motions.push(motion),
                CutInStep::Changes(motion, to_the_left) => {
                    let order = TrafficOrder::ChangeLane { id, to_the_left, duration_s: CUT_IN_S, keeps_gaps: false };
                    if traffic.order(&order).is_err() {
                        failed.push((event, id, NotDone::Refused));
                        self.give_back(id, traffic);
                        return false;
                    }
                    self.motions.push(motion);
                }
                CutInStep::Over => {
                    self.give_back(id, traffic);
                    return false;
                }
                CutInStep::TooLate => {
                    failed.push((event, id, NotDone::TooLate));
                    self.give_back(id, traffic);
                    return false;
                }
            }
            true
        });
        self.cut_ins = cut_ins;
    }

    /// Switches the hazard lights of vehicles on that have broken down.
    pub fn switch_hazard_lights(&self, cars: &mut [VehicleSnapshot]) {
        for control in self.controls.iter().filter(|control| control.is_broken_down) {
            if let Ok(at) = cars.binary_search_by_key(&control.id, |car| car.id) {
                (cars[at].lamps.left, cars[at].lamps.right) = (true, true);
            }
        }
    }
}
