//! Light agents: advised vehicles without a person inside. In: once a step what the driver sees. Out: the motion in that step, for the traffic
//! engine, which steers the vehicle, lets it change lanes and keeps it from running into others. Metres, m/s.
//!
//! Driver, pedals, engine and brakes are those of a full agent; springs, tyres and steering are left out, and the driver sees no more
//! than the leader, the advice and the road. The leader goes on with its acceleration within the step.

use super::{
    agent::{Agent, AgentBody},
    light_body::LightBody,
    network_view::NetworkView,
};
use crate::{
    driver::{Perception, SeenLeader},
    ego::{Contact, ObstacleId},
    map::RoadMap,
    sim::{Leader, Snapshot, VehicleSnapshot},
    time::TICK_S,
    traffic::{EGO, LaneMotion, VehicleId},
};
use std::sync::Arc;

impl Agent {
    /// Returns the motion of a light agent in the step that begins.
    pub(super) fn motion(&self) -> Option<LaneMotion> {
        match &self.body {
            AgentBody::Light(light) => light.motion,
            AgentBody::Full(_) => None,
        }
    }

    /// Lets the driver of a light agent drive the step that begins at `all`, the view of all vehicles.
    pub(super) fn choose_motion(&mut self, all: &Snapshot, step_ticks: u64) {
        let AgentBody::Light(light) = &mut self.body else { return };
        let (id, LightBody { car, motion, touch }) = (self.id, &mut **light);
        *motion = None;
        let Some(driver) = self.driver.as_mut().filter(|_| all.vehicle(id).is_some()) else { return };
        let (route, s_m) = (&self.map.route, self.view.ego_s_m);
        let lane = driver.look_along(route, s_m, car.speed_mps());
        let seen = Perception { lane, speed_limit_mps: route.speed_limit_mps(s_m), ..Perception::default() };
        let mut ahead = self.view.leader.map(|leader| MovingLeader::of(leader, all));
        // As with a full agent, the advice of a step is shown in its first tick and seen in the second.
        let mut advice = self.view.advice;
        let mut way_m = 0.0;
        for _ in 0..step_ticks {
            let leader = ahead.as_ref().map(|ahead| ahead.seen);
            self.controls = driver.pedals(&Perception { speed_mps: car.speed_mps(), leader, advice, ..seen });
            advice = self.advice.standing();
            self.control_delay.push_back(self.controls);
            let controls = self.control_delay.pop_front().unwrap_or(self.controls);
            let mut tick_m = car.tick(&controls, lane.grade).max(0.0);
            // Nothing moves backwards in traffic.
            car.set_speed(car.speed_mps().max(0.0));
            if let Some(ahead) = &mut ahead {
                let room_m = ahead.move_on();
                if tick_m > room_m {
                    touch.get_or_insert(ahead.touched_at(car.speed_mps()));
                    tick_m = room_m.max(0.0);
                    car.set_speed(car.speed_mps().min(ahead.seen.speed_mps));
                }
                ahead.seen.gap_m -= tick_m;
            }
            way_m += tick_m;
        }
        let mean_mps = way_m / (step_ticks as f64 * TICK_S);
        *motion = Some(LaneMotion { id, mean_mps, end_mps: car.speed_mps() });
    }

    /// Gives a light agent another path, on which it is at `s_m`.
    pub(super) fn drive_along(&mut self, map: Arc<RoadMap>, s_m: f64) {
        self.network = NetworkView::new(&map);
        (self.map, self.view.ego_s_m) = (map, s_m);
    }

    /// Takes a light agent to where the traffic has it at the end of a step: `now`, in the view of all vehicles.
    pub(super) fn follow_traffic(&mut self, now: &VehicleSnapshot, leader: Option<Leader>, all: &Snapshot) {
        let AgentBody::Light(light) = &mut self.body else { return };
        // An engine of networks may have held it back.
        light.car.set_speed(now.speed_mps);
        let view = &mut self.view;
        view.ego_before = view.ego;
        view.ego = light.state(now.pose, now.height_m);
        match now.s_m.filter(|_| self.map.route.is_closed()) {
            Some(s_m) => (view.ego_s_m, view.ego_lane) = (s_m, now.lane),
            None => self.network.follow(view, &self.map, now.lane),
        }
        view.lane_offset_m = now.lane.map_or(0.0, |lane| lane.offset_m);
        view.leader = leader;
        view.mean_speed_mps = all.mean_speed_mps;
        view.signals.clone_from(&all.signals);
        let touch = light.touch.take();
        let known = self.events.len();
        let vehicle_kind = |id: VehicleId| all.vehicle(id).map(|car| car.body.kind).unwrap_or_default();
        self.events.extend(self.contacts.begun(touch.as_slice(), view.tick, &|_| None, &vehicle_kind));
        self.contact_count += (self.events.len() - known) as u32;
        self.image = *now;
    }
}

/// Leader within a step.
struct MovingLeader {
    id: VehicleId,
    seen: SeenLeader,
    accel_mps2: f64,
}

impl MovingLeader {
    fn of(leader: Leader, all: &Snapshot) -> Self {
        let accel_mps2 = match all.vehicle(leader.id) {
            Some(car) => car.accel_mps2,
            None if leader.id == EGO => all.ego.accel_mps2,
            None => 0.0,
        };
        Self { id: leader.id, seen: SeenLeader { gap_m: leader.gap_m, speed_mps: leader.speed_mps }, accel_mps2 }
    }

    /// Moves the leader by one tick. Returns the way up to it, metres.
    fn move_on(&mut self) -> f64 {
        self.seen.speed_mps = (self.seen.speed_mps + self.accel_mps2 * TICK_S).max(0.0);
        self.seen.gap_m += self.seen.speed_mps * TICK_S;
        self.seen.gap_m
    }

    /// Returns the contact of a vehicle of this speed with the leader.
    fn touched_at(&self, speed_mps: f64) -> Contact {
        Contact {
            with: ObstacleId::Vehicle(self.id.0),
            ego_speed_mps: speed_mps,
            car_speed_mps: self.seen.speed_mps,
            closing_mps: (speed_mps - self.seen.speed_mps).max(0.0),
            angle_rad: 0.0,
        }
    }
}
