//! Event loop of every program with windows: it opens them once, passes on their events, draws each turn, and ends when
//! it is closed, stopped or failed. In: a [`Windows`] type, its parts, a flag for Ctrl-C. Out: the windows when the
//! loop is over.

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

/// Action of the loop after an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LoopControl {
    /// Wait for the next event.
    GoOn,
    /// End the loop and close the windows.
    End,
}

/// One or more windows and their content.
pub trait Windows: Sized {
    /// Parts of the windows, kept until there is a loop to open them on.
    type WindowParts;

    /// Opens the windows.
    ///
    /// # Errors
    /// No display or graphics, or the content cannot start.
    fn open(event_loop: &ActiveEventLoop, parts: Self::WindowParts) -> Result<Self, RunError>;

    /// Handles an event of a window; [`WindowEvent::RedrawRequested`] comes each turn.
    ///
    /// # Errors
    /// The content cannot continue.
    fn handle_event(&mut self, id: WindowId, event: WindowEvent) -> Result<LoopControl, RunError>;

    /// Returns the window that is drawn each turn.
    fn first(&self) -> &Window;

    /// Returns false while the loop must not end on Ctrl-C; it then ends as soon as it may.
    fn may_end(&mut self) -> bool {
        true
    }
}

/// Variable of the environment by which winit scales windows on X11.
const SCALE: &str = "WINIT_X11_SCALE_FACTOR";
/// Smallest and largest scale of windows. At the largest, the sides of a window of 1280 points still fit into a picture
/// ([`MAX_SIDE`](crate::render::MAX_SIDE)).
const SCALES: [f64; 2] = [0.25, 6.0];

/// Creates a loop that polls instead of waiting.
///
/// # Errors
/// There is no display, or the environment's scale of windows is not a scale.
pub fn event_loop() -> Result<EventLoop<()>, RunError> {
    std::env::var_os(SCALE).map_or(Ok(()), |value| check_scale(&value.to_string_lossy()))?;
    let event_loop = EventLoop::new().map_err(|error| no_display(&error))?;
    event_loop.set_control_flow(ControlFlow::Poll);
    Ok(event_loop)
}

/// Runs an application until it ends the loop. It is passed as a trait object, so that winit's loop, half a megabyte,
/// is compiled once for all applications.
///
/// # Errors
/// The display is lost.
pub fn run_application(
    event_loop: EventLoop<()>,
    mut application: &mut dyn ApplicationHandler,
) -> Result<(), RunError> {
    event_loop.run_app(&mut application).map_err(|error| no_display(&error))
}

/// Runs `W` until it ends, fails, or `stop` becomes true. Also returns `W`, if it was opened, so that it can finish its
/// work.
pub fn run<W: Windows>(
    event_loop: EventLoop<()>,
    parts: W::WindowParts,
    stop: &AtomicBool,
) -> (Option<W>, Result<(), RunError>) {
    let mut windowed = WindowedLoop::<W> { stop, parts: Some(parts), windows: None, failure: None };
    let ran = run_application(event_loop, &mut windowed);
    (windowed.windows, windowed.failure.map_or(ran, Err))
}

struct WindowedLoop<'a, W: Windows> {
    stop: &'a AtomicBool,
    parts: Option<W::WindowParts>,
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
        match windows.handle_event(id, event) {
            Ok(LoopControl::GoOn) => {}
            Ok(LoopControl::End) => event_loop.exit(),
            Err(error) => self.fail(event_loop, error),
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        if self.stop.load(Ordering::Relaxed) && self.windows.as_mut().is_none_or(W::may_end) {
            event_loop.exit();
        }
        if let Some(windows) = &self.windows {
            windows.first().request_redraw();
        }
    }
}

/// Checks a scale of windows as winit reads it, which panics at others: an empty one is none.
fn check_scale(value: &str) -> Result<(), RunError> {
    let inside = |scale: f64| (SCALES[0]..=SCALES[1]).contains(&scale);
    if value.is_empty() || value.eq_ignore_ascii_case("randr") || value.parse().is_ok_and(inside) {
        return Ok(());
    }
    Err(RunError::NoScale { variable: SCALE, value: value.to_owned(), range: SCALES })
}

/// Returns the error for a missing display, with the variables that name one and without the source position that winit puts in front.
pub fn no_display(error: &impl std::fmt::Display) -> RunError {
    let text = error.to_string();
    let message =
        text.split_once(".rs:").and_then(|(_, rest)| rest.split_once(": ")).map_or(text.as_str(), |(_, why)| why);
    let named = ["WAYLAND_DISPLAY", "WAYLAND_SOCKET", "DISPLAY"].iter().filter_map(|variable| {
        let value = std::env::var_os(variable).filter(|value| !value.is_empty())?;
        Some(format!("{variable}={}: ", value.to_string_lossy()))
    });
    RunError::NoDisplay(format!("{}{}", named.collect::<String>(), message.trim_end_matches('.')))
}

/// Returns the wall time, for the loop.
#[allow(clippy::disallowed_methods, reason = "the loop is where wall time enters")]
pub fn now() -> Instant {
    Instant::now()
}
