//! Playback of a spoken text. In: a WAV file in memory, or a sentence. Out: its sound on the device, once, and the progress. The
//! device is opened and closed on a thread of its own, as in [`Speaker`](super::Speaker); without a device the status
//! has the reason.

use super::{
    speaker::{self, DeviceRequests, LOOK, SpeakerFault},
    speech::{self, SpeechFault},
};
use hound::WavReader;
use std::{
    io::Cursor,
    sync::{
        Arc, Mutex,
        atomic::{AtomicBool, AtomicU32, Ordering},
        mpsc::{self, RecvTimeoutError, Sender},
    },
    thread::JoinHandle,
    time::Duration,
};

/// Time that a device may still need to play its buffer after the end of the text.
const TAIL: Duration = Duration::from_millis(150);

/// Progress of a spoken text.
#[derive(Clone, Debug, PartialEq)]
pub enum VoiceStatus {
    /// The device is being opened.
    Opening,
    /// The text is playing.
    Playing,
    /// The text was played to its end.
    Ended,
    /// The text cannot be played, with the reason.
    Failed(String),
}

/// Reason that a text cannot be played.
#[derive(Debug, thiserror::Error)]
enum VoiceFault {
    #[error("{0}")]
    Device(#[from] SpeakerFault),
    #[error("the file cannot be read: {0}")]
    File(#[from] hound::Error),
    #[error("{0}")]
    Speech(#[from] SpeechFault),
    #[error("the sound device asks for no samples")]
    Lost,
}

/// A text that is being played; dropping it stops the playback.
pub struct Voice {
    status: Arc<Mutex<VoiceStatus>>,
    close: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Voice {
    /// Starts the playback on a thread of its own; the device opens a little later.
    pub fn play(wav: Arc<[u8]>) -> Self {
        Self::begin(1.0, move || Ok(wav))
    }

    /// Starts to speak a sentence on a thread of its own, its amplitude multiplied by `gain`.
    pub fn say(sentence: String, gain: f32) -> Self {
        Self::begin(gain, move || Ok(speech::spoken(&sentence)?))
    }

    fn begin(gain: f32, text: impl FnOnce() -> Result<Arc<[u8]>, VoiceFault> + Send + 'static) -> Self {
        let status = Arc::new(Mutex::new(VoiceStatus::Opening));
        let (close, closed) = mpsc::channel::<()>();
        let theirs = Arc::clone(&status);
        let started = std::thread::Builder::new().name("voice".into()).spawn(move || {
            let (over, mut requests) = (Arc::new(AtomicBool::new(false)), DeviceRequests::default());
            match text().and_then(|wav| start(&wav, gain, &over, &requests.counter())) {
                Ok(stream) => {
                    while !over.load(Ordering::Relaxed) {
                        match requests.look() {
                            None => {}
                            Some(true) => put(&theirs, VoiceStatus::Playing),
                            Some(false) => return put(&theirs, VoiceStatus::Failed(VoiceFault::Lost.to_string())),
                        }
                        if closed.recv_timeout(LOOK) == Err(RecvTimeoutError::Disconnected) {
                            return;
                        }
                    }
                    let _ = closed.recv_timeout(TAIL);
                    put(&theirs, VoiceStatus::Ended);
                    drop(stream);
                }
                Err(why) => put(&theirs, VoiceStatus::Failed(why.to_string())),
            }
        });
        let thread =
            started.map_err(|e| put(&status, VoiceStatus::Failed(format!("its thread cannot start: {e}")))).ok();
        Self { status, close: Some(close), thread }
    }

    /// Returns the current progress.
    pub fn status(&self) -> VoiceStatus {
        self.status.lock().map_or(VoiceStatus::Ended, |status| status.clone())
    }
}

impl Drop for Voice {
    fn drop(&mut self) {
        self.close = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn put(status: &Mutex<VoiceStatus>, now: VoiceStatus) {
    if let Ok(mut status) = status.lock() {
        *status = now;
    }
}

fn start(wav: &[u8], gain: f32, over: &Arc<AtomicBool>, requests: &Arc<AtomicU32>) -> Result<cpal::Stream, VoiceFault> {
    let text = WavSamples::read(wav)?;
    Ok(speaker::stream(|rate_hz| {
        let (mut playback, over) = (Playback::new(text.clone(), rate_hz, gain), Arc::clone(over));
        let requests = Arc::clone(requests);
        move |out: &mut [[f32; 2]]| {
            requests.fetch_add(1, Ordering::Relaxed);
            if !playback.fill(out) {
                over.store(true, Ordering::Relaxed);
            }
        }
    })?)
}

/// Samples of a file, left and right, as shares of full scale.
#[derive(Clone, Debug)]
pub(super) struct WavSamples {
    rate_hz: u32,
    samples: Arc<[[f32; 2]]>,
}

impl WavSamples {
    pub fn read(wav: &[u8]) -> Result<Self, hound::Error> {
        let mut reader = WavReader::new(Cursor::new(wav))?;
        let spec = reader.spec();
        let full = (1_u64 << (spec.bits_per_sample - 1)) as f32;
        let all: Vec<f32> =
            reader.samples::<i32>().map(|s| Ok(s? as f32 / full)).collect::<Result<_, hound::Error>>()?;
        let samples = all.chunks_exact(spec.channels.into()).map(|frame| [frame[0], frame[frame.len() - 1]]).collect();
        Ok(Self { rate_hz: spec.sample_rate, samples })
    }
}

/// Playback of a text at the rate of a device, by linear interpolation between the file's samples.
pub(super) struct Playback {
    text: WavSamples,
    /// Position of the next sample, in samples of the file.
    at: f64,
    step: f64,
    gain: f32,
}

impl Playback {
    pub fn new(text: WavSamples, rate_hz: u32, gain: f32) -> Self {
        let step = f64::from(text.rate_hz) / f64::from(rate_hz);
        Self { text, at: 0.0, step, gain }
    }

    /// Fills `out` with the next samples, and silence after the end. Returns false once the end has been reached.
    pub fn fill(&mut self, out: &mut [[f32; 2]]) -> bool {
        let samples = &self.text.samples;
        for sample in out {
            let (before, share) = (self.at as usize, self.at.fract() as f32);
            let here = samples.get(before).copied().unwrap_or_default();
            let next = samples.get(before + 1).copied().unwrap_or_default();
            let value = |side: usize| here[side] + (next[side] - here[side]) * share;
            *sample = [0, 1].map(|side| (value(side) * self.gain).clamp(-1.0, 1.0));
            self.at += self.step;
        }
        self.at < samples.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hound::{SampleFormat, WavSpec, WavWriter};

    fn wav(channels: u16, rate_hz: u32, samples: &[i16]) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        let spec = WavSpec { channels, sample_rate: rate_hz, bits_per_sample: 16, sample_format: SampleFormat::Int };
        let mut writer = WavWriter::new(&mut bytes, spec).unwrap();
        samples.iter().for_each(|sample| writer.write_sample(*sample).unwrap());
        writer.finalize().unwrap();
        bytes.into_inner()
    }

    #[test]
    fn a_text_plays_at_the_devices_rate_to_its_end_then_silence_follows() {
        let text = WavSamples::read(&wav(2, 24_000, &[0, 16_384, 16_384, 0, -16_384, -32_768])).unwrap();
        // Twice as many samples: every second one is half way between its neighbours.
        let mut playback = Playback::new(text.clone(), 48_000, 1.0);
        let mut out = [[9.0; 2]; 5];
        assert!(playback.fill(&mut out));
        assert_eq!(out, [[0.0, 0.5], [0.25, 0.25], [0.5, 0.0], [0.0, -0.5], [-0.5, -1.0]]);
        assert!(!playback.fill(&mut out));
        assert_eq!(out[1..], [[0.0; 2]; 4], "nothing comes after the end");
        Playback::new(text, 24_000, 1.5).fill(&mut out);
        assert_eq!(out[1..4], [[0.75, 0.0], [-0.75, -1.0], [0.0; 2]], "louder, up to full scale");
        let mono = WavSamples::read(&wav(1, 8000, &[16_384])).unwrap();
        assert_eq!(mono.samples[..], [[0.5, 0.5]], "one channel is heard on both sides");
        assert!(WavSamples::read(b"no file").is_err());
    }
}
