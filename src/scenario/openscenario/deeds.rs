//! Actions of a scenario for those of OpenSCENARIO. In: [`Deed`]s of entities with their roles. Out: [`Action`]s. Seconds, metres, m/s.

use super::{
    actions::{Deed, Dynamics, Extent, LaneTarget, MeetingSpeed, SpeedTarget},
    casting::{Role, rounded},
    document::Place,
    fault::OpenScenarioError,
    positions::{Placement, Spot, lane_beside},
    scene::Scene,
    script::Script,
    storyboard::{InitAction, StoryEvent},
};
use crate::map::SHOULDER_M;
use crate::scenario::scripted_event::{
    Action, ChangeShape, LaneChange, Meeting, OffsetChange, SpeedChange, Teleport, Walk,
};
use std::f64::consts::PI;

/// Duration of a change at once, s.
const AT_ONCE_S: f64 = 0.01;
/// Largest lateral acceleration of a shift for which none is stated, m/s2: that of esmini.
const USUAL_MPS2: f64 = 0.5;

impl InitAction {
    /// Returns true for a speed that an entity has from the start on.
    pub fn is_plain_speed(&self) -> bool {
        matches!(&self.deed, Deed::Speed(Dynamics { extent: Extent::Step, .. }, SpeedTarget::Absolute(_)))
    }
}

impl StoryEvent {
    fn deeds(&self) -> impl Iterator<Item = &Deed> {
        self.actions.iter().filter_map(|action| action.deed.as_ref())
    }

    /// Returns true if an entity follows the speed of another until the event ends.
    pub fn keeps_a_speed(&self) -> bool {
        self.deeds().any(|deed| matches!(deed, Deed::Speed(_, SpeedTarget::Like { keeps: true, .. })))
    }

    /// Returns true if an action changes the speed of an entity.
    pub fn changes_speed(&self) -> bool {
        self.deeds().any(|deed| matches!(deed, Deed::Speed(..) | Deed::Meet { .. }))
    }
}

impl Scene<'_> {
    /// Returns the lane that an entity is on and the offset from its middle, in the direction of the road's left.
    pub fn lane_of(&self, spot: &Spot) -> Option<(i32, f64)> {
        let (road, s_m, t_m, lane) = spot.on_road.as_ref()?;
        let road = self.roads.road(road)?;
        let lane = lane.or_else(|| road.lane_under(*s_m, *t_m))?;
        Some((lane, t_m - road.lane_middle_m(lane, *s_m)?))
    }

    /// Returns the distance from the outermost lane that cars drive on to the edge of the road where an entity starts, m.
    pub fn beyond_lanes_m(&self, name: &str) -> f64 {
        let edges = self.spots.get(name).and_then(|spot| {
            let (road, s_m, ..) = spot.on_road.as_ref()?;
            self.roads.road(road)?.beside_driving_m(*s_m)
        });
        edges.unwrap_or(SHOULDER_M)
    }

    /// Returns the distance between the middles of two lanes of the road on which an entity starts, m; 3.5 m a lane where it cannot be known.
    fn between_lanes_m(&self, spot: Option<&Spot>, lanes: [i32; 2]) -> f64 {
        const USUAL_M: f64 = 3.5;
        let middles = spot.and_then(|spot| {
            let (road, s_m, ..) = spot.on_road.as_ref()?;
            let road = self.roads.road(road)?;
            Some(road.lane_middle_m(lanes[0], *s_m)? - road.lane_middle_m(lanes[1], *s_m)?)
        });
        middles.unwrap_or(USUAL_M * f64::from(lanes[0] - lanes[1])).abs()
    }
}

impl Script<'_> {
    /// Returns the action of an entity; `None` for one that is reported, or that the participant carries out.
    ///
    /// # Errors
    /// An entity, a place or a signal does not exist.
    pub fn action(
        &mut self,
        deed: &Deed,
        entity: Option<&str>,
        place: &Place,
    ) -> Result<Option<Action>, OpenScenarioError> {
        if let Deed::Signal { name, light } = deed {
            let (file, line) = (place.file.display(), place.line);
            let found = self.path_signal(name, place)?;
            return Ok(match found {
                Some((id, lights)) if lights.contains(light) => Some(Action::Signal { name: id, light: *light }),
                Some((id, _)) => {
                    let note =
                        format!("{file}:{line}: the signal {id} of the network never shows this light of {name}");
                    self.problems.note(note + "; it stays as it is");
                    None
                }
                None => {
                    let note = format!("{file}:{line}: the light {name} is not on the path of the ego");
                    self.problems.note(note + "; it shows what the program of the network gives it");
                    None
                }
            });
        }
        let Some(name) = entity else { return Ok(None) };
        let Some(role) = self.role(name, place)? else { return Ok(None) };
        if self.cast.is_participant(name) {
            let (file, line) = (place.file.display(), place.line);
            self.problems.note(format!("{file}:{line}: an action of {name} has no effect: the participant drives it"));
            return Ok(None);
        }
        match deed {
            Deed::Speed(dynamics, target) => self.speed_change(&role, *dynamics, target, place),
            Deed::Lane(dynamics, target) => self.lane_change(&role, *dynamics, target, place),
            Deed::Offset { shape, most_mps2, to_m } => Ok(Some(self.offset_change(&role, (*shape, *most_mps2), *to_m))),
            Deed::Meet { other, place: own, other_place, speed } => {
                let Some(with) = self.role(other, place)? else { return Ok(None) };
                let fronts = (self.front_at(&role, own)?, self.front_at(&with, other_place)?);
                let (Some(place_m), Some(with_place_m)) = fronts else { return Ok(None) };
                let to_mps = speed.as_ref().map(|speed| self.meeting_speed(speed, &with, place));
                let vehicle = role.name.clone();
                Ok(Some(Action::Synchronise(Meeting { vehicle, place_m, with: with.name, with_place_m, to_mps })))
            }
            Deed::Follow(points) => self.walk(&role, points),
            Deed::Teleport(to) => self.teleport(&role, to),
            Deed::Route(_) | Deed::Signal { .. } | Deed::Parameter { .. } => Ok(None),
        }
    }

    fn speed_change(
        &mut self,
        role: &Role,
        dynamics: Dynamics,
        target: &SpeedTarget,
        place: &Place,
    ) -> Result<Option<Action>, OpenScenarioError> {
        let mut change = SpeedChange {
            vehicle: role.name.clone(),
            to_mps: None,
            like: None,
            times: 1.0,
            plus_mps: 0.0,
            keeps: false,
            rate_mps2: None,
            in_s: None,
            in_m: None,
            shape: dynamics.shape,
        };
        match dynamics.extent {
            Extent::Step => {}
            Extent::Time(value) => change.in_s = Some(value),
            Extent::Distance(value) => change.in_m = Some(value),
            Extent::Rate(value) => change.rate_mps2 = Some(value),
        }
        match target {
            SpeedTarget::Absolute(to_mps) => change.to_mps = Some(*to_mps),
            SpeedTarget::Like { entity, times, plus_mps, keeps } => {
                let Some(like) = self.role(entity, place)? else { return Ok(None) };
                change.like = Some(like.name);
                (change.times, change.plus_mps, change.keeps) = (*times, *plus_mps, *keeps);
            }
        }
        Ok(Some(Action::Speed(change)))
    }

    fn lane_change(
        &mut self,
        role: &Role,
        dynamics: Dynamics,
        target: &LaneTarget,
        place: &Place,
    ) -> Result<Option<Action>, OpenScenarioError> {
        let entity = &role.entity.name;
        let spot = self.scene.spots.get(entity);
        let own = self.lanes.get(entity).map(|(lane, _)| *lane);
        let along = |name: &str| self.lanes.get(name).map(|(lane, _)| (*lane, self.leftwards(name)));
        let (to_the_left, of, next) = match target {
            LaneTarget::Absolute(lane) => {
                let Some((from, sign)) = along(entity) else {
                    let meaning = "the lane of the entity is not known; it keeps its lane";
                    self.leave_out(place, "AbsoluteTargetLane", meaning);
                    return Ok(None);
                };
                (sign * lanes_between(from, *lane), None, Some(*lane))
            }
            LaneTarget::Beside { entity: other, lanes } => {
                let Some(reference) = self.role(other, place)? else { return Ok(None) };
                let next = along(other).map(|(lane, sign)| lane_beside(lane, sign * lanes));
                (*lanes, (reference.name != role.name).then_some(reference.name), next)
            }
        };
        // A change to the own lane leads to its middle.
        let of = of.or_else(|| (to_the_left == 0).then(|| role.name.clone()));
        let aside_m = self.scene.between_lanes_m(spot, [own.unwrap_or(0), next.or(own).unwrap_or(0)]);
        let (in_s, in_m) = match dynamics.extent {
            Extent::Step => (Some(AT_ONCE_S), None),
            Extent::Time(value) => (Some(value), None),
            Extent::Distance(value) => (None, Some(value)),
            Extent::Rate(mps) => (Some(rounded(dynamics.shape.steepest() * aside_m.max(1.0) / mps)), None),
        };
        if let Some(next) = next {
            self.lanes.insert(entity.clone(), (next, 0.0));
        }
        let within_s = 5.0;
        let (vehicle, shape) = (role.name.clone(), dynamics.shape);
        Ok(Some(Action::ChangeLane(LaneChange { vehicle, to_the_left, of, within_s, in_s, in_m, shape })))
    }

    /// Returns 1 for an entity that heads along the line of its road at the start, and -1 for one against it.
    fn leftwards(&self, name: &str) -> i32 {
        let along = self.scene.spots.get(name).map_or(1.0, |spot| {
            let against = self.scene.place(spot).is_some_and(|place| place.is_against);
            self.scene.road_sign(spot) * if against { -1.0 } else { 1.0 }
        });
        if along < 0.0 { -1 } else { 1 }
    }

    fn offset_change(
        &mut self,
        role: &Role,
        (shape, most_mps2): (Option<ChangeShape>, Option<f64>),
        to_m: f64,
    ) -> Action {
        let entity = &role.entity.name;
        let sign = self.scene.spots.get(entity).map_or(1.0, |spot| self.scene.road_sign(spot));
        let from_m = self.lanes.get(entity).map_or(0.0, |(_, offset_m)| *offset_m);
        let (aside_m, most_mps2) = ((to_m - from_m).abs(), most_mps2.unwrap_or(USUAL_MPS2).max(1e-3));
        // The largest acceleration of half a cosine's period is pi²/2, that of the cubic 6, in its extent over the square of its time.
        let steepest = if shape == Some(ChangeShape::Sinusoidal) { PI * PI / 2.0 } else { 6.0 };
        let in_s = shape.map_or(AT_ONCE_S, |_| (steepest * aside_m / most_mps2).sqrt().max(AT_ONCE_S));
        if let Some((_, offset_m)) = self.lanes.get_mut(entity) {
            *offset_m = to_m;
        }
        let shape = shape.unwrap_or_default();
        Action::Offset(OffsetChange {
            vehicle: role.name.clone(),
            to_m: rounded(sign * to_m),
            in_s: Some(rounded(in_s)),
            in_m: None,
            shape,
        })
    }

    fn teleport(&mut self, role: &Role, to: &Placement) -> Result<Option<Action>, OpenScenarioError> {
        let spot = self.scene.spot(to)?;
        let Some(place) = self.scene.place(&spot) else {
            self.leave_out(&to.place, "Position", "the place is far from the path of the ego; the action is left out");
            return Ok(None);
        };
        if let Some(lane) = self.scene.lane_of(&spot) {
            self.lanes.insert(role.entity.name.clone(), lane);
        }
        let (lanes_left, offset_m) = place.lane(self.scene);
        let front_m = if place.is_against { -role.entity.front_m() } else { role.entity.front_m() };
        let (vehicle, place_m) = (role.name.clone(), rounded((place.s_m + front_m).max(0.0)));
        Ok(Some(Action::Teleport(Teleport { vehicle, place_m, lanes_left, offset_m, against: place.is_against })))
    }

    /// Returns the place of the front while the reference point is at a position; `None` if that is reported.
    fn front_at(&mut self, role: &Role, at: &Placement) -> Result<Option<f64>, OpenScenarioError> {
        let spot = self.scene.spot(at)?;
        let front_m = self.scene.place(&spot).map(|place| rounded(role.front_at_m(place.s_m)));
        if front_m.is_none_or(|front_m| front_m < 0.0) {
            self.leave_out(&at.place, "Position", "the place is not on the path of the ego; the action is left out");
            return Ok(None);
        }
        Ok(front_m)
    }

    fn meeting_speed(&mut self, speed: &MeetingSpeed, with: &Role, place: &Place) -> f64 {
        let (file, line, name) = (place.file.display(), place.line, &with.entity.name);
        let start_mps = with.speed_mps;
        let relative_mps = match speed {
            MeetingSpeed::Absolute(to_mps) => return *to_mps,
            MeetingSpeed::Plus(plus_mps) => start_mps + plus_mps,
            MeetingSpeed::Times(times) => start_mps * times,
        };
        self.problems.note(format!("{file}:{line}: the final speed counts from the speed of {name} at the start"));
        relative_mps.max(0.0)
    }

    fn walk(&mut self, role: &Role, points: &[Placement]) -> Result<Option<Action>, OpenScenarioError> {
        let mut found = Vec::new();
        for point in points {
            let spot = self.scene.spot(point)?;
            match self.scene.place(&spot) {
                Some(place) => found.push([rounded(place.s_m), rounded(place.offset_m)]),
                None => {
                    let meaning = "the point is far from the path of the ego; the line is not followed";
                    self.leave_out(&point.place, "Vertex", meaning);
                    return Ok(None);
                }
            }
        }
        Ok(Some(Action::Walk(Walk { vehicle: role.name.clone(), points: found })))
    }
}

/// Returns the number of lanes from one to another, positive to the left along the road, without the middle lane 0.
fn lanes_between(from: i32, to: i32) -> i32 {
    let crosses = (from < 0) != (to < 0);
    let between = to - from;
    between - if crosses { between.signum() } else { 0 }
}
