//! Progress of commands. In: the number of steps, a message. Out: a bar on the terminal.

use super::out;
use indicatif::{ProgressBar, ProgressStyle};

/// Returns a progress bar of `length` steps; it stays silent without a terminal.
pub(super) fn progress(length: u64, message: String) -> ProgressBar {
    let style = ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}  {eta} left");
    let bar = ProgressBar::new(length).with_message(out::visible(&message).into_owned());
    bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_in_a_progress_message_are_escaped() {
        assert_eq!(progress(1, "what if \u{1b}[2J".into()).message(), "what if \\u001b[2J");
    }
}
