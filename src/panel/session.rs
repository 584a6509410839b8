//! The experimenter's part of a session: plan and progress, what the participant sees, and every command with its reason. In:
//! a [`SessionPanelState`]. Out: [`SessionCommand`]s. Each button has a key, so that no mouse is needed; what ends a drive or the
//! session asks once more and wants a reason. It stands on the experimenter's side alone.

use super::{notice, theme};
use egui::{
    Button, Color32, DragValue, Frame, Grid, Key, KeyboardShortcut, Modifiers, RichText, ScrollArea, TextEdit, Ui,
};

/// What there is to show of a session.
#[derive(Clone, Copy, Debug)]
pub struct SessionPanelState<'a> {
    /// The study.
    pub title: &'a str,
    /// The participant's code.
    pub code: &'a str,
    /// The plan with what has become of it.
    pub items: &'a [SessionItem],
    /// How long what is not yet settled is reckoned to last, seconds.
    pub to_come_s: f64,
    /// What the participant sees now, in words.
    pub sees: &'a str,
    /// Seconds that are left of it, where it ends by itself.
    pub left_s: Option<f64>,
    /// What the session waits for.
    pub phase: SessionPhase,
    /// The participant has asked to stop.
    pub asked: bool,
    /// What went wrong last.
    pub error: Option<&'a str>,
    /// What the program does beside it: baselines, tables.
    pub work: Option<&'a str>,
}

/// What a session waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SessionPhase {
    /// For the experimenter: Go.
    Experimenter,
    /// For the participant, or for a question to be answered; Go goes on in their place where that can be.
    Participant,
    /// For the end of a drive.
    Driving,
    /// A drive is held.
    Held,
    /// For the end of a rest.
    Resting,
    /// For nothing: the session is over.
    Over,
}

/// A point of the plan.
#[derive(Clone, Debug, PartialEq)]
pub struct SessionItem {
    /// Its name.
    pub name: String,
    /// What it is, in words.
    pub what: String,
    /// Name of its condition, if it has one.
    pub condition: Option<String>,
    /// What has become of it.
    pub state: ItemState,
    /// What became of it earlier, in words: `broken off, done`; empty where this is the first time.
    pub earlier: String,
}

/// What has become of a point of the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ItemState {
    /// To its end.
    Done,
    /// Left out.
    Skipped,
    /// Now.
    Now,
    /// Broken off or called back: it comes again.
    Again,
    /// Broken off, in a session that is over.
    Broken,
    /// Not yet.
    Ahead,
}

impl ItemState {
    fn word(self) -> (&'static str, Color32) {
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

/// What the experimenter decides; words are reasons.
#[derive(Clone, Debug, PartialEq)]
pub enum SessionCommand {
    /// Go on.
    Go,
    /// Break off what runs; it comes again.
    Abort(String),
    /// An item once more.
    Repeat {
        /// Its name.
        item: String,
        /// Why.
        reason: String,
    },
    /// Leave out what runs, or what comes next.
    Skip(String),
    /// The drive or the rest lasts longer.
    Extend {
        /// By how much.
        seconds: f64,
        /// Why.
        reason: String,
    },
    /// Write something down.
    Note(String),
    /// Mark this moment.
    Mark(String),
    /// Hold the drive.
    Pause,
    /// Let it go on.
    Resume,
    /// End the session for good, as after sickness.
    Stop(String),
    /// Exclude the data of this session, which ends it too.
    Exclude(String),
    /// Close the windows of a session that is not over: the same command resumes it.
    Interrupt(String),
    /// Close the windows of a session that is over.
    Close,
}

/// Commands that ask for words first.
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

/// A command with words: on its button, its key, what it does, what the reason is called, and on the button that confirms.
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

/// Keys of the experimenter's window in a session, and what they do.
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

/// Commands without words: their keys and what they do.
const PLAIN: [(Key, &str); 3] =
    [(Key::G, "Continue, also on behalf of the participant"), (Key::P, "Pause or resume the drive"), (Key::M, MARK)];
const MARK: &str = "Mark this moment";

/// The panel's own state: what is being written.
#[derive(Debug, Default)]
pub struct SessionPanel {
    draft: Option<CommandDraft>,
}

#[derive(Debug)]
struct CommandDraft {
    act: PromptedCommand,
    reason: String,
    seconds: f64,
    /// Which of the items that can be repeated.
    item: usize,
    /// The text has had the keyboard already.
    focused: bool,
    /// Confirmed without a reason.
    refused: bool,
}

impl SessionPanel {
    /// Shows the section and tells what was decided.
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
        let (word, colour) = match state.phase {
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
            ui.label(RichText::new(word).color(colour).strong());
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
            for (command, word, key, tip, can) in plain {
                let first = word == "Go" && matches!(phase, SessionPhase::Experimenter | SessionPhase::Held);
                if pressed(ui, word, key, tip, can, first.then_some(Color32::from_rgb(36, 96, 150))) {
                    commands.push(command);
                }
            }
            if over && pressed(ui, "Close", Key::Q, "Close the windows: the session is over", true, None) {
                commands.push(SessionCommand::Close);
            }
            for (act, word, key, tip, ..) in ACTS.into_iter().filter(|row| !(over && row.0 == PromptedCommand::Close)) {
                let fill = (act == PromptedCommand::Stop).then_some(Color32::from_rgb(110, 40, 40));
                if pressed(ui, word, key, tip, self.can(act, state), fill) {
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

    /// The command that is being written: its words, and whether it is meant.
    fn draft(&mut self, ui: &mut Ui, state: &SessionPanelState<'_>, commands: &mut Vec<SessionCommand>) {
        let Some(mut draft) = self.draft.take() else { return };
        let Some((_, _, _, tip, called, confirm)) = ACTS.into_iter().find(|row| row.0 == draft.act) else { return };
        if !self.can(draft.act, state) {
            // What it was about is over.
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

/// Names of what can come once more.
fn repeatable<'a>(state: &SessionPanelState<'a>) -> Vec<&'a str> {
    let settled = |item: &&SessionItem| matches!(item.state, ItemState::Done | ItemState::Skipped);
    state.items.iter().filter(settled).map(|item| item.name.as_str()).collect()
}

/// A button with a key. True if one of them was pressed.
fn pressed(ui: &mut Ui, word: &str, key: Key, tip: &str, can: bool, fill: Option<Color32>) -> bool {
    let shortcut = KeyboardShortcut::new(Modifiers::COMMAND, key);
    let named = format!("Ctrl+{}", key.name());
    let button = match fill {
        Some(fill) => Button::new(RichText::new(word).color(Color32::WHITE)).fill(fill),
        None => Button::new(word),
    };
    let button = button.shortcut_text(RichText::new(&named).size(10.5));
    let clicked = ui.add_enabled(can, button).on_hover_text(tip).clicked();
    let typed = ui.input_mut(|input| input.consume_shortcut(&shortcut));
    clicked || (typed && can)
}

/// The plan, a line a point.
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
                let (word, colour) = item.state.word();
                let now = item.state == ItemState::Now;
                let name = RichText::new(&item.name).color(if now { theme::ACCENT } else { theme::TEXT });
                let response = ui.label(if now { name.strong() } else { name });
                if now {
                    response.scroll_to_me(None);
                }
                ui.label(RichText::new(word).color(colour));
                let earlier = if item.earlier.is_empty() { String::new() } else { format!("before: {}", item.earlier) };
                ui.label(RichText::new(earlier).color(theme::DIM));
                // Most names have their condition in them.
                let condition = item.condition.as_ref().filter(|condition| !item.name.contains(condition.as_str()));
                let what = condition.map_or_else(|| item.what.clone(), |c| format!("{c}: {}", item.what));
                ui.add(egui::Label::new(RichText::new(what).color(theme::DIM)).truncate());
                ui.end_row();
            }
        });
    });
}

/// Minutes and seconds.
fn time(left_s: f64) -> String {
    let left = left_s.max(0.0).ceil() as u64;
    format!("{}:{:02}", left / 60, left % 60)
}
