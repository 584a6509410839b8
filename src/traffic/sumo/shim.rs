//! The C interface of `shim.cpp`, opened at run time. In: names, numbers and commands. Out: what a step has changed, as columns that stand
//! until the next call, or SUMO's message. A [`Shim`] is the right to use SUMO in this process: there is one at a time.

use super::{
    locate,
    shim_data::{RawCommand, RawDeparture, RawStep, Reading, Record, Step, Text, VehicleType},
};
use crate::{
    idm::IdmParams,
    map::network::LaneId,
    space::SumoPose,
    traffic::{Leader, TrafficError, TrafficOrder, VehicleId, go_on, starts_under_way},
};
use glam::DVec2;
use std::{
    env,
    ffi::{CStr, CString, c_int},
    path::Path,
    ptr,
    sync::{
        OnceLock,
        atomic::{AtomicBool, Ordering},
    },
    thread::sleep,
    time::Duration,
};

/// Version and sizes on which both sides have to agree before any other call.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Interface {
    /// Raised with every change of a function or of a structure; as `INTERFACE` in shim_data.hpp.
    number: u32,
    command_bytes: u32,
    record_bytes: u32,
    departure_bytes: u32,
    vehicle_type_bytes: u32,
}

impl Interface {
    /// Interface of this program.
    const OWN: Self = Self {
        number: 13,
        command_bytes: size_of::<RawCommand>() as u32,
        record_bytes: size_of::<Record>() as u32,
        departure_bytes: size_of::<RawDeparture>() as u32,
        vehicle_type_bytes: size_of::<VehicleType>() as u32,
    };

    /// Fails if the library at `path` is not the one of this program: one of another version may lie beside it.
    fn check(self, path: &Path) -> Result<(), TrafficError> {
        if self == Self::OWN {
            return Ok(());
        }
        Err(TrafficError::Absent(format!(
            "{} is of another version of codrive; put the one there that comes with this program, or remove it",
            path.display()
        )))
    }
}

type Texts = *const Text;

/// The functions of the shim; `_library` keeps them loaded. Never unloaded: SUMO's libraries have static state.
struct Api {
    error: unsafe extern "C" fn() -> Text,
    start: unsafe extern "C" fn(Texts, usize) -> c_int,
    close: unsafe extern "C" fn() -> c_int,
    version: unsafe extern "C" fn(*mut Text) -> c_int,
    number: unsafe extern "C" fn(Texts, usize, Texts, usize, *const Reading) -> c_int,
    lane: unsafe extern "C" fn(usize, *mut f64, *mut f64) -> c_int,
    lane_count: unsafe extern "C" fn(*mut usize) -> c_int,
    lane_text: unsafe extern "C" fn(usize, *mut Text) -> c_int,
    close_lane: unsafe extern "C" fn(usize) -> c_int,
    vehicle_type: unsafe extern "C" fn(Text, Text, *const VehicleType) -> c_int,
    person: unsafe extern "C" fn(u32, f64, f64, f64, f64) -> c_int,
    leader: unsafe extern "C" fn(u32, f64, *mut u32, *mut f64, *mut f64) -> c_int,
    route: unsafe extern "C" fn(Text, Texts, usize) -> c_int,
    add: unsafe extern "C" fn(Text, Text, Text, usize, f64, f64, c_int, *mut u32) -> c_int,
    take: unsafe extern "C" fn(u32, *mut Text) -> c_int,
    take_pedals: unsafe extern "C" fn(u32, *mut Text) -> c_int,
    names: unsafe extern "C" fn(u32, *mut Text) -> c_int,
    take_over_by_event: unsafe extern "C" fn(u32) -> c_int,
    give_back: unsafe extern "C" fn(u32) -> c_int,
    change_lane: unsafe extern "C" fn(u32, c_int, f64, bool) -> c_int,
    set_route: unsafe extern "C" fn(u32, Texts, usize) -> c_int,
    set_phase: unsafe extern "C" fn(usize, u32) -> c_int,
    set_state: unsafe extern "C" fn(usize, Text) -> c_int,
    set_speed: unsafe extern "C" fn(u32, f64, f64) -> c_int,
    set_max_speed: unsafe extern "C" fn(u32, f64) -> c_int,
    set_speed_mode: unsafe extern "C" fn(u32, u32) -> c_int,
    step: unsafe extern "C" fn(*const RawCommand, usize, f64, *mut RawStep) -> c_int,
    look: unsafe extern "C" fn(*mut RawStep) -> c_int,
    bare_step: unsafe extern "C" fn() -> c_int,
    pose: unsafe extern "C" fn(u32, *mut f64, *mut f64, *mut f64) -> c_int,
    _library: libloading::Library,
    /// libsumocpp itself, loaded first from where SUMO is now.
    _sumo: libloading::Library,
}

static LOADED: OnceLock<Api> = OnceLock::new();
static BUSY: AtomicBool = AtomicBool::new(false);

/// Opens a library without putting its hundred relatives in the global scope, where Mesa would bind to them.
fn open(path: &Path) -> Result<libloading::Library, TrafficError> {
    // SAFETY: SUMO's libraries and our shim run no code at load time that asks anything of the caller.
    #[cfg(unix)]
    let library = unsafe {
        use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
        Library::open(Some(path), RTLD_NOW | RTLD_LOCAL).map(libloading::Library::from)
    };
    #[cfg(not(unix))]
    let library = unsafe { libloading::Library::new(path) };
    library.map_err(|error| TrafficError::Absent(format!("{}: {error}", path.display())))
}

impl Api {
    fn load(home: &Path) -> Result<Self, TrafficError> {
        let sumo = open(&locate::library(home)?)?;
        let path = locate::shim()?;
        let library = open(&path)?;
        macro_rules! symbol {
            ($name:literal) => {
                // SAFETY: the types above are those of the shim, which build.rs compiled with this program.
                *unsafe { library.get($name) }
                    .map_err(|error| TrafficError::Absent(format!("{}: {error}", path.display())))?
            };
        }
        let mut found = Interface::default();
        // SAFETY: as above; a shim without this function leaves a value that agrees with nothing.
        if let Ok(interface) = unsafe { library.get::<unsafe extern "C" fn(*mut Interface)>(b"cs_interface\0") } {
            unsafe { interface(&mut found) };
        }
        found.check(&path)?;
        Ok(Self {
            error: symbol!(b"cs_error\0"),
            start: symbol!(b"cs_start\0"),
            close: symbol!(b"cs_close\0"),
            version: symbol!(b"cs_version\0"),
            number: symbol!(b"cs_number\0"),
            lane: symbol!(b"cs_lane\0"),
            lane_count: symbol!(b"cs_lane_count\0"),
            lane_text: symbol!(b"cs_lane_text\0"),
            close_lane: symbol!(b"cs_close_lane\0"),
            vehicle_type: symbol!(b"cs_type\0"),
            person: symbol!(b"cs_person\0"),
            leader: symbol!(b"cs_leader\0"),
            route: symbol!(b"cs_route\0"),
            add: symbol!(b"cs_add\0"),
            take: symbol!(b"cs_take\0"),
            take_pedals: symbol!(b"cs_take_pedals\0"),
            names: symbol!(b"cs_names\0"),
            take_over_by_event: symbol!(b"cs_take_over\0"),
            give_back: symbol!(b"cs_give_back\0"),
            change_lane: symbol!(b"cs_change_lane\0"),
            set_route: symbol!(b"cs_set_route\0"),
            set_phase: symbol!(b"cs_set_phase\0"),
            set_state: symbol!(b"cs_set_state\0"),
            set_speed: symbol!(b"cs_set_speed\0"),
            set_max_speed: symbol!(b"cs_set_max_speed\0"),
            set_speed_mode: symbol!(b"cs_set_speed_mode\0"),
            step: symbol!(b"cs_step\0"),
            look: symbol!(b"cs_look\0"),
            bare_step: symbol!(b"cs_bare_step\0"),
            pose: symbol!(b"cs_pose\0"),
            _library: library,
            _sumo: sumo,
        })
    }
}

/// Text without a zero byte; one inside is dropped, which no name of a file or lane has.
fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', "")).expect("no zero byte is left")
}

fn with_texts<T>(texts: &[String], call: impl FnOnce(Texts, usize) -> T) -> T {
    let owned: Vec<CString> = texts.iter().map(|text| c_text(text)).collect();
    let pointers: Vec<Text> = owned.iter().map(|text| text.as_ptr()).collect();
    call(pointers.as_ptr(), pointers.len())
}

/// The right to use the library; given back when dropped.
pub(super) struct Shim {
    api: &'static Api,
}

// SAFETY of all calls below: pointers are valid for the call, `Shim` is not shared between threads (it is used through
// `&mut`, and only one exists for a library), and no exception leaves shim.cpp.
impl Shim {
    /// Takes the library from the SUMO at `home`.
    pub fn open(home: &Path) -> Result<Self, TrafficError> {
        locate::library(home)?;
        while BUSY.swap(true, Ordering::Acquire) {
            // Another start that was given up lets go of it once SUMO has read its files.
            if starts_under_way() < 2 {
                return Err(TrafficError::Busy);
            }
            go_on()?;
            sleep(Duration::from_millis(10));
        }
        if LOADED.get().is_none() {
            match Api::load(home) {
                Ok(api) => drop(LOADED.set(api)),
                Err(error) => {
                    BUSY.store(false, Ordering::Release);
                    return Err(error);
                }
            }
        }
        Ok(Self { api: LOADED.get().expect("set above") })
    }

    fn check(&self, code: c_int) -> Result<(), TrafficError> {
        if code == 0 {
            return Ok(());
        }
        // SAFETY: see above; the text stays until the next failing call.
        let message = unsafe { CStr::from_ptr((self.api.error)()) }.to_string_lossy();
        Err(TrafficError::Sumo(message.trim().to_string()))
    }

    fn text(&self, get: impl FnOnce(*mut Text) -> c_int) -> Result<String, TrafficError> {
        let mut text: Text = ptr::null();
        let code = get(&mut text);
        self.check(code)?;
        // SAFETY: see above; set by a call that succeeded, and read before the next.
        Ok(unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned())
    }

    /// Begins a simulation in this process; options as on SUMO's command line.
    pub fn start(&mut self, options: &[String]) -> Result<(), TrafficError> {
        let mut all = vec!["sumo".to_string()];
        all.extend_from_slice(options);
        read_slowly();
        self.check(with_texts(&all, |texts, n| unsafe { (self.api.start)(texts, n) }))?;
        // It reads its files without asking.
        go_on()
    }

    /// Returns SUMO's version, as it names itself.
    pub fn version(&self) -> Result<String, TrafficError> {
        self.text(|out| unsafe { (self.api.version)(out) })
    }

    /// Numbers lanes and signals in the order given, and says how the simulation is read.
    pub fn number(&mut self, lanes: &[String], signals: &[String], reading: Reading) -> Result<(), TrafficError> {
        let number = self.api.number;
        let code = with_texts(lanes, |lanes, n| {
            with_texts(signals, |signals, m| unsafe { number(lanes, n, signals, m, &raw const reading) })
        });
        self.check(code)
    }

    /// Returns length, m, and speed limit, m/s, of a lane as SUMO has them.
    pub fn lane(&self, lane: LaneId) -> Result<(f64, f64), TrafficError> {
        let (mut length_m, mut speed_mps) = (0.0, 0.0);
        self.check(unsafe { (self.api.lane)(lane.index(), &raw mut length_m, &raw mut speed_mps) })?;
        Ok((length_m, speed_mps))
    }

    /// Returns the number of SUMO's lanes, with those inside junctions.
    pub fn lane_count(&self) -> Result<usize, TrafficError> {
        let mut count = 0;
        self.check(unsafe { (self.api.lane_count)(&raw mut count) })?;
        Ok(count)
    }

    /// Returns the classes that may not use a lane, and a line for each of its connections: lane beyond, lane inside the junction and
    /// direction, separated by tabs.
    pub fn lane_text(&self, lane: LaneId) -> Result<String, TrafficError> {
        self.text(|out| unsafe { (self.api.lane_text)(lane.index(), out) })
    }

    /// Closes a lane to passenger cars in this simulation.
    pub fn close_lane(&mut self, lane: LaneId) -> Result<(), TrafficError> {
        self.check(unsafe { (self.api.close_lane)(lane.index()) })
    }

    /// Makes a vehicle type.
    pub fn add_type(&mut self, base: &str, name: &str, values: &VehicleType) -> Result<(), TrafficError> {
        let (base, name) = (c_text(base), c_text(name));
        self.check(unsafe { (self.api.vehicle_type)(base.as_ptr(), name.as_ptr(), values) })
    }

    /// Gives a vehicle the numbers of its driver; the rest of its type stays.
    pub fn set_driver(&mut self, id: VehicleId, idm: &IdmParams) -> Result<(), TrafficError> {
        self.check(unsafe { (self.api.person)(id.0, idm.a, idm.b, idm.t, idm.s0) })
    }

    /// Returns the leader of a vehicle; `None` without one within `reach_m`.
    pub fn leader(&self, id: VehicleId, reach_m: f64) -> Result<Option<Leader>, TrafficError> {
        let (mut number, mut gap_m, mut speed_mps) = (0, f64::INFINITY, 0.0);
        let out = (&raw mut number, &raw mut gap_m, &raw mut speed_mps);
        self.check(unsafe { (self.api.leader)(id.0, reach_m, out.0, out.1, out.2) })?;
        Ok(gap_m.is_finite().then_some(Leader { id: VehicleId(number), gap_m, speed_mps }))
    }

    /// Makes a route of edges.
    pub fn add_route(&mut self, id: &str, edges: &[String]) -> Result<(), TrafficError> {
        let id = c_text(id);
        self.check(with_texts(edges, |texts, n| unsafe { (self.api.route)(id.as_ptr(), texts, n) }))
    }

    /// Puts a vehicle (its name, route and type) on a lane at once, m and m/s; its number. `keeps_lane`: SUMO's model drives it there;
    /// otherwise a driver outside SUMO moves it along its route.
    pub fn add(
        &mut self,
        (id, route, kind): (&str, &str, &str),
        lane: LaneId,
        position_m: f64,
        speed_mps: f64,
        keeps_lane: bool,
    ) -> Result<VehicleId, TrafficError> {
        let (id, route, kind) = (c_text(id), c_text(route), c_text(kind));
        let names = (id.as_ptr(), route.as_ptr(), kind.as_ptr());
        let mut number = 0;
        let (lane, keeps_lane) = (lane.index(), c_int::from(keeps_lane));
        let add = self.api.add;
        self.check(unsafe {
            add(names.0, names.1, names.2, lane, position_m, speed_mps, keeps_lane, &raw mut number)
        })?;
        Ok(VehicleId(number))
    }

    /// Makes a vehicle of the demand one that a driver outside SUMO moves from now on. The edges of its route.
    pub fn take(&mut self, id: VehicleId) -> Result<Vec<String>, TrafficError> {
        let edges = self.text(|out| unsafe { (self.api.take)(id.0, out) })?;
        Ok(edges.split(' ').map(str::to_owned).collect())
    }

    /// Gives the pedals of a vehicle of the demand to a driver outside SUMO, who may leave its limits of acceleration. The edges of its route.
    pub fn take_pedals(&mut self, id: VehicleId) -> Result<Vec<String>, TrafficError> {
        let edges = self.text(|out| unsafe { (self.api.take_pedals)(id.0, out) })?;
        Ok(edges.split(' ').map(str::to_owned).collect())
    }

    /// Returns the name of a vehicle in the demand, and that of its type.
    pub fn names(&self, id: VehicleId) -> Result<[String; 2], TrafficError> {
        let names = self.text(|out| unsafe { (self.api.names)(id.0, out) })?;
        let (name, kind) = names.split_once('\n').unwrap_or((&names, ""));
        // A vehicle with a number of its own, such as a highest speed, has a type of its own: "TYPE@NAME".
        let kind = kind.strip_suffix(&format!("@{name}")).unwrap_or(kind);
        Ok([name.to_owned(), kind.to_owned()])
    }

    /// Carries out an order, from the next step on. SUMO has changed nothing if it refuses one.
    pub fn order(&mut self, order: &TrafficOrder) -> Result<(), TrafficError> {
        let api = &self.api;
        let code = match order {
            TrafficOrder::ChangeLane { id, to_the_left, duration_s, keeps_gaps } => unsafe {
                (api.change_lane)(id.0, *to_the_left, *duration_s, *keeps_gaps)
            },
            TrafficOrder::Route { id, edges } => {
                with_texts(edges, |texts, n| unsafe { (api.set_route)(id.0, texts, n) })
            }
            TrafficOrder::Phase { signal, phase } => unsafe { (api.set_phase)(signal.index(), *phase) },
            TrafficOrder::State { signal, letters } => {
                let letters = c_text(letters);
                unsafe { (api.set_state)(signal.index(), letters.as_ptr()) }
            }
            TrafficOrder::Speed { id, speed_mps, duration_s } => unsafe {
                (api.set_speed)(id.0, *speed_mps, *duration_s)
            },
            TrafficOrder::MaxSpeed { id, speed_mps } => unsafe { (api.set_max_speed)(id.0, *speed_mps) },
            TrafficOrder::TakeOver { id } => unsafe { (api.take_over_by_event)(id.0) },
            TrafficOrder::GiveBack { id } => unsafe { (api.give_back)(id.0) },
            TrafficOrder::SpeedMode { id, mode } => unsafe { (api.set_speed_mode)(id.0, *mode) },
        };
        self.check(code)
    }

    /// Carries out the commands and makes one step of this length, s; returns its changes.
    pub fn step(&mut self, commands: &[RawCommand], step_s: f64) -> Result<Step<'_>, TrafficError> {
        let mut raw = RawStep::default();
        self.check(unsafe { (self.api.step)(commands.as_ptr(), commands.len(), step_s, &raw mut raw) })?;
        Ok(unsafe { Step::of(&raw) })
    }

    /// Reads everything without a step.
    pub fn look(&mut self) -> Result<Step<'_>, TrafficError> {
        let mut raw = RawStep::default();
        self.check(unsafe { (self.api.look)(&raw mut raw) })?;
        Ok(unsafe { Step::of(&raw) })
    }

    /// Makes a step and reads nothing.
    pub fn bare_step(&mut self) -> Result<(), TrafficError> {
        self.check(unsafe { (self.api.bare_step)() })
    }

    /// Returns the place at which SUMO itself draws a vehicle.
    pub fn pose(&self, id: VehicleId) -> Result<SumoPose, TrafficError> {
        let mut pose = SumoPose { front: DVec2::ZERO, angle_deg: 0.0 };
        let (x, y) = (&raw mut pose.front.x, &raw mut pose.front.y);
        self.check(unsafe { (self.api.pose)(id.0, x, y, &raw mut pose.angle_deg) })?;
        Ok(pose)
    }
}

/// For tests: SUMO reads for as many seconds as `CODRIVE_SUMO_READS_S` says, deaf as it is. Release builds do not look.
fn read_slowly() {
    if cfg!(debug_assertions)
        && let Some(seconds) = env::var("CODRIVE_SUMO_READS_S").ok().and_then(|text| text.parse().ok())
    {
        sleep(Duration::from_secs_f64(seconds));
    }
}

impl Drop for Shim {
    fn drop(&mut self) {
        // A failure can be told to no caller.
        unsafe { (self.api.close)() };
        BUSY.store(false, Ordering::Release);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_library_of_another_version_is_refused_by_name() {
        let path = Path::new("/opt/codrive/libcodrive_sumo.so");
        assert!(Interface::OWN.check(path).is_ok());
        let before = Interface { number: 0, ..Interface::OWN };
        let grown = Interface { record_bytes: Interface::OWN.record_bytes + 8, ..Interface::OWN };
        for other in [Interface::default(), before, grown] {
            let text = other.check(path).expect_err("another version").to_string();
            assert!(text.contains("/opt/codrive/libcodrive_sumo.so is of another version of codrive"), "{text}");
        }
    }
}
