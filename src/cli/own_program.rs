//! Command that starts the program again, for drives in processes of their own: SUMO runs once in a process. In: the folder of data that a person
//! named. Out: a command.

use crate::data_folders;
use std::{env, io, process::Command};

/// Returns this program as a command of its own, with the same folder of data.
pub(super) fn own_program() -> io::Result<Command> {
    let mut command = Command::new(env::current_exe()?);
    if let Some(folder) = data_folders::given() {
        command.arg("--data").arg(folder);
    }
    Ok(command)
}
