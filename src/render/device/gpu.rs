//! The graphics device. In: nothing (off-screen) or a window's display and surface. Out: a [`Gpu`] that everything in
//! `render` borrows; `adapter` chooses among several.

use super::adapter::{AdapterChoice, DRIVERS, no_device};
use std::sync::{Arc, OnceLock};

/// Largest side of a picture, pixels: a size that every graphics card supports.
pub const MAX_SIDE: u32 = 8192;

/// Error of the graphics device.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// A variable of the environment chooses no adapter of this computer.
    #[error("{variable}={value}: {why}\n  remedy: unset {variable}, or {remedy}")]
    Variable {
        /// Name of the variable.
        variable: &'static str,
        /// Value of the variable.
        value: String,
        /// Reason for which nothing is chosen.
        why: String,
        /// Values that choose something here.
        remedy: String,
    },
    /// No adapter, or none that can show the window.
    #[error("no graphics adapter: {0}\n  remedy: install a driver ({DRIVERS})")]
    NoAdapter(String),
    /// The adapter cannot draw what this program draws.
    #[error("the graphics adapter {adapter} gives no device: {why}\n  remedy: {remedy}")]
    NoDevice {
        /// Name of the adapter, with its interface.
        adapter: String,
        /// Message of the driver, or what is missing.
        why: String,
        /// Other adapters of this computer.
        remedy: String,
    },
    /// The window has no surface to draw to.
    #[error(
        "the window cannot be drawn to: {0}\n  remedy: check that the display is still connected, or choose another \
         graphics interface with WGPU_BACKEND=vulkan or WGPU_BACKEND=gl"
    )]
    NoSurface(String),
    /// The device was lost while drawing.
    #[error(
        "the graphics device is lost: {0}\n  remedy: start the program again, or choose another graphics interface with \
         WGPU_BACKEND=vulkan or WGPU_BACKEND=gl"
    )]
    Lost(String),
}

/// Instance, adapter, device and queue.
#[derive(Debug)]
pub struct Gpu {
    /// Entry point of the graphics library.
    pub instance: wgpu::Instance,
    /// Graphics card, or software renderer.
    pub adapter: wgpu::Adapter,
    /// Creates buffers, textures and pipelines.
    pub device: wgpu::Device,
    /// Receives commands and uploads.
    pub queue: wgpu::Queue,
    /// Name, type, backend and driver of the adapter.
    pub info: wgpu::AdapterInfo,
}

impl Gpu {
    /// Opens a device without a window.
    ///
    /// # Errors
    /// There is no adapter, or it gives no device.
    pub fn headless() -> Result<Self, GpuError> {
        let choice = AdapterChoice::from_env()?;
        let instance = choice.instance(wgpu::InstanceDescriptor::new_without_display_handle());
        Self::new(&choice, instance, None)
    }

    /// Opens a device that can draw to `window`, and returns the window's surface too. `display` is the event loop's
    /// (`event_loop.owned_display_handle()`).
    ///
    /// # Errors
    /// The window has no surface, or as [`Gpu::headless`].
    pub fn for_window(
        display: Box<dyn wgpu::wgt::WgpuHasDisplayHandle>,
        window: impl Into<wgpu::SurfaceTarget<'static>>,
    ) -> Result<(Self, wgpu::Surface<'static>), GpuError> {
        let choice = AdapterChoice::from_env()?;
        let instance = choice.instance(wgpu::InstanceDescriptor::new_with_display_handle(display));
        let surface = instance
            .create_surface(window)
            .map_err(|e| choice.without_interface().unwrap_or_else(|| GpuError::NoSurface(e.to_string())))?;
        Ok((Self::new(&choice, instance, Some(&surface))?, surface))
    }

    /// Returns one device for the whole process, opened at the first call: for tests and for tools that draw several
    /// pictures.
    ///
    /// # Errors
    /// As [`Gpu::headless`], the same at every call.
    pub fn shared() -> Result<&'static Self, &'static GpuError> {
        static SHARED: OnceLock<Result<Gpu, GpuError>> = OnceLock::new();
        SHARED.get_or_init(Self::headless).as_ref()
    }

    /// Returns adapter, driver and backend in one line, for logs and reports.
    pub fn description(&self) -> String {
        let info = &self.info;
        let driver = format!("{} {}", info.driver, info.driver_info);
        format!("{} ({:?}, {:?}, {})", info.name, info.device_type, info.backend, driver.trim())
    }

    /// Returns true if the processor draws (software rendering), which makes pixels expensive.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// Returns the reason for which times on a graphics card cannot be measured; `None` if they can.
    pub fn lacks_device_times(&self) -> Option<&'static str> {
        if self.is_software() {
            return Some("the processor draws, not a graphics card");
        }
        let has_stamps = self.device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        (!has_stamps).then_some("the driver has no timestamps")
    }

    /// Waits until all submitted work is done.
    ///
    /// # Errors
    /// The device is lost.
    pub fn finish(&self) -> Result<(), GpuError> {
        self.device.poll(wgpu::PollType::wait_indefinitely()).map(drop).map_err(|e| GpuError::Lost(e.to_string()))
    }

    /// Returns the memory of textures and buffers on the device, MB; `None` if the driver does not report it.
    pub fn memory_mb(&self) -> Option<f64> {
        let report = self.device.generate_allocator_report()?;
        Some(report.total_allocated_bytes as f64 / 1e6)
    }

    fn new(
        choice: &AdapterChoice,
        instance: wgpu::Instance,
        surface: Option<&wgpu::Surface<'static>>,
    ) -> Result<Self, GpuError> {
        let adapter = choice.adapter(&instance, surface)?;
        let info = adapter.get_info();
        // Neither compute shaders nor storage are used, which older OpenGL lacks.
        let limits = wgpu::Limits::downlevel_webgl2_defaults();
        let (device, queue) = pollster::block_on(adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("codrive"),
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: wgpu::Limits { max_texture_dimension_2d: MAX_SIDE, ..limits },
            ..Default::default()
        }))
        .map_err(|e| no_device(&adapter, e.to_string()))?;
        // An error here is a mistake in our own calls: panic at once, with wgpu's explanation.
        device.on_uncaptured_error(Arc::new(|e: wgpu::Error| panic!("wgpu: {e}")));
        Ok(Self { instance, adapter, device, queue, info })
    }
}
