//! A visit as its windows show it. In: where it is and how its drive stands. Out: the participant's screen; the experimenter's
//! plan, phase and words. Nothing is changed here.

use super::{At, RoadNow, Visit};
use crate::{
    panel::{ItemState, Screen, VisitItem, VisitPhase},
    study::{Outcome, session::Log},
};

/// What became of an item before what is said of it now: an item that was broken off and then skipped was not skipped twice.
fn earlier(log: &Log, item: &str, is_running: bool, is_over: bool) -> String {
    let of_it = log.passages.iter().filter(|passage| passage.item == item);
    let mut words: Vec<&str> = of_it
        .filter_map(|passage| match passage.outcome {
            Outcome::Done => Some("done"),
            Outcome::Aborted => Some("broken off"),
            Outcome::Cut => Some("cut"),
            Outcome::Skipped => Some("skipped"),
            Outcome::Repeat => None,
        })
        .collect();
    let last = log.last(item).map(|passage| passage.outcome);
    let is_said = matches!(last, Some(Outcome::Done | Outcome::Skipped))
        || (is_over && matches!(last, Some(Outcome::Aborted | Outcome::Cut)));
    if !is_running && is_said {
        words.pop();
    }
    words.join(", ")
}

impl Visit {
    /// What the participant sees.
    pub fn screen(&self, now: RoadNow) -> Screen<'_> {
        let texts = &self.study.file.texts;
        match &self.at {
            At::Countdown(..) | At::Driving if self.asked => Screen::Drive(Some(&texts.asked)),
            _ if self.asked => Screen::Wait(&texts.asked),
            At::Hold => Screen::Wait(&texts.wait),
            At::Loading(_) => Screen::Wait(&texts.ready),
            At::Text(text) | At::Intro(text) => Screen::Page(text),
            At::Over => Screen::Page(&texts.drive_over),
            At::Countdown(_, true) => Screen::Drive(Some(&texts.paused)),
            At::Countdown(left_s, false) => {
                let speed = now.unit.from_mps(now.speed_mps.abs()).round() as u32;
                Screen::Countdown(left_s.ceil().max(1.0) as u32, speed, now.unit)
            }
            At::Driving if now.held => Screen::Drive(Some(&texts.paused)),
            At::Driving => Screen::Drive(None),
            At::Rest(text, left_s) => Screen::Rest(text, *left_s),
            At::Questions(form) => Screen::Questions(form),
            At::End => Screen::Wait(&texts.thanks),
            At::Stopped => Screen::Wait(&texts.stopped),
        }
    }

    /// How many points of the plan are behind, and how many there are.
    pub fn progress(&self) -> [usize; 2] {
        let items = &self.session.plan().items;
        [items.iter().filter(|planned| self.session.log().settled(&planned.name)).count(), items.len()]
    }

    /// How long what is not yet settled is reckoned to last, seconds; nothing comes after the end.
    pub fn to_come_s(&self) -> f64 {
        let left = self.session.plan().items.iter().filter(|p| !self.is_over() && !self.session.log().settled(&p.name));
        left.map(|planned| planned.item.seconds()).sum()
    }

    /// The plan with what has become of it.
    pub fn items(&self) -> Vec<VisitItem> {
        let log = self.session.log();
        let running = log.running.as_ref().map(|running| running.item.as_str());
        let items = self.session.plan().items.iter();
        items
            .map(|planned| {
                let now = running == Some(planned.name.as_str());
                let state = match log.last(&planned.name).map(|passage| passage.outcome) {
                    _ if now => ItemState::Now,
                    None => ItemState::Ahead,
                    Some(Outcome::Done) => ItemState::Done,
                    Some(Outcome::Skipped) => ItemState::Skipped,
                    Some(_) if self.is_over() => ItemState::Broken,
                    Some(Outcome::Aborted | Outcome::Cut | Outcome::Repeat) => ItemState::Again,
                };
                VisitItem {
                    name: planned.name.clone(),
                    what: planned.item.words(),
                    condition: planned.condition.clone(),
                    state,
                    earlier: earlier(log, &planned.name, now, self.is_over()),
                }
            })
            .collect()
    }

    /// What the participant sees, in the experimenter's words.
    pub fn sees(&self) -> String {
        let name = self.session.log().running.as_ref().map_or("", |running| running.item.as_str());
        match &self.at {
            At::Hold => "please wait".into(),
            At::Text(_) => format!("page {name}"),
            At::Intro(_) => format!("words before {name}"),
            At::Loading(_) => format!("{name} is being loaded"),
            At::Countdown(..) => format!("countdown to {name}"),
            At::Driving => format!("drive {name}"),
            At::Over => "the drive is over".into(),
            At::Rest(..) => format!("rest {name}"),
            At::Questions(form) => {
                let (page, pages) = form.progress();
                format!("questions {name}, page {} of {pages}", page + 1)
            }
            At::End => "thanks".into(),
            At::Stopped => "stopped, thanks".into(),
        }
    }

    /// What the visit waits for.
    pub fn phase(&self, now: RoadNow) -> VisitPhase {
        match &self.at {
            At::End | At::Stopped => VisitPhase::Over,
            _ if self.asked => VisitPhase::Held,
            At::Hold => VisitPhase::Experimenter,
            At::Countdown(_, held) if *held => VisitPhase::Held,
            At::Driving if now.held => VisitPhase::Held,
            At::Loading(_) | At::Countdown(..) | At::Driving => VisitPhase::Driving,
            At::Rest(_, left_s) if *left_s > 0.0 => VisitPhase::Resting,
            _ => VisitPhase::Participant,
        }
    }

    /// Seconds that are left of what ends by itself.
    pub fn left_s(&self, now: RoadNow) -> Option<f64> {
        match &self.at {
            At::Driving => Some(now.duration_s - now.time_s),
            At::Countdown(left_s, _) | At::Rest(_, left_s) => Some(*left_s),
            _ => None,
        }
    }

    /// What went wrong last.
    pub fn error(&self) -> Option<&str> {
        self.error.as_deref()
    }
}
