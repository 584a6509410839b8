//! One ring or drive, step by step. In: places and speeds as they are measured. Out: what a figure is drawn from. Metres, m/s.

/// One ring, step by step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trajectories {
    /// Length of the ring, metres.
    pub circumference_m: f64,
    /// Seconds; the first advice is at 0.
    pub time_s: Vec<f64>,
    /// Way of each car, the ego first, then backwards, metres, not wrapped; a row a step.
    pub way_m: Vec<Vec<f32>>,
    /// Their speeds, m/s.
    pub speed_mps: Vec<Vec<f32>>,
    /// The speed that is shown to the ego's driver, m/s.
    pub shown_mps: Vec<Option<f64>>,
    /// When cars collided, seconds; the trace ends there.
    pub crash_s: Option<f64>,
    /// First and last second that were to be driven, where that is known.
    pub span_s: Option<[f64; 2]>,
}

impl Trajectories {
    /// When the drive, whole or not, began, rounded down to a second, and when it ended.
    pub fn span_s(&self) -> [f64; 2] {
        let ends = || Some([self.time_s.first()?.floor(), *self.time_s.last()?]);
        self.span_s.or_else(ends).unwrap_or([0.0, 1.0])
    }
}
