//! Choice of the graphics adapter. In: `WGPU_BACKEND`, `WGPU_ADAPTER_NAME` and `WGPU_POWER_PREF` of the environment, and
//! a window's surface. Out: an adapter that this program can draw with, or an error that names the variable, its value
//! and what this computer has.

use super::gpu::GpuError;
use wgpu::Backends;

const BACKEND: &str = "WGPU_BACKEND";
const ADAPTER_NAME: &str = "WGPU_ADAPTER_NAME";
const POWER: &str = "WGPU_POWER_PREF";

/// Graphics interfaces by the names that wgpu knows; the first is the one that messages use.
const INTERFACES: [(&[&str], Backends); 4] = [
    (&["vulkan", "vk"], Backends::VULKAN),
    (&["gl", "gles", "opengl"], Backends::GL),
    (&["dx12", "d3d12"], Backends::DX12),
    (&["metal", "mtl"], Backends::METAL),
];

/// Wishes of the environment; an empty variable is none.
#[derive(Debug)]
pub(super) struct AdapterChoice {
    /// Value of `WGPU_BACKEND`, and the interfaces that it names.
    interfaces: Option<(String, Backends)>,
    /// Part of the adapter's name, in any case.
    name: Option<String>,
    power: wgpu::PowerPreference,
}

impl AdapterChoice {
    /// Reads the environment.
    ///
    /// # Errors
    /// A variable has a value that names nothing.
    pub fn from_env() -> Result<Self, GpuError> {
        Self::new(|variable| std::env::var_os(variable).map(|value| value.to_string_lossy().into_owned()))
    }

    fn new(value_of: impl Fn(&str) -> Option<String>) -> Result<Self, GpuError> {
        let value_of = |variable| value_of(variable).filter(|value| !value.trim().is_empty());
        let interfaces = value_of(BACKEND).map(|value| interfaces(&value).map(|found| (value, found))).transpose()?;
        let power = value_of(POWER).map_or(Ok(wgpu::PowerPreference::HighPerformance), power)?;
        Ok(Self { interfaces, name: value_of(ADAPTER_NAME), power })
    }

    /// Returns wgpu's entry point for the chosen interfaces, from a description with or without a display.
    pub fn instance(&self, mut description: wgpu::InstanceDescriptor) -> wgpu::Instance {
        description.backends = self.backends();
        description.backend_options = description.backend_options.with_env();
        // This program makes no indirect calls, and their check needs compute shaders, which older OpenGL lacks.
        description.flags = description.flags.with_env() - wgpu::InstanceFlags::VALIDATION_INDIRECT_CALL;
        wgpu::Instance::new(description)
    }

    /// Returns the adapter that fits best and can draw to `surface`.
    ///
    /// # Errors
    /// There is none, or it lacks something that this program needs.
    pub fn adapter(
        &self,
        instance: &wgpu::Instance,
        surface: Option<&wgpu::Surface<'static>>,
    ) -> Result<wgpu::Adapter, GpuError> {
        let options = wgpu::RequestAdapterOptions {
            power_preference: self.power,
            compatible_surface: surface,
            ..Default::default()
        };
        let adapter = match &self.name {
            Some(part) => self.named(instance, surface, part)?,
            None => pollster::block_on(instance.request_adapter(&options))
                .map_err(|e| self.without_interface().unwrap_or_else(|| GpuError::NoAdapter(e.to_string())))?,
        };
        match lacking(&adapter) {
            Some(why) => Err(no_device(&adapter, why)),
            None => Ok(adapter),
        }
    }

    /// Returns the error for a surface or an adapter that is missing because of `WGPU_BACKEND`; `None` if that is not set.
    pub fn without_interface(&self) -> Option<GpuError> {
        let (value, _) = self.interfaces.as_ref()?;
        Some(GpuError::Variable {
            variable: BACKEND,
            value: value.clone(),
            why: "no graphics adapter of this computer has this interface".to_owned(),
            remedy: format!("set it to {}, or install a driver ({DRIVERS})", available(Backends::all(), None)),
        })
    }

    fn backends(&self) -> Backends {
        self.interfaces.as_ref().map_or(Backends::all(), |(_, backends)| *backends)
    }

    fn named(
        &self,
        instance: &wgpu::Instance,
        surface: Option<&wgpu::Surface<'static>>,
        part: &str,
    ) -> Result<wgpu::Adapter, GpuError> {
        let fits = |adapter: &wgpu::Adapter| {
            adapter.get_info().name.to_lowercase().contains(&part.to_lowercase())
                && surface.is_none_or(|surface| adapter.is_surface_supported(surface))
        };
        let adapters = pollster::block_on(instance.enumerate_adapters(self.backends()));
        adapters.into_iter().find(fits).ok_or_else(|| GpuError::Variable {
            variable: ADAPTER_NAME,
            value: part.to_owned(),
            why: "no graphics adapter has this in its name".to_owned(),
            remedy: format!("set it to a part of the name of one that there is: {}", available(self.backends(), None)),
        })
    }
}

/// Drivers that bring an adapter, in a message.
pub(super) const DRIVERS: &str =
    "Debian, Ubuntu: `apt install mesa-vulkan-drivers libvulkan1` also brings one that needs no GPU";

/// Returns the error for an adapter that this program cannot draw with.
pub(super) fn no_device(adapter: &wgpu::Adapter, why: String) -> GpuError {
    let info = adapter.get_info();
    let remedy =
        format!("update its driver, or choose another with {BACKEND}: {}", available(Backends::all(), Some(&info)));
    GpuError::NoDevice { adapter: format!("{} ({})", info.name, interface(info.backend)), why, remedy }
}

/// Oldest version of OpenGL that draws, major and minor. The shaders of trees need the number of a sample, which 4.0 has;
/// below 4.2, where shaders cannot name their bindings, Mesa draws a black picture.
const OLDEST_OPENGL: [u32; 2] = [4, 2];

/// Returns the reason for which this program cannot draw with an adapter; `None` if it can.
fn lacking(adapter: &wgpu::Adapter) -> Option<String> {
    let info = adapter.get_info();
    let [major, minor] = OLDEST_OPENGL;
    let enough = info.backend != wgpu::Backend::Gl || version(&info.driver_info) >= Some(OLDEST_OPENGL);
    (!enough).then(|| format!("OpenGL {major}.{minor} or later is needed, not {}", info.driver_info))
}

/// Returns major and minor version from the text of a driver for OpenGL, which begins with them; `None` for OpenGL ES.
fn version(driver: &str) -> Option<[u32; 2]> {
    let mut numbers = driver.split(['.', ' ']).map(str::parse);
    Some([numbers.next()?.ok()?, numbers.next()?.ok()?])
}

/// Returns the usable adapters of some interfaces, except one, e.g. `vulkan (llvmpipe) or gl (llvmpipe)`.
fn available(backends: Backends, except: Option<&wgpu::AdapterInfo>) -> String {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapters = pollster::block_on(instance.enumerate_adapters(backends));
    let usable = adapters.iter().filter(|adapter| lacking(adapter).is_none()).map(wgpu::Adapter::get_info);
    let others = usable.filter(|info| except.is_none_or(|not| (&not.name, not.backend) != (&info.name, info.backend)));
    let mut names: Vec<String> = others.map(|info| format!("{} ({})", interface(info.backend), info.name)).collect();
    names.dedup();
    if names.is_empty() { "(this computer has no other)".to_owned() } else { names.join(" or ") }
}

/// Returns the name of an interface in `WGPU_BACKEND`.
fn interface(backend: wgpu::Backend) -> String {
    let known = INTERFACES.iter().find(|(_, bit)| *bit == Backends::from(backend));
    known.map_or_else(|| backend.to_string(), |(names, _)| names[0].to_owned())
}

/// Returns the interfaces of a list with commas.
fn interfaces(list: &str) -> Result<Backends, GpuError> {
    let known = |word: &str| INTERFACES.iter().find(|(names, _)| names.contains(&word)).map(|(_, bit)| *bit);
    let words = list.split(',').map(|word| word.trim().to_lowercase()).filter(|word| !word.is_empty());
    words.map(|word| known(&word)).collect::<Option<Backends>>().filter(|found| !found.is_empty()).ok_or_else(|| {
        GpuError::Variable {
            variable: BACKEND,
            value: list.to_owned(),
            why: "the graphics interfaces are vulkan, gl, dx12 and metal".to_owned(),
            remedy: format!("set it to {}", available(Backends::all(), None)),
        }
    })
}

fn power(word: String) -> Result<wgpu::PowerPreference, GpuError> {
    match word.to_lowercase().as_str() {
        "low" => Ok(wgpu::PowerPreference::LowPower),
        "high" => Ok(wgpu::PowerPreference::HighPerformance),
        "none" => Ok(wgpu::PowerPreference::None),
        _ => Err(GpuError::Variable {
            variable: POWER,
            value: word,
            why: "this is no kind of graphics adapter".to_owned(),
            remedy: "set it to low (the adapter that saves power), high (the fastest one) or none".to_owned(),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choice(variable: &'static str, value: &str) -> Result<AdapterChoice, String> {
        let value = value.to_owned();
        AdapterChoice::new(|asked| (asked == variable).then(|| value.clone())).map_err(|e| e.to_string())
    }

    #[test]
    fn words_choose_interfaces_and_power_and_empty_ones_nothing() {
        for (value, backends) in
            [("vulkan", Backends::VULKAN), ("GL", Backends::GL), (" vk , opengl,", Backends::VULKAN | Backends::GL)]
        {
            assert_eq!(choice(BACKEND, value).expect(value).backends(), backends, "{value}");
        }
        for variable in [BACKEND, ADAPTER_NAME, POWER] {
            let free = choice(variable, " ").expect("an empty variable");
            assert!(free.interfaces.is_none() && free.name.is_none(), "{variable}");
            assert_eq!(free.power, wgpu::PowerPreference::HighPerformance);
        }
        assert_eq!(choice(POWER, "Low").expect("a word").power, wgpu::PowerPreference::LowPower);
    }

    #[test]
    fn the_version_of_opengl_is_read_from_every_drivers_text() {
        assert_eq!(version("4.5 (Core Profile) Mesa 22.3.6"), Some([4, 5]));
        assert_eq!(version("4.6.0 NVIDIA 535.183.01"), Some([4, 6]));
        assert_eq!(version("3.3 (Core Profile) Mesa 22.3.6"), Some([3, 3]));
        assert_eq!(version("OpenGL ES 3.2 Mesa 22.3.6"), None);
        assert!([Some([4, 1]), Some([3, 3]), None].iter().all(|older| *older < Some(OLDEST_OPENGL)));
        assert!(Some([4, 10]) > Some(OLDEST_OPENGL));
    }

    #[test]
    fn a_word_that_is_none_is_named_with_its_variable_and_a_remedy() {
        for (variable, value) in [(BACKEND, "nonsense"), (BACKEND, "gl,noop"), (BACKEND, ","), (POWER, "x")] {
            let message = choice(variable, value).expect_err(value);
            assert!(message.starts_with(&format!("{variable}={value}: ")), "{message}");
            assert!(message.contains(&format!("\n  remedy: unset {variable}, or set it to ")), "{message}");
            assert_eq!(message.lines().count(), 2, "{message}");
        }
    }
}
