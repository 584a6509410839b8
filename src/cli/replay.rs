//! `codrive replay`: a recorded drive once more, with the proof that it is the same; a picture of it, all of
//! them, a window; or the same with something changed.

use super::{CliError, out, render, stop_on_ctrl_c};
use crate::{
    private,
    record::{self, LOST_AND_FOUND, Table},
    replay::{self, Replay, ReplayRenderer, ReplayReport, SoundTrack, window},
    time::Tick,
};
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use std::{
    path::{Path, PathBuf},
    process,
    sync::atomic::Ordering,
};

pub(super) fn command() -> Command {
    let path =
        |name, value, help| Arg::new(name).long(name).value_name(value).value_parser(value_parser!(PathBuf)).help(help);
    Command::new("replay")
        .about("Drive a recording again from its inputs and prove that every tick is the same; draw it")
        .after_help("Every column of every table that a drive makes is compared bit by bit, every other file by its SHA-256. Exit code 1 where something differs. Without --png, --frames and --video nothing is drawn.")
        .arg(
            Arg::new("recording")
                .value_name("DIR")
                .required(true)
                .value_parser(value_parser!(PathBuf))
                .help("A recording"),
        )
        .arg(
            Arg::new("window")
                .long("window")
                .action(ArgAction::SetTrue)
                .conflicts_with_all(["png", "frames", "video", "what-if"])
                .help("Play it in a window: any view, 0.25 to 16 times as fast, tick by tick, a line to seek on"),
        )
        .arg(
            Arg::new("what-if")
                .long("what-if")
                .value_name("SETTING=VALUE")
                .action(ArgAction::Append)
                .conflicts_with_all(["png", "frames", "video"])
                .help(
                    "Drive the same seed and scenario with this changed, by a simulated driver, and print what differs: \
                     policy=NAME, driver=perfect, hold_s=5; none: no advice, car-following model. May be given several times",
                ),
        )
        .arg(path("out", "DIR", "Where --what-if records [default: beside the recording, DIR-what-if-...]"))
        .arg(path("png", "FILE.png", "One picture, at --at"))
        .arg(path("frames", "DIR", "All pictures, numbered, in a new folder"))
        .arg(path("video", "FILE.mp4", "All pictures as a video, with the sound if --sound is named; needs ffmpeg"))
        .arg(path("sound", "FILE.wav", "The drive's sound at its scenario's levels, as long as the drive"))
        .arg(
            Arg::new("at")
                .long("at")
                .value_name("SECS")
                .value_parser(value_parser!(f64))
                .help("When --png is drawn [default: 60], or where --window begins [default: 0], seconds from the start of the drive"),
        )
        .args(render::picture_arguments())
        .arg(
            Arg::new("rate")
                .long("rate")
                .value_name("HZ")
                .default_value("25")
                .value_parser(value_parser!(u32).range(1..=100))
                .help("Pictures in a second of simulation, 1 to 100"),
        )
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let path = |name: &str| matches.get_one::<PathBuf>(name);
    let Some(recording) = path("recording") else { return Ok(()) };
    let size = matches.get_one::<[u32; 2]>("size").copied().unwrap_or([1280, 720]);
    let rate = matches.get_one::<u32>("rate").copied().unwrap_or(25);
    let at_s = matches.get_one::<f64>("at").copied();
    let at = Tick::at_seconds(at_s.unwrap_or(60.0));
    let kind = render::view_kind(matches.get_one::<String>("view").map_or("driver", String::as_str));
    if let Some(asked) = matches.get_many::<String>("what-if") {
        return instead(recording, &asked.cloned().collect::<Vec<_>>(), path("out"));
    }
    if matches.get_flag("window") {
        let (recording, at_s) = (recording.clone(), at_s.unwrap_or_default());
        let stop = stop_on_ctrl_c();
        let (found, all) = window::run(&window::ReplayOptions { recording: recording.clone(), kind, at_s, stop })?;
        return say(&recording, &found, all);
    }
    let mut replay = Replay::open(recording)?;
    let drawn = [path("png"), path("frames"), path("video")].iter().any(Option::is_some);
    let mut easel = drawn.then(|| ReplayRenderer::new(&replay, kind, size)).transpose()?;
    let mut track = path("sound").map(|file| SoundTrack::begin(file, &replay, recording)).transpose()?;
    let mut film = path("video").map(|file| VideoEncoder::begin(file, size, rate)).transpose()?;
    let frames = path("frames").map(|folder| new_folder(folder)).transpose()?;

    let stop = stop_on_ctrl_c();
    let bar = super::progress(replay.len(), "driving again".into());
    let mut frame = 0;
    while !replay.over() && !stop.load(Ordering::Relaxed) {
        replay.advance(1)?;
        if let Some(track) = &mut track {
            track.tick(&replay)?;
        }
        let tick = replay.world().snapshot().tick;
        bar.set_position(tick.0);
        // The last tick of each picture's time.
        let due = tick.0 * u64::from(rate) / 100 > frame;
        if let (true, Some(easel)) = (due && (film.is_some() || frames.is_some()), &mut easel) {
            let picture = easel.draw(&replay)?;
            if let Some(folder) = frames {
                render::save(&picture, &folder.join(format!("{frame:06}.png")))?;
            }
            if let Some(film) = &mut film {
                film.add(&picture)?;
            }
            frame += 1;
        }
        if let (Some(file), Some(easel), true) = (path("png"), &mut easel, tick == at) {
            render::save(&easel.draw(&replay)?, file)?;
        }
    }
    bar.finish_and_clear();
    if let Some(track) = track {
        track.end()?;
    }
    if let Some(film) = film {
        film.end()?;
    }
    if let (Some(film), Some(sound)) = (path("video"), path("sound")) {
        join(film, sound)?;
    }
    if path("png").is_some() && at.0 > replay.len() {
        let end_s = Tick(replay.len()).seconds();
        return Err(CliError::Input(format!(
            "--at is {} s, after the end of the recording at {end_s} s",
            at.seconds()
        )));
    }
    say(recording, replay.verdict(), replay.len())
}

/// What the proof has found.
fn say(recording: &Path, found: &ReplayReport, all: u64) -> Result<(), CliError> {
    let (name, ticks) = (recording.display(), found.ticks);
    if found.is_proven() {
        let which = if ticks < all {
            format!("{ticks} of {all} ticks were driven again, all")
        } else {
            format!("all {all} ticks are")
        };
        let what = if found.changes.is_some() { "; every file is as it was written" } else { "" };
        out::line(format_args!("{name}: {which} the same to the bit{what}"))?;
        if found.changes.is_none() {
            out::line(format_args!(
                "It has no checksums (an earlier version wrote it): what devices and the screen did is not proven."
            ))?;
        }
        return Ok(());
    }
    let mut lines = vec![format!("{name}: not as it was recorded")];
    lines.extend(found.difference.as_ref().map(|first| format!("first difference: {first}")));
    if found.cells > 1 {
        lines.push(format!("cells and rows that differ: {} in {ticks} ticks", found.cells));
    }
    lines.extend(found.hole.map(|tick| format!("ego.parquet: rows are missing from {:.2} s on", tick.seconds())));
    lines.extend(found.changes.iter().flatten().map(ToString::to_string));
    if recording.join(LOST_AND_FOUND).exists() {
        lines.push(format!(
            "rows could not be read when it was recovered: {LOST_AND_FOUND}/ in it holds what they were read from"
        ));
    } else if found.changes.as_ref().is_none_or(Vec::is_empty) {
        lines.push("The files are as they were written: another version of the program or of SUMO, or another map, does that; compare manifest.json".into());
    }
    Err(CliError::Failed(lines.join("\n  ")))
}

/// The same drive with something changed.
fn instead(recording: &Path, asked: &[String], out: Option<&PathBuf>) -> Result<(), CliError> {
    let changes = replay::changes(asked).map_err(CliError::Input)?;
    let words = replay::words(&changes);
    let beside = || {
        let slug: String = words.chars().map(|c| if c.is_alphanumeric() || c == '.' { c } else { '-' }).collect();
        let mut name = recording.file_name().unwrap_or_default().to_owned();
        name.push(format!("-what-if-{}", slug.replace("--", "-")));
        recording.with_file_name(name)
    };
    let out = out.cloned().unwrap_or_else(beside);
    let stop = stop_on_ctrl_c();
    let ticks = record::count(recording, Table::Ego).unwrap_or(0);
    let bar = super::progress(2 * ticks, format!("what if {words}"));
    let pair = replay::what_if(recording, &changes, &out, &stop, &|ticks| bar.inc(ticks));
    bar.finish_and_clear();
    let Some(pair) = pair? else {
        return Err(CliError::Failed(format!("stopped; {} holds what was driven", out.display())));
    };
    out::line(format_args!("{}, instead with {words}", recording.display()))?;
    if asked.iter().any(|word| word == "none") {
        out::line(format_args!("none stands for both: no advice, and the car-following model in the driver's place"))?;
    }
    if !pair.is_proven {
        out::line(format_args!(
            "the recorded drive could not be driven again to the bit: codrive replay {}",
            recording.display()
        ))?;
    }
    out::text(pair.table())?;
    out::line(format_args!("recorded in              {}", out.display()))?;
    Ok(())
}

fn new_folder(folder: &Path) -> Result<&Path, CliError> {
    if folder.symlink_metadata().is_ok() {
        return Err(CliError::Input(format!("{} exists; nothing is overwritten", folder.display())));
    }
    private::folder(folder).map_err(|error| CliError::Input(format!("{}: {error}", folder.display())))?;
    Ok(folder)
}

/// Makes the file that ffmpeg is to fill: new, and the user's alone.
fn reserve(file: &Path) -> Result<(), CliError> {
    private::file(file).map(drop).map_err(|error| match error.kind() {
        std::io::ErrorKind::AlreadyExists => {
            CliError::Input(format!("{} exists; nothing is overwritten", file.display()))
        }
        _ => CliError::Failed(format!("{}: {error}", file.display())),
    })
}

/// Puts the sound into the film; the sound's own file stays.
fn join(film: &Path, sound: &Path) -> Result<(), CliError> {
    let mute = film.with_extension("mute.mp4");
    let failed = |error: std::io::Error| CliError::Failed(format!("{}: {error}", film.display()));
    if mute.symlink_metadata().is_ok() {
        return Err(CliError::Failed(format!("{} is in the way; the film has no sound", mute.display())));
    }
    std::fs::rename(film, &mute).map_err(failed)?;
    reserve(film)?;
    let status = process::Command::new("ffmpeg")
        .args(["-loglevel", "error", "-i"])
        .arg(&mute)
        .arg("-i")
        .arg(sound)
        .args(["-c:v", "copy", "-c:a", "aac", "-b:a", "160k", "-shortest", "-y"])
        .arg(film)
        .status();
    match status {
        Ok(status) if status.success() => std::fs::remove_file(&mute).map_err(failed),
        _ => {
            let kept = mute.display();
            Err(CliError::Failed(format!(
                "ffmpeg could not join film and sound; they lie in {kept} and {}",
                sound.display()
            )))
        }
    }
}

/// ffmpeg, fed with raw pictures.
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
            CliError::Failed(format!("ffmpeg cannot be started: {error}; install it, or take --frames"))
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
