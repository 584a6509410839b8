//! List of the scenario's events. In: their names and states. Out: a command to begin one by hand.

use super::ExperimenterCommand;
use crate::{
    panel::theme,
    sim::{ScriptedState, World},
};
use egui::{Grid, RichText, Ui};

/// Event of the scenario, as the list shows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ListedEvent {
    /// Name of the event in the scenario.
    pub name: String,
    pub state: ScriptedState,
}

/// Returns the events of a drive's scenario as they are now.
pub fn listed_events(world: &World) -> Vec<ListedEvent> {
    world.scripted_events().map(|(name, state)| ListedEvent { name: name.to_owned(), state }).collect()
}

/// Shows all events; the button of one that is armed begins it.
pub(super) fn show(ui: &mut Ui, events: &[ListedEvent], commands: &mut Vec<ExperimenterCommand>) {
    Grid::new("events").num_columns(3).striped(true).show(ui, |ui| {
        for (number, event) in events.iter().enumerate() {
            let (word, colour) = match event.state {
                ScriptedState::Armed => ("armed", theme::DIM),
                ScriptedState::Running => ("now", theme::GREEN),
                ScriptedState::Over => ("over", theme::DIM),
            };
            ui.label(&event.name);
            ui.label(RichText::new(word).color(colour));
            let button = ui.add_enabled(event.state == ScriptedState::Armed, egui::Button::new("Begin"));
            if button.on_hover_text("Begin this event now; the recording says that it was begun by hand").clicked() {
                commands.push(ExperimenterCommand::BeginEvent(number));
            }
            ui.end_row();
        }
    });
}
