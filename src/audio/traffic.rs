//! Other vehicles nearby. In: their positions in the ego's axes, and their speeds. Out: samples, left and right: level
//! by distance and speed, side by bearing, duller from behind.

use super::{NearbyVehicle, filtered_noise::FilteredNoise, smoothing::SmoothedValue};

/// Distance up to which a vehicle has its full level, m; beyond it the level is inversely proportional to the distance.
const NEAR_M: f32 = 3.0;
/// Largest share of the panning, below 1: the head muffles the sound at the far ear but does not block it.
const WIDTH: f32 = 0.85;

/// Sound of one other vehicle.
pub struct OtherVoice {
    rate_hz: f32,
    tyres: FilteredNoise,
    phase: f32,
    /// Firing frequency of its engine at a standstill, Hz; different for each voice.
    idle_hz: f32,
    hum_hz: SmoothedValue,
    hum: SmoothedValue,
    hiss: SmoothedValue,
    cutoff_hz: SmoothedValue,
    side: SmoothedValue,
}

impl OtherVoice {
    /// Creates voice number `index`, silent.
    pub fn new(index: usize, rate_hz: f32) -> Self {
        let glide = |value| SmoothedValue::new(value, 0.06, rate_hz);
        let idle_hz = 26.0 + 1.7 * index as f32;
        Self {
            rate_hz,
            tyres: FilteredNoise::below(31 + index as u64, rate_hz),
            phase: 0.0,
            idle_hz,
            hum_hz: glide(idle_hz),
            hum: glide(0.0),
            hiss: glide(0.0),
            cutoff_hz: glide(300.0),
            side: glide(0.0),
        }
    }

    /// Returns the next sample, left and right; `None` fades out in place.
    pub fn next(&mut self, car: Option<&NearbyVehicle>) -> [f32; 2] {
        let (mut hum, mut hiss) = (0.0, 0.0);
        if let Some(car) = car {
            let distance_m = car.ahead_m.hypot(car.left_m);
            let level = NEAR_M / distance_m.max(NEAR_M);
            let speed = (car.speed_mps.abs() / 14.0).min(2.5);
            (hum, hiss) = (level * (0.012 + 0.02 * speed), level * 0.11 * speed * speed.sqrt());
            self.side.to(WIDTH * car.left_m / distance_m.max(1.0));
            let behind = if car.ahead_m < 0.0 { 0.65 } else { 1.0 };
            self.cutoff_hz.to(behind * (380.0 + 45.0 * car.speed_mps.abs()));
            self.hum_hz.to(self.idle_hz + 3.0 * car.speed_mps.abs());
        }
        let (hum, hiss) = (self.hum.to(hum), self.hiss.to(hiss));
        if hum == 0.0 && hiss == 0.0 {
            return [0.0; 2];
        }
        self.phase = (self.phase + self.hum_hz.now() / self.rate_hz).fract();
        let turn = std::f32::consts::TAU * self.phase;
        let engine = turn.sin() + 0.5 * (2.0 * turn).sin() + 0.3 * (3.0 * turn).sin();
        let sound = hum * engine + hiss * self.tyres.next(self.cutoff_hz.now());
        let side = self.side.now().clamp(-1.0, 1.0);
        [((1.0 + side) / 2.0).sqrt() * sound, ((1.0 - side) / 2.0).sqrt() * sound]
    }
}
