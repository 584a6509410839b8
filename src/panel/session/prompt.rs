//! Prompt for a command that needs a text: a reason, or a note. In: keys, clicks, the state of the session. Out: a [`SessionCommand`] once
//! the experimenter has confirmed it.

use super::state::{ItemState, SessionCommand, SessionPanelState, SessionPhase, repeatable};
use crate::panel::theme;
use PromptedCommand::{Abort, Close, Exclude, Extend, Note, Repeat, Skip, Stop, StopTechnically};
use egui::{Button, Color32, DragValue, Frame, Key, Modifiers, RichText, TextEdit, Ui};

/// Commands that ask for a text first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PromptedCommand {
    Note,
    Extend,
    Skip,
    Repeat,
    Abort,
    Stop,
    StopTechnically,
    Exclude,
    Close,
}

impl PromptedCommand {
    /// Returns true for a command that ends the session for good. Its question holds everything from the start.
    pub(super) fn ends_session(self) -> bool {
        matches!(self, Stop | StopTechnically | Exclude)
    }
}

/// Reason of a sickness stop that is in its field from the start.
const SICKNESS: &str = "sickness";

/// Texts and key of a command that asks for a text first.
#[derive(Debug)]
pub(super) struct PromptSpec {
    pub(super) command: PromptedCommand,
    /// Name of the button that opens the prompt.
    pub(super) label: &'static str,
    /// Key that opens the prompt, with Ctrl.
    pub(super) key: Key,
    /// Effect of the command, as tooltip and as title of the prompt.
    pub(super) tip: &'static str,
    /// Name of the button that confirms.
    confirm: &'static str,
}

const fn prompt(
    command: PromptedCommand,
    label: &'static str,
    key: Key,
    tip: &'static str,
    confirm: &'static str,
) -> PromptSpec {
    PromptSpec { command, label, key, tip, confirm }
}

/// Commands that ask for a text, in the order of their buttons.
pub(super) static PROMPTS: [PromptSpec; 9] = [
    prompt(Note, "Note", Key::N, "Write a note, with its time", "Write down"),
    prompt(Extend, "Extend", Key::E, "Make the drive or the rest longer", "Extend"),
    prompt(Skip, "Skip", Key::S, "Skip the current or next item", "Skip it"),
    prompt(Repeat, "Repeat", Key::R, "Repeat an earlier item", "Repeat it"),
    prompt(Abort, "Break off", Key::B, "Stop this item; it will be repeated", "Break it off"),
    prompt(Stop, "Sickness stop", Key::I, "End the session for good; it cannot be resumed", "End the session"),
    prompt(
        StopTechnically,
        "Technical stop",
        Key::T,
        "End the session for good: program, computer or a device failed",
        "End the session",
    ),
    prompt(Exclude, "Exclude", Key::D, "Exclude the data of this session, and end it", "Exclude the data"),
    prompt(Close, "Close", Key::Q, "Close the windows; run the same command to resume", "Close the windows"),
];

/// Command that is being written.
#[derive(Debug)]
pub(super) struct CommandDraft {
    spec: &'static PromptSpec,
    reason: String,
    seconds: f64,
    /// Index among the items that can be repeated.
    item: usize,
    /// True once the text field has had the focus.
    focused: bool,
    /// True if the command was confirmed without a text.
    refused: bool,
}

/// Returns true if a command applies in the present state of the session.
pub(super) fn is_possible(command: PromptedCommand, state: &SessionPanelState<'_>) -> bool {
    let over = state.phase == SessionPhase::Over;
    match command {
        Note | Exclude => true,
        Extend => {
            matches!(state.phase, SessionPhase::Driving | SessionPhase::Held | SessionPhase::Resting)
        }
        Repeat => !over && !repeatable(state).is_empty(),
        Abort => !over && state.items.iter().any(|item| item.state == ItemState::Now),
        Skip | Stop | StopTechnically | Close => !over,
    }
}

/// Decision about a prompt in one pass.
struct PromptDecision {
    is_confirmed: bool,
    is_cancelled: bool,
}

impl CommandDraft {
    pub(super) fn new(spec: &'static PromptSpec, state: &SessionPanelState<'_>) -> Self {
        Self {
            spec,
            reason: if spec.command == Stop { SICKNESS.into() } else { String::new() },
            seconds: 60.0,
            item: repeatable(state).len().saturating_sub(1),
            focused: false,
            refused: false,
        }
    }

    /// Returns a note with these words that is being written.
    pub(super) fn of_note(words: &str) -> Self {
        let [spec, ..] = &PROMPTS;
        Self { spec, reason: words.into(), seconds: 60.0, item: 0, focused: false, refused: false }
    }

    /// Returns true if this command is being written.
    pub(super) fn is_of(&self, spec: &PromptSpec) -> bool {
        self.spec.command == spec.command
    }

    /// Returns the words so far; those of other commands than a note with the name of the command. `None` if nothing was typed.
    pub(super) fn into_words(self) -> Option<String> {
        let words = self.reason.trim();
        let is_typed = !words.is_empty() && (self.spec.command != Stop || words != SICKNESS);
        is_typed.then(|| match self.spec.command {
            Note => words.to_owned(),
            _ => format!("{}: {words}", self.spec.label),
        })
    }

    /// Shows the command. Sends it if it is confirmed with a text. Returns it if it is still being written; of one that no longer applies the
    /// words are kept.
    pub(super) fn show(
        mut self,
        ui: &mut Ui,
        state: &SessionPanelState<'_>,
        commands: &mut Vec<SessionCommand>,
    ) -> Option<Self> {
        if !is_possible(self.spec.command, state) {
            commands.extend(self.into_words().map(SessionCommand::Draft));
            return None;
        }
        let items = repeatable(state);
        let typed = self.take_keys(ui, items.len());
        let clicked = self.fields(ui, &items);
        let is_confirmed = typed.is_confirmed || clicked.is_confirmed;
        if is_confirmed && !self.reason.trim().is_empty() {
            commands.extend(self.written(&items));
            return None;
        }
        self.refused |= is_confirmed;
        (!typed.is_cancelled && !clicked.is_cancelled).then_some(self)
    }

    /// Applies the keys of the prompt, with this number of items that can be repeated.
    fn take_keys(&mut self, ui: &Ui, items: usize) -> PromptDecision {
        ui.input_mut(|input| {
            if self.spec.command == Repeat {
                let up = input.count_and_consume_key(Modifiers::NONE, Key::ArrowUp);
                let down = input.count_and_consume_key(Modifiers::NONE, Key::ArrowDown);
                self.item = (self.item + down).min(items.saturating_sub(1)).saturating_sub(up);
            }
            let more = input.count_and_consume_key(Modifiers::COMMAND, Key::ArrowUp) as f64;
            let less = input.count_and_consume_key(Modifiers::COMMAND, Key::ArrowDown) as f64;
            self.seconds = (self.seconds + 10.0 * (more - less)).clamp(1.0, 3600.0);
            PromptDecision {
                is_confirmed: input.consume_key(Modifiers::NONE, Key::Enter),
                is_cancelled: input.consume_key(Modifiers::NONE, Key::Escape),
            }
        })
    }

    /// Shows the prompt: what the command applies to, its text, and the buttons.
    fn fields(&mut self, ui: &mut Ui, items: &[&str]) -> PromptDecision {
        let spec = self.spec;
        let ends = matches!(self.spec.command, Abort | Stop | StopTechnically | Exclude);
        let colour = if ends { theme::RED } else { theme::ACCENT };
        let frame = Frame::new().fill(colour.gamma_multiply(0.10)).corner_radius(4).inner_margin(8);
        let shown = frame.show(ui, |ui| {
            ui.set_min_width(ui.available_width());
            ui.label(RichText::new(spec.tip).strong());
            match self.spec.command {
                Repeat => self.item_choice(ui, items),
                Extend => self.duration(ui),
                _ => {}
            }
            self.text_field(ui, if spec.command == Note { "Note" } else { "Reason" });
            ui.horizontal(|ui| {
                let fill = if ends { Color32::from_rgb(130, 40, 40) } else { Color32::from_rgb(36, 96, 150) };
                let button = Button::new(RichText::new(spec.confirm).color(Color32::WHITE)).fill(fill);
                PromptDecision {
                    is_confirmed: ui.add(button).on_hover_text("Enter").clicked(),
                    is_cancelled: ui.button("Cancel").on_hover_text("Esc").clicked(),
                }
            })
            .inner
        });
        shown.inner
    }

    fn item_choice(&mut self, ui: &mut Ui, items: &[&str]) {
        for (i, item) in items.iter().enumerate() {
            if ui.radio(self.item == i, *item).clicked() {
                self.item = i;
            }
        }
        ui.label(RichText::new("Choose with Up and Down").small().color(theme::DIM));
    }

    fn duration(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            let label = ui.label("Longer by");
            let drag = DragValue::new(&mut self.seconds).range(1.0..=3600.0).suffix(" s");
            ui.add(drag).labelled_by(label.id);
            ui.label(RichText::new("Ctrl+Up and Ctrl+Down change it by 10 s").small().color(theme::DIM));
        });
    }

    fn text_field(&mut self, ui: &mut Ui, name: &str) {
        ui.horizontal(|ui| {
            let label = ui.label(name);
            let edit = TextEdit::singleline(&mut self.reason).desired_width(ui.available_width() - 8.0);
            let response = ui.add(edit).labelled_by(label.id);
            if !std::mem::replace(&mut self.focused, true) {
                response.request_focus();
            }
        });
        if self.refused && self.reason.trim().is_empty() {
            ui.label(RichText::new("Please write a few words.").color(theme::AMBER));
        }
    }

    /// Returns the command with its text; `None` if the item to repeat is gone.
    fn written(&self, items: &[&str]) -> Option<SessionCommand> {
        let reason = self.reason.trim().to_owned();
        Some(match self.spec.command {
            Note => SessionCommand::Note(reason),
            Extend => SessionCommand::Extend { seconds: self.seconds, reason },
            Skip => SessionCommand::Skip(reason),
            Abort => SessionCommand::Abort(reason),
            Stop => SessionCommand::Stop(reason),
            StopTechnically => SessionCommand::StopTechnically(reason),
            Exclude => SessionCommand::Exclude(reason),
            Close => SessionCommand::Interrupt(reason),
            Repeat => SessionCommand::Repeat { item: (*items.get(self.item)?).to_owned(), reason },
        })
    }
}
