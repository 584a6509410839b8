//! What every program with windows does with winit's loop: it opens them once, hands on their events, draws each turn, and
//! ends when it is closed, stopped or failed. In: a [`Windows`], what it is made of, Ctrl-C. Out: the same when it is over.

use crate::drive_loop::RunError;
use std::{
    sync::atomic::{AtomicBool, Ordering},
    time::Instant,
};
use winit::{
    application::ApplicationHandler,
    event::WindowEvent,
    event_loop::{ActiveEventLoop, ControlFlow, EventLoop},
    window::{Window, WindowId},
};

/// What is to come after an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoopControl {
    /// The next event.
    GoOn,
    /// The end of the program's windows.
    End,
}

/// One or more windows and what they show.
pub trait Windows: Sized {
    /// What they are made of, until there is a loop to open them on.
    type Parts;

    /// Opens them.
    ///
    /// # Errors
    /// No display or graphics, or what they are to show cannot begin.
    fn open(event_loop: &ActiveEventLoop, parts: Self::Parts) -> Result<Self, RunError>;

    /// An event of one of them; [`WindowEvent::RedrawRequested`] comes each turn.
    ///
    /// # Errors
    /// What they show cannot go on.
    fn hear(&mut self, id: WindowId, event: WindowEvent) -> Result<LoopControl, RunError>;

    /// The one that is drawn each turn.
    fn first(&self) -> &Window;
}

/// A loop that does not wait.
///
/// # Errors
/// There is no display.
pub fn event_loop() -> Result<EventLoop<()>, RunError> {
    let event_loop = EventLoop::new().map_err(|error| no_display(&error))?;
    event_loop.set_control_flow(ControlFlow::Poll);
    Ok(event_loop)
}

/// Runs an application until it ends the loop. By reference to whatever it is: winit's loop, half a megabyte, is compiled once for all
/// of them.
///
/// # Errors
/// The display is gone.
pub fn run_application(
    event_loop: EventLoop<()>,
    mut application: &mut dyn ApplicationHandler,
) -> Result<(), RunError> {
    event_loop.run_app(&mut application).map_err(|error| no_display(&error))
}

/// Runs `W` until it ends, fails, or `stop` becomes true. Returns it too, if it was opened: it may have things to finish.
pub fn run<W: Windows>(
    event_loop: EventLoop<()>,
    parts: W::Parts,
    stop: &AtomicBool,
) -> (Option<W>, Result<(), RunError>) {
    let mut windowed = WindowedLoop::<W> { stop, parts: Some(parts), windows: None, failure: None };
    let ran = run_application(event_loop, &mut windowed);
    (windowed.windows, windowed.failure.map_or(ran, Err))
}

struct WindowedLoop<'a, W: Windows> {
    stop: &'a AtomicBool,
    parts: Option<W::Parts>,
    windows: Option<W>,
    failure: Option<RunError>,
}

impl<W: Windows> WindowedLoop<'_, W> {
    fn fail(&mut self, event_loop: &ActiveEventLoop, error: RunError) {
        self.failure = Some(error);
        event_loop.exit();
    }
}

impl<W: Windows> ApplicationHandler for WindowedLoop<'_, W> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        let Some(parts) = self.parts.take() else { return };
        match W::open(event_loop, parts) {
            Ok(windows) => self.windows = Some(windows),
            Err(error) => self.fail(event_loop, error),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, id: WindowId, event: WindowEvent) {
        let Some(windows) = &mut self.windows else { return };
        match windows.hear(id, event) {
            Ok(LoopControl::GoOn) => {}
            Ok(LoopControl::End) => event_loop.exit(),
            Err(error) => self.fail(event_loop, error),
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        if self.stop.load(Ordering::Relaxed) {
            event_loop.exit();
        }
        if let Some(windows) = &self.windows {
            windows.first().request_redraw();
        }
    }
}

/// That there is no display, without the place in winit's sources where that was found out.
pub fn no_display(error: &impl std::fmt::Display) -> RunError {
    let text = error.to_string();
    let told =
        text.split_once(".rs:").and_then(|(_, rest)| rest.split_once(": ")).map_or(text.as_str(), |(_, why)| why);
    RunError::NoDisplay(told.trim_end_matches('.').to_owned())
}

/// Wall time, for the loop.
#[allow(clippy::disallowed_methods, reason = "the loop is where wall time enters")]
pub fn now() -> Instant {
    Instant::now()
}
