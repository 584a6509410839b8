//! Places in a TOML document. In: a parsed document with the span of each key and value. Out: the span of a key, the key at a span; the
//! document without a value, or with another one.

use std::ops::Range;
use toml::{
    Spanned,
    de::{DeString, DeTable, DeValue},
};

/// Part of a key that a fault is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeyPart {
    /// Name of the key.
    Key,
    /// Value of the key.
    Value,
}

/// Keys from the document's root to a value; entries of a list are numbers from 0.
pub(super) type KeyPath = Vec<String>;

/// Value of a document with its span.
pub(super) type Node<'a> = Spanned<DeValue<'a>>;

/// Span of values that are not in the text.
pub(super) const NOWHERE: Range<usize> = usize::MAX - 1..usize::MAX;

/// Parses a text that has no syntax errors; an empty document if it has one.
pub(super) fn document(text: &str) -> Node<'_> {
    DeTable::parse(text).map_or_else(|_| Spanned::new(0..0, DeValue::Table(DeTable::new())), root)
}

/// Returns a document as a value.
pub(super) fn root(table: Spanned<DeTable<'_>>) -> Node<'_> {
    Spanned::new(table.span(), DeValue::Table(table.into_inner()))
}

/// Returns the keys of a path with dots.
pub(super) fn path_of(key: &str) -> KeyPath {
    key.split('.').map(str::to_owned).collect()
}

/// Returns the entries of a table or list, each with its name and the span of its key, if it has one.
fn entries<'n, 'a>(node: &'n Node<'a>) -> Vec<(String, Option<Range<usize>>, &'n Node<'a>)> {
    match node.get_ref() {
        DeValue::Table(table) => {
            table.iter().map(|(key, value)| (key.get_ref().to_string(), Some(key.span()), value)).collect()
        }
        DeValue::Array(list) => list.iter().enumerate().map(|(i, item)| (i.to_string(), None, item)).collect(),
        _ => Vec::new(),
    }
}

/// Returns the entry of a table or list with the span of its key; an entry of a list has none.
fn entry<'n, 'a>(node: &'n Node<'a>, name: &str) -> Option<(Option<Range<usize>>, &'n Node<'a>)> {
    match node.get_ref() {
        DeValue::Table(table) => table.get_key_value(name).map(|(key, value)| (Some(key.span()), value)),
        DeValue::Array(list) => list.get(name.parse::<usize>().ok()?).map(|item| (None, item)),
        _ => None,
    }
}

fn entry_mut<'n, 'a>(node: &'n mut Node<'a>, name: &str) -> Option<&'n mut Node<'a>> {
    match node.get_mut() {
        DeValue::Table(table) => table.get_mut(name),
        DeValue::Array(list) => list.get_mut(name.parse::<usize>().ok()?),
        _ => None,
    }
}

/// Returns the span of a key or its value, and true; or the span of its nearest existing parent, and false.
pub(super) fn span_of(root: &Node<'_>, path: &[String], part: KeyPart) -> (Range<usize>, bool) {
    let (mut node, mut span) = (root, 0..0);
    for name in path {
        let Some((key, value)) = entry(node, name) else { return (span, false) };
        span = key.filter(|_| part == KeyPart::Key).unwrap_or_else(|| value.span());
        node = value;
    }
    (span, true)
}

/// Returns the path of the key or value at a span: an exact match of a key, or else the innermost value around the span; the root if
/// there is none.
pub(super) fn path_at(root: &Node<'_>, span: &Range<usize>) -> KeyPath {
    let mut best: (usize, KeyPath) = (usize::MAX, Vec::new());
    if !span.is_empty() {
        search(root, span, &mut Vec::new(), &mut best);
    }
    best.1
}

fn search(node: &Node<'_>, span: &Range<usize>, path: &mut KeyPath, best: &mut (usize, KeyPath)) {
    for (name, key, value) in entries(node) {
        path.push(name);
        let around = value.span();
        let width = match (key.as_ref() == Some(span), around.start <= span.start && span.end <= around.end) {
            (true, _) => 0,
            (false, true) => around.len().max(1),
            (false, false) => usize::MAX,
        };
        // Of equal spans the innermost is meant: the list of tables `[[segment]]` has the span of its first entry.
        if width < usize::MAX && width <= best.0 {
            *best = (width, path.clone());
        }
        search(value, span, path, best);
        path.pop();
    }
}

/// Removes a key with its value, or an entry of a list; returns true for an entry of a list.
pub(super) fn remove(root: &mut Node<'_>, path: &[String]) -> bool {
    let Some((name, parents)) = path.split_last() else { return false };
    let Some(parent) = parents.iter().try_fold(root, |node, name| entry_mut(node, name)) else { return false };
    match parent.get_mut() {
        DeValue::Table(table) => {
            table.remove(name.as_str());
            false
        }
        DeValue::Array(list) => {
            let gone = name.parse::<usize>().ok();
            let kept = list.iter().enumerate().filter(|(i, _)| Some(*i) != gone).map(|(_, item)| item.clone());
            *list = kept.collect();
            true
        }
        _ => false,
    }
}

/// Puts a value that is not in the text into the table at a path.
pub(super) fn insert<'a>(root: &mut Node<'a>, path: &[String], key: &str, value: DeValue<'a>) {
    let Some(table) = path.iter().try_fold(root, |node, name| entry_mut(node, name)) else { return };
    if let DeValue::Table(table) = table.get_mut() {
        table.insert(Spanned::new(NOWHERE, DeString::Owned(key.to_owned())), Spanned::new(NOWHERE, value));
    }
}

/// Returns the outermost list or table in which an error behind its beginning is: one that was never closed.
pub(super) fn unclosed(root: &Node<'_>, at: usize) -> Option<Range<usize>> {
    entries(root).into_iter().find_map(|(_, _, value)| {
        let span = value.span();
        let is_list = matches!(value.get_ref(), DeValue::Array(_) | DeValue::Table(_)) && span.len() > 1;
        if is_list && span.start < at && at <= span.end { Some(span) } else { unclosed(value, at) }
    })
}
