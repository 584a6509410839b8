//! A small copy of the driver's picture for the experimenter. At fixed intervals a frame is drawn onto a canvas instead
//! of the screen, then copied from there to the screen and, reduced, to the preview. In: frames. Out: a texture. The
//! copy stays on the device; the driver sees the same frame at the same time.

use crate::render::{Gpu, post::preview::PreviewPass};
use std::time::{Duration, Instant};

/// Time between two previews: with a graphics card, and on software rendering.
const EVERY: [Duration; 2] = [Duration::from_millis(125), Duration::from_millis(500)];
/// Largest width and height of the preview, pixels.
const MOST: [u32; 2] = [320, 180];

/// Canvas and preview, and their timing.
pub struct Preview {
    pass: PreviewPass,
    canvas: Option<wgpu::TextureView>,
    small: wgpu::TextureView,
    last: Option<Instant>,
}

impl Preview {
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        let pass = PreviewPass::new(&gpu.device, format);
        let small = pass.canvas(&gpu.device, MOST);
        Self { pass, canvas: None, small, last: None }
    }

    /// Returns the canvas for the frame of `now` if that frame becomes a preview, `None` otherwise.
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

    /// Copies the frame on the canvas to `screen`, and reduced to the preview.
    pub fn hand_on(&self, gpu: &Gpu, canvas: &wgpu::TextureView, screen: &wgpu::TextureView) {
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("preview") });
        self.pass.draw(&gpu.device, &mut encoder, canvas, screen, None);
        self.pass.draw(&gpu.device, &mut encoder, canvas, &self.small, None);
        gpu.queue.submit([encoder.finish()]);
    }

    /// Returns the latest preview.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.small
    }
}

/// Returns the largest size of the picture's shape within the limits, never larger than the picture.
fn fitting([width, height]: [u32; 2]) -> [u32; 2] {
    let (w, h) = (f64::from(width.max(1)), f64::from(height.max(1)));
    let scale = (f64::from(MOST[0]) / w).min(f64::from(MOST[1]) / h).min(1.0);
    [w * scale, h * scale].map(|side| (side.round() as u32).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::{OFFSCREEN, offscreen::read_back};

    #[test]
    fn a_preview_keeps_the_shape_of_the_picture() {
        assert_eq!(fitting([1280, 720]), [320, 180]);
        assert_eq!(fitting([5120, 1440]), [320, 90]);
        assert_eq!(fitting([1024, 768]), [240, 180]);
        assert_eq!(fitting([100, 60]), [100, 60]);
        assert_eq!(fitting([0, 0]), [1, 1]);
    }

    #[test]
    fn previews_come_eight_times_a_second_or_twice_on_software_rendering() {
        let gpu = Gpu::shared().expect("a graphics adapter is needed");
        let mut preview = Preview::new(gpu, OFFSCREEN);
        let every_ms = if gpu.is_software() { 500 } else { 125 };
        let begin = crate::desktop::event_loop::now();
        let mut taken = |after_ms: u64, size: [u32; 2]| {
            let canvas = preview.canvas(gpu, begin + Duration::from_millis(after_ms), size);
            canvas.map(|canvas| [canvas.texture().width(), canvas.texture().height()])
        };
        assert_eq!(taken(0, [64, 36]), Some([64, 36]), "the first at once");
        assert_eq!((taken(1, [64, 36]), taken(every_ms - 1, [64, 36])), (None, None));
        assert_eq!(taken(every_ms, [64, 36]), Some([64, 36]));
        // A new size of the window applies to the next preview.
        assert_eq!((taken(every_ms + 1, [640, 480]), taken(2 * every_ms, [640, 480])), (None, Some([640, 480])));
        assert_eq!([preview.view().texture().width(), preview.view().texture().height()], [240, 180]);
    }

    #[test]
    fn the_driver_sees_the_same_frame_and_the_experimenter_its_preview() {
        let gpu = Gpu::shared().expect("a graphics adapter is needed");
        let mut preview = Preview::new(gpu, OFFSCREEN);
        let canvas = preview.canvas(gpu, crate::desktop::event_loop::now(), [640, 360]).expect("the first at once");
        let screen = preview.pass.canvas(&gpu.device, [640, 360]);
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &canvas,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color { r: 0.0, g: 1.0, b: 0.0, a: 1.0 }),
                    store: wgpu::StoreOp::Store,
                },
            })],
            ..Default::default()
        });
        gpu.queue.submit([encoder.finish()]);
        preview.hand_on(gpu, &canvas, &screen);
        for (view, size) in [(&screen, 640 * 360), (preview.view(), 320 * 180)] {
            let bytes = read_back(gpu, view.texture(), 4).unwrap();
            assert_eq!(bytes.len(), 4 * size);
            assert!(bytes.chunks(4).all(|pixel| pixel == [0, 255, 0, 255]));
        }
    }
}
