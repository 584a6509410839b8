//! Events of a scenario in a drive. In: once a step the participant's view. Out: motions of vehicles of the traffic and orders to it, what the
//! participant is shown, and what is recorded of each event. Metres, m/s, seconds.
//!
//! Triggers are looked at where a step of the traffic begins. The engine then makes that step with the motions, so that a vehicle begins to
//! move by its event in the step's first tick, which is recorded as the event's onset.

use super::{driving_order::DrivingOrder, speed_control::SpeedControl, traffic_coupling::TrafficCoupling};
use crate::{
    map::RoadMap,
    policy::Advice,
    rng::{self, Stream},
    scenario::{
        PlannedDrive, ScriptedEvent,
        scripted_event::{Action, FOLLOWER, LEADER, Trigger},
    },
    sim::{
        Event, EventKind, Snapshot, VehicleSnapshot,
        event::{EventStage, NotDone},
    },
    time::{TICK_S, Tick},
    traffic::{EGO, LaneMotion, TrafficOrder, VehicleId},
};
use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

/// Bits of SUMO's speed mode: all checks; and those without the vehicle's own limits of acceleration and braking.
const ALL_CHECKS: u32 = 31;
const WITHOUT_OWN_LIMITS: u32 = 1 + 8 + 16;
/// Distance from the ego's front within which another vehicle is its follower, metres.
const FOLLOWER_REACH_M: f64 = 200.0;

/// State of all events of a drive.
pub(super) struct EventScript {
    runs: Vec<EventRun>,
    controls: Vec<SpeedControl>,
    /// True if an event names a vehicle by its name in the demand.
    has_names: bool,
    /// Vehicles by these names.
    names: BTreeMap<String, VehicleId>,
    /// Vehicles whose names are known.
    asked: BTreeSet<VehicleId>,
    order: DrivingOrder,
    step_s: f64,
    is_open: bool,
    /// Number of vehicles that move as in a file: the first of the others.
    logged: u32,
    /// Ego's place and advice at the step before.
    before: Option<(f64, Option<Advice>)>,
    /// Records of the tick that begins next.
    events: Vec<Event>,
    /// Motions in the step that begins, by ascending id.
    motions: Vec<LaneMotion>,
}

/// An event with its state.
struct EventRun {
    event: ScriptedEvent,
    stage: Stage,
    chance: Stream,
    was_true: bool,
    ended: Option<Tick>,
}

#[derive(Clone, Copy, PartialEq)]
enum Stage {
    Armed,
    /// The event has begun at the first tick; its actions other than those on speeds end at the second one.
    Running(Tick, Tick),
    Over,
}

/// Message and advice as events show them to the participant.
#[derive(Default)]
pub(super) struct ShownByEvents {
    pub message: Option<Arc<str>>,
    pub hides_advice: bool,
}

/// View of a drive where a step begins.
pub(super) struct ScriptView<'a> {
    /// The participant's view of all vehicles.
    pub view: &'a Snapshot,
    pub map: &'a RoadMap,
    /// Image of the participant's vehicle.
    pub own: Option<&'a VehicleSnapshot>,
    /// Vehicles with drivers of their own.
    pub agents: &'a dyn Fn(VehicleId) -> bool,
}

impl ScriptView<'_> {
    /// Returns the distance from the ego's front to another vehicle ahead, bumper to bumper along the route; beside the route, from body to body.
    /// `None` for one that is behind.
    fn distance_m(&self, id: VehicleId) -> Option<f64> {
        if let Some(leader) = self.view.leader.filter(|leader| leader.id == id) {
            return Some(leader.gap_m);
        }
        let car = self.view.vehicle(id)?;
        let along_m = car.s_m.map(|s_m| self.map.route.drawn_ahead_m(self.view.ego_s_m, s_m) - car.body.length_m);
        let beside_m = || {
            self.own.map(|own| {
                own.pose.position.distance(car.pose.position) - (own.body.length_m + car.body.length_m) / 2.0
            })
        };
        along_m.or_else(beside_m).filter(|distance_m| *distance_m >= 0.0)
    }

    fn follower(&self) -> Option<VehicleId> {
        let own_m = self.own?.body.length_m;
        let behind = self.view.vehicles().filter_map(|car| {
            let gap_m = self.map.route.drawn_ahead_m(car.s_m?, self.view.ego_s_m) - own_m;
            (0.0..FOLLOWER_REACH_M).contains(&gap_m).then_some((gap_m, car.id))
        });
        behind.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, id)| id)
    }
}

impl EventScript {
    /// Arms the events of a drive.
    pub fn new(drive: &PlannedDrive) -> Self {
        let scenario = drive.scenario();
        let is_name = |name: &String| name != LEADER && name != FOLLOWER && name.parse::<u32>().is_err();
        let has_name = |event: &ScriptedEvent| {
            event.actions.iter().filter_map(Action::vehicle).chain(event.trigger.vehicles()).any(is_name)
        };
        let run = |event: &ScriptedEvent| EventRun {
            event: event.clone(),
            stage: Stage::Armed,
            chance: rng::stream(scenario.seed, &format!("event/{}", event.name)),
            was_true: false,
            ended: None,
        };
        Self {
            runs: scenario.events.iter().map(run).collect(),
            controls: Vec::new(),
            has_names: drive.is_open() && scenario.events.iter().any(has_name),
            names: BTreeMap::new(),
            asked: BTreeSet::new(),
            order: DrivingOrder::default(),
            step_s: scenario.step_s,
            is_open: drive.is_open(),
            logged: drive.logged().map_or(0, |logged| logged.log.vehicles().len() as u32),
            before: None,
            events: Vec::new(),
            motions: Vec::new(),
        }
    }

    /// Begins and ends events where a step begins, and moves vehicles in that step.
    pub fn step(&mut self, seen: &ScriptView, traffic: &mut TrafficCoupling) {
        self.motions.clear();
        if self.runs.is_empty() {
            return;
        }
        self.learn_names(seen.view, traffic);
        let now = seen.view.tick;
        for k in 0..self.runs.len() {
            let is_true = self.holds(&self.runs[k].event.trigger, seen);
            let run = &mut self.runs[k];
            let comes_true = is_true && !run.was_true;
            run.was_true = is_true;
            if comes_true && run.stage == Stage::Armed {
                self.begin(k, seen, traffic);
            }
        }
        self.control_speeds(seen, traffic);
        for k in 0..self.runs.len() {
            let is_moving = self.controls.iter().any(|control| control.event == k);
            let run = &mut self.runs[k];
            if matches!(run.stage, Stage::Running(_, until) if until <= now) && !is_moving {
                run.stage = if run.event.repeats { Stage::Armed } else { Stage::Over };
                run.ended = Some(now);
                self.note(k, None, now, EventStage::Ended);
            }
        }
        self.before = Some((seen.view.ego_s_m, seen.view.advice));
    }

    /// Returns the motions of vehicles in the step that begins, by ascending id.
    pub fn motions(&self) -> &[LaneMotion] {
        &self.motions
    }

    /// Takes what is recorded in the tick that begins.
    pub fn take_events(&mut self) -> impl Iterator<Item = Event> {
        self.events.drain(..)
    }

    /// Returns what the participant is shown in the step that begins.
    pub fn shown(&self, now: Tick) -> ShownByEvents {
        let mut shown = ShownByEvents::default();
        for run in &self.runs {
            let Stage::Running(begun, _) = run.stage else { continue };
            let is_on = |for_s: f64| now < Tick::at_seconds(begun.seconds() + for_s);
            for action in &run.event.actions {
                match action {
                    Action::Message { text, for_s } if is_on(*for_s) => shown.message = Some(text.as_str().into()),
                    Action::HideAdvice { for_s } if is_on(*for_s) => shown.hides_advice = true,
                    _ => {}
                }
            }
        }
        shown
    }

    /// Checks whether a trigger is true where a step begins.
    fn holds(&self, trigger: &Trigger, seen: &ScriptView) -> bool {
        let (view, now_s) = (seen.view, seen.view.tick.seconds());
        let distance_m =
            |to: &str| self.vehicle(to, seen).and_then(|id| Some((seen.distance_m(id)?, view.vehicle(id)?)));
        let speed_mps = view.ego.speed_mps;
        match trigger {
            Trigger::TimeS(time_s) => now_s + TICK_S / 2.0 >= *time_s,
            Trigger::PlaceM(place_m) => self.reaches(*place_m, seen),
            Trigger::SpeedAboveMps(above_mps) => speed_mps > *above_mps,
            Trigger::SpeedBelowMps(below_mps) => speed_mps < *below_mps,
            Trigger::Distance { to, below_m } => distance_m(to).is_some_and(|(gap_m, _)| gap_m < *below_m),
            Trigger::TimeGap { to, below_s } => distance_m(to).is_some_and(|(gap_m, _)| gap_m < *below_s * speed_mps),
            Trigger::TimeToCollision { to, below_s } => {
                distance_m(to).is_some_and(|(gap_m, car)| gap_m < *below_s * (speed_mps - car.speed_mps))
            }
            Trigger::After { event, delay_s } => {
                let before = self.runs.iter().find(|run| run.event.name == *event);
                let ended = before.and_then(|run| run.ended);
                ended.is_some_and(|ended| now_s + TICK_S / 2.0 >= ended.seconds() + delay_s)
            }
            Trigger::AdviceChanges => self.before.is_some_and(|(_, before)| {
                let target = |advice: Option<Advice>| advice.map(|advice| advice.target_mps);
                view.advice.is_some() && target(view.advice) != target(before)
            }),
            Trigger::EgoBrakes => view.ego.braking,
            Trigger::Any(list) => list.iter().any(|trigger| self.holds(trigger, seen)),
            Trigger::All(list) => list.iter().all(|trigger| self.holds(trigger, seen)),
        }
    }

    /// Checks whether the ego's front has reached a place of its route; on a closed one, whether it has passed it in the step before.
    fn reaches(&self, place_m: f64, seen: &ScriptView) -> bool {
        let (route, here_m) = (&seen.map.route, seen.view.ego_s_m);
        if !route.is_closed() {
            return here_m >= place_m;
        }
        self.before.is_some_and(|(before_m, _)| {
            let (way_m, to_place_m) = (route.ahead(before_m, here_m), route.ahead(before_m, place_m));
            way_m < route.length_m() / 2.0 && to_place_m > 0.0 && to_place_m <= way_m
        })
    }

    /// Returns the vehicle of this name.
    fn vehicle(&self, name: &str, seen: &ScriptView) -> Option<VehicleId> {
        match name {
            LEADER => seen.view.leader.map(|leader| leader.id),
            FOLLOWER => seen.follower(),
            _ => match name.parse() {
                Ok(number) => seen.view.vehicle(VehicleId(number)).map(|car| car.id),
                Err(_) => self.names.get(name).copied().filter(|id| seen.view.vehicle(*id).is_some()),
            },
        }
    }

    /// Learns the names of vehicles that have come, if events need them.
    fn learn_names(&mut self, view: &Snapshot, traffic: &TrafficCoupling) {
        if !self.has_names {
            return;
        }
        for car in view.cars.iter().filter(|car| car.id != EGO) {
            if self.asked.insert(car.id)
                && let Ok([name, _]) = traffic.names(car.id)
            {
                self.names.insert(name, car.id);
            }
        }
    }

    /// Begins an event whose trigger has come true.
    fn begin(&mut self, k: usize, seen: &ScriptView, traffic: &mut TrafficCoupling) {
        let now = seen.view.tick;
        let run = &mut self.runs[k];
        let event = run.event.clone();
        if run.chance.uniform(0.0, 1.0) >= event.probability {
            run.stage = if event.repeats { Stage::Armed } else { Stage::Over };
            self.note(k, None, now, EventStage::NotDone(NotDone::ByChance));
            return;
        }
        run.ended = None;
        self.note(k, None, now, EventStage::Triggered);
        let mut until = now;
        for action in &event.actions {
            let id = action.vehicle().map(|name| self.vehicle(name, seen));
            let begun = match id {
                Some(None) => Err(NotDone::NoVehicle),
                Some(Some(id)) if (seen.agents)(id) || id.0 <= self.logged => Err(NotDone::OwnDriver),
                Some(Some(id)) if self.controls.iter().any(|control| control.id == id) => Err(NotDone::OtherEvent),
                Some(id) => self.act(k, action, id, traffic),
                None => self.act(k, action, None, traffic),
            };
            let id = id.flatten();
            match begun {
                Ok(lasts_s) => {
                    until = until.max(Tick::at_seconds(now.seconds() + lasts_s));
                    self.note(k, id, Tick(now.0 + 1), EventStage::Onset);
                }
                Err(why) => self.note(k, id, now, EventStage::NotDone(why)),
            }
        }
        self.runs[k].stage = Stage::Running(now, until);
    }

    /// Begins an action. Returns its duration, s, without that of a change of speed.
    fn act(
        &mut self,
        event: usize,
        action: &Action,
        id: Option<VehicleId>,
        traffic: &mut TrafficCoupling,
    ) -> Result<f64, NotDone> {
        let id = id.unwrap_or(EGO);
        match action {
            Action::Brake { decel_mps2: rate_mps2, to_mps, keep_s, .. }
            | Action::Accelerate { accel_mps2: rate_mps2, to_mps, keep_s, .. } => {
                if self.is_open {
                    let order = TrafficOrder::SpeedMode { id, mode: WITHOUT_OWN_LIMITS };
                    traffic.order(&order).map_err(|_| NotDone::Refused)?;
                }
                let (to_mps, rate_mps2, keep_s) = (*to_mps, *rate_mps2, *keep_s);
                self.controls.push(SpeedControl { event, id, to_mps, rate_mps2, keep_s, since: None });
                Ok(0.0)
            }
            Action::ChangeLane { to_the_left, within_s, .. } => {
                let (to_the_left, duration_s) = (*to_the_left, *within_s);
                let order = TrafficOrder::ChangeLane { id, to_the_left, duration_s };
                traffic.order(&order).map_err(|_| NotDone::Refused)?;
                Ok(duration_s)
            }
            Action::Message { for_s, .. } | Action::HideAdvice { for_s } => Ok(*for_s),
        }
    }

    /// Moves the vehicles whose speeds events change, and gives back those whose time is over.
    fn control_speeds(&mut self, seen: &ScriptView, traffic: &mut TrafficCoupling) {
        if self.controls.is_empty() {
            return;
        }
        if !self.is_open {
            self.order.take(seen.view, seen.own);
        }
        let mut controls = std::mem::take(&mut self.controls);
        controls.retain_mut(|control| {
            let Some(car) = seen.view.vehicle(control.id) else {
                self.note(control.event, Some(control.id), seen.view.tick, EventStage::NotDone(NotDone::HasLeft));
                return false;
            };
            if control.is_over(car.speed_mps, seen.view.tick) {
                if self.is_open {
                    // It may have left in this step; then there is nothing to give back.
                    let _ = traffic.order(&TrafficOrder::SpeedMode { id: control.id, mode: ALL_CHECKS });
                }
                return false;
            }
            // An engine of networks keeps safe distances by itself.
            let leader = self.order.leader(control.id, &seen.map.route).filter(|_| !self.is_open);
            self.motions.push(control.motion(car.speed_mps, leader, self.step_s));
            true
        });
        self.controls = controls;
        self.motions.sort_by_key(|motion| motion.id);
    }

    fn note(&mut self, event: usize, vehicle: Option<VehicleId>, tick: Tick, stage: EventStage) {
        let kind = EventKind::Scripted { event: event as u16, vehicle, stage };
        self.events.push(Event { tick, kind });
    }
}
