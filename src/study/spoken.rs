//! Spoken instructions. In: WAV files beside the study, a single one or one per language. Out: a [`SpokenText`] that a device can play,
//! with its length; or the reason why a file cannot be used. The spoken words are those of the segment's `text`, which is shown at the
//! same time for participants who do not hear.

use crate::file::read_bounded;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    sync::Arc,
};

/// Maximum size of a file, bytes; five minutes in stereo at 48 kHz and 16 bits take 58 MB.
const MOST_BYTES: u64 = 64 << 20;

/// Files of a segment's spoken instructions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum SpokenFiles {
    /// Single file beside the study.
    One(PathBuf),
    /// One file per language; the study's `language` selects one.
    ByLanguage(BTreeMap<String, PathBuf>),
}

/// Instructions that can be played.
#[derive(Clone, Debug, PartialEq)]
pub struct SpokenText {
    /// File name, without folders.
    pub file: String,
    /// Length of the audio, s.
    pub length_s: f64,
    /// Sample rate of the audio, Hz.
    pub rate_hz: u32,
    /// Number of channels, 1 or 2.
    pub channels: u16,
    /// Contents of the WAV file.
    pub wav: Arc<[u8]>,
}

/// Reason why instructions cannot be spoken.
#[derive(Debug, thiserror::Error)]
pub(super) enum SpokenFault {
    /// The instructions come in several languages, and none is selected.
    #[error("the instructions come in {0}; name the spoken language at the top of the file: language = \"...\"")]
    NoLanguage(String),
    /// The instructions do not come in the selected language.
    #[error("the study's language is \"{language}\"; the instructions come in {known}")]
    OtherLanguage {
        /// Language of the study.
        language: String,
        /// Languages of the instructions.
        known: String,
    },
    /// The file cannot be read.
    #[error("{} cannot be read: {source}", file.display())]
    Unreadable {
        /// Path of the file.
        file: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file is not a PCM WAV file.
    #[error("{} is not a WAV file of PCM samples ({why}); allowed: PCM of 8, 16, 24 or 32 bits, one or two \
        channels", file.display())]
    NoWav {
        /// Path of the file.
        file: PathBuf,
        /// First fault in the file's header.
        why: &'static str,
    },
}

impl SpokenFiles {
    /// Returns the file for this language.
    fn chosen(&self, language: Option<&str>) -> Result<&Path, SpokenFault> {
        let files = match self {
            Self::One(file) => return Ok(file),
            Self::ByLanguage(files) => files,
        };
        let known = files.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
        let Some(language) = language else { return Err(SpokenFault::NoLanguage(known)) };
        let other = || SpokenFault::OtherLanguage { language: language.into(), known };
        files.get(language).map(PathBuf::as_path).ok_or_else(other)
    }

    /// Reads the file for this language from the study's folder.
    pub(super) fn read(&self, folder: &Path, language: Option<&str>) -> Result<SpokenText, SpokenFault> {
        let name = self.chosen(language)?;
        let file = folder.join(name);
        let bytes =
            read_bounded(&file, MOST_BYTES).map_err(|source| SpokenFault::Unreadable { file: file.clone(), source })?;
        let wav = WavHeader::of(&bytes).map_err(|why| SpokenFault::NoWav { file, why })?;
        Ok(SpokenText {
            file: name.file_name().unwrap_or_default().to_string_lossy().into_owned(),
            length_s: wav.frames as f64 / f64::from(wav.rate_hz),
            rate_hz: wav.rate_hz,
            channels: wav.channels,
            wav: bytes.into(),
        })
    }
}

impl std::fmt::Display for SpokenText {
    /// Describes the audio: `welcome.wav, 12.3 s, 48000 Hz, mono`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let channels = if self.channels == 1 { "mono" } else { "stereo" };
        write!(f, "{}, {:.1} s, {} Hz, {channels}", self.file, self.length_s, self.rate_hz)
    }
}

/// Format and length of a WAV file.
struct WavHeader {
    rate_hz: u32,
    channels: u16,
    /// Number of samples per channel.
    frames: u64,
}

impl WavHeader {
    /// Reads the chunks of a RIFF file up to its samples.
    fn of(bytes: &[u8]) -> Result<Self, &'static str> {
        /// Format tags: WAVE_FORMAT_PCM, and WAVE_FORMAT_EXTENSIBLE, whose subformat GUID starts with the former.
        const PCM: u16 = 1;
        const EXTENSIBLE: u16 = 0xfffe;
        if bytes.get(..4) != Some(b"RIFF") || bytes.get(8..12) != Some(b"WAVE") {
            return Err("it does not begin with RIFF and WAVE");
        }
        let two = |at: usize| Some(u16::from_le_bytes(bytes.get(at..at + 2)?.try_into().ok()?));
        let four = |at: usize| Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?));
        let (mut at, mut format) = (12, None);
        while let (Some(name), Some(size)) = (bytes.get(at..at + 4), four(at + 4)) {
            let body = at + 8;
            match name {
                b"fmt " => {
                    let fields = (two(body), two(body + 2), four(body + 4), two(body + 14));
                    let (Some(tag), Some(channels), Some(rate_hz), Some(bits)) = fields else {
                        return Err("it is cut");
                    };
                    let tag = if tag == EXTENSIBLE { two(body + 24).ok_or("it is cut")? } else { tag };
                    if tag != PCM {
                        return Err("its samples are not PCM");
                    }
                    if !(1..=2).contains(&channels) || ![8, 16, 24, 32].contains(&bits) || rate_hz == 0 {
                        return Err("its number of channels, rate or bits differ");
                    }
                    format = Some((rate_hz, channels, u64::from(channels) * u64::from(bits) / 8));
                }
                b"data" => {
                    let Some((rate_hz, channels, frame)) = format else { return Err("its format is missing") };
                    if (bytes.len() - body) < size as usize {
                        return Err("it is cut");
                    }
                    return match u64::from(size) / frame {
                        0 => Err("it is empty"),
                        frames => Ok(Self { rate_hz, channels, frames }),
                    };
                }
                _ => {}
            }
            // Chunks start at even offsets.
            at = body + size as usize + (size % 2) as usize;
        }
        Err("it has no samples")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a WAV file with an unrelated chunk, the format, and `frames` silent samples per channel.
    fn wav(tag: u16, channels: u16, rate_hz: u32, bits: u16, frames: u32) -> Vec<u8> {
        let frame = channels * bits / 8;
        let size = frames * u32::from(frame);
        let mut bytes = b"RIFF\0\0\0\0WAVELIST\x03\0\0\0abc\0fmt \x10\0\0\0".to_vec();
        bytes.extend([tag.to_le_bytes(), channels.to_le_bytes()].concat());
        bytes.extend([rate_hz.to_le_bytes(), (rate_hz * u32::from(frame)).to_le_bytes()].concat());
        bytes.extend([frame.to_le_bytes(), bits.to_le_bytes()].concat());
        bytes.extend([b"data".as_slice(), &size.to_le_bytes()].concat());
        bytes.resize(bytes.len() + size as usize, 0);
        bytes
    }

    fn read(bytes: &[u8]) -> Result<SpokenText, String> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("it.wav"), bytes).unwrap();
        SpokenFiles::One("it.wav".into()).read(folder.path(), None).map_err(|fault| fault.to_string())
    }

    #[test]
    fn a_pcm_file_has_its_length_and_other_files_are_refused() {
        // 66,150 samples at 44.1 kHz last 1.5 s.
        let spoken = read(&wav(1, 2, 44_100, 16, 66_150)).unwrap();
        assert_eq!((spoken.to_string().as_str(), spoken.channels), ("it.wav, 1.5 s, 44100 Hz, stereo", 2));
        assert_eq!(read(&wav(1, 1, 8000, 24, 4000)).unwrap().length_s, 0.5);
        let cut = wav(1, 1, 8000, 16, 100);
        for (bytes, has) in [
            (wav(3, 1, 8000, 32, 10), "not PCM"),
            (wav(1, 6, 8000, 16, 10), "channels, rate or bits"),
            (wav(1, 1, 8000, 12, 10), "channels, rate or bits"),
            (wav(1, 1, 8000, 16, 0), "it is empty"),
            (cut[..cut.len() - 1].to_vec(), "it is cut"),
            (cut[..36].to_vec(), "it is cut"),
            (cut[..24].to_vec(), "no samples"),
            (b"ID3 an mp3 file".to_vec(), "RIFF and WAVE"),
            (Vec::new(), "RIFF and WAVE"),
        ] {
            let message = read(&bytes).unwrap_err();
            assert!(message.contains(has) && message.contains("it.wav"), "{message}");
        }
    }

    #[test]
    fn the_studys_language_chooses_the_file() {
        let files: BTreeMap<String, PathBuf> =
            [("en", "a.wav"), ("de", "b.wav")].map(|(word, file)| (word.to_owned(), file.into())).into();
        let files = SpokenFiles::ByLanguage(files);
        assert_eq!(files.chosen(Some("de")).unwrap(), Path::new("b.wav"));
        let message = files.chosen(None).unwrap_err().to_string();
        assert!(message.contains("come in de, en; name the spoken language at the top"), "{message}");
        let message = files.chosen(Some("fr")).unwrap_err().to_string();
        assert!(message.contains("language is \"fr\"; the instructions come in de, en"), "{message}");
    }
}
