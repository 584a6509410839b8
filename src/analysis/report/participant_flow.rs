//! Flow of the participants through a study, as reports of trials have it (CONSORT; Schulz et al. 2010). In: participants with the ends of
//! their sessions, analysed drives, the planned analysis. Out: a diagram, a table by order of conditions, and a paragraph of the methods.
//! The numbers add up: each participant of a stage is in the next one or among those who leave before it.

use super::page::{ReportFigure, ReportPage, TableCells};
use crate::analysis::{
    data::{StudyParticipant, StudyParticipants, people::DAMAGED},
    drives::AnalysedRecording,
    models::planned::PlannedAnalysis,
    text::{joined_with_and, on_one_line},
};
use crate::plot::{FlowBox, FlowChart};
use std::collections::{BTreeMap, BTreeSet};

/// Numbers of participants or of trials by reason, in the order in which reasons first occur.
type Reasons = Vec<(String, usize)>;

/// A stage of the flow.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct FlowStage<'a> {
    /// Stage in words: `Sessions begun`.
    title: &'static str,
    /// Participants of the stage whose data are there.
    ids: BTreeSet<&'a str>,
    /// Participants of the stage whose data were erased.
    erased: usize,
    /// Facts about these participants.
    facts: Reasons,
    /// Participants who leave before the next stage: their number, and their reasons, or facts about their trials.
    leave: Option<(&'static str, usize, Reasons)>,
}

/// Flow of the participants of a study.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ParticipantFlow<'a> {
    stages: Vec<FlowStage<'a>>,
    people: &'a StudyParticipants,
}

/// Adds a count to a reason, which becomes one line without control characters.
fn add(reasons: &mut Reasons, reason: &str, count: usize) {
    let reason = on_one_line(reason);
    match reasons.iter_mut().find(|known| known.0 == reason) {
        Some(known) => known.1 += count,
        None if count > 0 => reasons.push((reason, count)),
        None => {}
    }
}

/// Returns a reason with words of the experimenter or of a rule: `excluded: the phone rang`.
fn with(what: &str, words: &str) -> String {
    if words.is_empty() { what.to_owned() } else { format!("{what}: {words}") }
}

/// Returns the state of a session in words, with the reason of an early end.
fn state(person: &StudyParticipant) -> String {
    match person.state.as_str() {
        "complete" => "session completed".into(),
        "partial" => "session completed, with parts skipped".into(),
        "withdrawn" if person.ends.is_by_limit => limit(&person.ends.end),
        "withdrawn" => with("ended early", &person.ends.end),
        "ended_technically" => with("ended early for a technical reason", &person.ends.end),
        "declined" => "did not agree to take part".into(),
        "not_eligible" => with("not eligible", person.ends.end.trim_end_matches(" (ends_if)")),
        "open" if person.ends.is_cut => "session not over, cut by a failure of the program or the computer".into(),
        "open" => "session not over".into(),
        other => other.replace('_', " "),
    }
}

/// Returns the limit that ended a session, without drive and value: `trial-1-a: fms is 12, above 10 (stop_above)` is `ended early by a limit:
/// fms above 10`. The score of a questionnaire that is not about a trial keeps its segment: `ssq total above 60`.
fn limit(reason: &str) -> String {
    let parts = reason.split_once(": ").and_then(|(item, rest)| Some((item, rest.split_once(" is ")?)));
    let above = reason.split_once(", above ").map(|(_, value)| value.trim_end_matches(" (stop_above)"));
    match parts.zip(above) {
        Some(((item, (score, _)), above)) => {
            let of = if score == "fms" || score.contains('.') { String::new() } else { format!("{item} ") };
            format!("ended early by a limit: {of}{score} above {above}")
        }
        None => with("ended early by a limit", reason),
    }
}

fn is_trial(drive: &AnalysedRecording) -> bool {
    !drive.found.condition.is_empty()
}

impl<'a> ParticipantFlow<'a> {
    /// Counts the participants; `None` outside of a study, and for one participant alone.
    pub(super) fn of(
        people: &'a StudyParticipants,
        drives: &'a [AnalysedRecording],
        planned: Option<&'a PlannedAnalysis>,
    ) -> Option<Self> {
        if people.all.len() + people.erased < 2 {
            return None;
        }
        // Where no drive has a condition, every drive is a trial.
        let has_conditions = drives.iter().any(is_trial);
        let trials: Vec<&str> = drives
            .iter()
            .filter(|drive| !has_conditions || is_trial(drive))
            .map(|drive| drive.found.participant.as_str())
            .collect();
        let (begun, mut ids) = begun(people, &trials);
        let (taken, excluded) = taken(people, &ids);
        ids.retain(|id| !excluded.contains(id));
        let (kept, analysed) = kept(people, &ids, &trials);
        let mut stages = vec![begun, taken, kept];
        stages.push(of_drives(analysed, &trials, planned));
        if let Some(planned) = planned {
            stages.push(in_models(planned));
        }
        Some(Self { stages, people })
    }

    /// Draws the stages as boxes, from the sessions begun to the last analysis.
    pub(super) fn figure(&self) -> ReportFigure {
        let lines = |reasons: &Reasons| reasons.iter().map(|(reason, n)| format!("{reason}: {n}")).collect();
        let step = |stage: &FlowStage<'_>| {
            let title = format!("{}: {}", stage.title, stage.count());
            let leave = stage
                .leave
                .as_ref()
                .map(|(title, n, reasons)| FlowBox { title: format!("{title}: {n}"), lines: lines(reasons) });
            (FlowBox { title, lines: lines(&stage.facts) }, leave)
        };
        let caption = "Flow of the participants through the study: numbers of participants, if nothing else is written. To the right \
                       are those who left before the next stage, with the reasons in the words of the experimenter, or the rule.";
        ReportFigure {
            name: "participant-flow".into(),
            svg: FlowChart { steps: self.stages.iter().map(step).collect() }.svg(),
            caption: caption.into(),
        }
    }

    /// Returns the numbers of participants at each stage by order of conditions; none if all have the same order, or each has their own.
    fn by_order(&self) -> Vec<(String, Vec<usize>)> {
        let mut orders: BTreeMap<&str, Vec<usize>> = BTreeMap::new();
        for person in &self.people.all {
            let counts = orders.entry(&person.order).or_insert_with(|| vec![0; self.stages.len()]);
            for (count, stage) in counts.iter_mut().zip(&self.stages) {
                *count += usize::from(stage.ids.contains(person.id.as_str()));
            }
        }
        if orders.len() < 2 || orders.values().all(|counts| counts[0] < 2) {
            return Vec::new();
        }
        orders.into_iter().enumerate().map(|(i, (order, counts))| (order_text(i + 1, order), counts)).collect()
    }

    /// Adds the diagram and the table to the page.
    pub(super) fn section(&self, page: &mut ReportPage) {
        page.put("<h2>Participants</h2>");
        let by_order = self.by_order();
        let table = if by_order.is_empty() {
            String::new()
        } else {
            format!(", and {} gives them by order of conditions", page.table_links(1))
        };
        let links = page.figure_links(0, 1);
        page.paragraph("lead", &format!("{links} shows how many participants began, left and were analysed{table}."));
        page.figure(self.figure());
        if by_order.is_empty() {
            return;
        }
        let head = ["Order of conditions".to_owned()].into_iter();
        let row = |(order, counts): &(String, Vec<usize>)| {
            [order.clone()].into_iter().chain(counts.iter().map(usize::to_string)).collect::<TableCells>()
        };
        let mut rows: Vec<TableCells> = by_order.iter().map(row).collect();
        let sum = |k: usize| by_order.iter().map(|(_, counts)| counts[k]).sum::<usize>().to_string();
        rows.push(["All".to_owned()].into_iter().chain((0..self.stages.len()).map(sum)).collect());
        let without = if self.people.erased > 0 { ", without those whose data were erased" } else { "" };
        page.table(
            &format!("Participants of each stage by order of conditions{without}. The file participants.tsv of the data set has each order."),
            &head.chain(self.stages.iter().map(|stage| stage.title.to_owned())).collect(),
            &rows,
            &[],
        );
    }

    /// Returns the paragraph of the methods, with the numbers of the diagram and of the table.
    pub(super) fn paragraph(&self) -> String {
        let list = |reasons: &Reasons| {
            let texts: Vec<String> = reasons.iter().map(|(reason, n)| format!("{reason}: {n}")).collect();
            if texts.is_empty() { String::new() } else { format!(" ({})", texts.join("; ")) }
        };
        let stage = |stage: &FlowStage<'_>| {
            let leave = stage.leave.as_ref().map_or(String::new(), |(title, n, reasons)| {
                if *n == 0 && reasons.is_empty() { String::new() } else { format!(" {title}: {n}{}.", list(reasons)) }
            });
            format!("{}: {}{}.{leave}", stage.title, stage.count(), list(&stage.facts))
        };
        let stages: Vec<String> = self.stages.iter().map(stage).collect();
        let mut text = format!("Flow of the participants. {}", stages.join(" "));
        let by_order = self.by_order();
        if !by_order.is_empty() {
            let titles: Vec<String> = self.stages.iter().map(|stage| stage.title.to_lowercase()).collect();
            let orders: Vec<String> = by_order
                .iter()
                .map(|(order, counts)| {
                    let counts: Vec<String> = counts.iter().map(usize::to_string).collect();
                    format!("{order}: {}", counts.join(", "))
                })
                .collect();
            text += &format!(" By order of conditions ({}): {}.", joined_with_and(&titles), orders.join("; "));
        }
        text
    }
}

/// Longest list of conditions that names an order, in letters; a longer one is named by its number and its first condition.
const MOST_LETTERS: usize = 60;

/// Names an order by its conditions, joined by commas in the table of participants.
fn order_text(number: usize, order: &str) -> String {
    match order.split(',').next() {
        None | Some("") => "not recorded".into(),
        Some(first) if order.len() > MOST_LETTERS => format!("order {number}, which begins with {first}"),
        Some(_) => order.replace(',', ", "),
    }
}

impl FlowStage<'_> {
    /// Returns the number of participants of the stage.
    fn count(&self) -> usize {
        self.ids.len() + self.erased
    }
}

/// Returns the first stage, and the participants who were allocated to an order and took part.
fn begun<'a>(people: &'a StudyParticipants, trials: &[&str]) -> (FlowStage<'a>, BTreeSet<&'a str>) {
    let mut reasons = Reasons::new();
    add(&mut reasons, "data erased", people.erased);
    let stays = |person: &&StudyParticipant| match person.state.as_str() {
        "declined" | "not_eligible" => false,
        "open" => trials.contains(&person.id.as_str()),
        _ => true,
    };
    for person in people.all.iter().filter(|person| !stays(person)) {
        add(&mut reasons, &state(person), 1);
    }
    let ids: BTreeSet<&str> = people.all.iter().filter(stays).map(|person| person.id.as_str()).collect();
    let stage = FlowStage {
        title: "Sessions begun",
        ids: people.all.iter().map(|person| person.id.as_str()).collect(),
        erased: people.erased,
        facts: Reasons::new(),
        leave: Some(("Without data to use", people.all.len() - ids.len() + people.erased, reasons)),
    };
    (stage, ids)
}

/// Returns the stage of those who took part, and the participants among them who are excluded or damaged.
fn taken<'a>(people: &'a StudyParticipants, ids: &BTreeSet<&'a str>) -> (FlowStage<'a>, BTreeSet<&'a str>) {
    let mut reasons = Reasons::new();
    let excluded: Vec<&StudyParticipant> =
        people.all.iter().filter(|person| ids.contains(person.id.as_str()) && person.is_excluded()).collect();
    for person in &excluded {
        add(&mut reasons, person.ends.excluded.as_deref().unwrap_or("no reason is recorded"), 1);
    }
    let is_damaged = excluded.iter().any(|person| person.state == DAMAGED);
    let title = if is_damaged { "Excluded by the experimenter, or damaged" } else { "Excluded by the experimenter" };
    let stage = FlowStage {
        title: "Took part",
        ids: ids.clone(),
        erased: 0,
        facts: Reasons::new(),
        leave: Some((title, excluded.len(), reasons)),
    };
    (stage, excluded.into_iter().map(|person| person.id.as_str()).collect())
}

/// Returns the stage of those who were not excluded, and those among them who have a trial to analyse.
fn kept<'a>(
    people: &'a StudyParticipants,
    ids: &BTreeSet<&'a str>,
    trials: &[&str],
) -> (FlowStage<'a>, BTreeSet<&'a str>) {
    let (mut facts, mut reasons) = (Reasons::new(), Reasons::new());
    for person in people.all.iter().filter(|person| ids.contains(person.id.as_str())) {
        add(&mut facts, &state(person), 1);
        if !trials.contains(&person.id.as_str()) {
            add(&mut reasons, &state(person), 1);
        }
    }
    let analysed: BTreeSet<&str> = ids.iter().copied().filter(|id| trials.contains(id)).collect();
    let stage = FlowStage {
        title: "Not excluded",
        ids: ids.clone(),
        erased: 0,
        facts,
        leave: Some(("Without a completed trial", ids.len() - analysed.len(), reasons)),
    };
    (stage, analysed)
}

/// Returns the stage of the analysed participants, with those whom a rule of the plan leaves out of the models.
fn of_drives<'a>(ids: BTreeSet<&'a str>, trials: &[&str], planned: Option<&PlannedAnalysis>) -> FlowStage<'a> {
    let trials = trials.iter().filter(|id| ids.contains(*id)).count();
    let leave = planned.map(|planned| {
        let kept: BTreeSet<&str> = planned.kept.iter().map(String::as_str).collect();
        let mut reasons = Reasons::new();
        let left: BTreeSet<&str> = ids.difference(&kept).copied().collect();
        for id in &left {
            let whole = planned.left_out.iter().find(|one| one.participant == *id && one.segment.is_empty());
            add(&mut reasons, whole.map_or("each trial was left out", |one| one.rule), 1);
        }
        let singles: Vec<&str> =
            planned.left_out.iter().filter(|one| !one.segment.is_empty()).map(|one| one.rule).collect();
        let with_them = trials.saturating_sub(planned.kept.len() + singles.len());
        add(&mut reasons, "trials left out with participants", with_them);
        for rule in singles {
            add(&mut reasons, &format!("trials left out one by one, {rule}"), 1);
        }
        ("Left out by rules of the plan", left.len(), reasons)
    });
    FlowStage { title: "Analysed", ids, erased: 0, facts: vec![("trials".into(), trials)], leave }
}

/// Returns the stage of the planned models.
fn in_models(planned: &PlannedAnalysis) -> FlowStage<'_> {
    FlowStage {
        title: "In the planned models",
        ids: planned.kept.iter().map(String::as_str).collect(),
        erased: 0,
        facts: vec![("trials".into(), planned.kept.len())],
        leave: None,
    }
}

#[cfg(test)]
#[path = "participant_flow_tests.rs"]
mod tests;
