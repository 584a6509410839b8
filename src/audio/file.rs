//! Sound as a file, offline. In: a [`SoundScene`] per tick. Out: a WAV file of 48 kHz, 16 bits, stereo, as long as the
//! drive to the sample; the same drive gives the same bytes.

use super::{
    Mixer, SoundScene,
    mixer::FULL,
    speech::{self, SpeechFault},
    voice::{Playback, WavSamples},
};
use crate::{scenario::SoundLevels, time::TICKS_PER_S};
use hound::{SampleFormat, WavSpec, WavWriter};
use std::{
    fs::{File, OpenOptions},
    io::{self, BufWriter},
    path::Path,
};

/// Sample rate, Hz; a whole number of samples per tick.
pub const RATE_HZ: u32 = 48_000;
const SAMPLES: usize = (RATE_HZ / TICKS_PER_S) as usize;

/// A sound file that is being written.
pub struct SoundFile {
    mixer: Mixer,
    writer: WavWriter<BufWriter<File>>,
    samples: Vec<[f32; 2]>,
    /// Sentence that is being spoken.
    speech: Option<Playback>,
    speech_gain: f32,
}

impl SoundFile {
    /// Creates a new file, readable by the user only.
    ///
    /// # Errors
    /// The file exists, or the system refuses.
    pub fn begin(path: &Path, levels: &SoundLevels) -> io::Result<Self> {
        let writer = new_wav(path, 2, RATE_HZ)?;
        Ok(Self {
            mixer: Mixer::new(levels, RATE_HZ as f32),
            writer,
            samples: vec![[0.0; 2]; SAMPLES],
            speech: None,
            speech_gain: levels.speech_gain(),
        })
    }

    /// Speaks a sentence from the next tick on, in place of one that is being spoken.
    ///
    /// # Errors
    /// There is no speech.
    pub fn say(&mut self, sentence: &str) -> Result<(), SpeechFault> {
        let wav = speech::spoken(sentence)?;
        self.speech = WavSamples::read(&wav).ok().map(|text| Playback::new(text, RATE_HZ, self.speech_gain));
        Ok(())
    }

    /// Appends the sound of one tick.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn tick(&mut self, sound_scene: &SoundScene) -> io::Result<()> {
        self.mixer.render(sound_scene, &mut self.samples);
        if let Some(speech) = &mut self.speech {
            let mut spoken = [[0.0; 2]; SAMPLES];
            if !speech.fill(&mut spoken) {
                self.speech = None;
            }
            let both = self.samples.iter_mut().flatten().zip(spoken.iter().flatten());
            both.for_each(|(sample, spoken)| *sample = (*sample + spoken).clamp(-FULL, FULL));
        }
        for sample in self.samples.iter().flatten() {
            self.writer.write_sample((sample * 32_767.0).round() as i16).map_err(to_io_error)?;
        }
        Ok(())
    }

    /// Completes the file.
    ///
    /// # Errors
    /// The disk refuses.
    pub fn end(self) -> io::Result<()> {
        self.writer.finalize().map_err(to_io_error)
    }
}

/// Creates a new WAV file of 16 bits, readable by the user only.
pub(super) fn new_wav(path: &Path, channels: u16, rate_hz: u32) -> io::Result<WavWriter<BufWriter<File>>> {
    let mut options = OpenOptions::new();
    options.write(true).create_new(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    let spec = WavSpec { channels, sample_rate: rate_hz, bits_per_sample: 16, sample_format: SampleFormat::Int };
    WavWriter::new(BufWriter::new(options.open(path)?), spec).map_err(to_io_error)
}

pub(super) fn to_io_error(error: hound::Error) -> io::Error {
    match error {
        hound::Error::IoError(error) => error,
        other => io::Error::other(other.to_string()),
    }
}
