//! Force through SDL2's haptics, which exist on Windows and macOS too (DirectInput, ForceFeedback.framework). In:
//! vendor and product of a wheel. Out: a [`ForceDevice`]. The library is opened at run time and is optional: if it is
//! missing, or the wheel has no motor, one message says so and the drive goes on without force.
//!
//! The device has one constant effect, created once and updated in place, and a second effect of zero force that plays all the
//! time, for the reason given at `EvdevForce`. A positive level on SDL's steering axis turns the wheel to the left,
//! like evdev's direction 0x4000, to which SDL translates it on Linux (see `tests/wheel/uinput.rs`). On other systems
//! the sign is untested with a wheel; `invert` in a profile reverses it.

use super::{
    force_thread::ForceDevice,
    no_force::{LibraryFault, NoForce, NoSdl, WheelWithoutForce},
};
use crate::native_code;
use std::{
    ffi::{CStr, c_char, c_int, c_uint, c_void},
    io,
    path::{Path, PathBuf},
};

/// File names of the library, in the order in which they are tried.
const NAMES: &[&str] = if cfg!(windows) {
    &["SDL2.dll"]
} else if cfg!(target_os = "macos") {
    &[
        "libSDL2-2.0.0.dylib",
        "/opt/homebrew/lib/libSDL2-2.0.0.dylib",
        "/usr/local/lib/libSDL2-2.0.0.dylib",
        "/Library/Frameworks/SDL2.framework/SDL2",
    ]
} else {
    &["libSDL2-2.0.so.0", "libSDL2.so"]
};
const REMEDY: &str = if cfg!(windows) {
    "put SDL2.dll (2.0.14 or newer) beside codrive.exe"
} else if cfg!(target_os = "macos") {
    "brew install sdl2 (2.0.14 or newer)"
} else {
    "install SDL 2.0.14 or newer (Debian, Ubuntu: apt install libsdl2-2.0-0)"
};
/// Environment variable that names another file as the library.
pub const LIBRARY: &str = "CODRIVE_SDL2";

// Constants of SDL.h and SDL_haptic.h.
const INIT: u32 = 0x0000_0200 | 0x0000_1000;
const CONSTANT: u16 = 1 << 0;
const GAIN: c_uint = 1 << 12;
const AUTOCENTER: c_uint = 1 << 13;
const STEERING_AXIS: u8 = 3;
const INFINITY: u32 = u32::MAX;

/// `SDL_HapticDirection`. Padding is an explicit field, so that equal effects are equal bytes.
#[repr(C)]
#[derive(Clone, Copy, Default)]
struct HapticDirection {
    kind: u8,
    gap: [u8; 3],
    along: [i32; 3],
}

/// `SDL_HapticConstant`, in the size of the union `SDL_HapticEffect`.
#[repr(C, align(8))]
#[derive(Clone, Copy, Default)]
struct HapticEffect {
    kind: u16,
    gap: u16,
    direction: HapticDirection,
    length_ms: u32,
    delay_ms: u16,
    button: u16,
    interval_ms: u16,
    level: i16,
    envelope: [u16; 4],
    rest: [u64; 4],
}

type Joystick = *mut c_void;
type Haptic = *mut c_void;

/// Functions of SDL2 that are used, and the library that holds them.
struct Sdl {
    set_main_ready: unsafe extern "C" fn(),
    set_hint: unsafe extern "C" fn(*const c_char, *const c_char) -> c_int,
    init: unsafe extern "C" fn(u32) -> c_int,
    quit: unsafe extern "C" fn(u32),
    error: unsafe extern "C" fn() -> *const c_char,
    joysticks: unsafe extern "C" fn() -> c_int,
    vendor: unsafe extern "C" fn(c_int) -> u16,
    product: unsafe extern "C" fn(c_int) -> u16,
    open_joystick: unsafe extern "C" fn(c_int) -> Joystick,
    close_joystick: unsafe extern "C" fn(Joystick),
    open_haptic: unsafe extern "C" fn(Joystick) -> Haptic,
    close_haptic: unsafe extern "C" fn(Haptic),
    query: unsafe extern "C" fn(Haptic) -> c_uint,
    set_gain: unsafe extern "C" fn(Haptic, c_int) -> c_int,
    set_autocenter: unsafe extern "C" fn(Haptic, c_int) -> c_int,
    new_effect: unsafe extern "C" fn(Haptic, *mut HapticEffect) -> c_int,
    update_effect: unsafe extern "C" fn(Haptic, c_int, *mut HapticEffect) -> c_int,
    run_effect: unsafe extern "C" fn(Haptic, c_int, u32) -> c_int,
    stop_effect: unsafe extern "C" fn(Haptic, c_int) -> c_int,
    destroy_effect: unsafe extern "C" fn(Haptic, c_int),
    _library: libloading::Library,
}

// SAFETY of all calls below: the types are those of SDL2's headers, and pointers are valid for the call or come from
// SDL. An `Sdl` has one owner, a `SdlForce`, which one thread at a time uses.
impl Sdl {
    fn load(path: &Path) -> Result<Self, LibraryFault> {
        // SAFETY: SDL2 runs no code at load time with requirements on the caller.
        let library = unsafe { native_code::open(path) }.map_err(|e| LibraryFault::Unopened(path.into(), e))?;
        macro_rules! symbol {
            ($name:literal) => {
                // SAFETY: see above.
                *unsafe { library.get(concat!($name, "\0").as_bytes()) }
                    .map_err(|_| LibraryFault::Lacks(path.into(), $name))?
            };
        }
        Ok(Self {
            set_main_ready: symbol!("SDL_SetMainReady"),
            set_hint: symbol!("SDL_SetHint"),
            init: symbol!("SDL_InitSubSystem"),
            quit: symbol!("SDL_QuitSubSystem"),
            error: symbol!("SDL_GetError"),
            joysticks: symbol!("SDL_NumJoysticks"),
            vendor: symbol!("SDL_JoystickGetDeviceVendor"),
            product: symbol!("SDL_JoystickGetDeviceProduct"),
            open_joystick: symbol!("SDL_JoystickOpen"),
            close_joystick: symbol!("SDL_JoystickClose"),
            open_haptic: symbol!("SDL_HapticOpenFromJoystick"),
            close_haptic: symbol!("SDL_HapticClose"),
            query: symbol!("SDL_HapticQuery"),
            set_gain: symbol!("SDL_HapticSetGain"),
            set_autocenter: symbol!("SDL_HapticSetAutocenter"),
            new_effect: symbol!("SDL_HapticNewEffect"),
            update_effect: symbol!("SDL_HapticUpdateEffect"),
            run_effect: symbol!("SDL_HapticRunEffect"),
            stop_effect: symbol!("SDL_HapticStopEffect"),
            destroy_effect: symbol!("SDL_HapticDestroyEffect"),
            _library: library,
        })
    }

    /// Returns SDL's last error message.
    fn complaint(&self) -> String {
        unsafe { CStr::from_ptr((self.error)()) }.to_string_lossy().into_owned()
    }

    fn refuses(&self, refused: &'static str) -> NoForce {
        NoForce::Sdl { refused, complaint: self.complaint() }
    }

    fn begin(&self) -> Result<(), NoForce> {
        unsafe {
            // SDL must not take Ctrl-C from the program, and SDL's main function is not used.
            (self.set_hint)(c"SDL_NO_SIGNAL_HANDLERS".as_ptr(), c"1".as_ptr());
            (self.set_hint)(c"SDL_JOYSTICK_THREAD".as_ptr(), c"1".as_ptr());
            (self.set_main_ready)();
            if (self.init)(INIT) == 0 { Ok(()) } else { Err(self.refuses("does not start")) }
        }
    }
}

/// Returns the candidate files of the library: the one named in the environment, otherwise all known names.
fn files() -> Vec<PathBuf> {
    let named = std::env::var_os(LIBRARY).filter(|file| !file.is_empty()).map(PathBuf::from);
    named.map_or_else(|| NAMES.iter().map(PathBuf::from).collect(), |file| vec![file])
}

/// Loads the first library that can be used.
fn load(libraries: &[PathBuf]) -> Result<(PathBuf, Sdl), NoSdl> {
    let mut faults = Vec::new();
    let loaded = libraries.iter().find_map(|path| {
        let sdl = Sdl::load(path).map_err(|fault| faults.push(fault)).ok()?;
        Some((path.clone(), sdl))
    });
    loaded.ok_or_else(|| NoSdl { faults, remedy: format!("{REMEDY}, or name its file in {LIBRARY}") })
}

/// Returns the file of the SDL2 library that can be loaded; opens no device.
///
/// # Errors
/// No candidate can be used.
pub fn look() -> Result<PathBuf, NoSdl> {
    load(&files()).map(|(path, _)| path)
}

/// Force feedback of a wheel through SDL2.
pub struct SdlForce {
    sdl: Sdl,
    joystick: Joystick,
    haptic: Haptic,
    effect: Option<c_int>,
    rest: Option<c_int>,
    can: c_uint,
    autocentre_after: f64,
}

// SAFETY: SDL's haptics may be used from any thread, one at a time.
unsafe impl Send for SdlForce {}

impl SdlForce {
    /// Opens the force of the wheel with this vendor and product. `name` is the wheel's name in messages;
    /// `autocentre_after` is the strength of its own centring spring at the end, 0 to 1.
    ///
    /// # Errors
    /// SDL2 is missing, or the wheel has no force.
    pub fn open(id: (u16, u16), name: &str, autocentre_after: f64) -> Result<Self, WheelWithoutForce> {
        Self::open_from(&files(), id, name, autocentre_after)
    }

    /// Opens the force with the first of these libraries that can be loaded.
    ///
    /// # Errors
    /// SDL2 is missing, or the wheel has no force.
    pub fn open_from(
        libraries: &[PathBuf],
        id: (u16, u16),
        name: &str,
        autocentre_after: f64,
    ) -> Result<Self, WheelWithoutForce> {
        let without = |why, remedy| WheelWithoutForce { wheel: name.to_owned(), why, remedy };
        let (_, sdl) = load(libraries).map_err(|none| {
            let remedy = none.remedy.clone();
            without(none.into(), remedy)
        })?;
        sdl.begin().map_err(|why| without(why, REMEDY.into()))?;
        let null = std::ptr::null_mut();
        // From here on, dropping `force` also shuts down SDL.
        let mut force = Self { sdl, joystick: null, haptic: null, effect: None, rest: None, can: 0, autocentre_after };
        let motor = "use another wheel, or install the driver of the wheel's maker";
        force.take(id).map_err(|why| without(why, motor.into()))?;
        Ok(force)
    }

    /// Finds the wheel, opens it and creates the effects at level 0.
    fn take(&mut self, (vendor, product): (u16, u16)) -> Result<(), NoForce> {
        let sdl = &self.sdl;
        unsafe {
            let count = (sdl.joysticks)();
            let index = (0..count).find(|i| ((sdl.vendor)(*i), (sdl.product)(*i)) == (vendor, product));
            let index = index.ok_or(NoForce::Unseen { joysticks: count.max(0), vendor, product })?;
            self.joystick = (sdl.open_joystick)(index);
            if self.joystick.is_null() {
                return Err(sdl.refuses("cannot open it"));
            }
            self.haptic = (sdl.open_haptic)(self.joystick);
            if self.haptic.is_null() {
                return Err(sdl.refuses("finds no motor in it"));
            }
            self.can = (sdl.query)(self.haptic);
            if self.can & c_uint::from(CONSTANT) == 0 {
                return Err(NoForce::NoConstantForce);
            }
            if self.can & GAIN != 0 {
                (sdl.set_gain)(self.haptic, 100);
            }
            if self.can & AUTOCENTER != 0 {
                (sdl.set_autocenter)(self.haptic, 0);
            }
            let effect = (sdl.new_effect)(self.haptic, &mut constant(0));
            if effect < 0 {
                return Err(sdl.refuses("makes no constant force"));
            }
            self.effect = Some(effect);
            // Optional: a device may have room for only one effect.
            self.rest = Some((sdl.new_effect)(self.haptic, &mut constant(0))).filter(|rest| *rest >= 0);
            if let Some(rest) = self.rest {
                (sdl.run_effect)(self.haptic, rest, INFINITY);
            }
            if (sdl.run_effect)(self.haptic, effect, INFINITY) < 0 {
                return Err(sdl.refuses("does not run the force"));
            }
        }
        Ok(())
    }
}

impl ForceDevice for SdlForce {
    fn set(&mut self, level: i16) -> io::Result<()> {
        let Some(effect) = self.effect else { return Err(io::ErrorKind::NotConnected.into()) };
        let updated = unsafe { (self.sdl.update_effect)(self.haptic, effect, &mut constant(level)) };
        if updated < 0 { Err(io::Error::other(self.sdl.complaint())) } else { Ok(()) }
    }

    fn end(&mut self) {
        let Some(effect) = self.effect.take() else { return };
        unsafe {
            (self.sdl.update_effect)(self.haptic, effect, &mut constant(0));
            (self.sdl.stop_effect)(self.haptic, effect);
            if self.can & AUTOCENTER != 0 {
                (self.sdl.set_autocenter)(self.haptic, (self.autocentre_after * 100.0) as c_int);
            }
            for effect in [Some(effect), self.rest.take()].into_iter().flatten() {
                (self.sdl.destroy_effect)(self.haptic, effect);
            }
        }
    }
}

impl Drop for SdlForce {
    fn drop(&mut self) {
        self.end();
        unsafe {
            if !self.haptic.is_null() {
                (self.sdl.close_haptic)(self.haptic);
            }
            if !self.joystick.is_null() {
                (self.sdl.close_joystick)(self.joystick);
            }
            (self.sdl.quit)(INIT);
        }
    }
}

/// Makes an endless constant force; a positive `level` pushes towards greater values of the steering axis, to the
/// right.
fn constant(level: i16) -> HapticEffect {
    HapticEffect {
        kind: CONSTANT,
        direction: HapticDirection { kind: STEERING_AXIS, ..HapticDirection::default() },
        length_ms: INFINITY,
        level: (-i32::from(level)).clamp(-32_767, 32_767) as i16,
        ..HapticEffect::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::mem::{offset_of, size_of};

    #[test]
    fn an_effect_has_the_memory_layout_of_sdls_header() {
        assert_eq!(
            size_of::<HapticEffect>(),
            72,
            "the union's largest member is SDL_HapticCustom or SDL_HapticCondition"
        );
        assert_eq!([offset_of!(HapticEffect, direction), offset_of!(HapticDirection, along)], [4, 4]);
        assert_eq!([offset_of!(HapticEffect, length_ms), offset_of!(HapticEffect, level)], [20, 30]);
    }
}
