//! A window's surface. In: its size. Out: a texture a frame to draw into. One frame of latency at most, no sRGB format
//! (the tone map writes sRGB values itself).

use crate::render::device::gpu::Gpu;
use wgpu::CurrentSurfaceTexture as Current;

/// Pictures that may wait for the screen.
pub const FRAMES_AHEAD: u32 = 1;

/// A surface and its configuration.
pub struct WindowSurface {
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
}

impl WindowSurface {
    /// Configures `surface` for a window of `size` pixels; `None` if the adapter cannot show pictures in it. `present` says
    /// whether a picture waits for the screen.
    pub fn new(gpu: &Gpu, surface: wgpu::Surface<'static>, size: [u32; 2], present: wgpu::PresentMode) -> Option<Self> {
        let mut config = surface.get_default_config(&gpu.adapter, size[0].max(1), size[1].max(1))?;
        let formats = surface.get_capabilities(&gpu.adapter).formats;
        config.format = formats.into_iter().find(|f| !f.is_srgb()).unwrap_or(config.format.remove_srgb_suffix());
        config.present_mode = present;
        // Never queue a picture behind another: latency is what a driver feels.
        config.desired_maximum_frame_latency = FRAMES_AHEAD;
        surface.configure(&gpu.device, &config);
        Some(Self { surface, config })
    }

    /// Pixel format of the pictures.
    pub fn format(&self) -> wgpu::TextureFormat {
        self.config.format
    }

    /// How pictures are handed over, a word.
    pub fn present_mode(&self) -> String {
        format!("{:?}", self.config.present_mode).to_lowercase()
    }

    /// Width and height, pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.config.width, self.config.height]
    }

    /// The window has a new size.
    pub fn resize(&mut self, gpu: &Gpu, size: [u32; 2]) {
        if size[0] > 0 && size[1] > 0 && size != self.size() {
            [self.config.width, self.config.height] = size;
            self.surface.configure(&gpu.device, &self.config);
        }
    }

    /// The texture of the next frame; `None` if there is none now (hidden, or just configured again): try at the next.
    pub fn next(&mut self, gpu: &Gpu) -> Option<wgpu::SurfaceTexture> {
        match self.surface.get_current_texture() {
            Current::Success(texture) | Current::Suboptimal(texture) => Some(texture),
            Current::Outdated | Current::Lost => {
                self.surface.configure(&gpu.device, &self.config);
                None
            }
            Current::Timeout | Current::Occluded | Current::Validation => None,
        }
    }
}
