//! The driver's window. In: a [`StaticScene`] once, a [`View`] per frame, the egui overlay. Out: frames on the screen,
//! and a small copy of them for the experimenter.
//!
//! The window owns the overlay. Its context stays the same when another static scene goes to the GPU. It can be drawn
//! without any scene, before the first drive of a session.

use super::{
    EguiWindow,
    display::{self, WindowPlacement},
    event_loop::{no_display, now},
    preview::Preview,
    surface::WindowSurface,
};
use crate::{
    drive_loop::RunError,
    record::manifest::ScreenInfo,
    render::{
        Gpu, PassTimes, Renderer, ShaderFault,
        post::{
            preview::PreviewPass,
            ui_pass::{OverlayTarget, UiPass},
        },
        renderer_that_keeps_up,
    },
    scenario::QualityLevel,
    scene::{StaticScene, View},
};
use egui::{Context, FullOutput, Ui};
use std::sync::Arc;
use winit::{
    dpi::LogicalSize,
    event::WindowEvent,
    event_loop::ActiveEventLoop,
    window::{Window, WindowId},
};

/// Size of the window, and its size on software rendering: 0.1 s a frame on two cores (codrive bench).
const SIZE: LogicalSize<u32> = LogicalSize::new(1280, 720);
const SOFTWARE_SIZE: LogicalSize<u32> = LogicalSize::new(640, 360);

/// Title and placement of a window.
#[derive(Clone, Debug, Default)]
pub struct WindowSetup {
    /// Title of the window.
    pub title: String,
    /// Monitor, full screen, refresh rate.
    pub place: WindowPlacement,
}

/// Free area below the picture for a part of the overlay, and the canvas that the picture is drawn on before it is
/// placed above.
struct FooterArea {
    pass: PreviewPass,
    height: u32,
    canvas: Option<wgpu::TextureView>,
}

/// A window with the driver's picture.
pub struct DriverWindow {
    window: Arc<Window>,
    gpu: Gpu,
    surface: WindowSurface,
    renderer: Option<Renderer>,
    egui: EguiWindow,
    overlay: UiPass,
    preview: Option<Preview>,
    foot: Option<FooterArea>,
}

impl DriverWindow {
    /// Opens the window and the graphics device. Until [`Self::set_static_scene`] sets a static scene, only the overlay is shown,
    /// on black.
    ///
    /// # Errors
    /// No display, no such monitor, no graphics adapter that can draw to the window.
    pub fn open(event_loop: &ActiveEventLoop, placing: &WindowSetup) -> Result<Self, RunError> {
        let attributes = Window::default_attributes().with_title(&placing.title).with_inner_size(SIZE);
        let attributes = display::placed(attributes, event_loop, placing.place)?;
        let window = event_loop.create_window(attributes).map_err(|error| no_display(&error))?;
        let window = Arc::new(window);
        let display = Box::new(event_loop.owned_display_handle());
        let (gpu, surface) = Gpu::for_window(display, Arc::clone(&window))?;
        log::info!("graphics: {}", gpu.description());
        if gpu.is_software() && !placing.place.fullscreen {
            log::warn!(
                "no graphics card was found: the processor draws, and the window is small ({})",
                gpu.description()
            );
            let _ = window.request_inner_size(SOFTWARE_SIZE);
        }
        let size = window.inner_size();
        // A frame waits for the screen, without tearing if it is late; every adapter has this mode.
        let surface = WindowSurface::new(&gpu, surface, [size.width, size.height], wgpu::PresentMode::Fifo)
            .ok_or_else(|| RunError::NoSurface(gpu.description()))?;
        let egui = EguiWindow::new(&gpu, &window);
        let overlay = UiPass::new(&gpu.device, surface.format());
        Ok(Self { window, gpu, surface, renderer: None, egui, overlay, preview: None, foot: None })
    }

    /// Sets the static scene of the following views, and chooses a quality that keeps up. It must be called before the
    /// first view, and again when map, seed, trees or quality have changed. It takes a while and must not run during a
    /// drive. `view` is used for a trial.
    ///
    /// # Errors
    /// The device is lost.
    pub fn set_static_scene(
        &mut self,
        static_scene: &StaticScene,
        view: &View,
        level: QualityLevel,
    ) -> Result<(), RunError> {
        let (format, size) = (self.surface.format(), self.surface.size());
        self.renderer = Some(renderer_that_keeps_up(&self.gpu, static_scene, format, level, view, size)?);
        Ok(())
    }

    /// Returns the id of this window.
    pub fn id(&self) -> WindowId {
        self.window.id()
    }

    /// Returns the window itself, for its title, focus and cursor.
    pub fn window(&self) -> &Window {
        &self.window
    }

    /// Returns the graphics device, for a second window and for the manifest of a recording.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Describes the screen that shows the window.
    pub fn screen(&self) -> ScreenInfo {
        display::screen(&self.window, &self.surface)
    }

    /// Returns width and height, pixels.
    pub fn size(&self) -> [u32; 2] {
        self.surface.size()
    }

    /// Returns the overlay's context; its theme must be set (`panel::theme::apply`) before the first overlay.
    pub fn ctx(&self) -> &Context {
        &self.egui.ctx
    }

    /// Returns true while a text is being typed into the overlay: its keys are not for driving.
    pub fn is_typing(&self) -> bool {
        self.egui.ctx.text_edit_focused()
    }

    /// Returns true while a popup list is open in the overlay: Esc only closes it.
    pub fn has_open_list(&self) -> bool {
        egui::Popup::is_any_open(&self.egui.ctx)
    }

    /// Handles an event of this window: resizes the surface, and passes the event to the overlay. Returns true if the
    /// overlay uses it.
    pub fn on_event(&mut self, event: &WindowEvent) -> bool {
        if let WindowEvent::Resized(size) = event {
            self.surface.resize(&self.gpu, [size.width, size.height]);
        }
        self.egui.handle_event(&self.window, event)
    }

    /// Runs one pass of the overlay, for [`Self::draw`]. Each pass has to be drawn: egui sends its fonts once.
    pub fn overlay(&mut self, live: impl FnMut(&mut Ui)) -> FullOutput {
        self.egui.run(&self.window, live)
    }

    /// Draws a frame and presents it: `view` if there is a static scene, `overlay` over it. Returns false if the window
    /// has no surface now (hidden, being resized): the overlay's textures are kept, try again at the next frame.
    pub fn draw(&mut self, view: Option<&View>, overlay: Option<FullOutput>) -> bool {
        let Some(texture) = self.surface.next(&self.gpu) else {
            if let Some(output) = overlay {
                self.overlay.keep_textures(&self.gpu.device, &self.gpu.queue, output);
            }
            return false;
        };
        let screen = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let size = self.surface.size();
        let canvas = self.preview.as_mut().and_then(|preview| preview.canvas(&self.gpu, now(), size));
        let target = canvas.as_ref().unwrap_or(&screen);
        let clear = match (view, &mut self.renderer) {
            (Some(view), Some(renderer)) => {
                match self.foot.as_mut().filter(|foot| foot.height > 0 && foot.height < size[1]) {
                    None => renderer.draw(view, None, target, size),
                    Some(foot) => foot.draw(&self.gpu, [size[0], size[1] - foot.height], target, |canvas, size| {
                        renderer.draw(view, None, canvas, size);
                    }),
                }
                None
            }
            _ => Some(wgpu::Color::BLACK),
        };
        if overlay.is_some() || clear.is_some() {
            let output = overlay.unwrap_or_else(|| self.egui.run(&self.window, |_| ()));
            let Gpu { device, queue, .. } = &self.gpu;
            put_on(device, queue, &mut self.overlay, &self.egui.ctx, output, target, size, clear);
        }
        if let (Some(preview), Some(canvas)) = (&self.preview, &canvas) {
            preview.hand_on(&self.gpu, canvas, &screen);
        }
        self.window.pre_present_notify();
        self.gpu.queue.present(texture);
        true
    }

    /// Leaves this many pixels free below the picture from the next frame on.
    pub fn leave_foot(&mut self, height: u32) {
        if height > 0 || self.foot.is_some() {
            let (device, format) = (&self.gpu.device, self.surface.format());
            let fresh = || FooterArea { pass: PreviewPass::new(device, format), height, canvas: None };
            self.foot.get_or_insert_with(fresh).height = height;
        }
    }

    /// Enables the small copy of the driver's picture.
    pub fn keep_preview(&mut self) {
        if self.preview.is_none() {
            self.preview = Some(Preview::new(&self.gpu, self.surface.format()));
        }
    }

    /// Returns the driver's last picture, at most 320 by 180 pixels in its own shape. It is at most an eighth of a
    /// second old, half a second on software rendering. `None` unless [`Self::keep_preview`] was called.
    pub fn preview(&self) -> Option<&wgpu::TextureView> {
        self.preview.as_ref().map(Preview::view)
    }

    /// Toggles full screen on the window's current monitor.
    pub fn toggle_fullscreen(&self) {
        super::toggle_fullscreen(&self.window);
    }

    /// Returns the time of each pass on the device, a few frames ago; `None` if the adapter has no timestamps.
    pub fn pass_times(&self) -> Option<PassTimes> {
        self.renderer.as_ref().and_then(Renderer::pass_times)
    }

    /// Reloads the shaders from the directory `shaders`; if one is faulty, all stay as they were.
    ///
    /// # Errors
    /// `shaders/FILE.wgsl:LINE: message`.
    pub fn reload_shaders(&mut self) -> Result<(), ShaderFault> {
        self.renderer.as_mut().map_or(Ok(()), Renderer::reload_shaders)
    }
}

impl FooterArea {
    /// Draws a picture of `size` with `draw`, and places it above the free area.
    fn draw(
        &mut self,
        gpu: &Gpu,
        size: [u32; 2],
        target: &wgpu::TextureView,
        draw: impl FnOnce(&wgpu::TextureView, [u32; 2]),
    ) {
        let fits = |canvas: &wgpu::TextureView| [canvas.texture().width(), canvas.texture().height()] == size;
        if !self.canvas.as_ref().is_some_and(fits) {
            self.canvas = Some(self.pass.canvas(&gpu.device, size));
        }
        let Some(canvas) = &self.canvas else { return };
        draw(canvas, size);
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("foot") });
        self.pass.draw(&gpu.device, &mut encoder, canvas, target, Some(size));
        gpu.queue.submit([encoder.finish()]);
    }
}

/// Draws an egui pass onto a picture, after filling it with `clear` if that is a colour.
#[expect(clippy::too_many_arguments, reason = "one frame's facts, named once by each window")]
pub fn put_on(
    device: &wgpu::Device,
    queue: &wgpu::Queue,
    pass: &mut UiPass,
    ctx: &Context,
    output: FullOutput,
    view: &wgpu::TextureView,
    size: [u32; 2],
    clear: Option<wgpu::Color>,
) {
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("overlay") });
    if let Some(colour) = clear {
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("clear"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(colour), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
    }
    pass.draw(OverlayTarget { device, queue, encoder: &mut encoder, view, size, stamps: None }, ctx, output);
    queue.submit([encoder.finish()]);
}

#[cfg(test)]
#[path = "driver_window_tests.rs"]
mod tests;
