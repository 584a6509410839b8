//! The experimenter's window. In: its content as egui code. Out: a window beside the driver's, drawn a few times a
//! second between the driver's frames. It takes at most a twelfth of their time, more only after input, and does not
//! wait for its own screen.
//!
//! Ctrl + and Ctrl - change the scale of everything from 1.0 to 2.0, Ctrl 0 resets it; F11 toggles full screen.

use super::{display, event_loop::now, side_window::SideWindow};
use crate::{drive_loop::RunError, panel::theme, render::Gpu};
use egui::{Context, TextureId, Ui};
use std::time::{Duration, Instant};
use winit::{
    dpi::{LogicalSize, PhysicalPosition},
    event::{ElementState, WindowEvent},
    event_loop::ActiveEventLoop,
    window::{Window, WindowId},
};

/// Minimum time between two pictures: 12.5 a second at most. On software rendering 2 a second, because the driver's
/// picture needs the same processor: 1280 x 800 pixels take as long as a frame of the driver's, 70 ms on two cores.
const EVERY: Duration = Duration::from_millis(80);
const EVERY_BY_SOFTWARE: Duration = Duration::from_millis(500);
/// Minimum time between two pictures as a multiple of the time of one picture, which limits the window to a twelfth of
/// the loop. After a key, which needs a quick response, one picture may take a quarter. A click and a key with Ctrl are
/// drawn at once.
const RESTS: u32 = 12;
const RESTS_AFTER_INPUT: u32 = 4;
const SIZE: LogicalSize<u32> = LogicalSize::new(1280, 800);
const LEAST: LogicalSize<u32> = LogicalSize::new(800, 500);
/// Limits of the scale of everything, on top of the monitor's own.
const ZOOM: [f32; 2] = [1.0, 2.0];

/// Window for the experimenter.
pub struct ExperimenterWindow {
    side: SideWindow,
    last: Option<Instant>,
    /// Time that the last picture took in the loop.
    took: Duration,
    /// True if there was input since the last picture, or the picture has to change once more.
    asked: bool,
    /// True if a click or a key of a command waits, which must act before the next frame of the driver's.
    is_urgent: bool,
    has_command_key: bool,
    by_software: bool,
    picture: Option<(wgpu::TextureView, TextureId)>,
}

impl ExperimenterWindow {
    /// Opens the window, on another monitor than the window `driver` if there is one. `gpu` is the driver's window's;
    /// all calls need the same one.
    ///
    /// # Errors
    /// No display, or the adapter cannot draw to this window.
    pub fn open(event_loop: &ActiveEventLoop, gpu: &Gpu, driver: &Window, title: &str) -> Result<Self, RunError> {
        let mut attributes =
            Window::default_attributes().with_title(title).with_inner_size(SIZE).with_min_inner_size(LEAST);
        if let Some(monitor) = display::another(event_loop, driver) {
            let PhysicalPosition { x, y } = monitor.position();
            attributes = attributes.with_position(PhysicalPosition::new(x + 40, y + 40));
        }
        let side = SideWindow::open(event_loop, gpu, attributes)?;
        theme::apply(&side.egui.ctx);
        Ok(Self {
            side,
            last: None,
            took: Duration::ZERO,
            asked: false,
            is_urgent: false,
            has_command_key: false,
            by_software: gpu.is_software(),
            picture: None,
        })
    }

    /// Returns the id of this window.
    pub fn id(&self) -> WindowId {
        self.side.window.id()
    }

    /// Returns the window itself, for its title and focus.
    pub fn window(&self) -> &Window {
        &self.side.window
    }

    /// Returns the egui context of the window.
    pub fn ctx(&self) -> &Context {
        &self.side.egui.ctx
    }

    /// Handles an event of this window. Closing it is left to the loop.
    pub fn on_event(&mut self, gpu: &Gpu, event: &WindowEvent) {
        use WindowEvent::{KeyboardInput, ModifiersChanged, MouseInput, MouseWheel};
        if let ModifiersChanged(modifiers) = event {
            let state = modifiers.state();
            self.has_command_key = state.control_key() || state.super_key();
        }
        self.is_urgent |= match event {
            KeyboardInput { event: key, .. } => {
                self.has_command_key && key.state == ElementState::Pressed && !key.repeat
            }
            MouseInput { .. } => true,
            _ => false,
        };
        self.asked |= matches!(event, KeyboardInput { .. } | MouseInput { .. } | MouseWheel { .. });
        self.side.on_event(gpu, event);
    }

    /// Returns true when it is time for the next picture.
    pub fn due(&self) -> bool {
        if self.is_urgent {
            return true;
        }
        let rest = match (self.asked, self.by_software) {
            (true, _) => EVERY.max(RESTS_AFTER_INPUT * self.took),
            (false, true) => EVERY_BY_SOFTWARE.max(RESTS * self.took),
            (false, false) => EVERY.max(RESTS * self.took),
        };
        self.last.is_none_or(|last| now().saturating_duration_since(last) >= rest)
    }

    /// Registers a texture (a preview of the driver's picture) with egui, to be shown in this window. There is one at a
    /// time: another replaces it.
    pub fn picture(&mut self, gpu: &Gpu, view: &wgpu::TextureView) -> TextureId {
        let renderer = self.side.pass.renderer();
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

    /// Draws one picture; `live` runs in the root [`Ui`].
    pub fn draw(&mut self, gpu: &Gpu, live: impl FnMut(&mut Ui)) {
        let begin = now();
        self.last = Some(begin);
        self.is_urgent = false;
        let output = self.side.run(live);
        // A widget that has just got the focus is drawn so in the next pass, which egui requests.
        let root = output.viewport_output.get(&egui::ViewportId::ROOT);
        self.asked = root.is_some_and(|root| root.repaint_delay.is_zero());
        let laid_out = now();
        let ctx = &self.side.egui.ctx;
        let zoom = ctx.zoom_factor();
        if !(ZOOM[0]..=ZOOM[1]).contains(&zoom) {
            ctx.set_zoom_factor(zoom.clamp(ZOOM[0], ZOOM[1]));
        }
        if !self.side.present(gpu, output) {
            return;
        }
        self.took = now().saturating_duration_since(begin);
        log::debug!(
            "the experimenter's picture took {:.1} ms, {:.1} ms of them for the layout",
            self.took.as_secs_f64() * 1e3,
            (laid_out - begin).as_secs_f64() * 1e3
        );
    }
}
