//! Sound of the room to a file. In: the system's microphone. Out: a WAV file of one channel and 16 bits, and the number
//! of its samples, by which it is aligned with the ticks of a recording. The file stays readable if the program is cut
//! off. It records only if a study asks for it.

use super::file::new_wav;
use cpal::{
    FromSample, Sample, SampleFormat, SizedSample, StreamConfig,
    traits::{DeviceTrait, HostTrait, StreamTrait},
};
use std::{
    io,
    path::{Path, PathBuf},
    sync::{
        Arc, Mutex,
        mpsc::{self, RecvTimeoutError, Sender},
    },
    thread::JoinHandle,
    time::Duration,
};

/// Interval at which the thread checks whether to end.
const LOOK: Duration = Duration::from_millis(50);

/// State of a recording of the room.
#[derive(Clone, Debug, PartialEq)]
pub enum RoomStatus {
    /// The microphone is being opened.
    Opening,
    /// The microphone records to the file.
    Recording {
        /// Number of samples in the file so far.
        samples: u64,
        /// Sample rate of the file, Hz.
        rate_hz: u32,
    },
    /// The recording has failed, with the reason.
    Failed(String),
}

/// Reason that the room is not recorded.
#[derive(Debug, thiserror::Error)]
enum MicrophoneFault {
    #[error("the system has no microphone")]
    None,
    #[error("the microphone gives samples of type {0}; this program cannot read them")]
    Samples(SampleFormat),
    #[error("{0}")]
    Device(#[from] cpal::Error),
    #[error("{file}: {why}", file = .0.display(), why = .1)]
    File(PathBuf, io::Error),
}

/// A recording of the room; dropping it ends the file.
pub struct RoomRecording {
    status: Arc<Mutex<RoomStatus>>,
    close: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl RoomRecording {
    /// Starts a new file on a thread of its own; the microphone opens a little later.
    pub fn begin(path: &Path) -> Self {
        let status = Arc::new(Mutex::new(RoomStatus::Opening));
        let (close, closed) = mpsc::channel::<()>();
        let (theirs, path) = (Arc::clone(&status), path.to_owned());
        let started = std::thread::Builder::new().name("microphone".into()).spawn(move || {
            let failed = |why: MicrophoneFault| put(&theirs, RoomStatus::Failed(why.to_string()));
            let (to, samples) = mpsc::channel::<Vec<f32>>();
            match open(to) {
                Err(why) => failed(why),
                Ok((stream, rate_hz)) => {
                    let until = || closed.try_recv() == Err(mpsc::TryRecvError::Disconnected);
                    let now = |samples: u64| put(&theirs, RoomStatus::Recording { samples, rate_hz });
                    let written = write(&path, rate_hz, &samples, until, now);
                    drop(stream);
                    if let Err(why) = written {
                        failed(MicrophoneFault::File(path, why));
                    }
                }
            }
        });
        let thread =
            started.map_err(|e| put(&status, RoomStatus::Failed(format!("its thread cannot start: {e}")))).ok();
        Self { status, close: Some(close), thread }
    }

    /// Returns the current state.
    pub fn status(&self) -> RoomStatus {
        self.status.lock().map_or(RoomStatus::Opening, |status| status.clone())
    }
}

impl Drop for RoomRecording {
    fn drop(&mut self) {
        self.close = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn put(status: &Mutex<RoomStatus>, now: RoomStatus) {
    if let Ok(mut status) = status.lock() {
        *status = now;
    }
}

/// Opens the system's default microphone. Returns its stream and its rate, Hz.
fn open(to: Sender<Vec<f32>>) -> Result<(cpal::Stream, u32), MicrophoneFault> {
    if cfg!(target_os = "linux") && !super::speaker::there_may_be_sound() {
        return Err(MicrophoneFault::None);
    }
    let device = cpal::default_host().default_input_device().ok_or(MicrophoneFault::None)?;
    let supported = device.default_input_config()?;
    let config = supported.config();
    let stream = match supported.sample_format() {
        SampleFormat::F32 => build::<f32>(&device, config, to),
        SampleFormat::I32 => build::<i32>(&device, config, to),
        SampleFormat::I16 => build::<i16>(&device, config, to),
        SampleFormat::U16 => build::<u16>(&device, config, to),
        SampleFormat::U8 => build::<u8>(&device, config, to),
        other => return Err(MicrophoneFault::Samples(other)),
    }?;
    stream.play()?;
    Ok((stream, config.sample_rate))
}

fn build<T: SizedSample + Send + 'static>(
    device: &cpal::Device,
    config: StreamConfig,
    to: Sender<Vec<f32>>,
) -> Result<cpal::Stream, MicrophoneFault>
where
    f32: FromSample<T>,
{
    let channels = usize::from(config.channels.max(1));
    let take = move |data: &[T], _: &cpal::InputCallbackInfo| {
        let _ = to.send(mono(data, channels));
    };
    Ok(device.build_input_stream(config, take, |error| log::warn!("microphone: {error}"), None)?)
}

/// Returns the mean of the channels.
fn mono<T: Sample>(data: &[T], channels: usize) -> Vec<f32>
where
    f32: FromSample<T>,
{
    let mean = |frame: &[T]| frame.iter().map(|sample| f32::from_sample(*sample)).sum::<f32>() / frame.len() as f32;
    data.chunks_exact(channels).map(mean).collect()
}

/// Writes incoming samples until `until` is true or the sender is gone. The file's header is updated about once a
/// second.
fn write(
    path: &Path,
    rate_hz: u32,
    samples: &mpsc::Receiver<Vec<f32>>,
    until: impl Fn() -> bool,
    now: impl Fn(u64),
) -> io::Result<()> {
    let mut writer = new_wav(path, 1, rate_hz)?;
    let (mut count, mut kept) = (0_u64, 0_u64);
    loop {
        match samples.recv_timeout(LOOK) {
            Ok(part) => {
                for sample in &part {
                    let sample = (sample.clamp(-1.0, 1.0) * 32_767.0).round() as i16;
                    writer.write_sample(sample).map_err(super::file::to_io_error)?;
                }
                count += part.len() as u64;
                now(count);
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        if count - kept > u64::from(rate_hz) {
            kept = count;
            writer.flush().map_err(super::file::to_io_error)?;
        }
        if until() {
            break;
        }
    }
    writer.finalize().map_err(super::file::to_io_error)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    #[test]
    fn all_samples_of_the_microphone_are_in_the_file_and_counted() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("room.wav");
        let (to, samples) = mpsc::channel();
        // Two channels of 16 bits: the means are 0, a half, negative full scale.
        to.send(mono(&[0_i16, 0, 16_384, 16_384, -32_768, -32_768], 2)).unwrap();
        to.send(vec![0.25; 5]).unwrap();
        drop(to);
        let counts = RefCell::new(Vec::new());
        write(&path, 16_000, &samples, || false, |count| counts.borrow_mut().push(count)).unwrap();
        assert_eq!(counts.into_inner(), [3, 8]);
        let mut read = hound::WavReader::open(&path).unwrap();
        assert_eq!((read.spec().channels, read.spec().sample_rate, read.spec().bits_per_sample), (1, 16_000, 16));
        let found: Vec<i16> = read.samples::<i16>().map(Result::unwrap).collect();
        assert_eq!(found, [&[0, 16_384, -32_767][..], &[8192; 5]].concat());
        // An existing file is not overwritten.
        let (_to, samples) = mpsc::channel();
        assert!(write(&path, 16_000, &samples, || true, |_| ()).is_err());
    }

    #[test]
    fn a_recording_ends_on_request_with_a_complete_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("room.wav");
        let (to, samples) = mpsc::channel();
        to.send(vec![0.5; 10]).unwrap();
        write(&path, 8000, &samples, || true, |_| ()).unwrap();
        assert_eq!(hound::WavReader::open(&path).unwrap().duration(), 10);
        drop(to);
    }
}
