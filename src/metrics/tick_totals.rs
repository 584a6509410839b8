//! Sums of a drive over its ticks. In: speeds of all vehicles and the ego's speed, gap and range at each tick. Out: means, a
//! deviation and the smallest gap. Summaries of live drives and analyses of recordings use the same sums. SI units.

/// Mean of values added one by one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunningMean {
    sum: f64,
    n: u64,
}

impl Default for RunningMean {
    fn default() -> Self {
        // Sum of nothing: with 0.0, a sum of negative zeros would lose its sign.
        Self { sum: -0.0, n: 0 }
    }
}

impl RunningMean {
    /// Adds the next value to sum and count.
    pub fn add(&mut self, value: f64) {
        self.sum += value;
        self.n += 1;
    }

    /// Returns the number of values.
    pub fn count(&self) -> u64 {
        self.n
    }

    /// Returns the mean; `None` without values.
    pub fn get(&self) -> Option<f64> {
        (self.n > 0).then(|| self.sum / self.n as f64)
    }
}

/// Smallest of values added one by one; `None` without values.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RunningMinimum(pub Option<f64>);

impl RunningMinimum {
    /// Adds a value, if there is one.
    pub fn add(&mut self, value: Option<f64>) {
        self.0 = match (self.0, value) {
            (Some(least), Some(value)) => Some(least.min(value)),
            (least, value) => least.or(value),
        };
    }
}

/// Sums over the ticks of a drive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TickTotals {
    /// Mean speed of all vehicles, m/s.
    pub mean_speed_mps: RunningMean,
    /// Speed of the ego, m/s.
    pub ego_mean_speed_mps: RunningMean,
    /// Share of ticks in the range: 1 for a tick in it, 0 for one out of it.
    pub time_in_range: RunningMean,
    /// Gap to the leader, metres.
    pub min_gap_m: RunningMinimum,
    /// Mean and mean square of the speeds of all vehicles at all ticks, m/s and (m/s)^2.
    all_speeds: [RunningMean; 2],
    /// Smallest and largest number of vehicles at a tick with any.
    vehicles: Option<[u64; 2]>,
}

impl TickTotals {
    /// Adds the ego's tick; `is_in_range` is `None` without advice.
    pub fn add_ego(&mut self, speed_mps: f64, is_in_range: Option<bool>) {
        self.ego_mean_speed_mps.add(speed_mps);
        if let Some(is_in_range) = is_in_range {
            self.time_in_range.add(f64::from(u8::from(is_in_range)));
        }
    }

    /// Adds the speeds of all vehicles at a tick, whose mean is `mean_speed_mps`.
    pub fn add_speeds(&mut self, mean_speed_mps: f64, speeds_mps: impl Iterator<Item = f64>) {
        let before = self.all_speeds[0].count();
        for speed_mps in speeds_mps {
            self.all_speeds[0].add(speed_mps);
            self.all_speeds[1].add(speed_mps * speed_mps);
        }
        let vehicles = self.all_speeds[0].count() - before;
        if vehicles > 0 {
            self.mean_speed_mps.add(mean_speed_mps);
            let [least, most] = self.vehicles.unwrap_or([vehicles; 2]);
            self.vehicles = Some([least.min(vehicles), most.max(vehicles)]);
        }
    }

    /// Returns the distance of all vehicles over their time, m/s (Edie 1963); `None` if the number of vehicles never changed,
    /// because it then equals the mean speed.
    pub fn space_mean_speed_mps(&self) -> Option<f64> {
        let [least, most] = self.vehicles?;
        self.all_speeds[0].get().filter(|_| least < most)
    }

    /// Returns the standard deviation of the speeds of all vehicles at all ticks (N, not N-1), m/s.
    pub fn speed_sd_over_vehicles_and_time_mps(&self) -> Option<f64> {
        let [mean, square] = self.all_speeds.map(|speeds| speeds.get());
        mean.zip(square).map(|(mean, square)| (square - mean * mean).max(0.0).sqrt())
    }
}
