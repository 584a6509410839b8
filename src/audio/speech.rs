//! Speech, by the program espeak-ng. In: a sentence in English. Out: a WAV file in memory, or the reason why there is none.

use std::{
    io,
    process::{Command, Output, Stdio},
    sync::Arc,
};

/// Program that speaks, looked up in the search path.
const PROGRAM: &str = "espeak-ng";
/// Voice and speed, words a minute: slower than its default of 175, for listeners who drive.
const OPTIONS: [&str; 4] = ["-v", "en-gb", "-s", "155"];

/// Reason that a sentence cannot be spoken.
#[derive(Debug, thiserror::Error)]
pub enum SpeechFault {
    /// The program is not installed.
    #[error("the program {PROGRAM} is not installed; install it with: sudo apt install {PROGRAM}")]
    NotInstalled,
    /// The program cannot be run.
    #[error("{PROGRAM} cannot be run: {0}")]
    NotRun(#[from] io::Error),
    /// The program ended without speech.
    #[error("{PROGRAM} ended with {status}: {message}")]
    Failed { status: std::process::ExitStatus, message: String },
}

/// Returns the program's name and version.
///
/// # Errors
/// The program is not installed, or cannot be run.
pub fn speech_program() -> Result<String, SpeechFault> {
    let output = run(&["--version"])?;
    Ok(String::from_utf8_lossy(&output.stdout).lines().next().unwrap_or(PROGRAM).trim().to_owned())
}

/// Returns a sentence as a WAV file.
///
/// # Errors
/// The program is not installed, cannot be run, or fails.
pub fn spoken(sentence: &str) -> Result<Arc<[u8]>, SpeechFault> {
    let mut arguments = OPTIONS.to_vec();
    arguments.extend(["--stdout", "--", sentence]);
    Ok(with_sizes(run(&arguments)?.stdout).into())
}

fn run(arguments: &[&str]) -> Result<Output, SpeechFault> {
    let output =
        Command::new(PROGRAM).args(arguments).stdin(Stdio::null()).output().map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => SpeechFault::NotInstalled,
            _ => SpeechFault::NotRun(error),
        })?;
    if !output.status.success() {
        let message = String::from_utf8_lossy(&output.stderr).trim().to_owned();
        return Err(SpeechFault::Failed { status: output.status, message });
    }
    Ok(output)
}

/// Returns a WAV file with the sizes of its RIFF and data chunks: a program that writes to a pipe does not know them before its end.
fn with_sizes(mut wav: Vec<u8>) -> Vec<u8> {
    const HEADER: usize = 44;
    if wav.len() >= HEADER && wav[36..40] == *b"data" {
        for (at, before) in [(4, 8), (40, HEADER)] {
            let size = u32::try_from(wav.len() - before).unwrap_or(u32::MAX);
            wav[at..at + 4].copy_from_slice(&size.to_le_bytes());
        }
    }
    wav
}

#[cfg(test)]
mod tests {
    use super::*;
    use hound::WavReader;

    #[test]
    fn a_sentence_becomes_speech_of_its_length() {
        let length_s = |sentence: &str| {
            let wav = spoken(sentence).expect("espeak-ng is installed by scripts/setup --test");
            let mut reader = WavReader::new(&wav[..]).expect("a WAV file");
            let rate_hz = f64::from(reader.spec().sample_rate);
            let samples: Vec<i16> = reader.samples().collect::<Result<_, _>>().expect("16 bits");
            assert!(samples.iter().any(|sample| sample.unsigned_abs() > 3000), "it is heard");
            samples.len() as f64 / rate_hz
        };
        // 155 words a minute are 0.39 s a word; short words take less, and there is a pause at the end.
        let (short_s, long_s) = (length_s("Turn left."), length_s("In 200 metres, turn left at the roundabout."));
        assert!((0.4..1.6).contains(&short_s) && (1.6..4.5).contains(&long_s), "{short_s} {long_s}");
        assert!(speech_program().expect("installed").contains("eSpeak"));
    }
}
