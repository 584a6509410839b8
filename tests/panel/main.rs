//! The interfaces that egui draws, used through their labels, with the mouse and by keyboard, at every scale.

mod drive;
mod experimenter;
mod pages;
mod rating;
mod screens;
mod session_plan;
mod timeline;
mod wheel;
mod who_drives;

use codrive::panel::theme;
use egui::Ui;
use egui_kittest::Harness;

/// Returns a window in which `show` draws `state`, at this size in points and this scale.
fn harness<State: 'static>(
    state: State,
    size: [f32; 2],
    scale: f32,
    show: fn(&mut Ui, &mut State),
) -> Harness<'static, State> {
    let mut harness = Harness::builder()
        .with_size(egui::Vec2::from(size))
        .with_pixels_per_point(scale)
        .with_context_setup(theme::apply)
        .wgpu()
        .build_ui_state(show, state);
    harness.run();
    harness
}
