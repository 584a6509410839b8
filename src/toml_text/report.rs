//! Report of the mistakes of a text. In: places and messages. Out: for each mistake, in the order of lines, file with line and column, the
//! message with its remedy, and the line with a mark below the place.

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use std::{fmt, ops::Range};

/// Largest number of mistakes that a report shows.
pub(super) const MOST_SHOWN: usize = 20;

/// Mistakes of a text, in the order of its lines.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TomlError {
    /// Mistakes that the report shows, the first lines of the text first.
    pub mistakes: Vec<TomlMistake>,
    /// Number of further mistakes.
    pub more: usize,
    /// True if the text was not read to its end because of the number of its mistakes.
    pub is_cut: bool,
}

/// Mistake at a position in a text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TomlMistake {
    /// Name of the text, such as its file.
    pub name: String,
    /// Number of the line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Description of the mistake, with its remedy.
    pub message: String,
    /// Line of the mistake, with a mark under the position.
    pub excerpt: String,
}

impl std::error::Error for TomlError {}

impl fmt::Display for TomlError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, mistake) in self.mistakes.iter().enumerate() {
            write!(f, "{}{mistake}", if i == 0 { "" } else { "\n" })?;
        }
        match (self.more, self.is_cut) {
            (0, false) => Ok(()),
            (0, true) => write!(f, "\nand more"),
            (more, is_cut) => write!(f, "\nand {}{more} more", if is_cut { "at least " } else { "" }),
        }
    }
}

impl fmt::Display for TomlMistake {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, line, column, message, excerpt } = self;
        write!(f, "{name}:{line}:{column}: {message}\n{excerpt}")
    }
}

impl TomlMistake {
    /// Makes the mistake at a span of a text; `name` is the name of the text.
    pub(super) fn new(text: &str, name: &str, span: Range<usize>, message: &str) -> Self {
        let start = text.floor_char_boundary(span.start.min(text.len()));
        let line_start = text[..start].rfind('\n').map_or(0, |i| i + 1);
        let line = text[line_start..].lines().next().unwrap_or_default();
        let number = text[..start].matches('\n').count() + 1;
        let at = (start - line_start).min(line.len());
        let end = line.floor_char_boundary(span.end.saturating_sub(line_start).min(line.len())).max(at);
        let snippet = Snippet::source(line).line_start(number);
        let marked = snippet.annotation(AnnotationKind::Primary.span(at..end));
        let excerpt = Renderer::plain().render(&[Group::with_level(Level::ERROR).element(marked)]);
        Self {
            name: name.into(),
            line: number,
            column: line[..at].chars().count() + 1,
            message: message.into(),
            excerpt,
        }
    }
}
