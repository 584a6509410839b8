//! Responses of a simulated driver to a secondary task. In: the [`TaskDisplay`] of each tick. Out: the pressed [`TaskButton`]. The driver steers as
//! if there were no task: neither attention nor a closed shutter changes the driving.

use crate::{
    controls::TaskButton,
    rng,
    snapshot::{TaskDisplay, TaskPicture},
    time::TICKS_PER_S,
};

/// Median, s, and standard deviation of the logarithm of a time, and the probability of an error. All are orders of magnitude from memory
/// (docs/references.md: secondary-tasks).
struct ResponseModel {
    median_s: f64,
    log_sd: f64,
    errors: f64,
}

/// Responses to the signal of the detection response task; an error is a miss.
const SIGNAL: ResponseModel = ResponseModel { median_s: 0.45, log_sd: 0.3, errors: 0.04 };
/// Decisions of the 0-, 1- and 2-back task; an error is a press at a digit without a match, or none at a match.
const DIGITS: [ResponseModel; 3] = [
    ResponseModel { median_s: 0.60, log_sd: 0.25, errors: 0.01 },
    ResponseModel { median_s: 0.75, log_sd: 0.25, errors: 0.05 },
    ResponseModel { median_s: 0.90, log_sd: 0.25, errors: 0.15 },
];
/// Search for the target of the surrogate reference task; an error is another column.
const SEARCH: ResponseModel = ResponseModel { median_s: 2.0, log_sd: 0.4, errors: 0.03 };
/// Time until a driver opens a closed shutter.
const SHUTTER: ResponseModel = ResponseModel { median_s: 1.5, log_sd: 0.4, errors: 0.0 };
/// Time from one press to the next while the cursor is moved, s.
const PRESS_S: f64 = 0.35;

/// Driver of a secondary task.
#[derive(Clone, Debug)]
pub(super) struct TaskResponder {
    random: rng::Stream,
    tick: u64,
    /// Number of the last stimulus, and true if the shutter was closed.
    seen: (u32, bool),
    /// Tick of the next press.
    due: Option<u64>,
    /// Column that the driver is going to confirm.
    goal: Option<u8>,
}

impl TaskResponder {
    pub fn new(seed: u64) -> Self {
        Self { random: rng::stream(seed, "driver/secondary task"), tick: 0, seen: (0, false), due: None, goal: None }
    }

    /// Returns the button that is pressed in this tick.
    pub fn press(&mut self, now: TaskDisplay) -> TaskButton {
        self.tick += 1;
        let seen = (now.stimulus, matches!(now.shown, TaskPicture::Closed { .. }));
        if std::mem::replace(&mut self.seen, seen) != seen {
            self.decide(now.shown);
        }
        if self.due.is_none_or(|due| self.tick < due) {
            return TaskButton::None;
        }
        self.due = None;
        let (TaskPicture::Search { cursor, .. }, Some(goal)) = (now.shown, self.goal) else {
            return TaskButton::Respond;
        };
        if cursor == goal {
            return TaskButton::Respond;
        }
        self.press_after(PRESS_S);
        if cursor < goal { TaskButton::Right } else { TaskButton::Left }
    }

    /// Decides on the response to a new picture.
    fn decide(&mut self, shown: TaskPicture) {
        match shown {
            TaskPicture::Signal => {
                let is_missed = self.errs(&SIGNAL);
                self.respond_if(!is_missed, &SIGNAL);
            }
            TaskPicture::Digit { n, is_match: Some(is_match), .. } => {
                let model = &DIGITS[usize::from(n).min(DIGITS.len() - 1)];
                let errs = self.errs(model);
                self.respond_if(is_match != errs, model);
            }
            TaskPicture::Search { columns, target_column, .. } => {
                let errs = self.errs(&SEARCH);
                self.goal = Some(if errs { (target_column + 1) % columns } else { target_column });
                self.respond_if(true, &SEARCH);
            }
            TaskPicture::Closed { opens_on_press: true } => self.respond_if(true, &SHUTTER),
            TaskPicture::Digit { is_match: None, .. } | TaskPicture::Closed { .. } | TaskPicture::None => {}
        }
    }

    fn errs(&mut self, model: &ResponseModel) -> bool {
        self.random.uniform(0.0, 1.0) < model.errors
    }

    fn respond_if(&mut self, responds: bool, model: &ResponseModel) {
        let after_s = model.median_s * (model.log_sd * self.random.normal()).exp();
        self.due = None;
        if responds {
            self.press_after(after_s);
        }
    }

    fn press_after(&mut self, seconds: f64) {
        self.due = Some(self.tick + (seconds * f64::from(TICKS_PER_S)).round() as u64);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the ticks from each of `count` signals, 4 s apart, to its press.
    fn responses(seed: u64, count: u32) -> Vec<Option<u64>> {
        let mut driver = TaskResponder::new(seed);
        let mut response = |stimulus| {
            let at = |tick| if tick < 100 { TaskPicture::Signal } else { TaskPicture::None };
            (0..400)
                .filter(|tick| driver.press(TaskDisplay { stimulus, shown: at(*tick) }) == TaskButton::Respond)
                .min()
        };
        (1..=count).map(&mut response).collect()
    }

    #[test]
    fn responses_to_signals_have_the_median_and_the_misses_of_the_model() {
        let all = responses(1, 2000);
        let mut taken: Vec<u64> = all.iter().flatten().copied().collect();
        taken.sort_unstable();
        let missed = 1.0 - taken.len() as f64 / 2000.0;
        assert!((missed - 0.04).abs() < 0.015, "{missed}");
        // 0.45 s are 45 ticks; the standard error of the median of 1900 is 1.25 x 0.3 x 45 / 44 = 0.4 ticks.
        assert!((43..=47).contains(&taken[taken.len() / 2]), "{}", taken[taken.len() / 2]);
        assert_eq!(responses(1, 20), all[..20], "the same seed responds alike");
        assert_ne!(responses(2, 20), all[..20]);
    }

    #[test]
    fn the_cursor_is_moved_column_by_column_and_confirmed() {
        let mut driver = TaskResponder::new(3);
        let (mut cursor, mut pressed) = (3, Vec::new());
        for _ in 0..1000 {
            let shown = TaskPicture::Search { seed: 1, columns: 6, target_column: 0, cursor, size_ratio: 1.4 };
            let button = driver.press(TaskDisplay { stimulus: 1, shown });
            cursor -= u8::from(button == TaskButton::Left);
            pressed.extend(Some(button).filter(|button| *button != TaskButton::None));
        }
        assert_eq!(pressed, [TaskButton::Left, TaskButton::Left, TaskButton::Left, TaskButton::Respond]);
    }

    #[test]
    fn nothing_is_pressed_without_a_task_or_at_digits_to_be_spoken() {
        let mut driver = TaskResponder::new(1);
        for stimulus in 0..50 {
            let shown = TaskPicture::Digit { digit: 1, n: 1, is_match: None };
            assert!((0..200).all(|_| driver.press(TaskDisplay { stimulus, shown }) == TaskButton::None));
        }
        assert!((0..2000).all(|_| driver.press(TaskDisplay::default()) == TaskButton::None));
    }
}
