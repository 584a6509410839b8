//! Noise through a filter, by fundsp. In: a cutoff or centre frequency, Hz. Out: samples of about the same loudness at
//! any frequency. The same seed gives the same samples.

use fundsp::prelude32::*;

/// Interval at which a filter follows its frequency, samples: tuning it takes a tangent.
const RETUNE: u32 = 32;

/// A source of filtered noise.
pub struct FilteredNoise {
    unit: Box<dyn AudioUnit>,
    frequency_hz: f32,
    samples: u32,
    most_hz: f32,
    loudness: fn(f32, f32) -> f32,
    rate_hz: f32,
    gain: f32,
}

impl FilteredNoise {
    /// Creates noise below a frequency.
    pub fn below(seed: u64, rate_hz: f32) -> Self {
        // White noise below f has the share 2 f / rate of its power.
        Self::of(Box::new((noise().seed(seed) | pass()) >> lowpass_q(0.6)), rate_hz, |f, rate| {
            (rate / (2.0 * f)).sqrt()
        })
    }

    /// Creates noise around a frequency, with a bandwidth of about half of it.
    pub fn around(seed: u64, rate_hz: f32) -> Self {
        Self::of(Box::new((noise().seed(seed) | pass()) >> bandpass_q(1.2)), rate_hz, |f, rate| (rate / f).sqrt())
    }

    fn of(mut unit: Box<dyn AudioUnit>, rate_hz: f32, loudness: fn(f32, f32) -> f32) -> Self {
        unit.set_sample_rate(rate_hz.into());
        unit.allocate();
        Self { unit, frequency_hz: 0.0, samples: 0, most_hz: 0.4 * rate_hz, loudness, rate_hz, gain: 0.0 }
    }

    /// Returns the next sample; the RMS level is about 0.5.
    pub fn next(&mut self, frequency_hz: f32) -> f32 {
        if self.samples.is_multiple_of(RETUNE) {
            self.frequency_hz = frequency_hz.clamp(20.0, self.most_hz);
            self.gain = (self.loudness)(self.frequency_hz, self.rate_hz);
        }
        self.samples = self.samples.wrapping_add(1);
        self.unit.filter_mono(self.frequency_hz) * self.gain
    }
}
