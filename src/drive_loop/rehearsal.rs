//! Rehearsal of a study: simulated participants go through the whole plan at full speed, questions included. In: a
//! study, a data set. Out: the same files as from people. With native traffic the participants run in parallel. SUMO
//! runs once per process, so with SUMO they run one after the other.

use super::{RunError, offline::OfflineDrive, recording_manifest};
use crate::{
    driver::{self, FittedDriver, Population},
    idm::IdmParams,
    record,
    scenario::Scenario,
    study::{
        DataSet, FmsRating, ItemOutcome, ParticipantCode, PlanItem, PlannedItem, PracticeGoals, PracticeObserver,
        SessionError, SessionPlan, Study,
        dataset::{BASELINE, BASELINE_PART},
        fms::{self, FmsEvent, FmsScale},
        session::{ParticipantKind, Session, SessionLog, as_map},
        simulated::SimulatedParticipant,
        skills::{SKILL, SKILLS_MISSING},
        stop_rule::SessionEnding,
    },
    time::Tick,
    traffic::{EngineChoice, RING_STUDY},
};
use rayon::prelude::*;
use std::{
    path::Path,
    sync::atomic::{AtomicBool, Ordering},
};

/// Reason in the log for a drive that was stopped.
const STOPPED: &str = "stopped by Ctrl-C";

/// Numbers of a driver by which a participant is recognised, and the largest relative difference: a file keeps all
/// digits except the last.
const DRIVER_NUMBERS: [&str; 4] = ["reaction_s", "error_mps", "overspeed_mps", "time_gap_factor"];
const SAME_NUMBER: f64 = 1e-12;

/// Rehearsal with simulated participants of a study.
pub struct Rehearsal<'a> {
    study: &'a Study,
    data: DataSet,
    participants: usize,
    /// Drivers of the participants, in turn; if empty, each driver is drawn.
    drivers: Vec<FittedDriver>,
    /// Population from which the participants are drawn.
    population: Population,
}

/// Progress of a rehearsal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RehearsalProgress {
    /// Participants who are through, earlier calls included: to the end of the plan, or to an end by a rule of the
    /// study.
    pub complete: usize,
    /// Number of all participants.
    pub participants: usize,
    /// Participants whose session was ended by a rule of the study.
    pub stopped: usize,
}

impl<'a> Rehearsal<'a> {
    /// Opens a rehearsal for this number of participants in the folder `root`, which is new or holds a stopped
    /// rehearsal.
    ///
    /// # Errors
    /// The folder holds something else, or sessions of people.
    pub fn open(study: &'a Study, root: &Path, participants: usize) -> Result<Self, RunError> {
        let data = DataSet::open(root, study)?;
        if let Some(log) = data.logs()?.iter().find(|log| log.kind == ParticipantKind::Person) {
            return Err(SessionError::Refused(format!(
                "{} holds data of a person ({}); rehearse in another folder",
                root.display(),
                log.participant
            ))
            .into());
        }
        Ok(Self { study, data, participants, drivers: Vec::new(), population: Population::None })
    }

    /// Sets the drivers: participant `i` drives as driver `i` modulo their number.
    pub fn with_drivers(self, drivers: Vec<FittedDriver>) -> Self {
        Self { drivers, ..self }
    }

    /// Sets the population from which each participant is drawn.
    pub fn out_of(self, population: Population) -> Self {
        Self { population, ..self }
    }

    /// Returns participant number `index`.
    fn simulated(&self, index: usize) -> SimulatedParticipant {
        let drawn = SimulatedParticipant::draw(self.study.file.seed, index).out_of(self.population);
        match self.drivers.get(index % self.drivers.len().max(1)) {
            Some(known) => drawn.who_drives_as(known),
            None => drawn,
        }
    }

    /// Checks that participants who have begun continue as the same drivers, so that no session mixes two drivers.
    fn check_same_drivers(&self) -> Result<(), RunError> {
        for log in self.data.logs()?.iter().filter(|log| !log.traits.is_empty()) {
            let now = self.simulated(log.index).parameters();
            let is_other = |name: &&&str| match (log.traits.get(**name), now.get(**name)) {
                (Some(was), Some(is)) => (was - is).abs() > SAME_NUMBER * was.abs(),
                (was, is) => was != is,
            };
            let Some(name) = DRIVER_NUMBERS.iter().find(is_other) else { continue };
            let number_text = |number: Option<&f64>| number.map_or("not given".into(), ToString::to_string);
            return Err(SessionError::Refused(format!(
                "{}: participant {} began as another driver: {name} was {} and is {} now\n  remedy: repeat the earlier \
                 --drivers and --population, or leave both out if there were none, or rehearse in a new folder",
                self.data.root().display(),
                log.participant,
                number_text(log.traits.get(*name)),
                number_text(now.get(*name)),
            ))
            .into());
        }
        Ok(())
    }

    /// Returns the code of participant number `index`.
    pub fn code(index: usize) -> ParticipantCode {
        ParticipantCode::new(&format!("R{:02}", index + 1)).expect("letters and digits")
    }

    /// Returns the number of ticks of all participants, baselines included: the length of a progress bar.
    pub fn ticks(&self) -> u64 {
        let plans = (0..self.participants).map(|index| self.study.plan(index));
        plans.flat_map(|plan| plan.items).map(|planned| planned_ticks(&planned)).sum()
    }

    /// Takes all participants through the plan. `driven` is called with the ticks that were driven or found done. If
    /// `stop` is set it ends early, with everything written; a later call continues there.
    ///
    /// # Errors
    /// A participant began as another driver, a drive cannot start or go on, or a file cannot be written. Completed
    /// parts are kept.
    pub fn run(&self, stop: &AtomicBool, driven: &(impl Fn(u64) + Sync)) -> Result<RehearsalProgress, RunError> {
        self.check_same_drivers()?;
        let one = |index: usize| self.participant(index, stop, driven);
        let native = self.study.plan(0).items.iter().all(|planned| match &planned.item {
            PlanItem::Drive { scenario, .. } => scenario.traffic != EngineChoice::Sumo,
            _ => true,
        });
        let complete: Vec<bool> = if native {
            (0..self.participants).into_par_iter().map(one).collect::<Result<_, _>>()?
        } else {
            (0..self.participants).map(one).collect::<Result<_, _>>()?
        };
        let complete = complete.into_iter().filter(|is| *is).count();
        let ended = |log: &&SessionLog| log.end.as_ref().is_some_and(|end| !end.complete);
        let stopped = self.data.logs()?.iter().filter(ended).count();
        Ok(RehearsalProgress { complete, participants: self.participants, stopped })
    }

    /// Takes one participant to the end of the plan. Returns false if stopped before.
    fn participant(&self, index: usize, stop: &AtomicBool, driven: &dyn Fn(u64)) -> Result<bool, RunError> {
        if stop.load(Ordering::Relaxed) {
            return Ok(false);
        }
        let code = Self::code(index);
        let is_over = |log: &SessionLog| log.participant == code && log.end.is_some();
        let complete = if self.data.logs()?.iter().any(is_over) {
            self.study.plan(index).items.iter().for_each(|planned| driven(planned_ticks(planned)));
            true
        } else {
            SimulatedSession::open(self, index, stop, driven)?.run()?
        };
        // A session that was cut off after its last item lacks its tables, which are made here.
        self.data.publish(self.study, &code)?;
        Ok(complete)
    }
}

/// Session of one simulated participant in progress.
struct SimulatedSession<'a> {
    study: &'a Study,
    participant: SimulatedParticipant,
    session: Session,
    stop: &'a AtomicBool,
    driven: &'a dyn Fn(u64),
}

impl<'a> SimulatedSession<'a> {
    fn open(
        rehearsal: &Rehearsal<'a>,
        index: usize,
        stop: &'a AtomicBool,
        driven: &'a dyn Fn(u64),
    ) -> Result<Self, RunError> {
        let (study, code) = (rehearsal.study, Rehearsal::code(index));
        let participant = rehearsal.simulated(index);
        let now = recording_manifest::now();
        let mut session = Session::open(&rehearsal.data, study, &code, ParticipantKind::Simulated, index, &now)?;
        session.set_parameters(participant.parameters())?;
        Ok(Self { study, participant, session, stop, driven })
    }

    /// Takes the participant to the end of the plan, or to an end by a rule of the study. Returns false if stopped before.
    fn run(mut self) -> Result<bool, RunError> {
        self.count_ticks(true);
        while let Some((_, planned)) = self.session.next() {
            let planned = planned.clone();
            self.item(&planned)?;
            if self.session.log().end.is_some() {
                self.count_ticks(false);
                return Ok(true);
            }
            if self.stop.load(Ordering::Relaxed) && self.session.next().is_some() {
                return Ok(false);
            }
        }
        self.session.finish(&recording_manifest::now())?;
        Ok(true)
    }

    /// Counts the ticks of all items that are settled, or of all that are not.
    fn count_ticks(&self, settled: bool) {
        let items = self.session.plan().items.iter();
        items
            .filter(|planned| self.session.log().is_settled(&planned.name) == settled)
            .for_each(|planned| (self.driven)(planned_ticks(planned)));
    }

    fn item(&mut self, planned: &PlannedItem) -> Result<(), RunError> {
        let folder = self.session.begin(&recording_manifest::now())?;
        match &planned.item {
            PlanItem::Text(_) | PlanItem::Break(_) => {
                Ok(self.session.end(ItemOutcome::Done, "", &recording_manifest::now())?)
            }
            PlanItem::Questions(word) => {
                let answers = self.participant.answer_as_invited(self.study, word, planned);
                let ending = self.study.ending(planned, &as_map(&answers));
                Ok(self.session.end_answered(answers, ending.as_ref(), &recording_manifest::now())?)
            }
            PlanItem::Drive { scenario, practice, .. } => self.drive(planned, scenario, practice, &folder),
        }
    }

    /// Drives an item with its ratings, and a trial's baseline.
    fn drive(
        &mut self,
        planned: &PlannedItem,
        scenario: &Scenario,
        practice: &PracticeGoals,
        folder: &Path,
    ) -> Result<(), RunError> {
        let code = self.session.log().participant.clone();
        // Among measured people, drivers follow by those people's model, and time gaps are multiples of theirs.
        let is_ring_study = scenario.traffic_drivers == RING_STUDY;
        let driver = self.participant.driver_among(if is_ring_study { scenario.idm.t } else { IdmParams::default().t });
        let mut run = OfflineDrive::by(&driver, scenario, [0.0, f64::INFINITY])?;
        run.record_of(folder, "simulated participant".into(), Some(&code))?;
        let mut rater = self.rater(planned);
        let (mut whole, ending) = drive(&mut run, practice, rater.as_mut(), self.stop, &self.driven)?;
        // SUMO allows one world at a time.
        drop(run);
        let ratings = rater.map_or(Vec::new(), |rater| rater.ratings);
        let last = ratings.len().saturating_sub(1);
        for (i, rating) in ratings.into_iter().enumerate() {
            // The last rating caused the ending, if there is one.
            self.session.rate(rating, ending.as_ref().filter(|_| i == last), &recording_manifest::now())?;
        }
        if ending.is_some() {
            return Ok(());
        }
        if whole && planned.run.is_some() {
            whole = baseline(&code, folder, scenario, self.stop, &self.driven)?;
        }
        let (outcome, reason) = if whole { (ItemOutcome::Done, "") } else { (ItemOutcome::Aborted, STOPPED) };
        Ok(self.session.end(outcome, reason, &recording_manifest::now())?)
    }

    /// Returns the rater of a drive, if its segment asks for ratings. The scale starts at the last rating of the session.
    fn rater<'s>(&'s self, planned: &'s PlannedItem) -> Option<SimulatedRater<'s>> {
        let every_s = self.study.segment_of(planned)?.fms_every_s?;
        let last = self.session.log().fms.iter().rev().find_map(|rated| rated.rating.value);
        Some(SimulatedRater {
            scale: FmsScale::new(every_s, last.unwrap_or(0)),
            pending: None,
            ratings: Vec::new(),
            participant: &self.participant,
            study: self.study,
            plan: self.session.plan(),
            planned,
        })
    }
}

/// Sickness ratings by a simulated participant in a rehearsed drive, as a person gives them by wheel or keys.
struct SimulatedRater<'a> {
    scale: FmsScale,
    /// Response to the question on the screen, not yet given.
    pending: Option<FmsRating>,
    ratings: Vec<FmsRating>,
    participant: &'a SimulatedParticipant,
    study: &'a Study,
    plan: &'a SessionPlan,
    planned: &'a PlannedItem,
}

impl SimulatedRater<'_> {
    /// Updates the rating after a step of the drive. Returns the ending that the rating causes, if any.
    fn step(&mut self, run: &mut OfflineDrive) -> Option<SessionEnding> {
        let (now_s, end_s) = (run.world().time_s(), run.world().scenario().duration_s);
        match self.scale.time(now_s, end_s) {
            Some(FmsEvent::Asked) => {
                run.note(fms::ASKED, "");
                self.pending = Some(self.participant.rate(self.plan, &self.planned.name, now_s));
            }
            Some(FmsEvent::Unanswered(rating)) => {
                run.note(fms::UNANSWERED, &rating.to_string());
                self.ratings.push(rating);
            }
            None => {}
        }
        let answered = self.pending.filter(|rating| rating.answer_s.is_some_and(|s| now_s >= rating.time_s + s))?;
        self.pending = None;
        let prompt = self.scale.prompt(now_s)?;
        self.scale.turn(i32::from(answered.value?) - i32::from(prompt.value));
        let rating = self.scale.confirm(now_s)?;
        run.note_value(fms::ANSWERED, &rating.to_string(), rating.value?.into());
        self.ratings.push(rating);
        self.study.ending_of_rating(self.planned, &rating)
    }
}

/// Returns the number of ticks of a drive of this scenario.
pub fn ticks(scenario: &Scenario) -> u64 {
    Tick::at_seconds(scenario.duration_s).0
}

/// Returns the number of ticks of an item, including a trial's baseline.
fn planned_ticks(planned: &PlannedItem) -> u64 {
    match &planned.item {
        PlanItem::Drive { scenario, .. } => ticks(scenario) * if planned.run.is_some() { 2 } else { 1 },
        _ => 0,
    }
}

/// Drives the baseline of a trial: same seed and scenario, without advice, with the car-following model as the driver.
/// A complete baseline is stored beside the trial. An incomplete one has no participant's data and is made anew.
/// Returns false if stopped before the end.
///
/// # Errors
/// The drive cannot start or go on, or the recording cannot be written.
pub fn baseline(
    code: &ParticipantCode,
    trial: &Path,
    scenario: &Scenario,
    stop: &AtomicBool,
    driven: &impl Fn(u64),
) -> Result<bool, RunError> {
    let named = |ending: &str| {
        let mut name = trial.file_name().unwrap_or_default().to_owned();
        name.push(ending);
        trial.with_file_name(name)
    };
    let (whole, folder) = (named(BASELINE), named(BASELINE_PART));
    record::remove(&folder)?;
    let without = Scenario { policy: "none".into(), driver: "idm".into(), ..scenario.clone() };
    let mut run = OfflineDrive::by(&driver::named(&without.driver)?.params, &without, [0.0, f64::INFINITY])?;
    run.record_of(&folder, "simulated: idm".into(), Some(code))?;
    let (driven, _) = drive(&mut run, &PracticeGoals::default(), None, stop, driven)?;
    drop(run);
    if driven {
        record::rename(&folder, &whole)?;
    } else {
        record::remove(&folder)?;
    }
    Ok(driven)
}

/// Drives to the end, to the criterion, to an ending by a rule, or until stopped (false). The recording is finished in
/// any case.
fn drive(
    run: &mut OfflineDrive,
    practice: &PracticeGoals,
    mut rater: Option<&mut SimulatedRater<'_>>,
    stop: &AtomicBool,
    driven: &impl Fn(u64),
) -> Result<(bool, Option<SessionEnding>), RunError> {
    let step_s = run.world().scenario().step_s;
    let all = ticks(run.world().scenario());
    let mut observer = PracticeObserver::new(run.world().map());
    let (mut whole, mut ending) = (true, None);
    while run.world().ended().is_none() {
        let before = run.world().snapshot().tick.0;
        run.step()?;
        let snapshot = run.world().snapshot();
        driven(snapshot.tick.0 - before);
        let before = observer.progress().shown;
        observer.step(snapshot, run.world().map(), step_s);
        let progress = observer.progress();
        practice.shown_between(before, progress.shown).for_each(|skill| run.note(SKILL, skill.name()));
        ending = rater.as_mut().and_then(|rater| rater.step(run));
        if let Some(ending) = &ending {
            run.note("stopped", &ending.reason);
            break;
        }
        if let Some(criterion) = practice.met(&progress) {
            run.note("criterion", &criterion);
            driven(all.saturating_sub(run.world().snapshot().tick.0));
            break;
        }
        if stop.load(Ordering::Relaxed) && run.world().ended().is_none() {
            run.note("stopped", STOPPED);
            whole = false;
            break;
        }
    }
    let missing = practice.missing(observer.progress().shown);
    if whole && ending.is_none() && !missing.is_empty() {
        run.note(SKILLS_MISSING, &missing);
    }
    run.finish_recording()?;
    Ok((whole, ending))
}
