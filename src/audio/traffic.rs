//! Other vehicles and people nearby. In: their positions in the ego's axes, speeds and steps. Out: samples, left and right: level by distance and
//! speed, side by bearing; vehicles are duller from behind. Levels of people are relative to that of a passing car (docs/references.md: footsteps).

use super::{
    NearbyVehicle, filtered_noise::FilteredNoise, one_shot::Footstep, smoothing::SmoothedValue,
    sound_scene::SoundSource,
};

/// Distance up to which a vehicle has its full level, m; beyond it the level is inversely proportional to the distance.
const NEAR_M: f32 = 3.0;
/// Distance up to which a person on foot or on a bicycle has the full level, m.
const NEAR_PERSON_M: f32 = 1.0;
/// Largest share of the panning, below 1: the head muffles the sound at the far ear but does not block it.
const WIDTH: f32 = 0.85;
/// Amplitude of a bicycle's tyres at 1 m and at its usual speed, and that speed, m/s.
const BICYCLE: f32 = 0.0037;
const BICYCLE_MPS: f32 = 5.0;
/// Middle of the noise of a bicycle's tyres, Hz.
const BICYCLE_HZ: f32 = 1600.0;

/// Sound of one other vehicle or person.
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
    /// Tyres of a bicycle, and their level.
    thin_tyres: FilteredNoise,
    rush: SmoothedValue,
    footstep: Footstep,
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
            thin_tyres: FilteredNoise::around(51 + index as u64, rate_hz),
            rush: glide(0.0),
            footstep: Footstep::new(71 + index as u64, rate_hz),
        }
    }

    /// Returns the next sample, left and right; `None` fades out in place.
    pub fn next(&mut self, car: Option<&NearbyVehicle>) -> [f32; 2] {
        let (mut hum, mut hiss, mut rush, mut steps) = (0.0, 0.0, 0.0, None);
        if let Some(car) = car {
            let distance_m = car.ahead_m.hypot(car.left_m);
            let speed_mps = car.speed_mps.abs();
            self.side.to(WIDTH * car.left_m / distance_m.max(1.0));
            match car.source {
                SoundSource::Motor => {
                    let level = NEAR_M / distance_m.max(NEAR_M);
                    let speed = (speed_mps / 14.0).min(2.5);
                    (hum, hiss) = (level * (0.012 + 0.02 * speed), level * 0.11 * speed * speed.sqrt());
                    let behind = if car.ahead_m < 0.0 { 0.65 } else { 1.0 };
                    self.cutoff_hz.to(behind * (380.0 + 45.0 * speed_mps));
                    self.hum_hz.to(self.idle_hz + 3.0 * speed_mps);
                }
                SoundSource::Feet => steps = Some((car.steps, NEAR_PERSON_M / distance_m.max(NEAR_PERSON_M))),
                SoundSource::Bicycle => {
                    let speed = speed_mps / BICYCLE_MPS;
                    rush = BICYCLE * speed * speed.sqrt() * NEAR_PERSON_M / distance_m.max(NEAR_PERSON_M);
                }
            }
        }
        let (hum, hiss, rush) = (self.hum.to(hum), self.hiss.to(hiss), self.rush.to(rush));
        let tap = self.footstep.next(steps);
        if hum == 0.0 && hiss == 0.0 && rush == 0.0 && tap == 0.0 {
            return [0.0; 2];
        }
        let mut sound = tap;
        if hum != 0.0 || hiss != 0.0 {
            self.phase = (self.phase + self.hum_hz.now() / self.rate_hz).fract();
            let turn = std::f32::consts::TAU * self.phase;
            let engine = turn.sin() + 0.5 * (2.0 * turn).sin() + 0.3 * (3.0 * turn).sin();
            sound += hum * engine + hiss * self.tyres.next(self.cutoff_hz.now());
        }
        if rush != 0.0 {
            sound += rush * self.thin_tyres.next(BICYCLE_HZ);
        }
        let side = self.side.now().clamp(-1.0, 1.0);
        [((1.0 + side) / 2.0).sqrt() * sound, ((1.0 - side) / 2.0).sqrt() * sound]
    }
}
