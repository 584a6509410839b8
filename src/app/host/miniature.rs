//! The driver's picture once more, small, for the experimenter: every tenth of a second or so a frame is drawn onto a
//! canvas instead of the screen, copied from there to the screen, and made small beside it. In: frames. Out: a texture.
//! The copy stays on the device; the driver sees the same frame at the same time.

use crate::render::{Gpu, miniature::MiniaturePass};
use std::time::{Duration, Instant};

/// Time between two miniatures, on a graphics card and where the processor draws.
const EVERY: [Duration; 2] = [Duration::from_millis(125), Duration::from_millis(500)];
/// Most pixels across and down.
const MOST: [u32; 2] = [320, 180];

/// Canvas and miniature.
pub struct Miniature {
    pass: MiniaturePass,
    canvas: Option<wgpu::TextureView>,
    small: wgpu::TextureView,
    last: Option<Instant>,
}

impl Miniature {
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        let pass = MiniaturePass::new(&gpu.device, format);
        let small = pass.canvas(&gpu.device, MOST);
        Self { pass, canvas: None, small, last: None }
    }

    /// Where the frame of `now` is to be drawn, if it is one that becomes a miniature.
    pub fn canvas(&mut self, gpu: &Gpu, now: Instant, size: [u32; 2]) -> Option<wgpu::TextureView> {
        if self.last.is_some_and(|last| now.saturating_duration_since(last) < EVERY[usize::from(gpu.is_software())]) {
            return None;
        }
        self.last = Some(now);
        if self.canvas.as_ref().is_none_or(|canvas| {
            let texture = canvas.texture();
            [texture.width(), texture.height()] != size
        }) {
            self.canvas = Some(self.pass.canvas(&gpu.device, size));
            self.small = self.pass.canvas(&gpu.device, fitting(size));
        }
        self.canvas.clone()
    }

    /// The frame has been drawn onto the canvas: it goes to `screen`, and small beside it.
    pub fn hand_on(&self, gpu: &Gpu, canvas: &wgpu::TextureView, screen: &wgpu::TextureView) {
        let mut encoder =
            gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("miniature") });
        self.pass.draw(&gpu.device, &mut encoder, canvas, screen, None);
        self.pass.draw(&gpu.device, &mut encoder, canvas, &self.small, None);
        gpu.queue.submit([encoder.finish()]);
    }

    /// The latest miniature.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.small
    }
}

/// The largest size of the picture's shape within the limits, never larger than the picture.
fn fitting([width, height]: [u32; 2]) -> [u32; 2] {
    let (w, h) = (f64::from(width.max(1)), f64::from(height.max(1)));
    let scale = (f64::from(MOST[0]) / w).min(f64::from(MOST[1]) / h).min(1.0);
    [w * scale, h * scale].map(|side| (side.round() as u32).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_miniature_keeps_the_shape_of_the_picture() {
        assert_eq!(fitting([1280, 720]), [320, 180]);
        assert_eq!(fitting([5120, 1440]), [320, 90]);
        assert_eq!(fitting([1024, 768]), [240, 180]);
        assert_eq!(fitting([100, 60]), [100, 60]);
        assert_eq!(fitting([0, 0]), [1, 1]);
    }
}
