//! The window. In: events of winit, Ctrl-C. Out: frames on the screen. `Frame::draw` is one turn of the loop (DESIGN 3);
//! everything that needs no window lives in [`Show`] and [`Desk`].

use super::{
    AppError, Desk, Show,
    display::{Place, no_display, placed, screen},
    keys::{self, Command},
    offline::FLUSH_EVERY,
    renderer_that_keeps_up,
    surface::Surface,
};
use crate::{
    input::{Devices, Profile},
    render::{Gpu, Panel, Renderer},
    sim::Scenario,
    time::Pace,
};
use std::{
    path::PathBuf,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::{Duration, Instant},
};
use winit::{
    application::ApplicationHandler,
    dpi::LogicalSize,
    event::{ElementState, KeyEvent, WindowEvent},
    event_loop::{ActiveEventLoop, ControlFlow, EventLoop},
    keyboard::PhysicalKey,
    window::{Fullscreen, Window, WindowId},
};

/// Size of the window, and of one that the processor draws: 0.1 s a frame on two cores (codrive bench).
const SIZE: LogicalSize<u32> = LogicalSize::new(1280, 720);
const SOFTWARE_SIZE: LogicalSize<u32> = LogicalSize::new(640, 360);

/// How `codrive drive` was asked to start.
pub struct WindowOptions {
    /// The drive.
    pub scenario: Scenario,
    /// Where it opens, and whether it fills the screen at once.
    pub place: Place,
    /// Show the experimenter's panel at once.
    pub panel: bool,
    /// Wait for the space bar.
    pub paused: bool,
    /// Record the drive there.
    pub out: Option<PathBuf>,
    /// Profile of the wheel; `None` takes the one for the wheel that is found.
    pub wheel: Option<Profile>,
    /// Becomes true when the program is to end (Ctrl-C).
    pub stop: Arc<AtomicBool>,
}

/// Opens the window and drives until it is closed.
///
/// # Errors
/// No display, no graphics adapter, or a world that cannot start or go on.
pub fn run(options: WindowOptions) -> Result<(), AppError> {
    let event_loop = EventLoop::new().map_err(|error| no_display(&error))?;
    event_loop.set_control_flow(ControlFlow::Poll);
    // The world first: what is wrong with a scenario is said before a window opens.
    let pace = if options.paused { Pace::Paused } else { Pace::RealTime };
    let show = Show::new(&options.scenario, pace, Devices::open_with(options.wheel.clone()))?;
    let mut app = App { options, show: Some(show), frame: None, failure: None };
    event_loop.run_app(&mut app).map_err(|error| AppError::NoDisplay(error.to_string()))?;
    if let Some(mut frame) = app.frame.take() {
        print!("{}", frame.show.words());
        if let Some(folder) = frame.show.finish_recording()? {
            println!("recorded                 {}", folder.display());
        }
    }
    app.failure.map_or(Ok(()), Err)
}

struct App {
    options: WindowOptions,
    /// The drive until there is a window for it.
    show: Option<Show>,
    frame: Option<Frame>,
    failure: Option<AppError>,
}

/// A drive in its window.
struct Frame {
    window: Arc<Window>,
    gpu: Gpu,
    surface: Surface,
    renderer: Renderer,
    show: Show,
    desk: Desk,
    /// When the last frame began; `None` before the first, and after another stage went to the GPU: time runs from the
    /// first picture on, shaders and models are not a stall.
    last: Option<Instant>,
    /// When the first frame began, and when rows last went to the disk.
    first: Instant,
    flushed: Instant,
}

impl ApplicationHandler for App {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        let Some(show) = self.show.take() else { return };
        match Frame::open(event_loop, &self.options, show) {
            Ok(frame) => self.frame = Some(frame),
            Err(error) => self.fail(event_loop, error),
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _id: WindowId, event: WindowEvent) {
        let Some(frame) = &mut self.frame else { return };
        let taken = frame.desk.on_window_event(&frame.window, &event);
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(size) => frame.surface.resize(&frame.gpu, [size.width, size.height]),
            WindowEvent::Focused(false) => frame.show.devices.keyboard.release_all(),
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. } if !taken => match frame.key(&event) {
                Ok(Some(Command::Quit)) => event_loop.exit(),
                Ok(_) => {}
                Err(error) => self.fail(event_loop, error),
            },
            WindowEvent::RedrawRequested => {
                if let Err(error) = frame.draw() {
                    self.fail(event_loop, error);
                }
            }
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        if self.options.stop.load(Ordering::Relaxed) {
            event_loop.exit();
        }
        if let Some(frame) = &self.frame {
            frame.window.request_redraw();
        }
    }
}

impl App {
    fn fail(&mut self, event_loop: &ActiveEventLoop, error: AppError) {
        self.failure = Some(error);
        event_loop.exit();
    }
}

impl Frame {
    fn open(event_loop: &ActiveEventLoop, options: &WindowOptions, mut show: Show) -> Result<Self, AppError> {
        let attributes =
            Window::default_attributes().with_title(format!("codrive: {}", options.scenario.map)).with_inner_size(SIZE);
        let attributes = placed(attributes, event_loop, options.place)?;
        let window = event_loop.create_window(attributes).map_err(|error| AppError::NoDisplay(error.to_string()))?;
        let window = Arc::new(window);
        let display = Box::new(event_loop.owned_display_handle());
        let (gpu, surface) = Gpu::for_window(display, Arc::clone(&window))?;
        log::info!("graphics: {}", gpu.description());
        if gpu.is_software() && !options.place.fullscreen {
            log::warn!(
                "no graphics card was found: the processor draws, so the window is small ({})",
                gpu.description()
            );
            let _ = window.request_inner_size(SOFTWARE_SIZE);
        }
        let size = window.inner_size();
        let surface = Surface::new(&gpu, surface, [size.width, size.height])
            .ok_or_else(|| AppError::NoSurface(gpu.description()))?;
        let view = show.view();
        let level = options.scenario.quality;
        let renderer = renderer_that_keeps_up(&gpu, &show.stage, surface.format(), level, &view, surface.size())?;
        let desk = Desk::new(&gpu, &window, &options.scenario, options.panel);
        show.open_sound();
        show.set_screen(screen(&window, &surface));
        if let Some(folder) = &options.out {
            show.record(folder, &gpu)?;
        }
        let start = now();
        Ok(Self { window, gpu, surface, renderer, show, desk, last: None, first: start, flushed: start })
    }

    /// One frame: simulate what is due, look, draw, present.
    fn draw(&mut self) -> Result<(), AppError> {
        let first = self.last.is_none();
        let elapsed = self.lap();
        let due = self.show.advance(elapsed, |world| self.desk.watch(world))?;
        if let Some(news) = self.show.take_news().pop() {
            self.desk.say(news);
        }
        if !due.dropped.is_zero() && self.show.drive.clock.stalls() == 1 {
            log::warn!(
                "a frame came too late and {:.0} ms were dropped; F3 shows the sum (--quality low is faster)",
                due.dropped.as_secs_f64() * 1e3
            );
        }
        let Some(texture) = self.surface.next(&self.gpu) else { return Ok(()) };
        let target = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
        let size = self.surface.size();
        let view = self.show.view();
        let times = self.renderer.pass_times();
        let (output, asked) = self.desk.shapes(&self.window, &self.show, times, elapsed);
        let panel = Panel { ctx: self.desk.context(), output };
        self.renderer.draw(&view, Some(panel), &target, size);
        self.window.pre_present_notify();
        self.gpu.queue.present(texture);
        let done = now();
        if first {
            self.last = Some(done);
            self.first = done;
        }
        self.show.shown(done - self.first, elapsed, &due);
        if done - self.flushed > FLUSH_EVERY {
            self.flushed = done;
            self.show.flush()?;
        }
        for command in asked {
            if self.desk.obey(command, &mut self.show) {
                self.new_stage()?;
            }
        }
        Ok(())
    }

    /// The map has changed: its models go to the GPU.
    fn new_stage(&mut self) -> Result<(), AppError> {
        let view = self.show.view();
        let scenario = self.show.drive.world.scenario();
        let (format, size) = (self.surface.format(), self.surface.size());
        let renderer = renderer_that_keeps_up(&self.gpu, &self.show.stage, format, scenario.quality, &view, size)?;
        let old = std::mem::replace(&mut self.renderer, renderer);
        self.renderer.keep_panel_of(old);
        self.window.set_title(&format!("codrive: {}", scenario.map));
        self.last = None;
        Ok(())
    }

    /// Time since the last frame.
    fn lap(&mut self) -> Duration {
        let begin = now();
        self.last.replace(begin).map_or(Duration::ZERO, |before| begin - before)
    }

    /// A key went down or up. Returns the command that it stands for.
    ///
    /// # Errors
    /// Another stage had to be drawn and the device is lost.
    fn key(&mut self, event: &KeyEvent) -> Result<Option<Command>, AppError> {
        let PhysicalKey::Code(code) = event.physical_key else { return Ok(None) };
        let down = event.state == ElementState::Pressed;
        if let Some(key) = keys::driving(code) {
            self.show.devices.keyboard.set(key, down);
        }
        let Some(command) = keys::command(code).filter(|_| down && !event.repeat) else { return Ok(None) };
        match command {
            Command::FullScreen => {
                let full = self.window.fullscreen().is_some();
                self.window.set_fullscreen((!full).then_some(Fullscreen::Borderless(None)));
            }
            Command::ReloadShaders => match self.renderer.reload_shaders() {
                Ok(()) => self.desk.say("shaders read again".into()),
                Err(error) => self.desk.say(error),
            },
            Command::Restart => {
                let scenario = self.show.drive.world.scenario().clone();
                if self.desk.restart(&scenario, &mut self.show) {
                    self.new_stage()?;
                }
            }
            other => self.desk.key(other, &mut self.show),
        }
        Ok(Some(command))
    }
}

#[allow(clippy::disallowed_methods, reason = "the loop is where wall time enters")]
fn now() -> Instant {
    Instant::now()
}
