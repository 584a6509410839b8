//! Output of the commands. In: text. Out: the standard output, or why it takes nothing; asides on the standard error, which
//! nobody needs to take.

use super::CliError;
use std::{
    fmt::{Arguments, Display},
    io::{self, ErrorKind, Write},
};

/// Says a line on the standard output.
pub(super) fn line(text: Arguments<'_>) -> Result<(), CliError> {
    all(format_args!("{text}\n"))
}

/// Says a text that ends its own lines.
pub(super) fn text(text: impl Display) -> Result<(), CliError> {
    all(format_args!("{text}"))
}

fn all(text: Arguments<'_>) -> Result<(), CliError> {
    let mut out = io::stdout().lock();
    out.write_fmt(text).and_then(|()| out.flush()).map_err(|error| fault(&error))
}

/// What it means that the standard output takes no more.
pub(super) fn fault(error: &io::Error) -> CliError {
    match error.kind() {
        ErrorKind::BrokenPipe => CliError::Unread,
        _ => CliError::Failed(format!(
            "the standard output cannot be written: {error}\n  remedy: make room where it goes, or let it go elsewhere; \
             files that were asked for are written all the same"
        )),
    }
}

/// Says a line on the standard error: a word beside the work, which goes on if nobody can read it.
pub(super) fn status_line(text: impl Display) {
    let _ = writeln!(io::stderr(), "{text}");
}
