//! Spoken instructions in a session: they start when a page opens, repeat on request, and stop with their page.

use crate::rig::Rig;
use codrive::{
    audio::VoiceStatus,
    session::voice::VoiceOrder,
    study::{FormInput, Study},
};
use std::path::Path;

/// Writes a WAV file of silence with this length, 8 kHz, 16 bits, following the format exactly.
fn wav(path: &Path, seconds: u32) {
    let size = 16_000 * seconds;
    let mut bytes = b"RIFF\0\0\0\0WAVEfmt \x10\0\0\0\x01\0\x01\0\x40\x1f\0\0\x80\x3e\0\0\x02\0\x10\0data".to_vec();
    bytes.extend(size.to_le_bytes());
    bytes.resize(bytes.len() + size as usize, 0);
    std::fs::write(path, bytes).unwrap();
}

/// Returns a study whose welcome and trials are spoken.
fn study(folder: &Path) -> String {
    wav(&folder.join("welcome.wav"), 3);
    wav(&folder.join("trial.wav"), 2);
    let at = |name: &str| folder.join(name).display().to_string();
    format!(
        "title = \"Spoken\"\nparticipants = 2\norder = \"fixed\"\nlanguage = \"en\"\n[base]\ntraffic = \"native\"\nduration_s = 8.0\n\
         [[condition]]\nname = \"a\"\n[[condition]]\nname = \"b\"\n\
         [[segment]]\nkind = \"text\"\nname = \"welcome\"\ntext = \"\"\"# Hello\nDrive safely.\"\"\"\nspoken = '{}'\n\
         [[segment]]\nkind = \"text\"\nname = \"silent\"\ntext = \"Read this.\"\n\
         [[segment]]\nkind = \"trials\"\nname = \"trial\"\ntext = \"Drive.\"\nspoken = {{ en = '{}', de = 'nowhere.wav' }}\n",
        at("welcome.wav"),
        at("trial.wav")
    )
}

fn notes(rig: &Rig) -> Vec<String> {
    rig.log().notes.into_iter().filter(|note| note.kind == "spoken").map(|note| note.text).collect()
}

/// Returns the file of the next voice order, or `stop`.
fn played(rig: &mut Rig) -> Option<String> {
    match rig.live_session().take_voice_order() {
        Some(VoiceOrder::Play(text)) => Some(text.file),
        Some(VoiceOrder::Stop) => Some("stop".into()),
        None => None,
    }
}

fn hears(rig: &mut Rig, status: VoiceStatus) -> Option<String> {
    let warning = rig.live_session().hear_voice(status);
    rig.pass(0.1);
    warning
}

#[test]
fn a_spoken_text_starts_with_its_page_repeats_and_ends_with_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut rig = Rig::of(&study(folder.path()));
    assert!(rig.live_session().is_spoken());
    assert_eq!((played(&mut rig).as_deref(), played(&mut rig)), (Some("welcome.wav"), None));
    hears(&mut rig, VoiceStatus::Opening);
    assert!(notes(&rig).is_empty(), "not heard yet");
    hears(&mut rig, VoiceStatus::Playing);
    hears(&mut rig, VoiceStatus::Playing);
    assert_eq!(notes(&rig), ["welcome.wav began"]);
    // R, and the button that goes back on other pages, repeat the text.
    rig.input(FormInput::Again);
    assert_eq!(played(&mut rig).as_deref(), Some("welcome.wav"));
    hears(&mut rig, VoiceStatus::Playing);
    hears(&mut rig, VoiceStatus::Ended);
    assert_eq!(notes(&rig), ["welcome.wav began", "welcome.wav was cut", "welcome.wav began", "welcome.wav ended"]);
    rig.input(FormInput::Back);
    assert_eq!(played(&mut rig).as_deref(), Some("welcome.wav"));
    hears(&mut rig, VoiceStatus::Playing);
    // The page can be left at once, and the text stops with it.
    rig.next();
    assert_eq!(rig.running(), "silent");
    assert_eq!((played(&mut rig).as_deref(), rig.live_session().is_spoken()), (Some("stop"), false));
    rig.next();
    assert_eq!((rig.running().as_str(), played(&mut rig).as_deref()), ("trial-1-a", Some("trial.wav")));
    assert_eq!(notes(&rig).last().unwrap(), "welcome.wav was cut");
    // Without a sound device the page is silent, the experimenter is warned, and the session goes on.
    let warning = hears(&mut rig, VoiceStatus::Failed("no sound card".into())).unwrap();
    assert_eq!(warning, "trial.wav cannot be played: no sound card; the page shows the same text");
    assert_eq!(notes(&rig).last().unwrap(), "trial.wav cannot be played: no sound card");
    rig.drive_off();
    rig.pass(8.1);
    rig.next();
    // The text of the trials is shown and spoken before the first trial only.
    assert_eq!((rig.running().as_str(), played(&mut rig)), ("trial-2-b", None));
}

#[test]
fn a_request_to_stop_silences_the_voice_and_the_log_has_the_cut() {
    let folder = tempfile::tempdir().unwrap();
    let mut rig = Rig::of(&study(folder.path()));
    played(&mut rig);
    hears(&mut rig, VoiceStatus::Playing);
    rig.input(FormInput::Stop);
    assert_eq!((played(&mut rig).as_deref(), rig.live_session().is_spoken()), (Some("stop"), false));
    rig.pass(0.1);
    assert_eq!(notes(&rig), ["welcome.wav began", "welcome.wav was cut"]);
}

#[test]
fn the_printed_plan_has_each_text_and_its_file_and_mistakes_a_line() {
    let folder = tempfile::tempdir().unwrap();
    let text = study(folder.path());
    let parsed = |text: &str| Study::parse(text.to_owned(), Path::new("spoken.toml")).map_err(|error| error.0);
    let table = parsed(&text).unwrap().table(1);
    for has in [
        "Spoken in welcome: welcome.wav, 3.0 s, 8000 Hz, mono; its text, about 4 s of reading:\n  | # Hello\n  | Drive \
         safely.\n",
        "Spoken in trial: trial.wav, 2.0 s, 8000 Hz, mono; its text",
    ] {
        assert!(table.contains(has), "{table}");
    }
    for (from, to, line, has) in [
        ("language = \"en\"\n", "", 25, "name the spoken language at the top of the file: language"),
        ("language = \"en\"", "language = \"fr\"", 26, "the instructions come in de, en"),
        ("language = \"en\"", "language = \"de\"", 26, "nowhere.wav cannot be read"),
        ("text = \"Drive.\"\n", "", 25, "spoken instructions need `text`"),
        ("language = \"en\"", "record_room = true", 4, "a voice identifies a person"),
    ] {
        let message = parsed(&text.replacen(from, to, 1)).expect_err(to);
        assert!(message.starts_with(&format!("spoken.toml:{line}:")) && message.contains(has), "{message}");
    }
    let consent = "[[segment]]\nkind = \"consent\"\nname = \"consent\"\ntext = \"Your voice is recorded.\"\n[[segment]]\nkind = \"text\"";
    let room = text.replacen("language = \"en\"", "language = \"en\"\nrecord_room = true", 1);
    let room = parsed(&room.replacen("[[segment]]\nkind = \"text\"", consent, 1)).unwrap();
    assert!(room.table(1).contains("The room is recorded during every drive"), "{}", room.table(1));
}
