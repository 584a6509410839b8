//! Mixer of all sounds. In: a [`SoundScene`] and the number of samples. Out: these samples, left and right, each below
//! full scale. [`Mixer::sample`] has the formulas.

use super::{
    NEAR, SoundScene,
    engine::EngineVoice,
    filtered_noise::FilteredNoise,
    one_shot::{ContactSound, Horn, Tone},
    smoothing::SmoothedValue,
    traffic::OtherVoice,
};
use crate::scenario::{SoundLevels, sound::gain};

/// Amplitude up to which the limiter changes nothing; above it the curve bends towards full scale.
const KNEE: f32 = 0.6;
/// Full scale, less the rounding of a 16-bit sample.
pub(super) const FULL: f32 = 0.999;
/// Time constant of fading in at the start and after a pause, s.
const FADE_S: f32 = 0.03;
/// Time of the way to silence at a pause, s: short enough that the next block of a device is silent, long enough that nothing clicks.
const SILENCE_S: f32 = 0.005;
/// Time constant of speed and ground, s.
const SPEED_S: f32 = 0.05;
/// Speed that the levels of tyres and wind refer to, m/s.
const BRISK_MPS: f32 = 14.0;

/// All sources of sound, with their levels.
pub struct Mixer {
    levels: LevelFactors,
    engine: EngineVoice,
    /// Noise of the tyres, left and right.
    rumble: [FilteredNoise; 2],
    swish: [FilteredNoise; 2],
    wind: [FilteredNoise; 2],
    /// Rain: the patter on the roof, and its hiss.
    patter: [FilteredNoise; 2],
    hiss: [FilteredNoise; 2],
    others: [OtherVoice; NEAR],
    horn: Horn,
    thump: ContactSound,
    tone: Tone,
    question: Tone,
    master: SmoothedValue,
    /// Decrease of the master for each sample of a pause.
    silence_step: f32,
    speed_mps: SmoothedValue,
    grass: SmoothedValue,
    /// Contacts, changes of advice and questions that have been heard; `None` before the first sample.
    heard: Option<(u32, u32, u32)>,
}

/// Amplitude factors of the settings.
#[derive(Clone, Copy, Debug)]
struct LevelFactors {
    master: f32,
    engine: f32,
    road: f32,
    wind: f32,
    others: f32,
    horn: f32,
    tone: f32,
}

impl Mixer {
    /// Creates a silent mixer at this sample rate, Hz.
    pub fn new(levels: &SoundLevels, rate_hz: f32) -> Self {
        let pair = |make: fn(u64, f32) -> FilteredNoise, seed| [make(seed, rate_hz), make(seed + 1, rate_hz)];
        Self {
            levels: LevelFactors {
                master: gain(levels.master_db),
                engine: gain(levels.engine_db),
                road: gain(levels.road_db),
                wind: gain(levels.wind_db),
                others: gain(levels.others_db),
                horn: gain(levels.horn_db),
                tone: gain(levels.tone_db),
            },
            engine: EngineVoice::new(rate_hz),
            rumble: pair(FilteredNoise::below, 11),
            swish: pair(FilteredNoise::around, 13),
            wind: pair(FilteredNoise::around, 15),
            patter: pair(FilteredNoise::below, 17),
            hiss: pair(FilteredNoise::around, 19),
            others: std::array::from_fn(|index| OtherVoice::new(index, rate_hz)),
            horn: Horn::new(rate_hz),
            thump: ContactSound::new(rate_hz),
            tone: Tone::of_advice(rate_hz),
            question: Tone::of_question(rate_hz),
            master: SmoothedValue::new(0.0, FADE_S, rate_hz),
            silence_step: gain(levels.master_db) / (SILENCE_S * rate_hz),
            speed_mps: SmoothedValue::new(0.0, SPEED_S, rate_hz),
            grass: SmoothedValue::new(0.0, SPEED_S, rate_hz),
            heard: None,
        }
    }

    /// Fills `out` with the next samples of this scene.
    pub fn render(&mut self, sound_scene: &SoundScene, out: &mut [[f32; 2]]) {
        let counts = (sound_scene.contacts, sound_scene.advices, sound_scene.questions);
        let heard = self.heard.replace(counts);
        match heard {
            None => {
                // The state at the start applies at once; only the master fades in.
                self.engine.jump(sound_scene.engine_rpm, sound_scene.throttle);
                self.speed_mps.jump(sound_scene.speed_mps);
                self.grass.jump(sound_scene.grass);
            }
            Some((contacts, advices, questions)) => {
                if contacts != sound_scene.contacts {
                    self.thump.hit(sound_scene.contact_mps);
                }
                if advices != sound_scene.advices {
                    self.tone.begin();
                }
                if questions != sound_scene.questions {
                    self.question.begin();
                }
            }
        }
        for sample in out {
            *sample = self.sample(sound_scene);
        }
    }

    fn sample(&mut self, sound_scene: &SoundScene) -> [f32; 2] {
        let master = match sound_scene.running {
            true => self.master.to(self.levels.master),
            false => self.master.fall(self.silence_step),
        };
        let middle = self.levels.engine * self.engine.next(sound_scene.engine_rpm, sound_scene.throttle)
            + self.levels.horn * (self.horn.next(sound_scene.horn) + self.thump.next())
            + self.levels.tone * (self.tone.next() + self.question.next());
        let speed_mps = self.speed_mps.to(sound_scene.speed_mps).abs();
        let grass = self.grass.to(sound_scene.grass).clamp(0.0, 1.0);
        let mut sides = [middle; 2];
        for car in 0..NEAR {
            let heard = self.others[car].next(sound_scene.near[car].as_ref());
            sides = [0, 1].map(|side| sides[side] + self.levels.others * heard[side]);
        }
        if speed_mps > 0.0 {
            let brisk = speed_mps / BRISK_MPS;
            // The pressure of tyre noise grows with about the speed to the 1.5 (30 dB a decade), of wind with 2.5 to 3.
            let (asphalt, meadow) = (0.035 * brisk * brisk.sqrt(), 0.075 * brisk.min(1.5));
            let rumble = asphalt + (meadow - asphalt) * grass;
            let rumble_hz = (330.0 + 12.0 * speed_mps) * (1.0 - 0.55 * grass);
            // Water under the tyres hisses.
            let wet = if sound_scene.rain_mmph > 0.0 { 0.040 * brisk * (1.0 - grass) } else { 0.0 };
            let swish = 0.018 * brisk + (0.030 * brisk.min(1.5) - 0.018 * brisk) * grass + wet;
            let swish_hz = if wet > 0.0 { 2400.0 } else { 850.0 + 1700.0 * grass };
            let wind = 0.016 * brisk * brisk * brisk.sqrt();
            let wind_hz = 320.0 + 14.0 * speed_mps;
            for (side, sample) in sides.iter_mut().enumerate() {
                *sample += self.levels.road
                    * (rumble * self.rumble[side].next(rumble_hz) + swish * self.swish[side].next(swish_hz))
                    + self.levels.wind * wind * self.wind[side].next(wind_hz);
            }
        }
        if sound_scene.rain_mmph > 0.0 {
            // Ten times the rain is 6 dB louder here: more drops, and larger ones.
            let rain = self.levels.wind * (sound_scene.rain_mmph / 10.0).powf(0.3);
            for (side, sample) in sides.iter_mut().enumerate() {
                *sample += rain * (0.022 * self.patter[side].next(750.0) + 0.016 * self.hiss[side].next(3200.0));
            }
        }
        sides.map(|sample| limited(master * sample))
    }
}

/// Limits a sample softly: unchanged up to the knee, then bent without a corner towards full scale, which is never
/// reached. NaN becomes 0.
fn limited(sample: f32) -> f32 {
    let over = sample.abs() - KNEE;
    if over.is_nan() {
        return 0.0;
    }
    if over <= 0.0 {
        return sample;
    }
    let room = FULL - KNEE;
    (KNEE + room * (over / room).tanh()).copysign(sample)
}
