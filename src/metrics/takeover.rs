//! Measures of takeovers from the automation. In: changes of the automation, and the distances of each tick, in order. Out: [`TakeoverScores`]. They
//! are a pure function of these, so that a drive, its replay and its analysis have the same numbers. Seconds, metres.

use crate::time::Tick;
use serde::Serialize;

/// Time after a takeover in which its quality is measured, s.
pub const AFTER_TAKEOVER_S: f64 = 10.0;

/// Shortest glance, s: a shorter stay of the gaze is a pass of the eyes over it (docs/references.md: automation).
const GLANCE_S: f64 = 0.12;
/// Longest time without a sample within a glance, s: a blink.
const BLINK_S: f64 = 0.3;

/// Gaze of the participant at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GazeSample {
    /// Time since the start of the drive, s.
    pub time_s: f64,
    /// True for a gaze at the picture of the road.
    pub is_on_road: bool,
}

/// Returns the mean time from a takeover request to the begin of the first glance at the road, s: 0 where the eyes are there already. `None` without a
/// request that is followed by a glance before the next one. The samples are sorted by their times.
pub fn eyes_on_road_s(changes: &[(Tick, AutomationChange)], gaze: &[GazeSample]) -> Option<f64> {
    let requests = changes.iter().filter(|(_, change)| matches!(change, AutomationChange::Request { .. }));
    let requests_s: Vec<f64> = requests.map(|(tick, _)| tick.seconds()).collect();
    let ends_s = requests_s.iter().skip(1).copied().chain([f64::INFINITY]);
    let times_s: Vec<f64> = requests_s
        .iter()
        .zip(ends_s)
        .filter_map(|(request_s, end_s)| {
            let begin_s = glances_s(gaze).into_iter().find(|[_, to_s]| to_s >= request_s)?[0];
            (begin_s < end_s).then(|| (begin_s - request_s).max(0.0))
        })
        .collect();
    (!times_s.is_empty()).then(|| times_s.iter().sum::<f64>() / times_s.len() as f64)
}

/// Returns the begins and ends of all glances at the road, s.
fn glances_s(gaze: &[GazeSample]) -> Vec<[f64; 2]> {
    let mut glances: Vec<[f64; 2]> = Vec::new();
    let mut is_open = false;
    for sample in gaze {
        match glances.last_mut().filter(|glance| is_open && sample.time_s - glance[1] <= BLINK_S) {
            Some(glance) if sample.is_on_road => glance[1] = sample.time_s,
            _ if sample.is_on_road => glances.push([sample.time_s; 2]),
            _ => {}
        }
        is_open = sample.is_on_road;
    }
    glances.retain(|[from_s, to_s]| to_s - from_s >= GLANCE_S);
    glances
}

/// Change of the automation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AutomationChange {
    /// The system is switched on.
    On(SwitchedOnBy),
    /// The system is off.
    Off(SwitchedOffBy),
    /// The system asks the participant to take over within the lead time, s.
    Request { lead_s: f64 },
    /// The participant moves a control for the first time since the request.
    Input(TakeoverInput),
    /// The participant sets the time gap to the vehicle ahead, s.
    TimeGap { time_gap_s: f64 },
    /// The system begins to stop in the lane.
    MinimalRisk,
}

/// Cause of an automation that is switched on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SwitchedOnBy {
    Start,
    Button,
    Event,
}

/// Cause of an automation that is off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SwitchedOffBy {
    Button,
    Brake,
    Accelerator,
    /// Turn of the steering wheel by the participant, or torque of their hands.
    Wheel,
    Event,
    /// Failure of the system, which cannot be switched on again.
    Failure,
    /// Lead time of a takeover request that ended without a takeover, in systems below level 3.
    NoTakeover,
}

/// Control that the participant moves after a takeover request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TakeoverInput {
    Button,
    Brake,
    Accelerator,
    /// Turn of the steering wheel.
    Wheel,
    /// Torque of the hands on the steering wheel.
    Hands,
}

/// Words of the table of events for each change: kind and detail.
const WORDS: [(AutomationChange, [&str; 2]); 18] = [
    (AutomationChange::On(SwitchedOnBy::Start), ["automation_on", "start"]),
    (AutomationChange::On(SwitchedOnBy::Button), ["automation_on", "button"]),
    (AutomationChange::On(SwitchedOnBy::Event), ["automation_on", "event"]),
    (AutomationChange::Off(SwitchedOffBy::Button), ["automation_off", "button"]),
    (AutomationChange::Off(SwitchedOffBy::Brake), ["automation_off", "brake"]),
    (AutomationChange::Off(SwitchedOffBy::Accelerator), ["automation_off", "accelerator"]),
    (AutomationChange::Off(SwitchedOffBy::Wheel), ["automation_off", "wheel"]),
    (AutomationChange::Off(SwitchedOffBy::Event), ["automation_off", "event"]),
    (AutomationChange::Off(SwitchedOffBy::Failure), ["automation_off", "failure"]),
    (AutomationChange::Off(SwitchedOffBy::NoTakeover), ["automation_off", "no takeover"]),
    (AutomationChange::Input(TakeoverInput::Button), ["takeover_input", "button"]),
    (AutomationChange::Input(TakeoverInput::Brake), ["takeover_input", "brake"]),
    (AutomationChange::Input(TakeoverInput::Accelerator), ["takeover_input", "accelerator"]),
    (AutomationChange::Input(TakeoverInput::Wheel), ["takeover_input", "wheel"]),
    (AutomationChange::Input(TakeoverInput::Hands), ["takeover_input", "hands"]),
    (AutomationChange::MinimalRisk, ["minimal_risk_manoeuvre", ""]),
    (AutomationChange::Request { lead_s: 0.0 }, ["takeover_request", ""]),
    (AutomationChange::TimeGap { time_gap_s: 0.0 }, ["automation_gap", ""]),
];

impl AutomationChange {
    /// Returns the change as kind, detail and number of the table of events.
    pub fn words(self) -> (&'static str, &'static str, Option<f64>) {
        let (same, value) = match self {
            Self::Request { lead_s } => (Self::Request { lead_s: 0.0 }, Some(lead_s)),
            Self::TimeGap { time_gap_s } => (Self::TimeGap { time_gap_s: 0.0 }, Some(time_gap_s)),
            other => (other, None),
        };
        let [kind, detail] = WORDS.iter().find(|(change, _)| *change == same).map_or([""; 2], |(_, words)| *words);
        (kind, detail, value)
    }

    /// Returns the change of a row of the table of events; `None` if the row is of another kind.
    pub fn of_words(kind: &str, detail: &str, value: Option<f64>) -> Option<Self> {
        let (change, _) = WORDS.iter().find(|(_, words)| *words == [kind, detail])?;
        match change {
            Self::Request { .. } => Some(Self::Request { lead_s: value? }),
            Self::TimeGap { .. } => Some(Self::TimeGap { time_gap_s: value? }),
            change => Some(*change),
        }
    }
}

impl SwitchedOffBy {
    /// Returns true if the participant switched the system off.
    fn is_participant(self) -> bool {
        matches!(self, Self::Button | Self::Brake | Self::Accelerator | Self::Wheel)
    }
}

/// Scores of the takeovers of a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TakeoverScores {
    /// Number of takeover requests.
    pub takeover_requests: u32,
    /// Number of requests after which the participant took over.
    pub takeovers: u32,
    /// Mean time from the request to the takeover, s.
    pub takeover_time_s: Option<f64>,
    /// Mean time from the request to the first moved control, s.
    pub takeover_first_input_s: Option<f64>,
    /// Mean time from the request to the first turn of the steering wheel or torque of the hands on it, s.
    pub takeover_hands_on_s: Option<f64>,
    /// Smallest time to collision in the time after a takeover, s.
    pub takeover_min_ttc_s: Option<f64>,
    /// Largest offset from the lane's centre line in the time after a takeover, m.
    pub takeover_lane_deviation_m: Option<f64>,
    /// Number of minimal-risk manoeuvres.
    pub minimal_risk_manoeuvres: u32,
}

/// Log of the takeovers of a drive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TakeoverLog {
    /// Request without a takeover, and the inputs since: any, and of the wheel.
    request: Option<Tick>,
    has_input: bool,
    has_hands_on: bool,
    times_s: Times,
    /// End of the time after the last takeover.
    watched_until: Tick,
    scores: TakeoverScores,
}

/// Times from requests, s.
#[derive(Clone, Debug, Default, PartialEq)]
struct Times {
    takeovers: Vec<f64>,
    first_inputs: Vec<f64>,
    hands_on: Vec<f64>,
}

impl TakeoverLog {
    /// Adds a change of the automation, and the times that end with it.
    pub fn add(&mut self, tick: Tick, change: AutomationChange) {
        if change == AutomationChange::MinimalRisk {
            self.scores.minimal_risk_manoeuvres += 1;
        }
        if let AutomationChange::Request { .. } = change {
            self.scores.takeover_requests += 1;
            (self.request, self.has_input, self.has_hands_on) = (Some(tick), false, false);
        }
        let Some(request) = self.request else { return };
        let since_s = tick.seconds() - request.seconds();
        match change {
            AutomationChange::Input(input) => {
                if !std::mem::replace(&mut self.has_input, true) {
                    self.times_s.first_inputs.push(since_s);
                }
                let is_hands_on = matches!(input, TakeoverInput::Wheel | TakeoverInput::Hands);
                if is_hands_on && !std::mem::replace(&mut self.has_hands_on, true) {
                    self.times_s.hands_on.push(since_s);
                }
            }
            AutomationChange::Off(by) => {
                self.request = None;
                if by.is_participant() {
                    self.scores.takeovers += 1;
                    self.times_s.takeovers.push(since_s);
                    self.watched_until = Tick::at_seconds(tick.seconds() + AFTER_TAKEOVER_S);
                }
            }
            _ => {}
        }
    }

    /// Adds the time to collision, s, and the offset from the lane's centre line, m, of a tick, after its changes.
    pub fn watch(&mut self, tick: Tick, ttc_s: Option<f64>, lane_offset_m: f64) {
        if tick >= self.watched_until {
            return;
        }
        let scores = &mut self.scores;
        scores.takeover_min_ttc_s = [scores.takeover_min_ttc_s, ttc_s].into_iter().flatten().reduce(f64::min);
        let deviation_m = scores.takeover_lane_deviation_m.unwrap_or(0.0).max(lane_offset_m.abs());
        scores.takeover_lane_deviation_m = Some(deviation_m);
    }

    /// Returns the scores; `None` without a takeover request.
    pub fn scores(&self) -> Option<TakeoverScores> {
        let mean = |times_s: &[f64]| (!times_s.is_empty()).then(|| times_s.iter().sum::<f64>() / times_s.len() as f64);
        (self.scores.takeover_requests > 0).then(|| TakeoverScores {
            takeover_time_s: mean(&self.times_s.takeovers),
            takeover_first_input_s: mean(&self.times_s.first_inputs),
            takeover_hands_on_s: mean(&self.times_s.hands_on),
            ..self.scores
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_change_reads_back_from_its_words() {
        let gap = AutomationChange::TimeGap { time_gap_s: 1.5 };
        assert_eq!(gap.words(), ("automation_gap", "", Some(1.5)));
        for change in WORDS.map(|(change, _)| change).into_iter().chain([gap]) {
            let (kind, detail, value) = change.words();
            assert_eq!(AutomationChange::of_words(kind, detail, value), Some(change), "{kind} {detail}");
        }
        let request = AutomationChange::Request { lead_s: 7.0 };
        assert_eq!(request.words(), ("takeover_request", "", Some(7.0)));
        assert_eq!(AutomationChange::of_words("takeover_request", "", Some(7.0)), Some(request));
        assert_eq!(AutomationChange::of_words("takeover_request", "", None), None);
        assert_eq!(AutomationChange::of_words("mark", "", None), None);
    }

    #[test]
    fn times_count_from_the_request_and_quality_from_the_takeover() {
        use AutomationChange as Change;
        let at = Tick::at_seconds;
        let mut log = TakeoverLog::default();
        let distances = |time_s: f64| match time_s {
            // Before the takeover, in the ten seconds after it, and later.
            t if t < 13.0 => (Some(1.0), 2.0),
            t if t < 15.0 => (None, 0.1),
            t if t < 22.9 => (Some(6.0), -0.4),
            t if t < 23.0 => (Some(4.5), 0.2),
            _ => (Some(0.5), 3.0),
        };
        let changes = [
            (5.0, Change::Off(SwitchedOffBy::Brake)),
            (10.0, Change::Request { lead_s: 7.0 }),
            (11.5, Change::Input(TakeoverInput::Brake)),
            (12.0, Change::Input(TakeoverInput::Hands)),
            (12.5, Change::Input(TakeoverInput::Wheel)),
            (13.0, Change::Off(SwitchedOffBy::Wheel)),
            (40.0, Change::Request { lead_s: 7.0 }),
            (47.0, Change::MinimalRisk),
            (60.0, Change::Off(SwitchedOffBy::Failure)),
        ];
        for tick in 1..7000 {
            let tick = Tick(tick);
            for (_, change) in changes.iter().filter(|(time_s, _)| at(*time_s) == tick) {
                log.add(tick, *change);
            }
            let (ttc_s, offset_m) = distances(tick.seconds());
            log.watch(tick, ttc_s, offset_m);
        }
        let expected = TakeoverScores {
            takeover_requests: 2,
            takeovers: 1,
            takeover_time_s: Some(3.0),
            takeover_first_input_s: Some(1.5),
            takeover_hands_on_s: Some(2.0),
            takeover_min_ttc_s: Some(4.5),
            takeover_lane_deviation_m: Some(0.4),
            minimal_risk_manoeuvres: 1,
        };
        assert_eq!(log.scores(), Some(expected));
        assert_eq!(TakeoverLog::default().scores(), None);
    }

    #[test]
    fn eyes_are_on_the_road_at_the_first_glance_after_a_request() {
        let request = |at_s: f64| (Tick::at_seconds(at_s), AutomationChange::Request { lead_s: 7.0 });
        // 50 samples a second: on the road up to 1 s, for 0.06 s at 5 s, from 6.5 to 8 s with a blink of 0.2 s, and from 22 s on.
        let is_on = |t: f64| t < 1.0 || (5.0..5.07).contains(&t) || (6.495..8.0).contains(&t) || t >= 21.995;
        let samples = (0..1500).map(|k| f64::from(k) / 50.0).filter(|t| !(6.9..7.1).contains(t));
        let gaze: Vec<GazeSample> = samples.map(|time_s| GazeSample { time_s, is_on_road: is_on(time_s) }).collect();
        let mean_s = |requests: &[f64]| {
            let changes: Vec<_> = requests.iter().map(|at_s| request(*at_s)).collect();
            eyes_on_road_s(&changes, &gaze)
        };
        let near = |found: Option<f64>, wanted_s: f64| (found.expect("a glance") - wanted_s).abs() < 1e-9;
        assert!(near(mean_s(&[4.0]), 2.5), "{:?}", mean_s(&[4.0]));
        assert!(near(mean_s(&[7.5]), 0.0), "the eyes are on the road");
        assert!(near(mean_s(&[4.0, 20.0]), (2.5 + 2.0) / 2.0), "{:?}", mean_s(&[4.0, 20.0]));
        assert!(near(mean_s(&[9.0, 20.0]), 2.0), "no glance follows the first request before the second one");
        assert_eq!((mean_s(&[]), mean_s(&[40.0])), (None, None));
        assert_eq!(eyes_on_road_s(&[request(1.0)], &[]), None);
    }
}
