//! Trajectories of one ring or drive, step by step. In: measured positions and speeds. Out: data for figures. Metres, m/s.

/// Positions and speeds of all vehicles on one ring, step by step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trajectories {
    /// Length of the ring, metres.
    pub circumference_m: f64,
    /// Times in seconds; the first advice is at 0.
    pub time_s: Vec<f64>,
    /// Distance driven by each vehicle, metres, not wrapped; a row per step, with the ego first, then the vehicles behind it in
    /// order.
    pub way_m: Vec<Vec<f32>>,
    /// Speeds of the vehicles, m/s; same order.
    pub speed_mps: Vec<Vec<f32>>,
    /// Speed shown to the ego's driver, m/s.
    pub shown_mps: Vec<Option<f64>>,
    /// Time of a collision, seconds; the trace ends there.
    pub crash_s: Option<f64>,
    /// First and last second that were planned, if known.
    pub span_s: Option<[f64; 2]>,
}

impl Trajectories {
    /// Returns the planned span, else the start of the trace, rounded down to a second, and its end.
    pub fn span_s(&self) -> [f64; 2] {
        let ends = || Some([self.time_s.first()?.floor(), *self.time_s.last()?]);
        self.span_s.or_else(ends).unwrap_or([0.0, 1.0])
    }
}

/// Speeds over time for a figure, m/s: one value per step in each list.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SpeedTrace {
    /// Times in seconds since start.
    pub time_s: Vec<f64>,
    /// Speed of the ego.
    pub ego_mps: Vec<f64>,
    /// Speed shown to the ego's driver.
    pub shown_mps: Vec<Option<f64>>,
    /// Mean over all vehicles.
    pub mean_mps: Vec<f64>,
    /// Slowest and fastest of all vehicles; empty if they are not shown.
    pub extremes_mps: Vec<[f64; 2]>,
    /// Time of a collision, seconds; the trace ends there.
    pub crash_s: Option<f64>,
    /// First and last second shown, if different from the ends of the trace.
    pub shown_s: Option<[f64; 2]>,
}

impl SpeedTrace {
    /// Takes the speeds of a ring.
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

    /// Returns the first and last second of the axis.
    pub fn span_s(&self) -> [f64; 2] {
        let ends = || Some([self.time_s.first()?.floor(), *self.time_s.last()?]);
        self.shown_s.or_else(ends).unwrap_or([0.0, 1.0])
    }
}
