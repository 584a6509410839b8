//! Columns of tables. In: name, quantity, unit and definition of each column, as its table declares them. Out: heads and lines
//! of CSV, and the definitions for the data dictionary.

use serde_json::{Value, json};

/// A column of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnDefinition {
    /// Column name in the table.
    pub name: String,
    /// Quantity in words, without its unit.
    pub title: String,
    /// Unit in ASCII; empty without a unit.
    pub unit: &'static str,
    /// Definition, without the name.
    pub about: String,
}

impl ColumnDefinition {
    /// Returns the name, and the definition with the keys of BIDS.
    pub(crate) fn entry(self) -> (String, Value) {
        let mut about = json!({ "LongName": self.title, "Description": self.about });
        if !self.unit.is_empty() {
            about["Units"] = self.unit.into();
        }
        (self.name, about)
    }
}

/// A table and its columns, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct TableColumns {
    pub file: &'static str,
    /// Meaning of a row.
    pub row: &'static str,
    pub columns: Vec<ColumnDefinition>,
}

/// Texts of a column: name, quantity, unit, definition.
pub(crate) type ColumnTexts = (&'static str, &'static str, &'static str, &'static str);

pub(crate) fn columns(words: &[ColumnTexts]) -> Vec<ColumnDefinition> {
    let column = |(name, title, unit, about): &ColumnTexts| ColumnDefinition {
        name: (*name).into(),
        title: (*title).into(),
        unit,
        about: (*about).into(),
    };
    words.iter().map(column).collect()
}

impl TableColumns {
    /// Returns the head of the table, a line of CSV.
    pub(crate) fn head(&self) -> String {
        line(self.columns.iter().map(|column| column.name.clone()))
    }
}

/// Formats a finite number; empty for anything else.
pub(crate) fn cell(value: Option<f64>) -> String {
    value.filter(|v| v.is_finite()).map_or(String::new(), |v| v.to_string())
}

/// Returns a cell of CSV in quotes (RFC 4180): a quote within it is doubled.
pub fn quoted_cell(text: &str) -> String {
    format!("\"{}\"", text.replace('"', "\"\""))
}

/// Returns a cell of CSV, in quotes where its text needs them.
pub fn text_cell(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { quoted_cell(text) } else { text.into() }
}

pub(crate) fn line(cells: impl IntoIterator<Item = String>) -> String {
    cells.into_iter().map(|cell| text_cell(&cell)).collect::<Vec<_>>().join(",") + "\n"
}
