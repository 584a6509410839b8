//! `codrive render`: one picture of a drive, without a window.

use crate::cli::{CliError, flags, out};
use crate::{
    drive_loop::{RunError, offline::OfflineDrive},
    private,
    render::{DrivePictures, MAX_SIDE},
    scene::ViewKind,
};
use clap::{Arg, ArgMatches, Command, value_parser};
use image::{ImageFormat, RgbaImage};
use std::{
    io::Cursor,
    path::{Path, PathBuf},
    sync::Arc,
};

pub(super) fn command() -> Command {
    Command::new("render")
        .about("Draw one picture of a drive by the simulated driver, without a window")
        .arg(
            Arg::new("at")
                .long("at")
                .value_name("SECS")
                .default_value("60")
                .value_parser(value_parser!(f64))
                .help("Time of the picture, seconds from the start of the drive, 0 to 604800"),
        )
        .args(picture_arguments())
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("FILE.png")
                .required(true)
                .value_parser(flags::file_with_ending("png"))
                .help("File of the picture; an existing file is replaced"),
        )
}

/// Returns `--view` and `--size` of the commands that draw.
pub(super) fn picture_arguments() -> [Arg; 2] {
    let view = Arg::new("view")
        .long("view")
        .value_name("VIEW")
        .default_value("driver")
        .value_parser(ViewKind::NAMED.map(|(name, _)| name))
        .help("Camera view");
    let size = Arg::new("size")
        .long("size")
        .value_name("WxH")
        .default_value("1280x720")
        .value_parser(size)
        .help("Width and height, pixels, up to 8192 each");
    [view, size]
}

/// Parses a size such as 1280x720.
fn size(text: &str) -> Result<[u32; 2], String> {
    let sides = text.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    sides
        .filter(|sides: &[u32; 2]| sides.iter().all(|side| (1..=MAX_SIDE).contains(side)))
        .ok_or(format!("allowed: WIDTHxHEIGHT in pixels, each from 1 to {MAX_SIDE}, for example 1280x720"))
}

/// Returns the view of this name; the command line has checked it.
pub(super) fn view_kind(name: &str) -> ViewKind {
    ViewKind::NAMED.iter().find(|(known, _)| *known == name).map_or(ViewKind::Driver, |(_, kind)| *kind)
}

/// Writes a picture as PNG, readable by the user only; replaces a file of this name.
pub(super) fn save(picture: &RgbaImage, file: &Path) -> Result<(), CliError> {
    let failed = |why: &dyn std::fmt::Display| CliError::Failed(format!("{}: {why}", file.display()));
    let mut bytes = Vec::new();
    picture.write_to(&mut Cursor::new(&mut bytes), ImageFormat::Png).map_err(|error| failed(&error))?;
    private::replace(file, &bytes).map_err(|error| failed(&error))
}

pub(super) fn main(matches: &ArgMatches) -> Result<(), CliError> {
    let mut scenario = flags::scenario(matches)?;
    let at_s = matches.get_one::<f64>("at").copied().unwrap_or_default();
    if !(0.0..=604_800.0).contains(&at_s) {
        return Err(CliError::Input(format!("--at is {at_s}; allowed: a number from 0 to 604800 s")));
    }
    let (Some(out), Some(&size)) = (matches.get_one::<PathBuf>("out"), matches.get_one::<[u32; 2]>("size")) else {
        return Ok(());
    };
    let kind = view_kind(matches.get_one::<String>("view").map_or("driver", String::as_str));
    // The picture may lie after the end of the scenario's drive.
    scenario.duration_s = 0.0;
    let planned = flags::planned(matches, &scenario)?;
    let (map, on_thread) = (Arc::clone(planned.map()), scenario.clone());
    // The world starts meanwhile.
    let pictures = std::thread::spawn(move || DrivePictures::new(&map, &on_thread));
    let mut run = OfflineDrive::of(planned, [0.0, f64::INFINITY])?;
    run.until(at_s)?;
    let mut pictures = pictures.join().expect("preparing pictures does not panic").map_err(RunError::from)?;
    let world = run.world();
    let picture = pictures.draw(world, kind, size).map_err(RunError::from)?;
    save(&picture, out)?;
    out::line(format_args!("{}: {}x{}, {} at {:.2} s", out.display(), size[0], size[1], scenario.map, world.time_s()))?;
    Ok(())
}
