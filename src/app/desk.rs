//! The experimenter's desk: panel, messages, frame times, drawn by egui on top of the picture. In: the running [`Show`],
//! window events. Out: shapes on the screen, and what the panel asks for.

use super::{Show, keys, keys::Command, wheel};
use crate::{
    driver, map,
    panel::{
        Advance, Choices, History, Panel, PanelCommand, PanelState, Phase, Readings, calibration::CalibrationPage,
        theme,
    },
    policy,
    render::{Gpu, PassTimes},
    sim::{Scenario, World},
    time::Pace,
};
use egui::{Align2, Color32, Context, FontId, FullOutput, ViewportId};
use std::{collections::VecDeque, time::Duration};
use winit::{event::WindowEvent, window::Window};

/// Frames over which frame times are averaged.
const FRAMES: usize = 60;

/// Panel and overlays of one window.
pub struct Desk {
    ctx: Context,
    input: egui_winit::State,
    panel: Panel,
    history: History,
    engine: String,
    frames: VecDeque<Duration>,
    show_times: bool,
    message: Option<String>,
    error: Option<String>,
    /// The page of wheel and pedals, and what came of its last command.
    wheel: CalibrationPage,
    wheel_said: Option<String>,
}

impl Desk {
    /// A desk for this window.
    pub fn new(gpu: &Gpu, window: &Window, scenario: &Scenario, open: bool) -> Self {
        let ctx = Context::default();
        theme::apply(&ctx);
        let most = gpu.device.limits().max_texture_dimension_2d as usize;
        let scale = Some(window.scale_factor() as f32);
        let input = egui_winit::State::new(ctx.clone(), ViewportId::ROOT, window, scale, None, Some(most));
        let mut panel = Panel::new(scenario, choices());
        panel.open = open;
        Self {
            ctx,
            input,
            panel,
            history: History::default(),
            engine: String::new(),
            frames: VecDeque::new(),
            show_times: false,
            message: None,
            error: None,
            wheel: CalibrationPage::default(),
            wheel_said: None,
        }
    }

    /// Tells egui of an event; true if it is for the panel alone.
    pub fn on_window_event(&mut self, window: &Window, event: &WindowEvent) -> bool {
        let response = self.input.on_window_event(window, event);
        // Tab and the arrows drive and switch; only a text that is being typed keeps its keys.
        matches!(event, WindowEvent::KeyboardInput { .. }) && response.consumed && self.ctx.text_edit_focused()
    }

    /// Sees the world after a tick.
    pub fn watch(&mut self, world: &World) {
        let snapshot = world.snapshot();
        if snapshot.tick.0.is_multiple_of(world.scenario().step_ticks()) {
            let target = snapshot.advice.map(|advice| advice.target_mps);
            self.history.push(snapshot.tick.seconds(), snapshot.mean_speed_mps, snapshot.ego.speed_mps, target);
        }
    }

    /// One frame of what is open: its shapes, and what the panel asks for. `times` are those of the GPU's passes.
    pub fn shapes(
        &mut self,
        window: &Window,
        show: &Show,
        times: Option<PassTimes>,
        elapsed: Duration,
    ) -> (FullOutput, Vec<PanelCommand>) {
        self.frames.push_back(elapsed);
        if self.frames.len() > FRAMES {
            self.frames.pop_front();
        }
        let frame_ms = self.frames.iter().sum::<Duration>().as_secs_f64() * 1e3 / self.frames.len() as f64;
        let world = &show.drive.world;
        if self.engine.is_empty() {
            self.engine = world.traffic_engine();
        }
        let state = PanelState {
            scenario: world.scenario(),
            phase: phase(show),
            readings: Some(Readings::from(world.snapshot())),
            history: &self.history,
            engine: &self.engine,
            dropped: show.drive.clock.dropped(),
            stalls: show.drive.clock.stalls(),
            frame_ms,
            error: self.error.as_deref(),
        };
        let keys = keys::list();
        let mut asked = Vec::new();
        let notes = self.notes(show, times);
        let panel = &mut self.panel;
        let (page, said) = (&mut self.wheel, self.wheel_said.as_deref());
        let wheel = if page.open { wheel::wheel(show.devices.rig()) } else { None };
        let output = self.ctx.run_ui(self.input.take_egui_input(window), |ui| {
            asked = panel.show(ui, &state, &keys);
            asked.extend(page.show(ui, wheel.as_ref(), said).into_iter().map(PanelCommand::Calibration));
            write_notes(ui, &notes);
        });
        self.input.handle_platform_output(window, output.platform_output.clone());
        (output, asked)
    }

    /// The context that the shapes are of.
    pub fn context(&self) -> &Context {
        &self.ctx
    }

    /// What stands on the picture in words: state of the drive in the middle, times and messages at the lower left.
    fn notes(&self, show: &Show, times: Option<PassTimes>) -> Notes {
        let middle = match phase(show) {
            Phase::Paused if show.waits_for_wheel() => {
                "The wheel was unplugged. The drive goes on when it is back; Space goes on without it."
            }
            Phase::Paused | Phase::Ready => "Paused. Space goes on.",
            Phase::Ended => "The drive is over. Backspace begins again.",
            Phase::Running => "",
        };
        let mut corner = Vec::new();
        corner.extend(self.message.clone());
        corner.extend(self.error.clone());
        if self.show_times {
            corner.extend(show.latency().words());
            corner.extend(times.map(|t| {
                let parts = (t.shadow_ms, t.main_ms, t.mirror_ms, t.develop_ms);
                format!(
                    "GPU: shadow {:.2}, main {:.2}, mirror {:.2}, develop {:.2} ms",
                    parts.0, parts.1, parts.2, parts.3
                )
            }));
            let clock = &show.drive.clock;
            corner.push(format!("dropped {:.2} s in {} stalls", clock.dropped().as_secs_f64(), clock.stalls()));
            let help = if show.lane_help() { ", lane help" } else { "" };
            corner.push(format!("{}{help}", show.devices.describe()));
        }
        Notes { middle, corner }
    }

    /// A command from a key.
    pub fn key(&mut self, command: Command, show: &mut Show) {
        self.message = None;
        match command {
            Command::Help => self.panel.help_open = !self.panel.help_open,
            Command::Panel => self.panel.open = !self.panel.open,
            Command::FrameTimes => self.show_times = !self.show_times,
            Command::Pause => show.toggle_pause(),
            Command::Tick => single_step(show, 1),
            Command::Step => single_step(show, show.drive.world.scenario().step_ticks()),
            Command::NextView => show.next_view(),
            Command::Reverse => show.devices.keyboard.toggle_reverse(),
            Command::LaneHelp => {
                show.toggle_lane_help();
                self.say(format!("lane help is {}", if show.lane_help() { "on" } else { "off" }));
            }
            Command::Restart | Command::FullScreen | Command::ReloadShaders | Command::Quit => {}
        }
    }

    /// A command from the panel. True if there is a new stage to draw.
    pub fn obey(&mut self, command: PanelCommand, show: &mut Show) -> bool {
        match command {
            PanelCommand::Start => show.drive.clock.set_pace(Pace::RealTime),
            PanelCommand::Pause => show.drive.clock.set_pace(Pace::Paused),
            PanelCommand::SingleStep(Advance::Tick) => single_step(show, 1),
            PanelCommand::SingleStep(Advance::Step) => single_step(show, show.drive.world.scenario().step_ticks()),
            PanelCommand::Restart(scenario) => return self.restart(&scenario, show),
            PanelCommand::Wheel => self.wheel.open = !self.wheel.open,
            PanelCommand::Calibration(command) => self.wheel_said = show.calibrate(command),
        }
        false
    }

    /// Begins a drive; if it cannot start, the one before begins again and the panel says why. True if there is a new stage.
    pub fn restart(&mut self, scenario: &Scenario, show: &mut Show) -> bool {
        self.history.clear();
        self.engine.clear();
        self.message = None;
        self.error = None;
        match show.restart(scenario) {
            Ok(new_stage) => new_stage,
            Err(error) => {
                self.error = Some(error.to_string());
                false
            }
        }
    }

    /// Shows a message until the next key.
    pub fn say(&mut self, message: String) {
        self.message = Some(message);
    }
}

/// Words on the picture.
struct Notes {
    middle: &'static str,
    corner: Vec<String>,
}

fn write_notes(ui: &egui::Ui, notes: &Notes) {
    let painter = ui.ctx().layer_painter(egui::LayerId::background());
    let screen = ui.ctx().content_rect();
    let boxed = |align: Align2, at: egui::Pos2, text: String, size: f32| {
        let galley = painter.layout_no_wrap(text, FontId::proportional(size), Color32::WHITE);
        let rect = align.anchor_size(at, galley.size());
        painter.rect_filled(rect.expand2(egui::vec2(10.0, 6.0)), 6.0, Color32::from_black_alpha(150));
        painter.galley(rect.min, galley, Color32::WHITE);
    };
    if !notes.middle.is_empty() {
        let at = screen.center_top() + egui::vec2(0.0, 0.34 * screen.height());
        boxed(Align2::CENTER_CENTER, at, notes.middle.into(), 26.0);
    }
    if !notes.corner.is_empty() {
        boxed(Align2::LEFT_BOTTOM, screen.left_bottom() + egui::vec2(18.0, -16.0), notes.corner.join("\n"), 14.0);
    }
}

fn phase(show: &Show) -> Phase {
    match show.drive.clock.pace() {
        _ if show.drive.world.ended().is_some() => Phase::Ended,
        Pace::Paused if show.drive.world.snapshot().tick.0 == 0 => Phase::Ready,
        Pace::Paused => Phase::Paused,
        _ => Phase::Running,
    }
}

fn single_step(show: &mut Show, ticks: u64) {
    if show.drive.clock.pace() == Pace::Paused {
        show.drive.clock.single_step(ticks);
    }
}

/// Policies by name.
fn policies() -> Vec<String> {
    let own = std::iter::once(policy::AUTO).chain(policy::NAMES).map(str::to_owned);
    own.chain(policy::shipped()).collect()
}

/// Words for the settings that are texts.
fn choices() -> Choices {
    let maps: Vec<String> = map::list().into_iter().map(|info| info.name).collect();
    Choices::default()
        .with("map", maps, None)
        .with("traffic", ["sumo", "native"], Some("HOST:PORT"))
        .with("policy", policies(), None)
        .with("driver", driver::PRESETS, None)
}
