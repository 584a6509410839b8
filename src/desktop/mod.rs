//! Windows as building blocks: common parts of `codrive drive`, a session of a study and a replay. In: winit's event
//! loop, contents. Out: pictures on screens. Nothing here depends on drives or sessions.
//!
//! * [`DriverWindow`]: the driver's picture, alone or with an egui overlay; it owns the graphics device and is opened
//!   first.
//! * [`ExperimenterWindow`]: a second window on the same device, all egui, drawn a few times a second after the
//!   driver's frames.
//! * [`TaskWindow`]: the display of a secondary task, drawn when it changes.
//!
//! The loop itself is in [`event_loop`]: its [`Windows`](event_loop::Windows) pass every window its own events (by
//! [`WindowId`](winit::window::WindowId)), draw the picture each turn and the experimenter's window when it is
//! [due](ExperimenterWindow::due).

pub mod display;
mod driver_window;
pub mod event_loop;
mod experimenter_window;
pub mod keys;
mod preview;
mod side_window;
mod surface;
mod task_window;

pub use driver_window::{DriverWindow, WindowSetup};
pub use experimenter_window::ExperimenterWindow;
pub use task_window::TaskWindow;

use egui::{Context, FullOutput, Ui, ViewportId};
use winit::{
    event::WindowEvent,
    window::{Fullscreen, Window},
};

use crate::render::Gpu;

/// Toggles full screen on the monitor that shows the window.
fn toggle_fullscreen(window: &Window) {
    let full = window.fullscreen().is_some();
    window.set_fullscreen((!full).then(|| Fullscreen::Borderless(None)));
}

/// An egui context in a window: receives the window's events and produces shapes.
struct EguiWindow {
    ctx: Context,
    input: egui_winit::State,
}

impl EguiWindow {
    fn new(gpu: &Gpu, window: &Window) -> Self {
        let ctx = Context::default();
        let most = gpu.device.limits().max_texture_dimension_2d as usize;
        let scale = Some(window.scale_factor() as f32);
        let input = egui_winit::State::new(ctx.clone(), ViewportId::ROOT, window, scale, None, Some(most));
        Self { ctx, input }
    }

    /// Passes an event to egui. Returns true if egui uses it.
    fn handle_event(&mut self, window: &Window, event: &WindowEvent) -> bool {
        self.input.on_window_event(window, event).consumed
    }

    /// Runs one pass of the content.
    fn run(&mut self, window: &Window, live: impl FnMut(&mut Ui)) -> FullOutput {
        let mut output = self.ctx.run_ui(self.input.take_egui_input(window), live);
        self.input.handle_platform_output(window, std::mem::take(&mut output.platform_output));
        output
    }
}
