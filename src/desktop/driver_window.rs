//! The driver's window. In: a [`StaticScene`] once, a [`View`] a frame, what egui draws over it. Out: frames on the screen, and
//! a small copy of them for the experimenter.
//!
//! The overlay is the window's own: its context stays the same when another stage goes to the GPU, and it can be drawn
//! without any stage, before the first drive of a session.

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

/// Size of the window, and of one that the processor draws: 0.1 s a frame on two cores (codrive bench).
const SIZE: LogicalSize<u32> = LogicalSize::new(1280, 720);
const SOFTWARE_SIZE: LogicalSize<u32> = LogicalSize::new(640, 360);

/// Where and how a window opens.
#[derive(Clone, Debug, Default)]
pub struct WindowSetup {
    /// What the window manager writes on it.
    pub title: String,
    /// Monitor, full screen, refresh rate.
    pub place: WindowPlacement,
}

/// Room below the picture for what is drawn over the window, and where the picture is drawn meanwhile.
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
    /// Opens the window and the graphics device. There is no stage yet: until [`Self::stage`] only what egui draws is
    /// seen, on black.
    ///
    /// # Errors
    /// No display, no such monitor, no graphics adapter that can draw into the window.
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
                "no graphics card was found: the processor draws, so the window is small ({})",
                gpu.description()
            );
            let _ = window.request_inner_size(SOFTWARE_SIZE);
        }
        let size = window.inner_size();
        // A frame waits for the screen, without tearing where it is late; every adapter has this mode.
        let surface = WindowSurface::new(&gpu, surface, [size.width, size.height], wgpu::PresentMode::Fifo)
            .ok_or_else(|| RunError::NoSurface(gpu.description()))?;
        let egui = EguiWindow::new(&gpu, &window);
        let overlay = UiPass::new(&gpu.device, surface.format());
        Ok(Self { window, gpu, surface, renderer: None, egui, overlay, preview: None, foot: None })
    }

    /// From here on views of `stage` are drawn, in a quality that keeps up. To be called before the first view, and again
    /// when map, seed, trees or quality have changed; it takes a while and is no part of a drive. `view` is one to try
    /// with.
    ///
    /// # Errors
    /// The device is lost.
    pub fn stage(&mut self, stage: &StaticScene, view: &View, level: QualityLevel) -> Result<(), RunError> {
        let (format, size) = (self.surface.format(), self.surface.size());
        self.renderer = Some(renderer_that_keeps_up(&self.gpu, stage, format, level, view, size)?);
        Ok(())
    }

    /// Which window this is.
    pub fn id(&self) -> WindowId {
        self.window.id()
    }

    /// The window itself, for its title, its focus, its cursor.
    pub fn window(&self) -> &Window {
        &self.window
    }

    /// The graphics device, for a second window and for the manifest of a recording.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// The screen that the pictures come to.
    pub fn screen(&self) -> ScreenInfo {
        display::screen(&self.window, &self.surface)
    }

    /// Width and height, pixels.
    pub fn size(&self) -> [u32; 2] {
        self.surface.size()
    }

    /// The overlay's context: to be dressed (`panel::theme::apply`) before the first overlay.
    pub fn ctx(&self) -> &Context {
        &self.egui.ctx
    }

    /// True while a text is being typed into the overlay: its keys are not for driving.
    pub fn is_typing(&self) -> bool {
        self.egui.ctx.text_edit_focused()
    }

    /// True while a list hangs open in the overlay: Esc closes it, and nothing else.
    pub fn has_open_list(&self) -> bool {
        egui::Popup::is_any_open(&self.egui.ctx)
    }

    /// An event of this window: new sizes are obeyed, the overlay hears of everything. True if the overlay has a use for
    /// it.
    pub fn on_event(&mut self, event: &WindowEvent) -> bool {
        if let WindowEvent::Resized(size) = event {
            self.surface.resize(&self.gpu, [size.width, size.height]);
        }
        self.egui.hear(&self.window, event)
    }

    /// One pass of the overlay, for [`Self::draw`]. Each pass has to be drawn: egui sends its fonts once.
    pub fn overlay(&mut self, live: impl FnMut(&mut Ui)) -> FullOutput {
        self.egui.run(&self.window, live)
    }

    /// Draws a frame and hands it to the screen: `view` if there is a stage for it, `overlay` over it. False if the window
    /// takes none now (hidden, being resized): the overlay's news are kept, try at the next frame.
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

    /// From the next frame on the picture leaves so many pixels free at the foot of the window.
    pub fn leave_foot(&mut self, height: u32) {
        if height > 0 || self.foot.is_some() {
            let (device, format) = (&self.gpu.device, self.surface.format());
            let fresh = || FooterArea { pass: PreviewPass::new(device, format), height, canvas: None };
            self.foot.get_or_insert_with(fresh).height = height;
        }
    }

    /// From here on there is a small copy of what the driver sees.
    pub fn keep_preview(&mut self) {
        if self.preview.is_none() {
            self.preview = Some(Preview::new(&self.gpu, self.surface.format()));
        }
    }

    /// What the driver saw last, an eighth of a second old at most (half where the processor draws), 320 by 180 pixels or of another shape. `None` if
    /// nobody asked for it to be kept.
    pub fn preview(&self) -> Option<&wgpu::TextureView> {
        self.preview.as_ref().map(Preview::view)
    }

    /// Fills the screen, or not.
    pub fn toggle_fullscreen(&self) {
        super::toggle_fullscreen(&self.window);
    }

    /// Time of each pass on the device, a few frames ago, where the adapter tells.
    pub fn pass_times(&self) -> Option<PassTimes> {
        self.renderer.as_ref().and_then(Renderer::pass_times)
    }

    /// Reads the shaders anew from the directory `shaders`; if one is broken, all stay as they were.
    ///
    /// # Errors
    /// `shaders/FILE.wgsl:LINE: what is wrong`.
    pub fn reload_shaders(&mut self) -> Result<(), ShaderFault> {
        self.renderer.as_mut().map_or(Ok(()), Renderer::reload_shaders)
    }
}

impl FooterArea {
    /// Lets `draw` make a picture of `size`, and puts it above the foot.
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

/// Draws an egui pass onto a picture, which is painted over first if there is a colour to `clear` with.
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
    pass.draw(OverlayTarget { device, queue, encoder: &mut encoder, view, size }, ctx, output);
    queue.submit([encoder.finish()]);
}

#[cfg(test)]
#[path = "driver_window_tests.rs"]
mod tests;
