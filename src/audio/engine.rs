//! The ego's engine: a four-stroke engine of four cylinders. In: its speed and load. Out: samples. Each cylinder fires
//! every other turn, so that the sound contains all multiples of half the engine's speed; the multiples of the firing
//! frequency, twice the engine's speed, are by far the strongest. Load makes the upper partials louder, so that the
//! pedal is heard.

use super::smoothing::SmoothedValue;

/// Number of partials: multiples of half the engine's speed.
const PARTIALS: usize = 24;
/// Every fourth partial belongs to the firing.
const FIRING: usize = 4;
/// Time constants of speed and load, s: a change of gear takes longer than the first.
const SPEED_S: f32 = 0.020;
const LOAD_S: f32 = 0.080;
/// Engine speed below which the engine is silent, 1/min; it fades in from here to idle.
const STANDS_RPM: f32 = 200.0;
const IDLE_RPM: f32 = 600.0;

/// State and spectrum of the engine's sound.
pub struct EngineVoice {
    rate_hz: f32,
    /// Phase of half the engine's speed, 0 to 1.
    phase: f32,
    rpm: SmoothedValue,
    load: SmoothedValue,
    /// Amplitude of each partial without load, and at full load.
    light: [f32; PARTIALS],
    heavy: [f32; PARTIALS],
}

impl EngineVoice {
    /// Creates an engine at standstill.
    pub fn new(rate_hz: f32) -> Self {
        Self {
            rate_hz,
            phase: 0.0,
            rpm: SmoothedValue::new(0.0, SPEED_S, rate_hz),
            load: SmoothedValue::new(0.0, LOAD_S, rate_hz),
            light: partials(1.5, 0.06),
            heavy: partials(1.0, 0.14),
        }
    }

    /// Jumps to this speed, 1/min, and load, without a glide.
    pub fn jump(&mut self, rpm: f32, load: f32) {
        self.rpm.jump(rpm);
        self.load.jump(load);
    }

    /// Returns the next sample on the way to this engine speed, 1/min, and load, 0 to 1.
    pub fn next(&mut self, rpm: f32, load: f32) -> f32 {
        let (rpm, load) = (self.rpm.to(rpm), self.load.to(load));
        self.phase = (self.phase + rpm / 120.0 / self.rate_hz).fract();
        let strength = 0.045 + 0.21 * (rpm / 6000.0).clamp(0.0, 1.2) * (0.35 + 0.65 * load);
        let runs = ((rpm - STANDS_RPM) / (IDLE_RPM - STANDS_RPM)).clamp(0.0, 1.0);
        if runs == 0.0 {
            return 0.0;
        }
        // sin((k + 1) x) from the two before it: one sine and one cosine a sample.
        let (sin, cos) = (std::f32::consts::TAU * self.phase).sin_cos();
        let (mut before, mut here, mut sum) = (0.0, sin, 0.0);
        for (light, heavy) in self.light.iter().zip(&self.heavy) {
            sum += (light + (heavy - light) * load) * here;
            (before, here) = (here, 2.0 * cos * here - before);
        }
        runs * strength * sum
    }
}

/// Returns the amplitudes of the partials, of unit power. The firing's partials fall with `steepness`; the others are a
/// `share` of that.
fn partials(steepness: f32, share: f32) -> [f32; PARTIALS] {
    let mut list: [f32; PARTIALS] = std::array::from_fn(|i| {
        let order = (i + 1) as f32 / FIRING as f32;
        let firing = (i + 1).is_multiple_of(FIRING);
        let strength = order.max(0.5).powf(-steepness);
        if firing { strength } else { share * strength }
    });
    let power: f32 = list.iter().map(|s| s * s).sum();
    list.iter_mut().for_each(|s| *s /= power.sqrt());
    list
}
