//! Report section of the data dictionary. In: analysed drives. Out: the definitions of all columns of the tables.

use super::{glossary, page::ReportPage, words::cells};
use crate::analysis::{columns::ColumnDefinition, drives::AnalysedRecording};
use crate::metrics::registry::unit_text;
use crate::plot::escaped;

/// Adds the definitions of all columns of the tables beside the page.
pub(super) fn dictionary(page: &mut ReportPage, drives: &[AnalysedRecording]) {
    page.put("<section id=\"data-dictionary\">\n<h2>Data dictionary</h2>");
    let tables = glossary::tables(drives);
    page.paragraph(
        "lead",
        &format!(
            "{} define the columns of the tables beside this page; the file columns.json has the same definitions.",
            page.table_links(tables.len())
        ),
    );
    for table in tables {
        let row = |column: &ColumnDefinition| {
            vec![
                escaped(&column.title),
                format!("<code>{}</code>", escaped(&column.name)),
                unit_text(column.unit),
                escaped(&column.about),
            ]
        };
        page.marked_table(
            &format!("Columns of {}, in which a row is {}.", table.file, table.row),
            &cells(["Quantity", "Column", "Unit", "Definition"]),
            &table.columns.iter().map(row).collect::<Vec<_>>(),
            &[1, 2, 3],
        );
    }
    page.put("</section>");
}
