//! SUMO's simulation behind a [`Link`]: the same few calls as [`super::shim`] has for SUMO in this process. In: names,
//! numbers and commands. Out: records, or what went wrong. A step is one exchange: commands and step go out together,
//! the states of all cars come back as one subscription.

use super::{
    link::Link,
    shim::{Command, CommandKind, Record, VehicleType},
    wire::{self, Content, INVALID_DOUBLE, Message, Reply, WireFault},
};
use crate::{space::SumoPose, traffic::TrafficError};
use glam::dvec2;
use std::time::Duration;

/// The SUMO that this program drives, and its protocol. A SUMO of another version moves cars otherwise, so that a drive
/// could not be repeated; scripts/setup installs this one.
pub const VERSION: &str = "1.28.0";
const PROTOCOL: i32 = 22;
/// Of several clients of one SUMO the drive is the first in each step: watchers see what it did.
const ORDER: i32 = 1;
/// What a subscription tells of a car.
const STATES: [u8; 3] = [wire::SPEED, wire::LANE_POSITION, wire::LANE_ID];

/// A car, and where it was last.
struct Car {
    id: String,
    lane: i32,
}

/// A SUMO behind a socket.
pub(super) struct Remote {
    link: Link,
    version: String,
    lanes: Vec<String>,
    cars: Vec<Car>,
    /// Commands of a step on its way whose statuses have not come yet; `None` between steps.
    asked: Option<Vec<u8>>,
    /// States of cars that were put on the road, until the first step.
    first: Vec<Record>,
}

impl Remote {
    /// Connects, and is sure that it is a SUMO of our version.
    ///
    /// # Errors
    /// Nobody listens there, no answer in time, not SUMO, another version.
    pub fn connect(host: &str, port: u16, timeout: Duration) -> Result<Self, TrafficError> {
        let mut link = Link::open(host, port, timeout)?;
        let (protocol, version) = link.version()?;
        if protocol != PROTOCOL || version != format!("SUMO {VERSION}") {
            return Err(TrafficError::OtherVersion {
                address: link.address.clone(),
                theirs: format!("{version} (protocol {protocol})"),
                ours: format!("SUMO {VERSION} (protocol {PROTOCOL})"),
            });
        }
        let (lanes, cars, first) = (Vec::new(), Vec::new(), Vec::new());
        let mut remote = Self { link, version, lanes, cars, asked: None, first };
        remote.tell("its consent to the order of clients", wire::SET_ORDER, |content| {
            content.raw_i32(ORDER);
        })?;
        Ok(remote)
    }

    /// Sends one command and hands the answer, after its status, to `read`.
    fn ask<T>(
        &mut self,
        what: &str,
        command: u8,
        fill: impl FnOnce(&mut Content),
        read: impl FnOnce(&mut Reply) -> Result<T, WireFault>,
    ) -> Result<T, TrafficError> {
        let (_, bytes) = Message::of(command, fill).finish();
        self.link.send(&bytes, what)?;
        let answer = self.link.receive()?;
        let mut reply = Reply(&answer);
        let found = reply.status(command).and_then(|()| read(&mut reply));
        found.map_err(|fault| fail(&self.link, fault))
    }

    fn tell(&mut self, what: &str, command: u8, fill: impl FnOnce(&mut Content)) -> Result<(), TrafficError> {
        self.ask(what, command, fill, |_| Ok(()))
    }

    fn get<T>(
        &mut self,
        command: u8,
        variable: u8,
        id: &str,
        read: impl FnOnce(&mut Reply) -> Result<T, WireFault>,
    ) -> Result<T, TrafficError> {
        let what = format!("what it knows of {id}");
        let ask = |content: &mut Content| {
            content.variable(variable, id);
        };
        self.ask(&what, command, ask, |reply| {
            reply.command(command + wire::ANSWER)?;
            reply.u8()?;
            reply.text()?;
            read(reply)
        })
    }

    /// SUMO's version, as it names itself.
    pub fn version(&self) -> &str {
        &self.version
    }

    /// The value of an option.
    pub fn option(&mut self, name: &str) -> Result<String, TrafficError> {
        self.get(wire::GET_SIMULATION, wire::OPTION, name, |reply| reply.string().map(str::to_owned))
    }

    /// Begins anew with these options.
    pub fn load(&mut self, options: &[String]) -> Result<(), TrafficError> {
        self.tell("that it begins anew", wire::LOAD, |content| {
            content.texts(options);
        })
    }

    /// Numbers the lanes.
    pub fn set_lanes(&mut self, ids: &[String]) {
        self.lanes = ids.to_vec();
    }

    /// Length, metres, and speed limit, m/s, of a lane by its number.
    pub fn lane(&mut self, lane: usize) -> Result<(f64, f64), TrafficError> {
        let id = self.lanes.get(lane).cloned().unwrap_or_default();
        let length_m = self.get(wire::GET_LANE, wire::LENGTH, &id, |reply| reply.double())?;
        let speed_mps = self.get(wire::GET_LANE, wire::MAX_SPEED, &id, |reply| reply.double())?;
        Ok((length_m, speed_mps))
    }

    /// Closes lanes to passenger cars in this simulation.
    pub fn close_lanes(&mut self, ids: &[String]) -> Result<(), TrafficError> {
        let classes = ["passenger".to_owned()];
        let mut message = Message::new();
        for id in ids {
            message.add(wire::SET_LANE, |content| {
                content.variable(wire::DISALLOWED, id).texts(&classes);
            });
        }
        if message.is_empty() { Ok(()) } else { self.exchange("that lanes beside the route are closed", message) }
    }

    /// Makes a vehicle type, by way of a draft for the reason that `cs_type` in shim.cpp tells.
    pub fn add_type(&mut self, base: &str, name: &str, v: &VehicleType) -> Result<(), TrafficError> {
        let draft = format!("{name}.draft");
        let copy = |content: &mut Content, from: &str, to: &str| {
            content.variable(wire::COPY, from).text(to);
        };
        let mut message = Message::new();
        message.add(wire::SET_TYPE, |content| copy(content, base, &draft));
        for (variable, value) in [
            (wire::LENGTH, v.length_m),
            (wire::WIDTH, v.width_m),
            (wire::ACCEL, v.accel_mps2),
            (wire::DECEL, v.decel_mps2),
            (wire::EMERGENCY_DECEL, v.emergency_decel_mps2),
            (wire::APPARENT_DECEL, v.decel_mps2),
            (wire::TAU, v.time_gap_s),
            (wire::MIN_GAP, v.min_gap_m),
            (wire::MAX_SPEED, v.max_speed_mps),
            (wire::SPEED_FACTOR, 1.0),
            (wire::SPEED_DEVIATION, 0.0),
        ] {
            message.add(wire::SET_TYPE, |content| {
                content.variable(variable, &draft).double(value);
            });
        }
        message.add(wire::SET_TYPE, |content| copy(content, &draft, name));
        self.exchange("the type of cars", message)
    }

    /// Makes a route of edges.
    pub fn add_route(&mut self, id: &str, edges: &[String]) -> Result<(), TrafficError> {
        self.tell("the route", wire::SET_ROUTE, |content| {
            content.variable(wire::ADD, id).texts(edges);
        })
    }

    /// Puts the next car on the road: lane by number, position in metres, speed in m/s.
    pub fn add_car(
        &mut self,
        (id, route, kind): (&str, &str, &str),
        lane: usize,
        position_m: f64,
        speed_mps: f64,
    ) -> Result<(), TrafficError> {
        let on = self.lanes.get(lane).map_or("", String::as_str);
        let mut message = Message::new();
        message.add(wire::SET_VEHICLE, |content| {
            content.variable(wire::ADD_FULL, id).compound(14);
            // Route, type; departure: time, lane, position, speed; arrival: lane, position, speed; districts, line.
            for text in [route, kind, "now", "first", "0", "0", "current", "max", "current", "", "", ""] {
                content.text(text);
            }
            content.integer(0).integer(0);
        });
        message.add(wire::SET_VEHICLE, |content| {
            content.variable(wire::MOVE_TO, id).compound(3).text(on).double(position_m).integer(0);
        });
        message.add(wire::SET_VEHICLE, |content| previous_speed(content, id, speed_mps, 0.0));
        message.add(wire::SET_VEHICLE, |content| {
            content.variable(wire::LANE_CHANGE_MODE, id).integer(0);
        });
        self.exchange(&format!("that {id} is on the road"), message)?;
        self.cars.push(Car { id: id.to_owned(), lane: i32::try_from(lane).unwrap_or(-1) });
        let subscribe = |content: &mut Content| {
            content.raw_f64(INVALID_DOUBLE).raw_f64(INVALID_DOUBLE).raw_text(id).raw_u8(STATES.len() as u8);
            STATES.into_iter().fold(content, |content, variable| content.raw_u8(variable));
        };
        let mut record = [Record::default()];
        let (lanes, cars) = (&self.lanes, &mut self.cars);
        let last = cars.len() - 1;
        let mut read = |reply: &mut Reply| state(reply, lanes, &mut cars[last..], &mut record, 0).map(drop);
        let (_, bytes) = Message::of(wire::SUBSCRIBE_VEHICLE, subscribe).finish();
        self.link.send(&bytes, "where a car is")?;
        let answer = self.link.receive()?;
        let mut reply = Reply(&answer);
        let found = reply.status(wire::SUBSCRIBE_VEHICLE).and_then(|()| read(&mut reply));
        found.map_err(|fault| fail(&self.link, fault))?;
        self.first.push(record[0]);
        Ok(())
    }

    /// Sends a message whose commands have statuses and nothing else.
    fn exchange(&mut self, what: &str, message: Message) -> Result<(), TrafficError> {
        let (commands, bytes) = message.finish();
        self.link.send(&bytes, what)?;
        self.statuses(&commands)
    }

    fn statuses(&mut self, commands: &[u8]) -> Result<(), TrafficError> {
        let answer = self.link.receive()?;
        let mut reply = Reply(&answer);
        let found = commands.iter().try_for_each(|command| reply.status(*command));
        found.map_err(|fault| fail(&self.link, fault))
    }

    /// Asks for a step after these commands.
    pub fn begin(&mut self, commands: &[Command]) -> Result<(), TrafficError> {
        let mut message = Message::new();
        for command in commands {
            let id = &self.cars[command.car as usize].id;
            message.add(wire::SET_VEHICLE, |content| obey(content, id, command));
        }
        // Two messages in one go: where several clients share a SUMO, statuses before a step in the same message are
        // sent to another of them.
        let (mut bytes, mut asked) = (Vec::new(), Vec::new());
        if !message.is_empty() {
            (asked, bytes) = message.finish();
        }
        let step = Message::of(wire::STEP, |content| {
            content.raw_f64(0.0);
        });
        bytes.extend_from_slice(&step.finish().1);
        self.link.send(&bytes, "a step")?;
        self.asked = Some(asked);
        Ok(())
    }

    /// True once the step that was asked for is over, with all cars in `records`; waits `patience` for it at most.
    pub fn finish(&mut self, patience: Duration, records: &mut [Record]) -> Result<bool, TrafficError> {
        if !self.link.poll(patience)? {
            return Ok(false);
        }
        if let Some(asked) = self.asked.as_mut().map(std::mem::take).filter(|asked| !asked.is_empty()) {
            self.statuses(&asked)?;
            if !self.link.poll(patience)? {
                return Ok(false);
            }
        }
        let answer = self.link.receive()?;
        self.asked = None;
        let mut reply = Reply(&answer);
        let (lanes, cars) = (&self.lanes, &mut self.cars);
        records.iter_mut().for_each(|record| record.present = 0);
        let found = reply.status(wire::STEP).and_then(|()| {
            let mut next = 0;
            for _ in 0..reply.i32()? {
                next = state(&mut reply, lanes, cars, records, next)? + 1;
            }
            if reply.is_read() { Ok(()) } else { Err(WireFault::Garbled) }
        });
        found.map_err(|fault| fail(&self.link, fault))?;
        Ok(true)
    }

    /// All cars as they were put on the road.
    pub fn read(&self, records: &mut [Record]) {
        records.copy_from_slice(&self.first);
    }

    /// Where SUMO itself draws a car.
    pub fn pose(&mut self, car: u32) -> Result<SumoPose, TrafficError> {
        let id = self.cars[car as usize].id.clone();
        let [x, y] = self.get(wire::GET_VEHICLE, wire::POSITION, &id, |reply| reply.position())?;
        let angle_deg = self.get(wire::GET_VEHICLE, wire::ANGLE, &id, |reply| reply.double())?;
        Ok(SumoPose { front: dvec2(x, y), angle_deg })
    }
}

impl Drop for Remote {
    /// A SUMO that owes an answer is not asked for another.
    fn drop(&mut self) {
        if self.asked.is_none() {
            self.link.close();
        }
    }
}

fn fail(link: &Link, fault: WireFault) -> TrafficError {
    match fault {
        WireFault::Refused(text) => TrafficError::Sumo(format!("{} (at {})", text.trim(), link.address)),
        WireFault::Garbled => link.garbled(),
    }
}

fn previous_speed(content: &mut Content, id: &str, speed_mps: f64, accel_mps2: f64) {
    content.variable(wire::PREVIOUS_SPEED, id).compound(2).double(speed_mps).double(accel_mps2);
}

fn obey(content: &mut Content, id: &str, command: &Command) {
    match command.kind {
        CommandKind::MoveToXy => {
            content.variable(wire::MOVE_TO_XY, id).compound(7).text("").integer(-1);
            // Off the route if need be (2), a lane within 20 m.
            content.double(command.a).double(command.b).double(command.c).byte(2).double(20.0);
        }
        CommandKind::PreviousSpeed => previous_speed(content, id, command.a, INVALID_DOUBLE),
        CommandKind::Speed => {
            content.variable(wire::SPEED, id).double(command.a);
        }
        CommandKind::MaxSpeed => {
            content.variable(wire::MAX_SPEED, id).double(command.a);
        }
        CommandKind::SpeedMode => {
            content.variable(wire::SPEED_MODE, id).integer(command.a as i32);
        }
    }
}

/// One car's part of a subscription, into its record. Returns its number, which is looked for from `guess` on.
fn state(
    reply: &mut Reply,
    lanes: &[String],
    cars: &mut [Car],
    records: &mut [Record],
    guess: usize,
) -> Result<usize, WireFault> {
    reply.command(wire::SUBSCRIBE_VEHICLE + wire::ANSWER)?;
    let id = reply.text()?;
    let mut numbers = (guess..cars.len()).chain(0..guess.min(cars.len()));
    let number = numbers.find(|number| cars[*number].id == id).ok_or(WireFault::Garbled)?;
    let mut record = Record { present: 1, ..Record::default() };
    if usize::from(reply.u8()?) != STATES.len() {
        return Err(WireFault::Garbled);
    }
    for variable in STATES {
        if reply.u8()? != variable {
            return Err(WireFault::Garbled);
        }
        if reply.u8()? != 0 {
            return Err(WireFault::Refused(reply.string()?.to_owned()));
        }
        match variable {
            wire::SPEED => record.speed_mps = reply.double()?,
            wire::LANE_POSITION => record.lane_pos_m = reply.double()?,
            _ => record.lane = lane_number(lanes, reply.string()?, cars[number].lane),
        }
    }
    cars[number].lane = record.lane;
    records[number] = record;
    Ok(number)
}

/// The number of a lane, looked for from `guess` on; -1 if it is none of them.
fn lane_number(lanes: &[String], id: &str, guess: i32) -> i32 {
    let start = usize::try_from(guess).unwrap_or_default();
    let found = (0..lanes.len()).map(|k| (start + k) % lanes.len()).find(|i| lanes[*i] == id);
    found.and_then(|i| i32::try_from(i).ok()).unwrap_or(-1)
}
