//! Draws the output of egui over a picture. In: a pass of an egui [`Context`] (its [`FullOutput`]) and a view of the
//! picture. Out: commands. Colours are sRGB values, written unchanged: the target's format has to be a plain `Unorm`.

use crate::render::device::cost::PassCost;
use egui::{Context, FullOutput, TextureId, epaint::Primitive};

/// Target of a pass over a finished picture.
pub struct OverlayTarget<'a> {
    /// Device of the picture.
    pub device: &'a wgpu::Device,
    /// Queue of the device.
    pub queue: &'a wgpu::Queue,
    /// Commands of this frame.
    pub encoder: &'a mut wgpu::CommandEncoder,
    /// The picture; its content is kept.
    pub view: &'a wgpu::TextureView,
    /// Width and height of the picture, pixels.
    pub size: [u32; 2],
    /// Timestamps of the pass, if it is timed.
    pub stamps: Option<wgpu::RenderPassTimestampWrites<'a>>,
}

/// Draws one egui [`Context`]. Each context needs a pass of its own for its whole life: egui sends its font atlas once,
/// and only changes after that.
pub struct UiPass {
    renderer: egui_wgpu::Renderer,
    /// Textures that egui has released. They are freed in the next frame: freeing destroys them at once, and the last
    /// frame that shows them is submitted only after egui releases them.
    done_with: Vec<TextureId>,
    cost: (PassCost, u64),
}

impl std::fmt::Debug for UiPass {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("UiPass").field("done_with", &self.done_with).finish_non_exhaustive()
    }
}

impl UiPass {
    /// Creates a pass onto targets of `format`, which must not be an sRGB format.
    pub fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Self {
        debug_assert!(!format.is_srgb(), "egui writes sRGB values itself; {format:?} would encode them twice");
        // No dithering: a colour of the dial is the same number in every pixel.
        let options = egui_wgpu::RendererOptions { dithering: false, ..Default::default() };
        Self {
            renderer: egui_wgpu::Renderer::new(device, format, options),
            done_with: Vec::new(),
            cost: Default::default(),
        }
    }

    /// Returns the renderer, to register textures of our own.
    pub fn renderer(&mut self) -> &mut egui_wgpu::Renderer {
        &mut self.renderer
    }

    /// Draws the output of `ctx` over the picture. At most once per submission: a second call before `queue.submit`
    /// would overwrite the vertices of the first.
    pub fn draw(&mut self, target: OverlayTarget<'_>, ctx: &Context, mut output: FullOutput) {
        let OverlayTarget { device, queue, encoder, view, size, stamps } = target;
        self.take_textures(device, queue, &mut output);

        let screen = egui_wgpu::ScreenDescriptor { size_in_pixels: size, pixels_per_point: output.pixels_per_point };
        let meshes = ctx.tessellate(output.shapes, output.pixels_per_point);
        for mesh in &meshes {
            // Each primitive covers one rectangle of the screen. Paint callbacks are not used here.
            if let Primitive::Mesh(mesh) = &mesh.primitive {
                self.cost.0 += PassCost { draws: 1, instances: 1, triangles: mesh.indices.len() as u64 / 3 };
                self.cost.1 += (size_of_val(&mesh.indices[..]) + size_of_val(&mesh.vertices[..])) as u64;
            }
        }
        let uploads = self.renderer.update_buffers(device, queue, encoder, &meshes, &screen);
        if !uploads.is_empty() {
            queue.submit(uploads);
        }
        let mut pass = encoder
            .begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("ui"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
                })],
                timestamp_writes: stamps,
                ..Default::default()
            })
            .forget_lifetime();
        self.renderer.render(&mut pass, &meshes, &screen);
    }

    /// Takes the textures of an output that is not drawn, because the window has no surface now: egui sends each
    /// texture once.
    pub fn keep_textures(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, mut output: FullOutput) {
        self.take_textures(device, queue, &mut output);
    }

    /// Returns the cost and the bytes written since the last call.
    pub fn take_cost(&mut self) -> (PassCost, u64) {
        std::mem::take(&mut self.cost)
    }

    fn take_textures(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, output: &mut FullOutput) {
        for id in self.done_with.drain(..) {
            self.renderer.free_texture(&id);
        }
        for (id, deltas) in output.textures_delta.set.drain() {
            for delta in &deltas {
                self.cost.1 += (delta.image.width() * delta.image.height() * delta.image.bytes_per_pixel()) as u64;
                self.renderer.update_texture(device, queue, id, delta);
            }
        }
        self.done_with.extend(output.textures_delta.free.drain());
    }
}
