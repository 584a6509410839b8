//! Pictures, videos and sound that `codrive replay` makes from a recording. A script in place of ffmpeg records its arguments and the
//! number of picture bytes.

use codrive::record::{Table, TableReader};
use std::{
    fs,
    os::unix::fs::PermissionsExt,
    path::{Path, PathBuf},
    process::{Command, Output},
};

/// Script in place of ffmpeg: records its arguments, counts the picture bytes and creates its last argument. With a file "fails" beside it,
/// it fails at once; with a file "late", after it has read all pictures.
const FFMPEG: &str = r#"#!/bin/sh
here=$(dirname "$0")
[ ! -e "$here/fails" ] || exit 3
echo "$*" >>"$here/arguments"
case "$*" in *rawvideo*) wc -c >>"$here/bytes" ;; esac
[ ! -e "$here/late" ] || exit 4
for last; do :; done
echo film >"$last"
"#;

/// A recorded drive of 2 s in a folder that also takes the results.
struct RecordingFixture {
    folder: tempfile::TempDir,
}

impl RecordingFixture {
    fn recorded() -> Self {
        let place = Self { folder: tempfile::tempdir().unwrap() };
        let drive = place.path("drive");
        let short = ["run", "--traffic", "native", "--vehicles", "4", "--duration", "2", "--trees", "0", "--out"];
        let output = place.codrive(&[&short[..], &[&drive]].concat());
        assert!(output.status.success(), "{}", text(&output));
        fs::create_dir(place.path("bin")).unwrap();
        let ffmpeg = place.path("bin/ffmpeg");
        fs::write(&ffmpeg, FFMPEG).unwrap();
        fs::set_permissions(&ffmpeg, fs::Permissions::from_mode(0o755)).unwrap();
        place
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).into_os_string().into_string().unwrap()
    }

    fn codrive(&self, arguments: &[&str]) -> Output {
        let path = format!("{}:{}", self.path("bin"), std::env::var("PATH").unwrap());
        Command::new(env!("CARGO_BIN_EXE_codrive")).args(arguments).env("PATH", path).output().unwrap()
    }

    /// Replays at 64 by 36 pixels. Returns the exit code and the output.
    fn replay(&self, more: &[&str]) -> (i32, String) {
        let output = self.codrive(&[&["replay", &self.path("drive"), "--size", "64x36"], more].concat());
        (output.status.code().unwrap(), text(&output))
    }

    /// Returns the lines that the script recorded in a file.
    fn kept(&self, name: &str) -> Vec<String> {
        let text = fs::read_to_string(self.folder.path().join("bin").join(name)).unwrap_or_default();
        text.lines().map(|line| line.trim().to_owned()).collect()
    }
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&[&output.stdout[..], &output.stderr[..]].concat()).into_owned()
}

fn pictures(folder: &Path) -> Vec<PathBuf> {
    let mut all: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    all.sort();
    all
}

#[test]
fn a_picture_shows_its_time_and_all_pictures_are_numbered() {
    let place = RecordingFixture::recorded();
    let [png, frames] = ["at.png", "frames"].map(|name| place.path(name));
    let (code, printed) = place.replay(&["--png", &png, "--at", "1", "--frames-dir", &frames, "--rate", "10"]);
    assert!(code == 0 && printed.contains("all 200 ticks are the same to the bit"), "{printed}");
    let all = pictures(Path::new(&frames));
    // Two seconds at ten pictures a second, from 000000.png on.
    let names: Vec<String> = (0..20).map(|i| format!("{i:06}.png")).collect();
    assert_eq!(all.iter().map(|path| path.file_name().unwrap().to_str().unwrap()).collect::<Vec<_>>(), names);
    let open = |path: &Path| image::open(path).unwrap().into_rgba8();
    let at = open(Path::new(&png));
    assert_eq!(at.dimensions(), (64, 36));
    // The tenth picture is drawn after tick 100, as is the picture at 1 s.
    assert!(at == open(&all[9]), "another moment than 1 s");
    assert!(at != open(&all[0]) && at != open(&all[19]), "the car moves");

    // Nothing is overwritten, and a time after the end is named.
    let (code, printed) = place.replay(&["--frames-dir", &frames]);
    assert!(code == 2 && printed.contains("frames"), "{printed}");
    assert_eq!(pictures(Path::new(&frames)).len(), 20);
    let late = place.path("late.png");
    let (code, printed) = place.replay(&["--png", &late, "--at", "2.5"]);
    assert!(code == 2 && printed.contains("--at is 2.5 s, after the end of the recording at 2 s"), "{printed}");
    assert!(!Path::new(&late).exists());
}

#[test]
fn ffmpeg_gets_every_picture_of_a_video_and_joins_the_sound() {
    let place = RecordingFixture::recorded();
    let [film, sound] = ["film.mp4", "drive.wav"].map(|name| place.path(name));
    let (code, printed) = place.replay(&["--video", &film, "--rate", "10"]);
    assert_eq!(code, 0, "{printed}");
    // 20 pictures of 64 by 36 pixels of 4 bytes.
    assert_eq!(place.kept("bytes"), ["184320"]);
    let [asked] = &place.kept("arguments")[..] else { panic!("{:?}", place.kept("arguments")) };
    for part in ["-f rawvideo -pix_fmt rgba -s 64x36 -r 10 -i -", "-pix_fmt yuv420p"] {
        assert!(asked.contains(part), "{asked}");
    }
    assert!(asked.ends_with("film.mp4") && Path::new(&film).exists());
    let (code, printed) = place.replay(&["--video", &film]);
    assert!(code == 2 && printed.contains("film.mp4 exists; nothing is overwritten"), "{printed}");

    let both = place.path("both.mp4");
    let (code, printed) = place.replay(&["--video", &both, "--wav", &sound, "--rate", "5"]);
    assert_eq!(code, 0, "{printed}");
    assert_eq!(place.kept("bytes")[1..], ["92160"]);
    let joined = place.kept("arguments").pop().unwrap();
    assert!(joined.contains("drive.wav") && joined.contains("-c:v copy") && joined.ends_with("both.mp4"), "{joined}");
    let left: Vec<PathBuf> = pictures(place.folder.path());
    assert!(!left.iter().any(|path| path.to_str().unwrap().contains("mute")), "{left:?}");
    // Two seconds of sound at any sample rate.
    let wav = hound::WavReader::open(&sound).unwrap();
    assert_eq!(wav.duration(), 2 * wav.spec().sample_rate);
}

#[test]
fn a_failing_or_missing_ffmpeg_is_reported_and_nothing_is_called_done() {
    let place = RecordingFixture::recorded();
    fs::write(place.path("bin/fails"), "").unwrap();
    let (code, printed) = place.replay(&["--video", &place.path("film.mp4"), "--rate", "5"]);
    assert!(code == 1 && printed.contains("ffmpeg"), "{printed}");
    // This script reads all pictures and then fails, as on a full disk.
    fs::rename(place.path("bin/fails"), place.path("bin/late")).unwrap();
    let (code, printed) = place.replay(&["--video", &place.path("late.mp4"), "--rate", "5"]);
    assert!(
        code == 1 && printed.contains("ffmpeg failed: exit status: 4") && !printed.contains("the same to the bit"),
        "{printed}"
    );
    let none = Command::new(env!("CARGO_BIN_EXE_codrive"))
        .args(["replay", &place.path("drive"), "--size", "64x36", "--video", &place.path("other.mp4")])
        .env("PATH", place.path("nowhere"))
        .output()
        .unwrap();
    let printed = text(&none);
    assert!(none.status.code() == Some(1) && printed.contains("install it, or use --frames-dir"), "{printed}");
}

#[test]
fn the_smallest_gap_of_the_summary_equals_that_of_the_table() {
    let place = RecordingFixture::recorded();
    let summary = fs::read_to_string(place.path("drive/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let gaps = TableReader::parquet(&Table::Ego.parquet(Path::new(&place.path("drive")))).unwrap().numbers("gap_m");
    let least = gaps.into_iter().flatten().fold(f64::INFINITY, f64::min);
    assert!(least.is_finite());
    assert_eq!(summary["min_gap_m"].as_f64(), Some(least));
}
