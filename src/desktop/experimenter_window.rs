//! The experimenter's window. In: what is to be seen, as egui code. Out: a window beside the driver's, drawn a few times a
//! second between the driver's frames, of whose time it takes a twelfth at most; it does not wait for its own screen.
//!
//! Ctrl + and Ctrl - change the size of everything from 1.0 to 2.0, Ctrl 0 goes back; F11 fills the screen.

use super::{
    EguiWindow, display,
    driver_window::put_on,
    event_loop::{no_display, now},
    surface::WindowSurface,
    toggle_fullscreen,
};
use crate::{
    drive_loop::RunError,
    panel::theme,
    render::{Gpu, GpuError, post::ui_pass::UiPass},
};
use egui::{Context, TextureId, Ui};
use std::{
    sync::Arc,
    time::{Duration, Instant},
};
use winit::{
    dpi::{LogicalSize, PhysicalPosition},
    event::{ElementState, WindowEvent},
    event_loop::ActiveEventLoop,
    keyboard::{KeyCode, PhysicalKey},
    window::{Window, WindowId},
};

/// Time between two pictures of it: 12.5 a second, at most; where the processor draws, which it could do for the driver
/// meanwhile, 2 (1280 x 800 pixels of it take as long as a frame of the driver's, 70 ms on two cores).
const EVERY: Duration = Duration::from_millis(80);
const EVERY_BY_SOFTWARE: Duration = Duration::from_millis(500);
/// And so many times longer than a picture of it took: it never has more than a twelfth of the loop; after a key or a click,
/// which want an answer, for one picture a quarter.
const RESTS: u32 = 12;
const RESTS_AFTER_INPUT: u32 = 4;
const SIZE: LogicalSize<u32> = LogicalSize::new(1280, 800);
const LEAST: LogicalSize<u32> = LogicalSize::new(800, 500);
/// Scale of everything, on top of the monitor's own.
const ZOOM: [f32; 2] = [1.0, 2.0];

/// A window for whoever runs the experiment.
pub struct ExperimenterWindow {
    window: Arc<Window>,
    surface: WindowSurface,
    egui: EguiWindow,
    pass: UiPass,
    last: Option<Instant>,
    /// What the last picture took of the loop.
    took: Duration,
    /// True if a key or a button was pressed since, or the picture has to change once more.
    asked: bool,
    by_software: bool,
    picture: Option<(wgpu::TextureView, TextureId)>,
}

impl ExperimenterWindow {
    /// Opens the window, on another monitor than that of `driver` if there is one. `gpu` is the driver's window's; all
    /// calls want the same.
    ///
    /// # Errors
    /// No display, or the adapter cannot draw into this window.
    pub fn open(event_loop: &ActiveEventLoop, gpu: &Gpu, driver: &Window, title: &str) -> Result<Self, RunError> {
        let mut attributes =
            Window::default_attributes().with_title(title).with_inner_size(SIZE).with_min_inner_size(LEAST);
        if let Some(monitor) = display::another(event_loop, driver) {
            let PhysicalPosition { x, y } = monitor.position();
            attributes = attributes.with_position(PhysicalPosition::new(x + 40, y + 40));
        }
        let window = event_loop.create_window(attributes).map_err(|error| no_display(&error))?;
        let window = Arc::new(window);
        let surface =
            gpu.instance.create_surface(Arc::clone(&window)).map_err(|error| GpuError::NoSurface(error.to_string()))?;
        let size = window.inner_size();
        let surface = WindowSurface::new(gpu, surface, [size.width, size.height], wgpu::PresentMode::AutoNoVsync)
            .ok_or_else(|| RunError::NoSurface(gpu.description()))?;
        let egui = EguiWindow::new(gpu, &window);
        theme::apply(&egui.ctx);
        let pass = UiPass::new(&gpu.device, surface.format());
        Ok(Self {
            window,
            surface,
            egui,
            pass,
            last: None,
            took: Duration::ZERO,
            asked: false,
            by_software: gpu.is_software(),
            picture: None,
        })
    }

    /// Which window this is.
    pub fn id(&self) -> WindowId {
        self.window.id()
    }

    /// The window itself.
    pub fn window(&self) -> &Window {
        &self.window
    }

    /// Its context.
    pub fn ctx(&self) -> &Context {
        &self.egui.ctx
    }

    /// An event of this window. Whether it closes is the loop's to say.
    pub fn on_event(&mut self, gpu: &Gpu, event: &WindowEvent) {
        if let WindowEvent::Resized(size) = event {
            self.surface.resize(gpu, [size.width, size.height]);
        }
        use WindowEvent::{KeyboardInput, MouseInput, MouseWheel};
        if let KeyboardInput { event: key, is_synthetic: false, .. } = event
            && key.physical_key == PhysicalKey::Code(KeyCode::F11)
            && key.state == ElementState::Pressed
            && !key.repeat
        {
            toggle_fullscreen(&self.window);
        }
        self.asked |= matches!(event, KeyboardInput { .. } | MouseInput { .. } | MouseWheel { .. });
        self.egui.hear(&self.window, event);
    }

    /// True when it is time for another picture.
    pub fn due(&self) -> bool {
        let rest = match (self.asked, self.by_software) {
            (true, _) => EVERY.max(RESTS_AFTER_INPUT * self.took),
            (false, true) => EVERY_BY_SOFTWARE.max(RESTS * self.took),
            (false, false) => EVERY.max(RESTS * self.took),
        };
        self.last.is_none_or(|last| now().saturating_duration_since(last) >= rest)
    }

    /// A texture of ours (a preview of the driver's picture) as egui names it, to be shown in this window. One at a
    /// time: another takes its place.
    pub fn picture(&mut self, gpu: &Gpu, view: &wgpu::TextureView) -> TextureId {
        let renderer = self.pass.renderer();
        match &self.picture {
            Some((shown, id)) if shown == view => *id,
            Some((_, id)) => {
                renderer.update_egui_texture_from_wgpu_texture(&gpu.device, view, wgpu::FilterMode::Linear, *id);
                let id = *id;
                self.picture = Some((view.clone(), id));
                id
            }
            None => {
                let id = renderer.register_native_texture(&gpu.device, view, wgpu::FilterMode::Linear);
                self.picture = Some((view.clone(), id));
                id
            }
        }
    }

    /// One picture: `show` is run in the root [`Ui`].
    pub fn draw(&mut self, gpu: &Gpu, live: impl FnMut(&mut Ui)) {
        let begin = now();
        self.last = Some(begin);
        let output = self.egui.run(&self.window, live);
        // What has just got the keyboard is drawn so in the next pass, and egui asks for it.
        let root = output.viewport_output.get(&egui::ViewportId::ROOT);
        self.asked = root.is_some_and(|root| root.repaint_delay.is_zero());
        let laid_out = now();
        let zoom = self.egui.ctx.zoom_factor();
        if !(ZOOM[0]..=ZOOM[1]).contains(&zoom) {
            self.egui.ctx.set_zoom_factor(zoom.clamp(ZOOM[0], ZOOM[1]));
        }
        let Gpu { device, queue, .. } = gpu;
        let Some(texture) = self.surface.next(gpu) else {
            self.pass.keep_textures(device, queue, output);
            return;
        };
        let screen = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let clear = Some(wgpu::Color::BLACK);
        put_on(device, queue, &mut self.pass, &self.egui.ctx, output, &screen, self.surface.size(), clear);
        self.window.pre_present_notify();
        queue.present(texture);
        self.took = now().saturating_duration_since(begin);
        log::debug!(
            "the experimenter's picture took {:.1} ms of the loop, {:.1} of them to lay it out",
            self.took.as_secs_f64() * 1e3,
            (laid_out - begin).as_secs_f64() * 1e3
        );
    }
}
