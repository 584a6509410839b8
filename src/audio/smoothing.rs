//! A number that moves smoothly to where it is told to be. In: goals at any time. Out: a value a sample.

/// A first-order glide.
#[derive(Clone, Copy, Debug)]
pub struct SmoothedValue {
    value: f32,
    share: f32,
}

impl SmoothedValue {
    /// Starts at `value` and comes within 37 % of a new goal in `time_s`.
    pub fn new(value: f32, time_s: f32, rate_hz: f32) -> Self {
        Self { value, share: 1.0 - (-1.0 / (time_s * rate_hz)).exp() }
    }

    /// The next value on the way to `goal`; exactly there once it is closer than can be heard.
    pub fn to(&mut self, goal: f32) -> f32 {
        let rest = goal - self.value;
        self.value = if rest.abs() < 1e-7 { goal } else { self.value + self.share * rest };
        self.value
    }

    /// Jumps there: for the first sample of all.
    pub fn jump(&mut self, value: f32) {
        self.value = value;
    }

    /// Where it is.
    pub fn now(&self) -> f32 {
        self.value
    }
}
