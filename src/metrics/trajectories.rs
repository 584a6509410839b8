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

/// Speeds over time, as a figure shows them: a value a step in each list. m/s.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpeedTrace {
    /// Seconds.
    pub time_s: Vec<f64>,
    /// The ego's.
    pub ego_mps: Vec<f64>,
    /// What is shown to its driver.
    pub shown_mps: Vec<Option<f64>>,
    /// Mean of all vehicles.
    pub mean_mps: Vec<f64>,
    /// The slowest and the fastest of all; empty where they are not shown.
    pub extremes_mps: Vec<[f64; 2]>,
    /// When cars collided, seconds; the trace ends there.
    pub crash_s: Option<f64>,
    /// First and last second that are shown, if these are not those of the trace.
    pub shown_s: Option<[f64; 2]>,
}

impl SpeedTrace {
    /// Those of a ring.
    pub fn of(ring: &Trajectories) -> Self {
        let extreme = |cars: &[f32], f: fn(f32, f32) -> f32| cars.iter().copied().reduce(f).map_or(0.0, f64::from);
        let mean = |cars: &[f32]| cars.iter().map(|v| f64::from(*v)).sum::<f64>() / cars.len() as f64;
        let cars = || ring.speed_mps.iter();
        Self {
            time_s: ring.time_s.clone(),
            ego_mps: cars().map(|cars| f64::from(cars[0])).collect(),
            shown_mps: ring.shown_mps.clone(),
            mean_mps: cars().map(|cars| mean(cars)).collect(),
            extremes_mps: cars().map(|cars| [extreme(cars, f32::min), extreme(cars, f32::max)]).collect(),
            crash_s: ring.crash_s,
            shown_s: Some(ring.span_s()),
        }
    }

    /// First and last second of the axis.
    pub fn span_s(&self) -> [f64; 2] {
        let ends = || Some([self.time_s.first()?.floor(), *self.time_s.last()?]);
        self.shown_s.or_else(ends).unwrap_or([0.0, 1.0])
    }
}
