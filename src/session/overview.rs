//! Overview of a session for its windows. In: state of the session and status of the drive. Out: the participant's screen; the
//! experimenter's plan, phase and texts. Nothing is changed here.

use super::{BackendStatus, LiveSession, SessionState};
use crate::{
    panel::{ItemState, ParticipantScreen, SessionItem, SessionPhase, StopRequest},
    study::{ItemOutcome, session::SessionLog},
};

/// Describes earlier runs of an item, without the last run if the item's present state already shows it: an item that was broken off and
/// then skipped was not skipped twice.
fn earlier(log: &SessionLog, item: &str, is_running: bool, is_over: bool) -> String {
    let of_it = log.item_runs.iter().filter(|item_run| item_run.item == item);
    let mut words: Vec<&str> = of_it
        .filter_map(|item_run| match item_run.outcome {
            ItemOutcome::Done => Some("done"),
            ItemOutcome::Aborted => Some("broken off"),
            ItemOutcome::Cut => Some("cut"),
            ItemOutcome::Skipped => Some("skipped"),
            ItemOutcome::Repeat => None,
        })
        .collect();
    let last = log.last(item).map(|item_run| item_run.outcome);
    let is_said = matches!(last, Some(ItemOutcome::Done | ItemOutcome::Skipped))
        || (is_over && matches!(last, Some(ItemOutcome::Aborted | ItemOutcome::Cut)));
    if !is_running && is_said {
        words.pop();
    }
    words.join(", ")
}

impl LiveSession {
    /// Returns the participant's screen.
    pub fn screen(&self, now: BackendStatus) -> ParticipantScreen<'_> {
        let texts = &self.study.file.texts;
        let held = self.disk_text().or(match self.asked {
            Some(StopRequest::Participant) => Some(&*texts.asked),
            Some(StopRequest::Experimenter) if self.drives() => Some(&*texts.paused),
            Some(StopRequest::Experimenter) => Some(&*texts.wait),
            None => None,
        });
        match &self.at {
            SessionState::Countdown(..) | SessionState::Driving if held.is_some() => ParticipantScreen::Drive(held),
            _ if held.is_some() => ParticipantScreen::Wait(held.unwrap_or_default()),
            SessionState::Hold => ParticipantScreen::Wait(&texts.wait),
            SessionState::Loading(_) => ParticipantScreen::Wait(&texts.ready),
            SessionState::Text(text) | SessionState::Intro(text) => ParticipantScreen::Page(text),
            SessionState::Over => ParticipantScreen::Page(&texts.drive_over),
            SessionState::Countdown(_, true) => ParticipantScreen::Drive(Some(&texts.paused)),
            SessionState::Countdown(..) if self.waits_for_brake(now) => ParticipantScreen::Drive(Some(&texts.brake)),
            SessionState::Countdown(left_s, false) => {
                let speed = now.unit.from_mps(now.speed_mps.abs()).round() as u32;
                ParticipantScreen::Countdown(left_s.ceil().max(1.0) as u32, speed, now.unit)
            }
            SessionState::Driving if now.held => ParticipantScreen::Drive(Some(&texts.paused)),
            SessionState::Driving => match self.rating_prompt(now) {
                Some(prompt) => ParticipantScreen::Rating(prompt),
                None => ParticipantScreen::Drive(None),
            },
            SessionState::Rest(text, left_s) => ParticipantScreen::Rest(text, *left_s),
            SessionState::Questions(form) => ParticipantScreen::Questions(form),
            SessionState::End => ParticipantScreen::Wait(&texts.thanks),
            SessionState::Stopped(words) => ParticipantScreen::Wait(words),
        }
    }

    /// Returns the number of settled items of the plan, and the number of all items.
    pub fn progress(&self) -> [usize; 2] {
        let items = &self.session.plan().items;
        [items.iter().filter(|planned| self.session.log().is_settled(&planned.name)).count(), items.len()]
    }

    /// Returns true if the participant has given every consent of the plan, and the session is not over.
    pub fn has_consent(&self) -> bool {
        let mut asked = self.session.plan().items.iter().filter(|planned| self.study.is_consent(planned));
        !self.is_over() && asked.all(|planned| self.session.log().done(&planned.name).is_some())
    }

    /// Returns the expected duration of the unsettled items, s; 0 after the end.
    pub fn to_come_s(&self) -> f64 {
        let left =
            self.session.plan().items.iter().filter(|p| !self.is_over() && !self.session.log().is_settled(&p.name));
        left.map(|planned| planned.seconds).sum()
    }

    /// Returns the items of the plan with their states.
    pub fn items(&self) -> Vec<SessionItem> {
        let log = self.session.log();
        let running = log.running.as_ref().map(|running| running.item.as_str());
        let items = self.session.plan().items.iter();
        items
            .map(|planned| {
                let now = running == Some(planned.name.as_str());
                let state = match log.last(&planned.name).map(|item_run| item_run.outcome) {
                    _ if now => ItemState::Now,
                    None => ItemState::Ahead,
                    Some(ItemOutcome::Done) => ItemState::Done,
                    Some(ItemOutcome::Skipped) => ItemState::Skipped,
                    Some(_) if self.is_over() => ItemState::Broken,
                    Some(ItemOutcome::Aborted | ItemOutcome::Cut | ItemOutcome::Repeat) => ItemState::Again,
                };
                SessionItem {
                    name: planned.name.clone(),
                    what: planned.item.to_string(),
                    condition: planned.condition.clone(),
                    state,
                    earlier: earlier(log, &planned.name, now, self.is_over()),
                }
            })
            .collect()
    }

    /// Describes the participant's screen for the experimenter.
    pub fn sees(&self) -> String {
        let name = self.session.log().running.as_ref().map_or("", |running| running.item.as_str());
        match &self.at {
            SessionState::Hold => "please wait".into(),
            SessionState::Text(_) => format!("page {name}"),
            SessionState::Intro(_) => format!("text before {name}"),
            SessionState::Loading(_) => format!("{name} is loading"),
            SessionState::Countdown(..) if self.lacks_brake => format!("{name} waits until the brake is pressed"),
            SessionState::Countdown(..) => format!("countdown to {name}"),
            SessionState::Driving => format!("drive {name}"),
            SessionState::Over => "the drive is over".into(),
            SessionState::Rest(..) => format!("rest {name}"),
            SessionState::Questions(form) => {
                let (page, pages) = form.progress();
                format!("questions {name}, page {} of {pages}", page + 1)
            }
            SessionState::End => "thanks".into(),
            SessionState::Stopped(_) => "stopped, thanks".into(),
        }
    }

    /// Returns the phase of the session, which says what it waits for.
    pub fn phase(&self, now: BackendStatus) -> SessionPhase {
        match &self.at {
            SessionState::End | SessionState::Stopped(_) => SessionPhase::Over,
            _ if self.asked.is_some() || self.waits_for_disk() => SessionPhase::Held,
            SessionState::Hold => SessionPhase::Experimenter,
            SessionState::Countdown(_, held) if *held => SessionPhase::Held,
            SessionState::Driving if now.held => SessionPhase::Held,
            SessionState::Loading(_) | SessionState::Countdown(..) | SessionState::Driving => SessionPhase::Driving,
            SessionState::Rest(_, left_s) if *left_s > 0.0 => SessionPhase::Resting,
            _ => SessionPhase::Participant,
        }
    }

    /// Returns the remaining time of a drive, countdown or rest, s.
    pub fn left_s(&self, now: BackendStatus) -> Option<f64> {
        match &self.at {
            SessionState::Driving => Some(now.duration_s - now.time_s),
            SessionState::Countdown(left_s, _) | SessionState::Rest(_, left_s) => Some(*left_s),
            _ => None,
        }
    }

    /// Returns the error of a drive that could not go on. Refused commands and ends by a rule are not errors of a drive.
    pub fn drive_fault(&self) -> Option<&str> {
        self.error().filter(|_| self.drive_failed && !self.is_over())
    }
}
