//! liblsl, opened at run time (docs/decisions.md: 21). In: its possible locations. Out: its functions, with the types
//! of its C header (`lsl_c.h`, version 1.16). It is opened once and never unloaded, because its threads would continue
//! in unloaded code.

use super::LslError;
use crate::native_code;
use std::{
    env::{self, consts},
    ffi::{CStr, CString, c_char, c_double, c_int, c_ulong, c_void},
    path::PathBuf,
    sync::{Mutex, OnceLock, PoisonError},
};

/// Environment variable that names the library's file, or its folder, before all other locations.
pub const VARIABLE: &str = "CODRIVE_LSL";

/// Pointer to an object of the library.
pub(super) type Handle = *mut c_void;
type Text = *const c_char;

/// Functions of the library that are used. Each catches C++ exceptions and returns an error code instead.
pub struct Library {
    version: unsafe extern "C" fn() -> c_int,
    clock: unsafe extern "C" fn() -> c_double,
    last_error: Option<unsafe extern "C" fn() -> Text>,
    pub(super) create_info: unsafe extern "C" fn(Text, Text, c_int, c_double, c_int, Text) -> Handle,
    pub(super) destroy_info: unsafe extern "C" fn(Handle),
    pub(super) desc: unsafe extern "C" fn(Handle) -> Handle,
    pub(super) append_child: unsafe extern "C" fn(Handle, Text) -> Handle,
    pub(super) append_value: unsafe extern "C" fn(Handle, Text, Text) -> Handle,
    pub(super) info_xml: unsafe extern "C" fn(Handle) -> *mut c_char,
    pub(super) destroy_string: unsafe extern "C" fn(*mut c_char),
    pub(super) create_outlet: unsafe extern "C" fn(Handle, c_int, c_int) -> Handle,
    pub(super) destroy_outlet: unsafe extern "C" fn(Handle),
    pub(super) push_numbers: unsafe extern "C" fn(Handle, *const c_double, c_double, c_int) -> c_int,
    pub(super) push_texts: unsafe extern "C" fn(Handle, *const Text, c_double, c_int) -> c_int,
    pub(super) have_consumers: unsafe extern "C" fn(Handle) -> c_int,
    pub(super) resolve_all: unsafe extern "C" fn(*mut Handle, u32, c_double) -> c_int,
    pub(super) resolve_by_predicate: unsafe extern "C" fn(*mut Handle, u32, Text, c_int, c_double) -> c_int,
    pub(super) create_inlet: unsafe extern "C" fn(Handle, c_int, c_int, c_int) -> Handle,
    pub(super) destroy_inlet: unsafe extern "C" fn(Handle),
    pub(super) open_stream: unsafe extern "C" fn(Handle, c_double, *mut c_int),
    pub(super) full_info: unsafe extern "C" fn(Handle, c_double, *mut c_int) -> Handle,
    pub(super) time_correction:
        unsafe extern "C" fn(Handle, *mut c_double, *mut c_double, c_double, *mut c_int) -> c_double,
    pub(super) pull_numbers:
        unsafe extern "C" fn(Handle, *mut c_double, *mut c_double, c_ulong, c_ulong, c_double, *mut c_int) -> c_ulong,
    pub(super) pull_texts: unsafe extern "C" fn(Handle, *mut *mut c_char, c_int, c_double, *mut c_int) -> c_double,
    path: String,
    _library: libloading::Library,
}

static LOADED: OnceLock<Library> = OnceLock::new();
static LOADING: Mutex<()> = Mutex::new(());

/// Returns the library if it is open.
pub fn loaded() -> Option<&'static Library> {
    LOADED.get()
}

/// Returns the library; opens it at the first call.
///
/// # Errors
/// The library is in none of its locations, or a file is no liblsl.
pub fn open() -> Result<&'static Library, LslError> {
    let _one = LOADING.lock().unwrap_or_else(PoisonError::into_inner);
    if LOADED.get().is_none() {
        let library = Library::load(&places())?;
        drop(LOADED.set(library));
    }
    LOADED.get().ok_or_else(|| LslError::Absent("it could not be stored".into()))
}

/// Returns the names of the library's file on this system.
fn file_names() -> Vec<String> {
    match consts::OS {
        "windows" => vec!["lsl.dll".into(), "liblsl.dll".into()],
        "macos" => vec!["liblsl.2.dylib".into(), "liblsl.dylib".into()],
        _ => vec!["liblsl.so.2".into(), "liblsl.so".into()],
    }
}

/// Returns the possible locations of the library, in order. If the variable is set, it is the only one. Otherwise:
/// beside the program or in `.lsl/` of its checkout, then the system's locations.
fn places() -> Vec<PathBuf> {
    let names = file_names();
    let within = |folder: PathBuf| names.iter().map(|name| folder.join(name)).collect::<Vec<_>>();
    if let Some(named) = env::var_os(VARIABLE).map(PathBuf::from) {
        return if named.is_dir() { within(named) } else { vec![named] };
    }
    let mut places: Vec<PathBuf> = native_code::library_folders("lsl").into_iter().flat_map(within).collect();
    places.retain(|place| place.exists());
    // The system's own loader searches for a bare name.
    places.extend(names.iter().map(PathBuf::from));
    places
}

impl std::fmt::Display for Library {
    /// Writes version and location of the library, for display.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // SAFETY: the function has no arguments.
        let version = unsafe { (self.version)() };
        write!(f, "liblsl {}.{:02} ({})", version / 100, version % 100, self.path)
    }
}

impl Library {
    fn load(places: &[PathBuf]) -> Result<Self, LslError> {
        let mut first = None;
        for place in places {
            // SAFETY: liblsl runs no code at load time with requirements on the caller.
            match unsafe { native_code::open(place) } {
                Ok(library) => return Self::of(library, &place.display().to_string()),
                Err(error) => drop(first.get_or_insert_with(|| {
                    let source = std::error::Error::source(&error).map_or(error.to_string(), ToString::to_string);
                    format!("{}: {source}", place.display())
                })),
            }
        }
        Err(LslError::Absent(first.unwrap_or_else(|| "no place to look in".into())))
    }

    fn of(library: libloading::Library, path: &str) -> Result<Self, LslError> {
        macro_rules! symbol {
            ($name:literal) => {
                // SAFETY: the types above are those of lsl_c.h, which have not changed since its version 1.10.
                *unsafe { library.get($name) }
                    .map_err(|error| LslError::Absent(format!("{path} is not liblsl: {error}")))?
            };
        }
        Ok(Self {
            version: symbol!(b"lsl_library_version\0"),
            clock: symbol!(b"lsl_local_clock\0"),
            // SAFETY: as above; versions before 1.14 lack this function.
            last_error: unsafe { library.get(b"lsl_last_error\0") }.ok().map(|found| *found),
            create_info: symbol!(b"lsl_create_streaminfo\0"),
            destroy_info: symbol!(b"lsl_destroy_streaminfo\0"),
            desc: symbol!(b"lsl_get_desc\0"),
            append_child: symbol!(b"lsl_append_child\0"),
            append_value: symbol!(b"lsl_append_child_value\0"),
            info_xml: symbol!(b"lsl_get_xml\0"),
            destroy_string: symbol!(b"lsl_destroy_string\0"),
            create_outlet: symbol!(b"lsl_create_outlet\0"),
            destroy_outlet: symbol!(b"lsl_destroy_outlet\0"),
            push_numbers: symbol!(b"lsl_push_sample_dtp\0"),
            push_texts: symbol!(b"lsl_push_sample_strtp\0"),
            have_consumers: symbol!(b"lsl_have_consumers\0"),
            resolve_all: symbol!(b"lsl_resolve_all\0"),
            resolve_by_predicate: symbol!(b"lsl_resolve_bypred\0"),
            create_inlet: symbol!(b"lsl_create_inlet\0"),
            destroy_inlet: symbol!(b"lsl_destroy_inlet\0"),
            open_stream: symbol!(b"lsl_open_stream\0"),
            full_info: symbol!(b"lsl_get_fullinfo\0"),
            time_correction: symbol!(b"lsl_time_correction_ex\0"),
            pull_numbers: symbol!(b"lsl_pull_chunk_d\0"),
            pull_texts: symbol!(b"lsl_pull_sample_str\0"),
            path: path.into(),
            _library: library,
        })
    }

    /// Returns the time on the library's clock, s.
    pub fn local_clock_s(&self) -> f64 {
        // SAFETY: the function has no arguments.
        unsafe { (self.clock)() }
    }

    /// Returns an error with the library's own message.
    pub(super) fn refused(&self, what: &str) -> LslError {
        // SAFETY: the text belongs to the library and this thread, and is valid until its next failure.
        let why = self.last_error.map(|last| unsafe { text(last()) }).unwrap_or_default();
        let why = if why.is_empty() { "it gave no reason".into() } else { why };
        LslError::Refused { what: what.into(), why }
    }

    /// Converts an error code of the library.
    pub(super) fn check(&self, code: c_int, stream: &str, what: &str) -> Result<(), LslError> {
        match code {
            0 => Ok(()),
            // Codes of lsl_timeout_error and lsl_lost_error.
            -1 => Err(LslError::Silent(stream.into())),
            -2 => Err(LslError::Lost(stream.into())),
            _ => Err(self.refused(&format!("{what} of {stream}"))),
        }
    }
}

/// Copies a text of the library; returns an empty one for null.
///
/// # Safety
/// `pointer` is null or points to a zero-terminated text that is valid for the call.
pub(super) unsafe fn text(pointer: *const c_char) -> String {
    if pointer.is_null() {
        return String::new();
    }
    // SAFETY: as above.
    unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned()
}

/// Converts a text for the library; zero bytes are removed.
pub(super) fn c_text(text: &str) -> CString {
    CString::new(text.replace('\0', "")).unwrap_or_default()
}
