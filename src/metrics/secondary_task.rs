//! Scores of secondary tasks. In: times of stimuli, responses and openings of the shutter, in order. Out: a [`TaskScores`]. Each score is a pure
//! function of these lists, so that a drive, its replay and its analysis have the same numbers. Seconds since the start of the drive.

use super::questions::{QuestionChange, QuestionScore};
use crate::time::Tick;
use serde::Serialize;

/// Earliest response that can be caused by a signal, s (docs/references.md: secondary-tasks).
pub const FIRST_HIT_S: f64 = 0.1;
/// Latest response that counts as a hit, s (docs/references.md: secondary-tasks).
pub const LAST_HIT_S: f64 = 2.5;

/// Stimulus of a secondary task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskStimulus {
    /// Signal of the detection response task.
    Signal,
    /// Digit of the n-back task.
    Digit {
        digit: u8,
        /// True if the button is to be pressed; `None` if the digit asks for no button.
        is_match: Option<bool>,
    },
    /// Display of the surrogate reference task; its target is in this column, counted from 1 on the left.
    Display { target_column: u8 },
}

/// Response to a secondary task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TaskResponse {
    /// Press of the response button.
    Button,
    /// Confirmed column of the surrogate reference task, counted from 1 on the left.
    Column(u8),
}

impl TaskStimulus {
    /// Returns the stimulus as the words and the number of the table of events.
    pub fn words(self) -> (&'static str, Option<f64>) {
        match self {
            Self::Signal => ("signal", None),
            Self::Digit { digit, is_match: Some(true) } => ("match", Some(digit.into())),
            Self::Digit { digit, is_match: Some(false) } => ("no match", Some(digit.into())),
            Self::Digit { digit, is_match: None } => ("digit", Some(digit.into())),
            Self::Display { target_column } => ("display", Some(target_column.into())),
        }
    }

    /// Returns the stimulus of a row of the table of events; `None` if this program does not write such a row.
    pub fn of_words(detail: &str, value: Option<f64>) -> Option<Self> {
        let number = || value.map(|number| number as u8);
        let digit = |is_match| Some(Self::Digit { digit: number()?, is_match });
        match detail {
            "signal" => Some(Self::Signal),
            "match" => digit(Some(true)),
            "no match" => digit(Some(false)),
            "digit" => digit(None),
            "display" => Some(Self::Display { target_column: number()? }),
            _ => None,
        }
    }
}

impl TaskResponse {
    /// Returns the response as the words and the number of the table of events.
    pub fn words(self) -> (&'static str, Option<f64>) {
        match self {
            Self::Button => ("button", None),
            Self::Column(column) => ("column", Some(column.into())),
        }
    }

    /// Returns the response of a row of the table of events; `None` if this program does not write such a row.
    pub fn of_words(detail: &str, value: Option<f64>) -> Option<Self> {
        match (detail, value) {
            ("button", _) => Some(Self::Button),
            ("column", Some(column)) => Some(Self::Column(column as u8)),
            _ => None,
        }
    }
}

/// Stimuli, responses, shutter and questions of a drive, in order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TaskLog {
    /// Stimuli, each with the tick from which it is seen.
    pub stimuli: Vec<(Tick, TaskStimulus)>,
    /// Responses, each with its tick.
    pub responses: Vec<(Tick, TaskResponse)>,
    /// Movements of the shutter, each with its tick; true is open.
    pub shutter: Vec<(Tick, bool)>,
    /// Changes of questions to the participant, each with its tick; that of a question is the first that shows it.
    pub questions: Vec<(Tick, QuestionChange)>,
    /// Places in `stimuli` of those that are not scored, because the participant neither heard nor saw them or what they are compared with.
    pub unscored: Vec<usize>,
}

impl TaskLog {
    /// Leaves the stimulus with this onset out of the scores.
    pub fn leave_unscored(&mut self, onset: Tick) {
        self.unscored.extend(self.stimuli.iter().rposition(|(tick, _)| *tick == onset));
    }

    /// Returns the scores of a drive that ends at `end_s`.
    pub fn scores(&self, end_s: f64) -> TaskScores {
        let (mut signals, mut digits, mut displays) = (Vec::new(), Vec::new(), Vec::new());
        let mut scored_digits = 0;
        for (place, (tick, stimulus)) in self.stimuli.iter().enumerate() {
            match *stimulus {
                TaskStimulus::Signal => signals.push(tick.seconds()),
                TaskStimulus::Digit { is_match, .. } => {
                    let is_scored = !self.unscored.contains(&place);
                    scored_digits += u32::from(is_scored);
                    digits.push((tick.seconds(), is_match.filter(|_| is_scored)));
                }
                TaskStimulus::Display { target_column } => displays.push((tick.seconds(), target_column)),
            }
        }
        let (mut presses, mut columns) = (Vec::new(), Vec::new());
        for (tick, response) in &self.responses {
            match *response {
                TaskResponse::Button => presses.push(tick.seconds()),
                TaskResponse::Column(column) => columns.push((tick.seconds(), column)),
            }
        }
        let shutter: Vec<(f64, bool)> = self.shutter.iter().map(|(tick, open)| (tick.seconds(), *open)).collect();
        TaskScores {
            detection: (!signals.is_empty()).then(|| DetectionScore::of(&signals, &presses, end_s)),
            n_back: (scored_digits > 0)
                .then(|| NBackScore { n_back_digits: scored_digits, ..NBackScore::of(&digits, &presses, end_s) }),
            search: (!displays.is_empty()).then(|| SearchScore::of(&displays, &columns)),
            occlusion: (!shutter.is_empty()).then(|| OcclusionScore::of(&shutter, end_s)),
            questions: (!self.questions.is_empty()).then(|| QuestionScore::of(&self.questions)),
        }
    }
}

/// Scores of the secondary task of a drive, and of its questions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct TaskScores {
    /// Detection response task; `None` if no signal was shown.
    #[serde(flatten)]
    pub detection: Option<DetectionScore>,
    /// n-back task; `None` if no digit was presented.
    #[serde(flatten)]
    pub n_back: Option<NBackScore>,
    /// Surrogate reference task; `None` if no display was shown.
    #[serde(flatten)]
    pub search: Option<SearchScore>,
    /// Occlusion; `None` if the shutter did not move.
    #[serde(flatten)]
    pub occlusion: Option<OcclusionScore>,
    /// Questions of events; `None` if none was asked.
    #[serde(flatten)]
    pub questions: Option<QuestionScore>,
}

/// Score of a detection response task (docs/references.md: secondary-tasks).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct DetectionScore {
    /// Number of signals that had their whole time for a response, or a hit before the drive's end.
    pub detection_signals: u32,
    /// Number of those without a hit.
    pub detection_misses: u32,
    /// Share of those with a hit, 0..1; `None` without signals.
    pub detection_hit_rate: Option<f64>,
    /// Mean response time of the hits, s; `None` without hits.
    pub detection_response_s: Option<f64>,
    /// Number of responses that are no hit: too early, too late, or repeated.
    pub detection_false_responses: u32,
}

impl DetectionScore {
    /// Returns the score of signals and button presses at these times in a drive that ends at `end_s`.
    pub fn of(signals_s: &[f64], presses_s: &[f64], end_s: f64) -> Self {
        let mut sum_s = 0.0;
        let (mut signals, mut hits) = (0, 0);
        for signal_s in signals_s {
            let is_hit = |press_s: &f64| is_within(press_s - signal_s, FIRST_HIT_S, LAST_HIT_S);
            if let Some(press_s) = presses_s.iter().find(|press_s| is_hit(press_s)) {
                sum_s += press_s - signal_s;
                hits += 1;
                signals += 1;
            } else if is_within(end_s - signal_s, LAST_HIT_S, f64::INFINITY) {
                signals += 1;
            }
        }
        Self {
            detection_signals: signals,
            detection_misses: signals - hits,
            detection_hit_rate: share(hits, signals),
            detection_response_s: (hits > 0).then(|| sum_s / f64::from(hits)),
            detection_false_responses: presses_s.len() as u32 - hits,
        }
    }
}

/// Score of an n-back task with a button.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct NBackScore {
    /// Number of digits that were heard or shown, without those compared with one that was not.
    pub n_back_digits: u32,
    /// Share of the digits with a right decision, 0..1: pressed at a match and not pressed at others; `None` without such digits.
    pub n_back_accuracy: Option<f64>,
    /// Share of the matches with a press, 0..1; `None` without matches.
    pub n_back_hit_rate: Option<f64>,
    /// Number of other digits with a press.
    pub n_back_false_alarms: u32,
}

impl NBackScore {
    /// Returns the score of digits and button presses at these times in a drive that ends at `end_s`. A digit owns the presses from its onset to
    /// that of the next one; the last digit of a drive only counts if it has a press.
    pub fn of(digits: &[(f64, Option<bool>)], presses_s: &[f64], end_s: f64) -> Self {
        let (mut matches, mut hits, mut others, mut false_alarms) = (0, 0, 0, 0);
        for (i, (from_s, is_match)) in digits.iter().enumerate() {
            let to_s = digits.get(i + 1).map_or(end_s, |next| next.0);
            let is_pressed = presses_s.iter().any(|press_s| (*from_s..to_s).contains(press_s));
            let is_whole = is_pressed || i + 1 < digits.len();
            match is_match.filter(|_| is_whole) {
                Some(true) => (matches, hits) = (matches + 1, hits + u32::from(is_pressed)),
                Some(false) => (others, false_alarms) = (others + 1, false_alarms + u32::from(is_pressed)),
                None => {}
            }
        }
        Self {
            n_back_digits: digits.len() as u32,
            n_back_accuracy: share(hits + others - false_alarms, matches + others),
            n_back_hit_rate: share(hits, matches),
            n_back_false_alarms: false_alarms,
        }
    }
}

/// Score of a surrogate reference task.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SearchScore {
    /// Number of displays with a confirmed column.
    pub search_displays: u32,
    /// Share of those whose target was in the confirmed column, 0..1; `None` without such displays.
    pub search_correct: Option<f64>,
    /// Mean time from a display to its confirmation, s; `None` without such displays.
    pub search_response_s: Option<f64>,
}

impl SearchScore {
    /// Returns the score of displays with the column of their target, and of confirmed columns. Each confirmation ends a display.
    pub fn of(displays: &[(f64, u8)], confirmed: &[(f64, u8)]) -> Self {
        let done: Vec<_> = displays.iter().zip(confirmed).collect();
        let count = done.len() as u32;
        let correct = done.iter().filter(|(display, answer)| display.1 == answer.1).count() as u32;
        let sum_s: f64 = done.iter().map(|(display, answer)| answer.0 - display.0).sum();
        Self {
            search_displays: count,
            search_correct: share(correct, count),
            search_response_s: (count > 0).then(|| sum_s / f64::from(count)),
        }
    }
}

/// Score of an occlusion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct OcclusionScore {
    /// Number of times the shutter opened.
    pub shutter_openings: u32,
    /// Total shutter open time, s.
    pub shutter_open_s: f64,
}

impl OcclusionScore {
    /// Returns the score of a shutter that moves at these times, true for open, in a drive that ends at `end_s`.
    pub fn of(movements: &[(f64, bool)], end_s: f64) -> Self {
        let until = |i: usize| movements.get(i + 1).map_or(end_s, |next| next.0);
        let open_s =
            movements.iter().enumerate().filter(|(_, movement)| movement.1).map(|(i, (at_s, _))| until(i) - at_s);
        Self {
            shutter_openings: movements.iter().filter(|movement| movement.1).count() as u32,
            shutter_open_s: open_s.sum(),
        }
    }
}

/// Returns true if a difference of two ticks' times is within limits, both included, apart from rounding.
fn is_within(seconds: f64, low_s: f64, high_s: f64) -> bool {
    const ROUNDING_S: f64 = 1e-6;
    (low_s - ROUNDING_S..=high_s + ROUNDING_S).contains(&seconds)
}

/// Returns a share; `None` of nothing.
pub(super) fn share(part: u32, of: u32) -> Option<f64> {
    (of > 0).then(|| f64::from(part) / f64::from(of))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn responses_from_100_to_2500_ms_are_hits_and_all_others_false() {
        // 1: 0.45 s. 2: 0.09 s too early, no other. 3: 0.05 s too early, then 0.75 s. 4: none, 2.51 s too late. 5: at 0.1 s, and once more.
        // 6: at 2.5 s. The seventh has only 1 s before the end of the drive.
        let signals_s = [4.0, 8.0, 12.0, 16.0, 20.0, 24.0, 28.0];
        let presses_s = [4.45, 8.09, 12.05, 12.75, 18.51, 20.1, 20.6, 26.5];
        let score = DetectionScore::of(&signals_s, &presses_s, 29.0);
        assert_eq!((score.detection_signals, score.detection_misses, score.detection_false_responses), (6, 2, 4));
        assert_eq!(score.detection_hit_rate, Some(4.0 / 6.0));
        // (0.45 + 0.75 + 0.1 + 2.5) / 4
        assert!((score.detection_response_s.unwrap() - 0.95).abs() < 1e-9);
        let late = DetectionScore::of(&signals_s, &presses_s, 30.5);
        assert_eq!((late.detection_signals, late.detection_misses), (7, 3), "the last one had 2.5 s");
        let none = DetectionScore::of(&[28.0], &[], 29.0);
        assert_eq!((none.detection_signals, none.detection_hit_rate, none.detection_response_s), (0, None, None));
    }

    #[test]
    fn a_right_decision_is_a_press_at_a_match_and_none_elsewhere() {
        // 1-back of 3 3 7 7 2 4: the second and the fourth match. Pressed at the second, missed at the fourth, pressed wrongly at the fifth.
        let matches = [None, Some(true), Some(false), Some(true), Some(false), Some(false)];
        let digits: Vec<(f64, Option<bool>)> =
            matches.into_iter().enumerate().map(|(i, is_match)| (2.25 * i as f64, is_match)).collect();
        let score = NBackScore::of(&digits, &[2.25 + 0.8, 9.0 + 2.24], 12.0);
        // The last digit is cut by the end: four decisions, of which the first and the third digit's are right.
        assert_eq!((score.n_back_digits, score.n_back_accuracy), (6, Some(2.0 / 4.0)));
        assert_eq!((score.n_back_hit_rate, score.n_back_false_alarms), (Some(0.5), 1));
        let spoken = NBackScore::of(&[(0.0, None), (2.25, None)], &[], 9.0);
        assert_eq!((spoken.n_back_digits, spoken.n_back_accuracy, spoken.n_back_hit_rate), (2, None, None));
    }

    #[test]
    fn a_display_is_done_once_a_column_is_confirmed() {
        let displays = [(1.0, 2), (4.0, 5), (6.5, 1), (9.5, 3)];
        let score = SearchScore::of(&displays, &[(4.0, 2), (6.5, 4), (9.5, 1)]);
        assert_eq!((score.search_displays, score.search_correct), (3, Some(2.0 / 3.0)));
        // (3 + 2.5 + 3) / 3
        assert!((score.search_response_s.unwrap() - 8.5 / 3.0).abs() < 1e-9);
        assert_eq!(SearchScore::of(&displays, &[]).search_correct, None);
    }

    #[test]
    fn the_shutter_is_open_until_it_closes_or_the_drive_ends() {
        let score = OcclusionScore::of(&[(0.0, true), (1.5, false), (3.0, true), (4.5, false), (6.0, true)], 7.0);
        assert_eq!((score.shutter_openings, score.shutter_open_s), (3, 4.0));
        let closed = OcclusionScore::of(&[(0.0, false)], 9.0);
        assert_eq!((closed.shutter_openings, closed.shutter_open_s), (0, 0.0));
    }

    #[test]
    fn stimuli_and_responses_are_read_as_they_are_written() {
        let digits = [None, Some(true), Some(false)].map(|is_match| TaskStimulus::Digit { digit: 7, is_match });
        for stimulus in digits.into_iter().chain([TaskStimulus::Signal, TaskStimulus::Display { target_column: 3 }]) {
            let (detail, value) = stimulus.words();
            assert_eq!(TaskStimulus::of_words(detail, value), Some(stimulus));
        }
        for response in [TaskResponse::Button, TaskResponse::Column(4)] {
            let (detail, value) = response.words();
            assert_eq!(TaskResponse::of_words(detail, value), Some(response));
        }
        assert_eq!((TaskStimulus::of_words("match", None), TaskResponse::of_words("knee", None)), (None, None));
    }

    #[test]
    fn digits_that_were_not_presented_have_no_score() {
        let at = Tick::at_seconds;
        let digit = |is_match| TaskStimulus::Digit { digit: 3, is_match };
        let stimuli = [None, Some(true), Some(false), Some(true), Some(false)];
        let mut log = TaskLog {
            stimuli: stimuli.iter().enumerate().map(|(k, is_match)| (at(k as f64), digit(*is_match))).collect(),
            // At the second digit, which matches, and at the third, which does not.
            responses: vec![(at(1.5), TaskResponse::Button), (at(2.5), TaskResponse::Button)],
            ..TaskLog::default()
        };
        let score =
            |log: &TaskLog| log.scores(9.0).n_back.map(|n| (n.n_back_digits, n.n_back_accuracy, n.n_back_false_alarms));
        // Hit, false alarm, miss; the last digit has no end.
        assert_eq!(score(&log), Some((5, Some(1.0 / 3.0), 1)));
        // The press at the third does not count, and not for the second.
        log.leave_unscored(at(2.0));
        log.leave_unscored(at(3.0));
        assert_eq!(score(&log), Some((3, Some(1.0), 0)));
        log.leave_unscored(at(2.5));
        assert_eq!(score(&log), Some((3, Some(1.0), 0)), "no stimulus has this onset");
        [0.0, 1.0, 4.0].into_iter().for_each(|s| log.leave_unscored(at(s)));
        assert_eq!(score(&log), None, "no digit was presented");
    }

    #[test]
    fn a_log_is_scored_by_the_kind_of_its_stimuli() {
        let at = Tick::at_seconds;
        let log = TaskLog {
            stimuli: vec![(at(1.0), TaskStimulus::Signal)],
            responses: vec![(at(1.5), TaskResponse::Button)],
            ..TaskLog::default()
        };
        let scores = log.scores(9.0);
        assert_eq!(scores.detection.unwrap().detection_response_s, Some(0.5));
        assert_eq!((scores.n_back, scores.search, scores.occlusion, scores.questions), (None, None, None, None));
        assert_eq!(TaskLog::default().scores(9.0), TaskScores::default());
    }
}
