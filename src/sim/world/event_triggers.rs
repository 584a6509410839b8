//! Triggers of a scenario's events. In: a trigger, and the view of the drive where a step begins. Out: whether it is true. Metres, m/s, seconds.

use super::{
    event_script::EventScript,
    event_view::{OnRoute, ScriptView},
};
use crate::{
    map::StopLine,
    policy::Advice,
    scenario::scripted_event::{EGO_NAME, Trigger},
    time::{TICK_S, Tick},
};

impl EventScript {
    /// Checks whether a trigger is true where a step begins.
    pub(super) fn holds(&self, trigger: &Trigger, seen: &ScriptView) -> bool {
        let (view, now_s) = (seen.view, seen.view.tick.seconds());
        let speed_mps = view.ego.speed_mps;
        let is_past = |tick: Option<Tick>, delay_s: f64| {
            tick.is_some_and(|tick| now_s + TICK_S / 2.0 >= tick.seconds() + delay_s)
        };
        let run_of = |event: &String| self.runs.iter().find(|run| run.event.name == *event);
        match trigger {
            Trigger::TimeS(time_s) => now_s + TICK_S / 2.0 >= *time_s,
            Trigger::PlaceM(place_m) => self.reaches(*place_m, seen),
            Trigger::SpeedAboveMps(above_mps) => speed_mps > *above_mps,
            Trigger::SpeedBelowMps(below_mps) => speed_mps < *below_mps,
            Trigger::Distance(ahead) => {
                self.distance(&ahead.of, &ahead.to, ahead.plus_m, seen).is_some_and(|[gap_m, ..]| ahead.is_met(gap_m))
            }
            Trigger::TimeGap(ahead) => self
                .distance(&ahead.of, &ahead.to, ahead.plus_m, seen)
                .is_some_and(|[gap_m, own_mps, _]| own_mps > 0.0 && ahead.is_met(gap_m, own_mps)),
            Trigger::TimeToCollision(ahead) => self
                .distance(&ahead.of, &ahead.to, ahead.plus_m, seen)
                .is_some_and(|[gap_m, _, closing_mps]| closing_mps > 0.0 && ahead.is_met(gap_m, closing_mps)),
            Trigger::Reaches { vehicle, place_m } => self.on_route(vehicle, seen).is_some_and(|at| {
                // At the step that is nearest, before or after.
                let soon_m = at.along_mps * self.step_s / 2.0;
                if soon_m < 0.0 { at.extent_m[0] + soon_m <= *place_m } else { at.extent_m[1] + soon_m >= *place_m }
            }),
            Trigger::Speed { vehicle, than, above_mps, below_mps } => {
                let speed_mps = |name: &str| self.on_route(name, seen).map(|at| at.speed_mps);
                let other_mps = than.as_ref().map_or(Some(0.0), |than| speed_mps(than));
                speed_mps(vehicle).zip(other_mps).is_some_and(|(own_mps, other_mps)| {
                    let more_mps = own_mps - other_mps;
                    above_mps.is_none_or(|above| more_mps > above) && below_mps.is_none_or(|below| more_mps < below)
                })
            }
            Trigger::Acceleration { vehicle, above_mps2, below_mps2 } => {
                self.on_route(vehicle, seen).is_some_and(|at| {
                    above_mps2.is_none_or(|above| at.accel_mps2 > above)
                        && below_mps2.is_none_or(|below| at.accel_mps2 < below)
                })
            }
            Trigger::OffRoad { vehicle, beyond_m } => self
                .on_route(vehicle, seen)
                .is_some_and(|at| seen.map.network.lane_under(at.point, *beyond_m, None).is_none()),
            Trigger::Driven { vehicle, above_m } => {
                self.on_route(vehicle, seen).is_some_and(|at| at.driven_m > *above_m)
            }
            Trigger::Signal { name, light } => self
                .line_of(name, seen)
                .is_some_and(|line| view.signals.light(line.signal, line.link).is_some_and(|shown| light.is(shown))),
            Trigger::After { event, delay_s, times } => {
                let run = run_of(event).filter(|run| run.times >= *times);
                is_past(run.and_then(|run| run.ended), *delay_s)
            }
            Trigger::Begun { event, delay_s } => is_past(run_of(event).and_then(|run| run.begun), *delay_s),
            Trigger::AdviceChanges => self.before.is_some_and(|(_, before)| {
                let target = |advice: Option<Advice>| advice.map(|advice| advice.target_mps);
                view.advice.is_some() && target(view.advice) != target(before)
            }),
            Trigger::Edge { id, lane, at_m } => seen.is_on_edge(id, *lane, *at_m),
            Trigger::SignalAhead { light, below_m } => seen.has_signal_ahead(*light, *below_m),
            Trigger::Pressed(input) => self.given.contains(input),
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

    /// Returns a vehicle along the ego's route; `ego` is the participant's.
    fn on_route(&self, name: &str, seen: &ScriptView) -> Option<OnRoute> {
        if name == EGO_NAME {
            return seen.own().map(|own| seen.on_route(own));
        }
        if let Some(user) = self.users.named(name) {
            return Some(user.on_route());
        }
        self.vehicle(name, seen).and_then(|id| seen.view.vehicle(id)).map(|car| seen.on_route(car))
    }

    /// Returns the distance from a vehicle's front to another vehicle ahead, bumper to bumper, m, the speed of the first, and the closing speed, m/s;
    /// `None` if the other one is behind. It is ahead if the distance with the added length is not negative.
    fn distance(&self, of: &str, to: &str, plus_m: f64, seen: &ScriptView) -> Option<[f64; 3]> {
        let speed_mps = seen.view.ego.speed_mps;
        if of == EGO_NAME && self.users.named(to).is_none() {
            let id = self.vehicle(to, seen)?;
            return Some([seen.distance_m(id)?, speed_mps, speed_mps - seen.view.vehicle(id)?.speed_mps]);
        }
        let [own, other] = [self.on_route(of, seen)?, self.on_route(to, seen)?];
        let is_against = self.users.named(of).is_some_and(|user| user.lane().1);
        let gap_m = if is_against { own.extent_m[0] - other.extent_m[1] } else { other.extent_m[0] - own.extent_m[1] };
        let closing_mps = (own.along_mps - other.along_mps) * if is_against { -1.0 } else { 1.0 };
        (gap_m + plus_m >= 0.0).then_some([gap_m, own.speed_mps, closing_mps])
    }

    /// Returns the next line of a signal ahead on the ego's path, and without one the last.
    pub(super) fn line_of(&self, signal: &str, seen: &ScriptView) -> Option<&StopLine> {
        let signals = seen.map.network.signals();
        let mut lines = self.lines.iter().filter(|line| signals[line.signal.index()].id == signal);
        let ahead = |line: &&StopLine| line.s_m >= seen.view.ego_s_m;
        lines.clone().find(ahead).or_else(|| lines.next_back())
    }
}
