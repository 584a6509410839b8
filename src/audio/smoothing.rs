//! A number that glides to its target. In: targets at any time. Out: a value per sample.

/// A first-order low-pass filter.
#[derive(Clone, Copy, Debug)]
pub struct SmoothedValue {
    value: f32,
    share: f32,
}

impl SmoothedValue {
    /// Starts at `value`; after `time_s` 37 % of the distance to a new target is left.
    pub fn new(value: f32, time_s: f32, rate_hz: f32) -> Self {
        Self { value, share: 1.0 - (-1.0 / (time_s * rate_hz)).exp() }
    }

    /// Returns the next value on the way to `goal`; exactly `goal` once the difference is inaudible.
    pub fn to(&mut self, goal: f32) -> f32 {
        let rest = goal - self.value;
        self.value = if rest.abs() < 1e-7 { goal } else { self.value + self.share * rest };
        self.value
    }

    /// Returns the next value on a straight way down to 0, `step` lower than the last; exactly 0 at its end.
    pub fn fall(&mut self, step: f32) -> f32 {
        self.value = (self.value - step).max(0.0);
        self.value
    }

    /// Jumps to a value: for the first sample.
    pub fn jump(&mut self, value: f32) {
        self.value = value;
    }

    /// Returns the current value.
    pub fn now(&self) -> f32 {
        self.value
    }
}
