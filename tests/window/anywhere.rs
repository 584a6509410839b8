//! Test of the program file alone in a window. In: a copy in a folder with spaces and umlauts, started from another folder without a home.
//! Out: the ring that the program file carries is drawn.

use crate::xserver::{Server, ended, wait_for};
use std::{fs, process::Command};

#[test]
fn the_file_alone_opens_its_window_and_draws_its_ring() {
    let folder = tempfile::Builder::new().prefix("Über Räder und Straßen ").tempdir().unwrap();
    let [bin, work, tmp] = ["bin", "work", "tmp"].map(|name| folder.path().join(name));
    for folder in [&bin, &work, &tmp] {
        fs::create_dir(folder).unwrap();
    }
    let (built, program) = (env!("CARGO_BIN_EXE_codrive"), bin.join("codrive"));
    fs::hard_link(built, &program).or_else(|_| fs::copy(built, &program).map(drop)).unwrap();
    let server = Server::start([640, 400]);
    let mut command = Command::new(&program);
    command.env_clear().env("TMPDIR", &tmp).current_dir(&work);
    command.args(["drive", "--traffic", "native", "--quality", "low", "--duration", "0", "--out", "übung"]);
    let drive = server.start_program(&mut command);
    let window = server.window("codrive");
    wait_for("a picture", || (server.colours() > 200).then_some(()));
    server.close(window);
    let (code, text) = ended(drive);
    assert_eq!(code, 0, "{text}");
    assert!(text.contains("policy ring-250-speed (auto") && work.join("übung/manifest.json").is_file(), "{text}");
}
