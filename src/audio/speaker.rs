//! Sound to a device, by cpal. In: a [`SoundScene`] per frame. Out: samples played by the device. The numbers are
//! transferred without a lock, each by itself: the device's thread never waits, and a mixture of two frames glides like
//! any other change. Without a device there is silence, which is logged once.

use super::{Mixer, SoundScene, sound_scene::WORDS};
use crate::scenario::SoundLevels;
use cpal::{
    FromSample, SampleFormat, SizedSample, StreamConfig, SupportedBufferSize,
    traits::{DeviceTrait, HostTrait, StreamTrait},
};
use std::{
    sync::{
        Arc,
        atomic::{AtomicBool, AtomicU32, Ordering},
        mpsc::{self, RecvTimeoutError, Sender},
    },
    thread::JoinHandle,
    time::Duration,
};

/// Requested buffer size of a device, samples: 11 ms at 48 kHz.
const BUFFER: u32 = 512;
/// Number of samples mixed at a time.
const CHUNK: usize = 64;
/// Interval at which a thread looks after its device.
pub(super) const LOOK: Duration = Duration::from_millis(20);
/// Number of looks without a request for samples after which a device counts as lost: half a second. Devices ask for a buffer every few
/// hundredths of a second.
const LOST_LOOKS: u32 = 25;

/// Requests of a device for samples, the only sign that it plays.
#[derive(Default)]
pub(super) struct DeviceRequests {
    count: Arc<AtomicU32>,
    seen: u32,
    idle_looks: u32,
}

impl DeviceRequests {
    /// Returns the counter of requests, to be raised with each.
    pub fn counter(&self) -> Arc<AtomicU32> {
        Arc::clone(&self.count)
    }

    /// Looks once. Returns true once the device has asked for samples and not stopped since; `None` while it has neither asked nor had the
    /// time to.
    pub fn look(&mut self) -> Option<bool> {
        let count = self.count.load(Ordering::Relaxed);
        self.idle_looks = if count == self.seen { self.idle_looks + 1 } else { 0 };
        self.seen = count;
        let is_lost = self.idle_looks >= LOST_LOOKS;
        (is_lost || count > 0).then_some(!is_lost)
    }
}

/// Sound scene shared between two threads.
struct SharedScene([AtomicU32; WORDS]);

impl SharedScene {
    fn new() -> Self {
        let board = Self(std::array::from_fn(|_| AtomicU32::new(0)));
        board.put(&SoundScene::default());
        board
    }

    fn put(&self, sound_scene: &SoundScene) {
        for (place, word) in self.0.iter().zip(sound_scene.to_words()) {
            place.store(word.to_bits(), Ordering::Relaxed);
        }
    }

    fn get(&self) -> SoundScene {
        SoundScene::from_words(&std::array::from_fn(|i| f32::from_bits(self.0[i].load(Ordering::Relaxed))))
    }
}

/// An audio output, or a stand-in if there is none. It opens and closes on a thread of its own, because a sound server
/// may take a while.
pub struct Speaker {
    board: Arc<SharedScene>,
    plays: Arc<AtomicBool>,
    close: Option<Sender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Speaker {
    /// Starts to open the system's default output. If there is none, the speaker stays silent and logs this once.
    pub fn open(levels: SoundLevels) -> Self {
        let board = Arc::new(SharedScene::new());
        let plays = Arc::new(AtomicBool::new(false));
        let (close, closed) = mpsc::channel::<()>();
        let (theirs, playing) = (Arc::clone(&board), Arc::clone(&plays));
        let started = std::thread::Builder::new().name("sound".into()).spawn(move || {
            let mut requests = DeviceRequests::default();
            match start(&levels, theirs, requests.counter()) {
                Ok(stream) => {
                    // Until the other end is dropped.
                    while closed.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                        let plays = requests.look() == Some(true);
                        if playing.swap(plays, Ordering::Relaxed) && !plays {
                            log::warn!("the sound device asks for no more samples; continuing without sound");
                        }
                    }
                    drop(stream);
                }
                Err(why) => log::warn!("no sound: {why}; continuing without sound"),
            }
        });
        let thread = started.map_err(|e| log::warn!("no sound: its thread cannot start ({e})")).ok();
        Self { board, plays, close: Some(close), thread }
    }

    /// Plays this scene from now on.
    pub fn play(&self, sound_scene: &SoundScene) {
        self.board.put(sound_scene);
    }

    /// Returns true while a device plays: it asks for samples.
    pub fn plays(&self) -> bool {
        self.plays.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
impl Speaker {
    /// Returns a speaker without a thread whose device plays or does not.
    pub(crate) fn stand_in(plays: bool) -> Self {
        Self { board: Arc::new(SharedScene::new()), plays: Arc::new(AtomicBool::new(plays)), close: None, thread: None }
    }

    /// Sets whether the device plays.
    pub(crate) fn set_plays(&self, plays: bool) {
        self.plays.store(plays, Ordering::Relaxed);
    }
}

impl Drop for Speaker {
    fn drop(&mut self) {
        self.close = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// Reason that there is no sound.
#[derive(Debug, thiserror::Error)]
pub enum SpeakerFault {
    /// Linux has no sound card and no sound server.
    #[error("the system has no sound card and no sound server")]
    NoSound,
    /// The system has no default output.
    #[error("the system has no audio output")]
    NoOutput,
    /// The output needs an unsupported sample format.
    #[error("the output needs samples of type {0}; this program cannot write them")]
    Samples(SampleFormat),
    /// The output cannot be queried, opened or started.
    #[error("{0}")]
    Device(#[from] cpal::Error),
}

/// Opens the output for a moment and returns its name, rate and channels.
///
/// # Errors
/// There is no output, or it cannot be opened.
pub fn output() -> Result<String, SpeakerFault> {
    let (device, config, format) = device()?;
    drop(build(&device, config, format, |out: &mut [[f32; 2]]| out.fill([0.0; 2]))?);
    let name = device.description().map_or_else(|_| "an output".to_owned(), |about| about.name().to_owned());
    Ok(format!("{name}, {} Hz, {} channels", config.sample_rate, config.channels))
}

fn device() -> Result<(cpal::Device, StreamConfig, SampleFormat), SpeakerFault> {
    // ALSA's library prints its own messages; without any card it is not called.
    if cfg!(target_os = "linux") && !there_may_be_sound() {
        return Err(SpeakerFault::NoSound);
    }
    let device = cpal::default_host().default_output_device().ok_or(SpeakerFault::NoOutput)?;
    let supported = device.default_output_config()?;
    let mut config: StreamConfig = supported.config();
    if let SupportedBufferSize::Range { min, max } = supported.buffer_size()
        && (*min..=*max).contains(&BUFFER)
    {
        config.buffer_size = cpal::BufferSize::Fixed(BUFFER);
    }
    Ok((device, config, supported.sample_format()))
}

/// Checks for a sound card of the kernel, or the socket of a sound server.
pub(super) fn there_may_be_sound() -> bool {
    let card = std::fs::read_to_string("/proc/asound/cards").is_ok_and(|text| text.contains("]: "));
    let server = std::env::var_os("PULSE_SERVER").is_some()
        || std::env::var_os("XDG_RUNTIME_DIR").is_some_and(|folder| {
            ["pulse/native", "pipewire-0"].iter().any(|socket| std::path::Path::new(&folder).join(socket).exists())
        });
    card || server
}

fn start(
    levels: &SoundLevels,
    board: Arc<SharedScene>,
    requests: Arc<AtomicU32>,
) -> Result<cpal::Stream, SpeakerFault> {
    stream(|rate_hz| {
        let (mut mixer, board) = (Mixer::new(levels, rate_hz as f32), Arc::clone(&board));
        let requests = Arc::clone(&requests);
        move |out: &mut [[f32; 2]]| {
            requests.fetch_add(1, Ordering::Relaxed);
            mixer.render(&board.get(), out);
        }
    })
}

/// Opens the output and plays the samples that `source` makes for its rate.
pub(super) fn stream<R>(source: impl Fn(u32) -> R) -> Result<cpal::Stream, SpeakerFault>
where
    R: FnMut(&mut [[f32; 2]]) + Send + 'static,
{
    let (device, config, format) = device()?;
    let stream = build(&device, config, format, source(config.sample_rate)).or_else(|error| {
        // Some devices report a range of buffer sizes but accept none of it.
        let usual = StreamConfig { buffer_size: cpal::BufferSize::Default, ..config };
        build(&device, usual, format, source(config.sample_rate)).map_err(|_| error)
    })?;
    stream.play()?;
    Ok(stream)
}

fn build(
    device: &cpal::Device,
    config: StreamConfig,
    format: SampleFormat,
    render: impl FnMut(&mut [[f32; 2]]) + Send + 'static,
) -> Result<cpal::Stream, SpeakerFault> {
    match format {
        SampleFormat::F32 => build_as::<f32>(device, config, render),
        SampleFormat::I32 => build_as::<i32>(device, config, render),
        SampleFormat::I16 => build_as::<i16>(device, config, render),
        SampleFormat::U16 => build_as::<u16>(device, config, render),
        SampleFormat::U8 => build_as::<u8>(device, config, render),
        other => Err(SpeakerFault::Samples(other)),
    }
}

fn build_as<T: SizedSample + FromSample<f32> + Send + 'static>(
    device: &cpal::Device,
    config: StreamConfig,
    mut render: impl FnMut(&mut [[f32; 2]]) + Send + 'static,
) -> Result<cpal::Stream, SpeakerFault> {
    let channels = usize::from(config.channels.max(1));
    let fill = move |data: &mut [T], _: &cpal::OutputCallbackInfo| {
        let mut mixed = [[0.0; 2]; CHUNK];
        for part in data.chunks_mut(CHUNK * channels) {
            let count = part.len() / channels;
            render(&mut mixed[..count]);
            for (frame, sample) in part.chunks_mut(channels).zip(&mixed) {
                put(frame, *sample);
            }
        }
    };
    let is_logged = AtomicBool::new(false);
    let fault = move |error: cpal::Error| {
        if !is_logged.swap(true, Ordering::Relaxed) {
            log::warn!("sound: {error}");
        }
    };
    Ok(device.build_output_stream(config, fill, fault, None)?)
}

/// Writes one sample to all channels of a device: left and right to the first two, their mean to a single one.
fn put<T: SizedSample + FromSample<f32>>(frame: &mut [T], [left, right]: [f32; 2]) {
    match frame {
        [one] => *one = T::from_sample((left + right) / 2.0),
        [first, second, rest @ ..] => {
            (*first, *second) = (T::from_sample(left), T::from_sample(right));
            rest.fill(T::EQUILIBRIUM);
        }
        [] => {}
    }
}

#[cfg(test)]
mod tests {
    use super::{
        super::{NearbyVehicle, SoundSource},
        *,
    };

    #[test]
    fn a_scene_reaches_the_other_thread_unchanged() {
        let board = SharedScene::new();
        assert_eq!(board.get(), SoundScene::default());
        let mut sound_scene =
            SoundScene { running: true, speed_mps: -1.5, engine_rpm: 2100.0, contacts: 3, ..SoundScene::default() };
        sound_scene.horn = true;
        for (at, source) in [(4, SoundSource::Motor), (5, SoundSource::Feet), (7, SoundSource::Bicycle)] {
            sound_scene.near[at] =
                Some(NearbyVehicle { source, ahead_m: -7.0, left_m: 2.0, speed_mps: 5.0, steps: 1_000_001 });
        }
        board.put(&sound_scene);
        assert_eq!(board.get(), sound_scene);
    }

    #[test]
    fn a_device_plays_while_it_asks_for_samples_and_no_longer() {
        let mut requests = DeviceRequests::default();
        let counter = requests.counter();
        assert_eq!(requests.look(), None, "it has had no time");
        counter.fetch_add(3, Ordering::Relaxed);
        assert_eq!(requests.look(), Some(true));
        // A buffer of a quarter of a second is no loss, half a second is; another request is sound again.
        assert!((0..13).all(|_| requests.look() == Some(true)));
        counter.fetch_add(1, Ordering::Relaxed);
        let later: Vec<_> = (0..27).map(|_| requests.look()).collect();
        assert_eq!((later[24], later[25], later[26]), (Some(true), Some(false), Some(false)));
        counter.fetch_add(1, Ordering::Relaxed);
        assert_eq!(requests.look(), Some(true));
        let mut silent = DeviceRequests::default();
        assert_eq!((0..25).filter_map(|_| silent.look()).collect::<Vec<_>>(), [false], "a device that never asks");
    }

    #[test]
    fn every_number_of_channels_gets_left_and_right() {
        let mut stereo = [0.0f32; 2];
        put(&mut stereo, [0.5, -0.25]);
        assert_eq!(stereo, [0.5, -0.25]);
        let mut mono = [0i16];
        put(&mut mono, [0.5, 0.5]);
        assert_eq!(mono, [16_384]);
        let mut four = [9.0f32; 4];
        put(&mut four, [0.5, -0.25]);
        assert_eq!(four, [0.5, -0.25, 0.0, 0.0]);
    }
}
