//! Legends and colour keys below the field of a chart. In: lines with names, or a key to colours. Out: SVG, in as many columns
//! as have room for the longest name.

use super::{
    chart::{LineStyle, PlotLine},
    shape::ColourKey,
    text::{LINE, SIZE, escaped, width, wrapped},
};
use std::fmt::Write;

/// Opacity of the bands of intervals, 0 to 1.
pub(super) const BAND: f64 = 0.18;
/// Distance from the start of an entry to its name, units of the picture.
const SAMPLE: f64 = 32.0;

/// Legend entries in rows; names wider than a column are broken into lines.
pub(super) struct Legend<'a> {
    rows: Vec<Vec<(&'a PlotLine, Vec<String>)>>,
    column: f64,
}

impl<'a> Legend<'a> {
    pub fn of(named: Vec<&'a PlotLine>, field: f64) -> Self {
        let longest = named.iter().map(|line| width(&line.name, SIZE)).fold(0.0, f64::max);
        let columns = ((field / (longest + SAMPLE + 14.0)) as usize).clamp(1, named.len().max(1));
        let column = field / columns as f64;
        let entry = |line: &&'a PlotLine| (*line, wrapped(&line.name, column - SAMPLE, SIZE));
        Self { rows: named.chunks(columns).map(|row| row.iter().map(entry).collect()).collect(), column }
    }

    fn row_height(row: &[(&PlotLine, Vec<String>)]) -> f64 {
        2.5 + LINE * row.iter().map(|entry| entry.1.len()).max().unwrap_or(0) as f64
    }

    pub fn height(&self) -> f64 {
        self.rows.iter().map(|row| Self::row_height(row)).sum::<f64>() + if self.rows.is_empty() { 0.0 } else { 4.0 }
    }

    /// Draws the legend from this height below the upper edge of the field.
    pub fn draw(&self, out: &mut String, from: f64) {
        let mut y = from + 8.0;
        for row in &self.rows {
            for (k, (line, words)) in row.iter().enumerate() {
                entry(out, line, words, [k as f64 * self.column, y]);
            }
            y += Self::row_height(row);
        }
    }
}

fn entry(out: &mut String, line: &PlotLine, words: &[String], [x, y]: [f64; 2]) {
    let LineStyle { colour, width, dash, dots } = line.style;
    let dash = if dash.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dash}\"") };
    if !line.band.is_empty() {
        let top = y - 5.0;
        let _ = write!(
            out,
            "<rect x=\"{x:.1}\" y=\"{top:.1}\" width=\"26\" height=\"10\" fill=\"{colour}\" opacity=\"{BAND}\"/>"
        );
    }
    let _ = write!(out, "<path d=\"M{x:.1} {y:.1}h26\" stroke=\"{colour}\" stroke-width=\"{width}\"{dash}/>");
    if dots {
        let _ = write!(out, "<circle cx=\"{:.1}\" cy=\"{y:.1}\" r=\"2.8\" fill=\"{colour}\"/>", x + 13.0);
    }
    for (i, words) in words.iter().enumerate() {
        let at = [x + SAMPLE, y + 4.0 + LINE * i as f64];
        let _ = writeln!(out, "<text x=\"{:.1}\" y=\"{:.1}\">{}</text>", at[0], at[1], escaped(words));
    }
}

/// Returns the height of a key to colours in this room, units of the picture.
pub(super) fn key_height(key: &ColourKey, room: f64) -> f64 {
    32.0 + LINE * wrapped(&key.label, room, SIZE).len() as f64
}

/// Draws the key to colours from this place on: its label, patches, and the number where each begins.
pub(super) fn key(out: &mut String, key: &ColourKey, [left, top]: [f64; 2], room: f64) {
    let mut y = top + 14.0;
    for line in wrapped(&key.label, room, SIZE) {
        let _ = writeln!(out, "<text x=\"{left:.1}\" y=\"{y:.1}\">{}</text>", escaped(&line));
        y += LINE;
    }
    let patch = (room / key.colours.len() as f64).min(46.0);
    for (i, (colour, edge)) in key.colours.iter().zip(key.edges()).enumerate() {
        let x = left + patch * i as f64;
        let _ = writeln!(
            out,
            "<rect x=\"{x:.1}\" y=\"{:.1}\" width=\"{patch:.1}\" height=\"9\" fill=\"{colour}\"/>\
             <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{edge}</text>",
            y - 8.0,
            y + 13.0
        );
    }
}
