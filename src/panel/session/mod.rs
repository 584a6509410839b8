//! The experimenter's view of a session: plan and progress, the participant's screen, and all commands with their
//! reasons. In: a [`SessionPanelState`]. Out: [`SessionCommand`]s. Every button has a key, so that no mouse is needed;
//! most commands ask for a text before they are sent. It is shown in the experimenter's window only.

use super::{notice, theme};
use egui::{
    Button, Color32, DragValue, Frame, Grid, Key, KeyboardShortcut, Modifiers, RichText, ScrollArea, TextEdit, Ui,
};

/// Content of the session panel in one pass.
#[derive(Clone, Copy, Debug)]
pub struct SessionPanelState<'a> {
    /// Title of the study.
    pub title: &'a str,
    /// Code of the participant.
    pub code: &'a str,
    /// The plan, with the state of each item.
    pub items: &'a [SessionItem],
    /// Estimated duration of the items still to come, s.
    pub to_come_s: f64,
    /// Description of the participant's current screen.
    pub sees: &'a str,
    /// Seconds left of this screen, if it ends by itself.
    pub left_s: Option<f64>,
    /// Current phase of the session.
    pub phase: SessionPhase,
    /// True if the participant has asked to stop.
    pub asked: bool,
    /// Last error, if there was one.
    pub error: Option<&'a str>,
    /// Work of the program in the background: baselines, tables.
    pub work: Option<&'a str>,
}

/// Phase of a session: the event that it waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SessionPhase {
    /// Waits for the experimenter: Go.
    Experimenter,
    /// Waits for the participant, or for an answer; Go continues on their behalf where possible.
    Participant,
    /// Waits for the end of a drive.
    Driving,
    /// Paused during a drive.
    Held,
    /// Waits for the end of a rest.
    Resting,
    /// Over: waits for nothing.
    Over,
}

/// Item of the plan.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionItem {
    /// Name of the item in the plan.
    pub name: String,
    /// Description of the item.
    pub what: String,
    /// Name of its condition, if it has one.
    pub condition: Option<String>,
    /// State of the item.
    pub state: ItemState,
    /// Earlier results, such as `broken off, done`; empty the first time.
    pub earlier: String,
}

/// State of an item of the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ItemState {
    /// Finished to its end.
    Done,
    /// Skipped by the experimenter.
    Skipped,
    /// Running at this moment.
    Now,
    /// Broken off or called back: it will be repeated.
    Again,
    /// Broken off, in a session that is over.
    Broken,
    /// Still to come in the plan.
    Ahead,
}

impl ItemState {
    fn label(self) -> (&'static str, Color32) {
        match self {
            Self::Done => ("done", theme::GREEN),
            Self::Skipped => ("skipped", theme::DIM),
            Self::Now => ("now", theme::ACCENT),
            Self::Again => ("again", theme::AMBER),
            Self::Broken => ("broken off", theme::RED),
            Self::Ahead => ("", theme::DIM),
        }
    }
}

/// Commands of the experimenter. Each text is the reason, or the text of a note or mark.
#[derive(Clone, Debug, PartialEq)]
pub enum SessionCommand {
    /// Continue, on behalf of the participant if need be.
    Go,
    /// Break off the current item; it will be repeated.
    Abort(String),
    /// Repeat an earlier item.
    Repeat {
        /// Name of the item in the plan.
        item: String,
        /// Reason, for the record.
        reason: String,
    },
    /// Skip the current or next item.
    Skip(String),
    /// Make the drive or the rest longer.
    Extend {
        /// Additional time in seconds, 1 to 3600.
        seconds: f64,
        /// Reason, for the record.
        reason: String,
    },
    /// Write a note, with its time.
    Note(String),
    /// Mark this moment; the text may be empty.
    Mark(String),
    /// Pause the running drive.
    Pause,
    /// Resume the paused drive.
    Resume,
    /// End the session for good, e.g. after sickness.
    Stop(String),
    /// Exclude the data of this session, and end it.
    Exclude(String),
    /// Close the windows of an unfinished session; the same command resumes it.
    Interrupt(String),
    /// Close the windows of a finished session.
    Close,
}

/// Commands that ask for a text first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum PromptedCommand {
    Note,
    Extend,
    Skip,
    Repeat,
    Abort,
    Stop,
    Exclude,
    Close,
}

/// Texts of such a command: name on its button, key, tooltip, name of the text field, name on the button that confirms.
type CommandTexts = (PromptedCommand, &'static str, Key, &'static str, &'static str, &'static str);

const ACTS: [CommandTexts; 8] = [
    (PromptedCommand::Note, "Note", Key::N, "Write a note, with its time", "Note", "Write down"),
    (PromptedCommand::Extend, "Extend", Key::E, "Make the drive or the rest longer", "Reason", "Extend"),
    (PromptedCommand::Skip, "Skip", Key::S, "Skip the current or next item", "Reason", "Skip it"),
    (PromptedCommand::Repeat, "Repeat", Key::R, "Repeat an earlier item", "Reason", "Repeat it"),
    (PromptedCommand::Abort, "Break off", Key::B, "Stop this item; it will be repeated", "Reason", "Break it off"),
    (
        PromptedCommand::Stop,
        "Sickness stop",
        Key::I,
        "End the session for good; nothing comes after it",
        "Reason",
        "End the session",
    ),
    (
        PromptedCommand::Exclude,
        "Exclude",
        Key::D,
        "Exclude the data of this session, and end it",
        "Reason",
        "Exclude the data",
    ),
    (
        PromptedCommand::Close,
        "Close",
        Key::Q,
        "Close the windows; run the same command to resume",
        "Reason",
        "Close the windows",
    ),
];

/// Returns the keys of the experimenter's window in a session, and their actions.
pub fn keys() -> Vec<(String, &'static str)> {
    let ctrl = |key: Key| format!("Ctrl+{}", key.name());
    let mut keys = vec![("F1".to_owned(), "this list")];
    keys.extend(PLAIN.map(|(key, what)| (ctrl(key), what)));
    keys.extend(ACTS.map(|(_, _, key, what, ..)| (ctrl(key), what)));
    let (full_screen, what) = super::overlay::key_list::FULL_SCREEN;
    keys.push((full_screen.into(), what));
    keys.push(("Ctrl+1 to Ctrl+4".into(), "turn the pages of a narrow window"));
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

#[derive(Debug)]
struct CommandDraft {
    act: PromptedCommand,
    reason: String,
    seconds: f64,
    /// Index among the items that can be repeated.
    item: usize,
    /// True once the text field has had the focus.
    focused: bool,
    /// True if the command was confirmed without a text.
    refused: bool,
}

impl SessionPanel {
    /// Shows the panel and returns the commands.
    pub fn show(&mut self, ui: &mut Ui, state: &SessionPanelState<'_>) -> Vec<SessionCommand> {
        let mut commands = Vec::new();
        self.head(ui, state);
        ui.add_space(4.0);
        self.buttons(ui, state, &mut commands);
        self.draft(ui, state, &mut commands);
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
        if state.asked {
            notice(
                ui,
                "The participant asks to stop: everything waits for you. Go continues; Break off and Sickness stop end it.",
                theme::AMBER,
            );
        }
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
            for (act, label, key, tip, ..) in ACTS.into_iter().filter(|row| !(over && row.0 == PromptedCommand::Close))
            {
                let fill = (act == PromptedCommand::Stop).then_some(Color32::from_rgb(110, 40, 40));
                if pressed(ui, label, key, tip, self.can(act, state), fill) {
                    self.draft = Some(CommandDraft {
                        act,
                        reason: if act == PromptedCommand::Stop { "sickness".into() } else { String::new() },
                        seconds: 60.0,
                        item: repeatable(state).len().saturating_sub(1),
                        focused: false,
                        refused: false,
                    });
                }
            }
        });
    }

    fn can(&self, act: PromptedCommand, state: &SessionPanelState<'_>) -> bool {
        let over = state.phase == SessionPhase::Over;
        match act {
            PromptedCommand::Note | PromptedCommand::Exclude => true,
            PromptedCommand::Extend => {
                matches!(state.phase, SessionPhase::Driving | SessionPhase::Held | SessionPhase::Resting)
            }
            PromptedCommand::Repeat => !over && !repeatable(state).is_empty(),
            PromptedCommand::Abort => !over && state.items.iter().any(|item| item.state == ItemState::Now),
            PromptedCommand::Skip | PromptedCommand::Stop | PromptedCommand::Close => !over,
        }
    }

    /// Shows the command that is being written; sends it when it is confirmed with a text.
    fn draft(&mut self, ui: &mut Ui, state: &SessionPanelState<'_>, commands: &mut Vec<SessionCommand>) {
        let Some(mut draft) = self.draft.take() else { return };
        let Some((_, _, _, tip, called, confirm)) = ACTS.into_iter().find(|row| row.0 == draft.act) else { return };
        if !self.can(draft.act, state) {
            // The command no longer applies.
            return;
        }
        let items = repeatable(state);
        let (mut meant, mut given_up) = ui.input_mut(|input| {
            if draft.act == PromptedCommand::Repeat {
                let up = input.count_and_consume_key(Modifiers::NONE, Key::ArrowUp);
                let down = input.count_and_consume_key(Modifiers::NONE, Key::ArrowDown);
                draft.item = (draft.item + down).min(items.len().saturating_sub(1)).saturating_sub(up);
            }
            let more = input.count_and_consume_key(Modifiers::COMMAND, Key::ArrowUp) as f64;
            let less = input.count_and_consume_key(Modifiers::COMMAND, Key::ArrowDown) as f64;
            draft.seconds = (draft.seconds + 10.0 * (more - less)).clamp(1.0, 3600.0);
            (input.consume_key(Modifiers::NONE, Key::Enter), input.consume_key(Modifiers::NONE, Key::Escape))
        });
        let ends = matches!(draft.act, PromptedCommand::Abort | PromptedCommand::Stop | PromptedCommand::Exclude);
        let colour = if ends { theme::RED } else { theme::ACCENT };
        Frame::new().fill(colour.gamma_multiply(0.10)).corner_radius(4).inner_margin(8).show(ui, |ui| {
            ui.set_min_width(ui.available_width());
            ui.label(RichText::new(tip).strong());
            if draft.act == PromptedCommand::Repeat {
                for (i, item) in items.iter().enumerate() {
                    if ui.radio(draft.item == i, *item).clicked() {
                        draft.item = i;
                    }
                }
                ui.label(RichText::new("Choose with Up and Down").small().color(theme::DIM));
            }
            if draft.act == PromptedCommand::Extend {
                ui.horizontal(|ui| {
                    let label = ui.label("Longer by");
                    let drag = DragValue::new(&mut draft.seconds).range(1.0..=3600.0).suffix(" s");
                    ui.add(drag).labelled_by(label.id);
                    ui.label(RichText::new("Ctrl+Up and Ctrl+Down change it by 10 s").small().color(theme::DIM));
                });
            }
            ui.horizontal(|ui| {
                let label = ui.label(called);
                let edit = TextEdit::singleline(&mut draft.reason).desired_width(ui.available_width() - 8.0);
                let response = ui.add(edit).labelled_by(label.id);
                if !std::mem::replace(&mut draft.focused, true) {
                    response.request_focus();
                }
            });
            if draft.refused && draft.reason.trim().is_empty() {
                ui.label(RichText::new("A few words are needed.").color(theme::AMBER));
            }
            ui.horizontal(|ui| {
                let fill = if ends { Color32::from_rgb(130, 40, 40) } else { Color32::from_rgb(36, 96, 150) };
                let button = Button::new(RichText::new(confirm).color(Color32::WHITE)).fill(fill);
                meant |= ui.add(button).on_hover_text("Enter").clicked();
                given_up |= ui.button("Cancel").on_hover_text("Esc").clicked();
            });
        });
        let reason = draft.reason.trim().to_owned();
        if meant && !reason.is_empty() {
            commands.extend(match draft.act {
                PromptedCommand::Note => Some(SessionCommand::Note(reason)),
                PromptedCommand::Extend => Some(SessionCommand::Extend { seconds: draft.seconds, reason }),
                PromptedCommand::Skip => Some(SessionCommand::Skip(reason)),
                PromptedCommand::Abort => Some(SessionCommand::Abort(reason)),
                PromptedCommand::Stop => Some(SessionCommand::Stop(reason)),
                PromptedCommand::Exclude => Some(SessionCommand::Exclude(reason)),
                PromptedCommand::Close => Some(SessionCommand::Interrupt(reason)),
                PromptedCommand::Repeat => {
                    items.get(draft.item).map(|item| SessionCommand::Repeat { item: (*item).to_owned(), reason })
                }
            });
        } else if !given_up {
            draft.refused |= meant;
            self.draft = Some(draft);
        }
    }
}

/// Returns the names of the items that can be repeated: done or skipped.
fn repeatable<'a>(state: &SessionPanelState<'a>) -> Vec<&'a str> {
    let settled = |item: &&SessionItem| matches!(item.state, ItemState::Done | ItemState::Skipped);
    state.items.iter().filter(settled).map(|item| item.name.as_str()).collect()
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

/// Shows the plan, one line for each item.
fn list(ui: &mut Ui, state: &SessionPanelState<'_>) {
    let items = state.items;
    let done = items.iter().filter(|item| matches!(item.state, ItemState::Done | ItemState::Skipped)).count();
    let minutes = (state.to_come_s / 60.0).ceil();
    let left = if minutes > 0.0 { format!("; about {minutes} min left") } else { String::new() };
    let text = format!("Plan: {done} of {} done{left}", items.len());
    ui.label(RichText::new(text).color(theme::DIM));
    ScrollArea::vertical().id_salt("plan").auto_shrink([false, true]).show(ui, |ui| {
        Grid::new("plan").num_columns(4).spacing([12.0, 3.0]).striped(true).show(ui, |ui| {
            for item in items {
                let (label, colour) = item.state.label();
                let now = item.state == ItemState::Now;
                let name = RichText::new(&item.name).color(if now { theme::ACCENT } else { theme::TEXT });
                let response = ui.label(if now { name.strong() } else { name });
                if now {
                    response.scroll_to_me(None);
                }
                ui.label(RichText::new(label).color(colour));
                let earlier = if item.earlier.is_empty() { String::new() } else { format!("before: {}", item.earlier) };
                ui.label(RichText::new(earlier).color(theme::DIM));
                // Most names contain their condition.
                let condition = item.condition.as_ref().filter(|condition| !item.name.contains(condition.as_str()));
                let what = condition.map_or_else(|| item.what.clone(), |c| format!("{c}: {}", item.what));
                ui.add(egui::Label::new(RichText::new(what).color(theme::DIM)).truncate());
                ui.end_row();
            }
        });
    });
}

/// Formats a time as minutes and seconds, rounded up.
fn time(left_s: f64) -> String {
    let left = left_s.max(0.0).ceil() as u64;
    format!("{}:{:02}", left / 60, left % 60)
}
