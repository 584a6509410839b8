//! Page for screen and print. In: headings, paragraphs, figures and tables. Out: HTML with figures and tables numbered in
//! order, with captions, and a style that keeps them whole on paper.

use crate::plot::{escaped, minus};
use std::fmt::Write;

/// Style sheet. A sheet of A4 leaves 183 mm between its margins: one figure of page width, or two of column width.
pub(super) const STYLE: &str = "\
:root{color-scheme:light}\
body{font:15px/1.5 Helvetica,Arial,sans-serif;color:#222;background:#fff;max-width:192mm;margin:2em auto;padding:0 1.5em}\
h1{font-size:1.7em;line-height:1.2;margin-bottom:.3em}\
h2{font-size:1.3em;margin-top:2em;border-bottom:1px solid #ccc}\
h3{font-size:1.05em;margin:1.4em 0 .4em}\
table{border-collapse:collapse;font-size:12.5px;margin:1em 0;width:100%}\
caption,figcaption{font-size:13px;line-height:1.4;text-align:left;padding:.3em 0}\
th,td{padding:.25em .6em;border-bottom:1px solid #ddd;text-align:right;vertical-align:top}\
th{border-bottom:1.5px solid #555;vertical-align:bottom}\
td:first-child,th:first-child,td.t,th.t{text-align:left}\
figure{margin:0 0 1.2em;break-inside:avoid}\
figure.column{display:inline-block;width:89mm;margin-right:4mm;vertical-align:top}\
svg{max-width:100%;height:auto;display:block}\
a{color:inherit}\
.note{color:#444;font-size:13px}.warning{color:#a00}\
code{font-size:.95em}\
@page{size:A4;margin:15mm 13mm}\
@media print{\
body{font-size:9.5pt;max-width:none;margin:0;padding:0}\
table{font-size:7.5pt}caption,figcaption,.note{font-size:8pt}\
h1,h2,h3,caption{break-after:avoid}\
.lead{break-after:avoid}\
figure,tr,.whole{break-inside:avoid}\
figure.column{margin-right:1mm}\
figure.column figcaption{padding-right:5mm}\
thead{display:table-header-group}\
p{orphans:3;widows:3}\
a{text-decoration:none}}";

/// Largest number of rows of a table that is kept whole on a sheet.
const WHOLE: usize = 24;

/// A page under construction, and its figures by file name.
#[derive(Default)]
pub(super) struct ReportPage {
    pub html: String,
    pub figures: Vec<(String, String)>,
    tables: usize,
}

/// A figure with its caption.
pub(super) struct ReportFigure {
    /// File name without its ending.
    pub name: String,
    pub svg: String,
    /// Caption, text without markup.
    pub caption: String,
}

/// Cells of a head or a row. Columns are numbers, aligned right, except the first and those named as texts.
pub(super) type TableCells = Vec<String>;

impl ReportPage {
    /// Starts a page with its title as heading.
    pub fn titled(title: &str) -> Self {
        let mut page = Self::default();
        page.put(&format!(
            "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}</title><style>{STYLE}</style></head>\
             <body>\n<h1>{0}</h1>",
            escaped(title)
        ));
        page
    }

    /// Appends markup unchanged, and a line break.
    pub fn put(&mut self, text: &str) {
        self.html.push_str(text);
        self.html.push('\n');
    }

    /// Appends a paragraph of text with markup.
    pub fn paragraph(&mut self, class: &str, html: &str) {
        self.put(&format!("<p class=\"{class}\">{html}</p>"));
    }

    /// Returns links to `count` figures, starting `ahead` figures after the next one: `Figure 3`, `Figures 3 and 4`, `Figures 3
    /// to 9`.
    pub fn figure_links(&self, ahead: usize, count: usize) -> String {
        links("figure", "Figure", self.figures.len() + 1 + ahead, count)
    }

    /// Returns links to the next `count` tables.
    pub fn table_links(&self, count: usize) -> String {
        links("table", "Table", self.tables + 1, count)
    }

    /// Appends a figure with the next number.
    pub fn figure(&mut self, figure: ReportFigure) {
        let ReportFigure { name, svg, caption } = figure;
        // Ids within a picture are made unique on the page.
        let n = self.figures.len();
        let inline = svg.replace("id=\"f", &format!("id=\"p{n}f")).replace("url(#f", &format!("url(#p{n}f"));
        let class = if svg.contains("width=\"89mm\"") { "column" } else { "page" };
        let _ = writeln!(
            self.html,
            "<figure id=\"figure-{0}\" class=\"{class}\">\n{inline}<figcaption><b>Figure {0}.</b> {1}</figcaption>\n</figure>",
            n + 1,
            escaped(&caption)
        );
        self.figures.push((format!("{name}.svg"), svg));
    }

    /// Appends a table with the next number; all columns but the first and `texts` are numbers. Cells are texts without markup.
    pub fn table(&mut self, caption: &str, head: &TableCells, rows: &[TableCells], texts: &[usize]) {
        let plain = |cell: &String| escaped(cell);
        self.marked_table(
            caption,
            &head.iter().map(plain).collect(),
            &rows.iter().map(|row| row.iter().map(plain).collect()).collect::<Vec<_>>(),
            texts,
        );
    }

    /// Appends a table with cells of markup, else as [`Self::table`].
    pub fn marked_table(&mut self, caption: &str, head: &TableCells, rows: &[TableCells], texts: &[usize]) {
        self.tables += 1;
        let class = if rows.len() <= WHOLE { " class=\"whole\"" } else { "" };
        let row = |cells: &TableCells, tag: &str| {
            let cell = |(i, cell): (usize, &String)| {
                let class = if texts.contains(&i) { " class=\"t\"" } else { "" };
                format!("<{tag}{class}>{cell}</{tag}>")
            };
            format!("<tr>{}</tr>", cells.iter().enumerate().map(cell).collect::<String>())
        };
        let body: Vec<String> = rows.iter().map(|cells| row(cells, "td")).collect();
        let _ = writeln!(
            self.html,
            "<table id=\"table-{0}\"{class}><caption><b>Table {0}.</b> {1}</caption>\n<thead>{2}</thead>\n<tbody>\n{3}\n</tbody></table>",
            self.tables,
            escaped(caption),
            row(head, "th"),
            body.join("\n")
        );
    }
}

fn links(kind: &str, name: &str, first: usize, count: usize) -> String {
    let link = |n: usize, words: &str| format!("<a href=\"#{kind}-{n}\">{words}</a>");
    let last = first + count.max(1) - 1;
    match count {
        0 | 1 => link(first, &format!("{name} {first}")),
        2 => format!("{} and {}", link(first, &format!("{name}s {first}")), link(last, &last.to_string())),
        _ => format!("{} to {}", link(first, &format!("{name}s {first}")), link(last, &last.to_string())),
    }
}

/// Formats a number with three significant digits and a true minus sign; below 1, with three decimals.
pub(super) fn short(value: f64) -> String {
    let text = match value.abs() {
        v if v >= 100.0 => format!("{value:.0}"),
        v if v >= 10.0 => format!("{value:.1}"),
        v if v >= 1.0 => format!("{value:.2}"),
        _ => format!("{value:.3}"),
    };
    if text.trim_start_matches('-').chars().all(|c| "0.".contains(c)) { "0".into() } else { minus(&text) }
}
