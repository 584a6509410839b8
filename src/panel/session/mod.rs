//! The experimenter's view of a session: plan and progress, the participant's screen, and all commands with their
//! reasons. In: a [`SessionPanelState`]. Out: [`SessionCommand`]s. Every button has a key, so that no mouse is needed;
//! most commands ask for a text before they are sent (`prompt`). It is shown in the experimenter's window only.

mod prompt;
mod state;

pub use state::{ItemState, SessionCommand, SessionItem, SessionPanelState, SessionPhase, StopRequest};

use super::{notice, theme};
use egui::{Button, Color32, Grid, Key, KeyboardShortcut, Label, Modifiers, RichText, ScrollArea, Ui};
use prompt::{CommandDraft, PROMPTS, PromptedCommand, is_possible};

/// Returns the keys of the experimenter's window in a session, and their actions.
pub fn keys() -> Vec<(String, &'static str)> {
    let ctrl = |key: Key| format!("Ctrl+{}", key.name());
    let mut keys = vec![("F1".to_owned(), "this list")];
    keys.extend(PLAIN.map(|(key, what)| (ctrl(key), what)));
    keys.extend(PROMPTS.iter().map(|prompt| (ctrl(prompt.key), prompt.tip)));
    let (full_screen, what) = super::overlay::key_list::FULL_SCREEN;
    keys.push((full_screen.into(), what));
    keys.push(("Ctrl+1 to Ctrl+4".into(), "next or previous page of a narrow window"));
    keys
}

/// Commands without a text: their keys and actions.
const PLAIN: [(Key, &str); 3] =
    [(Key::G, "Continue, also on behalf of the participant"), (Key::P, "Pause or resume the drive"), (Key::M, MARK)];
const MARK: &str = "Mark this moment";

/// State of the panel: the command that is being written.
#[derive(Debug, Default)]
pub struct SessionPanel {
    draft: Option<CommandDraft>,
}

impl SessionPanel {
    /// Shows the panel and returns the commands.
    pub fn show(&mut self, ui: &mut Ui, state: &SessionPanelState<'_>) -> Vec<SessionCommand> {
        let mut commands = Vec::new();
        self.head(ui, state);
        ui.add_space(4.0);
        self.buttons(ui, state, &mut commands);
        self.draft = self.draft.take().and_then(|draft| draft.show(ui, state, &mut commands));
        if let Some(error) = state.error {
            notice(ui, error, theme::RED);
        }
        if let Some(work) = state.work {
            notice(ui, work, theme::ACCENT);
        }
        ui.separator();
        list(ui, state);
        commands
    }

    /// Takes the words that were typed and not entered, with the name of their command; `None` if there are none.
    pub fn take_words(&mut self) -> Option<String> {
        self.draft.take().and_then(CommandDraft::into_words)
    }

    /// Puts words back into the field for a note.
    pub fn restore(&mut self, words: &str) {
        self.draft = Some(CommandDraft::of_note(words));
    }

    fn head(&self, ui: &mut Ui, state: &SessionPanelState<'_>) {
        ui.horizontal(|ui| {
            ui.heading(state.code);
            ui.label(RichText::new(state.title).color(theme::DIM));
        });
        let (label, colour) = match state.phase {
            SessionPhase::Experimenter => ("waiting for you: press Go", theme::AMBER),
            SessionPhase::Participant => ("waiting for the participant", theme::TEXT),
            SessionPhase::Driving => ("driving", theme::GREEN),
            SessionPhase::Held => ("paused", theme::AMBER),
            SessionPhase::Resting => ("resting", theme::TEXT),
            SessionPhase::Over => ("the session is over", theme::GREEN),
        };
        Grid::new("session now").num_columns(2).spacing([10.0, 3.0]).show(ui, |ui| {
            ui.label(RichText::new("Screen").color(theme::DIM));
            ui.label(state.sees);
            ui.end_row();
            ui.label(RichText::new("State").color(theme::DIM));
            ui.label(RichText::new(label).color(colour).strong());
            ui.end_row();
            ui.label(RichText::new("Left").color(theme::DIM));
            ui.label(RichText::new(state.left_s.map_or("—".into(), time)).monospace());
            ui.end_row();
        });
        let asked = match state.asked {
            Some(StopRequest::Participant) => {
                "The participant asks to stop: everything waits for you. Go continues; Break off and Sickness stop end it."
            }
            Some(StopRequest::Experimenter) => {
                "Motion and sound have ended for a stop: everything waits for you. Go or Resume continues; a stop ends the session."
            }
            None => return,
        };
        notice(ui, asked, theme::AMBER);
    }

    fn buttons(&mut self, ui: &mut Ui, state: &SessionPanelState<'_>, commands: &mut Vec<SessionCommand>) {
        let phase = state.phase;
        let held = phase == SessionPhase::Held;
        let (hold, hold_word, hold_tip) = if held {
            (SessionCommand::Resume, "Resume", "Continue the drive")
        } else {
            (SessionCommand::Pause, "Pause", "Pause the drive")
        };
        let go = !matches!(phase, SessionPhase::Over | SessionPhase::Driving);
        let over = phase == SessionPhase::Over;
        let plain = [
            (SessionCommand::Go, "Go", Key::G, "Continue, also on behalf of the participant", go),
            (hold, hold_word, Key::P, hold_tip, matches!(phase, SessionPhase::Driving | SessionPhase::Held)),
            (SessionCommand::Mark(String::new()), "Mark", Key::M, MARK, !over),
        ];
        ui.horizontal_wrapped(|ui| {
            for (command, label, key, tip, can) in plain {
                let first = label == "Go" && matches!(phase, SessionPhase::Experimenter | SessionPhase::Held);
                if pressed(ui, label, key, tip, can, first.then_some(Color32::from_rgb(36, 96, 150))) {
                    commands.push(command);
                }
            }
            if over && pressed(ui, "Close", Key::Q, "Close the windows: the session is over", true, None) {
                commands.push(SessionCommand::Close);
            }
            for prompt in PROMPTS.iter().filter(|prompt| !(over && prompt.command == PromptedCommand::Close)) {
                let fill = (prompt.command == PromptedCommand::Stop).then_some(Color32::from_rgb(110, 40, 40));
                if pressed(ui, prompt.label, prompt.key, prompt.tip, is_possible(prompt.command, state), fill) {
                    commands.extend((prompt.command.ends_session() && !over).then_some(SessionCommand::Hold));
                    if self.draft.as_ref().is_some_and(|draft| draft.is_of(prompt)) {
                        continue;
                    }
                    commands.extend(self.take_words().map(SessionCommand::Draft));
                    self.draft = Some(CommandDraft::new(prompt, state));
                }
            }
        });
    }
}

/// Shows a button with a key. Returns true if either was pressed.
fn pressed(ui: &mut Ui, label: &str, key: Key, tip: &str, can: bool, fill: Option<Color32>) -> bool {
    let shortcut = KeyboardShortcut::new(Modifiers::COMMAND, key);
    let named = format!("Ctrl+{}", key.name());
    let button = match fill {
        Some(fill) => Button::new(RichText::new(label).color(Color32::WHITE)).fill(fill),
        None => Button::new(label),
    };
    let button = button.shortcut_text(RichText::new(&named).size(10.5));
    let clicked = ui.add_enabled(can, button).on_hover_text(tip).clicked();
    let typed = ui.input_mut(|input| input.consume_shortcut(&shortcut));
    clicked || (typed && can)
}

/// Widest name in the plan, as a share of the plan's width; longer names wrap.
const NAME_SHARE: f32 = 0.45;

/// Shows the plan, one row for each item.
fn list(ui: &mut Ui, state: &SessionPanelState<'_>) {
    let items = state.items;
    let done = items.iter().filter(|item| matches!(item.state, ItemState::Done | ItemState::Skipped)).count();
    let minutes = (state.to_come_s / 60.0).ceil();
    let left = if minutes > 0.0 { format!("; about {minutes} min left") } else { String::new() };
    let text = format!("Plan: {done} of {} done{left}", items.len());
    ui.label(RichText::new(text).color(theme::DIM));
    ScrollArea::vertical().id_salt("plan").auto_shrink([false, true]).show(ui, |ui| {
        // The last column gets the rest, in which its texts end in an ellipsis.
        let widest = NAME_SHARE * ui.available_width();
        Grid::new("plan").num_columns(3).spacing([12.0, 3.0]).striped(true).show(ui, |ui| {
            for item in items {
                row(ui, item, widest);
                ui.end_row();
            }
        });
    });
}

/// Shows an item of the plan in three columns: name, at most `widest` points wide; state; earlier runs and description.
fn row(ui: &mut Ui, item: &SessionItem, widest: f32) {
    let (label, colour) = item.state.label();
    let now = item.state == ItemState::Now;
    let name = RichText::new(&item.name).color(if now { theme::ACCENT } else { theme::TEXT });
    let response = ui.vertical(|ui| {
        ui.set_max_width(widest);
        ui.add(Label::new(if now { name.strong() } else { name }).wrap())
    });
    if now {
        response.inner.scroll_to_me(None);
    }
    // On the first line of its row, as the name is.
    ui.vertical(|ui| ui.add(Label::new(RichText::new(label).color(colour)).extend()));
    // Most names contain their condition.
    let condition = item.condition.as_ref().filter(|condition| !item.name.contains(condition.as_str()));
    let what = condition.map_or_else(|| item.what.clone(), |c| format!("{c}: {}", item.what));
    let earlier = Some(&item.earlier).filter(|earlier| !earlier.is_empty()).map(|earlier| format!("before: {earlier}"));
    ui.vertical(|ui| {
        for text in earlier.into_iter().chain([what]) {
            ui.add(Label::new(RichText::new(text).color(theme::DIM)).truncate());
        }
    });
}

/// Formats a time as minutes and seconds, rounded up.
fn time(left_s: f64) -> String {
    let left = left_s.max(0.0).ceil() as u64;
    format!("{}:{:02}", left / 60, left % 60)
}
