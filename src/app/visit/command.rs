//! What the experimenter decides in a visit. In: a [`VisitCommand`]. Out: the visit elsewhere, and the decision with time
//! and reason in the session, while a drive runs also in its recording.

use super::{At, Refused, Road, Visit};
use crate::{app::AppError, panel::VisitCommand, study::Outcome};

impl From<AppError> for Refused {
    fn from(error: AppError) -> Self {
        Self::End(error)
    }
}

impl Visit {
    /// The experimenter decides. What cannot be is said in the panel.
    ///
    /// # Errors
    /// The session cannot be written.
    pub fn command(&mut self, command: VisitCommand, road: &mut dyn Road) -> Result<(), AppError> {
        self.error = None;
        match self.obey(command, road) {
            Ok(()) => Ok(()),
            Err(Refused::Say(text)) => {
                self.error = Some(text);
                Ok(())
            }
            Err(Refused::End(error)) => Err(error),
        }
    }

    fn obey(&mut self, command: VisitCommand, road: &mut dyn Road) -> Result<(), Refused> {
        match command {
            VisitCommand::Go => self.go(road),
            VisitCommand::Abort(reason) => self.abort(&reason, road),
            VisitCommand::Skip(reason) => self.skip(&reason, road),
            VisitCommand::Repeat { item, reason } => {
                if self.session.log().running.as_ref().is_some_and(|running| running.item == item) {
                    return self.abort(&reason, road);
                }
                self.not_over()?;
                Ok(self.session.repeat(&item, &reason, &(self.utc)())?)
            }
            VisitCommand::Extend { seconds, reason } => self.extend(seconds, &reason, road),
            VisitCommand::Note(text) => Ok(self.write("note", &text, road)?),
            VisitCommand::Mark(text) => {
                let text = if text.is_empty() { "by the experimenter" } else { &text };
                Ok(self.write("mark", text, road)?)
            }
            VisitCommand::Close | VisitCommand::Interrupt(_) => Ok(()),
            VisitCommand::Pause => self.hold(true, road),
            VisitCommand::Resume => self.hold(false, road),
            VisitCommand::Stop(reason) => {
                self.not_over()?;
                self.leave("stopped", &reason, road)?;
                self.session.stop(&reason, &(self.utc)())?;
                self.asked = false;
                self.see(At::Stopped);
                Ok(())
            }
            VisitCommand::Exclude(reason) => {
                if !self.is_over() {
                    self.leave("excluded", &reason, road)?;
                    self.session.stop(&reason, &(self.utc)())?;
                    self.asked = false;
                    self.see(At::Stopped);
                }
                Ok(self.session.exclude(&reason)?)
            }
        }
    }

    fn not_over(&self) -> Result<(), Refused> {
        if self.is_over() { Err(Refused::Say("the visit is over".into())) } else { Ok(()) }
    }

    fn go(&mut self, road: &mut dyn Road) -> Result<(), Refused> {
        if self.asked {
            return self.hold(false, road);
        }
        match &self.at {
            At::Hold => self.go_on()?,
            At::Rest(_, left_s) => {
                if *left_s > 0.0 {
                    let text = format!("the rest ends {left_s:.0} s sooner");
                    self.write("go", &text, road)?;
                }
                self.turn_page()?;
            }
            At::Text(_) | At::Intro(_) | At::Over => self.turn_page()?,
            At::Countdown(..) | At::Driving => return self.hold(false, road),
            At::Questions(_) => {
                let text = "the participant has to answer the questions first; Skip leaves them out";
                return Err(Refused::Say(text.into()));
            }
            At::Loading(_) | At::End | At::Stopped => {}
        }
        Ok(())
    }

    /// Pauses a drive or its countdown, or lets it go on; also everything else that a request to stop has held.
    fn hold(&mut self, held: bool, road: &mut dyn Road) -> Result<(), Refused> {
        let asked = !held && std::mem::take(&mut self.asked);
        let was = match &mut self.at {
            At::Countdown(_, now) => std::mem::replace(now, held),
            At::Driving => {
                let was = road.now().held;
                road.hold(held);
                was
            }
            _ if asked => true,
            _ => return Err(Refused::Say("there is no drive to pause".into())),
        };
        if asked || was != held {
            self.write(if held { "paused" } else { "resumed" }, "by the experimenter", road)?;
        }
        Ok(())
    }

    /// Ends what runs on the road, if anything, with a word in its recording. True if a drive was there.
    pub(super) fn leave(&mut self, kind: &str, reason: &str, road: &mut dyn Road) -> Result<bool, AppError> {
        let drives = self.drives() || matches!(self.at, At::Loading(_));
        if matches!(self.at, At::Driving) {
            road.note(kind, reason);
        }
        if drives {
            road.end()?;
        }
        Ok(drives)
    }

    fn abort(&mut self, reason: &str, road: &mut dyn Road) -> Result<(), Refused> {
        if self.session.log().running.is_none() {
            return Err(Refused::Say("there is nothing to break off".into()));
        }
        self.leave("aborted", reason, road)?;
        self.session.end(Outcome::Aborted, reason, &(self.utc)())?;
        self.asked = false;
        self.see(At::Hold);
        Ok(())
    }

    fn skip(&mut self, reason: &str, road: &mut dyn Road) -> Result<(), Refused> {
        self.not_over()?;
        let runs = self.session.log().running.is_some();
        let drove = self.leave("skipped", reason, road)?;
        self.session.skip(reason, &(self.utc)())?;
        self.asked = false;
        if drove {
            self.see(At::Hold);
        } else if runs {
            self.go_on()?;
        }
        Ok(())
    }

    fn extend(&mut self, seconds: f64, reason: &str, road: &mut dyn Road) -> Result<(), Refused> {
        if !(1.0..=3600.0).contains(&seconds) {
            return Err(Refused::Say(format!("the extension is {seconds} s; allowed: 1 to 3600 s")));
        }
        match &mut self.at {
            At::Driving => road.extend(seconds)?,
            At::Rest(_, left_s) => *left_s += seconds,
            _ => return Err(Refused::Say("there is no drive and no rest to extend".into())),
        }
        Ok(self.write("extended", &format!("by {seconds} s: {reason}"), road)?)
    }
}
