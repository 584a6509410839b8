//! All road users that a scenario places. In: actions of events, and once a tick the participant. Out: the road users as vehicles of the view. Metres, m/s.

use super::{
    cut_in::CutInStep,
    event_view::ScriptView,
    road_user::MovedRoadUser,
    user_speed::{SeenVehicle, SeenVehicles},
};
use crate::{
    map::RoadMap,
    scenario::{
        RoadUser,
        scripted_event::{Action, EGO_NAME},
    },
    sim::{Snapshot, VehicleSnapshot, event::NotDone},
    traffic::VehicleId,
};

/// Duration of a change of lanes into the ego's lane, s: that of a usual change of lanes.
const CUT_IN_S: f64 = 3.0;

/// Road users of a drive, by ascending id.
pub(super) struct RoadUsers(Vec<MovedRoadUser>);

impl RoadUsers {
    /// Places road users on the road of a drive, with ids from this one on.
    pub fn new(users: &[RoadUser], first: VehicleId, map: &RoadMap) -> Self {
        let placed = users.iter().zip(first.0..).map(|(user, id)| MovedRoadUser::new(VehicleId(id), user, map));
        Self(placed.collect())
    }

    /// Checks whether the scenario places no road user.
    pub fn are_none(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the road user of this name.
    pub fn named(&self, name: &str) -> Option<&MovedRoadUser> {
        self.0.iter().find(|user| user.name == name)
    }

    /// Checks whether this is the id of a road user.
    pub fn has(&self, id: VehicleId) -> bool {
        self.0.iter().any(|user| user.id == id)
    }

    /// Checks whether an action of this event is under way.
    pub fn are_moved_by(&self, event: usize) -> bool {
        self.0.iter().any(|user| user.is_moved_by(event))
    }

    /// Begins an action on a road user, in a view of the drive.
    pub fn begin(
        &mut self,
        event: usize,
        action: &Action,
        id: VehicleId,
        (view, map): (&Snapshot, &RoadMap),
    ) -> Result<(), NotDone> {
        let seen = self.seen(view);
        let others = |name: &str| find(&seen, name);
        let user = self.0.iter().find(|user| user.id == id).ok_or(NotDone::NoVehicle)?;
        let of_lane = match action {
            Action::ChangeLane(change) => match change.of.as_deref() {
                None => user.lane(),
                // The participant's lane is the route's.
                Some(EGO_NAME) => (0, false),
                Some(name) => self.named(name).ok_or(NotDone::NoVehicle)?.lane(),
            },
            _ => (0, false),
        };
        let user = self.0.iter_mut().find(|user| user.id == id).ok_or(NotDone::NoVehicle)?;
        if user.begin(event, action, of_lane, (map, &others)) { Ok(()) } else { Err(NotDone::Refused) }
    }

    /// Moves a road user that cuts in before the ego in the step that begins. Returns false once it is over.
    pub fn cut_in(&mut self, event: usize, id: VehicleId, step: CutInStep, (seen, step_s): (&ScriptView, f64)) -> bool {
        let (CutInStep::Drives(motion) | CutInStep::Changes(motion, _)) = step else { return false };
        let Some(user) = self.0.iter_mut().find(|user| user.id == id) else { return false };
        user.drive(event, motion.end_mps, step_s);
        if matches!(step, CutInStep::Changes(..)) {
            user.enter_route(event, CUT_IN_S, seen.map);
        }
        true
    }

    /// Moves all road users by a number of ticks, with the participant as they are in the view.
    pub fn tick(&mut self, ticks: u64, view: &Snapshot, map: &RoadMap) {
        if self.are_none() {
            return;
        }
        for _ in 0..ticks {
            let seen = self.seen(view);
            let others: SeenVehicles = &|name| find(&seen, name);
            self.0.iter_mut().for_each(|user| user.tick(map, others));
        }
    }

    /// Returns all road users as they are drawn now.
    pub fn now(&self) -> impl Iterator<Item = VehicleSnapshot> {
        self.0.iter().map(MovedRoadUser::now)
    }

    /// Returns the participant's vehicle and all road users as others see them, with their names.
    fn seen(&self, view: &Snapshot) -> Vec<(String, SeenVehicle)> {
        let ego = SeenVehicle { front_m: view.ego_s_m, along_mps: view.ego.speed_mps, speed_mps: view.ego.speed_mps };
        let ego = (!view.is_without_ego).then(|| (EGO_NAME.to_owned(), ego));
        ego.into_iter().chain(self.0.iter().map(|user| (user.name.clone(), user.seen()))).collect()
    }
}

fn find(seen: &[(String, SeenVehicle)], name: &str) -> Option<SeenVehicle> {
    seen.iter().find(|(other, _)| other == name).map(|(_, seen)| *seen)
}
