//! Data that pass between this program and `shim.cpp`. In: [`Command`]s. Out: [`Step`]: what a step has changed, as columns of C.

use crate::{map::network::LaneId, traffic::VehicleId};
use glam::DVec2;
use std::{
    ffi::{CStr, c_char},
    ptr, slice,
};

/// A text of C, ended by a zero byte.
pub(super) type Text = *const c_char;

/// An order to SUMO for one vehicle, carried out before the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Command {
    /// Puts the vehicle's front bumper there, heading by the compass; on this lane where it is known, as lanes cross.
    MoveToXy {
        /// Lane, where it is known: lanes cross.
        lane: Option<LaneId>,
        /// Position of the front bumper, network axes, m.
        front: DVec2,
        /// Heading, degrees clockwise from north.
        angle_deg: f64,
    },
    /// Present speed for the vehicle's model and its followers, m/s.
    PreviousSpeed(f64),
    /// Speed without regard to others until further notice, m/s; `None` gives the vehicle back to its model.
    ImposedSpeed(Option<f64>),
    /// Highest speed from now on, m/s.
    MaxSpeed(f64),
    /// Speed that the vehicle's driver wants until further notice, m/s: the vehicle takes it as far as others and signals allow. `None` is the one of
    /// its model.
    WantedSpeed(Option<f64>),
    /// SUMO's bits of lamps.
    Lamps(u32),
}

/// A [`Command`] as C takes it; the kinds are numbered as in shim_data.hpp.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(super) struct RawCommand {
    vehicle: u32,
    kind: u32,
    lane: i32,
    a: f64,
    b: f64,
    c: f64,
}

impl Command {
    /// The command for one vehicle in C's layout.
    pub fn encode(self, vehicle: VehicleId) -> RawCommand {
        let (kind, lane, [a, b, c]) = match self {
            Self::MoveToXy { lane, front, angle_deg } => {
                (0, lane.map_or(-1, |lane| lane.index() as i32), [front.x, front.y, angle_deg])
            }
            Self::PreviousSpeed(speed_mps) => (1, -1, [speed_mps, 0.0, 0.0]),
            // A negative speed ends the order.
            Self::ImposedSpeed(speed_mps) => (2, -1, [speed_mps.unwrap_or(-1.0), 0.0, 0.0]),
            Self::MaxSpeed(speed_mps) => (3, -1, [speed_mps, 0.0, 0.0]),
            Self::WantedSpeed(speed_mps) => (5, -1, [speed_mps.unwrap_or(-1.0), 0.0, 0.0]),
            Self::Lamps(bits) => (4, -1, [bits.into(), 0.0, 0.0]),
        };
        RawCommand { vehicle: vehicle.0, kind, lane, a, b, c }
    }
}

/// One vehicle after a step. Of a fixed population `x` to `angle_deg`, `lateral_m` and `lamps` are not read.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(super) struct Record {
    /// Position of the front bumper, network axes, m.
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
    /// SUMO's bits of lamps that are lit.
    pub lamps: u32,
}

/// A vehicle that has come. The names are C's until the next call.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(super) struct RawDeparture {
    length_m: f64,
    width_m: f64,
    height_m: f64,
    number: u32,
    id: Text,
    class: Text,
    kind: Text,
}

/// See [`Step`]; C's until the next call.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(super) struct RawStep {
    records: *const Record,
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

/// A type of vehicle, in SUMO's terms.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct VehicleType {
    pub length_m: f64,
    pub width_m: f64,
    pub accel_mps2: f64,
    pub decel_mps2: f64,
    pub emergency_decel_mps2: f64,
    pub time_gap_s: f64,
    pub min_gap_m: f64,
    pub max_speed_mps: f64,
}

/// Settings for reading a simulation.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(super) struct Reading {
    /// Number of the first vehicle.
    pub first_number: u32,
    /// 1: no vehicle comes or goes, and all keep to the middle of their lanes.
    pub is_fixed: u32,
    /// 1: changes of lanes take time.
    pub lateral: u32,
}

/// C's array; an empty one may have no address.
///
/// # Safety
/// The address is that of so many, and they stand for the life of the result.
unsafe fn array<'a, T>(first: *const T, count: usize) -> &'a [T] {
    if count == 0 { &[] } else { unsafe { slice::from_raw_parts(first, count) } }
}

/// A vehicle that has come.
#[derive(Clone, Copy, Debug)]
pub(super) struct NewDeparture<'a> {
    pub number: u32,
    pub length_m: f64,
    pub width_m: f64,
    pub height_m: f64,
    /// SUMO's name of it.
    pub name: &'a CStr,
    /// SUMO's class: passenger, truck and so on.
    pub class: &'a CStr,
    /// Type by SUMO's name.
    pub kind: &'a CStr,
}

/// Columns of a step.
pub(super) struct Step<'a> {
    /// All vehicles on the road, by ascending number.
    pub records: &'a [Record],
    departures: &'a [RawDeparture],
    /// Numbers of those that have gone, ascending.
    pub arrivals: &'a [u32],
    /// States of all signals, one after the other, a letter a link.
    pub signals: &'a [u8],
    /// Start of each signal's states; one more at the end.
    pub signal_starts: &'a [u32],
}

impl<'a> Step<'a> {
    /// The columns that the shim has filled. They stand until the next call, which needs `&mut` of the [`Shim`].
    ///
    /// # Safety
    /// A call of the shim has filled `raw` and none has followed.
    pub unsafe fn of(raw: &RawStep) -> Self {
        unsafe {
            let signal_starts: &[u32] = array(raw.signal_starts, raw.signal_count + 1);
            Self {
                records: array(raw.records, raw.record_count),
                departures: array(raw.departures, raw.departure_count),
                arrivals: array(raw.arrivals, raw.arrival_count),
                signals: array(raw.signals.cast(), signal_starts.last().map_or(0, |end| *end as usize)),
                signal_starts,
            }
        }
    }

    /// Vehicles that have come, by ascending number.
    pub fn departures(&self) -> impl Iterator<Item = NewDeparture<'a>> {
        // SAFETY: the shim sets all names, and they stand as long as the step does.
        let text = |text: Text| unsafe { CStr::from_ptr(text) };
        self.departures.iter().map(move |raw| NewDeparture {
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
