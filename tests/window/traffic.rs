//! Test of a window whose traffic is starting: it responds while SUMO reads a file.

use crate::{
    keys::{BACKSPACE, ESC},
    xserver::{Server, ended, wait_for},
};
use std::{process::Command, thread::sleep, time::Duration};

#[test]
fn esc_ends_a_window_within_a_second_while_sumo_reads_a_file() {
    let server = Server::start([320, 200]);
    let mut program = server.start_program(
        Command::new(env!("CARGO_BIN_EXE_codrive"))
            .args(["drive", "--quality", "low", "--duration", "0", "--policy", "none", "--map", "ring-250"])
            // Every start of SUMO takes this long, the first one included.
            .env("CODRIVE_SUMO_READS_S", "6"),
    );
    let window = server.window("codrive");
    server.focus(window);
    wait_for("a picture", || (server.colours() > 100).then_some(()));
    for key in [BACKSPACE, ESC] {
        server.key(key, true);
        server.key(key, false);
        sleep(Duration::from_millis(300));
    }
    let is_over = (0..100).any(|_| {
        sleep(Duration::from_millis(10));
        program.try_wait().unwrap().is_some()
    });
    assert!(is_over, "it waits for SUMO");
    let (code, text) = ended(program);
    assert_eq!(code, 0, "{text}");
}
