//! Mean of the ego's speed as policies see it. In: the speed, step by step. Out: its moving average, m/s.

/// Time constant of the mean, s: about the wave's period on the paper's ring (33.5 s, docs/references.md: ring).
const MEMORY_S: f64 = 30.0;

/// Own mean speed: an exponential moving average with time constant `MEMORY_S` that starts at the first speed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanSpeed(Option<f64>);

impl MeanSpeed {
    /// Adds one step of `step_s` seconds and returns the mean, m/s.
    pub fn watch(&mut self, speed_mps: f64, step_s: f64) -> f64 {
        let before = self.0.unwrap_or(speed_mps);
        let mean = before + (speed_mps - before) * Self::share(step_s);
        self.0 = Some(mean);
        mean
    }

    /// Returns the weight of one step of `step_s` seconds in the mean.
    pub fn share(step_s: f64) -> f64 {
        step_s / MEMORY_S
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_speed_begins_with_the_first_and_follows_within_half_a_minute() {
        let mut mean = MeanSpeed::default();
        assert_eq!(mean.watch(4.0, 0.1), 4.0);
        let after = (0..300).map(|_| mean.watch(0.0, 0.1)).last().unwrap();
        assert!((after - 4.0 / std::f64::consts::E).abs() < 0.01, "{after}");
    }
}
