//! Monitors, and the check screen in a window of its own (`codrive doctor --display`). In: the scenario's screen width
//! and eye distance, the requested monitor. Out: a ruler on the screen; a list of the monitors for the doctor.

use super::{
    event_loop::{self, LoopControl, Windows, no_display, now},
    surface::{FRAMES_AHEAD, WindowSurface},
};
use crate::{
    doctor::MonitorInfo,
    drive_loop::RunError,
    live_drive::latency::Latency,
    panel::{self, DisplayTruth, theme},
    record::manifest::ScreenInfo,
    render::{
        Gpu,
        post::ui_pass::{OverlayTarget, UiPass},
    },
    scenario::Scenario,
};
use std::{
    sync::{Arc, atomic::AtomicBool},
    time::Instant,
};
use winit::{
    application::ApplicationHandler,
    event::{ElementState, WindowEvent},
    event_loop::ActiveEventLoop,
    keyboard::{KeyCode, PhysicalKey},
    monitor::{MonitorHandle, VideoModeHandle},
    window::{Fullscreen, Window, WindowAttributes, WindowId},
};

/// Largest deviation from the requested refresh rate, Hz: 59.94 counts as 60.
const SAME_HZ: f64 = 0.5;

/// Placement of a window when it opens.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WindowPlacement {
    /// Number of the monitor, from 1; `None` leaves it to the system.
    pub monitor: Option<usize>,
    /// True to fill the monitor.
    pub fullscreen: bool,
    /// Refresh rate to switch the monitor to, Hz; for full screen only.
    pub refresh_hz: Option<f64>,
}

fn monitor(number: usize, handle: &MonitorHandle, primary: Option<&MonitorHandle>) -> MonitorInfo {
    let (size, mut rates): (_, Vec<f64>) = (
        handle.size(),
        handle.video_modes().filter(|mode| mode.size() == handle.size()).map(|mode| hertz(&mode)).collect(),
    );
    rates.sort_by(f64::total_cmp);
    rates.dedup_by(|a, b| (*a - *b).abs() < 0.01);
    MonitorInfo {
        number,
        name: handle.name().unwrap_or_else(|| "unnamed".into()),
        size: [size.width, size.height],
        refresh_hz: rate(handle),
        rates_hz: rates,
        primary: primary == Some(handle),
    }
}

/// Returns a monitor that does not show `window`, if there are several.
pub fn another(event_loop: &ActiveEventLoop, window: &Window) -> Option<MonitorHandle> {
    let taken = window.current_monitor()?;
    event_loop.available_monitors().find(|monitor| *monitor != taken)
}

/// Returns the placement of a participant's window beside an experimenter's: on the only monitor it does not fill the
/// screen, so that the experimenter's stays in sight.
pub fn beside_experimenter(place: WindowPlacement, event_loop: &ActiveEventLoop) -> WindowPlacement {
    let shares = place.fullscreen && event_loop.available_monitors().count() == 1;
    if shares {
        log::warn!(
            "there is only one monitor: the participant's window does not fill it, so that the experimenter's window \
             stays visible; press F11 to fill it, or connect another monitor"
        );
    }
    WindowPlacement { fullscreen: place.fullscreen && !shares, ..place }
}

fn hertz(mode: &VideoModeHandle) -> f64 {
    f64::from(mode.refresh_rate_millihertz()) / 1e3
}

fn rate(handle: &MonitorHandle) -> Option<f64> {
    handle.refresh_rate_millihertz().map(|milli| f64::from(milli) / 1e3).filter(|hz| *hz > 0.0)
}

/// Returns all monitors with their numbers.
fn listed(event_loop: &ActiveEventLoop) -> Vec<(MonitorInfo, MonitorHandle)> {
    let primary = event_loop.primary_monitor();
    let handles = event_loop.available_monitors();
    handles.enumerate().map(|(i, handle)| (monitor(i + 1, &handle, primary.as_ref()), handle)).collect()
}

/// Adds the placement to a window's attributes.
///
/// # Errors
/// There is no such monitor, or it does not have the requested rate.
pub fn placed(
    attributes: WindowAttributes,
    event_loop: &ActiveEventLoop,
    place: WindowPlacement,
) -> Result<WindowAttributes, RunError> {
    let all = listed(event_loop);
    let chosen = match place.monitor {
        None => None,
        Some(number) => Some(all.iter().find(|(monitor, _)| monitor.number == number).ok_or_else(|| {
            let there: Vec<String> = all.iter().map(|(monitor, _)| monitor.to_string()).collect();
            RunError::NoMonitor { number, there: if there.is_empty() { "none".into() } else { there.join("; ") } }
        })?),
    };
    if !place.fullscreen {
        // Some window managers ignore a position; full screen is obeyed.
        return Ok(match chosen {
            Some((_, handle)) => attributes.with_position(handle.position()),
            None => attributes,
        });
    }
    let full = match place.refresh_hz {
        None => Fullscreen::Borderless(chosen.map(|(_, handle)| handle.clone())),
        Some(hz) => {
            let (monitor, handle) = chosen
                .or_else(|| all.iter().find(|(monitor, _)| monitor.primary))
                .or(all.first())
                .ok_or_else(|| RunError::NoRefresh { hz, there: "none: the system lists no monitor".into() })?;
            let modes = handle.video_modes().filter(|mode| mode.size() == handle.size());
            let nearest = modes.min_by(|a, b| (hertz(a) - hz).abs().total_cmp(&(hertz(b) - hz).abs()));
            let mode = nearest.filter(|mode| (hertz(mode) - hz).abs() <= SAME_HZ);
            Fullscreen::Exclusive(mode.ok_or_else(|| RunError::NoRefresh { hz, there: monitor.to_string() })?)
        }
    };
    Ok(attributes.with_fullscreen(Some(full)))
}

/// Describes the screen that shows a window.
pub fn screen(window: &Window, surface: &WindowSurface) -> ScreenInfo {
    let monitor = window.current_monitor();
    ScreenInfo {
        monitor: monitor.as_ref().and_then(MonitorHandle::name),
        refresh_hz: monitor.as_ref().and_then(rate),
        size: surface.size(),
        present_mode: surface.present_mode(),
        frames_ahead: FRAMES_AHEAD,
    }
}

/// Lists the monitors.
///
/// # Errors
/// There is no display.
pub fn monitors() -> Result<Vec<MonitorInfo>, RunError> {
    #[derive(Default)]
    struct MonitorQuery(Vec<MonitorInfo>);

    impl ApplicationHandler for MonitorQuery {
        fn resumed(&mut self, event_loop: &ActiveEventLoop) {
            self.0 = listed(event_loop).into_iter().map(|(monitor, _)| monitor).collect();
            event_loop.exit();
        }

        fn window_event(&mut self, _: &ActiveEventLoop, _: WindowId, _: WindowEvent) {}
    }

    let mut look = MonitorQuery::default();
    event_loop::run_application(event_loop::event_loop()?, &mut look)?;
    Ok(look.0)
}

/// Shows the check screen until Esc.
///
/// # Errors
/// No display, no such monitor, no graphics.
pub fn check(scenario: &Scenario, place: WindowPlacement) -> Result<(), RunError> {
    let truth = DisplayTruth {
        screen_width_m: scenario.display.screen_width_m,
        eye_distance_m: scenario.display.eye_distance_m,
        screen: Vec::new(),
    };
    let (_, ended) = event_loop::run::<CheckWindow>(event_loop::event_loop()?, (truth, place), &AtomicBool::new(false));
    ended
}

/// The window of the check screen.
struct CheckWindow {
    truth: DisplayTruth,
    window: Arc<Window>,
    gpu: Gpu,
    surface: WindowSurface,
    ctx: egui::Context,
    pass: UiPass,
    latency: Latency,
    last: Option<Instant>,
}

impl Windows for CheckWindow {
    type WindowParts = (DisplayTruth, WindowPlacement);

    fn open(event_loop: &ActiveEventLoop, (truth, place): Self::WindowParts) -> Result<Self, RunError> {
        let attributes = placed(Window::default_attributes().with_title("codrive: display"), event_loop, place)?;
        let window = event_loop.create_window(attributes).map_err(|error| no_display(&error))?;
        let window = Arc::new(window);
        let (gpu, surface) = Gpu::for_window(Box::new(event_loop.owned_display_handle()), Arc::clone(&window))?;
        let size = window.inner_size();
        let surface = WindowSurface::new(&gpu, surface, [size.width, size.height], wgpu::PresentMode::Fifo)
            .ok_or_else(|| RunError::NoSurface(gpu.description()))?;
        let ctx = egui::Context::default();
        theme::apply(&ctx);
        let pass = UiPass::new(&gpu.device, surface.format());
        let shown = screen(&window, &surface);
        let mut latency = Latency::default();
        latency.screen(shown.refresh_hz, &shown.present_mode);
        Ok(Self { truth, window, gpu, surface, ctx, pass, latency, last: None })
    }

    fn handle_event(&mut self, _: WindowId, event: WindowEvent) -> Result<LoopControl, RunError> {
        match event {
            WindowEvent::CloseRequested => return Ok(LoopControl::End),
            WindowEvent::Resized(size) => self.surface.resize(&self.gpu, [size.width, size.height]),
            WindowEvent::KeyboardInput { event, .. }
                if event.state == ElementState::Pressed && event.physical_key == PhysicalKey::Code(KeyCode::Escape) =>
            {
                return Ok(LoopControl::End);
            }
            WindowEvent::RedrawRequested => self.draw(),
            _ => {}
        }
        Ok(LoopControl::GoOn)
    }

    fn first(&self) -> &Window {
        &self.window
    }
}

impl CheckWindow {
    fn draw(&mut self) {
        let now = now();
        let elapsed = self.last.replace(now).map(|last| now - last).unwrap_or_default();
        self.latency.frame(elapsed, None);
        let Some(texture) = self.surface.next(&self.gpu) else { return };
        let target = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let size = self.surface.size();
        let shown = screen(&self.window, &self.surface);
        let truth = &mut self.truth;
        let name = shown.monitor.unwrap_or_else(|| "the monitor has no name".into());
        truth.screen = vec![format!("{name}, picture of {} x {} pixels", size[0], size[1])];
        truth.screen.extend(self.latency.lines().into_iter().next().filter(|_| !elapsed.is_zero()));
        if self.window.fullscreen().is_none() {
            truth.screen.push(
                "The window does not fill the screen: its width on the screen is known only in full screen.".into(),
            );
        }
        let points = egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(size[0] as f32, size[1] as f32));
        let input = egui::RawInput { screen_rect: Some(points), ..Default::default() };
        let output = self.ctx.run_ui(input, |ui| panel::check(ui, truth));
        let mut encoder = self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        let overlay = OverlayTarget {
            device: &self.gpu.device,
            queue: &self.gpu.queue,
            encoder: &mut encoder,
            view: &target,
            size,
            stamps: None,
        };
        self.pass.draw(overlay, &self.ctx, output);
        self.gpu.queue.submit([encoder.finish()]);
        self.window.pre_present_notify();
        self.gpu.queue.present(texture);
    }
}
