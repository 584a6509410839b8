//! Automation of the participant's vehicle. In: the participant's controls and what the vehicle perceives, once a tick; orders of events. Out: the
//! controls that move the vehicle, its [`AutomationState`], and events.
//!
//! The system drives through the same pedals and wheel as people. Everything follows from ticks and the participant's recorded controls, so that a
//! replay repeats it. [`override_by_hand`] tells a turn of the wheel by the participant from one that the wheel makes by itself.

mod override_by_hand;
#[cfg(test)]
mod tests;

use super::{Event, EventKind, event::NotDone};
use crate::{
    controls::{Controls, Selector},
    driver::{AutomatedDriver, DriverError, Perception, SimulatedDriver, SpeedGoal},
    ego::CarParams,
    metrics::{AutomationChange, SwitchedOffBy, SwitchedOnBy, TakeoverInput},
    scenario::{
        Automation, AutomationSystem,
        scripted_event::{Action, AutomationSwitch},
    },
    snapshot::{AutomationMode, AutomationState, TIME_GAPS_S},
    time::Tick,
};
use override_by_hand::WheelTurns;

/// Pedal from which it counts as pressed.
const PRESSED: f32 = 0.05;
/// Highest speed of the traffic-jam pilot, m/s: 60 km/h, as in the first version of UN Regulation 157 (docs/references.md: automation).
const JAM_MPS: f64 = 60.0 / 3.6;
/// Time in which the steering wheel goes over from the system's angle to the participant's when the system is switched off, s.
const RELEASE_S: f64 = 1.0;
/// Turn of the steering wheel since a takeover request that counts as hands on it, rad: 2 degrees (docs/references.md: automation).
const HANDS_ON_RAD: f32 = 2.0 * std::f32::consts::PI / 180.0;
/// Share of the lead time of a takeover request after which it becomes urgent.
const URGENT_SHARE: f64 = 0.5;

/// Order of an event to the automation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum AutomationOrder {
    On,
    Off,
    Fail,
    /// Ask the participant to take over within this time, s.
    Request(f64),
}

impl AutomationOrder {
    /// Returns the order of an event's action; `None` for an action on anything else.
    pub fn of(action: &Action) -> Option<Self> {
        match action {
            Action::TakeoverRequest { lead_s } => Some(Self::Request(*lead_s)),
            Action::Automation(AutomationSwitch::On) => Some(Self::On),
            Action::Automation(AutomationSwitch::Off) => Some(Self::Off),
            Action::Automation(AutomationSwitch::Fails) => Some(Self::Fail),
            _ => None,
        }
    }
}

/// Takeover request in progress.
#[derive(Clone, Debug)]
struct Request {
    since: Tick,
    lead_s: f64,
    /// Participant's wheel at the request, rad.
    wheel_rad: f32,
    /// Controls that the participant has moved.
    inputs: Vec<TakeoverInput>,
}

/// Automation of a drive from its first tick on.
#[derive(Clone, Debug)]
pub(super) struct AutomationRun {
    settings: Automation,
    driver: AutomatedDriver,
    /// Time gap to the vehicle ahead, s.
    time_gap_s: f64,
    mode: AutomationMode,
    has_failed: bool,
    /// True if the system could have been switched on in the last tick.
    is_ready: bool,
    order: Option<AutomationOrder>,
    request: Option<Request>,
    turns: WheelTurns,
    /// Tick at which the system was switched off, and the angle by which its wheel differed from the participant's, rad.
    released: Option<(Tick, f32)>,
    /// True once the hands were light while the system is on: those that held the wheel in a bend when it was switched on do not switch it off.
    have_hands_been_light: bool,
    /// True once the brake was up while the system is on: a foot that holds the vehicle before the drive begins does not switch it off.
    has_brake_been_up: bool,
    /// Controls that moved the vehicle in the last tick.
    driven: Controls,
}

impl AutomationRun {
    /// Returns the automation of a drive; `None` if it has none.
    pub fn new(settings: &Automation, car: &CarParams) -> Result<Option<Self>, DriverError> {
        if settings.system == AutomationSystem::None {
            return Ok(None);
        }
        Ok(Some(Self {
            settings: *settings,
            driver: AutomatedDriver::new(car)?,
            time_gap_s: settings.time_gap_s,
            mode: if settings.starts_on { AutomationMode::On } else { AutomationMode::Off },
            has_failed: false,
            is_ready: true,
            order: None,
            request: None,
            turns: WheelTurns::default(),
            released: None,
            have_hands_been_light: false,
            has_brake_been_up: false,
            driven: Controls::default(),
        }))
    }

    /// Returns the driver through whose eyes the vehicle sees.
    pub fn eyes(&self) -> &SimulatedDriver {
        self.driver.eyes()
    }

    /// Returns true while the policy's advice is not shown, as the system drives by it.
    pub fn hides_advice(&self) -> bool {
        self.settings.system == AutomationSystem::Policy && self.mode.drives()
    }

    /// Checks whether the automation can carry an order out, by the last tick.
    ///
    /// # Errors
    /// The reason why it cannot.
    pub fn takes(&self, order: AutomationOrder) -> Result<(), NotDone> {
        match order {
            AutomationOrder::Request(_) if self.mode != AutomationMode::On => Err(NotDone::AutomationOff),
            AutomationOrder::Off if !self.mode.drives() => Err(NotDone::AutomationOff),
            AutomationOrder::On if self.mode.drives() || !self.is_ready => Err(NotDone::AutomationNotReady),
            _ => Ok(()),
        }
    }

    /// Gives the automation an order, which it carries out in the next tick.
    pub fn order(&mut self, order: AutomationOrder) {
        self.order = Some(order);
    }

    /// Returns the state to show.
    pub fn state(&self, tick: Tick) -> AutomationState {
        let system = self.settings.system;
        let is_late = |request: &Request| tick.seconds() - request.since.seconds() >= URGENT_SHARE * request.lead_s;
        let is_urgent = self.mode.asks() && self.request.as_ref().is_none_or(is_late);
        let moves = self.mode.drives() || self.released.is_some();
        AutomationState {
            mode: self.mode,
            keeps_speed: system.keeps_speed(),
            steers: system.steers(),
            is_urgent,
            time_gap_s: system.keeps_time_gap().then_some(self.time_gap_s),
            driven: moves.then_some(self.driven),
        }
    }

    /// Advances to a tick with the participant's controls and what the vehicle perceives. Returns the controls that move the vehicle.
    pub fn tick(&mut self, tick: Tick, given: &Controls, now: &Perception, events: &mut Vec<Event>) -> Controls {
        let given = given.sane();
        let mut note = |change| events.push(Event { tick, kind: EventKind::Automation(change) });
        if tick == Tick(1) && self.settings.starts_on {
            note(AutomationChange::On(SwitchedOnBy::Start));
        }
        self.turns.add(given.steering_wheel_rad, self.driven.steering_wheel_rad);
        if given.gap_button && self.settings.system.keeps_time_gap() {
            self.time_gap_s = time_gap_after(self.time_gap_s);
            note(AutomationChange::TimeGap { time_gap_s: self.time_gap_s });
        }
        self.has_brake_been_up |= given.brake < PRESSED;
        self.have_hands_been_light |= !has_torque(&given, self.settings.override_nm);
        let order = self.order.take();
        if order == Some(AutomationOrder::Fail) {
            self.has_failed = true;
        }
        self.is_ready = self.can_start(&given, now.speed_mps);
        match self.mode {
            AutomationMode::None => {}
            AutomationMode::Off => {
                let by = match (given.automation_button, order) {
                    (true, _) => Some(SwitchedOnBy::Button),
                    (_, Some(AutomationOrder::On)) => Some(SwitchedOnBy::Event),
                    _ => None,
                };
                if let Some(by) = by.filter(|_| self.is_ready) {
                    self.switch_on(&given, by, &mut note);
                }
            }
            AutomationMode::On | AutomationMode::TakeoverRequest | AutomationMode::MinimalRisk => {
                self.note_inputs(&given, &mut note);
                let by_order = match order {
                    Some(AutomationOrder::Off) => Some(SwitchedOffBy::Event),
                    Some(AutomationOrder::Fail) => Some(SwitchedOffBy::Failure),
                    _ => None,
                };
                if let Some(by) = by_order.or_else(|| self.taken_over_by(&given)) {
                    self.switch_off(tick, &given, by, &mut note);
                } else if let (Some(AutomationOrder::Request(lead_s)), AutomationMode::On) = (order, self.mode) {
                    self.mode = AutomationMode::TakeoverRequest;
                    let wheel_rad = given.steering_wheel_rad;
                    self.request = Some(Request { since: tick, lead_s, wheel_rad, inputs: Vec::new() });
                    note(AutomationChange::Request { lead_s });
                } else if self.is_out_of_time(tick) {
                    // A level below 3 leaves the fallback to the participant.
                    if self.settings.system.level() < 3 {
                        self.switch_off(tick, &given, SwitchedOffBy::NoTakeover, &mut note);
                    } else {
                        self.mode = AutomationMode::MinimalRisk;
                        note(AutomationChange::MinimalRisk);
                    }
                }
            }
        }
        self.driven = if self.mode.drives() { self.drive(&given, now) } else { self.release(tick, &given) };
        self.driven
    }

    fn can_start(&self, given: &Controls, speed_mps: f64) -> bool {
        let is_slow_enough = self.settings.system != AutomationSystem::TrafficJamPilot || speed_mps <= JAM_MPS;
        let is_ready =
            given.selector == Selector::Drive && (given.brake < PRESSED || !self.settings.system.keeps_speed());
        !self.has_failed && is_slow_enough && is_ready
    }

    fn switch_on(&mut self, given: &Controls, by: SwitchedOnBy, note: &mut impl FnMut(AutomationChange)) {
        let now = if self.released.take().is_some() { self.driven } else { *given };
        self.driver = self.driver.from_controls(&now);
        self.driven = now;
        self.mode = AutomationMode::On;
        self.have_hands_been_light = false;
        self.turns = WheelTurns::default();
        note(AutomationChange::On(by));
    }

    fn switch_off(&mut self, tick: Tick, given: &Controls, by: SwitchedOffBy, note: &mut impl FnMut(AutomationChange)) {
        if self.settings.system.steers() {
            self.released = Some((tick, self.driven.steering_wheel_rad - given.steering_wheel_rad));
        }
        (self.mode, self.request) = (AutomationMode::Off, None);
        note(AutomationChange::Off(by));
    }

    /// Returns the control by which the participant takes over.
    fn taken_over_by(&self, given: &Controls) -> Option<SwitchedOffBy> {
        let system = self.settings.system;
        let heeds_brake = system.keeps_speed() || self.mode.asks();
        let is_braked = given.brake >= PRESSED && self.has_brake_been_up && heeds_brake;
        let has_force = given.hand_torque_nm.is_some();
        let is_turned = || self.turns.is_by_hand(self.settings.override_deg.to_radians());
        // A wheel with a motor may lag behind a quick turn of the system's: only hands with a torque turn it.
        let is_turned_by_hand = || is_turned() && (!has_force || has_torque(given, self.settings.hands_on_nm));
        let is_forced = || self.have_hands_been_light && has_torque(given, self.settings.override_nm);
        match given {
            _ if given.automation_button => Some(SwitchedOffBy::Button),
            _ if is_braked => Some(SwitchedOffBy::Brake),
            // Otherwise the accelerator drives faster than the system while it is pressed.
            _ if given.throttle >= PRESSED && system.keeps_speed() && self.mode.asks() => {
                Some(SwitchedOffBy::Accelerator)
            }
            _ if system.steers() && (is_forced() || is_turned_by_hand()) => Some(SwitchedOffBy::Wheel),
            _ => None,
        }
    }

    /// Notes each control that the participant moves for the first time since a takeover request.
    fn note_inputs(&mut self, given: &Controls, note: &mut impl FnMut(AutomationChange)) {
        let are_hands_on = has_torque(given, self.settings.hands_on_nm);
        let Some(request) = &mut self.request else { return };
        let is_turned = match self.settings.system.steers() {
            true => self.turns.is_by_hand(HANDS_ON_RAD.into()),
            false => (given.steering_wheel_rad - request.wheel_rad).abs() >= HANDS_ON_RAD,
        };
        let is_by_hand = is_turned && (are_hands_on || given.hand_torque_nm.is_none());
        let moved = [
            (TakeoverInput::Button, given.automation_button),
            (TakeoverInput::Brake, given.brake >= PRESSED),
            (TakeoverInput::Accelerator, given.throttle >= PRESSED),
            (TakeoverInput::Wheel, is_by_hand),
            (TakeoverInput::Hands, are_hands_on),
        ];
        for (input, _) in moved.iter().filter(|(_, is_moved)| *is_moved) {
            if !request.inputs.contains(input) {
                request.inputs.push(*input);
                note(AutomationChange::Input(*input));
            }
        }
    }

    fn is_out_of_time(&self, tick: Tick) -> bool {
        let is_over = |request: &Request| tick >= Tick::at_seconds(request.since.seconds() + request.lead_s);
        self.mode == AutomationMode::TakeoverRequest && self.request.as_ref().is_some_and(is_over)
    }

    /// Returns the controls of the system, and the participant's where it leaves them a control.
    fn drive(&mut self, given: &Controls, now: &Perception) -> Controls {
        let Automation { system, set_speed_mps, minimal_risk_mps2, .. } = self.settings;
        let limit_mps = now.speed_limit_mps.min(now.lane.next_limit_speed_mps);
        let set_mps = match (set_speed_mps, system) {
            (set_mps, AutomationSystem::TrafficJamPilot) if set_mps <= 0.0 => limit_mps.min(JAM_MPS),
            (set_mps, _) if set_mps <= 0.0 => limit_mps,
            (set_mps, AutomationSystem::TrafficJamPilot) => set_mps.min(JAM_MPS),
            (set_mps, _) => set_mps,
        };
        let level = system.level();
        let goal = match (self.mode, system) {
            (AutomationMode::MinimalRisk, _) => SpeedGoal::Brake(minimal_risk_mps2),
            (_, AutomationSystem::Policy) => SpeedGoal::Advice,
            _ => SpeedGoal::Cruise {
                set_mps,
                time_gap_s: self.time_gap_s,
                heeds_bends: level >= 2,
                heeds_all: level >= 3,
            },
        };
        let own = self.driver.controls(now, goal);
        let mut driven = *given;
        if system.keeps_speed() {
            (driven.throttle, driven.brake) = (own.throttle, own.brake);
            if given.throttle >= PRESSED && given.throttle > own.throttle {
                (driven.throttle, driven.brake) = (given.throttle, 0.0);
            }
            if !self.has_brake_been_up {
                (driven.throttle, driven.brake) = (0.0, own.brake.max(given.brake));
            }
        }
        if system.steers() {
            driven.steering_wheel_rad = own.steering_wheel_rad;
        }
        if level >= 3 {
            driven.indicator = own.indicator;
        }
        driven
    }

    /// Returns the participant's controls; after the system was switched off, the steering wheel goes over from the system's angle.
    fn release(&mut self, tick: Tick, given: &Controls) -> Controls {
        let Some((since, offset_rad)) = self.released else { return *given };
        let left = 1.0 - ((tick.seconds() - since.seconds()) / RELEASE_S) as f32;
        if left <= 0.0 {
            self.released = None;
            return *given;
        }
        Controls { steering_wheel_rad: given.steering_wheel_rad + left * offset_rad, ..*given }
    }
}

/// Returns true if the hands give the wheel this torque, N m. Without force feedback their torque is unknown.
fn has_torque(given: &Controls, least_nm: f64) -> bool {
    given.hand_torque_nm.is_some_and(|torque_nm| f64::from(torque_nm).abs() >= least_nm)
}

/// Returns the next longer setting of the time gap, or the shortest one after the longest, s.
fn time_gap_after(time_gap_s: f64) -> f64 {
    TIME_GAPS_S.into_iter().find(|setting_s| *setting_s > time_gap_s).unwrap_or(TIME_GAPS_S[0])
}
