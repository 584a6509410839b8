//! Outputs of `codrive replay` beside the proof: pictures, a video, the sound, or a window to play the drive in.

use super::render;
use crate::{
    cli::{CliError, flags, stop_on_ctrl_c},
    private,
    replay::{Replay, ReplayRenderer, ReplayReport, SoundTrack, window},
    time::Tick,
};
use clap::{Arg, ArgAction, ArgMatches, value_parser};
use std::{
    path::{Path, PathBuf},
    process,
};

pub(in crate::cli) const ABOUT: &str =
    "Drive a recording again from its inputs and prove that every tick is the same; draw it";

/// Last sentence of the help.
pub(in crate::cli) const DRAWS: &str = " Without --png, --frames-dir and --video nothing is drawn.";

pub(in crate::cli) fn arguments() -> Vec<Arg> {
    let named = |name, value, help| Arg::new(name).long(name).value_name(value).help(help);
    let path = |name, value, help| named(name, value, help).value_parser(value_parser!(PathBuf));
    let mut arguments = vec![
        Arg::new("window")
            .long("window")
            .action(ArgAction::SetTrue)
            .conflicts_with_all(["png", "frames-dir", "video", "what-if"])
            .help("Play it in a window: any view, 0.25 to 16 times as fast, tick by tick, with a timeline to seek on"),
        named("png", "FILE.png", "One picture, at --at")
            .value_parser(flags::file_with_ending("png"))
            .conflicts_with("what-if"),
        path("frames-dir", "DIR", "All pictures, numbered, in a new folder").conflicts_with("what-if"),
        path("video", "FILE.mp4", "All pictures as a video, with the sound if --wav is named; needs ffmpeg")
            .conflicts_with("what-if"),
        named("wav", "FILE.wav", "The drive's sound at its scenario's levels, as long as the drive")
            .value_parser(flags::file_with_ending("wav")),
        Arg::new("at")
            .long("at")
            .value_name("SECS")
            .value_parser(value_parser!(f64))
            .help("When --png is drawn [default: 60], or where --window begins [default: 0], seconds from the start of the drive"),
    ];
    arguments.extend(render::picture_arguments());
    arguments.push(
        Arg::new("rate")
            .long("rate")
            .value_name("HZ")
            .default_value("25")
            .value_parser(value_parser!(u32).range(1..=100))
            .help("Frames per second of simulation, 1 to 100"),
    );
    arguments
}

/// Plays a recording in a window, if `--window` is given. Returns the result of the proof and the number of recorded ticks.
pub(in crate::cli) fn play(recording: &Path, matches: &ArgMatches) -> Option<Result<(ReplayReport, u64), CliError>> {
    matches.get_flag("window").then(|| {
        let at_s = matches.get_one::<f64>("at").copied().unwrap_or_default();
        let options = window::ReplayOptions {
            recording: recording.to_owned(),
            kind: view_kind(matches),
            at_s,
            stop: stop_on_ctrl_c(),
        };
        Ok(window::run(&options)?)
    })
}

fn view_kind(matches: &ArgMatches) -> crate::scene::ViewKind {
    render::view_kind(matches.get_one::<String>("view").map_or("driver", String::as_str))
}

/// Files written during a replay.
pub(in crate::cli) struct Outputs {
    png: Option<(PathBuf, Tick)>,
    frames: Option<PathBuf>,
    video: Option<(PathBuf, VideoEncoder)>,
    sound: Option<(PathBuf, SoundTrack)>,
    renderer: Option<ReplayRenderer>,
    /// Frames per second of simulated time.
    rate: u32,
    /// Number of frames written.
    written: u64,
}

impl Outputs {
    pub(in crate::cli) fn begin(recording: &Path, replay: &Replay, matches: &ArgMatches) -> Result<Self, CliError> {
        let path = |name: &str| matches.get_one::<PathBuf>(name);
        let size = matches.get_one::<[u32; 2]>("size").copied().unwrap_or([1280, 720]);
        let rate = matches.get_one::<u32>("rate").copied().unwrap_or(25);
        let at = Tick::at_seconds(matches.get_one::<f64>("at").copied().unwrap_or(60.0));
        let draws = [path("png"), path("frames-dir"), path("video")].iter().any(Option::is_some);
        let renderer = draws.then(|| ReplayRenderer::new(replay, view_kind(matches), size)).transpose()?;
        let sound = |file: &PathBuf| Ok::<_, CliError>((file.clone(), SoundTrack::begin(file, replay, recording)?));
        let sound = path("wav").map(sound).transpose()?;
        let video = |file: &PathBuf| Ok::<_, CliError>((file.clone(), VideoEncoder::begin(file, size, rate)?));
        let video = path("video").map(video).transpose()?;
        let frames = path("frames-dir").map(|folder| new_folder(folder)).transpose()?.map(Path::to_owned);
        let png = path("png").map(|file| (file.clone(), at));
        Ok(Self { png, frames, video, sound, renderer, rate, written: 0 })
    }

    /// Writes what is due at a tick; called after each tick of the replay.
    pub(in crate::cli) fn tick(&mut self, replay: &Replay) -> Result<(), CliError> {
        if let Some((_, track)) = &mut self.sound {
            track.tick(replay)?;
        }
        let Some(renderer) = &mut self.renderer else { return Ok(()) };
        let tick = replay.world().snapshot().tick;
        // A frame is due at the last tick of its interval.
        let is_due = tick.0 * u64::from(self.rate) / 100 > self.written;
        if is_due && (self.video.is_some() || self.frames.is_some()) {
            let picture = renderer.draw(replay)?;
            if let Some(folder) = &self.frames {
                render::save(&picture, &folder.join(format!("{:06}.png", self.written)))?;
            }
            if let Some((_, video)) = &mut self.video {
                video.add(&picture)?;
            }
            self.written += 1;
        }
        match &self.png {
            Some((file, at)) if tick == *at => render::save(&renderer.draw(replay)?, file),
            _ => Ok(()),
        }
    }

    /// Finishes the files; called after the last tick.
    pub(in crate::cli) fn end(self, replay: &Replay) -> Result<(), CliError> {
        let sound = self.sound.map(|(file, track)| track.end().map(|()| file)).transpose()?;
        let video = self.video.map(|(file, video)| video.end().map(|()| file)).transpose()?;
        if let (Some(video), Some(sound)) = (&video, &sound) {
            join(video, sound)?;
        }
        match self.png {
            Some((_, at)) if at.0 > replay.len() => Err(CliError::Input(format!(
                "--at is {} s, after the end of the recording at {} s",
                at.seconds(),
                Tick(replay.len()).seconds()
            ))),
            _ => Ok(()),
        }
    }
}

fn new_folder(folder: &Path) -> Result<&Path, CliError> {
    if folder.symlink_metadata().is_ok() {
        return Err(CliError::Input(format!("{} exists; nothing is overwritten", folder.display())));
    }
    private::folder(folder).map_err(|error| CliError::Input(format!("{}: {error}", folder.display())))?;
    Ok(folder)
}

/// Makes the new, private file that ffmpeg will fill.
fn reserve(file: &Path) -> Result<(), CliError> {
    private::file(file).map(drop).map_err(|error| match error.kind() {
        std::io::ErrorKind::AlreadyExists => {
            CliError::Input(format!("{} exists; nothing is overwritten", file.display()))
        }
        _ => CliError::Failed(format!("{}: {error}", file.display())),
    })
}

/// Joins sound and video in the video's file. The sound's own file stays.
fn join(video: &Path, sound: &Path) -> Result<(), CliError> {
    let mute = video.with_extension("mute.mp4");
    let failed = |error: std::io::Error| CliError::Failed(format!("{}: {error}", video.display()));
    if mute.symlink_metadata().is_ok() {
        return Err(CliError::Failed(format!("{} is in the way; the video has no sound", mute.display())));
    }
    std::fs::rename(video, &mute).map_err(failed)?;
    reserve(video)?;
    let status = process::Command::new("ffmpeg")
        .args(["-loglevel", "error", "-i"])
        .arg(&mute)
        .arg("-i")
        .arg(sound)
        .args(["-c:v", "copy", "-c:a", "aac", "-b:a", "160k", "-shortest", "-y"])
        .arg(video)
        .status();
    match status {
        Ok(status) if status.success() => std::fs::remove_file(&mute).map_err(failed),
        _ => {
            let kept = mute.display();
            Err(CliError::Failed(format!(
                "ffmpeg could not join video and sound; they lie in {kept} and {}",
                sound.display()
            )))
        }
    }
}

/// ffmpeg process, fed with raw pictures.
struct VideoEncoder {
    ffmpeg: process::Child,
}

impl VideoEncoder {
    fn begin(file: &Path, [width, height]: [u32; 2], rate: u32) -> Result<Self, CliError> {
        reserve(file)?;
        let (size, rate) = (format!("{width}x{height}"), rate.to_string());
        let raw = ["-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgba", "-s", &size, "-r", &rate, "-i", "-"];
        let ffmpeg = process::Command::new("ffmpeg")
            .args(raw)
            .args(["-pix_fmt", "yuv420p", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-y"])
            .arg(file)
            .stdin(process::Stdio::piped())
            .spawn();
        ffmpeg.map(|ffmpeg| Self { ffmpeg }).map_err(|error| {
            CliError::Failed(format!("ffmpeg cannot be started: {error}; install it, or take --frames-dir"))
        })
    }

    fn add(&mut self, picture: &image::RgbaImage) -> Result<(), CliError> {
        let input = self.ffmpeg.stdin.as_mut().expect("piped");
        std::io::Write::write_all(input, picture).map_err(|e| CliError::Failed(format!("ffmpeg takes no more: {e}")))
    }

    fn end(mut self) -> Result<(), CliError> {
        drop(self.ffmpeg.stdin.take());
        match self.ffmpeg.wait() {
            Ok(status) if status.success() => Ok(()),
            Ok(status) => Err(CliError::Failed(format!("ffmpeg failed: {status}"))),
            Err(error) => Err(CliError::Failed(format!("ffmpeg: {error}"))),
        }
    }
}
