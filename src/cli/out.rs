//! Output of the commands. In: text, which may come from outside: file names, map titles, messages of servers. Out: lines on
//! the standard output, or the error why it cannot be written; status lines on the standard error, where errors are ignored.
//! Characters that would control the terminal are escaped.

use super::CliError;
use std::{
    borrow::Cow,
    fmt::{Arguments, Display},
    io::{self, ErrorKind, Write},
};

/// Prints a line on the standard output.
pub(super) fn line(text: Arguments<'_>) -> Result<(), CliError> {
    all(format_args!("{text}\n"))
}

/// Prints a text that has its own line ends.
pub(super) fn text(text: impl Display) -> Result<(), CliError> {
    all(format_args!("{text}"))
}

/// Overwrites the current line of the terminal.
#[cfg(feature = "desktop")]
pub(super) fn redrawn(text: impl Display) -> Result<(), CliError> {
    write(&format!("\r\x1b[K{}", visible(&text.to_string())))
}

fn all(text: Arguments<'_>) -> Result<(), CliError> {
    write(&visible(&text.to_string()))
}

fn write(text: &str) -> Result<(), CliError> {
    let mut out = io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).map_err(|error| fault(&error))
}

/// Escapes each character that would control a terminal: control characters except line feed and tab, marks of writing
/// direction, and Unicode line ends. The escapes are those of JSON, such as `\u001b`, so JSON keeps its meaning.
pub fn visible(text: &str) -> Cow<'_, str> {
    if !text.contains(commands_terminal) {
        return text.into();
    }
    let mut plain = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match c {
            c if commands_terminal(c) => plain += &format!("\\u{:04x}", u32::from(c)),
            c => plain.push(c),
        }
    }
    plain.into()
}

fn commands_terminal(c: char) -> bool {
    match c {
        '\n' | '\t' => false,
        '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => true,
        c => c.is_control(),
    }
}

/// Returns the error for a failed write to the standard output.
pub(super) fn fault(error: &io::Error) -> CliError {
    match error.kind() {
        ErrorKind::BrokenPipe => CliError::Unread,
        _ => CliError::Failed(format!(
            "the standard output cannot be written: {error}\n  remedy: make room on its disk, or redirect it; the \
             requested files are written anyway"
        )),
    }
}

/// Prints a line on the standard error; a failed write is ignored.
pub(super) fn status_line(text: impl Display) {
    let _ = writeln!(io::stderr(), "{}", visible(&text.to_string()));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn characters_that_control_a_terminal_are_escaped() {
        assert_eq!(visible("Zürich\t→ 5 m/s²\nשלום"), "Zürich\t→ 5 m/s²\nשלום");
        assert_eq!(visible("a\u{1b}[31mb\r\u{7}\u{7f}\u{9b}2J"), "a\\u001b[31mb\\u000d\\u0007\\u007f\\u009b2J");
        assert_eq!(visible("\u{202e}gpj.\u{2066}x\u{2028}"), "\\u202egpj.\\u2066x\\u2028");
        let json = serde_json::json!({ "title": "\u{1b}]0;x\u{7}\u{9b}\u{202e}" });
        let read: serde_json::Value = serde_json::from_str(&visible(&json.to_string())).unwrap();
        assert_eq!(read, json, "JSON says the same");
    }
}
