//! Presentation of the digits of an n-back task. In: the digits of each tick, and the moments at which one is heard or on a picture that was handed
//! to the screen. Out: the digits that are not scored: a digit that was neither heard nor shown, and the digits after it that are compared with it.

use crate::{
    metrics::TaskStimulus,
    sim::{Event, EventKind},
    time::Tick,
};

/// Digit that is not scored, and the reason.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct UnscoredDigit {
    pub onset: Tick,
    pub detail: String,
}

/// Digit that is present until the next one.
#[derive(Clone, Copy, Debug)]
struct PresentDigit {
    onset: Tick,
    digit: u8,
    is_perceived: bool,
    is_scored: bool,
}

/// Digits of a drive and their presentation.
#[derive(Clone, Debug, Default)]
pub(super) struct DigitPresentation {
    /// Number of digits back with which a digit is compared.
    n: u8,
    present: Option<PresentDigit>,
    /// Number of digits still to come that are compared with one that was not presented, or whose row of digits has a gap.
    to_leave_out: u8,
    is_in_view: bool,
}

impl DigitPresentation {
    /// Begins a drive whose digits are compared with those `n` before.
    pub fn new(n: u8) -> Self {
        Self { n, ..Self::default() }
    }

    /// Applies the events of a tick. Returns the digits that are not scored.
    pub fn tick(&mut self, events: &[Event]) -> Vec<UnscoredDigit> {
        let mut unscored = Vec::new();
        for event in events {
            let EventKind::TaskStimulus(TaskStimulus::Digit { digit, is_match }) = event.kind else { continue };
            unscored.extend(self.end());
            let follows_gap = self.to_leave_out > 0;
            self.to_leave_out = self.to_leave_out.saturating_sub(1);
            // The first digits of a block are compared with none.
            let is_left_out = follows_gap && is_match.is_some();
            if is_left_out {
                let detail = format!("digit {digit}: follows a digit that was not presented");
                unscored.push(UnscoredDigit { onset: event.tick, detail });
            }
            self.present =
                Some(PresentDigit { onset: event.tick, digit, is_perceived: false, is_scored: !is_left_out });
        }
        unscored
    }

    /// Notes that the present digit is heard.
    pub fn heard(&mut self) {
        if let Some(present) = &mut self.present {
            present.is_perceived = true;
        }
    }

    /// States whether the next picture has the present digit.
    pub fn view(&mut self, has_digit: bool) {
        self.is_in_view = has_digit;
    }

    /// Notes that the picture was handed to the screen.
    pub fn shown(&mut self) {
        if std::mem::take(&mut self.is_in_view) {
            self.heard();
        }
    }

    /// Ends the present digit. Returns it if it was not presented and would be scored.
    pub fn end(&mut self) -> Option<UnscoredDigit> {
        let missed = self.present.take().filter(|present| !present.is_perceived)?;
        self.to_leave_out = self.n;
        let detail = format!("digit {}: not presented", missed.digit);
        missed.is_scored.then_some(UnscoredDigit { onset: missed.onset, detail })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the onsets, s, of the digits that are not scored, of a digit each second of which those of `perceived` are presented.
    fn unscored(n: u8, matches: &[Option<bool>], perceived: &[usize]) -> Vec<f64> {
        let mut digits = DigitPresentation::new(n);
        let mut left_out = Vec::new();
        for (k, is_match) in matches.iter().enumerate() {
            let kind = EventKind::TaskStimulus(TaskStimulus::Digit { digit: 7, is_match: *is_match });
            left_out.extend(digits.tick(&[Event { tick: Tick::at_seconds(k as f64), kind }]));
            if perceived.contains(&k) {
                digits.view(true);
                digits.shown();
            }
            // A picture without the digit presents nothing.
            digits.view(false);
            digits.shown();
        }
        left_out.extend(digits.end());
        left_out.iter().map(|digit| digit.onset.seconds()).collect()
    }

    #[test]
    fn missed_digits_and_those_compared_with_them_are_not_scored() {
        let block = [None, Some(true), Some(false), Some(false), Some(true)];
        assert_eq!(unscored(1, &block, &[0, 1, 2, 3, 4]), [0.0; 0]);
        assert_eq!(unscored(1, &block, &[]), [0.0, 1.0, 2.0, 3.0, 4.0], "each once");
        // The third is missed: the fourth is compared with it, the fifth is not.
        assert_eq!(unscored(1, &block, &[0, 1, 3, 4]), [2.0, 3.0]);
        assert_eq!(unscored(0, &block, &[0, 1, 3, 4]), [2.0], "compared with none");
        // The last digit of a block is missed: the first ones of the next are compared with none of it.
        let blocks = [None, None, Some(true), None, None, Some(true)];
        assert_eq!(unscored(2, &blocks, &[0, 1, 3, 4, 5]), [2.0]);
        assert_eq!(unscored(2, &blocks[..5], &[1, 2, 3, 4]), [0.0, 2.0]);
    }
}
