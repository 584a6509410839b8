//! The C interface of `network_shim.cpp`: roads on which vehicles come and go. In: names of lanes and signals, commands. Out: what a
//! step has changed, as columns that stand until the next.

use super::shim::{Shim, Text, Texts, c_text, with_texts};
use crate::traffic::TrafficError;
use std::{
    ffi::{CStr, c_char, c_int},
    ptr, slice,
};

/// What shall be done to a vehicle before the step; numbered as in network_shim.cpp.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NetworkCommandKind {
    /// `a`, `b`: front bumper; `c`: compass degrees.
    MoveToXy = 0,
    /// `a`: the speed that model and followers take for the present one, m/s.
    PreviousSpeed = 1,
    /// `a`: speed imposed until further notice, m/s; below 0 ends it.
    Speed = 2,
    /// `a`: SUMO's speed mode.
    SpeedMode = 3,
    /// `a`: SUMO's bits of lamps.
    Lamps = 5,
}

/// One command.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(super) struct NetworkCommand {
    pub vehicle: u32,
    pub kind: NetworkCommandKind,
    /// The lane where it is to be, by number; -1: whichever is there.
    pub lane: i32,
    pub a: f64,
    pub b: f64,
    pub c: f64,
}

/// One vehicle after a step.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(super) struct NetworkRecord {
    /// Front bumper, metres.
    pub x: f64,
    pub y: f64,
    pub z: f64,
    pub angle_deg: f64,
    pub speed_mps: f64,
    pub lane_pos_m: f64,
    pub lateral_m: f64,
    pub number: u32,
    /// By number; -1: none.
    pub lane: i32,
    /// SUMO's bits.
    pub lamps: u32,
}

/// A vehicle that has come. The names are C's until the next call.
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

/// See [`NetworkStep`]; C's until the next call.
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

/// The functions.
pub(super) struct NetworkApi {
    pub begin: unsafe extern "C" fn(Texts, usize, Texts, usize, c_int, u32) -> c_int,
    pub add: unsafe extern "C" fn(Text, Text, Text, usize, f64, f64, *mut u32) -> c_int,
    pub take: unsafe extern "C" fn(u32, *mut Text) -> c_int,
    pub step: unsafe extern "C" fn(*const NetworkCommand, usize, f64, *mut RawStep) -> c_int,
    pub look: unsafe extern "C" fn(*mut RawStep) -> c_int,
    pub end: unsafe extern "C" fn(),
}

/// A vehicle that has come.
#[derive(Clone, Copy, Debug)]
pub(super) struct NetworkDeparture<'a> {
    pub number: u32,
    pub length_m: f64,
    pub width_m: f64,
    pub height_m: f64,
    /// SUMO's name of it.
    pub name: &'a CStr,
    /// SUMO's class: passenger, truck and so on.
    pub class: &'a CStr,
    /// SUMO's type.
    pub kind: &'a CStr,
}

/// What there is after a step.
pub(super) struct NetworkStep<'a> {
    /// All vehicles on the road, by ascending number.
    pub records: &'a [NetworkRecord],
    departures: &'a [RawDeparture],
    /// Numbers of those that have gone, ascending.
    pub arrivals: &'a [u32],
    /// States of all signals, one after the other, a letter a link.
    pub signals: &'a [u8],
    /// Where each signal's begin; one more at the end.
    pub signal_starts: &'a [u32],
}

/// C's array; of none there may be no address.
///
/// # Safety
/// The address is that of so many, and they stand for the life of the result.
unsafe fn array<'a, T>(first: *const T, count: usize) -> &'a [T] {
    if count == 0 { &[] } else { unsafe { slice::from_raw_parts(first, count) } }
}

impl<'a> NetworkStep<'a> {
    /// Those that have come, by ascending number.
    pub fn departures(&self) -> impl Iterator<Item = NetworkDeparture<'a>> {
        // SAFETY: the shim sets all names, and they stand as long as the step does.
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

/// A simulation of a network; it ends when dropped.
pub(super) struct NetworkShim {
    pub shim: Shim,
}

// SAFETY of all calls below: as in shim.rs.
impl NetworkShim {
    /// Takes a simulation that has just begun. `lateral`: changes of lanes take time. `first`: number of the first vehicle.
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

    /// Puts a vehicle on a lane at once; its number.
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

    /// From now on somebody drives this vehicle of the demand. The edges of its route.
    pub fn take(&mut self, number: u32) -> Result<Vec<String>, TrafficError> {
        let mut edges: Text = ptr::null();
        let code = unsafe { (self.shim.api.network.take)(number, &raw mut edges) };
        self.shim.check(code)?;
        // SAFETY: set by a call that succeeded, and read before the next.
        let edges = unsafe { CStr::from_ptr(edges) }.to_string_lossy();
        Ok(edges.split(' ').map(str::to_owned).collect())
    }

    /// The commands, one step of this length, and what it has changed.
    pub fn step(&mut self, commands: &[NetworkCommand], step_s: f64) -> Result<NetworkStep<'_>, TrafficError> {
        let mut raw = RawStep::default();
        let code = unsafe { (self.shim.api.network.step)(commands.as_ptr(), commands.len(), step_s, &raw mut raw) };
        self.shim.check(code)?;
        Ok(Self::seen(&raw))
    }

    /// Everything as it is, without a step.
    pub fn look(&mut self) -> Result<NetworkStep<'_>, TrafficError> {
        let mut raw = RawStep::default();
        let code = unsafe { (self.shim.api.network.look)(&raw mut raw) };
        self.shim.check(code)?;
        Ok(Self::seen(&raw))
    }

    /// What the shim has told. It stands until the next call, which needs `&mut self`.
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
