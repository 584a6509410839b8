//! Surface of a window. In: its size. Out: a texture per frame to draw to. At most one frame of latency; no sRGB
//! format, because the tone mapping writes sRGB values itself.

use crate::render::{MAX_SIDE, device::gpu::Gpu};
use wgpu::CurrentSurfaceTexture as Current;

/// Number of pictures that may wait for the screen.
pub const FRAMES_AHEAD: u32 = 1;

/// A surface and its configuration.
pub struct WindowSurface {
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
}

impl WindowSurface {
    /// Configures `surface` for a window of `size` pixels; `None` if the adapter cannot draw to it. `present` decides
    /// whether a picture waits for the screen. A window with a side of more than [`MAX_SIDE`] pixels is drawn with that many.
    pub fn new(gpu: &Gpu, surface: wgpu::Surface<'static>, size: [u32; 2], present: wgpu::PresentMode) -> Option<Self> {
        let [width, height] = drawable(size);
        let mut config = surface.get_default_config(&gpu.adapter, width, height)?;
        let formats = surface.get_capabilities(&gpu.adapter).formats;
        config.format = formats.into_iter().find(|f| !f.is_srgb()).unwrap_or(config.format.remove_srgb_suffix());
        config.present_mode = present;
        // Never queue a picture behind another: drivers feel the latency.
        config.desired_maximum_frame_latency = FRAMES_AHEAD;
        surface.configure(&gpu.device, &config);
        Some(Self { surface, config })
    }

    /// Returns the pixel format of the pictures.
    pub fn format(&self) -> wgpu::TextureFormat {
        self.config.format
    }

    /// Returns the present mode as a word, e.g. `fifo`.
    pub fn present_mode(&self) -> String {
        format!("{:?}", self.config.present_mode).to_lowercase()
    }

    /// Returns width and height, pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.config.width, self.config.height]
    }

    /// Adapts the surface to a new size of the window.
    pub fn resize(&mut self, gpu: &Gpu, size: [u32; 2]) {
        if size[0] > 0 && size[1] > 0 && drawable(size) != self.size() {
            [self.config.width, self.config.height] = drawable(size);
            self.surface.configure(&gpu.device, &self.config);
        }
    }

    /// Returns the texture of the next frame; `None` if there is none now (hidden, or just reconfigured): try again at
    /// the next frame.
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

/// Returns the sides that a picture can have, pixels.
fn drawable(size: [u32; 2]) -> [u32; 2] {
    size.map(|side| side.clamp(1, MAX_SIDE))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_wider_than_the_largest_picture_is_drawn_with_the_largest() {
        assert_eq!(drawable([10_000, 600]), [MAX_SIDE, 600]);
        assert_eq!((drawable([0, 8192]), drawable([1280, 720])), ([1, 8192], [1280, 720]));
    }
}
