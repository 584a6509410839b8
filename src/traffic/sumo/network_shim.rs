//! The C interface of `network_shim.cpp`, for roads that vehicles enter and leave. In: names of lanes and signals, commands. Out: the
//! changes of a step, as columns that are valid until the next call.

use super::shim::{Shim, Text, Texts, c_text, with_texts};
use crate::traffic::TrafficError;
use std::{
    ffi::{CStr, c_char, c_int},
    ptr, slice,
};

/// Kinds of commands for a vehicle before the step; numbered as in network_shim.cpp.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NetworkCommandKind {
    /// `a`, `b`: front bumper, metres; `c`: compass degrees.
    MoveToXy = 0,
    /// `a`: speed that the model and followers take as the present one, m/s.
    PreviousSpeed = 1,
    /// `a`: speed imposed until further notice, m/s; below 0 ends it.
    Speed = 2,
    /// `a`: SUMO's speed mode.
    SpeedMode = 3,
    /// `a`: SUMO's bits for vehicle lamps.
    Lamps = 5,
}

/// Command for one vehicle, with the layout of network_shim.cpp.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(super) struct NetworkCommand {
    pub vehicle: u32,
    pub kind: NetworkCommandKind,
    /// Number of the lane to move to; -1 lets SUMO choose.
    pub lane: i32,
    pub a: f64,
    pub b: f64,
    pub c: f64,
}

/// State of one vehicle after a step, with the layout of network_shim.cpp.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(super) struct NetworkRecord {
    /// Position of the front bumper, metres.
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub angle_deg: f64,
    pub speed_mps: f64,
    pub lane_pos_m: f64,
    pub lateral_m: f64,
    pub number: u32,
    /// Number of the lane; -1 if on none of them.
    pub lane: i32,
    /// SUMO's bits for vehicle lamps.
    pub lamps: u32,
}

/// Vehicle that departed. C owns the names, which are valid until the next call.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
struct RawDeparture {
    length_m: f64,
    width_m: f64,
    height_m: f64,
    number: u32,
    id: Text,
    class: Text,
    kind: Text,
}

/// Raw form of [`NetworkStep`]. C owns the arrays, which are valid until the next call.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(super) struct RawStep {
    records: *const NetworkRecord,
    departures: *const RawDeparture,
    arrivals: *const u32,
    signals: *const c_char,
    signal_starts: *const u32,
    record_count: usize,
    departure_count: usize,
    arrival_count: usize,
    signal_count: usize,
}

impl Default for RawStep {
    fn default() -> Self {
        Self {
            records: ptr::null(),
            departures: ptr::null(),
            arrivals: ptr::null(),
            signals: ptr::null(),
            signal_starts: ptr::null(),
            record_count: 0,
            departure_count: 0,
            arrival_count: 0,
            signal_count: 0,
        }
    }
}

/// Functions of the part of the shim for networks.
pub(super) struct NetworkApi {
    pub begin: unsafe extern "C" fn(Texts, usize, Texts, usize, c_int, u32) -> c_int,
    pub add: unsafe extern "C" fn(Text, Text, Text, usize, f64, f64, *mut u32) -> c_int,
    pub take: unsafe extern "C" fn(u32, *mut Text) -> c_int,
    pub step: unsafe extern "C" fn(*const NetworkCommand, usize, f64, *mut RawStep) -> c_int,
    pub look: unsafe extern "C" fn(*mut RawStep) -> c_int,
    pub end: unsafe extern "C" fn(),
}

/// Vehicle that departed in a step.
#[derive(Clone, Copy, Debug)]
pub(super) struct NetworkDeparture<'a> {
    pub number: u32,
    pub length_m: f64,
    pub width_m: f64,
    pub height_m: f64,
    /// Id of the vehicle in SUMO.
    pub name: &'a CStr,
    /// SUMO's vehicle class: passenger, truck and so on.
    pub class: &'a CStr,
    /// Id of the vehicle's type in SUMO.
    pub kind: &'a CStr,
}

/// State of the simulation after a step.
pub(super) struct NetworkStep<'a> {
    /// All vehicles on the road, by ascending number.
    pub records: &'a [NetworkRecord],
    departures: &'a [RawDeparture],
    /// Numbers of the vehicles that arrived, ascending.
    pub arrivals: &'a [u32],
    /// States of all signals in sequence, one letter per link.
    pub signals: &'a [u8],
    /// Start of each signal in `signals`, with the total length as the last entry.
    pub signal_starts: &'a [u32],
}

/// Returns a C array as a slice. The pointer may be null if the array is empty.
///
/// # Safety
/// `first` points to `count` elements that are valid for `'a`.
unsafe fn array<'a, T>(first: *const T, count: usize) -> &'a [T] {
    if count == 0 { &[] } else { unsafe { slice::from_raw_parts(first, count) } }
}

impl<'a> NetworkStep<'a> {
    /// Returns the vehicles that departed, by ascending number.
    pub fn departures(&self) -> impl Iterator<Item = NetworkDeparture<'a>> {
        // SAFETY: the shim sets all names, and they are valid as long as the step.
        let text = |text: Text| unsafe { CStr::from_ptr(text) };
        self.departures.iter().map(move |raw| NetworkDeparture {
            number: raw.number,
            length_m: raw.length_m,
            width_m: raw.width_m,
            height_m: raw.height_m,
            name: text(raw.id),
            class: text(raw.class),
            kind: text(raw.kind),
        })
    }
}

/// Simulation of a network; it ends when dropped.
pub(super) struct NetworkShim {
    pub shim: Shim,
}

// SAFETY of all calls below: as in shim.rs.
impl NetworkShim {
    /// Prepares a simulation that has just started. `lateral`: lane changes take time. `first`: number of the first vehicle.
    pub fn begin(
        shim: Shim,
        lanes: &[String],
        signals: &[String],
        (lateral, first): (bool, u32),
    ) -> Result<Self, TrafficError> {
        let begin = shim.api.network.begin;
        let code = with_texts(lanes, |lanes, n| {
            with_texts(signals, |signals, m| unsafe { begin(lanes, n, signals, m, c_int::from(lateral), first) })
        });
        shim.check(code)?;
        Ok(Self { shim })
    }

    /// Puts a vehicle on a lane at once and returns its number.
    pub fn add(
        &mut self,
        (id, route, kind): (&str, &str, &str),
        lane: usize,
        position_m: f64,
        speed_mps: f64,
    ) -> Result<u32, TrafficError> {
        let (id, route, kind) = (c_text(id), c_text(route), c_text(kind));
        let mut number = 0;
        let add = self.shim.api.network.add;
        let code =
            unsafe { add(id.as_ptr(), route.as_ptr(), kind.as_ptr(), lane, position_m, speed_mps, &raw mut number) };
        self.shim.check(code)?;
        Ok(number)
    }

    /// Makes a vehicle of the demand externally driven and returns the edges of its route.
    pub fn take(&mut self, number: u32) -> Result<Vec<String>, TrafficError> {
        let mut edges: Text = ptr::null();
        let code = unsafe { (self.shim.api.network.take)(number, &raw mut edges) };
        self.shim.check(code)?;
        // SAFETY: set by a call that succeeded, and read before the next.
        let edges = unsafe { CStr::from_ptr(edges) }.to_string_lossy();
        Ok(edges.split(' ').map(str::to_owned).collect())
    }

    /// Executes the commands and one step of this length, and returns the new state.
    pub fn step(&mut self, commands: &[NetworkCommand], step_s: f64) -> Result<NetworkStep<'_>, TrafficError> {
        let mut raw = RawStep::default();
        let code = unsafe { (self.shim.api.network.step)(commands.as_ptr(), commands.len(), step_s, &raw mut raw) };
        self.shim.check(code)?;
        Ok(Self::seen(&raw))
    }

    /// Returns the present state, without a step.
    pub fn look(&mut self) -> Result<NetworkStep<'_>, TrafficError> {
        let mut raw = RawStep::default();
        let code = unsafe { (self.shim.api.network.look)(&raw mut raw) };
        self.shim.check(code)?;
        Ok(Self::seen(&raw))
    }

    /// Converts the shim's raw state. It is valid until the next call, which needs `&mut self`.
    fn seen<'a>(raw: &RawStep) -> NetworkStep<'a> {
        unsafe {
            let signal_starts: &[u32] = array(raw.signal_starts, raw.signal_count + 1);
            NetworkStep {
                records: array(raw.records, raw.record_count),
                departures: array(raw.departures, raw.departure_count),
                arrivals: array(raw.arrivals, raw.arrival_count),
                signals: array(raw.signals.cast(), signal_starts.last().map_or(0, |end| *end as usize)),
                signal_starts,
            }
        }
    }
}

impl Drop for NetworkShim {
    fn drop(&mut self) {
        unsafe { (self.shim.api.network.end)() };
    }
}
