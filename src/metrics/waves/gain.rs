//! Gain from a leader's speed to a follower's by frequency. In: windows of speeds. Out: the gain at fixed frequencies.
//!
//! The estimate is that of Welch: in each window the mean is subtracted and a Hann taper applied; cross-spectra and the leaders'
//! spectra are summed over windows and pairs, and the gain is |cross| / leader. A follower's own noise does not bias it.

use super::VehicleSample;
use std::f64::consts::TAU;

/// Frequencies of the gains, Hz: 0.02 to 0.30.
pub const GAIN_HZ: [f64; 29] = {
    let mut hz = [0.0; 29];
    let mut i = 0;
    while i < hz.len() {
        hz[i] = (i + 2) as f64 / 100.0;
        i += 1;
    }
    hz
};

/// Sums of the spectra of leaders and followers.
#[derive(Clone, Debug)]
pub struct GainSpectrum {
    /// Tapered cosine and sine of each frequency at each step of a window.
    waves: Vec<Vec<[f64; 2]>>,
    /// Cross-spectrum of leader and follower, real and imaginary part, by frequency.
    cross: [[f64; 2]; GAIN_HZ.len()],
    /// Spectrum of the leaders, by frequency.
    leader: [f64; GAIN_HZ.len()],
}

impl GainSpectrum {
    /// Starts the sums of windows of so many steps.
    pub fn new(steps: usize, step_s: f64) -> Self {
        let wave = |hz: &f64| {
            let at = |i: usize| {
                let taper = 0.5 - 0.5 * (TAU * (i as f64 + 0.5) / steps as f64).cos();
                let (sin, cos) = (TAU * hz * i as f64 * step_s).sin_cos();
                [taper * cos, -taper * sin]
            };
            (0..steps).map(at).collect()
        };
        let zero = Default::default();
        Self { waves: GAIN_HZ.iter().map(wave).collect(), cross: zero, leader: [0.0; GAIN_HZ.len()] }
    }

    /// Adds a window: a row per step, and the leader of each vehicle.
    pub fn add_window(&mut self, window: &[Vec<VehicleSample>], leaders: &[Option<usize>]) {
        let spectra: Vec<_> = (0..leaders.len()).map(|vehicle| self.spectrum(window, vehicle)).collect();
        for (follower, leader) in leaders.iter().enumerate() {
            let Some(leader) = *leader else { continue };
            for (k, ([a, b], [c, d])) in spectra[leader].iter().zip(&spectra[follower]).enumerate() {
                self.leader[k] += a * a + b * b;
                self.cross[k][0] += a * c + b * d;
                self.cross[k][1] += a * d - b * c;
            }
        }
    }

    /// Returns the spectrum of a vehicle's speed less its mean.
    fn spectrum(&self, window: &[Vec<VehicleSample>], vehicle: usize) -> Vec<[f64; 2]> {
        let mean_mps = window.iter().map(|row| row[vehicle].speed_mps).sum::<f64>() / window.len() as f64;
        let of = |wave: &Vec<[f64; 2]>| {
            window.iter().zip(wave).fold([0.0; 2], |[re, im], (row, [cos, sin])| {
                let speed_mps = row[vehicle].speed_mps - mean_mps;
                [re + speed_mps * cos, im + speed_mps * sin]
            })
        };
        self.waves.iter().map(of).collect()
    }

    /// Returns the gain at a frequency of [`GAIN_HZ`]; `None` at others, or if no leader's speed varies.
    pub fn gain(&self, hz: f64) -> Option<f64> {
        let k = GAIN_HZ.iter().position(|at| (at - hz).abs() < 1e-9)?;
        let [re, im] = self.cross[k];
        (self.leader[k] > 1e-9).then(|| re.hypot(im) / self.leader[k])
    }
}
