//! Practice drives of a session: their criterion and the skills that they ask for. In: the progress of the drive. Out: notes in the session
//! log and the recording, the end of the drive, and a text for the experimenter.

use super::{BackendStatus, DriveBackend, LiveSession, SessionState};
use crate::{
    drive_loop::RunError,
    study::{
        ItemOutcome, PlanItem, PracticeGoals,
        skills::{SKILL, SKILLS_MISSING, ShownSkills, Skill},
    },
};

impl LiveSession {
    /// Prepares the skills for a new drive.
    pub(super) fn begin_practice(&mut self) {
        self.noted_skills = ShownSkills::default();
        self.missing_skills.clear();
    }

    /// Notes the skills that were newly shown, and ends the drive if its criterion is met or its time is over.
    pub(super) fn watch(&mut self, backend: &mut dyn DriveBackend) -> Result<(), RunError> {
        let now = backend.now();
        let goals = self.goals();
        let shown: Vec<Skill> = goals.shown_between(self.noted_skills, now.practice.shown).collect();
        self.noted_skills = now.practice.shown;
        for skill in shown {
            self.write(SKILL, skill.name(), backend)?;
        }
        let met = goals.met(&now.practice);
        if let Some(criterion) = &met {
            backend.note("criterion", criterion);
        }
        if met.is_none() && !now.ended {
            return Ok(());
        }
        self.missing_skills = goals.missing(now.practice.shown);
        if !self.missing_skills.is_empty() {
            self.write(SKILLS_MISSING, &self.missing_skills.clone(), backend)?;
        }
        match backend.end() {
            Ok(()) => {
                let ended = self.session.end(ItemOutcome::Done, "", &(self.utc)());
                self.enter(SessionState::Over);
                Ok(ended?)
            }
            Err(error) => {
                self.fail(&error, backend);
                Ok(())
            }
        }
    }

    /// Returns the goals of the running drive.
    fn goals(&self) -> PracticeGoals {
        match self.running().map(|planned| &planned.item) {
            Some(PlanItem::Drive { practice, .. }) => practice.clone(),
            _ => PracticeGoals::default(),
        }
    }

    /// Describes the progress of a practice drive towards its criterion and its skills, or the skills that the last one did not show; `None`
    /// if there is nothing to say.
    pub fn practice(&self, now: BackendStatus) -> Option<String> {
        if !matches!(self.at, SessionState::Driving) {
            let missing = &self.missing_skills;
            return (!missing.is_empty())
                .then(|| format!("skills not shown: {missing} (Repeat brings the drive again)"));
        }
        let goals = self.goals();
        let [at_s, best_s] = [now.practice.in_range.now_s(), now.practice.in_range.longest_s()];
        let of_range = goals.until_in_range_s.map(|enough_s| {
            format!("in the range without a break for {at_s:.1} s of {enough_s} s, at best {best_s:.1} s")
        });
        let of_skills = (!goals.skills.is_empty()).then(|| match goals.missing(now.practice.shown).as_str() {
            "" => "all skills shown".to_owned(),
            missing => format!("skills to come: {missing}"),
        });
        let parts: Vec<String> = of_range.into_iter().chain(of_skills).collect();
        (!parts.is_empty()).then(|| parts.join(", "))
    }
}
