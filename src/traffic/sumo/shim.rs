//! The C interface of `shim.cpp` and `network_shim.cpp`, loaded at run time. In: names, numbers and commands. Out: records, or SUMO's
//! message. A [`Shim`] is the right to use SUMO in this process; only one exists at a time.

use super::{locate, network_shim::NetworkApi};
use crate::{
    space::SumoPose,
    traffic::{TrafficError, go_on, starts_under_way},
};
use glam::DVec2;
use std::{
    env,
    ffi::{CStr, CString, c_char, c_int},
    path::Path,
    sync::{
        OnceLock,
        atomic::{AtomicBool, Ordering},
    },
    thread::sleep,
    time::Duration,
};

/// Kinds of commands for a vehicle before the step; numbered as in shim.cpp.
#[repr(u32)]
#[derive(Clone, Copy, Debug)]
pub(super) enum CommandKind {
    /// `a`, `b`: front bumper, metres; `c`: compass degrees.
    MoveToXy = 0,
    /// `a`: speed that the model and followers take as the present one, m/s.
    PreviousSpeed = 1,
    /// `a`: speed imposed until further notice, m/s; below 0 ends it.
    Speed = 2,
    /// `a`: SUMO's speed mode.
    SpeedMode = 3,
    /// `a`: maximum speed from now on, m/s.
    MaxSpeed = 4,
}

/// Command for one vehicle, with the layout of shim.cpp.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(super) struct Command {
    pub car: u32,
    pub kind: CommandKind,
    pub a: f64,
    pub b: f64,
    pub c: f64,
}

/// State of one vehicle after a step, with the layout of shim.cpp.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Record {
    pub speed_mps: f64,
    pub lane_pos_m: f64,
    /// Index in the table of lanes, -1 if the vehicle is on none of them.
    pub lane: i32,
    /// 0 if the vehicle is no longer in the simulation.
    pub present: u32,
}

/// Vehicle type in SUMO's terms, with the layout of shim.cpp.
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

/// Version and structure sizes of the interface, which both sides must share before any other call.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Interface {
    /// Number of the interface, raised with every change of a function or of a structure; `INTERFACE` in shim.cpp.
    number: u32,
    command_bytes: u32,
    record_bytes: u32,
    vehicle_type_bytes: u32,
}

impl Interface {
    /// Interface that this program expects.
    const OWN: Self = Self {
        number: 5,
        command_bytes: size_of::<Command>() as u32,
        record_bytes: size_of::<Record>() as u32,
        vehicle_type_bytes: size_of::<VehicleType>() as u32,
    };

    /// Checks that the library at `path` belongs to this program: one of another version may lie beside it.
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

pub(super) type Text = *const c_char;
pub(super) type Texts = *const *const c_char;

/// Functions of the shim; `_library` keeps them loaded. They are never unloaded, because SUMO's libraries have static state.
pub(super) struct Api {
    error: unsafe extern "C" fn() -> Text,
    start: unsafe extern "C" fn(Texts, usize) -> c_int,
    close: unsafe extern "C" fn() -> c_int,
    version: unsafe extern "C" fn(*mut Text) -> c_int,
    lanes: unsafe extern "C" fn(Texts, usize) -> c_int,
    lane: unsafe extern "C" fn(usize, *mut f64, *mut f64) -> c_int,
    close_lanes: unsafe extern "C" fn(Texts, usize) -> c_int,
    vehicle_type: unsafe extern "C" fn(Text, Text, *const VehicleType) -> c_int,
    route: unsafe extern "C" fn(Text, Texts, usize) -> c_int,
    add: unsafe extern "C" fn(Text, Text, Text, usize, f64, f64) -> c_int,
    frame: unsafe extern "C" fn(*const Command, usize, f64, *mut Record) -> c_int,
    bare_step: unsafe extern "C" fn() -> c_int,
    read: unsafe extern "C" fn(*mut Record) -> c_int,
    pose: unsafe extern "C" fn(u32, *mut f64, *mut f64, *mut f64) -> c_int,
    pub(super) network: NetworkApi,
    _library: libloading::Library,
    /// The library libsumocpp, loaded before the shim from SUMO's present folder.
    _sumo: libloading::Library,
}

static LOADED: OnceLock<Api> = OnceLock::new();
static BUSY: AtomicBool = AtomicBool::new(false);

/// Right to use the library, released on drop.
pub(super) struct Shim {
    pub(super) api: &'static Api,
    cars: usize,
}

/// Opens a library without adding the symbols of its hundred dependencies to the global scope, where Mesa would bind to them.
fn open(path: &Path) -> Result<libloading::Library, TrafficError> {
    // SAFETY: the load-time code of SUMO's libraries and of the shim requires nothing of the caller.
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
        // SAFETY: as above. An old shim without this function leaves `found` at zeros, which match nothing.
        if let Ok(interface) = unsafe { library.get::<unsafe extern "C" fn(*mut Interface)>(b"cs_interface\0") } {
            unsafe { interface(&mut found) };
        }
        found.check(&path)?;
        Ok(Self {
            error: symbol!(b"cs_error\0"),
            start: symbol!(b"cs_start\0"),
            close: symbol!(b"cs_close\0"),
            version: symbol!(b"cs_version\0"),
            lanes: symbol!(b"cs_lanes\0"),
            lane: symbol!(b"cs_lane\0"),
            close_lanes: symbol!(b"cs_close_lanes\0"),
            vehicle_type: symbol!(b"cs_type\0"),
            route: symbol!(b"cs_route\0"),
            add: symbol!(b"cs_add\0"),
            frame: symbol!(b"cs_frame\0"),
            bare_step: symbol!(b"cs_bare_step\0"),
            read: symbol!(b"cs_read\0"),
            pose: symbol!(b"cs_pose\0"),
            network: NetworkApi {
                begin: symbol!(b"cs_network_begin\0"),
                add: symbol!(b"cs_network_add\0"),
                take: symbol!(b"cs_network_take\0"),
                step: symbol!(b"cs_network_step\0"),
                look: symbol!(b"cs_network_look\0"),
                end: symbol!(b"cs_network_end\0"),
            },
            _library: library,
            _sumo: sumo,
        })
    }
}

/// Converts a text to a C string. Zero bytes are removed; no name of a file or lane has one.
pub(super) fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', "")).expect("no zero byte is left")
}

pub(super) fn with_texts<T>(texts: &[String], call: impl FnOnce(Texts, usize) -> T) -> T {
    let owned: Vec<CString> = texts.iter().map(|text| c_text(text)).collect();
    let pointers: Vec<Text> = owned.iter().map(|text| text.as_ptr()).collect();
    call(pointers.as_ptr(), pointers.len())
}

// SAFETY of all calls below: pointers are valid for the call, `Shim` is not shared between threads (it is used through
// `&mut`, and only one exists for a library), and no exception leaves shim.cpp.
impl Shim {
    /// Takes the right to use SUMO and loads the library from the SUMO at `home`.
    pub fn open(home: &Path) -> Result<Self, TrafficError> {
        locate::library(home)?;
        while BUSY.swap(true, Ordering::Acquire) {
            // An abandoned start releases the library once SUMO has read its files.
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
        Ok(Self { api: LOADED.get().expect("set above"), cars: 0 })
    }

    pub(super) fn check(&self, code: c_int) -> Result<(), TrafficError> {
        if code == 0 {
            return Ok(());
        }
        // SAFETY: see above; the text stays until the next failing call.
        let message = unsafe { CStr::from_ptr((self.api.error)()) }.to_string_lossy();
        Err(TrafficError::Sumo(message.trim().to_string()))
    }

    fn text(&self, get: impl FnOnce(*mut Text) -> c_int) -> Result<String, TrafficError> {
        let mut text: Text = std::ptr::null();
        let code = get(&mut text);
        self.check(code)?;
        // SAFETY: see above; set by a call that succeeded.
        Ok(unsafe { CStr::from_ptr(text) }.to_string_lossy().into_owned())
    }

    /// Starts a simulation in this process; options as on SUMO's command line.
    pub fn start(&mut self, options: &[String]) -> Result<(), TrafficError> {
        let mut all = vec!["sumo".to_string()];
        all.extend_from_slice(options);
        self.cars = 0;
        read_slowly();
        self.check(with_texts(&all, |texts, n| unsafe { (self.api.start)(texts, n) }))?;
        // SUMO does not check for an interruption while it reads its files.
        go_on()
    }

    /// Returns SUMO's version, as SUMO states it.
    pub fn version(&self) -> Result<String, TrafficError> {
        self.text(|out| unsafe { (self.api.version)(out) })
    }

    /// Numbers the lanes in this order.
    pub fn set_lanes(&mut self, ids: &[String]) -> Result<(), TrafficError> {
        self.check(with_texts(ids, |texts, n| unsafe { (self.api.lanes)(texts, n) }))
    }

    /// Returns length, metres, and speed limit, m/s, of a lane by its number.
    pub fn lane(&self, lane: usize) -> Result<(f64, f64), TrafficError> {
        let (mut length_m, mut speed_mps) = (0.0, 0.0);
        self.check(unsafe { (self.api.lane)(lane, &mut length_m, &mut speed_mps) })?;
        Ok((length_m, speed_mps))
    }

    /// Closes lanes to passenger cars in this simulation.
    pub fn close_lanes(&mut self, ids: &[String]) -> Result<(), TrafficError> {
        self.check(with_texts(ids, |texts, n| unsafe { (self.api.close_lanes)(texts, n) }))
    }

    /// Creates a vehicle type from `base` with these values.
    pub fn add_type(&mut self, base: &str, name: &str, values: &VehicleType) -> Result<(), TrafficError> {
        let (base, name) = (c_text(base), c_text(name));
        self.check(unsafe { (self.api.vehicle_type)(base.as_ptr(), name.as_ptr(), values) })
    }

    /// Creates a route along these edges.
    pub fn add_route(&mut self, id: &str, edges: &[String]) -> Result<(), TrafficError> {
        let id = c_text(id);
        self.check(with_texts(edges, |texts, n| unsafe { (self.api.route)(id.as_ptr(), texts, n) }))
    }

    /// Puts the next vehicle on the road: lane by number, position in metres, speed in m/s.
    pub fn add_car(
        &mut self,
        (id, route, kind): (&str, &str, &str),
        lane: usize,
        position_m: f64,
        speed_mps: f64,
    ) -> Result<(), TrafficError> {
        let (id, route, kind) = (c_text(id), c_text(route), c_text(kind));
        let code = unsafe { (self.api.add)(id.as_ptr(), route.as_ptr(), kind.as_ptr(), lane, position_m, speed_mps) };
        self.check(code)?;
        self.cars += 1;
        Ok(())
    }

    /// Executes the commands and one step, and reads all vehicles in the order in which they were added.
    ///
    /// # Panics
    /// If the length of `records` is not the number of vehicles.
    pub fn frame(&mut self, commands: &[Command], step_s: f64, records: &mut [Record]) -> Result<(), TrafficError> {
        assert_eq!(records.len(), self.cars);
        self.check(unsafe { (self.api.frame)(commands.as_ptr(), commands.len(), step_s, records.as_mut_ptr()) })
    }

    /// Reads all vehicles without a step. Panics as [`Shim::frame`].
    pub fn read(&mut self, records: &mut [Record]) -> Result<(), TrafficError> {
        assert_eq!(records.len(), self.cars);
        self.check(unsafe { (self.api.read)(records.as_mut_ptr()) })
    }

    /// Returns the pose at which SUMO draws a vehicle.
    pub fn pose(&self, car: u32) -> Result<SumoPose, TrafficError> {
        let mut pose = SumoPose { front: DVec2::ZERO, angle_deg: 0.0 };
        let (x, y) = (&raw mut pose.front.x, &raw mut pose.front.y);
        self.check(unsafe { (self.api.pose)(car, x, y, &mut pose.angle_deg) })?;
        Ok(pose)
    }

    /// Runs a step without commands and without reading.
    pub fn bare_step(&mut self) -> Result<(), TrafficError> {
        self.check(unsafe { (self.api.bare_step)() })
    }
}

/// Waits `CODRIVE_SUMO_READS_S` seconds, for tests that need a long uninterruptible read. Release builds ignore the variable.
fn read_slowly() {
    if cfg!(debug_assertions)
        && let Some(seconds) = env::var("CODRIVE_SUMO_READS_S").ok().and_then(|text| text.parse().ok())
    {
        sleep(Duration::from_secs_f64(seconds));
    }
}

impl Drop for Shim {
    fn drop(&mut self) {
        // A failure cannot be reported from here.
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
