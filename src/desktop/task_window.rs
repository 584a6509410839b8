//! Window of a secondary task on a display of its own. In: the task's content in each frame of the driver's window. Out: a picture each time that the
//! content changes, right after the driver's frame.

use super::{
    display::{self, WindowPlacement},
    side_window::SideWindow,
};
use crate::{
    drive_loop::RunError,
    render::{Gpu, dial::paint_search_display},
    snapshot::TaskPicture,
};
use egui::LayerId;
use winit::{
    dpi::{LogicalSize, PhysicalPosition},
    event::WindowEvent,
    event_loop::ActiveEventLoop,
    window::{Window, WindowId},
};

/// Title of the window.
const TITLE: &str = "codrive: secondary task";
const SIZE: LogicalSize<u32> = LogicalSize::new(640, 400);
/// Offset from the corner of its monitor, pixels; the experimenter's window is at another one.
const OFFSET: i32 = 80;

/// Window for the display of a secondary task.
pub struct TaskWindow {
    side: SideWindow,
    /// Content of the picture on the screen; `None` if it has to be drawn.
    shown: Option<TaskPicture>,
}

impl TaskWindow {
    /// Opens the window at its place; without a monitor of its own on another one than the window `driver`, if there is one. `gpu` is the driver's
    /// window's; all calls need the same one.
    ///
    /// # Errors
    /// No display, no such monitor, or the adapter cannot draw to this window.
    pub fn open(
        event_loop: &ActiveEventLoop,
        gpu: &Gpu,
        driver: &Window,
        place: WindowPlacement,
    ) -> Result<Self, RunError> {
        let mut attributes = Window::default_attributes().with_title(TITLE).with_inner_size(SIZE);
        match display::another(event_loop, driver).filter(|_| place.monitor.is_none()) {
            Some(monitor) => {
                let PhysicalPosition { x, y } = monitor.position();
                attributes = attributes.with_position(PhysicalPosition::new(x + OFFSET, y + OFFSET));
            }
            None => attributes = display::placed(attributes, event_loop, place)?,
        }
        Ok(Self { side: SideWindow::open(event_loop, gpu, attributes)?, shown: None })
    }

    /// Returns the id of this window.
    pub fn id(&self) -> WindowId {
        self.side.window.id()
    }

    /// Handles an event of this window. Closing it and the keys of the driver are left to the loop.
    pub fn on_event(&mut self, gpu: &Gpu, event: &WindowEvent) {
        if matches!(event, WindowEvent::Resized(_) | WindowEvent::RedrawRequested) {
            self.shown = None;
        }
        self.side.on_event(gpu, event);
    }

    /// Shows the task, unless the window shows it already.
    pub fn draw(&mut self, gpu: &Gpu, task: TaskPicture) {
        if self.shown == Some(task) {
            return;
        }
        let output = self.side.run(|ui| {
            let painter = ui.ctx().layer_painter(LayerId::background());
            paint_search_display(&painter, ui.ctx().content_rect(), task);
        });
        self.shown = self.side.present(gpu, output).then_some(task);
    }
}
