//! Triggers of a scenario for the conditions of OpenSCENARIO. In: [`conditions`](super::conditions), and the names of the events that stand for parts of
//! the storyboard. Out: triggers; conditions that cannot come true are reported. Seconds, metres, m/s.

use super::{
    casting::{Role, rounded},
    conditions::{
        Ahead, Condition, Demand, EntityDemand, Part, Rule, STANDING_MPS, State, Trigger as StoryTrigger, ValueRule,
    },
    document::Place,
    fault::OpenScenarioError,
    positions::Placement,
    script::{EventKey, Script},
};
use crate::{
    scenario::scripted_event::{DistanceAhead, EventLight, TimeAhead, Trigger},
    toml_text::did_you_mean,
};

/// Difference of accelerations up to which they are equal, m/s2.
const SAME_MPS2: f64 = 0.001;
/// Distance before the path's end from which a vehicle is at its end, m.
const PATH_END_M: f64 = 0.5;

/// Begin of an event.
#[derive(Clone, Debug)]
pub(super) struct Begin {
    pub trigger: Trigger,
    /// Time for which the trigger has to be true, s.
    pub holds_s: f64,
    /// Delay after it, s.
    pub delay_s: f64,
}

impl Begin {
    /// Returns the begin where a trigger comes true.
    pub fn at(trigger: Trigger) -> Self {
        Self { trigger, holds_s: 0.0, delay_s: 0.0 }
    }
}

/// Returns one of several triggers; `None` without any.
pub(super) fn any(mut list: Vec<Trigger>) -> Option<Trigger> {
    if list.len() > 1 { Some(Trigger::Any(list)) } else { list.pop() }
}

/// Returns all of several triggers together; `None` without any.
fn all(list: Vec<Trigger>) -> Option<Trigger> {
    let parts = |trigger| if let Trigger::All(list) = trigger { list } else { vec![trigger] };
    let mut list: Vec<Trigger> = list.into_iter().flat_map(parts).collect();
    if list.len() > 1 { Some(Trigger::All(list)) } else { list.pop() }
}

/// Returns a trigger at the begin of an event.
pub(super) fn begun(event: &str) -> Trigger {
    Trigger::Begun { event: event.to_owned(), delay_s: 0.0 }
}

impl Script<'_> {
    /// Returns the trigger of an event in an act that has begun by `start`; `None` where it never comes true. Without conditions the event begins with
    /// its act.
    ///
    /// # Errors
    /// A condition names an entity, a place or a part of the storyboard that does not exist.
    pub fn trigger(
        &mut self,
        story: Option<&StoryTrigger>,
        start: &Trigger,
        at: EventKey,
    ) -> Result<Option<Begin>, OpenScenarioError> {
        let Some(story) = story else { return Ok(Some(Begin::at(start.clone()))) };
        let begins_at_once = *start == Trigger::TimeS(0.0);
        let lasts = |condition: &Condition| condition.holds_s() > 0.0;
        if let [group] = story.groups.as_slice()
            && let [condition] = group.as_slice()
            && (begins_at_once || !lasts(condition))
        {
            let Some(found) = self.condition(condition, at, false)? else { return Ok(None) };
            let found = if begins_at_once { Some(found) } else { all(vec![start.clone(), found]) };
            let (holds_s, delay_s) = (condition.holds_s(), condition.delay_s);
            return Ok(found.map(|trigger| Begin { trigger, holds_s, delay_s }));
        }
        let mut groups = Vec::new();
        for group in &story.groups {
            let mut list = Some(if begins_at_once { vec![] } else { vec![start.clone()] });
            for condition in group {
                let found = self.condition(condition, at, group.len() > 1)?;
                let found = found.map(|found| self.lasting(condition, found, at));
                list = list.zip(found).map(|(mut list, found)| {
                    list.push(found);
                    list
                });
            }
            groups.extend(list.and_then(all));
        }
        Ok(any(groups).map(Begin::at))
    }

    /// Returns a trigger that comes true once another one has been true for the condition's duration, and after its delay; a mark among the events keeps
    /// the time.
    fn lasting(&mut self, condition: &Condition, trigger: Trigger, at: EventKey) -> Trigger {
        let Condition { title, delay_s, place, .. } = condition;
        let (holds_s, delay_s) = (condition.holds_s(), *delay_s);
        if holds_s == 0.0 && delay_s == 0.0 {
            return trigger;
        }
        if holds_s > 0.0 {
            self.problems.note(format!(
                "{}:{}: the condition stays true after {holds_s} s, also together with others",
                place.file.display(),
                place.line
            ));
        }
        let repeats = self.event(at).is_some_and(|event| event.most_times > 1);
        let name = self.add_mark(title, Begin { trigger, holds_s, delay_s }, repeats);
        begun(&name)
    }

    /// Returns the trigger of a condition. `is_joined` is true for one of several that have to be true together.
    fn condition(
        &mut self,
        condition: &Condition,
        at: EventKey,
        is_joined: bool,
    ) -> Result<Option<Trigger>, OpenScenarioError> {
        let place = &condition.place;
        match &condition.what {
            Demand::Time(time_s) => Ok(Some(Trigger::TimeS(*time_s))),
            Demand::Signal { name, light } => self.signal(name, *light, (condition, is_joined)),
            Demand::State { part, name, state } => self.state(*part, (name, *state), (place, at)),
            Demand::Parameter { name, declared, rule, value } => {
                Ok(self.parameter((name, declared), (*rule, value), condition))
            }
            Demand::Entity { names, is_all, what } => {
                let mut list = Vec::new();
                for name in names {
                    let found = self.of_entity(name, what, condition)?;
                    if found.is_none() && *is_all {
                        return Ok(None);
                    }
                    list.extend(found);
                }
                Ok(if *is_all { all(list) } else { any(list) })
            }
        }
    }

    fn signal(
        &mut self,
        name: &str,
        light: EventLight,
        (condition, is_joined): (&Condition, bool),
    ) -> Result<Option<Trigger>, OpenScenarioError> {
        let place = &condition.place;
        let on_path = self.path_signal(name, place)?.filter(|(_, lights)| lights.contains(&light));
        let level = on_path.map(|(id, _)| Trigger::Signal { name: id, light });
        // A light that is on from the start does not come on.
        let init = condition.is_rising.then(|| self.init_name());
        let is_setter = |(of, shown, event): &&(String, EventLight, String)| {
            of == name && *shown == light && init.as_ref() != Some(event)
        };
        let setters = self.setters.iter().filter(is_setter);
        let set = any(setters.map(|(_, _, event)| begun(event)).collect());
        match (set, level) {
            // Later it may have changed again.
            (Some(set), Some(level)) if is_joined => Ok(Some(Trigger::All(vec![set, level]))),
            (Some(set), _) => Ok(Some(set)),
            (None, Some(level)) => Ok(Some(level)),
            (None, None) => {
                let meaning = "no action sets the light, and it is not on the path of the ego; it never comes true";
                self.leave_out(place, "TrafficSignalCondition", meaning);
                Ok(None)
            }
        }
    }

    /// Returns the trigger at which a parameter has a value: the begin of an event that sets it so.
    fn parameter(
        &mut self,
        (name, declared): (&str, &str),
        (rule, value): (ValueRule, &str),
        condition: &Condition,
    ) -> Option<Trigger> {
        let init = self.init_name();
        let (at_start, setters): (Vec<_>, Vec<_>) =
            self.parameters.iter().filter(|(of, ..)| of == name).partition(|(.., event)| *event == init);
        let first = at_start.last().map_or(declared, |(_, set, _)| set);
        let is_so_at_start = rule.is_met(first, value) && !condition.is_rising;
        let (met, unmet): (Vec<_>, Vec<_>) = setters.into_iter().partition(|(_, set, _)| rule.is_met(set, value));
        let mut list: Vec<Trigger> = is_so_at_start.then_some(Trigger::TimeS(0.0)).into_iter().collect();
        list.extend(met.iter().map(|(.., event)| begun(event)));
        let (changes_back, place) = (!unmet.is_empty(), &condition.place);
        let found = any(list);
        if found.is_none() {
            let meaning = "no action sets the parameter so; the condition never comes true";
            self.leave_out(place, "ParameterCondition", meaning);
        } else if changes_back {
            let (file, line) = (place.file.display(), place.line);
            self.problems
                .note(format!("{file}:{line}: the condition stays true once an action has set the parameter so"));
        }
        found
    }

    fn state(
        &mut self,
        part: Part,
        (name, state): (&str, State),
        (place, at): (&Place, EventKey),
    ) -> Result<Option<Trigger>, OpenScenarioError> {
        let found = self.parts(part, name);
        if found.is_empty() {
            let known = self.part_names(part);
            let near = did_you_mean(name, &known);
            return Err(place.fault(format!("the storyboard has no part of this kind named \"{name}\"{near}")));
        }
        // Of several of one name the nearest: those of catalogs occur in each group.
        let near = (1..=3).rev().find(|depth| found.iter().any(|(key, _)| key[..*depth] == at[..*depth]));
        let found = found.into_iter().filter(|(key, _)| near.is_none_or(|depth| key[..depth] == at[..depth]));
        let mut list = Vec::new();
        for (key, events) in found {
            let is_whole = matches!(part, Part::Event | Part::Action);
            if part == Part::Action
                && state != State::Begun
                && self.event(key).is_some_and(|event| event.actions.len() > 1)
            {
                let meaning = "codrive knows the end of all actions of an event only; it never comes true";
                self.leave_out(place, "StoryboardElementStateCondition", meaning);
                continue;
            }
            let ended = |event: &String| {
                // A part is over once each of its events has ended for the last time.
                let is_last = !is_whole || state == State::Complete;
                let times = if is_last { self.most_times(event) } else { 1 };
                Trigger::After { event: event.clone(), delay_s: 0.0, times }
            };
            let trigger = match (state, is_whole) {
                (State::Begun, true) => any(events.iter().map(|event| begun(event)).collect()),
                (State::Begun, false) => self.act_start(key[0]),
                (State::Ended | State::Complete, _) => all(events.iter().map(ended).collect()),
            };
            list.extend(trigger);
        }
        Ok(any(list))
    }

    fn of_entity(
        &mut self,
        name: &str,
        what: &EntityDemand,
        condition: &Condition,
    ) -> Result<Option<Trigger>, OpenScenarioError> {
        let place = &condition.place;
        let Some(of) = self.role(name, place)? else { return Ok(None) };
        let vehicle = of.name.clone();
        match what {
            EntityDemand::TimeGap(ahead) => {
                let pair = self.pair(&of, ahead, place)?;
                Ok(pair.map(|pair| Trigger::TimeGap(time_ahead(pair, ahead))))
            }
            EntityDemand::TimeToCollision(ahead) => {
                let pair = self.pair(&of, ahead, place)?;
                Ok(pair.map(|pair| Trigger::TimeToCollision(time_ahead(pair, ahead))))
            }
            EntityDemand::Distance(ahead) => {
                let Some(to) = self.role(&ahead.to, place)? else { return Ok(None) };
                // The distance counts whichever of both is ahead.
                let there = Ahead { to: name.to_owned(), ..ahead.clone() };
                let pairs = [self.pair(&of, ahead, place)?, self.pair(&to, &there, place)?];
                Ok(any(pairs.into_iter().flatten().map(|pair| distance_ahead(pair, ahead)).collect()))
            }
            EntityDemand::Near { at, below_m, is_from_front } => {
                let reach_m = if *is_from_front { below_m + of.entity.front_m() } else { *below_m };
                self.reaches(&of, at, reach_m)
            }
            EntityDemand::Reach(at, tolerance_m) => self.reaches(&of, at, *tolerance_m),
            EntityDemand::Driven(above_m) => Ok(Some(Trigger::Driven { vehicle, above_m: *above_m })),
            EntityDemand::Speed(limit_mps, rule) => {
                let is_above = *rule == Rule::Above;
                let [above_mps, below_mps] = [is_above, !is_above].map(|is_side| is_side.then_some(*limit_mps));
                Ok(Some(Trigger::Speed { vehicle, than: None, above_mps, below_mps }))
            }
            EntityDemand::RelativeSpeed(to, limit_mps, rule) => {
                let Some(other) = self.role(to, place)? else { return Ok(None) };
                let than = Some(other.name.clone());
                let is_above = *rule == Rule::Above;
                let [above_mps, below_mps] = [is_above, !is_above].map(|is_side| is_side.then_some(*limit_mps));
                Ok(Some(Trigger::Speed { vehicle, than, above_mps, below_mps }))
            }
            EntityDemand::Acceleration(limit_mps2, rule) => {
                let limited = |above_mps2: Option<f64>, below_mps2: Option<f64>| Trigger::Acceleration {
                    vehicle: vehicle.clone(),
                    above_mps2,
                    below_mps2,
                };
                let [low_mps2, high_mps2] = [-SAME_MPS2, SAME_MPS2].map(|by| Some(limit_mps2 + by));
                Ok(match rule {
                    Some(Rule::Above) => Some(limited(Some(*limit_mps2), None)),
                    Some(Rule::Below) => Some(limited(None, Some(*limit_mps2))),
                    None => {
                        let mut parts = vec![limited(low_mps2, None), limited(None, high_mps2)];
                        if condition.is_rising {
                            // It was another one before.
                            let other = Trigger::Any(vec![limited(None, low_mps2), limited(high_mps2, None)]);
                            parts.insert(0, begun(&self.add_mark(&condition.title, Begin::at(other), false)));
                        }
                        all(parts)
                    }
                })
            }
            EntityDemand::Standstill(_) => Ok(Some(stands(vehicle))),
            EntityDemand::OffRoad(_) => {
                let beyond_m = self.scene.beyond_lanes_m(name);
                Ok(Some(Trigger::OffRoad { vehicle, beyond_m: rounded(beyond_m) }))
            }
            EntityDemand::RoadEnd(_) => {
                let length_m = self.scene.map.route.length_m();
                let place_m = if of.place.is_against { PATH_END_M } else { length_m - PATH_END_M };
                // Its reference point reaches the end, where it stops, later than its front.
                Ok(all(vec![Trigger::Reaches { vehicle: vehicle.clone(), place_m }, stands(vehicle)]))
            }
        }
    }

    /// Returns the trigger at which the reference point of a vehicle is within a distance of a place.
    fn reaches(&mut self, of: &Role, at: &Placement, reach_m: f64) -> Result<Option<Trigger>, OpenScenarioError> {
        let spot = self.scene.spot(at)?;
        let length_m = self.scene.map.route.length_m();
        let sign = if of.place.is_against { -1.0 } else { 1.0 };
        let place = self.scene.place(&spot).map(|place| of.front_at_m(place.s_m - sign * reach_m));
        match place.filter(|place_m| (-reach_m..length_m).contains(place_m)) {
            Some(place_m) => {
                Ok(Some(Trigger::Reaches { vehicle: of.name.clone(), place_m: rounded(place_m.max(0.0)) }))
            }
            None => {
                self.leave_out(&at.place, "Position", "the place is not on the path of the ego; it is never reached");
                Ok(None)
            }
        }
    }

    /// Returns the names of a vehicle and of one ahead of it, and the length that the distance from bumper to bumper lacks.
    fn pair(
        &mut self,
        of: &Role,
        ahead: &Ahead,
        place: &Place,
    ) -> Result<Option<(String, String, f64)>, OpenScenarioError> {
        let Some(to) = self.role(&ahead.to, place)? else { return Ok(None) };
        if to.name == of.name {
            return Err(place.fault(format!("the distance of \"{}\" to itself; allowed: to another entity", ahead.to)));
        }
        let is_same_way = of.place.is_against == to.place.is_against;
        let near_end_m = if is_same_way { to.entity.rear_m() } else { to.entity.front_m() };
        let plus_m = if ahead.is_freespace { 0.0 } else { of.entity.front_m() + near_end_m };
        Ok(Some((of.name.clone(), to.name.clone(), rounded(plus_m))))
    }
}

/// Returns the trigger at which a vehicle stands.
fn stands(vehicle: String) -> Trigger {
    Trigger::Speed { vehicle, than: None, above_mps: None, below_mps: Some(STANDING_MPS) }
}

/// Returns a value on the side of its limit: below and above.
fn sides(ahead: &Ahead) -> [Option<f64>; 2] {
    [Rule::Below, Rule::Above].map(|side| (ahead.rule == side).then_some(ahead.limit))
}

fn time_ahead((of, to, plus_m): (String, String, f64), ahead: &Ahead) -> TimeAhead {
    let [below_s, above_s] = sides(ahead);
    TimeAhead { of, to, below_s, above_s, plus_m }
}

fn distance_ahead((of, to, plus_m): (String, String, f64), ahead: &Ahead) -> Trigger {
    let [below_m, above_m] = sides(ahead);
    Trigger::Distance(DistanceAhead { of, to, below_m, above_m, plus_m })
}
