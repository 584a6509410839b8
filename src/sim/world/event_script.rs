//! Events of a scenario in a drive. In: once a step the participant's view. Out: motions of vehicles of the traffic and orders to it, what the
//! participant is shown, and what is recorded of each event. Metres, m/s, seconds.
//!
//! Triggers are looked at where a step of the traffic begins. The engine then makes that step with the motions, so that a vehicle begins to
//! move by its event in the step's first tick, which is recorded as the event's onset.

use super::{
    event_vehicles::EventVehicles, event_view::ScriptView, questions::Questions, road_people::RoadPeople,
    road_users::RoadUsers, traffic_coupling::TrafficCoupling,
};
use crate::{
    controls::Controls,
    ego::{Disturbance, water_mm},
    map::{
        StopLine,
        network::{Side, SignalPhase},
        stop_lines,
    },
    policy::Advice,
    rng::{self, Stream},
    scenario::{
        PlannedDrive, ScriptedEvent,
        scripted_event::{Action, DriverInput, EGO_NAME, EventLight, PLACES},
    },
    sim::{
        Event, EventKind, Snapshot, VehicleSnapshot,
        automation::AutomationOrder,
        event::{EventStage, NotDone, ScriptedState},
    },
    snapshot::{EventStimuli, Weather},
    time::Tick,
    traffic::{EGO, LaneMotion, TrafficOrder, VehicleId},
};
use std::{
    collections::{BTreeMap, BTreeSet},
    sync::Arc,
};

/// State of all events of a drive.
pub(super) struct EventScript {
    pub(super) runs: Vec<EventRun>,
    vehicles: EventVehicles,
    /// Inputs of the driver that triggers look at, and those given since the last step.
    looks_at: Vec<DriverInput>,
    pub(super) given: Vec<DriverInput>,
    /// True if an event names a vehicle by its name in the demand.
    has_names: bool,
    /// Vehicles by these names.
    names: BTreeMap<String, VehicleId>,
    /// Vehicles whose names are known.
    asked: BTreeSet<VehicleId>,
    /// People whom the events move.
    pub people: RoadPeople,
    /// Road users that the scenario places.
    pub users: RoadUsers,
    /// Questions to the participant.
    pub questions: Questions,
    /// Stop lines on the ego's path, for events that name signals.
    pub(super) lines: Vec<StopLine>,
    /// Step of the traffic, s.
    pub(super) step_s: f64,
    /// True once an event has ended the drive.
    ends_drive: bool,
    /// Number of vehicles that move as in a file: the first of the others.
    logged: u32,
    /// Ego's place and advice at the step before.
    pub(super) before: Option<(f64, Option<Advice>)>,
    /// Weather of the scenario, and its last change by an event.
    weather: Weather,
    change: Option<WeatherChange>,
    /// Records of the tick that begins next.
    events: Vec<Event>,
    /// Order to the automation in the tick that begins next.
    order_to_automation: Option<AutomationOrder>,
}

/// An event with its state.
pub(super) struct EventRun {
    pub(super) event: ScriptedEvent,
    stage: Stage,
    chance: Stream,
    was_true: bool,
    /// True once the experimenter has begun it by hand, until the next step.
    is_asked: bool,
    /// Tick until which the trigger has to be true, and tick at which the event begins after its delay.
    due: Option<[Tick; 2]>,
    /// Number of times that it has begun.
    pub(super) times: u32,
    pub(super) begun: Option<Tick>,
    pub(super) ended: Option<Tick>,
}

impl EventRun {
    /// Checks whether the event can begin again after its end.
    fn can_repeat(&self) -> bool {
        self.event.repeats && self.event.most_times.is_none_or(|most| self.times < most)
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Stage {
    Armed,
    /// The event has begun at the first tick; its actions other than those on speeds end at the second one.
    Running(Tick, Tick),
    Over,
}

/// Change of the weather by an event.
struct WeatherChange {
    from: Weather,
    to: Weather,
    begun: Tick,
    over_s: f64,
}

impl WeatherChange {
    /// Returns the weather at a tick. It changes once a second, as a new sky takes long to paint.
    fn at(&self, now: Tick) -> Weather {
        let passed_s = (now.seconds() - self.begun.seconds()).floor();
        self.from.towards(&self.to, if passed_s < self.over_s { passed_s / self.over_s } else { 1.0 })
    }
}

/// Effects of events on the participant and the car.
#[derive(Default)]
pub(super) struct EffectsOfEvents {
    pub message: Option<Arc<str>>,
    pub stimuli: EventStimuli,
    pub hides_advice: bool,
    pub disturbance: Disturbance,
    /// Weather, once an event has changed it.
    pub weather: Option<Weather>,
}

impl EventScript {
    /// Arms the events of a drive.
    pub fn new(drive: &PlannedDrive) -> Self {
        let scenario = drive.scenario();
        let is_user = |name: &str| name == EGO_NAME || scenario.road_users.iter().any(|user| user.name == name);
        let is_name =
            |name: &String| !PLACES.contains(&name.as_str()) && !is_user(name) && name.parse::<u32>().is_err();
        let has_name = |event: &ScriptedEvent| {
            event.actions.iter().filter_map(Action::vehicle).chain(event.trigger.vehicles()).any(is_name)
        };
        let run = |event: &ScriptedEvent| EventRun {
            event: event.clone(),
            stage: Stage::Armed,
            chance: rng::stream(scenario.seed, &format!("event/{}", event.name)),
            was_true: false,
            is_asked: false,
            due: None,
            times: 0,
            begun: None,
            ended: None,
        };
        let (people, map) = (RoadPeople::new(&scenario.events, drive.map()), drive.map());
        let names_signal = scenario.events.iter().any(ScriptedEvent::names_signal);
        Self {
            runs: scenario.events.iter().map(run).collect(),
            vehicles: EventVehicles::new(drive),
            looks_at: scenario.events.iter().flat_map(|event| event.trigger.inputs()).collect(),
            given: Vec::new(),
            has_names: drive.is_open() && scenario.events.iter().any(has_name),
            names: BTreeMap::new(),
            asked: BTreeSet::new(),
            users: RoadUsers::new(&scenario.road_users, people.next_id(), map),
            people,
            questions: Questions::default(),
            lines: if names_signal { stop_lines(map) } else { Vec::new() },
            ends_drive: false,
            step_s: scenario.step_s,
            logged: drive.logged().map_or(0, |logged| logged.log.vehicles().len() as u32),
            before: None,
            weather: Weather {
                visibility_km: scenario.display.visibility_km,
                rain_mmph: scenario.rain_mmph,
                time_h: scenario.display.time_h,
            },
            change: None,
            events: (0..scenario.events.len()).map(|k| record_of(k, None, Tick(0), EventStage::Armed)).collect(),
            order_to_automation: None,
        }
    }

    /// Begins and ends events where a step begins, and moves vehicles in that step.
    pub fn step(&mut self, seen: &ScriptView, traffic: &mut TrafficCoupling) {
        if self.runs.is_empty() && self.users.are_none() {
            return;
        }
        self.learn_names(seen.view, traffic);
        let now = seen.view.tick;
        // Again as long as an event begins, as others may wait for its begin, wherever they stand in the file.
        let mut is_settled = false;
        while !is_settled {
            is_settled = true;
            for k in 0..self.runs.len() {
                is_settled &= !self.look_at(k, (seen, traffic));
            }
        }
        for (event, id, why) in self.vehicles.step(seen, (&mut self.users, traffic)) {
            self.note(event, Some(id), now, EventStage::NotDone(why));
        }
        let (runs, ego) = (&self.runs, seen.view.ego.position.truncate());
        self.people.leave(now, ego, &seen.map.route, &|event| runs[event].can_repeat());
        self.vehicles.yield_to((&self.people, &self.users), seen, self.logged);
        for k in 0..self.runs.len() {
            let is_moving = self.vehicles.are_moved_by(k) || self.users.are_moved_by(k);
            let run = &mut self.runs[k];
            // What takes no time is over a step later, after its onset.
            if matches!(run.stage, Stage::Running(begun, until) if until <= now && begun < now) && !is_moving {
                run.ended = Some(now);
                self.note(k, None, now, EventStage::Ended);
                self.arm_again(k, now);
            }
        }
        self.before = Some((seen.view.ego_s_m, seen.view.advice));
        self.given.clear();
    }

    /// Looks at the trigger of an event, and begins it if it is its time. Returns true if it has begun.
    fn look_at(&mut self, k: usize, (seen, traffic): (&ScriptView, &mut TrafficCoupling)) -> bool {
        let now = seen.view.tick;
        let is_true = self.holds(&self.runs[k].event.trigger, seen);
        let run = &mut self.runs[k];
        let comes_true = is_true && !run.was_true;
        run.was_true = is_true;
        let by_hand = std::mem::take(&mut run.is_asked);
        let [holds_s, delay_s] = if by_hand { [0.0; 2] } else { [run.event.holds_s, run.event.delay_s] };
        if !is_true && run.due.is_some_and(|[held, _]| now < held) {
            run.due = None;
        }
        if (by_hand || (comes_true && run.due.is_none())) && run.stage == Stage::Armed {
            run.due = Some([holds_s, holds_s + delay_s].map(|later_s| Tick::at_seconds(now.seconds() + later_s)));
        }
        let is_due = run.due.is_some_and(|[_, due]| due <= now);
        if is_due {
            run.due = None;
            self.begin(k, by_hand, (seen, traffic));
        }
        is_due
    }

    /// Takes the driver's controls of a tick, for triggers on them.
    pub fn watch(&mut self, controls: &Controls) {
        let given = self.looks_at.iter().filter(|input| input.is_given(controls));
        self.given.extend(given);
    }

    /// Returns the motions of vehicles in the step that begins, by ascending id.
    pub fn motions(&self) -> &[LaneMotion] {
        self.vehicles.motions()
    }

    /// Takes the order to the automation in the tick that begins.
    pub fn take_order_to_automation(&mut self) -> Option<AutomationOrder> {
        self.order_to_automation.take()
    }

    /// Checks whether an event has ended the drive.
    pub fn ends_drive(&self) -> bool {
        self.ends_drive
    }

    /// Takes what is recorded in the tick that begins.
    pub fn take_events(&mut self) -> impl Iterator<Item = Event> {
        self.events.drain(..)
    }

    /// Returns the effects of the events that are under way in the step that begins.
    pub fn effects(&self, now: Tick) -> EffectsOfEvents {
        let weather = self.change.as_ref().map(|change| change.at(now));
        let mut shown = EffectsOfEvents { weather, ..EffectsOfEvents::default() };
        shown.disturbance.water_mm = shown.weather.map(|weather| water_mm(weather.rain_mmph));
        for run in &self.runs {
            let Stage::Running(begun, _) = run.stage else { continue };
            let onset = onset_of(begun);
            let is_on = |for_s: f64| now < Tick::at_seconds(begun.seconds() + for_s);
            for action in &run.event.actions {
                let car = &mut shown.disturbance;
                match action {
                    Action::Message { text, for_s } if is_on(*for_s) => shown.message = Some(text.as_str().into()),
                    Action::Pictogram { sign, for_s } if is_on(*for_s) => shown.stimuli.pictogram = Some(*sign),
                    Action::Sound { tone, for_s } if is_on(*for_s) => shown.stimuli.tones.push((*tone, onset)),
                    Action::Speak { text } if now == begun => {
                        shown.stimuli.sentence = Some((text.as_str().into(), onset))
                    }
                    Action::WheelPulse { strength, for_s } if is_on(*for_s) => {
                        shown.stimuli.wheel_pulse = shown.stimuli.wheel_pulse.max(*strength);
                    }
                    Action::HideAdvice { for_s } if is_on(*for_s) => shown.hides_advice = true,
                    Action::PowerLoss { for_s } if is_on(*for_s) => car.is_powerless = true,
                    Action::Friction { share, for_s } if is_on(*for_s) => car.friction *= share,
                    Action::SideWind { from, wind_mps, for_s } if is_on(*for_s) => {
                        car.side_wind_mps += if *from == Side::Right { *wind_mps } else { -wind_mps };
                    }
                    _ => {}
                }
            }
        }
        shown
    }

    /// Brings the signal of a stop line to the first phase of its program that shows this light there.
    fn show_light(
        &self,
        line: &StopLine,
        light: EventLight,
        seen: &ScriptView,
        traffic: &mut TrafficCoupling,
    ) -> Result<f64, NotDone> {
        let signal = &seen.map.network.signals()[line.signal.index()];
        let phases = signal.programs.first().map_or(&[][..], |program| &program.phases);
        let shows = |phase: &SignalPhase| phase.light(line.link).is_some_and(|shown| light.is(shown));
        let phase = phases.iter().position(shows).ok_or(NotDone::NoPhase)?;
        let order = TrafficOrder::Phase { signal: line.signal, phase: phase as u32 };
        traffic.order(&order).map(|_| 0.0).map_err(|_| NotDone::Refused)
    }

    /// Returns the vehicle of this name.
    pub(super) fn vehicle(&self, name: &str, seen: &ScriptView) -> Option<VehicleId> {
        if PLACES.contains(&name) {
            return seen.neighbour(name);
        }
        if let Some(user) = self.users.named(name) {
            return Some(user.id);
        }
        match name.parse() {
            Ok(number) => seen.view.vehicle(VehicleId(number)).map(|car| car.id),
            Err(_) => self.names.get(name).copied().filter(|id| seen.view.vehicle(*id).is_some()),
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

    /// Begins an event whose trigger has come true, or which the experimenter begins by hand, then without a draw.
    fn begin(&mut self, k: usize, by_hand: bool, (seen, traffic): (&ScriptView, &mut TrafficCoupling)) {
        let now = seen.view.tick;
        let run = &mut self.runs[k];
        let event = run.event.clone();
        if !by_hand && run.chance.uniform(0.0, 1.0) >= event.probability {
            self.note(k, None, now, EventStage::NotDone(NotDone::ByChance));
            self.arm_again(k, now);
            return;
        }
        (run.begun, run.ended) = (Some(now), None);
        run.times += 1;
        // What waits for the begin of an event begins again with it.
        for other in &mut self.runs {
            other.was_true &= !other.event.trigger.waits_for_begin_of(&event.name);
        }
        self.note(k, None, now, if by_hand { EventStage::TriggeredByHand } else { EventStage::Triggered });
        let mut until = now;
        for (n, action) in event.actions.iter().enumerate() {
            let id = action.vehicle().map(|name| self.vehicle(name, seen));
            let person = self.people.begin((k, n), now);
            let begun = match id {
                Some(None) => Err(NotDone::NoVehicle),
                Some(Some(id)) if self.users.has(id) => {
                    self.vehicles.begin_on_user(k, action, id, (seen, &mut self.users)).map(|()| 0.0)
                }
                Some(Some(id)) if (seen.agents)(id) || id.0 <= self.logged => Err(NotDone::OwnDriver),
                Some(Some(id)) if self.vehicles.moves(id) => Err(NotDone::OtherEvent),
                Some(id) => self.act(k, action, id, (seen, traffic)),
                None => person.map_or_else(|| self.act(k, action, None, (seen, traffic)), |(_, lasts_s)| Ok(lasts_s)),
            };
            let id = id.flatten().or(person.map(|(id, _)| id));
            match begun {
                Ok(lasts_s) => {
                    until = until.max(Tick::at_seconds(now.seconds() + lasts_s));
                    self.note(k, id, onset_of(now), EventStage::Onset);
                }
                Err(why) => self.note(k, id, now, EventStage::NotDone(why)),
            }
        }
        self.runs[k].stage = Stage::Running(now, until);
    }

    /// Begins an action. Returns its duration, s, without that of a vehicle's movement.
    fn act(
        &mut self,
        event: usize,
        action: &Action,
        id: Option<VehicleId>,
        (seen, traffic): (&ScriptView, &mut TrafficCoupling),
    ) -> Result<f64, NotDone> {
        if let Some(id) = id {
            return self.vehicles.begin(event, action, id, (seen, traffic));
        }
        match action {
            Action::SignalAhead { light } => {
                let (_, line) = seen.signal_ahead().ok_or(NotDone::NoSignal)?;
                self.show_light(line, *light, seen, traffic)
            }
            Action::Signal { name, light } => {
                let line = self.line_of(name, seen).ok_or(NotDone::NoSignal)?;
                self.show_light(line, *light, seen, traffic)
            }
            Action::EndDrive => {
                self.ends_drive = true;
                Ok(0.0)
            }
            Action::Weather { visibility_km, rain_mmph, time_h, over_s } => {
                let now = seen.view.tick;
                let from = self.change.as_ref().map_or(self.weather, |change| change.at(now));
                let to = Weather {
                    visibility_km: visibility_km.unwrap_or(from.visibility_km),
                    rain_mmph: rain_mmph.unwrap_or(from.rain_mmph),
                    time_h: time_h.unwrap_or(from.time_h),
                };
                self.change = Some(WeatherChange { from, to, begun: now, over_s: *over_s });
                Ok(*over_s)
            }
            Action::TakeoverRequest { .. } | Action::Automation(_) => {
                let run = seen.participant.and_then(|participant| participant.automation.as_ref());
                let order = AutomationOrder::of(action).ok_or(NotDone::Refused)?;
                run.ok_or(NotDone::AutomationOff)?.takes(order)?;
                self.order_to_automation = Some(order);
                Ok(0.0)
            }
            Action::Ask(ask) => {
                self.questions.ask(event, ask);
                Ok(ask.for_s)
            }
            Action::Message { for_s, .. }
            | Action::Pictogram { for_s, .. }
            | Action::Sound { for_s, .. }
            | Action::WheelPulse { for_s, .. }
            | Action::HideAdvice { for_s }
            | Action::PowerLoss { for_s }
            | Action::SideWind { for_s, .. }
            | Action::Friction { for_s, .. } => Ok(*for_s),
            _ => Ok(0.0),
        }
    }

    /// Switches the hazard lights of vehicles on that have broken down.
    pub fn switch_hazard_lights(&self, cars: &mut [VehicleSnapshot]) {
        self.vehicles.switch_hazard_lights(cars);
    }

    /// Returns the names of all events with what they are at.
    pub fn states(&self) -> impl ExactSizeIterator<Item = (&str, ScriptedState)> {
        self.runs.iter().map(|run| {
            let state = match run.stage {
                Stage::Armed if run.is_asked => ScriptedState::Running,
                Stage::Armed => ScriptedState::Armed,
                Stage::Running(..) => ScriptedState::Running,
                Stage::Over => ScriptedState::Over,
            };
            (run.event.name.as_str(), state)
        })
    }

    /// Asks for an event that is armed, so that it begins where the next step begins.
    pub fn ask(&mut self, event: usize) {
        if let Some(run) = self.runs.get_mut(event).filter(|run| run.stage == Stage::Armed) {
            run.is_asked = true;
        }
    }

    /// Arms an event that is over again if it repeats.
    fn arm_again(&mut self, event: usize, now: Tick) {
        let run = &mut self.runs[event];
        run.stage = if run.can_repeat() { Stage::Armed } else { Stage::Over };
        if run.stage == Stage::Armed {
            self.note(event, None, now, EventStage::Armed);
        }
    }

    fn note(&mut self, event: usize, vehicle: Option<VehicleId>, tick: Tick, stage: EventStage) {
        self.events.push(record_of(event, vehicle, tick, stage));
    }
}

/// Returns the first tick that shows the actions of an event that begins.
fn onset_of(begun: Tick) -> Tick {
    Tick(begun.0 + 1)
}

/// Returns the record of a stage of an event.
fn record_of(event: usize, vehicle: Option<VehicleId>, tick: Tick, stage: EventStage) -> Event {
    Event { tick, kind: EventKind::Scripted { event: event as u16, vehicle, stage } }
}
