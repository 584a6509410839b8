//! State and commands of the session panel. In: the state of a session. Out: [`SessionPanelState`] for the panel, and the commands of the
//! experimenter.

use crate::panel::theme;
use egui::Color32;

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
    /// Request to stop that is not decided yet.
    pub asked: Option<StopRequest>,
    /// Last error, if there was one.
    pub error: Option<&'a str>,
    /// Work of the program in the background: baselines, tables.
    pub work: Option<&'a str>,
}

/// Maker of a request to stop, which holds everything until the experimenter decides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopRequest {
    /// The participant, by key or button.
    Participant,
    /// The experimenter, who has opened the question of a command that ends the session.
    Experimenter,
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
    pub(super) fn label(self) -> (&'static str, Color32) {
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
    /// Keep words that were typed in the panel and not entered.
    Draft(String),
    /// Hold drive, sound and screens at once: the question of a command that ends the session is open.
    Hold,
    /// Mark this moment; the text may be empty.
    Mark(String),
    /// Begin the event of this number in the drive's scenario by hand.
    BeginEvent(usize),
    /// Pause the running drive.
    Pause,
    /// Resume the paused drive.
    Resume,
    /// End the session for good, e.g. after sickness.
    Stop(String),
    /// End the session for good because program, computer or a device failed.
    StopTechnically(String),
    /// Exclude the data of this session, and end it.
    Exclude(String),
    /// Close the windows of an unfinished session; the same command resumes it.
    Interrupt(String),
    /// Close the windows of a finished session.
    Close,
}

/// Returns the names of the items that can be repeated: done or skipped.
pub(super) fn repeatable<'a>(state: &SessionPanelState<'a>) -> Vec<&'a str> {
    let settled = |item: &&SessionItem| matches!(item.state, ItemState::Done | ItemState::Skipped);
    state.items.iter().filter(settled).map(|item| item.name.as_str()).collect()
}
