//! Window beside the driver's, on the same graphics device, all egui. In: its attributes, its content as egui code. Out: pictures that do not wait
//! for the window's own screen.
//!
//! F11 toggles full screen.

use super::{EguiWindow, driver_window::put_on, event_loop::no_display, surface::WindowSurface, toggle_fullscreen};
use crate::{
    drive_loop::RunError,
    render::{Gpu, GpuError, post::ui_pass::UiPass},
};
use egui::{FullOutput, Ui};
use std::sync::Arc;
use winit::{
    event::{ElementState, WindowEvent},
    event_loop::ActiveEventLoop,
    keyboard::{KeyCode, PhysicalKey},
    window::{Window, WindowAttributes},
};

/// Window with its surface and its egui context.
pub(super) struct SideWindow {
    pub window: Arc<Window>,
    pub egui: EguiWindow,
    pub pass: UiPass,
    surface: WindowSurface,
}

impl SideWindow {
    /// Opens the window. `gpu` is the driver's window's; all calls need the same one.
    ///
    /// # Errors
    /// No display, or the adapter cannot draw to this window.
    pub fn open(event_loop: &ActiveEventLoop, gpu: &Gpu, attributes: WindowAttributes) -> Result<Self, RunError> {
        let window = event_loop.create_window(attributes).map_err(|error| no_display(&error))?;
        let window = Arc::new(window);
        let surface =
            gpu.instance.create_surface(Arc::clone(&window)).map_err(|error| GpuError::NoSurface(error.to_string()))?;
        let size = window.inner_size();
        let surface = WindowSurface::new(gpu, surface, [size.width, size.height], wgpu::PresentMode::AutoNoVsync)
            .ok_or_else(|| RunError::NoSurface(gpu.description()))?;
        let egui = EguiWindow::new(gpu, &window);
        let pass = UiPass::new(&gpu.device, surface.format());
        Ok(Self { window, egui, pass, surface })
    }

    /// Handles an event of this window. Closing it is left to the loop.
    pub fn on_event(&mut self, gpu: &Gpu, event: &WindowEvent) {
        if let WindowEvent::Resized(size) = event {
            self.surface.resize(gpu, [size.width, size.height]);
        }
        if let WindowEvent::KeyboardInput { event: key, is_synthetic: false, .. } = event
            && key.physical_key == PhysicalKey::Code(KeyCode::F11)
            && key.state == ElementState::Pressed
            && !key.repeat
        {
            toggle_fullscreen(&self.window);
        }
        self.egui.handle_event(&self.window, event);
    }

    /// Runs one pass of the content, for [`Self::present`].
    pub fn run(&mut self, live: impl FnMut(&mut Ui)) -> FullOutput {
        self.egui.run(&self.window, live)
    }

    /// Draws a pass on black and presents it. Returns false if the window has no surface now: try again at the next frame.
    pub fn present(&mut self, gpu: &Gpu, output: FullOutput) -> bool {
        let Gpu { device, queue, .. } = gpu;
        let Some(texture) = self.surface.next(gpu) else {
            self.pass.keep_textures(device, queue, output);
            return false;
        };
        let screen = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let clear = Some(wgpu::Color::BLACK);
        put_on(device, queue, &mut self.pass, &self.egui.ctx, output, &screen, self.surface.size(), clear);
        self.window.pre_present_notify();
        queue.present(texture);
        true
    }
}
